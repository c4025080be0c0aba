// SPDX-License-Identifier: Apache-2.0
// The motion of a rigid piece against Euler's equations.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "meltsim/physics/rigid_piece.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr double pi = 3.14159265358979323846;

Mat3<double> diagonal(double x, double y, double z) {
  Mat3<double> m;
  m.m[0][0] = x;
  m.m[1][1] = y;
  m.m[2][2] = z;
  return m;
}

/// Euler's equations of a free body about its principal axes, by the classical Runge-Kutta method of fourth order:
/// I1 w1' = (I2 - I3) w2 w3 and so on. Steps of 1e-4 of a turn leave 1e-14.
Vec3<double> euler(Vec3<double> inertia, Vec3<double> w, double time, int steps) {
  const auto rate = [&](Vec3<double> a) {
    return Vec3<double>{(inertia.y - inertia.z) / inertia.x * a.y * a.z,
                        (inertia.z - inertia.x) / inertia.y * a.z * a.x,
                        (inertia.x - inertia.y) / inertia.z * a.x * a.y};
  };
  const double h = time / steps;
  for (int k = 0; k < steps; ++k) {
    const Vec3<double> a = rate(w), b = rate(w + a * (h / 2)), c = rate(w + b * (h / 2)), d = rate(w + c * h);
    w += (a + b * 2.0 + c * 2.0 + d) * (h / 6);
  }
  return w;
}

/// Angular velocity in the frame of the body after `time`.
Vec3<double> turned(Vec3<double> inertia, Vec3<double> w, double time, int steps) {
  const Mat3<double> K = inverse_inertia(diagonal(inertia.x, inertia.y, inertia.z));
  const Vec3<double> L{inertia.x * w.x, inertia.y * w.y, inertia.z * w.z};  // R = 1 at first
  Quat<double> R;
  for (int k = 0; k < steps; ++k) R = turned_freely(K, R, L, time / steps);
  return K * rotate(inverse(R), L);
}

// A steady spin about an axis of inertia turns by |w| t however long the step is, up to where parts of a quarter of a
// radian run out.
TEST(RigidPiece, ASteadySpinTurnsByItsAngle) {
  const Mat3<double> K = inverse_inertia(diagonal(2, 3, 5));
  for (const double angle : {1e-9, 1e-3, 0.2, 1.0, 3.0, 10.0}) {
    const Quat<double> R = turned_freely(K, {}, {0, 3 * angle, 0}, 1.0);
    EXPECT_NEAR(R.w, std::cos(angle / 2), 1e-14 * (1 + angle)) << angle;
    EXPECT_NEAR(R.y, std::sin(angle / 2), 1e-14 * (1 + angle)) << angle;
    EXPECT_EQ(R.x, 0.0);
    EXPECT_EQ(R.z, 0.0);
  }
}

// Spun about its middle axis, a body turns over (the tennis racket). Second order: half the step leaves a quarter of the
// error. Four times the period of a turn: it has turned over by then, w.y has the other sign.
TEST(RigidPiece, AMiddleAxisTurnsOverAsEulersEquationsSay) {
  const Vec3<double> inertia{1, 2, 3}, spin{0.05, 1, 0.05};
  const double time = 8 * pi;
  const Vec3<double> exact = euler(inertia, spin, time, 40000);
  double lowest = 1;
  for (int k = 1; k <= 40; ++k) lowest = std::min(lowest, euler(inertia, spin, time * k / 40, 1000 * k).y);
  EXPECT_LT(lowest, -0.9);  // it does turn over: the test would miss nothing if it stayed
  const double coarse = length(turned(inertia, spin, time, 400) - exact),
               fine = length(turned(inertia, spin, time, 800) - exact);
  EXPECT_LT(coarse, 0.05);
  EXPECT_NEAR(coarse / fine, 4, 0.2);
}

// Energy and angular momentum of a body that tumbles for 10^5 steps of 0.03 rad: rounding of a unit quaternion, 1e-16 per
// step, adds up like a random walk to 3e-14, or at worst to 1e-11.
TEST(RigidPiece, ATumblingBodyKeepsItsEnergy) {
  const Mat3<double> K = inverse_inertia(diagonal(1, 2, 3));
  const Vec3<double> L{0.6, 2.0, -0.9};
  Quat<double> R{0.5, 0.5, -0.5, 0.5};
  const auto energy = [&] { return 0.5 * dot(L, rotate(R, K * rotate(inverse(R), L))); };
  const double before = energy();
  double worst = 0;
  for (int k = 0; k < 100000; ++k) {
    R = turned_freely(K, R, L, 0.03);
    worst = std::max(worst, std::fabs(energy() / before - 1));
  }
  EXPECT_LT(worst, 1e-11);
}

// The rule is symmetric in time: back and forth is where it was.
TEST(RigidPiece, GoesBackTheWayItCame) {
  const Mat3<double> K = inverse_inertia(diagonal(1, 2, 3));
  const Vec3<double> L{0.6, 2.0, -0.9};
  const Quat<double> R = turned_freely(K, turned_freely(K, {}, L, 0.2), L, -0.2);
  EXPECT_NEAR(R.w, 1, 1e-14);
  EXPECT_LT(std::fabs(R.x) + std::fabs(R.y) + std::fabs(R.z), 1e-14);
}

