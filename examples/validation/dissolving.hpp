// SPDX-License-Identifier: Apache-2.0
// References for bodies that dissolve in a liquid at rest, as if mixing moved nothing but what mixes: volumes add up, so that no volume flows, and
// the share phi of the volume obeys d phi/dt = D laplacian phi whatever the densities are (Bird, Stewart & Lightfoot, Transport
// Phenomena, 2nd ed. (2002), 17.7 and table 17.8-2: one D for all frames). A front at phi_s gives off what is 1 beyond it:
// (1 - phi_s) ds/dt = D dphi/dr.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "constants.hpp"
#include "meltsim/meltsim.hpp"

namespace validation {

/// B = phi_s/(1 - phi_s) of a saturated solution of mass fraction w_s; densities of solvent over species.
inline double dissolving_number(double solubility, double density_ratio = 1) {
  return solubility / (1 - solubility) * density_ratio;
}

/// lambda of the front 2 lambda sqrt(D t) of a slab: sqrt(pi) lambda exp(lambda^2) erfc(-lambda) = B.
inline double dissolving_slab(double b) {
  double low = 0, high = 3;
  for (int k = 0; k < 100; ++k) {
    const double l = 0.5 * (low + high);
    (std::sqrt(pi) * l * std::exp(l * l) * std::erfc(-l) < b ? low : high) = l;
  }
  return 0.5 * (low + high);
}

/// As dissolving_ball(), of first order: finite volumes between the front and `reach` R, narrow at the front and moving with it, in equal
/// steps of sqrt(t), from the slab's solution on.
inline double dissolving_ball_of(double b, double share, double reach, int cells) {
  const double saturation = b / (1 + b), lambda = dissolving_slab(b), ends = std::cbrt(share);
  const auto n = static_cast<std::size_t>(cells);
  double root = 0.002, front = 1 - 2 * lambda * root;
  std::vector<double> edge(n + 1), phi(n), lower(n), diagonal(n), upper(n), next(n + 1);
  const auto place = [&](double s, std::vector<double>& r) {
    for (std::size_t k = 0; k <= n; ++k)
      r[k] = s + (reach - s) * std::pow(static_cast<double>(k) / static_cast<double>(n), 3);
  };
  const auto volume = [](const std::vector<double>& r, std::size_t k) {
    return (r[k + 1] * r[k + 1] * r[k + 1] - r[k] * r[k] * r[k]) / 3;
  };
  place(front, edge);
  for (std::size_t k = 0; k < n; ++k)
    phi[k] = saturation * std::erfc((0.5 * (edge[k] + edge[k + 1]) - 1) / (2 * root)) / std::erfc(-lambda);
  const double step = 1.0 / (10 * cells);
  while (root < 10) {
    const double later = root + step, dt = later * later - root * root,
                 slope = (phi[0] - saturation) / (0.5 * (edge[1] - edge[0]));
    const double s = front + slope / (1 - saturation) * dt;
    if (s <= ends) return root * root + dt * (front - ends) / (front - s);
    place(s, next);
    // What an edge sweeps is taken from the cell that it moves into; the front's own is part of the flux there, saturated.
    const auto between = [&](std::size_t k) {  // of cells k - 1 and k
      return k == 0 ? 0.5 * (next[1] - next[0]) : 0.5 * (next[k + 1] - next[k - 1]);
    };
    for (std::size_t k = 0; k < n; ++k) {
      lower[k] = upper[k] = 0;
      diagonal[k] = volume(next, k);
      phi[k] *= volume(edge, k);
      const double left = next[k] * next[k] / between(k) * dt,
                   swept = (edge[k] * edge[k] * edge[k] - next[k] * next[k] * next[k]) / 3;
      diagonal[k] += left;
      if (k == 0) phi[k] += (left + swept) * saturation;
      else {
        lower[k] -= left + 0.5 * swept;
        diagonal[k] -= 0.5 * swept;
      }
      if (k + 1 == n) continue;
      const double right = next[k + 1] * next[k + 1] / between(k + 1) * dt,
                   gone =
                       (edge[k + 1] * edge[k + 1] * edge[k + 1] - next[k + 1] * next[k + 1] * next[k + 1]) /
                       3;
      diagonal[k] += right + 0.5 * gone;
      upper[k] -= right - 0.5 * gone;
    }
    for (std::size_t k = 1; k < n; ++k) {
      const double f = lower[k] / diagonal[k - 1];
      diagonal[k] -= f * upper[k - 1];
      phi[k] -= f * phi[k - 1];
    }
    for (std::size_t k = n; k-- > 0;) {
      if (k + 1 < n) phi[k] -= upper[k] * phi[k + 1];
      phi[k] /= diagonal[k];
    }
    std::swap(edge, next);
    front = s;
    root = later;
  }
  return root * root;
}

/// D t/R^2 at which `share` of the volume of a ball of radius R is left, in liquid up to `reach` R; extrapolated, within 2e-4.
inline double dissolving_ball(double b, double share, double reach) {
  return 2 * dissolving_ball_of(b, share, reach, 400) - dissolving_ball_of(b, share, reach, 200);
}

/// Mass of bodies that is not dissolved [kg]: the rest of them is saturated solution.
inline double undissolved(const meltsim::ParticleData& p, double solubility) {
  double sum = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (meltsim::is_solid(p.tag[i]))
      sum += std::max(0.0, p.fractions[0][i] - solubility) / (1 - solubility) * p.mass[i];
  return sum;
}

}  // namespace validation
