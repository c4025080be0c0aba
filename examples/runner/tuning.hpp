// SPDX-License-Identifier: Apache-2.0
// A scene as a problem of speed against accuracy: probes of it, what they say, and the scene with other settings.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "observables.hpp"

namespace runner {

struct TuneOptions {
  double seconds = 60;  ///< for all probes
  bool cache = true;
  bool support = false;  ///< also compares another support
  /// After each probe: how many are done, and planned.
  std::function<void(int, int)> progress{};
};

class Tuning {
 public:
  /// `names`: observables; empty: the scene's, else those that follow from it. `of`: option that gave them, in messages.
  Tuning(const Scene& scene, const MachineOptions& machine, std::vector<std::string> names,
         const std::string& of);

  /// Another observable behind those, where it is none of them; before study().
  void observe_too(const std::string& name);
  /// Probes the scene, or takes what they came to from the cache.
  const meltsim::trade::Study& study(const TuneOptions& options);
  bool from_cache() const { return from_cache_; }

  const std::vector<SceneObservable>& observables() const { return observables_; }
  const meltsim::trade::Known& known(std::size_t k = 0) const { return study_.observables.at(k); }
  /// The scene with settings that are multiples of its own.
  Scene with(const meltsim::trade::Knobs& knobs) const;
  meltsim::trade::Measurement measure(const meltsim::trade::Knobs& knobs, double wall_limit);
  /// "spacing 0.17 m (x 0.85), sound speed 24 m/s (x 0.4), courant 0.6"
  std::string settings_text(const meltsim::trade::Knobs& knobs) const;
  Json settings_json(const meltsim::trade::Knobs& knobs) const;
  /// What a run of this scene has as multiples of the scene that was probed.
  meltsim::trade::Knobs actual(meltsim::World& world, const meltsim::trade::Knobs& asked) const;
  ObservableReader reader(Built& built) const;
  /// [s] of the samples that are compared.
  std::vector<double> sample_times() const;
  const meltsim::trade::Problem& problem() const { return problem_; }
  const std::string& device() const { return device_; }

 private:
  void choose_observables(std::vector<std::string> names, const std::string& of);
  void choose_ranges(Built& built);
  void make_problem();
  void measure_bodies();
  /// [s] that the values of a probe belong to which a sample holds: the mean of what it read since the sample before.
  std::vector<double> probe_times(std::size_t probe) const;
  double spacing_for(double multiple) const;
  std::string cache_file(const TuneOptions& options) const;

  struct Current;
  Scene scene_;
  MachineOptions machine_;
  SceneStart start_;
  std::vector<SceneObservable> observables_;
  std::shared_ptr<Current> current_;
  meltsim::trade::Problem problem_;
  meltsim::trade::Study study_;
  double spacing_ = 0, sound_speed_ = 0, courant_ = 0,
         support_ = 0;      ///< of the scene itself; support over spacing
  double step_ = 0;         ///< [s] longest step that a knob changes; 0: none
  bool heat_only_ = false;  ///< nothing moves
  bool from_cache_ = false;
  struct Body {
    const meltsim::Shape* shape;  ///< of scene_
    double volume;                ///< [m^3]
    bool liquid;
  };
  std::vector<Body> bodies_;                     ///< or liquid, whose size the spacing is fitted to
  mutable std::map<double, double> spacings_{};  ///< fitted, by multiple
  std::string device_, resolved_;
};

/// Of a time to reach something: what to say where a run at the scene's settings does not come so far. Empty: it does.
std::string not_reached(const meltsim::trade::Study& study, std::size_t observable, double end);
/// "0.012 m", "1.2 %" of a share: the unit where there is one.
std::string error_text(const meltsim::trade::Known& known, double error);

Json study_json(const meltsim::trade::Study& study);
/// The observables are those of the problem; fails where the text is not one of a study of them.
meltsim::trade::Study study_from_json(const Json& json, const meltsim::trade::Problem& problem);

}  // namespace runner
