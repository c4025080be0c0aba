// SPDX-License-Identifier: Apache-2.0
#include "room_to_melt.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "expect.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

// Of the domain: less is as little as sound of ten times the speed compresses liquid by.
constexpr double least_compression = 0.01;

bool lets_nothing_out(const Scene& scene) {
  const meltsim::DomainDesc& domain = scene.world.domain;
  return domain.bounded && std::count(domain.faces.begin(), domain.faces.end(), meltsim::Face::open) == 0;
}

const SceneMaterial* material_named(const Scene& scene, const std::string& name) {
  const auto found = std::find_if(scene.materials.begin(), scene.materials.end(),
                                  [&](const SceneMaterial& m) { return m.desc.name == name; });
  return found == scene.materials.end() ? nullptr : &*found;
}

/// Volume of what can melt [m^3]: how much more it is as liquid, and of which body the most.
struct Growth {
  double all = 0, largest = 0;
  const SceneBody* body = nullptr;
};

Growth growth_of(const Scene& scene, const Built& built, const std::vector<meltsim::PieceInfo>& pieces) {
  Growth growth;
  for (const meltsim::PieceInfo& piece : pieces) {
    const SceneBody& body = scene.bodies.at(piece.body.index);
    const SceneMaterial* solid = material_named(scene, body.material);
    // A body of a density of its own melts into liquid of a density of its own.
    if (!built.body_melts.at(piece.body.index) || body.density || solid == nullptr) continue;
    const SceneMaterial* liquid = material_named(scene, solid->becomes);
    if (liquid == nullptr) continue;
    const double more = piece.mass * (1 / liquid->desc.density - 1 / solid->desc.density);
    growth.all += more;
    if (more <= growth.largest) continue;
    growth.largest = more;
    growth.body = &body;
  }
  return growth;
}

}  // namespace

std::vector<std::string> room_to_melt(const Scene& scene, Built& built) {
  if (!lets_nothing_out(scene) || !built.melts) return {};
  const std::vector<meltsim::PieceInfo> pieces = expect(built.world.pieces());
  const Growth growth = growth_of(scene, built, pieces);
  if (growth.body == nullptr) return {};
  double liquid = expect(built.world.totals()).mass, solid = 0, densest = 0;
  for (const meltsim::PieceInfo& piece : pieces) {
    const SceneBody& body = scene.bodies.at(piece.body.index);
    const SceneMaterial* material = material_named(scene, body.material);
    liquid -= piece.mass;
    if (material != nullptr) solid += piece.mass / body.density.value_or(material->desc.density);
  }
  for (const SceneFluid& fluid : scene.fluids)
    if (const SceneMaterial* m = material_named(scene, fluid.material))
      densest = std::max(densest, m->desc.density);
  const meltsim::Vec3d size = scene.world.domain.max - scene.world.domain.min;
  const double domain = size.x * size.y * size.z;
  const double room = domain - solid - (densest > 0 ? liquid / densest : 0);
  if (growth.all < room + least_compression * domain) return {};
  return {fmt::format(
      "{}: {}.material: what melts takes up {} m^3 more as liquid than as solid, and the closed domain has "
      "{} m^3 free: the liquid is compressed by {}, which drives it about; make the domain larger, leave a "
      "gap, open a face, or give solid and liquid one density",
      growth.body->source.where, growth.body->source.path, two_digits(growth.all),
      two_digits(std::max(room, 0.0)), percent_text((growth.all - std::max(room, 0.0)) / domain))};
}

}  // namespace runner
