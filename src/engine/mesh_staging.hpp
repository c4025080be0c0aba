// SPDX-License-Identifier: Apache-2.0
// Staging buffers for vertices of deforming bodies: copies to the backend that do not wait.
#pragma once

#include <cstdint>
#include <cstring>

#include "frame/frame.hpp"
#include "frame/steered.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Two buffers of host memory that the backend reads: one is filled while the other is read.
template <class E>
class MeshStaging {
 public:
  /// Allocates room for n points. False: memory is insufficient.
  bool reserve(E& ex, std::uint64_t n) {
    if (n == room_) return true;
    release(ex);
    for (Buffer& b : buffers_) {
      b.points = static_cast<MeshPoint*>(n != 0 ? ex.allocate_pinned(n * sizeof(MeshPoint)) : nullptr);
      if (n != 0 && b.points == nullptr) {
        release(ex);
        return false;
      }
    }
    room_ = n;
    return true;
  }

  /// The buffer that was read is free again.
  void release(E& ex) {
    for (Buffer& b : buffers_) {
      if (b.points != nullptr) ex.release_pinned(b.points);
      if (b.marked) ex.release_mark(b.mark);
      b = {};
    }
    room_ = 0;
  }

  /// Enqueues the copy; waits only for the step before the last one that reshaped bodies.
  void put(E& ex, const std::vector<Reshaped>& all, MeshPoint* to) {
    Buffer& b = buffers_[next_];
    next_ = 1 - next_;
    if (b.marked) ex.wait_for_mark(b.mark);
    static_assert(sizeof(MeshPoint) % sizeof(double) == 0);
    for (const Reshaped& r : all) {
      std::memcpy(b.points + r.first, r.points, r.count * sizeof(MeshPoint));
      ex.copy(r.count * (sizeof(MeshPoint) / sizeof(double)),
              reinterpret_cast<const double*>(b.points + r.first), reinterpret_cast<double*>(to + r.first));
    }
    if (!b.marked) b.mark = ex.make_mark();
    b.marked = true;
    ex.begin_copies();
    ex.end_copies(b.mark);
  }

 private:
  struct Buffer {
    MeshPoint* points = nullptr;
    void* mark = nullptr;
    bool marked = false;
  };
  Buffer buffers_[2];
  int next_ = 0;
  std::uint64_t room_ = 0;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
