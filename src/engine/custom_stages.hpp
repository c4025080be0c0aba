// SPDX-License-Identifier: Apache-2.0
// Custom stages: which of them allow a sub-step to be recorded, where those run, and which fusions they rule out.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "engine/engine.hpp"
#include "pipeline/schedule.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Behind no built-in stage: it runs right after step.begin, before all tracks.
inline constexpr int before_tracks = -1;

class CustomStages {
 public:
  void set(const std::vector<PlacedStage>* stages) {
    stages_ = stages;
    ++generation_;
  }
  /// Differs whenever stages were added or removed.
  std::uint64_t generation() const { return generation_; }
  std::size_t count() const { return stages_ == nullptr ? 0 : stages_->size(); }
  const PlacedStage& operator[](std::size_t k) const { return (*stages_)[k]; }

  bool all_recorded() const {
    return !any([](const PlacedStage& c) { return !c.stage.recorded; });
  }
  bool any_recorded() const {
    return any([](const PlacedStage& c) { return c.stage.recorded; });
  }

  /// Whether a custom stage changes positions or velocities. Integration then cannot count the cells of the next search.
  bool move_particles() const {
    constexpr FieldSet places = FieldSet{1} << field_position | FieldSet{1} << field_velocity |
                                FieldSet{1} << field_tag | FieldSet{1} << field_id;
    return any([places](const PlacedStage& c) { return (c.writes & places) != 0; });
  }

  /// Whether sph.advance may take the place of forces and integration: it reads the state that the sub-step began with, leaves
  /// it as it is and ends the sub-step. So the host's stages only read, and come before.
  bool allow_advance(std::uint64_t running) const {
    for (std::size_t k = 0; k < count(); ++k) {
      const int at = seat(k, running);
      if ((*this)[k].writes != 0 || at >= stage_sph_forces || at == stage_sampling_probes) return false;
    }
    return true;
  }

  /// The last stage that runs up to the one that stage k was placed behind, but step.begin, or before_tracks.
  int seat(std::size_t k, std::uint64_t running) const {
    for (int s = (*this)[k].after; s > stage_step_begin; --s)
      if (((running >> s) & 1u) != 0) return s;
    return before_tracks;
  }

  Joined joined(std::uint64_t running) const {
    Joined j;
    for (std::size_t k = 0; k < count(); ++k)
      if (const int at = seat(k, running); at != before_tracks) {
        j.reads[static_cast<std::size_t>(at)] |= (*this)[k].reads;
        j.writes[static_cast<std::size_t>(at)] |= (*this)[k].writes;
      }
    return j;
  }

 private:
  template <class Test>
  bool any(const Test& test) const {
    return stages_ != nullptr && std::any_of(stages_->begin(), stages_->end(), test);
  }

  const std::vector<PlacedStage>* stages_ = nullptr;
  std::uint64_t generation_ = 0;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
