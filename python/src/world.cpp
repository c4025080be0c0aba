// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <regex>

#include "build_world.hpp"
#include "csv.hpp"
#include "describe.hpp"
#include "failure.hpp"
#include "host_world.hpp"
#include "resolution.hpp"
#include "scene_options.hpp"

namespace meltsim_python {

using namespace meltsim;

namespace {

// ---- Tables of arguments ---------------------------------------------------------------------------------

const char* const vector_type = "Sequence[float]";
const std::vector<std::string> backends{"automatic", "cpu", "cuda"}, precisions{"single", "double"};
const std::vector<std::string> face_names{"-x", "+x", "-y", "+y", "-z", "+z"};
const std::vector<std::string> event_names{"melted",        "frozen", "split", "contact_begun",
                                           "contact_ended", "gone",   "left"};

/// Pairs of (time, value), or nothing where it is a number.
std::optional<std::vector<TimedValue>> timed(const std::string& name, nb::handle v) {
  const nb::object rows = items_of(v);
  if (!rows) return std::nullopt;
  const std::string fault = name + ": expected a number or pairs of (time, value), got ";
  std::vector<TimedValue> read;
  for (Py_ssize_t i = 0; i < PySequence_Fast_GET_SIZE(rows.ptr()); ++i) {
    const nb::object row = items_of(PySequence_Fast_GET_ITEM(rows.ptr(), i));
    if (!row || PySequence_Fast_GET_SIZE(row.ptr()) != 2) wrong_type(fault + shown(v));
    read.push_back({number(name, PySequence_Fast_GET_ITEM(row.ptr(), 0)),
                    number(name, PySequence_Fast_GET_ITEM(row.ptr(), 1))});
  }
  if (read.empty()) refuse(fault + "a list without any: " + shown(v));
  return read;
}

const Keys<SurfaceHeatDesc>& surface_heat_keys() {
  using D = SurfaceHeatDesc;
  static const Keys<SurfaceHeatDesc> keys{
      {"temperature", "float | Sequence[tuple[float, float]] | None",
       "holds the surface at this [degrees Celsius], or at (time, value) pairs; alone",
       [](D& d, const std::string& name, nb::handle v) {
         if (v.is_none()) return d.temperature.reset();
         if (auto points = timed(name, v)) {
           d.temperature = points->front().value;
           d.temperature_points = std::move(*points);
         } else d.temperature = number(name, v);
       }},
      {"flux", "float | Sequence[tuple[float, float]]", "into the material [W/m^2], or (time, value) pairs",
       [](D& d, const std::string& name, nb::handle v) {
         if (auto points = timed(name, v)) d.flux_points = std::move(*points);
         else d.flux = number(name, v);
       }},
      {"convection", "float", "heat transfer coefficient towards `ambient` [W/(m^2 K)]",
       set_to(&SurfaceHeatDesc::convection)},
      {"emissivity", "float", "of radiation towards surroundings at `ambient`, 0 to 1",
       set_to(&SurfaceHeatDesc::emissivity)},
      {"ambient", "float | Sequence[tuple[float, float]]",
       "temperature of the surroundings [degrees Celsius], or (time, value) pairs",
       [](D& d, const std::string& name, nb::handle v) {
         if (auto points = timed(name, v)) {
           d.ambient = points->front().value;
           d.temperature_points = std::move(*points);
         } else d.ambient = number(name, v);
       }}};
  return keys;
}

/// Calls f(face, name, value) for what "+x", "x" or "all" names.
void each_face(const std::string& name, nb::handle value,
               const std::function<void(std::size_t, const std::string&, nb::handle)>& f) {
  static const std::vector<std::string> names{"-x", "+x", "-y", "+y", "-z", "+z"};
  if (!nb::isinstance<nb::dict>(value))
    wrong_type(name + ": expected a dict of faces, such as {\"-y\": ...}, got " + shown(value));
  for (auto [k, v] : nb::cast<nb::dict>(value)) {
    const std::string key = text(name + ": a face", k);
    bool known = false;
    for (std::size_t i = 0; i < 6; ++i)
      if (key == names[i] || key == names[i].substr(1) || key == "all")
        known = true, f(i, name + "[\"" + key + "\"]", v);
    if (!known)
      refuse(name + ": expected a face, -x, +x, -y, +y, -z, +z, or x, y, z or all, got \"" + key + "\"");
  }
}

const Keys<DomainDesc>& domain_keys() {
  static const std::vector<std::string> faces{"wall", "open", "periodic"};
  static const Keys<DomainDesc> keys{
      {"min", vector_type, "lower corner [m]", set_to(&DomainDesc::min)},
      {"max", vector_type, "upper corner [m]", set_to(&DomainDesc::max)},
      {"faces", "str | dict[str, str]",
       "\"wall\", \"open\" or \"periodic\", of all faces or per face: {\"+y\": \"open\", \"x\": "
       "\"periodic\"}",
       [](DomainDesc& d, const std::string& name, nb::handle v) {
         if (PyUnicode_Check(v.ptr())) return d.faces.fill(static_cast<Face>(choice(name, v, faces)));
         each_face(name, v, [&](std::size_t i, const std::string& at, nb::handle face) {
           d.faces[i] = static_cast<Face>(choice(at, face, faces));
         });
       }},
      {"no_slip", "bool", "liquid sticks to walls", set_to(&DomainDesc::no_slip)},
      {"friction", "float", "Coulomb coefficient of walls", set_to(&DomainDesc::friction)},
      {"contact_angle", "float", "of liquids with surface tension at walls [degrees]",
       set_to(&DomainDesc::contact_angle)},
      {"velocity", "dict[str, Sequence[float]]", "of walls [m/s], per face",
       [](DomainDesc& d, const std::string& name, nb::handle v) {
         each_face(name, v, [&](std::size_t i, const std::string& at, nb::handle u) {
           d.velocity[i] = vector(at, u);
         });
       }},
      {"outlets", "dict[str, dict[str, float]]",
       "what is beyond open faces: {\"+x\": {\"level\": 0.2}} [m] or {\"speed\": 0.5} [m/s]",
       [](DomainDesc& d, const std::string& name, nb::handle v) {
         static const Keys<OutletDesc> outlet_keys{
             {"level", "float", "height of the liquid beyond, against gravity [m]",
              set_to(&OutletDesc::level)},
             {"speed", "float", "at which liquid leaves [m/s]", set_to(&OutletDesc::speed)}};
         each_face(name, v, [&](std::size_t i, const std::string& at, nb::handle o) {
           describe(d.outlets[i], outlet_keys, at, o);
         });
       }},
      {"heat", "dict[str, dict[str, float]]",
       "heat through walls, per face: {\"-y\": {\"temperature\": 80}}; keys as of add_solid's surface",
       [](DomainDesc& d, const std::string& name, nb::handle v) {
         each_face(name, v, [&](std::size_t i, const std::string& at, nb::handle h) {
           describe(d.heat[i], surface_heat_keys(), at, h);
         });
       }}};
  return keys;
}

/// A value of Python as a scene would give it.
YAML::Node yaml_of(nb::handle v) {
  if (is_boolean(v)) return YAML::Load(boolean("a value", v) ? "true" : "false");
  if (nb::hasattr(v, "tolist")) return yaml_of(v.attr("tolist")());  // arrays and numbers of NumPy
  if (PyUnicode_Check(v.ptr())) return YAML::Node(text("a value", v));
  return YAML::Load(
      nb::cast<std::string>(nb::str(nb::isinstance<nb::tuple>(v) ? nb::handle(nb::list(v)) : v)));
}

/// Adds the options of solver: of scene files (runner/scene_options.cpp) that the table has no row for.
Keys<WorldDesc> with_solver_options(Keys<WorldDesc> keys) {
  for (const runner::Option<runner::Scene>& option : runner::solver_options()) {
    const bool there = std::any_of(keys.begin(), keys.end(),
                                   [&](const Key<WorldDesc>& key) { return key.name == option.key; });
    // What a scene does ahead of its first step is a call here: nothing is there yet that could settle.
    if (there || option.key == "settle") continue;
    keys.push_back({option.key.c_str(), "Any", option.doc.c_str(),
                    [&option](WorldDesc& d, const std::string& name, nb::handle v) {
                      runner::Scene scene;
                      scene.world = d;
                      try {
                        option.load(runner::Node(yaml_of(v), std::make_shared<runner::Document>()), scene);
                      } catch (const runner::Failure& failure) {
                        const std::string said = failure.what();
                        const std::size_t at = said.find("expected");
                        refuse(name + ": " + (at == std::string::npos ? said : said.substr(at)));
                      }
                      d = scene.world;
                    }});
  }
  return keys;
}

const Keys<WorldDesc>& world_keys() {
  const auto heat = [](auto member) {
    return
        [set = set_to(member)](WorldDesc& d, const std::string& name, nb::handle v) { set(d.heat, name, v); };
  };
  static const Keys<WorldDesc> keys = with_solver_options(
      {{"spacing", "float", "distance of particles [m]; halving it makes 8 times as many",
        set_to(&WorldDesc::spacing)},
       {"domain", "dict[str, Any] | tuple[Sequence[float], Sequence[float]] | None",
        "where particles may be: (min, max), a box of walls [m], or a dict with min, max, faces, no_slip, "
        "friction, contact_angle, velocity, heat; None: unbounded",
        [](WorldDesc& d, const std::string& name, nb::handle v) {
          d.domain = {};
          if (v.is_none()) return;
          d.domain.bounded = true;
          if (nb::isinstance<nb::dict>(v)) return describe(d.domain, domain_keys(), name, v);
          const nb::object pair = items_of(v);
          if (!pair || PySequence_Fast_GET_SIZE(pair.ptr()) != 2)
            wrong_type(name + ": expected (min, max), a dict or None, got " + shown(v));
          d.domain.min = vector(name + ": min", PySequence_Fast_GET_ITEM(pair.ptr(), 0));
          d.domain.max = vector(name + ": max", PySequence_Fast_GET_ITEM(pair.ptr(), 1));
        }},
       {"gravity", vector_type, "[m/s^2]", set_to(&WorldDesc::gravity)},
       {"heat_model", "str", "\"none\", \"paper\", \"iwasaki\" or \"enthalpy\"",
        [](WorldDesc& d, const std::string& name, nb::handle v) {
          d.heat.model = static_cast<HeatModel>(choice(name, v, {"none", "paper", "iwasaki", "enthalpy"}));
        }},
       {"heat_time_scale", "float", "heat runs so many times faster than motion (time lapse)",
        heat(&HeatDesc::time_scale)},
       {"heat_interval", "int", "most sub-steps that share a step of heat, within a step; 0: chosen",
        heat(&HeatDesc::interval)},
       {"heat_max_stages", "int", "stages per super-step of heat", heat(&HeatDesc::max_stages)},
       {"heat_max_supersteps", "int", "super-steps of heat in a sub-step; a step that needs more is refused",
        heat(&HeatDesc::max_supersteps)},
       {"heat_level_tolerance", "float", "temperatures that differ by no more count as level [K]",
        heat(&HeatDesc::level_tolerance)},
       {"heat_free_surface", "dict[str, float]",
        "heat through the liquid's free surface; keys as of add_solid's surface",
        [](WorldDesc& d, const std::string& name, nb::handle v) {
          describe(d.heat.free_surface, surface_heat_keys(), name, v);
        }},
       {"solute_time_scale", "float", "species diffuse and dissolve so many times faster than motion",
        [](WorldDesc& d, const std::string& name, nb::handle v) { d.solute.time_scale = number(name, v); }},
       {"solute_max_supersteps", "int",
        "most sweeps per species in a sub-step; a step that needs more is refused",
        [](WorldDesc& d, const std::string& name, nb::handle v) {
          d.solute.max_supersteps = static_cast<int>(std::clamp<long long>(integer(name, v), 0, 1 << 30));
        }},
       {"support_radius", "float", "H [m]; 0: 2.5 spacings", set_to(&WorldDesc::support_radius)},
       {"sound_speed", "float", "c [m/s]; 0: derived from the depth", set_to(&WorldDesc::sound_speed)},
       {"artificial_viscosity", "float", "damps acoustic noise; 0.01 to 0.1",
        set_to(&WorldDesc::artificial_viscosity)},
       {"tension", "bool", "allows pressures below 0", set_to(&WorldDesc::tension)},
       {"isotropic_pressure", "bool | None",
        "slow flow is not held up by the level of pressure; costs a sweep; None: where it is needed",
        set_to(&WorldDesc::isotropic_pressure)},
       {"particle_shifting", "bool", "keeps liquid evenly spread; needs tension",
        set_to(&WorldDesc::particle_shifting)},
       {"viscosity", "str", "how viscosity enters a sub-step: \"automatic\", \"explicit\" or \"implicit\"",
        set_to(&WorldDesc::viscosity, {"automatic", "explicit", "implicit"})},
       {"neighbour_search", "str", "how neighbours are found: \"automatic\", \"grid\" or \"tree\"",
        set_to(&WorldDesc::neighbour_search, {"automatic", "grid", "verlet", "tree"})},
       {"follow_sound_speed", "bool", "the derived sound speed follows what moves",
        set_to(&WorldDesc::follow_sound_speed)},
       {"hydrostatic_start", "bool", "liquid that stands on something starts with the pressure of rest",
        set_to(&WorldDesc::hydrostatic_start)},
       {"courant", "float", "sub-steps keep c dt / H at or below this", set_to(&WorldDesc::courant)},
       {"stray", "str", "\"remove\" or \"halt\": what happens to liquid that falls out of the scene",
        set_to(&WorldDesc::stray, {"remove", "halt"})},
       {"max_substeps", "int", "a step that needs more is refused", set_to(&WorldDesc::max_substeps)},
       {"reserved_particles", "int", "room for liquid and bodies that are added while it runs",
        set_to(&WorldDesc::reserved_particles)},
       {"density_error", "float", "compression at rest that the derived sound speed allows; 0: 0.005",
        set_to(&WorldDesc::density_error)},
       {"pieces_interval", "int", "sub-steps between searches for pieces that came apart",
        set_to(&WorldDesc::pieces_interval)},
       {"backend", "str", "\"automatic\", \"cpu\" or \"cuda\"", set_to(&WorldDesc::backend, backends)},
       {"precision", "str", "\"single\" or \"double\"", set_to(&WorldDesc::precision, precisions)},
       {"device", "int", "CUDA device", set_to(&WorldDesc::device)},
       {"stream", "int",
        "a cudaStream_t of the host, such as cupy.cuda.Stream.ptr; 0: the World makes its own",
        [](WorldDesc& d, const std::string& name, nb::handle v) {
          d.stream = reinterpret_cast<void*>(static_cast<std::intptr_t>(integer(name, v)));
        }},
       {"threads", "int", "CPU threads; 0: one per processor", set_to(&WorldDesc::threads)}});
  return keys;
}

struct MaterialInput {
  MaterialDesc desc;
  std::optional<std::array<double, 3>> color;
  nb::object becomes, dissolves_in;
};
struct FluidInput {
  FluidDesc desc;
  nb::object material, fractions;
};
struct SolidInput {
  SolidDesc desc;
  nb::object material;
};
struct EmitterInput {
  EmitterDesc desc;
  nb::object material, fractions;
};
struct ProbeInput {
  ProbeDesc desc;
  nb::object body;
};

/// A setter of the description within what a call was given.
template <class I, class D, class M>
auto of(D I::*desc, M member) {
  return [desc, set = set_to(member)](I& input, const std::string& name, nb::handle v) {
    set(input.*desc, name, v);
  };
}
template <class I>
auto kept(nb::object I::*member) {
  return [member](I& input, const std::string&, nb::handle v) { input.*member = nb::borrow(v); };
}

/// A number, or pairs of (temperature, value).
auto property(double MaterialDesc::*constant, std::vector<PropertyPoint> MaterialDesc::*table) {
  return [constant, table](MaterialInput& input, const std::string& name, nb::handle v) {
    const std::string fault = name + ": expected a number or pairs of (temperature, value), got ";
    const nb::object rows = items_of(v);
    if (!rows) {
      input.desc.*constant = number(name, v);
      return (input.desc.*table).clear();
    }
    std::vector<PropertyPoint> read;
    for (Py_ssize_t i = 0; i < PySequence_Fast_GET_SIZE(rows.ptr()); ++i) {
      const nb::object row = items_of(PySequence_Fast_GET_ITEM(rows.ptr(), i));
      if (!row || PySequence_Fast_GET_SIZE(row.ptr()) != 2) wrong_type(fault + shown(v));
      read.push_back({number(name, PySequence_Fast_GET_ITEM(row.ptr(), 0)),
                      number(name, PySequence_Fast_GET_ITEM(row.ptr(), 1))});
    }
    if (read.empty()) refuse(fault + "a table without any: " + shown(v));
    input.desc.*constant = read.front().value;
    input.desc.*table = std::move(read);
  };
}

/// Rows of numbers, the least and the most that one may have.
std::vector<std::array<double, 5>> rows_of(const std::string& name, nb::handle v, const char* expected,
                                           Py_ssize_t least, Py_ssize_t most) {
  const std::string fault = name + ": expected rows of " + expected + ", got ";
  const nb::object rows = items_of(v);
  if (!rows) wrong_type(fault + shown(v));
  std::vector<std::array<double, 5>> read;
  for (Py_ssize_t i = 0; i < PySequence_Fast_GET_SIZE(rows.ptr()); ++i) {
    const nb::object row = items_of(PySequence_Fast_GET_ITEM(rows.ptr(), i));
    const Py_ssize_t size = row ? PySequence_Fast_GET_SIZE(row.ptr()) : 0;
    if (size < least || size > most) wrong_type(fault + shown(v));
    std::array<double, 5> x{};
    for (Py_ssize_t k = 0; k < size; ++k)
      x[static_cast<std::size_t>(k)] =
          number(name + "[" + std::to_string(i) + "]", PySequence_Fast_GET_ITEM(row.ptr(), k));
    read.push_back(x);
  }
  return read;
}

const Keys<MaterialInput>& material_keys() {
  using D = MaterialDesc;
  const auto d = [](auto member) { return of(&MaterialInput::desc, member); };
  static const Keys<MaterialInput> keys{
      {"name", "str", "for messages and tables, and to refer to it", d(&D::name)},
      {"density", "float | Sequence[tuple[float, float]]",
       "[kg/m^3], or (temperature, value) pairs: buoyancy", property(&D::density, &D::density_points)},
      {"viscosity", "float | Sequence[tuple[float, float]]", "dynamic [Pa s], or (temperature, value) pairs",
       property(&D::viscosity, &D::viscosity_points)},
      {"conductivity", "float | Sequence[tuple[float, float]]", "[W/(m K)], or (temperature, value) pairs",
       property(&D::conductivity, &D::conductivity_points)},
      {"heat_capacity", "float | Sequence[tuple[float, float]]", "[J/(kg K)], or (temperature, value) pairs",
       property(&D::heat_capacity, &D::heat_capacity_points)},
      {"diffusivity", "float | None", "[m^2/s]; replaces the conductivity", d(&D::diffusivity)},
      {"melting_point", "float", "[degrees Celsius]; inf: never melts", d(&D::melting_point)},
      {"melting_range", "float", "[K] from where melting begins, the melting point, to where it ends",
       d(&D::melting_range)},
      {"latent_heat", "float", "[J/kg]", d(&D::latent_heat)},
      {"becomes", "Material | str | None", "the liquid that it melts into", kept(&MaterialInput::becomes)},
      {"freezes", "bool", "whether its liquid freezes onto it", d(&D::freezes)},
      {"dissolves_in", "Material | str | None", "the liquid that it dissolves in or mixes with",
       kept(&MaterialInput::dissolves_in)},
      {"solubility", "float | Sequence[tuple[float, float]]",
       "mass fraction of the saturated solution, 1: mixes in any ratio; or (temperature, value) pairs: "
       "precipitation",
       property(&D::solubility, &D::solubility_points)},
      {"diffusivity_in", "float", "in that liquid [m^2/s]", d(&D::diffusivity_in)},
      {"heat_of_solution", "float", "that dissolving takes up [J/kg]", d(&D::heat_of_solution)},
      {"transfer_coefficient", "float | None",
       "of a layer at a dissolving body that is thinner than the spacing [m/s]", d(&D::transfer_coefficient)},
      {"region_half_width", "int", "of shape matching, 0 to 8 spacings; larger is stiffer",
       d(&D::region_half_width)},
      {"stiffness", "float", "of shape matching, 0 to 1", d(&D::stiffness)},
      {"youngs_modulus", "float", "[Pa]; 0: `stiffness` holds", d(&D::youngs_modulus)},
      {"damping", "float", "share of non-rigid motion removed, 0 to 1", d(&D::damping)},
      {"friction", "float", "Coulomb coefficient", d(&D::friction)},
      {"surface_tension", "float", "of a liquid [N/m]", d(&D::surface_tension)},
      {"yield_stress", "float | Sequence[tuple[float, float]]",
       "of a liquid [Pa], or (temperature, value) pairs",
       property(&D::yield_stress, &D::yield_stress_points)},
      {"flow_index", "float",
       "of a liquid; below 1 it thins as it is sheared, above 1 it thickens; viscosity is then K [Pa s^n], "
       "what it is at 1/s",
       d(&D::flow_index)},
      {"regularisation", "float", "time beyond which what does not yield creeps [s]", d(&D::regularisation)},
      {"contact_angle", "float", "of a solid [degrees]", d(&D::contact_angle)},
      {"color", "Sequence[float] | None", "red, green, blue in show(), 0 to 1",
       [](MaterialInput& input, const std::string& name, nb::handle v) {
         if (v.is_none()) return input.color.reset();
         const Vec3d c = vector(name, v);
         for (const double x : {c.x, c.y, c.z})
           if (!(x >= 0 && x <= 1))
             refuse(name + ": expected red, green and blue from 0 to 1, got " + shown(v));
         input.color = {c.x, c.y, c.z};
       }}};
  return keys;
}

const Keys<FluidInput>& fluid_keys() {
  static const Keys<FluidInput> keys{
      {"shape", "Shape", "the volume [m]", of(&FluidInput::desc, &FluidDesc::shape)},
      {"material", "Material | str", "of the liquid", kept(&FluidInput::material)},
      {"temperature", "float", "[degrees Celsius]", of(&FluidInput::desc, &FluidDesc::temperature)},
      {"velocity", vector_type, "[m/s]", of(&FluidInput::desc, &FluidDesc::velocity)},
      {"fractions", "dict[Material | str, float] | None",
       "what is dissolved in it: mass fractions of species", kept(&FluidInput::fractions)}};
  return keys;
}

const Keys<SolidInput>& solid_keys() {
  using D = SolidDesc;
  const auto d = [](auto member) { return of(&SolidInput::desc, member); };
  static const Keys<SolidInput> keys{
      {"shape", "Shape", "the volume [m]", d(&D::shape)},
      {"material", "Material | str", "of the body", kept(&SolidInput::material)},
      {"name", "str", "empty: body<N>", d(&D::name)},
      {"temperature", "float", "[degrees Celsius]", d(&D::temperature)},
      {"velocity", vector_type, "of the centre of mass [m/s]", d(&D::velocity)},
      {"angular_velocity", vector_type, "about the centre of mass [rad/s]", d(&D::angular_velocity)},
      {"fixed", "bool", "an obstacle: conducts heat and melts, but never moves", d(&D::fixed)},
      {"motion", "str",
       "\"free\", \"fixed\", \"kinematic\": moved by set_motion(), \"rigid\": free, but nothing deforms "
       "it, or \"proxy\": a rigid body of your physics engine, see set_proxy()",
       [](SolidInput& input, const std::string& name, nb::handle v) {
         input.desc.motion =
             static_cast<Motion>(choice(name, v, {"free", "fixed", "kinematic", "rigid", "proxy"}));
       }},
      {"pivot", "Sequence[float] | None",
       "of a kinematic body or proxy: the point that positions are of [m]; None: its centre",
       [](SolidInput& input, const std::string& name, nb::handle v) {
         input.desc.pivot = v.is_none() ? std::nullopt : std::optional<Vec3d>(vector(name, v));
       }},
      {"max_speed", "float", "the largest speed that any point of a body that moves will have [m/s]",
       d(&D::max_speed)},
      {"path", "Sequence[Sequence[float]]",
       "of a kinematic body, in place of velocities: (time [s], x, y, z [m] from where it is built, and, "
       "where it turns, angle [rad]) per "
       "point",
       [](SolidInput& input, const std::string& name, nb::handle v) {
         input.desc.path.clear();
         for (const auto& x : rows_of(name, v, "(time, x, y, z) or (time, x, y, z, angle)", 4, 5))
           input.desc.path.push_back({x[0], {x[1], x[2], x[3]}, x[4]});
       }},
      {"path_axis", vector_type, "through its pivot, that angles of the path turn about", d(&D::path_axis)},
      {"mass", "float", "of a proxy, above 0 [kg]", d(&D::mass)},
      {"inertia", "Sequence[Sequence[float]] | Sequence[float] | None",
       "of a proxy, about its pivot as built, 3 x 3, or three numbers along the axes [kg m^2]; None: of its "
       "mass spread over the shape",
       [](SolidInput& input, const std::string& name, nb::handle v) {
         input.desc.inertia = {};
         if (v.is_none()) return;
         const nb::object rows = items_of(v);
         if (!rows || PySequence_Fast_GET_SIZE(rows.ptr()) != 3)
           wrong_type(name + ": expected three rows of three numbers, or three numbers, got " + shown(v));
         nb::handle first = PySequence_Fast_GET_ITEM(rows.ptr(), 0);
         const bool axes = PyNumber_Check(first.ptr()) != 0 && !items_of(first);
         const Vec3d along = axes ? vector(name, v) : Vec3d{};
         for (int k = 0; k < 3; ++k) {
           const Vec3d row = axes ? Vec3d{k == 0 ? along.x : 0, k == 1 ? along.y : 0, k == 2 ? along.z : 0}
                                  : vector(name, PySequence_Fast_GET_ITEM(rows.ptr(), k));
           input.desc.inertia.m[k][0] = row.x;
           input.desc.inertia.m[k][1] = row.y;
           input.desc.inertia.m[k][2] = row.z;
         }
       }},
      {"surface", "dict[str, float]",
       "heat through the dry surface: temperature, flux, convection, emissivity, ambient",
       [](SolidInput& input, const std::string& name, nb::handle v) {
         describe(input.desc.surface, surface_heat_keys(), name, v);
       }},
      {"heat_source", "float", "heat released in the body [W/m^3]", d(&D::heat_source)},
      {"carve", "bool", "remove liquid in the body's place; False: refuse the overlap", d(&D::carve)},
      {"held_until", "float",
       "a free or rigid body stays where it is until then [s]; inf: until hold(body, False)",
       d(&D::held_until)},
      {"growth", "int", "how far liquid may freeze onto the body [spacings]", d(&D::growth)}};
  return keys;
}

const Keys<EmitterInput>& emitter_keys() {
  using D = EmitterDesc;
  const auto d = [](auto member) { return of(&EmitterInput::desc, member); };
  static const Keys<EmitterInput> keys{
      {"center", vector_type, "end of the pipe [m]", d(&D::center)},
      {"material", "Material | str", "of the liquid", kept(&EmitterInput::material)},
      {"name", "str", "empty: emitter<N>", d(&D::name)},
      {"axis", vector_type, "direction of the stream", d(&D::axis)},
      {"radius", "float", "of a round opening [m], at least one spacing", d(&D::radius)},
      {"width", "float", "of a rectangular opening, across [m]", d(&D::width)},
      {"height", "float", "of a rectangular opening, along up [m]", d(&D::height)},
      {"up", vector_type, "which way the height lies", d(&D::up)},
      {"speed", "float", "[m/s]", d(&D::speed)},
      {"temperature", "float", "[degrees Celsius]", d(&D::temperature)},
      {"start", "float", "begins to emit [s]", d(&D::from)},
      {"until", "float", "ceases to emit [s]", d(&D::until)},
      {"max_particles", "int", "most particles that it emits; 0: what start to until needs",
       d(&D::max_particles)},
      {"recycle", "bool",
       "what has left comes again, so that it goes on for ever: max_particles is then how many there are at "
       "a time; 0: as many as fill "
       "the domain",
       d(&D::recycle)},
      {"fractions", "dict[Material | str, float] | None",
       "what is dissolved in it: mass fractions of species", kept(&EmitterInput::fractions)},
      {"level", "float | None",
       "instead of a nozzle: liquid up to this height [m] beyond the open face that axis points inwards from",
       d(&D::level)}};
  return keys;
}

const Keys<HeatRegionDesc>& region_keys() {
  using D = HeatRegionDesc;
  static const Keys<D> keys{{"shape", "Shape", "the volume [m]", set_to(&D::shape)},
                            {"name", "str", "empty: heat<N>", set_to(&D::name)},
                            {"temperature", "float | None",
                             "holds particles inside at this [degrees Celsius]", set_to(&D::temperature)},
                            {"source", "float", "heat released [W/m^3]", set_to(&D::source)},
                            {"start", "float", "begins to act [s]", set_to(&D::from)},
                            {"until", "float", "ceases to act [s]", set_to(&D::until)},
                            {"path", "Sequence[Sequence[float]]",
                             "where it is: (time [s], x, y, z [m] from where it was built) per point",
                             [](D& d, const std::string& name, nb::handle v) {
                               d.path.clear();
                               for (const auto& x : rows_of(name, v, "(time, x, y, z)", 4, 4))
                                 d.path.push_back({x[0], {x[1], x[2], x[3]}});
                             }}};
  return keys;
}

const Keys<ForceFieldDesc>& field_keys() {
  using D = ForceFieldDesc;
  static const Keys<D> keys{
      {"kind", "str", "\"uniform\", \"radial\", \"vortex\", \"drag\" or \"hydrostatic\"",
       set_to(&D::kind, {"uniform", "radial", "vortex", "drag", "hydrostatic"})},
      {"shape", "Shape | None", "a box, a sphere or a cylinder, also transformed; None: everywhere",
       [](D& d, const std::string& name, nb::handle v) {
         if (v.is_none()) return d.shape.reset();
         if (!nb::isinstance<Shape>(v))
           wrong_type(name + ": expected a meltsim.Shape or None, got " + shown(v));
         d.shape = nb::cast<Shape>(v);
       }},
      {"name", "str", "empty: field<N>", set_to(&D::name)},
      {"acceleration", vector_type, "of a uniform field [m/s^2]", set_to(&D::acceleration)},
      {"center", "Sequence[float] | None",
       "of a radial field, of a vortex's axis, of the wind's rotation, of a hydrostatic level [m]; None: the "
       "shape's",
       [](D& d, const std::string& name, nb::handle v) {
         d.center = v.is_none() ? std::nullopt : std::optional<Vec3d>(vector(name, v));
       }},
      {"axis", vector_type, "of a vortex", set_to(&D::axis)},
      {"strength", "float", "of a radial field or a vortex at the radius [m/s^2]; negative attracts",
       set_to(&D::strength)},
      {"radius", "float", "within it a radial field or a vortex grows linearly from its centre [m]",
       set_to(&D::radius)},
      {"density", "float", "of the liquid whose pressure at rest a hydrostatic field takes out [kg/m^3]",
       set_to(&D::density)},
      {"power", "int", "beyond the radius it goes as the distance to this power: 1, 0, -1, -2",
       set_to(&D::power)},
      {"velocity", vector_type, "of the wind of drag [m/s]", set_to(&D::velocity)},
      {"angular_velocity", vector_type, "of that wind about the center [rad/s]",
       set_to(&D::angular_velocity)},
      {"rate", "float", "at which a difference from the wind decays [1/s]", set_to(&D::rate)},
      {"liquid", "bool", "acts on liquid", set_to(&D::liquid)},
      {"bodies", "bool", "acts on bodies that can move", set_to(&D::bodies)},
      {"start", "float", "begins to act [s]", set_to(&D::from)},
      {"until", "float", "ceases to act [s]", set_to(&D::until)}};
  return keys;
}

const Keys<ProbeInput>& probe_keys() {
  using D = ProbeDesc;
  const auto d = [](auto member) { return of(&ProbeInput::desc, member); };
  static const Keys<ProbeInput> keys{
      {"points", "numpy.typing.ArrayLike", "where: shape (n, 3) [m]",
       [](ProbeInput& i, const std::string& name, nb::handle v) { i.desc.points = points(name, v); }},
      {"fields", "Sequence[str]",
       "temperature, pressure, density, speed, velocity, liquid_fraction; of force: force, moment, "
       "contact_force, contact_moment; of flux: mass_flux, volume_flux",
       [](ProbeInput& i, const std::string& name, nb::handle v) { i.desc.fields = texts(name, v); }},
      {"name", "str", "empty: probe<N>", d(&D::name)},
      {"kind", "str", "\"point\", \"level\", \"force\", \"heat\" or \"flux\"",
       [](ProbeInput& i, const std::string& name, nb::handle v) {
         i.desc.kind = static_cast<ProbeKind>(choice(name, v, {"point", "level", "force", "heat", "flux"}));
       }},
      {"body", "Body | str | None", "of force and heat", kept(&ProbeInput::body)},
      {"wall", "str | None", "of force and heat: -x, +x, -y, +y, -z or +z",
       [](ProbeInput& i, const std::string& name, nb::handle v) {
         i.desc.wall = v.is_none() ? std::nullopt
                                   : std::optional<int>(static_cast<int>(
                                         choice(name, v, {"-x", "+x", "-y", "+y", "-z", "+z"})));
       }},
      {"normal", vector_type, "of flux: the positive direction", d(&D::normal)},
      {"radius", "float", "of flux: of a disc [m]; 0: a rectangle", d(&D::radius)},
      {"along", vector_type, "of flux: the direction of the first side of a rectangle", d(&D::along)},
      {"size", vector_type, "of flux: lengths of the two sides of a rectangle, along and across [m]",
       [](ProbeInput& i, const std::string& name, nb::handle v) {
         const nb::object pair = items_of(v);
         if (!pair || PySequence_Fast_GET_SIZE(pair.ptr()) != 2)
           wrong_type(name + ": expected two numbers, got " + shown(v));
         for (int k = 0; k < 2; ++k)
           i.desc.size[k] =
               number(name + "[" + std::to_string(k) + "]", PySequence_Fast_GET_ITEM(pair.ptr(), k));
       }},
      {"every", "float", "interval between samples [s]; 0: every sub-step", d(&D::every)},
      {"start", "float", "first sample [s]", d(&D::from)},
      {"until", "float", "last sample [s]", d(&D::until)}};
  return keys;
}

template <class I, class D = decltype(I::desc)>
void take_material(HostWorld& w, I& input, const char* what) {
  if (!input.material) wrong_type(std::string(what) + ": material is missing");
  input.desc.material = w.resolve("material", w.materials, input.material, "material");
}

template <class I>
void take_fractions(HostWorld& w, I& input, const char* what) {
  if (!input.fractions || input.fractions.is_none()) return;
  const std::string name = std::string(what) + ": fractions";
  if (!nb::isinstance<nb::dict>(input.fractions))
    wrong_type(name + ": expected a dict of material and mass fraction, got " + shown(input.fractions));
  for (const auto& [material, value] : nb::cast<nb::dict>(input.fractions)) {
    nb::object key = nb::borrow(material);
    input.desc.fractions.push_back(
        {w.resolve("fractions", w.materials, key, "material"), number(name, value)});
  }
}

Quat<double> quaternion(const std::string& name, nb::handle v) {
  const nb::object q = items_of(v);
  if (!q || PySequence_Fast_GET_SIZE(q.ptr()) != 4)
    wrong_type(name + ": expected four numbers (w, x, y, z), got " + shown(v));
  double x[4];
  for (int k = 0; k < 4; ++k) x[k] = number(name, PySequence_Fast_GET_ITEM(q.ptr(), k));
  return {x[0], x[1], x[2], x[3]};
}

nb::tuple tuple4(const Quat<double>& q) { return nb::make_tuple(q.w, q.x, q.y, q.z); }

struct MotionInput {
  nb::object body;
  BodyMotion desc;
};
struct ProxyInput {
  nb::object body;
  ProxyState desc;
};
const Keys<ProxyInput>& proxy_keys() {
  using D = ProxyState;
  const auto d = [](auto member) { return of(&ProxyInput::desc, member); };
  static const Keys<ProxyInput> keys{
      {"body", "Body | str", "a proxy", kept(&ProxyInput::body)},
      {"position", vector_type, "of its centre of mass now [m]", d(&D::position)},
      {"orientation", "Sequence[float]", "now, relative to the body as built: a unit quaternion (w, x, y, z)",
       [](ProxyInput& i, const std::string& name, nb::handle v) {
         i.desc.orientation = quaternion(name, v);
       }},
      {"velocity", vector_type, "of the centre of mass [m/s]", d(&D::velocity)},
      {"angular_velocity", vector_type, "[rad/s]", d(&D::angular_velocity)},
      {"acceleration", vector_type, "by forces that only the host knows, beside gravity [m/s^2]",
       d(&D::acceleration)},
      {"teleport", "bool", "puts it there at once instead of within the next step", d(&D::teleport)}};
  return keys;
}

const Keys<MotionInput>& motion_keys() {
  using D = BodyMotion;
  const auto d = [](auto member) { return of(&MotionInput::desc, member); };
  static const Keys<MotionInput> keys{
      {"body", "Body | str", "a kinematic body", kept(&MotionInput::body)},
      {"position", "Sequence[float] | None", "of its pivot at the end of the next step [m]",
       [](MotionInput& i, const std::string& name, nb::handle v) {
         i.desc.position = v.is_none() ? std::nullopt : std::optional<Vec3d>(vector(name, v));
       }},
      {"orientation", "Sequence[float] | None", "at the end of the next step: a unit quaternion (w, x, y, z)",
       [](MotionInput& i, const std::string& name, nb::handle v) {
         if (v.is_none()) return i.desc.orientation.reset();
         i.desc.orientation = quaternion(name, v);
       }},
      {"velocity", vector_type, "of the pivot, where no position is given, and after the next step [m/s]",
       d(&D::velocity)},
      {"angular_velocity", vector_type, "about the pivot, likewise [rad/s]", d(&D::angular_velocity)},
      {"teleport", "bool",
       "places the body there at once; it must be clear of bodies, liquid goes out of its way",
       d(&D::teleport)}};
  return keys;
}

// ---- Making --------------------------------------------------------------------------------------------

/// A scene that was read, before it is built.
struct LoadedScene {
  runner::Scene scene;
  bool is_dict = false;
};

const char* const dict_file = "scene";  ///< what messages about a dict call it

/// A message of the reader in the terms of World.load(). A dict has paths, no lines and columns.
std::string in_terms_of_load(std::string said, bool is_dict) {
  static const std::regex place(std::string("\\b") + dict_file + ":\\d+:\\d+: "),
      first("; first given on line \\d+$"), of_argument("^[^\"]*:\\d+:\\d+: (threads: [^]*)$"),
      set("^--set "), scale("--scale (?=\\d)");
  said = std::regex_replace(said, of_argument, "$1");
  if (is_dict) {
    said = std::regex_replace(said, place, std::string(dict_file) + ": ");
    said = std::regex_replace(said, first, "");
  }
  return std::regex_replace(std::regex_replace(said, set, "set: "), scale, "scale=");
}

template <class F>
auto with_place(bool is_dict, F f) {
  try {
    return f();
  } catch (const runner::Failure& failure) {
    ErrorCode code = ErrorCode::invalid_argument;
    if (failure.code() == runner::ExitCode::device) code = ErrorCode::no_device;
    if (failure.code() == runner::ExitCode::diverged) code = ErrorCode::halted;
    throw LibraryError({code, in_terms_of_load(failure.what(), is_dict)});
  }
}

/// What show() needs to know of a World that was not read from a scene.
runner::Scene plain_scene(const WorldDesc& desc) {
  runner::Scene scene;
  scene.world = desc;
  return scene;
}

void init_world(HostWorld* self, const nb::args& args, const nb::kwargs& kwargs) {
  WorldDesc desc;
  desc.domain = {};
  describe(desc, world_keys(), "World", 1, args, kwargs);
  auto world = World::create(desc);
  if (!world) throw LibraryError(world.error());
  new (self) HostWorld(std::move(*world), plain_scene(desc));
}

/// The name that a thing was given, or the one that the library gives it: its kind and how many there are with it, or the next
/// number that no other has, so that a name which nobody chose is never refused.
template <class Taken>
std::string name_or(const std::string& name, const char* kind, std::size_t others, Taken taken) {
  std::string numbered = name;
  while (name.empty() && (numbered.empty() || taken(numbered))) numbered = kind + std::to_string(++others);
  return numbered;
}

/// The same among things of a World. A name that another has is refused.
template <class N>
std::string new_name(const std::string& name, const char* kind, const char* what,
                     const std::vector<N>& known) {
  const auto taken = [&](const std::string& other) {
    return std::any_of(known.begin(), known.end(), [&](const N& n) { return n.name == other; });
  };
  if (taken(name)) refuse(std::string("name: there is ") + what + " \"" + name + "\" already");
  return name_or(name, kind, known.size(), taken);
}

/// What the World calls a probe: its name, but where the World still has that for points of a scene that were removed.
std::string name_in_world(const HostWorld& w, const std::string& name) {
  const auto taken = [&](const std::string& other) {
    const auto has = [&](const Probe& p) { return p.name == other; };
    return std::any_of(w.unnamed.begin(), w.unnamed.end(), has) ||
           (other != name && std::any_of(w.probes.begin(), w.probes.end(), has));
  };
  return taken(name) ? name_or("", (name + ".").c_str(), 1, taken) : name;
}

/// Objects by name.
template <class N>
auto by_name(std::vector<N> HostWorld::*all) {
  return [all](HostWorld& w) {
    w.unguarded();
    nb::dict d;
    for (const N& x : w.*all)
      if (w.is_there(x)) d[x.name.c_str()] = nb::cast(x);
    return d;
  };
}

void init_scene(HostWorld* self, const LoadedScene& loaded, Text backend, Text precision, Integer threads) {
  runner::MachineOptions machine;
  machine.backend = static_cast<Backend>(choice("backend", backend, backends));
  machine.precision = static_cast<Precision>(choice("precision", precision, precisions));
  set_to (&runner::MachineOptions::threads)(machine, "threads", threads);
  std::vector<ProbeId> probe_ids;
  auto built = with_place(loaded.is_dict, [&] {
    const nb::gil_scoped_release released;
    runner::Built b = runner::build_world(loaded.scene, machine);
    b.probes = runner::add_probes(b.world, b.body_ids, loaded.scene, &probe_ids);
    return b;
  });
  const auto pieces = expect(built.world.pieces());
  new (self) HostWorld(std::move(built.world), loaded.scene);
  for (std::size_t i = 0; i < built.materials.size(); ++i)
    self->materials.push_back({self->serial(), built.material_ids[i], built.materials[i]});
  for (std::size_t i = 0; i < loaded.scene.bodies.size(); ++i) {
    BodyId id{static_cast<std::uint32_t>(i), 0};
    for (const PieceInfo& piece : pieces)
      if (piece.body.index == i) id = piece.body;
    self->bodies.push_back({self->serial(), id, loaded.scene.bodies[i].desc.name});
  }
  for (std::size_t i = 0; i < built.force_field_ids.size(); ++i)
    self->fields.push_back(
        {self->serial(), built.force_field_ids[i], loaded.scene.force_fields[i].desc.name});
  for (std::size_t i = 0; i < built.emitter_ids.size(); ++i)
    self->emitters.push_back({self->serial(), built.emitter_ids[i], loaded.scene.emitters[i].desc.name});
  for (std::size_t i = 0; i < built.heat_region_ids.size(); ++i)
    self->regions.push_back(
        {self->serial(), built.heat_region_ids[i], loaded.scene.heat_regions[i].desc.name});
  for (std::size_t k = 0; k < built.probes.size(); ++k) {
    int point = 0;
    for (const std::size_t i : built.probes[k])
      self->probes.push_back({self->serial(), probe_ids[k], loaded.scene.probes[i].desc.name, point++});
  }
}

template <class N>
void bind_named(nb::module_& m, const char* name, const char* doc) {
  nb::class_<N>(m, name, doc)
      .def_ro("name", &N::name, "Its name.")
      .def_prop_ro(
          "index", [](const N& n) { return n.id.index; }, "Its position in the World's table, from 0.")
      .def(
          "__eq__",
          [](const N& a, nb::handle b) {
            if (!nb::isinstance<N>(b)) return false;
            const N& other = nb::cast<const N&>(b);
            return other.world == a.world && other.id == a.id && other.point == a.point;
          },
          nb::arg("other").none())
      .def("__hash__", [](const N& n) { return n.world * 1000003u + n.id.index; })
      .def("__repr__",
           [name](const N& n) { return std::string("<meltsim.") + name + " \"" + n.name + "\">"; });
}

/// A result of the World, computed while other Python threads run.
template <class F>
auto away(HostWorld& w, bool changes, F f) {
  const HostWorld::Use world(w, changes);
  const nb::gil_scoped_release released;
  return f(*world);
}

/// A step that may end early.
template <class F>
TimedStep timed(HostWorld& w, F steps) {
  TimedStep taken;
  w.advance([&](World& world) -> Status {
    auto result = steps(world);
    if (!result) return result.error();
    taken = *result;
    return {};
  });
  return taken;
}

// ---- Results by name ------------------------------------------------------------------------------------

nb::list stages(HostWorld& w) {
  const Plan plan = away(w, true, [](World& world) {
    expect(world.prepare());
    return world.plan();
  });
  nb::list all;
  for (const StageReport& s : plan.stages) {
    nb::dict d;
    d["name"] = s.name;
    d["module"] = s.module;
    d["runs"] = s.runs;
    d["reason"] = s.reason;
    d["interval"] = s.interval;
    d["median_ms"] = s.median_ms;
    all.append(d);
  }
  return all;
}

nb::dict forces_by_name(const HostWorld& w, const std::vector<BodyForces>& all) {
  nb::dict bodies;
  for (const BodyForces& f : all) {
    nb::dict d;
    d["seconds"] = f.seconds;
    d["impulse"] = tuple3(f.total.linear);
    d["angular_impulse"] = tuple3(f.total.angular);
    d["pressure"] = tuple3(f.pressure.linear);
    d["pressure_angular"] = tuple3(f.pressure.angular);
    d["viscosity"] = tuple3(f.viscosity.linear);
    d["viscosity_angular"] = tuple3(f.viscosity.angular);
    d["contact"] = tuple3(f.contact.linear);
    d["contact_angular"] = tuple3(f.contact.angular);
    d["heat"] = f.heat;
    d["position"] = tuple3(f.position);
    d["orientation"] = tuple4(f.orientation);
    d["velocity"] = tuple3(f.velocity);
    d["angular_velocity"] = tuple3(f.angular_velocity);
    for (const Body& body : w.bodies)
      if (body.id == f.body) bodies[body.name.c_str()] = d;
  }
  return bodies;
}

nb::dict events_by_name(const HostWorld& w, const Events& all) {
  const auto name_of = [&w](BodyId id) -> nb::object {
    for (const Body& body : w.bodies)
      if (body.id == id) return nb::cast(body.name);
    return nb::none();
  };
  nb::list events;
  for (const Event& e : all.events) {
    nb::dict d;
    d["kind"] = event_names[static_cast<std::size_t>(e.kind)];
    d["step"] = e.step;
    d["time"] = e.time;
    d["position"] = tuple3(e.position);
    d["particle"] = e.particle;
    d["body"] = name_of(e.body);
    d["other"] = name_of(e.other);
    d["wall"] = e.wall < 0 ? nb::object(nb::none()) : nb::cast(face_names[static_cast<std::size_t>(e.wall)]);
    d["piece"] = e.piece;
    d["from"] = e.from;
    events.append(d);
  }
  nb::dict counts, result;
  for (std::size_t k = 0; k < all.counts.size(); ++k) counts[event_names[k].c_str()] = all.counts[k];
  result["events"] = events;
  result["lost"] = all.lost;
  result["counts"] = counts;
  return result;
}

/// Removes what has one kind of handle.
template <class Tag>
void remove(HostWorld& w, const char* argument, std::vector<Named<Tag>>& known, nb::handle what,
            const char* kind) {
  const Handle<Tag> id = w.resolve(argument, known, what, kind);
  away(w, true, [&](World& world) { expect(world.remove(id)); });
  known.erase(std::remove_if(known.begin(), known.end(), [&](const Named<Tag>& one) { return one.id == id; }),
              known.end());
}

/// Removes a probe; of a scene's probes that are points of one probe of the World the last one that is left, of others the name.
void remove_probe(HostWorld& w, nb::handle what) {
  const ProbeId id = w.resolve("probe", w.probes, what, "probe");
  const bool handle = nb::isinstance<Probe>(what);
  const auto sought = [&](const Probe& p) {
    return p.id == id &&
           (handle ? p.point == nb::cast<const Probe&>(what).point : p.name == text("probe", what));
  };
  const auto of_world = [&](const Probe& p) { return p.id == id; };
  const auto found = std::find_if(w.probes.begin(), w.probes.end(), sought);
  const auto points = std::count_if(w.probes.begin(), w.probes.end(), of_world);
  if (found == w.probes.end() && points > 0)
    refuse("remove: probe \"" + nb::cast<const Probe&>(what).name + "\": was removed already");
  if (points > 1) {
    const HostWorld::Use use(w, true);
    w.unnamed.push_back(*found);
    return void(w.probes.erase(found));
  }
  away(w, true, [&](World& world) { expect(world.remove(id)); });
  w.unnamed.erase(std::remove_if(w.unnamed.begin(), w.unnamed.end(), of_world), w.unnamed.end());
  w.probes.erase(std::remove_if(w.probes.begin(), w.probes.end(), of_world), w.probes.end());
}

void remove_body(HostWorld& w, nb::handle what) {
  const BodyId id = w.resolve("body", w.bodies, what, "body");
  away(w, true, [&](World& world) { expect(world.remove(id)); });
  w.removed.push_back(id);
}

/// What remove() takes by name: how it is called, and the handles of those that are there.
struct Removable {
  const char* kind;
  const char* property;
  std::vector<std::string> names;
  std::function<void(nb::handle)> remove;
};
std::vector<Removable> removables(HostWorld& w) {
  const auto names_of = [&w](const auto& all) {
    std::vector<std::string> names;
    for (const auto& one : all)
      if (w.is_there(one)) names.push_back(one.name);
    return names;
  };
  return {{"body", "bodies", names_of(w.bodies), [&w](nb::handle what) { remove_body(w, what); }},
          {"force field", "force_fields", names_of(w.fields),
           [&w](nb::handle what) { remove(w, "field", w.fields, what, "force field"); }},
          {"heat region", "heat_regions", names_of(w.regions),
           [&w](nb::handle what) { remove(w, "region", w.regions, what, "heat region"); }},
          {"probe", "probes", names_of(w.probes), [&w](nb::handle what) { remove_probe(w, what); }}};
}

void remove_named(HostWorld& w, nb::handle what) {
  const std::string name = text("remove", what);
  const Removable* found = nullptr;
  std::string list;
  const std::vector<Removable> kinds = removables(w);
  for (const Removable& kind : kinds)
    for (const std::string& known : kind.names) {
      list += (list.empty() ? "" : ", ") + known;
      if (known != name) continue;
      if (found != nullptr)
        refuse(std::string("remove: a ") + found->kind + " and a " + kind.kind + " are named \"" + name +
               "\"; pass the one that you mean: world." + found->property + "[\"" + name + "\"] or world." +
               kind.property + "[\"" + name + "\"]");
      found = &kind;
    }
  for (const Body& body : w.bodies)  // says that it was removed
    if (found == nullptr && body.name == name) return remove_body(w, what);
  if (found == nullptr)
    refuse("remove: no body, force field, heat region or probe is named \"" + name + "\"; there " +
           (list.empty() ? "are none" : "are: " + list));
  found->remove(what);
}

void remove_any(HostWorld& w, nb::handle what) {
  if (PyUnicode_Check(what.ptr())) return remove_named(w, what);
  if (nb::isinstance<ForceField>(what)) return remove(w, "field", w.fields, what, "force field");
  if (nb::isinstance<HeatRegion>(what)) return remove(w, "region", w.regions, what, "heat region");
  if (nb::isinstance<Probe>(what)) return remove_probe(w, what);
  if (nb::isinstance<Emitter>(what))
    refuse("remove: an emitter cannot be removed; set_emitter(..., on=False) turns it off");
  if (!nb::isinstance<Body>(what))
    wrong_type(
        "remove: expected a body, a force field, a heat region or a probe of this World, or its name, got " +
        shown(what));
  remove_body(w, what);
}

/// What a call has of its bytes: them, or a copy of what may change while it is read.
nb::object bytes_of(const std::string& name, const char* call, nb::object given) {
  if (!PyObject_CheckBuffer(given.ptr()))
    wrong_type(name + ": expected bytes of " + call + ", got " + shown(given));
  if (PyBytes_Check(given.ptr())) return given;
  nb::object copy = nb::steal(PyBytes_FromObject(given.ptr()));
  if (!copy) throw nb::python_error();
  return copy;
}

nb::dict samples_by_name(const HostWorld& w, std::vector<ProbeSeries> all) {
  nb::dict result;
  for (ProbeSeries& s : all) {
    const std::size_t points = s.points, width = s.width, times = s.time.size();
    const nb::object time = array_of<double>(std::move(s.time)),
                     values = array_of<double>(std::move(s.values)).attr("reshape")(times, points, width);
    for (const Probe& probe : w.probes) {
      if (probe.id != s.probe) continue;
      nb::dict one;
      one["time"] = time;
      one["values"] = values;
      if (probe.point >= 0)
        one["values"] =
            values[nb::make_tuple(nb::slice(nb::none(), nb::none(), nb::none()),
                                  nb::slice(nb::int_(probe.point), nb::int_(probe.point + 1), nb::none()))];
      result[probe.name.c_str()] = one;
    }
  }
  return result;
}

// ---- Reading without waiting ------------------------------------------------------------------------------

const std::vector<std::string> part_names{"totals", "forces", "events", "pieces", "particles", "samples"};
bool ReadRequest::*const part_members[] = {&ReadRequest::totals,    &ReadRequest::forces,
                                           &ReadRequest::events,    &ReadRequest::pieces,
                                           &ReadRequest::particles, &ReadRequest::probes};

/// A member of what was read; None where it was not asked for.
template <class F>
auto part(bool ReadRequest::*asked, F f) {
  return [asked, f](HostReading& r) -> nb::object {
    return r.asked.*asked ? nb::object(f(r)) : nb::object(nb::none());
  };
}

ReadTicket ticket_of(nb::handle ticket) {
  const std::int64_t value = integer("ticket", ticket);
  if (value < 0) refuse("ticket: expected one of request(), got " + std::to_string(value));
  return {static_cast<std::uint64_t>(value)};
}

/// Objects that hold their World: Python's collector follows that, or a cycle through a stage's exception, whose frames hold them,
/// stays for good. The World's own slots break such cycles.
template <class T>
int visit_owner(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (nb::inst_ready(self)) Py_VISIT(nb::inst_ptr<T>(self)->owner.ptr());
  return 0;
}
template <class T>
PyType_Slot owner_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(visit_owner<T>)}, {0, nullptr}};

