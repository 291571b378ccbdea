#include <array>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapless/core/errors.hpp>
#include <mapless/core/parameters.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using ::testing::AllOf;
using ::testing::HasSubstr;

enum class Colour { red, green, blue };
constexpr std::array<std::string_view, 3> kColourNames = {"red", "green", "blue"};
constexpr std::span<const std::string_view> choice_names(Colour) { return kColourNames; }

struct Inner {
  double width_m = 0.2;
  Colour colour = Colour::green;
  static constexpr auto declarations() {
    return std::tuple{declare(&Inner::width_m, "width_m", "m", 0.001, 10.0, "a width", "hand"),
                      declare(&Inner::colour, "colour", "a choice", "hand")};
  }
};

struct Outer {
  int count = 8;
  bool enabled = true;
  Inner inner;
  static constexpr auto declarations() {
    return std::tuple{declare(&Outer::count, "count", "scans", 1, 100, "a count", "hand"),
                      declare(&Outer::enabled, "enabled", "a switch", "hand"), group(&Outer::inner, "inner")};
  }
};

std::string message_of(const std::vector<ParameterReference>& references, std::string_view key,
                       std::string_view text) {
  try {
    assign_parameter(references, key, text, "config.yaml");
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

struct Window {
  int rows = 3;
  static constexpr auto declarations() {
    return std::tuple{declare_odd(&Window::rows, "rows", "lasers", 1, 15, "a height", "hand")};
  }
};

std::string bounds_error(const auto& parameters) {
  try {
    require_within_bounds(parameters, "Detector");
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Parameters, RequireWithinBoundsAcceptsDefaultsAndTheBoundsThemselves) {
  Outer p;
  EXPECT_EQ(bounds_error(p), "no error");
  p.count = 1;
  p.inner.width_m = 10;
  EXPECT_EQ(bounds_error(p), "no error");
}

TEST(Parameters, RequireWithinBoundsNamesParameterValueAndBounds) {
  Outer p;
  p.count = 0;
  EXPECT_EQ(bounds_error(p), "Detector: count = 0: out of bounds; give a value from 1 to 100 scans");
  p = {};
  p.inner.width_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(bounds_error(p), "Detector: inner.width_m = nan: out of bounds; give a value from 0.001 to 10 m");
  p = {};
  p.inner.colour = static_cast<Colour>(3);
  EXPECT_EQ(bounds_error(p), "Detector: inner.colour = 3: not one of its choices; choose red, green, blue");
  EXPECT_THAT(bounds_error(Window{4}), AllOf(HasSubstr("rows = 4"), HasSubstr("odd number from 1 to 15")));
}

TEST(Parameters, OddParametersRefuseEvenValues) {
  Window window;
  const auto references = parameter_references(window);
  EXPECT_THAT(message_of(references, "rows", "4"),
              AllOf(HasSubstr("rows = 4"), HasSubstr("odd number from 1")));
  assign_parameter(references, "rows", "15", "");
  EXPECT_EQ(window.rows, 15);
}

TEST(Parameters, AreListedInOrderOfDeclarationWithTheirGroups) {
  Outer p;
  const auto references = parameter_references(p);
  std::vector<std::string> keys, texts, types;
  for (const ParameterReference& r : references) {
    keys.push_back(r.key);
    texts.push_back(r.text());
    types.emplace_back(r.type());
  }
  EXPECT_EQ(keys, (std::vector<std::string>{"count", "enabled", "inner.width_m", "inner.colour"}));
  EXPECT_EQ(texts, (std::vector<std::string>{"8", "true", "0.2", "green"}));
  EXPECT_EQ(types, (std::vector<std::string>{"integer", "switch", "number", "choice"}));
}

TEST(Parameters, AssignReachesTheStruct) {
  Outer p;
  const auto references = parameter_references(p);
  assign_parameter(references, "count", "100", "test");
  assign_parameter(references, "enabled", "false", "test");
  assign_parameter(references, "inner.width_m", "1e-1", "test");
  assign_parameter(references, "inner.colour", "blue", "test");
  EXPECT_EQ(p.count, 100);
  EXPECT_FALSE(p.enabled);
  EXPECT_EQ(p.inner.width_m, 0.1);
  EXPECT_EQ(p.inner.colour, Colour::blue);
}

TEST(Parameters, TextOfANumberReadsBackToTheSameNumber) {
  Outer p;
  const auto references = parameter_references(p);
  for (const double value : {1.0 / 3, 0.1 + 0.2, 1e-3, 10.0}) {
    p.inner.width_m = value;
    const std::string text = references[2].text();
    p.inner.width_m = 5;
    references[2].assign(text, "test");
    EXPECT_EQ(p.inner.width_m, value) << text;
  }
}

TEST(Parameters, UnknownKeyNamesTheNearestOne) {
  Outer p;
  const auto references = parameter_references(p);
  EXPECT_THAT(message_of(references, "inner.widht_m", "1"),
              AllOf(HasSubstr("config.yaml"), HasSubstr("inner.widht_m = 1"), HasSubstr("unknown"),
                    HasSubstr("did you mean inner.width_m?")));
  EXPECT_THAT(message_of(references, "coulour", "red"), HasSubstr("did you mean inner.colour?"));
  EXPECT_THAT(message_of(references, "counts", "3"), HasSubstr("did you mean count?"));
  EXPECT_THAT(message_of({}, "count", "3"), HasSubstr("unknown"));
}

TEST(Parameters, OutOfBoundsNamesKeyValueAndBounds) {
  Outer p;
  const auto references = parameter_references(p);
  for (const char* text : {"0", "101", "-3"}) {
    EXPECT_THAT(message_of(references, "count", text),
                AllOf(HasSubstr(std::string("count = ") + text), HasSubstr("from 1 to 100 scans")));
  }
  for (const char* text : {"0.0009", "11", "inf", "nan", "-nan"}) {
    EXPECT_THAT(message_of(references, "inner.width_m", text), HasSubstr("from 0.001 to 10 m")) << text;
  }
  EXPECT_EQ(p.count, 8);
  EXPECT_EQ(p.inner.width_m, 0.2);
}

TEST(Parameters, TextOfAnotherTypeIsRefused) {
  Outer p;
  const auto references = parameter_references(p);
  for (const char* text : {"", "four", "4.5", "4 ", "99999999999", "+-4"}) {
    EXPECT_THAT(message_of(references, "count", text), HasSubstr("not an integer")) << text;
  }
  for (const char* text : {"", "0.2m", "0,2", "1e999"}) {
    EXPECT_THAT(message_of(references, "inner.width_m", text), HasSubstr("not a number")) << text;
  }
  EXPECT_THAT(message_of(references, "enabled", "2"), HasSubstr("true or false"));
  EXPECT_THAT(message_of(references, "inner.colour", "mauve"), HasSubstr("choose red, green, blue"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
