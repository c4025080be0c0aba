// SPDX-License-Identifier: Apache-2.0
// save() and load_saved(): a World that has other bodies, or none, goes on as the one that was saved, to the bit.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "body_cases.hpp"

namespace meltsim_test {
namespace {

/// A cube of 0.6 m as a mesh.
TriangleMesh cube_mesh(Vec3d low) {
  TriangleMesh m;
  for (int k = 0; k < 8; ++k)
    m.vertices.push_back(low + Vec3d{(k & 1) * 0.6, (k >> 1 & 1) * 0.6, (k >> 2 & 1) * 0.6});
  for (const std::uint32_t k : {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5})
    m.indices.push_back(k);
  return m;
}

const std::vector<BodyCase>& cases() {
  const auto nothing = [](WorldDesc&, IceScene&) {};
  static const std::vector<BodyCase> all = {
      {"melting", nothing, [](SolidDesc&) {}},
      {"double", [](WorldDesc& d, IceScene&) { d.precision = Precision::double_precision; },
       [](SolidDesc&) {}},
      {"tree", [](WorldDesc& d, IceScene&) { d.neighbour_search = NeighbourSearch::tree; },
       [](SolidDesc&) {}},
      {"weightless", [](WorldDesc& d, IceScene&) { d.gravity = {}; }, [](SolidDesc&) {}},
      {"fixed", nothing, [](SolidDesc& s) { s.motion = Motion::fixed; }},
      {"rigid", nothing,
       [](SolidDesc& s) {
         s.motion = Motion::rigid;
         s.held_until = 0.14;
         s.angular_velocity = {0, 1, 0};
       }},
      {"kinematic", nothing,
       [](SolidDesc& s) {
         s.motion = Motion::kinematic;
         s.velocity = {-0.1, 0, 0};
         s.angular_velocity = {0, 0.1, 0};
         s.pivot = Vec3d{1.1, 1.2, 0.9};
         s.heat_source = 1e3;
         s.surface.flux = 50;
       }},
      {"heated", nothing,
       [](SolidDesc& s) {
         s.surface.convection = 40;
         s.surface.emissivity = 0.5;
         s.surface.ambient = 90;
       }},
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

/// make() without anything in it but its materials.
Scene make_empty(const BodyCase& c) {
  WorldDesc d = describe();
  IceScene s = scene_of(c, d);
  s.water = false;
  s.block = 0;
  return ice_in_water(d, s);
}

void step(World& w, int n) {
  for (int k = 0; k < n; ++k) require(w.step(0.01));
}

/// All that a host sees of two Worlds is the same.
void expect_same(World& a, World& b) {
  EXPECT_EQ(*a.state_hash(), *b.state_hash());
  EXPECT_EQ(a.time(), b.time());
  EXPECT_EQ(a.resolved().sound_speed, b.resolved().sound_speed);
  EXPECT_EQ(a.stable_dt(), b.stable_dt());
  const StepResult r = a.synchronize(), t = b.synchronize();
  EXPECT_EQ(r.fluid, t.fluid);
  EXPECT_EQ(r.solid, t.solid);
  EXPECT_EQ(r.melted, t.melted);
  EXPECT_EQ(r.frozen, t.frozen);
  EXPECT_EQ(r.removed, t.removed);
  const auto k = a.pieces(), l = b.pieces();
  ASSERT_TRUE(k && l);
  ASSERT_EQ(k->size(), l->size());
  for (std::size_t i = 0; i < k->size(); ++i) {
    EXPECT_EQ((*k)[i].name, (*l)[i].name);
    EXPECT_EQ((*k)[i].particles, (*l)[i].particles);
    EXPECT_EQ(length((*k)[i].center - (*l)[i].center), 0);
  }
  const auto all = a.bodies(), others = b.bodies();
  ASSERT_TRUE(all && others);
  ASSERT_EQ(all->size(), others->size());
  for (std::size_t i = 0; i < all->size(); ++i) {
    EXPECT_EQ((*all)[i].name, (*others)[i].name);
    EXPECT_EQ((*all)[i].body.index, (*others)[i].body.index);
    EXPECT_EQ((*all)[i].motion, (*others)[i].motion);
    EXPECT_EQ((*all)[i].held, (*others)[i].held);
    EXPECT_EQ((*all)[i].material.index, (*others)[i].material.index);
  }
  const auto p = a.save(), q = b.save();
  ASSERT_TRUE(p && q);
  EXPECT_EQ(p->size(), q->size());
}

BodyId named(const World& w, const std::string& name) {
  const std::vector<BodyInfo> all = *w.bodies();
  const auto found = std::find_if(all.begin(), all.end(), [&](const BodyInfo& b) { return b.name == name; });
  EXPECT_NE(found, all.end()) << name;
  return found == all.end() ? BodyId{} : found->body;
}

void take(World& to, World& from) {
  const auto bytes = from.save();
  ASSERT_TRUE(bytes) << bytes.error().message;
  const Status loaded = to.load_saved(bytes->data(), bytes->size());
  ASSERT_TRUE(loaded) << loaded.error().message;
}

// Bodies that came, went and were forgotten, and one in the row of another: a World without any of them takes it, and one with others.
TEST(SavedWorld, GoesOnInAWorldWithOtherBodies) {
  MELTSIM_NEEDS_BACKEND();
  for (const BodyCase& c : cases()) {
    SCOPED_TRACE(c.name);
    Scene a = make(c), other = make(c), empty = make_empty(c);
    const BodyId first = *add(c, a, "first", 0.2);
    ASSERT_TRUE(add(c, a, "second", 1.6, 1.0, 4));
    step(a.world, 10);
    require(a.world.remove(first));
    ASSERT_TRUE(a.world.compact());
    EXPECT_EQ(add(c, a, "in its row", 1.6)->index, first.index);
    const BodyId gone = *add(c, a, "removed", 0.2, 1.6);
    step(a.world, 3);
    require(a.world.remove(gone));
    step(a.world, 3);
    const BodyId old = *add(c, other, "another", 0.8);
    step(other.world, 2);
    for (Scene* s : {&empty, &other}) {
      take(s->world, a.world);
      expect_same(a.world, s->world);
    }
    EXPECT_FALSE(other.world.remove(old));
    EXPECT_FALSE(empty.world.remove(gone));
    EXPECT_FALSE(add(c, empty, "second", 0.2));  // the name is taken
    for (Scene* s : {&a, &empty, &other}) {
      step(s->world, 12);
      ASSERT_TRUE(add(c, *s, "late", 0.2, 0.9));
      require(s->world.remove(named(s->world, "second")));
      step(s->world, 3);
      ASSERT_TRUE(s->world.compact());
      EXPECT_EQ(add(c, *s, "later", 1.6, 1.0)->index, 2u);  // of "second"
      step(s->world, 3);
    }
    expect_same(a.world, empty.world);
    expect_same(a.world, other.world);
    EXPECT_FALSE(other.world.remove(old));
  }
}

/// A water tank with a proxy that is lighter than water and a mesh that moves.
struct Carried {
  World world;
  MaterialId water;
  BodyId proxy, mesh;
};

Carried make_carried(bool with_bodies) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1.6, 1.6, 1.6};
  Carried s{*World::create(d), {}, {}, {}};
  s.water = *s.world.add_material({});
  if (!with_bodies) return s;
  FluidDesc pool;
  pool.material = s.water;
  pool.shape = Shape::box({0, 0, 0}, {1.6, 0.8, 1.6});
  require(s.world.add_fluid(pool));
  SolidDesc body;
  body.material = s.water;
  body.name = "proxy";
  body.motion = Motion::proxy;
  body.mass = 30;
  body.shape = Shape::box({0.2, 0.5, 0.2}, {0.6, 0.9, 0.6});
  s.proxy = *s.world.add_solid(body);
  body.name = "mesh";
  body.motion = Motion::kinematic;
  body.mass = 0;
  body.max_speed = 2;
  body.shape = Shape::mesh(cube_mesh({0.8, 0.3, 0.8}));
  s.mesh = *s.world.add_solid(body);
  return s;
}

void move(Carried& s, double by) {
  TriangleMesh m = cube_mesh({0.8, 0.3, 0.8});
  for (std::size_t k = 4; k < 8; ++k) m.vertices[k] += Vec3d{by, 0, 0};  // sheared
  require(s.world.update_mesh(s.mesh, m.vertices));
  ProxyState p = *s.world.proxy(s.proxy);
  p.velocity += Vec3d{0, 0, 0.1};
  require(s.world.set_proxy(s.proxy, p));
  require(s.world.step(0.01));
}

TEST(SavedWorld, ProxiesAndMeshesGoOn) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool moved : {false, true}) {  // whether the mesh has moved by then
    Carried a = make_carried(true), b = make_carried(false);
    require(a.world.watch_forces(a.mesh));
    for (int k = 0; k < 4; ++k) {
      if (moved) move(a, 0.01 * k);
      else require(a.world.step(0.01));
    }
    take(b.world, a.world);
    b.proxy = named(b.world, "proxy");
    b.mesh = named(b.world, "mesh");
    expect_same(a.world, b.world);
    ASSERT_TRUE(a.world.take_forces());
    for (Carried* s : {&a, &b})
      for (int k = 0; k < 4; ++k) move(*s, 0.03 + 0.01 * k);
    expect_same(a.world, b.world);
    const auto f = a.world.take_forces(), g = b.world.take_forces();
    ASSERT_TRUE(f && g);
    ASSERT_EQ(f->size(), 2u);
    ASSERT_EQ(g->size(), 2u);
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_EQ(length((*f)[k].pressure.linear - (*g)[k].pressure.linear), 0);
  }
}

