// SPDX-License-Identifier: Apache-2.0
// Heat: the enthalpy curve, conductivities, and the paper's pair update. Pairs exchange heat and super-steps advance it
// as diffusion.hpp says.
//
// Sources: enthalpy method: Voller & Cross (1981), Int. J. Heat Mass Transfer 24:545; melting over a range of temperatures with
// a liquid fraction linear in it: Voller & Swaminathan (1991), Numer. Heat Transfer B 19:175. Paper mode: Shao & Yu (2017),
// eq. (4); Dagenais et al. (2012).
//
//   symbol  meaning                                         unit
//   H       enthalpy of a particle                          J       (double: a step may add 1e-8 of it)
//   h       H / m                                           J/kg
//   T       temperature                                     degrees Celsius
//   T_s     melting point: melting begins                   degrees Celsius
//   T_l     T_s and the melting range: melting ends         degrees Celsius
//   f       liquid fraction, linear in h and T between them -
//   R       1/k                                             m K/W
//   g_ij    V_i V_j L_ij 2 / (R_i + R_j)                    W/K     bitwise symmetric in i, j
//   dH_i/dt sum_j g_ij (T_j - T_i)                          W       antisymmetric: energy is conserved
//
// Zero of enthalpy: liquid at 0 degrees. A solid's curve is shifted so that, fully melted, it lies on its
// liquid's curve; a liquid that can freeze has the very curve of its solid. The switch of phase therefore
// changes no number but the tag.
#pragma once

#include "meltsim/physics/diffusion.hpp"
#include "meltsim/physics/material_table.hpp"
#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// k = K rho c [W/(m K)].
inline double conductivity_of(double diffusivity, double density, double heat_capacity) {
  return diffusivity * density * heat_capacity;
}
/// Diffusivity of a material [m^2/s].
inline double diffusivity_of(double conductivity, double density, double heat_capacity) {
  return conductivity / (density * heat_capacity);
}

/// T(h) of a material: solid slope, melting - a plateau of width L, or a slope where it has a range -, liquid slope.
template <class T>
MELTSIM_HD double temperature_of(const MaterialRow<T>& m, double h) {
  if (m.tables != nullptr && m.tables->curve.nodes != 0u) return curve_temperature(m.tables->curve, h);
  if (m.plateau == 0u) return h / m.heat_capacity;
  const double above = h - m.melting_enthalpy;
  if (above < 0.0) return m.melting_point + above / m.heat_capacity;
  if (above <= m.melting_heat) return m.melting_point + m.melting_slope * above;
  return m.melting_point + m.melting_range + (above - m.melting_heat) / m.liquid_heat_capacity;
}

/// h(T) [J/kg]; at a melting point without a range that of the whole solid for a solid, of the whole liquid for a liquid.
template <class T>
MELTSIM_HD double enthalpy_of(const MaterialRow<T>& m, double temperature) {
  const bool liquid_at_point = m.freezes != 0u && temperature == m.melting_point && m.melting_range == 0.0;
  if (liquid_at_point) return m.melting_enthalpy + m.melting_heat;
  if (m.tables != nullptr && m.tables->curve.nodes != 0u) return curve_enthalpy(m.tables->curve, temperature);
  if (m.plateau == 0u) return m.heat_capacity * temperature;
  const double above = temperature - m.melting_point;
  if (above <= 0.0) return m.melting_enthalpy + above * m.heat_capacity;
  if (above < m.melting_range) return m.melting_enthalpy + above / m.melting_range * m.melting_heat;
  return m.melting_enthalpy + m.melting_heat + (above - m.melting_range) * m.liquid_heat_capacity;
}

/// Share of the melting heat taken up, 0..1. With none it jumps to 1 at the melting point, which is the
/// paper's criterion T >= T_melt.
template <class T>
MELTSIM_HD double liquid_fraction(const MaterialRow<T>& m, double h) {
  if (m.plateau == 0u) return 1.0;
  const double above = h - m.melting_enthalpy;
  if (m.melting_heat <= 0.0) return above >= 0.0 ? 1.0 : 0.0;
  return clamp(above / m.melting_heat, 0.0, 1.0);
}

