// SPDX-License-Identifier: Apache-2.0
// Typed device views of the arguments of a custom stage (scheduler.hpp), for hosts that write CUDA kernels.
// Opt-in: the one public header that includes CUDA; no other header of meltsim needs it.
//
//   void stage(const meltsim::StageContext& context, void*) {
//     namespace interop = meltsim::cuda_interop;
//     const auto x = interop::position<float>(context);
//     if (x.data == nullptr) return;  // not on CUDA, or not in single precision
//     my_kernel<<<blocks, threads, 0, interop::stream(context)>>>(x, interop::acceleration<float>(context));
//   }
//
// Launch on that stream and do not wait: the stream orders the stages before and after, and the step can
// still be captured in a CUDA graph. Views are valid until the stage returns.
#pragma once

#include <cuda_runtime_api.h>

#include "meltsim/scheduler.hpp"
#include "meltsim/span.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace cuda_interop {

/// Stream of the World: WorldDesc::stream if the host passed one.
inline cudaStream_t stream(const StageContext& c) { return static_cast<cudaStream_t>(c.stream); }

/// True when the context holds device memory in precision T (float or double).
template <class T>
bool holds(const StageContext& c) {
  static_assert(sizeof(T) == sizeof(float) || sizeof(T) == sizeof(double), "T is float or double");
  return c.backend == Backend::cuda &&
         (c.precision == Precision::double_precision) == (sizeof(T) == sizeof(double));
}

namespace detail {
template <class Item, class T>
DeviceSpan<Item> view(const StageContext& c, void* data) {
  if (!holds<T>(c) || data == nullptr) return {};
  return {static_cast<Item*>(data), static_cast<std::size_t>(c.particles)};
}
}  // namespace detail

// Each view is empty if the context does not hold T or the scene has no such channel.

/// Positions relative to Resolved::origin [m] in x, y, z; rest volume [m^3] in w.
template <class T>
DeviceSpan<Vec4<T>> position(const StageContext& c) {
  return detail::view<Vec4<T>, T>(c, c.position);
}
/// Velocities [m/s] in x, y, z; do not write w, an operand of the library.
template <class T>
DeviceSpan<Vec4<T>> velocity(const StageContext& c) {
  return detail::view<Vec4<T>, T>(c, c.velocity);
}
/// Accelerations [m/s^2]; a stage after "sph.forces" and before "step.integrate" may add to them.
template <class T>
DeviceSpan<Vec3<T>> acceleration(const StageContext& c) {
  return detail::view<Vec3<T>, T>(c, c.acceleration);
}

/// The same memory as position<float>, in CUDA's vector type.
inline DeviceSpan<float4> position_float4(const StageContext& c) {
  return detail::view<float4, float>(c, c.position);
}
/// The same memory as velocity<float>, in CUDA's vector type.
inline DeviceSpan<float4> velocity_float4(const StageContext& c) {
  return detail::view<float4, float>(c, c.velocity);
}

static_assert(sizeof(Vec4<float>) == sizeof(float4) && alignof(Vec4<float>) == alignof(float4),
              "Vec4<float> is a float4");

}  // namespace cuda_interop
}  // namespace v0
}  // namespace meltsim
