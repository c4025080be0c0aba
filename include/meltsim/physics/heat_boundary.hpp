// SPDX-License-Identifier: Apache-2.0
// Heat through walls, the dry surface of solids and the free surface of liquids.
//
// Sources: Newton's law of cooling and the Stefan-Boltzmann law, e.g. Incropera & DeWitt (2007), Fundamentals
// of Heat and Mass Transfer, secs. 1.2, 3.1 (resistances in series), 13.3 (large grey surroundings).
//
//   symbol  meaning                                                  unit
//   a       surface area that a particle serves                      m^2
//   d       depth of the particle beneath the surface                m
//   k       conductivity of the particle                             W/(m K)
//   q       flux into the surface                                    W/m^2
//   h       film coefficient of convection                           W/(m^2 K)
//   eps     emissivity                                               -
//   sigma   Stefan-Boltzmann constant                                W/(m^2 K^4)
//   T_s     temperature of the surface, T_a of the surroundings      degrees Celsius; K in fourth powers
//
//   held temperature:  a k/d (T_s - T)
//   otherwise:         a k/d (T_s - T) with T_s where the surface, which holds no heat, gives on what it gets:
//                      k/d (T_s - T) = q + h (T_a - T_s) + eps sigma (T_a^4 - T_s^4)
#pragma once

#include "meltsim/physics/elementary.hpp"
#include "meltsim/physics/neighbour_mask.hpp"
#include "meltsim/physics/wall_exchange.hpp"
#include "meltsim/physics/walls.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

inline constexpr double stefan_boltzmann = 5.670374419e-8;  ///< sigma [W/(m^2 K^4)]
inline constexpr double kelvin_offset = 273.15;             ///< 0 degrees Celsius [K]

/// The temperature [degrees Celsius], limited to absolute zero.
MELTSIM_HD double not_below_zero(double temperature) { return maximum(temperature, -kelvin_offset); }
/// Kind of a surface.
enum class SurfaceHeat : std::uint32_t { insulated = 0, held = 1, exchange = 2 };
/// Heat through a surface, per area.
template <class T>
struct SurfaceCondition {
  T temperature{};                            ///< T_s of a held surface, T_a otherwise [degrees Celsius]
  T flux{};                                   ///< q [W/m^2]
  T convection{};                             ///< [W/(m^2 K)]
  T emissivity{};                             ///< eps, 0..1
  SurfaceHeat kind = SurfaceHeat::insulated;  ///< which terms apply
};
/// Heat into a particle through a surface.
template <class T>
struct SurfaceRate {
  T rate{};         ///< heat into the particle [W]
  T conductance{};  ///< |d rate / d T| [W/K]: bounds the step
};

/// Radiation between two temperatures per degree that they differ by [W/(m^2 K)]: eps sigma (T^4 - T_a^4) over T - T_a.
template <class T>
MELTSIM_HD T radiation_coefficient(T emissivity, T temperature, T ambient) {
  const T a = temperature + T(kelvin_offset), b = ambient + T(kelvin_offset);
  return emissivity * T(stefan_boltzmann) * (a * a + b * b) * (a + b);
}

/// T_s [degrees Celsius] of a surface that radiates, over a particle of temperature T; inner = k/d [W/(m^2 K)].
template <class T>
MELTSIM_HD T surface_temperature(const SurfaceCondition<T>& c, T inner, T temperature) {
  const T outer = c.convection + inner, grey = c.emissivity * T(stefan_boltzmann);
  const T around = c.temperature + T(kelvin_offset);
  // outer T_s + grey T_s^4 = given. Either term alone says more than T_s can be, and from there Newton's method takes a few steps.
  const T given = c.flux + c.convection * around + inner * (temperature + T(kelvin_offset)) +
                  grey * (around * around) * (around * around);
  if (!(given > T(0))) return T(-kelvin_offset);
  T s = minimum(given / outer, std::sqrt(std::sqrt(given / grey)));
  for (int k = 0; k < 8; ++k) {
    const T cubed = grey * s * s * s;
    const T step = (given - outer * s - cubed * s) / (outer + T(4) * cubed);
    s += step;
    if (std::fabs(step) <= T(1e-7) * s) break;
  }
  return s - T(kelvin_offset);
}

