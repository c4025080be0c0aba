// SPDX-License-Identifier: Apache-2.0
// scene.schema.json and the reader must know the same keys and words.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "scene_keys.hpp"

namespace runner {
namespace {

using Json = nlohmann::json;

const Json& schema() {
  static const Json json = Json::parse(std::ifstream(SCENES_DIRECTORY "/scene.schema.json"));
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
  EXPECT_EQ(properties(top.at("domain")), sorted(keys::domain));
  EXPECT_EQ(properties(top.at("domain").at("properties").at("walls").at("oneOf").at(1)), sorted(keys::faces));
  EXPECT_EQ(properties(top.at("particles")), sorted(keys::particles));
  EXPECT_EQ(properties(top.at("time")), sorted(keys::time));
  EXPECT_EQ(properties(top.at("solver")), sorted(keys::solver));
  EXPECT_EQ(properties(top.at("heat")), sorted(keys::heat));
  EXPECT_EQ(properties(top.at("solute")), sorted(keys::solute));
  EXPECT_EQ(properties(top.at("output")), sorted(keys::output));
  EXPECT_EQ(properties(top.at("output").at("properties").at("camera")), sorted(keys::camera));
  EXPECT_EQ(properties(top.at("output").at("properties").at("picture")), sorted(keys::picture));
  EXPECT_EQ(properties(top.at("output").at("properties").at("surface")), sorted(keys::surface));
  EXPECT_EQ(properties(top.at("trade")), sorted(keys::trade));
  std::string words = "^(";
  for (const std::string& word : keys::observables) words += (words.size() > 2 ? "|" : "") + word;
  EXPECT_EQ(top.at("trade").at("properties").at("observe").at("items").at("pattern").get<std::string>(),
            words + ")(@.+)?$");
  EXPECT_EQ(properties(defs.at("material")), sorted(keys::material));
  EXPECT_EQ(properties(defs.at("fluid")), sorted(keys::fluid));
  EXPECT_EQ(properties(defs.at("body")), sorted(keys::body));
  EXPECT_EQ(properties(defs.at("emitter")), sorted(keys::emitter));
  EXPECT_EQ(properties(defs.at("emitter").at("properties").at("nozzle")), sorted(keys::nozzle));
  EXPECT_EQ(properties(defs.at("probe")), sorted(keys::probe));
  EXPECT_EQ(properties(defs.at("surface_heat")), sorted(keys::surface_heat));
  EXPECT_EQ(properties(defs.at("heat_region")), sorted(keys::heat_region));
  EXPECT_EQ(properties(top.at("heat").at("properties").at("walls")), sorted(keys::faces));
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
}

}  // namespace
}  // namespace runner
