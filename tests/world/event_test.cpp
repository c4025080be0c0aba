// SPDX-License-Identifier: Apache-2.0
// Events: what a host would find by comparing the World before and after every sub-step, and nothing else.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

class EventTest : public testing::Test {
 protected:
  void SetUp() override { MELTSIM_NEEDS_BACKEND(); }
};

using EventRing = EventTest;

std::uint64_t count(const Events& e, EventKind kind) { return e.counts[static_cast<std::size_t>(kind)]; }

Events taken(World& w) {
  auto e = w.take_events();
  EXPECT_TRUE(e) << e.error().message;
  return e ? std::move(*e) : Events{};
}

void append(Events& to, const Events& more) {
  to.events.insert(to.events.end(), more.events.begin(), more.events.end());
  to.lost += more.lost;
  for (std::size_t k = 0; k < to.counts.size(); ++k) to.counts[k] += more.counts[k];
}

/// All that an event says, to the bit.
auto key(const Event& e) {
  return std::make_tuple(e.kind, e.step, e.time, e.position.x, e.position.y, e.position.z, e.particle,
                         e.body.index, e.other.index, e.wall, e.piece, e.from);
}

void expect_same(const std::vector<Event>& a, const std::vector<Event>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_TRUE(key(a[k]) == key(b[k])) << k;
}

World made(const WorldDesc& d) {
  auto w = World::create(d);
  if (!w) ADD_FAILURE() << w.error().message;
  return w ? std::move(*w) : *World::create();
}

std::uint64_t solids(World& w) {
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  return r.solid;
}

/// 27 particles of ice in 360 of warm water: a quarter of a second melts all of it.
Scene melting(int threads = 0) {
  WorldDesc d = describe();
  d.threads = threads;
  IceScene s;
  s.block_floor = 0.6;
  s.motion = Motion::free;
  return ice_in_water(d, s);
}

/// A cube of stone of 4 spacings above the floor of a dry box, and one that lies fixed beside it.
struct Stones {
  World world;
  BodyId falling, fixed;
};
Stones stones(double height, double over_fixed = 0) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {2, 2, 2};
  d.heat.model = HeatModel::none;
  World w = made(d);
  MaterialDesc m;
  m.name = "stone";
  m.density = 2000;
  const MaterialId stone = *w.add_material(m);
  SolidDesc s;
  s.material = stone;
  s.name = "falling";
  const double low = over_fixed > 0 ? 1.2 : 0.4;
  s.shape = Shape::box({low, height, 0.4}, {low + 0.4, height + 0.4, 0.8});
  const BodyId falling = *w.add_solid(s);
  s.name = "fixed";
  s.fixed = true;
  s.shape = Shape::box({1.0, 0, 0.2}, {1.8, over_fixed > 0 ? over_fixed : 0.2, 1});
  const BodyId fixed = *w.add_solid(s);
  return {std::move(w), falling, fixed};
}

