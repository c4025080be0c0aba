// SPDX-License-Identifier: Apache-2.0
// Random sequences of calls of World, seeded by the number of the case. After every call: a refused one changed
// nothing; what is read is finite and consistent; masses and ids are those given out. Two kinds of sequences: even
// cases stay within what a user would write, where a World must not halt and nothing may fly; odd ones draw extremes.
//
//   meltsim_api_fuzz --cases 800 --backend cpu
//   meltsim_api_fuzz --first 4711 --cases 1 --trace 1     # one case again, with its calls
//   meltsim_api_fuzz --cases 800 --threads 1 --states FILE   # a line of hashes after every call, to be compared with another run's
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "calls_main.hpp"
#include "meltsim/meltsim.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using fuzz::Settings;
using fuzz::Violation;
using test_support::Random;

const double nan = std::numeric_limits<double>::quiet_NaN();

bool finite(double v) { return std::isfinite(v); }
bool finite(Vec3d v) { return finite(v.x) && finite(v.y) && finite(v.z); }

/// One World and what must be true of it.
class Sequence {
 public:
  Sequence(std::uint64_t item, const Settings& settings, fuzz::Progress& progress)
      : random_(static_cast<std::uint32_t>(item * 2654435761u + 17u)),
        item_(item),
        reserved_(item % 3 == 0 ? 0 : item % 300),
        settings_(settings),
        progress_(progress),
        wild_(item % 2 == 1) {}

  std::string run() {
    try {
      create();
      if (!world_) return {};
      const int calls = 6 + static_cast<int>(random_.below(30));
      for (int k = 0; k < calls; ++k) {
        any_call();
        say_state();
      }
      step_some();
      say_state();
      close();
      return {};
    } catch (const Violation& v) {
      return v.text + "\n  after: " + trace_;
    } catch (const std::exception& e) {
      return std::string("an exception left the library: ") + e.what() + "\n  after: " + trace_;
    }
  }

 private:
  // --- drawing ----------------------------------------------------------------------------------------------
  bool chance(double p) { return random_.uniform() < p; }
  double log_uniform(double low, double high) {
    return std::exp(random_.uniform(std::log(low), std::log(high)));
  }
  template <class T>
  T pick(std::initializer_list<T> of) {
    return *(of.begin() + random_.below(static_cast<std::uint32_t>(of.size())));
  }
  double extreme() {
    return pick(
        {0.0, -1.0, nan, infinity, -infinity, 1e300, -1e300, 1e-300, 1e30, -1e30, 1e12, 1e-12, 1e9, 4e9});
  }
  /// `v`, or in wild sequences sometimes something absurd.
  double or_extreme(double v, double p = 0.04) { return wild_ && chance(p) ? extreme() : v; }
  Vec3d or_extreme(Vec3d v, double p = 0.04) {
    if (wild_ && chance(p)) (&v.x)[random_.below(3)] = extreme();
    return v;
  }

  // --- reporting --------------------------------------------------------------------------------------------
  template <class... Parts>
  std::string text(const Parts&... parts) {
    std::ostringstream out;
    out.precision(9);
    (out << ... << parts);
    return out.str();
  }
  template <class... Parts>
  void note(const Parts&... parts) {
    const std::string said = text(parts...);
    trace_ += (trace_.empty() ? "" : "; ") + said;
    if (settings_.trace) std::printf("  %s\n", said.c_str()), std::fflush(stdout);
    std::snprintf(progress_.what, sizeof progress_.what, "%s", said.c_str());
    progress_.calls = progress_.calls + 1;
  }
  [[noreturn]] void violate(const std::string& what) { throw Violation{what}; }
  void expect(bool holds, const std::string& what) {
    if (!holds) violate(what);
  }

  // --- the World --------------------------------------------------------------------------------------------
  void create() {
    WorldDesc d;
    d.backend = settings_.backend;
    d.spacing = dx_ = pick({0.02, 0.05, 0.1, 0.2});
    d.precision = chance(0.3) ? Precision::double_precision : Precision::single_precision;
    d.threads = 1 + static_cast<int>(random_.below(2));
    if (chance(0.3)) d.support_radius = dx_ * random_.uniform(2.0, 3.2);
    const double support = d.support_radius > 0 ? d.support_radius : 2.5 * dx_;
    d.domain.bounded = chance(0.75);
    size_ = {dx_ * (8 + random_.below(8)), dx_ * (8 + random_.below(10)), dx_ * (8 + random_.below(8))};
    low_ = chance(0.3) ? random_.vector(5) : Vec3d{};
    d.domain.min = low_;
    d.domain.max = low_ + size_;
    for (int axis = 0; axis < 3; ++axis) {
      const double extent = (&size_.x)[axis];
      const double what = random_.uniform();
      const auto face = static_cast<std::size_t>(2 * axis);
      if (what < 0.15 && extent >= 3 * support)
        d.domain.faces[face] = d.domain.faces[face + 1] = Face::periodic;
      else if (what < 0.35) {
        const std::size_t open = face + random_.below(2);
        d.domain.faces[open] = Face::open;
        if (d.domain.bounded && chance(0.5)) {
          if (chance(0.5))
            d.domain.outlets[open].level = or_extreme(low_.y + size_.y * random_.uniform(0, 1));
          else d.domain.outlets[open].speed = or_extreme(random_.uniform(0.05, 1));
        } else if (axis != 1) {
          (&inwards_.x)[axis] = open % 2 == 0 ? 1 : -1;
        }
      }
    }
    if (chance(0.15)) {
      const std::uint32_t face = random_.below(6);
      Vec3d& along = d.domain.velocity[face];
      along = random_.vector(1);
      (&along.x)[face / 2] = 0;
      if (d.domain.faces[face] != Face::wall) along = {};
    }
    d.domain.no_slip = chance(0.7);
    d.domain.friction = random_.uniform(0, 1);
    d.gravity = chance(0.7) ? Vec3d{0, -9.81, 0} : chance(0.5) ? Vec3d{} : random_.vector(9.81);
    d.artificial_viscosity = random_.uniform(0.01, 0.1);
    d.heat.time_scale = pick({0.0, 1.0, 1e3, 1e5});
    d.heat.model = pick(
        {HeatModel::enthalpy, HeatModel::enthalpy, HeatModel::enthalpy, HeatModel::none, HeatModel::paper});
    const std::uint32_t face = random_.below(6);
    if (chance(0.3) && d.domain.bounded && d.heat.model == HeatModel::enthalpy &&
        d.domain.faces[face] == Face::wall)
      d.domain.heat[face] = surface_heat();
    d.neighbour_search = pick({NeighbourSearch::automatic, NeighbourSearch::grid, NeighbourSearch::tree});
    d.courant = random_.uniform(0.2, 0.45);
    d.pieces_interval = 1 + static_cast<int>(random_.below(16));
    if (chance(0.1)) d.heat.interval = static_cast<int>(random_.below(5));
    if (chance(0.15)) d.heat.level_tolerance = or_extreme(pick({0.0, 1e-3, 1.0}));
    if (chance(0.15) && d.heat.model == HeatModel::enthalpy) d.heat.free_surface = surface_heat();
    if (chance(0.15)) d.viscosity = pick({Viscosity::implicit, Viscosity::explicit_});
    if (chance(0.2)) d.density_error = or_extreme(pick({0.001, 0.01, 0.05}));
    if (chance(0.1)) d.follow_sound_speed = true;
    if (chance(0.3)) d.hydrostatic_start = false;
    if (wild_ && chance(0.2))
      d.tension = true, d.particle_shifting = chance(0.5);  // at a free surface it clumps
    if (chance(0.15)) d.domain.contact_angle = or_extreme(random_.uniform(0, 180));
    if (chance(0.1)) d.solute.time_scale = or_extreme(pick({0.0, 1e3, 1e5}));
    if (chance(0.05)) d.stray = Stray::halt;
    d.reserved_particles = reserved_;
    d.spacing = or_extreme(d.spacing, 0.02);
    d.support_radius = or_extreme(d.support_radius, 0.02);
    d.courant = or_extreme(d.courant, 0.02);
    d.gravity = or_extreme(d.gravity, 0.02);
    d.sound_speed = or_extreme(0, 0.04);
    d.artificial_viscosity = or_extreme(d.artificial_viscosity, 0.02);
    d.heat.time_scale = or_extreme(d.heat.time_scale, 0.04);
    d.domain.max = or_extreme(d.domain.max, 0.02);
    d.domain.velocity[0] = or_extreme(d.domain.velocity[0], 0.02);
    if (wild_ && chance(0.03)) d.threads = pick({-1, 100000, 1 << 30});
    if (settings_.threads > 0 && d.threads > 0) d.threads = settings_.threads;
    if (wild_ && chance(0.02)) d.heat.max_stages = pick({0, 1, 2, 1024, 1 << 30});
    if (wild_ && chance(0.02)) d.max_substeps = pick({0, 1, 1 << 30});
    note("create dx ", d.spacing, d.domain.bounded ? " bounded " : " unbounded ", size_.x / dx_, "x",
         size_.y / dx_, "x", size_.z / dx_, " search ", int(d.neighbour_search), " precision ",
         int(d.precision), " heat ", int(d.heat.model), " x", d.heat.time_scale, " c ", d.sound_speed, " g ",
         d.gravity.x, ",", d.gravity.y, ",", d.gravity.z, d.follow_sound_speed ? " follows" : "",
         d.tension ? " tension" : "", d.particle_shifting ? " shifting" : "", " viscosity ", int(d.viscosity),
         " compression ", d.density_error, " heat interval ", d.heat.interval, " courant ", d.courant);
    auto made = World::create(d);
    if (!made) {
      // An outlet's level needs a floor, its speed a direction; species and shifting exclude each other.
      expect(wild_ || made.error().message.find("outlet") != std::string::npos ||
                 made.error().message.find("shifting") != std::string::npos,
             "a usual World was refused: " + made.error().message);
      expect(!made.error().message.empty(), "an error without a message");
      return;
    }
    desc_ = made_from_ = d;
    world_.emplace(std::move(*made));
    tickets_.clear();
    speed_scale_ = 0;
    for (const Vec3d& v : d.domain.velocity) speed_scale_ = std::max(speed_scale_, length(v));
  }

