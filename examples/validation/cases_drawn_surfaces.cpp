// SPDX-License-Identifier: Apache-2.0
// Cases drawn at random, continued: surfaces that find their place, of bodies that dissolve, of drops on what they wet, of liquid in basins.
// As in cases_drawn.cpp, a target is what the order of the method says at the coarsest draw.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "dissolving.hpp"
#include "drawn.hpp"
#include "drops.hpp"

namespace validation {
namespace {

const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// A slab on a wall, or a ball in the middle of a box of solvent, until a drawn part of it has dissolved: how far its front has gone by
/// then, of a ball that of the ball of the volume that is left.
Outcome dissolved(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-4, 0.1), density = dice.log(300, 8000), diffusivity = dice.log(1e-10, 1e-4);
  const bool ball = dice.coin(), alike = dice.coin();
  const int axis = dice.whole(0, 2), above = dice.whole(0, 1);
  double ratio = 1, solubility = 0, b = 0, lambda = 0;  // ratio: density of the body over the solvent's
  double size = 0, gone = 0,
         time = 0;  // thickness or radius [dx]; what dissolves, [dx] or of a ball; D t/dx^2
  int length = 0;
  do {  // boxes of more cells than that are drawn again
    ratio = alike ? 1 : dice.log(0.7, 1.5);
    solubility = dice.uniform(0.15, 0.65);
    b = dissolving_number(solubility, 1 / ratio);
    lambda = dissolving_slab(b);
    if (ball) {
      size = dice.uniform(5, 8);
      gone = dice.uniform(0.8, 0.98);
      time = dissolving_ball(b, 1 - gone, 5) * size * size;
      length = 2 * static_cast<int>(std::ceil(size + 3 * std::sqrt(time)));
    } else {
      size = dice.whole(4, 8);
      gone = dice.uniform(3, size - 0.5);
      time = std::pow(gone / (2 * lambda), 2);
      length = static_cast<int>(std::ceil(size + 4.5 * std::sqrt(time)));
    }
  } while (length > (ball ? 42 : 100));
  Outcome o{
      0,
      text(ball ? "ball of radius %.2f dx, %.2f of it, w_s %.3f, density %.2f of the solvent's, D t %.3g dx^2"
                : "slab of %.0f dx, %.2f of them, w_s %.3f, density %.2f of the solvent's, D t %.3g dx^2",
           size, gone, solubility, ratio, time)};
  // At D t = dx^2 a front goes a twentieth of a cell in a step; a fifth of that where liquid has to move, as volumes change in
  // place, at some hundredth of the speed of sound.
  const double pace = (alike ? 0.05 : 0.01) / lambda, dt = alike ? 0.01 * dx : dx;
  Vec3i n{8, 8, 8};
  std::array<Face, 3> faces{Face::periodic, Face::periodic, Face::periodic};
  if (ball) n = {length, length, length}, faces = {Face::wall, Face::wall, Face::wall};
  else (axis == 0 ? n.x : axis == 1 ? n.y : n.z) = length, faces[static_cast<std::size_t>(axis)] = Face::wall;
  WorldDesc d = box(s, dx, n, faces[0], faces[1], faces[2]);
  d.gravity = {};
  d.sound_speed = 1;
  d.heat.model = HeatModel::none;
  d.solute.time_scale = pace * dx * dx / (diffusivity * dt);
  d.solute.max_supersteps = 10000;
  Run run(d, report);
  SolidDesc body;
  const Vec3d middle =
      d.domain.max * 0.5 + Vec3d{dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1)} * dx;
  const Vec3d beyond = axes[axis] * ((length - size) * dx);
  body.shape = ball         ? Shape::sphere(middle, size * dx)
               : above == 1 ? Shape::box(beyond, d.domain.max)
                            : Shape::box({0, 0, 0}, d.domain.max - beyond);
  body.fixed = !ball || dice.coin();
  MaterialDesc m;
  m.name = "salt";
  m.density = ratio * density;
  m.viscosity = 0.02 * density * dx;
  m.solubility = solubility;
  m.diffusivity_in = diffusivity;
  const MaterialId water = run.material("water", density, m.viscosity);
  m.dissolves_in = water;
  body.material = run.material(m);
  run.solid(body);
  run.fluid(Shape::box({0, 0, 0}, d.domain.max), water);
  if (!run.good()) return o;
  double cells = 0;
  for (const std::uint32_t tag : run.particles().tag) cells += is_solid(tag) ? 1 : 0;
  if (ball) time *= std::pow(cells * 3 / (4 * pi), 2.0 / 3) / (size * size);  // of a ball of as many cells
  if (!run.to(time / pace * dt, dt)) return o;
  const double left = undissolved(run.particles(), solubility) / (m.density * dx * dx * dx) / cells,
               whole = ball ? std::cbrt(cells * 3 / (4 * pi)) : size,
               exact = ball ? whole * (1 - std::cbrt(1 - gone)) : gone,
               ours = whole * (1 - (ball ? std::cbrt(left) : left));
  o.error = std::fabs(ours - exact);
  o.what += text(", front at %.3f dx instead of %.3f", ours, exact);
  return o;
}

