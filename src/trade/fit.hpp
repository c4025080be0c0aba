// SPDX-License-Identifier: Apache-2.0
// Laws from twins: how error and cost change with one knob.
#pragma once

#include <vector>

#include "meltsim/trade.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

/// Error exponent of a knob by theory, and the range within which a measured one is accepted.
struct Nominal {
  double exponent, least, most;
};
Nominal nominal(Knob knob);

/// Runs that differ in one knob only, complete ones.
struct Twin {
  double x;  ///< the knob's multiple, as built
  double work;
  const std::vector<double>* values;
};

/// The law of a knob from two or more twins, in any order. Differences of `noise` or less count as none. Fewer than two
/// distinct ones: a law without error.
Law fit(Knob knob, const Observable& observable, double scale, std::vector<Twin> twins, double noise);

/// The law of the spacing where the exact answer is known: `others` is the error that the other knobs make.
Law fit_exact(const Observable& observable, double scale, const Law& relative, std::vector<Twin> twins,
              double others);

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
