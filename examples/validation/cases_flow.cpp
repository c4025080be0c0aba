// SPDX-License-Identifier: Apache-2.0
// Liquids whose viscosity depends on the shear rate (physics/flow_curve.hpp): channels with exact profiles, a heap that comes
// to rest. WorldDesc::viscosity is automatic throughout.
#include <cmath>

#include "run.hpp"

namespace validation {
namespace {

// Driven along x between plates 2 h apart: tau = f y from the middle on, so within y0 = tau_y/f nothing is sheared, and
// outside u = n/(n+1) (f/K)^(1/n) ((h-y0)^(1+1/n) - (y-y0)^(1+1/n)). f is such that the middle moves at `speed`.
struct Flow {
  double index, plug;  ///< n; y0/h
  int layers;
  double sigma;  ///< nu dt/dx^2 at the mean shear rate and the acoustic step
  double spans;  ///< of h^2/nu
};
struct Found {
  double error = 0, middle = 0, plug = 0;  ///< of the speed; of the speed; of h
};
constexpr double regularisation = 100;

Found channel(const Settings& s, Report& r, const Flow& flow, Plot& plot) {
  Found found;
  if (!r.error.empty()) return found;
  constexpr double speed = 0.1, h = 0.2;
  const double dx = 2 * h / flow.layers, n = flow.index;
  WorldDesc d = box(s, dx, {8, flow.layers, 8}, Face::periodic, Face::wall, Face::periodic);
  d.sound_speed = 20 * speed;
  const double dt = d.courant * 2.5 * dx / d.sound_speed, nu = flow.sigma * dx * dx / dt;
  MaterialDesc m;
  m.name = "paste";
  m.viscosity = 1000 * nu / std::pow(speed / h, n - 1);
  const double f = m.viscosity * std::pow(speed * (n + 1) / n / std::pow((1 - flow.plug) * h, 1 + 1 / n), n);
  m.flow_index = n;
  m.yield_stress = flow.plug * h * f;
  m.regularisation = regularisation;
  d.gravity = {f / 1000, 0, 0};
  Run run(d, r);
  run.fluid(Shape::box({0, 0, 0}, d.domain.max), run.material(m));
  if (!run.to(flow.spans * h * h / nu)) return found;
  const ParticleData p = run.particles();
  const auto count = static_cast<std::size_t>(flow.layers);
  std::vector<double> y(count), u(count), of(count), exact(count);
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const auto b = static_cast<std::size_t>(std::clamp(p.position[i].y / dx, 0.0, flow.layers - 1.0));
    u[b] += p.velocity[i].x / speed;
    of[b] += 1;
  }
  for (std::size_t b = 0; b < count; ++b) {
    y[b] = (static_cast<double>(b) + 0.5) * dx / h - 1;
    u[b] /= of[b];
    const double a = std::fabs(y[b]);
    exact[b] = a < flow.plug ? 1 : 1 - std::pow((a - flow.plug) / (1 - flow.plug), 1 + 1 / n);
    found.error = std::max(found.error, std::fabs(u[b] - exact[b]));
    found.middle = std::max(found.middle, u[b]);
  }
  // Where the line through (u_plug - u)^(n/(n+1)) over y is 0, from a tenth to nine tenths of the speed.
  double sy = 0, sq = 0, syy = 0, syq = 0, k = 0;
  for (std::size_t b = 0; b < count; ++b) {
    const double lag = 1 - u[b] / found.middle, a = std::fabs(y[b]), q = std::pow(lag, n / (n + 1));
    if (lag < 0.1 || lag > 0.9) continue;
    sy += a, sq += q, syy += a * a, syq += a * q, k += 1;
  }
  const double slope = (k * syq - sy * sq) / (k * syy - sy * sy);
  found.plug = (slope * sy - sq) / (k * slope);
  const std::string at =
      flow.plug > 0 ? std::to_string(flow.layers) + " layers" : "n = " + std::to_string(n).substr(0, 3);
  plot.curves.push_back({"meltsim, " + at, y, u, false});
  if (flow.plug == 0 || flow.layers == 80) plot.curves.push_back({"exact, " + at, y, exact, true});
  return found;
}

void power_law(const Settings& s, Report& r) {
  Plot plot{"flow_power_law", "Power-law liquids in a channel", "y / h", "u / u_max", {}};
  for (const double n : {0.5, 1.5}) {
    const Found found = channel(s, r, {n, 0, 20, 10, 6}, plot);
    r.absolute("largest error of the profile, n = " + std::to_string(n).substr(0, 3), 100 * found.error, 0, 3,
               "% of the speed", "20 layers, nu dt/dx^2 = 10");
  }
  r.plots.push_back(plot);
}

void bingham(const Settings& s, Report& r) {
  Plot plot{"flow_bingham", "A Bingham liquid in a channel", "y / h", "u / u_plug", {}};
  for (const int layers : s.long_cases ? std::vector<int>{20, 40, 80} : std::vector<int>{20, 40}) {
    const Found found = channel(s, r, {1, 0.5, layers, 2, 2}, plot);
    const std::string at = ", " + std::to_string(layers) + " layers";
    r.relative("velocity of the plug" + at, found.middle, 1, 3,
               "of the exact one; creep below the yield stress adds 1 %");
    r.relative("width of the plug" + at, found.plug, 0.5, 3, "of the channel's");
  }
  r.note =
      "The kernel smears the shear rate across the edge of the plug, which moves it by a third of a spacing "
      "towards the middle "
      "whatever the spacing is: errors halve with the spacing.";
  r.plots.push_back(plot);
}

// Thin heaps at rest: the floor bears tau_y everywhere, rho g h dh/dx = -tau_y (Liu & Mei 1989, J. Fluid Mech. 207:505), so
// h^2 = 2 tau_y/(rho g) (x_f - x) and, of a given half area A, x_f^3 = 9 A^2 rho g/(8 tau_y).
void heap(const Settings& s, Report& r) {
  constexpr double g = 9.81, front = 0.6, middle = 0.15, area = 2.0 / 3 * front * middle, dx = 0.015;
  constexpr double yield = 1000 * g * middle * middle / (2 * front);
  WorldDesc d = world_desc(s);
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.min = {-0.9, 0, 0};
  d.domain.max = {0.9, 0.45, 8 * dx};
  d.domain.faces = {Face::wall, Face::wall, Face::wall, Face::wall, Face::periodic, Face::periodic};
  d.sound_speed = 10;  // nothing falls freely: 3 % of the height at first
  d.isotropic_pressure = true;
  MaterialDesc m;
  m.name = "mud";
  m.viscosity = 20;
  m.yield_stress = yield;
  m.regularisation = 30;
  Run run(d, r);
  const double half = 0.21, height = area / half;
  run.fluid(Shape::box({-half, 0, 0}, {half, height, d.domain.max.z}), run.material(m));
  // Of columns two spacings wide: half of their heights from the liquid in them. h^2 over x, a line from a sixth to five
  // sixths of the length.
  struct Outline {
    double front = 0, top = 0, steepness = 0;
  };
  const auto outline = [&] {
    constexpr double wide = 2 * dx;
    std::vector<double> h(30);
    const ParticleData p = run.particles();
    for (const Vec3d& x : p.position) {
      const auto b = static_cast<std::size_t>(std::fabs(x.x) / wide);
      if (b < h.size()) h[b] += dx * dx * dx / (2 * wide * 8 * dx);
    }
    double sx = 0, sh = 0, sxx = 0, sxh = 0, n = 0;
    for (std::size_t b = 0; b < h.size(); ++b) {
      const double x = (static_cast<double>(b) + 0.5) * wide, h2 = h[b] * h[b];
      if (x < front / 6 || x > front * 5 / 6) continue;
      sx += x, sh += h2, sxx += x * x, sxh += x * h2, n += 1;
    }
    const double slope = (n * sxh - sx * sh) / (n * sxx - sx * sx);
    return Outline{sx / n - sh / (n * slope), std::sqrt(std::max(0.0, sh / n - slope * sx / n)), -slope};
  };
  if (!run.to(2)) return;
  const Outline before = outline();
  if (!run.to(3)) return;
  const Outline now = outline();
  r.relative("half-length of the heap", now.front, front, 10,
             "where h^2 falls to 0; from a column of 0.21 x 0.29 m");
  r.relative("height in the middle", now.top, middle, 10, "of the same line");
  r.relative("yield stress that it shows", now.steepness / (2 * yield / (1000 * g)), 1, 10, "slope of h^2");
  r.absolute("what the front still gains", 100 * (now.front - before.front) / front, 0, 2,
             "% of the length per second", "what does not yield creeps at less than 1/m = 0.033/s");
  r.note =
      "isotropic_pressure on. The heap stops, steeper than its yield stress of 184 Pa makes it: as if that "
      "were "
      "25 Pa more, 46 without the option. Liquid at rest is a lattice that resists in proportion to its "
      "pressure.";
}

}  // namespace

std::vector<Case> flow_cases() {
  return {
      {"flow.power_law", "liquids that thin and thicken, driven through a channel", "exact solution", false,
       power_law},
      {"flow.bingham", "a liquid with a yield stress, driven through a channel", "exact solution", false,
       bingham},
      {"flow.heap", "a column with a yield stress slumps and stops",
       "Liu & Mei (1989), J. Fluid Mech. 207:505", true, heap},
  };
}

}  // namespace validation
