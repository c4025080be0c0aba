// SPDX-License-Identifier: Apache-2.0
// Solids: lattice shape matching against bars and beams, rigid motion, contact, bodies that come apart.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "constants.hpp"
#include "validation.hpp"

namespace validation {

namespace {

using meltsim::MaterialDesc;
using meltsim::ParticleData;
using meltsim::Shape;
using meltsim::SolidDesc;
using meltsim::Vec3d;
using meltsim::World;

/// A World without gravity and heat that holds one box of lattice points.
struct Block {
  double spacing = 0.1;
  int nx = 1, ny = 1, nz = 1;  ///< lattice points per axis
  Vec3d corner;
  MaterialDesc material;
  Vec3d velocity, spin;
  double dt = 1e-3;  ///< the step that stiffness belongs to [s]
};

/// The sound speed at which the acoustic step is dt: bodies then have their stiffness at steps of dt.
double sound_speed_for(const meltsim::WorldDesc& d, double dt) { return d.courant * 2.5 * d.spacing / dt; }

meltsim::Result<World> make_block(const Settings& s, const Block& b) {
  meltsim::WorldDesc d = world_desc(s);
  d.spacing = b.spacing;
  d.gravity = {0, 0, 0};
  d.heat.model = meltsim::HeatModel::none;
  d.sound_speed = sound_speed_for(d, b.dt);
  auto world = World::create(d);
  if (!world) return world.error();
  MaterialDesc m = b.material;
  m.name = "solid";
  const auto id = world->add_material(m);
  if (!id) return id.error();
  SolidDesc solid;
  const double h = b.spacing;
  solid.shape = Shape::box(b.corner, b.corner + Vec3d{b.nx * h, b.ny * h, b.nz * h});
  solid.material = *id;
  solid.velocity = b.velocity;
  solid.angular_velocity = b.spin;
  const auto body = world->add_solid(solid);
  if (!body) return body.error();
  return world;
}

/// Takes a step and says whether it could; what went wrong goes to the report.
bool advance(World& world, double dt, Report& report) {
  const meltsim::Status status = world.step(dt);
  if (!status) report.error = status.error().message;
  return status.ok();
}

bool sound(World& world, Report& report) {
  const meltsim::StepResult result = world.synchronize();
  if (result.halted) report.error = result.halt_reason;
  return !result.halted;
}

struct Oscillation {
  double frequency = 0;  ///< [rad/s]
  double mean = 0;       ///< about which it oscillates
};

/// Samples that oscillate about a constant: least squares of a + b cos + c sin over the
/// frequencies around `guess`, refined by golden section. Good to about 1e-3 of itself over five periods.
Oscillation fit_oscillation(const std::vector<double>& t, const std::vector<double>& y, double guess) {
  double mean = 0;
  const auto residual = [&](double omega) {
    double m[3][4] = {};
    for (std::size_t i = 0; i < t.size(); ++i) {
      const double f[4] = {1, std::cos(omega * t[i]), std::sin(omega * t[i]), y[i] - y[0]};
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 4; ++b) m[a][b] += f[a] * f[b];
    }
    for (int a = 0; a < 3; ++a)
      for (int b = a + 1; b < 3; ++b) {
        const double factor = m[b][a] / m[a][a];
        for (int c = a; c < 4; ++c) m[b][c] -= factor * m[a][c];
      }
    double x[3] = {};
    for (int a = 2; a >= 0; --a) {
      x[a] = m[a][3];
      for (int c = a + 1; c < 3; ++c) x[a] -= m[a][c] * x[c];
      x[a] /= m[a][a];
    }
    double sum = 0;
    for (std::size_t i = 0; i < t.size(); ++i) {
      const double e = y[i] - y[0] - x[0] - x[1] * std::cos(omega * t[i]) - x[2] * std::sin(omega * t[i]);
      sum += e * e;
    }
    mean = y[0] + x[0];
    return sum;
  };
  double best = guess, least = residual(guess);
  constexpr int steps = 400;
  for (int k = 0; k <= steps; ++k) {
    const double omega = guess * (0.6 + 0.8 * k / steps), r = residual(omega);
    if (r < least) {
      least = r;
      best = omega;
    }
  }
  double low = best - guess * 0.8 / steps, high = best + guess * 0.8 / steps;
  for (int k = 0; k < 40; ++k) {
    const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
    if (residual(a) < residual(b)) high = b;
    else low = a;
  }
  static_cast<void>(residual(0.5 * (low + high)));  // sets the mean
  return {0.5 * (low + high), mean};
}

/// Particles within half of `thickness` of the plane at x, and below `top`.
std::vector<std::size_t> slice(const ParticleData& p, double x, double thickness, double top = 1e30) {
  std::vector<std::size_t> ids;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (std::fabs(p.position[i].x - x) < 0.5 * thickness && p.position[i].y < top) ids.push_back(i);
  return ids;
}

Vec3d mean_of(const ParticleData& p, const std::vector<std::size_t>& ids) {
  Vec3d sum;
  for (const std::size_t i : ids) sum += p.position[i];
  return sum * (1.0 / static_cast<double>(ids.size()));
}

std::vector<std::size_t> all_of(const ParticleData& p) {
  std::vector<std::size_t> ids(p.id.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = i;
  return ids;
}

struct BarResult {
  double wave_speed = 0;  ///< of longitudinal waves [m/s]
  double modulus = 0;     ///< from the mean stretch [Pa]
  Curve stretch;          ///< over time [s], [m]
};

/// A slender free bar that is set spinning about z stretches. It oscillates about the centrifugal stretch
/// rho spin^2 L^3 / (12 E) with the period 2 L/c of the first longitudinal mode: two ways to the modulus.
BarResult spin_bar(const Settings& s, Block bar, double dt, double expected_speed, Report& report) {
  BarResult result;
  const double length = bar.nx * bar.spacing, h = bar.spacing;
  // A strain of 1e-3 at most: far above float's rounding, and a thousandth away from linear.
  const double spin = expected_speed / length * std::sqrt(8e-3);
  bar.spin = {0, 0, spin};
  bar.dt = dt;
  bar.material.damping = 0;
  auto world = make_block(s, bar);
  if (!world) {
    report.error = world.error().message;
    return result;
  }
  const ParticleData first = *world->particles();
  const auto left = slice(first, bar.corner.x + 0.5 * h, h),
             right = slice(first, bar.corner.x + length - 0.5 * h, h);
  const double period = 2 * length / expected_speed;
  const int steps = static_cast<int>(std::ceil(5 * period / dt));
  const int every = std::max(1, static_cast<int>(period / dt / 24));
  for (int k = 0; k <= steps; ++k) {
    if (k % every == 0) {
      const auto p = world->particles();
      if (!p) {
        report.error = p.error().message;
        return result;
      }
      result.stretch.x.push_back(k * dt);
      result.stretch.y.push_back(meltsim::length(mean_of(*p, right) - mean_of(*p, left)) - length + h);
    }
    if (!advance(*world, dt, report)) return result;
  }
  if (!sound(*world, report)) return result;
  const Oscillation o = fit_oscillation(result.stretch.x, result.stretch.y, 2 * pi / period);
  result.wave_speed = o.frequency * length / pi;
  result.modulus = bar.material.density * spin * spin * length * length * length / (12 * o.mean);
  return result;
}

/// c/(dx/dt) of a region half-width at alpha = 1.
double lattice_speed(int w) { return std::sqrt(w * (w + 1) / 3.0); }

void wave_speed(const Settings& s, Report& report) {
  Block bar;
  bar.ny = bar.nz = 3;
  const double dt = 1e-3, unit = bar.spacing / dt;
  Curve ours{"measured, bars of 20 w sites", {}, {}, false}, law{"sqrt(w (w+1)/3)", {}, {}, true},
      fit{"0.23 + 0.555 w", {}, {}, true};
  double lowest = 1e9, highest = 0;
  for (const int w : {1, 2, 3, 4, 5, 6, 7, 8}) {
    bar.nx = 20 * w;
    bar.material.region_half_width = w;
    bar.material.stiffness = w == 3 ? 0.25 : 1;  // once, that c goes as the root of alpha
    const double root = std::sqrt(bar.material.stiffness);
    const double c = spin_bar(s, bar, dt, lattice_speed(w) * root * unit, report).wave_speed / (unit * root);
    if (!report.error.empty()) return;
    report.relative("c / (sqrt(alpha) dx/dt), w = " + std::to_string(w), c, lattice_speed(w), 3,
                    "the law is exact for long waves; 3 % is what a user may rely on");
    const double other = 0.23 + 0.555 * w;
    lowest = std::min(lowest, other / c);
    highest = std::max(highest, other / c);
    ours.x.push_back(w);
    ours.y.push_back(c);
    law.x.push_back(w);
    law.y.push_back(lattice_speed(w));
    fit.x.push_back(w);
    fit.y.push_back(other);
  }
  report.plots.push_back({"solid_wave_speed",
                          "Longitudinal wave speed of a bar",
                          "region half-width w",
                          "c / (sqrt(alpha) dx/dt)",
                          {ours, law, fit}});
  char note[160];
  std::snprintf(
      note, sizeof note,
      "The fit 0.23 + 0.555 w is %.1f to %.1f %% lower: it counts the length from end particle to end "
      "particle, one spacing less than their mass fills.",
      100 * (1 - highest), 100 * (1 - lowest));
  report.note = note;
}

/// A modulus holds whatever the step is: alpha and the regions' width follow.
void modulus(const Settings& s, Report& report) {
  Block bar;
  bar.nx = 80;
  bar.ny = bar.nz = 3;
  const double speed = 120;  // [m/s]: w = 2 and alpha 0.72 at 1 ms, w = 8 and alpha 0.96 at 4 ms
  bar.material.density = 1000;
  bar.material.youngs_modulus = bar.material.density * speed * speed;
  bar.material.stiffness = 0.123;  // must not matter
  Plot plot{"solid_modulus",
            "Stretch of a spinning bar, one modulus at three steps",
            "time [s]",
            "stretch [mm]",
            {}};
  for (const double factor : {0.25, 1.0, 4.0}) {
    BarResult r = spin_bar(s, bar, 1e-3 * factor, speed, report);
    if (!report.error.empty()) return;
    char dt[32];
    std::snprintf(dt, sizeof dt, "dt %g ms", factor);
    report.relative(std::string("modulus from the wave speed, ") + dt,
                    bar.material.density * r.wave_speed * r.wave_speed, bar.material.youngs_modulus, 5,
                    "at w = 8 the wave is 10 half-widths long: 1 % of E");
    report.relative(std::string("modulus from the mean stretch, ") + dt, r.modulus,
                    bar.material.youngs_modulus, 5, "likewise, and a strain of 1e-3");
    r.stretch.name = dt;
    for (double& y : r.stretch.y) y *= 1e3;
    plot.curves.push_back(r.stretch);
  }
  // Starts unstretched: mean (1 - cos) of the first mode, which carries all but 1/81 of it.
  Curve exact{"first mode", {}, {}, true};
  const double length = bar.nx * bar.spacing, mean = 8e-3 / 12 * length * 1e3;
  for (const double t : plot.curves[0].x) {
    exact.x.push_back(t);
    exact.y.push_back(mean * (1 - std::cos(pi * speed / length * t)));
  }
  plot.curves.push_back(exact);
  report.plots.push_back(plot);
}

/// Share by which regions of half-width w stiffen the bending of a beam n sites high, beyond Euler-Bernoulli:
/// a region is straight, so even a single chain resists curvature. Energy of a region's misfit under constant
/// curvature: I_eff/I = 1 + (3 var(s^2)/<s^2> - 1)/n^2 over the sites s = -w..w; exactly 1 at w = 1.
double bending_excess(int w, int n) {
  const double s2 = w * (w + 1) / 3.0, s4 = w * (w + 1) * (3 * w * w + 3 * w - 1) / 15.0;
  return (3 * (s4 - s2 * s2) / s2 - 1) / (n * n);
}

/// A free beam, struck in the middle by a small body, rings in its first bending mode.
void beam(const Settings& s, Report& report) {
  const int nx = 48, high = 4, wide = 4;
  const double h = 0.02, dt = 5e-5, density = 1000, speed = 0.75 * h / dt, modulus = density * speed * speed;
  const double length = nx * h, t = high * h, ratio = t / length;
  // ASTM E1876, sec. 9: E from the frequency of a free bar, with Poisson's ratio 0.
  const double r2 = ratio * ratio, r4 = r2 * r2;
  const double correction = 1 + 6.585 * r2 - 0.868 * r4 - 8.340 * r4 / (1 + 6.338 * r2);
  const double per_f2 = 0.9465 * density * std::pow(length, 4) / (t * t) * correction;
  Plot plot{"solid_beam",
            "Free beam 48 x 4 sites, struck in the middle",
            "time [periods of the exact beam]",
            "middle against ends [spacings]",
            {}};
  for (const int w : {1, 2, 3}) {
    meltsim::WorldDesc d = world_desc(s);
    d.spacing = h;
    d.gravity = {0, 0, 0};
    d.sound_speed = sound_speed_for(d, dt);
    d.heat.model = meltsim::HeatModel::none;
    auto world = World::create(d);
    if (!world) {
      report.error = world.error().message;
      return;
    }
    MaterialDesc m;
    m.name = "beam";
    m.density = density;
    m.youngs_modulus = modulus;
    m.region_half_width = w;
    m.damping = 0.02;  // the strike's short waves
    SolidDesc body;
    body.material = *world->add_material(m);
    body.shape = Shape::box({0, 0, 0}, {length, t, wide * h});
    auto added = world->add_solid(body);
    SolidDesc hammer;
    hammer.material = body.material;
    hammer.shape = Shape::box({length / 2 - h, t, h}, {length / 2 + h, t + 2 * h, 3 * h});
    hammer.velocity = {0, -0.03 * h / dt, 0};
    if (added) added = world->add_solid(hammer);
    if (!added) {
      report.error = added.error().message;
      return;
    }
    const ParticleData first = *world->particles();
    const auto middle = slice(first, length / 2, 4 * h, t), left = slice(first, h / 2, h, t),
               right = slice(first, length - h / 2, h, t);
    const double period = 1 / std::sqrt(modulus / per_f2);
    const int steps = static_cast<int>(5 * period / dt), every = static_cast<int>(period / dt / 30);
    std::vector<double> time, y;
    for (int k = 0; k < steps; ++k) {
      if (!advance(*world, dt, report)) return;
      if (k % every != 0) continue;
      const ParticleData p = *world->particles();
      time.push_back(k * dt / period);
      y.push_back((mean_of(p, middle).y - 0.5 * (mean_of(p, left).y + mean_of(p, right).y)) / h);
    }
    if (!sound(*world, report)) return;
    const double frequency = fit_oscillation(time, y, 2 * pi).frequency / (2 * pi * period);
    const double found = per_f2 * frequency * frequency, excess = bending_excess(w, high);
    char text[96];
    std::snprintf(text, sizeof text, "modulus from bending, w = %d, against %.3g E [Pa]", w, 1 + excess);
    report.relative(text, found, modulus * (1 + excess), 5, "5 %: a beam of 12 heights");
    std::snprintf(text, sizeof text, "w = %d", w);
    plot.curves.push_back({text, time, y, false});
  }
  Curve exact{"ASTM E1876", {}, {}, true};
  for (const double at : plot.curves[0].x) {
    exact.x.push_back(at);
    exact.y.push_back(-0.21 * std::sin(2 * pi * at));
  }
  plot.curves.push_back(exact);
  report.plots.push_back(plot);
  report.note =
      "A region is straight inside, so wide regions stiffen bending beyond E I: by (3 var(s^2)/<s^2> - "
      "1)/n^2 for a "
      "beam n sites high, s = -w..w, which is 0 at w = 1, 3.2/n^2 at w = 2, 8/n^2 at w = 3 and 56/n^2 at w = "
      "8. "
      "Thin parts bend truly at w = 1 only.";
}

/// Largest deviation [m] of a coordinate from where `place` puts the particle's first position.
template <class Place>
double largest_offset(const ParticleData& now, const ParticleData& first, const Place& place) {
  double most = 0;
  for (std::size_t i = 0; i < now.id.size(); ++i) {
    const Vec3d d = now.position[i] - place(first.position[i]);
    most = std::max({most, std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
  }
  return most;
}

/// Unit in the last place of a coordinate [m].
double ulp(const Settings& s, double x) {
  if (s.precision == meltsim::Precision::double_precision) return std::nextafter(x, 2 * x + 1) - x;
  const float f = static_cast<float>(x);
  return static_cast<double>(std::nextafter(f, 2 * f + 1) - f);
}

/// Rest is a fixed point wherever the body is, and half a turn brings every particle to the opposite place.
void rigid_motion(const Settings& s, Report& report) {
  for (const double offset : {0.0, 100.0}) {
    Block block;
    block.nx = 6;
    block.ny = 4;
    block.nz = 5;
    block.corner = {offset, offset, offset};
    const double dt = 1e-3, h = block.spacing;
    const std::string at = " at " + std::to_string(static_cast<int>(offset)) + " m";
    for (const bool turning : {false, true}) {
      const int steps = turning ? 2000 : 10;
      block.spin = {0, 0, turning ? pi / (steps * dt) : 0.0};
      auto world = make_block(s, block);
      if (!world) {
        report.error = world.error().message;
        return;
      }
      const auto first = world->particles();
      for (int k = 0; k < steps; ++k)
        if (!advance(*world, dt, report)) return;
      if (!sound(*world, report)) return;
      const auto last = world->particles();
      const Vec3d center = mean_of(*first, all_of(*first));
      const double off = largest_offset(*last, *first, [&](Vec3d x) {
        return turning ? Vec3d{2 * center.x - x.x, 2 * center.y - x.y, x.z} : x;
      });
      if (turning) {
        report.absolute("largest deviation of a coordinate after half a turn" + at, off / h, 0, 0.01, "dx",
                        "the centrifugal stretch (1e-5 dx) and 2000 roundings of a coordinate");
      } else {
        const bool single = s.precision == meltsim::Precision::single_precision;
        const double target = std::max(single ? 1e-5 : 1e-11, 4 * ulp(s, offset + 1) / h);
        report.absolute("largest change of a coordinate in 10 steps at rest" + at, off / h, 0, target, "dx",
                        "1e-5 dx in float, 1e-11 dx in double, or 4 units in the last place of a coordinate");
      }
    }
  }
}

/// Momentum and spin of a body in free flight over 1e4 steps.
void momentum(const Settings& s, Report& report) {
  Block block;
  block.spacing = 0.2;
  block.nx = 4;
  block.ny = 3;
  block.nz = 6;
  block.velocity = {0.3, -0.2, 0.1};
  block.spin = {0.5, 1.0, -0.7};
  auto world = make_block(s, block);
  if (!world) {
    report.error = world.error().message;
    return;
  }
  const auto spin_of = [](const meltsim::Totals& t) {
    return t.angular_momentum - meltsim::cross(t.solid_center, t.momentum);
  };
  const meltsim::Totals before = *world->totals();
  for (int k = 0; k < 10000; ++k)
    if (!advance(*world, 1e-3, report)) return;
  if (!sound(*world, report)) return;
  const meltsim::Totals after = *world->totals();
  const bool single = s.precision == meltsim::Precision::single_precision;
  report.absolute("change of momentum over 1e4 steps, of itself",
                  meltsim::length(after.momentum - before.momentum) / meltsim::length(before.momentum), 0,
                  single ? 1e-5 : 1e-11, "-", "1e4 roundings of a velocity");
  report.absolute("change of spin over 1e4 steps, of itself",
                  meltsim::length(spin_of(after) - spin_of(before)) / meltsim::length(spin_of(before)), 0,
                  single ? 1e-4 : 1e-10, "-", "likewise, with the roundings of positions");
}

/// Long runs: rounding must not feed energy into a body, wherever it is.
void drift(const Settings& s, Report& report, int steps) {
  report.plots.push_back({"solid_drift_" + std::to_string(steps),
                          "Kinetic energy of a small spinning body",
                          "step",
                          "energy of its start",
                          {}});
  report.plots[0].curves.resize(3);
  int at = 0;
  for (const double offset : {0.0, 10.0, 100.0}) {
    Block block;
    block.spacing = 0.2;
    block.nx = block.ny = block.nz = 3;
    block.corner = {offset, offset, offset};
    block.velocity = {1e-3, 0, 0};  // within a metre over 1e6 steps, so that the offset stays what it is
    block.spin = {0.3, 0.5, -0.2};
    auto world = make_block(s, block);
    if (!world) {
      report.error = world.error().message;
      return;
    }
    const double before = world->totals()->kinetic;
    const std::string name = std::to_string(static_cast<int>(offset)) + " m";
    Curve* curve = &report.plots[0].curves[static_cast<std::size_t>(at++)];
    curve->name = "at " + name;
    double most = 0, last = 0;
    for (int k = 1; k <= steps; ++k) {
      if (!advance(*world, 1e-3, report)) return;
      if (k % (steps / 100) != 0) continue;
      last = world->totals()->kinetic / before;
      most = std::max(most, last);
      curve->x.push_back(k);
      curve->y.push_back(last);
    }
    if (!sound(*world, report)) return;
    report.absolute("largest kinetic energy at " + name + ", of its start", most, 1, 0.05, "-",
                    "no growth: 1.05 of the start");
    report.absolute("kinetic energy at the end at " + name + ", of its start", last, 1, 0.05, "-",
                    "and no loss of rigid motion");
  }
  report.note =
      "With the damping of 0.1 that is the default. Rounding of coordinates shakes a body by up to half a "
      "unit in the "
      "last place per step; without any damping that heats it, 220 times its energy after 1e5 steps at 100 m "
      "in single "
      "precision.";
}

void drift_short(const Settings& s, Report& report) { drift(s, report, 100000); }
void drift_long(const Settings& s, Report& report) { drift(s, report, 1000000); }

struct Layer {
  double density = 1000;
  int sites = 3;  ///< of its cube
};

/// Cubes on the floor of a box, one on another, for a time: at rest, in place, nothing sunk in.
void stack(const Settings& s, Report& report, const std::vector<Layer>& layers, double dt, double time,
           const std::string& label) {
  const double h = 0.2, side = 10 * h;
  meltsim::WorldDesc d = world_desc(s);
  d.spacing = h;
  d.heat.model = meltsim::HeatModel::none;
  d.sound_speed = sound_speed_for(d, dt);
  d.domain.bounded = true;
  d.domain.max = {side, 40 * h, side};
  auto world = World::create(d);
  if (!world) {
    report.error = world.error().message;
    return;
  }
  double floor = 0;
  std::vector<Vec3d> places;
  for (const Layer& layer : layers) {
    MaterialDesc m;
    m.name = "m" + std::to_string(places.size());
    m.density = layer.density;
    SolidDesc body;
    body.material = *world->add_material(m);
    const double low = (5 - layer.sites / 2) * h, width = layer.sites * h;
    body.shape = Shape::box({low, floor, low}, {low + width, floor + width, low + width});
    const auto added = world->add_solid(body);
    if (!added) {
      report.error = added.error().message;
      return;
    }
    places.push_back({low + width / 2, floor + width / 2, low + width / 2});
    floor += width;
  }
  const int steps = static_cast<int>(std::lround(time / dt));
  for (int k = 0; k < steps; ++k)
    if (!advance(*world, dt, report)) return;
  if (!sound(*world, report)) return;
  const auto pieces = *world->pieces();
  double sunk = 0, aside = 0, speed = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Vec3d off = pieces[i].center - places[pieces[i].body.index];
    const double below = i == 0 ? 0 : pieces[i - 1].center.y - places[pieces[i - 1].body.index].y;
    sunk = std::max(sunk, below - off.y);
    aside = std::max({aside, std::fabs(off.x), std::fabs(off.z)});
    speed = std::max(speed, meltsim::length(pieces[i].velocity));
  }
  report.absolute(label + ": most that one sinks into the next", sunk / h, 0, 1, "dx",
                  "no penetration beyond a spacing");
  report.absolute(label + ": most that one moves aside", aside / h, 0, 1, "dx", "it stands where it was put");
  report.absolute(label + ": fastest at the end", speed, 0, 0.01, "m/s", "at rest: a spacing in 20 s");
}

void tower(const Settings& s, Report& report) {
  stack(s, report, std::vector<Layer>(10), 1e-3, s.long_cases ? 60 : 20,
        s.long_cases ? "10 cubes of 3 sites, 60 s" : "10 cubes of 3 sites, 20 s (60 with --long)");
  report.note =
      "Contact and lattice soften as the square of the acoustic step, courant H/c. A tower of this "
      "slenderness buckles under its own weight at "
      "2 ms; "
      "one of five stands.";
}

void light_under_heavy(const Settings& s, Report& report) {
  for (const double dt : {1e-3, 2e-3}) {
    char label[64];
    std::snprintf(label, sizeof label, "200 under 10000, dt %g ms, 60 s", dt * 1e3);
    stack(s, report, {{200, 3}, {10000, 3}}, dt, 60, label);
  }
}

/// Ice in warm water without gravity and walls, so that all momentum is the particles' own. With a period the
/// space is closed in itself: water in free space flies apart before slow things happen.
struct Melting {
  World world;
  meltsim::MaterialId ice;
};

meltsim::Result<Melting> make_melting(const Settings& s, const Shape& ice_shape, const Shape& water_shape,
                                      double period) {
  meltsim::WorldDesc d = world_desc(s);
  d.spacing = 0.2;
  d.gravity = {0, 0, 0};
  d.sound_speed = 20;
  d.heat.time_scale = 2e5;
  if (period > 0) {
    d.domain.bounded = true;
    d.domain.max = {period, period, period};
    d.domain.faces.fill(meltsim::Face::periodic);
  }
  auto world = World::create(d);
  if (!world) return world.error();
  MaterialDesc water;
  const auto liquid = *world->add_material(water);
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = 3.34e5;
  ice.melts_into = liquid;
  const auto solid = *world->add_material(ice);
  SolidDesc body;
  body.name = "bar";
  body.shape = ice_shape;
  body.material = solid;
  body.temperature = -1;
  body.velocity = {0.02, 0.01, 0};
  body.angular_velocity = {0, 0.05, 0};
  const auto added = world->add_solid(body);
  if (!added) return added.error();
  meltsim::FluidDesc fluid;
  fluid.shape = water_shape;
  fluid.material = liquid;
  fluid.temperature = 80;
  const auto filled = world->add_fluid(fluid);
  if (!filled) return filled.error();
  return Melting{std::move(*world), solid};
}

/// Momentum is measured against sum m |v|, what rounding is made of.
double momentum_scale(const ParticleData& p) {
  double sum = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) sum += p.mass[i] * meltsim::length(p.velocity[i]);
  return sum;
}

void melted_through(const Settings& s, Report& report) {
  // Two cubes of 5 sites on a neck of one, whose middle lies in a lump of warm water.
  const double h = 0.2;
  const Shape bar = Shape::unite({Shape::box({0, 0, 0}, {5 * h, 5 * h, 5 * h}),
                                  Shape::box({5 * h, 2 * h, 2 * h}, {14 * h, 3 * h, 3 * h}),
                                  Shape::box({14 * h, 0, 0}, {19 * h, 5 * h, 5 * h})});
  auto made = make_melting(s, bar, Shape::box({8 * h, 0, 0}, {11 * h, 5 * h, 5 * h}), 0);
  if (!made) {
    report.error = made.error().message;
    return;
  }
  World& world = made->world;
  const meltsim::Totals before = *world.totals();
  double scale = momentum_scale(*world.particles());
  std::size_t pieces = world.pieces()->size();
  int steps = 0;
  for (; pieces < 2 && steps < 4000; steps += 10) {
    for (int k = 0; k < 10; ++k)
      if (!advance(world, 2.5e-3, report)) return;
    if (!sound(world, report)) return;
    pieces = world.pieces()->size();
    scale = std::max(scale, momentum_scale(*world.particles()));
  }
  const bool single = s.precision == meltsim::Precision::single_precision;
  report.absolute("bodies after the middle has melted", static_cast<double>(pieces), 2, 0, "-", "two halves");
  const meltsim::Totals after = *world.totals();
  report.absolute("change of momentum, of sum m|v|",
                  meltsim::length(after.momentum - before.momentum) / scale, 0, single ? 1e-6 : 1e-11, "-",
                  "melting changes a tag, no momentum; the rest is rounding");
  report.relative("mass [kg]", after.mass, before.mass, 0, "the same particles, bit for bit");
}

/// A body whose halves do not touch: each flies on its own way, on straight lines.
void halves(const Settings& s, Report& report) {
  meltsim::WorldDesc d = world_desc(s);
  d.spacing = 0.2;
  d.gravity = {0, 0, 0};
  d.heat.model = meltsim::HeatModel::none;
  auto world = World::create(d);
  if (!world) {
    report.error = world.error().message;
    return;
  }
  MaterialDesc m;
  m.name = "solid";
  m.region_half_width = 4;  // regions must not reach across the gap of one site
  SolidDesc body;
  body.material = *world->add_material(m);
  body.shape =
      Shape::unite({Shape::box({0, 0, 0}, {0.8, 0.8, 0.8}), Shape::box({1.0, 0, 0}, {1.8, 0.8, 0.8})});
  body.angular_velocity = {0, 0, 0.5};
  const auto added = world->add_solid(body);
  if (!added) {
    report.error = added.error().message;
    return;
  }
  const auto before = *world->pieces();
  for (int k = 0; k < 5000; ++k)
    if (!advance(*world, 1e-3, report)) return;
  if (!sound(*world, report)) return;
  const auto after = *world->pieces();
  report.absolute("pieces of a body in two halves", static_cast<double>(after.size()), 2, 0, "-",
                  "no contact");
  for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
    const Vec3d straight = before[i].center + before[i].velocity * 5.0;
    report.absolute("half " + std::to_string(i + 1) + ": distance from its straight line after 5 s",
                    meltsim::length(after[i].center - straight) / d.spacing, 0, 1e-3, "dx",
                    "5000 roundings of a coordinate; a pull would bend the line");
  }
}

void melt_out(const Settings& s, Report& report) {
  const double h = 0.2;
  auto made = make_melting(s, Shape::box({3 * h, 3 * h, 3 * h}, {7 * h, 7 * h, 7 * h}),
                           Shape::box({0, 0, 0}, {10 * h, 10 * h, 10 * h}), 10 * h);
  if (!made) {
    report.error = made.error().message;
    return;
  }
  World& world = made->world;
  const meltsim::Totals before = *world.totals();
  const ParticleData first = *world.particles();
  double scale = momentum_scale(first);
  meltsim::StepResult now = world.synchronize();
  for (int steps = 0; now.solid > 0 && steps < 8000; steps += 10) {
    for (int k = 0; k < 10; ++k)
      if (!advance(world, 2.5e-3, report)) return;
    if (!sound(world, report)) return;
    now = world.synchronize();
    scale = std::max(scale, momentum_scale(*world.particles()));
  }
  const meltsim::Totals after = *world.totals();
  const ParticleData last = *world.particles();
  const bool single = s.precision == meltsim::Precision::single_precision;
  report.absolute("solid particles left", static_cast<double>(after.solid), 0, 0, "-", "nothing is left");
  report.absolute("bodies left", static_cast<double>(world.pieces()->size()), 0, 0, "-", "nothing is left");
  report.absolute("particles whose mass changed a bit", first.mass == last.mass ? 0.0 : 1.0, 0, 0, "-",
                  "exact");
  report.absolute("change of momentum, of sum m|v|",
                  meltsim::length(after.momentum - before.momentum) / scale, 0, single ? 1e-5 : 1e-11, "-",
                  "rounding");
  report.absolute("change of thermal energy, of itself", std::fabs(after.thermal / before.thermal - 1), 0,
                  single ? 1e-6 : 1e-12, "-", "the ledger of a closed system");
}

}  // namespace