/// Particles of a piece: a box of lattice points with unequal masses.
struct Points {
  std::vector<double> mass;
  std::vector<Vec3<double>> q, u, v, kicked;
};
RigidPieceSums sums_of(const Points& p) {
  RigidPieceSums s;
  for (std::size_t i = 0; i < p.mass.size(); ++i) {
    const double m = p.mass[i];
    s.mass += m;
    s.first += p.u[i] * m;
    s.rest_first += p.q[i] * m;
    add_outer(s.rest_second, m, p.q[i], p.q[i]);
    s.momentum += p.v[i] * m;
    s.spin += cross(p.u[i], p.v[i]) * m;
    s.kicked_momentum += p.kicked[i] * m;
    s.kicked_spin += cross(p.u[i], p.kicked[i]) * m;
  }
  return s;
}
Points box(int nx, int ny, int nz) {
  Points p;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        p.mass.push_back(1 + 0.1 * x + 0.03 * y * z);
        p.q.push_back({0.1 * x, 0.1 * y, 0.1 * z});
        const double k = static_cast<double>(p.mass.size());
        p.u.push_back(p.q.back() + Vec3<double>{0.3, -0.2, 0.1});
        p.v.push_back({std::sin(k), std::cos(2 * k), std::sin(3 * k)});  // not a rigid motion
        p.kicked.push_back(p.v.back() + Vec3<double>{std::cos(k), std::sin(5 * k), 0.3});
      }
  return p;
}

// Whatever particles did, the piece leaves with their momentum and their angular momentum about the reference point, and
// its centre has moved on by half a step. A row, a plane and a single particle have singular inertias: of those the
// angular momentum about an axis without inertia is none of theirs, so the velocities are made rigid motions first.
TEST(RigidPiece, HasTheMomentaOfItsParticles) {
  for (const std::array<int, 3> n : {std::array<int, 3>{4, 3, 2}, {5, 4, 1}, {6, 1, 1}, {1, 1, 1}}) {
    SCOPED_TRACE(n[0] * 100 + n[1] * 10 + n[2]);
    Points p = box(n[0], n[1], n[2]);
    const bool singular = n[1] == 1;
    if (singular)
      for (std::size_t i = 0; i < p.mass.size(); ++i) {
        p.v[i] = {1, 2, 3};
        p.kicked[i] = Vec3<double>{3, 1, -1} + cross(Vec3<double>{0, 2, 1}, p.u[i]);
      }
    const RigidPieceSums s = sums_of(p);
    const double dt = 0.01;
    const RigidPieceStep step = rigid_step(s, {}, dt);
    Vec3<double> momentum{}, spin{}, first{};
    for (std::size_t i = 0; i < p.mass.size(); ++i) {
      const RigidPoint x = point_of(step, p.q[i]);
      momentum += x.velocity * p.mass[i];
      first += x.position * p.mass[i];
      spin += cross(x.position, x.velocity) * p.mass[i];
    }
    const double scale = s.mass * 3;
    EXPECT_LT(length(momentum - s.kicked_momentum), 1e-14 * scale);
    EXPECT_LT(length(first - (s.first + s.kicked_momentum * (0.5 * dt))), 1e-14 * scale);
    // The drift of the centre along P' changes nothing of it.
    EXPECT_LT(length(spin - s.kicked_spin), 1e-13 * scale);
    for (std::size_t i = 1; i < p.q.size(); ++i)
      EXPECT_NEAR(length(point_of(step, p.q[i]).position - point_of(step, p.q[0]).position),
                  length(p.q[i] - p.q[0]), 1e-15);
  }
}

// The kick is in the middle: it turns for half of the time at the spin before, for half at the spin after. A box of equal
// masses about z, one of its axes: rounding alone.
TEST(RigidPiece, TurnsHalfOfTheTimeAtEachSpin) {
  Points p = box(4, 3, 2);
  for (std::size_t i = 0; i < p.mass.size(); ++i) {
    p.mass[i] = 1;
    p.v[i] = cross(Vec3<double>{0, 0, 3}, p.u[i]);
    p.kicked[i] = cross(Vec3<double>{0, 0, 7}, p.u[i]);
  }
  const RigidPieceStep step = rigid_step(sums_of(p), {}, 0.02);
  EXPECT_NEAR(rotation_vector(step.rotation).z, 0.1, 1e-14);
  EXPECT_NEAR(step.angular_velocity.z, 7, 1e-12);
}

// A row of particles does not turn about itself, a single one not at all, nothing is nothing.
TEST(RigidPiece, HasNoSpinWithoutInertia) {
  Points row = box(6, 1, 1);
  for (std::size_t i = 0; i < row.mass.size(); ++i) row.v[i] = row.kicked[i] = {1, 0, 0};
  RigidPieceSums s = sums_of(row);
  s.kicked_spin += {7, 0, 0};
  EXPECT_LT(length(rigid_step(s, {}, 0.01).angular_velocity), 1e-12);
  const RigidPieceStep one = rigid_step(sums_of(box(1, 1, 1)), {}, 0.01);
  EXPECT_EQ(length(one.angular_velocity), 0.0);
  EXPECT_EQ(one.rotation.w, 1.0);
  const RigidPieceStep nothing = rigid_step({}, {}, 0.01);
  EXPECT_EQ(nothing.mass, 0.0);
  EXPECT_EQ(nothing.rotation.w, 1.0);
}

}  // namespace
