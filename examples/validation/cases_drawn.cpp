// SPDX-License-Identifier: Apache-2.0
// Cases drawn at random: shapes, sizes, materials, places and directions that nobody chose, each with an exact answer.
// A target is what the order of the method says at the coarsest draw; a row names the draw that is worst, which
// --seed and --draws make again.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "drawn.hpp"

namespace validation {
namespace {

using namespace meltsim;

/// Density, capacity and conductivity of a substance drawn between a foam and a metal.
MaterialDesc substance(Dice& dice, const char* name) {
  MaterialDesc m;
  m.name = name;
  m.density = dice.log(100, 10000);
  m.heat_capacity = dice.log(300, 5000);
  m.conductivity = dice.log(0.05, 200);
  return m;
}

// ---- heat ------------------------------------------------------------------------------------------------------------------

/// Mean of a slab of half thickness L at the Fourier number alpha t / L^2, cooled by convection on both faces: from 1 to 0.
double slab_mean(double biot, double fourier) {
  double sum = 0;
  for (int n = 0; n < 60; ++n) {
    double low = n * pi + 1e-12, high = n * pi + pi / 2 - 1e-12;
    for (int k = 0; k < 100; ++k) {
      const double z = 0.5 * (low + high);
      (z * std::tan(z) < biot ? low : high) = z;
    }
    const double z = low;
    sum += 4 * std::sin(z) / (2 * z + std::sin(2 * z)) * std::exp(-z * z * fourier) * std::sin(z) / z;
  }
  return sum;
}

/// A block of any sides anywhere on the lattice, cooled by convection over its whole surface: the product of three slabs.
Outcome cooled_block(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.1);
  const int n[3] = {dice.whole(8, 20), dice.whole(8, 20), dice.whole(8, 20)};
  const MaterialDesc m = substance(dice, "stone");
  const double biot = dice.log(0.05, 5), fourier = dice.log(0.1, 2), hot = dice.uniform(-100, 1000),
               ambient = dice.uniform(-100, 1000);
  const double half = 0.5 * *std::min_element(n, n + 3) * dx,
               alpha = m.conductivity / (m.density * m.heat_capacity), t = fourier * half * half / alpha,
               h = biot * m.conductivity / half;
  Outcome o{0, text("%.0f x %.0f x %.0f sites, Bi %.3g, Fo %.3g, k %.3g", n[0], n[1], n[2], biot, fourier,
                    m.conductivity)};
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = {};
  d.sound_speed = 1;
  d.heat.time_scale = t / (60 * dx);
  auto world = World::create(d);
  if (!world) return report.error = world.error().message, o;
  SolidDesc b;
  const Vec3d corner{dice.uniform(-5, 5) * dx, dice.uniform(-5, 5) * dx, dice.uniform(-5, 5) * dx};
  b.shape = Shape::box(corner, corner + Vec3d{n[0] * dx, n[1] * dx, n[2] * dx});
  b.material = *world->add_material(m);
  b.temperature = hot;
  b.fixed = true;
  b.surface.convection = h;
  b.surface.ambient = ambient;
  if (auto added = world->add_solid(b); !added) return report.error = added.error().message, o;
  for (int k = 0; k < 60; ++k)
    if (Status step = world->step(dx); !step) return report.error = step.error().message, o;
  if (const StepResult r = world->synchronize(); r.halted) return report.error = r.halt_reason, o;
  double exact = 1;
  for (const int sites : n) {
    const double L = 0.5 * sites * dx;
    exact *= slab_mean(h * L / m.conductivity, alpha * t / (L * L));
  }
  const double ours = (world->totals()->temperature_mean - ambient) / (hot - ambient);
  o.error = 100 * std::fabs(ours - exact);
  o.what += text(", mean %.4f instead of %.4f", ours, exact);
  return o;
}

/// Mean of a ball of radius R at alpha t / R^2, cooled by convection: sum over z cot z = 1 - Bi (Carslaw & Jaeger 9.4).
double ball_mean(double biot, double fourier) {
  double sum = 0;
  for (int n = 0; n < 60; ++n) {
    double low = n * pi + 1e-12, high = (n + 1) * pi - 1e-12;
    for (int k = 0; k < 100; ++k) {
      const double z = 0.5 * (low + high);
      (z / std::tan(z) > 1 - biot ? low : high) = z;
    }
    const double z = low, a = std::sin(z) - z * std::cos(z);
    sum += 12 * a * a / (z * z * z * (2 * z - std::sin(2 * z))) * std::exp(-z * z * fourier);
  }
  return sum;
}

/// A ball whose centre is anywhere between sites.
Outcome cooled_ball(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.1), R = dice.uniform(5, 12) * dx;
  const MaterialDesc m = substance(dice, "stone");
  const double biot = dice.log(0.05, 5), fourier = dice.log(0.05, 0.5) * (1 + 1 / biot),
               hot = dice.uniform(-100, 1000), ambient = dice.uniform(-100, 1000);
  const double alpha = m.conductivity / (m.density * m.heat_capacity), t = fourier * R * R / alpha;
  Outcome o{0, text("radius %.2f dx, Bi %.3g, Fo %.3g, k %.3g", R / dx, biot, fourier, m.conductivity)};
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = {};
  d.sound_speed = 1;
  d.heat.time_scale = t / (60 * dx);
  auto world = World::create(d);
  if (!world) return report.error = world.error().message, o;
  SolidDesc b;
  b.shape = Shape::sphere({dice.uniform(-5, 5) * dx, dice.uniform(-5, 5) * dx, dice.uniform(-5, 5) * dx}, R);
  b.material = *world->add_material(m);
  b.temperature = hot;
  b.fixed = true;
  b.surface.convection = biot * m.conductivity / R;
  b.surface.ambient = ambient;
  if (auto added = world->add_solid(b); !added) return report.error = added.error().message, o;
  for (int k = 0; k < 60; ++k)
    if (Status step = world->step(dx); !step) return report.error = step.error().message, o;
  if (const StepResult r = world->synchronize(); r.halted) return report.error = r.halt_reason, o;
  const double exact = ball_mean(biot, fourier),
               ours = (world->totals()->temperature_mean - ambient) / (hot - ambient);
  o.error = 100 * std::fabs(ours - exact);
  o.what += text(", mean %.4f instead of %.4f", ours, exact);
  return o;
}

