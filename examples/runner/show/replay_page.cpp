// SPDX-License-Identifier: Apache-2.0
// Frames are packed as replay.html unpacks them: per frame the steps between ids (7 bits a byte), then, for
// all particles one after the other, the low and high bytes of what x, y and z changed since the particle's
// last frame, the change of temperature, and phase with body, and material, exclusive-or'ed. All of it
// deflated.
#include "show/replay_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "csv.hpp"
#include "numbers.hpp"
#include "show/deflate.hpp"
#include "show/ramp.hpp"
#include "show/shapes.hpp"

namespace runner {

namespace {

constexpr std::size_t most_bytes =
    9500000;                             ///< of frames in base64, which leaves half a megabyte for the rest
constexpr std::size_t most_rows = 1500;  ///< of stats.csv: plots are not wider
const char* const plotted[] = {"time_s", "melted_fraction", "T_min",       "T_mean",
                               "T_max",  "kinetic_J",       "potential_J", "ms_per_step"};
/// Of columns above, those that have no value while the scene is empty, when the table has 0.
bool needs_particles(const std::string& column) { return column.compare(0, 2, "T_") == 0; }

/// Where numbers of the page are, and how large their steps.
struct Scale {
  Box box;
  meltsim::Vec3d step;
  double cold = 0, hot = 1;
};

double axis_of(const meltsim::Vec3d& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

Scale scale_of(const ReplayPage& page, const std::vector<ReplayFrame>& frames) {
  Scale scale;
  scale.box = page.box;
  double cold = 1e300, hot = -1e300;
  for (const ReplayFrame& frame : frames) {
    for (const ReplayParticle& p : frame.particles) {
      scale.box.add({p.position[0], p.position[1], p.position[2]});
      cold = std::min<double>(cold, p.temperature);
      hot = std::max<double>(hot, p.temperature);
    }
  }
  if (scale.box.empty()) scale.box.add({0, 0, 0});
  // A 50th of a spacing is not seen; finer steps would only make the file larger.
  const auto step = [&page](double extent) { return std::max(extent / 65000, page.spacing / 50); };
  const meltsim::Vec3d size = scale.box.size();
  scale.step = {step(size.x), step(size.y), step(size.z)};
  if (cold <= hot) scale.cold = cold, scale.hot = hot;
  if (scale.hot - scale.cold < 1e-3) scale.cold -= 0.5, scale.hot += 0.5;
  return scale;
}

struct Packed {
  std::uint32_t id;
  std::uint16_t position[3];
  std::uint8_t temperature, look, material;
};

Json bytes_of(const Rgb& color) {
  Json bytes = Json::array();
  for (const double c : color) bytes.push_back(std::lround(255 * c));
  return bytes;
}

/// Colours by number: those of the materials, then those of their mixtures with what is dissolved in them.
class Palette {
 public:
  Palette(const ReplayPage& page, const std::vector<ReplayFrame>& frames) : page_(page) {
    for (std::size_t k = 0; k < page.species.size(); ++k)
      if (color_of(page.looks, page.species[k]) != nullptr) shown_ |= 31u << (16 + 5 * k);
    // Contents are told apart as finely as there are numbers for.
    for (std::uint32_t kept = 31; shown_ != 0 && kept != 0; kept = kept << 1 & 31u) {
      for (std::size_t k = 0; k < page.species.size(); ++k) shown_ &= ~((31u & ~kept) << (16 + 5 * k));
      numbers_.clear();
      for (const ReplayFrame& frame : frames)
        for (const ReplayParticle& p : frame.particles)
          if (is_mixture(p)) numbers_[key(p)] = 0;
      if (page.looks.size() + numbers_.size() <= 256) break;
      numbers_.clear();
    }
    for (const ReplayFrame& frame : frames)
      for (const ReplayParticle& p : frame.particles)
        if ((p.look & 128u) != 0 && (p.look & 127u) != 0) {
          const std::uint32_t body = (p.look & 127u) - 1;
          const auto [found, fresh] = first_bodies_.try_emplace(p.look >> 8 & 255u, body);
          if (!fresh) found->second = std::min(found->second, body);
        }
    std::size_t next = page.looks.size();
    for (auto& [key, number] : numbers_) number = static_cast<std::uint8_t>(next++);
  }

  std::uint8_t number(const ReplayParticle& p) const {
    const auto found = is_mixture(p) ? numbers_.find(key(p)) : numbers_.end();
    return found != numbers_.end() ? found->second : static_cast<std::uint8_t>(p.look >> 8);
  }

  /// Of mixtures `of` is the number of the liquid; `solid` is the colour of solids of a material without one.
  Json json() const {
    Json list = Json::array();
    for (const SceneLook& look : page_.looks) {
      list.push_back({{"name", look.name}, {"color", look.color ? bytes_of(*look.color) : Json()}});
      const auto body = first_bodies_.find(static_cast<std::uint32_t>(list.size() - 1));
      if (!look.color && body != first_bodies_.end())
        list.back()["solid"] = bytes_of(monitor(palette_color(body->second)));
    }
    for (const auto& [key, number] : numbers_) {
      const std::size_t liquid = key >> 8 & 255u;
      list.push_back({{"name", page_.looks[liquid].name}, {"color", bytes_of(mixed(key))}, {"of", liquid}});
    }
    return list;
  }

  /// What is dissolved somewhere and has a colour.
  Json dissolved() const {
    Json list = Json::array();
    for (std::size_t k = 0; k < page_.species.size(); ++k) {
      const bool some = std::any_of(numbers_.begin(), numbers_.end(), [this, k](const auto& n) {
        return (n.first & shown_ & 31u << (16 + 5 * k)) != 0;
      });
      if (!some) continue;
      const SceneLook& look = page_.looks[page_.species[k]];
      list.push_back({{"name", look.name}, {"color", bytes_of(*look.color)}});
    }
    return list;
  }

 private:
  bool is_mixture(const ReplayParticle& p) const {
    return (p.look & 128u) == 0 && (p.look & shown_) != 0 && (p.look >> 8 & 255u) < page_.looks.size();
  }
  std::uint32_t key(const ReplayParticle& p) const { return p.look & (shown_ | 0xff00u); }
  /// As pictures mix: by content, as light adds up.
  Rgb mixed(std::uint32_t key) const {
    const auto& own = page_.looks[key >> 8 & 255u].color;
    const Rgb liquid = linear(own ? *own : Rgb{70 / 255.0, 122 / 255.0, 190 / 255.0});  // replay.html: water
    Rgb sum{};
    double share = 0;
    for (std::size_t k = 0; k < page_.species.size(); ++k) {
      const double w = (key >> (16 + 5 * k) & 31u) / 31.0;
      if (w == 0) continue;
      const Rgb color = linear(*page_.looks[page_.species[k]].color);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += w * color[c];
      share += w;
    }
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] = share > 1 ? sum[c] / share : sum[c] + (1 - share) * liquid[c];
    return monitor(sum);
  }

  const ReplayPage& page_;
  std::uint32_t shown_ = 0;  ///< bits of contents that are told apart
  std::map<std::uint32_t, std::uint8_t> numbers_;
  std::map<std::uint32_t, std::uint32_t>
      first_bodies_;  ///< of each solid material, from 0: pictures colour by body
};

Packed packed_particle(const ReplayParticle& p, const Scale& scale, const Palette& palette) {
  Packed packed{p.id, {}, 0, static_cast<std::uint8_t>(p.look), palette.number(p)};
  for (int axis = 0; axis < 3; ++axis) {
    const double at = (p.position[axis] - axis_of(scale.box.min, axis)) / axis_of(scale.step, axis);
    packed.position[axis] = static_cast<std::uint16_t>(std::lround(std::clamp(at, 0.0, 65535.0)));
  }
  packed.temperature = static_cast<std::uint8_t>(
      std::lround(std::clamp(255 * (p.temperature - scale.cold) / (scale.hot - scale.cold), 0.0, 255.0)));
  return packed;
}

void append_frame(std::string& bytes, const std::vector<Packed>& now, const std::vector<Packed>& before) {
  const auto byte = [&bytes](unsigned value) { bytes += static_cast<char>(value & 255u); };
  std::uint32_t expected = 0;
  std::vector<Packed> old(now.size());  // zero where the particle is new
  for (std::size_t i = 0, j = 0; i < now.size(); ++i) {
    std::uint32_t gap = now[i].id - expected;
    expected = now[i].id + 1;
    for (; gap > 127; gap >>= 7) byte(gap | 128u);
    byte(gap);
    while (j < before.size() && before[j].id < now[i].id) ++j;
    if (j < before.size() && before[j].id == now[i].id) old[i] = before[j];
  }
  for (int axis = 0; axis < 3; ++axis) {
    std::string high;
    for (std::size_t i = 0; i < now.size(); ++i) {
      const auto change = static_cast<std::int16_t>(now[i].position[axis] - old[i].position[axis]);
      const auto zigzag = static_cast<unsigned>(change < 0 ? -2 * change - 1 : 2 * change);
      byte(zigzag);
      high += static_cast<char>(zigzag >> 8 & 255u);
    }
    bytes += high;
  }
  for (std::size_t i = 0; i < now.size(); ++i) byte(256u + now[i].temperature - old[i].temperature);
  for (std::size_t i = 0; i < now.size(); ++i) byte(static_cast<unsigned>(now[i].look ^ old[i].look));
  for (std::size_t i = 0; i < now.size(); ++i) byte(static_cast<unsigned>(now[i].material ^ old[i].material));
}

std::string frames_text(const std::vector<ReplayFrame>& frames, const Scale& scale, const Palette& palette,
                        int threads) {
  std::string bytes;
  std::vector<Packed> before;
  for (const ReplayFrame& frame : frames) {
    std::vector<Packed> now;
    now.reserve(frame.particles.size());
    for (const ReplayParticle& p : frame.particles) now.push_back(packed_particle(p, scale, palette));
    append_frame(bytes, now, before);
    before = std::move(now);
  }
  return base64(deflated(bytes, 6, threads));
}

/// Every second frame, and the last one.
std::vector<ReplayFrame> half_of(const std::vector<ReplayFrame>& frames) {
  std::vector<ReplayFrame> kept;
  for (std::size_t i = 0; i < frames.size(); i += 2) kept.push_back(frames[i]);
  if (frames.size() % 2 == 0) kept.push_back(frames.back());
  return kept;
}

Json stats_of(const std::string& text) {
  std::istringstream table(text);
  std::string line;
  std::getline(table, line);
  const std::vector<std::string> header = split_commas(line);
  Json columns = Json::array(), rows = Json::array();
  std::vector<std::size_t> wanted;
  for (const char* name : plotted) {
    wanted.push_back(
        static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin()));
    columns.push_back(name);
  }
  std::vector<std::size_t> counts;
  for (const char* name : {"n_fluid", "n_solid"})
    counts.push_back(
        static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin()));
  std::vector<std::string> lines;
  while (std::getline(table, line)) lines.push_back(line);
  const std::size_t every = lines.size() / most_rows + 1;
  for (std::size_t i = 0; i < lines.size(); i += every) {
    const std::vector<std::string> cells = split_commas(lines[i]);
    const auto value_of = [&cells](std::size_t column) {
      return column < cells.size() ? parse_number(cells[column]) : std::nullopt;
    };
    const bool empty =
        std::all_of(counts.begin(), counts.end(), [&](std::size_t c) { return value_of(c) == 0.0; });
    Json row = Json::array();
    for (const std::size_t column : wanted) {
      auto value = value_of(column);
      if (empty && column < header.size() && needs_particles(header[column])) value.reset();
      // JSON has no "nan"; null leaves a gap in the plot.
      row.push_back(value && std::isfinite(*value) ? Json(typed(*value)) : Json());
    }
    rows.push_back(row);
  }
  return {{"columns", columns}, {"rows", rows}};
}

