#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "core/argument_checks.hpp"
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

// Finer shapes than this many facets around only cost memory.
constexpr int kMaxFacets = 10'000;
constexpr double kMaxSize_m = 1e5;  // the terrain of the largest scene is 2.2 km wide

Vector3d around(const Vector3d& centre, const Vector3d& u, const Vector3d& v, double radius, double angle) {
  return centre + radius * (std::cos(angle) * u + std::sin(angle) * v);
}

}  // namespace

float reflectivity(Material material) {
  // By Material. Chosen for a realistic order of materials; they set the intensities, and which far and
  // grazed surfaces give no return.
  constexpr std::array<float, 11> kReflectivity = {.12f, .25f, .40f, .35f, .45f, .35f,
                                                   .60f, .50f, .05f, .08f, .40f};
  return kReflectivity[static_cast<std::size_t>(material)];
}

void Mesh::add_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, Material m) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (const Vector3d& p : {a, b, c}) vertices.emplace_back(p.cast<float>());
  triangles.emplace_back(first, first + 1, first + 2);
  materials.push_back(m);
}

void Mesh::add_quad(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d, Material m) {
  add_triangle(a, b, c, m);
  add_triangle(a, c, d, m);
}

void Mesh::add_box(const Vector3d& lowest, const Vector3d& highest, Material m) {
  const auto corner = [&](int i) {
    return Vector3d(i & 1 ? highest.x() : lowest.x(), i & 2 ? highest.y() : lowest.y(),
                    i & 4 ? highest.z() : lowest.z());
  };
  constexpr std::array<std::array<int, 4>, 6> kFaces = {
      {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}}};
  for (const auto& f : kFaces) add_quad(corner(f[0]), corner(f[1]), corner(f[2]), corner(f[3]), m);
}

void Mesh::add_frustum(const Vector3d& base, double base_radius_m, const Vector3d& tip, double tip_radius_m,
                       int sides, Material m) {
  require_between("Mesh::add_frustum", "sides", sides, 3, kMaxFacets);
  require_between("Mesh::add_frustum", "base_radius_m", base_radius_m, 0, kMaxSize_m);
  require_between("Mesh::add_frustum", "tip_radius_m", tip_radius_m, 0, kMaxSize_m);
  require_between("Mesh::add_frustum", "length_m", (tip - base).norm(), std::numeric_limits<double>::min(),
                  kMaxSize_m);
  const Vector3d axis = (tip - base).normalized();
  const Vector3d u = axis.unitOrthogonal();
  const Vector3d v = axis.cross(u);
  const double step = 2 * std::numbers::pi / sides;
  for (int i = 0; i < sides; ++i) {
    const Vector3d a = around(base, u, v, base_radius_m, i * step);
    const Vector3d b = around(base, u, v, base_radius_m, (i + 1) * step);
    const Vector3d c = around(tip, u, v, tip_radius_m, (i + 1) * step);
    const Vector3d d = around(tip, u, v, tip_radius_m, i * step);
    add_quad(a, b, c, d, m);
    add_triangle(base, a, b, m);
    add_triangle(tip, d, c, m);
  }
}

void Mesh::add_extrusion(const std::vector<Eigen::Vector2d>& outline_xz, double half_width_m, Material m) {
  const std::size_t n = outline_xz.size();
  require_between("Mesh::add_extrusion", "points of the outline", static_cast<double>(n), 3, kMaxFacets);
  require_between("Mesh::add_extrusion", "half_width_m", half_width_m, 0, kMaxSize_m);
  const auto at = [&](std::size_t i, double y) {
    return Vector3d(outline_xz[i % n].x(), y, outline_xz[i % n].y());
  };
  for (std::size_t i = 0; i < n; ++i) {
    add_quad(at(i, -half_width_m), at(i + 1, -half_width_m), at(i + 1, half_width_m), at(i, half_width_m), m);
    if (i == 0 || i + 1 == n) continue;
    for (const double y : {-half_width_m, half_width_m}) add_triangle(at(0, y), at(i, y), at(i + 1, y), m);
  }
}

void Mesh::add_ellipsoid(const Vector3d& centre, const Vector3d& radii_m, int rings, Material m) {
  require_between("Mesh::add_ellipsoid", "rings", rings, 2, kMaxFacets);
  const auto at = [&](int ring, int sector) {
    const double polar = std::numbers::pi * ring / rings;
    const double azimuth = std::numbers::pi * sector / rings;
    const Vector3d unit(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                        std::cos(polar));
    return Vector3d(centre + radii_m.cwiseProduct(unit));
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int s = 0; s < 2 * rings; ++s) {
      add_quad(at(ring, s), at(ring, s + 1), at(ring + 1, s + 1), at(ring + 1, s), m);
    }
  }
}

void Mesh::append(const Mesh& other, const SE3& T_here_other) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (const Eigen::Vector3f& p : other.vertices)
    vertices.emplace_back((T_here_other * p.cast<double>()).cast<float>());
  for (const auto& t : other.triangles) triangles.emplace_back((t.array() + first).matrix());
  materials.insert(materials.end(), other.materials.begin(), other.materials.end());
}

}  // namespace mapless
