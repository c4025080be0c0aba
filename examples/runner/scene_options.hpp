// SPDX-License-Identifier: Apache-2.0
// The keys of a scene's sections, one row each. Reading, run.json's echo, the places of errors that only the library finds,
// the JSON Schema and the tables of docs/runner.md follow from these rows.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scene.hpp"
#include "scene_keys.hpp"

namespace runner {

/// One key of a description D.
template <class D>
struct Option {
  std::string key;
  std::string field;      ///< the library's name of it in messages; empty: the library has no such field
  std::string otherwise;  ///< default, as the manual shows it
  std::string doc;        ///< for manual and schema; Markdown. Empty: a row of the manual or its text has it
  Json schema;            ///< without the description; null: written by hand in scene.schema.json
  std::function<void(const Node& value, D&)> load;
  std::function<Json(const D&)> echo;  ///< as a scene would give it; null is left out
};
template <class D>
using Options = std::vector<Option<D>>;

const Options<Scene>& domain_options();
const Options<Scene>& particles_options();
const Options<Scene>& time_options();
const Options<Scene>& solver_options();
const Options<Scene>& heat_options();
const Options<Scene>& solute_options();
const Options<SceneMaterial>& material_options();
const Options<meltsim::SurfaceHeatDesc>& surface_heat_options();

/// A section of a scene whose keys belong to the whole scene.
struct Section {
  const char* name;
  const Options<Scene>& (*options)();
  Source Scene::*source;
};
const std::vector<Section>& scene_sections();

template <class D>
keys::List keys_of(const Options<D>& options) {
  keys::List list;
  for (const Option<D>& option : options) list.push_back(option.key);
  return list;
}

/// Reads the keys that are there, in the order of the table; others are refused.
template <class D>
void load_options(const Node& node, const Options<D>& options, D& to) {
  node.allow_keys(keys_of(options));
  for (const Option<D>& option : options)
    if (const auto value = node.find(option.key)) option.load(*value, to);
}

template <class D>
Json options_json(const Options<D>& options, const D& from) {
  Json json = Json::object();
  for (const Option<D>& option : options)
    if (Json value = option.echo(from); !value.is_null()) json[option.key] = std::move(value);
  return json;
}

/// Null when nothing is set.
Json surface_json(const meltsim::SurfaceHeatDesc& surface);

// ---- Kinds of options: `get` leads from a description to its member ----------------------------------------

/// What the schema says of a number.
struct Range {
  Json json = Json::object();
  bool above_zero = false;  ///< refused by the reader, for every other bound the library has words
};
inline Range any_number() { return {}; }
inline Range above_zero(Json more = Json::object()) {
  more["exclusiveMinimum"] = 0;
  return {std::move(more), true};
}
inline Range at_least(double low) { return {{{"minimum", low}}, false}; }
inline Range between(double low, double high) { return {{{"minimum", low}, {"maximum", high}}, false}; }

inline Json typed(const char* type, const Range& range) {
  Json json{{"type", type}};
  json.update(range.json);
  return json;
}

template <class D, class Get>
Option<D> number(const char* key, const char* field, const Get& get, const char* unit, const Range& range,
                 const char* otherwise, const char* doc) {
  return {
      key,
      field,
      otherwise,
      doc,
      typed("number", range),
      [=](const Node& value, D& d) { get(d) = range.above_zero ? value.positive(unit) : value.number(unit); },
      [get](const D& d) -> Json { return get(d); }};
}

/// A number that may be absent: std::optional<double>.
template <class D, class Get>
Option<D> maybe_number(const char* key, const char* field, const Get& get, const char* unit,
                       const Range& range, const char* otherwise, const char* doc) {
  return {key,
          field,
          otherwise,
          doc,
          typed("number", range),
          [=](const Node& value, D& d) { get(d) = value.number(unit); },
          [get](const D& d) -> Json { return get(d) ? Json(*get(d)) : Json(); }};
}

/// A number above 0, or `auto`, which is 0.
template <class D, class Get>
Option<D> number_or_auto(const char* key, const char* field, const Get& get, const char* unit,
                         const char* doc) {
  return {key,
          field,
          "`auto`",
          doc,
          {{"oneOf", {{{"const", "auto"}}, {{"type", "number"}, {"exclusiveMinimum", 0}}}}},
          [=](const Node& value, D& d) { get(d) = value.is_word("auto") ? 0 : value.positive(unit); },
          [get](const D& d) { return get(d) > 0 ? Json(get(d)) : Json("auto"); }};
}

template <class D, class Get>
Option<D> whole_number(const char* key, const char* field, const Get& get, const Range& range,
                       const char* otherwise, const char* doc) {
  return {key,
          field,
          otherwise,
          doc,
          typed("integer", range),
          [get](const Node& value, D& d) { get(d) = value.small_integer(); },
          [get](const D& d) -> Json { return get(d); }};
}

template <class D, class Get>
Option<D> flag(const char* key, const char* field, const Get& get, const char* otherwise, const char* doc) {
  return {key,
          field,
          otherwise,
          doc,
          {{"type", "boolean"}},
          [get](const Node& value, D& d) { get(d) = value.boolean(); },
          [get](const D& d) -> Json { return get(d); }};
}

/// An enumeration, or a bool, whose values are `words` in order.
template <class D, class Get>
Option<D> word(const char* key, const char* field, const Get& get, const keys::List& words,
               const char* otherwise, const char* doc) {
  return {key,
          field,
          otherwise,
          doc,
          {{"enum", words}},
          [get, words](const Node& value, D& d) {
            const std::string chosen = value.choice(words);
            std::size_t at = 0;
            while (words[at] != chosen) ++at;
            using Value = std::decay_t<decltype(get(d))>;
            get(d) = static_cast<Value>(at);
          },
          [get, words](const D& d) -> Json { return words.at(static_cast<std::size_t>(get(d))); }};
}

/// Whatever needs code of its own.
template <class D>
Option<D> custom(const char* key, const char* field, const char* otherwise, const char* doc, Json schema,
                 std::function<void(const Node&, D&)> load, std::function<Json(const D&)> echo) {
  return {key, field, otherwise, doc, std::move(schema), std::move(load), std::move(echo)};
}

}  // namespace runner
