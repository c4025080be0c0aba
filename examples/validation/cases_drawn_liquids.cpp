// SPDX-License-Identifier: Apache-2.0
// Cases drawn at random, continued: liquids that thin and thicken, species, surface tension, vessels that turn. As in cases_drawn.cpp,
// a target is what the order of the method says at the coarsest draw.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drawn.hpp"

namespace validation {
namespace {

const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// A box that is long, or whatever else, along one axis, and periodic across it.
WorldDesc along(const Settings& s, double dx, int axis, int cells) {
  Vec3i n{8, 8, 8};
  (axis == 0 ? n.x : axis == 1 ? n.y : n.z) = cells;
  std::array<Face, 3> faces{Face::periodic, Face::periodic, Face::periodic};
  faces[static_cast<std::size_t>(axis)] = Face::wall;
  WorldDesc d = box(s, dx, n, faces[0], faces[1], faces[2]);
  d.gravity = {};
  return d;
}

/// A power-law liquid pulled along two plates, in any of the six orientations, when its profile has come to rest:
/// u = u_max (1 - |y/h|^(1 + 1/n)), y from the middle.
Outcome pulled(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-4, 0.1), density = dice.log(100, 10000), index = dice.uniform(0.5, 1.6),
               speed = dice.log(0.1, 10) * dx, reynolds = dice.log(0.03, 1);
  const int layers = dice.whole(16, 24), across = dice.whole(0, 2), way = dice.coin() ? 1 : -1;
  const int with = (across + dice.whole(1, 2)) % 3;
  const double h = 0.5 * layers * dx, nu = speed * h / reynolds;
  Outcome o{
      0, text("n %.3g, %.0f layers, Re %.3g, across %.0f along %.0f", index, layers, reynolds, across, with)};
  WorldDesc d = along(s, dx, across, layers);
  d.sound_speed = 20 * speed;
  MaterialDesc m;
  m.name = "paste";
  m.density = density;
  m.viscosity = density * nu / std::pow(speed / h, index - 1);
  m.flow_index = index;
  const double pull = m.viscosity * std::pow(speed * (index + 1) / index, index) / std::pow(h, index + 1);
  d.gravity = axes[with] * (way * pull / density);
  Run run(d, report);
  run.fluid(Shape::box({0, 0, 0}, d.domain.max), run.material(m));
  if (!run.to(6 * h * h / nu)) return o;
  const ParticleData p = run.particles();
  std::vector<double> sum(static_cast<std::size_t>(layers)), count(sum);
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const double y = dot(p.position[i], axes[across]) / dx;
    const auto k = static_cast<std::size_t>(std::clamp(y, 0.0, layers - 1.0));
    sum[k] += way * dot(p.velocity[i], axes[with]) / speed;
    count[k] += 1;
  }
  for (std::size_t k = 0; k < sum.size(); ++k) {
    const double y = std::fabs((static_cast<double>(k) + 0.5) * dx / h - 1);
    o.error = std::max(o.error,
                       100 * std::fabs(sum[k] / std::max(1.0, count[k]) - (1 - std::pow(y, 1 + 1 / index))));
  }
  return o;
}

void power_law(const Settings& s, Report& r) {
  spread(s, r, "profile of a power-law liquid", 5, "% of the speed",
         "second order: 3 % at 20 layers, as in flow.power_law", pulled);
}

