// SPDX-License-Identifier: Apache-2.0
// CPU against CUDA, stage by stage: custom stages after every built-in one copy what a stage may see; a scene
// that has been moving for a while (written by the CPU, restored on both) goes through one step on each.
//
// Errors are medians over particles, relative to the value or, where that is larger, to a hundredth of the
// channel's root mean square: half of the particles agree better than the number given, and values near zero
// do not count.
//
// Tolerances in single precision. 3e-6: a sum over 65 neighbours, fused operations on one side only. Stiff
// channels get more: pressure is c^2 (phi - 1), so one unit in the last place of phi, 1.2e-7, is 1e-4 of a
// pressure with phi - 1 = 1e-3, and roots on the GPU are good to two; accelerations come from differences of
// pressure, velocities from accelerations. In double precision 1e-4 with 2^-52 for 2^-23, times ten.
#include <cuda_runtime_api.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "gpu/melting_scene.hpp"
#include "support/require_gpu.hpp"

namespace {

using namespace gpu_test;

/// One channel in order of id, `width` numbers to a particle.
struct Channel {
  std::size_t width = 1;
  std::vector<double> values;
};

struct Tolerance {
  double plain, stiff;
};

Tolerance tolerance(Precision precision) {
  return precision == Precision::single_precision ? Tolerance{3e-6, 2e-4} : Tolerance{6e-14, 2e-12};
}

double median_error(const Channel& cpu, const Channel& cuda) {
  if (cpu.values.size() != cuda.values.size()) return INFINITY;
  const std::size_t w = cpu.width, n = cpu.values.size() / w;
  if (n == 0) return 0;
  std::vector<double> size(n, 0.0), error(n, 0.0);
  double square = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < w; ++k) {
      const double a = cpu.values[i * w + k], b = cuda.values[i * w + k];
      size[i] += a * a;
      error[i] += (a - b) * (a - b);
    }
    square += size[i];
  }
  const double floor = 1e-2 * std::sqrt(square / static_cast<double>(n));
  for (std::size_t i = 0; i < n; ++i) {
    error[i] = std::sqrt(error[i]);
    if (error[i] > 0) error[i] /= std::max(std::sqrt(size[i]), floor);
    if (std::isnan(error[i])) error[i] = INFINITY;
  }
  std::nth_element(error.begin(), error.begin() + static_cast<std::ptrdiff_t>(n / 2), error.end());
  return error[n / 2];
}

/// Host memory of what a stage sees.
template <class V>
std::vector<V> fetch(const meltsim::StageContext& c, const void* from, std::size_t n) {
  std::vector<V> v(n);
  if (c.backend == Backend::cuda) {
    const auto stream = static_cast<cudaStream_t>(c.stream);
    EXPECT_EQ(cudaMemcpyAsync(v.data(), from, n * sizeof(V), cudaMemcpyDeviceToHost, stream), cudaSuccess);
    EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
  } else {
    std::copy_n(static_cast<const V*>(from), n, v.begin());
  }
  return v;
}

struct Recorder {
  std::string stage;
  std::map<std::string, Channel> channels;
};

/// `used` of every `stride` numbers, reordered by id.
template <class T>
Channel take(const meltsim::StageContext& c, const void* from, std::size_t stride, std::size_t first,
             std::size_t used) {
  const auto n = static_cast<std::size_t>(c.particles);
  const auto id = fetch<std::uint32_t>(c, c.id, n);
  const auto raw = fetch<T>(c, from, n * stride);
  Channel channel{used, std::vector<double>(n * used)};
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < used; ++k)
      channel.values[id[i] * used + k] = static_cast<double>(raw[i * stride + first + k]);
  return channel;
}

template <class T>
void record(const meltsim::StageContext& c, void* user) {
  auto& channels = static_cast<Recorder*>(user)->channels;
  channels["position"] = take<T>(c, c.position, 4, 0, 3);
  channels["volume"] = take<T>(c, c.position, 4, 3, 1);
  channels["velocity"] = take<T>(c, c.velocity, 4, 0, 3);
  channels["operand"] = take<T>(c, c.velocity, 4, 3, 1);
  channels["enthalpy"] = take<double>(c, c.enthalpy, 1, 0, 1);
  if (c.acceleration != nullptr) channels["acceleration"] = take<T>(c, c.acceleration, 3, 0, 3);
}

