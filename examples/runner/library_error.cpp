// SPDX-License-Identifier: Apache-2.0
#include "library_error.hpp"

#include <fmt/format.h>

#include <cctype>
#include <optional>
#include <regex>

#include "scene_options.hpp"

namespace runner {

namespace {

bool is_word_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Position of `word` in `text` as a whole word.
std::size_t find_word(const std::string& text, const std::string& word) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    const bool starts = at == 0 || !is_word_letter(text[at - 1]);
    const bool ends = end == text.size() || !is_word_letter(text[end]);
    if (starts && ends) return at;
  }
  return std::string::npos;
}

/// Where a key stands, or the mapping when the scene left it to its default.
FieldPlace place(const Source& source, const std::string& field, const std::string& key,
                 const std::string& fallback) {
  const auto found = source.keys.find(key);
  const std::string whole = source.where.empty() ? fallback : source.where;
  return {field, source.path + "." + key, found == source.keys.end() ? whole : found->second};
}

}  // namespace

ExitCode exit_code(meltsim::ErrorCode code) {
  using meltsim::ErrorCode;
  switch (code) {
    case ErrorCode::no_device:
    case ErrorCode::out_of_memory:
    case ErrorCode::version_mismatch:
    case ErrorCode::internal:
      return ExitCode::device;
    case ErrorCode::halted:
      return ExitCode::diverged;
    case ErrorCode::corrupt_data:
      return ExitCode::io;
    case ErrorCode::invalid_argument:
    case ErrorCode::capacity:
    case ErrorCode::step_too_large:
    case ErrorCode::interrupted:
      break;
  }
  return ExitCode::scene;
}

namespace {

/// Messages of the library read `field: what is wrong` or `material "ice": field: what is wrong`.
std::optional<Failure> named_field(const std::string& message, const std::vector<FieldPlace>& places) {
  static const std::regex form("^(?:\\w+(?: \"[^\"]*\")?: )?([\\w.]+): ([^]*)$");
  std::smatch match;
  if (!std::regex_match(message, match, form)) return std::nullopt;
  for (const FieldPlace& place : places) {
    if (place.field != match[1].str()) continue;
    return Failure(ExitCode::scene, fmt::format("{}: {}: {}", place.where, place.path, match[2].str()));
  }
  return std::nullopt;
}

}  // namespace

Failure library_failure(const meltsim::Error& error, const std::vector<FieldPlace>& places,
                        const std::string& path, const std::string& where) {
  const ExitCode code = exit_code(error.code);
  if (code != ExitCode::scene) return {code, error.message};
  if (const auto failure = named_field(error.message, places)) return *failure;
  std::string best_path = path, best_where = where, best_field;
  std::size_t best = std::string::npos;
  for (const FieldPlace& place : places) {
    const std::size_t at = find_word(error.message, place.field);
    if (at >= best) continue;
    best = at;
    best_path = place.path;
    best_where = place.where;
    best_field = place.field;
  }
  // A message that begins with a part of the field, "domain.heat[-x].convection: ...", already says where: in the library's words.
  const std::size_t end = best_field.size();
  if (best == 0 && end > 0 && end < error.message.size() &&
      (error.message[end] == '.' || error.message[end] == '['))
    return {code, fmt::format("{}: {}{}", best_where, best_path, error.message.substr(end))};
  const std::string subject = best_path.empty() ? "" : best_path + ": ";
  return {code, fmt::format("{}: {}{}", best_where, subject, error.message)};
}

std::vector<FieldPlace> world_places(const Scene& scene) {
  std::vector<FieldPlace> places;
  for (const Section& section : scene_sections()) {
    Source named = scene.*section.source;
    named.path = section.name;
    for (const Option<Scene>& option : section.options()) {
      if (option.field.empty()) continue;
      const bool of_domain = section.options == domain_options;
      const std::string field = of_domain ? "domain." + option.field : option.field;
      places.push_back(place(named, field, option.key, scene.where));
    }
  }
  places.push_back({"domain", "domain", scene.domain.where.empty() ? scene.where : scene.domain.where});
  return places;
}

namespace {

/// What is given, by its key; and fields that have another name in the library, wherever they stand.
template <class D>
std::vector<FieldPlace> places_of(const Source& source, const Options<D>& options) {
  std::vector<FieldPlace> places;
  for (const auto& [key, where] : source.keys) places.push_back({key, source.path + "." + key, where});
  for (const Option<D>& option : options)
    for (const std::string& name : {option.field, option.points})
      if (!name.empty() && name != option.key)
        places.push_back(place(source, name, option.key, source.where));
  return places;
}

}  // namespace

std::vector<FieldPlace> item_places(const SceneMaterial& material) {
  return places_of(material.source, material_options());
}
std::vector<FieldPlace> item_places(const SceneFluid& fluid) {
  return places_of(fluid.source, fluid_options());
}
std::vector<FieldPlace> item_places(const SceneBody& body) { return places_of(body.source, body_options()); }
std::vector<FieldPlace> item_places(const SceneHeatRegion& region) {
  return places_of(region.source, heat_region_options());
}
std::vector<FieldPlace> item_places(const SceneForceField& field) {
  return places_of(field.source, force_field_options());
}
std::vector<FieldPlace> item_places(const SceneProbe& probe) {
  return places_of(probe.source, probe_options());
}
std::vector<FieldPlace> item_places(const SceneEmitter& emitter) {
  std::vector<FieldPlace> places = places_of(emitter.source, emitter_options());
  for (const auto& [part, options] :
       {std::pair{"nozzle.", &nozzle_options()}, std::pair{"reservoir.", &reservoir_options()}})
    for (const Option<meltsim::EmitterDesc>& option : *options)
      if (const auto at = emitter.source.keys.find(part + option.key); at != emitter.source.keys.end())
        places.push_back({option.field, emitter.source.path + "." + part + option.key, at->second});
  return places;
}

}  // namespace runner
