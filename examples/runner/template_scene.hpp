// SPDX-License-Identifier: Apache-2.0
// What `meltsim new` writes. It must run as it is: a test does.
#pragma once

#include <string>

namespace runner {

inline const std::string template_scene =
    R"YAML(# A meltsim scene. Temperatures are in degrees Celsius, everything else in SI units.
# Look before you run: meltsim check THIS_FILE
meltsim: 1                       # version of the scene format
title: "My scene"

domain:
  min: [0, 0, 0]                 # m
  max: [2, 2, 2]
  walls: box                     # box | open | none | {x: periodic, +y: open, ...}

particles:
  spacing: 0.1                   # m; halving it makes 8 times as many particles
  support: auto                  # m; auto = 2.5 spacings

time:
  dt: auto                       # s; steps that are too long are split by themselves
  stepping: fixed                # fixed | adaptive
  end: 4                         # s; `meltsim check` says how much has melted by then
  fps: 25                        # frames per simulated second
  end_when: time                 # time | melted (then `end` is the cap)

solver:
  gravity: [0, -9.81, 0]         # m/s^2, y is up
  sound_speed: auto              # m/s; auto = ten times the fastest motion that gravity can cause

# A ball of ice of 0.64 m would melt for days: heat runs faster than motion, as in a time lapse.
heat:
  model: enthalpy                # none | paper | enthalpy
  time_scale: 2.0e+5             # <- change this first: 10 times less melts 10 times as slowly, 1 is real time

materials:
  water:
    density: 1000                # kg/m^3
    viscosity: 0.2               # Pa s; real water (0.001) needs far finer particles
    conductivity: 0.6            # W/(m K)
    heat_capacity: 4186          # J/(kg K)
  ice:
    density: 917
    conductivity: 2.2
    heat_capacity: 2100
    melting_point: 0             # degrees Celsius
    latent_heat: 3.34e5          # J/kg; less melts faster
    becomes: water
    region_half_width: 2         # 0..8; larger is stiffer

fluids:
  - shape: {box: [[0, 0, 0], [2, 0.8, 2]]}
    material: water
    temperature: 40              # <- warmer water melts the ice faster

bodies:
  - name: block
    shape: {sphere: {center: [1, 1.2, 1], radius: 0.32}}
    material: ice
    temperature: -10

probes:
  - name: middle
    at: [1, 0.4, 1]
    fields: [temperature, pressure]
    every: 0.1                   # s

output:
  export: [ply]                  # ply | vtp | surface | obj | glb | usd | pov | png; index.html and still.png are always written
  picture: {look: natural}       # natural | temperature
)YAML";

}  // namespace runner
