// SPDX-License-Identifier: Apache-2.0
// The library's own engine over the test executor, and scenes made by hand.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/engine.hpp"
#include "frame/lattice.hpp"
#include "support/permuting_exec.hpp"
#include "support/random.hpp"

namespace modules_test {

using namespace meltsim;
using test_support::Order;
using test_support::PermutingExec;
using test_support::Random;

/// EngineImpl<PermutingExec<T>, T>; compiled once, in engine.cpp.
template <class T>
std::shared_ptr<core::Engine> make_engine(const PermutingExec<T>& exec);

/// With what a scene cannot be without.
inline core::EngineSetup setup_for(core::FactSet facts, std::size_t particles) {
  if ((facts & core::fact_fluid) == 0) facts |= core::fact_dry;
  if ((facts & core::any_search) == 0) facts |= core::fact_sparse;
  if ((facts & (core::fact_sparse | core::fact_tree)) != 0) facts |= core::fact_sorted;
  core::EngineSetup setup;
  setup.facts = facts;
  setup.channels = core::channels_for(facts) | (core::FieldSet{1} << core::field_vertex_of_id) |
                   (core::FieldSet{1} << core::field_neighbour_mask) |
                   (core::FieldSet{1} << core::field_site_live);
  setup.particle_capacity = static_cast<std::uint32_t>(particles);
  return setup;
}

/// Bits of a stage, or of all stages of a module that run in such a scene; 0: there is none.
inline std::uint64_t stage_bits(const std::string& wanted, core::FactSet facts) {
  std::uint64_t bits = 0;
  for (int s = 0; s < core::stage_count; ++s) {
    const core::StageInfo& info = core::stage_table[static_cast<std::size_t>(s)];
    const bool of_module = wanted == info.module && core::runs(info, facts);
    if (wanted == info.name || of_module) bits |= std::uint64_t{1} << s;
  }
  return bits;
}

template <class T>
struct Rig {
  PermutingExec<T> exec;
  std::shared_ptr<core::Engine> engine;
  std::uint64_t sampled =
      0;  ///< bit per probe: due in the sub-steps to come; their values go to the same place

  explicit Rig(Order order = Order::forward, bool fuses = false)
      : exec(order, fuses), engine(make_engine<T>(exec)) {}
  const core::Frame<T>& frame() const { return exec.frame(); }
  void upload(const core::SceneConstants& c, const core::SceneLattice& l, const core::SceneState& s,
              core::FactSet facts) {
    const core::EngineSetup setup = setup_for(facts, s.position.size());
    facts_ = setup.facts;
    const Status status = engine->upload(c, l, s, setup);
    ASSERT_TRUE(status) << status.error().message;
  }
  /// One sub-step of only these stages, or of all that a module runs with the facts of the upload.
  void run(std::initializer_list<const char*> stages, double dt = 1) {
    core::SubstepArguments a;
    a.dt = dt;
    a.index = ++steps_;
    a.sampled = sampled;
    for (const char* wanted : stages) {
      const std::uint64_t bits = stage_bits(wanted, facts_);
      ASSERT_NE(bits, 0u) << wanted;
      a.stages |= bits;
    }
    engine->substep(a);
  }

 private:
  std::uint64_t steps_ = 0;
  core::FactSet facts_ = 0;
};

/// Constants with one liquid (0), one solid that melts into it at 0 degrees (1), a denser liquid (2).
inline core::SceneConstants plain_constants(double spacing = 0.2) {
  core::SceneConstants c;
  c.spacing = spacing;
  c.support = 2.5 * spacing;
  c.sound_speed = 30;
  c.artificial_viscosity = 0.05;
  core::MaterialRow<double> water;
  water.density = 1000;
  water.tait_stiffness = 1000 * 900.0 / 7;
  water.viscosity = 0.2;
  water.heat_capacity = water.liquid_heat_capacity = 4000;
  core::MaterialRow<double> ice = water;
  ice.density = 917;
  ice.melts = ice.plateau = 1;
  ice.latent_heat = ice.melting_heat = 1000;
  ice.melting_enthalpy = -1000;
  core::MaterialRow<double> brine = water;
  brine.density = 2500;
  brine.tait_stiffness = 2500 * 900.0 / 7;
  brine.viscosity = 0.7;
  brine.liquid = 2;
  c.materials = {water, ice, brine};
  c.largest_mass = 2500 * spacing * spacing * spacing;
  return c;
}

/// Appends a particle at rest with dx^3 of its material.
inline std::uint32_t add_particle(core::SceneState& s, const core::SceneConstants& c, Vec3d x,
                                  std::uint32_t tag, Vec3d v = {}) {
  const double volume = c.spacing * c.spacing * c.spacing;
  s.position.push_back(x);
  s.velocity.push_back(v);
  s.volume.push_back(volume);
  s.mass.push_back(volume * c.materials[material_of(tag)].density);
  s.enthalpy.push_back(-1e6);
  s.tag.push_back(tag);
  s.vertex_of_id.push_back(core::none);
  return static_cast<std::uint32_t>(s.position.size() - 1);
}

/// Appends a body of these lattice points, as World builds it.
/// `free`: sites beyond the shape that liquid may freeze onto.
void add_body(core::SceneLattice& l, core::SceneState& s, const core::SceneConstants& c,
              const std::vector<Vec3i>& points, int half_width, const std::vector<Vec3i>& free = {});

/// Sites nearer than radius to one in the middle [spacings].
inline std::vector<Vec3i> ball(double radius) {
  std::vector<Vec3i> points;
  const int n = static_cast<int>(radius);
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x)
        if (x * x + y * y + z * z < radius * radius) points.push_back({x, y, z});
  return points;
}

inline std::vector<Vec3i> block(int nx, int ny, int nz) {
  std::vector<Vec3i> p;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) p.push_back({x, y, z});
  return p;
}

/// Vertex at a lattice point of v's body, `none` outside.
inline std::uint32_t vertex_at(const core::SceneLattice& l, std::uint32_t v, Vec3i offset) {
  const Vec3i a = l.vertex_coordinates[v];
  for (std::uint32_t u = 0; u < l.vertex_site.size(); ++u) {
    const Vec3i b = l.vertex_coordinates[u];
    if (l.vertex_body[u] == l.vertex_body[v] && b.x == a.x + offset.x && b.y == a.y + offset.y &&
        b.z == a.z + offset.z)
      return u;
  }
  return core::none;
}

}  // namespace modules_test
