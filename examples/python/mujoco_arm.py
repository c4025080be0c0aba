# SPDX-License-Identifier: Apache-2.0
"""A robot arm in MuJoCo stirs warm water and lifts a melting block of ice out of it, two-way: meltsim moves the ladle as MuJoCo has it, and
the arm feels what water and ice do to the ladle. Needs mujoco (pip install mujoco); runs without a display, in a minute on a CPU. Ends in
arm.png if there is matplotlib. z is up."""
import sys

import mujoco
import numpy as np
from meltsim import Shape, World

DT, FPS = 1 / 240, 240  # s: exchange between the two
SHOULDER, UPPER, FORE = np.array((0.2, 0.24, 1.1)), 0.6, 0.6  # m
DX = 0.04
# The ladle in the frame of the wrist: an arm of its own hangs down to a tray with rims at two sides, open at the others: water drains.
TRAY = ((-0.16, -0.2, -0.52), (0.16, 0.2, -0.44))
RIMS = [((-0.24, -0.2, -0.52), (-0.16, 0.2, -0.28)), ((0.16, -0.2, -0.52), (0.24, 0.2, -0.28))]
MODEL = f"""
<mujoco>
  <option timestep="{DT / 4}" integrator="implicitfast"/>
  <default><position kp="6000" kv="600" inheritrange="0"/><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    <body name="upper" pos="{SHOULDER[0]} {SHOULDER[1]} {SHOULDER[2]}">
      <joint name="shoulder" type="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 {UPPER} 0 0" size="0.05" mass="40"/>
      <body name="fore" pos="{UPPER} 0 0">
        <joint name="elbow" type="hinge" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 {FORE} 0 0" size="0.04" mass="30"/>
        <body name="ladle" pos="{FORE} 0 0">
          <joint name="wrist" type="hinge" axis="0 1 0"/>
          <geom type="capsule" fromto="0 0 0 0 0 -0.44" size="0.02" mass="5"/>
          <geom type="box" pos="0 0 -0.47" size="0.24 0.2 0.05" mass="25"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="shoulder"/><position joint="elbow"/><position joint="wrist"/></actuator>
</mujoco>"""


def angles(wrist):
    """Of the joints, for a place of the wrist (x, z) with the ladle upright; hinges about +y turn x towards -z."""
    x, z = wrist[0] - SHOULDER[0], SHOULDER[2] - wrist[1]
    reach = np.hypot(x, z)
    inner = np.arccos(np.clip((UPPER**2 + reach**2 - FORE**2) / (2 * UPPER * reach), -1, 1))
    outer = np.arccos(np.clip((UPPER**2 + FORE**2 - reach**2) / (2 * UPPER * FORE), -1, 1))
    shoulder = np.arctan2(z, x) - inner
    elbow = np.pi - outer
    return np.array((shoulder, elbow, -shoulder - elbow))


def plan(time, block):
    """Where the wrist is to be: it stirs for 2 s, dives under the block, which it sees, and lifts it."""
    at = lambda t, points: np.array([np.interp(t, [p[0] for p in points], [p[k] for p in points]) for k in (1, 2)])
    if time < 2.2:
        return at(time, [(0, 0.55, 0.95), (0.4, 0.55, 0.72), (0.8, 0.75, 0.72), (1.2, 0.5, 0.72), (1.6, 0.7, 0.72), (2.0, 0.45, 0.72),
                         (2.2, 0.42, 0.62)])
    return np.array((np.interp(time, [2.2, 3.4], [0.42, block]), np.interp(time, [2.2, 2.5, 3.8, 5.8], [0.62, 0.56, 0.56, 1.1])))


