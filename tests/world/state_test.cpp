// SPDX-License-Identifier: Apache-2.0
// What a World is like after something went wrong: refused calls change nothing, halts are not lost, snapshots fit.
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();
const double inf = std::numeric_limits<double>::infinity();

WorldDesc open_air(double spacing = 0.1) {
  WorldDesc d = describe();
  d.spacing = spacing;
  return d;
}

FluidDesc liquid(MaterialId material, Vec3d low, Vec3d high) {
  FluidDesc f;
  f.material = material;
  f.shape = Shape::box(low, high);
  return f;
}

SolidDesc block(MaterialId material, Vec3d low, Vec3d high) {
  SolidDesc s;
  s.material = material;
  s.shape = Shape::box(low, high);
  return s;
}

EmitterDesc nozzle(MaterialId material, Vec3d center) {
  EmitterDesc e;
  e.material = material;
  e.center = center;
  e.radius = 0.15;
  e.speed = 2;
  e.until = 10;
  return e;
}

/// A fixed body, so that nothing limits sub-steps, in a region whose source single precision does not hold: the second
/// sub-step is the first that begins with it.
struct Bullet {
  World world;
  MaterialId stone;
};
Bullet bullet() {
  auto w = World::create(describe());
  EXPECT_TRUE(w) << w.error().message;
  Bullet b{std::move(*w), {}};
  MaterialDesc m;
  m.name = "stone";
  b.stone = *b.world.add_material(m);
  SolidDesc s = block(b.stone, {0, 0, 0}, {0.6, 0.6, 0.6});
  s.fixed = true;
  require(b.world.add_solid(s));
  HeatRegionDesc r;
  r.shape = s.shape;
  r.source = 1e100;
  r.from = 0.01;
  require(b.world.add_heat_region(r));
  return b;
}

/// Writes a NaN into the acceleration of the first particle in the n-th sub-step, on the host.
struct Spoiler {
  int left;
  static void run(const StageContext& c, void* user) {
    if (--static_cast<Spoiler*>(user)->left == 0)
      static_cast<Vec3<float>*>(c.acceleration)[0].z = std::numeric_limits<float>::quiet_NaN();
  }
};

// --- refused calls ----------------------------------------------------------------------------------------------------

/// Everything of a World that a refused call might have changed.
struct Picture {
  std::vector<std::uint8_t> snapshot;
  std::uint64_t hash = 0, steps = 0;
  double time = 0, stable_dt = 0, sound_speed = 0;
  std::string plan;
  Vec3d origin;
};
Picture picture(World& w) {
  Picture p;
  p.snapshot = *w.snapshot();
  p.hash = *w.state_hash();
  Plan plan = w.plan();
  plan.bytes = 0;  // looking for what lies at a place makes room to read it, which is kept
  p.plan = plan.to_string();
  const Resolved r = w.resolved();
  p.origin = r.origin;
  p.sound_speed = r.sound_speed;
  p.steps = w.steps();
  p.time = w.time();
  p.stable_dt = w.stable_dt();
  return p;
}
void expect_same(const Picture& a, const Picture& b, const std::string& call) {
  EXPECT_TRUE(a.snapshot == b.snapshot) << call << ": the snapshot differs";
  EXPECT_EQ(a.hash, b.hash) << call;
  EXPECT_EQ(a.steps, b.steps) << call;
  EXPECT_EQ(a.time, b.time) << call;
  EXPECT_EQ(a.stable_dt, b.stable_dt) << call;
  EXPECT_EQ(a.sound_speed, b.sound_speed) << call;
  EXPECT_TRUE(a.plan == b.plan) << call << ": the plan differs";
  EXPECT_EQ(a.origin.x, b.origin.x) << call;
}

struct BadCall {
  const char* what;
  std::function<std::string(World&)> call;  ///< the error's message; empty: accepted
};
template <class R>
std::string message_of(const R& r) {
  return r ? std::string() : r.error().message;
}
template <class F>
BadCall bad(const char* what, F call) {
  return {what, [call](World& w) { return message_of(call(w)); }};
}

