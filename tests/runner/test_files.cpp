// SPDX-License-Identifier: Apache-2.0
// What is written and read back: checkpoints, tables, particle files, library errors.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "checkpoint.hpp"
#include "csv.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "library_error.hpp"
#include "memory.hpp"
#include "particle_files.hpp"
#include "tables.hpp"

namespace runner {
namespace {

class Directory {
 public:
  Directory() {
    std::string name = (std::filesystem::temp_directory_path() / "meltsim-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Directory() { std::filesystem::remove_all(path_); }
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

Checkpoint example() {
  Checkpoint checkpoint;
  checkpoint.state.time = 1.0 / 3;
  checkpoint.state.steps = 67;
  checkpoint.state.next_frame = 9;
  checkpoint.state.melted_at = 0.25;
  checkpoint.scene = {{"meltsim", 1}};
  checkpoint.snapshot = {0, 255, 7, 10};
  return checkpoint;
}

TEST(Checkpoint, ComesBackToTheLastBit) {
  const Directory directory;
  const std::string path = directory.file("checkpoint.bin");
  write_checkpoint(path, example());
  const Checkpoint back = read_checkpoint(path);
  EXPECT_EQ(back.state.time, 1.0 / 3);
  EXPECT_EQ(back.state.steps, 67u);
  EXPECT_EQ(back.state.melted_at, 0.25);
  EXPECT_EQ(back.snapshot, example().snapshot);
  EXPECT_FALSE(exists(path + ".tmp"));
}

TEST(Checkpoint, AnyChangeOfAnyByteIsFound) {
  const Directory directory;
  const std::string path = directory.file("checkpoint.bin");
  write_checkpoint(path, example());
  const std::string good = read_file(path);
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x20);
    write_file(path, bad);
    EXPECT_THROW(read_checkpoint(path), Failure) << "byte " << i;
    write_file(path, good.substr(0, i));
    EXPECT_THROW(read_checkpoint(path), Failure) << "cut at " << i;
  }
}

TEST(Csv, ResumingDropsRowsThatAreComputedAgain) {
  const Directory directory;
  const std::string path = directory.file("t.csv");
  {
    CsvFile csv(path, "name,time_s");
    for (const char* row : {"a,0", "b,0.333333333", "c,0.5", "d,"}) csv.row(row);
    csv.flush();
  }
  std::vector<std::string> kept;
  CsvFile csv = CsvFile::resume(path, "name,time_s", 1, 1.0 / 3, &kept);
  csv.row("e,0.4");
  csv.flush();
  EXPECT_EQ(kept.size(), 2u);
  EXPECT_EQ(read_file(path), "name,time_s\na,0\nb,0.333333333\ne,0.4\n");
}

TEST(Tables, ARowHasAValueForEveryColumn) {
  StatsRow row;
  row.totals.fluid = 12;
  EXPECT_EQ(split_commas(stats_line(row)).size(), stats_columns.size());
  EXPECT_EQ(split_commas(stats_header()).size(), stats_columns.size());
  EXPECT_EQ(stats_json(row).at("n_fluid"), 12);
  EXPECT_EQ(split_commas(bodies_line({}, 0)).size(), split_commas(bodies_header).size());
}

TEST(ParticleFiles, AnEmptyFrameHoldsAPlaceholder) {
  const std::vector<FrameParticle> particles = frame_particles({});
  ASSERT_EQ(particles.size(), 1u);
  EXPECT_EQ(particles[0].phase, 255);
  EXPECT_NE(ply_text(particles, 0).find("element vertex 1\n"), std::string::npos);
}

TEST(LibraryError, GoesToTheKeyItNames) {
  const std::vector<FieldPlace> places{{"support_radius", "particles.support", "a.yaml:2:9"},
                                       {"heat.max_stages", "heat.max_stages", "a.yaml:5:3"}};
  const auto text = [&](const char* message) {
    return std::string(
        library_failure({meltsim::ErrorCode::invalid_argument, message}, places, "", "a.yaml:1:1").what());
  };
  EXPECT_EQ(text("support_radius: must be 1.5..6 spacings"),
            "a.yaml:2:9: particles.support: must be 1.5..6 spacings");
  EXPECT_EQ(text("body \"x\": heat.max_stages: no"), "a.yaml:5:3: heat.max_stages: no");
  EXPECT_EQ(text("too much for the support_radius given"),
            "a.yaml:2:9: particles.support: too much for the support_radius given");
  EXPECT_EQ(text("something else"), "a.yaml:1:1: something else");
}

TEST(Memory, SaysWhichScaleFits) {
  EXPECT_STREQ(memory_failure("memory: 4.2 GB needed, 3.1 GB free; use fewer particles", "device 0").what(),
               "memory: 4.2 GB needed, 3.1 GB free on device 0; --scale 0.9 fits");
  EXPECT_EQ(scale_hint(1e9, 2e9), "");
}

}  // namespace
}  // namespace runner
