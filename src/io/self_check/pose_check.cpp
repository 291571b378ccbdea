#include "io/self_check/pose_check.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "io/self_check/edge_check.hpp"
#include "io/self_check/pose_mistakes.hpp"
#include "io/self_check/pose_pair.hpp"
#include "io/self_check/pose_places.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// Poses are sharp up to this blur: noise of 0.05 m gives 0.04, and a wrong motion of 0.2 m/s, the slowest
// that counts as moving, another 0.05.
constexpr double kSharp_m = 0.08;
// A place contradicts the poses where the registration stands out among its neighbours by this many standard
// deviations, and the poses by less than the second (PosePair::peaks): what is seen has the one motion, and
// not the other. By chance each is 5 in 3 times 10 million, or 1 in 700; points of one object are not
// independent. Where the poses jump, the second is enough for the first. Speeds that differ by less than 1.2
// m/s are not told apart.
constexpr double kStandsOut = 5, kStandsOutNot = 3;
// Poses nearer to the registration than this, where neither has a peak of its own (PosePair::peaks), are on
// the flank of the same one where it is better by so many standard deviations, and half way to it is no
// valley (vehicles beside a slow sensor have peaks of their own). Measured, 516 places of 172 right
// recordings of two simulators: 5.3 at most, and there a valley; poses a tenth too fast or too slow or .1 s
// late, in a town, 7 to 12. Farther away right tilted sensors beside vehicles have 7 (at .84 m) to 9, without
// a valley.
constexpr double kFlank_m = 0.6, kFlankBetter = 6, kValley = -2;
// At any distance: slow poses that are wrong have a peak where motions farther off are still worse. Measured,
// 800 places of 274 right recordings of two simulators: 8.5 at most, but for traffic and what one vehicle
// explains (PosePair::one_sided; up to 14.9); 157 fresh ones: less than 10. Poses in reverse or twice as
// fast, in towns, forests and tunnels: 10 to 16.
constexpr double kFarBetter = 10;
constexpr double kAcross = 0.7;  // cosine of 45 degrees
// A registration that leaves this blur fits nothing: unrelated scans have 0.3 (PosePair::blur_m). A lorry
// that hides nearly all from a tilted sensor had 0.22.
constexpr double kFits_m = 0.2, kUnrelated_m = 0.3;
// A mistake explains where it takes away this share of the difference.
constexpr double kExplained = 0.7;
constexpr std::size_t kFewestPoints = 150;
constexpr double kSharpest_m = 0.01;  // smaller blurs are rounding, in "times sharper"
constexpr std::size_t kNear = 7;      // scans: a pair of scans half a second apart reaches over the jump
// What one vehicle explains (PosePair::one_sided) contradicts nothing where the poses stand out as well, and
// differ from it by more than all motions that they stand out from (PosePair::peaks): two motions are seen.
constexpr double kTwoMotions_m = 2.4;
// A registration that finds the sensor at rest, where the poses say otherwise, is believed where this share
// of the beams end at the same range: a motorway looks the same from metre to metre, and vehicles beside the
// sensor move with it. Elsewhere it is taken for traffic, where no other registration fits and the scans are
// unrelated under the poses, and left out otherwise.
constexpr double kAtRest = 0.85;
// Poses under which points at kLever_m move by less than this are at rest. They are doubtful where this share
// of the beams or less end at the same range. Measured at rest: .85 and more, the least beside trams.
constexpr double kStill_m = 0.1, kLeastAtRest = 0.7;
// Poses that are faster are wrong in any case; high-speed trains are not.
constexpr double kFastest_mps = 150;
// Vehicles fill the view and move along: a registration finds the motion relative to them, which is slower
// than the poses, and backwards where they overtake. Poses that are faster than this (a run), and with which
// the registration is in line, but for this share of it sideways or for rest, and at most to this share, are
// not refused for it, and such places are doubtful only where all are so. What one vehicle explains
// (PosePair::one_sided) is not doubtful where as many places speak for the poses. Forwards: right motorways
// of two simulators have .11 to .21, feet for metres .305. Backwards: vehicles less than 1.45 times as fast
// as the sensor (115 km/h beside 80; measured, .13 to .32); poses that are inverted or reversed have 1.
constexpr double kTraffic_mps = 3, kSideways = 0.2, kTrafficShare = 0.28, kOvertakenShare = 0.45,
                 kLorry_mps = 20;
