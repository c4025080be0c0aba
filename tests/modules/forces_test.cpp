// SPDX-License-Identifier: Apache-2.0
// Density and forces of a scene with two liquids, a solid and walls against sums over all pairs in double
// and explicit mirror images of them all, that use no code of the library but wall_exchange.hpp (tested on
// its own).
//
// Tolerance: the median over particles of the relative error, 3e-6: sums over 65 neighbours in float. The
// scene is compressed (phi around 1.3), so that the subtraction in phi^7 - 1 costs no digits. Errors of
// forces are relative to the force or, where that is larger, to a hundredth of the rms.
#include <gtest/gtest.h>

#include <algorithm>

#include "modules/engine.hpp"

namespace {

using namespace modules_test;

constexpr double dx = 0.2, H = 0.5, pi = 3.14159265358979323846;

/// Lattice of 0.9 dx, jittered by a tenth, in a box of walls: solid in one corner, two liquids in layers.
struct Scene {
  core::SceneConstants constants = plain_constants(dx);
  core::SceneState state;
  explicit Scene(std::uint32_t seed = 81) {
    Random random(seed);
    constants.surroundings.gravity = {0, -9.81, 0};
    constants.spring_dt = 1e-3;  // the step below
    constants.domain.bounded = true;
    constants.domain.max = {1.85, 1.5, 1.5};
    for (const Vec3i& p : block(10, 8, 8)) {
      const Vec3d x = Vec3d{p.x + 0.5, p.y + 0.5, p.z + 0.5} * (0.9 * dx) + random.vector(0.1 * dx);
      const bool solid = p.x < 4 && p.y < 4;
      add_particle(state, constants, x, solid ? 1u | tag_solid : p.y < 4 ? 2u : 0u, random.vector(1));
    }
  }
};

/// The frame in double, and the sums.
struct Oracle {
  std::vector<Vec3d> x, v, force;
  std::vector<double> volume, mass, phi, term;
  std::vector<std::vector<Vec3d>> images;  // of every particle, in the box's planes, edges and corners
  std::vector<std::uint32_t> tag;
  std::vector<core::MaterialRow<double>> rows;
  double dt = 0;
  physics::WallExchange<double> exchange = physics::make_wall_exchange<double>(H, dx);
  double w_scale = 0, f_scale = 0, gain = 0;

  static double bump(double r) {
    return r < H ? std::pow(1 - r / H, 4) * (1 + 4 * r / H) * 21 / (2 * pi * H * H * H) : 0;
  }
  static double steep(double r) { return r < H ? std::pow(1 - r / H, 3) * 210 / (pi * std::pow(H, 5)) : 0; }
  double W(double r) const { return bump(r) / w_scale; }
  double f(double r) const { return steep(r) / f_scale; }
  double L(double r) const { return 2 * steep(r) * r * r / (r * r + 0.01 * 0.25 * H * H) / gain; }
  bool solid(std::size_t i) const { return is_solid(tag[i]); }

  template <class T>
  Oracle(const core::Frame<T>& w, const core::SceneConstants& c)
      : rows(c.materials), dt(static_cast<double>(w.clock.dt)) {
    const double cell = dx * dx * dx;
    for (int k = -3; k <= 3; ++k)
      for (int j = -3; j <= 3; ++j)
        for (int i = -3; i <= 3; ++i) {
          const double r = dx * std::sqrt(double(i * i + j * j + k * k));
          w_scale += cell * bump(r);
          gain += 0.5 * cell * 2 * steep(r) * r * r / (r * r + 0.0025 * H * H) * dx * dx * i * i;
          f_scale += cell * steep(r) * dx * dx * i * i;
        }
    const std::size_t n = w.particles;
    for (std::size_t i = 0; i < n; ++i) {
      x.push_back(cast<double>(xyz(w.f.position[i])));
      v.push_back(cast<double>(xyz(w.f.velocity[i])));
      volume.push_back(static_cast<double>(w.f.position[i].w));
      mass.push_back(static_cast<double>(w.f.mass[i]));
      tag.push_back(w.f.tag[i]);
    }
    phi.assign(n, 0);
    term.assign(n, 0);
    force.assign(n, {});
    for (std::size_t i = 0; i < n; ++i) {
      images.emplace_back();
      for (int m = 1; m < 27; ++m) {
        const auto mirror = [&](double at, int how, double low, double high) {
          return how == 0 ? at : how == 1 ? 2 * low - at : 2 * high - at;
        };
        images[i].push_back({mirror(x[i].x, m % 3, c.domain.min.x, c.domain.max.x),
                             mirror(x[i].y, m / 3 % 3, c.domain.min.y, c.domain.max.y),
                             mirror(x[i].z, m / 9, c.domain.min.z, c.domain.max.z)});
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        phi[i] += volume[j] * W(length(x[i] - x[j]));
        if (c.domain.bounded)
          for (const Vec3d& m : images[j]) phi[i] += volume[j] * W(length(x[i] - m));
      }
      // Of a solid particle, what multiplies the stiffness of the liquid at the other end.
      const double stiffness = solid(i) ? 1 : rows[material_of(tag[i])].tait_stiffness;
      term[i] = std::max(0.0, stiffness * (std::pow(phi[i], 7) - 1)) / (phi[i] * phi[i]);
    }
    for (std::size_t i = 0; i < n; ++i) {
      force[i] += c.surroundings.gravity * mass[i];
      if (!solid(i) && c.domain.bounded)
        force[i] += cast<double>(physics::floor_push(w.c.walls, w.c.kernel,
                                                     physics::wall_view(w.c.walls, xyz(w.f.position[i])),
                                                     w.clock.gravity)) *
                    mass[i];
      if (!solid(i) && c.domain.bounded)
        for (const double d : {x[i].x - c.domain.min.x, c.domain.max.x - x[i].x, x[i].y - c.domain.min.y,
                               c.domain.max.y - x[i].y, x[i].z - c.domain.min.z, c.domain.max.z - x[i].z})
          force[i] += v[i] * (-rows[material_of(tag[i])].viscosity * volume[i] *
                              physics::wall_area(exchange, d) / physics::wall_depth(exchange, d));
      for (std::size_t j = 0; j < n; ++j) {
        if (solid(i) && solid(j)) continue;
        if (i != j) force[i] += solid(i) ? -pair(c, j, i) : pair(c, i, j);
        if (c.domain.bounded)
          for (const Vec3d& m : images[j]) {
            const Vec3d d = x[i] - m;
            force[i] += d * (volume[i] * volume[j] * f(length(d)) * terms(i, j));
          }
      }
    }
  }

