// SPDX-License-Identifier: Apache-2.0
#include "exec/pages.hpp"

#include <sys/mman.h>

namespace meltsim {
inline namespace v0 {
namespace core {

void prefer_large_pages(void* memory, std::uint64_t bytes) noexcept {
  constexpr std::uint64_t page = std::uint64_t{1} << 21;
  const std::uint64_t skipped = (page - reinterpret_cast<std::uintptr_t>(memory) % page) % page;
  if (memory == nullptr || bytes < skipped + page) return;
  // A hint: where it is refused, small pages do.
  static_cast<void>(
      ::madvise(static_cast<char*>(memory) + skipped, (bytes - skipped) / page * page, MADV_HUGEPAGE));
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
