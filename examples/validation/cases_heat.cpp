// SPDX-License-Identifier: Apache-2.0
// Heat: conduction, surfaces, sources, properties that depend on temperature, and the two models of the
// literature.
#include <cmath>
#include <functional>

#include "constants.hpp"
#include "meltsim/physics/heat_boundary.hpp"
#include "validation.hpp"

namespace validation {

using namespace meltsim;

namespace {

constexpr double dx = 0.1;               // [m]
constexpr double side = 8 * dx;          // periodic sideways: the least that 3 support radii allow
constexpr double diffusivity = 1e-3;     // [m^2/s]
constexpr double heat_per_volume = 1e6;  // rho c [J/(m^3 K)]
constexpr double conductivity = diffusivity * heat_per_volume;

MaterialDesc substance(const char* name = "substance") {
  MaterialDesc m;
  m.name = name;
  m.density = 1000;
  m.heat_capacity = heat_per_volume / m.density;
  m.conductivity = conductivity;
  return m;
}

/// A fixed body that fills a box between walls at -x and +x, periodic sideways.
WorldDesc bar_desc(const Settings& s, int cells) {
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = {};
  d.domain.bounded = true;
  d.domain.max = {cells * dx, side, side};
  d.domain.faces = {Face::wall, Face::wall, Face::periodic, Face::periodic, Face::periodic, Face::periodic};
  return d;
}

struct Body {
  World world;
  bool ok = false;
};

/// A World with one fixed body.
Body body_of(Report& report, const WorldDesc& d, const MaterialDesc& m, SolidDesc solid, double temperature) {
  auto world = World::create(d);
  if (!world) {
    report.error = world.error().message;
    return {*World::create({}), false};
  }
  Body b{std::move(*world), false};
  const auto id = b.world.add_material(m);
  if (!id) {
    report.error = id.error().message;
    return b;
  }
  solid.material = *id;
  solid.temperature = temperature;
  solid.fixed = true;
  const auto added = b.world.add_solid(solid);
  if (!added) report.error = added.error().message;
  b.ok = static_cast<bool>(added);
  return b;
}

Body bar(Report& report, const WorldDesc& d, const MaterialDesc& m, double temperature) {
  SolidDesc s;
  s.shape = Shape::box(d.domain.min, d.domain.max);
  return body_of(report, d, m, s, temperature);
}

/// Two fixed bodies, `half` cells long each, that touch in the middle of a bar.
Body halves(Report& report, const WorldDesc& d, int half, const MaterialDesc& left, double left_temperature,
            const MaterialDesc& right, double right_temperature) {
  SolidDesc s;
  s.shape = Shape::box({0, 0, 0}, {half * dx, side, side});
  Body b = body_of(report, d, left, s, left_temperature);
  if (!b.ok) return b;
  b.ok = false;
  const auto id =
      right.name == left.name ? Result<MaterialId>(MaterialId{0, 1}) : b.world.add_material(right);
  s.shape = Shape::box({half * dx, 0, 0}, {2 * half * dx, side, side});
  s.fixed = true;
  s.temperature = right_temperature;
  if (id) s.material = *id;
  const auto added = b.world.add_solid(s);
  if (!id || !added) report.error = id ? added.error().message : id.error().message;
  b.ok = report.error.empty();
  return b;
}

/// Steps to `until` in steps of `dt` (the last one shorter); false when the World refused or halted.
bool run_to(Report& report, World& world, double until, double dt) {
  while (world.time() < until * (1 - 1e-12)) {
    const Status s = world.step(std::min(dt, until - world.time()));
    if (!s) {
      report.error = s.error().message;
      return false;
    }
  }
  const StepResult r = world.synchronize();
  if (r.halted) report.error = r.halt_reason;
  if (r.heat_bound_exceeded) report.error = "the heat stages were too few";
  return report.error.empty();
}

/// Mean temperature of the particles for which `where` holds.
double mean_temperature(World& world, const std::function<bool(Vec3d)>& where) {
  const auto p = *world.particles();
  double sum = 0;
  int n = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (where(p.position[i])) {
      sum += p.temperature[i];
      ++n;
    }
  return sum / std::max(n, 1);
}

/// Temperature along the bar, one value per cell.
Curve profile(World& world, const std::string& name) {
  const auto p = *world.particles();
  std::vector<double> sum, n;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const auto k = static_cast<std::size_t>(std::max(0.0, p.position[i].x / dx));
    if (k >= sum.size()) sum.resize(k + 1), n.resize(k + 1);
    sum[k] += p.temperature[i];
    n[k] += 1;
  }
  Curve c;
  c.name = name;
  for (std::size_t k = 0; k < sum.size(); ++k) {
    c.x.push_back((static_cast<double>(k) + 0.5) * dx);
    c.y.push_back(sum[k] / n[k]);
  }
  return c;
}

double l2_error(const Curve& ours, const std::function<double(double)>& exact) {
  double error = 0, norm = 0;
  for (std::size_t k = 0; k < ours.x.size(); ++k) {
    error += std::pow(ours.y[k] - exact(ours.x[k]), 2);
    norm += std::pow(exact(ours.x[k]), 2);
  }
  return std::sqrt(error / norm);
}

Curve reference(const Curve& ours, const std::string& name, const std::function<double(double)>& exact) {
  Curve c = ours;
  c.name = name;
  c.reference = true;
  for (std::size_t k = 0; k < c.x.size(); ++k) c.y[k] = exact(c.x[k]);
  return c;
}

// ------------------------------------------------------------------------------------------------ conduction

void half_spaces(const Settings& s, Report& report) {
  Plot plot{"heat_half_spaces", "Two half-spaces after alpha t = 150 dx^2", "x [m]", "temperature [C]", {}};
  for (const double fourier : {0.1, 1.0, 5.0, 25.0}) {
    // sqrt(alpha t) = 6 and 12 dx: several steps even at Fo 25, and the front stays 5 such lengths inside.
    const int half = fourier < 5 ? 32 : 64;
    const double until = fourier < 5 ? 375 : 1500;
    Body b = halves(report, bar_desc(s, 2 * half), half, substance(), 1, substance(), 0);
    if (!b.ok || !run_to(report, b.world, until, fourier * dx * dx / diffusivity)) return;
    const auto exact = [=](double x) {
      return 0.5 * std::erfc((x - half * dx) / (2 * std::sqrt(diffusivity * until)));
    };
    const Curve ours = profile(b.world, "Fo " + std::to_string(fourier).substr(0, 4));
    report.absolute("L2 of the profile, step of Fo " + std::to_string(fourier).substr(0, 4),
                    l2_error(ours, exact), 0, fourier <= 1 ? 1e-3 : 1e-2, "-",
                    "second order in space, 6 and 12 cells per diffusion length");
    if (fourier >= 5) plot.curves.push_back(ours);
    if (fourier == 25.0) plot.curves.push_back(reference(ours, "0.5 erfc", exact));
  }
  report.plots.push_back(plot);
}

/// Two materials in contact: ice at -10 against water at 40 (both fixed, no phase change): 11.476 C.
void contact(const Settings& s, Report& report) {
  constexpr int half = 80;
  MaterialDesc water = substance("water"), ice = substance("ice");
  water.heat_capacity = 4217, water.conductivity = 0.561 * 1000;  // 1000 times faster than real: a time lapse
  ice.heat_capacity = 2050, ice.conductivity = 2.22 * 1000, ice.density = 917;
  const double e_water = std::sqrt(0.561 * 1000 * 4217), e_ice = std::sqrt(2.22 * 917 * 2050);
  Body b = halves(report, bar_desc(s, 2 * half), half, ice, -10, water, 40);
  if (!b.ok) return;
  const double energy = b.world.totals()->thermal;
  const double until = 1000, a_ice = 1000 * 2.22 / (917 * 2050), a_water = 1000 * 0.561 / (1000 * 4217);
  if (!run_to(report, b.world, until, until / 200)) return;
  const Curve ours = profile(b.world, "meltsim");
  const double T = (e_ice * -10 + e_water * 40) / (e_ice + e_water);
  const auto exact = [&](double x) {
    const double z = x - half * dx;
    return z < 0 ? T + (-10 - T) * std::erf(-z / (2 * std::sqrt(a_ice * until)))
                 : T + (40 - T) * std::erf(z / (2 * std::sqrt(a_water * until)));
  };
  // Profile fit: the exact curve's contact temperature that fits the cells on both sides best.
  double weight = 0, fit = 0;
  for (std::size_t k = 0; k < ours.x.size(); ++k) {
    const double z = ours.x[k] - half * dx, a = z < 0 ? a_ice : a_water, far = z < 0 ? -10 : 40;
    const double f = std::erfc(std::fabs(z) / (2 * std::sqrt(a * until)));
    fit += f * (ours.y[k] - far * (1 - f));
    weight += f * f;
  }
  report.absolute("contact temperature by profile fit", fit / weight, T, 0.1, "C", "validation target");
  report.absolute("energy, relative drift", std::fabs(b.world.totals()->thermal / energy - 1), 0, 1e-6, "-",
                  "exchange is antisymmetric, sums are double");
  report.plots.push_back({"heat_contact",
                          "Ice at -10 against water at 40",
                          "x [m]",
                          "temperature [C]",
                          {ours, reference(ours, "exact", exact)}});
}

void slab(const Settings& s, Report& report) {
  constexpr int cells = 40;
  WorldDesc d = bar_desc(s, cells);
  d.domain.heat[0].temperature = d.domain.heat[1].temperature = 0;
  Body b = bar(report, d, substance(), 1);
  const double L = cells * dx;
  Plot plot{"heat_slab",
            "Slab of 40 cells, both faces held at 0",
            "alpha t / L^2",
            "temperature at the centre",
            {}};
  Curve ours{"meltsim", {}, {}, false}, exact{"series", {}, {}, true};
  const double times[] = {.01, .02, .05, .1, .2, .5},
               values[] = {.999186, .975161, .772312, .474487, .176867, .009157};
  for (int k = 0; b.ok && k < 6; ++k) {
    if (!run_to(report, b.world, times[k] * L * L / diffusivity, 0.0025 * L * L / diffusivity)) return;
    const double T = mean_temperature(b.world, [&](Vec3d x) { return std::fabs(x.x - L / 2) < dx; });
    report.relative("centre at alpha t/L^2 " + std::to_string(times[k]).substr(0, 4), T, values[k], 1,
                    "second order in 1/40; the two middle cells read 0.1 % low");
    ours.x.push_back(times[k]), ours.y.push_back(T);
    exact.x.push_back(times[k]), exact.y.push_back(values[k]);
  }
  plot.curves = {ours, exact};
  report.plots.push_back(plot);
}

void cube(const Settings& s, Report& report) {
  constexpr int cells = 41;  // odd: a particle stands at the centre
  const double L = cells * dx;
  WorldDesc d = bar_desc(s, cells);
  d.domain.max = {L, L, L};
  d.domain.faces.fill(Face::wall);
  for (auto& wall : d.domain.heat) wall.temperature = 0;
  Body b = bar(report, d, substance(), 1);
  const double times[] = {.05, .1, .2}, values[] = {.460657, .106825, .005533};
  for (int k = 0; b.ok && k < 3; ++k) {
    if (!run_to(report, b.world, times[k] * L * L / diffusivity, 0.0025 * L * L / diffusivity)) return;
    const Vec3d c{L / 2, L / 2, L / 2};
    const double T = mean_temperature(b.world, [&](Vec3d x) { return length(x - c) < 0.1 * dx; });
    report.relative("centre at alpha t/L^2 " + std::to_string(times[k]).substr(0, 4), T, values[k], 2,
                    "three slabs multiplied: three times the error of one");
  }
}

void sphere(const Settings& s, Report& report) {
  const double R = 15 * dx;
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = {};
  SolidDesc solid;
  solid.shape = Shape::sphere({dx / 2, dx / 2, dx / 2}, R);  // a particle stands at the centre
  solid.surface.temperature = 0;
  Body b = body_of(report, d, substance(), solid, 1);
  const double times[] = {.05, .1, .2, .5}, values[] = {.965999, .707100, .277078, .014384};
  for (int k = 0; b.ok && k < 4; ++k) {
    if (!run_to(report, b.world, times[k] * R * R / diffusivity, 0.005 * R * R / diffusivity)) return;
    const Vec3d c{dx / 2, dx / 2, dx / 2};
    const double T = mean_temperature(b.world, [&](Vec3d x) { return length(x - c) < 0.1 * dx; });
    report.relative("centre at alpha t/R^2 " + std::to_string(times[k]).substr(0, 4), T, values[k], 2,
                    "validation target at R = 15 dx");
  }
}

// -------------------------------------------------------------------------------------------------- surfaces

/// Bi = 0.01: the body cools as one, T = T_a + (T_0 - T_a) exp(-h A t / (rho c V)).
void lumped(const Settings& s, Report& report) {
  for (const bool ball : {false, true}) {
    const double size = 10 * dx;  // radius; edge
    SolidDesc solid;
    solid.shape = ball ? Shape::sphere({0, 0, 0}, size) : Shape::box({0, 0, 0}, {size, size, size});
    solid.surface.convection = 0.01 * conductivity / size;
    solid.surface.ambient = 20;
    WorldDesc d = world_desc(s);
    d.spacing = dx;
    d.gravity = {};
    Body b = body_of(report, d, substance(), solid, 100);
    if (!b.ok) return;
    const double volume = static_cast<double>(b.world.particles()->id.size()) * dx * dx * dx;
    const double radius = std::cbrt(3 * volume / (4 * pi));  // of the sphere that the particles fill
    const double area = ball ? 4 * pi * radius * radius : 6 * size * size;
    const double tau = heat_per_volume * volume / (solid.surface.convection * area);
    if (!run_to(report, b.world, tau, tau / 200)) return;
    const double T = mean_temperature(b.world, [](Vec3d) { return true; });
    report.relative(
        std::string(ball ? "sphere of radius 10 dx" : "cube of 10 dx") + ", excess after one time constant",
        T - 20, 80 * std::exp(-1.0), 2,
        "the surface is counted on the lattice: boxes 0..+2 %, spheres of radius 5..15 dx +1..-3 %");
  }
}

/// Slab with Bi = 1 at both faces (half thickness L): first six roots of z tan z = Bi.
void biot(const Settings& s, Report& report) {
  constexpr int cells = 40;
  const double L = 0.5 * cells * dx, Bi = 1;
  WorldDesc d = bar_desc(s, cells);
  for (const std::size_t f : {std::size_t{0}, std::size_t{1}}) {
    d.domain.heat[f].convection = Bi * conductivity / L;
    d.domain.heat[f].ambient = 0;
  }
  Body b = bar(report, d, substance(), 1);
  Plot plot{"heat_biot", "Slab cooled by convection, Bi = 1", "x [m]", "temperature", {}};
  for (const double fourier : {0.2, 1.0}) {
    if (!b.ok || !run_to(report, b.world, fourier * L * L / diffusivity, 0.005 * L * L / diffusivity)) return;
    const auto exact = [&](double x) {
      double sum = 0;
      for (int n = 0; n < 6; ++n) {
        double low = n * pi + 1e-9, high = n * pi + pi / 2 - 1e-9;
        for (int k = 0; k < 100; ++k) {
          const double z = 0.5 * (low + high);
          (z * std::tan(z) < Bi ? low : high) = z;
        }
        const double z = low;
        sum += 4 * std::sin(z) / (2 * z + std::sin(2 * z)) * std::exp(-z * z * fourier) *
               std::cos(z * (x - L) / L);
      }
      return sum;
    };
    const Curve ours = profile(b.world, "Fo " + std::to_string(fourier).substr(0, 3));
    report.absolute("L2 of the profile at Fo " + std::to_string(fourier).substr(0, 3), l2_error(ours, exact),
                    0, 0.01, "-", "second order in 1/40");
    plot.curves.push_back(ours);
    plot.curves.push_back(reference(ours, "series", exact));
  }
  report.plots.push_back(plot);
}

/// Constant flux into a half-space: T = 2q/k sqrt(at/pi) exp(-x^2/4at) - q x/k erfc(x/2 sqrt(at)).
void flux(const Settings& s, Report& report) {
  constexpr int cells = 80;
  const double q = 1e4, until = 400;
  WorldDesc d = bar_desc(s, cells);
  d.domain.heat[0].flux = q;
  Body b = bar(report, d, substance(), 0);
  if (!b.ok || !run_to(report, b.world, until, 10)) return;
  const auto exact = [&](double x) {
    const double a = 2 * std::sqrt(diffusivity * until);
    return q / conductivity * (a / std::sqrt(pi) * std::exp(-x * x / (a * a)) - x * std::erfc(x / a));
  };
  const Curve ours = profile(b.world, "meltsim");
  report.absolute("L2 of the profile", l2_error(ours, exact), 0, 0.01, "-", "6 cells per diffusion length");
  const Totals t = *b.world.totals();
  report.relative("heat that came in", t.heat_in, q * side * side * until, 0.5,
                  "the cells' shares of the wall's area add up to it within 0.5 %");
  report.absolute("ledger: (thermal - heat in) / heat in", (t.thermal - t.heat_in) / t.heat_in, 0, 1e-9, "-",
                  "sums in double");
}

/// Radiation cools a small cube: C dT/dt = -eps sigma A (T^4 - T_a^4), integrated with small steps.
void radiation(const Settings& s, Report& report) {
  const double edge = 10 * dx, start = 800, ambient = 20;
  SolidDesc solid;
  solid.shape = Shape::box({0, 0, 0}, {edge, edge, edge});
  solid.surface.emissivity = 0.9;
  solid.surface.ambient = ambient;
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = {};
  MaterialDesc m = substance();
  m.conductivity = 1e4;  // Bi = 0.01: the body cools as one
  Body b = body_of(report, d, m, solid, start);
  if (!b.ok) return;
  const double until = 4000, C = heat_per_volume * edge * edge * edge;
  double T = start;
  constexpr int steps = 100000;
  for (int k = 0; k < steps; ++k) {
    const double a = T + 273.15, e = ambient + 273.15;
    T -= until / steps * 0.9 * 5.670374419e-8 * 6 * edge * edge * (std::pow(a, 4) - std::pow(e, 4)) / C;
  }
  if (!run_to(report, b.world, until, until / 400)) return;
  report.relative("temperature lost by a cube of 10 dx",
                  start - mean_temperature(b.world, [](Vec3d) { return true; }), start - T, 2,
                  "the lattice's count of the surface");
}

/// Heat released everywhere, faces held at 0: T = q x (L - x) / (2 k).
void source(const Settings& s, Report& report) {
  constexpr int cells = 40;
  const double q = 1e4, L = cells * dx;
  WorldDesc d = bar_desc(s, cells);
  d.domain.heat[0].temperature = d.domain.heat[1].temperature = 0;
  SolidDesc solid;
  solid.shape = Shape::box(d.domain.min, d.domain.max);
  solid.heat_source = q;
  Body b = body_of(report, d, substance(), solid, 0);
  if (!b.ok || !run_to(report, b.world, 2 * L * L / diffusivity, 0.02 * L * L / diffusivity)) return;
  const auto exact = [&](double x) { return q * x * (L - x) / (2 * conductivity); };
  const Curve ours = profile(b.world, "meltsim");
  report.absolute("source in a body, L2 of the steady profile", l2_error(ours, exact), 0, 0.01, "-",
                  "second order in 1/40");

  // The same heat from a region over half of an insulated bar: energy and nothing else.
  Body half = bar(report, bar_desc(s, cells), substance(), 0);
  if (!half.ok) return;
  HeatRegionDesc region;
  region.shape = Shape::box({0, 0, 0}, {L / 2, side, side});
  region.source = q;
  region.from = 10;
  region.until = 60;
  const auto added = half.world.add_heat_region(region);
  if (!added) return void(report.error = added.error().message);
  if (!run_to(report, half.world, 100, 10)) return;
  report.relative("source in a region for 50 s, heat that came in", half.world.totals()->heat_in,
                  q * L / 2 * side * side * 50, 1e-3, "whole sub-steps inside the time given");

  // A region that holds half a bar at 1: the other half warms as if its face were held.
  Body held = bar(report, bar_desc(s, 2 * cells), substance(), 0);
  HeatRegionDesc hot;
  hot.shape = Shape::box({0, 0, 0}, {L, side, side});
  hot.temperature = 1;
  const auto holds = held.world.add_heat_region(hot);
  if (!holds) return void(report.error = holds.error().message);
  const double until = 400;
  if (!run_to(report, held.world, until, 10)) return;
  const Totals t = *held.world.totals();
  const double inside = heat_per_volume * L * side * side;
  // The held layer's plane is its particles', half a cell before the first free cell.
  report.relative(
      "region held at 1: heat that crossed into a half-space", t.thermal - inside,
      (2 * conductivity * std::sqrt(until / (pi * diffusivity)) - 0.5 * dx * heat_per_volume) * side * side,
      1, "6 cells per diffusion length");
  report.absolute("ledger: (thermal - heat in) / thermal", (t.thermal - t.heat_in) / t.thermal, 0, 1e-9, "-",
                  "sums in double");
}

// --------------------------------------------------------------------------------- properties and extremes

/// k = k0 (1 + 0.02 T) between faces at 0 and 100, steady: Kirchhoff's transform gives T(x).
void variable(const Settings& s, Report& report) {
  constexpr int cells = 40;
  const double L = cells * dx;
  WorldDesc d = bar_desc(s, cells);
  d.domain.heat[0].temperature = 0;
  d.domain.heat[1].temperature = 100;
  MaterialDesc m = substance();
  m.conductivity_points = {{0, conductivity}, {100, 3 * conductivity}};
  Body b = bar(report, d, m, 50);
  if (!b.ok || !run_to(report, b.world, 2 * L * L / diffusivity, 0.02 * L * L / diffusivity)) return;
  const auto exact = [&](double x) {
    const double theta = x / L * (100 + 0.01 * 100 * 100);  // T + 0.01 T^2
    return (std::sqrt(1 + 0.04 * theta) - 1) / 0.02;
  };
  const Curve ours = profile(b.world, "meltsim");
  report.absolute("k(T): L2 of the steady profile", l2_error(ours, exact), 0, 0.01, "-",
                  "second order in 1/40");
  report.plots.push_back({"heat_conductivity",
                          "Conductivity that triples from 0 to 100 C",
                          "x [m]",
                          "temperature [C]",
                          {ours, reference(ours, "Kirchhoff", exact)}});

  // c = 1000 + 10 T: a known amount of heat gives a known temperature.
  MaterialDesc c = substance();
  c.heat_capacity_points = {{0, 1000}, {100, 2000}};
  WorldDesc closed = bar_desc(s, 10);
  SolidDesc solid;
  solid.shape = Shape::box(closed.domain.min, closed.domain.max);
  solid.heat_source = 1e6;
  Body h = body_of(report, closed, c, solid, 0);
  if (!h.ok || !run_to(report, h.world, 50, 1)) return;
  const double taken = 1e6 * 50 / 1000;  // J/kg = 1000 T + 5 T^2
  report.absolute(
      "c(T): temperature after a known heat", mean_temperature(h.world, [](Vec3d) { return true; }),
      (std::sqrt(1e6 + 20 * taken) - 1000) / 10, 1e-3, "C", "the enthalpy curve is exact; T is single");
}

void extremes(const Settings& s, Report& report) {
  // K = 1e6 m^2/s: uniform, and no drift.
  MaterialDesc m = substance();
  m.diffusivity = 1e6;
  Body b = halves(report, bar_desc(s, 16), 8, m, 80, m, -20);
  if (!b.ok) return;
  const double before = b.world.totals()->thermal;
  if (!run_to(report, b.world, 1e-4, 5e-5)) return;  // alpha t / L^2 = 39; 3000 stages
  const Totals t = *b.world.totals();
  report.absolute("K = 1e6: drift of the energy, relative", std::fabs(t.thermal / before - 1), 0, 1e-6, "-",
                  "validation target");
  report.absolute("K = 1e6: spread of the temperature", t.temperature_max - t.temperature_min, 0, 1e-3, "C",
                  "uniform to the rounding of 3000 stages in single precision");
}

/// The paper's model and the explicit one it is compared with, on the slab of half-spaces.
void models(const Settings& s, Report& report) {
  constexpr int half = 32;
  Plot plot{"heat_models", "Two half-spaces by three models, step of Fo 3", "x [m]", "temperature [C]", {}};
  struct Outcome {
    double l2 = 0, crossed = 0;
    bool flagged = false, bounded = true;
  };
  const auto run = [&](HeatModel model, double fourier, bool plotted) {
    Outcome o;
    WorldDesc d = bar_desc(s, 2 * half);
    d.heat.model = model;
    Body b = halves(report, d, half, substance(), 1, substance(), 0);
    if (!b.ok) return o;
    World& world = b.world;
    const double dt = fourier * dx * dx / diffusivity, until = 375;
    while (world.time() < until - dt / 2) {
      if (!world.step(dt)) break;
      o.flagged = o.flagged || world.synchronize().heat_bound_exceeded;
    }
    const auto exact = [&](double x) {
      return 0.5 * std::erfc((x - half * dx) / (2 * std::sqrt(diffusivity * until)));
    };
    const char* names[] = {"none", "paper", "iwasaki", "enthalpy"};
    const Curve ours = profile(world, names[static_cast<int>(model)]);
    o.l2 = l2_error(ours, exact);
    double crossed = 0, due = 0;
    for (std::size_t k = 0; k < ours.x.size(); ++k) {
      if (ours.x[k] > half * dx) crossed += ours.y[k], due += exact(ours.x[k]);
      o.bounded = o.bounded && ours.y[k] > -0.01 && ours.y[k] < 1.01;
    }
    o.crossed = crossed / due;
    if (plotted) {
      plot.curves.push_back(ours);
      if (model == HeatModel::enthalpy) plot.curves.push_back(reference(ours, "0.5 erfc", exact));
    }
    return o;
  };
  const Outcome small = run(HeatModel::iwasaki, 0.1, false), large = run(HeatModel::iwasaki, 3, false);
  const Outcome paper_small = run(HeatModel::paper, 0.1, false), paper = run(HeatModel::paper, 3, true);
  const Outcome ours = run(HeatModel::enthalpy, 3, true);
  report.absolute("iwasaki, Fo 0.1: L2 of the profile", small.l2, 0, 0.01, "-", "explicit, inside its limit");
  report.absolute("iwasaki, Fo 3: flagged and diverged (1 = both)", large.flagged && !large.bounded ? 1 : 0,
                  1, 0, "-", "dt sum K V L = 9: every explicit scheme diverges here");
  report.absolute("paper, Fo 3: bounded (1 = yes)", paper.bounded ? 1 : 0, 1, 0, "-",
                  "a convex combination at any step: its stated stability");
  report.absolute("paper, Fo 0.1: heat that crossed, share of what should", paper_small.crossed, 0.94, 0.05,
                  "-", "it goes with the square root of the effective diffusivity: 0.91 measured elsewhere");
  report.absolute("paper, Fo 3: heat that crossed, share of what should", paper.crossed, 0.37, 0.08, "-",
                  "0.14 of the diffusivity asked for: its known failing, shown, not a target");
  report.absolute("enthalpy, Fo 3: L2 of the profile", ours.l2, 0, 0.01, "-", "the default on the same step");
  report.plots.push_back(plot);
}

/// Sums by cells along a line, then means over all that was added.
class LineMeans {
 public:
  LineMeans(int cells, double length)
      : cells_(cells), length_(length), bins_(static_cast<std::size_t>(cells)) {}
  void add(double at, double value) {
    Bin& b = bins_[static_cast<std::size_t>(clamp(at / length_ * cells_, 0.0, cells_ - 1.0))];
    b.at += at;
    b.value += value;
    b.n += 1;
  }
  /// The largest value, times sign, of a parabola through the highest mean and those beside it.
  double peak(double sign) const {
    const auto value = [&](std::size_t k) {
      return bins_[k].n > 0 ? sign * bins_[k].value / bins_[k].n : 0.0;
    };
    const auto at = [&](std::size_t k) { return bins_[k].n > 0 ? bins_[k].at / bins_[k].n : 0.0; };
    std::size_t top = 1;
    for (std::size_t k = 1; k + 1 < bins_.size(); ++k)
      if (value(k) > value(top)) top = k;
    const double left = at(top) - at(top - 1), right = at(top + 1) - at(top);
    if (!(left > 0 && right > 0)) return value(top);
    const double rise = (value(top) - value(top - 1)) / left, fall = (value(top + 1) - value(top)) / right;
    const double bend = (fall - rise) / (left + right), slope = (rise * right + fall * left) / (left + right);
    return bend < 0 ? value(top) - slope * slope / (4 * bend) : value(top);
  }