/// Heat through area a [m^2] into a particle at depth d [m], of conductivity k [W/(m K)] and temperature T.
template <class T>
MELTSIM_HD SurfaceRate<T> surface_heat(const SurfaceCondition<T>& c, T area, T depth, T k, T temperature) {
  SurfaceRate<T> r;
  if (c.kind == SurfaceHeat::insulated) return r;
  if (c.kind == SurfaceHeat::held) {
    r.conductance = area * k / depth;
    r.rate = r.conductance * (c.temperature - temperature);
    return r;
  }
  const T inner = k / depth;
  const auto in_series = [&](T h) { return h > T(0) && k > T(0) ? area / (T(1) / h + depth / k) : T(0); };
  if (!(c.emissivity > T(0))) {
    const T passed_on = c.convection > T(0) ? inner / (inner + c.convection) : T(1);
    r.conductance = in_series(c.convection);
    r.rate = area * c.flux * passed_on + r.conductance * (c.temperature - temperature);
    return r;
  }
  const T surface = surface_temperature(c, inner, temperature), kelvin = surface + T(kelvin_offset);
  const T h = c.convection + T(4) * c.emissivity * T(stefan_boltzmann) * kelvin * kelvin * kelvin;
  const T outside = c.convection + radiation_coefficient(c.emissivity, surface, c.temperature);
  r.conductance = in_series(h);
  // Of the two sides of the balance the one in which T_s counts less, since only so many of its digits are known.
  r.rate =
      area * (h < inner ? c.flux + outside * (c.temperature - surface) : inner * (surface - temperature));
  return r;
}

/// How much of what lies beyond a surface counts as filled [-] for the conduction along it (heat.hpp: ConductionShare): of a held temperature all, else the
/// share of what a held one of the surroundings' temperature would pass. A flux passes what it does whatever is beneath. inner = k/d [W/(m^2 K)].
template <class T>
MELTSIM_HD T filled_by_wall(const SurfaceCondition<T>& c, T inner) {
  if (c.kind == SurfaceHeat::held) return T(1);
  if (c.kind == SurfaceHeat::insulated) return T(0);
  const T h = c.convection + radiation_coefficient(c.emissivity, c.temperature, c.temperature);
  return h > T(0) ? h / (h + inner) : T(0);
}

/// Surface that one particle of a solid represents.
template <class T>
struct ParticleSurface {
  T area{};   ///< [m^2]
  T depth{};  ///< of the particle beneath it [m]
};

/// Area over |G| [-] by how many of 27 sites (a particle's own and its direct neighbours) are live: 18 beneath a plane of the
/// lattice, 17 and 18 beneath those along its diagonals. On edges and corners of a box, with 12 and 8 left, missing quarters
/// count once while the surface has 2 and 3 faces: (18/live)^1.4 restores them. Edges of other directions step from
/// site to site, what sticks out of them has 9 to 11 left and serves more, up to 1.5 times that; beside them, with 13 to 16,
/// 1.12. Of a sloped plane the steps count, and the layer beneath them, which has 19 or more, once more: 0.88 of it.
/// Ours; fitted to sums over planes, boxes, balls, rods and turned cubes at chance offsets (docs/validation.md).
template <class T>
MELTSIM_HD T edge_factor(int live) {
  if (live > 18) return T(0.88);
  if (live > 16) return T(1);
  if (live > 12) return T(1.12);
  // (18/live)^1.4 for 1 to 12; written down, as the power itself has other last bits on a GPU.
  constexpr double box[12] = {57.19808741663585,  21.674022167526225, 12.286035066475314, 8.212918615558277,
                              6.009294678340453,  4.655536721746079,  3.7518394975000917, 3.112114201250831,
                              2.6390158215457884, 2.2770968742508497, 1.992653323702306,  1.7641185337870102};
  const T of_box = static_cast<T>(box[live < 1 ? 0 : live - 1]);
  return live > 8 ? of_box * (T(1) + T(1.0 / 6.0) * T(12 - live)) : of_box;
}

/// Open faces of the cell of a particle with nothing of its body in the layers on both sides of it along an axis: of a sheet, a rod, or one
/// alone. 0 of all others. direct: its live direct neighbours (neighbour_mask.hpp).
MELTSIM_HD int faces_of_sheet(std::uint32_t direct) {
  const bool sheet = (direct & (behind_x | behind_x << ahead_x)) == 0u ||
                     (direct & (behind_y | behind_y << ahead_y)) == 0u ||
                     (direct & (behind_z | behind_z << ahead_z)) == 0u;
  if (!sheet) return 0;
  const Vec3<int> faces = across_faces<int>(all_sites & ~direct);
  return faces.x + faces.y + faces.z;
}

