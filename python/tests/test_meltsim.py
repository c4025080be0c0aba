# SPDX-License-Identifier: Apache-2.0
"""The package as a user meets it: exact answers, arrays, errors. Small Worlds: the tests are about the interface."""
import copy
import gc
import math
import os
import pickle
import re
import signal
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest

import meltsim
from meltsim import Shape, World


def bath(**settings):
    """A block of ice over warm water: 6 x 6 x 3 cells of liquid, 3^3 of ice."""
    world = World(0.1, domain=((0, 0, 0), (0.6, 0.8, 0.6)), backend="cpu", threads=1, **settings)
    world.add_material("water", viscosity=0.2)
    world.add_material("ice", density=917, melting_point=0, latent_heat=3.34e5, becomes="water", conductivity=2.2, heat_capacity=2100)
    world.add_fluid(Shape.box((0, 0, 0), (0.6, 0.3, 0.6)), "water", temperature=40)
    world.add_solid(Shape.box((0.1, 0.4, 0.1), (0.4, 0.7, 0.4)), "ice", name="block", temperature=-10)
    return world


def test_free_fall_follows_the_parabola():
    # No heat, no contact: leap-frog integrates a constant force exactly. 1e-6: single precision of 1 m.
    world = World(spacing=0.1, backend="cpu", threads=1, heat_model="none")
    world.add_material("ice")
    world.add_solid(Shape.box((0, 0, 0), (0.3, 0.3, 0.3)), "ice", velocity=(1, 2, 0))
    start = world.pieces()[0].center
    for _ in range(10):
        world.step(0.02)
    piece = world.pieces()[0]
    t = 0.2
    assert world.time == pytest.approx(t, rel=1e-12)
    assert np.allclose(np.subtract(piece.center, start), (t, 2 * t - 0.5 * 9.81 * t * t, 0), atol=2e-6)
    assert np.allclose(piece.velocity, (1, 2 - 9.81 * t, 0), atol=1e-5)


def test_calorimetry_ends_at_the_mean_temperature():
    # Two halves of one fixed body, 20 and 80 degrees: heat is exchanged, never created, so they end at 50.
    world = World(spacing=0.1, backend="cpu", threads=1, gravity=(0, 0, 0), heat_time_scale=2e5)
    world.add_material("copper", density=8960, conductivity=400, heat_capacity=385)
    world.add_solid(Shape.box((0, 0, 0), (0.3, 0.3, 0.3)), "copper", temperature=20, fixed=True)
    world.add_solid(Shape.box((0.3, 0, 0), (0.6, 0.3, 0.3)), "copper", temperature=80, fixed=True)
    before = world.totals()
    assert before.mass == pytest.approx(8960 * 0.6 * 0.3 * 0.3, rel=1e-6)
    for _ in range(20):
        world.step(0.005)
    after = world.totals()
    assert after.thermal == pytest.approx(before.thermal, rel=1e-9)
    assert after.temperature_mean == pytest.approx(50, abs=1e-4)
    assert after.temperature_max - after.temperature_min < 0.1 * 60


def test_a_snapshot_goes_on_with_the_same_bits():
    world = bath(heat_time_scale=1e4)
    world.step(0.01)
    saved = world.snapshot()
    world.step(0.01)
    later = world.state_hash()
    world.restore(saved)
    assert world.state_hash() != later
    world.step(0.01)
    assert world.state_hash() == later
    other = bath(heat_time_scale=1e4)
    other.restore(saved)
    other.step(0.01)
    assert other.state_hash() == later
    with pytest.raises(meltsim.Error) as caught:
        world.restore(saved[:-1])
    assert caught.value.code == "corrupt_data"
    assert world.state_hash() == later
    world.step(0.01)
    for same in (bytearray(saved), memoryview(saved), np.frombuffer(saved, np.uint8), memoryview(saved + saved)[:len(saved)]):
        world.restore(same)
        world.step(0.01)
        assert world.state_hash() == later
    for mistake in ("text", 3, [1, 2]):
        with pytest.raises(TypeError, match="snapshot: expected bytes"):
            world.restore(mistake)


def test_a_saved_game_brings_its_bodies():
    def empty():
        world = World(0.1, domain=((0, 0, 0), (1, 1, 1)), backend="cpu", threads=1)
        world.add_material("water")
        return world

    world = empty()
    world.add_fluid(Shape.box((0, 0, 0), (1, 0.4, 1)), "water")
    gone = world.add_solid(Shape.box((0.1, 0.5, 0.1), (0.4, 0.8, 0.4)), "water", motion="rigid")
    world.add_solid(Shape.box((0.6, 0.5, 0.6), (0.9, 0.8, 0.9)), "water", name="hero", motion="rigid")
    world.step(0.01)
    world.remove(gone)
    world.compact()
    saved = world.save()
    other = empty()
    stranger = other.add_solid(Shape.box((0.1, 0.5, 0.1), (0.4, 0.8, 0.4)), "water", name="stranger")
    other.load_saved(bytearray(saved))
    assert list(other.bodies) == ["hero"]
    assert other.state_hash() == world.state_hash()
    for w in (world, other):
        w.set_velocity("hero", (1, 0, 0))
        w.step(0.01)
    assert other.state_hash() == world.state_hash()
    with pytest.raises(meltsim.Error):
        other.remove(stranger)
    with pytest.raises(meltsim.Error, match="restore"):
        other.load_saved(world.snapshot())
    with pytest.raises(TypeError, match="saved: expected bytes of save"):
        other.load_saved(3)
    with pytest.raises(TypeError, match="load_saved"):
        World.load(saved)
    other.remove("hero")
    assert other.pieces() == []


def test_heat_regions_and_probes_are_removed():
    world = bath()
    box = Shape.box((0, 0, 0), (0.6, 0.3, 0.6))
    heater = world.add_heat_region(box, name="heater", source=1e4)
    gauge = world.add_probe([(0.3, 0, 0.3)], kind="level", name="gauge")
    world.add_probe([(0.3, 0.1, 0.3)], name="thermometer", fields=["temperature"])
    world.step(0.01)
    world.remove(heater)
    world.remove(gauge)
    heat = world.totals().heat_in
    assert heat > 0
    world.step(0.01)
    assert world.totals().heat_in == heat
    assert list(world.take_samples()) == ["thermometer"]
    for gone in (heater, gauge):
        with pytest.raises(meltsim.Error):
            world.remove(gone)
    world.add_heat_region(box, name="heater", source=1e4)
    world.add_probe([(0.3, 0, 0.3)], kind="level", name="gauge")


def test_a_saved_state_is_gone_back_to():
    world = bath()
    world.save_state(1)
    before = world.state_hash()
    world.step(0.01)
    assert world.state_hash() != before
    world.load_state(1)
    assert world.state_hash() == before
    with pytest.raises(meltsim.Error, match="nothing is saved"):
        world.load_state(2)
    world.add_material("lead", density=11000)
    with pytest.raises(meltsim.Error, match="is lost"):
        world.load_state(1)


def test_particles_are_arrays_that_share_one_copy():
    world = bath()
    p = world.particles()
    assert len(p) == 6 * 6 * 3 + 27 == world.synchronize().fluid + world.synchronize().solid
    assert p.position.shape == (len(p), 3) and p.position.dtype == np.float64 and p.id.dtype == np.uint32
    assert p.position.base is not None and np.shares_memory(p.position, p.position)
    assert p.solid.dtype == bool and p.solid.sum() == 27 and p.liquid.sum() == 108
    assert set(p.temperature[p.solid]) == {-10.0} and set(p.body[p.solid]) == {0} and set(p.body[p.liquid]) == {-1}
    assert p.mass[p.solid].sum() == pytest.approx(917 * 0.027, rel=1e-6)
    y = p.position[:, 1]
    lowest = y.min()
    assert lowest == pytest.approx(0.05, rel=0.1)  # half a spacing, less what its weight presses it down by
    del p
    world.step(0.01)
    del world
    gc.collect()
    assert y.min() == lowest  # the array keeps what it views


def test_state_views_the_memory_of_the_world():
    world = bath()
    state = world.state()
    x = state.position
    assert x.shape == (135, 4) and x.dtype == np.float32 and not x.flags.writeable
    assert np.shares_memory(x, state.position) and state.acceleration is None
    at = x[np.argsort(state.id), :3] + np.asarray(world.resolved.origin, np.float32)
    assert np.allclose(at, world.particles().position, atol=1e-6)
    before = world.state_hash()
    with pytest.raises(meltsim.Error, match=r"array\(s\) of state\(\)"):
        world.step(0.01)
    with pytest.raises(meltsim.Error, match=r"array\(s\) of state\(\)"):
        world.add_fluid(Shape.sphere((0.5, 0.7, 0.5), 0.1), "water")
    assert world.state_hash() == before and world.time == 0
    kept = x.copy()
    del x
    world.step(0.01)
    with pytest.raises(meltsim.Error, match="has changed since"):
        state.position
    assert not np.array_equal(kept, world.state().position)
    double = World(spacing=0.1, backend="cpu", precision="double")
    double.add_material("m")
    double.add_solid(Shape.box((0, 0, 0), (0.2, 0.2, 0.2)), "m")
    assert double.state().position.dtype == np.float64


