#include "pictures/canvas.hpp"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace MAPLESS_FILE {

constexpr Color kBlack{0, 0, 0}, kWhite{255, 255, 255};

// The area that is white on black, and the mean x of it [px].
std::pair<double, double> white_area(const Canvas& canvas) {
  double area = 0, sum = 0;
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) {
      const double here = canvas.pixel(x, y).green / 255;
      area += here;
      sum += here * (x + 0.5);
    }
  }
  return {area, sum / area};
}

TEST(Canvas, ShapesHaveTheirArea) {
  Canvas disc(100, 80, kBlack);
  disc.disc(40, 40, 20, kWhite);
  EXPECT_NEAR(white_area(disc).first, std::numbers::pi * 400, 4);
  EXPECT_NEAR(white_area(disc).second, 40, 0.05);
  Canvas ring(100, 80, kBlack);
  ring.ring(40, 40, 20, 4, kWhite, 0.5);
  EXPECT_NEAR(white_area(ring).first, 0.5 * 2 * std::numbers::pi * 20 * 4, 4);
  Canvas arrow(100, 80, kBlack);
  arrow.arrow_right(40, 40, 20, kWhite);  // 40 wide, 40 high
  EXPECT_NEAR(white_area(arrow).first, 800, 4);
  Canvas rectangle(100, 80, kBlack);
  rectangle.clip(0, 0, 30, 80);
  rectangle.rectangle(20, 10, 40, 20, kWhite);
  EXPECT_NEAR(white_area(rectangle).first, 10 * 20, 1e-9);
  rectangle.unclip();
  rectangle.rectangle(20, 10, 40, 20, kWhite);
  EXPECT_NEAR(white_area(rectangle).first, 40 * 20, 1e-9);
}

TEST(Canvas, LinesHaveTheirLengthAndDashes) {
  Canvas whole(100, 20, kBlack), dashed(100, 20, kBlack);
  whole.line(10, 10, 90, 10, 2, kWhite);  // with two round ends
  EXPECT_NEAR(white_area(whole).first, 80 * 2 + std::numbers::pi, 1);
  dashed.line(10, 10, 89, 10, 2, kWhite, 8);  // five dashes
  EXPECT_NEAR(white_area(dashed).first, 5 * (8 * 2 + std::numbers::pi), 2);
}

TEST(Canvas, TextStandsWhereItsAnchorSays) {
  const auto middle_of = [](Anchor anchor) {
    Canvas canvas(200, 40, kBlack);
    canvas.text(100, 20, "mmmm", 16, kWhite, anchor);
    return white_area(canvas).second;
  };
  Canvas canvas(200, 40, kBlack);
  const double width = canvas.text(0, 20, "mmmm", 16, kWhite);
  EXPECT_NEAR(middle_of(Anchor::left), 100 + width / 2, 1);
  EXPECT_NEAR(middle_of(Anchor::middle), 100, 1);
  EXPECT_NEAR(middle_of(Anchor::right), 100 - width / 2, 1);
}

TEST(Canvas, UnitsMayBeSeveralPixels) {
  Canvas canvas(100, 80, kBlack, 2);
  EXPECT_EQ(canvas.width(), 200);
  canvas.rectangle(20, 10, 40, 20, kWhite);
  EXPECT_NEAR(white_area(canvas).first, 4 * 40 * 20, 1e-9);
}

TEST(Canvas, APictureIsTheSameBytesEachTime) {
  const test::TemporaryFolder folder;
  const auto written = [&](int reduce) {
    Canvas canvas(200, 40, kBlack);
    canvas.disc(40, 20, 15, {200, 30, 90}, 0.7);
    canvas.text(100, 20, "scan 7", 16, kWhite);
    canvas.write_png(folder.path() / "a.png", reduce);
    return read_whole_file(folder.path() / "a.png");
  };
  EXPECT_THAT(written(1), testing::StartsWith("\x89PNG"));
  EXPECT_TRUE(written(1) == written(1));
  EXPECT_TRUE(written(2) == written(2));
  EXPECT_LT(written(2).size(), written(1).size());
}

TEST(Canvas, APictureTooLargeIsRefused) { EXPECT_THROW(Canvas(40000, 10, kBlack), OutputError); }

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
