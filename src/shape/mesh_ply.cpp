// SPDX-License-Identifier: Apache-2.0
// PLY: x, y, z of the element 'vertex' and the corner list of the element 'face'; the rest is passed over.
#include "shape/mesh_formats.hpp"
#include "shape/mesh_ply_values.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

constexpr std::size_t missing = static_cast<std::size_t>(-1);

std::size_t find_property(const PlyElement& element, std::string_view name) {
  for (std::size_t i = 0; i < element.properties.size(); ++i)
    if (element.properties[i].name == name) return i;
  return missing;
}

template <class Values>
class BodyReader {
 public:
  BodyReader(const MeshSource& source, const PlyHeader& header)
      : source_(source), header_(header), values_(source, header) {}

  Result<TriangleMesh> read() {
    if (Status s = refuse_strips(); !s) return s.error();
    for (const PlyElement& element : header_.elements)
      if (Status s = elements(element); !s) return s.error();
    return mesh_.finish(values_.place());
  }

 private:
  /// Meshes of strips alone would be said to have no triangles.
  Status refuse_strips() const {
    const PlyElement* strips = nullptr;
    for (const PlyElement& element : header_.elements) {
      if (element.name == "face" && element.count > 0) return {};
      if (element.name == "tristrips") strips = &element;
    }
    if (strips == nullptr) return {};
    return source_.error(strips->declared,
                         "the faces are triangle strips ('tristrips'), which are not read; export triangles");
  }

  Status elements(const PlyElement& element) {
    // Without properties nothing is stored, and a large count alone must not cost time.
    if (element.properties.empty() && element.name != "vertex" && element.name != "face") return {};
    if (Status s = find_fields(element); !s) return s;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      const FilePlace at = values_.place();
      if (Status s = values_.begin_element(); !s) return s;
      if (Status s = properties(element); !s) return s;
      if (Status s = values_.end_element(); !s) return s;
      if (Status s = keep(element, at.unit == FilePlace::line ? values_.place() : at); !s) return s;
    }
    return {};
  }

  Status find_fields(const PlyElement& element) {
    for (std::size_t& f : fields_) f = missing;
    if (element.name == "vertex") {
      const char* names[3] = {"x", "y", "z"};
      for (int i = 0; i < 3; ++i) {
        fields_[i] = find_property(element, names[i]);
        if (fields_[i] == missing || element.properties[fields_[i]].list())
          return source_.error(element.declared, std::string("expected the property '") + names[i] +
                                                     "' in the element 'vertex'");
      }
    } else if (element.name == "face") {
      std::size_t f = find_property(element, "vertex_indices");
      if (f == missing) f = find_property(element, "vertex_index");
      if (f == missing || !element.properties[f].list() || !ply_is_integer(element.properties[f].type))
        return source_.error(element.declared,
                             "expected 'property list' of integers named 'vertex_indices' in the element "
                             "'face'; export polygons, not strips");
      fields_[0] = f;
    }
    return {};
  }

  Status properties(const PlyElement& element) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& p = element.properties[i];
      double value = 0;
      if (!p.list()) {
        if (Status s = values_.value(p, p.type, value); !s) return s;
        for (int c = 0; c < 3; ++c)
          if (fields_[c] == i) point_[c] = value;
        continue;
      }
      const bool wanted = fields_[0] == i;
      double count = 0;
      const FilePlace at = values_.place();
      if (Status s = values_.value(p, p.count_type, count); !s) return s;
      if (count < 0)
        return source_.error(at, "expected the length of the list '" + std::string(p.name) + "', found " +
                                     std::to_string(static_cast<std::int64_t>(count)));
      if (wanted) corners_.clear();
      // No memory is set aside for the count: it may be anything in a damaged file, the values run out first.
      for (double k = 0; k < count; ++k) {
        if (Status s = values_.value(p, p.type, value); !s) return s;
        if (wanted) corners_.push_back(static_cast<std::int64_t>(value));
      }
    }
    return {};
  }

  Status keep(const PlyElement& element, FilePlace at) {
    if (element.name == "vertex") return mesh_.vertex({point_[0], point_[1], point_[2]}, at);
    if (element.name == "face") return mesh_.face(corners_, at, 0);
    return {};
  }

  const MeshSource& source_;
  const PlyHeader& header_;
  Values values_;
  MeshBuilder mesh_{source_};
  std::size_t fields_[3] = {missing, missing, missing};
  double point_[3] = {0, 0, 0};
  std::vector<std::int64_t> corners_;
};

}  // namespace

Result<TriangleMesh> read_ply(const MeshSource& source) {
  const Result<PlyHeader> header = read_ply_header(source);
  if (!header) return header.error();
  if (header->format == PlyFormat::text) return BodyReader<PlyTextValues>(source, *header).read();
  return BodyReader<PlyBinaryValues>(source, *header).read();
}

}  // namespace v0
}  // namespace meltsim