// Displacement that is rest: this; up to a tenth of that by the poses, but not more than a walk.
constexpr double kRest_m = 0.3, kRestShare = 0.1, kMostRest_m = 1.5;

struct PlaceFinding {
  std::size_t k = 0;             // of its first scan
  double said_m = 0, own_m = 0;  // blur by the poses, by the registration
  double speed_mps = 0;          // by the poses
  bool at_jump = false;
  bool traffic = false;      // the registration may have found vehicles that move along
  bool slower = false;       // it is in line with the poses, and slower by what edges tell apart
  bool one_vehicle = false;  // or one vehicle beside the sensor
  bool stirred = false;      // doubtful because the poses are at rest and what is seen is not: maybe a crowd
  bool supports = false;     // the poses stand out, or are sharp
  Trust trust = Trust::unknown;
  std::shared_ptr<const Place> place;
};

// Velocities to begin the registration of neighbouring scans with: at rest, as the poses say, and, as the
// nearest basin may be that of a wrong motion, the sharpest of some speeds along the sensor's x and y.
std::vector<Vector6d> starts(const PosePair& pair, const std::optional<Vector6d>& said) {
  std::vector<Vector6d> out = {Vector6d::Zero()};
  if (said) out.push_back(*said);
  Vector6d best = Vector6d::Zero();
  double best_m = pair.blur_m(best);
  for (const double speed : {4.0, 8.0, 12.0, 18.0, 25.0, 32.0}) {
    for (int direction = 0; direction < 4; ++direction) {
      Vector6d velocity = Vector6d::Zero();
      velocity[direction / 2] = direction % 2 == 0 ? speed : -speed;
      const double blur = pair.blur_m(velocity);
      if (blur >= best_m) continue;
      best_m = blur;
      best = velocity;
    }
  }
  if (!best.isZero()) out.push_back(best);
  return out;
}

// Of the speed `found` as a part of that of the poses, below 0 where it is backwards; none where the poses
// are slow, or too fast, or the motion found is not in line with them.
std::optional<double> share_in_line(const Vector6d& found, const std::optional<Vector6d>& said,
                                    double apart_s) {
  if (!said) return std::nullopt;
  const Eigen::Vector3d slow = found.head<3>(), fast = said->head<3>();
  if (fast.norm() <= kTraffic_mps || fast.norm() > kFastest_mps) return std::nullopt;
  const double along = slow.dot(fast.normalized()), sideways = slow.cross(fast.normalized()).norm();
  if (sideways >= std::max(kSideways * slow.norm(), kRest_m / apart_s)) return std::nullopt;
  return std::copysign(slow.norm() / fast.norm(), along);
}

bool may_be_traffic(double share, const Vector6d& said) {
  const double ahead = std::max(kTrafficShare, 1 - kLorry_mps / said.head<3>().norm());
  return share > -kOvertakenShare && share < ahead;
}

// Vehicles move along the way of the sensor: what differs across it is the static world.
bool across(const Vector6d& found, const Vector6d& said) {
  const Eigen::Vector3d way = said.head<3>(), difference = found.head<3>() - way;
  return way.norm() > kTraffic_mps &&
         std::abs(difference.dot(way)) < kAcross * difference.norm() * way.norm();
}

// Whether the poses are better than motions a little slower or faster.
bool stand_out(const PosePair& apart, const Motion& said) {
  const auto peaks = apart.peaks(said, Vector6d::Zero());
  return peaks && peaks->said > kStandsOutNot;
}

bool on_flank(const PosePair::Flank& flank, const Vector6d& found, const std::optional<Vector6d>& said) {
  return said && flank.apart_m < kFlank_m && flank.found > kFlankBetter &&
         (flank.half_way > kValley || across(found, *said));
}