void dissolving(const Settings& s, Report& r) {
  spread(s, r, "how far the front of a body that dissolves has gone", 0.2, "dx",
         "a cell gives its content off as a whole, a tenth of it; a lattice has the area of a ball within 3 "
         "%, of 3 dx or more",
         dissolved);
}

/// A drop on a wall or a fixed plate, on any of six faces, that starts as half a ball; its angle once it has come to rest.
Outcome wetting(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-5, 1e-1), density = dice.log(300, 8000), tension = dice.log(0.01, 2),
               radius = dice.uniform(7, 10) * dx, angle = dice.uniform(50, 130),
               bond = dice.coin() ? 0 : dice.log(0.05, 0.5), ohnesorge = dice.log(0.1, 0.3);
  const int axis = dice.whole(0, 2);
  const bool above = dice.coin(), plate = dice.coin();
  Outcome o{0, text(plate ? "%.1f degrees, radius %.2f dx, on a body, Bond %.3g, Oh %.3g, axis %.0f, dx %.3g"
                          : "%.1f degrees, radius %.2f dx, on a wall, Bond %.3g, Oh %.3g, axis %.0f, dx %.3g",
                    angle, radius / dx, bond, ohnesorge, above ? -(axis + 1) : axis + 1, dx)};
  const int wide = 2 * static_cast<int>(std::ceil(1.5 * radius / dx + 4)), thick = plate ? 3 : 0;
  Vec3i n{wide, wide, wide};
  (axis == 0 ? n.x : axis == 1 ? n.y : n.z) = static_cast<int>(std::ceil(1.5 * radius / dx + 6)) + thick;
  WorldDesc d = box(s, dx, n, Face::wall, Face::wall, Face::wall);
  d.domain.contact_angle = plate ? 90 : angle;
  d.domain.no_slip = false;
  const Vec3d up = axes[axis] * (above ? -1.0 : 1.0), side = axes[(axis + 1) % 3],
              ahead = axes[(axis + 2) % 3];
  d.gravity = up * (-bond * tension / (density * radius * radius));
  Run run(d, report);
  const double off = dice.uniform(-1, 1), away = dice.uniform(-1, 1);  // from the middle
  const Vec3d foot = side * (0.5 * wide * dx + away * dx) + ahead * (0.5 * wide * dx + off * dx) +
                     axes[axis] * (above ? dot(d.domain.max, axes[axis]) : 0) + up * (thick * dx);
  const Vec3d low = above ? Vec3d{} : up * (thick * dx),
              high = d.domain.max + (above ? up * (thick * dx) : Vec3d{});
  if (plate) {
    MaterialDesc m;
    m.name = "plate";
    m.contact_angle = angle;
    const Vec3d cut = axes[axis] * (dot(d.domain.max, axes[axis]) - thick * dx);
    run.solid("plate", Shape::box(above ? cut : Vec3d{}, above ? d.domain.max : d.domain.max - cut),
              run.material(m), {}, true);
  }
  MaterialDesc m;
  m.name = "liquid";
  m.density = density;
  m.surface_tension = tension;
  m.viscosity = ohnesorge * std::sqrt(density * tension * radius);
  run.fluid(Shape::intersect({Shape::box(low, high), Shape::sphere(foot, radius)}), run.material(m));
  if (!run.to(5 * std::sqrt(density * radius * radius * radius / tension))) return o;
  const ParticleData p = run.particles();
  double count = 0, centre = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (is_fluid(p.tag[i])) centre += dot(p.position[i] - foot, up), count += 1;
  centre /= count;
  const double volume = count * dx * dx * dx,
               ours = bond > 0 ? sessile_angle(dx, volume, radius / std::sqrt(bond), centre)
                               : cap_angle(volume, centre);
  o.error = std::fabs(ours - angle) * radius / (10 * dx);
  o.what += text(", %.1f degrees instead", ours);
  return o;
}