void cooling(const Settings& s, Report& r) {
  spread(s, r, "mean temperature of a cooled block", 1, "% of the range",
         "second order in an eighth of a side: some 1/64 of the part that conduction decides", cooled_block);
  spread(s, r, "mean temperature of a cooled ball", 3, "% of the range",
         "a lattice has the area and the volume of a ball of 5 spacings within 3 %", cooled_ball);
}

/// Ice and water of drawn properties in an insulated tank: where they end follows from the heat balance alone.
Outcome mixed(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.1);
  const int n[3] = {dice.whole(6, 10), dice.whole(6, 12), dice.whole(6, 10)},
            layers = dice.whole(1, n[1] - 1);
  MaterialDesc water = substance(dice, "water"), ice = water;
  ice.name = "ice";
  ice.density = water.density * dice.uniform(0.8, 1.25);
  ice.heat_capacity = water.heat_capacity * dice.log(0.4, 2.5);
  ice.conductivity = water.conductivity * dice.log(0.25, 4);
  ice.melting_point = dice.uniform(-50, 500);
  ice.latent_heat = water.heat_capacity * dice.log(5, 200);
  ice.freezes = true;
  const double cold = ice.melting_point - dice.log(1, 100), hot = ice.melting_point + dice.log(1, 300);
  const double mi = ice.density * layers, mw = water.density * (n[1] - layers);
  Outcome o{0, text("%.0f of %.0f layers of ice, %.3g K below, water %.3g K above, latent heat %.3g K",
                    layers, n[1], ice.melting_point - cold, hot - ice.melting_point,
                    ice.latent_heat / water.heat_capacity)};
  // Heat above ice at its melting point decides: all solid, a mixture, or all liquid.
  const double Tm = ice.melting_point, warm = mw * (water.heat_capacity * (hot - Tm) + ice.latent_heat),
               deficit = mi * ice.heat_capacity * (Tm - cold), heat = warm - deficit,
               all = (mi + mw) * ice.latent_heat;
  // What was water keeps the capacity of the solid that it froze into, and the other way round.
  const double end = heat < 0     ? Tm + heat / ((mi + mw) * ice.heat_capacity)
                     : heat < all ? Tm
                                  : Tm + (heat - all) / ((mi + mw) * water.heat_capacity);
  WorldDesc d = box(s, dx, {n[0], n[1], n[2]}, Face::wall, Face::wall, Face::wall);
  d.gravity = {};
  d.sound_speed = 1;
  const double slow = std::min(ice.conductivity, water.conductivity), length = n[1] * dx,
               alpha = slow / (std::max(ice.density, water.density) *
                               std::max(ice.heat_capacity, water.heat_capacity));
  const double dt = 1e-3 * dx, tau = 0.5 * dx * dx / alpha;
  d.heat.time_scale = tau / dt;
  auto world = World::create(d);
  if (!world) return report.error = world.error().message, o;
  const MaterialId w = *world->add_material(water);
  ice.melts_into = w;
  const auto i = world->add_material(ice);
  if (!i) return report.error = i.error().message, o;
  SolidDesc b;
  b.shape = Shape::box({0, 0, 0}, {n[0] * dx, layers * dx, n[2] * dx});
  b.material = *i;
  b.temperature = cold;
  b.growth = n[1];
  b.fixed = true;
  FluidDesc f;
  f.shape = Shape::box({0, layers * dx, 0}, {n[0] * dx, length, n[2] * dx});
  f.material = w;
  f.temperature = hot;
  if (auto a = world->add_solid(b); !a) return report.error = a.error().message, o;
  if (auto a = world->add_fluid(f); !a) return report.error = a.error().message, o;
  // Latent heat makes the slowest mode slower by Ste; forty times the time of pure conduction is ample or the spread says so.
  const double ste = 1 + ice.latent_heat / water.heat_capacity / std::max(1.0, hot - cold);
  const int steps = static_cast<int>(std::ceil(4 * ste * n[1] * n[1] / 0.5));
  Totals t;
  for (int k = 0; k < steps; ++k) {
    if (Status step = world->step(dt); !step) return report.error = step.error().message, o;
    if (k % 64 != 63 && k + 1 != steps) continue;
    if (const StepResult r = world->synchronize(); r.halted) return report.error = r.halt_reason, o;
    t = *world->totals();
    if (t.temperature_max - t.temperature_min < 1e-6 * (hot - cold)) break;
  }
  o.error = 100 * std::fabs(t.temperature_mean - end) / (hot - cold);
  o.what += text(", end %.5g instead of %.5g, spread %.2g", t.temperature_mean, end,
                 t.temperature_max - t.temperature_min);
  return o;
}

void mixing(const Settings& s, Report& r) {
  spread(s, r, "end temperature of ice and water", 0.02, "% of the range",
         "the heat balance is exact; waiting ends with a millionth of the range, or after four times the "
         "slowest decay",
         mixed);
}

