// SPDX-License-Identifier: Apache-2.0
// Lattice shape matching: the solid.
//
// Source: Rivers & James (2007), FastLSM, ACM Trans. Graph. 26(3), secs. 3-4; Mueller et al. (2005),
// Meshless deformations, for goal positions.
//
//   symbol  meaning                                                       unit
//   R_r     region of vertex r: the vertices within w lattice steps       -
//   m~_i    m_i / |R_i|, so that a vertex counts once over its regions    kg
//   u_j     x_j - x_r, current position relative to the region's vertex   m
//   q_j     rest position relative to the region's vertex (lattice)       m
//   c, c0   weighted means of u and q over the region                     m
//   R       best rotation of A = sum m~ (u - c)(q - c0)^T                 -
//   g_i     mean over r in R_i of R_r (q_i - c0_r) + c_r + x_r            m
//   E       Young's modulus                                               Pa
//   c_l     speed of longitudinal waves in a slender bar                  m/s
//
// Stiffness. A small displacement u(x) along a bar turns no region, and goals become means of means: with the
// box filter B of 2w+1 sites, v changes by alpha (B B u - u)/dt per step. For waves much longer than a region
// B B u - u = (w(w+1)/3) dx^2 u'', so that
//   c_l = sqrt(alpha w(w+1)/3) dx/dt,   E = rho c_l^2,   Poisson's ratio 0.
// Validated by `meltsim validate --filter solid.wave_speed` (free bars of 3 x 3 x 20 w sites, damping 0, period
// 2 L/c_l of the first mode): within 0.05 % for w = 1..8. A wave of n regions' half-widths is slower by about
// 7/n^2. A common fit, c_l = (0.23 + 0.555 w) sqrt(alpha) dx/dt, is 4..5 % lower throughout: it takes L as the
// distance of the end particles, one spacing less than the length of the bar, in bars of some 20 sites.
// A given E is met by alpha = E/rho (dt/dx)^2/(w(w+1)/3), with w large enough that alpha <= 1 at the largest
// sub-step. Without a given E, alpha belongs to dt_s, the time step of the scene's springs (integrate.hpp: spring_dt), and
// at a step dt it is alpha (dt/dt_s)^2: E = rho alpha w(w+1)/3 (dx/dt_s)^2 does not depend on the step.
// If E followed the step, a shorter step would give a strain more energy than the longer step left in it.
//
// Steps of any length. A mode of I - B B, of eigenvalue l in 0..1, is an oscillator of frequency
// omega^2 = alpha l/dt_s^2 with friction damping l/dt_s. With neither changing, drift-kick-drift over steps
// whose length varies within 0..dt_s still adds energy, because it exactly conserves an energy that depends on the
// step: 2e-4 per step at random lengths, 2e-2 at the worst sequence. A damping of 0.11 alpha^(3/2) bounds the
// energy for any sequence of lengths (the worst one found by dynamic programming on the phase of the
// oscillator; 0.105 is the limit): least_damping.
//
// Boxes. Neighbouring regions share most of their members. A region that lacks no site of its box is 2w+1
// planes of 2w+1 rows of 2w+1 members, and a row or a plane is part of as many regions: its sums are computed once,
// about its own vertex, and shifted to the larger box (add_box), 3 (2w+1) terms instead of (2w+1)^3;
// goals are summed likewise over rows and planes of regions (add_goals). These are the passes (bars, plates,
// cubes) of the source's fast sums. Regions with gaps are summed member by member.
//
// Deviations: positions enter only as differences (displacement form): with absolute positions the rounding of the
// weights acts as an anti-spring about the origin. The rounding error in momentum and spin of a piece is
// subtracted (residual_correction): a float rotation is exact to 1e-7, which at steps of 1 ms is a torque that
// stops a body spinning at 1 rad/s within minutes. Damping pulls towards the rigid motion of each region, as
// in the source, with the angular velocity from a pseudo-inverse so that chains and sheets are well
// defined.
#pragma once

