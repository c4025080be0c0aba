// SPDX-License-Identifier: Apache-2.0
// The neighbour loops for a CPU: `lanes` candidates or neighbours side by side, in loops that compilers turn
// into vector instructions. Sums are kept per lane and added up in one order, so they depend on neither the
// number of threads nor the width of the instructions; formulas are the same scalar functions as everywhere.
#pragma once

#include <cstring>
#include <type_traits>

#include "exec/lane_positions.hpp"
#include "exec/wide.hpp"
#include "spatial/sweep.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

using core::LanePositions;

/// visit(lane, V_j, x_ij, r2) for every candidate of i, row by row, and stores which are near, as
/// find_part does. Terms that vanish beyond H need no branch; V_j is 0 in lanes beyond the end of a row.
template <bool Periodic, class T, class Visit>
inline void find_in_lanes(const core::Frame<T>& w, const LanePositions<T>& p, std::uint64_t i,
                          const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Grid<T> grid = w.grid;
  const T support2 = w.c.kernel.support2;
  const Rows<Periodic, T> rows(w, i);
  WordWriter<T> words(w, i, 0u);
  for (std::uint32_t r = 0; r < grid.rows; ++r) {
    const core::Range row = rows[r];
    const std::uint32_t end = row.end;
    for (std::uint32_t first = row.begin; first < end; first += word_bits) {
      std::uint32_t near_bits[lanes] = {};
      for (std::uint32_t k = 0; k < word_bits && first + k < end; k += lanes) {
        const auto left = static_cast<std::int32_t>(end - first - k);
        const T *x = p.x + first + k, *y = p.y + first + k, *z = p.z + first + k, *v = p.w + first + k;
        MELTSIM_SIDE_BY_SIDE
        for (std::uint32_t l = 0; l < lanes; ++l) {
          const Vec3<T> d = separation<Periodic>(grid, xi, Vec3<T>{x[l], y[l], z[l]});
          const T r2 = dot(d, d), volume = v[l];
          const bool exists = static_cast<std::int32_t>(l) < left;
          near_bits[l] |= (exists & (r2 < support2) ? 1u : 0u) << (k + l);
          visit(l, exists ? volume : T(0), d, r2);
        }
      }
      std::uint32_t found = 0;
      for (std::uint32_t l = 0; l < lanes; ++l) found |= near_bits[l];
      words.add(first, found);
    }
  }
  words.close();
}

/// Positions of the set bits of a byte, and how many there are.
struct ByteBits {
  std::uint8_t at[256][8] = {};
  std::uint8_t count[256] = {};
  constexpr ByteBits() {
    for (unsigned b = 0; b < 256; ++b)
      for (std::uint8_t k = 0; k < 8; ++k)
        if (((b >> k) & 1u) != 0u) at[b][count[b]++] = k;
  }
};
inline constexpr ByteBits byte_bits{};

/// Capacity of a batch of neighbours, which may be of several rows.
inline constexpr std::uint32_t batch = 6 * word_bits;

/// The neighbours of a particle in order, a batch at a time.
template <bool Periodic, class T>
class Batches {
 public:
  Batches(const core::Frame<T>& w, std::uint64_t i)
      : w_(w), x_(xyz(w.f.position[i])), i_(i), at_(words_of(w, i, 0u)), left_(words_in(*at_)) {
    search_ = at_->first == too_many;
  }
  /// Slots of the next neighbours, none when there are no more. Filled up to whole lanes with i.
  std::uint32_t next() {
    const std::uint32_t n = search_ ? found() : walked();
    const auto all = static_cast<std::uint32_t>((n + lanes - 1u) / lanes * lanes);
    for (std::uint32_t k = n; k < all; ++k) slots[k] = static_cast<std::uint32_t>(i_);
    return n;
  }
  alignas(64) std::uint32_t slots[batch + lanes];

 private:
  std::uint32_t walked() {
    std::uint32_t n = 0;
    for (; left_ != 0u && n + word_bits <= batch; --left_) {
      at_ = columns_on(at_, w_.words_column);
      std::uint32_t begin = at_->first;
      for (std::uint32_t bits = at_->bits; bits != 0u; bits >>= 8, begin += 8u) {
        const std::uint32_t byte = bits & 255u;
        std::uint32_t* to = slots + n;
        MELTSIM_SIDE_BY_SIDE
        for (std::uint32_t k = 0; k < 8u; ++k) to[k] = begin + byte_bits.at[byte][k];
        n += byte_bits.count[byte];
      }
    }
    return n;
  }
  /// Searches the rows of a particle with more neighbours than there are words for.
  std::uint32_t found() {
    std::uint32_t n = 0;
    const Rows<Periodic, T> rows(w_, i_);
    for (; row_ < w_.grid.rows; ++row_, done_ = 0) {
      const core::Range row = rows[row_];
      while (row.begin + done_ < row.end) {
        if (n == batch) return n;
        const std::uint32_t j = row.begin + done_++;
        const Vec3<T> d = separation<Periodic>(w_.grid, x_, xyz(w_.f.position[j]));
        if (dot(d, d) < w_.c.kernel.support2) slots[n++] = j;
      }
    }
    return n;
  }
  const core::Frame<T>& w_;
  Vec3<T> x_;
  std::uint64_t i_;
  const NeighbourWord* at_;
  std::uint32_t left_, row_ = 0, done_ = 0;
  bool search_ = false;
};

