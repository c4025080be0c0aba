// SPDX-License-Identifier: Apache-2.0
#include "resumed_scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "expect.hpp"

namespace runner {

namespace {

struct Change {
  std::vector<std::string> path;  ///< "emitters", "0", "speed"
  Json before, now;               ///< null: not given
};

/// What differs, at the deepest key there is. Lists of other lengths and lists of numbers differ as a whole.
void compare(const std::vector<std::string>& path, const Json& before, const Json& now,
             std::vector<Change>& changes) {
  if (before == now) return;
  const auto inside = [&](const std::string& key, const Json& b, const Json& n) {
    std::vector<std::string> deeper = path;
    deeper.push_back(key);
    compare(deeper, b, n, changes);
  };
  if (before.is_object() && now.is_object()) {
    for (const auto& [key, value] : before.items()) inside(key, value, now.value(key, Json()));
    for (const auto& [key, value] : now.items())
      if (!before.contains(key)) inside(key, Json(), value);
    return;
  }
  if (before.is_array() && now.is_array() && before.size() == now.size() && !before.empty() &&
      before.front().is_object()) {
    for (std::size_t i = 0; i < before.size(); ++i) inside(std::to_string(i), before[i], now[i]);
    return;
  }
  changes.push_back({path, before, now});
}

std::string path_text(const std::vector<std::string>& path) {
  std::string text;
  for (const std::string& key : path) {
    const bool number = key.find_first_not_of("0123456789") == std::string::npos;
    text += number ? "[" + key + "]" : text.empty() ? key : "." + key;
  }
  return text;
}

std::string value_text(const Json& value) {
  const std::string text = value.is_null() ? "nothing" : value.dump();
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

/// Whether the change is to what the checkpoint holds and the library has no call for.
bool is_kept(const Scene& scene, const Change& change) {
  const std::string& part = change.path.front();
  if (part == "fluids") return true;
  if (change.path.size() < 3) return false;
  const std::string& key = change.path[2];
  if (part == "emitters") return key == "from";
  if (part != "bodies") return false;
  if (key == "velocity" || key == "angular_velocity")
    return scene.bodies.at(std::stoul(change.path[1])).desc.motion != meltsim::Motion::kinematic;
  return key == "shape" || key == "temperature" || key == "held_until";
}

/// What is state of the World and can be set.
void set(const Scene& scene, Built& built, const Change& change) {
  if (change.path.size() < 3) return;
  const std::string &part = change.path[0], &key = change.path[2];
  const std::size_t i = std::stoul(change.path[1]);
  if (part == "emitters") {
    const meltsim::EmitterDesc& desc = scene.emitters.at(i).desc;
    meltsim::EmitterSetting setting;
    if (key == "speed") setting.speed = desc.speed;
    else if (key == "temperature") setting.temperature = desc.temperature;
    else if (key == "nozzle" && change.path.back() == "center") setting.center = desc.center;
    else if (key == "reservoir" && change.path.back() == "level") setting.level = desc.level;
    else return;
    expect(built.world.set_emitter(built.emitter_ids.at(i), setting));
  }
  if (part == "bodies" && (key == "velocity" || key == "angular_velocity")) {
    meltsim::BodyMotion motion;
    motion.velocity = scene.bodies.at(i).desc.velocity;
    motion.angular_velocity = scene.bodies.at(i).desc.angular_velocity;
    expect(built.world.set_motion(built.body_ids.at(i), motion));
  }
}

/// Puts back what the checkpoint has.
void put_back(Json& json, const Change& change) {
  Json* at = &json;
  for (std::size_t i = 0; i + 1 < change.path.size(); ++i)
    at = at->is_array() ? &(*at)[std::stoul(change.path[i])] : &(*at)[change.path[i]];
  if (change.before.is_null()) at->erase(change.path.back());
  else (*at)[change.path.back()] = change.before;
}

}  // namespace

std::vector<std::string> take_over(const Scene& scene, Built& built, const Json& before, Json& now) {
  std::vector<Change> changes;
  for (const char* part : {"domain", "particles", "solver", "heat", "solute", "materials", "fluids", "bodies",
                           "emitters", "force_fields", "probes"})
    compare({part}, before.value(part, Json()), now.value(part, Json()), changes);
  std::vector<std::string> said;
  for (const Change& change : changes) {
    const bool kept = is_kept(scene, change);
    if (kept) put_back(now, change);
    else set(scene, built, change);
    said.push_back(fmt::format("--resume: {}: {} in the checkpoint, {} here: {}", path_text(change.path),
                               value_text(change.before), value_text(change.now),
                               kept ? "ignored, the checkpoint holds what came of it" : "taken over"));
  }
  return said;
}

}  // namespace runner