#include <array>

#include "meltsim/physics/polar.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Sums over a region, relative to its vertex.
template <class T>
struct RegionSums {
  T mass{};        ///< sum m~ [kg]
  Vec3<T> mu{};    ///< sum m~ u
  Vec3<T> mq{};    ///< sum m~ q
  Mat3<T> muq{};   ///< sum m~ u q^T
  Sym3<T> muu{};   ///< sum m~ u u^T
  Vec3<T> mv{};    ///< sum m~ v, v relative to the vertex
  Vec3<T> muxv{};  ///< sum m~ u x v
};

/// Adds o to s.
template <class T>
MELTSIM_HD void add_sums(RegionSums<T>& s, const RegionSums<T>& o) {
  s.mass += o.mass;
  s.mu += o.mu;
  s.mq += o.mq;
  s.mv += o.mv;
  s.muxv += o.muxv;
  s.muu.diagonal += o.muu.diagonal;
  s.muu.mixed += o.muu.mixed;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) s.muq.m[i][j] += o.muq.m[i][j];
}
/// Adds a member of the region.
template <class T>
MELTSIM_HD void add_member(RegionSums<T>& s, T mass, Vec3<T> u, Vec3<T> q, Vec3<T> v) {
  s.mass += mass;
  s.mu += u * mass;
  s.mq += q * mass;
  add_outer(s.muq, mass, u, q);
  add_square(s.muu, mass, u);
  s.mv += v * mass;
  s.muxv += cross(u, v) * mass;
}

/// Sums over the members in a box of sites 2w+1 long along the first Axes of x, y and z and one site wide along
/// the others, relative to the vertex in its middle: a row (1), a plane (2), a whole region (3).
template <class T, int Axes>
struct BoxSums {
  T mass{};              ///< sum m~ [kg]
  T mq[Axes]{};          ///< sum m~ q along each of these axes
  Vec3<T> mu{};          ///< sum m~ u
  Vec3<T> muq[Axes]{};   ///< sum m~ u q along each of them: columns of sum m~ u q^T, the others are 0
  Sym3<T> muu{};         ///< sum m~ u u^T
  Vec3<T> mv{}, muxv{};  ///< sum m~ v, v relative to the box's vertex; sum m~ u x v
};

/// Adds a member to the row whose middle is at (-q,0,0) from it at rest.
template <class T>
MELTSIM_HD void add_member(BoxSums<T, 1>& r, T mass, Vec3<T> u, T q, Vec3<T> v) {
  const Vec3<T> mu = u * mass;
  r.mass += mass;
  r.mq[0] += mass * q;
  r.mu += mu;
  r.muq[0] += mu * q;
  add_square(r.muu, mass, u);
  r.mv += v * mass;
  r.muxv += cross(mu, v);
}

