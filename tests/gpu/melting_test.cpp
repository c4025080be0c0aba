// SPDX-License-Identifier: Apache-2.0
// A block melts away completely on both backends. The flow is chaotic, so particles part ways; what is
// compared is what a user sees: how much has melted when, and what is conserved.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "gpu/melting_scene.hpp"
#include "support/require_gpu.hpp"

namespace {

using namespace gpu_test;

constexpr int stride = 4, most_samples = 200;

struct History {
  std::vector<double> melted;  ///< share of the ice, every `stride` steps
  double mass_before = 0, mass_after = 0;
  double heat_before = 0, heat_after = 0;
};

History melt(Backend backend, bool still) {
  MeltingScene scene;
  scene.backend = backend;
  scene.side = 14;
  scene.latent_heat = 3.34e4;  // a tenth of ice's: the same course in a fifth of the steps
  scene.heat_time_scale = 2e5;
  scene.still = still;
  World world = make_world(scene);
  const meltsim::Totals before = value_of(world.totals());
  History h;
  h.mass_before = before.mass;
  h.heat_before = before.thermal;
  for (int sample = 0; sample < most_samples; ++sample) {
    step(world, stride);
    const meltsim::StepResult r = world.synchronize();
    if (r.halted) {
      ADD_FAILURE() << r.halt_reason;
      break;
    }
    h.melted.push_back(static_cast<double>(r.melted) / static_cast<double>(before.solid));
    if (r.solid == 0) break;
  }
  const meltsim::Totals after = value_of(world.totals());
  if (still)  // conduction alone takes its time; enough of it to compare
    EXPECT_LT(after.solid, before.solid / 2);
  else EXPECT_EQ(after.solid, 0u) << "not all of it melted in " << most_samples * stride << " steps";
  h.mass_after = after.mass;
  h.heat_after = after.thermal;
  return h;
}

/// Largest and mean difference of the melted share over time.
struct Difference {
  double largest = 0, mean = 0;
};

Difference compare(bool still) {
  const History cpu = melt(Backend::cpu, still), cuda = melt(Backend::cuda, still);
  EXPECT_EQ(cpu.mass_before, cpu.mass_after) << "melting changes tags, not masses";
  EXPECT_EQ(cuda.mass_before, cuda.mass_after);
  EXPECT_EQ(cpu.mass_after, cuda.mass_after) << "to the last bit";
  // Energy: increments are rounded to single precision, sums are in double.
  EXPECT_NEAR(cuda.heat_after, cuda.heat_before, 1e-6 * std::fabs(cuda.heat_before));
  Difference d;
  const std::size_t samples = std::max(cpu.melted.size(), cuda.melted.size());
  for (std::size_t k = 0; k < samples; ++k) {
    const double a = k < cpu.melted.size() ? cpu.melted[k] : 1.0,
                 b = k < cuda.melted.size() ? cuda.melted[k] : 1.0;
    d.largest = std::max(d.largest, std::fabs(a - b));
    d.mean += std::fabs(a - b) / static_cast<double>(samples);
  }
  std::printf("  melted after %zu (CPU) and %zu (CUDA) steps, difference: mean %.4f, largest %.4f\n",
              cpu.melted.size() * stride, cuda.melted.size() * stride, d.mean, d.largest);
  return d;
}

TEST(Melting, OfABlockHeldInStillWaterIsTheSameOnBothBackends) {
  MELTSIM_NEEDS_GPU();
  // No gravity and a fixed body: the flow has nothing to amplify, so every sample must agree.
  EXPECT_LE(compare(true).largest, 0.02);
}

TEST(Melting, OfAFloatingBlockTakesTheSameTimeOnBothBackends) {
  MELTSIM_NEEDS_GPU();
  // A splashing tank is chaotic: single and double precision on one CPU part by as much for a moment.
  const Difference d = compare(false);
  EXPECT_LE(d.mean, 0.02);
  EXPECT_LE(d.largest, 0.1);
}

}  // namespace
