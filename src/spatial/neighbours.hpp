// SPDX-License-Identifier: Apache-2.0
// The neighbour loop. The first sweep of a sub-step goes through the candidates and stores who is within H
// (neighbour_words.hpp); every later one visits only those.
#pragma once

#include <type_traits>

#include "spatial/neighbour_words.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// What a first sweep has to reckon with: axes that wrap; none; or none, and cells that are counted anew in every
/// sub-step, so that rows follow from where they begin.
enum class SearchKind { periodic, plain, counted };
template <bool Periodic>
inline constexpr SearchKind search_kind = Periodic ? SearchKind::periodic : SearchKind::plain;

/// Candidates of a row that far_bits covers.
inline constexpr std::uint32_t far_bits_per_row = 64;

/// visit(j, x_j, x_ij, r2) for every candidate in these rows, and stores which are near as set `part` of words:
/// the first sweep of a sub-step. Where branches are dear, candidates that are not near are visited, too; what
/// vanishes beyond H needs no branch.
template <SearchKind kind, class T, class Visit>
MELTSIM_HD void find_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, std::uint32_t parts,
                          const Visit& visit) {
  constexpr bool Periodic = kind == SearchKind::periodic, counted = kind == SearchKind::counted;
  const Vec3<T> xi = xyz(w.f.position[i]);
  const std::conditional_t<counted, CountedRows<T>, Rows<Periodic, T>> rows(w, i);
  WordWriter<T> words(w, i, part);
  // 1 where near: the sign of a difference, which takes no comparison.
  const auto look = [&](std::uint32_t j, const Vec4<T>& xj) {
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    const T r2 = dot(d, d), beyond = r2 - w.c.kernel.support2;
    if (on_device() || beyond < T(0)) visit(j, xj, d, r2);
    return sign_bit(beyond);
  };
  const auto mark = [&](std::uint32_t begin, std::uint32_t count) {
    const Vec4<T>* x = w.f.position + begin;
    std::uint32_t bits = 0, j = begin, left = count;  // the first candidate's bit comes out highest
    // Four at a time: their loads are under way together.
    const auto four = [&] {
      const Vec4<T> x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
      bits = bits << 1 | look(j, x0);
      bits = bits << 1 | look(j + 1u, x1);
      bits = bits << 1 | look(j + 2u, x2);
      bits = bits << 1 | look(j + 3u, x3);
      left -= 4u, j += 4u, x += 4;
    };
    while (left >= 8u) {
      four();
      four();
    }
    if (left >= 4u) four();
    if (left != 0u) {
      const Vec4<T> x0 = x[0], x1 = x[left > 1u ? 1 : 0], x2 = x[left > 2u ? 2 : 0];
      bits = bits << 1 | look(j, x0);
      if (left > 1u) bits = bits << 1 | look(j + 1u, x1);
      if (left > 2u) bits = bits << 1 | look(j + 2u, x2);
    }
    words.add(begin, reversed(bits) >> (word_bits - count));
  };
  // A kept grid knows who cannot be near.
  const auto mark_some = [&](std::uint32_t begin, std::uint32_t far) {
    std::uint32_t near = far;
    for (std::uint32_t bits = far; bits != 0u; bits &= bits - 1u) {
      const std::uint32_t j = begin + static_cast<std::uint32_t>(lowest_bit(bits));
      if (look(j, w.f.position[j]) == 0u) near &= ~(bits & (~bits + 1u));
    }
    words.add(begin, near);
  };
  SomeRows set = rows_of_part(w, part, parts);
  set.bits &= rows.within();
  while (!set.empty()) {
    const std::uint32_t r = set.take();
    const core::Range row = rows[r];
    std::uint32_t from = row.begin;
    if (!counted && w.f.far_bits != nullptr) {
      const std::uint64_t far = w.f.far_bits[static_cast<std::uint64_t>(r) * w.bits_stride + i];
      mark_some(from, static_cast<std::uint32_t>(far));
      mark_some(from + word_bits, static_cast<std::uint32_t>(far >> word_bits));
      from += far_bits_per_row;
    }
    for (; from < row.end; from += word_bits) mark(from, minimum(row.end - from, word_bits));
  }
  words.close();
}

/// visit(j, x_j, x_ij, r2) for every particle j with |x_ij| < H, i itself included (x_ij = 0), or for one part of
/// them (of 1, 3 or 9). Needs the words that the first sweep stored. All of them are one sequence: threads that run
/// side by side wait for the longest sum, not for the longest of every row (72 turns instead of 149 at 61
/// neighbours), and every part has as many (every third row, where a third is 26, took a warp 36 turns).
template <bool Periodic, class T, class Visit>
MELTSIM_HD void sweep_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, std::uint32_t parts,
                           const Visit& visit) {
  const Vec3<T> xi = xyz(w.f.position[i]);
  const bool walked = walk_words(w, i, part, parts, [&](std::uint32_t j) {
    const Vec4<T> xj = w.f.position[j];
    const Vec3<T> d = separation<Periodic>(w.grid, xi, xyz(xj));
    visit(j, xj, d, dot(d, d));
  });
  if (!walked) search_rows<Periodic>(w, i, rows_of_part(w, part, parts), visit);
}

/// All neighbours from the last down, where it is not worth two kernels.
template <class T, class Visit>
MELTSIM_HD void for_each_neighbour(const core::Frame<T>& w, std::uint64_t i, const Visit& visit) {
  if (w.grid.periodic != 0u) sweep_part<true>(w, i, 0u, 1u, visit);
  else sweep_part<false>(w, i, 0u, 1u, visit);
}

/// Bits [first, first + 32) of a string of bits that goes on for a word more.
MELTSIM_HD std::uint32_t bits_from(const std::uint32_t* bits, std::uint32_t first) {
  const std::uint32_t* at = bits + first / 32u;
  return static_cast<std::uint32_t>((std::uint64_t{at[1]} << 32 | at[0]) >> first % 32u);
}

/// Whether a neighbour of i is marked, i itself included; marks: a bit per slot.
template <class T>
MELTSIM_HD bool any_marked(const core::Frame<T>& w, std::uint64_t i, const std::uint32_t* marks) {
  const NeighbourWord* at = words_of(w, i, 0u);
  if (at->first == too_many) {
    bool found = false;
    for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>&, const Vec3<T>&, T) {
      found = found || (marks[j / 32u] >> j % 32u & 1u) != 0u;
    });
    return found;
  }
  for (std::uint32_t left = words_in(*at); left != 0u; --left) {
    at = columns_on(at, w.words_column);
    const NeighbourWord word = *at;
    if ((word.bits & bits_from(marks, word.first)) != 0u) return true;
  }
  return false;
}

template <SearchKind kind>
using SearchKindConstant = std::integral_constant<SearchKind, kind>;

/// stage(SearchKindConstant<...>{}): picks what is compiled.
template <class T, class Stage>
void with_search(const core::Frame<T>& w, const Stage& stage) {
  if (w.grid.periodic != 0u) stage(SearchKindConstant<SearchKind::periodic>{});
  else if (w.f.group_ranges == nullptr) stage(SearchKindConstant<SearchKind::counted>{});
  else stage(SearchKindConstant<SearchKind::plain>{});
}

/// stage(std::true_type) where axes are periodic, else stage(std::false_type): picks what is compiled.
template <class T, class Stage>
void with_periods(const core::Frame<T>& w, const Stage& stage) {
  if (w.grid.periodic != 0u) stage(std::true_type{});
  else stage(std::false_type{});
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
