// SPDX-License-Identifier: Apache-2.0
// Readings that are taken while the World goes on: they are of the moment of their request, whatever follows.
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

class Reading : public testing::Test {
 protected:
  void SetUp() override { MELTSIM_NEEDS_BACKEND(); }
};

constexpr ReadRequest everything() {
  ReadRequest r;
  r.totals = r.pieces = r.particles = true;
  return r;
}

/// 360 particles of water around a block of 27 that melts, at 1,000 times the pace of heat.
Scene melting() {
  WorldDesc d = describe();
  d.spacing = 0.2;
  IceScene s;
  s.block_floor = 0.6;
  Scene scene = ice_in_water(d, s);
  require(scene.world.step(2e-3));
  return scene;
}

void expect_equal(const meltsim::Reading& a, const meltsim::Reading& b) {
  EXPECT_EQ(a.step, b.step);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.result.max_speed, b.result.max_speed);
  EXPECT_EQ(a.result.max_density_ratio, b.result.max_density_ratio);
  EXPECT_EQ(a.result.melted, b.result.melted);
  EXPECT_EQ(a.result.solid, b.result.solid);
  EXPECT_EQ(a.totals.kinetic, b.totals.kinetic);
  EXPECT_EQ(a.totals.thermal, b.totals.thermal);
  EXPECT_EQ(a.totals.temperature_mean, b.totals.temperature_mean);
  EXPECT_EQ(a.totals.bodies, b.totals.bodies);
  EXPECT_EQ(a.ledger.momentum.y, b.ledger.momentum.y);
  ASSERT_EQ(a.pieces.size(), b.pieces.size());
  for (std::size_t k = 0; k < a.pieces.size(); ++k) {
    EXPECT_EQ(a.pieces[k].name, b.pieces[k].name);
    EXPECT_EQ(a.pieces[k].particles, b.pieces[k].particles);
    EXPECT_EQ(a.pieces[k].center.y, b.pieces[k].center.y);
    EXPECT_EQ(a.pieces[k].velocity.y, b.pieces[k].velocity.y);
  }
  EXPECT_EQ(a.particles.id, b.particles.id);
  EXPECT_EQ(a.particles.temperature, b.particles.temperature);
  EXPECT_EQ(a.particles.density, b.particles.density);
  EXPECT_EQ(a.particles.piece, b.particles.piece);
  ASSERT_EQ(a.particles.position.size(), b.particles.position.size());
  for (std::size_t i = 0; i < a.particles.position.size(); ++i) {
    EXPECT_EQ(a.particles.position[i].y, b.particles.position[i].y);
    EXPECT_EQ(a.particles.velocity[i].y, b.particles.velocity[i].y);
  }
}

// One World is read at once, its twin goes on for 20 steps first; the state has changed by then.
TEST_F(Reading, IsOfTheMomentOfItsRequest) {
  Scene one = melting(), other = melting();
  const auto now = one.world.take(*one.world.request(everything()));
  require(now);
  const auto ticket = other.world.request(everything());
  require(ticket);
  for (int n = 0; n < 20; ++n) require(other.world.step(2e-3));
  const auto later = other.world.take(*ticket);
  require(later);
  expect_equal(*now, *later);
  EXPECT_EQ(now->step, one.world.steps());
  EXPECT_EQ(now->particles.id.size(), now->result.fluid + now->result.solid);
  const auto after = other.world.take(*other.world.request(everything()));
  require(after);
  EXPECT_NE(after->totals.kinetic, now->totals.kinetic);
}

// What was not asked for is not there.
TEST_F(Reading, HoldsWhatWasAskedFor) {
  Scene s = melting();
  const auto r = s.world.take(*s.world.request({}));
  require(r);
  EXPECT_EQ(r->result.solid, 27u);
  EXPECT_EQ(r->totals.mass, 0);
  EXPECT_TRUE(r->pieces.empty());
  EXPECT_TRUE(r->particles.id.empty());
}

