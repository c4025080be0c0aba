// SPDX-License-Identifier: Apache-2.0
#include "show/ply_reader.hpp"

#include <algorithm>
#include <cstring>
#include <sstream>

#include "failure.hpp"
#include "files.hpp"
#include "numbers.hpp"
#include "show/mesh_files.hpp"

namespace runner {

namespace {

[[noreturn]] void fail(const std::string& path) {
  throw Failure(ExitCode::io,
                path + ": is not a whole file of frames as `meltsim run` writes them; run the scene again");
}

/// The header, and where the data starts.
struct Ply {
  const std::string& path;
  std::string data;
  std::string vertex_properties;  ///< "x y z ", as they follow each other
  std::uint64_t vertices = 0, faces = 0;
  double time = 0;
  bool placeholder = false;
  std::size_t at = 0;

  explicit Ply(const std::string& file) : path(file), data(read_file(file)) {
    const std::string last = "end_header\n";
    const std::size_t end = data.find(last);
    if (data.compare(0, 4, "ply\n") != 0 || end == std::string::npos) fail(path);
    at = end + last.size();
    std::istringstream header(data.substr(0, end));
    std::string line;
    bool in_vertex = false;
    while (std::getline(header, line)) {
      std::istringstream words(line);
      std::string first, second, third;
      words >> first >> second >> third;
      if (first == "comment" && second == "time_s") time = parse_number(third).value_or(0);
      if (first == "comment" && second.find(placeholder_word) == 0) placeholder = true;
      if (first == "element") {
        const auto count = parse_integer(third);
        if (!count || *count < 0) fail(path);
        in_vertex = second == "vertex";
        (in_vertex ? vertices : faces) = static_cast<std::uint64_t>(*count);
      }
      if (first == "property" && in_vertex) vertex_properties += third + " ";
    }
  }
  /// Whether `material` follows these properties; frames of earlier versions lack it. Fails where there are
  /// others.
  bool has_material(const std::string& properties) const {
    const bool has = vertex_properties == properties + "material ";
    if (!has && vertex_properties != properties) fail(path);
    return has;
  }
  /// How many columns of what is dissolved, w_..., stand behind these properties and no others.
  std::size_t species_behind(const std::string& properties) const {
    if (vertex_properties.compare(0, properties.size() + 2, properties + "w_") != 0) return 0;
    const auto count = static_cast<std::size_t>(
        std::count(vertex_properties.begin() + static_cast<std::ptrdiff_t>(properties.size()),
                   vertex_properties.end(), ' '));
    if (count > meltsim::most_species) fail(path);
    return count;
  }
  void expect_left(std::uint64_t count, std::size_t size) const {
    if (count > (data.size() - at) / size) fail(path);
  }
  template <class T>
  T take() {
    T value;
    std::memcpy(&value, data.data() + at, sizeof(T));
    at += sizeof(T);
    return value;
  }
};

}  // namespace

std::vector<FrameParticle> read_particles_ply(const std::string& path, double& time) {
  Ply ply(path);
  const std::string first = "x y z vx vy vz temperature phase body id ",
                    whole = first + "material liquid_fraction ";
  const std::size_t species = ply.species_behind(whole);
  const bool has_fraction = species > 0 || ply.vertex_properties == whole,
             has_material = has_fraction || ply.has_material(first);
  ply.expect_left(ply.vertices, has_fraction ? 45 + species * sizeof(float) : has_material ? 41 : 37);
  time = ply.time;
  std::vector<FrameParticle> list(ply.vertices);
  for (FrameParticle& p : list) {
    for (float& x : p.position) x = ply.take<float>();
    for (float& v : p.velocity) v = ply.take<float>();
    p.temperature = ply.take<float>();
    p.phase = ply.take<std::uint8_t>();
    p.body = ply.take<std::int32_t>();
    p.id = ply.take<std::uint32_t>();
    if (has_material) p.material = ply.take<std::int32_t>();
    if (has_fraction) p.liquid_fraction = ply.take<float>();
    for (std::size_t k = 0; k < species; ++k) p.contents[k] = ply.take<float>();
  }
  return list;
}

Mesh read_mesh_ply(const std::string& path, const meltsim::Vec3d& origin, double& time) {
  Ply ply(path);
  const std::string first = "x y z nx ny nz temperature body ";
  // Surfaces of earlier versions lack the fraction, or the material as well.
  const bool has_fraction = ply.vertex_properties.find("liquid_fraction ") != std::string::npos;
  const std::string whole = first + (has_fraction ? "material liquid_fraction " : "material ");
  const std::size_t species = ply.species_behind(whole);
  const bool has_material = species > 0 || ply.vertex_properties == whole || ply.has_material(first);
  ply.expect_left(ply.vertices, has_material ? 36 + (species + (has_fraction ? 1 : 0)) * sizeof(float) : 32);
  time = ply.time;
  Mesh mesh;
  if (ply.placeholder) return mesh;
  mesh.contents.resize(species);
  for (std::uint64_t i = 0; i < ply.vertices; ++i) {
    float x[7];
    for (float& value : x) value = ply.take<float>();
    mesh.position.push_back(meltsim::cast<float>(meltsim::Vec3d{x[0], x[1], x[2]} - origin));
    mesh.normal.push_back({x[3], x[4], x[5]});
    mesh.temperature.push_back(x[6]);
    mesh.body.push_back(static_cast<std::uint32_t>(ply.take<std::int32_t>() + 1));
    mesh.material.push_back(has_material ? static_cast<std::uint32_t>(ply.take<std::int32_t>()) : 0u);
    if (has_fraction) mesh.liquid_fraction.push_back(ply.take<float>());
    for (std::vector<float>& content : mesh.contents) content.push_back(ply.take<float>());
  }
  ply.expect_left(ply.faces, 13);
  for (std::uint64_t i = 0; i < ply.faces; ++i) {
    if (ply.take<std::uint8_t>() != 3) fail(path);
    for (int k = 0; k < 3; ++k) {
      mesh.triangles.push_back(ply.take<std::uint32_t>());
      if (mesh.triangles.back() >= ply.vertices) fail(path);
    }
  }
  return mesh;
}

}  // namespace runner
