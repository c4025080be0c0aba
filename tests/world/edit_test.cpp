// SPDX-License-Identifier: Apache-2.0
// Adding and taking out while the World runs: on the backend, where particles are, as long as there is room in reserve. Held
// to what an upload comes to, to the bit: a World that was restored from its own snapshot holds its state on the host, so that
// the same calls take that way.
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

FluidDesc liquid(MaterialId material, const Shape& shape, double temperature) {
  FluidDesc f;
  f.material = material;
  f.shape = shape;
  f.temperature = temperature;
  f.velocity = {0.1, -0.5, 0};
  return f;
}

/// A material by its index, for a World and its twin.
MaterialId of_any_world(MaterialId id) { return {id.index, 1}; }

/// A World and its twin, to which the host does the same; the twin goes through the host's memory each time.
struct Twins {
  Scene scene, twin;
  bool same() {
    const auto a = scene.world.particles(), b = twin.world.particles();
    if (!a || !b) return false;
    bool equal = a->id == b->id && a->tag == b->tag && a->temperature == b->temperature;
    for (std::size_t i = 0; equal && i < a->position.size(); ++i)
      equal = a->position[i].x == b->position[i].x && a->position[i].y == b->position[i].y &&
              a->position[i].z == b->position[i].z && a->velocity[i].y == b->velocity[i].y;
    return equal && *scene.world.state_hash() == *twin.world.state_hash();
  }
  void step(int n) {
    for (int k = 0; k < n; ++k) {
      require(scene.world.step(0.01));
      require(twin.world.step(0.01));
    }
  }
  /// What both calls return has to be the same, and then all else.
  template <class Call>
  auto both(const Call& call) {
    const auto bytes = twin.world.snapshot();
    EXPECT_TRUE(bytes) << bytes.error().message;
    require(twin.world.restore(bytes->data(), bytes->size()));
    auto a = call(scene), b = call(twin);
    EXPECT_EQ(bool(a), bool(b));
    if (!a && !b) {
      EXPECT_EQ(a.error().message, b.error().message);
    }
    return std::make_pair(std::move(a), std::move(b));
  }
};

struct Case {
  const char* name;
  std::function<void(WorldDesc&, IceScene&)> change;
};

/// A tank with ice above water; its particles are few enough that each search and both precisions take a moment.
Twins make(const Case& c) {
  WorldDesc d = describe();
  IceScene s;
  d.reserved_particles = 600;
  c.change(d, s);
  Twins t{ice_in_water(d, s), ice_in_water(d, s)};
  return t;
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"single", [](WorldDesc&, IceScene&) {}},
      {"double", [](WorldDesc& d, IceScene&) { d.precision = Precision::double_precision; }},
      {"tree", [](WorldDesc& d, IceScene&) { d.neighbour_search = NeighbourSearch::tree; }},
      {"freezing",
       [](WorldDesc&, IceScene& s) {
         s.freezes = true;
         s.growth = 2;
         s.water_temperature = 1;
         s.ice_temperature = -40;
       }},
      {"rigid", [](WorldDesc&, IceScene& s) { s.motion = Motion::rigid; }},
      {"no heat", [](WorldDesc& d, IceScene&) { d.heat.model = HeatModel::none; }},
      {"level", [](WorldDesc&, IceScene& s) { s.ice_temperature = s.water_temperature = -5; }},
      {"follows sound", [](WorldDesc& d, IceScene&) { d.follow_sound_speed = true; }},
  };
  return all;
}

TEST(Edits, InPlaceAreThoseOfAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    Twins t = make(c);
    for (World* w : {&t.scene.world, &t.twin.world}) require(w->watch_events());
    t.step(3);
    ASSERT_TRUE(t.same());
    const std::uint64_t uploads = t.scene.world.plan().uploads;
    // Beside the block, reaching into the water: some points are taken.
    const auto pour = [](Scene& s) {
      return s.world.add_fluid(liquid(s.water, Shape::box({0.2, 0.6, 0.2}, {0.8, 1.8, 0.8}), 30));
    };
    const auto poured = t.both(pour);
    ASSERT_TRUE(poured.first) << poured.first.error().message;
    EXPECT_EQ(*poured.first, *poured.second);
    EXPECT_GT(*poured.first, 0u);
    EXPECT_LT(*poured.first, 3u * 6u * 3u);
    EXPECT_TRUE(t.same());
    // What was added is found, too, ahead of any sub-step.
    EXPECT_FALSE(t.both(pour).first);
    const auto drain = [](Scene& s) { return s.world.remove_liquid(Shape::sphere({0.5, 1.2, 0.5}, 0.35)); };
    const auto drained = t.both(drain);
    ASSERT_TRUE(drained.first) << drained.first.error().message;
    EXPECT_GT(*drained.first, 0u);
    EXPECT_EQ(*drained.first, *drained.second);
    EXPECT_TRUE(t.same());
    const auto again = t.both(drain);
    EXPECT_EQ(*again.first, 0u);
    t.step(4);
    EXPECT_TRUE(t.same());
    EXPECT_GT(*t.both(pour).first, 0u);  // now found by cells
    t.step(2);
    EXPECT_TRUE(t.same());
    EXPECT_GT(*t.both([](Scene& s) {
                  return s.world.remove_liquid(Shape::box({-9, -9, -9}, {1, 0.5, 9}));
                }).first,
              0u);
    t.step(2);
    EXPECT_TRUE(t.same());
    const StepResult a = t.scene.world.synchronize(), b = t.twin.world.synchronize();
    EXPECT_EQ(a.fluid, b.fluid);
    EXPECT_EQ(a.solid, b.solid);
    EXPECT_EQ(a.removed, b.removed);
    EXPECT_EQ(a.melted, b.melted);
    const auto seen = t.scene.world.take_events(), too = t.twin.world.take_events();
    ASSERT_TRUE(seen && too);
    // What went through restore() has dropped the events before.
    EXPECT_LE(too->events.size(), seen->events.size());
    EXPECT_EQ(t.scene.world.plan().uploads, uploads);
    EXPECT_GT(t.twin.world.plan().uploads, uploads);
  }
}

TEST(Edits, RemovedBodiesAreThoseOfAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    Twins t = make(c);
    // Others beside it stay as they are.
    const auto beside = [](Scene& s) {
      SolidDesc d;
      d.name = "beside";
      d.material = s.ice;
      d.shape = Shape::box({0.2, 1.2, 0.2}, {0.8, 1.8, 0.8});
      d.temperature = -5;
      return s.world.add_solid(d);
    };
    const auto stone = t.both(beside);
    ASSERT_TRUE(stone.first) << stone.first.error().message;
    t.step(12);
    ASSERT_TRUE(t.same());
    const std::uint64_t uploads = t.scene.world.plan().uploads;
    const auto melt_off = t.scene.world.synchronize().solid;
    const auto pieces = t.scene.world.pieces();
    ASSERT_TRUE(pieces);
    BodyId first;
    for (const PieceInfo& p : *pieces)
      if (!(p.body == *stone.first)) first = p.body;
    int call = 0;
    const auto gone = t.both([&](Scene& s) {
      const BodyId here = call++ == 0 ? first : BodyId{first.index, stone.second->generation};
      return s.world.remove(here);
    });
    ASSERT_TRUE(gone.first) << gone.first.error().message;
    EXPECT_TRUE(t.same());
    EXPECT_LT(t.scene.world.synchronize().solid, melt_off);
    EXPECT_EQ(t.scene.world.synchronize().removed, t.twin.world.synchronize().removed);
    // Twice is refused, and changes nothing.
    const Status twice = t.scene.world.remove(first);
    ASSERT_FALSE(twice);
    EXPECT_NE(twice.error().message.find("was removed"), std::string::npos);
    SurfaceDesc surface;
    surface.of = SurfaceOf::body;
    surface.body = first;
    EXPECT_NE(t.scene.world.surface(surface).error().message.find("was removed"), std::string::npos);
    ProbeDesc probe;
    probe.kind = ProbeKind::force;
    probe.body = first;
    probe.fields = {"force"};
    EXPECT_NE(t.scene.world.add_probe(probe).error().message.find("was removed"), std::string::npos);
    t.step(4);
    EXPECT_TRUE(t.same());
    ASSERT_TRUE(t.scene.world.remove(*stone.first));
    ASSERT_TRUE(t.twin.world.remove(*stone.second));
    t.step(4);
    EXPECT_TRUE(t.same());
    EXPECT_EQ(t.scene.world.synchronize().solid, 0u);
    EXPECT_EQ(t.scene.world.plan().uploads, uploads);
  }
}

struct BodyCase {
  const char* name;
  Case scene;
  std::function<void(SolidDesc&)> change;
};

const std::vector<BodyCase>& body_cases() {
  const auto same = [](WorldDesc&, IceScene&) {};
  static const std::vector<BodyCase> all = {
      {"free", {"", same}, [](SolidDesc&) {}},
      {"double",
       {"", [](WorldDesc& d, IceScene&) { d.precision = Precision::double_precision; }},
       [](SolidDesc&) {}},
      {"tree",
       {"", [](WorldDesc& d, IceScene&) { d.neighbour_search = NeighbourSearch::tree; }},
       [](SolidDesc&) {}},
      {"rigid, the only one of its kind", {"", same}, [](SolidDesc& s) { s.motion = Motion::rigid; }},
      {"rigid",
       {"", [](WorldDesc&, IceScene& s) { s.motion = Motion::rigid; }},
       [](SolidDesc& s) { s.motion = Motion::rigid; }},
      {"fixed", {"", same}, [](SolidDesc& s) { s.motion = Motion::fixed; }},
      {"free beside a fixed one", {"", [](WorldDesc&, IceScene& s) { s.fixed = true; }}, [](SolidDesc&) {}},
      {"kinematic", {"", same}, [](SolidDesc& s) { s.motion = Motion::kinematic; }},
      {"proxy",
       {"", same},
       [](SolidDesc& s) {
         s.motion = Motion::proxy;
         s.mass = 200;
       }},
      {"held", {"", same}, [](SolidDesc& s) { s.held_until = 0.06; }},
      {"heated", {"", same}, [](SolidDesc& s) { s.heat_source = 1e5; }},
      {"freezing",
       {"",
        [](WorldDesc&, IceScene& s) {
          s.freezes = true;
          s.growth = 2;
          s.water_temperature = 1;
          s.ice_temperature = -40;
        }},
       [](SolidDesc& s) {
         s.growth = 2;
         s.temperature = -40;
       }},
      {"no heat", {"", [](WorldDesc& d, IceScene&) { d.heat.model = HeatModel::none; }}, [](SolidDesc&) {}},
      {"level",
       {"", [](WorldDesc&, IceScene& s) { s.ice_temperature = s.water_temperature = -5; }},
       [](SolidDesc&) {}},
      {"level until it comes",
       {"", [](WorldDesc&, IceScene& s) { s.ice_temperature = s.water_temperature = -5; }},
       [](SolidDesc& s) { s.temperature = -20; }},
      {"follows sound",
       {"", [](WorldDesc& d, IceScene&) { d.follow_sound_speed = true; }},
       [](SolidDesc&) {}},
      {"the first body", {"", [](WorldDesc&, IceScene& s) { s.block = 0; }}, [](SolidDesc&) {}},
      {"two pieces",
       {"", same},
       [](SolidDesc& s) {
         s.shape = Shape::unite(
             {Shape::box({0.2, 1.2, 0.2}, {0.6, 1.8, 0.4}), Shape::box({0.2, 1.2, 1.8}, {0.6, 1.8, 2.2})});
       }},
  };
  return all;
}

