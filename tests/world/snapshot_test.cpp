// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <random>
#include <string>
#include <tuple>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

TEST(Snapshot, RestoreAndContinueEqualsUninterrupted) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe());
  for (int k = 0; k < 60; ++k) require(a.world.step(0.005));
  const auto bytes = *a.world.snapshot();
  Scene b = ice_in_water(describe());
  require(b.world.restore(bytes.data(), bytes.size()));
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  EXPECT_EQ(a.world.steps(), b.world.steps());
  EXPECT_EQ(a.world.time(), b.world.time());
  for (int k = 0; k < 60; ++k) {
    require(a.world.step(0.005));
    require(b.world.step(0.005));
  }
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  EXPECT_EQ(a.world.synchronize().melted, b.world.synchronize().melted);
}

// Only faster the sound gets once a World runs: what a snapshot sees of what was added counts without it, too.
TEST(Snapshot, OneAheadOfAChangeByWhichLessFallsIsSeenByNothing) {
  MELTSIM_NEEDS_BACKEND();
  const struct {
    const char* name;
    void (*change)(World&, BodyId, ForceFieldId);
  } changes[] = {
      {"gravity",
       [](World& w, BodyId, ForceFieldId) {
         require(w.set_gravity({0, -2, 0}));
       }},
      {"field", [](World& w, BodyId, ForceFieldId f) { require(w.remove(f)); }},
      {"liquid",
       [](World& w, BodyId, ForceFieldId) {
         require(w.remove_liquid(Shape::box({-9, 2, -9}, {9, 9, 9})));
       }},
      {"body", [](World& w, BodyId b, ForceFieldId) { require(w.remove(b)); }},
  };
  for (const auto& c : changes) {
    SCOPED_TRACE(c.name);
    Scene one = ice_in_water(describe()), other = ice_in_water(describe());
    for (Scene* s : {&one, &other}) {
      require(s->world.step(0.002));
      FluidDesc f;
      f.material = s->water;
      f.shape = Shape::box({0, 2.0, 0}, {0.6, 2.4, 0.6});
      require(s->world.add_fluid(f));
      SolidDesc b;
      b.material = s->ice;
      b.shape = Shape::box({1.2, 1.8, 1.2}, {1.8, 2.4, 1.8});
      b.velocity = {0, -9, 0};
      const auto body = s->world.add_solid(b);
      require(body);
      ForceFieldDesc up;
      up.acceleration = {0, 30, 0};
      const auto field = s->world.add_force_field(up);
      require(field);
      if (s == &one) require(s->world.snapshot());
      c.change(s->world, *body, *field);
      require(s->world.step(0.002));
    }
    EXPECT_EQ(one.world.resolved().sound_speed, other.world.resolved().sound_speed);
    EXPECT_EQ(*one.world.state_hash(), *other.world.state_hash());
  }
}

// Heat is switched on, and what it would melt is taken out ahead of the next step: no liquid can come to be, whoever has looked
// in between. With liquid, other limits of a sub-step would hold, and other sub-steps would be taken.
TEST(Snapshot, OneAheadOfARemovalOfWhatWouldMeltIsSeenByNothing) {
  MELTSIM_NEEDS_BACKEND();
  struct Look {
    const char* name;
    void (*look)(World&);
  };
  const Look nobody{"nobody", [](World&) {}};
  const Look looks[] = {{"snapshot", [](World& w) { require(w.snapshot()); }},
                        {"plan", [](World& w) { EXPECT_EQ(w.plan().error, ""); }},
                        {"saved", [](World& w) { require(w.save_state(0)); }}};
  for (const std::uint32_t reserved : {0u, 500u}) {
    const auto run = [&](const Look& l, double& limit) {
      WorldDesc d = describe();
      d.reserved_particles = reserved;
      IceScene s;
      s.time_scale = 0;
      s.water = false;
      s.block = 0;
      Scene scene = ice_in_water(d, s);
      World& w = scene.world;
      SolidDesc b;
      b.material = scene.ice;
      b.temperature = -10;
      b.shape = Shape::box({0.8, 0, 0.8}, {1.4, 0.6, 1.4});
      const auto melts = w.add_solid(b);
      require(melts);
      MaterialDesc stone;  // which does not melt
      stone.name = "stone";
      b.material = *w.add_material(stone);
      b.temperature = 20;
      b.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
      require(w.add_solid(b));
      require(w.step(0.002));
      b.shape = Shape::box({1.6, 0, 1.6}, {2.2, 0.6, 2.2});
      require(w.add_solid(b));
      require(w.set_heat_time_scale(1));
      l.look(w);
      require(w.remove(*melts));
      require(w.step(0.02));
      limit = w.resolved().stable_dt;
      return *w.state_hash();
    };
    double unseen = 0, seen = 0;
    const std::uint64_t hash = run(nobody, unseen);
    for (const Look& l : looks) {
      SCOPED_TRACE(std::string(l.name) + (reserved != 0 ? ", in place" : ""));
      EXPECT_EQ(run(l, seen), hash);
      EXPECT_EQ(seen, unseen);
    }
  }
}