  SurfaceHeatDesc surface_heat() {
    SurfaceHeatDesc s;
    const auto timed = [this](double low, double high) {
      std::vector<TimedValue> points{{random_.uniform(-0.1, 0.1), random_.uniform(low, high)}};
      for (int k = 0; k < 2; ++k)
        points.push_back({points.back().time + or_extreme(random_.uniform(0.001, 0.1), 0.02),
                          or_extreme(random_.uniform(low, high), 0.02)});
      return points;
    };
    if (chance(0.15)) s.temperature_points = timed(-50, 150);
    if (chance(0.4)) {
      s.temperature = or_extreme(random_.uniform(-50, 150));
      return s;
    }
    if (chance(0.1)) s.flux_points = timed(-1e3, 1e4);
    s.flux = or_extreme(random_.uniform(-1e3, 1e4));
    s.convection = or_extreme(random_.uniform(0, 500));
    s.emissivity = or_extreme(random_.uniform(0, 1));
    s.ambient = or_extreme(random_.uniform(-50, 150));
    return s;
  }

  /// Tells whether a refused call changed anything a host can see.
  struct Seen {
    std::vector<std::uint8_t> snapshot;
    std::uint64_t hash = 0, steps = 0;
    double time = 0, stable_dt = 0;
    std::size_t materials = 0;
  };
  Seen see() {
    Seen s;
    (void)world_->prepare();  // derives what follows from the scene, stable_dt among it
    const auto snapshot = world_->snapshot();
    if (snapshot) s.snapshot = *snapshot;
    const auto hash = world_->state_hash();
    if (hash) s.hash = *hash;
    s.steps = world_->steps();
    s.time = world_->time();
    s.stable_dt = world_->stable_dt();
    return s;
  }
  template <class Call>
  auto guarded_call(const char* what, const Call& call) {
    const bool watched = chance(0.5);
    Seen before;
    if (watched) before = see();
    auto result = call();
    if (!result) {
      expect(!result.error().message.empty(), text(what, ": an error without a message"));
      if (settings_.trace) std::printf("    refused: %s\n", result.error().message.c_str());
      const bool awaited = interruption_waits_ && result.error().code == ErrorCode::interrupted;
      if (awaited) interruption_waits_ = false;
      if (watched && !awaited) {  // what was interrupted has begun
        const Seen after = see();
        expect(after.hash == before.hash,
               text(what, " was refused and changed the state: ", result.error().message));
        expect(after.snapshot == before.snapshot,
               text(what, " was refused and changed the snapshot: ", result.error().message));
        expect(after.steps == before.steps && after.time == before.time,
               text(what, " was refused and changed the clock: ", result.error().message));
        expect(after.stable_dt == before.stable_dt ||
                   (std::isnan(after.stable_dt) && std::isnan(before.stable_dt)),
               text(what, " was refused and changed stable_dt from ", before.stable_dt, " to ",
                    after.stable_dt, ": ", result.error().message));
      }
      const bool may = wild_ || result.error().code == ErrorCode::capacity ||
                       result.error().code == ErrorCode::step_too_large || refusable_ || awaited ||
                       // A body that the host moves comes to a wall.
                       result.error().message.find("set_motion: body") != std::string::npos ||
                       result.error().message.find("step: path: body") != std::string::npos ||
                       result.error().message.find("update_mesh: body") != std::string::npos;
      expect(may, text(what, ": a usual call was refused: ", result.error().message));
    }
    return result;
  }

  Vec3d place() {
    return low_ + Vec3d{size_.x * random_.uniform(0.1, 0.9), size_.y * random_.uniform(0.1, 0.9),
                        size_.z * random_.uniform(0.1, 0.9)};
  }
  Shape shape() {
    const Vec3d c = place();
    const double r = dx_ * random_.uniform(1.2, 3.2);
    switch (random_.below(6)) {
      case 0:
        return Shape::sphere(or_extreme(c, 0.02), or_extreme(r, 0.03));
      case 1:
        return Shape::capsule(c, or_extreme(c + random_.vector(2 * dx_), 0.02), or_extreme(r / 2, 0.03));
      case 2:
        return Shape::cylinder(c, or_extreme(c + Vec3d{0, r, 0}, 0.02), or_extreme(r, 0.03));
      case 3:
        return Shape::subtract(Shape::box(c - Vec3d{r, r, r}, c + Vec3d{r, r, r}), Shape::sphere(c, r / 2));
      case 4:
        return Shape::box(c - Vec3d{r, r, r}, c + Vec3d{r, r, r})
            .transformed({}, {1, 2, 3}, or_extreme(random_.uniform(0, 3), 0.03));
      default:
        return Shape::box(or_extreme(c - Vec3d{r, r, r}, 0.02), c + Vec3d{r, r, r});
    }
  }

  void add_material() {
    MaterialDesc m;
    m.name = text("m", materials_.size());
    const bool solid = !liquids_.empty() && chance(0.55);
    m.density = or_extreme(log_uniform(300, 3000));
    m.viscosity = or_extreme(log_uniform(1e-4, 1));
    m.conductivity = or_extreme(log_uniform(0.05, 100));
    m.heat_capacity = or_extreme(log_uniform(300, 5000));
    m.damping = or_extreme(random_.uniform(0, 0.5), 0.02);
    m.friction = or_extreme(random_.uniform(0, 1), 0.02);
    if (solid) {
      m.region_half_width = static_cast<int>(random_.below(4));
      if (wild_ && chance(0.1)) m.region_half_width = pick({-1, 0, 8, 9, 1 << 30});
      m.stiffness = or_extreme(random_.uniform(0.3, 1), 0.03);
      if (m.region_half_width > 0 && chance(0.3)) m.youngs_modulus = or_extreme(log_uniform(1e4, 1e7), 0.05);
      if (chance(0.8)) {
        m.melts_into = liquids_[random_.below(static_cast<std::uint32_t>(liquids_.size()))];
        m.melting_point = or_extreme(random_.uniform(-20, 60));
        m.latent_heat = or_extreme(pick({0.0, 1e4, 3.34e5}));
        if (chance(0.3)) m.melting_range = or_extreme(log_uniform(0.1, 100), 0.05);
        m.freezes = chance(0.3);
      }
      if (chance(0.2)) m.contact_angle = or_extreme(random_.uniform(0, 180), 0.05);
    } else {
      if (chance(0.2)) m.surface_tension = or_extreme(log_uniform(0.01, 0.1) * dx_ * dx_ / 1e-4, 0.05);
      if (chance(0.2)) m.viscosity_points = {{0, or_extreme(0.5)}, {or_extreme(50), 0.01}};
      if (chance(0.2)) m.density_points = {{0, m.density}, {80, or_extreme(m.density * 0.97)}};
    }
    if (chance(0.2)) m.conductivity_points = {{-20, or_extreme(0.4)}, {or_extreme(60), 2}};
    const bool species = !liquids_.empty() && chance(0.2);
    if (species) {
      m.melts_into = {};
      m.melting_point = infinity;
      m.freezes = false;
      m.viscosity_points.clear();
      m.density_points.clear();
      m.dissolves_in = liquids_[random_.below(static_cast<std::uint32_t>(liquids_.size()))];
      m.solubility = or_extreme(solid ? random_.uniform(0.1, 0.9) : 1.0, 0.05);
      if (solid && chance(0.5))
        m.solubility_points = {{0, or_extreme(random_.uniform(0.05, 0.5), 0.05)},
                               {or_extreme(60, 0.05), random_.uniform(0.1, 0.9)}};
      m.diffusivity_in = or_extreme(log_uniform(1e-9, 1e-3), 0.05);
      if (chance(0.5)) m.heat_of_solution = or_extreme(random_.uniform(-1e5, 1e5));
      if (chance(0.3)) m.transfer_coefficient = or_extreme(log_uniform(1e-6, 1e-2), 0.05);
    }
    if (!species && !solid && chance(0.15)) {
      m.yield_stress_points = {{0, or_extreme(1, 0.05)}, {or_extreme(40, 0.05), 0}};
      m.regularisation = or_extreme(1, 0.05);
    }
    note("add_material ", species ? "species " : "", solid ? "solid" : "liquid", " rho ", m.density, " mu ",
         m.viscosity, " k ", m.conductivity, " c ", m.heat_capacity, " w ", m.region_half_width, " E ",
         m.youngs_modulus, " L ", m.latent_heat, " range ", m.melting_range, m.freezes ? " freezes" : "");
    refusable_ =
        species ||
        bool(
            m.melts_into);  // two solids may not freeze from one liquid, nor one melt far below where it freezes
    const auto id = guarded_call("add_material", [&] { return world_->add_material(m); });
    refusable_ = false;
    if (!id) return;
    again([m](World& w) { return bool(w.add_material(m)); });
    materials_.push_back(*id);
    if (species) species_.push_back(*id);
    if (solid || !species) (solid ? solids_ : liquids_).push_back(*id);
  }

  /// Other numbers of a material while the World runs; now and then one that must stay.
  void change_material() {
    if (materials_.empty()) return add_material();
    const MaterialId id = materials_[random_.below(static_cast<std::uint32_t>(materials_.size()))];
    MaterialDesc m = world_->material(id);
    if (chance(0.6)) m.viscosity = or_extreme(log_uniform(1e-4, 1));
    if (chance(0.6)) m.conductivity = or_extreme(log_uniform(0.05, 100));
    if (chance(0.3)) m.friction = or_extreme(random_.uniform(0, 1), 0.02);
    if (chance(0.3)) m.damping = or_extreme(random_.uniform(0, 0.5), 0.02);
    if (chance(0.3)) m.stiffness = or_extreme(random_.uniform(0.3, 1), 0.03);
    const bool must_stay = chance(0.1);
    if (must_stay) m.density *= 1.01;
    note("set_material ", id.index, " mu ", m.viscosity, " k ", m.conductivity,
         must_stay ? " and its density" : "");
    refusable_ = must_stay;
    const Status s = guarded_call("set_material", [&] { return world_->set_material(id, m); });
    refusable_ = false;
    expect(!(s && must_stay), "set_material took another density");
    if (s) again([id, m](World& w) { return bool(w.set_material(id, m)); });
  }