void angle(const Settings& s, Report& r) {
  spread(s, r, "angle of a drop on what it wets", 6, "degrees at 10 dx",
         "as asked of tension.angles: a quarter of a spacing in the height of a centre; first order in the "
         "radius",
         wetting);
}

/// Upwards along an axis, and how high its floor is above the origin.
struct Upright {
  int axis;
  bool flipped;
  Vec3d up;
  double floor;
};
Upright upright(Dice& dice) {
  Upright u{dice.whole(0, 2), dice.coin(), {}, 0};
  u.up = axes[u.axis] * (u.flipped ? -1.0 : 1.0);
  return u;
}

/// A nozzle above the floor of a closed tank, until it ends; twice the height of the centre of mass once that is at rest.
Outcome filled(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 1), g = dice.log(1, 100), density = dice.log(300, 8000),
               unit = std::sqrt(dx / g);
  Upright u = upright(dice);
  const int broad = dice.whole(8, 14), deep = dice.whole(8, 14), height = 16;
  const double layers = dice.uniform(4, 8), radius = dice.uniform(1.2, 3), speed = dice.log(1, 4) * dx / unit,
               runs = layers * broad * deep * dx / (pi * radius * radius * speed);
  Outcome o{
      0, text("%.0f x %.0f spacings, %.2f layers, nozzle %.2f dx at %.2f sqrt(g dx), up %.0f, dx %.3g", broad,
              deep, layers, radius, speed * unit / dx, u.flipped ? -(u.axis + 1) : u.axis + 1, dx)};
  Vec3i n{};
  (u.axis == 0 ? n.x : u.axis == 1 ? n.y : n.z) = height;
  (u.axis == 0 ? n.y : u.axis == 1 ? n.z : n.x) = broad;
  (u.axis == 0 ? n.z : u.axis == 1 ? n.x : n.y) = deep;
  WorldDesc d = box(s, dx, n, Face::wall, Face::wall, Face::wall);
  d.gravity = u.up * -g;
  d.sound_speed = 10 * std::sqrt(2 * g * height * dx);
  u.floor = u.flipped ? -height * dx : 0;
  Run run(d, report);
  EmitterDesc e;
  e.radius = radius * dx;
  e.axis = u.up * -1.0;
  const double room = radius + 1;
  const double z = dice.uniform(room, deep - room), y = dice.uniform(room, broad - room);
  e.center = u.up * (u.floor + (height - 4) * dx) + axes[(u.axis + 1) % 3] * (y * dx) +
             axes[(u.axis + 2) % 3] * (z * dx);
  e.speed = speed;
  e.until = runs;
  e.material = run.material("liquid", density, density * 0.03 * std::sqrt(g * dx) * dx);
  if (!run.emitter(e)) return o;
  const double rest = runs + 60 * unit;
  double centre = 0;
  int samples = 0;
  for (double t = rest; run.to(t) && t < rest + 20 * unit; t += 2 * unit, ++samples) {
    const ParticleData p = run.particles();
    for (const Vec3d& x : p.position) centre += (dot(x, u.up) - u.floor) / static_cast<double>(p.id.size());
  }
  if (!run.good()) return o;
  const double ours = 2 * centre / samples / dx;
  o.error = std::fabs(ours - layers);
  o.what += text(", level %.3f", ours);
  return o;
}