using Look = void (*)(World&);

void colder_body(Scene& s, const SolidDesc& like, Look look) {
  SolidDesc b = like;
  b.temperature = -20;
  const auto body = s.world.add_solid(b);
  require(body);
  look(s.world);
  require(s.world.remove(*body));
}

void warm_region(Scene& s, const SolidDesc& b, Look look) {
  HeatRegionDesc r;
  r.shape = b.shape;
  r.temperature = 50;
  const auto region = s.world.add_heat_region(r);
  require(region);
  look(s.world);
  require(s.world.remove(*region));
}

void stage_that_heats(Scene& s, const SolidDesc&, Look look) {
  CustomStage stage;
  stage.name = "oven";
  stage.run = [](const StageContext&, void*) {};
  stage.writes = {"enthalpy"};
  require(s.world.scheduler().insert_after("step.begin", stage));
  look(s.world);
  require(s.world.scheduler().remove("oven"));
}

/// Beside ice that is level something comes and goes, and more of that ice comes. Returns state, sub-steps and their limit.
std::tuple<std::uint64_t, std::uint64_t, double> after(void (*come_and_go)(Scene&, const SolidDesc&, Look),
                                                       Look look, std::uint32_t reserved) {
  WorldDesc d = describe();
  d.reserved_particles = reserved;
  IceScene s;
  s.time_scale = 1;
  s.water = false;
  s.block = 0;
  Scene scene = ice_in_water(d, s);
  SolidDesc b;
  b.material = scene.ice;
  b.motion = Motion::fixed;
  b.temperature = -5;
  b.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
  require(scene.world.add_solid(b));
  require(scene.world.step(0.002));
  b.shape = Shape::box({0.8, 0, 0.8}, {1.4, 0.6, 1.4});
  come_and_go(scene, b, look);
  b.shape = Shape::box({1.6, 0, 1.6}, {2.2, 0.6, 2.2});
  require(scene.world.add_solid(b));
  require(scene.world.step(0.02));
  return {*scene.world.state_hash(), scene.world.steps(), scene.world.resolved().stable_dt};
}

// What is warmer or colder than all that is there lets heat flow, and heat comes to rest in a sub-step: taken out ahead of the next one it
// does so, too, whoever has looked in between. Limits of a sub-step follow from what can melt.
TEST(Snapshot, OneAheadOfARemovalOfWhatIsWarmerIsSeenByNothing) {
  MELTSIM_NEEDS_BACKEND();
  const Look looks[] = {[](World& w) { require(w.snapshot()); }, [](World& w) { w.synchronize(); }};
  const struct {
    const char* name;
    void (*come_and_go)(Scene&, const SolidDesc&, Look);
  } changes[] = {{"body", colder_body}, {"region", warm_region}, {"stage", stage_that_heats}};
  for (const auto& c : changes)
    for (const std::uint32_t reserved : {0u, 500u}) {
      SCOPED_TRACE(std::string(c.name) + (reserved != 0 ? ", in place" : ""));
      const auto unseen = after(
          c.come_and_go, [](World&) {}, reserved);
      for (const Look look : looks) EXPECT_EQ(after(c.come_and_go, look, reserved), unseen);
    }
}

