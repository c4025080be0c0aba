# SPDX-License-Identifier: Apache-2.0
"""host.py LIBRARY: a host in another language (ctypes) through the C interface: exact answers, and mistakes. Standard library only."""
import ctypes as c
import math
import sys

lib = c.CDLL(sys.argv[1])
lib.meltsim_error_text.restype = c.c_char_p
lib.meltsim_world_time.restype = c.c_double
lib.meltsim_world_stable_dt.restype = c.c_double
lib.meltsim_world_steps.restype = c.c_uint64
Vec = c.c_double * 3


class Id(c.Structure):
    _fields_ = [("index", c.c_uint32), ("generation", c.c_uint32)]


class SurfaceHeat(c.Structure):
    _fields_ = [("has_temperature", c.c_int32), ("reserved", c.c_int32), ("temperature", c.c_double), ("flux", c.c_double),
                ("convection", c.c_double), ("emissivity", c.c_double), ("ambient", c.c_double)]


class WorldDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("version", c.c_uint32), ("backend", c.c_int32), ("double_precision", c.c_int32),
                ("device", c.c_int32), ("threads", c.c_int32), ("spacing", c.c_double), ("bounded", c.c_int32), ("no_slip", c.c_int32),
                ("min", Vec), ("max", Vec), ("faces", c.c_int32 * 6), ("gravity", Vec), ("sound_speed", c.c_double),
                ("heat_model", c.c_int32), ("max_substeps", c.c_int32), ("heat_time_scale", c.c_double), ("wall_heat", SurfaceHeat * 6)]


class Outlet(c.Structure):
    _fields_ = [("kind", c.c_int32), ("reserved", c.c_int32), ("value", c.c_double)]


class WholeWorldDesc(WorldDesc):
    _fields_ = [("outlets", Outlet * 6), ("density_error", c.c_double), ("heat_interval", c.c_int32), ("follow_sound_speed", c.c_int32),
                ("reserved_particles", c.c_uint64), ("support_radius", c.c_double), ("artificial_viscosity", c.c_double),
                ("tension", c.c_int32), ("isotropic_pressure", c.c_int32), ("particle_shifting", c.c_int32), ("neighbour_search", c.c_int32),
                ("viscosity", c.c_int32), ("stray", c.c_int32), ("courant", c.c_double), ("pieces_interval", c.c_int32),
                ("heat_max_stages", c.c_int32), ("heat_max_supersteps", c.c_int32), ("solute_max_supersteps", c.c_int32),
                ("solute_time_scale", c.c_double), ("heat_level_tolerance", c.c_double), ("free_surface", SurfaceHeat),
                ("wall_friction", c.c_double), ("wall_contact_angle", c.c_double), ("wall_velocity", Vec * 6), ("stream", c.c_void_p),
                ("hydrostatic_start", c.c_int32), ("reserved", c.c_int32)]


class MaterialDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("freezes", c.c_int32), ("name", c.c_char_p), ("density", c.c_double), ("rest", c.c_double * 5),
                ("melts_into", Id), ("more", c.c_double * 9),
                ("yield_stress_points", c.POINTER(c.c_double)), ("yield_stress_point_count", c.c_size_t)]


class WholeMaterialDesc(MaterialDesc):
    _fields_ = [("damping", c.c_double), ("diffusivity", c.c_double)] + [
        (name + end, kind) for name in ("conductivity", "heat_capacity", "viscosity", "density")
        for end, kind in (("_points", c.POINTER(c.c_double)), ("_point_count", c.c_size_t))]


class SolidDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("motion", c.c_int32), ("name", c.c_char_p), ("shape", c.c_void_p), ("material", Id),
                ("temperature", c.c_double), ("velocity", Vec), ("angular_velocity", Vec), ("max_speed", c.c_double), ("surface", SurfaceHeat), ("heat_source", c.c_double),
                ("has_pivot", c.c_int32), ("reserved", c.c_int32), ("pivot", Vec), ("mass", c.c_double), ("inertia", c.c_double * 9)]


class WholeSolidDesc(SolidDesc):
    _fields_ = [("held_until", c.c_double), ("carve", c.c_int32), ("growth", c.c_int32)]


class ProxyState(c.Structure):
    _fields_ = [("size", c.c_uint32), ("teleport", c.c_int32), ("position", Vec), ("orientation", c.c_double * 4), ("velocity", Vec),
                ("angular_velocity", Vec), ("acceleration", Vec)]


class BodyForces(c.Structure):
    _fields_ = [("body", Id), ("seconds", c.c_double), ("impulse", Vec), ("angular_impulse", Vec), ("parts", Vec * 6), ("heat", c.c_double),
                ("position", Vec), ("orientation", c.c_double * 4), ("velocity", Vec), ("angular_velocity", Vec)]


class Event(c.Structure):
    _fields_ = [("kind", c.c_uint32), ("wall", c.c_int32), ("step", c.c_uint64), ("time", c.c_double), ("position", Vec),
                ("particle", c.c_uint32), ("piece", c.c_uint32), ("from_", c.c_uint32), ("reserved", c.c_uint32), ("body", Id), ("other", Id)]


class ProbeDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("kind", c.c_int32), ("name", c.c_char_p), ("points", c.POINTER(c.c_double)), ("point_count", c.c_uint64),
                ("fields", c.POINTER(c.c_char_p)), ("field_count", c.c_uint64), ("body", Id), ("wall", c.c_int32), ("reserved", c.c_int32),
                ("normal", Vec), ("radius", c.c_double), ("along", Vec), ("side", c.c_double * 2), ("every", c.c_double), ("from_", c.c_double),
                ("until", c.c_double)]


class ProbeSeries(c.Structure):
    _fields_ = [("size", c.c_uint32), ("points", c.c_uint32), ("width", c.c_uint32), ("reserved", c.c_uint32), ("samples", c.c_uint64),
                ("time", c.POINTER(c.c_double)), ("values", c.POINTER(c.c_double))]


class SurfaceDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("of", c.c_int32), ("body", Id), ("cell", c.c_double), ("anisotropic", c.c_int32), ("smoothing", c.c_int32),
                ("closed_at_solids", c.c_int32), ("no_wait", c.c_int32)]


class Mesh(c.Structure):
    _fields_ = [("size", c.c_uint32), ("reserved", c.c_uint32), ("vertices", c.c_uint64), ("triangles", c.c_uint64), ("origin", Vec),
                ("position", c.POINTER(c.c_float)), ("normal", c.POINTER(c.c_float)), ("temperature", c.POINTER(c.c_float)),
                ("liquid_fraction", c.c_void_p), ("body", c.POINTER(c.c_uint32)), ("material", c.c_void_p), ("triangle", c.POINTER(c.c_uint32))]


class Piece(c.Structure):
    _fields_ = [("body", Id), ("piece", c.c_uint32), ("reserved", c.c_uint32), ("particles", c.c_uint64), ("mass", c.c_double), ("center", Vec),
                ("velocity", Vec), ("orientation", c.c_double * 4), ("angular_velocity", Vec), ("inertia", c.c_double * 9), ("min", Vec),
                ("max", Vec), ("temperature_mean", c.c_double), ("submerged_fraction", c.c_double)]


class ParticleFrame(c.Structure):
    _fields_ = [("size", c.c_uint32), ("reserved", c.c_uint32), ("count", c.c_uint64), ("origin", Vec), ("id", c.POINTER(c.c_uint32)),
                ("position", c.POINTER(c.c_float)), ("velocity", c.POINTER(c.c_float)), ("temperature", c.POINTER(c.c_float)),
                ("liquid_fraction", c.c_void_p), ("density", c.c_void_p), ("pressure", c.c_void_p), ("tag", c.POINTER(c.c_uint32)),
                ("piece", c.POINTER(c.c_uint32))]


class RenderDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("color", c.c_int32), ("colors", c.POINTER(c.c_uint32)), ("color_count", c.c_uint64),
                ("coldest", c.c_double), ("hottest", c.c_double)]


class RenderView(c.Structure):
    _fields_ = [("size", c.c_uint32), ("backend", c.c_int32), ("stream", c.c_void_p), ("count", c.c_uint64), ("origin", Vec), ("radius", c.c_double),
                ("position", c.POINTER(c.c_float)), ("velocity", c.c_void_p), ("temperature", c.POINTER(c.c_float)), ("rest", c.c_void_p * 3),
                ("tag", c.POINTER(c.c_uint32)), ("piece", c.c_void_p), ("color", c.POINTER(c.c_uint32)), ("serial", c.c_uint64)]


class SurfaceView(c.Structure):
    _fields_ = [("size", c.c_uint32), ("backend", c.c_int32), ("stream", c.c_void_p), ("origin", Vec), ("vertices", c.c_uint64),
                ("triangles", c.c_uint64), ("position", c.POINTER(c.c_float)), ("rest", c.c_void_p * 3), ("body", c.POINTER(c.c_uint32)),
                ("material", c.c_void_p), ("triangle", c.POINTER(c.c_uint32)), ("draw", c.POINTER(c.c_uint32)), ("serial", c.c_uint64)]


class StageContext(c.Structure):
    _fields_ = [("size", c.c_uint32), ("backend", c.c_int32), ("double_precision", c.c_int32), ("reserved", c.c_int32), ("stream", c.c_void_p),
                ("dt", c.c_double), ("time", c.c_double), ("origin", Vec), ("particles", c.c_uint64), ("position", c.POINTER(c.c_float)),
                ("velocity", c.POINTER(c.c_float)), ("acceleration", c.POINTER(c.c_float)), ("enthalpy", c.c_void_p), ("enthalpy_of_id", c.c_void_p),
                ("id", c.POINTER(c.c_uint32)), ("tag", c.POINTER(c.c_uint32)), ("clock", c.POINTER(c.c_double)), ("serial", c.c_uint64)]


StageFunction = c.CFUNCTYPE(None, c.POINTER(StageContext), c.c_void_p)


class StageDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("recorded", c.c_int32), ("name", c.c_char_p), ("after", c.c_char_p), ("run", StageFunction),
                ("user", c.c_void_p), ("reads", c.POINTER(c.c_char_p)), ("read_count", c.c_uint64), ("writes", c.POINTER(c.c_char_p)),
                ("write_count", c.c_uint64)]


class Report(c.Structure):
    _fields_ = [("size", c.c_uint32), ("halted", c.c_int32), ("steps", c.c_uint64), ("time", c.c_double), ("max_speed", c.c_double),
                ("counts", c.c_uint64 * 5)]


class Ray(c.Structure):
    _fields_ = [("origin", Vec), ("direction", Vec), ("length", c.c_double)]


class RayHit(c.Structure):
    _fields_ = [("what", c.c_uint32), ("wall", c.c_int32), ("distance", c.c_double), ("point", Vec), ("normal", Vec), ("body", Id),
                ("particle", c.c_uint32), ("reserved", c.c_uint32)]


class EmitterSetting(c.Structure):
    _fields_ = [("size", c.c_uint32), ("has_on", c.c_int32), ("has_speed", c.c_int32), ("has_temperature", c.c_int32), ("on", c.c_int32),
                ("reserved", c.c_int32), ("speed", c.c_double), ("temperature", c.c_double), ("center", Vec), ("has_center", c.c_int32),
                ("reserved2", c.c_int32)]


class EmitterDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("reserved", c.c_uint32), ("name", c.c_char_p), ("center", Vec), ("axis", Vec),
                ("radius", c.c_double), ("speed", c.c_double), ("material", Id), ("temperature", c.c_double), ("from_", c.c_double),
                ("until", c.c_double), ("max_particles", c.c_uint64)]


class FaceReport(Report):
    _fields_ = [("entered", c.c_uint64)]


class FaceSetting(EmitterSetting):
    _fields_ = [("level", c.c_double), ("has_level", c.c_int32), ("reserved3", c.c_int32)]


class FaceDesc(EmitterDesc):
    _fields_ = [("width", c.c_double), ("height", c.c_double), ("up", Vec), ("level", c.c_double), ("has_level", c.c_int32),
                ("reserved2", c.c_int32)]


class HeatRegionDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("has_temperature", c.c_int32), ("name", c.c_char_p), ("shape", c.c_void_p),
                ("temperature", c.c_double), ("source", c.c_double), ("from_", c.c_double), ("until", c.c_double)]


class ForceFieldDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("kind", c.c_int32), ("name", c.c_char_p), ("shape", c.c_void_p), ("acceleration", Vec),
                ("has_center", c.c_int32), ("power", c.c_int32), ("center", Vec), ("axis", Vec), ("strength", c.c_double),
                ("radius", c.c_double), ("velocity", Vec), ("angular_velocity", Vec), ("rate", c.c_double), ("from_", c.c_double),
                ("until", c.c_double), ("liquid", c.c_int32), ("bodies", c.c_int32)]


class Totals(c.Structure):
    _fields_ = [("size", c.c_uint32), ("reserved", c.c_uint32), ("mass", c.c_double), ("rest", c.c_double * 7), ("heat_in", c.c_double),
                ("temperatures", Vec), ("field_work", c.c_double), ("field_impulse", Vec)]


class TimedStep(c.Structure):
    _fields_ = [("size", c.c_uint32), ("over_budget", c.c_int32), ("simulated", c.c_double), ("owed", c.c_double), ("substeps", c.c_uint64),
                ("planned", c.c_uint64), ("wall_ms", c.c_double), ("substep_ms", c.c_double)]


class Particles(c.Structure):
    _fields_ = [("size", c.c_uint32), ("reserved", c.c_uint32), ("capacity", c.c_uint64), ("count", c.c_uint64), ("id", c.c_void_p),
                ("position", c.POINTER(c.c_double)), ("velocity", c.POINTER(c.c_double)), ("temperature", c.POINTER(c.c_double)),
                ("liquid_fraction", c.c_void_p), ("tag", c.c_void_p)]


def text():
    return lib.meltsim_error_text().decode()


def made(struct, init):
    value = struct()
    init(c.byref(value), c.c_size_t(c.sizeof(value)))
    assert value.size == c.sizeof(struct), (struct.__name__, value.size, c.sizeof(struct))
    return value


def world(heat_model=0, ident_of=None, **body):
    desc = made(WorldDesc, lib.meltsim_world_desc_init_sized)
    desc.spacing, desc.backend, desc.threads, desc.heat_model = 0.1, 1, 1, heat_model
    handle = c.c_void_p()
    assert lib.meltsim_world_create(c.byref(desc), c.byref(handle)) == 0, text()
    material, ident = made(MaterialDesc, lib.meltsim_material_desc_init_sized), Id()
    material.name, material.density = b"ice", 917
    assert lib.meltsim_world_add_material(handle, c.byref(material), c.byref(ident)) == 0, text()
    shape = c.c_void_p()
    assert lib.meltsim_shape_box(Vec(0, 0, 0), Vec(0.3, 0.3, 0.3), c.byref(shape)) == 0, text()
    solid = made(SolidDesc, lib.meltsim_solid_desc_init_sized)
    solid.shape, solid.material, solid.velocity = shape, ident, Vec(1, 2, 0)
    for key, value in body.items():
        setattr(solid, key, value)
    assert lib.meltsim_world_add_solid(handle, c.byref(solid), ident_of) == 0, text()
    lib.meltsim_shape_destroy(shape)
    return handle