std::vector<BadCall> bad_calls(const Scene& s) {
  const MaterialId water = s.water, ice = s.ice;
  const auto fluid = [](auto change, MaterialId m) {
    return [=](World& w) {
      FluidDesc f = liquid(m, {0.2, 1.0, 0.2}, {0.8, 1.4, 0.8});
      change(f);
      return w.add_fluid(f);
    };
  };
  const auto solid = [](auto change, MaterialId m) {
    return [=](World& w) {
      SolidDesc b = block(m, {0.2, 1.8, 0.2}, {0.6, 2.2, 0.6});
      change(b);
      return w.add_solid(b);
    };
  };
  const auto emitter = [](auto change, MaterialId m) {
    return [=](World& w) {
      EmitterDesc e = nozzle(m, {0.4, 2.0, 0.4});
      e.radius = 0.3;
      e.until = w.time() + 1;
      change(e);
      return w.add_emitter(e);
    };
  };
  const auto region = [](auto change) {
    return [=](World& w) {
      HeatRegionDesc r;
      r.shape = Shape::box({0, 0, 0}, {1, 1, 1});
      r.source = 1;
      change(r);
      return w.add_heat_region(r);
    };
  };
  const auto material = [](auto change) {
    return [=](World& w) {
      MaterialDesc m;
      m.name = "new";
      change(m);
      return w.add_material(m);
    };
  };
  const auto restored = [](auto change) {
    return [=](World& w) {
      auto bytes = *w.snapshot();
      change(bytes);
      return w.restore(bytes.data(), bytes.size());
    };
  };
  return {
      bad("material: name taken", material([](MaterialDesc& m) { m.name = "water"; })),
      bad("material: density", material([](MaterialDesc& m) { m.density = nan; })),
      bad("material: a table with a NaN", material([](MaterialDesc& m) {
            m.viscosity_points = {{0, 1}, {1, nan}};
          })),
      bad("material: melts into nothing", material([](MaterialDesc& m) {
            m.melting_point = 1;
            m.melts_into = {9, 1};
          })),
      bad("fluid: all taken", fluid(
                                  [](FluidDesc& f) {
                                    f.shape = Shape::box({0.2, 0, 0.2}, {0.6, 0.4, 0.6});
                                  },
                                  water)),
      bad("fluid: outside", fluid(
                                [](FluidDesc& f) {
                                  f.shape = Shape::box({0, 0, 0}, {9, 1, 1});
                                },
                                water)),
      bad("fluid: far away", fluid(
                                 [](FluidDesc& f) {
                                   f.shape = Shape::box({1e6, 0, 0}, {1e6 + 1, 1, 1});
                                 },
                                 water)),
      bad("fluid: velocity", fluid([](FluidDesc& f) { f.velocity.x = inf; }, water)),
      bad("fluid: a velocity whose square is no number",
          fluid([](FluidDesc& f) { f.velocity.x = 1e30; }, water)),
      bad("fluid: temperature", fluid([](FluidDesc& f) { f.temperature = -1000; }, water)),
      bad("fluid: of a solid", fluid([](FluidDesc&) {}, ice)),
      bad("fluid: no material", fluid([](FluidDesc&) {}, MaterialId{7, 1})),
      bad("solid: name taken", solid([](SolidDesc& b) { b.name = "block"; }, ice)),
      bad("solid: overlap", solid(
                                [](SolidDesc& b) {
                                  b.shape = Shape::box({0.9, 1.3, 0.9}, {1.3, 1.9, 1.3});
                                },
                                ice)),
      bad("solid: liquid in its place", solid(
                                            [](SolidDesc& b) {
                                              b.shape = Shape::box({0.2, 0.2, 0.2}, {0.6, 0.6, 0.6});
                                              b.carve = false;
                                            },
                                            ice)),
      bad("solid: growth", solid([](SolidDesc& b) { b.growth = 2; }, ice)),
      bad("solid: on a nozzle", solid(
                                    [](SolidDesc& b) {
                                      b.shape = Shape::box({1.6, 1.8, 1.6}, {2.2, 2.2, 2.2});
                                    },
                                    ice)),
      bad("solid: spin", solid([](SolidDesc& b) { b.angular_velocity.z = nan; }, ice)),
      bad("solid: a spin whose square is no number",
          solid([](SolidDesc& b) { b.angular_velocity.z = 1e30; }, ice)),
      bad("emitter: outside", emitter(
                                  [](EmitterDesc& e) {
                                    e.center = {1e6, 0, 0};
                                  },
                                  water)),
      bad("emitter: in a wall", emitter(
                                    [](EmitterDesc& e) {
                                      e.center = {0.1, 2, 0.1};
                                    },
                                    water)),
      bad("emitter: in a body", emitter(
                                    [](EmitterDesc& e) {
                                      e.center = {1.1, 1.5, 1.1};
                                    },
                                    water)),
      bad("emitter: on another", emitter(
                                     [](EmitterDesc& e) {
                                       e.center = {1.8, 2, 1.8};
                                     },
                                     water)),
      bad("emitter: axis", emitter(
                               [](EmitterDesc& e) {
                                 e.axis = {0, 0, 0};
                               },
                               water)),
      bad("emitter: less than a layer", emitter([](EmitterDesc& e) { e.max_particles = 1; }, water)),
      bad("emitter: 1e9 spacings wide", emitter([](EmitterDesc& e) { e.radius = 2e8; }, water)),
      bad("emitter: emits for ever", emitter([](EmitterDesc& e) { e.until = inf; }, water)),
      bad("emitter: speed", emitter([](EmitterDesc& e) { e.speed = 1e30; }, water)),
      bad("region: nothing in it", region([](HeatRegionDesc& r) {
            r.shape = Shape::sphere({1, 1, 1}, 0.001);
          })),
      bad("region: source", region([](HeatRegionDesc& r) { r.source = nan; })),
      bad("step: negative", [](World& w) { return w.step(-1); }),
      bad("step: NaN", [](World& w) { return w.step(nan); }),
      bad("step: too long", [](World& w) { return w.step(1e6); }),
      bad("step: beyond single precision", [](World& w) { return w.step(1e39); }),
      bad("restore: nothing", [](World& w) { return w.restore(nullptr, 0); }),
      bad("restore: cut", restored([](auto& b) { b.resize(b.size() / 2); })),
      bad("restore: changed", restored([](auto& b) { b[b.size() / 2] ^= 1; })),
      bad("stage: no function",
          [](World& w) {
            return w.scheduler().insert_after("step.begin", {"x", nullptr, nullptr, {}, {}});
          }),
      bad("stage: nowhere",
          [](World& w) {
            return w.scheduler().insert_after("nowhere",
                                              {"x", [](const StageContext&, void*) {}, nullptr, {}, {}});
          }),
      bad("stage: none of this name", [](World& w) { return w.scheduler().remove("x"); }),
      bad("interval", [](World& w) { return w.scheduler().set_interval("thermal", 0); }),
      bad("interval of heat", [](World& w) { return w.scheduler().set_interval("thermal", 1001); }),
      bad("interval of a module", [](World& w) { return w.scheduler().set_interval("sph", 2); }),
      bad("enable", [](World& w) { return w.scheduler().enable("step", false); }),
      bad("sample",
          [](World& w) {
            return w.sample({{0, 0, 0}}, "colour");
          }),
      bad("surface",
          [](World& w) {
            SurfaceDesc d;
            d.cell = -1;
            return w.surface(d);
          }),
      bad("take", [](World& w) { return w.take(ReadTicket{1u << 30}); }),
  };
}

