// SPDX-License-Identifier: Apache-2.0
#include "meltsim/physics/contact.hpp"

#include <gtest/gtest.h>

#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

constexpr double dt = 1e-3, mass = 8, friction = 0.3;

Vec3<double> unit(Vec3<double> v) { return v * (1 / length(v)); }

// Coulomb's bound with 1e-12 of rounding; never pulls, never feeds the sliding.
TEST(Contact, RepelsAndSlidesWithinCoulombsBound) {
  Random random(61);
  int slipping = 0, sticking = 0;
  for (int n = 0; n < 20000; ++n) {
    const Vec3<double> normal = unit(random.vector() + Vec3<double>{0, 0, 1e-3});
    const Vec3<double> v = random.vector(std::pow(10.0, random.uniform(-4, 2)));
    const double overlap = std::pow(10.0, random.uniform(-6, -1));
    const Vec3<double> f = contact_force(overlap, normal, v, mass, friction, dt);
    const double fn = dot(f, normal);
    const Vec3<double> ft = f - normal * fn, vt = v - normal * dot(v, normal);
    ASSERT_GE(fn, -1e-9);
    ASSERT_LE(length(ft), friction * fn * (1 + 1e-12) + 1e-9);
    ASSERT_LE(dot(ft, vt), 1e-9);
    (length(ft) > 0.999 * friction * fn ? slipping : sticking) += 1;
  }
  EXPECT_GT(slipping, 1000);
  EXPECT_GT(sticking, 100);
}

// At the edge of contact only an approach meets resistance; something that leaves is not held.
TEST(Contact, NothingWithoutOverlapOrApproach) {
  const Vec3<double> up{0, 0, 1};
  EXPECT_EQ(length(contact_force(0.0, up, Vec3<double>{}, mass, friction, dt)), 0.0);
  EXPECT_EQ(length(contact_force(0.0, up, Vec3<double>{3, 0, 1}, mass, friction, dt)), 0.0);
  EXPECT_EQ(length(contact_force(1e-4, up, Vec3<double>{3, 0, 10}, mass, friction, dt)), 0.0);
  EXPECT_GT(dot(contact_force(0.0, up, Vec3<double>{0, 0, -1}, mass, friction, dt), up), 0.0);
}

// k = 0.15 m/dt^2 and c = 2 * 0.5 sqrt(0.15) m/dt; sqrt(kappa) is given with ten digits.
TEST(Contact, SpringAndDashpot) {
  const Vec3<double> up{0, 0, 1};
  const double k = 0.15 * mass / (dt * dt), c = std::sqrt(0.15) * mass / dt;
  EXPECT_NEAR(contact_force(0.01, up, Vec3<double>{}, mass, friction, dt).z / (k * 0.01), 1.0, 1e-12);
  EXPECT_NEAR(contact_force(0.01, up, Vec3<double>{0, 0, -2}, mass, friction, dt).z / (k * 0.01 + 2 * c), 1.0,
              1e-9);
}

// A step far shorter than the one that springs go by has the forces of that one.
TEST(Contact, SpringsGoByTheirOwnStep) {
  const Vec3<double> up{0, 0, 1}, v{0.1, 0, -0.2}, slip{1e-9, 0, 0};
  const auto usual = contact_response(body_contact<double>(), 0.01, up, v, {}, mass, friction, dt, dt);
  const auto brief = contact_response(body_contact<double>(), 0.01, up, v, slip, mass, friction, 1e-9, dt);
  EXPECT_DOUBLE_EQ(brief.force.z, usual.force.z);
  EXPECT_NEAR(brief.slip.x, 1e-9 + 1e-10, 1e-15);
}

