// SPDX-License-Identifier: Apache-2.0
// Liquids of different density, and liquid with solids. Default settings throughout.
#include <cmath>

#include "run.hpp"
#include "sphere_motion.hpp"

namespace validation {
namespace {

constexpr double dx = 0.0625, g = 9.81, cell = dx * dx * dx;

struct Solid {
  double centre = 0, low = infinity,
         speed = 0;  ///< height of the centre and of the lowest particle [m], vertical speed
  int count = 0;
};
Solid solid_of(const ParticleData& p) {
  Solid s;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (!is_solid(p.tag[i])) continue;
    s.centre += p.position[i].y;
    s.speed += p.velocity[i].y;
    s.low = std::min(s.low, p.position[i].y);
    ++s.count;
  }
  s.centre /= std::max(1, s.count);
  s.speed /= std::max(1, s.count);
  return s;
}

/// A tank of side x layers x side spacings of water with a cube in its middle, `draught` spacings deep at the
/// start.
constexpr int side = 12, layers = 10;
Run tank_with_cube(const Settings& s, Report& r, double density, int edge, int draught) {
  const WorldDesc d = box(s, dx, {side, layers + 8, side}, Face::wall, Face::wall, Face::wall);
  Run run(d, r);
  const double low = (side - edge) / 2 * dx, bottom = (layers - draught) * dx, size = edge * dx;
  run.solid("cube", Shape::box({low, bottom, low}, {low + size, bottom + size, low + size}),
            run.material("solid", density, 0));
  run.fluid(Shape::box({0, 0, 0}, {side * dx, layers * dx, side * dx}), run.material("water", 1000, 1e-3));
  return run;
}

// Draught = density ratio times the edge. At 500 the cube tilts; the centre of a half-submerged cube lies in
// the surface in any attitude, so the submerged height is measured from the centre. The level follows from
// the volumes.
void floating(const Settings& s, Report& r, double density) {
  constexpr int edge = 4;
  Run run = tank_with_cube(s, r, density, edge, static_cast<int>(std::lround(density / 1000 * edge)));
  const double until = 5, area = side * side * dx * dx, base = edge * edge * dx * dx;
  double draught = 0;
  int samples = 0;
  for (double t = 3; run.to(t, 0.02) && t < until; t += 0.02) {
    const double bottom = solid_of(run.particles()).centre - 0.5 * edge * dx;
    const double volume = static_cast<double>(run.last().fluid) * cell;
    draught += ((volume - bottom * base) / (area - base) - bottom) / dx;
    ++samples;
  }
  if (!run.good()) return;
  const std::string name = std::to_string(static_cast<int>(density)) + " kg/m^3";
  r.absolute("draught in spacings, " + name, draught / samples, density / 1000 * edge, 0.5, "dx",
             "half a spacing: what a surface of particles resolves");
}
void floats(const Settings& s, Report& r) {
  for (const double density : {200.0, 500.0, 917.0})
    if (r.error.empty()) floating(s, r, density);
}

void sinks(const Settings& s, Report& r) {
  for (const double density : {2000.0, 10000.0}) {
    if (!r.error.empty()) return;
    Run run = tank_with_cube(s, r, density, 4, 4);
    if (!run.to(4)) return;
    const Solid b = solid_of(run.particles());
    const std::string name = ", " + std::to_string(static_cast<int>(density)) + " kg/m^3";
    r.absolute("gap to the floor" + name, (b.low - 0.5 * dx) / dx, 0, 1, "dx",
               "a film of liquid may stay below it");
    r.absolute("vertical speed at rest" + name, b.speed / std::sqrt(g * layers * dx), 0, 1e-2, "sqrt(g h)",
               "at rest");
  }
}

// 1e5 sub-steps in a tank of 7 x 5 x 7 with a cube of 3: coarse, so that every density is affordable.
void endures(const Settings& s, Report& r, double density) {
  constexpr int width = 7, deep = 5, edge = 3, at_start = 2;
  const WorldDesc d = box(s, dx, {width, deep + 5, width}, Face::wall, Face::wall, Face::wall);
  Run run(d, r);
  const double low = 2 * dx, bottom = (deep - at_start) * dx, size = edge * dx;
  run.solid("cube", Shape::box({low, bottom, low}, {low + size, bottom + size, low + size}),
            run.material("solid", density, 0));
  run.fluid(Shape::box({0, 0, 0}, {width * dx, deep * dx, width * dx}), run.material("water", 1000, 1e-3));
  const double fall = std::sqrt(2 * g * deep * dx), dt = run.stable_dt();
  double fastest = 0, densest = 0, draught = 0, gap = 0, samples = 0;
  for (double steps = 1000; steps <= 1e5 && run.to(steps * dt); steps += 1000) {
    fastest = std::max(fastest, run.last().max_speed);
    if (steps <= 5e4) continue;  // what is left of the splash
    densest = std::max(densest, run.last().max_density_ratio);
    const Solid b = solid_of(run.particles());
    const double base = size * size, area = width * width * dx * dx, under = b.centre - 0.5 * size;
    draught += ((static_cast<double>(run.last().fluid) * cell - under * base) / (area - base) - under) / dx;
    gap += b.low / dx - 0.5;
    samples += 1;
  }
  if (!run.good()) return;
  const std::string name = ", " + std::to_string(static_cast<int>(density)) + " kg/m^3";
  r.absolute("sub-steps short of 1e5" + name, 1e5 - std::min(1e5, static_cast<double>(run.last().steps)), 0,
             0, "-", "stable for so long: no halt");
  if (density <= 1000)
    r.absolute("largest speed over sqrt(2 g h)" + name, fastest / fall, 0, 1, "-",
               "nothing gains more than a fall over the depth");
  else  // what lands squeezes the liquid beneath it out: measured 3 at 5000, 4 at 10000, for half a second
    r.absolute("largest speed over sqrt(2 g h), landing" + name, fastest / fall, 0, 5, "-",
               "half the speed of sound, beyond which weak compressibility means nothing");
  r.absolute("density beyond rest density" + name, densest - 1, 0, 0.05, "-",
             "the depth's pressure makes 0.5 % at c = 10 sqrt(2 g h); ten times that is no rest");
  if (density < 1000)
    r.absolute("draught in spacings" + name, draught / samples, density / 1000 * edge, 0.5, "dx",
               "half a spacing: what a surface of particles resolves");
  if (density > 1000)
    r.absolute("gap to the floor" + name, gap / samples, 0, 1, "dx", "a film of liquid may stay below it");
}
void endures_light(const Settings& s, Report& r) {
  for (const double density : {100.0, 200.0, 500.0, 900.0})
    if (r.error.empty()) endures(s, r, density);
}
void endures_heavy(const Settings& s, Report& r) {
  for (const double density : {1000.0, 2000.0, 5000.0, 10000.0})
    if (r.error.empty()) endures(s, r, density);
}

void neutral(const Settings& s, Report& r) {
  Run run = tank_with_cube(s, r, 1000, 4, 7);
  const double start = solid_of(run.particles()).centre;
  Curve path{"meltsim", {}, {}, false};
  double worst = 0;
  for (double t = 0.25; t <= 10; t += 0.25) {
    if (!run.to(t)) return;
    const double moved = (solid_of(run.particles()).centre - start) / dx;
    worst = std::max(worst, std::fabs(moved));
    path.x.push_back(t);
    path.y.push_back(moved);
  }
  r.absolute("largest vertical displacement in 10 s", worst, 0, 1, "dx", "no buoyancy beyond a spacing");
  r.plots.push_back({"coupling_neutral", "A body as dense as the liquid", "t [s]", "rise / dx", {path}});
}

// The cube of 4 spacings, deep under water and as light as 100 kg/m^3: nothing may go faster than it could in
// free fall over the depth.
void contact_start(const Settings& s, Report& r) {
  Run run = tank_with_cube(s, r, 100, 4, 4);
  double fastest = 0;
  for (double t = 0.02; t <= 1; t += 0.02) {
    if (!run.to(t)) return;
    fastest = std::max(fastest, run.last().max_speed);
  }
  r.absolute("largest speed over sqrt(2 g h), h the depth", fastest / std::sqrt(2 * g * layers * dx), 0, 1,
             "-", "buoyancy alone; an overlap of volumes would throw the cube");
}

// A fixed plate one particle thick across the tank, 4 layers of water on it, air below.
void thin_plate(const Settings& s, Report& r) {
  const WorldDesc d = box(s, dx, {side, 16, side}, Face::wall, Face::wall, Face::wall);
  Run run(d, r);
  const double width = side * dx;
  run.solid("plate", Shape::box({0, 5 * dx, 0}, {width, 6 * dx, width}), run.material("solid", 3000, 0), {},
            true);
  run.fluid(Shape::box({0, 6 * dx, 0}, {width, 10 * dx, width}), run.material("water", 1000, 1e-3));
  if (!run.to(5)) return;
  double leaked = 0;
  const ParticleData p = run.particles();
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (!is_solid(p.tag[i]) && p.position[i].y < 5.5 * dx) leaked += 1;
  r.absolute("particles that leaked in 5 s", leaked, 0, 0, "-", "none may");
}

// Closed, without gravity: a cube flies into a slab of liquid. Momentum relative to the cube's at the start.
void momentum(const Settings& s, Report& r) {
  WorldDesc d = box(s, dx, {16, 16, 16}, Face::periodic, Face::periodic, Face::periodic);
  d.gravity = {0, 0, 0};
  Run run(d, r);
  run.solid("cube", Shape::box({6 * dx, 10 * dx, 6 * dx}, {10 * dx, 14 * dx, 10 * dx}),
            run.material("solid", 2000, 0), {0.5, -1, 0});
  run.fluid(Shape::box({0, 0, 0}, {16 * dx, 8 * dx, 16 * dx}), run.material("water", 1000, 1e-3));
  const Vec3d start = run.totals().momentum;
  const double steps = s.long_cases ? 10000 : 2000;
  if (!run.to(steps * run.stable_dt())) return;
  const Vec3d end = run.totals().momentum;
  r.absolute("change of momentum over " + std::to_string(static_cast<int>(steps)) + " steps",
             length(end - start) / std::max(length(start), 1e-300), 0,
             s.precision == Precision::double_precision ? 1e-12 : 1e-6, "-",
             "pair forces are exact negatives; rounding");
}

/// Height of the centre of mass of the particles of one material [m], and how many are on the wrong side of
/// y.
struct Layer {
  double centre = 0, above = 0, count = 0;
};
Layer layer_of(const ParticleData& p, std::uint32_t material, double y) {
  Layer l;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (material_of(p.tag[i]) != material) continue;
    l.centre += p.position[i].y;
    l.above += p.position[i].y > y ? 1 : 0;
    l.count += 1;
  }
  l.centre /= std::max(1.0, l.count);
  return l;
}