Scene busy_scene() {
  Scene s = ice_in_water(describe());
  EmitterDesc e = nozzle(s.water, {1.8, 2.0, 1.8});
  e.radius = 0.3;
  require(s.world.add_emitter(e));
  HeatRegionDesc r;
  r.shape = Shape::box({0, 0, 0}, {1, 1, 1});
  r.source = 1e5;
  require(s.world.add_heat_region(r));
  return s;
}

TEST(Refused, ChangesNothingThatAnyoneCouldSee) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = busy_scene(), twin = busy_scene();
  for (int k = 0; k < 12; ++k) {
    require(s.world.step(0.004));
    require(twin.world.step(0.004));
  }
  const auto before = picture(s.world);
  expect_same(before, picture(twin.world), "the twin");
  for (const BadCall& b : bad_calls(s)) {
    const std::string message = b.call(s.world);
    EXPECT_NE(message, "") << b.what << " was accepted";
    expect_same(before, picture(s.world), b.what);
    static_cast<void>(picture(twin.world));  // what a snapshot does to what follows, it does to both
  }
  for (int k = 0; k < 12; ++k) {
    require(s.world.step(0.004));
    require(twin.world.step(0.004));
  }
  EXPECT_EQ(*s.world.state_hash(), *twin.world.state_hash());
}

