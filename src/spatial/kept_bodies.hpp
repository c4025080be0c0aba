// SPDX-License-Identifier: Apache-2.0
// Kernels of the grid that is kept for several sub-steps (Verlet 1967's skin): cells are wider than H by the
// skin, candidates within H and skin are marked once, and for as long as no particle has moved by half of the
// skin the sub-steps look at those only. Whether the grid stays is decided on the device: a flag that makes
// the kernels of its building do nothing.
#pragma once

#include "spatial/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Whether a particle has left the place that the grid knows it at, or was removed since.
template <class T>
struct MovedBody {
  Frame<T> w;
  MELTSIM_HD core::Moved operator()(std::uint64_t i) const {
    const Vec4<T> anchor = w.f.anchor[i];
    const bool removed = is_removed(w.before.tag[i]);
    const Vec3<T> x =
        physics::drift(xyz(w.before.position[i]), xyz(w.before.velocity[i]), w.f.clock->half_dt);
    const Vec3<T> d = separation(w.grid, x, xyz(anchor));
    const bool stayed = removed || dot(d, d) <= w.kept.moved2;
    return {stayed && removed == (anchor.w != T(0)) ? 0u : 1u};
  }
};

template <class T>
struct KeepBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    w.f.search->keep = w.f.clock->rebuild == 0u && w.f.moved->any == 0u ? 1u : 0u;
    if (w.f.search->keep == 0u) ++w.f.search->built;
  }
};

/// Where particles are when the grid is built, and which candidates are within H and skin.
template <class T, bool Periodic>
struct SkinBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const Vec4<T> x = w.f.position[i];
    w.f.anchor[i] = with_w(xyz(x), is_removed(w.f.tag[i]) ? T(1) : T(0));
    if (w.f.group_of[i] == none) return;
    const Rows<Periodic, T> rows(w, i);
    for (std::uint32_t r = 0; r < w.grid.rows; ++r) {
      const Range row = rows[r];
      std::uint64_t bits = 0;
      for (std::uint32_t j = row.begin; j < minimum(row.begin + far_bits_per_row, row.end); ++j) {
        const Vec3<T> d = separation<Periodic>(w.grid, xyz(x), xyz(w.f.position[j]));
        bits |= static_cast<std::uint64_t>(dot(d, d) < w.kept.reach2) << (j - row.begin);
      }
      w.f.far_bits[static_cast<std::uint64_t>(r) * w.bits_stride + i] = bits;
    }
  }
};

/// While it lives, verbs do nothing where the grid is kept.
template <class E, class T>
class WhereRebuilt {
 public:
  WhereRebuilt(E& ex, const Frame<T>& w) : ex_(ex), w_(w) {
    if (w_.f.search != nullptr) ex_.set_guard(&w_.f.search->keep);
  }
  ~WhereRebuilt() {
    if (w_.f.search != nullptr) ex_.set_guard(&w_.f.status->halted);
  }
  WhereRebuilt(const WhereRebuilt&) = delete;
  WhereRebuilt& operator=(const WhereRebuilt&) = delete;

 private:
  E& ex_;
  const Frame<T>& w_;
};

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
