#pragma once

#include "simulation/traffic/agents.hpp"

namespace mapless::inline v1 {

/// True if the light is green at `t_s` for traffic along x, or along y.
[[nodiscard]] bool is_green(const Junction& junction, bool along_x, double t_s);

/// True if vehicle `i` may enter its next passage at `t_s`: its light is green; no vehicle with the right of
/// way has a conflicting path; when it turns left, no vehicle is oncoming (unless it has waited for 12 s); no
/// vehicle waits ahead of it; there is room for it beyond the junction. Vehicles with the right of way can
/// therefore not block each other.
[[nodiscard]] bool may_enter(const std::vector<Agent>& agents, std::size_t i,
                             const std::vector<Junction>& junctions, double t_s);

/// True if pedestrian `i` may step onto the street at `t_s`: the light has been green for less than 6 s, and
/// no vehicle with the right of way through the junction is about to cross the pedestrian's path.
[[nodiscard]] bool may_cross(const std::vector<Agent>& agents, std::size_t i,
                             const std::vector<Junction>& junctions, double t_s);

/// True if both vehicles enter the same junction from the same street.
[[nodiscard]] bool same_approach(const Agent& a, const Agent& b);

}  // namespace mapless
