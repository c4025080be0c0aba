// SPDX-License-Identifier: Apache-2.0
// Phase change: fronts against Neumann's solutions, calorimetry, and what a cycle of melting and freezing
// keeps.
//
// References: Neumann's similarity solutions (Carslaw & Jaeger, Conduction of Heat in Solids, 2nd ed. 1959,
// sec. 11.2): the front stands at s = 2 lambda sqrt(alpha t), with
//   one phase     lambda exp(lambda^2) erf(lambda) = Ste / sqrt(pi), Ste = c dT / L
//   two phases    the same with the flux into the cold solid, or from the warm liquid, k 0.561/2.22, c 4217/2050, L 333.7e3
// the heat balance of an insulated tank, and finite volumes for bodies that have no closed form.
//
// The bars are heat alone: time_scale turns a billionth of a second of motion into a step of conduction, so
// that what has melted stays where it is and the front is that of a substance at rest.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "constants.hpp"
#include "validation.hpp"

namespace validation {
namespace {

using namespace meltsim;

constexpr double dx = 0.01, time_scale = 1e9;
constexpr int side = 8;  ///< sites across a bar: periodic axes span three supports
constexpr double water_c = 4217, ice_c = 2050, water_k = 0.561, ice_k = 2.22, latent = 333.7e3, rho = 1000;

std::string text(const char* format, double a, double b = 0, double c = 0) {
  char out[160];
  std::snprintf(out, sizeof out, format, a, b, c);
  return out;
}

/// A bar along x, closed by a wall of fixed temperature on the left: sites [-wall, 0) hold their temperature,
/// the first site of the bar is 0.
struct Bar {
  World world;
  MaterialId liquid, solid, wall;
  double length = 0;
};

struct Substance {
  double k_solid = ice_k, k_liquid = water_k, c_solid = ice_c, c_liquid = water_c, latent_heat = latent;
};

constexpr int wall_sites = 3;  ///< as deep as the support of 2.5 spacings

template <class R>
bool accept(const R& r, Report& report) {
  if (!r && report.error.empty()) report.error = r.error().message;
  return static_cast<bool>(r);
}

Box sites(double from, double to) { return {{from * dx, 0, 0}, {to * dx, side * dx, side * dx}}; }
Shape slab(double from, double to) {
  const Box b = sites(from, to);
  return Shape::box(b.min, b.max);
}

/// Nothing in it but the materials and the wall.
bool make_bar(const Settings& settings, const Substance& s, int length, double wall_temperature, Bar& bar,
              Report& report, double wall_capacity = 1e15) {
  WorldDesc d = world_desc(settings);
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = 1;
  d.heat.time_scale = time_scale;
  d.domain.bounded = true;
  d.domain.min = {-wall_sites * dx, 0, 0};
  d.domain.max = {length * dx, side * dx, side * dx};
  d.domain.faces = {Face::open, Face::open, Face::periodic, Face::periodic, Face::periodic, Face::periodic};
  auto world = World::create(d);
  if (!accept(world, report)) return false;
  bar.world = std::move(*world);
  bar.length = length;
  MaterialDesc m;
  m.name = "liquid";
  m.density = rho;
  m.conductivity = s.k_liquid;
  m.heat_capacity = s.c_liquid;
  const auto liquid = bar.world.add_material(m);
  m.name = "solid";
  m.conductivity = s.k_solid;
  m.heat_capacity = s.c_solid;
  m.melting_point = 0;
  m.latent_heat = s.latent_heat;
  m.melts_into = *liquid;
  m.freezes = true;
  const auto solid = bar.world.add_material(m);
  // A wall that keeps its temperature, and conducts so well that all resistance lies on the bar's side: the
  // surface is then where wall and bar meet.
  m = MaterialDesc{};
  m.name = "wall";
  m.conductivity = 1e6;
  m.heat_capacity = wall_capacity;
  const auto wall = bar.world.add_material(m);
  if (!accept(solid, report) || !accept(wall, report)) return false;
  bar.liquid = *liquid;
  bar.solid = *solid;
  bar.wall = *wall;
  SolidDesc b;
  b.name = "wall";
  b.shape = slab(-wall_sites, 0);
  b.material = bar.wall;
  b.temperature = wall_temperature;
  b.fixed = true;
  return accept(bar.world.add_solid(b), report);
}

/// Depth of the front in spacings: latent heat taken up (or given off) by the bar, over what one layer holds.
/// `frozen`: counts what is solid.
double front(const ParticleData& p, bool frozen) {
  double layers = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (p.position[i].x > 0) layers += frozen ? 1 - p.liquid_fraction[i] : p.liquid_fraction[i];
  return layers / (side * side);
}

/// Runs until the front has come this deep; fits s^2 = 4 lambda^2 alpha (t - t0) over its second half.
double run_front(Bar& bar, double alpha, double lambda, double depth, double fourier, bool frozen,
                 const char* name, Report& report) {
  const double tau = fourier * dx * dx / alpha, end = std::pow(depth * dx / (2 * lambda), 2) / alpha;
  const int steps = static_cast<int>(std::ceil(end / tau));
  Curve ours{"meltsim", {}, {}, false}, exact{"Neumann", {}, {}, true};
  double n = 0, st = 0, sy = 0, stt = 0, sty = 0;
  for (int k = 1; k <= steps; ++k) {
    if (!accept(bar.world.step(tau / time_scale), report)) return 0;
    if (k % std::max(1, steps / 200) != 0) continue;
    const StepResult r = bar.world.synchronize();
    if (r.halted || r.heat_bound_exceeded) {
      report.error = r.halted ? r.halt_reason : "heat bound exceeded";
      return 0;
    }
    const double t = k * tau, s = front(*bar.world.particles(), frozen) * dx, y = s * s;
    ours.x.push_back(t);
    ours.y.push_back(s / dx);
    exact.x.push_back(t);
    exact.y.push_back(2 * lambda * std::sqrt(alpha * t) / dx);
    if (s < 0.5 * depth * dx) continue;
    n += 1;
    st += t;
    sy += y;
    stt += t * t;
    sty += t * y;
  }
  report.plots.push_back({name, std::string("Front, ") + name, "t [s]", "s [dx]", {ours, exact}});
  const double slope = (n * sty - st * sy) / (n * stt - st * st);
  return std::sqrt(slope / (4 * alpha));
}

constexpr const char* fit_reason =
    "front by latent heat; slope of s^2, so that the half cell of the wall and of the first layer drop out";

/// A layer of solid at the wall, onto which the liquid in the rest of the bar may freeze.
bool add_seeded(Bar& bar, int length, double cold, double warm, Report& report) {
  SolidDesc seed;
  seed.shape = slab(0, 1);
  seed.material = bar.solid;
  seed.temperature = cold;
  seed.fixed = true;
  seed.growth = length;
  FluidDesc rest;
  rest.shape = slab(1, length);
  rest.material = bar.liquid;
  rest.temperature = warm;
  return accept(bar.world.add_solid(seed), report) && accept(bar.world.add_fluid(rest), report);
}

void freezing_one_phase(const Settings& settings, double ste, double lambda, Report& report) {
  const double alpha = ice_k / (rho * ice_c);
  Substance s;
  s.k_liquid = ice_k;  // the liquid is at the melting point: what it conducts does not matter, its mush does
  s.latent_heat = 20 * ice_c / ste;
  Bar bar{*World::create(world_desc(settings)), {}, {}, {}};
  const int depth = settings.long_cases ? 32 : 16, length = depth + 4;
  if (!make_bar(settings, s, length, -20, bar, report)) return;
  if (!add_seeded(bar, length, -20, 0, report)) return;
  const std::string name = text("freezing_ste_%.1f", ste);
  const double value = run_front(bar, alpha, lambda, depth, 2, true, name.c_str(), report);
  if (!report.error.empty()) return;
  report.relative(text("lambda of the freezing front, Ste %.1f", ste), value, lambda, 2, fit_reason);
  const double grown = double(bar.world.synchronize().solid) / (side * side) - wall_sites;
  report.absolute(
      text("layers that are solid by tag, Ste %.1f", ste), grown, front(*bar.world.particles(), true), 2,
      "dx", "a layer turns solid when its last latent heat is gone, while the next ones have lost some");
}

void freezing(const Settings& settings, Report& report) {
  freezing_one_phase(settings, 0.1, 0.220016, report);
  freezing_one_phase(settings, 0.5, 0.464786, report);
}

void melting_one_phase(const Settings& settings, double ste, double lambda, Report& report) {
  const double alpha = water_k / (rho * water_c);
  Substance s;
  s.k_solid = water_k;
  s.latent_heat = 20 * water_c / ste;
  Bar bar{*World::create(world_desc(settings)), {}, {}, {}};
  const int depth = settings.long_cases ? 32 : 16, length = depth + 4;
  if (!make_bar(settings, s, length, 20, bar, report)) return;
  SolidDesc ice;
  ice.shape = slab(0, length);
  ice.material = bar.solid;
  ice.temperature = 0;
  ice.fixed = true;
  if (!accept(bar.world.add_solid(ice), report)) return;
  const double value =
      run_front(bar, alpha, lambda, depth, 2, false, text("melting_ste_%.1f", ste).c_str(), report);
  if (report.error.empty())
    report.relative(text("lambda of the melting front, Ste %.1f", ste), value, lambda, 1, fit_reason);
}

void melting(const Settings& settings, Report& report) {
  melting_one_phase(settings, 0.1, 0.220016, report);
  melting_one_phase(settings, 0.5, 0.464786, report);
}

void melting_two_phases(const Settings& settings, Report& report) {
  const double alpha = water_k / (rho * water_c), lambda = 0.419387, alpha_ice = ice_k / (rho * ice_c);
  Bar bar{*World::create(world_desc(settings)), {}, {}, {}};
  const int depth = settings.long_cases ? 24 : 14;
  // The ice reaches 3.5 diffusion lengths further: at its end erfc(1.75) of 10 degrees are missing, 0.13.
  const double far = 3.5 * std::sqrt(alpha_ice / alpha) * depth / (2 * lambda);
  const int length = depth + static_cast<int>(far);
  if (!make_bar(settings, {}, length, 40, bar, report)) return;
  SolidDesc ice;
  ice.shape = slab(0, length);
  ice.material = bar.solid;
  ice.temperature = -10;
  ice.fixed = true;
  if (!accept(bar.world.add_solid(ice), report)) return;
  const double value = run_front(bar, alpha, lambda, depth, 2, false, "melting_two_phases", report);
  if (report.error.empty())
    report.relative("lambda of the melting front, water 40 C, ice -10 C", value, lambda, 0.5,
                    "as above; a particle between the phases that conducts as their mixture makes 1.5 %");
}

void freezing_two_phases(const Settings& settings, Report& report) {
  const double alpha = ice_k / (rho * ice_c), lambda = 0.147824, alpha_water = water_k / (rho * water_c);
  Bar bar{*World::create(world_desc(settings)), {}, {}, {}};
  const int depth = settings.long_cases ? 32 : 16;
  // The water reaches 3.5 diffusion lengths further, as the ice does where it melts.
  const int length = depth + static_cast<int>(3.5 * std::sqrt(alpha_water / alpha) * depth / (2 * lambda));
  if (!make_bar(settings, {}, length, -10, bar, report)) return;
  if (!add_seeded(bar, length, -10, 15, report)) return;
  const double value = run_front(bar, alpha, lambda, depth, 2, true, "freezing_two_phases", report);
  if (!report.error.empty()) return;
  report.relative("lambda of the freezing front, wall -10 C, water 15 C", value, lambda, 2, fit_reason);
  const double end = bar.world.time() * time_scale;
  report.absolute("its depth at the end", front(*bar.world.particles(), true),
                  2 * lambda * std::sqrt(alpha * end) / dx, 0.5, "dx",
                  "half a cell: the seed's, and that in which the front is");
}

/// A closed tank of 10^3 sites, ice in its lowest layers. Heat alone, as in the bars.
struct Tank {
  int layers = 1;  ///< of ten that are ice
  double ice_temperature = 0, water_temperature = 0, fourier = 4;
  int half_width = 2;
};

bool mix(const Settings& settings, const Tank& tank, World& world, Report& report) {
  constexpr int n = 10;
  WorldDesc d = world_desc(settings);
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = 1;
  d.heat.time_scale = time_scale;
  d.domain.bounded = true;
  d.domain.max = {n * dx, n * dx, n * dx};
  auto made = World::create(d);
  if (!accept(made, report)) return false;
  world = std::move(*made);
  MaterialDesc m;
  m.density = rho;
  m.conductivity = water_k;
  m.heat_capacity = water_c;
  const auto water = world.add_material(m);
  m.name = "ice";
  m.conductivity = ice_k;
  m.heat_capacity = ice_c;
  m.melting_point = 0;
  m.latent_heat = latent;
  m.melts_into = *water;
  m.freezes = true;
  m.region_half_width = tank.half_width;
  const auto ice = world.add_material(m);
  if (!accept(ice, report)) return false;
  const double level = tank.layers * dx;
  SolidDesc b;
  b.shape = Shape::box({0, 0, 0}, {n * dx, level, n * dx});
  b.material = *ice;
  b.temperature = tank.ice_temperature;
  b.growth = n;
  FluidDesc f;
  f.shape = Shape::box({0, level, 0}, {n * dx, n * dx, n * dx});
  f.material = *water;
  f.temperature = tank.water_temperature;
  if (!accept(world.add_solid(b), report) || !accept(world.add_fluid(f), report)) return false;
  // Differences decay with exp(-pi^2 alpha t / L^2), so that 300 cells squared are plenty once all that melts
  // has melted; until a ten-thousandth of a degree is left, looked at every 16 cells squared.
  const double tau = tank.fourier * dx * dx * rho * water_c / water_k;
  const int look = std::max(1, static_cast<int>(16 / tank.fourier));
  for (int k = 0; k < static_cast<int>(900 / tank.fourier); ++k) {
    if (!accept(world.step(tau / time_scale), report)) return false;
    const StepResult r = world.synchronize();
    if (r.halted) report.error = r.halt_reason;
    if (r.halted) return false;
    if ((k + 1) % look != 0) continue;
    const Totals t = *world.totals();
    if (t.temperature_max - t.temperature_min < 1e-4) break;
  }
  return true;
}

void calorimetry(const Settings& settings, Report& report) {
  struct Entry {
    double ice, water;
    int layers;
    double end;
  };
  const Entry table[] = {{-10, 40, 1, 27.601},  {-10, 40, 2, 15.201}, {-10, 40, 3, 2.802},
                         {-20, 80, 1, 63.115},  {-20, 80, 2, 46.229}, {-20, 80, 3, 29.344},
                         {-10, 100, 1, 81.601}, {-10, 100, 5, 8.003}};
  const char* reason = "an insulated tank: exact but for what has not levelled out";
  for (const Entry& e : table) {
    World world = *World::create(world_desc(settings));
    if (!mix(settings, {e.layers, e.ice, e.water, 4, 2}, world, report)) return;
    const Totals t = *world.totals();
    report.absolute(text("ice %.0f C, water %.0f C, share of ice %.1f", e.ice, e.water, e.layers / 10.0),
                    t.temperature_mean, e.end, 0.01, "C", reason);
    if (t.solid != 0)
      report.note +=
          text("share of ice %.1f: %.0f particles still solid. ", e.layers / 10.0, double(t.solid));
  }
  // Any step, any w.
  for (const double fourier : {1.0, 16.0})
    for (const int w : {1, 4}) {
      World world = *World::create(world_desc(settings));
      if (!mix(settings, {1, -10, 40, fourier, w}, world, report)) return;
      report.absolute(text("the same for 0.1, step of Fo %.0f, w %.0f", fourier, w),
                      world.totals()->temperature_mean, 27.601, 0.01, "C", reason);
    }
  // Half ice: it ends at 0 degrees with part of the ice left.
  World world = *World::create(world_desc(settings));
  if (!mix(settings, {5, -10, 40, 4, 2}, world, report)) return;
  const auto p = *world.particles();
  double taken = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) taken += p.liquid_fraction[i];
  const Totals t = *world.totals();
  report.absolute("ice -10 C, water 40 C, share of ice 0.5: warmest", t.temperature_max, 0, 0.01, "C",
                  reason);
  report.absolute("... coldest", t.temperature_min, 0, 0.01, "C", reason);
  // 500 particles were ice, the others liquid from the start.
  report.absolute("... share of the ice melted, by latent heat", (taken - 500) / 5, 44.41, 0.01, "%", reason);
}

/// A block of another density in warm liquid, in free space: what is lost until nothing solid is left.
void ledger(const Settings& settings, Report& report) {
  for (const double density : {400.0, 917.0, 2500.0}) {
    WorldDesc d = world_desc(settings);
    d.spacing = 0.1;
    d.gravity = {0, 0, 0};
    d.sound_speed = 20;
    d.heat.time_scale = 5e5;
    auto made = World::create(d);
    if (!accept(made, report)) return;
    World world = std::move(*made);
    const auto water = world.add_material({});
    MaterialDesc m;
    m.name = "solid";
    m.density = density;
    m.conductivity = ice_k;
    m.heat_capacity = ice_c;
    m.melting_point = 0;
    m.latent_heat = 5e4;
    m.melts_into = *water;
    const auto solid = world.add_material(m);
    if (!accept(solid, report)) return;
    SolidDesc b;
    b.shape = Shape::box({0.4, 0.4, 0.4}, {0.8, 0.8, 0.8});
    b.material = *solid;
    b.temperature = -5;
    b.velocity = {0.2, -0.1, 0};
    FluidDesc f;
    f.shape = Shape::box({0, 0, 0}, {1.2, 1.2, 1.2});
    f.material = *water;
    f.temperature = 60;
    f.velocity = {-0.1, 0.1, 0.2};
    if (!accept(world.add_fluid(f), report) || !accept(world.add_solid(b), report)) return;
    const Totals before = *world.totals();
    const auto masses = world.particles()->mass;
    double scale = 0;
    const auto p = *world.particles();
    for (std::size_t i = 0; i < p.id.size(); ++i) scale += p.mass[i] * length(p.velocity[i]);
    for (int k = 0; k < 1500; ++k) {
      if (!accept(world.step(0.002), report)) return;
      if (k % 20 != 0) continue;
      const StepResult r = world.synchronize();
      if (r.halted) report.error = r.halt_reason;
      if (r.halted) return;
      if (r.solid == 0) break;
    }
    const Totals after = *world.totals();
    const bool twice = settings.precision == Precision::double_precision;
    const std::string of = text(", solid of %.0f kg/m^3", density);
    report.absolute("solid particles left" + of, double(after.solid), 0, 0, "-", "all of it melts");
    report.absolute("masses that changed" + of, world.particles()->mass == masses ? 0 : 1, 0, 0, "-",
                    "to the last bit");
    report.absolute("heat" + of, after.thermal / before.thermal, 1, twice ? 1e-12 : 1e-6, "-",
                    "fluxes are exact negatives of each other");
    report.absolute("momentum, of the sum of |m v|" + of, length(after.momentum - before.momentum) / scale, 0,
                    twice ? 1e-12 : 1e-5, "-", "forces are; the rounding of the velocities' sums remains");
  }
}

/// Wall | warm liquid | solid: the liquid melts some of the solid before the cold of the wall has come
/// through it and freezes everything.
void cycle(const Settings& settings, Report& report) {
  const int length = 16;
  Bar bar{*World::create(world_desc(settings)), {}, {}, {}};
  if (!make_bar(settings, {}, length, -40, bar, report, 2e7)) return;
  SolidDesc ice;
  ice.shape = slab(10, length);
  ice.material = bar.solid;
  ice.temperature = -1;
  ice.fixed = true;
  ice.growth = length;
  FluidDesc water;
  water.shape = slab(0, 10);
  water.material = bar.liquid;
  water.temperature = 60;
  if (!accept(bar.world.add_solid(ice), report) || !accept(bar.world.add_fluid(water), report)) return;
  const double tau = 4 * dx * dx * rho * water_c / water_k;
  const auto before = *bar.world.particles();
  const double heat = bar.world.totals()->thermal;
  Curve solid{"solid layers", {}, {}, false};
  StepResult r;
  double molten = 0;
  for (int k = 0; k < 2500; ++k) {
    if (!accept(bar.world.step(tau / time_scale), report)) return;
    r = bar.world.synchronize();
    if (r.halted) report.error = r.halt_reason;
    if (r.halted) return;
    const double layers = double(r.solid) / (side * side) - wall_sites;
    solid.x.push_back((k + 1) * tau);
    solid.y.push_back(layers);
    molten = std::max(molten, 6 - layers);
    if (layers >= length) break;
  }
  const auto after = *bar.world.particles();
  report.plots.push_back({"melt_freeze_cycle", "Melting, then freezing", "t [s]", "solid layers", {solid}});
  report.absolute("layers melted before they froze again", molten, 2, 1.5, "dx", "there and back");
  report.absolute("solid layers at the end", solid.y.back(), length, 0, "dx", "everything freezes");
  report.absolute("masses that changed", before.mass == after.mass ? 0 : 1, 0, 0, "-", "to the last bit");
  report.absolute("count of melted and frozen", double(r.frozen) - double(r.melted), 10 * side * side, 0, "-",
                  "what melted froze, and the liquid with it");
  const bool twice = settings.precision == Precision::double_precision;
  report.absolute("heat of wall and bar", bar.world.totals()->thermal / heat, 1, twice ? 1e-12 : 1e-6, "-",
                  "fluxes are exact negatives of each other");
}

/// A ball, rod, layer or block (cube) of ice at 0 degrees in a shell of warm water of the same shape, insulated outside;
/// lengths in radii (half the thickness of a layer or a block) of the ice, times in radius^2 / alpha of the water.
struct Bath {
  int dimensions = 3;  ///< 1 layer, 2 rod, 3 ball or block
  double outer = 2;    ///< radius of the water
  double warm = 60;    ///< of the water at first [C]
  const char* name = "";
  bool block = false;
};

/// Times at which these shares of a total have been reached, from one step to the next.
struct Passing {
  const std::vector<double>& shares;
  std::vector<double> times;
  double last = 0;
  void at(double before, double now, double share) {
    while (times.size() < shares.size() && share >= shares[times.size()])
      times.push_back(before + (now - before) * (shares[times.size()] - last) / (share - last));
    last = share;
  }
  bool done() const { return times.size() == shares.size(); }
};

/// k [W/(m K)] of a cell of so much heat [J/m^3] toward another: of the phase that lies between.
double cell_conductivity(double heat, double temperature, double other) {
  return heat >= rho * latent || (heat > 0 && other > temperature) ? water_k : ice_k;
}
double cell_temperature(double heat) {
  const double above = heat - rho * latent;
  return heat < 0 ? heat / (rho * ice_c) : above > 0 ? above / (rho * water_c) : 0;
}
double cells_exchange(double heat_i, double t_i, double heat_j, double t_j) {
  return 2 / (1 / cell_conductivity(heat_i, t_i, t_j) + 1 / cell_conductivity(heat_j, t_j, t_i)) *
         (t_j - t_i);
}

/// Times at which these shares of the latent heat have been taken up: finite volumes, 80 along the radius of the
/// ice, explicit. Three times as many change the times by 0.5 % at most.
std::vector<double> bath_times(const Bath& b, const std::vector<double>& shares) {
  constexpr int ice = 80;
  // Stable up to 0.31: ice at its melting point changes no temperature, and water beside it conducts 1.6 times as well.
  constexpr double dr = 1.0 / ice, dt = 0.2 * dr * dr * rho * water_c / water_k;
  const int n = static_cast<int>(std::lround(b.outer * ice));
  const auto inside = [&](double r) { return std::pow(r, b.dimensions) / b.dimensions; };
  std::vector<double> heat(n), temperature(n), volume(n), area(n + 1, 0.0);
  for (int i = 0; i < n; ++i) {
    volume[i] = inside((i + 1) * dr) - inside(i * dr);
    area[i] = std::pow(i * dr, b.dimensions - 1);
    heat[i] = i < ice ? 0 : rho * (latent + water_c * b.warm);
  }
  area[0] = 0;
  Passing passing{shares, {}};
  for (double t = 0; !passing.done(); t += dt) {
    double molten = 0, before = 0;
    for (int i = 0; i < n; ++i) {
      temperature[i] = cell_temperature(heat[i]);
      if (i < ice) molten += volume[i] / inside(1) * std::clamp(heat[i] / (rho * latent), 0.0, 1.0);
    }
    passing.at((t - dt) * water_k / (rho * water_c), t * water_k / (rho * water_c), molten);
    for (int i = 0; i < n; ++i) {
      const double flow =
          i + 1 == n
              ? 0
              : area[i + 1] / dr * cells_exchange(heat[i], temperature[i], heat[i + 1], temperature[i + 1]);
      heat[i] += dt * (flow - before) / volume[i];
      before = flow;
    }
  }
  return passing.times;
}

/// The same for a block: an eighth of it, 20 cells along half its edge. 32 cells change the times by 0.5 % at most.
std::vector<double> block_times(const Bath& b, const std::vector<double>& shares, int ice = 20) {
  const double dr = 1.0 / ice, dt = 0.065 * dr * dr * rho * water_c / water_k;
  const int n = static_cast<int>(std::lround(b.outer * ice)), rows[] = {1, n, n * n}, all = n * n * n;
  std::vector<double> heat(all), temperature(all), flow(all);
  const auto is_ice = [&](int x, int y, int z) { return x < ice && y < ice && z < ice; };
  const auto each = [&](const auto& what) {
    for (int z = 0, c = 0; z < n; ++z)
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x, ++c) what(x, y, z, c);
  };
  each(
      [&](int x, int y, int z, int c) { heat[c] = is_ice(x, y, z) ? 0 : rho * (latent + water_c * b.warm); });
  Passing passing{shares, {}};
  for (double t = 0; !passing.done(); t += dt) {
    double molten = 0;
    each([&](int x, int y, int z, int c) {
      temperature[c] = cell_temperature(heat[c]);
      flow[c] = 0;
      if (is_ice(x, y, z)) molten += std::clamp(heat[c] / (rho * latent), 0.0, 1.0);
    });
    passing.at((t - dt) * water_k / (rho * water_c), t * water_k / (rho * water_c),
               molten / (ice * ice * ice));
    each([&](int x, int y, int z, int c) {
      const int at[] = {x, y, z};
      for (int axis = 0; axis < 3; ++axis) {
        const int o = c + rows[axis];
        if (at[axis] + 1 == n || temperature[o] == temperature[c]) continue;
        const double q = cells_exchange(heat[c], temperature[c], heat[o], temperature[o]);
        flow[c] += q;
        flow[o] -= q;
      }
    });
    for (int c = 0; c < all; ++c) heat[c] += dt / (dr * dr) * flow[c];
  }
  return passing.times;
}

