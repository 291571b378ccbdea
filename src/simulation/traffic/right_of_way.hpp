#pragma once

#include "simulation/traffic/agents.hpp"

namespace mapless::inline v1 {

/// Whether the light shows green to those who come along x, or along y, at `t_s`.
[[nodiscard]] bool is_green(const Junction& junction, bool along_x, double t_s);

/// Whether vehicle `i` may enter its next passage now: its light is green, nobody whose way meets its own has
/// the right of way, nobody comes towards it as it turns left (unless it has waited for long), nobody waits
/// ahead of it, and it finds room beyond. Those who have the right of way can so never block each other.
[[nodiscard]] bool may_enter(const std::vector<Agent>& agents, std::size_t i,
                             const std::vector<Junction>& junctions, double t_s);

/// Whether walker `i` may step onto the street now: his light has been green for a short while, and no
/// vehicle on its way through the junction is about to pass there.
[[nodiscard]] bool may_cross(const std::vector<Agent>& agents, std::size_t i,
                             const std::vector<Junction>& junctions, double t_s);

/// Whether both come into the same junction from the same street.
[[nodiscard]] bool same_approach(const Agent& a, const Agent& b);

}  // namespace mapless
