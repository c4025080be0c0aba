// SPDX-License-Identifier: Apache-2.0
// Kinematic bodies whose mesh the host moves: where their particles go, what liquid and other bodies feel, what is refused.
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double spacing = 0.1;

WorldDesc mesh_desc(Vec3d size, Precision precision = Precision::double_precision) {
  WorldDesc d = describe();
  d.precision = precision;
  d.spacing = spacing;
  d.sound_speed = 40;  // ten times the largest speed of any scene here, 3 m/s of fall and 1 m/s of the host's
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.max = size;
  d.domain.no_slip = false;
  return d;
}

World make(const WorldDesc& d) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

MaterialDesc stone() {
  MaterialDesc m;
  m.name = "stone";
  m.density = 2000;
  return m;
}

/// The surface of the cells [low, high) of a grid that `inside` takes, cell by cell, corners shared.
TriangleMesh surface_of(Vec3i low, Vec3i high, double cell, const std::function<bool(Vec3i)>& inside) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> corners;
  const auto solid = [&](Vec3i c) {
    return c.x >= low.x && c.y >= low.y && c.z >= low.z && c.x < high.x && c.y < high.y && c.z < high.z &&
           inside(c);
  };
  const auto corner = [&](std::array<int, 3> p) {
    const auto [it, added] = corners.try_emplace(p, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (added) mesh.vertices.push_back({p[0] * cell, p[1] * cell, p[2] * cell});
    return it->second;
  };
  for (int z = low.z; z < high.z; ++z)
    for (int y = low.y; y < high.y; ++y)
      for (int x = low.x; x < high.x; ++x) {
        if (!solid({x, y, z})) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (int side = 0; side < 2; ++side) {
            std::array<int, 3> n{x, y, z}, p{x, y, z};
            n[std::size_t(axis)] += 2 * side - 1;
            if (solid({n[0], n[1], n[2]})) continue;
            p[std::size_t(axis)] += side;
            const auto u = std::size_t((axis + 1) % 3), v = std::size_t((axis + 2) % 3);
            std::array<std::array<int, 3>, 4> q{p, p, p, p};
            ++q[1][u];
            ++q[2][u];
            ++q[2][v];
            ++q[3][v];
            std::uint32_t k[4];
            for (std::size_t i = 0; i < 4; ++i) k[i] = corner(q[i]);
            for (const int i : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(k[i]);
          }
      }
  return mesh;
}

TriangleMesh block_mesh(Vec3i low, Vec3i high, double cell = spacing) {
  return surface_of(low, high, cell, [](Vec3i) { return true; });
}

std::vector<Vec3d> moved(const TriangleMesh& mesh, const std::function<Vec3d(Vec3d)>& map) {
  std::vector<Vec3d> v = mesh.vertices;
  for (Vec3d& x : v) x = map(x);
  return v;
}

BodyId deformable(World& w, MaterialId material, const TriangleMesh& mesh) {
  SolidDesc s;
  s.material = material;
  s.shape = Shape::mesh(mesh);
  s.motion = Motion::kinematic;
  auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

// A beam of 2 by 0.4 by 0.4 m that is bent to a quarter of a circle, against the map of plane cross-sections that made its vertices, at
// which triangles of 0.1 m have a sagitta of R (1 - cos(a/2)) = 1e-3 m. Chords cut off what they span: the worst particle is off
// by 1.3 % of the thickness at any spacing, those of the outermost layer by the sagitta and a tenth of a spacing of the chords beside them.
TEST(MeshMotion, ABentBeamFollowsTheExactArc) {
  MELTSIM_NEEDS_BACKEND();
  for (const double dx : {0.1, 0.05}) {
    WorldDesc d = describe();
    d.precision = Precision::double_precision;
    d.spacing = dx;
    d.gravity = {};
    d.sound_speed = 100;
    d.heat.model = HeatModel::none;
    World w = *World::create(d);
    const TriangleMesh mesh = block_mesh({0, 0, 0}, {20, 4, 4}, 0.1);
    const BodyId beam = deformable(w, *w.add_material({}), mesh);
    const ParticleData rest = *w.particles();
    const auto arc = [](Vec3d x, double share) {
      const double r = 2 / (0.5 * 3.14159265358979323846 * share), a = x.x / r, y = x.y - 0.2;
      return Vec3d{(r - y) * std::sin(a), 0.2 + r - (r - y) * std::cos(a), x.z};
    };
    for (int k = 1; k <= 20; ++k) {
      require(w.update_mesh(beam, moved(mesh, [&](Vec3d x) { return arc(x, k / 20.0); })));
      require(w.step(0.05));
    }
    const ParticleData now = *w.particles();
    double worst = 0, outer = 0;
    for (std::size_t i = 0; i < now.id.size(); ++i) {
      const Vec3d x = rest.position[i];
      const double off = length(now.position[i] - arc(x, 1));
      worst = std::max(worst, off);
      if (std::max(std::fabs(x.y - 0.2), std::fabs(x.z - 0.2)) > 0.2 - 0.6 * dx) outer = std::max(outer, off);
    }
    EXPECT_LT(worst, 0.015 * 0.4) << dx;
    EXPECT_LT(outer, 1e-3 + 0.05 * dx) << dx;
    EXPECT_GT(worst, 1e-4) << "chords are straight: what is exact here was not bent";
  }
}

Vec3d turned_about(Vec3d x, Vec3d center, double angle) {
  const Vec3d r = x - center;
  return center + Vec3d{std::cos(angle) * r.x - std::sin(angle) * r.y,
                        std::sin(angle) * r.x + std::cos(angle) * r.y, r.z};
}

double distance(Vec3d a, Vec3d b) { return length(a - b); }

/// Places of the particles of a body, in the order of ids.
std::vector<Vec3d> particles_of(World& w, BodyId body) {
  const ParticleData p = *w.particles();
  std::vector<Vec3d> x;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (is_solid(p.tag[i]) && body_of(p.tag[i]) == body.index + 1) x.push_back(p.position[i]);
  return x;
}

// Weights sum up to 1 and reproduce places, so that an affine map of the mesh (here a turn, a shear and a stretch of 1.2) is
// one of the particles, whatever the triangles are: to rounding of coordinates of 1 m, 1e-12 in double; 2e-7, two units in the
// last place, in single precision. Cells of 0.15 m do not match the lattice; the block is hollow, so that chords end inside, too.
TEST(MeshMotion, ParticlesFollowEveryAffineMap) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
    const double eps = precision == Precision::double_precision ? 1e-12 : 2e-7;
    World w = make(mesh_desc({3, 3, 3}, precision));
    const MaterialId m = *w.add_material(stone());
    const TriangleMesh mesh = surface_of({5, 6, 7}, {11, 11, 12}, 0.15, [](Vec3i c) {
      return !(c.x == 8 && c.y == 8 && c.z > 8 && c.z < 11);
    });
    const BodyId body = deformable(w, m, mesh);
    const std::vector<Vec3d> rest = particles_of(w, body);
    ASSERT_GT(rest.size(), 300u);
    const auto map = [](Vec3d x) {
      const Vec3d r = turned_about(x, {1.2, 1.2, 1.4}, 0.4) - Vec3d{1.2, 1.2, 1.4};
      return Vec3d{1.3, 1.4, 1.5} + Vec3d{1.2 * r.x + 0.1 * r.y, r.y - 0.2 * r.z, 0.9 * r.z};
    };
    require(w.update_mesh(body, moved(mesh, map)));
    require(w.step(0.5));
    const auto check = [&](const std::function<Vec3d(Vec3d)>& where) {
      const std::vector<Vec3d> now = particles_of(w, body);
      ASSERT_EQ(now.size(), rest.size());
      for (std::size_t i = 0; i < rest.size(); ++i) EXPECT_LT(distance(now[i], where(rest[i])), eps);
    };
    check(map);
    require(w.step(0.5));  // without velocities it stays
    check(map);
    // Half way of a step of twice the length, and beyond it at the velocities of the vertices.
    const auto back = [&](Vec3d x) { return x + Vec3d{0.1, 0, 0}; };
    const auto flow = [](Vec3d x) { return Vec3d{0.1 * x.y, 0, -0.2}; };
    require(w.update_mesh(body, moved(mesh, back), moved(mesh, flow)));
    require(w.step(0.5));
    check(back);
    require(w.step(0.25));
    check([&](Vec3d x) { return back(x) + flow(x) * 0.25; });
    const ParticleData p = *w.particles();
    for (std::size_t i = 0; i < rest.size(); ++i) EXPECT_LT(distance(p.velocity[i], flow(rest[i])), 2 * eps);
    // A motion of the whole body comes on top.
    const Vec3d pivot = *w.motion(body)->position;
    BodyMotion turn;
    turn.orientation = Quat<double>{std::cos(0.25), 0, 0, std::sin(0.25)};
    require(w.update_mesh(body, moved(mesh, back)));
    require(w.set_motion(body, turn));
    require(w.step(0.5));
    check([&](Vec3d x) { return turned_about(back(x), pivot, 0.5); });
  }
}