struct Registration {
  Vector6d velocity = Vector6d::Zero();
  double blur_m = PosePair::kCap_m;
  bool apparent_rest = false;  // at rest where the sensor can hardly be
};

// The sharpest; one that is apparently at rest only as the last resort.
Registration best_registration(const Place& place, const PosePair& apart, const Motion& said,
                               const PlaceFinding& out) {
  const PosePair neighbours(place.first, place.next);
  const double apart_s = (place.last.start - place.first.start).seconds();
  const double said_m = out.speed_mps * apart_s;
  const double rest_m = std::max(kRest_m, std::min(kMostRest_m, kRestShare * said_m));
  const bool may_rest =
      said_m < kRest_m || said_m > kFastest_mps * apart_s || apart.equal_share().value_or(0) > kAtRest;
  Registration best, at_rest;
  for (const Vector6d& start : starts(neighbours, neighbours.mean_velocity(said))) {
    const Vector6d found = apart.registered(neighbours.registered(start));
    const double blur_m = apart.blur_m(found);
    const bool apparent_rest = !may_rest && found.head<3>().norm() * apart_s < rest_m;
    Registration& sharpest = apparent_rest ? at_rest : best;
    if (blur_m < sharpest.blur_m) sharpest = {found, blur_m, apparent_rest};
  }
  const bool unrelated = best.blur_m >= kFits_m && out.said_m >= kUnrelated_m;
  return unrelated && at_rest.blur_m < best.blur_m ? at_rest : best;
}

// Sets own_m, the blur under the best registration of the scans, traffic, one_vehicle and trust.
void compare_with_registration(const Place& place, const PosePair& apart, const Motion& said,
                               PlaceFinding& out) {
  const Registration best = best_registration(place, apart, said, out);
  const double apart_s = (place.last.start - place.first.start).seconds();
  const auto said_velocity = apart.mean_velocity(said);
  out.own_m = best.blur_m;
  if (out.own_m >= out.said_m) return;
  const auto share = share_in_line(best.velocity, said_velocity, apart_s);
  out.traffic = best.apparent_rest || (share && may_be_traffic(*share, *said_velocity));
  const bool fits = best.blur_m < kFits_m;
  const auto peaks = apart.peaks(said, best.velocity);
  const auto flank = apart.flank(said, best.velocity);
  const bool contradicts = fits && peaks && peaks->said < kStandsOutNot &&
                           peaks->found > (out.at_jump ? kStandsOutNot : kStandsOut);
  const bool flanked = fits && flank && on_flank(*flank, best.velocity, said_velocity);
  out.slower = share && *share > 0 && *share < 1 && flank && flank->apart_m > kFlank_m;
  const bool one_sided = apart.one_sided(said, best.velocity);
  const bool two_motions =
      contradicts && one_sided && out.supports && flank && flank->apart_m > kTwoMotions_m && !out.at_jump;
  if (two_motions) return;
  const bool far_better = flank && flank->found > kFarBetter && !out.traffic && !one_sided;
  // A vehicle that stays beside the sensor for half a second moves along with it, or the sensor is slow.
  const bool beside = out.speed_mps < kTraffic_mps || best.velocity.head<3>().norm() < out.speed_mps;
  out.one_vehicle = (contradicts || flanked) && beside && one_sided;
  if (contradicts && out.trust != Trust::wrong) out.trust = out.traffic ? Trust::doubtful : Trust::wrong;
  if (out.trust == Trust::right && (far_better || flanked)) out.trust = Trust::doubtful;
}

// Whether the poses are at rest and most of what is seen is not. Rings on a bare ground look the same.
bool is_stirred(const PosePair& apart, const Vector6d& said, double apart_s) {
  const auto share = apart.equal_share();
  const double moved_m = (said.head<3>().norm() + kLever_m * said.tail<3>().norm()) * apart_s;
  return share && moved_m < kStill_m && *share < kLeastAtRest;
}