/// lambda of Neumann's two-phase front into a half space of solid at `cold` below its melting point, wall at `warm` above:
/// exp(-l^2)/erf(l) - (k_s/k_l) sqrt(a_l/a_s) (cold/warm) exp(-l^2 a_l/a_s)/erfc(l sqrt(a_l/a_s)) = l sqrt(pi) L/(c_l warm).
double neumann(double k_ratio, double a_ratio, double cold_over_warm, double ste) {
  const double r = std::sqrt(a_ratio);  // sqrt(a_l / a_s)
  double low = 1e-6, high = 5;
  for (int k = 0; k < 200; ++k) {
    const double l = 0.5 * (low + high);
    const double left = std::exp(-l * l) / std::erf(l) -
                        k_ratio * r * cold_over_warm * std::exp(-l * l * a_ratio) / std::erfc(l * r);
    (left > l * std::sqrt(pi) / ste ? low : high) = l;
  }
  return 0.5 * (low + high);
}

/// A melting front from a wall of constant temperature into cold solid along any axis.
Outcome melting_front(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.1);
  MaterialDesc liquid, solid;
  double warm = 0, cold = 0, ste = 0, al = 0, lambda = 0;
  int depth = 0, length = 0;
  do {  // bars of more than 200 sites are drawn again
    liquid = solid = substance(dice, "liquid");
    solid.name = "solid";
    solid.heat_capacity = liquid.heat_capacity * dice.log(0.4, 2.5);
    solid.conductivity = liquid.conductivity * dice.log(0.25, 4);
    solid.melting_point = dice.uniform(-50, 500);
    warm = dice.log(1, 300), cold = warm * dice.uniform(0, 0.5), ste = dice.log(0.1, 2);
    solid.latent_heat = liquid.heat_capacity * warm / ste;
    al = liquid.conductivity / (liquid.density * liquid.heat_capacity);
    const double as = solid.conductivity / (solid.density * solid.heat_capacity);
    lambda = neumann(solid.conductivity / liquid.conductivity, al / as, cold / warm, ste);
    depth = dice.whole(8, 14);
    length = depth + 2 + static_cast<int>(3.5 * std::sqrt(as / al) * depth / (2 * lambda));
  } while (length > 200);
  const int axis = dice.whole(0, 2);
  const bool from_above = dice.coin();
  Outcome o{0, text("Ste %.3g, lambda %.3g, %.0f dx deep of %.0f, k_s/k_l %.3g, cold/warm %.2f", ste, lambda,
                    depth, length, solid.conductivity / liquid.conductivity, cold / warm)};
  const double end = std::pow(depth * dx / (2 * lambda), 2) / al, dt = 1e-4 * dx;
  const int steps = static_cast<int>(std::ceil(end / (2 * dx * dx / al)));
  Vec3i cells{8, 8, 8};
  std::array<Face, 3> faces{Face::periodic, Face::periodic, Face::periodic};
  (axis == 0 ? cells.x : axis == 1 ? cells.y : cells.z) = length;
  faces[static_cast<std::size_t>(axis)] = Face::wall;
  WorldDesc d = box(s, dx, cells, faces[0], faces[1], faces[2]);
  d.gravity = {};
  d.sound_speed = 1;
  d.heat.time_scale = end / steps / dt;
  auto& wall = d.domain.heat[static_cast<std::size_t>(2 * axis + (from_above ? 1 : 0))];
  wall.temperature = solid.melting_point + warm;
  auto world = World::create(d);
  if (!world) return report.error = world.error().message, o;
  solid.melts_into = *world->add_material(liquid);
  const auto id = world->add_material(solid);
  if (!id) return report.error = id.error().message, o;
  SolidDesc b;
  b.shape = Shape::box({0, 0, 0}, d.domain.max);
  b.material = *id;
  b.temperature = solid.melting_point - cold;
  b.fixed = true;
  if (auto a = world->add_solid(b); !a) return report.error = a.error().message, o;
  for (int k = 0; k < steps; ++k)
    if (Status step = world->step(dt); !step) return report.error = step.error().message, o;
  const StepResult r = world->synchronize();
  if (r.halted || r.heat_bound_exceeded)
    return report.error = r.halted ? r.halt_reason : "heat bound exceeded", o;
  // What came through the wall: 2 k_l warm sqrt(t / (pi a_l)) / erf(lambda), per area.
  const double exact = 2 * liquid.conductivity * warm * std::sqrt(end / (pi * al)) / std::erf(lambda) * 64 *
                       dx * dx,
               ours = world->totals()->heat_in;
  o.error = 100 * std::fabs(ours / exact - 1);
  o.what += text(", heat %.4f of what it should be", ours / exact);
  return o;
}

void front(const Settings& s, Report& r) {
  spread(s, r, "heat taken up behind a melting front", 1, "%",
         "first order in a layer of 8 to 14 for the time before the first layer melts", melting_front);
}

// ---- liquid ----------------------------------------------------------------------------------------------------------------