/// A tray with liquid and a loose block, tilted to and fro about z; by its mesh, or as a whole.
struct Tray {
  World world;
  BodyId tray;
  TriangleMesh mesh;
  Vec3d pivot;
  Tray() : world(make(mesh_desc({2, 2, 1}))) {
    mesh = surface_of({3, 6, 2}, {17, 11, 8}, spacing,
                      [](Vec3i c) { return c.y < 8 || c.x < 5 || c.x > 14 || c.z < 4 || c.z > 5; });
    const MaterialId m = *world.add_material(stone()), water = *world.add_material({});
    tray = deformable(world, m, mesh);
    SolidDesc block;
    block.material = m;
    block.shape = Shape::box({1.1, 0.9, 0.4}, {1.3, 1.1, 0.6});
    require(world.add_solid(block));
    FluidDesc f;
    f.material = water;
    f.shape = Shape::box({0.5, 0.8, 0.4}, {1.5, 1.0, 0.6});
    require(world.add_fluid(f));
    pivot = *world.motion(tray)->position;
  }
};

// The same motion of the whole body by its mesh and by set_motion, with liquid in it and a block that falls into it: pressure,
// friction and contact normals are then those of a rigid body. Moved without a turn, what rounding (1e-16) has grown to within
// 200 sub-steps of liquid and contact: 1e-10 m. Turned at up to w = 0.12 rad/s, particles of a mesh move straight within a step,
// and those of a rigid body on arcs: their velocities differ by w^2 r dt/2 = 7e-6 m/s at r = 0.8 m, 2e-6 m in the 0.25 s.
TEST(MeshMotion, ARigidMotionOfTheMeshIsSetMotion) {
  MELTSIM_NEEDS_BACKEND();
  for (const double turn : {0.0, 0.005}) {
    Tray by_mesh, whole;
    const double dt = 0.5 * by_mesh.world.resolved().stable_dt;
    for (int k = 0; k < 200; ++k) {
      const double angle = turn * std::sin(0.03 * (k + 1)), shift = 1e-4 * (k + 1);
      require(by_mesh.world.update_mesh(by_mesh.tray, moved(by_mesh.mesh, [&](Vec3d x) {
                                          return turned_about(x, by_mesh.pivot, angle) + Vec3d{shift, 0, 0};
                                        })));
      BodyMotion m;
      m.position = whole.pivot + Vec3d{shift, 0, 0};
      m.orientation = Quat<double>{std::cos(angle / 2), 0, 0, std::sin(angle / 2)};
      require(whole.world.set_motion(whole.tray, m));
      for (World* w : {&by_mesh.world, &whole.world}) require(w->step(dt));
    }
    ASSERT_EQ(by_mesh.world.steps(), 200u);
    const ParticleData a = *by_mesh.world.particles(), b = *whole.world.particles();
    ASSERT_EQ(a.id.size(), b.id.size());
    double block = 0, worst = 0;
    for (std::size_t i = 0; i < a.id.size(); ++i) {
      worst = std::max(worst, distance(a.position[i], b.position[i]));
      if (is_solid(a.tag[i]) && body_of(a.tag[i]) == 2) block = std::max(block, a.velocity[i].x);
    }
    EXPECT_LT(worst, turn == 0 ? 1e-10 : 2e-6) << turn;
    EXPECT_GT(block, 0.01);  // tray and liquid take it along
  }
}

