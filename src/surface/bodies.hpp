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

/// 1 where a new cell begins. Not left to the scan, which has a few threads with many items each.
template <class T>
struct SurfaceHeadBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint64_t key = w.key_out[i];
    w.group_of[i] = key != core::removed_key && (i == 0 || w.key_out[i - 1] != key) ? 1u : 0u;
  }
};

struct SurfaceCountsBody {
  const std::uint32_t* counts;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t k) const { return counts[k]; }
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
    const double enthalpy = w.enthalpy != nullptr ? w.enthalpy[slot] : w.enthalpy_of_id[w.id[slot]];
    const double h = enthalpy / static_cast<double>(w.mass[slot]);
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
    const auto entry = static_cast<std::uint32_t>(k), g = entry / 9u;
    if (g >= groups_of(w)) return;
    const Range near = groups_in(w, key_row(w, coordinates(w, w.group_key[g]), entry % 9u));
    w.group_near[k] = near;
    w.group_rows[k] = particles_of(w, near);
  }
};

/// The volume of a particle from the sum around it, and whether it is at a surface.
template <class T, bool Periodic>
struct SurfaceShareBody {
  static constexpr bool wide = true;
  SurfaceFrame<T> w;
  static constexpr bool shared = true;
  using Sum = FieldSums<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    const std::uint32_t g = w.group_of[i];
    if (g >= groups_of(w)) return {};  // none, or no room
    return volume_around<Periodic>(w, w.group_rows + std::uint64_t{9} * g, k, parts, xyz(w.point[i]));
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    if (w.group_of[i] >= groups_of(w)) return;
    const Vec4<T> p = w.point[i];
    const T scale = w.field.kernel.w_scale / physics::open_share(w.walls, w.field.kernel, xyz(p));
    const T all = s.all * scale, of_solids = s.solid * scale;
    const bool solid = w.two_fields && w.mark[i] == mark_solid;
    w.share[i] = with_w(xyz(p), p.w * physics::surface_gain(w.field, all));
    if (w.two_fields) w.solid_share[i] = solid ? p.w * physics::surface_gain(w.field, of_solids) : T(0);
    const bool at_surface = all < w.field.full_sum || (solid && of_solids < w.field.full_sum);
    w.at_surface[i] = at_surface ? 1u : 0u;
  }
};

/// Makes ellipsoids of the balls.
template <class T, bool Periodic>
struct SurfaceShapeBody {
  static constexpr bool wide = true;
  SurfaceFrame<T> w;
  static constexpr bool shared = true;
  using Sum = physics::ShapeSums<T>;
  MELTSIM_HD bool by_itself(std::uint64_t i) const { return w.two_fields && w.mark[i] == mark_solid; }
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    const std::uint32_t g = w.group_of[i];
    if (g >= groups_of(w)) return {};
    return shape_around<Periodic>(w, w.group_rows + std::uint64_t{9} * g, k, parts, xyz(w.point[i]),
                                  by_itself(i));
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    if (w.group_of[i] >= groups_of(w)) return;
    const Vec4<T> p = w.share[i];
    const physics::Ellipsoid<T> e = physics::make_ellipsoid(s, w.field.full);
    // Flat ellipsoids keep their volume; only isolated particles need more.
    const auto share = [&](T gained, T volume) { return e.det * (gained + e.trust * (volume - gained)); };
    const T volume = w.point[i].w;
    w.share[i] = with_w(xyz(p), share(p.w, volume));
    if (w.two_fields) w.solid_share[i] = by_itself(i) ? share(w.solid_share[i], volume) : T(0);
    w.shape[i] = {{e.xx, e.yy, e.zz, e.xy}, e.yz, e.zx};
  }
};

/// Summary of a group, so that neighbouring groups need not read its particles.
template <class T>
struct SurfaceMarkBody {
  SurfaceFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t g) const {
    if (g >= groups_of(w)) return;
    std::uint32_t marks = 0;
    for (std::uint32_t j = w.group_begin[g]; j < w.group_begin[g + 1]; ++j)
      marks |= w.mark[j] | (w.at_surface[j] != 0u ? core::mark_surface : 0u);
    w.group_mark[g] = static_cast<std::uint8_t>(marks);
  }
};

