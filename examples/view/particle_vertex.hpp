// SPDX-License-Identifier: Apache-2.0
// A particle as it is drawn, and how one is made of the World's state. Host and device.
#pragma once

#include <cstdint>

#include "meltsim/scheduler.hpp"
#include "temperature_table.hpp"

namespace view {

struct ParticleVertex {
  float x = 0, y = 0, z = 0;  ///< [m], relative to Resolved::origin
  float speed = 0;            ///< [m/s]
  float temperature = 0;      ///< [degrees Celsius]
  std::uint32_t tag = 0;      ///< meltsim/particle_tag.hpp; removed particles are not drawn
};
static_assert(sizeof(ParticleVertex) == 24, "the layout that particle_renderer.cpp declares");

/// Makes vertex i of the state's particle i. T: the state's precision.
template <class T>
struct VertexBody {
  const meltsim::Vec4<T>*position, *velocity;
  const double *enthalpy, *enthalpy_of_id;  ///< one of them
  const std::uint32_t *tag, *id;
  const SubstanceCurve* curves;
  ParticleVertex* to;

  VertexBody(const meltsim::StageContext& state, const SubstanceCurve* curves_there, ParticleVertex* vertices)
      : position(static_cast<const meltsim::Vec4<T>*>(state.position)),
        velocity(static_cast<const meltsim::Vec4<T>*>(state.velocity)),
        enthalpy(state.enthalpy),
        enthalpy_of_id(state.enthalpy_of_id),
        tag(state.tag),
        id(state.id),
        curves(curves_there),
        to(vertices) {}

  MELTSIM_HD void operator()(std::size_t i) const {
    const meltsim::Vec4<T> x = position[i];
    ParticleVertex v;
    v.x = static_cast<float>(x.x);
    v.y = static_cast<float>(x.y);
    v.z = static_cast<float>(x.z);
    v.speed = static_cast<float>(length(xyz(velocity[i])));
    v.tag = tag[i];
    const double h = enthalpy != nullptr ? enthalpy[i] : enthalpy_of_id[id[i]];
    v.temperature = static_cast<float>(particle_temperature(curves, v.tag, h, static_cast<double>(x.w)));
    to[i] = v;
  }
};

}  // namespace view