/// k [W/(m K)] at a liquid fraction and temperature, interpolated linearly in the fraction: for exchange with
/// surfaces and walls. Exchange between particles uses conductivity_toward.
template <class T>
MELTSIM_HD T conductivity_at(const MaterialRow<T>& m, T fraction, T temperature) {
  T own = m.conductivity, liquid = m.liquid_conductivity;
  if (m.tables != nullptr) {
    if (m.tables->conductivity.points != 0u) own = property_at(m.tables->conductivity, temperature);
    if (m.tables->liquid_conductivity.points != 0u)
      liquid = property_at(m.tables->liquid_conductivity, temperature);
  }
  return m.plateau == 0u ? own : own + fraction * (liquid - own);
}

/// k [W/(m K)] toward neighbours of a particle that can change phase: the mean over the temperatures between both particles,
/// solid below the melting point and liquid above it (Kirchhoff's transform). A particle at the melting point conducts as
/// liquid toward hotter neighbours and as solid toward colder ones, because that phase lies between its front and them; the
/// front crosses the cell while it takes up latent heat, so its mean distance from the neighbour is one spacing. The flux is
/// continuous in both temperatures where melting begins and ends, so the stages of a super-step may follow them.
/// Deviation: with a melting range k changes in its middle instead of along it, which conducts the same across the whole of it.
template <class T>
struct TowardNeighbour {
  T solid{}, liquid{};  ///< k of the phases [W/(m K)]
  T melting_point{};    ///< of the particle, in the middle of a range [degrees Celsius]
  T temperature{};      ///< of the particle [degrees Celsius]
  MELTSIM_HD T operator()(T neighbour) const {  ///< k toward a neighbour of this temperature
    const T above = maximum(temperature, neighbour) - melting_point,
            below = melting_point - minimum(temperature, neighbour);
    if (!(above > T(0))) return solid;
    if (!(below > T(0))) return liquid;
    return (above * liquid + below * solid) / (above + below);
  }
};
/// The same for a material at a temperature.
template <class T>
MELTSIM_HD TowardNeighbour<T> toward_neighbour(const MaterialRow<T>& m, T temperature) {
  return {conductivity_at(m, T(0), temperature), conductivity_at(m, T(1), temperature),
          static_cast<T>(m.melting_point + 0.5 * m.melting_range), temperature};
}
/// k toward a neighbour [W/(m K)].
template <class T>
MELTSIM_HD T conductivity_toward(const MaterialRow<T>& m, T temperature, T neighbour) {
  return toward_neighbour(m, temperature)(neighbour);
}

/// 1/k [m K/W]: infinite for an insulator.
template <class T>
MELTSIM_HD T resistivity_of(T conductivity) {
  return T(1) / conductivity;
}

/// Share of the conduction along a surface that the pair sum gives [-], and the correction for it.
///
/// In direction e the sum over neighbours gives the conduction times the moment M_e = sum_j V_j L_ij (x_ij.e)^2 / 2,
/// which is 1 inside and less where neighbours are missing. Along a plane, an edge, a sheet or a bar of the lattice
/// M = 1 - slope (1 - phi) within 1 % for H from 1.5 to 4 dx, where phi = sum_j V_j W_ij is the filled share of the
/// surroundings, down to a row of single particles. The conductivity of the particle is divided by M:
/// pairs stay symmetric and g_ij >= 0, so energy is conserved and no new extreme arises. Across the surface half of
/// the moment is missing, which insulates it; there the correction adds 3 % to the exchange of the outermost two
/// layers. Walls at a held temperature count as filled, because their exchange (wall_exchange.hpp) is calibrated for
/// uncorrected sums; others as far as they conduct (filled_by_wall), other matter likewise (filled_by). Ours.
template <class T>
struct ConductionShare {
  T slope{};  ///< (1 - M) / (1 - phi) of the first lattice layer beneath a plane, along it [-]
};

/// Least share: that of nearly isolated particles is not corrected further.
inline constexpr double least_conduction_share = 0.05;

/// M along a surface [-] at a given phi.
template <class T>
MELTSIM_HD T conduction_share(const ConductionShare<T>& c, T phi) {
  return clamp(T(1) - c.slope * (T(1) - phi), T(least_conduction_share), T(1));
}

