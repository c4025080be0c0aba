// SPDX-License-Identifier: Apache-2.0
// Adding a body: its lattice, the sites that it may grow into, and obstacles.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "description/growth_sites.hpp"
#include "description/names.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "frame/lattice.hpp"
#include "meltsim/physics/contact.hpp"
#include "meltsim/physics/heat.hpp"
#include "shape/shape_depth.hpp"
#include "shape/shape_limits.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;
using core::none;
using core::same_place;

namespace {

/// Sites of the box that a body may grow in: at some 400 bytes each, 50 GB.
constexpr double most_growth_sites = 134217728.0;

constexpr double most_speed = 1e15;  ///< as of every velocity [m/s]

/// Row `index` of a table, or one more.
template <class Table, class Row>
void put_row(Table& table, std::size_t index, Row&& row) {
  if (index < table.size()) table[index] = std::forward<Row>(row);
  else table.push_back(std::forward<Row>(row));
}

/// Room for one more, so that what comes later cannot fail.
template <class Vector>
void reserve_one_more(Vector& v, std::size_t size) {
  if (v.capacity() == size) v.reserve(2 * size + 1);
}

/// Which sites of a box hold a point of a body, and two around it.
class Presence {
 public:
  Presence(const std::vector<Vec3i>& points, const core::SiteBox& box)
      : low_{static_cast<std::int32_t>(box.low[0]), static_cast<std::int32_t>(box.low[1]),
             static_cast<std::int32_t>(box.low[2])},
        stride_y_(box.extent(0) + 2 * reach),
        stride_z_(stride_y_ * (box.extent(1) + 2 * reach)),
        there_(static_cast<std::size_t>(stride_z_ * (box.extent(2) + 2 * reach)), 0) {
    for (const Vec3i& p : points) there_[at(p)] = 1;
  }
  /// How many of the direct neighbours of a point are there, itself among them.
  unsigned direct(Vec3i p) const {
    unsigned n = 0;
    core::each_direct([&](int x, int y, int z) { n += there_[at({p.x + x, p.y + y, p.z + z})]; });
    return n;
  }
  bool surface(Vec3i p) const { return direct(p) < core::full_neighbours; }
  /// Away from the points within some sites of one, two at most: a unit vector, or 0.
  Vec3d outward(Vec3i p, int within) const {
    Vec3d out{};
    for (int z = -within; z <= within; ++z)
      for (int y = -within; y <= within; ++y)
        for (int x = -within; x <= within; ++x)
          if (there_[at({p.x + x, p.y + y, p.z + z})] != 0) out += Vec3d{double(-x), double(-y), double(-z)};
    const double size = length(out);
    return size > 0 ? out * (1 / size) : Vec3d{};
  }

 private:
  static constexpr int reach = 2;
  std::size_t at(Vec3i p) const {
    return static_cast<std::size_t>((p.x - low_.x + reach) + (p.y - low_.y + reach) * stride_y_ +
                                    (p.z - low_.z + reach) * stride_z_);
  }
  Vec3i low_;
  std::int64_t stride_y_, stride_z_;
  std::vector<std::uint8_t> there_;
};

/// Sums of a fit of a shift u to d = u.n.
class FaceSums {
 public:
  void add(Vec3d n, double d, double weight) {
    nn_[0] += n * (n.x * weight);
    nn_[1] += n * (n.y * weight);
    nn_[2] += n * (n.z * weight);
    dn_ += n * (d * weight);
  }
  void add(const FaceSums& o) {
    for (std::size_t i = 0; i < 3; ++i) nn_[i] += o.nn_[i];
    dn_ += o.dn_;
  }
  /// By Cramer's rule; empty where the n do not span space.
  std::optional<Vec3d> shift() const {
    const Vec3d &a = nn_[0], &b = nn_[1], &c = nn_[2];
    const double volume = dot(a, cross(b, c)), size = a.x + b.y + c.z;
    if (!(volume > 1e-6 * size * size * size)) return {};
    return Vec3d{dot(dn_, cross(b, c)), dot(a, cross(dn_, c)), dot(a, cross(b, dn_))} * (1 / volume);
  }

 private:
  std::array<Vec3d, 3> nn_{};  ///< rows of the sum of n n^T
  Vec3d dn_;
};

Error damaged(const std::string& what, const char* why) {
  return Error{ErrorCode::corrupt_data,
               core::text(what, why, "; the World is unchanged, use another saved World")};
}

/// `fixed` and `motion` say the same from here on.
Status settle_motion(SolidDesc& s, const std::string& what) {
  if (Status st = core::known(what + "motion", s.motion, Motion::proxy, "Motion", "free is the default"); !st)
    return st;
  const bool proxy = s.motion == Motion::proxy;
  if (s.fixed && (s.motion == Motion::kinematic || s.motion == Motion::rigid || proxy))
    return invalid(what, "fixed: a ",
                   proxy                       ? "proxy"
                   : s.motion == Motion::rigid ? "rigid body"
                                               : "kinematic body",
                   " moves; drop fixed, or use motion fixed");
  if (s.fixed) s.motion = Motion::fixed;
  s.fixed = s.motion == Motion::fixed || s.motion == Motion::kinematic;
  return {};
}

}  // namespace

/// A body that is being added. Everything is computed and checked before the World is changed.
class WorldImpl::NewBody {
 public:
  NewBody(WorldImpl& world, const SolidDesc& given) : NewBody(world, given, world.free_row()) {}
  NewBody(WorldImpl& world, const SolidDesc& given, std::uint32_t row)
      : w_(world),
        index_(row),
        s_(given),
        name_(s_.name.empty() ? core::numbered_name(
                                    "body", w_.bodies_.size(),
                                    [&](const std::string& name) { return w_.body_names_.count(name) != 0; })
                              : s_.name),
        what_("body \"" + name_ + "\": ") {}

  Status check();  ///< the description, as far as it needs no place
  Status place();  ///< its sites, and where it may grow
  Status clear();  ///< obstacles: bodies, liquid, nozzles
  Status weigh();  ///< density, enthalpy, speeds
  void reserve();  ///< all memory; from here on nothing fails
  BodyId join();   ///< it becomes part of the World
  /// The same while the World runs, without an upload. Empty where it takes one.
  std::optional<Result<BodyId>> join_in_place();
  /// It comes back as it was saved, into rows that are there for it; its particles come with the state.
  Status come_back(const StoredBody& stored);

