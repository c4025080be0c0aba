// SPDX-License-Identifier: Apache-2.0
// What checked builds look for, on a World that is sound and then broken by hand.
#include "engine/checked.hpp"

#include <limits>

#include "engine.hpp"
#include "lattice_oracle.hpp"

namespace modules_test {
namespace {

struct Copy {
  template <class V>
  std::vector<V> operator()(const V* from, std::size_t n) const {
    return std::vector<V>(from, from + n);
  }
};

TEST(Checked, BrokenValuesOrderAndMassAreNamed) {
  const auto c = plain_constants();
  core::SceneState s;
  for (int i = 0; i < 3; ++i) add_particle(s, c, {0.2 * i, 0, 0}, 0);
  Rig<double> rig;
  rig.upload(c, {}, s, core::fact_particles | core::fact_fluid);
  rig.run({"step.begin", "spatial", "sph.density"});
  const auto& w = rig.frame();
  const Copy copy;
  const core::Invariants<double, Copy> look(w, copy);
  const double mass = look.mass();
  EXPECT_EQ(look.after(core::stage_spatial_reorder, mass, 0), "");
  EXPECT_EQ(look.after(core::stage_sph_density, mass, 0), "");

  const double density = w.f.density[1];
  w.f.density[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(look.after(core::stage_sph_density, mass, 0).find("sph.density: channel density"),
            std::string::npos);
  EXPECT_EQ(look.after(core::stage_spatial_sort, mass, 0), "");  // did not write it
  w.f.density[1] = density;

  EXPECT_NE(look.after(core::stage_spatial_reorder, 2 * mass, 0).find("mass fell"), std::string::npos);
  EXPECT_NE(look.after(core::stage_spatial_settle, 2 * mass, 0).find("mass fell"), std::string::npos);
  std::swap(w.f.slot_of_id[0], w.f.slot_of_id[1]);
  // Both ways to sort: cells that are counted, the usual case, and keys.
  EXPECT_NE(look.after(core::stage_spatial_reorder, mass, 0).find("inverse"), std::string::npos);
  EXPECT_NE(look.after(core::stage_spatial_settle, mass, 0).find("inverse"), std::string::npos);
}

}  // namespace
}  // namespace modules_test
