// SPDX-License-Identifier: Apache-2.0
// One row per material, as the formulas need it: derived values already worked out (by the host, in double).
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

template <class T>
struct MaterialRow {
  T density{};                    ///< rho0 [kg/m^3]
  T tait_stiffness{};             ///< rho0 c^2 / 7 [Pa], c the sound speed
  T viscosity{};                  ///< mu [Pa s]
  T conductivity{};               ///< k of this phase [W/(m K)]
  T diffusivity{};                ///< k / (rho0 c) of this phase [m^2/s]: K of eq. (4)
  T liquid_conductivity{};        ///< k of the liquid it becomes [W/(m K)]
  double heat_capacity{};         ///< c of this phase [J/(kg K)]
  double liquid_heat_capacity{};  ///< c of the liquid it becomes [J/(kg K)]
  double melting_point{};         ///< [degrees Celsius]
  double melting_enthalpy{};      ///< specific enthalpy at the melting point, still solid [J/kg]
  double latent_heat{};           ///< L [J/kg]
  T shape_stiffness{};            ///< alpha of shape matching
  T modulus_rate{};               ///< E/(rho0 dx^2) of a given modulus [1/s^2]; 0 = shape_stiffness holds
  T shape_damping{};              ///< share of non-rigid motion removed per step
  T friction{};                   ///< Coulomb coefficient
  std::uint32_t liquid{};         ///< material index it becomes
  std::uint32_t melts{};          ///< 1 when it can melt
};

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