/// A tank that stands on any of its six faces. Times in sqrt(dx/g): 13 per layer, as in liquid.hydrostatic.
Outcome tank_at_rest(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 1), g = dice.log(1, 100), density = dice.log(100, 10000);
  const int axis = dice.whole(0, 2), layers = dice.whole(8, 14);
  const double sign = dice.coin() ? 1 : -1;
  Vec3i cells{dice.whole(7, 12), dice.whole(7, 12), dice.whole(7, 12)};
  (axis == 0 ? cells.x : axis == 1 ? cells.y : cells.z) = layers + 6;
  WorldDesc d = box(s, dx, cells, Face::wall, Face::wall, Face::wall);
  const Vec3d up = axis == 0 ? Vec3d{sign, 0, 0} : axis == 1 ? Vec3d{0, sign, 0} : Vec3d{0, 0, sign};
  d.gravity = up * -g;
  Outcome o{0, text("%.0f layers, axis %.0f, dx %.3g m, g %.3g, density %.4g", layers, sign * (axis + 1), dx,
                    g, density)};
  Run run(d, report);
  const Vec3d gap = Vec3d{up.x * 6 * dx, up.y * 6 * dx, up.z * 6 * dx};
  run.fluid(
      Shape::box({std::max(0.0, -gap.x), std::max(0.0, -gap.y), std::max(0.0, -gap.z)},
                 d.domain.max - Vec3d{std::max(0.0, gap.x), std::max(0.0, gap.y), std::max(0.0, gap.z)}),
      run.material("liquid", density, density * 0.01 * std::sqrt(g * dx) * dx));
  const double unit = std::sqrt(dx / g), until = 13 * layers * unit;
  std::vector<double> pressure(static_cast<std::size_t>(layers)), count(pressure);
  double top = 0;
  int samples = 0;
  for (double t = 0.7 * until; run.to(t) && t < until; t += 2 * unit, ++samples) {
    const ParticleData p = run.particles();
    double mean = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      const double x = dot(p.position[i], up), height = sign > 0 ? x : x + (layers + 6) * dx;
      mean += height / static_cast<double>(p.id.size());
      const int k = static_cast<int>(height / dx);
      if (k < 0 || k >= layers) continue;
      pressure[static_cast<std::size_t>(k)] += p.pressure[i];
      count[static_cast<std::size_t>(k)] += 1;
    }
    top += 2 * mean;
  }
  if (!run.good()) return o;
  top /= samples;  // of the liquid, from its centre of mass
  double e = 0, all = 0;
  for (int k = 0; k < layers - 2; ++k) {  // the upper two are those of the free surface
    const auto b = static_cast<std::size_t>(k);
    const double exact = density * g * (layers - k - 0.5) * dx,
                 ours = count[b] > 0 ? pressure[b] / count[b] : 0;
    e += (ours - exact) * (ours - exact);
    all += exact * exact;
  }
  o.error = 100 * std::sqrt(e / all);
  o.what += text(", level %.3f of %.0f layers", top / dx, layers);
  return o;
}

void tank(const Settings& s, Report& r) {
  spread(s, r, "pressure in a tank", 5, "%",
         "3 % of 16 layers; the error of the free surface grows as 1/layers", tank_at_rest);
}

/// Flow between plates in any of the six orientations: a wall that moves, or a pull along them, at any time after the start.
Outcome channel_flow(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-4, 0.1), density = dice.log(100, 10000), reynolds = dice.log(0.01, 1),
               speed = dice.log(0.1, 10) * dx;
  const int layers = dice.whole(12, 24), across = dice.whole(0, 2);
  const int along = (across + dice.whole(1, 2)) % 3;
  const double height = layers * dx, nu = speed * height / reynolds;
  const double fourier =
      dice.log(16.0 / (layers * layers), 1);  // the layer at the wall is four spacings thick or more
  const bool moved = dice.coin();
  const double way = dice.coin() ? 1 : -1;
  const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Vec3i cells{8, 8, 8};
  (across == 0 ? cells.x : across == 1 ? cells.y : cells.z) = layers;
  std::array<Face, 3> faces{Face::periodic, Face::periodic, Face::periodic};
  faces[static_cast<std::size_t>(across)] = Face::wall;
  WorldDesc d = box(s, dx, cells, faces[0], faces[1], faces[2]);
  d.gravity = {};
  d.artificial_viscosity = 0;
  d.sound_speed = 10 * speed;
  const Vec3d flow = axes[along] * (way * speed);
  const bool upper = dice.coin();
  if (moved) d.domain.velocity[static_cast<std::size_t>(2 * across + (upper ? 1 : 0))] = flow;
  else d.gravity = axes[along] * (way * 8 * nu * speed / (height * height));
  Outcome o{0, text(moved ? "Couette, %.0f layers, Re %.3g, Fo %.3g, across %.0f along %.0f"
                          : "Poiseuille, %.0f layers, Re %.3g, Fo %.3g, across %.0f along %.0f",
                    layers, reynolds, fourier, across, along)};
  Run run(d, report);
  run.fluid(Shape::box({0, 0, 0}, d.domain.max), run.material("liquid", density, density * nu));
  const double until =
      fourier * height * height / nu;  // in forty steps or more: viscosity of a step is of first order in it
  if (!run.to(until, until / 40)) return o;
  const ParticleData p = run.particles();
  double worst = 0;
  std::vector<double> sum(static_cast<std::size_t>(layers)), count(sum);
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const auto k = std::min(sum.size() - 1,
                            static_cast<std::size_t>(std::max(0.0, dot(p.position[i], axes[across]) / dx)));
    sum[k] += dot(p.velocity[i], axes[along]) * way / speed;
    count[k] += 1;
  }
  for (int k = 0; k < layers; ++k) {
    const double place = (k + 0.5) / layers, y = moved && !upper ? 1 - place : place;
    double exact = moved ? y : 4 * y * (1 - y);
    for (int n = 1; n < 200; ++n) {
      const double a = n * pi, decay = std::exp(-a * a * fourier);
      if (moved) exact += 2 / a * (n % 2 == 0 ? 1 : -1) * decay * std::sin(a * y);
      else if (n % 2 == 1) exact -= 32 / (a * a * a) * decay * std::sin(a * y);
    }
    const auto b = static_cast<std::size_t>(k);
    worst = std::max(worst, std::fabs(sum[b] / std::max(1.0, count[b]) - exact));
  }
  o.error = 100 * worst;
  return o;
}

