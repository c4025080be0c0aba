// SPDX-License-Identifier: Apache-2.0
// The liquid alone: hydrostatics, waves, the dam break, viscous flow, a free drop.
#include <algorithm>
#include <cmath>
#include <random>

#include "run.hpp"

namespace validation {
namespace {

using namespace meltsim;

constexpr double g = 9.81;

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto it = std::upper_bound(x.begin(), x.end(), at);
  if (it == x.begin()) return y.front();
  if (it == x.end()) return y.back();
  const auto i = static_cast<std::size_t>(it - x.begin());
  return y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]);
}

// 10 x 16 x 10 spacings of water, default settings. Pressure per layer is the mean over the particles of that
// layer and over the last four seconds: a tank that starts without pressure rings at c/4h, and the liquid
// damps that slowly, at 16 layers by e in 10 to 12 s (rms speed 0.0094 to 0.0104 of sqrt(g h) after 8 s, 0.0042 to
// 0.0054 after 16); 8 layers are at 0.004 after 8 s.
constexpr double tank_spacing = 0.0625;
constexpr int tank_side = 10;

/// What a tank at rest reads: means over its layers and over time.
struct Rest {
  std::vector<double> y, pressure, exact;
  double level = 0, speed = 0;
  /// L2 over all layers but the upper ones, of that of rho g h [%].
  double error(std::size_t but_upper) const {
    double e = 0, all = 0;
    for (std::size_t b = 0; b + but_upper < y.size(); ++b) {
      e += (pressure[b] - exact[b]) * (pressure[b] - exact[b]);
      all += exact[b] * exact[b];
    }
    return 100 * std::sqrt(e / all);
  }
};

enum class Start { still, sloshing };

/// seed: 0, or particles start with up to 1e-4 m/s each, at random.
Rest rest_of(const Settings& s, Report& r, int layers, Start start, unsigned seed) {
  constexpr double dx = tank_spacing;
  constexpr int side = tank_side;
  const bool slosh = start == Start::sloshing;
  const WorldDesc d =
      box(s, dx, {side, (slosh ? 2 : 1) * layers + 8, side}, Face::wall, Face::wall, Face::wall);
  const double depth = layers * dx, width = side * dx, until = slosh ? 12 : layers,
               from = until - (slosh ? 2 : 4);
  Run run(d, r);
  const MaterialId water = run.material("water", 1000, 1e-3);
  if (slosh) {
    run.fluid(Shape::box({0, 0, 0}, {width / 2, 2 * depth, width}), water);
  } else if (seed == 0) {
    run.fluid(Shape::box({0, 0, 0}, {width, depth, width}), water);
  } else {
    std::mt19937 random(seed);
    const auto up_to = [&](double speed) {
      return speed * (2 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 1);
    };
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < layers; ++j)
        for (int k = 0; k < side; ++k) {
          const Vec3d low{i * dx, j * dx, k * dx}, v{up_to(1e-4), up_to(1e-4), up_to(1e-4)};
          run.fluid(Shape::box(low, low + Vec3d{dx, dx, dx}), water, v);
        }
  }
  const auto bins = static_cast<std::size_t>(layers);
  std::vector<double> pressure(bins), height(bins), count(bins);
  Rest rest;
  int samples = 0;
  for (double t = from; run.to(t, 0.02) && t < until; t += 0.02) {
    const ParticleData p = run.particles();
    double centre = 0, square = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      centre += p.position[i].y;
      square += dot(p.velocity[i], p.velocity[i]);
      const auto b = static_cast<std::size_t>(std::max(0.0, p.position[i].y / dx));
      if (b >= bins) continue;
      pressure[b] += p.pressure[i];
      height[b] += p.position[i].y;
      count[b] += 1;
    }
    rest.level += 2 * centre / static_cast<double>(p.id.size());
    rest.speed += std::sqrt(square / static_cast<double>(p.id.size()));
    ++samples;
  }
  if (!run.good()) return rest;
  rest.level /= samples;
  rest.speed /= samples;
  for (std::size_t b = 0; b < bins; ++b) {
    if (count[b] == 0) continue;
    rest.y.push_back(height[b] / count[b]);
    rest.pressure.push_back(pressure[b] / count[b]);
    rest.exact.push_back(1000 * g * (rest.level - rest.y.back()));
  }
  return rest;
}

