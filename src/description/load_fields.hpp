// SPDX-License-Identifier: Apache-2.0
// Names of what probes of kinds force and flux give.
#pragma once

#include <cstdint>
#include <string>

#include "meltsim/probe.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

struct LoadField {
  const char* name;
  ProbeKind kind;
  std::uint32_t width;  ///< values
  std::uint32_t slot;   ///< which of the kind's: force and moment of the liquid, of contact; mass, volume
};
inline constexpr LoadField load_fields[] = {
    {"force", ProbeKind::force, 3, 0},         {"moment", ProbeKind::force, 3, 1},
    {"contact_force", ProbeKind::force, 3, 2}, {"contact_moment", ProbeKind::force, 3, 3},
    {"mass_flux", ProbeKind::flux, 1, 0},      {"volume_flux", ProbeKind::flux, 1, 1},
};

/// Null if this kind has no field of that name.
inline const LoadField* find_load_field(ProbeKind kind, const std::string& name) {
  for (const LoadField& f : load_fields)
    if (f.kind == kind && name == f.name) return &f;
  return nullptr;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
