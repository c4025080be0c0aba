// SPDX-License-Identifier: Apache-2.0
// A scene's probes: the World samples them, probes.csv holds what they say.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "csv.hpp"
#include "meltsim/world.hpp"
#include "scene.hpp"

namespace runner {

/// Probes of a scene that are points of one probe of the World, because they ask for the same at the same times. Numbers
/// count from 0, in the order of the scene; groups are in the order in which the World has them.
using ProbeGroups = std::vector<std::vector<std::size_t>>;

/// bodies: the World's, in the order of the scene. Fails with the place in the scene where the World refuses one. ids: those of
/// the groups go there.
ProbeGroups add_probes(meltsim::World& world, const std::vector<meltsim::BodyId>& bodies, const Scene& scene,
                       std::vector<meltsim::ProbeId>* ids = nullptr);

/// Later samples of the same probes behind earlier ones.
void append(std::vector<meltsim::ProbeSeries>& to, std::vector<meltsim::ProbeSeries> more);

/// The rows of probes.csv: in order of time, then of the scene's probes and their values.
class ProbeTable {
 public:
  /// Many rows are written down by up to `threads` threads, in parts that are joined in order.
  ProbeTable(const Scene& scene, ProbeGroups groups, int threads);
  /// `series` as the World gives them.
  void write(CsvFile& to, const std::vector<meltsim::ProbeSeries>& series) const;

 private:
  struct Probe {
    std::string name;                 ///< and a comma
    std::vector<std::string> values;  ///< per value its name, between commas
  };
  /// The values of one probe of the scene at one time.
  struct Item {
    std::size_t probe;
    const double* values;
  };
  /// A sample of a group, by its number in the group's series.
  struct Sample {
    double time;
    std::size_t group, number;
  };
  using Samples = std::vector<Sample>;

  Samples in_order(const std::vector<meltsim::ProbeSeries>& series) const;
  /// Where parts begin and end that are written down side by side; samples of one time stay together.
  std::vector<Samples::const_iterator> parts_of(const Samples& samples, std::size_t rows) const;
  struct Text {
    std::unique_ptr<char[]> room;
    std::size_t size = 0;
  };
  Text rows(const std::vector<meltsim::ProbeSeries>& series, Samples::const_iterator from,
            Samples::const_iterator end) const;
  /// Rows of one time; the end of what it wrote.
  char* append(char* to, double time, const std::vector<Item>& items) const;

  ProbeGroups groups_;
  int threads_;
  std::vector<Probe> probes_;
  std::size_t longest_ = 0;  ///< row [bytes]
};

}  // namespace runner
