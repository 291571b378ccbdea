#include <utility>

#include <mapless/live/live_options.hpp>

namespace mapless::inline v1 {

std::vector<LiveSetting> live_settings(LiveOptions& options) {
  return {{"sensor", &options.sensor_name,
           "name of the sensor or its calibration file; empty: recovered from the first clouds"},
          {"world_frame", &options.world_frame,
           "frame of objects and odometry; with motion tf, the frame that poses are in"},
          {"base_frame", &options.base_frame,
           "own odometry is of this frame, which tf_static places on the lidar (base_link); empty: of the "
           "clouds' frame"},
          {"static_map_file", &options.static_map_file,
           "file that service save_static_map writes the still points of the run to (.pcd, .ply or .las), "
           "one for each voxel; empty: none are kept"}};
}

std::vector<ParameterReference> live_parameters(LiveOptions& options) {
  std::vector<ParameterReference> all = parameter_references(options.live);
  for (ParameterReference& parameter : parameter_references(options.detector.detection))
    all.push_back(std::move(parameter));
  for (ParameterReference& parameter : parameter_references(options.detector.odometry)) {
    parameter.key = "odometry." + parameter.key;
    all.push_back(std::move(parameter));
  }
  return all;
}

}  // namespace mapless
