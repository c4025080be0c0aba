// SPDX-License-Identifier: Apache-2.0
// The processors of this machine.
#pragma once

namespace runner {

/// Processors that this process may use, at least 1.
int processors();

}  // namespace runner
