// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Name of a thing that its host gave none: its kind and how many there are with it, or the next number that no other has, so that a
/// name which nobody chose is never refused.
template <class Taken>
std::string numbered_name(const char* kind, std::size_t others, Taken taken) {
  std::string name;
  do name = kind + std::to_string(++others);
  while (taken(name));
  return name;
}

/// The same among things with a description.
template <class Records>
std::string numbered_name(const char* kind, const Records& records) {
  return numbered_name(kind, records.size(), [&](const std::string& name) {
    for (const auto& r : records)
      if (r.desc.name == name) return true;
    return false;
  });
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
