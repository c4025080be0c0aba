// SPDX-License-Identifier: Apache-2.0
// Kernels of the surface: particles into cells, the field around surface particles.
#pragma once

#include "meltsim/physics/heat.hpp"
#include "surface/field.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

using core::mark_liquid;
using core::mark_solid;

/// Whether a particle takes part.
template <class T>
MELTSIM_HD bool is_member(const SurfaceFrame<T>& w, std::uint32_t tag) {
  if (is_removed(tag)) return false;
  if (w.only_solids == 0u) return true;
  return is_solid(tag) && (w.only_body == 0u || body_of(tag) == w.only_body);
}

/// One call per id, so that the order within a cell is that of ids, whatever the history.
template <class T>
struct SurfaceKeysBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t id) const {
    const std::uint32_t slot = w.slot_of_id[id];
    w.slot[id] = slot;
    w.key[id] =
        is_member(w, w.tag[slot]) ? key_of(w, cell_at(w, xyz(w.position[slot]), 1)) : core::removed_key;
  }
};

template <class T>
struct SurfaceHeadBody {
  SurfaceFrame<T> w;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i) const {
    const std::uint64_t key = w.key_out[i];
    return key != core::removed_key && (i == 0 || w.key_out[i - 1] != key) ? 1u : 0u;
  }
};

/// Lists the groups; copies what later sums need into their order.
template <class T>
struct SurfaceGroupsBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint64_t key = w.key_out[i];
    const bool live = key != core::removed_key;
    const std::uint32_t count = w.group_of[i];  // heads up to and including i
    const auto put = [&](std::uint32_t g, std::uint64_t first) {
      if (g <= w.max_groups) w.group_begin[g] = static_cast<std::uint32_t>(first);
    };
    if (live && (i == 0 || w.key_out[i - 1] != key)) {
      put(count - 1u, i);
      if (count <= w.max_groups) w.group_key[count - 1u] = key;
    }
    if (i + 1 == w.particles || (live && w.key_out[i + 1] == core::removed_key)) {
      if (live || count == 0u) {
        put(count, live ? i + 1 : 0);
        w.counts->groups = count;
      }
    }
    if (i == 0) w.counts->halted = w.status != nullptr ? w.status->halted : 0u;
    w.group_of[i] = live ? count - 1u : none;
    if (!live) return;
    const std::uint32_t slot = w.slot_out[i], tag = w.tag[slot];
    const core::MaterialRow<T>& m = w.materials[material_of(tag)];
    const double h = w.enthalpy[slot] / static_cast<double>(w.mass[slot]);
    w.point[i] = w.position[slot];
    w.mark[i] = is_solid(tag) ? mark_solid : mark_liquid;
    const double both = is_solid(tag) ? 0.0 : 1.0;
    w.heat[i] = {static_cast<T>(physics::temperature_of(m, h)),
                 static_cast<T>(m.plateau != 0u ? physics::liquid_fraction(m, h) : both)};
  }
};

/// One call per group and row.
template <class T>
struct SurfaceRowsBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const auto g = static_cast<std::uint32_t>(k / 9);
    if (g >= groups_of(w)) return;
    w.group_rows[k] =
        particles_in(w, key_row(w, coordinates(w, w.group_key[g]), static_cast<std::uint32_t>(k % 9)));
  }
};

/// The sum around a particle says how much it stands for, and whether it is at a surface.
template <class T>
struct SurfaceShareBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t g = w.group_of[i];
    if (g >= groups_of(w)) return;  // none, or no room
    const Vec4<T> p = w.point[i];
    const std::uint8_t* const mark = w.mark;
    const FieldSums<T> s = sums_at(
        w, w.group_rows + std::uint64_t{9} * g, xyz(p), w.point,
        [mark](std::uint32_t j, T v) { return (mark[j] & mark_solid) != 0u ? v : T(0); },
        [](std::uint32_t, Vec3<T>, T straight) { return straight; });
    const bool solid = w.two_fields && w.mark[i] == mark_solid;
    w.share[i] = with_w(xyz(p), p.w * physics::surface_gain(w.field, s.all));
    if (w.two_fields) w.solid_share[i] = solid ? p.w * physics::surface_gain(w.field, s.solid) : T(0);
    const bool at_surface = s.all < w.field.full_sum || (solid && s.solid < w.field.full_sum);
    w.at_surface[i] = at_surface ? 1u : 0u;
  }
};