/// Area [dx^2] of a particle that is open to both sides, as in a plate of one or two sites that lies across the lattice, where the sides
/// cancel in G: that of the plane through steps with n_k open faces along axis k, the length of n. How far
/// the S open sites lie on one side says how much of it counts: V the sum of their offsets, |V|/S is small where both sides are open and
/// large beneath planes, whose area G shows; corners and edges lie between. Ours; the three numbers are fitted to
/// plates at chance directions and offsets (docs/design/heat.md).
template <class T>
MELTSIM_HD T area_of_both_sides(std::uint32_t direct) {
  const std::uint32_t open = all_sites & ~direct;
  if (open == 0u) return T(0);
  const T one_side = length(sum_of_offsets<T>(open)) / T(popcount(open));
  return T(0.95) * clamp((T(0.8) - one_side) / T(0.3), T(0), T(1)) * length(across_faces<T>(open));
}

/// Surface that a particle of a solid represents: wall_exchange.hpp for a surface of any shape.
///   G_i = sum_j V_j L_ij x_ij over its own body [1/m]: minus what the missing half would have contributed,
///   so
/// |G| is I(d) beneath a plane. Where the body is whole it is 0. Depth: d = dx/2 + dx^2 (I(dx/2) - |G|),
/// times 0.95 beneath dx/2 and 1.6 above, fitted to lattice particles beneath planes of random orientation
/// (the sum of |G| over such a plane is 1.04 of its area). Unless the particle lies beneath a plane of the lattice (18 of 27
/// sites live) it is 0.05 dx less: part of the layer behind steps is open too but exchanges nothing, so that a held surface would
/// act as one farther out. Fitted to the decay of balls and turned cubes. For surface particles (SBP) only;
/// `first_layer` is the share of the area of a plane that these represent. edge_factor corrects |G| where it is not the area.
/// Of a layer that is one particle thick both sides cancel in G, and one alone has none: there the faces of its cell count, dx/2 above it;
/// across the lattice area_of_both_sides is the least, likewise.
/// direct: as in faces_of_sheet. Ours.
template <class T>
MELTSIM_HD ParticleSurface<T> particle_surface(const WallExchange<T>& e, T volume, T G, std::uint32_t direct,
                                               T first_layer) {
  const T plane = wall_area(e, e.half_spacing), dx = T(2) * e.half_spacing;
  if (const int faces = faces_of_sheet(direct); faces > 0) return {T(faces) * volume / dx, e.half_spacing};
  const int live = static_cast<int>(popcount(direct));
  const T area = volume * G / first_layer * edge_factor<T>(live),
          least = area_of_both_sides<T>(direct) * volume / dx;
  if (least > area) return {least, e.half_spacing};
  const T slope = G < plane ? T(0.95) : T(1.6);
  const T steps = live == 18 ? T(0) : T(0.05) * dx;
  return {area, maximum(e.half_spacing + slope * dx * dx * (plane - G) - steps, e.smallest_distance)};
}

/// Part of G (below) of a particle of liquid that walls stand for [1/m]: what lies beyond a plane would have contributed a
/// vector that points inwards, of the size wall_area.
template <class T>
MELTSIM_HD Vec3<T> walls_part(const WallExchange<T>& e, const WallView<T>& v) {
  const auto part = [&](std::uint32_t bit, T from) {
    if ((v.axes & bit) == 0u) return T(0);
    const T size = wall_area(e, std::fabs(from));
    return from < T(0) ? -size : size;
  };
  return {part(1u, v.from.x), part(2u, v.from.y), part(4u, v.from.z)};
}

