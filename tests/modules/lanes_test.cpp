// SPDX-License-Identifier: Apache-2.0
// The sweeps that work on several neighbours at a time against the bodies that take them one by one: the same
// neighbours, to the last bit; the same sums, to rounding (a few units in the last place of the sum of what
// they add up, at up to 500 neighbours).
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "modules/engine.hpp"
#include "sph/bodies.hpp"
#include "thermal/bodies.hpp"

namespace {

using namespace modules_test;

constexpr double spacing = 0.2;

struct Cloud {
  core::SceneConstants constants = plain_constants(spacing);
  core::SceneState state;
  void add(Vec3d x, std::uint32_t tag, Vec3d v) { add_particle(state, constants, x, tag, v); }
  void bound(Vec3d max, int periodic) {
    DomainDesc& d = constants.domain;
    d.bounded = true;
    d.max = max;
    for (std::size_t a = 0; a < 3; ++a)
      if ((periodic >> a) & 1) d.faces[2 * a] = d.faces[2 * a + 1] = Face::periodic;
  }
  /// n particles of these kinds anywhere in the box.
  void scatter(int n, Random& random, std::initializer_list<std::uint32_t> tags) {
    const Vec3d e = constants.domain.max;
    for (int k = 0; k < n; ++k) {
      const std::uint32_t tag = *(tags.begin() + k % static_cast<int>(tags.size()));
      const double x = random.uniform(0, e.x), y = random.uniform(0, e.y);
      add({x, y, random.uniform(0, e.z)}, tag, random.vector(1));
    }
  }
};

template <class T>
class Lanes : public testing::Test {
 protected:
  void SetUp() override {
    if (!core::sums_by_lanes) GTEST_SKIP() << "this build sums one by one, for a GPU's bits";
  }
  static constexpr T tolerance = 64 * std::numeric_limits<T>::epsilon();

  static void check(Cloud cloud, sph::Company company) {
    cloud.constants.one_liquid = company != sph::Company::any;
    double conductivity = 2.2;
    for (core::MaterialRow<double>& m : cloud.constants.materials) {
      m.plateau = 1;  // a liquid that holds both phases conducts in another way toward who is warmer, too
      m.conductivity = conductivity;
      m.liquid_conductivity = 0.3 * conductivity;
      conductivity *= 2;
    }
    for (const std::uint32_t search : {core::fact_packed, core::fact_sparse}) {
      Rig<T> rig;
      const bool alone = company == sph::Company::liquid;
      rig.upload(cloud.constants, {}, cloud.state,
                 core::fact_particles | core::fact_fluid | core::fact_heat_enthalpy | search |
                     (alone ? core::FactSet{0} : core::FactSet{core::fact_solid}));
      if (alone) rig.run({"step.begin", "spatial", "sph.density", "sph.forces"}, 0.001);
      else rig.run({"step.begin", "spatial", "sph.density", "sph.cover", "sph.forces"}, 0.001);
      const core::Frame<T>& w = rig.frame();
      ASSERT_EQ(sph::company_of(w), company);
      spatial::with_periods(w, [&](auto periodic) {
        if (company == sph::Company::liquid) compare<sph::Company::liquid, periodic()>(w);
        else if (company == sph::Company::solids) compare<sph::Company::solids, periodic()>(w);
        else compare<sph::Company::any, periodic()>(w);
      });
    }
  }

