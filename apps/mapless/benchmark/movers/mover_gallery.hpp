#pragma once

#include <filesystem>
#include <string>

#include "benchmark/movers/mover_views.hpp"
#include "reports/json.hpp"
#include <mapless/io/labels.hpp>

namespace mapless::app {

/// Draws a gallery of the moving objects, and the five stages around one vehicle (another object if none),
/// as PNG files whose names begin with `name`. Returns a list of {file, kind ("gallery" or "cascade"),
/// caption}. `objects` has their classes.
[[nodiscard]] Json draw_gallery(const MoverViews& views, const StageNames& stages, const ObjectTruth& objects,
                                const std::filesystem::path& folder, const std::string& name);

}  // namespace mapless::app
