// SPDX-License-Identifier: Apache-2.0
#include "shape/mesh_ply_header.hpp"

#include "shape/mesh_text.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

PlyType type_of(std::string_view word) {
  struct Name {
    std::string_view old_name, name;
    PlyType type;
  };
  constexpr Name names[] = {{"char", "int8", PlyType::int8},        {"uchar", "uint8", PlyType::uint8},
                            {"short", "int16", PlyType::int16},     {"ushort", "uint16", PlyType::uint16},
                            {"int", "int32", PlyType::int32},       {"uint", "uint32", PlyType::uint32},
                            {"float", "float32", PlyType::float32}, {"double", "float64", PlyType::float64}};
  for (const Name& n : names)
    if (word == n.old_name || word == n.name) return n.type;
  return PlyType::none;
}

class HeaderReader {
 public:
  explicit HeaderReader(const MeshSource& source) : source_(source), lines_(source.bytes, false) {}

  Result<PlyHeader> read() {
    bool have_format = false;
    lines_.next();  // the "ply" by which the format was recognised
    while (lines_.next()) {
      const std::string_view word = lines_.token();
      Status s;
      if (word == "end_header") {
        if (!have_format) return expected("'format' before 'end_header'", word).error();
        header_.bytes = lines_.behind();
        header_.lines = lines_.place().number;
        return std::move(header_);
      }
      if (word == "format") {
        s = format();
        have_format = true;
      } else if (word == "element") {
        s = element();
      } else if (word == "property") {
        s = property();
      } else if (!word.empty() && word != "comment" && word != "obj_info") {
        s = expected("'format', 'element', 'property' or 'end_header'", word);
      }
      if (!s) return s.error();
    }
    return source_.error(lines_.place(), "the file ends before 'end_header'; it is cut off, export it again");
  }

 private:
  Status format() {
    const std::string_view word = lines_.token();
    if (word == "ascii") header_.format = PlyFormat::text;
    else if (word == "binary_little_endian") header_.format = PlyFormat::little_endian;
    else if (word == "binary_big_endian") header_.format = PlyFormat::big_endian;
    else return expected("'ascii', 'binary_little_endian' or 'binary_big_endian'", word);
    return {};
  }

  Status element() {
    PlyElement e;
    e.name = lines_.token();
    e.declared = lines_.place();
    const std::string_view word = lines_.token();
    std::int64_t count = 0;
    if (!parse_integer(word, count) || count < 0) return expected("the number of elements", word);
    e.count = static_cast<std::uint64_t>(count);
    if (e.name == "face")
      if (Status s = check_triangle_count(source_, e.count, e.declared); !s) return s;
    header_.elements.push_back(std::move(e));
    return {};
  }

  Status property() {
    PlyProperty p;
    std::string_view word = lines_.token();
    if (header_.elements.empty()) return expected("'element' before 'property'", "property");
    if (word == "list") {
      word = lines_.token();
      p.count_type = type_of(word);
      if (p.count_type == PlyType::none || !ply_is_integer(p.count_type))
        return expected("an integer type for the length of the list", word);
      word = lines_.token();
    }
    p.type = type_of(word);
    if (p.type == PlyType::none) return expected("a type like float, int or uchar", word);
    p.name = lines_.token();
    if (p.name.empty()) return expected("the name of the property", p.name);
    header_.elements.back().properties.push_back(p);
    return {};
  }

  Status expected(const std::string& what, std::string_view found) const {
    return source_.error(lines_.place(), "expected " + what + ", found " + quoted(found));
  }

  const MeshSource& source_;
  TextLines lines_;
  PlyHeader header_;
};

}  // namespace

std::size_t ply_size(PlyType type) {
  switch (type) {
    case PlyType::none:
      return 0;
    case PlyType::int8:
    case PlyType::uint8:
      return 1;
    case PlyType::int16:
    case PlyType::uint16:
      return 2;
    case PlyType::int32:
    case PlyType::uint32:
    case PlyType::float32:
      return 4;
    case PlyType::float64:
      return 8;
  }
  return 0;
}

Result<PlyHeader> read_ply_header(const MeshSource& source) { return HeaderReader(source).read(); }

}  // namespace v0
}  // namespace meltsim
