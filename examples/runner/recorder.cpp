// SPDX-License-Identifier: Apache-2.0
#include "recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "files.hpp"
#include "numbers.hpp"
#include "particle_files.hpp"
#include "processors.hpp"

namespace runner {

namespace {

// Of that many frames each is tried for still.png. Of more than these the one two ahead is near enough.
constexpr std::uint64_t most_few_frames = 8;
// Molten shares of a frame that is tried: it shows both what melts and what has melted.
constexpr double least_melted = 0.05, most_melted = 0.95;
// Molten share at which a frame ahead is chosen: some more melts until it is there.
constexpr double nearly_half = 0.42;

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

/// Threads for text. Steps on the CPU need theirs, and are slow enough for one.
int threads_beside(meltsim::Backend steps) {
  constexpr int most = 4;  // four write faster than a GPU samples a thousand points
  return steps == meltsim::Backend::cpu ? 1 : std::min(most, processors());
}

/// Memory of a frame that waits for the disk.
std::size_t bytes_of(const meltsim::ParticleFrame& particles, const Recorder::Samples& samples) {
  constexpr std::size_t row = 2 * sizeof(meltsim::Vec3f) + 4 * sizeof(float) + 2 * sizeof(std::uint32_t) +
                              sizeof(meltsim::ParticleTag);
  std::size_t bytes = particles.id.size() * (row + particles.fractions.size() * sizeof(float));
  for (const meltsim::ProbeSeries& series : samples)
    bytes += series.time.size() * sizeof(double) + series.values.size() * sizeof(double);
  return bytes;
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : std::min(1.0, static_cast<double>(part) / static_cast<double>(whole));
}

}  // namespace

Recorder::Recorder(const Scene& scene, RunDirectory directory, Built& built, std::uint64_t planned_frames,
                   const RunState* resumed, bool still, bool page)
    : scene_(scene),
      directory_(std::move(directory)),
      probe_table_(scene, built.probes, threads_beside(built.world.backend())),
      stats_(open_table(directory_.file("stats.csv"), stats_header(), 1, resumed, &kept_stats_)),
      bodies_(open_table(directory_.file("bodies.csv"), bodies_header(), 1, resumed)),
      probes_(open_table(directory_.file("probes.csv"), probes_header, 1, resumed)),
      export_(scene, directory_, times_of(kept_stats_)),
      pictures_(scene, directory_, built, planned_frames, resumed) {
  replay_every_ = pictures_.every();
  still_ = still;
  page_ = page;
  few_frames_ = planned_frames > 0 && planned_frames <= most_few_frames;
  // A resumed run has one if it had come so far.
  const bool has_still = resumed != nullptr && exists(directory_.file("still.png"));
  if (has_still && few_frames_) still_share_ = resumed->still_share;
  wants_still_ = still && !(few_frames_ ? still_share_.has_value() : has_still);
}

void Recorder::choose_still(std::uint64_t counted, std::uint64_t ahead) {
  if (!still_) return;
  const double melted = last_.melted_fraction;
  if (few_frames_) {
    if (melted < least_melted || melted > most_melted) return;
    if (still_share_ && !(std::abs(melted - 0.5) < std::abs(*still_share_ - 0.5))) return;
    still_share_ = melted;
    still_frame_ = counted;
  } else {
    if (!wants_still_ || melted < nearly_half) return;
    still_frame_ = ahead;
  }
  wants_still_ = false;
}

bool Recorder::wants_particles(std::uint64_t index) const {
  return export_.any() || index == still_frame_ || (page_ && index % replay_every_ == 0);
}

Frame Recorder::count(const Built& built, std::uint64_t index, StatsRow row, meltsim::Reading reading,
                      std::uint64_t meltable) {
  row.totals = reading.totals;
  row.melted_fraction = share(net_melted(row.totals.melted, row.totals.frozen), meltable);
  row.courant = reading.ledger.courant;
  row.solute = reading.ledger.solute;
  row.dissolved = reading.ledger.dissolved;
  row.solution = reading.ledger.solution;
  row.left = reading.result.removed;
  row.entered = reading.result.entered;
  meltable_left_ = 0;
  for (const meltsim::PieceInfo& piece : reading.pieces) {
    if (built.body_melts.at(piece.body.index)) meltable_left_ += piece.particles;
  }
  last_ = row;
  return {index, row, std::move(reading.pieces)};
}

std::shared_ptr<const FrameShapes> Recorder::shapes(meltsim::World& world,
                                                    const meltsim::ParticleFrame& particles,
                                                    std::uint64_t index, double time) {
  if (!wants_world(index)) return nullptr;
  return std::make_shared<const FrameShapes>(export_.shapes(world, time, particles));
}

void Recorder::write(Frame frame, meltsim::ParticleFrame particles, Samples samples,
                     std::shared_ptr<const FrameShapes> shapes) {
  const bool seen = wants_particles(frame.index);
  const bool still = frame.index == still_frame_;
  const std::size_t bytes = shapes ? Writer::most_bytes : bytes_of(particles, samples);
  std::function<void()> job = [this, seen, still, samples = std::move(samples), frame = std::move(frame),
                               particles = std::move(particles), shapes = std::move(shapes)] {
    const double time = frame.row.time;
    stats_.row(stats_line(frame.row));
    for (const meltsim::PieceInfo& piece : frame.pieces) bodies_.row(bodies_line(piece, time));
    probe_table_.write(probes_, samples);
    flush();
    if (!seen) return;
    pictures_.frame(frame.index, time, particles);
    replay_every_ = pictures_.every();
    if (export_.any())
      export_.write(frame.index, time, particles, export_.wants_shapes() ? shapes.get() : nullptr);
    if (still && shapes) pictures_.still(shapes);
  };
  writer_.push(std::move(job), bytes);
}

std::set<std::string> Recorder::problems() const {
  std::set<std::string> problems{pictures_.problem(), export_.problem(), export_.camera_problem()};
  problems.erase("");
  return problems;
}

void Recorder::flush() {
  stats_.flush();
  bodies_.flush();
  probes_.flush();
}

void Recorder::save(Checkpoint checkpoint, Samples samples) {
  writer_.push([this, samples = std::move(samples), checkpoint = std::move(checkpoint)] {
    probe_table_.write(probes_, samples);
    flush();
    pictures_.save();
    write_checkpoint(directory_.file("checkpoint.bin"), checkpoint);
  });
}

void Recorder::finish() { writer_.finish(); }

void Recorder::pictures(meltsim::World& world, const RunState& state, bool ended) {
  writer_.finish();
  // The frame that was chosen may lie beyond the end.
  const bool missing = still_ && (wants_still_ || (still_frame_ != none && still_frame_ >= state.next_frame));
  pictures_.finish(world, state, page_, ended && missing);
}

}  // namespace runner
