// SPDX-License-Identifier: Apache-2.0
// The cells, axis by axis. Tanks of a few hundred particles: every wall, the surface and a body's inside are there.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <initializer_list>
#include <map>
#include <utility>

#include "stress/setup.hpp"

namespace runner {
namespace stress {

namespace {

using meltsim::Status;
using meltsim::Vec3d;
using meltsim::World;

std::string number(double v) { return fmt::format("{:g}", v); }

/// A block of n^3 in the middle, with its lower face at this height.
Block cube(double n, double floor, bool other = false) {
  Block b;
  b.low = {std::floor((8 - n) / 2), floor, std::floor((8 - n) / 2)};
  b.size = {n, n, n};
  b.other = other;
  return b;
}

Block part(Vec3d low, Vec3d size, bool other = false) {
  Block b;
  b.low = low;
  b.size = size;
  b.other = other;
  return b;
}

/// A tank of a cube alone, without liquid.
Setup dry(const std::string& axis, const std::string& value) {
  Setup s(axis, value);
  s.depth = 0;
  s.blocks = {cube(4, 2)};
  return s;
}

class Cells {
 public:
  std::deque<Setup> list;  ///< what add() returns stays where it is

  Setup& add(Setup setup) {
    list.push_back(std::move(setup));
    return list.back();
  }
  /// The default tank.
  Setup& add(const std::string& axis, const std::string& value) { return add(Setup(axis, value)); }

