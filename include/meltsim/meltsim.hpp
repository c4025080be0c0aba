// SPDX-License-Identifier: Apache-2.0
// Everything a host needs, except CUDA interop (meltsim/cuda_interop.hpp, opt-in).
#pragma once

#include "meltsim/desc.hpp"
#include "meltsim/probe.hpp"
#include "meltsim/world.hpp"