void expect_refused(Scene& s, const std::vector<std::uint8_t>& bytes, ErrorCode code, const char* says) {
  const auto before = s.world.save();
  const std::size_t bodies = s.world.bodies()->size();
  const Status refused = s.world.load_saved(bytes.data(), bytes.size());
  ASSERT_FALSE(refused) << says;
  EXPECT_EQ(refused.error().code, code) << refused.error().message;
  EXPECT_NE(refused.error().message.find(says), std::string::npos) << refused.error().message;
  EXPECT_EQ(refused.error().message.find("load_saved: "), 0u) << refused.error().message;
  EXPECT_EQ(s.world.bodies()->size(), bodies);
  EXPECT_EQ(*s.world.save(), *before);
}

TEST(SavedWorld, RefusesWhatDoesNotFitAndChangesNothing) {
  MELTSIM_NEEDS_BACKEND();
  const BodyCase& c = cases().front();
  Scene a = make(c), b = make(c);
  step(a.world, 3);
  const auto bytes = a.world.save();
  ASSERT_TRUE(bytes);
  const BodyId body = *add(c, b, "another", 0.2);
  step(b.world, 3);
  expect_refused(b, *a.world.snapshot(), ErrorCode::corrupt_data, "a snapshot, which restore() takes");
  const Status other = b.world.restore(bytes->data(), bytes->size());
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("load_saved()"), std::string::npos) << other.error().message;
  expect_refused(b, {}, ErrorCode::corrupt_data, "not a saved World");
  for (const std::size_t part : {8u, 12u, 20u, 28u, 100u, 1000u})
    expect_refused(b, {bytes->begin(), bytes->begin() + static_cast<std::ptrdiff_t>(part)},
                   ErrorCode::corrupt_data, "");
  std::vector<std::uint8_t> changed = *bytes;
  changed[200] ^= 1;
  expect_refused(b, changed, ErrorCode::corrupt_data, "checksum");
  changed = *bytes;
  changed[8] = 99;
  expect_refused(b, changed, ErrorCode::version_mismatch, "version 99");
  ReadRequest what;
  what.totals = true;
  const auto ticket = b.world.request(what);
  ASSERT_TRUE(ticket);
  const Status open = b.world.load_saved(bytes->data(), bytes->size());
  ASSERT_FALSE(open);
  EXPECT_NE(open.error().message.find("reading"), std::string::npos) << open.error().message;
  ASSERT_TRUE(b.world.take(*ticket));
  ProbeDesc probe;
  probe.name = "push";
  probe.kind = ProbeKind::force;
  probe.body = body;
  probe.fields = {"force"};
  require(b.world.add_probe(probe));
  expect_refused(b, *bytes, ErrorCode::invalid_argument, "probe \"push\"");
  WorldDesc d = describe();
  Scene denser = ice_in_water(d, [] {
    IceScene s;
    s.ice_density = 900;
    return s;
  }());
  expect_refused(denser, *bytes, ErrorCode::invalid_argument, "materials");
  d.spacing = 0.1;
  Scene finer{*World::create(d), {}, {}};
  expect_refused(finer, *bytes, ErrorCode::invalid_argument, "spacing");
}

