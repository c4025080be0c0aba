// SPDX-License-Identifier: Apache-2.0
// Liquid that starts at rest, compressed as its own weight compresses it (host).
//
// On a lattice of even spacing liquid has no pressure, so it falls until it has, and rings at c/4h (h its depth). Compressed along
// gravity it starts with the pressure of rest. Pressure is the weight of what is above, and masses do not change, so it is known
// in places as they were laid out:
//
//   symbol  meaning                                                          unit
//   m_k     mass of the particles above, in the same column                  kg
//   p       p_top + g (sum of m_k)/dx^2 + g m/(2 dx^2)                       Pa
//   phi     (1 + 7 p/(rho0 c^2))^(1/7): volume fraction, Tait's inverse      -
//   a       dx/phi: height of the particle's cell                            m
//
// Columns run along the axis nearest to gravity, of which g is the component; liquid with an even surface across gravity then has the
// pressure of rest along the other axes, too. p_top is 0 at a free surface; below a body or a lid the level of the nearest free
// surface, over liquid that is connected, says what it is. In a full box in which liquid may pull it is minus half of the column's weight.
// Where cells are longer or shorter than a spacing, sums are not those of a lattice of even ones: a is then what makes the sum phi.
// Sums lack neighbours at a free surface, so layers near it are where the forces of layers balance (sums as in fluid.hpp):
//
//   phi_n   sum over layers m, and their images in the floor, of that of V W over layer m             -
//   F_n     sum over them of (P_n/phi_n^2 + P_m/phi_m^2) times that of V f x; rho0 floor_push          N/m^3
//   F_n = rho0 g
//
// Deviations: layers are endless, and liquid is thought to go on within a body below them; the balance of those below a body, which is
// not at rest either, is by depth alone.
#pragma once

#include <cmath>
#include <vector>

#include "meltsim/physics/walls.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// phi of liquid under a pressure above -stiffness [-]; stiffness = rho0 c^2 / 7 [Pa] (tait_pressure, inverted). Of
/// arithmetic alone, so that every machine has the same bits.
inline double hydrostatic_fraction(double pressure, double stiffness) {
  const double seventh = 1.0 + pressure / stiffness;
  double phi = 1.0 + (seventh - 1.0) / 7.0;  // no less than the root, so that Newton's steps all go down
  constexpr int most = 1000;                 // six do unless pressures are far beyond c^2
  for (int k = 0; k < most; ++k) {
    const double p2 = phi * phi, p6 = p2 * p2 * p2, next = phi - (p6 * phi - seventh) / (7.0 * p6);
    if (!(next < phi)) break;
    phi = next;
  }
  return phi;
}

/// phi of every layer of a column by the weight of what is above it [-], the lowest layer first. on_top: pressure at the column's top; weight: of
/// each layer, per area; stiffness: of each layer [all in one unit].
inline std::vector<double> hydrostatic_fractions(double on_top, const std::vector<double>& weight,
                                                 const std::vector<double>& stiffness) {
  std::vector<double> phi(weight.size());
  for (std::size_t i = phi.size(); i-- > 0;) {
    phi[i] = hydrostatic_fraction(on_top + 0.5 * weight[i], stiffness[i]);
    on_top += weight[i];
  }
  return phi;
}

/// Rate of the drag [1/s] that lets liquid come to rest soonest: the slowest sound wave that there is along a path [m] between walls or to a
/// surface decays without swinging on for long. c: sound speed [m/s].
inline double settling_rate(double c, double path) { return 2 * c / path; }
/// How long that takes [s]: such a wave is down to exp(-5) of what it was, as rate/2 says.
inline double settling_time(double c, double path) { return 5 * path / c; }

/// Middles of cells of these heights on top of each other, the lowest first, from `bottom` on.
inline std::vector<double> stacked(const std::vector<double>& cells, double bottom) {
  std::vector<double> middles(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    middles[i] = bottom + 0.5 * cells[i];
    bottom += cells[i];
  }
  return middles;
}

/// Cells that liquid is laid out in [spacings].
struct LiquidCell {
  double x = 1;       ///< length along its layers
  double z = 1;       ///< the other one
  double height = 1;  ///< from one layer to the next
  /// Whether they are cubes of the spacing.
  bool even() const { return x == 1 && z == 1 && height == 1; }
  /// Whether all lengths are alike.
  bool operator==(const LiquidCell& o) const { return x == o.x && z == o.z && height == o.height; }
};

