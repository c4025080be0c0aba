// SPDX-License-Identifier: Apache-2.0
// The neighbour loop. The first sweep of a sub-step goes through the candidates and stores which of them are within H
// (neighbour_words.hpp); every later one visits only those.
#pragma once

#include <type_traits>

#include "spatial/neighbour_words.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Kinds of first sweeps: periodic axes; none; or none, and cells that are counted in every
/// sub-step, so that rows follow from where they begin.
enum class SearchKind { periodic, plain, counted };
template <bool Periodic>
inline constexpr SearchKind search_kind = Periodic ? SearchKind::periodic : SearchKind::plain;

/// A first sweep of the candidates of Count particles at x, which writes their neighbours into `words`.
template <SearchKind kind, std::uint32_t Count, class T, class Visit>
struct Search {
  const core::Frame<T>& w;
  const Vec3<T> (&x)[Count];
  WordWriter<T> (&words)[Count];
  const Visit& visit;
  std::uint32_t bits[Count]{};  ///< the first candidate's bit comes out highest

  /// Visits a candidate if it is near. Where branches are expensive, those beyond H are visited, too: their terms vanish
  /// without a branch.
  MELTSIM_HD void look(const Vec4<T>& xj) {
    T r2[Count];
    bool near = on_device();
    for (std::uint32_t p = 0; p < Count; ++p) {
      const Vec3<T> d = separation<kind == SearchKind::periodic>(w.grid, x[p], xyz(xj));
      r2[p] = dot(d, d);
      const T beyond = r2[p] - w.c.kernel.support2;
      near = near || beyond < T(0);
      bits[p] = bits[p] << 1 | sign_bit(beyond);  // 1 where near, without a comparison
    }
    if (near) visit(xj, r2);
  }
  /// Four at a time: their loads are under way together.
  MELTSIM_HD void look_at_four(const Vec4<T>* xj) {
    const Vec4<T> x0 = xj[0], x1 = xj[1], x2 = xj[2], x3 = xj[3];
    look(x0);
    look(x1);
    look(x2);
    look(x3);
  }
  /// Writes the bits of `count` candidates from slot `begin` on.
  MELTSIM_HD void note(std::uint32_t begin, std::uint32_t count) {
    for (std::uint32_t p = 0; p < Count; ++p) {
      words[p].add(begin, reversed(bits[p]) >> (word_bits - count));
      bits[p] = 0u;
    }
  }
  /// Looks at `left` candidates from slot `begin` on.
  MELTSIM_HD void mark(std::uint32_t begin, std::uint32_t left) {
    const Vec4<T>* xj = w.f.position + begin;
    std::uint32_t done = 0;
    const auto four = [&] {
      look_at_four(xj);
      left -= 4u, done += 4u, xj += 4;
    };
    while (left >= 8u) {
      four();
      four();
      if (done == word_bits) {
        note(begin, word_bits);
        begin += word_bits, done = 0u;
      }
    }
    if (left >= 4u) four();
    if (left != 0u) {
      const Vec4<T> x0 = xj[0], x1 = xj[left > 1u ? 1 : 0], x2 = xj[left > 2u ? 2 : 0];
      look(x0);
      if (left > 1u) look(x1);
      if (left > 2u) look(x2);
    }
    if (done + left != 0u) note(begin, done + left);
  }
};

/// visit(x_j, r2) for every candidate in these rows, r2 to each of the particles at x, and stores the neighbours of each of
/// them.
template <SearchKind kind, std::uint32_t Count, class T, class SomeKindOfRows, class Visit>
MELTSIM_HD void search_for(const core::Frame<T>& w, const SomeKindOfRows& rows, SomeRows set,
                           const Vec3<T> (&x)[Count], WordWriter<T> (&words)[Count], const Visit& visit) {
  Search<kind, Count, T, Visit> search{w, x, words, visit};
  while (!set.empty()) {
    const core::Range row = rows[set.take()];
    if (row.begin < row.end) search.mark(row.begin, row.end - row.begin);
  }
}

