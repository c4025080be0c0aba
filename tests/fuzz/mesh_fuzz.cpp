// SPDX-License-Identifier: Apache-2.0
// libFuzzer: arbitrary bytes as a mesh file. What is read must be a mesh that samples or an error that says
// something. Build and run, from the root of the sources:
//   clang++ -std=c++17 -O1 -g -fsanitize=fuzzer,address,undefined -Iinclude -Isrc tests/fuzz/mesh_fuzz.cpp
//       src/shape/*.cpp -o mesh_fuzz && ./mesh_fuzz -max_len=4096
#include <cstdint>
#include <cstdlib>

#include "shape/mesh_formats.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace meltsim;
  const std::string name = "fuzz";
  const Result<TriangleMesh> mesh = read_any_mesh({{reinterpret_cast<const char*>(data), size}, name});
  if (!mesh) {
    if (mesh.error().message.empty()) std::abort();
    return 0;
  }
  const Shape shape = Shape::mesh(*mesh);
  if (!shape.validate()) std::abort();
  const Box b = shape.bounds();
  // Eight sites along the longest side: enough to raster, little enough to be fast.
  const double side = maximum(b.max.x - b.min.x, maximum(b.max.y - b.min.y, b.max.z - b.min.z));
  (void)shape.lattice_points({}, side / 8);
  return 0;
}