 private:
  struct Bin {
    double at = 0, value = 0, n = 0;
  };
  int cells_;
  double length_;
  std::vector<Bin> bins_;
};

/// De Vahl Davis (1983), Int. J. Numer. Meth. Fluids 3:249: Ra = 1e4, Pr = 0.71; side walls held at 0 and 1.
/// What carries heat is how particles move, and with particle_shifting that is not their velocity: a shift
/// moves them beside it. Shifts are 0.4 of the largest velocity (rms), velocities hold what they undo, and
/// the two do not cancel on average: where velocity has its maximum, particles are 10 % slower than it says.
/// So motion is measured as a particle's displacement over one call of step().
/// Profiles are averaged over time first, since the maximum of a noisy profile is too high; maxima over both
/// directions, since the liquid is lighter on the hot side, where it is faster for the same flow of mass.
void cavity(const Settings& s, Report& report) {
  constexpr int cells = 50;
  const double L = 1, h = L / cells, g = 1, expansion = 0.2, Ra = 1e4, Pr = 0.71;
  const double alpha = std::sqrt(g * expansion * L * L * L / (Ra * Pr)), nu = Pr * alpha;
  WorldDesc d = world_desc(s);
  d.spacing = h;
  d.gravity = {0, -g, 0};
  // What drives, g beta L = 0.2 m^2/s^2, has to be felt against c^2 = 36: hydrostatic compression is 2.8 %,
  // and densities differ by 20 %, which is still nearly Boussinesq's case.
  d.sound_speed = 6;
  d.tension = true;              // the cavity is full
  d.particle_shifting = true;    // liquid at rest would be a lattice that withstands small stresses
  d.artificial_viscosity = 0.0;  // the liquid is viscous enough
  d.domain.bounded = true;
  d.domain.max = {L, L, 8 * h};
  d.domain.faces = {Face::wall, Face::wall, Face::wall, Face::wall, Face::periodic, Face::periodic};
  d.domain.heat[0].temperature = 1;
  d.domain.heat[1].temperature = 0;
  auto world = World::create(d);
  if (!world) return void(report.error = world.error().message);
  MaterialDesc m = substance();
  m.density = 1000;
  m.heat_capacity = 1000;
  m.conductivity = alpha * 1e6;
  m.viscosity = nu * 1000;
  m.density_points = {{0, 1000 * (1 + expansion / 2)}, {1, 1000 * (1 - expansion / 2)}};
  FluidDesc f;
  f.shape = Shape::box(d.domain.min, d.domain.max);
  f.material = *world->add_material(m);
  // 0.3 % more mass than fills it at 0.5: stirred particles read a lower density than a lattice, and the mean
  // pressure has to be about 0. What strained particles resist with goes with pressure, whose level means
  // nothing in a liquid: under pressure they flow as if stickier, under tension as if thinner (see the note).
  f.temperature = 0.483;
  const auto added = world->add_fluid(f);
  if (!added) return void(report.error = added.error().message);
  const double until = 0.3 * L * L / alpha;
  const double dt = 16 * world->resolved().stable_dt;
  // What the library lets through the side walls, by its own formula.
  const auto exchange = meltsim::physics::make_wall_exchange<double>(world->resolved().support_radius, h);
  const auto through = [&](double mass, double distance, double temperature, double wall) {
    if (distance >= exchange.support) return 0.0;
    const double volume = mass / (m.density * (1 + expansion * (0.5 - temperature)));
    return volume * meltsim::physics::wall_area(exchange, distance) * m.conductivity /
           meltsim::physics::wall_depth(exchange, distance) * (wall - temperature);
  };
  double carried = 0, hot = 0, cold = 0, pressure = 0, thinnest = 1;
  LineMeans across(cells, L), upwards(cells, L);
  int samples = 0;
  for (int call = 0; world->time() < until; ++call) {
    const bool sampled = world->time() >= 0.6 * until && call % 6 == 0;
    ParticleData before;
    if (sampled) before = *world->particles();
    const double then = world->time();
    const Status st = world->step(dt);
    if (!st) return void(report.error = st.error().message);
    if (!sampled) continue;
    const auto p = *world->particles();
    const double passed = world->time() - then;
    std::vector<std::size_t> slot_before(p.id.size());
    for (std::size_t i = 0; i < before.id.size(); ++i) slot_before[before.id[i]] = i;
    double sum = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      const std::size_t j = slot_before[p.id[i]];
      const Vec3d &from = before.position[j], &to = p.position[i];
      const double x = 0.5 * (from.x + to.x), y = 0.5 * (from.y + to.y);
      const double u = (to.x - from.x) / passed, v = (to.y - from.y) / passed;
      // No mass crosses a plane on average, so the zero of temperature is free; 0.5 has the least noise.
      sum += u * (0.5 * (before.temperature[j] + p.temperature[i]) - 0.5);
      hot += through(p.mass[i], p.position[i].x, p.temperature[i], 1);
      cold -= through(p.mass[i], L - p.position[i].x, p.temperature[i], 0);
      pressure += p.pressure[i] / static_cast<double>(p.id.size());
      thinnest = std::min(thinnest, p.density[i] / (m.density * (1 + expansion * (0.5 - p.temperature[i]))));
      if (std::fabs(y - L / 2) < h) across.add(x, v);
      if (std::fabs(x - L / 2) < h) upwards.add(y, u);
    }
    // Volume average of u T - alpha dT/dx; the second part is alpha dT/L.
    carried += 1 + sum / static_cast<double>(p.id.size()) * L / alpha;
    ++samples;
  }
  const StepResult r = world->synchronize();
  report.note =
      "tension and particle_shifting on, density +-10 %, sound speed 6, filled to a mean pressure of 0. "
      "At 30 and 40 cells: Nusselt number 2.23 and 2.25, vertical 17.6 and 18.5, horizontal velocity "
      "15.1 and 15.7. The level of pressure acts as viscosity: at 20 cells 15.1 (vertical) under +300 "
      "Pa, 13.1 under +650; at 40 cells and sound speed 10 21.7 under -370 (rho g L is 1000 Pa). Filled "
      "at rest density, 20 and 30 cells tear off in the upper hot corner. Velocities of particles "
      "instead of how they move: 21.5 (vertical), volume average 2.50, 40 cells at -115 Pa, where "
      "motion gives 19.2 and 2.29. A lattice without shifting, at +-2.5 % and sound speed 10, "
      "withstands the driving stress: 1.11 and 3.08.";
  if (r.halted || samples == 0) return void(report.error = r.halted ? r.halt_reason : "no sample was taken");
  const double conducted = m.conductivity * 8 * h;  // W per kelvin through the cavity at rest
  const double unit = alpha / L;
  report.relative("mean Nusselt number, Ra 1e4", carried / samples, 2.243, 5,
                  "volume average over how particles move, 50 cells");
  report.relative("Nusselt number at the walls, Ra 1e4", (hot + cold) / 2 / samples / conducted, 2.243, 5,
                  "what the walls let through");
  report.relative("largest vertical velocity on the middle plane [alpha/L]",
                  (across.peak(1) + across.peak(-1)) / 2 / unit, 19.617, 5,
                  "how particles move, mean of up and down, cells of 1/50");
  report.relative("largest horizontal velocity on the middle plane [alpha/L]",
                  (upwards.peak(1) + upwards.peak(-1)) / 2 / unit, 16.178, 5, "likewise");
  report.absolute("mean pressure [rho g L]", pressure / samples / (m.density * g * L), 0, 0.1, "-",
                  "the set-up: the flow depends on it");
  report.absolute("what the thinnest particle lacks of its rest density", 1 - thinnest, 0, 0.1, "-",
                  "liquid that tears off beneath the lid leaves a void: 0.11 beside it");
}

}  // namespace