/// visit(x_j, r2) for every candidate of particle i in one part of its rows, and stores the neighbours as set `part` of words:
/// the first sweep of a sub-step.
template <SearchKind kind, class T, class Visit>
MELTSIM_HD void find_part(const core::Frame<T>& w, std::uint64_t i, std::uint32_t part, std::uint32_t parts,
                          const Visit& visit) {
  const Vec3<T> x[1] = {xyz(w.f.position[i])};
  WordWriter<T> words[1] = {{w, i, part}};
  SomeRows set = rows_of_part(w, part, parts);
  const auto search = [&](const auto& rows) {
    set.bits &= rows.within();
    search_for<kind>(w, rows, set, x, words, [&](const Vec4<T>& xj, const T(&r2)[1]) { visit(xj, r2[0]); });
  };
  if constexpr (kind == SearchKind::counted) {
    const std::uint32_t cell = w.f.group_of[i];
    search(CountedRows<T>(w, cell, cell));
  } else {
    search(Rows<kind == SearchKind::periodic, T>(w, i));
  }
  words[0].close();
}

/// The same for particles i and i + 1 at once, where cells are counted; visit(x_j, r2 of each). Most follow each other in
/// one line of cells and have nearly the same candidates: a position that is loaded serves both, and so does what it
/// costs to reach the next row. Returns the number of particles: i alone if it is the last or the next is in another line
/// (first_of_line finds that one), or where that is asked for. Removed ones have no candidates.
template <class T, class Visit>
MELTSIM_HD std::uint32_t find_two(const core::Frame<T>& w, std::uint64_t i, bool alone, const Visit& visit) {
  const std::uint32_t there = alone || i + 1u >= w.particles ? 1u : 2u;
  std::uint32_t from = w.f.group_of[i], to = from;
  if (from == core::none) return there;
  if (there == 2u) to = w.f.group_of[i + 1u];
  const bool two = there == 2u && to != core::none;
  if (!two) to = from;
  WordWriter<T> words[2] = {{w, i, 0u}, {w, i + 1u, 0u}};
  for (bool again = false;;) {
    const CountedRows<T> rows(w, from, to);
    const std::uint32_t done = rows.of_both() ? there : rows.one_line() ? 0u : 1u;
    Vec3<T> x[2] = {xyz(w.f.position[i]), xyz(w.f.position[i + (two ? 1u : 0u)])};
    // A position far from all candidates, whose sum stays 0.
    const T away = T(1e4) * w.c.kernel.support;
    if (again) x[0] += Vec3<T>{away, away, away};
    if (!two || !rows.of_both()) x[1] += Vec3<T>{away, away, away};
    SomeRows set = rows_of_part(w, 0u, 1u);
    set.bits &= rows.within();
    search_for<SearchKind::counted>(w, rows, set, x, words,
                                    [&](const Vec4<T>& xj, const T(&r2)[2]) { visit(xj, r2[0], r2[1]); });
    if (done != 0u) {
      words[0].close();
      if (done == 2u) words[1].close();
      return done;
    }
    from = to;  // far apart: one after the other
    again = true;
  }
}

/// Lines of cells along x.
template <class T>
std::uint64_t lines(const core::Grid<T>& g) {
  return static_cast<std::uint64_t>(g.ny) * static_cast<std::uint64_t>(g.nz);
}

/// Whether find_two is faster than one particle per thread. A million particles on an H200 [ms per sub-step]: at 2 spacings
/// water 0.351 to 0.332, melting 0.757 to 0.744; at 2.5, where a row is longer than a word, water 0.574 both ways, melting
/// 1.150 to 1.185: shape matching beside it leaves room for half as many warps. In short lines too many would be left over.
template <class T>
bool pays_by_twos(const core::Frame<T>& w) {
  return w.c.kernel.support < T(2.25) * w.c.spacing && w.grid.nx >= 64;
}

/// The particle that begins a line of cells where find_two leaves it alone; behind all particles where there is none.
template <class T>
MELTSIM_HD std::uint64_t first_of_line(const core::Frame<T>& w, std::uint64_t line) {
  const std::uint32_t* cells = w.f.cell_begin + line * static_cast<std::uint64_t>(w.grid.nx);
  const std::uint32_t begin = cells[0], end = cells[w.grid.nx];
  return begin % 2u == 1u && begin < end ? begin : w.particles;
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

/// All neighbours from the last down, for sweeps that are not worth two kernels.
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