 private:
  /// Slots of i's neighbours as its words say, or that they are too many.
  static std::vector<std::uint32_t> stored(const core::Frame<T>& w, std::size_t i) {
    std::vector<std::uint32_t> slots;
    if (is_removed(w.f.tag[i])) return slots;
    if (!spatial::walk_words(w, i, 0u, 1u, [&](std::uint32_t j) { slots.push_back(j); }))
      slots.push_back(core::none);
    return slots;
  }
  template <sph::Company company, bool Periodic>
  static void compare(const core::Frame<T>& w) {
    const std::size_t n = w.particles;
    std::vector<T> density(w.f.density, w.f.density + n), term;
    std::vector<Vec3<T>> acceleration(w.f.acceleration, w.f.acceleration + n);
    std::vector<std::vector<std::uint32_t>> neighbours;
    for (std::size_t i = 0; i < n; ++i) {
      term.push_back(w.f.velocity[i].w);
      neighbours.push_back(stored(w, i));
    }
    const sph::DensityBody<T, spatial::search_kind<Periodic>> body{w};
    const sph::ForcesBody<T, company, Periodic> forces{w};
    const sph::ForcesBody<T, sph::Company::any, Periodic> asks{w};
    for (std::size_t i = 0; i < n; ++i) {
      body.finish(i, core::sum_of(body, i, 1));
      EXPECT_NEAR(w.f.density[i], density[i], tolerance * density[i]) << i;
      // Pressure grows with the seventh power, and a difference is taken.
      EXPECT_NEAR(w.f.velocity[i].w, term[i], 20 * tolerance * (std::fabs(term[i]) + 1e5)) << i;
      w.f.velocity[i].w = term[i];
      if (is_removed(w.f.tag[i])) continue;
      EXPECT_EQ(stored(w, i), neighbours[i]) << i;
    }
    T largest = 0;
    for (std::size_t i = 0; i < n; ++i) largest = maximum(largest, length(acceleration[i]));
    EXPECT_GT(largest, T(10));
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_fluid(w.f.tag[i])) continue;
      forces(i);
      const Vec3<T> alone = w.f.acceleration[i];
      EXPECT_LE(length(alone - acceleration[i]), tolerance * largest) << i;
      asks(i);  // who asks everyone what it is finds the same
      EXPECT_LE(length(w.f.acceleration[i] - alone), tolerance * largest) << i;
    }
    if constexpr (company == sph::Company::solids) compare_reaction<Periodic>(w);
    compare_heat<Periodic>(w);
  }
  template <bool Periodic>
  static void compare_reaction(const core::Frame<T>& w) {
    const core::LiquidOnSolid<T> body{w};
    std::vector<std::pair<Vec3<T>, Vec3<T>>> both;
    T largest = 0;
    for (std::size_t k = 0; k < w.particles; ++k) {
      if (!is_solid(w.f.tag[k]) || is_removed(w.f.tag[k])) continue;
      const auto one = spatial::sum_part<Periodic>(w, body, k, 0u, 1u),
                 many = spatial::sum_in_lanes<Periodic>(w, body, k);
      both.emplace_back(one.force, many.force);
      largest = maximum(largest, length(one.force));
    }
    EXPECT_GT(both.size(), 5u);
    EXPECT_GT(largest, T(0));
    for (const auto& [one, many] : both) EXPECT_LE(length(one - many), tolerance * largest);
  }
  /// Some particles hold both phases: their resistivity is marked. Many of them are as warm as others of another material.
  template <bool Periodic>
  static void compare_heat(const core::Frame<T>& w) {
    Random random(91);
    for (std::size_t i = 0; i < w.particles; ++i) {
      const T r = static_cast<T>(random.uniform(0.5, 2));
      w.f.heat_share[i] = static_cast<T>(random.uniform(0.3, 1));
      w.f.heat_operand[i] = {static_cast<T>(i % 2 == 0 ? 0.0 : random.uniform(-20, 20)),
                             i % 5 == 0 ? core::marked(r) : r};
    }
    const thermal::StageBody<T, false, Periodic> body{w, physics::stage_factors(1, 1, 1.0, true, true)};
    for (std::size_t i = 0; i < w.particles; ++i) {
      if (is_removed(w.f.tag[i])) continue;
      const auto a = body.part(i, 0, 1), b = spatial::sum_in_lanes<Periodic>(w, body, i);
      EXPECT_NEAR(a.conductance, b.conductance, tolerance * a.conductance) << i;
      EXPECT_NEAR(a.rate, b.rate, 40 * static_cast<double>(tolerance * a.conductance)) << i;
    }
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Lanes, Scalars);

