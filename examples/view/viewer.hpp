// SPDX-License-Identifier: Apache-2.0
// The window's loop: input, steps, picture.
#pragma once

#include "view_options.hpp"

namespace view {

/// Until the window is closed or the picture is written; returns the exit code or throws runner::Failure.
int run_viewer(const ViewOptions& options);

}  // namespace view
