// SPDX-License-Identifier: Apache-2.0
// Non-owning views. Host and device memory have different types, so one is never read as the other.
#pragma once

#include <cstddef>

namespace meltsim {
inline namespace v0 {

/// Contiguous host memory; valid until the next call that changes what it views.
template <class T>
struct HostSpan {
  const T* data = nullptr;
  std::size_t size = 0;
  const T& operator[](std::size_t i) const { return data[i]; }
  const T* begin() const { return data; }
  const T* end() const { return data + size; }
  bool empty() const { return size == 0; }
};

/// Memory of the World's backend: device memory on CUDA, host memory on CPU. Not to be dereferenced on the
/// host unless World::backend() is cpu. Valid until the next step or addition.
template <class T>
struct DeviceSpan {
  T* data = nullptr;
  std::size_t size = 0;
};

}  // namespace v0
}  // namespace meltsim