def particles(handle, room):
    p = Particles(size=c.sizeof(Particles), capacity=room)
    position, velocity = (c.c_double * (3 * room))(), (c.c_double * (3 * room))()
    p.position, p.velocity = position, velocity
    return lib.meltsim_world_particles(handle, c.byref(p)), p.count, position, velocity


def state_hash(handle):
    value = c.c_uint64()
    assert lib.meltsim_world_state_hash(handle, c.byref(value)) == 0, text()
    return value.value


step = lambda handle, seconds: lib.meltsim_world_step(handle, c.c_double(seconds))  # noqa: E731

# Free fall: leap-frog integrates a constant force exactly; 2e-6: single precision of 1 m and, of the body's mean, of 2 m/s over 70
# sub-steps. Its particles tremble: shape matching answers to the rounding of their positions, 2^-25 m between 0.25 and 0.5 m, over a
# sub-step. Measured: 0.7 of that where multiplications and additions are fused, 3.3 where they are not (MELTSIM_REPRODUCIBLE); 4 allowed.
a = world()
status, count, before, _ = particles(a, 27)
assert (status, count) == (0, 27), text()
for _ in range(10):
    assert step(a, 0.02) == 0, text()
_, _, after, velocity = particles(a, 27)
substep = 0.02 / math.ceil(0.02 / lib.meltsim_world_stable_dt(a))
for i in range(27):
    for k, moved in enumerate((0.2, 2 * 0.2 - 0.5 * 9.81 * 0.04, 0)):
        assert abs(after[3 * i + k] - before[3 * i + k] - moved) < 2e-6
    assert abs(velocity[3 * i + 1] - (2 - 9.81 * 0.2)) < 4 * 2**-25 / substep, velocity[3 * i + 1]
assert abs(sum(velocity[1::3]) / 27 - (2 - 9.81 * 0.2)) < 2e-6
assert abs(lib.meltsim_world_time(a) - 0.2) < 1e-12

# A snapshot goes on with the same bits, in another World too.
size = c.c_size_t()
assert lib.meltsim_world_snapshot(a, None, 0, c.byref(size)) == 5 and "capacity" in text()  # MELTSIM_CAPACITY
buffer = c.create_string_buffer(size.value)
assert lib.meltsim_world_snapshot(a, buffer, size, c.byref(size)) == 0, text()
assert step(a, 0.02) == 0
b = world()
assert lib.meltsim_world_restore(b, buffer, size) == 0, text()
assert state_hash(b) != state_hash(a)
assert step(b, 0.02) == 0
assert state_hash(b) == state_hash(a)

# A source of 1 kW/m^3 in the body, or in a region around it, for 0.1 s: 0.027 m^3 take 2.7 J, to rounding.
for source in ("body", "region"):
    heated = world(3, heat_source=1000 if source == "body" else 0)
    if source == "region":
        region, shape = made(HeatRegionDesc, lib.meltsim_heat_region_desc_init_sized), c.c_void_p()
        assert lib.meltsim_shape_box(Vec(-1, -1, -1), Vec(2, 2, 2), c.byref(shape)) == 0, text()
        region.shape, region.source = shape, 1000
        assert lib.meltsim_world_add_heat_region(heated, c.byref(region), None) == 0, text()
        lib.meltsim_shape_destroy(shape)
    totals = Totals(size=c.sizeof(Totals))
    assert step(heated, 0.1) == 0 and lib.meltsim_world_totals(heated, c.byref(totals)) == 0, text()
    assert abs(totals.heat_in - 2.7) < 1e-6, totals.heat_in
    lib.meltsim_world_destroy(heated)

# A field of 3 m/s^2 upwards in a sphere around the body, then of -3, then none: 24.759 kg gain 7.4277 N s in 0.1 s and lose them again.
# Single precision of 1 m/s and 25 kg: 1e-4.
blown, field, ball, where = world(), made(ForceFieldDesc, lib.meltsim_force_field_desc_init_sized), c.c_void_p(), Id()
assert lib.meltsim_world_set_gravity(blown, Vec(0, 0, 0)) == 0, text()
assert lib.meltsim_shape_sphere(Vec(0.15, 0.15, 0.15), c.c_double(2), c.byref(ball)) == 0, text()
field.shape, field.acceleration, field.name = ball, Vec(0, 3, 0), b"fan"
assert lib.meltsim_world_add_force_field(blown, c.byref(field), c.byref(where)) == 0, text()
for strength in (7.4277, 0, 0):
    assert step(blown, 0.1) == 0, text()
    assert lib.meltsim_world_totals(blown, c.byref(totals)) == 0 and abs(totals.field_impulse[1] - strength) < 1e-4, totals.field_impulse[1]
    field.acceleration = Vec(0, -3 if strength else 0, 0)
    assert lib.meltsim_world_set_force_field(blown, where, c.byref(field)) == 0, text()
field.radius = -1
assert lib.meltsim_world_set_force_field(blown, where, c.byref(field)) == 1 and "radius" in text() and "fan" in text()
field.kind = 7
assert lib.meltsim_world_add_force_field(blown, c.byref(field), None) == 1 and "kind" in text()
assert lib.meltsim_world_remove_force_field(blown, where) == 0, text()
assert lib.meltsim_world_remove_force_field(blown, where) == 1 and "removed" in text()
lib.meltsim_shape_destroy(ball)
lib.meltsim_world_destroy(blown)

# A nozzle of radius R emits rho pi R^2 v t: here 1000 pi 0.04 2 0.5 = 126 kg.
tap, ident, totals = c.c_void_p(), Id(), Totals(size=c.sizeof(Totals))
# A host that was built against a header whose material ended with the stiffness of bodies, 40 bytes ago: nothing beyond its struct
# is written, and what it does not know has its default.
short = c.sizeof(MaterialDesc) - 40
room = (c.c_uint8 * c.sizeof(MaterialDesc))(*[0xAB] * c.sizeof(MaterialDesc))
lib.meltsim_material_desc_init_sized(c.byref(room), c.c_size_t(short))
assert c.c_uint32.from_buffer(room).value == short
assert bytes(room)[short:] == b"\xab" * 40
lib.meltsim_material_desc_init_sized(None, c.c_size_t(short))  # does nothing
old, old_id = c.c_void_p(), Id()
assert lib.meltsim_world_create(c.byref(made(WorldDesc, lib.meltsim_world_desc_init_sized)), c.byref(old)) == 0, text()
assert lib.meltsim_world_add_material(old, c.byref(room), c.byref(old_id)) == 0, text()
lib.meltsim_world_destroy(old)

desc = made(WorldDesc, lib.meltsim_world_desc_init_sized)
desc.spacing, desc.backend, desc.gravity = 0.1, 1, Vec(0, 0, 0)
assert lib.meltsim_world_create(c.byref(desc), c.byref(tap)) == 0, text()
material = made(MaterialDesc, lib.meltsim_material_desc_init_sized)
assert lib.meltsim_world_add_material(tap, c.byref(material), c.byref(ident)) == 0, text()
emitter = made(EmitterDesc, lib.meltsim_emitter_desc_init_sized)
emitter.radius, emitter.speed, emitter.until, emitter.material = 0.2, 2, 0.5, ident
nozzle, moves = Id(), made(EmitterSetting, lib.meltsim_emitter_setting_init_sized)
assert lib.meltsim_world_add_emitter(tap, c.byref(emitter), c.byref(nozzle)) == 0, text()
moves.has_center = 1
for k in range(10):  # it moves meanwhile
    moves.center = Vec(0.02 * k, 0, 0)
    assert step(tap, 0.05) == 0 and lib.meltsim_world_set_emitter(tap, nozzle, c.byref(moves)) == 0, text()
