// SPDX-License-Identifier: Apache-2.0
// Which liquid takes which free site, and what that does to the lattice.
#include <gtest/gtest.h>

#include <cmath>

#include "meltsim/physics/phase_change.hpp"
#include "modules/lattice_oracle.hpp"

namespace {

using namespace modules_test;

constexpr core::FactSet facts = core::fact_particles | core::fact_fluid | core::fact_solid |
                                core::fact_mobile | core::fact_lattice | core::fact_contact |
                                core::fact_melt | core::fact_freeze;
constexpr std::uint32_t water = 0, brine = 2;
constexpr double dx = 0.2;
constexpr int drawn_in = 64;

/// A sub-step of topology, and what follows it at the beginning of the next.
void run_topology(Rig<double>& rig) {
  rig.run({"step.begin", "spatial", "spatial.neighbours", "topology"}, 1e-9);
  rig.run({"step.begin", "spatial", "spatial.neighbours", "topology.regions", "topology.pieces"}, 1e-9);
}

/// A plate of ice of 5 x 5 sites, z = 0, and free sites upon it, z = 1.
struct Plate {
  core::SceneConstants constants = plain_constants(dx);
  core::SceneLattice lattice;
  core::SceneState state;
  Rig<double> rig;

  explicit Plate(int half_width = 1) {
    constants.spring_dt = 1e-9;  // the sub-step below: particles are drawn as far as in an acoustic step
    for (const std::uint32_t m : {water, brine}) {
      core::MaterialRow<double>& row = constants.materials[m];
      row.freezes = row.plateau = 1;
      row.solid = m == water ? 1 : 2;  // brine freezes into something else
      row.latent_heat = row.melting_heat = 1000;
      row.melting_enthalpy = -1000;
    }
    std::vector<Vec3i> free = block(5, 5, 1);
    for (Vec3i& p : free) p.z = 1;
    add_body(lattice, state, constants, block(5, 5, 1), half_width, free);
  }
  std::uint32_t site(int x, int y) const { return vertex_at(lattice, 0, {x, y, 1}); }
  /// Liquid at an offset in spacings from the centre of a free site; cold enough to freeze.
  std::uint32_t add(int x, int y, Vec3d offset, std::uint32_t material = water) {
    return add_particle(state, constants, (Vec3d{x + 0.5, y + 0.5, 1.5} + offset) * dx, material, {1, 2, 3});
  }
  /// As many sub-steps as a particle is drawn to its site in, in which nothing but freezing happens; short, so that nothing else moves.
  void freeze(std::uint32_t with = facts) {
    rig.upload(constants, lattice, state, with);
    for (int k = 0; k < drawn_in; ++k)
      rig.run({"step.begin", "spatial", "spatial.neighbours", "topology"}, 1e-9);
    rig.engine->download(state);
  }
};

// The state after freezing, value by value. Velocity and mass keep their bits, the place is the site's.
TEST(Freezing, LiquidWithinReachTakesTheSite) {
  Plate p;
  const std::uint32_t id = p.add(2, 2, {0.3, -0.2, 0.4});  // 0.54 of 0.62
  const double mass = p.state.mass[id], enthalpy = p.state.enthalpy[id];
  p.freeze();
  const std::uint32_t v = p.site(2, 2);
  EXPECT_EQ(p.state.vertex_state[v], 1u);
  EXPECT_EQ(p.state.vertex_id[v], id);
  EXPECT_EQ(p.state.vertex_of_id[id], v);
  EXPECT_EQ(p.state.vertex_piece[v], p.state.vertex_piece[0]);
  EXPECT_EQ(p.state.tag[id], p.state.tag[0]);  // a surface particle of the same body and material
  EXPECT_EQ(p.state.mass[id], mass);
  EXPECT_EQ(p.state.enthalpy[id], enthalpy);
  EXPECT_EQ(p.state.velocity[id].x, 1.0);
  EXPECT_EQ(p.state.velocity[id].z, 3.0);
  EXPECT_NEAR(p.state.volume[id], dx * dx * dx, 1e-18);
  EXPECT_NEAR(length(p.state.position[id] - Vec3d{0.5, 0.5, 0.3}), 0, 1e-6);  // drifts of 1e-9 s
  EXPECT_EQ(p.state.frozen, 1u);
}

// The particle is drawn by a hundredth of a spacing in a sub-step, is liquid until it is a tenth from the site, and of two the nearer is.
TEST(Freezing, AParticleIsDrawnToItsSiteSlowly) {
  Plate p;
  const std::uint32_t id = p.add(2, 2, {0, 0, 0.305}), second = p.add(2, 2, {0.5, 0, 0});
  const std::uint32_t at = p.add(0, 0, {0.09, 0, 0});
  p.state.enthalpy[second] = -999 * p.state.mass[second];  // warm: no site takes it
  p.rig.upload(p.constants, p.lattice, p.state, facts);
  for (int k = 1; k <= 40; ++k) {
    p.rig.run({"step.begin", "spatial", "spatial.neighbours", "topology"}, 1e-9);
    p.rig.engine->download(p.state);
    const double left = std::max(0.0, 0.305 - physics::drawn_step * k);
    EXPECT_NEAR(p.state.position[id].z, (1.5 + left) * dx, 1e-6) << k;
    EXPECT_NEAR(p.state.position[second].x, 3.0 * dx, 1e-6) << k;
    EXPECT_TRUE(is_fluid(p.state.tag[id]));  // the second is near
    EXPECT_TRUE(is_solid(p.state.tag[at]));
  }
}

// What a held body draws no longer moves away from its site, or it would hang where it falls as fast as it is drawn; along the plate it
// moves on. A free body leaves it its momentum.
TEST(Freezing, WhatAHeldBodyDrawsDoesNotMoveAway) {
  for (const bool held : {false, true}) {
    Plate p;
    const std::uint32_t away = p.add(2, 2, {0, 0, 0.5}), towards = p.add(0, 0, {0, 0, -0.5});
    if (held)
      for (std::uint32_t& tag : p.state.tag)
        if (is_solid(tag)) tag |= tag_fixed;
    p.rig.upload(p.constants, p.lattice, p.state, facts);
    p.rig.run({"step.begin", "spatial", "spatial.neighbours", "topology"}, 1e-9);
    p.rig.engine->download(p.state);
    EXPECT_NEAR(p.state.velocity[away].x, 1.0, 1e-6);  // a nanosecond of weight and pressure
    EXPECT_NEAR(p.state.velocity[away].z, held ? 0.0 : 3.0, 1e-6);
    EXPECT_NEAR(p.state.velocity[towards].z, 3.0, 1e-6);
  }
}

TEST(Freezing, WhatIsOutOfReachWarmOrOfAnotherMaterialStaysLiquid) {
  Plate p;
  const std::uint32_t far = p.add(0, 0, {0, 0, 0.63});
  const std::uint32_t warm = p.add(2, 0, {});
  p.state.enthalpy[warm] = -999 * p.state.mass[warm];  // a thousandth of the latent heat is left
  const std::uint32_t other = p.add(4, 0, {}, brine);
  // Two at one site: neither while the other is near, though each alone would be within reach.
  const std::uint32_t left = p.add(0, 2, {-0.3, 0, 0}), right = p.add(0, 2, {0.3, 0, 0});
  // Room enough: the second is beyond 0.75.
  const std::uint32_t near = p.add(3, 3, {}), apart = p.add(3, 3, {0, 0, 0.76});
  p.freeze();
  for (const std::uint32_t id : {far, warm, other, left, right, apart})
    EXPECT_TRUE(is_fluid(p.state.tag[id])) << id;
  EXPECT_TRUE(is_solid(p.state.tag[near]));
  EXPECT_EQ(p.state.frozen, 1u);
}

// At the melting point itself a liquid without latent heat stays liquid and a solid melts; each a hair beyond
// it changes nothing: no chatter.
TEST(Freezing, WithoutLatentHeatTheMeltingPointBelongsToTheLiquid) {
  for (const bool below : {false, true}) {
    Plate p;
    for (const int m : {0, 1})
      p.constants.materials[m].latent_heat = p.constants.materials[m].melting_heat =
          p.constants.materials[m].melting_enthalpy = 0;
    const std::uint32_t id = p.add(2, 2, {});
    p.state.enthalpy[id] = below ? -1e-9 : 0;
    p.freeze();
    EXPECT_EQ(is_solid(p.state.tag[id]), below);
    for (int again = 0; again < 3; ++again) p.freeze();
    EXPECT_EQ(is_solid(p.state.tag[id]), below);
    EXPECT_EQ(p.state.melted, 0u);
    EXPECT_EQ(p.state.frozen, below ? 1u : 0u);
  }
}

// A particle in the middle of four sites: the smallest vertex gets it, the others stay free.
TEST(Freezing, AParticleThatSeveralSitesWantGoesToTheSmallestVertex) {
  Plate p;
  const std::uint32_t id = p.add(1, 1, {0.43, 0.43, 0});  // 0.61 from the nearest of the four ...
  const std::uint32_t second = p.add(3, 1, {0.5, 0, 0});  // ... and just between two
  p.freeze();
  EXPECT_EQ(p.state.vertex_of_id[id], p.site(1, 1));
  EXPECT_EQ(p.state.vertex_of_id[second], std::min(p.site(3, 1), p.site(4, 1)));
  EXPECT_EQ(p.state.frozen, 2u);
  std::uint64_t live = 0;
  for (const std::uint32_t s : p.state.vertex_state) live += s == 1u ? 1 : 0;
  EXPECT_EQ(live, 27u);
}

TEST(Freezing, AFixedBodyStopsWhatFreezesOntoIt) {
  Plate p;
  p.lattice.bodies[0].motion = core::body_fixed;
  for (std::uint32_t& t : p.state.tag) t |= tag_fixed;
  const std::uint32_t id = p.add(2, 2, {0.1, 0, 0});
  p.freeze(facts & ~(core::fact_mobile | core::fact_lattice | core::fact_contact));
  EXPECT_EQ(p.state.tag[id], p.state.tag[0]);
  EXPECT_EQ(length(p.state.velocity[id]), 0.0);
  EXPECT_NEAR(length(p.state.position[id] - Vec3d{0.5, 0.5, 0.3}), 0, 1e-15);
}

// The whole scene turned and moved: sites turn with the regions.
TEST(Freezing, SitesMoveWithTheBody) {
  Plate p;
  const double angle = 0.7;
  const Quat<double> q{std::cos(angle / 2), 0, std::sin(angle / 2), 0};
  const auto turned = [&](Vec3d x) { return to_matrix(q) * x + Vec3d{3, -2, 1}; };
  const std::uint32_t id = p.add(2, 2, {0, 0.3, 0.3});
  for (Vec3d& x : p.state.position) x = turned(x);
  for (auto& r : p.state.region_rotation) r = q;
  p.freeze();
  EXPECT_EQ(p.state.vertex_of_id[id], p.site(2, 2));
  EXPECT_NEAR(length(p.state.position[id] - turned({0.5, 0.5, 0.3})), 0, 1e-6);
  EXPECT_EQ(p.state.region_rotation[p.site(2, 2)].y, q.y);
}

// Two halves of the plate drift apart: the gap between them belongs to neither.
TEST(Freezing, NeighboursThatDisagreeLeaveTheSiteFree) {
  for (const double apart :
       {0.4, 0.6}) {  // each half's wish is half of that from the mean: 0.25 is the limit
    Plate p;
    for (std::uint32_t v = 0; v < 25; ++v)
      if (p.lattice.vertex_coordinates[v].x >= 2) p.state.position[v].x += apart * dx;
    // 3 of 9 neighbours on the left, 6 on the right: the mean is two thirds of the way.
    const std::uint32_t id = p.add(2, 2, {apart * 2 / 3, 0, 0});
    p.freeze();
    EXPECT_EQ(is_solid(p.state.tag[id]), apart * 2 / 3 <= physics::site_agreement) << apart;
  }
}

// Sites turned into a wall are no sites.
TEST(Freezing, NothingFreezesInsideAWall) {
  for (const double wall : {1.7, 1.8}) {  // from the site at 1.5: 0.2 and 0.3 spacings; 0.25 is the limit
    Plate p;
    p.constants.domain.bounded = true;
    p.constants.domain.min = {-2, -2, -2};
    p.constants.domain.max = {2, 2, wall * dx};
    const std::uint32_t id = p.add(2, 2, {});
    p.freeze();
    EXPECT_EQ(is_solid(p.state.tag[id]), wall > 1.75);
  }
}

void expect_lattice(const Plate& p, const core::LatticeMasks& m, int w) {
  const LatticeOracle oracle(p.lattice, p.state.vertex_state);
  for (std::uint32_t v = 0; v < p.lattice.vertex_site.size(); ++v) {
    ASSERT_EQ(m.neighbour_mask[v], oracle.neighbour_mask(v)) << "vertex " << v;
    ASSERT_EQ(offsets(m, v, w), oracle.region(v, w)) << "vertex " << v;
    if (p.state.vertex_state[v] != 1u) continue;
    const std::uint32_t id = p.state.vertex_id[v], tag = p.state.tag[id];
    ASSERT_TRUE(is_solid(tag));
    ASSERT_EQ(p.state.vertex_of_id[id], v);
    ASSERT_EQ((tag & tag_surface) != 0u, popcount(m.neighbour_mask[v]) < 27u) << "vertex " << v;
  }
}

/// A block of 5^3 of which half has melted where it stands, in a shell of free sites with liquid.
struct Growing : Plate {
  explicit Growing(int w) : Plate(w) {
    lattice = {};
    state = {};
    std::vector<Vec3i> shell;
    for (int z = -2; z < 7; ++z)
      for (int y = -2; y < 7; ++y)
        for (int x = -2; x < 7; ++x)
          if (std::min({x, y, z}) < 0 || std::max({x, y, z}) > 4) shell.push_back({x, y, z});
    add_body(lattice, state, constants, block(5, 5, 5), w, shell);
    for (const Vec3i& s : shell)
      add_particle(state, constants, Vec3d{s.x + 0.5, s.y + 0.5, s.z + 0.5} * dx, water);
  }
};

// Eight steps in which a random share of liquid is cooled and a random share of the solid heated. What
// freezes is exactly what is cold beside something live; all arrays equal those of a search, and of an
// upload.
TEST(Freezing, IncrementalEqualsFullRebuild) {
  for (const int w : {0, 1, 3}) {
    Random random(200 + static_cast<std::uint32_t>(w));
    Growing p(w);
    for (double& h : p.state.enthalpy) h = 0;  // solid: all liquid; liquid: none frozen
    for (std::uint32_t id = 0; id < 125; ++id) p.state.enthalpy[id] = -2000 * p.state.mass[id];
    p.rig.upload(p.constants, p.lattice, p.state, facts);
    const core::Frame<double>& f = p.rig.frame();
    run_topology(p.rig);
    std::vector<std::vector<std::uint32_t>> face(p.state.vertex_state.size());
    for (std::uint32_t v = 0; v < face.size(); ++v)
      for (const Vec3i d : {Vec3i{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}})
        if (const std::uint32_t n = vertex_at(p.lattice, v, d); n != core::none) face[v].push_back(n);
    std::uint64_t melted = 0, frozen = 0, internal = 0;
    for (int round = 0; round < 8; ++round) {
      SCOPED_TRACE("w " + std::to_string(w) + ", round " + std::to_string(round));
      p.rig.engine->download(p.state);
      std::vector<std::uint32_t> expected = p.state.vertex_state;
      for (std::uint32_t id = 0; id < p.state.tag.size(); ++id) {
        double& h = f.f.enthalpy[f.f.slot_of_id[id]];
        const double draw = random.uniform(), m = p.state.mass[id];
        if (is_solid(p.state.tag[id]) && draw < (round % 4 == 3 ? 0.2 : 0.02)) h = 1 * m;
        if (is_fluid(p.state.tag[id])) h = draw < 0.5 ? -1500 * m : -500 * m;
        const std::uint32_t v = is_solid(p.state.tag[id]) ? p.state.vertex_of_id[id] : core::none;
        if (v != core::none && h > 0 && (p.state.tag[id] & tag_surface) != 0u) {
          expected[v] = 2;
          ++melted;
        }
      }
      for (std::uint32_t v = 0; v < expected.size(); ++v) {
        if (p.state.vertex_state[v] == 2u) expected[v] = 0;  // melted a step ago: free from the next on
        if (p.state.vertex_state[v] != 0u) continue;
        bool beside = false;
        for (const std::uint32_t n : face[v]) beside = beside || p.state.vertex_state[n] == 1u;
        // Nothing moves, so the particle at vertex v is that of id v.
        if (beside && f.f.enthalpy[f.f.slot_of_id[v]] < -1000 * p.state.mass[v]) {
          expected[v] = 1;
          ++frozen;
        }
      }
      run_topology(p.rig);
      p.rig.engine->download(p.state);
      ASSERT_EQ(p.state.vertex_state, expected);
      ASSERT_EQ(p.state.melted, melted);
      ASSERT_EQ(p.state.frozen, frozen);
      core::LatticeMasks kept, full;
      p.rig.engine->download(kept);
      ASSERT_NO_FATAL_FAILURE(expect_lattice(p, kept, w));
      for (const std::uint32_t mask : kept.neighbour_mask) internal += popcount(mask) == 27u ? 1 : 0;
      const LatticeOracle after(p.lattice, expected);
      for (std::uint32_t v = 0; v < expected.size(); v += 31)  // the oracle floods the body for each
        if (expected[v] == 1u) {
          ASSERT_EQ(p.state.vertex_piece[v], after.piece(v));
        }
      Rig<double> fresh;
      fresh.upload(p.constants, p.lattice, p.state, facts);
      fresh.engine->download(full);
      ASSERT_EQ(kept.neighbour_mask, full.neighbour_mask);
      ASSERT_EQ(kept.region_mask, full.region_mask);
    }
    EXPECT_GT(melted, 50u);
    EXPECT_GT(frozen, 200u);
    EXPECT_GT(internal, 30u);  // surface particles became internal ones
  }
}

// A gap of one site between two pieces fills: they are one again, with one label.
TEST(Freezing, PiecesThatFreezeTogetherAreOne) {
  Plate p;
  for (std::uint32_t v = 0; v < 25; ++v)
    if (p.lattice.vertex_coordinates[v].x == 2) {
      p.state.vertex_state[v] = 0;
      p.state.tag[v] = water;
    }
  for (std::uint32_t v = 0; v < 25; ++v)
    if (p.lattice.vertex_coordinates[v].x > 2) p.state.vertex_piece[v] = 3;
  // A first search ends while the gap is still warm; the next is due because something froze.
  for (double& h : p.state.enthalpy) h = -999 * p.state.mass[0];
  p.rig.upload(p.constants, p.lattice, p.state, facts);
  run_topology(p.rig);
  const core::Frame<double>& f = p.rig.frame();
  ASSERT_EQ(f.f.status->pieces_stale, 0u);
  ASSERT_EQ(f.f.vertex_piece[3], 3u);
  for (std::uint32_t i = 0; i < 25; ++i) f.f.enthalpy[i] = -1e6;
  run_topology(p.rig);
  p.rig.engine->download(p.state);
  EXPECT_EQ(p.state.frozen, 5u);
  for (std::uint32_t v = 0; v < 25; ++v) EXPECT_EQ(p.state.vertex_piece[v], 0u) << v;
}

/// The bits of a random lattice in random liquid after 64 sub-steps.
core::SceneState freeze_at_random(Order order) {
  Random random(77);
  Growing p(2);
  for (std::uint32_t v = 0; v < 125; ++v)
    if (random.uniform() < 0.3) {
      p.state.vertex_state[v] = 0;
      p.state.tag[v] = water;
    }
  for (std::uint32_t id = 0; id < p.state.tag.size(); ++id)
    if (is_fluid(p.state.tag[id]))
      p.state.position[id] +=
          Vec3d{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5} * dx;
  Rig<double> rig(order);
  rig.upload(p.constants, p.lattice, p.state, facts);
  for (int k = 0; k < drawn_in; ++k) run_topology(rig);
  rig.engine->download(p.state);
  return p.state;
}

TEST(Freezing, OrderChangesNoBit) {
  const core::SceneState a = freeze_at_random(Order::forward);
  EXPECT_GT(a.frozen, 50u);
  for (const Order order : {Order::reversed, Order::shuffled}) {
    const core::SceneState b = freeze_at_random(order);
    EXPECT_EQ(a.vertex_id, b.vertex_id);
    EXPECT_EQ(a.vertex_of_id, b.vertex_of_id);
    EXPECT_EQ(a.vertex_state, b.vertex_state);
    EXPECT_EQ(a.vertex_piece, b.vertex_piece);
    EXPECT_EQ(a.tag, b.tag);
    for (std::size_t i = 0; i < a.position.size(); ++i)
      ASSERT_TRUE(a.position[i].x == b.position[i].x && a.position[i].y == b.position[i].y &&
                  a.position[i].z == b.position[i].z);
  }
}

}  // namespace
