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

/// T_s [degrees Celsius] of any surface that is not insulated, over a particle of temperature T; inner = k/d [W/(m^2 K)]. A particle that changes
/// phase conducts towards it as towards a neighbour of that temperature (heat.hpp: conductivity_toward), k being its own here.
template <class T>
MELTSIM_HD T facing_temperature(const SurfaceCondition<T>& c, T inner, T temperature) {
  if (c.kind == SurfaceHeat::held) return c.temperature;
  if (c.emissivity > T(0)) return surface_temperature(c, inner, temperature);
  const T outer = c.convection + inner;
  return outer > T(0) ? temperature + (c.flux + c.convection * (c.temperature - temperature)) / outer
                      : temperature;
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

/// Gap up to which a body counts as flush with a wall [dx]: bodies at rest keep some hundredths of a spacing off.
inline constexpr double flush_gap = 0.2;

/// Walls that a body goes on behind, as a particle of it sees them, and its direct neighbours with their images in them.
template <class T>
struct FlushWalls {
  WallView<T> view{};      ///< those walls alone
  std::uint32_t direct{};  ///< neighbour_mask.hpp
};

/// Picks the walls of `v` that a layer of the body's lattice lies along, half a spacing and whole spacings away (to flush_gap), so that it and its image
/// make one body: a surface that ends at such a wall goes on as far as the wall. Where the layers next to the wall are
/// missing, images lie out of reach. turn: of the lattice, away from which a wall may be turned by 14 degrees. Ours.
template <class T>
MELTSIM_HD FlushWalls<T> flush_walls(const WallExchange<T>& e, const WallView<T>& v, const Quat<T>& turn,
                                     std::uint32_t direct) {
  FlushWalls<T> f{v, direct};
  f.view.axes = 0;
  const Quat<T> back = inverse(turn);
  const auto look = [&](std::uint32_t bit, T from, Vec3<T> normal) {
    if ((v.axes & bit) == 0u) return;
    const T layer = std::fabs(from) / (T(2) * e.half_spacing) - T(0.5);
    if (std::fabs(layer - std::floor(layer + T(0.5))) > static_cast<T>(flush_gap)) return;
    const Vec3<T> n = rotate(back, normal);  // inwards, in the lattice
    const auto along = [&](int axis, T part) {
      if (std::fabs(part) < T(0.97)) return;
      f.view.axes |= bit;
      if (layer < T(0.5)) f.direct = with_image(f.direct, axis, part > T(0));
    };
    along(0, n.x), along(1, n.y), along(2, n.z);
  };
  const auto inwards = [](T from) { return from < T(0) ? T(-1) : T(1); };
  look(1u, v.from.x, {inwards(v.from.x), T(0), T(0)});
  look(2u, v.from.y, {T(0), inwards(v.from.y), T(0)});
  look(4u, v.from.z, {T(0), T(0), inwards(v.from.z)});
  return f;
}

/// Sums around a particle of a body.
template <class T>
struct BodySums {
  Vec3<T> G{};     ///< of V_j L_ij x_ij over the body [1/m]
  T own{};         ///< of V_j W_ij over the body [-]
  T everything{};  ///< of V_j W_ij over all particles [-]
  /// Adds a neighbour of volume V_j and its images in `flush`; of_body: it is of the particle's own body.
  MELTSIM_HD void add(const SphKernel<T>& k, const WallView<T>& flush, T volume, Vec3<T> x_ij, T r2,
                      bool of_body) {
    const T r = std::sqrt(r2);
    T share = kernel_value(k, r);
    if (flush.axes != 0u)
      share += image_sums(flush, k.support2, x_ij, r2, [&](T square) {
                 return square < k.support2 ? kernel_value(k, std::sqrt(square)) : T(0);
               }).all;
    everything += volume * share;
    if (!of_body) return;
    own += volume * share;
    G += x_ij * (volume * kernel_laplacian(k, r, r2));
    if (flush.axes == 0u) return;
    const auto images = image_sums(flush, k.support2, x_ij, r2, [&](T square) {
      return square < k.support2 ? kernel_laplacian(k, std::sqrt(square), square) : T(0);
    });
    G += (x_ij * images.all + image_steps(flush, x_ij, images)) * volume;
  }
};

/// Area that a particle of a solid represents [dx^2/100], from its direct neighbours (neighbour_mask.hpp): the faces of its cell where it is of a face, edge
/// or corner of a box, of a sheet or a rod. Elsewhere surfaces run in steps, and what they amount to goes by how many of its six faces are
/// open, and of the other 20 directions (rows and columns). Local counts as in Lindblad (2005), Image Vis. Comput. 23:111; the numbers are ours,
/// fitted to the sums over balls, ellipsoids, cylinders, turned cubes, planes and plates at chance places and at those of highest symmetry.
MELTSIM_HD int surface_hundredths(std::uint32_t direct) {
  constexpr std::uint16_t stepped[7][21] = {
      {0, 1, 0, 3, 13, 20, 0, 17, 46, 23, 48, 0, 0, 44, 77, 83, 88, 93, 99, 105, 110},
      {31, 38, 46, 60, 66, 69, 88, 75, 89, 111, 163, 113, 102, 0, 134, 139, 146, 154, 161, 168, 175},
      {100, 105, 110, 115, 120, 127, 122, 138, 146, 133, 144,
       137, 155, 152, 175, 117, 136, 231, 222, 195, 200},
      {108, 115, 122, 128, 129, 123, 158, 155, 153, 152, 156,
       173, 196, 178, 202, 207, 227, 224, 226, 232, 238},
      {52, 65, 78, 91, 104, 117, 130, 143, 156, 198, 176, 244, 215, 219, 274, 384, 550, 315, 338, 299, 312},
      {80, 93, 106, 119, 132, 145, 158, 171, 184, 197, 211, 269, 258, 419, 196, 298, 421, 483, 388, 327, 340},
      {108, 121, 134, 147, 160, 173, 186, 199, 212, 225, 238,
       251, 264, 277, 346, 303, 316, 330, 342, 355, 368}};
  if (const int sides = whole_sides_open(direct); sides > 0) return 100 * sides;
  const std::uint32_t open = all_sites & ~direct;
  const int all = static_cast<int>(popcount(open)), faces = static_cast<int>(popcount(open & across_a_face));
  return stepped[faces][all - faces];
}

/// Surface that a particle of a solid represents. Area: surface_hundredths. Depth: from
///   G_i = sum_j V_j L_ij x_ij over its own body [1/m]: minus what the missing half would have contributed,
/// so |G| is I(d) beneath a plane (wall_exchange.hpp), and 0 where the body is whole. d = dx/2 + dx^2 (I(dx/2) - |G|),
/// times 0.95 beneath dx/2 and 1.3 above, fitted to lattice particles beneath planes of random orientation. On faces, edges and corners of boxes, on sheets
/// and rods it is dx/2. G and `direct` include images in flush walls. Ours.
template <class T>
MELTSIM_HD ParticleSurface<T> particle_surface(const WallExchange<T>& e, T volume, T G,
                                               std::uint32_t direct) {
  const T plane = wall_area(e, e.half_spacing), dx = T(2) * e.half_spacing;
  const T area = static_cast<T>(surface_hundredths(direct)) * (T(0.01) * volume / dx);
  if (whole_sides_open(direct) > 0) return {area, e.half_spacing};
  const T slope = G < plane ? T(0.95) : T(1.3);
  return {area, maximum(e.half_spacing + slope * dx * dx * (plane - G), e.smallest_distance)};
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
