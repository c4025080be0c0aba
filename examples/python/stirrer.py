# SPDX-License-Identifier: Apache-2.0
"""A motor in MuJoCo drives a paddle through warm water with melting ice, two-way: meltsim moves the paddle as MuJoCo says, and MuJoCo
feels the torque of liquid and ice. Needs mujoco (pip install mujoco). Ends in stirrer.html. z is up."""
import mujoco
from meltsim import Shape, World

DT = 0.005  # s: exchange between the two
MODEL = """
<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <body pos="0.5 0.5 0.25">
      <joint name="shaft" type="hinge" axis="0 0 1"/>
      <geom type="box" pos="0.2 0 0" size="0.1 0.05 0.15" density="2700"/>
    </body>
  </worldbody>
  <actuator><motor joint="shaft" ctrlrange="0 5"/></actuator>
</mujoco>"""
TORQUE = 3.0  # N m

model = mujoco.MjModel.from_xml_string(MODEL)
data = mujoco.MjData(model)
in_air = mujoco.MjData(model)
data.ctrl[0] = in_air.ctrl[0] = TORQUE

world = World(spacing=0.05, domain=((0, 0, 0), (1, 1, 0.6)), gravity=(0, 0, -9.81), heat_time_scale=1e5, backend="cpu")
world.add_material("water", viscosity=0.2)
world.add_material("ice", density=917, conductivity=2.2, heat_capacity=2100, melting_point=0, latent_heat=3.34e5, becomes="water")
world.add_material("aluminium", density=2700, conductivity=237, heat_capacity=897, color=(0.8, 0.8, 0.85))
world.add_fluid(Shape.box((0, 0, 0), (1, 1, 0.3)), "water", temperature=60)
world.add_solid(Shape.box((0.1, 0.4, 0.3), (0.3, 0.6, 0.5)), "ice", name="block", temperature=-5)
shaft = (0.5, 0.5, 0.25)
world.add_solid(Shape.box((0.6, 0.45, 0.1), (0.8, 0.55, 0.4)), "aluminium", name="paddle", temperature=60, motion="kinematic",
                pivot=shaft, max_speed=2)
world.add_probe([shaft], ["moment", "contact_moment"], name="paddle", kind="force", body="paddle")  # about the shaft

work = turned = 0.0
for step in range(400):
    mujoco.mj_step(model, data)
    mujoco.mj_step(model, in_air)
    world.set_motion("paddle", position=data.xpos[1], orientation=data.xquat[1])
    world.step(DT)
    moments = world.take_samples()["paddle"]["values"]  # of every sub-step: (samples, 1, 6)
    load = moments[:, 0, 2].mean() + moments[:, 0, 5].mean()
    data.qfrc_applied[0] = load
    work -= load * (data.qpos[0] - turned)
    turned = data.qpos[0]
    if step % 8 == 0:
        world.record()
    if step % 80 == 79:
        print(f"t = {world.time:.2f} s: {data.qvel[0]:.2f} rad/s ({in_air.qvel[0]:.2f} in air), load {load:.2f} N m, "
              f"particles melted: {world.synchronize().melted}")
inertia = TORQUE * world.time / in_air.qvel[0]
kinetic = 0.5 * inertia * data.qvel[0] ** 2
print(f"the motor did {TORQUE * turned:.2f} J: {work:.2f} J on liquid and ice, {kinetic:.2f} J in the paddle")
print(world.show("stirrer.html"))
