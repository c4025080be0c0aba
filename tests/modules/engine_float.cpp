// SPDX-License-Identifier: Apache-2.0
#include "modules/make_engine.hpp"

template std::shared_ptr<modules_test::core::Engine> modules_test::make_engine<float>(
    const PermutingExec<float>&);