/// Lanes that n neighbours take.
inline std::uint32_t whole_lanes(std::uint32_t n) { return (n + lanes - 1u) / lanes * lanes; }

/// Takes lanes beyond the last of n neighbours out of a sum that is in proportion to `weight`.
template <class T>
inline void cut(T* weight, std::uint32_t n) {
  for (std::uint32_t k = n; k % lanes != 0u; ++k) weight[k] = T(0);
}

/// 16 bytes. Not std::memcpy: with _FORTIFY_SOURCE=3, the default of Ubuntu's compilers, g++ 13 calls a function
/// that checks each of them, and water takes twice as long.
inline void copy_16(void* to, const void* from) { __builtin_memcpy(to, from, 16); }

/// 16 bytes: vectors that every x86-64 and ARMv8 has. Out of plain loops compilers make poor code here.
template <class T>
struct LaneVector {
  typedef T Half [[gnu::vector_size(16)]];
};

/// Values at the slots of a batch, one array per component.
template <class T>
struct LaneVectors {
  alignas(64) T x[batch + lanes], y[batch + lanes], z[batch + lanes], w[batch + lanes];
  /// Loads n neighbours and fills up to whole lanes.
  void load(const Vec4<T>* from, const std::uint32_t* slots, std::uint32_t n) {
    for (std::size_t k = 0; k < n; k += lanes) {
      transpose(from, slots + k, k);
      transpose(from, slots + k + 4, k + 4);
    }
  }
  Vec4<T> at(std::size_t k) const { return {x[k], y[k], z[k], w[k]}; }
  void put(std::size_t k, const Vec4<T>& v) {
    x[k] = v.x;
    y[k] = v.y;
    z[k] = v.z;
    w[k] = v.w;
  }

 private:
  using Half = typename LaneVector<T>::Half;
  static Half half(const Vec4<T>& v, int which) {
    Half h;
    copy_16(&h, reinterpret_cast<const unsigned char*>(&v) + 16 * which);
    return h;
  }
  static void put(T* to, Half h) { copy_16(to, &h); }
  void transpose(const Vec4<T>* from, const std::uint32_t* s, std::size_t k) {
    const Vec4<T>&a = from[s[0]], &b = from[s[1]], &c = from[s[2]], &d = from[s[3]];
    if constexpr (sizeof(T) == 4) {
      const Half v0 = half(a, 0), v1 = half(b, 0), v2 = half(c, 0), v3 = half(d, 0);
      const Half xy01 = __builtin_shufflevector(v0, v1, 0, 4, 1, 5),
                 xy23 = __builtin_shufflevector(v2, v3, 0, 4, 1, 5),
                 zw01 = __builtin_shufflevector(v0, v1, 2, 6, 3, 7),
                 zw23 = __builtin_shufflevector(v2, v3, 2, 6, 3, 7);
      put(x + k, __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5));
      put(y + k, __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7));
      put(z + k, __builtin_shufflevector(zw01, zw23, 0, 1, 4, 5));
      put(w + k, __builtin_shufflevector(zw01, zw23, 2, 3, 6, 7));
    } else {
      const auto pair = [&](const Vec4<T>& p, const Vec4<T>& q, std::size_t at) {
        const Half p0 = half(p, 0), q0 = half(q, 0), p1 = half(p, 1), q1 = half(q, 1);
        put(x + at, __builtin_shufflevector(p0, q0, 0, 2));
        put(y + at, __builtin_shufflevector(p0, q0, 1, 3));
        put(z + at, __builtin_shufflevector(p1, q1, 0, 2));
        put(w + at, __builtin_shufflevector(p1, q1, 1, 3));
      };
      pair(a, b, k);
      pair(c, d, k + 2);
    }
  }
};

