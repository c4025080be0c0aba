// SPDX-License-Identifier: Apache-2.0
// Numbers that are none, work without end, memory and threads that are not there: named and refused, or harmless.
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#if defined(__linux__)
#include <sys/resource.h>
#include <unistd.h>
#endif

#include "scenes.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MELTSIM_SANITIZED 1  // their shadow memory needs more addresses than the tests below leave
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MELTSIM_SANITIZED 1
#endif
#endif

namespace meltsim_test {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();
const double inf = std::numeric_limits<double>::infinity();

World tank(NeighbourSearch search, bool bounded, Precision precision = Precision::single_precision,
           bool periodic = false) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.neighbour_search = search;
  d.precision = precision;
  d.domain.bounded = bounded;
  d.domain.max = {1.2, 1.2, 1.2};
  if (periodic) d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

/// Spoils one coordinate of one particle behind the check at the end of a sub-step, on the host.
template <class T>
struct Spoiler {
  int field = 0;  ///< 0 position, 1 velocity, 2 acceleration
  int axis = 0;
  double value = 0;
  static void run(const StageContext& c, void* user) {
    const auto& self = *static_cast<Spoiler*>(user);
    const std::uint64_t i = c.particles / 2;
    auto* x = self.field == 0   ? &static_cast<Vec4<T>*>(c.position)[i].x
              : self.field == 1 ? &static_cast<Vec4<T>*>(c.velocity)[i].x
                                : &static_cast<Vec3<T>*>(c.acceleration)[i].x;
    x[self.axis] = static_cast<T>(self.value);
  }
};

template <class T>
void expect_halt(NeighbourSearch search, bool bounded, bool periodic, Spoiler<T> spoiler) {
  const auto precision = sizeof(T) == 8 ? Precision::double_precision : Precision::single_precision;
  World w = tank(search, bounded, precision, periodic);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0.1, 0.1, 0.1}, {0.7, 0.7, 0.7});
  require(w.add_fluid(f));
  SolidDesc b;
  b.name = "brick";
  b.material = f.material;
  b.shape = Shape::box({0.8, 0.1, 0.1}, {1.1, 0.4, 0.4});
  require(w.add_solid(b));
  require(w.step(1e-3));
  const auto good = *w.state_hash();
  const char* after = spoiler.field == 2 ? "sph.forces" : "step.integrate";
  require(
      w.scheduler().insert_after(after, {"spoil", Spoiler<T>::run, &spoiler, {}, {"position", "velocity"}}));
  require(w.step(1e-3));  // the check is before the stage
  require(w.step(1e-3));
  require(w.step(1e-3));
  const StepResult r = w.synchronize();
  ASSERT_TRUE(r.halted);
  EXPECT_NE(r.halt_reason.find("not finite"), std::string::npos) << r.halt_reason;
  EXPECT_NE(r.halt_reason.find("particle "), std::string::npos) << r.halt_reason;
  if (spoiler.field == 2) {
    EXPECT_EQ(*w.state_hash(), good);
  }
  EXPECT_TRUE(w.particles());
}

// What is no number is in some cell, wherever cells are; the end of the sub-step names it. On CUDA: tests/gpu/interop_test.cu.
TEST(Limits, APositionThatIsNoNumberHaltsWithEverySearch) {
  MELTSIM_NEEDS_BACKEND();
  if (backend() == Backend::cuda) GTEST_SKIP() << "the stage below runs on the host";
  for (const auto search : {NeighbourSearch::grid, NeighbourSearch::tree})
    for (const bool bounded : {true, false})
      for (const bool periodic : {false, true}) {
        if (periodic && !bounded) continue;
        for (const double value : {nan, inf, -inf})
          for (const int field : {0, 1, 2}) {
            SCOPED_TRACE(::testing::Message()
                         << "search " << static_cast<int>(search) << ", bounded " << bounded << ", periodic "
                         << periodic << ", field " << field << ", " << value);
            expect_halt<float>(search, bounded, periodic, {field, field, value});
            expect_halt<double>(search, bounded, periodic, {field, field, value});
          }
      }
}