/// Melts a body of a radius of `cells` spacings; returns times in the unit of bath_times and the ice's and the
/// water's radius in spacings, of what the lattice holds.
bool melt_in_bath(const Settings& settings, const Bath& b, double cells, const std::vector<double>& shares,
                  std::vector<double>& times, double& radius, double& outer, Report& report) {
  WorldDesc d = world_desc(settings);
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = 1;
  d.heat.time_scale = time_scale;
  const double R = cells * dx, half = side / 2 * dx, far = std::ceil(b.outer * cells + 3) * dx;
  d.domain.bounded = true;
  d.domain.min = {-far, b.dimensions > 1 ? -far : -half, b.dimensions > 2 ? -far : -half};
  d.domain.max = -d.domain.min;
  d.domain.faces.fill(Face::open);
  for (int axis = b.dimensions; axis < 3; ++axis)
    d.domain.faces[2 * axis] = d.domain.faces[2 * axis + 1] = Face::periodic;
  auto made = World::create(d);
  if (!accept(made, report)) return false;
  World world = std::move(*made);
  MaterialDesc m;
  m.density = rho;
  m.conductivity = water_k;
  m.heat_capacity = water_c;
  const auto water = world.add_material(m);
  m.name = "ice";
  m.conductivity = ice_k;
  m.heat_capacity = ice_c;
  m.melting_point = 0;
  m.latent_heat = latent;
  m.melts_into = *water;
  const auto ice = world.add_material(m);
  if (!accept(ice, report)) return false;
  const auto shape = [&](double r) {
    if (b.block) return Shape::box({-r, -r, -r}, {r, r, r});
    if (b.dimensions == 3) return Shape::sphere({0, 0, 0}, r);
    if (b.dimensions == 2) return Shape::cylinder({0, 0, -half}, {0, 0, half}, r);
    return Shape::box({-r, -half, -half}, {r, half, half});
  };
  SolidDesc body;
  body.shape = shape(R);
  body.material = *ice;
  body.temperature = 0;
  body.fixed = true;
  FluidDesc f;
  f.shape = shape(b.outer * R);
  f.material = *water;
  f.temperature = b.warm;
  if (!accept(world.add_solid(body), report) || !accept(world.add_fluid(f), report)) return false;
  const auto start = *world.particles();
  std::vector<char> was_ice(start.id.size(), 0);
  double count = 0;
  for (std::size_t i = 0; i < start.id.size(); ++i) {
    was_ice[start.id[i]] = start.liquid_fraction[i] < 0.5 ? 1 : 0;
    count += was_ice[start.id[i]];
  }
  const double measure[] = {2.0 * side * side, pi * side, b.block ? 8.0 : 4 * pi / 3};
  const auto radius_of = [&](double n) {
    return std::pow(n / measure[b.dimensions - 1], 1.0 / b.dimensions);
  };
  radius = radius_of(count);
  outer = radius_of(double(start.id.size()));
  // A quarter of the time in which warmth crosses a cell of water: a layer melts in some eight steps.
  const double tau = 0.25 * dx * dx * rho * water_c / water_k,
               unit = rho * water_c / water_k * std::pow(radius * dx, 2);
  Passing passing{shares, {}};
  for (double t = 0; !passing.done() && t < 4 * unit; t += tau) {
    if (!accept(world.step(tau / time_scale), report)) return false;
    const StepResult r = world.synchronize();
    if (r.halted || r.heat_bound_exceeded) {
      report.error = r.halted ? r.halt_reason : "heat bound exceeded";
      return false;
    }
    const auto p = *world.particles();
    double molten = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (was_ice[p.id[i]] != 0) molten += p.liquid_fraction[i] / count;
    passing.at(t / unit, (t + tau) / unit, molten);
  }
  times = passing.times;
  if (!passing.done()) report.error = "ice is left";
  return passing.done();
}

