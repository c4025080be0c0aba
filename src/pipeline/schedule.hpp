// SPDX-License-Identifier: Apache-2.0
// Which stages of a sub-step may run concurrently. All of it follows from the stage table: two stages of which
// one writes a channel that the other touches keep their order, others need not. Stages are laid on a few tracks
// (an executor runs the stages of one track in order); between tracks they wait for each other by name.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "pipeline/pipeline.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Executors with begin_tracks, enter_track, hurry, step_aside, mark_stage and wait_for_stage.
template <class E, class = void>
inline constexpr bool runs_tracks = false;
template <class E>
inline constexpr bool runs_tracks<E, std::void_t<decltype(std::declval<E&>().begin_tracks())>> = true;

/// Number of tracks that melting needs: shape matching, search and contact, normals of contact, loads, forces, wetted solids, heat.
/// A stage that finds no track of its own waits for one that it need not wait for.
inline constexpr int most_tracks = 7;

constexpr std::uint64_t stage_bit(int stage) { return std::uint64_t{1} << stage; }

/// Sums over all neighbours: compute-bound, they occupy a whole GPU.
inline constexpr std::uint64_t sum_stages = stage_bit(stage_sph_density) | stage_bit(stage_sph_forces) |
                                            stage_bit(stage_sph_shift) | stage_bit(stage_sph_diffuse) |
                                            stage_bit(stage_sph_strain) | stage_bit(stage_thermal_exchange);
/// Shape matching: a chain of short, memory-bound kernels.
inline constexpr std::uint64_t modest_stages = stage_bit(stage_lsm_gather) | stage_bit(stage_lsm_regions) |
                                               stage_bit(stage_lsm_goals) | stage_bit(stage_lsm_balance);

struct Schedule {
  std::array<std::int8_t, stage_count> track{};  ///< of every stage that runs; -1 of the others
  std::array<std::uint64_t, stage_count>
      waits{};  ///< bit per stage: ends on another track before this begins
  /// Modest stages with a sum to run beside: on a few threads of every multiprocessor, but before all others. The sum
  /// computes meanwhile; one after the other both would take as long as they take alone.
  std::uint64_t aside = 0;
  /// Where there is not room for all, the most urgent go first. 3: what sph.density waits for; 2: what steps aside and
  /// what that waits for; 0: what nothing waits for, and lsm.contact: all in the order in which they can begin (measured:
  /// other orders of theirs are slower); 1: the rest.
  std::array<std::int8_t, stage_count> urgency{};
  std::uint64_t awaited = 0;  ///< stages that others wait for
  std::uint64_t last = 0;     ///< the last one of every track but the first
};
static_assert(stage_count <= 64);

/// Blocks of every multiprocessor for what steps aside: all of it should be done when the sums are, which are half as
/// long at a support of 2 spacings. A million particles, a third solid, on an H200 [ms], 2, 3, 4, 5, 6, 8 blocks: 1.189,
/// 1.169, 1.187, 1.186, 1.190, 1.206 at 2.5 spacings; 0.860, 0.776, 0.769, 0.778, 0.786, 0.794 at 2.
constexpr unsigned aside_blocks(double support_in_spacings) { return support_in_spacings < 2.25 ? 4u : 3u; }

/// Every kernel tests whether the World has halted: the verdict of step.integrate holds for all stages after it, and
/// for none before it.
constexpr std::uint64_t usual_barriers = stage_bit(stage_step_begin) | stage_bit(stage_step_integrate);
/// The same where sph.advance takes the place of sph.forces and step.integrate.
constexpr std::uint64_t advancing_barriers = usual_barriers | stage_bit(stage_sph_forces);
/// The same for scenes that liquid cannot leave, in which sph.advance changes no channel that probes read: it writes the new state
/// elsewhere. What a probe reads in a sub-step that halts does not count.
constexpr std::uint64_t probing_barriers = advancing_barriers | stage_bit(stage_sampling_probes);
constexpr bool is_barrier(int stage, std::uint64_t barriers = usual_barriers) {
  return stage != stage_sampling_probes && (stage_bit(stage) & barriers) != 0;
}

/// Channels of recorded custom stages, by the built-in stage that each joins: it runs right after that stage, on its track.
struct Joined {
  std::array<FieldSet, stage_count> reads{}, writes{};
};

constexpr bool in_order(int first, int second, std::uint64_t barriers = usual_barriers,
                        const Joined* joined = nullptr) {
  if (first == stage_sampling_probes && (barriers & stage_bit(stage_sampling_probes)) != 0)
    return second != stage_sph_forces && second != stage_step_integrate;
  const StageInfo &a = stage_table[static_cast<std::size_t>(first)],
                  &b = stage_table[static_cast<std::size_t>(second)];
  FieldSet a_reads = a.reads_apart, a_writes = a.writes_apart, b_reads = b.reads_apart,
           b_writes = b.writes_apart;
  if (joined != nullptr) {
    a_reads |= joined->reads[static_cast<std::size_t>(first)];
    a_writes |= joined->writes[static_cast<std::size_t>(first)];
    b_reads |= joined->reads[static_cast<std::size_t>(second)];
    b_writes |= joined->writes[static_cast<std::size_t>(second)];
  }
  return is_barrier(first, barriers) || is_barrier(second, barriers) ||
         (a_writes & (b_reads | b_writes)) != 0 || (a_reads & b_writes) != 0;
}

