// SPDX-License-Identifier: Apache-2.0
// The values behind the header of a PLY file, from text or from bytes.
#pragma once

#include "shape/mesh_bytes.hpp"
#include "shape/mesh_ply_header.hpp"
#include "shape/mesh_text.hpp"

namespace meltsim {
inline namespace v0 {

/// One element per line.
class PlyTextValues {
 public:
  PlyTextValues(const MeshSource& source, const PlyHeader& header)
      : source_(source), lines_(source.bytes.substr(header.bytes), false), header_lines_(header.lines) {}

  FilePlace place() const { return {FilePlace::line, header_lines_ + lines_.place().number}; }

  Status begin_element() {
    while (lines_.next()) {
      pending_ = lines_.token();
      if (!pending_.empty()) return {};
    }
    return source_.error(place(),
                         "the file ends before all elements were read; it is cut off, export it again");
  }

  Status value(const PlyProperty& property, PlyType type, double& out) {
    const std::string_view token = pending_;
    pending_ = lines_.token();
    std::int64_t whole = 0;
    // No integer type of the format is wider than 32 bits.
    constexpr std::int64_t widest = 0xffffffff;
    const bool good = ply_is_integer(type)
                          ? parse_integer(token, whole) && whole >= -widest && whole <= widest
                          : parse_number(token, out);
    if (!good)
      return source_.error(place(), std::string("expected ") +
                                        (ply_is_integer(type) ? "an integer" : "a number") + " for '" +
                                        std::string(property.name) + "', found " + quoted(token));
    if (ply_is_integer(type)) out = static_cast<double>(whole);
    return {};
  }

  Status end_element() const {
    if (pending_.empty()) return {};
    return source_.error(place(),
                         "expected the end of the line after the last property, found " + quoted(pending_));
  }

 private:
  const MeshSource& source_;
  TextLines lines_;
  std::uint64_t header_lines_;
  std::string_view pending_;  // next token of the line
};

class PlyBinaryValues {
 public:
  PlyBinaryValues(const MeshSource& source, const PlyHeader& header)
      : source_(source), at_(header.bytes), big_(header.format == PlyFormat::big_endian) {}

  FilePlace place() const { return {FilePlace::byte, at_}; }
  Status begin_element() const { return {}; }
  Status end_element() const { return {}; }

  Status value(const PlyProperty& property, PlyType type, double& out) {
    const std::size_t size = ply_size(type);
    if (source_.bytes.size() - at_ < size)
      return source_.error(place(), "the file ends inside '" + std::string(property.name) +
                                        "'; it is cut off, export it again");
    out = load(source_.bytes.data() + at_, type);
    at_ += size;
    return {};
  }

 private:
  double load(const char* c, PlyType type) const {
    const std::uint64_t bits = type == PlyType::float64 ? 0 : load_bits(c, ply_size(type), big_);
    switch (type) {
      case PlyType::int8:
        return static_cast<std::int8_t>(bits);
      case PlyType::int16:
        return static_cast<std::int16_t>(bits);
      case PlyType::int32:
        return static_cast<std::int32_t>(bits);
      case PlyType::float32:
        return static_cast<double>(load_float(c, big_));
      case PlyType::float64:
        return load_double(c, big_);
      default:
        return static_cast<double>(bits);
    }
  }

  const MeshSource& source_;
  std::size_t at_;
  bool big_;
};

}  // namespace v0
}  // namespace meltsim
