#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "lidar/vendor_models.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

struct NamedModel {
  std::string_view name;
  LidarModel (*make)();
};

constexpr std::array<NamedModel, 8> kNamedModels = {{{"HDL-64E-S2", hdl_64e_s2},
                                                     {"HDL-64E-S3", hdl_64e_s3},
                                                     {"VLP-16", vlp_16},
                                                     {"HDL-32E", hdl_32e},
                                                     {"OS1-64", os1_64},
                                                     {"OS1-128", os1_128},
                                                     {"Pandar64", pandar_64},
                                                     {"XT-32", xt_32}}};

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

}  // namespace

LidarModel assembled(LidarModel model) {
  for (Laser& laser : model.lasers) {
    const double turned =
        model.sign() * 2 * std::numbers::pi * model.rotation_rate_hz * laser.firing_offset.seconds();
    laser.azimuth_offset_rad += turned;
    laser.origin_h_m = rotation_z(turned) * laser.origin_h_m;
  }
  std::stable_sort(model.lasers.begin(), model.lasers.end(),
                   [](const Laser& a, const Laser& b) { return a.elevation_rad < b.elevation_rad; });
  return model;
}

LidarModel named_model(std::string_view name) {
  for (const NamedModel& known : kNamedModels) {
    if (!equal_ignoring_case(known.name, name)) continue;
    LidarModel model = known.make();
    model.name = known.name;
    return model;
  }
  throw ParameterError({"sensor", "name", std::string(name), "not a named model",
                        fmt::format("choose one of {}", fmt::join(named_models(), ", "))});
}

const std::vector<std::string>& named_models() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const NamedModel& known : kNamedModels) out.emplace_back(known.name);
    return out;
  }();
  return names;
}

}  // namespace mapless
