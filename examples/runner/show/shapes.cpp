// SPDX-License-Identifier: Apache-2.0
#include "show/shapes.hpp"

#include <algorithm>
#include <cmath>

#include "show/ramp.hpp"

namespace runner {

using meltsim::Vec3d;
using meltsim::Vec3f;

void add_balls(FrameShapes& shapes, const std::vector<FrameParticle>& particles, double spacing) {
  for (const FrameParticle& p : particles) {
    const bool solid = p.phase == 1;
    if (p.phase > 1 || !(solid ? shapes.solid : shapes.liquid).empty()) continue;
    const Vec3d x{p.position[0], p.position[1], p.position[2]};
    // A little more than touching: gaps between balls are noise in a picture.
    shapes.balls.push_back({meltsim::cast<float>(x - shapes.origin), static_cast<float>(0.56 * spacing),
                            p.temperature, static_cast<std::uint32_t>(p.body + 1), solid,
                            static_cast<std::uint32_t>(p.material)});
  }
}

void drop_unused(Mesh& mesh) {
  std::vector<std::uint32_t> number(mesh.position.size(), 0);
  for (const std::uint32_t v : mesh.triangles) number[v] = 1;
  std::uint32_t used = 0;
  for (std::uint32_t& n : number) n = n != 0 ? ++used : 0;  // from 1; 0: drop it
  const auto pack = [&number, used](auto& values) {
    if (values.empty()) return;
    for (std::size_t v = 0; v < number.size(); ++v)
      if (number[v] != 0) values[number[v] - 1] = values[v];
    values.resize(used);
  };
  pack(mesh.position);
  pack(mesh.normal);
  pack(mesh.temperature);
  pack(mesh.liquid_fraction);
  pack(mesh.body);
  pack(mesh.material);
  pack(mesh.color);
  for (std::vector<float>& content : mesh.contents) pack(content);
  for (std::uint32_t& v : mesh.triangles) v = number[v] - 1;
}

std::uint32_t material_of_triangle(const Mesh& mesh, std::size_t first) {
  const auto at = [&](std::size_t k) { return mesh.material[mesh.triangles[first + k]]; };
  return at(1) == at(2) ? at(1) : at(0);
}

namespace {

/// How often colours are averaged over neighbours: a material changes from vertex to vertex, and its edge would
/// follow the triangles.
constexpr int color_passes = 4;

/// Colour times its share, and the share of what has a colour.
struct Dye {
  Vec3f color{0, 0, 0};
  float share = 0;
};

Vec3f linear_color(const std::array<double, 3>& shown) {
  const Rgb c = linear(shown);
  return meltsim::cast<float>(Vec3d{c[0], c[1], c[2]});
}

/// Of a mixture: what has no colour counts as the solvent, which shows nothing where that has none.
Dye mixed(const Mesh& mesh, std::size_t v, const std::vector<SceneLook>& looks, Dye dye) {
  Vec3f color{0, 0, 0};
  float colored = 0;
  for (std::size_t k = 0; k < mesh.species.size(); ++k) {
    const auto* own = color_of(looks, mesh.species[k]);
    const float w = std::max(mesh.contents[k][v], 0.0f);
    if (own == nullptr || !(w > 0)) continue;
    color = color + linear_color(*own) * w;
    colored += w;
  }
  if (!(colored > 0)) return dye;
  if (colored > 1) {
    color = color * (1 / colored);
    colored = 1;
  }
  if (dye.share > 0) return {dye.color * (1 - colored) + color, 1};
  constexpr float visible = 0.05f;  // half of it cuts the surface
  const float share = std::min(1.0f, colored / visible);
  return {color * (share / colored), share};
}

std::vector<Dye> dyes_of(const Mesh& mesh, const std::vector<SceneLook>& looks) {
  std::vector<Dye> dyes(mesh.position.size());
  for (std::size_t v = 0; v < dyes.size(); ++v) {
    if (const auto* color = color_of(looks, mesh.material[v])) dyes[v] = {linear_color(*color), 1};
    dyes[v] = mixed(mesh, v, looks, dyes[v]);
  }
  for (int pass = 0; pass < color_passes; ++pass) {
    std::vector<Dye> sum(dyes.size());
    std::vector<float> count(dyes.size(), 0);
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh.triangles[t + k];
        for (const std::uint32_t other : {mesh.triangles[t + (k + 1) % 3], mesh.triangles[t + (k + 2) % 3]}) {
          sum[v].color = sum[v].color + dyes[other].color;
          sum[v].share += dyes[other].share;
          count[v] += 1;
        }
      }
    }
    for (std::size_t v = 0; v < dyes.size(); ++v) {
      if (count[v] == 0) continue;
      const float part = 0.5f / count[v];
      dyes[v] = {dyes[v].color * 0.5f + sum[v].color * part, 0.5f * dyes[v].share + sum[v].share * part};
    }
  }
  return dyes;
}

