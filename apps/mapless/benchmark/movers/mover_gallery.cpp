#include "benchmark/movers/mover_gallery.hpp"

#include <set>
#include <utility>

#include <fmt/format.h>

#include "benchmark/movers/mover_picture.hpp"
#include "reports/json.hpp"

namespace mapless::app {
namespace {

using Classes = std::map<std::uint32_t, std::string>;

constexpr std::size_t kGallery = 8;
constexpr int kWidth = 480, kHeight = 360;

Classes classes_of(const ObjectTruth& objects) {
  Classes classes;
  for (const auto& [id, description] : objects.descriptions) classes[id] = description.object_class;
  return classes;
}

// The vehicle with most points in its view; without vehicles, the mover with most points.
const MoverView* mover_for_cascade(const std::map<std::uint32_t, MoverView>& views, const Classes& classes) {
  static const std::set<std::string> kVehicles = {"car", "van", "truck", "bus"};
  const auto rank = [&](const MoverView& view) {
    const auto name = classes.find(view.object_id);
    return std::pair(name != classes.end() && kVehicles.contains(name->second), view.moving_points);
  };
  const MoverView* best = nullptr;
  for (const auto& [id, view] : views) {
    if (best == nullptr || rank(view) > rank(*best)) best = &view;
  }
  return best;
}

std::string share_text(std::size_t some, std::size_t of) {
  return fmt::format("{} of {} moving points found", some, of);
}

Json gallery_picture(const MoverView& view, const Classes& classes, const std::filesystem::path& folder,
                     const std::string& name) {
  const std::string file = fmt::format("{}.gallery_{}.png", name, view.object_id);
  draw_mover(view, kWidth, kHeight, 1.2F, [](const ViewedPoint& p) {
    return p.dynamic;
  }).write_png(folder / file);
  const auto known = classes.find(view.object_id);
  return {{"file", file},
          {"kind", "gallery"},
          {"caption",
           fmt::format("{}, {:.0f} m away, scan {}: {}", known == classes.end() ? "mover" : known->second,
                       view.centre_v.norm(), view.scan, share_text(view.found_points, view.moving_points))}};
}

Json cascade_picture(const MoverView& view, Stage stage, std::string_view stage_name,
                     const std::filesystem::path& folder, const std::string& name) {
  const auto number = static_cast<std::size_t>(stage);
  const std::string file = fmt::format("{}.cascade_{}.png", name, number + 1);
  const auto dynamic = [stage](const ViewedPoint& p) { return dynamic_after(p.trace, stage); };
  draw_mover(view, kWidth, kHeight, MoverView::kSurroundings * 0.55F, dynamic).write_png(folder / file);
  std::size_t found = 0, wrong = 0;
  for (const ViewedPoint& p : view.points) {
    found += p.moving && dynamic(p) ? 1 : 0;
    wrong += p.known && !p.moving && dynamic(p) ? 1 : 0;
  }
  return {{"file", file},
          {"kind", "cascade"},
          {"caption", fmt::format("{}. {}: {}, {} false", number + 1, stage_name,
                                  share_text(found, view.moving_points), wrong)}};
}

}  // namespace

Json draw_gallery(const MoverViews& views, const StageNames& stages, const ObjectTruth& objects,
                  const std::filesystem::path& folder, const std::string& name) {
  const Classes classes = classes_of(objects);
  Json pictures = Json::array();
  for (const MoverView* view : choose_for_gallery(views.views(), classes, kGallery))
    pictures.push_back(gallery_picture(*view, classes, folder, name));
  if (const MoverView* mover = mover_for_cascade(views.views(), classes)) {
    for (std::size_t s = 0; s < kStageCount; ++s)
      pictures.push_back(cascade_picture(*mover, static_cast<Stage>(s), stages.at(s), folder, name));
  }
  return pictures;
}

}  // namespace mapless::app