// Twice: the second one finds plan and recorded sub-steps as they are. Then the first one is taken out again.
TEST(Edits, AddedBodiesAreThoseOfAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  for (const BodyCase& c : body_cases()) {
    SCOPED_TRACE(c.name);
    Twins t = make(c.scene);
    for (World* w : {&t.scene.world, &t.twin.world}) require(w->watch_events());
    t.step(3);
    ASSERT_TRUE(t.same());
    const std::uint64_t uploads = t.scene.world.plan().uploads;
    double along = 0;
    const auto drop = [&](Scene& s) {
      SolidDesc d;
      d.material = s.ice;
      d.shape = Shape::box({0.2, 0.8, 0.2}, {0.8, 1.4, 0.8});  // its foot displaces water
      d.temperature = -5;
      c.change(d);
      if (d.motion == Motion::proxy) d.material = s.water;  // does not melt
      if (d.motion == Motion::free) d.velocity = {0.1, -0.2, 0};
      d.shape = d.shape.transformed({along, 0, 0});
      return s.world.add_solid(d);
    };
    const auto first = t.both(drop);
    ASSERT_TRUE(first.first) << first.first.error().message;
    EXPECT_TRUE(t.same());
    const auto there = t.both(drop);  // found ahead of any sub-step
    ASSERT_FALSE(there.first);
    EXPECT_NE(there.first.error().message.find("overlaps body"), std::string::npos);
    t.step(4);
    EXPECT_TRUE(t.same());
    along = 1.4;
    const auto second = t.both(drop);
    ASSERT_TRUE(second.first) << second.first.error().message;
    t.step(4);
    EXPECT_TRUE(t.same());
    const auto pieces = t.scene.world.pieces(), too = t.twin.world.pieces();
    ASSERT_TRUE(pieces && too);
    ASSERT_EQ(pieces->size(), too->size());
    for (std::size_t k = 0; k < pieces->size(); ++k) {
      EXPECT_EQ((*pieces)[k].particles, (*too)[k].particles);
      EXPECT_EQ((*pieces)[k].center.x, (*too)[k].center.x);
      EXPECT_EQ((*pieces)[k].bounds.min.x, (*too)[k].bounds.min.x);
      EXPECT_EQ((*pieces)[k].body.index, (*too)[k].body.index);
    }
    int call = 0;
    ASSERT_TRUE(
        t.both([&](Scene& s) { return s.world.remove(call++ == 0 ? *first.first : *first.second); }).first);
    t.step(2);
    EXPECT_TRUE(t.same());
    const StepResult a = t.scene.world.synchronize(), b = t.twin.world.synchronize();
    EXPECT_EQ(a.fluid, b.fluid);
    EXPECT_EQ(a.solid, b.solid);
    EXPECT_EQ(a.removed, b.removed);
    EXPECT_EQ(a.melted, b.melted);
    EXPECT_EQ(a.frozen, b.frozen);
    EXPECT_EQ(t.scene.world.plan().uploads, uploads);
    EXPECT_GT(t.twin.world.plan().uploads, uploads);
  }
}

// Of what a GPU has recorded nothing is dropped, nor recorded anew, for a body like one that has come before: neither its material, nor
// its size, nor the digits of sums (152 and 179 vertices: they go by powers of 2), nor the eighths of the room that kernels run
// over (each 1,000 and more) are new. A CPU records nothing: there, both numbers are 0.
TEST(Edits, ABodyLikeAnotherCostsNoGraph) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.reserved_particles = 8000;
  IceScene as;
  as.depth = 0.2;
  as.box = 4;
  as.block = 5;
  Scene s = ice_in_water(d, as);
  const auto cube = [&](double x) {
    SolidDesc c;
    c.material = s.ice;
    c.shape = Shape::box({x, 1.6, 0.2}, {x + 0.6, 2.2, 0.8});
    c.temperature = as.ice_temperature;
    return s.world.add_solid(c);
  };
  const auto step = [&](int n) {
    for (int k = 0; k < n; ++k) require(s.world.step(0.002));
  };
  step(40);  // with a search for pieces, which comes every 16 sub-steps
  require(cube(2.2));
  step(40);
  const std::uint64_t graphs = s.world.plan().graphs, uploads = s.world.plan().uploads;
  EXPECT_EQ(graphs > 0, backend() == Backend::cuda);
  require(cube(3.2));
  require(s.world.prepare());
  EXPECT_EQ(s.world.plan().graphs, graphs);  // 0 if they were dropped
  step(40);
  EXPECT_EQ(s.world.plan().graphs, graphs);
  EXPECT_EQ(s.world.plan().uploads, uploads);
}