/// Every sub-step of a melting block: an event per particle whose phase differs from before, at its place, and no other.
TEST_F(EventTest, MeltedEventsAreTheParticlesThatChangedPhase) {
  Scene s = melting();
  require(s.world.watch_events());
  require(s.world.prepare());
  const double dt = 0.9 * s.world.stable_dt();  // one sub-step a call
  auto before = *s.world.particles();
  const std::uint64_t built = solids(s.world);
  ASSERT_EQ(built, 27u);
  std::uint64_t melted = 0, gone = 0;
  std::set<std::uint32_t> seen;
  for (int k = 0; k < 4000 && solids(s.world) != 0; ++k) {
    require(s.world.step(dt));
    const auto now = *s.world.particles();
    const Events e = taken(s.world);
    ASSERT_EQ(e.lost, 0u);
    std::vector<std::uint32_t> expected;
    for (std::size_t i = 0; i < now.id.size(); ++i)
      if (is_solid(before.tag[i]) && !is_solid(now.tag[i])) expected.push_back(now.id[i]);
    std::vector<std::uint32_t> found;
    for (const Event& event : e.events) {
      EXPECT_EQ(event.step, s.world.steps());
      EXPECT_EQ(event.time, s.world.time());
      EXPECT_EQ(event.position.x, now.position[event.particle].x);
      EXPECT_EQ(event.position.y, now.position[event.particle].y);
      EXPECT_EQ(event.position.z, now.position[event.particle].z);
      EXPECT_EQ(event.body.index, 0u);
      if (event.kind == EventKind::gone) ++gone;
      if (event.kind != EventKind::melted) continue;
      found.push_back(event.particle);
      EXPECT_TRUE(seen.insert(event.particle).second);
    }
    EXPECT_EQ(found, expected);
    melted += count(e, EventKind::melted);
    ASSERT_EQ(melted, built - solids(s.world));
    before = now;
  }
  EXPECT_EQ(melted, built);
  EXPECT_EQ(gone, 1u);
  // Nothing more comes of a World without bodies.
  require(s.world.step(5 * dt));
  EXPECT_TRUE(taken(s.world).events.empty());
}

/// The shell that grows around a cold block in barely warm water (freeze_test.cpp): 100 of its particles.
TEST_F(EventTest, FrozenLessMeltedIsTheGrowthOfTheBody) {
  IceScene scene;
  scene.freezes = true;
  scene.growth = 2;
  scene.latent_heat = 5e4;
  scene.ice_temperature = -200;
  scene.water_temperature = 1;
  scene.block_floor = 0.4;
  scene.depth = 1.2;
  scene.box = 2.2;
  Scene s = ice_in_water(describe(), scene);
  require(s.world.watch_events());
  const std::uint64_t built = solids(s.world);
  Events all;
  for (int k = 0; k < 400 && solids(s.world) < built + 60; ++k) {
    require(s.world.step(0.005));
    append(all, taken(s.world));
    ASSERT_EQ(built + count(all, EventKind::frozen) - count(all, EventKind::melted), solids(s.world));
  }
  EXPECT_GE(count(all, EventKind::frozen), 60u);
  for (const Event& e : all.events) EXPECT_TRUE(e.kind != EventKind::frozen || e.body.index == 0u);
}

TEST_F(EventTest, ABodyThatComesApartSaysWhichPieceCameOffWhich) {
  IceScene scene;
  scene.block = 0;
  scene.box = 3.2;
  scene.depth = 2.0;
  Scene s = ice_in_water(describe(), scene);
  SolidDesc b;
  // Two 4-site cubes joined by a neck one site thick: the neck goes first (topology_test.cpp).
  b.shape = Shape::unite({Shape::box({0.4, 0.6, 1.0}, {1.2, 1.4, 1.8}),
                          Shape::box({1.2, 1.0, 1.4}, {2.0, 1.2, 1.6}),
                          Shape::box({2.0, 0.6, 1.0}, {2.8, 1.4, 1.8})});
  b.material = s.ice;
  b.temperature = -1;
  const BodyId id = *s.world.add_solid(b);
  require(s.world.watch_events());
  std::vector<PieceInfo> pieces = *s.world.pieces();
  std::set<std::uint32_t> labels{pieces.at(0).piece};
  std::size_t splits = 0, most = 1;
  require(s.world.prepare());
  const double dt = 0.9 * s.world.stable_dt();
  // Until both cubes are nearly gone. A piece may melt away, but it never comes but by a split.
  for (int k = 0; k < 6000 && solids(s.world) > 20; ++k) {
    require(s.world.step(dt));
    pieces = *s.world.pieces();
    for (const Event& e : taken(s.world).events) {
      if (e.kind != EventKind::split) continue;
      ++splits;
      EXPECT_EQ(e.body.index, id.index);
      const auto is = [&](std::uint32_t label) {
        return std::any_of(pieces.begin(), pieces.end(),
                           [label](const PieceInfo& p) { return p.piece == label; });
      };
      EXPECT_NE(e.piece, e.from);
      EXPECT_TRUE(labels.count(e.piece) == 0u);  // a new name
      // Particles that melted in this very sub-step may have been all of either piece.
      if (pieces.size() >= most + 1) {
        EXPECT_TRUE(is(e.piece));
        EXPECT_TRUE(is(e.from));
      }
    }
    // One that comes off while another melts away does not raise the number: splits are at least as many as that.
    most = std::max(most, pieces.size());
    EXPECT_GE(splits + 1, most);
    labels.clear();
    for (const PieceInfo& p : pieces) labels.insert(p.piece);
  }
  EXPECT_GE(most, 2u);
}