/// Sets the checksum of bytes that were changed: FNV-1a of all but the last eight.
void sign(std::vector<std::uint8_t>& bytes) {
  std::uint64_t h = 14695981039346656037ull;
  for (std::size_t k = 0; k + 8 < bytes.size(); ++k) h = (h ^ bytes[k]) * 1099511628211ull;
  std::memcpy(bytes.data() + bytes.size() - 8, &h, 8);
}

// Whoever changes a file on purpose: it is refused, or a World that steps, never a crash. Each byte of what there is of bodies, to
// 0, 0x7f, 0x80 and 0xff; of their sites and of the state only some, since there are many alike.
TEST(SavedWorld, ADamagedBodyIsRefusedOrSteps) {
  MELTSIM_NEEDS_BACKEND();
  const BodyCase& c = cases().back();
  WorldDesc d = describe();
  IceScene scene = scene_of(c, d);
  scene.water = false;
  Scene a = ice_in_water(d, scene);
  ASSERT_TRUE(add(c, a, "second", 1.6));
  step(a.world, 1);
  const std::vector<std::uint8_t> bytes = *a.world.save();
  int refused = 0, taken = 0;
  for (std::size_t k = 12; k + 8 < bytes.size(); k += k < 500 ? 1 : 89)
    for (const int value : {0, 0x7f, 0x80, 0xff}) {
      std::vector<std::uint8_t> changed = bytes;
      if (changed[k] == value) continue;
      changed[k] = static_cast<std::uint8_t>(value);
      sign(changed);
      const Status loaded = a.world.load_saved(changed.data(), changed.size());
      ++(loaded ? taken : refused);
      if (!loaded) {
        EXPECT_FALSE(loaded.error().message.empty());
        continue;
      }
      static_cast<void>(a.world.step(1e-4));
      static_cast<void>(a.world.synchronize());
      static_cast<void>(a.world.pieces());
    }
  EXPECT_GT(refused, 100);
  EXPECT_GT(taken, 100);  // a name, a number that may be another
  const Status loaded = a.world.load_saved(bytes.data(), bytes.size());
  EXPECT_TRUE(loaded) << loaded.error().message;
}

