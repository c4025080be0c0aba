// SPDX-License-Identifier: Apache-2.0
// What the liquid's and the coupling's cases share: a World whose first error ends the case.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "constants.hpp"
#include "validation.hpp"

namespace validation {

using namespace meltsim;

/// A World that remembers the first thing that went wrong.
class Run {
 public:
  Run(const WorldDesc& desc, Report& report) : report_(report) {
    auto made = World::create(desc);
    if (made) world_ = std::make_unique<World>(std::move(*made));
    else report_.error = made.error().message;
  }
  MaterialId material(const std::string& name, double density, double viscosity) {
    MaterialDesc m;
    m.name = name;
    m.density = density;
    m.viscosity = viscosity;
    return material(m);
  }
  MaterialId material(const MaterialDesc& m) {
    return take([&] { return world_->add_material(m); });
  }
  BodyId solid(const SolidDesc& b) {
    return take([&] { return world_->add_solid(b); });
  }
  std::uint64_t fluid(const FluidDesc& f) {
    return take([&] { return world_->add_fluid(f); });
  }
  bool field(const ForceFieldDesc& f) {
    take([&] { return world_->add_force_field(f); });
    return good();
  }
  bool emitter(const EmitterDesc& e) {
    take([&] { return world_->add_emitter(e); });
    return good();
  }
  bool heat_region(const HeatRegionDesc& h) {
    take([&] { return world_->add_heat_region(h); });
    return good();
  }
  /// Of forces() from now on.
  bool watch(BodyId body) {
    if (good())
      if (Status s = world_->watch_forces(body); !s) report_.error = s.error().message;
    return good();
  }
  std::vector<BodyForces> forces() {
    return take([&] { return world_->take_forces(); });
  }
  std::uint64_t fluid(const Shape& shape, MaterialId material, Vec3d velocity = {},
                      const std::vector<MassFraction>& fractions = {}) {
    FluidDesc f;
    f.shape = shape;
    f.material = material;
    f.velocity = velocity;
    f.fractions = fractions;
    return take([&] { return world_->add_fluid(f); });
  }
  /// Liquid whose velocity depends on the place: cell by cell of the lattice, where `inside` says so.
  void field(const WorldDesc& d, Vec3i cells, MaterialId material,
             const std::function<bool(double, double)>& inside,
             const std::function<Vec3d(double, double)>& velocity) {
    for (int i = 0; i < cells.x; ++i)
      for (int j = 0; j < cells.y; ++j) {
        const Vec3d low = d.domain.min + Vec3d{i * d.spacing, j * d.spacing, 0};
        const double x = low.x + 0.5 * d.spacing, y = low.y + 0.5 * d.spacing;
        if (!inside(x, y)) continue;
        fluid(Shape::box(low, low + Vec3d{d.spacing, d.spacing, cells.z * d.spacing}), material,
              velocity(x, y));
      }
  }
  /// Steps to `time`, at most `dt` at once; false when it cannot.
  bool to(double time, double dt = infinity) {
    if (good())
      if (Status ready = world_->prepare(); !ready) report_.error = ready.error().message;
    while (good() && time_ < time * (1 - 1e-12)) {
      // A step may be split into 64 sub-steps; 50 leaves room for speeds that grow meanwhile.
      const double step = std::min({dt, time - time_, 50 * world_->stable_dt()});
      if (Status s = world_->step(step); !s) report_.error = s.error().message;
      time_ += step;
    }
    if (!good()) return false;
    last_ = world_->synchronize();
    if (last_.halted) report_.error = last_.halt_reason;
    return good();
  }
  BodyId solid(const std::string& name, const Shape& shape, MaterialId material, Vec3d velocity = {},
               bool fixed = false) {
    SolidDesc b;
    b.name = name;
    b.shape = shape;
    b.material = material;
    b.velocity = velocity;
    b.fixed = fixed;
    return take([&] { return world_->add_solid(b); });
  }
  ParticleData particles() {
    return take([&] { return world_->particles(); });
  }
  Ledger ledger() {
    return take([&] { return world_->ledger(); });
  }
  Totals totals() {
    return take([&] { return world_->totals(); });
  }
  SurfaceMesh surface(const SurfaceDesc& d) {
    return take([&] { return world_->surface(d); });
  }
  double stable_dt() { return good() && world_->prepare() ? world_->stable_dt() : 0; }
  const StepResult& last() const { return last_; }  ///< of the last to()
  bool good() const { return world_ && report_.error.empty(); }
  double time() const { return time_; }

 private:
  template <class Make>
  auto take(const Make& make) -> std::decay_t<decltype(*make())> {
    if (!good()) return {};
    auto result = make();
    if (result) return *result;
    report_.error = result.error().message;
    return {};
  }
  Report& report_;
  std::unique_ptr<World> world_;
  StepResult last_;
  double time_ = 0;
};

/// A box from 0 to `cells` spacings; faces in pairs per axis.
inline WorldDesc box(const Settings& s, double spacing, Vec3i cells, Face x, Face y, Face z) {
  WorldDesc d = world_desc(s);
  d.spacing = spacing;
  d.domain.bounded = true;
  d.domain.max = {cells.x * spacing, cells.y * spacing, cells.z * spacing};
  d.domain.faces = {x, x, y, y, z, z};
  return d;
}

}  // namespace validation