  /// P_i/phi_i^2 + P_j/phi_j^2 of a pair with at most one solid end.
  double terms(std::size_t i, std::size_t j) const {
    if (solid(i)) return terms(j, i);
    return term[i] + term[j] * (solid(j) ? rows[material_of(tag[i])].tait_stiffness : 1);
  }

  /// How much of the spring against leaks liquid i feels.
  double leak_share(const core::SceneConstants& c, std::size_t i) const {
    double cover = 0, rate = 0;
    const auto add = [&](std::size_t j, const Vec3d& at, const Vec3d& u) {
      const double r = length(x[i] - at);
      cover += volume[j] * W(r);
      rate -= volume[j] * f(r) * dot(u, x[i] - at);
    };
    for (std::size_t j = 0; j < x.size(); ++j) {
      if (!solid(j)) continue;
      add(j, x[j], v[i] - v[j]);
      if (!c.domain.bounded) continue;
      for (const Vec3d& m : images[j])  // a component that is mirrored has the other sign
        add(j, m,
            {v[i].x - (m.x == x[j].x ? v[j].x : -v[j].x), v[i].y - (m.y == x[j].y ? v[j].y : -v[j].y),
             v[i].z - (m.z == x[j].z ? v[j].z : -v[j].z)});
    }
    const double coming = (rate * dx / c.sound_speed - 0.001) / 0.005, in = (cover - 0.42) / 0.05;
    return std::min(1.0, std::max({0.0, coming, in}));
  }
  /// On liquid i from j.
  Vec3d pair(const core::SceneConstants& c, std::size_t i, std::size_t j) const {
    const Vec3d d = x[i] - x[j], u = v[i] - v[j];
    const double r = length(d);
    if (r >= H) return {};
    const auto &a = rows[material_of(tag[i])], &b = rows[material_of(tag[j])];
    const double vj = volume[j];
    const double viscosity =
        solid(j) ? 2 * a.viscosity : 2 * a.viscosity * b.viscosity / (a.viscosity + b.viscosity);
    const double rho = solid(j) ? 0 : 0.5 * (a.density + b.density);  // of what is damped
    double leak = 0;  // contact from 0.9 dx inwards, per distance
    if (solid(j) && r < 0.9 * dx) {
      const double m = mass[i] * mass[j] / (mass[i] + mass[j]);
      leak = leak_share(c, i) *
             std::max(0.0, 0.15 * m / (dt * dt) * (0.9 * dx - r) - std::sqrt(0.15) * m / dt * dot(u, d) / r) /
             r;
    }
    const double approach = std::min(0.0, dot(u, d)) / (r * r + 0.0025 * H * H);
    const double mu = 0.5 * H * approach;  // of Monaghan
    const double held = std::min(-rho * c.artificial_viscosity * c.sound_speed * mu,
                                 std::abs(terms(i, j)) + 4 * rho * mu * mu);
    return d * leak + d * (volume[i] * vj * f(r) * (terms(i, j) + held)) -
           u * (viscosity * volume[i] * vj * L(r));
  }
};

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

template <class T>
class Forces : public testing::Test {
 protected:
  static constexpr double tolerance = sizeof(T) == 8 ? 1e-13 : 3e-6;
  static constexpr std::initializer_list<const char*> stages = {"step.begin", "spatial",     "sph.density",
                                                                "lsm.loads",  "sph.cover",   "sph.forces",
                                                                "sph.wetted", "sph.reaction"};
  static constexpr core::FactSet facts =
      core::fact_particles | core::fact_fluid | core::fact_solid | core::fact_mobile | core::fact_lattice;
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Forces, Scalars);

TYPED_TEST(Forces, EqualSumsOverAllPairs) {
  using T = TypeParam;
  const Scene scene;
  Rig<T> rig;
  rig.upload(scene.constants, {}, scene.state, this->facts);
  rig.run(this->stages, 1e-3);
  const core::Frame<T>& w = rig.frame();
  const Oracle o(w, scene.constants);
  std::vector<double> density, term, tau, liquid, solid;
  double square = 0;
  int compressed = 0;
  for (const Vec3d& f : o.force) square += dot(f, f);
  const double least = 1e-2 * std::sqrt(square / double(o.force.size()));
  for (std::uint32_t i = 0; i < w.particles; ++i) {
    const Vec3d f = cast<double>(w.f.acceleration[i]) * o.mass[i];
    const Vec3d x = o.x[i], top = scene.constants.domain.max;
    const bool near_wall = std::min({x.x, x.y, x.z, top.x - x.x, top.y - x.y, top.z - x.z}) < 0.5 * dx;
    if (o.solid(i)) {
      if (o.term[i] > 0) tau.push_back(std::fabs(-static_cast<double>(w.f.velocity[i].w) / o.term[i] - 1));
      // Contact with walls is no business of this test.
      if (!near_wall) solid.push_back(length(f - o.force[i]) / std::max(length(o.force[i]), least));
      continue;
    }
    density.push_back(std::fabs(static_cast<double>(w.f.density[i]) / o.phi[i] - 1));
    if (o.term[i] > 0) term.push_back(std::fabs(static_cast<double>(w.f.velocity[i].w) / o.term[i] - 1));
    liquid.push_back(length(f - o.force[i]) / std::max(length(o.force[i]), least));
    compressed += o.phi[i] > 1.1 ? 1 : 0;
  }
  EXPECT_GT(compressed, 300);
  EXPECT_GT(solid.size(), 20u);
  EXPECT_GT(tau.size(), 20u);
  EXPECT_LE(median(tau), this->tolerance);
  EXPECT_LE(median(density), this->tolerance);
  EXPECT_LE(median(term), this->tolerance);
  EXPECT_LE(median(liquid), this->tolerance);
  EXPECT_LE(median(solid), this->tolerance);
  // No outlier hides behind the median: a hundred times that.
  EXPECT_LE(*std::max_element(density.begin(), density.end()), 100 * this->tolerance);
  EXPECT_LE(*std::max_element(liquid.begin(), liquid.end()), 1000 * this->tolerance);
}

// One liquid, one solid particle of mass 1: what one gets the other loses, bit for bit. The liquid particle
// has 0.5 m^3, so that it is compressed although alone.
TYPED_TEST(Forces, ReactionIsTheExactNegative) {
  using T = TypeParam;
  Random random(82);
  for (int n = 0; n < 200; ++n) {
    core::SceneConstants c = plain_constants(dx);
    c.materials[0].density = 2;
    core::SceneState s;
    const Vec3d x = random.vector(20);
    add_particle(s, c, x, 0u, random.vector(2));
    add_particle(s, c, x + random.vector(0.2), 1u | tag_solid, random.vector(2));
    s.mass = {1, 1};
    s.volume[0] = 0.5;
    Rig<T> rig;
    rig.upload(c, {}, s, this->facts);
    rig.run(this->stages, 1e-3);
    const core::Frame<T>& w = rig.frame();
    const std::uint32_t i = w.f.slot_of_id[0], k = w.f.slot_of_id[1];
    const Vec3<T> on_liquid = w.f.acceleration[i], on_solid = w.f.acceleration[k];
    ASSERT_GT(w.f.velocity[i].w, T(0));
    ASSERT_GT(length(on_liquid), T(0));
    ASSERT_TRUE(on_liquid.x == -on_solid.x && on_liquid.y == -on_solid.y && on_liquid.z == -on_solid.z) << n;
  }
}

// A closed cloud without walls or gravity: rounding of the sum of all forces, relative to their sizes.
TYPED_TEST(Forces, SumToZero) {
  using T = TypeParam;
  Scene scene(83);
  scene.constants.domain.bounded = false;
  scene.constants.surroundings.gravity = {};
  Rig<T> rig;
  rig.upload(scene.constants, {}, scene.state, this->facts);
  rig.run(this->stages, 1e-3);
  const core::Frame<T>& w = rig.frame();
  Vec3d sum{};
  double parts = 0;
  for (std::uint32_t i = 0; i < w.particles; ++i) {
    const Vec3d f = cast<double>(w.f.acceleration[i]) * static_cast<double>(w.f.mass[i]);
    sum += f;
    parts += length(f);
  }
  EXPECT_GT(parts, 0.0);
  EXPECT_LE(length(sum), (sizeof(T) == 8 ? 1e-14 : 1e-6) * parts);
}

}  // namespace
