// SPDX-License-Identifier: Apache-2.0
// The window's picture as a PNG file.
#pragma once

#include <string>

#include "camera.hpp"

namespace view {

/// Of what has been drawn but not shown yet. Throws runner::Failure (code 5) when it cannot be written.
void save_screenshot(const std::string& file, const Viewport& viewport);

}  // namespace view
