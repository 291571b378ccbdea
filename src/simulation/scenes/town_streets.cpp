#include <cmath>
#include <numbers>

#include "simulation/scenes/town.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector2d;

constexpr double kRight = std::numbers::pi / 2;
constexpr double kKerb = 0.13;

/// One block between four streets; `low` and `high` are its kerbs.
struct Block {
  Vector2d low, high;
};

std::vector<Block> blocks(const TownPlan& plan) {
  std::vector<Block> out;
  const Vector2d road = Vector2d::Constant(plan.half_road_m);
  // The outermost blocks lie beyond the outermost streets.
  for (int i = -1; i < plan.nx; ++i) {
    for (int j = -1; j < plan.ny; ++j) {
      const bool left = i < 0, right = i == plan.nx - 1, below = j < 0, above = j == plan.ny - 1;
      Block block{plan.junction(i, j) + road, plan.junction(i + 1, j + 1) - road};
      if (left) block.low.x() = -40;
      if (right) block.high.x() = (plan.nx - 1) * plan.dx_m + 40;
      if (below) block.low.y() = -40;
      if (above) block.high.y() = (plan.ny - 1) * plan.dy_m + 40;
      out.push_back(block);
    }
  }
  return out;
}

/// One side of a block, seen from its street: along x of the frame at `start`, the block to the left.
struct Frontage {
  Vector2d start;
  double angle;
  double length;
  [[nodiscard]] Vector2d at(double along, double inwards) const {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return start + Vector2d(c * along - s * inwards, s * along + c * inwards);
  }
};

std::vector<Frontage> frontages(const TownPlan& plan, const Block& b) {
  const double max_x = (plan.nx - 1) * plan.dx_m;
  const double max_y = (plan.ny - 1) * plan.dy_m;
  const Vector2d size = b.high - b.low;
  std::vector<Frontage> out;
  if (b.low.y() > 0) out.push_back({b.low, 0, size.x()});
  if (b.high.x() < max_x) out.push_back({{b.high.x(), b.low.y()}, kRight, size.y()});
  if (b.high.y() < max_y) out.push_back({b.high, 2 * kRight, size.x()});
  if (b.low.x() > 0) out.push_back({{b.low.x(), b.high.y()}, -kRight, size.y()});
  return out;
}

void build_houses(const TownPlan& plan, const Scenery& scenery, const Frontage& front,
                  RandomSequence& random) {
  const double line = plan.pavement_m + plan.front_garden_m;
  double along = line + 2;
  while (true) {
    const int variant = random.index(12);
    const double width = Scenery::house_width(variant);
    if (along + width > front.length - line - 12) break;
    if (random.chance(0.88)) {
      scenery.put_house(front.at(along + width / 2, line + random.uniform(0, 1.5)), front.angle, variant);
    } else {
      for (int k = 0; k < 3; ++k)
        scenery.put_tree(front.at(along + 3 * k + 1, line + random.uniform(1, 8)), random.index(6), along);
    }
    along += width + random.uniform(0.3, 6);
  }
}

void build_kerbside(const TownPlan& plan, const Scenery& scenery, const Frontage& front,
                    RandomSequence& random) {
  for (double along = 14; along < front.length - 14; along += 6) {
    if (random.chance(plan.fences))
      scenery.put_fence(front.at(along, plan.pavement_m + 0.2), front.angle, random.chance(0.4));
    if (random.chance(0.25))
      scenery.put_bush(front.at(along, plan.pavement_m + 1.5), random.index(4), random.uniform(0, 6));
    if (random.chance(0.22))
      scenery.put_tree(front.at(along + 2, 0.8), random.index(4), random.uniform(0, 6));
    if (random.chance(0.06)) scenery.put_sign(front.at(along + 4, 0.5), front.angle);
  }
  for (double along = 10; along < front.length - 8; along += 28)
    scenery.put_lamp(front.at(along, 0.6), front.angle);
  for (double along = 16; along < front.length - 18; along += 6.2) {
    if (!random.chance(plan.parked)) continue;
    const int variant = random.index(12);
    const bool turned = random.chance(0.15);
    const double aside = -0.95 - random.uniform(0, 0.1);
    scenery.put_parked(front.at(along + random.uniform(0, 0.8), aside),
                       front.angle + (turned ? 2 * kRight : 0) + random.uniform(-0.02, 0.02),
                       random.chance(0.12) ? ObjectClass::van : ObjectClass::car, variant);
  }
}

}  // namespace

Terrain TownPlan::terrain() const {
  return [height = hills_m](double x, double y) {
    return height * std::sin(x / 55 + 0.4) * std::cos(y / 48) + 0.3 * height * std::sin(y / 90);
  };
}

std::vector<Junction> TownPlan::junctions() const {
  std::vector<Junction> out;
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) out.push_back({junction(i, j), turn_m(), 7.0 * i + 13.0 * j});
  }
  return out;
}

void build_town(const TownPlan& plan, const Scenery& scenery, std::uint64_t seed) {
  SceneBuilder& scene = scenery.scene();
  const Terrain& terrain = scenery.terrain();
  const Vector2d far(plan.nx * plan.dx_m + 60, plan.ny * plan.dy_m + 60);
  const auto ground = scene.shape("ground", [&] {
    return ground_patch({-plan.dx_m - 60, -plan.dy_m - 60}, far, 0, 4, terrain, Material::asphalt);
  });
  scene.place(ground, SE3(), ObjectClass::ground);
  Mesh pavements;
  std::uint64_t number = 0;
  for (const Block& block : blocks(plan)) {
    pavements.append(ground_patch(block.low, block.high, kKerb, 4, terrain, Material::concrete), SE3());
    pavements.append(patch_edge(block.low, block.high, kKerb, 4, terrain, Material::concrete), SE3());
    for (const Frontage& front : frontages(plan, block)) {
      RandomSequence random(seed, 2000 + number++);
      build_houses(plan, scenery, front, random);
      build_kerbside(plan, scenery, front, random);
      scenery.put_traffic_light(front.at(0.5, 0.5), front.angle);
    }
  }
  scene.place(scene.shape("pavements", [&] { return pavements; }), SE3(), ObjectClass::ground);
}

}  // namespace mapless
