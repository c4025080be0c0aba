// SPDX-License-Identifier: Apache-2.0
#include "load_shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <tuple>

#include "echo.hpp"
#include "failure.hpp"
#include "hash.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

using meltsim::Shape;
using meltsim::Vec3d;

// A scene nests a handful of shapes; a list that contains itself (YAML allows it) never ends.
constexpr int max_depth = 32;
constexpr std::size_t max_parts = 4096;

struct Loader {
  std::size_t parts = 0;

  SceneShape load(const Node& node, int depth);
  SceneShape plain(const std::string& kind, const Node& node, int depth);
  SceneShape combined(const std::string& kind, const Node& node, int depth);
};

SceneShape load_box(const Node& node) {
  const std::vector<Node> corners = node.is_list() ? node.items("corners") : std::vector<Node>{};
  if (corners.size() != 2) node.fail("expected two corners [[x, y, z], [x, y, z]] (m), got " + node.found());
  const Vec3d min = corners[0].vector("m"), max = corners[1].vector("m");
  if (max.x <= min.x || max.y <= min.y || max.z <= min.z) {
    corners[1].fail("expected a corner above the first one on every axis (m)");
  }
  return {Shape::box(min, max), Json::array({echo(min), echo(max)})};
}

SceneShape load_sphere(const Node& node) {
  node.allow_keys(keys::sphere);
  const Vec3d center = node.require("center", "3 numbers [x, y, z] (m)").vector("m");
  const double radius = node.require("radius", "a number (m)").positive("m");
  return {Shape::sphere(center, radius), {{"center", echo(center)}, {"radius", radius}}};
}

SceneShape load_rod(const std::string& kind, const Node& node) {
  node.allow_keys(keys::rod);
  const Vec3d from = node.require("from", "3 numbers [x, y, z] (m)").vector("m");
  const Node to_node = node.require("to", "3 numbers [x, y, z] (m)");
  const Vec3d to = to_node.vector("m");
  const double radius = node.require("radius", "a number (m)").positive("m");
  if (kind == "cylinder" && !(length(to - from) > 0)) to_node.fail("expected a point away from \"from\" (m)");
  const Shape shape =
      kind == "capsule" ? Shape::capsule(from, to, radius) : Shape::cylinder(from, to, radius);
  return {shape, {{"from", echo(from)}, {"to", echo(to)}, {"radius", radius}}};
}

Vec3d load_axis(const Node& node) {
  const Vec3d axis = node.vector("any length");
  if (!(length(axis) > 0)) node.fail("expected a direction, got [0, 0, 0]");
  return axis;
}

SceneShape load_torus(const Node& node) {
  node.allow_keys(keys::torus);
  const Vec3d center = node.require("center", "3 numbers [x, y, z] (m)").vector("m");
  const auto axis_node = node.find("axis");
  const Vec3d axis = axis_node ? load_axis(*axis_node) : Vec3d{0, 1, 0};
  const double major = node.require("major_radius", "a number (m)").positive("m");
  const double minor = node.require("minor_radius", "a number (m)").positive("m");
  return {Shape::torus(center, axis, major, minor),
          {{"center", echo(center)}, {"axis", echo(axis)}, {"major_radius", major}, {"minor_radius", minor}}};
}

SceneShape load_blend(const Node& node) {
  node.allow_keys(keys::blend);
  std::vector<meltsim::Ellipsoid> parts;
  Json list = Json::array();
  const Node ellipsoids = node.require("ellipsoids", "a list of {center, radii}");
  for (const Node& item : ellipsoids.items("{center, radii}")) {
    item.allow_keys(keys::ellipsoid);
    meltsim::Ellipsoid part;
    part.center = item.require("center", "3 numbers [x, y, z] (m)").vector("m");
    const Node radii = item.require("radii", "3 numbers [x, y, z] (m)");
    part.radii = radii.vector("m");
    if (!(part.radii.x > 0 && part.radii.y > 0 && part.radii.z > 0))
      radii.fail("expected numbers above 0 (m)");
    list.push_back({{"center", echo(part.center)}, {"radii", echo(part.radii)}});
    parts.push_back(part);
  }
  if (parts.empty()) ellipsoids.fail("expected at least one ellipsoid, got none");
  double width = 0;
  if (const auto given = node.find("width")) {
    width = given->number("m");
    if (width < 0) given->fail(fmt::format("expected 0 or more (m), got {}", given->found()));
  }
  return {Shape::blend(std::move(parts), width), {{"ellipsoids", list}, {"width", width}}};
}

/// Edges that an odd number of triangles share. Vertices at the same place, or in the same cell [m], are one: many files repeat them.
std::size_t open_edges(const meltsim::TriangleMesh& mesh, double cell = 0) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), same(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&mesh, cell](std::uint32_t i) {
    const Vec3d& v = mesh.vertices[i];
    if (!(cell > 0)) return std::make_tuple(v.x, v.y, v.z);
    return std::make_tuple(std::round(v.x / cell), std::round(v.y / cell), std::round(v.z / cell));
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  for (std::size_t i = 0; i < order.size(); ++i)
    same[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? same[order[i - 1]] : order[i];
  std::vector<std::uint64_t> edges;
  edges.reserve(mesh.indices.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint64_t a = same[mesh.indices[i]], b = same[mesh.indices[i % 3 == 2 ? i - 2 : i + 1]];
    if (a != b) edges.push_back(std::min(a, b) << 32 | std::max(a, b));
  }
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0;
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end] == edges[begin]) ++end;
    open += (end - begin) % 2;
  }
  return open;
}