// A plate three spacings thick from wall to wall that bends by up to 0.35 m as it sweeps the channel at 1 m/s: every particle of
// liquid stays ahead of it, and none is lost.
TEST(MeshMotion, ABendingPlateLeavesNothingBehind) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(mesh_desc({3, 1.2, 0.5}));
  const MaterialId m = *w.add_material(stone()), water = *w.add_material({});
  const TriangleMesh mesh = block_mesh({2, 0, 0}, {5, 12, 5});
  const BodyId plate = deformable(w, m, mesh);
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0.5, 0, 0}, {3, 0.3, 0.5});
  require(w.add_fluid(f));
  const auto bend = [](double t, double y) { return t + 0.35 * std::sin(3 * t) * (y / 1.2) * (y / 1.2); };
  double t = 0;
  for (int k = 0; k < 60; ++k) {
    t += 1.0 / 60;
    require(w.update_mesh(plate, moved(mesh, [&](Vec3d x) { return x + Vec3d{bend(t, x.y), 0, 0}; })));
    require(w.step(1.0 / 60));
  }
  EXPECT_FALSE(w.synchronize().halted);
  const ParticleData p = *w.particles();
  std::size_t liquid = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (!is_fluid(p.tag[i])) continue;
    ++liquid;
    EXPECT_GT(p.position[i].x, 0.35 + bend(t, std::min(p.position[i].y, 1.2))) << p.id[i];
  }
  EXPECT_EQ(liquid, 25u * 3 * 5);
}