/// Whether a group is far inside: nothing to see in its block.
template <class T>
struct SurfaceDeepBody {
  SurfaceFrame<T> w;
  MELTSIM_HD std::uint32_t deep(std::uint32_t g) const {
    const Index3 c = coordinates(w, w.group_key[g]);
    const Vec3<T> low = node_position(w, c, {}), high = node_position(w, c + Index3{1, 1, 1}, {});
    const bool clear = low.x > w.clip_min.x && low.y > w.clip_min.y && low.z > w.clip_min.z &&
                       high.x < w.clip_max.x && high.y < w.clip_max.y && high.z < w.clip_max.z;
    if (!clear) return 0;
    std::uint32_t marks = 0;
    for (std::uint32_t r = 0; r < 9; ++r) {
      const Range near = w.group_near[std::uint64_t{9} * g + r];
      if (near.end - near.begin != 3u) return 0;
      for (std::uint32_t k = near.begin; k < near.end; ++k) marks |= w.group_mark[k];
    }
    if ((marks & core::mark_surface) != 0u) return 0;
    if (!w.two_fields) return link_inside;
    return marks == mark_liquid ? link_inside : marks == mark_solid ? link_outside : 0u;
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
    const auto entry = static_cast<std::uint32_t>(k);
    w.owns[k] = owns(entry / 27u, entry % 27u) ? 1u : 0u;
  }
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
    const auto entry = static_cast<std::uint32_t>(k), b = entry / 27u, d = entry % 27u;
    if (b >= blocks_of(w)) return;
    const Index3 c = coordinates(w, w.block_key[b]);
    w.block_link[k] = d == 13u ? b : link_to(w, c + direction(d));
    if (d < 9u) w.block_rows[std::uint64_t{9} * b + d] = particles_of(w, groups_in(w, key_row(w, c, d)));
  }
};

/// The field at the nodes of a line, and which are inside. Step 2: nodes with even coordinates in their
/// block, before the rest; where cells are small an eighth of all says where the others need not be looked
/// at. What lies between even nodes that are all far inside, or all far outside, is that, too. The mesh is
/// closed whatever a node is said to be; no drop is small enough to be missed, because phi of a particle that
/// stands alone is 0.33 at 0.87 dx, the farthest that it can be from the even nodes around it where they are
/// a spacing apart.
template <class T, bool Anisotropic, bool Periodic, int Step>
struct SurfaceNodesBody {
  static constexpr bool wide = true;
  SurfaceFrame<T> w;
  static constexpr std::int32_t step = Step;
  static constexpr bool shared = true;
  static constexpr std::uint32_t most = most_in_line<Anisotropic, Step>;
  using Sum = LineSums<T, most>;

  struct Line {
    std::uint32_t block = none;
    Index3 of_block, first;
    std::uint32_t count = 0;
  };
  MELTSIM_HD std::uint32_t nodes_along() const {
    return static_cast<std::uint32_t>((w.grid.side + step - 1) / step);
  }
  MELTSIM_HD std::uint32_t lines_along() const { return (nodes_along() + most - 1u) / most; }
  MELTSIM_HD std::uint32_t lines_of_block() const { return lines_along() * nodes_along() * nodes_along(); }

  MELTSIM_HD Line line(std::uint64_t i) const {
    const std::uint32_t along = nodes_along(), lines = lines_along(), all = lines * along * along;
    const auto number = static_cast<std::uint32_t>(i);
    const std::uint32_t block = number / all, at = number % all;
    if (block >= blocks_of(w)) return {};
    const std::uint32_t length = (along + lines - 1u) / lines, x = at % lines * length;
    const auto place = [](std::uint32_t n) { return static_cast<std::int32_t>(n) * step; };
    return {block,
            coordinates(w, w.block_key[block]),
            {place(x), place(at / lines % along), place(at / lines / along)},
            x < along ? minimum(length, along - x) : 0u};
  }
  MELTSIM_HD Index3 node(const Line& l, std::uint32_t k) const {
    return {l.first.x + static_cast<std::int32_t>(k) * step, l.first.y, l.first.z};
  }

