#include "io/formats/kitti/kitti_calibration.hpp"

#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/rotation_check.hpp"
#include "io/files/text.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

// A text file of lines "key: number number ...".
class KittiCalibration {
 public:
  explicit KittiCalibration(const std::filesystem::path& file)
      : file_(file.string()), text_(read_whole_file(file)) {}

  // The numbers of `key`, where it is there. Throws InputError unless there are `count`, all finite.
  [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key, std::size_t count) const {
    std::optional<std::vector<double>> found;
    for (const std::string_view line : split_lines(text_)) {
      const std::size_t colon = line.find(':');
      if (colon == std::string_view::npos || line.substr(0, colon) != key) continue;
      if (found) refuse(key, "", "is there twice");
      const std::vector<std::string_view> words = split_words(line.substr(colon + 1));
      std::vector<double> values;
      for (const std::string_view word : words) {
        const std::optional<double> value = parse_double(word);
        if (!value || !std::isfinite(*value)) refuse(key, std::string(word), "is not a finite number");
        values.push_back(*value);
      }
      if (values.size() != count) {
        refuse(key, fmt::format("{} numbers", values.size()), fmt::format("{} are needed", count));
      }
      found = std::move(values);
    }
    return found;
  }

  [[nodiscard]] std::optional<Eigen::Matrix3d> rotation(std::string_view key) const {
    const auto values = numbers(key, 9);
    if (!values) return std::nullopt;
    return checked(key, Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values->data()));
  }

  [[nodiscard]] Eigen::Matrix3d checked(std::string_view key, const Eigen::Matrix3d& R) const {
    if (const auto problem = rotation_problem(R)) refuse(key, "", *problem);
    return SE3(R, Eigen::Vector3d::Zero()).normalized().rotation();
  }

  [[noreturn]] void refuse(std::string_view key, std::string value, std::string problem) const {
    throw InputError({file_, std::string(key), std::move(value), std::move(problem),
                      "give calib.txt of KITTI odometry or calib_velo_to_cam.txt of KITTI raw"});
  }

 private:
  std::string file_;
  std::string text_;
};

}  // namespace

SE3 read_kitti_calibration(const std::filesystem::path& file) {
  const KittiCalibration calibration(file);
  if (const auto Tr = calibration.numbers("Tr", 12)) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> T(Tr->data());
    return {calibration.checked("Tr", T.leftCols<3>()), T.col(3)};
  }
  const auto R = calibration.rotation("R");
  const auto T = calibration.numbers("T", 3);
  if (!R || !T) calibration.refuse(R ? "T" : "Tr, or R and T", "", "not found");
  const SE3 T_cam_velo(*R, Eigen::Map<const Eigen::Vector3d>(T->data()));
  const std::filesystem::path rectification = file.parent_path() / "calib_cam_to_cam.txt";
  if (!std::filesystem::exists(rectification)) return T_cam_velo;
  const auto R_rect = KittiCalibration(rectification).rotation("R_rect_00");
  return R_rect ? SE3(*R_rect, Eigen::Vector3d::Zero()) * T_cam_velo : T_cam_velo;
}

}  // namespace mapless
