// SPDX-License-Identifier: Apache-2.0
// compact(): what was removed is forgotten. Held to a World that does the same without: ids close up, and no other bit differs.
#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "body_cases.hpp"

namespace meltsim_test {
namespace {

const std::vector<BodyCase>& cases() {
  const auto nothing = [](WorldDesc&, IceScene&) {};
  static const std::vector<BodyCase> all = {
      {"melting", nothing, [](SolidDesc&) {}},
      {"double", [](WorldDesc& d, IceScene&) { d.precision = Precision::double_precision; },
       [](SolidDesc&) {}},
      {"tree", [](WorldDesc& d, IceScene&) { d.neighbour_search = NeighbourSearch::tree; },
       [](SolidDesc&) {}},
      {"rigid", nothing, [](SolidDesc& s) { s.motion = Motion::rigid; }},
      {"kinematic", nothing, [](SolidDesc& s) { s.motion = Motion::kinematic; }},
      {"freezing",
       [](WorldDesc&, IceScene& s) {
         s.freezes = true;
         s.growth = 1;
         s.water_temperature = 1;
         s.ice_temperature = -40;
       },
       [](SolidDesc& s) {
         s.growth = 1;
         s.temperature = -40;
       }},
  };
  return all;
}

void step(Scene& s, int n) {
  for (int k = 0; k < n; ++k) require(s.world.step(0.01));
}

/// Ids of b are what `was` says of a's; all else is the same.
void expect_same(World& a, World& b, const std::vector<std::uint32_t>& was) {
  const auto p = a.particles(), q = b.particles();
  ASSERT_TRUE(p && q);
  ASSERT_EQ(p->id.size(), q->id.size());
  for (std::size_t i = 0; i < p->id.size(); ++i) {
    if (q->id[i] < was.size()) EXPECT_EQ(was[q->id[i]], p->id[i]);
    else EXPECT_EQ(p->id.back() - p->id[i], q->id.back() - q->id[i]);  // of what came later
    EXPECT_EQ(is_solid(p->tag[i]), is_solid(q->tag[i]));               // of a body that may have another row
    EXPECT_EQ(material_of(p->tag[i]), material_of(q->tag[i]));
    EXPECT_EQ(p->temperature[i], q->temperature[i]);
    EXPECT_EQ(p->mass[i], q->mass[i]);
    EXPECT_EQ(length(p->position[i] - q->position[i]), 0);
    EXPECT_EQ(length(p->velocity[i] - q->velocity[i]), 0);
  }
  const StepResult r = a.synchronize(), t = b.synchronize();
  EXPECT_EQ(r.fluid, t.fluid);
  EXPECT_EQ(r.solid, t.solid);
  EXPECT_EQ(r.melted, t.melted);
  EXPECT_EQ(r.frozen, t.frozen);
  EXPECT_EQ(r.removed, t.removed);
  const auto e = a.ledger(), f = b.ledger();
  ASSERT_TRUE(e && f);
  EXPECT_NEAR(e->mass, f->mass, 1e-12 * e->mass);  // sums over all ids are over others
  EXPECT_NEAR(e->thermal, f->thermal, 1e-12 * std::abs(e->thermal));
  const auto k = a.pieces(), l = b.pieces();
  ASSERT_TRUE(k && l);
  ASSERT_EQ(k->size(), l->size());
  for (std::size_t i = 0; i < k->size(); ++i) {
    EXPECT_EQ((*k)[i].name, (*l)[i].name);
    EXPECT_EQ((*k)[i].particles, (*l)[i].particles);
    EXPECT_EQ(length((*k)[i].center - (*l)[i].center), 0);
  }
}

TEST(Compact, ClosesUpIdsAndChangesNothingElse) {
  MELTSIM_NEEDS_BACKEND();
  for (const BodyCase& c : cases()) {
    SCOPED_TRACE(c.name);
    Scene a = make(c), b = make(c);
    BodyId left[2], right[2];
    std::vector<std::uint32_t> was;
    int k = 0;
    for (Scene* s : {&a, &b}) {
      left[k] = *add(c, *s, "left", 0.2);
      // With so many vertices that sums in fixed point keep their unit without those of `left`: it follows from the digits of their
      // number, 162 to 216 (570 to 820 with sites to freeze onto).
      ASSERT_TRUE(add(c, *s, "behind", 1.6, 1.0, 6));
      step(*s, 12);
      right[k] = *add(c, *s, "right", 1.6);
      require(s->world.remove(left[k]));
      ASSERT_GT(*s->world.remove_liquid(Shape::box({-9, -9, -9}, {1, 0.5, 9})), 0u);
      step(*s, 5);
      ++k;
    }
    auto compacted = b.world.compact();
    ASSERT_TRUE(compacted) << compacted.error().message;
    was = *compacted;
    EXPECT_LT(was.size(), a.world.render_view({})->count);
    EXPECT_TRUE(std::is_sorted(was.begin(), was.end()));
    expect_same(a.world, b.world, was);
    // Nothing is left to forget.
    const auto again = b.world.compact();
    ASSERT_TRUE(again);
    EXPECT_EQ(again->size(), was.size());
    for (Scene* s : {&a, &b}) step(*s, 20);
    expect_same(a.world, b.world, was);
    // Handles are those of before, and what comes takes the next ids.
    EXPECT_FALSE(b.world.remove(left[1]));
    for (Scene* s : {&a, &b}) {
      if (c.name != std::string("kinematic")) require(s->world.hold(right[s == &a ? 0 : 1]));
      ASSERT_TRUE(add(c, *s, "middle", 0.9));
      step(*s, 5);
    }
    expect_same(a.world, b.world, was);
  }
}

// What is added from then on is put where it is on the backend, as before.
TEST(Compact, AWorldInWhichBodiesComeAndGoStaysAsLarge) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  d.reserved_particles = 100;
  Scene s{*World::create(d), {}, {}};
  s.water = *s.world.add_material({});
  FluidDesc pool;
  pool.material = s.water;
  pool.shape = Shape::box({0, 0, 0}, {1, 0.2, 1});
  require(s.world.add_fluid(pool));
  SolidDesc cube;
  cube.material = s.water;
  cube.motion = Motion::rigid;
  cube.shape = Shape::box({0.4, 0.6, 0.4}, {0.6, 0.8, 0.6});
  FluidDesc drop;
  drop.material = s.water;
  drop.shape = Shape::box({0.1, 0.6, 0.1}, {0.3, 0.8, 0.3});
  const auto order = [](BodyId a, BodyId b) {
    return std::tie(a.index, a.generation) < std::tie(b.index, b.generation);
  };
  std::set<BodyId, decltype(order)> handles(order);
  std::size_t bytes = 0;
  std::uint64_t uploads = 0, removed = 0;
  for (int round = 0; round < 12; ++round) {
    for (int k = 0; k < 3; ++k) {
      const auto body = s.world.add_solid(cube);
      ASSERT_TRUE(body) << body.error().message;
      EXPECT_LT(body->index, 3u);
      EXPECT_FALSE(handles.count(*body));
      for (const BodyId& old : handles) EXPECT_FALSE(s.world.hold(old));
      handles.insert(*body);
      ASSERT_TRUE(s.world.add_fluid(drop));
      require(s.world.step(0.002));
      require(s.world.remove(*body));
      const auto gone = s.world.remove_liquid(Shape::box({-9, 0.4, -9}, {9, 9, 9}));
      ASSERT_TRUE(gone);
      removed += 8 + *gone;
    }
    const auto was = s.world.compact();
    ASSERT_TRUE(was) << was.error().message;
    EXPECT_EQ(was->size(), 200u);
    EXPECT_EQ(s.world.synchronize().removed, removed);
    require(s.world.step(0.002));
    EXPECT_EQ(s.world.render_view({})->count, 200u);
    const std::size_t now = s.world.snapshot()->size();
    if (round > 0) {
      EXPECT_EQ(now, bytes);
    }
    bytes = now;
    // One for each compact(), and those of the first round.
    const std::uint64_t there = s.world.plan().uploads;
    if (round > 0) {
      EXPECT_EQ(there, uploads + 1);
    }
    uploads = there;
  }
  EXPECT_EQ(s.world.synchronize().fluid, 200u);
}

/// A shaft with an open floor, a nozzle that recycles above it, and liquid that is drained.
TEST(Compact, WhatANozzleHasInReserveStays) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<World> worlds;
  std::vector<std::uint32_t> was;
  for (const bool compacts : {false, true}) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.domain.bounded = true;
    d.domain.max = {1.2, 1.2, 1.2};
    d.domain.faces[2] = Face::open;
    d.gravity = {};
    d.sound_speed = 40;
    World w = std::move(*World::create(d));
    FluidDesc still;
    still.material = *w.add_material({});
    still.shape = Shape::box({0, 0.2, 0}, {0.2, 0.6, 1.2});
    require(w.add_fluid(still));
    EmitterDesc jet;
    jet.material = still.material;
    jet.center = {0.7, 1.0, 0.6};
    jet.axis = {0, -1, 0};
    jet.radius = 0.15;
    jet.speed = 2;
    jet.recycle = true;
    jet.max_particles = 120;
    require(w.add_emitter(jet));
    for (int k = 0; k < 4; ++k) require(w.step(0.1));
    ASSERT_EQ(*w.remove_liquid(Shape::box({-1, -1, -1}, {0.25, 9, 9})), 2u * 4u * 12u);
    if (compacts) was = *w.compact();
    for (int k = 0; k < 15; ++k) require(w.step(0.1));  // several times what the shaft holds
    worlds.push_back(std::move(w));
  }
  EXPECT_EQ(was.size(), 120u);
  EXPECT_EQ(was.front(), 96u);
  expect_same(worlds[0], worlds[1], was);
  EXPECT_GT(worlds[1].synchronize().entered, 240u);
  // A state of before is lost, one of after is not.
  require(worlds[1].save_state(0));
  ASSERT_GT(*worlds[1].remove_liquid(Shape::box({-1, -1, -1}, {9, 0.5, 9})), 0u);
  ASSERT_TRUE(worlds[1].compact());
  require(worlds[1].step(0.01));
  EXPECT_FALSE(worlds[1].load_state(0));
}