 private:
  Status check_path(double now) const;
  Status check_motion() const;
  Status check_material() const;
  Status check_velocity() const;
  Status take_sites(const StoredBody& stored);
  bool is_box_of_its_sites(const StoredBody& stored) const;
  Status come_back_to_lattice(const StoredBody& stored);
  void center();
  Status place_growth();
  Status number_sites();
  void find_surface();
  std::optional<Vec3d> centering_shift(const Presence& there, const ShapeDepth& depth) const;
  float radius_at(const ShapeDepth& depth, Vec3d x, Vec3d outward) const;
  Vec4<float> normal_at(const ShapeDepth& depth, const Presence& there, Vec3i point, Vec3d x,
                        float radius) const;
  template <class TagOf>
  Status find_displaced(const core::PointGrid& there, const TagOf& tag_of);
  bool displaces_liquid_only();
  Status check_carve(Vec3d place) const;
  bool fits_in_place() const;
  Status clear_found();
  core::SceneState enter_tables();
  Status enter_backend(const std::vector<core::FoundParticle>& taken, const core::SceneState& particles,
                       bool level);
  bool keeps_regions();
  void count();
  Status check_nozzles() const;
  Vec3d mean_position() const;
  Vec3d center_in_lattice() const;
  double fastest_particle() const;
  void make_record();
  void make_row();
  void add_vertices(core::SceneState& particles, std::size_t first_id);
  void add_vertex(core::SceneState& particles, std::size_t i, std::size_t id, std::size_t k);
  std::uint32_t put_on_lattice(std::size_t id, std::size_t k);
  std::uint32_t tag_at(std::uint32_t site) const;
  void label_pieces();
  void label_piece(std::uint32_t first);
  void add_free_sites();
  core::BodyMotionRow rest_row() const;
  void bound_rest();
  physics::RigidMotion first_motion() const;

  bool kinematic() const { return s_.motion == Motion::kinematic; }
  bool proxy() const { return s_.motion == Motion::proxy; }
  bool rigid() const { return s_.motion == Motion::rigid || proxy(); }
  /// Whether nothing freezes onto its sites, which are a spacing apart whatever its cells are.
  bool keeps_its_sites() const {
    return !material().freezes && material().solubility_points.empty() && s_.growth == 0;
  }
  const MaterialDesc& material() const { return w_.materials[s_.material.index]; }
  double density_of(std::uint64_t particles) const {
    const double dx = w_.desc.spacing;
    return proxy() ? s_.mass / (double(particles) * dx * dx * dx) : material().density;
  }
  std::uint64_t site_of(Vec3i p) const {
    return base_ + std::uint64_t(p.x - box_.low[0] + pad_) + std::uint64_t(p.y - box_.low[1] + pad_) * nx_ +
           std::uint64_t(p.z - box_.low[2] + pad_) * nx_ * ny_;
  }
  std::uint32_t vertex_beside(std::uint32_t site, int dx, int dy, int dz) const {
    return w_.lattice_.site_vertex[core::site_beside(site, row_, dx, dy, dz)];
  }

  WorldImpl& w_;
  std::uint32_t index_;  ///< row of the body that it becomes
  SolidDesc s_;
  std::string name_, what_;  ///< what: the head of its errors
  bool held_ = false;
  std::vector<Vec3i> points_;
  std::vector<Vec3d> positions_;      ///< of the points [m]
  std::vector<Vec4<float>> surface_;  ///< how it lies at the points (SceneLattice::contact_shape)
  Vec3d cell_ = w_.cube();            ///< around each of them [m]
  Vec3d origin_;                      ///< the World's, with this body
  std::vector<Vec3i> free_;           ///< sites that it may grow into
  core::SiteBox box_;                 ///< of its sites and of those
  int pad_ = 0;  ///< sites around that box, so that the look-up of a region never leaves it
  std::uint64_t nx_ = 0, ny_ = 0, nz_ = 0, base_ = 0;  ///< its box in the table of sites
  std::vector<std::uint32_t> displaced_;               ///< liquid in its place
  Vec3d center_;                                       ///< or the pivot, from the World's origin [m]
  double density_ = 0, enthalpy_ = 0;
  Contents contents_{};
  BodyRecord record_;
  core::BodyRow row_;
  std::vector<std::uint32_t> stack_;  ///< of the flood fill
};

Status WorldImpl::NewBody::check() {
  if (Status st = settle_motion(s_, what_); !st) return st;
  if (!(s_.held_until >= 0))
    return invalid(what_, "held_until: must be >= 0 s, got ", s_.held_until,
                   "; 0 lets it go from the start, infinity holds it until World::hold(body, false)");
  held_ = s_.held_until > w_.time;
  if (Status st = check_motion(); !st) return st;
  if (w_.body_names_.count(name_) != 0)
    return invalid(what_, "a body of this name exists; choose another name");
  if (index_ >= 65535)
    return Error{ErrorCode::capacity,
                 what_ + "a World holds at most 65535 bodies; remove() some and have compact() forget them"};
  if (Status st = check_material(); !st) return st;
  if (!finite(s_.angular_velocity))
    return invalid(what_, "angular_velocity: must be finite, got ", s_.angular_velocity);
  if (Status st = core::validate(s_.surface, w_.desc.heat.model, what_ + "surface."); !st) return st;
  if (Status st = w_.check_proxy(s_, what_); !st) return st;
  return check_velocity();
}

Status WorldImpl::NewBody::check_motion() const {
  if (s_.held_until > 0 && (s_.fixed || proxy()))
    return invalid(what_, "held_until: only a free or rigid body can be let go; set motion to one of these");
  if (!kinematic() && !proxy() && s_.pivot)
    return invalid(what_, "pivot: only of kinematic bodies and proxies; set motion to kinematic or proxy");
  if (Status st = check_path(w_.time); !st) return st;
  if (s_.motion == Motion::fixed && s_.max_speed != 0)
    return invalid(what_, "max_speed: a fixed body does not move; leave it out, or let the body move");
  if (!(std::isfinite(s_.max_speed) && s_.max_speed >= 0))
    return invalid(what_, "max_speed: must be finite and >= 0 m/s, got ", s_.max_speed);
  if (s_.max_speed > most_speed)
    return invalid(what_, "max_speed: must be at most ", most_speed, " m/s, got ", s_.max_speed,
                   "; check the computation that made it");
  // Rounding of a place that is reckoned from the pivot then stays below a millionth of a spacing.
  const double farthest = 1e9 * w_.desc.spacing;
  if (s_.pivot && !(length(*s_.pivot - w_.desc.domain.min) <= farthest))  // NaN, too
    return invalid(what_, "pivot: must be within a thousand million spacings (", farthest,
                   " m) of domain.min, got ", *s_.pivot,
                   "; for a straight path give a velocity and leave the pivot out");
  return {};
}

