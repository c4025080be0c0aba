// SPDX-License-Identifier: Apache-2.0
#include "common.hpp"

#include <algorithm>
#include <regex>

#include "describe.hpp"
#include "suggest.hpp"

namespace meltsim_python {

std::string shown(nb::handle value) {
  std::string text;
  try {
    const nb::str repr = nb::repr(value);
    const char* utf8 = PyUnicode_AsUTF8(repr.ptr());
    if (utf8 == nullptr) PyErr_Clear();
    text = utf8 == nullptr ? "?" : utf8;
  } catch (nb::python_error&) {
    text = "?";
  }
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text + " (" + nb::type_name(value.type()).c_str() + ")";
}

std::string in_words_of_python(std::string message) {
  static const std::pair<std::regex, const char*> words[] = {
      {std::regex("SolidDesc::motion (\\w+) or (\\w+)"), "motion=\"$1\" or \"$2\""},
      {std::regex("SolidDesc::motion (\\w+)"), "motion=\"$1\""},
      {std::regex("EventWatch::kinds"), "kinds of watch_events()"},
      {std::regex("in the order of TriangleMesh::vertices"), "in the order in which Shape.mesh() took them"},
      {std::regex("\\b(World|[A-Z][A-Za-z]*(Desc|Setting|Watch))::"), ""},
      {std::regex("\\bShape::"), "Shape."},
      {std::regex("\\b(hold|enable|watch_forces)\\((\\w+), false\\)"), "$1($2, False)"},
      {std::regex("\\b(hold|enable|watch_forces)\\((\\w+), true\\)"), "$1($2, True)"}};
  for (const auto& [word, python] : words) message = std::regex_replace(message, word, python);
  return message;
}

std::string accepted(std::string type) {
  static const std::pair<std::regex, const char*> wider[] = {
      {std::regex("dict\\[Material \\| str, "), "collections.abc.Mapping[Any, "},
      {std::regex("\\bdict\\["), "collections.abc.Mapping["},
      {std::regex("Sequence\\[tuple\\[float, float\\]\\]"), "Sequence[Sequence[float]] | numpy.ndarray"},
      {std::regex("Sequence\\[float\\]"), "Sequence[float] | numpy.ndarray"},
      {std::regex("\\bfloat\\b"), "typing.SupportsFloat"},
      {std::regex("\\bint\\b"), "typing.SupportsIndex"},
      {std::regex("\\bbool\\b"), "bool | numpy.bool_"}};
  for (const auto& [word, python] : wider) type = std::regex_replace(type, word, python);
  return type;
}

bool is_boolean(nb::handle value) {
  if (PyBool_Check(value.ptr())) return true;
  if (!nb::hasattr(value, "dtype") || !nb::hasattr(value, "ndim")) return false;
  const nb::object kind = nb::getattr(value.attr("dtype"), "kind", nb::none());
  return kind.equal(nb::str("b")) && value.attr("ndim").equal(nb::int_(0));
}

nb::object items_of(nb::handle value) {
  PyObject* const v = value.ptr();
  if (PyUnicode_Check(v) || PyBytes_Check(v) || PyByteArray_Check(v) || PyDict_Check(v) || PyAnySet_Check(v))
    return {};
  nb::object items = nb::steal(PySequence_Fast(v, ""));
  if (items) return items;
  if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw nb::python_error();
  PyErr_Clear();
  return {};
}

double number(const std::string& name, nb::handle value, const char* expected) {
  const bool word = PyUnicode_Check(value.ptr()) || PyBytes_Check(value.ptr()) || is_boolean(value);
  const double result = word ? 0 : PyFloat_AsDouble(value.ptr());
  if (word || (result == -1 && PyErr_Occurred())) {
    PyErr_Clear();
    wrong_type(name + ": expected " + expected + ", got " + shown(value));
  }
  return result;
}

std::int64_t integer(const std::string& name, nb::handle value) {
  const bool fits = PyIndex_Check(value.ptr()) && !is_boolean(value);
  nb::object index = fits ? nb::steal(PyNumber_Index(value.ptr())) : nb::object();
  const long long result = index ? PyLong_AsLongLong(index.ptr()) : -1;
  if (!fits || PyErr_Occurred()) {
    PyErr_Clear();
    wrong_type(name + ": expected an integer, got " + shown(value));
  }
  return result;
}

int small(const std::string& name, nb::handle value) {
  const std::int64_t wide = integer(name, value);
  if (wide != static_cast<int>(wide)) refuse(name + ": " + std::to_string(wide) + " is out of range");
  return static_cast<int>(wide);
}

bool boolean(const std::string& name, nb::handle value, const char* expected) {
  if (!is_boolean(value)) wrong_type(name + ": expected " + expected + ", got " + shown(value));
  return value.is(Py_True) || PyObject_IsTrue(value.ptr()) == 1;
}

std::string text(const std::string& name, nb::handle value) {
  if (!PyUnicode_Check(value.ptr())) wrong_type(name + ": expected a string, got " + shown(value));
  Py_ssize_t size = 0;
  const char* utf8 = PyUnicode_AsUTF8AndSize(value.ptr(), &size);
  if (utf8 == nullptr) {  // as of a file name that is not UTF-8
    PyErr_Clear();
    refuse(name + ": expected text that UTF-8 can write, got " + shown(value));
  }
  return {utf8, static_cast<std::size_t>(size)};
}

meltsim::Vec3d vector(const std::string& name, nb::handle value) {
  const nb::object items = items_of(value);
  if (!items || PySequence_Fast_GET_SIZE(items.ptr()) != 3)
    wrong_type(name + ": expected three numbers, got " + shown(value));
  double x[3];
  for (int i = 0; i < 3; ++i)
    x[i] = number(name + "[" + std::to_string(i) + "]", PySequence_Fast_GET_ITEM(items.ptr(), i));
  return {x[0], x[1], x[2]};
}

std::size_t choice(const std::string& name, nb::handle value, const std::vector<std::string>& names) {
  const std::string word = text(name, value);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == word) return i;
  refuse(name + ": expected " + runner::either_of(names) + ", got \"" + word + "\"");
}