/// A tank or channel that stands along two axes, its open end at either end of the first.
struct Reach {
  WorldDesc desc;
  int along = 0;
  bool end = false;  ///< the open face is the upper one of `along`
  Upright u{};
  int length = 0, width = 0, layers = 0, lid = 0;
  double dx = 0, g = 0;
  /// A point so many spacings from the open face, above the floor, and across.
  Vec3d at(double from, double high, double across) const {
    return (axes[along] * (end ? length - from : from) + axes[3 - along - u.axis] * across + u.up * high) *
               dx +
           u.up * u.floor;
  }
};
Reach reach(Dice& dice, const Settings& s) {
  Reach r;
  r.dx = dice.log(1e-3, 1), r.g = dice.log(1, 100);
  r.u = upright(dice);
  r.along = (r.u.axis + dice.whole(1, 2)) % 3;
  r.end = dice.coin();
  r.length = dice.whole(20, 28), r.width = dice.whole(8, 10), r.layers = dice.whole(8, 12),
  r.lid = 2 * r.layers;
  const int across = 3 - r.along - r.u.axis;
  int n[3];
  n[r.along] = r.length, n[across] = r.width, n[r.u.axis] = r.lid;
  std::array<Face, 3> faces{Face::wall, Face::wall, Face::wall};
  if (dice.coin()) faces[static_cast<std::size_t>(across)] = Face::periodic;
  r.desc = box(s, r.dx, {n[0], n[1], n[2]}, faces[0], faces[1], faces[2]);
  r.desc.domain.faces[static_cast<std::size_t>(2 * r.along + (r.end ? 1 : 0))] = Face::open;
  r.desc.gravity = r.u.up * -r.g;
  r.desc.sound_speed = 10 * std::sqrt(2 * r.g * r.layers * 1.5 * r.dx);
  r.u.floor = r.u.flipped ? -r.lid * r.dx : 0;
  return r;
}

/// The depth between two distances from the open face [dx], in layers.
double depth_of(const Reach& r, const ParticleData& p, double from, double to) {
  double count = 0;
  for (const Vec3d& x : p.position) {
    const double along = dot(x, axes[r.along]) / r.dx, away = r.end ? r.length - along : along;
    count += away > from && away < to ? 1 : 0;
  }
  return count / ((to - from) * r.width);
}

/// Liquid that comes in or goes out through a face, to the level beyond it: an emitter with a level. A particle that is not accounted for
/// counts as a spacing.
Outcome levelled(Dice& dice, const Settings& s, Report& report) {
  Reach r = reach(dice, s);
  const double density = dice.log(300, 8000), share = dice.one_in(5) ? 0 : dice.log(0.5, 1.5);
  const int begin = static_cast<int>(share * r.layers + 0.5);
  Outcome o{
      0, text("%.0f layers beyond, %.0f inside, %.0f x %.0f spacings, along %.0f, up %.0f, dx %.3g", r.layers,
              begin, r.length, r.width, r.along, r.u.flipped ? -(r.u.axis + 1) : r.u.axis + 1, r.dx)};
  Run run(r.desc, report);
  const MaterialId liquid = run.material("liquid", density, density * 0.02 * std::sqrt(r.g * r.dx) * r.dx);
  double first = 0;
  if (begin > 0) {
    const Vec3d a = r.at(0, 0, 0), b = r.at(r.length, begin, r.width);
    first = static_cast<double>(
        run.fluid(Shape::box({std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)},
                             {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}),
                  liquid));
  }
  EmitterDesc e;
  e.axis = axes[r.along] * (r.end ? -1.0 : 1.0);
  e.level = r.u.floor + r.layers * r.dx;
  e.material = liquid;
  if (!run.emitter(e)) return o;
  const double crossing = r.length * r.dx / std::sqrt(r.g * r.layers * r.dx),
               rest = (begin > 0 ? 5 : 9) * crossing;
  double depth = 0;
  int samples = 0;
  for (double t = rest; run.to(t) && t < rest + 2 * crossing; t += 0.2 * crossing, ++samples)
    depth += depth_of(r, run.particles(), 8, r.length);
  if (!run.good()) return o;
  depth /= samples;
  const StepResult& now = run.last();
  const double lost = first + static_cast<double>(now.entered) - static_cast<double>(now.removed) -
                      static_cast<double>(now.fluid);
  o.error = std::fabs(depth - r.layers) + std::fabs(lost);
  o.what += text(", depth %.3f, %.0f at first, %.0f came in, %.0f left", depth, first, double(now.entered),
                 double(now.removed));
  return o;
}