// Static friction. A particle pressed on a plane and pushed along it by less than friction holds stops at the
// spring's balance, force/(0.2 m/dt^2), and stays: no creep over 1e5 steps. Pushed by more it slides off with
// what is left of the push, to rounding and the first steps.
TEST(Contact, HoldsWhatFrictionCanHoldAndNothingMore) {
  const Vec3<double> up{0, 0, 1};
  const double press = 0.01 * 0.4 * mass / (dt * dt);  // normal force of an overlap of 1 cm
  for (const double share : {0.5, 1.5}) {
    const Vec3<double> push{share * friction * press, 0, 0};
    Vec3<double> x{}, v{}, slip{};
    for (int n = 0; n < (share < 1 ? 100000 : 100); ++n) {
      x += v * (0.5 * dt);
      const auto r = contact_response(body_contact<double>(), 0.01, up, v, slip, mass, friction, dt, dt);
      v += (push + Vec3<double>{r.force.x, r.force.y, 0}) * (dt / mass);
      x += v * (0.5 * dt);
      slip = r.slip;
    }
    if (share < 1) {
      const double balance = push.x / (0.2 * mass / (dt * dt));
      EXPECT_NEAR(x.x / balance, 1, 1e-9);
      EXPECT_LT(length(v) * dt, 1e-9 * balance);
    } else {
      EXPECT_NEAR(v.x / (0.5 * friction * press / mass * 100 * dt), 1, 0.05);
      EXPECT_LE(length(slip), friction * press / (0.2 * mass / (dt * dt)) * (1 + 1e-12));
    }
  }
}

// What one gets the other loses, bit for bit.
TEST(Contact, ResponseIsOdd) {
  Random random(63);
  for (int n = 0; n < 1000; ++n) {
    const Vec3<float> normal = cast<float>(unit(random.vector() + Vec3<double>{0, 0, 1e-3}));
    const Vec3<float> v = cast<float>(random.vector()), slip = cast<float>(random.vector(1e-3));
    const auto a = contact_response(body_contact<float>(), 0.01f, normal, v, slip, 8.0f, 0.3f, 1e-3f, 1e-3f);
    const auto b =
        contact_response(body_contact<float>(), 0.01f, -normal, -v, -slip, 8.0f, 0.3f, 1e-3f, 1e-3f);
    ASSERT_TRUE(a.force.x == -b.force.x && a.force.y == -b.force.y && a.force.z == -b.force.z);
    ASSERT_TRUE(a.slip.x == -b.slip.x && a.slip.y == -b.slip.y && a.slip.z == -b.slip.z);
  }
}

// Slow sliding is braked by tau m/dt, not by the full Coulomb force: 0.1 of the speed per step, no reversal.
TEST(Contact, SlowSlidingIsDamped) {
  const Vec3<double> f =
      contact_force(0.01, Vec3<double>{0, 0, 1}, Vec3<double>{1e-6, 0, 0}, mass, friction, dt);
  EXPECT_NEAR(f.x * dt / mass, -1e-7, 1e-18);
}

// A particle that falls on the face of a fixed lattice touches up to four or five of its points at once: the
// case the stiffness was chosen for. Leap-frog; it must not gain energy (5 %: overlap and fall between the
// points) and must end at rest, a few steps of gravity at most.
TEST(Contact, ManyContactsAreStable) {
  Random random(62);
  for (int trial = 0; trial < 50; ++trial) {
    Vec3<double> x{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 0.2}, v{0, 0, -1};
    for (int n = 0; n < 4000; ++n) {
      x += v * (0.5 * dt);
      Vec3<double> force{0, 0, -9.81 * mass};
      for (int a = -4; a <= 4; ++a)
        for (int b = -4; b <= 4; ++b) {
          const Vec3<double> d = x - Vec3<double>{0.2 * a, 0.2 * b, 0};
          const double r = length(d);
          if (r < 0.2) force += contact_force(0.2 - r, d * (1 / r), v, mass, friction, dt);
        }
      v += force * (dt / mass);
      x += v * (0.5 * dt);
      const double energy = 0.5 * dot(v, v) + 9.81 * (x.z - 0.2);
      ASSERT_LT(energy, 0.5 * 1.05 + 0.01) << trial << ", step " << n;
    }
    EXPECT_LT(length(v), 0.05) << trial;
    EXPECT_GT(x.z, 0.1) << trial;  // not pressed through
  }
}

