// SPDX-License-Identifier: Apache-2.0
// Whole runs with every body called forward, backward and shuffled: the same bits. A block of ice beside
// another in a small tank of warm water, so that every stage but the other heat model's has work; 24 steps,
// in which the labels are searched three times and particles melt; or melt and freeze.
#include <gtest/gtest.h>

#include "modules/engine.hpp"
#include "world/world_impl.hpp"

namespace {

using namespace modules_test;

struct Outcome {
  std::uint64_t hash = 0, melted = 0, frozen = 0;
  std::vector<double> density, operand;
  std::vector<float> surface;  ///< coordinates, normals and what vertices carry
  std::vector<std::uint32_t> triangles;
};

struct HostStage {
  std::string after;
  CustomStage stage;
};

void mesh_of(WorldImpl& world, std::vector<float>& surface, std::vector<std::uint32_t>& triangles) {
  for (const auto of : {SurfaceOf::liquid, SurfaceOf::solids})
    for (const auto kernel : {SurfaceKernel::isotropic, SurfaceKernel::anisotropic}) {
      SurfaceDesc d;
      d.of = of;
      d.kernel = kernel;
      const auto mesh = world.surface(d);
      EXPECT_TRUE(mesh) << mesh.error().message;
      for (std::size_t v = 0; v < mesh->position.size(); ++v) {
        const Vec3f p = mesh->position[v], n = mesh->normal[v];
        surface.insert(surface.end(), {p.x, p.y, p.z, n.x, n.y, n.z, mesh->temperature[v],
                                       mesh->liquid_fraction[v], float(mesh->body[v])});
      }
      triangles.insert(triangles.end(), mesh->triangles.begin(), mesh->triangles.end());
    }
}

template <class T>
Outcome run(std::shared_ptr<core::Engine> engine, HeatModel model, bool freezing, NeighbourSearch search,
            bool viscous, const std::vector<HostStage>& host = {}) {
  const double dx = 0.1;
  WorldImpl world;
  world.desc.backend = Backend::cpu;
  world.desc.precision = sizeof(T) == 8 ? Precision::double_precision : Precision::single_precision;
  world.desc.spacing = dx;
  world.desc.domain.bounded = true;
  const double depth = 0.8;
  world.desc.domain.max = {1.0, freezing ? 1.0 : 0.62, depth};
  world.desc.domain.faces = {Face::wall, Face::wall, Face::wall, Face::open, Face::periodic, Face::periodic};
  world.desc.heat.model = model;
  world.desc.heat.time_scale = freezing ? 1e6 : 2e4;
  world.desc.pieces_interval = 8;
  world.desc.particle_shifting = freezing;
  world.desc.neighbour_search = search;
  world.engine = std::move(engine);
  MaterialDesc water, ice;
  water.viscosity = viscous ? 1e5 : 0.2;  // two super-steps
  const auto water_id = world.add_material(water);
  ice.name = "ice";
  ice.density = 917;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = 1e3;
  ice.melts_into = *water_id;
  ice.region_half_width = 1;
  ice.freezes = freezing;
  const auto ice_id = world.add_material(ice);
  FluidDesc pool;
  pool.shape = Shape::box({0, 0, 0}, {1.0, 0.5, depth});
  pool.material = *water_id;
  pool.temperature = freezing ? 2 : 80;  // the block then freezes some and melts its neighbour not at all
  EXPECT_TRUE(world.add_fluid(pool));
  SolidDesc block;
  block.material = *ice_id;
  block.temperature = freezing ? -100 : -1;
  block.growth = freezing ? 2 : 0;
  block.shape = Shape::box({0.2, 0.2, 0.2}, {0.5, 0.6, 0.6});
  EXPECT_TRUE(world.add_solid(block));
  block.shape = Shape::box({0.5, 0.3, 0.2}, {0.8, 0.6, 0.5});
  if (freezing) block.temperature = 0;
  EXPECT_TRUE(world.add_solid(block));
  if (!freezing) {  // one layer in the middle of the run, which leaves through the open face
    EmitterDesc jet;
    jet.material = *water_id;
    jet.center = {0.9, 0.58, depth - 0.15};  // within H of the pool
    jet.axis = {0, 1, 0};
    jet.radius = 1.1 * dx;
    jet.speed = 12;  // through the nozzle, two spacings long, and out within the run
    jet.from = 0.005;
    jet.until = 0.06;
    const auto added = world.add_emitter(jet);
    EXPECT_TRUE(added) << added.error().message;
  }
  for (const HostStage& h : host) EXPECT_TRUE(world.insert_after(h.after, h.stage));
  // Every sixth is shorter: what was counted ahead for the usual one no longer holds.
  for (int n = 0; n < 24; ++n) {
    const Status s = world.step(n % 6 == 5 ? 1.0 / 1024 : 1.0 / 512);
    EXPECT_TRUE(s) << s.error().message;
  }
  EXPECT_EQ(world.resolved().neighbour_search, search);
  EXPECT_EQ(world.resolved().viscous_supersteps, viscous ? 2 : 0);
  const StepResult r = world.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_EQ(r.removed > 0, !freezing);
  core::DerivedState derived;
  world.engine->download(derived);
  Outcome o{*world.state_hash(), r.melted, r.frozen, derived.density, derived.pressure_term, {}, {}};
  mesh_of(world, o.surface, o.triangles);
  // What a World knows of where particles are beside the state makes no difference to it.
  const auto snapshot = world.snapshot();
  EXPECT_TRUE(world.restore(snapshot->data(), snapshot->size()));
  std::vector<float> surface;
  std::vector<std::uint32_t> triangles;
  mesh_of(world, surface, triangles);
  EXPECT_TRUE(surface == o.surface && triangles == o.triangles);
  EXPECT_GT(o.triangles.size(), 10000u);
  return o;
}

template <class T>
void expect_any_order(HeatModel model, bool freezing = false, NeighbourSearch search = NeighbourSearch::grid,
                      bool viscous = false) {
  const Outcome forward = run<T>(Rig<T>(Order::forward).engine, model, freezing, search, viscous);
  EXPECT_GT(freezing ? forward.frozen : forward.melted, 10u);
  for (const Order order : {Order::reversed, Order::shuffled}) {
    const Outcome other = run<T>(Rig<T>(order).engine, model, freezing, search, viscous);
    EXPECT_EQ(other.hash, forward.hash);
    EXPECT_EQ(other.melted, forward.melted);
    EXPECT_EQ(other.density, forward.density);
    EXPECT_EQ(other.operand, forward.operand);
    EXPECT_TRUE(other.surface == forward.surface);
    EXPECT_TRUE(other.triangles == forward.triangles);
  }
  // And the library's own executor, with threads.
  WorldDesc desc;
  desc.threads = 3;
  if (sizeof(T) == 8) desc.precision = Precision::double_precision;
  EXPECT_EQ(run<T>(*core::make_cpu_engine(desc), model, freezing, search, viscous).hash, forward.hash);
}

// A wind that grows with time on all that is there, and a brake behind integration: between stages that write the same channels, on
// other tracks too, so that their places show in the bits.
template <class T>
void blow(const StageContext& c, void*) {
  const auto* x = static_cast<const Vec4<T>*>(c.position);
  auto* a = static_cast<Vec3<T>*>(c.acceleration);
  for (std::uint64_t i = 0; i < c.particles; ++i)
    if (!is_removed(c.tag[i]))
      a[i].x = T(1.5) * a[i].x + static_cast<T>(40 * (c.clock->time + c.clock->length)) * x[i].y;
}
template <class T>
void brake(const StageContext& c, void*) {
  auto* v = static_cast<Vec4<T>*>(c.velocity);
  for (std::uint64_t i = 0; i < c.particles; ++i)
    if (!is_removed(c.tag[i])) v[i].z *= T(0.99);
}
template <class T>
void look(const StageContext& c, void* user) {
  const auto* v = static_cast<const Vec4<T>*>(c.velocity);
  double sum = 0;
  for (std::uint64_t i = 0; i < c.particles; ++i)
    if (!is_removed(c.tag[i])) sum += static_cast<double>(v[i].x) * c.id[i];
  static_cast<std::vector<double>*>(user)->push_back(sum);
}

template <class T>
std::vector<HostStage> host_stages(bool recorded, std::vector<double>& seen) {
  const auto stage = [&](const char* name, CustomStageFunction run, std::vector<std::string> reads,
                         std::vector<std::string> writes) {
    CustomStage s;
    s.name = name;
    s.run = run;
    s.user = &seen;
    s.reads = std::move(reads);
    s.writes = std::move(writes);
    s.recorded = recorded;
    return s;
  };
  return {{"sph.forces", stage("blow", blow<T>, {"position", "tag"}, {"acceleration"})},
          {"step.fields", stage("look", look<T>, {"velocity", "id", "tag"}, {})},  // does not run here
          {"step.begin", stage("look first", look<T>, {"velocity", "id", "tag"}, {})},
          {"lsm.commit", stage("brake", brake<T>, {"tag"}, {"velocity"})}};
}

// One after another, as stages that are not recorded run, or joined to the stages that they follow, in any order that the
// schedule leaves: the same bits, and what they see is the same.
template <class T>
void expect_host_stages_keep_their_place() {
  std::vector<double> seen;
  const auto with = [&](Order order, bool recorded) {
    seen.clear();
    return run<T>(Rig<T>(order).engine, HeatModel::enthalpy, false, NeighbourSearch::grid, false,
                  host_stages<T>(recorded, seen));
  };
  const Outcome one_by_one = with(Order::forward, false);
  const std::vector<double> seen_one_by_one = seen;
  EXPECT_GE(seen.size(), 48u);  // twice a sub-step
  EXPECT_NE(
      one_by_one.hash,
      run<T>(Rig<T>(Order::forward).engine, HeatModel::enthalpy, false, NeighbourSearch::grid, false).hash);
  for (const Order order : {Order::forward, Order::reversed, Order::shuffled}) {
    const Outcome joined = with(order, true);
    SCOPED_TRACE(::testing::Message() << "order " << static_cast<int>(order));
    EXPECT_EQ(joined.hash, one_by_one.hash);
    EXPECT_EQ(joined.density, one_by_one.density);
    EXPECT_EQ(seen, seen_one_by_one);
  }
}
TEST(Order, RecordedStagesOfTheHostKeepTheirPlaceInSinglePrecision) {
  expect_host_stages_keep_their_place<float>();
}
TEST(Order, RecordedStagesOfTheHostKeepTheirPlaceInDoublePrecision) {
  expect_host_stages_keep_their_place<double>();
}

TEST(Order, ChangesNoBitInSinglePrecision) { expect_any_order<float>(HeatModel::enthalpy); }
TEST(Order, ChangesNoBitInDoublePrecision) { expect_any_order<double>(HeatModel::enthalpy); }
TEST(Order, ChangesNoBitWhereLiquidFreezes) { expect_any_order<float>(HeatModel::enthalpy, true); }
TEST(Order, ChangesNoBitWithImplicitViscosity) {
  expect_any_order<float>(HeatModel::enthalpy, true, NeighbourSearch::grid, true);
}
TEST(Order, ChangesNoBitWithATree) {
  expect_any_order<float>(HeatModel::enthalpy, false, NeighbourSearch::tree);
}
TEST(Order, ChangesNoBitInPaperMode) { expect_any_order<float>(HeatModel::paper); }

}  // namespace