// --- nozzles ----------------------------------------------------------------------------------------------------------

EmitterDesc nozzle(MaterialId water, Vec3d center) {
  EmitterDesc e;
  e.name = "jet";
  e.material = water;
  e.center = center;
  e.radius = 0.15;
  e.speed = 2;
  e.until = 1;
  return e;
}

TEST(Limits, AnAxisOfAnyLengthIsADirection) {
  MELTSIM_NEEDS_BACKEND();
  std::uint64_t hash = 0;
  for (const double length : {1.0, 1e200, 1e-200, 1e308}) {
    World w = tank(NeighbourSearch::grid, true);
    EmitterDesc e = nozzle(*w.add_material({}), {0.6, 0.6, 0.6});
    e.axis = {length, 0, 0};
    require(w.add_emitter(e));
    for (int k = 0; k < 20; ++k) require(w.step(0.005));
    const StepResult r = w.synchronize();
    EXPECT_FALSE(r.halted) << r.halt_reason;
    EXPECT_GT(r.fluid, 0u);
    if (length == 1.0) hash = *w.state_hash();
    EXPECT_EQ(*w.state_hash(), hash) << length;
  }
}

TEST(Limits, ARadiusIsHeldAgainstMemoryBeforeAnythingIsMade) {
  MELTSIM_NEEDS_BACKEND();
  for (const double spacings : {1e6, 4e9, 1e12, 1e200}) {
    World w = tank(NeighbourSearch::grid, false);
    EmitterDesc e = nozzle(*w.add_material({}), {});
    e.radius = 0.1 * spacings;
    e.max_particles = 1000;
    const auto r = w.add_emitter(e);
    ASSERT_FALSE(r) << spacings;
    EXPECT_NE(r.error().message.find("radius"), std::string::npos) << r.error().message;
    EXPECT_EQ(w.resolved().error, "");
  }
}

// A nozzle is a disc: where its rim is counts.
TEST(Limits, ANozzleKeepsOffWallsBodiesAndOtherNozzles) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(NeighbourSearch::grid, true);
  const auto water = *w.add_material({});
  SolidDesc brick;
  brick.name = "brick";
  brick.material = water;
  brick.shape = Shape::box({0.8, 0, 0.8}, {1.2, 0.4, 1.2});
  require(w.add_solid(brick));
  const auto refused = [&](EmitterDesc e, const char* by) {
    const auto r = w.add_emitter(e);
    ASSERT_FALSE(r) << by;
    EXPECT_NE(r.error().message.find(by), std::string::npos) << r.error().message;
    EXPECT_NE(r.error().message.find("emitter \"jet\": center"), std::string::npos) << r.error().message;
  };
  refused(nozzle(water, {0.05, 0.6, 0.6}), "wall");  // the centre is inside, the rim is not
  refused(nozzle(water, {0.6, 0.1, 0.6}), "wall");   // blows at the floor, a spacing away
  refused(nozzle(water, {0.9, 0.25, 0.9}), "\"brick\"");
  require(w.add_emitter(nozzle(water, {0.4, 0.8, 0.4})));
  refused(nozzle(water, {0.5, 0.8, 0.4}), "emitter \"jet\"");
  EmitterDesc later = nozzle(water, {0.4, 0.8, 0.4});
  later.from = 1;  // when the other has ended
  later.until = 2;
  require(w.add_emitter(later));
  SolidDesc lid = brick;
  lid.name = "lid";
  lid.shape = Shape::box({0.2, 0.7, 0.2}, {0.6, 0.9, 0.6});
  const auto r = w.add_solid(lid);
  ASSERT_FALSE(r);
  EXPECT_NE(r.error().message.find("nozzle of emitter \"jet\""), std::string::npos) << r.error().message;
  for (int k = 0; k < 100; ++k) require(w.step(0.005));
  const StepResult s = w.synchronize();
  EXPECT_FALSE(s.halted) << s.halt_reason;
}