// A place far away is the World's origin only once something is there.
TEST(Refused, LeavesTheOriginWhereItWas) {
  MELTSIM_NEEDS_BACKEND();
  const auto calls = {0, 1, 2};
  for (const int call : calls) {
    auto w = World::create(open_air());
    ASSERT_TRUE(w);
    const auto water = *w->add_material({});
    EmitterDesc e = nozzle(water, {1e6, 0, 0});
    e.max_particles = 1;  // less than a layer
    SolidDesc b = block(water, {1e6, 0, 0}, {1e6 + 1, 1, 1});
    b.growth = 2;  // of what does not freeze
    FluidDesc f = liquid(water, {1e6, 0, 0}, {1e6 + 1, 1, 1});
    f.velocity = {1e30, 0, 0};
    if (call == 0) {
      ASSERT_FALSE(w->add_emitter(e));
    } else if (call == 1) {
      ASSERT_FALSE(w->add_solid(b));
    } else {
      ASSERT_FALSE(w->add_fluid(f));
    }
    require(w->add_fluid(liquid(water, {0, 0, 0}, {0.4, 0.4, 0.4})));
    EXPECT_EQ(w->resolved().origin.x, 0.0);
  }
}

// --- halts ------------------------------------------------------------------------------------------------------------

// Whatever comes between a sub-step that diverged and the next look at it, the World says that it halted, and when.
TEST(Halt, IsFoundByWhateverComesNext) {
  MELTSIM_NEEDS_BACKEND();
  const std::vector<std::function<void(Bullet&)>> next = {
      [](Bullet& b) {
        MaterialDesc m;
        m.name = "other";
        require(b.world.add_material(m));
      },
      [](Bullet& b) {
        require(b.world.add_fluid(liquid(b.stone, {5, 0, 0}, {5.4, 0.4, 0.4})));
      },
      [](Bullet& b) {
        require(b.world.add_solid(block(b.stone, {5, 0, 0}, {5.4, 0.4, 0.4})));
      },
      [](Bullet& b) { require(b.world.scheduler().enable("thermal", false)); },
      [](Bullet& b) {
        require(b.world.scheduler().insert_after(
            "step.begin", {"x", [](const StageContext&, void*) {}, nullptr, {"enthalpy"}, {}}));
      },
      [](Bullet& b) { require(b.world.snapshot()); },
      [](Bullet& b) {
        SurfaceDesc d;
        d.of = SurfaceOf::solids;
        require(b.world.surface(d));
      },
      [](Bullet& b) {
        const auto bytes = *b.world.snapshot();
        b = bullet();
        require(b.world.restore(bytes.data(), bytes.size()));
        EXPECT_EQ(b.world.time(), 0.01);  // that of the last good state
        EXPECT_EQ(b.world.steps(), 1u);
        for (int k = 0; k < 3; ++k) require(b.world.step(0.02));
        EXPECT_TRUE(b.world.synchronize().halted);
        EXPECT_EQ(b.world.steps(), 1u);
        require(b.world.restore(bytes.data(), bytes.size()));
        EXPECT_FALSE(b.world.synchronize().halted) << "what halted before it was restored is past";
        for (int k = 0; k < 3; ++k) require(b.world.step(0.02));
      }};
  for (std::size_t k = 0; k < next.size(); ++k) {
    Bullet b = bullet();
    require(b.world.step(0.01));
    const auto good = *b.world.state_hash();
    const double mass = b.world.totals()->mass;
    for (int n = 0; n < 10; ++n) require(b.world.step(0.02));
    next[k](b);
    const Status s = b.world.step(0.01);
    const StepResult r = b.world.synchronize();
    EXPECT_TRUE(r.halted) << k;
    EXPECT_NE(r.halt_reason.find("sub-step 2"), std::string::npos) << k << r.halt_reason;
    EXPECT_EQ(r.halt_step, 2u) << k;
    EXPECT_EQ(r.steps, 1u) << k;
    EXPECT_EQ(b.world.time(), 0.01) << k;
    if (k >= 3) {
      EXPECT_NEAR(b.world.totals()->mass, mass, 1e-9 * mass) << k;  // an upload changes the order of a sum
    }
    if (k >= 3) {  // nothing was added
      EXPECT_EQ(*b.world.state_hash(), good) << k;
    }
    if (k + 1 < next.size()) {
      ASSERT_EQ(bool(s), k == 0)
          << k;  // found by the call between; a material is added without a look at particles
      if (k > 0) {
        EXPECT_EQ(s.error().code, ErrorCode::halted);
      }
    }
    EXPECT_FALSE(b.world.step(0.01)) << k;
    EXPECT_TRUE(b.world.synchronize().halted) << k << ": until a snapshot is restored";
  }
}

