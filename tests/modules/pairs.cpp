// SPDX-License-Identifier: Apache-2.0
#include "modules/pairs.hpp"

#include <limits>

#include "engine/scales.hpp"
#include "frame/piece_sums.hpp"
#include "meltsim/physics/surface_tension.hpp"

namespace modules_test {
namespace {

constexpr double dx = 0.2, step = 0.9 * dx;

enum class Kind { water, drop, water_and_ice, all, all_viscosity, yielding, wetting, precipitating };

bool solids_of(Kind kind) { return kind != Kind::water && kind != Kind::drop; }

/// Nothing in it is symmetric: positions are jittered, velocities and temperatures random, one in 50 is removed.
PairScene box(double support, Kind kind, std::uint32_t periodic, Vec3i count, int free_layers,
              std::uint32_t seed) {
  PairScene p;
  Random random(seed);
  core::SceneConstants& c = p.constants;
  c.support = support * dx;
  c.spring_dt = p.dt;
  c.surroundings.gravity = {0.5, -9.81, 0.3};
  c.one_liquid = kind != Kind::all && kind != Kind::yielding && kind != Kind::wetting;
  for (core::MaterialRow<double>& m : c.materials) {
    m.viscosity *= 1000;  // as much as pressure does
    m.conductivity = 2.2;
    m.liquid_conductivity = 0.6;
    m.diffusivity = 0.01 / m.heat_capacity * m.density;
    m.plateau = 1;
    m.latent_heat = m.melting_heat = 1000;
    m.melting_enthalpy = -1000;
    m.coldest = -1e7;
  }
  c.materials[2].conductivity = 5;
  c.materials[2].diffusivity *= 3;
  if (kind == Kind::all_viscosity) {
    c.properties.resize(c.materials.size());
    for (std::size_t k : {0u, 2u}) {
      c.properties[k].viscosity.points = 2;
      c.properties[k].viscosity.temperature[1] = 8;
      c.properties[k].viscosity.value[0] = 200;
      c.properties[k].viscosity.value[1] = 3000;
    }
    p.facts |= core::fact_viscosity;
  }
  if (solids_of(kind)) {  // what dissolves in water; volumes stay
    physics::SpeciesRow<double> s;
    s.solute = 1;
    s.solvent = 0;
    s.solubility = 0.4;
    s.volume = s.solvent_volume = 1 / c.materials[0].density;
    s.diffusivity = 0.01;
    if (kind == Kind::precipitating) {  // over the temperatures of what is liquid: 0 to 7 degrees
      s.saturation.points = 2;
      s.saturation.temperature[1] = 7;
      s.saturation.value[0] = 0.2;
      s.saturation.value[1] = s.solubility = 0.6;
    }
    c.species = {s};
  }
  if (kind == Kind::yielding) {  // one liquid yields, the other thickens: velocities of 1 m/s over 0.2 m
    c.properties.resize(c.materials.size());
    c.properties[0].flow = {2000, 0.6, 0.5, std::numeric_limits<double>::infinity()};
    c.properties[2].flow = {0, 1.5, 10, 8};
    p.facts |= core::fact_viscosity | core::fact_strain;
  }
  if (kind == Kind::wetting || kind == Kind::drop) {  // as much as pressure does
    const double tension[] = {1e5, 0, 3e4};
    for (std::size_t k : {0u, 2u}) {
      c.materials[k].tension = tension[k];
      c.materials[k].cohesion = physics::cohesion_strength(tension[k], c.support);
      c.materials[k].skin_viscosity = physics::skin_viscosity(tension[k], c.materials[k].density, dx);
    }
    c.materials[1].wetting = physics::wetting_cosine(70);
    c.domain.contact_angle = 140;
    p.facts |= core::fact_tension;
  }
  DomainDesc& d = c.domain;
  d.bounded = true;
  const auto extent = [&](int n, int axis) {
    return (periodic >> axis & 1u) != 0u ? n * step : (n - 1) * step + 0.24;
  };
  d.max = {extent(count.x, 0), extent(count.y + free_layers, 1), extent(count.z, 2)};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if ((periodic >> axis & 1u) != 0u) d.faces[2 * axis] = d.faces[2 * axis + 1] = Face::periodic;
  const bool solids = solids_of(kind);
  for (const Vec3i& n : block(count.x, count.y, count.z)) {
    // Solids stand clear of walls, whose contact is not a sum over pairs.
    const Vec3d x =
        Vec3d{n.x * step, n.y * step, n.z * step} + Vec3d{0.12, 0.12, 0.12} + random.vector(0.012);
    const bool solid = solids && n.x < count.x / 2 && n.y < count.y / 2;
    std::uint32_t tag = solid ? 1u | tag_solid | 1u << tag_body_shift : 0u;
    if (!solid && c.one_liquid == false && n.y < count.y / 2) tag = 2u;
    if (solid && n.x == 0) tag |= tag_surface;
    if (random.below(50) == 0) tag |= tag_removed;
    const std::uint32_t i = add_particle(p.state, c, x, tag, random.vector(1));
    // A third holds both phases.
    const double h = random.below(3) == 0 ? random.uniform(-1000, 0) : random.uniform(-30000, 30000);
    p.state.enthalpy[i] = h * p.state.mass[i];
    if (!c.species.empty()) p.state.solute[0].push_back(random.uniform(0, 1) * p.state.mass[i]);
  }
  if (solids) p.facts |= core::fact_solid | core::fact_mobile;  // without a lattice
  return p;
}

PairScene crowded(double support) {
  PairScene p = box(support, Kind::water, 0, {8, 5, 6}, 4, 5);
  Random random(6);
  // Small ones: they are many, but do not press much.
  for (int n = 0; n < 500; ++n) {
    const std::uint32_t i =
        add_particle(p.state, p.constants, Vec3d{0.4, 0.4, 0.5} + random.vector(0.12), 0u, random.vector(1));
    p.state.volume[i] *= 0.01;
    p.state.mass[i] *= 0.01;
    p.state.enthalpy[i] = 4000 * random.uniform(-5, 5) * p.state.mass[i];
  }
  return p;
}

/// Two blocks into which each other reach, of different masses, and one that only touches the third by an edge.
PairScene bodies(double support, bool liquid) {
  PairScene p;
  Random random(7);
  core::SceneConstants& c = p.constants;
  c.support = support * dx;
  c.spring_dt = p.dt;
  c.surroundings.gravity = {0.5, -9.81, 0.3};
  c.one_liquid = true;
  for (core::MaterialRow<double>& m : c.materials) {
    m.conductivity = m.liquid_conductivity = 2.2;
    m.diffusivity = 0.01 / m.heat_capacity * m.density;
    m.friction = 0.4;
    m.shape_stiffness = m.shape_damping = 0;
    m.coldest = -1e7;
  }
  c.domain.bounded = true;
  c.domain.max = {2.4, 2.4, 2.4};
  const Vec3d at[3] = {
      {0.3, 0.3, 0.3}, {0.3 + 0.05, 0.3 + 2.85 * dx, 0.3}, {0.3 + 2.9 * dx, 0.3 + 2.85 * dx, 0.35}};
  for (int b = 0; b < 3; ++b) {
    const std::size_t first = p.state.position.size();
    add_body(p.lattice, p.state, c, block(3, 3, 3), 1);
    const Vec3d v = random.vector(1);
    for (std::size_t i = first; i < p.state.position.size(); ++i) {
      p.state.position[i] += at[b] + random.vector(0.01);
      p.state.velocity[i] = v;
      p.state.mass[i] *= 1 + b;
    }
  }
  if (liquid)
    for (const Vec3i& n : block(9, 3, 9))
      add_particle(p.state, c,
                   Vec3d{n.x * step, n.y * step, n.z * step} + Vec3d{0.3, 1.4, 0.3} + random.vector(0.012),
                   0u, random.vector(1));
  for (std::size_t i = 0; i < p.state.position.size(); ++i)
    p.state.enthalpy[i] = 4000 * random.uniform(-5, 5) * p.state.mass[i];
  for (core::BodyRow& body : p.lattice.bodies) body.watched = 1;
  p.state.forces.resize(p.lattice.bodies.size());
  p.facts |= core::fact_solid | core::fact_mobile | core::fact_lattice | core::fact_contact;
  if (!liquid) p.facts &= ~core::fact_fluid;
  return p;
}

}  // namespace

std::vector<NamedScene> pair_scenes(double support, double length) {
  std::vector<NamedScene> all;
  // Free surface above, walls and edges around.
  all.push_back({"water", box(support, Kind::water, 0, {9, 8, 8}, 4, 1)});
  all.push_back({"water, x and z periodic", box(support, Kind::water, 5, {9, 8, 9}, 4, 2)});
  all.push_back({"water and ice", box(support, Kind::water_and_ice, 0, {9, 8, 8}, 4, 3)});
  all.push_back({"water and ice, all periodic", box(support, Kind::water_and_ice, 7, {9, 9, 9}, 0, 4)});
  all.push_back({"two liquids and ice", box(support, Kind::all, 0, {9, 8, 8}, 4, 8)});
  all.push_back({"two liquids and ice, y periodic", box(support, Kind::all, 2, {9, 9, 8}, 0, 9)});
  all.push_back({"water and ice, viscosity varies", box(support, Kind::all_viscosity, 0, {9, 8, 8}, 4, 10)});
  all.push_back({"two liquids that shear and ice", box(support, Kind::yielding, 0, {9, 8, 8}, 4, 14)});
  all.push_back(
      {"two liquids that shear and ice, periodic", box(support, Kind::yielding, 5, {9, 8, 9}, 4, 15)});
  all.push_back({"water that wets", box(support, Kind::drop, 0, {9, 8, 8}, 4, 21)});
  all.push_back({"two liquids that wet and ice", box(support, Kind::wetting, 0, {9, 8, 8}, 4, 16)});
  all.push_back(
      {"two liquids that wet and ice, y periodic", box(support, Kind::wetting, 2, {9, 9, 8}, 0, 17)});
  all.push_back({"water and ice that precipitates", box(support, Kind::precipitating, 0, {9, 8, 8}, 4, 28)});
  all.push_back({"water and ice that precipitates, all periodic",
                 box(support, Kind::precipitating, 7, {9, 9, 9}, 0, 19)});
  for (const char* slips : {"water, x and z periodic", "two liquids that shear and ice",
                            "two liquids that wet and ice, y periodic"})
    for (NamedScene& s : all)
      if (s.name == slips) s.scene.constants.domain.no_slip = false;
  for (const auto& [name, of] :
       {NamedScene{"water, isotropic pressure", box(support, Kind::water, 0, {9, 8, 8}, 4, 28)},
        NamedScene{"water and ice, isotropic pressure",
                   box(support, Kind::water_and_ice, 0, {9, 8, 8}, 4, 19)},
        NamedScene{"two liquids and ice, y periodic, isotropic pressure",
                   box(support, Kind::all, 2, {9, 9, 8}, 0, 20)}}) {
    all.push_back({name, of});
    all.back().scene.facts |= core::fact_isotropic;
  }
  PairScene under_tension = box(support, Kind::water, 4, {9, 8, 9}, 4, 11);
  under_tension.constants.tension = true;
  under_tension.facts |= core::fact_shifting;
  all.push_back({"water under tension, shifted", under_tension});
  PairScene open = box(support, Kind::all, 0, {9, 8, 8}, 0, 12);
  open.constants.domain = DomainDesc{};
  all.push_back({"two liquids and ice, no domain", open});
  all.push_back({"crowd", crowded(support)});
  all.push_back({"bodies", bodies(support, false)});
  all.push_back({"bodies and water", bodies(support, true)});
  all.push_back({"bodies and water, isotropic pressure", bodies(support, true)});
  all.back().scene.facts |= core::fact_isotropic;
  for (NamedScene& s : all) {
    DomainDesc& d = s.scene.constants.domain;
    if (d.bounded && d.faces[1] == Face::wall) d.max.x = std::max(d.max.x, length * support * dx);
  }
  return all;
}

namespace {

template <class T>
struct Run {
  const PairEngine& how;
  const PairScene& scene;
  core::SceneState after;
  core::DerivedState derived;
  std::size_t n = scene.state.position.size();

