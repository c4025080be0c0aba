// SPDX-License-Identifier: Apache-2.0
// How the panel looks.
#pragma once

namespace view {

/// `scale`: 1 on ordinary displays, 2 on fine ones.
void set_theme(double scale);

}  // namespace view
