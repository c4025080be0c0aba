// SPDX-License-Identifier: Apache-2.0
// Surface tension: pressure, period and shape of drops, angles and puddles on walls and bodies, drops that merge, hang and fall, a bubble.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "drops.hpp"
#include "run.hpp"

namespace validation {
namespace {

constexpr double dx = 1e-3, sigma = 0.072, rho = 1000;

/// The time of a drop [s].
double time_of(double radius) { return std::sqrt(rho * radius * radius * radius / sigma); }
/// Viscosity of an Ohnesorge number [Pa s].
double viscosity_of(double ohnesorge, double radius) { return ohnesorge * std::sqrt(rho * sigma * radius); }

MaterialDesc liquid(double viscosity, double tension = sigma) {
  MaterialDesc m;
  m.name = "liquid";
  m.density = rho;
  m.viscosity = viscosity;
  m.surface_tension = tension;
  return m;
}
MaterialDesc plate(double angle) {
  MaterialDesc m;
  m.name = "plate";
  m.contact_angle = angle;
  return m;
}
WorldDesc space(const Settings& s, double gravity = 0) {
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.gravity = {0, -gravity, 0};
  return d;
}

struct Drop {
  Vec3d centre, drift;
  double count = 0, radius = 0;  ///< radius of a ball of its volume [m]
};
Drop drop_of(const ParticleData& p) {
  Drop d;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (is_fluid(p.tag[i])) d.centre += p.position[i], d.drift += p.velocity[i], ++d.count;
  d.centre = d.centre * (1 / d.count);
  d.drift = d.drift * (1 / d.count);
  d.radius = std::cbrt(3 * d.count / (4 * pi)) * dx;
  return d;
}

/// Deviation of the radius at which half of space is filled from its mean, rms over 200 directions [% of the mean].
double asphericity(const ParticleData& p, const Drop& d) {
  const double reach = 2.5 * dx;
  const int directions = 200;
  double sum = 0, squares = 0;
  for (int k = 0; k < directions; ++k) {
    const double z = 1 - (2 * k + 1.0) / directions, a = 2.399963 * k, s = std::sqrt(1 - z * z);
    const Vec3d along{s * std::cos(a), s * std::sin(a), z};
    double low = 0, high = 2 * d.radius;
    for (int turn = 0; turn < 20; ++turn) {
      const double r = 0.5 * (low + high);
      double filled = 0;
      for (const Vec3d& x : p.position) {
        const double q = 1 - length(x - d.centre - along * r) / reach;
        if (q > 0) filled += q * q * q * q * (5 - 4 * q);
      }
      (filled * 21 / (2 * pi * 15.625) > 0.5 ? low : high) = r;
    }
    sum += low;
    squares += low * low;
  }
  const double mean = sum / directions;
  return 100 * std::sqrt(std::max(0.0, squares / directions - mean * mean)) / mean;
}

// Readings of pressure contain that of cohesion, the same in every drop of a liquid.
void pressure(const Settings& s, Report& r) {
  double sum[2] = {}, laplace[2] = {};
  const double radii[2] = {10, 20};
  for (int k = 0; k < 2; ++k) {
    Run run(space(s), r);
    run.fluid(Shape::sphere({}, radii[k] * dx), run.material(liquid(viscosity_of(0.06, radii[k] * dx))));
    if (!run.to(2 * time_of(radii[k] * dx))) return;
    const ParticleData p = run.particles();
    const Drop d = drop_of(p);
    double count = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (length(p.position[i] - d.centre) < 0.6 * d.radius) sum[k] += p.pressure[i], ++count;
    sum[k] /= count;
    laplace[k] = 2 * sigma / d.radius;
    const std::string at = ", R = " + std::to_string(static_cast<int>(radii[k])) + " dx";
    r.relative("pressure as it is read, over 2 sigma/R" + at, sum[k] / laplace[k], 1, 10, "asked for");
    double fastest = 0;
    for (const Vec3d& v : p.velocity) fastest = std::max(fastest, length(v - d.drift));
    r.absolute("fastest particle" + at, fastest * time_of(d.radius) / d.radius, 0, 0.05,
               "of sqrt(sigma/(rho R))", "asked for");
  }
  r.relative("difference of the two pressures over that of 2 sigma/R",
             (sum[0] - sum[1]) / (laplace[0] - laplace[1]), 1, 10, "asked for");
}

void oscillation(const Settings& s, Report& r) {
  for (const double radius : {7.0, 10.0}) {
    if (!r.error.empty()) return;
    Run run(space(s), r);
    const double half = 0.4 * radius * dx;
    run.fluid(Shape::capsule({0, 0, -half}, {0, 0, half}, radius * dx),
              run.material(liquid(viscosity_of(0.015, radius * dx))));
    if (!run.good()) return;
    const Drop ball = drop_of(run.particles());
    const double period = 2 * pi * time_of(ball.radius) / std::sqrt(8.0);
    std::vector<double> zero;
    double last = 0;
    for (int n = 1; n <= 70; ++n) {
      if (!run.to(n * period / 40)) return;
      const ParticleData p = run.particles();
      const Drop d = drop_of(p);
      double stretch = 0;
      for (const Vec3d& x : p.position) {
        const Vec3d q = x - d.centre;
        stretch += q.z * q.z - 0.5 * (q.x * q.x + q.y * q.y);
      }
      if (last * stretch < 0) zero.push_back((n - stretch / (stretch - last)) / 40);
      last = stretch;
    }
    if (zero.size() < 3) r.error = "the drop does not swing";
    else
      r.relative("period over Rayleigh's, " + std::to_string(static_cast<int>(ball.radius / dx + 0.5)) +
                     " spacings to a radius",
                 zero[2] - zero[0], 1, 10, "asked for");
  }
}

void cube(const Settings& s, Report& r) {
  Run run(space(s), r);
  run.fluid(Shape::box({}, {16 * dx, 16 * dx, 16 * dx}), run.material(liquid(viscosity_of(0.1, 10 * dx))));
  if (!run.to(6 * time_of(10 * dx))) return;
  const ParticleData p = run.particles();
  const Drop d = drop_of(p);
  r.absolute("deviation of the radius, rms", asphericity(p, d), 0, 3, "%", "asked for");
  double fastest = 0;
  for (const Vec3d& v : p.velocity) fastest = std::max(fastest, length(v - d.drift));
  r.absolute("fastest particle", fastest * time_of(d.radius) / d.radius, 0, 0.05, "of sqrt(sigma/(rho R))",
             "asked for");
}

/// Height of the centre of mass above what liquid stands on [m], and its volume [m^3].
std::array<double, 2> standing(const Settings& s, Report& r, const Shape& shape, bool on_body, double angle,
                               double gravity, double tension, double ohnesorge, double time) {
  WorldDesc d = box(s, dx, {52, 26, 52}, Face::wall, Face::wall, Face::wall);
  d.domain.min.y = -3 * dx;
  if (!on_body) d.domain.min.y = 0;
  d.domain.contact_angle = on_body ? 90 : angle;
  d.domain.no_slip = false;
  d.gravity = {0, -gravity, 0};
  Run run(d, r);
  if (on_body)
    run.solid("plate", Shape::box({0, -3 * dx, 0}, {52 * dx, 0, 52 * dx}), run.material(plate(angle)), {},
              true);
  run.fluid(shape, run.material(liquid(ohnesorge * std::sqrt(rho * tension * 10 * dx), tension)));
  if (!run.to(time)) return {};
  const Drop drop = drop_of(run.particles());
  return {drop.centre.y, drop.count * dx * dx * dx};
}

void angles(const Settings& s, Report& r) {
  const Shape half = Shape::intersect({Shape::box({16 * dx, 0, 16 * dx}, {36 * dx, 20 * dx, 36 * dx}),
                                       Shape::sphere({26 * dx, 0, 26 * dx}, 10 * dx)});
  for (const bool on_body : {false, true})
    for (const double angle : {60.0, 90.0, 120.0}) {
      const auto at = standing(s, r, half, on_body, angle, 0, sigma, 0.1, 5 * time_of(10 * dx));
      if (!r.error.empty()) return;
      r.absolute(std::string(on_body ? "angle on a body of " : "angle on a wall of ") +
                     std::to_string(static_cast<int>(angle)) + " degrees",
                 cap_angle(at[1], at[0]), angle, 6, "degrees", "asked for");
    }
}

void puddles(const Settings& s, Report& r) {
  const auto cylinder = [](double radius, double height) {
    return Shape::cylinder({26 * dx, 0, 26 * dx}, {26 * dx, height * dx, 26 * dx}, radius * dx);
  };
  const double tension = 0.2, capillary = std::sqrt(tension / (rho * 9.81));
  const auto look = [&](const char* what, bool on_body, double angle, double radius, double height) {
    if (!r.error.empty()) return;
    const auto at = standing(s, r, cylinder(radius, height), on_body, angle, 9.81, tension, 0.35, 0.5);
    if (r.error.empty())
      r.relative(what, at[0] / dx, sessile(dx, at[1], capillary, angle) / dx, 10, "asked for");
  };
  look("centre of a puddle that spreads [dx], 90 degrees, wall", false, 90, 12, 6);
  look("one that draws together, 90 degrees, wall", false, 90, 17, 3);
  look("60 degrees, wall", false, 60, 12, 6);
  look("120 degrees, wall", false, 120, 12, 6);
  look("60 degrees, body", true, 60, 12, 6);
  look("90 degrees, body", true, 90, 12, 6);
}

void merging(const Settings& s, Report& r) {
  Run run(space(s), r);
  const MaterialId m = run.material(liquid(viscosity_of(0.1, 6 * dx)));
  const double speed = 0.5 * 6 * dx / time_of(6 * dx);
  run.fluid(Shape::sphere({-6.5 * dx, -2 * dx, 0}, 6 * dx), m, {speed, 0.2 * speed, 0});
  run.fluid(Shape::sphere({6.5 * dx, 2 * dx, 0}, 6 * dx), m, {-speed, 0.2 * speed, 0});
  if (!run.good()) return;
  const Totals before = run.totals();
  if (!run.to(12 * time_of(7.5 * dx))) return;
  const Totals after = run.totals();
  r.absolute("change of momentum", length(after.momentum - before.momentum) / (before.mass * speed), 0,
             s.precision == Precision::double_precision ? 1e-12 : 1e-6, "of mass times speed",
             "asked for; in double precision rounding");
  const ParticleData p = run.particles();
  r.absolute("deviation of the radius, rms", asphericity(p, drop_of(p)), 0, 3, "%", "asked for");
}

// Tate's law: a foot of diameter D holds pi D sigma, of which a drop that falls takes some 0.6 to 0.7 with it (Harkins & Brown 1919).
void pendant(const Settings& s, Report& r) {
  constexpr double foot = 10;  // spacings
  const auto centre = [&](double gravity) {
    Run run(space(s, gravity), r);
    run.solid("plate",
              Shape::box({-foot / 2 * dx, 0, -foot / 2 * dx}, {foot / 2 * dx, 3 * dx, foot / 2 * dx}),
              run.material(plate(30)), {}, true);
    run.fluid(Shape::intersect(
                  {Shape::box({-9 * dx, -9 * dx, -9 * dx}, {9 * dx, 0, 9 * dx}), Shape::sphere({}, 5 * dx)}),
              run.material(liquid(viscosity_of(0.1, 5 * dx))));
    if (!run.to(0.25)) return 0.0;
    return drop_of(run.particles()).centre.y / dx;
  };
  // The weight of 262 mm^3 equals pi D sigma at 8.6 m/s^2.
  const double hangs = centre(4.3), falls = centre(12.9);
  r.absolute("centre of a drop of half the weight that its foot holds", hangs, -3.5, 3.5, "dx",
             "it hangs: half a ball's is at -1.9");
  // Free fall is 403 spacings.
  r.absolute("centre of one of 1.5 times that weight", falls, -403, 360, "dx", "most of it has fallen");
}

/// A bubble of light liquid rises through a heavy one between walls, in a slab: the first test of Hysing et al. (2009), on which their
/// three programs agree to 0.2 %. Its floor and ceiling, half its width from the bubble and more, are without friction here.
void bubble(const Settings& s, Report& r) {
  constexpr int width = 40;  // spacings; the bubble is half as wide
  const double h = 1.0 / width, depth = 8 * h, every = 0.25;
  WorldDesc d = world_desc(s);
  d.spacing = h;
  d.gravity = {0, -0.98, 0};
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.max = {1, 2, depth};
  d.domain.faces[4] = d.domain.faces[5] = Face::periodic;
  d.domain.no_slip = false;
  Run run(d, r);
  MaterialDesc heavy = liquid(10, 24.5), light = liquid(1, 0);
  light.name = "light";
  light.density = 100;
  const MaterialId bubble = run.material(light);
  const Shape round = Shape::cylinder({0.5, 0.5, 0}, {0.5, 0.5, depth}, 0.25);
  run.fluid(round, bubble);
  run.fluid(Shape::subtract(Shape::box({}, {1, 2, depth}), round), run.material(heavy));
  const auto height = [&] {
    const ParticleData p = run.particles();
    double sum = 0, n = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (material_of(p.tag[i]) == bubble.index) sum += p.position[i].y, ++n;
    return sum / n;
  };
  double at = 0.5, fastest = 0;
  for (int k = 1; k <= 12; ++k) {
    if (!run.to(k * every)) return;
    const double before = at;
    at = height();
    fastest = std::max(fastest, (at - before) / every);
  }
  // Its edge is known to half a spacing, 5 % of its radius, and its speed grows with the radius at most.
  r.relative("largest speed of its centre", fastest, 0.2417, 5, "half a spacing of its radius");
  r.relative("way of its centre in 3 s", at - 0.5, 0.581, 5, "half a spacing of its radius");
}

}  // namespace

std::vector<Case> tension_cases() {
  return {
      {"tension.pressure", "pressure in drops at rest", "Laplace (1806)", true, pressure},
      {"tension.oscillation", "drops that swing", "Rayleigh (1879)", false, oscillation},
      {"tension.cube", "a cube becomes a ball", "4/3 pi R^3", false, cube},
      {"tension.angles", "drops on walls and bodies that they wet more or less", "Young (1805)", true,
       angles},
      {"tension.puddles", "puddles on walls and bodies, from above and from below",
       "Bashforth & Adams (1883)", true, puddles},
      {"tension.merging", "two drops meet off centre", "conservation", false, merging},
      {"tension.pendant", "a drop hangs from a plate, or falls", "Tate (1864)", false, pendant},
      {"tension.bubble", "a bubble of light liquid rises", "Hysing et al. (2009)", true, bubble},
  };
}

}  // namespace validation