std::vector<Case> heat_cases() {
  return {
      {"heat.half_spaces", "two half-spaces at 1 and 0",
       "0.5 erfc(x / (2 sqrt(alpha t))), Carslaw & Jaeger 1959, 2.4", false, half_spaces},
      {"heat.contact", "ice at -10 against water at 40",
       "contact temperature of half-spaces, Carslaw & Jaeger 2.15", false, contact},
      {"heat.slab", "slab of 40 cells, both faces 0", "Fourier series, Carslaw & Jaeger 3.3", false, slab},
      {"heat.cube", "cube, surface 0", "product of three slabs", false, cube},
      {"heat.sphere", "sphere of radius 15 cells, surface 0", "Fourier series, Carslaw & Jaeger 9.3", false,
       sphere},
      {"heat.lumped", "convection cools a small body", "lumped capacitance, Incropera & DeWitt 5.1", false,
       lumped},
      {"heat.biot", "slab cooled by convection, Bi 1", "series with z tan z = Bi, Incropera & DeWitt 5.5",
       false, biot},
      {"heat.flux", "constant flux into a half-space", "Carslaw & Jaeger 2.9", false, flux},
      {"heat.radiation", "radiation cools a small body", "the ordinary differential equation, integrated",
       false, radiation},
      {"heat.source", "heat released in bodies and regions, held regions", "steady and energy balances",
       false, source},
      {"heat.variable", "conductivity and capacity that depend on temperature", "Kirchhoff's transform",
       false, variable},
      {"heat.extremes", "diffusivity 1e6", "conservation", false, extremes},
      {"heat.cavity", "natural convection in a heated cavity", "de Vahl Davis 1983, benchmark", true, cavity},
      {"heat.models", "the paper's and the explicit model", "0.5 erfc; Shao & Yu 2017; Iwasaki et al. 2010",
       false, models},
  };
}

}  // namespace validation