// A World that halted owes the layers that its nozzles would have emitted since.
TEST(Halt, NozzlesGoBackWithTheClock) {
  MELTSIM_NEEDS_BACKEND();
  const auto make = [] {
    Bullet b{*World::create(describe()), {}};
    b.stone = *b.world.add_material({});
    require(b.world.add_solid(block(b.stone, {0, 0, 0}, {0.6, 0.6, 0.6})));
    EmitterDesc e = nozzle(b.stone, {-5, 0, 0});
    e.radius = 0.3;
    require(b.world.add_emitter(e));
    return b;
  };
  Bullet b = make(), reference = make();
  const double dt = 0.002;  // below what the sound speed of the jet allows
  const auto steps = [&](World& w, int n) {
    for (int k = 0; k < n; ++k) require(w.step(dt));
  };
  require(b.world.prepare());
  // It halts long before what is enqueued ends.
  steps(b.world, 1);
  Spoiler spoiler{1};
  if (backend() == Backend::cuda) GTEST_SKIP() << "the stage below runs on the host";
  require(b.world.scheduler().insert_after("sph.forces",
                                           {"spoil", Spoiler::run, &spoiler, {}, {"acceleration"}}));
  steps(b.world, 200);
  const auto bytes = *b.world.snapshot();
  Bullet restored = make();
  require(restored.world.restore(bytes.data(), bytes.size()));
  EXPECT_LT(restored.world.time(), 0.01);
  steps(restored.world, 250 - static_cast<int>(std::lround(restored.world.time() / dt)));
  steps(reference.world, 250);
  EXPECT_NEAR(restored.world.time(), reference.world.time(), 0.5 * dt);
  EXPECT_GT(reference.world.synchronize().fluid, 20u);
  EXPECT_EQ(restored.world.synchronize().fluid, reference.world.synchronize().fluid);
}

// --- growth -----------------------------------------------------------------------------------------------------------

World basin() {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1, 2, 1};
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

// However a pool came about, liquid in it is as stiff as its depth wants.
TEST(Growth, TheSoundSpeedFollowsWhatIsAdded) {
  MELTSIM_NEEDS_BACKEND();
  const auto pool = [](World& w, MaterialId m) { return w.add_fluid(liquid(m, {0, 0, 0}, {1, 0.6, 1})); };
  World whole = basin();
  require(whole.add_material({}));
  const MaterialId water{0, 1};  // the first of any World
  require(pool(whole, water));
  const double c = whole.resolved().sound_speed;
  EXPECT_NEAR(c, 10 * std::sqrt(2 * 9.81 * 0.65), 1.0);  // half a spacing more or less

  World empty = basin();
  require(empty.add_material({}));
  require(empty.step(0.01));
  require(pool(empty, water));
  EXPECT_EQ(empty.resolved().sound_speed, c);

  World puddle = basin();
  require(puddle.add_material({}));
  require(puddle.add_fluid(liquid(water, {0, 0, 0}, {1, 0.2, 1})));
  require(puddle.step(0.01));
  const double first = puddle.resolved().sound_speed;
  EXPECT_LT(first, 0.7 * c);
  require(pool(puddle, water));
  EXPECT_EQ(puddle.resolved().sound_speed, c);
  EXPECT_LT(puddle.stable_dt(), 0.8 * 0.4 * 0.25 / first);  // courant H / c of before

  // It depends on what was added, not on where it is by now: reading or switching changes nothing.
  for (int k = 0; k < 20; ++k) require(puddle.step(0.002));
  require(puddle.scheduler().enable("thermal", false));
  MaterialDesc other;
  other.name = "other";
  require(puddle.add_material(other));
  EXPECT_EQ(puddle.resolved().sound_speed, c);
  EXPECT_FALSE(puddle.synchronize().halted);
}

