// SPDX-License-Identifier: Apache-2.0
// What is dissolved, and bodies that dissolve: diffusion, fronts, balances, buoyancy. Lengths in spacings unless said otherwise:
// D dt/dx^2 is chosen, and the species runs as much faster than motion.
#include <cmath>
#include <vector>

#include "dissolving.hpp"
#include "run.hpp"

namespace validation {
namespace {

constexpr double dx = 0.01, diffusivity = 1e-5;

/// A closed box at rest; D dt/dx^2 = `pace` in a step of 0.01 s.
WorldDesc still(const Settings& s, Vec3i cells, double pace, Face across = Face::wall) {
  WorldDesc d = box(s, dx, cells, Face::wall, across, across);
  d.gravity = {0, 0, 0};
  d.sound_speed = 1;
  d.solute.time_scale = pace * dx * dx / (diffusivity * 0.01);
  d.solute.max_supersteps = 10000;
  d.heat.model = HeatModel::none;
  return d;
}

/// A species of the solvent's density and viscosity.
MaterialDesc solute(MaterialId solvent, double solubility) {
  MaterialDesc m;
  m.name = "solute";
  m.dissolves_in = solvent;
  m.solubility = solubility;
  m.diffusivity_in = diffusivity;
  return m;
}

void half_spaces(const Settings& s, Report& r) {
  Run run(still(s, {48, 8, 8}, 0.5, Face::periodic), r);
  const MaterialId water = run.material("water", 1000, 1e-3), salt = run.material(solute(water, 1));
  run.fluid(Shape::box({0, 0, 0}, {24 * dx, 8 * dx, 8 * dx}), water, {}, {{salt, 0.8}});
  run.fluid(Shape::box({24 * dx, 0, 0}, {48 * dx, 8 * dx, 8 * dx}), water);
  if (!run.to(0.72, 0.01)) return;  // sqrt(D t) = 6 spacings
  const ParticleData p = run.particles();
  std::vector<double> x, w, exact;
  double error = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const double at = p.position[i].x / dx - 24, expected = 0.5 * std::erfc(at / 12);
    error += std::pow(p.fractions[0][i] / 0.8 - expected, 2) / double(p.id.size());
    if (p.position[i].y > dx || p.position[i].z > dx) continue;
    x.push_back(at);
    w.push_back(p.fractions[0][i] / 0.8);
    exact.push_back(expected);
  }
  r.absolute("L2 error of C/C0, sqrt(D t) = 6 spacings", std::sqrt(error), 0, 1e-3, "-", "asked for");
  r.plots.push_back({"species_half_spaces",
                     "Two half spaces",
                     "x / dx",
                     "C / C0",
                     {{"meltsim", x, w, false}, {"exact", x, exact, true}}});
}

void half_full(const Settings& s, Report& r) {
  constexpr int n = 32;
  Run run(still(s, {n, 16, 16}, 1), r);
  const MaterialId water = run.material("water", 1000, 1e-3), salt = run.material(solute(water, 1));
  run.fluid(Shape::box({0, 0, 0}, {n / 2 * dx, 16 * dx, 16 * dx}), water, {}, {{salt, 1}});
  run.fluid(Shape::box({n / 2 * dx, 0, 0}, {n * dx, 16 * dx, 16 * dx}), water);
  for (const auto& [fourier, expected] :
       {std::pair{0.01, 0.68085}, {0.05, 0.30212}, {0.1, 0.11260}, {0.2, 0.01564}}) {
    if (!run.to(0.01 * fourier * n * n, 0.01)) return;
    const ParticleData p = run.particles();
    double variance = 0;
    for (const double w : p.fractions[0]) variance += (w - 0.5) * (w - 0.5) / double(p.id.size());
    char text[64];
    std::snprintf(text, sizeof text, "variance over the initial one, Fo %g", fourier);
    r.relative(text, 4 * variance, expected, 1, "asked for");
  }
}

/// Volume of what is not dissolved, in cells.
double crystals(const ParticleData& p, double solubility) {
  return undissolved(p, solubility) / (1000 * dx * dx * dx);
}

/// What has left the slab's place at x < `slab` spacings, in cells.
double given_off(const ParticleData& p, int slab, double cells) {
  double left = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (p.position[i].x < slab * dx) left += p.fractions[0][i];
  return slab - left / cells;
}

// u = w_s erfc(x/(2 sqrt(D t)))/erfc(-lambda) from the front at x = -2 lambda sqrt(D t) on: beyond x = 0 are
// 2 w_s sqrt(D t/pi)/erfc(-lambda), by which the front is read. Cells tell no other one: what a front in one of them has dissolved is not
// saturated throughout. Exact contents, read as if it were, give a front that is up to 34 % off (B = 2).
void slab(const Settings& s, Report& r) {
  struct Front {
    double b, pace;
    int slab, liquid;
    double thickness;
  };
  Plot plot{"species_slab", "Front of a dissolving slab", "2 lambda sqrt(D t) / dx", "front / dx", {}};
  for (const Front& f :
       {Front{0.1, 1, 6, 74, 2.5}, {0.5, 0.1, 8, 56, 6}, {1, 0.1, 10, 54, 8}, {2, 0.1, 14, 42, 12}}) {
    if (!r.error.empty()) return;
    const double solubility = f.b / (1 + f.b), lambda = dissolving_slab(f.b);
    Run run(still(s, {f.slab + f.liquid, 8, 8}, f.pace, Face::periodic), r);
    const MaterialId water = run.material("water", 1000, 1e-3),
                     salt = run.material(solute(water, solubility));
    run.solid("slab", Shape::box({0, 0, 0}, {f.slab * dx, 8 * dx, 8 * dx}), salt, {}, true);
    run.fluid(Shape::box({f.slab * dx, 0, 0}, {(f.slab + f.liquid) * dx, 8 * dx, 8 * dx}), water);
    const double per_cell = lambda * std::sqrt(pi) * std::erfc(-lambda) / solubility;
    std::vector<double> at, found;
    double early = 0, half = 0, late = 0, front = 0;
    // Ten steps for one until D t = 2 dx^2: the front of B = 2 is through its first cell at 0.9.
    double now = 0;
    while (front < f.thickness && now < 40) {
      const double step = f.pace * now < 0.0199 ? 0.001 : 0.01;
      now += step;
      if (!run.to(now, step)) return;
      const ParticleData p = run.particles();
      front = per_cell * given_off(p, f.slab, 64);
      const double expected = 2 * lambda * std::sqrt(100 * f.pace * now);
      at.push_back(expected);
      found.push_back(front);
      if (expected > 0.5) {
        early = std::max(early, std::fabs(front - expected));
        half = std::max(half, 100 * std::fabs(front / expected - 1));
      }
      if (expected > 2) late = std::max(late, 100 * std::fabs(front / expected - 1));
    }
    char b[32];
    std::snprintf(b, sizeof b, ", B = %g", f.b);
    r.absolute(std::string("largest error of the front from half a cell on") + b, half, 0, 1.5, "%",
               "asked for");
    r.absolute(std::string("the same in spacings") + b, early, 0, 0.05, "spacings", "a twentieth of a cell");
    r.absolute(std::string("the same from 2 cells on") + b, late, 0, 1.5, "%", "asked for");
    plot.curves.push_back({std::string("meltsim") + b, at, found, false});
  }
  plot.curves.push_back({"exact", {0, 12}, {0, 12}, true});
  r.plots.push_back(plot);
  r.note =
      "The front is read by what has left the slab's place; a cell's content alone does not tell where a "
      "front in it is. At first the layer at the face is thinner than the spacing (0.46 spacings at half a "
      "cell, B = 2).";
}

/// An eighth of a sphere in a corner, whose walls are planes of symmetry.
void sphere_of(const Settings& s, Report& r, int radius, double b, double reference, double reach) {
  if (!r.error.empty()) return;
  const int n = static_cast<int>(std::ceil(reach * radius));
  const double solubility = b / (1 + b);
  Run run(still(s, {n, n, n}, 1), r);
  const MaterialId water = run.material("water", 1000, 1e-3), salt = run.material(solute(water, solubility));
  const double edge = n * dx;
  run.solid(
      "sphere",
      Shape::intersect({Shape::sphere({0, 0, 0}, radius * dx), Shape::box({0, 0, 0}, {edge, edge, edge})}),
      salt, {}, true);
  run.fluid(Shape::box({0, 0, 0}, {edge, edge, edge}), water);
  double volume = 0;
  const ParticleData first = run.particles();
  for (const std::uint32_t tag : first.tag) volume += is_solid(tag) ? 1 : 0;
  const double sampled = std::cbrt(8 * volume * 3 / (4 * pi));  // its radius [spacings]
  const double least = 0.002 * volume;
  double before = volume, nearly = 0, vanished = 0;
  for (int k = 1; vanished == 0 && k < 4 * radius * radius; ++k) {
    if (!run.to(0.01 * k, 0.01)) return;
    const double now = crystals(run.particles(), solubility);
    if (nearly == 0 && now <= least) nearly = k - 1 + (before - least) / std::max(before - now, 1e-30);
    if (run.last().solid == 0) vanished = k;
    before = now;
  }
  char text[96];
  std::snprintf(text, sizeof text, "D t/R^2 to vanish, B = %g, R = %d spacings", b, radius);
  r.relative(text, vanished / (sampled * sampled), reference, 5,
             radius >= 15 ? "asked for" : "asked for at R = 15");
  std::snprintf(text, sizeof text, "the same until 0.2 %% is left, B = %g, R = %d", b, radius);
  r.relative(text, nearly / (sampled * sampled), dissolving_ball(b, 0.002, reach), 1,
             "a radial solution, converged");
}
void sphere(const Settings& s, Report& r) {
  for (const int radius : {8}) {
    sphere_of(s, r, radius, 1, 0.451, 3.7);
    sphere_of(s, r, radius, 0.5, 0.834, 4.5);
  }
}
void sphere_large(const Settings& s, Report& r) { sphere_of(s, r, 15, 1, 0.451, 3.7); }

void saturated(const Settings& s, Report& r) {
  constexpr double solubility = 0.4;
  Run run(still(s, {8, 8, 8}, 1), r);
  const MaterialId water = run.material("water", 1000, 1e-3), sugar = run.material(solute(water, solubility));
  run.solid("sugar", Shape::box({0, 0, 0}, {4 * dx, 8 * dx, 8 * dx}), sugar, {}, true);
  run.fluid(Shape::box({4 * dx, 0, 0}, {8 * dx, 8 * dx, 8 * dx}), water);
  if (!run.good()) return;
  const double half = run.ledger().solute[0], expected = half - solubility * half / (1 - solubility);
  if (!run.to(4, 0.01)) return;
  r.absolute("what stays behind of too much sugar, relative error",
             std::fabs(crystals(run.particles(), solubility) * 1000 * dx * dx * dx / expected - 1), 0, 1e-6,
             "-", "asked for");
  r.absolute("change of the sugar, relative", std::fabs(run.ledger().solute[0] / half - 1), 0, 1e-12, "-",
             "sums are double in either precision");
}

void salt(const Settings& s, Report& r) {
  constexpr double heat = 3900 / 0.05844;  // J/kg
  WorldDesc d = still(s, {10, 10, 10}, 1);
  d.heat.model = HeatModel::enthalpy;
  d.heat.time_scale = 1e5;
  Run run(d, r);
  const MaterialId water = run.material("water", 1000, 1e-3);
  MaterialDesc m = solute(water, 0.264);
  m.density = 2160;
  m.heat_of_solution = heat;
  const MaterialId body = run.material(m);
  run.solid("salt", Shape::box({0, 0, 0}, {10 * dx, 10 * dx, dx}), body, {}, true);
  run.fluid(Shape::box({0, 0, dx}, {10 * dx, 10 * dx, 10 * dx}), water);
  if (!run.good()) return;
  const Ledger before = run.ledger();
  double off = 0;
  for (int k = 1; k <= 60; ++k) {
    if (!run.to(0.1 * k, 0.01)) return;
    const Ledger now = run.ledger();
    off = std::max(off, std::fabs(now.thermal + now.solution - before.thermal - before.solution));
  }
  const Ledger after = run.ledger();
  const double expected = 20 - heat * after.solute[0] / (after.mass * 4186);
  char text[96];
  std::snprintf(text, sizeof text, "temperature of %.3g g of salt in 100 g of water [C]",
                100 * after.solute[0] / (after.mass - after.solute[0]));
  r.absolute(text, run.totals().temperature_mean, expected, 0.01, "K", "asked for");
  r.absolute("largest error of the ledger, relative to the heat of solution", off / (heat * after.solute[0]),
             0, 1e-6, "-", "asked for");
  r.absolute("solid particles left", static_cast<double>(run.last().solid), 0, 0, "-", "all of it dissolves");
}

/// Saturated at 0.3 at 20 degrees and at 0.5 at 60.
MaterialDesc precipitating(MaterialId solvent) {
  MaterialDesc m = solute(solvent, 1);
  m.solubility_points = {{20, 0.3}, {60, 0.5}};
  return m;
}

/// Fixed, `thickness` spacings from x = 0 on, with sites for `growth` more; liquid beside it up to the end of the box.
void crystal_in_solution(Run& run, Vec3i cells, int thickness, int growth, double fraction, double heat) {
  const MaterialId water = run.material("water", 1000, 1e-3);
  MaterialDesc m = precipitating(water);
  m.heat_of_solution = heat;
  const MaterialId salt = run.material(m);
  const Vec3d end{cells.x * dx, cells.y * dx, cells.z * dx};
  SolidDesc b;
  b.shape = Shape::box({0, 0, 0}, {thickness * dx, end.y, end.z});
  b.material = salt;
  b.fixed = true;
  b.growth = growth;
  run.solid(b);
  run.fluid(Shape::box({thickness * dx, 0, 0}, end), water, {}, {{salt, fraction}});
}

/// Mass of what is crystal [kg], of bodies and of liquid that has more than saturation.
double precipitated(const ParticleData& p, double saturation) {
  double sum = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    sum += std::max(0.0, p.fractions[0][i] - saturation) / (1 - saturation) * p.mass[i];
  return sum;
}

// A solution of w = 0.5 that holds 0.3, beside a crystal, until the slowest mode is gone: it falls by exp(-0.038) per step.
void precipitation(const Settings& s, Report& r) {
  constexpr Vec3i cells{11, 6, 6};
  for (const double heat : {0.0, 2e5}) {
    WorldDesc d = still(s, cells, 1);
    if (heat > 0) {
      d.heat.model = HeatModel::enthalpy;
      d.heat.time_scale = 1e5;
    }
    Run run(d, r);
    crystal_in_solution(run, cells, 3, 4, 0.5, heat);
    if (!run.good()) return;
    const Ledger before = run.ledger();
    double off = 0, lost = 0;
    for (int k = 1; k <= 12; ++k) {
      if (!run.to(0.5 * k, 0.01)) return;
      const Ledger now = run.ledger();
      off = std::max(off, std::fabs(now.thermal + now.solution - before.thermal - before.solution));
      lost = std::max(lost, std::fabs(now.solute[0] / before.solute[0] - 1));
    }
    const Ledger now = run.ledger();
    const double temperature = run.totals().temperature_mean;
    const double saturation = heat > 0 ? 0.3 + 0.2 * (temperature - 20) / 40 : 0.3;
    const double water = now.mass - now.solute[0];
    const double dissolved = now.solute[0] - precipitated(run.particles(), saturation);
    r.absolute(
        heat > 0 ? "the same where the heat of solution warms it" : "what stays in solution, relative error",
        std::fabs(dissolved / (saturation * water / (1 - saturation)) - 1), 0, heat > 0 ? 1e-5 : 1e-6, "-",
        heat > 0 ? "saturation of the temperature found, read to 1e-3 K"
                 : "w_s W/(1 - w_s) of W of water; as for what dissolves");
    if (heat == 0) {
      r.absolute("change of the sum of contents, relative", lost, 0, 1e-12, "-", "sums are double");
      continue;
    }
    r.absolute("warming over the heat given back/(m c), relative error",
               std::fabs((temperature - 20) * now.mass * 4186 / (before.solution - now.solution) - 1), 0,
               1e-5, "-", "read to 1e-4 K of 10");
    r.absolute("largest error of the ledger, relative to the heat given back",
               off / (before.solution - now.solution), 0, 1e-6, "-", "as for what dissolves");
  }
}

// Front 2 lambda sqrt(D t) of a crystal that grows from a solution of w: sqrt(pi) lambda exp(lambda^2) erfc(lambda) =
// (w - w_s)/(1 - w_s).
void growth(const Settings& s, Report& r) {
  constexpr double pace = 0.5, saturation = 0.3;
  constexpr Vec3i cells{48, 8, 8};
  Plot plot{"species_growth", "Front of a growing crystal", "2 lambda sqrt(D t) / dx", "front / dx", {}};
  for (const double content : {0.4, 0.5}) {
    double low = 0, high = 3;
    for (int k = 0; k < 60; ++k) {
      const double l = (low + high) / 2;
      (std::sqrt(pi) * l * std::exp(l * l) * std::erfc(l) < (content - saturation) / (1 - saturation)
           ? low
           : high) = l;
    }
    Run run(still(s, cells, pace, Face::periodic), r);
    crystal_in_solution(run, cells, 3, 8, content, 0);
    std::vector<double> at, found;
    double off = 0;
    int k = 0;
    // Until the layer in the solution reaches the end of the box.
    for (double front = 0.5; front <= 4; front += 0.5) {
      k = std::max(k + 1, static_cast<int>(front * front / (4 * low * low) / pace));
      if (!run.to(0.01 * k, 0.01)) return;
      // Crystal is what bodies hold beyond saturation, and the layer of liquid beside them.
      const ParticleData p = run.particles();
      double edge = 0, sum = 0;
      for (std::size_t i = 0; i < p.id.size(); ++i)
        if (is_solid(p.tag[i])) edge = std::max(edge, p.position[i].x);
      for (std::size_t i = 0; i < p.id.size(); ++i)
        if (p.position[i].x < edge + 1.5 * dx)
          sum += std::max(0.0, p.fractions[0][i] - saturation) / (1 - saturation);
      at.push_back(2 * low * std::sqrt(pace * k));
      found.push_back(sum / 64 - 3);
      off = std::max(off, std::fabs(found.back() - at.back()));
    }
    char text[96];
    std::snprintf(text, sizeof text, "largest error of the front from half a cell to 4, w = %g", content);
    r.absolute(text, off, 0, 0.1, "spacings", "a cell takes in its content as a whole");
    std::snprintf(text, sizeof text, "meltsim, w = %g", content);
    plot.curves.push_back({text, at, found, false});
  }
  plot.curves.push_back({"exact", {0, 4}, {0, 4}, true});
  r.plots.push_back(plot);
}

/// A lock is opened: the heavier half, of salt water, runs below the lighter one.
void lock_of(const Settings& s, Report& r, int depth) {
  Plot plot{"species_lock_" + std::to_string(depth), "Lock exchange", "t sqrt(g'/H)", "front / H", {}};
  {
    constexpr double contrast = 0.05, gravity = 9.81;
    const double high = depth * dx;
    WorldDesc d = box(s, dx, {8 * depth, depth + depth / 2, 8}, Face::wall, Face::wall, Face::periodic);
    d.gravity = {0, -gravity, 0};
    d.domain.no_slip = false;
    d.artificial_viscosity = 0.01;
    d.isotropic_pressure = true;
    d.sound_speed = 10 * std::sqrt(2 * gravity * high);
    d.heat.model = HeatModel::none;
    Run run(d, r);
    const MaterialId water = run.material("water", 1000, 1e-3);
    MaterialDesc m = solute(water, 1);
    m.density = 1000 * (1 + contrast);
    m.diffusivity_in = 1e-9;
    const MaterialId brine = run.material(m);
    const double middle = 4 * high;
    // Of equal weight, so that no wave runs ahead.
    run.fluid(Shape::box({0, 0, 0}, {middle, high, 8 * dx}), water, {}, {{brine, 1}});
    run.fluid(Shape::box({middle, 0, 0}, {2 * middle, high, 8 * dx}), water);
    const double reduced = gravity * contrast / (1 + contrast), unit = std::sqrt(high / reduced);
    std::vector<double> t, x;
    double from = 0, begin = 0, until = 0, end = 0;
    for (int k = 1; k <= 80; ++k) {
      if (!run.to(0.1 * unit * k, 0.05)) return;
      const ParticleData p = run.particles();
      double front = middle;
      for (std::size_t i = 0; i < p.id.size(); ++i)
        if (p.fractions[0][i] > 0.5) front = std::max(front, p.position[i].x);
      t.push_back(0.1 * k);
      x.push_back((front - middle) / high);
      if (begin == 0 && x.back() >= 1) begin = t.back(), from = x.back();
      if (begin != 0 && x.back() <= 2.5) end = t.back(), until = x.back();
      if (x.back() > 2.5) break;
    }
    r.absolute("front speed over sqrt(g' H), H = " + std::to_string(depth) + " spacings",
               (until - from) / (end - begin), 0.48, 0.02, "-", "0.46 to 0.5, asked for");
    plot.curves.push_back({"meltsim, " + std::to_string(depth) + " spacings", t, x, false});
  }
  r.plots.push_back(plot);
}

void lock(const Settings& s, Report& r) { lock_of(s, r, 20); }
void lock_fine(const Settings& s, Report& r) { lock_of(s, r, 30); }

// A block of stronger solution falls into a weaker one.
void conserved(const Settings& s, Report& r) {
  WorldDesc d = box(s, dx, {20, 24, 10}, Face::wall, Face::wall, Face::wall);
  d.solute.time_scale = 200;
  d.heat.model = HeatModel::none;
  Run run(d, r);
  const MaterialId water = run.material("water", 1000, 1e-3);
  MaterialDesc m = solute(water, 1);
  m.density = 2000;
  const MaterialId salt = run.material(m);
  run.fluid(Shape::box({0, 0, 0}, {20 * dx, 6 * dx, 10 * dx}), water, {}, {{salt, 0.1}});
  run.fluid(Shape::box({4 * dx, 8 * dx, 2 * dx}, {12 * dx, 18 * dx, 8 * dx}), water, {0.5, -0.5, 0},
            {{salt, 0.6}});
  if (!run.good()) return;
  const double before = run.ledger().solute[0];
  if (!run.to(0.6, 0.005)) return;
  double low = 1, high = 0;
  const ParticleData p = run.particles();
  for (const double w : p.fractions[0]) {
    low = std::min(low, w);
    high = std::max(high, w);
  }
  const double slack = s.precision == Precision::double_precision ? 1e-14 : 1e-6;
  r.absolute("change of the sum of contents, relative", std::fabs(run.ledger().solute[0] / before - 1), 0,
             1e-12, "-", "asked for; sums are double in either precision");
  r.absolute("contents beyond those at first, 0.1 to 0.6", std::max({0.0, 0.1 - low, high - 0.6}), 0, slack,
             "-", "potentials are rounded to the World's precision");
}

}  // namespace

std::vector<Case> species_cases() {
  return {
      {"species.half_spaces", "a species diffuses between two half spaces", "error function", false,
       half_spaces},
      {"species.half_full", "a closed box half full of a species mixes", "series", false, half_full},
      {"species.slab", "a slab dissolves", "similarity solution", false, slab},
      {"species.sphere", "a sphere dissolves until it is gone", "quasi-exact solution", true, sphere},
      {"species.sphere_large", "the same, of 15 spacings", "quasi-exact solution", true, sphere_large},
      {"species.saturated", "too much sugar in a closed tank", "balance", false, saturated},
      {"species.salt", "salt cools the water that it dissolves in", "balance", false, salt},
      {"species.precipitation", "what a solution that holds too much puts onto a crystal", "balance", false,
       precipitation},
      {"species.growth", "a crystal grows", "similarity solution", false, growth},
      {"species.lock_exchange", "salt water runs below fresh water", "Shin, Dalziel & Linden (2004)", true,
       lock},
      {"species.lock_fine", "the same, 30 spacings deep", "Shin, Dalziel & Linden (2004)", true, lock_fine},
      {"species.conserved", "contents in a splash", "conservation", false, conserved},
  };
}

}  // namespace validation
