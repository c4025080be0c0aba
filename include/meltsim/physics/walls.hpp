// SPDX-License-Identifier: Apache-2.0
// Planar walls without wall particles: liquid and solids are mirrored in them.
//
// Source: ghost particles by reflection, Libersky et al. (1993), J. Comput. Phys. 109:67; Colagrossi &
// Landrini (2003), J. Comput. Phys. 191:448, sec. 3.3. An image is never stored: for a neighbour j of i, at
// distances d_i, d_j from the same plane, the image of j lies at
//   r_m^2 = r^2 + 4 d_i d_j >= r^2,   x_m = x_ij with its normal component replaced by (d_i + d_j) n,
// so a neighbour with an image within H is itself within H, and no further search is needed. The particle i has
// an image too (j = i). Beside an edge the images in both planes add 4 d_i d_j of each; three planes have seven.
//
//   phi_i   sum_j V_j [W(r) + sum over images W(r_m)]                                        -
//   F_i<-j  the pair formulas of fluid.hpp and coupling.hpp at x_ij, and again at each x_m    N
//   n       unit normal of the wall, inwards
//
// The images' forces are minus the gradient of the energy that their share of phi adds: along the wall they
// act on i and j with opposite signs, across it on both inwards (the wall takes the difference). So energy is
// conserved, a lattice whose first layer stands dx/2 from the walls reads exactly 1 and feels exactly no
// force beside faces, edges and corners, and the first layer's pressure is that of the liquid behind it.
// Images carry the pressure of the particles that they mirror, while beneath a floor it would rise further: 2 rho g d_j
// is missing (Adami, Hu & Adams 2012, J. Comput. Phys. 231:7057, eq. 27, extrapolate to wall particles). For a
// column that is
//   a(d) = 2 g int_d W dz     upwards, half of gravity at d = dx/2,
// a function of d alone, hence a conservative force (`floor_push`). Without it the first layer sinks by a tenth of
// a spacing and reads rho g dx/2 too much. The alternative to images, an integral of the kernel over the outside
// (Ferrand et al. 2013, Int. J. Numer. Meth. Fluids 71:446), does not react to the particles in front of it: liquid
// then packs more particles into the first layer, at a pressure above the hydrostatic one, and tanks lose volume.
// Images react like the liquid
// itself.
#pragma once

#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/wall_exchange.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// The domain, in stored coordinates.
template <class T>
struct WallBox {
  Vec3<T> min{}, max{};   ///< lower and upper corner [m]
  std::uint32_t faces{};  ///< bit 2 a + s set: axis a, side s (0 low, 1 high) is a wall
  T support{};            ///< H [m]
  T cover_scale = T(1);   ///< of wall_cover
  T push_scale = T(1);    ///< of floor_push
};

/// Distance of a place to each of the six faces [m], negative beyond one, in the order of `faces`.
template <class T>
struct FaceDistances {
  T of[6];  ///< -x, +x, -y, +y, -z, +z
  /// Distance of face 0..5.
  MELTSIM_HD T operator[](int face) const { return of[face]; }
};
/// Distances of x from the faces.
template <class T>
MELTSIM_HD FaceDistances<T> face_distances(const WallBox<T>& b, Vec3<T> x) {
  return {{x.x - b.min.x, b.max.x - x.x, x.y - b.min.y, b.max.y - x.y, x.z - b.min.z, b.max.z - x.z}};
}

/// The walls within reach of one particle: the nearest one per axis.
template <class T>
struct WallView {
  Vec3<T>
      from{};  ///< x_i minus the plane, per axis: its size is d_i, its sign points inwards [m]; H without a wall
  std::uint32_t axes{};  ///< bit a: a wall of axis a is closer than H
};

/// A particle behind a plane counts as just inside, so that the sign still tells the side of the wall.
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

/// x_m - x_ij for one plane, 2 d_j n [m]; x = x_i - x_j. Neighbours behind the plane count as on it.
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

/// Sums over the images of one neighbour of a function of r_m.
template <class T>
struct ImageSums {
  T all{};           ///< over all images
  Vec3<T> across{};  ///< over the images mirrored along x, along y, along z
};