  /// What is dissolved in a liquid; of a species of another one it is refused.
  std::vector<MassFraction> fractions() {
    if (species_.empty() || !chance(0.4)) return {};
    return {{species_[random_.below(static_cast<std::uint32_t>(species_.size()))],
             or_extreme(random_.uniform(0, 0.3), 0.05)}};
  }

  void add_fluid() {
    if (liquids_.empty()) return add_material();
    FluidDesc f;
    f.shape = shape();
    f.material = liquids_[random_.below(static_cast<std::uint32_t>(liquids_.size()))];
    if (wild_ && chance(0.03)) f.material = pick({MaterialId{}, MaterialId{77, 1}, MaterialId{0, 2}});
    f.temperature = or_extreme(random_.uniform(-10, 90));
    if (chance(0.2)) f.velocity = or_extreme(random_.vector(1));
    f.fractions = fractions();
    note("add_fluid", f.fractions.empty() ? "" : " mixed", " T ", f.temperature, " v ", f.velocity.x, ",",
         f.velocity.y, ",", f.velocity.z);
    refusable_ = true;  // its place may be taken or outside
    const auto n = guarded_call("add_fluid", [&] { return world_->add_fluid(f); });
    refusable_ = false;
    if (!n) return;
    again_saved([f](World& w) { return bool(w.add_fluid(f)); });
    moves(length(f.velocity));
  }

  /// A body that the host moves, of the mesh of a box; returns its corners.
  std::vector<Vec3d> make_deformable(SolidDesc& s) {
    const Vec3d c = place();
    const double r = dx_ * random_.uniform(1.2, 3.2);
    TriangleMesh mesh;
    for (int k = 0; k < 8; ++k)
      mesh.vertices.push_back(c + Vec3d{k & 1 ? r : -r, k & 2 ? r : -r, k & 4 ? r : -r});
    mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    std::vector<Vec3d> corners = mesh.vertices;
    s.shape = Shape::mesh(std::move(mesh));
    s.fixed = false;
    s.motion = Motion::kinematic;
    s.velocity = s.angular_velocity = {};
    return corners;
  }
  /// Moves the corners of such a body by less than a spacing, at times too far.
  void deform() {
    if (meshes_.empty()) return;
    auto& [id, corners] = meshes_[random_.below(static_cast<std::uint32_t>(meshes_.size()))];
    std::vector<Vec3d> to = corners, velocities;
    for (Vec3d& x : to) x = or_extreme(x + random_.vector(0.3 * dx_), 0.01);
    if (wild_ && chance(0.3))
      for (std::size_t k = 0; k < to.size(); ++k)
        velocities.push_back(or_extreme(random_.vector(0.2 * dx_), 0.01));
    if (wild_ && chance(0.1)) to.pop_back();
    note("update_mesh ", id.index);
    refusable_ = true;  // growth, beyond a wall, too fast
    const double stable = world_->stable_dt(), dt = finite(stable) && stable > 0 ? stable : 1e-3;
    double farthest = 0;
    for (std::size_t k = 0; k < to.size(); ++k) farthest = std::max(farthest, length(to[k] - corners[k]));
    if (guarded_call("update_mesh", [&] { return world_->update_mesh(id, to, velocities); })) {
      moves(farthest / dt);  // of a body that is alone it may be any speed
      deformed_ = true;
      if (guarded_call("step", [&] { return world_->step(dt); })) corners = to;
      else {  // it would be refused for ever
        (void)guarded_call("update_mesh", [&] { return world_->update_mesh(id, corners); });
        (void)world_->step(dt);  // what is not taken yet is no part of the state
      }
    }
    refusable_ = false;
    synchronize();
  }

  void add_solid() {
    if (solids_.empty()) return add_material();
    SolidDesc s;
    s.shape = shape();
    s.material = solids_[random_.below(static_cast<std::uint32_t>(solids_.size()))];
    s.temperature = or_extreme(random_.uniform(-30, 40));
    if (chance(0.3)) s.velocity = or_extreme(random_.vector(1));
    if (chance(0.2)) s.angular_velocity = or_extreme(random_.vector(2));
    s.fixed = chance(0.25);
    if (s.fixed) s.velocity = s.angular_velocity = {};
    else if (chance(0.3)) s.motion = Motion::rigid;
    else if (chance(0.2)) {
      s.motion = Motion::kinematic;
      if (chance(0.5)) s.pivot = or_extreme(place(), 0.03);
      if (chance(0.3)) s.max_speed = or_extreme(random_.uniform(0, 2), 0.03);
      if (chance(0.3)) {
        s.velocity = s.angular_velocity = {};
        s.path = {{world_->time(), {}, 0}};
        for (int k = 0; k < 3; ++k)
          s.path.push_back({s.path.back().time + or_extreme(random_.uniform(0.01, 0.3), 0.02),
                            random_.vector(0.1), or_extreme(random_.uniform(-1, 1), 0.02)});
        if (chance(0.5)) s.path_axis = or_extreme(random_.vector(1), 0.03);
      }
    } else if (chance(0.25)) {
      s.motion = Motion::proxy;
      s.mass = or_extreme(random_.uniform(0.1, 5) * 1000 * 27 * dx_ * dx_ * dx_);
    }
    std::vector<Vec3d> corners;
    if (chance(0.1)) {
      corners = make_deformable(s);
    }
    if (chance(0.2)) s.surface = surface_heat();
    if (chance(0.1)) s.heat_source = or_extreme(random_.uniform(-1e5, 1e6));
    if (chance(0.15)) s.growth = static_cast<int>(random_.below(3));
    if (wild_ && chance(0.03)) s.growth = pick({-1, 1 << 30, 1000});
    if (chance(0.1)) s.held_until = or_extreme(pick({0.05, 0.5, infinity}), 0.03);
    s.carve = chance(0.8);
    note("add_solid T ", s.temperature,
         s.fixed                         ? " fixed"
         : s.motion == Motion::rigid     ? " rigid"
         : s.motion == Motion::proxy     ? " proxy"
         : s.motion == Motion::kinematic ? " kinematic"
                                         : "",
         s.held_until > 0 ? " held" : "", " growth ", s.growth, " source ", s.heat_source, " v ",
         s.velocity.x, ",", s.velocity.y, ",", s.velocity.z);
    refusable_ = true;
    const auto id = guarded_call("add_solid", [&] { return world_->add_solid(s); });
    refusable_ = false;
    if (!id) return;
    again_saved([s](World& w) { return bool(w.add_solid(s)); });
    moves(s.max_speed);
    for (std::size_t k = 1; k < s.path.size(); ++k)
      moves((length(s.path[k].displacement - s.path[k - 1].displacement) +
             2 * length(size_) * std::fabs(s.path[k].angle - s.path[k - 1].angle)) /
            (s.path[k].time - s.path[k - 1].time));
    bodies_.push_back(*id);
    if (s.motion == Motion::kinematic) kinematic_.push_back(*id);
    if (!corners.empty()) meshes_.emplace_back(*id, std::move(corners));
    if (world_->steps() == 0) masses_.clear();  // ids close up where the body displaced liquid
    const double arm = s.pivot ? length(*s.pivot) + 2 * length(size_) : 4 * dx_;
    moves(length(s.velocity) + arm * length(s.angular_velocity));
  }

  void add_emitter() {
    if (liquids_.empty()) return add_material();
    EmitterDesc e;
    e.center = or_extreme(place());
    e.axis = chance(0.6) ? Vec3d{0, -1, 0} : random_.vector(1);
    e.axis = or_extreme(e.axis, 0.05);
    if (chance(0.7)) e.radius = or_extreme(dx_ * random_.uniform(1, 2), 0.08);
    else {
      e.width = or_extreme(dx_ * random_.uniform(2, 4), 0.05);
      e.height = or_extreme(dx_ * random_.uniform(2, 4), 0.05);
      e.up = or_extreme(random_.vector(1), 0.05);
    }
    e.fractions = fractions();
    if (length(inwards_) > 0 && chance(0.6)) {  // an open face
      e = EmitterDesc{};
      e.axis = inwards_.x != 0 ? Vec3d{inwards_.x, 0, 0} : inwards_;
      if (chance(0.05)) e.axis = random_.vector(1);
      e.level = or_extreme(low_.y + size_.y * random_.uniform(0.1, 0.9), 0.03);
    } else {
      e.speed = or_extreme(random_.uniform(0.2, 2));
      e.from = or_extreme(random_.uniform(0, 0.1), 0.03);
      e.until = or_extreme(e.from + random_.uniform(0, 0.3), 0.03);
    }
    e.material = liquids_[random_.below(static_cast<std::uint32_t>(liquids_.size()))];
    e.temperature = or_extreme(random_.uniform(5, 95));
    if (chance(0.5)) e.max_particles = 50 + random_.below(300);
    if (chance(e.level ? 0.05 : 0.5)) e.recycle = true;
    note("add_emitter radius ", e.radius / dx_, " dx, speed ", e.speed, " axis ", e.axis.x, ",", e.axis.y,
         ",", e.axis.z, " until ", e.until, " level ", e.level.value_or(-1), e.recycle ? " recycles" : "");
    refusable_ = true;
    const auto id = guarded_call("add_emitter", [&] { return world_->add_emitter(e); });
    refusable_ = false;
    if (id) {
      again([e](World& w) { return bool(w.add_emitter(e)); });
      moves(e.level ? std::sqrt(2 * 9.81 * size_.y) : e.speed);
      emits_ = true;
      emitters_.push_back({*id, e});
    }
  }