def test_a_stage_adds_a_force_and_its_exception_comes_out():
    world = World(spacing=0.1, backend="cpu", threads=1, gravity=(0, 0, 0), heat_model="none")
    world.add_material("m")
    world.add_solid(Shape.box((0, 0, 0), (0.3, 0.3, 0.3)), "m")
    kept = []

    def wind(state):
        state.acceleration[:, 0] += 3

    for recorded in (False, True):  # a CPU calls both in every sub-step
        world.add_stage("wind", wind, recorded=recorded)
        before = world.totals().momentum[0]
        world.step(0.1)
        assert world.totals().momentum[0] - before == pytest.approx(3 * 0.1 * world.totals().mass, rel=1e-5)
        world.remove_stage("wind")
    world.add_stage("faulty", lambda state: 1 / 0)
    time = world.time
    with pytest.raises(ZeroDivisionError):
        world.step(0.1)
    world.remove_stage("faulty")
    assert world.time < time + 0.1

    def keeps_and_raises(state):
        states.append(state)
        raise ZeroDivisionError

    states = []
    world.add_stage("faulty", keeps_and_raises)
    with pytest.raises(ZeroDivisionError):
        world.step(0.1)
    world.remove_stage("faulty")
    with pytest.raises(meltsim.Error, match="the stage has returned"):
        states[0].position
    world.add_stage("keeper", lambda state: kept.append(state.position))
    with pytest.raises(meltsim.Error, match="keeps an array"):
        world.step(0.1)
    kept.clear()
    world.remove_stage("keeper")
    world.add_stage("nested", lambda state: world.step(0.1))
    with pytest.raises(meltsim.Error, match="in use"):
        world.step(0.1)
    world.remove_stage("nested")
    world.step(0.01)
    with pytest.raises(meltsim.Error, match="sph.nothing"):
        world.add_stage("late", wind, after="sph.nothing")


def test_modules_run_as_often_as_told_and_can_be_switched_off():
    world = World(spacing=0.1, backend="cpu", threads=1, domain=((0, 0, 0), (1, 1, 1)))
    world.add_material("water")
    world.add_material("ice", melting_point=0, latent_heat=334e3, becomes="water")
    world.add_solid(Shape.box((0.3, 0, 0.3), (0.7, 0.4, 0.7)), "ice", temperature=-10, surface={"flux": 100})

    def interval(stage):
        return next(s["interval"] for s in world.stages() if s["name"] == stage)

    for module, stage, n in (("topology", "topology.melt", 4), ("thermal", "thermal.exchange", 3), ("topology", "topology.melt", 1)):
        world.set_interval(module, n)
        assert interval(stage) == n
    known = world.state_hash()
    for call, said in ((lambda: world.set_interval("topology", 0), "must be >= 1, got 0"),
                       (lambda: world.set_interval("sph", 2), "only thermal and topology"),
                       (lambda: world.enable("step", False), "step"), (lambda: world.enable_timings(every=0), "every")):
        with pytest.raises(meltsim.Error, match=said):
            call()
    for call in (lambda: world.set_interval("thermal", 2.5), lambda: world.set_interval(None, 2), lambda: world.enable(3)):
        with pytest.raises(TypeError):
            call()
    assert world.state_hash() == known and interval("topology.melt") == 1
    assert all(s["median_ms"] == 0 for s in world.stages())
    world.enable_timings(every=1)
    world.step(0.01)
    assert sum(s["median_ms"] for s in world.stages()) > 0
    world.enable("lsm", False)
    assert {s["reason"] for s in world.stages() if s["module"] == "lsm"} == {"switched off by the host"}
    world.enable("lsm")
    assert any(s["runs"] for s in world.stages() if s["module"] == "lsm")


def test_a_kinematic_body_moves_as_told():
    world = bath()
    world.add_material("steel", density=7800)
    rod = world.add_solid(Shape.box((0.5, 0.5, 0.5), (0.6, 0.7, 0.6)), "steel", motion="kinematic", max_speed=1)
    start = world.motion(rod)["position"]
    world.set_motion(rod, position=np.add(start, (0, 0.05, 0)))
    world.step(0.1)
    # Positions are relative to an origin in single precision: 1e-6 of a metre.
    assert np.allclose(world.motion(rod)["position"], np.add(start, (0, 0.05, 0)), atol=1e-6)
    moved = world.particles()
    assert np.allclose(moved.position[moved.body == rod.index].mean(axis=0), np.add(start, (0, 0.05, 0)), atol=1e-5)
    with pytest.raises(meltsim.Error, match="velocity"):
        world.set_motion(rod, velocity=(math.nan, 0, 0))
    with pytest.raises(meltsim.Error, match="kinematic"):
        world.set_motion("block", velocity=(1, 0, 0))


def test_a_mesh_moves_as_told():
    world = World(0.1, domain=((0, 0, 0), (1, 1, 1)), backend="cpu", threads=1, heat_model="none", gravity=(0, 0, 0))
    world.add_material("steel", density=7800)
    corners = np.array([(x, y, z) for z in (0.3, 0.6) for y in (0.3, 0.6) for x in (0.3, 0.6)])
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    cube = world.add_solid(Shape.mesh(corners, faces), "steel", motion="kinematic", max_speed=1)
    rest = world.particles().position.copy()
    shear = lambda x: x + np.outer(x[:, 1], (0.5, 0, 0))
    world.update_mesh(cube, shear(corners), np.tile((0, 0.1, 0), (8, 1)))
    world.step(0.5)
    # An affine map of the mesh is that of what is inside, to rounding of single precision.
    assert np.allclose(world.particles().position, shear(rest), atol=1e-6)
    world.step(0.1)
    assert np.allclose(world.particles().position, shear(rest) + (0, 0.01, 0), atol=1e-6)
    world.update_mesh("body1", corners.astype(np.float32).tolist())  # what NumPy takes, and no velocities
    with pytest.raises(meltsim.Error, match="8 vertices, got 7"):
        world.update_mesh(cube, corners[:7])
    with pytest.raises(meltsim.Error, match="velocities"):
        world.update_mesh(cube, corners, corners[:7])
    with pytest.raises(meltsim.Error, match="vertices"):
        world.update_mesh(cube, np.where(np.arange(8)[:, None] == 3, math.nan, corners))
    with pytest.raises(meltsim.Error, match=r"shape \(n, 3\)"):
        world.update_mesh(cube, corners.ravel())
    box = world.add_solid(Shape.box((0.7, 0.7, 0.7), (0.9, 0.9, 0.9)), "steel", motion="kinematic")
    with pytest.raises(meltsim.Error, match="one mesh"):
        world.update_mesh(box, corners)


def test_a_proxy_answers_its_host():
    world = World(spacing=0.1, backend="cpu", threads=1)
    world.add_material("wood", density=500)
    # As a cube of 0.3 m has it about its centre: m a^2 / 6.
    inertia = np.eye(3) * 12 * 0.09 / 6
    ball = world.add_solid(Shape.box((0, 0, 0), (0.3, 0.3, 0.3)), "wood", name="ball", motion="proxy", mass=12, inertia=inertia, max_speed=2)
    world.set_proxy(ball, position=(0.15, 0.15, 0.15), velocity=(0, 1, 0), acceleration=(0, 9.81, 0))
    world.step(0.1)
    # It is held against gravity by what its host adds; nothing acts on it here. Single precision: 1e-6.
    forces = world.take_forces()["ball"]
    assert math.isclose(forces["seconds"], 0.1, rel_tol=1e-6)
    assert np.allclose(forces["impulse"], 0, atol=1e-5)
    assert np.allclose(world.proxy(ball)["velocity"], (0, 1, 0), atol=1e-6)
    assert np.allclose(forces["position"], (0.15, 0.25, 0.15), atol=1e-6)
    with pytest.raises(meltsim.Error, match="mass"):
        world.add_solid(Shape.box((1, 1, 1), (1.3, 1.3, 1.3)), "wood", motion="proxy")
    with pytest.raises(meltsim.Error, match="velocity"):
        world.set_proxy(ball, position=(0, 0, 0), velocity=(math.nan, 0, 0))
    with pytest.raises(meltsim.Error, match="always watched"):
        world.watch_forces(ball, False)
    with pytest.raises(meltsim.Error, match="set_proxy"):
        world.set_velocity(ball, (1, 0, 0))


def test_events_say_what_melted_and_what_touches():
    world = bath(heat_time_scale=2e5)
    with pytest.raises(meltsim.Error, match="watch_events"):
        world.take_events()
    with pytest.raises(meltsim.Error, match="capacity"):
        world.watch_events(0)
    with pytest.raises(meltsim.Error, match="kinds"):
        world.watch_events(kinds=["burst"])
    world.watch_events()
    solid = world.totals().solid
    for _ in range(30):
        world.step(0.02)
    taken = world.take_events()
    # Exactly the drop in solid particles, and the end of the body once.
    assert taken["counts"]["melted"] == solid - world.totals().solid > 0
    assert taken["lost"] == 0 and len(taken["events"]) == sum(taken["counts"].values())
    melted = [e for e in taken["events"] if e["kind"] == "melted"]
    assert {e["body"] for e in melted} == {"block"} and all(e["wall"] is None for e in melted)
    assert [e["step"] for e in melted] == sorted(e["step"] for e in melted)
    world.stop_events()
    world.watch_events(8, ["contact_begun"])
    assert world.take_events()["events"] == []