// A sound speed that was set, and what a derived one follows from, are the World's; derived, it is no slower than it was.
TEST(Snapshot, TheSoundSpeedIsThatOfTheWorldsSettings) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe());
  for (int k = 0; k < 10; ++k) require(a.world.step(0.005));
  const auto bytes = *a.world.snapshot();
  const Resolved was = a.world.resolved();
  const struct {
    const char* name;
    void (*change)(WorldDesc&, double sound);
    double times;  ///< as fast
  } settings[] = {
      {"none", [](WorldDesc&, double) {}, 1},
      {"set", [](WorldDesc& d, double sound) { d.sound_speed = 3 * sound; }, 3},
      {"set to less", [](WorldDesc& d, double sound) { d.sound_speed = 0.5 * sound; }, 0.5},
      {"more gravity", [](WorldDesc& d, double) { d.gravity = d.gravity * 4.0; }, 2},
      {"less gravity", [](WorldDesc& d, double) { d.gravity = d.gravity * 0.25; }, 1},
      {"less compression", [](WorldDesc& d, double) { d.density_error = 0.005 / 9; }, 3},
      {"more compression", [](WorldDesc& d, double) { d.density_error = 0.02; }, 1},
      {"a fast lid",
       [](WorldDesc& d, double sound) {
         d.domain.velocity[3] = {0.5 * sound, 0, 0};
       },
       5},
  };
  for (const auto& s : settings) {
    SCOPED_TRACE(s.name);
    WorldDesc desc = describe();
    s.change(desc, was.sound_speed);
    Scene b = ice_in_water(desc);
    require(b.world.restore(bytes.data(), bytes.size()));
    EXPECT_NEAR(b.world.resolved().sound_speed / (s.times * was.sound_speed), 1, s.times == 5 ? 0.05 : 1e-9);
    if (s.times == 1) {
      EXPECT_EQ(b.world.stable_dt(), was.stable_dt);
    } else if (s.times > 1) {
      EXPECT_LT(b.world.stable_dt(), was.stable_dt / (0.8 * s.times));
    }
    require(b.world.step(0.005));
  }
}

TEST(Snapshot, DamagedBytesAreRefusedAndChangeNothing) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe());
  for (int k = 0; k < 5; ++k) require(a.world.step(0.005));
  const auto good = *a.world.snapshot();
  const auto hash = *a.world.state_hash();
  std::mt19937 random(7);
  for (int k = 0; k < 200; ++k) {  // every part of the file is hit several times
    auto bad = good;
    if (k % 3 == 0) bad.resize(random() % bad.size());
    else bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    const Status s = a.world.restore(bad.data(), bad.size());
    ASSERT_FALSE(s);
    EXPECT_FALSE(s.error().message.empty());
  }
  EXPECT_FALSE(a.world.restore(nullptr, 0));
  EXPECT_EQ(*a.world.state_hash(), hash);
  require(a.world.step(0.005));
}

TEST(Snapshot, ASnapshotOfAnotherSceneIsRefusedByName) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe());
  IceScene larger;
  larger.block = 4;
  Scene b = ice_in_water(describe(), larger);
  const auto bytes = *b.world.snapshot();
  const Status s = a.world.restore(bytes.data(), bytes.size());
  ASSERT_FALSE(s);
  EXPECT_NE(s.error().message.find("lattice vertices"), std::string::npos) << s.error().message;
}

// The version stands behind eight letters. An older one, a newer one and one that no library has had are refused as that, not
// as damaged, and the message names both versions.
TEST(Snapshot, AnotherFormatVersionIsRefusedByNumber) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe());
  const std::uint64_t hash = *a.world.state_hash();
  const auto bytes = *a.world.snapshot();
  std::uint32_t own = 0;
  std::memcpy(&own, bytes.data() + 8, sizeof own);
  for (const std::uint32_t version : {own - 1, own + 1, 0u, 0xffffffffu}) {
    auto other = bytes;
    std::memcpy(other.data() + 8, &version, sizeof version);
    const Status s = a.world.restore(other.data(), other.size());
    ASSERT_FALSE(s) << version;
    EXPECT_EQ(s.error().code, ErrorCode::version_mismatch) << version;
    EXPECT_NE(s.error().message.find("version " + std::to_string(version)), std::string::npos)
        << s.error().message;
    EXPECT_NE(s.error().message.find("reads " + std::to_string(own)), std::string::npos) << s.error().message;
  }
  EXPECT_EQ(*a.world.state_hash(), hash);
}