/// Makes ellipsoids of the balls.
template <class T>
struct SurfaceShapeBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t g = w.group_of[i];
    if (g >= groups_of(w)) return;
    const Vec4<T> p = w.share[i];
    const bool solid = w.two_fields && w.mark[i] == mark_solid;
    const physics::Ellipsoid<T> e = physics::make_ellipsoid(
        shape_sums(w, w.group_rows + std::uint64_t{9} * g, xyz(w.point[i]), solid), w.field.full);
    // What is flat stands for its volume; only what stands alone needs more.
    const auto share = [&](T gained, T volume) { return e.det * (gained + e.trust * (volume - gained)); };
    const T volume = w.point[i].w;
    w.share[i] = with_w(xyz(p), share(p.w, volume));
    if (w.two_fields) w.solid_share[i] = solid ? share(w.solid_share[i], volume) : T(0);
    w.shape[i] = {{e.xx, e.yy, e.zz, e.xy}, e.yz, e.zx};
  }
};

/// Whether a group is far inside: nothing to see in its block.
template <class T>
struct SurfaceDeepBody {
  SurfaceFrame<T> w;
  MELTSIM_HD std::uint32_t deep(std::uint32_t g) const {
    const std::uint32_t groups = groups_of(w);
    const Index3 c = coordinates(w, w.group_key[g]);
    const Vec3<T> low = node_position(w, c, {}), high = node_position(w, c + Index3{1, 1, 1}, {});
    const bool clear = low.x > w.clip_min.x && low.y > w.clip_min.y && low.z > w.clip_min.z &&
                       high.x < w.clip_max.x && high.y < w.clip_max.y && high.z < w.clip_max.z;
    if (!clear) return 0;
    std::uint8_t kinds = 0;
    for (std::uint32_t r = 0; r < 9; ++r) {
      const KeyRow row = key_row(w, c, r);
      const std::uint32_t a = spatial::first_not_below(w.group_key, groups, row.first);
      if (a + 2 >= groups || w.group_key[a] != row.first || w.group_key[a + 2] != row.last) return 0;
      for (std::uint32_t j = w.group_begin[a]; j < w.group_begin[a + 3]; ++j) {
        if (w.at_surface[j] != 0u) return 0;
        kinds |= w.mark[j];
      }
    }
    if (!w.two_fields) return link_inside;
    return kinds == mark_liquid ? link_inside : kinds == mark_solid ? link_outside : 0u;
  }
  MELTSIM_HD void operator()(std::uint64_t g) const {
    if (g < groups_of(w)) w.group_deep[g] = deep(static_cast<std::uint32_t>(g));
  }
};

/// One call per group and direction: whether the group lists the block there.
template <class T>
struct SurfaceOwnsBody {
  SurfaceFrame<T> w;
  MELTSIM_HD bool owns(std::uint32_t g, std::uint32_t d) const {
    if (g >= groups_of(w)) return false;
    if (d == 13u) return w.group_deep[g] == 0u;
    if (w.group_deep[g] != 0u) return false;  // no cell beside it is empty
    const Index3 c = coordinates(w, w.group_key[g]) + direction(d);
    return group_at(w, c) == none && owner_of(w, c) == g;
  }
  MELTSIM_HD void operator()(std::uint64_t k) const {
    w.owns[k] = owns(static_cast<std::uint32_t>(k / 27), static_cast<std::uint32_t>(k % 27)) ? 1u : 0u;
  }
};

struct SurfaceOwnsCountBody {
  const std::uint32_t* owns;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t k) const { return owns[k]; }
};

template <class T>
struct SurfaceBlocksBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    if (k + 1 == std::uint64_t{27} * w.max_groups) w.counts->blocks = w.owns[k];
    if (!is_listed(w, k) || w.owns[k] > w.max_blocks) return;
    const Index3 c = coordinates(w, w.group_key[k / 27]) + direction(static_cast<std::uint32_t>(k % 27));
    w.block_key[w.owns[k] - 1u] = key_of(w, c);
  }
};

/// One call per block and direction: the block there; nine of them also look for the particles of a row.
template <class T>
struct SurfaceLinksBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const auto b = static_cast<std::uint32_t>(k / 27), d = static_cast<std::uint32_t>(k % 27);
    if (b >= blocks_of(w)) return;
    const Index3 c = coordinates(w, w.block_key[b]);
    w.block_link[k] = d == 13u ? b : link_to(w, c + direction(d));
    if (d < 9u) w.block_rows[std::uint64_t{9} * b + d] = particles_in(w, key_row(w, c, d));
  }
};