/// Where most gaps are a rounding wide, no hole is to be closed.
std::string cure_of_open(const meltsim::TriangleMesh& mesh, std::size_t open) {
  constexpr double rounding = 1e-5;  // of the mesh's size: files of six digits are off by a tenth of it
  Vec3d low = mesh.vertices.front(), high = low;
  for (const Vec3d& v : mesh.vertices) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  if (2 * open_edges(mesh, rounding * length(high - low)) > open) return "close the holes";
  return "merge its vertices by distance: most of these edges lie beside another, with a gap as of rounding";
}

std::uint64_t hash_of(const meltsim::TriangleMesh& mesh) {
  const std::uint64_t hash = fnv1a(mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3d));
  return fnv1a(mesh.indices.data(), mesh.indices.size() * sizeof(mesh.indices[0]), hash);
}

SceneShape load_mesh(const Node& node) {
  const std::string given = node.text("the path of an OBJ, STL or PLY file");
  std::filesystem::path path = given;
  if (path.is_relative()) path = std::filesystem::path(node.document().directory) / path;
  auto mesh = meltsim::read_mesh(path.string());
  if (!mesh && mesh.error().code == meltsim::ErrorCode::out_of_memory)
    throw Failure(ExitCode::device, fmt::format("{}: {}: memory: the machine has too little for this mesh",
                                                node.where(), node.path()));
  if (!mesh) node.fail(mesh.error().message);
  SceneShape shape;
  if (const std::size_t open = open_edges(*mesh); open > 0) {
    shape.warnings.push_back(
        fmt::format("{}: {}: the mesh is open: {} of its edges belong to one triangle only; what is inside "
                    "is a guess there, so {}",
                    node.where(), node.path(), open, cure_of_open(*mesh, open)));
  }
  shape.mesh = hash_of(*mesh);
  shape.shape = Shape::mesh(std::move(*mesh));
  shape.echo = std::filesystem::absolute(path).lexically_normal().string();
  return shape;
}

SceneShape transformed(const SceneShape& shape, const Node& node, Json& echo_map) {
  node.allow_keys(keys::transform);
  Vec3d offset, axis{0, 1, 0};
  double angle = 0, scale = 1;
  if (const auto given = node.find("offset")) offset = given->vector("m");
  if (const auto given = node.find("axis")) axis = load_axis(*given);
  if (const auto given = node.find("angle")) angle = given->number("degrees");
  if (const auto given = node.find("scale")) scale = given->positive("a factor");
  echo_map["transform"] = {
      {"offset", echo(offset)}, {"axis", echo(axis)}, {"angle", angle}, {"scale", scale}};
  constexpr double radians = 3.14159265358979323846 / 180;
  SceneShape moved = shape;
  moved.shape = shape.shape.transformed(offset, axis, angle * radians, scale);
  moved.echo = echo_map;
  return moved;
}

SceneShape Loader::combined(const std::string& kind, const Node& node, int depth) {
  std::vector<Shape> shapes;
  SceneShape all;
  all.echo = Json::array();
  for (const Node& item : node.items("shapes")) {
    const SceneShape part = load(item, depth + 1);
    shapes.push_back(part.shape);
    all.echo.push_back(part.echo);
    all.warnings.insert(all.warnings.end(), part.warnings.begin(), part.warnings.end());
    if (part.mesh != 0) all.mesh = fnv1a(&part.mesh, sizeof part.mesh, all.mesh);
  }
  const std::size_t least = kind == "union" ? 1 : 2;
  if (shapes.size() < least) {
    node.fail(
        fmt::format("expected at least {} shape{}, got {}", least, least == 1 ? "" : "s", node.found()));
  }
  if (kind == "union") {
    all.shape = Shape::unite(std::move(shapes));
  } else if (kind == "intersection") {
    all.shape = Shape::intersect(std::move(shapes));
  } else {
    const Shape from = shapes.front();
    shapes.erase(shapes.begin());
    all.shape = Shape::subtract(from, Shape::unite(std::move(shapes)));
  }
  return all;
}

SceneShape Loader::plain(const std::string& kind, const Node& node, int depth) {
  if (kind == "box") return load_box(node);
  if (kind == "sphere") return load_sphere(node);
  if (kind == "torus") return load_torus(node);
  if (kind == "blend") return load_blend(node);
  if (kind == "mesh") return load_mesh(node);
  if (kind == "union" || kind == "difference" || kind == "intersection") return combined(kind, node, depth);
  return load_rod(kind, node);
}

SceneShape Loader::load(const Node& node, int depth) {
  if (depth > max_depth) node.fail(fmt::format("shapes are nested more than {} deep", max_depth));
  if (++parts > max_parts) node.fail(fmt::format("more than {} shapes in one", max_parts));
  if (!node.is_mapping()) {
    node.fail(fmt::format("expected a shape, e.g. {{box: [[0,0,0],[1,1,1]]}}, got {}", node.found()));
  }
  node.allow_keys(keys::shape);
  std::string kind;
  for (const std::string& name : keys::shapes) {
    if (!node.find(name)) continue;
    if (!kind.empty()) {
      node.fail(fmt::format("expected one shape, got both {} and {}; put them in a union list", kind, name));
    }
    kind = name;
  }
  if (kind.empty()) node.fail("expected one of " + either_of(keys::shapes));
  SceneShape shape = plain(kind, *node.find(kind), depth);
  Json echo_map = {{kind, shape.echo}};
  if (const auto transform = node.find("transform")) return transformed(shape, *transform, echo_map);
  shape.echo = echo_map;
  return shape;
}

}  // namespace

SceneShape load_shape(const Node& node) {
  Loader loader;
  SceneShape shape = loader.load(node, 0);
  const meltsim::Status valid = shape.shape.validate();
  if (!valid) node.fail(valid.error().message);
  return shape;
}

}  // namespace runner