void bind_reading(nb::module_& m) {
  nb::class_<HostReading>(m, "Reading", nb::type_slots(owner_slots<HostReading>),
                          "What World.take() gives: the World as it was at the request. What was not asked "
                          "for is None.")
      .def_prop_ro(
          "time", [](const HostReading& r) { return r.reading.time; }, "[s]")
      .def_prop_ro(
          "steps", [](const HostReading& r) { return r.reading.step; }, "Sub-steps completed.")
      .def_prop_ro(
          "result", [](const HostReading& r) { return r.reading.result; },
          "The report that synchronize() would have given then; always there.")
      .def_prop_ro("totals",
                   part(&ReadRequest::totals, [](HostReading& r) { return nb::cast(r.reading.totals); }),
                   nb::sig("def totals(self) -> Totals | None"), "As World.totals().")
      .def_prop_ro("ledger",
                   part(&ReadRequest::totals, [](HostReading& r) { return nb::cast(r.reading.ledger); }),
                   nb::sig("def ledger(self) -> Ledger | None"), "As World.ledger(), with the totals.")
      .def_prop_ro("forces",
                   part(&ReadRequest::forces,
                        [](HostReading& r) { return forces_by_name(*r.world, r.reading.forces); }),
                   nb::sig("def forces(self) -> dict[str, meltsim._types.Forces] | None"),
                   "As World.take_forces().")
      .def_prop_ro("events",
                   part(&ReadRequest::events,
                        [](HostReading& r) { return events_by_name(*r.world, r.reading.events); }),
                   nb::sig("def events(self) -> dict[str, Any] | None"), "As World.take_events().")
      .def_prop_ro("pieces",
                   part(&ReadRequest::pieces,
                        [](HostReading& r) {
                          nb::list all;
                          for (const PieceInfo& p : r.reading.pieces) all.append(nb::cast(p));
                          return all;
                        }),
                   nb::sig("def pieces(self) -> list[Piece] | None"), "As World.pieces(); at most 65,536.")
      .def_prop_ro("particles",
                   part(&ReadRequest::particles,
                        [](HostReading& r) {
                          return nb::cast(r.reading.particles, nb::rv_policy::reference_internal,
                                          nb::find(&r));
                        }),
                   nb::sig("def particles(self) -> ParticleFrame | None"),
                   "Particles in single precision, without a copy.")
      .def_prop_ro("samples",
                   part(&ReadRequest::probes,
                        [](HostReading& r) { return samples_by_name(*r.world, r.reading.probes); }),
                   nb::sig("def samples(self) -> dict[str, dict[str, numpy.ndarray]] | None"),
                   "As World.take_samples().");
}

