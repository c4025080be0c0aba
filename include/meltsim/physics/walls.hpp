// SPDX-License-Identifier: Apache-2.0
// Planar walls without wall particles: liquid and solids are mirrored in them.
//
// Source: ghost particles by reflection, Libersky et al. (1993), J. Comput. Phys. 109:67; Colagrossi &
// Landrini (2003), J. Comput. Phys. 191:448, sec. 3.3. An image is never stored: for a neighbour j of i, at
// distances d_i, d_j from the same plane, the image of j lies at
//   r_m^2 = r^2 + 4 d_i d_j >= r^2,   x_m = x_ij with its normal component replaced by (d_i + d_j) n,
// so whoever has an image within H is itself within H, and no further search is needed. j = i is its own
// first image. Beside an edge the images in both planes add 4 d_i d_j of each; three planes have seven.
//
//   phi_i   sum_j V_j [W(r) + sum over images W(r_m)]                                        -
//   F_i<-j  the pair formulas of fluid.hpp and coupling.hpp at x_ij, and again at each x_m    N
//   n       unit normal of the wall, inwards
//
// The images' forces are minus the gradient of the energy that their share of phi adds: along the wall they
// act on i and j with opposite signs, across it on both inwards (the wall takes the difference). So energy is
// conserved, a lattice whose first layer stands dx/2 from the walls reads exactly 1 and feels exactly no
// force beside faces, edges and corners, and the first layer's pressure is that of the liquid behind it.
// Images carry the pressure of what they mirror, where beneath a floor it goes on rising: 2 rho g d_j is
// missing (Adami, Hu & Adams 2012, J. Comput. Phys. 231:7057, eq. 27, extrapolate to wall particles). For a
// column that is
//   a(d) = 2 g int_d W dz     upwards, half of gravity at d = dx/2,
// a function of d alone, hence a potential's force (`floor_push`). Without it the first layer sinks by a
// tenth of a spacing and reads rho g dx/2 too much. Instead of images one may integrate the kernel over the
// outside (Ferrand et al. 2013, Int. J. Numer. Meth. Fluids 71:446). Measured here: whatever the integral's
// calibration, liquid packs 15 % more particles into the first layer, which the outside does not answer;
// pressure there 1.2 to 1.4 times hydrostatic, and tanks lose 2 to 4 % of their volume. The images answer in
// kind.
#pragma once

#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/wall_exchange.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// The box in stored coordinates.
template <class T>
struct WallBox {
  Vec3<T> min{}, max{};
  std::uint32_t faces{};  ///< bit 2 a + s set: axis a, side s (0 low, 1 high) is a wall
  T support{};            ///< H [m]
  T cover_scale = T(1);   ///< of wall_cover
  T push_scale = T(1);    ///< of floor_push
};

/// The walls within reach of one particle: the nearest one per axis.
template <class T>
struct WallView {
  Vec3<T> from{};        ///< x_i minus the plane, per axis: its size is d_i, its sign points inwards [m]
  std::uint32_t axes{};  ///< bit a: a wall of axis a is nearer than H
};

/// Behind a plane counts as just inside, so that the sign still says which side that is.
template <class T>
MELTSIM_HD WallView<T> wall_view(const WallBox<T>& b, Vec3<T> x) {
  WallView<T> v;
  const T least = static_cast<T>(1e-6) * b.support;
  const auto look = [&](T at, T low, T high, std::uint32_t faces, std::uint32_t bit, T& from) {
    const T dl = (faces & 1u) != 0u ? maximum(at - low, least) : b.support;
    const T dh = (faces & 2u) != 0u ? maximum(high - at, least) : b.support;
    from = dl <= dh ? dl : -dh;
    if (minimum(dl, dh) < b.support) v.axes |= bit;
  };
  look(x.x, b.min.x, b.max.x, b.faces, 1u, v.from.x);
  look(x.y, b.min.y, b.max.y, b.faces >> 2, 2u, v.from.y);
  look(x.z, b.min.z, b.max.z, b.faces >> 4, 4u, v.from.z);
  return v;
}

/// x_m - x_ij across one plane, 2 d_j n; x = x_i - x_j. Neighbours behind the plane count as on it.
template <class T>
MELTSIM_HD T image_step(T from, T x) {
  const T d = from - x;
  return from * d > T(0) ? d + d : d;
}

/// r_m^2 - r^2 of one plane, 4 d_i d_j [m^2].
template <class T>
MELTSIM_HD T image_shift(T from, T x) {
  return maximum(product(T(4) * from, from - x), T(0));
}

/// Sums over the images of one neighbour, of whatever depends on r_m alone.
template <class T>
struct ImageSums {
  T all{};           ///< over all images
  Vec3<T> across{};  ///< over those that are mirrored along x, y, z
};

