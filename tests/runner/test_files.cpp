// SPDX-License-Identifier: Apache-2.0
// What is written and read back: checkpoints, tables, particle files, library errors.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <random>

#include "checkpoint.hpp"
#include "csv.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "library_error.hpp"
#include "memory.hpp"
#include "particle_files.hpp"
#include "rehearsal.hpp"
#include "run_directory.hpp"
#include "show/ply_reader.hpp"
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

/// A file whose sum is right and whose header is this.
std::string with_header(const std::string& header) {
  const Directory directory;
  const std::string path = directory.file("checkpoint.bin");
  write_checkpoint(path, example());
  const std::string good = read_file(path);
  const auto size_of = [&](std::size_t at) {
    return static_cast<std::size_t>(static_cast<unsigned char>(good[at])) +
           256u * static_cast<unsigned char>(good[at + 1]);
  };
  const std::size_t rest = 16 + size_of(8);
  std::string data = good.substr(0, 8), length(8, '\0');
  length[0] = static_cast<char>(header.size() & 255u);
  length[1] = static_cast<char>(header.size() >> 8);
  data += length + header + good.substr(rest, good.size() - rest - 8);
  std::uint64_t hash = 14695981039346656037ull;
  for (const char c : data) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  for (int shift = 0; shift < 64; shift += 8) data += static_cast<char>(hash >> shift & 255u);
  return data;
}

TEST(Checkpoint, AHeaderThatIsNoneIsRefusedAsTheWholeFileIs) {
  const Directory directory;
  const std::string path = directory.file("checkpoint.bin");
  const std::string numbers =
      R"("steps":1,"next_frame":1,"frame_dt":0,"limits":[],"part":{"dt":0,"steps":0},"rest":{"dt":0,"steps":0,"end":0,"speed":0},"meltable":0,"wall_s":0)";
  write_file(path, with_header(R"({"time":0,)" + numbers + R"(,"scene":{"time":{"fps":25}}})"));
  EXPECT_NO_THROW(read_checkpoint(path));
  for (const std::string& header :
       {R"({"time":0,)" + numbers + R"(,"scene":5})", R"({"time":0,)" + numbers + R"(,"scene":{"time":5}})",
        R"({"time":0,)" + numbers + R"(,"scene":{"time":{"fps":"x"}}})",
        R"({"time":-1,)" + numbers + R"(,"scene":{}})", R"({"time":1e999,)" + numbers + R"(,"scene":{}})",
        R"({"time":null,)" + numbers + R"(,"scene":{}})", std::string("[1]"), std::string("null"),
        std::string("{")}) {
    write_file(path, with_header(header));
    try {
      read_checkpoint(path);
      ADD_FAILURE() << "taken: " << header;
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.code(), ExitCode::io) << header;
      EXPECT_NE(std::string(failure.what()).find("not a whole checkpoint"), std::string::npos) << header;
    }
  }
}

TEST(RunDirectory, OneProcessAtATime) {
  const Directory directory;
  const std::string path = directory.file("");
  auto first = std::make_unique<DirectoryLock>(path, "another run");
  try {
    const DirectoryLock second(path, "another run");
    ADD_FAILURE() << "both have the lock";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.code(), ExitCode::io);
    EXPECT_NE(std::string(failure.what()).find(": another run is writing there (process "), std::string::npos)
        << failure.what();
  }
  first.reset();
  EXPECT_NO_THROW(DirectoryLock(path, "another run")) << "the file is still there, the lock is not";
}

TEST(RunDirectory, ALockThatIsALinkIsNotOpened) {
  const Directory directory;
  write_file(directory.file("precious"), "precious");
  std::filesystem::create_symlink(directory.file("precious"), directory.file(".lock"));
  EXPECT_THROW(DirectoryLock(directory.file(""), "another run"), Failure);
  EXPECT_EQ(read_file(directory.file("precious")), "precious");
}

