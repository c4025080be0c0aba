// SPDX-License-Identifier: Apache-2.0
// Checked builds (MELTSIM_CHECKED=ON): after every stage the engine waits and looks at what the stage wrote.
// For finding where something goes wrong; far too slow for anything else.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "engine/text.hpp"
#include "frame/frame.hpp"
#include "pipeline/pipeline.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

#if defined(MELTSIM_CHECKED)
constexpr bool checked_build = true;  // of a file: tests have engines of both kinds
#else
constexpr bool checked_build = false;
#endif

inline bool all_finite(float v) { return std::isfinite(v); }
inline bool all_finite(double v) { return std::isfinite(v); }
template <class T>
bool all_finite(const Vec3<T>& v) {
  return finite(v);
}
template <class T>
bool all_finite(const Vec4<T>& v) {
  return finite(xyz(v)) && std::isfinite(v.w);
}
template <class T>
bool all_finite(const HeatOperand<T>& v) {
  return std::isfinite(v.temperature) && !std::isnan(v.resistivity);  // infinite: insulates
}
template <class V>
bool all_finite(const V&) {
  return true;  // integers and tables
}

/// Copies of what the invariants need; fetch(pointer, count) copies from the backend.
template <class T, class Fetch>
class Invariants {
 public:
  Invariants(const Frame<T>& w, const Fetch& fetch) : w_(w), fetch_(fetch) {}

  double account_before = 0;  ///< heat_account->step before the stage [J]

  /// Empty, or the invariant broken after stage s. `mass` is the sum at the upload, `thermal` that before the stage.
  std::string after(int s, double mass, double thermal) const {
    std::string wrong = written_values(stage_table[static_cast<std::size_t>(s)].writes);
    if (wrong.empty() && (s == stage_spatial_reorder || s == stage_spatial_settle)) wrong = order(mass);
    if (wrong.empty() && s == stage_thermal_exchange) wrong = heat(thermal);
    if (wrong.empty() && s == stage_topology_neighbours) wrong = surface_flags();
    if (wrong.empty() && s == stage_step_integrate) wrong = inside_walls();
    return wrong.empty()
               ? wrong
               : text("checked build: after ", stage_table[static_cast<std::size_t>(s)].name, ": ", wrong);
  }

  /// Sum of enthalpy [J].
  double thermal() const {
    double sum = 0;
    for (const double h : fetch_(w_.f.enthalpy, w_.particles)) sum += h;
    return sum;
  }

  /// Sum of mass in order of id: the same bits whatever the order in memory [kg].
  double mass() const {
    const auto m = fetch_(w_.f.mass, w_.particles);
    const auto id = fetch_(w_.f.id, w_.particles);
    std::vector<double> by_id(m.size());
    for (std::size_t i = 0; i < m.size(); ++i)
      if (id[i] < w_.born) by_id[id[i]] = static_cast<double>(m[i]);
    double sum = 0;
    for (const double v : by_id) sum += v;
    return sum;
  }

 private:
  /// Every float that the stage wrote for a live particle or vertex is finite.
  std::string written_values(FieldSet writes) const {
    std::string wrong;
    const auto look = [&](int field, const auto* data) {
      if (!writes.has(field) || data == nullptr || !wrong.empty()) return;
      const auto& info = field_table[static_cast<std::size_t>(field)];
      const bool particle = info.owner == Owner::particle;
      if (!particle && info.owner != Owner::vertex) return;
      const auto values = fetch_(data, particle ? w_.particles : w_.vertices);
      for (std::size_t i = 0; i < values.size(); ++i)
        if (!all_finite(values[i])) {
          wrong = text("channel ", info.name, " is not finite at ", particle ? "slot " : "vertex ",
                       static_cast<std::uint64_t>(i));
          return;
        }
    };
#define MELTSIM_FIELD(name, type, owner, lifetime, unit, doc) look(field_##name, w_.f.name);
#include "meltsim/fields.def"
#undef MELTSIM_FIELD
    return wrong;
  }

  std::string order(double expected) const {
    const auto id = fetch_(w_.f.id, w_.particles);
    const auto slot = fetch_(w_.f.slot_of_id, w_.particles);
    const auto tag = fetch_(w_.f.tag, w_.particles);
    for (std::size_t i = 0; i < id.size(); ++i)
      if (id[i] >= slot.size() || (slot[id[i]] != i && core::slot_is_known(w_, tag[i])))
        return text("slot_of_id is not the inverse of id at slot ", static_cast<std::uint64_t>(i));
    const double now = mass();
    // Emitted particles add to it.
    return now < expected ? text("mass fell from ", expected, " to ", now, " kg") : std::string();
  }

  std::string heat(double before) const {
    double in = 0, scale = 0;
    if (w_.f.heat_account != nullptr) in = fetch_(w_.f.heat_account, 1).front().step - account_before;
    for (const double h : fetch_(w_.f.enthalpy, w_.particles)) scale += std::fabs(h);
    const double now = thermal();
    // Double sums of n terms; what came from outside is summed apart.
    return std::fabs(now - before - in) > 1e-10 * scale
               ? text("enthalpy changed by ", now - before, " J while ", in, " J came in")
               : std::string();
  }

  /// SBP = fewer than 27 live direct neighbours.
  std::string surface_flags() const {
    const auto mask = fetch_(w_.f.neighbour_mask, w_.vertices);
    const auto state = fetch_(w_.f.vertex_state, w_.vertices);
    const auto id = fetch_(w_.f.vertex_id, w_.vertices);
    const auto slot = fetch_(w_.f.slot_of_id, w_.particles);
    const auto tag = fetch_(w_.f.tag, w_.particles);
    for (std::size_t v = 0; v < mask.size(); ++v) {
      if (state[v] != vertex_live) continue;
      const bool surface = (tag[slot[id[v]]] & tag_surface) != 0u;
      if (surface != (popcount(mask[v]) < 27))
        return text("surface flag and neighbours disagree at vertex ", static_cast<std::uint64_t>(v));
    }
    return {};
  }

  std::string inside_walls() const {
    const auto position = fetch_(w_.f.position, w_.particles);
    const auto tag = fetch_(w_.f.tag, w_.particles);
    for (std::size_t i = 0; i < position.size(); ++i) {
      if (is_removed(tag[i])) continue;
      const physics::FaceDistances<T> d = physics::face_distances(w_.c.walls, xyz(position[i]));
      for (int face = 0; face < 6; ++face)
        if (((w_.c.walls.faces >> face) & 1u) != 0u && d[face] < T(0))
          return text("slot ", static_cast<std::uint64_t>(i), " is outside a wall");
    }
    return {};
  }

  const Frame<T>& w_;
  const Fetch& fetch_;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