// More left with it than it was built of: what froze on.
TEST(SavedWorld, TheRowOfABodyThatGrewAndWentIsLoaded) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene;
  scene.freezes = true;
  scene.latent_heat = 5e4;  // the cold of the ice does for a layer of liquid
  scene.water_temperature = 1;
  scene.block = 0;
  Scene a = ice_in_water(describe(), scene);
  scene.water = false;
  Scene b = ice_in_water(describe(), scene);
  SolidDesc cold;
  cold.material = a.ice;
  cold.shape = Shape::box({0.6, 0.2, 0.6}, {1.2, 0.8, 1.2});
  cold.temperature = -200;
  cold.growth = 2;
  const BodyId grown = *a.world.add_solid(cold);
  for (int k = 0; k < 200 && a.world.synchronize().frozen < 5; ++k) step(a.world, 1);
  ASSERT_GE(a.world.synchronize().frozen, 5u);
  require(a.world.remove(grown));
  ASSERT_TRUE(a.world.compact());
  cold.temperature = -1;
  cold.growth = 0;
  EXPECT_EQ(a.world.add_solid(cold)->index, 0u);
  take(b.world, a.world);
  expect_same(a.world, b.world);
  const auto bytes = a.world.snapshot();
  ASSERT_TRUE(bytes);
  require(a.world.restore(bytes->data(), bytes->size()));
  for (Scene* s : {&a, &b}) step(s->world, 5);
  expect_same(a.world, b.world);
}

// A material whose only body has gone, one that was held when it went, a nozzle that never gave anything: limits of sub-steps are those
// of the World that goes on, whether bodies were added in place or not.
TEST(SavedWorld, WhatIsGoneCountsAsInTheWorldThatGoesOn) {
  MELTSIM_NEEDS_BACKEND();
  for (const std::uint64_t reserved : {0u, 3000u}) {
    SCOPED_TRACE(reserved);
    std::vector<World> worlds;
    for (int k = 0; k < 2; ++k) {
      WorldDesc d = describe();
      d.spacing = 0.1;
      d.domain.bounded = true;
      d.domain.max = {1.2, 2.4, 1.2};
      d.heat.time_scale = 3e4;
      d.density_error = 0.05;
      d.reserved_particles = reserved;
      World w = std::move(*World::create(d));
      MaterialDesc m;
      const MaterialId water = *w.add_material(m);
      m.name = "metal";
      m.conductivity = 300;
      m.density = 1500;
      const MaterialId metal = *w.add_material(m);
      m.name = "rock";
      m.conductivity = 1;
      require(w.add_material(m));
      m.name = "oil";
      m.density = 800;
      m.viscosity = 5;
      const MaterialId oil = *w.add_material(m);
      EmitterDesc e;
      e.material = oil;
      e.center = {0.6, 2, 0.6};
      e.radius = 0.15;
      e.until = 0.05;
      const EmitterId tap = *w.add_emitter(e);
      if (k == 0) {
        EmitterSetting off;
        off.on = false;
        require(w.set_emitter(tap, off));
        FluidDesc f;
        f.material = water;
        f.shape = Shape::box({0, 0, 0}, {1.2, 0.3, 1.2});
        f.temperature = 60;
        require(w.add_fluid(f));
        SolidDesc s;
        s.name = "soft";
        s.material = metal;
        s.shape = Shape::box({0.1, 0.4, 0.1}, {0.4, 0.7, 0.4});
        const BodyId gone = *w.add_solid(s);
        s.name = "held";
        s.material.index = 2;
        s.held_until = 0.08;
        s.shape = Shape::box({0.7, 0.4, 0.7}, {1.0, 2.2, 1.0});
        const BodyId held = *w.add_solid(s);
        step(w, 5);
        require(w.remove(gone));
        require(w.remove(held));
        ASSERT_TRUE(w.compact());
        step(w, 1);
        s.name = "new";
        s.held_until = 0;
        s.shape = Shape::box({0.1, 0.8, 0.1}, {0.4, 1.1, 0.4});
        EXPECT_EQ(w.add_solid(s)->index, 0u);
        step(w, 5);
      }
      worlds.push_back(std::move(w));
    }
    take(worlds[1], worlds[0]);
    expect_same(worlds[0], worlds[1]);
    EXPECT_EQ(worlds[0].resolved().heat_stages, worlds[1].resolved().heat_stages);
    for (World& w : worlds) step(w, 5);
    expect_same(worlds[0], worlds[1]);
  }
}

