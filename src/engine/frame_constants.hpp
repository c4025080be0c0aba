// SPDX-License-Identifier: Apache-2.0
// The constants of a scene as kernels take them.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "engine/engine_sizes.hpp"
#include "engine/rounded.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "meltsim/physics/surface_tension.hpp"
#include "spatial/cells.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

template <class T>
void fill_grid(Frame<T>& w, const SceneConstants& c, double support, int reach) {
  Grid<T>& g = w.grid;
  g.reach = reach;
  if (!c.domain.bounded) {
    // An unbounded lattice of cells around the origin; only occupied ones cost anything.
    g.nx = g.ny = g.nz = 1 << 21;
    const double low = -support * double(1 << 20);
    g.min = cast<T>(Vec3d{low, low, low});
    g.inv_cell = cast<T>(Vec3d{1 / support, 1 / support, 1 / support});
    w.key_bits = 64;
    return;
  }
  const Vec3d e = c.domain.max - c.domain.min;
  g.min = cast<T>(c.domain.min);
  g.nx = cells_along(e.x, support / reach);
  g.ny = cells_along(e.y, support);
  g.nz = cells_along(e.z, support);
  g.inv_cell = cast<T>(Vec3d{g.nx / e.x, g.ny / e.y, g.nz / e.z});
  for (int axis = 0; axis < 3; ++axis)
    if (is_periodic(c.domain, static_cast<std::size_t>(axis))) g.periodic |= 1u << axis;
  const auto per = [&](int axis, double extent) { return (g.periodic >> axis) & 1u ? extent : 0.0; };
  const Vec3d p{per(0, e.x), per(1, e.y), per(2, e.z)};
  g.period = cast<T>(p);
  g.inv_period = cast<T>(Vec3d{p.x > 0 ? 1 / p.x : 0, p.y > 0 ? 1 / p.y : 0, p.z > 0 ? 1 / p.z : 0});
  g.rows = (g.periodic & 1u) != 0u ? 18u : 9u;
  // Asked where cells are counted, which are few enough for these numbers.
  for (std::uint32_t line = 0; line < 9; ++line) {
    const std::int64_t y = spatial::line_offset(spatial::lines_y, line);
    const std::int64_t z = spatial::line_offset(spatial::lines_z, line);
    g.line_cells[line] = static_cast<std::int32_t>((z * g.ny + y) * g.nx);
  }
  // One bit more than the cells need: the key of a removed particle, cut to these bits, still sorts last.
  const double all = double(g.nx) * double(g.ny) * double(g.nz);
  w.key_bits = static_cast<std::uint32_t>(std::ceil(std::log2(all + 1.0))) + 1u;
}

template <class T>
void fill_tree(Frame<T>& w, const SceneConstants& c, const Sizes& n) {
  Tree<T>& t = w.tree;
  const double cell = c.support / tree_resolution;
  t.inv_cell = static_cast<T>(1 / cell);
  t.bits = 21;  // three axes in 63 bits; beyond, only the order suffers
  t.min = w.grid.min;
  double largest = 0;  // coordinate that distances are rounded at, where axes wrap
  if (c.domain.bounded) {
    const Vec3d e = c.domain.max - c.domain.min;
    const double cells = std::max({e.x, e.y, e.z}) / cell;
    t.bits = static_cast<std::uint32_t>(std::min(21.0, std::ceil(std::log2(std::max(cells, 2.0)))));
    if (w.grid.periodic != 0u) largest = std::max({e.x, e.y, e.z});
  } else {
    const double low = -cell * double(1 << 20);
    t.min = cast<T>(Vec3d{low, low, low});
  }
  w.key_bits = 3 * t.bits + 1;
  w.grid.rows = static_cast<std::uint32_t>(n.rows);
  t.levels = n.tree_levels;
  std::copy(std::begin(n.tree_first), std::end(n.tree_first), t.first);
  t.reach = static_cast<T>(c.support * (1 + 1e-5) + 8 * double(std::numeric_limits<T>::epsilon()) * largest);
}

/// Outlets of the domain. A level is measured along the axis of gravity, from the floor (validate_outlet()).
template <class T>
void fill_outlets(physics::Outlets<T>& o, const SceneConstants& c) {
  const Vec3d extent = c.domain.max - c.domain.min, pull = c.surroundings.gravity;
  const double sides[3] = {extent.x, extent.y, extent.z}, along[3] = {pull.x, pull.y, pull.z};
  for (std::uint32_t f = 0; f < 6u && c.domain.bounded; ++f) {
    const OutletDesc& outlet = c.domain.outlets[f];
    if (!outlet.level && !outlet.speed) continue;
    o.taking |= 1u << f;
    o.speed[f] = static_cast<T>(outlet.speed.value_or(0));
    if (!outlet.level) continue;
    o.levels |= 1u << f;
    const std::uint32_t axis = f / 2u;
    std::uint32_t down = 0;
    for (std::uint32_t a = 1; a < 3u; ++a)
      if (std::fabs(along[a]) > std::fabs(along[down])) down = a;
    o.head[f] = static_cast<T>(c.outlet_head[f]);
    o.floor[f] =
        static_cast<T>((physics::outlet_end - physics::outlet_reach) * c.support * sides[3u - axis - down]);
  }
}

