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

/// The i-th particle of a frame.
FrameParticle frame_particle(const meltsim::ParticleFrame& frame, std::size_t i);
/// Live particles in order of id. When there are none, one placeholder: empty meshes break importers.
std::vector<FrameParticle> frame_particles(const meltsim::ParticleFrame& frame);

std::string ply_text(const std::vector<FrameParticle>& particles, double time);
/// The same of all particles of a frame, as a file.
void write_ply(const std::string& path, const meltsim::ParticleFrame& frame, double time);
std::string vtp_text(const std::vector<FrameParticle>& particles, double time);
/// The collection that gives ParaView the time of each file.
std::string pvd_text(const std::vector<std::pair<double, std::string>>& frames);

}  // namespace runner
