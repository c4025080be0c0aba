// SPDX-License-Identifier: Apache-2.0
#include "recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "expect.hpp"
#include "files.hpp"
#include "numbers.hpp"
#include "particle_files.hpp"
#include "stepper.hpp"

namespace runner {

namespace {

CsvFile open_table(const std::string& path, const std::string& header, std::size_t time_column,
                   const RunState* resumed, std::vector<std::string>* kept = nullptr) {
  if (resumed == nullptr) return {path, header};
  return CsvFile::resume(path, header, time_column, resumed->time, kept);
}

std::vector<double> times_of(const std::vector<std::string>& rows) {
  std::vector<double> times;
  for (const std::string& row : rows) times.push_back(parse_number(split_commas(row).at(1)).value_or(0));
  return times;
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : std::min(1.0, static_cast<double>(part) / static_cast<double>(whole));
}

}  // namespace

Recorder::Recorder(const Scene& scene, RunDirectory directory, Built& built, std::uint64_t planned_frames,
                   const RunState* resumed)
    : scene_(scene),
      directory_(std::move(directory)),
      stats_(open_table(directory_.file("stats.csv"), stats_header(), 1, resumed, &kept_stats_)),
      bodies_(open_table(directory_.file("bodies.csv"), bodies_header, 1, resumed)),
      export_(scene, directory_, times_of(kept_stats_)),
      pictures_(scene, directory_, built, planned_frames, resumed) {
  probes_ = open_table(directory_.file("probes.csv"), probes_header, 1, resumed);
}

void Recorder::frame(Built& built, const RunState& state, double dt, double ms_per_step) {
  last_.step = state.steps;
  last_.time = state.time;
  last_.dt = dt;
  last_.totals = expect(built.world.totals());
  last_.melted_fraction = share(net_melted(last_.totals.melted, last_.totals.frozen), state.meltable);
  last_.ms_per_step = ms_per_step;
  last_.courant = expect(built.world.ledger()).courant;
  stats_.row(stats_line(last_));
  write_bodies(built, state.time);
  write_particles(built.world, state);
  flush();
}

void Recorder::write_bodies(Built& built, double time) {
  meltable_left_ = 0;
  for (const meltsim::PieceInfo& piece : expect(built.world.pieces())) {
    bodies_.row(bodies_line(piece, time));
    if (built.body_melts.at(piece.body.index)) meltable_left_ += piece.particles;
  }
}

void Recorder::write_particles(meltsim::World& world, const RunState& state) {
  if (!export_.any() && !pictures_.wants(state.next_frame)) return;
  const std::vector<FrameParticle> particles = frame_particles(expect(world.particles()));
  pictures_.frame(state.next_frame, state.time, particles);
  export_.write(world, state.next_frame, state.time, particles);
}

const std::string& Recorder::problem() const {
  return pictures_.problem().empty() ? export_.problem() : pictures_.problem();
}

double Recorder::next_probe(double now) const {
  double due = std::numeric_limits<double>::infinity();
  for (const SceneProbe& probe : scene_.probes) due = std::min(due, next_sample(now, probe.every));
  return due;
}

void Recorder::probes(meltsim::World& world, double since, double now) {
  for (const SceneProbe& probe : scene_.probes) {
    const double due = samples_by(now, probe.every);
    if (std::isfinite(due) && since >= 0 && due <= samples_by(since, probe.every)) continue;
    for (const std::string& field : probe.fields) {
      const std::vector<double> values = expect(world.sample({probe.at}, field));
      probes_->row(fmt::format("{},{},{},{}", probe.name, csv_number(now), field, csv_number(values.at(0))));
    }
  }
}

void Recorder::flush() {
  stats_.flush();
  bodies_.flush();
  probes_->flush();
}

void Recorder::save() {
  flush();
  pictures_.save();
}

void Recorder::finish(meltsim::World& world, const RunState& state) {
  flush();
  pictures_.finish(world, state);
}

}  // namespace runner