Status WorldImpl::NewBody::check_path(double now) const {
  constexpr std::size_t most = 1u << 20;
  const std::vector<PosePoint>& path = s_.path;
  if (path.empty()) return {};
  if (!kinematic()) return invalid(what_, "path: only of kinematic bodies; set motion to kinematic");
  if (length(s_.velocity) != 0 || length(s_.angular_velocity) != 0)
    return invalid(what_,
                   "path: says how fast the body moves, and so do velocity and angular_velocity; drop these");
  if (path.size() > most)
    return invalid(what_, "path: at most ", most, " points, got ", path.size(),
                   "; move it with set_motion instead");
  if (!finite(s_.path_axis) || !(length(s_.path_axis) > 0))
    return invalid(what_, "path_axis: must be finite and not 0, got ", s_.path_axis);
  if (length(path[0].displacement) != 0 || path[0].angle != 0)
    return invalid(what_, "path: begins ", path[0].displacement,
                   " m from where the body is built, turned by ", path[0].angle,
                   " rad; build it where the path begins, and let that point be 0 m and 0 rad");
  if (path[0].time < now)
    return invalid(what_, "path: begins at ", path[0].time, " s, and it is ", now,
                   " s; let it begin now or later");
  for (std::size_t k = 0; k < path.size(); ++k) {
    const PosePoint& point = path[k];
    if (!std::isfinite(point.time) || !finite(point.displacement) || !std::isfinite(point.angle))
      return invalid(what_, "path: point ", k, ", ", point.displacement, " m and ", point.angle, " rad at ",
                     point.time, " s, must be finite");
    if (k > 0 && !(point.time > path[k - 1].time))
      return invalid(what_, "path: point ", k, " is at ", point.time, " s, not after the one before it, at ",
                     path[k - 1].time, " s; times must ascend");
  }
  return {};
}

Status WorldImpl::NewBody::check_material() const {
  if (!w_.valid(s_.material))
    return invalid(what_, "material: no such material in this World; pass an id from add_material");
  const MaterialDesc& m = material();
  if (Status st = core::validate_state(what_.c_str(), s_.temperature, s_.velocity); !st) return st;
  if (m.dissolves_in && !(largest_solubility(m) < 1))
    return invalid(what_, "material: \"", m.name, "\" mixes with \"", w_.materials[m.dissolves_in.index].name,
                   "\" in any ratio (solubility 1), so that nothing holds a body of it together; fill with "
                   "fluid, or set "
                   "solubility below 1");
  return {};
}

Status WorldImpl::NewBody::check_velocity() const {
  const int wide = material().region_half_width, most = w_.most_half_width();
  if (s_.motion == Motion::free && wide > most)
    return invalid(what_, "material: \"", material().name, "\" has a region_half_width of ", wide,
                   ", and its regions would reach across half of a periodic axis; use at most ", most,
                   " here, or a longer domain");
  if (!std::isfinite(s_.heat_source) || (s_.heat_source != 0 && w_.desc.heat.model != HeatModel::enthalpy))
    return invalid(what_, "heat_source: must be finite W/m^3 and needs heat.model enthalpy, got ",
                   s_.heat_source, "; 0 is none");
  if (Status st = core::summable(what_ + "heat_source", s_.heat_source, "W/m^3"); !st) return st;
  if (s_.motion == Motion::fixed &&
      (dot(s_.velocity, s_.velocity) > 0 || dot(s_.angular_velocity, s_.angular_velocity) > 0))
    return invalid(what_, "velocity: a fixed body cannot move, got ", s_.velocity,
                   "; drop fixed or the velocity");
  return {};
}

Status WorldImpl::NewBody::place() {
  if (s_.motion == Motion::fixed && keeps_its_sites()) cell_ = w_.cell_of(s_.shape.bounds());
  if (Status st = w_.place(s_.shape, what_.c_str(), s_.fixed, cell_, points_, positions_, origin_); !st)
    return st;
  if (Status st = place_growth(); !st) return st;
  if (Status st = number_sites(); !st) return st;
  find_surface();
  return {};
}

/// How far inside the shape the points at its surface are (physics/contact.hpp), once the shape lies evenly around them; half a spacing where no
/// other point is missing around one, and where there is no way to tell how the shape lies.
void WorldImpl::NewBody::find_surface() {
  surface_.assign(points_.size(), {0, 0, 0, static_cast<float>(physics::largest_contact_radius)});
  const Presence there(points_, box_);
  const ShapeDepth depth(s_.shape);
  const std::optional<Vec3d> shift = centering_shift(there, depth);
  if (!shift) return;
  w_.loops().pieces(points_.size(), [&](std::size_t k, std::size_t end) {
    for (; k < end; ++k) {
      if (!there.surface(points_[k])) continue;
      const Vec3d x = positions_[k] + *shift;
      const Vec3d outward = there.outward(points_[k], 2);
      const double deepest =
          0.75 * w_.desc.spacing;  // what is deeper than that touches nothing, as bodies lie on each other
      surface_[k].w = radius_at(depth, x, outward);
      if (depth.at(x, outward, deepest) < deepest)
        surface_[k] = normal_at(depth, there, points_[k], x, surface_[k].w);
    }
  });
}

/// SceneLattice::contact_shape of a radius: the normal of the face that a point lies beneath, or the way out at an edge. 0 where the lattice says the
/// same: faces along it.
Vec4<float> WorldImpl::NewBody::normal_at(const ShapeDepth& depth, const Presence& there, Vec3i point,
                                          Vec3d x, float radius) const {
  const Vec3d outward = there.outward(point, 2), of_lattice = there.outward(point, 1);
  const std::optional<ShapeFace> face = depth.face(x, outward, 1.5 * w_.desc.spacing);
  const Vec3d n = face ? face->normal : outward;
  const double live = there.direct(point);
  if (length(n - of_lattice) < 0.01 && physics::flatness(live) == (face ? 1 : 0))
    return with_w(Vec3<float>{}, radius);
  return with_w(cast<float>(n * (face && face->curved ? live + physics::curved_mark : live)),
                face ? radius : -radius);
}

