// SPDX-License-Identifier: Apache-2.0
// SurfaceFrame: the one argument of the surface module's bodies. It has a frame of its own because it works
// between sub-steps, on particles in its own order, and on buffers that no step touches.
#pragma once

#include <cstdint>

#include "frame/cube_table.hpp"
#include "frame/frame.hpp"
#include "meltsim/physics/surface_field.hpp"
#include "meltsim/surface.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Numbers of items found, whether or not the buffers have room for them.
struct SurfaceCounts {
  std::uint32_t groups = 0, blocks = 0, vertices = 0, triangles = 0;
  std::uint32_t halted = 0;  ///< the World's own flag
};

template <class T>
struct SurfaceHeat {
  T temperature{}, liquid_fraction{};
};

/// G of a particle's ellipsoid.
template <class T>
struct SurfaceShape {
  Vec4<T> diagonal;  ///< xx, yy, zz; w = xy
  T yz{}, zx{};
};

/// The four vertices that a vertex is joined to across the faces beside its edge, counter-clockwise seen from
/// outside.
struct alignas(16) SurfaceRing {
  std::uint32_t at[4] = {};
};

/// Links of a block to a neighbour that is not in the list: all its nodes are outside, or inside.
inline constexpr std::uint32_t link_outside = 0xffffffffu, link_inside = 0xfffffffeu;

/// Region that contains a node. Beneath a solid's surface a node is outside of the liquid.
inline constexpr std::uint8_t node_outside = 0, node_inside = 1, node_in_solid = 2;

/// In `code`: the cell has no triangles, because only solids bound the liquid in it.
inline constexpr std::uint32_t code_at_solid = 1u << 11;

// Marks of a particle, and of a group: of all its particles.
inline constexpr std::uint8_t mark_solid = 1, mark_liquid = 2, mark_surface = 4;

/// Blocks of side^3 nodes are also the cells of the particle grid: occupied ones are groups. Node 0 of a
/// block is its low corner.
template <class T>
struct SurfaceGrid {
  Vec3<T> base{};            ///< low corner of block `offset`, in stored coordinates
  T cell{};                  ///< between nodes [m]
  T edge{}, inv_edge{};      ///< of a block, at least H_s [m]
  std::int32_t side = 1;     ///< nodes per edge of a block
  std::uint32_t volume = 1;  ///< side^3
  std::int32_t nx = 1, ny = 1, nz = 1, offset = 1;
  std::uint32_t key_bits = 64;
};

template <class T>
struct SurfaceFrame {
  // the World's particles
  const Vec4<T>* position = nullptr;
  const double *enthalpy = nullptr, *enthalpy_of_id = nullptr;  ///< one of them
  const T* mass = nullptr;
  const std::uint32_t *tag = nullptr, *id = nullptr;
  const std::uint32_t* slot_of_id = nullptr;
  const MaterialRow<T>* materials = nullptr;
  const WorldStatus* status = nullptr;
  std::uint32_t particles = 0;  ///< ids

  // whose surface
  std::uint32_t only_solids = 0;
  std::uint32_t only_body = 0;  ///< body index + 1; 0 = any
  bool two_fields = false;      ///< liquid beside solids: all of it, less the solids
  T overlap{};  ///< how far the liquid's mesh reaches into solids [cells]; 0 = it is closed there
  bool anisotropic = false;
  bool coarse_first = false;  ///< cells are small enough that every second node tells about those between

  physics::SurfaceField<T> field;
  WallBox<T> walls;
  Vec3<T> clip_min{}, clip_max{};  ///< the mesh is closed there; far away where it is not
  Vec3<T> period{};                ///< 0 = not periodic
  Vec3<T> shift{};                 ///< taken off the positions handed out
  SurfaceGrid<T> grid;
  std::uint32_t max_groups = 0, max_blocks = 0, max_vertices = 0, max_triangles = 0;

  SurfaceCounts* counts = nullptr;
  SurfaceDraw* draw = nullptr;
  // per particle; from key_out on in order of cell, then id
  std::uint64_t *key = nullptr, *key_out = nullptr;
  std::uint32_t *slot = nullptr, *slot_out = nullptr, *group_of = nullptr;
  Vec4<T>* point = nullptr;            ///< position, V
  Vec4<T>* share = nullptr;            ///< position, V g
  SurfaceShape<T>* shape = nullptr;    ///< where anisotropic
  T* solid_share = nullptr;            ///< V g of solids by themselves, 0 for liquid
  std::uint8_t* mark = nullptr;        ///< what it is
  std::uint8_t* at_surface = nullptr;  ///< 1: yes
  SurfaceHeat<T>* heat = nullptr;
  // per group
  std::uint64_t* group_key = nullptr;
  std::uint32_t* group_begin = nullptr;  ///< one more than groups
  Range* group_rows = nullptr;           ///< 9 per group: particles
  Range* group_near = nullptr;           ///< the same rows: groups
  std::uint8_t* group_mark = nullptr;
  std::uint32_t* group_deep = nullptr;  ///< 0, link_inside or link_outside
  std::uint32_t* owns = nullptr;  ///< 27 per group: blocks around it that it lists; then their running count
  // per block
  std::uint64_t* block_key = nullptr;
  Range* block_rows = nullptr;          ///< 9 per block
  std::uint32_t* block_link = nullptr;  ///< 27 per block
  // per node
  T* value = nullptr;              ///< phi - level
  T* solid_value = nullptr;        ///< level - phi of the solids
  std::uint8_t* inside = nullptr;  ///< node_outside, node_inside or node_in_solid
  std::uint32_t* code =
      nullptr;  ///< bits 0-7: corners of its cell inside; 8-10: its edges with a vertex; 11:
                ///< code_at_solid
  std::uint64_t* ends = nullptr;  ///< running counts: vertices in the low half, triangles in the high one
  // per vertex
  std::uint32_t* vertex_edge = nullptr;              ///< 4 node + axis
  Vec4<T>*vertex = nullptr, *vertex_next = nullptr;  ///< w = 1: it stays where it is
  SurfaceRing* ring = nullptr;
  Vec3<float>*out_position = nullptr, *out_normal = nullptr;
  float *out_temperature = nullptr, *out_fraction = nullptr;
  std::uint32_t *out_body = nullptr, *out_material = nullptr;
  std::uint32_t* out_triangles = nullptr;
  const CubeCase* cases = nullptr;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
