// SPDX-License-Identifier: Apache-2.0
// Scene text (YAML or JSON) to Scene. Every error is a Failure with its place in the file.
#pragma once

#include <string>
#include <vector>

#include "scene.hpp"

namespace runner {

/// SCENE of the command line: a file, the name of a built-in scene, or "-" for standard input.
Scene load_scene(const std::string& file_or_name, const std::vector<std::string>& set_options);

/// The same from text; `file` is what messages call it.
Scene parse_scene(const std::string& text, const std::string& file, const std::string& directory,
                  const std::vector<std::string>& set_options);

/// Materials as build_world makes them: those of the scene, then one per density that a body has of its own.
void add_look(SceneOutput& output, const std::string& material, std::optional<std::array<double, 3>> color);
void add_look(SceneOutput& output, const std::string& material, double density);
/// The colour of a material whose look was added; nothing where it has none.
std::optional<std::array<double, 3>> look_color(const SceneOutput& output, const std::string& material);
/// A body's own density is a material of its own, alike in everything else.
std::string dense_material(const std::string& material, double density);

}  // namespace runner