/// A species between two half spaces that hold different shares of it: erfc of the distance over 2 sqrt(D t), along any axis.
Outcome diffused(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-4, 0.1), density = dice.log(300, 8000), diffusivity = dice.log(1e-10, 1e-4),
               left = dice.uniform(0, 1), right = dice.uniform(0, 1), spread = dice.uniform(4, 7),
               pace = dice.log(0.05, 2);
  const int axis = dice.whole(0, 2), half = static_cast<int>(std::ceil(4.5 * spread));
  Outcome o{0, text("shares %.3f and %.3f, sqrt(D t) %.2f dx, D dt/dx^2 %.3g, axis %.0f, D %.3g, dx %.3g",
                    left, right, spread, pace, axis, diffusivity, dx)};
  WorldDesc d = along(s, dx, axis, 2 * half);
  const double dt = 0.01 * dx;
  d.sound_speed = 1;
  d.heat.model = HeatModel::none;
  d.solute.time_scale = pace * dx * dx / (diffusivity * dt);
  d.solute.max_supersteps = 10000;
  Run run(d, report);
  const MaterialId water = run.material("water", density, 1e-6 * density);
  MaterialDesc salt;
  salt.name = "salt";
  salt.density = density;
  salt.viscosity = 1e-6 * density;
  salt.solubility = 1;
  salt.dissolves_in = water;
  salt.diffusivity_in = diffusivity;
  const MaterialId id = run.material(salt);
  Vec3d low{}, high = d.domain.max;
  const Vec3d middle = axes[axis] * (half * dx),
              rest = d.domain.max - axes[axis] * dot(d.domain.max, axes[axis]);
  run.fluid(Shape::box(low, rest + middle), water, {}, {{id, left}});
  run.fluid(Shape::box(middle, high), water, {}, {{id, right}});
  const double steps = std::ceil(spread * spread / pace), until = spread * spread / pace * dt;
  if (!run.to(until, until / steps)) return o;
  const ParticleData p = run.particles();
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const double at = dot(p.position[i], axes[axis]) / dx - half,
                 exact = right + (left - right) * 0.5 * std::erfc(at / (2 * spread));
    o.error += std::pow(p.fractions[0][i] - exact, 2) / double(p.id.size());
  }
  o.error = 100 * std::sqrt(o.error) / std::fabs(left - right);
  return o;
}

void diffusion(const Settings& s, Report& r) {
  spread(s, r, "a species between half spaces", 0.25, "% of the difference",
         "second order: 0.1 % where sqrt(D t) is 6 spacings, as in species.half_spaces", diffused);
}

/// A stretched drop of any liquid, along any direction: Rayleigh's period, sqrt(8) per its own time, slower by Lamb's damping.
Outcome swinging(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-5, 1e-1), density = dice.log(300, 8000), tension = dice.log(0.01, 2),
               radius = dice.uniform(6, 10) * dx, stretch = dice.uniform(0.25, 0.45),
               ohnesorge = dice.log(0.01, 0.05);
  const Vec3d axis = dice.direction(), at = dice.place(1, 100) * dx;
  Outcome o{0, text("radius %.2f dx, half-length %.2f radii more, Oh %.3g, sigma %.3g, density %.4g, dx %.3g",
                    radius / dx, stretch, ohnesorge, tension, density, dx)};
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = {};
  Run run(d, report);
  MaterialDesc m;
  m.name = "liquid";
  m.density = density;
  m.surface_tension = tension;
  m.viscosity = ohnesorge * std::sqrt(density * tension * radius);
  run.fluid(Shape::capsule(at - axis * (stretch * radius), at + axis * (stretch * radius), radius),
            run.material(m));
  if (!run.good()) return o;
  const double ball = std::cbrt(3 * static_cast<double>(run.particles().id.size()) / (4 * pi)) * dx,
               time = std::sqrt(density * ball * ball * ball / tension), damping = 5 * ohnesorge,
               exact = 2 * pi * time / std::sqrt(8 - damping * damping);
  std::vector<double> zero;
  double last = 0;
  for (int n = 1; n <= 60 && zero.size() < 3; ++n) {
    if (!run.to(n * exact / 40)) return o;
    const ParticleData p = run.particles();
    Vec3d centre{};
    for (const Vec3d& x : p.position) centre += x * (1 / static_cast<double>(p.id.size()));
    double now = 0;
    for (const Vec3d& x : p.position) {
      const Vec3d q = x - centre;
      now += 1.5 * std::pow(dot(q, axis), 2) - 0.5 * dot(q, q);
    }
    if (last * now < 0) zero.push_back((n - now / (now - last)) / 40);
    last = now;
  }
  if (zero.size() < 3) return report.error = "the drop does not swing", o;
  o.error = 100 * std::fabs(zero[2] - zero[0] - 1);
  o.what += text(", period %.3f of what it should be", zero[2] - zero[0]);
  return o;
}

void drop(const Settings& s, Report& r) {
  spread(s, r, "period of a drop that swings", 12, "%",
         "half a spacing of a radius of 6 or more, and 3 % for how far it swings", swinging);
}