Json vector_json(const meltsim::Vec3d& v) { return Json::array({v.x, v.y, v.z}); }

Json ramp_json() {
  Json stops = Json::array();
  for (const Rgb& color : ramp_stops) {
    stops.push_back(bytes_of(color));
  }
  return stops;
}

/// Drawn radius as a multiple of the spacing: where few particles stand for many, they are larger.
double drawn_radius(const ReplayPage& page, double share) { return 0.55 * page.spacing * std::cbrt(share); }

/// `page` with each mark replaced by its value, in one pass: a value that holds a mark stays as it is.
std::string filled(const std::string& page, const std::vector<std::pair<std::string, std::string>>& marks) {
  std::string text;
  std::size_t at = 0;
  for (const auto& [mark, value] : marks) {
    const std::size_t next = page.find(mark, at);
    text += page.substr(at, next - at) + value;
    at = next + mark.size();
  }
  return text + page.substr(at);
}

/// JSON for the inside of a <script>: "<" appears in strings only and is written as an escape, so that no title can end the
/// script or begin an HTML comment in it.
std::string script_text(const Json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', true, Json::error_handler_t::replace))
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return text;
}

}  // namespace

std::string replay_page(const ReplayPage& page, const std::vector<ReplayFrame>& all) {
  std::vector<ReplayFrame> frames = all;
  if (frames.empty()) frames.emplace_back();
  const Scale scale = scale_of(page, frames);
  const Palette palette(page, frames);
  std::string text = frames_text(frames, scale, palette, page.threads);
  while (text.size() > most_bytes && frames.size() > 2) {
    frames = half_of(frames);
    text = frames_text(frames, scale, palette, page.threads);
  }
  Json meta;
  meta["title"] = page.title;
  meta["note"] = page.note + fmt::format(" {} are here.", frames.size());
  meta["frames"] = Json::array();
  for (const ReplayFrame& frame : frames) {
    meta["frames"].push_back({{"time", frame.time}, {"n", frame.particles.size()}});
  }
  meta["min"] = vector_json(scale.box.min);
  meta["size"] = vector_json(scale.box.size());
  meta["step"] = vector_json(scale.step);
  meta["temperature"] = {scale.cold, scale.hot};
  meta["radius"] = drawn_radius(page, static_cast<double>(page.share));
  meta["up"] = vector_json(page.camera.up);
  meta["camera"] = {{"eye", vector_json(page.camera.eye)},
                    {"look_at", vector_json(page.camera.look_at)},
                    {"fov", page.camera.fov}};
  meta["bodies"] = page.bodies;
  meta["materials"] = palette.json();
  meta["dissolved"] = palette.dissolved();
  meta["ramp"] = ramp_json();
  meta["stats"] = stats_of(page.stats);
  return filled(replay_template, {{"%META%", script_text(meta)}, {"%FRAMES%", text}});
}

}  // namespace runner