TEST(Rehearsal, GoesOnAsTheCurveDid) {
  Rehearsal seen;
  seen.until = 4;
  for (int i = 0; i <= 40; ++i)
    seen.melting.push_back({0.1 * i, 0.025 * i * 0.1, 0.025 * i * 0.1});  // in proportion to time
  EXPECT_NEAR(seen.melted_at(2), 0.05, 1e-12);
  EXPECT_NEAR(seen.melted_at(8), 0.2, 1e-9);
  EXPECT_NEAR(seen.time_of(1), 40, 1e-6);
  EXPECT_EQ(seen.melted_at(1000), 1);
  for (Rehearsal::Sample& sample : seen.melting)
    sample.melted = sample.taken = 0.05 * std::sqrt(sample.time);  // heat that soaks in
  EXPECT_NEAR(seen.melted_at(16), 0.2, 1e-3);
  for (Rehearsal::Sample& sample : seen.melting) sample.melted = sample.taken = 0;
  EXPECT_EQ(seen.melted_at(1e6), 0);
  EXPECT_EQ(seen.time_of(1), meltsim::infinity);
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

TEST(Csv, ResumingDropsRowsThatAreNotWhole) {
  const Directory directory;
  const std::string path = directory.file("t.csv");
  write_file(path, "name,time_s,value\na,0,1\nb,0.1\nc,0.2,3,4\nd,0.3,5\ne,nan,6\nf");
  std::vector<std::string> kept;
  CsvFile csv = CsvFile::resume(path, "name,time_s,value", 1, 1, &kept);
  EXPECT_EQ(kept, (std::vector<std::string>{"a,0,1", "d,0.3,5"}));
  EXPECT_EQ(read_file(path), "name,time_s,value\na,0,1\nd,0.3,5\n");
}

// Against the C library: random bits, decimals that end, halves of the last digit, both ends of both notations.
TEST(Csv, NumbersAreThoseOfPrintf) {
  const auto expected = [](double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", value);
    return std::string(text);
  };
  std::vector<double> values{0.0,
                             -0.0,
                             1,
                             -1,
                             9.5,
                             0.1,
                             1e-4,
                             9.9999e-5,
                             123456789,
                             999999999.4,
                             999999999.5,
                             999999999.6,
                             1e9,
                             0.00012345678949,
                             12345678.25,
                             1.5e300,
                             5e-324,
                             1e22,
                             1e23,
                             1e-14,
                             1e-13,
                             1e31,
                             std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()};
  std::mt19937_64 random(7);
  for (int k = 0; k < 200000; ++k) {
    const std::uint64_t bits = random();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isnan(value)) values.push_back(value);
    const double mantissa = static_cast<double>(random() % 10000000000u) / 2;  // a half every other time
    values.push_back(mantissa * std::pow(10.0, static_cast<int>(random() % 40) - 25));
    values.push_back(static_cast<double>(static_cast<float>(mantissa)) * 1e-7);
    values.push_back(static_cast<double>(random() % 1000000u) / 1000);
  }
  for (const double value : values) ASSERT_EQ(csv_number(value), expected(value));
  EXPECT_EQ(csv_number(std::numeric_limits<double>::quiet_NaN()), "nan");
}

// What takes the name of a table while it grows does not get its rows.
TEST(Csv, ATableGoesOnInTheFileThatItMade) {
  const Directory directory;
  const std::string path = directory.file("t.csv"), other = directory.file("other.txt");
  write_file(other, "mine\n");
  CsvFile csv(path, "a");
  csv.row("1");
  csv.flush();
  EXPECT_EQ(read_file(path), "a\n1\n");
  std::filesystem::remove(path);
  std::filesystem::create_symlink(other, path);
  csv.row("2");
  csv.flush();
  EXPECT_EQ(read_file(other), "mine\n");
  EXPECT_FALSE(exists(path + ".tmp"));
}