/// Sums of weight(r_m^2) over the images of j; x_ij = x_i - x_j, r2 its square; x_ij = 0 for the images of i. On a device
/// images beyond H are included, because branches are expensive: weight must be 0 there.
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

/// Sum of weight(r_m^2) (x_m - x_ij) over the images of j, from their sums.
template <class T>
MELTSIM_HD Vec3<T> image_steps(const WallView<T>& v, Vec3<T> x_ij, const ImageSums<T>& s) {
  return {image_step(v.from.x, x_ij.x) * s.across.x, image_step(v.from.y, x_ij.y) * s.across.y,
          image_step(v.from.z, x_ij.z) * s.across.z};
}

/// Sum of W(r_m) / w_scale over the images of j [-].
template <class T>
MELTSIM_HD T image_shape(const SphKernel<T>& k, const WallView<T>& v, Vec3<T> x_ij, T r2) {
  return image_sums(v, k.support2, x_ij, r2, [&](T square) { return kernel_shape(k, std::sqrt(square)); })
      .all;
}

/// Force of the images of j on i: along x_ij + normal.
template <class T>
struct ImageForce {
  T along{};         ///< factor of x_ij [N/m]
  Vec3<T> normal{};  ///< along the normals of the planes [N]
};

/// Force of the images of j on i: the sum over them of factor weight(r_m^2) x_m, from the sums of their weights.
template <class T>
MELTSIM_HD ImageForce<T> image_force(const WallView<T>& v, Vec3<T> x_ij, const ImageSums<T>& s, T factor) {
  return {factor * s.all, image_steps(v, x_ij, s) * factor};
}

/// Pressure force of the images of j on i; terms = P_i/phi_i^2 + P_j/phi_j^2 [Pa].
template <class T>
MELTSIM_HD ImageForce<T> image_pressure_force(const SphKernel<T>& k, const WallView<T>& v, Vec3<T> x_ij, T r2,
                                              T volume_i, T volume_j, T terms) {
  const auto sums = image_sums(v, k.support2, x_ij, r2,
                               [&](T square) { return kernel_gradient_shape(k, std::sqrt(square)); });
  return image_force(v, x_ij, sums, pressure_factor(volume_i, volume_j, terms, T(0), k.grad_scale));
}

/// 1 for the axes of `mask` (bit a: axis a), 0 for others. As factors they are no branch, so that loops over neighbours become vector
/// instructions.
template <class T>
MELTSIM_HD Vec3<T> axes_of(std::uint32_t mask) {
  return {T(mask & 1u), T(mask >> 1 & 1u), T(mask >> 2 & 1u)};
}

/// x_m of the image mirrored in the planes of `mask` [m].
template <class T>
MELTSIM_HD Vec3<T> image_of(const WallView<T>& v, Vec3<T> x_ij, std::uint32_t mask) {
  const Vec3<T> on = axes_of<T>(mask);
  return x_ij + Vec3<T>{image_step(v.from.x, x_ij.x) * on.x, image_step(v.from.y, x_ij.y) * on.y,
                        image_step(v.from.z, x_ij.z) * on.z};
}

/// r_m^2 of that image [m^2].
template <class T>
MELTSIM_HD T image_square(const WallView<T>& v, Vec3<T> x_ij, T r2, std::uint32_t mask) {
  const Vec3<T> on = axes_of<T>(mask);
  return r2 + image_shift(v.from.x, x_ij.x) * on.x + image_shift(v.from.y, x_ij.y) * on.y +
         image_shift(v.from.z, x_ij.z) * on.z;
}

/// Calls visit(mask, x_m, r_m^2) for every image of j within H of i, for terms that depend on more than r_m; r2 = x_ij^2.
template <class T, class Visit>
MELTSIM_HD void for_each_masked_image(const WallView<T>& v, T support2, Vec3<T> x_ij, T r2,
                                      const Visit& visit) {
  for (std::uint32_t mask = v.axes; mask != 0u; mask = (mask - 1u) & v.axes) {
    const T square = image_square(v, x_ij, r2, mask);
    if (square < support2) visit(mask, image_of(v, x_ij, mask), square);
  }
}