TEST_F(Reading, TicketsAreFourAndEachOfItsOwnWorld) {
  Scene s = melting(), other = melting();
  std::vector<ReadTicket> open;
  for (int k = 0; k < most_readings; ++k) {
    const auto t = s.world.request(everything());
    require(t);
    open.push_back(*t);
    require(s.world.step(2e-3));
  }
  const auto fifth = s.world.request(everything());
  ASSERT_FALSE(fifth);
  EXPECT_EQ(fifth.error().code, ErrorCode::capacity);
  // In any order; each is of its own moment.
  for (const int k : {2, 0, 3, 1}) {
    const auto r = s.world.take(open[static_cast<std::size_t>(k)]);
    require(r);
    EXPECT_EQ(r->step, open.size() - 3 + static_cast<std::size_t>(k));
  }
  const auto t = s.world.request({});
  require(t);
  const auto of_other = other.world.take(*t);
  ASSERT_FALSE(of_other);
  EXPECT_EQ(of_other.error().code, ErrorCode::invalid_argument);
  EXPECT_FALSE(other.world.ready(*t));
  EXPECT_FALSE(s.world.ready({}));
  EXPECT_TRUE(s.world.ready(*t));
  require(s.world.take(*t));
  EXPECT_FALSE(s.world.take(*t));
  EXPECT_FALSE(s.world.ready(*t));
}

// A snapshot that is restored and a body that is added change the World, not what was read.
TEST_F(Reading, OutlivesWhatIsBuiltAfterIt) {
  Scene one = melting(), other = melting();
  const auto now = one.world.take(*one.world.request(everything()));
  require(now);
  const auto saved = other.world.snapshot();
  require(saved);
  const auto ticket = other.world.request(everything());
  require(ticket);
  require(other.world.step(2e-3));
  SolidDesc body;
  body.name = "second";
  body.material = other.ice;
  body.shape = Shape::box({1.6, 1.8, 1.6}, {2.0, 2.2, 2.0});
  require(other.world.add_solid(body));
  const auto second = other.world.request(everything());
  require(second);
  require(other.world.step(2e-3));
  const auto a = other.world.take(*ticket), b = other.world.take(*second);
  require(a);
  require(b);
  expect_equal(*now, *a);
  EXPECT_EQ(b->pieces.size(), 2u);
}

// A jet brings 30 to 500 particles, so that each reading is larger than the one before. To allocate makes a device wait, so memory
// for readings grows by half, at most seven times here, not with every reading.
TEST_F(Reading, OfWhatFlowsInAllocatesNowAndThen) {
  IceScene tank;
  tank.water = false;
  tank.block = 0;
  Scene s = ice_in_water(describe(), tank);
  EmitterDesc e;
  e.material = s.water;
  e.center = {1.2, 2.0, 1.2};
  e.axis = {0, -1, 0};
  e.radius = 0.5;
  e.speed = 4;
  e.until = 1.2;
  require(s.world.add_emitter(e));
  ReadRequest particles;
  particles.particles = true;
  std::set<std::uint64_t> sizes;
  std::size_t first = 0, last = 0;
  for (int n = 0; n < 40; ++n) {
    require(s.world.step(0.03));
    const auto r = s.world.take(*s.world.request(particles));
    require(r);
    last = r->particles.id.size();
    if (n == 0) first = last;
    sizes.insert(s.world.plan().bytes);
  }
  EXPECT_LT(first, 60u);
  EXPECT_GT(last, 400u);
  EXPECT_LE(sizes.size(), 9u);
}

// The extremes of two intervals, read with request() by one World and with synchronize() by its twin.
TEST_F(Reading, StartsTheExtremesAnew) {
  Scene one = melting(), other = melting();
  for (int n = 0; n < 3; ++n) {
    const auto ticket = one.world.request({});
    require(ticket);
    const StepResult here = other.world.synchronize();
    require(one.world.step(4e-3));
    require(other.world.step(4e-3));
    const auto r = one.world.take(*ticket);
    require(r);
    EXPECT_EQ(r->result.max_speed, here.max_speed);
    EXPECT_EQ(r->result.max_density_ratio, here.max_density_ratio);
    EXPECT_EQ(r->result.steps, here.steps);
    EXPECT_EQ(r->result.time, here.time);
  }
}