// What a scene has beside particles comes and goes with a new plan.
TEST(Edits, WhatIsAddedBesideParticlesIsThatOfAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    Twins t = make(c);
    t.step(2);
    const std::uint64_t uploads = t.scene.world.plan().uploads;
    if (c.name != std::string("no heat")) {
      const auto region = t.both([](Scene& s) {
        HeatRegionDesc r;
        r.shape = Shape::box({0, 0, 0}, {1, 1, 1});
        r.source = 1e6;
        r.from = 0.025;  // within the second step from now
        return s.world.add_heat_region(r);
      });
      ASSERT_TRUE(region.first) << region.first.error().message;
      t.step(2);
      EXPECT_TRUE(t.same());
    }
    MaterialId oil, wax;
    const auto liquid_too = t.both([&](Scene& s) {
      MaterialDesc m;
      m.name = "oil";
      m.density = 900;
      m.viscosity = 0.1;
      auto id = s.world.add_material(m);
      if (id) oil = of_any_world(*id);
      return id;
    });
    ASSERT_TRUE(liquid_too.first);
    const auto solid_too = t.both([&](Scene& s) {
      MaterialDesc m;
      m.name = "wax";
      m.density = 850;
      m.melting_point = 50;
      m.latent_heat = 2e5;
      m.melts_into = oil;
      m.conductivity_points = {{0, 0.3}, {100, 0.2}};
      auto id = s.world.add_material(m);
      if (id) wax = of_any_world(*id);
      return id;
    });
    ASSERT_TRUE(solid_too.first) << solid_too.first.error().message;
    EXPECT_TRUE(t.same());
    ASSERT_TRUE(t.both([&](Scene& s) {
                   return s.world.add_fluid(liquid(oil, Shape::box({1.2, 2.0, 0.4}, {1.6, 2.2, 2.2}), 20));
                 }).first);
    const auto tap = t.both([&](Scene& s) {
      EmitterDesc e;
      e.material = oil;
      e.center = {0.6, 2.0, 0.6};
      e.radius = 0.3;
      e.speed = 2;
      e.temperature = 60;
      e.max_particles = 60;
      return s.world.add_emitter(e);
    });
    ASSERT_TRUE(tap.first) << tap.first.error().message;
    const auto candle = t.both([&](Scene& s) {
      SolidDesc d;
      d.material = wax;
      d.shape = Shape::box({1.8, 1.2, 1.8}, {2.2, 1.8, 2.2});
      d.temperature = 20;
      return s.world.add_solid(d);
    });
    ASSERT_TRUE(candle.first) << candle.first.error().message;
    // Too near to that: refused by both, with one text.
    EXPECT_FALSE(t.both([&](Scene& s) {
                    EmitterDesc e;
                    e.material = oil;
                    e.center = {2, 1.6, 2};
                    e.radius = 0.1;
                    return s.world.add_emitter(e);
                  }).first);
    t.step(3);
    EXPECT_TRUE(t.same());
    EXPECT_EQ(t.scene.world.plan().uploads, uploads);
  }
}

// Where something is dissolved already, what comes with contents of its own joins it; what was in no liquid before takes channels
// that an upload makes.
TEST(Edits, InSolutionsAreThoseOfAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.reserved_particles = 600;
  d.solute.time_scale = 1e4;
  MaterialId salt;
  const auto make_one = [&] {
    Scene s = ice_in_water(d, {});
    MaterialDesc m;
    m.name = "salt";
    m.density = 2170;
    m.dissolves_in = s.water;
    m.solubility = 0.26;
    m.diffusivity_in = 1.5e-9;
    salt = of_any_world(*s.world.add_material(m));
    return s;
  };
  Twins t{make_one(), make_one()};
  t.step(1);
  const auto pour = [&](Scene& s) {
    FluidDesc f = liquid(s.water, Shape::box({0.2, 2.0, 0.4}, {0.6, 2.2, 2.2}), 80);
    f.fractions = {{salt, 0.1}};
    return s.world.add_fluid(f);
  };
  std::uint64_t uploads = t.scene.world.plan().uploads;
  ASSERT_TRUE(t.both(pour).first);
  t.step(2);
  EXPECT_TRUE(t.same());
  EXPECT_EQ(t.scene.world.plan().uploads, uploads + 1);
  const auto beside = [&](Scene& s) {
    FluidDesc f = liquid(s.water, Shape::box({1.8, 2.0, 0.4}, {2.2, 2.2, 2.2}), 80);
    f.fractions = {{salt, 0.2}};
    return s.world.add_fluid(f);
  };
  ASSERT_TRUE(t.both(beside).first);
  EXPECT_TRUE(t.same());
  t.step(2);
  EXPECT_TRUE(t.same());
  ASSERT_TRUE(t.both([&](Scene& s) {
                 SolidDesc lump;
                 lump.material = salt;
                 lump.shape = Shape::box({0.2, 0.6, 0.2}, {0.8, 1.2, 0.8});
                 lump.temperature = 20;
                 return s.world.add_solid(lump);
               }).first);
  t.step(2);
  EXPECT_TRUE(t.same());
  ASSERT_TRUE(t.both([&](Scene& s) {
                 return s.world.remove_liquid(Shape::box({1.6, 1.8, 0}, {2.4, 2.4, 2.4}));
               }).first);
  t.step(2);
  EXPECT_TRUE(t.same());
  EXPECT_EQ(t.scene.world.plan().uploads, uploads + 1);
}

