// SPDX-License-Identifier: Apache-2.0
// Probes as the host hands them to an engine, in double and stored coordinates.
#pragma once

#include <cstdint>
#include <vector>

#include "frame/frame.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

struct ProbeSetup {
  std::vector<ProbeRow> rows;
  std::vector<ProbePoint<double>> points;
  std::vector<ProbePoint<double>> heights;
  std::vector<ProbeLine> lines;
  std::vector<LoadRow> loads[load_kinds];  ///< by kind
  std::uint64_t room = 0;                  ///< number of values of samples to allocate
  std::uint64_t region = 0;                ///< in regions of so many
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