  template <class Set>
  void sweep(const std::string& axis, std::initializer_list<double> values, const Set& set) {
    for (const double v : values) set(add(axis, number(v)), v);
  }
};

void steps(Cells& c) {
  for (const double f : {0.001, 0.01, 0.1, 0.5, 1.0, 2.0, 10.0, 60.0, 100.0, 1000.0}) {
    c.add("step x stable", number(f)).step = f;
    Setup& s = c.add(dry("step x stable, solids", number(f)));
    s.step = f;
  }
  c.add("step x stable", "random").random_steps = true;
  c.add(dry("step x stable, solids", "random")).random_steps = true;
  c.sweep("courant", {1e-3, 0.1, 0.4, 0.6, 0.8}, [](Setup& s, double v) { s.world.courant = v; });
}

void liquid(Cells& c) {
  c.sweep("sound speed", {1e-6, 1e-3, 0.1, 1, 3, 5, 9, 12, 17, 30, 100, 1e3, 1e4, 1e5, 1e6},
          [](Setup& s, double v) { s.world.sound_speed = v; });
  for (const double v : {0.1, 3.0, 10.0, 100.0, 1e4}) {
    Setup& s = c.add(dry("sound speed, solids", number(v)));
    s.world.sound_speed = v;
  }
  c.sweep("viscosity", {0, 1e-6, 1e-3, 1, 1e2, 1e4, 1e6, 1e12},
          [](Setup& s, double v) { s.water.viscosity = v; });
  c.sweep("support", {1.4, 1.5, 1.6, 1.75, 1.9, 2, 2.25, 2.5, 3, 4, 5, 6, 6.1}, [](Setup& s, double v) {
    s.world.support_radius = v * s.world.spacing;
    s.width = std::max(8.0, std::ceil(2 * v));
    s.most_substeps = v > 3 ? 120 : 300;
  });
  c.sweep("gravity", {0, 1e-6, 1, 9.81, 100, 1e4, 1e8}, [](Setup& s, double v) {
    s.world.gravity = {0, -v, 0};
  });
  const double pi = std::acos(-1.0);
  for (const double degrees : {10.0, 30.0, 45.0, 90.0, 180.0}) {
    const double a = degrees * pi / 180;
    Setup& s = c.add("gravity tilted", number(degrees));
    s.world.gravity = Vec3d{std::sin(a), -std::cos(a), 0} * 9.81;
    Setup& solid = c.add(dry("gravity tilted, solids", number(degrees)));
    solid.world.gravity = s.world.gravity;
  }
  for (const double v : {1.0, 10.0, 100.0, 1000.0}) {
    Setup& s = c.add("jet", number(v));
    s.blocks.clear();
    s.mass = s.energy = s.ledger = false;
    s.speed = false;
    s.more = [v, dx = s.world.spacing](World& w) -> Status {
      meltsim::EmitterDesc e;
      e.material = {0, 1};
      e.center = Vec3d{4, 9, 4} * dx;
      e.radius = 1.2 * dx;
      e.speed = v;
      e.max_particles = 200;
      const auto r = w.add_emitter(e);
      return r ? Status{} : Status{r.error()};
    };
  }
}

void densities(Cells& c) {
  c.sweep("density, all", {1e-3, 1, 1e3, 1e6}, [](Setup& s, double v) {
    s.water.density = v;
    s.ice.density = 0.917 * v;
  });
  const auto ratios = {1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 4.0, 10.0, 100.0, 1e4};
  for (const double r : ratios) {
    Setup& falls = c.add("body/liquid density", number(r));
    falls.ice.density = r * 1000;
    falls.ice.melting_point = meltsim::infinity;
    // What liquid cannot stop squeezes it out: a film h thick leaves below a cube 4 spacings wide with 4/(4h) times its speed, if
    // volume is kept. The last particles of it are between a quarter and half a spacing of film.
    if (r >= 10) falls.most_falls = 4;
    Setup& within = c.add("body/liquid, immersed", number(r));
    if (r >= 10) within.most_falls = 4;
    within.ice.density = r * 1000;
    within.ice.melting_point = meltsim::infinity;
    within.depth = 8;
    within.blocks = {cube(3, 2)};
    Setup& melts = c.add("solid/melt density", number(r));
    melts.ice.density = r * 1000;
    melts.ice.latent_heat = 100;
    melts.world.heat.time_scale = 1e4;
    melts.water_temperature = 80;
    melts.blocks = {cube(3, 3)};
    melts.times = 10;
    Setup& inside = c.add("solid/melt, immersed", number(r));
    inside.ice.density = r * 1000;
    inside.ice.latent_heat = 1e4;
    inside.world.heat.time_scale = 3e5;
    inside.water_temperature = 80;
    inside.depth = 8;
    inside.blocks = {cube(4, 2)};
    inside.height = 24;  // there is room for what expands
  }
  for (const double r : {1e-4, 1e-2, 0.1, 0.5, 2.0, 10.0, 100.0, 1e4}) {
    Setup& s = c.add("upper/lower liquid", number(r));
    s.blocks.clear();
    s.other_liquid = true;
    s.other.density = 1000 * r;
    s.other_depth = 4;
    Setup& b = c.add(dry("upper/lower body", number(r)));
    b.other.density = 917 * r;
    b.blocks = {cube(3, 0), cube(3, 4, true)};
  }
}

void heat(Cells& c) {
  c.sweep("conductivity", {0, 1e-15, 1e-6, 1e-3, 1, 1e3, 1e6, 1e9, 1e12},
          [](Setup& s, double v) { s.water.conductivity = s.ice.conductivity = v; });
  for (const double v : {1e3, 1e6, 1e9, 1e12}) {
    Setup& s = c.add("conductivity contrast", number(v * 1e3));
    s.water.conductivity = 1e-3;
    s.ice.conductivity = v;
    s.blocks = {cube(3, 3)};
  }
  c.sweep("water temperature", {-300, -273.15, -100, 0, 100, 1e3, 1e6, 1e12}, [](Setup& s, double v) {
    s.water_temperature = v;
    s.blocks = {cube(3, 3)};
  });
  c.sweep("ice temperature", {-273.16, -273.15, -100, 0, 1e3, 1e6}, [](Setup& s, double v) {
    s.ice_temperature = v;
    s.blocks = {cube(3, 3)};
  });
  c.sweep("time scale", {0, 1, 1e3, 1e6, 1e9, 1e12, 1e15}, [](Setup& s, double v) {
    s.world.heat.time_scale = v;
    s.water_temperature = 80;
    s.blocks = {cube(3, 3)};
  });
  c.sweep("latent heat", {0, 1, 3.34e5, 1e10, 1e15}, [](Setup& s, double v) {
    s.ice.latent_heat = v;
    s.world.heat.time_scale = 1e4;
    s.water_temperature = 80;
    s.blocks = {cube(3, 3)};
  });
  for (const double source : {-1e15, -1e12, -1e6, 1e6, 1e12, 1e15}) {
    Setup& s = c.add("heat source", number(source));
    s.bounded_heat = false;
    s.more = [source, dx = s.world.spacing](World& w) -> Status {
      meltsim::HeatRegionDesc r;
      r.shape = meltsim::Shape::box({0, 0, 0}, Vec3d{8, 2, 8} * dx);
      r.source = source;
      const auto added = w.add_heat_region(r);
      return added ? Status{} : Status{added.error()};
    };
  }
  {
    Setup& s = c.add("melting", "in one step");
    s.world.heat.time_scale = 1e9;
    s.ice.latent_heat = 10;
    s.water_temperature = 1e4;
    s.depth = 6;
    s.blocks = {cube(3, 2)};
    s.all_melts = true;
  }
  {
    Setup& s = c.add("melting", "in the air");
    s.depth = 0;
    s.blocks = {cube(4, 4)};
    s.ice_temperature = 50;  // hotter than its melting point
    s.all_melts = true;
  }
  {
    Setup& s = c.add("melting", "chain");
    s.blocks = {part({0, 4, 4}, {8, 1, 1})};
    s.water_temperature = 90;
    s.world.heat.time_scale = 1e5;
    s.ice.latent_heat = 1e4;
  }
  {
    Setup& s = c.add("melting", "plate");
    s.blocks = {part({1, 4, 1}, {6, 1, 6})};
    s.water_temperature = 90;
    s.world.heat.time_scale = 1e5;
    s.ice.latent_heat = 1e4;
  }
  {
    Setup& s = c.add("melting", "and freezing");
    s.ice.freezes = true;
    s.ice.latent_heat = 1e3;
    s.world.heat.time_scale = 1e6;
    s.bounded_heat = false;
    s.depth = 6;
    s.blocks = {cube(3, 2)};
    s.more = [dx = s.world.spacing](World& w) -> Status {
      for (int k = 0; k < 8; ++k) {
        meltsim::HeatRegionDesc r;
        r.name = fmt::format("r{}", k);
        r.shape = meltsim::Shape::box({0, 0, 0}, Vec3d{8, 14, 8} * dx);
        r.temperature = k % 2 == 0 ? 60 : -60;
        r.from = 0.1 * k;
        r.until = 0.1 * (k + 1);
        const auto added = w.add_heat_region(r);
        if (!added) return added.error();
      }
      return {};
    };
  }
}

void scales(Cells& c) {
  c.sweep("spacing", {1e-9, 1e-6, 1e-4, 1e-2, 1, 100, 1e4, 1e6}, [](Setup& s, double v) {
    s.world.spacing = v;
    s.world.heat.time_scale = 0;
  });
  for (const double x : {0.0, 10.0, 1e3, 1e5, 1e7, 1e9, 1e15}) {
    Setup& s = c.add("coordinates", number(x));
    s.corner = {x, 0, -x};
    Setup& small = c.add("coordinates, spacing 0.01", number(x));
    small.world.spacing = 0.01;
    small.corner = {x, 0, -x};
  }
}

void bodies(Cells& c) {
  for (const int w : {0, 1, 2, 3, 4, 5, 6, 7, 8}) {
    Setup& s = c.add("half-width w", number(w));
    s.ice.region_half_width = w;
    Setup& d = c.add(dry("half-width w, solids", number(w)));
    d.ice.region_half_width = w;
  }
  for (const double e : {1.0, 1e3, 1e6, 1e9, 1e12, 1e15}) {
    c.add("modulus", number(e)).ice.youngs_modulus = e;
    c.add(dry("modulus, solids", number(e))).ice.youngs_modulus = e;
  }
  c.sweep("stiffness", {1e-6, 1e-3, 0.1, 1}, [](Setup& s, double v) { s.ice.stiffness = v; });
  c.sweep("damping", {0, 0.1, 1}, [](Setup& s, double v) { s.ice.damping = v; });
  c.sweep("friction", {0, 0.3, 1e6},
          [](Setup& s, double v) { s.ice.friction = s.world.domain.friction = v; });
  for (const double spin : {1.0, 10.0, 100.0, 1e3, 1e4}) {
    Setup& s = c.add(dry("spin [rad/s]", number(spin)));
    s.blocks = {cube(3, 6)};
    s.blocks[0].spin = {0, spin, 0.5 * spin};
    s.world.gravity = {0, 0, 0};
    s.walls = false;
    s.momentum = true;
  }
  for (const double v : {1.0, 10.0, 100.0, 1e3, 1e5}) {
    Setup& s = c.add(dry("thrown at a wall [m/s]", number(v)));
    s.blocks = {cube(3, 6)};
    s.blocks[0].velocity = {v, -0.3 * v, 0.1 * v};
  }
  for (const double v : {0.1, 1.0, 10.0}) {  // a piston presses a body against the far wall, and goes on
    Setup& s = c.add(dry("pressed into a wall [m/s]", number(v)));
    s.energy = s.speed = false;
    s.blocks = {part({4, 0, 2}, {3, 3, 3}), part({1, 0, 2}, {2, 3, 3}, true)};
    s.blocks[1].motion = meltsim::Motion::kinematic;
    s.blocks[1].velocity = {v, 0, 0};
    s.most_substeps = 600;
  }
  for (const int n : {0, 1, 2, 27}) {
    Setup& s = c.add("particles", number(n));
    s.blocks.clear();
    s.depth = 0;
    if (n == 0) continue;
    s.more = [n, dx = s.world.spacing](World& w) -> Status {
      const double side = n == 27 ? 3 : 1;
      meltsim::FluidDesc f;
      f.material = {0, 1};
      f.shape =
          meltsim::Shape::box(Vec3d{3, 3, 3} * dx, Vec3d{3 + (n == 2 ? 2 : side), 3 + side, 3 + side} * dx);
      const auto added = w.add_fluid(f);
      return added ? Status{} : Status{added.error()};
    };
  }
  const std::pair<const char*, Vec3d> shapes[] = {
      {"site", {1, 1, 1}},  {"pair", {2, 1, 1}},  {"chain", {7, 1, 1}}, {"pole", {1, 6, 1}},
      {"plate", {6, 1, 6}}, {"sheet", {6, 6, 1}}, {"cube", {3, 3, 3}}};
  for (const auto& shape : shapes) {
    Setup& wet = c.add("shape of a body", shape.first);
    wet.blocks = {part({1, 5, 1}, shape.second)};
    Setup& d = c.add(dry("shape of a body, solids", shape.first));
    d.blocks = {part({1, 3, 1}, shape.second)};
  }
  for (const int n : {8, 64, 1000}) {
    Setup& s = c.add(dry("bodies", number(n)));
    const int side = static_cast<int>(std::lround(std::cbrt(n)));
    s.width = 2 * side + 2;
    s.height = 2 * side + 4;
    s.blocks.clear();
    for (int k = 0; k < n; ++k)
      s.blocks.push_back(
          part({1.0 + 2 * (k % side), 1.0 + 2 * (k / side % side), 1.0 + 2 * (k / side / side)}, {1, 1, 1}));
    s.most_substeps = n == 1000 ? 100 : 300;
  }
  {
    Setup& s = c.add(dry("bodies", "fills the tank"));
    s.blocks = {part({0, 0, 0}, {8, 6, 8})};
  }
  {
    Setup& s = c.add("bodies", "fills the tank, wet");
    s.blocks = {part({0, 4, 0}, {8, 3, 8})};
  }
  for (const double n : {1e4, 1e6}) {
    Setup& s = c.add("sub-steps", number(n));
    s.long_one = n > 1e5;
    if (!s.long_one) {  // the long one is the usual tank
      s.depth = 0;
      s.blocks = {cube(2, 1)};
    }
    s.times = 1e9;
    s.most_substeps = static_cast<std::uint64_t>(n);
    s.step = 50;
  }
}

}  // namespace

Setup::Setup(std::string of_axis, std::string of_value)
    : axis(std::move(of_axis)), value(std::move(of_value)) {
  water.name = "water";
  ice.name = "ice";
  ice.density = 917;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = 3.34e5;
  other.name = "other";
  blocks = {cube(3, 5)};
  world.threads = 1;
}

std::vector<Setup> all_cells() {
  Cells cells;
  steps(cells);
  liquid(cells);
  densities(cells);
  heat(cells);
  scales(cells);
  bodies(cells);
  std::map<std::string, std::size_t> first;  // axes in the order in which they come first
  for (const Setup& s : cells.list) first.emplace(s.axis, first.size());
  std::vector<Setup> all(cells.list.begin(), cells.list.end());
  std::stable_sort(all.begin(), all.end(),
                   [&](const Setup& a, const Setup& b) { return first.at(a.axis) < first.at(b.axis); });
  return all;
}

}  // namespace stress
}  // namespace runner
