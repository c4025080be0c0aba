// SPDX-License-Identifier: Apache-2.0
// Keyword arguments to descriptions: one table per description, from which reading, errors and docstrings follow.
#pragma once

#include <functional>
#include <optional>

#include "common.hpp"
#include "suggest.hpp"

namespace meltsim_python {

template <class D>
struct Key {
  const char* name;
  const char* type;  ///< as docstrings show it
  const char* doc;
  std::function<void(D&, const std::string& name, nb::handle value)> set;
};
template <class D>
using Keys = std::vector<Key<D>>;

template <class D>
auto set_to(double D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) { d.*member = number(name, v); };
}
template <class D>
auto set_to(std::optional<double> D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) {
    if (v.is_none()) (d.*member).reset();
    else d.*member = number(name, v, "a number or None");
  };
}
template <class D>
auto set_to(bool D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) { d.*member = boolean(name, v); };
}
template <class D>
auto set_to(std::optional<bool> D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) {
    if (v.is_none()) (d.*member).reset();
    else d.*member = boolean(name, v, "True, False or None");
  };
}
template <class D>
auto set_to(int D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) { d.*member = small(name, v); };
}
template <class D>
auto set_to(std::uint64_t D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) {
    const std::int64_t value = integer(name, v);
    if (value < 0) refuse(name + ": " + std::to_string(value) + " is below 0");
    d.*member = static_cast<std::uint64_t>(value);
  };
}
template <class D>
auto set_to(std::string D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) { d.*member = text(name, v); };
}
template <class D>
auto set_to(meltsim::Vec3d D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) { d.*member = vector(name, v); };
}
template <class D>
auto set_to(meltsim::Shape D::*member) {
  return [member](D& d, const std::string& name, nb::handle v) {
    if (!nb::isinstance<meltsim::Shape>(v)) wrong_type(name + ": expected a meltsim.Shape, got " + shown(v));
    d.*member = nb::cast<meltsim::Shape>(v);
  };
}
template <class D, class E>
auto set_to(E D::*member, std::vector<std::string> names) {
  return [member, names](D& d, const std::string& name, nb::handle v) {
    d.*member = static_cast<E>(choice(name, v, names));
  };
}

template <class D>
const Key<D>& key_named(const Keys<D>& keys, const std::string& what, const std::string& name) {
  std::vector<std::string> names;
  for (const Key<D>& key : keys) {
    if (name == key.name) return key;
    names.emplace_back(key.name);
  }
  wrong_type(what + ": there is no argument \"" + name + "\"" + runner::suggestion(name, names, "arguments"));
}

/// Reads positional arguments in the order of the table, at most `positional`, then keywords.
template <class D>
void describe(D& desc, const Keys<D>& keys, const std::string& what, std::size_t positional,
              const nb::args& args, const nb::kwargs& kwargs) {
  if (args.size() > positional)
    wrong_type(what + ": takes at most " + std::to_string(positional) +
               " arguments without a name; name the others");
  for (std::size_t i = 0; i < args.size(); ++i) {
    if (kwargs.contains(keys[i].name)) wrong_type(what + ": " + keys[i].name + " is given twice");
    keys[i].set(desc, keys[i].name, args[i]);
  }
  for (auto [name, value] : kwargs) {
    const Key<D>& key = key_named(keys, what, text(what + ": an argument's name", name));
    key.set(desc, key.name, value);
  }
}

/// The same from a dict that is an argument itself: errors say "surface.flux: ...".
template <class D>
void describe(D& desc, const Keys<D>& keys, const std::string& name, nb::handle dict) {
  if (!nb::isinstance<nb::dict>(dict)) wrong_type(name + ": expected a dict, got " + shown(dict));
  for (auto [k, value] : nb::cast<nb::dict>(dict)) {
    const Key<D>& key = key_named(keys, name, text(name + ": a key", k));
    key.set(desc, name + "." + key.name, value);
  }
}

/// What an argument takes that docstrings call so: NumPy's numbers, vectors and bools, too. For stubs.
std::string accepted(std::string type);

/// A signature for stubs and help().
template <class D>
std::string signature(const char* name, const Keys<D>& keys, std::size_t positional, std::size_t required,
                      const char* result) {
  std::string s = std::string("def ") + name + "(self";
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i == positional) s += ", *";
    s += std::string(", ") + keys[i].name + ": " + accepted(keys[i].type) + (i < required ? "" : " = ...");
  }
  return s + ") -> " + result;
}

template <class D>
std::string documented(const char* summary, const Keys<D>& keys) {
  std::string s = std::string(summary) + "\n\nParameters\n----------\n";
  for (const Key<D>& key : keys) s += std::string(key.name) + " : " + key.type + "\n    " + key.doc + "\n";
  return s;
}

}  // namespace meltsim_python
