// SPDX-License-Identifier: Apache-2.0
#include "scenes.hpp"

const char* meltsim_test::usual_backend() { return "cpu"; }
