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
  std::int32_t material = 0;                   ///< index, in order of run.json's materials
  float liquid_fraction = 0;                   ///< 0 solid .. 1 liquid: share of the latent heat taken up
  float contents[meltsim::most_species] = {};  ///< mass fractions of species
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
        id(frame.id.data()),
        species(frame.fractions.size()) {
    for (std::size_t k = 0; k < species; ++k) contents[k] = frame.fractions[k].data();
  }

  FrameParticle particle(std::size_t i) const {
    const meltsim::ParticleTag t = tag[i];
    const meltsim::Vec3f x = meltsim::cast<float>(origin + meltsim::cast<double>(position[i]));
    const meltsim::Vec3f v = velocity[i];
    const std::uint8_t phase = meltsim::is_solid(t) ? 1 : 0;
    FrameParticle p{{x.x, x.y, x.z},
                    {v.x, v.y, v.z},
                    temperature[i],
                    phase,
                    static_cast<std::int32_t>(meltsim::body_of(t)) - 1,
                    id[i],
                    static_cast<std::int32_t>(meltsim::material_of(t)),
                    fraction[i]};
    for (std::size_t k = 0; k < species; ++k) p.contents[k] = contents[k][i];
    return p;
  }

  meltsim::Vec3d origin;
  const meltsim::Vec3f *position, *velocity;
  const float *temperature, *fraction;
  const meltsim::ParticleTag* tag;
  const std::uint32_t* id;
  std::size_t species;
  const float* contents[meltsim::most_species] = {};
};
/// Live particles in order of id. When there are none, one placeholder: empty meshes break importers.
std::vector<FrameParticle> frame_particles(const meltsim::ParticleFrame& frame);

/// Columns of mass fractions, one per species of a frame: "w_" and the material's name, of letters, digits and underscores.
/// names: of all materials.
std::vector<std::string> content_columns(const meltsim::ParticleFrame& frame,
                                         const std::vector<std::string>& names);

/// contents: names of columns, as many as there are species.
std::string ply_text(const std::vector<FrameParticle>& particles, double time,
                     const std::vector<std::string>& contents = {});
/// The same of all particles of a frame, as a file.
void write_ply(const std::string& path, const meltsim::ParticleFrame& frame, double time,
               const std::vector<std::string>& contents = {});
std::string vtp_text(const std::vector<FrameParticle>& particles, double time,
                     const std::vector<std::string>& contents = {});
void write_vtp(const std::string& path, const meltsim::ParticleFrame& frame, double time,
               const std::vector<std::string>& contents = {});
/// The collection that gives ParaView the time of each file.
std::string pvd_text(const std::vector<std::pair<double, std::string>>& frames);

}  // namespace runner