// Most particles are counted from when the nozzle was added, not from when it would have begun.
TEST(Limits, MaxParticlesOfANozzleThatIsAddedLate) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(NeighbourSearch::grid, true);
  const auto water = *w.add_material({});
  for (int k = 0; k < 100; ++k) require(w.step(0.01));  // by then 20 layers would have come
  EmitterDesc e = nozzle(water, {0.6, 0.8, 0.6});
  e.until = inf;
  e.max_particles = 30;  // 3 layers of 8
  require(w.add_emitter(e));
  for (int k = 0; k < 70; ++k) require(w.step(0.005));
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_EQ(r.fluid, 24u);
  EXPECT_TRUE(r.emitter_exhausted);
}

// --- steps ------------------------------------------------------------------------------------------------------------

TEST(Limits, StepsOfAnyLengthAreTakenOrRefused) {
  MELTSIM_NEEDS_BACKEND();
  for (const double dt : {1e-300, 1e-50, 1e-31, 1e-29, 1e-20, 1e-12, 1e10, 1e20, 1e39, 1e300})
    for (const bool fixed : {false, true})
      for (const double gravity : {0.0, -9.81}) {
        if (!fixed && (gravity == 0) == (dt < 1)) continue;  // of springs and free fall other texts tell
        SCOPED_TRACE(::testing::Message() << dt << " s, fixed " << fixed << ", gravity " << gravity);
        WorldDesc d = describe();
        d.spacing = 0.1;
        d.gravity.y = gravity;
        auto w = World::create(d);
        ASSERT_TRUE(w);
        SolidDesc b;
        b.material = *w->add_material({});
        b.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
        b.fixed = fixed;
        require(w->add_solid(b));
        const Status s = w->step(dt);
        const StepResult r = w->synchronize();
        EXPECT_FALSE(r.halted) << r.halt_reason;
        if (!s) {
          EXPECT_EQ(s.error().code, dt < 1 ? ErrorCode::invalid_argument : ErrorCode::step_too_large)
              << s.error().message;
          EXPECT_TRUE(dt < 1e-30 || dt > 1);
          EXPECT_EQ(w->time(), 0.0);
        }
        const double now = w->time();
        const Status next = w->step(1e-3);
        EXPECT_EQ(static_cast<bool>(next), now + 1e-3 > now);  // or a loop up to some time would never end
        if (!next) {
          EXPECT_EQ(next.error().code, ErrorCode::invalid_argument);
          EXPECT_NE(next.error().message.find("step: dt: 0.001 s does not move the clock"), std::string::npos)
              << next.error().message;
          EXPECT_EQ(w->time(), now);
        }
        EXPECT_FALSE(w->synchronize().halted);
        EXPECT_TRUE(std::isfinite(w->totals()->kinetic));
      }
}

// Sound does not come down again, so a slip of the host's shortens all steps to come: the refusal says so.
TEST(Limits, AStepRefusedForASpeedThatWasOnceSetSaysSo) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe(), {});
  require(s.world.step(1e-3));
  const Status usual = s.world.step(100);
  ASSERT_FALSE(usual);
  EXPECT_EQ(usual.error().message.find("sound is at"), std::string::npos) << usual.error().message;
  const BodyId ice = s.world.bodies()->front().body;
  require(s.world.set_velocity(ice, {3000, 0, 0}, {}));
  require(s.world.set_velocity(ice, {}, {}));
  const Status refused = s.world.step(0.02);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::step_too_large);
  EXPECT_NE(refused.error().message.find("; sound is at 30000"), std::string::npos)
      << refused.error().message;
}