void layered(const Settings& s, Report& r, double light, double heavy, bool heavy_on_top, double until) {
  const WorldDesc d = box(s, dx, {10, 20, 10}, Face::wall, Face::wall, Face::wall);
  Run run(d, r);
  const double width = 10 * dx, half = 6 * dx;
  const Shape low = Shape::box({0, 0, 0}, {width, half, width}),
              high = Shape::box({0, half, 0}, {width, 2 * half, width});
  const MaterialId a = run.material("light", light, 1e-3), b = run.material("heavy", heavy, 1e-3);
  const auto lights = static_cast<double>(run.fluid(heavy_on_top ? low : high, a));
  const auto heavies = static_cast<double>(run.fluid(heavy_on_top ? high : low, b));
  if (!run.to(until)) return;
  const ParticleData p = run.particles();
  const Layer l = layer_of(p, 0, half), h = layer_of(p, 1, half);
  const std::string name = ", " + std::to_string(static_cast<int>(light)) +
                           (heavy_on_top ? " under " : " over ") + std::to_string(static_cast<int>(heavy)) +
                           " kg/m^3";
  // Each layer's centre, stratified, stands at 1/4 and 3/4 of the depth.
  r.absolute("centre of the heavy liquid" + name, h.centre / dx, 3, heavy_on_top ? 1 : 0.5, "dx",
             heavy_on_top ? "overturned; drops of the light one may still be under way" : "stays stratified");
  r.absolute("centre of the light liquid" + name, l.centre / dx, 9, heavy_on_top ? 1 : 0.5, "dx",
             heavy_on_top ? "overturned; drops may still be under way" : "stays stratified");
  r.absolute("particles lost" + name, lights + heavies - l.count - h.count, 0, 0, "-", "none may");
}
void stratified(const Settings& s, Report& r) {
  layered(s, r, 100, 1000, false, 3);
  if (r.error.empty()) layered(s, r, 1000, 10000, false, 3);
}
void overturn(const Settings& s, Report& r) { layered(s, r, 1000, 2000, true, 8); }

