#include "simulation/scene_builder.hpp"

#include <utility>

namespace mapless::inline v1 {

std::size_t SceneBuilder::shape(const std::string& name, const std::function<Mesh()>& make) {
  const auto [found, fresh] = shapes_.try_emplace(name, world_.shapes.size());
  if (fresh) world_.shapes.push_back(make());
  return found->second;
}

void SceneBuilder::place(std::size_t shape, const SE3& T_0s, ObjectClass object_class, bool numbered) {
  world_.statics.push_back({shape, T_0s, object_class, numbered ? ++last_id_ : 0});
}

void SceneBuilder::add(Mover mover) {
  mover.object_id = ++last_id_;
  world_.movers.push_back(std::move(mover));
}

}  // namespace mapless
