#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "options/parameter_options.hpp"
#include "reports/json.hpp"
#include <mapless/lidar/lidar_model.hpp>

namespace mapless::app {

/// The settings that determine a simulated recording.
struct RecordingKey {
  std::string scene;
  std::string sensor;         ///< a named model, or the name of a sensor file without extension
  std::string sensor_file;    ///< empty for a named model
  std::string sensor_digest;  ///< of the file's contents
  double range_noise_m = 0.02;
  bool faulty = true;  ///< glass, dark paint and distant ground give faulty returns
  std::uint64_t seed = 1;
  double duration_s = 0;

  auto operator<=>(const RecordingKey&) const = default;

  /// Name of its folder; different keys have different names.
  [[nodiscard]] std::string name() const;
  [[nodiscard]] Json json() const;
  /// Throws InputError for a sensor file that cannot be read.
  [[nodiscard]] LidarModel model() const;
};

/// Where the motion of the sensor within a scan is accounted for (ablations; ablated_motion.hpp).
enum class Compensation { full, not_of_clouds, not_of_rays, none };

/// The part of the page that a run belongs to.
enum class Part { table, sweep, ablation };

/// One run of the detector over a recording, or over the first scans of it.
struct Job {
  Part part = Part::table;
  RecordingKey recording;
  std::string name;  ///< distinguishes the runs of one part and recording; "" for the default method
  DetectorParameters parameters;
  Compensation compensation = Compensation::full;
  bool odometry = false;                   ///< lidar odometry in place of the true poses
  std::optional<std::size_t> first_scans;  ///< number of scans; all if not given
  std::optional<double> threshold_m;       ///< of a sweep
  bool pictures = false;                   ///< draw its movers

  /// Name of its file without extension, unique in a plan.
  [[nodiscard]] std::string stem() const;
  /// All settings that determine its figures.
  [[nodiscard]] Json json() const;
};

struct PlanOptions {
  bool quick = false;
  // Any of these three given: their product, HDL-64E-S2, 0.02 m and all scenes (quick: town1) for the rest.
  std::vector<std::string> scenes, sensors;  // sensors: named models in any case of letters, or sensor files
  std::vector<double> range_noises_m;
  std::vector<std::uint64_t> seeds = {1};
  std::string faulty = "on";  // or "off", for every recording
  std::optional<double> duration_s;
  ParameterOptions parameters;
  bool odometry = false;
};

/// How many scans of a recording the sweep and the ablations use.
[[nodiscard]] std::size_t stretch_scans(const PlanOptions& options);

/// Every run of the benchmark, in the order of the page. Throws ParameterError for an unknown sensor or a
/// noise beyond 0 to 1 m, InputError for a sensor file that cannot be read, and as ParameterOptions::chosen.
[[nodiscard]] std::vector<Job> make_plan(const PlanOptions& options);

/// The parameters with one error threshold, as the paper sweeps it: that of the comparison, and those of the
/// freespace check in the proportion they have to it.
[[nodiscard]] DetectorParameters with_error_threshold(DetectorParameters parameters, double threshold_m);

}  // namespace mapless::app
