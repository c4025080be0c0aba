// SPDX-License-Identifier: Apache-2.0
// Kernels of the search by a tree: the paper's KD-tree, in a form that is built by a sort and a scan. Space
// is halved along its axes in turn; particles lie in the order in which a Hilbert curve visits the halves, so
// every node of that tree is a run of slots (Lauterbach et al. 2009, "Fast BVH construction on GPUs", there
// with the Morton curve; Hilbert's has no jumps, which leaves 12 rows per leaf instead of 16). Leaves are the
// largest halves of at most 8 particles and no longer than H. Above them eight neighbours along the curve
// share a box, whatever halves they are of: that needs no links, and boxes are exact at every level.
//
// The order depends on positions and ids alone. Nothing here depends on the size of the domain.
#pragma once

#include "spatial/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

/// Most particles of a leaf. At 61 neighbours on a jittered lattice, candidates and rows per particle: 4: 168
/// and 16; 8: 265 and 12; 16: 362 and 8. Small leaves cost walks, large ones candidates.
inline constexpr std::uint32_t leaf_size = 8;

/// Every third bit of a word.
MELTSIM_HD std::uint64_t spread_bits(std::uint64_t v) {
  v = (v | v << 32) & 0x1f00000000ffffu;
  v = (v | v << 16) & 0x1f0000ff0000ffu;
  v = (v | v << 8) & 0x100f00f00f00f00fu;
  v = (v | v << 4) & 0x10c30c30c30c30c3u;
  return (v | v << 2) & 0x1249249249249249u;
}

/// Place of a cell along the Hilbert curve through 2^bits cells per axis (Skilling 2004, "Programming the
/// Hilbert curve": axes to transpose).
MELTSIM_HD std::uint64_t hilbert_code(std::uint32_t x, std::uint32_t y, std::uint32_t z, std::uint32_t bits) {
  const std::uint32_t top = 1u << (bits - 1u);
  // Bits are as good as random: selected by masks, not by branches.
  const auto turn = [&x](std::uint32_t& a, std::uint32_t bit) {
    const std::uint32_t low = bit - 1u, set = (a & bit) != 0u ? low : 0u;
    const std::uint32_t t = (x ^ a) & (low ^ set);
    x ^= set ^ t;
    a ^= t;
  };
  for (std::uint32_t bit = top; bit > 1u; bit >>= 1) {
    x ^= (x & bit) != 0u ? bit - 1u : 0u;
    turn(y, bit);
    turn(z, bit);
  }
  y ^= x;
  z ^= y;
  std::uint32_t t = 0;
  for (std::uint32_t bit = top; bit > 1u; bit >>= 1) t ^= (z & bit) != 0u ? bit - 1u : 0u;
  return spread_bits(x ^ t) << 2 | spread_bits(y ^ t) << 1 | spread_bits(z ^ t);
}

/// One call per id, so that ids ascend where codes are equal. Removed particles come last.
template <class T>
struct CodesBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t id) const {
    const std::uint32_t slot = w.f.slot_of_id[id];
    w.f.sort_slot[id] = slot;
    w.f.sort_key[id] = removed_key;
    if (is_removed(w.before.tag[slot])) return;
    const Vec3<T> x =
        physics::drift(xyz(w.before.position[slot]), xyz(w.before.velocity[slot]), w.f.clock->half_dt);
    const Vec3<T> cell = (x - w.tree.min) * w.tree.inv_cell;
    const auto clamped = [&](T c) {
      return static_cast<std::uint32_t>(clamp(std::floor(c), T(0), T((1u << w.tree.bits) - 1u)));
    };
    w.f.sort_key[id] = hilbert_code(clamped(cell.x), clamped(cell.y), clamped(cell.z), w.tree.bits);
  }
};

/// Leading bits that two codes share: the depth of the smallest half that holds both.
MELTSIM_HD int shared_depth(std::uint64_t a, std::uint64_t b, int bits) {
  const std::uint64_t differ = a ^ b;
  return differ == 0u ? bits : bits - 1 - highest_bit(differ);
}

