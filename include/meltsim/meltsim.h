/* SPDX-License-Identifier: Apache-2.0
 *
 * meltsim from C99, and from every language that calls C. Handles are opaque; structs begin with their size, so that a host built
 * against an older header goes on to work; no exception leaves a call. SI units, temperatures in degrees Celsius.
 *
 * Every call that can fail returns a meltsim_status. Where it is not MELTSIM_OK, meltsim_error_text() has the text, which names
 * field, value and fix, and nothing has changed. A World is used by one thread at a time, meltsim_world_interrupt() excepted.
 * The C++ interface (meltsim.hpp) has more: timings, lattices, what was derived. */
#ifndef MELTSIM_MELTSIM_H
#define MELTSIM_MELTSIM_H

#include <stddef.h>
#include <stdint.h>

#include "meltsim/version.hpp"

#if defined(__GNUC__) && !defined(MELTSIM_STATIC)
#define MELTSIM_C_API __attribute__((visibility("default")))
#else
#define MELTSIM_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* What a call returns: 0, or a kind of error. Values do not change between versions. */
typedef int32_t meltsim_status;
enum {
  MELTSIM_OK = 0,
  MELTSIM_INVALID_ARGUMENT = 1, /* a description that cannot be simulated; the text names the field */
  MELTSIM_VERSION_MISMATCH = 2, /* the host was compiled against other headers than the library */
  MELTSIM_NO_DEVICE = 3,        /* the backend asked for is not built in or has no usable device */
  MELTSIM_OUT_OF_MEMORY = 4,    /* the text names the bytes needed and free */
  MELTSIM_CAPACITY = 5,         /* a fixed capacity would be exceeded */
  MELTSIM_STEP_TOO_LARGE = 6,   /* more sub-steps than allowed; the text names the step that fits */
  MELTSIM_HALTED = 7,           /* the simulation diverged earlier; the World keeps its last good state */
  MELTSIM_CORRUPT_DATA = 8,     /* a snapshot whose checksum or structure is wrong */
  MELTSIM_INTERRUPTED = 9, /* meltsim_world_interrupt() ended a step; sub-steps completed before it count */
  MELTSIM_INTERNAL = 10    /* a fault of the library or of the device */
};

/* The text of the last call of this thread that failed; "" before the first. It holds until the next one fails. Never null. */
MELTSIM_C_API const char* meltsim_error_text(void);
/* MELTSIM_VERSION_NUMBER of the library that runs. */
MELTSIM_C_API uint32_t meltsim_version(void);

typedef struct meltsim_world meltsim_world;     /* one simulation */
typedef struct meltsim_shape meltsim_shape;     /* a part of space; immutable */
typedef struct meltsim_reading meltsim_reading; /* what was read of a World */
typedef struct meltsim_surface meltsim_surface; /* a mesh */

/* An object of one World: a material or a body. {0, 0} is none. */
typedef struct meltsim_id {
  uint32_t index;      /* position in the World's table, from 0 */
  uint32_t generation; /* 0: none */
} meltsim_id;

/* ---- Shapes --------------------------------------------------------------------------------------------------------------
 * Each makes a shape in *shape, which meltsim_shape_destroy() frees; a World that samples it keeps nothing of it. Lengths are
 * in metres, points are three numbers. On an error *shape is null. */
MELTSIM_C_API meltsim_status meltsim_shape_box(const double min[3], const double max[3],
                                               meltsim_shape** shape);
MELTSIM_C_API meltsim_status meltsim_shape_sphere(const double center[3], double radius,
                                                  meltsim_shape** shape);
MELTSIM_C_API meltsim_status meltsim_shape_capsule(const double a[3], const double b[3], double radius,
                                                   meltsim_shape** shape);
MELTSIM_C_API meltsim_status meltsim_shape_cylinder(const double a[3], const double b[3], double radius,
                                                    meltsim_shape** shape);
/* A ring around `axis`. */
MELTSIM_C_API meltsim_status meltsim_shape_torus(const double center[3], const double axis[3],
                                                 double major_radius, double minor_radius,
                                                 meltsim_shape** shape);
/* Smooth union of ellipsoids along the axes: 3 numbers per centre, 3 half axes each; `blend` is the width over which neighbours
 * merge [m], 0: sharp. */
MELTSIM_C_API meltsim_status meltsim_shape_blend(const double* centers, const double* radii, size_t count,
                                                 double blend, meltsim_shape** shape);
/* Inside of a triangle mesh: 3 numbers per vertex; 3 indices, from 0, per triangle. */
MELTSIM_C_API meltsim_status meltsim_shape_mesh(const double* vertices, size_t vertex_count,
                                                const uint32_t* triangles, size_t triangle_count,
                                                meltsim_shape** shape);
/* Inside of the mesh of an OBJ, STL or PLY file. */
MELTSIM_C_API meltsim_status meltsim_shape_file(const char* path, meltsim_shape** shape);
/* Points in `a` or in `b`; points in `a` and not in `b`; points in both. */
MELTSIM_C_API meltsim_status meltsim_shape_unite(const meltsim_shape* a, const meltsim_shape* b,
                                                 meltsim_shape** shape);
MELTSIM_C_API meltsim_status meltsim_shape_subtract(const meltsim_shape* a, const meltsim_shape* b,
                                                    meltsim_shape** shape);
MELTSIM_C_API meltsim_status meltsim_shape_intersect(const meltsim_shape* a, const meltsim_shape* b,
                                                     meltsim_shape** shape);
/* `of` moved: x -> scale R x + offset, R = rotation about `axis` by `angle` [rad]. */
MELTSIM_C_API meltsim_status meltsim_shape_transform(const meltsim_shape* of, const double offset[3],
                                                     const double axis[3], double angle, double scale,
                                                     meltsim_shape** shape);
/* Frees a shape; null does nothing. */
MELTSIM_C_API void meltsim_shape_destroy(meltsim_shape* shape);

/* ---- Descriptions --------------------------------------------------------------------------------------------------------
 * meltsim_..._init() sets the size and the defaults, those of the C++ interface. `name` may be null: the default. */
enum { MELTSIM_BACKEND_AUTOMATIC = 0, MELTSIM_BACKEND_CPU = 1, MELTSIM_BACKEND_CUDA = 2 };
enum { MELTSIM_FACE_WALL = 0, MELTSIM_FACE_OPEN = 1, MELTSIM_FACE_PERIODIC = 2 };
enum { MELTSIM_HEAT_NONE = 0, MELTSIM_HEAT_PAPER = 1, MELTSIM_HEAT_IWASAKI = 2, MELTSIM_HEAT_ENTHALPY = 3 };
enum {
  MELTSIM_MOTION_FREE = 0,
  MELTSIM_MOTION_FIXED = 1,
  MELTSIM_MOTION_KINEMATIC = 2,
  MELTSIM_MOTION_RIGID = 3,
  MELTSIM_MOTION_PROXY = 4 /* a rigid body of the host's physics engine: meltsim_world_set_proxy() */
};

/* Heat through a surface: the sum of what is set; all 0 insulates. */
typedef struct meltsim_surface_heat {
  int32_t has_temperature; /* whether the surface is held at `temperature`; alone */
  int32_t reserved;        /* 0 */
  double temperature;      /* [degrees Celsius] */
  double flux;             /* into the material [W/m^2] */
  double convection;       /* heat transfer coefficient towards `ambient` [W/(m^2 K)] */
  double emissivity;       /* of radiation towards surroundings at `ambient`, 0 to 1 */
  double ambient;          /* temperature of the surroundings [degrees Celsius] */
} meltsim_surface_heat;

/* What is beyond an open face. */
enum {
  MELTSIM_OUTLET_NONE = 0,  /* liquid falls out freely */
  MELTSIM_OUTLET_LEVEL = 1, /* liquid up to the height `value` [m], against gravity */
  MELTSIM_OUTLET_SPEED = 2  /* liquid near the face moves out at the speed `value` [m/s] */
};
typedef struct meltsim_outlet {
  int32_t kind;     /* MELTSIM_OUTLET_... */
  int32_t reserved; /* 0 */
  double value;     /* level or speed */
} meltsim_outlet;

/* A choice that is left to the library unless it is made. */
enum { MELTSIM_CHOICE_AUTOMATIC = 0, MELTSIM_CHOICE_OFF = 1, MELTSIM_CHOICE_ON = 2 };

/* How neighbours are found. */
enum { MELTSIM_SEARCH_AUTOMATIC = 0, MELTSIM_SEARCH_GRID = 1, MELTSIM_SEARCH_TREE = 3 };

/* How viscosity enters a sub-step. */
enum { MELTSIM_VISCOSITY_AUTOMATIC = 0, MELTSIM_VISCOSITY_EXPLICIT = 1, MELTSIM_VISCOSITY_IMPLICIT = 2 };

