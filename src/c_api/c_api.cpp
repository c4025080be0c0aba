// SPDX-License-Identifier: Apache-2.0
// The C interface: a user of World. Every call catches, so that no exception reaches C.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "meltsim/meltsim.h"
#include "meltsim/world.hpp"

/// A stage of the host and whose it is.
struct StageOfHost {
  std::string name;
  meltsim_stage_function run = nullptr;
  void* user = nullptr;
  meltsim::Vec3d origin;  // of the positions that it sees
};

struct meltsim_world {
  meltsim::World world;
  std::uint32_t event_capacity = 0;  // of the ring
  std::vector<std::unique_ptr<StageOfHost>> stages{};
  std::vector<std::uint32_t> ids_before{};  // by the last compact()
  std::vector<meltsim::BodyInfo> bodies{};  // by the last meltsim_world_bodies()
};
struct meltsim_shape {
  meltsim::Shape shape;
};
struct meltsim_reading {
  meltsim::Reading reading;
};
struct meltsim_surface {
  meltsim::SurfaceMesh mesh;
};

namespace {

using meltsim::Error;
using meltsim::ErrorCode;
using meltsim::Vec3d;

static_assert(static_cast<int>(ErrorCode::internal) + 1 == MELTSIM_INTERNAL,
              "codes are those of ErrorCode, and 0 is success");

// A message that cannot be stored is not worth an exception.
thread_local std::string last_error;

meltsim_status fail(const Error& error) noexcept {
  try {
    last_error = error.message;
  } catch (...) {
    last_error.clear();
  }
  return static_cast<meltsim_status>(error.code) + 1;
}

struct Refused {
  Error error;
};
[[noreturn]] void refuse(const std::string& message) {
  throw Refused{{ErrorCode::invalid_argument, message}};
}

template <class F>
meltsim_status guarded(F f) noexcept {
  try {
    f();
    return MELTSIM_OK;
  } catch (const Refused& refused) {
    return fail(refused.error);
  } catch (const std::bad_alloc&) {
    return fail({ErrorCode::out_of_memory, "the host has no memory left for this call"});
  } catch (...) {
    return fail({ErrorCode::internal, "an unexpected exception"});
  }
}

template <class T>
T expect(meltsim::Result<T> result) {
  if (!result) throw Refused{result.error()};
  return std::move(*result);
}
void expect(const meltsim::Status& status) {
  if (!status) throw Refused{status.error()};
}

template <class T>
T& given(T* pointer, const char* name) {
  if (pointer == nullptr) refuse(std::string(name) + ": is null");
  return *pointer;
}

/// The part of a struct that the host was compiled with, over the defaults of the rest.
template <class D>
D read(const D* desc, const char* name, const D& defaults) {
  const std::uint32_t size = given(desc, name).size;
  if (size == 0 || size > sizeof(D) || size % alignof(D) != 0)  // else it would end within a member
    refuse(std::string(name) + ".size: " + std::to_string(size) + " is not a size of this struct, at most " +
           std::to_string(sizeof(D)) +
           "; set it to sizeof or call its _init() function, if it has one, and link the library of the "
           "headers");
  D known = defaults;
  std::memcpy(&known, desc, size);
  return known;
}
template <class D>
D defaults_of() {
  D d;
  fill(&d);
  return d;
}
/// Writes defaults into a struct of the host. The host passes its size, which is smaller if it was built against an older header.
template <class D>
void init_sized(D* to, std::size_t size) {
  if (to == nullptr || size < sizeof to->size) return;
  std::memset(static_cast<void*>(to), 0, size);
  D d = defaults_of<D>();
  d.size = static_cast<std::uint32_t>(std::min(size, sizeof d));
  std::memcpy(static_cast<void*>(to), &d, d.size);
}

/// The same for a struct that is written.
template <class R>
void write(R* to, const char* name, R result) {
  const std::uint32_t size = read(to, name, R{}).size;
  result.size = size;
  std::memcpy(to, &result, size);
}

Vec3d vec(const double v[3]) { return {v[0], v[1], v[2]}; }
Vec3d vec(const double v[3], const char* name) {
  given(v, name);
  return vec(v);
}
void put(double to[3], const Vec3d& v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
template <class H>
H handle(meltsim_id id) {
  return {id.index, id.generation};
}
template <class H>
meltsim_id id_of(H h) {
  return {h.index, h.generation};
}

meltsim::SurfaceHeatDesc heat_of(const meltsim_surface_heat& c) {
  meltsim::SurfaceHeatDesc d;
  if (c.has_temperature != 0) d.temperature = c.temperature;
  d.flux = c.flux;
  d.convection = c.convection;
  d.emissivity = c.emissivity;
  d.ambient = c.ambient;
  return d;
}

template <class E>
E option(std::int32_t value, int last, const char* name) {
  if (value < 0 || value > last)
    refuse(std::string(name) + ": " + std::to_string(value) + " is not one of 0 to " + std::to_string(last));
  return static_cast<E>(value);
}

template <class F>
meltsim_status make_shape(meltsim_shape** to, F make) {
  if (to != nullptr) *to = nullptr;
  return guarded([&] {
    given(to, "shape");
    meltsim::Shape shape = make();
    expect(shape.validate());
    *to = new meltsim_shape{std::move(shape)};
  });
}

meltsim_report report_of(const meltsim::StepResult& s) {
  return {0,       s.halted, s.steps,  s.time,    s.max_speed, s.fluid,
          s.solid, s.melted, s.frozen, s.removed, s.entered};
}

void put(meltsim_timed_step* to, const meltsim::TimedStep& s) {
  if (to == nullptr) return;
  meltsim_timed_step c{};
  c.over_budget = s.over_budget ? 1 : 0;
  c.simulated = s.simulated;
  c.owed = s.owed;
  c.substeps = s.substeps;
  c.planned = s.planned;
  c.wall_ms = s.wall_ms;
  c.substep_ms = s.substep_ms;
  write(to, "result", c);
}

void put(meltsim_settled* to, const meltsim::Settled& s) {
  if (to == nullptr) return;
  meltsim_settled c{};
  c.seconds = s.seconds;
  c.substeps = s.substeps;
  c.farthest = s.farthest;
  c.fastest = s.fastest;
  write(to, "result", c);
}

meltsim_totals totals_of(const meltsim::Totals& t) {
  meltsim_totals c{};
  c.mass = t.mass;
  put(c.momentum, t.momentum);
  c.kinetic = t.kinetic;
  c.potential = t.potential;
  c.thermal = t.thermal;
  c.latent = t.latent;
  c.heat_in = t.heat_in;
  c.temperature_min = t.temperature_min;
  c.temperature_mean = t.temperature_mean;
  c.temperature_max = t.temperature_max;
  c.field_work = t.field_work;
  put(c.field_impulse, t.field_impulse);
  c.latent_max = t.latent_max;
  return c;
}

void put(double to[4], const meltsim::Quat<double>& q) { to[0] = q.w, to[1] = q.x, to[2] = q.y, to[3] = q.z; }
meltsim::Quat<double> quat(const double q[4]) { return {q[0], q[1], q[2], q[3]}; }

/// Structs of the caller's size, one after another, that there is room for.
template <class C>
void check_room(const C* to, const char* name, const char* type, size_t struct_size, size_t capacity,
                size_t count) {
  if (struct_size == 0 || struct_size > sizeof(C) || struct_size % alignof(C) != 0)
    refuse("struct_size: " + std::to_string(struct_size) + " is not a size of " + type + ", at most " +
           std::to_string(sizeof(C)) + "; pass sizeof(" + type + ")");
  if (count > capacity)
    throw Refused{{ErrorCode::capacity, "capacity: " + std::to_string(capacity) + ", but there may be " +
                                            std::to_string(count) + " " + name + "; raise it"}};
  if (count > 0) given(to, name);
}

/// Copies a state; `bytes` is set to its size, also where there is no room for it.
void put_bytes(const std::vector<std::uint8_t>& state, void* buffer, size_t capacity, size_t& bytes) {
  bytes = state.size();
  if (state.size() > capacity)
    throw Refused{{ErrorCode::capacity, "capacity: " + std::to_string(capacity) +
                                            " bytes, but the state has " + std::to_string(state.size()) +
                                            "; pass a buffer of that size"}};
  std::memcpy(&given(static_cast<std::uint8_t*>(buffer), "buffer"), state.data(), state.size());
}

/// Ahead of reading as many: a count that is a slip reaches far beyond what the host has.
void at_most(size_t count, size_t most, const char* name) {
  if (count > most)
    throw Refused{{ErrorCode::capacity, std::string(name) + ": at most " + std::to_string(most) + ", got " +
                                            std::to_string(count) + "; ask in several calls"}};
}
void check_room(const meltsim_body_forces* forces, size_t struct_size, size_t capacity, size_t count) {
  check_room(forces, "forces", "meltsim_body_forces", struct_size, capacity, count);
}
void check_room(const meltsim_event* events, size_t struct_size, size_t capacity, size_t count) {
  check_room(events, "events", "meltsim_event", struct_size, capacity, count);
}

void put_events(const meltsim::Events& all, meltsim_event* events, size_t struct_size, uint64_t* lost) {
  auto* to = reinterpret_cast<unsigned char*>(events);
  for (const meltsim::Event& e : all.events) {
    meltsim_event c{};
    c.kind = meltsim::event_bit(e.kind);
    c.wall = e.wall;
    c.step = e.step;
    c.time = e.time;
    put(c.position, e.position);
    c.particle = e.particle;
    c.piece = e.piece;
    c.from = e.from;
    c.body = id_of(e.body);
    c.other = id_of(e.other);
    std::memcpy(to, &c, struct_size);
    to += struct_size;
  }
  if (lost != nullptr) *lost = all.lost;
}
static_assert(MELTSIM_EVENT_ALL == meltsim::all_events &&
                  MELTSIM_EVENT_LEFT == meltsim::event_bit(meltsim::EventKind::left),
              "bits are those of EventKind");

void put_forces(const std::vector<meltsim::BodyForces>& all, meltsim_body_forces* forces,
                size_t struct_size) {
  auto* to = reinterpret_cast<unsigned char*>(forces);
  for (const meltsim::BodyForces& f : all) {
    meltsim_body_forces c{};
    c.body = id_of(f.body);
    c.seconds = f.seconds;
    put(c.impulse, f.total.linear);
    put(c.angular_impulse, f.total.angular);
    put(c.pressure, f.pressure.linear);
    put(c.pressure_angular, f.pressure.angular);
    put(c.viscosity, f.viscosity.linear);
    put(c.viscosity_angular, f.viscosity.angular);
    put(c.contact, f.contact.linear);
    put(c.contact_angular, f.contact.angular);
    c.heat = f.heat;
    put(c.position, f.position);
    put(c.orientation, f.orientation);
    put(c.velocity, f.velocity);
    put(c.angular_velocity, f.angular_velocity);
    std::memcpy(to, &c, struct_size);
    to += struct_size;
  }
}

meltsim_piece piece_of(const meltsim::PieceInfo& p) {
  meltsim_piece c{};
  c.body = id_of(p.body);
  c.piece = p.piece;
  c.particles = p.particles;
  c.mass = p.mass;
  put(c.center, p.center);
  put(c.velocity, p.velocity);
  put(c.orientation, p.orientation);
  put(c.angular_velocity, p.angular_velocity);
  for (int k = 0; k < 9; ++k) c.inertia[k] = p.inertia.m[k / 3][k % 3];
  put(c.min, p.bounds.min);
  put(c.max, p.bounds.max);
  c.temperature_mean = p.temperature_mean;
  c.submerged_fraction = p.submerged_fraction;
  return c;
}

/// The numbers of an array of vectors.
template <class V>
const float* numbers(const V* vectors) {
  static_assert(sizeof(V) == 3 * sizeof(float), "three numbers");
  return reinterpret_cast<const float*>(vectors);
}
static_assert(MELTSIM_RAY_ALL == meltsim::ray_all && MELTSIM_RAY_BODIES == meltsim::ray_bodies &&
                  MELTSIM_RAY_WALLS == meltsim::ray_walls,
              "bits are those of query.hpp");

meltsim::World& world_of(meltsim_world* world) { return given(world, "world").world; }

/// The World, about to step: stages of the host get to know where its positions are relative to.
meltsim::World& stepping(meltsim_world* world) {
  meltsim::World& w = world_of(world);
  if (world->stages.empty()) return w;
  const meltsim::Resolved now = w.resolved();
  for (const auto& stage : world->stages)
    if (now.error.empty()) stage->origin = now.origin;
  return w;
}

}  // namespace

extern "C" {

const char* meltsim_error_text(void) { return last_error.c_str(); }
uint32_t meltsim_version(void) { return MELTSIM_VERSION_NUMBER; }

meltsim_status meltsim_shape_box(const double min[3], const double max[3], meltsim_shape** shape) {
  return make_shape(shape, [&] { return meltsim::Shape::box(vec(min, "min"), vec(max, "max")); });
}
meltsim_status meltsim_shape_sphere(const double center[3], double radius, meltsim_shape** shape) {
  return make_shape(shape, [&] { return meltsim::Shape::sphere(vec(center, "center"), radius); });
}
meltsim_status meltsim_shape_capsule(const double a[3], const double b[3], double radius,
                                     meltsim_shape** shape) {
  return make_shape(shape, [&] { return meltsim::Shape::capsule(vec(a, "a"), vec(b, "b"), radius); });
}
meltsim_status meltsim_shape_cylinder(const double a[3], const double b[3], double radius,
                                      meltsim_shape** shape) {
  return make_shape(shape, [&] { return meltsim::Shape::cylinder(vec(a, "a"), vec(b, "b"), radius); });
}
meltsim_status meltsim_shape_torus(const double center[3], const double axis[3], double major_radius,
                                   double minor_radius, meltsim_shape** shape) {
  return make_shape(shape, [&] {
    return meltsim::Shape::torus(vec(center, "center"), vec(axis, "axis"), major_radius, minor_radius);
  });
}
meltsim_status meltsim_shape_blend(const double* centers, const double* radii, size_t count, double blend,
                                   meltsim_shape** shape) {
  return make_shape(shape, [&] {
    if (count > 0) given(centers, "centers"), given(radii, "radii");
    std::vector<meltsim::Ellipsoid> parts;
    for (size_t i = 0; i < count; ++i) parts.push_back({vec(centers + 3 * i), vec(radii + 3 * i)});
    return meltsim::Shape::blend(std::move(parts), blend);
  });
}
meltsim_status meltsim_shape_transform(const meltsim_shape* of, const double offset[3], const double axis[3],
                                       double angle, double scale, meltsim_shape** shape) {
  return make_shape(shape, [&] {
    return given(of, "of").shape.transformed(vec(offset, "offset"), vec(axis, "axis"), angle, scale);
  });
}
meltsim_status meltsim_shape_mesh(const double* vertices, size_t vertex_count, const uint32_t* triangles,
                                  size_t triangle_count, meltsim_shape** shape) {
  return make_shape(shape, [&] {
    meltsim::TriangleMesh mesh;
    if (vertex_count > 0) given(vertices, "vertices");
    if (triangle_count > 0) given(triangles, "triangles");
    for (size_t i = 0; i < vertex_count; ++i) mesh.vertices.push_back(vec(vertices + 3 * i));
    if (triangle_count > 0) mesh.indices.assign(triangles, triangles + 3 * triangle_count);
    return meltsim::Shape::mesh(std::move(mesh));
  });
}
meltsim_status meltsim_shape_file(const char* path, meltsim_shape** shape) {
  return make_shape(shape,
                    [&] { return meltsim::Shape::mesh(expect(meltsim::read_mesh(&given(path, "path")))); });
}
meltsim_status meltsim_shape_unite(const meltsim_shape* a, const meltsim_shape* b, meltsim_shape** shape) {
  return make_shape(shape, [&] { return meltsim::Shape::unite({given(a, "a").shape, given(b, "b").shape}); });
}
meltsim_status meltsim_shape_subtract(const meltsim_shape* a, const meltsim_shape* b, meltsim_shape** shape) {
  return make_shape(shape,
                    [&] { return meltsim::Shape::subtract(given(a, "a").shape, given(b, "b").shape); });
}
meltsim_status meltsim_shape_intersect(const meltsim_shape* a, const meltsim_shape* b,
                                       meltsim_shape** shape) {
  return make_shape(shape, [&] {
    return meltsim::Shape::intersect({given(a, "a").shape, given(b, "b").shape});
  });
}
void meltsim_shape_destroy(meltsim_shape* shape) { delete shape; }

}  // extern "C"

static void fill(meltsim_world_desc* desc) {
  const meltsim::WorldDesc d;
  *desc = {};
  desc->size = sizeof *desc;
  desc->version = MELTSIM_VERSION_NUMBER;
  desc->spacing = d.spacing;
  desc->no_slip = d.domain.no_slip;
  put(desc->gravity, d.gravity);
  desc->heat_model = static_cast<int32_t>(d.heat.model);
  desc->max_substeps = d.max_substeps;
  desc->heat_time_scale = d.heat.time_scale;
  for (meltsim_surface_heat& heat : desc->wall_heat) heat.ambient = meltsim::SurfaceHeatDesc{}.ambient;
  desc->artificial_viscosity = d.artificial_viscosity;
  desc->hydrostatic_start = d.hydrostatic_start;
  desc->courant = d.courant;
  desc->pieces_interval = d.pieces_interval;
  desc->heat_interval = d.heat.interval;
  desc->heat_max_stages = d.heat.max_stages;
  desc->heat_max_supersteps = d.heat.max_supersteps;
  desc->solute_max_supersteps = d.solute.max_supersteps;
  desc->solute_time_scale = d.solute.time_scale;
  desc->heat_level_tolerance = d.heat.level_tolerance;
  desc->free_surface.ambient = d.heat.free_surface.ambient;
  desc->wall_friction = d.domain.friction;
  desc->wall_contact_angle = d.domain.contact_angle;
}
static void fill(meltsim_material_desc* desc) {
  const meltsim::MaterialDesc d;
  *desc = {};
  desc->size = sizeof *desc;
  desc->density = d.density;
  desc->viscosity = d.viscosity;
  desc->conductivity = d.conductivity;
  desc->heat_capacity = d.heat_capacity;
  desc->melting_point = d.melting_point;
  desc->region_half_width = d.region_half_width;
  desc->stiffness = d.stiffness;
  desc->friction = d.friction;
  desc->surface_tension = d.surface_tension;
  desc->contact_angle = d.contact_angle;
  desc->flow_index = d.flow_index;
  desc->regularisation = d.regularisation;
  desc->damping = d.damping;
}
static void fill(meltsim_species_desc* desc) {
  *desc = {};
  desc->size = sizeof *desc;
  desc->solubility = meltsim::MaterialDesc{}.solubility;
}
static void fill(meltsim_fluid_desc* desc) {
  *desc = {};
  desc->size = sizeof *desc;
  desc->temperature = meltsim::FluidDesc{}.temperature;
}
static void fill(meltsim_solid_desc* desc) {
  *desc = {};
  desc->size = sizeof *desc;
  desc->temperature = meltsim::SolidDesc{}.temperature;
  desc->carve = 1;
  put(desc->path_axis, meltsim::SolidDesc{}.path_axis);
  desc->surface.ambient = meltsim::SurfaceHeatDesc{}.ambient;
}
static void fill(meltsim_emitter_desc* desc) {
  const meltsim::EmitterDesc d;
  *desc = {};
  desc->size = sizeof *desc;
  put(desc->axis, d.axis);
  put(desc->up, d.up);
  desc->speed = d.speed;
  desc->temperature = d.temperature;
  desc->until = d.until;
}
static void fill(meltsim_heat_region_desc* desc) {
  *desc = {};
  desc->size = sizeof *desc;
  desc->until = meltsim::HeatRegionDesc{}.until;
}
static void fill(meltsim_force_field_desc* desc) {
  const meltsim::ForceFieldDesc d;
  *desc = {};
  desc->size = sizeof *desc;
  put(desc->axis, d.axis);
  desc->until = d.until;
  desc->liquid = desc->bodies = 1;
}
static void fill(meltsim_body_motion* motion) {
  *motion = {};
  motion->size = sizeof *motion;
  motion->orientation[0] = 1;
}

static void fill(meltsim_proxy_state* state) {
  *state = {};
  state->size = sizeof *state;
  state->orientation[0] = 1;
}
static void fill(meltsim_emitter_setting* setting) {
  *setting = {};
  setting->size = sizeof *setting;
}

static void fill(meltsim_probe_desc* desc) {
  *desc = {};
  desc->size = sizeof *desc;
  desc->wall = -1;
  desc->until = meltsim::ProbeDesc{}.until;
}
static void fill(meltsim_surface_desc* desc) {
  *desc = {};
  desc->size = sizeof *desc;
  desc->smoothing = meltsim::SurfaceDesc{}.smoothing;
}
static void fill(meltsim_stage_desc* desc) {
  *desc = {};
  desc->size = sizeof *desc;
}
static void fill(meltsim_render_desc* desc) {
  *desc = {};
  desc->size = sizeof *desc;
  desc->hottest = meltsim::RenderDesc{}.hottest;
}

static meltsim::ForceFieldDesc field_of(const meltsim_force_field_desc* desc) {
  const meltsim_force_field_desc c = read(desc, "desc", defaults_of<meltsim_force_field_desc>());
  meltsim::ForceFieldDesc d;
  if (c.name != nullptr) d.name = c.name;
  d.kind = option<meltsim::ForceFieldKind>(c.kind, MELTSIM_FIELD_HYDROSTATIC, "desc.kind");
  if (c.shape != nullptr) d.shape = c.shape->shape;
  d.acceleration = vec(c.acceleration);
  if (c.has_center != 0) d.center = vec(c.center);
  d.axis = vec(c.axis);
  d.strength = c.strength;
  d.radius = c.radius;
  d.power = c.power;
  d.velocity = vec(c.velocity);
  d.angular_velocity = vec(c.angular_velocity);
  d.rate = c.rate;
  d.liquid = c.liquid != 0;
  d.bodies = c.bodies != 0;
  d.density = c.density;
  d.from = c.from;
  d.until = c.until;
  return d;
}

extern "C" {

void meltsim_world_desc_init_sized(meltsim_world_desc* to, size_t size) { init_sized(to, size); }
void meltsim_material_desc_init_sized(meltsim_material_desc* to, size_t size) { init_sized(to, size); }
void meltsim_species_desc_init_sized(meltsim_species_desc* to, size_t size) { init_sized(to, size); }
void meltsim_fluid_desc_init_sized(meltsim_fluid_desc* to, size_t size) { init_sized(to, size); }
void meltsim_solid_desc_init_sized(meltsim_solid_desc* to, size_t size) { init_sized(to, size); }
void meltsim_emitter_desc_init_sized(meltsim_emitter_desc* to, size_t size) { init_sized(to, size); }
void meltsim_heat_region_desc_init_sized(meltsim_heat_region_desc* to, size_t size) { init_sized(to, size); }
void meltsim_force_field_desc_init_sized(meltsim_force_field_desc* to, size_t size) { init_sized(to, size); }
void meltsim_body_motion_init_sized(meltsim_body_motion* to, size_t size) { init_sized(to, size); }
void meltsim_proxy_state_init_sized(meltsim_proxy_state* to, size_t size) { init_sized(to, size); }
void meltsim_emitter_setting_init_sized(meltsim_emitter_setting* to, size_t size) { init_sized(to, size); }
void meltsim_probe_desc_init_sized(meltsim_probe_desc* to, size_t size) { init_sized(to, size); }
void meltsim_surface_desc_init_sized(meltsim_surface_desc* to, size_t size) { init_sized(to, size); }
void meltsim_render_desc_init_sized(meltsim_render_desc* to, size_t size) { init_sized(to, size); }
void meltsim_stage_desc_init_sized(meltsim_stage_desc* to, size_t size) { init_sized(to, size); }

/// Settings of the method, and of walls.
static void set_method(meltsim::WorldDesc& d, const meltsim_world_desc& c) {
  d.stream = c.stream;
  d.support_radius = c.support_radius;
  d.artificial_viscosity = c.artificial_viscosity;
  d.tension = c.tension != 0;
  const auto choice = option<std::int32_t>(c.isotropic_pressure, MELTSIM_CHOICE_ON, "isotropic_pressure");
  if (choice != MELTSIM_CHOICE_AUTOMATIC) d.isotropic_pressure = choice == MELTSIM_CHOICE_ON;
  d.particle_shifting = c.particle_shifting != 0;
  d.neighbour_search =
      option<meltsim::NeighbourSearch>(c.neighbour_search, MELTSIM_SEARCH_TREE, "neighbour_search");
  d.viscosity = option<meltsim::Viscosity>(c.viscosity, MELTSIM_VISCOSITY_IMPLICIT, "viscosity");
  d.stray = option<meltsim::Stray>(c.stray, MELTSIM_STRAY_HALT, "stray");
  d.courant = c.courant;
  d.hydrostatic_start = c.hydrostatic_start != 0;
  d.pieces_interval = c.pieces_interval;
  d.heat.max_stages = c.heat_max_stages;
  d.heat.max_supersteps = c.heat_max_supersteps;
  d.heat.level_tolerance = c.heat_level_tolerance;
  d.heat.free_surface = heat_of(c.free_surface);
  d.solute.max_supersteps = c.solute_max_supersteps;
  d.solute.time_scale = c.solute_time_scale;
  d.domain.friction = c.wall_friction;
  d.domain.contact_angle = c.wall_contact_angle;
  for (std::size_t i = 0; i < 6; ++i) d.domain.velocity[i] = vec(c.wall_velocity[i]);
}

meltsim_status meltsim_world_create(const meltsim_world_desc* desc, meltsim_world** world) {
  if (world != nullptr) *world = nullptr;
  return guarded([&] {
    given(world, "world");
    const meltsim_world_desc c = read(desc, "desc", defaults_of<meltsim_world_desc>());
    meltsim::WorldDesc d;
    d.header_version = c.version;
    d.backend = option<meltsim::Backend>(c.backend, MELTSIM_BACKEND_CUDA, "backend");
    d.precision =
        c.double_precision != 0 ? meltsim::Precision::double_precision : meltsim::Precision::single_precision;
    d.device = c.device;
    d.threads = c.threads;
    d.spacing = c.spacing;
    d.domain.bounded = c.bounded != 0;
    d.domain.no_slip = c.no_slip != 0;
    d.domain.min = vec(c.domain_min);
    d.domain.max = vec(c.domain_max);
    for (std::size_t i = 0; i < 6; ++i)
      d.domain.faces[i] = option<meltsim::Face>(c.faces[i], MELTSIM_FACE_PERIODIC, "faces");
    for (std::size_t i = 0; i < 6; ++i) d.domain.heat[i] = heat_of(c.wall_heat[i]);
    for (std::size_t i = 0; i < 6; ++i) {
      const auto kind = option<std::int32_t>(c.outlets[i].kind, MELTSIM_OUTLET_SPEED, "outlets.kind");
      if (kind == MELTSIM_OUTLET_LEVEL) d.domain.outlets[i].level = c.outlets[i].value;
      if (kind == MELTSIM_OUTLET_SPEED) d.domain.outlets[i].speed = c.outlets[i].value;
    }
    d.gravity = vec(c.gravity);
    d.sound_speed = c.sound_speed;
    d.heat.model = option<meltsim::HeatModel>(c.heat_model, MELTSIM_HEAT_ENTHALPY, "heat_model");
    d.heat.time_scale = c.heat_time_scale;
    d.heat.interval = c.heat_interval;
    d.density_error = c.density_error;
    d.follow_sound_speed = c.follow_sound_speed != 0;
    d.max_substeps = c.max_substeps;
    d.reserved_particles = c.reserved_particles;
    set_method(d, c);
    *world = new meltsim_world{expect(meltsim::World::create(d, c.version))};
  });
}
void meltsim_world_destroy(meltsim_world* world) { delete world; }

}  // extern "C"

namespace {
/// Pairs of temperature and value.
std::vector<meltsim::PropertyPoint> points_of(const double* pairs, size_t count, const char* name) {
  std::vector<meltsim::PropertyPoint> points;
  if (count > 0) given(pairs, name);
  // A table with too many points is refused whatever the points are; one point beyond the limit is enough to report it.
  for (size_t k = 0; k < count && k < 9; ++k) points.push_back({pairs[2 * k], pairs[2 * k + 1]});
  return points;
}
meltsim::MaterialDesc material_of(const meltsim_material_desc* desc, const char* name) {
  const meltsim_material_desc c = read(desc, name, defaults_of<meltsim_material_desc>());
  meltsim::MaterialDesc d;
  if (c.name != nullptr) d.name = c.name;
  d.density = c.density;
  d.viscosity = c.viscosity;
  d.conductivity = c.conductivity;
  d.heat_capacity = c.heat_capacity;
  d.melting_point = c.melting_point;
  d.melting_range = c.melting_range;
  d.latent_heat = c.latent_heat;
  d.melts_into = handle<meltsim::MaterialId>(c.melts_into);
  d.freezes = c.freezes != 0;
  d.region_half_width = c.region_half_width;
  d.stiffness = c.stiffness;
  d.youngs_modulus = c.youngs_modulus;
  d.friction = c.friction;
  d.surface_tension = c.surface_tension;
  d.contact_angle = c.contact_angle;
  d.yield_stress = c.yield_stress;
  d.flow_index = c.flow_index;
  d.regularisation = c.regularisation;
  d.yield_stress_points =
      points_of(c.yield_stress_points, c.yield_stress_point_count, "desc.yield_stress_points");
  d.damping = c.damping;
  if (c.diffusivity != 0) d.diffusivity = c.diffusivity;
  d.conductivity_points =
      points_of(c.conductivity_points, c.conductivity_point_count, "desc.conductivity_points");
  d.heat_capacity_points =
      points_of(c.heat_capacity_points, c.heat_capacity_point_count, "desc.heat_capacity_points");
  d.viscosity_points = points_of(c.viscosity_points, c.viscosity_point_count, "desc.viscosity_points");
  d.density_points = points_of(c.density_points, c.density_point_count, "desc.density_points");
  return d;
}
meltsim::EmitterDesc emitter_of(const meltsim_emitter_desc* desc) {
  const meltsim_emitter_desc c = read(desc, "desc", defaults_of<meltsim_emitter_desc>());
  meltsim::EmitterDesc d;
  if (c.name != nullptr) d.name = c.name;
  d.center = vec(c.center);
  d.axis = vec(c.axis);
  d.radius = c.radius;
  d.speed = c.speed;
  d.material = handle<meltsim::MaterialId>(c.material);
  d.temperature = c.temperature;
  d.from = c.from;
  d.until = c.until;
  d.max_particles = c.max_particles;
  d.recycle = c.recycle != 0;
  d.width = c.width;
  d.height = c.height;
  d.up = vec(c.up);
  if (c.has_level != 0) d.level = c.level;
  return d;
}

std::vector<meltsim::MassFraction> fractions_of(const meltsim_id* species, const double* fractions,
                                                size_t count) {
  if (count > 0) given(species, "species"), given(fractions, "fractions");
  std::vector<meltsim::MassFraction> all;
  for (size_t k = 0; k < count; ++k) all.push_back({handle<meltsim::MaterialId>(species[k]), fractions[k]});
  return all;
}

meltsim::FluidDesc fluid_of(const meltsim_fluid_desc* desc) {
  const meltsim_fluid_desc c = read(desc, "desc", defaults_of<meltsim_fluid_desc>());
  meltsim::FluidDesc d;
  d.shape = given(c.shape, "desc.shape").shape;
  d.material = handle<meltsim::MaterialId>(c.material);
  d.temperature = c.temperature;
  d.velocity = vec(c.velocity);
  return d;
}
}  // namespace

extern "C" {

meltsim_status meltsim_world_add_material(meltsim_world* world, const meltsim_material_desc* desc,
                                          meltsim_id* id) {
  return guarded([&] {
    const meltsim::MaterialId made = expect(world_of(world).add_material(material_of(desc, "desc")));
    if (id != nullptr) *id = id_of(made);
  });
}
meltsim_status meltsim_world_add_species(meltsim_world* world, const meltsim_material_desc* material,
                                         const meltsim_species_desc* species, meltsim_id* id) {
  return guarded([&] {
    meltsim::MaterialDesc d = material_of(material, "material");
    const meltsim_species_desc c = read(species, "species", defaults_of<meltsim_species_desc>());
    d.dissolves_in = handle<meltsim::MaterialId>(c.dissolves_in);
    d.solubility = c.solubility;
    d.solubility_points =
        points_of(c.solubility_points, c.solubility_point_count, "species.solubility_points");
    d.diffusivity_in = c.diffusivity_in;
    d.heat_of_solution = c.heat_of_solution;
    if (c.transfer_coefficient != 0) d.transfer_coefficient = c.transfer_coefficient;
    if (!d.dissolves_in)
      throw Refused{{ErrorCode::invalid_argument, "species.dissolves_in: is null; pass the liquid's id"}};
    const meltsim::MaterialId made = expect(world_of(world).add_material(d));
    if (id != nullptr) *id = id_of(made);
  });
}
meltsim_status meltsim_world_add_fluid(meltsim_world* world, const meltsim_fluid_desc* desc,
                                       uint64_t* added) {
  return guarded([&] {
    const std::uint64_t count = expect(world_of(world).add_fluid(fluid_of(desc)));
    if (added != nullptr) *added = count;
  });
}
meltsim_status meltsim_world_add_mixture(meltsim_world* world, const meltsim_fluid_desc* desc,
                                         const meltsim_id* species, const double* fractions, size_t count,
                                         uint64_t* added) {
  return guarded([&] {
    meltsim::FluidDesc d = fluid_of(desc);
    d.fractions = fractions_of(species, fractions, count);
    const std::uint64_t particles = expect(world_of(world).add_fluid(d));
    if (added != nullptr) *added = particles;
  });
}
meltsim_status meltsim_world_add_solid(meltsim_world* world, const meltsim_solid_desc* desc, meltsim_id* id) {
  return guarded([&] {
    const meltsim_solid_desc c = read(desc, "desc", defaults_of<meltsim_solid_desc>());
    meltsim::SolidDesc d;
    if (c.name != nullptr) d.name = c.name;
    d.shape = given(c.shape, "desc.shape").shape;
    d.material = handle<meltsim::MaterialId>(c.material);
    d.temperature = c.temperature;
    d.velocity = vec(c.velocity);
    d.angular_velocity = vec(c.angular_velocity);
    d.motion = option<meltsim::Motion>(c.motion, MELTSIM_MOTION_PROXY, "motion");
    if (c.has_pivot != 0) d.pivot = vec(c.pivot);
    d.mass = c.mass;
    for (int i = 0; i < 9; ++i) d.inertia.m[i / 3][i % 3] = c.inertia[i];
    d.max_speed = c.max_speed;
    d.surface = heat_of(c.surface);
    d.heat_source = c.heat_source;
    d.held_until = c.held_until;
    d.carve = c.carve != 0;
    d.growth = c.growth;
    at_most(c.path_count, 1u << 20, "desc.path_count");
    if (c.path_count > 0) given(c.path, "desc.path");
    for (const double* p = c.path; d.path.size() < c.path_count; p += 5)
      d.path.push_back({p[0], vec(p + 1), p[4]});
    d.path_axis = vec(c.path_axis);
    const meltsim::BodyId made = expect(world_of(world).add_solid(d));
    if (id != nullptr) *id = id_of(made);
  });
}

meltsim_status meltsim_world_add_emitter(meltsim_world* world, const meltsim_emitter_desc* desc,
                                         meltsim_id* id) {
  return meltsim_world_add_mixture_emitter(world, desc, nullptr, nullptr, 0, id);
}
meltsim_status meltsim_world_add_mixture_emitter(meltsim_world* world, const meltsim_emitter_desc* desc,
                                                 const meltsim_id* species, const double* fractions,
                                                 size_t count, meltsim_id* id) {
  return guarded([&] {
    meltsim::EmitterDesc d = emitter_of(desc);
    d.fractions = fractions_of(species, fractions, count);
    const meltsim::EmitterId made = expect(world_of(world).add_emitter(d));
    if (id != nullptr) *id = id_of(made);
  });
}
meltsim_status meltsim_world_add_heat_region(meltsim_world* world, const meltsim_heat_region_desc* desc,
                                             meltsim_id* id) {
  return guarded([&] {
    const meltsim_heat_region_desc c = read(desc, "desc", defaults_of<meltsim_heat_region_desc>());
    meltsim::HeatRegionDesc d;
    if (c.name != nullptr) d.name = c.name;
    d.shape = given(c.shape, "desc.shape").shape;
    if (c.has_temperature != 0) d.temperature = c.temperature;
    d.source = c.source;
    d.from = c.from;
    d.until = c.until;
    at_most(c.path_count, 1u << 20, "desc.path_count");
    if (c.path_count > 0) given(c.path, "desc.path");
    for (size_t k = 0; k < c.path_count; ++k) d.path.push_back({c.path[4 * k], vec(c.path + 4 * k + 1)});
    const meltsim::HeatRegionId made = expect(world_of(world).add_heat_region(d));
    if (id != nullptr) *id = id_of(made);
  });
}

meltsim_status meltsim_world_add_force_field(meltsim_world* world, const meltsim_force_field_desc* desc,
                                             meltsim_id* id) {
  return guarded([&] {
    const meltsim::ForceFieldId made = expect(world_of(world).add_force_field(field_of(desc)));
    if (id != nullptr) *id = id_of(made);
  });
}
meltsim_status meltsim_world_set_force_field(meltsim_world* world, meltsim_id field,
                                             const meltsim_force_field_desc* desc) {
  return guarded(
      [&] { expect(world_of(world).set_force_field(handle<meltsim::ForceFieldId>(field), field_of(desc))); });
}
meltsim_status meltsim_world_remove_heat_region(meltsim_world* world, meltsim_id region) {
  return guarded([&] { expect(world_of(world).remove(handle<meltsim::HeatRegionId>(region))); });
}
meltsim_status meltsim_world_remove_probe(meltsim_world* world, meltsim_id probe) {
  return guarded([&] { expect(world_of(world).remove(handle<meltsim::ProbeId>(probe))); });
}
meltsim_status meltsim_world_remove_force_field(meltsim_world* world, meltsim_id field) {
  return guarded([&] { expect(world_of(world).remove(handle<meltsim::ForceFieldId>(field))); });
}

meltsim_status meltsim_world_add_probe(meltsim_world* world, const meltsim_probe_desc* desc, meltsim_id* id) {
  return guarded([&] {
    const meltsim_probe_desc c = read(desc, "desc", defaults_of<meltsim_probe_desc>());
    meltsim::ProbeDesc d;
    if (c.name != nullptr) d.name = c.name;
    d.kind = option<meltsim::ProbeKind>(c.kind, 4, "desc.kind");
    if (c.point_count > 0) given(c.points, "desc.points");
    for (uint64_t k = 0; k < c.point_count; ++k) d.points.push_back(vec(c.points + 3 * k));
    if (c.field_count > 0) given(c.fields, "desc.fields");
    for (uint64_t k = 0; k < c.field_count; ++k)
      d.fields.emplace_back(&given(c.fields[k], "desc.fields: an entry"));
    d.body = handle<meltsim::BodyId>(c.body);
    if (c.wall != -1) d.wall = c.wall;
    d.normal = vec(c.normal);
    d.radius = c.radius;
    d.along = vec(c.along);
    d.size[0] = c.side[0];
    d.size[1] = c.side[1];
    d.every = c.every;
    d.from = c.from;
    d.until = c.until;
    const meltsim::ProbeId made = expect(world_of(world).add_probe(d));
    if (id != nullptr) *id = id_of(made);
  });
}

meltsim_status meltsim_world_prepare(meltsim_world* world) {
  return guarded([&] { expect(world_of(world).prepare()); });
}
meltsim_status meltsim_world_settle(meltsim_world* world, double seconds, meltsim_settled* result) {
  return guarded([&] {
    if (result != nullptr) read(result, "result", meltsim_settled{});
    put(result, expect(stepping(world).settle(seconds)));
  });
}
meltsim_status meltsim_world_step(meltsim_world* world, double seconds) {
  return guarded([&] { expect(stepping(world).step(seconds)); });
}
meltsim_status meltsim_world_step_within(meltsim_world* world, double seconds, double milliseconds,
                                         meltsim_timed_step* result) {
  return guarded([&] {
    if (result != nullptr) read(result, "result", meltsim_timed_step{});
    put(result, expect(stepping(world).step_within(seconds, milliseconds)));
  });
}
meltsim_status meltsim_world_step_part(meltsim_world* world, double seconds, uint64_t substeps,
                                       meltsim_timed_step* result) {
  return guarded([&] {
    if (result != nullptr) read(result, "result", meltsim_timed_step{});
    put(result, expect(stepping(world).step_part(seconds, substeps)));
  });
}
void meltsim_world_interrupt(meltsim_world* world) {
  if (world != nullptr) world->world.interrupt();
}
meltsim_status meltsim_world_set_motion(meltsim_world* world, meltsim_id body,
                                        const meltsim_body_motion* motion) {
  return guarded([&] {
    const meltsim_body_motion c = read(motion, "motion", defaults_of<meltsim_body_motion>());
    meltsim::BodyMotion m;
    if (c.has_position != 0) m.position = vec(c.position);
    if (c.has_orientation != 0)
      m.orientation =
          meltsim::Quat<double>{c.orientation[0], c.orientation[1], c.orientation[2], c.orientation[3]};
    m.velocity = vec(c.velocity);
    m.angular_velocity = vec(c.angular_velocity);
    m.teleport = c.teleport != 0;
    expect(world_of(world).set_motion(handle<meltsim::BodyId>(body), m));
  });
}
meltsim_status meltsim_world_motion(meltsim_world* world, meltsim_id body, meltsim_body_motion* motion) {
  return guarded([&] {
    meltsim_body_motion c = read(motion, "motion", defaults_of<meltsim_body_motion>());
    const meltsim::BodyMotion m = expect(world_of(world).motion(handle<meltsim::BodyId>(body)));
    c.has_position = c.has_orientation = 1;
    c.teleport = 0;
    put(c.position, *m.position);
    put(c.orientation, *m.orientation);
    put(c.velocity, m.velocity);
    put(c.angular_velocity, m.angular_velocity);
    write(motion, "motion", c);
  });
}
meltsim_status meltsim_world_update_mesh(meltsim_world* world, meltsim_id body, const double* vertices,
                                         const double* velocities, size_t vertex_count) {
  return guarded([&] {
    if (vertex_count > 0) given(vertices, "vertices");
    std::vector<meltsim::Vec3d> x, v;
    x.reserve(vertex_count);
    for (size_t i = 0; i < vertex_count; ++i) x.push_back(vec(vertices + 3 * i));
    if (velocities != nullptr) v.reserve(vertex_count);
    for (size_t i = 0; i < vertex_count && velocities != nullptr; ++i) v.push_back(vec(velocities + 3 * i));
    expect(world_of(world).update_mesh(handle<meltsim::BodyId>(body), x, v));
  });
}
meltsim_status meltsim_world_set_proxy(meltsim_world* world, meltsim_id body,
                                       const meltsim_proxy_state* state) {
  return guarded([&] {
    const meltsim_proxy_state c = read(state, "state", defaults_of<meltsim_proxy_state>());
    meltsim::ProxyState s;
    s.position = vec(c.position);
    s.orientation = quat(c.orientation);
    s.velocity = vec(c.velocity);
    s.angular_velocity = vec(c.angular_velocity);
    s.acceleration = vec(c.acceleration);
    s.teleport = c.teleport != 0;
    expect(world_of(world).set_proxy(handle<meltsim::BodyId>(body), s));
  });
}
meltsim_status meltsim_world_proxy(meltsim_world* world, meltsim_id body, meltsim_proxy_state* state) {
  return guarded([&] {
    meltsim_proxy_state c = read(state, "state", defaults_of<meltsim_proxy_state>());
    const meltsim::ProxyState s = expect(world_of(world).proxy(handle<meltsim::BodyId>(body)));
    c.teleport = 0;
    put(c.position, s.position);
    put(c.orientation, s.orientation);
    put(c.velocity, s.velocity);
    put(c.angular_velocity, s.angular_velocity);
    put(c.acceleration, s.acceleration);
    write(state, "state", c);
  });
}
meltsim_status meltsim_world_watch_forces(meltsim_world* world, meltsim_id body, int32_t on) {
  return guarded([&] { expect(world_of(world).watch_forces(handle<meltsim::BodyId>(body), on != 0)); });
}
meltsim_status meltsim_world_watch_events(meltsim_world* world, uint32_t capacity, uint32_t kinds) {
  return guarded([&] {
    expect(world_of(world).watch_events({capacity, kinds}));
    world->event_capacity = capacity;
  });
}
meltsim_status meltsim_world_stop_events(meltsim_world* world) {
  return guarded([&] {
    expect(world_of(world).stop_events());
    world->event_capacity = 0;
  });
}
meltsim_status meltsim_world_set_material(meltsim_world* world, meltsim_id material,
                                          const meltsim_material_desc* desc) {
  return guarded([&] {
    expect(world_of(world).set_material(handle<meltsim::MaterialId>(material), material_of(desc, "desc")));
  });
}
meltsim_status meltsim_world_set_gravity(meltsim_world* world, const double gravity[3]) {
  return guarded([&] { expect(world_of(world).set_gravity(vec(gravity, "gravity"))); });
}
meltsim_status meltsim_world_hold(meltsim_world* world, meltsim_id body, int32_t on) {
  return guarded([&] { expect(world_of(world).hold(handle<meltsim::BodyId>(body), on != 0)); });
}
meltsim_status meltsim_world_set_velocity(meltsim_world* world, meltsim_id body, const double velocity[3],
                                          const double angular_velocity[3]) {
  return guarded([&] {
    const auto or_zero = [](const double* v) { return v != nullptr ? vec(v) : Vec3d{}; };
    expect(world_of(world).set_velocity(handle<meltsim::BodyId>(body), or_zero(velocity),
                                        or_zero(angular_velocity)));
  });
}
meltsim_status meltsim_world_apply_impulse(meltsim_world* world, meltsim_id body, const double impulse[3],
                                           const double angular_impulse[3]) {
  return guarded([&] {
    const auto or_zero = [](const double* v) { return v != nullptr ? vec(v) : Vec3d{}; };
    expect(world_of(world).apply_impulse(handle<meltsim::BodyId>(body), or_zero(impulse),
                                         or_zero(angular_impulse)));
  });
}
meltsim_status meltsim_world_set_wall_heat(meltsim_world* world, int32_t face,
                                           const meltsim_surface_heat* heat) {
  return guarded([&] { expect(world_of(world).set_wall_heat(face, heat_of(given(heat, "heat")))); });
}
meltsim_status meltsim_world_set_free_surface_heat(meltsim_world* world, const meltsim_surface_heat* heat) {
  return guarded([&] { expect(world_of(world).set_free_surface_heat(heat_of(given(heat, "heat")))); });
}
meltsim_status meltsim_world_set_body_heat(meltsim_world* world, meltsim_id body,
                                           const meltsim_surface_heat* surface, double source) {
  return guarded([&] {
    expect(world_of(world).set_body_heat(handle<meltsim::BodyId>(body), heat_of(given(surface, "surface")),
                                         source));
  });
}
meltsim_status meltsim_world_set_heat_region(meltsim_world* world, meltsim_id region,
                                             const double* temperature, double source) {
  return guarded([&] {
    std::optional<double> held;
    if (temperature != nullptr) held = *temperature;
    expect(world_of(world).set_heat_region(handle<meltsim::HeatRegionId>(region), held, source));
  });
}
meltsim_status meltsim_world_move_heat_region(meltsim_world* world, meltsim_id region,
                                              const double displacement[3], const double velocity[3]) {
  return guarded([&] {
    const auto or_zero = [](const double* v) { return v != nullptr ? vec(v) : Vec3d{}; };
    expect(world_of(world).move_heat_region(handle<meltsim::HeatRegionId>(region), or_zero(displacement),
                                            or_zero(velocity)));
  });
}
meltsim_status meltsim_world_set_heat_time_scale(meltsim_world* world, double scale) {
  return guarded([&] { expect(world_of(world).set_heat_time_scale(scale)); });
}
meltsim_status meltsim_world_set_emitter(meltsim_world* world, meltsim_id emitter,
                                         const meltsim_emitter_setting* setting) {
  return guarded([&] {
    const meltsim_emitter_setting c = read(setting, "setting", defaults_of<meltsim_emitter_setting>());
    meltsim::EmitterSetting s;
    if (c.has_on != 0) s.on = c.on != 0;
    if (c.has_speed != 0) s.speed = c.speed;
    if (c.has_temperature != 0) s.temperature = c.temperature;
    if (c.has_center != 0) s.center = vec(c.center);
    if (c.has_level != 0) s.level = c.level;
    expect(world_of(world).set_emitter(handle<meltsim::EmitterId>(emitter), s));
  });
}
meltsim_status meltsim_world_remove(meltsim_world* world, meltsim_id body) {
  return guarded([&] { expect(world_of(world).remove(handle<meltsim::BodyId>(body))); });
}
meltsim_status meltsim_world_remove_liquid(meltsim_world* world, const meltsim_shape* shape,
                                           uint64_t* removed) {
  return guarded([&] {
    const std::uint64_t n = expect(world_of(world).remove_liquid(given(shape, "shape").shape));
    if (removed != nullptr) *removed = n;
  });
}
meltsim_status meltsim_world_compact(meltsim_world* world, const uint32_t** was, size_t* count) {
  return guarded([&] {
    std::vector<std::uint32_t> ids = expect(world_of(world).compact());
    world->ids_before = std::move(ids);
    if (was != nullptr) *was = world->ids_before.data();
    if (count != nullptr) *count = world->ids_before.size();
  });
}
double meltsim_world_time(const meltsim_world* world) { return world != nullptr ? world->world.time() : 0; }
double meltsim_world_stable_dt(const meltsim_world* world) {
  return world != nullptr ? world->world.stable_dt() : 0;
}
uint64_t meltsim_world_steps(const meltsim_world* world) {
  return world != nullptr ? world->world.steps() : 0;
}
int32_t meltsim_world_backend(const meltsim_world* world) {
  return world != nullptr ? static_cast<int32_t>(world->world.backend()) : MELTSIM_BACKEND_AUTOMATIC;
}

meltsim_status meltsim_world_synchronize(meltsim_world* world, meltsim_report* report) {
  return guarded([&] {
    read(report, "report", meltsim_report{});
    const meltsim::StepResult s = world_of(world).synchronize();
    const bool in_use = s.error.rfind("World: ", 0) == 0;
    if (!s.error.empty())
      throw Refused{{in_use ? ErrorCode::invalid_argument : ErrorCode::out_of_memory, s.error}};
    if (s.halted) last_error = s.halt_reason;
    write(report, "report", report_of(s));
  });
}
meltsim_status meltsim_world_totals(meltsim_world* world, meltsim_totals* totals) {
  return guarded([&] {
    read(totals, "totals", meltsim_totals{});
    const meltsim::Totals t = expect(world_of(world).totals());
    write(totals, "totals", totals_of(t));
  });
}
meltsim_status meltsim_world_take_forces(meltsim_world* world, meltsim_body_forces* forces,
                                         size_t struct_size, size_t capacity, size_t* count) {
  return guarded([&] {
    given(count, "count");
    const size_t there = world_of(world).watched_bodies();
    *count = there;
    check_room(forces, struct_size, capacity, there);
    const std::vector<meltsim::BodyForces> all = expect(world_of(world).take_forces());
    *count = all.size();  // nothing of what has melted
    put_forces(all, forces, struct_size);
  });
}

meltsim_status meltsim_world_take_events(meltsim_world* world, meltsim_event* events, size_t struct_size,
                                         size_t capacity, size_t* count, uint64_t* lost) {
  return guarded([&] {
    meltsim::World& w = world_of(world);
    given(count, "count") = world->event_capacity;
    check_room(events, struct_size, capacity, world->event_capacity);
    const meltsim::Events all = expect(w.take_events());
    *count = all.events.size();
    put_events(all, events, struct_size, lost);
  });
}

meltsim_status meltsim_world_request(meltsim_world* world, uint32_t parts, uint64_t* ticket) {
  return guarded([&] {
    given(ticket, "ticket");
    constexpr uint32_t known = MELTSIM_READ_TOTALS | MELTSIM_READ_FORCES | MELTSIM_READ_EVENTS |
                               MELTSIM_READ_PIECES | MELTSIM_READ_PARTICLES | MELTSIM_READ_PROBES;
    if ((parts & ~known) != 0) refuse("parts: " + std::to_string(parts) + " is no sum of MELTSIM_READ_...");
    meltsim::ReadRequest what;
    what.totals = (parts & MELTSIM_READ_TOTALS) != 0;
    what.forces = (parts & MELTSIM_READ_FORCES) != 0;
    what.events = (parts & MELTSIM_READ_EVENTS) != 0;
    what.pieces = (parts & MELTSIM_READ_PIECES) != 0;
    what.particles = (parts & MELTSIM_READ_PARTICLES) != 0;
    what.probes = (parts & MELTSIM_READ_PROBES) != 0;
    *ticket = expect(world_of(world).request(what)).value;
  });
}
meltsim_status meltsim_world_ready(meltsim_world* world, uint64_t ticket, int32_t* ready) {
  return guarded([&] {
    given(ready, "ready");
    *ready = expect(world_of(world).ready({ticket})) ? 1 : 0;
  });
}
meltsim_status meltsim_world_take(meltsim_world* world, uint64_t ticket, meltsim_reading** reading) {
  if (reading != nullptr) *reading = nullptr;
  return guarded([&] {
    given(reading, "reading");
    auto made = std::make_unique<meltsim_reading>();
    made->reading = expect(world_of(world).take({ticket}));
    *reading = made.release();
  });
}
meltsim_status meltsim_reading_report(const meltsim_reading* reading, meltsim_report* report) {
  return guarded([&] {
    const meltsim::StepResult& s = given(reading, "reading").reading.result;
    if (s.halted) last_error = s.halt_reason;
    write(report, "report", report_of(s));
  });
}
meltsim_status meltsim_reading_totals(const meltsim_reading* reading, meltsim_totals* totals) {
  return guarded([&] { write(totals, "totals", totals_of(given(reading, "reading").reading.totals)); });
}
meltsim_status meltsim_reading_forces(const meltsim_reading* reading, meltsim_body_forces* forces,
                                      size_t struct_size, size_t capacity, size_t* count) {
  return guarded([&] {
    const auto& all = given(reading, "reading").reading.forces;
    given(count, "count");
    *count = all.size();
    check_room(forces, struct_size, capacity, all.size());
    put_forces(all, forces, struct_size);
  });
}
meltsim_status meltsim_reading_events(const meltsim_reading* reading, meltsim_event* events,
                                      size_t struct_size, size_t capacity, size_t* count, uint64_t* lost) {
  return guarded([&] {
    const meltsim::Events& all = given(reading, "reading").reading.events;
    given(count, "count") = all.events.size();
    check_room(events, struct_size, capacity, all.events.size());
    put_events(all, events, struct_size, lost);
  });
}
meltsim_status meltsim_reading_pieces(const meltsim_reading* reading, meltsim_piece* pieces,
                                      size_t struct_size, size_t capacity, size_t* count) {
  return guarded([&] {
    const auto& all = given(reading, "reading").reading.pieces;
    given(count, "count") = all.size();
    check_room(pieces, "pieces", "meltsim_piece", struct_size, capacity, all.size());
    auto* to = reinterpret_cast<unsigned char*>(pieces);
    for (const meltsim::PieceInfo& p : all) {
      const meltsim_piece c = piece_of(p);
      std::memcpy(to, &c, struct_size);
      to += struct_size;
    }
  });
}
meltsim_status meltsim_reading_particles(const meltsim_reading* reading, meltsim_particle_frame* particles) {
  return guarded([&] {
    const meltsim::ParticleFrame& p = given(reading, "reading").reading.particles;
    meltsim_particle_frame c{};
    c.count = p.id.size();
    put(c.origin, p.origin);
    c.id = p.id.data();
    c.position = numbers(p.position.data());
    c.velocity = numbers(p.velocity.data());
    c.temperature = p.temperature.data();
    c.liquid_fraction = p.liquid_fraction.data();
    c.density = p.density.data();
    c.pressure = p.pressure.data();
    c.tag = p.tag.data();
    c.piece = p.piece.data();
    write(particles, "particles", c);
  });
}
meltsim_status meltsim_reading_probe(const meltsim_reading* reading, size_t index,
                                     meltsim_probe_series* series) {
  return guarded([&] {
    const auto& all = given(reading, "reading").reading.probes;
    if (index >= all.size())
      refuse("index: " + std::to_string(index) + ", but the reading has " + std::to_string(all.size()) +
             " series; ask for MELTSIM_READ_PROBES");
    const meltsim::ProbeSeries& s = all[index];
    meltsim_probe_series c{};
    c.points = s.points;
    c.width = s.width;
    c.samples = s.time.size();
    c.time = s.time.data();
    c.values = s.values.data();
    write(series, "series", c);
  });
}
void meltsim_reading_destroy(meltsim_reading* reading) { delete reading; }

meltsim_status meltsim_world_particles(meltsim_world* world, meltsim_particles* particles) {
  return guarded([&] {
    meltsim_particles to = read(particles, "particles", meltsim_particles{});
    const meltsim::ParticleData p = expect(world_of(world).particles());
    to.count = p.id.size();
    write(particles, "particles", to);
    if (to.count > to.capacity)
      throw Refused{{ErrorCode::capacity, "particles.capacity: " + std::to_string(to.capacity) +
                                              ", but there are " + std::to_string(to.count) +
                                              " particles; raise it"}};
    const auto copy = [](const auto& from, auto* array) {
      if (array != nullptr && !from.empty()) std::memcpy(array, from.data(), from.size() * sizeof from[0]);
    };
    static_assert(sizeof(Vec3d) == 3 * sizeof(double), "three numbers");
    copy(p.id, to.id);
    copy(p.position, to.position);
    copy(p.velocity, to.velocity);
    copy(p.temperature, to.temperature);
    copy(p.liquid_fraction, to.liquid_fraction);
    copy(p.tag, to.tag);
  });
}
meltsim_status meltsim_world_fractions(meltsim_world* world, meltsim_id species, double* values,
                                       uint64_t capacity, uint64_t* count) {
  return guarded([&] {
    const meltsim::ParticleData p = expect(world_of(world).particles());
    const auto found = std::find(p.species.begin(), p.species.end(), handle<meltsim::MaterialId>(species));
    if (found == p.species.end())
      throw Refused{{ErrorCode::invalid_argument,
                     "species: is no species of this World; pass an id of meltsim_world_add_species()"}};
    given(count, "count") = p.id.size();
    if (p.id.size() > capacity)
      throw Refused{{ErrorCode::capacity, "capacity: " + std::to_string(capacity) + ", but there are " +
                                              std::to_string(p.id.size()) + " particles; raise it"}};
    if (!p.id.empty()) given(values, "values");
    const std::vector<double>& from = p.fractions[static_cast<std::size_t>(found - p.species.begin())];
    std::copy(from.begin(), from.end(), values);
  });
}
meltsim_status meltsim_world_sample(meltsim_world* world, const double* points, size_t point_count,
                                    const char* field, double* values) {
  return guarded([&] {
    if (point_count > 0) given(points, "points"), given(values, "values");
    at_most(point_count, meltsim::most_sample_points, "point_count");
    std::vector<Vec3d> at;
    for (size_t i = 0; i < point_count; ++i) at.push_back(vec(points + 3 * i));
    const std::vector<double> found = expect(world_of(world).sample(at, std::string(&given(field, "field"))));
    std::copy(found.begin(), found.end(), values);
  });
}

meltsim_status meltsim_world_cast_rays(meltsim_world* world, const meltsim_ray* rays, size_t ray_count,
                                       uint32_t sought, meltsim_ray_hit* hits, size_t struct_size) {
  return guarded([&] {
    if (ray_count > 0) given(rays, "rays");
    at_most(ray_count, meltsim::most_rays, "ray_count");
    check_room(hits, "hits", "meltsim_ray_hit", struct_size, ray_count, ray_count);
    std::vector<meltsim::Ray> all;
    for (size_t k = 0; k < ray_count; ++k)
      all.push_back({vec(rays[k].origin), vec(rays[k].direction), rays[k].length});
    auto* to = reinterpret_cast<unsigned char*>(hits);
    for (const meltsim::RayHit& h : expect(world_of(world).cast_rays(all, sought))) {
      meltsim_ray_hit c{};
      c.what = static_cast<uint32_t>(h.what);
      c.wall = h.wall;
      c.distance = h.distance;
      put(c.point, h.point);
      put(c.normal, h.normal);
      c.body = id_of(h.body);
      c.particle = h.particle;
      std::memcpy(to, &c, struct_size);
      to += struct_size;
    }
  });
}
meltsim_status meltsim_world_liquid_in(meltsim_world* world, const meltsim_shape* shape, uint64_t* particles,
                                       double* volume) {
  return guarded([&] {
    const meltsim::Overlap o = expect(world_of(world).overlap(given(shape, "shape").shape));
    if (particles != nullptr) *particles = o.liquid;
    if (volume != nullptr) *volume = o.liquid_volume;
  });
}
meltsim_status meltsim_world_bodies_in(meltsim_world* world, const meltsim_shape* shape, meltsim_id* bodies,
                                       uint64_t* particles, size_t capacity, size_t* count) {
  return guarded([&] {
    given(count, "count");
    const meltsim::Overlap o = expect(world_of(world).overlap(given(shape, "shape").shape));
    *count = o.bodies.size();
    check_room(bodies, "bodies", "meltsim_id", sizeof(meltsim_id), capacity, o.bodies.size());
    for (size_t k = 0; k < o.bodies.size(); ++k) {
      bodies[k] = id_of(o.bodies[k].body);
      if (particles != nullptr) particles[k] = o.bodies[k].particles;
    }
  });
}

}  // extern "C"

namespace {
meltsim::SurfaceDesc surface_of(const meltsim_surface_desc* desc) {
  const meltsim_surface_desc c = read(desc, "desc", defaults_of<meltsim_surface_desc>());
  meltsim::SurfaceDesc d;
  d.of = option<meltsim::SurfaceOf>(c.of, 2, "desc.of");
  if (d.of == meltsim::SurfaceOf::body) d.body = handle<meltsim::BodyId>(c.body);
  d.cell = c.cell;
  d.kernel = c.anisotropic != 0 ? meltsim::SurfaceKernel::anisotropic : meltsim::SurfaceKernel::isotropic;
  d.smoothing = c.smoothing;
  d.closed_at_solids = c.closed_at_solids != 0;
  d.wait = c.no_wait == 0;
  return d;
}

meltsim_stage_context context_of(const meltsim::StageContext& s, const Vec3d& origin) {
  meltsim_stage_context c{};
  c.size = sizeof c;
  c.backend = static_cast<int32_t>(s.backend);
  c.double_precision = s.precision == meltsim::Precision::double_precision ? 1 : 0;
  c.stream = s.stream;
  c.dt = s.dt;
  c.time = s.time;
  put(c.origin, origin);
  c.particles = s.particles;
  c.position = s.position;
  c.velocity = s.velocity;
  c.acceleration = s.acceleration;
  c.enthalpy = s.enthalpy;
  c.enthalpy_of_id = s.enthalpy_of_id;
  c.id = s.id;
  c.tag = s.tag;
  static_assert(sizeof(meltsim_stage_clock) == sizeof(meltsim::StageClock) &&
                    offsetof(meltsim_stage_clock, dt) == offsetof(meltsim::StageClock, length),
                "the clock is the library's own");
  c.clock = reinterpret_cast<const meltsim_stage_clock*>(s.clock);
  c.serial = s.serial;
  return c;
}

void run_stage(const meltsim::StageContext& context, void* user) {
  const auto& stage = *static_cast<const StageOfHost*>(user);
  const meltsim_stage_context c = context_of(context, stage.origin);
  stage.run(&c, stage.user);
}

std::vector<std::string> names(const char* const* from, uint64_t count, const char* name) {
  std::vector<std::string> all;
  if (count > 0) given(from, name);
  for (uint64_t k = 0; k < count; ++k) all.emplace_back(&given(from[k], name));
  return all;
}
}  // namespace

extern "C" {

meltsim_status meltsim_world_surface(meltsim_world* world, const meltsim_surface_desc* desc,
                                     meltsim_surface** surface) {
  if (surface != nullptr) *surface = nullptr;
  return guarded([&] {
    given(surface, "surface");
    const meltsim::SurfaceDesc d = surface_of(desc);
    auto made = std::make_unique<meltsim_surface>();
    made->mesh = expect(world_of(world).surface(d));
    *surface = made.release();
  });
}
meltsim_status meltsim_surface_mesh(const meltsim_surface* surface, meltsim_mesh* mesh) {
  return guarded([&] {
    const meltsim::SurfaceMesh& m = given(surface, "surface").mesh;
    meltsim_mesh c{};
    c.vertices = m.position.size();
    c.triangles = m.triangles.size() / 3;
    put(c.origin, m.origin);
    c.position = numbers(m.position.data());
    c.normal = numbers(m.normal.data());
    c.temperature = m.temperature.data();
    c.liquid_fraction = m.liquid_fraction.data();
    c.body = m.body.data();
    c.material = m.material.data();
    c.triangle = m.triangles.data();
    write(mesh, "mesh", c);
  });
}
void meltsim_surface_destroy(meltsim_surface* surface) { delete surface; }

meltsim_status meltsim_world_render_view(meltsim_world* world, const meltsim_render_desc* desc,
                                         meltsim_render_view* view) {
  return guarded([&] {
    const meltsim_render_desc known = defaults_of<meltsim_render_desc>();
    const meltsim_render_desc c = desc != nullptr ? read(desc, "desc", known) : known;
    meltsim::RenderDesc d;
    d.color = option<meltsim::ColorBy>(c.color, 2, "desc.color");
    if (c.color_count > 256) refuse("desc.color_count: at most 256, got " + std::to_string(c.color_count));
    if (c.color_count > 0) d.colors.assign(&given(c.colors, "desc.colors"), c.colors + c.color_count);
    d.coldest = c.coldest;
    d.hottest = c.hottest;
    read(view, "view", meltsim_render_view{});
    const meltsim::RenderView v = expect(world_of(world).render_view(d));
    meltsim_render_view to{};
    to.backend = static_cast<int32_t>(v.backend);
    to.stream = v.stream;
    to.count = v.count;
    put(to.origin, v.origin);
    to.radius = static_cast<double>(v.radius);
    to.position = numbers(v.position);
    to.velocity = numbers(v.velocity);
    to.temperature = v.temperature;
    to.liquid_fraction = v.liquid_fraction;
    to.density = v.density;
    to.pressure = v.pressure;
    to.tag = v.tag;
    to.piece = v.piece;
    to.color = v.color;
    to.serial = v.serial;
    write(view, "view", to);
  });
}
meltsim_status meltsim_world_surface_view(meltsim_world* world, const meltsim_surface_desc* desc,
                                          meltsim_surface_view* view) {
  return guarded([&] {
    const meltsim::SurfaceDesc d = surface_of(desc);
    read(view, "view", meltsim_surface_view{});
    const meltsim::SurfaceView v = expect(world_of(world).surface_view(d));
    meltsim_surface_view to{};
    to.backend = static_cast<int32_t>(v.backend);
    to.stream = v.stream;
    put(to.origin, v.origin);
    to.vertices = v.vertices;
    to.triangles = v.triangles;
    to.position = numbers(v.position);
    to.normal = numbers(v.normal);
    to.temperature = v.temperature;
    to.liquid_fraction = v.liquid_fraction;
    to.body = v.body;
    to.material = v.material;
    to.triangle = v.triangle;
    to.draw = reinterpret_cast<const uint32_t*>(v.draw);
    to.serial = v.serial;
    write(view, "view", to);
  });
}
meltsim_status meltsim_world_device_state(meltsim_world* world, meltsim_stage_context* state) {
  return guarded([&] {
    meltsim::World& w = world_of(world);
    read(state, "state", meltsim_stage_context{});
    const meltsim::StageContext s = expect(w.device_state());
    write(state, "state", context_of(s, w.resolved().origin));
  });
}
meltsim_status meltsim_world_add_stage(meltsim_world* world, const meltsim_stage_desc* desc) {
  return guarded([&] {
    meltsim::World& w = world_of(world);
    const meltsim_stage_desc c = read(desc, "desc", defaults_of<meltsim_stage_desc>());
    auto stage = std::make_unique<StageOfHost>();
    stage->name = &given(c.name, "desc.name");
    stage->run = c.run;
    stage->user = c.user;
    if (c.run == nullptr) refuse("desc.run: is null");
    meltsim::CustomStage custom;
    custom.name = stage->name;
    custom.run = run_stage;
    custom.user = stage.get();
    custom.reads = names(c.reads, c.read_count, "desc.reads");
    custom.writes = names(c.writes, c.write_count, "desc.writes");
    custom.recorded = c.recorded != 0;
    world->stages.reserve(world->stages.size() + 1);
    expect(w.scheduler().insert_after(c.after != nullptr ? c.after : "sph.forces", custom));
    world->stages.push_back(std::move(stage));
  });
}
meltsim_status meltsim_world_remove_stage(meltsim_world* world, const char* name) {
  return guarded([&] {
    meltsim::World& w = world_of(world);
    const std::string sought(&given(name, "name"));
    expect(w.scheduler().remove(sought));
    auto& all = world->stages;
    all.erase(
        std::remove_if(all.begin(), all.end(), [&](const auto& stage) { return stage->name == sought; }),
        all.end());
  });
}
meltsim_status meltsim_world_set_interval(meltsim_world* world, const char* module, int32_t n) {
  return guarded([&] { expect(world_of(world).scheduler().set_interval(&given(module, "module"), n)); });
}
meltsim_status meltsim_world_interval(meltsim_world* world, const char* stage, int32_t* n) {
  return guarded([&] {
    meltsim::World& w = world_of(world);
    const std::string sought(&given(stage, "stage"));
    given(n, "n");
    expect(w.prepare());
    const meltsim::Plan plan = w.plan();
    for (const meltsim::StageReport& s : plan.stages)
      if (s.name == sought) return static_cast<void>(*n = s.interval);
    refuse("stage: none is named \"" + sought + "\"; \"thermal.exchange\" and \"topology.melt\" are two");
  });
}
meltsim_status meltsim_world_enable(meltsim_world* world, const char* module, int32_t on) {
  return guarded([&] { expect(world_of(world).scheduler().enable(&given(module, "module"), on != 0)); });
}
meltsim_status meltsim_world_wait_for(meltsim_world* world, void* event) {
  return guarded([&] { expect(world_of(world).wait_for(event)); });
}
meltsim_status meltsim_world_signal(meltsim_world* world, void* event) {
  return guarded([&] { expect(world_of(world).signal(event)); });
}
meltsim_status meltsim_world_check_view(meltsim_world* world, const meltsim_render_view* view) {
  return guarded([&] {
    meltsim::RenderView v;
    v.serial = read(view, "view", meltsim_render_view{}).serial;
    expect(world_of(world).check_view(v));
  });
}
meltsim_status meltsim_world_check_surface_view(meltsim_world* world, const meltsim_surface_view* view) {
  return guarded([&] {
    meltsim::SurfaceView v;
    v.serial = read(view, "view", meltsim_surface_view{}).serial;
    expect(world_of(world).check_view(v));
  });
}
meltsim_status meltsim_world_check_device_state(meltsim_world* world, const meltsim_stage_context* state) {
  return guarded([&] {
    meltsim::StageContext s;
    s.serial = read(state, "state", meltsim_stage_context{}).serial;
    expect(world_of(world).check_view(s));
  });
}

meltsim_status meltsim_world_snapshot(meltsim_world* world, void* buffer, size_t capacity, size_t* bytes) {
  return guarded([&] {
    given(bytes, "bytes");
    put_bytes(expect(world_of(world).snapshot()), buffer, capacity, *bytes);
  });
}
meltsim_status meltsim_world_save(meltsim_world* world, void* buffer, size_t capacity, size_t* bytes) {
  return guarded([&] {
    given(bytes, "bytes");
    put_bytes(expect(world_of(world).save()), buffer, capacity, *bytes);
  });
}
meltsim_status meltsim_world_load_saved(meltsim_world* world, const void* data, size_t bytes) {
  return guarded([&] {
    given(static_cast<const std::uint8_t*>(data), "data");
    expect(world_of(world).load_saved(data, bytes));
  });
}
meltsim_status meltsim_world_bodies(meltsim_world* world, meltsim_body_info* bodies, size_t struct_size,
                                    size_t capacity, size_t* count) {
  return guarded([&] {
    std::vector<meltsim::BodyInfo> all = expect(world_of(world).bodies());
    given(count, "count") = all.size();
    check_room(bodies, "bodies", "meltsim_body_info", struct_size, capacity, all.size());
    world->bodies = std::move(all);
    auto* to = reinterpret_cast<unsigned char*>(bodies);
    for (const meltsim::BodyInfo& b : world->bodies) {
      const meltsim_body_info c{id_of(b.body), id_of(b.material), static_cast<std::int32_t>(b.motion),
                                b.held ? 1 : 0, b.name.c_str()};
      std::memcpy(to, &c, struct_size);
      to += struct_size;
    }
  });
}
meltsim_status meltsim_world_restore(meltsim_world* world, const void* data, size_t bytes) {
  return guarded([&] {
    given(static_cast<const std::uint8_t*>(data), "data");
    expect(world_of(world).restore(data, bytes));
  });
}
meltsim_status meltsim_world_save_state(meltsim_world* world, int32_t slot) {
  return guarded([&] { expect(world_of(world).save_state(slot)); });
}
meltsim_status meltsim_world_load_state(meltsim_world* world, int32_t slot) {
  return guarded([&] { expect(world_of(world).load_state(slot)); });
}
meltsim_status meltsim_world_state_hash(meltsim_world* world, uint64_t* hash) {
  return guarded([&] {
    given(hash, "hash");
    *hash = expect(world_of(world).state_hash());
  });
}

}  // extern "C"
