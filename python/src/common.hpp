// SPDX-License-Identifier: Apache-2.0
// Python values to the library's, with errors that name the argument; the library's errors as exceptions.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "meltsim/meltsim.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace meltsim_python {

/// Arguments of any type, which the functions below convert, and results: what stubs and docstrings call them.
inline bool any_value(nb::handle) { return true; }
struct Real : nb::object {
  NB_OBJECT_DEFAULT(Real, nb::object, "typing.SupportsFloat", any_value)
};
struct Integer : nb::object {
  NB_OBJECT_DEFAULT(Integer, nb::object, "typing.SupportsIndex", any_value)
};
struct Boolean : nb::object {
  NB_OBJECT_DEFAULT(Boolean, nb::object, "bool | numpy.bool_", any_value)
};
struct Text : nb::object {
  NB_OBJECT_DEFAULT(Text, nb::object, "str", any_value)
};
struct Texts : nb::object {
  NB_OBJECT_DEFAULT(Texts, nb::object, "str | Sequence[str]", any_value)
};
struct Vector : nb::object {
  NB_OBJECT_DEFAULT(Vector, nb::object, "Sequence[typing.SupportsFloat] | numpy.ndarray", any_value)
};
struct ArrayLike : nb::object {
  NB_OBJECT_DEFAULT(ArrayLike, nb::object, "numpy.typing.ArrayLike", any_value)
};
struct Array : nb::object {
  NB_OBJECT_DEFAULT(Array, nb::object, "numpy.ndarray", any_value)
};
struct Triple : nb::object {
  NB_OBJECT_DEFAULT(Triple, nb::object, "tuple[float, float, float]", any_value)
};

/// Becomes meltsim.Error.
struct LibraryError : std::exception {
  meltsim::Error error;
  explicit LibraryError(meltsim::Error e) : error(std::move(e)) {}
  const char* what() const noexcept override { return error.message.c_str(); }
};

[[noreturn]] inline void refuse(const std::string& message) {
  throw LibraryError({meltsim::ErrorCode::invalid_argument, message});
}
[[noreturn]] inline void wrong_type(const std::string& message) { throw nb::type_error(message.c_str()); }

template <class T>
T expect(meltsim::Result<T> result) {
  if (!result) throw LibraryError(result.error());
  return std::move(*result);
}
inline void expect(const meltsim::Status& status) {
  if (!status) throw LibraryError(status.error());
}

/// A message of the library as Python says it: motion="kinematic" for SolidDesc::motion kinematic, False for false.
std::string in_words_of_python(std::string message);
/// str(value)
inline std::string to_text(const nb::object& value) { return nb::str(value).c_str(); }
/// For messages: the value, shortened, and its type.
std::string shown(nb::handle value);
/// Whether it is a bool, of NumPy, too.
bool is_boolean(nb::handle value);
/// What PySequence_Fast makes of a list, a tuple, an array and the like; null, without an error, of what is none of them: a number, an
/// array without axes, text, bytes, a dict, a set.
nb::object items_of(nb::handle value);
double number(const std::string& name, nb::handle value, const char* expected = "a number");
std::int64_t integer(const std::string& name, nb::handle value);
int small(const std::string& name, nb::handle value);  ///< an integer that an int holds
bool boolean(const std::string& name, nb::handle value, const char* expected = "True or False");
std::string text(const std::string& name, nb::handle value);
meltsim::Vec3d vector(const std::string& name, nb::handle value);
/// Index of the word in `names`.
std::size_t choice(const std::string& name, nb::handle value, const std::vector<std::string>& names);
std::vector<std::string> texts(const std::string& name, nb::handle value);
/// Of shape (n, 3); three numbers are one point.
std::vector<meltsim::Vec3d> points(const std::string& name, nb::handle value);
std::vector<std::uint32_t> triangles(const std::string& name, nb::handle value);

/// Arguments of a call in the order of `names`; those that are not given are null. Errors name them as those of the tables of
/// describe.hpp do: nanobind would list signatures. The first `required` must be there.
std::vector<nb::object> arguments(const std::string& what, const std::vector<std::string>& names,
                                  std::size_t required, const nb::args& args, const nb::kwargs& kwargs);

inline Triple tuple3(const meltsim::Vec3d& v) { return nb::borrow<Triple>(nb::make_tuple(v.x, v.y, v.z)); }

/// A NumPy array that keeps `owner` alive. No copy.
template <class T>
Array array_view(const T* data, std::vector<std::size_t> shape, nb::handle owner, bool writable = true) {
  static T none{};
  auto* at = const_cast<T*>(data != nullptr ? data : &none);
  nb::ndarray<nb::numpy, T> array(at, shape.size(), shape.data(), owner);
  Array object = nb::borrow<Array>(nb::cast(array, nb::rv_policy::reference));
  if (!writable) object.attr("flags").attr("writeable") = false;
  return object;
}

/// A NumPy array that owns what was in `values`. No copy.
template <class T, class V>
Array array_of(std::vector<V>&& values, std::size_t columns = 1) {
  static_assert(sizeof(V) % sizeof(T) == 0, "items of T");
  auto* kept = new std::vector<V>(std::move(values));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<V>*>(p); });
  std::vector<std::size_t> shape{kept->size() * sizeof(V) / sizeof(T) / columns};
  if (columns > 1) shape.push_back(columns);
  return array_view<T>(reinterpret_cast<const T*>(kept->data()), shape, owner);
}

void bind_shape(nb::module_& m);
void bind_readings(nb::module_& m);
void bind_world(nb::module_& m);

}  // namespace meltsim_python