  /// Turns a nozzle off or on, changes its speed, moves it: a little as a host does, or anywhere.
  void set_emitter() {
    if (emitters_.empty()) return add_emitter();
    auto& [id, e] = emitters_[random_.below(static_cast<std::uint32_t>(emitters_.size()))];
    EmitterSetting to;
    if (chance(0.3)) to.on = chance(0.6);
    if (chance(0.3)) to.speed = or_extreme(e.speed * random_.uniform(0.5, 1.5), 0.03);
    if (chance(0.6))
      to.center = chance(0.8) ? or_extreme(e.center + direction() * dx_, 0.03) : or_extreme(place(), 0.03);
    if (e.level && chance(0.7)) {
      to = EmitterSetting{};
      to.level = or_extreme(low_.y + size_.y * random_.uniform(0.1, 0.9), 0.03);
      if (chance(0.2)) to.on = chance(0.5);
    }
    note("set_emitter level ", to.level.value_or(-1), " speed ", to.speed.value_or(0), " to ",
         to.center.value_or(Vec3d{}).x);
    refusable_ = true;
    const auto s = guarded_call("set_emitter", [&] { return world_->set_emitter(id, to); });
    refusable_ = false;
    if (!s) return;
    if (to.speed) moves(*to.speed);
    if (to.center) e.center = *to.center;
  }

  void add_heat_region() {
    HeatRegionDesc r;
    r.shape = shape();
    if (chance(0.5)) r.temperature = or_extreme(random_.uniform(-50, 150));
    else r.source = or_extreme(random_.uniform(-1e5, 1e6));
    r.from = or_extreme(random_.uniform(0, 0.1));
    r.until = or_extreme(r.from + random_.uniform(0, 0.2));
    if (chance(0.3)) {
      r.path = {{random_.uniform(-0.1, 0.1), random_.vector(0.1)}};
      for (int k = 0; k < 3; ++k)
        r.path.push_back({r.path.back().time + or_extreme(random_.uniform(0.001, 0.1), 0.02),
                          or_extreme(random_.vector(0.3), 0.03)});
    }
    note("add_heat_region source ", r.source, " held ", r.temperature.value_or(nan));
    refusable_ = true;
    const auto id = guarded_call("add_heat_region", [&] { return world_->add_heat_region(r); });
    refusable_ = false;
    if (!id) return;
    heat_regions_.push_back(*id);
    again([r](World& w) { return bool(w.add_heat_region(r)); });
  }

  /// Takes out a heat region or a probe; now and then by a handle of one that is gone.
  void take_out_region_or_probe() {
    if (chance(0.5) && !heat_regions_.empty()) {
      const HeatRegionId id = any_of(heat_regions_);
      note("remove heat region ", id.index);
      refusable_ = std::find(gone_regions_.begin(), gone_regions_.end(), id) != gone_regions_.end();
      const Status done = guarded_call("remove", [&] { return world_->remove(id); });
      refusable_ = false;
      if (!done) return;
      gone_regions_.push_back(id);
      expect(!world_->remove(id) && !world_->set_heat_region(id, {}, 0),
             "the handle of a heat region that was removed is taken");
      again([](World&) { return false; });  // handles are of this World
      if (chance(0.7)) heat_regions_.erase(std::find(heat_regions_.begin(), heat_regions_.end(), id));
      return;
    }
    auto series = world_->take_samples();
    if (!series || series->empty()) return;
    const ProbeId id = any_of(*series).probe;
    note("remove probe ", id.index);
    const Status removed = guarded_call("remove", [&] { return world_->remove(id); });
    if (!removed) return;
    --probes_;
    expect(!world_->remove(id), "a probe was removed twice");
    expect(world_->take_samples()->size() == series->size() - 1, "another number of series");
    again_saved([](World&) { return false; });
  }

  Vec3d direction() { return {random_.uniform(-1, 1), random_.uniform(-1, 1), random_.uniform(-1, 1)}; }
  /// Adds, changes or removes a force field; sometimes by the handle of one that is gone.
  void push_about() {
    ForceFieldDesc f;
    f.kind = pick({ForceFieldKind::uniform, ForceFieldKind::radial, ForceFieldKind::vortex,
                   ForceFieldKind::drag, ForceFieldKind::hydrostatic});
    const Vec3d corner = low_ + size_ * 0.2;
    if (chance(0.3)) f.shape = shape();  // most kinds of which are refused
    else if (chance(0.5))
      f.shape = pick({Shape::box(corner, corner + size_ * 0.5), Shape::sphere(corner, 4 * dx_),
                      Shape::cylinder(low_, low_ + size_, 3 * dx_)})
                    .transformed({}, {0, 0, 1}, random_.uniform(0, 1));
    f.acceleration = or_extreme(direction() * random_.uniform(0, 20), 0.03);
    if (chance(0.5)) f.center = corner;
    f.axis = direction();
    f.strength = or_extreme(random_.uniform(-20, 20), 0.03);
    f.radius = or_extreme(random_.uniform(0, 6 * dx_), 0.03);
    f.power = pick({0, 0, 1, -1, -2, 3});
    f.velocity = or_extreme(direction() * random_.uniform(0, 3), 0.03);
    f.angular_velocity = direction() * random_.uniform(0, 2);
    f.rate = or_extreme(pick({0.0, 1.0, 30.0, 1e6}), 0.03);
    f.liquid = chance(0.9);
    f.bodies = chance(0.9);
    f.density = or_extreme(pick({0.0, 900.0, 1000.0}), 0.03);
    if (chance(0.2)) f.until = or_extreme(random_.uniform(0, 0.3), 0.1);
    const bool adds = fields_.empty() || chance(0.4), removes = !adds && chance(0.3);
    note("force field kind ", int(f.kind), " strength ", f.strength, " rate ", f.rate,
         adds      ? " added"
         : removes ? " removed"
                   : " changed");
    refusable_ = true;
    if (adds) {
      const auto id = guarded_call("add_force_field", [&] { return world_->add_force_field(f); });
      if (id) {
        fields_.push_back(*id);
        again([f](World& w) { return bool(w.add_force_field(f)); });
      }
    } else {
      const ForceFieldId id = fields_[random_.below(static_cast<std::uint32_t>(fields_.size()))];
      const Status done =
          removes ? guarded_call("remove", [&] { return world_->remove(id); })
                  : guarded_call("set_force_field", [&] { return world_->set_force_field(id, f); });
      if (done) again([=](World& w) { return bool(removes ? w.remove(id) : w.set_force_field(id, f)); });
    }
    refusable_ = false;
    moves(length(f.velocity) +
          std::sqrt(2 * (length(f.acceleration) + std::fabs(f.strength)) * 10 * length(size_)));
  }

  void moves(double speed) {
    if (finite(speed)) speed_scale_ = std::max(speed_scale_, speed);
  }

  // --- stepping ---------------------------------------------------------------------------------------------
  void step() {
    double stable = world_->stable_dt();
    if (!finite(stable) || stable <= 0) stable = 1e-3;
    double dt = stable * pick({0.01, 0.1, 0.3, 0.5, 0.9, 1.0, 1.0, 2.0, 4.0});
    if (chance(0.5)) dt = stable * random_.uniform(0.01, 1);
    if (wild_ && chance(0.06)) dt = extreme();
    note("step ", dt, " = ", dt / stable, " stable");
    refusable_ = halted_;
    const bool usual = dt >= 0 && dt <= 10 * stable;
    const auto s = guarded_call("step", [&] { return world_->step(dt); });
    refusable_ = false;
    if (!s && usual && !halted_ && s.error().code == ErrorCode::halted) synchronize();
    if (s) stepped_ += dt;
  }
  void step_some() {
    for (int k = 1 + static_cast<int>(random_.below(8)); k > 0; --k) step();
    synchronize();
  }
  void synchronize() {
    note("synchronize");
    const StepResult r = world_->synchronize();
    halted_ = r.halted;
    expect(!(r.halted && r.halt_reason.empty()), "halted without a reason");
    expect(wild_ || !r.halted, "a usual World halted: " + r.halt_reason);
    expect(finite(r.time) && r.time >= 0, "the clock is not finite");
    check_speed(r.max_speed, r);
  }
  /// What falls or is pushed may reach a few times the fastest thing there was; more is energy from nothing.
  void check_speed(double speed, const StepResult& r) {
    expect(!std::isnan(speed), "the largest speed is NaN");
    if (wild_) return;
    const double g = length(desc_.gravity),
                 height = length(size_) + 2 * stepped_ * speed_scale_ + g * stepped_ * stepped_;
    const double fall = std::sqrt(2 * g * height), thrust = std::sqrt(g * dx_);
    double bound = 6 * (speed_scale_ + fall + thrust) + 1;
    // A soft body that is strained when liquid comes becomes as stiff as the liquid's sound speed: flagged, and at the most
    // as fast as that.
    if (r.body_stiffened) bound += world_->resolved().sound_speed;
    if (speed > bound)
      violate(text("speed ", speed, " m/s, where ", bound, " is plenty (fastest given ", speed_scale_,
                   ", fall ", fall, "), t ", r.time, r.courant_exceeded ? ", flagged" : ", no flag"));
  }

