// SPDX-License-Identifier: Apache-2.0
// Liquid that starts at rest (physics/hydrostatic.hpp): columns of particles, their runs, and what presses on each.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "description/point_grid.hpp"
#include "description/validate.hpp"
#include "meltsim/physics/force_field.hpp"
#include "meltsim/physics/hydrostatic.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

double part(const Vec3d& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
double& part(Vec3d& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/// The axis nearest to a direction.
int axis_of(const Vec3d& v) {
  if (std::fabs(v.y) >= std::fabs(v.x) && std::fabs(v.y) >= std::fabs(v.z)) return 1;
  return std::fabs(v.x) >= std::fabs(v.z) ? 0 : 2;
}

/// A particle of liquid in its column.
struct Place {
  std::uint64_t column = 0;  ///< its number
  double height = 0;         ///< against gravity [m]
  std::uint32_t id = 0;
};
bool operator<(const Place& a, const Place& b) {
  if (a.column != b.column) return a.column < b.column;
  return a.height != b.height ? a.height < b.height : a.id < b.id;
}

/// Particles of a column without a gap between them.
struct Run {
  std::size_t first = 0, end = 0;  ///< of the places, from below
  bool stands = false;             ///< on a wall or a body
  bool open = false;               ///< its top is a free surface
  double level = -infinity;        ///< of the free surface that its pressure goes by [m]
  bool pressed = false;            ///< its weight compresses it
  std::size_t surface = none;      ///< number of its surface among those of its part; none: it has none
  const std::vector<double>* risen =
      nullptr;  ///< its topmost layers above where their depth puts them [spacings]

  static constexpr std::size_t none = static_cast<std::size_t>(-1);
};

/// What a run's volume fractions follow from, these, and heights of cells that have them [m].
struct Pressed {
  double on_top = 0;
  std::vector<double> weights, stiffness;
  physics::LiquidCell cell;
  std::vector<double> phi, cells;
  bool alike(const Pressed& o) const {
    return on_top == o.on_top && weights == o.weights && stiffness == o.stiffness && cell == o.cell;
  }
};

/// Layers near a free surface, which sums and not depth alone put in their places.
constexpr std::size_t surface_layers = 24;

/// x of A x = b by elimination, A in rows of b.size(); {} where A is singular.
std::vector<double> solved(std::vector<double> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::fabs(a[i * n + k]) > std::fabs(a[pivot * n + k])) pivot = i;
    if (!(std::fabs(a[pivot * n + k]) > 0)) return {};
    std::swap_ranges(a.begin() + k * n, a.begin() + (k + 1) * n, a.begin() + pivot * n);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] / a[k * n + k];
      for (std::size_t j = k; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k * n + j] * b[j];
    b[k] /= a[k * n + k];
  }
  return b;
}

/// How far layers below a free surface come to lie above where their depth puts them.
class SurfaceLayers {
 public:
  /// The layers below a surface.
  struct Surface {
    std::vector<double> density;  ///< the lowest first [of any unit]
    bool stands = false;          ///< they are all there are, on a floor; else liquid goes on below them
    double pull = 0;              ///< g dx/c^2
    physics::LiquidCell cell;
    bool operator==(const Surface& o) const {
      return density == o.density && stands == o.stands && pull == o.pull && cell == o.cell;
    }
    bool operator<(const Surface& o) const { return key() < o.key(); }
    std::tuple<const std::vector<double>&, bool, double, double, double, double> key() const {
      return {density, stands, pull, cell.x, cell.z, cell.height};
    }
  };
  SurfaceLayers(double support_in_spacings, const core::HostLoops& loops)
      : loops_(loops),
        support_(support_in_spacings),
        held_(static_cast<std::size_t>(2 * support_in_spacings) + 2) {}
  /// Of the topmost layers, of which there should be this many below a free surface.
  std::size_t wanted() const { return surface_layers + held_; }
  /// In spacings, one per layer; null: depth alone holds.
  const std::vector<double>* rise(const Surface& s) {
    Surface alike = s;
    for (double& d : alike.density) d /= s.density.back();
    const auto known = known_.find(alike);
    if (known != known_.end()) return &known->second;
    if (known_.size() == most_known) return nullptr;
    return &(known_[alike] = solve(alike, physics::LayerSums(support_, alike.cell)));
  }