/// Adds a box to a box with one axis more. Relative to the vertex of the larger box, the vertex of the smaller one is at q
/// along that axis at rest, at u now, and moves at v; q, u and v of each member change by these.
template <class T, int Axes>
MELTSIM_HD void add_box(BoxSums<T, Axes + 1>& s, const BoxSums<T, Axes>& b, Vec3<T> u, T q, Vec3<T> v) {
  const Vec3<T> mu = b.mu + u * b.mass;  // of its members about the larger one's vertex
  s.mass += b.mass;
  s.mu += mu;
  for (int k = 0; k < Axes; ++k) {
    s.mq[k] += b.mq[k];
    s.muq[k] += b.muq[k] + u * b.mq[k];
  }
  s.mq[Axes] += b.mass * q;
  s.muq[Axes] += mu * q;
  // sum m~ (u_j + u)(u_j + u)^T = muu + u (sum m~ u_j)^T + (sum m~ (u_j + u)) u^T
  s.muu.diagonal +=
      b.muu.diagonal + Vec3<T>{u.x * (b.mu.x + mu.x), u.y * (b.mu.y + mu.y), u.z * (b.mu.z + mu.z)};
  s.muu.mixed +=
      b.muu.mixed + Vec3<T>{u.y * b.mu.z + mu.y * u.z, u.z * b.mu.x + mu.z * u.x, u.x * b.mu.y + mu.x * u.y};
  s.mv += b.mv + v * b.mass;
  s.muxv += b.muxv + cross(mu, v) + cross(u, b.mv);
}
/// Sums of a region from those of its box.
template <class T>
MELTSIM_HD RegionSums<T> region_of(const BoxSums<T, 3>& b) {
  RegionSums<T> s;
  s.mass = b.mass;
  s.mu = b.mu;
  s.mq = {b.mq[0], b.mq[1], b.mq[2]};
  for (int k = 0; k < 3; ++k) {
    s.muq.m[0][k] = b.muq[k].x;
    s.muq.m[1][k] = b.muq[k].y;
    s.muq.m[2][k] = b.muq[k].z;
  }
  s.muu = b.muu;
  s.mv = b.mv;
  s.muxv = b.muxv;
  return s;
}

/// Best rigid placement and motion of a region, relative to its vertex: the goal of the site q is R q + anchor, and
/// the rigid velocity at u is velocity + spin x u.
template <class T>
struct RegionFit {
  Quat<T> rotation{};  ///< R
  Vec3<T> anchor{};    ///< c - R c0
  Vec3<T> velocity{};  ///< mean velocity minus spin x c
  Vec3<T> spin{};      ///< angular velocity [rad/s]
};
/// Fits a region; `previous`: rotation of the last step, from which the search starts.
template <class T>
MELTSIM_HD RegionFit<T> fit_region(const RegionSums<T>& s, const Quat<T>& previous) {
  RegionFit<T> f;
  const T inv = T(1) / s.mass;
  const Vec3<T> center = s.mu * inv, rest_center = s.mq * inv, mean = s.mv * inv;
  Mat3<T> A = s.muq;
  add_outer(A, -s.mass, center, rest_center);
  f.rotation = best_rotation(A, previous);
  f.anchor = center - rotate(f.rotation, rest_center);
  Mat3<T> second = to_matrix(s.muu);
  add_outer(second, -s.mass, center, center);
  const T trace = second.m[0][0] + second.m[1][1] + second.m[2][2];
  Mat3<T> inertia;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) inertia.m[i][j] = (i == j ? trace : T(0)) - second.m[i][j];
  const Vec3<T> spin_momentum = s.muxv - cross(center, mean) * s.mass;
  f.spin = solve_symmetric(inertia, spin_momentum);
  f.velocity = mean - cross(f.spin, center);
  return f;
}

/// Goal of a member minus its position [m]. q, u: rest and current position of the member relative to the vertex of
/// the region.
template <class T>
MELTSIM_HD Vec3<T> goal_displacement(const RegionFit<T>& f, Vec3<T> q, Vec3<T> u) {
  return rotate(f.rotation, q) + (f.anchor - u);
}

/// Rigid velocity of the region at a member minus the velocity v of the member [m/s]; u relative to the vertex of the
/// region, v in the frame of f.velocity.
template <class T>
MELTSIM_HD Vec3<T> rigid_velocity_defect(const RegionFit<T>& f, Vec3<T> u, Vec3<T> v) {
  return cross(f.spin, u) + (f.velocity - v);
}

