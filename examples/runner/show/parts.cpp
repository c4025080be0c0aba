// SPDX-License-Identifier: Apache-2.0
#include "show/parts.hpp"

#include <algorithm>
#include <set>

#include "load_scene.hpp"

namespace runner {

namespace {

using meltsim::Vec3f;

constexpr double clear_opacity = 0.2, clear_roughness = 0.02;
constexpr Rgb clear_color{0.86, 0.94,
                          0.97};  // a trace of blue, since renderers that do not refract show a veil
constexpr double warm_liquid_opacity = 0.6;  // what is in the liquid stays visible

Vec3f vector_of(const Rgb& c) { return meltsim::cast<float>(meltsim::Vec3d{c[0], c[1], c[2]}); }

/// "ice", "ice_2", ...: readers tell materials apart by name.
std::size_t add_look(PartLooks& looks, PartLook look) {
  const auto taken = [&looks](const std::string& name) {
    return std::any_of(looks.all.begin(), looks.all.end(),
                       [&name](const PartLook& other) { return other.name == name; });
  };
  const std::string name = look.name;
  for (int number = 2; taken(look.name); ++number) look.name = name + "_" + std::to_string(number);
  looks.all.push_back(std::move(look));
  return looks.all.size() - 1;
}

/// Materials that are liquid at some time of a run, by name.
std::set<std::string> liquid_materials(const Scene& scene) {
  std::set<std::string> names;
  for (const SceneFluid& fluid : scene.fluids) names.insert(fluid.material);
  for (const SceneEmitter& emitter : scene.emitters) names.insert(emitter.material);
  for (const SceneMaterial& material : scene.materials) {
    if (!material.becomes.empty()) names.insert(material.becomes);
    if (!material.dissolves_in.empty()) names.insert(material.dissolves_in);
  }
  return names;
}

std::size_t look_of_material(PartLooks& looks, std::uint32_t material) {
  const auto [found, fresh] = looks.of_material.try_emplace(material, 0);
  const SceneLook& own = looks.materials[material];
  if (fresh) found->second = add_look(looks, {own.name, linear(*own.color)});
  return found->second;
}

/// Liquids come first: importers number materials in this order.
void add_liquid_looks(PartLooks& looks, const Scene& scene) {
  const std::set<std::string> names = liquid_materials(scene);
  std::vector<std::uint32_t> colored;
  bool has_clear = names.empty();
  for (std::uint32_t m = 0; m < looks.materials.size(); ++m) {
    if (names.count(looks.materials[m].name) == 0) continue;
    if (looks.materials[m].color) colored.push_back(m);
    else has_clear = true;
  }
  const std::vector<std::uint32_t> species = shown_species(scene);
  looks.mixed = colored.size() > 1 || std::any_of(species.begin(), species.end(), [&](std::uint32_t m) {
                  return color_of(looks.materials, m) != nullptr;
                });
  if (has_clear)
    looks.liquid.push_back(
        add_look(looks, {"liquid", clear_color, clear_opacity, clear_roughness, true, false}));
  if (looks.mixed) {
    looks.liquid.push_back(add_look(looks, {"dyed", {1, 1, 1}, 1, 0.4, false, true}));
  } else {
    for (const std::uint32_t m : colored) looks.liquid.push_back(look_of_material(looks, m));
  }
}

/// A colour per body, as pictures have: that of its material, or one of the palette.
void add_solid_looks(PartLooks& looks, const Scene& scene) {
  std::map<std::size_t, std::size_t> palette;  // after its last colour bodies share them
  for (const SceneBody& body : scene.bodies) {
    const std::string name = body.density ? dense_material(body.material, *body.density) : body.material;
    const std::size_t slot = looks.of_body.size() % body_palette.size();
    std::size_t look = 0;
    if (look_color(scene.output, body.material)) {
      for (std::uint32_t m = 0; m < looks.materials.size(); ++m)
        if (looks.materials[m].name == name) look = look_of_material(looks, m);
    } else {
      const auto [found, fresh] = palette.try_emplace(slot, 0);
      if (fresh) found->second = add_look(looks, {body.material, palette_color(slot)});
      look = found->second;
    }
    looks.of_body.push_back(look);
    if (std::find(looks.solid.begin(), looks.solid.end(), look) == looks.solid.end())
      looks.solid.push_back(look);
  }
  if (looks.solid.empty()) looks.solid.push_back(add_look(looks, {"solid", palette_color(0)}));
}

void color_by_temperature(Mesh& mesh, const PartLooks& looks) {
  mesh.color.clear();
  for (const float t : mesh.temperature)
    mesh.color.push_back(vector_of(linear(warmth_of(t, looks.cold, looks.hot))));
}

/// Vertices have the colour of their part, but for those of parts that are coloured by vertex.
void color_by_part(PartedMesh& parted, const PartLooks& looks) {
  std::vector<Vec3f>& color = parted.mesh.color;
  color.resize(parted.mesh.position.size(), vector_of({1, 1, 1}));
  const std::vector<Vec3f> own = color;
  for (const bool by_vertex : {false, true}) {  // a vertex of both kinds keeps its own
    for (const auto& [look, triangles] : parted.triangles) {
      if (looks.all[look].by_vertex != by_vertex) continue;
      for (const std::uint32_t v : triangles)
        color[v] = by_vertex ? own[v] : vector_of(looks.all[look].color);
    }
  }
}

}  // namespace

PartLooks part_looks(const Scene& scene, const PictureWish& wish) {
  PartLooks looks;
  looks.by_temperature = wish.look == Look::temperature;
  looks.cold = wish.cold;
  looks.hot = wish.hot;
  looks.materials = scene.output.looks;
  if (looks.by_temperature) {
    looks.liquid = {add_look(looks, {"liquid", {1, 1, 1}, warm_liquid_opacity, 0.1, false, true})};
    looks.solid = {add_look(looks, {"solid", {1, 1, 1}, 1, 0.6, false, true})};
  } else {
    add_liquid_looks(looks, scene);
    add_solid_looks(looks, scene);
  }
  return looks;
}

PartedMesh liquid_parts(const FrameShapes& shapes, const PartLooks& looks) {
  PartedMesh parted;
  const bool mixed = looks.mixed && !shapes.liquid.empty();
  const FrameShapes split = mixed ? split_liquid(shapes, looks.materials) : FrameShapes{};
  if (mixed && !split.paint.empty()) {  // both parts have the same vertices
    parted.mesh = split.paint;
    parted.mesh.triangles = shapes.liquid.triangles;
    if (!split.liquid.empty()) parted.triangles[looks.liquid.front()] = split.liquid.triangles;
    parted.triangles[looks.liquid.back()] = split.paint.triangles;
  } else {
    parted.mesh = shapes.liquid;
    parted.triangles = grouped(shapes.liquid, [&](std::size_t t) {
      const auto own = looks.of_material.find(material_of_triangle(shapes.liquid, t));
      const bool colored = own != looks.of_material.end() && !looks.by_temperature && !looks.mixed;
      return colored ? own->second : looks.liquid.front();
    });
  }
  if (looks.by_temperature) color_by_temperature(parted.mesh, looks);
  color_by_part(parted, looks);
  return parted;
}

PartedMesh solid_parts(const FrameShapes& shapes, const PartLooks& looks) {
  PartedMesh parted;
  parted.mesh = shapes.solid;
  parted.triangles = grouped(shapes.solid, [&](std::size_t t) {
    const std::uint32_t body = shapes.solid.body[shapes.solid.triangles[t]];  // 1 + index
    const bool known = body > 0 && body <= looks.of_body.size();
    return known ? looks.of_body[body - 1] : looks.solid.front();
  });
  if (looks.by_temperature) color_by_temperature(parted.mesh, looks);
  color_by_part(parted, looks);
  return parted;
}

}  // namespace runner
