// SPDX-License-Identifier: Apache-2.0
// A body as World::save() keeps it: what it was built from, without the state of its particles.
#pragma once

#include <cstdint>
#include <vector>

#include "description/growth_sites.hpp"
#include "meltsim/desc.hpp"

namespace meltsim {
inline namespace v0 {

struct StoredBody {
  /// As it is by now; the shape is its mesh, or a box as large as it. Not in it: whether the body is held, and until when.
  SolidDesc desc;
  std::uint32_t row = 0;             ///< BodyId::index
  bool watched = false;              ///< BodyRecord::watched
  bool forgotten = false;            ///< by compact(): only its row is there
  std::uint64_t vertices = 0;        ///< that it was built of
  std::int64_t longest = 0;          ///< BodyRecord::longest
  core::SiteBox box;                 ///< of its points and free sites
  std::vector<Vec3i> points;         ///< on the World's lattice, in the order of its vertices
  std::vector<Vec3i> free;           ///< sites that it may grow into, likewise
  std::vector<Vec4<float>> surface;  ///< of its points: SceneLattice::contact_shape
};

}  // namespace v0
}  // namespace meltsim
