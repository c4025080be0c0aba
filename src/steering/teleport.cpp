// SPDX-License-Identifier: Apache-2.0
// Teleports: liquid that a body would bury goes to the nearest free places.
#include <algorithm>
#include <cmath>
#include <vector>

#include "description/point_grid.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::FoundParticle;
using core::invalid;

namespace {
/// How far around a body free places are looked for at first, and how often twice as far [spacings].
constexpr int first_margin = 6, most_passes = 8;
/// Cells of a search: a byte each.
constexpr double most_cells = 134217728.0;
/// Up to so many particles each goes to the nearest of the places; of more, in order.
constexpr std::size_t most_matched = 10000;
}  // namespace

/// Fills found_ with what is in a box, from wherever the state is. true: the backend has it.
Result<bool> WorldImpl::particles_in(Vec3d low, Vec3d high) {
  if (!dirty_ && !halted_ && capacity_ != 0 && !engine->host_captures()) {
    core::WorldStatus status;
    const auto runs = find(low, high, status);
    if (!runs) return runs.error();
    if (*runs) return true;
  }
  fetch_state();
  found_.clear();
  for (std::size_t i = 0; i < state_.position.size(); ++i) {
    const Vec3d x = state_.position[i];
    if (is_removed(state_.tag[i]) || !(x.x >= low.x && x.y >= low.y && x.z >= low.z) ||
        !(x.x <= high.x && x.y <= high.y && x.z <= high.z))
      continue;
    found_.push_back(
        {x, state_.mass[i], state_.volume[i], static_cast<std::uint32_t>(i), state_.tag[i], core::none, 0});
  }
  return false;
}

/// One teleport, in stored coordinates.
class WorldImpl::Teleport {
 public:
  Teleport(WorldImpl& world, std::uint32_t body, const physics::RigidPlace& place)
      : w_(world), body_(body), reach_(core::same_place * w_.desc.spacing), own_(reach_), others_(reach_) {
    const BodyRecord& b = w_.bodies_[body];
    what_ = core::text(b.proxy() ? "set_proxy" : "set_motion", ": body \"", b.desc.name, "\": teleport: ");
    points_of(body, place, [this](Vec3d x) {
      low_ =
          own_.size() == 0 ? x : Vec3d{std::min(low_.x, x.x), std::min(low_.y, x.y), std::min(low_.z, x.z)};
      high_ = own_.size() == 0
                  ? x
                  : Vec3d{std::max(high_.x, x.x), std::max(high_.y, x.y), std::max(high_.z, x.z)};
      own_.add(x, 0);
    });
  }

  Status find_buried();
  bool buries() const { return !buried_.empty(); }
  Status find_places();
  Status carry_out();

 private:
  /// A box of cells of the World's lattice.
  struct Cells {
    std::int64_t low[3] = {}, size[3] = {};
    bool whole[3] = {};  ///< along this axis the domain has no more
    std::size_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
      return static_cast<std::size_t>(((z - low[2]) * size[1] + (y - low[1])) * size[0] + (x - low[0]));
    }
  };
  static bool any(std::uint32_t) { return true; }
  template <class Visit>
  void points_of(std::uint32_t body, const physics::RigidPlace& place, const Visit& visit) const {
    const BodyRecord& b = w_.bodies_[body];
    const BodyExtent extent = w_.extent_of(body, 0, false);
    for (std::uint32_t v = b.first_vertex; v < b.first_vertex + b.vertices; ++v)
      visit(physics::point_of(place, w_.rest_of(body, v, extent)).position);
  }
  Error in_the_way(const std::string& what, Vec3d x) const {
    return invalid(what_, what, " is in the way at ", x + w_.origin_,
                   "; choose a clear place, or move there without teleport");
  }
  Vec3d margin(double spacings) const {
    const double m = spacings * w_.desc.spacing;
    return {m, m, m};
  }
  std::int64_t cell(double x, double origin) const {
    return static_cast<std::int64_t>(std::floor((x - origin) / w_.desc.spacing));
  }
  Vec3d center(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const Vec3d o = w_.lattice_origin() - w_.origin_;
    const double dx = w_.desc.spacing;
    return {o.x + (double(x) + 0.5) * dx, o.y + (double(y) + 0.5) * dx, o.z + (double(z) + 0.5) * dx};
  }
  bool cells_around(double spacings, Cells& cells) const;
  Status look_around(const Cells& cells, core::PointGrid& bodies, core::PointGrid& taken);
  Status search(const Cells& cells, bool& reached_edge);
  void match();

  WorldImpl& w_;
  std::uint32_t body_;
  double reach_;  ///< closer than this two particles are in one place [m]
  std::string what_;
  core::PointGrid own_;     ///< points of the body there
  core::PointGrid others_;  ///< of other bodies that are to be elsewhere at the beginning of the next step
  Vec3d low_, high_;        ///< box of own_
  bool on_backend_ = false;
  std::vector<FoundParticle> buried_;  ///< by id
  std::vector<Vec3d> places_;          ///< for them
};