PlaceFinding look_at(std::shared_ptr<const Place> place, std::size_t k, const Motion& said, bool at_jump) {
  PlaceFinding found;
  found.k = k;
  found.at_jump = at_jump;
  const PosePair apart(place->first, place->last);
  const auto blur = apart.blur_m(said);
  if (!blur || apart.size() < kFewestPoints) return found;
  found.said_m = *blur;
  found.own_m = *blur;
  if (const auto velocity = apart.mean_velocity(said)) {
    found.speed_mps = velocity->head<3>().norm();
    found.stirred = is_stirred(apart, *velocity, (place->last.start - place->first.start).seconds());
  }
  found.trust = found.speed_mps > kFastest_mps ? Trust::wrong : Trust::right;
  found.supports = *blur <= kSharp_m || stand_out(apart, said);
  if (*blur > kSharp_m) compare_with_registration(*place, apart, said, found);
  found.stirred = found.stirred && found.trust == Trust::right;
  if (found.stirred) found.trust = Trust::doubtful;
  found.place = std::move(place);
  return found;
}

std::shared_ptr<const Place> read_place(const Dataset& dataset, std::size_t k, std::size_t last) try {
  const std::size_t n = scans_apart(dataset, k, last);
  LidarScan next = dataset.read(k + 1);
  LidarScan far = n == 1 ? next : dataset.read(k + n);
  return std::make_shared<const Place>(Place{dataset.read(k), std::move(next), std::move(far)});
} catch (const InputError&) {  // the run says so when it reaches the scan
  return nullptr;
}

// The mistake under which the places that contradict are sharpest.
std::string likely_mistake(const std::vector<PlaceFinding>& findings,
                           const std::shared_ptr<const Trajectory>& given) {
  double said = 0, own = 0;
  std::vector<PosePair> pairs;
  for (const PlaceFinding& found : findings) {
    if (found.trust < Trust::doubtful) continue;
    pairs.emplace_back(found.place->first, found.place->last);
    said += found.said_m;
    own += found.own_m;
  }
  std::string best;
  double least = said - kExplained * (said - own);
  for (const PoseMistake& mistake : pose_mistakes(given)) {
    double sum = 0;
    for (const PosePair& pair : pairs) sum += pair.blur_m(mistake.motion).value_or(PosePair::kCap_m);
    if (sum >= least) continue;
    least = sum;
    best = fmt::format("{}: the static world is {:.0f} times sharper so", mistake.text,
                       said / std::max(sum, kSharpest_m));
  }
  return best.empty() ? kOtherMistake : best;
}

struct Votes {
  std::size_t checked = 0, wrong = 0, bad = 0, at_jumps = 0, traffic = 0, slower = 0, vehicles = 0,
              support = 0, stirred = 0;
  const PlaceFinding* worst = nullptr;
};

Votes count(const std::vector<PlaceFinding>& findings) {
  Votes out;
  out.worst = &findings.front();
  for (const PlaceFinding& found : findings) {
    const bool bad = found.trust > Trust::right;
    if (!found.at_jump) ++out.checked;
    if (!found.at_jump && found.trust == Trust::wrong) ++out.wrong;
    if (bad) ++out.bad;
    if (bad && found.traffic) ++out.traffic;
    if (bad && (found.traffic || found.slower)) ++out.slower;
    if (bad && (found.one_vehicle || found.stirred) && !found.traffic) ++out.vehicles;
    if (bad && found.stirred) ++out.stirred;
    if (!bad && found.supports) ++out.support;
    if (bad && found.at_jump) ++out.at_jumps;
    const PlaceFinding& worst = *out.worst;
    const bool more = found.said_m - found.own_m > worst.said_m - worst.own_m;
    if (found.trust == worst.trust ? more : found.trust > worst.trust) out.worst = &found;
  }
  return out;
}