moves.center = Vec(math.inf, 0, 0)
assert lib.meltsim_world_set_emitter(tap, nozzle, c.byref(moves)) == 1 and "center" in text()
assert lib.meltsim_world_totals(tap, c.byref(totals)) == 0
assert abs(totals.mass - 125.66) < 13, totals.mass  # one layer of a spacing: 13 kg
lib.meltsim_world_destroy(tap)

# An open face below a level: what the report says has come in is there; an old host's report, which ends before, is left as long as it is.
desc = made(WorldDesc, lib.meltsim_world_desc_init_sized)
desc.spacing, desc.backend, desc.threads, desc.bounded, desc.max = 0.1, 1, 1, 1, Vec(1, 1, 0.5)
desc.faces[1] = 1  # +x, open
lake = c.c_void_p()
assert lib.meltsim_world_create(c.byref(desc), c.byref(lake)) == 0, text()
assert lib.meltsim_world_add_material(lake, c.byref(material), c.byref(ident)) == 0, text()
face = made(FaceDesc, lib.meltsim_emitter_desc_init_sized)
face.name, face.material, face.axis, face.has_level, face.level, face.height = b"lake", ident, Vec(-1, 0, 0), 1, 2, 0.8
assert lib.meltsim_world_add_emitter(lake, c.byref(face), c.byref(nozzle)) == 1 and "lake" in text() and "level" in text(), text()
face.level = 0.6
assert lib.meltsim_world_add_emitter(lake, c.byref(face), c.byref(nozzle)) == 0, text()
for k in range(60):
    assert step(lake, 0.02) == 0, text()
report, short = FaceReport(size=c.sizeof(FaceReport)), FaceReport(size=c.sizeof(Report), entered=4711)
assert lib.meltsim_world_synchronize(lake, c.byref(report)) == lib.meltsim_world_synchronize(lake, c.byref(short)) == 0
assert report.entered > 20 and report.counts[0] == report.entered and report.counts[4] == 0, (report.entered, list(report.counts))
assert short.entered == 4711 and short.counts[0] == report.counts[0]
tide = made(FaceSetting, lib.meltsim_emitter_setting_init_sized)
tide.has_level, tide.level = 1, 0.9  # above its height
assert lib.meltsim_world_set_emitter(lake, nozzle, c.byref(tide)) == 1 and "more than the opening's 0.8 m" in text(), text()
tide.level = 0.2
assert lib.meltsim_world_set_emitter(lake, nozzle, c.byref(tide)) == 0, text()
for k in range(60):
    assert step(lake, 0.02) == 0, text()
ebb = FaceReport(size=c.sizeof(FaceReport))
assert lib.meltsim_world_synchronize(lake, c.byref(ebb)) == 0
assert ebb.counts[4] > 20 and ebb.counts[0] == ebb.entered - ebb.counts[4], (ebb.entered, list(ebb.counts))
lib.meltsim_world_destroy(lake)

# A proxy in free fall: nothing acts on it, and its host says where it is. An impulse on a rigid body moves it by J/m.
hull = Id()
p = world(ident_of=c.byref(hull), motion=4, mass=5, max_speed=5)
state, forces, n = made(ProxyState, lib.meltsim_proxy_state_init_sized), (BodyForces * 1)(), c.c_size_t()
state.position, state.velocity = Vec(0.15, 0.15, 0.15), Vec(0, 1, 0)
assert lib.meltsim_world_set_proxy(p, hull, c.byref(state)) == 0, text()
assert step(p, 0.01) == 0, text()
ticket, ready, reading = c.c_uint64(), c.c_int32(), c.c_void_p()
assert lib.meltsim_world_request(p, 3, c.byref(ticket)) == 0, text()
assert step(p, 0.01) == 0, text()
assert lib.meltsim_world_ready(p, ticket, c.byref(ready)) == 0 and ready.value == 1, text()
assert lib.meltsim_world_take(p, ticket, c.byref(reading)) == 0, text()
assert lib.meltsim_reading_forces(reading, forces, c.sizeof(BodyForces), 0, c.byref(n)) == 5 and n.value == 1  # MELTSIM_CAPACITY
assert lib.meltsim_reading_forces(reading, forces, c.sizeof(BodyForces), 1, c.byref(n)) == 0, text()
assert abs(forces[0].seconds - 0.01) < 1e-9 and max(map(abs, forces[0].impulse)) < 1e-5 and forces[0].body.index == hull.index
assert abs(forces[0].velocity[1] - (1 - 9.81 * 0.01)) < 1e-6
totals = Totals(size=c.sizeof(Totals))
assert lib.meltsim_reading_totals(reading, c.byref(totals)) == 0 and abs(totals.mass - 5) < 1e-4, totals.mass
lib.meltsim_reading_destroy(reading)
assert lib.meltsim_world_take(p, ticket, c.byref(reading)) == 1 and "ticket" in text() and reading.value is None
assert lib.meltsim_world_take_forces(p, None, c.sizeof(BodyForces), 0, c.byref(n)) == 5 and n.value == 1
assert lib.meltsim_world_take_forces(p, forces, c.sizeof(BodyForces), 1, c.byref(n)) == 0, text()
assert abs(forces[0].seconds - 0.01) < 1e-9, "what did not fit was not lost"
assert lib.meltsim_world_take_forces(p, forces, 9999, 1, c.byref(n)) == 1 and "struct_size" in text()
assert lib.meltsim_world_proxy(p, hull, c.byref(state)) == 0 and abs(state.velocity[1] - (1 - 9.81 * 0.02)) < 1e-6, text()
state.velocity = Vec(math.nan, 0, 0)
assert lib.meltsim_world_set_proxy(p, hull, c.byref(state)) == 1 and "velocity" in text()
assert lib.meltsim_world_watch_forces(p, hull, 0) == 1 and "always watched" in text()
assert lib.meltsim_world_apply_impulse(p, hull, Vec(1, 0, 0), None) == 1 and "set_proxy" in text()
lib.meltsim_world_destroy(p)
r = world(ident_of=c.byref(hull), motion=3)
assert lib.meltsim_world_set_gravity(r, Vec(0, 0, 0)) == 0, text()
assert lib.meltsim_world_apply_impulse(r, hull, Vec(0, 0, 917 * 0.027), None) == 0, text()
assert step(r, 0.01) == 0, text()
velocity = particles(r, 27)[3]
assert abs(velocity[2] - 1) < 1e-5 and abs(velocity[1] - 2) < 1e-5, list(velocity)[:3]
assert lib.meltsim_world_set_velocity(r, hull, Vec(0, 0, 0), None) == 0, text()
assert lib.meltsim_world_set_material(r, Id(), c.byref(material)) == 1 and "material: no material of this World" in text()
assert lib.meltsim_world_set_wall_heat(r, 9, c.byref(SurfaceHeat())) == 1 and "face" in text()
assert lib.meltsim_world_set_heat_time_scale(r, c.c_double(-1)) == 1 and "time_scale" in text()
assert lib.meltsim_world_set_emitter(r, Id(0, 1), c.byref(made(EmitterSetting, lib.meltsim_emitter_setting_init_sized))) == 1 and "emitter" in text()
known = state_hash(r)
assert lib.meltsim_world_load_state(r, 2) == 1 and "nothing is saved" in text()
assert lib.meltsim_world_save_state(r, 2) == 0 and step(r, 0.01) == 0, text()
assert lib.meltsim_world_apply_impulse(r, hull, Vec(1, 0, 0), None) == 0 and state_hash(r) != known, text()
assert lib.meltsim_world_load_state(r, 2) == 0 and state_hash(r) == known, text()
assert lib.meltsim_world_save_state(r, 16) == 1 and "slot" in text()
assert lib.meltsim_world_remove(r, hull) == 0, text()
assert lib.meltsim_world_remove(r, hull) == 1 and "removed" in text()
was, count = c.POINTER(c.c_uint32)(), c.c_size_t()
assert lib.meltsim_world_compact(r, c.byref(was), c.byref(count)) == 0, text()
assert was[:count.value] == sorted(was[:count.value]) and lib.meltsim_world_compact(r, None, None) == 0, text()
assert step(r, 0.01) == 0 and lib.meltsim_world_remove(r, hull) == 1 and "removed" in text()
lib.meltsim_world_destroy(r)

