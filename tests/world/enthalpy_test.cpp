// SPDX-License-Identifier: Apache-2.0
// Enthalpies that nothing changes lie by id and are not moved about: everyone still has their own, whoever asks, and a
// custom stage that names them gets them in the order of particles.
#include <algorithm>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

struct Tank {
  HeatModel model = HeatModel::none;
  NeighbourSearch search = NeighbourSearch::automatic;
  bool expands = false;  ///< rho0 falls from 1000 to 900 kg/m^3 over 100 degrees
  Vec3d gravity{0, -9.81, 0};
  double sound_speed = 30;
};

MaterialId water;

/// Cold beside warm water that leaves through an open face, hot water from a nozzle above. Particles change places.
World make_tank(const Tank& tank) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.sound_speed = tank.sound_speed;
  d.gravity = tank.gravity;
  d.heat.model = tank.model;
  d.neighbour_search = tank.search;
  d.domain.bounded = true;
  d.domain.max = {1.6, 1.6, 0.8};
  d.domain.faces[1] = Face::open;
  World w = *World::create(d);
  MaterialDesc m;
  m.viscosity = 0.2;
  if (tank.expands) m.density_points = {{0, 1000}, {100, 900}};
  water = *w.add_material(m);
  FluidDesc f;
  f.material = water;
  f.velocity = {1, 0, 0.5};
  f.shape = Shape::box({0, 0, 0}, {0.8, 0.8, 0.8});
  f.temperature = 10;
  require(w.add_fluid(f));
  f.shape = Shape::box({0.8, 0, 0}, {1.6, 0.6, 0.8});
  f.temperature = 40;
  require(w.add_fluid(f));
  EmitterDesc jet;
  jet.material = water;
  jet.center = {0.8, 1.4, 0.4};
  jet.axis = {0, -1, 0};
  jet.radius = 0.15;
  jet.speed = 3;
  jet.temperature = 90;
  jet.until = 0.4;
  require(w.add_emitter(jet));
  require(w.prepare());
  return w;
}

std::uint64_t bytes(World& w, const std::string& channel) {
  std::uint64_t found = 0;
  for (const ChannelReport& c : w.plan().channels)
    if (c.name == channel) found = c.bytes;
  return found;
}

constexpr double dt = 4e-3;
constexpr int steps = 60;  // 0.24 s: the jet is under way, everyone has changed cell

const NeighbourSearch searches[] = {NeighbourSearch::grid, NeighbourSearch::tree};

TEST(Enthalpy, EveryoneKeepsTheirOwnWhereHeatIsAtRest) {
  MELTSIM_NEEDS_BACKEND();
  for (const NeighbourSearch search : searches) {
    World w = make_tank({HeatModel::none, search, false});
    EXPECT_EQ(bytes(w, "enthalpy"), 0u);
    EXPECT_GT(bytes(w, "enthalpy_of_id"), 0u);
    const ParticleData before = *w.particles();
    const std::size_t n = before.id.size();
    for (int k = 0; k < steps; ++k) require(w.step(dt));
    EXPECT_FALSE(w.synchronize().halted);
    const ParticleData after = *w.particles();
    ASSERT_GT(after.id.back(), n);      // emitted
    ASSERT_NE(after.id[n - 1], n - 1);  // and gone
    // Mass in single precision: 10 and 40 degrees come back to 1e-7 of themselves.
    double sum = 0, furthest = 0;
    for (std::size_t i = 0; i < after.id.size(); ++i) {
      const std::uint32_t id = after.id[i];
      if (id < n) {
        ASSERT_EQ(after.enthalpy[i], before.enthalpy[id]) << id;
        furthest = std::max(furthest, length(after.position[i] - before.position[id]));
      } else {
        ASSERT_NEAR(after.temperature[i], 90, 90 * 2e-7) << id;
      }
      sum += after.enthalpy[i];
    }
    EXPECT_GT(furthest, 0.2);  // two spacings
    // Added up in another order, in double: rounding of n terms.
    EXPECT_NEAR(w.ledger()->thermal, sum, 1e-12 * sum);

    const auto data = *w.snapshot();
    World again = make_tank({HeatModel::none, search, false});
    require(again.restore(data.data(), data.size()));
    for (World* one : {&w, &again})
      for (int k = 0; k < 5; ++k) require(one->step(dt));
    EXPECT_EQ(*again.state_hash(), *w.state_hash());
  }
}

