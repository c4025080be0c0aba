// SPDX-License-Identifier: Apache-2.0
#include "resumed_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "expect.hpp"
#include "failure.hpp"

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

/// Of an item of a list: its number. Parts with names, such as materials, have none.
std::size_t item_of(const Change& change) { return std::stoul(change.path.at(1)); }

/// A body goes on about its own pivot: another one would carry it off.
void refuse_pivot(const Change& change) {
  throw Failure(
      ExitCode::scene,
      fmt::format("--resume: {}: a body goes on about the pivot that it began with ({}), got {}; {}",
                  path_text(change.path), value_text(change.before), value_text(change.now),
                  change.before.is_null() ? "leave it out" : "set that one"));
}

/// Whether the change is to what the checkpoint holds and the library has no call for.
bool is_kept(const Scene& scene, const Change& change) {
  const std::string& part = change.path.front();
  if (part == "fluids") return true;
  if (part == "solver") return change.path.back() == "hydrostatic_start" || change.path.back() == "settle";
  if (change.path.size() < 3) return false;
  const std::string& key = change.path[2];
  if (part == "emitters") return key == "from";
  if (part != "bodies") return false;
  if (key == "velocity" || key == "angular_velocity")
    return scene.bodies.at(item_of(change)).desc.motion != meltsim::Motion::kinematic;
  return key == "shape" || key == "temperature" || key == "held_until" || key == "carve";
}

void set_emitter(const meltsim::EmitterDesc& desc, Built& built, const Change& change) {
  const std::string &key = change.path[2], &last = change.path.back();
  meltsim::EmitterSetting setting;
  if (key == "speed") setting.speed = desc.speed;
  else if (key == "temperature") setting.temperature = desc.temperature;
  else if (key == "nozzle" && last == "center") setting.center = desc.center;
  else if (key == "reservoir" && last == "level") setting.level = desc.level;
  else return;
  expect(built.world.set_emitter(built.emitter_ids.at(item_of(change)), setting));
}

void set_body(const meltsim::SolidDesc& desc, Built& built, const Change& change) {
  const std::string& key = change.path[2];
  if (key == "pivot") refuse_pivot(change);
  if (key != "velocity" && key != "angular_velocity") return;
  meltsim::BodyMotion motion;
  motion.velocity = desc.velocity;
  motion.angular_velocity = desc.angular_velocity;
  expect(built.world.set_motion(built.body_ids.at(item_of(change)), motion));
}

/// The heights that a sound speed follows from are along the gravity of the checkpoint: it changes as that of a World that runs.
void turn_gravity(const Scene& scene, Built& built, const Change& change) {
  const auto then = change.before.get<std::array<double, 3>>();
  expect(built.world.set_gravity({then[0], then[1], then[2]}));
  expect(built.world.set_gravity(scene.world.gravity));
}

/// What is state of the World and can be set; what is the World's own it has already.
void set(const Scene& scene, Built& built, const Change& change) {
  const std::string& part = change.path.front();
  if (part == "solver" && change.path.back() == "gravity") turn_gravity(scene, built, change);
  if (change.path.size() < 3) return;
  if (part == "emitters") set_emitter(scene.emitters.at(item_of(change)).desc, built, change);
  if (part == "bodies") set_body(scene.bodies.at(item_of(change)).desc, built, change);
}

/// Puts back what the checkpoint has.
void put_back(Json& json, const Change& change) {
  Json* at = &json;
  for (std::size_t i = 0; i + 1 < change.path.size(); ++i)
    at = at->is_array() ? &(*at)[std::stoul(change.path[i])] : &(*at)[change.path[i]];
  if (change.before.is_null()) at->erase(change.path.back());
  else (*at)[change.path.back()] = change.before;
}

bool is_solver(const Change& change, const char* key) {
  return change.path == std::vector<std::string>{"solver", key};
}

/// Sound is as fast as the World has it by now. A density_error that asks for less leaves it as it was in the checkpoint.
void take_over_sound(Built& built, const Json& before, Json& now, std::vector<Change>& changes) {
  const double speed = built.world.resolved().sound_speed;
  const Json then = before.value("solver", Json::object()).value("sound_speed", Json());
  if (!(speed > 0) || !then.is_number()) return;
  const auto of_sound = [](const Change& change) { return is_solver(change, "sound_speed"); };
  changes.erase(std::remove_if(changes.begin(), changes.end(), of_sound), changes.end());
  now["solver"]["sound_speed"] = speed;
  if (then != now["solver"]["sound_speed"]) changes.push_back({{"solver", "sound_speed"}, then, speed});
}

/// "emitters[0].speed: 2.0 in the checkpoint, 6.0 here"
std::string text(const Change& change) {
  return fmt::format("{}: {} in the checkpoint, {} here", path_text(change.path), value_text(change.before),
                     value_text(change.now));
}

std::vector<Change> differences(const Json& before, const Json& now) {
  std::vector<Change> changes;
  for (const char* part : {"domain", "particles", "solver", "heat", "solute", "materials", "fluids", "bodies",
                           "emitters", "force_fields", "probes"})
    compare({part}, before.value(part, Json()), now.value(part, Json()), changes);
  return changes;
}

}  // namespace

std::string changed_since(const Json& before, const Json& now) {
  std::string all;
  for (const Change& change : differences(before, now)) all += "\nchanged since: " + text(change);
  return all;
}

std::vector<std::string> take_over(const Scene& scene, Built& built, const Json& before, Json& now) {
  std::vector<Change> changes = differences(before, now);
  for (const Change& change : changes)
    if (!is_kept(scene, change)) set(scene, built, change);
  take_over_sound(built, before, now, changes);
  const bool faster = std::any_of(changes.begin(), changes.end(),
                                  [](const Change& change) { return is_solver(change, "sound_speed"); });
  std::vector<std::string> said;
  for (const Change& change : changes) {
    const bool kept = is_kept(scene, change) || (is_solver(change, "density_error") && !faster);
    if (kept) put_back(now, change);
    said.push_back(fmt::format("--resume: {}: {}", text(change),
                               kept ? "ignored, the checkpoint holds what came of it" : "taken over"));
  }
  return said;
}

}  // namespace runner