void channel(const Settings& s, Report& r) {
  spread(s, r, "flow between plates", 2, "% of the speed", "second order in 1/12 of the height",
         channel_flow);
}

/// A jet in any direction in the open: every particle keeps v^2/2 - g.x, and stays within the nozzle's radius of the parabola.
Outcome free_jet(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.1), g = dice.log(1, 30);
  // Slower ones feel the pressure at the end of the pipe: rho g R beside rho v^2.
  const double radius = dice.uniform(1.5, 5) * dx, speed = std::sqrt(g * radius) * dice.log(4.5, 20);
  const Vec3d axis = dice.direction(), pull = dice.direction() * -g;
  const double density = dice.log(300, 8000);
  Outcome o{0, text("radius %.2f dx, speed %.3g sqrt(g radius), %.0f degrees from down, dx %.3g", radius / dx,
                    speed / std::sqrt(g * radius), std::acos(dot(axis, pull) / g) * 180 / pi, dx)};
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = pull;
  Run run(d, report);
  EmitterDesc e;
  e.center = {0, 0, 0};
  e.axis = axis;
  e.radius = radius;
  e.speed = speed;
  e.material = run.material("liquid", density, density * 1e-3 * speed * radius);
  // For forty spacings, or until gravity has changed the velocity by half.
  e.until = std::min(40 * dx / speed, 0.5 * speed / g);
  if (!run.emitter(e) || !run.to(e.until)) return o;
  const ParticleData p = run.particles();
  std::vector<double> off;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const Vec3d x = p.position[i], v = p.velocity[i];
    if (dot(x, axis) < 2 * dx) continue;  // in the pipe, or just out of it
    // How far it is beyond the edge of the jet, A v = const, at the nearest point of the parabola.
    double best = infinity, edge = radius;
    for (int k = 0; k <= 400; ++k) {
      const double t = e.until * k / 400, away = length(x - (axis * (speed * t) + pull * (0.5 * t * t)));
      if (away < best) edge = radius * std::max(1.0, std::sqrt(speed / length(axis * speed + pull * t)));
      best = std::min(best, away);
    }
    const double energy = std::fabs(dot(v, v) - speed * speed - 2 * dot(pull, x)) / (speed * speed);
    off.push_back(std::max(std::max(0.0, best - edge) / radius, energy));
  }
  if (off.size() < 20) return o.what += " (too few particles)", o;
  std::sort(off.begin(), off.end());
  o.error = 100 * off[off.size() * 95 / 100];
  o.what += text(", %.0f particles, farthest %.0f %%", double(off.size()), 100 * off.back());
  return o;
}

void jet(const Settings& s, Report& r) {
  spread(s, r, "95 % of a jet: radius and energy", 8, "%",
         "nothing acts on a jet but gravity; liquid leaves the pipe in layers of a spacing", free_jet);
}

// ---- bodies ----------------------------------------------------------------------------------------------------------------

/// A body of any shape that flies: its centre keeps to the parabola, and it its spin.
Outcome thrown(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 1), g = dice.log(1, 100), size = dice.uniform(2.5, 5) * dx;
  const Vec3d pull = dice.direction() * g, at = dice.place(1, 1000) * dx;
  const double fall = dice.log(10, 200) * dx, t = std::sqrt(2 * fall / g);
  const int kind = dice.whole(0, 2);
  MaterialDesc m;
  m.name = "stone";
  m.density = dice.log(100, 10000);
  m.region_half_width = dice.whole(1, 3);
  SolidDesc b;
  if (kind == 0) {
    b.shape = Shape::sphere(at, size);
  } else if (kind == 1) {
    const Vec3d half{size, 0.7 * size, 1.3 * size};
    b.shape = Shape::box(at - half, at + half);
  } else {
    const Vec3d second = at + dice.direction() * size, first = at - dice.direction() * size;
    b.shape = Shape::cylinder(first, second, 0.8 * size);
  }
  const double speed = dice.log(0.1, 10);
  b.velocity = dice.direction() * std::sqrt(g * dx) * speed;
  const double spin = dice.log(0.01, 0.3) * std::sqrt(g / dx);
  b.angular_velocity = dice.direction() * spin;
  b.motion = dice.coin() ? Motion::rigid : Motion::free;
  Outcome o{0, text("kind %.0f, size %.2f dx, %.0f dx of fall, dx %.3g, half-width %.0f, rigid %.0f", kind,
                    size / dx, fall / dx, dx, m.region_half_width, b.motion == Motion::rigid ? 1 : 0)};
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = pull;
  auto world = World::create(d);
  if (!world) return report.error = world.error().message, o;
  b.material = *world->add_material(m);
  if (auto a = world->add_solid(b); !a) return report.error = a.error().message, o;
  const auto motion = [&](Vec3d& centre, Vec3d& spun) {
    const ParticleData p = *world->particles();
    Vec3d c{}, v{};
    for (std::size_t i = 0; i < p.id.size(); ++i) c += p.position[i], v += p.velocity[i];
    centre = c * (1.0 / static_cast<double>(p.id.size()));
    v = v * (1.0 / static_cast<double>(p.id.size()));
    spun = {};
    for (std::size_t i = 0; i < p.id.size(); ++i) spun += cross(p.position[i] - centre, p.velocity[i] - v);
  };
  Vec3d from, spun0, to, spun1;
  motion(from, spun0);
  const int steps = 64;
  for (int k = 0; k < steps; ++k) {
    if (Status step = world->step(t / steps); !step) return report.error = step.error().message, o;
  }
  if (const StepResult r = world->synchronize(); r.halted) return report.error = r.halt_reason, o;
  motion(to, spun1);
  const double off = length(to - from - b.velocity * t - pull * (0.5 * t * t)) / dx,
               lost = length(spun1 - spun0) / length(spun0);
  o.error = 100 * std::max(off, lost);
  o.what += text(", off by %.2g dx, spin by %.2g", off, lost);
  return o;
}

