// SPDX-License-Identifier: Apache-2.0
#include "show/usd_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "meltsim/particle_tag.hpp"

namespace runner {

namespace {

using meltsim::Vec3d;
using meltsim::Vec3f;

/// Nine digits bring a float back to the bit.
void put_number(std::string& to, double value) { fmt::format_to(std::back_inserter(to), "{:.9g}", value); }
void put_point(std::string& to, const Vec3d& p) {
  fmt::format_to(std::back_inserter(to), "({:.9g}, {:.9g}, {:.9g})", p.x, p.y, p.z);
}

/// `type name = [item(0), item(1), ...]`, and what else it says of it in brackets.
template <class Item>
void put_array(std::string& to, const char* declaration, std::size_t count, const Item& item,
               const char* interpolation = nullptr) {
  to += "        ";
  to += declaration;
  to += " = [";
  for (std::size_t i = 0; i < count; ++i) {
    if (i != 0) to += ", ";
    item(i);
  }
  to += "]";
  if (interpolation != nullptr)
    to += fmt::format(" (\n            interpolation = \"{}\"\n        )", interpolation);
  to += "\n";
}

/// `p` is called with each place.
template <class Place>
void put_extent(std::string& to, std::size_t count, double margin, const Place& place) {
  if (count == 0) return;
  Vec3d low = place(0), high = low;
  for (std::size_t i = 1; i < count; ++i) {
    const Vec3d x = place(i);
    low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
    high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
  }
  const Vec3d m{margin, margin, margin};
  to += "        float3[] extent = [";
  put_point(to, low - m);
  to += ", ";
  put_point(to, high + m);
  to += "]\n";
}

void put_particles(std::string& to, const meltsim::ParticleFrame& p, double spacing) {
  const std::size_t n = p.id.size();
  const auto place = [&](std::size_t i) { return meltsim::cast<double>(p.position[i]) + p.origin; };
  to += "    def Points \"particles\"\n    {\n";
  put_extent(to, n, 0.5 * spacing, place);
  put_array(to, "point3f[] points", n, [&](std::size_t i) { put_point(to, place(i)); });
  put_array(to, "vector3f[] velocities", n,
            [&](std::size_t i) { put_point(to, meltsim::cast<double>(p.velocity[i])); });
  put_array(
      to, "float[] widths", 1, [&](std::size_t) { put_number(to, spacing); }, "constant");
  put_array(to, "int64[] ids", n, [&](std::size_t i) { to += std::to_string(p.id[i]); });
  put_array(
      to, "float[] primvars:temperature", n, [&](std::size_t i) { put_number(to, p.temperature[i]); },
      "vertex");
  put_array(
      to, "float[] primvars:liquid_fraction", n, [&](std::size_t i) { put_number(to, p.liquid_fraction[i]); },
      "vertex");
  put_array(
      to, "int[] primvars:body", n,
      [&](std::size_t i) {
        to += std::to_string(meltsim::is_solid(p.tag[i]) ? static_cast<int>(meltsim::body_of(p.tag[i])) - 1
                                                         : -1);
      },
      "vertex");
  put_array(
      to, "int[] primvars:material", n,
      [&](std::size_t i) { to += std::to_string(meltsim::material_of(p.tag[i])); }, "vertex");
  to += "    }\n";
}

void put_mesh(std::string& to, const char* name, const Mesh& mesh, const Vec3d& origin) {
  const std::size_t n = mesh.position.size();
  const auto place = [&](std::size_t i) { return meltsim::cast<double>(mesh.position[i]) + origin; };
  to +=
      fmt::format("    def Mesh \"{}\"\n    {{\n        uniform token subdivisionScheme = \"none\"\n", name);
  put_extent(to, n, 0, place);
  put_array(to, "int[] faceVertexCounts", mesh.triangles.size() / 3, [&](std::size_t) { to += "3"; });
  put_array(to, "int[] faceVertexIndices", mesh.triangles.size() / 3 * 3,
            [&](std::size_t i) { to += std::to_string(mesh.triangles[i]); });
  put_array(to, "point3f[] points", n, [&](std::size_t i) { put_point(to, place(i)); });
  put_array(
      to, "normal3f[] normals", n,
      [&](std::size_t i) { put_point(to, meltsim::cast<double>(mesh.normal[i])); }, "vertex");
  put_array(
      to, "float[] primvars:temperature", n, [&](std::size_t i) { put_number(to, mesh.temperature[i]); },
      "vertex");
  if (mesh.liquid_fraction.size() == n)
    put_array(
        to, "float[] primvars:liquid_fraction", n,
        [&](std::size_t i) { put_number(to, mesh.liquid_fraction[i]); }, "vertex");
  put_array(
      to, "int[] primvars:body", n,
      [&](std::size_t i) { to += std::to_string(static_cast<int>(mesh.body[i]) - 1); }, "vertex");
  put_array(
      to, "int[] primvars:material", n, [&](std::size_t i) { to += std::to_string(mesh.material[i]); },
      "vertex");
  to += "    }\n";
}

}  // namespace

std::string usd_text(const meltsim::ParticleFrame& particles, const FrameShapes& shapes, double spacing,
                     double time, const Vec3d& up) {
  const bool up_is_z = is_along(up, {0, 0, 1});
  std::string text = fmt::format(
      "#usda 1.0\n(\n    customLayerData = {{\n        double time_s = {:.9g}\n        string units = \"m, "
      "degrees "
      "Celsius\"\n    }}\n    defaultPrim = \"meltsim\"\n    metersPerUnit = 1\n    upAxis = "
      "\"{}\"\n)\n\ndef Xform "
      "\"meltsim\"\n{{\n",
      time, up_is_z ? "Z" : "Y");
  if (!up_is_z && !is_along(up, {0, 1, 0})) {
    const std::array<double, 4> turn = turn_upright(up);
    text += fmt::format(
        "    quatf xformOp:orient = ({3:.9g}, {0:.9g}, {1:.9g}, {2:.9g})\n    uniform token[] xformOpOrder = "
        "[\"xformOp:orient\"]\n",
        turn[0], turn[1], turn[2], turn[3]);
  }
  put_particles(text, particles, spacing);
  put_mesh(text, "liquid", shapes.liquid, shapes.origin);
  put_mesh(text, "solid", shapes.solid, shapes.origin);
  text += "}\n";
  return text;
}

}  // namespace runner