// Liquid that holds the same everywhere exchanges nothing, and its plan has no stage for it; what comes with other contents makes that
// one: liquid, a nozzle's, a body.
TEST(Edits, WhatComesIntoALevelSolutionIsExchangedAsAfterAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.gravity = {0, 0, 0};
  d.reserved_particles = 600;
  d.solute.time_scale = 1e6;
  d.heat.model = HeatModel::none;
  MaterialId salt;
  const auto make_one = [&] {
    World w = *World::create(d);
    MaterialDesc m;
    const MaterialId water = *w.add_material(m);
    m.name = "salt";
    m.density = 2170;
    m.dissolves_in = water;
    m.solubility = 0.26;
    m.diffusivity_in = 1.5e-9;
    salt = of_any_world(*w.add_material(m));
    FluidDesc f = liquid(water, Shape::box({0, 0, 0}, {0.8, 0.4, 0.8}), 20);
    f.velocity = {};
    f.fractions = {{salt, 0.1}};
    require(w.add_fluid(f));
    return Scene{std::move(w), water, {}};
  };
  const auto exchanges = [](Scene& s) {
    for (const StageReport& stage : s.world.plan().stages)
      if (stage.name == "species.exchange") return stage.runs;
    return false;
  };
  const std::vector<std::pair<const char*, std::function<bool(Scene&)>>> ways = {
      {"liquid",
       [&](Scene& s) {
         FluidDesc f = liquid(s.water, Shape::box({0, 0.4, 0}, {0.4, 0.6, 0.8}), 20);
         f.fractions = {{salt, 0.2}};
         return bool(s.world.add_fluid(f));
       }},
      {"nozzle",
       [&](Scene& s) {
         EmitterDesc e;
         e.material = s.water;
         e.center = {0.4, 0.5, 0.4};
         e.radius = 0.15;
         e.axis = {0, -1, 0};
         e.speed = 2;
         e.max_particles = 60;
         e.temperature = 20;
         e.fractions = {{salt, 0.2}};
         return bool(s.world.add_emitter(e));
       }},
      {"body", [&](Scene& s) {
         SolidDesc lump;
         lump.material = salt;
         lump.shape = Shape::box({0.2, 0.2, 0.2}, {0.5, 0.5, 0.5});
         return bool(s.world.add_solid(lump));
       }}};
  for (const auto& way : ways) {
    SCOPED_TRACE(way.first);
    Twins t{make_one(), make_one()};
    t.step(2);
    EXPECT_FALSE(exchanges(t.scene));
    const std::uint64_t uploads = t.scene.world.plan().uploads;
    const auto add = [&](Scene& s) -> Status {
      return way.second(s) ? Status{} : Status{Error{ErrorCode::internal, "refused"}};
    };
    ASSERT_TRUE(t.both(add).first);
    t.step(20);  // a nozzle's liquid takes as long to get there
    EXPECT_TRUE(exchanges(t.scene));
    EXPECT_TRUE(t.same());
    const auto shares = t.scene.world.particles()->fractions.front();
    EXPECT_TRUE(std::any_of(shares.begin(), shares.end(), [](double w) { return w > 0.1001 && w < 0.1999; }));
    EXPECT_EQ(t.scene.world.plan().uploads, uploads);
  }
}

// Pieces of one body touch each other, also where it is the only one, and came without an upload.
// The plan of a World in which nothing can move has no room for pushes; the first body that can is pushed ahead of the next step.
TEST(Edits, TheFirstBodyThatCanMoveIsPushedAheadOfAStep) {
  MELTSIM_NEEDS_BACKEND();
  Twins t = make({"", [](WorldDesc& d, IceScene& s) {
                    d.heat.model = HeatModel::none;
                    s.fixed = true;
                  }});
  t.step(2);
  const std::uint64_t uploads = t.scene.world.plan().uploads;
  const auto cube = [](Scene& s) {
    SolidDesc d;
    d.material = s.ice;
    d.shape = Shape::box({0.4, 1.8, 0.4}, {0.8, 2.2, 0.8});
    return s.world.add_solid(d);
  };
  const auto added = t.both(cube);
  ASSERT_TRUE(added.first);
  const double speed = 0.5;
  require(t.scene.world.set_velocity(*added.first, {speed, 0, 0}));
  require(t.twin.world.set_velocity(*added.second, {speed, 0, 0}));
  EXPECT_TRUE(t.same());
  EXPECT_NEAR(t.scene.world.pieces()->back().velocity.x, speed, 1e-6);
  t.step(5);
  EXPECT_TRUE(t.same());
  EXPECT_EQ(t.scene.world.plan().uploads, uploads);
}

TEST(Edits, PiecesOfTheOnlyBodyTouchAsAfterAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  Twins t = make({"", [](WorldDesc& d, IceScene& s) {
                    d.heat.model = HeatModel::none;
                    s.block = 0;
                  }});
  t.step(2);
  const std::uint64_t uploads = t.scene.world.plan().uploads;
  const auto plates = [](Scene& s) {
    SolidDesc d;
    d.material = s.ice;
    d.shape = Shape::unite(
        {Shape::box({0.4, 1.0, 0.4}, {1.4, 1.2, 1.4}), Shape::box({0.6, 1.6, 0.6}, {1.2, 2.2, 1.2})});
    return s.world.add_solid(d);
  };
  ASSERT_TRUE(t.both(plates).first);
  t.step(1);
  const auto contact = [](Scene& s) {
    for (const StageReport& stage : s.world.plan().stages)
      if (stage.name == "lsm.contact") return stage.runs;
    return false;
  };
  EXPECT_TRUE(contact(t.scene));
  t.step(60);  // the upper one falls onto the lower one, which floats
  EXPECT_TRUE(t.same());
  const auto pieces = t.scene.world.pieces();
  ASSERT_EQ(pieces->size(), 2u);
  EXPECT_GT((*pieces)[1].bounds.min.y, (*pieces)[0].bounds.max.y);
  EXPECT_EQ(t.scene.world.plan().uploads, uploads);
}