/// Makes the slope for H = support on a lattice of spacing dx (host).
template <class T>
inline ConductionShare<T> make_conduction_share(double support, double spacing) {
  const auto k = make_kernel<double>(support, spacing);
  const double volume = spacing * spacing * spacing;
  const int n = static_cast<int>(support / spacing) + 1;
  double moment = 0, phi = 0;  // of the half lattice beyond the plane
  for (int x = 1; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z) {
        const double r2 = spacing * spacing * double(x * x + y * y + z * z), r = std::sqrt(r2);
        phi += kernel_value(k, r) * volume;
        moment += 0.5 * kernel_laplacian(k, r, r2) * volume * (spacing * spacing * double(y * y));
      }
  return {static_cast<T>(moment / phi)};
}

/// Whether two materials, of these indices, are one, or phases of each other.
template <class T>
MELTSIM_HD bool same_matter(const MaterialRow<T>& a, std::size_t index_a, const MaterialRow<T>& b,
                            std::size_t index_b) {
  if (index_a == index_b) return true;
  return (a.melts != 0u && a.liquid == index_b) || (a.freezes != 0u && a.solid == index_b) ||
         (b.melts != 0u && b.liquid == index_a) || (b.freezes != 0u && b.solid == index_a);
}

/// How much of a neighbour that is other matter counts as filled [-]: the share of what own matter would pass in its place, 1 where it conducts as
/// well or better. Pairs take the harmonic mean, so that beside an insulator a body lacks neighbours as it does at a free surface.
/// Phases of one matter count whole, as fronts between them are calibrated (phase.bodies). Ours.
template <class T>
MELTSIM_HD T filled_by(T own, T other) {
  return own > other ? T(2) * other / (own + other) : T(1);
}

/// Harmonic mean of two conductivities [W/(m K)] from their resistivities: 0 if either end insulates.
template <class T>
MELTSIM_HD T pair_conductivity(T resistivity_i, T resistivity_j) {
  return T(2) / (resistivity_i + resistivity_j);
}

/// Paper mode, eq. (4): the backward Euler step of the isolated pair (i, j), seen from i.
///   k = (K_i + K_j)/2 L_ij,  D = (T_j - T_i)/(1 + k dt (V_i + V_j)),  T_i += k dt V_j D.
/// Deviation: eq. (4) prints K_i + K_j; with L_ij as defined here (factor 2 included) half of it makes K the
/// diffusivity [m^2/s] that the scheme tends to for small dt. Returns the change of T_i.
template <class T>
MELTSIM_HD T paper_pair_update(T K_i, T K_j, T laplacian, T dt, T volume_i, T volume_j, T temperature_i,
                               T temperature_j) {
  const T k = T(0.5) * (K_i + K_j) * laplacian * dt;
  return k * volume_j * (temperature_j - temperature_i) / (T(1) + k * (volume_i + volume_j));
}

/// The explicit scheme with which the paper compares: dT_i/dt = sum_j (K_i + K_j)/2 V_j L_ij (T_j - T_i),
/// Euler's step. Iwasaki et al. (2010), Comput. Graph. Forum 29:2215; theirs has the SPH Laplacian of the
/// day, here L. Stable while dt sum_j of this is at most 1 (a convex combination of old temperatures).
/// Returns the rate per degree [1/s].
template <class T>
MELTSIM_HD T explicit_pair_rate(T K_i, T K_j, T laplacian, T volume_j) {
  return T(0.5) * (K_i + K_j) * laplacian * volume_j;
}

/// Diffusivity [m^2/s] that paper mode delivers on the lattice at a step dt when K is asked for (host): one
/// sweep over dt/2 leaves T_i = sum w_j T_j with weights from the running update, so a parabola spreads by
/// sum w_j r_j^2 / 6 per dt/2. Tends to K as K dt/dx^2 -> 0; an upper
/// bound while the profile has jumps.
inline double paper_effective_diffusivity(double K, double dt, double support, double spacing) {
  if (!(K > 0) || !(dt > 0)) return K;
  const auto kernel = make_kernel<double>(support, spacing);
  const double volume = spacing * spacing * spacing;
  const int n = static_cast<int>(support / spacing) + 1;
  double spread = 0;  // sum w_j r_j^2 so far; each further neighbour reduces it by its share
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        const double r2 = spacing * spacing * double(x * x + y * y + z * z), r = std::sqrt(r2);
        if (r >= support || r2 == 0) continue;
        const double share =
            paper_pair_update(K, K, kernel_laplacian(kernel, r, r2), 0.5 * dt, volume, volume, 0.0, 1.0);
        spread += share * (r2 - spread);
      }
  return spread / (6.0 * 0.5 * dt);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