bool stiff(const std::string& channel) {
  return channel == "operand" || channel == "acceleration" || channel == "velocity" || channel == "pressure";
}

/// A state that has been moving for a while.
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

/// What every stage from the reordering on left behind, in order.
std::vector<Recorder> stages_of_a_step(World& world) {
  std::vector<Recorder> recorders;
  bool ordered = false;  // before that, channels hold an older step
  for (const meltsim::StageReport& stage : world.plan().stages) {
    ordered = ordered || stage.name == "spatial.reorder" || stage.name == "spatial.settle";
    if (ordered && stage.runs && stage.module != "custom") recorders.push_back({stage.name, {}});
  }
  for (Recorder& r : recorders) {
    meltsim::CustomStage stage;
    stage.name = "after " + r.stage;
    stage.run = world.precision() == Precision::single_precision ? record<float> : record<double>;
    stage.user = &r;
    succeed(world.scheduler().insert_after(r.stage, stage));
  }
  step(world, 1);
  world.synchronize();
  for (const Recorder& r : recorders) succeed(world.scheduler().remove("after " + r.stage));
  return recorders;
}

class Parity : public ::testing::TestWithParam<Precision> {
 protected:
  void SetUp() override {
    MELTSIM_NEEDS_GPU();
    scene_.precision = GetParam();
    scene_.second_ice = 3;
  }
  void compare_stages();
  void compare_steps();
  Tolerance allowed() const {
    const Tolerance t = tolerance(GetParam());
    return {slack_ * t.plain, slack_ * t.stiff};
  }
  double slack_ = 1;
  MeltingScene scene_;
};

void Parity::compare_stages() {
  const auto state = developed(scene_);
  World cpu = restored(scene_, Backend::cpu, state), cuda = restored(scene_, Backend::cuda, state);
  const auto expected = stages_of_a_step(cpu), got = stages_of_a_step(cuda);
  ASSERT_EQ(expected.size(), got.size());
  ASSERT_GE(expected.size(), 10u) << "the scene does not run enough stages to say anything";
  const Tolerance t = allowed();
  for (std::size_t s = 0; s < expected.size(); ++s) {
    ASSERT_FALSE(expected[s].channels.empty()) << expected[s].stage << " did not run";
    for (const auto& [name, channel] : expected[s].channels) {
      const double error = median_error(channel, got[s].channels.at(name));
      std::printf("  %-22s %-13s %.1e\n", expected[s].stage.c_str(), name.c_str(), error);
      EXPECT_LE(error, stiff(name) ? t.stiff : t.plain) << expected[s].stage << ": " << name;
    }
  }
}

TEST_P(Parity, EveryStageAgrees) { compare_stages(); }

// Regions of w = 8 go by planes of rows on both backends (engine/lattice.hpp: least_row_width), all of a block's as long
// as nothing has melted inside. Sums over 4,913 members and rigid blocks nearly at rest: a block of 59^3 with w = 3 had 4e-4 and 2e-12 of
// its median speed after one step, 1.5e-2 and 4e-11 after five. (tests/modules/rows_test.cpp holds the sums themselves
// to rounding, on the CPU.)
TEST_P(Parity, EveryStageAgreesWhereRegionsGoByRows) {
  scene_.half_width = 8;
  scene_.side = 32;
  scene_.ice = 20;
  slack_ = 50;
  compare_stages();
  compare_steps();
}

std::map<std::string, Channel> particles_of(World& world) {
  const meltsim::ParticleData d = value_of(world.particles());
  std::map<std::string, Channel> channels;
  for (const auto& [name, from] : {std::pair{"position", &d.position}, std::pair{"velocity", &d.velocity}}) {
    Channel& c = channels[name];
    c.width = 3;
    for (const meltsim::Vec3d& v : *from) c.values.insert(c.values.end(), {v.x, v.y, v.z});
  }
  channels["enthalpy"] = {1, d.enthalpy};
  channels["temperature"] = {1, d.temperature};
  channels["density"] = {1, d.density};
  channels["pressure"] = {1, d.pressure};
  return channels;
}