/// A tank in which everything is that a state may hold: ice that melts and freezes, a nozzle, a body that the host moves, a proxy.
struct Everything {
  World world;
  BodyId paddle, hull;
};
Everything everything() {
  IceScene scene;
  scene.freezes = true;
  Scene s = ice_in_water(describe(), scene);
  Everything e{std::move(s.world), {}, {}};
  MaterialDesc steel;
  steel.name = "steel";
  const MaterialId material = *e.world.add_material(steel);
  SolidDesc b;
  b.material = material;
  b.shape = Shape::box({0.2, 0.2, 0.2}, {0.6, 0.6, 0.6});
  b.motion = Motion::kinematic;
  b.max_speed = 1;
  e.paddle = *e.world.add_solid(b);
  b.shape = Shape::box({1.6, 1.0, 1.6}, {2.0, 1.4, 2.0});
  b.motion = Motion::proxy;
  b.mass = 30;
  e.hull = *e.world.add_solid(b);
  EmitterDesc n;
  n.center = {1.2, 2.2, 1.2};
  n.radius = 0.7;
  n.speed = 4;
  n.material = s.water;
  n.temperature = 60;
  n.max_particles = 500;  // more than the eighth of all slots that a kernel has spare
  require(e.world.add_emitter(n));
  return e;
}
void go_on(Everything& e, int steps) {
  for (int k = 0; k < steps; ++k) {
    BodyMotion m;
    m.velocity = {k % 20 < 10 ? 0.5 : -0.5, 0, 0};
    require(e.world.set_motion(e.paddle, m));
    require(e.world.step(0.005));
  }
}

// Bits: what is gone back to goes on as it did, as often as one likes, in any order, and with as much emitted.
TEST(Saved, GoingBackRepeatsTheBits) {
  MELTSIM_NEEDS_BACKEND();
  Everything e = everything();
  go_on(e, 25);
  require(e.world.save_state(3));
  const auto at_first = *e.world.state_hash();
  const StepResult first = e.world.synchronize();
  go_on(e, 25);
  require(e.world.save_state(0));
  const auto at_second = *e.world.state_hash();
  go_on(e, 25);
  const auto at_end = *e.world.state_hash();
  const StepResult end = e.world.synchronize();
  const ProxyState hull = *e.world.proxy(e.hull);
  EXPECT_GT(end.fluid, first.fluid) << "the nozzle emits";
  EXPECT_GT(end.melted + end.frozen, first.melted + first.frozen) << "something changes phase";
  for (int again = 0; again < 2; ++again) {
    require(e.world.load_state(3));
    EXPECT_EQ(e.world.steps(), first.steps);
    EXPECT_EQ(e.world.time(), first.time);
    EXPECT_EQ(*e.world.state_hash(), at_first);
    go_on(e, 25);
    EXPECT_EQ(*e.world.state_hash(), at_second);
    require(e.world.load_state(0));
    require(e.world.load_state(0));
    go_on(e, 25);
    EXPECT_EQ(*e.world.state_hash(), at_end);
    EXPECT_EQ(e.world.synchronize().fluid, end.fluid);
    EXPECT_EQ(length(e.world.proxy(e.hull)->position - hull.position), 0);
  }
}

