// SPDX-License-Identifier: Apache-2.0
// Density, forces and reaction, the strain rate, implicit viscosity, surface tension and wetting, shifting, contact, exchange of
// heat in three models and of what is dissolved or precipitates, impulses on watched bodies: what every particle gets from its neighbours, by every strategy, against one sum over all pairs in double (pair_sums.hpp), by what a particle is beside.
//
// Tolerance, in units in the last place of the sum of the sizes of all terms: a term is the outcome of some 30 roundings;
// x_i - x_j loses the digits by which a domain of 2 m is larger than a distance (10 units), kernels take them to the third and
// fourth power. So 100 for the worst. Roundings of many terms cancel each other: half of a
// class is below a fifth of that, nine of ten are below half.
#include <cstdio>
#include <cstdlib>

#include "modules/pairs.hpp"

namespace {

using namespace modules_test;

template <class T>
class Pairs : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Pairs, Scalars);

double quantile(std::vector<double> v, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * double(v.size() - 1));
  std::nth_element(v.begin(), v.begin() + at, v.end());
  return v[static_cast<std::size_t>(at)];
}

TYPED_TEST(Pairs, EqualOneSumOverAllPairs) {
  using T = TypeParam;
  const std::string none = no_pair_engines();
  if (!none.empty()) GTEST_SKIP() << none;
  const bool print = std::getenv("MELTSIM_PRINT_ERRORS") != nullptr;
  for (const PairEngine& how : pair_engines()) {
    std::size_t seen[quantities][beside_count] = {};
    for (const NamedScene& s : pair_scenes(how.support, how.length)) {
      Errors<T> errors;
      errors.note(AllPairs<T>(s.scene).sums(), sums_of<T>(how, s.scene));
      if (this->HasFatalFailure()) return;
      for (int q = 0; q < quantities; ++q)
        for (int b = 0; b < beside_count; ++b) {
          const std::vector<double>& e = errors.of[q][b];
          if (e.empty()) continue;
          seen[q][b] += e.size();
          const std::string what =
              how.name + ", " + s.name + ": " + quantity_names[q] + " beside " + beside_names[b];
          if (print)
            std::printf("%-70s %5zu: half %.2g, nine tenths %.2g, all %.2g\n", what.c_str(), e.size(),
                        quantile(e, 0.5), quantile(e, 0.9), quantile(e, 1));
          EXPECT_LE(quantile(e, 0.5), 20) << what;
          EXPECT_LE(quantile(e, 0.9), 50) << what;
          EXPECT_LE(quantile(e, 1), 100) << what;
        }
    }
    std::size_t watched = 0;
    for (const std::size_t n : seen[of_watched]) watched += n;
    EXPECT_GE(watched, 36u) << how.name;  // three bodies in two scenes
    for (int q = 0; q < quantities; ++q)
      for (int b = 0; b < beside_count; ++b) {
        const std::uint32_t beside = 1u << b;
        if (q == of_density && beside == beside_other_body) continue;  // that is liquid's, this solid's
        if (q == of_shift &&
            (beside & (beside_other_phase | beside_other_liquid | beside_crowd | beside_other_body)) != 0u)
          continue;                                              // one liquid alone
        if (q == of_paper && beside == beside_period) continue;  // pair_sums.hpp
        if (q == of_watched) continue;                           // of whole bodies; below
        if (q == of_solute && (beside & (beside_crowd | beside_other_body)) != 0u) continue;  // of one body
        EXPECT_GT(seen[q][b], 1u) << how.name << ": " << quantity_names[q] << " beside " << beside_names[b];
      }
  }
}

}  // namespace
