// SPDX-License-Identifier: Apache-2.0
// Species: what dissolves in a liquid and diffuses in it. Pairs exchange it as diffusion.hpp says.
//
// Sources: diffusion by Fick's law with the mass fraction as potential (mass-averaged frame: two particles exchange equal masses,
// so that their masses stay constant): Bird, Stewart & Lightfoot, Transport Phenomena, 2nd ed. (2002), table 17.8-2.
// Dissolving is the enthalpy method of melting (Voller & Cross 1981) with the content in place of the enthalpy. Viscosity of a
// mixture: Arrhenius (1887), Z. Phys. Chem. 1:285.
//
//   symbol  meaning                                         unit
//   S       content of a particle                           kg      (double: a step may change it by 1e-9 of itself)
//   m       mass of the particle, constant                  kg
//   w       S / m                                           -
//   w_s     mass fraction of the saturated solution         -       a constant, or a table over temperature
//   u       w of liquid, min(w, w_s) of crystals            -
//   R       1/(rho D), rho of the solution                  m s/kg
//   g_ij    V_i V_j L_ij 2 / (R_i + R_j)                    kg/s    bitwise symmetric in i, j
//   r       1 - w of crystals: room for more                -
//           across a front: across_front() for R_i + R_j
//   dS_i/dt sum_j g_ij (u_j - u_i)                          kg/s    antisymmetric: the species is conserved
//   V0      S/rho_s + (m - S)/rho_w: volume at rest         m^3
//   q       (S - w_s m)/(1 - w_s): what is not dissolved    kg
//
// A particle of a body is a plateau: it gives its species off at w_s until its content is down to w_s. It then leaves the
// lattice, and no number changes but its tag.
//
// Precipitation, where w_s depends on temperature: liquid that holds more than w_s(T) and lies beside a body of the species is
// crystals, too. It is a plateau as the body is, takes in what liquid farther off holds beyond w_s, and joins the lattice by the
// rule of freezing once 0.95 of it is crystal. A pair gives crystals at most g_ij r_i, so that none holds more
// than its mass: the sum of g_ij tau is at most m. Liquid away from bodies stays supersaturated: nothing nucleates. The drive is
// w, not w/w_s, within liquid of varying temperature, too: Fick's law. The saturation of a body is that at its own
// temperature, which is what a crystal in a gradient of temperature dissolves and grows by.
//
// Heat of solution cools what dissolves. At 0 K nothing dissolves any more, and where growth takes heat nothing grows: limit_by_heat().
//
// Time: explicit steps, of which a new w is a weighted mean of old ones while tau sum_j g_ij/m_i <= 1: no content leaves the
// range of those around it. Runge-Kutta-Legendre stages of first order would not keep that: two of them weigh the particle's
// own value by 1 - q + q^2/6 plus what comes back by way of neighbours, q = tau sum_j g_ij/m_i, which is below 0 from
// q = 1.3 on (on a chain of particles, for which their monotony is proven, half of q^2/6 comes back; among 60 neighbours a
// sixtieth). Species diffuse so slowly that one step is enough in nearly all scenes.
//
// Deviations: volumes of solvent and solute add up. The heat capacity is the solvent's whatever the content, and diffusion
// carries no enthalpy. D does not depend on temperature. Species do not hinder each other. With a table, q counts with the
// largest w_s, in bodies and liquid alike: a function of the content alone, so that nothing jumps where a particle joins or leaves a
// lattice or its temperature changes. Heat of solution is exact over a cell that dissolves or grows; what a cell takes
// in or gives off between w_s at its temperature and the largest w_s has none.
#pragma once

#include "meltsim/physics/diffusion.hpp"
#include "meltsim/physics/elementary.hpp"
#include "meltsim/physics/math.hpp"
#include "meltsim/physics/property_table.hpp"
#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// A species, as formulas need it.
template <class T>
struct SpeciesRow {
  std::uint32_t solute{}, solvent{};  ///< material indices
  double solubility{};                ///< w_s; the largest of a table
  double volume{};                    ///< 1/rho_s [m^3/kg]
  double solvent_volume{};            ///< 1/rho_w [m^3/kg], at the solvent's nominal density
  double diffusivity{};               ///< D [m^2/s]
  double heat_of_solution{};          ///< [J/kg]; 0 where heat is not computed
  double log_viscosity{};             ///< ln mu of the species [mu: Pa s]; -infinity of one without viscosity
  T surface_resistivity{};  ///< R_i + R_j of a pair of body and liquid where a transfer coefficient is given [m s/kg]; else 0
  PropertyTable<double> saturation{};  ///< w_s over temperature [degrees Celsius]; no points: `solubility`
};