/// The field at a node, and whether that is inside.
template <bool Anisotropic, class T>
MELTSIM_HD void evaluate_node(const SurfaceFrame<T>& w, std::uint32_t b, Index3 n) {
  const Vec3<T> x = node_position(w, coordinates(w, w.block_key[b]), n), at = clipped(w, x);
  const std::uint32_t must = forced(w, b, n);
  T value = must == link_inside ? T(0.5) : T(-0.5), solid = T(0.5);
  bool in = must == link_inside;
  const Vec3<T> beyond = x - at;
  // Next to what is beyond a face of the domain by more than a cell there are no vertices.
  const T cell = T(0.99) * w.grid.cell;
  const bool near = std::fabs(beyond.x) < cell && std::fabs(beyond.y) < cell && std::fabs(beyond.z) < cell;
  if (must == 0u && near) {
    const FieldSums<T> s = field_at<Anisotropic>(w, w.block_rows + std::uint64_t{9} * b, at);
    value = s.all - w.field.level;
    solid = w.field.level - s.solid;
    in = value > T(0) && (!w.two_fields || solid > T(0)) && x.x > w.clip_min.x && x.y > w.clip_min.y &&
         x.z > w.clip_min.z && x.x < w.clip_max.x && x.y < w.clip_max.y && x.z < w.clip_max.z;
  }
  const std::uint32_t i = node_at(w, b, n);
  w.value[i] = value;
  if (w.two_fields) w.solid_value[i] = solid;
  w.inside[i] = in ? 1u : 0u;
}

/// Nodes with even coordinates in their block, first: an eighth of them says where the rest need not be
/// looked at.
template <class T, bool Anisotropic>
struct SurfaceCoarseBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t half = static_cast<std::uint32_t>(w.grid.side + 1) / 2u, all = half * half * half;
    const auto b = static_cast<std::uint32_t>(i / all);
    if (b >= blocks_of(w)) return;
    const Index3 n = node_in_block(static_cast<std::uint32_t>(i % all), static_cast<std::int32_t>(half));
    evaluate_node<Anisotropic>(w, b, {2 * n.x, 2 * n.y, 2 * n.z});
  }
};

/// The others: what lies between even nodes that are all far inside, or all far outside, is that, too. The
/// mesh is closed whatever a node is said to be; no drop is small enough to be missed, because phi of a
/// particle that stands alone is 0.33 at 0.87 dx, the farthest that it can be from the even nodes around it.
template <class T, bool Anisotropic>
struct SurfaceNodesBody {
  SurfaceFrame<T> w;

  /// 1 far inside, 2 far outside, 0 neither.
  MELTSIM_HD std::uint32_t verdict(std::uint32_t node) const {
    if (node >= link_inside) return node == link_inside ? 1u : 2u;
    const T far = static_cast<T>(physics::far_from_level), value = w.value[node];
    const T solid = w.two_fields ? w.solid_value[node] : T(1);
    if (value < -far || solid < -far) return 2u;
    return value > far && solid > far && w.inside[node] != 0u ? 1u : 0u;
  }

  MELTSIM_HD void operator()(std::uint64_t i) const {
    const auto b = static_cast<std::uint32_t>(i / w.grid.volume);
    if (b >= blocks_of(w)) return;
    const Index3 n = node_in_block(static_cast<std::uint32_t>(i % w.grid.volume), w.grid.side);
    const std::uint32_t odd = corner_number(n);
    std::uint32_t all = 0;
    if (w.coarse_first) {
      if (odd == 0u) return;  // done
      all = 3;
      for (std::uint32_t up = odd;; up = (up - 1u) & odd) {
        const Index3 plus = corner_offset(up), minus = corner_offset(odd & ~up);
        all &=
            verdict(node_at(w, b, {n.x + plus.x - minus.x, n.y + plus.y - minus.y, n.z + plus.z - minus.z}));
        if (up == 0u || all == 0u) break;
      }
    }
    if (all == 0u) return evaluate_node<Anisotropic>(w, b, n);
    w.value[i] = all == 1u ? T(0.5) : T(-0.5);
    if (w.two_fields) w.solid_value[i] = T(0.5);
    w.inside[i] = all == 1u ? 1u : 0u;
  }
};

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
