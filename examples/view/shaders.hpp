// SPDX-License-Identifier: Apache-2.0
// The shaders, as text. All colours are sRGB as they stand; light is simple: sky, sun, a highlight.
#pragma once

namespace view::shaders {

/// How much sunlight reaches a point: four samples, each blended between texels by the hardware.
inline constexpr const char* shadow = R"(
uniform mat4 shadow_matrix;
uniform sampler2DShadow shadow_map;
uniform float shadows;
float sunlight(vec3 world) {
  vec3 at = (shadow_matrix * vec4(world, 1.0)).xyz * 0.5 + 0.5;
  if (shadows < 0.5 || any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
  float texel = 1.0 / float(textureSize(shadow_map, 0).x), sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    vec2 offset = (vec2(float(i & 1), float(i >> 1)) - 0.5) * 2.0 * texel;
    sum += texture(shadow_map, vec3(at.xy + offset, at.z - 0.002));
  }
  return 0.25 * sum;
}
)";

/// Which particles are shown, how large; needs the attributes and ParticleVertex' layout.
inline constexpr const char* particle = R"(
uniform vec4 cut;           // shown while dot(cut.xyz, x) <= cut.w
uniform vec2 radii;         // of liquid and of solid particles
float shown_radius(vec3 x, uint tag) {
  if ((tag & 0x800u) != 0u || dot(cut.xyz, x) > cut.w) return 0.0;
  return (tag & 0x100u) != 0u ? radii.y : radii.x;
}
)";

inline constexpr const char* particle_vertex = R"(
layout(location = 0) in vec4 position_speed;
layout(location = 1) in float temperature;
layout(location = 2) in uint tag;
uniform mat4 view, projection;
uniform float height;       // of the window, pixels
uniform int color_by;
uniform vec2 range;
uniform sampler2D colors;   // a row per choice
flat out vec3 center;       // as the eye sees it
flat out vec3 color;
flat out float radius;
flat out float gloss;

int ramp(float value) {
  float x = range.y > range.x ? (value - range.x) / (range.y - range.x) : 0.5;
  return int(clamp(x, 0.0, 1.0) * 255.0 + 0.5);
}

void main() {
  radius = shown_radius(position_speed.xyz, tag);
  center = (view * vec4(position_speed.xyz, 1.0)).xyz;
  bool is_solid = (tag & 0x100u) != 0u;
  uint body = tag >> 16;
  int at = ramp(color_by == 0 ? temperature : position_speed.w);
  if (color_by == 1) at = is_solid ? 1 : body != 0u ? 2 : 0;
  if (color_by == 2) at = body == 0u ? 0 : 1 + int((body - 1u) % 255u);
  if (color_by == 4) at = int(tag & 127u) + (is_solid ? 128 : 0);
  color = texelFetch(colors, ivec2(at, color_by), 0).rgb;
  gloss = is_solid ? 0.10 : 0.28;
  gl_Position = projection * vec4(center, 1.0);
  // A sphere off the axis is seen as an ellipse: a little more than its diameter.
  float far2 = max(dot(center, center) - radius * radius, 1e-12);
  gl_PointSize = 1.2 * height * projection[1][1] * radius / sqrt(far2) * length(center) / max(-center.z, 1e-6) + 2.0;
  if (radius <= 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
)";

inline constexpr const char* particle_fragment = R"(
uniform mat4 projection, to_world;
uniform vec2 viewport;
uniform vec3 sun, up;       // as the eye sees them
flat in vec3 center;
flat in vec3 color;
flat in float radius;
flat in float gloss;
out vec4 shade;

void main() {
  vec2 ndc = 2.0 * gl_FragCoord.xy / viewport - 1.0;
  vec3 ray = normalize(vec3((ndc.x + projection[2][0]) / projection[0][0], ndc.y / projection[1][1], -1.0));
  float along = dot(center, ray);
  float inside = (radius * radius - dot(center, center) + along * along) / (radius * radius);
  float coverage = clamp(inside / max(fwidth(inside), 1e-6) + 0.5, 0.0, 1.0);
  if (coverage <= 0.0) discard;
  vec3 at = ray * (along - radius * sqrt(max(inside, 0.0)));
  vec3 normal = (at - center) / radius;
  vec4 clip = projection * vec4(at, 1.0);
  gl_FragDepth = clamp(0.5 * clip.z / clip.w + 0.5, 0.0, 1.0);
  float light = sunlight((to_world * vec4(at + 0.35 * radius * normal, 1.0)).xyz);
  float diffuse = max(dot(normal, sun), 0.0) * mix(0.25, 1.0, light);
  float sky = 0.5 + 0.5 * dot(normal, up);
  float edge = 0.72 + 0.28 * smoothstep(0.0, 0.55, inside);
  vec3 lit = color * (0.40 + 0.24 * sky + 0.48 * diffuse) * edge;
  float glint = pow(max(dot(normal, normalize(sun - ray)), 0.0), 48.0) * gloss * light;
  shade = vec4(lit + glint, coverage);
}
)";

