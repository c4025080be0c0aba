# SPDX-License-Identifier: Apache-2.0
"""A fish swims: a mesh that bends in a travelling wave, 60 times a second, pushes water. Its body is held where it is, and thrust is what
the water does to it. Ends in fish.png (needs matplotlib; without it the numbers are all)."""
import numpy as np
from meltsim import Shape, World

LENGTH, RINGS, SIDES = 1.0, 25, 12  # m; of the mesh
FREQUENCY, WAVES, SWAY = 2.0, 1.0, 0.12  # Hz; along the body; of the tail [m]
NOSE = np.array([0.5, 0.4, 0.5])


def fish():
    """A closed mesh: rings of an oval that is thickest at a third of the length and flattens to a fin; z is across."""
    s = np.linspace(0, 1, RINGS)
    thick = 0.085 * np.sqrt(np.clip(s / 0.3, 0, 1)) * np.where(s < 0.3, 1, 1 - 0.4 * (s - 0.3)) + 0.02
    high = 0.14 * np.sqrt(np.clip(s / 0.3, 0, 1)) * np.where(s < 0.3, 1, 1 - 0.9 * (s - 0.3)) + 0.03 + 0.1 * np.clip(s - 0.8, 0, 1) / 0.2
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    rings = np.stack([np.repeat(s * LENGTH, SIDES), (high[:, None] * np.sin(angle)).ravel(), (thick[:, None] * np.cos(angle)).ravel()], 1)
    vertices = np.concatenate([rings, [[0, 0, 0], [LENGTH, 0, 0]]]) + NOSE
    at = lambda ring, side: ring * SIDES + side % SIDES
    triangles = [t for r in range(RINGS - 1) for k in range(SIDES)
                 for t in ((at(r, k), at(r, k + 1), at(r + 1, k)), (at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)))]
    triangles += [(RINGS * SIDES, at(0, k + 1), at(0, k)) for k in range(SIDES)]
    triangles += [(RINGS * SIDES + 1, at(RINGS - 1, k), at(RINGS - 1, k + 1)) for k in range(SIDES)]
    return vertices, np.array(triangles)


def bent(vertices, time):
    """The mesh at a time and how fast its vertices move: the body sways across, more towards the tail, and starts from rest."""
    s = (vertices[:, 0] - NOSE[0]) / LENGTH
    phase, start = 2 * np.pi * (FREQUENCY * time - WAVES * s), min(time, 1.0)
    sway = SWAY * (0.1 + 0.9 * s ** 2)
    place, velocity = vertices.copy(), np.zeros_like(vertices)
    place[:, 2] += start * sway * np.sin(phase)
    velocity[:, 2] = sway * (start * 2 * np.pi * FREQUENCY * np.cos(phase) + (np.sin(phase) if time < 1 else 0))
    return place, velocity


vertices, triangles = fish()
world = World(spacing=0.04, domain=((0, 0, 0), (2, 0.8, 1)), backend="cpu", heat_model="none")
world.add_material("water", viscosity=0.001)
world.add_material("fish", density=1050)
world.add_solid(Shape.mesh(vertices, triangles), "fish", name="fish", motion="kinematic", max_speed=2)
world.add_fluid(Shape.box((0, 0, 0), (2, 0.7, 1)), "water")
world.watch_forces("fish")

thrust, stroke, dt = [], [], 1 / 60
for frame in range(120):
    world.update_mesh("fish", *bent(vertices, world.time + dt))
    world.step(dt)
    impulse = world.take_forces()["fish"]["impulse"]
    thrust.append(-impulse[0] / dt)  # it swims towards -x
    stroke.append(world.time)
print(f"mean thrust of the second second: {np.mean(thrust[60:]):.2f} N")

particles = world.particles()
liquid = np.asarray(particles.liquid_fraction) > 0.5
try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    raise SystemExit("no matplotlib: no picture")
figure, (top, below) = plt.subplots(2, 1, figsize=(8, 6.5), height_ratios=(3, 1), layout="constrained")
layer = np.abs(particles.position[:, 1] - NOSE[1]) < 0.03
seen = liquid & layer
speed = np.linalg.norm(particles.velocity, axis=1)
dots = top.scatter(particles.position[seen, 0], particles.position[seen, 2], c=speed[seen], s=14, cmap="viridis", vmax=0.8)
top.quiver(particles.position[seen, 0], particles.position[seen, 2], particles.velocity[seen, 0], particles.velocity[seen, 2], scale=15,
           width=0.0015)
body = ~liquid & layer
top.scatter(particles.position[body, 0], particles.position[body, 2], c="tab:orange", s=22)
top.set(aspect="equal", xlabel="x [m]", ylabel="z [m]", title=f"Water at half the height of the fish after {world.time:.1f} s")
figure.colorbar(dots, ax=top, label="speed [m/s]", shrink=0.8)
below.plot(stroke, thrust, linewidth=1)
below.set(xlabel="time [s]", ylabel="thrust [N]")
figure.savefig("fish.png", dpi=110)
print("fish.png")
