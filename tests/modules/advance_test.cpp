// SPDX-License-Identifier: Apache-2.0
// sph.advance: forces and the end of the sub-step in one sweep does what the two stages do one by one, and a World that
// halts goes back to the bits it had, however its sub-steps were made.
#include <limits>
#include <string>

#include "meltsim/particle_tag.hpp"
#include "modules/engine.hpp"

namespace {

using namespace modules_test;

constexpr double dx = 0.1, dt = 1e-3;

/// Jittered water in a box, that moves. The upper face may be open: then the topmost layer leaves through it at 4 m/s,
/// some in the second sub-step, most in the third.
struct Pool {
  core::SceneConstants c = plain_constants(dx);
  core::SceneState s;
  explicit Pool(bool open = false) {
    c.one_liquid = true;
    c.domain.bounded = true;
    c.domain.max = {1.2, 1.2, 0.8};
    if (open) c.domain.faces[3] = Face::open;
    Random random(17);
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < (open ? 12 : 6); ++y)
        for (int x = 0; x < 12; ++x)
          add_particle(s, c,
                       Vec3d{x + 0.5, y + 0.5, z + 0.5} * dx + random.vector(0.02 * dx) +
                           Vec3d{0, open ? 0.042 : 0, 0},
                       0, random.vector(0.3) + Vec3d{0, open ? 4.0 : 0.0, 0});
  }
};

template <class T>
class Advance : public ::testing::Test {
 protected:
  static constexpr core::FactSet facts = core::fact_particles | core::fact_fluid;
  using Rig = modules_test::Rig<T>;
  static void step(Rig& rig, int times = 1) {
    for (int k = 0; k < times; ++k) rig.run({"step.begin", "spatial", "sph", "step.integrate"}, dt);
  }
  static core::SceneState state_of(Rig& rig) {
    core::SceneState s;
    rig.engine->download(s);
    return s;
  }
  static void expect_same(const core::SceneState& a, const core::SceneState& b, const std::string& what) {
    ASSERT_EQ(a.position.size(), b.position.size());
    for (std::size_t i = 0; i < a.position.size(); ++i) {
      ASSERT_EQ(length(a.position[i] - b.position[i]), 0.0) << what << ", position of " << i;
      ASSERT_EQ(length(a.velocity[i] - b.velocity[i]), 0.0) << what << ", velocity of " << i;
      ASSERT_EQ(a.volume[i], b.volume[i]) << what << ", volume of " << i;
      ASSERT_EQ(a.mass[i], b.mass[i]) << what << ", mass of " << i;
      ASSERT_EQ(a.enthalpy[i], b.enthalpy[i]) << what << ", enthalpy of " << i;
      ASSERT_EQ(a.tag[i], b.tag[i]) << what << ", tag of " << i;
    }
  }
};

using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Advance, Precisions);

// Sums of eight neighbours at a time and one by one are added up in other orders. After 20 sub-steps positions were
// apart by 2 units in the last place of the box, velocities by 60 of 1 m/s, densities by one; about four times that is
// let pass. What is beyond rho0 counts in units of 2^-22, and there are hundreds of particles to its mean.
TYPED_TEST(Advance, DoesWhatForcesAndIntegrationDo) {
  using T = TypeParam;
  for (const bool open : {false, true})
    for (const std::uint32_t search : core::search_facts) {
      const Pool pool(open);
      modules_test::Rig<T> one_by_one(Order::shuffled), at_once(Order::shuffled, true);
      for (auto* rig : {&one_by_one, &at_once}) {
        rig->upload(pool.c, {}, pool.s, this->facts | search);
        this->step(*rig, 20);
      }
      EXPECT_EQ(one_by_one.frame().next.position, nullptr);
      ASSERT_NE(at_once.frame().next.position, nullptr) << "the sweep was not taken";
      const auto a = this->state_of(one_by_one), b = this->state_of(at_once);
      const core::WorldStatus sa = one_by_one.engine->synchronize(), sb = at_once.engine->synchronize();
      const double unit = std::numeric_limits<T>::epsilon();
      std::size_t removed = 0;
      for (std::size_t i = 0; i < a.position.size(); ++i) {
        ASSERT_LT(length(a.position[i] - b.position[i]), 8 * unit * pool.c.domain.max.x)
            << i << ", search " << search;
        ASSERT_LT(length(a.velocity[i] - b.velocity[i]), 250 * unit) << i << ", search " << search;
        ASSERT_EQ(a.tag[i], b.tag[i]) << i;
        removed += is_removed(a.tag[i]) ? 1 : 0;
      }
      EXPECT_EQ(open, removed != 0) << "particles leave through the open face only";
      EXPECT_EQ(sa.removed, sb.removed);
      EXPECT_EQ(static_cast<std::size_t>(sb.removed), removed);
      EXPECT_EQ(sb.halted, 0u);
      EXPECT_NEAR(sa.step_speed, sb.step_speed, 250 * unit);
      EXPECT_NEAR(sa.step_density, sb.step_density, 4 * unit);
      EXPECT_GT(sb.step_excess, 0.0);
      EXPECT_NEAR(sa.step_excess, sb.step_excess, unit + 1e-2 / core::CheckResult::excess_units);
    }
}

