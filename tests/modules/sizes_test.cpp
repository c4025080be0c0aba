// SPDX-License-Identifier: Apache-2.0
// Sizes that no test can hold in memory, and crowds that no host can make: the engine's arithmetic of bytes,
// its refusal of what does not fit, and 500 particles in a tenth of a spacing.
#include <algorithm>
#include <cmath>

#include "modules/engine.hpp"

namespace {

using namespace modules_test;

constexpr double dx = 0.2, H = 0.5;

core::FieldSet only(std::initializer_list<int> fields) {
  core::FieldSet set = 0;
  for (const int f : fields) set |= core::FieldSet{1} << f;
  return set;
}

template <class T>
class EngineSizes : public testing::Test {
 protected:
  /// Bytes of these channels for so many particles, without allocating one.
  static std::uint64_t bytes(std::uint32_t particles, core::FieldSet channels, bool periodic = false) {
    core::SceneConstants c = plain_constants(dx);
    if (periodic) {
      c.domain.bounded = true;
      c.domain.max = {1e3, 1e3, 1e3};  // 8e9 cells: more than particles
      c.domain.faces[0] = c.domain.faces[1] = Face::periodic;
    }
    core::EngineSetup setup;
    setup.particle_capacity = particles;
    setup.channels = channels;
    return Rig<T>().engine->bytes_needed(c, {}, setup);
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(EngineSizes, Scalars);

// Around 2^31 and 2^32 bytes and entries, up to the most particles that ids can number: no product is cut to
// 32 bits. A state channel has two buffers, rows are 9 to a group, of which there may be one per particle.
TYPED_TEST(EngineSizes, BytesAreCountedIn64Bits) {
  const std::uint64_t real = sizeof(TypeParam);
  for (const std::uint32_t n :
       {1u, 29826161u, 29826162u, 134217728u, 268435456u, 477218588u, 477218589u, 2147483648u, 4294967294u}) {
    const std::uint64_t many = n;
    EXPECT_EQ(this->bytes(n, only({core::field_position})), many * 4 * real * 2) << n;
    EXPECT_EQ(this->bytes(n, only({core::field_tag})), many * 4 * 2) << n;
    EXPECT_EQ(this->bytes(n, only({core::field_density})), many * real) << n;
    // 16 words of 8 bytes and their count at this support, 6 more where rows wrap; columns are whole warps.
    // In builds that are to have a GPU's bits few particles have three sets of 7 words, 9 where rows wrap.
    const std::uint64_t column = (many + 31) / 32 * 32 * 8;
    const bool one_set = core::sums_by_lanes || n >= core::gather_few;
    EXPECT_EQ(this->bytes(n, only({core::field_neighbour_words})), column * (one_set ? 17 : 3 * 8)) << n;
    EXPECT_EQ(this->bytes(n, only({core::field_neighbour_words}), true), column * (one_set ? 23 : 3 * 10))
        << n;
    EXPECT_EQ(this->bytes(n, only({core::field_group_ranges})), many * 9 * 8) << n;
    EXPECT_EQ(this->bytes(n, only({core::field_position, core::field_group_ranges})), many * (8 * real + 72))
        << n;
  }
}

// Cells have 32-bit numbers, and offsets between them a sign: 31 bits, however many particles there are. The domain has
// 1280^3 cubes of H, 2.10e9: one to a cube can just be counted (2^31 is 2.15e9), two along x cannot.
TEST(CountedCells, AreNumberedIn31Bits) {
  DomainDesc d;
  d.bounded = true;
  d.max = {1280, 1280, 1280};
  EXPECT_EQ(core::packed_reach(d, 1.0, 4294967294u), 1);
  d.max = {1300, 1300, 1300};  // 2.2e9
  EXPECT_EQ(core::packed_reach(d, 1.0, 4294967294u), 0);
  d.max = {10, 10, 10};  // 1000 particles, 6000 cells
  EXPECT_EQ(core::packed_reach(d, 1.0, 1000), 6);
}

// What does not fit is refused before anything is allocated, with both numbers; the same engine then takes a
// smaller scene.
TYPED_TEST(EngineSizes, WhatDoesNotFitTheDeviceIsRefusedWithBothNumbers) {
  PermutingExec<TypeParam> exec;
  exec.limit_memory(2000000);
  const auto engine = make_engine<TypeParam>(exec);
  const core::SceneConstants c = plain_constants(dx);
  core::SceneState s;
  for (int n = 0; n < 10; ++n) add_particle(s, c, {n * dx, 0, 0}, 0);
  core::EngineSetup setup;
  setup.facts = core::fact_particles | core::fact_fluid | core::fact_sorted | core::fact_sparse;
  setup.channels = core::channels_for(setup.facts);
  setup.particle_capacity = 4000000000u;  // 930 GB
  const std::uint64_t needed = engine->bytes_needed(c, {}, setup);
  EXPECT_GT(needed, std::uint64_t{400000000000});
  const Status refused = engine->upload(c, {}, s, setup);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
  char number[32];
  std::snprintf(number, sizeof number, "%.1f GB needed", double(needed) / 1e9);
  EXPECT_NE(refused.error().message.find(number), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("0.0 GB free"), std::string::npos) << refused.error().message;
  for (int f = 0; f < core::field_count; ++f) EXPECT_EQ(engine->channel_bytes(f), 0u);
  setup.particle_capacity = 10;
  const Status fits = engine->upload(c, {}, s, setup);
  EXPECT_TRUE(fits) << fits.error().message;
}

// 500 particles within a tenth of a spacing, and 500 at one point: the neighbours of each are all of them,
// the density is their sum, and what follows - a pressure of 100^7 - is refused by step.integrate and never
// committed.
TYPED_TEST(EngineSizes, ACrowdInOneCellIsSummedAndRefused) {
  for (const double spread : {0.1 * dx, 0.0}) {
    core::SceneConstants c = plain_constants(dx);
    c.surroundings.gravity = {0, 0, 0};
    core::SceneState s;
    Random random(91);
    for (int n = 0; n < 500; ++n)
      add_particle(s, c, Vec3d{0.25, 0.25, 0.25} + random.vector(0.5 * spread), 0);
    Rig<TypeParam> rig;
    rig.upload(c, {}, s, core::fact_particles | core::fact_fluid);
    rig.run({"step.begin", "spatial", "sph"}, 1e-3);
    const core::Frame<TypeParam>& w = rig.frame();
    ASSERT_EQ(w.particles, 500u);
    const auto kernel = physics::make_kernel<double>(H, dx);
    for (std::uint32_t i = 0; i < 500; ++i) {
      double phi = 0;
      for (std::uint32_t j = 0; j < 500; ++j)
        phi += dx * dx * dx *
               physics::kernel_value(
                   kernel, length(cast<double>(xyz(w.f.position[i])) - cast<double>(xyz(w.f.position[j]))));
      EXPECT_GT(phi, 90);
      ASSERT_NEAR(static_cast<double>(w.f.density[i]) / phi, 1, sizeof(TypeParam) == 4 ? 1e-5 : 1e-12) << i;
    }
    Rig<TypeParam> whole;
    whole.upload(c, {}, s, core::fact_particles | core::fact_fluid);
    whole.run({"step.begin", "spatial", "sph", "step.integrate"}, 1e-3);
    if (spread >
        0) {  // who cannot be gone on with stays, so that whoever looks before it is known finds a place
      const core::Frame<TypeParam>& found = whole.frame();
      for (std::uint32_t i = 0; i < 500; ++i)
        EXPECT_LT(length(cast<double>(xyz(found.f.position[i])) - Vec3d{0.25, 0.25, 0.25}), dx) << i;
    }
    const core::WorldStatus status = whole.engine->synchronize();
    core::SceneState after;
    whole.engine->download(after);
    if (spread > 0) {
      EXPECT_EQ(static_cast<core::Halt>(status.halted), core::Halt::speed);
      for (std::size_t i = 0; i < 500; ++i)  // as uploaded
        EXPECT_EQ(length(after.position[i] - cast<double>(cast<TypeParam>(s.position[i]))), 0.0) << i;
    } else {  // at one point nothing pushes: no direction, no force
      EXPECT_EQ(static_cast<core::Halt>(status.halted), core::Halt::no);
      for (std::size_t i = 0; i < 500; ++i) EXPECT_EQ(length(after.velocity[i]), 0.0) << i;
    }
  }
}

}  // namespace
