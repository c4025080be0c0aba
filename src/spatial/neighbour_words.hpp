// SPDX-License-Identifier: Apache-2.0
// How neighbours are stored: words of 32 candidates, a bit for each that is within H, with the slot of the
// first. What is found once, most sweeps of a sub-step walk; the next bit is a few instructions away, the next
// word is loaded ahead, and words without neighbours are left out. (Bits by row of the grid save the slots, 64
// bytes per particle, but to come to the next row takes 30 instructions, at almost every turn of a warp.)
//
// neighbour_words is a table of columns, one entry per particle, so that threads side by
// side read side by side. A particle has words_parts sets of them, one per part of a sum that is shared out
// (core/gather.hpp), each of 1 + words_room columns: how many, then the words. Where there are too many for the
// room, candidates are searched again by every sweep.
#pragma once

#include <type_traits>

#include "spatial/rows.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

using core::NeighbourWord;

/// In place of how many words there are: more than fit.
inline constexpr std::uint32_t too_many = 0xffffffffu;

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
  }
  MELTSIM_HD void close() const { *first_ = {count_ <= room_ ? count_ : too_many, 0u}; }

 private:
  NeighbourWord *first_, *at_;
  std::uint64_t column_;
  std::uint32_t room_, count_ = 0;
};

/// The share of a part of a sum: sets [begin, end) of words, of each the words first, first + step, ...
struct WordShare {
  std::uint32_t begin, end, first, step;
};
/// parts: 1; 3, where there are three sets; or core::listed_parts, each of which takes its words of one set. A
/// constant, so that most loops have no steps.
template <class T>
MELTSIM_HD WordShare word_share(const core::Frame<T>& w, std::uint32_t part, std::uint32_t parts) {
  if (parts == 1u) return {0u, w.words_parts, 0u, 1u};
  if (parts == 3u) return {part, part + 1u, 0u, 1u};
  const std::uint32_t step = parts / w.words_parts;
  return {part / step, part / step + 1u, part % step, step};
}

/// see(j) for the neighbours of one set, or for those of its words first, first + step, ... counted from the
/// last: from the last neighbour down, because the highest bit is an instruction nearer than the lowest, and what
/// comes before the first word says by itself that there are no more. False where the words are too many: rows
/// have to be searched. One loop with a turn per neighbour, so that threads side by side meet at every
/// neighbour; the next word is on its way while one is walked.
template <class T, class See>
MELTSIM_HD bool walk_words(const core::Frame<T>& w, std::uint64_t i, std::uint32_t set, std::uint32_t first,
                           std::uint32_t step, const See& see) {
  const NeighbourWord* at = words_of(w, i, set);
  const std::uint32_t count = at->first;
  if (count == too_many) return false;
  if (first >= count) return true;
  std::uint32_t left = (count - first - 1u) / step;  // steps of more than one may miss the beginning
  at = columns_on(at, (count - first) * w.words_column);
  NeighbourWord word = *at;
  do {
    const auto b = static_cast<std::uint32_t>(highest_bit(word.bits));
    const std::uint32_t j = word.first + b;
    word.bits ^= 1u << b;
    if (word.bits == 0u && (step == 1u || left-- != 0u))
      word = *(at = columns_on(at, -(step * w.words_column)));
    see(j);
  } while (word.bits != 0u);
  return true;
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