/// Sums over the regions of a box of vertices (BoxSums) of their goals and rigid velocities for a vertex that all of
/// them contain: the values at the vertex in the middle of the box, and their change away from it. Axes = 0: one
/// region; Axes = 3: all regions of a vertex.
template <class T, int Axes>
struct BoxGoals {
  Vec3<T> displacement{};  ///< sum of goals minus position, for a vertex at the middle of the box
  Vec3<T> velocity{};      ///< sum of rigid velocities there
  Vec3<T> spin{};          ///< sum of spins
  Vec3<T> columns[Axes < 3 ? 3 - Axes : 1]{};  ///< sums of the columns of R for the remaining axes
};
/// Goals of one region.
template <class T>
MELTSIM_HD BoxGoals<T, 0> goals_of(const RegionFit<T>& f) {
  const Mat3<T> R = to_matrix(f.rotation);
  return {f.anchor,
          f.velocity,
          f.spin,
          {{R.m[0][0], R.m[1][0], R.m[2][0]},
           {R.m[0][1], R.m[1][1], R.m[2][1]},
           {R.m[0][2], R.m[1][2], R.m[2][2]}}};
}

/// Adds a box of `count` regions to a box with one axis more. Relative to the vertex of the smaller box, the vertex of the
/// larger one is at q along that axis at rest and at u now.
template <class T, int Axes>
MELTSIM_HD void add_goals(BoxGoals<T, Axes + 1>& s, const BoxGoals<T, Axes>& b, T count, T q, Vec3<T> u) {
  s.displacement += b.displacement + (b.columns[0] * q - u * count);
  s.velocity += b.velocity + cross(b.spin, u);
  s.spin += b.spin;
  for (int k = 1; k < 3 - Axes; ++k) s.columns[k - 1] += b.columns[k];
}

/// Change of velocity from the mean goal displacement and the mean velocity defect [m/s].
template <class T>
MELTSIM_HD Vec3<T> shape_velocity(T stiffness, T damping, T dt, Vec3<T> displacement, Vec3<T> defect) {
  return displacement * (stiffness / dt) + defect * damping;
}

/// alpha at a step dt that gives the same E as `stiffness` at spring_dt. Damping scales with the first power.
template <class T>
MELTSIM_HD T stiffness_of_step(T stiffness, T dt, T spring_dt) {
  const T share = dt / spring_dt;
  return stiffness * (share * share);
}

/// Damping, as a share per step dt_s, below which steps of varying length could add energy to a body with this alpha at
/// the step dt_s.
template <class T>
MELTSIM_HD T least_damping(T stiffness) {
  return T(0.11) * stiffness * std::sqrt(stiffness);
}

inline constexpr int most_half_width = 8;  ///< a region has at most 17^3 sites

/// Square of the wave speed of a long bar at alpha = 1 [(dx/dt)^2].
MELTSIM_HD constexpr double region_wave_speed2(int half_width) { return half_width * (half_width + 1) / 3.0; }

/// Sites up to which a bar is not taken for a long one, which has its E to 2 %.
inline constexpr int most_short_sites = 6 * most_half_width;

