// SPDX-License-Identifier: Apache-2.0
// The stability map finds what it is there to find. Each cell here has one fault in it that a cell of the map would have if
// the library had it.
#include <gtest/gtest.h>

#include <cmath>

#include "stress/setup.hpp"

namespace runner {
namespace {

using stress::Outcome;
using stress::run_cell;
using stress::Verdict;

/// The default tank in a second and a half of a processor at most.
stress::Setup tank() {
  stress::Setup s("axis", "value");
  s.world.backend = meltsim::Backend::cpu;
  s.most_substeps = 100;
  return s;
}

/// The block alone, which has fallen by 100 sub-steps of the 4 ms that there are then.
stress::Setup block() {
  stress::Setup s = tank();
  s.depth = 0;
  return s;
}

/// Calls before step k.
template <class Call>
stress::Setup with(stress::Setup s, int step, const Call& call) {
  s.between = [step, call](meltsim::World& w, int k) { return k == step ? call(w) : meltsim::Status{}; };
  return s;
}

TEST(Stress, ACellHolds) {
  const Outcome o = run_cell(tank());
  EXPECT_EQ(o.verdict, Verdict::holds) << o.note;
  EXPECT_EQ(o.particles, 8u * 4 * 8 + 27);
  EXPECT_EQ(o.substeps, 100u);
  EXPECT_GT(o.speed, 0);
}

TEST(Stress, NamesOfCellsDiffer) {
  std::vector<std::string> names;
  for (const stress::Setup& s : stress::all_cells()) names.push_back(s.axis + ": " + s.value);
  EXPECT_GE(names.size(), 250u);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
}

// An impulse from nowhere: the block, 198 kg, is thrown upwards at 6 m/s, where its fall through 1.6 m gives 5.6. Twice that is
// within the speed that a splash may have, but not within the energy.
TEST(Stress, EnergyFromNothingIsFound) {
  const Outcome o = run_cell(with(block(), 3, [](meltsim::World& w) {
    return w.set_velocity({0, w.pieces()->front().body.generation}, {0, 6, 0});
  }));
  EXPECT_EQ(o.verdict, Verdict::fails);
  EXPECT_NE(o.note.find("energy rises"), std::string::npos) << o.note;
}

TEST(Stress, MomentumFromNothingIsFound) {
  stress::Setup s = block();
  s.world.gravity = {0, 0, 0};
  s.walls = false;
  s.momentum = true;
  s.energy = false;
  s.blocks[0].velocity = {1, 0, 0};
  EXPECT_EQ(run_cell(s).verdict, Verdict::holds);
  const Outcome o = run_cell(with(s, 3, [](meltsim::World& w) {
    return w.apply_impulse({0, w.pieces()->front().body.generation}, {1, 0, 0});
  }));
  EXPECT_EQ(o.verdict, Verdict::fails);
  EXPECT_NE(o.note.find("momentum drifts"), std::string::npos) << o.note;
}

TEST(Stress, MassThatIsGoneIsFound) {
  stress::Setup s = tank();
  s.ledger = false;  // its heat goes with it
  const Outcome o = run_cell(with(s, 3, [](meltsim::World& w) {
    const auto removed = w.remove_liquid(meltsim::Shape::sphere({0.8, 0.3, 0.8}, 0.15));
    return removed ? meltsim::Status{} : meltsim::Status{removed.error()};
  }));
  EXPECT_EQ(o.verdict, Verdict::fails);
  EXPECT_NE(o.note.find("are left"), std::string::npos) << o.note;
}

TEST(Stress, HeatOutOfRangeIsFound) {
  stress::Setup s = tank();
  s.more = [](meltsim::World& w) {
    meltsim::HeatRegionDesc r;
    r.shape = meltsim::Shape::box({0, 0, 0}, {1.6, 0.4, 1.6});
    r.temperature = 90;
    const auto added = w.add_heat_region(r);
    return added ? meltsim::Status{} : meltsim::Status{added.error()};
  };
  const Outcome o = run_cell(s);
  EXPECT_EQ(o.verdict, Verdict::fails);
  EXPECT_NE(o.note.find("a temperature of"), std::string::npos) << o.note;
}

TEST(Stress, WhatIsRefusedNamesTheFix) {
  stress::Setup s = tank();
  s.world.courant = 2;
  EXPECT_EQ(run_cell(s).verdict, Verdict::refused);
  // Other words than a library's that name no field and no fix.
  s = tank();
  s.more = [](meltsim::World&) {
    return meltsim::Status{meltsim::Error{meltsim::ErrorCode::internal, "no"}};
  };
  const Outcome o = run_cell(s);
  EXPECT_EQ(o.verdict, Verdict::fails);
  EXPECT_NE(o.note.find("without a fix"), std::string::npos) << o.note;
}

void spoil(const meltsim::StageContext& c, void*) { static_cast<float*>(c.velocity)[0] = std::nanf(""); }

TEST(Stress, AHaltIsAFailure) {
  stress::Setup s = tank();
  s.more = [](meltsim::World& w) {
    return w.scheduler().insert_after("sph.forces", {"spoil", spoil, nullptr, {}, {"velocity"}});
  };
  const Outcome o = run_cell(s);
  EXPECT_EQ(o.verdict, Verdict::fails);
  EXPECT_NE(o.note.find("halts: "), std::string::npos) << o.note;
}

TEST(Stress, FlagsAreNamed) {
  stress::Setup s = tank();
  s.ice.youngs_modulus = 1e15;  // ten thousand times steel
  const Outcome o = run_cell(s);
  EXPECT_EQ(o.verdict, Verdict::clamped);
  EXPECT_EQ(o.note, "modulus_unreachable");
}

}  // namespace
}  // namespace runner