TEST(Growth, AFastJetAddedLaterIsTakenIntoAccount) {
  MELTSIM_NEEDS_BACKEND();
  World w = basin();
  const auto water = *w.add_material({});
  require(w.add_fluid(liquid(water, {0, 0, 0}, {1, 0.4, 1})));
  require(w.step(0.002));
  EmitterDesc e = nozzle(water, {0.5, 1.5, 0.5});
  e.speed = 20;
  e.until = 0.2;
  require(w.add_emitter(e));
  EXPECT_GE(w.resolved().sound_speed, 200.0);
  for (int k = 0; k < 100; ++k) require(w.step(0.002));
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
}

// What was derived belongs to the state: a World of which only the last scene is known goes on like the one that grew.
TEST(Growth, IsInTheSnapshot) {
  MELTSIM_NEEDS_BACKEND();
  const auto build = [](World& w, bool grows) {
    const auto water = *w.add_material({});
    require(w.add_fluid(liquid(water, {0, 0, 0}, {1, 0.2, 1})));
    if (grows) require(w.step(0.01));
    require(w.add_fluid(liquid(water, {0.2, 1.0, 0.2}, {0.6, 1.4, 0.6})));
  };
  World a = basin(), b = basin();
  build(a, true);
  build(b, false);
  const MaterialId water{0, 1};  // the first of any World
  for (int k = 0; k < 20; ++k) require(a.step(0.002));
  const auto bytes = *a.snapshot();
  require(b.restore(bytes.data(), bytes.size()));
  EXPECT_EQ(a.resolved().sound_speed, b.resolved().sound_speed);
  for (World* w : {&a, &b}) {
    for (int k = 0; k < 10; ++k) require(w->step(0.002));
    require(w->add_fluid(liquid(water, {0.2, 1.5, 0.2}, {0.6, 1.9, 0.6})));
    for (int k = 0; k < 10; ++k) require(w->step(0.002));
  }
  EXPECT_EQ(a.resolved().sound_speed, b.resolved().sound_speed);
  EXPECT_EQ(*a.state_hash(), *b.state_hash());
}

// --- snapshots --------------------------------------------------------------------------------------------------------

// Regions are as wide as a modulus wants at the scene's largest sub-step, which a World knows once it is prepared: no matter
// to whose snapshot it is.
TEST(Own, SnapshotOfAWorldWhoseRegionsWereWidened) {
  MELTSIM_NEEDS_BACKEND();
  const auto make = [] {
    WorldDesc d = describe();
    d.spacing = 0.1;
    auto w = World::create(d);
    EXPECT_TRUE(w);
    MaterialDesc rubber;
    rubber.name = "rubber";
    rubber.youngs_modulus = 1e7;
    const auto m = *w->add_material(rubber);
    MaterialDesc water;
    EXPECT_TRUE(w->add_solid(block(m, {0, 0, 0}, {0.6, 0.6, 0.6})));
    EXPECT_TRUE(w->add_fluid(liquid(*w->add_material(water), {1, 0, 0}, {1.4, 0.4, 0.4})));
    return std::move(*w);
  };
  World a = make();
  require(a.prepare());
  const double dt = a.stable_dt();
  require(a.step(dt));
  const auto bytes = *a.snapshot();
  require(a.step(dt / 8));
  require(a.restore(bytes.data(), bytes.size()));  // its own
  World fresh = make();
  require(fresh.restore(bytes.data(), bytes.size()));
  World prepared = make();
  require(prepared.step(dt / 8));
  require(prepared.restore(bytes.data(), bytes.size()));
  for (World* w : {&a, &fresh, &prepared})
    for (int k = 0; k < 5; ++k) require(w->step(dt));
  EXPECT_EQ(*a.state_hash(), *fresh.state_hash());
  EXPECT_EQ(*a.state_hash(), *prepared.state_hash());
}

