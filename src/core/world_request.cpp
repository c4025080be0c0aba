// SPDX-License-Identifier: Apache-2.0
// Readings that are taken later.
#include <algorithm>
#include <atomic>
#include <utility>

#include "core/text.hpp"
#include "core/validate.hpp"
#include "core/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {

/// Of the whole process, so that a ticket of another World is recognised.
std::uint64_t next_ticket() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

ParticleFrame frame_of(const ParticleData& d, Vec3d origin) {
  ParticleFrame f;
  f.origin = origin;
  f.id = d.id;
  f.tag = d.tag;
  f.piece = d.piece;
  for (const Vec3d& x : d.position) f.position.push_back(cast<float>(x - origin));
  for (const Vec3d& v : d.velocity) f.velocity.push_back(cast<float>(v));
  f.temperature.assign(d.temperature.begin(), d.temperature.end());
  f.liquid_fraction.assign(d.liquid_fraction.begin(), d.liquid_fraction.end());
  f.density.assign(d.density.begin(), d.density.end());
  f.pressure.assign(d.pressure.begin(), d.pressure.end());
  return f;
}

}  // namespace

Result<ReadTicket> WorldImpl::request(const ReadRequest& what) {
  const auto free = std::find_if(readings_.begin(), readings_.end(),
                                 [](const OpenReading& r) { return r.ticket.value == 0; });
  if (free == readings_.end())
    return Error{ErrorCode::capacity, core::text("request: ", most_readings,
                                                 " readings are open, which is as many as there may be; "
                                                 "take() one first")};
  Reading r;
  r.result = synchronize();
  r.step = r.result.steps;
  r.time = r.result.time;
  if (what.totals) {
    auto t = totals();
    if (!t) return t.error();
    r.totals = *t;
    auto l = ledger();
    if (!l) return l.error();
    r.ledger = *l;
  }
  if (what.pieces) {
    auto p = pieces();
    if (!p) return p.error();
    r.pieces = std::move(*p);
  }
  if (what.particles) {
    auto d = particles();
    if (!d) return d.error();
    r.particles = frame_of(*d, origin_);
  }
  if (what.probes) {
    auto s = take_samples();
    if (!s) return s.error();
    r.probes = std::move(*s);
  }
  free->reading = std::move(r);
  free->ticket.value = next_ticket();
  return free->ticket;
}

Result<bool> WorldImpl::ready(ReadTicket ticket) {
  for (const OpenReading& r : readings_)
    if (ticket.value != 0 && r.ticket.value == ticket.value) return true;
  return invalid("ready: ticket: no open reading of this World has it; use what request() returned, once");
}

Result<Reading> WorldImpl::take(ReadTicket ticket) {
  for (OpenReading& r : readings_)
    if (ticket.value != 0 && r.ticket.value == ticket.value) {
      r.ticket = {};
      return std::exchange(r.reading, {});
    }
  return invalid("take: ticket: no open reading of this World has it; use what request() returned, once");
}

}  // namespace v0
}  // namespace meltsim
