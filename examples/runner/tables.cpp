// SPDX-License-Identifier: Apache-2.0
#include "tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "csv.hpp"

namespace runner {

namespace {

/// A column of stats.csv, which is a key of the summary in run.json, too.
struct StatsColumn {
  const char* name;
  bool whole;  ///< a count
  double (*value)(const StatsRow&);
};
constexpr StatsColumn stats_table[] = {
    {"step", true, [](const StatsRow& r) { return double(r.step); }},
    {"time_s", false, [](const StatsRow& r) { return r.time; }},
    {"dt_s", false, [](const StatsRow& r) { return r.dt; }},
    {"n_fluid", true, [](const StatsRow& r) { return double(r.totals.fluid); }},
    {"n_solid", true, [](const StatsRow& r) { return double(r.totals.solid); }},
    {"n_bodies", true, [](const StatsRow& r) { return double(r.totals.bodies); }},
    {"melted_fraction", false, [](const StatsRow& r) { return r.melted_fraction; }},
    {"mass_kg", false, [](const StatsRow& r) { return r.totals.mass; }},
    {"momentum_x", false, [](const StatsRow& r) { return r.totals.momentum.x; }},
    {"momentum_y", false, [](const StatsRow& r) { return r.totals.momentum.y; }},
    {"momentum_z", false, [](const StatsRow& r) { return r.totals.momentum.z; }},
    {"kinetic_J", false, [](const StatsRow& r) { return r.totals.kinetic; }},
    {"potential_J", false, [](const StatsRow& r) { return r.totals.potential; }},
    {"thermal_J", false, [](const StatsRow& r) { return r.totals.thermal; }},
    {"T_min", false, [](const StatsRow& r) { return r.totals.temperature_min; }},
    {"T_mean", false, [](const StatsRow& r) { return r.totals.temperature_mean; }},
    {"T_max", false, [](const StatsRow& r) { return r.totals.temperature_max; }},
    {"com_solid_x", false, [](const StatsRow& r) { return r.totals.solid_center.x; }},
    {"com_solid_y", false, [](const StatsRow& r) { return r.totals.solid_center.y; }},
    {"com_solid_z", false, [](const StatsRow& r) { return r.totals.solid_center.z; }},
    {"max_speed", false, [](const StatsRow& r) { return r.totals.max_speed; }},
    {"density_error_mean", false, [](const StatsRow& r) { return r.totals.density_error_mean; }},
    {"density_error_max", false, [](const StatsRow& r) { return r.totals.density_error_max; }},
    {"ms_per_step", false, [](const StatsRow& r) { return r.ms_per_step; }},
    {"angular_momentum_x", false, [](const StatsRow& r) { return r.totals.angular_momentum.x; }},
    {"angular_momentum_y", false, [](const StatsRow& r) { return r.totals.angular_momentum.y; }},
    {"angular_momentum_z", false, [](const StatsRow& r) { return r.totals.angular_momentum.z; }},
    {"latent_J", false, [](const StatsRow& r) { return r.totals.latent; }},
    {"heat_in_J", false, [](const StatsRow& r) { return r.totals.heat_in; }},
    {"courant", false, [](const StatsRow& r) { return r.courant; }},
    {"solute1_kg", false, [](const StatsRow& r) { return r.solute[0]; }},
    {"solute2_kg", false, [](const StatsRow& r) { return r.solute[1]; }},
    {"solute3_kg", false, [](const StatsRow& r) { return r.solute[2]; }},
    {"solution_J", false, [](const StatsRow& r) { return r.solution; }},
    {"n_left", true, [](const StatsRow& r) { return double(r.left); }},
    {"n_entered", true, [](const StatsRow& r) { return double(r.entered); }},
    {"dissolved1_kg", false, [](const StatsRow& r) { return r.dissolved[0]; }},
    {"dissolved2_kg", false, [](const StatsRow& r) { return r.dissolved[1]; }},
    {"dissolved3_kg", false, [](const StatsRow& r) { return r.dissolved[2]; }},
    {"liquid_fraction", false, [](const StatsRow& r) {
       return r.totals.latent_max > 0 ? r.totals.latent / r.totals.latent_max : 0.0;
     }}};
static_assert(meltsim::most_species == 3);

/// A column of bodies.csv, behind body, time_s and n.
struct BodiesColumn {
  const char* name;
  double (*value)(const meltsim::PieceInfo&);
};
constexpr BodiesColumn bodies_table[] = {
    {"mass_kg", [](const meltsim::PieceInfo& p) { return p.mass; }},
    {"com_x", [](const meltsim::PieceInfo& p) { return p.center.x; }},
    {"com_y", [](const meltsim::PieceInfo& p) { return p.center.y; }},
    {"com_z", [](const meltsim::PieceInfo& p) { return p.center.z; }},
    {"vx", [](const meltsim::PieceInfo& p) { return p.velocity.x; }},
    {"vy", [](const meltsim::PieceInfo& p) { return p.velocity.y; }},
    {"vz", [](const meltsim::PieceInfo& p) { return p.velocity.z; }},
    {"T_mean", [](const meltsim::PieceInfo& p) { return p.temperature_mean; }},
    {"submerged_fraction", [](const meltsim::PieceInfo& p) { return p.submerged_fraction; }},
    {"q_w", [](const meltsim::PieceInfo& p) { return p.orientation.w; }},
    {"q_x", [](const meltsim::PieceInfo& p) { return p.orientation.x; }},
    {"q_y", [](const meltsim::PieceInfo& p) { return p.orientation.y; }},
    {"q_z", [](const meltsim::PieceInfo& p) { return p.orientation.z; }},
    {"omega_x", [](const meltsim::PieceInfo& p) { return p.angular_velocity.x; }},
    {"omega_y", [](const meltsim::PieceInfo& p) { return p.angular_velocity.y; }},
    {"omega_z", [](const meltsim::PieceInfo& p) { return p.angular_velocity.z; }},
    {"min_x", [](const meltsim::PieceInfo& p) { return p.bounds.min.x; }},
    {"min_y", [](const meltsim::PieceInfo& p) { return p.bounds.min.y; }},
    {"min_z", [](const meltsim::PieceInfo& p) { return p.bounds.min.z; }},
    {"max_x", [](const meltsim::PieceInfo& p) { return p.bounds.max.x; }},
    {"max_y", [](const meltsim::PieceInfo& p) { return p.bounds.max.y; }},
    {"max_z", [](const meltsim::PieceInfo& p) { return p.bounds.max.z; }}};

}  // namespace

const std::string probes_header = "name,time_s,field,value";

std::string stats_header() {
  std::string header;
  for (const StatsColumn& column : stats_table)
    header += (header.empty() ? "" : ",") + std::string(column.name);
  return header;
}

std::string bodies_header() {
  std::string header = "body,time_s,n";
  for (const BodiesColumn& column : bodies_table) header += std::string(",") + column.name;
  return header;
}

std::string stats_line(const StatsRow& row) {
  std::vector<std::string> cells;
  for (const StatsColumn& column : stats_table) {
    const double value = column.value(row);
    cells.push_back(column.whole ? fmt::format("{:.0f}", value) : csv_number(value));
  }
  return fmt::format("{}", fmt::join(cells, ","));
}

Json stats_json(const StatsRow& row) {
  Json json;
  for (const StatsColumn& column : stats_table) {
    if (column.whole) json[column.name] = static_cast<std::uint64_t>(column.value(row));
    else json[column.name] = column.value(row);
  }
  return json;
}

std::string bodies_line(const meltsim::PieceInfo& piece, double time) {
  std::vector<std::string> cells{piece.name, csv_number(time), std::to_string(piece.particles)};
  for (const BodiesColumn& column : bodies_table) cells.push_back(csv_number(column.value(piece)));
  return fmt::format("{}", fmt::join(cells, ","));
}

}  // namespace runner
