// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "csv.hpp"
#include "probes.hpp"

namespace runner {
namespace {

/// Two probes of pressure in every sub-step, and a level, which is third in the scene and sampled at every second time.
Scene scene_with_probes() {
  Scene scene;
  for (const char* name : {"a", "h", "b"}) {
    SceneProbe probe;
    probe.desc.name = name;
    probe.desc.fields = {"pressure"};
    scene.probes.push_back(probe);
  }
  scene.probes[1].desc.kind = meltsim::ProbeKind::level;
  return scene;
}

constexpr std::size_t times = 30000;  // enough rows for four threads and more

std::vector<meltsim::ProbeSeries> samples() {
  std::vector<meltsim::ProbeSeries> series(2);
  series[0].points = 2;
  series[1].points = series[0].width = series[1].width = 1;
  for (std::size_t n = 0; n < times; ++n) {
    series[0].time.push_back(static_cast<double>(n) / 1024);
    series[0].values.push_back(static_cast<double>(n));
    series[0].values.push_back(-static_cast<double>(n));
    if (n % 2 == 1) continue;
    series[1].time.push_back(static_cast<double>(n) / 1024);
    series[1].values.push_back(0.5);
  }
  return series;
}

std::string written_by(int threads) {
  std::string name = (std::filesystem::temp_directory_path() / "meltsim-XXXXXX").string();
  const std::filesystem::path directory = mkdtemp(name.data());
  const ProbeTable table(scene_with_probes(), {{0, 2}, {1}}, threads);
  {
    CsvFile file((directory / "probes.csv").string(), "name,time_s,field,value");
    table.write(file, samples());
    file.flush();
  }
  std::ostringstream text;
  text << std::ifstream(directory / "probes.csv").rdbuf();
  std::filesystem::remove_all(directory);
  return text.str();
}

TEST(ProbeTable, RowsAreInOrderOfTimeThenOfTheScene) {
  std::istringstream text(written_by(1));
  std::string line;
  std::getline(text, line);
  for (std::size_t n = 0; n < times; ++n) {
    const std::string time = csv_number(static_cast<double>(n) / 1024);
    const std::string value = csv_number(static_cast<double>(n)), below = csv_number(-static_cast<double>(n));
    std::getline(text, line);
    ASSERT_EQ(line, "a," + time + ",pressure," + value);
    if (n % 2 == 0) {
      std::getline(text, line);
      ASSERT_EQ(line, "h," + time + ",level,0.5");
    }
    std::getline(text, line);
    ASSERT_EQ(line, "b," + time + ",pressure," + below);
  }
  EXPECT_FALSE(std::getline(text, line));
}

TEST(ProbeTable, AnyNumberOfThreadsWritesTheSame) {
  const std::string alone = written_by(1);
  for (const int threads : {2, 3, 4, 7}) EXPECT_TRUE(written_by(threads) == alone) << threads;
}

}  // namespace
}  // namespace runner
