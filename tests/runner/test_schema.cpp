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
  EXPECT_EQ(properties(schema()), sorted(scene_keys()));
  EXPECT_EQ(properties(top.at("domain").at("properties").at("walls").at("oneOf").at(1)), sorted(keys::faces));
  EXPECT_EQ(properties(top.at("heat").at("properties").at("walls")), sorted(keys::faces));
}

/// Markdown without links and marks of code.
std::string plain(const std::string& doc) {
  static const std::regex link("\\[([^\\]]*)\\]\\([^)]*\\)");
  std::string text = std::regex_replace(doc, link, "$1");
  text.erase(std::remove(text.begin(), text.end(), '`'), text.end());
  return text;
}

/// With the kinds that have the key, where not all have it.
template <class D>
std::string doc_of(const Option<D>& option) {
  if (option.kinds.empty()) return option.doc;
  std::string kinds;
  for (std::size_t i = 0; i < option.kinds.size(); ++i)
    kinds += (i == 0 ? "" : i + 1 == option.kinds.size() ? " and " : ", ") + ("`" + option.kinds[i] + "`");
  return option.doc + (option.kinds.size() == 1 ? "; of kind " : "; of kinds ") + kinds;
}

/// What the table of options makes of the schema's properties of a section; what it leaves to the schema stays.
template <class D>
void put_schema(const Options<D>& options, Json& section) {
  Json properties = Json::object();
  keys::List needed;
  for (const Option<D>& option : options) {
    Json& property = properties[option.key];
    if (!option.schema.is_null()) property = option.schema;
    else property = section.value(Json::json_pointer("/properties/" + option.key), Json());
    if (const std::string doc = doc_of(option); !doc.empty()) property["description"] = plain(doc);
    else property.erase("description");
    if (!option.needed.empty() && option.kinds.empty()) needed.push_back(option.key);
  }
  section["type"] = "object";
  section["additionalProperties"] = false;
  section["properties"] = properties;
  if (!needed.empty()) section["required"] = needed;
}

template <class D>
std::string rows(const Options<D>& options, const std::string& section) {
  std::string text;
  for (const Option<D>& option : options) {
    const std::string name = section.empty() ? option.key : section + "." + option.key;
    const std::string otherwise = option.needed.empty() ? option.otherwise : "must be given";
    text +=
        "| `" + name + "` | " + otherwise + (otherwise.empty() ? "" : " ") + "| " + doc_of(option) + " |\n";
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

// The schema and the tables of the manual are what the rows of the options make. With MELTSIM_WRITE_OPTIONS set, both
// are written anew.
TEST(Schema, AndManualFollowFromTheTableOfOptions) {
  Json json = schema();
  std::string manual = text_of(manual_file), sections;
  const auto put = [&](const auto& options, Json& section, const char* table, const char* prefix) {
    put_schema(options, section);
    put_rows(manual, table, rows(options, prefix));
  };
  Json& top = json["properties"];
  for (const Section& section : scene_sections()) {
    put_schema(section.options(), top[section.name]);
    sections += rows(section.options(), section.name);
  }
  put_rows(manual, "sections", sections);
  Json& defs = json["$defs"];
  put_schema(outlet_options(), defs["outlet"]);
  put(material_options(), defs["material"], "a material", "");
  put(surface_heat_options(), defs["surface_heat"], "a surface", "");
  put(heat_region_options(), defs["heat_region"], "a heat region", "");
  put(fluid_options(), defs["fluid"], "a fluid", "");
  put(body_options(), defs["body"], "a body", "");
  Json& nozzle = defs["emitter"]["properties"]["nozzle"];
  put_schema(nozzle_options(), nozzle);
  put_schema(reservoir_options(), defs["emitter"]["properties"]["reservoir"]);
  put_schema(emitter_options(), defs["emitter"]);
  put_rows(manual, "an emitter",
           rows(emitter_options(), "") + rows(nozzle_options(), "nozzle") +
               rows(reservoir_options(), "reservoir"));
  put(force_field_options(), defs["force_field"], "a force field", "");
  put(probe_options(), defs["probe"], "a probe", "");
  Json& output = top["output"]["properties"];
  put_schema(surface_options(), output["surface"]);
  put_schema(camera_options(), output["camera"]);
  put_schema(picture_options(), output["picture"]);
  put_rows(manual, "outputs",
           rows(surface_options(), "output.surface") + rows(camera_options(), "output.camera") +
               rows(picture_options(), "output.picture"));
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
  const Json& walls = schema().at("properties").at("domain").at("properties").at("walls").at("oneOf").at(0);
  EXPECT_EQ(words(walls), sorted(keys::walls));
}

}  // namespace
}  // namespace runner