/// Liquid in a cup that turns about its axis, which stands in any direction, at rest in the cup: its surface is a paraboloid. Of
/// columns two spacings wide, the heights of their uppermost particles, half a spacing within it, less that, over r^2.
Outcome turned(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.5), g = dice.log(1, 100), density = dice.log(300, 8000);
  const int radius = dice.whole(6, 9), depth = dice.whole(6, 9), thick = 3;
  const double R = radius * dx, rise = dice.uniform(2, 1.2 * depth) * dx;
  const Vec3d up = dice.direction(), at = dice.place(1, 100) * dx;
  const double turn = std::sqrt(2 * g * rise) / R * (dice.coin() ? 1 : -1);
  Outcome o{0, text("radius %.0f dx, %.0f dx deep, rise %.2f dx, %.0f degrees from y, dx %.3g, g %.3g",
                    radius, depth, rise / dx, std::acos(up.y) * 180 / pi, dx, g)};
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = up * -g;
  d.sound_speed = 10 * std::sqrt(2 * g * (depth * dx + rise));
  Run run(d, report);
  const Vec3d top = up * (depth * dx + 0.5 * rise + 4 * dx);
  SolidDesc cup;
  cup.name = "cup";
  cup.material = run.material("steel", 8000, 0);
  cup.motion = Motion::kinematic;
  cup.shape = Shape::subtract(Shape::cylinder(at - up * (thick * dx), at + top, R + thick * dx),
                              Shape::cylinder(at, at + top + up * dx, R));
  cup.angular_velocity = up * turn;
  cup.pivot = at;
  run.solid(cup);
  run.fluid(Shape::cylinder(at, at + up * (depth * dx), R),
            run.material("liquid", density, density * 0.02 * std::sqrt(g * dx) * dx));
  // What turns the liquid, for six times as long as that takes; after that the cup alone.
  const double unit = std::sqrt(dx / g);
  ForceFieldDesc wind;
  wind.kind = ForceFieldKind::drag;
  wind.center = at;
  wind.angular_velocity = cup.angular_velocity;
  wind.rate = 0.3 / unit;
  wind.until = 20 * unit;
  wind.bodies = false;
  run.field(wind);
  const Vec3d side = axes[std::fabs(up.x) < 0.5 ? 0 : 1],
              right = cross(up, side) * (1 / length(cross(up, side))), ahead = cross(right, up);
  const auto excess = [&] {
    const ParticleData p = run.particles();
    std::map<std::pair<int, int>, Vec3d> tops;
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      if (is_solid(p.tag[i])) continue;
      const Vec3d x = (p.position[i] - at) * (1 / dx);
      const Vec3d here{dot(x, right), dot(x, up), dot(x, ahead)};
      const std::pair cell{static_cast<int>(std::floor(0.5 * here.x)),
                           static_cast<int>(std::floor(0.5 * here.z))};
      const auto [top, first] = tops.emplace(cell, here);
      if (!first && top->second.y < here.y) top->second = here;
    }
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (const auto& [cell, top] : tops) {
      const double r2 = top.x * top.x + top.z * top.z;
      if (r2 > (radius - 1) * (radius - 1)) continue;  // beside the wall a column is partly steel
      const double slope = 2 * rise / dx * std::sqrt(r2) / (radius * radius),
                   off = top.y + 0.5 * std::sqrt(1 + slope * slope) - rise / dx * r2 / (radius * radius);
      n += 1, sx += r2, sy += off, sxx += r2 * r2, sxy += r2 * off;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx) * radius * radius;
  };
  double ours = 0;
  int samples = 0;
  for (double t = 60 * unit; run.to(t) && t < 100 * unit; t += 2 * unit, ++samples) ours += excess();
  if (!run.good()) return o;
  ours /= samples;
  o.error = std::fabs(ours);
  o.what += text(", %.2f dx more", ours);
  return o;
}

void cup(const Settings& s, Report& r) {
  spread(s, r, "rise of a surface in a cup that turns", 0.5, "dx",
         "half a spacing: what a surface of particles resolves", turned);
}

}  // namespace

std::vector<Case> drawn_liquids_cases() {
  return {
      {"drawn.power_law", "Liquids that thin and thicken between plates in any orientation", "exact profile",
       false, power_law},
      {"drawn.diffusion", "Species between half spaces along any axis", "erfc", false, diffusion},
      {"drawn.drop", "Stretched drops of any liquid", "Rayleigh (1879), Lamb (1932)", false, drop},
      {"drawn.cup", "Liquid in cups that turn, upright in any direction", "paraboloid", false, cup},
  };
}

}  // namespace validation