// Of one that melted in part: its row counts what melted off it, for the next body, too.
TEST(Compact, ASnapshotFitsAWorldThatForgotTheSame) {
  MELTSIM_NEEDS_BACKEND();
  const BodyCase& c = cases().front();
  Scene a = make(c), b = make(c), other = make(c);
  for (Scene* s : {&a, &b}) {
    const BodyId gone = *add(c, *s, "gone", 0.2);
    if (s == &a) {
      step(*s, 40);
      EXPECT_GT(a.world.synchronize().melted, 0u);
      EXPECT_GT(a.world.synchronize().solid, 0u);
    }
    require(s->world.remove(gone));
    ASSERT_TRUE(s->world.compact());
    const auto next = add(c, *s, "gone", 1.6);  // the name is free again
    ASSERT_TRUE(next) << next.error().message;
    EXPECT_EQ(next->index, gone.index);
  }
  step(a, 3);
  const auto bytes = a.world.snapshot();
  ASSERT_TRUE(bytes);
  const Status restored = b.world.restore(bytes->data(), bytes->size());
  ASSERT_TRUE(restored) << restored.error().message;
  for (Scene* s : {&a, &b}) step(*s, 10);
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  const StepResult r = a.world.synchronize(), t = b.world.synchronize();
  EXPECT_EQ(r.removed, t.removed);
  EXPECT_EQ(r.solid, t.solid);
  ASSERT_TRUE(add(c, other, "gone", 0.2));
  const Status refused = other.world.restore(bytes->data(), bytes->size());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("lattice vertices"), std::string::npos) << refused.error().message;
}

