// SPDX-License-Identifier: Apache-2.0
// How neighbours are stored: words of 32 candidates, a bit for each that is within H, with the slot of the
// first. What is found once, most sweeps of a sub-step walk; the next bit is a few instructions away, the next
// word is loaded ahead, and words without neighbours are left out. (Bits by row of the grid save the slots, 64
// bytes per particle, but to come to the next row takes 30 instructions, at almost every turn of a warp.)
//
// neighbour_words is a table of columns, one entry per particle, so that threads side by
// side read side by side: a header, which says how many words and neighbours follow, then the words. Where a search
// is shared out (exec/gather.hpp), each of its words_parts parts fills a set of its own, 1 + words_room columns;
// joined, they are one sequence, and every part of a later sum takes its share of the neighbours, as many as the
// others. Where there are too many for the room, candidates are searched again by every sweep.
#pragma once

#include <type_traits>

#include "spatial/rows.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

using core::NeighbourWord;

/// Header of a particle with more words than fit.
inline constexpr std::uint32_t too_many = 0xffffffffu;

/// The header of a sequence; it has no bits, which ends a walk.
MELTSIM_HD NeighbourWord words_header(std::uint32_t words, std::uint32_t neighbours) {
  return {words | neighbours << 16, 0u};
}
MELTSIM_HD std::uint32_t words_in(NeighbourWord header) { return header.first & 0xffffu; }
MELTSIM_HD std::uint32_t neighbours_in(NeighbourWord header) { return header.first >> 16; }

/// Candidates of a word.
inline constexpr std::uint32_t word_bits = 32;

/// Words that a set holds at a support of so many spacings: what nine rows, 2.25 supports long and one wide, take
/// where they are a quarter denser than liquid, and three more, nine where rows wrap around: 16 at 2.5 spacings.
/// Jittered lattices take 8 on average and 13 at most; with room for 13 enough solids beside liquid had to be
/// searched again that heat took a quarter longer.
inline std::uint32_t words_room(double support, std::uint32_t rows, std::uint32_t parts) {
  const double in_row = 1.25 * 2.25 * support * support * support / word_bits;
  const std::uint32_t share = 9u / parts, spare = (rows > 9u ? 9u : 3u) / parts + (parts > 1u ? 1u : 0u);
  return maximum(share, static_cast<std::uint32_t>(share * in_row) + 1u) + spare;
}

/// Entries per column: whole warps.
inline std::uint64_t words_stride(std::uint64_t particles) { return (particles + 31u) / 32u * 32u; }

/// The entry of the same particle so many bytes on: whole columns. Bytes, as that saves a walk two instructions
/// per word.
template <class Word>
MELTSIM_HD Word* columns_on(Word* at, std::uint64_t bytes) {
  using Byte = std::conditional_t<std::is_const<Word>::value, const char, char>;
  return reinterpret_cast<Word*>(reinterpret_cast<Byte*>(at) + bytes);
}

template <class T>
MELTSIM_HD NeighbourWord* words_of(const core::Frame<T>& w, std::uint64_t i, std::uint32_t set) {
  return columns_on(w.f.neighbour_words + i, std::uint64_t{set} * (w.words_room + 1u) * w.words_column);
}

/// Writes one set of words.
template <class T>
class WordWriter {
 public:
  MELTSIM_HD WordWriter(const core::Frame<T>& w, std::uint64_t i, std::uint32_t set)
      : first_(words_of(w, i, set)), at_(first_), column_(w.words_column), room_(w.words_room) {}
  MELTSIM_HD void add(std::uint32_t first, std::uint32_t bits) {
    if (bits == 0u) return;
    if (++count_ > room_) return;
    at_ = columns_on(at_, column_);
    *at_ = {first, bits};
    neighbours_ += static_cast<std::uint32_t>(popcount(bits));
  }
  MELTSIM_HD void close() const {
    if (count_ <= room_) *first_ = words_header(count_, neighbours_);
    else *first_ = {too_many, 0u};
  }

 private:
  NeighbourWord *first_, *at_;
  std::uint64_t column_;
  std::uint32_t room_, count_ = 0, neighbours_ = 0;
};

/// Makes one sequence of the sets of i, once all parts of the search have filled theirs. What moves moves down, to
/// where its set or one before it has been read.
template <class T>
MELTSIM_HD void join_words(const core::Frame<T>& w, std::uint64_t i) {
  if (w.words_parts == 1u) return;
  NeighbourWord* const first = words_of(w, i, 0u);
  NeighbourWord header = *first;
  NeighbourWord* to = columns_on(first, words_in(header) * w.words_column);
  for (std::uint32_t s = 1; s < w.words_parts; ++s) {
    const NeighbourWord* from = words_of(w, i, s);
    const NeighbourWord more = *from;
    if (header.first == too_many || more.first == too_many) {
      *first = {too_many, 0u};
      return;
    }
    header.first += more.first;  // both counts
    const auto take = [&] { return *(from = columns_on(from, w.words_column)); };
    const auto put = [&](NeighbourWord word) { *(to = columns_on(to, w.words_column)) = word; };
    std::uint32_t left = words_in(more);
    for (; left >= 2u; left -= 2u) {  // two at a time: their loads are under way together
      const NeighbourWord one = take(), two = take();
      put(one);
      put(two);
    }
    if (left != 0u) put(take());
  }
  *first = header;
}

/// A walk through words: from the last neighbour down, because the highest bit is an instruction nearer than the
/// lowest, and the header, which comes before the first word, says by having no bits that there are no more.
template <class T>
class WordWalk {
 public:
  MELTSIM_HD WordWalk(const core::Frame<T>& w, const NeighbourWord* header, std::uint32_t words)
      : at_(columns_on(header, words * w.words_column)), word_(*at_), column_(w.words_column) {}
  MELTSIM_HD bool ended() const { return word_.bits == 0u; }
  /// The next word is on its way while the last neighbour of this one is visited.
  MELTSIM_HD std::uint32_t take() {
    const auto b = static_cast<std::uint32_t>(highest_bit(word_.bits));
    word_.bits &= bits_below(b);
    const std::uint32_t j = word_.first + b;
    if (word_.bits == 0u) next_word();
    return j;
  }
  MELTSIM_HD void skip(std::uint32_t neighbours) {
    for (std::uint32_t n; (n = static_cast<std::uint32_t>(popcount(word_.bits))) <= neighbours;
         neighbours -= n)
      next_word();
    for (; neighbours != 0u; --neighbours) word_.bits ^= 1u << highest_bit(word_.bits);
  }

 private:
  MELTSIM_HD void next_word() { word_ = *(at_ = columns_on(at_, -column_)); }
  const NeighbourWord* at_;
  NeighbourWord word_;
  std::uint64_t column_;
};

/// see(j) for part k of the neighbours of i, as many for every part. False where the words are too many: rows have to
/// be searched. One loop with a turn per neighbour, so that threads side by side meet at every neighbour.
template <class T, class See>
MELTSIM_HD bool walk_words(const core::Frame<T>& w, std::uint64_t i, std::uint32_t k, std::uint32_t parts,
                           const See& see) {
  const NeighbourWord* const header = words_of(w, i, 0u);
  if (header->first == too_many) return false;
  WordWalk<T> walk(w, header, words_in(*header));
  if (parts == 1u) {
    while (!walk.ended()) see(walk.take());
    return true;
  }
  const std::uint32_t all = neighbours_in(*header), begin = all * k / parts;
  std::uint32_t left = all * (k + 1u) / parts - begin;
  if (left == 0u) return true;
  walk.skip(begin);
  do see(walk.take());
  while (--left != 0u);
  return true;
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
