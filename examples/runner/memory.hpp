// SPDX-License-Identifier: Apache-2.0
// Memory: refusing what cannot fit before anything is built, and saying which --scale fits.
#pragma once

#include <string>

#include "failure.hpp"
#include "scene.hpp"

namespace runner {

/// Makes memory that is freed come back to this program, not to the system. Every frame takes and frees the same tens of
/// megabytes, and pages new from the system cost more than what is done with them.
void keep_freed_memory();

/// Fails when the shapes would hold more particles than this machine can (a typo in the spacing, mostly).
void check_particle_budget(const Scene& scene);

/// "memory: 4.2 GB needed, 3.1 GB free on device 0; --scale 0.8 fits", from the library's message.
Failure memory_failure(const std::string& library_message, const std::string& device);

/// The --scale that fits: particles grow with the third power of the resolution.
std::string scale_hint(double needed_bytes, double free_bytes);

}  // namespace runner
