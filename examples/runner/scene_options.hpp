// SPDX-License-Identifier: Apache-2.0
// The keys of a scene, one row each: scene_options.cpp has those of its sections and materials, item_options.cpp those of what it
// lists (fluids, bodies, probes, ...). Reading, run.json's echo, the places of errors that only the library finds, the JSON Schema
// and the tables of docs/runner.md follow from these rows.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "echo.hpp"
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
  std::string needed{};                ///< what to write where the key is missing; empty: it may be left out
  keys::List kinds{};    ///< of things that have a kind: the kinds that take the key; empty: all
  std::string points{};  ///< library's name of its points of temperature, which a scene gives as the value
  keys::List others{};   ///< names that people know it by, which are no keys

  Option must_be_given(const char* what) && {
    needed = what;
    return std::move(*this);
  }
  Option of_kinds(keys::List list) && {
    kinds = std::move(list);
    return std::move(*this);
  }
  Option also_called(keys::List names) && {
    others = std::move(names);
    return std::move(*this);
  }
  /// Echoed only where it differs from the default.
  Option echoed_if_set() && {
    echo = [all = std::move(echo)](const D& d) {
      Json json = all(d);
      return json == all(D{}) ? Json() : json;
    };
    return std::move(*this);
  }
};
template <class D>
using Options = std::vector<Option<D>>;

const Options<Scene>& domain_options();
const Options<Scene>& particles_options();
const Options<Scene>& time_options();
const Options<Scene>& solver_options();
const Options<Scene>& heat_options();
const Options<Scene>& solute_options();
const Options<Scene>& output_options();
const Options<Scene>& trade_options();
const Options<SceneMaterial>& material_options();
const Options<meltsim::SurfaceHeatDesc>& surface_heat_options();
const Options<meltsim::OutletDesc>& outlet_options();
const Options<SceneHeatRegion>& heat_region_options();
const Options<SceneFluid>& fluid_options();
const Options<SceneBody>& body_options();
const Options<meltsim::EmitterDesc>& reservoir_options();
const Options<SceneEmitter>& emitter_options();
const Options<meltsim::EmitterDesc>& nozzle_options();
const Options<SceneForceField>& force_field_options();
const Options<SceneProbe>& probe_options();
const Options<Json>& surface_options();  ///< of output.surface, likewise camera and picture
const Options<Json>& camera_options();
const Options<Json>& picture_options();

/// A section of a scene whose keys belong to the whole scene.
struct Section {
  const char* name;
  const Options<Scene>& (*options)();
  Source Scene::*source;
};
const std::vector<Section>& scene_sections();

/// A list of a scene.
struct SceneList {
  const char* name;
  void (*load)(const Node&, Scene&);
  Json (*echo)(const Scene&);
  bool named;  ///< its items have names, each once
};
const std::vector<SceneList>& scene_lists();  ///< in the order of reading
keys::List scene_keys();                      ///< of the whole scene

/// The word that `kind` has, of things whose keys depend on it.
template <class D>
std::string kind_of(const D&) {
  return {};
}
std::string kind_of(const SceneForceField& field);
std::string kind_of(const SceneProbe& probe);

template <class D>
keys::List keys_of(const Options<D>& options) {
  keys::List list;
  for (const Option<D>& option : options) list.push_back(option.key);
  return list;
}

template <class D>
bool takes(const Option<D>& option, const std::string& kind) {
  return option.kinds.empty() ||
         std::find(option.kinds.begin(), option.kinds.end(), kind) != option.kinds.end();
}

/// Names of the library, and others that people know keys by, that are no keys, each with what to write instead.
template <class D>
std::map<std::string, std::string> other_names(const Options<D>& options) {
  std::map<std::string, std::string> names;
  for (const Option<D>& option : options) {
    if (!option.points.empty())
      names[option.points] =
          "give the points as the value of \"" + option.key + "\": [[temperature, value], ...]";
    for (const std::string& other : option.others) names[other] = "did you mean \"" + option.key + "\"?";
    if (!option.field.empty() && option.field != option.key)
      names[option.field] = "did you mean \"" + option.key + "\"?";
  }
  return names;
}

