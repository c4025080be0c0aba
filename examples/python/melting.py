# SPDX-License-Identifier: Apache-2.0
"""A block of ice melts in warm water. Ends in melting.html, a page that plays the run in a browser."""
from meltsim import Shape, World

world = World(spacing=0.05, domain=((0, 0, 0), (1, 1, 1)), heat_time_scale=5e4)  # a time lapse: melting takes hours
world.add_material("water", viscosity=0.2)
world.add_material("ice", density=917, conductivity=2.2, heat_capacity=2100, melting_point=0, latent_heat=3.34e5, becomes="water")
world.add_fluid(Shape.box((0, 0, 0), (1, 0.3, 1)), "water", temperature=60)
world.add_solid(Shape.box((0.35, 0.35, 0.35), (0.65, 0.65, 0.65)), "ice", temperature=-5)
print(world.run(1.0))
print(world.show("melting.html"))
