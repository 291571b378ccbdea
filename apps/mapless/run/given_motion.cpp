#include "run/given_motion.hpp"

#include <string>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

bool needs_odometry(const Dataset& dataset, const TrajectoryRequest& request, std::size_t first) {
  if (request.stationary || !request.file.empty() || dataset.trajectory() != nullptr) return false;
  // A compensated scan needs the poses it was compensated with; open_trajectory says so.
  return !dataset.read(first).compensated_to;
}

TrajectorySource estimated() { return {nullptr, {{"source", std::string(kEstimatedMotion)}}}; }

}  // namespace

TrajectorySource given_motion(const Dataset& dataset, const TrajectoryRequest& request, std::size_t first) {
  return needs_odometry(dataset, request, first) ? estimated() : open_trajectory(dataset, request);
}

TrajectorySource motion_by_odometry(const Dataset& dataset, std::size_t first) {
  if (!dataset.read(first).compensated_to) return estimated();
  throw InputError({dataset.scan_file(first).string(), "points", "", "compensated for motion already",
                    "odometry needs them as measured: use the poses they were compensated with, the "
                    "recording's own or those of mapless detect --trajectory FILE"});
}

}  // namespace mapless::app
