// SPDX-License-Identifier: Apache-2.0
// Built in place of mesh_assimp.cpp where MELTSIM_ASSIMP is off.
#include "shape/mesh_formats.hpp"

namespace meltsim {
inline namespace v0 {

std::optional<Result<TriangleMesh>> read_other(const MeshSource&, std::string& why_not) {
  why_not = "other formats need a build with -DMELTSIM_ASSIMP=ON";
  return std::nullopt;
}

}  // namespace v0
}  // namespace meltsim
