// SPDX-License-Identifier: Apache-2.0
// Random sequences of calls of the C interface, seeded by the number of the case, with right and with wrong arguments: null pointers,
// sizes of other headers, handles of other Worlds, numbers that are none, buffers that are too small. Each is made of World, too: both
// take it, or both refuse it with one text, and have one state then. What is refused has a text and changes nothing. Structs
// lie in memory of exactly the size that they say, so that a sanitizer finds what is touched beyond it.
//
//   meltsim_c_fuzz --cases 200
//   meltsim_c_fuzz --first 4711 --cases 1 --trace 1     # one case again, with its calls
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "calls_main.hpp"
#include "meltsim/meltsim.h"
#include "meltsim/meltsim.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using fuzz::Settings;
using fuzz::Violation;
using test_support::Random;

const double nan = std::numeric_limits<double>::quiet_NaN();

/// A struct in memory of its own of exactly the size that it says, with a mark behind it that nothing may change.
template <class D>
class Sized {
 public:
  Sized(const D& d, std::uint32_t size) : bytes_(size + sizeof mark), size_(size) {
    D copy = d;
    copy.size = size;
    std::memcpy(bytes_.data(), &copy, std::min<std::size_t>(size, sizeof copy));
    std::memcpy(bytes_.data() + size, mark, sizeof mark);
  }
  D* get() { return reinterpret_cast<D*>(bytes_.data()); }
  bool intact() const { return std::memcmp(bytes_.data() + size_, mark, sizeof mark) == 0; }
  /// What the library knows of it: the rest is what it was initialised with.
  D known(const D& defaults) const {
    D d = defaults;
    std::memcpy(static_cast<void*>(&d), bytes_.data(), std::min<std::size_t>(size_, sizeof d));
    return d;
  }

 private:
  static constexpr unsigned char mark[8] = {0xa5, 0x5a, 0xc3, 0x3c, 0x96, 0x69, 0xf0, 0x0f};
  std::vector<unsigned char> bytes_;
  std::uint32_t size_;
};

Vec3d vec(const double v[3]) { return {v[0], v[1], v[2]}; }
void put(double to[3], Vec3d v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }

/// An object of both Worlds: the C World's, and its like in the other.
struct Thing {
  meltsim_id c{};
  std::uint32_t index = 0, generation = 0;
  template <class Id>
  Id id() const {
    return {index, generation};
  }
};

struct ShapeDelete {
  void operator()(meltsim_shape* s) const { meltsim_shape_destroy(s); }
};
struct WorldDelete {
  void operator()(meltsim_world* w) const { meltsim_world_destroy(w); }
};
struct ReadingDelete {
  void operator()(meltsim_reading* r) const { meltsim_reading_destroy(r); }
};
struct SurfaceDelete {
  void operator()(meltsim_surface* s) const { meltsim_surface_destroy(s); }
};
struct BothShapes {
  std::unique_ptr<meltsim_shape, ShapeDelete> c;
  Shape cpp;
};

class Sequence {
 public:
  Sequence(std::uint64_t item, const Settings& settings, fuzz::Progress& progress)
      : random_(static_cast<std::uint32_t>(item * 2654435761u + 29u)),
        settings_(settings),
        progress_(progress),
        wild_(item % 2 == 1) {}

