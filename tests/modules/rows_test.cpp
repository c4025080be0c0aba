// SPDX-License-Identifier: Apache-2.0
// lsm.regions and lsm.goals, regions by planes of rows and those not made of them member by member, against sums over every
// member of every region in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine.hpp"
#include "lsm/rows.hpp"
#include "support/random.hpp"

namespace modules_test {
namespace {

constexpr double dx = 0.2;
constexpr double dt = 1e-3;
constexpr core::FactSet facts =
    core::fact_particles | core::fact_solid | core::fact_mobile | core::fact_lattice;

struct Bodies {
  core::SceneConstants constants = plain_constants(dx);
  core::SceneLattice lattice;
  core::SceneState state;

  Bodies() {
    constants.spring_dt = dt;
    constants.materials[1].shape_stiffness = 1;
    constants.materials[1].shape_damping = 1;
  }
  void add(const std::vector<Vec3i>& points, int w, bool fixed = false) {
    add_body(lattice, state, constants, points, w);
    lattice.bodies.back().motion = fixed ? core::body_fixed : core::body_free;
  }
  /// A fifth of a spacing off their places, masses that differ by a factor of ten; at 20 m/s what defects say
  /// weighs as much as what places say: 20 m/s dt = dx/10.
  void shake(Random& random) {
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      state.position[i] += random.vector(0.2 * dx);
      state.velocity[i] = random.vector(20);
      state.mass[i] *= random.uniform(0.2, 2);
    }
  }
  /// Everything moved by an offset, and back into a domain of four metres that is periodic.
  void wrap(Vec3d offset) {
    DomainDesc& d = constants.domain;
    d.bounded = true;
    d.max = {4, 4, 4};
    for (auto& face : d.faces) face = Face::periodic;
    const auto into = [](double x) { return x - 4 * std::floor(x / 4); };
    for (Vec3d& x : state.position) {
      x += offset;
      x = {into(x.x), into(x.y), into(x.z)};
    }
  }
};

/// a - b, the short way round.
Vec3d between(const Bodies& b, Vec3d a, Vec3d c) {
  Vec3d d = a - c;
  if (!b.constants.domain.bounded) return d;
  d.x -= 4 * std::rint(d.x / 4);
  d.y -= 4 * std::rint(d.y / 4);
  d.z -= 4 * std::rint(d.z / 4);
  return d;
}

/// visit(member, offset in spacings)
template <class Visit>
void each_member(const Bodies& b, const core::LatticeMasks& m, std::uint32_t v, const Visit& visit) {
  const core::BodyRow row = b.lattice.bodies[b.lattice.vertex_body[v]];
  const int w = row.region_half_width, side = 2 * w + 1;
  for (int bit = 0; bit < side * side * side; ++bit) {
    const auto word = static_cast<std::size_t>(v) * m.region_words + static_cast<std::size_t>(bit / 32);
    if (((m.region_mask[word] >> (bit % 32)) & 1u) == 0u) continue;
    const int x = bit % side - w, y = bit / side % side - w, z = bit / side / side - w;
    visit(b.lattice.site_vertex[core::site_at(b.lattice.vertex_site[v], row, x, y, z)],
          Vec3d{double(x), double(y), double(z)} * dx);
  }
}

/// Half-width from which a scene of such bodies is summed by planes: some builds follow a GPU's rule.
int least_width(const Bodies& b) {
  return core::least_row_width(!core::sums_by_lanes, b.lattice.vertex_site.size());
}

struct Found {
  std::uint64_t whole = 0, ragged = 0;  ///< regions that lack nobody, and others
  std::uint64_t boxed = 0;              ///< those made of planes of rows, of both
  double worst = 0;                     ///< of shape_velocity, as the distance it makes in a step [dx]
};

/// Compares shape_velocity of every vertex that moves.
template <class T>
Found compare(const Rig<T>& rig, const Bodies& b) {
  Found found;
  const core::Frame<T>& w = rig.frame();
  core::LatticeMasks masks;
  rig.engine->download(masks);
  const std::uint32_t n = w.vertices;
  std::vector<Vec3d> x(n), v(n);
  std::vector<double> share(n);
  std::vector<physics::RegionFit<double>> fit(n);
  const auto moves = [&](std::uint32_t i) {
    return w.f.vertex_state[i] == 1u && b.lattice.bodies[b.lattice.vertex_body[i]].motion == core::body_free;
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!moves(i)) continue;
    const std::uint32_t slot = w.f.slot_of_id[w.f.vertex_id[i]];
    std::uint32_t members = 0;
    each_member(b, masks, i, [&](std::uint32_t, Vec3d) { ++members; });
    x[i] = cast<double>(xyz(w.f.position[slot]));
    v[i] = cast<double>(xyz(w.f.velocity[slot]));
    share[i] = static_cast<double>(w.f.mass[slot]) / members;
    const int half = b.lattice.bodies[b.lattice.vertex_body[i]].region_half_width, side = 2 * half + 1;
    const bool whole = members == static_cast<std::uint32_t>(side * side * side);
    ++(whole ? found.whole : found.ragged);
    EXPECT_EQ(lsm::region_members(w, i), members) << i;
    EXPECT_TRUE(lsm::is_boxed(w, i) || !whole || half < least_width(b)) << i;
    EXPECT_TRUE(!lsm::is_boxed(w, i) || half >= least_width(b)) << i;
    if (lsm::is_boxed(w, i)) ++found.boxed;
  }
  for (std::uint32_t r = 0; r < n; ++r) {
    if (!moves(r)) continue;
    physics::RegionSums<double> s;
    Mat3<double> muu;
    each_member(b, masks, r, [&](std::uint32_t j, Vec3d q) {
      const Vec3d u = between(b, x[j], x[r]), relative = v[j] - v[r];
      s.mass += share[j];
      s.mu += u * share[j];
      s.mq += q * share[j];
      add_outer(s.muq, share[j], u, q);
      add_outer(muu, share[j], u, u);
      s.mv += relative * share[j];
      s.muxv += cross(u, relative) * share[j];
    });
    s.muu = {{muu.m[0][0], muu.m[1][1], muu.m[2][2]}, {muu.m[1][2], muu.m[0][2], muu.m[0][1]}};
    const Quat<T> p = w.f.region_rotation[r];
    fit[r] = physics::fit_region<double>(s, {static_cast<double>(p.w), static_cast<double>(p.x),
                                             static_cast<double>(p.y), static_cast<double>(p.z)});
    fit[r].velocity += v[r];
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!moves(i)) continue;
    Vec3d displacement{}, defect{};
    double count = 0;
    each_member(b, masks, i, [&](std::uint32_t r, Vec3d q) {
      const Vec3d u = between(b, x[i], x[r]);
      displacement += rotate(fit[r].rotation, q * -1.0) + fit[r].anchor - u;
      defect += fit[r].velocity + cross(fit[r].spin, u) - v[i];
      count += 1;
    });
    const Vec3d wanted = displacement * (1 / count) + defect * (dt / count);
    const Vec3d got = cast<double>(w.f.shape_velocity[i]) * dt;
    found.worst = std::max(found.worst, finite(got) ? length(got - wanted) / dx : 1e30);
  }
  return found;
}