void level_and_speed(Report& r, const Rest& rest, int layers, const char* at_rest) {
  const double depth = layers * tank_spacing;
  r.relative("level of the surface (twice the centre of mass)", rest.level, depth, 1,
             "0.25 % is compression at the chosen sound speed, 0.4 % the lattice's disorder");
  r.absolute("rms speed over sqrt(g h)", rest.speed / std::sqrt(g * depth), 0, 1e-2, "-", at_rest);
}

void plot_rest(Report& r, const Rest& rest, const std::string& name) {
  r.plots.push_back(
      {name,
       "Pressure in a tank at rest",
       "y [m]",
       "p [Pa]",
       {{"meltsim", rest.y, rest.pressure, false}, {"rho g (h - y)", rest.y, rest.exact, true}}});
}

void tank(const Settings& s, Report& r, Start start) {
  constexpr int layers = 16;
  const Rest rest = rest_of(s, r, layers, start, 0);
  if (!r.error.empty()) return;
  plot_rest(r, rest, start == Start::sloshing ? "liquid_sloshed" : "liquid_hydrostatic");
  r.absolute("pressure, L2 over layers", rest.error(0), 0, 3, "%",
             "16 layers: the free surface alone, whose layer carries no pressure, makes 1 %");
  level_and_speed(r, rest, layers,
                  start == Start::sloshing ? "at rest, apart from ringing"
                                           : "at rest once it has stopped ringing: after a second per layer");
}
void hydrostatic(const Settings& s, Report& r) { tank(s, r, Start::still); }

// A surface as coarse as that is chaotic, and a lattice that nothing stirs keeps some of its order: one start reads
// anything from 1.1 to 4.7 %.
void hydrostatic_coarse(const Settings& s, Report& r) {
  constexpr int layers = 8, starts = 5;
  Rest mean;
  double all = 0, below = 0;
  for (unsigned seed = 1; seed <= starts; ++seed) {
    const Rest rest = rest_of(s, r, layers, Start::still, seed);
    if (!r.error.empty()) return;
    all += rest.error(0) / starts;
    below += rest.error(2) / starts;
    mean.level += rest.level / starts;
    mean.speed += rest.speed / starts;
    if (seed == 1) plot_rest(r, rest, "liquid_hydrostatic_coarse");
  }
  r.absolute("pressure, L2 over layers, mean of five stirred starts", all, 0, 3, "%",
             "as with 16 layers, where the surface weighs a third as much");
  r.absolute("the same below the upper two layers", below, 0, 2, "%",
             "the surface alone is as coarse as that: 3.8 % where floors lack their push");
  level_and_speed(r, mean, layers, "at rest once it has stopped ringing: after a second per layer");
  r.note =
      "8 layers fall short of 3 %: 3.7 +- 0.6 % in single precision and 3.6 +- 0.6 in double, ten starts "
      "each, which "
      "begin with up to 1e-4 m/s at random. The outermost layer of a free surface carries no pressure and "
      "lies closer "
      "to the next, which carries more: a fifth to two fifths of rho g dx each.";
}
void sloshed(const Settings& s, Report& r) { tank(s, r, Start::sloshing); }

/// Two decimals.
std::string text(double value) { return std::to_string(std::round(value * 100) / 100).substr(0, 4); }

