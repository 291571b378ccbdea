#include "simulation/object_states.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

// Half the time over which the velocity is a difference quotient, as in world.cpp.
constexpr Duration kHalfStep = Duration::from_nanoseconds(200'000);

AlignedBox3d box_of(const Mesh& mesh) {
  AlignedBox3d box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex.cast<double>());
  return box;
}

// Bounding box of all parts, along the axes of the body.
AlignedBox3d body_box(const Mover& mover, const std::vector<AlignedBox3d>& shape_boxes, Time t) {
  AlignedBox3d box;
  for (const Mover::Part& part : mover.parts) {
    const SE3 T_bs = part.T_bs ? part.T_bs(t) : SE3();
    for (int corner = 0; corner < 8; ++corner) {
      box.extend(T_bs *
                 Vector3d(shape_boxes[part.shape].corner(static_cast<AlignedBox3d::CornerType>(corner))));
    }
  }
  return box;
}

}  // namespace

ObjectStates::ObjectStates(const Scene& scene) : movers_(scene.world.movers), T_w0_(scene.T_w0) {
  for (const Mesh& mesh : scene.world.shapes) shape_boxes_.push_back(box_of(mesh));
}

ObjectState ObjectStates::state(const Mover& mover, Time t) const {
  const Vector3d moved_0 = mover.T_0b(t + kHalfStep).translation() - mover.T_0b(t - kHalfStep).translation();
  ObjectState out;
  out.time = t;
  out.centre_0 = T_w0_ * (mover.T_0b(t) * Vector3d(body_box(mover, shape_boxes_, t).center()));
  out.velocity_0 = T_w0_.rotation() * moved_0 / (2 * kHalfStep.seconds());
  out.speed_mps = out.velocity_0.norm();
  return out;
}

std::map<std::uint32_t, ObjectState> ObjectStates::of_visible(const SimulatedScan& scan, Time t) const {
  std::vector<bool> seen(1u << 16);
  for (const std::uint32_t label : scan.labels) seen[label >> 16] = true;
  std::map<std::uint32_t, ObjectState> out;
  for (const Mover& mover : movers_) {
    const auto id = static_cast<std::uint32_t>(mover.object_id);
    if (seen[id] && !mover.carries_sensor) out.emplace(id, state(mover, t));
  }
  return out;
}

}  // namespace mapless
