// SPDX-License-Identifier: Apache-2.0
// For hosts that write their own CUDA kernels: typed views of what a custom stage sees (scheduler.hpp).
// Opt-in: the one public header that includes CUDA; nothing else of meltsim needs it.
//
//   void stage(const meltsim::StageContext& context, void*) {
//     namespace interop = meltsim::cuda_interop;
//     const auto x = interop::position<float>(context);
//     if (x.data == nullptr) return;  // not on CUDA, or not in single precision
//     my_kernel<<<blocks, threads, 0, interop::stream(context)>>>(x, interop::acceleration<float>(context));
//   }
//
// Launch on that stream and do not wait: stages before and after it are ordered by it, and the step stays
// capturable in a CUDA graph. Views hold until the end of the stage.
#pragma once

#include <cuda_runtime_api.h>

#include "meltsim/scheduler.hpp"
#include "meltsim/span.hpp"
#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {
namespace cuda_interop {

/// Stream of the World: the host's own if it passed one in WorldDesc::stream.
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

// Each of these is empty when the context does not hold T, or the scene has no such channel.

/// x, y, z relative to Resolved::origin [m]; w = volume [m^3].
template <class T>
DeviceSpan<Vec4<T>> position(const StageContext& c) {
  return detail::view<Vec4<T>, T>(c, c.position);
}
/// vx, vy, vz [m/s]; w is the library's, do not write it.
template <class T>
DeviceSpan<Vec4<T>> velocity(const StageContext& c) {
  return detail::view<Vec4<T>, T>(c, c.velocity);
}
/// [m/s^2]; add to it after "sph.forces".
template <class T>
DeviceSpan<Vec3<T>> acceleration(const StageContext& c) {
  return detail::view<Vec3<T>, T>(c, c.acceleration);
}

/// The same memory as position<float>, for kernels that speak CUDA's vector types.
inline DeviceSpan<float4> position_float4(const StageContext& c) {
  return detail::view<float4, float>(c, c.position);
}
/// The same memory as velocity<float>.
inline DeviceSpan<float4> velocity_float4(const StageContext& c) {
  return detail::view<float4, float>(c, c.velocity);
}

static_assert(sizeof(Vec4<float>) == sizeof(float4) && alignof(Vec4<float>) == alignof(float4),
              "Vec4<float> is a float4");

}  // namespace cuda_interop
}  // namespace v0
}  // namespace meltsim
