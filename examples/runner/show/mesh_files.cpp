// SPDX-License-Identifier: Apache-2.0
#include "show/mesh_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <iterator>
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
  mesh.liquid_fraction.assign(3, 0);
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

constexpr int gl_float = 5126, gl_unsigned = 5125, gl_vertices = 34962, gl_indices = 34963;

Json bounds_of(const std::vector<Vec3f>& points) {
  Box box;
  for (const Vec3f& x : points) box.add(meltsim::cast<double>(x));
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

/// "w_sugar" as glTF writes attributes of one's own: _W_SUGAR.
std::string attribute_name(std::string column, const Json& taken) {
  for (char& c : column) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  column = "_" + column;
  while (taken.contains(column)) column += "_";
  return column;
}

/// What the vertices of a mesh have, but for colours. glTF wants numbers of one's own as float.
Json vertex_attributes(Glb& glb, const Mesh& mesh, const std::vector<std::string>& contents) {
  const auto scalars = [&glb](const std::vector<float>& values) {
    return glb.add(values, "SCALAR", gl_float, gl_vertices);
  };
  std::vector<float> bodies;
  for (const std::uint32_t body : mesh.body) bodies.push_back(static_cast<float>(body) - 1);
  Json attributes{
      {"POSITION", glb.add(mesh.position, "VEC3", gl_float, gl_vertices, bounds_of(mesh.position))},
      {"NORMAL", glb.add(mesh.normal, "VEC3", gl_float, gl_vertices)},
      {"_TEMPERATURE", scalars(mesh.temperature)},
      {"_BODY", scalars(bodies)},
      {"_MATERIAL", scalars({mesh.material.begin(), mesh.material.end()})}};
  if (mesh.liquid_fraction.size() == mesh.position.size())
    attributes["_LIQUID_FRACTION"] = scalars(mesh.liquid_fraction);
  for (std::size_t k = 0; k < std::min(mesh.contents.size(), contents.size()); ++k)
    attributes[attribute_name(contents[k], attributes)] = scalars(mesh.contents[k]);
  return attributes;
}

/// Clear liquid refracts light; what importers lack of these extensions they leave out.
Json material_json(const PartLook& look) {
  const Rgb color = look.by_vertex ? Rgb{1, 1, 1} : look.color;
  const double alpha = look.clear ? 1 : look.opacity;
  Json material{{"name", look.name},
                {"pbrMetallicRoughness",
                 {{"baseColorFactor", {color[0], color[1], color[2], alpha}},
                  {"metallicFactor", 0},
                  {"roughnessFactor", look.roughness}}}};
  if (alpha < 1) material["alphaMode"] = "BLEND";
  if (look.clear)
    material["extensions"] = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                              {"KHR_materials_ior", {{"ior", water_ior}}}};
  return material;
}

/// The number of a look among the materials of the file, which has only those that appear in it.
std::size_t material_number(Json& json, const PartLook& look) {
  Json& materials = json["materials"];
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (materials[i]["name"] == look.name) return i;
  materials.push_back(material_json(look));
  if (look.clear) json["extensionsUsed"] = {"KHR_materials_transmission", "KHR_materials_ior"};
  return materials.size() - 1;
}

/// A primitive per material.
Json primitives_json(Json& json, Glb& glb, const PartedMesh& parted, const PartLooks& looks,
                     const std::vector<std::string>& contents) {
  Json primitives = Json::array();
  const Json attributes = vertex_attributes(glb, parted.mesh, contents);
  for (const auto& [look, triangles] : parted.triangles) {
    Json primitive;
    primitive["attributes"] = attributes;
    if (looks.all[look].by_vertex)
      primitive["attributes"]["COLOR_0"] = glb.add(parted.mesh.color, "VEC3", gl_float, gl_vertices);
    primitive["indices"] = glb.add(triangles, "SCALAR", gl_unsigned, gl_indices);
    primitive["material"] = material_number(json, looks.all[look]);
    primitives.push_back(primitive);
  }
  return primitives;
}

