// SPDX-License-Identifier: Apache-2.0
#include "show/tracer.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <thread>

namespace runner {

namespace {

using meltsim::Vec3d;
using meltsim::Vec3f;

// Colours are linear light from here on.
const Vec3f horizon{0.80f, 0.84f, 0.88f}, zenith{0.36f, 0.50f, 0.70f}, sunlight{1.9f, 1.82f, 1.68f};
const Vec3f absorbed{1.6f, 0.42f, 0.22f};  ///< by a depth of liquid as large as the picture's contents
const Vec3f liquid_color{0.07f, 0.24f, 0.55f};
constexpr float refraction = 1.333f, pi = 3.14159265f;
constexpr int deepest = 7;

Vec3f as_vector(const Rgb& c) { return meltsim::cast<float>(Vec3d{c[0], c[1], c[2]}); }
Vec3f times(const Vec3f& a, const Vec3f& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
Vec3f unit(const Vec3f& v) { return v * (1 / std::max(length(v), 1e-20f)); }
Vec3f mix(const Vec3f& a, const Vec3f& b, float t) { return a + (b - a) * t; }
float smooth(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

/// Numbers that look random, for this pixel and sample: the same in every run.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : state_(seed * 747796405u + 2891336453u) { next(); }
  float next() {
    state_ = state_ * 747796405u + 2891336453u;
    std::uint32_t word = ((state_ >> ((state_ >> 28) + 4)) ^ state_) * 277803737u;
    word = word >> 22 ^ word;
    return static_cast<float>(word >> 8) * (1.0f / 16777216.0f);
  }

 private:
  std::uint32_t state_;
};

/// What a ray met.
struct Surface {
  Vec3f at, normal;  ///< of the shading, on the outside
  Vec3f color;
  bool solid = true, outside = true;  ///< outside: the ray comes from there
};

class Tracer {
 public:
  Tracer(const FrameShapes& shapes, const Camera& camera, const TraceSettings& settings)
      : shapes_(settings.look == Look::natural ? split_liquid(shapes, settings.looks) : shapes),
        bvh_(shapes_),
        settings_(settings) {
    eye_ = meltsim::cast<float>(camera.eye - shapes.origin);
    up_ = unit(meltsim::cast<float>(camera.up));
    front_ = unit(meltsim::cast<float>(camera.look_at - camera.eye));
    right_ = cross(front_, up_);
    // Looking straight up or down: any direction will do.
    right_ = unit(length(right_) > 1e-4f ? right_ : cross(front_, Vec3f{1, 0.1f, 0}));
    above_ = cross(right_, front_);
    tangent_ = std::tan(0.5f * static_cast<float>(std::min(camera.fov, 170.0)) * pi / 180);
    sun_ = unit(up_ * 1.25f - right_ * 0.75f - front_ * 0.55f);
    across_ = unit(cross(up_, sun_));
    floor_ = static_cast<float>(settings.floor - dot(camera.up, shapes.origin));
    const Box box = box_of(shapes);
    size_ = static_cast<float>(
        std::max(settings.extent > 0 ? settings.extent : length(box.size()), settings.spacing));
    middle_ =
        meltsim::cast<float>((box.empty() ? camera.look_at : (box.min + box.max) * 0.5) - shapes.origin);
    tile_ = static_cast<float>(tile_size(size_));
    see_through_ = !shapes_.liquid.empty();
  }

  Vec3f pixel(float x, float y, Dice dice, int sample) const {
    const float aspect = static_cast<float>(settings_.width) / static_cast<float>(settings_.height);
    const Vec3f along = unit(front_ + right_ * (x * tangent_ * aspect) + above_ * (y * tangent_));
    return color({eye_, along}, dice, sample, 0, 1);
  }

 private:
  Vec3f sky(const Vec3f& along) const {
    const float height = dot(along, up_);
    const float glow = std::pow(std::max(0.0f, dot(along, sun_)), 350.0f);
    return mix(horizon, zenith, smooth(0, 0.9f, height)) + sunlight * (6 * glow);
  }

  Surface surface(const Ray& ray, const Hit& hit) const {
    Surface s;
    s.at = ray.from + ray.along * hit.distance;
    s.solid = bvh_.is_solid(hit.primitive);
    float temperature = 0;
    std::uint32_t body = 0;
    std::optional<Vec3f> own;
    if (bvh_.is_ball(hit.primitive)) {
      const Ball& ball = bvh_.ball(hit.primitive);
      s.normal = (s.at - ball.center) * (1 / ball.radius);
      s.outside = dot(s.normal, ray.along) < 0;
      temperature = ball.temperature;
      body = ball.body;
      if (const auto* color = color_of(settings_.looks, ball.material)) own = as_vector(linear(*color));
    } else {
      const Mesh& mesh = bvh_.mesh(hit.primitive);
      const std::size_t t = bvh_.triangle(hit.primitive);
      const std::uint32_t a = mesh.triangles[t], b = mesh.triangles[t + 1], c = mesh.triangles[t + 2];
      const Vec3f flat = cross(mesh.position[b] - mesh.position[a], mesh.position[c] - mesh.position[a]);
      s.outside = dot(flat, ray.along) < 0;
      const float w = 1 - hit.u - hit.v;
      s.normal = unit(mesh.normal[a] * w + mesh.normal[b] * hit.u + mesh.normal[c] * hit.v);
      temperature = mesh.temperature[a] * w + mesh.temperature[b] * hit.u + mesh.temperature[c] * hit.v;
      body = mesh.body[a];
      if (bvh_.is_paint(hit.primitive)) own = paint(mesh, t, {w, hit.u, hit.v});
    }
    if (settings_.look == Look::temperature) {
      const Rgb shown = ramp((temperature - settings_.cold) / std::max(settings_.hot - settings_.cold, 1e-9));
      s.color = as_vector(linear(shown));
    } else {
      s.color = own ? *own : s.solid ? as_vector(body_color(settings_, body)) : liquid_color;
    }
    return s;
  }

  /// What of the sun arrives; water between takes a part.
  float sunshine(const Vec3f& at, const Vec3f& normal, Dice& dice, int sample) const {
    // A disc of light, each sample of the pixel in a part of it of its own.
    const float n = static_cast<float>(settings_.samples * settings_.samples);
    const float angle = 2 * pi * (static_cast<float>(sample) + dice.next()) / n,
                radius = 0.07f * std::sqrt(dice.next());
    const Vec3f towards =
        unit(sun_ + across_ * (radius * std::cos(angle)) + cross(sun_, across_) * (radius * std::sin(angle)));
    const Ray ray{at + normal * lift(), towards};
    const bool clear = settings_.look == Look::natural && see_through_;
    if (bvh_.blocked(ray, clear ? Seen::solid : Seen::all)) return 0;
    return clear && bvh_.blocked(ray, Seen::liquid) ? 0.72f : 1;
  }

  /// Share of the sky that is open above a point, nearby.
  float openness(const Vec3f& at, const Vec3f& normal, Dice& dice, int sample) const {
    const float n = static_cast<float>(settings_.samples * settings_.samples);
    const float angle = 2 * pi * (static_cast<float>(sample) + dice.next()) / n, r2 = dice.next();
    const Vec3f side = unit(cross(normal, std::abs(normal.x) < 0.8f ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0}));
    const Vec3f towards = side * (std::sqrt(r2) * std::cos(angle)) +
                          cross(normal, side) * (std::sqrt(r2) * std::sin(angle)) +
                          normal * std::sqrt(1 - r2);
    const bool clear = settings_.look == Look::natural && see_through_;
    Ray ray{at + normal * lift(), towards};
    ray.most = 0.2f * size_;
    return bvh_.blocked(ray, clear ? Seen::solid : Seen::all) ? 0.15f : 1;
  }

  Vec3f lit(const Surface& s, const Vec3f& along, Dice& dice, int sample, float gloss) const {
    const Vec3f n = dot(s.normal, along) > 0 ? Vec3f{0, 0, 0} - s.normal : s.normal;
    const float open = openness(s.at, n, dice, sample), cosine = dot(n, sun_);
    const float sun = cosine > 0 ? cosine * sunshine(s.at, n, dice, sample) : 0;
    const Vec3f dome = mix(Vec3f{0.34f, 0.33f, 0.32f}, Vec3f{0.62f, 0.68f, 0.76f}, 0.5f + 0.5f * dot(n, up_));
    const bool even = settings_.look == Look::temperature;  // colours are to be read
    Vec3f color =
        times(s.color, dome * (open * (even ? 1.0f : 0.66f)) + sunlight * (sun * (even ? 0.22f : 0.38f)));
    if (gloss > 0 && sun > 0) {
      const Vec3f halfway = unit(sun_ - along);
      color = color + sunlight * (gloss * std::pow(std::max(0.0f, dot(n, halfway)), 60.0f));
    }
    return color;
  }

  Vec3f floor_color(const Vec3f& at, const Vec3f& along, Dice& dice, int sample) const {
    const Vec3f off = at - middle_;
    const Vec3f level = off - up_ * dot(off, up_);
    const Vec3f east = unit(cross(up_, std::abs(up_.x) < 0.8f ? Vec3f{1, 0, 0} : Vec3f{0, 0, 1})),
                north = cross(up_, east);
    const auto cell = [&](const Vec3f& axis) { return static_cast<int>(std::floor(dot(at, axis) / tile_)); };
    const bool dark = ((cell(east) + cell(north)) & 1) != 0;
    Surface s;
    s.at = at;
    s.normal = up_;
    s.color = dark ? Vec3f{0.50f, 0.52f, 0.55f} : Vec3f{0.60f, 0.62f, 0.64f};
    const float far = smooth(0.9f * size_, 3.5f * size_, length(level));
    // Beyond what the picture is about the floor fades into the horizon.
    if (far >= 1) return horizon;
    return mix(lit(s, along, dice, sample, 0), horizon, far);
  }

  /// submerged: the ray starts in liquid.
  Vec3f color(const Ray& ray, Dice& dice, int sample, int depth, float weight, bool submerged = false) const {
    const Hit hit = bvh_.nearest(ray);
    const bool met = hit.any();
    Surface s;
    if (met) s = surface(ray, hit);
    const bool inside = met && !s.solid && !s.outside;
    const float down = dot(ray.along, up_);
    if (settings_.has_floor && down < 0) {
      // Liquid rests on the floor: from inside, the film of air below it is not there.
      const float height = floor_ + (inside ? 0.7f * static_cast<float>(settings_.spacing) : 0);
      const float to_floor = (height - dot(ray.from, up_)) / down;
      if (to_floor > 0 && to_floor < hit.distance) {
        const Vec3f found = floor_color(ray.from + ray.along * to_floor, ray.along, dice, sample);
        return inside ? times(found, passing(to_floor)) : found;
      }
    }
    if (!met) return sky(ray.along);
    if (settings_.look == Look::temperature) return warm_color(ray, s, dice, sample, depth, weight);
    if (s.solid) {
      const Vec3f own = lit(s, ray.along, dice, sample, 0.25f);
      return submerged ? times(own, passing(hit.distance)) : own;
    }
    if (!see_through_) return lit(s, ray.along, dice, sample, 0.35f);
    if (const auto wetted = inside ? wetted_solid(ray, s) : std::nullopt)
      return times(lit(*wetted, ray.along, dice, sample, 0.25f), passing(hit.distance));
    return liquid(ray, s, hit.distance, dice, sample, depth, weight);
  }

  Vec3f warm_color(const Ray& ray, const Surface& s, Dice& dice, int sample, int depth, float weight) const {
    const bool film = !s.solid && see_through_;
    if (!film) return lit(s, ray.along, dice, sample, 0.08f);
    const float opaque = s.outside ? 0.55f : 0.0f;
    const Vec3f own = opaque > 0 ? lit(s, ray.along, dice, sample, 0.15f) : Vec3f{0, 0, 0};
    if (depth >= deepest || weight < 0.05f) return own;
    Dice fork = dice;
    const Vec3f behind =
        color({s.at + ray.along * lift(), ray.along}, fork, sample, depth + 1, weight * (1 - opaque));
    return own * opaque + behind * (1 - opaque);
  }

  /// The solid that a ray leaving the liquid meets at once. Both have a surface where they touch, and the film of
  /// air that rounding leaves between would be a mirror.
  std::optional<Surface> wetted_solid(const Ray& ray, const Surface& left) const {
    Ray on{left.at - ray.along * lift(), ray.along};
    on.most = static_cast<float>(settings_.spacing);
    const Hit next = bvh_.nearest(on, Seen::solid);
    if (!next.any()) return std::nullopt;
    return surface(on, next);
  }

  /// What liquid lets through over a distance.
  Vec3f passing(float distance) const {
    const float x = distance / size_;
    return {std::exp(-absorbed.x * x), std::exp(-absorbed.y * x), std::exp(-absorbed.z * x)};
  }

  Vec3f liquid(const Ray& ray, const Surface& s, float distance, Dice& dice, int sample, int depth,
               float weight) const {
    const Vec3f n = s.outside ? s.normal : Vec3f{0, 0, 0} - s.normal;
    const float cosine = std::clamp(-dot(n, ray.along), 0.02f, 1.0f);
    const float eta = s.outside ? 1 / refraction : refraction;
    const float k = 1 - eta * eta * (1 - cosine * cosine);
    const Vec3f through = s.outside ? Vec3f{1, 1, 1} : passing(distance);
    const Vec3f mirrored = unit(ray.along + n * (2 * cosine));
    if (depth >= deepest || weight < 0.02f) return times(sky(mirrored), through);
    const Ray back{s.at + n * lift(), mirrored};
    if (k <= 0) return times(color(back, dice, sample, depth + 1, weight, true), through);
    const float outer = s.outside ? cosine : std::sqrt(k), grazing = 1 - outer, g2 = grazing * grazing;
    const float fresnel = 0.02f + 0.98f * g2 * g2 * grazing;  // Schlick 1994
    const Vec3f bent = unit(ray.along * eta + n * (eta * cosine - std::sqrt(k)));
    const Ray on{s.at - n * lift(), bent};
    const Vec3f refracted = color(on, dice, sample, depth + 1, weight * (1 - fresnel), s.outside);
    // Faint mirrorings of mirrorings are not worth a ray.
    const Vec3f reflected = fresnel * weight < 0.03f && depth > 0
                                ? sky(mirrored)
                                : color(back, dice, sample, depth + 1, weight * fresnel, !s.outside);
    return times(refracted * (1 - fresnel) + reflected * fresnel, through);
  }

  /// Rays start this far from the surface they leave.
  float lift() const { return 1e-4f * size_; }

  /// Of a point in the liquid: between the corners that have a colour.
  Vec3f paint(const Mesh& mesh, std::size_t t, const float (&share)[3]) const {
    Vec3f sum{0, 0, 0};
    float weight = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto* color = color_of(settings_.looks, mesh.material[mesh.triangles[t + k]]);
      if (color == nullptr) continue;
      const float part = share[k] + 1e-6f;
      sum = sum + as_vector(linear(*color)) * part;
      weight += part;
    }
    return sum * (1 / std::max(weight, 1e-6f));
  }