// Timings make stages run one by one. Whatever mixture of the two a World was made by, before it halted and after, it
// goes back to the bits of the last sub-step that counts. Densities are those of the one that halted.
TYPED_TEST(Advance, AWorldThatHaltsGoesBackToItsBits) {
  for (const bool open : {false, true})
    for (int mixture = 0; mixture < 32; ++mixture) {
      const auto at_once = [mixture](int k) { return ((mixture >> k) & 1) != 0; };
      const Pool pool(open);
      using Rig = modules_test::Rig<TypeParam>;
      const auto next = [&](Rig& rig, bool fused) {
        rig.engine->enable_timings(!fused);
        this->step(rig);
        EXPECT_EQ(rig.frame().next.position != nullptr, fused);
      };
      // Two sub-steps; then someone is to move through its whole neighbourhood in the next one. Its place in the state is
      // where the last one wrote.
      const auto begin = [&](Rig& rig) {
        rig.upload(pool.c, {}, pool.s, this->facts | core::fact_packed);
        next(rig, at_once(0));
        next(rig, at_once(1));
        const core::Frame<TypeParam> w = rig.frame();
        auto* const velocity = at_once(1) ? w.next.velocity : w.f.velocity;
        std::uint32_t slot = 100;
        while (is_removed(w.f.tag[slot])) ++slot;
        velocity[slot].x = static_cast<TypeParam>(10 * pool.c.support / dt);
        return w.f.id[slot];
      };
      Rig rig(Order::shuffled, true), twin(Order::shuffled, true);
      const std::uint32_t culprit = begin(rig);
      begin(twin);
      twin.run({"step.begin", "spatial", "sph.density"}, dt);
      core::DerivedState found, expected;  // as the sub-step that halts finds it
      twin.engine->download(expected);
      const auto before = this->state_of(rig);
      for (int k = 2; k < 5; ++k) next(rig, at_once(k));
      if (open) {
        const core::Frame<TypeParam>& last = rig.frame();
        std::size_t had_left = 0, left = 0;
        for (std::size_t i = 0; i < before.tag.size(); ++i) {
          had_left += is_removed(before.tag[i]) ? 1u : 0u;
          left += is_removed(last.f.tag[i]) || is_removed(last.before.tag[i]) ? 1u : 0u;
        }
        EXPECT_GT(left, had_left) << "nobody leaves in the sub-step that halts";
      }
      const core::WorldStatus status = rig.engine->synchronize();
      const std::string what = "mixture " + std::to_string(mixture);
      EXPECT_EQ(static_cast<core::Halt>(status.halted), core::Halt::speed) << what;
      EXPECT_EQ(status.halt_step, 3u) << what;
      EXPECT_EQ(status.halt_particle, culprit) << what;
      this->expect_same(this->state_of(rig), before, what);
      rig.engine->download(found);
      EXPECT_EQ(found.density, expected.density) << what;
      EXPECT_EQ(found.pressure_term, expected.pressure_term) << what;
    }
}