/// The sums of weight(r_m^2) over the images of j; x_ij = x_i - x_j, r2 its square; 0 = its own images. Where
/// branches are dear, images beyond H are asked, too: weight must vanish there.
template <class T, class Weight>
MELTSIM_HD ImageSums<T> image_sums(const WallView<T>& v, T support2, Vec3<T> x_ij, T r2,
                                   const Weight& weight) {
  ImageSums<T> s;
  const auto value = [&](T square) {
    const T f = on_device() || square < support2 ? weight(square) : T(0);
    s.all += f;
    return f;
  };
  const bool x = (v.axes & 1u) != 0u, y = (v.axes & 2u) != 0u, z = (v.axes & 4u) != 0u;
  const T in_x = r2 + image_shift(v.from.x, x_ij.x), by_y = image_shift(v.from.y, x_ij.y),
          by_z = image_shift(v.from.z, x_ij.z);
  if (x) s.across.x = value(in_x);
  if (y) {
    s.across.y = value(r2 + by_y);
    if (x) {
      const T f = value(in_x + by_y);
      s.across.x += f;
      s.across.y += f;
    }
  }
  if (z) {
    s.across.z = value(r2 + by_z);
    if (x) {
      const T f = value(in_x + by_z);
      s.across.x += f;
      s.across.z += f;
    }
    if (y) {
      const T f = value(r2 + by_y + by_z);
      s.across.y += f;
      s.across.z += f;
      if (x) {
        const T g = value(in_x + by_y + by_z);
        s.across += Vec3<T>{g, g, g};
      }
    }
  }
  return s;
}

/// sum of weight(r_m^2) (x_m - x_ij) over the images of j, from their sums.
template <class T>
MELTSIM_HD Vec3<T> image_steps(const WallView<T>& v, Vec3<T> x_ij, const ImageSums<T>& s) {
  return {image_step(v.from.x, x_ij.x) * s.across.x, image_step(v.from.y, x_ij.y) * s.across.y,
          image_step(v.from.z, x_ij.z) * s.across.z};
}

/// sum of W(r_m) / w_scale over the images of j [-].
template <class T>
MELTSIM_HD T image_shape(const SphKernel<T>& k, const WallView<T>& v, Vec3<T> x_ij, T r2) {
  return image_sums(v, k.support2, x_ij, r2, [&](T square) { return kernel_shape(k, std::sqrt(square)); })
      .all;
}

/// What the images of j push i with: along x_ij [N/m], as j itself does, and along the planes' normals [N].
template <class T>
struct ImageForce {
  T along{};
  Vec3<T> normal{};
};

/// The same for terms, P/phi^2 of both ends together [Pa].
template <class T>
MELTSIM_HD ImageForce<T> image_pressure_force(const SphKernel<T>& k, const WallView<T>& v, Vec3<T> x_ij, T r2,
                                              T volume_i, T volume_j, T terms) {
  const auto sums = image_sums(v, k.support2, x_ij, r2,
                               [&](T square) { return kernel_gradient_shape(k, std::sqrt(square)); });
  const T factor = pressure_factor(volume_i, volume_j, terms, T(0), k.grad_scale);
  return {factor * sums.all, image_steps(v, x_ij, sums) * factor};
}

/// x_m of one image: mirrored in the planes of `mask` (bit a: axis a).
template <class T>
MELTSIM_HD Vec3<T> image_of(const WallView<T>& v, Vec3<T> x_ij, std::uint32_t mask) {
  return x_ij + Vec3<T>{(mask & 1u) != 0u ? image_step(v.from.x, x_ij.x) : T(0),
                        (mask & 2u) != 0u ? image_step(v.from.y, x_ij.y) : T(0),
                        (mask & 4u) != 0u ? image_step(v.from.z, x_ij.z) : T(0)};
}

/// r_m^2 of that image.
template <class T>
MELTSIM_HD T image_square(const WallView<T>& v, Vec3<T> x_ij, T r2, std::uint32_t mask) {
  return r2 + ((mask & 1u) != 0u ? image_shift(v.from.x, x_ij.x) : T(0)) +
         ((mask & 2u) != 0u ? image_shift(v.from.y, x_ij.y) : T(0)) +
         ((mask & 4u) != 0u ? image_shift(v.from.z, x_ij.z) : T(0));
}

/// Calls visit(x_m, r_m^2) for every image of j within H of i, for what depends on more than r_m.
template <class T, class Visit>
MELTSIM_HD void for_each_image(const WallView<T>& v, T support2, Vec3<T> x_ij, const Visit& visit) {
  for (std::uint32_t mask = v.axes; mask != 0u; mask = (mask - 1u) & v.axes) {
    const T square = image_square(v, x_ij, dot(x_ij, x_ij), mask);
    if (square < support2) visit(image_of(v, x_ij, mask), square);
  }
}