/// A stream from a nozzle as broad as a channel to an outlet with a level.
Outcome streaming(Dice& dice, const Settings& s, Report& report) {
  Reach r = reach(dice, s);
  const double density = dice.log(300, 8000), froude = dice.uniform(0.1, 0.5);
  const int begin = std::max(4, static_cast<int>(dice.uniform(0.8, 1.2) * r.layers + 0.5));
  const double celerity = std::sqrt(r.g * r.layers * r.dx), speed = froude * celerity;
  r.desc.domain.no_slip = false;  // so that nothing but the outlet decides on the depth
  Outcome o{0,
            text("Froude %.2f, %.0f layers beyond, %.0f at first, %.0f x %.0f spacings, along %.0f, up %.0f",
                 froude, r.layers, begin, r.length, r.width, r.along,
                 r.u.flipped ? -(r.u.axis + 1) : r.u.axis + 1)};
  r.desc.domain.outlets[static_cast<std::size_t>(2 * r.along + (r.end ? 1 : 0))].level =
      r.u.floor + r.layers * r.dx;
  Run run(r.desc, report);
  const MaterialId liquid = run.material("liquid", density, density * 0.01 * std::sqrt(r.g * r.dx) * r.dx);
  const Vec3d a = r.at(0, 0, 0), b = r.at(r.length - 3, begin, r.width);
  FluidDesc f;
  f.shape = Shape::box({std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)},
                       {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)});
  f.material = liquid;
  const Vec3d flow = axes[r.along] * (r.end ? 1.0 : -1.0);
  f.velocity = flow * speed;
  run.fluid(f);
  EmitterDesc e;
  e.axis = flow;
  e.center = r.at(r.length - 0.5, 0.5 * r.layers, 0.5 * r.width);
  e.up = r.u.up;
  e.height = r.layers * r.dx;
  e.width = r.width * r.dx;
  e.speed = speed;
  e.max_particles = 200000;
  e.material = liquid;
  if (!run.emitter(e)) return o;
  const double crossing = r.length * r.dx / celerity, rest = 4 * crossing;
  double depth = 0;
  int samples = 0;
  for (double t = rest; run.to(t) && t < rest + 3 * crossing; t += 0.2 * crossing, ++samples)
    depth += depth_of(r, run.particles(), 8, r.length - 5);
  if (!run.good()) return o;
  depth /= samples;
  o.error = std::fabs(depth - r.layers);
  o.what += text(", depth %.3f", depth);
  return o;
}

void basin(const Settings& s, Report& r) {
  const char* half = "half a spacing: what a surface of particles resolves";
  spread(s, r, "level of a tank that a nozzle has filled", 0.5, "dx", half, filled);
  spread(s, r, "depth inside an open face at the level beyond it", 0.5, "dx", half, levelled);
  spread(s, r, "depth of a stream towards a level", 0.5, "dx", half, streaming);
}

}  // namespace

std::vector<Case> drawn_surfaces_cases() {
  return {
      {"drawn.dissolving", "Slabs and balls that dissolve", "similarity solution; a radial one, converged",
       true, dissolving},
      {"drawn.angle", "Drops of any liquid on walls and bodies", "Young (1805), Bashforth & Adams (1883)",
       true, angle},
      {"drawn.basin", "Tanks that a nozzle fills, and tanks with a level beyond an open face",
       "volume; the level beyond", true, basin},
  };
}

}  // namespace validation
