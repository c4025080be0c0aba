// SPDX-License-Identifier: Apache-2.0
// ReadingFrame: the one argument of the reading module's bodies: the scene's frame, and the buffers of a reading.
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "frame/frame.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Sums for totals besides LedgerSums.
struct ExtentSums {
  double coldest = 1e300, hottest = -1e300, heat = 0;  ///< degrees C; heat: sum of mass times temperature
  double speed = 0;                                    ///< largest [m/s]
  double solid_mass = 0;
  Vec3<double> solid_moment{};  ///< sum of mass times position, stored coordinates
  MELTSIM_HD static ExtentSums combine(ExtentSums a, const ExtentSums& b) {
    a.coldest = minimum(a.coldest, b.coldest);
    a.hottest = maximum(a.hottest, b.hottest);
    a.heat += b.heat;
    a.speed = maximum(a.speed, b.speed);
    a.solid_mass += b.solid_mass;
    a.solid_moment += b.solid_moment;
    return a;
  }
};

/// Exact sums over a piece, as PieceSums. Positions are relative to its first live vertex.
struct PieceTotals {
  std::int64_t count = 0, mass = 0;
  std::int64_t momentum[3] = {}, spin[3] = {}, first[3] = {}, second[6] = {};
  std::int64_t heat = 0;        ///< mass times temperature
  std::int64_t submerged = 0;   ///< shares of particles, in units of 1/submerged_units
  std::int64_t rest[3] = {};    ///< mass times position in the lattice as built
  std::int64_t turned[9] = {};  ///< mass times position times position in the lattice as built, row by row
  static constexpr int words = 31;
  static constexpr double submerged_units = 1u << 28;
};
static_assert(sizeof(PieceTotals) == PieceTotals::words * sizeof(std::int64_t));

struct PieceUnits {
  SumUnits sums;
  SumUnit heat;
};

/// Further data of a piece.
struct PieceRow {
  std::uint32_t first = 0, label = 0, body = 0;  ///< vertices; index of the body
  std::uint32_t low[3] = {}, high[3] = {};       ///< bounds relative to `at`: ordered(x), ordered(-x)
  Vec3<double> at{};                             ///< position of the first live vertex, stored coordinates
  Quat<double> turn{};                           ///< rotation of its region
};

/// Head of every reading.
struct ReadingHead {
  WorldStatus status;
  LedgerSums sums;
  ContentSums contents;  ///< where there are species
  ExtentSums extents;
  PieceUnits units;
  std::uint32_t pieces = 0;    ///< how many there are, whether or not there is room for them
  std::uint32_t complete = 0;  ///< 0: the World had halted, so that only the status was read
};

/// Bits whose order as an unsigned number is that of x.
MELTSIM_HD std::uint32_t ordered(float x) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
MELTSIM_HD float unordered(std::uint32_t bits) {
  bits = (bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits;
  float x = 0;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}
/// The same of the next smaller float where x is not one.
MELTSIM_HD std::uint32_t ordered_below(double x) {
  const auto f = static_cast<float>(x);
  return ordered(f) - (static_cast<double>(f) > x ? 1u : 0u);
}

/// Columns along gravity, a few spacings wide, over the domain; where nothing bounds it they repeat.
struct ColumnGrid {
  Vec3<double> up{0, 1, 0}, a{1, 0, 0}, b{0, 0, 1};
  double low_a = 0, low_b = 0, side = 1, floor = 0;
  double extent_a = 0, extent_b = 0;  ///< of the domain, cut at its faces; 0 = nothing is cut
  std::int32_t na = 1, nb = 1, levels = 1;
  std::uint32_t repeats = 0;
};

/// Sums over a column.
struct Column {
  std::int64_t volume = 0;          ///< of liquid above the base, in units of dx^3/units
  std::uint32_t top = 0xffffffffu;  ///< ordered(-height) of the topmost liquid
  std::uint32_t solid = 0;          ///< bit 0: there is some; bit 1: near the top of the liquid
  static constexpr double units = 1u << 20;
};

/// Sums over a square of columns: weights of columns with a level and of empty ones.
struct LevelSums {
  double wet = 0, dry = 0, level = 0;  ///< level: weight times level [m]
};

/// Particles in single precision: arrays of n, by id, one behind the other.
struct PackedParticles {
  Vec3<float>*position = nullptr, *velocity = nullptr;
  float *temperature = nullptr, *fraction = nullptr, *density = nullptr, *pressure = nullptr;
  std::uint32_t *tag = nullptr, *piece = nullptr;
  std::uint32_t* color = nullptr;    ///< elsewhere, where colours are asked for
  float* solute[most_species] = {};  ///< mass fractions, of the species that there are
  /// Size of a particle's row.
  static constexpr std::uint64_t bytes(std::uint64_t species) {
    return 2 * sizeof(Vec3<float>) + (4 + species) * sizeof(float) + 2 * sizeof(std::uint32_t);
  }
  static PackedParticles at(unsigned char* base, std::uint64_t n, std::uint32_t species) {
    PackedParticles p;
    const auto place = [&base, n](auto*& to) {
      to = reinterpret_cast<std::remove_reference_t<decltype(to)>>(base);
      base += n * sizeof *to;
    };
    place(p.position);
    place(p.velocity);
    place(p.temperature);
    place(p.fraction);
    place(p.density);
    place(p.pressure);
    place(p.tag);
    place(p.piece);
    for (std::uint32_t k = 0; k < species; ++k) place(p.solute[k]);
    return p;
  }
};

/// Colours of particles: entries of a table of 256.
struct PackColors {
  std::uint32_t by = 0;  ///< ColorBy
  float coldest = 0;     ///< temperature of the first entry [degrees Celsius]
  float per_degree = 0;  ///< entries per degree
  const std::uint32_t* table = nullptr;
};

/// Impulses on a body, and its motion if the host moves it or follows it.
struct ForcesRow {
  BodyForceTotals totals;
  physics::RigidMotion motion;
};

template <class T>
struct ReadingFrame {
  Frame<T> s;                     ///< the scene
  std::uint32_t rolled_back = 0;  ///< the World is back at its last good state
  std::uint32_t has_density = 0;  ///< a sub-step has worked densities out
  std::uint32_t clears = 0;       ///< extremes begin anew
  std::uint32_t piece_room = 0;   ///< pieces there is room for
  Vec3<double> gravity{};         ///< that of the scene is rounded
  // For the units of sums over pieces.
  double largest_mass = 1,
         size = 1;  ///< of a particle [kg]; of a position relative to another of its piece [m]
  std::int32_t sum_bits = 40;
  ReadingHead* head = nullptr;
  // pieces
  const std::uint32_t* body_origin = nullptr;  ///< site at the low corner of the body's vertices
  std::uint32_t* is_label = nullptr;           ///< bit per vertex
  std::uint32_t* piece_of = nullptr;           ///< labels up to a vertex, itself included
  PieceRow* rows = nullptr;
  PieceTotals* totals = nullptr;
  ColumnGrid grid;
  Column* columns = nullptr;
  LevelSums* levels = nullptr;  ///< column by column, then of 2x2, of 4x4, ...
  PackedParticles p;
  PackColors colors;
  std::uint32_t bodies_taken = 0, events_taken = 0;  ///< rows of each, 0 where they are not asked for
  ForcesRow* forces = nullptr;                       ///< per body
  EventHead* event_head = nullptr;
  EventRow* events = nullptr;  ///< the ring
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