/// Nothing in it but a material whose modulus is out of reach.
Scene make_stiff() {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = 0.2;
  d.gravity = {};
  d.domain.bounded = true;
  d.domain.max = {2.4, 2.4, 2.4};
  d.reserved_particles = 600;
  Scene s{*World::create(d), {}, {}};
  MaterialDesc stiff;
  stiff.youngs_modulus = 1e7;
  s.ice = *s.world.add_material(stiff);
  return s;
}

// Bodies that come while the World runs make its sub-steps shorter. What regions can give of a modulus is as it was then, to the last bit, as in a
// World that begins with all of them.
TEST(SavedWorld, AModulusOutOfReachIsThatOfTheWorldThatGoesOn) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = make_stiff();
  SolidDesc body;
  body.material = a.ice;
  for (int k = 0; k < 16; ++k) {
    SCOPED_TRACE(k);
    const Vec3d low{0.6 * (k % 4), 0.6 * (k / 4), 0.6 * (k % 3)};
    body.shape = Shape::box(low, low + Vec3d{0.4, 0.4, 0.4});
    body.velocity = {0, 0, 0.01 * (k + 1)};
    body.angular_velocity = {0, 0.05, 0};
    require(a.world.add_solid(body));
    step(a.world, 1);
    Scene b = make_stiff();
    take(b.world, a.world);
    for (Scene* s : {&a, &b}) step(s->world, 1);
    EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  }
  EXPECT_LE(a.world.plan().uploads, 4u);  // the others came in place
  EXPECT_TRUE(a.world.synchronize().modulus_unreachable);
}

TEST(SavedWorld, RefusesOtherEmitters) {
  MELTSIM_NEEDS_BACKEND();
  const auto with = [](const std::function<void(EmitterDesc&)>& change) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    Scene s{*World::create(d), {}, {}};
    EmitterDesc e;
    e.name = "tap";
    e.material = *s.world.add_material({});
    e.radius = 0.2;
    e.until = 1;
    change(e);
    require(s.world.add_emitter(e));
    step(s.world, 1);
    return s;
  };
  const auto bytes = with([](EmitterDesc&) {}).world.save();
  ASSERT_TRUE(bytes);
  const std::vector<std::function<void(EmitterDesc&)>> others = {
      [](EmitterDesc& e) { e.radius = 0.3; },
      [](EmitterDesc& e) {
        e.axis = {1, -1, 0};
      },
      [](EmitterDesc& e) { e.until = 2; }, [](EmitterDesc& e) { e.max_particles = 1000; }};
  for (const auto& change : others) {
    Scene s = with(change);
    expect_refused(s, *bytes, ErrorCode::invalid_argument, "emitter \"tap\"");
  }
  // Where it is, how fast and how warm, is part of the state.
  Scene same = with([](EmitterDesc& e) {
    e.center = {1, 1, 1};
    e.speed = 2;
    e.temperature = 50;
  });
  require(same.world.load_saved(bytes->data(), bytes->size()));
}

}  // namespace
}  // namespace meltsim_test