/// Whether w_s depends on temperature, so that the species precipitates.
template <class T>
MELTSIM_HD bool precipitates(const SpeciesRow<T>& s) {
  return s.saturation.points != 0u;
}

/// w_s [-] at a temperature [degrees Celsius].
template <class T>
MELTSIM_HD double saturation_at(const SpeciesRow<T>& s, double temperature) {
  return precipitates(s) ? property_at(s.saturation, temperature) : s.solubility;
}

/// Distance from a particle of a body, in spacings, within which supersaturated liquid is beside the body: more than the
/// diagonal of a face of the lattice's cells, less than two cells.
inline constexpr double crystal_reach = 1.5;

/// Share of a particle that is crystal when it joins the lattice beside it [-]: all of it but for what its room leaves slowly.
inline constexpr double crystal_share = 0.95;

/// Whether supersaturated liquid beside a body joins its lattice; w: its content.
MELTSIM_HD bool crystallises(double w, double saturation) {
  return w >= saturation + crystal_share * (1.0 - saturation);
}

/// r: what crystals of content w may take in, per mass [-].
MELTSIM_HD double crystal_room(double w) { return maximum(1.0 - w, 0.0); }

/// What drives a pair, u_j - u_i, as far as the one that takes has room [-]; bitwise antisymmetric.
template <class T>
MELTSIM_HD T limited_drive(T u_i, T room_i, T u_j, T room_j) {
  return maximum(minimum(u_j - u_i, room_i), -room_j);
}

/// Volume at rest [m^3] of what is not solvent, per mass of it 1/rho_s.
template <class T>
MELTSIM_HD double dissolved_volume(const SpeciesRow<T>& s, double content) {
  return content * s.volume;
}

/// 1/rho [m^3/kg] of a solution of mass fraction w, at the solvent's nominal density.
template <class T>
MELTSIM_HD double solution_volume(const SpeciesRow<T>& s, double w) {
  return s.solvent_volume + w * (s.volume - s.solvent_volume);
}

/// u: what drives the exchange [-].
MELTSIM_HD double solute_potential(double w, double saturation, bool crystal) {
  return crystal ? minimum(w, saturation) : w;
}

/// 1/(rho D) [m s/kg] of liquid of mass fraction w.
template <class T>
MELTSIM_HD double solute_resistivity(const SpeciesRow<T>& s, double w) {
  return solution_volume(s, w) / s.diffusivity;
}

/// R_i + R_j [m s/kg] of crystals of content w and a neighbour one spacing away: (1 + 2 f)/(rho D), f the dissolved share of the
/// crystals' cell. The front has crossed that share, so it is 1/2 + f spacings from the neighbour's centre.
template <class T>
MELTSIM_HD double front_resistivity(const SpeciesRow<T>& s, double w, double saturation) {
  const double f = saturation < 1.0 ? minimum(maximum((1.0 - w) / (1.0 - saturation), 0.0), 1.0) : 0.5;
  return (1.0 + 2.0 * f) * solute_resistivity(s, s.solubility);
}

/// Largest gain of a layer thinner than the spacing [-].
inline constexpr double most_layer_gain = 1.7;
/// Largest sum of g over all neighbours of a particle of a body, over that of liquid [-]: one by itself in fresh liquid, f = 0; the
/// mean of r/(r - dx/2) over the lattice is 1.75 at H = 2.5 dx and less at larger H.
inline constexpr double most_front_exchange = 1.75 * most_layer_gain;

/// What a pair across a front exchanges over what it would if w fell along a straight line from the front to the neighbour's centre
/// [-]. In a layer that starts at the front w is ws erfc(z), and the slope at the front is 2 z/(sqrt(pi) erf z) times that of
/// the line; v = erfc z: the lesser of both potentials over the larger. The fit is within 0.4 % from v = 0.25 on and at most most_layer_gain.
/// Symmetric to the last bit.
template <class T>
MELTSIM_HD T layer_gain(T u_i, T u_j) {
  const T v = maximum(minimum(u_i, u_j), T(0)) / maximum(maximum(u_i, u_j), T(1e-30));
  return minimum(T(most_layer_gain), T(1) + (T(1) - v) * (T(1) - v) / (T(1) + T(3) * std::sqrt(v)));
}