std::uint64_t request(HostWorld& w, const nb::args& args) {
  ReadRequest what;
  for (nb::handle name : args) what.*part_members[choice("parts", name, part_names)] = true;
  const HostWorld::Use use(w);
  ReadTicket ticket;
  {
    const nb::gil_scoped_release released;
    ticket = expect(use->request(what));
  }
  w.requests[ticket.value] = what;
  return ticket.value;
}

nb::object take(HostWorld& w, Integer of) {
  const ReadTicket ticket = ticket_of(of);
  auto taken = std::make_unique<HostReading>();
  const HostWorld::Use use(w);
  {
    const nb::gil_scoped_release released;
    taken->reading = expect(use->take(ticket));
  }
  taken->asked = w.requests[ticket.value];
  w.requests.erase(ticket.value);
  taken->owner = nb::find(&w);
  taken->world = &w;
  return nb::cast(taken.release(), nb::rv_policy::take_ownership);
}

// ---- Views of the World's own memory ------------------------------------------------------------------------

/// An array of the World's own memory. It keeps the World, and counts: what changes that memory is refused while the array is
/// alive. `columns` 1: of shape (n,).
nb::object exported_array(const nb::object& of, HostWorld& w, std::atomic<int>& counter, Backend backend,
                          void* data, std::uint64_t rows, std::size_t columns, nb::dlpack::dtype dtype,
                          bool writable) {
  if (data == nullptr && rows > 0) return nb::none();
  struct Export {
    nb::object owner;
    std::atomic<int>* counter;
  };
  auto* exported = new Export{of, &counter};
  ++counter;
  nb::capsule owner(exported, [](void* p) noexcept {
    auto* e = static_cast<Export*>(p);
    --*e->counter;
    delete e;
  });
  const std::size_t shape[2] = {static_cast<std::size_t>(rows), columns};
  const std::size_t dimensions = columns > 1 ? 2 : 1;
  if (backend == Backend::cuda) {
    nb::ndarray<> array(data, dimensions, shape, owner, nullptr, dtype, nb::device::cuda::value,
                        w.unguarded().desc().device);
    return nb::cast(array, nb::rv_policy::reference);
  }
  nb::ndarray<nb::numpy> array(data, dimensions, shape, owner, nullptr, dtype, nb::device::cpu::value, 0);
  nb::object object = nb::cast(array, nb::rv_policy::reference);
  if (!writable) object.attr("flags").attr("writeable") = false;
  return object;
}