/// The same for pairs of numbers.
template <class T>
struct LanePairs {
  alignas(64) T first[batch + lanes], second[batch + lanes];
  /// Loads n neighbours and fills up to whole lanes: a lane of weight zero must not hold a NaN either.
  template <class Pair>
  void load(const Pair* from, const std::uint32_t* slots, std::uint32_t n) {
    static_assert(sizeof(Pair) == 2 * sizeof(T));
    constexpr std::size_t each = 16 / sizeof(T);
    static_assert(lanes % each == 0);
    const std::size_t all = (n + lanes - 1u) / lanes * lanes;
    for (std::size_t k = 0; k < all; k += each) {
      alignas(16) T two[2][each];
      for (std::size_t h = 0; h < each; ++h)
        __builtin_memcpy(&two[0][0] + 2 * h, from + slots[k + h], 2 * sizeof(T));
      Half a, b;
      copy_16(&a, two[0]);
      copy_16(&b, two[1]);
      if constexpr (each == 4) {
        put(first + k, __builtin_shufflevector(a, b, 0, 2, 4, 6));
        put(second + k, __builtin_shufflevector(a, b, 1, 3, 5, 7));
      } else {
        put(first + k, __builtin_shufflevector(a, b, 0, 2));
        put(second + k, __builtin_shufflevector(a, b, 1, 3));
      }
    }
  }

 private:
  using Half = typename LaneVector<T>::Half;
  static void put(T* to, Half h) { copy_16(to, &h); }
};

/// visit(lane, k) for k in [0, n), `lanes` of them side by side, and on to whole lanes.
template <class Visit>
inline void in_lanes(std::uint32_t n, const Visit& visit) {
  for (std::size_t first = 0; first < n; first += lanes) {
    MELTSIM_SIDE_BY_SIDE
    for (std::size_t l = 0; l < lanes; ++l) visit(l, first + l);
  }
}

/// Whether the predicate holds for a k in [0, n), or beyond up to whole lanes.
template <class Test>
inline bool any_in_lanes(std::uint32_t n, const Test& test) {
  std::uint32_t found[lanes] = {}, any = 0;
  in_lanes(n, [&](std::size_t l, std::size_t k) { found[l] |= test(k) ? 1u : 0u; });
  for (const std::uint32_t f : found) any |= f;
  return any != 0u;
}

/// visit(mask) for the images across walls of `axes`, mask by mask: it stays the same in a loop over neighbours, which so has no
/// branch in it and becomes vector instructions. Not as a constant: seven texts of every sum took half of the time to compile.
template <class Visit>
inline void for_each_mask(std::uint32_t axes, const Visit& visit) {
  for (std::uint32_t mask = axes; mask != 0u; mask = (mask - 1u) & axes) visit(mask);
}

/// Adds images in walls, mask by mask; pair(k) is the k-th of n pairs.
template <class T, class Body, class Own, class Sums, class PairOf>
inline void add_images_in_lanes(const Body& body, const Own& own, const typename Body::Lanes& stored,
                                std::uint32_t n, const PairOf& pair, Sums& sums) {
  for_each_mask(own.walls.axes, [&](std::uint32_t mask) {
    in_lanes(n, [&](std::size_t l, std::size_t k) {
      const Pair<T> p = pair(k);
      const Pair<T> image{physics::image_of(own.walls, p.x_ij, mask),
                          physics::image_square(own.walls, p.x_ij, p.r2, mask), p.volume};
      auto sum = sums.at(l);
      body.add_image(sum, own, body.other(own, stored.at(k)), image, mask);
      sums.put(l, sum);
    });
  });
}

/// Likewise, of an interaction whose images act along their lines alone.
template <class T, class Body, class Own, class Sums, class PairOf>
inline void add_mirrored_in_lanes(const core::Frame<T>& w, const Body& body, const Own& own,
                                  const typename Body::Lanes& stored, std::uint32_t n, const PairOf& pair,
                                  Sums& sums) {
  for_each_mask(own.walls.axes, [&](std::uint32_t mask) {
    in_lanes(n, [&](std::size_t l, std::size_t k) {
      const Pair<T> p = pair(k);
      const T shape =
          Body::mirrored_shape(w.c.kernel, std::sqrt(physics::image_square(own.walls, p.x_ij, p.r2, mask)));
      const T factor = body.mirrored(own, body.other(own, stored.at(k)), p.volume) * shape;
      auto sum = sums.at(l);
      sum.add_mirrored(physics::image_of(own.walls, p.x_ij, mask) * factor);
      sums.put(l, sum);
    });
  });
}