/// Mask of a vertex whose neighbours with `keep` are there.
template <class Keep>
std::uint32_t mask_of(const Keep& keep) {
  std::uint32_t mask = 0;
  for (int bit = 0; bit < 27; ++bit)
    if (keep(bit % 3 - 1, bit / 3 % 3 - 1, bit / 9 - 1)) mask |= 1u << bit;
  return mask;
}

Mat3<double> quarter_turn() {  // about z: x to y
  Mat3<double> r;
  r.m[0][1] = -1;
  r.m[1][0] = r.m[2][2] = 1;
  return r;
}

TEST(SurfaceNormal, PointsOutOfFaceEdgeAndCorner) {
  const auto normal = [](std::uint32_t m) { return surface_normal(m, identity3<double>()); };
  const Vec4<double> face = normal(mask_of([](int x, int, int) { return x <= 0; }));
  EXPECT_LE(length(xyz(face) - Vec3<double>{1, 0, 0}), 1e-15);
  EXPECT_EQ(face.w, 18.0);
  const Vec4<double> edge = normal(mask_of([](int x, int y, int) { return x <= 0 && y >= 0; }));
  EXPECT_LE(length(xyz(edge) - unit({1, -1, 0})), 1e-15);
  const Vec4<double> corner = normal(mask_of([](int x, int y, int z) { return x <= 0 && y <= 0 && z <= 0; }));
  EXPECT_LE(length(xyz(corner) - unit({1, 1, 1})), 1e-15);
  EXPECT_EQ(corner.w, 8.0);
  const auto turned = surface_normal(mask_of([](int x, int, int) { return x <= 0; }), quarter_turn());
  EXPECT_LE(length(xyz(turned) - Vec3<double>{0, 1, 0}), 1e-15);
}

// Inside, a sheet, a single vertex: no direction is outside more than its opposite.
TEST(SurfaceNormal, ZeroWhereBothSidesAreAlike) {
  for (const std::uint32_t m : {mask_of([](int, int, int) { return true; }),
                                mask_of([](int, int y, int) { return y == 0; }), 1u << 13})
    EXPECT_EQ(length(xyz(surface_normal(m, identity3<double>()))), 0.0);
}

// 20 direct neighbours as built: one more or less, and the lattice says how the surface lies.
TEST(BuiltNormal, HoldsWhileNeighboursAreAsBuilt) {
  const Vec3<double> n = unit(Vec3<double>{1, 2, -2});
  const auto turn = to_matrix(Quat<double>{std::cos(0.3), 0, std::sin(0.3), 0});
  for (const double mark : {0.0, curved_mark}) {
    const auto face = with_w(n * (20 + mark), 0.1), edge = with_w(n * (20 + mark), -0.1);
    EXPECT_TRUE(is_as_built(face, 20.0));
    EXPECT_FALSE(is_as_built(face, 19.0));
    EXPECT_FALSE(is_as_built(face, 21.0));
    const auto there = built_normal(face, 20.0, turn);
    EXPECT_LT(length(xyz(there) - turn * n), 1e-15);
    EXPECT_EQ(there.w, mark > 0 ? neighbours_of_curved : neighbours_of_plane);
    EXPECT_EQ(built_normal(edge, 20.0, turn).w, neighbours_of_edge);
    EXPECT_EQ(flatness(there.w), mark > 0 ? 0 : 1);
    EXPECT_EQ(flatness(neighbours_of_edge), 0);
  }
  EXPECT_FALSE(is_as_built(Vec4<double>{0, 0, 0, 0.5}, 0.0));
  EXPECT_FALSE(is_as_built(Vec4<double>{0, 0, 0, 0.5}, 18.0));
}