/// The same sums, by hand, from particles in double.
TEST_F(Reading, TotalsAreThoseOfTheParticles) {
  Scene s = melting();
  for (int n = 0; n < 5; ++n) require(s.world.step(4e-3));
  const auto t = s.world.totals();
  const auto d = s.world.particles();
  require(t);
  require(d);
  Totals sum;
  sum.temperature_min = infinity;
  sum.temperature_max = -infinity;
  double solid_mass = 0;
  for (std::size_t i = 0; i < d->id.size(); ++i) {
    const double m = d->mass[i];
    const Vec3d x = d->position[i], v = d->velocity[i];
    sum.mass += m;
    sum.momentum += v * m;
    sum.angular_momentum += cross(x, v) * m;
    sum.kinetic += 0.5 * m * dot(v, v);
    sum.potential += 9.81 * m * x.y;
    sum.thermal += d->enthalpy[i];
    sum.latent += m * 3.34e5 * d->liquid_fraction[i];
    sum.temperature_min = std::min(sum.temperature_min, d->temperature[i]);
    sum.temperature_max = std::max(sum.temperature_max, d->temperature[i]);
    sum.temperature_mean += m * d->temperature[i];
    sum.max_speed = std::max(sum.max_speed, length(v));
    if (!is_solid(d->tag[i])) continue;
    ++sum.solid;
    sum.solid_center += x * m;
    solid_mass += m;
  }
  // The order of addition differs: 1e-12 of the sum of the sizes, which the mass times the largest stands for.
  const double speed = sum.max_speed, close = 1e-12 * sum.mass;
  EXPECT_NEAR(t->mass, sum.mass, close);
  EXPECT_NEAR(t->momentum.y, sum.momentum.y, close * speed);
  EXPECT_NEAR(t->angular_momentum.x, sum.angular_momentum.x, close * speed * 3);
  EXPECT_NEAR(t->kinetic, sum.kinetic, close * speed * speed);
  EXPECT_NEAR(t->potential, sum.potential, close * 30);
  EXPECT_NEAR(t->thermal, sum.thermal, 1e-12 * sum.mass * 4e5);
  EXPECT_NEAR(t->latent, sum.latent, 1e-12 * sum.mass * 4e5);
  EXPECT_EQ(t->temperature_min, sum.temperature_min);
  EXPECT_EQ(t->temperature_max, sum.temperature_max);
  EXPECT_NEAR(t->temperature_mean, sum.temperature_mean / sum.mass, 1e-10);
  EXPECT_EQ(t->max_speed, sum.max_speed);
  EXPECT_EQ(t->solid, sum.solid);
  EXPECT_EQ(t->fluid + t->solid, d->id.size());
  EXPECT_EQ(t->bodies, 1u);
  EXPECT_NEAR(t->solid_center.y, sum.solid_center.y / solid_mass, 1e-12);
  EXPECT_GT(t->density_error_max, 0);
  EXPECT_LE(t->density_error_mean, t->density_error_max);
}

// Nothing has frozen, so the latent heat that is there is the same whether or not something may.
TEST_F(Reading, LatentHeatIsTheSameWhetherOrNotLiquidMayFreeze) {
  double latent[2];
  for (const bool freezes : {false, true}) {
    IceScene scene;
    scene.freezes = freezes;
    scene.block_floor = 0.6;
    Scene s = ice_in_water(describe(), scene);
    const auto t = s.world.totals();
    require(t);
    latent[freezes ? 1 : 0] = t->latent;
    EXPECT_NEAR(t->latent, (t->mass - 27 * 917 * 0.008) * 3.34e5, 1e-6 * t->latent);  // masses are single
  }
  EXPECT_EQ(latent[0], latent[1]);
}

struct Bath {
  World world;
  BodyId body;
};

/// Water 0.8 m deep at a spacing of 0.1 m, and a fixed box of 4 x 8 x 4 spacings in it whose foot is at `foot`.
Bath bath(double foot, Vec3d up, double depth = 0.8, bool at_rest = false) {
  WorldDesc d = describe();
  d.hydrostatic_start = at_rest;
  d.spacing = 0.1;
  d.gravity = up * -9.81;
  d.domain.bounded = true;
  d.domain.max = {1.6, 1.6, 1.6};
  World w = *World::create(d);
  const MaterialId water = *w.add_material({});
  SolidDesc s;
  s.name = "box";
  s.material = water;
  s.fixed = true;
  const auto box = [&](double low, double high, double lower, double upper) {  // up is y or x
    return up.y != 0 ? Shape::box({low, lower, low}, {high, upper, high})
                     : Shape::box({lower, low, low}, {upper, high, high});
  };
  s.shape = box(0.6, 1.0, foot, foot + 0.8);
  const BodyId body = *w.add_solid(s);
  if (depth > 0) {
    FluidDesc f;
    f.material = water;
    f.shape = Shape::subtract(box(0, 1.6, 0, depth), s.shape);
    require(w.add_fluid(f));
  }
  return {std::move(w), body};
}

