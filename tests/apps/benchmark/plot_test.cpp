#include "benchmark/page/plot.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmark/page/html.hpp"
#include "reports/json.hpp"

namespace mapless::app {
namespace MAPLESS_FILE {

using testing::HasSubstr;
using testing::Not;

Plot diagonal() {
  Plot plot{"a < b", {"x", 0, 1, 0.5}, {"y", 0, 1, 0.5}, {}};
  plot.lines.push_back({"up", {{0, 0}, {1, 1}}, {}, 0, false});
  return plot;
}

// What the page reads.
Json in_figure(const Plot& plot) {
  const std::string figure = plot.figure(), begin = "application/json\">";
  const std::size_t from = figure.find(begin) + begin.size();
  return Json::parse(figure.substr(from, figure.find("</script>") - from));
}

bool is_dark_blue(const Color& c) { return c.blue > c.red + 60 && c.red < 120; }

TEST(Plot, ALineGoesWhereItsPointsSay) {
  const Plot plot = diagonal();
  const Canvas canvas = plot.png();
  EXPECT_EQ(canvas.width(), 2 * Plot::kWidth);  // two pixels of the file per pixel of the drawing
  for (const double t : {0.1, 0.25, 0.7}) {
    const auto [x, y] = plot.pixel(t, t);
    EXPECT_TRUE(is_dark_blue(canvas.pixel(static_cast<int>(2 * x), static_cast<int>(2 * y)))) << t;
    const auto [beside_x, beside_y] = plot.pixel(t + 0.1, t);
    EXPECT_FALSE(is_dark_blue(canvas.pixel(static_cast<int>(2 * beside_x), static_cast<int>(2 * beside_y))))
        << t;
  }
}

TEST(Plot, AxesRunToTheRightAndUp) {
  const Plot plot = diagonal();
  EXPECT_LT(plot.pixel(0, 0).first, plot.pixel(1, 0).first);
  EXPECT_GT(plot.pixel(0, 0).second, plot.pixel(0, 1).second);
  const auto [x, y] = plot.pixel(0.5, 0.5);
  EXPECT_NEAR(x, (plot.pixel(0, 0).first + plot.pixel(1, 0).first) / 2, 1e-9);
  EXPECT_NEAR(y, (plot.pixel(0, 0).second + plot.pixel(0, 1).second) / 2, 1e-9);
}

TEST(Plot, ADashedLineHasGaps) {
  Plot plot = diagonal();
  plot.lines[0].dashed = true;
  plot.lines[0].points = {{0, 0.25}, {1, 0.25}};
  const Canvas canvas = plot.png();
  const auto [from, y] = plot.pixel(0.05, 0.25);
  const auto [to, unused] = plot.pixel(0.45, 0.25);
  int changes = 0;
  for (int x = static_cast<int>(2 * from); x < static_cast<int>(2 * to); ++x) {
    const int row = static_cast<int>(2 * y);
    changes += is_dark_blue(canvas.pixel(x, row)) != is_dark_blue(canvas.pixel(x + 1, row)) ? 1 : 0;
  }
  EXPECT_GT(changes, 10);
}

TEST(Plot, PointsBeyondTheAxesAreLeftOut) {
  Plot plot = diagonal();
  plot.lines[0].points = {{0.5, 0.5}, {2, 0.5}, {0.5, -1}};
  plot.lines[0].point_names = {"in", "right", "below"};
  const Json line = in_figure(plot)["lines"][0];
  EXPECT_EQ(line["points"], (Json{{0.5, 0.5}}));
  EXPECT_EQ(line["names"], (Json{"in"}));
}

TEST(Plot, AFigureOfThePageHoldsItsNumbers) {
  const Json all = in_figure(diagonal());
  EXPECT_EQ(all["title"], "a < b");
  EXPECT_EQ(all["x"]["to"], 1);
  EXPECT_EQ(all["y"]["step"], 0.5);
  EXPECT_EQ(all["lines"][0]["points"], (Json{{0, 0}, {1, 1}}));
  EXPECT_THAT(diagonal().figure(), Not(HasSubstr("a < b")));  // no text ends the script element
}

TEST(Plot, AnAxisFromZeroHoldsTheLargestWithRoundTicks) {
  for (const double largest : {0.3, 1.0, 7.0, 24.0, 95.0, 120.0, 130.0}) {
    const Axis axis = axis_from_zero("m", largest);
    EXPECT_GE(axis.to, largest - 1e-9);
    EXPECT_LT(axis.to, largest + axis.step);
    const double count = axis.to / axis.step;
    EXPECT_NEAR(count, std::round(count), 1e-9) << largest;
    EXPECT_LE(count, 8 + 1e-9);
  }
  EXPECT_DOUBLE_EQ(axis_from_zero("m", 120).step, 20);
}

TEST(Html, EscapesWhatHasAMeaning) {
  EXPECT_EQ(escaped(R"(<a href="x">R&D's</a>)"), "&lt;a href=&quot;x&quot;&gt;R&amp;D&#39;s&lt;/a&gt;");
  EXPECT_THAT(html_table({"<b>"}, {{"1 < 2"}}, 1),
              testing::AllOf(HasSubstr("&lt;b&gt;"), HasSubstr("1 &lt; 2")));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