/// What may not be read before it is written.
template <class T>
void poison(const Rig<T>& rig) {
  const core::Frame<T>& w = rig.frame();
  const T bad = std::numeric_limits<T>::quiet_NaN();
  const Vec4<T> nothing{bad, bad, bad, bad};
  std::fill(w.f.region_fit, w.f.region_fit + std::uint64_t{4} * w.vertices, nothing);
  if (w.f.region_rows != nullptr)
    std::fill(w.f.region_rows, w.f.region_rows + std::uint64_t{7} * w.vertices, nothing);
}

template <class T>
void match_shapes(Rig<T>& rig) {
  rig.run({"step.begin", "spatial", "lsm.gather", "lsm.regions", "lsm.goals"}, dt);
}

/// Rounding of what is compared [dx]: goals are up to 8 sqrt(3) dx away, where rotations good to 1e-7 leave
/// 1e-6 in single precision (found: 3e-7 at w = 3; in double 3e-15 at w = 8). A wrong term is 1e-3 at least.
template <class T>
constexpr double tolerance = sizeof(T) == 8 ? 2e-14 : 5e-6;

template <class T>
Found found_in(const Bodies& b, Order order = Order::forward) {
  Rig<T> rig(order);
  rig.upload(b.constants, b.lattice, b.state, facts);
  match_shapes(rig);
  poison(rig);
  match_shapes(rig);
  return compare(rig, b);
}

