// SPDX-License-Identifier: Apache-2.0
// Non-owning views. Host and device memory have different types, so one is never read as the other.
#pragma once

#include <cstddef>

namespace meltsim {
inline namespace v0 {

/// Contiguous host memory; valid until the next call that changes what it views.
template <class T>
struct HostSpan {
  const T* data = nullptr;                                      ///< first item; null where there is none
  std::size_t size = 0;                                         ///< number of items
  const T& operator[](std::size_t i) const { return data[i]; }  ///< item i, 0 <= i < size, unchecked
  const T* begin() const { return data; }                       ///< first item
  const T* end() const { return data + size; }                  ///< behind the last item
  bool empty() const { return size == 0; }                      ///< whether there are no items
};

/// Memory of the World's backend: device memory on CUDA, host memory on the CPU. The host may dereference it
/// only if World::backend() is cpu. Valid until the next step or addition.
template <class T>
struct DeviceSpan {
  T* data = nullptr;     ///< first item; null where there is none
  std::size_t size = 0;  ///< number of items
};

}  // namespace v0
}  // namespace meltsim
