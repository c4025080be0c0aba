// SPDX-License-Identifier: Apache-2.0
// Removal of bodies and emitters from a World.
#include "description/validate.hpp"
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
  solids_built_ -= body.taken;
  motions_[index].reset();
  proxies_[index].reset();
  meshes_[index].set = false;
  body.watched = false;
  forget_live(index);
  lattice_.bodies[index].watched = 0;
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
