// SPDX-License-Identifier: Apache-2.0
// Values of fields at points between particles, the level of a liquid along a line, and the flux through a plane.
//
// Source: Shepard, D. (1968), Proc. 23rd ACM Nat. Conf., 517, eq. (1): an average whose weights add up to 1. Level:
// the half value of the smoothed volume fraction, as free surfaces are found in volume-of-fluid methods (Hirt &
// Nichols 1981, J. Comput. Phys. 39:201).
//
//   symbol  meaning                                                               unit
//   A(x)    sum_j W(|x - x_j|) A_j / sum_j W(|x - x_j|), |x - x_j| < H             of A
//   f_L(x)  sum over liquid of V_j [W(|x - x_j|) + sum over images in walls of W]  -
//   f_S(x)  the same over solids                                                  -
//   g(x)    2 f_L + min(f_S, 1/2) - 1                                             -
//   Q       sum over liquid beside the opening of V_j (v_j . n) w(d_j)            m^3/s
//   w(d)    integral of W over a plane at distance d (walls.hpp: plane_share)     1/m
//   d_j     distance of x_j from the plane of the opening, n its normal           m
//
// j runs over all particles for temperature, density and liquid fraction, over liquid for pressure, speed and
// velocity: a solid has no pressure, and counting it as 0 would lower the value at a point beside it.
//
// g > 0 where more of the space is liquid than empty: with the empty share f_0 = 1 - f_L - f_S, f_L > f_0 is equivalent to
// g > 0 if f_S < 1/2. On a flat surface f_L = 1/2 and g = 0, also beside a wall, whose images complete f_L, and beside a
// body, which takes equal shares from liquid and from air. Because of the bound on f_S the inside of a body does not count
// as liquid.
#pragma once

#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/walls.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {
/// Fields that can be sampled.
enum class SampleField : std::uint32_t {
  temperature,
  pressure,
  density,
  speed,
  velocity,
  liquid_fraction,
  solute1,  ///< w of the first species; those of the others follow
  solute2,
  solute3
};
inline constexpr std::uint32_t sample_fields = 9;   ///< number of fields
inline constexpr std::uint32_t sample_species = 3;  ///< number of fields of species
/// w of species k.
MELTSIM_HD constexpr SampleField solute_field(std::uint32_t k) {
  return static_cast<SampleField>(static_cast<std::uint32_t>(SampleField::solute1) + k);
}
/// Bit of a field in a set.
MELTSIM_HD constexpr std::uint32_t sample_bit(SampleField f) { return 1u << static_cast<std::uint32_t>(f); }
/// Number of values of a field.
MELTSIM_HD constexpr std::uint32_t sample_width(SampleField f) {
  return f == SampleField::velocity ? 3u : 1u;
}

/// Values of a particle, as sampling and World::particles() report them.
struct SampledParticle {
  bool liquid = false;                 ///< otherwise solid
  double temperature = 0;              ///< [degrees Celsius]
  double pressure = 0;                 ///< [Pa]; 0 for solids
  double density = 0;                  ///< [kg/m^3]
  double liquid_fraction = 0;          ///< 0 solid .. 1 liquid
  double solute[sample_species] = {};  ///< w of every species, its mass fraction [-]
  Vec3<double> velocity;               ///< [m/s]
};

/// Values of a particle: those of `fields` (bits), pressure and velocity. h [J/kg], phi [-], pressure_term = P/phi^2 [Pa].
template <class T>
MELTSIM_HD SampledParticle sampled(const MaterialRow<T>& m, bool liquid, double h, double mass, double volume,
                                   double phi, double pressure_term, Vec3<double> velocity,
                                   std::uint32_t fields) {
  SampledParticle p;
  p.liquid = liquid;
  p.velocity = velocity;
  const auto asked = [fields](SampleField f) { return (fields & sample_bit(f)) != 0u; };
  if (asked(SampleField::temperature)) p.temperature = temperature_of(m, h);
  // The enthalpy of a material that melts or freezes gives the fraction.
  if (asked(SampleField::liquid_fraction))
    p.liquid_fraction = m.plateau != 0u ? liquid_fraction(m, h) : liquid ? 1.0 : 0.0;
  if (asked(SampleField::density)) p.density = liquid ? phi * mass / volume : static_cast<double>(m.density);
  p.pressure = liquid ? pressure_term * phi * phi : 0.0;
  return p;
}

/// Sums of A(x). Weights are relative: the scale of the kernel cancels.
struct SampleSums {
  double all = 0, liquid = 0;  ///< sums of W over all particles, over liquid
  double temperature = 0, density = 0, liquid_fraction = 0, pressure = 0, speed = 0;  ///< sums of W A
  double solute[sample_species] = {};         ///< sums of W w over liquid
  Vec3<double> velocity;                      ///< sum of W v over liquid
  MELTSIM_HD void add(const SampleSums& o) {  ///< adds other sums
    all += o.all;
    liquid += o.liquid;
    temperature += o.temperature;
    density += o.density;
    liquid_fraction += o.liquid_fraction;
    pressure += o.pressure;
    speed += o.speed;
    for (std::uint32_t k = 0; k < sample_species; ++k) solute[k] += o.solute[k];
    velocity += o.velocity;
  }
  MELTSIM_HD void add(double weight, const SampledParticle& p) {  ///< adds a particle
    all += weight;
    temperature += weight * p.temperature;
    density += weight * p.density;
    liquid_fraction += weight * p.liquid_fraction;
    if (!p.liquid) return;
    liquid += weight;
    pressure += weight * p.pressure;
    speed += weight * length(p.velocity);
    for (std::uint32_t k = 0; k < sample_species; ++k) solute[k] += weight * p.solute[k];
    velocity += p.velocity * weight;
  }
};