/// A cubic array of spheres in liquid: one sphere, `diameter` spacings wide, in the middle of a periodic cube.
struct SphereArray {
  double radius = 0;  ///< of a sphere with the volume of the sampled body [m]
  double share = 0;   ///< of the volume [-]
};
SphereArray sphere_in(Run& run, int diameter, int cells, double density, double viscosity, Vec3d velocity,
                      bool fixed, Vec3d stream = {}) {
  const double middle = 0.5 * cells * dx, edge = cells * dx;
  run.solid("sphere", Shape::sphere({middle, middle, middle}, 0.5 * diameter * dx),
            run.material("solid", density, 0), velocity, fixed);
  run.fluid(Shape::box({0, 0, 0}, {edge, edge, edge}), run.material("water", 1000, viscosity), stream);
  const double volume = solid_of(run.particles()).count * cell;
  return {std::cbrt(3 * volume / (4 * pi)), volume / (edge * edge * edge)};
}
WorldDesc sphere_array(const Settings& s, int cells, double sound_speed) {
  WorldDesc d = box(s, dx, {cells, cells, cells}, Face::periodic, Face::periodic, Face::periodic);
  d.tension = true;  // liquid fills the domain
  d.sound_speed = sound_speed;
  d.artificial_viscosity = 0;  // its shear stress is no part of the references
  return d;
}

// A sphere is set in motion at once. What it keeps of its momentum once sound has spread it over the liquid gives the
// added mass. Sound stays in the box, so the speed is the mean over ten passages of it.
void added_mass(const Settings& s, Report& r) {
  constexpr int cells = 20, diameter = 8;
  constexpr double ratio = 2.5;
  const auto launch = [&](double path, const char* name) {
    WorldDesc d = sphere_array(s, cells, 20);
    d.gravity = {0, 0, 0};
    Run run(d, r);
    const double passage = cells * dx / d.sound_speed, start = path * dx / (11 * passage);
    const SphereArray a = sphere_in(run, diameter, cells, ratio * 1000, 0, {0, start, 0}, false);
    double mean = 0;
    int samples = 0;
    for (double t = passage; t < 11 * passage; t += 0.1 * passage, ++samples) {
      if (!run.to(t)) return;
      mean += solid_of(run.particles()).speed;
    }
    mean /= samples;
    r.relative(std::string("added mass over displaced mass, ") + name, ratio * (start / mean - 1),
               0.5 * (1 + 2 * a.share) / (1 - a.share), 20, "8 spacings to a diameter");
  };
  launch(0.1, "moved by less than 0.1 dx");
  if (r.error.empty()) launch(2, "moved by less than 2 dx");
  r.note =
      "The force on a body that has just begun to move is right. Later the first layer of liquid catches a "
      "little "
      "on the steps of the sampled surface (0.61 over 2 dx without the spring against leaks).";
}