// Of neighbours below an oblique plane that are deformed alike: at right angles to what lies along the surface, and out of it.
TEST(BuiltNormal, FollowsASurfaceThatDeforms) {
  Random random(65);
  for (int k = 0; k < 200; ++k) {
    const Vec3<double> n = unit(random.vector() + Vec3<double>{0, 0, 1e-3});
    Mat3<double> f = identity3<double>();
    add_outer(f, 0.5, random.vector(), random.vector());
    if (!(determinant(f) > 0.2)) continue;
    Mat3<double> moved, built;
    for (int bit = 0; bit < 27; ++bit) {
      const Vec3<double> d{double(bit % 3 - 1), double(bit / 3 % 3 - 1), double(bit / 9 - 1)};
      if (dot(d, n) > 0.3) continue;
      add_outer(moved, 1.0, f * d, d);
      add_outer(built, 1.0, d, d);
    }
    const Vec3<double> there = unit(deformed_normal(moved, built, n));
    const Vec3<double> along = unit(cross(n, Vec3<double>{0.3, -0.5, 0.8})), across = cross(n, along);
    EXPECT_LT(std::fabs(dot(there, f * along)), 1e-12);
    EXPECT_LT(std::fabs(dot(there, f * across)), 1e-12);
    EXPECT_GT(dot(there, f * n), 0);
  }
}

TEST(ContactGeometry, AntisymmetricToTheBit) {
  Random random(63);
  for (int n = 0; n < 20000; ++n) {
    const auto direction = [&] {
      const auto live = static_cast<float>(8 + random.below(12));  // corners, edges, steps, faces; some equal
      if (random.below(4) == 0) return with_w(Vec3<float>{}, live);
      return with_w(cast<float>(unit(random.vector() + Vec3<double>{0, 0, 1e-3})), live);
    };
    const Vec4<float> a = direction(), b = direction();
    const auto x = cast<float>(random.vector(0.2)) + Vec3<float>{0, 0, 1e-4f};
    const auto i = contact_geometry(a, b, x, dot(x, x), 0.2f),
               j = contact_geometry(b, a, -x, dot(x, x), 0.2f);
    ASSERT_TRUE(i.normal.x == -j.normal.x && i.normal.y == -j.normal.y && i.normal.z == -j.normal.z);
    ASSERT_EQ(i.overlap, j.overlap);
    ASSERT_EQ(i.weight, j.weight);
    ASSERT_NEAR(length(i.normal), 1.0, 1e-6);
  }
}

// Two flat faces 0.9 dx apart, shifted sideways at random: every pair has the faces' normal and the overlap
// of the faces, and the shares of a particle sum to 1 (at the worst shift, half a cell both ways, 1.17).
TEST(ContactGeometry, FacesTouchAsPlanes) {
  Random random(64);
  const double dx = 0.2;
  const Vec4<double> up{0, 0, 1, 18}, down{0, 0, -1, 18};
  for (int n = 0; n < 1000; ++n) {
    const double sx = random.uniform(), sy = random.uniform();
    double weight = 0;
    for (int a = -3; a <= 3; ++a)
      for (int b = -3; b <= 3; ++b) {
        const Vec3<double> x{(a + sx) * dx, (b + sy) * dx, 0.9 * dx};
        const auto g = contact_geometry(down, up, x, dot(x, x), dx);
        ASSERT_LE(length(g.normal - Vec3<double>{0, 0, 1}), 1e-14);
        ASSERT_NEAR(g.overlap, 0.1 * dx, 1e-14);
        weight += maximum(g.weight, 0.0);
      }
    ASSERT_GT(weight, 0.9);
    ASSERT_LT(weight, 1.18);
  }
  const auto aligned = contact_geometry(down, up, Vec3<double>{0, 0, dx}, dx * dx, dx);
  EXPECT_NEAR(aligned.overlap, 0.0, 1e-16);
  EXPECT_NEAR(aligned.weight, 1.0, 1e-7);  // a root of rounding
}