/// Contacts of every pair: begun, ended, begun, ...; and what holds at the end.
std::map<std::tuple<std::uint32_t, std::uint32_t, int>, bool> pair_up(const std::vector<Event>& events) {
  std::map<std::tuple<std::uint32_t, std::uint32_t, int>, bool> touching;
  for (const Event& e : events) {
    if (e.kind != EventKind::contact_begun && e.kind != EventKind::contact_ended) continue;
    bool& now = touching[{e.body.index, e.other ? e.other.index : 0xffffffffu, e.wall}];
    EXPECT_NE(now, e.kind == EventKind::contact_begun) << "step " << e.step;
    now = e.kind == EventKind::contact_begun;
    EXPECT_NE(static_cast<bool>(e.other), e.wall >= 0);
  }
  return touching;
}

/// A cube falls 0.2 m on the floor: it touches half a spacing's overlap later than sqrt(2 h/g) at most. Pushed up at 1 m/s, it
/// leaves the floor; it comes down again, and comes to rest.
TEST_F(EventTest, ContactsOfABodyWithTheFloorPairUp) {
  Stones s = stones(0.2);
  require(s.world.watch_events());
  Events all;
  const auto run = [&](double seconds) {
    for (int k = 0; k < static_cast<int>(seconds / 0.005); ++k) {
      require(s.world.step(0.005));
      append(all, taken(s.world));
    }
  };
  run(2);  // it bounces for 1.2 s
  ASSERT_FALSE(all.events.empty());
  const Event first = all.events.front();
  EXPECT_EQ(first.kind, EventKind::contact_begun);
  EXPECT_EQ(first.body.index, s.falling.index);
  EXPECT_FALSE(first.other);
  EXPECT_EQ(first.wall, 2);
  // Its lowest particles have their centres half a spacing above its face, where they rest on the wall.
  EXPECT_NEAR(first.time, std::sqrt(2 * 0.2 / 9.81), 0.01);
  EXPECT_NEAR(first.position.y, 0.05, 0.01);
  auto touching = pair_up(all.events);
  EXPECT_TRUE((touching[{s.falling.index, 0xffffffffu, 2}]));
  require(s.world.set_velocity(s.falling, {0, 1, 0}));
  run(0.05);
  touching = pair_up(all.events);
  EXPECT_FALSE((touching[{s.falling.index, 0xffffffffu, 2}]));
  run(2.2);  // it bounces for 1.2 s
  touching = pair_up(all.events);
  EXPECT_TRUE((touching[{s.falling.index, 0xffffffffu, 2}]));
  EXPECT_EQ(touching.size(), 1u);  // nothing else was touched, the fixed body's own floor included
  EXPECT_EQ(all.events.size(), count(all, EventKind::contact_begun) + count(all, EventKind::contact_ended));
}