// A bellows, full of liquid, with a hole in its lid. The lid comes down by 0.2 m while the sides are squeezed to two thirds of their
// height: of 384 particles, 8 x 8 x 4 have room in the chamber, 256; the others come out. 9 of them: a quarter of a layer at one
// face. What is in the hole still swings (20 to 44 at the end of 120 frames). Sides whose particles kept their volume would push 97 more out.
TEST(MeshMotion, ABellowsSqueezesOutWhatItCannotHold) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(mesh_desc({2, 3, 2}));
  const MaterialId m = *w.add_material(stone()), water = *w.add_material({});
  const TriangleMesh mesh = surface_of({4, 4, 4}, {16, 14, 16}, spacing, [](Vec3i c) {
    const bool chamber = c.x >= 6 && c.x < 14 && c.z >= 6 && c.z < 14 && c.y >= 6 && c.y < 12;
    const bool hole = c.x >= 8 && c.x < 12 && c.z >= 8 && c.z < 12 && c.y >= 12;
    return !chamber && !hole;
  });
  const BodyId bellows = deformable(w, m, mesh);
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0.6, 0.6, 0.6}, {1.4, 1.2, 1.4});
  require(w.add_fluid(f));
  double t = 0;
  for (int k = 0; k < 120; ++k) {
    t += 1.0 / 60;
    const double down = 0.2 * std::min(t, 1.0);
    require(w.update_mesh(bellows, moved(mesh, [&](Vec3d x) {
                            const double y = x.y < 0.6   ? x.y
                                             : x.y < 1.2 ? 0.6 + (x.y - 0.6) * (0.6 - down) / 0.6
                                                         : x.y - down;
                            return Vec3d{x.x, y, x.z};
                          })));
    require(w.step(1.0 / 60));
  }
  EXPECT_FALSE(w.synchronize().halted);
  const ParticleData p = *w.particles();
  int held = 0, lost = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (!is_fluid(p.tag[i])) continue;
    const Vec3d x = p.position[i];
    const bool within = x.x > 0.55 && x.x < 1.45 && x.z > 0.55 && x.z < 1.45;
    held += within && x.y > 0.55 && x.y < 1.0 ? 1 : 0;
    lost += x.y > 0.42 && x.y < 0.55 && x.x > 0.42 && x.x < 1.58 && x.z > 0.42 && x.z < 1.58 ? 1 : 0;
  }
  EXPECT_NEAR(held, 256, 9);
  EXPECT_EQ(lost, 0);  // nobody within the floor
}