/// Layers of liquid on the lattice of the simulation, the lowest first: lengths in spacings, pressures in rho c^2 of a density of 1 (host).
class LayerSums {
 public:
  /// H/dx.
  explicit LayerSums(double support_in_spacings, const LiquidCell& cell = {})
      : kernel_(make_kernel<double>(support_in_spacings, 1)), support_(support_in_spacings), cell_(cell) {
    floor_.push_scale = floor_push_scale<double>(support_, 1);
  }

  /// hydrostatic_fractions() below a free surface; pull = g dx/c^2.
  std::vector<double> by_depth(const std::vector<double>& density, double pull) const {
    std::vector<double> weight = density, stiff = density;
    for (double& w : weight) w *= pull * cell_.height;
    for (double& s : stiff) s *= stiffness;
    return hydrostatic_fractions(0, weight, stiff);
  }

  /// Height of the cells of layers, all of one height, in which the sum is phi: 1/phi of even ones.
  double cell_height(double phi) const {
    double height = cell_.height / phi;
    constexpr int most_steps = 40;
    for (int step = 0; step < most_steps && !cell_.even(); ++step) {  // the sum goes by nearly 1/height
      const double sum = sum_of_layers(height);
      if (!(sum > 0)) break;
      height *= sum / phi;
      if (std::fabs(sum / phi - 1) < 1e-12) break;
    }
    return height;
  }

  /// Forces minus weight, in c^2/dx of a density of 1, on layers at these heights. The lowest `held` stay where they are and have the
  /// phi of their depth. stands: on a floor at height 0, with its images.
  std::vector<double> balance(const std::vector<double>& heights, const std::vector<double>& density,
                              std::size_t held, double pull, bool stands) const {
    const std::size_t n = heights.size();
    std::vector<double> terms(n), forces(n, 0.0), phi = by_depth(density, pull);
    for (std::size_t i = 0; i < n; ++i) {
      if (i >= held) phi[i] = fraction(heights, i, stands);
      terms[i] = pressure_term(tait_pressure(density[i] * stiffness, phi[i]), phi[i]);
    }
    for (std::size_t i = held; i < n; ++i) {
      forces[i] = density[i] * ((stands ? pushed(heights[i], pull) : 0.0) - pull);
      for_each_near(heights, i, stands,
                    [&](std::size_t j, double x) { forces[i] += (terms[i] + terms[j]) * gradient(x); });
    }
    return forces;
  }

 private:
  static constexpr double stiffness = 1.0 / 7.0;  ///< tait_stiffness of rho c^2 = 1

  /// Calls visit(j, distance) for layers and images within the support.
  template <class Visit>
  void for_each_near(const std::vector<double>& heights, std::size_t i, bool stands,
                     const Visit& visit) const {
    for (std::size_t j = 0; j < heights.size(); ++j) {
      if (std::fabs(heights[i] - heights[j]) < support_) visit(j, heights[i] - heights[j]);
      if (stands && heights[i] + heights[j] < support_) visit(j, heights[i] + heights[j]);
    }
  }
  auto value() const {
    return [this](double r) { return kernel_value(kernel_, r); };
  }
  /// phi of layers this far apart, of the mass of those of the cell.
  double sum_of_layers(double distance) const {
    double phi = 0;
    for (int k = static_cast<int>(support_ / distance); k > 0; --k)
      phi += 2 * over_layer(k * distance, value());
    return phi + over_layer(0, value());
  }
  double fraction(const std::vector<double>& heights, std::size_t i, bool stands) const {
    double phi = 0;
    for_each_near(heights, i, stands, [&](std::size_t, double x) { phi += over_layer(x, value()); });
    return phi;
  }
  double gradient(double x) const {
    return x * over_layer(x, [this](double r) { return r > 0 ? kernel_gradient_factor(kernel_, r) : 0.0; });
  }
  double pushed(double height, double pull) const {
    WallView<double> view;
    view.from.y = height;
    view.axes = height < support_ ? 2u : 0u;
    return floor_push(floor_, kernel_, view, {0, -pull, 0}).y;
  }
  /// Sum of V times a value over a layer at this distance.
  template <class Value>
  double over_layer(double distance, const Value& value) const {
    const int reach_x = static_cast<int>(support_ / cell_.x) + 1,
              reach_z = static_cast<int>(support_ / cell_.z) + 1;
    double sum = 0;
    for (int x = -reach_x; x <= reach_x; ++x)
      for (int z = -reach_z; z <= reach_z; ++z) {
        const double dx = x * cell_.x, dz = z * cell_.z;
        const double r = std::sqrt(dx * dx + dz * dz + distance * distance);
        if (r < support_) sum += value(r);
      }
    return sum * (cell_.x * cell_.z * cell_.height);
  }

  SphKernel<double> kernel_;
  WallBox<double> floor_;
  double support_;
  LiquidCell cell_;
};

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
