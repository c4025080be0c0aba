# SPDX-License-Identifier: Apache-2.0
"""How long a bar takes to warm up, for three conductivities: temperatures along it against the exact series. Needs matplotlib.
Ends in conductivity.png."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from meltsim import Shape, World

length, hot, cold, time, density, capacity = 0.4, 80.0, 20.0, 400.0, 2700.0, 900.0
figure, axes = plt.subplots(figsize=(7, 4.5))
for k, color in ((15.0, "tab:blue"), (60.0, "tab:orange"), (240.0, "tab:red")):
    # Heat runs `time` times faster than motion, so a second of motion is all that is computed. The bar touches the
    # walls of the domain, which insulate, but for the left one, held at 80 degrees.
    bar = World(spacing=0.02, domain={"min": (0, 0, 0), "max": (length, 0.12, 0.12), "heat": {"-x": {"temperature": hot}}},
                gravity=(0, 0, 0), heat_time_scale=time, backend="cpu")
    bar.add_material("metal", density=density, conductivity=k, heat_capacity=capacity)
    bar.add_solid(Shape.box((0, 0, 0), (length, 0.12, 0.12)), "metal", temperature=cold, fixed=True)
    bar.run(1.0, fps=10)
    particles = bar.particles()
    x, first = np.unique(particles.position[:, 0].round(6), return_index=True)  # one particle of each layer
    computed = particles.temperature[first]
    exact, a = np.full_like(x, hot), k / (density * capacity)
    for n in range(1, 200, 2):
        m = n * np.pi / (2 * length)
        exact += (cold - hot) * 4 / (n * np.pi) * np.sin(m * x) * np.exp(-a * m * m * time)
    axes.plot(x, exact, color=color, label=f"k = {k:g} W/(m K), exact")
    axes.plot(x, computed, "o", color=color, markersize=3)
    print(f"k = {k:g}: largest difference {np.abs(computed - exact).max():.2f} K")
axes.set(xlabel="distance from the hot end [m]", ylabel="temperature [°C]", title=f"After {time:g} s (dots: meltsim)")
axes.legend()
figure.savefig("conductivity.png", dpi=120)
