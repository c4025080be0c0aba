// SPDX-License-Identifier: Apache-2.0
// STL. Its triangles share no vertices; those with the same coordinates are merged here. Normals are ignored:
// they follow from the corners, and files often have them wrong.
#include <cstring>
#include <unordered_map>

#include "shape/mesh_bytes.hpp"
#include "shape/mesh_formats.hpp"
#include "shape/mesh_text.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

class MergedVertices {
 public:
  explicit MergedVertices(MeshBuilder& mesh) : mesh_(mesh) {}

  Status corner(Vec3d p, FilePlace at, std::vector<std::int64_t>& corners) {
    p = p + Vec3d{};  // -0 becomes +0, which compares equal but has other bits
    const auto [entry, fresh] = known_.try_emplace(p, static_cast<std::int64_t>(mesh_.vertices()));
    corners.push_back(entry->second);
    return fresh ? mesh_.vertex(p, at) : Status();
  }

 private:
  struct Hash {
    std::size_t operator()(Vec3d p) const {
      std::uint64_t h = 0;
      for (const double c : {p.x, p.y, p.z}) {
        std::uint64_t bits;
        std::memcpy(&bits, &c, sizeof bits);
        // Multiplication by 2^64 / golden ratio spreads the few bits in which round numbers differ.
        h = (h ^ bits) * 0x9e3779b97f4a7c15u;
        h ^= h >> 32;
      }
      return static_cast<std::size_t>(h);
    }
  };
  struct Equal {
    bool operator()(Vec3d a, Vec3d b) const { return a.x == b.x && a.y == b.y && a.z == b.z; }
  };

  MeshBuilder& mesh_;
  std::unordered_map<Vec3d, std::int64_t, Hash, Equal> known_;
};

class TextReader {
 public:
  explicit TextReader(const MeshSource& source) : source_(source), lines_(source.bytes, false) {}

  Result<TriangleMesh> read() {
    while (next_line()) {
      if (!same_word(word_, "solid")) return expected("'solid'").error();
      for (;;) {
        if (!next_line()) return cut_off("'endsolid'").error();
        if (same_word(word_, "endsolid")) break;
        if (!same_word(word_, "facet")) return expected("'facet' or 'endsolid'").error();
        if (Status s = facet(); !s) return s.error();
      }
    }
    return mesh_.finish(lines_.place());
  }

 private:
  Status facet() {
    const FilePlace at = lines_.place();
    std::vector<std::int64_t> corners;
    if (Status s = line_of("outer"); !s) return s;
    for (;;) {
      if (!next_line()) return cut_off("'vertex' or 'endloop'");
      if (same_word(word_, "endloop")) break;
      if (!same_word(word_, "vertex")) return expected("'vertex' or 'endloop'");
      Vec3d p;
      if (Status s = read_point(source_, lines_, p); !s) return s;
      if (Status s = vertices_.corner(p, lines_.place(), corners); !s) return s;
    }
    if (Status s = line_of("endfacet"); !s) return s;
    return mesh_.face(corners, at, 0);
  }

  /// Goes to the next line with anything on it.
  bool next_line() {
    while (lines_.next()) {
      word_ = lines_.token();
      if (!word_.empty()) return true;
    }
    return false;
  }

  Status line_of(const char* word) {
    const std::string wanted = std::string("'") + word + "'";
    if (!next_line()) return cut_off(wanted);
    return same_word(word_, word) ? Status() : expected(wanted);
  }

  Status expected(const std::string& what) const {
    return source_.error(lines_.place(), "expected " + what + ", found " + quoted(word_));
  }
  Status cut_off(const std::string& what) const {
    return source_.error(lines_.place(),
                         "the file ends where " + what + " was expected; it is cut off, export it again");
  }

  const MeshSource& source_;
  TextLines lines_;
  std::string_view word_;
  MeshBuilder mesh_{source_};
  MergedVertices vertices_{mesh_};
};

}  // namespace

Result<TriangleMesh> read_stl_text(const MeshSource& source) { return TextReader(source).read(); }

Result<TriangleMesh> read_stl_binary(const MeshSource& source) {
  // 80 bytes of anything, the count, then per triangle a normal, three corners and two bytes of attributes.
  constexpr std::size_t header = 84, record = 50;
  const std::string_view bytes = source.bytes;
  if (bytes.size() < header)
    return source.error(
        {FilePlace::byte, bytes.size()},
        "the file ends inside the 84 bytes of the header of a binary STL; it is cut off, export it again");
  const std::uint64_t count = load_bits(bytes.data() + 80, 4, false);
  if (bytes.size() != header + record * count)
    return source.error({FilePlace::byte, bytes.size()},
                        "a binary STL of " + std::to_string(count) + " triangles has " +
                            std::to_string(header + record * count) + " bytes but the file has " +
                            std::to_string(bytes.size()) +
                            "; it is damaged, cut off, or none of OBJ, STL and PLY; export it again");
  if (Status s = check_triangle_count(source, count, {FilePlace::byte, 80}); !s) return s.error();
  MeshBuilder mesh(source);
  MergedVertices vertices(mesh);
  std::vector<std::int64_t> corners;
  for (std::uint64_t t = 0; t < count; ++t) {
    const std::size_t begin = header + record * t;
    corners.clear();
    for (std::size_t at = begin + 12; at < begin + 48; at += 12) {
      const char* c = bytes.data() + at;
      const Vec3d p =
          cast<double>(Vec3f{load_float(c, false), load_float(c + 4, false), load_float(c + 8, false)});
      if (Status s = vertices.corner(p, {FilePlace::byte, at}, corners); !s) return s.error();
    }
    if (Status s = mesh.face(corners, {FilePlace::byte, begin}, 0); !s) return s.error();
  }
  return mesh.finish({FilePlace::byte, bytes.size()});
}

}  // namespace v0
}  // namespace meltsim
