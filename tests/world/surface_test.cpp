// SPDX-License-Identifier: Apache-2.0
// Surfaces of Worlds whose shape is known. dx = 0.1 m; cells are half of it unless said otherwise.
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

#include "scenes.hpp"
#include "support/mesh_check.hpp"
#include "support/random.hpp"

namespace meltsim_test {
namespace {

using test_support::check_mesh;
using test_support::expect_surface;
using test_support::MeshCheck;

constexpr double dx = 0.1, cube = dx * dx * dx, pi = 3.14159265358979323846;

template <class T>
T value_of(Result<T> r) {
  EXPECT_TRUE(r) << (r ? "" : r.error().message);
  return r ? *std::move(r) : T{};
}

/// Nothing moves unless something is pushed.
WorldDesc weightless() {
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {};
  d.sound_speed = 20;
  return d;
}

World make(const WorldDesc& d) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

World liquid(const WorldDesc& d, const std::vector<Shape>& shapes) {
  World w = make(d);
  const MaterialId water = value_of(w.add_material({}));
  for (const Shape& s : shapes) {
    FluidDesc f;
    f.shape = s;
    f.material = water;
    value_of(w.add_fluid(f));
  }
  return w;
}

/// Sites of the lattice, from low to high.
Shape sites(Vec3i low, Vec3i high) {
  return Shape::box(Vec3d{low.x * dx, low.y * dx, low.z * dx}, Vec3d{high.x * dx, high.y * dx, high.z * dx});
}

class Kernels : public ::testing::TestWithParam<SurfaceKernel> {
 protected:
  SurfaceDesc desc() const {
    SurfaceDesc d;
    d.kernel = GetParam();
    return d;
  }
};

// R = 10 dx, three places of the centre on the lattice. The targets are the issue's: 2 % of the volume, 3 %
// of the area. A lattice has steps where the sphere has none: its own particles are 0.8 % too many at the
// first place, and steps are what most of the area's error is.
TEST_P(Kernels, SphereHasItsVolumeAndArea) {
  MELTSIM_NEEDS_BACKEND();
  const double R = 10 * dx;
  for (const Vec3d centre :
       {Vec3d{0, 0, 0}, Vec3d{0.5 * dx, 0.5 * dx, 0.5 * dx}, Vec3d{0.031, 0.017, 0.042}}) {
    World w = liquid(weightless(), {Shape::sphere(centre, R)});
    const SurfaceMesh m = value_of(w.surface(desc()));
    const MeshCheck c = expect_surface(m, dx / 2, 0.9);
    EXPECT_EQ(c.euler, std::vector<int>{2});
    EXPECT_NEAR(c.volume / (4.0 / 3 * pi * R * R * R), 1, 0.02);
    EXPECT_NEAR(c.area / (4 * pi * R * R), 1, 0.03);
    for (std::size_t v = 0; v < m.position.size(); ++v) {
      const Vec3d r = cast<double>(m.position[v]) - centre;
      ASSERT_NEAR(length(r), R, 0.8 * dx);  // a step of the lattice and half a spacing of rounding
      ASSERT_GT(dot(r, cast<double>(m.normal[v])), 0);
    }
  }
}

// Nodes of cells of one and of a third of a spacing stand exactly on the lattice's particles; 2 dx is coarser
// than the smallest thing here.
TEST_P(Kernels, FewParticlesInCellsOfAnySize) {
  MELTSIM_NEEDS_BACKEND();
  for (const double cell : {dx / 16, dx / 8, dx / 3, dx / 2, dx, 2 * dx}) {
    SurfaceDesc d = desc();
    d.cell = cell;
    World one = liquid(weightless(), {sites({0, 0, 0}, {1, 1, 1})});
    World touching = liquid(weightless(), {sites({0, 0, 0}, {2, 1, 1})});
    World apart = liquid(weightless(), {sites({0, 0, 0}, {1, 1, 1}), sites({5, 0, 0}, {6, 1, 1})});
    const SurfaceMesh ball = value_of(one.surface(d));
    if (cell > dx) continue;  // between the nodes: no error, whether or not something is left
    const MeshCheck a = expect_surface(ball, cell);
    EXPECT_EQ(a.euler, std::vector<int>{2});
    const MeshCheck b = expect_surface(value_of(touching.surface(d)), cell);
    EXPECT_EQ(b.euler, std::vector<int>{2});
    const MeshCheck two = expect_surface(value_of(apart.surface(d)), cell);
    EXPECT_EQ(two.euler, (std::vector<int>{2, 2}));
    if (cell > dx / 3) continue;  // too few vertices to have a volume
    // A ball of a spacing's volume by construction. Fine cells lose a little to the chords of the mesh; 10 %
    // at dx/3.
    EXPECT_NEAR(a.volume / cube, 1, cell > dx / 8 ? 0.2 : 0.05);
    EXPECT_NEAR(two.volume / cube, 2, cell > dx / 8 ? 0.4 : 0.1);
    EXPECT_GT(b.volume, 1.5 * a.volume);
  }
}

// A third of the sites of a block, flying apart: drops, strings, films, holes.
TEST_P(Kernels, RandomSetsAreClosed) {
  MELTSIM_NEEDS_BACKEND();
  test_support::Random random(5);
  for (int round = 0; round < 4; ++round) {
    World w = make(weightless());
    const MaterialId water = value_of(w.add_material({}));
    for (int n = 0; n < 400; ++n) {
      const auto at = [&] { return static_cast<int>(random.below(11)); };
      const int x = at(), y = at(), z = at();
      FluidDesc f;
      f.shape = sites({x, y, z}, {x + 1, y + 1, z + 1});
      f.material = water;
      f.velocity = random.vector(2);
      static_cast<void>(w.add_fluid(f));  // taken sites are refused
    }
    for (int k = 0; k < 15; ++k) require(w.step(0.002));
    for (const double cell : {dx / 2, dx / 4, dx}) {
      SurfaceDesc d = desc();
      d.cell = cell;
      d.smoothing = round;
      const SurfaceMesh m = value_of(w.surface(d));
      const MeshCheck c = check_mesh(m);
      EXPECT_EQ(c.open_edges, 0u);
      EXPECT_EQ(c.unused, 0u);
      EXPECT_EQ(c.split, 0u);
      EXPECT_GT(c.smallest_area, 0);
      EXPECT_GT(c.volume, 0);
      if (d.smoothing == 0) {
        for (const double v : c.volumes) EXPECT_NE(v, 0);
        EXPECT_GT(c.smallest_area, 1e-5 * cell * cell);
      }
    }
  }
}

// A hole of three by three sites through a block of fifteen: cells around it are all occupied, it is found by
// its surface particles. Genus 1; the hole is rounded, so that the volume is that of the sites to 3 %.
TEST_P(Kernels, TunnelGoesThrough) {
  MELTSIM_NEEDS_BACKEND();
  World w = liquid(weightless(), {sites({0, 0, 0}, {15, 15, 6}), sites({0, 0, 9}, {15, 15, 15}),
                                  sites({0, 0, 6}, {15, 6, 9}), sites({0, 9, 6}, {15, 15, 9})});
  const MeshCheck c = expect_surface(value_of(w.surface(desc())), dx / 2);
  EXPECT_EQ(c.euler, std::vector<int>{0});
  EXPECT_NEAR(c.volume / (15 * (15 * 15 - 9) * cube), 1, 0.03);
}

// A full tank is its box: faces at the walls, edges and corners sharp, volume and area to rounding. (Edges cut off by
// half a cell would take 0.4 % of the volume and 2 % of the area.) Half full, its upper edges are rounded.
TEST_P(Kernels, WaterMeetsWallsAtTheWall) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = weightless();
  d.domain.bounded = true;
  d.domain.min = {-0.3, 0, 0.2};
  d.domain.max = {1.0, 0.9, 1.099};  // not a multiple of the cell in z
  World full = liquid(d, {Shape::box(d.domain.min, {1.0, 0.9, 1.1})});
  World half = liquid(d, {Shape::box(d.domain.min, {1.0, 0.5, 1.1})});
  for (World* w : {&full, &half}) {
    const double top = w == &full ? 0.9 : 0.5;
    const SurfaceMesh m = value_of(w->surface(desc()));
    const MeshCheck c = expect_surface(m, dx / 2);
    EXPECT_EQ(c.euler, std::vector<int>{2});
    const double wide = 1.3, deep = 0.899;
    EXPECT_NEAR(c.volume / (wide * top * deep), 1, w == &full ? 2e-6 : 0.02);
    EXPECT_NEAR(c.area / (2 * (wide * top + top * deep + deep * wide)), 1, w == &full ? 2e-6 : 0.04);
    float low[3] = {9, 9, 9}, high[3] = {-9, -9, -9};
    for (const Vec3f& p : m.position) {
      const float at[3] = {p.x, p.y, p.z};
      for (int a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], at[a]);
        high[a] = std::max(high[a], at[a]);
      }
    }
    EXPECT_NEAR(low[0], -0.3, 1e-6);
    EXPECT_NEAR(low[1], 0, 1e-6);
    EXPECT_NEAR(low[2], 0.2, 1e-6);
    EXPECT_NEAR(high[0], 1.0, 1e-6);
    EXPECT_NEAR(high[2], 1.099, 1e-6);
    EXPECT_NEAR(high[1], top, w == &full ? 1e-6 : 0.15 * dx);  // the line where it meets the wall: 0.11 dx
  }
}