def test_rays_and_shapes_find_what_is_there():
    world = bath()
    origins = [(0.25, 0.79, 0.25), (0.5, 0.79, 0.5), (0.5, 0.79, 0.5)]
    directions = [(0, -1, 0), (0, -5, 0), (0, 1, 0)]
    hits = world.cast_rays(origins, directions)
    assert hits["what"].tolist() == [2, 1, 3] and hits["body"].tolist() == [0, -1, -1] and hits["wall"].tolist() == [-1, -1, 3]
    # The block ends at 0.7 m, the water at 0.3 m, the domain at 0.8 m. 0.01 m: a tenth of a spacing.
    assert np.allclose(hits["point"][:, 1], [0.7, 0.3, 0.8], atol=0.01)
    assert np.allclose(hits["normal"], [(0, 1, 0), (0, 1, 0), (0, -1, 0)], atol=0.05)
    assert np.allclose(hits["distance"], [0.09, 0.49, 0.01], atol=0.01)
    below = world.cast_rays(origins, directions, of="walls", length=0.5)
    assert below["what"].tolist() == [0, 0, 3] and below["distance"][0] == np.inf
    with pytest.raises(meltsim.Error, match=r"rays\[1\]: direction"):
        world.cast_rays(origins[:2], [(0, 1, 0), (0, 0, 0)])
    none = world.cast_rays(np.zeros((0, 3)), np.zeros((0, 3)))
    assert none["what"].shape == none["distance"].shape == (0,) and none["point"].shape == none["normal"].shape == (0, 3)
    with pytest.raises(meltsim.Error, match="as many"):
        world.cast_rays(origins, directions[:2])
    with pytest.raises(meltsim.Error, match="of"):
        world.cast_rays(origins, directions, of=["air"])
    found = world.overlap(Shape.box((0, 0, 0), (0.6, 0.6, 0.6)))
    assert found["liquid"] == 108 and found["bodies"] == {"block": 18}
    assert found["liquid_volume"] == pytest.approx(0.108, rel=1e-5)


def test_a_render_pack_is_drawn_from_while_the_world_steps():
    world = bath()
    pack = world.render_view()
    assert len(pack) == 135 and pack.color is None and pack.radius == pytest.approx(0.05)
    at = pack.position
    assert at.shape == (135, 3) and at.dtype == np.float32 and not at.flags.writeable
    assert np.allclose(at + np.asarray(pack.origin), world.particles().position, atol=1e-6)
    kept = at.copy()
    world.step(0.01)
    assert np.array_equal(at, kept)  # it stays while the World steps
    with pytest.raises(meltsim.Error, match=r"array\(s\) of the one before"):
        world.render_view()
    del at
    later = world.render_view(color="temperature", coldest=-10, hottest=40, colors=range(256))
    assert later.color.dtype == np.uint32 and np.allclose(later.color, np.clip((later.temperature + 10) * 256 / 50, 0, 255), atol=1)
    assert not np.array_equal(later.position, kept)
    with pytest.raises(meltsim.Error, match="later one"):
        pack.position
    materials = world.render_view(color="material", colors=[1, 2])
    assert set(materials.color[materials.temperature > 0]) == {1} and set(materials.color[materials.temperature < 0]) == {2}
    for mistake, text in ((dict(color="mood"), "color"), (dict(color="temperature", hottest=0), "hottest"), (dict(color="material", colors=[-1]), "colors")):
        with pytest.raises(meltsim.Error, match=text):
            world.render_view(**mistake)


def test_a_reading_is_of_its_request_and_names_what_was_asked_for():
    world = bath(heat_time_scale=1e4)
    probe = world.add_probe([(0.3, 0.1, 0.3)], ["temperature"], name="middle")
    world.watch_forces("block")
    world.watch_events()
    world.step(0.05)
    ticket = world.request("totals", "forces", "events", "pieces", "particles", "samples")
    asked, time, steps, mass = world.particles(), world.time, world.steps, world.totals().mass
    world.step(0.05)
    other = world.request("totals")
    reading = world.take(ticket)
    assert world.ready(other) in (False, True)
    assert (reading.time, reading.steps, reading.result.steps) == (time, steps, steps) and not reading.result.halted
    assert reading.totals.mass == pytest.approx(mass) and reading.ledger.step == steps
    at = reading.particles
    assert len(at) == 135 and at.position.dtype == np.float32 and np.array_equal(at.id, asked.id)
    assert np.allclose(at.position + np.asarray(at.origin), asked.position, atol=1e-6) and np.allclose(at.temperature, asked.temperature, atol=1e-4)
    position = at.position
    assert [(p.name, p.body, p.piece, p.particles) for p in reading.pieces] == [("block", world.bodies["block"].index, 1, 27)]
    assert set(at.piece[at.tag & 0x100 != 0]) == {1}
    assert reading.samples["middle"]["values"].shape == (steps, 1, 1) and probe.name == "middle"
    assert reading.forces["block"]["seconds"] == pytest.approx(0.05) and reading.events["lost"] == 0
    one = world.take(other)
    assert one.forces is None and one.events is None and one.pieces is None and one.particles is None and one.samples is None
    del reading, at, one
    gc.collect()
    assert np.isfinite(position).all()  # the array keeps what it views
    with pytest.raises(meltsim.Error, match="ticket"):
        world.take(ticket)
    with pytest.raises(meltsim.Error, match="parts: expected totals, forces"):
        world.request("force")
    with pytest.raises(meltsim.Error, match="ticket"):
        world.ready(-1)
    with pytest.raises(TypeError, match="ticket"):
        world.ready("first")
    world.stop_events()
    with pytest.raises(meltsim.Error, match="events"):
        world.request("events")
    opened = [world.request() for _ in range(4)]
    with pytest.raises(meltsim.Error):
        world.request()
    assert all(world.take(t).totals is None for t in opened)


def test_a_surface_is_viewed_where_it_was_made():
    world = bath()
    whole = world.surface("solids")
    view = world.surface_view("solids")
    assert np.array_equal(view.position, whole.position) and np.array_equal(view.triangles, whole.triangles)
    assert view.position.dtype == np.float32 and not view.position.flags.writeable and view.origin == whole.origin
    assert set(view.body) == {world.bodies["block"].index + 1} and view.draw.tolist() == [whole.triangles.size, 1, 0, 0, 0]
    kept = view.position
    world.step(0.01)
    for again in (world.surface, world.surface_view):
        with pytest.raises(meltsim.Error, match="still view its memory"):
            again("liquid")
    del kept
    later = world.surface_view(world.bodies["block"], wait=False)
    assert later.draw[0] in (0, later.triangles.size)
    with pytest.raises(meltsim.Error, match="past its time"):
        view.position
    with pytest.raises(meltsim.Error, match='of: expected liquid or solids, got "gas", and no body is named so; there are: block'):
        world.surface_view("gas")
    by_name = world.surface("block")
    assert len(by_name.triangles) > 0 and np.array_equal(by_name.position, world.surface(world.bodies["block"]).position)
    world.add_solid(Shape.box((0.5, 0.4, 0.5), (0.6, 0.5, 0.6)), "ice", name="liquid")
    assert set(world.surface("liquid").body) == {0}


def test_probes_of_bodies_are_those_of_their_world():
    scene = {
        "meltsim": 1, "particles": {"spacing": 0.1}, "domain": {"min": [0, 0, 0], "max": [1, 1, 1]}, "time": {"end": 1},
        "materials": {"water": {}, "wood": {"density": 500}}, "fluids": [{"shape": {"box": [[0, 0, 0], [1, 0.3, 1]]}, "material": "water"}],
        "bodies": [{"name": "cork", "shape": {"box": [[0.3, 0.4, 0.3], [0.6, 0.7, 0.6]]}, "material": "wood"}],
        "probes": [{"name": "load", "kind": "force", "body": "cork"}]}
    for _ in range(2):
        world = World.load(scene, backend="cpu", threads=1)
        world.step(0.01)
        assert len(world.take_samples()["load"]["time"]) > 0


def test_what_a_scene_lists_is_steered_and_read_by_its_name():
    scene = {
        "meltsim": 1, "particles": {"spacing": 0.1}, "domain": {"min": [0, 0, 0], "max": [1, 1, 1]}, "time": {"end": 1},
        "materials": {"water": {}}, "fluids": [{"shape": {"box": [[0, 0, 0], [1, 0.3, 1]]}, "material": "water", "temperature": 20}],
        "emitters": [{"nozzle": {"center": [0.5, 0.9, 0.5], "radius": 0.15, "axis": [0, -1, 0]}, "material": "water", "speed": 1, "name": "tap", "until": 5}],
        "heat": {"regions": [{"shape": {"box": [[0, 0, 0], [1, 1, 1]]}, "temperature": 20}]},
        "force_fields": [{"kind": "uniform", "acceleration": [0, 0, 0]}],
        "probes": [{"name": "low", "at": [0.5, 0.1, 0.5], "fields": ["temperature"]}, {"name": "floor", "kind": "force", "wall": "-y", "fields": ["force"]},
                   {"name": "high", "at": [0.2, 0.2, 0.5], "fields": ["temperature"]}]}
    world = World.load(scene, backend="cpu", threads=1)
    assert list(world.emitters) == ["tap"] and list(world.heat_regions) == ["heat1"] and list(world.force_fields) == ["field1"]
    world.set_emitter("tap", on=False)
    world.set_heat_region("heat1", temperature=30)
    world.set_force_field("field1", acceleration=(0, 1, 0))
    mine = world.add_probe([(0.5, 0.1, 0.5)], ["temperature"])
    before = world.synchronize().fluid
    world.step(0.05)
    samples = world.take_samples()
    assert list(samples) == ["low", "high", "floor", mine.name]  # in the order in which the World has them
    assert samples["low"]["values"].shape == (len(samples["low"]["time"]), 1, 1) and samples["floor"]["values"].shape[1:] == (1, 3)
    assert all(samples[name]["values"][-1, 0, 0] == pytest.approx(30) for name in ("low", "high", mine.name))
    assert world.synchronize().fluid == before and world.totals().temperature_min == pytest.approx(30) and world.totals().field_impulse[1] > 0
    with pytest.raises(meltsim.Error, match="there are: tap"):
        world.set_emitter("tab", on=True)
    with pytest.raises(meltsim.Error, match="there are: heat1"):
        world.set_heat_region("heat", temperature=3)
    with pytest.raises(TypeError, match="emitter: expected"):
        world.set_emitter(3, on=True)
    with pytest.raises(meltsim.Error, match="already"):
        world.add_heat_region(Shape.sphere((0, 0, 0), 1), name="heat1", temperature=3)
    assert world.precision == "single"


