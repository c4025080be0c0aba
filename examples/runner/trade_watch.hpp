// SPDX-License-Identifier: Apache-2.0
// A run whose settings were chosen for an error: the observables over its frames, and what error they tell.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "tuning.hpp"

namespace runner {

/// What was asked for, and what was chosen for it.
struct TradeRequest {
  double max_error = 0;  ///< share of the scale
  std::string of;        ///< the observable
  std::string asked_by;  ///< "--max-error 3%", or the place in the scene
  bool by_option = true;
};

/// Settings for an error. Fails where it cannot be had: says what can, and what that costs.
meltsim::trade::Choice choose_settings(const Tuning& tuning, const meltsim::trade::Study& study,
                                       const TradeRequest& request);

/// What to say where the error of a run turns out larger than was asked for; empty: it does not.
std::string broken_promise_text(const meltsim::trade::Known& known, double error, double asked);

/// "3 min": an estimate has no more digits than it deserves.
std::string about_text(double seconds);

class TradeWatch {
 public:
  TradeWatch(std::shared_ptr<const Tuning> tuning, meltsim::trade::Study study, meltsim::trade::Choice choice,
             TradeRequest request, Built& built);

  bool wants_particles() const { return reader_.wants_particles(); }
  bool wants_probes() const { return reader_.wants_probes(); }
  /// A frame's readings. Its particles and probes follow by rest(), in the order of the frames, where they are wanted.
  void frame(double time, const meltsim::Totals& totals, const std::vector<meltsim::PieceInfo>& pieces);
  void rest(const meltsim::ParticleFrame& particles, const std::vector<meltsim::ProbeSeries>& probes);

  /// One line per observable: what was delivered, in its unit.
  std::vector<std::string> report() const;
  /// broken_promise_text of the observable that was asked for.
  std::string broken_promise() const;
  Json json(bool ended) const;

 private:
  std::string missed(std::size_t k) const;
  struct Open {
    double time;
    meltsim::Totals totals;
    std::vector<meltsim::PieceInfo> pieces;
  };
  /// The values that the study compares, of this run.
  std::vector<double> compared(std::size_t k) const;
  std::vector<meltsim::trade::Difference> delivered() const;

  std::shared_ptr<const Tuning> tuning_;
  meltsim::trade::Study study_;
  meltsim::trade::Choice choice_;
  TradeRequest request_;
  ObservableReader reader_;
  meltsim::trade::Knobs actual_;
  std::deque<Open> open_;
  std::vector<double> times_;
  std::vector<std::vector<double>> rows_;  ///< per frame, values of all observables
};

}  // namespace runner