/// Chooses low-occupancy launches and priorities.
constexpr void rank(Schedule& r, std::uint64_t running, std::uint64_t barriers, const Joined* joined) {
  for (int s = stage_count; s-- > 0;) {
    if (((running >> s) & 1u) == 0) continue;
    for (int t = 0; t < stage_count; ++t)
      if ((stage_bit(s) & modest_stages) != 0 && (stage_bit(t) & running & sum_stages) != 0 &&
          !in_order(s, t, barriers, joined))
        r.aside |= stage_bit(s);
    int urgency = 0;
    for (int t = s + 1; t < stage_count && !is_barrier(t, barriers); ++t) {
      if (((running >> t) & 1u) == 0 || !in_order(s, t, barriers, joined)) continue;
      const int behind = r.urgency[static_cast<std::size_t>(t)];
      urgency = std::max(urgency, t == stage_sph_density ? 3 : std::max(behind, 1));
    }
    if ((stage_bit(s) & r.aside) != 0) urgency = 2;
    if (s == stage_lsm_contact) urgency = 0;
    r.urgency[static_cast<std::size_t>(s)] = static_cast<std::int8_t>(urgency);
  }
}

/// Tracks while stages are laid on them one after the other.
struct Tracks {
  std::array<std::uint64_t, stage_count> before{};  ///< stages that have ended when a stage begins
  std::array<int, most_tracks> end{};               ///< last stage of a track
  int count = 0;

  constexpr int end_of(int track) const { return end[static_cast<std::size_t>(track)]; }
  constexpr std::uint64_t before_of(int stage) const { return before[static_cast<std::size_t>(stage)]; }
};

/// The track of stage s, which has to wait for those in `direct`: behind one of them; else a new one; else the one that has
/// been idle longest.
constexpr int choose_track(Tracks& tracks, int s, std::uint64_t direct, std::uint64_t barriers) {
  int track = -1;
  for (int k = 0; k < tracks.count && track < 0; ++k)
    if (((direct >> tracks.end_of(k)) & 1u) != 0) track = k;
  if (is_barrier(s, barriers) && tracks.count != 0) track = 0;
  if (s == stage_sampling_probes && (barriers & stage_bit(s)) != 0 && tracks.count != 0)
    track = -1;  // not in the way
  if (track >= 0) return track;
  if (tracks.count < most_tracks) return tracks.count++;
  track = 1;
  for (int k = 2; k < tracks.count; ++k)
    if (tracks.end_of(k) < tracks.end_of(track)) track = k;
  return track;
}

/// Which of `direct` stage s waits for: one that another wait or the same track already covers needs no wait of its own.
constexpr std::uint64_t waits_of(const Schedule& r, const Tracks& tracks, int s, int track,
                                 std::uint64_t direct) {
  std::uint64_t waits = 0;
  for (int t = s - 1; t >= 0; --t) {
    const std::uint64_t bit = std::uint64_t{1} << t;
    if ((direct & bit) == 0) continue;
    bool known = r.track[static_cast<std::size_t>(t)] == track;
    for (int u = t + 1; u < s; ++u) known = known || ((direct >> u) & 1u && (tracks.before_of(u) & bit));
    if (!known) waits |= bit;
  }
  return waits;
}

/// The schedule of the stages in `running` (bit per stage).
constexpr Schedule make_schedule(std::uint64_t running, std::uint64_t barriers = usual_barriers,
                                 const Joined* joined = nullptr) {
  Schedule r;
  Tracks tracks;
  for (int s = 0; s < stage_count; ++s) {
    const auto at = static_cast<std::size_t>(s);
    r.track[at] = -1;
    if (((running >> s) & 1u) == 0) continue;
    std::uint64_t direct = 0;
    for (int t = 0; t < s; ++t)
      if (((running >> t) & 1u) != 0 && in_order(t, s, barriers, joined)) {
        direct |= std::uint64_t{1} << t;
        tracks.before[at] |= (std::uint64_t{1} << t) | tracks.before_of(t);
      }
    const int track = choose_track(tracks, s, direct, barriers);
    r.waits[at] = waits_of(r, tracks, s, track, direct);
    r.track[at] = static_cast<std::int8_t>(track);
    r.awaited |= r.waits[at];
    int& end = tracks.end[static_cast<std::size_t>(track)];
    if (end != 0) tracks.before[at] |= (std::uint64_t{1} << end) | tracks.before_of(end);
    end = s;
  }
  rank(r, running, barriers, joined);
  for (int k = 1; k < tracks.count; ++k) r.last |= std::uint64_t{1} << tracks.end_of(k);
  r.awaited |= r.last;
  return r;
}

/// The order in which stages are enqueued: the table's, or, where an executor has one of its own (tests
/// have), any that the schedule allows.
template <class E, class = void>
struct EnqueueOrder {
  static std::array<int, stage_count> of(E&, const Schedule&) {
    std::array<int, stage_count> order{};
    for (int s = 0; s < stage_count; ++s) order[static_cast<std::size_t>(s)] = s;
    return order;
  }
};
template <class E>
struct EnqueueOrder<E, std::void_t<decltype(std::declval<E&>().stage_order(Schedule{}))>> {
  static std::array<int, stage_count> of(E& ex, const Schedule& plan) { return ex.stage_order(plan); }
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
