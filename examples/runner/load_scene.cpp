// SPDX-License-Identifier: Apache-2.0
#include "load_scene.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/parser.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "builtin.hpp"
#include "check_heat.hpp"
#include "check_units.hpp"
#include "failure.hpp"
#include "load_parts.hpp"
#include "merge_keys.hpp"
#include "overrides.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

// Scenes are written by hand; meshes live in files of their own.
constexpr std::uintmax_t max_scene_bytes = 16u << 20;

/// Reads until the end or the limit.
std::string read_stream(std::istream& stream, const std::string& name) {
  std::string text;
  std::vector<char> block(1u << 16);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > max_scene_bytes) throw Failure(ExitCode::scene, name + ": a scene is at most 16 MB");
  }
  if (stream.bad())
    throw Failure(ExitCode::io, fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
  return text;
}

std::string read_text(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw Failure(ExitCode::io, fmt::format("{}: is a directory; name the scene file in it", path));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Failure(ExitCode::io, fmt::format("{}: cannot be read: {}", path, std::strerror(errno)));
  return read_stream(file, path);
}

/// Counts documents. YAML::LoadAll() would not end where a comma or bracket stands outside of brackets: it is a document
/// each time it is looked at, and stays.
struct Documents : YAML::EventHandler {
  int count = 0;
  void OnDocumentStart(const YAML::Mark&) override { ++count; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
  }
  void OnMapEnd() override {}
};

/// The first line up to this one that a tab indents, from 0; none: -1. The parser does not name what it stumbles over then.
int tab_up_to(const std::string& text, int line) {
  std::istringstream lines(text);
  std::string read;
  for (int n = 0; n <= line && std::getline(lines, read); ++n)
    if (const std::size_t first = read.find_first_not_of(' ');
        first != std::string::npos && read[first] == '\t')
      return n;
  return -1;
}

YAML::Node parse_text(const std::string& text, const std::string& file) {
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Documents documents;
    while (documents.count < 2 && parser.HandleNextDocument(documents)) {
    }
    if (documents.count > 1)
      throw Failure(
          ExitCode::scene,
          file + ": holds more than one YAML document, or a comma or bracket stands where none can");
    if (documents.count == 0)
      throw Failure(ExitCode::scene, file + ": is empty; `meltsim new NAME` writes a scene");
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    if (error.mark.is_null()) throw Failure(ExitCode::scene, fmt::format("{}: {}", file, error.msg));
    if (const int tab = tab_up_to(text, error.mark.line); tab >= 0)
      throw Failure(ExitCode::scene, fmt::format("{}:{}:1: a tab indents this line, and YAML takes spaces "
                                                 "alone; replace the tabs",
                                                 file, tab + 1));
    throw Failure(ExitCode::scene, fmt::format("{}:{}:{}: not valid YAML or JSON: {}", file,
                                               error.mark.line + 1, error.mark.column + 1, error.msg));
  }
}

void check_version(const Node& root) {
  const Node version = root.require("meltsim", "the version of the scene format, \"meltsim: 1\"");
  if (version.integer() != 1) {
    version.fail(
        fmt::format("expected scene format 1, got {}; this program reads format 1 only", version.found()));
  }
}

/// Outputs name things, so a name is given once.
void check_names(const Node& root, const char* section) {
  const auto list = root.find(section);
  if (!list || !list->is_list()) return;
  std::map<std::string, std::string> seen;
  for (const Node& item : list->items("mappings")) {
    const auto name = item.is_mapping() ? item.find("name") : std::nullopt;
    if (!name) continue;
    const auto [first, fresh] = seen.emplace(name->text("a name"), item.path());
    if (!fresh) name->fail(fmt::format("the name {} is taken by {}", name->found(), first->second));
  }
}

void load_sections(const Node& root, Scene& scene) {
  root.require("particles", "{spacing: ...}, the distance of particles (m)");
  for (const Section& section : scene_sections()) {
    const auto node = root.find(section.name);
    if (!node) continue;
    (section.options == domain_options ? load_domain : load_section)(section, *node, scene);
  }
  // Materials come before what is made of them.
  if (const auto node = root.find("materials")) load_materials(*node, scene);
  for (const SceneList& list : scene_lists())
    if (const auto node = root.find(list.name)) list.load(*node, scene);
  for (const SceneList& list : scene_lists())
    if (list.named) check_names(root, list.name);
  check_units(root, scene);
  check_heat(root, scene);
  for (const SceneMaterial& material : scene.materials)
    add_look(scene.output, material.desc.name, material.color);
  for (const SceneBody& body : scene.bodies)
    if (body.density) add_look(scene.output, body.material, *body.density);
}

}  // namespace

void add_look(SceneOutput& output, const std::string& material, std::optional<std::array<double, 3>> color) {
  output.looks.push_back({material, color});
}

std::optional<std::array<double, 3>> look_color(const SceneOutput& output, const std::string& material) {
  for (const SceneLook& look : output.looks)
    if (look.name == material) return look.color;
  return std::nullopt;
}

void add_look(SceneOutput& output, const std::string& material, double density) {
  const std::string name = dense_material(material, density);
  for (const SceneLook& look : output.looks)
    if (look.name == name) return;
  output.looks.push_back({name, look_color(output, material)});
}

std::string dense_material(const std::string& material, double density) {
  return fmt::format("{} ({:g} kg/m^3)", material, density);
}

Scene parse_scene(const std::string& text, const std::string& file, const std::string& directory,
                  const std::vector<std::string>& set_options) {
  YAML::Node yaml = parse_text(text, file);
  if (!yaml.IsMap())
    throw Failure(ExitCode::scene, file + ":1:1: expected a scene, a mapping of keys to values");
  auto document = std::make_shared<Document>();
  document->file = file;
  document->directory = directory;
  try {
    resolve_merge_keys(yaml, file);
    Node(yaml, document).entries();  // a duplicate key must not be hidden by a --set of it
    document->overrides = apply_overrides(yaml, set_options);
    const Node root(yaml, document);
    root.allow_keys(scene_keys());
    check_version(root);
    Scene scene;
    scene.file = file;
    scene.name = std::filesystem::path(file).stem().string();
    scene.where = root.where();
    if (const auto title = root.find("title")) scene.title = title->text("text");
    load_sections(root, scene);
    scene.given_spacing = scene.world.spacing;
    return scene;
  } catch (const YAML::Exception& error) {
    throw Failure(ExitCode::scene, fmt::format("{}: {}", file, error.what()));
  }
}

Scene load_scene(const std::string& file_or_name, const std::vector<std::string>& set_options) {
  if (file_or_name == "-") {
    const std::string text = read_stream(std::cin, "standard input");
    Scene scene = parse_scene(text, "standard input", "", set_options);
    scene.name = "stdin";
    scene.text = text;
    return scene;
  }
  const std::filesystem::path path(file_or_name);
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) {
    return parse_scene(read_text(file_or_name), file_or_name, path.parent_path().string(), set_options);
  }
  if (const BuiltinScene* builtin = find_builtin(file_or_name)) {
    return parse_scene(builtin->text, file_or_name, "", set_options);
  }
  // Pipes and unreadable files too end in a message about the file; a bare word was meant as a name.
  const bool is_path = path.has_extension() || path.has_parent_path() || std::filesystem::exists(path, error);
  if (is_path)
    return parse_scene(read_text(file_or_name), file_or_name, path.parent_path().string(), set_options);
  throw Failure(ExitCode::usage,
                fmt::format("no scene file and no built-in scene is named \"{}\"{}", file_or_name,
                            suggestion(file_or_name, builtin_names(), "built-in scenes")));
}

}  // namespace runner
