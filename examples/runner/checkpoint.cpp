// SPDX-License-Identifier: Apache-2.0
// Layout: magic (8 bytes), length of the header (u64), header (JSON), length of the snapshot (u64), snapshot,
// FNV-1a of everything before (u64). Little-endian.
#include "checkpoint.hpp"

#include <cmath>
#include <limits>

#include "failure.hpp"
#include "files.hpp"
#include "hash.hpp"

namespace runner {

namespace {

const std::string magic = "MELTRUN1";

void append_u64(std::string& to, std::uint64_t value) {
  for (int shift = 0; shift < 64; shift += 8) to += static_cast<char>(value >> shift & 255u);
}

Json header_json(const Checkpoint& checkpoint) {
  const RunState& state = checkpoint.state;
  Json json;
  json["time"] = state.time;
  json["steps"] = state.steps;
  json["next_frame"] = state.next_frame;
  json["frame_dt"] = state.frame_dt;
  json["limits"] = Json::array();
  for (const double limit : state.limits)
    json["limits"].push_back(std::isfinite(limit) ? Json(limit) : Json());
  json["rest"] = {{"dt", state.rest.dt},
                  {"steps", state.rest.steps},
                  {"end", state.rest.end},
                  {"speed", state.rest_speed}};
  json["part"] = {{"dt", state.part.dt}, {"steps", state.part.steps}};
  json["meltable"] = state.meltable;
  if (state.melted_at) json["melted_at"] = *state.melted_at;
  if (state.still_share) json["still_share"] = *state.still_share;
  json["wall_s"] = state.wall_s;
  json["budget"] = {{"substeps", state.substeps}, {"owed", state.owed}};
  json["scene"] = checkpoint.scene;
  return json;
}

/// Whether numbers and scene are such as this program writes; the sum over the file only says that nothing changed them.
bool sound(const Checkpoint& checkpoint) {
  const RunState& state = checkpoint.state;
  for (const double value : {state.time, state.frame_dt, state.wall_s, state.rest.dt, state.rest.end,
                             state.melted_at.value_or(0), state.still_share.value_or(0), state.owed})
    if (!(value >= 0 && std::isfinite(value))) return false;
  if (!checkpoint.scene.is_object()) return false;
  const Json time = checkpoint.scene.value("time", Json::object());
  return time.is_object() && (!time.contains("fps") || time["fps"].is_number());
}

Checkpoint from_header(const Json& json) {
  Checkpoint checkpoint;
  RunState& state = checkpoint.state;
  state.time = json.at("time").get<double>();
  state.steps = json.at("steps").get<std::uint64_t>();
  state.next_frame = json.at("next_frame").get<std::uint64_t>();
  state.frame_dt = json.at("frame_dt").get<double>();
  for (const Json& limit : json.at("limits"))
    state.limits.push_back(limit.is_null() ? std::numeric_limits<double>::infinity() : limit.get<double>());
  const Json& part = json.at("part");
  state.part = {part.at("dt").get<double>(), part.at("steps").get<int>(), 0};
  const Json& rest = json.at("rest");
  state.rest = {rest.at("dt").get<double>(), rest.at("steps").get<int>(), rest.at("end").get<double>()};
  state.rest_speed = rest.at("speed").get<double>();
  state.meltable = json.at("meltable").get<std::uint64_t>();
  if (json.contains("melted_at")) state.melted_at = json.at("melted_at").get<double>();
  if (json.contains("still_share")) state.still_share = json.at("still_share").get<double>();
  state.wall_s = json.at("wall_s").get<double>();
  if (json.contains("budget")) {
    state.substeps = json.at("budget").at("substeps").get<std::vector<std::uint64_t>>();
    state.owed = json.at("budget").at("owed").get<double>();
  }
  checkpoint.scene = json.at("scene");
  return checkpoint;
}

/// Reads the parts one after the other and never past the end.
class Reader {
 public:
  Reader(const std::string& data, const std::string& path) : data_(data), path_(path) {}

  [[noreturn]] void fail() const {
    throw Failure(ExitCode::io, path_ + ": is not a whole checkpoint of this program; start the run again");
  }
  std::string take(std::uint64_t size) {
    if (size > data_.size() - at_) fail();
    at_ += static_cast<std::size_t>(size);
    return data_.substr(at_ - static_cast<std::size_t>(size), static_cast<std::size_t>(size));
  }
  std::uint64_t take_u64() {
    const std::string bytes = take(8);
    std::uint64_t value = 0;
    for (std::size_t i = 8; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
  }
  std::size_t position() const { return at_; }

 private:
  const std::string& data_;
  const std::string& path_;
  std::size_t at_ = 0;
};

}  // namespace

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint) {
  const std::string header = header_json(checkpoint).dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string data = magic;
  append_u64(data, header.size());
  data += header;
  append_u64(data, checkpoint.snapshot.size());
  data.append(checkpoint.snapshot.begin(), checkpoint.snapshot.end());
  append_u64(data, fnv1a(data.data(), data.size()));
  write_file(path, data);
}

Checkpoint read_checkpoint(const std::string& path) {
  const std::string data = read_file(path);
  Reader reader(data, path);
  if (reader.take(magic.size()) != magic) reader.fail();
  const std::string header = reader.take(reader.take_u64());
  const std::string snapshot = reader.take(reader.take_u64());
  const std::size_t end = reader.position();
  if (reader.take_u64() != fnv1a(data.data(), end)) reader.fail();
  try {
    Checkpoint checkpoint = from_header(Json::parse(header));
    checkpoint.snapshot.assign(snapshot.begin(), snapshot.end());
    if (sound(checkpoint)) return checkpoint;
    reader.fail();
  } catch (const Json::exception&) {
    reader.fail();
  }
}

}  // namespace runner
