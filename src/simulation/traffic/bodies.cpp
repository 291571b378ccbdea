#include "simulation/traffic/bodies.hpp"

#include "simulation/traffic/living.hpp"
#include "simulation/traffic/vehicles.hpp"

namespace mapless::inline v1 {

void add_movers(SceneBuilder& scene, const std::vector<RoadUser>& users,
                const std::vector<std::shared_ptr<const Track>>& tracks, std::size_t first) {
  for (std::size_t i = first; i < users.size(); ++i) {
    const int variant = static_cast<int>(i);
    switch (users[i].object_class) {
      case ObjectClass::person:
        add_person(scene, variant, tracks[i]);
        break;
      case ObjectClass::dog:
        add_dog(scene, tracks[i]);
        break;
      case ObjectClass::cyclist:
      case ObjectClass::motorcycle:
        add_cyclist(scene, users[i].object_class, tracks[i]);
        break;
      default:
        add_vehicle(scene, users[i].object_class, variant, tracks[i]);
    }
  }
}

}  // namespace mapless