TYPED_TEST(Lanes, WallsOnAllSides) {
  Random random(92);
  Cloud c;
  c.bound({1.3, 1.7, 1.1}, 0);  // images in planes, edges and corners; some see both of two walls
  c.scatter(500, random, {0u});
  this->check(c, sph::Company::liquid);
}

TYPED_TEST(Lanes, PeriodicAlongSomeAxes) {
  Random random(93);
  for (int periodic = 1; periodic < 8; ++periodic) {
    Cloud c;
    c.bound({1.6, 2.1, 1.7}, periodic);
    c.scatter(700, random, {0u});
    this->check(c, sph::Company::liquid);
  }
}

TYPED_TEST(Lanes, SolidsAndASecondLiquid) {
  Random random(94);
  Cloud c;
  c.bound({1.6, 1.9, 1.7}, 0);
  c.scatter(300, random, {0u, 0u, 0u, 0u, 1u | tag_solid, 2u, 0u | tag_removed});
  for (int n = 0; n < 200; ++n) c.add({3 + random.uniform(0, 0.5), 1, 1}, 0u, random.vector(1));  // alike
  c.bound({4, 1.9, 1.7}, 0);
  this->check(c, sph::Company::any);
}

// Some so near that liquid could slip through, some of the same liquid far from any.
TYPED_TEST(Lanes, SolidsInOneLiquid) {
  Random random(97);
  Cloud c;
  c.bound({1.6, 1.9, 1.7}, 0);
  c.scatter(300, random, {0u, 0u, 0u, 0u, 1u | tag_solid, 0u | tag_removed});
  for (int n = 0; n < 200; ++n) c.add({3 + random.uniform(0, 0.5), 1, 1}, 0u, random.vector(1));
  c.bound({4, 1.9, 1.7}, 0);
  this->check(c, sph::Company::solids);
}

// More candidates in a row than have a bit, more neighbours than a batch holds.
TYPED_TEST(Lanes, Crowds) {
  Random random(95);
  Cloud c;
  c.bound({2, 2, 2}, 0);
  c.scatter(200, random, {0u});
  for (int n = 0; n < 500; ++n) c.add(Vec3d{0.3, 0.3, 1} + random.vector(0.12), 0u, random.vector(1));
  this->check(c, sph::Company::liquid);
}

TYPED_TEST(Lanes, FewParticles) {
  for (const int n : {1, 2, 7, 8, 9}) {
    Random random(96);
    Cloud c;
    c.bound({0.6, 0.6, 0.6}, 0);
    c.constants.surroundings.gravity = {0, -20, 0};
    c.scatter(n, random, {0u});
    this->check(c, sph::Company::liquid);
  }
}

// A weight of zero takes nothing out of a NaN: lanes beyond the last neighbour must be loaded, too. On g++ 13 what lay
// on the stack halted Worlds.
template <class T>
void loads_whole_lanes() {
  struct Pair {
    T a, b;
  };
  const Pair from[2] = {{T(1), T(2)}, {T(3), T(4)}};
  for (std::uint32_t n = 1; n <= 2 * spatial::lanes; ++n) {
    std::uint32_t slots[2 * spatial::lanes] = {};
    slots[n - 1] = 1;
    auto pairs = std::make_unique<spatial::LanePairs<T>>();
    for (std::size_t k = 0; k < spatial::batch + spatial::lanes; ++k)
      pairs->first[k] = pairs->second[k] = std::numeric_limits<T>::quiet_NaN();
    pairs->load(from, slots, n);
    const std::size_t all = (n + spatial::lanes - 1) / spatial::lanes * spatial::lanes;
    for (std::size_t k = 0; k < all; ++k) {
      ASSERT_EQ(pairs->first[k], k == n - 1 ? T(3) : T(1)) << n << " neighbours, lane " << k;
      ASSERT_EQ(pairs->second[k], k == n - 1 ? T(4) : T(2)) << n << " neighbours, lane " << k;
    }
  }
}
TEST(Lanes, PairsAreLoadedOnToWholeLanes) {
  loads_whole_lanes<float>();
  loads_whole_lanes<double>();
}

}  // namespace
