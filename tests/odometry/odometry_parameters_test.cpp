#include <cmath>
#include <limits>
#include <string>
#include <variant>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/odometry/lidar_odometry.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string refusal(const OdometryParameters& parameters) {
  try {
    const LidarOdometry odometry(parameters);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

/// Every parameter by itself, first at `value(parameter)`, then at its default again.
template <class Value, class Check>
void for_each_parameter(const Value& value, const Check& check) {
  OdometryParameters parameters;
  for (const ParameterReference& p : parameter_references(parameters)) {
    const OdometryParameters defaults = parameters;
    const double wanted = value(p);
    if (auto* const* v = std::get_if<double*>(&p.value)) {
      **v = wanted;
    } else {
      *std::get<int*>(p.value) = static_cast<int>(wanted);
    }
    check(refusal(parameters), p);
    parameters = defaults;
  }
}

bool is_integer(const ParameterReference& p) { return std::holds_alternative<int*>(p.value); }

TEST(OdometryParameters, ValuesOutOfBoundsAreRefusedByNameValueAndBounds) {
  const auto names_all = [](const std::string& message, const ParameterReference& p) {
    EXPECT_THAT(message, AllOf(StartsWith("LidarOdometry: " + p.key + " = " + p.text() + ": out of bounds"),
                               HasSubstr(fmt::format("from {} to {}", p.min, p.max))));
  };
  for_each_parameter(
      [](const auto& p) { return is_integer(p) ? p.min - 1 : std::nextafter(p.min, -kInfinity); }, names_all);
  for_each_parameter(
      [](const auto& p) { return is_integer(p) ? p.max + 1 : std::nextafter(p.max, kInfinity); }, names_all);
}

TEST(OdometryParameters, NotANumberIsRefused) {
  for_each_parameter(
      [](const auto& p) { return is_integer(p) ? p.min : std::numeric_limits<double>::quiet_NaN(); },
      [](const std::string& message, const ParameterReference& p) {
        const std::string expected = is_integer(p) ? "no error" : "LidarOdometry: " + p.key + " = nan";
        EXPECT_THAT(message, StartsWith(expected));
      });
}

TEST(OdometryParameters, TheBoundsThemselvesAreAccepted) {
  const auto accepted = [](const std::string& message, const ParameterReference& p) {
    EXPECT_EQ(message, "no error") << p.key;
  };
  for_each_parameter([](const auto& p) { return p.min; }, accepted);
  for_each_parameter([](const auto& p) { return p.max; }, accepted);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