/// The bytes with a good checksum (FNV-1a, the last 8).
std::vector<std::uint8_t> signed_again(std::vector<std::uint8_t> bytes) {
  std::uint64_t h = 14695981039346656037ull;
  for (std::size_t k = 0; k + 8 < bytes.size(); ++k) h = (h ^ bytes[k]) * 1099511628211ull;
  std::memcpy(bytes.data() + bytes.size() - 8, &h, 8);
  return bytes;
}

// Damage that a checksum does not show, everywhere and of every kind: what is no number is refused, and a World that takes
// what is left goes on without a fault.
TEST(Snapshot, EveryFieldIsValidated) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = busy_scene(), other = busy_scene();
  for (int k = 0; k < 5; ++k) require(s.world.step(0.005));
  const auto good = *s.world.snapshot();
  require(s.world.restore(good.data(), good.size()));
  const auto hash = *s.world.state_hash();
  int refused = 0, taken = 0;
  const auto put = [&](std::size_t at, const void* value) {
    auto bytes = good;
    std::memcpy(bytes.data() + at, value, 8);
    return signed_again(std::move(bytes));
  };
  const double values[] = {nan, inf, -inf, 1e300, -1e300, -1};
  // The header whole (magic and version are 12 bytes), then samples of the arrays: 8-byte words, most of them doubles.
  for (std::size_t at = 16; at + 16 < good.size(); at += at < 300 ? 8 : 8 * 131)
    for (const double v : values) {
      const auto bytes = put(at, &v);
      if (bytes == good) continue;
      const Status status = other.world.restore(bytes.data(), bytes.size());
      if (!status) {
        ++refused;
        EXPECT_FALSE(status.error().message.empty());
        continue;
      }
      ++taken;
      const Totals t = *other.world.totals();
      EXPECT_TRUE(std::isfinite(t.mass) && std::isfinite(t.kinetic) && std::isfinite(t.thermal) &&
                  std::isfinite(t.heat_in) && std::isfinite(t.momentum.x))
          << "at byte " << at << ", " << v;
      EXPECT_TRUE(std::isfinite(other.world.time()) && other.world.time() >= 0) << "at byte " << at;
      static_cast<void>(other.world.step(0.001));
      static_cast<void>(other.world.synchronize());
    }
  EXPECT_GT(refused, 5 * taken)
      << taken;  // a slip, a piece's label or a liquid's velocity may be other than it was
  require(other.world.restore(good.data(), good.size()));
  EXPECT_EQ(*other.world.state_hash(), hash);
}

TEST(Snapshot, OfOtherMaterialsIsRefusedByName) {
  MELTSIM_NEEDS_BACKEND();
  const auto make = [](double latent_heat, double capacity) {
    IceScene ice;
    ice.latent_heat = latent_heat;
    Scene s = ice_in_water(describe(), ice);
    MaterialDesc oil;
    oil.name = "oil";
    oil.heat_capacity = capacity;
    require(s.world.add_material(oil));
    return s;
  };
  Scene a = make(3e5, 2000);
  const auto bytes = *a.world.snapshot();
  require(a.world.restore(bytes.data(), bytes.size()));
  Scene latent = make(2e5, 2000), capacity = make(3e5, 1000);
  const Status first = latent.world.restore(bytes.data(), bytes.size());
  ASSERT_FALSE(first);
  EXPECT_NE(first.error().message.find("\"ice\""), std::string::npos) << first.error().message;
  EXPECT_EQ(first.error().code, ErrorCode::invalid_argument);
  // What does not touch the meaning of the state may change.
  MaterialDesc thick;
  Scene other = ice_in_water(describe());
  thick.name = "oil";
  thick.heat_capacity = 2000;
  thick.viscosity = 0.5;
  thick.friction = 0.1;
  require(other.world.add_material(thick));
  Scene same = ice_in_water(describe());
  thick.name = "honey";
  thick.viscosity = 5;
  require(same.world.add_material(thick));
  const auto thin = *other.world.snapshot();
  require(same.world.restore(thin.data(), thin.size()));
  const Status second = capacity.world.restore(bytes.data(), bytes.size());
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("\"oil\""), std::string::npos) << second.error().message;
}

