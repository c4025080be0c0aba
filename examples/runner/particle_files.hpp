// SPDX-License-Identifier: Apache-2.0
// Particles as files other programs open: binary PLY and VTP (VTK PolyData), both little-endian.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "meltsim/world.hpp"

namespace runner {

/// What is written of one particle.
struct FrameParticle {
  float position[3];   ///< [m]
  float velocity[3];   ///< [m/s]
  float temperature;   ///< [degrees Celsius]
  std::uint8_t phase;  ///< 0 liquid, 1 solid, 255 placeholder of an empty frame
  std::int32_t body;   ///< from 0, kept after melting; -1 = none
  std::uint32_t id;
  std::int32_t material = 0;  ///< index, in order of run.json's materials
  float liquid_fraction = 0;  ///< 0 solid .. 1 liquid: share of the latent heat taken up
};

/// The columns of a frame, for loops over its particles: where columns lie is read once, and not again behind every byte
/// that such a loop writes. The frame must outlive it.
struct ParticleColumns {
  explicit ParticleColumns(const meltsim::ParticleFrame& frame)
      : origin(frame.origin),
        position(frame.position.data()),
        velocity(frame.velocity.data()),
        temperature(frame.temperature.data()),
        fraction(frame.liquid_fraction.data()),
        tag(frame.tag.data()),
        id(frame.id.data()) {}

  FrameParticle particle(std::size_t i) const {
    const meltsim::ParticleTag t = tag[i];
    const meltsim::Vec3f x = meltsim::cast<float>(origin + meltsim::cast<double>(position[i]));
    const meltsim::Vec3f v = velocity[i];
    const std::uint8_t phase = meltsim::is_solid(t) ? 1 : 0;
    return {{x.x, x.y, x.z},
            {v.x, v.y, v.z},
            temperature[i],
            phase,
            static_cast<std::int32_t>(meltsim::body_of(t)) - 1,
            id[i],
            static_cast<std::int32_t>(meltsim::material_of(t)),
            fraction[i]};
  }

  meltsim::Vec3d origin;
  const meltsim::Vec3f *position, *velocity;
  const float *temperature, *fraction;
  const meltsim::ParticleTag* tag;
  const std::uint32_t* id;
};
/// Live particles in order of id. When there are none, one placeholder: empty meshes break importers.
std::vector<FrameParticle> frame_particles(const meltsim::ParticleFrame& frame);

std::string ply_text(const std::vector<FrameParticle>& particles, double time);
/// The same of all particles of a frame, as a file.
void write_ply(const std::string& path, const meltsim::ParticleFrame& frame, double time);
std::string vtp_text(const std::vector<FrameParticle>& particles, double time);
void write_vtp(const std::string& path, const meltsim::ParticleFrame& frame, double time);
/// The collection that gives ParaView the time of each file.
std::string pvd_text(const std::vector<std::pair<double, std::string>>& frames);

}  // namespace runner
