// SPDX-License-Identifier: Apache-2.0
// Events: which kinds a host watches, and taking them.
#include <algorithm>
#include <utility>
#include <vector>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
constexpr std::uint32_t most_events = 1u << 20;
}

Status WorldImpl::watch_events(const EventWatch& what) {
  if (what.capacity == 0 || what.capacity > most_events)
    return invalid("watch_events: capacity: must be 1 to ", most_events, " events, got ", what.capacity);
  if (what.kinds == 0 || (what.kinds & ~all_events) != 0)
    return invalid("watch_events: kinds: must be a sum of event_bit() of some kinds, ", all_events,
                   " for all of them, got ", what.kinds);
  if (Status s = check_touching(what.kinds, bodies_.size(), "watch_events"); !s) return s;
  fetch_state();
  event_watch_ = what;
  forget_events();
  dirty_ = true;
  return {};
}

Status WorldImpl::stop_events() {
  if (!event_watch_) return {};
  fetch_state();
  event_watch_.reset();
  forget_events();
  dirty_ = true;
  return {};
}

/// Contacts are kept in a table of pairs.
Status WorldImpl::check_touching(std::uint32_t kinds, std::size_t bodies, const char* call) {
  if ((kinds & core::contact_events) == 0 || bodies <= core::most_touching_bodies) return {};
  return Error{ErrorCode::capacity,
               core::text(call, ": events: contacts and bodies that melt away are watched among at most ",
                          core::most_touching_bodies, " bodies, and there would be ",
                          static_cast<std::uint64_t>(bodies),
                          "; leave contact_begun, contact_ended and gone out of EventWatch::kinds")};
}

/// Present contacts are then reported as they are found.
void WorldImpl::forget_events() {
  state_.touched.clear();
  state_.touched_bodies = 0;
  state_.event_head = {};
  state_.events.assign(event_watch_ ? event_watch_->capacity : 0, {});
}

/// Ahead of an upload: the table of contacts has a row for every body, those to come included.
void WorldImpl::fit_events() {
  if (!event_watch_) return;
  const std::size_t bodies = std::max<std::size_t>(bodies_.size(), room_.bodies), had = state_.touched_bodies;
  std::vector<std::uint32_t> table(core::touch_entries(bodies, event_watch_->kinds), core::none);
  const std::size_t columns = bodies + core::wall_columns, columns_had = had + core::wall_columns;
  if (!table.empty() && !state_.touched.empty())
    for (std::size_t row = 0; row < std::min(had, bodies); ++row)
      for (std::size_t column = 0; column < std::min(columns, columns_had); ++column)
        table[row * columns + column] = state_.touched[row * columns_had + column];
  state_.touched = std::move(table);
  state_.touched_bodies = bodies;
}

/// Of the body that had this row before.
void WorldImpl::forget_contacts(std::uint32_t body) {
  const std::size_t columns = state_.touched_bodies + core::wall_columns;
  if (body >= state_.touched_bodies || state_.touched.empty()) return;
  std::fill_n(state_.touched.begin() + static_cast<std::ptrdiff_t>(body * columns), columns, core::none);
  for (std::size_t row = 0; row < state_.touched_bodies; ++row)
    state_.touched[row * columns + core::wall_columns + body] = core::none;
}

/// A body that the host takes out does not melt away.
void WorldImpl::forget_live(std::uint32_t body) {
  const std::size_t columns = state_.touched_bodies + core::wall_columns;
  if (body < state_.touched_bodies && !state_.touched.empty())
    state_.touched[body * columns + core::wall_columns + body] = core::none;
}

Result<Events> WorldImpl::take_events() {
  if (!event_watch_)
    return invalid("take_events: events are not watched; call watch_events() before the steps");
  core::ReadParts parts;
  parts.events = true;
  const auto s = read_now(parts);
  if (!s) return s.error();
  state_stale_ = state_stale_ || s->event_head.written != 0;  // the device begins anew
  return events_of(*s, origin_);
}

Events WorldImpl::events_of(const core::StateReading& s, Vec3d origin) const {
  Events all;
  all.lost = s.event_head.written - s.events.size();
  for (int k = 0; k < event_kinds; ++k)
    all.counts[static_cast<std::size_t>(k)] = static_cast<std::uint64_t>(s.event_head.count[k]);
  all.events.reserve(s.events.size());
  for (const core::EventRow& row : s.events) {
    Event e;
    e.kind = static_cast<EventKind>(row.kind);
    e.step = row.step;
    e.time = row.time;
    e.position = row.at + origin;
    e.particle = row.particle;
    e.body = id_of(row.body, row.step);
    e.other = id_of(row.other, row.step);
    e.wall = row.wall < core::wall_columns ? static_cast<int>(row.wall) : -1;
    e.piece = row.piece;
    e.from = row.from;
    all.events.push_back(e);
  }
  return all;
}

}  // namespace v0
}  // namespace meltsim