/* What happens to liquid that falls out of an unbounded scene. */
enum { MELTSIM_STRAY_REMOVE = 0, MELTSIM_STRAY_HALT = 1 };

/* A World. */
typedef struct meltsim_world_desc {
  uint32_t size;                     /* sizeof(meltsim_world_desc) */
  uint32_t version;                  /* MELTSIM_VERSION_NUMBER of the header: leave it as it is */
  int32_t backend;                   /* MELTSIM_BACKEND_... */
  int32_t double_precision;          /* 0: the state is in single precision */
  int32_t device;                    /* CUDA device */
  int32_t threads;                   /* CPU threads; 0: one per processor */
  double spacing;                    /* distance of particles [m] */
  int32_t bounded;                   /* 0: no faces; the next fields then have no effect */
  int32_t no_slip;                   /* liquid sticks to walls */
  double domain_min[3];              /* lower corner [m] */
  double domain_max[3];              /* upper corner [m] */
  int32_t faces[6];                  /* MELTSIM_FACE_..., in the order -x, +x, -y, +y, -z, +z */
  double gravity[3];                 /* [m/s^2] */
  double sound_speed;                /* [m/s]; 0: derived from the depth */
  int32_t heat_model;                /* MELTSIM_HEAT_... */
  int32_t max_substeps;              /* a step that needs more is refused */
  double heat_time_scale;            /* heat runs so many times faster than motion */
  meltsim_surface_heat wall_heat[6]; /* through each wall, in the order of `faces` */
  meltsim_outlet outlets[6];         /* what is beyond open faces, in the order of `faces` */
  double density_error;              /* compression at rest that a derived sound speed allows; 0: 0.005 */
  int32_t heat_interval;             /* most sub-steps that share a step of heat, within a step; 0: chosen */
  int32_t follow_sound_speed;        /* the derived sound speed follows what moves, 0 or 1 */
  uint64_t reserved_particles;       /* room for what is added while the World runs */
  double support_radius;             /* of the smoothing kernel [m], 1.5 to 6 spacings; 0: 2.5 spacings */
  double artificial_viscosity;       /* Monaghan's alpha: damps acoustic noise */
  int32_t tension;                   /* pressure may be below 0, 0 or 1 */
  int32_t isotropic_pressure;        /* MELTSIM_CHOICE_...: its level does not act as viscosity */
  int32_t particle_shifting;         /* keeps particles evenly spread; needs `tension`, 0 or 1 */
  int32_t neighbour_search;          /* MELTSIM_SEARCH_... */
  int32_t viscosity;                 /* MELTSIM_VISCOSITY_... */
  int32_t stray;                     /* MELTSIM_STRAY_... */
  double courant;                    /* sub-steps keep c dt / H at or below this, above 0, at most 0.6 */
  int32_t pieces_interval;           /* sub-steps between searches for pieces that came apart */
  int32_t heat_max_stages;           /* stages per super-step of heat, 2 to 1024 */
  int32_t heat_max_supersteps;       /* of heat in a sub-step; a step that needs more is refused */
  int32_t solute_max_supersteps;     /* likewise of species */
  double solute_time_scale;          /* species diffuse so many times faster than motion */
  double heat_level_tolerance;       /* temperatures that differ by no more count as level [K] */
  meltsim_surface_heat free_surface; /* heat through free surfaces of liquids */
  double wall_friction;              /* Coulomb coefficient */
  double wall_contact_angle;         /* of liquids with surface tension at walls, 0 to 180 degrees */
  double wall_velocity[6][3];        /* of each wall, in the order of `faces` [m/s]; along it only */
  void* stream;                      /* CUDA stream that the World runs on; null: its own */
  int32_t hydrostatic_start; /* liquid that stands on something starts with the pressure of rest, 0 or 1 */
  int32_t reserved;          /* 0 */
} meltsim_world_desc;

/* A substance. */
typedef struct meltsim_material_desc {
  uint32_t size;             /* sizeof(meltsim_material_desc) */
  int32_t freezes;           /* whether its liquid freezes onto it */
  const char* name;          /* copied */
  double density;            /* [kg/m^3] */
  double viscosity;          /* dynamic [Pa s]; where it depends on the shear rate, the consistency */
  double conductivity;       /* [W/(m K)] */
  double heat_capacity;      /* [J/(kg K)] */
  double melting_point;      /* [degrees Celsius]; infinity: never melts */
  double latent_heat;        /* [J/kg] */
  meltsim_id melts_into;     /* the liquid that it becomes, or {0, 0} */
  int32_t region_half_width; /* of shape matching, 0 to 8 spacings */
  int32_t reserved;          /* 0 */
  double stiffness;          /* of shape matching, 0 to 1 */
  double youngs_modulus;     /* [Pa]; 0: `stiffness` holds */
  double friction;           /* Coulomb coefficient */
  double surface_tension;    /* of a liquid [N/m]; 0: none */
  double contact_angle;      /* of liquids with surface tension at this solid, 0 to 180 degrees */
  double yield_stress;       /* of a liquid [Pa]; 0: none */
  double flow_index;         /* of a liquid; below 1 it thins as it is sheared, above 1 it thickens */
  double regularisation;     /* time beyond which what does not yield creeps [s] */
  const double*
      yield_stress_points; /* in place of yield_stress: temperature [degrees Celsius] and value, pair after
                                        pair, ascending; null: none */
  size_t yield_stress_point_count; /* pairs: 0, or 2 to 8 */
  double damping;                  /* of shape matching, 0 to 1 */
  double diffusivity;              /* in place of conductivity [m^2/s]; 0: conductivity holds */
  /* Properties by temperature, likewise, in place of the constants above; density of liquids alone. */
  const double* conductivity_points;
  size_t conductivity_point_count;
  const double* heat_capacity_points;
  size_t heat_capacity_point_count;
  const double* viscosity_points;
  size_t viscosity_point_count;
  const double* density_points;
  size_t density_point_count;
  double melting_range; /* what it is hotter where melting ends than at melting_point, where it begins [K] */
} meltsim_material_desc;

/* Liquid that fills a shape. */
typedef struct meltsim_fluid_desc {
  uint32_t size;              /* sizeof(meltsim_fluid_desc) */
  uint32_t reserved;          /* 0 */
  const meltsim_shape* shape; /* the volume */
  meltsim_id material;        /* of the liquid */
  double temperature;         /* [degrees Celsius] */
  double velocity[3];         /* [m/s] */
} meltsim_fluid_desc;

/* What makes a material a species: it dissolves in a liquid, or mixes with it. */
typedef struct meltsim_species_desc {
  uint32_t size;           /* sizeof(meltsim_species_desc) */
  uint32_t reserved;       /* 0 */
  meltsim_id dissolves_in; /* the liquid */
  double solubility;       /* mass fraction of the saturated solution; 1: mixes in any ratio */
  double diffusivity_in;   /* in that liquid [m^2/s] */
  double heat_of_solution; /* that dissolving takes up [J/kg] */
  double
      transfer_coefficient; /* of a layer at a dissolving body that is thinner than the spacing [m/s]; 0: none */
  const double*
      solubility_points; /* in place of solubility: temperature [degrees Celsius] and value, pair after
                                      pair, ascending; null: none. The species precipitates */
  size_t solubility_point_count; /* pairs: 0, or 2 to 8 */
} meltsim_species_desc;

/* A body. */
typedef struct meltsim_solid_desc {
  uint32_t size;                /* sizeof(meltsim_solid_desc) */
  int32_t motion;               /* MELTSIM_MOTION_... */
  const char* name;             /* copied; null: body<N> */
  const meltsim_shape* shape;   /* the volume */
  meltsim_id material;          /* of the body */
  double temperature;           /* [degrees Celsius] */
  double velocity[3];           /* of the centre of mass [m/s] */
  double angular_velocity[3];   /* about it [rad/s] */
  double max_speed;             /* the largest that any point of a body that moves will have [m/s] */
  meltsim_surface_heat surface; /* heat through the dry surface */
  double heat_source;           /* heat released in the body [W/m^3] */
  int32_t has_pivot;            /* whether `pivot` holds; 0: the centre of its particles */
  int32_t reserved;             /* 0 */
  double pivot[3];   /* of a kinematic body or proxy: the point that positions are of, as built [m] */
  double mass;       /* of a proxy, above 0 [kg] */
  double inertia[9]; /* of a proxy, about its pivot, row by row [kg m^2]; all 0: of the shape */
  double held_until; /* a free or rigid body stays where it is until then [s]; 0: free from the start */
  int32_t carve;     /* 0: refused where liquid lies in its place; 1: that leaves */
  int32_t growth;    /* lattice steps beyond its shape that liquid may freeze onto */
  const double*
      path; /* of a kinematic body, in place of velocities: time [s], displacement [m] of its pivot from where
                          the body is built, angle [rad] about path_axis, five numbers per point, times ascending, the
                          first point where it is built; null: none */
  size_t path_count;   /* points */
  double path_axis[3]; /* through the pivot */
} meltsim_solid_desc;