// Periodic faces close the mesh, too, and what is beyond one counts on the other side: the surface is flat up
// to it.
TEST(Surface, PeriodicFacesCutStraight) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = weightless();
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.2, 1.0};
  d.domain.faces = {Face::periodic, Face::periodic, Face::open, Face::open, Face::wall, Face::wall};
  World w = liquid(d, {Shape::box({0, 0, 0}, {1.2, 0.6, 1.0})});
  const SurfaceMesh m = value_of(w.surface());
  const MeshCheck c = expect_surface(m, dx / 2);
  EXPECT_EQ(c.euler, std::vector<int>{2});
  EXPECT_NEAR(c.volume / (1.2 * 0.6 * 1.0), 1, 0.01);
  for (const Vec3f& p : m.position) {
    if (p.y < 0.5f || p.x < 0.01f || p.x > 1.19f || p.z < 0.01f || p.z > 0.99f) continue;
    ASSERT_NEAR(p.y, 0.6, 0.1 * dx);  // bumps of the lattice are 0.01 dx, the mesh's chords as much
  }
}

/// Water around and above a block of ice.
Scene submerged(int threads = 0, Precision precision = Precision::single_precision) {
  WorldDesc d = describe();
  d.threads = threads;
  d.precision = precision;
  IceScene s;
  s.depth = 2.2;
  s.block = 5;
  s.block_floor = 0.6;
  s.fixed = true;
  return ice_in_water(d, s);
}