 private:
  /// Newton's method: the sums are smooth but where a layer's pressure begins, so that a few steps do. Where they do not, depth
  /// alone holds.
  std::vector<double> solve(const Surface& s, const physics::LayerSums& sums) const {
    constexpr int most_steps = 20;
    constexpr double close = 1e-9, farthest = 0.1, least_distance = 0.5;  // [spacings]
    const std::size_t n = s.density.size(), held = s.stands ? 0 : std::min(held_, n);
    std::vector<double> cells = sums.by_depth(s.density, s.pull);
    for (double& phi : cells) phi = sums.cell_height(phi);
    const std::vector<double> nothing(n, 0.0), start = physics::stacked(cells, 0);
    std::vector<double> at = start;
    for (int step = 0; step < most_steps; ++step) {
      const std::vector<double> move = newton_step(at, s, sums, held);
      double largest = move.empty() ? infinity : 0;
      for (const double m : move) largest = std::max(largest, std::fabs(m));
      if (!(largest < infinity)) return nothing;
      for (std::size_t i = held; i < n; ++i)
        at[i] += move[i - held] * (largest > farthest ? farthest / largest : 1.0);
      if (largest > close) continue;
      for (std::size_t i = 1; i < n; ++i)  // wide kernels have balances with layers on top of each other
        if (at[i] - at[i - 1] < least_distance) return nothing;
      for (std::size_t i = 0; i < n; ++i) at[i] -= start[i];
      return at;
    }
    return nothing;
  }
  /// Of the layers that are not held.
  std::vector<double> newton_step(const std::vector<double>& at, const Surface& s,
                                  const physics::LayerSums& sums, std::size_t held) const {
    constexpr double nudge = 1e-7;
    const std::size_t n = at.size(), free = n - held;
    const auto forces = [&](const std::vector<double>& heights) {
      return sums.balance(heights, s.density, held, s.pull, s.stands);
    };
    const std::vector<double> now = forces(at);
    std::vector<double> slope(free * free), wanted(free);
    loops_.each(static_cast<std::int64_t>(free), [&](std::int64_t column) {
      const auto j = static_cast<std::size_t>(column);
      std::vector<double> moved = at;
      moved[held + j] += nudge;
      const std::vector<double> then = forces(moved);
      for (std::size_t i = 0; i < free; ++i) slope[i * free + j] = (then[held + i] - now[held + i]) / nudge;
      wanted[j] = -now[held + j];
    });
    return solved(std::move(slope), std::move(wanted));
  }

  static constexpr std::size_t most_known = 40;  // further ones go by depth alone
  const core::HostLoops& loops_;
  double support_;  ///< H/dx
  std::size_t held_;
  std::map<Surface, std::vector<double>> known_;
};