/// The shift u of the points after which those at opposite faces are equally deep in the shape: a box is as high as its layers, wherever
/// these lie in it. Of depths d and ways out n, where the surface is a face, the least squares of d - u.n - half a spacing. Empty where
/// faces do not look along all axes: a body one or two spacings thick, a rod.
std::optional<Vec3d> WorldImpl::NewBody::centering_shift(const Presence& there,
                                                         const ShapeDepth& depth) const {
  const double dx = w_.desc.spacing;
  const auto of = [&](std::size_t k, std::size_t end) {
    FaceSums s;
    for (; k < end; ++k) {
      const unsigned live = there.direct(points_[k]);
      const double flat = live < core::full_neighbours ? physics::flatness(static_cast<double>(live)) : 0;
      if (!(flat > 0)) continue;
      const Vec3d n = there.outward(points_[k], 1);  // that of a face, also beside an edge
      s.add(n, depth.at(positions_[k], n, dx) - physics::largest_contact_radius * dx, flat);
    }
    return s;
  };
  FaceSums sum;
  for (const FaceSums& s : w_.loops().of_pieces<FaceSums>(points_.size(), of)) sum.add(s);
  const std::optional<Vec3d> u = sum.shift();
  if (!u || length(*u) > 0.02 * dx) return u;
  return Vec3d{};  // depths are found to a hundredth
}

/// In spacings. To a hundredth, as depths are found: the faces of a box lie half a spacing from its particles.
float WorldImpl::NewBody::radius_at(const ShapeDepth& depth, Vec3d x, Vec3d outward) const {
  constexpr double most = physics::largest_contact_radius;
  const double dx = w_.desc.spacing, share = depth.at(x, outward, most * dx) / dx;
  return static_cast<float>(share < 0.97 * most ? std::max(share, physics::least_contact_radius) : most);
}

/// The free sites a body may grow into, and the box of all of its sites. Occupied neighbours are not left
/// out: an obstacle there may move or melt, so topology.freeze checks a site when liquid is about to freeze.
Status WorldImpl::NewBody::place_growth() {
  box_ = core::box_of(points_);
  record_.longest = static_cast<int>(std::max({box_.extent(0), box_.extent(1), box_.extent(2)}));
  const MaterialDesc& m = material();
  if (s_.growth < 0)
    return invalid(what_, "growth: must be >= 0 lattice steps, got ", s_.growth,
                   "; 0 lets liquid freeze only where the body was solid before");
  if (s_.growth == 0) return {};
  if (!m.freezes && m.solubility_points.empty())
    return invalid(what_, "growth: ", s_.growth, " steps of \"", m.name,
                   "\", which does not freeze; set `freezes` on the material, or its solubility_points if it "
                   "is a species, or growth to 0");
  const DomainDesc& domain = w_.desc.domain;
  const double low[3] = {domain.min.x, domain.min.y, domain.min.z};
  const double high[3] = {domain.max.x, domain.max.y, domain.max.z};
  const Vec3d o = w_.lattice_origin();
  const double origin[3] = {o.x, o.y, o.z}, dx = w_.desc.spacing;
  for (int a = 0; a < 3; ++a) {
    std::int64_t lo = box_.low[a] - s_.growth, hi = box_.high[a] + s_.growth;
    if (domain.bounded) {  // sites whose centre lies inside
      lo = std::max(lo, static_cast<std::int64_t>(std::ceil((low[a] - origin[a]) / dx - 0.5)));
      hi = std::min(hi, static_cast<std::int64_t>(std::floor((high[a] - origin[a]) / dx - 0.5)));
    }
    box_.low[a] = std::min(lo, box_.low[a]);  // never less than the shape
    box_.high[a] = std::max(hi, box_.high[a]);
  }
  if (box_.sites() > most_growth_sites)
    return invalid(what_, "growth: ", s_.growth, " steps make a box of ", box_.sites(), " sites, more than ",
                   most_growth_sites, "; grow less, or bound the domain");
  free_ = core::growth_sites(points_, s_.growth, box_);
  return {};
}

Status WorldImpl::NewBody::number_sites() {
  // A modulus, and liquid, may widen regions later.
  pad_ = w_.widest_half_width(material());
  nx_ = static_cast<std::uint64_t>(box_.extent(0) + 2 * pad_);
  ny_ = static_cast<std::uint64_t>(box_.extent(1) + 2 * pad_);
  nz_ = static_cast<std::uint64_t>(box_.extent(2) + 2 * pad_);
  base_ = w_.lattice_.site_vertex.size();
  const double sites = double(nx_) * double(ny_) * double(nz_);
  if (double(base_) + sites >= double(none))
    return Error{ErrorCode::capacity,
                 core::text(what_, "shape: its box of ", sites,
                            " lattice sites is more than 32 bits can number together with the ", base_,
                            " of other bodies; use a larger spacing or smaller bodies")};
  return {};
}

Status WorldImpl::NewBody::clear() {
  w_.update_state();
  w_.lay_out();
  const auto tag_of = [this](std::uint32_t id) { return w_.state_.tag[id]; };
  // Hashed are the particles of the body or all others, whichever are fewer.
  constexpr std::size_t large = 64;
  const bool alone = large * positions_.size() > w_.state_.position.size() && displaces_liquid_only();
  if (!alone)
    if (Status st = find_displaced(w_.places(), tag_of); !st) return st;
  if (!displaced_.empty())
    if (Status st = check_carve(w_.state_.position[*std::min_element(displaced_.begin(), displaced_.end())]);
        !st)
      return st;
  return check_nozzles();
}

/// Liquid lies in its place, there.
Status WorldImpl::NewBody::check_carve(Vec3d place) const {
  if (s_.carve) return {};
  return invalid(what_, "carve: liquid occupies its place at ", place + w_.origin_,
                 " and carve is off; move the body or let it carve");
}

/// tag_of: of what the grid numbers.
template <class TagOf>
Status WorldImpl::NewBody::find_displaced(const core::PointGrid& there, const TagOf& tag_of) {
  for (const Vec3d& p : positions_) {
    std::uint32_t other = none;
    const auto look = [&](std::uint32_t id) {
      if (is_fluid(tag_of(id))) displaced_.push_back(id);
      if (is_solid(tag_of(id))) other = id;
      return other != none;
    };
    if (there.near(p - origin_, look))
      return invalid(what_, "shape: overlaps body \"", w_.bodies_[body_of(tag_of(other)) - 1].desc.name,
                     "\" at ", p, "; bodies must be a spacing apart, move one of them");
  }
  return {};
}

/// find_displaced() of all particles of the World, in order. False: another body is in the way.
bool WorldImpl::NewBody::displaces_liquid_only() {
  core::PointGrid own(same_place * w_.desc.spacing);
  for (const Vec3d& p : positions_) own.add(p - origin_, 0);
  struct Met {
    std::vector<std::uint32_t> liquid;
    bool solid = false;
  };
  const core::SceneState& s = w_.state_;
  const auto met = w_.loops().of_pieces<Met>(s.position.size(), [&](std::size_t i, std::size_t end) {
    Met m;
    for (; i < end && !m.solid; ++i) {
      if (is_removed(s.tag[i]) || !own.near(s.position[i], [](std::uint32_t) { return true; })) continue;
      if (is_fluid(s.tag[i])) m.liquid.push_back(static_cast<std::uint32_t>(i));
      m.solid = is_solid(s.tag[i]);
    }
    return m;
  });
  for (const Met& m : met)
    if (m.solid) return false;
  for (const Met& m : met) displaced_.insert(displaced_.end(), m.liquid.begin(), m.liquid.end());
  return true;
}