/// sum_part of all neighbours, `lanes` of them side by side; images in walls, which vanish beyond H like everything else, are
/// gone through mask by mask, and what is rare one by one.
template <bool Periodic, class T, class Body>
inline typename Body::Sum sum_in_lanes(const core::Frame<T>& w, const Body& body, std::uint64_t i) {
  const auto own = body.own(i);
  const Vec3<T> xi = xyz(w.f.position[i]);
  const core::Grid<T> grid = w.grid;
  typename Body::Sum::Lanes sums;
  typename Body::Sum apart;
  Batches<Periodic, T> neighbours(w, i);
  while (const std::uint32_t n = neighbours.next()) {
    LaneVectors<T> x;
    typename Body::Lanes stored;
    x.load(w.f.position, neighbours.slots, n);
    stored.load(body, own, i, neighbours.slots, n, x.w);
    cut(x.w, n);
    const auto pair = [&](std::size_t k) {
      const Vec3<T> x_ij = separation<Periodic>(grid, xi, Vec3<T>{x.x[k], x.y[k], x.z[k]});
      return Pair<T>{x_ij, dot(x_ij, x_ij), x.w[k]};
    };
    in_lanes(n, [&](std::size_t l, std::size_t k) {
      auto sum = sums.at(l);
      body.add(sum, own, body.other(own, stored.at(k)), pair(k), NoImages{});
      sums.put(l, sum);
    });
    if constexpr (has_rare<Body>) {
      const auto rare = [&](std::size_t k) {
        return (x.w[k] > T(0)) & body.rare(own, body.other(own, stored.at(k)), pair(k));
      };
      const auto possible = [&](std::size_t k) { return body.may_be_rare(body.other(own, stored.at(k))); };
      if (any_in_lanes(n, possible) && any_in_lanes(n, rare))
        for (std::uint32_t k = 0; k < n; ++k)
          if (rare(k))
            body.add_rare(apart, own, body.other(own, stored.at(k)), i, neighbours.slots[k], pair(k));
    }
    if constexpr (adds_each_image<Body>) add_images_in_lanes<T>(body, own, stored, n, pair, sums);
    if constexpr (is_mirrored<Body>) add_mirrored_in_lanes(w, body, own, stored, n, pair, sums);
  }
  auto sum = sums.total();
  sum.add(apart);
  return sum;
}

/// The body of a gather, for a CPU.
template <bool Periodic, class Body>
struct InLanes : Body {
  static constexpr bool wide = true;
  explicit InLanes(const Body& body) : Body(body) {}
  typename Body::Sum sum(std::uint64_t i) const {
    if (!Body::takes_part(i)) return {};
    return sum_in_lanes<Periodic>(Body::w, static_cast<const Body&>(*this), i);
  }
  void operator()(std::uint64_t i) const {
    if constexpr (is_listed<Body>)
      if (!Body::wanted(i)) return;
    Body::finish(i, sum(i));
  }
  template <class Add>
  void operator()(std::uint64_t i, const Add& add) const {
    Body::finish(i, sum(i), add);
  }
};

/// The same for the first sweep of a sub-step, which finds neighbours.
template <bool Periodic, class T, class Body>
struct FoundInLanes : Body {
  static constexpr bool wide = true;
  LanePositions<T> p;
  FoundInLanes(const Body& body, const LanePositions<T>& positions) : Body(body), p(positions) {}
  void operator()(std::uint64_t i) const {
    if (Body::w.f.group_of[i] == core::none) return Body::finish(i, {});  // removed
    typename Body::Sum::Lanes sums;
    const auto found = [&](std::size_t l, T volume, T r2) {
      auto sum = sums.at(l);
      Body::found(sum, volume, r2);
      sums.put(l, sum);
    };
    find_in_lanes<Periodic>(Body::w, p, i,
                            [&](std::size_t l, T volume, const Vec3<T>&, T r2) { found(l, volume, r2); });
    if constexpr (Body::mirrors) {
      const auto walls = physics::wall_view(Body::w.c.walls, xyz(Body::w.f.position[i]));
      if (walls.axes != 0u) for_each_found_image(i, walls, found);
    }
    Body::finish(i, sums.total());
  }

 private:
  /// found(lane, V_j, r_m^2)
  template <class Found>
  void for_each_found_image(std::uint64_t i, const physics::WallView<T>& walls, const Found& found) const {
    const core::Grid<T> grid = Body::w.grid;
    const Vec3<T> xi = xyz(Body::w.f.position[i]);
    Batches<Periodic, T> neighbours(Body::w, i);
    while (const std::uint32_t n = neighbours.next()) {
      LaneVectors<T> x;
      x.load(Body::w.f.position, neighbours.slots, n);
      cut(x.w, n);
      for_each_mask(walls.axes, [&](std::uint32_t mask) {
        in_lanes(n, [&](std::size_t l, std::size_t k) {
          const Vec3<T> x_ij = separation<Periodic>(grid, xi, Vec3<T>{x.x[k], x.y[k], x.z[k]});
          found(l, x.w[k], physics::image_square(walls, x_ij, dot(x_ij, x_ij), mask));
        });
      });
    }
  }
};

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