// A body that is held or watched stays where it is on the backend.
TEST(Edits, HeldAndWatchedBodiesAreThoseOfAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  for (const Motion motion : {Motion::free, Motion::rigid}) {
    SCOPED_TRACE(motion == Motion::free ? "free" : "rigid");
    Twins t = make({"", [&](WorldDesc&, IceScene& s) { s.motion = motion; }});
    for (World* w : {&t.scene.world, &t.twin.world}) require(w->watch_events());
    // Another one that moves, so that the backend keeps what is of such bodies.
    for (Scene* scene : {&t.scene, &t.twin}) {
      SolidDesc d;
      d.material = scene->ice;
      d.shape = Shape::box({0.2, 1.8, 0.2}, {0.6, 2.2, 0.6});
      d.motion = motion;
      require(scene->world.add_solid(d));
    }
    t.step(3);
    const std::uint64_t uploads = t.scene.world.plan().uploads;
    const BodyId first = t.scene.world.pieces()->front().body;
    int call = 0;
    // Asked of the twin beforehand: a reading would upload it, and it would take the way of the other.
    const BodyId second{first.index, t.twin.world.pieces()->front().body.generation};
    const auto body = [&](Scene&) { return call++ % 2 == 0 ? first : second; };
    const auto turn = [&](Scene& s) { return s.world.apply_impulse(body(s), {10, 0, 0}, {0, 2, 5}); };
    ASSERT_TRUE(t.both(turn).first);
    t.step(1);
    for (const bool on : {true, false, true}) {
      ASSERT_TRUE(t.both([&](Scene& s) { return s.world.watch_forces(body(s), on); }).first);
      // Ahead of any step, too: nothing has acted on it since.
      for (World* w : {&t.scene.world, &t.twin.world}) {
        const auto now = w->take_forces();
        ASSERT_TRUE(now);
        ASSERT_EQ(now->size(), on ? 1u : 0u);
        EXPECT_TRUE(!on || now->front().seconds == 0);
      }
      t.step(1);
      ASSERT_TRUE(t.both([&](Scene& s) { return s.world.hold(body(s), on); }).first);
      EXPECT_TRUE(t.same());
      t.step(2);
      EXPECT_TRUE(t.same());
    }
    const auto forces = t.scene.world.take_forces(), too = t.twin.world.take_forces();
    ASSERT_TRUE(forces && too);
    ASSERT_EQ(forces->size(), 1u);
    ASSERT_EQ(too->size(), 1u);
    EXPECT_GT(forces->front().seconds, 0);
    EXPECT_EQ(t.scene.world.plan().uploads, uploads);
    EXPECT_GE(t.twin.world.plan().uploads, uploads + 7);
  }
}

// A body that its description holds is let go with the velocities that it has there: by the step that it is due in, on the backend, and
// through the host, where the World was restored before that step.
TEST(Edits, BodiesThatAreDueAreLetGoAsAfterAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  for (const Motion motion : {Motion::free, Motion::rigid}) {
    SCOPED_TRACE(motion == Motion::free ? "free" : "rigid");
    Twins t = make({"", [](WorldDesc& d, IceScene&) { d.heat.model = HeatModel::none; }});
    t.step(1);
    const auto held = [motion](Scene& s) {
      SolidDesc d;
      d.material = s.ice;
      d.shape = Shape::box({0.2, 1.6, 0.2}, {0.8, 2.0, 0.6});
      d.motion = motion;
      d.velocity = {1, 0, 0};
      d.angular_velocity = {0, 0, 2};
      d.held_until = 0.035;
      return s.world.add_solid(d);
    };
    const auto body = t.both(held);
    ASSERT_TRUE(body.first);
    t.step(3);  // the next one lets it go
    const std::uint64_t uploads = t.scene.world.plan().uploads;
    ASSERT_TRUE(t.both([](Scene&) { return Status{}; }).first);
    t.step(1);
    EXPECT_TRUE(t.same());
    EXPECT_EQ(t.scene.world.plan().uploads, uploads);
    for (const PieceInfo& p : *t.scene.world.pieces()) {
      if (!(p.body == *body.first)) continue;
      EXPECT_NEAR(p.velocity.x, 1, 0.01);
      EXPECT_NEAR(p.angular_velocity.z, 2, 0.02);
      EXPECT_NEAR(p.velocity.y, -9.81 * 0.01, 0.01);
    }
  }
}