// Where water touches ice both closed meshes have the same vertices, so that there is neither gap nor overlap.
// Exactly: the two cross the same edge at t and 1 - t. Smoothing moves both alike, to rounding.
TEST(Surface, ClosedLiquidAndSolidHaveTheSameInterface) {
  MELTSIM_NEEDS_BACKEND();
  for (const int smoothing : {0, 4}) {
    Scene s = submerged();
    SurfaceDesc d;
    d.smoothing = smoothing;
    d.closed_at_solids = true;
    const SurfaceMesh water = value_of(s.world.surface(d));
    d.of = SurfaceOf::solids;
    const SurfaceMesh ice = value_of(s.world.surface(d));
    const MeshCheck a = expect_surface(water, 0.1), b = expect_surface(ice, 0.1);
    EXPECT_EQ(a.euler, (std::vector<int>{2, 2}));  // the tank and the hole
    EXPECT_EQ(b.euler, std::vector<int>{2});
    EXPECT_NEAR(*std::min_element(a.volumes.begin(), a.volumes.end()), -b.volume, 1e-5 * b.volume);
    const auto cell_of = [](Vec3f p) {
      return std::make_tuple(std::lround(p.x * 50), std::lround(p.y * 50), std::lround(p.z * 50));
    };
    std::multimap<std::tuple<long, long, long>, Vec3f> near;
    for (const Vec3f& p : water.position) near.emplace(cell_of(p), p);
    std::size_t shared = 0;
    for (const Vec3f& p : ice.position) {
      bool found = false;
      for (float ox : {-1e-4f, 1e-4f})
        for (float oy : {-1e-4f, 1e-4f})
          for (float oz : {-1e-4f, 1e-4f}) {
            const auto range = near.equal_range(cell_of({p.x + ox, p.y + oy, p.z + oz}));
            for (auto it = range.first; it != range.second; ++it)
              found = found || length(it->second - p) < 5e-6f;  // ten roundings of a coordinate of 2 m
          }
      shared += found ? 1 : 0;
    }
    EXPECT_EQ(shared, ice.position.size()) << "smoothing " << smoothing;
  }
}

/// The block of ice that fell into the tank, melting, half in the water: there are lines where ice, water and air
/// meet.
Scene afloat() {
  Scene s = ice_in_water(describe());
  for (int k = 0; k < 100; ++k) require(s.world.step(0.005));
  return s;
}

/// Distance of a point from a triangle: from the plane's foot if that is inside, else from the nearest edge.
double distance(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d n = cross(b - a, c - a);
  const double area2 = dot(n, n);
  const auto side = [&](const Vec3d& u, const Vec3d& v) { return dot(cross(v - u, p - u), n) >= 0; };
  if (area2 > 0 && side(a, b) && side(b, c) && side(c, a)) return std::fabs(dot(p - a, n)) / std::sqrt(area2);
  const auto from_edge = [&](const Vec3d& u, const Vec3d& v) {
    const Vec3d e = v - u;
    const double t = std::min(1.0, std::max(0.0, dot(p - u, e) / std::max(dot(e, e), 1e-300)));
    return length(p - u - e * t);
  };
  return std::min({from_edge(a, b), from_edge(b, c), from_edge(c, a)});
}

