// SPDX-License-Identifier: Apache-2.0
// A library of the host's with meltsim inside: what it exports is its own.
#include "meltsim/meltsim.h"

extern "C" __attribute__((visibility("default"))) unsigned plugin_version() { return meltsim_version(); }