// The first liquid of a World, and its first body, have a surface at once.
TEST(Edits, TheFirstLiquidAndBodyHaveSurfacesAheadOfAStep) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool wet : {false, true}) {
    SCOPED_TRACE(wet ? "a body beside liquid" : "liquid beside a body");
    Twins t = make({"", [wet](WorldDesc& d, IceScene& s) {
                      d.heat.model = HeatModel::none;
                      s.water = wet;
                      if (wet) s.block = 0;
                    }});
    t.step(2);
    const std::uint64_t uploads = t.scene.world.plan().uploads;
    const auto add = [wet](Scene& s) -> Status {
      const Shape where = Shape::box({0.2, 1.6, 0.2}, {0.8, 2.2, 0.8});
      SolidDesc d;
      d.material = s.ice;
      d.shape = where;
      if (!wet) require(s.world.add_fluid(liquid(s.water, where, 20)));
      else require(s.world.add_solid(d));
      return {};
    };
    ASSERT_TRUE(t.both(add).first);
    SurfaceDesc of;
    of.of = wet ? SurfaceOf::solids : SurfaceOf::liquid;
    const auto a = t.scene.world.surface(of), b = t.twin.world.surface(of);
    ASSERT_TRUE(a && b);
    EXPECT_GT(a->position.size(), 100u);
    EXPECT_EQ(a->position.size(), b->position.size());
    EXPECT_EQ(t.scene.world.plan().uploads, uploads);
    t.step(3);
    EXPECT_TRUE(t.same());
  }
}

// What has come from a nozzle and fallen since was not added, whichever way something else is: the sound speed does not follow it.
TEST(Edits, WhatNozzlesBroughtIsSeenByNoUpload) {
  MELTSIM_NEEDS_BACKEND();
  double sound[2] = {0, 0};
  std::uint64_t hash[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.reserved_particles = k == 0 ? 0 : 600;
    World w = *World::create(d);
    const MaterialId water = *w.add_material({});
    EmitterDesc e;
    e.material = water;
    e.radius = 0.15;
    e.max_particles = 100;
    require(w.add_emitter(e));
    for (int step = 0; step < 50; ++step) require(w.step(0.01));  // falls at 5 m/s then
    FluidDesc f;
    f.material = water;
    f.shape = Shape::box({2, 0, 2}, {2.3, 0.3, 2.3});
    require(w.add_fluid(f));
    require(w.step(0.01));
    EXPECT_EQ(w.plan().uploads, k == 0 ? 2u : 1u);
    sound[k] = w.resolved().sound_speed;
    hash[k] = *w.state_hash();
  }
  EXPECT_EQ(sound[0], sound[1]);
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(Edits, RoomThatRunsOutIsMadeAnew) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.reserved_particles = 40;
  Twins t{ice_in_water(d, {}), ice_in_water(d, {})};
  t.step(1);
  const std::uint64_t uploads = t.scene.world.plan().uploads;
  std::uint64_t added = 0;
  for (int k = 0; k < 6; ++k) {
    const double x = 0.2 + 0.2 * k;
    const auto n = t.both([x](Scene& s) {
      return s.world.add_fluid(liquid(s.water, Shape::box({x, 2.0, 0.4}, {x + 0.2, 2.2, 2.2}), 80));
    });
    ASSERT_TRUE(n.first) << n.first.error().message;
    EXPECT_EQ(*n.first, 9u);  // a row along z
    added += *n.first;
    EXPECT_TRUE(t.same());
    t.step(1);
    EXPECT_TRUE(t.same());
  }
  EXPECT_EQ(added, 54u);  // more than 40: once, room was made
  EXPECT_EQ(t.scene.world.plan().uploads, uploads + 1);
}

TEST(Edits, MaterialsChangeWithoutAnUpload) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  Twins t{ice_in_water(d, {}), ice_in_water(d, {})};
  t.step(3);
  const std::uint64_t uploads = t.scene.world.plan().uploads;
  MaterialDesc thick = t.scene.world.material(t.scene.water);
  thick.viscosity = 0.5;
  thick.conductivity = 2;
  MaterialDesc hard = t.scene.world.material(t.scene.ice);
  hard.melts_into = of_any_world(hard.melts_into);
  hard.friction = 0.7;
  hard.damping = 0.2;
  t.both([&](Scene& s) { return s.world.set_material(s.water, thick); });
  t.both([&](Scene& s) { return s.world.set_material(s.ice, hard); });
  t.step(4);
  EXPECT_TRUE(t.same());
  EXPECT_EQ(t.scene.world.plan().uploads, uploads);
  EXPECT_EQ(t.scene.world.material(t.scene.water).viscosity, 0.5);
}

// The stiffness that a modulus takes goes up where a body is shorter, and with it the least damping of its material: the tables
// have to follow. Two sites beside three; a damping of 0, so that the least one holds.
TEST(Edits, AShorterBodyWithAModulusIsThatOfAnUploadToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  Twins t = make({"", [](WorldDesc&, IceScene&) {}});
  MaterialDesc soft = t.scene.world.material(t.scene.ice);
  soft.melts_into = of_any_world(soft.melts_into);
  soft.youngs_modulus = 1e3;
  soft.damping = 0;
  for (Scene* s : {&t.scene, &t.twin}) require(s->world.set_material(s->ice, soft));
  t.step(3);
  ASSERT_TRUE(t.same());
  const std::uint64_t uploads = t.scene.world.plan().uploads;
  const auto short_one = [](Scene& s) {
    SolidDesc d;
    d.material = s.ice;
    d.shape = Shape::box({0.2, 1.4, 0.2}, {0.6, 1.8, 0.6});
    d.temperature = -5;
    return s.world.add_solid(d);
  };
  const auto added = t.both(short_one);
  ASSERT_TRUE(added.first) << added.first.error().message;
  t.step(4);
  EXPECT_TRUE(t.same());
  int call = 0;
  ASSERT_TRUE(
      t.both([&](Scene& s) { return s.world.remove(call++ == 0 ? *added.first : *added.second); }).first);
  t.step(4);
  EXPECT_TRUE(t.same());
  EXPECT_EQ(t.scene.world.plan().uploads, uploads);
}