  // --- reading ----------------------------------------------------------------------------------------------
  void read_particles() {
    note("particles");
    const auto data = world_->particles();
    expect(bool(data), "particles() failed: " + (data ? "" : data.error().message));
    for (std::size_t i = 0; i < data->id.size(); ++i) {
      const std::string who = text("particle ", data->id[i], ": ");
      expect(i == 0 || data->id[i] > data->id[i - 1], who + "ids are not ascending");
      expect(finite(data->position[i]), who + "position is not finite");
      expect(finite(data->velocity[i]), who + "velocity is not finite");
      expect(data->mass[i] > 0 && finite(data->mass[i]), who + text("mass ", data->mass[i]));
      expect(finite(data->temperature[i]), who + text("temperature ", data->temperature[i]));
      // The enthalpy of absolute zero is met to rounding.
      expect(data->temperature[i] >= absolute_zero * (1 + 1e-5),
             who + text("temperature ", data->temperature[i]));
      expect(data->liquid_fraction[i] >= 0 && data->liquid_fraction[i] <= 1, who + "liquid fraction");
      expect(finite(data->density[i]) && finite(data->pressure[i]), who + "density or pressure");
      for (const auto& w : data->fractions)
        expect(w[i] >= -1 && w[i] <= 2, who + text("mass fraction ", w[i]));
      expect(material_of(data->tag[i]) < materials_.size(), who + "material");
      const auto known = masses_.find(data->id[i]);
      if (known == masses_.end()) masses_[data->id[i]] = data->mass[i];
      else
        expect(known->second == data->mass[i],
               who + text("mass changed from ", known->second, " to ", data->mass[i]));
    }
  }
  void read_totals() {
    note("totals, ledger");
    const auto t = world_->totals();
    const auto l = world_->ledger();
    expect(t && l, "totals() or ledger() failed: " + (t ? (l ? "" : l.error().message) : t.error().message));
    for (const double v : {t->mass, t->kinetic, t->potential, t->thermal, t->latent, t->heat_in,
                           t->temperature_min, t->temperature_mean, t->temperature_max, t->max_speed,
                           t->density_error_mean, t->density_error_max, l->mass, l->kinetic, l->thermal})
      expect(finite(v), "a total is not finite");
    expect(finite(t->momentum) && finite(t->angular_momentum) && finite(t->solid_center),
           "a total is not finite");
    const auto near = [](double a, double b, double scale) {
      return std::fabs(a - b) <= 1e-4 * scale + 1e-9;
    };
    expect(t->fluid == l->fluid && t->solid == l->solid,
           text("totals count ", t->fluid, " + ", t->solid, ", the ledger ", l->fluid, " + ", l->solid));
    expect(near(t->mass, l->mass, t->mass), text("mass ", t->mass, " and ", l->mass));
    expect(near(t->kinetic, l->kinetic, t->kinetic), text("kinetic ", t->kinetic, " and ", l->kinetic));
    const auto p = world_->particles();
    expect(p && p->id.size() == t->fluid + t->solid, "totals and particles count differently");
  }
  /// Readings that stay open while other calls come between.
  void read_later() {
    note("request, take");
    ReadRequest what;
    what.totals = chance(0.5);
    what.pieces = chance(0.5);
    what.particles = chance(0.5);
    const auto ticket = world_->request(what);
    if (ticket) tickets_.push_back(*ticket);
    else
      expect(tickets_.size() == static_cast<std::size_t>(most_readings) || wild_,
             "request failed: " + ticket.error().message);
    if (tickets_.empty() || chance(0.4)) return;
    const std::size_t k = random_.below(static_cast<std::uint32_t>(tickets_.size()));
    const ReadTicket taken = tickets_[k];
    tickets_.erase(tickets_.begin() + static_cast<std::ptrdiff_t>(k));
    expect(bool(world_->ready(taken)), "ready() does not know an open ticket");
    const auto r = world_->take(taken);
    expect(bool(r), "take() failed: " + (r ? std::string() : r.error().message));
    halted_ = halted_ || world_->synchronize().halted;
    for (const double v : {r->totals.mass, r->totals.kinetic, r->totals.thermal, r->ledger.latent,
                           r->result.max_speed, r->result.max_density_ratio})
      expect(finite(v),
             text("a total of a reading is not finite: mass ", r->totals.mass, ", kinetic ",
                  r->totals.kinetic, ", thermal ", r->totals.thermal, ", latent ", r->ledger.latent,
                  ", speed ", r->result.max_speed, ", density ", r->result.max_density_ratio));
    for (const PieceInfo& p : r->pieces)
      expect(p.particles > 0 && p.mass > 0 && finite(p.center) && finite(p.angular_velocity) &&
                 finite(p.bounds.min) && finite(p.bounds.max) && finite(p.orientation.w) &&
                 p.submerged_fraction >= 0 && p.submerged_fraction <= 1.0000001,
             "a piece of a reading is not consistent");
    const ParticleFrame& f = r->particles;
    expect(f.position.size() == f.id.size() && f.piece.size() == f.id.size(), "arrays of a reading differ");
    expect(f.id.empty() || f.id.size() == r->result.fluid + r->result.solid, "a reading lacks particles");
    for (std::size_t i = 0; i < f.id.size(); ++i)
      expect(std::isfinite(f.position[i].x) && std::isfinite(f.temperature[i]) &&
                 std::isfinite(f.density[i]) && material_of(f.tag[i]) < materials_.size(),
             "a particle of a reading is not consistent");
    expect(!world_->take(taken), "a reading was taken twice");
  }
  void read_other() {
    if (chance(0.3)) return read_later();
    switch (random_.below(6)) {
      case 0: {
        note("pieces");
        const auto pieces = world_->pieces();
        expect(bool(pieces), "pieces() failed");
        for (const PieceInfo& p : *pieces)
          expect(p.particles > 0 && p.mass > 0 && finite(p.center) && finite(p.velocity) &&
                     finite(p.temperature_mean) && p.submerged_fraction >= 0 &&
                     p.submerged_fraction <= 1.0000001,
                 "a piece is not consistent");
        return;
      }
      case 1: {
        note("lattice");
        refusable_ = true;
        expect(bool(world_->lattice()), "lattice() failed");
        refusable_ = false;
        return;
      }
      case 2: {
        note("sample");
        const auto v = world_->sample({or_extreme(place(), 0.1), place()},
                                      pick({"temperature", "pressure", "density", "velocity"}));
        if (v) expect(v->size() == 2, "sample gave another number of values");
        else expect(wild_, "sample failed: " + v.error().message);
        return;
      }
      case 3: {
        SurfaceDesc d;
        d.of = pick({SurfaceOf::liquid, SurfaceOf::solids});
        d.cell = or_extreme(0, 0.1);
        if (wild_ && chance(0.1)) d.smoothing = pick({-1, 101, 1 << 30});
        note("surface");
        const auto mesh = world_->surface(d);
        if (!mesh) return expect(wild_, "surface failed: " + mesh.error().message);
        for (const Vec3f& p : mesh->position)
          expect(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "a surface is not finite");
        for (const std::uint32_t k : mesh->triangles)
          expect(k < mesh->position.size(), "a triangle has no such vertex");
        return;
      }
      case 4:
        note("plan, resolved");
        expect(!world_->plan().to_string().empty(), "an empty plan");
        (void)world_->resolved();
        return;
      default:
        read_particles();
    }
  }
  void snapshot_and_restore() {
    note("snapshot, restore");
    const auto hash = world_->state_hash();
    auto bytes = world_->snapshot();
    if (!bytes || !hash) return expect(halted_, "snapshot failed: " + (bytes ? "" : bytes.error().message));
    if (chance(0.4) && !bytes->empty()) {  // a damaged one is refused and changes nothing
      std::vector<std::uint8_t> bad = *bytes;
      if (chance(0.5)) bad.resize(random_.below(static_cast<std::uint32_t>(bad.size())));
      else
        bad[random_.below(static_cast<std::uint32_t>(bad.size()))] ^=
            static_cast<std::uint8_t>(1u << random_.below(8));
      expect(!world_->restore(bad.data(), bad.size()), "a damaged snapshot was taken");
      const auto same = world_->state_hash();
      expect(same && *same == *hash, "a damaged snapshot changed the state");
    }
    if (chance(0.5)) step();
    const Status back = world_->restore(bytes->data(), bytes->size());
    expect(bool(back), "a World refuses its own snapshot: " + (back ? "" : back.error().message));
    const auto after = world_->state_hash();
    expect(after && *after == *hash, "restored with another hash");
    halted_ = false;
  }
  /// What particles have otherwise than they had.
  std::string first_difference(const Result<ParticleData>& was) {
    const auto is = world_->particles();
    if (!was || !is) return {};
    if (was->id != is->id) return ": other particles";
    if (was->tag != is->tag) return ": other tags";
    for (std::size_t i = 0; i < is->id.size(); ++i) {
      const std::string who = text(": of particle ", is->id[i], " of ", is->id.size(), " the ");
      if (length(is->position[i] - was->position[i]) != 0) return who + "position";
      if (length(is->velocity[i] - was->velocity[i]) != 0) return who + "velocity";
      if (is->enthalpy[i] != was->enthalpy[i])
        return text(who, "enthalpy, ", was->enthalpy[i], " -> ", is->enthalpy[i]);
      if (is->mass[i] != was->mass[i]) return who + "mass";
      if (is->piece[i] != was->piece[i]) return who + "piece";
    }
    return ": nothing that particles() shows";
  }
  void save_and_go_back() {
    const int slot =
        wild_ && chance(0.05) ? pick({-1, most_saved_states, 1 << 30}) : static_cast<int>(random_.below(4));
    note("save, load ", slot);
    const auto hash = world_->state_hash();
    refusable_ = halted_;
    const Status saved = guarded_call("save_state", [&] { return world_->save_state(slot); });
    refusable_ = false;
    if (!saved && saved.error().code == ErrorCode::halted) synchronize();
    if (!saved || !hash) return;
    const auto seen = world_->particles();
    step();
    if (chance(0.3)) step();
    const Status back = world_->load_state(slot);
    if (!back) return expect(back.error().message.find("is lost") != std::string::npos, back.error().message);
    const auto after = world_->state_hash();
    expect(after && *after == *hash, "gone back to another hash" + first_difference(seen));
    halted_ = false;
  }
  void feel() {
    if (bodies_.empty()) return;
    const BodyId id = bodies_[random_.below(static_cast<std::uint32_t>(bodies_.size()))];
    const bool on = chance(0.7);
    note("watch_forces ", on);
    refusable_ = true;  // a proxy is always watched
    (void)guarded_call("watch_forces", [&] { return world_->watch_forces(id, on); });
    if (const auto now = world_->proxy(id)) {
      ProxyState s = *now;
      s.position = or_extreme(s.position + random_.vector(0.1 * dx_));
      s.velocity = or_extreme(random_.vector(1));
      s.angular_velocity = or_extreme(random_.vector(1));
      s.teleport = chance(0.2);
      (void)guarded_call("set_proxy", [&] { return world_->set_proxy(id, s); });
      step();
    }
    refusable_ = false;
    const auto forces = world_->take_forces();
    expect(forces || halted_, "take_forces failed: " + (forces ? "" : forces.error().message));
    if (!forces) return;
    for (const BodyForces& f : *forces)
      expect(finite(f.seconds) && finite(length(f.total.linear)) && finite(length(f.total.angular)) &&
                 finite(length(f.pressure.linear)) && finite(length(f.contact.angular)) && finite(f.heat),
             "a force that is no number");
  }
  /// Events, rays, shapes, colours: what is handed out is finite and adds up.
  void look_about() {
    note("look about");
    if (chance(0.4)) {
      EventWatch w;
      w.capacity = wild_ && chance(0.1) ? pick({0u, 0xffffffffu}) : pick({1u, 16u, 4096u});
      w.kinds = wild_ && chance(0.1) ? pick({0u, 1u << 30u})
                : chance(0.5)        ? all_events
                                     : 1u + random_.below(126);
      (void)guarded_call("watch_events", [&] { return world_->watch_events(w); });
      step();
    }
    const auto events = world_->take_events();
    if (events) {
      std::uint64_t all = 0;
      for (const std::uint64_t n : events->counts) all += n;
      expect(all == events->events.size() + events->lost, "events do not add up");
      for (const Event& e : events->events)
        expect(finite(e.time) && finite(length(e.position)) && e.step <= world_->steps(),
               "an event that cannot be");
    }
    if (chance(0.2)) (void)guarded_call("stop_events", [&] { return world_->stop_events(); });
    std::vector<Ray> rays;
    for (int k = 0; k < 3; ++k)
      rays.push_back({or_extreme(place()), or_extreme(random_.vector(1)), infinity});
    if (const auto hits = guarded_call("cast_rays", [&] { return world_->cast_rays(rays); }))
      for (const RayHit& h : *hits)
        expect(h.what == RayTarget::nothing ||
                   (h.distance >= 0 && finite(h.distance) && finite(length(h.normal)) &&
                    std::fabs(length(h.normal) - 1) < 1e-6),
               "a ray that ends nowhere");
    if (const auto o = guarded_call("overlap", [&] { return world_->overlap(shape()); }))
      expect(finite(o->liquid_volume) && o->bodies.size() <= bodies_.size(), "an overlap that cannot be");
    RenderDesc d;
    d.color = pick({ColorBy::nothing, ColorBy::material, ColorBy::temperature});
    d.hottest = or_extreme(50);
    (void)guarded_call("render_view", [&] { return world_->render_view(d); });
  }
  /// A stage of the host: pushes every particle a little, or once makes a velocity no number; on CUDA it does nothing.
  struct Nudge {
    bool acts = true, poison = false;
  };
  static void nudge(const StageContext& c, void* user) {
    auto& what = *static_cast<Nudge*>(user);
    if (c.backend == Backend::cuda || !what.acts) return;  // CUDA: the channels are the device's
    const auto push = [&](auto* acceleration, auto* velocity) {
      for (std::uint64_t i = 0; acceleration && i < c.particles; ++i) acceleration[i].x += 1e-3f;
      if (what.poison && c.particles > 0)
        velocity[c.particles / 2].y = std::numeric_limits<float>::quiet_NaN();
    };
    if (c.precision == Precision::double_precision)
      push(static_cast<Vec3<double>*>(c.acceleration), static_cast<Vec4<double>*>(c.velocity));
    else push(static_cast<Vec3<float>*>(c.acceleration), static_cast<Vec4<float>*>(c.velocity));
    what.poison = false;
  }
  void insert_stage() {
    CustomStage own{"own", nudge, &nudge_, {}, {"acceleration", "velocity"}};
    own.recorded = chance(0.5);
    const char* after =
        pick({"sph.density", "sph.forces", "step.begin", "lsm.gather", "step.integrate", "nonsense"});
    if (wild_ && chance(0.1)) own.writes.push_back("nonsense");
    nudge_.acts = settings_.states == nullptr;  // or on no backend
    note("insert_after ", after, own.recorded ? " recorded" : "");
    const Status in =
        guarded_call("insert_after", [&] { return world_->scheduler().insert_after(after, own); });
    if (in) again([=](World& w) { return bool(w.scheduler().insert_after(after, own)); });
    if (!in || chance(0.3)) return;
    if (wild_ && chance(0.3) && std::string(after) != "step.integrate") {
      note("a velocity that is no number");
      nudge_.poison = true;
    }
    step();
    nudge_.poison = false;
    synchronize();
    if (!chance(0.4)) return;
    if (world_->scheduler().remove("own")) again([](World& w) { return bool(w.scheduler().remove("own")); });
  }
  void schedule() {
    Scheduler& s = world_->scheduler();
    note("schedule");
    refusable_ = true;
    switch (random_.below(4)) {
      case 0: {
        const char* module = pick({"thermal", "topology", "sph", "nonsense"});
        const int n = pick({1, 2, 3, 0, -1, 2147483647});
        if (guarded_call("set_interval", [&] { return s.set_interval(module, n); }))
          again([=](World& w) { return bool(w.scheduler().set_interval(module, n)); });
        break;
      }
      case 1: {
        const bool on = chance(0.7);
        const char* module = pick({"thermal", "topology", "nonsense"});
        if (guarded_call("enable", [&] { return s.enable(module, on); }))
          again([=](World& w) { return bool(w.scheduler().enable(module, on)); });
        break;
      }
      case 2:
        static_cast<void>(s.enable_timings(chance(0.5), chance(0.5) ? 1 : 3));
        break;
      default:
        insert_stage();
    }
    refusable_ = false;
  }