# Events: a body that falls on a floor 0.3 m below begins one contact, with wall 2, after sqrt(2 h/g) = 0.247 s.
box, material, solid, shape = c.c_void_p(), made(MaterialDesc, lib.meltsim_material_desc_init_sized), made(SolidDesc, lib.meltsim_solid_desc_init_sized), c.c_void_p()
desc = made(WorldDesc, lib.meltsim_world_desc_init_sized)
desc.spacing, desc.backend, desc.bounded, desc.max = 0.1, 1, 1, Vec(1, 1, 1)
assert lib.meltsim_world_create(c.byref(desc), c.byref(box)) == 0, text()
events, n, lost = (Event * 16)(), c.c_size_t(), c.c_uint64(9)
assert lib.meltsim_world_take_events(box, events, c.sizeof(Event), 16, c.byref(n), None) == 1 and "watch_events" in text()
assert lib.meltsim_world_add_material(box, c.byref(material), c.byref(ident)) == 0, text()
assert lib.meltsim_shape_box(Vec(0.3, 0.3, 0.3), Vec(0.6, 0.6, 0.6), c.byref(shape)) == 0, text()
solid.shape, solid.material = shape, ident
assert lib.meltsim_world_add_solid(box, c.byref(solid), None) == 0, text()
lib.meltsim_shape_destroy(shape)
assert lib.meltsim_world_watch_events(box, 0, 127) == 1 and "capacity" in text()
assert lib.meltsim_world_watch_events(box, 16, 8) == 0, text()
for _ in range(12):
    assert step(box, 0.02) == 0, text()
assert lib.meltsim_world_take_events(box, events, c.sizeof(Event), 16, c.byref(n), c.byref(lost)) == 0 and (n.value, lost.value) == (0, 0), text()
assert step(box, 0.02) == 0 and lib.meltsim_world_request(box, 4, c.byref(ticket)) == 0 and step(box, 0.02) == 0, text()
assert lib.meltsim_world_take(box, ticket, c.byref(reading)) == 0, text()
assert lib.meltsim_reading_events(reading, None, c.sizeof(Event), 0, c.byref(n), None) == 5 and n.value == 1
assert lib.meltsim_reading_events(reading, events, c.sizeof(Event), 16, c.byref(n), c.byref(lost)) == 0 and n.value == 1, text()
assert (events[0].kind, events[0].wall, events[0].other.generation) == (8, 2, 0) and abs(events[0].time - 0.2473) < 0.01, events[0].time
lib.meltsim_reading_destroy(reading)
assert lib.meltsim_world_take_events(box, events, c.sizeof(Event), 15, c.byref(n), None) == 5 and n.value == 16
assert lib.meltsim_world_take_events(box, events, c.sizeof(Event), 16, c.byref(n), None) == 0 and n.value == 0, text()
# The same body, at rest on the floor: rays, shapes, a mesh, pieces, particles, a probe, a render pack. 0.01: a tenth of a spacing.
rays, hits = (Ray * 2)(Ray(Vec(0.45, 0.95, 0.45), Vec(0, -2, 0), math.inf), Ray(Vec(0.1, 0.5, 0.1), Vec(0, -1, 0), math.inf)), (RayHit * 2)()
for _ in range(80):
    assert step(box, 0.02) == 0, text()
assert lib.meltsim_world_cast_rays(box, rays, 2, 7, hits, c.sizeof(RayHit)) == 0, text()
assert (hits[0].what, hits[0].body.generation != 0, hits[0].wall) == (2, True, -1) and abs(hits[0].point[1] - 0.3) < 0.02, hits[0].point[1]
assert (hits[1].what, hits[1].wall, hits[1].body.generation) == (3, 2, 0) and abs(hits[1].distance - 0.5) < 1e-9
rays[1].direction = Vec(0, 0, 0)
assert lib.meltsim_world_cast_rays(box, rays, 2, 7, hits, c.sizeof(RayHit)) == 1 and "rays[1]: direction" in text()
assert lib.meltsim_world_cast_rays(box, None, 0, 7, None, c.sizeof(RayHit)) == 1 and "rays" in text()
# Counts that are slips are refused before anything is read.
assert lib.meltsim_world_cast_rays(box, rays, c.c_size_t(1 << 60), 7, hits, c.sizeof(RayHit)) == 5 and "ray_count: at most" in text()
assert lib.meltsim_world_sample(box, (c.c_double * 3)(), c.c_size_t(1 << 61), b"pressure", (c.c_double * 1)()) == 5 and "point_count: at most" in text()
found, volume, bodies, each = c.c_uint64(9), c.c_double(9), (Id * 2)(), (c.c_uint64 * 2)()
assert lib.meltsim_shape_box(Vec(0, 0, 0), Vec(1, 1, 1), c.byref(shape)) == 0, text()
assert lib.meltsim_world_liquid_in(box, shape, c.byref(found), c.byref(volume)) == 0 and (found.value, volume.value) == (0, 0), text()
assert lib.meltsim_world_bodies_in(box, shape, None, None, 0, c.byref(n)) == 5 and n.value == 1
assert lib.meltsim_world_bodies_in(box, shape, bodies, each, 2, c.byref(n)) == 0 and (n.value, each[0]) == (1, 27), text()
lib.meltsim_shape_destroy(shape)
of, surface, mesh = made(SurfaceDesc, lib.meltsim_surface_desc_init_sized), c.c_void_p(), Mesh(size=c.sizeof(Mesh))
of.of = 1
assert lib.meltsim_world_surface(box, c.byref(of), c.byref(surface)) == 0, text()
assert lib.meltsim_surface_mesh(surface, c.byref(mesh)) == 0 and mesh.triangles > 50, text()
top = max(mesh.position[3 * k + 1] for k in range(mesh.vertices)) + mesh.origin[1]
assert abs(top - 0.3) < 0.05 and max(mesh.triangle[k] for k in range(3 * mesh.triangles)) < mesh.vertices, top
# The same mesh where it was made; the place of triangles that a draw reads from there.
seen, older = SurfaceView(size=c.sizeof(SurfaceView)), SurfaceView(size=c.sizeof(SurfaceView))
assert lib.meltsim_world_surface_view(box, c.byref(of), c.byref(older)) == 0, text()
assert lib.meltsim_world_surface_view(box, c.byref(of), c.byref(seen)) == 0, text()
assert (seen.vertices, seen.triangles, seen.draw[0], seen.draw[1]) == (mesh.vertices, mesh.triangles, 3 * mesh.triangles, 1)
assert all(seen.position[k] == mesh.position[k] for k in range(3 * mesh.vertices))
assert all(seen.triangle[k] == mesh.triangle[k] for k in range(3 * mesh.triangles)) and all(seen.body[k] == 1 for k in range(mesh.vertices))
assert lib.meltsim_world_check_surface_view(box, c.byref(seen)) == 0, text()
assert lib.meltsim_world_check_surface_view(box, c.byref(older)) == 1 and "past its time" in text(), text()
of.no_wait = 1
assert lib.meltsim_world_surface_view(box, c.byref(of), c.byref(seen)) == 0 and seen.draw[0] in (0, 3 * mesh.triangles), text()
assert lib.meltsim_world_surface_view(box, c.byref(of), None) == 1 and "view" in text()
lib.meltsim_surface_destroy(surface)
of.of = 7
assert lib.meltsim_world_surface_view(box, c.byref(of), c.byref(seen)) == 1 and "desc.of" in text()
assert lib.meltsim_world_surface(box, c.byref(of), c.byref(surface)) == 1 and "desc.of" in text() and surface.value is None
probe, fields = made(ProbeDesc, lib.meltsim_probe_desc_init_sized), (c.c_char_p * 2)(b"force", b"contact_force")
probe.kind, probe.wall, probe.fields, probe.field_count = 2, 2, fields, 2
assert lib.meltsim_world_add_probe(box, c.byref(probe), None) == 0, text()
for _ in range(10):
    assert step(box, 0.02) == 0, text()
