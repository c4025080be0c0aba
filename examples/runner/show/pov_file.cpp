// SPDX-License-Identifier: Apache-2.0
#include "show/pov_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>

namespace runner {

namespace {

using meltsim::Vec3d;
using meltsim::Vec3f;

constexpr int shades = 64;  ///< textures of the temperature view; POV-Ray blends between vertices

template <class V>
std::string vec(const V& v) {
  return fmt::format("<{:.6g},{:.6g},{:.6g}>", v.x, v.y, v.z);
}

template <class Out>
void vectors(Out to, const char* name, const std::vector<Vec3f>& list) {
  fmt::format_to(to, "  {} {{ {}", name, list.size());
  for (const Vec3f& v : list) fmt::format_to(to, ",\n{}", vec(v));
  fmt::format_to(to, " }}\n");
}

int shade_of(float temperature, const TraceSettings& s) {
  const double x = (temperature - s.cold) / std::max(s.hot - s.cold, 1e-9);
  return static_cast<int>(std::lround((shades - 1) * std::clamp(x, 0.0, 1.0)));
}

/// Textures of a mesh's vertices: how many, what each is, and which one a vertex has.
struct Textures {
  std::vector<std::string> list;
  std::function<int(std::uint32_t)> of;
};

Textures warmth(const Mesh& m, const TraceSettings& s, const char* transmit) {
  Textures made;
  for (int i = 0; i < shades; ++i) made.list.push_back(fmt::format("Warmth({}, {})", i, transmit));
  made.of = [&m, &s](std::uint32_t v) { return shade_of(m.temperature[v], s); };
  return made;
}

/// Of liquid that has a colour: the colours of its vertices, rounded to steps that are not seen.
Textures paint(const Mesh& m) {
  constexpr float steps = 31;
  std::map<std::array<int, 3>, int> numbers;
  std::vector<int> number;
  Textures made;
  const auto step = [](float c) { return static_cast<int>(std::lround(steps * monitor(std::max(c, 0.0f)))); };
  const auto light = [](int s) { return static_cast<float>(linear(static_cast<double>(s) / steps)); };
  for (const Vec3f& c : m.color) {
    const std::array<int, 3> key{step(c.x), step(c.y), step(c.z)};
    const auto [found, fresh] = numbers.try_emplace(key, static_cast<int>(numbers.size()));
    if (fresh)
      made.list.push_back(
          fmt::format("Paint(<{:.3f},{:.3f},{:.3f}>)", light(key[0]), light(key[1]), light(key[2])));
    number.push_back(found->second);
  }
  made.of = [number = std::move(number)](std::uint32_t v) { return number[v]; };
  return made;
}

std::string mesh(const Mesh& m, const Textures& textures = {}) {
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  const bool colored = !textures.list.empty();
  fmt::format_to(to, "mesh2 {{\n");
  vectors(to, "vertex_vectors", m.position);
  vectors(to, "normal_vectors", m.normal);
  if (colored) {
    fmt::format_to(to, "  texture_list {{ {}", textures.list.size());
    for (const std::string& texture : textures.list) fmt::format_to(to, ",\ntexture {{ {} }}", texture);
    fmt::format_to(to, " }}\n");
  }
  fmt::format_to(to, "  face_indices {{ {}", m.triangles.size() / 3);
  for (std::size_t t = 0; t + 2 < m.triangles.size(); t += 3) {
    const std::uint32_t a = m.triangles[t], b = m.triangles[t + 1], c = m.triangles[t + 2];
    fmt::format_to(to, ",\n<{},{},{}>", a, b, c);
    if (colored) {
      fmt::format_to(to, ",{},{},{}", textures.of(a), textures.of(b), textures.of(c));
    }
  }
  fmt::format_to(to, " }}\n");
  return fmt::to_string(out);
}

/// One mesh per body, so that each has its colour.
std::vector<std::pair<std::uint32_t, Mesh>> by_body(const Mesh& all) {
  std::vector<std::uint32_t> bodies = all.body;
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  std::vector<std::pair<std::uint32_t, Mesh>> parts;
  for (const std::uint32_t body : bodies) {
    Mesh part = all;  // vertices of others do no harm
    part.triangles.clear();
    for (std::size_t t = 0; t + 2 < all.triangles.size(); t += 3) {
      if (all.body[all.triangles[t]] != body) continue;
      part.triangles.insert(part.triangles.end(), all.triangles.begin() + static_cast<std::ptrdiff_t>(t),
                            all.triangles.begin() + static_cast<std::ptrdiff_t>(t) + 3);
    }
    if (!part.empty()) parts.emplace_back(body, std::move(part));
  }
  return parts;
}

const char* const head = R"(#version 3.7;
global_settings {{ assumed_gamma 1 max_trace_level 8 }}
background {{ rgb <0.50,0.56,0.62> }}
sky_sphere {{ pigment {{ gradient {up} color_map {{ [0 rgb <0.50,0.56,0.62>] [0.9 rgb <0.12,0.19,0.29>] }} }} }}
// Coordinates are right-handed: the picture's right is turned round.
camera {{ perspective location {eye} right -x*{aspect:.6g} up y sky {up} angle {angle:.6g} look_at {look_at} }}
light_source {{ {sun} rgb 1.1*<1,0.96,0.89> area_light {side1} {side2} 3 3 adaptive 0 jitter circular orient parallel point_at {look_at} }}
light_source {{ {fill} rgb 0.3*<0.85,0.92,1> shadowless parallel point_at {look_at} }}
#default {{ finish {{ ambient 0 emission 0 diffuse 0.8 }} }}
)";

const char* const look_macros = R"(
#macro Body(Rgb) texture {{ pigment {{ rgb Rgb }} finish {{ ambient 0.15 diffuse 0.7 specular 0.25 roughness 0.02 }} }} #end
#macro Paint(Rgb) pigment {{ rgb Rgb }}
  finish {{ ambient 0.12 diffuse 0.7 specular 0.6 roughness 0.004 }} #end
#macro Water(Reach) material {{ texture {{ pigment {{ rgbt <1,1,1,1> }}
    finish {{ ambient 0 diffuse 0 specular 0.6 roughness 0.002 reflection {{ 0.02, 1 fresnel on }} conserve_energy }} }}
  interior {{ ior 1.333 fade_distance Reach fade_power 1001 fade_color <0.03,0.34,0.46> }} }} photons {{ target off }} #end
)";