Status WorldImpl::NewBody::check_nozzles() const {
  if (w_.emitters_.empty()) return {};
  core::PointGrid own(same_place * w_.desc.spacing);
  for (const Vec3d& p : positions_) own.add(p - origin_, 0);
  for (const EmitterRecord& e : w_.emitters_) {
    if (!(w_.time < e.desc.until)) continue;
    for (const Vec3d& p : w_.places_of(e))
      if (own.near(p - origin_, [](std::uint32_t) { return true; }))
        return invalid(what_, "shape: lies on the nozzle of emitter \"", e.desc.name, "\" at ", p,
                       "; move one of them");
  }
  return {};
}

Vec3d WorldImpl::NewBody::mean_position() const {
  Vec3d sum{};
  for (const Vec3d& p : positions_) sum += p - origin_;
  return sum * (1.0 / double(positions_.size()));
}

/// Its pivot or the mean of its points, from the origin of the lattice [m]: to the bit the same wherever the World's origin is, which
/// a World that takes a snapshot may have elsewhere.
Vec3d WorldImpl::NewBody::center_in_lattice() const {
  if (s_.pivot) return *s_.pivot - w_.lattice_origin();
  Vec3d sum{};  // of whole numbers: exact
  for (const Vec3i& p : points_) sum += {double(p.x), double(p.y), double(p.z)};
  return (sum * (1.0 / double(points_.size())) + Vec3d{0.5, 0.5, 0.5}) * w_.desc.spacing;
}

/// Its pivot, or the mean of its points.
void WorldImpl::NewBody::center() { center_ = s_.pivot ? *s_.pivot - origin_ : mean_position(); }

double WorldImpl::NewBody::fastest_particle() const {
  double fastest = length(s_.velocity);
  for (const Vec3d& p : positions_)
    fastest = std::max(fastest, length(s_.velocity + cross(s_.angular_velocity, p - origin_ - center_)));
  if (s_.path.empty()) return fastest;
  double reach = 0;
  for (const Vec3d& p : positions_) reach = std::max(reach, length(p - origin_ - center_));
  for (std::size_t k = 1; k < s_.path.size(); ++k) {
    const PosePoint &a = s_.path[k - 1], &b = s_.path[k];
    fastest =
        std::max(fastest, (length(b.displacement - a.displacement) + std::fabs(b.angle - a.angle) * reach) /
                              (b.time - a.time));
  }
  return fastest;
}

Status WorldImpl::NewBody::weigh() {
  const MaterialDesc& m = material();
  center();
  enthalpy_ = physics::enthalpy_of(w_.material_rows()[s_.material.index], s_.temperature);
  if (proxy())
    if (Status st = w_.make_proxy(what_, points_, positions_, w_.lattice_origin() + center_in_lattice(), s_);
        !st)
      return st;
  density_ = density_of(points_.size());
  const double fastest = fastest_particle();
  if (Status st = w_.check_numbers(what_, m, density_, enthalpy_, {fastest, 0, 0}); !st) return st;
  if (kinematic() || proxy() || held_) s_.max_speed = std::max(s_.max_speed, fastest);
  if (w_.event_watch_)
    if (Status st = check_touching(w_.event_watch_->kinds,
                                   std::max<std::size_t>(w_.bodies_.size(), index_ + 1u), "add_solid");
        !st)
      return st;
  if (m.dissolves_in) contents_[w_.species_of(s_.material.index)] = 1;
  return {};
}

void WorldImpl::NewBody::reserve() {
  const std::size_t bodies = w_.bodies_.size();
  reserve_one_more(w_.state_.motion, bodies);
  reserve_one_more(w_.lattice_.rests, bodies);
  reserve_one_more(w_.motions_, bodies);
  reserve_one_more(w_.meshes_, bodies);
  reserve_one_more(w_.proxies_, bodies);
  reserve_one_more(w_.state_.forces, bodies);
  w_.reserve(points_.size(), points_.size() + free_.size(), nx_ * ny_ * nz_);
  reserve_one_more(w_.lattice_.bodies, bodies);
  reserve_one_more(w_.bodies_, bodies);
  stack_.reserve(points_.size());
  make_record();
  if (w_.holes_.capacity() - w_.holes_.size() < displaced_.size())
    w_.holes_.reserve(2 * w_.holes_.size() + displaced_.size());
  w_.body_names_.insert(name_);
}

void WorldImpl::NewBody::make_record() {
  record_.desc = s_;
  record_.desc.name = name_;
  record_.generation = index_ < w_.bodies_.size() ? next_number() : w_.body_number_;
  record_.since = w_.steps;
  if (index_ < w_.bodies_.size()) {
    const BodyRecord& had = w_.bodies_[index_];
    record_.before =
        had.before + static_cast<std::int64_t>(had.vertices) - static_cast<std::int64_t>(had.taken);
  }
  record_.density = density_;
  record_.watched = proxy();
  record_.box = box_;
  record_.held = held_;
  record_.desc.fixed = s_.fixed || held_;
  record_.first_vertex = static_cast<std::uint32_t>(w_.lattice_.vertex_site.size());
  record_.vertices = static_cast<std::uint32_t>(points_.size());
  record_.vertices_in_lattice = static_cast<std::uint32_t>(points_.size() + free_.size());
  record_.sites = nx_ * ny_ * nz_;
  record_.pivot = center_ + origin_;
  for (const Vec3d& p : positions_) record_.reach = std::max(record_.reach, length(p - origin_ - center_));
  if ((kinematic() || proxy()) && !positions_.empty()) bound_rest();
}

/// The box of the particles about the pivot.
void WorldImpl::NewBody::bound_rest() {
  Vec3d &low = record_.rest_low, &high = record_.rest_high;
  low = high = positions_.front() - origin_ - center_;
  for (const Vec3d& p : positions_) {
    const Vec3d r = p - origin_ - center_;
    low = {std::min(low.x, r.x), std::min(low.y, r.y), std::min(low.z, r.z)};
    high = {std::max(high.x, r.x), std::max(high.y, r.y), std::max(high.z, r.z)};
  }
}