// At rest on the lattice the level is exact, along whatever axis gravity points: 0, 1/4, 1/2 and all of a box that hangs at
// 0.9, 0.6, 0.4 and 0 m. In single precision heights are good to 1e-7 m, which is 1e-6 of a spacing.
TEST_F(Reading, SubmergedFractionOfABoxIsExact) {
  for (const Vec3d up : {Vec3d{0, 1, 0}, Vec3d{1, 0, 0}})
    for (const auto& [foot, share] : {std::pair{0.8, 0.0}, {0.6, 0.25}, {0.4, 0.5}, {0.0, 1.0}}) {
      Bath b = bath(foot, up);
      const auto p = b.world.pieces();
      require(p);
      ASSERT_EQ(p->size(), 1u);
      EXPECT_NEAR(p->front().submerged_fraction, share, 2e-6) << foot;
      EXPECT_EQ(p->front().particles, 128u);
      // Under its weight water is g h^2/(2 c^2) lower: 2 mm, of the box's 0.8 m; what is below the box has no level.
      Bath pressed = bath(foot, up, 0.8, true);
      EXPECT_NEAR(pressed.world.pieces()->front().submerged_fraction, share, 0.005) << foot;
    }
  Bath dry = bath(0, {0, 1, 0}, 0);
  EXPECT_EQ(dry.world.pieces()->front().submerged_fraction, 0);
}

// A cuboid of 4 x 6 x 8 spacings that turns freely about its long axis, without gravity and liquid, keeps its spin: it
// turns by its angle. 0.5 rad, and as the body is soft a thousandth of that.
TEST_F(Reading, PiecesTurnAsTheySpin) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    WorldDesc d = describe();
    d.precision = precision;
    d.spacing = 0.1;
    d.gravity = {};
    World w = *World::create(d);
    MaterialDesc m;
    m.density = 500;
    SolidDesc s;
    s.material = *w.add_material(m);
    s.shape = Shape::box({1, 2, 3}, {1.4, 2.6, 3.8});
    s.velocity = {1, 0, 0};
    s.angular_velocity = {0, 0, 2};
    require(w.add_solid(s));
    const auto before = w.pieces();
    require(before);
    const PieceInfo a = before->front();
    // sum m (y^2 + z^2) of centres on the lattice; 1e-6: masses and positions are single.
    const auto square = [](int n) { return 0.01 * (n * n - 1) / 12.0; };
    const double mass = 192 * 0.5;
    EXPECT_NEAR(a.mass, mass, 1e-6 * mass);
    EXPECT_NEAR(a.inertia.m[0][0], mass * (square(6) + square(8)), 1e-5 * mass);
    EXPECT_NEAR(a.inertia.m[1][1], mass * (square(4) + square(8)), 1e-5 * mass);
    EXPECT_NEAR(a.inertia.m[2][2], mass * (square(4) + square(6)), 1e-5 * mass);
    EXPECT_NEAR(a.inertia.m[0][1], 0, 1e-5 * mass);
    EXPECT_NEAR(a.center.x, 1.2, 1e-6);
    EXPECT_NEAR(a.center.z, 3.4, 1e-6);
    EXPECT_NEAR(a.angular_velocity.z, 2, 1e-5);
    EXPECT_NEAR(a.velocity.x, 1, 1e-6);
    EXPECT_NEAR(a.orientation.w, 1, 1e-6);
    EXPECT_NEAR(a.bounds.min.x, 1, 1e-6);
    EXPECT_NEAR(a.bounds.min.y, 2, 1e-6);
    EXPECT_NEAR(a.bounds.max.z, 3.8, 1e-6);
    for (int n = 0; n < 250; ++n) require(w.step(1e-3));
    const auto after = w.pieces();
    require(after);
    const PieceInfo b = after->front();
    EXPECT_NEAR(2 * std::atan2(b.orientation.z, b.orientation.w), 0.5, 5e-4);
    EXPECT_NEAR(b.orientation.x, 0, 1e-4);
    EXPECT_NEAR(b.angular_velocity.z, 2, 2e-3);
    EXPECT_NEAR(b.center.x, 1.45, 1e-5);
  }
}

/// 27 particles that fall with 1000 m/s^2, so fast by now, 60 m/s, that the largest sub-step crosses their neighbourhood.
World bullet() {
  WorldDesc d = describe();
  d.sound_speed = 5;
  d.gravity = {1000, 0, 0};
  World w = *World::create(d);
  SolidDesc b;
  b.name = "bullet";
  b.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
  b.material = *w.add_material({});
  require(w.add_solid(b));
  for (int k = 0; k < 60; ++k) require(w.step(1e-3));
  return w;
}