/// A cube that falls on a fixed one: a pair, named by both, whichever of them is the lower index.
TEST_F(EventTest, ContactsOfTwoBodiesPairUp) {
  Stones s = stones(0.6, 0.4);
  require(s.world.watch_events());
  Events all;
  for (int k = 0; k < 400; ++k) {
    require(s.world.step(0.005));
    append(all, taken(s.world));
  }
  ASSERT_FALSE(all.events.empty());
  EXPECT_EQ(all.events.front().body.index, s.falling.index);
  EXPECT_EQ(all.events.front().other.index, s.fixed.index);
  EXPECT_EQ(all.events.front().wall, -1);
  EXPECT_NEAR(all.events.front().time, std::sqrt(2 * 0.2 / 9.81), 0.02);
  const auto touching = pair_up(all.events);
  ASSERT_EQ(touching.size(), 1u);
  EXPECT_TRUE(touching.begin()->second);
}

/// What is added, and with it uploaded, begins no contact twice and loses no event; what the host takes out ends its contacts and
/// is not gone by melting.
TEST_F(EventTest, UploadsKeepContactsAndEventsThatWereNotTaken) {
  Stones s = stones(0.6, 0.4);
  require(s.world.watch_events());
  for (int k = 0; k < 20; ++k) require(s.world.step(0.1));
  SolidDesc more;
  more.material = MaterialId{0, 1};
  more.shape = Shape::box({0.2, 1, 1.2}, {0.6, 1.4, 1.6});
  more.fixed = true;
  require(s.world.add_solid(more));
  require(s.world.step(0.1));
  Events all = taken(s.world);
  const auto touching = pair_up(all.events);
  ASSERT_EQ(touching.size(), 1u);
  EXPECT_TRUE(touching.begin()->second);
  require(s.world.remove(s.fixed));
  require(s.world.step(0.01));
  append(all, taken(s.world));
  EXPECT_FALSE(pair_up(all.events).begin()->second);
  EXPECT_EQ(count(all, EventKind::gone), 0u);
  EXPECT_EQ(count(all, EventKind::left), 0u);
}

/// Liquid that runs out through an open side: as many as StepResult::removed, each once.
TEST_F(EventTest, WhatLeavesTheDomainIsWhatWasRemoved) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 0.6};
  d.domain.faces[1] = Face::open;
  d.heat.model = HeatModel::none;
  World w = made(d);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {1, 0.5, 0.6});
  require(w.add_fluid(f));
  require(w.watch_events());
  Events all;
  for (int k = 0; k < 40; ++k) {
    require(w.step(0.02));
    append(all, taken(w));
  }
  const StepResult r = w.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  ASSERT_GT(r.removed, 20u);
  EXPECT_EQ(count(all, EventKind::left), r.removed);
  std::set<std::uint32_t> seen;
  for (const Event& e : all.events) {
    ASSERT_EQ(e.kind, EventKind::left);
    EXPECT_TRUE(seen.insert(e.particle).second);
    EXPECT_FALSE(e.body);
    EXPECT_GT(e.position.x, 0.99);
  }
}

/// Emission is no event, and ids that come to be while the World runs are looked at like others.
TEST_F(EventTest, EmittedParticlesLeaveToo) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {2, 1, 1};
  d.domain.faces[1] = Face::open;
  d.heat.model = HeatModel::none;
  World w = made(d);
  EmitterDesc e;
  e.material = *w.add_material({});
  e.center = {0.4, 0.5, 0.5};
  e.axis = {1, 0, 0};
  e.radius = 0.2;
  e.speed = 4;
  e.until = 0.5;
  require(w.add_emitter(e));
  require(w.watch_events());
  for (int k = 0; k < 40; ++k) require(w.step(0.025));
  const StepResult r = w.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  ASSERT_GT(r.removed, 50u);
  const Events all = taken(w);
  EXPECT_EQ(count(all, EventKind::left), r.removed);
  EXPECT_EQ(all.events.size(), r.removed);
}