/// The columns of a scene.
class Columns {
 public:
  /// fields: those that act on liquid at the start.
  Columns(const core::SceneState& state, const WorldDesc& desc, Vec3d origin, double sound_speed,
          std::vector<physics::ForceField<double>> fields, const std::vector<LiquidFill>& fills,
          const core::HostLoops& loops)
      : loops_(loops),
        state_(state),
        desc_(desc),
        fields_(std::move(fields)),
        fills_(fills),
        axis_(axis_of(desc.gravity)),
        sound_speed_(sound_speed),
        surface_(core::support_of(desc) / desc.spacing, loops) {
    const Vec3d g = desc.gravity;
    up_ = part(g, axis_) > 0 ? -1 : 1;
    low_ = part(desc.domain.min - origin, axis_);
    high_ = part(desc.domain.max - origin, axis_);
    if (up_ < 0) {
      std::swap(low_, high_);
      low_ = -low_;
      high_ = -high_;
    }
    for (int k = 0; k < 2; ++k) {
      for (const LiquidFill& f : fills_)
        inverse_pitch_[k] = std::max(inverse_pitch_[k], 1 / part(f.cell, across_[k]));
      if (fills_.empty()) inverse_pitch_[k] = 1 / desc.spacing;
    }
  }
  /// Puts liquid that its weight compresses in its places. moved: for how many, before any is; then move(k, id, new coordinate along the axis)
  /// of each, k = 0, 1, ..., in several threads.
  template <class Moved, class Move>
  void press(const Moved& moved, const Move& move) {
    sort();
    find_runs();
    find_bodies();
    find_levels();
    heights_.resize(places_.size());
    const std::vector<std::size_t> first = find_heights();
    moved(first.back());
    loops_.each(static_cast<std::int64_t>(first.size()) - 1, [&](std::int64_t part) {
      std::size_t k = first[static_cast<std::size_t>(part)];
      each_run_of(part, [&](const Run& r) {
        const std::size_t layers = r.risen != nullptr ? std::min(r.end - r.first, r.risen->size()) : 0;
        for (std::size_t i = r.first; i < r.end && r.pressed; ++i) {
          const double risen =
              r.end - i <= layers ? desc_.spacing * (*r.risen)[r.risen->size() - (r.end - i)] : 0.0;
          move(k++, places_[i].id, up_ * (heights_[i] + risen));
        }
      });
    });
  }
  int axis() const { return axis_; }
  /// Ids of liquid that stands on nothing.
  std::vector<std::uint32_t> hanging() {
    sort();
    find_runs();
    find_bodies();
    std::vector<std::uint32_t> ids;
    for (const Run& r : runs_)
      for (std::size_t i = r.first; i < r.end && !r.stands; ++i) ids.push_back(places_[i].id);
    return ids;
  }

 private:
  double gravity() const { return std::fabs(part(desc_.gravity, axis_)); }
  /// What pulls a particle along gravity [m/s^2]: with fields perhaps nothing.
  double pull(std::uint32_t id) const { return pull(id, state_.position[id]); }
  /// The same of the particle at another place.
  double pull(std::uint32_t id, Vec3d x) const {
    Vec3d a = desc_.gravity;
    const physics::Weighed<double> weighed{desc_.gravity, state_.volume[id] / state_.mass[id]};
    physics::Winds<double> winds;
    for (const physics::ForceField<double>& f : fields_)
      if (physics::in_force_region(f, x - f.center)) {
        a += physics::force_field_acceleration(f, x - f.about, weighed);
        winds.add(f, x - f.about);
      }
    a += physics::wind_acceleration(winds, state_.velocity[id], a, 0.0);
    return std::max(-up_ * part(a, axis_), 0.0);
  }
  double height(Vec3d x) const { return up_ * part(x, axis_); }

  bool is_liquid(std::size_t i) const { return is_fluid(state_.tag[i]); }
  /// Liquid in the box of columns.
  struct Spread {
    double low[2] = {infinity, infinity}, high[2] = {-infinity, -infinity};
    std::size_t liquid = 0, solid = 0;
  };
  Spread spread_of(std::size_t i, std::size_t end) const {
    Spread s;
    for (; i < end; ++i) {
      if (is_solid(state_.tag[i])) ++s.solid;
      if (!is_liquid(i)) continue;
      ++s.liquid;
      for (int k = 0; k < 2; ++k) {
        const double x = part(state_.position[i], across_[k]);
        s.low[k] = std::min(s.low[k], x);
        s.high[k] = std::max(s.high[k], x);
      }
    }
    return s;
  }
  std::int64_t along(int k, double x) const {
    return std::llround((x - middle_[k]) * inverse_pitch_[k]) - low_column_[k];
  }
  /// Columns are numbered row by row. Lattices are no larger than 2e9 spacings, so that 64 bits are enough.
  std::uint64_t column_of(const Vec3d& x) const {
    return static_cast<std::uint64_t>(along(0, part(x, across_[0])) * columns_[1] +
                                      along(1, part(x, across_[1])));
  }