TEST(Tables, ARowHasAValueForEveryColumn) {
  StatsRow row;
  row.totals.fluid = 12;
  EXPECT_EQ(split_commas(stats_line(row)).size(), split_commas(stats_header()).size());
  EXPECT_EQ(stats_json(row).at("n_fluid"), 12);
  EXPECT_EQ(split_commas(bodies_line({}, 0)).size(), split_commas(bodies_header()).size());
}

TEST(Tables, TheManualNamesEveryColumn) {
  std::string manual = read_file(SCENES_DIRECTORY "/../../docs/runner.md");
  manual.erase(std::remove_if(manual.begin(), manual.end(), [](char c) { return c == '\n' || c == ' '; }),
               manual.end());
  EXPECT_NE(manual.find("`" + stats_header() + "`"), std::string::npos) << stats_header();
  EXPECT_NE(manual.find("`" + bodies_header() + "`"), std::string::npos) << bodies_header();
}

TEST(ParticleFiles, AnEmptyFrameHoldsAPlaceholder) {
  const std::vector<FrameParticle> particles = frame_particles({});
  ASSERT_EQ(particles.size(), 1u);
  EXPECT_EQ(particles[0].phase, 255);
  EXPECT_NE(ply_text(particles, 0).find("element vertex 1\n"), std::string::npos);
}

// More rows than a part of a file (8,192) or of an array (512) holds, and no multiple of either; far from the origin, of two
// phases, bodies and materials, so that every column has values of its own.
TEST(ParticleFiles, FilesOfAFrameAreTheTextsOfItsParticles) {
  const Directory directory;
  meltsim::ParticleFrame frame;
  frame.origin = {1e3, -0.0, -7};
  for (std::uint32_t i = 0; i < 9001; ++i) {
    const float x = static_cast<float>(i);
    frame.id.push_back(3 * i);
    frame.position.push_back({0.1f * x, -0.0f, -x});
    frame.velocity.push_back({x + 1, x + 2, x + 3});
    frame.temperature.push_back(x / 7);
    frame.liquid_fraction.push_back(x / 9001);
    frame.tag.push_back(i % 3 == 0 ? meltsim::tag_solid | (1 + i % 5) << meltsim::tag_body_shift | 1u : 2u);
  }
  meltsim::ParticleFrame mixed = frame;
  mixed.species = {{1, 1}, {4, 1}};
  mixed.fractions.resize(2);
  for (std::uint32_t i = 0; i < 9001; ++i)
    for (std::size_t k = 0; k < 2; ++k)
      mixed.fractions[k].push_back(static_cast<float>(i) / (9001 * static_cast<float>(k + 1)));
  const std::vector<std::string> columns = content_columns(mixed, {"water", "sea salt"});
  EXPECT_EQ(columns, (std::vector<std::string>{"w_sea_salt", "w_species"}));
  EXPECT_TRUE(content_columns(frame, {"water"}).empty());
  for (const auto& shown : {frame, mixed, meltsim::ParticleFrame{}}) {
    const auto contents = content_columns(shown, {"water", "sea salt"});
    write_ply(directory.file("a.ply"), shown, 0.5, contents);
    write_vtp(directory.file("a.vtp"), shown, 0.5, contents);
    EXPECT_TRUE(read_file(directory.file("a.ply")) == ply_text(frame_particles(shown), 0.5, contents));
    EXPECT_TRUE(read_file(directory.file("a.vtp")) == vtp_text(frame_particles(shown), 0.5, contents));
    double time = 0;
    const auto back = read_particles_ply(directory.file("a.ply"), time);
    ASSERT_EQ(back.size(), std::max<std::size_t>(1, shown.id.size()));
    for (std::size_t k = 0; k < shown.fractions.size(); ++k)
      for (std::size_t i = 0; i < back.size(); ++i) EXPECT_EQ(back[i].contents[k], shown.fractions[k][i]);
  }
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
