// SPDX-License-Identifier: Apache-2.0
// Errors of the library, brought back to the place in the scene that caused them.
#pragma once

#include <string>
#include <vector>

#include "failure.hpp"
#include "meltsim/result.hpp"
#include "scene.hpp"

namespace runner {

/// A field of a library description and the scene value it was filled from.
struct FieldPlace {
  std::string field;  ///< "support_radius"
  std::string path;   ///< "particles.support"
  std::string where;  ///< "fig4.yaml:4:33"
};

ExitCode exit_code(meltsim::ErrorCode code);

/// "where: path: message": the place of the first field that the message names, else `path` as a whole.
Failure library_failure(const meltsim::Error& error, const std::vector<FieldPlace>& places,
                        const std::string& path, const std::string& where);

std::vector<FieldPlace> world_places(const Scene& scene);
std::vector<FieldPlace> item_places(const SceneMaterial& material);
std::vector<FieldPlace> item_places(const SceneFluid& fluid);
std::vector<FieldPlace> item_places(const SceneBody& body);
std::vector<FieldPlace> item_places(const SceneEmitter& emitter);
std::vector<FieldPlace> item_places(const SceneHeatRegion& region);
std::vector<FieldPlace> item_places(const SceneForceField& field);
std::vector<FieldPlace> item_places(const SceneProbe& probe);

}  // namespace runner
