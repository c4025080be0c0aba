// SPDX-License-Identifier: Apache-2.0
// What is read from a World: plain values with named members, arrays without a copy.
#include <cstring>
#include <functional>
#include <memory>

#include "common.hpp"

namespace meltsim_python {

namespace {

/// A class of values. Every member is in its docstring, in repr() and in as_dict().
template <class T>
class Record {
 public:
  Record(nb::module_& m, const char* name, const char* doc) : name_(name), class_(m, name, doc) {
    class_.def(
        "as_dict", [keys = keys_](nb::handle self) { return dict(self, *keys); },
        nb::sig("def as_dict(self) -> dict[str, Any]"), "The same values as a dict.");
    class_.def(
        "__getstate__",
        [fields = fields_](const T& t) {
          nb::list values;
          for (const Field& field : *fields) values.append(field.get(t));
          return nb::tuple(values);
        },
        nb::sig("def __getstate__(self) -> tuple[Any, ...]"));
    class_.def(
        "__setstate__",
        [fields = fields_, name = name_](T& t, const nb::tuple& values) {
          if (values.size() != fields->size())
            wrong_type(name + ": the state is of another version of meltsim: it has " +
                       std::to_string(values.size()) + " values, not " + std::to_string(fields->size()));
          T read;
          for (std::size_t i = 0; i < values.size(); ++i) (*fields)[i].set(read, values[i]);
          new (&t) T(std::move(read));
        },
        nb::sig("def __setstate__(self, state: tuple[Any, ...], /) -> None"));
    class_.def("__repr__", [keys = keys_, name = name_](nb::handle self) {
      std::string text = "<meltsim." + name;
      const char* gap = ": ";
      for (const std::string& key : *keys) {
        text += gap + key + "=" + to_text(self.attr(key.c_str()));
        gap = ", ";
      }
      return text + ">";
    });
  }
  template <class M>
  Record& add(const char* key, M T::*member, const char* doc) {
    keys_->push_back(key);
    keep(member);
    if constexpr (std::is_same_v<M, meltsim::Vec3d>)
      class_.def_prop_ro(
          key, [member](const T& t) { return tuple3(t.*member); }, doc);
    else class_.def_ro(key, member, doc);
    return *this;
  }
  /// What copies and pickles have.
  template <class M>
  Record& keep(M T::*member) {
    if constexpr (std::is_same_v<M, meltsim::Vec3d>)
      return keep([member](const T& t) { return nb::object(tuple3(t.*member)); },
                  [member](T& t, nb::handle v) { t.*member = vector("state", v); });
    else
      return keep([member](const T& t) { return nb::object(nb::cast(t.*member)); },
                  [member](T& t, nb::handle v) { t.*member = nb::cast<M>(v); });
  }
  Record& keep(std::function<nb::object(const T&)> get, std::function<void(T&, nb::handle)> set) {
    fields_->push_back({std::move(get), std::move(set)});
    return *this;
  }
  nb::class_<T>& get() { return class_; }

