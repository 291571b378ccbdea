#include <chrono>
#include <exception>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include <mapless/live/live_detector.hpp>

namespace mapless::inline v1 {
namespace {

// The folder that a node runs in is not what its users see.
std::string absolute(const std::string& file) {
  return file.empty() ? file : std::filesystem::absolute(file).string();
}

// With poses given, the world is theirs; that of the own odometry is known once the body is.
bool is_in_world(const LiveOutput& output) {
  return output.labelled.detection.motion_known && (!output.labelled.odometry || output.body_known);
}

}  // namespace

StaticMap::StaticMap(const LiveOptions& options)
    : file_(absolute(options.static_map_file)),
      voxel_m_(options.live.static_map_voxel_m),
      max_voxels_(static_cast<std::size_t>(options.live.static_map_max_voxels)) {}

void StaticMap::add(const LiveOutput& output) {
  if (file_.empty() || !is_in_world(output)) return;
  const Detection& detection = output.labelled.detection;
  const CompensatedScan scan = compensate(detection.scan, *output.labelled.trajectory);
  const std::lock_guard lock(mutex_);
  const bool restarted = map_ && world_number_ != output.world_number;
  if (!map_ || restarted) {
    map_.emplace(voxel_m_, max_voxels_);
    world_number_ = output.world_number;
    clouds_ = left_out_ = 0;
    if (restarted) ++restarts_;
  }
  for (std::size_t i = 0; i < scan.points_0.size(); ++i) {
    if (!detection.dynamic(i) && !map_->add(output.T_w0 * scan.points_0[i])) ++left_out_;
  }
  ++clouds_;
}

void StaticMap::clear() {
  const std::lock_guard lock(mutex_);
  map_.reset();
  restarts_ = 0;
}

StaticMap::Answer StaticMap::save(const Write& write) const try {
  if (file_.empty()) return {false, "no map is kept: set static_map_file"};
  ExportCloud cloud;
  std::string message;
  {
    const std::lock_guard lock(mutex_);
    if (!map_ || map_->size() == 0)
      return {false, "no cloud with labels and a known motion yet: see the diagnostics"};
    cloud = map_->cloud();
    message =
        fmt::format("{}: {} points (at most {}), one for each voxel of {:g} m with still points of {} clouds",
                    file_, map_->size(), max_voxels_, voxel_m_, clouds_);
    if (restarts_ > 0)
      message +=
          fmt::format("; earlier clouds are left out: the own odometry began anew {} times", restarts_);
    if (left_out_ > 0)
      message += fmt::format(
          "; the map is full, {} points are left out: raise static_map_voxel_m or static_map_max_voxels",
          left_out_);
  }
  write(file_, cloud);
  return {true, std::move(message)};
} catch (const std::exception& error) {
  return {false, error.what()};
}

void StaticMap::save_aside(Write write, std::function<void(const Answer&)> reply) {
  if (saving_.valid() && saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    reply({false, "the map is being written: wait for the reply to the request before"});
    return;
  }
  saving_ = std::async(std::launch::async,
                       [this, write = std::move(write), reply = std::move(reply)] { reply(save(write)); });
}

}  // namespace mapless
