// SPDX-License-Identifier: Apache-2.0
// Solids: lattice shape matching against bars and beams, rigid motion, contact, bodies that come apart.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "validation.hpp"

namespace validation {

namespace {

using meltsim::MaterialDesc;
using meltsim::ParticleData;
using meltsim::Shape;
using meltsim::SolidDesc;
using meltsim::Vec3d;
using meltsim::World;

constexpr double pi = 3.14159265358979323846;

/// A World without gravity and heat that holds one box of lattice points.
struct Block {
  double spacing = 0.1;
  int nx = 1, ny = 1, nz = 1;  ///< lattice points per axis
  Vec3d corner;
  MaterialDesc material;
  Vec3d velocity, spin;
};

meltsim::Result<World> make_block(const Settings& s, const Block& b) {
  meltsim::WorldDesc d = world_desc(s);
  d.spacing = b.spacing;
  d.gravity = {0, 0, 0};
  d.heat.model = meltsim::HeatModel::none;
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

/// Angular frequency of samples that oscillate about a constant: least squares of a + b cos + c sin over the
/// frequencies around `guess`, refined by golden section. Good to about 1e-3 of itself over five periods.
double fit_frequency(const std::vector<double>& t, const std::vector<double>& y, double guess) {
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
  return 0.5 * (low + high);
}

/// Ids of the particles whose x is `extreme` in the first state.
std::vector<std::size_t> slice(const ParticleData& p, double x, double spacing) {
  std::vector<std::size_t> ids;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (std::fabs(p.position[i].x - x) < 0.25 * spacing) ids.push_back(i);
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

/// The stretch of a slender free bar that was set spinning about z: it oscillates about the centrifugal
/// stretch with the period 2 L/c of the first longitudinal mode. Returns c [m/s], or 0 with an error.
double bar_wave_speed(const Settings& s, Block bar, double dt, double expected, Curve* curve,
                      Report& report) {
  const double length = bar.nx * bar.spacing;
  // A strain of 1e-3 at most: far above float's rounding, and 1 % away from nothing linear.
  bar.spin = {0, 0, expected / length * std::sqrt(8e-3)};
  bar.material.damping = 0;
  auto world = make_block(s, bar);
  if (!world) {
    report.error = world.error().message;
    return 0;
  }
  const auto first = world->particles();
  if (!first) {
    report.error = first.error().message;
    return 0;
  }
  const double h = bar.spacing;
  const auto left = slice(*first, bar.corner.x + 0.5 * h, h),
             right = slice(*first, bar.corner.x + length - 0.5 * h, h);
  const double period = 2 * length / expected;
  const int steps = static_cast<int>(std::ceil(5 * period / dt));
  const int every = std::max(1, static_cast<int>(period / dt / 24));
  std::vector<double> t, y;
  for (int k = 0; k <= steps; ++k) {
    if (k % every == 0) {
      const auto p = world->particles();
      if (!p) {
        report.error = p.error().message;
        return 0;
      }
      t.push_back(k * dt);
      y.push_back(meltsim::length(mean_of(*p, right) - mean_of(*p, left)));
    }
    if (!advance(*world, dt, report)) return 0;
  }
  if (!sound(*world, report)) return 0;
  if (curve != nullptr) {
    curve->x = t;
    curve->y = y;
  }
  return fit_frequency(t, y, 2 * pi / period) * length / pi;
}

void wave_speed(const Settings& s, Report& report) {
  Block bar;
  bar.spacing = 0.1;
  bar.ny = bar.nz = 3;
  Curve ours{"ours", {}, {}, false}, law{"sqrt(w (w+1)/3)", {}, {}, true},
      fitted{"0.23 + 0.555 w", {}, {}, true};
  for (const int w : {1, 2, 3, 4, 6, 8}) {
    bar.nx = 20 * w;  // long against the region
    bar.material.region_half_width = w;
    const double dt = 1e-3, unit = bar.spacing / dt, expected = std::sqrt(w * (w + 1) / 3.0);
    const double c = bar_wave_speed(s, bar, dt, expected * unit, nullptr, report) / unit;
    if (!report.error.empty()) return;
    report.relative("c / (dx/dt) at w = " + std::to_string(w), c, expected, 3, "law");
  }
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
      const int steps = turning ? 2000 : 100;
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
        report.absolute("largest change of a coordinate in 100 steps at rest" + at, off / h, 0, target, "dx",
                        "1e-5 dx in float, 1e-11 dx in double, or 4 units in the last place of a coordinate");
      }
    }
  }
}

}  // namespace

std::vector<Case> solid_cases() {
  return {
      {"solid.rigid_motion", "rest and half a turn, at the origin and at 100 m", "rigid motion", false,
       rigid_motion},
      {"solid.wave_speed", "longitudinal waves in a bar, region half-widths 1 to 8",
       "long-wave limit of lattice shape matching: c = sqrt(alpha w (w+1)/3) dx/dt", false, wave_speed},
  };
}

}  // namespace validation
