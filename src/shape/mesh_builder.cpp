// SPDX-License-Identifier: Apache-2.0
#include "shape/mesh_builder.hpp"

#include "shape/shape_limits.hpp"

namespace meltsim {
inline namespace v0 {

Error MeshSource::error(FilePlace at, const std::string& what) const {
  const char* unit = at.unit == FilePlace::line ? ", line " : ", byte ";
  return {ErrorCode::invalid_argument,
          "mesh file '" + name + "'" + unit + std::to_string(at.number) + ": " + what};
}

Status check_triangle_count(const MeshSource& source, std::uint64_t count, FilePlace at) {
  if (count <= max_mesh_triangles) return {};
  return source.error(at, "the mesh has more than 50 million triangles; simplify it before reading");
}

Status MeshBuilder::vertex(Vec3d position, FilePlace at) {
  for (const double c : {position.x, position.y, position.z})
    if (!(std::abs(c) <= max_coordinate))
      return source_.error(at, "expected a finite coordinate of at most 1e30 in magnitude, found " +
                                   number_text(c) + "; repair the mesh");
  if (mesh_.vertices.size() >= 3 * max_mesh_triangles)
    return source_.error(at, "the mesh has more than 150 million vertices; simplify it before reading");
  mesh_.vertices.push_back(position);
  return {};
}

Status MeshBuilder::face(const std::vector<std::int64_t>& corners, FilePlace at, std::int64_t first) {
  if (corners.size() < 3)
    return source_.error(at,
                         "expected a face with at least 3 corners, found " + std::to_string(corners.size()));
  if (Status s = check_triangle_count(source_, mesh_.indices.size() / 3 + corners.size() - 2, at); !s)
    return s;
  const auto most = static_cast<std::int64_t>(3 * max_mesh_triangles);
  for (const std::int64_t c : corners) {
    if (c < 0 || c >= most)
      return source_.error(at, "a face refers to vertex " + std::to_string(c + first) +
                                   ", which cannot exist; vertices count from " + std::to_string(first));
    if (c <= greatest_) continue;
    greatest_ = c;
    greatest_at_ = at;
    greatest_first_ = first;
  }
  for (std::size_t i = 2; i < corners.size(); ++i)
    for (const std::int64_t c : {corners[0], corners[i - 1], corners[i]})
      mesh_.indices.push_back(static_cast<std::uint32_t>(c));
  return {};
}

Result<TriangleMesh> MeshBuilder::finish(FilePlace end) {
  if (mesh_.indices.empty())
    return source_.error(end,
                         "expected at least one face before the end of the file; export the surface, "
                         "not points or lines");
  if (greatest_ >= static_cast<std::int64_t>(mesh_.vertices.size()))
    return source_.error(greatest_at_, "a face refers to vertex " +
                                           std::to_string(greatest_ + greatest_first_) +
                                           " but the file has " + std::to_string(mesh_.vertices.size()) +
                                           " vertices counted from " + std::to_string(greatest_first_) +
                                           "; the file may be cut off, export it again");
  return std::move(mesh_);
}

}  // namespace v0
}  // namespace meltsim
