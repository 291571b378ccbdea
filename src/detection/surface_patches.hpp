#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {

/// Neighbours in the scan image, and the plane through them.
struct SurfacePatch {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();  ///< as LocalPoints [m]
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< towards the sensor
  float thickness_m = 0;                             ///< standard deviation across the plane
  bool is_plane = false;
};

/// The aligned scan image in rectangles of kPatchRows lasers and kPatchColumns firings, each with a plane
/// where its points lie on one.
class SurfacePatches {
 public:
  /// Of the returns that are `wanted`, one element per return.
  SurfacePatches(const LidarScan& scan, const LocalPoints& points, const std::vector<char>& wanted);

  [[nodiscard]] std::size_t size() const { return patches_.size(); }
  [[nodiscard]] const SurfacePatch& operator[](std::size_t p) const { return patches_[p]; }
  /// Its returns, increasing.
  [[nodiscard]] std::span<const std::int32_t> members(std::size_t p) const {
    return {members_.data() + begin_[p], begin_[p + 1] - begin_[p]};
  }
  /// Calls visit(patch) for those around it, by rows.
  template <class Visit>
  void for_each_beside(std::size_t p, Visit&& visit) const {
    const int row = static_cast<int>(p) / across_, column = static_cast<int>(p) % across_;
    for (int r = row - 1; r <= row + 1; ++r) {
      if (r < 0 || r >= down_) continue;
      for (int c = column - 1; c <= column + 1; ++c) {
        if (r != row || c != column) visit(static_cast<std::size_t>(r * across_ + (c + across_) % across_));
      }
    }
  }

 private:
  void gather(const LidarScan& scan, const std::vector<char>& wanted);
  [[nodiscard]] SurfacePatch fitted(const std::vector<Eigen::Vector3f>& points, std::size_t p) const;

  int across_, down_;
  std::vector<std::size_t> begin_;  // of each patch in members_, and the end of the last
  std::vector<std::int32_t> members_;
  std::vector<SurfacePatch> patches_;
};

inline constexpr int kPatchRows = 4, kPatchColumns = 16;

}  // namespace mapless