assert lib.meltsim_world_request(box, 8 + 16 + 32, c.byref(ticket)) == 0 and lib.meltsim_world_take(box, ticket, c.byref(reading)) == 0, text()
pieces, frame, series = (Piece * 1)(), ParticleFrame(size=c.sizeof(ParticleFrame)), ProbeSeries(size=c.sizeof(ProbeSeries))
assert lib.meltsim_reading_pieces(reading, pieces, c.sizeof(Piece), 1, c.byref(n)) == 0 and n.value == 1, text()
assert pieces[0].particles == 27 and abs(pieces[0].center[1] - 0.15) < 0.02 and pieces[0].piece == 1
assert lib.meltsim_reading_particles(reading, c.byref(frame)) == 0 and frame.count == 27, text()
assert abs(sum(frame.position[3 * k + 1] for k in range(27)) / 27 + frame.origin[1] - pieces[0].center[1]) < 1e-4
assert lib.meltsim_reading_probe(reading, 0, c.byref(series)) == 0 and (series.points, series.width) == (1, 6) and series.samples > 10, text()
weight = 1000 * 0.027 * 9.81
assert abs(series.values[6 * (series.samples - 1) + 4] + weight) < 0.05 * weight, series.values[6 * (series.samples - 1) + 4]  # on the floor: down
assert lib.meltsim_reading_probe(reading, 1, c.byref(series)) == 1 and "index" in text()
lib.meltsim_reading_destroy(reading)
how, view = made(RenderDesc, lib.meltsim_render_desc_init_sized), RenderView(size=c.sizeof(RenderView))
assert lib.meltsim_world_render_view(box, None, c.byref(view)) == 0 and view.count == 27 and not view.color, text()
assert lib.meltsim_world_check_view(box, c.byref(view)) == 0, text()
assert lib.meltsim_world_wait_for(box, c.c_void_p(8)) == 1 and "on the CPU" in text(), text()
assert lib.meltsim_world_signal(box, c.c_void_p(8)) == 1 and "on the CPU" in text(), text()
old_view = RenderView.from_buffer_copy(view)
how.color, how.colors, how.color_count = 1, (c.c_uint32 * 1)(0xff123456), 1
assert lib.meltsim_world_render_view(box, c.byref(how), c.byref(view)) == 0 and all(view.color[k] == 0xff123456 for k in range(27)), text()
assert lib.meltsim_world_check_view(box, c.byref(view)) == 0, text()
assert lib.meltsim_world_check_view(box, c.byref(old_view)) == 1 and "past its time" in text()
how.color, how.coldest, how.hottest = 2, 5, 5
assert lib.meltsim_world_render_view(box, c.byref(how), c.byref(view)) == 1 and "hottest" in text()
assert lib.meltsim_world_stop_events(box) == 0 and lib.meltsim_world_take_events(box, events, c.sizeof(Event), 16, c.byref(n), None) == 1
# The state in its own memory, and a stage: a lift of 1.5 g, for 0.1 s, as the velocity says.
state = StageContext(size=c.sizeof(StageContext))
assert lib.meltsim_world_device_state(box, c.byref(state)) == 0 and state.particles == 27, text()
assert not state.acceleration and not state.clock and state.double_precision == 0 and not state.stream
assert abs(sum(state.position[4 * k + 1] for k in range(27)) / 27 + state.origin[1] - pieces[0].center[1]) < 1e-4
assert lib.meltsim_world_check_device_state(box, c.byref(state)) == 0, text()
calls = []


@StageFunction
def lift(context, user):
    s = context.contents
    calls.append((user, s.dt, s.clock[0], s.clock[1], s.time, s.origin[1]))
    for k in range(s.particles):
        s.acceleration[3 * k + 1] += 2.5 * 9.81


stage, channels = made(StageDesc, lib.meltsim_stage_desc_init_sized), (c.c_char_p * 1)(b"acceleration")
stage.name, stage.run, stage.user, stage.writes, stage.write_count = b"lift", lift, 42, channels, 1
assert lib.meltsim_world_add_stage(box, c.byref(stage)) == 0, text()
assert lib.meltsim_world_add_stage(box, c.byref(stage)) == 1 and "lift" in text(), text()
before = lib.meltsim_world_steps(box)
assert step(box, 0.1) == 0, text()
assert lib.meltsim_world_check_device_state(box, c.byref(state)) == 1 and "past its time" in text(), text()
assert len(calls) == lib.meltsim_world_steps(box) - before > 0 and all(user == 42 for user, *_ in calls)
assert all(dt == length and time == begun and o == state.origin[1] for _, dt, begun, length, time, o in calls)
assert abs(sum(dt for _, dt, *_ in calls) - 0.1) < 1e-12
assert lib.meltsim_world_device_state(box, c.byref(state)) == 0, text()
# In the air now, it gains what the stage gives less gravity. 1e-4: single precision, and the edge of a sub-step.
rise = sum(state.velocity[4 * k + 1] for k in range(27)) / 27
assert step(box, 0.05) == 0 and lib.meltsim_world_device_state(box, c.byref(state)) == 0, text()
gained = sum(state.velocity[4 * k + 1] for k in range(27)) / 27 - rise
assert rise > 1 and abs(gained - 1.5 * 9.81 * 0.05) < 1e-4 * gained, (rise, gained)
assert lib.meltsim_world_remove_stage(box, b"lift") == 0, text()
assert lib.meltsim_world_remove_stage(box, b"lift") == 1 and "lift" in text(), text()
called = len(calls)
assert step(box, 0.02) == 0 and len(calls) == called, text()
stage.after = b"sph.nothing"
assert lib.meltsim_world_add_stage(box, c.byref(stage)) == 1 and "sph.nothing" in text(), text()
stage.after, stage.write_count = None, 2**40
stage.writes = None
assert lib.meltsim_world_add_stage(box, c.byref(stage)) == 1 and "desc.writes" in text(), text()
# A stage must not call its World, nor may it be taken away below itself.
refusals = []


@StageFunction
def meddle(context, user):
    refusals.extend((step(box, 0.01), lib.meltsim_world_remove_stage(box, b"meddle"), lib.meltsim_world_synchronize(box, c.byref(report))))


