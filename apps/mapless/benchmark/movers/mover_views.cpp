#include "benchmark/movers/mover_views.hpp"

#include <algorithm>

#include <mapless/io/labels.hpp>

namespace mapless::app {
namespace {

struct MovingPoints {
  std::vector<std::size_t> returns;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
};

std::map<std::uint32_t, MovingPoints> moving_objects(const LidarScan& scan,
                                                     std::span<const std::uint32_t> truth) {
  std::map<std::uint32_t, MovingPoints> objects;
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const std::uint32_t label = truth[scan.returns[i].input_index];
    if (label >> 16 == 0 || motion_of_label(label) != MotionTruth::moving) continue;
    MovingPoints& object = objects[label >> 16];
    object.returns.push_back(i);
    object.sum += scan.returns[i].position_v;
  }
  return objects;
}

MoverView view_of(const Detection& detection, std::span<const std::uint32_t> truth,
                  const MovingPoints& moving) {
  const auto& returns = detection.scan->returns;
  MoverView view;
  view.moving_points = moving.returns.size();
  view.centre_v = moving.sum / static_cast<float>(view.moving_points);
  for (const std::size_t i : moving.returns) {
    view.radius_m = std::max(view.radius_m, (returns[i].position_v - view.centre_v).norm());
    view.found_points += detection.dynamic(i) ? 1 : 0;
  }
  for (std::size_t i = 0; i < returns.size(); ++i) {
    if ((returns[i].position_v - view.centre_v).norm() > view.radius_m + MoverView::kSurroundings) continue;
    const MotionTruth motion = motion_of_label(truth[returns[i].input_index]);
    view.points.push_back({returns[i].position_v, motion == MotionTruth::moving,
                           motion != MotionTruth::unknown, detection.dynamic(i), detection.trace[i]});
  }
  return view;
}

}  // namespace

void MoverViews::add(std::size_t scan, const Detection& detection, std::span<const std::uint32_t> truth) {
  for (const auto& [id, moving] : moving_objects(*detection.scan, truth)) {
    const std::size_t count = moving.returns.size();
    if (count < kFewestPoints || (moving.sum / static_cast<float>(count)).norm() < kNearest) continue;
    const auto known = views_.find(id);
    if (known != views_.end() && count <= known->second.moving_points) continue;
    MoverView view = view_of(detection, truth, moving);
    view.object_id = id;
    view.scan = scan;
    views_.insert_or_assign(id, std::move(view));
  }
}

std::vector<const MoverView*> choose_for_gallery(const std::map<std::uint32_t, MoverView>& views,
                                                 const std::map<std::uint32_t, std::string>& classes,
                                                 std::size_t count) {
  std::map<std::string, std::vector<const MoverView*>> by_class;
  for (const auto& [id, view] : views) {
    const auto found = classes.find(id);
    by_class[found == classes.end() ? "" : found->second].push_back(&view);
  }
  std::size_t most = 0;
  for (auto& [name, of_class] : by_class) {
    std::stable_sort(of_class.begin(), of_class.end(), [](const MoverView* a, const MoverView* b) {
      return a->moving_points > b->moving_points;
    });
    most = std::max(most, of_class.size());
  }
  std::vector<const MoverView*> chosen;
  for (std::size_t rank = 0; rank < most; ++rank) {  // the first of every class, then the second ...
    for (const auto& [name, of_class] : by_class) {
      if (rank < of_class.size() && chosen.size() < count) chosen.push_back(of_class[rank]);
    }
  }
  return chosen;
}

}  // namespace mapless::app