/// Faces through which liquid comes in, and nozzles that recycle.
template <class T>
void fill_inlets(Constants<T>& k, const SceneConstants& c) {
  k.outlets.taking |= c.inlet_faces;
  k.outlets.inlets = c.inlet_faces;
  k.nozzles = c.nozzles;
  for (std::size_t n = 0; n < inlet_rows; ++n) {
    const Inlet<double>& row = c.inlets.row[n];
    k.inlet_first_point[n] = row.first_point;
    k.inlet_points[n] = row.points;
    k.inlet_first_id[n] = row.first_id;
    k.inlet_ids[n] = row.ids;
  }
}

/// Settings that the host may change between sub-steps.
template <class T>
void fill_surroundings(Frame<T>& w, const Surroundings& s) {
  w.clock.gravity = cast<T>(s.gravity);
  w.clock.free_surface = round_condition<T>(s.free_surface);
  w.clock.uneven_conductors = s.uneven_conductors ? 1u : 0u;
  w.clock.heated_walls = 0;
  for (std::size_t f = 0; f < 6; ++f) {
    w.clock.wall_heat[f] = round_condition<T>(s.wall_heat[f]);
    if (s.wall_heat[f].kind != physics::SurfaceHeat::insulated) w.clock.heated_walls |= 1u << f;
  }
}

/// Faces of the domain that are walls or open, and constants of walls that follow from support and spacing.
template <class T>
void fill_faces(Constants<T>& k, const SceneConstants& c) {
  k.wall_friction = static_cast<T>(c.domain.friction);
  k.wall_wetting = static_cast<T>(physics::wetting_cosine(c.domain.contact_angle));
  k.no_slip = c.domain.no_slip ? 1u : 0u;
  k.domain_min = k.walls.min = cast<T>(c.domain.min);
  k.domain_max = k.walls.max = cast<T>(c.domain.max);
  k.walls.support = static_cast<T>(c.support);
  k.wall_exchange = physics::make_wall_exchange<T>(c.support, c.spacing);
  k.walls.cover_scale = physics::wall_cover_scale<T>(c.support, c.spacing);
  k.walls.push_scale = physics::floor_push_scale<T>(c.support, c.spacing);
  k.gap_scale =
      static_cast<T>(physics::gap_scale(physics::make_kernel<double>(c.support, c.spacing), c.spacing));
  k.free_layer = physics::make_free_layer<T>(c.support, c.spacing);
  if (c.domain.bounded)
    for (int f = 0; f < 6; ++f) {
      const Face face = c.domain.faces[static_cast<std::size_t>(f)];
      if (face == Face::wall) k.walls.faces |= 1u << f;
      if (face == Face::open) k.open_faces |= 1u << f;
      k.wall_velocity[f] = cast<T>(c.domain.velocity[static_cast<std::size_t>(f)]);
    }
  fill_outlets(k.outlets, c);
  fill_inlets(k, c);
}

/// Vertices that kernels run over, and what follows from how many there are.
template <class E, class T>
void use_vertices(Frame<T>& w, std::uint64_t used, const Sizes& n) {
  w.vertices = stepped(used, n.count[static_cast<int>(Owner::vertex)]);
  w.row_width = least_row_width(as_gpu<E>, w.vertices);
}

/// All but views and what changes from sub-step to sub-step.
template <class E, class T>
void fill_constants(Frame<T>& w, const SceneConstants& c, const SceneLattice& l, const Sizes& n) {
  Constants<T>& k = w.c;
#define MELTSIM_CONSTANT(name, type, value, doc) k.name = static_cast<type>(c.name);
#include "frame/constants.def"
#undef MELTSIM_CONSTANT
  k.kernel = physics::make_kernel<T>(c.support, c.spacing);
  k.lowest_phi = c.tension ? T(0) : T(1);
  k.volume_rate = static_cast<T>(c.sound_speed / (physics::volume_relaxation * c.support));
  k.conduction_share = physics::make_conduction_share<T>(c.support, c.spacing);
  k.central_viscosity = physics::make_central_viscosity<T>(c.support, c.spacing);
  k.heat_regions = static_cast<std::uint32_t>(c.heat_regions.size());
  k.leak_distance2 = static_cast<T>(std::pow(physics::leak_distance * c.spacing, 2));
  fill_faces(k, c);
  fill_surroundings(w, c.surroundings);
  fill_grid(w, c, c.support, n.reach);
  if (n.tree_levels != 0) fill_tree(w, c, n);
  w.max_groups = static_cast<std::uint32_t>(n.groups);
  w.cells = static_cast<std::uint32_t>(n.cells);
  w.bodies = static_cast<std::uint32_t>(n.count[static_cast<int>(Owner::body)]);
  w.capacity = n.count[static_cast<int>(Owner::particle)];
  w.one_liquid = c.one_liquid;
  w.solute_rooms = std::any_of(c.species.begin(), c.species.end(), [](const SpeciesRow<double>& s) {
    return physics::precipitates(s) || s.heat_of_solution != 0;
  });
  w.species = static_cast<std::uint32_t>(c.species.size());
  w.region_words = words_for(l.max_half_width);
  use_vertices<E>(w, l.vertex_site.size(), n);
  w.event_kinds = c.event_kinds;
  w.event_capacity = c.event_capacity;
  w.touch_entries = n.count[static_cast<int>(Owner::touch_entry)];
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