std::string problem_of(const Votes& votes, const std::vector<PlaceFinding>& findings,
                       const std::shared_ptr<const Trajectory>& given) {
  const PlaceFinding& worst = *votes.worst;
  const std::string where =
      worst.speed_mps > kFastest_mps
          ? fmt::format("the poses move at {:.0f} m/s (at {} of {} places are they doubtful): ",
                        worst.speed_mps, votes.bad, findings.size())
          : fmt::format(
                "the static world is blurred by {:.2f} m under the poses, by {:.2f} m under a "
                "registration of the scans (at {} of {} places): ",
                worst.said_m, worst.own_m, votes.bad, findings.size());
  std::string what;
  if (votes.bad == votes.at_jumps) {
    what = "the poses jump there";
  } else if (votes.stirred == votes.bad) {
    what = "the poses are at rest, but most beams end at another range half a second later";
  } else if (votes.traffic == votes.bad) {
    what = "vehicles fill the view and move along, or the poses are too fast";
  } else {
    what = likely_mistake(findings, given);
  }
  return fmt::format("from scan {} on, {}{}", worst.k, where, what);
}

CheckResult result_of(const std::vector<PlaceFinding>& findings, const Dataset& dataset,
                      const std::shared_ptr<const Trajectory>& given) {
  const Votes votes = count(findings);
  std::vector<std::shared_ptr<const Place>> places;
  for (const PlaceFinding& found : findings) {
    if (!found.at_jump) places.push_back(found.place);
  }
  const EdgeFinding edges = check_edges(places, given);
  CheckResult out{"poses", Trust::right, "", "", "", ""};
  out.measured = fmt::format(
      "at worst of {} places, the static world is blurred by {:.3f} m under the poses, by {:.3f} m under a "
      "registration of the scans",
      findings.size(), votes.worst->said_m, votes.worst->own_m);
  if (!edges.measured.empty()) out.measured += "; " + edges.measured;
  const bool right_elsewhere = votes.bad < findings.size() && votes.support >= votes.vehicles;
  const bool by_places = votes.traffic + votes.vehicles == votes.bad && right_elsewhere;
  const bool by_edges = edges.sure ? votes.slower == votes.bad
                                   : edges.agree && votes.traffic == votes.bad && votes.vehicles == 0;
  const bool outvoted = (by_places || by_edges) && votes.at_jumps == 0;
  if (votes.bad > 0 && !outvoted) {
    out.trust = votes.wrong > 0 && 2 * votes.wrong >= votes.checked ? Trust::wrong : Trust::doubtful;
    out.problem = problem_of(votes, findings, given);
  } else if (!edges.problem.empty()) {
    out.trust = Trust::doubtful;
    out.problem = edges.problem;
  }
  if (out.trust == Trust::right) return out;
  out.where = dataset.scan_file(votes.worst->k).string();
  out.remedy = "correct the poses, or leave them out (--odometry)";
  return out;
}

}  // namespace

CheckResult check_poses(const Dataset& dataset, const std::shared_ptr<const Trajectory>& given,
                        std::size_t first, std::size_t count, const std::vector<std::size_t>& places) {
  CheckResult out{"poses", Trust::unknown, "not checked: none given", "", "", ""};
  if (!given) return out;
  out.measured = "not checked: too few scans or points, or poses that do not cover them";
  if (count < 2) return out;
  const Motion said = motion_of(given);
  const std::size_t last = first + count - 1;
  std::vector<PlaceFinding> findings;
  const std::vector<std::size_t> jumped =
      within(dataset, first, last, places_at_jumps(dataset, said, first, count));
  const auto near_jump = [&](std::size_t k) {
    return std::any_of(jumped.begin(), jumped.end(),
                       [k](std::size_t j) { return k < j + kNear && j < k + kNear; });
  };
  std::vector<std::size_t> numbers = jumped;
  numbers.insert(numbers.end(), places.begin(), places.end());
  for (const std::size_t k : within(dataset, first, last, std::move(numbers))) {
    auto place = read_place(dataset, k, last);
    if (!place) continue;
    PlaceFinding found = look_at(std::move(place), k, said, near_jump(k));
    if (found.trust != Trust::unknown) findings.push_back(std::move(found));
  }
  return findings.empty() ? out : result_of(findings, dataset, given);
}

}  // namespace mapless
