// SPDX-License-Identifier: Apache-2.0
#include "particle_feed.hpp"

#include <epoxy/gl.h>

#include <algorithm>
#include <vector>

#include "particle_vertex.hpp"

namespace view {

ParticleFeed::ParticleFeed() { glGenBuffers(1, &buffer_); }

ParticleFeed::~ParticleFeed() {
  device_.reset();
  glDeleteBuffers(1, &buffer_);
}

void ParticleFeed::attach(runner::Built& built) {
  device_.reset();
  origin_ = built.world.resolved().origin;
  curves_ = substance_curves(built.world, built.material_ids);
  capacity_ = 0;
  reason_.clear();
  update(built);
}

/// Room for as many, and for some more that emitters add. A buffer of which the GPU knows is let go of first.
void ParticleFeed::reserve(runner::Built& built, std::size_t particles) {
  if (particles <= capacity_ && capacity_ > 0) return;
  device_.reset();
  capacity_ = particles + particles / 4 + 1024;
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(capacity_ * sizeof(ParticleVertex)), nullptr,
               GL_STREAM_DRAW);
  if (failed_) return;
  DeviceFeedResult made = make_device_feed(built.world, built.material_ids, buffer_);
  device_ = std::move(made.feed);
  reason_ = made.reason;
}

void ParticleFeed::update(runner::Built& built) {
  count_ = 0;
  const auto state = built.world.device_state();
  if (!state) {
    reason_ = state.error().message;
    return;
  }
  const std::size_t n = static_cast<std::size_t>(state->particles);
  reserve(built, n);
  if (device_) {
    if (device_->write(*state)) {
      count_ = n;
      return;
    }
    reason_ = device_->error();
    failed_ = true;
    device_.reset();
  }
  if (state->backend == meltsim::Backend::cpu) count_ = convert(*state);
  else count_ = copy(built.world);
}

/// Memory of the backend is the host's: straight into the buffer.
std::size_t ParticleFeed::convert(const meltsim::StageContext& state) {
  const std::size_t n = static_cast<std::size_t>(state.particles);
  if (n == 0) return 0;
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  void* const mapped =
      glMapBufferRange(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(n * sizeof(ParticleVertex)),
                       GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
  if (mapped == nullptr) return 0;
  const auto each = [n](const auto& body) {
    for (std::size_t i = 0; i < n; ++i) body(i);
  };
  auto* const to = static_cast<ParticleVertex*>(mapped);
  if (state.precision == meltsim::Precision::double_precision)
    each(VertexBody<double>(state, curves_.data(), to));
  else each(VertexBody<float>(state, curves_.data(), to));
  return glUnmapBuffer(GL_ARRAY_BUFFER) == GL_TRUE
             ? n
             : 0;  // else the buffer was lost; the next picture has a new one
}

/// From a GPU that does not draw: once, in single precision.
std::size_t ParticleFeed::copy(meltsim::World& world) {
  meltsim::ReadRequest all;
  all.particles = true;
  const auto ticket = world.request(all);
  const auto reading = ticket ? world.take(*ticket) : meltsim::Result<meltsim::Reading>(ticket.error());
  if (!reading) {
    reason_ = reading.error().message;
    return 0;
  }
  const meltsim::ParticleFrame& data = reading->particles;
  const meltsim::Vec3f shift = meltsim::cast<float>(data.origin - origin_);
  std::vector<ParticleVertex> vertices(std::min(data.id.size(), capacity_));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const meltsim::Vec3f x = data.position[i] + shift;
    vertices[i] = {x.x, x.y, x.z, length(data.velocity[i]), data.temperature[i], data.tag[i]};
  }
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(vertices.size() * sizeof(ParticleVertex)),
                  vertices.data());
  return vertices.size();
}

std::string ParticleFeed::path() const {
  return device_ ? "written by the GPU (CUDA-OpenGL)" : "host copy: " + reason_;
}

}  // namespace view