  void sort() {
    const std::size_t n = state_.position.size();
    Spread all;
    for (const Spread& s : loops_.template of_pieces<Spread>(
             n, [this](std::size_t i, std::size_t end) { return spread_of(i, end); })) {
      all.liquid += s.liquid;
      all.solid += s.solid;
      for (int k = 0; k < 2; ++k) {
        all.low[k] = std::min(all.low[k], s.low[k]);
        all.high[k] = std::max(all.high[k], s.high[k]);
      }
    }
    bodies_ = all.solid != 0;
    if (all.liquid == 0) return;
    std::size_t first = 0;
    while (!is_liquid(first)) ++first;
    for (int k = 0; k < 2; ++k) {  // the middle of a column, so that rounding cannot tear it apart
      middle_[k] = part(state_.position[first], across_[k]);
      low_column_[k] = 0;
      low_column_[k] = along(k, all.low[k]);
      columns_[k] = along(k, all.high[k]) + 1;
    }
    loops_.resize(places_, all.liquid);
    counted_ = double(columns_[0]) * double(columns_[1]) <= 2.0 * double(all.liquid);
    if (counted_) return sort_by_counting();
    std::size_t to = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (is_liquid(i)) places_[to++] = place_of(i, column_of(state_.position[i]));
    std::sort(places_.begin(), places_.end());
  }
  Place place_of(std::size_t i, std::uint64_t column) const {
    return {column, height(state_.position[i]), static_cast<std::uint32_t>(i)};
  }
  /// Where there are not many more columns than places, by counting the places of each column: particles mostly come from a lattice, in
  /// which those of a column are in order already. Each of a few shares of the particles has counts of its own, no more of them than
  /// there are places.
  void sort_by_counting() {
    const std::size_t n = state_.position.size();
    const auto columns = static_cast<std::size_t>(columns_[0] * columns_[1]);
    const std::size_t shares = std::clamp<std::size_t>(places_.size() / columns, 1, 16);
    std::vector<std::uint32_t> column;
    loops_.resize(column, n);
    std::vector<std::size_t> next(shares * columns, 0);
    const auto each_of_share = [&](std::int64_t share, const auto& visit) {
      const auto s = static_cast<std::size_t>(share);
      for (std::size_t i = n * s / shares; i < n * (s + 1) / shares; ++i)
        if (is_liquid(i)) visit(i, next.data() + s * columns);
    };
    loops_.each(static_cast<std::int64_t>(shares), [&](std::int64_t share) {
      each_of_share(share, [&](std::size_t i, std::size_t* counts) {
        column[i] = static_cast<std::uint32_t>(column_of(state_.position[i]));
        ++counts[column[i]];
      });
    });
    first_place_.assign(columns + 1, 0);
    std::size_t sum = 0;
    for (std::size_t k = 0; k < columns; ++k) {
      first_place_[k] = sum;
      for (std::size_t s = 0; s < shares; ++s) sum += std::exchange(next[s * columns + k], sum);
    }
    first_place_[columns] = sum;
    loops_.each(static_cast<std::int64_t>(shares), [&](std::int64_t share) {
      each_of_share(
          share, [&](std::size_t i, std::size_t* to) { places_[to[column[i]]++] = place_of(i, column[i]); });
    });
  }
  /// Columns come in parts, those that are counted.
  static constexpr std::size_t columns_of_part = 64;
  std::int64_t parts() const {
    if (places_.empty()) return 0;
    return counted_ ? static_cast<std::int64_t>((first_place_.size() - 2) / columns_of_part + 1) : 1;
  }
  std::size_t first_of_part(std::int64_t part) const {
    if (!counted_) return part == 0 ? 0 : places_.size();
    return first_place_[std::min(first_place_.size() - 1, static_cast<std::size_t>(part) * columns_of_part)];
  }
  template <class Visit>
  void each_run_of(std::int64_t part, const Visit& visit) {
    for (std::size_t k = first_run_[static_cast<std::size_t>(part)];
         k < first_run_[static_cast<std::size_t>(part) + 1]; ++k)
      visit(runs_[k]);
  }
  bool same_column(std::size_t a, std::size_t b) const { return places_[a].column == places_[b].column; }
  /// About a spacing above (way 1) or below (way -1) a place.
  Vec3d beyond(std::size_t place, int way) const {
    Vec3d x = state_.position[places_[place].id];
    part(x, axis_) += way * up_ * 0.75 * desc_.spacing;
    return x;
  }
  bool is_wall(bool upper) const {
    const std::size_t face = static_cast<std::size_t>(2 * axis_) + ((up_ > 0) == upper ? 1u : 0u);
    return desc_.domain.bounded && desc_.domain.faces[face] == Face::wall;
  }
  void find_runs() {
    std::vector<std::vector<Run>> of_part(static_cast<std::size_t>(parts()));
    loops_.each(parts(), [&](std::int64_t part) {
      const auto first = places_.begin() + static_cast<std::ptrdiff_t>(first_of_part(part));
      const auto end = places_.begin() + static_cast<std::ptrdiff_t>(first_of_part(part + 1));
      if (!std::is_sorted(first, end)) std::sort(first, end);
      find_runs(first_of_part(part), first_of_part(part + 1), of_part[static_cast<std::size_t>(part)]);
    });
    for (const std::vector<Run>& runs : of_part) {
      first_run_.push_back(runs_.size());
      runs_.insert(runs_.end(), runs.begin(), runs.end());
    }
    first_run_.push_back(runs_.size());
    if (!counted_) return;
    run_of_column_.assign(first_place_.size() - 1, runs_.size());
    for (std::size_t k = runs_.size(); k-- > 0;) run_of_column_[places_[runs_[k].first].column] = k;
  }
  void find_runs(std::size_t first, std::size_t end, std::vector<Run>& runs) const {
    const double dx = desc_.spacing;
    for (std::size_t i = first; i < end;) {
      Run r;
      r.first = i++;
      while (i < end && same_column(i, r.first) && places_[i].height - places_[i - 1].height < 1.5 * dx) ++i;
      r.end = i;
      r.stands = is_wall(false) && places_[r.first].height - low_ < dx;
      r.open = !(is_wall(true) && high_ - places_[r.end - 1].height < dx);
      runs.push_back(r);
    }
  }
  /// Which runs stand on bodies or end below them. Hashed is where that is asked, of which there is less than particles of bodies.
  void find_bodies() {
    if (!bodies_ || runs_.empty()) return;
    core::PointGrid asked(0.75 * desc_.spacing);
    for (std::size_t k = 0; k < runs_.size(); ++k) {
      if (!runs_[k].stands) asked.add(beyond(runs_[k].first, -1), static_cast<std::uint32_t>(2 * k));
      if (runs_[k].open) asked.add(beyond(runs_[k].end - 1, 1), static_cast<std::uint32_t>(2 * k + 1));
    }
    std::vector<std::uint8_t> met(2 * runs_.size(), 0);
    loops_.pieces(state_.position.size(), [&](std::size_t i, std::size_t end) {
      for (; i < end; ++i)
        if (is_solid(state_.tag[i]))
          asked.near(state_.position[i], [&met](std::uint32_t k) {
            __atomic_store_n(&met[k], std::uint8_t{1}, __ATOMIC_RELAXED);
            return false;
          });
    });
    for (std::size_t k = 0; k < runs_.size(); ++k) {
      runs_[k].stands = runs_[k].stands || met[2 * k] != 0;
      runs_[k].open = runs_[k].open && met[2 * k + 1] == 0;
    }
  }
  double top(const Run& r) const { return places_[r.end - 1].height + 0.5 * desc_.spacing; }
  double bottom(const Run& r) const { return places_[r.first].height - 0.5 * desc_.spacing; }

