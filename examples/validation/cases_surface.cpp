// SPDX-License-Identifier: Apache-2.0
// Surfaces of particles whose shape is known.
#include <cmath>
#include <map>

#include "run.hpp"

namespace validation {
namespace {

using namespace meltsim;

struct Size {
  double volume = 0, area = 0;
  double open_edges = 0;  ///< not between two triangles of opposite direction
  int euler = 0;          ///< of everything: 2 per closed ball
};

Size size_of(const SurfaceMesh& m) {
  Size s;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (std::size_t t = 0; t + 2 < m.triangles.size(); t += 3) {
    const std::uint32_t* v = m.triangles.data() + t;
    const Vec3d a = cast<double>(m.position[v[0]]), b = cast<double>(m.position[v[1]]),
                c = cast<double>(m.position[v[2]]);
    s.volume += dot(a, cross(b, c)) / 6;
    s.area += 0.5 * length(cross(b - a, c - a));
    for (int k = 0; k < 3; ++k) ++sides[{v[k], v[(k + 1) % 3]}];
  }
  for (const auto& [side, count] : sides) {
    const auto other = sides.find({side.second, side.first});
    if (count != 1 || other == sides.end() || other->second != 1) ++s.open_edges;
  }
  s.euler = static_cast<int>(m.position.size()) - static_cast<int>(sides.size() / 2) +
            static_cast<int>(m.triangles.size() / 3);
  return s;
}

const char* name_of(SurfaceKernel k) { return k == SurfaceKernel::isotropic ? "isotropic" : "anisotropic"; }

WorldDesc free_space(const Settings& s, double spacing) {
  WorldDesc d = world_desc(s);
  d.spacing = spacing;
  d.gravity = {};
  d.sound_speed = 20;
  return d;
}

void sphere(const Settings& s, Report& r) {
  constexpr double dx = 0.1;
  const WorldDesc d = free_space(s, dx);
  for (const double cells : {5.0, 10.0, 20.0}) {
    const double R = cells * dx;
    Run run(d, r);
    run.fluid(Shape::sphere({0.031, 0.017, 0.042}, R), run.material("water", 1000, 1e-3));
    for (const SurfaceKernel kernel : {SurfaceKernel::isotropic, SurfaceKernel::anisotropic}) {
      SurfaceDesc desc;
      desc.kernel = kernel;
      const Size size = size_of(run.surface(desc));
      if (!run.good()) return;
      char where[64];
      std::snprintf(where, sizeof where, ", R = %g dx, %s", cells, name_of(kernel));
      const bool small = cells < 10;
      r.relative(std::string("volume") + where, size.volume, 4.0 / 3 * pi * R * R * R, small ? 4 : 2,
                 small ? "the sphere's own particles are 1 % too few or many" : "the target");
      r.relative(std::string("area") + where, size.area, 4 * pi * R * R, small ? 5 : 3,
                 small ? "steps of the lattice are a tenth of the radius" : "the target");
      r.absolute(std::string("edges not between two triangles") + where, size.open_edges, 0, 0, "-",
                 "closed by construction");
      r.absolute(std::string("Euler characteristic") + where, size.euler, 2, 0, "-", "one ball");
    }
  }
}

void tank(const Settings& s, Report& r) {
  constexpr double dx = 0.05;
  WorldDesc d = box(s, dx, {20, 20, 20}, Face::wall, Face::wall, Face::wall);
  Run run(d, r);
  const MaterialId water = run.material("water", 1000, 1e-3);
  run.fluid(Shape::box({0, 0, 0}, {1, 0.5, 1}), water);
  if (!run.to(6, 0.02)) return;  // its lattice dissolves after 2 to 4 s
  for (const SurfaceKernel kernel : {SurfaceKernel::isotropic, SurfaceKernel::anisotropic}) {
    SurfaceDesc desc;
    desc.kernel = kernel;
    const SurfaceMesh m = run.surface(desc);
    if (!run.good()) return;
    double high = 0, low = 1, at_wall = 0;
    for (const Vec3f& p : m.position) {
      const double x = static_cast<double>(p.x), y = static_cast<double>(p.y), z = static_cast<double>(p.z);
      at_wall = std::max({at_wall, -x, x - 1, -y, -z, z - 1});
      if (y < 0.4 || x < 3 * dx || x > 1 - 3 * dx || z < 3 * dx || z > 1 - 3 * dx) continue;
      high = std::max(high, y);
      low = std::min(low, y);
    }
    const std::string which = std::string(", ") + name_of(kernel);
    r.relative("volume of a tank at rest" + which, size_of(m).volume, 0.5, 2, "the target for a sphere");
    r.absolute("height of bumps of a surface at rest" + which, (high - low) / dx, 0, 0.2, "dx",
               "particles at rest are nearly a lattice; bumps that can be seen are larger");
    r.absolute("how far it reaches through a wall" + which, at_wall / dx, 0, 1e-4, "dx", "rounding");
  }
}

}  // namespace

std::vector<Case> surface_cases() {
  return {
      {"surface.sphere", "spheres of liquid on a lattice", "4/3 pi R^3, 4 pi R^2", false, sphere},
      {"surface.tank", "ten layers of water after 6 s", "the box they fill", false, tank},
  };
}

}  // namespace validation