BodyId WorldImpl::NewBody::join() {
  w_.pass_over_particles();
  for (const std::uint32_t id : displaced_)
    if (is_fluid(w_.state_.tag[id])) w_.drop_fluid(id);  // several points may have met it
  make_row();
  add_vertices(w_.state_, w_.state_.position.size());
  count();
  put_row(w_.bodies_, index_, std::move(record_));
  put_row(w_.lattice_.bodies, index_, row_);
  w_.forget_contacts(index_);
  w_.seen_bodies_ = std::min<std::size_t>(w_.seen_bodies_, index_);
  w_.settle_at(origin_);
  return w_.id_of(index_);
}

/// All of it but its particles, its row and its record.
void WorldImpl::NewBody::count() {
  label_pieces();
  add_free_sites();
  put_row(w_.lattice_.rests, index_, rest_row());
  put_row(w_.state_.motion, index_, first_motion());
  put_row(w_.motions_, index_, std::optional<BodyMotion>{});
  put_row(w_.meshes_, index_, PendingMesh{});
  put_row(w_.proxies_, index_, std::optional<ProxyState>{});
  w_.state_.forces.resize(std::max<std::size_t>(w_.state_.forces.size(), index_));
  put_row(w_.state_.forces, index_, core::BodyForceTotals{});
  w_.solids_built_ += points_.size();
  w_.lattice_.max_half_width = std::max(w_.lattice_.max_half_width, row_.region_half_width);
}

bool WorldImpl::NewBody::fits_in_place() const {
  const std::uint64_t total = w_.born_ + points_.size() + w_.planned_emission();
  return w_.edits_in_place() && total <= w_.capacity_ && w_.same_search(total) &&
         w_.fits_lattice_room(points_.size() + free_.size(), nx_ * ny_ * nz_, 1);
}

/// Whether all regions stay as wide as they are, with the body, whose regions become as wide as they are to be. Its record and row are
/// then the World's.
bool WorldImpl::NewBody::keeps_regions() {
  WorldImpl& w = w_;
  const std::vector<std::uint8_t> solid = w.solid_used_;
  const bool again = index_ < w.bodies_.size();  // the row of one that is forgotten
  const BodyRecord had = again ? w.bodies_[index_] : BodyRecord{};
  const core::BodyRow had_row = again ? w.lattice_.bodies[index_] : core::BodyRow{};
  make_row();
  put_row(w.bodies_, index_, record_);
  put_row(w.lattice_.bodies, index_, row_);
  if (again)  // nothing may be of its material any more
    w.solid_used_[had.desc.material.index] =
        std::any_of(w.bodies_.begin(), w.bodies_.end(),
                    [&had](const BodyRecord& b) { return b.desc.material.index == had.desc.material.index; })
            ? 1
            : 0;
  w.solid_used_[s_.material.index] = 1;
  w.weigh_materials();
  w.derive_limits();
  core::BodyRow& row = w.lattice_.bodies[index_];
  if (record_.may_deform()) w.fit_regions_of(record_, row);
  row_ = row;
  const bool lattices = (w.facts_ & core::fact_solid) != 0;  // on the backend, with masks of one width
  if (w.regions_fit() && (!lattices || row.region_half_width <= w.lattice_.max_half_width)) return true;
  w.bodies_[index_] = had;
  w.lattice_.bodies[index_] = had_row;
  if (!again) {
    w.bodies_.pop_back();
    w.lattice_.bodies.pop_back();
  }
  w.solid_used_ = solid;
  w.weigh_materials();
  w.derive_limits();
  return false;
}

/// clear() and weigh() with the liquid of found_.
Status WorldImpl::NewBody::clear_found() {
  const std::vector<core::FoundParticle>& found = w_.found_;
  core::PointGrid there(same_place * w_.desc.spacing);
  for (std::size_t k = 0; k < found.size(); ++k) there.add(found[k].position, static_cast<std::uint32_t>(k));
  const auto tag_of = [&found](std::uint32_t k) { return found[k].tag; };
  if (Status st = find_displaced(there, tag_of); !st) return st;
  std::sort(displaced_.begin(), displaced_.end());
  displaced_.erase(std::unique(displaced_.begin(), displaced_.end()), displaced_.end());
  if (!displaced_.empty())
    if (Status st = check_carve(found[displaced_.front()].position); !st) return st;
  if (Status st = check_nozzles(); !st) return st;
  return weigh();
}

/// Its rows in the tables of the World.
core::SceneState WorldImpl::NewBody::enter_tables() {
  core::SceneState particles;
  w_.state_.vertex_of_id.resize(w_.born_, none);
  add_vertices(particles, w_.born_);
  w_.state_.vertex_of_id.insert(w_.state_.vertex_of_id.end(), particles.vertex_of_id.begin(),
                                particles.vertex_of_id.end());
  count();
  if (record_.watched) w_.state_.forces[index_].center = particles.position.front();
  return particles;
}

/// Itself instead of the liquid that it takes the place of, on the backend.
Status WorldImpl::NewBody::enter_backend(const std::vector<core::FoundParticle>& taken,
                                         const core::SceneState& particles, bool level) {
  core::AddedBody added;
  added.body = index_;
  added.first_vertex = record_.first_vertex;
  added.first_site = base_;
  added.largest_mass = w_.largest_mass();
  added.heat = {core::condition_at(s_.surface, w_.time), s_.heat_source};
  if (!taken.empty())
    if (Status st = w_.engine->take_out(taken); !st) return st;
  if (Status st = w_.engine->append(particles, level, record_.first_vertex); !st) return st;
  return w_.engine->add_body(w_.lattice_, w_.state_, added);
}

std::optional<Result<BodyId>> WorldImpl::NewBody::join_in_place() {
  if (!fits_in_place()) return std::nullopt;
  core::WorldStatus status;
  const auto runs = w_.find_around(positions_, origin_, status);
  if (!runs) return Result<BodyId>(runs.error());
  if (!*runs) return std::nullopt;
  if (Status st = clear_found(); !st) return Result<BodyId>(st.error());
  std::optional<LevelRange> range;
  const physics::MaterialRow<double> material_row = w_.material_rows()[s_.material.index];
  if (!w_.holds_contents(contents_) ||
      !w_.stays_level(physics::temperature_of(material_row, enthalpy_), status.heat_idle, range)) {
    displaced_.clear();
    return std::nullopt;
  }
  std::vector<core::FoundParticle> taken;
  for (const std::uint32_t k : displaced_) taken.push_back(w_.found_[k]);
  if (Status st = w_.engine->make_edit_room(taken.size(), points_.size()); !st)
    return Result<BodyId>(st.error());
  reserve();
  const auto derived = w_.derived();
  const std::vector<std::uint8_t> liquid = w_.liquid_used_, solid = w_.solid_used_;
  if (!keeps_regions()) {
    w_.body_names_.erase(name_);
    displaced_.clear();
    return std::nullopt;
  }
  const bool had_lattice = (w_.facts_ & core::fact_solid) != 0;
  const Change change(w_);
  const core::SceneState particles = enter_tables();
  // From here on there is nothing that could fail but the device, and memory (Change).
  if (Status st = enter_backend(taken, particles, range.has_value()); !st) return Result<BodyId>(st.error());
  w_.level_ = range;
  w_.state_.heat_level = range.has_value();
  w_.body_joined(index_, particles, taken.size(), status, material_row);
  w_.edited_in_place(derived);
  w_.plan_changed_ = w_.plan_changed_ || liquid != w_.liquid_used_ || solid != w_.solid_used_ ||
                     material().youngs_modulus > 0;  // tables
  if (!had_lattice) static_cast<void>(w_.adapt());   // the step finds what is amiss
  return Result<BodyId>(w_.id_of(index_));
}