// What the host may still ask about a body that is forgotten must not be answered with the one in its row.
TEST(Compact, ARowThatTheHostMayAskAboutIsNotTaken) {
  MELTSIM_NEEDS_BACKEND();
  const BodyCase& c = cases().front();
  Scene s = make(c);
  require(s.world.watch_events());
  const BodyId first = *add(c, s, "first", 0.2), watched = *add(c, s, "watched", 1.6);
  ProbeDesc probe;
  probe.kind = ProbeKind::force;
  probe.body = watched;
  probe.fields = {"force"};
  require(s.world.add_probe(probe));
  step(s, 60);
  ReadRequest what;
  what.pieces = true;
  const auto ticket = s.world.request(what);
  ASSERT_TRUE(ticket) << ticket.error().message;
  for (const BodyId id : {first, watched}) require(s.world.remove(id));
  ASSERT_TRUE(s.world.compact());
  EXPECT_EQ(add(c, s, "third", 0.2)->index, 3u);  // the ice has row 0, and a reading of row 1 is open
  bool there = false;
  for (const PieceInfo& p : s.world.take(*ticket)->pieces)
    there = there || (p.body == first && p.name == "first");
  EXPECT_TRUE(there);
  const BodyId fourth = *add(c, s, "fourth", 0.2, 1.6);
  EXPECT_EQ(fourth.index, first.index);
  EXPECT_FALSE(fourth == first);
  EXPECT_EQ(add(c, s, "watched", 1.6)->index, 4u);  // a probe is on row 2; the name is free
  require(s.world.remove(*add(c, s, "sixth", 0.9)));
  ASSERT_TRUE(s.world.compact());
  EXPECT_FALSE(add(c, s, "watched", 0.9));  // row 2 had that name, and row 4 has it
  step(s, 60);
  const auto events = s.world.take_events();
  ASSERT_TRUE(events);
  std::size_t of_none = 0, of_fourth = 0;
  for (const Event& e : events->events) {
    EXPECT_FALSE(e.body == first);
    of_none += e.kind == EventKind::melted && !e.body ? 1u : 0u;
    of_fourth += e.body == fourth ? 1u : 0u;
  }
  EXPECT_GT(of_none, 0u);  // melted off what is no more
  EXPECT_GT(of_fourth, 0u);
}

}  // namespace
}  // namespace meltsim_test