  // --- what a host does between steps -----------------------------------------------------------------------
  double some_step() {
    const double stable = world_->stable_dt();
    return (finite(stable) && stable > 0 ? stable : 1e-3) * random_.uniform(0.1, 1);
  }
  template <class T>
  T& any_of(std::vector<T>& of) {
    return of[random_.below(static_cast<std::uint32_t>(of.size()))];
  }
  void move_about() {
    if (kinematic_.empty()) return;
    const BodyId id = any_of(kinematic_);
    const auto now = world_->motion(id);
    if (!now) return expect(wild_ || halted_, "motion() failed: " + now.error().message);
    expect(now->position && finite(*now->position) && finite(now->velocity) && finite(now->angular_velocity),
           "a motion that is no number");
    const double dt = some_step();
    BodyMotion m;
    if (chance(0.5)) m.position = or_extreme(*now->position + random_.vector(0.1 * dx_), 0.03);
    if (chance(0.4)) {
      const Vec3d turn = random_.vector(0.1);
      const double w = std::sqrt(1 - dot(turn, turn));
      m.orientation = Quat<double>{or_extreme(w, 0.03), turn.x, turn.y, turn.z};
    }
    m.velocity = or_extreme(random_.vector(0.5), 0.03);
    m.angular_velocity = or_extreme(random_.vector(0.5), 0.03);
    m.teleport = m.position && chance(0.2);
    note("set_motion ", id.index, m.position ? " to a place" : "", m.orientation ? " turned" : "",
         m.teleport ? " at once" : "");
    refusable_ = true;  // through a wall, too fast, not clear
    if (guarded_call("set_motion", [&] { return world_->set_motion(id, m); })) {
      moves(length(m.velocity) + length(m.angular_velocity) * length(size_) +
            (m.position ? length(*m.position - *now->position) / dt : 0) +
            (m.orientation ? length(size_) / dt : 0));
      if (!guarded_call("step", [&] { return world_->step(dt); })) {
        (void)guarded_call("set_motion", [&] { return world_->set_motion(id, {}); });
        (void)world_->step(dt);
      }
    }
    refusable_ = false;
    synchronize();
  }
  /// Ids close up, and nothing else changes.
  void forget(const Totals& before) {
    note("compact");
    const auto had = world_->particles();
    const auto was = guarded_call("compact", [&] { return world_->compact(); });
    if (!was) return;
    again_saved([](World& w) { return bool(w.compact()); });
    const auto after = world_->totals();
    const auto data = world_->particles();
    expect(after && after->fluid == before.fluid && after->solid == before.solid,
           "compact() changed what is there");
    if (!had || !data) return;
    bool same = had->id.size() == data->id.size();
    for (std::size_t i = 0; same && i < data->id.size(); ++i)
      same = data->id[i] < was->size() && (*was)[data->id[i]] == had->id[i] &&
             data->mass[i] == had->mass[i] && data->position[i].x == had->position[i].x;
    expect(same, "compact() does not say which particle has which id");
    masses_.clear();
  }
  void take_out() {
    const auto before = world_->totals();
    if (!before) return expect(halted_, "totals() failed");
    refusable_ = true;
    if (chance(0.25)) {
      forget(*before);
    } else if (chance(0.5) && !bodies_.empty()) {
      const BodyId id = any_of(bodies_);
      note("remove body ", id.index);
      if (guarded_call("remove", [&] { return world_->remove(id); })) {
        again_saved([id](World& w) { return bool(w.remove(id)); });
        expect(!world_->remove(id), "a body was removed twice");
        expect(!world_->hold(id) && !world_->watch_forces(id) && !world_->set_velocity(id, {}),
               "the handle of a body that was removed is taken");
        const auto gone = [id](const auto& b) { return b == id; };
        bodies_.erase(std::remove_if(bodies_.begin(), bodies_.end(), gone), bodies_.end());
        kinematic_.erase(std::remove_if(kinematic_.begin(), kinematic_.end(), gone), kinematic_.end());
        meshes_.erase(std::remove_if(meshes_.begin(), meshes_.end(), [&](auto& m) { return m.first == id; }),
                      meshes_.end());
        const auto after = world_->totals();
        expect(after && after->fluid == before->fluid && after->solid <= before->solid,
               "removing a body changed the liquid");
      }
    } else {
      const Shape where = shape();
      note("remove_liquid");
      if (const auto n = guarded_call("remove_liquid", [&] { return world_->remove_liquid(where); })) {
        const auto after = world_->totals();
        expect(after && after->fluid + *n == before->fluid && after->solid == before->solid,
               text("remove_liquid returned ", *n, "; liquid ", before->fluid, " -> ", after->fluid,
                    ", solid ", before->solid, " -> ", after->solid));
      }
    }
    refusable_ = false;
    if (world_->steps() == 0) masses_.clear();
  }
  void steer() {
    refusable_ = true;
    switch (random_.below(8)) {
      case 0: {
        const Vec3d g = or_extreme(chance(0.3) ? Vec3d{} : random_.vector(12));
        note("set_gravity ", g.x, ",", g.y, ",", g.z);
        if (guarded_call("set_gravity", [&] { return world_->set_gravity(g); })) {
          again([g](World& w) { return bool(w.set_gravity(g)); });
          if (length(g) > length(desc_.gravity)) desc_.gravity = g;
        }
        break;
      }
      case 1: {
        const double scale = or_extreme(pick({0.0, 1.0, 1e2, 1e5}));
        note("set_heat_time_scale ", scale);
        if (guarded_call("set_heat_time_scale", [&] { return world_->set_heat_time_scale(scale); }))
          again([=](World& w) { return bool(w.set_heat_time_scale(scale)); });
        break;
      }
      case 2: {
        const int face = wild_ && chance(0.1) ? pick({-1, 6, 1 << 30}) : static_cast<int>(random_.below(6));
        const SurfaceHeatDesc h = surface_heat();
        note("set_wall_heat ", face, " held ", h.temperature.value_or(infinity), " flux ", h.flux,
             " convection ", h.convection, " emissivity ", h.emissivity, " ambient ", h.ambient);
        if (guarded_call("set_wall_heat", [&] { return world_->set_wall_heat(face, h); }))
          again([=](World& w) { return bool(w.set_wall_heat(face, h)); });
        break;
      }
      case 3: {
        const SurfaceHeatDesc h = surface_heat();
        note("set_free_surface_heat");
        if (guarded_call("set_free_surface_heat", [&] { return world_->set_free_surface_heat(h); }))
          again([=](World& w) { return bool(w.set_free_surface_heat(h)); });
        break;
      }
      case 4: {
        if (heat_regions_.empty()) break;
        const HeatRegionId id = any_of(heat_regions_);
        std::optional<double> held;
        if (chance(0.5)) held = or_extreme(random_.uniform(-50, 150));
        const double source = held ? 0 : or_extreme(random_.uniform(-1e5, 1e6));
        note("set_heat_region ", id.index, " held ", held.value_or(nan), " source ", source);
        if (guarded_call("set_heat_region", [&] { return world_->set_heat_region(id, held, source); }))
          again([=](World& w) { return bool(w.set_heat_region(id, held, source)); });
        if (!bodies_.empty() && chance(0.3)) {
          const BodyId body = any_of(bodies_);
          const SurfaceHeatDesc heat = surface_heat();
          const double inside = chance(0.5) ? 0 : or_extreme(random_.uniform(-1e5, 1e6));
          note("set_body_heat ", body.index, " source ", inside);
          if (guarded_call("set_body_heat", [&] { return world_->set_body_heat(body, heat, inside); }))
            again([=](World& w) { return bool(w.set_body_heat(body, heat, inside)); });
        }
        if (!chance(0.5)) break;
        const Vec3d by{or_extreme(random_.uniform(-0.2, 0.2)), random_.uniform(-0.2, 0.2), 0};
        const Vec3d at{random_.uniform(-1, 1), or_extreme(random_.uniform(-1, 1)), 0};
        note("move_heat_region ", id.index, " by ", by.x, " at ", at.y);
        if (guarded_call("move_heat_region", [&] { return world_->move_heat_region(id, by, at); }))
          again([=](World& w) { return bool(w.move_heat_region(id, by, at)); });
        break;
      }
      default:
        push_body();
    }
    refusable_ = false;
  }
  void push_body() {
    if (bodies_.empty()) return;
    const BodyId id = any_of(bodies_);
    switch (random_.below(3)) {
      case 0: {
        const bool on = chance(0.5);
        note("hold ", id.index, " ", on);
        (void)guarded_call("hold", [&] { return world_->hold(id, on); });
        return;
      }
      case 1: {
        const Vec3d v = or_extreme(random_.vector(1)), w = or_extreme(random_.vector(1));
        note("set_velocity ", id.index);
        if (guarded_call("set_velocity", [&] { return world_->set_velocity(id, v, w); }))
          moves(length(v) + length(w) * length(size_));
        return;
      }
      default: {  // of the lightest particle that is drawn: no body gets faster than 1 m/s by it
        const double unit = 300 * dx_ * dx_ * dx_;
        const Vec3d p = or_extreme(random_.vector(unit)), l = or_extreme(random_.vector(unit * dx_));
        note("apply_impulse ", id.index);
        if (guarded_call("apply_impulse", [&] { return world_->apply_impulse(id, p, l); })) moves(20);
      }
    }
  }
  /// A step that may end early is repeated to the bit by as many sub-steps from the same state.
  void step_by_budget() {
    if (halted_) return;
    const double dt = or_extreme(some_step() * pick({1.0, 3.0, 8.0}), 0.03);
    double budget = or_extreme(pick({1e-6, 0.2, 2.0, infinity}), 0.03);
    if (settings_.states != nullptr) budget = infinity;  // what fits into less depends on the machine
    note("step_within ", dt, " s, ", budget, " ms");
    const auto bytes = world_->snapshot();
    const bool saves = chance(0.5) && world_->save_state(15);
    refusable_ = true;
    const auto t = guarded_call("step_within", [&] { return world_->step_within(dt, budget); });
    refusable_ = false;
    synchronize();
    if (!t || !bytes || halted_) return;
    stepped_ += t->simulated;
    expect(t->substeps <= t->planned && (dt == 0 || t->substeps > 0),
           "step_within took no sub-step, or too many");
    expect(std::fabs(t->simulated + t->owed - dt) <= 1e-9 * dt,
           text("simulated ", t->simulated, " and owed ", t->owed, " are not ", dt));
    const auto hash = world_->state_hash();
    const auto was = world_->particles();
    const Status back = saves ? world_->load_state(15) : world_->restore(bytes->data(), bytes->size());
    if (!back && saves) return;  // lost by a change of plan
    expect(bool(back), "a World refuses its own snapshot: " + (back ? "" : back.error().message));
    const auto part = world_->step_part(dt, t->substeps);
    expect(bool(part), "step_part was refused: " + (part ? "" : part.error().message));
    const auto same = world_->state_hash();
    expect(hash && same && *hash == *same, text("step_part differs from the step_within that it repeats",
                                                saves ? ", of a saved state" : "", first_difference(was)));
  }
  /// Nothing but places of liquid may be others afterwards.
  void settle() {
    if (halted_) return;
    const double seconds = chance(0.5) ? automatic : or_extreme(0.01, 0.2);
    note("settle ", seconds, " s");
    const auto was = world_->particles();
    const double time = world_->time();
    refusable_ = true;
    const auto s = guarded_call("settle", [&] { return world_->settle(seconds); });
    refusable_ = false;
    const auto now = world_->particles();
    if (!was || !now) return;
    expect(world_->time() == time, "settle() moved the clock");
    expect(was->id == now->id && was->mass == now->mass && was->tag == now->tag &&
               was->temperature == now->temperature,
           "settle() changed more than places");
    for (std::size_t i = 0; i < now->id.size(); ++i) {
      const double moved = length(now->position[i] - was->position[i]);
      expect(length(now->velocity[i] - was->velocity[i]) == 0, "settle() changed a velocity");
      expect(moved == 0 || (s && is_fluid(now->tag[i])), "settle() moved what it should not");
    }
  }
  void interrupt_and_move() {
    if (chance(0.5)) {
      note("another World object");
      World moved = std::move(*world_);
      world_.emplace(std::move(moved));
      return;
    }
    note("interrupt");
    world_->interrupt();
    const double before = world_->time();
    double dt = some_step();
    Status s = world_->step(dt);
    // A step that is refused was none: the interruption waits for the next one.
    for (int k = 0; k < 8 && !s && s.error().code == ErrorCode::step_too_large; ++k)
      s = world_->step(dt *= 0.01);
    interruption_waits_ = !s && s.error().code != ErrorCode::interrupted;
    if (s || interruption_waits_)
      return expect(wild_ || halted_ || refusable_ || (!s && s.error().message.find("set_motion") == 0),
                    "interrupt() was not heeded" + (s ? "" : ": " + s.error().message));
    expect(world_->time() == before, "a step that was interrupted ahead of its first sub-step took time");
  }
  void probe() {
    if (probes_ == 0 || chance(0.4)) {
      ProbeDesc d;
      d.kind = pick({ProbeKind::point, ProbeKind::level, ProbeKind::force, ProbeKind::heat, ProbeKind::flux});
      d.every = or_extreme(pick({0.0, 1e-4, 0.01}), 0.05);
      d.until = chance(0.8) ? infinity : or_extreme(random_.uniform(0, 0.3), 0.1);
      if (d.kind == ProbeKind::point || d.kind == ProbeKind::level || d.kind == ProbeKind::flux)
        d.points = {or_extreme(place(), 0.05)};
      if (d.kind == ProbeKind::point) d.fields = {"temperature", "pressure", "velocity", "liquid_fraction"};
      if (d.kind == ProbeKind::force) d.fields = {"force", "moment", "contact_force"};
      if (d.kind == ProbeKind::flux) {
        d.fields = {"mass_flux", "volume_flux"};
        d.normal = or_extreme(random_.vector(1), 0.05);
        d.radius = or_extreme(dx_ * random_.uniform(1, 4), 0.05);
      }
      if (d.kind == ProbeKind::force || d.kind == ProbeKind::heat) {
        if (!bodies_.empty() && chance(0.6)) d.body = any_of(bodies_);
        else d.wall = static_cast<int>(random_.below(6));
      }
      note("add_probe kind ", int(d.kind));
      refusable_ = true;
      const auto id = guarded_call("add_probe", [&] { return world_->add_probe(d); });
      refusable_ = false;
      if (id) {
        ++probes_;
        again_saved([d](World& w) { return bool(w.add_probe(d)); });
      }
      return;
    }
    note("take_samples");
    const auto series = world_->take_samples();
    expect(bool(series), "take_samples failed: " + (series ? "" : series.error().message));
    expect(series->size() == static_cast<std::size_t>(probes_), "a probe has no series");
    for (const ProbeSeries& p : *series) {
      expect(p.values.size() == p.time.size() * p.points * p.width, "samples lack values");
      for (std::size_t k = 0; k < p.time.size(); ++k)
        // A clock that one step of an empty World set to 1e12 s does not tell sub-steps of 1e-5 s apart.
        expect(finite(p.time[k]) && p.time[k] <= world_->time() &&
                   (k == 0 || p.time[k] > p.time[k - 1] ||
                    (wild_ && p.time[k] == p.time[k - 1] && p.time[k] > 1e6)),
               "times of samples do not ascend");
      for (const double v : p.values) expect(!std::isinf(v), "a sample is infinite");
    }
  }
  /// What was added and set, for a World of its own. False: it was refused there.
  void again(std::function<bool(World&)> call) { builds_.emplace_back(std::move(call), true); }
  /// The same of what save() has of it.
  void again_saved(std::function<bool(World&)> call) { builds_.emplace_back(std::move(call), false); }
  /// Another World, built as this one was, takes its snapshot and goes on with the same bits.
  void twin() {
    if (halted_ || deformed_ || interruption_waits_) return;
    note("twin");
    auto other = World::create(made_from_);
    expect(bool(other), "the same description is refused the second time");
    for (const auto& [build, scenery] : builds_)
      if (!build(*other)) return;  // its place is taken there: bodies of this World have moved meanwhile
    const auto bytes = world_->snapshot();
    const auto hash = world_->state_hash();
    if (!bytes || !hash) return expect(halted_, "snapshot failed: " + (bytes ? "" : bytes.error().message));
    const Status taken = other->restore(bytes->data(), bytes->size());
    if (!taken) return expect(wild_, "a World built alike refuses the snapshot: " + taken.error().message);
    go_on_with(*other, *hash);
  }
  /// Another World, with materials, emitters and settings alone, loads what this one saves, sometimes damaged before, and goes on with
  /// the same bits.
  void heir() {
    if (halted_ || interruption_waits_) return;
    note("heir");
    auto other = World::create(made_from_);
    expect(bool(other), "the same description is refused the second time");
    for (const auto& [build, scenery] : builds_)
      if (scenery && !build(*other)) return;
    const auto bytes = world_->save();
    const auto hash = world_->state_hash();
    if (!bytes || !hash) return expect(halted_, "save failed: " + (bytes ? "" : bytes.error().message));
    auto bad = *bytes;
    bad[random_.below(static_cast<std::uint32_t>(bad.size()))] ^= 1u << random_.below(8);
    expect(!other->load_saved(bad.data(), bad.size()), "a damaged saved World was taken");
    const Status taken = other->load_saved(bytes->data(), bytes->size());
    if (!taken) return expect(wild_, "a World refuses a saved one: " + taken.error().message);
    go_on_with(*other, *hash);
  }
  void go_on_with(World& other, std::uint64_t hash) {
    const auto there = other.state_hash();
    expect(there && *there == hash, "restored in another World with another hash");
    for (int k = 0; k < 3; ++k) {
      const double dt = some_step();
      const Status a = world_->step(dt), b = other.step(dt);
      expect(a.ok() == b.ok(), "the World built alike " + (b ? std::string("steps") : b.error().message) +
                                   ", this one " + (a ? std::string("steps") : a.error().message));
      if (a) stepped_ += dt;
    }
    synchronize();
    const StepResult r = other.synchronize();
    expect(r.halted == halted_, "of two Worlds built alike one halts");
    const auto first = world_->state_hash(), second = other.state_hash();
    expect(
        first && second && *first == *second,
        "two Worlds built alike go on differently from one snapshot" + first_difference(other.particles()));
  }