std::vector<std::string> texts(const std::string& name, nb::handle value) {
  if (PyUnicode_Check(value.ptr())) return {text(name, value)};
  std::vector<std::string> list;
  const nb::object items = PyAnySet_Check(value.ptr()) ? nb::list(value) : items_of(value);
  if (!items) wrong_type(name + ": expected a list of strings, got " + shown(value));
  for (Py_ssize_t i = 0; i < PySequence_Fast_GET_SIZE(items.ptr()); ++i)
    list.push_back(text(name, PySequence_Fast_GET_ITEM(items.ptr(), i)));
  return list;
}

std::vector<nb::object> arguments(const std::string& what, const std::vector<std::string>& names,
                                  std::size_t required, const nb::args& args, const nb::kwargs& kwargs) {
  if (args.size() > names.size())
    wrong_type(what + ": takes at most " + std::to_string(names.size()) + " arguments, got " +
               std::to_string(args.size()));
  std::vector<nb::object> given(names.size());
  for (std::size_t i = 0; i < args.size(); ++i) given[i] = nb::borrow(args[i]);
  for (auto [key, value] : kwargs) {
    const std::string name = text(what + ": an argument's name", key);
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end())
      wrong_type(what + ": there is no argument \"" + name + "\"" +
                 runner::suggestion(name, names, "arguments"));
    nb::object& place = given[static_cast<std::size_t>(at - names.begin())];
    if (place) wrong_type(what + ": " + name + " is given twice");
    place = nb::borrow(value);
  }
  for (std::size_t i = 0; i < required; ++i)
    if (!given[i]) wrong_type(what + ": " + names[i] + " is missing");
  return given;
}

namespace {

/// As a NumPy array in C order, of the type asked for; `kinds` are the letters of NumPy's dtype.kind that convert.
nb::object in_order(const std::string& name, nb::handle value, const char* kinds, const char* type,
                    const char* what) {
  if (nb::hasattr(value, "__dlpack_device__")) {
    const nb::tuple device = nb::cast<nb::tuple>(value.attr("__dlpack_device__")());
    if (nb::cast<int>(nb::int_(device[0])) != 1)
      wrong_type(
          name +
          ": the array is in device memory; copy it to the host first (.get() of CuPy, .cpu() of PyTorch)");
  }
  nb::module_ numpy = nb::module_::import_("numpy");
  nb::object array;
  try {
    array = numpy.attr("asarray")(value);
  } catch (nb::python_error&) {
    wrong_type(name + ": expected " + what + ", got " + shown(value));
  }
  const std::string kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
  const bool empty = nb::cast<std::size_t>(array.attr("size")) == 0;
  if (!empty && std::string(kinds).find(kind) == std::string::npos)
    wrong_type(name + ": expected " + what + ", got an array of " + to_text(array.attr("dtype")));
  nb::tuple shape = nb::cast<nb::tuple>(array.attr("shape"));
  if (shape.size() == 1 && nb::cast<std::size_t>(shape[0]) == 3) array = array.attr("reshape")(1, 3);
  else if (empty) array = array.attr("reshape")(0, 3);
  else if (shape.size() != 2 || nb::cast<std::size_t>(shape[1]) != 3)
    refuse(name + ": expected " + what + ", got one of shape " + nb::repr(shape).c_str());
  return numpy.attr("ascontiguousarray")(array, type);
}

}  // namespace

std::vector<meltsim::Vec3d> points(const std::string& name, nb::handle value) {
  const nb::object array = in_order(name, value, "fiu", "float64", "an array of numbers of shape (n, 3)");
  const auto view = nb::cast<nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>>(array);
  const auto* first = reinterpret_cast<const meltsim::Vec3d*>(view.data());
  return {first, first + view.shape(0)};
}

std::vector<std::uint32_t> triangles(const std::string& name, nb::handle value) {
  const nb::object array = in_order(name, value, "iu", "int64", "an array of integers of shape (n, 3)");
  const auto view =
      nb::cast<nb::ndarray<const std::int64_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>>(array);
  std::vector<std::uint32_t> indices(view.size());
  for (std::size_t i = 0; i < view.size(); ++i) {
    const std::int64_t index = view.data()[i];
    if (index < 0 || index > 0xffffffffll)
      refuse(name + ": expected indices of vertices from 0, got " + std::to_string(index));
    indices[i] = static_cast<std::uint32_t>(index);
  }
  return indices;
}

}  // namespace meltsim_python
