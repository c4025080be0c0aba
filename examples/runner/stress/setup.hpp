// SPDX-License-Identifier: Apache-2.0
// A cell of the stability map: a small tank with something extreme in it, and what must hold of it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "meltsim/world.hpp"

namespace runner {
namespace stress {

/// A block of the tank. Lengths in spacings.
struct Block {
  meltsim::Vec3d low, size;  ///< corner, from the tank's; extents
  bool other = false;        ///< of material `other`, else of `ice`
  meltsim::Vec3d velocity;   ///< [m/s]
  meltsim::Vec3d spin;       ///< [rad/s]
  meltsim::Motion motion = meltsim::Motion::free;
};

/// One cell. Lengths in spacings unless they say otherwise; the default one is still water of 8 x 4 x 8 with a block of 27
/// above it.
struct Setup {
  Setup(std::string of_axis, std::string of_value);

  std::string axis, value;
  std::string drawn;  ///< what was drawn, of a cell that was; goes with what is said of a failure
  meltsim::WorldDesc world;
  meltsim::MaterialDesc water, ice, other;  ///< ice melts into water, other does not melt
  bool other_liquid = false;                ///< `other` is a liquid that lies above the water
  double width = 8, height = 14, depth = 4, other_depth = 4;
  bool walls = true;
  meltsim::Vec3d corner;  ///< of the tank [m]
  double water_temperature = 20, ice_temperature = -10;
  meltsim::Vec3d water_velocity;  ///< [m/s]
  std::vector<Block> blocks;
  std::function<meltsim::Status(meltsim::World&)> more;  ///< adds what is special; may be empty

  double times = 7;                   ///< simulated, in units of sqrt(spacing / gravity)
  std::uint64_t most_substeps = 300;  ///< ends it, too
  double step = 1;                    ///< of the stable one
  bool random_steps = false;          ///< drawn anew each time from 0.01 to 1 of the stable one
  std::function<meltsim::Status(meltsim::World&, int)> between;  ///< ahead of step k; may be empty
  bool long_one = false;                                         ///< only with --long

  // What must hold, besides that all is finite and that nothing halts.
  double most_falls =
      3;               ///< speeds of a fall that are allowed: jets outrun it, what explodes does by far more
  bool energy = true;  ///< kinetic and potential energy do not rise
  bool speed = true;   ///< nothing is faster than a fall can make it
  bool mass = true;    ///< of every particle, to the bit
  bool inside = true;  ///< nothing passes a wall
  bool bounded_heat = true;  ///< no temperature leaves the range of those at the start
  bool ledger = true;        ///< thermal energy is what it was and what came in
  bool momentum = false;     ///< is kept
  bool all_melts = false;
};

enum class Verdict { holds, clamped, refused, fails };

struct Outcome {
  Verdict verdict = Verdict::holds;
  std::string note;   ///< the flag, the refusal, what does not hold
  double energy = 0;  ///< largest gain, as a share of what there is
  double speed = 0;   ///< largest [m/s]
  std::uint64_t particles = 0, substeps = 0;
  double time = 0, wall_s = 0;  ///< simulated; taken [s]
};

/// All cells, axis by axis.
std::vector<Setup> all_cells();

/// The cell of this number in the series of this seed: several settings away from their defaults.
Setup drawn_cell(std::uint64_t seed, std::uint64_t number);

/// Runs one. It neither throws nor prints.
Outcome run_cell(Setup setup);

const char* name_of(Verdict verdict);

}  // namespace stress
}  // namespace runner
