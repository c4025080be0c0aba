// SPDX-License-Identifier: Apache-2.0
// File: magic, every, share (u64), length of what follows unpacked (u64); then, deflated, the frames: time
// (f64), index, particles (u64), and the particles as they lie in memory. Little-endian.
#include "show/replay.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "files.hpp"
#include "show/deflate.hpp"

namespace runner {

namespace {

const std::string magic = "MELTREP1";
// One to two bytes a particle and frame after packing make a page of some megabytes.
constexpr std::size_t most_particles = 4000000;        ///< of all frames together
constexpr std::size_t most_particles_a_frame = 60000;  ///< what a browser draws without effort
constexpr std::size_t most_frames = 1000;

std::uint32_t hash(std::uint32_t id) {
  id = (id ^ id >> 16) * 0x45d9f3bu;
  id = (id ^ id >> 16) * 0x45d9f3bu;
  return id ^ id >> 16;
}

/// share: a power of 2.
bool is_picked(std::uint32_t id, std::uint64_t share) { return (hash(id) & (share - 1)) == 0; }
bool is_power_of_two(std::uint64_t n) { return n != 0 && (n & (n - 1)) == 0; }

static_assert(16 + 5 * meltsim::most_species <= 32, "contents do not fit beside body and material");
std::uint32_t content_bits(const FrameParticle& p) {
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(meltsim::most_species); ++k)
    bits |= static_cast<std::uint32_t>(std::lround(31 * std::clamp(p.contents[k], 0.0f, 1.0f)))
            << (16 + 5 * k);
  return bits;
}

template <class T>
void append(std::string& to, const T& value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

/// False when the data ends before.
template <class T>
bool take(const std::string& from, std::size_t& at, T& value) {
  if (from.size() - at < sizeof(T)) return false;
  std::memcpy(&value, from.data() + at, sizeof(T));
  at += sizeof(T);
  return true;
}

}  // namespace

Replay::Replay(std::uint64_t planned_frames, std::uint64_t particles) {
  while (particles / share_ > most_particles_a_frame) share_ *= 2;
  const std::uint64_t a_frame = std::max<std::uint64_t>(1, particles / share_);
  while (planned_frames / every_ > most_frames || planned_frames / every_ * a_frame > most_particles) {
    every_ *= 2;
  }
}

std::size_t Replay::particles() const {
  std::size_t count = 0;
  for (const ReplayFrame& frame : frames_) count += frame.particles.size();
  return count;
}

ReplayFrame Replay::picked(std::uint64_t index, double time, const meltsim::ParticleFrame& particles) const {
  ReplayFrame frame{time, index, {}};
  const ParticleColumns columns(particles);
  std::vector<std::uint32_t> picked(particles.id.size() + 1);  // one more, that is written and not kept
  std::size_t count = 0;
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    picked[count] = static_cast<std::uint32_t>(i);
    count += is_picked(columns.id[i], share_) ? 1u : 0u;
  }
  frame.particles.resize(count);  // no more than there are: it is kept until the run ends
  for (std::size_t k = 0; k < count; ++k) {
    const FrameParticle p = columns.particle(picked[k]);
    const std::uint32_t body = p.body < 0 ? 0 : 1 + static_cast<std::uint32_t>(p.body) % 127;
    frame.particles[k] = {p.id,
                          {p.position[0], p.position[1], p.position[2]},
                          p.temperature,
                          body + (p.phase == 1 ? 128u : 0u) +
                              (static_cast<std::uint32_t>(p.material) & 255u) * 256u + content_bits(p)};
  }
  return frame;
}

void Replay::add(std::uint64_t index, double time, const meltsim::ParticleFrame& particles) {
  frames_.push_back(picked(index, time, particles));
  thin();
}

void Replay::thin() {
  while (frames_.back().particles.size() > most_particles_a_frame) {
    share_ *= 2;
    for (ReplayFrame& frame : frames_) {
      auto& list = frame.particles;
      list.erase(std::remove_if(list.begin(), list.end(),
                                [this](const ReplayParticle& p) { return !is_picked(p.id, share_); }),
                 list.end());
    }
  }
  while (frames_.size() > 1 && (particles() > most_particles || frames_.size() > most_frames)) {
    every_ *= 2;
    frames_.erase(std::remove_if(frames_.begin(), frames_.end(),
                                 [this](const ReplayFrame& frame) { return !wants(frame.index); }),
                  frames_.end());
  }
}

void Replay::save(const std::string& path, int threads) const {
  std::string data;
  for (const ReplayFrame& frame : frames_) {
    append(data, frame.time);
    append(data, frame.index);
    append(data, static_cast<std::uint64_t>(frame.particles.size()));
    data.append(reinterpret_cast<const char*>(frame.particles.data()),
                frame.particles.size() * sizeof(ReplayParticle));
  }
  std::string file = magic;
  append(file, every_);
  append(file, share_);
  append(file, static_cast<std::uint64_t>(data.size()));
  write_file(path, file + deflated(data, 1, threads));
}

bool Replay::load(const std::string& path, double time) {
  if (!exists(path)) return false;
  const std::string file = read_file(path);
  std::size_t at = magic.size();
  std::uint64_t every = 0, share = 0, size = 0;
  if (file.compare(0, magic.size(), magic) != 0 || !take(file, at, every) || !take(file, at, share) ||
      !take(file, at, size) || every == 0 || !is_power_of_two(share)) {
    return false;
  }
  std::string data;
  if (!inflated(file.substr(at), size, data)) return false;
  std::vector<ReplayFrame> frames;
  for (at = 0; at < data.size();) {
    ReplayFrame frame;
    std::uint64_t count = 0;
    if (!take(data, at, frame.time) || !take(data, at, frame.index) || !take(data, at, count)) return false;
    if (count > (data.size() - at) / sizeof(ReplayParticle)) return false;
    frame.particles.resize(count);
    if (count > 0) std::memcpy(frame.particles.data(), data.data() + at, count * sizeof(ReplayParticle));
    at += count * sizeof(ReplayParticle);
    if (frame.time <= time * (1 + 1e-12)) frames.push_back(std::move(frame));
  }
  frames_ = std::move(frames);
  every_ = every;
  share_ = share;
  return true;
}

}  // namespace runner