struct Corners {
  Vec3d a, b, c, middle, normal;
  double reach = 0;  ///< of the corners from the middle
};

std::vector<Corners> corners_of(const SurfaceMesh& m) {
  std::vector<Corners> all;
  const auto at = [&](std::size_t k) { return cast<double>(m.position[m.triangles[k]]); };
  for (std::size_t t = 0; t + 2 < m.triangles.size(); t += 3) {
    Corners k{at(t), at(t + 1), at(t + 2), {}, {}};
    const Vec3d n = cross(k.b - k.a, k.c - k.a);
    k.middle = (k.a + k.b + k.c) * (1.0 / 3);
    k.normal = n * (1 / length(n));
    k.reach = std::max({length(k.a - k.middle), length(k.b - k.middle), length(k.c - k.middle)});
    all.push_back(k);
  }
  return all;
}

/// Triangles of `a` whose middle and corners are all nearer than `near` to triangles of `b` that face against
/// them. Those of `b` are looked up by the x of their middle: all pairs took longer than what is tested.
std::size_t coinciding(const SurfaceMesh& a, const SurfaceMesh& b, double near) {
  std::multimap<double, Corners> others;
  double reach = near;
  for (const Corners& o : corners_of(b)) {
    others.emplace(o.middle.x, o);
    reach = std::max(reach, o.reach + near);
  }
  const auto met = [&](const Vec3d& p, const Vec3d& normal) {
    const auto end = others.upper_bound(p.x + reach);
    for (auto at = others.lower_bound(p.x - reach); at != end; ++at) {
      const Corners& o = at->second;
      if (length(p - o.middle) < o.reach + near && dot(normal, o.normal) < -0.7 &&
          distance(p, o.a, o.b, o.c) < near)
        return true;
    }
    return false;
  };
  std::size_t count = 0;
  for (const Corners& t : corners_of(a))
    count +=
        met(t.middle, t.normal) && met(t.a, t.normal) && met(t.b, t.normal) && met(t.c, t.normal) ? 1 : 0;
  return count;
}

/// How often a closed mesh winds around a point: 1 inside, 0 outside (van Oosterom & Strackee 1983).
double winding(const std::vector<Corners>& mesh, const Vec3d& p) {
  double sum = 0;
  for (const Corners& t : mesh) {
    const Vec3d a = t.a - p, b = t.b - p, c = t.c - p;
    const double la = length(a), lb = length(b), lc = length(c);
    sum +=
        2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4 * pi);
}

// The solids' mesh is the interface of both, so no sheet of the liquid lies on it: not one triangle within a
// hundredth of a cell of triangles that face against it. With closed_at_solids there are many (73 or more), so
// that the check is known to see them. A block under water all around leaves no trace in the liquid's mesh; the
// ellipsoids leave pockets at its edges, and those have walls.
TEST_P(Kernels, NoSheetOfLiquidCoincidesWithASolid) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool floats : {false, true}) {
    Scene s = floats ? afloat() : submerged();
    for (const double cell : {0.1, 0.2 / 3})
      for (const int smoothing : {0, 4}) {
        SurfaceDesc d = desc();
        d.cell = cell;
        d.smoothing = smoothing;
        const SurfaceMesh water = value_of(s.world.surface(d));
        d.closed_at_solids = true;
        const SurfaceMesh closed = value_of(s.world.surface(d));
        d.of = SurfaceOf::solids;
        const SurfaceMesh ice = value_of(s.world.surface(d));
        EXPECT_EQ(coinciding(water, ice, cell / 100), 0u);
        EXPECT_EQ(coinciding(ice, water, cell / 100), 0u);
        EXPECT_GT(coinciding(ice, closed, cell / 100), 30u);  // hundreds in most of these
        EXPECT_LT(water.triangles.size(), closed.triangles.size());
        if (floats || d.kernel == SurfaceKernel::anisotropic) continue;
        EXPECT_EQ(expect_surface(water, cell).euler, std::vector<int>{2});
      }
  }
}

