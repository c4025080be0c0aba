// SPDX-License-Identifier: Apache-2.0
// Readings that are taken while the World goes on: they are of the moment of their request, whatever follows.
#include <cmath>

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

}  // namespace
}  // namespace meltsim_test
