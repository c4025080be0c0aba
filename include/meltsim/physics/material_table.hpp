// SPDX-License-Identifier: Apache-2.0
// One row per material with the values that formulas need, derived by the host in double.
#pragma once

#include "meltsim/physics/property_table.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {
/// A material.
template <class T>
struct MaterialRow {
  T density{};              ///< rho0 [kg/m^3]
  T tait_stiffness{};       ///< rho0 c^2 / 7 [Pa], c the sound speed
  T viscosity{};            ///< mu [Pa s]
  T conductivity{};         ///< k of this phase (with a plateau: of the solid) [W/(m K)]
  T diffusivity{};          ///< k / (rho0 c) of this phase [m^2/s]: K of eq. (4)
  T liquid_conductivity{};  ///< k of the liquid it becomes [W/(m K)]
  double
      heat_capacity{};  ///< c of this phase (with a plateau: of the solid) [J/(kg K)]; the least of a table
  double liquid_heat_capacity{};  ///< c of the liquid it becomes or is [J/(kg K)]; the least of a table
  double melting_point{};         ///< where melting begins [degrees Celsius]
  double melting_range{};         ///< T_l - T_s: how much hotter it is where melting ends [K]
  double melting_enthalpy{};      ///< specific enthalpy at the melting point, still solid [J/kg]
  double melting_heat{};    ///< what melting takes from its beginning to its end [J/kg]: L and what warms it
  double melting_slope{};   ///< melting_range / melting_heat, 0 without a range [K kg/J]
  double latent_heat{};     ///< L [J/kg]; of a liquid that of the solid that melts into it
  double coldest{};         ///< specific enthalpy at 0 K [J/kg]
  T shape_stiffness{};      ///< alpha of shape matching
  T modulus_rate{};         ///< E/(rho0 dx^2) of a given modulus [1/s^2]; 0 = shape_stiffness holds
  T shape_damping{};        ///< share of non-rigid motion removed per step
  T friction{};             ///< Coulomb coefficient
  T tension{};              ///< sigma of a liquid [N/m]
  T cohesion{};             ///< of a liquid: strength of its pair force (surface_tension.hpp) [N/m^7]
  T skin_viscosity{};       ///< of a liquid: viscosity among particles of its surface [Pa s]
  T wetting{};              ///< of a solid: cosine of its contact angle [-]
  std::uint32_t liquid{};   ///< material index it melts into
  std::uint32_t solid{};    ///< material index it freezes into
  std::uint32_t melts{};    ///< 1: a solid that can melt
  std::uint32_t freezes{};  ///< 1: a liquid that can freeze
  std::uint32_t plateau{};  ///< 1: T(h) has a plateau; it melts or freezes
  const MaterialProperties<T>*
      tables{};  ///< properties that depend on temperature or shear rate; null if none does
};

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