// Readings ahead of the sub-step that halts and behind it are both of the last good state; only the second says that the
// World halted. The engine has gone on meanwhile, and the one taken last needs what the first put right.
TEST_F(Reading, OfAWorldThatHaltsIsOfTheLastGoodState) {
  World w = bullet(), twin = bullet();
  const auto good = twin.take(*twin.request(everything()));
  require(good);
  const auto ahead = w.request(everything());
  require(ahead);
  require(w.step(8.9e-3));
  const auto behind = w.request(everything()), later = w.request(everything());
  require(behind);
  require(later);
  const auto c = w.take(*later), b = w.take(*behind), a = w.take(*ahead);
  require(a);
  require(b);
  require(c);
  expect_equal(*good, *a);
  EXPECT_FALSE(a->result.halted);
  for (const auto* r : {&*b, &*c}) {
    EXPECT_TRUE(r->result.halted);
    EXPECT_NE(r->result.halt_reason.find("bullet"), std::string::npos) << r->result.halt_reason;
    EXPECT_EQ(r->step, good->step);
    EXPECT_EQ(r->time, good->time);
    EXPECT_EQ(r->totals.kinetic, good->totals.kinetic);
    EXPECT_EQ(r->pieces.front().center.x, good->pieces.front().center.x);
    EXPECT_EQ(r->particles.id, good->particles.id);
    EXPECT_EQ(r->particles.position[5].x, good->particles.position[5].x);
  }
  EXPECT_TRUE(w.synchronize().halted);
  EXPECT_EQ(w.time(), good->time);
  EXPECT_FALSE(w.step(0.01));
}

// The state that a halted World's reading is of is gone when another is restored: it is read before that.
TEST_F(Reading, OfAWorldThatHaltedOutlivesARestore) {
  World w = bullet(), twin = bullet();
  const auto saved = w.snapshot();
  require(saved);
  require(w.step(1e-3));
  require(twin.step(1e-3));
  const auto good = twin.take(*twin.request(everything()));
  require(good);
  require(w.step(8.9e-3));
  const auto ticket = w.request(everything());
  require(ticket);
  require(w.restore(saved->data(), saved->size()));
  require(w.step(1e-3));
  const auto r = w.take(*ticket);
  require(r);
  EXPECT_TRUE(r->result.halted);
  EXPECT_EQ(r->totals.kinetic, good->totals.kinetic);
  EXPECT_EQ(r->pieces.front().center.x, good->pieces.front().center.x);
  EXPECT_FALSE(w.synchronize().halted);
  require(w.step(1e-3));
}

// Where the backend is the host, pointers can be looked at. With heat at work and at rest, when enthalpies lie by id.
TEST(DeviceState, IsTheStateOfTheStepsSoFar) {
  for (const bool heats : {true, false}) {
    WorldDesc d = describe();
    d.backend = Backend::cpu;
    d.spacing = 0.2;
    if (!heats) d.heat.model = HeatModel::none;
    IceScene s;
    s.block_floor = 0.6;
    Scene scene = ice_in_water(d, s);
    for (int k = 0; k < 3; ++k) {  // odd and even numbers of sub-steps: the state is in either of two buffers
      const auto state = scene.world.device_state();
      ASSERT_TRUE(state) << state.error().message;
      const auto data = scene.world.particles();
      ASSERT_TRUE(data);
      ASSERT_EQ(state->particles, data->id.size());
      EXPECT_EQ(state->backend, Backend::cpu);
      EXPECT_EQ(state->time, scene.world.time());
      EXPECT_EQ(state->acceleration, nullptr);
      EXPECT_NE(state->enthalpy == nullptr, state->enthalpy_of_id == nullptr);
      const auto* x = static_cast<const Vec4<float>*>(state->position);
      const auto* v = static_cast<const Vec4<float>*>(state->velocity);
      const Vec3d origin = scene.world.resolved().origin;
      for (std::size_t i = 0; i < state->particles; ++i) {
        const std::uint32_t id = state->id[i];
        ASSERT_EQ(data->id.at(id), id);
        EXPECT_EQ(static_cast<double>(x[i].y) + origin.y, data->position[id].y);
        EXPECT_EQ(static_cast<double>(v[i].y), data->velocity[id].y);
        EXPECT_EQ(state->tag[i], data->tag[id]);
        EXPECT_EQ(state->enthalpy != nullptr ? state->enthalpy[i] : state->enthalpy_of_id[id],
                  data->enthalpy[id]);
      }
      require(scene.world.step(1e-3));
    }
  }
}

