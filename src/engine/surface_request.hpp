// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "meltsim/desc.hpp"
#include "meltsim/surface.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// A checked SurfaceDesc with the properties of the World that it depends on; domain relative to the origin.
struct SurfaceRequest {
  SurfaceOf of = SurfaceOf::liquid;
  std::uint32_t body = 0;  ///< index + 1
  double cell = 0, spacing = 0;
  bool anisotropic = false;
  bool solids = false;  ///< there are some
  bool closed = false;  ///< SurfaceDesc::closed_at_solids
  int smoothing = 0;
  bool waits = true;  ///< SurfaceDesc::wait
  DomainDesc domain;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