/// T: 0 = the World's precision, else the type.
nb::object state_array(State& s, void* data, std::size_t columns, nb::dlpack::dtype dtype, bool writable,
                       bool optional = false) {
  HostWorld& w = *s.world;
  w.unguarded();
  if (s.stage ? !*s.alive : s.generation != w.generation)
    refuse(s.stage ? "state: the stage has returned; its argument holds until then"
                   : "state: the World has changed since state(); call state() again");
  if (data == nullptr && optional) return nb::none();
  return exported_array(s.owner, w, w.exported, s.context.backend, data, s.context.particles, columns, dtype,
                        writable);
}

/// A member of a render pack.
template <class V>
auto pack_array(const V* RenderView::*member) {
  return [member](RenderPack& p) {
    constexpr std::size_t columns = std::is_same_v<V, Vec3f> ? 3 : 1;
    using Item = std::conditional_t<std::is_same_v<V, Vec3f>, float, V>;
    p.world->unguarded();
    if (p.pack != p.world->packs)
      refuse(
          "render_view: there is a later one, which has taken the place of this; use that, or keep a copy");
    auto* data = const_cast<V*>(p.view.*member);
    if constexpr (std::is_same_v<V, std::uint32_t>)  // colours, where none were asked for
      if (data == nullptr && member == &RenderView::color) return nb::object(nb::none());
    return exported_array(p.owner, *p.world, p.world->packed, p.view.backend, data, p.view.count, columns,
                          nb::dtype<Item>(), false);
  };
}

std::string view_repr(const char* kind, const std::string& contents, Backend backend, bool expired) {
  return std::string("<meltsim.") + kind + ": " + contents + ", " +
         backends[static_cast<std::size_t>(backend)] + (expired ? ", no longer there>" : ">");
}