void flight(const Settings& s, Report& r) {
  spread(s, r, "flight of a body: place in dx, angular momentum", 1, "%",
         "leap-frog is exact under gravity; rounding remains", thrown);
}

/// A block on an incline: it stays below the angle of friction, and above it slides at g (sin - mu cos).
Outcome slide(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.5), g = dice.log(1, 30), mu = dice.uniform(0.05, 0.9),
               angle = dice.uniform(0.05, 0.9);
  const int nx = dice.whole(4, 8), ny = dice.whole(2, 4), nz = dice.whole(4, 8);
  const double turn = dice.uniform(0, 2 * pi);
  const Vec3d along{std::cos(turn), 0, std::sin(turn)};
  Outcome o{0, text("%.0f x %.0f x %.0f sites, mu %.3f, tan %.3f, dx %.3g, towards %.0f degrees", nx, ny, nz,
                    mu, std::tan(angle), dx, turn * 180 / pi)};
  WorldDesc d = box(s, dx, {600, 30, 600}, Face::wall, Face::wall, Face::wall);
  d.domain.friction = mu;
  d.gravity = along * (g * std::sin(angle)) + Vec3d{0, -g * std::cos(angle), 0};
  Run run(d, report);
  MaterialDesc m;
  m.name = "stone";
  m.density = dice.log(300, 8000);
  m.friction = 1;
  const MaterialId id = run.material(m);
  const Vec3d corner{300 * dx, 0, 300 * dx};  // it slides 132 spacings at most
  run.solid("block", Shape::box(corner, corner + Vec3d{nx * dx, ny * dx, nz * dx}), id);
  const double a = g * std::max(0.0, std::sin(angle) - mu * std::cos(angle)), t0 = 10 * std::sqrt(dx / g),
               t1 = t0 + (a > 0 ? std::min(std::sqrt(2 * 30 * dx / a), 60 * std::sqrt(dx / g))
                                : 60 * std::sqrt(dx / g));
  const auto speed = [&] {
    const ParticleData p = run.particles();
    double v = 0;
    for (const Vec3d& u : p.velocity) v += dot(u, along) / static_cast<double>(p.id.size());
    return v;
  };
  if (!run.to(t0)) return o;
  const double before = speed();
  if (!run.to(t1)) return o;
  const double ours = (speed() - before) / (t1 - t0);
  o.error = 100 * std::fabs(ours - a) / (g * std::sin(angle));
  o.what += text(", %.4g instead of %.4g g sin", ours / (g * std::sin(angle)), a / (g * std::sin(angle)));
  return o;
}

void incline(const Settings& s, Report& r) {
  spread(s, r, "acceleration down an incline", 3, "% of g sin",
         "Coulomb's law, through springs that give a little", slide);
}

/// A flat box in a tank: its draught is the ratio of densities times its height.
Outcome afloat(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.5), g = dice.log(1, 100), liquid = dice.log(300, 8000),
               ratio = dice.uniform(0.15, 0.9);
  const int height = dice.whole(3, 5), width = dice.whole(2 * height, 10), depth = dice.whole(2 * height, 10),
            layers = dice.whole(8, 10);
  const bool rigid = dice.coin();
  const int nx = width + dice.whole(6, 9), nz = depth + dice.whole(6, 9);
  Outcome o{0, text("%.0f x %.0f x %.0f sites, ratio %.3f, liquid %.4g kg/m^3, rigid %.0f", width, height,
                    depth, ratio, liquid, rigid ? 1 : 0)};
  WorldDesc d = box(s, dx, {nx, layers + 12, nz}, Face::wall, Face::wall, Face::wall);
  d.gravity = {0, -g, 0};
  Run run(d, report);
  MaterialDesc m;
  m.name = "wood";
  m.density = ratio * liquid;
  SolidDesc b;
  b.name = "box";
  const double x = (nx - width) / 2 * dx, z = (nz - depth) / 2 * dx,
               bottom = (layers - std::lround(ratio * height)) * dx;
  b.shape = Shape::box({x, bottom, z}, {x + width * dx, bottom + height * dx, z + depth * dx});
  b.material = run.material(m);
  b.motion = rigid ? Motion::rigid : Motion::free;
  run.solid(b);
  run.fluid(Shape::box({0, 0, 0}, {nx * dx, layers * dx, nz * dx}),
            run.material("liquid", liquid, liquid * 0.01 * std::sqrt(g * dx) * dx));
  const double unit = std::sqrt(dx / g), until = 65 * unit, area = double(nx) * nz,
               base = double(width) * depth;
  double draught = 0;
  int samples = 0;
  for (double t = 0.6 * until; run.to(t) && t < until; t += unit, ++samples) {
    const ParticleData p = run.particles();
    double centre = 0, n = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (is_solid(p.tag[i])) centre += p.position[i].y / dx, ++n;
    const double low = centre / n - 0.5 * height;
    draught += (static_cast<double>(run.last().fluid) - low * base) / (area - base) - low;
  }
  if (!run.good()) return o;
  draught /= samples;
  o.error = std::fabs(draught - ratio * height);
  o.what += text(", draught %.3f instead of %.3f", draught, ratio * height);
  return o;
}