Status WorldImpl::Teleport::find_buried() {
  for (std::uint32_t b = 0; b < w_.bodies_.size(); ++b) {
    if (b == body_ || w_.bodies_[b].gone) continue;
    const auto& motion = w_.motions_[b];
    const auto& proxy = w_.proxies_[b];
    if (!(motion && motion->teleport) && !(proxy && proxy->teleport)) continue;
    const physics::RigidPlace there =
        motion ? w_.motion_for(b, *motion, 0).first : w_.motion_for(*proxy, 0).first;
    Vec3d met{};
    bool meets = false;
    points_of(b, there, [&](Vec3d x) {
      if (own_.near(x, any)) {
        met = x;
        meets = true;
      }
      others_.add(x, 0);
    });
    if (meets) return in_the_way("body \"" + w_.bodies_[b].desc.name + "\", which goes there,", met);
  }
  const auto on_backend = w_.particles_in(low_ - margin(1), high_ + margin(1));
  if (!on_backend) return on_backend.error();
  on_backend_ = *on_backend;
  for (const FoundParticle& p : w_.found_) {
    const bool solid = is_solid(p.tag);
    if ((solid && body_of(p.tag) == body_ + 1u) || !own_.near(p.position, any)) continue;
    if (solid) return in_the_way("body \"" + w_.bodies_[body_of(p.tag) - 1u].desc.name + "\"", p.position);
    if (is_held(p.tag)) return in_the_way("a nozzle", p.position);
    buried_.push_back(p);
  }
  return {};
}

/// The cells within so many spacings of the body, inside the domain. False: they are too many.
bool WorldImpl::Teleport::cells_around(double spacings, Cells& cells) const {
  const Vec3d o = w_.lattice_origin() - w_.origin_, m = margin(spacings);
  const Vec3d low = low_ - m, high = high_ + m;
  const double from[3] = {low.x, low.y, low.z}, to[3] = {high.x, high.y, high.z}, origin[3] = {o.x, o.y, o.z};
  const DomainDesc& d = w_.desc.domain;
  const Vec3d begin = d.min - w_.origin_, end = d.max - w_.origin_;
  const double first[3] = {begin.x, begin.y, begin.z}, last[3] = {end.x, end.y, end.z};
  double all = 1;
  for (int a = 0; a < 3; ++a) {
    const bool at_both = d.bounded && from[a] <= first[a] && to[a] >= last[a];
    const double begins = d.bounded ? std::max(from[a], first[a]) : from[a],
                 ends = d.bounded ? std::min(to[a], last[a]) : to[a];
    cells.low[a] = cell(begins, origin[a]);
    cells.size[a] = std::max<std::int64_t>(1, cell(ends, origin[a]) - cells.low[a] + 1);
    cells.whole[a] = at_both;
    all *= double(cells.size[a]);
  }
  return all <= most_cells;
}

/// What is in and around these cells: bodies, and particles and nozzles in whose places there is no room.
Status WorldImpl::Teleport::look_around(const Cells& cells, core::PointGrid& bodies, core::PointGrid& taken) {
  const Vec3d low = center(cells.low[0], cells.low[1], cells.low[2]),
              high = center(cells.low[0] + cells.size[0] - 1, cells.low[1] + cells.size[1] - 1,
                            cells.low[2] + cells.size[2] - 1);
  if (const auto there = w_.particles_in(low - margin(1), high + margin(1)); !there) return there.error();
  std::size_t next = 0;
  for (const FoundParticle& p : w_.found_) {
    while (next < buried_.size() && buried_[next].id < p.id) ++next;
    if (next < buried_.size() && buried_[next].id == p.id) continue;
    const bool own = is_solid(p.tag) && body_of(p.tag) == body_ + 1u;  // stays where it is until the step
    (is_solid(p.tag) && !own ? bodies : taken).add(p.position, 0);
  }
  for (const EmitterRecord& e : w_.emitters_)
    if (w_.time < e.desc.until)
      for (const Vec3d& x : w_.places_of(e)) taken.add(x - w_.origin_, 0);
  return {};
}

