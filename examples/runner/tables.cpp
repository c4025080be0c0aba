// SPDX-License-Identifier: Apache-2.0
#include "tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "csv.hpp"

namespace runner {

const std::vector<std::string> stats_columns{"step",
                                             "time_s",
                                             "dt_s",
                                             "n_fluid",
                                             "n_solid",
                                             "n_bodies",
                                             "melted_fraction",
                                             "mass_kg",
                                             "momentum_x",
                                             "momentum_y",
                                             "momentum_z",
                                             "kinetic_J",
                                             "potential_J",
                                             "thermal_J",
                                             "T_min",
                                             "T_mean",
                                             "T_max",
                                             "com_solid_x",
                                             "com_solid_y",
                                             "com_solid_z",
                                             "max_speed",
                                             "density_error_mean",
                                             "density_error_max",
                                             "ms_per_step",
                                             "angular_momentum_x",
                                             "angular_momentum_y",
                                             "angular_momentum_z",
                                             "latent_J",
                                             "heat_in_J",
                                             "courant",
                                             "solute1_kg",
                                             "solute2_kg",
                                             "solute3_kg",
                                             "solution_J"};
static_assert(meltsim::most_species == 3);
const std::string probes_header = "name,time_s,field,value";
const std::string bodies_header =
    "body,time_s,n,mass_kg,com_x,com_y,com_z,vx,vy,vz,T_mean,submerged_fraction,"
    "q_w,q_x,q_y,q_z,omega_x,omega_y,omega_z,min_x,min_y,min_z,max_x,max_y,max_z";

std::string stats_header() { return fmt::format("{}", fmt::join(stats_columns, ",")); }

namespace {

constexpr std::size_t count_columns[] = {0, 3, 4, 5};  ///< whole numbers

/// In the order of stats_columns.
std::vector<double> stats_values(const StatsRow& row) {
  const meltsim::Totals& t = row.totals;
  const auto count = [](std::uint64_t n) { return static_cast<double>(n); };
  return {count(row.step),
          row.time,
          row.dt,
          count(t.fluid),
          count(t.solid),
          count(t.bodies),
          row.melted_fraction,
          t.mass,
          t.momentum.x,
          t.momentum.y,
          t.momentum.z,
          t.kinetic,
          t.potential,
          t.thermal,
          t.temperature_min,
          t.temperature_mean,
          t.temperature_max,
          t.solid_center.x,
          t.solid_center.y,
          t.solid_center.z,
          t.max_speed,
          t.density_error_mean,
          t.density_error_max,
          row.ms_per_step,
          t.angular_momentum.x,
          t.angular_momentum.y,
          t.angular_momentum.z,
          t.latent,
          t.heat_in,
          row.courant,
          row.solute[0],
          row.solute[1],
          row.solute[2],
          row.solution};
}

bool is_count(std::size_t column) {
  for (const std::size_t i : count_columns) {
    if (i == column) return true;
  }
  return false;
}

}  // namespace

std::string stats_line(const StatsRow& row) {
  std::vector<std::string> cells;
  for (const double value : stats_values(row)) {
    cells.push_back(is_count(cells.size()) ? fmt::format("{:.0f}", value) : csv_number(value));
  }
  return fmt::format("{}", fmt::join(cells, ","));
}

Json stats_json(const StatsRow& row) {
  Json json;
  const std::vector<double> values = stats_values(row);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (is_count(i)) json[stats_columns[i]] = static_cast<std::uint64_t>(values[i]);
    else json[stats_columns[i]] = values[i];
  }
  return json;
}

std::string bodies_line(const meltsim::PieceInfo& piece, double time) {
  std::vector<std::string> cells{piece.name, csv_number(time), std::to_string(piece.particles)};
  for (const double value : {piece.mass,
                             piece.center.x,
                             piece.center.y,
                             piece.center.z,
                             piece.velocity.x,
                             piece.velocity.y,
                             piece.velocity.z,
                             piece.temperature_mean,
                             piece.submerged_fraction,
                             piece.orientation.w,
                             piece.orientation.x,
                             piece.orientation.y,
                             piece.orientation.z,
                             piece.angular_velocity.x,
                             piece.angular_velocity.y,
                             piece.angular_velocity.z,
                             piece.bounds.min.x,
                             piece.bounds.min.y,
                             piece.bounds.min.z,
                             piece.bounds.max.x,
                             piece.bounds.max.y,
                             piece.bounds.max.z}) {
    cells.push_back(csv_number(value));
  }
  return fmt::format("{}", fmt::join(cells, ","));
}

}  // namespace runner
