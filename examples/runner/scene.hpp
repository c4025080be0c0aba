// SPDX-License-Identifier: Apache-2.0
// A scene after reading: the library's own descriptions, plus what only the runner knows (time, outputs),
// plus where each part stood in the file.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meltsim/desc.hpp"
#include "meltsim/probe.hpp"
#include "node.hpp"

namespace runner {

using Json = nlohmann::ordered_json;

/// A shape and the text it came from, so that run.json can repeat it.
struct SceneShape {
  meltsim::Shape shape;
  Json echo;
  std::vector<std::string> warnings{};  ///< of mesh files
  std::uint64_t mesh = 0;               ///< hash of what its mesh files hold; 0: it has none
};

struct SceneMaterial {
  meltsim::MaterialDesc desc;
  std::string becomes;                         ///< name of the liquid it melts into, or empty
  std::string dissolves_in;                    ///< name of its solvent, or empty
  std::optional<std::array<double, 3>> color;  ///< red, green, blue in pictures, 0..1
  Source source;
};

/// How a material is shown.
struct SceneLook {
  std::string name;
  std::optional<std::array<double, 3>> color;  ///< red, green, blue, 0..1; a liquid without one is clear
};

/// Species by name, and how much of each a liquid holds [kg/kg].
using SceneFractions = std::vector<std::pair<std::string, double>>;

struct SceneFluid {
  SceneShape shape;
  std::string material;
  SceneFractions fractions;
  meltsim::FluidDesc desc;
  Source source;
};

struct SceneBody {
  SceneShape shape;
  std::string material;
  std::optional<double> density;  ///< replaces the material's
  bool visible = true;            ///< in pictures and on the page
  meltsim::SolidDesc desc;
  Source source;
};

struct SceneEmitter {
  std::string material;
  SceneFractions fractions;
  meltsim::EmitterDesc desc;
  Source source;
};

/// Half of the opening's least side, or its radius [m]; of a face of the domain none.
inline double least_radius(const meltsim::EmitterDesc& e) {
  if (e.level) return meltsim::infinity;
  return e.width > 0 ? 0.5 * std::min(e.width, e.height) : e.radius;
}

struct SceneHeatRegion {
  SceneShape shape;
  meltsim::HeatRegionDesc desc;
  Source source;
};

struct SceneForceField {
  std::optional<SceneShape> shape;  ///< nothing: everywhere
  meltsim::ForceFieldDesc desc;
  Source source;
};

struct SceneProbe {
  meltsim::ProbeDesc desc;  ///< fields as the scene names them; of points one, or none
  std::string body;         ///< its name, of kinds force and heat
  Source source;
};

/// Whether liquid comes to rest before the run.
struct SceneSettle {
  bool on = false;
  double seconds = meltsim::automatic;  ///< that it is given
};

struct SceneTime {
  std::optional<double> dt;  ///< [s]; nothing = the largest stable one
  bool adaptive = false;
  double end = 10;            ///< [s]
  double fps = 25;            ///< frames per simulated second
  bool until_melted = false;  ///< stop when nothing meltable is left; `end` is the cap
  double tail = 0;            ///< [s] simulated after that
  std::string dt_where, end_when_where;
};

/// What an exact answer is at a time.
struct ExactPoint {
  double time, value;
};

/// What matters in a scene, and how exactly.
struct SceneTrade {
  std::vector<std::string> observe;  ///< empty: it follows from what is in the scene
  std::optional<double> max_error;   ///< of the first observable, share of its scale
  std::vector<std::pair<std::string, std::vector<ExactPoint>>>
      exact;  ///< per observable; one point: constant
  std::string observe_where, max_error_where;
};

struct SceneOutput {
  std::vector<std::string> formats{"ply"};
  /// Of each body in pictures; empty where the scene does not say.
  std::vector<std::optional<std::array<double, 3>>> body_colors;
  std::vector<bool> body_visible;  ///< of each body, in pictures and on the page
  std::vector<SceneLook> looks;    ///< by the material index in a particle's tag
  Json surface, camera, picture;   ///< what was given of their keys, checked
};

struct Scene {
  std::string file;  ///< as shown in messages
  std::string name;  ///< of the output directory
  std::string title;
  std::string text;                   ///< of a scene from standard input, which cannot be read twice
  std::vector<std::string> warnings;  ///< what looks like a slip: "where: path: ..."
  meltsim::WorldDesc world;
  double given_spacing = 0;  ///< [m] as the scene has it, ahead of options that change it
  SceneTime time;
  SceneSettle settle;
  std::vector<SceneMaterial> materials;
  std::vector<SceneFluid> fluids;
  std::vector<SceneBody> bodies;
  std::vector<SceneEmitter> emitters;
  std::vector<SceneHeatRegion> heat_regions;
  std::vector<SceneForceField> force_fields;
  std::vector<SceneProbe> probes;
  SceneTrade trade;
  SceneOutput output;
  double sound_factor = 1;  ///< of the sound speed, once `auto` is known
  std::string where;        ///< of the whole scene
  Source domain, particles, solver, heat, solute, time_source;
  Source wishes;  ///< of what no World is told
};

}  // namespace runner