// A tank whose floor and sides are stretched to twice their length and width keeps its liquid: sites two spacings apart stand for
// four times their volume. (Three times still keeps all of it.)
TEST(MeshMotion, AStretchedTankKeepsItsLiquid) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(mesh_desc({3.6, 2.4, 3.6}));
  const MaterialId m = *w.add_material(stone()), water = *w.add_material({});
  const TriangleMesh mesh = surface_of({0, 6, 0}, {16, 17, 16}, spacing, [](Vec3i c) {
    return c.y < 8 || c.x < 3 || c.x >= 13 || c.z < 3 || c.z >= 13;
  });
  const BodyId tank = deformable(w, m, mesh);
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0.3, 0.8, 0.3}, {1.3, 1.6, 1.3});
  require(w.add_fluid(f));
  for (int k = 0; k < 90; ++k) {
    const double size = 1 + std::min((k + 1) / 60.0, 1.0);
    require(w.update_mesh(tank, moved(mesh, [&](Vec3d x) { return Vec3d{x.x * size, x.y, x.z * size}; })));
    require(w.step(1.0 / 60));
  }
  EXPECT_FALSE(w.synchronize().halted);
  const ParticleData p = *w.particles();
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (is_fluid(p.tag[i])) {
      EXPECT_GT(p.position[i].y, 0.75) << p.id[i];
    }
}

// A slab is bent into a slope of 0.4 rad by its mesh, or turned as a whole; then a block that slides without friction is put on it.
// It slides alike only if the slope's contact normals are those of the bent mesh. Rounding grows to less than 1e-9 m within 0.4 s.
TEST(MeshMotion, ABlockSlidesOnASlopeMadeByTheMesh) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<Vec3d> ends[2];
  double way = 0;
  for (const bool by_mesh : {true, false}) {
    World w = make(mesh_desc({2, 2, 1}));
    MaterialDesc ice = stone();
    ice.friction = 0;
    const MaterialId m = *w.add_material(ice);
    const TriangleMesh mesh = block_mesh({3, 4, 2}, {17, 7, 8});
    const BodyId slab = deformable(w, m, mesh);
    const Vec3d pivot = *w.motion(slab)->position;
    if (by_mesh) {
      require(w.update_mesh(slab, moved(mesh, [&](Vec3d x) { return turned_about(x, pivot, 0.4); })));
    } else {
      BodyMotion turn;
      turn.orientation = Quat<double>{std::cos(0.2), 0, 0, std::sin(0.2)};
      require(w.set_motion(slab, turn));
    }
    require(w.step(1));
    SolidDesc s;
    s.name = "block";
    s.material = m;
    s.shape = Shape::box({1, 0.9, 0.4}, {1.2, 1.1, 0.6});
    const BodyId block = *w.add_solid(s);
    const Vec3d before = particles_of(w, block).front();
    for (int k = 0; k < 40; ++k) require(w.step(0.01));
    ends[by_mesh ? 0 : 1] = particles_of(w, block);
    way = before.x - ends[by_mesh ? 0 : 1].front().x;
  }
  ASSERT_EQ(ends[0].size(), 8u);
  for (std::size_t i = 0; i < ends[0].size(); ++i) EXPECT_LT(distance(ends[0][i], ends[1][i]), 1e-9);
  EXPECT_GT(
      way,
      0.05);  // it falls for 0.1 s, and slides by g sin 0.4 t^2/2 = 0.17 m in what is left, 0.16 m of that along x
}

/// A fish in a tank: a body that bends, one that floats beside it, and liquid.
struct Pond {
  World world;
  BodyId fish;
  TriangleMesh mesh;
  Pond() : world(make(mesh_desc({2, 1, 1}))) {
    mesh = block_mesh({5, 3, 4}, {14, 6, 6});
    const MaterialId m = *world.add_material(stone()), water = *world.add_material({});
    fish = deformable(world, m, mesh);
    SolidDesc block;
    block.name = "float";
    MaterialDesc wood = stone();
    wood.name = "wood";
    wood.density = 500;
    block.material = *world.add_material(wood);
    block.shape = Shape::box({1.5, 0.5, 0.4}, {1.7, 0.7, 0.6});
    require(world.add_solid(block));
    FluidDesc f;
    f.material = water;
    f.shape = Shape::box({0, 0, 0}, {2, 0.7, 1});
    require(world.add_fluid(f));
  }
  void swim(int frame) {
    const double t = (frame + 1) / 60.0;
    const auto bend = [](double at, Vec3d x) {
      return x + Vec3d{0, 0, 0.2 * x.x * std::sin(6 * at - 3 * x.x)};
    };
    std::vector<Vec3d> speed = mesh.vertices;
    for (Vec3d& v : speed) v = (bend(t + 1e-4, v) - bend(t, v)) * 1e4;
    require(world.update_mesh(fish, moved(mesh, [&](Vec3d x) { return bend(t, x); }), speed));
    require(world.step(1.0 / 60));
  }
  std::uint64_t hash() { return *world.state_hash(); }
};