void float_(const Settings& s, Report& r) {
  spread(s, r, "draught of a box", 0.5, "dx", "half a spacing: what a surface of particles resolves", afloat);
}

/// A column let go in a tank comes to rest level: as high as its volume over the floor's area.
Outcome levelled(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.5), g = dice.log(1, 100), liquid = dice.log(300, 8000);
  const int nx = dice.whole(12, 24), nz = dice.whole(8, 12), width = dice.whole(5, nx - 3),
            height = dice.whole(8, 16);
  const double tilt = dice.coin() ? 0 : dice.uniform(-0.3, 0.3);
  Outcome o{0, text("%.0f x %.0f of %.0f x %.0f sites, tilted by %.2f", width, height, nx, nz, tilt)};
  WorldDesc d = box(s, dx, {nx, 2 * height + 8, nz}, Face::wall, Face::wall, Face::wall);
  d.gravity = {g * std::sin(tilt), -g * std::cos(tilt), 0};
  Run run(d, report);
  const double left = dice.whole(0, nx - width) * dx;
  run.fluid(Shape::box({left, 0, 0}, {left + width * dx, height * dx, nz * dx}),
            run.material("liquid", liquid, liquid * 0.05 * std::sqrt(g * dx) * dx));
  const double unit = std::sqrt(dx / g), until = 300 * unit;
  double x = 0, y = 0;
  int samples = 0;
  for (double t = 0.7 * until; run.to(t) && t < until; t += 3 * unit, ++samples) {
    const ParticleData p = run.particles();
    for (const Vec3d& at : p.position) {
      x += at.x / dx / static_cast<double>(p.id.size());
      y += at.y / dx / static_cast<double>(p.id.size());
    }
  }
  if (!run.good()) return o;
  // Centre of mass of the trapezium under the surface y = a + (x - nx/2) tan(tilt), or of the triangle in a corner.
  const double a = double(width) * height / nx, slope = std::tan(tilt);
  if (std::fabs(slope) * nx / 2 > a) return o.what += " (a dry floor)", o.error = 0, o;
  const double cx = nx / 2.0 + slope * std::pow(nx, 2) / (12 * a),
               cy = a / 2 + slope * slope * nx * nx / (24 * a);
  o.error = std::max(std::fabs(x / samples - cx), 2 * std::fabs(y / samples - cy));
  o.what += text(", centre at %.2f %.2f instead of %.2f %.2f dx", x / samples, y / samples, cx, cy);
  return o;
}

void level(const Settings& s, Report& r) {
  spread(s, r, "centre of mass of a column that has come to rest", 0.5, "dx",
         "half a spacing: what a surface of particles resolves", levelled);
}

/// A body of any shape, loose in a warm bath under gravity: it melts, and what is left follows from the heat balance.
Outcome bathed(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 0.2), g = dice.log(1, 30);
  const int side = dice.whole(10, 13), layers = dice.whole(8, 10), kind = dice.whole(0, 2),
            drop = dice.whole(0, 5);
  MaterialDesc water, ice;
  water.name = "water";
  water.density = dice.log(500, 5000);
  water.viscosity = water.density * 0.02 * std::sqrt(g * dx) * dx;
  water.heat_capacity = dice.log(500, 5000);
  water.conductivity = dice.log(0.1, 10);
  ice = water;
  ice.name = "ice";
  ice.density = water.density * dice.uniform(0.5, 1.6);
  ice.conductivity = water.conductivity * dice.log(0.5, 4);
  ice.heat_capacity = water.heat_capacity * dice.log(0.5, 1.2);
  ice.melting_point = dice.uniform(-20, 300);
  const double cold = dice.log(1, 30), hot = dice.log(30, 200);
  ice.latent_heat = water.heat_capacity * dice.log(5, 100);
  const bool rigid = dice.coin();
  Outcome o{0, text("%.0f wide, %.0f layers, kind %.0f, density ratio %.3f, rigid %.0f, dropped %.0f dx",
                    side, layers, kind, ice.density / water.density, rigid ? 1 : 0, drop)};
  WorldDesc d = box(s, dx, {side, layers + 16, side}, Face::wall, Face::wall, Face::wall);
  d.gravity = {0, -g, 0};
  const double unit = std::sqrt(dx / g);
  // Heat crosses a spacing of ice in the time of a few spacings of fall.
  d.heat.time_scale = 0.2 * dx * dx * water.density * water.heat_capacity / water.conductivity / unit;
  Run run(d, report);
  const MaterialId w = run.material(water);
  ice.melts_into = w;
  SolidDesc b;
  b.name = "ice";
  b.material = run.material(ice);
  b.temperature = ice.melting_point - cold;
  b.motion = rigid ? Motion::rigid : Motion::free;
  const Vec3d at{side / 2.0 * dx, (layers + 3.5 + drop) * dx, side / 2.0 * dx};
  b.shape = kind == 0   ? Shape::sphere(at, 2.6 * dx)
            : kind == 1 ? Shape::box(at - Vec3d{2, 2, 3} * dx, at + Vec3d{2, 2, 3} * dx)
                        : Shape::cylinder(at - Vec3d{2.5, 0, 1} * dx, at + Vec3d{2.5, 0, 1} * dx, 2.2 * dx);
  run.solid(b);
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {side * dx, layers * dx, side * dx});
  f.material = w;
  f.temperature = ice.melting_point + hot;
  run.fluid(f);
  const ParticleData p = run.particles();
  double mi = 0, mw = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) (is_solid(p.tag[i]) ? mi : mw) += p.mass[i];
  const double need = mi * (ice.heat_capacity * cold + ice.latent_heat),
               have = mw * water.heat_capacity * hot;
  const double end =
      have > need ? ice.melting_point + (have - need) / ((mi + mw) * water.heat_capacity) : ice.melting_point;
  double spread_of = infinity;
  Totals t;
  for (int k = 1; k <= 60; ++k) {
    if (!run.to(k * 20 * unit, unit)) return o;
    t = run.totals();
    spread_of = (t.temperature_max - t.temperature_min) / (hot + cold);
    if (spread_of < 1e-5) break;
  }
  o.error = 100 * std::fabs(t.temperature_mean - end) / (hot + cold);
  if (have > 1.1 * need && t.solid != 0) o.error = 100;  // all of it should have melted
  o.what += text(", end %.5g instead of %.5g, spread %.2g, %.0f solid", t.temperature_mean, end, spread_of,
                 double(t.solid));
  return o;
}

