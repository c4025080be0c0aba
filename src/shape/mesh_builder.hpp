// SPDX-License-Identifier: Apache-2.0
// What the readers of mesh files share: places, errors, and a mesh put together face by face.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "meltsim/result.hpp"
#include "meltsim/shape.hpp"

namespace meltsim {
inline namespace v0 {

/// Largest number of triangles: 32-bit indices still reach three corners each.
inline constexpr std::uint64_t max_mesh_triangles = 50'000'000;

/// Where in a file: a line of text (from 1) or a byte (from 0).
struct FilePlace {
  enum Unit { line, byte } unit = line;
  std::uint64_t number = 0;
};

/// The bytes of a file and the name that errors give it.
struct MeshSource {
  std::string_view bytes;
  const std::string& name;

  Error error(FilePlace at, const std::string& what) const;
};

class MeshBuilder {
 public:
  explicit MeshBuilder(const MeshSource& source) : source_(source) {}

  std::size_t vertices() const { return mesh_.vertices.size(); }
  Status vertex(Vec3d position, FilePlace at);
  /// Splits a face into a fan around its first corner. Corners may come before their vertices; those beyond
  /// the last vertex are found in finish(). `first` is the number that the format gives the first vertex.
  Status face(const std::vector<std::int64_t>& corners, FilePlace at, std::int64_t first);
  Result<TriangleMesh> finish(FilePlace end);

 private:
  const MeshSource& source_;
  TriangleMesh mesh_;
  std::int64_t greatest_ = -1;  // corner index, with where it was first met and how the file counts
  FilePlace greatest_at_;
  std::int64_t greatest_first_ = 0;
};

/// Refuses a count of triangles that a file announces.
Status check_triangle_count(const MeshSource& source, std::uint64_t count, FilePlace at);

}  // namespace v0
}  // namespace meltsim
