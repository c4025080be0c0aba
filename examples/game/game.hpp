// SPDX-License-Identifier: Apache-2.0
// A small game on World alone: a cup that the player moves, a hot iron, a tap that is switched, ice that comes apart, and flags that
// its pieces carry. Every frame is: set motions, step, take events, read pieces.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "meltsim/meltsim.hpp"

namespace game {

using meltsim::Vec3d;

struct Settings {
  double spacing = 0.04;  ///< [m]; 0.025 looks better and takes six times as long
  meltsim::Backend backend = meltsim::Backend::automatic;
  int threads = 0;
};

/// What the player does in a frame.
struct Hands {
  Vec3d cup;         ///< where the cup is at the end of it: the middle of its bottom [m]
  double tilt = 0;   ///< of the cup, about z [rad]
  Vec3d iron;        ///< middle of the iron's lower face [m]
  bool tap = false;  ///< whether water runs
};

/// What a piece of ice carries: the host's own mesh, placed by where the piece is.
struct Flag {
  std::uint32_t piece = 0;  ///< label of its piece
  Vec3d position;           ///< of the piece's centre [m]
  meltsim::Quat<double> orientation;
  Vec3d at;  ///< where it stands, from the centre as the piece was when it got the flag [m]
  meltsim::Quat<double> planted;  ///< orientation then
  bool planted_in_piece = true;   ///< false: its piece has melted away
};

/// Triangles of a flag, where it is now.
struct FlagMesh {
  std::vector<Vec3d> position;
  std::vector<std::uint32_t> triangles;
};

/// How often what happened.
struct Score {
  std::uint64_t melted = 0, split = 0, bumps = 0, gone = 0;
};

class Game {
 public:
  static meltsim::Result<Game> make(const Settings& settings);

  /// One frame. What happened is appended to `news`, a line each.
  meltsim::Status frame(double seconds, const Hands& hands, std::vector<std::string>& news);

  meltsim::World& world() { return world_; }
  const std::vector<Flag>& flags() const { return flags_; }
  const Score& score() const { return score_; }
  FlagMesh mesh_of(const Flag& flag) const;
  /// Liquid in the cup [litres].
  meltsim::Result<double> in_cup();

  static constexpr Vec3d size{1.6, 1.0, 0.6};  ///< of the tank [m]
  static constexpr double pool = 0.36;         ///< depth of the water at first [m]
  static Hands at_rest();                      ///< where cup and iron begin

 private:
  explicit Game(meltsim::World world) : world_(std::move(world)) {}
  meltsim::Status take_news(std::vector<std::string>& news);
  meltsim::Status follow_pieces();
  std::string name_of(const meltsim::Event& e) const;

  meltsim::World world_;
  meltsim::BodyId cup_, iron_, ice_, shelf_;
  meltsim::EmitterId tap_;
  Hands hands_;
  bool runs_ = false;
  std::vector<Flag> flags_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> splits_;  ///< from, new piece
  Score score_;
};

/// The player of the headless mode: fills the cup in the pool, pours it out, melts the ice's neck with the iron and pushes a half off
/// its shelf.
Hands script(double time, const Score& score);

}  // namespace game
