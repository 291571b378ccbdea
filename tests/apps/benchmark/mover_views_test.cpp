#include "benchmark/movers/mover_views.hpp"

#include <memory>

#include <gtest/gtest.h>

#include "benchmark/movers/mover_picture.hpp"
#include <mapless/io/labels.hpp>

namespace mapless::app {
namespace MAPLESS_FILE {

// A mover of `count` points 10 m ahead, each second one found, on ground that is called dynamic at one place.
struct Seen {
  Detection detection;
  std::vector<std::uint32_t> truth;

  explicit Seen(std::size_t count, std::uint32_t id = 7) {
    auto scan = std::make_shared<LidarScan>();
    const auto add = [&](const Eigen::Vector3f& p, std::uint32_t label, bool dynamic) {
      const auto i = static_cast<std::uint32_t>(truth.size());
      scan->returns.push_back({p, p.norm(), 0, 0, 0, i});
      truth.push_back(label);
      detection.object.push_back(dynamic ? 1 : 0);
      detection.trace.emplace_back();
    };
    for (std::size_t i = 0; i < count; ++i)
      add({10, 0.01F * static_cast<float>(i), 0}, kLabelDynamic | id << 16, i % 2 == 0);
    add({12, 0, -1}, kLabelStatic, true);
    add({40, 0, -1}, kLabelStatic, false);  // too far to be shown
    detection.scan = std::move(scan);
  }
};

TEST(MoverViews, KeepTheScanWithMostMovingPointsFoundOrNot) {
  MoverViews views;
  for (const auto& [scan, count] : {std::pair<std::size_t, std::size_t>{0, 40}, {1, 60}, {2, 50}}) {
    const Seen seen(count);
    views.add(scan, seen.detection, seen.truth);
  }
  ASSERT_EQ(views.views().size(), 1u);
  const MoverView& view = views.views().at(7);
  EXPECT_EQ(view.scan, 1u);
  EXPECT_EQ(view.moving_points, 60u);
  EXPECT_EQ(view.found_points, 30u);
  EXPECT_EQ(view.points.size(), 61u);
  EXPECT_NEAR(view.centre_v.x(), 10, 1e-4);
}

TEST(MoverViews, LeaveOutWhatHasTooFewPoints) {
  MoverViews views;
  const Seen seen(MoverViews::kFewestPoints - 1);
  views.add(0, seen.detection, seen.truth);
  EXPECT_TRUE(views.views().empty());
}

TEST(MoverViews, AGalleryShowsEveryClassBeforeItShowsOneTwice) {
  MoverViews views;
  const std::vector<std::size_t> counts = {90, 80, 70, 40};
  for (std::uint32_t id = 1; id <= 4; ++id) {
    const Seen seen(counts[id - 1], id);
    views.add(0, seen.detection, seen.truth);
  }
  const auto chosen = choose_for_gallery(views.views(), {{1, "car"}, {2, "car"}, {3, "car"}, {4, "dog"}}, 3);
  ASSERT_EQ(chosen.size(), 3u);
  EXPECT_EQ(chosen[0]->object_id, 1u);
  EXPECT_EQ(chosen[1]->object_id, 4u);
  EXPECT_EQ(chosen[2]->object_id, 2u);
}

TEST(MoverPicture, ColoursTellRightMissedAndFalse) {
  MoverView view;
  view.centre_v = {10, 0, 0};
  view.radius_m = 1;
  view.points = {{{10, 0, 0}, true, true, true, {}}};
  const auto middle = [&](bool moving, bool dynamic) {
    view.points[0].moving = moving;
    const Canvas canvas = draw_mover(view, 400, 300, 1, [dynamic](const ViewedPoint&) { return dynamic; });
    return canvas.pixel(200, 150);
  };
  const auto near = [](const Color& a, const Color& b) {
    return std::abs(a.red - b.red) + std::abs(a.green - b.green) + std::abs(a.blue - b.blue) < 60;
  };
  EXPECT_TRUE(near(middle(true, true), kRightColor));
  EXPECT_TRUE(near(middle(true, false), kMissedColor));
  EXPECT_TRUE(near(middle(false, true), kFalseColor));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
