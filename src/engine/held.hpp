// SPDX-License-Identifier: Apache-2.0
// The arrays that the host holds of the state, one by one, and items of channels to items of arrays and back. Both follow
// from fields.def.
#pragma once

#include <cstddef>
#include <type_traits>

#include "engine/scene.hpp"
#include "pipeline/pipeline.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Properties of an array of SceneState, from fields.def.
template <Owner Per, Hashed How>
struct Held {
  static constexpr bool of_vertex = Per == Owner::vertex;
  static constexpr bool of_species = Per == Owner::particle_species;
  static constexpr Hashed hashed = How;
};

/// visit(Held, array, value of what is added), in the order of snapshots; arrays per species for the first `species`.
template <class State, class Visit>
void each_held(State& s, std::size_t species, const Visit& visit) {
#define MELTSIM_HELD(array, host, owner, channel, part, first, how) \
  {                                                                 \
    const host added = first;                                       \
    visit(Held<Owner::owner, Hashed::how>{}, s.array, added);       \
  }
#define MELTSIM_HELD_PER_SPECIES(array, host, owner, channel, part, first, how) \
  for (std::size_t k = 0; k < species; ++k) {                                   \
    const host added = first;                                                   \
    visit(Held<Owner::owner, Hashed::how>{}, s.array[k], added);                \
  }
#include "meltsim/fields.def"
}

// Parts of a channel's item, by the names that fields.def has for them: the whole, x y z, w.

template <class To, class From>
To converted(const From& v) {
  return static_cast<To>(v);
}
template <class To, class T>
std::enable_if_t<std::is_same_v<To, Vec3<float>> || std::is_same_v<To, Vec3<double>>, To> converted(
    const Vec3<T>& v) {
  return {static_cast<decltype(To::x)>(v.x), static_cast<decltype(To::x)>(v.y),
          static_cast<decltype(To::x)>(v.z)};
}
template <class To, class T>
To converted(const Quat<T>& q) {
  using S = decltype(To::x);
  return {static_cast<S>(q.w), static_cast<S>(q.x), static_cast<S>(q.y), static_cast<S>(q.z)};
}

struct Part_all {
  template <class Item, class Host>
  static void put(Item& to, const Host& from) {
    to = converted<Item>(from);
  }
  template <class Host, class Item>
  static Host get(const Item& from) {
    return converted<Host>(from);
  }
};
struct Part_xyz {
  template <class T>
  static void put(Vec4<T>& to, const Vec3d& from) {
    to = with_w(cast<T>(from), to.w);
  }
  template <class Host, class T>
  static Host get(const Vec4<T>& from) {
    return cast<double>(xyz(from));
  }
};
struct Part_w {
  template <class T>
  static void put(Vec4<T>& to, double from) {
    to.w = static_cast<T>(from);
  }
  template <class Host, class T>
  static Host get(const Vec4<T>& from) {
    return static_cast<double>(from.w);
  }
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