// What is recorded of a sub-step is found again by a key, which has to tell all orders apart that buffers come in.
TYPED_TEST(Advance, ARecordedSubStepMeansItsBuffers) {
  const Pool pool;
  modules_test::Rig<TypeParam> rig(Order::forward, true);
  rig.upload(pool.c, {}, pool.s, this->facts | core::fact_packed);
  Random random(5);
  for (int k = 0; k < 60; ++k) {
    // At first in turn, which is back at the same positions after six, but not at the same velocities.
    const bool fused = k < 12 ? k % 2 == 0 : random.vector(1.0).x > 0;
    rig.engine->enable_timings(!fused);
    this->step(rig);
    EXPECT_EQ(rig.exec.wrong_repeats(), 0) << "sub-step " << k;
  }
  EXPECT_EQ(rig.engine->synchronize().halted, 0u);
}

// Where anything else happens between forces and the end of the sub-step, or somebody looks on, the stages run one by
// one: bodies, heat, several liquids.
TYPED_TEST(Advance, IsNotTakenWhereLiquidIsNotAlone) {
  const auto taken = [&](const Pool& pool, std::uint32_t more) {
    modules_test::Rig<TypeParam> rig(Order::forward, true);
    rig.upload(pool.c, {}, pool.s, this->facts | core::fact_packed | more);
    this->step(rig);
    return rig.frame().next.position != nullptr;
  };
  EXPECT_TRUE(taken(Pool(), 0));
  EXPECT_FALSE(taken(Pool(), core::fact_heat_enthalpy));
  EXPECT_FALSE(taken(Pool(), core::fact_shifting));
  EXPECT_FALSE(taken(Pool(), core::fact_viscosity));
  Pool two;
  two.c.one_liquid = false;
  EXPECT_FALSE(taken(two, 0));
  Pool solid;
  solid.s.tag[5] |= tag_solid;
  EXPECT_FALSE(taken(solid, 0));
}

// Probes read the middle of the sub-step, in which what leaves through the open face at its end is still there: a sweep
// that ends the sub-step waits for them, whatever the order of the rest.
TYPED_TEST(Advance, WaitsForProbes) {
  const Pool pool(true);
  core::ProbeSetup probes;
  core::ProbeRow row;
  row.width = row.listed = 1;
  row.field[0] = physics::SampleField::speed;
  row.fields = physics::sample_bit(row.field[0]);
  for (int k = 0; k < 12; ++k) probes.points.push_back({{(k + 0.5) * dx, 1.19, 0.4}, 0});
  row.values = 12;
  probes.rows = {row};
  probes.room = 12;
  std::vector<double> expected;
  for (const bool fuses : {false, true})
    for (const Order order : {Order::forward, Order::reversed, Order::shuffled}) {
      typename TestFixture::Rig rig(order, fuses);
      rig.upload(pool.c, {}, pool.s, this->facts);
      ASSERT_TRUE(rig.engine->set_probes(probes));
      rig.sampled = 1;
      std::vector<double> all;
      for (int k = 0; k < 3; ++k) {
        rig.run({"step.begin", "spatial", "sph", "sampling.probes", "step.integrate"}, dt);
        std::vector<double> values(12);
        EXPECT_EQ(rig.engine->samples(0, 12, values.data()), 0u);
        all.insert(all.end(), values.begin(), values.end());
      }
      EXPECT_GT(rig.engine->synchronize().removed, 0);
      if (expected.empty()) expected = all;
      ASSERT_EQ(all.size(), expected.size());
      // The first two sub-steps' sums round apart where they are fused (above), and (1 - r/H)^4 with them.
      for (std::size_t k = 0; k < all.size(); ++k)
        EXPECT_NEAR(all[k], expected[k], 1e-4) << k << ", fuses " << fuses;
      EXPECT_NEAR(all[30], 4, 0.4);
    }
}

}  // namespace