template <class T>
class Rows : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Rows, Scalars);

std::vector<Vec3i> without(std::vector<Vec3i> points, const std::vector<Vec3i>& gone) {
  const auto is_gone = [&](const Vec3i& p) {
    return std::any_of(gone.begin(), gone.end(),
                       [&](const Vec3i& g) { return p.x == g.x && p.y == g.y && p.z == g.z; });
  };
  points.erase(std::remove_if(points.begin(), points.end(), is_gone), points.end());
  return points;
}

// 2w+2 sites along one axis at least, so that whole regions share rows.
TYPED_TEST(Rows, WholeBodiesEqualSumsOverMembers) {
  using T = TypeParam;
  struct Case {
    int w;
    std::vector<Vec3i> points;
    std::uint64_t whole;
  };
  for (const Case& c : {Case{1, block(5, 4, 3), 6}, Case{2, block(8, 7, 6), 24}, Case{3, block(9, 7, 8), 6},
                        Case{4, block(10, 9, 9), 2}, Case{8, block(18, 17, 17), 2}}) {
    SCOPED_TRACE("w " + std::to_string(c.w));
    Random random(71);
    Bodies b;
    b.add(c.points, c.w);
    b.shake(random);
    const Found f = found_in<T>(b);
    EXPECT_EQ(f.whole, c.whole);
    // Nobody is missing but outside the block.
    EXPECT_EQ(f.boxed, c.w < least_width(b) ? 0u : c.points.size());
    EXPECT_LE(f.worst, tolerance<T>);
  }
}

// A site missing inside and a cut halfway through: regions about them are not whole, some of their rows are.
TYPED_TEST(Rows, BodiesWithGapsEqualSumsOverMembers) {
  using T = TypeParam;
  std::vector<Vec3i> cut;
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 8; ++y) cut.push_back({9, y, z});
  for (const int w : {2, 3}) {
    SCOPED_TRACE("w " + std::to_string(w));
    Random random(72);
    Bodies b;
    b.add(without(without(block(18, 8, 9), {{3, 3, 3}, {14, 0, 4}}), cut), w);
    b.shake(random);
    const Found f = found_in<T>(b);
    EXPECT_LE(f.worst, tolerance<T>);
    EXPECT_GT(f.whole, 5u);
    if (w < least_width(b)) continue;
    EXPECT_GT(f.boxed, f.whole + 100u);
    EXPECT_LT(f.boxed, f.whole + f.ragged - 100u);
  }
}

// Beside a curved surface rows go on where no vertex ever was: those regions are summed member by member.
TYPED_TEST(Rows, RoundBodiesEqualSumsOverMembers) {
  using T = TypeParam;
  for (const int w : {1, 2, 3}) {
    SCOPED_TRACE("w " + std::to_string(w));
    Random random(77);
    Bodies b;
    b.add(ball(6.3), w);
    b.shake(random);
    const Found f = found_in<T>(b);
    EXPECT_LE(f.worst, tolerance<T>);
    if (w < least_width(b)) continue;
    EXPECT_GT(f.boxed, f.whole + 50u);
    EXPECT_LT(f.boxed, f.whole + f.ragged - 50u);
  }
}

// Across the seam of all three axes.
TYPED_TEST(Rows, PeriodicBodiesEqualSumsOverMembers) {
  using T = TypeParam;
  for (const int w : {2, 3}) {
    SCOPED_TRACE("w " + std::to_string(w));
    Random random(73);
    Bodies b;
    b.add(block(8, 8, 7), w);
    b.shake(random);
    b.wrap({3.2, 3.3, 3.4});
    const Found f = found_in<T>(b);
    EXPECT_GE(f.whole, 4u);
    EXPECT_LE(f.worst, tolerance<T>);
  }
}