// A sub-step cannot be interrupted, so what it may take is bounded, and said.
TEST(Limits, HeatWorkOfASubStepIsBounded) {
  MELTSIM_NEEDS_BACKEND();
  const auto world = [](double time_scale, double conductivity, double capacity, int supersteps) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.heat.time_scale = time_scale;
    d.heat.max_supersteps = supersteps;
    auto w = World::create(d);
    EXPECT_TRUE(w) << w.error().message;
    MaterialDesc m;
    m.conductivity = conductivity;
    m.heat_capacity = capacity;
    FluidDesc f;
    f.material = *w->add_material(m);
    for (const double x : {0.0, 0.3}) {
      f.shape = Shape::box({x, 0, 0}, {x + 0.3, 0.3, 0.3});
      f.temperature = 20 + 100 * x;
      require(w->add_fluid(f));
    }
    return std::move(*w);
  };
  struct Case {
    double time_scale, conductivity, capacity;
  };
  for (const Case& c : {Case{1e12, 0.6, 4186}, Case{1, 1e13, 4186}, Case{1, 0.6, 1e-9},
                        Case{1e300, 0.6, 4186}, Case{1, 1e15, 1e-15}}) {
    World w = world(c.time_scale, c.conductivity, c.capacity, 64);
    const Status s = w.step(1e-3);
    ASSERT_FALSE(s) << c.time_scale << ", " << c.conductivity;
    EXPECT_EQ(s.error().code, ErrorCode::step_too_large);
    for (const char* named : {"super-steps", "max_supersteps 64", "time_scale", "at most"})
      EXPECT_NE(s.error().message.find(named), std::string::npos) << s.error().message;
    EXPECT_EQ(w.time(), 0.0);
    EXPECT_GT(w.resolved().heat_sweeps, 64 * 63);
  }
  // As many as are allowed do run, and the step that is named is one.
  World w = world(3e10, 0.6, 4186, 100000);
  require(w.prepare());
  const Resolved r = w.resolved();
  ASSERT_GT(r.heat_supersteps, 1);
  EXPECT_EQ(r.heat_sweeps, std::int64_t{r.heat_stages} * r.heat_supersteps);
  World refused = world(3e10, 0.6, 4186, r.heat_supersteps - 1),
        allowed = world(3e10, 0.6, 4186, r.heat_supersteps);
  const double dt = w.stable_dt();
  const Status s = refused.step(dt);
  ASSERT_FALSE(s);
  require(allowed.step(dt));
  const std::string text = s.error().message;
  const auto at = text.find("at most ");
  ASSERT_NE(at, std::string::npos) << text;
  require(refused.step(std::strtod(text.c_str() + at + 8, nullptr)));
  EXPECT_FALSE(refused.synchronize().halted);
  for (const int bad : {0, -1, 1000001}) {
    WorldDesc d = describe();
    d.heat.max_supersteps = bad;
    const auto no = World::create(d);
    ASSERT_FALSE(no);
    EXPECT_NE(no.error().message.find("max_supersteps"), std::string::npos);
  }
}

// Temperatures are level, and a source within the step that is refused would have begun.
TEST(Limits, AStepThatIsRefusedForItsHeatLetsNoneFlow) {
  MELTSIM_NEEDS_BACKEND();
  const auto make = [] {
    WorldDesc d = describe();
    d.spacing = 0.1;
    World w = *World::create(d);
    MaterialDesc m;
    m.heat_capacity = 1e-9;  // no sub-step has time for its heat
    FluidDesc f;
    f.material = *w.add_material(m);
    f.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
    require(w.add_fluid(f));
    HeatRegionDesc r;
    r.shape = Shape::box({0, 0, 0}, {1, 1, 1});
    r.source = 1e-9;
    r.from = 0.02;
    require(w.add_heat_region(r));
    require(w.step(1e-3));
    return w;
  };
  World w = make(), other = make();
  const auto before = *w.snapshot();
  const Status s = w.step(0.03);
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().code, ErrorCode::step_too_large) << s.error().message;
  EXPECT_EQ(*w.snapshot(), before);
  // Nor does it in what goes through the host afterwards, whether it is restored or added to.
  require(w.restore(before.data(), before.size()));
  for (World* each : {&w, &other}) require(each->step(1e-3));
  ASSERT_FALSE(w.step(0.03));
  for (World* each : {&w, &other}) {
    FluidDesc f;
    f.material = MaterialId{0, 1};
    f.shape = Shape::box({0.5, 0, 0}, {0.8, 0.3, 0.3});
    require(each->add_fluid(f));
    require(each->step(1e-3));
  }
  EXPECT_FALSE(w.synchronize().halted);
  EXPECT_EQ(*w.state_hash(), *other.state_hash());
}

