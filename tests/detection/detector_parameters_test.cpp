#include <cmath>
#include <limits>
#include <string>
#include <variant>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string refusal(const DetectorParameters& parameters) {
  try {
    const Detector detector(parameters);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

/// Gives every number among the parameters, one at a time, the value that `change` makes of it, and calls
/// `check(message, parameter)` with what Detector's constructor says.
template <class Change, class Check>
void for_each_number(Change&& change, Check&& check) {
  DetectorParameters parameters;
  int numbers = 0;
  for (const ParameterReference& p : parameter_references(parameters)) {
    const DetectorParameters defaults = parameters;
    if (auto* const* v = std::get_if<double*>(&p.value)) {
      **v = change(p, **v);
    } else if (auto* const* n = std::get_if<int*>(&p.value)) {
      **n = static_cast<int>(change(p, **n));
    } else {
      continue;
    }
    ++numbers;
    check(refusal(parameters), p);
    parameters = defaults;
  }
  EXPECT_GT(numbers, 30);
}

double below(const ParameterReference& p, auto /*value*/) {
  return std::holds_alternative<int*>(p.value) ? p.min - 1 : std::nextafter(p.min, -kInfinity);
}
double above(const ParameterReference& p, auto /*value*/) {
  return std::holds_alternative<int*>(p.value) ? p.max + 1 : std::nextafter(p.max, kInfinity);
}

TEST(DetectorParameters, ValuesBeyondTheirBoundsAreRefusedByName) {
  const auto names_all = [](const std::string& message, const ParameterReference& p) {
    const std::string bounds = fmt::format("from {} to {}", p.min, p.max);
    EXPECT_THAT(message, AllOf(StartsWith("Detector: " + p.key + " = " + p.text() + ": out of bounds"),
                               HasSubstr(bounds)));
  };
  for_each_number([](const auto& p, auto value) { return below(p, value); }, names_all);
  for_each_number([](const auto& p, auto value) { return above(p, value); }, names_all);
}

TEST(DetectorParameters, NotANumberIsRefused) {
  const auto not_a_number = [](const ParameterReference& p, auto value) -> double {
    return std::holds_alternative<double*>(p.value) ? std::numeric_limits<double>::quiet_NaN() : value;
  };
  for_each_number(not_a_number, [](const std::string& message, const ParameterReference& p) {
    if (std::holds_alternative<double*>(p.value)) {
      EXPECT_THAT(message, StartsWith("Detector: " + p.key + " = nan: out of bounds"));
    } else {
      EXPECT_EQ(message, "no error") << p.key;
    }
  });
}

TEST(DetectorParameters, BoundsThemselvesAreAccepted) {
  const auto accepted = [](const std::string& message, const ParameterReference& p) {
    EXPECT_EQ(message, "no error") << p.key;
  };
  for_each_number([](const ParameterReference& p, auto) { return p.min; }, accepted);
  for_each_number([](const ParameterReference& p, auto) { return p.max; }, accepted);
}

TEST(DetectorParameters, EvenWindowsAreRefused) {
  DetectorParameters parameters;
  parameters.voting.window_columns = 4;
  EXPECT_THAT(refusal(parameters),
              AllOf(HasSubstr("voting.window_columns = 4: not odd"), HasSubstr("odd number from 1")));
}

TEST(DetectorParameters, UnknownMethodsAreRefused) {
  DetectorParameters parameters;
  parameters.method = static_cast<DetectionMethod>(7);
  EXPECT_THAT(refusal(parameters), HasSubstr("method = 7: not one of its choices"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