// Where ice stands out of the water the liquid's mesh ends inside the ice, so that there is no gap to see
// through: every vertex of an open edge is in the ice or, where smoothing has moved the ice away at its corners,
// within a tenth of a cell of it. Every other edge lies between two triangles.
TEST_P(Kernels, LiquidEndsInsideSolids) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = afloat();
  for (const int smoothing : {0, 4}) {
    SurfaceDesc d = desc();
    d.smoothing = smoothing;
    const SurfaceMesh water = value_of(s.world.surface(d));
    d.of = SurfaceOf::solids;
    const SurfaceMesh ice = value_of(s.world.surface(d));
    const MeshCheck c = check_mesh(water);
    EXPECT_EQ(c.unused, 0u);
    EXPECT_GT(c.smallest_area, 1e-5 * 0.1 * 0.1);
    for (const Vec3f& n : water.normal) ASSERT_NEAR(length(n), 1, 1e-5);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    for (std::size_t t = 0; t < water.triangles.size(); t += 3)
      for (std::size_t k = 0; k < 3; ++k)
        ++directed[{water.triangles[t + k], water.triangles[t + (k + 1) % 3]}];
    std::set<std::uint32_t> ends;
    for (const auto& [edge, count] : directed) {
      ASSERT_EQ(count, 1);
      if (directed.count({edge.second, edge.first}) == 0) ends.insert({edge.first, edge.second});
    }
    EXPECT_GT(ends.size(), 20u);  // around a block of three spacings, cells of half a spacing
    const std::vector<Corners> sheet = corners_of(ice);
    for (const std::uint32_t v : ends) {
      const Vec3d p = cast<double>(water.position[v]);
      double off = 1e30;
      for (const Corners& t : sheet) off = std::min(off, distance(p, t.a, t.b, t.c));
      EXPECT_LT(off, 0.6 * 0.1) << v;  // the overlap, and what smoothing moves
      if (off > 0.1 * 0.1) {
        EXPECT_GT(winding(sheet, p), 0.5) << v << " off " << off;
      }
    }
  }
}

// A dry body has no film of liquid on it, and liquid that touches nothing solid is as without it.
TEST(Surface, DrySolidsCarryNoLiquid) {
  MELTSIM_NEEDS_BACKEND();
  IceScene s;
  s.block_floor = 1.8;  // 0.8 m above the water
  WorldDesc d = describe();
  d.hydrostatic_start = false;  // what may fall farther makes sound faster, which compresses water less
  Scene with = ice_in_water(d, s);
  s.block = 0;
  Scene without = ice_in_water(d, s);
  const SurfaceMesh a = value_of(with.world.surface()), b = value_of(without.world.surface());
  ASSERT_EQ(a.position.size(), b.position.size());
  EXPECT_EQ(a.triangles, b.triangles);
  for (std::size_t v = 0; v < a.position.size(); ++v) ASSERT_EQ(length(a.position[v] - b.position[v]), 0);
}

// A level surface is level up to the face of a body beside it, at any size of cells: what is dry of that face raises it by nothing. A
// tenth of a spacing, where it climbed by 0.4 to 0.8; at a wall it is right.
TEST(Surface, WaterMeetsBodiesLevel) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = weightless();
  d.domain.bounded = true;
  d.domain.max = {2, 2, 2};
  World w = liquid(d, {sites({0, 0, 0}, {14, 10, 20})});
  MaterialDesc steel;
  steel.name = "steel";
  SolidDesc body;
  body.material = value_of(w.add_material(steel));
  body.shape = sites({14, 0, 0}, {20, 20, 20});
  body.fixed = true;
  value_of(w.add_solid(body));
  for (const double cells : {2, 4}) {
    SurfaceDesc how;
    how.cell = dx / cells;
    const SurfaceMesh m = value_of(w.surface(how));
    double highest = 0;
    for (const auto& x : m.position)
      if (x.z > 0.3f && x.z < 1.7f) highest = std::max<double>(highest, x.y);
    EXPECT_NEAR(highest, 1.0, 0.1 * dx) << cells << " cells to a spacing";
  }
}

TEST(Surface, VerticesCarryWhatParticlesDo) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = submerged();
  const SurfaceMesh water = value_of(s.world.surface());
  SurfaceDesc d;
  d.of = SurfaceOf::solids;
  const SurfaceMesh ice = value_of(s.world.surface(d));
  for (std::size_t v = 0; v < water.position.size(); ++v) {
    ASSERT_NEAR(water.temperature[v], 80, 1e-3);
    ASSERT_NEAR(water.liquid_fraction[v], 1, 1e-6);
    ASSERT_EQ(water.body[v], 0u);
  }
  for (std::size_t v = 0; v < ice.position.size(); ++v) {
    ASSERT_NEAR(ice.temperature[v], -10, 1e-3);
    ASSERT_EQ(ice.liquid_fraction[v], 0);
    ASSERT_EQ(ice.body[v], 1u);
  }
}

/// Number of the particle that lies nearest to x, among those of a phase; none where two lie about as near.
std::size_t nearest(const ParticleData& p, const Vec3d& x, bool solid) {
  std::size_t best = p.id.size();
  double first = 1e30, second = 1e30;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (is_solid(p.tag[i]) != solid) continue;
    const double r = length(p.position[i] - x);
    if (r < first) best = i;
    second = std::min(second, std::max(r, first));
    first = std::min(first, r);
  }
  return second - first > 1e-5 * dx ? best : p.id.size();
}

