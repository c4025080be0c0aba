// SPDX-License-Identifier: Apache-2.0
// Which stages run side by side: whatever the scene, stages that touch the same channel keep their order.
#include "pipeline/schedule.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "exec/timings.hpp"

namespace {

using namespace meltsim::core;

std::uint64_t stages_of(FactSet facts) {
  std::uint64_t bits = 0;
  for (int s = 1; s < stage_count; ++s)  // step.begin runs ahead of what repeats
    if (runs(stage_table[static_cast<std::size_t>(s)], facts)) bits |= std::uint64_t{1} << s;
  return bits;
}

/// What has surely ended when a stage begins, from nothing but tracks and waits.
std::vector<std::uint64_t> ended_before(const Schedule& plan) {
  std::vector<std::uint64_t> before(stage_count, 0);
  int last[most_tracks] = {};
  for (int s = 0; s < stage_count; ++s) {
    const auto at = static_cast<std::size_t>(s);
    if (plan.track[at] < 0) continue;
    const auto take = [&](int t) {
      before[at] |= before[static_cast<std::size_t>(t)] | (std::uint64_t{1} << t);
    };
    int& end = last[plan.track[at]];
    if (end != 0) take(end);
    for (int t = 0; t < s; ++t)
      if (((plan.waits[at] >> t) & 1u) != 0) take(t);
    end = s;
  }
  return before;
}

TEST(Schedule, StagesThatTouchTheSameChannelKeepTheirOrder) {
  int pairs = 0;
  for (FactSet facts = 0; facts < fact_packed; ++facts) {
    if (!consistent(facts)) continue;
    for (const std::uint32_t search : search_facts) {
      const std::uint64_t running = stages_of(facts | search | fact_probes | fact_loads);
      const Schedule plan = make_schedule(running);
      const auto before = ended_before(plan);
      for (int s = 0; s < stage_count; ++s)
        for (int t = 0; t < s; ++t) {
          if (((running >> s) & (running >> t) & 1u) == 0) continue;
          const StageInfo &a = stage_table[static_cast<std::size_t>(t)],
                          &b = stage_table[static_cast<std::size_t>(s)];
          const FieldSet a_all = a.reads_apart | a.writes_apart, b_all = b.reads_apart | b.writes_apart;
          if ((a.writes_apart & b_all) == 0 && (b.writes_apart & a_all) == 0) continue;
          ++pairs;
          ASSERT_TRUE((before[static_cast<std::size_t>(s)] >> t) & 1u)
              << a.name << " and " << b.name << " with facts " << (facts | search);
        }
    }
  }
  EXPECT_GT(pairs, 10000);
}

// Liquid alone, in a scene that it cannot leave: probes run beside the sweep that ends the sub-step, which waits for all else.
TEST(Schedule, ProbesRunBesideTheSweepThatEndsTheSubstep) {
  const std::uint64_t running = stages_of(fact_particles | fact_fluid | fact_packed | fact_probes);
  ASSERT_TRUE((running >> stage_sampling_probes) & (running >> stage_sph_forces) & 1u);
  const auto waits_for_probes = [running](std::uint64_t barriers) {
    const Schedule plan = make_schedule(running, barriers);
    const auto before = ended_before(plan);
    // They have what they read, and the sub-step ends behind them.
    EXPECT_TRUE((before[stage_sampling_probes] >> stage_sph_density) & 1u);
    EXPECT_TRUE((before[stage_sph_forces] >> stage_sph_density) & 1u);
    const bool joined = plan.track[stage_sampling_probes] == 0 ||
                        ((plan.last >> stage_sampling_probes) & 1u) != 0 ||
                        ((before[stage_step_integrate] >> stage_sampling_probes) & 1u) != 0;
    EXPECT_TRUE(joined);
    return ((before[stage_sph_forces] | before[stage_step_integrate]) >> stage_sampling_probes & 1u) != 0;
  };
  EXPECT_TRUE(waits_for_probes(usual_barriers));
  EXPECT_TRUE(waits_for_probes(advancing_barriers));
  EXPECT_FALSE(waits_for_probes(probing_barriers));
}

TEST(Schedule, NothingPassesIntegrationAndAllEndsOnTheFirstTrack) {
  for (FactSet facts = 0; facts < fact_packed; ++facts) {
    if (!consistent(facts) || (facts & fact_particles) == 0) continue;
    const std::uint64_t running = stages_of(facts | fact_packed);
    const Schedule plan = make_schedule(running);
    const auto before = ended_before(plan);
    const std::uint64_t ahead = running & ((std::uint64_t{1} << stage_step_integrate) - 1);
    ASSERT_EQ(before[stage_step_integrate] & ahead, ahead) << facts;
    std::uint64_t joined = plan.last;
    for (int s = 0; s < stage_count; ++s) {
      if (((running >> s) & 1u) == 0) continue;
      if (plan.track[static_cast<std::size_t>(s)] == 0 || ((plan.last >> s) & 1u) != 0)
        joined |= before[static_cast<std::size_t>(s)] | (std::uint64_t{1} << s);
      if (s > stage_step_integrate) {
        ASSERT_TRUE((before[static_cast<std::size_t>(s)] >> stage_step_integrate) & 1u);
      }
    }
    ASSERT_EQ(joined, running) << facts;
  }
}

TEST(Schedule, WaterIsAChainMeltingIsNot) {
  const std::uint32_t water = fact_particles | fact_fluid | fact_packed;
  const Schedule one = make_schedule(stages_of(water));
  for (int s = 0; s < stage_count; ++s) EXPECT_LE(one.track[static_cast<std::size_t>(s)], 0) << s;

  const std::uint32_t melting =
      water | fact_solid | fact_mobile | fact_lattice | fact_contact | fact_melt | fact_heat_enthalpy;
  const Schedule many = make_schedule(stages_of(melting));
  const auto before = ended_before(many);
  const auto apart = [&](int a, int b) {
    return ((before[static_cast<std::size_t>(a)] >> b) & 1u) == 0 &&
           ((before[static_cast<std::size_t>(b)] >> a) & 1u) == 0;
  };
  EXPECT_TRUE(apart(stage_sph_forces, stage_thermal_exchange));
  EXPECT_TRUE(apart(stage_sph_forces, stage_lsm_goals));
  // By parts of velocity and acceleration.
  EXPECT_TRUE(apart(stage_sph_density, stage_lsm_gather));
  EXPECT_TRUE(apart(stage_sph_forces, stage_lsm_contact));
  EXPECT_TRUE(apart(stage_sph_forces, stage_sph_reaction));
  EXPECT_TRUE(apart(stage_lsm_goals, stage_thermal_exchange));
}

// Shape matching waits for memory: beside sums it takes a few threads and goes first, with all that it waits for.
TEST(Schedule, ShapeMatchingStepsAsideForSums) {
  const std::uint32_t solids =
      fact_particles | fact_packed | fact_solid | fact_mobile | fact_lattice | fact_contact;
  const std::uint32_t melting = solids | fact_fluid | fact_melt | fact_heat_enthalpy;
  const std::uint64_t chain = stage_bit(stage_lsm_gather) | stage_bit(stage_lsm_regions) |
                              stage_bit(stage_lsm_goals) | stage_bit(stage_lsm_balance);
  const Schedule many = make_schedule(stages_of(melting));
  EXPECT_EQ(many.aside, chain);
  const auto urgency = [&](int s) { return static_cast<int>(many.urgency[static_cast<std::size_t>(s)]); };
  for (const int s : {stage_spatial_cells, stage_spatial_settle}) EXPECT_EQ(urgency(s), 3) << s;
  for (const int s : {stage_lsm_gather, stage_lsm_balance, stage_topology_regions, stage_topology_pieces})
    EXPECT_EQ(urgency(s), 2) << s;
  for (const int s :
       {stage_sph_density, stage_thermal_operands, stage_sph_wetted, stage_lsm_normals, stage_topology_melt})
    EXPECT_EQ(urgency(s), 1) << s;
  for (const int s : {stage_sph_forces, stage_thermal_exchange, stage_lsm_contact, stage_sph_reaction,
                      stage_topology_neighbours})
    EXPECT_EQ(urgency(s), 0) << s;
  // Sorted cells are on the way to density, too, however far ahead.
  const Schedule sorted = make_schedule(stages_of((melting & ~fact_packed) | fact_sorted | fact_sparse));
  EXPECT_EQ(static_cast<int>(sorted.urgency[stage_spatial_keys]), 3);
  // Operands follow the sums that say what is missing around a particle.
  EXPECT_NE(ended_before(many)[stage_thermal_operands] & stage_bit(stage_sph_density), 0u);
  // Without liquid and heat there is nothing to step aside for.
  EXPECT_EQ(make_schedule(stages_of(solids | fact_dry)).aside, 0u);
}

// Every window of `every` sub-steps has one whose stages are timed and, where there is room, one that is timed as a whole;
// sub-steps that are a multiple of 16, in which pieces are looked for by default, are among them about once in 16 times.
TEST(Sampling, TimesOneSubStepOfEachWindowAndAllKindsOfThem) {
  for (const int every : {1, 2, 3, 16, 64, 400}) {
    Sampling sampling{every};
    int multiples = 0;
    for (int window = 0; window < 64; ++window) {
      int stages = 0, whole = 0;
      for (int n = 0; n < every; ++n) {
        const Sample s = sampling.next();
        stages += s == Sample::stages ? 1 : 0;
        whole += s == Sample::whole ? 1 : 0;
        multiples += s == Sample::stages && (window * every + n) % 16 == 0 ? 1 : 0;
      }
      EXPECT_EQ(stages, 1) << every;
      EXPECT_EQ(whole, every > 1 ? 1 : 0) << every;
    }
    EXPECT_GE(multiples, 2) << every;
    EXPECT_LE(multiples, 8) << every;
  }
  EXPECT_EQ(Sampling{}.next(), Sample::nothing);
}

}  // namespace
