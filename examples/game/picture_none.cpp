// SPDX-License-Identifier: Apache-2.0
#include "picture.hpp"

namespace game {

std::string write_picture(Game&, const std::string&) {
  return "--picture: this build has no renderer; build with the runner (MELTSIM_BUILD_RUNNER)";
}

}  // namespace game