// Settings are the World's, whichever way it goes back: what was changed or removed after a state was saved acts as it does after restore().
// A field that had been removed acted again after load_state(), and its handle was gone; a heat region had its old power.
TEST(Saved, SettingsStayAsTheyAreLikeAfterARestore) {
  MELTSIM_NEEDS_BACKEND();
  enum class Change { remove_field, set_field, set_region, set_region_temperature, set_gravity, set_walls };
  for (const Change change : {Change::remove_field, Change::set_field, Change::set_region,
                              Change::set_region_temperature, Change::set_gravity, Change::set_walls}) {
    Scene s = ice_in_water(describe());
    World& w = s.world;
    ForceFieldDesc pull;
    pull.acceleration = {1, 0, 0};
    const ForceFieldId first = *w.add_force_field(pull);
    pull.acceleration = {0, 0, 1};
    require(w.add_force_field(pull));
    HeatRegionDesc torch;
    torch.shape = Shape::box({0, 0, 0}, {1, 1, 1});
    torch.source = 1e5;
    const HeatRegionId region = *w.add_heat_region(torch);
    SurfaceHeatDesc wall;
    wall.temperature = 30;
    require(w.set_wall_heat(2, wall));
    const auto run = [&] {
      for (int k = 0; k < 10; ++k) require(w.step(0.005));
    };
    run();
    require(w.save_state(0));
    const auto bytes = *w.snapshot();
    run();
    const auto unchanged = *w.state_hash();
    pull.acceleration = {-0.5, 0, 0};
    wall.temperature = 80;
    switch (change) {
      case Change::remove_field:
        require(w.remove(first));
        break;
      case Change::set_field:
        require(w.set_force_field(first, pull));
        break;
      case Change::set_region:
        require(w.set_heat_region(region, {}, 3e5));
        break;
      case Change::set_region_temperature:
        require(w.set_heat_region(region, 60.0));
        break;
      case Change::set_gravity:
        require(w.set_gravity({0, -2, 0}));
        break;
      case Change::set_walls:
        require(w.set_wall_heat(2, wall));
        break;
    }
    require(w.load_state(0));
    run();
    const auto loaded = *w.state_hash();
    require(w.restore(bytes.data(), bytes.size()));
    run();
    EXPECT_EQ(loaded, *w.state_hash()) << static_cast<int>(change);
    EXPECT_NE(loaded, unchanged) << static_cast<int>(change);
  }
}

// What a host says a body will do at most costs no saved state when it does it; beyond that sound is made faster, and they are lost.
TEST(Saved, AreKeptWhereABodyIsAsFastAsItWasSaidToBe) {
  MELTSIM_NEEDS_BACKEND();
  for (const Motion motion : {Motion::free, Motion::rigid}) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.domain.bounded = true;
    d.domain.max = {2, 2, 2};
    World w = *World::create(d);
    SolidDesc b;
    b.material = *w.add_material({});
    b.shape = Shape::box({0.5, 0.5, 0.5}, {0.9, 0.9, 0.9});
    b.motion = motion;
    b.max_speed = 12;
    const BodyId id = *w.add_solid(b);
    require(w.step(1.0 / 120));
    EXPECT_GE(w.resolved().sound_speed, 120);
    require(w.save_state(0));
    require(w.set_velocity(id, {10, 0, 0}));
    require(w.step(1.0 / 120));
    require(w.load_state(0));
    require(w.set_velocity(id, {13, 0, 0}));
    require(w.step(1.0 / 240));
    EXPECT_FALSE(w.load_state(0));
  }
}

// Liquid alone takes the steps that put a state elsewhere (sph.advance) on a GPU.
TEST(Saved, OfLiquidAlone) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  d.heat.model = HeatModel::none;
  World w = *World::create(d);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {0.5, 0.6, 1});
  require(w.add_fluid(f));
  const auto run = [&](int n) {
    for (int k = 0; k < n; ++k) require(w.step(0.003));
  };
  run(7);
  require(w.save_state(1));
  run(10);
  const auto hash = *w.state_hash();
  for (int again = 0; again < 3; ++again) {
    require(w.load_state(1));
    run(10);
    EXPECT_EQ(*w.state_hash(), hash);
  }
}