// What a body that deforms does is part of the state: a snapshot, a saved state, and an upload because something was added, in the
// middle of its motion, in or beside a step that has set it, go on with the same bits.
TEST(MeshMotion, StatesInTheMiddleOfAMotionGoOnToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  Pond a;
  for (int k = 0; k < 6; ++k) a.swim(k);
  const std::vector<std::uint8_t> snapshot = *a.world.snapshot();
  require(a.world.save_state(0));
  const std::uint64_t middle = a.hash();
  const auto go_on = [](Pond& p) {
    require(p.world.step(0.004));  // at the velocities
    for (int k = 6; k < 9; ++k) p.swim(k);
    return p.hash();
  };
  const std::uint64_t end = go_on(a);
  require(a.world.load_state(0));
  EXPECT_EQ(a.hash(), middle);
  EXPECT_EQ(go_on(a), end);
  require(a.world.restore(snapshot.data(), snapshot.size()));
  EXPECT_EQ(a.hash(), middle);
  EXPECT_EQ(go_on(a), end);
  Pond b;  // of the same scene, and has never moved a mesh
  require(b.world.restore(snapshot.data(), snapshot.size()));
  EXPECT_EQ(b.hash(), middle);
  EXPECT_EQ(go_on(b), end);
  // Part of a step taken, the rest after an upload, as the sub-steps of a whole one.
  Pond c, d;
  for (Pond* p : {&c, &d}) {
    p->swim(0);
    require(p->world.update_mesh(p->fish, moved(p->mesh, [](Vec3d x) {
                                   return x + Vec3d{0, 0.02 * x.x, 0};
                                 })));
  }
  const TimedStep part = *c.world.step_part(1.0 / 60, 2);
  ASSERT_GT(part.planned, 2u);
  require(d.world.step_part(1.0 / 60, 2));
  const std::vector<std::uint8_t> within = *d.world.snapshot();
  Pond e;
  require(e.world.restore(within.data(), within.size()));
  for (Pond* p : {&c, &d, &e}) require(p->world.step(0.01));
  EXPECT_EQ(c.hash(), d.hash());
  EXPECT_EQ(c.hash(), e.hash());
  // A snapshot from before any mesh moved takes the deformation back.
  Pond g, fresh;
  const std::vector<std::uint8_t> rest = *fresh.world.snapshot();
  g.swim(0);
  require(g.world.restore(rest.data(), rest.size()));
  for (Pond* p : {&g, &fresh}) require(p->world.step(0.02));
  EXPECT_EQ(g.hash(), fresh.hash());
}

