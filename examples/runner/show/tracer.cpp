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
const Vec3f horizon{0.50f, 0.56f, 0.62f}, zenith{0.12f, 0.19f, 0.29f}, sunlight{2.1f, 2.0f, 1.85f};
const Vec3f absorbed{2.6f, 0.75f, 0.42f};    ///< by a depth of liquid as large as the picture's contents
const Vec3f scattered{0.01f, 0.11f, 0.17f};  ///< what very deep liquid shows
const Vec3f liquid_color{0.07f, 0.24f, 0.55f}, tank_color{0.035f, 0.04f, 0.045f};
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

/// A mesh of boxes; only positions and triangles are of use.
Mesh mesh_of(const std::vector<Bar>& bars, const Vec3d& origin) {
  constexpr std::uint32_t faces[12][3] = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                                          {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  Mesh mesh;
  for (const Bar& bar : bars) {
    const auto first = static_cast<std::uint32_t>(mesh.position.size());
    for (int c = 0; c < 8; ++c) {
      const Vec3d x{(c & 1) != 0 ? bar.max.x : bar.min.x, (c & 2) != 0 ? bar.max.y : bar.min.y,
                    (c & 4) != 0 ? bar.max.z : bar.min.z};
      mesh.position.push_back(meltsim::cast<float>(x - origin));
    }
    for (const auto& face : faces)
      for (const std::uint32_t corner : face) mesh.triangles.push_back(first + corner);
  }
  return mesh;
}

FrameShapes with_tank(FrameShapes shapes, const std::vector<Bar>& bars) {
  shapes.tank = mesh_of(bars, shapes.origin);
  return shapes;
}

/// What a ray met.
struct Surface {
  Vec3f at, normal;  ///< of the shading, on the outside
  Vec3f color;
  bool solid = true, outside = true;  ///< outside: the ray comes from there
};

class Tracer {
 public:
  Tracer(const FrameShapes& shapes, const Camera& camera, const TraceSettings& settings)
      : shapes_(with_tank(settings.look == Look::natural ? split_liquid(shapes, settings.looks) : shapes,
                          settings.tank)),
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
    window_ = unit(up_ * 0.75f - right_ * 0.35f + front_ * 0.8f);
    floor_ = static_cast<float>(settings.floor - dot(camera.up, shapes.origin));
    if (!settings.basin.empty()) {
      basin_low_ = meltsim::cast<float>(settings.basin.min - shapes.origin);
      basin_high_ = meltsim::cast<float>(settings.basin.max - shapes.origin);
      // A little below the liquid's own lowest face.
      const Vec3f bottom{up_.x > 0 ? basin_low_.x : basin_high_.x, up_.y > 0 ? basin_low_.y : basin_high_.y,
                         up_.z > 0 ? basin_low_.z : basin_high_.z};
      basin_floor_ = dot(bottom, up_) - 0.02f * static_cast<float>(settings.spacing);
    }
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
  /// A studio: light from above, the sun, and a window to the left whose mirror image shows the waves.
  Vec3f sky(const Vec3f& along) const {
    const float height = dot(along, up_);
    const float glow = std::pow(std::max(0.0f, dot(along, sun_)), 350.0f);
    const float window = smooth(0.86f, 0.93f, dot(along, window_));
    return mix(horizon, zenith, smooth(0, 0.9f, height)) + sunlight * (6 * glow) +
           Vec3f{1.0f, 1.05f, 1.1f} * window;
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
      if (bvh_.is_tank(hit.primitive)) {
        s.normal = unit(flat);
        s.color = tank_color;
        return s;
      }
      // Along an axis exactly: on a wall, which is flat up to its edges.
      const bool on_wall = (flat.x == 0) + (flat.y == 0) + (flat.z == 0) == 2;
      s.normal = unit(on_wall ? flat : mesh.normal[a] * w + mesh.normal[b] * hit.u + mesh.normal[c] * hit.v);
      temperature = mesh.temperature[a] * w + mesh.temperature[b] * hit.u + mesh.temperature[c] * hit.v;
      body = mesh.body[a];
      if (bvh_.is_paint(hit.primitive))
        own = mesh.color[a] * w + mesh.color[b] * hit.u + mesh.color[c] * hit.v;
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

  /// `inside`: of the basin.
  Vec3f floor_color(const Vec3f& at, const Vec3f& along, Dice& dice, int sample, bool inside) const {
    const Vec3f off = at - middle_;
    const Vec3f level = off - up_ * dot(off, up_);
    const Vec3f east = unit(cross(up_, std::abs(up_.x) < 0.8f ? Vec3f{1, 0, 0} : Vec3f{0, 0, 1})),
                north = cross(up_, east);
    const auto cell = [&](const Vec3f& axis) { return static_cast<int>(std::floor(dot(at, axis) / tile_)); };
    const bool dark = ((cell(east) + cell(north)) & 1) != 0;
    Surface s;
    s.at = at;
    s.normal = up_;
    if (inside) s.color = dark ? Vec3f{0.16f, 0.18f, 0.20f} : Vec3f{0.34f, 0.36f, 0.38f};
    else s.color = dark ? Vec3f{0.33f, 0.35f, 0.37f} : Vec3f{0.40f, 0.42f, 0.44f};
    const float far = inside ? 0 : smooth(0.9f * size_, 3.5f * size_, length(level));
    // Beyond what the picture is about the floor fades into the horizon.
    if (far >= 1) return horizon;
    return mix(lit(s, along, dice, sample, 0), horizon, far);
  }

  bool over_basin(const Vec3f& x) const {
    const auto within = [](float along_up, float low, float at, float high) {
      return std::abs(along_up) > 0.7f || (at > low && at < high);
    };
    return within(up_.x, basin_low_.x, x.x, basin_high_.x) &&
           within(up_.y, basin_low_.y, x.y, basin_high_.y) && within(up_.z, basin_low_.z, x.z, basin_high_.z);
  }

  /// Where a ray that goes down meets the floor, or the basin's own.
  struct Ground {
    float distance = 1e30f;
    bool basin = false;
  };
  /// `inside`: from inside the liquid, which rests on the floor: the film of air below it is not there.
  Ground ground(const Ray& ray, float down, float most, bool inside) const {
    if (!settings_.has_floor || down >= 0) return {};
    const float height = dot(ray.from, up_), spacing = inside ? static_cast<float>(settings_.spacing) : 0;
    const auto meets = [&](float level, float film) {
      const float to = (level + film - height) / down;
      return to <= 0 && film > 0 && height >= level ? lift() : to;  // begins in the film
    };
    if (!settings_.basin.empty()) {
      const float to = meets(basin_floor_, 0.05f * spacing);  // the surface is closed at the wall below
      if (to > 0 && to < most && over_basin(ray.from + ray.along * to)) return {to, true};
    }
    const float to = meets(floor_, settings_.basin.empty() ? 0.7f * spacing : 0);
    if (to > 0 && to < most) return {to, false};
    return {};
  }

  /// submerged: the ray starts in liquid.
  Vec3f color(const Ray& ray, Dice& dice, int sample, int depth, float weight, bool submerged = false) const {
    const Hit hit = bvh_.nearest(ray);
    const bool met = hit.any();
    Surface s;
    if (met) s = surface(ray, hit);
    const bool inside = met && !s.solid && !s.outside;
    const Ground found = ground(ray, dot(ray.along, up_), hit.distance, inside);
    if (found.distance < hit.distance) {
      const Vec3f own =
          floor_color(ray.from + ray.along * found.distance, ray.along, dice, sample, found.basin);
      return inside ? veiled(own, found.distance) : own;
    }
    if (!met) return sky(ray.along);
    if (settings_.look == Look::temperature) return warm_color(ray, s, dice, sample, depth, weight);
    if (s.solid) {
      const Vec3f own = lit(s, ray.along, dice, sample, 0.25f);
      return submerged ? veiled(own, hit.distance) : own;
    }
    if (!see_through_) return lit(s, ray.along, dice, sample, 0.35f);
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

  /// What is seen through a distance of liquid: less of what lies behind, and some light from between.
  Vec3f veiled(const Vec3f& behind, float distance) const {
    const float x = distance / size_;
    const Vec3f passed{std::exp(-absorbed.x * x), std::exp(-absorbed.y * x), std::exp(-absorbed.z * x)};
    return times(behind, passed) + times(scattered, Vec3f{1, 1, 1} - passed);
  }

  Vec3f liquid(const Ray& ray, const Surface& s, float distance, Dice& dice, int sample, int depth,
               float weight) const {
    const Vec3f n = s.outside ? s.normal : Vec3f{0, 0, 0} - s.normal;
    const float cosine = std::clamp(-dot(n, ray.along), 0.02f, 1.0f);
    const float eta = s.outside ? 1 / refraction : refraction;
    const float k = 1 - eta * eta * (1 - cosine * cosine);
    const auto through = [&](const Vec3f& light) { return s.outside ? light : veiled(light, distance); };
    const Vec3f mirrored = unit(ray.along + n * (2 * cosine));
    if (depth >= deepest || weight < 0.04f) return through(sky(mirrored));
    const Ray back{s.at + n * lift(), mirrored};
    if (k <= 0) return through(color(back, dice, sample, depth + 1, weight, true));
    const float outer = s.outside ? cosine : std::sqrt(k), grazing = 1 - outer, g2 = grazing * grazing;
    const float fresnel = 0.02f + 0.98f * g2 * g2 * grazing;  // Schlick 1994
    const Vec3f bent = unit(ray.along * eta + n * (eta * cosine - std::sqrt(k)));
    const Ray on{s.at - n * lift(), bent};
    const Vec3f refracted = color(on, dice, sample, depth + 1, weight * (1 - fresnel), s.outside);
    // Faint mirrorings of mirrorings are not worth a ray.
    const Vec3f reflected = fresnel * weight < 0.03f && depth > 0
                                ? sky(mirrored)
                                : color(back, dice, sample, depth + 1, weight * fresnel, !s.outside);
    return through(refracted * (1 - fresnel) + reflected * fresnel);
  }

  /// Rays start this far from the surface they leave.
  float lift() const { return 1e-4f * size_; }

  FrameShapes shapes_;
  Bvh bvh_;
  const TraceSettings& settings_;
  Vec3f eye_, up_, front_, right_, above_, sun_, across_, window_, middle_, basin_low_, basin_high_;
  float tangent_ = 1, floor_ = 0, basin_floor_ = 0, size_ = 1, tile_ = 1;
  bool see_through_ = false;
};

/// Linear light to what a monitor shows, bright parts held back.
Rgb shown(const Vec3f& light) {
  const auto one = [](float c) {
    const double x = std::max(0.0f, c);
    const double held = x < 0.7 ? x : 0.7 + 0.3 * (1 - std::exp(-(x - 0.7) / 0.3));
    return monitor(std::min(held, 1.0));
  };
  return {one(light.x), one(light.y), one(light.z)};
}

}  // namespace

double tile_size(double size) {
  const double power = std::pow(10.0, std::floor(std::log10(size / 6))), rest = size / 6 / power;
  return power * (rest < 2 ? 1 : rest < 5 ? 2 : 5);
}

Rgb body_color(const TraceSettings& settings, std::size_t body) {
  const std::size_t index = std::max<std::size_t>(body, 1) - 1;
  return index < settings.bodies.size() ? settings.bodies[index] : palette_color(index);
}

namespace {

/// Calls row(y) for every row, in several threads.
template <class Row>
void each_row(int height, int threads, const Row& row) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int y = next++; y < height; y = next++) row(y);
  };
  const unsigned count =
      threads > 0 ? static_cast<unsigned>(threads) : std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::thread> helpers;
  for (unsigned i = 1; i < count; ++i) helpers.emplace_back(work);
  work();
  for (std::thread& helper : helpers) helper.join();
}