/// Cuts a mesh's triangles where the share of dye is one half.
class Cutter {
 public:
  Cutter(Mesh& mesh, std::vector<Dye>& dyes) : mesh_(mesh), dyes_(dyes) {}

  void cut(std::vector<std::uint32_t>& dyed, std::vector<std::uint32_t>& clear) {
    const std::vector<std::uint32_t> all = std::move(mesh_.triangles);
    mesh_.triangles.clear();
    for (std::size_t t = 0; t + 2 < all.size(); t += 3) {
      const std::uint32_t v[3] = {all[t], all[t + 1], all[t + 2]};
      int inside = 0;
      for (const std::uint32_t k : v) inside += is_dyed(k) ? 1 : 0;
      if (inside == 0 || inside == 3) {
        auto& to = inside == 3 ? dyed : clear;
        to.insert(to.end(), {v[0], v[1], v[2]});
        continue;
      }
      // The corner that is alone on its side, then the others in order.
      std::size_t alone = 0;
      while (is_dyed(v[alone]) != (inside == 1)) ++alone;
      const std::uint32_t a = v[alone], b = v[(alone + 1) % 3], c = v[(alone + 2) % 3];
      const std::uint32_t ab = between(a, b), ac = between(a, c);
      auto& one = inside == 1 ? dyed : clear;
      auto& two = inside == 1 ? clear : dyed;
      one.insert(one.end(), {a, ab, ac});
      two.insert(two.end(), {ab, b, c, ab, c, ac});
    }
  }

 private:
  bool is_dyed(std::uint32_t v) const { return dyes_[v].share > 0.5f; }

  std::uint32_t between(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [found, fresh] = cuts_.try_emplace({a, b}, static_cast<std::uint32_t>(mesh_.position.size()));
    if (!fresh) return found->second;
    const float t = (0.5f - dyes_[a].share) / (dyes_[b].share - dyes_[a].share);
    const auto mix = [t](const auto& x, const auto& y) { return x * (1 - t) + y * t; };
    const Vec3f normal = mix(mesh_.normal[a], mesh_.normal[b]);
    const std::uint32_t nearer = t < 0.5f ? a : b;
    mesh_.position.push_back(mix(mesh_.position[a], mesh_.position[b]));
    mesh_.normal.push_back(normal * (1 / std::max(length(normal), 1e-20f)));
    mesh_.temperature.push_back(mix(mesh_.temperature[a], mesh_.temperature[b]));
    if (!mesh_.liquid_fraction.empty())
      mesh_.liquid_fraction.push_back(mix(mesh_.liquid_fraction[a], mesh_.liquid_fraction[b]));
    for (std::vector<float>& content : mesh_.contents) content.push_back(mix(content[a], content[b]));
    mesh_.body.push_back(mesh_.body[nearer]);
    mesh_.material.push_back(mesh_.material[nearer]);
    dyes_.push_back({mix(dyes_[a].color, dyes_[b].color), 0.5f});
    return found->second;
  }

  Mesh& mesh_;
  std::vector<Dye>& dyes_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> cuts_;
};

}  // namespace

std::vector<std::uint32_t> shown_species(const Scene& scene) {
  std::vector<std::uint32_t> species;
  for (std::size_t m = 0; m < scene.materials.size(); ++m)
    if (!scene.materials[m].dissolves_in.empty())
      species.push_back(shown_species(static_cast<std::uint32_t>(m), scene.materials[m].desc));
  return species;
}