/// Calls visit(x_m, r_m^2), for terms that do not depend on the planes.
template <class T, class Visit>
MELTSIM_HD void for_each_image(const WallView<T>& v, T support2, Vec3<T> x_ij, const Visit& visit) {
  for_each_masked_image(v, support2, x_ij, dot(x_ij, x_ij),
                        [&](std::uint32_t, const Vec3<T>& x, T square) { visit(x, square); });
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

/// Integral of the uncorrected W over a plane at a distance [m], whose integral over all distances is 1: minus the
/// derivative of half_space_share, 21/H b^5 (1 - 3b/2 + 4b^2/7) [1/m].
template <class T>
MELTSIM_HD T plane_share(const SphKernel<T>& k, T distance) {
  const T b = falling(distance, k.inv_support), b2 = b * b;
  const T bracket = T(1) - b * (T(1.5) - b * static_cast<T>(4.0 / 7.0));
  return T(21) * k.inv_support * (b2 * b2 * b) * bracket;
}

/// Share of the surroundings of a particle that walls cover [-]; in edges and corners the open share is the product of
/// the open shares of the planes. counts(face): how much of each is meant, 0 to 1.
template <class T, class Counts>
MELTSIM_HD T wall_cover(const WallBox<T>& b, const SphKernel<T>& k, Vec3<T> x, const Counts& counts) {
  const WallView<T> v = wall_view(b, x);
  if (v.axes == 0u) return T(0);
  const auto open = [&](int axis, T from) {
    if (((v.axes >> axis) & 1u) == 0u) return T(1);
    const T share = counts(2 * axis + (from < T(0) ? 1 : 0));
    return T(1) - share * (b.cover_scale * half_space_share(k, std::fabs(from)));
  };
  return T(1) - open(0, v.from.x) * open(1, v.from.y) * open(2, v.from.z);
}
/// The same of all walls in full.
template <class T>
MELTSIM_HD T wall_cover(const WallBox<T>& b, const SphKernel<T>& k, Vec3<T> x) {
  return wall_cover(b, k, x, [](int) { return T(1); });
}

/// Scale that makes the cover of a plane at dx/2 equal to that of the lattice (host).
template <class T>
inline T wall_cover_scale(double support, double spacing) {
  const auto k = make_kernel<double>(support, spacing);
  return static_cast<T>(lattice_half_space(support, spacing) / half_space_share(k, 0.5 * spacing));
}

/// Acceleration that images lack at a floor, that is at walls to which gravity points [m/s^2].
template <class T>
MELTSIM_HD Vec3<T> floor_push(const WallBox<T>& b, const SphKernel<T>& k, const WallView<T>& v,
                              Vec3<T> gravity) {
  const auto push = [&](std::uint32_t bit, T from, T g) {
    if ((v.axes & bit) == 0u || !(g * from < T(0))) return T(0);
    return T(-2) * g * b.push_scale * half_space_share(k, std::fabs(from));
  };
  return {push(1u, v.from.x, gravity.x), push(2u, v.from.y, gravity.y), push(4u, v.from.z, gravity.z)};
}

/// Scale that makes the push at dx/2 equal to that of the lattice, where the image in layer k lacks the pressure of 2 k - 1
/// half spacings: 1.15 times the integral at H = 2.5 dx; at the second layer it is right within 3 % (host).
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

/// Conductance of one no-slip wall at a distance d [kg/s]: mu V I(d)/d, wall_exchange.hpp.
template <class T>
MELTSIM_HD T wall_viscous_factor(const WallExchange<T>& e, T mu, T volume, T distance) {
  return mu * volume * wall_area(e, distance) / wall_depth(e, distance);
}
/// Traction of that wall [N].
template <class T>
MELTSIM_HD Vec3<T> wall_viscous_force(const WallExchange<T>& e, T mu, T volume, T distance,
                                      Vec3<T> v_wall_minus_v) {
  return v_wall_minus_v * wall_viscous_factor(e, mu, volume, distance);
}

/// Keeps a particle at least a tenth of a spacing inside walls: a safeguard for spray that hits a wall without pressure
/// behind it. The velocity into the wall becomes 0.
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
