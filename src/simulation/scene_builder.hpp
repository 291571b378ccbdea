#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

/// Collects the shapes and objects of a scene. A shape of a given name is made once and shared.
class SceneBuilder {
 public:
  /// Number of the shape `name`, which `make` builds at its first use.
  std::size_t shape(const std::string& name, const std::function<Mesh()>& make);
  /// Adds a static object; `numbered` gives it the next object id (a parked vehicle).
  void place(std::size_t shape, const SE3& T_0s, ObjectClass object_class, bool numbered = false);
  /// Adds the mover with the next object id.
  void add(Mover mover);
  [[nodiscard]] WorldDescription take() { return std::move(world_); }

 private:
  WorldDescription world_;
  std::map<std::string, std::size_t> shapes_;
  int last_id_ = 0;
};

}  // namespace mapless
