// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file: which elements follow, and what each is made of.
#pragma once

#include <string_view>
#include <vector>

#include "shape/mesh_builder.hpp"

namespace meltsim {
inline namespace v0 {

enum class PlyType { none, int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t ply_size(PlyType type);
inline bool ply_is_integer(PlyType type) { return type < PlyType::float32; }

struct PlyProperty {
  std::string_view name;
  PlyType type = PlyType::none;
  PlyType count_type = PlyType::none;  ///< of a list; none for a single value
  bool list() const { return count_type != PlyType::none; }
};

struct PlyElement {
  std::string_view name;
  std::uint64_t count = 0;
  FilePlace declared;
  std::vector<PlyProperty> properties;
};

enum class PlyFormat { text, little_endian, big_endian };

struct PlyHeader {
  PlyFormat format = PlyFormat::text;
  std::vector<PlyElement> elements;
  std::size_t bytes = 0;    ///< the data start here,
  std::uint64_t lines = 0;  ///< behind this many lines
};

Result<PlyHeader> read_ply_header(const MeshSource& source);

}  // namespace v0
}  // namespace meltsim
