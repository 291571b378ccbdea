#include "live/transform_buffer.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// Longer than any cloud waits; at 1 kHz, 10,000 poses.
constexpr double kKept_s = 10;
constexpr double kJumpBack_s = 1;
// A tree of a robot has tens of frames; a stream of made-up names does not fill the memory.
constexpr std::size_t kMostFrames = 1000;

// tf names frames with or without it.
std::string without_slash(const std::string& frame) {
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

bool is_rigid(const SE3& T) {
  const Eigen::Matrix3d error = T.rotation() * T.rotation().transpose() - Eigen::Matrix3d::Identity();
  return T.matrix().allFinite() && error.cwiseAbs().maxCoeff() < 1e-3;
}

}  // namespace

void TransformBuffer::add(const std::string& parent, const std::string& child, Time time,
                          const SE3& T_parent_child, bool is_static) {
  if (!is_rigid(T_parent_child)) return;
  const std::string name = without_slash(child);
  if (edges_.size() >= kMostFrames && !edges_.contains(name)) return;
  Edge& edge = edges_[name];
  if (edge.parent != without_slash(parent) || edge.is_static != is_static) edge.poses.clear();
  edge.parent = without_slash(parent);
  edge.is_static = is_static;
  if (is_static) edge.poses.clear();
  if (!edge.poses.empty() && time <= edge.poses.back().time) {
    if ((edge.poses.back().time - time).seconds() < kJumpBack_s) return;
    edge.poses.clear();
  }
  edge.poses.push_back({time, T_parent_child.inverse()});
  while ((edge.poses.back().time - edge.poses.front().time).seconds() > kKept_s) edge.poses.pop_front();
}

// From the frame upwards; empty where it does not lead to the world.
std::vector<const TransformBuffer::Edge*> TransformBuffer::chain(const std::string& frame,
                                                                 const std::string& world) const {
  std::vector<const Edge*> path;
  std::string at = frame;
  while (at != world && path.size() <= edges_.size()) {
    const auto edge = edges_.find(at);
    if (edge == edges_.end()) return {};
    path.push_back(&edge->second);
    at = edge->second.parent;
  }
  return at == world ? path : std::vector<const Edge*>();
}

// T_pf of `frame` f in itself and in each ancestor p that static transforms lead to.
std::map<std::string, SE3> TransformBuffer::fixed_ancestors(const std::string& frame) const {
  std::map<std::string, SE3> found;
  SE3 T_pf;
  std::string at = without_slash(frame);
  while (found.emplace(at, T_pf).second) {
    const auto edge = edges_.find(at);
    if (edge == edges_.end() || !edge->second.is_static) break;
    T_pf = edge->second.poses.front().T_v0.inverse() * T_pf;
    at = edge->second.parent;
  }
  return found;
}

std::optional<SE3> TransformBuffer::fixed(const std::string& a, const std::string& b) const {
  const std::map<std::string, SE3> of_b = fixed_ancestors(b);
  for (const auto& [ancestor, T_pa] : fixed_ancestors(a)) {
    if (const auto T_pb = of_b.find(ancestor); T_pb != of_b.end()) return T_pa.inverse() * T_pb->second;
  }
  return std::nullopt;
}

// The poses around [begin, end]: the last one before it, those within, the first one after.
std::shared_ptr<const Trajectory> TransformBuffer::Edge::trajectory(Time begin, Time end) const {
  const auto later = [](Time t, const TimedPose& pose) { return t < pose.time; };
  const auto first = std::upper_bound(poses.begin(), poses.end(), begin, later) - 1;
  auto last = std::lower_bound(poses.begin(), poses.end(), end,
                               [](const TimedPose& pose, Time t) { return pose.time < t; });
  if (last - first < 1) ++last;
  return std::make_shared<SampledTrajectory>(std::vector<TimedPose>(first, last + 1), Duration(),
                                             "transforms");
}

std::string TransformBuffer::known_edges() const {
  std::vector<std::string> known;
  for (const auto& [child, edge] : edges_) known.push_back(edge.parent + " -> " + child);
  return known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "));
}

TransformBuffer::Lookup TransformBuffer::find(const std::string& frame, const std::string& world, Time begin,
                                              Time end) const {
  if (without_slash(frame) == without_slash(world))
    return {std::make_shared<StationaryTrajectory>(), "", false};
  const auto path = chain(without_slash(frame), without_slash(world));
  if (path.empty()) {
    return {nullptr,
            fmt::format("no transforms lead from frame {} to {}; there are: {}", frame, world, known_edges()),
            false};
  }
  std::vector<std::shared_ptr<const Trajectory>> moving(path.size());
  std::set<Time> times = {begin, end};
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto& poses = path[i]->poses;
    if (path[i]->is_static) continue;
    if (const double missed_s = (poses.front().time - begin).seconds(); missed_s > 0) {
      return {nullptr,
              fmt::format("the poses in frame {} begin {:.3f} s after the cloud", path[i]->parent, missed_s),
              true};
    }
    if (poses.size() < 2 || poses.back().time < end) {
      return {
          nullptr,
          fmt::format("the poses in frame {} do not cover the cloud: the newest is {:.3f} s before its end",
                      path[i]->parent, (end - poses.back().time).seconds()),
          false};
    }
    for (const TimedPose& pose : poses) {
      if (pose.time > begin && pose.time < end) times.insert(pose.time);
    }
    moving[i] = path[i]->trajectory(begin, end);
  }
  std::vector<TimedPose> joined;
  for (const Time time : times) {
    SE3 T_v0;
    for (std::size_t i = 0; i < path.size(); ++i)
      T_v0 = T_v0 * (moving[i] ? moving[i]->at(time).T_v0 : path[i]->poses.front().T_v0);
    joined.push_back({time, T_v0.normalized()});
  }
  return {std::make_shared<SampledTrajectory>(std::move(joined), Duration(), "transforms"), "", false};
}

}  // namespace mapless
