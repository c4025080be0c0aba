// SPDX-License-Identifier: Apache-2.0
// Ellipsoids that melt together. The distance to an ellipsoid is the usual first-order estimate, value over
// gradient: with q = p / radii, (|q| - 1) |q| / |q / radii| (Taubin, "Distance approximations for rasterizing
// implicit curves", ACM Trans. Graph. 13, 1994). Distances combine by the quadratic polynomial smooth minimum
// (Quilez, "Smooth minimum", iquilezles.org/articles/smin): min(a, b) - max(k - |a - b|, 0)^2 / 4k.
#include "shape/box_ops.hpp"
#include "shape/shape_check.hpp"
#include "shape/shape_primitives.hpp"
#include "shape/shape_round.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

double smooth_minimum(double a, double b, double width, double inverse_width) {
  const double overlap = width - std::abs(a - b);
  const double least = minimum(a, b);
  return overlap > 0 ? least - 0.25 * overlap * overlap * inverse_width : least;
}

class BlendNode final : public ShapeNode {
 public:
  BlendNode(std::vector<Ellipsoid> parts, double blend) : parts_(std::move(parts)), blend_(blend) {
    inverse_blend_ = blend > 0 ? 1 / blend : 0;
    inverse_radii_.reserve(parts_.size());
    for (const Ellipsoid& e : parts_) {
      inverse_radii_.push_back({1 / e.radii.x, 1 / e.radii.y, 1 / e.radii.z});
      tie_ = maximum(tie_, tie_width(magnitude(e.radii), magnitude(e.center)));
    }
    bulge_ = largest_bulge();
    for (const Vec3d& inv : inverse_radii_) {
      const double farthest = 1 + 2 * (bulge_ + tie_) * maximum(inv.x, maximum(inv.y, inv.z));
      far_.push_back(farthest * farthest * (1 + slack));
    }
  }

  bool contains(Vec3d p) const override {
    bool near = false;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const double level = squared_level(i, p);
      if (level < 1 - slack) return true;  // the smooth minimum is no more than the least
      near = near || !(level > far_[i]);
    }
    if (!near) return false;
    double least = infinity;
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (!out_of_reach(i, p, least + blend_))
        least = smooth_minimum(least, distance(i, p), blend_, inverse_blend_);
    return least <= tie_;
  }

  Box bounds(const Affine& to_world) const override {
    Box out = empty_box();
    for (const Ellipsoid& e : parts_) {
      // |q| - 1 <= distance / least radius, so a bulge scales the ellipsoid by no more than this.
      const double least = minimum(e.radii.x, minimum(e.radii.y, e.radii.z));
      const Vec3d r = e.radii * (1 + bulge_ / least);
      const auto& m = to_world.linear.m;
      const auto extent = [&r](const double* row) {
        return length(Vec3d{row[0] * r.x, row[1] * r.y, row[2] * r.z});
      };
      grow(out, around(to_world(e.center), {extent(m[0]), extent(m[1]), extent(m[2])}));
    }
    return out;
  }

  Status validate() const override {
    if (parts_.empty()) return refuse_shape("blend.parts is empty; give at least one ellipsoid");
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const std::string name = "blend.parts[" + std::to_string(i) + "]";
      if (Status s = check_point(name + ".center", parts_[i].center); !s) return s;
      if (Status s = check_positive(name + ".radii.x", parts_[i].radii.x); !s) return s;
      if (Status s = check_positive(name + ".radii.y", parts_[i].radii.y); !s) return s;
      if (Status s = check_positive(name + ".radii.z", parts_[i].radii.z); !s) return s;
    }
    if (Status s = check_number("blend.blend", blend_); !s) return s;
    if (blend_ < 0)
      return refuse_shape("blend.blend is " + number_text(blend_) + " but must not be negative");
    return {};
  }

 private:
  double distance(std::size_t i, Vec3d p) const {
    const Vec3d inv = inverse_radii_[i], d = p - parts_[i].center;
    const Vec3d q{d.x * inv.x, d.y * inv.y, d.z * inv.z};
    const Vec3d g{q.x * inv.x, q.y * inv.y, q.z * inv.z};
    const double level = length(q), slope = length(g);
    // The gradient vanishes at the centre only; the least radius is the distance there.
    if (!(slope > 0)) return -1 / maximum(inv.x, maximum(inv.y, inv.z));
    return (level - 1) * level / slope;
  }

  double squared_level(std::size_t i, Vec3d p) const {
    const Vec3d inv = inverse_radii_[i], d = p - parts_[i].center;
    const Vec3d q{d.x * inv.x, d.y * inv.y, d.z * inv.z};
    return dot(q, q);
  }
  /// Whether the distance to a part is certainly more than this: it is at least |q| - 1 times the least radius. A smooth minimum
  /// that is a width less than a distance is the same to the bit without it.
  bool out_of_reach(std::size_t i, Vec3d p, double distance) const {
    const Vec3d inv = inverse_radii_[i];
    const double least = 1 + distance * maximum(inv.x, maximum(inv.y, inv.z));
    return least > 1 && squared_level(i, p) > least * least * (1 + slack);
  }

  // The smooth minimum is monotone, so the value sinks deepest below the least distance where all distances
  // are equal. There each part takes off another (1 - sunk)^2 / 4 widths; the sum stays below one width.
  double largest_bulge() const {
    double sunk = 0;
    for (std::size_t i = 1; i < parts_.size() && i < 1000; ++i) sunk += 0.25 * (1 - sunk) * (1 - sunk);
    return (parts_.size() > 1000 ? 1 : sunk) * maximum(blend_, 0.0);
  }

  std::vector<Ellipsoid> parts_;
  static constexpr double slack = 1e-9;  ///< more than rounding can be, of a square of |q|

  std::vector<Vec3d> inverse_radii_;
  std::vector<double> far_;  ///< squares of |q| from which on a part, bulges included, holds nothing
  double blend_, inverse_blend_ = 0, tie_ = 0, bulge_ = 0;
};

}  // namespace

ShapePtr make_blend(std::vector<Ellipsoid> parts, double blend) {
  return std::make_shared<BlendNode>(std::move(parts), blend);
}

}  // namespace v0
}  // namespace meltsim