// Where all particles have the same volume the heaviest one is the nearest. Two liquids side by side, a third
// around a solid of a fourth material: every vertex names the nearest particle's, and all four are named.
TEST(Surface, VerticesNameTheMaterialOfTheHeaviestParticle) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless());
  std::vector<MaterialId> ids;
  for (const char* name : {"water", "oil", "syrup", "stone"}) {
    MaterialDesc m;
    m.name = name;
    ids.push_back(value_of(w.add_material(m)));
  }
  const auto fill = [&](std::size_t material, Vec3i low, Vec3i high) {
    FluidDesc f;
    f.shape = sites(low, high);
    f.material = ids[material];
    value_of(w.add_fluid(f));
  };
  fill(0, {0, 0, 0}, {6, 6, 6});
  fill(1, {6, 0, 0}, {12, 6, 6});
  fill(2, {0, 6, 0}, {12, 12, 6});
  SolidDesc b;
  b.shape = sites({3, 9, 0}, {9, 15, 6});
  b.material = ids[3];
  value_of(w.add_solid(b));
  const ParticleData p = value_of(w.particles());
  std::map<std::uint32_t, std::size_t> named;
  for (const auto of : {SurfaceOf::liquid, SurfaceOf::solids})
    for (const auto kernel : {SurfaceKernel::isotropic, SurfaceKernel::anisotropic}) {
      SurfaceDesc d;
      d.of = of;
      d.kernel = kernel;
      d.closed_at_solids = true;
      const SurfaceMesh m = value_of(w.surface(d));
      expect_surface(m, dx / 2);
      for (std::size_t v = 0; v < m.position.size(); ++v) {
        const std::size_t i = nearest(p, cast<double>(m.position[v]), of == SurfaceOf::solids);
        if (i == p.id.size()) continue;
        ASSERT_EQ(m.material[v], material_of(p.tag[i])) << v;
        ++named[m.material[v]];
      }
    }
  ASSERT_EQ(named.size(), 4u);
  for (const auto& [material, count] : named) EXPECT_GT(count, 200u) << material;
}

TEST(Surface, OneBodyOfSeveral) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless());
  MaterialDesc stone;
  stone.name = "stone";
  const MaterialId id = value_of(w.add_material(stone));
  std::vector<BodyId> bodies;
  for (int k = 0; k < 3; ++k) {
    SolidDesc b;
    b.shape = sites({10 * k, 0, 0}, {10 * k + 3 + k, 3, 3});
    b.material = id;
    bodies.push_back(value_of(w.add_solid(b)));
  }
  SurfaceDesc d;
  d.of = SurfaceOf::solids;
  const MeshCheck all = expect_surface(value_of(w.surface(d)), dx / 2);
  EXPECT_EQ(all.euler, (std::vector<int>{2, 2, 2}));
  d.of = SurfaceOf::body;
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    d.body = bodies[k];
    const SurfaceMesh m = value_of(w.surface(d));
    const MeshCheck c = expect_surface(m, dx / 2);
    EXPECT_EQ(c.euler, std::vector<int>{2});
    sum += c.volume;
    for (const std::uint32_t b : m.body) ASSERT_EQ(b, k + 1);
  }
  EXPECT_NEAR(sum, all.volume, 1e-5 * sum);  // far apart: nothing but the order of single-precision sums
}

bool same(const SurfaceMesh& a, const SurfaceMesh& b) {
  const auto equal = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0);
  };
  return equal(a.position, b.position) && equal(a.normal, b.normal) && equal(a.temperature, b.temperature) &&
         equal(a.liquid_fraction, b.liquid_fraction) && equal(a.body, b.body) &&
         equal(a.material, b.material) && equal(a.triangles, b.triangles);
}

TEST(Surface, BitsDoNotDependOnTheNumberOfThreads) {
  MELTSIM_NEEDS_BACKEND();
  for (const auto precision : {Precision::single_precision, Precision::double_precision}) {
    std::vector<SurfaceMesh> meshes;
    for (const int threads : {1, 2, 3, 8}) {
      WorldDesc d = describe();
      d.threads = threads;
      d.precision = precision;
      Scene s = ice_in_water(d);
      for (int k = 0; k < 60; ++k) require(s.world.step(0.005));
      SurfaceDesc closed;
      closed.closed_at_solids = true;
      expect_surface(value_of(s.world.surface(closed)), 0.1, -1);
      meshes.push_back(value_of(s.world.surface()));
      EXPECT_TRUE(same(meshes.front(), meshes.back())) << threads;
    }
  }
}