// --- what falls out of the scene --------------------------------------------------------------------------------------

// A droplet in the air, below everything else; gravity is so strong that it is too fast within a few steps.
TEST(Stray, ADropletThatFallsForEverIsRemovedAndCounted) {
  MELTSIM_NEEDS_BACKEND();
  for (const Stray stray : {Stray::remove, Stray::halt}) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.stray = stray;
    auto w = World::create(d);
    ASSERT_TRUE(w);
    const auto water = *w->add_material({});
    MaterialDesc stone;
    stone.name = "stone";
    SolidDesc tray;  // a floor and four sides
    tray.material = *w->add_material(stone);
    tray.fixed = true;
    tray.shape =
        Shape::subtract(Shape::box({0, 0, 0}, {1, 0.6, 1}), Shape::box({0.2, 0.2, 0.2}, {0.8, 0.7, 0.8}));
    require(w->add_solid(tray));
    FluidDesc f;
    f.material = water;
    f.shape = Shape::box({0.2, 0.2, 0.2}, {0.8, 0.5, 0.8});
    require(w->add_fluid(f));
    f.shape = Shape::box({3, 0, 0}, {3.1, 0.1, 0.1});  // one particle
    require(w->add_fluid(f));
    const StepResult before = w->synchronize();
    require(w->prepare());
    const double c = w->resolved().sound_speed, g = 9.81;
    double time = 0;
    StepResult r;
    while (time < 1.5 * c / g && !r.halted && r.strayed == 0) {
      const Status s = w->step(0.1);
      if (!s && s.error().code == ErrorCode::halted) break;
      require(s);
      time += 0.1;
      r = w->synchronize();
    }
    r = w->synchronize();
    EXPECT_EQ(r.removed, 0u);
    if (stray == Stray::halt) {
      EXPECT_EQ(r.strayed, 0u);
      EXPECT_EQ(r.fluid, before.fluid);
      continue;
    }
    EXPECT_FALSE(r.halted) << r.halt_reason;
    EXPECT_EQ(r.strayed, 1u);
    EXPECT_EQ(r.fluid, before.fluid - 1);
    EXPECT_NEAR(time, c / g, 0.2);  // v = g t
    EXPECT_EQ(w->particles()->id.size(), before.fluid - 1 + before.solid);
    EXPECT_EQ(w->ledger()->fluid, before.fluid - 1);
    // And it is counted after a restore, and after an upload.
    const auto bytes = *w->snapshot();
    require(w->restore(bytes.data(), bytes.size()));
    EXPECT_EQ(w->synchronize().strayed, 1u);
    require(w->step(0.01));
    EXPECT_EQ(w->synchronize().strayed, 1u);
    EXPECT_FALSE(w->synchronize().halted);
  }
}

