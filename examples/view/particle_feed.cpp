// SPDX-License-Identifier: Apache-2.0
#include "particle_feed.hpp"

#include <epoxy/gl.h>

#include <vector>

#include "particle_vertex.hpp"

namespace view {

ParticleFeed::ParticleFeed() { glGenBuffers(1, &buffer_); }

ParticleFeed::~ParticleFeed() {
  device_.reset();
  glDeleteBuffers(1, &buffer_);
}

void ParticleFeed::reserve(std::size_t particles) {
  if (particles <= capacity_ && capacity_ > 0) return;
  capacity_ = particles + particles / 4 + 1024;  // emitters add more
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(capacity_ * sizeof(ParticleVertex)), nullptr,
               GL_STREAM_DRAW);
}

void ParticleFeed::attach(runner::Built& built) {
  detach(built.world);
  origin_ = built.world.resolved().origin;
  copy(built.world);
  make_device(built);
}

void ParticleFeed::make_device(runner::Built& built) {
  DeviceFeedResult made = make_device_feed(built.world, built.material_ids, buffer_, capacity_);
  device_ = std::move(made.feed);
  reason_ = made.reason;
}

void ParticleFeed::detach(meltsim::World& world) {
  remove_device_feed(world, device_);
  on_device_ = false;
}

void ParticleFeed::before_steps() {
  if (device_) device_->before_steps();
}

void ParticleFeed::after_steps(runner::Built& built, bool changed) {
  const std::size_t written = device_ ? device_->after_steps() : 0;
  if (!changed) return;
  if (written > 0) {
    count_ = written;
    on_device_ = true;
    return;
  }
  if (!device_) return copy(built.world);
  const std::string failure = device_->error();
  const bool outgrown = device_->needed() > capacity_;
  if (outgrown || !failure.empty()) {
    const std::size_t needed = device_->needed();
    detach(built.world);
    reserve(needed);
  }
  copy(built.world);
  if (!failure.empty()) reason_ = failure;
  else if (outgrown) make_device(built);
}

void ParticleFeed::copy(meltsim::World& world) {
  on_device_ = false;
  const auto data = world.particles();
  if (!data) {
    reason_ = data.error().message;
    count_ = 0;
    return;
  }
  std::vector<ParticleVertex> vertices(data->id.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const meltsim::Vec3d x = data->position[i] - origin_;
    vertices[i] = {static_cast<float>(x.x),
                   static_cast<float>(x.y),
                   static_cast<float>(x.z),
                   static_cast<float>(length(data->velocity[i])),
                   static_cast<float>(data->temperature[i]),
                   data->tag[i]};
  }
  // A buffer that the device writes must stay where it is until it has been taken back.
  if (vertices.size() > capacity_) detach(world);
  reserve(vertices.size());
  count_ = vertices.size();
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(count_ * sizeof(ParticleVertex)),
                  vertices.data());
}

std::string ParticleFeed::path() const {
  if (on_device_) return "written by the GPU (CUDA-OpenGL)";
  if (device_) return "host copy; the GPU takes over with the next step";
  return "host copy: " + reason_;
}

}  // namespace view