  enum What : std::uint32_t { unknown, far_inside, far_outside, known };

  MELTSIM_HD What verdict(std::uint32_t number) const {
    if (number >= link_inside) return number == link_inside ? far_inside : far_outside;
    const T far = static_cast<T>(physics::far_from_level), value = w.value[number];
    const T solid = w.two_fields ? w.solid_value[number] : T(1);
    if (value < -far || solid < -far) return far_outside;
    return value > far && solid > far && w.inside[number] == core::node_inside ? far_inside : unknown;
  }

  /// The value of a node as far as it is known without the field.
  MELTSIM_HD What what(std::uint32_t b, Index3 n, Vec3<T> x, Vec3<T> at) const {
    const bool second = w.coarse_first && step == 1;
    const std::uint32_t odd = corner_number(n);
    if (second && odd == 0u) return known;
    const std::uint32_t must = forced(w, b, n);
    if (must != 0u) return must == link_inside ? far_inside : far_outside;
    // Next to what is beyond a face of the domain by more than a cell there are no vertices.
    const T cell = T(0.99) * w.grid.cell;
    if (!(std::fabs(x.x - at.x) < cell && std::fabs(x.y - at.y) < cell && std::fabs(x.z - at.z) < cell))
      return far_outside;
    if (!second) return unknown;
    std::uint32_t all = far_inside | far_outside;
    for (std::uint32_t up = odd;; up = (up - 1u) & odd) {
      const Index3 plus = corner_offset(up), minus = corner_offset(odd & ~up);
      all &= verdict(node_at(w, b, {n.x + plus.x - minus.x, n.y + plus.y - minus.y, n.z + plus.z - minus.z}));
      if (up == 0u || all == 0u) break;
    }
    return static_cast<What>(all);
  }

  MELTSIM_HD Vec3<T> position(const Line& l, std::uint32_t k) const {
    return node_position(w, l.of_block, node(l, k));
  }

  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t part, std::uint32_t parts) const {
    const Line l = line(i);
    if (l.count == 0u) return {};
    T along[most];
    Vec3<T> at{};
    bool look = false;
    for (std::uint32_t k = 0; k < most; ++k) {
      const Vec3<T> x = position(l, minimum(k, l.count - 1u));
      at = clipped(w, x);
      along[k] = at.x;
      look = look || (k < l.count && what(l.block, node(l, k), x, at) == unknown);
    }
    if (!look) return {};
    return field_along<Anisotropic, Periodic>(w, w.block_rows + std::uint64_t{9} * l.block, part, parts,
                                              along, l.count, at.y, at.z);
  }

  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    const Line l = line(i);
    for (std::uint32_t k = 0; k < most; ++k) {
      if (k >= l.count) return;
      const Vec3<T> x = position(l, k), at = clipped(w, x);
      const What is = what(l.block, node(l, k), x, at);
      if (is == known) continue;
      T value = is == far_inside ? T(0.5) : T(-0.5), solid = T(0.5);
      bool in = is == far_inside;
      if (is == unknown) {
        const T scale = w.field.kernel.w_scale / physics::open_share(w.walls, w.field.kernel, at);
        const T phi = s.all[k] * scale, phi_s = w.two_fields ? s.solid[k] * scale : T(0);
        value = physics::liquid_value(w.field, phi, phi_s);
        solid = w.field.level - phi_s;
        in = value > T(0) && (!w.two_fields || solid > T(0)) && x.x > w.clip_min.x && x.y > w.clip_min.y &&
             x.z > w.clip_min.z && x.x < w.clip_max.x && x.y < w.clip_max.y && x.z < w.clip_max.z;
      }
      const std::uint32_t to = node_at(w, l.block, node(l, k));
      w.value[to] = value;
      if (w.two_fields) w.solid_value[to] = solid;
      const bool in_solid = w.overlap > T(0) && !in && !(solid > T(0));
      w.inside[to] = in ? core::node_inside : in_solid ? core::node_in_solid : core::node_outside;
    }
  }
};

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