// Liquid that other forces make as fast has diverged: a cube of it, too soft by far for the way it falls onto a plate.
TEST(Stray, LiquidThatDivergesHalts) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  auto w = World::create(d);
  ASSERT_TRUE(w);
  FluidDesc f;
  f.material = *w->add_material({});
  f.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
  require(w->add_fluid(f));
  CustomStage push;  // a force that is no gravity, growing without bound
  push.name = "push";
  push.writes = {"acceleration"};
  push.run = [](const StageContext& c, void*) {
    for (std::uint64_t i = 0; i < c.particles; ++i) static_cast<Vec3<float>*>(c.acceleration)[i].x += 2e4f;
  };
  if (backend() == Backend::cuda) GTEST_SKIP() << "the stage below runs on the host";
  require(w->scheduler().insert_after("sph.forces", push));
  StepResult r;
  for (int k = 0; k < 200 && !r.halted; ++k) {
    const Status s = w->step(1e-3);
    if (!s) break;
    r = w->synchronize();
  }
  EXPECT_TRUE(r.halted || !w->step(1e-3));
  EXPECT_EQ(r.strayed, 0u);
  EXPECT_EQ(r.fluid, 216u);
}

// --- memory and threads -----------------------------------------------------------------------------------------------

#if defined(__linux__) && !defined(MELTSIM_SANITIZED)

/// From here on the process may map this many bytes more, whatever the machine has.
void leave(std::uint64_t bytes) {
  std::uint64_t pages = 0;
  if (std::FILE* f = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(f, "%lu", &pages) != 1) pages = 0;
    std::fclose(f);
  }
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + bytes;
  setrlimit(RLIMIT_AS, &limit);
}

// Each in a process of its own. Exit codes: 0 as it should be; else which expectation failed.
TEST(LimitsDeathTest, MemoryThatRunsOutIsSaidToHave) {
  if (backend() == Backend::cuda) GTEST_SKIP() << "a CUDA process maps more than there is";
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  const auto run = [] {
    World w = tank(NeighbourSearch::grid, false);
    const auto water = *w.add_material({});
    const Shape huge = Shape::box({0, 0, 0}, {80, 80, 80});  // 5e8 sites, a byte each and more
    FluidDesc f;
    f.material = water;
    f.shape = Shape::box({0, 0, 0}, {1, 1, 1});
    require(w.add_fluid(f));
    require(w.step(1e-3));
    const auto hash = *w.state_hash();
    leave(100u << 20);
    f.shape = huge;
    const auto fluid = w.add_fluid(f);
    if (fluid || fluid.error().code != ErrorCode::out_of_memory) std::_Exit(1);
    SolidDesc s;
    s.material = water;
    s.shape = huge;
    const auto solid = w.add_solid(s);
    if (solid || solid.error().code != ErrorCode::out_of_memory) std::_Exit(2);
    std::vector<Vec3i> points(1);
    const Status sites = huge.lattice_points({}, 0.1, points);
    if (sites || sites.error().code != ErrorCode::out_of_memory || !points.empty()) std::_Exit(4);
    if (*w.state_hash() != hash || !w.step(1e-3) || w.synchronize().halted) std::_Exit(5);
    std::_Exit(0);
  };
  EXPECT_EXIT(run(), ::testing::ExitedWithCode(0), "");
}

TEST(LimitsDeathTest, ThreadsThatTheSystemDoesNotGrantAreNotAskedFor) {
  if (backend() == Backend::cuda) GTEST_SKIP() << "threads are the CPU's";
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  const auto run = [](int threads, std::uint64_t bytes) {
    leave(bytes);
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.threads = threads;
    auto w = World::create(d);
    if (!w) std::_Exit(w.error().code == ErrorCode::out_of_memory ? 0 : 1);
    FluidDesc f;
    f.material = *w->add_material({});
    f.shape = Shape::box({0, 0, 0}, {1.2, 1.2, 1.2});  // 1728 particles: more than one thread's share
    if (!w->add_fluid(f)) std::_Exit(2);
    if (!w->step(1e-3) || w->synchronize().halted) std::_Exit(3);
    std::_Exit(0);
  };
  // 20 MB hold two stacks of 8 MB at the most.
  for (const int threads : {0, 8, 1000, 100000}) {
    EXPECT_EXIT(run(threads, 40u << 20), ::testing::ExitedWithCode(0), "") << threads;
    EXPECT_EXIT(run(threads, 400u << 20), ::testing::ExitedWithCode(0), "") << threads;
  }
}