  std::string run() {
    try {
      create();
      if (!c_) return {};
      nothing_given();
      for (int k = 12 + static_cast<int>(random_.below(25)); k > 0; --k) any_call();
      same_state();
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
  template <class T>
  T pick(std::initializer_list<T> of) {
    return *(of.begin() + random_.below(static_cast<std::uint32_t>(of.size())));
  }
  double wrong() { return pick({nan, infinity, -infinity, -1.0, 1e300, -1e300, 1e-300, 0.0}); }
  double number(double v, double p = 0.04) { return wild_ && chance(p) ? wrong() : v; }
  Vec3d vector(Vec3d v, double p = 0.04) {
    if (wild_ && chance(p)) (&v.x)[random_.below(3)] = wrong();
    return v;
  }
  std::int32_t choice(int count) {
    return wild_ && chance(0.05)
               ? pick({-1, count, 1 << 30})
               : static_cast<std::int32_t>(random_.below(static_cast<std::uint32_t>(count)));
  }
  Thing thing(const std::vector<Thing>& of) {
    const double what = wild_ ? random_.uniform() : 1;
    if (what < 0.03 || of.empty()) return {};
    if (what < 0.06) return {{77, 1}, 77, 1};
    const Thing& t = of[random_.below(static_cast<std::uint32_t>(of.size()))];
    if (what < 0.09) return {{t.index, t.generation}, t.c.index, t.c.generation};  // the other World's
    return t;
  }

  // --- reporting --------------------------------------------------------------------------------------------
  template <class... Parts>
  std::string text(const Parts&... parts) {
    std::ostringstream out;
    (out << ... << parts);
    return out.str();
  }
  void note(const std::string& said) {
    trace_ += (trace_.empty() ? "" : "; ") + said;
    if (settings_.trace) std::printf("  %s\n", said.c_str()), std::fflush(stdout);
    std::snprintf(progress_.what, sizeof progress_.what, "%s", said.c_str());
    progress_.calls = progress_.calls + 1;
  }
  [[noreturn]] void violate(const std::string& what) { throw Violation{what}; }
  void expect(bool holds, const std::string& what) {
    if (!holds) violate(what);
  }

  // --- both interfaces ----------------------------------------------------------------------------------------
  /// Handles of the two Worlds differ in the generation.
  static std::string plain(std::string s) {
    for (const char* word : {"generation ", " ms"}) {
      for (std::size_t at = s.find(word); at != std::string::npos; at = s.find(word, at + 1)) {
        std::size_t end = at + std::strlen(word);
        while (end < s.size() && std::isdigit(static_cast<unsigned char>(s[end])) != 0) ++end;
        s.replace(at, end - at, word);
      }
    }
    return s;
  }
  struct Seen {
    std::vector<std::uint8_t> snapshot;
    std::uint64_t hash = 0, steps = 0;
    double time = 0;
    bool operator==(const Seen& o) const {
      return snapshot == o.snapshot && hash == o.hash && steps == o.steps && time == o.time;
    }
  };
  Seen see() {
    Seen s;
    std::size_t bytes = 0;
    const meltsim_status asked = meltsim_world_snapshot(c_.get(), nullptr, 0, &bytes);
    if (asked == MELTSIM_CAPACITY) {
      s.snapshot.resize(bytes);
      expect(meltsim_world_snapshot(c_.get(), s.snapshot.data(), bytes, &bytes) == MELTSIM_OK,
             "a snapshot into room for it was refused");
    }
    (void)meltsim_world_state_hash(c_.get(), &s.hash);
    s.steps = meltsim_world_steps(c_.get());
    s.time = meltsim_world_time(c_.get());
    return s;
  }
  void unchanged(const Seen& before, const std::string& said) {
    const Seen now = see();
    if (now == before) return;
    const std::size_t size = std::min(before.snapshot.size(), now.snapshot.size());
    std::size_t alike = 0;
    while (alike < size && before.snapshot[alike] == now.snapshot[alike]) ++alike;
    violate(text(said, " (snapshot ", before.snapshot.size(), " to ", now.snapshot.size(),
                 " bytes, alike up to ", alike, "; hash ", before.hash == now.hash ? "the same" : "another",
                 "; steps ", before.steps, " to ", now.steps, ")"));
  }
  void failed(const char* name, meltsim_status status) {
    expect(status >= MELTSIM_INVALID_ARGUMENT && status <= MELTSIM_INTERNAL,
           text(name, ": returned ", status, ", which is no kind of error"));
    expect(meltsim_error_text()[0] != '\0', text(name, ": an error without a text"));
    if (settings_.trace) std::printf("    refused: %s\n", meltsim_error_text());
    expect(status != MELTSIM_INTERNAL, text(name, ": an error of the library: ", meltsim_error_text()));
  }
  /// Both interfaces take a call, or refuse it with one text. Returns whether they took it.
  template <class C, class Cpp>
  bool both(const char* name, const C& c, const Cpp& cpp) {
    note(name);
    Seen before;
    const bool watched = chance(0.4);
    if (watched) before = see();
    const meltsim_status status = c();
    const std::string said = status != MELTSIM_OK ? meltsim_error_text() : "";
    if (status != MELTSIM_OK) failed(name, status);
    const auto result = cpp();
    const int there = result ? 0 : static_cast<int>(result.error().code) + 1;
    if (status != there)
      violate(text(name, ": C returned ", status, " (", said, "), C++ ", there, " (",
                   result ? "" : result.error().message, ")"));
    if (status == MELTSIM_OK) return true;
    expect(plain(said) == plain(result.error().message),
           text(name, ": C says \"", said, "\", C++ \"", result.error().message, "\""));
    // What was interrupted has begun.
    if (watched && status != MELTSIM_INTERRUPTED)
      unchanged(before, text(name, " was refused and changed something: ", said));
    return false;
  }
  /// A call that C refuses before World is asked.
  template <class C>
  void refused(const char* name, const C& c, meltsim_status with = MELTSIM_INVALID_ARGUMENT) {
    note(text(name, " (wrong)"));
    Seen before;
    const bool watched = chance(0.2);
    if (watched) before = see();
    const meltsim_status status = c();
    if (status != with) violate(text(name, ": returned ", status, " and not ", with));
    failed(name, status);
    if (watched) unchanged(before, text(name, " was refused and changed something"));
  }
  /// A size that the struct may have had in an older header.
  template <class D>
  std::uint32_t smaller() {
    constexpr auto step = static_cast<std::uint32_t>(alignof(D)), all = static_cast<std::uint32_t>(sizeof(D));
    return step * (1 + random_.below(all / step));
  }
  /// Sizes that it has in no header.
  template <class D>
  std::uint32_t no_size() {
    constexpr auto all = static_cast<std::uint32_t>(sizeof(D));
    return pick({0u, 3u, all - 1u, all - 4u, all + 8u, 0xffffffffu});
  }
  /// A call with a struct: of this size, at times of a smaller one, or of none that there is.
  template <class D, class C, class Cpp>
  bool described(const char* name, const D& d, const D& defaults, const C& c, const Cpp& cpp) {
    if (chance(0.06)) refused(name, [&] { return c(static_cast<D*>(nullptr)); });
    if (chance(0.06)) {
      Sized<D> bad(d, sizeof(D) + 8);
      bad.get()->size = no_size<D>();
      refused(name, [&] { return c(bad.get()); });
    }
    Sized<D> given(d, chance(0.15) ? smaller<D>() : static_cast<std::uint32_t>(sizeof(D)));
    const D known = given.known(defaults);
    return both(
        name, [&] { return c(given.get()); }, [&] { return cpp(known); });
  }
  /// A struct that the library fills, of this size or a smaller one. Returns what it holds then.
  template <class D, class C>
  D filled(const char* name, const C& c, meltsim_status& status) {
    if (chance(0.06)) refused(name, [&] { return c(static_cast<D*>(nullptr)); });
    if (chance(0.06)) {
      Sized<D> bad(D{}, sizeof(D) + 8);
      bad.get()->size = no_size<D>();
      refused(name, [&] { return c(bad.get()); });
    }
    Sized<D> to(D{}, chance(0.15) ? smaller<D>() : static_cast<std::uint32_t>(sizeof(D)));
    note(name);
    status = c(to.get());
    if (status != MELTSIM_OK) failed(name, status);
    expect(to.intact(), text(name, ": wrote beyond the size of the struct"));
    return to.known(D{});
  }
  void same_state() {
    std::uint64_t hash = 0;
    const meltsim_status status = meltsim_world_state_hash(c_.get(), &hash);
    const auto there = cpp_->state_hash();
    expect((status == MELTSIM_OK) == bool(there), "one interface has a hash, the other has none");
    expect(!there || hash == *there, "the two interfaces have come to different states");
    expect(meltsim_world_time(c_.get()) == cpp_->time() && meltsim_world_steps(c_.get()) == cpp_->steps(),
           "the two interfaces have come to different times");
  }

  // --- the Worlds -------------------------------------------------------------------------------------------
  static SurfaceHeatDesc heat_of(const meltsim_surface_heat& c) {
    SurfaceHeatDesc d;
    if (c.has_temperature != 0) d.temperature = c.temperature;
    d.flux = c.flux, d.convection = c.convection, d.emissivity = c.emissivity, d.ambient = c.ambient;
    return d;
  }
  meltsim_surface_heat surface_heat() {
    meltsim_surface_heat s{};
    s.ambient = 20;
    if (chance(0.5)) return s;
    s.has_temperature = chance(0.3) ? 1 : 0;
    s.temperature = number(40);
    if (s.has_temperature == 0) s.flux = number(1e3), s.convection = number(50), s.emissivity = number(0.5);
    return s;
  }
  void create() {
    meltsim_world_desc d;
    meltsim_world_desc_init(&d);
    d.backend = settings_.backend == Backend::cuda ? MELTSIM_BACKEND_CUDA : MELTSIM_BACKEND_CPU;
    d.threads = 1;
    d.spacing = dx;
    d.double_precision = chance(0.3) ? 1 : 0;
    d.bounded = chance(0.8) ? 1 : 0;
    put(d.domain_max, {10 * dx, 12 * dx, 10 * dx});
    d.heat_time_scale = pick({0.0, 1.0, 1e4});
    d.reserved_particles = pick({0u, 300u});
    d.neighbour_search = pick({MELTSIM_SEARCH_AUTOMATIC, MELTSIM_SEARCH_TREE});
    d.wall_heat[2] = surface_heat();
    if (d.bounded == 0) d.wall_heat[2] = {0, 0, 0, 0, 0, 0, 20};
    d.faces[3] = chance(0.3) ? MELTSIM_FACE_OPEN : MELTSIM_FACE_WALL;
    if (d.faces[3] == MELTSIM_FACE_OPEN) d.wall_heat[3] = {0, 0, 0, 0, 0, 0, 20};
    d.faces[0] = d.bounded != 0 && chance(0.4) ? MELTSIM_FACE_OPEN : MELTSIM_FACE_WALL;
    d.courant = number(0.4), d.density_error = number(0), d.spacing = number(d.spacing, 0.02);
    put(d.gravity, vector({0, -9.81, 0}, 0.03));
    d.isotropic_pressure = choice(3);
    d.viscosity = choice(3), d.stray = choice(2);
    d.hydrostatic_start = chance(0.7) ? 1 : 0;
    if (d.isotropic_pressure == MELTSIM_CHOICE_ON) d.artificial_viscosity = 0.05;
    create_both(d);
  }
  void create_both(const meltsim_world_desc& d) {
    note("create");
    meltsim_world* world = reinterpret_cast<meltsim_world*>(&world);  // anything but null
    expect(meltsim_world_create(nullptr, &world) == MELTSIM_INVALID_ARGUMENT && world == nullptr,
           "a World of no description");
    expect(meltsim_world_create(&d, nullptr) == MELTSIM_INVALID_ARGUMENT, "a World that is put nowhere");
    const meltsim_status status = meltsim_world_create(&d, &world);
    WorldDesc w;
    w.backend = settings_.backend;
    w.threads = 1;
    w.spacing = d.spacing;
    w.precision = d.double_precision != 0 ? Precision::double_precision : Precision::single_precision;
    w.domain.bounded = d.bounded != 0;
    w.domain.max = vec(d.domain_max);
    w.domain.heat[2] = heat_of(d.wall_heat[2]);
    if (d.faces[3] == MELTSIM_FACE_OPEN) w.domain.faces[3] = Face::open;
    if (d.faces[0] == MELTSIM_FACE_OPEN) w.domain.faces[0] = Face::open;
    w.heat.time_scale = d.heat_time_scale;
    w.reserved_particles = d.reserved_particles;
    w.hydrostatic_start = d.hydrostatic_start != 0;
    if (d.neighbour_search == MELTSIM_SEARCH_TREE) w.neighbour_search = NeighbourSearch::tree;
    w.courant = d.courant, w.density_error = d.density_error, w.gravity = vec(d.gravity);
    if (d.isotropic_pressure != MELTSIM_CHOICE_AUTOMATIC)
      w.isotropic_pressure = d.isotropic_pressure == MELTSIM_CHOICE_ON;
    w.viscosity = static_cast<Viscosity>(d.viscosity), w.stray = static_cast<Stray>(d.stray);
    const auto off = [](std::int32_t v, int most) { return v < 0 || v > most; };
    if (off(d.isotropic_pressure, 2) || off(d.viscosity, 2) || off(d.stray, 1)) {
      expect(status == MELTSIM_INVALID_ARGUMENT && world == nullptr, "a choice that there is not was taken");
      return;
    }
    const std::string said = status != MELTSIM_OK ? meltsim_error_text() : "";
    meltsim_world* other = nullptr;
    Sized<meltsim_world_desc> old(d, sizeof d);
    old.get()->version = 1;
    expect(meltsim_world_create(old.get(), &other) == MELTSIM_VERSION_MISMATCH && other == nullptr,
           "a World of another version");
    auto made = World::create(w);
    if ((status == MELTSIM_OK) != bool(made) || (world != nullptr) != bool(made))
      violate(text("C made a World: ", status == MELTSIM_OK, ", C++: ", bool(made), " ", said));
    if (!made) return expect(said == made.error().message, "create: C says \"" + said + "\"");
    c_.reset(world);
    cpp_ = std::make_unique<World>(std::move(*made));
  }

  /// Every call without its World or its object, and with nothing else.
  void nothing_given() {
    note("null everywhere");
    const auto none = [this](const char* name, meltsim_status status) {
      if (status != MELTSIM_INVALID_ARGUMENT) violate(text(name, " of nothing returned ", status));
      failed(name, status);
    };
    const double v[3] = {0, 0, 0};
#define OF_NOTHING(call, ...) none(#call, call(__VA_ARGS__))
    OF_NOTHING(meltsim_shape_box, v, v, nullptr);
    OF_NOTHING(meltsim_shape_sphere, v, 1, nullptr);
    OF_NOTHING(meltsim_shape_capsule, v, v, 1, nullptr);
    OF_NOTHING(meltsim_shape_cylinder, v, v, 1, nullptr);
    OF_NOTHING(meltsim_shape_mesh, nullptr, 3, nullptr, 1, nullptr);
    OF_NOTHING(meltsim_shape_file, nullptr, nullptr);
    OF_NOTHING(meltsim_shape_unite, nullptr, nullptr, nullptr);
    OF_NOTHING(meltsim_shape_subtract, nullptr, nullptr, nullptr);
    OF_NOTHING(meltsim_shape_intersect, nullptr, nullptr, nullptr);
    OF_NOTHING(meltsim_shape_torus, v, v, 1, 1, nullptr);
    OF_NOTHING(meltsim_shape_blend, v, v, 1, 0, nullptr);
    OF_NOTHING(meltsim_shape_transform, nullptr, v, v, 1, 1, nullptr);
    meltsim_shape* shape = nullptr;
    OF_NOTHING(meltsim_shape_torus, nullptr, nullptr, 1, 1, &shape);
    OF_NOTHING(meltsim_shape_blend, nullptr, nullptr, 1, 0, &shape);
    OF_NOTHING(meltsim_shape_transform, nullptr, nullptr, nullptr, 1, 1, &shape);
    OF_NOTHING(meltsim_shape_box, nullptr, v, &shape);
    OF_NOTHING(meltsim_shape_sphere, nullptr, 1, &shape);
    OF_NOTHING(meltsim_shape_mesh, nullptr, 3, nullptr, 1, &shape);
    OF_NOTHING(meltsim_shape_unite, nullptr, nullptr, &shape);
    OF_NOTHING(meltsim_world_create, nullptr, nullptr);
    meltsim_world* const worlds[] = {nullptr, c_.get()};
    for (meltsim_world* w : worlds) {
      OF_NOTHING(meltsim_world_add_material, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_add_fluid, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_add_species, w, nullptr, nullptr, nullptr);
      OF_NOTHING(meltsim_world_add_mixture, w, nullptr, nullptr, nullptr, 0, nullptr);
      OF_NOTHING(meltsim_world_add_solid, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_add_emitter, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_add_mixture_emitter, w, nullptr, nullptr, nullptr, 1, nullptr);
      OF_NOTHING(meltsim_world_add_heat_region, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_add_force_field, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_add_probe, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_set_motion, w, {}, nullptr);
      OF_NOTHING(meltsim_world_motion, w, {}, nullptr);
      OF_NOTHING(meltsim_world_update_mesh, w, {}, nullptr, nullptr, 3);
      OF_NOTHING(meltsim_world_set_proxy, w, {}, nullptr);
      OF_NOTHING(meltsim_world_proxy, w, {}, nullptr);
      OF_NOTHING(meltsim_world_watch_forces, w, {}, 1);
      OF_NOTHING(meltsim_world_set_material, w, {}, nullptr);
      OF_NOTHING(meltsim_world_set_gravity, w, nullptr);
      OF_NOTHING(meltsim_world_hold, w, {}, 1);
      OF_NOTHING(meltsim_world_set_velocity, w, {}, nullptr, nullptr);
      OF_NOTHING(meltsim_world_apply_impulse, w, {}, nullptr, nullptr);
      OF_NOTHING(meltsim_world_set_wall_heat, w, 0, nullptr);
      OF_NOTHING(meltsim_world_set_free_surface_heat, w, nullptr);
      OF_NOTHING(meltsim_world_set_heat_region, w, {}, nullptr, 0);
      OF_NOTHING(meltsim_world_move_heat_region, w, {}, nullptr, nullptr);
      OF_NOTHING(meltsim_world_set_body_heat, w, meltsim_id{}, nullptr, 0);
      OF_NOTHING(meltsim_world_set_force_field, w, {}, nullptr);
      OF_NOTHING(meltsim_world_remove_force_field, w, {});
      OF_NOTHING(meltsim_world_set_emitter, w, {}, nullptr);
      OF_NOTHING(meltsim_world_remove, w, {});
      OF_NOTHING(meltsim_world_remove_liquid, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_synchronize, w, nullptr);
      OF_NOTHING(meltsim_world_totals, w, nullptr);
      OF_NOTHING(meltsim_world_take_forces, w, nullptr, 0, 0, nullptr);
      OF_NOTHING(meltsim_world_take_events, w, nullptr, 0, 0, nullptr, nullptr);
      OF_NOTHING(meltsim_world_request, w, 0, nullptr);
      OF_NOTHING(meltsim_world_ready, w, 0, nullptr);
      OF_NOTHING(meltsim_world_take, w, 0, nullptr);
      OF_NOTHING(meltsim_world_particles, w, nullptr);
      OF_NOTHING(meltsim_world_fractions, w, {}, nullptr, 0, nullptr);
      OF_NOTHING(meltsim_world_sample, w, nullptr, 1, nullptr, nullptr);
      OF_NOTHING(meltsim_world_cast_rays, w, nullptr, 1, MELTSIM_RAY_ALL, nullptr, sizeof(meltsim_ray_hit));
      OF_NOTHING(meltsim_world_liquid_in, w, nullptr, nullptr, nullptr);
      OF_NOTHING(meltsim_world_bodies_in, w, nullptr, nullptr, nullptr, 0, nullptr);
      OF_NOTHING(meltsim_world_surface, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_render_view, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_check_view, w, nullptr);
      OF_NOTHING(meltsim_world_surface_view, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_check_surface_view, w, nullptr);
      OF_NOTHING(meltsim_world_device_state, w, nullptr);
      OF_NOTHING(meltsim_world_check_device_state, w, nullptr);
      OF_NOTHING(meltsim_world_add_stage, w, nullptr);
      OF_NOTHING(meltsim_world_remove_stage, w, nullptr);
      OF_NOTHING(meltsim_world_set_interval, w, nullptr, 1);
      OF_NOTHING(meltsim_world_interval, w, nullptr, nullptr);
      OF_NOTHING(meltsim_world_enable, w, nullptr, 0);
      OF_NOTHING(meltsim_world_wait_for, w, nullptr);
      OF_NOTHING(meltsim_world_signal, w, nullptr);
      OF_NOTHING(meltsim_world_snapshot, w, nullptr, 0, nullptr);
      OF_NOTHING(meltsim_world_restore, w, nullptr, 0);
      OF_NOTHING(meltsim_world_save, w, nullptr, 0, nullptr);
      OF_NOTHING(meltsim_world_remove_heat_region, w, meltsim_id{});
      OF_NOTHING(meltsim_world_remove_probe, w, meltsim_id{});
      OF_NOTHING(meltsim_world_load_saved, w, nullptr, 0);
      OF_NOTHING(meltsim_world_bodies, w, nullptr, 0, 0, nullptr);
      OF_NOTHING(meltsim_world_state_hash, w, nullptr);
    }
    OF_NOTHING(meltsim_world_prepare, nullptr);
    OF_NOTHING(meltsim_world_compact, nullptr, nullptr, nullptr);
    OF_NOTHING(meltsim_world_step, nullptr, 0.01);
    OF_NOTHING(meltsim_world_settle, nullptr, 0, nullptr);
    OF_NOTHING(meltsim_world_step_within, nullptr, 0.01, 1, nullptr);
    OF_NOTHING(meltsim_world_step_part, nullptr, 0.01, 1, nullptr);
    OF_NOTHING(meltsim_world_watch_events, nullptr, 16, MELTSIM_EVENT_ALL);
    OF_NOTHING(meltsim_world_stop_events, nullptr);
    OF_NOTHING(meltsim_world_set_heat_time_scale, nullptr, 1);
    OF_NOTHING(meltsim_world_save_state, nullptr, 0);
    OF_NOTHING(meltsim_world_load_state, nullptr, 0);
    OF_NOTHING(meltsim_reading_report, nullptr, nullptr);
    OF_NOTHING(meltsim_reading_totals, nullptr, nullptr);
    OF_NOTHING(meltsim_reading_forces, nullptr, nullptr, 0, 0, nullptr);
    OF_NOTHING(meltsim_reading_events, nullptr, nullptr, 0, 0, nullptr, nullptr);
    OF_NOTHING(meltsim_reading_pieces, nullptr, nullptr, 0, 0, nullptr);
    OF_NOTHING(meltsim_reading_particles, nullptr, nullptr);
    OF_NOTHING(meltsim_reading_probe, nullptr, 0, nullptr);
    OF_NOTHING(meltsim_surface_mesh, nullptr, nullptr);
#undef OF_NOTHING
    expect(shape == nullptr, "a shape of nothing");
    meltsim_shape_destroy(nullptr);
    meltsim_world_destroy(nullptr);
    meltsim_reading_destroy(nullptr);
    meltsim_surface_destroy(nullptr);
    meltsim_world_interrupt(nullptr);
    expect(meltsim_world_time(nullptr) == 0 && meltsim_world_stable_dt(nullptr) == 0 &&
               meltsim_world_steps(nullptr) == 0 &&
               meltsim_world_backend(nullptr) == MELTSIM_BACKEND_AUTOMATIC,
           "numbers of no World");
    meltsim_fluid_desc_init_sized(nullptr, sizeof(meltsim_fluid_desc));
    expect(meltsim_version() == MELTSIM_VERSION_NUMBER, "another version");
  }

  // --- shapes -------------------------------------------------------------------------------------------------
  BothShapes shape() {
    BothShapes s{nullptr, Shape::sphere({}, 1)};
    meltsim_shape* made = nullptr;
    const Vec3d at =
        vector(Vec3d{random_.uniform(2, 8), random_.uniform(2, 9), random_.uniform(2, 8)} * dx, 0.03);
    const double r = number(dx * random_.uniform(1.1, 2.5), 0.03);
    double low[3], high[3];
    put(low, at - Vec3d{r, r, r});
    put(high, at + Vec3d{r, r, r});
    double center[3];
    put(center, at);
    double axis[3];
    put(axis, vector({0, 1, 0.3}, 0.03));
    const double blend = number(0.1, 0.03), angle = number(0.3, 0.03), scale = number(0.9, 0.03);
    note("shape");
    meltsim_status status = MELTSIM_OK;
    switch (random_.below(8)) {
      case 5:
        status = meltsim_shape_torus(center, axis, r, dx, &made);
        s.cpp = Shape::torus(at, vec(axis), r, dx);
        break;
      case 6: {
        const std::vector<double> centers = {at.x, at.y, at.z, at.x + dx, at.y, at.z}, radii(6, r);
        status = meltsim_shape_blend(centers.data(), radii.data(), 2, blend, &made);
        s.cpp = Shape::blend({{at, {r, r, r}}, {at + Vec3d{dx, 0, 0}, {r, r, r}}}, blend);
        break;
      }
      case 7: {
        const BothShapes a = simple();
        status = meltsim_shape_transform(a.c.get(), low, axis, angle, scale, &made);
        s.cpp = a.cpp.transformed(vec(low), vec(axis), angle, scale);
        break;
      }
      case 0:
        status = meltsim_shape_box(low, high, &made);
        s.cpp = Shape::box(vec(low), vec(high));
        break;
      case 1:
        status = meltsim_shape_capsule(center, high, r, &made);
        s.cpp = Shape::capsule(at, vec(high), r);
        break;
      case 2:
        status = meltsim_shape_cylinder(center, high, r, &made);
        s.cpp = Shape::cylinder(at, vec(high), r);
        break;
      case 3: {
        BothShapes a = simple(), b = simple();
        const int how = static_cast<int>(random_.below(3));
        status = (how == 0   ? meltsim_shape_unite
                  : how == 1 ? meltsim_shape_subtract
                             : meltsim_shape_intersect)(a.c.get(), b.c.get(), &made);
        s.cpp = how == 0   ? Shape::unite({a.cpp, b.cpp})
                : how == 1 ? Shape::subtract(a.cpp, b.cpp)
                           : Shape::intersect({a.cpp, b.cpp});
        break;
      }
      default:
        status = meltsim_shape_sphere(center, r, &made);
        s.cpp = Shape::sphere(at, r);
    }
    const Status valid = s.cpp.validate();
    expect((status == MELTSIM_OK) == bool(valid) && (made != nullptr) == bool(valid),
           text("a shape is taken by one interface only: ", status, " ", valid ? "" : valid.error().message));
    s.c.reset(made);
    if (valid) return s;
    failed("shape", status);
    return simple();
  }
  BothShapes simple() {
    const double at[3] = {5 * dx, 3 * dx, 5 * dx};
    meltsim_shape* made = nullptr;
    const double r = 1.6 * dx;
    expect(meltsim_shape_sphere(at, r, &made) == MELTSIM_OK, "a sphere was refused");
    BothShapes s{nullptr, Shape::sphere(vec(at), r)};
    s.c.reset(made);
    return s;
  }
  void mesh_shape() {
    note("shape_mesh");
    const double r = number(2 * dx);
    std::vector<double> x;
    for (int k = 0; k < 8; ++k)
      for (const double v : {k & 1 ? r : -r, k & 2 ? r : -r, k & 4 ? r : -r}) x.push_back(4 * dx + v);
    std::vector<std::uint32_t> t = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    if (chance(0.2)) t[random_.below(36)] = pick({8u, 0xffffffffu, 0u});
    if (chance(0.1)) t.resize(3 * random_.below(12));
    TriangleMesh mesh;
    for (std::size_t k = 0; k < 8; ++k) mesh.vertices.push_back(vec(x.data() + 3 * k));
    mesh.indices = t;
    const Status valid = Shape::mesh(mesh).validate();
    meltsim_shape* made = nullptr;
    const meltsim_status status = meltsim_shape_mesh(x.data(), 8, t.data(), t.size() / 3, &made);
    const std::unique_ptr<meltsim_shape, ShapeDelete> owned(made);
    expect((status == MELTSIM_OK) == bool(valid) && (made != nullptr) == bool(valid),
           "a mesh is taken by one interface only");
    if (!valid) expect(meltsim_error_text() == valid.error().message, "a mesh is refused with two texts");
    expect(meltsim_shape_file("/no/such/file.obj", &made) != MELTSIM_OK && made == nullptr &&
               meltsim_error_text()[0] != '\0',
           "a file that is not there");
  }

  // --- building -----------------------------------------------------------------------------------------------
  std::string name(const char* of) { return text(of, random_.below(wild_ ? 6 : 1u << 30)); }
  static MaterialDesc material_of(const meltsim_material_desc& c, const std::vector<Thing>& known) {
    MaterialDesc d;
    if (c.name != nullptr) d.name = c.name;
    d.density = c.density, d.viscosity = c.viscosity, d.conductivity = c.conductivity;
    d.heat_capacity = c.heat_capacity, d.melting_point = c.melting_point, d.latent_heat = c.latent_heat;
    d.melting_range = c.melting_range;
    d.melts_into = {c.melts_into.index, c.melts_into.generation};
    for (const Thing& t : known)
      if (t.c.index == c.melts_into.index && t.c.generation == c.melts_into.generation)
        d.melts_into = t.id<MaterialId>();
      else if (t.index == c.melts_into.index && t.generation == c.melts_into.generation)
        d.melts_into = {t.c.index, t.c.generation};  // the other World's
    d.freezes = c.freezes != 0;
    d.region_half_width = c.region_half_width, d.stiffness = c.stiffness, d.youngs_modulus = c.youngs_modulus;
    d.friction = c.friction, d.surface_tension = c.surface_tension, d.contact_angle = c.contact_angle;
    d.yield_stress = c.yield_stress, d.flow_index = c.flow_index, d.regularisation = c.regularisation;
    d.damping = c.damping;
    if (c.diffusivity != 0) d.diffusivity = c.diffusivity;
    for (std::size_t k = 0; k < c.viscosity_point_count && k < 9; ++k)
      d.viscosity_points.push_back({c.viscosity_points[2 * k], c.viscosity_points[2 * k + 1]});
    return d;
  }
  void add_material() {
    meltsim_material_desc d, defaults;
    meltsim_material_desc_init(&defaults);
    d = defaults;
    const std::string called = name("m");
    if (!wild_ || chance(0.9)) d.name = called.c_str();
    const bool solid = !liquids_.empty() && chance(0.5);
    d.density = number(solid ? 900 : 1000), d.viscosity = number(0.01), d.conductivity = number(1);
    d.heat_capacity = number(2000), d.stiffness = number(0.8), d.damping = number(0.1);
    if (chance(0.1)) d.diffusivity = number(1e-6);
    // In memory of exactly their size.
    const std::vector<double> points = {0, 0.02, number(50), number(0.01)};
    if (chance(0.2) && !solid) {
      d.viscosity_points = points.data();
      d.viscosity_point_count = 2;
    }
    if (chance(0.02)) {
      meltsim_material_desc bad = d;
      bad.density_points = nullptr;
      bad.density_point_count = 2;
      refused("add_material", [&] { return meltsim_world_add_material(c_.get(), &bad, nullptr); });
    }
    const Thing liquid = thing(liquids_);
    if (solid)
      d.melts_into = liquid.c, d.melting_point = number(0), d.latent_heat = number(3e5),
      d.melting_range = number(2);
    Thing made;
    if (!described(
            "add_material", d, defaults,
            [&](const meltsim_material_desc* c) { return meltsim_world_add_material(c_.get(), c, &made.c); },
            [&](const meltsim_material_desc& c) {
              const auto id = cpp_->add_material(material_of(c, liquids_));
              if (id) made.index = id->index, made.generation = id->generation;
              return id;
            }))
      return;
    // What was left out of a smaller struct decides which it is.
    const MaterialDesc is = cpp_->material(made.id<MaterialId>());
    (is.melts_into ? solids_ : liquids_).push_back(made);
    materials_.push_back(made);
  }
  void add_species() {
    if (liquids_.empty()) return add_material();
    meltsim_material_desc m;
    meltsim_material_desc_init(&m);
    const std::string called = name("s");
    m.name = called.c_str();
    meltsim_species_desc d, defaults;
    meltsim_species_desc_init(&defaults);
    d = defaults;
    const Thing liquid = thing(liquids_);
    d.dissolves_in = liquid.c;
    d.diffusivity_in = number(1e-9), d.solubility = number(0.5), d.heat_of_solution = number(0);
    if (liquid.c.generation == 0)
      return refused("add_species", [&] { return meltsim_world_add_species(c_.get(), &m, &d, nullptr); });
    Thing made;
    const bool taken = both(
        "add_species", [&] { return meltsim_world_add_species(c_.get(), &m, &d, &made.c); },
        [&] {
          MaterialDesc x = material_of(m, liquids_);
          x.dissolves_in = liquid.id<MaterialId>();
          x.diffusivity_in = d.diffusivity_in, x.solubility = d.solubility;
          x.heat_of_solution = d.heat_of_solution;
          const auto id = cpp_->add_material(x);
          if (id) made.index = id->index, made.generation = id->generation;
          return id;
        });
    if (taken) species_.push_back(made), materials_.push_back(made);
  }
  void set_material() {
    if (materials_.empty()) return add_material();
    const Thing m = thing(materials_);
    MaterialDesc x = cpp_->material(m.id<MaterialId>());
    if (x.dissolves_in || !x.viscosity_points.empty() || x.diffusivity) return;
    x.viscosity = number(0.02), x.friction = number(0.3);
    meltsim_material_desc d;
    meltsim_material_desc_init(&d);
    d.name = x.name.c_str();
    d.density = x.density, d.viscosity = x.viscosity, d.conductivity = x.conductivity;
    d.heat_capacity = x.heat_capacity, d.melting_point = x.melting_point, d.latent_heat = x.latent_heat;
    d.melting_range = x.melting_range;
    for (const Thing& t : materials_)
      if (t.id<MaterialId>() == x.melts_into) d.melts_into = t.c;
    d.freezes = x.freezes ? 1 : 0;
    d.region_half_width = x.region_half_width, d.stiffness = x.stiffness, d.youngs_modulus = x.youngs_modulus;
    d.friction = x.friction, d.surface_tension = x.surface_tension, d.contact_angle = x.contact_angle;
    d.yield_stress = x.yield_stress, d.flow_index = x.flow_index, d.regularisation = x.regularisation;
    d.damping = x.damping;
    both(
        "set_material", [&] { return meltsim_world_set_material(c_.get(), m.c, &d); },
        [&] { return cpp_->set_material(m.id<MaterialId>(), x); });
  }
  struct Mixture {
    std::vector<meltsim_id> c;
    std::vector<double> share;
    std::vector<MassFraction> cpp;
  };
  Mixture mixture() {
    Mixture m;
    for (int k = static_cast<int>(random_.below(3)); k > 0 && !species_.empty(); --k) {
      const Thing s = thing(species_);
      m.c.push_back(s.c);
      m.share.push_back(number(0.1));
      m.cpp.push_back({s.id<MaterialId>(), m.share.back()});
    }
    return m;
  }
  void add_fluid() {
    if (liquids_.empty()) return add_material();
    meltsim_fluid_desc d, defaults;
    meltsim_fluid_desc_init(&defaults);
    d = defaults;
    const BothShapes s = shape();
    d.shape = s.c.get();
    const Thing liquid = thing(liquids_);
    d.material = liquid.c;
    d.temperature = number(20);
    put(d.velocity, vector({0.1, 0, 0}));
    const Mixture m = mixture();
    std::uint64_t here = 0, there = 0;
    const auto cpp_of = [&](const meltsim_fluid_desc& c) {
      FluidDesc x;
      x.shape = s.cpp;
      x.material = c.material.generation == 0 ? MaterialId{} : liquid.id<MaterialId>();
      x.temperature = c.temperature, x.velocity = vec(c.velocity), x.fractions = m.cpp;
      return x;
    };
    meltsim_fluid_desc bad = d;
    bad.shape = nullptr;
    if (chance(0.05)) refused("add_fluid", [&] { return meltsim_world_add_fluid(c_.get(), &bad, &here); });
    const bool taken = both(
        "add_mixture",
        [&] {
          return m.c.empty()
                     ? meltsim_world_add_fluid(c_.get(), &d, &here)
                     : meltsim_world_add_mixture(c_.get(), &d, m.c.data(), m.share.data(), m.c.size(), &here);
        },
        [&] {
          const auto n = cpp_->add_fluid(cpp_of(d));
          if (n) there = *n;
          return n;
        });
    expect(!taken || here == there, "the two interfaces have added another number of particles");
  }
  void add_solid() {
    if (solids_.empty()) return add_material();
    meltsim_solid_desc d;
    meltsim_solid_desc_init(&d);
    const BothShapes s = shape();
    const Thing solid = thing(solids_);
    const std::string called = name("b");
    d.name = chance(0.5) ? called.c_str() : nullptr;
    d.shape = s.c.get();
    d.material = solid.c;
    d.temperature = number(-5);
    d.motion = choice(5);
    if (d.motion != MELTSIM_MOTION_FIXED) put(d.velocity, vector({0, -0.1, 0}));
    if (d.motion == MELTSIM_MOTION_PROXY) d.mass = number(30);
    d.surface = surface_heat();
    d.heat_source = number(0), d.held_until = number(0);
    const double begin = chance(0.9) ? cpp_->time() : number(0);
    const double path[] = {begin, 0, 0, 0, 0, begin + number(0.1), number(0.01), 0, 0, number(0.1)};
    if (d.motion == MELTSIM_MOTION_KINEMATIC && chance(0.5)) {
      put(d.velocity, {});
      d.path = path, d.path_count = 2;
      put(d.path_axis, vector({0, 1, 0}));
    }
    d.carve = chance(0.8) ? 1 : 0;
    if (d.motion < 0 || d.motion > MELTSIM_MOTION_PROXY)
      return refused("add_solid", [&] { return meltsim_world_add_solid(c_.get(), &d, nullptr); });
    Thing made;
    const bool taken = both(
        "add_solid", [&] { return meltsim_world_add_solid(c_.get(), &d, &made.c); },
        [&] {
          SolidDesc x;
          if (d.name != nullptr) x.name = d.name;
          x.shape = s.cpp, x.material = solid.id<MaterialId>(), x.temperature = d.temperature;
          x.motion = static_cast<Motion>(d.motion), x.velocity = vec(d.velocity), x.mass = d.mass;
          x.surface = heat_of(d.surface), x.heat_source = d.heat_source, x.held_until = d.held_until;
          x.carve = d.carve != 0;
          for (std::size_t k = 0; k < d.path_count; ++k)
            x.path.push_back({path[5 * k], vec(path + 5 * k + 1), path[5 * k + 4]});
          x.path_axis = vec(d.path_axis);
          const auto id = cpp_->add_solid(x);
          if (id) made.index = id->index, made.generation = id->generation;
          return id;
        });
    if (taken) bodies_.push_back(made);
  }
  void add_emitter() {
    if (liquids_.empty()) return add_material();
    meltsim_emitter_desc d, defaults;
    meltsim_emitter_desc_init(&defaults);
    d = defaults;
    const Thing liquid = thing(liquids_);
    put(d.center, vector(Vec3d{5, 8, 5} * dx));
    put(d.axis, vector({0, -1, 0}));
    d.radius = number(1.5 * dx), d.speed = number(0.5), d.material = liquid.c;
    d.temperature = number(20), d.from = number(0), d.until = number(0.2);
    d.max_particles = pick({0u, 60u});
    if (chance(0.5)) {  // an open face
      put(d.center, {}), put(d.axis, {1, 0, 0});
      d.radius = 0, d.speed = defaults.speed, d.from = defaults.from, d.until = defaults.until;
      d.has_level = 1, d.level = number(5 * dx), d.height = number(pick({0.0, 9 * dx})),
      d.max_particles = pick({0u, 300u});
    }
    const Mixture m = mixture();
    Thing made;
    const bool taken = both(
        "add_emitter",
        [&] {
          return m.c.empty() ? meltsim_world_add_emitter(c_.get(), &d, &made.c)
                             : meltsim_world_add_mixture_emitter(c_.get(), &d, m.c.data(), m.share.data(),
                                                                 m.c.size(), &made.c);
        },
        [&] {
          EmitterDesc x;
          x.center = vec(d.center), x.axis = vec(d.axis), x.radius = d.radius, x.speed = d.speed;
          x.material = liquid.id<MaterialId>(), x.temperature = d.temperature;
          x.from = d.from, x.until = d.until, x.max_particles = d.max_particles, x.fractions = m.cpp;
          x.height = d.height;
          if (d.has_level != 0) x.level = d.level;
          const auto id = cpp_->add_emitter(x);
          if (id) made.index = id->index, made.generation = id->generation;
          return id;
        });
    if (taken) emitters_.push_back(made);
  }
  void add_heat_region() {
    meltsim_heat_region_desc d;
    meltsim_heat_region_desc_init(&d);
    const BothShapes s = shape();
    d.shape = s.c.get();
    d.has_temperature = chance(0.5) ? 1 : 0;
    d.temperature = number(50);
    d.source = d.has_temperature != 0 ? 0 : number(1e5);
    d.from = number(0), d.until = number(0.1);
    const double path[] = {0, 0, 0, 0, number(0.1), number(0.05), 0, 0};
    if (chance(0.3)) d.path = path, d.path_count = 2;
    Thing made;
    const bool taken = both(
        "add_heat_region", [&] { return meltsim_world_add_heat_region(c_.get(), &d, &made.c); },
        [&] {
          HeatRegionDesc x;
          x.shape = s.cpp;
          if (d.has_temperature != 0) x.temperature = d.temperature;
          x.source = d.source, x.from = d.from, x.until = d.until;
          for (std::size_t k = 0; k < d.path_count; ++k)
            x.path.push_back({path[4 * k], vec(path + 4 * k + 1)});
          const auto id = cpp_->add_heat_region(x);
          if (id) made.index = id->index, made.generation = id->generation;
          return id;
        });
    if (taken) regions_.push_back(made);
  }
  void force_field() {
    meltsim_force_field_desc d, defaults;
    meltsim_force_field_desc_init(&defaults);
    d = defaults;
    d.kind = choice(5);
    d.density = number(1000);
    put(d.acceleration, vector({0, 2, 0}));
    put(d.velocity, vector({1, 0, 0}));
    d.strength = number(2), d.radius = number(dx), d.rate = number(1), d.power = choice(2);
    const BothShapes s = simple();
    const bool within = chance(0.4);
    if (within) d.shape = s.c.get();
    if (d.kind < 0 || d.kind > MELTSIM_FIELD_HYDROSTATIC)
      return refused("add_force_field", [&] { return meltsim_world_add_force_field(c_.get(), &d, nullptr); });
    const auto cpp_of = [&](const meltsim_force_field_desc& c) {
      ForceFieldDesc x;
      x.kind = static_cast<ForceFieldKind>(c.kind);
      if (c.shape != nullptr) x.shape = s.cpp;
      x.acceleration = vec(c.acceleration), x.velocity = vec(c.velocity), x.axis = vec(c.axis);
      if (c.has_center != 0) x.center = vec(c.center);
      x.angular_velocity = vec(c.angular_velocity);
      x.strength = c.strength, x.radius = c.radius, x.rate = c.rate, x.power = c.power;
      x.density = c.density, x.from = c.from, x.until = c.until, x.liquid = c.liquid != 0,
      x.bodies = c.bodies != 0;
      return x;
    };
    if (fields_.empty() || chance(0.5)) {
      Thing made;
      const bool taken = both(
          "add_force_field", [&] { return meltsim_world_add_force_field(c_.get(), &d, &made.c); },
          [&] {
            const auto id = cpp_->add_force_field(cpp_of(d));
            if (id) made.index = id->index, made.generation = id->generation;
            return id;
          });
      if (taken) fields_.push_back(made);
      return;
    }
    const Thing f = thing(fields_);
    if (chance(0.3))
      both(
          "remove_force_field", [&] { return meltsim_world_remove_force_field(c_.get(), f.c); },
          [&] { return cpp_->remove(f.id<ForceFieldId>()); });
    else
      both(
          "set_force_field", [&] { return meltsim_world_set_force_field(c_.get(), f.c, &d); },
          [&] { return cpp_->set_force_field(f.id<ForceFieldId>(), cpp_of(d)); });
  }
  void add_probe() {
    meltsim_probe_desc d, defaults;
    meltsim_probe_desc_init(&defaults);
    d = defaults;
    d.kind = choice(5);
    std::vector<double> points;
    for (std::uint32_t k = random_.below(3); k > 0; --k)
      for (const double v : {5 * dx, 3 * dx, 5 * dx}) points.push_back(number(v));
    d.points = points.data();
    d.point_count = points.size() / 3;
    std::vector<const char*> fields;
    for (std::uint32_t k = random_.below(3); k > 0; --k)
      fields.push_back(pick({"temperature", "pressure", "velocity", "force", "mass_flux", "", "nonsense"}));
    d.fields = fields.data();
    d.field_count = fields.size();
    d.every = number(0.01), d.until = number(1), d.radius = number(0.1);
    put(d.normal, vector({0, 1, 0}));
    if (chance(0.4)) d.wall = choice(6);
    const Thing body = chance(0.4) ? thing(bodies_) : Thing{};
    d.body = body.c;
    if (!fields.empty() && chance(0.05)) {
      fields.back() = nullptr;
      return refused("add_probe", [&] { return meltsim_world_add_probe(c_.get(), &d, nullptr); });
    }
    if (d.kind < 0 || d.kind > MELTSIM_PROBE_FLUX)
      return refused("add_probe", [&] { return meltsim_world_add_probe(c_.get(), &d, nullptr); });
    Thing made;
    const bool taken = both(
        "add_probe", [&] { return meltsim_world_add_probe(c_.get(), &d, &made.c); },
        [&] {
          ProbeDesc x;
          x.kind = static_cast<ProbeKind>(d.kind);
          for (std::size_t k = 0; k < d.point_count; ++k) x.points.push_back(vec(points.data() + 3 * k));
          for (const char* f : fields) x.fields.emplace_back(f);
          x.every = d.every, x.until = d.until, x.radius = d.radius, x.normal = vec(d.normal);
          if (d.wall != -1) x.wall = d.wall;
          x.body = body.id<BodyId>();
          const auto id = cpp_->add_probe(x);
          if (id) made.index = id->index, made.generation = id->generation;
          return id;
        });
    if (taken) probes_.push_back(made);
  }
  void take_out_region_or_probe() {
    auto& all = chance(0.5) ? regions_ : probes_;
    if (all.empty()) return;
    const std::uint32_t k = random_.below(static_cast<std::uint32_t>(all.size()));
    const Thing t = all[k];
    if (chance(0.7)) all.erase(all.begin() + k);
    const bool of_region = &all == &regions_;
    both(
        "remove",
        [&] {
          return of_region ? meltsim_world_remove_heat_region(c_.get(), t.c)
                           : meltsim_world_remove_probe(c_.get(), t.c);
        },
        [&] { return of_region ? cpp_->remove(t.id<HeatRegionId>()) : cpp_->remove(t.id<ProbeId>()); });
  }

  // --- stepping -----------------------------------------------------------------------------------------------
  double length_of_step() {
    expect(both(
               "prepare", [&] { return meltsim_world_prepare(c_.get()); }, [&] { return cpp_->prepare(); }) ||
               wild_,
           "a usual World was not prepared");
    // By the speeds of the last reading, and C was read more often.
    const double stable = std::min(meltsim_world_stable_dt(c_.get()), cpp_->stable_dt());
    return number(
        (std::isfinite(stable) && stable > 0 ? std::min(stable, 0.05) : 1e-3) * pick({0.3, 1.0, 2.5}), 0.05);
  }
  void settle() {
    const double seconds = chance(0.5) ? 0 : number(0.01, 0.01);
    meltsim_settled to{};
    to.size = chance(0.1) ? 0 : sizeof to;
    if (to.size == 0) return refused("settle", [&] { return meltsim_world_settle(c_.get(), seconds, &to); });
    if (both(
            "settle", [&] { return meltsim_world_settle(c_.get(), seconds, &to); },
            [&] {
              const auto s = cpp_->settle(seconds);
              if (s)
                expect(s->seconds == to.seconds && s->substeps == to.substeps && s->farthest == to.farthest &&
                           s->fastest == to.fastest,
                       "liquid that came to rest twice");
              return s;
            }))
      expect(to.size == sizeof to, "a size was changed");
  }
  void step() {
    if (chance(0.1)) settle();
    const double dt = length_of_step();
    if (chance(0.15)) {
      meltsim_world_interrupt(c_.get());
      cpp_->interrupt();
    }
    if (chance(0.7)) {
      both(
          "step", [&] { return meltsim_world_step(c_.get(), dt); }, [&] { return cpp_->step(dt); });
      return synchronize();
    }
    const std::uint64_t most = pick({0ull, 1ull, 3ull, 1ull << 60});
    const bool part = chance(0.6);
    meltsim_timed_step to{};
    to.size = sizeof to;
    if (chance(0.1)) {
      meltsim_timed_step bad{};
      refused("step_part", [&] { return meltsim_world_step_part(c_.get(), dt, most, &bad); });
    }
    const double budget = number(infinity);
    const bool taken = both(
        part ? "step_part" : "step_within",
        [&] {
          return part ? meltsim_world_step_part(c_.get(), dt, most, &to)
                      : meltsim_world_step_within(c_.get(), dt, budget, &to);
        },
        [&] {
          const auto t = part                                        ? cpp_->step_part(dt, most)
                         : std::isfinite(budget) && to.substeps != 0 ? cpp_->step_part(dt, to.substeps)
                                                                     : cpp_->step_within(dt, budget);
          if (t) expect(t->substeps == to.substeps && t->simulated == to.simulated, "two parts of a step");
          return t;
        });
    if (taken) expect(to.size == sizeof to, "a size was changed");
    synchronize();
  }
  void synchronize() {
    meltsim_status status = MELTSIM_OK;
    const auto r = filled<meltsim_report>(
        "synchronize", [&](meltsim_report* to) { return meltsim_world_synchronize(c_.get(), to); }, status);
    const StepResult there = cpp_->synchronize();
    expect(status == MELTSIM_OK, "synchronize was refused");
    if (r.size == sizeof r)
      expect(r.steps == there.steps && r.fluid == there.fluid && r.solid == there.solid &&
                 (r.halted != 0) == there.halted && r.removed == there.removed && r.entered == there.entered,
             "two reports");
    if (there.halted) expect(meltsim_error_text()[0] != '\0', "halted without a reason");
    expect(!there.halted || wild_, "a usual World halted: " + there.halt_reason);
  }

  // --- steering -----------------------------------------------------------------------------------------------
  void move_body() {
    if (bodies_.empty()) return add_solid();
    const Thing b = thing(bodies_);
    const double dt = 1e-3;
    meltsim_status status = MELTSIM_OK;
    const auto now = filled<meltsim_body_motion>(
        "motion", [&](meltsim_body_motion* to) { return meltsim_world_motion(c_.get(), b.c, to); }, status);
    const auto there = cpp_->motion(b.id<BodyId>());
    expect((status == MELTSIM_OK) == bool(there), "one interface has a motion, the other has none");
    if (status == MELTSIM_OK && now.size == sizeof now)
      expect(now.position[1] == there->position->y, "two motions");
    meltsim_body_motion d, defaults;
    meltsim_body_motion_init(&defaults);
    d = defaults;
    if (there) put(d.position, *there->position + Vec3d{0.01 * dx, 0, 0});
    d.has_position = there && chance(0.5) ? 1 : 0;
    d.has_orientation = chance(0.2) ? 1 : 0;
    d.orientation[0] = number(1);
    put(d.velocity, vector({0.01, 0, 0}));
    described(
        "set_motion", d, defaults,
        [&](const meltsim_body_motion* c) { return meltsim_world_set_motion(c_.get(), b.c, c); },
        [&](const meltsim_body_motion& c) {
          BodyMotion m;
          if (c.has_position != 0) m.position = vec(c.position);
          if (c.has_orientation != 0)
            m.orientation =
                Quat<double>{c.orientation[0], c.orientation[1], c.orientation[2], c.orientation[3]};
          m.velocity = vec(c.velocity), m.angular_velocity = vec(c.angular_velocity);
          m.teleport = c.teleport != 0;
          return cpp_->set_motion(b.id<BodyId>(), m);
        });
    std::vector<double> corners(24, number(0.0));
    both(
        "update_mesh",
        [&] { return meltsim_world_update_mesh(c_.get(), b.c, corners.data(), nullptr, corners.size() / 3); },
        [&] { return cpp_->update_mesh(b.id<BodyId>(), std::vector<Vec3d>(8, vec(corners.data())), {}); });
    both(
        "step", [&] { return meltsim_world_step(c_.get(), dt); }, [&] { return cpp_->step(dt); });
    synchronize();
  }
  void move_proxy() {
    if (bodies_.empty()) return add_solid();
    const Thing b = thing(bodies_);
    meltsim_status status = MELTSIM_OK;
    (void)filled<meltsim_proxy_state>(
        "proxy", [&](meltsim_proxy_state* to) { return meltsim_world_proxy(c_.get(), b.c, to); }, status);
    const auto there = cpp_->proxy(b.id<BodyId>());
    expect((status == MELTSIM_OK) == bool(there), "one interface has a proxy, the other has none");
    meltsim_proxy_state d, defaults;
    meltsim_proxy_state_init(&defaults);
    d = defaults;
    if (there) put(d.position, there->position);
    d.orientation[0] = number(1);
    put(d.velocity, vector({0, 0.05, 0}));
    both(
        "set_proxy", [&] { return meltsim_world_set_proxy(c_.get(), b.c, &d); },
        [&] {
          ProxyState s;
          s.position = vec(d.position), s.velocity = vec(d.velocity);
          s.orientation = {d.orientation[0], d.orientation[1], d.orientation[2], d.orientation[3]};
          return cpp_->set_proxy(b.id<BodyId>(), s);
        });
  }
  void push_body() {
    if (bodies_.empty()) return add_solid();
    const Thing b = thing(bodies_);
    double v[3], w[3];
    put(v, vector({0.1, 0, 0}));
    put(w, vector({0, 0.2, 0}));
    const bool turns = chance(0.5);
    switch (random_.below(4)) {
      case 0:
        both(
            "set_velocity", [&] { return meltsim_world_set_velocity(c_.get(), b.c, v, turns ? w : nullptr); },
            [&] { return cpp_->set_velocity(b.id<BodyId>(), vec(v), turns ? vec(w) : Vec3d{}); });
        return;
      case 1:
        both(
            "apply_impulse",
            [&] { return meltsim_world_apply_impulse(c_.get(), b.c, v, turns ? w : nullptr); },
            [&] { return cpp_->apply_impulse(b.id<BodyId>(), vec(v), turns ? vec(w) : Vec3d{}); });
        return;
      case 2:
        both(
            "hold", [&] { return meltsim_world_hold(c_.get(), b.c, turns ? 1 : 0); },
            [&] { return cpp_->hold(b.id<BodyId>(), turns); });
        return;
      default:
        if (!both(
                "remove", [&] { return meltsim_world_remove(c_.get(), b.c); },
                [&] { return cpp_->remove(b.id<BodyId>()); }))
          return;
        both(
            "remove", [&] { return meltsim_world_remove(c_.get(), b.c); },
            [&] { return cpp_->remove(b.id<BodyId>()); });
    }
  }
  void set_something() {
    double g[3];
    put(g, vector({0, -5, 1}));
    const meltsim_surface_heat h = surface_heat();
    const double scale = number(10);
    const std::int32_t face = choice(6);
    switch (random_.below(6)) {
      case 0:
        both(
            "set_gravity", [&] { return meltsim_world_set_gravity(c_.get(), g); },
            [&] { return cpp_->set_gravity(vec(g)); });
        return;
      case 1:
        both(
            "set_wall_heat", [&] { return meltsim_world_set_wall_heat(c_.get(), face, &h); },
            [&] { return cpp_->set_wall_heat(face, heat_of(h)); });
        return;
      case 2:
        both(
            "set_free_surface_heat", [&] { return meltsim_world_set_free_surface_heat(c_.get(), &h); },
            [&] { return cpp_->set_free_surface_heat(heat_of(h)); });
        return;
      case 3:
        both(
            "set_heat_time_scale", [&] { return meltsim_world_set_heat_time_scale(c_.get(), scale); },
            [&] { return cpp_->set_heat_time_scale(scale); });
        return;
      case 4: {
        if (regions_.empty()) return add_heat_region();
        const Thing r = thing(regions_);
        const bool holds = chance(0.5);
        both(
            "set_heat_region",
            [&] {
              return meltsim_world_set_heat_region(c_.get(), r.c, holds ? &scale : nullptr,
                                                   holds ? 0 : scale);
            },
            [&] {
              return cpp_->set_heat_region(r.id<HeatRegionId>(),
                                           holds ? std::optional<double>(scale) : std::nullopt,
                                           holds ? 0 : scale);
            });
        const double by[3] = {scale, 0, 0};
        both(
            "move_heat_region",
            [&] { return meltsim_world_move_heat_region(c_.get(), r.c, by, holds ? by : nullptr); },
            [&] {
              return cpp_->move_heat_region(r.id<HeatRegionId>(), {scale, 0, 0},
                                            holds ? Vec3d{scale, 0, 0} : Vec3d{});
            });
        return;
      }
      default: {
        if (emitters_.empty()) return add_emitter();
        const Thing e = thing(emitters_);
        meltsim_emitter_setting d, defaults;
        meltsim_emitter_setting_init(&defaults);
        d = defaults;
        d.has_on = chance(0.5) ? 1 : 0, d.on = chance(0.5) ? 1 : 0;
        d.has_speed = chance(0.5) ? 1 : 0, d.speed = number(0.6);
        d.has_temperature = chance(0.3) ? 1 : 0, d.temperature = number(30);
        d.has_level = chance(0.5) ? 1 : 0, d.level = number(pick({3 * dx, 8 * dx}));
        if (d.has_level != 0) d.has_speed = 0;
        described(
            "set_emitter", d, defaults,
            [&](const meltsim_emitter_setting* c) { return meltsim_world_set_emitter(c_.get(), e.c, c); },
            [&](const meltsim_emitter_setting& c) {
              EmitterSetting s;
              if (c.has_on != 0) s.on = c.on != 0;
              if (c.has_speed != 0) s.speed = c.speed;
              if (c.has_temperature != 0) s.temperature = c.temperature;
              if (c.has_center != 0) s.center = vec(c.center);
              if (c.has_level != 0) s.level = c.level;
              return cpp_->set_emitter(e.id<EmitterId>(), s);
            });
      }
    }
  }
  void remove_liquid() {
    const BothShapes s = shape();
    std::uint64_t here = 0, there = 0;
    both(
        "remove_liquid", [&] { return meltsim_world_remove_liquid(c_.get(), s.c.get(), &here); },
        [&] {
          const auto n = cpp_->remove_liquid(s.cpp);
          if (n) there = *n;
          return n;
        });
    expect(here == there, "the two interfaces have removed another number of particles");
  }

  void compact() {
    const std::uint32_t* was = nullptr;
    std::size_t count = 0;
    std::vector<std::uint32_t> there;
    if (!both(
            "compact", [&] { return meltsim_world_compact(c_.get(), &was, &count); },
            [&] {
              auto ids = cpp_->compact();
              if (ids) there = *ids;
              return ids;
            }))
      return;
    expect(count == there.size() && std::equal(there.begin(), there.end(), was),
           "the two interfaces have numbered particles anew in another way");
  }

  // --- reading ------------------------------------------------------------------------------------------------
  /// Where particles were taken out, the order of a sum depends on which of the two Worlds was looked at in between.
  static bool same_sum(double a, double b) {
    return a == b || std::fabs(a - b) <= 1e-9 * (std::fabs(a) + std::fabs(b));
  }
  void read_totals() {
    meltsim_status status = MELTSIM_OK;
    const auto t = filled<meltsim_totals>(
        "totals", [&](meltsim_totals* to) { return meltsim_world_totals(c_.get(), to); }, status);
    const auto there = cpp_->totals();
    expect((status == MELTSIM_OK) == bool(there), "one interface has totals, the other has none");
    if (there && t.size == sizeof t)
      expect(same_sum(t.mass, there->mass) && same_sum(t.kinetic, there->kinetic) &&
                 same_sum(t.thermal, there->thermal),
             "two totals");
  }
  void read_particles() {
    const auto there = cpp_->particles();
    meltsim_particles p{};
    p.size = sizeof p;
    note("particles");
    const meltsim_status asked = meltsim_world_particles(c_.get(), &p);
    if (!there) return expect(asked != MELTSIM_OK, "particles in one interface only");
    expect(asked == (there->id.empty() ? MELTSIM_OK : MELTSIM_CAPACITY) && p.count == there->id.size(),
           "another number of particles");
    std::vector<std::uint32_t> id(p.count);
    std::vector<double> position(3 * p.count);
    p.capacity = p.count;
    p.id = id.data();
    p.position = position.data();
    expect(meltsim_world_particles(c_.get(), &p) == MELTSIM_OK, "particles were refused");
    expect(id == there->id, "other ids");
    for (std::size_t k = 0; k < id.size(); ++k)
      expect(position[3 * k + 1] == there->position[k].y, "other positions");
    const Thing s = thing(species_);
    std::vector<double> values(p.count);
    std::uint64_t count = 0;
    const meltsim_status shares =
        meltsim_world_fractions(c_.get(), s.c, values.data(), values.size(), &count);
    bool known = false;
    for (std::size_t k = 0; k < there->species.size(); ++k)
      if (there->species[k] == s.id<MaterialId>())
        known = true, expect(values == there->fractions[k], "other shares");
    expect((shares == MELTSIM_OK) == known, "shares of a species in one interface only");
    if (shares == MELTSIM_OK && count > 0)
      refused(
          "fractions",
          [&] { return meltsim_world_fractions(c_.get(), s.c, values.data(), count - 1, &count); },
          MELTSIM_CAPACITY);
  }
  void look_about() {
    const BothShapes s = shape();
    std::uint64_t n = 0;
    double volume = 0;
    both(
        "liquid_in", [&] { return meltsim_world_liquid_in(c_.get(), s.c.get(), &n, &volume); },
        [&] {
          const auto o = cpp_->overlap(s.cpp);
          if (o) expect(o->liquid == n && o->liquid_volume == volume, "two overlaps");
          return o;
        });
    std::vector<meltsim_id> in(bodies_.size());
    std::vector<std::uint64_t> each(bodies_.size());
    std::size_t count = 0;
    both(
        "bodies_in",
        [&] {
          return meltsim_world_bodies_in(c_.get(), s.c.get(), in.data(), each.data(), in.size(), &count);
        },
        [&] {
          const auto o = cpp_->overlap(s.cpp);
          if (o) expect(o->bodies.size() == count, "other bodies");
          return o;
        });
    if (count > 0)
      refused(
          "bodies_in",
          [&] { return meltsim_world_bodies_in(c_.get(), s.c.get(), in.data(), nullptr, count - 1, &count); },
          MELTSIM_CAPACITY);
    std::vector<meltsim_ray> rays(2);
    std::vector<Ray> there;
    for (meltsim_ray& r : rays) {
      put(r.origin, vector(Vec3d{5, 6, 5} * dx));
      put(r.direction, vector(random_.vector(1)));
      r.length = number(infinity);
      there.push_back({vec(r.origin), vec(r.direction), r.length});
    }
    const std::uint32_t sought = wild_ && chance(0.1) ? 8u : 1u + random_.below(7);
    std::vector<meltsim_ray_hit> hits(2);
    refused("cast_rays", [&] {
      return meltsim_world_cast_rays(c_.get(), rays.data(), 2, sought, hits.data(), sizeof hits[0] + 1);
    });
    both(
        "cast_rays",
        [&] {
          return meltsim_world_cast_rays(c_.get(), rays.data(), 2, sought, hits.data(), sizeof hits[0]);
        },
        [&] {
          const auto h = cpp_->cast_rays(there, sought);
          if (h)
            expect((*h)[1].distance == hits[1].distance && (*h)[0].particle == hits[0].particle, "two hits");
          return h;
        });
    std::vector<double> at = {5 * dx, 2 * dx, number(5 * dx)}, value(1);
    const char* field = pick({"temperature", "pressure", "velocity", "nonsense"});
    both(
        "sample", [&] { return meltsim_world_sample(c_.get(), at.data(), 1, field, value.data()); },
        [&] {
          const auto v = cpp_->sample({vec(at.data())}, std::string(field));
          if (v) expect((*v)[0] == value[0] || (std::isnan(value[0]) && std::isnan((*v)[0])), "two samples");
          return v;
        });
  }
  static void push_c(const meltsim_stage_context* c, void* user) {
    auto* const a = static_cast<float*>(c->acceleration);
    ++*static_cast<int*>(user);
    for (std::uint64_t i = 0; c->double_precision == 0 && i < c->particles && a != nullptr; ++i)
      a[3 * i] += 0.01f;
  }
  static void push_cpp(const StageContext& c, void*) {
    auto* const a = static_cast<float*>(c.acceleration);
    for (std::uint64_t i = 0; c.precision == Precision::single_precision && i < c.particles && a != nullptr;
         ++i)
      a[3 * i] += 0.01f;
  }
  /// A stage of the host that pushes everything a little, on a CPU.
  void stage() {
    if (settings_.backend != Backend::cpu) return;
    const char* called = pick({"a", "b", "c"});
    if (chance(0.3)) {
      both(
          "remove_stage", [&] { return meltsim_world_remove_stage(c_.get(), called); },
          [&] { return cpp_->scheduler().remove(called); });
      return step();
    }
    meltsim_stage_desc d, defaults;
    meltsim_stage_desc_init(&defaults);
    d = defaults;
    d.name = called;
    d.after = pick({static_cast<const char*>(nullptr), "sph.forces", "step.begin", "nonsense"});
    d.run = push_c;
    d.user = &calls_;
    const std::vector<const char*> writes = {pick({"acceleration", "acceleration", "nonsense"})};
    d.writes = writes.data();
    d.write_count = 1;
    meltsim_stage_desc bad = d;
    bad.run = nullptr;
    if (chance(0.2)) refused("add_stage", [&] { return meltsim_world_add_stage(c_.get(), &bad); });
    both(
        "add_stage", [&] { return meltsim_world_add_stage(c_.get(), &d); },
        [&] {
          CustomStage own;
          own.name = called;
          own.run = push_cpp;
          own.writes = {writes.front()};
          return cpp_->scheduler().insert_after(d.after != nullptr ? d.after : "sph.forces", own);
        });
    step();
  }
  /// How often modules run, and whether.
  void schedule() {
    const char* module = pick({"thermal", "topology", "sph", "lsm", "species", "spatial", "nonsense"});
    if (chance(0.3)) {
      const bool on = chance(0.6);
      both(
          "enable", [&] { return meltsim_world_enable(c_.get(), module, on ? 1 : 0); },
          [&] { return cpp_->scheduler().enable(module, on); });
    } else {
      const int n = pick({1, 2, 3, 7, 0, -1, 2147483647});
      both(
          "set_interval", [&] { return meltsim_world_set_interval(c_.get(), module, n); },
          [&] { return cpp_->scheduler().set_interval(module, n); });
    }
    const std::string stage = pick({"thermal.exchange", "topology.melt", "topology.pieces", "step.begin"});
    std::int32_t c = -1, cpp = -1;
    both(
        "interval", [&] { return meltsim_world_interval(c_.get(), stage.c_str(), &c); },
        [&] {
          const Status ready = cpp_->prepare();
          if (ready)
            for (const StageReport& s : cpp_->plan().stages)
              if (s.name == stage) cpp = s.interval;
          return ready;
        });
    if (chance(0.3)) refused("interval", [&] { return meltsim_world_interval(c_.get(), module, &c); });
    expect(c == cpp, "two intervals");
    step();
  }
  void see_memory() {
    meltsim_status status = MELTSIM_OK;
    const auto c = filled<meltsim_stage_context>(
        "device_state", [&](meltsim_stage_context* to) { return meltsim_world_device_state(c_.get(), to); },
        status);
    const auto there = cpp_->device_state();
    expect((status == MELTSIM_OK) == bool(there), "one interface has its memory, the other has not");
    if (there && c.size == sizeof c) {
      expect(c.particles == there->particles, "two states");
      expect(meltsim_world_check_device_state(c_.get(), &c) == MELTSIM_OK, "a state that was just made");
    }
    meltsim_surface_desc d;
    meltsim_surface_desc_init(&d);
    meltsim_surface_view v{};
    v.size = sizeof v;
    both(
        "surface_view", [&] { return meltsim_world_surface_view(c_.get(), &d, &v); },
        [&] {
          const auto other = cpp_->surface_view({});
          if (other)
            expect(other->vertices == v.vertices && other->triangles == v.triangles, "two surfaces in place");
          return other;
        });
    if (v.serial != 0)
      expect(meltsim_world_check_surface_view(c_.get(), &v) == MELTSIM_OK, "a surface that was just made");
    v.serial += 12345;
    refused("check_surface_view", [&] { return meltsim_world_check_surface_view(c_.get(), &v); });
  }
  void see_surface() {
    meltsim_surface_desc d, defaults;
    meltsim_surface_desc_init(&defaults);
    d = defaults;
    d.of = choice(3);
    const Thing b = thing(bodies_);
    d.body = b.c;
    d.cell = number(0), d.smoothing = choice(4);
    meltsim_surface* made = nullptr;
    if (d.of < 0 || d.of > 2)
      return refused("surface", [&] { return meltsim_world_surface(c_.get(), &d, &made); });
    std::size_t vertices = 0;
    both(
        "surface", [&] { return meltsim_world_surface(c_.get(), &d, &made); },
        [&] {
          SurfaceDesc x;
          x.of = static_cast<SurfaceOf>(d.of);
          if (x.of == SurfaceOf::body) x.body = b.id<BodyId>();
          x.cell = d.cell, x.smoothing = d.smoothing;
          auto mesh = cpp_->surface(x);
          if (mesh) vertices = mesh->position.size();
          return mesh;
        });
    const std::unique_ptr<meltsim_surface, SurfaceDelete> owned(made);
    if (!made) return;
    meltsim_status status = MELTSIM_OK;
    const auto m = filled<meltsim_mesh>(
        "surface_mesh", [&](meltsim_mesh* to) { return meltsim_surface_mesh(made, to); }, status);
    if (m.size == sizeof m) expect(m.vertices == vertices, "two surfaces");
    meltsim_render_desc r, plain_colours;
    meltsim_render_desc_init(&plain_colours);
    r = plain_colours;
    r.color = choice(3), r.hottest = number(80);
    meltsim_render_view v{};
    v.size = sizeof v;
    if (r.color < 0 || r.color > 2)
      return refused("render_view", [&] { return meltsim_world_render_view(c_.get(), &r, &v); });
    both(
        "render_view", [&] { return meltsim_world_render_view(c_.get(), &r, &v); },
        [&] {
          RenderDesc x;
          x.color = static_cast<ColorBy>(r.color), x.hottest = r.hottest;
          const auto made_there = cpp_->render_view(x);
          if (made_there) expect(made_there->count == v.count, "two views");
          return made_there;
        });
    if (v.serial != 0)
      expect(meltsim_world_check_view(c_.get(), &v) == MELTSIM_OK, "a view that was just made");
  }
  void read_later() {
    std::uint64_t ticket = 0;
    const std::uint32_t parts =
        wild_ && chance(0.1) ? 64u : random_.below(64) & ~std::uint32_t{MELTSIM_READ_EVENTS};
    if (parts == 64u)
      return refused("request", [&] { return meltsim_world_request(c_.get(), parts, &ticket); });
    ReadTicket there;
    const bool open = both(
        "request", [&] { return meltsim_world_request(c_.get(), parts, &ticket); },
        [&] {
          ReadRequest what;
          what.totals = (parts & MELTSIM_READ_TOTALS) != 0;
          what.forces = (parts & MELTSIM_READ_FORCES) != 0;
          what.pieces = (parts & MELTSIM_READ_PIECES) != 0;
          what.particles = (parts & MELTSIM_READ_PARTICLES) != 0;
          what.probes = (parts & MELTSIM_READ_PROBES) != 0;
          auto t = cpp_->request(what);
          if (t) there = *t;
          return t;
        });
    if (!open) return;
    std::int32_t is = 0;
    expect(meltsim_world_ready(c_.get(), ticket, &is) == MELTSIM_OK, "an open ticket is not known");
    refused("ready", [&] { return meltsim_world_ready(c_.get(), ticket + 4096, &is); });
    meltsim_reading* made = nullptr;
    std::optional<Reading> other;
    both(
        "take", [&] { return meltsim_world_take(c_.get(), ticket, &made); },
        [&] {
          auto r = cpp_->take(there);
          if (r) other = *r;
          return r;
        });
    const std::unique_ptr<meltsim_reading, ReadingDelete> owned(made);
    if (!made || !other) return;
    refused("take", [&] {
      meltsim_reading* again = nullptr;
      return meltsim_world_take(c_.get(), ticket, &again);
    });
    read(made, *other);
  }
  void read(const meltsim_reading* r, const Reading& there) {
    meltsim_status status = MELTSIM_OK;
    const auto t = filled<meltsim_totals>(
        "reading_totals", [&](meltsim_totals* to) { return meltsim_reading_totals(r, to); }, status);
    if (t.size == sizeof t) expect(same_sum(t.mass, there.totals.mass), "two totals of a reading");
    const auto p = filled<meltsim_particle_frame>(
        "reading_particles", [&](meltsim_particle_frame* to) { return meltsim_reading_particles(r, to); },
        status);
    if (p.size == sizeof p) expect(p.count == there.particles.id.size(), "two frames");
    const auto report = filled<meltsim_report>(
        "reading_report", [&](meltsim_report* to) { return meltsim_reading_report(r, to); }, status);
    if (report.size == sizeof report) expect(report.steps == there.result.steps, "two reports of a reading");
    std::size_t count = 0;
    std::vector<meltsim_piece> pieces(there.pieces.size());
    if (!pieces.empty())
      refused(
          "reading_pieces",
          [&] {
            return meltsim_reading_pieces(r, pieces.data(), sizeof pieces[0], pieces.size() - 1, &count);
          },
          MELTSIM_CAPACITY);
    expect(meltsim_reading_pieces(r, pieces.data(), sizeof(meltsim_piece), pieces.size(), &count) ==
                   MELTSIM_OK &&
               count == pieces.size(),
           "other pieces");
    std::vector<meltsim_body_forces> forces(there.forces.size());
    expect(meltsim_reading_forces(r, forces.data(), sizeof(meltsim_body_forces), forces.size(), &count) ==
                   MELTSIM_OK &&
               count == forces.size(),
           "other forces");
    expect(meltsim_reading_events(r, nullptr, sizeof(meltsim_event), 0, &count, nullptr) == MELTSIM_OK,
           "events that were not asked for");
    for (std::size_t k = 0; k < there.probes.size(); ++k) {
      meltsim_probe_series s{};
      s.size = sizeof s;
      expect(meltsim_reading_probe(r, k, &s) == MELTSIM_OK && s.samples == there.probes[k].time.size(),
             "other samples");
    }
    meltsim_probe_series none{};
    none.size = sizeof none;
    refused("reading_probe", [&] { return meltsim_reading_probe(r, there.probes.size(), &none); });
  }
  void watch() {
    const Thing b = thing(bodies_);
    if (!bodies_.empty())
      both(
          "watch_forces", [&] { return meltsim_world_watch_forces(c_.get(), b.c, 1); },
          [&] { return cpp_->watch_forces(b.id<BodyId>(), true); });
    std::size_t count = 0;
    std::vector<meltsim_body_forces> forces(cpp_->watched_bodies());
    if (!forces.empty())
      refused(
          "take_forces",
          [&] {
            return meltsim_world_take_forces(c_.get(), forces.data(), sizeof forces[0], forces.size() - 1,
                                             &count);
          },
          MELTSIM_CAPACITY);
    both(
        "take_forces",
        [&] {
          return meltsim_world_take_forces(c_.get(), forces.data(), sizeof(meltsim_body_forces),
                                           forces.size(), &count);
        },
        [&] {
          const auto f = cpp_->take_forces();
          if (f) expect(f->size() == count, "two lists of forces");
          return f;
        });
    const std::uint32_t ring = wild_ && chance(0.1) ? pick({0u, 0xffffffffu}) : 32u,
                        kinds = wild_ && chance(0.1) ? pick({0u, 128u}) : 1u + random_.below(127);
    if (chance(0.6)) {
      if (both(
              "watch_events", [&] { return meltsim_world_watch_events(c_.get(), ring, kinds); },
              [&] {
                return cpp_->watch_events({ring, kinds});
              }))
        ring_ = ring;
    } else if (both(
                   "stop_events", [&] { return meltsim_world_stop_events(c_.get()); },
                   [&] { return cpp_->stop_events(); })) {
      ring_ = 0;
    }
    std::vector<meltsim_event> events(ring_);
    std::uint64_t lost = 0;
    if (ring_ > 0)
      refused(
          "take_events",
          [&] {
            return meltsim_world_take_events(c_.get(), events.data(), sizeof events[0], ring_ - 1, &count,
                                             &lost);
          },
          MELTSIM_CAPACITY);
    both(
        "take_events",
        [&] {
          return meltsim_world_take_events(c_.get(), events.data(), sizeof(meltsim_event), ring_, &count,
                                           &lost);
        },
        [&] {
          const auto e = cpp_->take_events();
          if (e) {
            expect(e->events.size() == count && e->lost == lost, "two lists of events");
            for (std::size_t k = 0; k < count; ++k)
              expect(events[k].kind == event_bit(e->events[k].kind) &&
                         events[k].particle == e->events[k].particle,
                     "two events");
          }
          return e;
        });
  }
  void go_back() {
    std::size_t bytes = 0;
    const auto there = cpp_->snapshot();
    note("snapshot");
    const meltsim_status asked = meltsim_world_snapshot(c_.get(), nullptr, 0, &bytes);
    if (!there) return expect(asked != MELTSIM_OK, "a snapshot in one interface only");
    expect(asked == MELTSIM_CAPACITY && bytes == there->size(), "a snapshot of another size");
    std::vector<std::uint8_t> here(bytes);
    refused(
        "snapshot", [&] { return meltsim_world_snapshot(c_.get(), here.data(), bytes - 1, &bytes); },
        MELTSIM_CAPACITY);
    refused("snapshot", [&] { return meltsim_world_snapshot(c_.get(), nullptr, bytes, &bytes); });
    expect(meltsim_world_snapshot(c_.get(), here.data(), bytes, &bytes) == MELTSIM_OK, "no snapshot");
    if (chance(0.5)) step();
    std::vector<std::uint8_t> damaged = here;
    damaged[random_.below(static_cast<std::uint32_t>(bytes))] ^= 1u;
    both(
        "restore", [&] { return meltsim_world_restore(c_.get(), damaged.data(), damaged.size()); },
        [&] { return cpp_->restore(damaged.data(), damaged.size()); });
    const std::size_t cut = random_.below(static_cast<std::uint32_t>(bytes));
    const std::vector<std::uint8_t> part(here.begin(), here.begin() + static_cast<std::ptrdiff_t>(cut));
    if (cut > 0)
      both(
          "restore", [&] { return meltsim_world_restore(c_.get(), part.data(), cut); },
          [&] { return cpp_->restore(part.data(), cut); });
    expect(both(
               "restore", [&] { return meltsim_world_restore(c_.get(), here.data(), bytes); },
               [&] { return cpp_->restore(here.data(), bytes); }),
           "a World refuses its own snapshot");
    const std::int32_t slot = choice(16);
    const bool saved = both(
        "save_state", [&] { return meltsim_world_save_state(c_.get(), slot); },
        [&] { return cpp_->save_state(slot); });
    if (saved && chance(0.5)) step();
    both(
        "load_state", [&] { return meltsim_world_load_state(c_.get(), slot); },
        [&] { return cpp_->load_state(slot); });
  }

  /// Bodies by both interfaces; handles of before are of no use after a load.
  void list_bodies() {
    const auto there = cpp_->bodies();
    expect(bool(there), "no list of bodies");
    std::size_t count = 0;
    meltsim_body_info none{};
    if (!there->empty())
      refused(
          "bodies",
          [&] { return meltsim_world_bodies(c_.get(), &none, sizeof none, there->size() - 1, &count); },
          MELTSIM_CAPACITY);
    std::vector<meltsim_body_info> here(there->size() + 1);
    expect(meltsim_world_bodies(c_.get(), here.data(), sizeof none, here.size(), &count) == MELTSIM_OK &&
               count == there->size(),
           "two lists of bodies");
    bodies_.clear();
    for (std::size_t k = 0; k < count; ++k) {
      const BodyInfo& b = (*there)[k];
      expect(b.name == here[k].name && here[k].motion == static_cast<int>(b.motion) &&
                 (here[k].held != 0) == b.held && here[k].body.index == b.body.index &&
                 here[k].material.index == b.material.index,
             "two bodies");
      bodies_.push_back({here[k].body, b.body.index, b.body.generation});
    }
  }
  void save_and_load() {
    std::size_t bytes = 0;
    const auto there = cpp_->save();
    note("save");
    const meltsim_status asked = meltsim_world_save(c_.get(), nullptr, 0, &bytes);
    if (!there) return expect(asked != MELTSIM_OK, "a saved World in one interface only");
    expect(asked == MELTSIM_CAPACITY && bytes == there->size(), "a saved World of another size");
    std::vector<std::uint8_t> here(bytes);
    expect(meltsim_world_save(c_.get(), here.data(), bytes, &bytes) == MELTSIM_OK && bytes == there->size(),
           "two saved Worlds");
    if (chance(0.5)) any_call();
    std::vector<std::uint8_t> damaged = here;
    damaged[random_.below(static_cast<std::uint32_t>(bytes))] ^= 1u;
    both(
        "load_saved", [&] { return meltsim_world_load_saved(c_.get(), damaged.data(), damaged.size()); },
        [&] { return cpp_->load_saved(damaged.data(), damaged.size()); });
    if (both(
            "load_saved", [&] { return meltsim_world_load_saved(c_.get(), here.data(), bytes); },
            [&] { return cpp_->load_saved(here.data(), bytes); }))
      list_bodies();
  }

  void any_call() {
    const double what = random_.uniform();
    if (what < 0.13) add_material();
    else if (what < 0.16) add_species();
    else if (what < 0.19) set_material();
    else if (what < 0.30) add_fluid();
    else if (what < 0.39) add_solid();
    else if (what < 0.42) add_emitter();
    else if (what < 0.44) add_heat_region();
    else if (what < 0.47) force_field();
    else if (what < 0.50) add_probe();
    else if (what < 0.62) step();
    else if (what < 0.65) move_body();
    else if (what < 0.67) move_proxy();
    else if (what < 0.71) push_body();
    else if (what < 0.76) set_something();
    else if (what < 0.775) remove_liquid();
    else if (what < 0.78) compact();
    else if (what < 0.785) take_out_region_or_probe();
    else if (what < 0.81) read_totals();
    else if (what < 0.84) read_particles();
    else if (what < 0.87) look_about();
    else if (what < 0.90) see_surface();
    else if (what < 0.93) read_later();
    else if (what < 0.96) watch();
    else if (what < 0.973) go_back();
    else if (what < 0.98) save_and_load();
    else if (what < 0.983) stage();
    else if (what < 0.987) schedule();
    else if (what < 0.993) see_memory();
    else mesh_shape();
    if (chance(0.2)) same_state();
  }

  static constexpr double dx = 0.1;
  Random random_;
  const Settings& settings_;
  fuzz::Progress& progress_;
  const bool wild_;
  std::unique_ptr<meltsim_world, WorldDelete> c_;
  std::unique_ptr<World> cpp_;
  std::vector<Thing> materials_, liquids_, solids_, species_, bodies_, emitters_, regions_, fields_, probes_;
  std::uint32_t ring_ = 0;
  int calls_ = 0;  ///< of stages of the C World
  std::string trace_;
};

}  // namespace

int main(int argc, char** argv) { return fuzz::run_sequences<Sequence>(argc, argv); }