def test_a_run_to_the_end_of_the_scene_is_over_there():
    world = World.load("ice_block", scale=0.4, set={"time.end": 0.3}, backend="cpu", threads=1)
    world.step(0.1 + 0.1)
    world.step(0.1)  # 0.1 + 0.1 + 0.1 is more than 0.3
    assert world.time > world.end == 0.3
    before = world.state_hash()
    assert world.run().steps == world.steps and world.state_hash() == before
    world.step(0.01)
    world.run()
    assert world.time == pytest.approx(0.31)
    again = World.load("ice_block", scale=0.4, set={"time.end": 0.02}, backend="cpu", threads=1)
    again.step(0.02 - 1e-17)
    steps = again.steps
    again.run()
    assert again.steps == steps
    # A World of one's own has no end: it would be over at once.
    own = bath()
    with pytest.raises(meltsim.Error, match="seconds: this World has no end.*pass the seconds"):
        own.run()
    assert own.time == 0
    own.end = 0.02
    own.run()
    assert own.time == pytest.approx(0.02)


def test_an_assignment_that_would_do_nothing_is_refused():
    world = bath()
    before = world.state_hash()
    for name, text in (("gravity", r"call set_gravity\("), ("heat_time_scale", r"call set_heat_time_scale\("), ("heat_free_surface", r"call set_free_surface_heat\("),
                       ("spacing", r"argument of World\(...\).*stays"), ("graviti", r'no attribute "graviti"; gravity: .*set_gravity'), ("warnigns", 'did you mean "warnings"'),
                       ("set_gravity", "is a method; call set_gravity"), ("time", "can be read only"), ("quite_another", 'no attribute "quite_another"$')):
        with pytest.raises(AttributeError, match=text):
            setattr(world, name, (0, 0, 0))
    assert world.state_hash() == before and world.spacing == 0.1
    world.end, world.fps, world.warnings = 2.0, 10, ["a"]
    world._kept = 3
    assert (world.end, world.fps, world.warnings, world._kept) == (2, 10, ["a"], 3)

    class Tank(World):
        courant = 0.4  # a name of World's that it has for itself
        threads: int

        def __init__(self, **settings):
            super().__init__(spacing=0.1, backend="cpu", threads=1, **settings)
            self.level = 0.3
            self.courant = self.threads = 1

        @property
        def tension(self):
            return self.level

        @tension.setter
        def tension(self, value):
            self.level = value

    class Deep(Tank):
        pass

    for tank in (Tank(), Deep()):
        tank.fish = tank.courant = 2
        tank.tension = 7
        assert (tank.level, tank.courant, tank.fish) == (7, 2, 2)
        with pytest.raises(AttributeError, match="set_gravity"):
            tank.gravity = (0, 0, 0)


def test_a_name_that_nobody_gave_is_never_refused():
    # As the library and scenes count: from 1; where another has that name, on to the next number.
    scene = {
        "meltsim": 1, "particles": {"spacing": 0.1}, "domain": {"min": [0, 0, 0], "max": [2, 1, 1]}, "time": {"end": 1},
        "materials": {"water": {}, "stone": {"density": 2000}},
        "bodies": [{"shape": {"box": [[0, 0, 0], [0.2, 0.2, 0.2]]}, "material": "stone"},
                   {"shape": {"box": [[0.4, 0, 0], [0.6, 0.2, 0.2]]}, "material": "stone", "name": "body3"}],
        "heat": {"regions": [{"shape": {"box": [[0, 0, 0], [1, 1, 1]]}, "temperature": 20}]},
        "probes": [{"at": [0.5, 0.1, 0.5], "fields": ["temperature"]}, {"at": [0.5, 0.1, 0.6], "fields": ["temperature"]}]}
    world = World.load(scene, backend="cpu", threads=1)
    assert list(world.bodies) == ["body1", "body3"]
    for name, x in (("body4", 0.8), ("body5", 1.2)):
        assert world.add_solid(Shape.box((x, 0, 0), (x + 0.2, 0.2, 0.2)), "stone").name == name
    for name in ("heat2", "heat3"):
        assert world.add_heat_region(Shape.sphere((0, 0, 0), 0.1), temperature=3).name == name
    for name in ("probe3", "probe4"):  # one probe of the World has both of the scene
        assert world.add_probe([(0.5, 0.1, 0.5)], ["temperature"]).name == name
    for name in ("probe2", "probe4"):
        with pytest.raises(meltsim.Error, match=f'name: there is a probe "{name}" already'):
            world.add_probe([(0.5, 0.1, 0.5)], ["temperature"], name=name)
    other = World(spacing=0.1, backend="cpu", threads=1)
    other.add_material("water")
    nozzle = dict(material="water", radius=0.2, speed=1, until=1)
    assert other.add_emitter((0, 0, 0), name="emitter2", **nozzle).name == "emitter2"
    assert other.add_emitter((2, 0, 0), **nozzle).name == "emitter3" and other.add_emitter((4, 0, 0), **nozzle).name == "emitter4"
    assert other.add_solid(Shape.box((0, 1, 0), (0.2, 1.2, 0.2)), "water").name == "body1"
    assert other.add_probe([(0, 0, 0)], ["temperature"]).name == "probe1"


def test_an_empty_world_has_empty_arrays():
    world = World(spacing=0.1, backend="cpu", threads=1)
    world.step(0.01)
    assert len(world.particles()) == 0 and world.totals().mass == 0 and world.pieces() == []
    state = world.state()
    assert state.position.shape == (0, 4) and state.id.shape == (0,) and state.acceleration is None
    del state
    pack = world.render_view()
    assert pack.position.shape == (0, 3) and pack.temperature.shape == (0,) and pack.color is None
    assert len(world.take(world.request("particles")).particles) == 0
    assert world.surface().triangles.shape == (0, 3)
    view = world.surface_view()
    assert view.triangles.shape == (0, 3) and view.position.shape == (0, 3)


def test_ellipsoids_that_blend():
    drops = [(0, 0, 0), (0.5, 0, 0)], [(0.3, 0.2, 0.2), (0.3, 0.2, 0.2)]
    sharp, smooth = Shape.blend(*drops), Shape.blend(*drops, blend=0.2)
    neck = (0.25, 0.14, 0)
    assert smooth.contains(neck) and not sharp.contains(neck) and sharp.contains((0.5, 0.19, 0))
    with pytest.raises(meltsim.Error, match="radii: expected as many"):
        Shape.blend([(0, 0, 0)], [(1, 1, 1), (1, 1, 1)])


def test_a_proxy_takes_its_inertia_along_the_axes():
    twists = []
    for inertia in ((0.01, 0.02, 0.03), np.diag((0.01, 0.02, 0.03))):
        world = World(spacing=0.1, backend="cpu", threads=1, gravity=(0, 0, 0))
        world.add_material("wood", density=500)
        world.add_solid(Shape.box((0, 0, 0), (0.3, 0.3, 0.3)), "wood", name="hull", motion="proxy", mass=1, inertia=inertia)
        world.set_proxy("hull", position=(0.15, 0.15, 0.15), angular_velocity=(1, 2, 0.1))
        world.step(0.1)
        twists.append(world.proxy("hull"))
    assert twists[0] == twists[1] and not np.allclose(twists[0]["angular_velocity"], (1, 2, 0.1), atol=1e-3)  # it tumbles
    for mistake in (1, (1, 2), [(1, 0, 0), 2, 3]):
        with pytest.raises(TypeError, match="inertia: expected three"):
            world.add_solid(Shape.box((1, 0, 0), (1.3, 0.3, 0.3)), "wood", motion="proxy", mass=1, inertia=mistake)


def test_forces_on_a_body_are_its_weight():
    world = World(spacing=0.1, backend="cpu", threads=1, domain=((0, 0, 0), (1, 1, 1)))
    world.add_material("stone", density=2000)
    block = world.add_solid(Shape.box((0.3, 0, 0.3), (0.6, 0.3, 0.6)), "stone", name="block", motion="rigid")
    world.watch_forces(block)
    for _ in range(100):
        world.step(0.01)
    world.take_forces()
    for _ in range(50):
        world.step(0.01)
    forces = world.take_forces()["block"]
    # At rest on the floor: its weight, to what is left of a first bounce.
    assert math.isclose(forces["contact"][1] / forces["seconds"], 2000 * 0.027 * 9.81, rel_tol=0.01)