// Working space is kept: what an earlier surface left in it, larger or smaller, must not show; nor may asking
// show in the state.
TEST(Surface, IsAFunctionOfTheState) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe()), b = ice_in_water(describe());
  SurfaceDesc fine, solids;
  fine.cell = 0.05;
  solids.of = SurfaceOf::solids;
  for (int k = 0; k < 40; ++k) {
    require(a.world.step(0.005));
    require(b.world.step(0.005));
    if (k % 4 == 0) {
      require(a.world.surface());
      require(a.world.surface(fine));
      require(a.world.surface(solids));
    }
  }
  EXPECT_TRUE(same(value_of(a.world.surface()), value_of(b.world.surface())));
  EXPECT_TRUE(same(value_of(a.world.surface(solids)), value_of(b.world.surface(solids))));
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
}

// A jet into a tank without a floor: particles come and go, the mesh holds those that are there. Falling, it
// is drawn out to strings and drops, which come out up to half too large.
// Where the backend is the host, pointers can be looked at: the view is the mesh, also after steps were taken.
TEST(Surface, TheViewIsTheMesh) {
  WorldDesc d = weightless();
  d.backend = Backend::cpu;
  d.gravity = {0, -9.81, 0};
  World w = liquid(d, {Shape::sphere({0.5, 0.5, 0.5}, 0.3)});
  const SurfaceMesh mesh = value_of(w.surface());
  const SurfaceView view = value_of(w.surface_view());
  require(w.step(0.01));
  ASSERT_EQ(view.backend, Backend::cpu);
  ASSERT_EQ(view.vertices, mesh.position.size());
  ASSERT_EQ(3 * view.triangles, mesh.triangles.size());
  ASSERT_GT(view.triangles, 100u);
  const auto same = [](const auto* a, const auto& b) {
    return std::memcmp(a, b.data(), b.size() * sizeof b[0]) == 0;
  };
  EXPECT_TRUE(same(view.position, mesh.position));
  EXPECT_TRUE(same(view.normal, mesh.normal));
  EXPECT_TRUE(same(view.temperature, mesh.temperature));
  EXPECT_TRUE(same(view.liquid_fraction, mesh.liquid_fraction));
  EXPECT_TRUE(same(view.body, mesh.body));
  EXPECT_TRUE(same(view.material, mesh.material));
  EXPECT_TRUE(same(view.triangle, mesh.triangles));
  // A CPU has the size at once, whoever waits.
  ASSERT_NE(view.draw, nullptr);
  SurfaceDesc enqueued;
  enqueued.wait = false;
  const SurfaceView now = value_of(w.surface_view(enqueued));
  const SurfaceMesh later = value_of(w.surface());
  ASSERT_EQ(now.vertices, later.position.size());
  ASSERT_EQ(3 * now.triangles, later.triangles.size());
  EXPECT_EQ(now.draw->indices, later.triangles.size());
  EXPECT_EQ(now.draw->instances, 1u);
  EXPECT_EQ(now.draw->first_index + now.draw->first_instance, 0u);
  EXPECT_EQ(now.draw->vertex_offset, 0);
  // Of nothing, and of what is no description.
  SurfaceDesc solids;
  solids.of = SurfaceOf::solids;
  const SurfaceView none = value_of(w.surface_view(solids));
  EXPECT_EQ(none.vertices, 0u);
  EXPECT_EQ(none.triangle, nullptr);
  EXPECT_EQ(none.draw, nullptr);
  SurfaceDesc wrong;
  wrong.cell = -1;
  EXPECT_EQ(w.surface_view(wrong).error().code, ErrorCode::invalid_argument);
}

TEST(Surface, FollowsWhatIsEmittedAndWhatLeaves) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.2, 1.2};
  d.domain.faces[2] = Face::open;
  World w = make(d);
  EmitterDesc e;
  e.material = value_of(w.add_material({}));
  e.center = {0.6, 1.0, 0.6};
  e.axis = {0, -1, 0};
  e.radius = 0.25;
  e.speed = 2;
  e.until = 0.6;
  require(w.add_emitter(e));
  std::uint64_t most = 0;
  for (int k = 0; k < 240; ++k) {
    require(w.step(0.005));
    if (k % 20 != 19) continue;
    const StepResult r = w.synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    most = std::max(most, r.fluid);
    const SurfaceMesh m = value_of(w.surface());
    if (r.fluid == 0) {
      EXPECT_TRUE(m.position.empty());
      continue;
    }
    const MeshCheck c = expect_surface(m, dx / 2, -1);
    // Once the nozzle has ended, the tail of the stream is drawn out until its layers are farther apart than the field
    // reaches, and what they enclose is less.
    if (k < 120) {
      EXPECT_NEAR(c.volume / (static_cast<double>(r.fluid) * cube), 1.2, 0.4) << k;
    }
  }
  EXPECT_GT(most, 50u);
  EXPECT_EQ(w.synchronize().fluid, 0u);
}