/// R_i + R_j [m s/kg] of a pair across a front at distance r [m], potentials u: 2/(rho D) (r + (f - 1/2) dx)/r over the gain. next: that of
/// crystals at one spacing; saturated: 1/(rho D).
template <class T>
MELTSIM_HD T across_front(T next, T saturated, T spacing, T r, T u_i, T u_j) {
  const T n = minimum(T(1), spacing / r);
  return (n * next + (T(1) - n) * (T(2) * saturated)) / layer_gain(u_i, u_j);
}

/// Whether a particle of a body has given off what it can: its content is down to saturation.
MELTSIM_HD bool is_dissolved(double content, double mass, double saturation) {
  return content <= saturation * mass;
}

/// q [kg]: what of a particle is not dissolved; of a body of saturated solution around crystals. Liquid has some only of
/// a species that precipitates.
template <class T>
MELTSIM_HD double undissolved(const SpeciesRow<T>& s, double content, double mass, bool solid) {
  const double above = content - s.solubility * mass;
  return (solid || precipitates(s)) && above > 0.0 ? above / (1.0 - s.solubility) : 0.0;
}

/// What a particle drives the exchange with [-].
struct SoluteDrive {
  double potential{};  ///< u
  double room = 1;     ///< r
};

/// Lowers u, or r where growth takes heat, so that no sweep cools a particle below 0 K by its heat of solution: pairs count
/// what is left at both ends, so that no heat comes from nothing. What gives off less takes in nothing either, since it is no less
/// soluble. heat: above 0 K [J/kg]; share: the largest of its mass that a particle exchanges in a sweep [-]. Returns whether its
/// heat lasts without.
template <class T>
MELTSIM_HD bool limit_by_heat(const SpeciesRow<T>& s, double w, bool solid, double heat, double share,
                              SoluteDrive& drive) {
  if (s.heat_of_solution == 0.0 || !(solid || precipitates(s))) return true;
  const double cost =
      std::fabs(s.heat_of_solution) / (1.0 - s.solubility);  // of what is given off or grows [J/kg]
  const double lasting = maximum(heat, 0.0) / (cost * share), above = w - s.solubility;
  if (s.heat_of_solution < 0.0) {
    const double most = maximum(-above, 0.0) + lasting;
    if (most >= drive.room) return true;
    drive.room = most;
    return false;
  }
  if (above * cost <= heat || lasting >= drive.potential) return true;
  drive = {lasting, 0.0};
  return false;
}

/// Viscosity of a mixture, species by species: ln mu = sum_k w_k ln mu_k, the solvent's share the rest.
struct MixtureViscosity {
  double logarithm = 0, rest = 1;  ///< sum so far; mass fraction that is left for the solvent
  /// Adds a species of mass fraction w.
  template <class T>
  MELTSIM_HD void add(const SpeciesRow<T>& s, double w) {
    if (!(w > 0.0)) return;
    logarithm += w * s.log_viscosity;
    rest -= w;
  }
  /// mu [Pa s] in a solvent of this viscosity; the very same where nothing is dissolved.
  MELTSIM_HD double with(double solvent) const {
    if (rest == 1.0) return solvent;
    return exponential(logarithm) * (rest > 0.0 ? power(solvent, rest) : 1.0);
  }
};

/// R_i + R_j [m s/kg] of a pair of body and liquid with which a plane face of a body, on the lattice of spacing dx, loses
/// k rho (w_s - w) per area to liquid of content w (host). k: transfer coefficient [m/s]; rho of the saturated solution.
/// The sum over all pairs across a plane, per area: sum over layers n >= 1 of n q_n a/dx, a = 2/(R_i + R_j), q_n dx^2 the sum of
/// V L over the plane n spacings away.
inline double surface_resistivity(double k, double density, double support, double spacing) {
  const auto kernel = make_kernel<double>(support, spacing);
  const double volume = spacing * spacing * spacing;
  const int n = static_cast<int>(support / spacing) + 1;
  double crossing = 0;
  for (int x = 1; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z) {
        const double r2 = spacing * spacing * double(x * x + y * y + z * z);
        crossing += x * kernel_laplacian(kernel, std::sqrt(r2), r2) * volume * spacing * spacing;
      }
  return 2 * crossing / (density * k * spacing);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