void add_node(Json& json, Glb& glb, PartedMesh parted, std::size_t empty_look, const meltsim::Vec3d& origin,
              const std::string& name, const PartLooks& looks, const std::vector<std::string>& contents) {
  const bool empty = parted.triangles.empty();
  if (empty) {
    parted.mesh = placeholder();
    parted.mesh.color.assign(3, {1, 1, 1});
    parted.triangles[empty_look] = parted.mesh.triangles;
  }
  const Json primitives = primitives_json(json, glb, parted, looks, contents);
  json["meshes"].push_back({{"name", name}, {"primitives", primitives}});
  json["nodes"].push_back({{"name", empty ? name + " " + placeholder_word : name},
                           {"mesh", json["meshes"].size() - 1},
                           {"translation", {origin.x, origin.y, origin.z}}});
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

/// Numbers of vertices that not every mesh has.
struct Column {
  std::string name;
  const float* values;
};

std::vector<Column> columns_of(const Mesh& mesh, const std::vector<std::string>& contents) {
  std::vector<Column> columns;
  if (mesh.liquid_fraction.size() == mesh.position.size())
    columns.push_back({"liquid_fraction", mesh.liquid_fraction.data()});
  for (std::size_t k = 0; k < std::min(mesh.contents.size(), contents.size()); ++k)
    columns.push_back({contents[k], mesh.contents[k].data()});
  return columns;
}

/// The header of a surface as PLY; `more` stands behind the other properties.
std::string mesh_ply_head(const Mesh& mesh, const std::string& said, const std::vector<Column>& more) {
  std::string text = "ply\nformat binary_little_endian 1.0\n" + said +
                     fmt::format("element vertex {}\n", mesh.position.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "temperature"})
    text += fmt::format("property float {}\n", name);
  text += "property int body\nproperty int material\n";
  for (const Column& column : more) text += fmt::format("property float {}\n", column.name);
  return text + fmt::format("element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
                            mesh.triangles.size() / 3);
}

}  // namespace

std::string mesh_ply_text(const Mesh& given, const meltsim::Vec3d& origin, double time,
                          const std::vector<std::string>& contents) {
  const Mesh stand_in = given.empty() ? placeholder() : Mesh{};
  const Mesh& mesh = given.empty() ? stand_in : given;
  const std::size_t vertices = mesh.position.size(), faces = mesh.triangles.size() / 3;
  const std::vector<Column> more = columns_of(mesh, contents);
  std::string text = mesh_ply_head(mesh, comments("comment", given.empty(), time), more);
  const std::size_t vertex_bytes = 36 + 4 * more.size(), face_bytes = 13,  // of what is put below
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
    for (const Column& column : more) put(column.values[i]);
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

std::string glb_text(const FrameShapes& shapes, const PartLooks& looks,
                     const std::vector<std::string>& contents, const meltsim::Vec3d& up) {
  Json json;
  json["asset"] = {{"version", "2.0"}, {"generator", "meltsim"}};
  json["scene"] = 0;
  json["scenes"] = Json::array({{{"nodes", {0, 1}}, {"extras", {{"time_s", shapes.time}}}}});
  json["materials"] = Json::array();
  Glb glb(json);
  add_node(json, glb, liquid_parts(shapes, looks), looks.liquid.front(), shapes.origin, "liquid", looks,
           contents);
  add_node(json, glb, solid_parts(shapes, looks), looks.solid.front(), shapes.origin, "solid", looks,
           contents);
  if (!is_along(up, {0, 1, 0})) {
    const Json children = std::exchange(json["scenes"][0]["nodes"], Json::array({json["nodes"].size()}));
    json["nodes"].push_back({{"name", "upright"}, {"rotation", turn_upright(up)}, {"children", children}});
  }
  return glb_file(std::move(json), glb.take_bytes());
}

}  // namespace runner