// Liquid driven slowly through a cubic array of fixed spheres. Hasimoto: the pressure drop over a cell is, per 6 pi mu R
// times the mean velocity of the whole volume, 1/(1 - 1.7601 f^(1/3) + f - 1.5593 f^2). The liquid starts at about its
// final speed; what it still gains or loses is taken off its weight.
void stokes(const Settings& s, Report& r) {
  for (const int diameter : {6, 8}) {
    if (!r.error.empty()) return;
    const int cells = 3 * diameter;
    const double edge = cells * dx, whole = edge * edge * edge, width = diameter * dx;
    const double reynolds = 0.5, speed = 0.05, mu = 1000 * speed * width / reynolds;
    const auto share_of_drag = [](double f) { return 1 - 1.7601 * std::cbrt(f) + f - 1.5593 * f * f; };
    const double f = pi / 6 * std::pow(width / edge, 3);
    WorldDesc d = sphere_array(s, cells, 4);
    d.gravity = {0, -6 * pi * mu * 0.5 * width * speed / share_of_drag(f) / (1000 * whole), 0};
    Run run(d, r);
    const SphereArray a = sphere_in(run, diameter, cells, 1000, mu, {}, true, {0, -speed / (1 - f), 0});
    // The slowest change of the profile decays at 4 pi^2 nu/L^2: by 1/e^4 in the first part, by as much in the second.
    const double part = 4 * 1000 * edge * edge / (4 * pi * pi * mu);
    if (!run.to(part)) return;
    const double before = -run.totals().momentum.y;
    if (!run.to(2 * part)) return;
    const double after = -run.totals().momentum.y, through = 0.5 * (before + after) / (1000 * whole);
    const double gain = (after - before) / part / (1 - a.share);  // as if the whole volume were liquid
    r.relative("drag over 6 pi mu R v, " + std::to_string(diameter) + " spacings to a diameter",
               (1000 * length(d.gravity) * whole - gain) / (6 * pi * mu * a.radius * through),
               1 / share_of_drag(a.share), 100.0 / diameter, "half a spacing of the radius");
  }
}

// A half-submerged sphere of 0.3 m in water 3 diameters deep, let go a tenth of its diameter above its balance. Its first swing
// ends after half of the period of Kramer et al., the next one after a whole period.
void heave(const Settings& s, Report& r) {
  constexpr int across = 8, wide = 6 * across, deep = 3 * across;
  constexpr double diameter = 0.3, h = diameter / across, period = 0.76, level = deep * h, every = 0.01;
  WorldDesc d = box(s, h, {wide, deep + across, wide}, Face::wall, Face::wall, Face::wall);
  d.sound_speed = 40;
  Run run(d, r);
  run.solid("sphere", Shape::sphere({wide * h / 2, level + 0.1 * diameter, wide * h / 2}, diameter / 2),
            run.material("solid", 499, 0));
  run.fluid(Shape::box({0, 0, 0}, {wide * h, level, wide * h}), run.material("water", 998, 1e-3));
  Curve path{"meltsim", {}, {}, false};
  for (int k = 1; k * every < 1.3 * period; ++k) {
    if (!run.to(k * every)) return;
    path.x.push_back(k * every / period);
    path.y.push_back((solid_of(run.particles()).centre - level) / diameter);
  }
  // Sound that the start sends up and down the tank takes 4 depths/c = 0.09 s: the sphere turns where what it gains over that
  // time changes its sign.
  constexpr std::size_t half = 4;
  std::vector<double> turns;
  double before = 0;
  for (std::size_t k = half; k + half < path.y.size(); ++k) {
    const double gain = path.y[k + half] - path.y[k - half];
    if (before * gain < 0) turns.push_back(period * path.x[k] - every * gain / (gain - before));
    before = gain;
  }
  turns.resize(2, 0);
  r.relative("end of the first swing", turns[0], 0.5 * period, 10, "8 spacings to a diameter");
  r.relative("end of the second swing", turns[1], period, 10, "8 spacings to a diameter");
  r.plots.push_back(
      {"coupling_heave", "A sphere that heaves", "t / 0.76 s", "height of its centre / D", {path}});
}

/// Diameter of a sphere with the volume of this many cells.
double diameter_of(int count) { return std::cbrt(6 * count * cell / pi); }

/// Of spheres: diameter, and the ways after which timing begins and ends [m]; the speed that they come to, and that of streams [m/s].
constexpr int across = 8;
constexpr double diameter = across * dx, way_from = 1.5 * diameter, way_to = 4.5 * diameter, speed = 0.05;

