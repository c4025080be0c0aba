// SPDX-License-Identifier: Apache-2.0
// Liquid that starts at rest (physics/hydrostatic.hpp): columns of particles, their runs, and what presses on each.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
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
  std::int64_t column[2];  ///< across the axis, in spacings
  double height;           ///< against gravity [m]
  std::uint32_t id;
};
bool operator<(const Place& a, const Place& b) {
  if (a.column[0] != b.column[0]) return a.column[0] < b.column[0];
  if (a.column[1] != b.column[1]) return a.column[1] < b.column[1];
  return a.height != b.height ? a.height < b.height : a.id < b.id;
}

/// Particles of a column without a gap between them.
struct Run {
  std::size_t first = 0, end = 0;  ///< of the places, from below
  bool stands = false;             ///< on a wall or a body
  bool open = false;               ///< its top is a free surface
  double level = -infinity;        ///< of the free surface that its pressure goes by [m]
};

/// What a run's volume fractions follow from, and these.
struct Pressed {
  double on_top = 0;
  std::vector<double> weights, stiffness, phi;
  bool alike(const Pressed& o) const {
    return on_top == o.on_top && weights == o.weights && stiffness == o.stiffness;
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
  SurfaceLayers(double support_in_spacings, double pull)
      : sums_(support_in_spacings),
        pull_(pull),
        held_(static_cast<std::size_t>(2 * support_in_spacings) + 2) {}
  /// Of the topmost layers, of which there should be this many below a free surface.
  std::size_t wanted() const { return surface_layers + held_; }
  /// density: of the layers, the lowest first [of any unit]; stands: they are all there are, on a floor; else liquid goes on below them.
  /// In spacings.
  std::vector<double> rise(const std::vector<double>& density, bool stands) {
    std::pair<std::vector<double>, bool> key{density, stands};
    for (double& d : key.first) d /= density.back();
    const auto known = known_.find(key);
    if (known != known_.end()) return known->second;
    if (known_.size() == most_known) return std::vector<double>(density.size(), 0.0);
    return known_[key] = solve(key.first, stands);
  }

 private:
  /// Newton's method: the sums are smooth but where a layer's pressure begins, so that a few steps do. Where they do not, depth
  /// alone holds.
  std::vector<double> solve(const std::vector<double>& density, bool stands) const {
    constexpr int most_steps = 20;
    constexpr double close = 1e-9, farthest = 0.1, least_distance = 0.5;  // [spacings]
    const std::size_t n = density.size(), held = stands ? 0 : std::min(held_, n);
    const std::vector<double> nothing(n, 0.0),
        start = physics::stacked(physics::LayerSums::by_depth(density, pull_), 0, 1);
    std::vector<double> at = start;
    for (int step = 0; step < most_steps; ++step) {
      const std::vector<double> move = newton_step(at, density, held, stands);
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
  std::vector<double> newton_step(const std::vector<double>& at, const std::vector<double>& density,
                                  std::size_t held, bool stands) const {
    constexpr double nudge = 1e-7;
    const std::size_t n = at.size(), free = n - held;
    const auto forces = [&](const std::vector<double>& heights) {
      return sums_.balance(heights, density, held, pull_, stands);
    };
    const std::vector<double> now = forces(at);
    std::vector<double> slope(free * free), wanted(free);
    for (std::size_t j = 0; j < free; ++j) {
      std::vector<double> moved = at;
      moved[held + j] += nudge;
      const std::vector<double> then = forces(moved);
      for (std::size_t i = 0; i < free; ++i) slope[i * free + j] = (then[held + i] - now[held + i]) / nudge;
      wanted[j] = -now[held + j];
    }
    return solved(std::move(slope), std::move(wanted));
  }

  static constexpr std::size_t most_known = 40;  // further ones go by depth alone
  physics::LayerSums sums_;
  double pull_;  ///< g dx/c^2
  std::size_t held_;
  std::map<std::pair<std::vector<double>, bool>, std::vector<double>> known_;
};

/// The columns of a scene.
class Columns {
 public:
  /// fields: those that act on liquid at the start.
  Columns(const core::SceneState& state, const WorldDesc& desc, Vec3d origin, double sound_speed,
          std::vector<physics::ForceField<double>> fields)
      : state_(state),
        desc_(desc),
        fields_(std::move(fields)),
        axis_(axis_of(desc.gravity)),
        sound_speed_(sound_speed),
        surface_(core::support_of(desc) / desc.spacing,
                 gravity() * desc.spacing / (sound_speed * sound_speed)) {
    const Vec3d g = desc.gravity;
    up_ = part(g, axis_) > 0 ? -1 : 1;
    low_ = part(desc.domain.min - origin, axis_);
    high_ = part(desc.domain.max - origin, axis_);
    if (up_ < 0) {
      std::swap(low_, high_);
      low_ = -low_;
      high_ = -high_;
    }
  }
  /// Calls move(id, new coordinate along the axis) for liquid that its weight compresses.
  template <class Move>
  void press(const Move& move) {
    sort();
    find_runs();
    find_levels();
    for (const Run& r : runs_)
      if (r.stands) press(r, move);
  }
  int axis() const { return axis_; }

 private:
  double gravity() const { return std::fabs(part(desc_.gravity, axis_)); }
  /// What pulls a particle along gravity [m/s^2]: with fields perhaps nothing.
  double pull(std::uint32_t id) const {
    Vec3d a = desc_.gravity;
    for (const physics::ForceField<double>& f : fields_)
      if (physics::in_force_region(f, state_.position[id] - f.center))
        a += physics::force_field_acceleration(f, state_.position[id] - f.about, state_.velocity[id], 0.0);
    return std::max(-up_ * part(a, axis_), 0.0);
  }
  double height(Vec3d x) const { return up_ * part(x, axis_); }

  void sort() {
    const double inverse = 1 / desc_.spacing;
    const int first = axis_ == 0 ? 1 : 0, second = axis_ == 2 ? 1 : 2;
    Vec3d middle;  // of a column, so that rounding cannot tear it apart
    places_.reserve(state_.position.size());
    for (std::size_t i = 0; i < state_.position.size(); ++i) {
      if (is_removed(state_.tag[i])) continue;
      const Vec3d& x = state_.position[i];
      if (is_solid(state_.tag[i])) {
        solids_.add(x, static_cast<std::uint32_t>(i));
        continue;
      }
      if (places_.empty()) middle = x;
      places_.push_back({{std::llround((part(x, first) - part(middle, first)) * inverse),
                          std::llround((part(x, second) - part(middle, second)) * inverse)},
                         height(x),
                         static_cast<std::uint32_t>(i)});
    }
    if (!sort_by_counting()) std::sort(places_.begin(), places_.end());
  }
  /// The same order, by counting the places of each column: particles mostly come from a lattice, in which those of a column are
  /// in order already. False: there would be many more columns than places.
  bool sort_by_counting() {
    if (places_.empty()) return true;
    std::int64_t low[2], size[2];
    for (int k = 0; k < 2; ++k) {
      const auto [least, most] =
          std::minmax_element(places_.begin(), places_.end(),
                              [k](const Place& a, const Place& b) { return a.column[k] < b.column[k]; });
      low[k] = least->column[k];
      size[k] = most->column[k] - low[k] + 1;
    }
    if (double(size[0]) * double(size[1]) > 2.0 * double(places_.size())) return false;
    const auto number = [&](const Place& p) {
      return static_cast<std::size_t>((p.column[0] - low[0]) * size[1] + p.column[1] - low[1]);
    };
    std::vector<std::size_t> ends(static_cast<std::size_t>(size[0] * size[1]), 0);
    for (const Place& p : places_) ++ends[number(p)];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<Place> sorted(places_.size());
    for (std::size_t i = places_.size(); i-- > 0;) sorted[--ends[number(places_[i])]] = places_[i];
    places_.swap(sorted);
    for (std::size_t k = 0; k < ends.size(); ++k) {  // now where columns begin
      const auto first = places_.begin() + static_cast<std::ptrdiff_t>(ends[k]);
      const auto end =
          k + 1 < ends.size() ? places_.begin() + static_cast<std::ptrdiff_t>(ends[k + 1]) : places_.end();
      if (!std::is_sorted(first, end)) std::sort(first, end);
    }
    return true;
  }
  bool same_column(std::size_t a, std::size_t b) const {
    return places_[a].column[0] == places_[b].column[0] && places_[a].column[1] == places_[b].column[1];
  }
  /// Whether a particle of a body is about a spacing above (way 1) or below (way -1) a place.
  bool meets_solid(std::size_t place, int way) const {
    Vec3d x = state_.position[places_[place].id];
    part(x, axis_) += way * up_ * 0.75 * desc_.spacing;
    return solids_.near(x, [](std::uint32_t) { return true; });
  }
  bool is_wall(bool upper) const {
    const std::size_t face = static_cast<std::size_t>(2 * axis_) + ((up_ > 0) == upper ? 1u : 0u);
    return desc_.domain.bounded && desc_.domain.faces[face] == Face::wall;
  }
  void find_runs() {
    const double dx = desc_.spacing;
    for (std::size_t i = 0; i < places_.size();) {
      Run r;
      r.first = i++;
      while (i < places_.size() && same_column(i, r.first) &&
             places_[i].height - places_[i - 1].height < 1.5 * dx)
        ++i;
      r.end = i;
      r.stands = (is_wall(false) && places_[r.first].height - low_ < dx) || meets_solid(r.first, -1);
      r.open = !(is_wall(true) && high_ - places_[r.end - 1].height < dx) && !meets_solid(r.end - 1, 1);
      runs_.push_back(r);
    }
  }
  double top(const Run& r) const { return places_[r.end - 1].height + 0.5 * desc_.spacing; }
  double bottom(const Run& r) const { return places_[r.first].height - 0.5 * desc_.spacing; }

  /// Calls visit(run) for those in the columns beside that it touches.
  template <class Visit>
  void for_each_beside(const Run& r, const Visit& visit) {
    constexpr int ways[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (const auto& way : ways) {
      const Place& from = places_[r.first];
      const Place wanted{{from.column[0] + way[0], from.column[1] + way[1]}, -infinity, 0};
      auto run = std::lower_bound(runs_.begin(), runs_.end(), wanted,
                                  [&](const Run& a, const Place& p) { return places_[a.first] < p; });
      for (; run != runs_.end() && places_[run->first].column[0] == wanted.column[0] &&
             places_[run->first].column[1] == wanted.column[1];
           ++run)
        if (std::min(top(*run), top(r)) - std::max(bottom(*run), bottom(r)) > 0.5 * desc_.spacing)
          visit(*run);
    }
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
  double on_top(const Run& r, const Weight& weight) const {
    if (r.level > -infinity) return std::max(r.level - top(r), 0.0) / desc_.spacing * weight(r.end - 1);
    double all = 0;
    for (std::size_t i = r.first; i < r.end && desc_.tension; ++i) all += weight(i);
    return -0.5 * all;
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
  template <class Move>
  void press(const Run& r, const Move& move) {
    const double dx = layer(r), square = desc_.spacing * desc_.spacing;
    const auto mass = [&](std::size_t place) { return state_.mass[places_[place].id]; };
    const auto volume = [&](std::size_t place) { return state_.volume[places_[place].id]; };
    const auto weight = [&](std::size_t place) {
      return pull(places_[place].id) * mass(place) / unless_alike(volume(place) / dx, square);
    };
    constexpr double most_fraction = 1.1;  // beyond, layers are no lattice any more: left as it was laid out
    std::vector<double> weights, stiffness;
    for (std::size_t i = r.first; i < r.end; ++i) {
      weights.push_back(weight(i));
      stiffness.push_back(physics::tait_stiffness(mass(i) / volume(i), sound_speed_));
    }
    Pressed pressed{on_top(r, weight), std::move(weights), std::move(stiffness), {}};
    if (!pressed.alike(last_)) {
      pressed.phi = physics::hydrostatic_fractions(pressed.on_top, pressed.weights, pressed.stiffness);
      last_ = std::move(pressed);
    }
    const std::vector<double>& phi = last_.phi;
    for (const double fraction : phi)
      if (!(fraction <= most_fraction && fraction >= 1 / most_fraction)) return;
    const std::vector<double> heights = physics::stacked(phi, bottom(r), dx), risen = rise(r);
    for (std::size_t i = 0; i < heights.size(); ++i)
      move(places_[r.first + i].id, up_ * (heights[i] + risen[i]));
  }
  /// What its free surface does to the layers of a run [m]; where it has none, or where fields act, nothing.
  std::vector<double> rise(const Run& r) {
    std::vector<double> risen(r.end - r.first, 0.0);
    if (!r.open || desc_.tension || !fields_.empty()) return risen;
    const bool on_floor = is_wall(false) && places_[r.first].height - low_ < desc_.spacing;
    const std::size_t layers = std::min(risen.size(), surface_.wanted());
    std::vector<double> density;
    for (std::size_t i = r.end - layers; i < r.end; ++i)
      density.push_back(state_.mass[places_[i].id] / state_.volume[places_[i].id]);
    const bool all = on_floor && layers == risen.size();
    // A body answers liquid with the liquid's own pressure, as if it went on there.
    if (!all) density.insert(density.begin(), surface_.wanted() - layers, density.front());
    const std::vector<double> top = surface_.rise(density, all);
    const std::size_t below = density.size() - layers;
    for (std::size_t i = 0; i < layers; ++i)
      risen[risen.size() - layers + i] = desc_.spacing * top[below + i];
    return risen;
  }

  const core::SceneState& state_;
  const WorldDesc& desc_;
  std::vector<physics::ForceField<double>> fields_;
  int axis_, up_ = 1;          ///< up_: sign of what is against gravity
  double sound_speed_;         ///< [m/s]
  double low_ = 0, high_ = 0;  ///< of the domain, against gravity [m]
  core::PointGrid solids_{0.75 * desc_.spacing};
  std::vector<Place> places_;
  std::vector<Run> runs_;
  SurfaceLayers surface_;
  Pressed last_;  ///< of the run pressed last: most are like the one before
};

}  // namespace

/// Liquid where it was laid out, before it was compressed.
void WorldImpl::lay_out() {
  if (laid_out_.empty()) return;
  if (steps == 0) {
    for (const auto& [id, x] : laid_out_) state_.position[id] = x;
    pressed_ = false;
    dirty_ = true;
    places_.reset();
  }
  laid_out_ = {};
}

/// Ahead of what reads or moves particles: what is read before the first step is what the step begins with.
void WorldImpl::start_at_rest() {
  if (desc.hydrostatic_start && steps == 0 && dirty_)
    static_cast<void>(prepare());  // a failure shows at the step
}

/// Compresses liquid as its weight does. Before the first step, at the speed of sound of the scene.
void WorldImpl::press_liquid() {
  if (!desc.hydrostatic_start || steps != 0 || pressed_ || !(length(desc.gravity) > 0)) return;
  std::vector<physics::ForceField<double>> fields;
  for (const ForceFieldRecord& r : force_fields_)
    if (r.used && r.desc.liquid && time >= r.desc.from && time < r.desc.until) fields.push_back(field_row(r));
  Columns columns(state_, desc, origin_, sound_speed_, std::move(fields));
  laid_out_.reserve(state_.position.size());
  columns.press([&](std::uint32_t id, double at) {
    laid_out_.push_back({id, state_.position[id]});
    round_to_precision(at);
    part(state_.position[id], columns.axis()) = at;
  });
  pressed_ = !laid_out_.empty();
  if (pressed_) places_.reset();
}

}  // namespace v0
}  // namespace meltsim
