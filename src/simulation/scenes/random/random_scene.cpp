#include "simulation/scenes/named_scenes.hpp"
#include "simulation/scenes/random/draws.hpp"
#include "simulation/scenes/random/places.hpp"
#include "simulation/scenes/sensor_poses.hpp"
#include "simulation/traffic/agents.hpp"
#include "simulation/traffic/bodies.hpp"
#include "simulation/traffic/traffic.hpp"

namespace mapless::inline v1 {
namespace {

using Kind = Carrier::Kind;

enum class PlaceKind { town, road, grounds, tunnel, hill };

// Which carriers come to a place: no vehicles indoors, no drones among the flyers.
Kind draw_kind(RandomSequence& random, PlaceKind place) {
  switch (place) {
    case PlaceKind::town:
    case PlaceKind::road:
      return draw_one<Kind>(random, {{Kind::vehicle, 0.6},
                                     {Kind::robot, 0.08},
                                     {Kind::hand, 0.08},
                                     {Kind::back, 0.08},
                                     {Kind::tripod, 0.08},
                                     {Kind::drone, 0.08}});
    case PlaceKind::grounds:
      return draw_one<Kind>(random, {{Kind::robot, 0.25},
                                     {Kind::hand, 0.25},
                                     {Kind::back, 0.25},
                                     {Kind::tripod, 0.15},
                                     {Kind::drone, 0.1}});
    default:
      return draw_one<Kind>(random, {{Kind::robot, 0.3}, {Kind::hand, 0.4}, {Kind::back, 0.3}});
  }
}

Place draw_place(SceneBuilder& scene, RandomSequence& random, PlaceKind kind, const Carrier& carrier,
                 const SceneOptions& options) {
  switch (kind) {
    case PlaceKind::town:
      return draw_town(scene, random, carrier, options.seed);
    case PlaceKind::road:
      return draw_road(scene, random, carrier, options.seed);
    case PlaceKind::grounds:
      return draw_grounds(scene, random, carrier, options.seed, options.duration_s + kMargin_s);
    case PlaceKind::tunnel:
      return draw_tunnel(scene, random, options.seed);
    default:
      return draw_hill(scene, random, options.seed);
  }
}

// Moves those on foot who would start within 1.5 m of the sensor along their ways.
void clear_start(std::vector<RoadUser>& users) {
  const Eigen::Vector2d own = users.front().path->at(users.front().start_m);
  for (RoadUser& user : users) {
    if (&user == &users.front() || !on_foot(user.object_class)) continue;
    while ((user.path->at(user.start_m) - own).norm() < 1.5) user.start_m += 2;
  }
}

}  // namespace

Scene random_scene(const SceneOptions& options) {
  RandomSequence random(options.seed, 7000);
  const auto kind = draw_one<PlaceKind>(random, {{PlaceKind::town, 0.35},
                                                 {PlaceKind::road, 0.2},
                                                 {PlaceKind::grounds, 0.27},
                                                 {PlaceKind::tunnel, 0.1},
                                                 {PlaceKind::hill, 0.08}});
  const Carrier carrier = draw_carrier(random, draw_kind(random, kind));
  SceneBuilder builder;
  Place place = draw_place(builder, random, kind, carrier, options);
  RoadUser& first = place.users.front();
  if (carrier.kind == Kind::vehicle) {
    first.object_class = carrier.vehicle;
  } else {
    first.desired_speed = carrier.speed_mps;
  }
  clear_start(place.users);
  const double duration_s = options.duration_s + kMargin_s;
  std::shared_ptr<const Track> own;
  if (!carrier.in_traffic()) {
    own = drive_all({first}, {}, place.terrain, duration_s, options.seed).front();
    place.users.erase(place.users.begin());
  }
  const auto tracks = drive_all(place.users, place.junctions, place.terrain, duration_s, options.seed);
  add_movers(builder, place.users, tracks, carrier.in_traffic() ? 1 : 0);
  if (carrier.in_traffic()) own = tracks.front();
  const auto T_0b = body_motion(carrier, own);
  add_carrier(builder, carrier, T_0b);
  Scene scene;
  scene.poses = sample_poses([&](double t) { return T_0b(t) * carrier.T_bv; }, options.duration_s);
  scene.world = builder.take();
  return scene;
}

}  // namespace mapless