def test_a_rigid_body_keeps_its_shape():
    world = World(spacing=0.1, backend="cpu", threads=1, gravity=(0, 0, 0))
    world.add_material("stone", density=2000)
    world.add_solid(Shape.box((0, 0, 0), (0.3, 0.2, 0.4)), "stone", motion="rigid", angular_velocity=(1, 2, 3))
    before = world.particles().position.copy()
    for _ in range(20):
        world.step(0.02)
    after = world.particles().position

    def distances(x):
        return np.linalg.norm(x[:, None] - x[None], axis=-1)

    assert not np.allclose(before, after, atol=0.01)
    # Positions of half a metre in single precision round to 3e-8 m.
    assert np.allclose(distances(before), distances(after), atol=2e-7)


def test_force_fields_accelerate_what_is_in_them():
    world = World(spacing=0.1, backend="cpu", threads=1, gravity=(0, 0, 0), heat_model="none")
    world.add_material("water")
    world.add_fluid(Shape.box((0, 0, 0), (0.3, 0.3, 0.3)), "water")
    world.add_fluid(Shape.box((2, 0, 0), (2.3, 0.3, 0.3)), "water")
    fan = world.add_force_field("uniform", Shape.sphere((0.15, 0.15, 0.15), 1), name="fan", acceleration=(0, 5, 0))
    world.step(0.1)
    # 27 kg at 0.5 m/s; the other 27 kg are outside. Single precision of 13 N s, of 3.4 J.
    assert np.allclose(world.totals().momentum, (0, 13.5, 0), atol=1e-4)
    assert np.allclose(world.ledger().field_impulse, (0, 13.5, 0), atol=1e-4)
    assert world.totals().field_work == pytest.approx(27 * 0.5**2 / 2, rel=1e-5)
    world.set_force_field("fan", acceleration=(0, -5, 0))  # the rest of it stays
    world.step(0.1)
    assert np.allclose(world.totals().momentum, (0, 0, 0), atol=1e-4)
    before = world.state_hash()
    with pytest.raises(meltsim.Error, match="strength: must be finite"):
        world.set_force_field(fan, kind="radial", strength=math.nan)
    with pytest.raises(meltsim.Error, match="radius"):
        world.add_force_field("vortex", strength=1, radius=-1)
    with pytest.raises(meltsim.Error, match="box, a sphere or a cylinder"):
        world.set_force_field(fan, shape=Shape.torus((0, 0, 0), (0, 1, 0), 1, 0.2))
    with pytest.raises(TypeError, match='did you mean "strength"'):
        world.set_force_field(fan, strenght=1)
    with pytest.raises(TypeError, match="meltsim.Shape or None"):
        world.add_force_field("uniform", "everywhere")
    with pytest.raises(meltsim.Error, match="another World"):
        bath().set_force_field(fan, strength=1)
    world.remove(fan)
    with pytest.raises(meltsim.Error, match="no force field"):
        world.remove(fan)
    with pytest.raises(meltsim.Error, match='named "fan"; there are none'):
        world.set_force_field("fan", strength=1)
    assert world.state_hash() == before
    scene = {"meltsim": 1, "particles": {"spacing": 0.1}, "heat": {"model": "none"}, "solver": {"gravity": [0, 0, 0]},
             "domain": {"min": [0, 0, 0], "max": [1, 1, 1]}, "materials": {"water": {}},
             "fluids": [{"shape": {"box": [[0.3, 0.3, 0.3], [0.6, 0.6, 0.6]]}, "material": "water"}],
             "force_fields": [{"name": "wind", "kind": "drag", "velocity": [0, 1, 0], "rate": 10}]}
    windy = World.load(scene, backend="cpu")
    windy.set_force_field("wind", velocity=(0, 0, 0.5))
    windy.step(0.1)
    assert np.allclose(windy.totals().momentum, (0, 0, 13.5 * (1 - math.exp(-1))), atol=1e-4)


def test_what_was_removed_is_forgotten():
    world = bath()
    world.step(0.01)
    block = world.bodies["block"]
    world.remove(block)
    removed = world.remove_liquid(Shape.box((0, 0, 0), (0.6, 0.1, 0.6)))
    assert removed > 0
    left, total = world.particles(), world.synchronize().removed
    was = world.compact()
    now = world.particles()
    assert was.dtype == np.uint32 and len(was) == len(now.id) == len(left.id)
    assert np.array_equal(was[now.id], left.id) and np.array_equal(now.position, left.position)
    assert world.synchronize().removed == total > removed
    assert "block" not in world.bodies
    with pytest.raises(meltsim.Error, match="was removed"):
        world.hold(block)
    again = world.add_solid(Shape.box((0.2, 0.4, 0.2), (0.4, 0.6, 0.4)), "ice", name="block", temperature=-5)
    assert world.bodies == {"block": again} and again.index == block.index and again != block
    world.step(0.01)
    assert [p.body for p in world.pieces()] == [again.index]
    with pytest.raises(meltsim.Error, match="nothing that was removed"):
        world.hold(block)


def test_a_world_is_steered_between_steps():
    world = World(spacing=0.1, backend="cpu", threads=1, gravity=(0, 0, 0), heat_time_scale=1)
    world.add_material("ice", density=1000)
    body = world.add_solid(Shape.box((0, 0, 0), (0.3, 0.3, 0.3)), "ice", name="cube", temperature=20)
    region = world.add_heat_region(Shape.box((-9, -9, -9), (9, 9, 9)), source=500)
    mass = world.totals().mass
    world.apply_impulse(body, (mass, 0, 0))
    # Single precision of a momentum of 27 kg m/s.
    assert np.allclose(world.totals().momentum, (mass, 0, 0), atol=1e-4)
    world.set_velocity("cube", (0, 2, 0))
    assert np.allclose(world.totals().momentum, (0, 2 * mass, 0), atol=1e-4)
    world.set_gravity((0, -10, 0))
    world.step(0.1)
    assert np.allclose(world.totals().momentum, (0, mass, 0), atol=1e-3)
    world.set_heat_region(region, source=1000)
    world.step(0.1)
    assert world.totals().heat_in == pytest.approx((500 + 1000) * 0.027 * 0.1, rel=1e-5)
    world.set_heat_time_scale(0)
    world.step(0.1)
    assert world.totals().heat_in == pytest.approx(4.05, rel=1e-5)
    world.remove(body)
    assert world.totals().solid == 0
    with pytest.raises(meltsim.Error, match="remove"):
        world.remove(body)
    other = bath()
    assert other.remove_liquid(Shape.box((0, 0, 0), (0.6, 0.1, 0.6))) == 36
    before = other.state_hash()
    with pytest.raises(meltsim.Error, match="another World"):
        other.set_heat_region(region, source=1)
    with pytest.raises(TypeError, match='did you mean "temperature"'):
        other.set_wall_heat("-y", temprature=80)
    with pytest.raises(meltsim.Error, match="gravity"):
        other.set_gravity((0, math.nan, 0))
    with pytest.raises(meltsim.Error, match="density: must stay"):
        other.set_material("water", density=900)
    with pytest.raises(TypeError, match='did you mean "viscosity"'):
        other.set_material("water", viscosty=1)
    assert other.state_hash() == before
    other.set_material("water", viscosity=3)
    other.set_wall_heat("-y", temperature=80)
    other.remove("block")
    tap = other.add_emitter((0.3, 0.7, 0.3), "water", radius=0.1, speed=1, until=1.0)
    other.set_emitter(tap, on=False)
    other.set_emitter(tap, center=(0.35, 0.7, 0.3))
    with pytest.raises(meltsim.Error, match="center: must be finite"):
        other.set_emitter(tap, center=(0.35, math.inf, 0.3))
    other.step(0.01)
    assert other.totals().heat_in > 0


def test_liquid_comes_in_and_goes_out_below_a_level():
    world = meltsim.World(domain={"max": (1, 1, 0.5), "faces": {"+x": "open"}}, spacing=0.1, backend="cpu", threads=1)
    world.add_material("water")
    with pytest.raises(meltsim.Error, match="level: the opening must reach the level"):
        world.add_emitter(material="water", axis=(-1, 0, 0), level=2)
    lake = world.add_emitter(material="water", axis=(-1, 0, 0), level=0.6, height=0.8, name="lake")
    for _ in range(60):
        world.step(0.02)
    came = world.synchronize()
    assert came.entered > 20 and came.fluid == came.entered and came.removed == 0
    assert len(world.particles()) == came.fluid  # ids in reserve are none of them
    with pytest.raises(meltsim.Error, match="level: 0.9 m is 0.9 m above the floor"):
        world.set_emitter(lake, level=0.9)
    for frame in range(60):  # it falls by and by
        world.set_emitter("lake", level=max(0.2, 0.6 - 0.02 * frame))
        world.step(0.02)
    went = world.synchronize()
    assert went.removed > 20 and went.fluid == went.entered - went.removed