void bodies(const Settings& settings, Report& report) {
  const std::vector<double> shares{0.25, 0.5, 0.99};
  const Bath baths[] = {
      {3, 2, 60, "ball"}, {2, 2, 60, "rod"}, {1, 3, 60, "layer"}, {3, 2, 60, "block", true}};
  std::vector<int> sizes{4, 6, 8};
  if (settings.long_cases) sizes.push_back(12);
  for (const Bath& b : baths) {
    std::vector<Curve> curves;
    for (const double share : shares) curves.push_back({text("%.0f %% molten", 100 * share), {}, {}, false});
    std::vector<double> exact;
    Bath held = b;
    for (const int cells : sizes) {
      std::vector<double> times;
      double radius = 0, outer = 0;
      if (!melt_in_bath(settings, b, cells, shares, times, radius, outer, report)) return;
      if (exact.empty() || held.outer != outer / radius) {
        held.outer = outer / radius;
        exact = b.block ? block_times(held, shares) : bath_times(held, shares);
      }
      // Order 1.5 from 5 % at six spacings.
      const double target = 5 * std::pow(6.0 / cells, 1.5);
      for (std::size_t k = 0; k < shares.size(); ++k) {
        if (k != 0)
          report.relative(text("radius of %.0f dx, %.0f %% molten: ", cells, 100 * shares[k]) + b.name,
                          times[k], exact[k], target,
                          "5 % at 6 dx, order 1.5; radii are those of as many cells");
        curves[k].x.push_back(cells);
        curves[k].y.push_back(100 * (times[k] / exact[k] - 1));
      }
    }
    report.note += text("error of the first quarter at 4, 6, 8 dx: %+.0f, %+.0f, %+.0f %%, ", curves[0].y[0],
                        curves[0].y[1], curves[0].y[2]) +
                   b.name + ". ";
    report.plots.push_back({std::string("melting_") + b.name, std::string("Time to melt a ") + b.name,
                            "radius [dx]", "error [%]", curves});
  }
}

}  // namespace

std::vector<Case> phase_cases() {
  return {
      {"phase.freezing", "Freezing front into liquid at its melting point", "Neumann, one phase", false,
       freezing},
      {"phase.melting", "Melting front into solid at its melting point", "Neumann, one phase", false,
       melting},
      {"phase.melting_two_phases", "Melting front into cold ice", "Neumann, two phases", false,
       melting_two_phases},
      {"phase.freezing_two_phases", "Freezing front into warm water", "Neumann, two phases", false,
       freezing_two_phases},
      {"phase.calorimetry", "End temperature of ice and water in an insulated tank", "heat balance", false,
       calorimetry},
      {"phase.bodies", "Melting of a ball, a rod, a layer and a block in a warm bath", "finite volumes",
       false, bodies},
      {"phase.ledger", "Mass, heat and momentum through complete melting", "conservation", false, ledger},
      {"phase.cycle", "Melting, then freezing of all there is", "conservation", false, cycle},
  };
}

}  // namespace validation