  void any_call() {
    const double what = random_.uniform();
    if (what < 0.10) add_material();
    else if (what < 0.12) change_material();
    else if (what < 0.21) add_fluid();
    else if (what < 0.31) add_solid();
    else if (what < 0.34) add_emitter();
    else if (what < 0.36) set_emitter();
    else if (what < 0.39) add_heat_region();
    else if (what < 0.56) step_some();
    else if (what < 0.61) read_totals();
    else if (what < 0.67) read_other();
    else if (what < 0.70) snapshot_and_restore();
    else if (what < 0.725) save_and_go_back();
    else if (what < 0.74) feel();
    else if (what < 0.755) deform();
    else if (what < 0.77) look_about();
    else if (what < 0.785) push_about();
    else if (what < 0.81) schedule();
    else if (what < 0.85) move_about();
    else if (what < 0.87) take_out();
    else if (what < 0.88) take_out_region_or_probe();
    else if (what < 0.92) steer();
    else if (what < 0.94) step_by_budget();
    else if (what < 0.95) interrupt_and_move();
    else if (what < 0.97) probe();
    else if (what < 0.978) twin();
    else if (what < 0.985) heir();
    else if (stepped_ == 0 && what < 0.992) {
      settle();
    } else {
      note("prepare");
      const Status s = world_->prepare();
      expect(s || wild_, "prepare failed: " + (s ? "" : s.error().message));
    }
  }
  /// A line on what a host can see, for another run of the case. Totals are left out: where particles were taken out, nothing
  /// says in which order they are summed.
  void say_state() {
    if (settings_.states == nullptr || halted_) return;
    const StepResult r = world_->synchronize();
    const auto hash = world_->state_hash();
    const auto p = world_->particles();
    const auto pieces = world_->pieces();
    if (!hash || !p || !pieces) return;
    std::string line =
        text(item_, " ", std::strtok(std::string(progress_.what).data(), " "), " steps ", r.steps);
    const auto add = [&](const char* name, const void* data, std::size_t bytes) {
      std::uint64_t h = 1469598103934665603u;  // FNV-1a
      for (std::size_t k = 0; k < bytes; ++k)
        h = (h ^ static_cast<const std::uint8_t*>(data)[k]) * 1099511628211u;
      line += text(" ", name, " ", std::hex, h);
    };
    const auto all = [&](const char* name, const auto& values) {
      add(name, values.data(), values.size() * sizeof(values[0]));
    };
    const double stable = world_->stable_dt();
    add("state", &*hash, sizeof *hash);
    add("time", &r.time, sizeof r.time);
    add("stable_dt", &stable, sizeof stable);
    all("id", p->id);
    all("position", p->position);
    all("velocity", p->velocity);
    all("enthalpy", p->enthalpy);
    all("density", p->density);
    all("pressure", p->pressure);
    all("tag", p->tag);
    all("piece", p->piece);
    for (const auto& w : p->fractions) all("fraction", w);
    for (const PieceInfo& q : *pieces) {
      const double said[] = {q.mass,         q.center.x,         q.center.y,           q.center.z,
                             q.velocity.x,   q.orientation.w,    q.angular_velocity.x, q.inertia.m[0][0],
                             q.bounds.min.x, q.temperature_mean, q.submerged_fraction};
      add("piece", said, sizeof said);
    }
    std::fprintf(settings_.states, "%s\n", line.c_str());
    std::fflush(settings_.states);
  }
  void close() {
    synchronize();
    if (halted_) return;
    read_totals();
    read_particles();
  }