// A World that halted goes on from the state before. Nothing is saved of one that has, whoever knows of it.
TEST(Saved, AWorldThatHaltedGoesBack) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.heat.model = HeatModel::none;
  d.sound_speed = 20;
  World w = *World::create(d);
  SolidDesc b;
  b.material = *w.add_material({});
  b.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  const BodyId id = *w.add_solid(b);
  require(w.step(0.01));
  require(w.save_state(0));
  require(w.step(0.01));
  const auto hash = *w.state_hash();
  require(w.apply_impulse(id, {27.0 * 1e5, 0, 0}));  // 1e5 m/s: across its neighbourhood in a sub-step
  require(w.step(0.01));
  require(w.save_state(1));  // it does not wait, so that the host cannot know yet
  EXPECT_TRUE(w.synchronize().halted);
  EXPECT_FALSE(w.step(0.01));
  const Status late = w.save_state(1);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::halted);
  EXPECT_FALSE(w.load_state(1)) << "nothing was saved";
  require(w.load_state(0));
  EXPECT_FALSE(w.synchronize().halted);
  require(w.step(0.01));
  EXPECT_EQ(*w.state_hash(), hash);
}

// A host that never asks: it saves a World that has halted, goes back to an earlier state, and only then to what it saved. There is
// nothing, and the World halts once more and says why, instead of going on from another state than the host believes.
TEST(Saved, WhatWasNotSavedHaltsTheWorld) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.heat.model = HeatModel::none;
  d.sound_speed = 20;
  World w = *World::create(d);
  SolidDesc b;
  b.material = *w.add_material({});
  b.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  const BodyId id = *w.add_solid(b);
  require(w.step(0.01));
  require(w.save_state(0));
  require(w.step(0.01));
  require(w.save_state(2));  // of this time, and further than what is to come
  require(w.load_state(0));
  require(w.apply_impulse(id, {27.0 * 1e5, 0, 0}));
  require(w.step(0.01));
  require(w.save_state(1));
  require(w.load_state(0));
  require(w.step(0.005));
  require(w.load_state(1));
  require(w.step(0.01));
  const StepResult r = w.synchronize();
  EXPECT_TRUE(r.halted);
  EXPECT_NE(r.halt_reason.find("nothing was saved"), std::string::npos) << r.halt_reason;
  require(w.load_state(2));
  EXPECT_FALSE(w.synchronize().halted);
  const auto hash = *w.state_hash();
  require(w.load_state(0));
  require(w.step(0.01));
  EXPECT_EQ(*w.state_hash(), hash);
}

TEST(Saved, WhatIsLostOrWasNeverThereIsRefusedByName) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  const auto refused = [](const Status& r, const std::string& part) {
    ASSERT_FALSE(r) << part;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(part), std::string::npos) << r.error().message;
  };
  refused(s.world.save_state(-1), "slot: must be 0 to 15");
  refused(s.world.load_state(most_saved_states), "slot: must be 0 to 15");
  refused(s.world.load_state(0), "nothing is saved");
  require(s.world.save_state(0));
  require(s.world.step(0.005));
  MaterialDesc m;
  m.name = "other";
  require(s.world.add_material(m));
  const auto hash = *s.world.state_hash();
  refused(s.world.load_state(0), "is lost");
  require(s.world.prepare());
  refused(s.world.load_state(0), "is lost");
  EXPECT_EQ(*s.world.state_hash(), hash);
  require(s.world.save_state(0));
  require(s.world.step(0.005));
  require(s.world.load_state(0));
  EXPECT_EQ(*s.world.state_hash(), hash);
  MaterialDesc thicker = s.world.material(s.water);
  thicker.viscosity *= 2;
  require(s.world.set_material(s.water, thicker));
  refused(s.world.load_state(0), "set_material");
  EXPECT_EQ(*s.world.state_hash(), hash);
}

// A reading that is open keeps its values, whatever is gone back to.
TEST(Saved, OpenReadingsKeepTheirValues) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  require(s.world.save_state(0));
  for (int k = 0; k < 5; ++k) require(s.world.step(0.005));
  ReadRequest what;
  what.totals = true;
  const std::uint64_t then = s.world.steps();
  const auto ticket = s.world.request(what);
  ASSERT_TRUE(ticket);
  require(s.world.load_state(0));
  const auto reading = s.world.take(*ticket);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->step, then);
  EXPECT_EQ(s.world.steps(), 0u);
}

}  // namespace
}  // namespace meltsim_test
