// SPDX-License-Identifier: Apache-2.0
#include "shape/mesh_raster.hpp"

#include <cmath>

#include "shape/mesh_scanline.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

template <int axis>
bool odd_crossings(const TriangleMesh& mesh, Vec3d point) {
  const Projected p = project<axis>(point);
  bool odd = false;
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    const Projected corner[3] = {project<axis>(mesh.vertices[mesh.indices[t]]),
                                 project<axis>(mesh.vertices[mesh.indices[t + 1]]),
                                 project<axis>(mesh.vertices[mesh.indices[t + 2]])};
    Span span;
    if (!scan(corner, p.v, span) || p.u < span.left_u || p.u >= span.right_u) continue;
    if (span.depth(p.u) < p.w) odd = !odd;
  }
  return odd;
}

/// Bit `axis` of a byte counts, modulo 2, the crossings between a site and the one before it on that axis.
class CrossingGrid {
 public:
  CrossingGrid(const SiteRange& range, std::vector<std::uint8_t>& bits)
      : size_{range.width(), range.height(), range.depth()},
        stride_{1, range.width(), range.width() * range.height()},
        bits_(bits) {}

  template <int axis>
  void add(const Vec3d (&corner)[3]) {
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
        bits_[row * stride_[rows] + column * stride_[across] + beyond * stride_[axis]] ^= 1u << axis;
      }
    }
  }

  /// Sums up the crossings along all axes at once, then lets the majority decide.
  void resolve() {
    std::size_t site = 0;
    for (std::size_t z = 0; z < size_[2]; ++z)
      for (std::size_t y = 0; y < size_[1]; ++y)
        for (std::size_t x = 0; x < size_[0]; ++x, ++site) {
          if (x > 0) bits_[site] ^= bits_[site - stride_[0]] & 1u;
          if (y > 0) bits_[site] ^= bits_[site - stride_[1]] & 2u;
          if (z > 0) bits_[site] ^= bits_[site - stride_[2]] & 4u;
        }
    // Bit n of the constant tells whether n has two or more bits set.
    for (std::uint8_t& b : bits_) b = static_cast<std::uint8_t>((0xe8u >> b) & 1u);
  }

 private:
  /// First index >= v in [0, size]. Clamped before the conversion, which is undefined out of range.
  static std::size_t at_or_above(double v, std::size_t size) {
    return static_cast<std::size_t>(clamp(std::ceil(v), 0.0, static_cast<double>(size)));
  }

  std::size_t size_[3], stride_[3];
  std::vector<std::uint8_t>& bits_;
};

}  // namespace

bool inside_by_parity(const TriangleMesh& mesh, Vec3d point) {
  const int votes = odd_crossings<0>(mesh, point) + odd_crossings<1>(mesh, point);
  return votes == 2 || (votes == 1 && odd_crossings<2>(mesh, point));
}

void fill_by_parity(const TriangleMesh& mesh, Vec3d nudge, const Lattice& lattice, SiteMask& mask) {
  const Vec3i first = mask.range.lo;
  const Vec3d lo{static_cast<double>(first.x), static_cast<double>(first.y), static_cast<double>(first.z)};
  std::vector<Vec3d> on_lattice;
  on_lattice.reserve(mesh.vertices.size());
  for (const Vec3d& v : mesh.vertices) on_lattice.push_back(lattice.coordinates(v - nudge) - lo);

  CrossingGrid grid(mask.range, mask.inside);
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    const Vec3d corner[3] = {on_lattice[mesh.indices[t]], on_lattice[mesh.indices[t + 1]],
                             on_lattice[mesh.indices[t + 2]]};
    grid.add<0>(corner);
    grid.add<1>(corner);
    grid.add<2>(corner);
  }
  grid.resolve();
}

}  // namespace v0
}  // namespace meltsim