def main(seconds=6.5):
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    ladle = model.body("ladle").id
    data.qpos[:] = angles(plan(0, 0))
    mujoco.mj_forward(model, data)

    world = World(spacing=DX, domain=((0, 0, 0), (1.4, 0.48, 1.2)), gravity=(0, 0, -9.81), heat_time_scale=6e3, backend="cpu")
    world.add_material("water", viscosity=0.05)
    world.add_material("ice", density=917, conductivity=2.2, heat_capacity=2100, melting_point=0, latent_heat=3.34e5, becomes="water",
                       friction=0.5)
    world.add_material("steel", density=2700, conductivity=20, heat_capacity=500, friction=0.5)
    world.add_fluid(Shape.box((0, 0, 0), (1.4, 0.48, 0.44)), "water", temperature=40)
    world.add_solid(Shape.box((1.0, 0.12, 0.28), (1.24, 0.36, 0.44)), "ice", name="block", temperature=-5, motion="rigid")
    wrist = data.xpos[ladle].copy()  # the tray is built on the lattice; the host's frame may lie anywhere
    parts = [Shape.box(wrist + low, wrist + high) for low, high in [TRAY, *RIMS]]
    world.add_solid(Shape.unite(*parts), "steel", name="ladle", temperature=30, motion="kinematic", pivot=wrist, max_speed=2)
    world.watch_forces("ladle")

    record, shots = [], []
    torque_arm = torque_fluid = 0.0
    block = 1.1
    force = torque = np.zeros(3)
    for _ in range(round(seconds / DT)):
        pieces = [p for p in world.pieces() if p.name.startswith("block")] if world.steps % 16 == 0 else []
        if pieces and world.time < 4.6:
            block = min(max(pieces, key=lambda p: p.mass).center[0], 1.12)  # no farther than where the tray has room
        data.ctrl[:] = angles(plan(world.time + DT, block))
        data.xfrc_applied[ladle, :3] = force
        # MuJoCo takes torques about the centre of mass of the body, meltsim gives them about the pivot.
        data.xfrc_applied[ladle, 3:] = torque - np.cross(data.xipos[ladle] - data.xpos[ladle], force)
        for _ in range(4):
            data.qfrc_applied[:] = data.qfrc_bias  # the arm's own weight is known; the load is not, and bends it
            mujoco.mj_step(model, data)
        world.set_motion("ladle", position=data.xpos[ladle], orientation=data.xquat[ladle])
        world.step(DT)
        taken = world.take_forces()["ladle"]
        force, torque = np.array(taken["impulse"]) / DT, np.array(taken["angular_impulse"]) / DT
        # What the joint of the shoulder feels of it, by MuJoCo's own Jacobian, and by the moment about the shoulder.
        jacobian, turning = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, jacobian, turning, data.xpos[ladle], ladle)
        by_joint = jacobian[:, 0] @ force + turning[:, 0] @ torque
        by_moment = (torque + np.cross(data.xpos[ladle] - SHOULDER, force))[1]
        torque_arm, torque_fluid = torque_arm + by_joint * DT, torque_fluid + by_moment * DT
        if round(world.time * FPS) in (round(FPS * 1.3), round(FPS * 3.5), round(FPS * seconds)):
            shots.append((world.time, world.particles(), data.xpos[2:4].copy()))
        record.append((world.time, force[2], *data.actuator_force))
    return model, data, world, np.array(record), shots, torque_arm, torque_fluid


def report(model, data, world, record, torque_arm, torque_fluid):
    """What was felt against what was done; returns ratios, which are 1, and numbers of particles of ice."""
    ladle = model.body("ladle").id
    print(f"angular impulse on the shoulder: {torque_arm:.4f} N m s by the joint, {torque_fluid:.4f} N m s by the moment of what the "
          "ladle felt")
    particles = world.particles()
    local = particles.position - data.xpos[ladle]
    carried = (particles.body != 1) & (np.abs(local[:, 0]) < 0.26) & (local[:, 2] > -0.46) & (local[:, 2] < 0.1)
    weight = 9.81 * particles.mass[carried].sum()
    rest = record[-round(0.5 / DT):].mean(axis=0)
    # At rest the shoulder's motor holds the load: its weight times its lever.
    load, lever = rest[2], data.xpos[ladle][0] - SHOULDER[0]
    ice = (particles.body == 0) & (particles.liquid_fraction < 0.5)
    print(f"held for half a second: the ladle feels {-rest[1]:.1f} N downwards; what lies on it weighs {weight:.1f} N; the shoulder's motor "
          f"holds {abs(load):.1f} N m, {abs(load / lever):.1f} N at its lever of {lever:.2f} m")
    print(f"ice: {ice.sum()} particles of 144 left, {(ice & carried).sum()} of them on the ladle, {(carried & ~ice).sum()} of water")
    return {"torque": torque_arm / torque_fluid, "weight": -rest[1] / weight, "load": abs(load / lever / rest[1]),
            "melted": 144 - ice.sum(), "lifted": (ice & carried).sum()}


def draw(shots, picture):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(shots), figsize=(5 * len(shots), 4.6), layout="constrained")
    for axis, (time, p, (elbow, wrist)) in zip(np.atleast_1d(axes), shots):
        middle = np.abs(p.position[:, 1] - 0.24) < 0.05
        dots = axis.scatter(p.position[middle, 0], p.position[middle, 2], c=p.temperature[middle], s=14, cmap="coolwarm", vmin=-5, vmax=40)
        tray = middle & (p.body == 1)
        axis.scatter(p.position[tray, 0], p.position[tray, 2], c="0.35", s=14)
        links = np.array([SHOULDER, elbow, wrist, wrist - (0, 0, 0.44)])
        axis.plot(links[:, 0], links[:, 2], "-o", color="tab:orange", linewidth=4)
        axis.set(aspect="equal", xlim=(0, 1.4), ylim=(0, 1.7), xlabel="x [m]", ylabel="z [m]", title=f"{time:.1f} s")
    figure.colorbar(dots, ax=axes, label="temperature [°C]")
    figure.savefig(picture, dpi=90)
    print(picture)


if __name__ == "__main__":
    model, data, world, record, shots, torque_arm, torque_fluid = main(float(sys.argv[1]) if len(sys.argv) > 1 else 6.5)
    report(model, data, world, record, torque_arm, torque_fluid)
    try:
        draw(shots, "arm.png")
    except ImportError:
        print("no matplotlib: no picture")
