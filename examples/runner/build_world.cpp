// SPDX-License-Identifier: Apache-2.0
#include "build_world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "check_units.hpp"
#include "expect.hpp"
#include "library_error.hpp"
#include "load_scene.hpp"
#include "meltsim/physics/fluid.hpp"
#include "memory.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

using meltsim::MaterialId;

class Builder {
 public:
  Builder(const Scene& scene, meltsim::World world)
      : scene_(scene), built_{std::move(world), {}, {}, {}, {}, {}, false, false, {}, {}, {}, 0, {}, 0, {}} {}

  Built build() && {
    for (const SceneMaterial& material : scene_.materials) ids_[material.desc.name] = add(material);
    for (const SceneFluid& fluid : scene_.fluids) add(fluid);
    for (const SceneBody& body : scene_.bodies) add(body);
    for (const SceneEmitter& emitter : scene_.emitters) add(emitter);
    for (const SceneHeatRegion& region : scene_.heat_regions) add(region);
    for (const SceneForceField& field : scene_.force_fields)
      built_.force_field_ids.push_back(accept(built_.world.add_force_field(field.desc), field));
    const meltsim::Status ready = built_.world.prepare();
    if (!ready) {
      if (ready.error().code == meltsim::ErrorCode::out_of_memory)
        throw memory_failure(ready.error().message, device());
      throw library_failure(ready.error(), world_places(scene_), "", scene_.where);
    }
    for (const meltsim::PieceInfo& piece : expect(built_.world.pieces())) {
      if (built_.body_melts.at(piece.body.index)) built_.meltable += piece.particles;
    }
    if (scene_.time.until_melted && built_.meltable == 0) {
      throw Failure(
          ExitCode::scene,
          fmt::format("{}: time.end_when: nothing in this scene can melt or dissolve; give a body a "
                      "material with melting_point and becomes, or use end_when: time",
                      scene_.time.end_when_where));
    }
    return std::move(built_);
  }

 private:
  std::string device() const {
    return built_.world.backend() == meltsim::Backend::cuda
               ? fmt::format("device {}", built_.world.desc().device)
               : "this machine";
  }

  /// `item`: what of the scene the library was handed.
  template <class T, class Item>
  T accept(meltsim::Result<T> result, const Item& item) {
    if (result) return *result;
    if (result.error().code == meltsim::ErrorCode::out_of_memory)
      throw memory_failure(result.error().message, device());
    throw library_failure(result.error(), item_places(item), item.source.path, item.source.where);
  }

  MaterialId add(const SceneMaterial& material) {
    meltsim::MaterialDesc desc = material.desc;
    if (!material.becomes.empty()) desc.melts_into = ids_.at(material.becomes);
    if (!material.dissolves_in.empty()) desc.dissolves_in = ids_.at(material.dissolves_in);
    return keep(desc, material);
  }

  std::vector<meltsim::MassFraction> fractions_of(const SceneFractions& named) const {
    std::vector<meltsim::MassFraction> fractions;
    for (const auto& [name, value] : named) fractions.push_back({ids_.at(name), value});
    return fractions;
  }

  void add(const SceneFluid& fluid) {
    meltsim::FluidDesc desc = fluid.desc;
    desc.material = ids_.at(fluid.material);
    desc.fractions = fractions_of(fluid.fractions);
    built_.fluid_particles.push_back(accept(built_.world.add_fluid(desc), fluid));
  }

  void add(const SceneBody& body) {
    meltsim::SolidDesc desc = body.desc;
    desc.material = body.density ? with_density(body) : ids_.at(body.material);
    const meltsim::MaterialDesc material = built_.world.material(desc.material);
    const bool heats =
        scene_.world.heat.model != meltsim::HeatModel::none && scene_.world.heat.time_scale > 0;
    const bool melts = heats && static_cast<bool>(material.melts_into),
               dissolves = scene_.world.solute.time_scale > 0 && static_cast<bool>(material.dissolves_in);
    built_.body_melts.push_back(melts || dissolves);
    built_.melts = built_.melts || melts;
    built_.dissolves = built_.dissolves || dissolves;
    built_.body_ids.push_back(accept(built_.world.add_solid(desc), body));
  }

  void add(const SceneHeatRegion& region) {
    built_.heat_region_ids.push_back(accept(built_.world.add_heat_region(region.desc), region));
  }