// What a debug build asks of a view: that it is of this World, and not past its time. Of a state that ends with the next step, of a pack with the
// next pack, of a surface with the next surface or upload.
TEST(DeviceState, AViewPastItsTimeIsFoundOut) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  Scene other = ice_in_water(describe());
  World& w = s.world;
  const auto past = [](const Status& r, const std::string& word) {
    ASSERT_FALSE(r) << word;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(word), std::string::npos) << r.error().message;
  };
  const StageContext state = *w.device_state(), again = *w.device_state();
  const RenderView pack = *w.render_view();
  const SurfaceView surface = *w.surface_view();
  require(w.check_view(state));
  require(w.check_view(again));
  require(w.check_view(pack));
  require(w.check_view(surface));
  past(other.world.check_view(state), "another World");
  past(w.check_view(StageContext{}), "no call");
  past(w.check_view(RenderView{}), "no call");
  require(w.step(0.005));
  past(w.check_view(state), "a step was taken");
  require(w.check_view(pack));  // packs and surfaces are copies
  require(w.check_view(surface));
  require(w.render_view());
  past(w.check_view(pack), "call render_view() again");
  const StageContext now = *w.device_state();
  require(w.check_view(now));
  past(w.check_view(state), "a later one");
  require(w.save_state(0));
  require(w.load_state(0));
  past(w.check_view(now), "another state");
  const StageContext before = *w.device_state();
  MaterialDesc m;
  m.name = "other";
  require(w.add_material(m));
  past(w.check_view(before), "added");
  require(w.prepare());
  require(w.check_view(surface));  // where it is now nothing was uploaded
  const auto bytes = *w.snapshot();
  require(w.restore(bytes.data(), bytes.size()));
  require(w.prepare());
  past(w.check_view(surface), "restored");
}

TEST(DeviceState, OfNothing) {
  WorldDesc d = describe();
  d.backend = Backend::cpu;
  auto w = World::create(d);
  ASSERT_TRUE(w);
  const auto state = w->device_state();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->particles, 0u);
  EXPECT_EQ(state->position, nullptr);
}

TEST_F(Reading, OfNothing) {
  World w = *World::create(describe());
  const auto ticket = w.request(everything());
  require(ticket);
  EXPECT_TRUE(*w.ready(*ticket));
  const auto r = w.take(*ticket);
  require(r);
  EXPECT_EQ(r->step, 0u);
  EXPECT_EQ(r->totals.mass, 0);
  EXPECT_TRUE(r->particles.id.empty());
  EXPECT_EQ(w.totals()->temperature_max, 0);
  EXPECT_TRUE(w.pieces()->empty());
}

// What a renderer draws from has the values of a frame that is read, to the last bit, and stays while steps are taken. On a GPU
// the host cannot look at it: there only the call is tried.
TEST(RenderView, HasTheValuesOfAReading) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  auto empty = World::create(describe());
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->render_view()->count, 0u);
  for (int k = 0; k < 5; ++k) require(s.world.step(0.005));
  ReadRequest what;
  what.particles = true;
  const auto ticket = s.world.request(what);
  ASSERT_TRUE(ticket);
  const auto view = s.world.render_view();
  ASSERT_TRUE(view) << view.error().message;
  for (int k = 0; k < 5; ++k) require(s.world.step(0.005));
  const ParticleFrame p = s.world.take(*ticket)->particles;
  ASSERT_EQ(view->count, p.id.size());
  EXPECT_FLOAT_EQ(view->radius, float(0.5 * s.world.desc().spacing));
  EXPECT_EQ(length(view->origin - p.origin), 0);
  if (view->backend == Backend::cuda) return;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    EXPECT_EQ(view->position[i].x, p.position[i].x);
    EXPECT_EQ(view->velocity[i].y, p.velocity[i].y);
    EXPECT_EQ(view->temperature[i], p.temperature[i]);
    EXPECT_EQ(view->liquid_fraction[i], p.liquid_fraction[i]);
    EXPECT_EQ(view->density[i], p.density[i]);
    EXPECT_EQ(view->pressure[i], p.pressure[i]);
    EXPECT_EQ(view->tag[i], p.tag[i]);
    EXPECT_EQ(view->piece[i], p.piece[i]);
  }
}

}  // namespace
}  // namespace meltsim_test