// A sphere sinks or rises from rest through 8 diameters of liquid, in an array 6 diameters wide, under the gravity at which Schiller &
// Naumann give its final speed; it is timed on its way from 1.5 to 4.5 diameters. On that way it still gains speed. from_rest: a hydrostatic
// field takes the pressure at rest out of all but the topmost five layers.
void fall(const Settings& s, Report& r, double ratio, double reynolds, Plot& plot, bool from_rest = false) {
  constexpr int wide = 6 * across;
  const bool rises = ratio < 1;
  const double start = (rises ? 1.5 : 6.5) * diameter, up = rises ? 1 : -1,
               mu = 1000 * speed * diameter / reynolds,
               drive = 0.75 * SphereMotion::drag_coefficient(reynolds) * speed * speed / diameter,
               gravity = drive / std::fabs(ratio - 1);
  WorldDesc d = box(s, dx, {wide, 9 * across, wide}, Face::periodic, Face::wall, Face::periodic);
  d.gravity = {0, -gravity, 0};
  d.artificial_viscosity = 0;  // it would be larger than that of the liquid
  d.isotropic_pressure = true;
  constexpr double above = 5 * dx;
  const double weighs = from_rest ? above + 2.5 * dx : 8 * diameter;
  d.sound_speed = std::max(10 * std::sqrt(2 * gravity * weighs), 50 * speed);
  Run run(d, r);
  if (from_rest) {
    ForceFieldDesc rest;
    rest.kind = ForceFieldKind::hydrostatic;
    rest.center = Vec3d{0, 8 * diameter - above, 0};
    rest.density = 1000;
    run.field(rest);
  }
  const double middle = 0.5 * wide * dx;
  run.solid("sphere", Shape::sphere({middle, start, middle}, 0.5 * diameter),
            run.material("solid", 1000 * ratio, 0));
  run.fluid(Shape::box({0, 0, 0}, {wide * dx, 8 * diameter, wide * dx}), run.material("water", 1000, mu));
  const SphereMotion motion{ratio, diameter_of(solid_of(run.particles()).count), mu / 1000, drive, wide * dx};
  const SpherePath path = motion_of(motion, 20 * diameter / speed);
  const std::string name = "Re " + std::to_string(static_cast<int>(reynolds));
  Curve ours{"meltsim, " + name, {}, {}, false}, right{"equation of motion, " + name, {}, {}, true};
  double from = 0, at = 0, mean = 0;
  const double latest = 4 * 6 * diameter / speed;
  for (double t = 1; t < latest && mean == 0; t += 1) {
    if (!run.to(t)) return;
    const Solid sphere = solid_of(run.particles());
    const double way = up * (sphere.centre - start);
    ours.x.push_back(way / diameter);
    ours.y.push_back(up * sphere.speed / speed);
    if (at == 0 && way > way_from) from = way, at = t;
    if (way > way_to) mean = (way - from) / (t - at);
  }
  for (std::size_t k = 0; k < path.time.size() && path.distance[k] < way_to; k += 20) {
    right.x.push_back(path.distance[k] / diameter);
    right.y.push_back(path.speed[k] / speed);
  }
  std::string of = " at " + name;
  if (ratio != 2) of += ", " + std::to_string(ratio).substr(0, from_rest ? 4 : 3) + " times as dense";
  r.relative("mean speed" + of, mean, (way_to - way_from) / (path.when(way_to) - path.when(way_from)), 15,
             "8 spacings to a diameter");
  plot.curves.push_back(ours);
  plot.curves.push_back(right);
}

void settling(const Settings& s, Report& r) {
  Plot plot{
      "coupling_settling", "A sphere sinks from rest", "distance fallen / D", "speed / final speed", {}};
  for (const double reynolds : {1.0, 20.0, 100.0})
    if (r.error.empty()) fall(s, r, 2, reynolds, plot);
  r.note =
      "The reference is the equation of motion with added mass, history force and counterflow of the array "
      "(sphere_motion.hpp): at Re 100 it has 0.8 of the final speed of 0.05 m/s on this way, at Re 1 "
      "neighbours take a tenth. isotropic_pressure "
      "on: without it the level of pressure, here the weight of what is above, resists what shears the "
      "particles' lattice, and they "
      "sink at 0.36, 0.60 and 0.62 of the final speed.";
  r.plots.push_back(plot);
}

// The same of spheres that rise, and of one that is nearly as dense as the liquid.
void rising(const Settings& s, Report& r) {
  for (const double ratio : {0.5, 0.8, 1.2})
    for (const double reynolds : {1.0, 20.0, 100.0}) {
      Plot unused{"", "", "", "", {}};
      if (r.error.empty()) fall(s, r, ratio, reynolds, unused);
    }
  r.note =
      "At 1.2 times the liquid's density gravity, and the level of pressure with it, is five times that of "
      "coupling.settling, and pressure resists as a friction of 0.0007 of it would: under three times the "
      "pressure the sphere loses 26 instead of 17 % at Re 20 (docs/limits.md). It is not lift: a "
      "fixed sphere of this size has 1.002 to 1.009 of the weight of its liquid.";
}