void WorldImpl::NewBody::make_row() {
  row_.stride_y = static_cast<std::uint32_t>(nx_);
  row_.stride_z = static_cast<std::uint32_t>(nx_ * ny_);
  row_.first_site = static_cast<std::uint32_t>(base_);
  row_.region_half_width = rigid() ? 0 : std::min(material().region_half_width, w_.most_half_width());
  row_.motion = motion_of(record_, held_);
  row_.watched = proxy() ? 1u : 0u;
  row_.pad = static_cast<std::uint32_t>(pad_);
  const Vec3d size = w_.desc.domain.max - w_.desc.domain.min;
  const double cells[3] = {size.x / cell_.x, size.y / cell_.y, size.z / cell_.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t sites = box_.extent(static_cast<int>(axis));
    if (core::is_periodic(w_.desc.domain, axis) && sites == std::llround(cells[axis]))
      row_.around[axis] = static_cast<std::uint32_t>(sites);
  }
}

/// Its particles get the ids from `first_id` on.
void WorldImpl::NewBody::add_vertices(core::SceneState& particles, std::size_t first_id) {
  core::SceneLattice& lattice = w_.lattice_;
  lattice.site_vertex.resize(base_ + nx_ * ny_ * nz_, none);
  const std::size_t first = particles.position.size();
  w_.extend(particles, points_.size());
  w_.extend_vertices(points_.size());
  const core::HostLoops shared = w_.loops();
  shared.pieces(points_.size(), [&](std::size_t k, std::size_t end) {
    for (; k < end; ++k)
      lattice.site_vertex[site_of(points_[k])] = record_.first_vertex + static_cast<std::uint32_t>(k);
  });
  shared.pieces(points_.size(), [&](std::size_t k, std::size_t end) {
    for (; k < end; ++k) add_vertex(particles, first + k, first_id + k, k);
  });
}

/// Point k: particle `id`, item i of `particles`.
void WorldImpl::NewBody::add_vertex(core::SceneState& particles, std::size_t i, std::size_t id,
                                    std::size_t k) {
  const std::uint32_t vertex = put_on_lattice(id, k), site = w_.lattice_.vertex_site[vertex];
  const Vec3d x = positions_[k] - origin_;
  w_.put(particles, i, x, held_ ? Vec3d{} : s_.velocity + cross(s_.angular_velocity, x - center_), density_,
         enthalpy_, tag_at(site), vertex, contents_,
         s_.motion == Motion::fixed ? w_.cut_at_walls(positions_[k], cell_) : cell_);
}

/// The vertex of point k, whose particle is `id`.
std::uint32_t WorldImpl::NewBody::put_on_lattice(std::size_t id, std::size_t k) {
  const auto vertex = record_.first_vertex + static_cast<std::uint32_t>(k);
  w_.put_vertex(vertex, static_cast<std::uint32_t>(id), core::vertex_live, none);
  w_.lattice_.vertex_site[vertex] = static_cast<std::uint32_t>(site_of(points_[k]));
  w_.lattice_.vertex_body[vertex] = index_;
  w_.lattice_.contact_shape[vertex] = surface_[k];
  w_.lattice_.vertex_coordinates[vertex] = points_[k];
  return vertex;
}

std::uint32_t WorldImpl::NewBody::tag_at(std::uint32_t site) const {
  int direct = 0;
  core::each_direct(
      [&](int dx, int dy, int dz) { direct += vertex_beside(site, dx, dy, dz) != none ? 1 : 0; });
  std::uint32_t tag = s_.material.index | tag_solid | ((index_ + 1) << tag_body_shift);
  if (direct < static_cast<int>(core::full_neighbours)) tag |= tag_surface;
  if (record_.desc.fixed) tag |= tag_fixed;
  if (kinematic()) tag |= tag_kinematic;
  return tag;
}

/// Labels of the pieces the shape consists of.
void WorldImpl::NewBody::label_pieces() {
  for (std::uint32_t v = record_.first_vertex; v < record_.first_vertex + record_.vertices; ++v)
    if (w_.state_.vertex_piece[v] == none) label_piece(v);
}

/// Flood fill over the 26 direct neighbours.
void WorldImpl::NewBody::label_piece(std::uint32_t first) {
  std::vector<std::uint32_t>& label = w_.state_.vertex_piece;
  label[first] = first;
  stack_.push_back(first);
  while (!stack_.empty()) {
    const std::uint32_t u = stack_.back();
    stack_.pop_back();
    core::each_direct([&](int dx, int dy, int dz) {
      const std::uint32_t n = vertex_beside(w_.lattice_.vertex_site[u], dx, dy, dz);
      if (n == none || label[n] != none) return;
      label[n] = first;
      stack_.push_back(n);
    });
  }
}

/// Free sites come after all that are occupied; each is the label of nothing but itself.
void WorldImpl::NewBody::add_free_sites() {
  core::SceneLattice& lattice = w_.lattice_;
  auto v = static_cast<std::uint32_t>(lattice.vertex_site.size());
  w_.extend_vertices(free_.size());
  for (const Vec3i& p : free_) {
    const std::uint64_t site = site_of(p);
    lattice.site_vertex[site] = v;
    lattice.vertex_site[v] = static_cast<std::uint32_t>(site);
    lattice.vertex_body[v] = index_;
    lattice.vertex_coordinates[v] = p;
    w_.put_vertex(v, none, core::vertex_free, v);
    ++v;
  }
}