TEST(Enthalpy, TheSurfaceShowsIt) {
  MELTSIM_NEEDS_BACKEND();
  World w = make_tank({});
  for (int k = 0; k < steps; ++k) require(w.step(dt));
  const SurfaceMesh mesh = *w.surface();
  ASSERT_FALSE(mesh.temperature.empty());
  const auto ends = std::minmax_element(mesh.temperature.begin(), mesh.temperature.end());
  // Averages of who is near: from cold water to the middle of the jet.
  EXPECT_NEAR(*ends.first, 10, 1e-3);
  EXPECT_GT(*ends.second, 80);
  EXPECT_LT(*ends.second, 90 + 1e-3);
}

struct Seen {
  bool there = false;
  std::uint64_t calls = 0, wrong = 0;
  const std::vector<double>* by_id = nullptr;
};

void look(const StageContext& context, void* user) {
  Seen& seen = *static_cast<Seen*>(user);
  ++seen.calls;
  seen.there = context.enthalpy != nullptr;
  if (!seen.there || context.backend != Backend::cpu) return;
  for (std::uint64_t i = 0; i < context.particles; ++i)
    if (context.id[i] < seen.by_id->size() && context.enthalpy[i] != (*seen.by_id)[context.id[i]])
      ++seen.wrong;
}

TEST(Enthalpy, ACustomStageHasItIfItSaysSo) {
  MELTSIM_NEEDS_BACKEND();
  for (const NeighbourSearch search : searches) {
    World w = make_tank({HeatModel::none, search, false}),
          plain = make_tank({HeatModel::none, search, false});
    const std::vector<double> by_id = w.particles()->enthalpy;
    Seen seen;
    seen.by_id = &by_id;
    CustomStage stage{"look", look, &seen, {"position"}, {}};
    require(w.scheduler().insert_after("sph.density", stage));
    require(w.step(dt));
    EXPECT_EQ(seen.calls, w.steps());
    EXPECT_FALSE(seen.there);
    require(w.scheduler().remove("look"));
    for (int k = 1; k < steps / 2; ++k) require(w.step(dt));

    stage.reads = {"enthalpy"};
    const std::uint64_t calls = seen.calls, steps_before = w.steps();
    require(w.scheduler().insert_after("sph.density", stage));
    for (int k = 0; k < steps / 2; ++k) require(w.step(dt));
    EXPECT_TRUE(seen.there);
    EXPECT_EQ(seen.calls - calls, w.steps() - steps_before);
    EXPECT_EQ(seen.wrong, 0u);
    EXPECT_GT(bytes(w, "enthalpy"), 0u);
    EXPECT_EQ(bytes(w, "enthalpy_of_id"), 0u);
    for (int k = 0; k < steps; ++k) require(plain.step(dt));
    EXPECT_EQ(*w.state_hash(), *plain.state_hash());
  }
}

// What warm water weighs follows from its enthalpy, moved about or not.
TEST(Enthalpy, VolumesFollowItWhereverItLies) {
  MELTSIM_NEEDS_BACKEND();
  Tank tank;
  tank.expands = true;
  World w = make_tank(tank), moved = make_tank(tank);
  std::vector<double> nobody;
  Seen seen;
  seen.by_id = &nobody;
  require(moved.scheduler().insert_after("sph.density", {"look", look, &seen, {"enthalpy"}, {}}));
  for (World* one : {&w, &moved})
    for (int k = 0; k < steps; ++k) require(one->step(dt));
  EXPECT_EQ(bytes(w, "enthalpy"), 0u);
  EXPECT_GT(bytes(moved, "enthalpy"), 0u);
  EXPECT_EQ(*w.state_hash(), *moved.state_hash());
}

// A World that halts goes back to an order in which everyone still has their own.
TEST(Enthalpy, OutlivesAHalt) {
  MELTSIM_NEEDS_BACKEND();
  Tank tank;
  tank.gravity = {1000, 0, 0};  // out of the open face
  tank.sound_speed = 10;        // sub-steps of up to 10 ms
  World w = make_tank(tank);
  for (int k = 0; k < 45; ++k)
    require(w.step(1e-3));  // 45 m/s, 1 m: everyone has changed cell, some have left
  EXPECT_FALSE(w.synchronize().halted);
  const ParticleData before = *w.particles();
  require(w.step(6e-3));  // 0.3 m: crosses its neighbourhood, 0.25 m
  EXPECT_TRUE(w.synchronize().halted);
  const ParticleData after = *w.particles();
  ASSERT_EQ(after.id, before.id);
  EXPECT_EQ(after.enthalpy, before.enthalpy);
  EXPECT_EQ(after.position.back().x, before.position.back().x);
}

}  // namespace
}  // namespace meltsim_test
