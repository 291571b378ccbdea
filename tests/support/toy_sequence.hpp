#pragma once

#include <filesystem>

#include "io/formats/native/native_writer.hpp"
#include "support/toy_scene.hpp"

namespace mapless::test {

/// Writes the first `scans` scans of a scene with truth and trajectory as a native sequence.
inline void write_toy_sequence(const ToyScene& scene, int scans, const std::filesystem::path& folder) {
  NativeWriter writer(folder, *scene.model);
  std::vector<TimedPose> poses;
  for (int k = 0; k < scans; ++k) {
    const ToyScan scan = cast_scan(scene, k);
    writer.add_scan(scan.scan->start, scan.records, scan.labels);
    poses.push_back({scan.scan->start, scene.trajectory->at(scan.scan->start).T_v0});
    if (k + 1 == scans) poses.push_back({scan.scan->end(), scene.trajectory->at(scan.scan->end()).T_v0});
  }
  writer.finish(poses);
}

}  // namespace mapless::test
