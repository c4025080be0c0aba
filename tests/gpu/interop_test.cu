// SPDX-License-Identifier: Apache-2.0
// A host's kernel in a custom stage, through cuda_interop.hpp.
#include <cmath>
#include <cstring>
#include <vector>

#include "gpu/melting_scene.hpp"
#include "meltsim/cuda_interop.hpp"
#include "support/require_gpu.hpp"

namespace {

using namespace gpu_test;
namespace interop = meltsim::cuda_interop;

template <class T>
__global__ void push(meltsim::DeviceSpan<meltsim::Vec4<T>> position,
                     meltsim::DeviceSpan<meltsim::Vec3<T>> acceleration, const std::uint32_t* tag) {
  const std::size_t i = static_cast<std::size_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < position.size && meltsim::is_fluid(tag[i])) acceleration.data[i].x += T(3);
}

template <class T>
void push_stage(const meltsim::StageContext& context, void*) {
  const auto position = interop::position<T>(context);
  const auto acceleration = interop::acceleration<T>(context);
  if (position.data == nullptr || acceleration.data == nullptr) return;
  push<T><<<static_cast<unsigned>((position.size + 127) / 128), 128, 0, interop::stream(context)>>>(
      position, acceleration, context.tag);
}

template <class T>
double gained(Precision precision) {
  MeltingScene scene;
  scene.precision = precision;
  World plain = make_world(scene), pushed = make_world(scene);
  meltsim::CustomStage stage;
  stage.name = "push";
  stage.run = push_stage<T>;
  stage.reads = {"position", "tag"};
  stage.writes = {"acceleration"};
  succeed(pushed.scheduler().insert_after("sph.reaction", stage));
  step(plain, 1);
  step(pushed, 1);
  const auto a = value_of(plain.totals()), b = value_of(pushed.totals());
  const double fluid_mass = static_cast<double>(a.fluid) * 1000 * spacing * spacing * spacing;
  return (b.momentum.x - a.momentum.x) / (fluid_mass * 3 * time_step);
}

// Tolerance: velocities of about 1 m/s held in single precision, changed by 6 mm/s.
TEST(Interop, AKernelOfTheHostsPushesTheLiquid) {
  MELTSIM_NEEDS_GPU();
  EXPECT_NEAR(gained<float>(Precision::single_precision), 1.0, 1e-3);
  EXPECT_NEAR(gained<double>(Precision::double_precision), 1.0, 1e-9);
}

template <class T>
__global__ void spoil(meltsim::DeviceSpan<meltsim::Vec4<T>> position) {
  position.data[0].y = T(0) / T(0);
}

template <class T>
void spoil_stage(const meltsim::StageContext& context, void*) {
  const auto position = interop::position<T>(context);
  if (position.data != nullptr) spoil<T><<<1, 1, 0, interop::stream(context)>>>(position);
}

// A particle at no place is near nobody, so no sum shows it for sure.
template <class T>
void expect_halt(Precision precision) {
  MeltingScene scene;
  scene.precision = precision;
  World w = make_world(scene);
  meltsim::CustomStage stage;
  stage.name = "spoil";
  stage.run = spoil_stage<T>;
  stage.writes = {"position"};
  succeed(w.scheduler().insert_after("spatial.neighbours", stage));  // the last of the search
  succeed(w.step(time_step));
  const meltsim::StepResult r = w.synchronize();
  EXPECT_TRUE(r.halted);
  EXPECT_NE(r.halt_reason.find("position is not finite"), std::string::npos) << r.halt_reason;
}

TEST(Interop, APositionThatIsNoNumberHalts) {
  MELTSIM_NEEDS_GPU();
  expect_halt<float>(Precision::single_precision);
  expect_halt<double>(Precision::double_precision);
}

// Behind the check at the end of a sub-step: the next one's search meets it first. What is no number is in some cell,
// wherever cells are, and is named.
template <class T>
__global__ void spoil_middle(meltsim::Vec4<T>* values, std::uint64_t i, T bad) {
  values[i].x = bad;
}
struct Middle {
  bool velocity = false;
  double value = 0;
};
template <class T>
void spoil_middle_stage(const meltsim::StageContext& context, void* user) {
  const auto& how = *static_cast<const Middle*>(user);
  auto* values = static_cast<meltsim::Vec4<T>*>(how.velocity ? context.velocity : context.position);
  spoil_middle<T>
      <<<1, 1, 0, interop::stream(context)>>>(values, context.particles / 2, static_cast<T>(how.value));
}

