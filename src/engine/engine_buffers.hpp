// SPDX-License-Identifier: Apache-2.0
// The memory of a World, and which buffer holds which channel.
#pragma once

#include <cstdint>
#include <utility>

#include "engine/engine_sizes.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Two buffers of every channel of the state, one of every other. Which of the two holds the state is turned over in every
/// sub-step.
template <class E, class T>
class EngineBuffers {
 public:
  /// False: memory is insufficient, and nothing is allocated.
  bool allocate(E& ex, FieldSet channels, const Sizes& n) {
    for (int i = 0; i < field_count; ++i) {
      if (!channels.has(i)) continue;
      const std::uint64_t bytes = field_bytes<T>(i, n);
      if (bytes == 0) continue;
      now_[i] = ex.allocate(bytes);
      if (now_[i] != nullptr) bytes_[i] = bytes;
      if (double_buffered(i)) before_[i] = ex.allocate(bytes);
      if (before_[i] != nullptr) bytes_before_[i] = bytes;
      if (now_[i] == nullptr || (double_buffered(i) && before_[i] == nullptr)) {
        release(ex);
        return false;
      }
      ex.zero(now_[i], bytes);
      if (before_[i] != nullptr) ex.zero(before_[i], bytes);
    }
    spare_position_ = n.spare_position;
    return true;
  }

  void release(E& ex) {
    for (int i = 0; i < field_count; ++i) give_back(ex, i);
  }

  /// Allocates those of `channels` that are missing or have another size; contents of channels that change size are lost.
  /// grown: these channels, all 0. Other channels stay. False: memory is insufficient, and nothing has changed.
  /// Waits.
  bool grow(E& ex, FieldSet channels, const Sizes& n, FieldSet& grown) {
    void* now[field_count] = {};
    void* before[field_count] = {};
    bool there = true;
    grown = 0;
    for (int i = 0; i < field_count && there; ++i) {
      const std::uint64_t bytes = field_bytes<T>(i, n);
      if (!channels.has(i) || bytes == bytes_[i] || bytes == 0) continue;
      now[i] = ex.allocate(bytes);
      if (double_buffered(i)) before[i] = ex.allocate(bytes);
      there = now[i] != nullptr && (!double_buffered(i) || before[i] != nullptr);
      grown |= FieldSet{1} << i;
    }
    for (int i = 0; i < field_count; ++i) {
      if (!grown.has(i)) continue;
      if (!there) {
        if (now[i] != nullptr) ex.release(now[i]);
        if (before[i] != nullptr) ex.release(before[i]);
        continue;
      }
      give_back(ex, i);
      const std::uint64_t bytes = field_bytes<T>(i, n);
      now_[i] = now[i];
      before_[i] = before[i];
      bytes_[i] = bytes;
      bytes_before_[i] = before[i] != nullptr ? bytes : 0;
      ex.zero(now_[i], bytes);
      if (before_[i] != nullptr) ex.zero(before_[i], bytes);
    }
    if (there) spare_position_ = n.spare_position;
    return there;
  }

  /// Bytes that grow() would allocate.
  std::uint64_t missing(FieldSet channels, const Sizes& n) const {
    std::uint64_t total = 0;
    for (int i = 0; i < field_count; ++i) {
      const std::uint64_t bytes = field_bytes<T>(i, n);
      if (channels.has(i) && bytes != bytes_[i]) total += bytes * (double_buffered(i) ? 2u : 1u);
    }
    return total;
  }

  /// Frees channels that are not in `channels` or hold no items. Waits.
  void shrink(E& ex, FieldSet channels, const Sizes& n) {
    for (int i = 0; i < field_count; ++i)
      if (bytes_[i] != 0 && (!channels.has(i) || field_bytes<T>(i, n) == 0)) give_back(ex, i);
  }

  std::uint64_t bytes(int field) const { return bytes_[field] + bytes_before_[field]; }