// Of those that are hardly heavier than the liquid, with pressure counted from that of rest.
void from_rest(const Settings& s, Report& r) {
  for (const double ratio : {1.05, 1.2})
    for (const double reynolds : {1.0, 20.0, 100.0}) {
      Plot unused{"", "", "", "", {}};
      if (r.error.empty()) fall(s, r, ratio, reynolds, unused, true);
    }
  r.note =
      "A hydrostatic force field below the topmost five layers: there is no level of pressure that could "
      "resist. Without it those of 1.2 times the density are 12 to 20 % too slow "
      "(coupling.rising).";
}

// The same spheres in a periodic box 8 diameters wide, pushed by a force field that another one on the liquid balances: no weight, so
// that the mean pressure is 0. Speed after 8 diameters at the speed of Schiller & Naumann, relative to the whole volume.
void drift(const Settings& s, Report& r) {
  for (const double reynolds : {1.0, 20.0}) {
    if (!r.error.empty()) return;
    constexpr int cells = 8 * across;
    constexpr double until = 8 * diameter / speed;
    const double mu = 1000 * speed * diameter / reynolds, drag = SphereMotion::drag_coefficient(reynolds);
    WorldDesc d = sphere_array(s, cells, 50 * speed);
    d.gravity = {0, 0, 0};
    Run run(d, r);
    const SphereArray a = sphere_in(run, across, cells, 2000, mu, {}, false);
    const double volume = 4 * pi / 3 * a.radius * a.radius * a.radius,
                 force = drag * 500 * speed * speed * pi * a.radius * a.radius;
    ForceFieldDesc push, back;
    push.acceleration = {0, -force / (2000 * volume), 0};
    push.liquid = false;
    back.acceleration = {0, force / (1000 * volume * (1 / a.share - 1)), 0};
    back.bodies = false;
    run.field(push);
    run.field(back);
    if (!run.to(until)) return;
    const double momentum = run.totals().momentum.y, sphere = solid_of(run.particles()).speed;
    const double liquid = (momentum - 2000 * volume * sphere) / (1000 * volume * (1 / a.share - 1));
    const SphereMotion motion{2, 2 * a.radius, mu / 1000, force / (1000 * volume), cells * dx};
    r.relative("speed at Re " + std::to_string(static_cast<int>(reynolds)),
               sphere * a.share + liquid * (1 - a.share) - sphere, motion_of(motion, until).speed.back(), 15,
               "8 spacings to a diameter");
  }
}

/// A stream past a sphere at 1 degree that is held in it.
struct Stream {
  double reynolds, prandtl;
  int wide, along;  ///< width and length of a periodic box [diameters]
  int from, until;  ///< time of measurement [diameters that the stream moves by]
  bool pressed;  ///< by its weight, on a floor, under a free surface; else it fills the box, at no pressure
};
// Its speed and its temperature, 0 degrees, are renewed in the first diameter of the box.
void hold(const Settings& s, Report& r, const Stream& of) {
  constexpr double capacity = 1000, passage = diameter / speed;
  const int wide = of.wide * across;
  WorldDesc d = box(s, dx, {of.along * across, wide, wide}, Face::periodic, Face::periodic, Face::periodic);
  d.tension = !of.pressed;  // liquid fills the domain
  d.gravity = {0, 0, 0};
  d.sound_speed = 20 * speed;
  if (of.pressed) {
    // At the sphere 20 times the pressure of the stream, and a surface that stays flat, at a Froude number of 0.22.
    d.domain.faces[2] = d.domain.faces[3] = Face::wall;
    d.domain.no_slip = false;
    d.domain.max.y += 2 * diameter;
    d.gravity.y = -20 * speed * speed / (wide * dx);
    d.sound_speed = 30 * speed;
    d.isotropic_pressure = true;
  }
  d.artificial_viscosity = 0;  // it would be larger than that of the liquid
  MaterialDesc water, solid;
  water.name = "water";
  water.viscosity = 1000 * speed * diameter / of.reynolds;
  water.heat_capacity = capacity;
  water.conductivity = water.viscosity * capacity / of.prandtl;
  solid.name = "solid";
  solid.conductivity = 1000 * water.conductivity;  // its surface is as warm as its middle,
  solid.heat_capacity = 1e6 * capacity;            // and it stays so
  Run run(d, r);
  const double middle = 0.5 * wide * dx, edge = wide * dx;
  SolidDesc b;
  b.shape = Shape::sphere({3 * diameter, middle, middle}, 0.5 * diameter);
  b.material = run.material(solid);
  b.temperature = 1;
  b.fixed = true;
  const BodyId body = run.solid(b);
  FluidDesc f;
  f.shape = Shape::box(d.domain.min, {d.domain.max.x, edge, edge});
  f.material = run.material(water);
  f.temperature = 0;
  f.velocity = {speed, 0, 0};
  run.fluid(f);
  HeatRegionDesc cold;
  cold.shape = Shape::box({0, 0, 0}, {diameter, d.domain.max.y, edge});
  cold.temperature = 0;
  ForceFieldDesc wind;
  wind.kind = ForceFieldKind::drag;
  wind.shape = cold.shape;
  wind.velocity = {speed, 0, 0};
  wind.rate = 5 / passage;
  wind.bodies = false;
  run.field(wind);
  run.heat_region(cold);
  const double width = diameter_of(solid_of(run.particles()).count);
  run.watch(body);
  if (!run.to(of.from * passage)) return;
  run.forces();
  if (!run.to(of.until * passage)) return;
  const std::vector<BodyForces> forces = run.forces();
  if (forces.empty()) return;
  const double heat = -forces[0].heat / forces[0].seconds,
               force = forces[0].total.linear.x / forces[0].seconds;
  const std::string name = ", Re " + std::to_string(static_cast<int>(of.reynolds)) + ", Pr " +
                           std::to_string(static_cast<int>(of.prandtl));
  r.relative("Nusselt number" + name, heat / (pi * width * water.conductivity),
             1 + std::cbrt(1 + of.reynolds * of.prandtl) * std::pow(of.reynolds, 0.077), 25,
             "the layer of heat is half a spacing to two spacings thick");
  if (of.prandtl > 1) return;
  r.relative("drag coefficient" + name, force / (500 * speed * speed * pi * width * width / 4),
             SphereMotion::drag_coefficient(of.reynolds), 25, "8 spacings to a diameter");
}