 private:
  struct Field {
    std::function<nb::object(const T&)> get;
    std::function<void(T&, nb::handle)> set;
  };
  static nb::dict dict(nb::handle self, const std::vector<std::string>& keys) {
    nb::dict values;
    for (const std::string& key : keys) values[key.c_str()] = self.attr(key.c_str());
    return values;
  }
  std::string name_;
  nb::class_<T> class_;
  std::shared_ptr<std::vector<std::string>> keys_ = std::make_shared<std::vector<std::string>>();
  std::shared_ptr<std::vector<Field>> fields_ = std::make_shared<std::vector<Field>>();
};

/// Numbers that lie one after another in a member of T.
template <class T, class M>
void keep_numbers(Record<T>& record, M T::*member) {
  constexpr std::size_t count = sizeof(M) / sizeof(double);
  static_assert(std::is_trivially_copyable_v<M> && sizeof(M) == count * sizeof(double), "doubles");
  record.keep(
      [member](const T& t) {
        double values[count];
        std::memcpy(values, &(t.*member), sizeof values);
        nb::list list;
        for (const double x : values) list.append(x);
        return nb::object(nb::tuple(list));
      },
      [member](T& t, nb::handle v) {
        const auto list = nb::cast<std::vector<double>>(v);
        if (list.size() != count) wrong_type("state: expected " + std::to_string(count) + " numbers");
        std::memcpy(static_cast<void*>(&(t.*member)), list.data(), sizeof(M));
      });
}

template <class T, class V>
auto column(std::vector<V> meltsim::ParticleData::*member, std::size_t columns = 1) {
  return [member, columns](nb::handle self) {
    const auto& values = nb::cast<const meltsim::ParticleData&>(self).*member;
    std::vector<std::size_t> shape{values.size()};
    if (columns > 1) shape.push_back(columns);
    return array_view<T>(reinterpret_cast<const T*>(values.data()), shape, self);
  };
}

template <class T, class F>
auto of_tag(F f) {
  return [f](const meltsim::ParticleData& p) {
    using Item =
        std::conditional_t<std::is_same_v<T, bool>, unsigned char, T>;  // std::vector<bool> has no array
    static_assert(sizeof(bool) == 1, "NumPy's bool");
    std::vector<Item> values(p.tag.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<Item>(f(p.tag[i]));
    return array_of<T>(std::move(values));
  };
}

/// What copies, pickles and as_dict() of particles have: every array, by its name.
const std::vector<std::string> particle_arrays{"id",          "position", "velocity",        "mass",
                                               "temperature", "enthalpy", "liquid_fraction", "density",
                                               "pressure",    "tag",      "piece",           "fractions"};

nb::dict particles_as_dict(nb::handle self) {
  nb::dict d;
  for (const std::string& name : particle_arrays) d[name.c_str()] = self.attr(name.c_str());
  return d;
}

/// `species` has no array: it is kept beside them.
nb::tuple particles_state(nb::handle self) {
  nb::list species;
  for (const meltsim::MaterialId id : nb::cast<const meltsim::ParticleData&>(self).species)
    species.append(nb::make_tuple(id.index, id.generation));
  return nb::make_tuple(particles_as_dict(self), species);
}

template <class T, class V>
void read_column(std::vector<V>& values, nb::handle array, std::size_t columns = 1) {
  const auto view = nb::cast<nb::ndarray<const T, nb::c_contig, nb::device::cpu>>(
      nb::module_::import_("numpy").attr("ascontiguousarray")(array));
  if (view.size() % columns != 0) wrong_type("state: expected arrays of particles");
  const auto* first = reinterpret_cast<const V*>(view.data());
  values.assign(first, first + view.size() / columns);
}

void set_particles_state(meltsim::ParticleData& to, const nb::tuple& state) {
  meltsim::ParticleData p;
  const nb::dict d = nb::cast<nb::dict>(state[0]);
  read_column<std::uint32_t>(p.id, d["id"]);
  read_column<double>(p.position, d["position"], 3);
  read_column<double>(p.velocity, d["velocity"], 3);
  for (const auto& [name, values] :
       {std::pair{"mass", &p.mass}, std::pair{"temperature", &p.temperature},
        std::pair{"enthalpy", &p.enthalpy}, std::pair{"liquid_fraction", &p.liquid_fraction},
        std::pair{"density", &p.density}, std::pair{"pressure", &p.pressure}})
    read_column<double>(*values, d[name]);
  read_column<std::uint32_t>(p.tag, d["tag"]);
  read_column<std::uint32_t>(p.piece, d["piece"]);
  for (nb::handle one : nb::cast<nb::list>(d["fractions"]))
    read_column<double>(p.fractions.emplace_back(), one);
  for (nb::handle one : nb::cast<nb::list>(state[1])) {
    const auto pair = nb::cast<std::vector<std::uint32_t>>(one);
    p.species.push_back({pair.at(0), pair.at(1)});
  }
  const std::size_t n = p.id.size();
  const auto as_long = [n](const auto&... columns) { return ((columns.size() == n) && ...); };
  bool whole = as_long(p.position, p.velocity, p.mass, p.temperature, p.enthalpy, p.liquid_fraction,
                       p.density, p.pressure, p.tag, p.piece);
  for (const auto& one : p.fractions) whole = whole && as_long(one);
  if (!whole) wrong_type("state: expected arrays of one length");
  new (&to) meltsim::ParticleData(std::move(p));
}

template <class T, class V>
auto vertex_column(std::vector<V> meltsim::SurfaceMesh::*member, std::size_t columns = 1) {
  return [member, columns](nb::handle self) {
    const auto& values = nb::cast<const meltsim::SurfaceMesh&>(self).*member;
    std::vector<std::size_t> shape{values.size() * sizeof(V) / sizeof(T) / columns};
    if (columns > 1) shape.push_back(columns);
    return array_view<T>(reinterpret_cast<const T*>(values.data()), shape, self);
  };
}

template <class T, class V>
auto frame_column(std::vector<V> meltsim::ParticleFrame::*member, std::size_t columns = 1) {
  return [member, columns](nb::handle self) {
    const auto& values = nb::cast<const meltsim::ParticleFrame&>(self).*member;
    std::vector<std::size_t> shape{values.size()};
    if (columns > 1) shape.push_back(columns);
    return array_view<T>(reinterpret_cast<const T*>(values.data()), shape, self);
  };
}

void bind_frame(nb::module_& m) {
  using meltsim::ParticleFrame;
  nb::class_<ParticleFrame>(m, "ParticleFrame",
                            "Particles of a Reading, sorted by id, in single precision. Arrays are parallel "
                            "and share its memory.")
      .def("__len__", [](const ParticleFrame& p) { return p.id.size(); })
      .def("__repr__",
           [](const ParticleFrame& p) {
             return "<meltsim.ParticleFrame: " + std::to_string(p.id.size()) + ">";
           })
      .def_prop_ro(
          "origin", [](const ParticleFrame& p) { return tuple3(p.origin); },
          "Positions are relative to it [m].")
      .def_prop_ro("id", frame_column<std::uint32_t>(&ParticleFrame::id), "Ascending, uint32 (n,)")
      .def_prop_ro("position", frame_column<float>(&ParticleFrame::position, 3), "[m], float32 (n, 3)")
      .def_prop_ro("velocity", frame_column<float>(&ParticleFrame::velocity, 3), "[m/s], float32 (n, 3)")
      .def_prop_ro("temperature", frame_column<float>(&ParticleFrame::temperature),
                   "[degrees Celsius], float32 (n,)")
      .def_prop_ro("liquid_fraction", frame_column<float>(&ParticleFrame::liquid_fraction),
                   "0 solid to 1 liquid, float32 (n,)")
      .def_prop_ro("density", frame_column<float>(&ParticleFrame::density),
                   "[kg/m^3], 0 before the first step, float32 (n,)")
      .def_prop_ro("pressure", frame_column<float>(&ParticleFrame::pressure),
                   "[Pa], 0 for solids, float32 (n,)")
      .def_prop_ro("tag", frame_column<std::uint32_t>(&ParticleFrame::tag),
                   "Bits of meltsim/particle_tag.hpp, uint32 (n,)")
      .def_prop_ro("piece", frame_column<std::uint32_t>(&ParticleFrame::piece),
                   "Label of the connected piece, 0 for liquid, uint32 (n,)");
}

}  // namespace

void bind_readings(nb::module_& m) {
  using namespace meltsim;
  Record<StepResult>(m, "StepResult", "Report on the steps since the last synchronize().")
      .add("steps", &StepResult::steps, "Sub-steps completed since the World was created.")
      .add("time", &StepResult::time, "Simulated time [s].")
      .add("max_speed", &StepResult::max_speed, "Largest speed since the last report [m/s].")
      .add("max_density_ratio", &StepResult::max_density_ratio,
           "Largest rho/rho0 of the liquid since the last report.")
      .add("halted", &StepResult::halted,
           "Whether the simulation diverged; the World keeps its last good state.")
      .add("halt_reason", &StepResult::halt_reason, "Step, particle, body and stage.")
      .add("courant_exceeded", &StepResult::courant_exceeded,
           "A particle moved further than 0.4 H in one sub-step.")
      .add("heat_bound_exceeded", &StepResult::heat_bound_exceeded,
           "Heat was exchanged faster than its stages allow.")
      .add("viscous_bound_exceeded", &StepResult::viscous_bound_exceeded,
           "Momentum diffused faster than its stages allow.")
      .add("modulus_unreachable", &StepResult::modulus_unreachable,
           "A body is softer than its youngs_modulus.")
      .add("body_stiffened", &StepResult::body_stiffened, "A body is stiffer than described.")
      .add("level_bared", &StepResult::level_bared,
           "Liquid below the level of a hydrostatic field has a free surface.")
      .add("cooled_to_zero", &StepResult::cooled_to_zero,
           "A particle that would have cooled below 0 K was held there.")
      .add("emitter_exhausted", &StepResult::emitter_exhausted,
           "An emitter stopped: at its max_particles, or a closed domain is full.")
      .add("removed", &StepResult::removed, "Particles that left through open faces so far.")
      .add("entered", &StepResult::entered,
           "Particles that came in below the level of an emitter, or from one that recycles, so far.")
      .add("strayed", &StepResult::strayed, "Liquid particles that fell out of the scene so far.")
      .add("melted", &StepResult::melted, "Particles that melted so far.")
      .add("frozen", &StepResult::frozen, "Particles that froze so far.")
      .add("fluid", &StepResult::fluid, "Live liquid particles.")
      .add("solid", &StepResult::solid, "Live solid particles.");
  Record<TimedStep>(m, "TimedStep", "What a step that may end early came to.")
      .add("simulated", &TimedStep::simulated, "By which `time` went on [s].")
      .add("owed", &TimedStep::owed, "What was not simulated [s].")
      .add("substeps", &TimedStep::substeps, "Taken; step_part() with as many repeats the call to the bit.")
      .add("planned", &TimedStep::planned, "Sub-steps that all of it takes.")
      .add("wall_ms", &TimedStep::wall_ms, "The call took [ms].")
      .add("substep_ms", &TimedStep::substep_ms, "Running mean [ms]; 0: none was measured yet.")
      .add("over_budget", &TimedStep::over_budget, "It took longer than was asked for.");
  Record<Settled>(m, "Settled", "What settle() came to.")
      .add("seconds", &Settled::seconds, "That the liquid was given [s]; 0: there was none that could move.")
      .add("substeps", &Settled::substeps, "Sub-steps that it took.")
      .add("farthest", &Settled::farthest, "Way of the particle that was moved farthest [m].")
      .add("fastest", &Settled::fastest, "Speed of the fastest at the end, before it was stopped [m/s].");
  Record<Totals>(m, "Totals", "Conserved quantities and extremes, summed on the host.")
      .add("fluid", &Totals::fluid, "Liquid particles.")
      .add("solid", &Totals::solid, "Solid particles.")
      .add("bodies", &Totals::bodies, "Bodies.")
      .add("melted", &Totals::melted, "Particles that melted so far.")
      .add("frozen", &Totals::frozen, "Particles that froze so far.")
      .add("mass", &Totals::mass, "[kg]")
      .add("momentum", &Totals::momentum, "[kg m/s]")
      .add("angular_momentum", &Totals::angular_momentum, "About the origin [kg m^2/s].")
      .add("kinetic", &Totals::kinetic, "[J]")
      .add("potential", &Totals::potential, "Of gravity, 0 at the origin [J].")
      .add("thermal", &Totals::thermal, "Latent heat included [J].")
      .add("latent", &Totals::latent, "The part of thermal that is latent heat [J].")
      .add("latent_max", &Totals::latent_max,
           "What latent is where all that can melt is liquid [J]: latent / latent_max is molten.")
      .add("heat_in", &Totals::heat_in, "Through surfaces and from sources since the World was created [J].")
      .add("field_work", &Totals::field_work, "Of force fields since the World was created [J].")
      .add("field_impulse", &Totals::field_impulse, "Likewise [N s].")
      .add("temperature_min", &Totals::temperature_min, "[degrees Celsius]")
      .add("temperature_mean", &Totals::temperature_mean, "[degrees Celsius]")
      .add("temperature_max", &Totals::temperature_max, "[degrees Celsius]")
      .add("solid_center", &Totals::solid_center, "Centre of mass of all solid particles [m].")
      .add("max_speed", &Totals::max_speed, "[m/s]")
      .add("density_error_mean", &Totals::density_error_mean, "|rho/rho0 - 1| over liquid with rho > rho0.")
      .add("density_error_max", &Totals::density_error_max, "The largest.");
  Record<Ledger> ledger(m, "Ledger",
                        "Conserved quantities at the end of the last sub-step, summed by the backend.");
  ledger.get().def_prop_ro(
      "solute", [](const Ledger& l) { return nb::make_tuple(l.solute[0], l.solute[1], l.solute[2]); },
      nb::sig("def solute(self) -> tuple[float, float, float]"),
      "Of every species, in the order in which its materials were added: dissolved or not [kg].");
  keep_numbers(ledger, &Ledger::solute);
  ledger.get().def_prop_ro(
      "dissolved",
      [](const Ledger& l) { return nb::make_tuple(l.dissolved[0], l.dissolved[1], l.dissolved[2]); },
      nb::sig("def dissolved(self) -> tuple[float, float, float]"),
      "Of every species, what of it is dissolved [kg].");
  keep_numbers(ledger, &Ledger::dissolved);
  ledger.add("step", &Ledger::step, "Sub-steps completed.")
      .add("time", &Ledger::time, "[s]")
      .add("fluid", &Ledger::fluid, "Liquid particles.")
      .add("solid", &Ledger::solid, "Solid particles.")
      .add("mass", &Ledger::mass, "[kg]")
      .add("momentum", &Ledger::momentum, "[kg m/s]")
      .add("angular_momentum", &Ledger::angular_momentum, "About the origin [kg m^2/s].")
      .add("kinetic", &Ledger::kinetic, "[J]")
      .add("potential", &Ledger::potential, "[J]")
      .add("thermal", &Ledger::thermal, "Latent heat included [J].")
      .add("latent", &Ledger::latent, "[J]")
      .add("latent_max", &Ledger::latent_max, "What latent is where all that can melt is liquid [J].")
      .add("heat_in", &Ledger::heat_in, "[J]")
      .add("field_work", &Ledger::field_work, "Of force fields since the World was created [J].")
      .add("field_impulse", &Ledger::field_impulse, "Likewise [N s].")
      .add("max_speed", &Ledger::max_speed, "[m/s]")
      .add("courant", &Ledger::courant, "(c + max_speed) dt / H of that sub-step.")
      .add("solution", &Ledger::solution, "Heat that what is dissolved has taken up [J].")
      .add("density_error_mean", &Ledger::density_error_mean, "rho/rho0 - 1 over liquid with rho > rho0.")
      .add("density_error_max", &Ledger::density_error_max, "The largest.")
      .add("sound_speed", &Ledger::sound_speed, "Of that sub-step [m/s]; 0 before the first.")
      .add("sound_work", &Ledger::sound_work, "On compressed liquid by a sound speed that changes [J].")
      .add("displaced", &Ledger::displaced, "Liquid particles that teleports of bodies have put elsewhere.")
      .add("displaced_work", &Ledger::displaced_work, "Their work against gravity, of this World [J].");
  Record<PieceInfo> piece(m, "Piece", "One connected piece of a body.");
  piece.get().def_prop_ro(
      "body", [](const PieceInfo& p) { return p.body.index; },
      "Body.index of the body that it is or was part of.");
  piece.keep([](const PieceInfo& p) { return nb::object(nb::make_tuple(p.body.index, p.body.generation)); },
             [](PieceInfo& p, nb::handle v) {
               const auto pair = nb::cast<std::vector<std::uint32_t>>(v);
               if (pair.size() != 2) wrong_type("state: expected two numbers");
               p.body = {pair[0], pair[1]};
             });
  keep_numbers(piece, &PieceInfo::orientation);
  keep_numbers(piece, &PieceInfo::inertia);
  keep_numbers(piece, &PieceInfo::bounds);
  piece.add("name", &PieceInfo::name, "The body's name; further pieces get \".2\", \".3\", ...")
      .add("piece", &PieceInfo::piece, "Label, as of Particles.piece and of events.")
      .add("particles", &PieceInfo::particles, "Number of its particles.")
      .add("mass", &PieceInfo::mass, "[kg]")
      .add("center", &PieceInfo::center, "Centre of mass [m].")
      .add("velocity", &PieceInfo::velocity, "Of the centre of mass [m/s].")
      .add("angular_velocity", &PieceInfo::angular_velocity, "[rad/s]")
      .add("temperature_mean", &PieceInfo::temperature_mean, "Weighted by mass [degrees Celsius].")
      .add("submerged_fraction", &PieceInfo::submerged_fraction,
           "Share of its volume below the level of the liquid.");
  piece.get()
      .def_prop_ro(
          "orientation",
          [](const PieceInfo& p) {
            return nb::make_tuple(p.orientation.w, p.orientation.x, p.orientation.y, p.orientation.z);
          },
          nb::sig("def orientation(self) -> tuple[float, float, float, float]"),
          "Rotation since it was built, as a quaternion (w, x, y, z).")
      .def_prop_ro(
          "inertia",
          [](nb::handle self) {
            return array_view<double>(&nb::cast<const PieceInfo&>(self).inertia.m[0][0], {3, 3}, self);
          },
          "About the centre, in the axes of the World [kg m^2], shape (3, 3).")
      .def_prop_ro(
          "bounds",
          [](const PieceInfo& p) { return nb::make_tuple(tuple3(p.bounds.min), tuple3(p.bounds.max)); },
          nb::sig("def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]"),
          "Lower and upper corner [m].");
  Record<Stiffness>(m, "Stiffness", "Stiffness of the bodies of a material.")
      .add("region_half_width", &Stiffness::region_half_width, "w in use.")
      .add("stiffness", &Stiffness::stiffness, "alpha in use.")
      .add("youngs_modulus", &Stiffness::youngs_modulus,
           "E that these deliver at that sub-step [Pa]; 0 while no sub-step is known.");
  Record<Resolved> resolved(m, "Resolved", "Values that the World derived.");
  resolved.add("backend_reason", &Resolved::backend_reason, "Why the steps run there.")
      .add("device_name", &Resolved::device_name, "Of the GPU or the processor.")
      .add("neighbour_reason", &Resolved::neighbour_reason, "How neighbours are searched for, and why.")
      .add("support_radius", &Resolved::support_radius, "H [m]")
      .add("sound_speed", &Resolved::sound_speed, "c [m/s]; 0 while the World is empty.")
      .add("stable_dt", &Resolved::stable_dt, "Largest sub-step [s].")
      .add("heat_interval", &Resolved::heat_interval, "Sub-steps that share a step of heat.")
      .add("heat_stages", &Resolved::heat_stages, "Stages of a super-step of heat; 0: no heat.")
      .add("heat_supersteps", &Resolved::heat_supersteps, "Super-steps in a sub-step.")
      .add("viscous_dt", &Resolved::viscous_dt, "Largest sub-step that explicit viscosity would allow [s].")
      .add("viscous_stages", &Resolved::viscous_stages,
           "Stages of a super-step of implicit viscosity; 0: it is explicit.")
      .add("viscous_supersteps", &Resolved::viscous_supersteps, "Its super-steps in a sub-step.")
      .add("solute_supersteps", &Resolved::solute_supersteps,
           "Sweeps per species in a sub-step; 0: no species.")
      .add("heat_efficiency", &Resolved::heat_efficiency,
           "Share of the specified diffusivity that the heat model delivers at that sub-step.")
      .add("error", &Resolved::error, "Why the scene cannot be prepared; empty: it can.")
      .add("origin", &Resolved::origin, "Positions of State are relative to it [m].");
  resolved.keep([](const Resolved& r) { return nb::object(nb::cast(r.stiffness)); },
                [](Resolved& r, nb::handle v) { r.stiffness = nb::cast<std::vector<Stiffness>>(v); });
  resolved.get().def_prop_ro(
      "stiffness",
      [](const Resolved& r) {
        nb::list all;
        for (const Stiffness& s : r.stiffness) all.append(nb::cast(s));
        return all;
      },
      nb::sig("def stiffness(self) -> list[Stiffness]"),
      "Per material, in the order added: at the last sub-step; before the first one, at stable_dt.");

  bind_frame(m);
  nb::class_<ParticleData>(
      m, "Particles",
      "All particles, sorted by id: a copy that stays as it is. Arrays are parallel and share its memory.")
      .def("__len__", [](const ParticleData& p) { return p.id.size(); })
      .def("__repr__",
           [](const ParticleData& p) { return "<meltsim.Particles: " + std::to_string(p.id.size()) + ">"; })
      .def(
          "as_dict", &particles_as_dict, nb::sig("def as_dict(self) -> dict[str, Any]"),
          "The arrays by their names, fractions as a list of them; without solid, liquid, material and body, "
          "which are in tag.")
      .def("__getstate__", &particles_state, nb::sig("def __getstate__(self) -> tuple[Any, ...]"))
      .def("__setstate__", &set_particles_state,
           nb::sig("def __setstate__(self, state: tuple[Any, ...], /) -> None"))
      .def_prop_ro("id", column<std::uint32_t>(&ParticleData::id),
                   "Ascending; from the first step on an id names the same particle. uint32 (n,)")
      .def_prop_ro("position", column<double>(&ParticleData::position, 3), "[m], float64 (n, 3)")
      .def_prop_ro("velocity", column<double>(&ParticleData::velocity, 3), "[m/s], float64 (n, 3)")
      .def_prop_ro("mass", column<double>(&ParticleData::mass), "[kg], float64 (n,)")
      .def_prop_ro("temperature", column<double>(&ParticleData::temperature),
                   "[degrees Celsius], float64 (n,)")
      .def_prop_ro("enthalpy", column<double>(&ParticleData::enthalpy), "[J], float64 (n,)")
      .def_prop_ro("liquid_fraction", column<double>(&ParticleData::liquid_fraction),
                   "0 solid to 1 liquid, float64 (n,)")
      .def_prop_ro("density", column<double>(&ParticleData::density),
                   "[kg/m^3], 0 before the first step, float64 (n,)")
      .def_prop_ro("pressure", column<double>(&ParticleData::pressure), "[Pa], 0 for solids, float64 (n,)")
      .def_prop_ro(
          "fractions",
          [](nb::handle self) {
            nb::list list;
            for (const std::vector<double>& f : nb::cast<const ParticleData&>(self).fractions)
              list.append(array_view<double>(f.data(), {f.size()}, self));
            return list;
          },
          nb::sig("def fractions(self) -> list[numpy.ndarray]"),
          "Mass fractions: an array per species, in the order in which their materials were added; float64 "
          "(n,)")
      .def_prop_ro("tag", column<std::uint32_t>(&ParticleData::tag),
                   "Bits of meltsim/particle_tag.hpp, uint32 (n,)")
      .def_prop_ro("piece", column<std::uint32_t>(&ParticleData::piece),
                   "Label of the connected piece, 0 for liquid, uint32 (n,)")
      .def_prop_ro("solid", of_tag<bool>([](ParticleTag t) { return is_solid(t); }),
                   "Whether in a body, bool (n,)")
      .def_prop_ro("liquid", of_tag<bool>([](ParticleTag t) { return is_fluid(t); }),
                   "Whether liquid, bool (n,)")
      .def_prop_ro("material", of_tag<std::uint32_t>([](ParticleTag t) { return material_of(t); }),
                   "Material.index, uint32 (n,)")
      .def_prop_ro("body", of_tag<std::int32_t>([](ParticleTag t) {
                     return static_cast<std::int64_t>(body_of(t)) - 1;
                   }),
                   "Body.index, kept after melting; -1 for liquid of no body, int32 (n,)");

  nb::class_<SurfaceMesh>(m, "Surface",
                          "A surface mesh. Arrays per vertex are parallel and share its memory.")
      .def("__repr__",
           [](const SurfaceMesh& s) {
             return "<meltsim.Surface: " + std::to_string(s.position.size()) + " vertices, " +
                    std::to_string(s.triangles.size() / 3) + " triangles>";
           })
      .def_prop_ro(
          "origin", [](const SurfaceMesh& s) { return tuple3(s.origin); }, "Add it to positions [m].")
      .def_prop_ro("position", vertex_column<float>(&SurfaceMesh::position, 3), "[m], float32 (n, 3)")
      .def_prop_ro("normal", vertex_column<float>(&SurfaceMesh::normal, 3),
                   "Outward, length 1, float32 (n, 3)")
      .def_prop_ro("temperature", vertex_column<float>(&SurfaceMesh::temperature),
                   "[degrees Celsius], float32 (n,)")
      .def_prop_ro("liquid_fraction", vertex_column<float>(&SurfaceMesh::liquid_fraction),
                   "0 to 1, float32 (n,)")
      .def_prop_ro("body", vertex_column<std::uint32_t>(&SurfaceMesh::body),
                   "0 = liquid, else Body.index + 1, uint32 (n,)")
      .def_prop_ro("material", vertex_column<std::uint32_t>(&SurfaceMesh::material),
                   "Material.index, uint32 (n,)")
      .def_prop_ro("triangles", vertex_column<std::uint32_t>(&SurfaceMesh::triangles, 3),
                   "Vertices of triangles, counter-clockwise seen from outside, uint32 (m, 3)");
}

}  // namespace meltsim_python