// A column a wide and 2 a high collapses along a dry floor; periodic across. Z = front / a, T = t sqrt(2 g /
// a).
void dam_break(const Settings& s, Report& r) {
  struct Set {
    const char* name;
    std::vector<double> t, z;
  };
  const std::vector<Set> sets = {
      {"Martin & Moyce, a = 1.125 in",
       {0.849, 1.212, 1.602, 2.283, 2.950},
       {1.245, 1.443, 1.884, 2.689, 3.728}},
      {"Martin & Moyce, a = 2.25 in", {0.832, 1.219, 1.997, 2.547}, {1.217, 1.474, 2.292, 2.995}},
      {"Martin & Moyce, table 2",
       {0.84, 1.19, 1.43, 1.63, 1.83, 1.98, 2.20, 2.32, 2.51, 2.65, 2.83, 2.98, 3.11},
       {1.22, 1.44, 1.67, 1.89, 2.11, 2.33, 2.56, 2.78, 3.00, 3.22, 3.44, 3.67, 3.89}},
      {"Koshizuka & Oka",
       {1.153, 1.537, 1.935, 2.323, 2.719, 3.096},
       {1.505, 1.892, 2.241, 2.615, 3.003, 3.624}}};
  constexpr double a = 0.145, last = 3.35;
  constexpr int cells = 29;
  const double dx = a / cells, unit = std::sqrt(a / (2 * g));
  const WorldDesc d = box(s, dx, {5 * cells, 3 * cells, 8}, Face::wall, Face::wall, Face::periodic);
  Run run(d, r);
  run.fluid(Shape::box({0, 0, 0}, {a, 2 * a, 8 * dx}), run.material("water", 1000, 1e-3));
  Curve ours{"meltsim", {}, {}, false};
  for (double t = 0; t < last; t += 0.05) {
    if (!run.to(t * unit)) return;
    double front = 0;
    for (const Vec3d& x : run.particles().position) front = std::max(front, x.x);
    ours.x.push_back(t);
    ours.y.push_back((front + 0.5 * dx) / a);
  }
  Plot plot{"liquid_dam_break", "Front of a collapsing column", "t sqrt(2 g / a)", "front / a", {ours}};
  // DualSPHysics 5.4.355: this column, spacing, H and sound speed, Verlet, artificial viscosity 0.1, walls of particles.
  const std::vector<double> theirs_z = {1.25, 1.5, 2, 2.5, 3, 3.5, 4},
                            theirs_t = {0.690, 1.015, 1.526, 1.961, 2.354, 2.716, 3.064};
  for (const double z : {2.0, 3.0, 4.0})
    r.relative("T at which the front is at " + std::to_string(static_cast<int>(z)) + " a",
               interpolate(ours.y, ours.x, z), interpolate(theirs_z, theirs_t, z), 5,
               "another program's front at this spacing, which its settings move by up to 4 %");
  plot.curves.push_back({"DualSPHysics 5.4", theirs_t, theirs_z, true});
  r.note =
      "Experiments are drawn, not judged by: their gates and diaphragms leave open when time begins. The "
      "same curve started later by one constant deviates by";
  for (const Set& set : sets) {
    const auto deviation = [&](double lag) {
      double worst = 0;
      for (std::size_t i = 0; i < set.t.size(); ++i)
        worst = std::max(worst, std::fabs(interpolate(ours.x, ours.y, set.t[i] - lag) - set.z[i]));
      return worst;
    };
    plot.curves.push_back({set.name, set.t, set.z, true});
    double best = 0;
    for (double lag = 0; lag < 0.5; lag += 0.01)
      if (deviation(lag) < deviation(best)) best = lag;
    r.note += std::string(r.note.back() == 'y' ? " " : ", ") + text(deviation(best)) + " (" + set.name +
              ", " + text(best) + "; " + text(deviation(0)) + " without)";
  }
  r.note +=
      " column widths at that lag in T. The sets differ by 0.37 among themselves at T = 2.7. Neither the "
      "resolution, nor the wall's friction, nor whether the outermost "
      "particle or the outermost column of particles counts makes more than 0.03 of a difference. "
      "liquid.collapse compares how the column begins to move with potential flow.";
  r.plots.push_back(plot);
}

/// How a column of liquid, a wide and h high, begins to fall apart when what held it is taken away at once: pressure is
/// harmonic, 0 at the top and in front, without flow through wall and floor. As p = rho g (h - y) + a series in
/// cos((n + 1/2) pi y / h), which takes the hydrostatic part off the front [m/s^2]:
struct Release {
  double sideways = 0, down = 0;  ///< mean of the column
  double low = 0, high = 0;       ///< sideways, mean of the lower and of the upper half of the layer at x
};
Release release(double a, double h, double x) {
  Release r{0.5 * h / a, 0, 0, 0};
  for (int n = 0; n < 2000; ++n) {
    const double k = (n + 0.5) * pi / h, sign = n % 2 == 0 ? 1 : -1, part = 2 / (h * k * k);
    const double ends = 1 + std::exp(-2 * k * a);  // of cosh(k a), over its exponential
    const double steep = std::exp(k * (x - a)) * (1 - std::exp(-2 * k * x)) / ends;
    r.sideways -= part * sign / k * 2 * std::exp(-k * a) / ends / (a * h);
    r.down += part * std::tanh(k * a) / k / (a * h);
    r.low += part * steep * std::sin(0.5 * k * h) / (0.5 * h);
    r.high += part * steep * (sign - std::sin(0.5 * k * h)) / (0.5 * h);
  }
  return {g * r.sideways, g * r.down, g * r.low, g * r.high};
}

