// SPDX-License-Identifier: Apache-2.0
// Removal of bodies and liquid from a World, and what is left of them.
#include <algorithm>
#include <numeric>

#include "description/validate.hpp"
#include "engine/held.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

Status WorldImpl::remove_body(BodyId id) {
  if (Status s = check_body("remove", id); !s) return s;
  if (const auto removed = remove_in_place(id.index)) return *removed;
  fetch_state();
  lay_out();
  see_added();
  BodyRecord& body = bodies_[id.index];
  // A site that is free may be frozen onto only beside a live one, of which there is none left.
  for (std::size_t v = 0; v < state_.vertex_state.size(); ++v)
    if (lattice_.vertex_body[v] == id.index) state_.vertex_state[v] = 0;
  for (std::uint32_t& tag : state_.tag) {
    if (!is_solid(tag) || body_of(tag) != id.index + 1u) continue;
    tag |= tag_removed;
    ++body.taken;
  }
  state_.removed += body.taken;
  forget_body(id.index);
  dirty_ = measure_ = true;
  added_ = added_ || steps == 0;  // all is looked at anew
  return {};
}

/// Whose particles were taken out.
void WorldImpl::forget_body(std::uint32_t index) {
  BodyRecord& body = bodies_[index];
  body.gone = true;
  if (body.held)
    body.held = body.desc.fixed = false;  // of what limits go by, whenever it would have been let go
  solids_built_ -= body.taken;
  forget_motion(index);
  body.watched = false;
  forget_live(index);
  lattice_.bodies[index].watched = 0;
}

/// By id, 1: nothing needs it. Of bodies that are there the particles stay that their vertices held last: labels of pieces name them.
std::vector<std::uint8_t> WorldImpl::forgettable() const {
  std::vector<std::uint8_t> drop(state_.tag.size());
  std::transform(state_.tag.begin(), state_.tag.end(), drop.begin(),
                 [](std::uint32_t tag) -> std::uint8_t { return is_removed(tag) ? 1 : 0; });
  for (const EmitterRecord& e : emitters_)
    std::fill_n(drop.begin() + e.first_id, e.ids, std::uint8_t{0});  // in reserve
  std::vector<std::uint8_t> live(bodies_.size(), 0);
  for (std::size_t v = 0; v < state_.vertex_state.size(); ++v)
    if (state_.vertex_state[v] == core::vertex_live) live[lattice_.vertex_body[v]] = 1;
  for (std::size_t v = 0; v < state_.vertex_state.size(); ++v) {
    const std::uint32_t id = state_.vertex_id[v], body = lattice_.vertex_body[v];
    if (id == core::none || bodies_[body].gone) continue;
    if (live[body] != 0u || v == bodies_[body].first_vertex) drop[id] = 0;
  }
  return drop;
}

/// Leaves out the lattices of bodies that were removed; the numbers of other vertices and sites close up.
void WorldImpl::leave_out_lattices() {
  const auto gone = [this](std::size_t v) { return bodies_[lattice_.vertex_body[v]].gone; };
  std::vector<std::uint32_t> vertex_of(lattice_.vertex_site.size(), core::none);
  std::uint32_t to = 0;
  for (std::size_t v = 0; v < vertex_of.size(); ++v)
    if (!gone(v)) vertex_of[v] = to++;
  const auto renumber = [&vertex_of](std::uint32_t& v) {
    if (v != core::none) v = vertex_of[v];
  };
  const auto keep = [&](auto& array) {
    for (std::size_t v = 0; v < vertex_of.size(); ++v)
      if (vertex_of[v] != core::none) array[vertex_of[v]] = array[v];
    array.resize(to);
  };
  for (std::uint32_t& v : state_.vertex_of_id) renumber(v);
  for (std::uint32_t& v : state_.vertex_piece) renumber(v);
  core::each_held(state_, species_.size(), [&](auto held, auto& array, const auto&) {
    if (held.of_vertex) keep(array);
  });
  keep(lattice_.vertex_site);
  keep(lattice_.vertex_body);
  keep(lattice_.contact_shape);
  keep(lattice_.vertex_coordinates);
  for (std::uint32_t& v : lattice_.site_vertex) renumber(v);
  leave_out_rows();
  leave_out_meshes();
}

/// Bodies in the order in which their lattices came.
std::vector<std::uint32_t> WorldImpl::rows_by_vertex() const {
  std::vector<std::uint32_t> rows(bodies_.size());
  std::iota(rows.begin(), rows.end(), 0u);
  std::stable_sort(rows.begin(), rows.end(), [this](std::uint32_t a, std::uint32_t b) {
    return bodies_[a].first_vertex < bodies_[b].first_vertex;
  });
  return rows;
}