/// sum / weights; NaN if the weights are 0.
MELTSIM_HD double average(double sum, double weights) {
  return weights > 0 ? sum / weights : static_cast<double>(NAN);
}

/// A(x); component 0, or 0 to 2 for a velocity. NaN if the weights are 0.
MELTSIM_HD double sampled_value(const SampleSums& s, SampleField field, std::uint32_t component) {
  switch (field) {
    case SampleField::temperature:
      return average(s.temperature, s.all);
    case SampleField::density:
      return average(s.density, s.all);
    case SampleField::liquid_fraction:
      return average(s.liquid_fraction, s.all);
    case SampleField::pressure:
      return average(s.pressure, s.liquid);
    case SampleField::speed:
      return average(s.speed, s.liquid);
    case SampleField::velocity:
      return average(component == 0u   ? s.velocity.x
                     : component == 1u ? s.velocity.y
                                       : s.velocity.z,
                     s.liquid);
    case SampleField::solute1:
      return average(s.solute[0], s.liquid);
    case SampleField::solute2:
      return average(s.solute[1], s.liquid);
    case SampleField::solute3:
      return average(s.solute[2], s.liquid);
  }
  return static_cast<double>(NAN);
}

/// f_L and f_S, divided by the scale of the kernel.
template <class T>
struct FillSums {
  T liquid{}, solid{};                      ///< f_L; f_S
  MELTSIM_HD void add(const FillSums& o) {  ///< adds other sums
    liquid += o.liquid;
    solid += o.solid;
  }
  /// Adds a particle. x_ij: from the particle to the point [m]; walls: those within H of the point.
  MELTSIM_HD void add(const SphKernel<T>& k, const WallView<T>& walls, bool is_liquid, T volume, Vec3<T> x_ij,
                      T r2) {
    T shape = kernel_shape(k, std::sqrt(r2));
    if (walls.axes != 0u) shape += image_shape(k, walls, x_ij, r2);
    if (is_liquid) liquid += volume * shape;
    else solid += volume * shape;
  }
};

/// g(x).
template <class T>
MELTSIM_HD T liquid_excess(const SphKernel<T>& k, const FillSums<T>& s) {
  return T(2) * k.w_scale * s.liquid + minimum(k.w_scale * s.solid, T(0.5)) - T(1);
}

/// Height [m] of the highest place where g falls through 0, from its values at `count` heights `step` apart, the first at
/// `lowest` [m]; g is interpolated linearly. The last height if liquid is there; NaN if there is no liquid.
template <class T>
MELTSIM_HD double level_of(const T* g, std::uint32_t count, double lowest, double step) {
  constexpr std::uint32_t together = 8;  // values are loaded together, so that their latencies overlap
  T above = 0;
  for (std::uint32_t end = count; end > 0u; end -= end < together ? end : together) {
    T below[together];
    for (std::uint32_t n = 0; n < together; ++n) below[n] = n < end ? g[end - 1u - n] : T(0);
    for (std::uint32_t n = 0; n < together; ++n) {
      const T here = below[n];
      if (here > T(0)) {
        const std::uint32_t k = end - 1u - n;
        const double part = k + 1u == count ? 0.0 : static_cast<double>(here / (here - above));
        return lowest + step * (static_cast<double>(k) + part);
      }
      above = here;
    }
  }
  return static_cast<double>(NAN);
}

/// A disc or a rectangle through which liquid flows; in stored coordinates.
template <class T>
struct Opening {
  Vec3<T> normal{}, along{}, across{};  ///< unit vectors at right angles
  T radius{};                           ///< of a disc [m]; 0: a rectangle
  T half_along{}, half_across{};        ///< half sides of a rectangle [m]
};

/// Weight [1/m] of a particle at x, relative to the centre of the opening, in the flux through it: w(d) if its projection
/// on the plane lies inside, otherwise 0.
template <class T>
MELTSIM_HD T opening_share(const SphKernel<T>& k, const Opening<T>& o, Vec3<T> x) {
  const T d = std::fabs(dot(x, o.normal)), u = dot(x, o.along), v = dot(x, o.across);
  if (!(d < k.support)) return T(0);
  const bool inside = o.radius > T(0) ? u * u + v * v < o.radius * o.radius
                                      : std::fabs(u) < o.half_along && std::fabs(v) < o.half_across;
  return inside ? plane_share(k, d) : T(0);
}

/// Sums of a force, heat or flux: forces on particles at their places, or amounts.
struct LoadSums {
  Vec3<double> force, moment;  ///< [N], [N m] about the point that places are relative to
  Vec3<double> first;          ///< sum of mass times place [kg m]
  double mass = 0;             ///< [kg]
  double amount[2] = {};       ///< heat; or mass and volume per second
  MELTSIM_HD void add(double m, Vec3<double> place, Vec3<double> f) {  ///< adds a force f at a place
    force += f;
    moment += cross(place, f);
    first += place * m;
    mass += m;
  }
  /// Moment about the centre of mass; 0 without a particle.
  MELTSIM_HD Vec3<double> moment_about_center() const {
    return mass > 0 ? moment - cross(first * (1 / mass), force) : Vec3<double>{};
  }
  MELTSIM_HD static LoadSums combine(LoadSums a, const LoadSums& b) {  ///< sum of both
    a.force += b.force;
    a.moment += b.moment;
    a.first += b.first;
    a.mass += b.mass;
    a.amount[0] += b.amount[0];
    a.amount[1] += b.amount[1];
    return a;
  }
};

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