// Where liquid was displaced its places are taken anew, so that sums run in another order than after an upload: one state, and totals of
// it that are equal to rounding.
TEST(Edits, TotalsAreThoseOfAnUploadToRounding) {
  MELTSIM_NEEDS_BACKEND();
  Twins t = make(cases().front());
  t.step(3);
  const auto drop = [](Scene& s) {
    SolidDesc d;
    d.material = s.ice;
    d.shape = Shape::box({0.2, 0.8, 0.2}, {0.8, 1.4, 0.8});
    d.temperature = -5;
    d.velocity = {0.1, -0.2, 0};
    return s.world.add_solid(d);
  };
  ASSERT_TRUE(t.both(drop).first);
  ASSERT_TRUE(t.both([](Scene& s) {
                 return s.world.add_fluid(liquid(s.water, Shape::box({0.2, 2.0, 0.4}, {0.4, 2.2, 2.2}), 80));
               }).first);
  EXPECT_TRUE(t.same());
  const Totals a = *t.scene.world.totals(), b = *t.twin.world.totals();
  EXPECT_EQ(a.fluid, b.fluid);
  EXPECT_EQ(a.solid, b.solid);
  for (const auto& [here, there] :
       {std::pair{a.mass, b.mass}, {a.kinetic, b.kinetic}, {a.thermal, b.thermal}})
    EXPECT_NEAR(here / there, 1, 1e-12);
}

TEST(Edits, AreHeldBySnapshotsAndEndWhatWasSaved) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.reserved_particles = 100;
  Scene s = ice_in_water(d, {}), other = ice_in_water(d, {});
  for (int k = 0; k < 2; ++k) require(s.world.step(0.01));
  require(s.world.save_state(0));
  const auto view = s.world.device_state();
  ASSERT_TRUE(view);
  ASSERT_TRUE(s.world.add_fluid(liquid(s.water, Shape::box({0.2, 2.0, 0.4}, {0.4, 2.2, 2.2}), 80)));
  EXPECT_FALSE(s.world.check_view(*view));
  const Status lost = s.world.load_state(0);
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().message.find("something was added"), std::string::npos);
  const auto bytes = s.world.snapshot();
  ASSERT_TRUE(bytes);
  require(other.world.restore(bytes->data(), bytes->size()));
  for (int k = 0; k < 3; ++k) {
    require(s.world.step(0.01));
    require(other.world.step(0.01));
  }
  EXPECT_EQ(*s.world.state_hash(), *other.world.state_hash());
}

// Of a nozzle whose time is over nothing follows, whichever way it is added.
TEST(Edits, AWarmerEmitterThatIsOverLetsNoHeatFlow) {
  MELTSIM_NEEDS_BACKEND();
  Twins t = make({"", [](WorldDesc&, IceScene& s) { s.ice_temperature = s.water_temperature = -5; }});
  t.step(3);
  const std::uint64_t uploads = t.scene.world.plan().uploads;
  const auto tap = [](Scene& s) {
    EmitterDesc e;
    e.material = s.water;
    e.center = {0.6, 2.0, 0.6};
    e.radius = 0.3;
    e.temperature = 60;
    e.until = 0.02;
    return s.world.add_emitter(e);
  };
  ASSERT_TRUE(t.both(tap).first);
  t.step(3);
  for (Scene* s : {&t.scene, &t.twin})
    for (const StageReport& stage : s->world.plan().stages)
      EXPECT_FALSE(stage.runs && stage.module == "thermal") << stage.name;
  EXPECT_TRUE(t.same());
  EXPECT_EQ(t.scene.world.plan().uploads, uploads);
}

// Where all is as warm as what a nozzle brings, no heat flows; what comes warmer later ends that.
TEST(Edits, AWarmerEmitterLetsHeatFlow) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.heat.time_scale = 1000;  // in 0.8 s a spacing's heat goes 0.01 m on
  d.domain.bounded = true;
  d.domain.max = {0.6, 1, 0.6};
  auto made = World::create(d);
  ASSERT_TRUE(made);
  World& w = *made;
  const MaterialId water = *w.add_material({});
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0, 0, 0}, {0.6, 0.3, 0.6});
  const std::uint64_t first = *w.add_fluid(f);
  EmitterDesc e;
  e.material = water;
  e.center = {0.3, 0.6, 0.3};
  e.radius = 0.15;
  e.speed = 2;
  e.until = 0.3;
  const EmitterId tap = *w.add_emitter(e);
  const auto heat_runs = [&w] {
    for (const StageReport& s : w.plan().stages)
      if (s.name == "thermal.exchange") return s.runs;
    return false;
  };
  require(w.step(0.02));
  EXPECT_FALSE(heat_runs());
  EmitterSetting warmer;
  warmer.temperature = 80;
  require(w.set_emitter(tap, warmer));
  EXPECT_TRUE(heat_runs());
  for (int k = 0; k < 40; ++k) require(w.step(0.02));
  const ParticleData p = *w.particles();
  double warmest = 0;
  for (std::size_t i = 0; i < first; ++i) warmest = std::max(warmest, p.temperature[i]);
  EXPECT_GT(warmest, 20.1);
  EXPECT_LT(warmest, 80);
}

}  // namespace
}  // namespace meltsim_test