void bind_pack(nb::module_& m) {
  nb::class_<RenderPack>(
      m, "RenderPack", nb::type_slots(owner_slots<RenderPack>),
      "Particles by id in single precision, packed in the memory of the backend: no copy. NumPy "
      "arrays on the CPU; on CUDA arrays with __dlpack__. They stay while the World steps, until the "
      "next render_view(), which is refused while one is alive.")
      .def("__len__", [](const RenderPack& p) { return static_cast<std::size_t>(p.view.count); })
      .def("__repr__",
           [](const RenderPack& p) {
             return view_repr("RenderPack", std::to_string(p.view.count) + " particles", p.view.backend,
                              p.world->closed() || p.pack != p.world->packs);
           })
      .def_prop_ro(
          "origin", [](const RenderPack& p) { return tuple3(p.view.origin); },
          "Positions are relative to it [m].")
      .def_prop_ro(
          "radius", [](const RenderPack& p) { return p.view.radius; }, "Half a spacing [m].")
      .def_prop_ro("position", pack_array(&RenderView::position), nb::sig("def position(self) -> Any"),
                   "[m], float32 (n, 3)")
      .def_prop_ro("velocity", pack_array(&RenderView::velocity), nb::sig("def velocity(self) -> Any"),
                   "[m/s], float32 (n, 3)")
      .def_prop_ro("temperature", pack_array(&RenderView::temperature),
                   nb::sig("def temperature(self) -> Any"), "[degrees Celsius], float32 (n,)")
      .def_prop_ro("liquid_fraction", pack_array(&RenderView::liquid_fraction),
                   nb::sig("def liquid_fraction(self) -> Any"), "0 solid to 1 liquid, float32 (n,)")
      .def_prop_ro("density", pack_array(&RenderView::density), nb::sig("def density(self) -> Any"),
                   "[kg/m^3], float32 (n,)")
      .def_prop_ro("pressure", pack_array(&RenderView::pressure), nb::sig("def pressure(self) -> Any"),
                   "[Pa], float32 (n,)")
      .def_prop_ro("tag", pack_array(&RenderView::tag), nb::sig("def tag(self) -> Any"),
                   "Bits: 0x100 solid, 0x800 removed; low byte: material; uint32 (n,)")
      .def_prop_ro("piece", pack_array(&RenderView::piece), nb::sig("def piece(self) -> Any"),
                   "Label of the piece, 0 for liquid; uint32 (n,)")
      .def_prop_ro(
          "color", pack_array(&RenderView::color), nb::sig("def color(self) -> Any"),
          "Red in the lowest byte, then green, blue, opacity; uint32 (n,). None if none were asked for.")
      .def_prop_ro(
          "stream", [](const RenderPack& p) { return reinterpret_cast<std::uintptr_t>(p.view.stream); },
          "The World's cudaStream_t; 0 on the CPU.");
}

/// A member of a surface in the backend's memory.
template <class V>
auto surface_array(const V* SurfaceView::*member) {
  return [member](SurfacePack& p) {
    constexpr std::size_t columns = std::is_same_v<V, Vec3f> ? 3 : 1;
    using Item = std::conditional_t<std::is_same_v<V, Vec3f>, float, V>;
    expect(p.world->unguarded().check_view(p.view));
    const bool of_triangles = static_cast<const void*>(p.view.*member) == p.view.triangle;
    return exported_array(p.owner, *p.world, p.world->surfaced, p.view.backend,
                          const_cast<V*>(p.view.*member), of_triangles ? p.view.triangles : p.view.vertices,
                          of_triangles ? 3 : columns, nb::dtype<Item>(), false);
  };
}

void bind_surface_pack(nb::module_& m) {
  nb::class_<SurfacePack>(
      m, "SurfaceView", nb::type_slots(owner_slots<SurfacePack>),
      "A surface mesh in the memory of the backend: no copy. NumPy arrays on the CPU; on CUDA arrays with "
      "__dlpack__. They stay while the World steps, until the next surface, which is refused while one is "
      "alive.")
      .def("__repr__",
           [](const SurfacePack& p) {
             const bool expired = p.world->closed() || !p.world->unguarded().check_view(p.view);
             return view_repr("SurfaceView",
                              std::to_string(p.view.vertices) + " vertices, " +
                                  std::to_string(p.view.triangles) + " triangles",
                              p.view.backend, expired);
           })
      .def_prop_ro(
          "origin", [](const SurfacePack& p) { return tuple3(p.view.origin); }, "Add it to positions [m].")
      .def_prop_ro("position", surface_array(&SurfaceView::position), nb::sig("def position(self) -> Any"),
                   "[m], float32 (n, 3)")
      .def_prop_ro("normal", surface_array(&SurfaceView::normal), nb::sig("def normal(self) -> Any"),
                   "Outward, length 1, float32 (n, 3)")
      .def_prop_ro("temperature", surface_array(&SurfaceView::temperature),
                   nb::sig("def temperature(self) -> Any"), "[degrees Celsius], float32 (n,)")
      .def_prop_ro("liquid_fraction", surface_array(&SurfaceView::liquid_fraction),
                   nb::sig("def liquid_fraction(self) -> Any"), "0 to 1, float32 (n,)")
      .def_prop_ro("body", surface_array(&SurfaceView::body), nb::sig("def body(self) -> Any"),
                   "0 = liquid, else Body.index + 1, uint32 (n,)")
      .def_prop_ro("material", surface_array(&SurfaceView::material), nb::sig("def material(self) -> Any"),
                   "Material.index, uint32 (n,)")
      .def_prop_ro("triangles", surface_array(&SurfaceView::triangle), nb::sig("def triangles(self) -> Any"),
                   "Vertices of triangles, counter-clockwise seen from outside, uint32 (m, 3)")
      .def_prop_ro(
          "draw",
          [](SurfacePack& p) {
            expect(p.world->unguarded().check_view(p.view));
            return exported_array(p.owner, *p.world, p.world->surfaced, p.view.backend,
                                  const_cast<SurfaceDraw*>(p.view.draw), p.view.draw == nullptr ? 0 : 5, 1,
                                  nb::dtype<std::uint32_t>(), false);
          },
          nb::sig("def draw(self) -> Any"),
          "Arguments of an indexed indirect draw: uint32 (5,), the first is three times the number of "
          "triangles.")
      .def_prop_ro(
          "stream", [](const SurfacePack& p) { return reinterpret_cast<std::uintptr_t>(p.view.stream); },
          "The World's cudaStream_t; 0 on the CPU.");
}

void refuse_while_surfaced(const HostWorld& w, const char* call) {
  if (w.surfaced > 0)
    refuse(std::string(call) + ": " + std::to_string(w.surfaced) +
           " array(s) of a surface_view() still view its memory; delete them first, or keep a copy "
           "(array.copy())");
}

SurfaceDesc surface_desc(HostWorld& w, nb::handle of_what, nb::handle cell, nb::handle kernel,
                         nb::handle smoothing, nb::handle closed) {
  SurfaceDesc desc;
  if (nb::isinstance<Body>(of_what))
    desc.of = SurfaceOf::body, desc.body = w.resolve("of", w.bodies, of_what, "body");
  else {
    const std::string word = text("of", of_what);
    std::string others;
    for (const Body& body : w.bodies) {
      if (body.name == word) desc.of = SurfaceOf::body, desc.body = body.id;
      if (w.is_there(body)) others += (others.empty() ? "" : ", ") + body.name;
    }
    if (word == "liquid" || word == "solids")  // before bodies of that name
      desc.of = word == "liquid" ? SurfaceOf::liquid : SurfaceOf::solids;
    else if (desc.of != SurfaceOf::body)
      refuse("of: expected liquid or solids, got \"" + word + "\", and no body is named so; there " +
             (others.empty() ? "are none" : "are: " + others));
  }
  desc.cell = number("cell", cell);
  desc.kernel = static_cast<SurfaceKernel>(choice("kernel", kernel, {"isotropic", "anisotropic"}));
  desc.smoothing = static_cast<int>(integer("smoothing", smoothing));
  desc.closed_at_solids = boolean("closed_at_solids", closed);
  return desc;
}

nb::dlpack::dtype scalar(const State& s) {
  return s.context.precision == Precision::double_precision ? nb::dtype<double>() : nb::dtype<float>();
}

void bind_state(nb::module_& m) {
  nb::class_<State>(m, "State", nb::type_slots(owner_slots<State>),
                    "Views of the World's own memory, in the order of the backend: no copy. NumPy arrays on "
                    "the CPU; on CUDA "
                    "arrays with __dlpack__, for cupy.from_dlpack and torch.from_dlpack. From World.state() "
                    "they are read-only "
                    "by agreement; what changes the World is refused while one is alive.")
      .def("__len__", [](const State& s) { return static_cast<std::size_t>(s.context.particles); })
      .def("__repr__",
           [](const State& s) {
             const bool expired =
                 s.world->closed() || (s.stage ? !*s.alive : s.generation != s.world->generation);
             return view_repr("State",
                              std::to_string(s.context.particles) +
                                  " particles at t = " + runner::csv_number(s.context.time) + " s",
                              s.context.backend, expired);
           })
      .def_prop_ro(
          "position",
          [](State& s) { return state_array(s, s.context.position, 4, scalar(s), s.writable("position")); },
          nb::sig("def position(self) -> Any"),
          "x, y, z relative to World.resolved.origin [m], rest volume [m^3]; (n, 4)")
      .def_prop_ro(
          "velocity",
          [](State& s) { return state_array(s, s.context.velocity, 4, scalar(s), s.writable("velocity")); },
          nb::sig("def velocity(self) -> Any"), "[m/s]; the fourth column belongs to the library; (n, 4)")
      .def_prop_ro(
          "acceleration",
          [](State& s) {
            return state_array(s, s.context.acceleration, 3, scalar(s), s.writable("acceleration"), true);
          },
          nb::sig("def acceleration(self) -> Any"),
          "Within a stage: add to it [m/s^2]; (n, 3). None outside.")
      .def_prop_ro(
          "id",
          [](State& s) {
            return state_array(s, const_cast<std::uint32_t*>(s.context.id), 1, nb::dtype<std::uint32_t>(),
                               false);
          },
          nb::sig("def id(self) -> Any"), "Stable ids, uint32 (n,)")
      .def_prop_ro(
          "tag",
          [](State& s) {
            return state_array(s, const_cast<std::uint32_t*>(s.context.tag), 1, nb::dtype<std::uint32_t>(),
                               false);
          },
          nb::sig("def tag(self) -> Any"),
          "Bits: 0x100 solid, 0x800 removed; low byte: material; uint32 (n,)")
      .def_prop_ro(
          "enthalpy",
          [](State& s) {
            return state_array(s, const_cast<double*>(s.context.enthalpy), 1, nb::dtype<double>(), false,
                               true);
          },
          nb::sig("def enthalpy(self) -> Any"), "[J], float64 (n,); None where heat is at rest")
      .def_prop_ro(
          "dt", [](const State& s) { return s.context.dt; },
          "Length of the sub-step [s]; 0 outside of stages.")
      .def_prop_ro(
          "time", [](const State& s) { return s.context.time; }, "[s]")
      .def_prop_ro(
          "stream", [](const State& s) { return reinterpret_cast<std::uintptr_t>(s.context.stream); },
          "The World's cudaStream_t as an integer, for torch.cuda.ExternalStream; 0 on the CPU.")
      .def(
          "__cuda_stream__",
          [](const State& s) {
            return nb::make_tuple(0, reinterpret_cast<std::uintptr_t>(s.context.stream));
          },
          nb::sig("def __cuda_stream__(self) -> tuple[int, int]"),
          "CUDA's stream protocol, for cupy.cuda.Stream.from_external(state).");
}

int visit(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  for (const auto& stage : nb::inst_ptr<HostWorld>(self)->stages()) Py_VISIT(stage->function.ptr());
  return 0;
}
int forget(PyObject* self) {
  if (nb::inst_ready(self)) nb::inst_ptr<HostWorld>(self)->clear();
  return 0;
}
PyType_Slot world_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(visit)},
                             {Py_tp_clear, reinterpret_cast<void*>(forget)},
                             {0, nullptr}};

}  // namespace

