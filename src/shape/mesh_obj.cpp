// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: positions and polygons; everything else is passed over.
#include "shape/mesh_formats.hpp"
#include "shape/mesh_text.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

/// The position of a corner v, v/vt, v//vn or v/vt/vn, counted from 0.
Status read_corner(const MeshSource& source, const TextLines& lines, std::string_view token,
                   std::size_t vertices, std::int64_t& corner) {
  std::int64_t index = 0;
  const bool plain = token.find_first_not_of("+-0123456789/") == std::string_view::npos;
  if (!plain || !parse_integer(token.substr(0, token.find('/')), index))
    return source.error(lines.place(),
                        "expected a corner like 1, 1/2, 1//3 or 1/2/3, found " + quoted(token));
  const auto count = static_cast<std::int64_t>(vertices);
  if (index == 0 || index < -count)
    return source.error(lines.place(), "a face refers to vertex " + std::to_string(index) + " but " +
                                           std::to_string(count) +
                                           " vertices precede it; count from 1, or from -1 backwards");
  corner = index > 0 ? index - 1 : count + index;
  return {};
}

}  // namespace

Result<TriangleMesh> read_obj(const MeshSource& source) {
  TextLines lines(source.bytes, true);
  MeshBuilder mesh(source);
  std::vector<std::int64_t> corners;
  while (lines.next()) {
    const std::string_view keyword = lines.token();
    if (keyword == "v") {
      Vec3d p;  // a weight or a colour may follow
      if (Status s = read_point(source, lines, p); !s) return s.error();
      if (Status s = mesh.vertex(p, lines.place()); !s) return s.error();
    } else if (keyword == "f") {
      corners.clear();
      for (std::string_view t = lines.token(); !t.empty() && t[0] != '#'; t = lines.token()) {
        corners.push_back(0);
        if (Status s = read_corner(source, lines, t, mesh.vertices(), corners.back()); !s) return s.error();
      }
      if (Status s = mesh.face(corners, lines.place(), 1); !s) return s.error();
    }
  }
  return mesh.finish(lines.place());
}

}  // namespace v0
}  // namespace meltsim