  /// Points a frame at the buffers; at those of these channels alone.
  void link(Frame<T>& w, FieldSet channels = ~FieldSet{0}) const {
    const auto buffer = [&](int i) { return channels.has(i) ? now_[i] : nullptr; };
#define MELTSIM_FIELD(name, type, owner, lifetime, unit, doc) \
  w.f.name = static_cast<type*>(buffer(field_##name));
#include "meltsim/fields.def"
#undef MELTSIM_FIELD
#define MELTSIM_MOVED(name, type) w.before.name = static_cast<type*>(before_[field_##name]);
#include "meltsim/fields.def"
  }

  /// Swaps the two buffers of the state.
  void turn(Frame<T>& w) {
    for (int i = 0; i < field_count; ++i)
      if (double_buffered(i)) std::swap(now_[i], before_[i]);
    link(w);
  }

  /// Where sph.advance puts the state: accelerations' buffer, where that has room for positions, and that of the old
  /// velocities.
  bool has_spare_position() const { return spare_position_; }
  NextViews<T> spare() const {
    return {static_cast<Vec4<T>*>(now_[field_acceleration]), static_cast<Vec4<T>*>(before_[field_velocity])};
  }
  /// After sph.advance: the buffer of the old positions becomes that of accelerations.
  void take_spare(Frame<T>& w) {
    void* const old = before_[field_position];
    before_[field_position] = now_[field_position];
    now_[field_position] = now_[field_acceleration];
    now_[field_acceleration] = old;
    std::swap(now_[field_velocity], before_[field_velocity]);
    link(w);
  }

  /// Size of a saved state [bytes].
  std::uint64_t saved_bytes() const {
    std::uint64_t total = 0;
    for (int i = 0; i < field_count; ++i)
      if (is_saved(i)) total += padded(bytes_[i]) + padded(bytes_before_[i]);
    return total;
  }
  /// Enqueues a copy of all channels that outlast a sub-step. Both buffers of the state are copied, because slots for emitters are prepared in each.
  void save(E& ex, unsigned char* to) const {
    each_saved(
        [&](void* buffer, std::uint64_t bytes, std::uint64_t at) { copy(ex, bytes, buffer, to + at); });
  }
  void load(E& ex, const unsigned char* from) const {
    each_saved(
        [&](void* buffer, std::uint64_t bytes, std::uint64_t at) { copy(ex, bytes, from + at, buffer); });
  }

  /// Goes back to the state at the beginning of the halted sub-step. Later sub-steps have swapped buffers and done nothing
  /// else. Where sph.advance made it, velocities are there in the new order only: those before, whose order ids before
  /// say.
  void go_back(Frame<T>& w, const WorldStatus& s) {
    const auto is = [](const void* buffer, std::uint64_t address) {
      return reinterpret_cast<std::uintptr_t>(buffer) == address;
    };
    if (spare_position_ && is(now_[field_acceleration], s.halt_position))
      std::swap(now_[field_acceleration], before_[field_position]);
    if (!is(now_[field_position], s.halt_position)) std::swap(now_[field_position], before_[field_position]);
    if (is(now_[field_velocity], s.halt_velocity) != (s.halt_advanced == 0))
      std::swap(now_[field_velocity], before_[field_velocity]);
    if (!is(now_[field_id], s.halt_id))
      for (int i = 0; i < field_count; ++i)
        if (double_buffered(i) && i != field_position && i != field_velocity) std::swap(now_[i], before_[i]);
    link(w);
  }

 private:
  /// All channels except those that every sub-step recomputes and nothing reads after it, and settings that the host changes in place: these are
  /// the World's, wherever its state goes back to.
  static bool is_saved(int i) {
    const bool setting = i == field_force_fields || i == field_heat_regions || i == field_body_heat;
    return !setting && i != field_neighbour_words && i != field_sort_key && i != field_sort_key_alt &&
           i != field_sort_slot && i != field_sort_slot_alt;
  }
  static std::uint64_t padded(std::uint64_t bytes) { return (bytes + 255) / 256 * 256; }
  template <class Visit>
  void each_saved(const Visit& visit) const {
    std::uint64_t at = 0;
    for (int i = 0; i < field_count; ++i) {
      if (!is_saved(i)) continue;
      if (bytes_[i] != 0) visit(now_[i], bytes_[i], at);
      at += padded(bytes_[i]);
      if (bytes_before_[i] != 0) visit(before_[i], bytes_before_[i], at);
      at += padded(bytes_before_[i]);
    }
  }
  static void copy(E& ex, std::uint64_t bytes, const void* from, void* to) {
    ex.copy(bytes / sizeof(std::uint32_t), static_cast<const std::uint32_t*>(from),
            static_cast<std::uint32_t*>(to));
  }

  void give_back(E& ex, int i) {
    if (now_[i] != nullptr) ex.release(now_[i]);
    if (before_[i] != nullptr) ex.release(before_[i]);
    now_[i] = before_[i] = nullptr;
    bytes_[i] = bytes_before_[i] = 0;
  }

  void* now_[field_count] = {};
  void* before_[field_count] = {};
  std::uint64_t bytes_[field_count] = {}, bytes_before_[field_count] = {};
  bool spare_position_ = false;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