#endif

TEST(Limits, ThreadsAreNoMoreThanTheMachineHasUse) {
  if (backend() == Backend::cuda) GTEST_SKIP() << "threads are the CPU's";
  std::uint64_t hash = 0;
  for (const int threads : {1, 3, 16, 100000, std::numeric_limits<int>::max()}) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.threads = threads;
    auto w = World::create(d);
    ASSERT_TRUE(w) << threads;
    FluidDesc f;
    f.material = *w->add_material({});
    f.shape = Shape::box({0, 0, 0}, {1.2, 1.2, 1.2});
    require(w->add_fluid(f));
    for (int k = 0; k < 3; ++k) require(w->step(1e-3));
    if (threads == 1) hash = *w->state_hash();
    EXPECT_EQ(*w->state_hash(), hash) << threads;
  }
}

// Flow takes sound along: a signal passes at c + v, beyond the tenth of c that the acoustic step allows for. Steps that a host
// makes by stable_dt() of what moves; nothing moves faster than that lets it: H/(1.4 c) at half of c.
TEST(StableStep, FollowsWhatSoundAndFlowDoTogether) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(NeighbourSearch::grid, true);
  FluidDesc f;
  f.material = *w.add_material(MaterialDesc{});
  f.shape = Shape::box({0, 0, 0}, {1.2, 0.4, 1.2});
  require(w.add_fluid(f));
  require(w.prepare());
  const Resolved r = w.resolved();
  const double acoustic = w.desc().courant * r.support_radius / r.sound_speed;
  EXPECT_DOUBLE_EQ(w.stable_dt(0.1 * r.sound_speed), w.stable_dt(0));
  EXPECT_NEAR(w.stable_dt(0.5 * r.sound_speed), acoustic / 1.4, 1e-12 * acoustic);
  EXPECT_NEAR(w.stable_dt(5 * r.sound_speed), acoustic / 5.9, 1e-12 * acoustic);
}

// A column that collapses at 0.25 to 0.4 of the derived sound speed, with the Courant number 0.6: jets come to a third of c and
// more, and with acoustic steps the World halts as they meet the wall, at 0.74 to 0.78 s. 648 particles, as coarse as did.
TEST(StableStep, ASplashInSlowSoundHolds) {
  MELTSIM_NEEDS_BACKEND();
  double c = 0;
  for (const double share : {1.0, 0.4, 0.3, 0.25}) {
    WorldDesc d = describe();
    d.spacing = 0.8 / 6;
    d.courant = 0.6;
    d.sound_speed = share < 1 ? share * c : 0;
    d.domain.bounded = true;
    d.domain.no_slip = false;
    d.domain.max = {4, 2.4, 0.8};
    d.heat.model = HeatModel::none;
    auto made = World::create(d);
    ASSERT_TRUE(made) << made.error().message;
    World w = std::move(*made);
    MaterialDesc m;
    m.viscosity = 0.05;
    FluidDesc f;
    f.material = *w.add_material(m);
    f.shape = Shape::box({0, 0, 0}, {1.2, 1.6, 0.8});
    require(w.add_fluid(f));
    require(w.prepare());
    if (share == 1) c = w.resolved().sound_speed;
    double speed = 0;
    while (share < 1 && w.time() < 1) {
      const double limit = w.stable_dt(speed);
      for (int k = 0; k < 8; ++k) require(w.step(limit));
      const StepResult now = w.synchronize();
      ASSERT_FALSE(now.halted) << now.halt_reason << " at " << w.time() << " s, " << share
                               << " of the sound speed";
      speed = now.max_speed;
    }
  }
}

}  // namespace
}  // namespace meltsim_test
