// SPDX-License-Identifier: Apache-2.0
// Memory in large pages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Asks the system to back memory that nothing has been written to with its large pages, those of 2 MB that lie in it as a whole.
/// Why: a system gives memory page by page as it is first written, and pages of 4 kB take it as long as filling them. Nothing where
/// the system has none.
void prefer_large_pages(void* memory, std::uint64_t bytes) noexcept;

/// v.reserve(n) of items that are written soon, in large pages.
template <class V>
void reserve_large(std::vector<V>& v, std::size_t n) {
  if (n <= v.capacity()) return;
  v.reserve(n);
  prefer_large_pages(v.data() + v.size(), (v.capacity() - v.size()) * sizeof(V));
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