/// A pixel while samples are added to it.
struct Pixel {
  Vec3f sum{0, 0, 0};
  float count = 0;
  Rgb first{};    ///< as a monitor shows its first sample,
  Rgb average{};  ///< and all of those that every pixel has
  bool uneven = false;
};

float difference(const Rgb& a, const Rgb& b) {
  double most = 0;
  for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return static_cast<float>(most);
}

}  // namespace

Image traced(const FrameShapes& shapes, const Camera& camera, const TraceSettings& settings) {
  Image image(settings.width, settings.height);
  const Tracer tracer(shapes, camera, settings);
  const int n = settings.samples, all = n * n, few = std::min(2, all);
  std::vector<Pixel> pixels(static_cast<std::size_t>(settings.width) *
                            static_cast<std::size_t>(settings.height));
  const auto at = [&](int x, int y) -> Pixel& {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(settings.width) +
                  static_cast<std::size_t>(x)];
  };
  const auto sample = [&](int x, int y, int s) {
    Dice dice(static_cast<std::uint32_t>((y * settings.width + x) * 64 + s));
    const float px =
        static_cast<float>(x) + (static_cast<float>(s % n) + dice.next()) / static_cast<float>(n);
    const float py =
        static_cast<float>(y) + (static_cast<float>(s / n) + dice.next()) / static_cast<float>(n);
    return tracer.pixel(2 * px / static_cast<float>(settings.width) - 1,
                        1 - 2 * py / static_cast<float>(settings.height), dice, s);
  };
  const auto order = [&](int k) { return k * (all / few) % all; };  // the first two lie half a pixel apart
  each_row(settings.height, settings.threads, [&](int y) {
    for (int x = 0; x < settings.width; ++x) {
      Pixel& p = at(x, y);
      for (int k = 0; k < few; ++k) {
        p.sum = p.sum + sample(x, y, order(k));
        p.count += 1;
        if (k == 0) p.first = shown(p.sum);
      }
      p.average = shown(p.sum * (1 / p.count));
    }
  });
  // Where a pixel's samples or its neighbours differ by what an eye sees, it gets the rest of its samples, and so do
  // those beside it: what only some samples meet would leave grains.
  constexpr float seen = 0.02f;
  const auto beside = [&](int x, int y, const auto& visit) {
    for (int j = std::max(0, y - 1); j <= std::min(settings.height - 1, y + 1); ++j)
      for (int i = std::max(0, x - 1); i <= std::min(settings.width - 1, x + 1); ++i) visit(at(i, j));
  };
  each_row(settings.height, settings.threads, [&](int y) {
    for (int x = 0; x < settings.width; ++x) {
      Pixel& p = at(x, y);
      float most = 2 * difference(p.first, p.average);
      beside(x, y, [&](const Pixel& other) { most = std::max(most, difference(p.average, other.average)); });
      p.uneven = most > 2 * seen;
    }
  });
  each_row(settings.height, settings.threads, [&](int y) {
    for (int x = 0; x < settings.width; ++x) {
      Pixel& p = at(x, y);
      bool refine = false;
      beside(x, y, [&](const Pixel& other) { refine = refine || other.uneven; });
      for (int s = 0; s < all && refine; ++s) {
        bool done = false;
        for (int k = 0; k < few; ++k) done = done || s == order(k);
        if (done) continue;
        p.sum = p.sum + sample(x, y, s);
        p.count += 1;
      }
      image.set(x, y, shown(p.sum * (1 / p.count)));
    }
  });
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