// While a thread is in a call, another one's are refused and change nothing; calls from a stage of the same thread go on. The other
// thread calls while the stage runs, so nothing hangs on when.
TEST(State, TwoThreadsAtATimeAreRefused) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  struct Seen {
    World* world;
    Status step, totals, own, remove;
    std::string report;
  } seen{&s.world, {}, {}, {}, {}, {}};
  const auto intrude = [](const StageContext&, void* user) {
    Seen& to = *static_cast<Seen*>(user);
    std::thread other([&to] {
      to.step = to.world->step(0.001);
      const auto totals = to.world->totals();
      to.totals = totals ? Status{} : Status{totals.error()};
      to.report = to.world->synchronize().error;
    });
    other.join();
    to.own = to.world->set_gravity({0, -9.81, 0});
    std::thread taker([&to] { to.remove = to.world->scheduler().remove("intrude"); });
    taker.join();
  };
  require(s.world.scheduler().insert_after("sph.forces", {"intrude", intrude, &seen, {}, {}}));
  require(s.world.step(0.5 * s.world.resolved().stable_dt));
  for (const Status* status : {&seen.step, &seen.totals, &seen.remove}) {
    ASSERT_FALSE(*status);
    EXPECT_EQ(status->error().code, ErrorCode::invalid_argument);
    EXPECT_NE(status->error().message.find("another thread is in a call"), std::string::npos);
  }
  EXPECT_NE(seen.report.find("another thread is in a call"), std::string::npos);
  require(seen.own);
  require(s.world.scheduler().remove("intrude"));
  EXPECT_EQ(s.world.steps(), 1u);
  std::thread later([&] { require(s.world.step(0.001)); });  // another thread may go on
  later.join();
  EXPECT_FALSE(s.world.synchronize().halted);
}

// What a stage calls of the World that runs it would find a sub-step half done, or take the stage away below itself. Two stages: the one
// that calls goes on to be called.
TEST(State, AStageIsRefusedWhatChangesOrReadsItsWorld) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe()), other = ice_in_water(describe());
  struct Seen {
    World* world;
    int calls = 0;
    std::vector<Status> refused{};
    std::string report{}, resolved{};
  } seen{&s.world};
  const auto meddle = [](const StageContext&, void* user) {
    Seen& to = *static_cast<Seen*>(user);
    World& w = *to.world;
    const auto status = [](const auto& result) { return result ? Status{} : Status{result.error()}; };
    ++to.calls;
    to.refused = {w.step(0.001),
                  w.prepare(),
                  w.scheduler().remove("meddle"),
                  w.scheduler().insert_after("sph.forces",
                                             {"more", [](const StageContext&, void*) {}, nullptr, {}, {}}),
                  w.scheduler().enable("thermal", false),
                  w.scheduler().enable_timings(true),
                  status(w.remove_liquid(Shape::sphere({0.5, 0.2, 0.5}, 0.2))),
                  status(w.totals()),
                  status(w.snapshot()),
                  w.save_state(0)};
    to.report = w.synchronize().error;
    to.resolved = w.resolved().error;
  };
  require(s.world.scheduler().insert_after("sph.forces", {"meddle", meddle, &seen, {}, {}}));
  for (Scene* one : {&s, &other}) {
    require(one->world.prepare());
    require(one->world.step(2.5 * other.world.stable_dt()));
  }
  EXPECT_EQ(seen.calls, 3);
  ASSERT_EQ(seen.refused.size(), 10u);
  for (const Status& status : seen.refused) {
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("runs the stage that calls it"), std::string::npos)
        << status.error().message;
  }
  EXPECT_NE(seen.report.find("runs the stage"), std::string::npos);
  EXPECT_NE(seen.resolved.find("runs the stage"), std::string::npos);
  EXPECT_EQ(*s.world.state_hash(), *other.world.state_hash());
  require(s.world.scheduler().remove("meddle"));
}

// A World that was moved from says so.
TEST(State, AWorldThatWasMovedFromIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  const World now = std::move(s.world);
  const Status step = s.world.step(0.001);  // NOLINT(bugprone-use-after-move): that is what is tested
  ASSERT_FALSE(step);
  EXPECT_NE(step.error().message.find("moved from"), std::string::npos) << step.error().message;
  EXPECT_NE(s.world.synchronize().error.find("moved from"), std::string::npos);
}

}  // namespace
}  // namespace meltsim_test
