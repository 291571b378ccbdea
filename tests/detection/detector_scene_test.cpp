#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "support/detection/run_detector.hpp"
#include "support/toy_scene.hpp"
#include <mapless/detection/detector.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::uint32_t kCrossingCar = 3;  // toy_street's, third of its traffic

struct Counts {
  int true_positive = 0;
  int false_positive = 0;
  int false_negative = 0;

  void operator+=(const Counts& o) {
    true_positive += o.true_positive;
    false_positive += o.false_positive;
    false_negative += o.false_negative;
  }
};

// Counts over the returns of one object and of the still world; object 0 counts all.
Counts count(const Detection& detection, const std::vector<std::uint32_t>& labels, std::uint32_t object) {
  Counts counts;
  for (std::size_t i = 0; i < detection.trace.size(); ++i) {
    const std::uint32_t label = labels[detection.scan->returns[i].input_index];
    const bool moves = motion_of_label(label) == MotionTruth::moving;
    if (moves && object != 0 && (label >> 16) != object) continue;
    const bool found = detection.dynamic(i);
    counts.true_positive += moves && found ? 1 : 0;
    counts.false_positive += !moves && found ? 1 : 0;
    counts.false_negative += moves && !found ? 1 : 0;
  }
  return counts;
}

DetectorParameters published() {
  DetectorParameters parameters;
  parameters.method = DetectionMethod::published;
  parameters.forward_gap = 2;
  return parameters;
}

struct Street {
  Counts car, all;
};

// The street while the car crosses, scans 26 to 30, by a detector that has seen it from scan `first` on.
Street judge_street(const DetectorParameters& parameters, int first) {
  const test::ToyScene street = test::toy_street("HDL-64E-S3");
  const auto scans = test::cast_scans(street, first, 33 - first);
  const auto detections = test::detect_all(test::scans_of(scans), *street.trajectory, parameters);
  EXPECT_EQ(detections.size(), scans.size());
  Street sum;
  for (auto k = static_cast<std::size_t>(26 - first); k + 2 < detections.size(); ++k) {
    EXPECT_EQ(detections[k].sequence_number, k);
    sum.car += count(detections[k], scans[k].labels, kCrossingCar);
    sum.all += count(detections[k], scans[k].labels, 0);
  }
  EXPECT_GT(sum.car.true_positive + sum.car.false_negative, 500);
  return sum;
}

// At 7 m/s the crossing car has left its own length of 4.4 m behind it in 0.63 s: the scans 0.8 s and 1.6 s
// back saw through where it is now, and growth needs one of them only. The lowest 0.2 m of its 1.5 m, less
// the 0.1 m that it stands off the ground, are too near the ground to tell: a fifteenth.
TEST(DetectorOnTheStreet, FindsTheCrossingCarAndLeavesTheStreetAlone) {
  const Street street = judge_street({}, 6);
  EXPECT_GT(street.car.true_positive, 4 * street.car.false_negative);
  EXPECT_GT(street.all.true_positive, 4 * street.all.false_negative);
  EXPECT_GT(street.all.true_positive, 49 * street.all.false_positive);
}

// In the 0.8 s of the scan gap a car at 7 m/s goes 5.6 m and leaves its own length of 4.4 m behind it, so
// that all of it stands where space was free, except what is near other surfaces: the lowest 0.2 to 0.3 m of
// its side (threshold and border radius, less the 0.1 m that it stands off the ground) of 1.5 m, a fifth,
// which growth mostly gives back. That leaves four points in five at least. Of what is called dynamic, nine
// in ten do move.
TEST(DetectorOnTheStreet, FindsTheCrossingCarByTheFiveStepsToo) {
  const Street street = judge_street(published(), 18);
  EXPECT_GT(street.car.true_positive, 4 * street.car.false_negative);
  EXPECT_GT(street.all.true_positive, 9 * street.all.false_positive);
}

// A ray search that ignored the motion within a scan would be 18 degrees off at its end.
TEST(DetectorInTheRoom, CallsNothingDynamicWhateverTheSensorDoes) {
  for (const DetectorParameters& parameters : {DetectorParameters{}, published()}) {
    for (const double yaw_rate : {200 * kDegree, -200 * kDegree}) {
      SCOPED_TRACE(yaw_rate);
      const auto room = test::toy_room("HDL-64E-S3", test::drive(0.5, yaw_rate));
      const auto detections =
          test::detect_all(test::scans_of(test::cast_scans(room, 0, 11)), *room.trajectory, parameters);
      ASSERT_EQ(detections.size(), 11u);
      for (const Detection& d : detections)
        EXPECT_EQ(d.objects, 0) << "scan " << d.sequence_number << ": "
                                << std::count_if(d.object.begin(), d.object.end(),
                                                 [](auto o) { return o != 0; });
    }
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
