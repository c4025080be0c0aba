// SPDX-License-Identifier: Apache-2.0
// Liquids so viscous that the explicit limit would bind: steady flows at the step of sound, drag, what is
// conserved. WorldDesc::viscosity is automatic throughout.
#include <cmath>

#include "run.hpp"

namespace validation {
namespace {

/// The step that sound allows at a support of 2.5 spacings.
double acoustic(const WorldDesc& d) { return d.courant * 2.5 * d.spacing / d.sound_speed; }

// Steady profiles after 1.5 L^2/nu, and at least 20 steps, of the step that sound allows.
constexpr int layers = 20;
void channel(const Settings& s, Report& r, double sigma, bool driven, Plot& plot) {
  if (!r.error.empty()) return;
  constexpr double dx = 0.01, speed = 0.1, width = layers * dx;
  WorldDesc d = box(s, dx, {8, layers, 8}, Face::periodic, Face::wall, Face::periodic);
  d.sound_speed = 20 * speed;
  const double dt = acoustic(d), nu = sigma * dx * dx / dt;
  d.gravity = {driven ? 8 * nu * speed / (width * width) : 0, 0, 0};
  if (!driven) d.domain.velocity[3] = {speed, 0, 0};
  Run run(d, r);
  run.fluid(Shape::box({0, 0, 0}, d.domain.max), run.material("liquid", 1000, 1000 * nu));
  const double steps = std::max(20.0, std::ceil(1.5 * layers * layers / sigma));
  if (!run.to(steps * dt)) return;
  const ParticleData p = run.particles();
  std::vector<double> y(layers), u(layers), count(layers), exact(layers);
  double worst = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const auto b = static_cast<std::size_t>(std::clamp(p.position[i].y / dx, 0.0, layers - 1.0));
    u[b] += p.velocity[i].x;
    count[b] += 1;
  }
  for (std::size_t b = 0; b < y.size(); ++b) {
    y[b] = (static_cast<double>(b) + 0.5) / layers;
    u[b] /= count[b] * speed;
    exact[b] = driven ? 4 * y[b] * (1 - y[b]) : y[b];
    worst = std::max(worst, std::fabs(u[b] - exact[b]));
  }
  const std::string at = "nu dt/dx^2 = " + std::to_string(static_cast<int>(sigma));
  r.absolute(std::string("largest error of the profile, ") + at, 100 * worst, 0, 2, "% of the speed",
             "20 layers");
  r.absolute(std::string("sub-steps beyond those of sound, ") + at,
             static_cast<double>(run.last().steps) - steps, 0, 0, "-",
             "viscosity does not limit the sub-step");
  plot.curves.push_back({"meltsim, " + at, y, u, false});
  if (sigma > 50) plot.curves.push_back({"exact", y, exact, true});
}
void couette(const Settings& s, Report& r) {
  Plot plot{"viscous_couette", "Couette flow at the acoustic step", "y / L", "u / V", {}};
  for (const double sigma : {1.0, 10.0, 100.0}) channel(s, r, sigma, false, plot);
  r.plots.push_back(plot);
}
void poiseuille(const Settings& s, Report& r) {
  Plot plot{"viscous_poiseuille", "Poiseuille flow at the acoustic step", "y / L", "u / u_max", {}};
  for (const double sigma : {1.0, 10.0, 100.0}) channel(s, r, sigma, true, plot);
  r.plots.push_back(plot);
}

// As coupling.stokes, with a liquid a thousand times as viscous as one for which the explicit limit binds.
void stokes(const Settings& s, Report& r) {
  constexpr double dx = 0.0625;
  for (const int diameter : {6, 8}) {
    if (!r.error.empty()) return;
    const int cells = 3 * diameter;
    const double edge = cells * dx, whole = edge * edge * edge, width = diameter * dx, mu = 1000,
                 speed = 5e-4;
    const auto share_of_drag = [](double f) { return 1 - 1.7601 * std::cbrt(f) + f - 1.5593 * f * f; };
    const double f = pi / 6 * std::pow(width / edge, 3);
    WorldDesc d = box(s, dx, {cells, cells, cells}, Face::periodic, Face::periodic, Face::periodic);
    d.tension = true;  // liquid fills the domain
    d.sound_speed = 4;
    d.artificial_viscosity = 0;
    d.gravity = {0, -6 * pi * mu * 0.5 * width * speed / share_of_drag(f) / (1000 * whole), 0};
    Run run(d, r);
    const double middle = 0.5 * edge;
    run.solid("sphere", Shape::sphere({middle, middle, middle}, 0.5 * width), run.material("solid", 1000, 0),
              {}, true);
    run.fluid(Shape::box({0, 0, 0}, {edge, edge, edge}), run.material("liquid", 1000, mu),
              {0, -speed / (1 - f), 0});
    double solids = 0;
    for (const std::uint32_t tag : run.particles().tag) solids += is_solid(tag) ? 1 : 0;
    const double volume = solids * dx * dx * dx, share = volume / whole,
                 radius = std::cbrt(3 * volume / (4 * pi));
    // Momentum spreads within L^2/(4 pi^2 nu), pressure within nu/c^2 and the time that sound takes across.
    const double nu = mu / 1000, part = 4 * (edge * edge / (4 * pi * pi * nu) + nu / (4 * 4) + edge / 4);
    if (!run.to(part)) return;
    const double before = -run.totals().momentum.y;
    if (!run.to(2 * part)) return;
    const double after = -run.totals().momentum.y, through = 0.5 * (before + after) / (1000 * whole);
    const double gain = (after - before) / part / (1 - share);
    r.relative("drag over 6 pi mu R v, " + std::to_string(diameter) + " spacings to a diameter",
               (1000 * length(d.gravity) * whole - gain) / (6 * pi * mu * radius * through),
               1 / share_of_drag(share), 5, "asked for");
  }
}

// A closed box of liquid that moves at random, with a body among it.
void conserved(const Settings& s, Report& r) {
  constexpr double dx = 0.01;
  for (const double sigma : {1.0, 100.0, 2000.0}) {
    if (!r.error.empty()) return;
    WorldDesc d = box(s, dx, {8, 8, 8}, Face::periodic, Face::periodic, Face::periodic);
    d.gravity = {0, 0, 0};
    d.tension = true;
    d.sound_speed = 2;
    Run run(d, r);
    run.solid("body", Shape::box({2 * dx, 2 * dx, 2 * dx}, {6 * dx, 5 * dx, 5 * dx}),
              run.material("solid", 2000, 0), {0.01, -0.02, 0.005});
    const double dt = acoustic(d);
    run.field(
        d, {8, 8, 8}, run.material("liquid", 1000, 1000 * sigma * dx * dx / dt),
        [](double, double) { return true; },
        [](double x, double y) {
          return Vec3d{0.02 * std::sin(2 * pi * y / (8 * dx)) + 0.005, 0.01 * std::sin(4 * pi * x / (8 * dx)),
                       0.003};
        });
    const Totals before = run.totals();
    double rise = 0, energy = before.kinetic;
    for (int k = 1; k <= 40; ++k) {
      if (!run.to(k * dt)) return;
      const double now = run.totals().kinetic;
      rise = std::max(rise, (now - energy) / before.kinetic);
      energy = now;
    }
    const std::string at = ", nu dt/dx^2 = " + std::to_string(static_cast<int>(sigma));
    const double mass = before.mass * 0.02;
    r.absolute("change of momentum" + at, length(run.totals().momentum - before.momentum) / mass, 0,
               s.precision == Precision::double_precision ? 1e-13 : 1e-6, "of mass times speed",
               "rounding of the velocities, 40 sub-steps");
    r.absolute("largest rise of kinetic energy in a sub-step" + at, rise, 0, 1e-3, "of the first",
               "sound and the body's springs give back what they took");
  }
}

// A plane gravity current so viscous that inertia does not count: half of it, of area A, reaches 1.411 (g A^3/(3 nu))^(1/5)
// t^(1/5) (Huppert 1982, J. Fluid Mech. 121:43), once it is much longer than high. 24 x 20 spacings at first; the Reynolds
// number of speed and height is below 1 from 2.5 half widths on, and what it was at the start is forgotten by then.
void slump(const Settings& s, Report& r) {
  constexpr double dx = 0.01, g = 9.81, nu = 0.04, half = 12 * dx, height = 20 * dx, reach = 54 * dx;
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.artificial_viscosity = 0;
  d.sound_speed = 8;  // nothing falls freely: 3 % of the height at first
  d.domain.bounded = true;
  d.domain.min = {-reach - 6 * dx, 0, 0};
  d.domain.max = {reach + 6 * dx, height + 6 * dx, 8 * dx};
  d.domain.faces = {Face::wall, Face::wall, Face::wall, Face::open, Face::periodic, Face::periodic};
  Run run(d, r);
  run.fluid(Shape::box({-half, 0, 0}, {half, height, d.domain.max.z}),
            run.material("honey", 1000, 1000 * nu));
  const double area = half * height, scale = 1.411 * std::pow(g * area * area * area / (3 * nu), 0.2);
  const double end = std::pow(reach / scale, 5);
  double st = 0, sx = 0, stt = 0, stx = 0, n = 0, front = 0, fastest = 0;
  std::vector<double> times, fronts, exact;
  for (double t = end / 400; t < end; t *= 1.12) {
    if (!run.to(t)) return;
    front = 0;
    for (const Vec3d& x : run.particles().position) front = std::max(front, std::fabs(x.x));
    times.push_back(t);
    fronts.push_back(front / dx);
    exact.push_back(scale * std::pow(t, 0.2) / dx);
    if (front < 2.5 * half) continue;
    if (n == 0) fastest = run.last().max_speed * area / front / nu;
    const double a = std::log(t), b = std::log(front);
    st += a, sx += b, stt += a * a, stx += a * b, n += 1;
  }
  r.absolute("exponent of the front", (n * stx - st * sx) / (n * stt - st * st), 0.2, 0.02, "-",
             "from 2.5 half widths on, a fit to its logarithm");
  r.relative("front at the end", front, scale * std::pow(times.back(), 0.2), 10, "outermost particle");
  r.absolute("Reynolds number where the fit begins", fastest, 0, 1, "-", "largest speed, mean height");
  r.plots.push_back({"viscous_slump",
                     "A plane viscous gravity current",
                     "t [s]",
                     "front / dx",
                     {{"meltsim", times, fronts, false}, {"Huppert", times, exact, true}}});
}

}  // namespace

std::vector<Case> viscous_cases() {
  return {
      {"viscous.couette", "a lid drags a very viscous liquid, at the step of sound", "exact solution", false,
       couette},
      {"viscous.poiseuille", "a very viscous liquid driven through a channel, at the step of sound",
       "exact solution", false, poiseuille},
      {"viscous.stokes", "a very viscous liquid through a cubic array of spheres", "Hasimoto (1959)", false,
       stokes},
      {"viscous.slump", "a column of very viscous liquid slumps", "Huppert (1982), J. Fluid Mech. 121:43",
       true, slump},
      {"viscous.conserved", "momentum and energy at any number of stages", "conservation", false, conserved},
  };
}

}  // namespace validation