/* A nozzle that emits liquid at a steady speed, or an open face with liquid beyond. */
typedef struct meltsim_emitter_desc {
  uint32_t size;          /* sizeof(meltsim_emitter_desc) */
  uint32_t reserved;      /* 0 */
  const char* name;       /* copied; null: emitter<N> */
  double center[3];       /* end of the pipe [m] */
  double axis[3];         /* direction of the stream */
  double radius;          /* [m], at least one spacing */
  double speed;           /* [m/s] */
  meltsim_id material;    /* of the liquid */
  double temperature;     /* [degrees Celsius] */
  double from;            /* begins to emit [s] */
  double until;           /* ceases to emit [s] */
  uint64_t max_particles; /* most that it emits, 0: what from..until needs; see recycle */
  double width;           /* of a rectangular opening instead of a radius [m]; 0: a disc */
  double height;          /* its other side, along `up` [m] */
  double up[3];           /* which way the height lies */
  double level;           /* of liquid beyond the open face that `axis` points inwards from [m] */
  int32_t has_level;      /* whether `level` holds: a face instead of a nozzle */
  int32_t recycle; /* what has left comes again; at most max_particles at a time, 0: what fills the domain */
} meltsim_emitter_desc;

/* A part of space that heats, cools or holds the temperature of the particles inside. */
typedef struct meltsim_heat_region_desc {
  uint32_t size;              /* sizeof(meltsim_heat_region_desc) */
  int32_t has_temperature;    /* whether particles are held at `temperature`; excludes `source` */
  const char* name;           /* copied; null: heat<N> */
  const meltsim_shape* shape; /* the volume */
  double temperature;         /* [degrees Celsius] */
  double source;              /* heat released [W/m^3] */
  double from;                /* begins to act [s] */
  double until;               /* ceases to act [s] */
  const double* path; /* where it is: time [s] and displacement [m] from where it was built, four numbers
                                 per point, times ascending; null: it stays there */
  size_t path_count;  /* points */
} meltsim_heat_region_desc;

/* What a force field does: meltsim_force_field_desc::kind. */
enum {
  MELTSIM_FIELD_UNIFORM = 0,    /* accelerates by `acceleration` */
  MELTSIM_FIELD_RADIAL = 1,     /* away from `center` by `strength`, or towards it where that is negative */
  MELTSIM_FIELD_VORTEX = 2,     /* around `axis` through `center` by `strength` */
  MELTSIM_FIELD_DRAG = 3,       /* towards the velocity of a wind, at `rate` */
  MELTSIM_FIELD_HYDROSTATIC = 4 /* counts pressure below `center` from that of liquid at rest */
};

/* A part of space in which liquid and bodies that can move are accelerated (meltsim/desc.hpp: ForceFieldDesc). */
typedef struct meltsim_force_field_desc {
  uint32_t size;              /* sizeof(meltsim_force_field_desc) */
  int32_t kind;               /* one of the above */
  const char* name;           /* copied; null: field<N>, or the name that it has */
  const meltsim_shape* shape; /* a box, a sphere or a cylinder, moved, turned and scaled; null: everywhere */
  double acceleration[3];     /* of a uniform field [m/s^2] */
  int32_t has_center; /* whether `center` is given; otherwise that of the shape, everywhere the origin */
  int32_t power;      /* beyond `radius` strength goes as the distance to this power: 1, 0, -1, -2 */
  double center[3];   /* of a radial field, of a vortex's axis, of the wind's rotation [m] */
  double axis[3];     /* of a vortex */
  double strength;    /* of a radial field or a vortex at `radius` [m/s^2] */
  double radius;      /* within it strength grows linearly from 0 [m] */
  double velocity[3]; /* of the wind [m/s] */
  double angular_velocity[3]; /* of the wind about `center` [rad/s] */
  double rate;                /* at which a difference from the wind decays [1/s] */
  double from;                /* begins to act [s] */
  double until;               /* ceases to act [s] */
  int32_t liquid;             /* acts on liquid */
  int32_t bodies;             /* acts on bodies that can move */
  double density;             /* of the liquid of a hydrostatic field [kg/m^3] */
} meltsim_force_field_desc;

/* How a kinematic body moves from the next step on. */
typedef struct meltsim_body_motion {
  uint32_t size;              /* sizeof(meltsim_body_motion) */
  int32_t has_position;       /* whether `position` holds */
  int32_t has_orientation;    /* whether `orientation` holds */
  int32_t teleport;           /* places the body there instead of moving it; liquid goes out of its way */
  double position[3];         /* of its pivot at the end of the next step [m] */
  double orientation[4];      /* then, relative to the body as built: a unit quaternion w, x, y, z */
  double velocity[3];         /* of the pivot: of what is not given above, and afterwards [m/s] */
  double angular_velocity[3]; /* likewise [rad/s] */
} meltsim_body_motion;

/* Where a proxy is and how it moves, as the host has it. */
typedef struct meltsim_proxy_state {
  uint32_t size;              /* sizeof(meltsim_proxy_state) */
  int32_t teleport;           /* puts the proxy there at once instead of within the next step */
  double position[3];         /* of its centre of mass [m] */
  double orientation[4];      /* relative to the body as built: a unit quaternion w, x, y, z */
  double velocity[3];         /* of the centre of mass [m/s] */
  double angular_velocity[3]; /* [rad/s] */
  double acceleration[3];     /* by the host's own forces, beside gravity [m/s^2] */
} meltsim_proxy_state;

/* Changes to an emitter: those whose has_... is set. */
typedef struct meltsim_emitter_setting {
  uint32_t size;           /* sizeof(meltsim_emitter_setting) */
  int32_t has_on;          /* whether `on` holds */
  int32_t has_speed;       /* whether `speed` holds */
  int32_t has_temperature; /* whether `temperature` holds */
  int32_t on;              /* 0: no further layers come */
  int32_t reserved;        /* 0 */
  double speed;            /* [m/s], of the liquid in the pipe, too */
  double temperature;      /* of layers to come [degrees Celsius] */
  double center[3];        /* end of the pipe from the next step on [m] */
  int32_t has_center;      /* whether `center` holds */
  int32_t reserved2;       /* 0 */
  double level;            /* of liquid beyond a face [m] */
  int32_t has_level;       /* whether `level` holds */
  int32_t reserved3;       /* 0 */
} meltsim_emitter_setting;

/* A probe: samples inside the sub-steps. */
enum {
  MELTSIM_PROBE_POINT = 0, /* averages at points */
  MELTSIM_PROBE_LEVEL = 1, /* height of the liquid above points [m] */
  MELTSIM_PROBE_FORCE = 2, /* on a body or wall */
  MELTSIM_PROBE_HEAT = 3,  /* into a body or through a wall [W] */
  MELTSIM_PROBE_FLUX = 4   /* of liquid through a disc or rectangle */
};
typedef struct meltsim_probe_desc {
  uint32_t size;        /* sizeof(meltsim_probe_desc) */
  int32_t kind;         /* one of MELTSIM_PROBE_... */
  const char* name;     /* null: "probe<N>" */
  const double* points; /* 3 numbers per point [m] */
  uint64_t point_count; /* how many points */
  const char* const*
      fields; /* "temperature", "pressure", "velocity", ...; "force", ...; "mass_flux", ... (probe.hpp) */
  uint64_t field_count; /* how many fields */
  meltsim_id body;      /* force and heat: the body; {0, 0}: the wall */
  int32_t wall;         /* force and heat without a body: 0 to 5, in the order of `faces`; -1: none */
  int32_t reserved;     /* 0 */
  double normal[3];     /* flux: the positive direction */
  double radius;        /* flux: of a disc [m]; 0: a rectangle */
  double along[3];      /* flux: direction of a side of the rectangle */
  double side[2];       /* flux: its sides [m] */
  double every;         /* interval between samples [s]; 0: every sub-step */
  double from;          /* first time that is due [s] */
  double until;         /* last time that may be due [s] */
} meltsim_probe_desc;

/* Whose surface, and how fine. */
enum { MELTSIM_SURFACE_LIQUID = 0, MELTSIM_SURFACE_SOLIDS = 1, MELTSIM_SURFACE_BODY = 2 };
typedef struct meltsim_surface_desc {
  uint32_t size;            /* sizeof(meltsim_surface_desc) */
  int32_t of;               /* one of MELTSIM_SURFACE_... */
  meltsim_id body;          /* of MELTSIM_SURFACE_BODY: which */
  double cell;              /* edge of the cells [m]; 0: half a spacing */
  int32_t anisotropic;      /* not 0: ellipsoids, smoother and several times the cost */
  int32_t smoothing;        /* passes over the mesh, 0 to 100 */
  int32_t closed_at_solids; /* not 0: the liquid's mesh covers what touches solids, too */
  int32_t no_wait;          /* not 0: meltsim_world_surface_view() does not wait for the mesh's size */
} meltsim_surface_desc;