  FrameShapes shapes_;
  Bvh bvh_;
  const TraceSettings& settings_;
  Vec3f eye_, up_, front_, right_, above_, sun_, across_, middle_;
  float tangent_ = 1, floor_ = 0, size_ = 1, tile_ = 1;
  bool see_through_ = false;
};

/// Linear light to what a monitor shows, bright parts held back.
Rgb shown(const Vec3f& light) {
  const auto one = [](float c) {
    const double x = std::max(0.0f, c);
    const double held = x < 0.7 ? x : 0.7 + 0.3 * (1 - std::exp(-(x - 0.7) / 0.3));
    return std::pow(std::min(held, 1.0), 1 / 2.2);
  };
  return {one(light.x), one(light.y), one(light.z)};
}

}  // namespace

double tile_size(double size) {
  const double power = std::pow(10.0, std::floor(std::log10(size / 6))), rest = size / 6 / power;
  return power * (rest < 2 ? 1 : rest < 5 ? 2 : 5);
}

Rgb body_color(const TraceSettings& settings, std::size_t body) {
  constexpr Rgb palette[] = {{0.66, 0.80, 0.90}, {0.80, 0.42, 0.09}, {0.64, 0.15, 0.10},
                             {0.22, 0.46, 0.18}, {0.36, 0.24, 0.55}, {0.72, 0.32, 0.43}};
  const std::size_t index = std::max<std::size_t>(body, 1) - 1;
  return index < settings.bodies.size() ? settings.bodies[index] : palette[index % std::size(palette)];
}

