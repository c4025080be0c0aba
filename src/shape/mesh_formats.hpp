// SPDX-License-Identifier: Apache-2.0
// One reader per format. Each may throw std::bad_alloc, which read_mesh turns into an error.
#pragma once

#include <optional>

#include "shape/mesh_builder.hpp"

namespace meltsim {
inline namespace v0 {

Result<TriangleMesh> read_obj(const MeshSource& source);
Result<TriangleMesh> read_stl_text(const MeshSource& source);
Result<TriangleMesh> read_stl_binary(const MeshSource& source);
Result<TriangleMesh> read_ply(const MeshSource& source);
/// Reads any other format with assimp, from the file of the source's name. Empty if assimp cannot read it or was
/// not built in; why_not then says so.
std::optional<Result<TriangleMesh>> read_other(const MeshSource& source, std::string& why_not);
/// Picks the reader by the content.
Result<TriangleMesh> read_any_mesh(const MeshSource& source);

}  // namespace v0
}  // namespace meltsim