/// Integral of W over the outside of one plane at distance d, without scale: 2 pi w H^3 b^6 (1/6 - 3b/14 +
/// b^2/14), b = 1 - d/H (swap the order of integration, as in wall_exchange.hpp) [-].
template <class T>
MELTSIM_HD T half_space_share(const SphKernel<T>& k, T distance) {
  const T b = falling(distance, k.inv_support), b2 = b * b;
  const T bracket =
      static_cast<T>(1.0 / 6.0) - b * (static_cast<T>(3.0 / 14.0) - b * static_cast<T>(1.0 / 14.0));
  return static_cast<T>(6.28318530717958647692) * k.w_scale * (k.support2 * k.support) * (b2 * b2 * b2) *
         bracket;
}

/// Integral of W over a plane at this distance, of the kernel as published, so that its own integral over all distances is
/// 1: minus the derivative of half_space_share, 21/H b^5 (1 - 3b/2 + 4b^2/7) [1/m].
template <class T>
MELTSIM_HD T plane_share(const SphKernel<T>& k, T distance) {
  const T b = falling(distance, k.inv_support), b2 = b * b;
  const T bracket = T(1) - b * (T(1.5) - b * static_cast<T>(4.0 / 7.0));
  return T(21) * k.inv_support * (b2 * b2 * b) * bracket;
}

/// Share of a particle's surroundings that walls fill, whatever stands in front of them [-]: edges and
/// corners by the product of what the planes leave open.
template <class T>
MELTSIM_HD T wall_cover(const WallBox<T>& b, const SphKernel<T>& k, Vec3<T> x) {
  const WallView<T> v = wall_view(b, x);
  if (v.axes == 0u) return T(0);
  const auto open = [&](T distance) { return T(1) - b.cover_scale * half_space_share(k, distance); };
  return T(1) - open(std::fabs(v.from.x)) * open(std::fabs(v.from.y)) * open(std::fabs(v.from.z));
}

/// Makes the cover of a plane at dx/2 the lattice's (host).
template <class T>
inline T wall_cover_scale(double support, double spacing) {
  const auto k = make_kernel<double>(support, spacing);
  return static_cast<T>(lattice_half_space(support, spacing) / half_space_share(k, 0.5 * spacing));
}

/// What images leave out of the push of a floor: walls that gravity points to [m/s^2].
template <class T>
MELTSIM_HD Vec3<T> floor_push(const WallBox<T>& b, const SphKernel<T>& k, const WallView<T>& v,
                              Vec3<T> gravity) {
  const auto push = [&](std::uint32_t bit, T from, T g) {
    if ((v.axes & bit) == 0u || !(g * from < T(0))) return T(0);
    return T(-2) * g * b.push_scale * half_space_share(k, std::fabs(from));
  };
  return {push(1u, v.from.x, gravity.x), push(2u, v.from.y, gravity.y), push(4u, v.from.z, gravity.z)};
}

/// Makes the push at dx/2 the lattice's, whose image in layer k is 2 k - 1 half spacings of pressure
/// short: 1.15 times the integral at H = 2.5 dx; the second layer's is then right to 3 % (host).
template <class T>
inline T floor_push_scale(double support, double spacing) {
  const auto k = make_kernel<double>(support, spacing);
  const int n = static_cast<int>(support / spacing) + 1;
  double missing = 0;
  for (int x = 1; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z) {
        const double r = spacing * std::sqrt(double(x * x + y * y + z * z));
        missing += kernel_gradient_factor(k, r) * (spacing * x) * (spacing * (2 * x - 1));
      }
  return static_cast<T>(missing * spacing * spacing * spacing / (2 * half_space_share(k, 0.5 * spacing)));
}

/// Traction of one no-slip wall at this distance [N]: mu V I(d)/d (v_wall - v), wall_exchange.hpp.
template <class T>
MELTSIM_HD Vec3<T> wall_viscous_force(const WallExchange<T>& e, T mu, T volume, T distance,
                                      Vec3<T> v_wall_minus_v) {
  return v_wall_minus_v * (mu * volume * wall_area(e, distance) / wall_depth(e, distance));
}

/// Keeps a particle a tenth of a spacing inside walled faces: the last resort for spray that meets a wall
/// with no pressure behind it. Speed into the wall is lost.
template <class T>
MELTSIM_HD void hold_inside(const WallBox<T>& box, T spacing, Vec3<T>& x, Vec3<T>& v) {
  const T margin = T(0.1) * spacing;
  const auto hold = [&](T& position, T& speed, T low, T high, std::uint32_t faces) {
    if ((faces & 1u) != 0u && position < low + margin) {
      position = low + margin;
      speed = maximum(speed, T(0));
    }
    if ((faces & 2u) != 0u && position > high - margin) {
      position = high - margin;
      speed = minimum(speed, T(0));
    }
  };
  hold(x.x, v.x, box.min.x, box.max.x, box.faces);
  hold(x.y, v.y, box.min.y, box.max.y, box.faces >> 2);
  hold(x.z, v.z, box.min.z, box.max.z, box.faces >> 4);
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