/// Position of the lattice relative to the pivot.
core::BodyMotionRow WorldImpl::NewBody::rest_row() const {
  core::BodyMotionRow rest;
  rest.first_vertex = record_.first_vertex;
  rest.spacing = w_.desc.spacing;
  rest.mass = s_.mass;
  rest.inertia = s_.inertia;
  if ((!kinematic() && !proxy()) || points_.empty()) return rest;
  const double dx = w_.desc.spacing;
  rest.low = Vec3d{(box_.low[0] - pad_ + 0.5) * dx, (box_.low[1] - pad_ + 0.5) * dx,
                   (box_.low[2] - pad_ + 0.5) * dx} -
             center_in_lattice();
  return rest;
}

physics::RigidMotion WorldImpl::NewBody::first_motion() const {
  physics::RigidMotion motion;
  if (!kinematic() && !proxy()) return motion;
  motion.from = motion.until = w_.time;
  motion.first = motion.then = {center_, {}, s_.velocity, s_.angular_velocity};
  if (proxy()) motion.then = {};  // no gap to close, no acceleration by the host
  return motion;
}

Status WorldImpl::NewBody::come_back(const StoredBody& stored) {
  const double max_speed = std::exchange(s_.max_speed, 0);  // one that is held has it, too
  if (Status st = check_path(-infinity); !st) return st;    // it may have begun
  std::vector<PosePoint> path = std::exchange(s_.path, {});
  if (s_.growth < 0 || stored.longest < 1 || stored.longest > (1 << 30) || !w_.valid(s_.material) ||
      !(max_speed >= 0 && max_speed <= most_speed))
    return damaged(what_, "a number is not usable");
  if (Status st = stored.forgotten ? settle_motion(s_, what_) : check(); !st) return st;
  s_.max_speed = max_speed;
  s_.path = std::move(path);
  if (Status st = take_sites(stored); !st) return st;
  if (Status st = number_sites(); !st) return st;
  density_ = density_of(stored.vertices);
  make_record();
  record_.longest = static_cast<int>(stored.longest);
  record_.vertices = static_cast<std::uint32_t>(stored.vertices);
  record_.watched = stored.watched;
  if (stored.forgotten) {
    record_.gone = true;
    record_.sites = 0;
  }
  make_row();
  row_.watched = stored.watched ? 1u : 0u;
  if (Status st = stored.forgotten ? Status{} : come_back_to_lattice(stored); !st) return st;
  if (!stored.forgotten) w_.body_names_.insert(name_);
  w_.lattice_.rests[index_] = rest_row();
  w_.bodies_[index_] = std::move(record_);
  w_.lattice_.bodies[index_] = row_;
  return {};
}

/// Whether its box is about its points, and no larger than growth can make it.
bool WorldImpl::NewBody::is_box_of_its_sites(const StoredBody& stored) const {
  constexpr std::int64_t most = 1 << 30;
  if (s_.growth > 0 && !(box_.sites() <= most_growth_sites)) return false;
  if (stored.points.empty() && !stored.forgotten) return false;
  const core::SiteBox about = stored.points.empty() ? box_ : core::box_of(stored.points);
  for (int a = 0; a < 3; ++a)
    if (std::max(std::abs(box_.low[a]), std::abs(box_.high[a])) > most || box_.extent(a) < 1 ||
        box_.low[a] > about.low[a] || box_.high[a] < about.high[a] ||
        box_.low[a] < about.low[a] - s_.growth || box_.high[a] > about.high[a] + s_.growth)
      return false;
  return true;
}

/// Points, free sites and box.
Status WorldImpl::NewBody::take_sites(const StoredBody& stored) {
  points_ = stored.points;
  free_ = stored.free;
  surface_ = stored.surface;
  box_ = stored.box;
  origin_ = w_.origin_;
  if (!is_box_of_its_sites(stored)) return damaged(what_, "its box is not usable");
  if (points_.size() != (stored.forgotten ? 0 : stored.vertices) || surface_.size() != points_.size() ||
      stored.vertices == 0 || stored.vertices >= none || (stored.forgotten && !free_.empty()))
    return damaged(what_, "its sites and particles are not as many");
  for (const Vec4<float>& s : surface_)
    if (!(std::fabs(s.w) <= physics::largest_contact_radius) || !(std::fabs(s.w) > 0) ||
        !(length(Vec3<float>{s.x, s.y, s.z}) < core::full_neighbours + 1))
      return damaged(what_, "how it lies at its surface is not usable");
  if (s_.motion == Motion::fixed && keeps_its_sites()) cell_ = w_.cell_of(s_.shape.bounds());
  if (!points_.empty()) w_.put_in_cells(w_.lattice_origin(), cell_, points_, positions_);
  if (points_.size() != surface_.size()) return damaged(what_, "a site is outside the domain");
  if (!points_.empty()) center();
  return {};
}

/// Its vertices and sites, in the order that they had.
Status WorldImpl::NewBody::come_back_to_lattice(const StoredBody& stored) {
  core::SceneLattice& lattice = w_.lattice_;
  const auto within = [this](const Vec3i& p) {
    return p.x >= box_.low[0] && p.x <= box_.high[0] && p.y >= box_.low[1] && p.y <= box_.high[1] &&
           p.z >= box_.low[2] && p.z <= box_.high[2];
  };
  for (const auto* sites : {&points_, &free_})
    if (!std::all_of(sites->begin(), sites->end(), within))
      return damaged(what_, "a site is outside its box");
  if (double(record_.first_vertex) + double(points_.size()) + double(free_.size()) >= double(none))
    return damaged(what_, "there are too many sites");
  lattice.site_vertex.resize(base_ + nx_ * ny_ * nz_, none);
  w_.extend_vertices(points_.size());
  for (std::size_t k = 0; k < points_.size(); ++k)
    lattice.site_vertex[site_of(points_[k])] = put_on_lattice(none, k);
  add_free_sites();
  for (std::uint32_t v = record_.first_vertex; v < record_.end_vertex(); ++v)
    if (lattice.site_vertex[lattice.vertex_site[v]] != v) return damaged(what_, "two sites are the same");
  w_.solids_built_ += stored.vertices;
  return {};
}

Status WorldImpl::come_back(const StoredBody& stored) {
  return NewBody(*this, stored.desc, stored.row).come_back(stored);
}

Result<BodyId> WorldImpl::add_solid(const SolidDesc& given) {
  NewBody body(*this, given);
  if (Status st = body.check(); !st) return st.error();
  if (Status st = body.place(); !st) return st.error();
  if (const auto joined = body.join_in_place()) return *joined;
  if (Status st = body.clear(); !st) return st.error();
  if (Status st = body.weigh(); !st) return st.error();
  body.reserve();
  return body.join();
}

}  // namespace v0
}  // namespace meltsim
