// SPDX-License-Identifier: Apache-2.0
// Kernels of heat. Every particle, liquid or solid, exchanges with every neighbour.
#pragma once

#include "core/frame.hpp"
#include "meltsim/physics/heat.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace thermal {

using core::Frame;
using core::HeatOperand;
using physics::MaterialRow;

/// Temperature and conductivity at an enthalpy [J].
template <class T>
MELTSIM_HD HeatOperand<T> operand_at(const MaterialRow<T>& m, double enthalpy, T mass) {
  const double h = enthalpy / static_cast<double>(mass);
  const T temperature = static_cast<T>(physics::temperature_of(m, h));
  return {temperature,
          physics::conductivity_at(m, static_cast<T>(physics::liquid_fraction(m, h)), temperature)};
}

template <class T>
struct OperandsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    w.f.heat_operand[i] = operand_at(w.f.materials[material_of(w.f.tag[i])], w.f.enthalpy[i], w.f.mass[i]);
  }
};

/// Stage j of a super-step: d_j from d_{j-1}, d_{j-2} and the exchange at stage j-1.
template <class T>
struct StageBody {
  Frame<T> w;
  T mu, nu, mu_tau, gamma_tau;
  bool first;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t i, const Add& add) const {
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag)) {
      w.f.heat_increment_old[i] = T(0);
      w.f.heat_operand_next[i] = w.f.heat_operand[i];
      return;
    }
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const HeatOperand<T> own = w.f.heat_operand[i];
    const T volume = w.f.position[i].w, mass = w.f.mass[i];
    T rate = 0, conductance = 0;
    spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>&, T r2) {
      const HeatOperand<T> other = w.f.heat_operand[j];
      const T g =
          physics::pair_conductance(volume, xj.w, physics::kernel_laplacian(w.c.kernel, std::sqrt(r2), r2),
                                    own.conductivity, other.conductivity);
      rate += g * (other.temperature - own.temperature);
      conductance += g;
    });
    T d = mu_tau * rate;
    if (first) {
      w.f.heat_rate0[i] = rate;
      const double capacity = static_cast<double>(mass) * minimum(m.heat_capacity, m.liquid_heat_capacity);
      if (static_cast<double>(conductance) > w.c.heat_bound * capacity)
        add(&w.f.status->heat_bound_exceeded, 1);
    } else {
      d += mu * w.f.heat_increment[i] + nu * w.f.heat_increment_old[i] + gamma_tau * w.f.heat_rate0[i];
    }
    w.f.heat_increment_old[i] = d;
    w.f.heat_operand_next[i] = operand_at(m, w.f.enthalpy[i] + static_cast<double>(d), mass);
  }
};

/// Takes the super-step's increment into the state.
template <class T>
struct CommitBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    w.f.enthalpy[i] += static_cast<double>(w.f.heat_increment[i]);
  }
};

/// One sweep of eq. (4): T_i runs along the neighbours, T_j stays as it was before the sweep.
template <class T, bool Reversed>
struct PaperBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag)) {
      w.f.heat_operand_next[i] = w.f.heat_operand[i];
      return;
    }
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const HeatOperand<T> own = w.f.heat_operand[i];
    const T volume = w.f.position[i].w, mass = w.f.mass[i], half = T(0.5) * w.heat_dt;
    T change = 0;
    const auto visit = [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>&, T r2) {
      const HeatOperand<T> other = w.f.heat_operand[j];
      change += physics::paper_pair_update(m.diffusivity, w.f.materials[material_of(w.f.tag[j])].diffusivity,
                                           physics::kernel_laplacian(w.c.kernel, std::sqrt(r2), r2), half,
                                           volume, xj.w, own.temperature + change, other.temperature);
    };
    if (Reversed) spatial::for_each_neighbour_reversed(w, i, visit);
    else spatial::for_each_neighbour(w, i, visit);
    const double before = physics::temperature_of(m, w.f.enthalpy[i] / static_cast<double>(mass));
    if (change != T(0))  // a step that changes nothing changes no bit
      w.f.enthalpy[i] =
          static_cast<double>(mass) * physics::enthalpy_of(m, before + static_cast<double>(change));
    w.f.heat_operand_next[i] = operand_at(m, w.f.enthalpy[i], mass);
  }
};

}  // namespace thermal
}  // namespace v0
}  // namespace meltsim