/* What colours a render view has. */
enum { MELTSIM_COLOR_NOTHING = 0, MELTSIM_COLOR_MATERIAL = 1, MELTSIM_COLOR_TEMPERATURE = 2 };
typedef struct meltsim_render_desc {
  uint32_t size; /* sizeof(meltsim_render_desc) */
  int32_t color; /* one of MELTSIM_COLOR_... */
  const uint32_t*
      colors; /* the table: red in the lowest byte, then green, blue, opacity; null: a palette, a ramp */
  uint64_t color_count; /* at most 256 */
  double coldest;       /* temperature of the first colour [degrees Celsius] */
  double hottest;       /* of the last one */
} meltsim_render_desc;

/* These fill a struct of `size` bytes, which may be smaller than the library's where a host was built against an older header, and set
 * its size and the defaults. For languages that call C; in C each has an inline form without the size. */
MELTSIM_C_API void meltsim_world_desc_init_sized(meltsim_world_desc* to, size_t size);
MELTSIM_C_API void meltsim_material_desc_init_sized(meltsim_material_desc* to, size_t size);
MELTSIM_C_API void meltsim_species_desc_init_sized(meltsim_species_desc* to, size_t size);
MELTSIM_C_API void meltsim_fluid_desc_init_sized(meltsim_fluid_desc* to, size_t size);
MELTSIM_C_API void meltsim_solid_desc_init_sized(meltsim_solid_desc* to, size_t size);
MELTSIM_C_API void meltsim_emitter_desc_init_sized(meltsim_emitter_desc* to, size_t size);
MELTSIM_C_API void meltsim_heat_region_desc_init_sized(meltsim_heat_region_desc* to, size_t size);
MELTSIM_C_API void meltsim_force_field_desc_init_sized(meltsim_force_field_desc* to, size_t size);
MELTSIM_C_API void meltsim_body_motion_init_sized(meltsim_body_motion* to, size_t size);
MELTSIM_C_API void meltsim_proxy_state_init_sized(meltsim_proxy_state* to, size_t size);
MELTSIM_C_API void meltsim_emitter_setting_init_sized(meltsim_emitter_setting* to, size_t size);
MELTSIM_C_API void meltsim_probe_desc_init_sized(meltsim_probe_desc* to, size_t size);
MELTSIM_C_API void meltsim_surface_desc_init_sized(meltsim_surface_desc* to, size_t size);
MELTSIM_C_API void meltsim_render_desc_init_sized(meltsim_render_desc* to, size_t size);