TEST_F(EventTest, TheyDependNeitherOnThreadsNorOnWhenTheHostTakesThem) {
  Scene one = melting(1), other = melting(2), late = melting(2);
  require(one.world.watch_events());
  require(other.world.watch_events());
  require(late.world.watch_events());
  Events a, b;
  for (int k = 0; k < 100; ++k) {
    require(one.world.step(0.005));
    require(other.world.step(0.005));
    require(late.world.step(0.005));
    append(a, taken(one.world));
    append(b, taken(other.world));
  }
  ASSERT_GT(a.events.size(), 20u);
  expect_same(a.events, b.events);
  expect_same(a.events, taken(late.world).events);
  // Within a sub-step particles are in order of id.
  for (std::size_t k = 1; k < a.events.size(); ++k) {
    EXPECT_LE(a.events[k - 1].step, a.events[k].step);
    if (a.events[k - 1].step == a.events[k].step && a.events[k].kind == EventKind::melted) {
      EXPECT_LT(a.events[k - 1].particle, a.events[k].particle);
    }
  }
}

/// A ring of 4 has the last 4 of what a large one has, and says how many it lost.
TEST_F(EventRing, KeepsTheLastAndCountsTheOthers) {
  Scene large = melting(), small = melting();
  require(large.world.watch_events());
  EventWatch few;
  few.capacity = 4;
  require(small.world.watch_events(few));
  for (int k = 0; k < 10; ++k) {
    require(large.world.step(0.05));
    require(small.world.step(0.05));
  }
  const Events all = taken(large.world), last = taken(small.world);
  ASSERT_GT(all.events.size(), 8u);
  ASSERT_EQ(last.events.size(), 4u);
  EXPECT_EQ(last.lost, all.events.size() - 4);
  EXPECT_EQ(last.counts, all.counts);
  expect_same({all.events.end() - 4, all.events.end()}, last.events);
}

TEST_F(EventRing, HasOnlyTheKindsAskedFor) {
  Scene s = melting();
  EventWatch what;
  what.kinds = event_bit(EventKind::gone);
  require(s.world.watch_events(what));
  melt(s.world, 0.005, 4);
  require(s.world.step(0.005));
  const Events e = taken(s.world);
  ASSERT_EQ(e.events.size(), 1u);
  EXPECT_EQ(e.events[0].kind, EventKind::gone);
  EXPECT_EQ(count(e, EventKind::melted), 0u);
}

/// Taken without waiting, one frame late, they are those that a host that waits gets.
TEST_F(EventRing, ReadingsHaveThemWithoutWaiting) {
  Scene one = melting(), other = melting();
  require(one.world.watch_events());
  require(other.world.watch_events());
  ReadRequest what;
  what.events = true;
  std::vector<Event> a, b;
  ReadTicket open;
  for (int k = 0; k < 100; ++k) {
    require(one.world.step(0.005));
    require(other.world.step(0.005));
    const Events now = taken(one.world);
    a.insert(a.end(), now.events.begin(), now.events.end());
    const auto ticket = other.world.request(what);
    require(ticket);
    if (open.value != 0) {
      const auto r = other.world.take(open);
      require(r);
      b.insert(b.end(), r->events.events.begin(), r->events.events.end());
    }
    open = *ticket;
  }
  const auto r = other.world.take(open);
  require(r);
  b.insert(b.end(), r->events.events.begin(), r->events.events.end());
  ASSERT_GT(a.size(), 20u);
  expect_same(a, b);
}

TEST_F(EventRing, GoesBackWithASavedState) {
  Scene s = melting();
  require(s.world.watch_events());
  require(s.world.step(0.05));
  (void)taken(s.world);
  require(s.world.save_state(0));
  require(s.world.step(0.1));
  const Events first = taken(s.world);
  ASSERT_GT(first.events.size(), 2u);
  require(s.world.load_state(0));
  require(s.world.step(0.1));
  expect_same(first.events, taken(s.world).events);
}