void bind_world(nb::module_& m) {
  bind_named<Material>(m, "Material", "A substance of a World.");
  bind_named<Body>(m, "Body", "A body of a World.");
  bind_named<Emitter>(m, "Emitter", "An emitter of a World.");
  bind_named<HeatRegion>(m, "HeatRegion", "A heat region of a World.");
  bind_named<ForceField>(m, "ForceField", "A force field of a World.");
  bind_named<Probe>(m, "Probe", "A probe of a World.");
  bind_state(m);
  bind_pack(m);
  bind_surface_pack(m);
  bind_reading(m);

  nb::class_<LoadedScene>(m, "Scene", "A scene that was read and not built yet.")
      .def(nb::new_([](const std::string& source, bool is_text, const std::vector<std::string>& set,
                       double scale) {
             return with_place(is_text, [&] {
               if (!(scale >= 0.01 && scale <= 100))
                 refuse("scale: expected a factor from 0.01 to 100, got " + runner::csv_number(scale));
               LoadedScene loaded{is_text ? runner::parse_scene(source, dict_file, "", set)
                                          : runner::load_scene(source, set),
                                  is_text};
               runner::apply_resolution(loaded.scene, scale, runner::Quality::balanced);
               for (std::string& warning : loaded.scene.warnings)
                 warning = in_terms_of_load(warning, is_text);
               return loaded;
             });
           }),
           "source"_a, "is_text"_a, "set"_a, "scale"_a)
      .def_prop_ro(
          "title", [](const LoadedScene& s) { return s.scene.title; }, "Its title.")
      .def_prop_ro(
          "end", [](const LoadedScene& s) { return s.scene.time.end; }, "When it ends [s].")
      .def_prop_ro(
          "fps", [](const LoadedScene& s) { return s.scene.time.fps; }, "Frames per simulated second.")
      .def_prop_ro(
          "warnings", [](const LoadedScene& s) { return s.scene.warnings; }, "What looks like a slip.");

  static const std::string
      init_sig = signature("__init__", world_keys(), 1, 0, "None"),
      init_doc = documented("Makes an empty World.", world_keys()),
      material_sig = signature("add_material", material_keys(), 1, 0, "Material"),
      material_doc = documented("Adds a substance. Defaults are those of water.", material_keys()),
      fluid_sig = signature("add_fluid", fluid_keys(), 2, 2, "int"),
      fluid_doc =
          documented("Fills a shape with liquid. Returns the number of particles added.", fluid_keys()),
      solid_sig = signature("add_solid", solid_keys(), 2, 2, "Body"),
      solid_doc = documented("Adds a body.", solid_keys()),
      emitter_sig = signature("add_emitter", emitter_keys(), 2, 0, "Emitter"),
      emitter_doc = documented("Adds a nozzle, or an open face with liquid beyond.", emitter_keys()),
      region_sig = signature("add_heat_region", region_keys(), 1, 1, "HeatRegion"),
      region_doc = documented("Adds a part of space that heats, cools or holds temperatures.", region_keys()),
      field_sig = signature("add_force_field", field_keys(), 2, 1, "ForceField"),
      field_doc = documented("Adds a part of space in which liquid and bodies that can move are accelerated.",
                             field_keys()),
      probe_sig = signature("add_probe", probe_keys(), 2, 0, "Probe"),
      probe_doc =
          documented("Adds a probe, sampled inside the sub-steps; take_samples() reads it.", probe_keys());

  static const std::string
      motion_sig = signature("set_motion", motion_keys(), 1, 1, "None"),
      proxy_sig = signature("set_proxy", proxy_keys(), 1, 1, "None"),
      proxy_doc = documented(
          "Sets pose and twist of a proxy as your physics engine has them now. Step, then "
          "give its body the impulses of take_forces().",
          proxy_keys()),
      motion_doc =
          documented("Sets how a kinematic body moves in the next step, and then on.", motion_keys());

  nb::list settings;
  for (const Key<WorldDesc>& key : world_keys()) settings.append(key.name);
  m.attr("_world_settings") = nb::tuple(settings);

  nb::class_<HostWorld>(m, "World", nb::type_slots(world_slots))
      .def("__init__", &init_scene, "scene"_a, "backend"_a, "precision"_a, "threads"_a)
      .def("__init__", &init_world, nb::sig(init_sig.c_str()), init_doc.c_str())
      .def("close", &HostWorld::close,
           "Releases the World and its memory; everything but close() is refused from then on, and close() "
           "does nothing. Refused while "
           "an array views that memory. `with World(...) as world:` closes at its end.")
      .def_prop_ro(
          "closed", [](const HostWorld& w) { return w.closed(); }, "Whether close() was called.")
      .def(
          "add_material",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            MaterialInput input;
            describe(input, material_keys(), "add_material", 1, args, kwargs);
            if (input.becomes && !input.becomes.is_none())
              input.desc.melts_into = w.resolve("becomes", w.materials, input.becomes, "material");
            if (input.dissolves_in && !input.dissolves_in.is_none())
              input.desc.dissolves_in =
                  w.resolve("dissolves_in", w.materials, input.dissolves_in, "material");
            for (const Material& known : w.materials)
              if (known.name == input.desc.name)
                refuse("name: there is a material \"" + input.desc.name + "\" already");
            Material material{
                w.serial(),
                away(w, true, [&](World& world) { return expect(world.add_material(input.desc)); }),
                input.desc.name};
            w.materials.push_back(material);
            w.scene.output.looks.push_back({input.desc.name, input.color});
            return material;
          },
          nb::sig(material_sig.c_str()), material_doc.c_str())
      .def(
          "set_material",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            if (args.size() != 1)
              refuse("material: set_material takes a material, then what of it changes by keyword");
            const MaterialId id = w.resolve("material", w.materials, args[0], "material");
            MaterialInput input;
            input.desc = away(w, false, [&](World& world) { return world.material(id); });
            describe(input, material_keys(), "set_material", 0, nb::borrow<nb::args>(nb::make_tuple()),
                     kwargs);
            if (input.becomes && !input.becomes.is_none())
              input.desc.melts_into = w.resolve("becomes", w.materials, input.becomes, "material");
            if (input.dissolves_in && !input.dissolves_in.is_none())
              input.desc.dissolves_in =
                  w.resolve("dissolves_in", w.materials, input.dissolves_in, "material");
            away(w, true, [&](World& world) { expect(world.set_material(id, input.desc)); });
          },
          nb::sig("def set_material(self, material: str | Material, **changes: Any) -> None"),
          "Changes what of a material may change while a World runs: viscosity, conductivity, flow curve, "
          "friction, stiffness, "
          "tension. What its particles' masses and heat are counted by must stay.")
      .def(
          "add_fluid",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            FluidInput input;
            describe(input, fluid_keys(), "add_fluid", 2, args, kwargs);
            take_material(w, input, "add_fluid");
            take_fractions(w, input, "add_fluid");
            return away(w, true, [&](World& world) { return expect(world.add_fluid(input.desc)); });
          },
          nb::sig(fluid_sig.c_str()), fluid_doc.c_str())
      .def(
          "add_solid",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            SolidInput input;
            describe(input, solid_keys(), "add_solid", 2, args, kwargs);
            take_material(w, input, "add_solid");
            input.desc.name = new_name(input.desc.name, "body", "a body", w.bodies);
            Body body{w.serial(),
                      away(w, true, [&](World& world) { return expect(world.add_solid(input.desc)); }),
                      input.desc.name};
            w.bodies.push_back(body);
            return body;
          },
          nb::sig(solid_sig.c_str()), solid_doc.c_str())
      .def(
          "add_emitter",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            EmitterInput input;
            describe(input, emitter_keys(), "add_emitter", 2, args, kwargs);
            take_material(w, input, "add_emitter");
            take_fractions(w, input, "add_emitter");
            input.desc.name = new_name(input.desc.name, "emitter", "an emitter", w.emitters);
            w.emitters.push_back(
                {w.serial(),
                 away(w, true, [&](World& world) { return expect(world.add_emitter(input.desc)); }),
                 input.desc.name});
            return w.emitters.back();
          },
          nb::sig(emitter_sig.c_str()), emitter_doc.c_str())
      .def(
          "add_heat_region",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            HeatRegionDesc desc;
            describe(desc, region_keys(), "add_heat_region", 1, args, kwargs);
            desc.name = new_name(desc.name, "heat", "a heat region", w.regions);
            w.regions.push_back(
                {w.serial(), away(w, true, [&](World& world) { return expect(world.add_heat_region(desc)); }),
                 desc.name});
            return w.regions.back();
          },
          nb::sig(region_sig.c_str()), region_doc.c_str())
      .def(
          "add_force_field",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            ForceFieldDesc desc;
            describe(desc, field_keys(), "add_force_field", 2, args, kwargs);
            const ForceFieldId id =
                away(w, true, [&](World& world) { return expect(world.add_force_field(desc)); });
            ForceField field{w.serial(), id, away(w, false, [&](World& world) {
                               return expect(world.force_field(id)).name;
                             })};
            w.fields.push_back(field);
            return field;
          },
          nb::sig(field_sig.c_str()), field_doc.c_str())
      .def(
          "set_force_field",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            if (args.size() != 1)
              refuse("field: set_force_field takes a field, then what of it changes by keyword");
            const ForceFieldId id = w.resolve("field", w.fields, args[0], "force field");
            ForceFieldDesc desc = away(w, false, [&](World& world) { return expect(world.force_field(id)); });
            describe(desc, field_keys(), "set_force_field", 0, nb::borrow<nb::args>(nb::make_tuple()),
                     kwargs);
            away(w, true, [&](World& world) { expect(world.set_force_field(id, desc)); });
            for (ForceField& known : w.fields)
              if (known.id == id) known.name = desc.name;
          },
          nb::sig("def set_force_field(self, field: str | ForceField, **changes: Any) -> None"),
          "Changes a force field from the next step on: the arguments of add_force_field(), those that are "
          "given. Without waiting.")
      .def(
          "add_probe",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            ProbeInput input;
            describe(input, probe_keys(), "add_probe", 2, args, kwargs);
            if (input.body && !input.body.is_none())
              input.desc.body = w.resolve("body", w.bodies, input.body, "body");
            const std::string name = new_name(input.desc.name, "probe", "a probe", w.probes);
            input.desc.name = name_in_world(w, name);
            Probe probe{w.serial(),
                        away(w, true, [&](World& world) { return expect(world.add_probe(input.desc)); }),
                        name};
            w.probes.push_back(probe);
            return probe;
          },
          nb::sig(probe_sig.c_str()), probe_doc.c_str())
      .def(
          "set_motion",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            MotionInput input;
            describe(input, motion_keys(), "set_motion", 1, args, kwargs);
            if (!input.body) wrong_type("set_motion: body is missing");
            const BodyId body = w.resolve("body", w.bodies, input.body, "body");
            away(w, true, [&](World& world) { expect(world.set_motion(body, input.desc)); });
          },
          nb::sig(motion_sig.c_str()), motion_doc.c_str())
      .def(
          "motion",
          [](HostWorld& w, nb::object body) {
            const BodyId id = w.resolve("body", w.bodies, body, "body");
            const BodyMotion now = away(w, false, [&](World& world) { return expect(world.motion(id)); });
            nb::dict d;
            if (now.position) d["position"] = tuple3(*now.position);
            if (const auto& q = now.orientation) d["orientation"] = nb::make_tuple(q->w, q->x, q->y, q->z);
            d["velocity"] = tuple3(now.velocity);
            d["angular_velocity"] = tuple3(now.angular_velocity);
            return d;
          },
          "body"_a, nb::sig("def motion(self, body: Body | str) -> dict[str, tuple[float, ...]]"),
          "Pose and velocities of a kinematic body now, as set_motion() takes them.")
      .def(
          "update_mesh",
          [](HostWorld& w, nb::object body, ArrayLike vertices, nb::object velocities) {
            const BodyId id = w.resolve("body", w.bodies, body, "body");
            const auto x = points("vertices", vertices);
            std::vector<Vec3d> v;
            if (!velocities.is_none()) v = points("velocities", velocities);
            if (!velocities.is_none() && v.size() != x.size())
              refuse("velocities: expected as many as vertices, " + std::to_string(x.size()) + ", got " +
                     std::to_string(v.size()));
            away(w, true, [&](World& world) { expect(world.update_mesh(id, x, v)); });
          },
          "body"_a, "vertices"_a, "velocities"_a = nb::none(),
          nb::sig("def update_mesh(self, body: Body | str, vertices: numpy.typing.ArrayLike, velocities: "
                  "numpy.typing.ArrayLike | None = None) -> None"),
          "Moves the mesh of a kinematic body that was built from Shape.mesh: its vertices (n, 3) are there "
          "[m] at "
          "the end of the next step, and go on at velocities (n, 3) [m/s] from then on. None: they stay.")
      .def(
          "wait_for",
          [](HostWorld& w, Integer event) {
            void* const e = reinterpret_cast<void*>(static_cast<std::intptr_t>(integer("event", event)));
            away(w, true, [&](World& world) { expect(world.wait_for(e)); });
          },
          "event"_a,
          "What the World enqueues from now on waits for a CUDA event, given as its address: event.ptr of "
          "CuPy, "
          "event.cuda_event of PyTorch. Python does not wait.")
      .def(
          "signal",
          [](HostWorld& w, Integer event) {
            void* const e = reinterpret_cast<void*>(static_cast<std::intptr_t>(integer("event", event)));
            away(w, true, [&](World& world) { expect(world.signal(e)); });
          },
          "event"_a, "Records a CUDA event, given as its address, behind all that the World has enqueued.")
      .def(
          "save_state",
          [](HostWorld& w, Integer slot) {
            const int of = small("slot", slot);
            away(w, true, [&](World& world) { expect(world.save_state(of)); });
          },
          "slot"_a = 0, nb::sig("def save_state(self, slot: typing.SupportsIndex = 0) -> None"),
          "Saves the state in the backend's memory under a number from 0 to 15.")
      .def(
          "load_state",
          [](HostWorld& w, Integer slot) {
            const int of = small("slot", slot);
            away(w, true, [&](World& world) { expect(world.load_state(of)); });
          },
          "slot"_a = 0, nb::sig("def load_state(self, slot: typing.SupportsIndex = 0) -> None"),
          "Goes back to a state of save_state(), to the bit. Lost when something is added, removed or "
          "restored, or "
          "stages begin or end; snapshot() is not.")
      .def(
          "set_proxy",
          [](HostWorld& w, nb::args args, nb::kwargs kwargs) {
            ProxyInput input;
            describe(input, proxy_keys(), "set_proxy", 1, args, kwargs);
            if (!input.body) wrong_type("set_proxy: body is missing");
            const BodyId body = w.resolve("body", w.bodies, input.body, "body");
            away(w, true, [&](World& world) { expect(world.set_proxy(body, input.desc)); });
          },
          nb::sig(proxy_sig.c_str()), proxy_doc.c_str())
      .def(
          "proxy",
          [](HostWorld& w, nb::object body) {
            const BodyId id = w.resolve("body", w.bodies, body, "body");
            const ProxyState now = away(w, false, [&](World& world) { return expect(world.proxy(id)); });
            nb::dict d;
            d["position"] = tuple3(now.position);
            d["orientation"] = tuple4(now.orientation);
            d["velocity"] = tuple3(now.velocity);
            d["angular_velocity"] = tuple3(now.angular_velocity);
            d["acceleration"] = tuple3(now.acceleration);
            return d;
          },
          "body"_a, nb::sig("def proxy(self, body: Body | str) -> dict[str, tuple[float, ...]]"),
          "Pose and twist of a proxy now, as set_proxy() takes them. Waits.")
      .def(
          "watch_forces",
          [](HostWorld& w, nb::object body, Boolean on) {
            const bool watched = boolean("on", on);
            const BodyId id = w.resolve("body", w.bodies, body, "body");
            away(w, true, [&](World& world) { expect(world.watch_forces(id, watched)); });
          },
          "body"_a, "on"_a = true,
          nb::sig("def watch_forces(self, body: Body | str, on: bool | numpy.bool_ = True) -> None"),
          "Begins, or ends, to sum up what acts on a body. Proxies are always watched.")
      .def(
          "take_forces",
          [](HostWorld& w) {
            const auto all = away(w, false, [](World& world) { return expect(world.take_forces()); });
            return forces_by_name(w, all);
          },
          nb::sig("def take_forces(self) -> dict[str, meltsim._types.Forces]"),
          "What acted on every watched body since the last call, by its name: impulses [N s] and angular "
          "impulses "
          "[N m s] about its centre of mass (of kinematic bodies the pivot) in all and by pressure, "
          "viscosity and "
          "contact, heat received [J], and the seconds that they cover. Gravity is left out. Waits.")
      .def(
          "watch_events",
          [](HostWorld& w, Integer capacity, nb::object kinds) {
            EventWatch what;
            const std::int64_t rows = integer("capacity", capacity);
            if (rows < 0 || rows > 0xffffffffLL)
              refuse("capacity: must be 1 to 1048576 events, got " + std::to_string(rows));
            what.capacity = static_cast<std::uint32_t>(rows);
            if (!kinds.is_none()) {
              what.kinds = 0;
              for (const std::string& kind : texts("kinds", nb::cast<Texts>(kinds)))
                what.kinds |= 1u << choice("kinds", nb::cast(kind), event_names);
            }
            away(w, true, [&](World& world) { expect(world.watch_events(what)); });
          },
          "capacity"_a = 4096, "kinds"_a = nb::none(),
          nb::sig("def watch_events(self, capacity: typing.SupportsIndex = 4096, kinds: Sequence[str] | None "
                  "= None) -> None"),
          "Begins to note events, in a ring of so many. Kinds, all of them by default: \"melted\", "
          "\"frozen\", "
          "\"split\", \"contact_begun\", \"contact_ended\", \"gone\", \"left\".")
      .def(
          "stop_events",
          [](HostWorld& w) { away(w, true, [](World& world) { expect(world.stop_events()); }); },
          "Ends watch_events().")
      .def(
          "take_events",
          [](HostWorld& w) {
            const Events all = away(w, false, [](World& world) { return expect(world.take_events()); });
            return events_by_name(w, all);
          },
          nb::sig("def take_events(self) -> dict[str, Any]"),
          "Events since the last call: \"events\", a list of dicts with kind, step, time [s], position [m], "
          "particle "
          "(id), body and other (names or None), wall (\"-x\" to \"+z\" or None), piece and from (labels of "
          "a split); "
          "\"lost\", how many older ones the ring had no room for; \"counts\" by kind, lost ones included. "
          "Waits.")
      .def(
          "remove", [](HostWorld& w, nb::object what) { remove_any(w, what); }, "body"_a,
          nb::sig("def remove(self, body: Body | ForceField | HeatRegion | Probe | str) -> None"),
          "Removes a body, a force field, a heat region or a probe, by its name, too. Of a body all that is "
          "solid goes, and its name stays taken until compact(); other names are free again. Samples of a "
          "probe that were not taken go with it.")
      .def(
          "remove_liquid",
          [](HostWorld& w, const Shape& shape) {
            return away(w, true, [&](World& world) { return expect(world.remove_liquid(shape)); });
          },
          "shape"_a, "Removes the liquid whose particles have their centres in a shape; returns how many.")
      .def(
          "compact",
          [](HostWorld& w) {
            auto was = away(w, true, [](World& world) { return expect(world.compact()); });
            const auto gone = [&](const Body& b) { return !w.is_there(b); };
            w.bodies.erase(std::remove_if(w.bodies.begin(), w.bodies.end(), gone), w.bodies.end());
            w.removed.clear();
            return array_of<std::uint32_t>(std::move(was));
          },
          "Forgets particles that were removed or have left, and removed bodies, whose names are free again, "
          "so "
          "that a World in which things come and go costs what is there. Ids of particles close up; returns, "
          "per id, the id "
          "that it had.")
      .def(
          "hold",
          [](HostWorld& w, nb::object body, Boolean on) {
            const bool held = boolean("on", on);
            const BodyId id = w.resolve("body", w.bodies, body, "body");
            away(w, true, [&](World& world) { expect(world.hold(id, held)); });
          },
          "body"_a, "on"_a = true, "Holds a free or rigid body where it is, or lets it go.")
      .def(
          "set_velocity",
          [](HostWorld& w, nb::object body, Vector velocity, Vector angular_velocity) {
            const BodyId id = w.resolve("body", w.bodies, body, "body");
            const Vec3d v = vector("velocity", velocity), spin = vector("angular_velocity", angular_velocity);
            away(w, true, [&](World& world) { expect(world.set_velocity(id, v, spin)); });
          },
          "body"_a, "velocity"_a, "angular_velocity"_a = nb::make_tuple(0, 0, 0),
          "Sets the motion of a free body: of its centre of mass [m/s] and about it [rad/s].")
      .def(
          "apply_impulse",
          [](HostWorld& w, nb::object body, Vector impulse, Vector angular_impulse) {
            const BodyId id = w.resolve("body", w.bodies, body, "body");
            const Vec3d p = vector("impulse", impulse), l = vector("angular_impulse", angular_impulse);
            away(w, true, [&](World& world) { expect(world.apply_impulse(id, p, l)); });
          },
          "body"_a, "impulse"_a, "angular_impulse"_a = nb::make_tuple(0, 0, 0),
          "Gives a free body an impulse at its centre of mass [N s] and an angular impulse about it [N m s].")
      .def(
          "set_emitter",
          [](HostWorld& w, nb::object emitter, nb::object on, nb::object speed, nb::object temperature,
             nb::object center, nb::object level) {
            EmitterSetting setting;
            if (!level.is_none()) setting.level = number("level", level);
            if (!center.is_none()) setting.center = vector("center", center);
            if (!on.is_none()) setting.on = boolean("on", on);
            if (!speed.is_none()) setting.speed = number("speed", speed);
            if (!temperature.is_none()) setting.temperature = number("temperature", temperature);
            const EmitterId id = w.resolve("emitter", w.emitters, emitter, "emitter");
            away(w, true, [&](World& world) { expect(world.set_emitter(id, setting)); });
          },
          "emitter"_a, nb::kw_only(), "on"_a = nb::none(), "speed"_a = nb::none(),
          "temperature"_a = nb::none(), "center"_a = nb::none(), "level"_a = nb::none(),
          nb::sig("def set_emitter(self, emitter: Emitter | str, *, on: bool | numpy.bool_ | None = None, "
                  "speed: typing.SupportsFloat | None = None, temperature: typing.SupportsFloat | None = "
                  "None, center: Sequence[typing.SupportsFloat] | numpy.ndarray | None = None, level: "
                  "typing.SupportsFloat | None = None) -> None"),
          "Turns an emitter on or off, changes its speed [m/s] or the temperature of what is to come "
          "[degrees Celsius], moves it [m], or changes the level beyond a face [m].")
      .def(
          "set_gravity",
          [](HostWorld& w, const nb::args& args, const nb::kwargs& kwargs) {
            const Vec3d g = vector("gravity", arguments("set_gravity", {"gravity"}, 1, args, kwargs)[0]);
            away(w, true, [&](World& world) { expect(world.set_gravity(g)); });
          },
          nb::sig("def set_gravity(self, gravity: Sequence[typing.SupportsFloat] | numpy.ndarray) -> None"),
          "Sets gravity [m/s^2]. Not part of snapshots.")
      .def(
          "set_heat_time_scale",
          [](HostWorld& w, const nb::args& args, const nb::kwargs& kwargs) {
            const double x = number("scale", arguments("set_heat_time_scale", {"scale"}, 1, args, kwargs)[0]);
            away(w, true, [&](World& world) { expect(world.set_heat_time_scale(x)); });
          },
          nb::sig("def set_heat_time_scale(self, scale: typing.SupportsFloat) -> None"),
          "Sets how many times faster than motion heat runs; 0 stops heat. Not part of snapshots.")
      .def(
          "set_wall_heat",
          [](HostWorld& w, Text face, nb::kwargs heat) {
            const int index = static_cast<int>(choice("face", face, {"-x", "+x", "-y", "+y", "-z", "+z"}));
            SurfaceHeatDesc desc;
            describe(desc, surface_heat_keys(), "set_wall_heat", 0,
                     nb::args(nb::steal<nb::args>(PyTuple_New(0))), heat);
            away(w, true, [&](World& world) { expect(world.set_wall_heat(index, desc)); });
          },
          "face"_a, "heat"_a,
          nb::sig("def set_wall_heat(self, face: str, *, temperature: typing.SupportsFloat | "
                  "Sequence[tuple[float, float]] | None = ..., "
                  "flux: typing.SupportsFloat | Sequence[tuple[float, float]] = ..., convection: "
                  "typing.SupportsFloat = ..., emissivity: "
                  "typing.SupportsFloat = ..., ambient: typing.SupportsFloat | Sequence[tuple[float, float]] "
                  "= ...) -> None"),
          "Sets the heat through a wall, -x to +z; what is not given is 0, and `ambient` 20 degrees.")
      .def(
          "set_free_surface_heat",
          [](HostWorld& w, nb::kwargs heat) {
            SurfaceHeatDesc desc;
            describe(desc, surface_heat_keys(), "set_free_surface_heat", 0,
                     nb::args(nb::steal<nb::args>(PyTuple_New(0))), heat);
            away(w, true, [&](World& world) { expect(world.set_free_surface_heat(desc)); });
          },
          "heat"_a,
          nb::sig("def set_free_surface_heat(self, *, temperature: typing.SupportsFloat | "
                  "Sequence[tuple[float, float]] | None = ..., flux: "
                  "typing.SupportsFloat | Sequence[tuple[float, float]] = ..., convection: "
                  "typing.SupportsFloat = ..., emissivity: "
                  "typing.SupportsFloat = ..., ambient: typing.SupportsFloat | Sequence[tuple[float, float]] "
                  "= ...) -> None"),
          "Sets the heat through the liquid's free surface; what is not given is 0, and `ambient` 20 "
          "degrees.")
      .def(
          "set_body_heat",
          [](HostWorld& w, nb::object body, Real source, nb::kwargs heat) {
            SurfaceHeatDesc desc;
            describe(desc, surface_heat_keys(), "set_body_heat", 0,
                     nb::args(nb::steal<nb::args>(PyTuple_New(0))), heat);
            const double released = number("source", source);
            const BodyId id = w.resolve("body", w.bodies, body, "body");
            away(w, true, [&](World& world) { expect(world.set_body_heat(id, desc, released)); });
          },
          "body"_a, nb::kw_only(), "source"_a = 0.0, "heat"_a,
          nb::sig(
              "def set_body_heat(self, body: Body | str, *, source: typing.SupportsFloat = 0.0, temperature: "
              "typing.SupportsFloat | Sequence[tuple[float, float]] | None = ..., flux: typing.SupportsFloat "
              "| "
              "Sequence[tuple[float, float]] = ..., convection: typing.SupportsFloat = ..., emissivity: "
              "typing.SupportsFloat = ..., ambient: typing.SupportsFloat | Sequence[tuple[float, float]] = "
              "...) -> "
              "None"),
          "Sets the heat through the dry surface of a body, and what is released in it [W/m^3]; what is not "
          "given is 0, and "
          "`ambient` 20 degrees.")
      .def(
          "set_heat_region",
          [](HostWorld& w, nb::object region, nb::object temperature, Real source) {
            std::optional<double> held;
            if (!temperature.is_none()) held = number("temperature", temperature);
            const double released = number("source", source);
            const HeatRegionId id = w.resolve("region", w.regions, region, "heat region");
            away(w, true, [&](World& world) { expect(world.set_heat_region(id, held, released)); });
          },
          "region"_a, nb::kw_only(), "temperature"_a = nb::none(), "source"_a = 0.0,
          nb::sig("def set_heat_region(self, region: HeatRegion | str, *, temperature: typing.SupportsFloat "
                  "| None = None, source: typing.SupportsFloat = 0.0) -> None"),
          "Sets what a heat region does: it holds a temperature [degrees Celsius] or releases heat [W/m^3].")
      .def(
          "move_heat_region",
          [](HostWorld& w, nb::object region, nb::object displacement, nb::object velocity) {
            const Vec3d by = vector("displacement", displacement), goes = vector("velocity", velocity);
            const HeatRegionId id = w.resolve("region", w.regions, region, "heat region");
            away(w, true, [&](World& world) { expect(world.move_heat_region(id, by, goes)); });
          },
          "region"_a, "displacement"_a, "velocity"_a = nb::make_tuple(0.0, 0.0, 0.0),
          nb::sig("def move_heat_region(self, region: HeatRegion | str, displacement: Sequence[float], "
                  "velocity: Sequence[float] = (0.0, 0.0, 0.0)) -> None"),
          "Moves a heat region: its shape lies `displacement` [m] from where it was built, and goes on at "
          "`velocity` [m/s].")
      .def(
          "prepare", [](HostWorld& w) { away(w, true, [](World& world) { expect(world.prepare()); }); },
          "Allocates and plans for the next step; step() does it if it was not called.")
      .def(
          "settle",
          [](HostWorld& w, nb::object seconds) {
            const double given =
                seconds.is_none() ? automatic : number("seconds", seconds, "a number or None");
            Settled came_to;
            w.advance([&](World& world) -> Status {
              auto result = world.settle(given);
              if (!result) return result.error();
              came_to = *result;
              return {};
            });
            return came_to;
          },
          "seconds"_a = nb::none(),
          nb::sig("def settle(self, seconds: typing.SupportsFloat | None = None) -> Settled"),
          "Lets liquid come to rest before the first step, with bodies held, so that forces on what it "
          "touches "
          "are those of rest from then on. None: as long as depth and speed of sound ask for. Liquid that "
          "nothing holds flows meanwhile: Settled.farthest says how far.")
      .def(
          "step",
          [](HostWorld& w, const nb::args& args, const nb::kwargs& kwargs) {
            w.step(number("seconds", arguments("step", {"seconds"}, 1, args, kwargs)[0]));
          },
          nb::sig("def step(self, seconds: typing.SupportsFloat) -> None"),
          "Advances by so many seconds, in sub-steps that keep it stable. Other threads run meanwhile. "
          "Ctrl-C, or the stop button of a "
          "notebook, ends it between sub-steps with KeyboardInterrupt, or with what the host's own handler "
          "raises "
          "(if that returns, with Error.code \"interrupted\"): `time` then says how far it came, and "
          "step() goes on from there.")
      .def(
          "step_within",
          [](HostWorld& w, const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("step_within", {"seconds", "milliseconds"}, 2, args, kwargs);
            const double dt = number("seconds", a[0]), budget = number("milliseconds", a[1]);
            return timed(w, [&](World& world) { return world.step_within(dt, budget); });
          },
          nb::sig("def step_within(self, seconds: typing.SupportsFloat, milliseconds: typing.SupportsFloat) "
                  "-> TimedStep"),
          "As step(), but ends when so much wall time is used up; says how far it came and what it owes. "
          "At least one sub-step is taken.")
      .def(
          "step_part",
          [](HostWorld& w, const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("step_part", {"seconds", "substeps"}, 2, args, kwargs);
            const double dt = number("seconds", a[0]);
            const std::int64_t count = integer("substeps", a[1]);
            if (count < 0) refuse("substeps: must be 0 or more, got " + std::to_string(count));
            return timed(
                w, [&](World& world) { return world.step_part(dt, static_cast<std::uint64_t>(count)); });
          },
          nb::sig("def step_part(self, seconds: typing.SupportsFloat, substeps: typing.SupportsIndex) -> "
                  "TimedStep"),
          "Takes the first sub-steps of step(): repeats a step_within() that took as many, to the bit.")
      .def(
          "synchronize",
          [](HostWorld& w) {
            return away(w, false, [](World& world) {
              StepResult result = world.synchronize();
              if (!result.error.empty()) throw LibraryError({ErrorCode::out_of_memory, result.error});
              return result;
            });
          },
          "Waits for all steps and reports on them.")
      .def(
          "interrupt", [](HostWorld& w) { w.unguarded().interrupt(); },
          "Ends the running step(), or the next one, with Error.code \"interrupted\". From any thread.")
      .def(
          "stable_dt",
          [](HostWorld& w) { return away(w, false, [](World& world) { return world.stable_dt(); }); },
          "Largest sub-step that is stable [s].")
      .def(
          "totals",
          [](HostWorld& w) { return away(w, false, [](World& world) { return expect(world.totals()); }); },
          "Conserved quantities and extremes.")
      .def(
          "ledger",
          [](HostWorld& w) { return away(w, false, [](World& world) { return expect(world.ledger()); }); },
          "Conserved quantities, summed by the backend.")
      .def(
          "particles",
          [](HostWorld& w) { return away(w, false, [](World& world) { return expect(world.particles()); }); },
          "All particles, sorted by id: a copy.")
      .def(
          "pieces",
          [](HostWorld& w) { return away(w, false, [](World& world) { return expect(world.pieces()); }); },
          "Connected pieces of all bodies.")
      .def("request", &request, nb::sig("def request(self, *parts: str) -> int"),
           "Enqueues a reading behind the steps so far and returns its ticket, without waiting: \"totals\", "
           "\"forces\", "
           "\"events\", \"pieces\", \"particles\", \"samples\". At most four are open.")
      .def(
          "ready",
          [](HostWorld& w, Integer ticket) {
            const ReadTicket of = ticket_of(ticket);
            return away(w, false, [&](World& world) { return expect(world.ready(of)); });
          },
          "ticket"_a, "Whether take() would return at once.")
      .def("take", &take, "ticket"_a, nb::sig("def take(self, ticket: typing.SupportsIndex) -> Reading"),
           "Waits for that reading, not for steps behind it, and closes the ticket.")
      .def("state", &HostWorld::state, nb::sig("def state(self) -> State"),
           "Views of the World's own memory, without a copy. Waits for all steps.")
      .def(
          "state_hash",
          [](HostWorld& w) {
            return away(w, false, [](World& world) { return expect(world.state_hash()); });
          },
          "Equal states give equal hashes.")
      .def(
          "snapshot",
          [](HostWorld& w) {
            const auto bytes = away(w, false, [](World& world) { return expect(world.snapshot()); });
            return nb::bytes(bytes.data(), bytes.size());
          },
          "The state, for restore().")
      .def(
          "restore",
          [](HostWorld& w, nb::object snapshot) {
            snapshot = bytes_of("snapshot", "snapshot()", std::move(snapshot));
            const auto* data = PyBytes_AS_STRING(snapshot.ptr());
            const auto size = static_cast<std::size_t>(PyBytes_GET_SIZE(snapshot.ptr()));
            const auto all = away(w, true, [&](World& world) {
              expect(world.restore(data, size));
              return expect(world.bodies());
            });
            w.removed.clear();  // a snapshot may have bodies that were removed since, or lack others
            for (const Body& body : w.bodies)
              if (std::none_of(all.begin(), all.end(), [&](const BodyInfo& b) { return b.body == body.id; }))
                w.removed.push_back(body.id);
          },
          "snapshot"_a, nb::sig("def restore(self, snapshot: bytes | bytearray | memoryview) -> None"),
          "Goes back to a snapshot of a World with the same materials and bodies. On an error the World is "
          "unchanged.")
      .def(
          "save",
          [](HostWorld& w) {
            const auto bytes = away(w, false, [](World& world) { return expect(world.save()); });
            return nb::bytes(bytes.data(), bytes.size());
          },
          "The state and the bodies that it is of, for load_saved(): a saved game.")
      .def(
          "load_saved",
          [](HostWorld& w, nb::object saved) {
            saved = bytes_of("saved", "save()", std::move(saved));
            const auto* data = PyBytes_AS_STRING(saved.ptr());
            const auto size = static_cast<std::size_t>(PyBytes_GET_SIZE(saved.ptr()));
            const auto all = away(w, true, [&](World& world) {
              expect(world.load_saved(data, size));
              return expect(world.bodies());
            });
            w.bodies.clear();
            w.removed.clear();
            for (const BodyInfo& b : all) w.bodies.push_back({w.serial(), b.body, b.name});
          },
          "saved"_a, nb::sig("def load_saved(self, saved: bytes | bytearray | memoryview) -> None"),
          "Makes state and bodies those of a saved World with the same materials and emitters, whatever "
          "bodies "
          "there are here; "
          "bodies has the new ones. On an error the World is unchanged.")
      .def(
          "take_samples",
          [](HostWorld& w) {
            return samples_by_name(w,
                                   away(w, false, [](World& world) { return expect(world.take_samples()); }));
          },
          nb::sig("def take_samples(self) -> dict[str, dict[str, numpy.ndarray]]"),
          "Samples of every probe since the last call, by name: \"time\" (samples,) and \"values\" (samples, "
          "points, values).")
      .def(
          "sample",
          [](HostWorld& w, ArrayLike where, Texts fields) {
            const auto p = points("points", where);
            const auto names = texts("fields", fields);
            auto values = away(w, false, [&](World& world) { return expect(world.sample(p, names)); });
            return array_of<double>(std::move(values))
                .attr("reshape")(p.size(), static_cast<int>(sample_columns(names).size()));
          },
          nb::sig("def sample(self, points: numpy.typing.ArrayLike, fields: str | Sequence[str]) -> "
                  "numpy.ndarray"),
          "Fields at points of shape (n, 3) [m], of the present state: float64 (n, values). NaN where there "
          "is nothing.")
      .def(
          "surface",
          [](HostWorld& w, nb::object of_what, Real cell, Text kernel, Integer smoothing, Boolean closed) {
            const SurfaceDesc desc = surface_desc(w, of_what, cell, kernel, smoothing, closed);
            refuse_while_surfaced(w, "surface");
            return away(w, false, [&](World& world) { return expect(world.surface(desc)); });
          },
          "of"_a = "liquid", nb::kw_only(), "cell"_a = 0.0, "kernel"_a = "isotropic", "smoothing"_a = 4,
          "closed_at_solids"_a = false,
          "The surface of \"liquid\", \"solids\" or a body, by its name, too, as triangles.")
      .def(
          "surface_view",
          [](HostWorld& w, nb::object of_what, Real cell, Text kernel, Integer smoothing, Boolean closed,
             Boolean wait) {
            SurfaceDesc desc = surface_desc(w, of_what, cell, kernel, smoothing, closed);
            desc.wait = boolean("wait", wait);
            refuse_while_surfaced(w, "surface_view");
            auto pack = std::make_unique<SurfacePack>();
            const HostWorld::Use world(w);
            {
              const nb::gil_scoped_release released;
              pack->view = expect(world->surface_view(desc));
              if (desc.wait)
                world->synchronize();  // arrays are used on streams that the World has no part in
            }
            pack->owner = nb::find(&w);
            pack->world = &w;
            return nb::cast(pack.release(), nb::rv_policy::take_ownership);
          },
          "of"_a = "liquid", nb::kw_only(), "cell"_a = 0.0, "kernel"_a = "isotropic", "smoothing"_a = 4,
          "closed_at_solids"_a = false, "wait"_a = true,
          nb::sig("def surface_view(self, of: Any = \"liquid\", *, cell: typing.SupportsFloat = 0.0, kernel: "
                  "str = \"isotropic\", smoothing: typing.SupportsIndex = 4, closed_at_solids: bool | "
                  "numpy.bool_ = False, wait: bool | numpy.bool_ = True) -> SurfaceView"),
          "The same as arrays in the memory of the backend, without a copy. wait=False: nothing waits on "
          "CUDA; arrays are as "
          "long as there is room for, draw says how much of them there is, and they are used on stream.")
      .def(
          "render_view",
          [](HostWorld& w, nb::object color, Real coldest, Real hottest, nb::object colors, Boolean wait) {
            RenderDesc desc;
            const bool waits = boolean("wait", wait);
            if (!color.is_none())
              desc.color = static_cast<ColorBy>(1 + choice("color", color, {"material", "temperature"}));
            desc.coldest = number("coldest", coldest);
            desc.hottest = number("hottest", hottest);
            if (!colors.is_none())
              for (nb::handle one : colors) {
                const std::int64_t c = integer("colors", one);
                if (c < 0 || c > 0xffffffffLL)
                  refuse("colors: expected numbers of 32 bits, got " + std::to_string(c));
                desc.colors.push_back(static_cast<std::uint32_t>(c));
              }
            if (w.packed > 0)
              refuse("render_view: " + std::to_string(w.packed) +
                     " array(s) of the one before still view its memory; delete them first, or keep a copy "
                     "(array.copy())");
            auto pack = std::make_unique<RenderPack>();
            const HostWorld::Use world(w);
            {
              const nb::gil_scoped_release released;
              pack->view = expect(world->render_view(desc));
              if (waits) world->synchronize();  // arrays are used on streams that the World has no part in
            }
            pack->owner = nb::find(&w);
            pack->world = &w;
            pack->pack = ++w.packs;
            return nb::cast(pack.release(), nb::rv_policy::take_ownership);
          },
          nb::kw_only(), "color"_a = nb::none(), "coldest"_a = 0.0, "hottest"_a = 100.0,
          "colors"_a = nb::none(), "wait"_a = true,
          nb::sig("def render_view(self, *, color: str | None = None, coldest: typing.SupportsFloat = 0.0, "
                  "hottest: typing.SupportsFloat = 100.0, colors: Sequence[typing.SupportsIndex] | None = "
                  "None, wait: bool | numpy.bool_ = True) -> RenderPack"),
          "Packs particles by id for a renderer. color: \"material\" (an entry of colors each) or "
          "\"temperature\" (even "
          "steps from coldest to hottest [degrees Celsius]); colors: red in the lowest byte, then green, "
          "blue, opacity; "
          "None: a palette, a ramp. Waits for all steps, unless wait=False: on CUDA the arrays are then used "
          "on "
          "stream.")
      .def(
          "cast_rays",
          [](HostWorld& w, ArrayLike origins, ArrayLike directions, nb::object length, Texts of) {
            const auto from = points("origins", origins), along = points("directions", directions);
            if (from.size() != along.size())
              refuse("directions: expected as many as origins, " + std::to_string(from.size()) + ", got " +
                     std::to_string(along.size()));
            const double reach = length.is_none() ? infinity : number("length", length);
            std::uint32_t sought = 0;
            for (const std::string& what : texts("of", of))
              sought |= 1u << choice("of", nb::cast(what), {"liquid", "bodies", "walls"});
            std::vector<Ray> rays;
            for (std::size_t k = 0; k < from.size(); ++k) rays.push_back({from[k], along[k], reach});
            const auto hits = away(w, false, [&](World& world) {
              return rays.empty() ? std::vector<RayHit>() : expect(world.cast_rays(rays, sought));
            });
            std::vector<std::int32_t> what, body, wall;
            std::vector<double> distance;
            std::vector<Vec3d> point, normal;
            for (const RayHit& h : hits) {
              what.push_back(static_cast<std::int32_t>(h.what));
              body.push_back(h.body ? static_cast<std::int32_t>(h.body.index) : -1);
              wall.push_back(h.wall);
              distance.push_back(h.distance);
              point.push_back(h.point);
              normal.push_back(h.normal);
            }
            nb::dict d;
            d["what"] = array_of<std::int32_t>(std::move(what));
            d["distance"] = array_of<double>(std::move(distance));
            d["point"] = array_of<double>(std::move(point), 3);
            d["normal"] = array_of<double>(std::move(normal), 3);
            d["body"] = array_of<std::int32_t>(std::move(body));
            d["wall"] = array_of<std::int32_t>(std::move(wall));
            return d;
          },
          "origins"_a, "directions"_a, nb::kw_only(), "length"_a = nb::none(),
          "of"_a = nb::make_tuple("liquid", "bodies", "walls"),
          nb::sig("def cast_rays(self, origins: numpy.typing.ArrayLike, directions: numpy.typing.ArrayLike, "
                  "*, length: typing.SupportsFloat | None = None, of: str | Sequence[str] = (\"liquid\", "
                  "\"bodies\", \"walls\")) -> dict[str, numpy.ndarray]"),
          "Where rays from origins along directions, (n, 3) each, first meet liquid, bodies or walls: "
          "\"what\" (0 nothing, 1 "
          "liquid, 2 a body, 3 a wall), \"distance\" [m], \"point\" and \"normal\" (n, 3), \"body\" (index "
          "in the order "
          "of adding, or -1), \"wall\" (0 to 5 for -x to +z, or -1). Waits.")
      .def(
          "overlap",
          [](HostWorld& w, const Shape& shape) {
            const Overlap o = away(w, false, [&](World& world) { return expect(world.overlap(shape)); });
            nb::dict d, bodies;
            for (const BodyOverlap& b : o.bodies)
              for (const Body& body : w.bodies)
                if (body.id == b.body) bodies[body.name.c_str()] = b.particles;
            d["liquid"] = o.liquid;
            d["liquid_volume"] = o.liquid_volume;
            d["bodies"] = bodies;
            return d;
          },
          "shape"_a, nb::sig("def overlap(self, shape: Shape) -> dict[str, Any]"),
          "What has its centre in a shape: \"liquid\", particles; \"liquid_volume\" at rest [m^3]; "
          "\"bodies\", particles by "
          "name. Waits, and copies the particles in the shape's box.")
      .def(
          "add_stage",
          [](HostWorld& w, Text name, nb::object function, Text after, Texts reads, Texts writes,
             Boolean recorded) {
            const std::vector<std::string> written = texts("writes", writes);
            for (const char* fixed : {"enthalpy", "id", "tag"})
              if (std::find(written.begin(), written.end(), fixed) != written.end())
                refuse(std::string("writes: a stage reads \"") + fixed +
                       "\" and cannot change it; it writes acceleration, velocity and position");
            w.add_stage(text("name", name), function, text("after", after), texts("reads", reads), written,
                        boolean("recorded", recorded));
          },
          "name"_a, "function"_a, nb::kw_only(), "after"_a = "sph.forces",
          "reads"_a = nb::make_tuple("position", "velocity", "tag"),
          "writes"_a = nb::make_tuple("acceleration"), "recorded"_a = false,
          "Calls function(state) in every sub-step, after a built-in stage. It adds to state.acceleration, "
          "and may "
          "write velocity and position; "
          "recorded: what it launches on state.stream is the same every time, and CUDA repeats it without "
          "calling it; "
          "its arrays hold until it returns. "
          "An exception in it ends the step and comes out of step().")
      .def(
          "remove_stage", [](HostWorld& w, Text name) { w.remove_stage(text("name", name)); }, "name"_a,
          "Removes a stage of add_stage().")
      .def(
          "set_interval",
          [](HostWorld& w, Text module, Integer n) {
            const std::string name = text("module", module);
            const int interval = small("n", n);
            away(w, true, [&](World& world) { expect(world.scheduler().set_interval(name, interval)); });
          },
          "module"_a, "n"_a,
          "Runs the stages of a module only in every n-th sub-step: \"thermal\" (heat_interval: within a "
          "step) "
          "and \"topology\" only.")
      .def(
          "enable",
          [](HostWorld& w, Text module, Boolean on) {
            const std::string name = text("module", module);
            const bool enabled = boolean("on", on);
            away(w, true, [&](World& world) { expect(world.scheduler().enable(name, enabled)); });
          },
          "module"_a, "on"_a = true,
          "Switches a module off, or on again: \"sph\", \"lsm\", \"thermal\", \"species\", \"topology\".")
      .def(
          "enable_timings",
          [](HostWorld& w, Boolean on, Integer every) {
            const bool timed = boolean("on", on);
            const int n = small("every", every);
            away(w, true, [&](World& world) { expect(world.scheduler().enable_timings(timed, n)); });
          },
          "on"_a = true, nb::kw_only(), "every"_a = 400,
          "Times the stages in one of `every` sub-steps, for stages() and plan().")
      .def("stages", stages, nb::sig("def stages(self) -> list[dict[str, Any]]"),
           "The stages of a sub-step in order: \"name\", \"module\", \"runs\" and \"reason\", \"interval\" "
           "[sub-steps], \"median_ms\" of enable_timings() (0: none was timed).")
      .def(
          "plan",
          [](HostWorld& w) { return away(w, true, [](World& world) { return world.plan().to_string(); }); },
          "The stages of a sub-step, as a table.")
      .def("record", &HostWorld::record, "Keeps the present state as a frame for show().")
      .def("clear_frames", &HostWorld::clear_frames,
           "Forgets the frames of run() and record() and gives their memory back.")
      .def_prop_ro(
          "frames", [](HostWorld& w) { return w.unguarded(), w.frames(); },
          "How many frames run() and record() have recorded since clear_frames().")
      .def(
          "_page",
          [](HostWorld& w, const std::string& title) {
            const HostWorld::Use use(w);
            return w.page(title);
          },
          "title"_a)
      .def_prop_ro(
          "resolved",
          [](HostWorld& w) { return away(w, false, [](World& world) { return world.resolved(); }); },
          "Values that the World derived.")
      .def_prop_ro(
          "time", [](HostWorld& w) { return w.unguarded().time(); }, "Simulated time [s].")
      .def_prop_ro(
          "steps", [](HostWorld& w) { return w.unguarded().steps(); }, "Sub-steps so far.")
      .def_prop_ro(
          "backend", [](HostWorld& w) { return backends[static_cast<std::size_t>(w.unguarded().backend())]; },
          "\"cpu\" or \"cuda\".")
      .def_prop_ro(
          "spacing", [](HostWorld& w) { return w.unguarded().desc().spacing; }, "Distance of particles [m].")
      .def_prop_ro(
          "max_substeps", [](HostWorld& w) { return w.unguarded().desc().max_substeps; },
          "Most sub-steps of one step.")
      .def_prop_ro(
          "precision",
          [](HostWorld& w) { return precisions[static_cast<std::size_t>(w.unguarded().precision())]; },
          "\"single\" or \"double\": of the state.")
      .def_prop_ro("materials", by_name(&HostWorld::materials),
                   nb::sig("def materials(self) -> dict[str, Material]"), "Its materials by name.")
      .def_prop_ro("bodies", by_name(&HostWorld::bodies), nb::sig("def bodies(self) -> dict[str, Body]"),
                   "Its bodies by name, without those that were removed.")
      .def_prop_ro("emitters", by_name(&HostWorld::emitters),
                   nb::sig("def emitters(self) -> dict[str, Emitter]"), "Its emitters by name.")
      .def_prop_ro("heat_regions", by_name(&HostWorld::regions),
                   nb::sig("def heat_regions(self) -> dict[str, HeatRegion]"), "Its heat regions by name.")
      .def_prop_ro("force_fields", by_name(&HostWorld::fields),
                   nb::sig("def force_fields(self) -> dict[str, ForceField]"), "Its force fields by name.")
      .def_prop_ro("probes", by_name(&HostWorld::probes), nb::sig("def probes(self) -> dict[str, Probe]"),
                   "Its probes by name, those of its scene included.");
}

}  // namespace meltsim_python