// The column of liquid.dam_break in its first moments, where experiments differ and theory is exact. The speed after t is
// fitted by A t + B t^3; A is what is compared. With sound 80 times as fast as a fall from the top, five periods of the
// longest wave of pressure lie within.
void collapse(const Settings& s, Report& r) {
  constexpr double a = 0.05715;
  constexpr int cells = 20;
  const double dx = a / cells, unit = std::sqrt(a / (2 * g));
  WorldDesc d = box(s, dx, {2 * cells, 3 * cells, 8}, Face::wall, Face::wall, Face::periodic);
  d.domain.no_slip = false;
  d.sound_speed = 80 * std::sqrt(4 * g * a);
  Run run(d, r);
  run.fluid(Shape::box({0, 0, 0}, {a, 2 * a, 8 * dx}), run.material("water", 1000, 0));
  // Sums of t^2, t^4, t^6 and of what is fitted with t and t^3.
  struct Fit {
    double s2 = 0, s4 = 0, s6 = 0, y1 = 0, y3 = 0;
    void add(double t, double y) {
      s2 += t * t, s4 += t * t * t * t, s6 += t * t * t * t * t * t;
      y1 += t * y, y3 += t * t * t * y;
    }
    double slope() const { return (y1 * s6 - y3 * s4) / (s2 * s6 - s4 * s4); }
  } sideways, down, low, high;
  std::vector<std::size_t> ahead[2];  // the outermost layer: its lower half, its upper
  Curve ours{"meltsim", {}, {}, false}, theory{"potential flow", {}, {}, true};
  const Release exact = release(a, 2 * a, a - 0.5 * dx);
  for (double T = 0.01; T < 0.405; T += 0.01) {
    const double t = T * unit;
    if (!run.to(t)) return;
    const ParticleData p = run.particles();
    if (ahead[0].empty())
      for (std::size_t i = 0; i < p.id.size(); ++i)
        if (p.position[i].x > a - 0.7 * dx) ahead[p.position[i].y > a ? 1 : 0].push_back(i);
    Vec3d mean{};
    for (const Vec3d& v : p.velocity) mean += v;
    mean = mean * (1.0 / static_cast<double>(p.id.size()));
    const auto speed = [&p](const std::vector<std::size_t>& some) {
      double sum = 0;
      for (const std::size_t i : some) sum += p.velocity[i].x;
      return sum / static_cast<double>(some.size());
    };
    sideways.add(t, mean.x);
    down.add(t, -mean.y);
    low.add(t, speed(ahead[0]));
    high.add(t, speed(ahead[1]));
    ours.x.push_back(T);
    ours.y.push_back(mean.x / (g * t));
    theory.x.push_back(T);
    theory.y.push_back(exact.sideways / g);
  }
  r.relative("centre of mass, sideways / g", sideways.slope() / g, exact.sideways / g, 2,
             "20 cells per width; the outermost half spacing carries no pressure");
  r.relative("centre of mass, down / g", down.slope() / g, exact.down / g, 2, "the same");
  r.relative("front, lower half / g", low.slope() / g, exact.low / g, 5, "one layer of particles");
  r.relative(
      "front, upper half / g", high.slope() / g, exact.high / g, 10,
      "half a spacing in where the front is makes 4.4 %; measured 6.3 %, 3.2 % with 40 cells per width");
  r.note =
      "Whether the column begins to move as it should, which experiments with gates and diaphragms do not "
      "tell: liquid.dam_break is ahead of them.";
  r.plots.push_back(
      {"liquid_collapse", "A column let go", "t sqrt(2 g / a)", "mean u / (g t)", {ours, theory}});
}