  void add(const SceneEmitter& emitter) {
    meltsim::EmitterDesc desc = emitter.desc;
    desc.material = ids_.at(emitter.material);
    desc.fractions = fractions_of(emitter.fractions);
    built_.emitter_ids.push_back(accept(built_.world.add_emitter(desc), emitter));
  }

  MaterialId with_density(const SceneBody& body) {
    const std::string name = dense_material(body.material, *body.density);
    const auto known = ids_.find(name);
    if (known != ids_.end()) return known->second;
    meltsim::MaterialDesc desc = built_.world.material(ids_.at(body.material));
    desc.name = name;
    desc.density = *body.density;
    return ids_[name] = keep(desc, body);
  }

  template <class Item>
  MaterialId keep(const meltsim::MaterialDesc& desc, const Item& item) {
    const MaterialId id = accept(built_.world.add_material(desc), item);
    built_.materials.push_back(desc.name);
    built_.material_ids.push_back(id);
    return id;
  }

  const Scene& scene_;
  Built built_;
  std::map<std::string, MaterialId> ids_;
};

Built settled(Built built, const Scene& scene) {
  if (scene.settle.on) built.settled = expect(built.world.settle(scene.settle.seconds));
  return built;
}
}  // namespace

double error_at(double density_error, double sound_factor) {
  const double e = density_error > 0 ? density_error : meltsim::physics::usual_density_error;
  return std::clamp(e / (sound_factor * sound_factor), 1e-5, 0.1);
}

std::vector<std::string> softer_than_asked(Built& built) {
  std::vector<std::string> warnings;
  const std::vector<meltsim::Stiffness> delivered = built.world.resolved().stiffness;
  for (std::size_t i = 0; i < delivered.size(); ++i) {
    const double asked = built.world.material(built.material_ids[i]).youngs_modulus,
                 got = delivered[i].youngs_modulus;
    if (got >= asked * (1 - 1e-6)) continue;
    warnings.push_back(
        fmt::format("materials.{}: a youngs_modulus of {:.3g} Pa is out of reach, bodies have {:.3g} "
                    "Pa; a sound_speed {:.4g} times as large brings it, at as many times the steps",
                    built.materials[i], asked, got, std::ceil(100 * std::sqrt(asked / got)) / 100));
  }
  return warnings;
}

Built build_world(const Scene& scene, const MachineOptions& machine) {
  check_frames(scene);
  check_particle_budget(scene);
  meltsim::WorldDesc desc = scene.world;
  desc.backend = machine.backend;
  desc.precision = machine.precision;
  desc.threads = machine.threads;
  const auto build = [&] {
    auto world = meltsim::World::create(desc);
    if (!world) throw library_failure(world.error(), world_places(scene), "", scene.where);
    return Builder(scene, std::move(*world)).build();
  };
  if (scene.sound_factor == 1 || desc.sound_speed > 0) return settled(build(), scene);
  // What `auto` comes to, only the scene's contents tell.
  if (desc.follow_sound_speed) {  // it stays derived
    desc.density_error = error_at(desc.density_error, scene.sound_factor);
    return settled(build(), scene);
  }
  const double automatic = build().world.resolved().sound_speed;
  desc.sound_speed = automatic * scene.sound_factor;
  desc.density_error = 0;
  return settled(build(), scene);
}

const char* pace_keys(const Built& built) {
  if (!built.dissolves) return "heat.time_scale";
  return built.melts ? "heat.time_scale or solute.time_scale" : "solute.time_scale";
}

const char* backend_name(meltsim::Backend backend) {
  switch (backend) {
    case meltsim::Backend::cuda:
      return "cuda";
    case meltsim::Backend::cpu:
      return "cpu";
    case meltsim::Backend::automatic:
      break;
  }
  return "auto";
}

std::string memory_text(const Built& built) {
  return bytes_text(static_cast<double>(built.start_bytes)) + " for the World";
}

std::string backend_text(meltsim::World& world) {
  const meltsim::Resolved resolved = world.resolved();
  const auto without = [](std::string text, const std::string& prefix) {
    return text.compare(0, prefix.size(), prefix) == 0 ? text.substr(prefix.size()) : text;
  };
  std::string text = backend_name(resolved.backend);
  if (!resolved.device_name.empty()) text += ", " + without(resolved.device_name, "CPU, ");
  if (!resolved.backend_reason.empty())
    text += fmt::format(" ({})", without(resolved.backend_reason, "backend: "));
  return text;
}

}  // namespace runner
