#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/toy_scene.hpp"
#include <mapless/lidar/self_check.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::size_t kScans = 12;

// Scans of a VLP-16 that drives along a street.
const std::vector<LidarScan>& street() {
  static const std::vector<LidarScan> scans = [] {
    const test::ToyScene scene = test::toy_street("VLP-16");
    std::vector<LidarScan> out;
    for (std::size_t k = 0; k < kScans; ++k) out.push_back(*cast_scan(scene, static_cast<int>(k)).scan);
    return out;
  }();
  return scans;
}

// Of the scans of the street, each changed by `spoil`.
template <class Spoil>
std::vector<std::string> lines_of(Spoil spoil) {
  ScanWatch watch;
  for (std::size_t k = 0; k < kScans; ++k) {
    LidarScan scan = street()[k];
    spoil(scan, k);
    watch.add(scan, k);
  }
  return watch.lines();
}

TEST(ScanWatch, SaysNothingOfARightRecording) {
  EXPECT_THAT(lines_of([](LidarScan&, std::size_t) {}), IsEmpty());
}

TEST(ScanWatch, NamesTheScansThatAreSpoiltInTheMiddle) {
  const auto in_the_middle = [](auto change) {
    return [change](LidarScan& scan, std::size_t k) {
      if (k < 4 || k > 6) return;
      for (LidarReturn& r : scan.returns) change(r);
    };
  };
  EXPECT_THAT(lines_of(in_the_middle([](LidarReturn& r) { r.position_v.y() *= -1; })),
              ElementsAre(AllOf(HasSubstr("doubtful beams"), HasSubstr("scan 6"))));
  EXPECT_THAT(lines_of(in_the_middle([](LidarReturn& r) { r.time_ns = 0; })),
              ElementsAre(AllOf(HasSubstr("doubtful times"), HasSubstr("scan 6"))));
  EXPECT_THAT(lines_of(in_the_middle([](LidarReturn& r) { r.range_m *= 1000; })),
              ElementsAre(AllOf(HasSubstr("doubtful ranges"), HasSubstr("scan 6"))));
}

// A driver that stalls. A sensor without noise that stands still sees the same in every scan.
TEST(ScanWatch, NamesAScanThatIsTheOneBeforeItOnceMore) {
  const LidarScan &before = street()[4], &first = street()[0];
  EXPECT_THAT(lines_of([&](LidarScan& scan, std::size_t k) {
                if (k == 5) scan.returns = before.returns;
              }),
              ElementsAre(AllOf(HasSubstr("doubtful scans: scan 5"), HasSubstr("before it"))));
  EXPECT_THAT(lines_of([&](LidarScan& scan, std::size_t) { scan.returns = first.returns; }), IsEmpty());
}

// Captures begin and end within a turn.
TEST(ScanWatch, NamesScansWithoutTheReturnsOfManyColumns) {
  const auto lines_without_half = [](const std::vector<std::size_t>& scans) {
    return lines_of([&](LidarScan& scan, std::size_t k) {
      if (std::find(scans.begin(), scans.end(), k) == scans.end()) return;
      const int half = scan.columns / 2;
      const bool first = k % 2 == 0;
      std::erase_if(scan.returns, [&](const LidarReturn& r) { return (r.column < half) == first; });
      std::fill(scan.cells.begin(), scan.cells.end(), empty_cell(ReturnCode::absent));
    });
  };
  EXPECT_THAT(lines_without_half({5}), ElementsAre(AllOf(HasSubstr("doubtful columns: scan 5: 904 columns"),
                                                         HasSubstr("of 1808 that have"))));
  EXPECT_THAT(lines_without_half({4, 5}), ElementsAre(HasSubstr("doubtful columns: scan 4 (and 1 others)")));
  EXPECT_THAT(lines_without_half({0, kScans - 1}), IsEmpty());
}

// A dark vehicle that passes hides 200 columns, 150 further on in each scan, across the seam too. One stretch
// that is empty in one scan alone is of lost packets, and so are 25 of 8 columns.
TEST(ScanWatch, SaysNothingOfADarkThingThatPasses) {
  const auto lines_with = [](auto&& hidden) {
    return lines_of([&](LidarScan& scan, std::size_t k) {
      const int begin = 850 + 150 * static_cast<int>(k);
      std::erase_if(scan.returns,
                    [&](const LidarReturn& r) { return hidden((r.column - begin + 2 * 1808) % 1808, k); });
      std::fill(scan.cells.begin(), scan.cells.end(), empty_cell(ReturnCode::absent));
    });
  };
  const auto vehicle = [](int column, std::size_t) { return column < 200; };
  const auto once = [&](int column, std::size_t k) { return k == 5 && vehicle(column, k); };
  const auto packets = [](int column, std::size_t) { return column % 72 < 8; };
  EXPECT_THAT(lines_with(vehicle), IsEmpty());
  EXPECT_THAT(lines_with(once), ElementsAre(HasSubstr("doubtful columns: scan 5: 200 columns")));
  EXPECT_THAT(lines_with(packets), ElementsAre(HasSubstr("doubtful columns: scan 1 (and ")));
}

TEST(ScanWatch, LinesThatAreTakenAreForgotten) {
  ScanWatch watch;
  const auto add = [&](std::size_t k) { watch.add(street()[k], k); };
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}, std::size_t{1}, std::size_t{2}}) add(k);
  EXPECT_THAT(watch.take_lines(), ElementsAre(HasSubstr("doubtful scans: scan 1")));
  EXPECT_THAT(watch.take_lines(), IsEmpty());
  for (std::size_t k = 3; k < 6; ++k) add(k);
  EXPECT_THAT(watch.lines(), IsEmpty());
}

// Walls ahead and behind come .3 m nearer in a scan: the scan before the two is like the second, the one
// after them like the first.
TEST(ScanWatch, NamesTwoScansThatAreExchanged) {
  const test::ToyScene room = test::toy_room("VLP-16", test::drive(0.8, 0));
  ScanWatch right, exchanged;
  for (int k = 0; k < 16; ++k) {
    right.add(*cast_scan(room, k).scan, static_cast<std::size_t>(k));
    const int other = k == 5 ? 6 : k == 6 ? 5 : k;
    exchanged.add(*cast_scan(room, other).scan, static_cast<std::size_t>(k));
  }
  EXPECT_THAT(right.lines(), IsEmpty());
  EXPECT_THAT(exchanged.lines(), ElementsAre(HasSubstr("doubtful order: scans 5 and 6 look exchanged")));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