// First mode of a tank: T = 2 pi / sqrt(g k tanh(k d)), k = pi / L. Starts with the linear wave's velocities
// at a flat surface; amplitude 0.02 L. The period is read from the zero crossings of sum cos(k x).
void standing_wave(const Settings& s, Report& r, double length, double depth) {
  const double dx = depth / 16, k = pi / length, omega = std::sqrt(g * k * std::tanh(k * depth));
  const double period = 2 * pi / omega, speed = 0.02 * length * omega;
  const int nx = static_cast<int>(std::lround(length / dx));
  const WorldDesc d = box(s, dx, {nx, 24, 8}, Face::wall, Face::wall, Face::periodic);
  Run run(d, r);
  run.field(
      d, {nx, 16, 8}, run.material("water", 1000, 1e-3), [](double, double) { return true; },
      [&](double x, double y) {
        return Vec3d{-std::sin(k * x) * std::cosh(k * y), std::cos(k * x) * std::sinh(k * y), 0} *
               (speed / std::sinh(k * depth));
      });
  Curve ours{"meltsim", {}, {}, false};
  for (double t = 0; t < 2.3 * period; t += period / 40) {
    if (!run.to(t)) return;
    double moment = 0;
    const ParticleData p = run.particles();
    for (const Vec3d& x : p.position) moment += std::cos(k * x.x);
    ours.x.push_back(t / period);
    ours.y.push_back(moment / static_cast<double>(p.id.size()));
  }
  std::vector<double> crossings;
  for (std::size_t i = 2; i < ours.x.size(); ++i)
    if (ours.y[i - 1] * ours.y[i] < 0)
      crossings.push_back(ours.x[i - 1] +
                          (ours.x[i] - ours.x[i - 1]) * ours.y[i - 1] / (ours.y[i - 1] - ours.y[i]));
  if (crossings.size() < 4) {
    r.error = "the wave has died out";
    return;
  }
  // Whole periods, two that overlap by half of one: where the mean is not 0, half periods are too long and too short in turn.
  const double measured = 0.5 * (crossings[2] - crossings[0] + crossings[3] - crossings[1]) * period;
  r.relative("period, L " + std::to_string(length).substr(0, 3) + " m, d " +
                 std::to_string(depth).substr(0, 3) + " m",
             measured, period, 2, "16 layers; the finite amplitude lengthens it by 0.1 %");
  r.plots.push_back(
      {"liquid_wave_" + std::to_string(nx), "First mode of a tank", "t / T", "mean cos(k x)", {ours}});
}
void standing_waves(const Settings& s, Report& r) {
  standing_wave(s, r, 2, 1);
  if (r.error.empty()) standing_wave(s, r, 1, 0.5);
}

// Taylor-Green vortices at Re 100: u = -U cos(2 pi x) sin(2 pi y), v = U sin(2 pi x) cos(2 pi y), U(t) =
// exp(-8 pi^2 t/Re).
void taylor_green(const Settings& s, Report& r) {
  constexpr int n = 50;
  WorldDesc d = box(s, 1.0 / n, {n, n, 8}, Face::periodic, Face::periodic, Face::periodic);
  d.gravity = {0, 0, 0};
  d.artificial_viscosity = 0;
  d.tension = true;
  d.particle_shifting = true;
  Run run(d, r);
  const auto flow = [](double x, double y) {
    return Vec3d{-std::cos(2 * pi * x) * std::sin(2 * pi * y), std::sin(2 * pi * x) * std::cos(2 * pi * y),
                 0};
  };
  run.field(
      d, {n, n, 8}, run.material("liquid", 1, 0.01), [](double, double) { return true; }, flow);
  const double rate = 8 * pi * pi / 100;
  Curve ours{"meltsim", {}, {}, false}, exact{"exp(-8 pi^2 t/Re)", {}, {}, true};
  for (double t = 0; t < 1.001; t += 0.05) {
    if (!run.to(t)) return;
    double square = 0;
    const ParticleData p = run.particles();
    for (const Vec3d& v : p.velocity) square += dot(v, v);
    ours.x.push_back(t);
    ours.y.push_back(std::sqrt(2 * square / static_cast<double>(p.id.size())));
    exact.x.push_back(t);
    exact.y.push_back(std::exp(-rate * t));
  }
  r.relative("decay rate over t = 1", -std::log(ours.y.back() / ours.y.front()), rate, 5,
             "50^2 particles; speed = sqrt(2 mean v^2), so every disorder counts as flow");
  r.plots.push_back({"liquid_taylor_green", "Taylor-Green vortices, Re 100", "t", "speed", {ours, exact}});
  r.note =
      "artificial_viscosity 0: the flow's own viscosity only; tension on: the vortices' cores pull; "
      "particle_shifting on. Without it the strain at the stagnation points squeezes the lattice into "
      "strings "
      "within a tenth of a turnover, which phi takes for compression; they break at t = 0.2, half of the "
      "energy "
      "becomes noise, and the decay is three times too fast (231 % off at 24^2).";
}