// Asked for behind a step that diverged, before anybody looked: the last good state's.
TEST(Surface, OfAWorldThatHalted) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<SurfaceMesh> meshes;
  for (const bool diverges : {false, true}) {
    WorldDesc scene = describe();
    scene.sound_speed = 5;
    scene.gravity = {1000, 0, 0};
    World w = make(scene);
    MaterialDesc stone;
    stone.name = "stone";
    SolidDesc b;
    b.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
    b.material = value_of(w.add_material(stone));
    value_of(w.add_solid(b));
    for (int k = 0; k < 60; ++k) require(w.step(1e-3));  // 60 m/s
    if (diverges)
      for (int k = 0; k < 2; ++k) require(w.step(8.9e-3));  // more than H at once
    SurfaceDesc d;
    d.of = SurfaceOf::solids;
    meshes.push_back(value_of(w.surface(d)));
    EXPECT_EQ(w.synchronize().halted, diverges);
  }
  expect_surface(meshes[0], 0.1);
  EXPECT_TRUE(same(meshes[0], meshes[1]));
}

TEST(Surface, NothingHasNoSurface) {
  MELTSIM_NEEDS_BACKEND();
  World empty = make(weightless());
  World water = liquid(weightless(), {sites({0, 0, 0}, {3, 3, 3})});
  SurfaceDesc solids;
  solids.of = SurfaceOf::solids;
  for (World* w : {&empty, &water}) {
    const SurfaceMesh m = value_of(w->surface(solids));
    EXPECT_TRUE(m.position.empty());
    EXPECT_TRUE(m.triangles.empty());
  }
  EXPECT_TRUE(value_of(empty.surface()).position.empty());
  IceScene dry;
  dry.water = false;
  Scene ice = ice_in_water(describe(), dry);
  EXPECT_TRUE(value_of(ice.world.surface()).position.empty());
  EXPECT_FALSE(value_of(ice.world.surface(solids)).position.empty());
}

// A million metres out: positions relative to an origin, in both precisions.
TEST(Surface, FarFromTheOrigin) {
  MELTSIM_NEEDS_BACKEND();
  for (const auto precision : {Precision::single_precision, Precision::double_precision}) {
    WorldDesc d = weightless();
    d.precision = precision;
    d.domain.bounded = true;
    d.domain.min = {1e6, 0, -1e6};
    d.domain.max = {1e6 + 2, 2, -1e6 + 2};
    const Vec3d centre{1e6 + 1, 1, -1e6 + 1};
    World w = liquid(d, {Shape::sphere(centre, 0.5)});
    const SurfaceMesh m = value_of(w.surface());
    expect_surface(m, dx / 2);
    for (const Vec3f& p : m.position) ASSERT_NEAR(length(m.origin + cast<double>(p) - centre), 0.5, 0.8 * dx);
  }
}

TEST(Surface, RefusesWhatItCannotDo) {
  MELTSIM_NEEDS_BACKEND();
  World w = liquid(weightless(), {sites({0, 0, 0}, {3, 3, 3})});
  const std::uint64_t before = *w.state_hash();
  const auto refused = [&](const SurfaceDesc& d, const char* field) {
    const auto r = w.surface(d);
    ASSERT_FALSE(r);
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(field), std::string::npos) << r.error().message;
  };
  for (const double cell : {-0.1, 0.001, 0.3, std::nan(""), infinity}) {
    SurfaceDesc d;
    d.cell = cell;
    refused(d, "cell");
  }
  for (const int passes : {-1, 101}) {
    SurfaceDesc d;
    d.smoothing = passes;
    refused(d, "smoothing");
  }
  SurfaceDesc body;
  body.of = SurfaceOf::body;
  refused(body, "body");
  SurfaceDesc unawaited;
  unawaited.wait = false;
  refused(unawaited, "wait");
  if (w.backend() == Backend::cpu) {
    int nothing = 0;
    for (const Status& s : {w.wait_for(&nothing), w.signal(&nothing)}) {
      ASSERT_FALSE(s);
      EXPECT_EQ(s.error().code, ErrorCode::invalid_argument);
      EXPECT_NE(s.error().message.find("on the CPU"), std::string::npos) << s.error().message;
    }
  }
  EXPECT_EQ(*w.state_hash(), before);
}

INSTANTIATE_TEST_SUITE_P(Surface, Kernels,
                         ::testing::Values(SurfaceKernel::isotropic, SurfaceKernel::anisotropic),
                         [](const auto& info) {
                           return info.param == SurfaceKernel::isotropic ? "Isotropic" : "Anisotropic";
                         });

}  // namespace
}  // namespace meltsim_test
