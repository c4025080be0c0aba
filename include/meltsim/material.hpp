// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "meltsim/handle.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

/// A property at one temperature. Between points a property is linear, beyond the ends constant.
struct PropertyPoint {
  double temperature = 0;  ///< [degrees Celsius]
  double value = 0;        ///< in the unit of the property
};

/// What a substance is. The same description serves liquids and solids; a solid ignores the viscosity,
/// a liquid the melting and lattice fields.
struct MaterialDesc {
  std::string name = "water";
  double density = 1000;        ///< rest density rho0 [kg/m^3], > 0; tuned for 100..10000
  double viscosity = 1e-3;      ///< dynamic viscosity mu [Pa s], >= 0
  double conductivity = 0.6;    ///< k [W/(m K)], > 0
  double heat_capacity = 4186;  ///< c [J/(kg K)], > 0
  /// Thermal diffusivity K [m^2/s], >= 0 (the paper's K); when set, k = K rho c and 0 insulates.
  std::optional<double> diffusivity;

  // Properties that depend on temperature: 2..8 points in ascending order replace the constant above.
  std::vector<PropertyPoint> conductivity_points;   ///< k [W/(m K)]
  std::vector<PropertyPoint> heat_capacity_points;  ///< c [J/(kg K)]
  std::vector<PropertyPoint> viscosity_points;      ///< mu [Pa s]; liquids
  std::vector<PropertyPoint> density_points;  ///< rho0 [kg/m^3]; liquids: buoyancy. `density` sets the scale

  /// T_melt [degrees Celsius]; infinity = never melts. Needs `melts_into`.
  double melting_point = infinity;
  double latent_heat = 0;  ///< L [J/kg], >= 0
  MaterialId melts_into;   ///< the liquid this solid becomes; null = never melts
  /// Its liquid freezes onto it below the melting point: liquid that has given off the latent heat takes a
  /// free site of the lattice of a body of this material.
  bool freezes = false;

  int region_half_width = 2;  ///< w of lattice shape matching, 0..8; larger is stiffer (0 = free particles)
  /// alpha of shape matching, (0, 1]: E = density stiffness w(w+1)/3 (dx/dt_s)^2 with dt_s = courant H / c of the
  /// World, less where a body may stand on one of less than a quarter of its density, whatever sub-steps are taken. At the default H and Courant number dx/dt_s is c: the body carries sound
  /// about as fast as the liquid, and a larger WorldDesc::sound_speed makes it stiffer.
  double stiffness = 1.0;
  /// Young's modulus E [Pa], >= 0; 0 = `stiffness` holds. Above 0 it replaces `stiffness`; regions are widened, from
  /// region_half_width (then at least 1) up to 8, until they carry E at the World's largest sub-step (stable_dt without
  /// speeds). What is out of reach at width 8, E > 24 density (spacing/dt)^2, stays at that:
  /// StepResult::modulus_unreachable says so, Resolved::stiffness what is delivered. Wide regions are slow, the cost
  /// goes as (2w+1)^3: a larger sound_speed, and so a shorter sub-step, is the cheaper way to a stiff body.
  /// Where there is liquid a body that can move has at least E = density c^2/2 and half-width 1, whatever was asked for:
  /// the coupling's forces do no work on what keeps its shape, and energy comes of softer bodies. Then
  /// StepResult::body_stiffened is set. A smaller sound_speed lowers that bound.
  double youngs_modulus = 0;
  /// Share of non-rigid motion removed per region in the time dt_s, [0, 1]. Never less than 0.11 stiffness^1.5 (with a
  /// modulus, of the stiffness at the largest sub-step): what keeps sub-steps of changing length from adding energy.
  double damping = 0.1;
  double friction = 0.3;  ///< Coulomb coefficient against bodies and walls, >= 0
};

}  // namespace v0
}  // namespace meltsim