/// Mean x velocity per layer of a channel, walls included, at y / L.
void profile(const ParticleData& p, double dx, int layers, std::vector<double>& y, std::vector<double>& u) {
  std::vector<double> sum(static_cast<std::size_t>(layers)), count(sum.size());
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const auto b = std::min(sum.size() - 1, static_cast<std::size_t>(std::max(0.0, p.position[i].y / dx)));
    sum[b] += p.velocity[i].x;
    count[b] += 1;
  }
  y.clear();
  u.clear();
  for (std::size_t b = 0; b < sum.size(); ++b) {
    y.push_back((static_cast<double>(b) + 0.5) / layers);
    u.push_back(count[b] > 0 ? sum[b] / count[b] : 0);
  }
}

constexpr int channel_layers = 20;
constexpr double channel = 1e-3, channel_speed = 1.25e-5;

WorldDesc channel_desc(const Settings& s) {
  WorldDesc d =
      box(s, channel / channel_layers, {8, channel_layers, 8}, Face::periodic, Face::wall, Face::periodic);
  d.sound_speed = 20 * channel_speed;
  // The flow comes to rest within a few of the steps that sound would allow, and its start is the subject.
  d.viscosity = Viscosity::explicit_;
  d.gravity = {0, 0, 0};
  return d;
}

// Morris, Fox & Zhu (1997): nu 1e-6 m^2/s, L 1e-3 m, from rest.
void couette(const Settings& s, Report& r) {
  WorldDesc d = channel_desc(s);
  d.domain.velocity[3] = {channel_speed, 0, 0};
  Run run(d, r);
  run.fluid(Shape::box({0, 0, 0}, d.domain.max), run.material("water", 1000, 1e-3));
  const double times[] = {0.0225, 0.045, 0.1125, 0.225}, half[] = {.01842, .09558, .29028, .43090},
               upper[] = {.63735, .73888, .83298, .87862};
  Plot plot{"liquid_couette", "Couette flow from rest", "y / L", "u / V", {}};
  std::vector<double> y, u;
  for (int i = 0; i < 4; ++i) {
    if (!run.to(times[i])) return;
    profile(run.particles(), d.spacing, channel_layers, y, u);
    for (double& v : u) v /= channel_speed;
    const std::string at = ", t = " + std::to_string(times[i]).substr(0, 6) + " s";
    r.relative("u/V at y/L 0.5" + at, interpolate(y, u, 0.5), half[i], 2, "20 layers");
    r.relative("u/V at y/L 0.9" + at, interpolate(y, u, 0.9), upper[i], 2, "20 layers");
    plot.curves.push_back({"meltsim" + at, y, u, false});
    plot.curves.push_back({"series" + at, {0.5, 0.9}, {half[i], upper[i]}, true});
  }
  r.plots.push_back(plot);
}

void poiseuille(const Settings& s, Report& r) {
  WorldDesc d = channel_desc(s);
  d.gravity = {8 * 1e-6 * channel_speed / (channel * channel), 0, 0};
  Run run(d, r);
  run.fluid(Shape::box({0, 0, 0}, d.domain.max), run.material("water", 1000, 1e-3));
  const double times[] = {0.0225, 0.045, 0.1125, 0.225}, centre[] = {.17862, .33877, .65999, .88798};
  Plot plot{"liquid_poiseuille", "Poiseuille flow from rest", "y / L", "u / u_max", {}};
  std::vector<double> y, u;
  for (int i = 0; i < 4; ++i) {
    if (!run.to(times[i])) return;
    profile(run.particles(), d.spacing, channel_layers, y, u);
    for (double& v : u) v /= channel_speed;
    const std::string at = ", t = " + std::to_string(times[i]).substr(0, 6) + " s";
    r.relative("centre u/u_max" + at, interpolate(y, u, 0.5), centre[i], 2, "20 layers");
    plot.curves.push_back({"meltsim" + at, y, u, false});
    plot.curves.push_back({"series" + at, {0.5}, {centre[i]}, true});
  }
  r.plots.push_back(plot);
}