// Widths of their own, one body that does not move.
TYPED_TEST(Rows, SeveralBodiesEqualSumsOverMembers) {
  using T = TypeParam;
  Random random(74);
  Bodies b;
  b.add(block(6, 6, 6), 2);
  b.add(block(4, 4, 4), 1);
  b.add(block(6, 6, 6), 2, true);
  b.add(block(7, 8, 7), 3);
  b.add({{0, 0, 0}}, 2);
  b.shake(random);
  const Found f = found_in<T>(b);
  EXPECT_EQ(f.whole, 8u + 8u + 2u);
  EXPECT_LE(f.worst, tolerance<T>);
}

// Regions stop being whole, and their rows with them, where something has melted.
TYPED_TEST(Rows, WhatMeltsIsInNoRow) {
  using T = TypeParam;
  Random random(75);
  Bodies b;
  b.add(block(12, 9, 9), 2);
  b.shake(random);
  Rig<T> rig;
  rig.upload(b.constants, b.lattice, b.state,
             facts | core::fact_fluid | core::fact_contact | core::fact_melt);
  std::uint64_t whole = 1000;
  for (int round = 0; round < 3; ++round) {
    match_shapes(rig);
    const Found f = compare(rig, b);
    EXPECT_LT(f.whole, whole);
    EXPECT_GT(f.whole, 5u);
    EXPECT_LE(f.worst, tolerance<T>) << round;
    whole = f.whole;
    poison(rig);
    const core::Frame<T>& w = rig.frame();
    for (int k = 0; k < 8; ++k) {  // solid at 0 J/kg is all liquid; those inside stay
      const std::uint32_t v = random.below(w.vertices);
      w.f.enthalpy[w.f.slot_of_id[w.f.vertex_id[v]]] = 1.0;
    }
    rig.run({"step.begin", "spatial", "spatial.neighbours", "topology"}, dt);
    // What has melted flows away: sums relative to where it is now would be good to nothing.
    for (std::uint32_t v = 0; v < w.vertices; ++v)
      if (w.f.vertex_state[v] != 1u) w.f.position[w.f.slot_of_id[w.f.vertex_id[v]]].x = T(1000 * dx);
    // Regions follow at the beginning of the next sub-step.
    rig.run({"step.begin", "spatial", "spatial.neighbours", "topology.regions"}, dt);
  }
}

// The same bits in whatever order vertices come.
TYPED_TEST(Rows, OrderChangesNoBit) {
  using T = TypeParam;
  Random random(76);
  Bodies b;
  b.add(without(block(9, 8, 7), {{2, 2, 2}}), 2);
  b.shake(random);
  std::vector<Vec3<T>> first;
  for (const Order order : {Order::forward, Order::reversed, Order::shuffled}) {
    Rig<T> rig(order);
    rig.upload(b.constants, b.lattice, b.state, facts);
    match_shapes(rig);
    const core::Frame<T>& w = rig.frame();
    const std::vector<Vec3<T>> now(w.f.shape_velocity, w.f.shape_velocity + w.vertices);
    if (first.empty()) first = now;
    for (std::size_t i = 0; i < now.size(); ++i)
      ASSERT_TRUE(now[i].x == first[i].x && now[i].y == first[i].y && now[i].z == first[i].z) << i;
  }
}

// Seven planes where a body is wide enough for rows, else not one byte.
TYPED_TEST(Rows, HaveMemoryOnlyWhereTheyAreSummed) {
  using T = TypeParam;
  for (const int w : {0, 1, 2, 3}) {
    Bodies b;
    b.add(block(6, 5, 4), w);
    Rig<T> rig;
    rig.upload(b.constants, b.lattice, b.state, facts);
    EXPECT_EQ(rig.engine->channel_bytes(core::field_region_rows),
              w < least_width(b) ? 0u : 120u * 28u * sizeof(T))
        << w;
    EXPECT_EQ(rig.engine->channel_bytes(core::field_ragged), 0u);  // this executor makes no lists
  }
}

}  // namespace
}  // namespace modules_test