report = Report(size=c.sizeof(Report))
stage.name, stage.run, stage.write_count = b"meddle", meddle, 0
assert lib.meltsim_world_add_stage(box, c.byref(stage)) == 0, text()
assert step(box, 0.02) == 0 and len(refusals) > 2 and set(refusals) == {1} and "runs the stage" in text(), (refusals, text())
assert lib.meltsim_world_remove_stage(box, b"meddle") == 0, text()
stage.write_count, stage.run = 0, StageFunction()
assert lib.meltsim_world_add_stage(box, c.byref(stage)) == 1 and "desc.run" in text(), text()
# A kinematic body of a mesh that the host moves: a cube of 0.3 m, stretched by 1.5 along x from its face at 0.3 m on.
corners = [(x, y, z) for z in (0.6, 0.9) for y in (0.6, 0.9) for x in (0.3, 0.6)]
faces = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]
flat = lambda points: (c.c_double * 24)(*[x for p in points for x in p])
assert lib.meltsim_shape_mesh(flat(corners), 8, (c.c_uint32 * 36)(*faces), 12, c.byref(shape)) == 0, text()
cube, made_solid = Id(), made(SolidDesc, lib.meltsim_solid_desc_init_sized)
made_solid.shape, made_solid.material, made_solid.motion = shape, ident, 2
assert lib.meltsim_world_add_solid(box, c.byref(made_solid), c.byref(cube)) == 0, text()
lib.meltsim_shape_destroy(shape)
stretched = flat([(0.3 + 1.5 * (x - 0.3), y, z) for x, y, z in corners])
assert lib.meltsim_world_update_mesh(box, cube, stretched, None, 7) == 1 and "the mesh has 8 vertices, got 7" in text(), text()
assert lib.meltsim_world_update_mesh(box, cube, None, None, 8) == 1 and "vertices" in text(), text()
assert lib.meltsim_world_update_mesh(box, cube, stretched, flat([(0, 0, 0)] * 8), 8) == 0, text()
assert step(box, 0.1) == 0, text()
seen = (RayHit * 1)()
assert lib.meltsim_world_cast_rays(box, (Ray * 1)(Ray(Vec(0.98, 0.75, 0.75), Vec(-1, 0, 0), math.inf)), 1, 2, seen, c.sizeof(RayHit)) == 0, text()
assert seen[0].body.index == cube.index and abs(seen[0].point[0] - 0.75) < 0.06, seen[0].point[0]
assert lib.meltsim_world_remove(box, cube) == 0 and step(box, 0.02) == 0, text()
lib.meltsim_world_destroy(box)

# Mistakes: a status, a text, nothing changed.
known = state_hash(a)
assert lib.meltsim_world_restore(a, buffer, size.value - 1) == 8 and text()  # MELTSIM_CORRUPT_DATA
assert particles(a, 26)[:2] == (5, 27) and "27" in text()
assert step(a, math.nan) == 1 and "dt" in text()
assert step(None, 0.1) == 1 and "world" in text()
assert lib.meltsim_world_create(None, c.byref(c.c_void_p())) == 1 and "desc: is null" in text()
wrong = made(WorldDesc, lib.meltsim_world_desc_init_sized)
wrong.spacing = -1
handle = c.c_void_p(1)
assert lib.meltsim_world_create(c.byref(wrong), c.byref(handle)) == 1 and "spacing" in text() and handle.value is None
# What follows heat through walls: each value reaches the library, which refuses it by the name that it has there.
for name, value, said in (("support_radius", 1e-9, "support_radius"), ("artificial_viscosity", -1, "artificial_viscosity"),
                          ("isotropic_pressure", 3, "isotropic_pressure"), ("particle_shifting", 1, "particle_shifting"),
                          ("neighbour_search", 4, "neighbour_search"), ("viscosity", 3, "viscosity"), ("stray", 2, "stray"),
                          ("courant", 0.7, "courant"), ("pieces_interval", 0, "pieces_interval"), ("heat_max_stages", 1, "max_stages"),
                          ("heat_max_supersteps", 0, "max_supersteps"), ("solute_max_supersteps", 0, "max_supersteps"),
                          ("solute_time_scale", -1, "solute.time_scale"), ("heat_level_tolerance", -1, "level_tolerance"),
                          ("free_surface", SurfaceHeat(flux=math.nan), "free_surface"), ("wall_friction", -1, "friction"),
                          ("wall_contact_angle", 200, "contact_angle"), ("wall_velocity", (Vec * 6)(Vec(math.nan, 0, 0)), "velocity")):
    whole = made(WholeWorldDesc, lib.meltsim_world_desc_init_sized)
    whole.bounded, whole.max, whole.spacing, whole.backend = 1, Vec(2, 2, 2), 0.1, 1
    assert lib.meltsim_world_create(c.byref(whole), c.byref(handle)) == 0, text()
    lib.meltsim_world_destroy(handle)
    setattr(whole, name, value)
    assert lib.meltsim_world_create(c.byref(whole), c.byref(handle)) == 1 and said in text(), f"{name}: {text()}"
for name, value in (("damping", -1), ("diffusivity", -1), ("conductivity_points", 0), ("heat_capacity_points", 0),
                    ("viscosity_points", 0), ("density_points", 0)):
    whole = made(WholeMaterialDesc, lib.meltsim_material_desc_init_sized)
    assert whole.damping == 0.1 and whole.diffusivity == 0
    if name.endswith("_points"):  # of one point
        setattr(whole, name, (c.c_double * 2)(20, 1))
        setattr(whole, name.replace("_points", "_point_count"), 1)
    else:
        setattr(whole, name, value)
    assert lib.meltsim_world_add_material(a, c.byref(whole), None) == 1 and name in text(), f"{name}: {text()}"
whole = made(WholeSolidDesc, lib.meltsim_solid_desc_init_sized)
assert whole.carve == 1 and whole.growth == 0
wrong.spacing, wrong.size = 0.1, 4000
assert lib.meltsim_world_create(c.byref(wrong), c.byref(handle)) == 1 and "size" in text()
wrong.size, wrong.version = c.sizeof(WorldDesc), 1
assert lib.meltsim_world_create(c.byref(wrong), c.byref(handle)) == 2, text()  # MELTSIM_VERSION_MISMATCH
wrong.version, wrong.size, wrong.heat_time_scale = lib.meltsim_version(), WorldDesc.heat_time_scale.offset, -1
assert lib.meltsim_world_create(c.byref(wrong), c.byref(handle)) == 0, text()  # an older header: what it lacks has its default
lib.meltsim_world_destroy(handle)
bad = made(SolidDesc, lib.meltsim_solid_desc_init_sized)
assert lib.meltsim_world_add_solid(a, c.byref(bad), None) == 1 and "shape" in text()
assert lib.meltsim_shape_sphere(Vec(0, 0, 0), c.c_double(math.nan), c.byref(handle)) == 1 and handle.value is None
lib.meltsim_world_interrupt(a)
assert step(a, 0.02) == 9  # MELTSIM_INTERRUPTED
assert state_hash(a) == known
lib.meltsim_world_destroy(a)
lib.meltsim_world_destroy(b)
lib.meltsim_world_destroy(None)


# Species: what is dissolved, by its own number, and what cannot be.
class FluidDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("reserved", c.c_uint32), ("shape", c.c_void_p), ("material", Id), ("temperature", c.c_double),
                ("velocity", Vec)]


class SpeciesDesc(c.Structure):
    _fields_ = [("size", c.c_uint32), ("reserved", c.c_uint32), ("dissolves_in", Id), ("solubility", c.c_double),
                ("diffusivity_in", c.c_double), ("heat_of_solution", c.c_double), ("transfer_coefficient", c.c_double),
                ("solubility_points", c.POINTER(c.c_double)), ("solubility_point_count", c.c_size_t)]


