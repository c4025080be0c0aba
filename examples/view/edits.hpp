// SPDX-License-Identifier: Apache-2.0
// What the panel changes about a scene. A World takes none of it while it runs, so the scene is built anew.
#pragma once

#include <string>
#include <vector>

#include "color_map.hpp"
#include "options.hpp"
#include "scene.hpp"

namespace view {

/// How well a material conducts, in the form in which the scene gives it.
struct ConductivityEdit {
  enum class Form {
    conductivity,  ///< [W/(m K)]
    diffusivity,   ///< [m^2/s]
    factor         ///< of a conductivity that depends on temperature
  };
  std::string material;
  Form form = Form::conductivity;
  double value = 0;
};

/// A temperature that the scene starts with.
struct TemperatureEdit {
  std::string name;  ///< "body block", "liquid 1", "jet"
  double value = 0;  ///< [degrees Celsius]
};

struct Edits {
  std::vector<ConductivityEdit> conductivities;  ///< per material
  std::vector<TemperatureEdit> temperatures;     ///< fluids, then bodies, then emitters
  double time_scale = 1;                         ///< heat.time_scale
  double scale = 1;                              ///< linear resolution factor
};

/// The scene's own values.
Edits edits_of(const runner::Scene& scene, double scale);
/// `scene` (before any change of resolution) with `edits`.
runner::Scene edited(const runner::Scene& scene, const Edits& edits, runner::Quality quality);

/// From the coldest to the warmest that the scene itself names, at least one degree.
Range temperature_range(const runner::Scene& scene);
/// What there is to see: the domain where it has bounds, else the fluids and bodies.
meltsim::Box scene_box(const runner::Scene& scene);

}  // namespace view