// The flatter one, with more neighbours, has the say; without normals it is the line of centres.
TEST(ContactGeometry, TheFlatterDecides) {
  const Vec4<double> face{0, 0, 1, 18}, corner{-0.6, 0, -0.8, 8}, none{0, 0, 0, 1};
  const Vec3<double> x{0.05, 0, 0.15};
  const double r2 = dot(x, x);
  EXPECT_LE(length(contact_geometry(corner, face, x, r2, 0.2).normal - xyz(face)), 1e-15);
  EXPECT_LE(length(contact_geometry(none, face, x, r2, 0.2).normal - xyz(face)), 1e-15);
  EXPECT_LE(length(contact_geometry(corner, none, x, r2, 0.2).normal + xyz(corner)), 1e-15);
  EXPECT_LE(length(contact_geometry(none, none, x, r2, 0.2).normal - unit(x)), 1e-15);
  EXPECT_EQ(contact_geometry(none, face, Vec3<double>{0, 0, -0.15}, 0.0225, 0.2).overlap, 0.0);  // far side
}

// Where edges and corners alone meet, nothing overlaps at a spacing, whichever way they point, and the particles of two edges that
// bound the faces that touch have those faces' normal.
TEST(ContactGeometry, EdgesDoNotOverlapAtASpacing) {
  const double dx = 0.2, e = std::sqrt(0.5), c = std::sqrt(1.0 / 3);
  const std::vector<Vec4<double>> points{
      {e, e, 0, 12}, {-e, e, 0, 12}, {0, -e, e, 12}, {-c, c, -c, 8}, {c, c, c, 8}};
  for (const auto& a : points)
    for (const auto& b : points)
      for (const Vec3<double>& x :
           {Vec3<double>{dx, 0, 0}, Vec3<double>{0, dx, 0}, Vec3<double>{0, 0, -dx}}) {
        const auto g = contact_geometry(a, b, x, dot(x, x), dx);
        if (dot(x, g.normal) > 0) {
          EXPECT_NEAR(g.overlap, 0, 1e-15);
        }
      }
  const auto flush = contact_geometry(points[1], points[0], Vec3<double>{0.9 * dx, 0, 0}, 0.81 * dx * dx, dx);
  EXPECT_LE(length(flush.normal - Vec3<double>{1, 0, 0}), 1e-15);
  EXPECT_NEAR(flush.overlap, 0.1 * dx, 1e-15);
}

// Particles around a vertex, itself among them: 18 of 27 on a plane, 17 on one oblique to all axes, 12 at a right edge.
TEST(ContactGeometry, APlaneIsAFaceInAnyDirection) {
  for (const double live : {17, 18, 20, 27}) EXPECT_EQ(flatness(live), 1) << live;
  for (const double live : {1, 8, 12, 15}) EXPECT_EQ(flatness(live), 0) << live;
}

// A column of n particles comes to rest on a wall: with the dashpot of its lowest particle alone it presses that in by nearly twice
// what stays, which is a tenth of a spacing at the longest step that is allowed.
TEST(Contact, AColumnPressesInATenthOfASpacing) {
  constexpr double dx = 0.05, g = 9.81;
  for (const int n : {4, 16, 64}) {
    const double dt_s = standing_dt(dx, g, n * dx), dt = dt_s / 50;
    double depth = 0, speed = 0, most = 0;  // downwards
    for (int k = 0; k < 400000; ++k) {
      depth += 0.5 * dt * speed;
      const double force = contact_response(body_contact<double>(), depth, Vec3<double>{0, 1, 0},
                                            Vec3<double>{0, -speed, 0}, Vec3<double>{}, 1.0, 0.0, dt, dt_s)
                               .force.y;
      speed += dt * (g - force / n);
      depth += 0.5 * dt * speed;
      most = std::max(most, depth);
    }
    EXPECT_LE(most, 0.1 * dx) << n;
    EXPECT_GE(most, 0.08 * dx) << n;
    EXPECT_NEAR(depth, 0.05 * dx, 1e-3 * dx) << n;
  }
}

TEST(Contact, ReducedMassNeverExceedsTheLighter) {
  EXPECT_DOUBLE_EQ(reduced_mass(2.0, 2.0), 1.0);
  EXPECT_DOUBLE_EQ(reduced_mass(1.0, 3.0), 0.75);
  EXPECT_LT(reduced_mass(200.0f, 10000.0f), 200.0f);
  EXPECT_EQ(reduced_mass(200.0f, 10000.0f), reduced_mass(10000.0f, 200.0f));
}

}  // namespace