std::string warmth_macro() {
  std::string text = fmt::format("#declare Ramp = array[{}] {{", shades);
  for (int i = 0; i < shades; ++i) {
    const Rgb c = linear(ramp(static_cast<double>(i) / (shades - 1)));
    text += fmt::format("{}\n<{:.4f},{:.4f},{:.4f}>", i > 0 ? "," : "", c[0], c[1], c[2]);
  }
  return text +
         " }\n#macro Warmth(I, T) pigment { rgb Ramp[I] transmit T } finish { ambient 0.45 diffuse 0.5 "
         "specular "
         "0.1 } #end\n";
}

/// A slab whose top is just inside the liquid: air between the two would be a mirror.
std::string basin_floor(const TraceSettings& s, const Vec3d& up, const Vec3d& origin, double tile) {
  const double gap = 0.02 * s.spacing, thick = 0.5 * s.spacing;
  Vec3d low = s.basin.min, high = s.basin.max;
  const auto flatten = [&](double along_up, double& from, double& to) {
    if (along_up > 0.7) to = from + gap, from = to - thick;
    else if (along_up < -0.7) from = to - gap, to = from + thick;
  };
  flatten(up.x, low.x, high.x);
  flatten(up.y, low.y, high.y);
  flatten(up.z, low.z, high.z);
  return fmt::format(
      "box {{ {}, {} pigment {{ checker rgb <0.16,0.18,0.20> rgb <0.34,0.36,0.38> scale {:.4g} }} "
      "finish {{ ambient 0.12 diffuse 0.7 }} }}\n",
      vec(low - origin), vec(high - origin), tile);
}

}  // namespace