std::vector<Case> solid_cases() {
  return {
      {"solid.rigid_motion", "rest and half a turn, at the origin and at 100 m", "rigid motion", false,
       rigid_motion},
      {"solid.momentum", "a body in free flight, 1e4 steps", "conservation", false, momentum},
      {"solid.drift", "rounding over 1e5 steps at 0, 10 and 100 m", "conservation", false, drift_short},
      {"solid.drift_long", "rounding over 1e6 steps at 0, 10 and 100 m", "conservation", true, drift_long},
      {"solid.wave_speed", "longitudinal waves in a bar, region half-widths 1 to 8",
       "long-wave limit of lattice shape matching: c = sqrt(alpha w (w+1)/3) dx/dt", false, wave_speed},
      {"solid.modulus", "a given Young's modulus at three lengths of step",
       "c = sqrt(E/rho); centrifugal stretch rho spin^2 L^3/(12 E)", false, modulus},
      {"solid.beam", "first bending mode of a free beam",
       "ASTM E1876: modulus from the flexural resonance of a bar", false, beam},
      {"solid.tower", "a tower of ten blocks", "rest", false, tower},
      {"solid.light_under_heavy", "a block of 200 kg/m^3 under one of 10000", "rest", false,
       light_under_heavy},
      {"solid.halves", "a body of two halves that do not touch", "free flight", false, halves},
      {"solid.melted_through", "a bar melted through in the middle", "conservation", false, melted_through},
      {"solid.melt_out", "ice that melts to nothing", "conservation", false, melt_out},
  };
}

}  // namespace validation
