// SPDX-License-Identifier: Apache-2.0
#pragma once

#define MELTSIM_VERSION_MAJOR 0
#define MELTSIM_VERSION_MINOR 1
#define MELTSIM_VERSION_PATCH 0
/// Compared at World::create: a host compiled against other headers is refused with a clear message.
#define MELTSIM_VERSION_NUMBER \
  (MELTSIM_VERSION_MAJOR * 10000 + MELTSIM_VERSION_MINOR * 100 + MELTSIM_VERSION_PATCH)