  void operator()(core::FactSet facts, std::initializer_list<const char*> stages) {
    const std::shared_ptr<core::Engine> engine =
        how.make(sizeof(T) == sizeof(float) ? Precision::single_precision : Precision::double_precision);
    ASSERT_NE(engine, nullptr) << how.name;
    core::SceneConstants c = scene.constants;
    core::SceneState s = scene.state;
    add_removed(c, s);
    set_tables(c);
    if ((facts & core::fact_species) == 0u) {
      c.species.clear();
      s.solute[0].clear();
    }
    facts |= scene.facts | (c.domain.bounded ? core::fact_packed : core::fact_sparse);
    const core::EngineSetup setup = setup_for(facts, s.position.size());
    const Status status = engine->upload(c, scene.lattice, s, setup);
    ASSERT_TRUE(status) << status.error().message;
    core::SubstepArguments a;
    a.dt = scene.dt;
    a.index = 1;
    a.heat_dt = scene.heat_dt;
    a.heat_stages = a.heat_supersteps = 1;
    a.heat_bound = 1e30;
    a.solute_dt = scene.heat_dt;
    a.solute_supersteps = 1;
    a.solute_bound = 1e30;
    a.viscous_dt = scene.dt;
    a.viscous_stages = a.viscous_supersteps = (facts & core::fact_implicit) != 0 ? 1 : 0;
    a.viscous_bound = 1e30;
    for (int k = 0; k < core::stage_count; ++k)
      for (const char* wanted : stages)
        if (core::runs(core::stage_table[static_cast<std::size_t>(k)], setup.facts))
          a.stages |= stage_bits(wanted, setup.facts) & std::uint64_t{1} << k;
    engine->substep(a);
    const core::WorldStatus end = engine->synchronize();
    ASSERT_EQ(end.halted, 0u) << how.name << ": " << end.halt_value << " at particle " << end.halt_particle;
    after.motion.resize(scene.lattice.bodies.size());  // so many rows of forces come
    engine->download(after);
    engine->download(derived);
  }
  void add_removed(const core::SceneConstants& c, core::SceneState& s) const {
    for (std::size_t k = 0; k < how.removed; ++k) add_particle(s, c, s.position[0], tag_removed);
    if (!c.species.empty()) s.solute[0].resize(s.position.size());
  }
};

}  // namespace

template <class T>
PairSums sums_of(const PairEngine& how, const PairScene& scene) {
  Run<T> run{how, scene, {}, {}};
  PairSums sums(run.n);
  const auto note_accelerations = [&](std::vector<Summed>& to) {
    for (std::size_t i = 0; i < run.n; ++i) {
      if (is_removed(scene.state.tag[i])) continue;
      const Vec3d v0 = cast<double>(cast<T>(scene.state.velocity[i])), v1 = run.after.velocity[i];
      to[i].add((v1 - v0) * (1 / scene.dt), (length(v0) + length(v1)) / scene.dt);
    }
  };
  if ((scene.facts & core::fact_fluid) != 0) {
    run(core::fact_implicit, {"step.begin", "spatial", "sph", "lsm", "step.integrate"});
    if (testing::Test::HasFatalFailure()) return sums;
    note_accelerations(sums.diffused);
  }
  run(0, {"step.begin", "spatial", "sph", "lsm", "step.integrate"});
  if (testing::Test::HasFatalFailure()) return sums;
  note_accelerations(sums.acceleration);
  const auto drifted = [&](Vec3d x, Vec3d v) {
    return cast<double>(physics::drift(cast<T>(x), cast<T>(v), static_cast<T>(0.5 * scene.dt)));
  };
  for (std::size_t i = 0; i < run.n; ++i) {
    if (is_removed(scene.state.tag[i])) continue;
    const Vec3d v0 = cast<double>(cast<T>(scene.state.velocity[i])), v1 = run.after.velocity[i];
    if ((scene.facts & core::fact_fluid) != 0) {
      sums.density[i].add({run.derived.density[i], 0, 0}, 0);
      sums.term[i].add({run.derived.pressure_term[i], 0, 0}, 0);
    }
    const Vec3d x = drifted(scene.state.position[i], v0), rest = v1 * (0.5 * scene.dt);
    if ((scene.facts & core::fact_shifting) != 0)
      sums.shift[i].add(run.after.position[i] - x - rest, length(x) + length(run.after.position[i]));
  }
  if (!scene.state.forces.empty()) {
    run(core::fact_forces, {"step.begin", "spatial", "sph", "lsm", "sampling", "step.integrate"});
    if (testing::Test::HasFatalFailure()) return sums;
    const core::Scales scales = core::scales_of(scene.constants, scene.lattice);
    for (std::size_t b = 0; b < scene.state.forces.size(); ++b) {
      const core::BodyForceTotals& f = run.after.forces[b];
      const core::Impulses* const parts[] = {&f.all, &f.pressure, &f.contact};
      // Sums are whole numbers of these units (EngineImpl::set_sum_units); each of 27 particles is rounded to one, and half of
      // all errors are to be below 20 units in the last place.
      const double units = 27 / 20.0 * std::ldexp(scales.largest_mass, 1 - scales.sum_bits) * scales.spacing /
                           std::min(scales.spring_dt, scene.dt) / std::numeric_limits<T>::epsilon();
      for (std::size_t k = 0; k < 3; ++k) {
        sums.watched[6 * b + k].add(parts[k]->linear, units);
        sums.watched[6 * b + 3 + k].add(parts[k]->angular, 2 * units * scales.spacing * scales.body_size);
      }
    }
  }
  if (!scene.constants.species.empty()) {
    run(core::fact_species, {"step.begin", "spatial", "sph.density", "species"});
    if (testing::Test::HasFatalFailure()) return sums;
    for (std::size_t i = 0; i < run.n; ++i) {
      if (is_removed(scene.state.tag[i])) continue;
      const double before = scene.state.solute[0][i], after = run.after.solute[0][i];
      // Contents are double whatever T is.
      const double unit = 2.3e-16 / static_cast<double>(std::numeric_limits<T>::epsilon());
      sums.solute[i].add({(after - before) / scene.heat_dt, 0, 0}, (before + after) * unit / scene.heat_dt);
    }
  }
  struct Model {
    std::uint32_t fact;
    const char* stage;
    std::vector<Summed>* to;
  };
  for (const Model& m : {Model{core::fact_heat_enthalpy, "thermal", &sums.heat},
                         Model{core::fact_heat_iwasaki, "thermal", &sums.iwasaki},
                         Model{core::fact_heat_paper, "thermal", &sums.paper}}) {
    run(m.fact, {"step.begin", "spatial", "sph.density", m.stage});
    if (testing::Test::HasFatalFailure()) return sums;
    for (std::size_t i = 0; i < run.n; ++i) {
      if (is_removed(scene.state.tag[i])) continue;
      const double h0 = scene.state.enthalpy[i], h1 = run.after.enthalpy[i];
      const double mass = static_cast<double>(static_cast<T>(scene.state.mass[i]));
      const core::MaterialRow<double>& row = scene.constants.materials[material_of(scene.state.tag[i])];
      const auto temperature = [&](double h) { return physics::temperature_of(row, h / mass); };
      // Enthalpies are double whatever T is.
      const double unit = 2.3e-16 / static_cast<double>(std::numeric_limits<T>::epsilon());
      const double in = m.fact == core::fact_heat_enthalpy ? h1 - h0 : temperature(h1) - temperature(h0);
      const double size =
          m.fact == core::fact_heat_enthalpy
              ? std::fabs(h0) + std::fabs(h1)
              : std::fabs(temperature(h0)) + std::fabs(temperature(h1)) +
                    row.latent_heat / row.heat_capacity;  // that is taken off h below the plateau
      const double per = m.fact == core::fact_heat_paper ? 1 : 1 / scene.heat_dt;
      (*m.to)[i].add({in * per, 0, 0}, size * unit * per);
    }
  }
  return sums;
}
template PairSums sums_of<float>(const PairEngine&, const PairScene&);
template PairSums sums_of<double>(const PairEngine&, const PairScene&);

}  // namespace modules_test