/// What a neighbour of volume V_j adds to G, with its images in walls [1/m]: images count along the planes that mirror them, so that a
/// surface ends at a wall as it goes on elsewhere. Across planes walls_part stands for them, since particles move to and fro before
/// a wall as they do beneath a surface.
template <class T>
MELTSIM_HD Vec3<T> opening_part(const SphKernel<T>& k, const WallView<T>& v, T volume, Vec3<T> x_ij, T r2) {
  const auto weight = [&](T square) {
    return square < k.support2 ? kernel_laplacian(k, std::sqrt(square), square) : T(0);
  };
  const T own = weight(r2);
  if (v.axes == 0u) return x_ij * (own * volume);
  const auto images = image_sums(v, k.support2, x_ij, r2, weight);
  const T along = own + images.all;
  return Vec3<T>{x_ij.x * (along - images.across.x), x_ij.y * (along - images.across.y),
                 x_ij.z * (along - images.across.z)} *
         volume;
}

/// How the uppermost layer of a liquid serves its surface.
template <class T>
struct FreeLayer {
  T lattice_phi{};  ///< phi of that layer where particles lie as in a lattice [-]
  T on_lattice{};   ///< what it has of the sum of V G over the area there [-]
  T at_rest{};      ///< the same where phi is 1, as in liquid that has come to rest [-]
};

/// Makes the constants for H = support on a lattice of spacing dx (host).
template <class T>
inline FreeLayer<T> make_free_layer(double support, double spacing) {
  const auto k = make_kernel<double>(support, spacing);
  const auto e = make_wall_exchange<double>(support, spacing);
  const int n = static_cast<int>(support / spacing) + 1;
  double phi = 0;
  for (int z = 0; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x)
        phi +=
            spacing * spacing * spacing * kernel_value(k, spacing * std::sqrt(double(x * x + y * y + z * z)));
  const double ratio = support / spacing;
  return {static_cast<T>(phi), static_cast<T>(wall_area(e, 0.5 * spacing) * spacing),
          static_cast<T>(1 + 0.18 * exponential(2 - ratio))};
}

/// Free surface that a particle of liquid represents.
///   G_i = walls_part + sum_j opening_part, V_j L_ij x_ij over all particles [1/m]: points outwards, |G| is I(dx/2) beneath a plane.
/// What pairs contribute cancels, so the sum of V G beneath a surface is its area. The uppermost layer has a part of it where
/// particles lie as in a lattice. At rest they have moved together until phi, the sum of the kernel, is 1 for the uppermost, too: that
/// layer then has more than all, and those beneath it point the other way. phi says where between the two it is.
/// Within a liquid in motion G is never quite 0, so a small one counts for nothing. Where less than half is
/// full around a particle it represents at least a share of the surface of a ball of its volume, (36 pi)^(1/3) dx^2, all of it
/// where it is alone: W(0) V = `own`, which at small supports is more than half by itself. phi = sum_j V_j W_ij. Depth: dx/2.
/// Ours; the shares are fitted to pools (docs/design/heat.md).
template <class T>
MELTSIM_HD ParticleSurface<T> free_surface(const WallExchange<T>& e, const FreeLayer<T>& layer, T volume, T G,
                                           T phi, T own) {
  const T plane = wall_area(e, e.half_spacing), dx = T(2) * e.half_spacing;
  const T share = clamp((G - T(0.3) * plane) / (T(0.2) * plane), T(0), T(1));
  const T crowd = maximum(T(0.5), own + T(0.1));
  const T lonely = clamp((crowd - phi) / (crowd - own), T(0), T(1));
  const T rest = clamp((phi - layer.lattice_phi) / (T(1) - layer.lattice_phi), T(0), T(1));
  const T of_layer = layer.on_lattice + rest * (layer.at_rest - layer.on_lattice);
  return {maximum(volume * G / of_layer * share, lonely * T(4.84) * volume / dx), e.half_spacing};
}

/// Share up to which a surface is covered: what is missing there is a gap of a few tenths of a spacing, as liquid leaves beneath
/// a body that does not sink after it when its weight compresses it.
inline constexpr double covered_share = 0.2;

/// Dry share of the surface of a particle [-]: the kernel sum missing around it, divided by the sum that its body
/// alone leaves missing. 0 up to covered_share, what it is from twice that on. Ours.
template <class T>
MELTSIM_HD T dry_share(T own, T everything) {
  const T open = T(1) - own;
  if (!(open > T(1e-3))) return T(0);
  const T share = clamp((T(1) - everything) / open, T(0), T(1)), covered = static_cast<T>(covered_share);
  return minimum(share, maximum(T(2) * (share - covered), T(0)));
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
