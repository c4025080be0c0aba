// SPDX-License-Identifier: Apache-2.0
// Exponential, logarithm, power, sine, cosine and arc tangent of the same bits everywhere: the libraries of a CPU and of a GPU
// round the last bit differently.
//
// Sources: the Taylor series of each, Muller (2016), Elementary Functions, chs. 9-11, for the reductions of the argument:
//
//   exp x = 2^k exp r,  r = x - k ln 2,  |r| <= ln 2/2;  sum r^n/n! up to n = 14
//   ln x  = e ln 2 + 2 (s + s^3/3 + ... + s^21/21),  x = m 2^e,  s = (m - 1)/(m + 1),  m from 1/sqrt 2 to sqrt 2
//   sin x, cos x from r = x - k pi/2, |r| <= pi/4; up to r^17
//   atan t = t - t^3/3 + ... + t^25/25, t = tan of an eighth of the angle, <= 0.2
//
// ln 2 and pi/2 are subtracted in parts whose products with k are exact. Errors: a few units of the last place; of a power
// y ln x times that; of sine and cosine 1e-16 x.
#pragma once

#include <cmath>

#include "meltsim/physics/hd.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

inline constexpr double ln2_high = 6.93147180369123816490e-01;     ///< ln 2, 33 bits
inline constexpr double ln2_low = 1.90821492927058770002e-10;      ///< the rest of it
inline constexpr double quarter_high = 1.57079632673412561417;     ///< pi/2, 33 bits
inline constexpr double quarter_mid = 6.07710050630396597660e-11;  ///< the next 33
inline constexpr double quarter_low = 2.02226624879595063154e-21;  ///< the rest of it

/// exp x [-].
MELTSIM_HD double exponential(double x) {
  if (!(x < 710.0)) return x > 0 ? HUGE_VAL : x;
  if (x < -745.2) return 0.0;
  const double k = std::floor(x / (ln2_high + ln2_low) + 0.5);
  const double r = (x - k * ln2_high) - k * ln2_low;
  double sum = 1.0;
  for (int n = 14; n > 0; --n) sum = 1.0 + sum * r / n;
  return std::ldexp(sum, static_cast<int>(k));
}

/// ln x [-]; NaN below 0, minus infinity at 0.
MELTSIM_HD double logarithm(double x) {
  if (!(x > 0)) return x == 0 ? -HUGE_VAL : (x - x) / (x - x);
  if (x == HUGE_VAL) return x;
  int e = 0;
  double m = std::frexp(x, &e);
  if (m < 0.70710678118654752) m *= 2, --e;
  const double s = (m - 1.0) / (m + 1.0), s2 = s * s;
  double sum = 0.0;
  for (int n = 21; n > 0; n -= 2) sum = sum * s2 + 1.0 / n;
  return e * ln2_high + (2.0 * s * sum + e * ln2_low);
}

/// x^y [-], x > 0.
MELTSIM_HD double power(double x, double y) { return exponential(y * logarithm(x)); }

/// Sine and cosine of one angle.
struct SineCosine {
  double sine{}, cosine{};  ///< [-]
};

/// Sine and cosine of an angle [rad].
MELTSIM_HD SineCosine sine_cosine(double angle) {
  const double k = std::floor(angle / (quarter_high + quarter_mid) + 0.5);
  const double r = ((angle - k * quarter_high) - k * quarter_mid) - k * quarter_low, r2 = r * r;
  double s = 1.0, c = 1.0;
  for (int n = 16; n > 0; n -= 2) {
    s = 1.0 - s * r2 / (n * (n + 1));
    c = 1.0 - c * r2 / (n * (n - 1));
  }
  s *= r;
  const double turn = k - 4.0 * std::floor(k / 4.0);  // 0 to 3
  if (turn == 0.0) return {s, c};
  if (turn == 1.0) return {c, -s};
  if (turn == 2.0) return {-s, -c};
  return {-c, s};
}

/// Angle of a sine and a cosine >= 0, of a point at any distance from the origin [rad]: 8 atan of the tangent of an eighth.
MELTSIM_HD double angle_of(const SineCosine& p) {
  double t = p.sine / (p.cosine + std::sqrt(p.sine * p.sine + p.cosine * p.cosine));
  for (int half = 0; half < 2; ++half) t /= 1.0 + std::sqrt(1.0 + t * t);
  const double t2 = t * t;
  double sum = 0.0;
  for (int n = 25; n > 0; n -= 2) sum = 1.0 / n - sum * t2;
  return 8.0 * t * sum;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
