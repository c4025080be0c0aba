#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""regional_steps.py: whether a region of one liquid may take longer steps than the rest.

A column of weakly compressible liquid in one dimension (SPH, density by summation, linear equation of state, no viscosity; the
kernel of meltsim, H = 2.5 dx), periodic, at rest but for a sound wave of 1e-4 c. Half of it takes steps of dt, the other half
steps of 2 dt or 4 dt, in three ways:

  one     all of it takes the step of the slow half
  frozen  between its steps the slow half keeps its forces, and the fast half sees it move at constant velocity
  kicks   pairs that cross the border, or lie in the slow half, kick both ends together, every 2 or 4 dt (momentum exact)

Prints, for c times the step of the slow half over H, how energy has grown after 2000 of its steps, and how momentum has
changed. A region saves something only if it may take a step that the whole may not.
"""
import numpy as np

n, dx, c, rho = 80, 1.0, 1.0, 1.0
support = 2.5 * dx
length = n * dx


def gradient(r):
    """dW/dr / r of (1-q)^4 (1+4q), so that sums over the lattice give a unit gradient."""
    a = np.clip(1 - np.abs(r) / support, 0, None)
    return -(a**3)


lattice = np.arange(-2, 3) * dx
scale = 1 / np.sum(-gradient(lattice) * lattice**2 * dx)


def value(r):
    a = np.clip(1 - np.abs(r) / support, 0, None)
    return a**4 * (5 - 4 * a)


shape = 1 / np.sum(value(lattice) * dx)


def pairs(x):
    d = x[:, None] - x[None, :]
    return d - length * np.round(d / length)


def forces(x, mask=None):
    """Accelerations; mask: pairs that act."""
    d = pairs(x)
    density = shape * dx * np.sum(value(d), axis=1)
    pressure = rho * c * c * (density - 1)
    term = pressure / density**2
    f = -(term[:, None] + term[None, :]) * gradient(d) * scale * d * dx / rho
    if mask is not None:
        f = f * mask
    return f.sum(axis=1), density


def energy(x, v):
    density = forces(x)[1]
    return 0.5 * np.sum(v**2) * dx + 0.5 * c * c * np.sum((density - 1) ** 2) * dx


def run(way, ratio, number, steps=2000):
    slow_dt = number * support / c
    dt = slow_dt / ratio
    i = np.arange(n)
    x = i * dx
    v = 1e-4 * c * np.sin(2 * np.pi * i / n) + 1e-5 * c * (-1.0) ** i  # the longest and the shortest wave
    slow = i >= n // 2
    e0, p0 = energy(x, v), v.sum()
    fast_pairs = ~(slow[:, None] | slow[None, :])
    for _ in range(steps):
        if way == "one":
            x = x + 0.5 * slow_dt * v
            v = v + slow_dt * forces(x)[0]
            x = x + 0.5 * slow_dt * v
        elif way == "frozen":
            at = x + 0.5 * slow_dt * v
            kick = forces(at)[0]  # of the slow half, at the middle of its step
            y, u = x.copy(), v.copy()
            for _ in range(ratio):
                y = y + 0.5 * dt * u
                u = np.where(slow, u, u + dt * forces(y)[0])
                y = y + 0.5 * dt * u
            u_slow = v + slow_dt * kick
            x = np.where(slow, x + 0.5 * slow_dt * (v + u_slow), y)
            v = np.where(slow, u_slow, u)
        else:
            kick = 0.5 * slow_dt * forces(x, ~fast_pairs)[0]
            v = v + kick
            for _ in range(ratio):
                x = x + 0.5 * dt * v
                v = v + dt * forces(x, fast_pairs)[0]
                x = x + 0.5 * dt * v
            v = v + 0.5 * slow_dt * forces(x, ~fast_pairs)[0]
        if not np.isfinite(v).all() or np.abs(v).max() > 100 * c:
            return np.inf, np.inf
    return energy(x, v) / e0, abs(v.sum() - p0) / (1e-4 * c * n)


if __name__ == "__main__":
    print("| c dt_slow/H | all | frozen, 2 | frozen, 4 | kicks, 2 | kicks, 4 |")
    print("|---|---|---|---|---|---|")
    ways = [("one", 1), ("frozen", 2), ("frozen", 4), ("kicks", 2), ("kicks", 4)]
    for number in (0.2, 0.4, 0.6, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4):
        cells = []
        for way, ratio in ways:
            grown, momentum = run(way, ratio, number)
            cells.append("bursts" if not np.isfinite(grown) or grown > 10 else f"{grown:.3g}, {momentum:.0e}")
        print(f"| {number} | " + " | ".join(cells) + " |")
