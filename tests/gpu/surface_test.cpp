// SPDX-License-Identifier: Apache-2.0
// Surfaces on CPU and CUDA of the same state: a scene that has been moving for a while, written by the CPU
// and restored on both.
//
// Tolerances. In double precision the fields differ by a few units of 1e-16 (fused operations, roots on the
// GPU), far from changing a node's sign, so both have the same triangles, and vertices agree to the rounding
// of single-precision output: 1.2e-7 of 1.6 m, ten times because edges' crossings divide by a difference of
// the field. In single precision a sum over 65 neighbours differs by 3e-7; a node closer to the level than
// that, one of some 1e5, is inside on one side only, so counts may differ by a few and volume and area are
// compared instead.
#include <algorithm>
#include <cmath>

#include "gpu/melting_scene.hpp"
#include "support/mesh_check.hpp"
#include "support/require_gpu.hpp"

namespace {

using namespace gpu_test;
using namespace meltsim;
using test_support::check_mesh;
using test_support::MeshCheck;

std::vector<std::uint8_t> developed(MeltingScene scene) {
  scene.backend = Backend::cpu;
  World world = make_world(scene);
  hash_after(world, 60);
  return value_of(world.snapshot());
}

World restored(MeltingScene scene, Backend backend, const std::vector<std::uint8_t>& state) {
  scene.backend = backend;
  World world = make_world(scene);
  succeed(world.restore(state.data(), state.size()));
  return world;
}

/// The first body of a World of the scene.
BodyId first_body(World& world) {
  for (const PieceInfo& piece : value_of(world.pieces()))
    if (piece.body.index == 0) return piece.body;
  ADD_FAILURE() << "the first body has no piece";
  return {};
}

/// Every kind of surface of the scene.
std::vector<SurfaceDesc> all_kinds() {
  std::vector<SurfaceDesc> all;
  for (const auto of : {SurfaceOf::liquid, SurfaceOf::solids, SurfaceOf::body})
    for (const auto kernel : {SurfaceKernel::isotropic, SurfaceKernel::anisotropic})
      for (const double cell : {0.0, spacing / 3}) {
        SurfaceDesc d;
        d.of = of;
        d.kernel = kernel;
        d.cell = cell;
        all.push_back(d);
        if (of != SurfaceOf::liquid) continue;
        d.closed_at_solids = true;
        all.push_back(d);
      }
  return all;
}

/// Makes the surface, of the first body where of one is asked.
SurfaceMesh surface_of(World& world, SurfaceDesc d) {
  if (d.of == SurfaceOf::body) d.body = first_body(world);
  return value_of(world.surface(d));
}

class SurfaceParity : public ::testing::TestWithParam<Precision> {
 protected:
  void SetUp() override {
    MELTSIM_NEEDS_GPU();
    scene_.precision = GetParam();
    scene_.second_ice = 3;
  }
  MeltingScene scene_;
};

TEST_P(SurfaceParity, BothBackendsMakeTheSameMesh) {
  const auto state = developed(scene_);
  World cpu = restored(scene_, Backend::cpu, state), cuda = restored(scene_, Backend::cuda, state);
  const bool exact = GetParam() == Precision::double_precision;
  for (const SurfaceDesc& d : all_kinds()) {
    const SurfaceMesh a = surface_of(cpu, d), b = surface_of(cuda, d);
    const MeshCheck ca = check_mesh(a), cb = check_mesh(b);
    const bool closed = d.of != SurfaceOf::liquid || d.closed_at_solids;
    EXPECT_EQ(cb.unused, 0u);
    if (closed) {
      EXPECT_EQ(cb.open_edges, 0u);
      EXPECT_EQ(cb.split, 0u);
    }
    if (exact) {
      EXPECT_EQ(cb.open_edges, ca.open_edges);
    }
    EXPECT_NEAR(cb.volume / ca.volume, 1, 1e-5);
    EXPECT_NEAR(cb.area / ca.area, 1, 1e-5);
    const double count = static_cast<double>(a.triangles.size());
    EXPECT_NEAR(static_cast<double>(b.triangles.size()), count, exact ? 0.0 : 1e-3 * count);
    if (!exact || a.position.size() != b.position.size()) continue;
    EXPECT_TRUE(a.triangles == b.triangles);
    EXPECT_TRUE(a.body == b.body);
    EXPECT_TRUE(a.material == b.material);
    double apart = 0, turned = 0, warmer = 0;
    for (std::size_t v = 0; v < a.position.size(); ++v) {
      apart = std::max(apart, static_cast<double>(length(a.position[v] - b.position[v])));
      turned = std::max(turned, static_cast<double>(length(a.normal[v] - b.normal[v])));
      warmer = std::max(warmer, static_cast<double>(std::fabs(a.temperature[v] - b.temperature[v])));
    }
    EXPECT_LT(apart, 2e-6);
    EXPECT_LT(turned, 1e-4);  // of a sliver, whose sides are a hundredth of a cell
    EXPECT_LT(warmer, 1e-4);  // of 80 degrees in single precision
  }
}

bool same(const SurfaceMesh& a, const SurfaceMesh& b) {
  if (a.position.size() != b.position.size() || a.triangles != b.triangles || a.body != b.body ||
      a.material != b.material || a.temperature != b.temperature || a.liquid_fraction != b.liquid_fraction)
    return false;
  for (std::size_t v = 0; v < a.position.size(); ++v)
    if (length(a.position[v] - b.position[v]) != 0 || length(a.normal[v] - b.normal[v]) != 0) return false;
  return true;
}

// Asked for again and again, with steps in between and without: the same bits, recorded (third time on) or
// not, and the state goes on as if nobody had asked.
TEST_P(SurfaceParity, AskingTwiceGivesTheSameBitsAndLeavesNoTrace) {
  const auto state = developed(scene_);
  World asked = restored(scene_, Backend::cuda, state), other = restored(scene_, Backend::cuda, state);
  for (int round = 0; round < 3; ++round) {
    for (const SurfaceDesc& d : all_kinds()) {
      const SurfaceMesh first = surface_of(asked, d);
      for (int k = 0; k < 3; ++k) EXPECT_TRUE(same(first, surface_of(asked, d)));
      if (round != 2) continue;
      EXPECT_TRUE(same(first, surface_of(other, d)));
    }
    step(asked, 7);
    step(other, 7);
    if (round == 2) break;
  }
  EXPECT_EQ(value_of(asked.state_hash()), value_of(other.state_hash()));
}

INSTANTIATE_TEST_SUITE_P(Precisions, SurfaceParity,
                         ::testing::Values(Precision::single_precision, Precision::double_precision),
                         [](const auto& info) { return name_of(info.param); });

}  // namespace