void add_contents(FrameShapes& shapes, const std::vector<FrameParticle>& particles,
                  const std::vector<std::uint32_t>& species, double spacing) {
  Mesh& mesh = shapes.liquid;
  if (species.empty() || mesh.empty()) return;
  const double reach = 1.5 * spacing;
  using Cell = std::array<std::int64_t, 3>;
  const auto cell_of = [reach](const Vec3d& x) {
    return Cell{static_cast<std::int64_t>(std::floor(x.x / reach)),
                static_cast<std::int64_t>(std::floor(x.y / reach)),
                static_cast<std::int64_t>(std::floor(x.z / reach))};
  };
  std::map<Cell, std::vector<std::uint32_t>> cells;
  const auto place = [&](const FrameParticle& p) {
    return Vec3d{p.position[0], p.position[1], p.position[2]} - shapes.origin;
  };
  for (std::size_t i = 0; i < particles.size(); ++i)
    if (particles[i].phase == 0) cells[cell_of(place(particles[i]))].push_back(static_cast<std::uint32_t>(i));
  mesh.species = species;
  mesh.contents.assign(species.size(), std::vector<float>(mesh.position.size(), 0.0f));
  for (std::size_t v = 0; v < mesh.position.size(); ++v) {
    const Vec3d x = meltsim::cast<double>(mesh.position[v]);
    const Cell middle = cell_of(x);
    double weight = 0, sum[meltsim::most_species] = {};
    for (std::int64_t a = -1; a <= 1; ++a)
      for (std::int64_t b = -1; b <= 1; ++b)
        for (std::int64_t c = -1; c <= 1; ++c) {
          const auto found = cells.find({middle[0] + a, middle[1] + b, middle[2] + c});
          if (found == cells.end()) continue;
          for (const std::uint32_t i : found->second) {
            const Vec3d d = place(particles[i]) - x;
            const double near = 1 - dot(d, d) / (reach * reach);
            if (!(near > 0)) continue;
            weight += near * near;
            for (std::size_t k = 0; k < species.size(); ++k)
              sum[k] += near * near * static_cast<double>(particles[i].contents[k]);
          }
        }
    for (std::size_t k = 0; k < species.size() && weight > 0; ++k)
      mesh.contents[k][v] = static_cast<float>(sum[k] / weight);
  }
}

FrameShapes split_liquid(FrameShapes shapes, const std::vector<SceneLook>& looks) {
  Mesh& liquid = shapes.liquid;
  const auto has_color = [&](std::uint32_t m) { return color_of(looks, m) != nullptr; };
  if (std::none_of(liquid.material.begin(), liquid.material.end(), has_color) &&
      std::none_of(liquid.species.begin(), liquid.species.end(), has_color))
    return shapes;
  std::vector<Dye> dyes = dyes_of(liquid, looks);
  std::vector<std::uint32_t> dyed, clear;
  Cutter(liquid, dyes).cut(dyed, clear);
  shapes.paint = liquid;  // vertices of others do no harm
  shapes.paint.triangles = std::move(dyed);
  for (const Dye& dye : dyes) shapes.paint.color.push_back(dye.color * (1 / std::max(dye.share, 1e-6f)));
  liquid.triangles = std::move(clear);
  return shapes;
}

FrameShapes visible_part(FrameShapes shapes, const std::vector<bool>& visible) {
  std::vector<std::uint32_t> shown;
  const std::vector<std::uint32_t>& corners = shapes.solid.triangles;
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3)
    if (!is_hidden(visible, shapes.solid.body[corners[t]]))
      shown.insert(shown.end(), {corners[t], corners[t + 1], corners[t + 2]});
  shapes.solid.triangles = std::move(shown);
  const auto unseen = [&](const Ball& ball) { return ball.solid && is_hidden(visible, ball.body); };
  shapes.balls.erase(std::remove_if(shapes.balls.begin(), shapes.balls.end(), unseen), shapes.balls.end());
  return shapes;
}

Box box_of(const FrameShapes& shapes) {
  Box box;
  const auto add = [&](const Vec3f& x) { box.add(shapes.origin + meltsim::cast<double>(x)); };
  for (const Mesh* mesh : {&shapes.liquid, &shapes.solid}) {
    for (const Vec3f& x : mesh->position) add(x);
  }
  for (const Ball& ball : shapes.balls) {
    const Vec3f r{ball.radius, ball.radius, ball.radius};
    add(ball.center - r);
    add(ball.center + r);
  }
  return box;
}

}  // namespace runner