template <class T>
void expect_halt_after_search(meltsim::NeighbourSearch search, bool bounded, Middle how) {
  meltsim::WorldDesc d;
  d.backend = Backend::cuda;
  d.precision = sizeof(T) == 8 ? Precision::double_precision : Precision::single_precision;
  d.spacing = 0.1;
  d.neighbour_search = search;
  d.domain.bounded = bounded;
  d.domain.max = {1.2, 1.2, 1.2};
  World w = value_of(World::create(d));
  meltsim::FluidDesc f;
  f.material = value_of(w.add_material({}));
  f.shape = meltsim::Shape::box({0.1, 0.1, 0.1}, {0.7, 0.7, 0.7});
  value_of(w.add_fluid(f));
  succeed(w.step(1e-3));
  meltsim::CustomStage stage;
  stage.name = "spoil";
  stage.run = spoil_middle_stage<T>;
  stage.user = &how;
  stage.writes = {"position", "velocity"};
  succeed(w.scheduler().insert_after("step.integrate", stage));
  for (int k = 0; k < 3; ++k) succeed(w.step(1e-3));
  const meltsim::StepResult r = w.synchronize();
  ASSERT_TRUE(r.halted);
  EXPECT_NE(r.halt_reason.find("not finite"), std::string::npos) << r.halt_reason;
  EXPECT_EQ(r.halt_reason.find("device"), std::string::npos) << r.halt_reason;
  value_of(w.particles());
}

TEST(Interop, WhatIsNoNumberHaltsWithEverySearch) {
  MELTSIM_NEEDS_GPU();
  using meltsim::NeighbourSearch;
  for (const auto search : {NeighbourSearch::grid, NeighbourSearch::tree})
    for (const bool bounded : {true, false})
      for (const bool velocity : {false, true})
        for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
          SCOPED_TRACE(::testing::Message() << "search " << static_cast<int>(search) << ", bounded "
                                            << bounded << ", velocity " << velocity << ", " << value);
          expect_halt_after_search<float>(search, bounded, {velocity, value});
          expect_halt_after_search<double>(search, bounded, {velocity, value});
        }
}

TEST(Interop, ViewsAreEmptyWhereTheyDoNotFit) {
  meltsim::StageContext context;
  int anything = 0;
  context.position = &anything;
  context.particles = 1;
  EXPECT_EQ(interop::position<float>(context).data, nullptr) << "host memory";
  context.backend = Backend::cuda;
  EXPECT_EQ(interop::position<float>(context).size, 1u);
  EXPECT_EQ(interop::position_float4(context).size, 1u);
  EXPECT_EQ(interop::position<double>(context).data, nullptr) << "single precision";
  EXPECT_EQ(interop::velocity<float>(context).data, nullptr) << "not in this scene";
}

template <class T>
std::vector<T> brought(const T* from, std::size_t n, cudaStream_t stream) {
  std::vector<T> to(n);
  EXPECT_EQ(cudaMemcpyAsync(to.data(), from, n * sizeof(T), cudaMemcpyDeviceToHost, stream), cudaSuccess);
  EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
  return to;
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

// The state as a host finds it behind 0, 1, 2, ... sub-steps that nobody waited for: both halves of the double buffer, stage by
// stage and as a graph.
TEST(Interop, TheStateBetweenStepsIsThatOfTheStepsSoFar) {
  MELTSIM_NEEDS_GPU();
  for (const bool ice : {true, false}) {  // alone, liquid ends its sub-steps in another kernel
    MeltingScene scene;
    if (!ice) scene.ice = 0;
    World w = make_world(scene);
    for (int k = 0; k < 5; ++k) {
      const meltsim::StageContext c = value_of(w.device_state());
      const std::size_t n = c.particles;
      const cudaStream_t stream = interop::stream(c);
      const auto x = brought(interop::position<float>(c).data, n, stream);
      const auto v = brought(interop::velocity<float>(c).data, n, stream);
      const auto id = brought(c.id, n, stream), tag = brought(c.tag, n, stream);
      ASSERT_NE(c.enthalpy == nullptr, c.enthalpy_of_id == nullptr);
      const auto h = brought(c.enthalpy != nullptr ? c.enthalpy : c.enthalpy_of_id, n, stream);
      const meltsim::ParticleData data = value_of(w.particles());
      ASSERT_EQ(data.id.size(), n);
      const double origin = w.resolved().origin.y;
      for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t at = id[i];
        ASSERT_LT(at, n);
        EXPECT_EQ(static_cast<double>(x[i].y) + origin, data.position[at].y);
        EXPECT_EQ(static_cast<double>(v[i].y), data.velocity[at].y);
        EXPECT_EQ(tag[i], data.tag[at]);
        EXPECT_EQ(h[c.enthalpy != nullptr ? i : at], data.enthalpy[at]);
      }
      step(w, 3);
    }
  }
}