@pytest.mark.parametrize("call, error, text", [
    (lambda w: w.add_material("oil", densty=900), TypeError, 'did you mean "density"'),
    (lambda w: w.add_material("oil", density="heavy"), TypeError, "density: expected a number, got 'heavy'"),
    (lambda w: w.add_material("oil", density=-1), meltsim.Error, "density"),
    (lambda w: w.add_material("oil", density=math.nan), meltsim.Error, "density"),
    (lambda w: w.add_material("water"), meltsim.Error, "already"),
    (lambda w: w.add_fluid(Shape.box((0, 0, 0), (1, 1, 1)), "watr"), meltsim.Error, "there are: water, ice"),
    (lambda w: w.add_fluid(Shape.box((0, 0, 0), (1, 1, 1))), TypeError, "material is missing"),
    (lambda w: w.add_fluid("box", "water"), TypeError, "expected a meltsim.Shape"),
    (lambda w: w.add_solid(Shape.box((0, 0.4, 0), (0.3, 0.7, 0.3)), "ice", velocity=(1, 2)), TypeError, "velocity: expected three numbers"),
    (lambda w: w.add_solid(Shape.box((0.1, 0.4, 0.1), (0.4, 0.7, 0.4)), "ice", name="block"), meltsim.Error, "already"),
    (lambda w: w.add_solid(Shape.box((0.5, 0.4, 0.5), (0.6, 0.5, 0.6)), "ice", surface={"flx": 1}), TypeError, 'did you mean "flux"'),
    (lambda w: w.sample(np.zeros((2, 4)), "temperature"), meltsim.Error, r"got one of shape \(2, 4\)"),
    (lambda w: w.sample([[0, 0, "a"]], "temperature"), TypeError, "got an array of <U"),
    (lambda w: w.sample([[0, 0, math.inf]], "temperature"), meltsim.Error, "points"),
    (lambda w: w.sample([[0, 0, 0]], "heat"), meltsim.Error, "heat"),
    (lambda w: w.surface("gas"), meltsim.Error, 'expected liquid or solids, got "gas"'),
    (lambda w: w.step(math.nan), meltsim.Error, "dt"),
    (lambda w: w.step("fast"), TypeError, "seconds: expected a number"),
    (lambda w: w.step(-1), meltsim.Error, "dt"),
    (lambda w: w.run(math.inf), meltsim.Error, "seconds"),
    (lambda w: World(spacing=0.1, domain=((0, 0), (1, 1))), TypeError, "domain: min: expected three numbers"),
    (lambda w: World(spacing=0.1, domain={"min": (0, 0, 0), "max": (1, 1, 1), "faces": {"top": "open"}}), meltsim.Error, "expected a face"),
    (lambda w: w.run("long"), TypeError, "seconds: expected a number, got 'long'"),
    (lambda w: w.run(0.1, fps=True), TypeError, "fps: expected a number"),
    (lambda w: w.run(0.1, each=5), TypeError, "each: expected a function"),
    (lambda w: World.load("ice_block", scale="a"), TypeError, "scale: expected a number, got 'a'"),
    (lambda w: w.add_material("\udcff"), meltsim.Error, "name: expected text that UTF-8 can write"),
    (lambda w: w.add_material("oil", **{"\udcff": 1}), meltsim.Error, "argument's name"),
    (lambda w: World(spacing=0), meltsim.Error, "spacing"),
    (lambda w: World(spacing=0.1, isotropic_pressure="auto"), TypeError, "isotropic_pressure: expected True, False or None, got 'auto'"),
    (lambda w: w.add_material("oil", diffusivity="low"), TypeError, "diffusivity: expected a number or None, got 'low'"),
    (lambda w: w.step(None), TypeError, "seconds: expected a number, got None"),
    (lambda w: w.step(), TypeError, "step: seconds is missing"),
    (lambda w: w.step(second=1), TypeError, 'step: there is no argument "second"; did you mean "seconds"'),
    (lambda w: w.step_within(0.1, None), TypeError, "milliseconds: expected a number, got None"),
    (lambda w: w.step_part(0.1, 1, 2), TypeError, "step_part: takes at most 2 arguments, got 3"),
    (lambda w: w.set_gravity(None), TypeError, "gravity: expected three numbers, got None"),
    (lambda w: w.set_heat_time_scale(sclae=2), TypeError, 'did you mean "scale"'),
    (lambda w: Shape.box((0, 0, 0), mx=(1, 1, 1)), TypeError, 'box: there is no argument "mx"; did you mean "max"'),
    (lambda w: Shape.sphere(centre=(0, 0, 0), radius=1), TypeError, 'did you mean "center"'),
    (lambda w: Shape.sphere((0, 0, 0), None), TypeError, "radius: expected a number, got None"),
    (lambda w: Shape.sphere((0, 0, 0), 1, radius=1), TypeError, "sphere: radius is given twice"),
    (lambda w: Shape.capsule((0, 0, 0), (1, 0, 0)), TypeError, "capsule: radius is missing"),
    (lambda w: Shape.cylinder((0, 0, 0), (1, 0, 0), 1, 2), TypeError, "cylinder: takes at most 3 arguments, got 4"),
    (lambda w: Shape.torus((0, 0, 0), (1, 0, 0), major=1, minor_radius=2), TypeError, 'torus: there is no argument "major"'),
    (lambda w: Shape.blend([(0, 0, 0)], [(1, 1, 1)], blnd=0.1), TypeError, 'did you mean "blend"'),
    (lambda w: Shape.mesh(np.zeros((3, 3)), faces=[[0, 1, 2]]), TypeError, "mesh: there is no argument"),
    (lambda w: Shape.from_file(3), TypeError, "path: expected the path of a file, got 3"),
    (lambda w: Shape.sphere((0, 0, 0), 1).transformed(ofset=(1, 0, 0)), TypeError, 'did you mean "offset"'),
    (lambda w: Shape.sphere((0, 0, 0), 1).contains(None), TypeError, "point: expected three numbers, got None"),
    (lambda w: Shape.sphere((0, 0, 0), math.nan), meltsim.Error, "radius|extents|finite"),
    (lambda w: Shape.mesh(np.zeros((3, 3)), [[0, 1, 2.5]]), TypeError, "integers"),
    (lambda w: Shape.mesh(np.zeros((3, 3)), [[0, 1, 3]]), meltsim.Error, "3"),
])
def test_a_mistake_is_named_and_changes_nothing(call, error, text):
    world = bath()
    before = world.state_hash()
    with pytest.raises(error, match=text):
        call(world)
    assert world.state_hash() == before and world.time == 0 and len(world.materials) == 2


def test_handles_of_another_world_are_refused():
    water = bath().materials["water"]
    world = bath()
    with pytest.raises(meltsim.Error, match="belongs to another World"):
        world.add_fluid(Shape.sphere((0.5, 0.7, 0.5), 0.1), water)
    assert world.materials["water"] == world.materials["water"] != water


def test_arrays_of_any_layout_give_the_same_values():
    world = bath()
    world.step(0.01)
    points = np.array([[0.3, 0.1, 0.3], [0.2, 0.2, 0.2], [9, 9, 9]])
    expected = world.sample(points, ["temperature", "velocity"])
    assert expected.shape == (3, 4) and np.isnan(expected[2]).all() and expected[0, 0] == pytest.approx(40, abs=1)
    for same in (np.asfortranarray(points), points[::-1][::-1], points.tolist()):
        assert np.array_equal(world.sample(same, ["temperature", "velocity"]), expected, equal_nan=True)
    assert world.sample(points[0], "temperature").shape == (1, 1)
    assert world.sample(np.zeros((0, 3)), "temperature").shape == (0, 1)


def test_probes_come_back_by_name():
    world = bath()
    world.add_probe([[0.3, 0.1, 0.3], [0.3, 0.2, 0.3]], ["pressure", "velocity"], name="wall", every=0.01)
    world.add_probe(kind="force", body="block", fields="force", name="on the block")
    world.step(0.02)
    samples = world.take_samples()
    assert list(samples) == ["wall", "on the block"]
    assert samples["wall"]["values"].shape == (len(samples["wall"]["time"]), 2, 4)
    assert samples["on the block"]["values"].shape[1:] == (1, 3)


def test_a_flux_goes_through_a_rectangle():
    world = World(spacing=0.1, domain=((0, 0, 0), (1, 1, 1)), backend="cpu", threads=1, gravity=(0, 0, 0), heat_model="none")
    world.add_material("water")
    world.add_fluid(Shape.box((0, 0, 0), (1, 1, 1)), "water", velocity=(1, 0, 0))
    flux = dict(points=(0.5, 0.5, 0.5), kind="flux", normal=(1, 0, 0), fields="volume_flux")
    world.add_probe(**flux, along=(0, 1, 0), size=(0.2, 0.4), name="tall")
    world.add_probe(**flux, along=(0, 1, 0), size=np.array([0.4, 0.4]), name="square")
    world.step(world.stable_dt())
    samples = {name: of["values"].mean() for name, of in world.take_samples().items()}
    # Area times speed, to a tenth: sums over a lattice.
    assert samples == {"tall": pytest.approx(0.08, rel=0.1), "square": pytest.approx(0.16, rel=0.1)}
    for size in (0.2, (1, 2, 3), "ab", ("a", 1)):
        with pytest.raises(TypeError, match="size"):
            world.add_probe(**flux, along=(0, 1, 0), size=size)
    with pytest.raises(meltsim.Error, match="along"):
        world.add_probe(**flux, size=(0.2, 0.4))


