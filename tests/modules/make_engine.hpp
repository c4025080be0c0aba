// SPDX-License-Identifier: Apache-2.0
// All stages for the executor of the tests. One precision per translation unit: both took minutes.
#pragma once

#include "engine/engine_impl.hpp"
#include "lsm/stages.hpp"
#include "modules/engine.hpp"
#include "reading/stages.hpp"
#include "sampling/stages.hpp"
#include "spatial/stages.hpp"
#include "species/stages.hpp"
#include "sph/stages.hpp"
#include "step/stages.hpp"
#include "surface/stages.hpp"
#include "thermal/stages.hpp"
#include "topology/stages.hpp"

namespace modules_test {

template <class T>
std::shared_ptr<core::Engine> make_engine(const PermutingExec<T>& exec) {
  return std::make_shared<core::EngineImpl<PermutingExec<T>, T>>(exec, "test");
}

}  // namespace modules_test
