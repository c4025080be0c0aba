// SPDX-License-Identifier: Apache-2.0
#include "run_json.hpp"

#include <fmt/format.h>

namespace runner {

namespace {

std::string version_text() {
  return fmt::format("{}.{}.{}", MELTSIM_VERSION_MAJOR, MELTSIM_VERSION_MINOR, MELTSIM_VERSION_PATCH);
}

Json versions_json() {
  const meltsim::BuildInfo info = meltsim::build_info();
  Json json;
  json["meltsim"] = info.version;
  json["headers"] = version_text();
  json["scene_format"] = 1;
  if (!info.cuda_runtime.empty()) json["cuda_runtime"] = info.cuda_runtime;
  if (!info.cuda_driver.empty()) json["cuda_driver"] = info.cuda_driver;
  return json;
}

Json plan_json(const meltsim::Plan& plan) {
  Json json;
  json["stages"] = Json::array();
  json["channels"] = Json::array();
  for (const meltsim::StageReport& stage : plan.stages) {
    json["stages"].push_back({{"name", stage.name},
                              {"module", stage.module},
                              {"runs", stage.runs},
                              {"reason", stage.reason},
                              {"interval", stage.interval},
                              {"track", stage.track},
                              {"median_ms", stage.median_ms}});
  }
  for (const meltsim::FusionReport& fusion : plan.fusions)
    json["fusions"].push_back({{"name", fusion.name}, {"holds", fusion.holds}, {"reason", fusion.reason}});
  for (const meltsim::ChannelReport& channel : plan.channels) {
    json["channels"].push_back({{"name", channel.name},
                                {"type", channel.type},
                                {"owner", channel.owner},
                                {"lifetime", channel.lifetime},
                                {"unit", channel.unit},
                                {"bytes", channel.bytes}});
  }
  json["bytes"] = plan.bytes;
  return json;
}

Json timings_json(const meltsim::Plan& plan) {
  Json json = Json::object();
  for (const meltsim::StageReport& stage : plan.stages) {
    if (stage.runs) json[stage.name] = stage.median_ms;
  }
  return json;
}

}  // namespace

Json run_json(const Scene& scene, const Json& resolved_scene, const RunOptions& options, Built& built,
              const std::vector<std::string>& warnings, const Json& final_block) {
  const char* qualities[] = {"draft", "balanced", "accurate"};
  const meltsim::Resolved resolved = built.world.resolved();
  const meltsim::Plan plan = built.world.plan();
  Json json;
  json["format"] = 1;
  json["title"] = scene.title;
  json["scene_file"] = scene.file;
  json["scene"] = resolved_scene;
  json["options"] = {{"set", options.scene.set},
                     {"scale", options.scene.scale},
                     {"quality", qualities[static_cast<std::size_t>(options.scene.quality)]}};
  json["versions"] = versions_json();
  json["backend"] = {{"name", backend_name(resolved.backend)},
                     {"device", resolved.device_name},
                     {"reason", resolved.backend_reason},
                     {"requested", backend_name(options.machine.backend)}};
  json["threads"] = options.machine.threads;
  json["precision"] = built.world.precision() == meltsim::Precision::double_precision ? "double" : "single";
  json["deterministic"] = true;
  json["seed"] = 0;  // nothing in a run is random
  json["materials"] = built.materials;
  json["stiffness"] = Json::object();
  for (std::size_t i = 0; i < resolved.stiffness.size() && i < built.materials.size(); ++i) {
    const meltsim::Stiffness& s = resolved.stiffness[i];
    json["stiffness"][built.materials[i]] = {{"region_half_width", s.region_half_width},
                                             {"stiffness", s.stiffness},
                                             {"youngs_modulus", s.youngs_modulus}};
  }
  json["viscosity"] = {{"implicit", resolved.viscosity == meltsim::Viscosity::implicit},
                       {"stages", resolved.viscous_stages},
                       {"supersteps", resolved.viscous_supersteps}};
  json["heat"] = {{"stages", resolved.heat_stages},
                  {"interval", resolved.heat_interval},
                  {"efficiency", resolved.heat_efficiency}};
  json["plan"] = plan_json(plan);
  json["plan"]["start_bytes"] = built.start_bytes;
  json["timings_ms"] = timings_json(plan);
  json["timings"] = {{"stages_timed_every", plan.timings_every}, {"substep_ms", plan.substep_ms}};
  json["warnings"] = warnings;
  if (!final_block.is_null()) json["final"] = final_block;
  return json;
}

}  // namespace runner