  /// Calls visit(run) for those in the columns beside that it touches.
  template <class Visit>
  void for_each_beside(const Run& r, const Visit& visit) {
    constexpr int ways[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const auto from = static_cast<std::int64_t>(places_[r.first].column);
    for (const auto& way : ways) {
      const std::int64_t row = from / columns_[1] + way[0], along_row = from % columns_[1] + way[1];
      if (row < 0 || row >= columns_[0] || along_row < 0 || along_row >= columns_[1]) continue;
      const auto column = static_cast<std::uint64_t>(row * columns_[1] + along_row);
      for (std::size_t k = first_run_in(column); k < runs_.size() && places_[runs_[k].first].column == column;
           ++k)
        if (std::min(top(runs_[k]), top(r)) - std::max(bottom(runs_[k]), bottom(r)) > 0.5 * desc_.spacing)
          visit(runs_[k]);
    }
  }
  std::size_t first_run_in(std::uint64_t column) const {
    if (counted_) return run_of_column_[column];
    const auto run =
        std::lower_bound(runs_.begin(), runs_.end(), column,
                         [this](const Run& a, std::uint64_t c) { return places_[a.first].column < c; });
    return static_cast<std::size_t>(run - runs_.begin());
  }
  /// Of runs below bodies and lids: that of the nearest run, by columns, with a free surface.
  void find_levels() {
    std::vector<Run*> reached;
    for (Run& r : runs_)
      if (r.open) {
        r.level = top(r);
        reached.push_back(&r);
      }
    for (std::size_t k = 0; k < reached.size(); ++k)
      for_each_beside(*reached[k], [&](Run& beside) {
        if (beside.level > -infinity) return;
        beside.level = reached[k]->level;
        reached.push_back(&beside);
      });
  }
  /// Pressure at the top of a run [Pa]: of the liquid up to the level beside it. In a full box, where liquid may pull, it is on average none.
  template <class Weight>
  double on_top(const Run& r, const Weight& weight, double mass_per_area) const {
    if (r.level > -infinity)
      return hydrostatic_ ? pull_above(r) * mass_per_area
                          : std::max(r.level - top(r), 0.0) / desc_.spacing * weight(r.end - 1);
    double all = 0;
    for (std::size_t i = r.first; i < r.end && desc_.tension; ++i) all += weight(i);
    return -0.5 * all;
  }
  /// Sum of what pulls on the particle at the top of a run, were it in the layers between there and the level beside it [m/s^2]: hydrostatic
  /// fields take out more the deeper it is.
  double pull_above(const Run& r) const {
    const std::uint32_t id = places_[r.end - 1].id;
    const double above = std::max(r.level - top(r), 0.0), layers = std::ceil(above / desc_.spacing);
    double sum = 0;
    for (double k = 0; k < layers; ++k) {
      Vec3d x = state_.position[id];
      part(x, axis_) = up_ * (top(r) + above * (k + 0.5) / layers);
      sum += pull(id, x) * above / (layers * desc_.spacing);
    }
    return sum;
  }
  /// Cells of liquid may be laid out longer or shorter than a spacing (WorldImpl::cell_of); what rounding makes of one is one.
  static double unless_alike(double length, double usual) {
    return std::fabs(length / usual - 1) < 1e-3 ? usual : length;
  }
  /// Height of the cells of a run as they were laid out [m].
  double layer(const Run& r) const {
    const auto gaps = static_cast<double>(r.end - r.first - 1);
    if (gaps == 0) return desc_.spacing;
    return unless_alike((places_[r.end - 1].height - places_[r.first].height) / gaps, desc_.spacing);
  }
  /// Of all runs that stand. What is to move, in order: the first of every part and one more.
  std::vector<std::size_t> find_heights() {
    std::vector<std::vector<SurfaceLayers::Surface>> surfaces(static_cast<std::size_t>(parts()));
    std::vector<std::size_t> first(surfaces.size() + 1, 0);
    loops_.each(parts(), [&](std::int64_t part) {
      Pressed last;  // of the run before: most are like that
      each_run_of(part, [&](Run& r) {
        if (r.stands) find_heights(r, last, surfaces[static_cast<std::size_t>(part)]);
        if (r.pressed) first[static_cast<std::size_t>(part) + 1] += r.end - r.first;
      });
    });
    std::partial_sum(first.begin(), first.end(), first.begin());
    // One after another: only so many surfaces are solved for.
    for (std::int64_t part = 0; part < parts(); ++part) {
      std::vector<const std::vector<double>*> risen;
      for (const SurfaceLayers::Surface& s : surfaces[static_cast<std::size_t>(part)])
        risen.push_back(surface_.rise(s));
      each_run_of(part, [&](Run& r) {
        if (r.surface != Run::none) r.risen = risen[r.surface];
      });
    }
    return first;
  }
  /// How the liquid of a run was laid out.
  physics::LiquidCell cell_of(const Run& r) const {
    const std::uint32_t id = places_[r.first].id;
    physics::LiquidCell cell;
    for (const LiquidFill& f : fills_) {
      if (id < f.first || id >= f.end) continue;
      cell.x = unless_alike(part(f.cell, across_[0]) / desc_.spacing, 1);
      cell.z = unless_alike(part(f.cell, across_[1]) / desc_.spacing, 1);
    }
    cell.height = layer(r) / desc_.spacing;
    return cell;
  }
  /// Heights of the cells of layers that are dx high as laid out [m].
  void find_cells(Pressed& p, double dx) const {
    p.cells = p.phi;
    if (p.cell.even()) {
      for (double& c : p.cells) c = dx / c;
      return;
    }
    const physics::LayerSums sums(core::support_of(desc_) / desc_.spacing, p.cell);
    for (double& c : p.cells) c = desc_.spacing * sums.cell_height(c);
  }
  void find_heights(Run& r, Pressed& last, std::vector<SurfaceLayers::Surface>& surfaces) {
    const double dx = layer(r), square = desc_.spacing * desc_.spacing;
    const auto mass = [&](std::size_t place) { return state_.mass[places_[place].id]; };
    const auto volume = [&](std::size_t place) { return state_.volume[places_[place].id]; };
    const auto area = [&](std::size_t place) { return unless_alike(volume(place) / dx, square); };
    const auto weight = [&](std::size_t place) {
      return pull(places_[place].id) * mass(place) / area(place);
    };
    constexpr double most_fraction = 1.1;  // beyond, layers are no lattice any more: left as it was laid out
    std::vector<double> weights(r.end - r.first), stiffness(r.end - r.first);
    for (std::size_t i = r.first; i < r.end; ++i) {
      weights[i - r.first] = weight(i);
      stiffness[i - r.first] = physics::tait_stiffness(mass(i) / volume(i), sound_speed_);
    }
    Pressed pressed{on_top(r, weight, mass(r.end - 1) / area(r.end - 1)),
                    std::move(weights),
                    std::move(stiffness),
                    cell_of(r),
                    {},
                    {}};
    if (!pressed.alike(last)) {
      pressed.phi = physics::hydrostatic_fractions(pressed.on_top, pressed.weights, pressed.stiffness);
      last = std::move(pressed);
      find_cells(last, dx);
    }
    for (const double fraction : last.phi)
      if (!(fraction <= most_fraction && fraction >= 1 / most_fraction)) return;
    const std::vector<double> heights = physics::stacked(last.cells, places_[r.first].height - 0.5 * dx);
    std::copy(heights.begin(), heights.end(), heights_.begin() + static_cast<std::ptrdiff_t>(r.first));
    r.pressed = true;
    find_surface(r, surfaces);
  }
  /// The free surface that does something to the layers of a run; where it has none, or where what pulls on them differs, there is none.
  void find_surface(Run& r, std::vector<SurfaceLayers::Surface>& surfaces) const {
    if (!r.open || desc_.tension) return;
    const bool on_floor = is_wall(false) && places_[r.first].height - low_ < desc_.spacing;
    const std::size_t layers = std::min(r.end - r.first, surface_.wanted());
    const double pulled = pull(places_[r.end - 1].id);
    SurfaceLayers::Surface s;
    for (std::size_t i = r.end - layers; i < r.end; ++i) {
      if (pull(places_[i].id) != pulled) return;
      s.density.push_back(state_.mass[places_[i].id] / state_.volume[places_[i].id]);
    }
    s.pull = pulled * desc_.spacing / (sound_speed_ * sound_speed_);
    s.cell = cell_of(r);
    s.stands = on_floor && layers == r.end - r.first;
    // A body answers liquid with the liquid's own pressure, as if it went on there.
    if (!s.stands) s.density.insert(s.density.begin(), surface_.wanted() - layers, s.density.front());
    if (surfaces.empty() || !(surfaces.back() == s)) surfaces.push_back(std::move(s));
    r.surface = surfaces.size() - 1;
  }

  const core::HostLoops& loops_;
  const core::SceneState& state_;
  const WorldDesc& desc_;
  std::vector<physics::ForceField<double>> fields_;
  const bool hydrostatic_ = std::any_of(fields_.begin(), fields_.end(), [](const auto& f) {
    return f.kind == physics::ForceKind::hydrostatic;
  });
  const std::vector<LiquidFill>& fills_;
  int axis_, up_ = 1;                                         ///< up_: sign of what is against gravity
  double sound_speed_;                                        ///< [m/s]
  double low_ = 0, high_ = 0;                                 ///< of the domain, against gravity [m]
  int across_[2] = {axis_ == 0 ? 1 : 0, axis_ == 2 ? 1 : 2};  ///< the axes that columns are numbered along
  /// Of columns [1/m]: of the narrowest cells, so that no two have one number.
  double inverse_pitch_[2] = {};
  double middle_[2] = {};  ///< of a column [m]
  std::int64_t low_column_[2] = {}, columns_[2] = {};
  bool bodies_ = false;   ///< there are particles of bodies
  bool counted_ = false;  ///< there are not many more columns than places
  std::vector<Place> places_;
  std::vector<std::size_t> first_place_;  ///< per column that is counted, and one more
  std::vector<Run> runs_;
  std::vector<std::size_t> first_run_;  ///< per part, and one more
  std::vector<std::size_t>
      run_of_column_;            ///< where they are counted: the first one, or how many runs there are
  std::vector<double> heights_;  ///< per place: where its depth puts it, against gravity [m]
  SurfaceLayers surface_;
};

}  // namespace