/// Watching changes no bit of the state; where nobody watches there is neither stage nor memory.
TEST_F(EventTest, NothingRunsWhereNobodyWatches) {
  Scene watched = melting(), other = melting();
  require(watched.world.watch_events());
  require(watched.world.step(0.1));
  require(other.world.step(0.1));
  EXPECT_EQ(*watched.world.state_hash(), *other.world.state_hash());
  const auto used = [](World& w) {
    const Plan p = w.plan();
    int stages = 0;
    std::uint64_t bytes = 0;
    for (const StageReport& s : p.stages)
      if (s.name == "sampling.events" || s.name == "sampling.touches") stages += s.runs ? 1 : 0;
    for (const ChannelReport& c : p.channels)
      if (c.name.find("seen_") == 0 || c.name.find("event") == 0 || c.name == "touch" ||
          c.name == "new_piece")
        bytes += c.bytes;
    return std::make_pair(stages, bytes);
  };
  EXPECT_EQ(used(watched.world).first, 2);
  EXPECT_GT(used(watched.world).second, 0u);
  EXPECT_EQ(used(other.world).first, 0);
  EXPECT_EQ(used(other.world).second, 0u);
  require(watched.world.stop_events());
  require(watched.world.step(0.1));
  require(other.world.step(0.1));
  EXPECT_EQ(used(watched.world).first, 0);
  EXPECT_EQ(used(watched.world).second, 0u);
  EXPECT_EQ(*watched.world.state_hash(), *other.world.state_hash());
}

template <class R>
std::string refusal(const R& r) {
  EXPECT_FALSE(r);
  return r ? "" : r.error().message;
}

TEST_F(EventTest, WhatCannotBeIsRefused) {
  World w = made(describe());
  EXPECT_NE(refusal(w.take_events()).find("watch_events"), std::string::npos);
  ReadRequest what;
  what.events = true;
  EXPECT_NE(refusal(w.request(what)).find("events"), std::string::npos);
  EventWatch watch;
  watch.capacity = 0;
  EXPECT_NE(refusal(w.watch_events(watch)).find("capacity"), std::string::npos);
  watch.capacity = 0xffffffffu;
  EXPECT_NE(refusal(w.watch_events(watch)).find("capacity"), std::string::npos);
  watch = {};
  watch.kinds = 0;
  EXPECT_NE(refusal(w.watch_events(watch)).find("kinds"), std::string::npos);
  watch.kinds = 1u << 30;
  EXPECT_NE(refusal(w.watch_events(watch)).find("kinds"), std::string::npos);
  // Nothing of that began to watch; of an empty World there is nothing to report.
  EXPECT_FALSE(w.take_events());
  require(w.watch_events());
  EXPECT_TRUE(taken(w).events.empty());
  require(w.step(0.1));
  EXPECT_TRUE(taken(w).events.empty());
  require(w.stop_events());
  require(w.stop_events());
  EXPECT_FALSE(w.take_events());
}

/// The table of contacts has 1,024 bodies. A particle each is enough.
TEST_F(EventTest, ContactsAmongTooManyBodiesAreRefused) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.heat.model = HeatModel::none;
  d.gravity = {};
  World w = made(d);
  SolidDesc s;
  s.material = *w.add_material({});
  const auto add = [&](int k) {
    const Vec3d at{0.3 * (k % 33), 0.3 * (k / 33), 0};
    s.shape = Shape::box(at, at + Vec3d{0.1, 0.1, 0.1});
    return w.add_solid(s);
  };
  for (int k = 0; k < 1024; ++k) require(add(k));
  require(w.watch_events());
  require(w.step(1e-3));
  EXPECT_NE(refusal(add(1024)).find("1024 bodies"), std::string::npos);
  require(w.stop_events());
  require(add(1024));
  EXPECT_NE(refusal(w.watch_events()).find("1024 bodies"), std::string::npos);
  EventWatch phases;
  phases.kinds = event_bit(EventKind::melted);
  require(w.watch_events(phases));
}

}  // namespace
}  // namespace meltsim_test