def test_the_surface_of_a_block_has_its_size():
    mesh = bath().surface("solids", smoothing=0)
    a, b, c = (mesh.position[mesh.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert mesh.triangles.dtype == np.uint32 and mesh.normal.shape == mesh.position.shape
    # Three spacings wide, edges rounded by half a spacing: within a quarter.
    assert volume == pytest.approx(0.027, rel=0.25)


def test_a_second_thread_is_refused_while_one_steps():
    world = bath()
    inside, leave = threading.Event(), threading.Event()

    def wait(state):
        inside.set()
        assert leave.wait(10)
        world_stage.append(1)

    world_stage = []
    world.add_stage("wait", wait)
    stepping = threading.Thread(target=lambda: world.step(1e-5))
    stepping.start()
    assert inside.wait(10)
    for call in (world.totals, world.particles, lambda: world.step(0.1), lambda: world.add_material("oil")):
        with pytest.raises(meltsim.Error, match="one thread at a time"):
            call()
    leave.set()
    stepping.join()
    assert world_stage and world.totals().fluid == 108


@pytest.fixture
def python_handles_sigint():
    """Jobs that a script starts in the background ignore SIGINT, and Python then leaves it so."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_ends_a_step_and_the_next_goes_on(python_handles_sigint):
    world = bath()
    world.prepare()
    steps = []

    def press(state):
        steps.append(state.time)
        if len(steps) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    world.add_stage("press", press)
    dt = world.resolved.stable_dt
    with pytest.raises(KeyboardInterrupt):
        world.step(8 * dt)
    assert world.time < 7 * dt
    world.remove_stage("press")
    world.step(8 * dt - world.time)  # no interrupt is left over
    assert world.time == pytest.approx(8 * dt)
    # Pressed when the last sub-step is done: the step counts, and the next one is not interrupted.
    world.add_stage("late", lambda state: os.kill(os.getpid(), signal.SIGINT), after="topology.neighbours", reads=(), writes=())
    time = world.time
    with pytest.raises(KeyboardInterrupt):
        world.step(0.5 * dt)
    assert world.time == pytest.approx(time + 0.5 * dt)
    world.remove_stage("late")
    world.step(0.5 * dt)
    assert world.time == pytest.approx(time + dt)
    handler = signal.getsignal(signal.SIGINT)
    assert handler is signal.default_int_handler
    world.interrupt()
    with pytest.raises(meltsim.Error) as caught:
        world.step(dt)
    assert caught.value.code == "interrupted"


def test_ctrl_c_that_the_program_ignores_ends_no_step(python_handles_sigint):
    world = bath()
    world.prepare()
    dt = world.resolved.stable_dt
    world.add_stage("press", lambda state: os.kill(os.getpid(), signal.SIGINT))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    world.step(8 * dt)
    assert world.time == pytest.approx(8 * dt)
    # A handler of the host's own: what it raises ends the step; where it returns, an error says that the step was cut short.
    signal.signal(signal.SIGINT, lambda number, frame: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        world.step(8 * dt)
    seen = []
    signal.signal(signal.SIGINT, lambda number, frame: seen.append(number))
    with pytest.raises(meltsim.Error) as caught:
        world.step(8 * dt)
    assert caught.value.code == "interrupted" and seen == [signal.SIGINT]
    assert world.time < 10 * dt


def test_what_was_derived_is_there():
    world = World(0.1, backend="cpu", threads=1, gravity=(0, 0, 0), heat_model="none")
    world.add_material("soft", youngs_modulus=5e3)
    world.add_solid(Shape.box((0, 0, 0), (1, 1, 1)), "soft")
    world.prepare()
    world.step(world.resolved.stable_dt)
    (soft,) = world.resolved.stiffness
    assert soft.region_half_width >= 1 and 0 < soft.stiffness <= 1
    assert soft.youngs_modulus == pytest.approx(5e3, rel=1e-6)  # no step is too long for it
    assert world.resolved.error == "" and world.resolved.solute_supersteps == 0 and world.resolved.neighbour_reason
    assert "youngs_modulus" in soft.as_dict() and "stiffness" in repr(soft)


def test_events_are_for_cuda():
    world = bath()
    for call in (world.wait_for, world.signal):
        with pytest.raises(meltsim.Error, match="on the CPU"):
            call(8)
        with pytest.raises(TypeError, match="event"):
            call("now")


def test_scenes_come_from_names_files_and_dicts(tmp_path):
    scene = {
        "meltsim": 1, "title": "Small", "domain": {"min": [0, 0, 0], "max": np.array([0.6, 0.6, 0.6]), "walls": "box"},
        "particles": {"spacing": 0.1}, "time": {"end": 0.04, "fps": 50},
        "materials": {"water": {"density": 1000}, "ice": {"density": 917, "melting_point": 0, "latent_heat": 1, "becomes": "water"}},
        "fluids": [{"shape": {"box": [[0, 0, 0], [0.6, 0.3, 0.6]]}, "material": "water", "temperature": 40}],
        "bodies": [{"name": "cube", "shape": {"box": [[0.2, 0.3, 0.2], [0.4, 0.5, 0.4]]}, "material": "ice"}],
        "probes": [{"name": "middle", "at": [0.3, 0.1, 0.3], "fields": ["temperature"]}]}
    world = World.load(scene, backend="cpu", threads=1)
    assert list(world.materials) == ["water", "ice"] and list(world.bodies) == ["cube"]
    seen = []
    world.run(each=lambda w: seen.append(w.time))
    assert seen == pytest.approx([0.02, 0.04])
    page = world.show(tmp_path / "page.html").read_text()
    assert "<title>" in page and "Small" in page
    again = World.load(scene, set={"fluids[0].temperature": 60}, backend="cpu")
    assert again.totals().temperature_max == pytest.approx(60)
    with pytest.raises(meltsim.Error, match="not finite"):
        World.load({**scene, "particles": {"spacing": math.nan}})
    del scene["bodies"][0]["material"]
    with pytest.raises(meltsim.Error, match=r"bodies\[0\]"):
        World.load(scene)
    with pytest.raises(meltsim.Error, match="ice_block"):
        World.load("ice_blok")
    with pytest.raises(meltsim.Error, match="cannot be read"):
        World.load(tmp_path / "none.yaml")
    with pytest.raises(TypeError, match="scene: expected"):
        World.load(3)
    assert "ice_block" in meltsim.scenes()


def test_errors_of_a_dict_say_where_in_the_dict():
    def scene(**other):
        return {"meltsim": 1, "particles": {"spacing": 0.1}, "domain": {"min": [0, 0, 0], "max": [1, 1, 1]}, "time": {"end": 1}, "materials": {"ice": {"density": 917}},
                "bodies": [{"shape": {"box": [[0.3, 0.4, 0.3], [0.6, 0.7, 0.6]]}, "material": "ice"}], **other}

    around = scene()
    around["title"] = [{"again": around}]
    deep = 0
    for _ in range(5000):
        deep = [deep]
    body = {"shape": {"box": [[0, 0, 0], [1, 1, 1]]}, "material": "ice"}
    for mistake, error, text in (
            (scene(particles={"spcing": 0.1}), meltsim.Error, 'scene: unknown key "spcing" in particles; did you mean "spacing"?'),
            (scene(bodies=[{**body, "temperature": "hot"}]), meltsim.Error, 'scene: bodies[0].temperature: expected a number (degrees Celsius), got "hot"'),
            (scene(materials={"ice": {"density": -3}}), meltsim.Error, "scene: materials.ice.density: must be finite"),  # that of the library
            ({**scene(), 1: 2, "1": 3}, meltsim.Error, 'scene: duplicate key "1" in the scene'),
            (around, meltsim.Error, "scene: title[0].again: contains itself"),
            (scene(title=deep), meltsim.Error, "nested more than 100 deep"),
            (scene(bodies=[{**body, "velocity": np.array([0, math.nan, 0])}]), meltsim.Error, "scene: bodies[0].velocity[1]: nan is not finite"),
            (scene(title=b"x"), TypeError, "scene: title: b'x' (bytes) has no place in a scene"),
            (scene(title={(1, 2): 3}), TypeError, "scene: title: a key: expected a string, got (1, 2) (tuple)")):
        with pytest.raises(error) as caught:
            World.load(mistake, backend="cpu")
        assert str(caught.value).startswith(text) or text.startswith("nested") and text in str(caught.value)
    for settings, text in ((dict(threads=-1), "threads: must be >= 0, got -1"), (dict(threads=2**33), "threads: 8589934592 is out of range"),
                           (dict(scale=0), "scale: expected a factor from 0.01 to 100, got 0"), (dict(set={"bodies[0].temperature": "x"}), "set: bodies[0].temperature="),
                           (dict(set={"time.end": math.inf}), "set['time.end']: inf is not finite")):
        for of in (scene(), "ice_block"):
            with pytest.raises(meltsim.Error) as caught:
                World.load(of, **{"backend": "cpu", **settings})
            assert str(caught.value).startswith(text) and not str(caught.value).endswith("0000")
    # What a file has stays with its place.
    with pytest.raises(meltsim.Error, match=r"ice_block:\d+:\d+: particles.support"):
        World.load("ice_block", set={"particles.spacing": 2.0}, backend="cpu")
    warm = World.load(scene(materials={"water": {}, "ice": {"density": 917, "melting_point": 0, "latent_heat": 3e5, "becomes": "water"}}), backend="cpu", threads=1)
    assert len(warm.warnings) == 1 and warm.warnings[0].startswith("scene: bodies[0]")


def test_a_world_in_a_cycle_with_its_stage_is_collected():
    world = bath()
    world.add_stage("self", lambda state, w=world: None)
    gone = weakref.ref(world) if hasattr(world, "__weakref__") else None
    del world
    gc.collect()
    assert gone is None or gone() is None


def test_a_closed_world_is_gone():
    with bath() as world:
        world.add_stage("nothing", lambda state, held=world: None)
        world.run(0.02)
        particles, totals, reading = world.particles(), world.totals(), world.take(world.request("totals", "pieces"))
        state, pack, surface, block = world.state(), world.render_view(), world.surface_view(), world.bodies["block"]
        views = [state.position, pack.position, surface.position]
        while views:
            with pytest.raises(meltsim.Error, match="still view"):
                world.close()
            views.pop()
        assert not world.closed and world.totals().mass == totals.mass
    assert world.closed and repr(world) == "<meltsim.World: closed>"
    world.close()
    calls = [lambda: world.step(0.1), world.run, world.particles, world.totals, world.snapshot, world.interrupt, world.show, world.record, world.stable_dt, world.prepare,
             lambda: world.add_material("oil"), lambda: world.remove(block), lambda: world.remove_stage("nothing"), lambda: world.sample([(0, 0, 0)], "speed"),
             world.stages, lambda: world.time, lambda: world.bodies, lambda: world.resolved, lambda: world.backend, world.__enter__,
             lambda: state.position, lambda: pack.position, lambda: surface.position, lambda: surface.draw]
    for call in calls:
        with pytest.raises(meltsim.Error, match="^World: it is closed"):
            call()
    # What was copied out of it stays.
    assert len(particles) == 135 and particles.temperature.max() > 0 and reading.totals.mass == totals.mass and reading.pieces[0].name == block.name
    with pytest.raises(ZeroDivisionError):  # not an error about the array that its frame holds
        with bath() as other:
            x = other.state().position
            x / 0 if x is None else 1 / 0
    assert not other.closed and len(x) == 135
    with pytest.raises(meltsim.Error, match="still view"):
        with other:
            pass
    del x
    other.add_stage("closes", lambda state: other.close())
    with pytest.raises(meltsim.Error, match="in use"):
        other.step(0.01)
    other.close()
    assert other.closed


def test_what_was_read_is_copied_and_pickled():
    world = bath(heat_time_scale=1e4)
    world.add_material("salt", dissolves_in="water", solubility=0.3, diffusivity_in=1e-9)
    world.add_fluid(Shape.box((0.5, 0.5, 0.5), (0.6, 0.6, 0.6)), "water", fractions={"salt": 0.1})
    world.step(0.01)
    records = [world.totals(), world.ledger(), world.synchronize(), world.pieces()[0], world.resolved, world.step_within(0.01, 1e9)]
    again = [pickle.loads(pickle.dumps(records)), copy.deepcopy(records), [copy.copy(r) for r in records]]
    for others in again:
        for one, other in zip(records, others):
            assert type(one) is type(other) and repr(one) == repr(other)  # of every number, to its last digit
    piece, solute = records[3], records[1].solute
    assert solute[0] > 0 and all(others[1].solute == solute for others in again)
    for others in again:
        assert (others[3].body, others[3].orientation, others[3].bounds) == (piece.body, piece.orientation, piece.bounds)
        assert np.array_equal(others[3].inertia, piece.inertia) and piece.inertia[0, 0] > 0
        assert others[4].stiffness[0].as_dict() == world.resolved.stiffness[0].as_dict()
    p = world.particles()
    arrays = p.as_dict()
    assert list(arrays)[:2] == ["id", "position"] and arrays["position"].shape == (len(p), 3)
    for other in (pickle.loads(pickle.dumps(p)), copy.deepcopy(p), copy.copy(p)):
        assert len(other) == len(p) and not np.shares_memory(other.position, p.position)
        for name, values in arrays.items():
            assert np.array_equal(getattr(other, name), values) and name in ("fractions",) or getattr(other, name).dtype == values.dtype
        assert np.array_equal(other.solid, p.solid) and np.array_equal(other.body, p.body) and other.fractions[0].max() > 0.05
    del arrays["mass"]
    for state in ((p.as_dict(), [1]), (arrays, []), ({**p.as_dict(), "mass": np.zeros(3)}, []), ({**p.as_dict(), "mass": "heavy"}, [])):
        with pytest.raises((TypeError, KeyError, ValueError, RuntimeError)):
            meltsim.Particles.__new__(meltsim.Particles).__setstate__(state)
    with pytest.raises(TypeError, match="another version"):
        meltsim.Totals.__new__(meltsim.Totals).__setstate__((1, 2))
    shape = Shape.sphere((0, 0, 0), 1) - Shape.box((0, 0, 0), (1, 1, 1))
    assert copy.copy(shape) is copy.deepcopy({"shape": shape})["shape"] is shape  # nothing changes it


def test_what_views_a_world_says_what_it_is():
    world = bath()
    state, pack, surface, mesh = world.state(), world.render_view(), world.surface_view("solids"), world.surface("liquid")
    assert repr(state) == "<meltsim.State: 135 particles at t = 0 s, cpu>" and repr(pack) == "<meltsim.RenderPack: 135 particles, cpu>"
    assert repr(mesh) == f"<meltsim.Surface: {len(mesh.position)} vertices, {len(mesh.triangles)} triangles>"
    assert re.fullmatch(r"<meltsim.SurfaceView: \d+ vertices, \d+ triangles, cpu, no longer there>", repr(surface))  # there is a later one
    assert "no longer" not in repr(world.surface_view())
    world.step(0.01)
    world.render_view()
    assert repr(state).endswith("cpu, no longer there>") and repr(pack).endswith("no longer there>")
    kept = []
    world.add_stage("keeps", kept.append)
    world.step(1e-4)
    assert repr(kept[0]).endswith("no longer there>")
    world.close()
    assert all(repr(view).endswith("no longer there>") for view in (state, pack, surface))
    assert re.fullmatch(r"<meltsim.Page: 0.002 MB, 300 pixels high; .*>", repr(meltsim.Page("x" * 2000, 300)))


def test_warnings_are_those_of_one_world():
    one, other = World(spacing=0.1, backend="cpu"), World(spacing=0.1, backend="cpu")
    one.warnings.append("mine")
    assert one.warnings == ["mine"] and other.warnings == [] == World(spacing=0.1, backend="cpu").warnings


def test_a_stage_writes_what_it_may():
    world = bath()
    for channel in ("enthalpy", "id", "tag"):
        with pytest.raises(meltsim.Error, match=f'writes: a stage reads "{channel}" and cannot change it; it writes acceleration, velocity and position'):
            world.add_stage("heats", lambda state: None, writes=("acceleration", channel))
    with pytest.raises(meltsim.Error, match='channel "heat" does not exist'):
        world.add_stage("heats", lambda state: None, writes="heat")
    seen = []

    def stops(state):
        state.velocity[:, :3] = 0
        seen.append((state.enthalpy.flags.writeable, state.id.flags.writeable, state.velocity.flags.writeable))

    world.add_stage("stops", stops, reads=("velocity", "enthalpy"), writes=("velocity",), after="step.integrate")
    world.step(0.01)
    assert set(seen) == {(False, False, True)} and world.totals().kinetic == 0


def test_steps_within_a_budget_and_again():
    one, other = bath(), bath()
    taken = one.step_within(0.05, 1e9)
    assert taken.owed == 0 and taken.substeps == taken.planned and not taken.over_budget
    assert other.step_part(0.05, taken.substeps).substeps == taken.substeps
    assert one.state_hash() == other.state_hash()
    starved = one.step_within(0.05, 1e-9)
    assert starved.substeps == 1 and starved.over_budget
    assert starved.simulated + starved.owed == pytest.approx(0.05)
    with pytest.raises(meltsim.Error, match="milliseconds"):
        one.step_within(0.05, 0)
    with pytest.raises(meltsim.Error, match="substeps"):
        one.step_part(0.05, -1)


def test_the_sun_warms_a_pool():
    world = World(spacing=0.1, domain=((0, 0, 0), (0.6, 0.8, 0.6)), heat_time_scale=1e4,
                  heat_free_surface={"flux": 800})
    world.add_material("water")
    world.add_fluid(Shape.box((0, 0, 0), (0.6, 0.3, 0.6)), "water", temperature=60)
    world.step(0.01)
    # 0.36 m^2, a sixth of which is along walls: docs/runner.md has the errors of the area.
    assert world.totals().heat_in / (800 * 0.36 * 0.01 * 1e4) == pytest.approx(1, abs=0.1)
    world.set_free_surface_heat()
    before = world.totals().heat_in
    world.step(0.01)
    assert world.totals().heat_in == before


@pytest.mark.parametrize("kept", ["pass", "position = state.position"])
def test_nothing_of_a_world_is_left_at_the_end(kept):
    """What a stage raised holds its frames, these the state and its arrays, these the World, and that the stage."""
    script = f"""
import meltsim
world = meltsim.World(spacing=0.1)
world.add_fluid(meltsim.Shape.box((0, 0, 0), (0.3, 0.3, 0.3)), world.add_material("water"))
world.step(0.001)
views = world.state(), world.render_view(), world.particles()
del views
def stage(state):
    {kept}
    raise ValueError("kept")
world.add_stage("raises", stage)
try:
    world.step(0.001)
except ValueError as error:
    kept = error
"""
    done = subprocess.run([sys.executable, "-B", "-c", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "leaked" not in done.stderr, done.stderr