/// Liquid where it was laid out, before it was compressed.
void WorldImpl::lay_out() {
  if (laid_out_.empty()) return;
  if (steps == 0) {
    for (const LaidOut& l : laid_out_) part(state_.position[l.id], laid_out_axis_) = l.at;
    pressed_ = false;
    dirty_ = true;
    places_.reset();
  }
  laid_out_ = {};
}

/// Derives the speed of sound between steps. Liquid that is compressed for another one is laid out, to be compressed anew.
void WorldImpl::derive_sound_anew() {
  const double sound = sound_speed_;
  derive_sound_speed();
  if (sound_speed_ == sound || steps != 0 || laid_out_.empty()) return;
  update_state();
  lay_out();
}

/// Ahead of what reads or moves particles: what is read before the first step is what the step begins with.
void WorldImpl::start_at_rest() {
  if (desc.hydrostatic_start && steps == 0 && dirty_)
    static_cast<void>(prepare());  // a failure shows at the step
}

/// Ids of liquid that stands on nothing, by the state that the host has.
std::vector<std::uint32_t> WorldImpl::hanging() const {
  if (!(length(desc.gravity) > 0)) return {};
  const core::HostLoops shared = loops();
  return Columns(state_, desc, origin_, sound_speed_, {}, fills_, shared).hanging();
}

/// Compresses liquid as its weight does. Before the first step, at the speed of sound of the scene.
void WorldImpl::press_liquid() {
  if (!desc.hydrostatic_start || steps != 0 || pressed_ || !(length(desc.gravity) > 0)) return;
  std::vector<physics::ForceField<double>> fields = acting_fields();
  fields.erase(std::remove_if(fields.begin(), fields.end(), [](const auto& f) { return f.liquid == 0u; }),
               fields.end());
  const core::HostLoops shared = loops();
  Columns columns(state_, desc, origin_, sound_speed_, std::move(fields), fills_, shared);
  laid_out_axis_ = columns.axis();
  columns.press([&](std::size_t n) { shared.resize(laid_out_, n); },
                [&](std::size_t k, std::uint32_t id, double at) {
                  double& x = part(state_.position[id], laid_out_axis_);
                  laid_out_[k] = {id, x};
                  round_to_precision(at);
                  x = at;
                });
  pressed_ = !laid_out_.empty();
  if (pressed_) places_.reset();
}

}  // namespace v0
}  // namespace meltsim
