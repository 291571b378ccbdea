#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "detection/evidence/point_evidence.hpp"
#include "detection/freespace/packed_points.hpp"

namespace mapless::inline v1 {

/// Seen as a surface, and by nobody seen through or moving.
[[nodiscard]] inline bool is_static(const PointVotes& v) {
  return v.surface_seen && !v.seen_through && !v.vacated && !v.moving_seen;
}

/// The scans asked about the points of one scan, and what they say.
class Witnesses {
  struct Witness;

 public:
  /// Keeps references to all but `asked`.
  Witnesses(const LidarScan& scan, const LocalPoints& points, const std::vector<AskedScan>& asked,
            const RayImage& own, const VotingParameters& parameters);

  /// Room for what is known of one call, kept for the next.
  struct Hearing {
    struct Question {
      std::uint32_t i;  // return of the scan
      PointVotes votes;
      bool seen_next = false;   // as a surface, by the next later scan
      float next_off_m = 0;     // along the ray, from the point to that surface; NaN: beside it
      bool hider_left = false;  // of some scan
    };
    std::vector<Question> questions;
    std::vector<std::size_t> open;  // those not settled yet
    PackedPoints points;            // of each of them
    // What hid a point from one scan, and may have left.
    struct Hider {
      Question* question;
      int laser, column;       // of the firing that ended there
      float distance2_m2 = 0;  // of the point from there, squared
    };
    std::vector<Hider> hiders;
    PackedPoints places;  // of each of them
    // What has left, of all scans.
    struct Leaver {
      Question* question;
      const Witness* witness;
      float distance_m;  // from where it was to the point
    };
    std::vector<Leaver> leavers;
  };
  /// Asks about returns of the scan, best neighbours of a row, and enters the answers in `votes`.
  void ask(const std::vector<std::size_t>& questions, Hearing& hearing, std::vector<PointVotes>& votes) const;

 private:
  using Question = Hearing::Question;
  struct Witness {
    FreespaceProbe probe;
    int surface_votes;
    bool later;
    bool next;  // the nearest of the later ones
    bool recent;
    int scans_off;
  };

  [[nodiscard]] float column(std::size_t i) const { return static_cast<float>(scan_.returns[i].column); }
  void gather(const std::vector<std::size_t>& questions, Hearing& hearing) const;
  void hear_all(const Witness& witness, Hearing& hearing) const;
  void hear(const Witness& witness, const FreespaceProbe::Answer& answer, Question& question,
            Hearing& hearing) const;
  void ask_whether_left(const Witness& witness, Hearing& hearing) const;
  void count_leavers(Hearing& hearing) const;
  [[nodiscard]] bool goes_on(const Hearing::Leaver& leaver) const;
  static void count(const Witness& witness, int number, PointVotes& votes);
  void settle(std::size_t next, Hearing& hearing) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  float vacated_m_, surface_noise_m_;
  FreespaceProbe own_;
  std::vector<Witness> witnesses_;
};

}  // namespace mapless
