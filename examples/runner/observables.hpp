// SPDX-License-Identifier: Apache-2.0
// What users care about in a scene: numbers and curves over time, from the World's readings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "build_world.hpp"
#include "meltsim/trade.hpp"

namespace runner {

enum class ObservableKind {
  /// Share of what could melt at the start: by the latent heat that it took up, which no whole particles blur; by
  /// particles where liquid comes in or leaves, or nothing has latent heat.
  melted,
  melt_time,  ///< when this share is reached [s]
  front,      ///< how far liquid reaches along the longest level axis of the domain [m]; 1 % of it is beyond
  height,     ///< how high [m]; 1 % of the liquid is higher
  draught,    ///< of a body: share below the level times its height, mean of the second half of the run [m]
  path,       ///< of a body: its centre of mass [m]
  pressure,   ///< at a probe, means between samples [Pa]
  temperature,  ///< at a probe [degrees Celsius]
  level,        ///< of a probe of kind level [m]
  energy,       ///< kinetic and potential, less that at the start [J]
  volume        ///< mean compression of the liquid; exactly 0
};

struct SceneObservable {
  ObservableKind kind = ObservableKind::melted;
  std::size_t index = 0;   ///< of the body or the probe
  std::size_t column = 0;  ///< of the probe's value
  meltsim::trade::Observable desc;
  std::vector<ExactPoint> exact{};  ///< empty: none is known
};

/// What is known of a scene's start, from its World. Where there is no liquid yet, emitters say where it will be.
struct SceneStart {
  double floor = 0, top = 0;      ///< of the liquid's room and of the liquid, against gravity [m]
  std::size_t up = 1, along = 0;  ///< axes: against gravity, of the front
  double up_sign = 1, along_sign = 1;
  double along_from = 0, length = 0;  ///< where fronts are measured from; of the domain along that axis [m]
  double liquid_along = 0;            ///< share of that length that the liquid has at the start
  bool liquid = false, gravity = false;
  std::vector<double> body_height, body_size;  ///< [m], per body
  double temperatures = 0;                     ///< highest less lowest [degrees]
  double liquid_density = 0;                   ///< the largest [kg/m^3]
  std::vector<bool> body_melts;
  double latent = 0;  ///< that melts all that can melt [J]; 0: melted is counted by particles
};
SceneStart start_of(const Scene& scene, Built& built);
/// What the bodies of this World are at its start: their sizes, and the latent heat that melts them. At another spacing they are of
/// other particles, so that a ball has another mass.
void describe_bodies(const Scene& scene, Built& built, SceneStart& start);

/// The observable of this name ("melted", "draught@cork", "pressure@far_wall"). Why the scene cannot have it stands in
/// `problem`, which is empty otherwise.
std::optional<SceneObservable> observable_named(const Scene& scene, const SceneStart& start,
                                                const std::string& name, std::string& problem);

/// Names of those that follow from what is in the scene.
std::vector<std::string> default_observables(const Scene& scene, const SceneStart& start);

/// Reads them from what a reading says.
class ObservableReader {
 public:
  /// `spacing`: of the World that is read [m].
  ObservableReader(std::vector<SceneObservable> observables, SceneStart start, std::uint64_t meltable,
                   ProbeGroups probes, double spacing);
  bool wants_particles() const;
  bool wants_probes() const;
  /// Everything that stands in the reading of a frame, in the order of the observables.
  std::vector<double> values(const meltsim::Totals& totals, const std::vector<meltsim::PieceInfo>& pieces,
                             const meltsim::ParticleFrame& particles,
                             const std::vector<meltsim::ProbeSeries>& probes);
  bool all_melted() const { return all_melted_; }

 private:
  void body_values(const SceneObservable& observable, const std::vector<meltsim::PieceInfo>& pieces,
                   std::vector<double>& values) const;
  double probe_value(const SceneObservable& observable,
                     const std::vector<meltsim::ProbeSeries>& probes) const;
  double reach(const meltsim::ParticleFrame& particles, std::size_t axis, double sign) const;

  std::vector<SceneObservable> observables_;
  SceneStart start_;
  std::uint64_t meltable_;
  ProbeGroups probes_;
  double spacing_;
  std::optional<double> first_energy_, first_latent_;
  bool all_melted_ = false;
};

}  // namespace runner