// The view is the mesh, also when steps were enqueued in between.
TEST(Interop, ASurfaceStaysOnTheDevice) {
  MELTSIM_NEEDS_GPU();
  MeltingScene scene;
  World w = make_world(scene);
  step(w, 20);
  const meltsim::SurfaceMesh mesh = value_of(w.surface());
  const meltsim::SurfaceView view = value_of(w.surface_view());
  step(w, 5);
  ASSERT_EQ(view.backend, Backend::cuda);
  ASSERT_EQ(view.vertices, mesh.position.size());
  ASSERT_EQ(3 * view.triangles, mesh.triangles.size());
  ASSERT_GT(view.triangles, 100u);
  const auto stream = static_cast<cudaStream_t>(view.stream);
  const std::size_t n = view.vertices;
  EXPECT_TRUE(same_bytes(brought(view.position, n, stream), mesh.position));
  EXPECT_TRUE(same_bytes(brought(view.normal, n, stream), mesh.normal));
  EXPECT_TRUE(same_bytes(brought(view.temperature, n, stream), mesh.temperature));
  EXPECT_TRUE(same_bytes(brought(view.liquid_fraction, n, stream), mesh.liquid_fraction));
  EXPECT_TRUE(same_bytes(brought(view.body, n, stream), mesh.body));
  EXPECT_TRUE(same_bytes(brought(view.material, n, stream), mesh.material));
  EXPECT_TRUE(same_bytes(brought(view.triangle, mesh.triangles.size(), stream), mesh.triangles));
}

/// Of a view, once the World's stream has reached it.
meltsim::SurfaceDraw drawn(const meltsim::SurfaceView& view) {
  return brought(view.draw, 1, static_cast<cudaStream_t>(view.stream)).front();
}

// The same mesh as where the host waits, with its size on the device alone; the arrays are as long as there is room for.
TEST(Interop, ASurfaceThatNobodyWaitsForIsTheSame) {
  MELTSIM_NEEDS_GPU();
  for (const auto of : {meltsim::SurfaceOf::liquid, meltsim::SurfaceOf::solids}) {
    MeltingScene scene;
    World w = make_world(scene);
    step(w, 20);
    meltsim::SurfaceDesc d;
    d.of = of;
    d.wait = false;
    value_of(w.surface_view(d));  // the first one waits
    for (int k = 0; k < 6; ++k) {
      step(w, 7);
      const meltsim::SurfaceView view = value_of(w.surface_view(d));
      const auto stream = static_cast<cudaStream_t>(view.stream);
      const meltsim::SurfaceDraw draw = drawn(view);
      const auto triangles = brought(view.triangle, draw.indices, stream);
      const auto positions = brought(view.position, view.vertices, stream);
      meltsim::SurfaceDesc waiting = d;
      waiting.wait = true;
      const meltsim::SurfaceMesh mesh = value_of(w.surface(waiting));
      ASSERT_GT(mesh.triangles.size(), 100u);
      EXPECT_TRUE(same_bytes(triangles, mesh.triangles)) << draw.indices << " of " << mesh.triangles.size();
      EXPECT_EQ(draw.instances, 1u);
      ASSERT_GE(view.vertices, mesh.position.size());
      EXPECT_TRUE(same_bytes(
          {positions.begin(), positions.begin() + static_cast<std::ptrdiff_t>(mesh.position.size())},
          mesh.position));
      EXPECT_EQ(drawn(value_of(w.surface_view(waiting))).indices, mesh.triangles.size());
    }
  }
}