/// The same of a bar of n sites, by its first longitudinal mode (host): n^2 (1 - g)/pi^2, as a bar of length L has pi^2 E/(rho L^2). g: the largest
/// eigenvalue of G among modes odd about the middle, by the power method; G u: the goals of sites displaced by u, which are means
/// over the regions of a site of the means over their sites, each of these weighted by one over its number of regions. Regions
/// end where the bar does; one that holds all of it does not follow the mode at all: n^2/pi^2 is the most. Ours.
inline double bar_wave_speed2(int half_width, int sites) {
  constexpr double pi2 = 9.86960440108935861;
  if (half_width < 1 || sites < 2 || sites > most_short_sites) return region_wave_speed2(half_width);
  const auto n = static_cast<std::size_t>(sites), w = static_cast<std::size_t>(half_width);
  std::array<double, most_short_sites> mode{}, share{}, mean{}, goal{};
  const auto low = [&](std::size_t k) { return k > w ? k - w : std::size_t{0}; };
  const auto high = [&](std::size_t k) { return k + w < n ? k + w : n - 1; };
  for (std::size_t k = 0; k < n; ++k) {
    mode[k] =
        std::sin(std::sqrt(pi2) * (static_cast<double>(k) - 0.5 * (sites - 1)) / sites);  // of a long bar
    share[k] = 1.0 / static_cast<double>(high(k) - low(k) + 1);
  }
  double g = 0;
  constexpr int rounds = 12;  // g is right to the square of the mode's error
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t r = 0; r < n; ++r) {
      double sum = 0, shares = 0;
      for (std::size_t k = low(r); k <= high(r); ++k) {
        sum += share[k] * mode[k];
        shares += share[k];
      }
      mean[r] = sum / shares;
    }
    double up = 0, down = 0;
    for (std::size_t k = 0; k < n; ++k) {
      goal[k] = 0;
      for (std::size_t r = low(k); r <= high(k); ++r) goal[k] += share[k] * mean[r];
      up += mode[k] * goal[k];
      down += mode[k] * mode[k];
    }
    g = up / down;
    if (!(g > 1e-9)) break;  // all regions hold all of it
    for (std::size_t k = 0; k < n; ++k) mode[k] = 0.5 * (goal[k] - goal[n - 1 - k]) / g;
  }
  return sites * sites * (1 - g) / pi2;
}

/// alpha at a step dt [s] that gives E = modulus_rate rho dx^2; modulus_rate = E/(rho dx^2) [1/s^2], wave_speed2 as above. A result above 1
/// means that these regions cannot give E.
template <class T>
MELTSIM_HD T modulus_stiffness(T modulus_rate, T wave_speed2, T dt) {
  return modulus_rate * dt * dt / wave_speed2;
}

/// The smallest half-width w from `least` to `most` whose alpha for a step dt is at most 1, or `most`; wave_speed2(w) as above.
template <class WaveSpeed2>
inline int modulus_half_width(double modulus_rate, int least, int most, double dt,
                              const WaveSpeed2& wave_speed2) {
  int w = least;
  while (w < most && modulus_stiffness(modulus_rate, wave_speed2(w), dt) > 1.0) ++w;
  return w;
}

/// E/(rho dx^2) [1/s^2] of Young's modulus E [Pa]: what regions of whatever width have to come to.
inline double modulus_rate(double youngs_modulus, double density, double spacing) {
  return youngs_modulus / (density * spacing * spacing);
}

/// Young's modulus [Pa] of shape matching with stiffness alpha at a step dt [s]; wave_speed2 as above.
MELTSIM_HD double shape_modulus(double stiffness, double wave_speed2, double density, double spacing,
                                double dt) {
  const double speed = spacing / dt;
  return density * stiffness * wave_speed2 * speed * speed;
}

/// Rounding error in the momentum and spin of a piece after shape matching, which must change neither: sums over its
/// vertices, positions relative to one of them.
struct RigidResidual {
  double mass = 0;                  ///< sum m [kg]
  Vec3<double> momentum{}, spin{};  ///< sum m dv, sum m u x dv
  Vec3<double> first{};             ///< sum m u
  Mat3<double> second{};            ///< sum m u u^T
};

/// Change of velocity at u that cancels the error: minus the mean velocity and minus the rigid rotation with the
/// residual spin about the centre of mass.
MELTSIM_HD Vec3<double> residual_correction(const RigidResidual& r, Vec3<double> u) {
  if (!(r.mass > 0)) return {};
  const Vec3<double> c = r.first * (1.0 / r.mass), mean = r.momentum * (1.0 / r.mass);
  const Vec3<double> spin = r.spin - cross(c, r.momentum);
  Mat3<double> s = r.second;
  add_outer(s, -r.mass, c, c);
  const double trace = s.m[0][0] + s.m[1][1] + s.m[2][2];
  Mat3<double> inertia;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) inertia.m[i][j] = (i == j ? trace : 0.0) - s.m[i][j];
  return -(mean + cross(solve_symmetric(inertia, spin), u - c));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