/// 1 where a leaf begins. Written down before it is summed: a thread of a sum asks for one item after another.
template <class T>
struct LeafHeadBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t at) const { w.f.sort_slot[at] = is_head(at); }

 private:
  MELTSIM_HD std::uint32_t is_head(std::uint64_t at) const {
    const auto i = static_cast<std::int64_t>(at), n = static_cast<std::int64_t>(w.particles);
    const std::uint64_t* keys = w.f.sort_key_alt;
    const std::uint64_t mine = keys[i];
    if (mine == removed_key) return 0u;
    if (i == 0) return 1u;
    const int bits = static_cast<int>(3u * w.tree.bits);
    // The depth shared with the nearest neighbour along the curve that no longer fits into the leaf: the leaf is deeper.
    int depth = -1;
    std::int64_t before = i - 1, after = i + 1;
    for (std::uint32_t k = 0; k < leaf_size; ++k) {
      const int a = before >= 0 ? shared_depth(keys[before], mine, bits) : -1;
      const int b = after < n && keys[after] != removed_key ? shared_depth(keys[after], mine, bits) : -1;
      depth = maximum(a, b);
      before -= a >= b ? 1 : 0;
      after += a >= b ? 0 : 1;
    }
    if (depth == bits) {  // more than fit share one cell of the curve: runs of that many
      const std::uint32_t first = first_not_below(keys, static_cast<std::uint32_t>(i), mine);
      return (static_cast<std::uint32_t>(i) - first) % leaf_size == 0u ? 1u : 0u;
    }
    constexpr int cells_to_support = 2;  // log2(core::tree_resolution): a leaf is at most H long
    const int least = 3 * maximum(static_cast<int>(w.tree.bits) - cells_to_support, 0);
    return shared_depth(keys[i - 1], mine, bits) < maximum(depth + 1, least) ? 1u : 0u;
  }
};

template <class T>
struct LeafHeadsBody {
  Frame<T> w;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i) const { return w.f.sort_slot[i]; }
};

/// Turns the running count of heads into leaf numbers and lists the leaves.
template <class T>
struct LeavesBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t* heads = w.f.sort_slot;  // up to and including i; the sort is done with it
    const bool live = w.f.sort_key_alt[i] != removed_key;
    const bool last = live && (i + 1 == w.particles || w.f.sort_key_alt[i + 1] == removed_key);
    const std::uint32_t count = heads[i];
    if (live && (i == 0 || heads[i - 1] != count)) w.f.group_begin[count - 1] = static_cast<std::uint32_t>(i);
    if (last || (i == 0 && !live)) {
      w.f.group_begin[count] = last ? static_cast<std::uint32_t>(i) + 1u : 0u;
      w.f.status->groups = count;
    }
    if (live) w.f.group_of[i] = count - 1u;
    else w.f.group_of[i] = none;
  }
};

/// Nodes of a level above `leaves` leaves.
MELTSIM_HD std::uint64_t nodes_of(std::uint64_t leaves, int level) {
  return (leaves + (std::uint64_t{1} << (3 * level)) - 1u) >> (3 * level);
}

template <class T>
struct BoxBody {
  Frame<T> w;
  int level;
  MELTSIM_HD void operator()(std::uint64_t node) const {
    const std::uint64_t groups = w.f.status->groups;
    if (node >= nodes_of(groups, level)) return;
    core::TreeBox<T> box;
    const auto grow = [&box](Vec3<T> low, Vec3<T> high) {
      box.low = {minimum(box.low.x, low.x), minimum(box.low.y, low.y), minimum(box.low.z, low.z)};
      box.high = {maximum(box.high.x, high.x), maximum(box.high.y, high.y), maximum(box.high.z, high.z)};
    };
    if (level == 0) {
      box.low = box.high = xyz(w.f.position[w.f.group_begin[node]]);
      for (std::uint32_t i = w.f.group_begin[node] + 1u; i < w.f.group_begin[node + 1]; ++i)
        grow(xyz(w.f.position[i]), xyz(w.f.position[i]));
    } else {
      const core::TreeBox<T>* below = w.f.tree_box + w.tree.first[level - 1];
      const std::uint64_t end = minimum(8u * node + 8u, nodes_of(groups, level - 1));
      box = below[8u * node];
      for (std::uint64_t child = 8u * node + 1u; child < end; ++child)
        grow(below[child].low, below[child].high);
    }
    w.f.tree_box[w.tree.first[level] + node] = box;
  }
};

/// Distance of two intervals along one axis, the nearest image where it wraps (period 0: it does not).
template <bool Periodic, class T>
MELTSIM_HD T interval_gap(T low, T high, T other_low, T other_high, T period, T inv_period) {
  if (!Periodic || !(period > T(0))) return maximum(maximum(other_low - high, low - other_high), T(0));
  T between = T(0.5) * ((low + high) - (other_low + other_high));
  between -= period * std::rint(between * inv_period);
  return maximum(std::fabs(between) - T(0.5) * ((high - low) + (other_high - other_low)), T(0));
}