// Adding to the World while a body is bent leaves it bent; a second body that deforms, added and moved later, keeps to its own
// points. Places to rounding of 2 m, 1e-12.
TEST(MeshMotion, WhatIsAddedLeavesBodiesBent) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(mesh_desc({3, 3, 1}));
  const MaterialId m = *w.add_material(stone());
  const TriangleMesh mesh = block_mesh({2, 2, 2}, {8, 5, 5});
  SolidDesc first;
  first.material = m;
  first.shape = Shape::mesh(mesh).transformed({1, 0.5, 0});
  first.motion = Motion::kinematic;
  const BodyId a = *w.add_solid(first);
  const std::vector<Vec3d> rest = particles_of(w, a);
  TriangleMesh placed = mesh;
  for (Vec3d& v : placed.vertices) v = v + Vec3d{1, 0.5, 0};
  const auto shear = [](Vec3d x) { return x + Vec3d{0.3 * x.y, 0, 0}; };
  require(w.update_mesh(a, moved(placed, shear)));
  require(w.step(0.5));
  const TriangleMesh other = block_mesh({2, 20, 2}, {8, 25, 5});
  const BodyId b = deformable(w, m, other);
  const std::vector<Vec3d> rest_b = particles_of(w, b);
  const auto lift = [](Vec3d x) { return x + Vec3d{0, 0.1 * x.x, 0}; };
  require(w.update_mesh(b, moved(other, lift)));
  require(w.step(0.5));
  const std::vector<Vec3d> now_a = particles_of(w, a), now_b = particles_of(w, b);
  ASSERT_EQ(now_a.size(), rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i) EXPECT_LT(distance(now_a[i], shear(rest[i])), 1e-12);
  for (std::size_t i = 0; i < rest_b.size(); ++i) EXPECT_LT(distance(now_b[i], lift(rest_b[i])), 1e-12);
  require(w.remove(a));
  require(w.step(0.1));
  EXPECT_FALSE(w.update_mesh(a, placed.vertices));
}

/// That a call was refused with a text.
template <class R>
void expect_error(const R& r, const std::string& part) {
  ASSERT_FALSE(r) << part;
  EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(r.error().message.find(part), std::string::npos) << r.error().message;
}

// Every misuse has a text that names the field and the fix, and changes nothing.
TEST(MeshMotion, RefusesWhatCannotBe) {
  MELTSIM_NEEDS_BACKEND();
  Pond p, other;
  p.swim(0);
  const std::uint64_t before = p.hash();
  std::vector<Vec3d> v = p.mesh.vertices;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  World& w = p.world;
  expect_error(w.update_mesh(p.fish, std::vector<Vec3d>(v.begin(), v.end() - 1)),
               "vertices: the mesh has " + std::to_string(v.size()) + " vertices, got " +
                   std::to_string(v.size() - 1));
  expect_error(w.update_mesh(p.fish, {}), "got 0");
  expect_error(w.update_mesh(p.fish, v, {{0, 0, 0}}), "velocities: must be one per vertex");
  std::vector<Vec3d> bad = v;
  bad[7].y = nan;
  expect_error(w.update_mesh(p.fish, bad), "vertices[7]: must be finite");
  expect_error(w.update_mesh(p.fish, v, bad), "velocities[7]: must be finite");
  expect_error(w.update_mesh(BodyId{p.fish.index + 1, p.fish.generation}, v),
               "motion: only the mesh of a kinematic body");
  expect_error(w.update_mesh(other.fish, v), "body: no body of this World");
  expect_error(w.update_mesh(BodyId{}, v), "body: no body of this World");
  SolidDesc s;
  s.name = "box";
  s.material = MaterialId{0, 1};
  s.shape = Shape::box({0.2, 0.8, 0.2}, {0.4, 1, 0.4});
  s.motion = Motion::kinematic;
  {
    Pond q;
    const BodyId box = *q.world.add_solid(s);
    expect_error(q.world.update_mesh(box, v), "shape: it was not built from one mesh");
  }
  // Too fast a vertex: step() says so, and forgets what it refused.
  std::vector<Vec3d> far = v;
  for (Vec3d& x : far) x.y += 0.4;
  require(w.update_mesh(p.fish, far));
  expect_error(w.step(0.01), "update_mesh: body \"body1\": vertices: a particle would move at 4");
  require(w.update_mesh(p.fish, far));
  expect_error(w.step(0.01), "more than half the sound speed");
  require(w.update_mesh(p.fish, v, std::vector<Vec3d>(v.size(), Vec3d{0, 1e300, 0})));
  expect_error(w.step(0.01), "velocities: a particle would move at");
  // Through a wall.
  for (Vec3d& x : far) x.y = x.y - 0.4 - 0.5;
  require(w.update_mesh(p.fish, far));
  expect_error(w.step(0.1), "vertices: would reach through a wall");
  EXPECT_EQ(p.hash(), before);
  require(w.step(1.0 / 60));  // none of it waits
  require(w.update_mesh(p.fish, v));
  require(w.step(1.0 / 60));
  EXPECT_FALSE(w.synchronize().halted);
}

}  // namespace
}  // namespace meltsim_test
