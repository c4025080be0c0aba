// SPDX-License-Identifier: Apache-2.0
// Declarations of every stage, made from the stage table. Definitions: src/<module>/stages.hpp; instantiated
// once per executor and scalar in src/<module>/<module>_cpu.cpp and cuda/<module>/<module>.cu.
#pragma once

#include "frame/edit_rows.hpp"
#include "frame/frame.hpp"
#include "frame/ray_rows.hpp"
#include "frame/steered.hpp"

namespace meltsim {
inline namespace v0 {

#define MELTSIM_STAGE(module, stage, need, reads, writes, may, why, why_not) \
  namespace module {                                                         \
  template <class E, class T>                                                \
  void stage(E& ex, const core::Frame<T>& w);                                \
  }
#include "pipeline/pipeline.def"
#undef MELTSIM_STAGE

// Not stages: called when the scene changes, when a layer is due, on a call of the host, after a roll-back.
namespace step {
template <class E, class T>
void steer(E& ex, const core::Frame<T>& w, const core::Steered* steered, std::uint32_t n);
template <class E, class T>
void set_off(E& ex, const core::Frame<T>& w, double time, bool places);
template <class E, class T>
void respeed(E& ex, const core::Frame<T>& w, Vec3<double> from, Vec3<double> to);
template <class E, class T>
void shift(E& ex, const core::Frame<T>& w, Vec3<double> velocity, Vec3<double> begin, double length,
           double reach, Vec3<double> by);
template <class E, class T>
void count_in_box(E& ex, const core::Frame<T>& w, const core::FoundBox& box, std::uint64_t ranges,
                  std::uint32_t* counts);
template <class E, class T>
void list_in_box(E& ex, const core::Frame<T>& w, const core::FoundBox& box, std::uint64_t ranges,
                 const std::uint32_t* counts, core::FoundParticle* list);
template <class E, class T>
void append(E& ex, const core::Frame<T>& w, const core::PreviousViews<T>& from, std::uint32_t first,
            std::uint32_t vertex, std::uint64_t n);
template <class E, class T>
void take_out(E& ex, const core::Frame<T>& w, const core::FoundParticle* list, std::uint64_t n);
template <class E, class T>
void move(E& ex, const core::Frame<T>& w, const core::FoundParticle* list, std::uint64_t n);
template <class E, class T>
void take_body(E& ex, const core::Frame<T>& w, std::uint32_t body, std::uint32_t first, std::uint32_t count,
               core::TakenSum* sum);
template <class E, class T>
void list_body(E& ex, const core::Frame<T>& w, std::uint32_t body, std::uint32_t first, std::uint32_t count,
               core::FoundParticle* list);
template <class E, class T>
void hold(E& ex, const core::Frame<T>& w, const core::FoundParticle* list, std::uint64_t n, bool on,
          std::uint32_t first, std::uint32_t count);
template <class E, class T>
void push(E& ex, const core::Frame<T>& w, const core::PushArguments& a);
template <class E, class T>
void set_heat_region(E& ex, const core::Frame<T>& w, std::uint32_t row, bool held, double temperature,
                     double source);
template <class E, class T>
void set_body_heat(E& ex, const core::Frame<T>& w, std::uint32_t body, const core::BodyHeat<T>& heat);
template <class E, class T>
void move_heat_region(E& ex, const core::Frame<T>& w, std::uint32_t row, double since,
                      Vec3<double> displacement, Vec3<double> velocity);
template <class E, class T>
void set_force_field(E& ex, const core::Frame<T>& w, std::uint32_t row, const physics::ForceField<T>& field,
                     std::uint32_t count);
template <class E, class T>
void set_inlet(E& ex, const core::Frame<T>& w, std::uint32_t row, const core::Inlet<T>& now);
template <class E, class T>
void set_sound_speed(E& ex, const core::Frame<T>& w, std::uint32_t materials, double speed, double change,
                     core::SoundWork* sum, core::SoundWork* account);
template <class E, class T>
void look(E& ex, const core::Frame<T>& w, bool sized, core::SoundLook* to);
template <class E, class T>
void loaded(E& ex, const core::Frame<T>& w, const std::uint32_t* missing, std::uint64_t step);
template <class E, class T>
void emit(E& ex, const core::Frame<T>& w);
template <class E, class T>
void let_go(E& ex, const core::Frame<T>& w);
template <class E, class T>
void begin_cells(E& ex, const core::Frame<T>& w);
template <class E, class T>
void clear(E& ex, const core::Frame<T>& w);
template <class E, class T>
void give_up(E& ex, const core::Frame<T>& w);
template <class E, class T>
void restore(E& ex, const core::Frame<T>& w);
template <class E, class T>
void reindex(E& ex, const core::Frame<T>& w);
template <class E, class T>
void enthalpy_to_slots(E& ex, const core::Frame<T>& w);
template <class E, class T>
void enthalpy_to_ids(E& ex, const core::Frame<T>& w);
}  // namespace step
namespace sph {
template <class E, class T>
void advance(E& ex, const core::Frame<T>& w);
}
namespace topology {
template <class E, class T>
void build(E& ex, const core::Frame<T>& w);
template <class E, class T>
void build_body(E& ex, const core::Frame<T>& w, std::uint32_t first, std::uint32_t count);
}  // namespace topology

namespace sampling {
template <class E, class T>
void at_once(E& ex, const core::Frame<T>& w, const core::SampleRoom& room);
template <class E, class T>
void follow_rays(E& ex, const core::Frame<T>& w, const core::SampleRoom& room, const core::RayRoom& rays);
}  // namespace sampling

namespace core {
template <class T>
struct SurfaceFrame;
}
namespace surface {
/// Between sub-steps; w as engine/surface_run.hpp fills it.
template <class E, class T>
void build(E& ex, const core::SurfaceFrame<T>& w, int smoothing);
}  // namespace surface

namespace core {
template <class T>
struct ReadingFrame;
}
/// Between sub-steps; w as engine/reading_run.hpp fills it.
namespace reading {
template <class E, class T>
void status(E& ex, const core::ReadingFrame<T>& w);
template <class E, class T>
void sums(E& ex, const core::ReadingFrame<T>& w);
template <class E, class T>
void count_pieces(E& ex, const core::ReadingFrame<T>& w);
template <class E, class T>
void pieces(E& ex, const core::ReadingFrame<T>& w);
template <class E, class T>
void pack(E& ex, const core::ReadingFrame<T>& w);
template <class E, class T>
void records(E& ex, const core::ReadingFrame<T>& w);
}  // namespace reading

namespace core {

template <class E, class T>
using StageFunction = void (*)(E&, const Frame<T>&);

/// In the order of the stage table.
template <class E, class T>
inline constexpr StageFunction<E, T> stage_functions[] = {
#define MELTSIM_STAGE(module, stage, need, reads, writes, may, why, why_not) &module::stage<E, T>,
#include "pipeline/pipeline.def"
#undef MELTSIM_STAGE
};

}  // namespace core

/// Explicit instantiation of one stage of the enclosing module for both scalars.
#define MELTSIM_INSTANTIATE(Exec, stage)                              \
  template void stage<Exec, float>(Exec&, const core::Frame<float>&); \
  template void stage<Exec, double>(Exec&, const core::Frame<double>&);

/// What steers a World between sub-steps, likewise.
#define MELTSIM_INSTANTIATE_STEERING(Exec)     \
  MELTSIM_INSTANTIATE_STEERING_OF(Exec, float) \
  MELTSIM_INSTANTIATE_STEERING_OF(Exec, double)
#define MELTSIM_INSTANTIATE_STEERING_OF(Exec, T)                                                             \
  template void steer<Exec, T>(Exec&, const core::Frame<T>&, const core::Steered*, std::uint32_t);           \
  template void set_off<Exec, T>(Exec&, const core::Frame<T>&, double, bool);                                \
  template void loaded<Exec, T>(Exec&, const core::Frame<T>&, const std::uint32_t*, std::uint64_t);          \
  template void push<Exec, T>(Exec&, const core::Frame<T>&, const core::PushArguments&);                     \
  template void set_heat_region<Exec, T>(Exec&, const core::Frame<T>&, std::uint32_t, bool, double, double); \
  template void set_body_heat<Exec, T>(Exec&, const core::Frame<T>&, std::uint32_t,                          \
                                       const core::BodyHeat<T>&);                                            \
  template void move_heat_region<Exec, T>(Exec&, const core::Frame<T>&, std::uint32_t, double, Vec3<double>, \
                                          Vec3<double>);                                                     \
  template void set_force_field<Exec, T>(Exec&, const core::Frame<T>&, std::uint32_t,                        \
                                         const physics::ForceField<T>&, std::uint32_t);                      \
  template void set_inlet<Exec, T>(Exec&, const core::Frame<T>&, std::uint32_t, const core::Inlet<T>&);      \
  template void shift<Exec, T>(Exec&, const core::Frame<T>&, Vec3<double>, Vec3<double>, double, double,     \
                               Vec3<double>);                                                                \
  template void set_sound_speed<Exec, T>(Exec&, const core::Frame<T>&, std::uint32_t, double, double,        \
                                         core::SoundWork*, core::SoundWork*);                                \
  template void look<Exec, T>(Exec&, const core::Frame<T>&, bool, core::SoundLook*);                         \
  template void respeed<Exec, T>(Exec&, const core::Frame<T>&, Vec3<double>, Vec3<double>);

/// What edits between sub-steps enqueue, likewise.
#define MELTSIM_INSTANTIATE_EDITS(Exec)     \
  MELTSIM_INSTANTIATE_EDITS_OF(Exec, float) \
  MELTSIM_INSTANTIATE_EDITS_OF(Exec, double)
#define MELTSIM_INSTANTIATE_EDITS_OF(Exec, T)                                                                \
  template void count_in_box<Exec, T>(Exec&, const core::Frame<T>&, const core::FoundBox&, std::uint64_t,    \
                                      std::uint32_t*);                                                       \
  template void list_in_box<Exec, T>(Exec&, const core::Frame<T>&, const core::FoundBox&, std::uint64_t,     \
                                     const std::uint32_t*, core::FoundParticle*);                            \
  template void append<Exec, T>(Exec&, const core::Frame<T>&, const core::PreviousViews<T>&, std::uint32_t,  \
                                std::uint32_t, std::uint64_t);                                               \
  template void take_out<Exec, T>(Exec&, const core::Frame<T>&, const core::FoundParticle*, std::uint64_t);  \
  template void move<Exec, T>(Exec&, const core::Frame<T>&, const core::FoundParticle*, std::uint64_t);      \
  template void take_body<Exec, T>(Exec&, const core::Frame<T>&, std::uint32_t, std::uint32_t,               \
                                   std::uint32_t, core::TakenSum*);                                          \
  template void list_body<Exec, T>(Exec&, const core::Frame<T>&, std::uint32_t, std::uint32_t,               \
                                   std::uint32_t, core::FoundParticle*);                                     \
  template void hold<Exec, T>(Exec&, const core::Frame<T>&, const core::FoundParticle*, std::uint64_t, bool, \
                              std::uint32_t, std::uint32_t);

#define MELTSIM_INSTANTIATE_BUILD_BODY(Exec)                                                             \
  template void build_body<Exec, float>(Exec&, const core::Frame<float>&, std::uint32_t, std::uint32_t); \
  template void build_body<Exec, double>(Exec&, const core::Frame<double>&, std::uint32_t, std::uint32_t);

/// All that a reading enqueues, likewise.
#define MELTSIM_INSTANTIATE_READING(Exec)             \
  MELTSIM_INSTANTIATE_FOR_READING(Exec, status)       \
  MELTSIM_INSTANTIATE_FOR_READING(Exec, sums)         \
  MELTSIM_INSTANTIATE_FOR_READING(Exec, count_pieces) \
  MELTSIM_INSTANTIATE_FOR_READING(Exec, pieces)       \
  MELTSIM_INSTANTIATE_FOR_READING(Exec, records)      \
  MELTSIM_INSTANTIATE_FOR_READING(Exec, pack)
#define MELTSIM_INSTANTIATE_FOR_READING(Exec, part)                         \
  template void part<Exec, float>(Exec&, const core::ReadingFrame<float>&); \
  template void part<Exec, double>(Exec&, const core::ReadingFrame<double>&);

}  // namespace v0
}  // namespace meltsim