void bath(const Settings& s, Report& r) {
  spread(s, r, "end temperature of a bath with a loose body", 0.1, "% of the range",
         "the heat balance is exact; waiting ends with a spread of 1e-5 of the range, or 1200 times the fall "
         "of a spacing",
         bathed);
}

/// Liquids and bodies that meet without gravity: momentum is what it was, energy no more than it was.
Outcome met(Dice& dice, const Settings& s, Report& report) {
  const double dx = dice.log(1e-3, 1), speed = std::sqrt(dx) * dice.log(0.5, 10);
  const int bodies = dice.whole(1, 3);
  Outcome o{0, text("%.0f bodies, speed %.3g, dx %.3g", bodies, speed, dx)};
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = {};
  Run run(d, report);
  const MaterialId liquid = run.material("liquid", dice.log(300, 8000), 1e-3);
  run.fluid(Shape::sphere({0, 0, 0}, 6 * dx), liquid);
  for (int k = 0; k < bodies; ++k) {
    const Vec3d side = dice.direction();
    // One from each of three sides that are 120 degrees apart, so that they do not start in each other.
    const double turn = 2 * pi * k / 3 + dice.uniform(-0.3, 0.3);
    const Vec3d at{std::cos(turn) * 11 * dx, 2 * side.y * dx, std::sin(turn) * 11 * dx};
    MaterialDesc m;
    m.name = "stone" + std::to_string(k);
    m.density = dice.log(300, 8000);
    SolidDesc b;
    b.name = m.name;
    b.material = run.material(m);
    b.shape = Shape::sphere(at, dice.uniform(2, 3.5) * dx);
    b.velocity = at * (-speed / length(at));
    b.motion = dice.coin() ? Motion::rigid : Motion::free;
    run.solid(b);
  }
  const auto look = [&](double& energy, double& scale) {
    const ParticleData p = run.particles();
    Vec3d sum{};
    energy = scale = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      sum += p.velocity[i] * p.mass[i];
      scale += length(p.velocity[i]) * p.mass[i];
      energy += 0.5 * dot(p.velocity[i], p.velocity[i]) * p.mass[i];
    }
    return sum;
  };
  double e0, e1, scale, after;
  if (!run.good()) return o;
  const Vec3d p0 = look(e0, scale);
  if (!run.to(20 * dx / speed)) return o;
  const Vec3d p1 = look(e1, after);
  const double lost = length(p1 - p0) / scale, gained = std::max(0.0, e1 / e0 - 1);
  o.error = std::max(lost / (s.precision == Precision::double_precision ? 1e-10 : 1e-4), gained / 0.01);
  o.what += text(", momentum off by %.2g, energy %.3f of what it was", lost, e1 / e0);
  return o;
}

void meeting(const Settings& s, Report& r) {
  spread(s, r, "momentum (1e-4; double 1e-10) and energy (1 % more) when bodies meet a drop, in those bounds",
         1, "-", "forces are exact negatives of each other; springs and pressure give back what they took",
         met);
}

}  // namespace

std::vector<Case> drawn_cases() {
  return {
      {"drawn.cooling", "Blocks of any size and substance cooled by convection", "product of three slabs",
       false, cooling},
      {"drawn.mixing", "Ice and water of any substance in an insulated tank", "heat balance", false, mixing},
      {"drawn.front", "Melting fronts into cold solids along any axis", "Neumann, two phases", false, front},
      {"drawn.tank", "Tanks of any liquid, on any of their faces", "rho g h", false, tank},
      {"drawn.channel", "Couette and Poiseuille flow in any orientation", "series solution", false, channel},
      {"drawn.jet", "Jets in any direction under gravity in any direction", "free fall", false, jet},
      {"drawn.flight", "Bodies that spin and fall", "free fall", false, flight},
      {"drawn.incline", "Blocks on inclines", "Coulomb's law", false, incline},
      {"drawn.float", "Flat boxes in tanks", "Archimedes", false, float_},
      {"drawn.level", "Columns let go in tanks, level or tilted", "volume", false, level},
      {"drawn.bath", "Bodies of any shape melting loose in a bath", "heat balance", false, bath},
      {"drawn.meeting", "Bodies that hit a drop without gravity", "conservation", false, meeting},
  };
}

}  // namespace validation
