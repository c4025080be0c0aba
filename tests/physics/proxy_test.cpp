// SPDX-License-Identifier: Apache-2.0
// A proxy against motions known in closed form and Euler's equations by another method.
#include <gtest/gtest.h>

#include <cmath>

#include "meltsim/physics/proxy.hpp"

namespace meltsim {
namespace {

using physics::RigidMotion;
using physics::RigidPieceStep;

Mat3<double> diagonal(double x, double y, double z) {
  Mat3<double> a;
  a.m[0][0] = x;
  a.m[1][1] = y;
  a.m[2][2] = z;
  return a;
}

/// n sub-steps of dt under a constant force [N] and torque [N m].
RigidMotion moved(RigidMotion m, double mass, const Mat3<double>& inertia, Vec3<double> force,
                  Vec3<double> torque, Vec3<double> gravity, double dt, int n) {
  // A reference vertex away from the centre: where it is may not matter.
  const Vec3<double> rest{0.3, -0.2, 0.5};
  for (int k = 0; k < n; ++k) {
    const RigidPieceStep s =
        physics::proxy_step(mass, inertia, rest, m, force * dt, torque * dt, gravity, k * dt, dt);
    m = physics::proxy_after(m, s, k * dt, dt);
  }
  return m;
}

// x = v t + (F/M + g + a) t^2/2: drift, kick, drift is exact for a constant force. 1000 roundings of metres: 1e-12.
TEST(Proxy, FollowsAParabolaUnderAConstantForce) {
  RigidMotion m;
  m.first.velocity = {1, -2, 0.5};
  m.then.position = {0, 3, 0};  // the host's acceleration
  const RigidMotion end = moved(m, 2, diagonal(1, 1, 1), {4, 0, -2}, {}, {0, -10, 0}, 1e-3, 1000);
  EXPECT_NEAR(end.first.position.x, 1 + 0.5 * 2, 1e-12);
  EXPECT_NEAR(end.first.position.y, -2 + 0.5 * (3 - 10), 1e-12);
  EXPECT_NEAR(end.first.position.z, 0.5 + 0.5 * -1, 1e-12);
  EXPECT_NEAR(end.first.velocity.y, -2 + 3 - 10, 1e-12);
  EXPECT_NEAR(end.from, 1, 1e-12);
}

// About a principal axis: w = T t/I, the angle T t^2/(2 I), exactly, for the same reason.
TEST(Proxy, SpinsUpUnderAConstantTorque) {
  const RigidMotion end = moved({}, 2, diagonal(1, 2, 2.5), {}, {0, 0, 1.5}, {}, 1e-3, 1000);
  const double angle = 0.5 * 1.5 / 2.5;
  EXPECT_NEAR(end.first.angular_velocity.z, 1.5 / 2.5, 1e-12);
  EXPECT_NEAR(end.first.orientation.w, std::cos(angle / 2), 1e-12);
  EXPECT_NEAR(end.first.orientation.z, std::sin(angle / 2), 1e-12);
}

// A free body of three different moments tumbles as Euler's equations say. The rule is of second order: at half the step the
// error is a quarter, and at 1e-3 s and some 3 rad/s (w dt)^2 w t/12 = 1e-5.
TEST(Proxy, TumblesAsEulersEquationsSay) {
  const Vec3<double> inertia{1, 2, 2.5};
  const auto rate = [&](Vec3<double> w) {
    return Vec3<double>{(inertia.y - inertia.z) / inertia.x * w.y * w.z,
                        (inertia.z - inertia.x) / inertia.y * w.z * w.x,
                        (inertia.x - inertia.y) / inertia.z * w.x * w.y};
  };
  Vec3<double> w{0.1, 3, 0.2};
  constexpr int fine = 20000;
  constexpr double time = 2, h = time / fine;
  for (int k = 0; k < fine; ++k) {  // classical Runge-Kutta, in the frame of the body
    const auto a = rate(w), b = rate(w + a * (h / 2)), c = rate(w + b * (h / 2)), d = rate(w + c * h);
    w += (a + b * 2.0 + c * 2.0 + d) * (h / 6);
  }
  double error[2];
  for (int k = 0; k < 2; ++k) {
    RigidMotion m;
    m.first.angular_velocity = {0.1, 3, 0.2};
    const int n = k == 0 ? 2000 : 4000;
    m = moved(m, 2, diagonal(inertia.x, inertia.y, inertia.z), {}, {}, {}, time / n, n);
    error[k] = length(rotate(inverse(m.first.orientation), m.first.angular_velocity) - w);
  }
  EXPECT_LT(error[0], 2e-5);
  EXPECT_GT(error[0], 1e-12) << "nothing was compared";
  EXPECT_NEAR(error[0] / error[1], 4, 0.2);
}

// The gap to the host's pose closes in its step, whatever sub-steps that has, and adds no velocity; a jump leaves none.
TEST(Proxy, ClosesTheGapToItsHost) {
  RigidMotion now, host;
  now.first.position = {1, 2, 3};
  host.until = 0.01;
  host.first.position = {1.1, 2, 2.9};
  host.first.orientation = {std::cos(0.2), std::sin(0.2), 0, 0};
  for (const int n : {1, 3, 7, 20}) {  // 20: twice as long as the step
    const RigidMotion set = physics::proxy_set(now, host, false, 1, 1e3, {});
    EXPECT_EQ(length(set.first.position - now.first.position), 0);
    const RigidMotion end = moved(set, 2, diagonal(1, 1, 1), {}, {}, {}, n == 20 ? 0.001 : 0.01 / n, n);
    EXPECT_LT(length(end.first.position - host.first.position), 1e-14);
    EXPECT_NEAR(end.first.orientation.x, std::sin(0.2), 1e-14);
    EXPECT_EQ(length(end.first.velocity), 0);
  }
  const RigidMotion jumped = physics::proxy_set(now, host, true, 1, 0, {});
  EXPECT_EQ(length(jumped.first.position - host.first.position), 0);
  EXPECT_EQ(length(jumped.then.velocity), 0);
}

// A host that keeps its pose in one period of 1.6 m is a tenth ahead of a proxy that has gone on, along x; y is no periodic axis.
TEST(Proxy, ClosesTheGapToTheNearestImage) {
  RigidMotion now, host;
  host.until = 0.01;
  now.first.position = {1.9, 0, 3.3};
  host.first.position = {0.4, 2, 0};
  const RigidMotion set = physics::proxy_set(now, host, false, 1, 1e3, {1.6, 0, 1.6});
  EXPECT_NEAR(set.then.velocity.x, 10, 1e-10);
  EXPECT_NEAR(set.then.velocity.y, 200, 1e-10);
  EXPECT_NEAR(set.then.velocity.z, -10, 1e-10);
}

// A gap of 0.3 m and 0.4 rad, of which a point at 2 m has 1.1 m to go, at 11 m/s in 0.01 s: a tenth of it, in the same
// proportion; the rest is there for the next state.
TEST(Proxy, ClosesAWideGapNoFasterThanItMay) {
  RigidMotion now, host;
  host.until = 0.01;
  host.first.position = {0, 0.3, 0};
  host.first.orientation = {std::cos(0.2), 0, 0, std::sin(0.2)};
  for (const double most : {11.0, 200.0}) {
    const RigidMotion set = physics::proxy_set(now, host, false, 2, most, {});
    const RigidMotion end = moved(set, 2, diagonal(1, 1, 1), {}, {}, {}, 0.001, 20);
    const double share = most == 11.0 ? 0.1 : 1.0;
    EXPECT_NEAR(end.first.position.y, 0.3 * share, 1e-14);
    EXPECT_NEAR(end.first.orientation.z, std::sin(0.2 * share), 1e-14);
  }
}

}  // namespace
}  // namespace meltsim
