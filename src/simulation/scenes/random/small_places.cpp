#include <algorithm>

#include "simulation/scenes/flyer_scene.hpp"
#include "simulation/scenes/random/draws.hpp"
#include "simulation/scenes/random/places.hpp"
#include "simulation/scenes/tunnel_scene.hpp"

namespace mapless::inline v1 {

Place draw_tunnel(SceneBuilder& scene, RandomSequence& random, std::uint64_t seed) {
  TunnelPlan plan;
  plan.half_width_m = random.uniform(2.2, 6);
  plan.height_m = random.uniform(2.9, 6.5);
  plan.swing_m = random.uniform(0.5, 8);
  plan.hills_m = random.uniform(0, 1.2);
  plan.boxes = random.uniform(0, 0.8);
  plan.people = draw_count(random, 8, 30);
  // Walkers step aside by up to 0.6 m; boxes reach 0.7 m from the wall.
  plan.last_way_m = plan.half_width_m - 1.4;
  plan.first_way_m = std::min(1.0, 0.6 * plan.last_way_m);
  plan.sensor_way_m = random.uniform(0.2, 0.6);
  plan.stop_every_s = random.uniform(9, 80);
  build_tunnel(plan, scene, seed);
  return {plan.terrain(), {}, tunnel_people(plan, seed)};
}

Place draw_hill(SceneBuilder& scene, RandomSequence& random, std::uint64_t seed) {
  HillPlan plan;
  plan.fall_per_m = random.uniform(0.0005, 0.004);
  plan.flyers = draw_count(random, 8, 24);
  plan.bushes = draw_count(random, 0, 40);
  plan.way_m = random.uniform(2.5, 5.5);  // flyers keep 7 m from the top
  build_hill(plan, scene, seed);
  return {plan.terrain(), {}, {hill_walker(plan)}};
}

}  // namespace mapless
