#pragma once

#include <cstdint>
#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/tracking/motion_classifier.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// Whether the velocity of an object differs from zero by at least 3 standard deviations: what stands and is
/// called dynamic must not have its surroundings follow.
[[nodiscard]] bool surely_moves(const TrackedObject& object);

/// How far from an object parts of its body may be. The part that is seen is not much smaller than the rest.
/// Chosen: more than this from a lorry is the next lane.
inline constexpr float kMaxBodyReach_m = 1.5F;

/// Points beside a dynamic object that surely moves which belong to its
/// body: windows, bars and occluders part the points of one body, and a part of few points is proposed alone,
/// as static, or not at all.
///
/// A point is taken if its votes are at least those of one scan that saw through it, if it lies within the
/// radius of the object, at most 1.5 m, of one of its points, and if it is in no proposed object or in one
/// that is static for want of evidence alone. Of several objects the one with the nearest point has it.
///
/// `object`: number of the proposed object of each point; changed for the points taken. `motions`: by number
/// - 1. Returns the points taken, increasing. Nothing of it reaches tracking or later scans, so that no error
/// grows.
std::vector<std::uint32_t> complete_bodies(const LocalPoints& points, const std::vector<PointEvidence>& votes,
                                           const std::vector<TrackedObject>& tracked,
                                           const std::vector<TrackMotion>& motions,
                                           std::vector<std::uint16_t>& object);

}  // namespace mapless
