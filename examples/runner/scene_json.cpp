// SPDX-License-Identifier: Apache-2.0
#include "scene_json.hpp"

#include <algorithm>

#include "echo.hpp"
#include "scene_options.hpp"

namespace runner {

namespace {

/// The scene with derived values in place of `auto`.
Scene with_derived(const Scene& scene, const meltsim::Resolved& resolved) {
  Scene said = scene;
  if (scene.world.sound_speed > 0) said.world.density_error = 0;
  said.world.sound_speed = resolved.sound_speed;
  said.world.support_radius = resolved.support_radius;
  said.world.neighbour_search = resolved.neighbour_search;
  return said;
}

/// Without what says nothing: of a material that has no solvent, of a stiffness that youngs_modulus replaces.
Json material_json(const SceneMaterial& material) {
  Json json = options_json(material_options(), material);
  json.erase(material.desc.youngs_modulus > 0 ? "stiffness" : "youngs_modulus");
  if (material.dissolves_in.empty())
    for (const char* key : {"solubility", "diffusivity_in", "heat_of_solution", "transfer_coefficient"})
      json.erase(key);
  return json;
}

}  // namespace

Json scene_json(const Scene& scene, const meltsim::Resolved& resolved) {
  Json json;
  json["meltsim"] = 1;
  if (!scene.title.empty()) json["title"] = scene.title;
  const Scene said = with_derived(scene, resolved);
  const bool solutes = std::any_of(scene.materials.begin(), scene.materials.end(),
                                   [](const SceneMaterial& m) { return !m.dissolves_in.empty(); });
  for (const Section& section : scene_sections()) {
    if (section.options == solute_options && !solutes) continue;
    if (Json options = options_json(section.options(), said); !options.empty())
      json[section.name] = std::move(options);
  }
  for (const SceneMaterial& material : scene.materials)
    json["materials"][material.desc.name] = material_json(material);
  for (const SceneList& list : scene_lists())
    if (Json items = list.echo(scene); !items.is_null()) json[list.name] = std::move(items);
  return json;
}

}  // namespace runner