// A free cylinder of liquid, radius 1, strained at the rate A0: it stays an ellipse, Monaghan (1994).
// Semi-axes from second moments: b = 2 sqrt(mean y^2), relative to those at the start. The strain's axes lie
// at 45 degrees to the lattice: along them, the lattice is squeezed into strings (0.52 apart along, 1.93
// across at the end) that nothing disturbs in a flow this regular, and the area comes out 14 % too large.
void drop(const Settings& s, Report& r) {
  constexpr int radius = 20, n = 2 * radius + 70;
  constexpr double dx = 1.0 / radius;
  WorldDesc d = box(s, dx, {n, n, 8}, Face::open, Face::open, Face::periodic);
  d.domain.min = {-0.5 * n * dx, -0.5 * n * dx, 0};
  d.domain.max = {0.5 * n * dx, 0.5 * n * dx, 8 * dx};
  d.gravity = {0, 0, 0};
  d.artificial_viscosity = 0.01;
  Run run(d, r);
  run.field(
      d, {n, n, 8}, run.material("liquid", 1000, 0), [](double x, double y) { return x * x + y * y < 1; },
      [](double x, double y) {
        return Vec3d{100 * y, 100 * x, 0};
      });
  const double times[] = {0.0025, 0.005, 0.0075}, small[] = {.78261, .62705, .51791},
               large[] = {1.27777, 1.59476, 1.93085};
  const auto axes = [&] {
    const ParticleData p = run.particles();
    double xx = 0, yy = 0;
    for (const Vec3d& x : p.position) {
      xx += 0.5 * (x.x - x.y) * (x.x - x.y);
      yy += 0.5 * (x.x + x.y) * (x.x + x.y);
    }
    const double c = static_cast<double>(std::max<std::size_t>(1, p.id.size()));
    return std::make_pair(2 * std::sqrt(xx / c), 2 * std::sqrt(yy / c));
  };
  const double start = axes().first;
  Curve a{"short semi-axis", {}, {}, false}, b{"long semi-axis", {}, {}, false};
  for (int i = 0; i < 3; ++i) {
    if (!run.to(times[i])) return;
    const auto now = axes();
    const std::string at = ", t = " + std::to_string(times[i]).substr(0, 6) + " s";
    r.relative("short semi-axis" + at, now.first / start, small[i], 1, "20 particles per radius");
    r.relative("long semi-axis" + at, now.second / start, large[i], 1, "20 particles per radius");
    a.x.push_back(times[i]);
    a.y.push_back(now.first / start);
    b.x.push_back(times[i]);
    b.y.push_back(now.second / start);
  }
  r.plots.push_back({"liquid_drop",
                     "Elliptical drop",
                     "t [s]",
                     "semi-axis / radius",
                     {a,
                      b,
                      {"exact", {times[0], times[1], times[2]}, {small[0], small[1], small[2]}, true},
                      {"exact", {times[0], times[1], times[2]}, {large[0], large[1], large[2]}, true}}});
  r.note = "Inviscid: viscosity 0, artificial_viscosity 0.01 against sound.";
}

}  // namespace

std::vector<Case> liquid_cases() {
  return {
      {"liquid.hydrostatic", "a tank of 16 layers at rest", "p = rho g h", false, hydrostatic},
      {"liquid.hydrostatic_coarse", "a tank of 8 layers at rest", "p = rho g h", false, hydrostatic_coarse},
      {"liquid.sloshed", "a tank that was poured in from one side, settled", "p = rho g h", true, sloshed},
      {"liquid.dam_break", "front of a collapsing column on a dry floor",
       "DualSPHysics 5.4; drawn: Martin & Moyce (1952), Phil. Trans. A 244:312; Koshizuka & Oka (1996), "
       "Nucl. Sci. Eng. 123:421",
       true, dam_break},
      {"liquid.collapse", "a column of liquid let go: its first moments", "potential flow (a series)", false,
       collapse},
      {"liquid.standing_wave", "periods of two tanks' first modes", "linear wave theory", true,
       standing_waves},
      {"liquid.taylor_green", "decay of a periodic array of vortices at Re 100", "exact solution", true,
       taylor_green},
      {"liquid.couette", "start of a flow between a wall and a moving lid",
       "series solution; Morris, Fox & Zhu (1997), J. Comput. Phys. 136:214", false, couette},
      {"liquid.poiseuille", "start of a flow driven through a channel",
       "series solution; Morris, Fox & Zhu (1997), J. Comput. Phys. 136:214", false, poiseuille},
      {"liquid.drop", "a free cylinder of liquid stretched into an ellipse",
       "Monaghan (1994), J. Comput. Phys. 110:399, sec. 5", false, drop},
  };
}

}  // namespace validation