Image traced(const FrameShapes& shapes, const Camera& camera, const TraceSettings& settings) {
  Image image(settings.width, settings.height);
  const Tracer tracer(shapes, camera, settings);
  std::atomic<int> next_row{0};
  const auto work = [&] {
    for (int y = next_row++; y < settings.height; y = next_row++) {
      for (int x = 0; x < settings.width; ++x) {
        Vec3f sum{0, 0, 0};
        const int n = settings.samples;
        for (int s = 0; s < n * n; ++s) {
          const auto seed = static_cast<std::uint32_t>((y * settings.width + x) * 64 + s);
          Dice dice(seed);
          const float px =
              static_cast<float>(x) + (static_cast<float>(s % n) + dice.next()) / static_cast<float>(n);
          const float py =
              static_cast<float>(y) + (static_cast<float>(s / n) + dice.next()) / static_cast<float>(n);
          sum = sum + tracer.pixel(2 * px / static_cast<float>(settings.width) - 1,
                                   1 - 2 * py / static_cast<float>(settings.height), dice, s);
        }
        image.set(x, y, shown(sum * (1 / static_cast<float>(n * n))));
      }
    }
  };
  const unsigned count = settings.threads > 0 ? static_cast<unsigned>(settings.threads)
                                              : std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::thread> helpers;
  for (unsigned i = 1; i < count; ++i) helpers.emplace_back(work);
  work();
  for (std::thread& helper : helpers) helper.join();
  return image;
}

bool eye_in_solid(const FrameShapes& shapes, const Camera& camera) {
  if (shapes.solid.empty() && shapes.balls.empty()) return false;
  const Bvh bvh(shapes);
  const Vec3f eye = meltsim::cast<float>(camera.eye - shapes.origin);
  const Hit hit = bvh.nearest({eye, unit(meltsim::cast<float>(camera.look_at - camera.eye))});
  if (!hit.any() || !bvh.is_solid(hit.primitive)) return false;
  if (bvh.is_ball(hit.primitive))
    return length(bvh.ball(hit.primitive).center - eye) < bvh.ball(hit.primitive).radius;
  const Mesh& mesh = bvh.mesh(hit.primitive);
  const std::size_t t = bvh.triangle(hit.primitive);
  const Vec3f a = mesh.position[mesh.triangles[t]], b = mesh.position[mesh.triangles[t + 1]],
              c = mesh.position[mesh.triangles[t + 2]];
  return dot(cross(b - a, c - a), a - eye) > 0;
}

}  // namespace runner