/// The same for what there is per body: its first vertex, its sites, how its mesh moves.
void WorldImpl::leave_out_rows() {
  std::size_t vertex = 0, site = 0, from = 0;
  for (const std::uint32_t b : rows_by_vertex()) {
    BodyRecord& body = bodies_[b];
    const std::size_t sites = body.sites;
    if (body.gone) {
      // Once: of one that was forgotten before, another body may have the name by now.
      if (body.vertices_in_lattice != 0) body_names_.erase(body.desc.name);
      body.vertices_in_lattice = 0;
      body.sites = 0;
    }
    body.first_vertex = lattice_.rests[b].first_vertex = static_cast<std::uint32_t>(vertex);
    lattice_.bodies[b].first_site = static_cast<std::uint32_t>(site);
    for (std::size_t k = 0; k < body.sites; ++k)
      lattice_.site_vertex[site + k] = lattice_.site_vertex[from + k];
    for (std::size_t k = 0; k < body.vertices_in_lattice; ++k)
      lattice_.vertex_site[vertex + k] -= static_cast<std::uint32_t>(from - site);
    vertex += body.vertices_in_lattice;
    site += body.sites;
    from += sites;
  }
  lattice_.site_vertex.resize(site);
}

/// How the meshes of removed bodies move.
void WorldImpl::leave_out_meshes() {
  std::vector<physics::MeshPoint>& points = state_.mesh_points;
  std::size_t to = 0, from = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!deforms(static_cast<std::uint32_t>(b))) continue;
    for (std::size_t k = 0; k < bodies_[b].vertices; ++k, ++from)
      if (!bodies_[b].gone) points[to++] = points[from];
    if (bodies_[b].gone) lattice_.rests[b].first_point = core::none;
  }
  points.resize(to);
  place_mesh_points();
}

/// The row of the next body: of one that is forgotten, or a new one. What the host may yet read of that body would name the new one.
std::uint32_t WorldImpl::free_row() const {
  const auto rows = static_cast<std::uint32_t>(bodies_.size());
  if (std::any_of(readings_.begin(), readings_.end(),
                  [](const OpenReading& r) { return r.ticket.value != 0; }))
    return rows;
  for (std::uint32_t b = 0; b < rows; ++b)
    if (forgotten(bodies_[b]) && std::none_of(probes_.begin(), probes_.end(), [b](const ProbeRecord& p) {
          return p.desc.body && p.desc.body.index == b;
        }))
      return b;
  return rows;
}

/// Ids close up, in their order, so that sums over particles keep theirs.
Result<std::vector<std::uint32_t>> WorldImpl::compact() {
  fetch_state();
  if (halted_)
    return Error{ErrorCode::halted,
                 core::text("compact: the World halted: ", halt_reason_, "; restore a snapshot to go on")};
  lay_out();
  see_added();
  const std::vector<std::uint8_t> drop = forgettable();
  std::vector<std::uint32_t> was;
  for (std::size_t i = 0; i < drop.size(); ++i)
    if (drop[i] == 0u) was.push_back(static_cast<std::uint32_t>(i));
  const std::size_t n = drop.size() - was.size();
  const bool lattices = std::any_of(bodies_.begin(), bodies_.end(),
                                    [](const BodyRecord& b) { return b.gone && b.vertices_in_lattice != 0; });
  if (n == 0 && !lattices) return was;
  const Change change(*this);
  if (lattices) leave_out_lattices();
  leave_out(drop);
  state_.removed -= n;
  forgotten_ += n;
  if (!added_) seen_particles_ = state_.position.size();
  dirty_ = true;
  return was;
}

Result<std::uint64_t> WorldImpl::remove_liquid(const Shape& shape) {
  if (Status s = shape.validate(); !s)
    return Error{s.error().code, core::text("remove_liquid: shape: ", s.error().message)};
  if (const auto removed = remove_liquid_in_place(shape)) return *removed;
  fetch_state();
  lay_out();
  see_added();
  std::vector<std::uint32_t> inside;
  for (std::size_t i = 0; i < state_.tag.size(); ++i)
    if (is_fluid(state_.tag[i]) && shape.contains(state_.position[i] + origin_))
      inside.push_back(static_cast<std::uint32_t>(i));
  holes_.reserve(holes_.size() + inside.size());
  for (const std::uint32_t id : inside) drop_fluid(id);
  if (inside.empty()) return std::uint64_t{0};
  dirty_ = measure_ = true;
  added_ = added_ || steps == 0;
  return static_cast<std::uint64_t>(inside.size());
}

}  // namespace v0
}  // namespace meltsim