// Without pressure: liquid that pulls comes apart behind the sphere, the more the wider the box is.
void stream(const Settings& s, Report& r) {
  for (const Stream& of : {Stream{20, 1, 5, 7, 6, 8, false}, Stream{100, 1, 5, 7, 6, 8, false},
                           Stream{100, 7, 5, 7, 6, 8, false}})
    if (r.error.empty()) hold(s, r, of);
}

void pressed_stream(const Settings& s, Report& r) {
  for (const Stream& of : {Stream{20, 1, 6, 8, 3, 6, true}, Stream{100, 1, 6, 8, 3, 6, true}})
    if (r.error.empty()) hold(s, r, of);
}

// A jet in free space strikes a held plate 4 of its diameters wide, which turns it by 90 degrees, or less where it leans: the force on the
// plate is what the jet brings of momentum across it. Counted over 0.2 s once the plate is wet to its edges.
void strike(const Settings& s, Report& r, int radius, double degrees) {
  constexpr double spacing = 0.01, v = 2;
  const double R = radius * spacing, wide = 8 * R, lean = degrees * pi / 180;
  WorldDesc d = box(s, spacing, {10 * radius, 10 * radius, 10 * radius}, Face::open, Face::open, Face::open);
  d.gravity = {0, 0, 0};
  d.sound_speed = 20 * v;
  const double middle = 5 * R;
  Run run(d, r);
  SolidDesc plate;
  plate.shape = Shape::box({-0.5 * wide, -3 * spacing, -0.5 * wide}, {0.5 * wide, 0, 0.5 * wide})
                    .transformed({middle, middle, middle}, {0, 0, 1}, lean);
  plate.material = run.material("steel", 8000, 0);
  plate.fixed = true;
  EmitterDesc jet;
  jet.center = {middle, middle + 4 * R, middle};
  jet.radius = R;
  jet.speed = v;
  jet.material = run.material("water", 1000, 1e-3);
  jet.until = 10;
  const BodyId body = run.solid(plate);
  run.emitter(jet);
  const double begin = 14 * R / v;
  if (!run.watch(body) || !run.to(begin)) return;
  run.forces();
  if (!run.to(begin + 0.2)) return;
  const auto forces = run.forces();
  if (forces.empty()) return;
  const Vec3d normal{-std::sin(lean), std::cos(lean), 0};
  const std::string name = std::to_string(radius) + " spacings, " +
                           (degrees > 0 ? "a plate that leans by 45 degrees" : "a plate across it");
  r.relative("force, jet with a radius of " + name, -dot(forces[0].total.linear, normal) / forces[0].seconds,
             1000 * pi * R * R * v * v * std::cos(lean), radius < 6 ? 10 : 5,
             radius < 6 ? "the film on the plate is a spacing thick 2 radii out"
                        : "the film on the plate is a spacing thick 3 radii out");
}

void jet_on_plate(const Settings& s, Report& r) {
  for (const int radius : {4, 6, 8})
    if (r.error.empty()) strike(s, r, radius, 0);
  if (r.error.empty()) strike(s, r, 6, 45);
}

