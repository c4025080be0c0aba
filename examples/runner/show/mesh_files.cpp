// SPDX-License-Identifier: Apache-2.0
#include "show/mesh_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "scene.hpp"
#include "show/ramp.hpp"

namespace runner {

namespace {

using meltsim::Vec3f;

template <class T>
void append(std::string& to, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  to.append(bytes, sizeof(T));
}

Mesh placeholder() {
  Mesh mesh;
  mesh.position = {{0, 0, 0}, {1e-6f, 0, 0}, {0, 0, -1e-6f}};
  mesh.normal.assign(3, {0, 1, 0});
  mesh.temperature.assign(3, 0);
  mesh.body.assign(3, 0);
  mesh.material.assign(3, 0);
  mesh.triangles = {0, 1, 2};
  return mesh;
}

/// Comments, one a line behind `mark`.
std::string comments(const char* mark, bool empty, double time) {
  std::string text =
      fmt::format("{0} meltsim surface\n{0} time_s {1:.9g}\n{0} units m, degrees Celsius\n", mark, time);
  if (empty) text += fmt::format("{} {}: this frame has no such surface\n", mark, placeholder_word);
  return text;
}

/// Names in OBJ end at a space.
std::string one_word(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

Rgb warmth_of(float temperature, double cold, double hot) {
  return ramp((temperature - cold) / std::max(hot - cold, 1e-9));
}

/// The parts of a GLB file: JSON that points into one block of bytes.
class Glb {
 public:
  explicit Glb(Json& json) : json_(json) {}

  /// Returns the accessor's number. glTF wants bounds of positions.
  template <class T>
  std::size_t add(const std::vector<T>& values, const char* type, int component, int target,
                  const Json& bounds = {}) {
    const std::size_t components = sizeof(T) / 4;
    const Json view{{"buffer", 0},
                    {"byteOffset", bytes_.size()},
                    {"byteLength", values.size() * sizeof(T)},
                    {"target", target}};
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    json_["bufferViews"].push_back(view);
    Json accessor{{"bufferView", json_["bufferViews"].size() - 1},
                  {"componentType", component},
                  {"count", values.size()},
                  {"type", components == 1 ? "SCALAR" : type}};
    if (!bounds.is_null()) accessor.update(bounds);
    json_["accessors"].push_back(accessor);
    return json_["accessors"].size() - 1;
  }
  std::string take_bytes() { return std::move(bytes_); }

 private:
  Json& json_;
  std::string bytes_;
};

constexpr std::size_t first_look = 2;  ///< materials of a scene come after these: liquid, solid
constexpr int gl_float = 5126, gl_unsigned = 5125, gl_vertices = 34962, gl_indices = 34963;

Json bounds_of(const std::vector<Vec3f>& points) {
  Box box;
  for (const Vec3f& x : points) box.add(meltsim::cast<double>(x));
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

/// What the vertices of a mesh have, but for colours.
Json vertex_attributes(Glb& glb, const Mesh& mesh) {
  const std::vector<float> numbers(mesh.material.begin(),
                                   mesh.material.end());  // as glTF wants its own to be
  return {{"POSITION", glb.add(mesh.position, "VEC3", gl_float, gl_vertices, bounds_of(mesh.position))},
          {"NORMAL", glb.add(mesh.normal, "VEC3", gl_float, gl_vertices)},
          {"_TEMPERATURE", glb.add(mesh.temperature, "SCALAR", gl_float, gl_vertices)},
          {"_MATERIAL", glb.add(numbers, "SCALAR", gl_float, gl_vertices)}};
}

/// Colours of the temperatures of a mesh's vertices.
std::size_t add_warmth(Glb& glb, const Mesh& mesh, double cold, double hot) {
  std::vector<Vec3f> colors;
  for (const float t : mesh.temperature) {
    const Rgb c = linear(warmth_of(t, cold, hot));  // as glTF's colours are
    colors.push_back(meltsim::cast<float>(meltsim::Vec3d{c[0], c[1], c[2]}));
  }
  return glb.add(colors, "VEC3", gl_float, gl_vertices);
}

/// Some triangles in one material; `colors` of their vertices, if any.
Json primitive_json(Glb& glb, const Json& attributes, std::optional<std::size_t> colors,
                    const std::vector<std::uint32_t>& triangles, std::size_t material) {
  Json primitive;
  primitive["attributes"] = attributes;
  if (colors) primitive["attributes"]["COLOR_0"] = *colors;
  primitive["indices"] = glb.add(triangles, "SCALAR", gl_unsigned, gl_indices);
  primitive["material"] = material;
  return primitive;
}

void put_node(Json& json, const std::string& mesh, const std::string& node, const Json& primitives,
              const meltsim::Vec3d& origin) {
  json["meshes"].push_back({{"name", mesh}, {"primitives", primitives}});
  json["nodes"].push_back(
      {{"name", node}, {"mesh", json["meshes"].size() - 1}, {"translation", {origin.x, origin.y, origin.z}}});
}

void add_node(Json& json, Glb& glb, const Mesh& given, const meltsim::Vec3d& origin, const std::string& name,
              std::size_t material, double cold, double hot, const std::vector<SceneLook>& looks) {
  const Mesh mesh = given.empty() ? placeholder() : given;
  const Json attributes = vertex_attributes(glb, mesh);
  const std::size_t warmth = add_warmth(glb, mesh, cold, hot);
  // Those without a colour are one part, -1.
  const auto part_of = [&](std::size_t t) {
    const std::uint32_t m = material_of_triangle(mesh, t);
    return !given.empty() && color_of(looks, m) != nullptr ? static_cast<int>(m) : -1;
  };
  Json primitives = Json::array();
  for (const auto& [part, triangles] : grouped(mesh, part_of)) {
    if (part < 0) primitives.push_back(primitive_json(glb, attributes, warmth, triangles, material));
    else
      primitives.push_back(primitive_json(glb, attributes, std::nullopt, triangles,
                                          first_look + static_cast<std::size_t>(part)));
  }
  put_node(json, name, given.empty() ? name + " " + placeholder_word : name, primitives, origin);
}

/// Whether liquids of different colours are in it.
bool is_mixed(const Mesh& mesh, const std::vector<SceneLook>& looks) {
  std::set<std::uint32_t> colored;
  for (const std::uint32_t m : mesh.material)
    if (color_of(looks, m) != nullptr) colored.insert(m);
  for (const std::uint32_t m : mesh.species)
    if (color_of(looks, m) != nullptr) return true;
  return colored.size() > 1;
}

/// Liquids of different colours: what has a colour is one part whose vertices carry it, of the material `dyed`.
void add_mixed_node(Json& json, Glb& glb, const FrameShapes& split, std::size_t dyed, double cold,
                    double hot) {
  const Json attributes = vertex_attributes(glb, split.liquid);  // both parts have the same vertices
  Json primitives = Json::array();
  if (!split.liquid.empty()) {
    const std::size_t warmth = add_warmth(glb, split.liquid, cold, hot);
    primitives.push_back(primitive_json(glb, attributes, warmth, split.liquid.triangles, 0));
  }
  if (!split.paint.empty()) {
    const std::size_t colors = glb.add(split.paint.color, "VEC3", gl_float, gl_vertices);
    primitives.push_back(primitive_json(glb, attributes, colors, split.paint.triangles, dyed));
  }
  put_node(json, "liquid", "liquid", primitives, split.origin);
}

/// The whole file.
std::string glb_file(Json json, std::string bytes) {
  json["buffers"] = Json::array({{{"byteLength", bytes.size()}}});
  std::string head = json.dump();
  head.resize((head.size() + 3) / 4 * 4, ' ');
  bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
  std::string file = "glTF";
  append<std::uint32_t>(file, 2);
  append(file, static_cast<std::uint32_t>(12 + 8 + head.size() + 8 + bytes.size()));
  append(file, static_cast<std::uint32_t>(head.size()));
  file += "JSON" + head;
  append(file, static_cast<std::uint32_t>(bytes.size()));
  file.append("BIN\0", 4);
  return file + bytes;
}

/// The header of a surface as PLY; `contents`: the columns of what is dissolved.
std::string mesh_ply_head(const Mesh& mesh, const std::string& said,
                          const std::vector<std::string>& contents) {
  std::string text = "ply\nformat binary_little_endian 1.0\n" + said +
                     fmt::format("element vertex {}\n", mesh.position.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "temperature"})
    text += fmt::format("property float {}\n", name);
  text += "property int body\nproperty int material\n";
  for (const std::string& name : contents) text += fmt::format("property float {}\n", name);
  return text + fmt::format("element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
                            mesh.triangles.size() / 3);
}

}  // namespace

std::string mesh_ply_text(const Mesh& given, const meltsim::Vec3d& origin, double time,
                          const std::vector<std::string>& contents) {
  const Mesh stand_in = given.empty() ? placeholder() : Mesh{};
  const Mesh& mesh = given.empty() ? stand_in : given;
  const std::size_t vertices = mesh.position.size(), faces = mesh.triangles.size() / 3,
                    species = std::min(mesh.contents.size(), contents.size());
  std::string text =
      mesh_ply_head(mesh, comments("comment", given.empty(), time),
                    {contents.begin(), contents.begin() + static_cast<std::ptrdiff_t>(species)});
  const std::size_t vertex_bytes = 36 + 4 * species, face_bytes = 13,  // of what is put below
      head = text.size();
  text.resize(head + vertices * vertex_bytes + faces * face_bytes);
  char* to = text.data() + head;
  const auto put = [&to](const auto& value) {
    std::memcpy(to, &value, sizeof(value));
    to += sizeof(value);
  };
  // Where arrays lie is read once, not again behind every byte that is written.
  const Vec3f *const position = mesh.position.data(), *const normal = mesh.normal.data();
  const float* const temperature = mesh.temperature.data();
  const std::uint32_t *const body = mesh.body.data(), *const material = mesh.material.data(),
                             *const corner = mesh.triangles.data();
  for (std::size_t i = 0; i < vertices; ++i) {
    put(meltsim::cast<float>(origin + meltsim::cast<double>(position[i])));
    put(normal[i]);
    put(temperature[i]);
    put(static_cast<std::int32_t>(body[i]) - 1);
    put(static_cast<std::int32_t>(material[i]));
    for (std::size_t k = 0; k < species; ++k) put(mesh.contents[k][i]);
  }
  for (std::size_t t = 0; t < faces; ++t) {
    put(std::uint8_t{3});
    for (std::size_t k = 0; k < 3; ++k) put(corner[3 * t + k]);
  }
  return text;
}

std::string mesh_obj_text(const Mesh& given, const meltsim::Vec3d& origin, double time,
                          const std::string& name, double cold, double hot,
                          const std::vector<SceneLook>& looks) {
  const Mesh mesh = given.empty() ? placeholder() : given;
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  fmt::format_to(
      to,
      "{}# vt: temperature, 0. Colours of v: red-yellow-blue from {:.6g} to {:.6g} degrees Celsius\no {}\n",
      comments("#", given.empty(), time), cold, hot, name);
  for (std::size_t i = 0; i < mesh.position.size(); ++i) {
    const meltsim::Vec3d x = origin + meltsim::cast<double>(mesh.position[i]);
    const Rgb c = warmth_of(mesh.temperature[i], cold, hot);
    fmt::format_to(to, "v {:.7g} {:.7g} {:.7g} {:.4f} {:.4f} {:.4f}\n", x.x, x.y, x.z, c[0], c[1], c[2]);
  }
  for (const float t : mesh.temperature) fmt::format_to(to, "vt {:.6g} 0\n", t);
  for (const Vec3f& n : mesh.normal) fmt::format_to(to, "vn {:.5f} {:.5f} {:.5f}\n", n.x, n.y, n.z);
  const auto of_material = [&mesh](std::size_t t) { return material_of_triangle(mesh, t); };
  for (const auto& [material, triangles] : grouped(mesh, of_material)) {
    if (material < looks.size()) fmt::format_to(to, "usemtl {}\n", one_word(looks[material].name));
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
      fmt::format_to(to, "f {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2}\n", triangles[t] + 1, triangles[t + 1] + 1,
                     triangles[t + 2] + 1);
    }
  }
  return fmt::to_string(out);
}

std::string glb_text(const FrameShapes& shapes, double cold, double hot, const std::vector<SceneLook>& looks,
                     const meltsim::Vec3d& up) {
  Json json;
  json["asset"] = {{"version", "2.0"}, {"generator", "meltsim"}};
  json["scene"] = 0;
  json["scenes"] = Json::array({{{"nodes", {0, 1}}, {"extras", {{"time_s", shapes.time}}}}});
  const auto material = [](const std::string& name, Rgb color, double alpha, double roughness) {
    Json m{{"name", name},
           {"pbrMetallicRoughness",
            {{"baseColorFactor", {color[0], color[1], color[2], alpha}},
             {"metallicFactor", 0},
             {"roughnessFactor", roughness}}}};
    if (alpha < 1) m["alphaMode"] = "BLEND";
    return m;
  };
  json["materials"] = {material("liquid", {1, 1, 1}, 0.6, 0.1), material("solid", {1, 1, 1}, 1, 0.6)};
  for (const SceneLook& look : looks)
    json["materials"].push_back(material(look.name, linear(look.color.value_or(Rgb{1, 1, 1})), 1, 0.4));
  Glb glb(json);
  if (!shapes.liquid.empty() && is_mixed(shapes.liquid, looks)) {
    json["materials"].push_back(material("dyed", {1, 1, 1}, 1, 0.4));
    add_mixed_node(json, glb, split_liquid(shapes, looks), json["materials"].size() - 1, cold, hot);
  } else {
    add_node(json, glb, shapes.liquid, shapes.origin, "liquid", 0, cold, hot, looks);
  }
  add_node(json, glb, shapes.solid, shapes.origin, "solid", 1, cold, hot, looks);
  if (!is_along(up, {0, 1, 0})) {
    const Json children = std::exchange(json["scenes"][0]["nodes"], Json::array({json["nodes"].size()}));
    json["nodes"].push_back({{"name", "upright"}, {"rotation", turn_upright(up)}, {"children", children}});
  }
  return glb_file(std::move(json), glb.take_bytes());
}

}  // namespace runner
