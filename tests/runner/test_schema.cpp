// SPDX-License-Identifier: Apache-2.0
// scene.schema.json and the reader must know the same keys and words.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "scene_options.hpp"

namespace runner {
namespace {

const char* const schema_file = SCENES_DIRECTORY "/scene.schema.json";
const char* const manual_file = SCENES_DIRECTORY "/../../docs/runner.md";

const Json& schema() {
  static const Json json = Json::parse(std::ifstream(schema_file));
  return json;
}

keys::List sorted(keys::List list) {
  std::sort(list.begin(), list.end());
  return list;
}

keys::List properties(const Json& object) {
  EXPECT_EQ(object.at("additionalProperties"), false);
  keys::List list;
  for (const auto& [key, value] : object.at("properties").items()) list.push_back(key);
  return sorted(list);
}

keys::List words(const Json& value) { return sorted(value.at("enum").get<keys::List>()); }

TEST(Schema, KnowsTheKeysOfTheReader) {
  const Json& top = schema().at("properties");
  const Json& defs = schema().at("$defs");
  EXPECT_EQ(properties(schema()), sorted(keys::scene));
  EXPECT_EQ(properties(top.at("domain").at("properties").at("walls").at("oneOf").at(1)), sorted(keys::faces));
  EXPECT_EQ(properties(top.at("output")), sorted(keys::output));
  EXPECT_EQ(properties(top.at("output").at("properties").at("camera")), sorted(keys::camera));
  EXPECT_EQ(properties(top.at("output").at("properties").at("picture")), sorted(keys::picture));
  EXPECT_EQ(properties(top.at("output").at("properties").at("surface")), sorted(keys::surface));
  EXPECT_EQ(properties(top.at("trade")), sorted(keys::trade));
  std::string words = "^(";
  for (const std::string& word : keys::observables) words += (words.size() > 2 ? "|" : "") + word;
  EXPECT_EQ(top.at("trade").at("properties").at("observe").at("items").at("pattern").get<std::string>(),
            words + ")(@.+)?$");
  EXPECT_EQ(properties(defs.at("fluid")), sorted(keys::fluid));
  EXPECT_EQ(properties(defs.at("body")), sorted(keys::body));
  EXPECT_EQ(properties(defs.at("emitter")), sorted(keys::emitter));
  EXPECT_EQ(properties(defs.at("emitter").at("properties").at("nozzle")), sorted(keys::nozzle));
  EXPECT_EQ(properties(defs.at("probe")), sorted(keys::probe));
  EXPECT_EQ(properties(defs.at("heat_region")), sorted(keys::heat_region));
  EXPECT_EQ(properties(defs.at("force_field")), sorted(keys::field));
  EXPECT_EQ(properties(top.at("heat").at("properties").at("walls")), sorted(keys::faces));
}

/// Markdown without links and marks of code.
std::string plain(const std::string& doc) {
  static const std::regex link("\\[([^\\]]*)\\]\\([^)]*\\)");
  std::string text = std::regex_replace(doc, link, "$1");
  text.erase(std::remove(text.begin(), text.end(), '`'), text.end());
  return text;
}

/// What the table of options makes of the schema's properties of a section; what it leaves to the schema stays.
template <class D>
void put_schema(const Options<D>& options, Json& section) {
  Json properties = Json::object();
  for (const Option<D>& option : options) {
    Json& property = properties[option.key];
    if (!option.schema.is_null()) property = option.schema;
    else property = section.value(Json::json_pointer("/properties/" + option.key), Json());
    if (!option.doc.empty()) property["description"] = plain(option.doc);
  }
  section["properties"] = properties;
}

template <class D>
std::string rows(const Options<D>& options, const std::string& section) {
  std::string text;
  for (const Option<D>& option : options) {
    const std::string name = section.empty() ? option.key : section + "." + option.key;
    text += "| `" + name + "` | " + option.otherwise + (option.otherwise.empty() ? "" : " ") + "| " +
            option.doc + " |\n";
  }
  return text;
}

/// Puts rows between the marks of a table, `<!-- name -->` and `<!-- end -->`.
void put_rows(std::string& manual, const std::string& name, const std::string& rows) {
  const std::string mark = "<!-- options of " + name + " -->\n";
  const std::size_t begin = manual.find(mark);
  ASSERT_NE(begin, std::string::npos) << name;
  const std::size_t first = begin + mark.size(), last = manual.find("<!-- end -->", first);
  ASSERT_NE(last, std::string::npos) << name;
  manual.replace(first, last - first, "| key | default | meaning |\n|---|---|---|\n" + rows);
}

std::string text_of(const char* file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The schema and the tables of the manual are what the rows of scene_options.cpp make. With MELTSIM_WRITE_OPTIONS set, both
// are written anew.
TEST(Schema, AndManualFollowFromTheTableOfOptions) {
  Json json = schema();
  std::string manual = text_of(manual_file), sections;
  for (const Section& section : scene_sections()) {
    put_schema(section.options(), json["properties"][section.name]);
    sections += rows(section.options(), section.name);
  }
  put_schema(material_options(), json["$defs"]["material"]);
  put_schema(surface_heat_options(), json["$defs"]["surface_heat"]);
  put_rows(manual, "sections", sections);
  put_rows(manual, "a material", rows(material_options(), ""));
  put_rows(manual, "a surface", rows(surface_heat_options(), ""));
  if (std::getenv("MELTSIM_WRITE_OPTIONS") != nullptr) {
    std::ofstream(schema_file) << json.dump(2) << "\n";
    std::ofstream(manual_file) << manual;
    GTEST_SKIP() << "wrote " << schema_file << " and " << manual_file;
  }
  const char* const fix = "run test_runner with MELTSIM_WRITE_OPTIONS=1";
  EXPECT_EQ(text_of(schema_file), json.dump(2) + "\n") << fix;
  EXPECT_EQ(text_of(manual_file), manual) << fix;
}

TEST(Schema, KnowsTheShapesOfTheReader) {
  const Json& shape = schema().at("$defs").at("shape");
  EXPECT_EQ(properties(shape), sorted(keys::shape));
  EXPECT_EQ(shape.at("oneOf").size(), keys::shapes.size());
  const Json& kinds = shape.at("properties");
  EXPECT_EQ(properties(kinds.at("sphere")), sorted(keys::sphere));
  EXPECT_EQ(properties(kinds.at("capsule")), sorted(keys::rod));
  EXPECT_EQ(properties(kinds.at("cylinder")), sorted(keys::rod));
  EXPECT_EQ(properties(kinds.at("torus")), sorted(keys::torus));
  EXPECT_EQ(properties(kinds.at("blend")), sorted(keys::blend));
  EXPECT_EQ(properties(kinds.at("blend").at("properties").at("ellipsoids").at("items")),
            sorted(keys::ellipsoid));
  EXPECT_EQ(properties(kinds.at("transform")), sorted(keys::transform));
}

TEST(Schema, KnowsTheWordsOfTheReader) {
  const Json& top = schema().at("properties");
  EXPECT_EQ(words(top.at("domain").at("properties").at("walls").at("oneOf").at(0)), sorted(keys::walls));
  EXPECT_EQ(words(top.at("time").at("properties").at("stepping")), sorted(keys::stepping));
  EXPECT_EQ(words(schema().at("$defs").at("body").at("properties").at("motion")), sorted(keys::motion));
  EXPECT_EQ(words(top.at("solver").at("properties").at("neighbour_search")), sorted(keys::neighbour_search));
  EXPECT_EQ(words(top.at("solver").at("properties").at("viscosity")), sorted(keys::viscosity));
  EXPECT_EQ(words(top.at("time").at("properties").at("end_when")), sorted(keys::end_when));
  EXPECT_EQ(words(top.at("heat").at("properties").at("model")), sorted(keys::heat_model));
  EXPECT_EQ(words(top.at("solver").at("properties").at("stray")), sorted(keys::stray));
  EXPECT_EQ(words(top.at("output").at("properties").at("export").at("items")), sorted(keys::formats));
  EXPECT_EQ(words(top.at("output").at("properties").at("picture").at("properties").at("look")),
            sorted(keys::look));
  EXPECT_EQ(words(top.at("output").at("properties").at("surface").at("properties").at("kernel")),
            sorted(keys::surface_kernel));
  const Json& probe = schema().at("$defs").at("probe").at("properties");
  keys::List fields = keys::probe_field;
  fields.insert(fields.end(), keys::force_field.begin(), keys::force_field.end());
  fields.insert(fields.end(), keys::flux_field.begin(), keys::flux_field.end());
  EXPECT_EQ(words(probe.at("fields").at("items")), sorted(fields));
  EXPECT_EQ(words(probe.at("wall")), sorted(keys::one_face));
  EXPECT_EQ(words(schema().at("$defs").at("force_field").at("properties").at("kind")),
            sorted(keys::field_kind));
}

}  // namespace
}  // namespace runner