void Parity::compare_steps() {
  const auto state = developed(scene_);
  World cpu = restored(scene_, Backend::cpu, state), cuda = restored(scene_, Backend::cuda, state);
  ASSERT_EQ(value_of(cpu.state_hash()), value_of(cuda.state_hash()));
  const Tolerance t = allowed();
  int steps = 0;
  for (const int until : {1, 5}) {
    step(cpu, until - steps);
    step(cuda, until - steps);
    steps = until;
    const auto expected = particles_of(cpu), got = particles_of(cuda);
    for (const auto& [name, channel] : expected) {
      const double error = median_error(channel, got.at(name));
      std::printf("  after %d step(s) %-13s %.1e\n", until, name.c_str(), error);
      // Every sub-step adds its own rounding of phi to the velocities: c 6e-8 times a few, against a liquid
      // that is nearly at rest.
      EXPECT_LE(error, until * (stiff(name) ? t.stiff : t.plain)) << name << " after " << until;
    }
    const auto a = value_of(cpu.totals()), b = value_of(cuda.totals());
    // The same masses in another order: each addition rounds by half a unit in the last place of the sum at most.
    EXPECT_NEAR(a.mass, b.mass, static_cast<double>(a.fluid + a.solid) * 0x1p-53 * a.mass);
    EXPECT_EQ(a.fluid, b.fluid);
    EXPECT_EQ(a.solid, b.solid);
    EXPECT_NEAR(b.thermal, a.thermal, t.plain * std::fabs(a.thermal));
  }
}

TEST_P(Parity, WholeStepsAgree) { compare_steps(); }

TEST_P(Parity, WholeStepsAgreeWithATree) {
  scene_.search = meltsim::NeighbourSearch::tree;
  World world = make_world(scene_);
  ASSERT_EQ(world.resolved().neighbour_search, scene_.search);
  compare_steps();
  step(world, 64);
  EXPECT_FALSE(world.synchronize().halted);
}

// The paper's heat hangs on the order of neighbours: at the Fourier number of 1 that water has here, another order
// moves temperatures beside the ice by degrees. What melts changes its properties, so two sub-steps and no more.
TEST_P(Parity, ThePapersHeatTakesNeighboursInTheSameOrder) {
  scene_.heat_model = meltsim::HeatModel::paper;
  scene_.heat_time_scale = 4e7;
  scene_.still = true;
  scene_.backend = Backend::cpu;
  World cpu = make_world(scene_);
  scene_.backend = Backend::cuda;
  World cuda = make_world(scene_);
  const meltsim::ParticleData before = value_of(cpu.particles());
  step(cpu, 2);
  step(cuda, 2);
  const meltsim::ParticleData a = value_of(cpu.particles()), b = value_of(cuda.particles());
  ASSERT_EQ(a.id, b.id);
  double worst = 0, changed = 0;
  for (std::size_t i = 0; i < a.id.size(); ++i) {
    worst = std::max(worst, std::fabs(a.temperature[i] - b.temperature[i]));
    changed = std::max(changed, std::fabs(a.temperature[i] - before.temperature[i]));
  }
  EXPECT_GT(changed, 20) << "the step is too small to say anything";
  // Temperatures run through 65 pairs, each rounded: in single precision 65 * 80 C * 6e-8 = 3e-4 per sub-step, in
  // double 6e-13, times ten for two sub-steps and enthalpies turned into temperatures.
  EXPECT_LE(worst, GetParam() == Precision::single_precision ? 1e-3 : 1e-11);
}

INSTANTIATE_TEST_SUITE_P(Precisions, Parity,
                         ::testing::Values(Precision::single_precision, Precision::double_precision),
                         [](const auto& info) { return name_of(info.param); });

}  // namespace