desc = made(WorldDesc, lib.meltsim_world_desc_init_sized)
desc.spacing, desc.backend, desc.threads, desc.double_precision = 0.1, 1, 1, 1
s = c.c_void_p()
assert lib.meltsim_world_create(c.byref(desc), c.byref(s)) == 0, text()
water, salt = Id(), Id()
material = made(MaterialDesc, lib.meltsim_material_desc_init_sized)
material.name = b"water"
assert lib.meltsim_world_add_material(s, c.byref(material), c.byref(water)) == 0, text()
material.name, species = b"salt", made(SpeciesDesc, lib.meltsim_species_desc_init_sized)
species.solubility, species.diffusivity_in = 0.25, 1.6e-9
assert lib.meltsim_world_add_species(s, c.byref(material), c.byref(species), c.byref(salt)) != 0
assert "dissolves_in" in text()
species.dissolves_in = water
assert lib.meltsim_world_add_species(s, c.byref(material), c.byref(species), c.byref(salt)) == 0, text()
# Tables over temperature: pairs, refused as in C++.
alum, table = Id(), (c.c_double * 4)(60, 0.2, 20, 0.06)
species.solubility_point_count = 2
assert lib.meltsim_world_add_species(s, c.byref(material), c.byref(species), c.byref(alum)) != 0 and "is null" in text(), text()
species.solubility_points = table
material.name = b"alum"
assert lib.meltsim_world_add_species(s, c.byref(material), c.byref(species), c.byref(alum)) != 0 and "sort the points" in text(), text()
table[0], table[2] = 20, 60
table[1], table[3] = 0.06, 0.2
assert lib.meltsim_world_add_species(s, c.byref(material), c.byref(species), c.byref(alum)) == 0, text()
material.name, material.yield_stress_points, material.yield_stress_point_count = b"butter", table, 99
assert lib.meltsim_world_add_material(s, c.byref(material), None) != 0 and "2..8 points" in text(), text()
material.yield_stress_point_count = 2
assert lib.meltsim_world_add_material(s, c.byref(material), None) == 0, text()
shape, fluid, added = c.c_void_p(), made(FluidDesc, lib.meltsim_fluid_desc_init_sized), c.c_uint64()
assert lib.meltsim_shape_box(Vec(0, 0, 0), Vec(0.3, 0.3, 0.3), c.byref(shape)) == 0, text()
fluid.shape, fluid.material = shape, water
for share, good in ((0.3, False), (0.1, True)):
    status = lib.meltsim_world_add_mixture(s, c.byref(fluid), c.byref(salt), c.byref(c.c_double(share)), c.c_size_t(1), c.byref(added))
    assert (status == 0) == good, text()
assert added.value == 27
values, count = (c.c_double * 27)(), c.c_uint64()
assert lib.meltsim_world_fractions(s, salt, values, c.c_uint64(26), c.byref(count)) != 0 and count.value == 27
assert lib.meltsim_world_fractions(s, salt, values, c.c_uint64(27), c.byref(count)) == 0, text()
assert all(abs(value - 0.1) < 1e-15 for value in values)
assert lib.meltsim_world_fractions(s, water, values, c.c_uint64(27), c.byref(count)) != 0 and "is no species" in text()

# A nozzle of salt water: what it emits has the mass fraction asked for.
nozzle = made(EmitterDesc, lib.meltsim_emitter_desc_init_sized)
nozzle.center, nozzle.radius, nozzle.speed, nozzle.until, nozzle.material = Vec(0, 5, 0), 0.2, 2, 1, water
share = c.c_double(0.3)
arguments = (s, c.byref(nozzle), c.byref(salt), c.byref(share), c.c_size_t(1), None)
assert lib.meltsim_world_add_mixture_emitter(*arguments) != 0 and "0.25" in text(), text()
share.value = 0.2
assert lib.meltsim_world_add_mixture_emitter(s, c.byref(nozzle), None, c.byref(share), c.c_size_t(1), None) == 1 and "species" in text()
assert lib.meltsim_world_add_mixture_emitter(*arguments) == 0, text()
assert step(s, 0.05) == 0, text()
values = (c.c_double * 1000)()
assert lib.meltsim_world_fractions(s, salt, values, c.c_uint64(1000), c.byref(count)) == 0 and count.value > 27, text()
assert all(abs(value - 0.2) < 1e-15 for value in values[27:count.value])

# How often modules run, and whether: what is set is what the plan says.
m = world(heat_model=3, surface=SurfaceHeat(flux=100))
n = c.c_int32(-1)
for module, stage_name, every in ((b"topology", b"topology.melt", 4), (b"thermal", b"thermal.exchange", 3), (b"topology", b"topology.melt", 1)):
    assert lib.meltsim_world_set_interval(m, module, every) == 0, text()
    assert lib.meltsim_world_interval(m, stage_name, c.byref(n)) == 0 and n.value == every, (stage_name, n.value, text())
known = state_hash(m)
n.value = -1
for call, said in ((lambda: lib.meltsim_world_set_interval(m, b"topology", 0), "must be >= 1, got 0"),
                   (lambda: lib.meltsim_world_set_interval(m, b"sph", 2), "only thermal and topology"),
                   (lambda: lib.meltsim_world_set_interval(m, None, 2), "module: is null"),
                   (lambda: lib.meltsim_world_interval(m, b"thermal", c.byref(n)), 'none is named "thermal"'),
                   (lambda: lib.meltsim_world_interval(m, b"topology.melt", None), "n: is null"),
                   (lambda: lib.meltsim_world_enable(m, b"step", 0), "step"), (lambda: lib.meltsim_world_enable(m, None, 0), "module: is null")):
    assert call() == 1 and said in text(), (said, text())
assert n.value == -1 and state_hash(m) == known
assert lib.meltsim_world_interval(m, b"topology.melt", c.byref(n)) == 0 and n.value == 1, text()
# Bodies without their lattices' module fly on; with it they fall.
m2 = world()
for on, gained in ((0, 0), (1, -9.81 * 0.05)):
    assert lib.meltsim_world_enable(m2, b"lsm", on) == 0, text()
    before = particles(m2, 27)[3][1]
    assert step(m2, 0.05) == 0 and abs(particles(m2, 27)[3][1] - before - gained) < 1e-5, (on, before, particles(m2, 27)[3][1])
lib.meltsim_world_destroy(m)
lib.meltsim_world_destroy(m2)

# Steps that end early: the first sub-steps of a step, to the bit; without a limit, all of it.
twins = [world() for _ in range(3)]
part, whole = TimedStep(size=c.sizeof(TimedStep)), TimedStep(size=c.sizeof(TimedStep))
seconds = c.c_double(10 * lib.meltsim_world_stable_dt(twins[0]))
assert lib.meltsim_world_step_part(twins[0], seconds, c.c_uint64(3), c.byref(part)) == 0, text()
assert (part.substeps, part.over_budget) == (3, 0) and part.planned >= 10, (part.substeps, part.planned)
assert abs(part.simulated + part.owed - seconds.value) < 1e-12 and lib.meltsim_world_steps(twins[0]) == 3
assert lib.meltsim_world_step_part(twins[1], seconds, c.c_uint64(3), None) == 0 and state_hash(twins[0]) == state_hash(twins[1])
assert lib.meltsim_world_step_within(twins[2], seconds, c.c_double(math.inf), c.byref(whole)) == 0, text()
assert whole.substeps == whole.planned == part.planned and whole.owed == 0 and whole.wall_ms > 0
assert lib.meltsim_world_step_part(twins[1], seconds, whole.planned, None) == 0, text()
assert lib.meltsim_world_step_within(twins[2], seconds, c.c_double(0), None) == 1 and "milliseconds" in text(), text()
part.size = 0
assert lib.meltsim_world_step_part(twins[2], seconds, c.c_uint64(1), c.byref(part)) == 1 and "size" in text(), text()
assert lib.meltsim_world_steps(twins[2]) == whole.planned and lib.meltsim_world_steps(None) == 0
for twin in twins:
    lib.meltsim_world_destroy(twin)
lib.meltsim_shape_destroy(shape)
lib.meltsim_world_destroy(s)
print("ok")
