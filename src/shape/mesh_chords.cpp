// SPDX-License-Identifier: Apache-2.0
#include "shape/mesh_chords.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "meltsim/physics/mesh_motion.hpp"
#include "shape/affine.hpp"
#include "shape/shape_node.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {
namespace {

/// Where a line of sites along an axis meets a triangle.
struct Hit {
  double at = 0;  ///< along the axis, in units in which site i is at i
  std::uint32_t triangle = 0;
  std::array<double, 3> share{};  ///< of its corners
};

/// In units of the spacing: points nearer to the surface than this lie on it, and no end of a chord counts as nearer.
constexpr double on_surface = 1e-9, nearest = 1e-3;
/// Shares of corners that a point on an edge may have by rounding.
constexpr double on_edge = 1e-9;

std::array<double, 3> array_of(Vec3d v) { return {v.x, v.y, v.z}; }
std::array<std::int32_t, 3> array_of(Vec3i v) { return {v.x, v.y, v.z}; }

/// Lines of sites along one axis, and where they meet a mesh.
class Lines {
 public:
  Lines(std::size_t axis, const std::vector<Vec3i>& sites)
      : axis_(axis), u_((axis + 1) % 3), v_((axis + 2) % 3) {
    low_u_ = high_u_ = array_of(sites.front())[u_];
    low_v_ = high_v_ = array_of(sites.front())[v_];
    for (const Vec3i& s : sites) {
      const auto p = array_of(s);
      low_u_ = std::min(low_u_, p[u_]);
      high_u_ = std::max(high_u_, p[u_]);
      low_v_ = std::min(low_v_, p[v_]);
      high_v_ = std::max(high_v_, p[v_]);
    }
    hits_.resize(static_cast<std::size_t>(high_u_ - low_u_ + 1) *
                 static_cast<std::size_t>(high_v_ - low_v_ + 1));
  }

  /// corners: in units in which site i is at i.
  void add(std::uint32_t number, const std::array<std::array<double, 3>, 3>& corners) {
    const auto& a = corners[0];
    const auto& b = corners[1];
    const auto& c = corners[2];
    const double area = (b[u_] - a[u_]) * (c[v_] - a[v_]) - (c[u_] - a[u_]) * (b[v_] - a[v_]);
    if (area == 0) return;  // it lies along the axis
    const auto least = [&](std::size_t k) { return std::min({a[k], b[k], c[k]}); };
    const auto most = [&](std::size_t k) { return std::max({a[k], b[k], c[k]}); };
    const auto first_u =
                   static_cast<std::int32_t>(std::max(double(low_u_), std::ceil(least(u_) - on_surface))),
               last_u =
                   static_cast<std::int32_t>(std::min(double(high_u_), std::floor(most(u_) + on_surface))),
               first_v =
                   static_cast<std::int32_t>(std::max(double(low_v_), std::ceil(least(v_) - on_surface))),
               last_v =
                   static_cast<std::int32_t>(std::min(double(high_v_), std::floor(most(v_) + on_surface)));
    for (std::int32_t v = first_v; v <= last_v; ++v)
      for (std::int32_t u = first_u; u <= last_u; ++u) {
        Hit h;
        h.share[1] = ((u - a[u_]) * (c[v_] - a[v_]) - (c[u_] - a[u_]) * (v - a[v_])) / area;
        h.share[2] = ((b[u_] - a[u_]) * (v - a[v_]) - (u - a[u_]) * (b[v_] - a[v_])) / area;
        h.share[0] = 1 - h.share[1] - h.share[2];
        if (std::min({h.share[0], h.share[1], h.share[2]}) < -on_edge) continue;
        h.at = h.share[0] * a[axis_] + h.share[1] * b[axis_] + h.share[2] * c[axis_];
        h.triangle = number;
        hits_[line(u, v)].push_back(h);
      }
  }

  void sort() {
    for (auto& line : hits_)
      std::stable_sort(line.begin(), line.end(), [](const Hit& a, const Hit& b) { return a.at < b.at; });
  }

  /// The nearest hits on either side of a site; null where there is none.
  std::pair<const Hit*, const Hit*> around(Vec3i site) const {
    const auto p = array_of(site);
    const double at = p[axis_];
    const Hit *below = nullptr, *above = nullptr;
    for (const Hit& h : hits_[line(p[u_], p[v_])]) {
      if (h.at <= at + on_surface) below = &h;
      if (h.at >= at - on_surface && above == nullptr) above = &h;
    }
    return {below, above};
  }
  double along(Vec3i site) const { return array_of(site)[axis_]; }

 private:
  std::size_t line(std::int32_t u, std::int32_t v) const {
    return static_cast<std::size_t>(u - low_u_) +
           static_cast<std::size_t>(v - low_v_) * static_cast<std::size_t>(high_u_ - low_u_ + 1);
  }
  std::size_t axis_, u_, v_;
  std::int32_t low_u_ = 0, high_u_ = 0, low_v_ = 0, high_v_ = 0;
  std::vector<std::vector<Hit>> hits_;
};

}  // namespace

std::size_t bind_sites(const TriangleMesh& mesh, Vec3d origin, double spacing,
                       const std::vector<Vec3i>& sites, MeshChords& chords) {
  chords = {};
  chords.vertices_ = mesh.vertices.size();
  chords.begin_.push_back(0);
  if (sites.empty()) return 0;
  std::vector<std::array<double, 3>> corners;
  corners.reserve(mesh.vertices.size());
  for (const Vec3d& v : mesh.vertices)
    corners.push_back(array_of((v - origin) * (1 / spacing) - Vec3d{0.5, 0.5, 0.5}));
  std::array<Lines, 3> lines{Lines(0, sites), Lines(1, sites), Lines(2, sites)};
  for (Lines& l : lines) {
    for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3)
      l.add(static_cast<std::uint32_t>(t / 3),
            {corners[mesh.indices[t]], corners[mesh.indices[t + 1]], corners[mesh.indices[t + 2]]});
    l.sort();
  }
  for (const Vec3i& site : sites) {
    const std::size_t first = chords.weight_.size();
    double sum = 0;
    for (const Lines& l : lines) {
      const auto [below, above] = l.around(site);
      if (below == nullptr || above == nullptr) continue;
      const double d1 = std::max(l.along(site) - below->at, nearest),
                   d2 = std::max(above->at - l.along(site), nearest), weight = physics::chord_weight(d1, d2);
      sum += weight;
      for (const auto& [hit, share] : {std::pair(below, d2 / (d1 + d2)), std::pair(above, d1 / (d1 + d2))})
        for (std::size_t k = 0; k < 3; ++k) {
          chords.vertex_.push_back(mesh.indices[3 * std::size_t{hit->triangle} + k]);
          chords.weight_.push_back(weight * share * hit->share[k]);
        }
    }
    if (chords.weight_.size() == first) return chords.sites();
    for (std::size_t k = first; k < chords.weight_.size(); ++k) chords.weight_[k] /= sum;
    chords.begin_.push_back(chords.weight_.size());
  }
  return chords.sites();
}

}  // namespace core

TriangleMesh mesh_of(const Shape& shape) {
  TriangleMesh mesh;
  if (const ShapeNode* node = ShapeAccess::node(shape)) static_cast<void>(node->mesh({}, mesh));
  return mesh;
}

}  // namespace v0
}  // namespace meltsim
