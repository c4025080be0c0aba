// SPDX-License-Identifier: Apache-2.0
// How lattice sites inside a mesh follow its vertices (meltsim/physics/mesh_motion.hpp).
#pragma once

#include <cstdint>
#include <vector>

#include "meltsim/shape.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Weights of vertices per site: the place of a site is the weighted sum of theirs. They sum up to 1.
class MeshChords {
 public:
  std::size_t sites() const { return begin_.empty() ? 0 : begin_.size() - 1; }
  std::size_t vertices() const { return vertices_; }  ///< of the mesh

  /// Weighted sum of a value per vertex.
  Vec3d at(std::size_t site, const std::vector<Vec3d>& values) const {
    Vec3d sum{};
    for (std::size_t k = begin_[site]; k < begin_[site + 1]; ++k) sum += values[vertex_[k]] * weight_[k];
    return sum;
  }

 private:
  friend std::size_t bind_sites(const TriangleMesh&, Vec3d, double, const std::vector<Vec3i>&, MeshChords&);
  std::vector<std::size_t> begin_;  ///< per site and one more, in what follows
  std::vector<std::uint32_t> vertex_;
  std::vector<double> weight_;
  std::size_t vertices_ = 0;
};

/// Binds the sites origin + (i + 1/2) spacing to a mesh. Returns how many are bound: fewer than there are if from the next one no
/// axis meets the mesh on both sides.
std::size_t bind_sites(const TriangleMesh& mesh, Vec3d origin, double spacing,
                       const std::vector<Vec3i>& sites, MeshChords& chords);

}  // namespace core

/// The mesh of a shape that is one, moved or not, with its vertices where they are; without indices: it is none.
TriangleMesh mesh_of(const Shape& shape);

}  // namespace v0
}  // namespace meltsim