// Water in a tank with a held plate down its middle, which leaves a gap below: a U-tube whose legs and bend are 8 spacings wide, let go
// 4 spacings from rest. Half as much as the difference of the levels, from what is on either side of the plate's middle.
void u_tube(const Settings& s, Report& r) {
  constexpr int leg = 8, plate = 3, wide = 2 * leg + plate, high = 40, step = 4, deep = 8;
  constexpr double dx = 0.01;
  WorldDesc d = box(s, dx, {wide, high + 30, deep}, Face::wall, Face::wall, Face::periodic);
  d.domain.no_slip = false;
  Run run(d, r);
  const auto between = [&](int left, int right, int bottom, int top) {
    return Shape::box({left * dx, bottom * dx, 0}, {right * dx, top * dx, deep * dx});
  };
  SolidDesc held;
  held.shape = between(leg, leg + plate, leg, high + 30);
  held.material = run.material("steel", 8000, 0);
  held.fixed = true;
  run.solid(held);
  const MaterialId water = run.material("water", 1000, 1e-3);
  run.fluid(between(0, leg, 0, high + step), water);
  run.fluid(between(leg, leg + plate, 0, leg), water);
  run.fluid(between(leg + plate, wide, 0, high - step), water);
  const double length = (2 * (high - 0.5 * leg) + leg + plate) * dx,
               period = 2 * pi * std::sqrt(0.5 * length / g);
  Curve ours{"meltsim", {}, {}, false}, theory{"thin tube", {}, {}, true};
  for (int k = 0; k <= 80; ++k) {
    const double t = 0.02 * k * period;
    if (!run.to(t)) return;
    const ParticleData p = run.particles();
    double more = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (!is_solid(p.tag[i])) more += p.position[i].x < 0.5 * wide * dx ? 0.5 : -0.5;
    ours.x.push_back(t / period);
    ours.y.push_back(more / (leg * deep));
    theory.x.push_back(t / period);
    theory.y.push_back(step * std::cos(2 * pi * t / period));
  }
  std::vector<double> crossings;
  for (std::size_t i = 1; i < ours.x.size(); ++i)
    if (ours.y[i - 1] * ours.y[i] < 0)
      crossings.push_back(ours.x[i - 1] +
                          (ours.x[i] - ours.x[i - 1]) * ours.y[i - 1] / (ours.y[i - 1] - ours.y[i]));
  if (crossings.size() < 3) {
    r.error = "the water has stopped swinging";
    return;
  }
  r.relative("period", (crossings[2] - crossings[0]) * period, period, 5,
             "legs as wide as a fifth of their length: water turns inside of the bend's middle");
  r.relative("how far it swings after half a period", -*std::min_element(ours.y.begin(), ours.y.end()), step,
             15, "half a spacing of the 4: what a surface of particles resolves");
  r.plots.push_back({"coupling_u_tube", "Water in a U-tube", "t / T", "level, spacings", {ours, theory}});
}

}  // namespace

std::vector<Case> coupling_cases() {
  return {
      {"coupling.floating", "draught of cubes lighter than water", "Archimedes", false, floats},
      {"coupling.sinking", "cubes heavier than water rest on the floor", "Archimedes", false, sinks},
      {"coupling.endurance_light", "cubes of 100 to 900 kg/m^3 for 1e5 sub-steps", "stability", true,
       endures_light},
      {"coupling.endurance_heavy", "cubes of 1000 to 10000 kg/m^3 for 1e5 sub-steps", "stability", true,
       endures_heavy},
      {"coupling.neutral", "a cube as dense as water, 10 s", "Archimedes", true, neutral},
      {"coupling.contact_start", "a light cube released under water", "energy", false, contact_start},
      {"coupling.thin_plate", "a plate one particle thick holds water", "nothing leaks", false, thin_plate},
      {"coupling.momentum", "a cube meets liquid in a periodic box", "conservation", false, momentum},
      {"coupling.stratified", "a light liquid stays on a heavy one", "stability", false, stratified},
      {"coupling.overturn", "a heavy liquid sinks through a light one", "Rayleigh-Taylor instability", true,
       overturn},
      {"coupling.added_mass", "a sphere set in motion in liquid", "potential flow; Zuber (1964) for an array",
       false, added_mass},
      {"coupling.heave", "a half-submerged sphere let go", "Kramer et al. (2021), Energies 14:269", true,
       heave},
      {"coupling.settling", "a sphere sinks from rest", "Schiller & Naumann (1933), Mei & Adrian (1992)",
       true, settling},
      {"coupling.rising", "lighter and hardly heavier spheres, from rest",
       "Schiller & Naumann (1933), Mei & Adrian (1992)", true, rising},
      {"coupling.from_rest", "hardly heavier spheres, pressure counted from rest",
       "Schiller & Naumann (1933), Mei & Adrian (1992)", true, from_rest},
      {"coupling.drift", "a sphere pushed from rest through liquid without weight",
       "Schiller & Naumann (1933), Mei & Adrian (1992)", true, drift},
      {"coupling.stream", "a warm sphere held in a stream",
       "Clift, Grace & Weber (1978), eq. 5-25; Schiller & Naumann (1933)", true, stream},
      {"coupling.pressed_stream", "the same in a stream that its weight presses",
       "Clift, Grace & Weber (1978), eq. 5-25; Schiller & Naumann (1933)", true, pressed_stream},
      {"coupling.jet", "a jet strikes a held plate", "balance of momentum", true, jet_on_plate},
      {"coupling.u_tube", "water swings around a held plate", "a thin tube without friction", false, u_tube},
      {"coupling.stokes", "slow flow through a cubic array of spheres", "Hasimoto (1959)", false, stokes},
  };
}

}  // namespace validation