/// Seen from the sun every sphere is a disc.
inline constexpr const char* caster_vertex = R"(
layout(location = 0) in vec4 position_speed;
layout(location = 2) in uint tag;
uniform mat4 shadow_matrix;
uniform vec2 disc;          // pixels and depth per metre
flat out float bulge;
void main() {
  float radius = shown_radius(position_speed.xyz, tag);
  gl_Position = shadow_matrix * vec4(position_speed.xyz, 1.0);
  gl_PointSize = max(2.0 * radius * disc.x, 1.0);
  bulge = radius * disc.y;
  if (radius <= 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
)";

inline constexpr const char* caster_fragment = R"(
flat in float bulge;
void main() {
  vec2 at = 2.0 * gl_PointCoord - 1.0;
  float beside = dot(at, at);
  if (beside > 1.0) discard;
  gl_FragDepth = gl_FragCoord.z - bulge * sqrt(1.0 - beside);
}
)";

inline constexpr const char* backdrop_vertex = R"(
out float height;
void main() {
  vec2 at = vec2(float((gl_VertexID & 1) * 4 - 1), float((gl_VertexID & 2) * 2 - 1));
  height = 0.5 + 0.5 * at.y;
  gl_Position = vec4(at, 1.0, 1.0);
}
)";

inline constexpr const char* backdrop_fragment = R"(
in float height;
out vec4 shade;
void main() { shade = vec4(mix(vec3(0.13, 0.15, 0.18), vec3(0.25, 0.29, 0.34), clamp(height, 0.0, 1.0)), 1.0); }
)";

inline constexpr const char* floor_vertex = R"(
uniform mat4 view, projection;
uniform vec3 center, along, across;  // of the floor; the axes have length 1
uniform float reach;
out vec2 place;
out vec3 world;
void main() {
  place = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0 - 1.0;
  world = center + reach * (place.x * along + place.y * across);
  gl_Position = projection * view * vec4(world, 1.0);
}
)";

inline constexpr const char* floor_fragment = R"(
uniform vec3 along, across;
uniform float step_size;
uniform vec2 start;         // a crossing of lines
in vec2 place;
in vec3 world;
out vec4 shade;
float lines(vec2 at) {
  vec2 away = abs(fract(at - 0.5) - 0.5) / max(fwidth(at), 1e-6);
  return 1.0 - min(min(away.x, away.y), 1.0);
}
void main() {
  vec2 at = (vec2(dot(world, along), dot(world, across)) - start) / step_size;
  float fade = 1.0 - smoothstep(0.35, 1.0, length(place));
  float line = 0.35 * lines(at) + 0.35 * lines(at / 5.0);
  vec3 color = mix(vec3(0.33, 0.36, 0.40), vec3(0.60, 0.64, 0.69), line);
  shade = vec4(color * mix(0.62, 1.0, sunlight(world)), fade);
}
)";

inline constexpr const char* line_vertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 view, projection;
void main() { gl_Position = projection * view * vec4(position, 1.0); }
)";

inline constexpr const char* line_fragment = R"(
out vec4 shade;
void main() { shade = vec4(0.80, 0.84, 0.90, 0.55); }
)";

}  // namespace view::shaders
