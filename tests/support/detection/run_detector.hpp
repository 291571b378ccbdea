#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

#include "support/toy_scene.hpp"
#include <mapless/detection/detector.hpp>

namespace mapless::test {

/// Scans `first` to `first + count - 1` of a scene.
inline std::vector<ToyScan> cast_scans(const ToyScene& scene, int first, int count) {
  std::vector<ToyScan> scans;
  for (int i = first; i < first + count; ++i) scans.push_back(cast_scan(scene, i));
  return scans;
}

/// Every scan's detection, in order.
inline std::vector<Detection> detect_all(const std::vector<std::shared_ptr<const LidarScan>>& scans,
                                         const Trajectory& trajectory, const DetectorParameters& parameters) {
  Detector detector(parameters);
  std::vector<Detection> detections;
  for (const auto& scan : scans)
    std::ranges::move(detector.process(scan, trajectory), std::back_inserter(detections));
  std::ranges::move(detector.flush(), std::back_inserter(detections));
  return detections;
}

inline std::vector<std::shared_ptr<const LidarScan>> scans_of(const std::vector<ToyScan>& toy) {
  std::vector<std::shared_ptr<const LidarScan>> scans;
  for (const ToyScan& scan : toy) scans.push_back(scan.scan);
  return scans;
}

/// Points of moving objects, of all the scans.
inline std::size_t moving_points(const std::vector<Detection>& detections) {
  std::ptrdiff_t moving = 0;
  for (const Detection& d : detections)
    moving += std::ranges::count_if(d.object, [](auto object) { return object > 0; });
  return static_cast<std::size_t>(moving);
}

}  // namespace mapless::test