template <bool Periodic, class T>
MELTSIM_HD bool within_reach(const Frame<T>& w, const core::TreeBox<T>& a, const core::TreeBox<T>& b) {
  const auto& g = w.grid;
  const T x = interval_gap<Periodic>(a.low.x, a.high.x, b.low.x, b.high.x, g.period.x, g.inv_period.x);
  const T y = interval_gap<Periodic>(a.low.y, a.high.y, b.low.y, b.high.y, g.period.y, g.inv_period.y);
  const T z = interval_gap<Periodic>(a.low.z, a.high.z, b.low.z, b.high.z, g.period.z, g.inv_period.z);
  return x * x + y * y + z * z < w.tree.reach * w.tree.reach;
}

/// Which of up to eight brothers from `first` on are within H of a box.
template <bool Periodic, class T>
MELTSIM_HD std::uint32_t brothers_within_reach(const Frame<T>& w, const core::TreeBox<T>& mine,
                                               std::uint64_t groups, int level, std::uint32_t first) {
  const core::TreeBox<T>* boxes = w.f.tree_box + w.tree.first[level] + first;
  const auto n = static_cast<std::uint32_t>(minimum(nodes_of(groups, level) - first, std::uint64_t{8}));
  std::uint32_t bits = 0;
  for (std::uint32_t k = 0; k < n; ++k) bits |= (within_reach<Periodic>(w, mine, boxes[k]) ? 1u : 0u) << k;
  return bits;
}

/// The rows of one group, filled with runs of slots that ascend. Runs beyond the last row are kept by joining
/// the two runs with the fewest slots between them: candidates more, none less.
class RowList {
 public:
  MELTSIM_HD RowList(Range* rows, std::uint32_t most) : rows_(rows), most_(most) {}
  MELTSIM_HD void add(Range run) {
    if (count_ != 0u && rows_[count_ - 1u].end == run.begin) {
      rows_[count_ - 1u].end = run.end;
      return;
    }
    if (count_ == most_) {
      std::uint32_t best = most_ - 1u, least = run.begin - rows_[most_ - 1u].end;
      for (std::uint32_t k = 0; k + 1u < most_; ++k) {
        const std::uint32_t gap = rows_[k + 1u].begin - rows_[k].end;
        if (gap < least) {
          least = gap;
          best = k;
        }
      }
      if (best == most_ - 1u) {
        rows_[best].end = run.end;
        return;
      }
      rows_[best].end = rows_[best + 1u].end;
      for (std::uint32_t k = best + 1u; k + 1u < most_; ++k) rows_[k] = rows_[k + 1u];
      --count_;
    }
    rows_[count_++] = run;
  }
  /// The rest of the rows are empty.
  MELTSIM_HD void finish() {
    for (std::uint32_t k = count_; k < most_; ++k) rows_[k] = Range{0u, 0u};
  }

 private:
  Range* rows_;
  std::uint32_t most_, count_ = 0;
};

/// The rows of a leaf: every leaf within H of it, found from the top of the tree down, in order of slots.
template <class T, bool Periodic>
struct WalkBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t leaf) const {
    const std::uint64_t groups = w.f.status->groups;
    if (leaf >= groups) return;
    RowList rows(w.f.group_ranges + leaf * w.grid.rows, w.grid.rows);
    const core::TreeBox<T> mine = w.f.tree_box[leaf];
    // Eight brothers at a time: where they begin and which of them are still to be visited.
    std::uint32_t first[core::Tree<T>::most_levels], left[core::Tree<T>::most_levels];
    int top = 0;
    while (nodes_of(groups, top) > 1u) ++top;
    int level = top;
    first[top] = 0u;
    left[top] = 1u;
    for (;;) {
      if (left[level] == 0u) {
        if (level == top) break;
        ++level;
        continue;
      }
      const std::uint32_t node = first[level] + static_cast<std::uint32_t>(lowest_bit(left[level]));
      left[level] &= left[level] - 1u;
      if (level == 0) {
        rows.add(Range{w.f.group_begin[node], w.f.group_begin[node + 1]});
      } else {
        --level;
        first[level] = 8u * node;
        left[level] = brothers_within_reach<Periodic>(w, mine, groups, level, first[level]);
      }
    }
    rows.finish();
  }
};

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