/// Fails: a key that this kind has no use for would be passed over in silence.
[[noreturn]] void refuse_key(const Node& value, const std::string& key, const std::string& kind,
                             const keys::List& kinds);

/// Reads the keys that are there, in the order of the table; others are refused, and those that must be there are asked for.
template <class D>
void load_options(const Node& node, const Options<D>& options, D& to) {
  node.allow_keys(keys_of(options), other_names(options));
  for (const Option<D>& option : options) {
    const auto value = node.find(option.key);
    const bool taken = takes(option, kind_of(to));
    if (value && !taken) refuse_key(*value, option.key, kind_of(to), option.kinds);
    if (value) option.load(*value, to);
    else if (taken && !option.needed.empty()) node.require(option.key, option.needed);
  }
}

template <class D>
Json options_json(const Options<D>& options, const D& from) {
  Json json = Json::object();
  for (const Option<D>& option : options)
    if (takes(option, kind_of(from)))
      if (Json value = option.echo(from); !value.is_null()) json[option.key] = std::move(value);
  return json;
}

/// Reads a list; `finish(node, item)` does what no row can: it looks at other keys, and at other parts of the scene.
template <class D, class Finish>
void load_list(const Node& node, const Options<D>& options, std::vector<D>& list, const Finish& finish) {
  for (const Node& item : node.items(node.path().substr(node.path().rfind('.') + 1))) {
    D d;
    load_options(item, options, d);
    d.source = item.source();
    finish(item, d);
    list.push_back(std::move(d));
  }
}

/// Null for an empty list.
template <class D>
Json list_json(const Options<D>& options, const std::vector<D>& list) {
  Json json;
  for (const D& item : list) json.push_back(options_json(options, item));
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
  return {
      key,
      field,
      otherwise,
      doc,
      typed("number", range),
      [=](const Node& value, D& d) { get(d) = range.above_zero ? value.positive(unit) : value.number(unit); },
      [get](const D& d) -> Json { return get(d) ? Json(*get(d)) : Json(); }};
}

/// A number that may be infinite: an end of time.
template <class D, class Get>
Option<D> time_or_never(const char* key, const char* field, const Get& get, const char* otherwise,
                        const char* doc) {
  return {key,
          field,
          otherwise,
          doc,
          {{"oneOf", {{{"type", "number"}}, {{"enum", {"inf", "infinity", ".inf"}}}}}},
          [get](const Node& value, D& d) { get(d) = value.number_or_infinite("s"); },
          [get](const D& d) { return echo_number(get(d)); }};
}

/// Three numbers, which may be absent: Vec3d or std::optional of it.
template <class D, class Get>
Option<D> vector(const char* key, const char* field, const Get& get, const char* unit, const char* otherwise,
                 const char* doc) {
  return {key,
          field,
          otherwise,
          doc,
          {{"$ref", "#/$defs/vector"}},
          [=](const Node& value, D& d) { get(d) = value.vector(unit); },
          [get](const D& d) { return echo(get(d)); }};
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
          [=](const Node& value, D& d) {
            get(d) = value.is_word("auto") ? 0 : value.positive(std::string(unit) + ", or auto");
          },
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

/// A flag that the World decides on if the scene does not.
template <class D, class Get>
Option<D> automatic_flag(const char* key, const char* field, const Get& get, const char* doc) {
  return {key,
          field,
          "`auto`",
          doc,
          {{"enum", {"auto", true, false}}},
          [get](const Node& value, D& d) {
            if (value.is_word("auto")) get(d) = std::nullopt;
            else get(d) = value.boolean("auto, true or false");
          },
          [get](const D& d) -> Json { return get(d) ? Json(*get(d)) : Json("auto"); }};
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

// The member that a row is about, of a description.
#define MEMBER(path) \
  [](auto& d) -> auto& { return d.path; }

/// Whatever needs code of its own.
template <class D>
Option<D> custom(const char* key, const char* field, const char* otherwise, const char* doc, Json schema,
                 std::function<void(const Node&, D&)> load, std::function<Json(const D&)> echo) {
  return {key, field, otherwise, doc, std::move(schema), std::move(load), std::move(echo)};
}

}  // namespace runner
