// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "meltsim/handle.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

/// A property at one temperature. Between points a property is linear, beyond the first and last constant.
struct PropertyPoint {
  double temperature = 0;  ///< [degrees Celsius]
  double value = 0;        ///< [unit of the property]
};

/// Most species of a World: materials that dissolve in another.
inline constexpr int most_species = 3;

/// How much of a species a liquid holds.
struct MassFraction {
  MaterialId material;  ///< of the species: one with `dissolves_in`
  /// Mass of it per mass of the mixture, 0..MaterialDesc::solubility; with solubility_points up to the largest of them, which
  /// is a supersaturated solution at other temperatures.
  double value = 0;
};

/// A substance. The same description serves liquids and solids: a solid ignores the viscosity, a liquid the
/// melting and lattice fields.
struct MaterialDesc {
  std::string name = "water";  ///< for messages and tables
  /// Rest density rho0 [kg/m^3], > 0; validated for 100..10000. Of a solid at most 4 times that of the liquid it melts into,
  /// unless heat stands still.
  double density = 1000;
  /// Dynamic viscosity mu [Pa s], >= 0. Of a species: what it counts in a mixture, ln mu = sum of w_k ln mu_k.
  /// With a flow_index other than 1 or a yield_stress: the consistency K [Pa s^n].
  double viscosity = 1e-3;
  double conductivity = 0.6;    ///< k [W/(m K)], > 0
  double heat_capacity = 4186;  ///< c [J/(kg K)], > 0
  /// Thermal diffusivity K [m^2/s], >= 0 (the paper's K). If set, k = K rho c replaces `conductivity`; 0 insulates.
  std::optional<double> diffusivity;

  // Temperature-dependent properties: 2..8 points in ascending order replace the constant above.
  std::vector<PropertyPoint> conductivity_points;   ///< k [W/(m K)]
  std::vector<PropertyPoint> heat_capacity_points;  ///< c [J/(kg K)]
  std::vector<PropertyPoint> viscosity_points;      ///< mu [Pa s]; liquids
  std::vector<PropertyPoint> density_points;  ///< rho0 [kg/m^3]; liquids: buoyancy; `density` is the scale

  /// T_melt [degrees Celsius]; infinity = never melts. Needs `melts_into`.
  double melting_point = infinity;
  /// [K], >= 0: it melts from melting_point on and is wholly molten so much above it, the liquid fraction linear in the
  /// temperature between the two, as alloys, fats, waxes and glass do. It stays a body until all of it has melted, and liquid that
  /// freezes joins a body when none of it is liquid; 0: both at the melting point.
  double melting_range = 0;
  double latent_heat = 0;  ///< L [J/kg], >= 0: what melting takes beside warming
  MaterialId melts_into;   ///< the liquid this solid becomes; null = never melts
  /// Whether its liquid freezes onto it below the melting point: liquid that has released its latent heat joins a
  /// free site of the lattice of a body of this material.
  bool freezes = false;

  // A liquid whose viscosity depends on the shear rate gd (Herschel & Bulkley): mu = K gd^(n-1) + tau_y (1 - exp(-m gd))/gd.
  // K is `viscosity`; viscosity_points make it depend on temperature. Not of a solid that melts: give it to its liquid.
  /// Yield stress tau_y [Pa], >= 0: below it the liquid hardly flows. Ketchup 15, mayonnaise 80; 0: none.
  double yield_stress = 0;
  /// tau_y [Pa], >= 0, over temperature: 2..8 points in ascending order replace yield_stress. A liquid that is solid-like when
  /// it is cold, as butter and wax are, has a yield stress that falls to 0.
  std::vector<PropertyPoint> yield_stress_points;
  /// n, 0.1..3: below 1 the liquid thins as it is sheared, above 1 it thickens. For n > 1 shear rates count at most c/(10 dx), c
  /// the sound speed.
  double flow_index = 1;
  /// m [s], > 0 where yield_stress or flow_index is given (Papanastasiou 1987): at shear rates below 1/m what does not yield creeps
  /// as a liquid of viscosity tau_y m + K m^(1-n), which the sub-step or the stages of implicit viscosity have to bear.
  double regularisation = 100;