/// Floods the cells from those of what is buried, around other bodies, and takes the free ones in the order in which they are
/// reached. reached_edge: there may be more beyond.
Status WorldImpl::Teleport::search(const Cells& cells, bool& reached_edge) {
  core::PointGrid bodies(reach_), taken(reach_);
  if (Status s = look_around(cells, bodies, taken); !s) return s;
  enum : std::uint8_t { unseen = 0, seen = 1 };
  std::vector<std::uint8_t> state(static_cast<std::size_t>(cells.size[0]) *
                                      static_cast<std::size_t>(cells.size[1]) *
                                      static_cast<std::size_t>(cells.size[2]),
                                  unseen);
  struct Cell {
    std::int32_t x, y, z;
  };
  std::vector<Cell> queue;
  const auto reach = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    const std::int64_t at[3] = {x, y, z};
    for (int a = 0; a < 3; ++a)
      if (at[a] < cells.low[a] || at[a] >= cells.low[a] + cells.size[a]) {
        if (!cells.whole[a]) reached_edge = true;
        return;
      }
    std::uint8_t& s = state[cells.at(x, y, z)];
    if (s != unseen) return;
    s = seen;
    if (bodies.near(center(x, y, z), any) || others_.near(center(x, y, z), any)) return;
    queue.push_back(
        {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)});
  };
  const Vec3d o = w_.lattice_origin() - w_.origin_;
  for (const FoundParticle& p : buried_)
    reach(cell(p.position.x, o.x), cell(p.position.y, o.y), cell(p.position.z, o.z));
  places_.clear();
  for (std::size_t k = 0; k < queue.size() && places_.size() < buried_.size(); ++k) {
    const Cell c = queue[k];
    const Vec3d x = center(c.x, c.y, c.z);
    if (w_.fits(x + w_.origin_) && !own_.near(x, any) && !taken.near(x, any)) places_.push_back(x);
    for (int a = 0; a < 3; ++a)
      for (const int d : {-1, 1}) reach(c.x + (a == 0) * d, c.y + (a == 1) * d, c.z + (a == 2) * d);
  }
  return {};
}

Status WorldImpl::Teleport::find_places() {
  double spacings = first_margin;
  bool more = true;
  for (int pass = 0; pass < most_passes && more; ++pass, spacings *= 2) {
    Cells cells;
    if (!cells_around(spacings, cells)) break;
    more = false;
    if (Status s = search(cells, more); !s) return s;
    if (places_.size() == buried_.size()) {
      match();
      return {};
    }
  }
  return invalid(
      what_, "would bury ", static_cast<std::uint64_t>(buried_.size()),
      " particles of liquid, and around it there is room for ", static_cast<std::uint64_t>(places_.size()),
      ", the first at ", buried_.front().position + w_.origin_,
      "; remove liquid there (remove_liquid), choose another place, or move there without teleport");
}

/// Each to the nearest of the places that is left.
void WorldImpl::Teleport::match() {
  if (buried_.size() > most_matched) return;
  std::vector<Vec3d> left = places_;
  for (std::size_t k = 0; k < buried_.size(); ++k) {
    std::size_t nearest = 0;
    double best = infinity;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const Vec3d d = left[i] - buried_[k].position;
      if (dot(d, d) < best) {
        best = dot(d, d);
        nearest = i;
      }
    }
    places_[k] = left[nearest];
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(nearest));
  }
}

Status WorldImpl::Teleport::carry_out() {
  double work = 0;
  for (std::size_t k = 0; k < buried_.size(); ++k) {
    Vec3d& x = places_[k];
    for (double* c : {&x.x, &x.y, &x.z}) w_.round_to_precision(*c);
    work -= buried_[k].mass * dot(w_.desc.gravity, x - buried_[k].position);
    buried_[k].position = x;
  }
  if (on_backend_) {
    if (Status s = w_.engine->move(buried_); !s) return s;
    w_.state_stale_ = true;
  } else {
    for (const FoundParticle& p : buried_) w_.state_.position[p.id] = p.position;
    w_.dirty_ = true;
  }
  w_.places_.reset();
  w_.displaced_ += buried_.size();
  w_.displaced_work_ += work;
  // Liquid may fall from where it is now.
  const double g = length(w_.desc.gravity), sound = w_.sound_speed_;
  const Vec3d up = g > 0 ? w_.desc.gravity * (-1.0 / g) : Vec3d{};
  for (const Vec3d& x : places_) w_.see(x + w_.origin_, up);
  if (sound > 0) {
    w_.derive_sound_speed();
    if (!w_.dirty_) w_.derive_limits();
    if (w_.sound_speed_ != sound) {
      w_.plan_changed_ = true;
      ++w_.layout_;
    }
  }
  w_.look_now_ = true;
  return {};
}

/// Waits. Liquid that a body would bury at another place goes out of its way; what cannot is refused, and nothing changes.
Status WorldImpl::clear_for_teleport(std::uint32_t body, const physics::RigidPlace& place) {
  start_at_rest();
  Teleport teleport(*this, body, place);
  if (Status s = teleport.find_buried(); !s || !teleport.buries()) return s;
  if (Status s = teleport.find_places(); !s) return s;
  laid_out_ = {};  // liquid stays where it goes
  return teleport.carry_out();
}

}  // namespace v0
}  // namespace meltsim
