// SPDX-License-Identifier: Apache-2.0
#include "shape/mesh_raster.hpp"

#include <cmath>

#include "shape/mesh_scanline.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

template <int axis>
bool inside_along(const TriangleMesh& mesh, const std::vector<std::int8_t>& turns, Vec3d point) {
  const Projected p = project<axis>(point);
  bool odd = false;
  int winding = 0;
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    const Projected corner[3] = {project<axis>(mesh.vertices[mesh.indices[t]]),
                                 project<axis>(mesh.vertices[mesh.indices[t + 1]]),
                                 project<axis>(mesh.vertices[mesh.indices[t + 2]])};
    Span span;
    if (!scan(corner, p.v, span) || p.u < span.left_u || p.u >= span.right_u) continue;
    if (!(span.depth(p.u) < p.w)) continue;
    const int turn = turns[t / 3];
    if (turn == 0) odd = !odd;
    else winding += turn * span.facing;
  }
  return odd != (winding != 0);
}

/// Crossings between a site and the one before it on an axis: bit `axis` of a byte counts those without a turn, modulo 2, and
/// three small numbers the others with their signs.
class CrossingGrid {
 public:
  CrossingGrid(const SiteRange& range, std::vector<std::uint8_t>& bits)
      : size_{range.width(), range.height(), range.depth()},
        stride_{1, range.width(), range.width() * range.height()},
        bits_(bits),
        winding_(3 * bits.size(), 0) {}

  template <int axis>
  void add(const Vec3d (&corner)[3], int turn) {
    constexpr int across = (axis + 1) % 3, rows = (axis + 2) % 3;
    const Projected c[3] = {project<axis>(corner[0]), project<axis>(corner[1]), project<axis>(corner[2])};
    // Row v is crossed where least <= v < greatest, and likewise along the row.
    const std::size_t end_row = at_or_above(maximum(c[0].v, maximum(c[1].v, c[2].v)), size_[rows]);
    std::size_t row = at_or_above(minimum(c[0].v, minimum(c[1].v, c[2].v)), size_[rows]);
    for (; row < end_row; ++row) {
      Span span;
      if (!scan(c, static_cast<double>(row), span)) continue;
      const std::size_t end = at_or_above(span.right_u, size_[across]);
      for (std::size_t column = at_or_above(span.left_u, size_[across]); column < end; ++column) {
        const double depth = span.depth(static_cast<double>(column));
        const std::size_t beyond = at_or_above(depth, size_[axis]);
        if (beyond == size_[axis]) continue;
        const std::size_t site = row * stride_[rows] + column * stride_[across] + beyond * stride_[axis];
        if (turn == 0) bits_[site] ^= 1u << axis;
        else count(3 * site + axis, turn * span.facing);
      }
    }
  }

  /// Sums up the crossings along all axes at once, then lets the majority decide.
  void resolve() {
    std::size_t site = 0;
    for (std::size_t z = 0; z < size_[2]; ++z)
      for (std::size_t y = 0; y < size_[1]; ++y)
        for (std::size_t x = 0; x < size_[0]; ++x, ++site) {
          const bool has[3] = {x > 0, y > 0, z > 0};
          for (std::size_t axis = 0; axis < 3; ++axis)
            if (has[axis]) go_on(site, axis);
        }
    for (site = 0; site < bits_.size(); ++site) {
      std::uint8_t& b = bits_[site];
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (winding_[3 * site + axis] != 0) b ^= 1u << axis;
      // Bit n of the constant tells whether n has two or more bits set.
      b = static_cast<std::uint8_t>((0xe8u >> b) & 1u);
    }
  }

 private:
  void count(std::size_t at, int by) { winding_[at] = static_cast<std::int8_t>(winding_[at] + by); }
  void go_on(std::size_t site, std::size_t axis) {
    const std::size_t last = site - stride_[axis];
    bits_[site] ^= bits_[last] & (1u << axis);
    count(3 * site + axis, winding_[3 * last + axis]);
  }
  /// First index >= v in [0, size]. Clamped before the conversion, which is undefined out of range.
  static std::size_t at_or_above(double v, std::size_t size) {
    return static_cast<std::size_t>(clamp(std::ceil(v), 0.0, static_cast<double>(size)));
  }

  std::size_t size_[3], stride_[3];
  std::vector<std::uint8_t>& bits_;
  std::vector<std::int8_t> winding_;  ///< more than 127 shells over each other count as fewer
};

}  // namespace

bool inside_of(const TriangleMesh& mesh, const std::vector<std::int8_t>& turns, Vec3d point) {
  const int votes = inside_along<0>(mesh, turns, point) + inside_along<1>(mesh, turns, point);
  return votes == 2 || (votes == 1 && inside_along<2>(mesh, turns, point));
}

void fill_inside(const TriangleMesh& mesh, const std::vector<std::int8_t>& turns, Vec3d nudge,
                 const Lattice& lattice, SiteMask& mask) {
  const Vec3i first = mask.range.lo;
  const Vec3d lo{static_cast<double>(first.x), static_cast<double>(first.y), static_cast<double>(first.z)};
  std::vector<Vec3d> on_lattice;
  on_lattice.reserve(mesh.vertices.size());
  for (const Vec3d& v : mesh.vertices) on_lattice.push_back(lattice.coordinates(v - nudge) - lo);

  CrossingGrid grid(mask.range, mask.inside);
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    const Vec3d corner[3] = {on_lattice[mesh.indices[t]], on_lattice[mesh.indices[t + 1]],
                             on_lattice[mesh.indices[t + 2]]};
    grid.add<0>(corner, turns[t / 3]);
    grid.add<1>(corner, turns[t / 3]);
    grid.add<2>(corner, turns[t / 3]);
  }
  grid.resolve();
}

}  // namespace v0
}  // namespace meltsim