  Random random_;
  const std::uint64_t item_;
  const std::uint64_t reserved_;  ///< room for liquid that is added later
  const Settings& settings_;
  fuzz::Progress& progress_;
  const bool wild_;
  std::optional<World> world_;
  WorldDesc desc_, made_from_;  ///< the first with the largest gravity so far
  double dx_ = 0.1, speed_scale_ = 0, stepped_ = 0;
  Vec3d size_, low_;
  std::vector<MaterialId> materials_, liquids_, solids_, species_;
  std::vector<BodyId> bodies_, kinematic_;
  std::vector<HeatRegionId> heat_regions_;
  std::vector<HeatRegionId> gone_regions_;  ///< those of them that were removed
  std::vector<std::pair<std::function<bool(World&)>, bool>> builds_;
  int probes_ = 0;
  Nudge nudge_;
  std::vector<std::pair<BodyId, std::vector<Vec3d>>> meshes_;  ///< bodies that deform, and their corners
  std::vector<std::pair<EmitterId, EmitterDesc>> emitters_;
  std::vector<ForceFieldId> fields_;  ///< removed ones included
  std::map<std::uint32_t, double> masses_;
  std::vector<ReadTicket> tickets_;
  Vec3d inwards_;  ///< from an open face that has no outlet
  bool interruption_waits_ =
      false;  ///< the steps that it was for were refused, as where a body comes to a wall
  bool halted_ = false, emits_ = false, refusable_ = false, deformed_ = false;
  std::string trace_;
};

}  // namespace

int main(int argc, char** argv) { return fuzz::run_sequences<Sequence>(argc, argv); }