  // A species: a body of it dissolves, or, where solubility is 1, it is a liquid that mixes with any amount of its solvent.
  // What is dissolved is a content of the solvent's particles (FluidDesc::fractions), which diffuses between them. Needs
  // `diffusivity_in`; excludes melts_into. At most most_species materials of a World.
  /// The solvent, a liquid that nothing freezes from; null = it does not dissolve. A body of it has the heat capacity of the
  /// solvent, and so has what is dissolved.
  MaterialId dissolves_in;
  /// w_s: mass fraction of the saturated solution, (0, 1]; below 1 for bodies, which dissolve down to it. Sugar in water 0.67.
  double solubility = 1;
  /// w_s over temperature, each in (0, 1): 2..8 points in ascending order replace solubility. A body dissolves down to w_s at
  /// its own temperature; liquid that holds more than w_s gives what is too much to bodies of the species beside it
  /// (precipitation), and becomes a part of them where a site of their lattice is free (SolidDesc::growth adds sites).
  std::vector<PropertyPoint> solubility_points;
  double diffusivity_in = 0;  ///< D in the solvent [m^2/s], > 0. Salt in water 1.6e-9, sugar 5e-10.
  /// Heat that a body takes up as it dissolves [J/kg]; negative: it gives heat off. Needs HeatModel::enthalpy, else it has no
  /// effect. Salt in water 6.7e4. Nothing is cooled below 0 K by it: what has no heat left waits for some
  /// (StepResult::cooled_to_zero).
  double heat_of_solution = 0;
  /// k [m/s], > 0: where the layer of liquid at a dissolving body is thinner than the spacing, a body of the material loses
  /// k rho (w_s - w) per area and time to liquid of content w beside it, whatever D is. Empty: diffusion over one spacing.
  std::optional<double> transfer_coefficient;

  int region_half_width = 2;  ///< w, half-width of regions in spacings, 0..8; 0: free particles
  /// alpha of shape matching, (0, 1]: E = density stiffness w(w+1)/3 (dx/dt_s)^2, where dt_s = courant H / c (less if a body
  /// may stand on one of less than a quarter of its density, or lie in liquid of more than twice its density) does not depend
  /// on the sub-step. At the default H and Courant
  /// number dx/dt_s = c: sound is about as fast in the body as in the liquid; a larger sound_speed makes it stiffer.
  double stiffness = 1.0;
  /// Young's modulus E [Pa], >= 0; 0: `stiffness` holds. A value above 0 replaces `stiffness`. Regions are widened from
  /// region_half_width (at least 1) up to 8 until they carry E at the World's largest sub-step (stable_dt without
  /// speeds). If width 8 does not suffice, E > 24 density (spacing/dt)^2, or one that holds all of a body n sites long,
  /// E > n^2/pi^2 density (spacing/dt)^2, the body gets that limit,
  /// StepResult::modulus_unreachable is set, and Resolved::stiffness holds the value delivered. The cost of regions grows
  /// as (2w+1)^3; a larger sound_speed, and so a shorter sub-step, is the cheaper way to a stiff body.
  /// In a scene with liquid, a movable body has at least half-width 1 and E = density c^2/2, or (density of the liquid - 1.5 density)
  /// c^2 if that is more, whatever the values here:
  /// the coupling does no work on a body that keeps its shape, and a softer body would gain energy. If that
  /// raises E, StepResult::body_stiffened is set. A smaller sound_speed lowers that bound.
  double youngs_modulus = 0;
  /// Share of non-rigid motion removed per region in the time dt_s, [0, 1]. At least 0.11 stiffness^1.5 is used (with a
  /// modulus, of the stiffness at the largest sub-step), so that sub-steps of changing length add no energy.
  double damping = 0.1;
  /// Surface tension of a liquid [N/m], >= 0; water has 0.072. 0: it neither coheres nor wets. The sub-step gets shorter: the
  /// sound speed becomes at least 7 sqrt(surface_tension/(density spacing)), and one that is set must be no less. The
  /// interface of two liquids has the difference of their tensions. Measured at a support_radius of 2.5 spacings.
  double surface_tension = 0;
  /// Angle at which liquids with surface tension meet a solid of this material [degrees], 0..180, measured through the liquid:
  /// 0 wets, 90 is neutral, 180 repels.
  double contact_angle = 90;
  double friction = 0.3;  ///< Coulomb coefficient, >= 0; mean of two bodies, smaller of body and wall
};

}  // namespace v0
}  // namespace meltsim