static inline void meltsim_world_desc_init(meltsim_world_desc* to) {
  meltsim_world_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_material_desc_init(meltsim_material_desc* to) {
  meltsim_material_desc_init_sized(to, sizeof *to);
} /* size and defaults: water */
static inline void meltsim_species_desc_init(meltsim_species_desc* to) {
  meltsim_species_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_fluid_desc_init(meltsim_fluid_desc* to) {
  meltsim_fluid_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_solid_desc_init(meltsim_solid_desc* to) {
  meltsim_solid_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_emitter_desc_init(meltsim_emitter_desc* to) {
  meltsim_emitter_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_heat_region_desc_init(meltsim_heat_region_desc* to) {
  meltsim_heat_region_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_force_field_desc_init(meltsim_force_field_desc* to) {
  meltsim_force_field_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_body_motion_init(meltsim_body_motion* to) {
  meltsim_body_motion_init_sized(to, sizeof *to);
} /* size and defaults: at rest */
static inline void meltsim_proxy_state_init(meltsim_proxy_state* to) {
  meltsim_proxy_state_init_sized(to, sizeof *to);
} /* size and defaults: at rest */
static inline void meltsim_emitter_setting_init(meltsim_emitter_setting* to) {
  meltsim_emitter_setting_init_sized(to, sizeof *to);
} /* size and changes nothing */
static inline void meltsim_probe_desc_init(meltsim_probe_desc* to) {
  meltsim_probe_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_surface_desc_init(meltsim_surface_desc* to) {
  meltsim_surface_desc_init_sized(to, sizeof *to);
} /* size and defaults */
static inline void meltsim_render_desc_init(meltsim_render_desc* to) {
  meltsim_render_desc_init_sized(to, sizeof *to);
} /* size and defaults: no colours */

/* ---- Worlds -------------------------------------------------------------------------------------------------------------- */
/* Makes an empty World in *world; on an error *world is null. */
MELTSIM_C_API meltsim_status meltsim_world_create(const meltsim_world_desc* desc, meltsim_world** world);
/* Frees a World; null does nothing. */
MELTSIM_C_API void meltsim_world_destroy(meltsim_world* world);

/* Building, also between steps. `id` and `added` may be null. */
MELTSIM_C_API meltsim_status meltsim_world_add_material(meltsim_world* world,
                                                        const meltsim_material_desc* desc, meltsim_id* id);
MELTSIM_C_API meltsim_status meltsim_world_add_fluid(meltsim_world* world, const meltsim_fluid_desc* desc,
                                                     uint64_t* added);
/* Adds a material that is a species. */
MELTSIM_C_API meltsim_status meltsim_world_add_species(meltsim_world* world,
                                                       const meltsim_material_desc* material,
                                                       const meltsim_species_desc* species, meltsim_id* id);
/* The same as meltsim_world_add_fluid of liquid in which something is dissolved: species[k] with the mass fraction fractions[k],
 * k < count. `added` may be null. */
MELTSIM_C_API meltsim_status meltsim_world_add_mixture(meltsim_world* world, const meltsim_fluid_desc* desc,
                                                       const meltsim_id* species, const double* fractions,
                                                       size_t count, uint64_t* added);
MELTSIM_C_API meltsim_status meltsim_world_add_solid(meltsim_world* world, const meltsim_solid_desc* desc,
                                                     meltsim_id* id);
MELTSIM_C_API meltsim_status meltsim_world_add_emitter(meltsim_world* world, const meltsim_emitter_desc* desc,
                                                       meltsim_id* id);
/* The same of liquid in which something is dissolved, as meltsim_world_add_mixture(). */
MELTSIM_C_API meltsim_status meltsim_world_add_mixture_emitter(meltsim_world* world,
                                                               const meltsim_emitter_desc* desc,
                                                               const meltsim_id* species,
                                                               const double* fractions, size_t count,
                                                               meltsim_id* id);
MELTSIM_C_API meltsim_status meltsim_world_add_heat_region(meltsim_world* world,
                                                           const meltsim_heat_region_desc* desc,
                                                           meltsim_id* id);
/* At most 16 at a time. */
MELTSIM_C_API meltsim_status meltsim_world_add_force_field(meltsim_world* world,
                                                           const meltsim_force_field_desc* desc,
                                                           meltsim_id* id);
MELTSIM_C_API meltsim_status meltsim_world_add_probe(meltsim_world* world, const meltsim_probe_desc* desc,
                                                     meltsim_id* id);

/* Allocates and plans for the next step; meltsim_world_step() does it if it was not called. */
MELTSIM_C_API meltsim_status meltsim_world_prepare(meltsim_world* world);
/* What meltsim_world_settle() came to. The caller sets `size`. */
typedef struct meltsim_settled {
  uint32_t size;     /* sizeof(meltsim_settled) */
  uint32_t reserved; /* 0 */
  double seconds;    /* that the liquid was given [s]; 0: there was none that could move */
  uint64_t substeps; /* that it took */
  double farthest;   /* way of the particle that was moved farthest [m] */
  double fastest;    /* speed of the fastest at the end, before it was stopped [m/s] */
} meltsim_settled;
/* Lets liquid come to rest before the first step, with bodies held, so that forces on what it touches are those of rest. `seconds`: how long it is
 * given; 0 derives it. Liquid that nothing holds flows meanwhile. Waits. `result` may be null. */
MELTSIM_C_API meltsim_status meltsim_world_settle(meltsim_world* world, double seconds,
                                                  meltsim_settled* result);
/* Enqueues `seconds`, in sub-steps that keep it stable. */
MELTSIM_C_API meltsim_status meltsim_world_step(meltsim_world* world, double seconds);
/* A step that may have ended early. The caller sets `size`. */
typedef struct meltsim_timed_step {
  uint32_t size;       /* sizeof(meltsim_timed_step) */
  int32_t over_budget; /* wall_ms is above what was asked for; with one sub-step: one alone takes longer */
  double simulated;    /* by which meltsim_world_time() went on [s] */
  double owed;         /* rest of `seconds`, which was not simulated [s]; 0: all of it was */
  uint64_t substeps;   /* taken; meltsim_world_step_part() with as many repeats the call to the bit */
  uint64_t planned;    /* sub-steps that all of `seconds` takes */
  double wall_ms;      /* the call took [ms], with the wait for the device */
  double substep_ms;   /* running mean over the sub-steps of such calls [ms]; 0: none was measured yet */
} meltsim_timed_step;
/* Takes sub-steps of `seconds` until `milliseconds` of wall time are used up, at least one, and waits for them. What is owed is
 * forgotten: a host that is to catch up adds it to the next step. `result` may be null. */
MELTSIM_C_API meltsim_status meltsim_world_step_within(meltsim_world* world, double seconds,
                                                       double milliseconds, meltsim_timed_step* result);
/* Takes the first `substeps` of the sub-steps of `seconds`, all if there are no more, and waits for them. `result` may be null. */
MELTSIM_C_API meltsim_status meltsim_world_step_part(meltsim_world* world, double seconds, uint64_t substeps,
                                                     meltsim_timed_step* result);
/* Ends the running step, or the next one, with MELTSIM_INTERRUPTED. From any thread or a signal handler. */
MELTSIM_C_API void meltsim_world_interrupt(meltsim_world* world);
/* Sets the motion of a kinematic body; without waiting, but for a teleport. */
MELTSIM_C_API meltsim_status meltsim_world_set_motion(meltsim_world* world, meltsim_id body,
                                                      const meltsim_body_motion* motion);
/* Pose and velocities of a kinematic body now. The caller sets `size`. */
MELTSIM_C_API meltsim_status meltsim_world_motion(meltsim_world* world, meltsim_id body,
                                                  meltsim_body_motion* motion);
/* Moves the mesh of a kinematic body that was built from one: `vertex_count` vertices, 3 numbers each, in the order in which the mesh
 * has them: where they are at the end of the next step [m], relative to the body as built; velocities from then on [m/s], or null: they stay.
 * Without waiting, but for the first call for a body. */
MELTSIM_C_API meltsim_status meltsim_world_update_mesh(meltsim_world* world, meltsim_id body,
                                                       const double* vertices, const double* velocities,
                                                       size_t vertex_count);
/* Sets pose and twist of a proxy as the host has them now. */
MELTSIM_C_API meltsim_status meltsim_world_set_proxy(meltsim_world* world, meltsim_id body,
                                                     const meltsim_proxy_state* state);
/* Those of a proxy now. Waits for all steps. The caller sets `size`. */
MELTSIM_C_API meltsim_status meltsim_world_proxy(meltsim_world* world, meltsim_id body,
                                                 meltsim_proxy_state* state);
/* Begins (on not 0) or ends to sum up what acts on a body. Proxies are always watched. */
MELTSIM_C_API meltsim_status meltsim_world_watch_forces(meltsim_world* world, meltsim_id body, int32_t on);

/* Kinds of events, a bit each. */
enum {
  MELTSIM_EVENT_MELTED = 1,        /* a particle of a body became liquid */
  MELTSIM_EVENT_FROZEN = 2,        /* a liquid particle became part of a body */
  MELTSIM_EVENT_SPLIT = 4,         /* a piece came off a body, or off a piece of one */
  MELTSIM_EVENT_CONTACT_BEGUN = 8, /* a body that can move touches another body or a wall */
  MELTSIM_EVENT_CONTACT_ENDED = 16,
  MELTSIM_EVENT_GONE = 32, /* nothing solid is left of a body */
  MELTSIM_EVENT_LEFT = 64, /* a particle left the scene */
  MELTSIM_EVENT_ALL = 127
};
/* Begins to note events of the kinds in a sum of MELTSIM_EVENT_..., in a ring of `capacity` events (1 to 1,048,576). */
MELTSIM_C_API meltsim_status meltsim_world_watch_events(meltsim_world* world, uint32_t capacity,
                                                        uint32_t kinds);
/* Ends that. */
MELTSIM_C_API meltsim_status meltsim_world_stop_events(meltsim_world* world);

/* Steering: what is set holds from the next step on. */
/* Another viscosity, conductivity, friction and so on; what masses and heat are counted by must stay: World::set_material. */
MELTSIM_C_API meltsim_status meltsim_world_set_material(meltsim_world* world, meltsim_id material,
                                                        const meltsim_material_desc* desc);
MELTSIM_C_API meltsim_status meltsim_world_set_gravity(meltsim_world* world,
                                                       const double gravity[3]); /* [m/s^2] */
/* Holds a free or rigid body where it is (on: not 0), or lets it go: World::hold. */
MELTSIM_C_API meltsim_status meltsim_world_hold(meltsim_world* world, meltsim_id body, int32_t on);
/* Of a free or rigid body: velocity of its centre [m/s], angular velocity about it [rad/s]; impulse [N s], angular impulse
 * [N m s]. Null: 0. */
MELTSIM_C_API meltsim_status meltsim_world_set_velocity(meltsim_world* world, meltsim_id body,
                                                        const double velocity[3],
                                                        const double angular_velocity[3]);
MELTSIM_C_API meltsim_status meltsim_world_apply_impulse(meltsim_world* world, meltsim_id body,
                                                         const double impulse[3],
                                                         const double angular_impulse[3]);
/* Heat through a wall, 0 to 5 in the order of `faces`; through the free surface of liquids. */
MELTSIM_C_API meltsim_status meltsim_world_set_wall_heat(meltsim_world* world, int32_t face,
                                                         const meltsim_surface_heat* heat);
MELTSIM_C_API meltsim_status meltsim_world_set_free_surface_heat(meltsim_world* world,
                                                                 const meltsim_surface_heat* heat);
/* Heat through the dry surface of a body, and what is released in it [W/m^3]. */
MELTSIM_C_API meltsim_status meltsim_world_set_body_heat(meltsim_world* world, meltsim_id body,
                                                         const meltsim_surface_heat* surface, double source);
/* A region holds `temperature`, or, where that is null, releases `source` [W/m^3]. */
MELTSIM_C_API meltsim_status meltsim_world_set_heat_region(meltsim_world* world, meltsim_id region,
                                                           const double* temperature, double source);
/* Moves a region: its shape lies `displacement` [m] from where it was built, and goes on at `velocity` [m/s]; null: 0. */
MELTSIM_C_API meltsim_status meltsim_world_move_heat_region(meltsim_world* world, meltsim_id region,
                                                            const double displacement[3],
                                                            const double velocity[3]);
/* Replaces a force field: place, kind and strength; without waiting. Takes one out. */
MELTSIM_C_API meltsim_status meltsim_world_set_force_field(meltsim_world* world, meltsim_id field,
                                                           const meltsim_force_field_desc* desc);
MELTSIM_C_API meltsim_status meltsim_world_remove_force_field(meltsim_world* world, meltsim_id field);
MELTSIM_C_API meltsim_status meltsim_world_remove_heat_region(meltsim_world* world, meltsim_id region);
/* With its samples that were not taken; refused while a reading with samples is open. */
MELTSIM_C_API meltsim_status meltsim_world_remove_probe(meltsim_world* world, meltsim_id probe);
MELTSIM_C_API meltsim_status meltsim_world_set_heat_time_scale(meltsim_world* world,
                                                               double scale); /* 0 stops heat */
MELTSIM_C_API meltsim_status meltsim_world_set_emitter(meltsim_world* world, meltsim_id emitter,
                                                       const meltsim_emitter_setting* setting);
/* Takes out all that is solid of a body; liquid whose particles have their centres in a shape. `removed` may be null. */
MELTSIM_C_API meltsim_status meltsim_world_remove(meltsim_world* world, meltsim_id body);
MELTSIM_C_API meltsim_status meltsim_world_remove_liquid(meltsim_world* world, const meltsim_shape* shape,
                                                         uint64_t* removed);
/* Forgets what was removed or has left, and lattices of removed bodies: ids of particles close up. Sets *was to `count` numbers, per id the one
 * that it had, which hold until the next call or meltsim_world_destroy(). Both may be null: World::compact. */
MELTSIM_C_API meltsim_status meltsim_world_compact(meltsim_world* world, const uint32_t** was, size_t* count);

/* Time after all enqueued steps [s]; largest stable sub-step [s]. */
MELTSIM_C_API double meltsim_world_time(const meltsim_world* world);
MELTSIM_C_API double meltsim_world_stable_dt(const meltsim_world* world);
/* Sub-steps enqueued so far. */
MELTSIM_C_API uint64_t meltsim_world_steps(const meltsim_world* world);
/* MELTSIM_BACKEND_CPU or MELTSIM_BACKEND_CUDA. */
MELTSIM_C_API int32_t meltsim_world_backend(const meltsim_world* world);

/* Report on the steps since the last report. The caller sets `size`; what lies within it is filled. */
typedef struct meltsim_report {
  uint32_t size;    /* sizeof(meltsim_report) */
  int32_t halted;   /* diverged: the World keeps its last good state; meltsim_error_text() has the reason */
  uint64_t steps;   /* sub-steps completed */
  double time;      /* [s] */
  double max_speed; /* [m/s] */
  uint64_t fluid;   /* liquid particles */
  uint64_t solid;   /* solid particles */
  uint64_t melted;  /* so far */
  uint64_t frozen;  /* so far */
  uint64_t removed; /* so far, through open faces */
  uint64_t entered; /* so far, below the level of an emitter or from one that recycles */
} meltsim_report;
/* Waits for all steps and reports on them. MELTSIM_OK also where the simulation has halted. */
MELTSIM_C_API meltsim_status meltsim_world_synchronize(meltsim_world* world, meltsim_report* report);

/* Conserved quantities. The caller sets `size`. */
typedef struct meltsim_totals {
  uint32_t size;           /* sizeof(meltsim_totals) */
  uint32_t reserved;       /* 0 */
  double mass;             /* [kg] */
  double momentum[3];      /* [kg m/s] */
  double kinetic;          /* [J] */
  double potential;        /* [J] */
  double thermal;          /* latent heat included [J] */
  double latent;           /* [J] */
  double heat_in;          /* through surfaces and from sources since the World was created [J] */
  double temperature_min;  /* [degrees Celsius] */
  double temperature_mean; /* [degrees Celsius] */
  double temperature_max;  /* [degrees Celsius] */
  double field_work;       /* of force fields since the World was created [J] */
  double field_impulse[3]; /* likewise [N s] */
  double latent_max; /* what latent is where all that can melt is liquid [J]; latent / latent_max is molten */
} meltsim_totals;
/* Waits for all steps. */
MELTSIM_C_API meltsim_status meltsim_world_totals(meltsim_world* world, meltsim_totals* totals);

/* What acted on a watched body since it was last read: impulses [N s] and angular impulses [N m s] about its centre of mass, of a
 * kinematic body about the pivot. */
typedef struct meltsim_body_forces {
  meltsim_id body;             /* the body */
  double seconds;              /* that they cover */
  double impulse[3];           /* pressure, viscosity and contact */
  double angular_impulse[3];   /* likewise */
  double pressure[3];          /* impulse by the pressure of liquid */
  double pressure_angular[3];  /* its moment */
  double viscosity[3];         /* impulse by its viscosity */
  double viscosity_angular[3]; /* its moment */
  double contact[3];           /* impulse by bodies and walls that it touches */
  double contact_angular[3];   /* its moment */
  double heat;                 /* that it received [J] */
  double position[3];          /* of its centre of mass, or the pivot [m] */
  double orientation[4];       /* of a proxy or kinematic body: w, x, y, z */
  double velocity[3];          /* of a proxy or kinematic body [m/s] */
  double angular_velocity[3];  /* of a proxy or kinematic body [rad/s] */
} meltsim_body_forces;
/* What acted on every watched body; the sums begin anew. `struct_size` is sizeof(meltsim_body_forces). *count is set to how many
 * there are; where `capacity` is less, nothing else is done and MELTSIM_CAPACITY is returned. Waits for all steps. */
MELTSIM_C_API meltsim_status meltsim_world_take_forces(meltsim_world* world, meltsim_body_forces* forces,
                                                       size_t struct_size, size_t capacity, size_t* count);

/* Something that happened in a sub-step. */
typedef struct meltsim_event {
  uint32_t kind;      /* one of MELTSIM_EVENT_... */
  int32_t wall;       /* of a contact with a wall 0 to 5, in the order of `faces`; else -1 */
  uint64_t step;      /* the sub-step, from 1 */
  double time;        /* at its end [s] */
  double position[3]; /* of `particle` then [m] */
  uint32_t particle;  /* id: of contacts of one that touches, of split of one of the new piece */
  uint32_t piece;     /* of split: label of the new piece; else 0 */
  uint32_t from;      /* of split: label of what it came off; else 0 */
  uint32_t reserved;  /* 0 */
  meltsim_id body;    /* {0, 0}: of liquid that left */
  meltsim_id other;   /* of a contact of two bodies the one with the larger index; else {0, 0} */
} meltsim_event;
/* Events since they were last read, in the order in which they came. `struct_size` is sizeof(meltsim_event). `events` has room for as
 * many as the ring; for fewer nothing is done but that *count is set to that number, and MELTSIM_CAPACITY is returned. *count is set
 * to how many there are, *lost (may be null) to how many older ones the ring had no room for. Waits for all steps. */
MELTSIM_C_API meltsim_status meltsim_world_take_events(meltsim_world* world, meltsim_event* events,
                                                       size_t struct_size, size_t capacity, size_t* count,
                                                       uint64_t* lost);

/* Reading without waiting: a request is enqueued behind the steps so far, and its values are those of then. At most 4 are open. */
enum {
  MELTSIM_READ_TOTALS = 1,
  MELTSIM_READ_FORCES = 2,
  MELTSIM_READ_EVENTS = 4,
  MELTSIM_READ_PIECES = 8,
  MELTSIM_READ_PARTICLES = 16,
  MELTSIM_READ_PROBES = 32
};
/* parts: a sum of MELTSIM_READ_...; forces, events and samples of probes begin anew with it. */
MELTSIM_C_API meltsim_status meltsim_world_request(meltsim_world* world, uint32_t parts, uint64_t* ticket);
/* Whether meltsim_world_take() would return at once. */
MELTSIM_C_API meltsim_status meltsim_world_ready(meltsim_world* world, uint64_t ticket, int32_t* ready);
/* Waits for that reading, not for steps behind it, and closes the ticket. Free it with meltsim_reading_destroy(). On an error *reading is
 * null: keep one that is still needed elsewhere. */
MELTSIM_C_API meltsim_status meltsim_world_take(meltsim_world* world, uint64_t ticket,
                                                meltsim_reading** reading);
/* The report that meltsim_world_synchronize() would have given then. */
MELTSIM_C_API meltsim_status meltsim_reading_report(const meltsim_reading* reading, meltsim_report* report);
/* Conserved quantities, if they were asked for. */
MELTSIM_C_API meltsim_status meltsim_reading_totals(const meltsim_reading* reading, meltsim_totals* totals);
/* What acted on watched bodies, if that was asked for; as meltsim_world_take_forces(). */
MELTSIM_C_API meltsim_status meltsim_reading_forces(const meltsim_reading* reading,
                                                    meltsim_body_forces* forces, size_t struct_size,
                                                    size_t capacity, size_t* count);
/* Events, if they were asked for. *count is set to how many there are; where `capacity` is less, nothing else is done and
 * MELTSIM_CAPACITY is returned. */
MELTSIM_C_API meltsim_status meltsim_reading_events(const meltsim_reading* reading, meltsim_event* events,
                                                    size_t struct_size, size_t capacity, size_t* count,
                                                    uint64_t* lost);
/* One connected piece of a body. */
typedef struct meltsim_piece {
  meltsim_id body;            /* the body that it is or was part of */
  uint32_t piece;             /* label */
  uint32_t reserved;          /* 0 */
  uint64_t particles;         /* number of its particles */
  double mass;                /* [kg] */
  double center[3];           /* of mass [m] */
  double velocity[3];         /* of the centre [m/s] */
  double orientation[4];      /* rotation since it was built: w, x, y, z */
  double angular_velocity[3]; /* [rad/s] */
  double inertia[9];          /* about the centre, row by row [kg m^2] */
  double min[3];              /* of its bounds [m] */
  double max[3];              /* of its bounds [m] */
  double temperature_mean;    /* weighted by mass [degrees Celsius] */
  double submerged_fraction;  /* share of its volume below the level of the liquid */
} meltsim_piece;
/* Pieces, if they were asked for; as meltsim_reading_events(). */
MELTSIM_C_API meltsim_status meltsim_reading_pieces(const meltsim_reading* reading, meltsim_piece* pieces,
                                                    size_t struct_size, size_t capacity, size_t* count);
/* Particles by id in single precision: parallel arrays of the reading's, which hold until it is freed. The caller sets `size`. */
typedef struct meltsim_particle_frame {
  uint32_t size;                /* sizeof(meltsim_particle_frame) */
  uint32_t reserved;            /* 0 */
  uint64_t count;               /* particles; without removed ones */
  double origin[3];             /* positions are relative to it [m] */
  const uint32_t* id;           /* ascending */
  const float* position;        /* 3 per particle [m] */
  const float* velocity;        /* 3 per particle [m/s] */
  const float* temperature;     /* [degrees Celsius] */
  const float* liquid_fraction; /* 0 solid to 1 liquid */
  const float* density;         /* [kg/m^3]; 0 before the first sub-step */
  const float* pressure;        /* [Pa]; 0 for solids */
  const uint32_t* tag;          /* as meltsim_particles */
  const uint32_t* piece;        /* label of the piece, 0 for liquid */
} meltsim_particle_frame;
/* Particles, if they were asked for. */
MELTSIM_C_API meltsim_status meltsim_reading_particles(const meltsim_reading* reading,
                                                       meltsim_particle_frame* particles);
/* Samples of a probe, in the order in which probes were added: arrays of the reading's. The caller sets `size`. */
typedef struct meltsim_probe_series {
  uint32_t size;        /* sizeof(meltsim_probe_series) */
  uint32_t points;      /* of the probe; 1 of force, heat and flux */
  uint32_t width;       /* values per point */
  uint32_t reserved;    /* 0 */
  uint64_t samples;     /* since they were last read */
  const double* time;   /* per sample [s] */
  const double* values; /* [sample][point][value], in the order of the fields */
} meltsim_probe_series;
/* Series number `index`; MELTSIM_INVALID_ARGUMENT where there are not so many, or they were not asked for. */
MELTSIM_C_API meltsim_status meltsim_reading_probe(const meltsim_reading* reading, size_t index,
                                                   meltsim_probe_series* series);
/* Frees a reading; null does nothing. */
MELTSIM_C_API void meltsim_reading_destroy(meltsim_reading* reading);

/* Particles by id. The caller sets `size`, `capacity` and the arrays to fill; others are null. */
typedef struct meltsim_particles {
  uint32_t size;           /* sizeof(meltsim_particles) */
  uint32_t reserved;       /* 0 */
  uint64_t capacity;       /* particles that each array has room for */
  uint64_t count;          /* out: particles there are */
  uint32_t* id;            /* ascending */
  double* position;        /* 3 per particle [m] */
  double* velocity;        /* 3 per particle [m/s] */
  double* temperature;     /* [degrees Celsius] */
  double* liquid_fraction; /* 0 solid to 1 liquid */
  uint32_t* tag;           /* bits of meltsim/particle_tag.hpp: 0x100 solid; low byte: material */
} meltsim_particles;
/* Waits for all steps. MELTSIM_CAPACITY, with `count` set and no array written, where there are more than `capacity`. */
MELTSIM_C_API meltsim_status meltsim_world_particles(meltsim_world* world, meltsim_particles* particles);
/* Mass fraction of a species in every particle, in the order of meltsim_world_particles(). *count is set to the number of particles;
 * MELTSIM_CAPACITY, with nothing written, where that is more than `capacity`. Waits for all steps. */
MELTSIM_C_API meltsim_status meltsim_world_fractions(meltsim_world* world, meltsim_id species, double* values,
                                                     uint64_t capacity, uint64_t* count);

/* Fields ("temperature", "pressure", ...; one value each) at points, 3 numbers per point: values[point]. "velocity" is its
 * magnitude. NaN where there is nothing. Waits for all steps. */
MELTSIM_C_API meltsim_status meltsim_world_sample(meltsim_world* world, const double* points,
                                                  size_t point_count, const char* field, double* values);

/* Rays against liquid, bodies and walls. */
typedef struct meltsim_ray {
  double origin[3];    /* [m] */
  double direction[3]; /* of any length but 0 */
  double length;       /* how far it looks [m]; > 0, may be infinite */
} meltsim_ray;
enum { MELTSIM_RAY_LIQUID = 1, MELTSIM_RAY_BODIES = 2, MELTSIM_RAY_WALLS = 4, MELTSIM_RAY_ALL = 7 };
/* Where a ray ends. */
typedef struct meltsim_ray_hit {
  uint32_t what;     /* 0 nothing, 1 liquid, 2 a body, 3 a wall */
  int32_t wall;      /* 0 to 5, in the order of `faces`; -1 but for a wall */
  double distance;   /* from its origin [m]; infinite: nothing */
  double point[3];   /* [m] */
  double normal[3];  /* outward: a unit vector */
  meltsim_id body;   /* {0, 0} but for a body */
  uint32_t particle; /* id of the nearest one of what is there; 0xffffffff: none */
  uint32_t reserved; /* 0 */
} meltsim_ray_hit;
/* Where rays first meet what is sought, a sum of MELTSIM_RAY_...; hits[ray]. `struct_size` is sizeof(meltsim_ray_hit). Waits for all
 * steps. */
MELTSIM_C_API meltsim_status meltsim_world_cast_rays(meltsim_world* world, const meltsim_ray* rays,
                                                     size_t ray_count, uint32_t sought, meltsim_ray_hit* hits,
                                                     size_t struct_size);
/* Liquid within a shape: particles and their volume at rest [m^3]; either may be null. Waits for all steps. */
MELTSIM_C_API meltsim_status meltsim_world_liquid_in(meltsim_world* world, const meltsim_shape* shape,
                                                     uint64_t* particles, double* volume);
/* Bodies within a shape, and how many of their particles each; as meltsim_reading_events(). `particles` may be null. Waits. */
MELTSIM_C_API meltsim_status meltsim_world_bodies_in(meltsim_world* world, const meltsim_shape* shape,
                                                     meltsim_id* bodies, uint64_t* particles, size_t capacity,
                                                     size_t* count);

/* Makes a surface in *surface, which meltsim_surface_destroy() frees. Waits for all steps. On an error *surface is null. */
MELTSIM_C_API meltsim_status meltsim_world_surface(meltsim_world* world, const meltsim_surface_desc* desc,
                                                   meltsim_surface** surface);
/* Arrays of a surface, which hold until it is freed. The caller sets `size`. */
typedef struct meltsim_mesh {
  uint32_t size;                /* sizeof(meltsim_mesh) */
  uint32_t reserved;            /* 0 */
  uint64_t vertices;            /* number of vertices */
  uint64_t triangles;           /* number of triangles */
  double origin[3];             /* add it to positions [m] */
  const float* position;        /* 3 per vertex [m] */
  const float* normal;          /* 3 per vertex: a unit vector, outward */
  const float* temperature;     /* per vertex [degrees Celsius] */
  const float* liquid_fraction; /* per vertex, 0 to 1 */
  const uint32_t* body;         /* per vertex: 0 liquid, else index + 1 */
  const uint32_t* material;     /* per vertex: index */
  const uint32_t* triangle;     /* 3 vertices per triangle, counter-clockwise from outside */
} meltsim_mesh;
MELTSIM_C_API meltsim_status meltsim_surface_mesh(const meltsim_surface* surface, meltsim_mesh* mesh);
/* Frees a surface; null does nothing. */
MELTSIM_C_API void meltsim_surface_destroy(meltsim_surface* surface);

/* Particles by id in single precision in the memory of the backend: what a renderer draws from. The caller sets `size`. */
typedef struct meltsim_render_view {
  uint32_t size;                /* sizeof(meltsim_render_view) */
  int32_t backend;              /* MELTSIM_BACKEND_CUDA: the pointers are into the device's memory */
  void* stream;                 /* cudaStream_t; null on the CPU */
  uint64_t count;               /* ids so far; 0x800 in `tag`: removed */
  double origin[3];             /* positions are relative to it [m] */
  double radius;                /* half a spacing [m] */
  const float* position;        /* 3 per particle [m] */
  const float* velocity;        /* 3 per particle [m/s] */
  const float* temperature;     /* [degrees Celsius] */
  const float* liquid_fraction; /* 0 solid to 1 liquid */
  const float* density;         /* [kg/m^3] */
  const float* pressure;        /* [Pa] */
  const uint32_t* tag;          /* as meltsim_particles */
  const uint32_t* piece;        /* label of the piece, 0 for liquid */
  const uint32_t* color; /* red in the lowest byte, then green, blue, opacity; null: none were asked for */
  uint64_t serial;       /* for meltsim_world_check_view() */
} meltsim_render_view;
/* Packs the particles as the steps so far leave them. On CUDA nothing waits: use the arrays on `stream`. They stay until the next
 * call. `desc` may be null: no colours. */
MELTSIM_C_API meltsim_status meltsim_world_render_view(meltsim_world* world, const meltsim_render_desc* desc,
                                                       meltsim_render_view* view);

/* A surface mesh in the memory of the backend. The caller sets `size`. */
typedef struct meltsim_surface_view {
  uint32_t size;                /* sizeof(meltsim_surface_view) */
  int32_t backend;              /* MELTSIM_BACKEND_CUDA: the pointers are into the device's memory */
  void* stream;                 /* cudaStream_t; null on the CPU */
  double origin[3];             /* add it to positions [m] */
  uint64_t vertices;            /* number of vertices; with `no_wait`: how many there is room for */
  uint64_t triangles;           /* number of triangles, likewise */
  const float* position;        /* 3 per vertex [m] */
  const float* normal;          /* 3 per vertex: a unit vector, outward */
  const float* temperature;     /* per vertex [degrees Celsius] */
  const float* liquid_fraction; /* per vertex, 0 to 1 */
  const uint32_t* body;         /* per vertex: 0 liquid, else index + 1 */
  const uint32_t* material;     /* per vertex: index */
  const uint32_t* triangle;     /* 3 vertices per triangle, counter-clockwise from outside */
  const uint32_t* draw;         /* 5 words: the arguments of an indexed indirect draw of it */
  uint64_t serial;              /* for meltsim_world_check_surface_view() */
} meltsim_surface_view;
/* Makes a surface there; waits for its size unless desc->no_wait. The arrays stay until the next surface. */
MELTSIM_C_API meltsim_status meltsim_world_surface_view(meltsim_world* world,
                                                        const meltsim_surface_desc* desc,
                                                        meltsim_surface_view* view);

/* Time as the device has it: of the sub-step that runs, also in one that was recorded. */
typedef struct meltsim_stage_clock {
  double time; /* at its start [s] */
  double dt;   /* its length [s] */
} meltsim_stage_clock;
/* The World's own arrays in the backend's memory, one entry per particle in the order of slots. T is float or double. */
typedef struct meltsim_stage_context {
  uint32_t size;                    /* sizeof(meltsim_stage_context) */
  int32_t backend;                  /* MELTSIM_BACKEND_CUDA: the pointers are into the device's memory */
  int32_t double_precision;         /* not 0: T is double */
  int32_t reserved;                 /* 0 */
  void* stream;                     /* cudaStream_t; null on the CPU: work there and do not wait */
  double dt;                        /* of a stage: length of the sub-step [s]; else 0 */
  double time;                      /* at its start [s] */
  double origin[3];                 /* positions are relative to it [m] */
  uint64_t particles;               /* number of entries */
  void* position;                   /* T: x, y, z [m], rest volume [m^3] */
  void* velocity;                   /* T: 3 numbers [m/s], and one that belongs to the library */
  void* acceleration;               /* T: 3 numbers [m/s^2], to be added to; null outside of stages */
  const double* enthalpy;           /* [J]; null where heat is at rest and no stage names it */
  const double* enthalpy_of_id;     /* [J] by id where `enthalpy` is null; else null */
  const uint32_t* id;               /* stable */
  const uint32_t* tag;              /* as meltsim_particles */
  const meltsim_stage_clock* clock; /* in the backend's memory; null outside of stages */
  uint64_t serial;                  /* for meltsim_world_check_device_state() */
} meltsim_stage_context;
/* The state as it is, without a copy. Arrays are not to be written; they stay until the next step. The caller sets `size`. */
MELTSIM_C_API meltsim_status meltsim_world_device_state(meltsim_world* world, meltsim_stage_context* state);

/* A stage of the host, called in every sub-step with arrays that hold until it returns. It must not call the World. */
typedef void (*meltsim_stage_function)(const meltsim_stage_context* context, void* user);
typedef struct meltsim_stage_desc {
  uint32_t size;              /* sizeof(meltsim_stage_desc) */
  int32_t recorded;           /* not 0: CUDA records what it enqueues: CustomStage::recorded */
  const char* name;           /* unique; copied */
  const char* after;          /* the built-in stage before it; null: "sph.forces" */
  meltsim_stage_function run; /* enqueues the work of the stage */
  void* user;                 /* passed to `run`; it outlives the stage */
  const char* const* reads;   /* channels that it reads, by their names in fields.def */
  uint64_t read_count;        /* how many */
  const char* const* writes;  /* channels that it writes */
  uint64_t write_count;       /* how many */
} meltsim_stage_desc;
MELTSIM_C_API void meltsim_stage_desc_init_sized(meltsim_stage_desc* to, size_t size);
static inline void meltsim_stage_desc_init(meltsim_stage_desc* to) {
  meltsim_stage_desc_init_sized(to, sizeof *to);
} /* size and defaults */
MELTSIM_C_API meltsim_status meltsim_world_add_stage(meltsim_world* world, const meltsim_stage_desc* desc);
MELTSIM_C_API meltsim_status meltsim_world_remove_stage(meltsim_world* world, const char* name);
/* Runs the stages of a module only in every n-th sub-step, n >= 1: "thermal" (`heat_interval`, at most 1000) and "topology" only. */
MELTSIM_C_API meltsim_status meltsim_world_set_interval(meltsim_world* world, const char* module, int32_t n);
/* In *n: a built-in stage, such as "thermal.exchange" or "topology.melt", runs every so many sub-steps; 1 while it rests. */
MELTSIM_C_API meltsim_status meltsim_world_interval(meltsim_world* world, const char* stage, int32_t* n);
/* Switches a module off (on: 0), or on again: "sph", "lsm", "thermal", "species", "topology". */
MELTSIM_C_API meltsim_status meltsim_world_enable(meltsim_world* world, const char* module, int32_t on);

/* Order between the World's stream and other streams of the host, on the device; neither waits. `event` is a cudaEvent_t. What the
 * World enqueues from now on waits for it; it is recorded behind what the World has enqueued. MELTSIM_INVALID_ARGUMENT: no event, one of
 * another device, a World on the CPU. */
MELTSIM_C_API meltsim_status meltsim_world_wait_for(meltsim_world* world, void* event);
MELTSIM_C_API meltsim_status meltsim_world_signal(meltsim_world* world, void* event);

/* Whether the arrays of a view are still what they were: MELTSIM_INVALID_ARGUMENT, and why, where another call has taken their memory.
 * Does not wait; for the asserts of a debug build. */
MELTSIM_C_API meltsim_status meltsim_world_check_view(meltsim_world* world, const meltsim_render_view* view);
MELTSIM_C_API meltsim_status meltsim_world_check_surface_view(meltsim_world* world,
                                                              const meltsim_surface_view* view);
MELTSIM_C_API meltsim_status meltsim_world_check_device_state(meltsim_world* world,
                                                              const meltsim_stage_context* state);

/* Copies the state to `buffer`, for meltsim_world_restore(). *bytes is set to the size of the state; where `capacity` is less,
 * nothing is copied and MELTSIM_CAPACITY is returned. `buffer` may be null if `capacity` is 0. Waits for all steps. */
MELTSIM_C_API meltsim_status meltsim_world_snapshot(meltsim_world* world, void* buffer, size_t capacity,
                                                    size_t* bytes);
/* Goes back to a snapshot of a World with the same materials and bodies. */
MELTSIM_C_API meltsim_status meltsim_world_restore(meltsim_world* world, const void* data, size_t bytes);
/* A saved game: the state and the bodies that it is of, for meltsim_world_load_saved(); as meltsim_world_snapshot(). */
MELTSIM_C_API meltsim_status meltsim_world_save(meltsim_world* world, void* buffer, size_t capacity,
                                                size_t* bytes);
/* Makes state and bodies of this World those of a saved World with the same materials and emitters, whatever bodies there are here.
 * Ids of bodies from before are refused from then on; meltsim_world_bodies() has the new ones. */
MELTSIM_C_API meltsim_status meltsim_world_load_saved(meltsim_world* world, const void* data, size_t bytes);
/* A body of a World, as it was described. */
typedef struct meltsim_body_info {
  meltsim_id body;     /* its id */
  meltsim_id material; /* what it was built of */
  int32_t motion;      /* MELTSIM_MOTION_... */
  int32_t held;        /* 1: by meltsim_world_hold() or held_until, now */
  const char* name;    /* holds until the next call of meltsim_world_bodies() or meltsim_world_destroy() */
} meltsim_body_info;
/* The bodies that are there, without removed ones; as meltsim_reading_events(). */
MELTSIM_C_API meltsim_status meltsim_world_bodies(meltsim_world* world, meltsim_body_info* bodies,
                                                  size_t struct_size, size_t capacity, size_t* count);
/* Saves the state in the backend's memory under a number from 0 to 15, and goes back to it, without waiting; lost when something is added, removed
 * or restored, or stages begin or end. */
MELTSIM_C_API meltsim_status meltsim_world_save_state(meltsim_world* world, int32_t slot);
MELTSIM_C_API meltsim_status meltsim_world_load_state(meltsim_world* world, int32_t slot);
/* Equal states give equal hashes on every backend. */
MELTSIM_C_API meltsim_status meltsim_world_state_hash(meltsim_world* world, uint64_t* hash);

#ifdef __cplusplus
}
#endif

#endif