// A jet into an empty box: the mesh outgrows its room time and again. It is whole or not drawn, and mostly whole.
TEST(Interop, ASurfaceThatNobodyWaitsForGrows) {
  MELTSIM_NEEDS_GPU();
  meltsim::WorldDesc d;
  d.backend = Backend::cuda;
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {4, 4, 4};
  World w = value_of(World::create(d));
  meltsim::EmitterDesc jet;
  jet.material = value_of(w.add_material({}));
  jet.center = {2, 3.5, 2};
  jet.axis = {0, -1, 0};
  jet.radius = 0.5;
  jet.speed = 3;
  jet.max_particles = 20000;
  value_of(w.add_emitter(jet));
  meltsim::SurfaceDesc what;
  what.wait = false;
  int empty = 0;
  std::uint32_t most = 0;
  for (int k = 0; k < 120; ++k) {
    succeed(w.step(0.005));
    const meltsim::SurfaceView view = value_of(w.surface_view(what));
    if (view.draw == nullptr) continue;
    const std::uint32_t indices = drawn(view).indices;
    const std::size_t whole = value_of(w.surface()).triangles.size();
    if (indices == 0 && whole != 0) ++empty;
    else EXPECT_EQ(indices, whole) << k;
    most = std::max(most, indices);
  }
  EXPECT_GT(most, 10000u);
  EXPECT_LE(empty, 6);
}

__global__ void wait_and_write(int* to, int value, long long clocks) {
  const long long begin = clock64();
  while (clock64() - begin < clocks) {
  }
  *to = value;
}
__global__ void copy_one(const int* from, int* to) { *to = *from; }
struct Copy {
  int* from = nullptr;
  int* to = nullptr;
};

// The host's other stream is slow: what the World does behind wait_for() sees what that has written, and the other way round.
TEST(Interop, EventsOrderTheWorldAndOtherStreams) {
  MELTSIM_NEEDS_GPU();
  MeltingScene scene;
  World w = make_world(scene);
  step(w, 3);
  cudaStream_t other = nullptr;
  cudaEvent_t event = nullptr;
  int* words = nullptr;
  ASSERT_EQ(cudaStreamCreateWithFlags(&other, cudaStreamNonBlocking), cudaSuccess);
  ASSERT_EQ(cudaEventCreateWithFlags(&event, cudaEventDisableTiming), cudaSuccess);
  ASSERT_EQ(cudaMalloc(&words, 3 * sizeof(int)), cudaSuccess);
  ASSERT_EQ(cudaMemset(words, 0, 3 * sizeof(int)), cudaSuccess);
  Copy copy{words, words + 1};
  meltsim::CustomStage stage;
  stage.name = "copy";
  stage.user = &copy;
  stage.run = [](const meltsim::StageContext& c, void* user) {
    const auto& own = *static_cast<const Copy*>(user);
    copy_one<<<1, 1, 0, interop::stream(c)>>>(own.from, own.to);
  };
  succeed(w.scheduler().insert_after("step.begin", stage));
  wait_and_write<<<1, 1, 0, other>>>(words, 7, 50000000);  // some 30 ms
  ASSERT_EQ(cudaEventRecord(event, other), cudaSuccess);
  succeed(w.wait_for(event));
  succeed(w.step(time_step));
  succeed(w.signal(event));
  ASSERT_EQ(cudaStreamWaitEvent(other, event, 0), cudaSuccess);
  copy_one<<<1, 1, 0, other>>>(words + 1, words + 2);
  EXPECT_EQ(brought(words + 2, 1, other).front(), 7);
  EXPECT_EQ(w.wait_for(nullptr).error().code, meltsim::ErrorCode::invalid_argument);
  EXPECT_NE(w.signal(nullptr).error().message.find("signal: event: is null"), std::string::npos);
  EXPECT_FALSE(w.synchronize().halted);
  (void)cudaFree(words);
  (void)cudaEventDestroy(event);
  (void)cudaStreamDestroy(other);
}

}  // namespace