std::string pov_text(const FrameShapes& given, const Camera& camera, const TraceSettings& s) {
  const FrameShapes shapes = s.look == Look::natural ? split_liquid(given, s.looks) : given;
  // Everything is relative to the frame's origin, as the meshes are.
  const Vec3d eye = camera.eye - shapes.origin, look_at = camera.look_at - shapes.origin;
  const Vec3d front = (look_at - eye) * (1 / std::max(length(look_at - eye), 1e-30));
  Vec3d right = cross(front, camera.up);
  if (length(right) < 1e-6) right = cross(front, Vec3d{1, 0.1, 0});
  right = right * (1 / length(right));
  const Vec3d up = camera.up * (1 / length(camera.up));
  const Vec3d towards = up * 1.25 - right * 0.75 - front * 0.55;
  const Box seen = box_of(shapes);
  const double size = std::max(s.extent > 0 ? s.extent : length(seen.size()), s.spacing),
               far = 20 * size + 2 * length(look_at - eye);
  const double aspect = static_cast<double>(s.width) / s.height,
               half = std::tan(0.5 * std::min(camera.fov, 170.0) * 3.14159265358979 / 180);
  std::string text = "// A frame of meltsim, relative to " + vec(shapes.origin) +
                     fmt::format(" m, t = {:.9g} s\n", shapes.time);
  text += fmt::format(
      head, fmt::arg("up", vec(up)), fmt::arg("eye", vec(eye)), fmt::arg("look_at", vec(look_at)),
      fmt::arg("aspect", aspect), fmt::arg("angle", 2 * std::atan(half * aspect) * 180 / 3.14159265358979),
      fmt::arg("sun", vec(look_at + towards * far)), fmt::arg("side1", vec(right * (0.12 * far))),
      fmt::arg("side2", vec(cross(right, towards) * (0.12 * far))),
      fmt::arg("fill", vec(look_at + (up * 0.4 + right - front * 0.5) * far)));
  text += fmt::format(look_macros) + warmth_macro();
  if (s.has_floor) {
    text += fmt::format(
        "plane {{ {}, {:.6g} pigment {{ checker rgb <0.33,0.35,0.37> rgb <0.40,0.42,0.44> scale {:.4g} }} "
        "finish {{ ambient 0.12 diffuse 0.7 }} }}\n",
        vec(up), s.floor - dot(up, shapes.origin), tile_size(size));
    // Beyond what the picture is about the floor fades into the horizon.
    text += fmt::format("fog {{ distance {:.4g} rgb <0.50,0.56,0.62> fog_type 1 }}\n", 8 * size);
  }
  for (const Bar& bar : s.tank)
    text += fmt::format("box {{ {}, {} Body(<0.035,0.04,0.045>) }}\n", vec(bar.min - shapes.origin),
                        vec(bar.max - shapes.origin));
  if (!s.basin.empty()) text += basin_floor(s, up, shapes.origin, tile_size(size));
  const bool warm = s.look == Look::temperature;
  if (shapes.solid.empty() && shapes.balls.empty()) text += "// nothing solid in this frame\n";
  for (const auto& [body, part] : by_body(shapes.solid)) {
    const Rgb c = body_color(s, body);
    text += warm ? mesh(part, warmth(part, s, "0")) + "}\n"
                 : mesh(part) + fmt::format("  Body(<{:.3f},{:.3f},{:.3f}>)\n}}\n", c[0], c[1], c[2]);
  }
  if (!shapes.liquid.empty()) {
    text += warm ? mesh(shapes.liquid, warmth(shapes.liquid, s, "0.45")) + "}\n"
                 : mesh(shapes.liquid) + fmt::format("  Water({:.4g})\n}}\n", 0.35 * size);
  }
  if (!shapes.paint.empty()) text += mesh(shapes.paint, paint(shapes.paint)) + "}\n";
  for (const Ball& ball : shapes.balls) {
    text += fmt::format("sphere {{ {},{:.5g} ", vec(ball.center), ball.radius);
    const Rgb* const own = color_of(s.looks, ball.material);
    const Rgb c = own != nullptr ? linear(*own)
                  : ball.solid   ? body_color(s, ball.body)
                                 : Rgb{0.07, 0.24, 0.55};
    text += warm ? fmt::format("texture {{ Warmth({}, 0) }} }}\n", shade_of(ball.temperature, s))
                 : fmt::format("Body(<{:.3f},{:.3f},{:.3f}>) }}\n", c[0], c[1], c[2]);
  }
  return text;
}

}  // namespace runner
