# SPDX-License-Identifier: Apache-2.0
"""What scripts pass to the package, and what they find again: numbers of NumPy, names, frames, types."""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import meltsim
from meltsim import Shape, World


def bath(**settings):
    """A block of ice over warm water, and a tool that is moved."""
    world = World(0.1, domain=((0, 0, 0), (0.6, 0.9, 0.6)), backend="cpu", threads=1, **settings)
    world.add_material("water", viscosity=0.2)
    world.add_material("ice", density=917, melting_point=0, latent_heat=3.34e5, becomes="water")
    world.add_fluid(Shape.box((0, 0, 0), (0.6, 0.3, 0.6)), "water", temperature=40)
    world.add_solid(Shape.box((0.1, 0.4, 0.1), (0.4, 0.7, 0.4)), "ice", name="block", temperature=-10)
    world.add_solid(Shape.box((0.5, 0.7, 0.5), (0.6, 0.8, 0.6)), "ice", name="tool", motion="kinematic", max_speed=1, temperature=-10)
    return world


def scene(probes):
    return World.load({
        "meltsim": 1, "particles": {"spacing": 0.1}, "domain": {"min": [0, 0, 0], "max": [0.6, 0.9, 0.6]}, "time": {"end": 1},
        "materials": {"water": {}, "steel": {"density": 2000}}, "fluids": [{"shape": {"box": [[0, 0, 0], [0.6, 0.3, 0.6]]}, "material": "water", "temperature": 30}],
        "bodies": [{"name": "tool", "shape": {"box": [[0.3, 0.5, 0.3], [0.5, 0.7, 0.5]]}, "material": "steel", "motion": "kinematic", "max_speed": 1}],
        "probes": probes}, backend="cpu", threads=1)


def flow(change):
    """Kinetic energy of a column that collapses."""
    world = World(0.1, domain=((0, 0, 0), (0.6, 0.6, 0.6)), backend="cpu", threads=1)
    world.add_material("water", viscosity=0.2)
    change(world)
    world.add_fluid(Shape.box((0, 0, 0), (0.3, 0.4, 0.6)), "water")
    world.step(0.1)
    return world.ledger().kinetic


@pytest.mark.parametrize("name", ["density", "viscosity", "conductivity", "heat_capacity", "yield_stress", "solubility"])
def test_an_array_without_axes_is_a_number(name):
    world = bath()
    value = 0.5 if name == "solubility" else 500.
    more = {"dissolves_in": "water", "diffusivity_in": 1e-9} if name == "solubility" else {}
    world.add_material("m", **{name: np.array(value)}, **more)
    world.add_material("t", **{name: np.array([[0, value], [50, value / 2]])}, **more)
    for wrong in ([], np.array([]), np.zeros((0, 2))):
        with pytest.raises(meltsim.Error, match=f"{name}: expected a number or pairs of .temperature, value., got a table without any"):
            world.add_material("e", **{name: wrong}, **more)
    for wrong in ({}, {20: value}, {1, 2}, b"12", [1, 2], np.array("a"), True, np.True_):
        with pytest.raises(TypeError, match=f"{name}: expected a number"):
            world.add_material("e", **{name: wrong}, **more)
    assert list(world.materials) == ["water", "ice", "m", "t"]


def test_a_table_and_a_number_replace_each_other():
    thin, thick = flow(lambda w: None), flow(lambda w: w.set_material("water", viscosity=5))
    assert thick < 0.95 * thin
    assert flow(lambda w: w.set_material("water", viscosity=np.array(5.))) == thick

    def there_and_back(world):
        world.set_material("water", viscosity=[(0, 5), (100, 5)])
        world.set_material("water", viscosity=0.2)

    assert flow(there_and_back) == thin


def test_vectors_are_lists_and_arrays_and_nothing_else():
    world = bath()
    world.set_motion("tool", position=np.array([0.5, 0.7, 0.5], np.float32), velocity=[np.float32(0), np.array(0.), 0])
    world.set_gravity(np.array([0, -9, 0]))
    for wrong in ({0.5: 1, 0.7: 2, 0.6: 3}, {0.5, 0.7, 0.6}, b"abc", np.array(3.), "abc"):
        with pytest.raises(TypeError, match="position: expected three numbers"):
            world.set_motion("tool", position=wrong)
    with pytest.raises(TypeError, match="orientation: expected four numbers"):
        world.set_motion("tool", orientation={1: 0, 2: 0, 3: 0, 4: 0})
    with pytest.raises(TypeError, match="fields: expected a list of strings"):
        world.add_probe([(0.3, 0.1, 0.3)], {"temperature": 1})
    world.add_material("steel", density=2000)
    world.add_solid(Shape.box((0, 0.8, 0), (0.1, 0.9, 0.1)), "steel", motion="proxy", mass=1, inertia=[np.array(1.), np.array(1.), np.array(1.)])


def test_a_bool_of_numpy_is_one():
    world = bath(tension=np.False_)
    yes = np.array([1., 2.])[1] > 1
    assert type(yes) is not bool
    world.watch_forces("tool", yes)
    world.set_motion("tool", position=(0.5, 0.75, 0.5), teleport=yes)
    world.hold("block", yes)
    world.hold("block", np.array(False))
    world.enable("topology", np.False_)
    world.enable("topology", yes)
    world.enable_timings(np.False_, every=np.int64(100))
    world.add_stage("none", lambda state: None, recorded=np.False_)
    world.add_force_field("uniform", acceleration=(0, 0, 0), bodies=np.False_)
    world.set_interval("topology", np.int32(1))
    world.save_state(np.int64(1))
    world.run(np.float32(0.01), record=np.False_)
    calls = [("on", lambda x: world.watch_forces("tool", x)), ("on", lambda x: world.hold("block", x)), ("on", lambda x: world.enable("topology", x)),
             ("on", lambda x: world.enable_timings(x)), ("teleport", lambda x: world.set_motion("tool", teleport=x)), ("record", lambda x: world.run(0.01, record=x)),
             ("recorded", lambda x: world.add_stage("other", lambda state: None, recorded=x)), ("wait", lambda x: world.render_view(wait=x))]
    for name, call in calls:
        for wrong in (1, "yes", 1.0, np.float64(1), np.array([True])):
            with pytest.raises(TypeError, match=f"^{name}: expected True or False, got {re.escape(repr(wrong))}"):
                call(wrong)
    with pytest.raises(TypeError, match="slot: expected an integer, got 0.5"):
        world.save_state(0.5)
    with pytest.raises(TypeError, match="seconds: expected a number or None, got 'long'"):
        world.settle("long")
    with pytest.raises(TypeError, match="seconds: expected a number, got"):
        world.step(yes)


def test_probes_of_a_scene_are_removed_by_name():
    world = scene([{"name": "load", "kind": "force", "body": "tool", "fields": ["force"]}, {"name": "low", "at": [0.5, 0.1, 0.5], "fields": ["temperature"]},
                   {"name": "high", "at": [0.2, 0.2, 0.5], "fields": ["temperature"]}])
    mine = world.add_probe([(0.3, 0.1, 0.3), (0.3, 0.2, 0.3)], ["temperature"], name="mine")
    assert set(world.probes) == {"load", "low", "high", "mine"} and world.probes["mine"] == mine
    assert len({world.probes["low"], world.probes["high"]}) == 2
    world.step(0.01)
    saved = world.save()
    with pytest.raises(meltsim.Error, match="probe"):
        world.load_saved(saved)
    world.remove("load")
    assert "load" not in world.probes and set(world.take_samples()) == {"low", "high", "mine"}
    world.load_saved(saved)
    low = world.probes["low"]
    world.remove("low")  # the World's probe has the other point
    world.step(0.01)
    samples = world.take_samples()
    assert set(samples) == {"high", "mine"} == set(world.probes) and samples["mine"]["values"].shape[1:] == (2, 1)
    assert samples["high"]["values"].shape[1:] == (1, 1) and np.allclose(samples["high"]["values"], 30)
    with pytest.raises(meltsim.Error, match='"low": was removed already'):
        world.remove(low)
    world.add_probe([(0.5, 0.1, 0.5)], ["temperature"], name="low")
    world.remove(world.probes["high"])
    world.add_probe([(0.5, 0.1, 0.5)], ["temperature"], name="high")
    world.step(0.01)
    assert set(world.take_samples()) == {"mine", "low", "high"} == set(world.probes)
    world.remove(mine)
    world.remove("low")
    world.remove("high")
    assert world.probes == {} == world.take_samples()
    with pytest.raises(meltsim.Error, match='no body, force field, heat region or probe is named "high"; there are: tool'):
        world.remove("high")


def test_what_is_removed_by_name_is_one_thing():
    world = bath()
    world.add_force_field("uniform", acceleration=(0, 0, 0), name="wind")
    world.add_heat_region(Shape.box((0, 0, 0), (1, 1, 1)), name="oven", source=1)
    world.add_probe([(0.3, 0.1, 0.3)], ["temperature"], name="block")
    world.remove("wind")
    world.remove("oven")
    assert world.force_fields == {} == world.heat_regions
    with pytest.raises(meltsim.Error, match='a body and a probe are named "block"; pass the one that you mean: world.bodies..block.. or world.probes..block..'):
        world.remove("block")
    world.remove(world.probes["block"])
    world.remove("block")
    world.add_emitter((0.3, 0.7, 0.3), "water", radius=0.1, speed=1, until=1.0, name="tap")
    with pytest.raises(meltsim.Error, match="an emitter cannot be removed; set_emitter"):
        world.remove(world.emitters["tap"])
    with pytest.raises(TypeError, match="remove: expected a body, a force field, a heat region or a probe of this World"):
        world.remove(3)
    with pytest.raises(TypeError, match="emitter: expected an emitter of this World"):
        world.set_emitter(3, on=True)


def test_bodies_are_those_that_are_there():
    world = bath()
    world.step(0.01)
    before = world.snapshot()
    world.remove("block")
    assert list(world.bodies) == ["tool"] and "1 bodies" in repr(world)
    with pytest.raises(meltsim.Error, match="was removed"):
        world.hold("block")
    with pytest.raises(meltsim.Error, match="there are: tool$"):
        world.hold("blok")
    with pytest.raises(meltsim.Error, match="already"):
        world.add_solid(Shape.box((0.1, 0.4, 0.1), (0.4, 0.7, 0.4)), "ice", name="block")
    after = world.snapshot()
    world.restore(before)  # where it is there
    assert set(world.bodies) == {"block", "tool"}
    world.compact()
    assert set(world.bodies) == {"block", "tool"} == {piece.name for piece in world.pieces()}
    other = bath()
    other.step(0.01)
    other.restore(after)
    assert list(other.bodies) == ["tool"]


def test_frames_are_kept_as_told(tmp_path):
    world = bath()
    start = world.snapshot()
    world.run(0.08)
    assert world.frames == 3
    world.restore(start)
    assert world.frames == 3  # frames are not part of the state
    world.clear_frames()
    seen = []
    steps = world.run(0.08, record=False, each=lambda w: seen.append(w.time)).steps
    assert world.frames == 0 and len(seen) == 2 and steps == world.steps
    world.record()
    assert world.frames == 1
    page = world.show(tmp_path / "page.html").read_text()
    assert "1 frames were recorded" in page
    world.add_stage("late", lambda state: world.clear_frames())
    with pytest.raises(meltsim.Error, match="in use"):
        world.step(0.01)


def test_a_stage_changes_what_it_declares_alone():
    world = bath()
    seen = []

    def pushes(state):
        state.acceleration[:, 0] += 1
        seen.append([getattr(state, name).flags.writeable for name in ("acceleration", "velocity", "position")])
        state.velocity[:, 1] += 0.5

    world.add_stage("pushes", pushes, writes="acceleration")
    with pytest.raises(ValueError, match="read-only"):
        world.step(0.01)
    assert seen == [[True, False, False]]
    world.remove_stage("pushes")
    world.add_stage("pushes", pushes, writes=("acceleration", "velocity"))
    world.step(0.001)
    assert seen[-1] == [True, True, False]


def test_messages_are_in_words_of_python():
    world = bath()
    with pytest.raises(meltsim.Error, match='build it with motion="kinematic"'):
        world.set_motion("block", velocity=(0, 1, 0))
    with pytest.raises(meltsim.Error, match='build it with motion="proxy"'):
        world.set_proxy("block", position=(0, 0, 0))
    world.hold("block")
    with pytest.raises(meltsim.Error, match=r"let it go with hold\(body, False\) first"):
        world.apply_impulse("block", (1, 0, 0))
    world.step(0.1)
    with pytest.raises(meltsim.Error, match="does not move the clock.*; take a longer step$"):
        world.step(1e-20)


def test_the_ledger_says_what_a_teleport_displaced():
    world = bath()
    world.set_motion("tool", position=(0.3, 0.15, 0.3), teleport=True)
    world.step(0.01)
    ledger = world.ledger()
    assert ledger.displaced > 0 and ledger.displaced_work != 0 and ledger.as_dict()["displaced"] == ledger.displaced


TYPED = """
from __future__ import annotations
from typing import Any
import numpy as np
import meltsim
from meltsim import Body, Shape, World

def use(world: World, tool: Body, on: np.bool_) -> float:
    a = np.zeros(3)
    world.set_motion("tool", position=a, orientation=np.array([1., 0, 0, 0]), teleport=on)
    world.set_motion(tool, position=[0.1, 0.2, 0.3], velocity=(1, 0, 0))
    world.set_gravity(a)
    world.set_velocity("x", a)
    world.apply_impulse("x", (np.float32(1), 0, 0))
    for step in (np.float32(0.1), np.float64(0.1), 0.1, 1):
        world.step(step)
    world.add_material("m", viscosity=np.array(5.), density=[(0.0, 1e3), (80.0, 9e2)], conductivity=np.zeros((2, 2)), color=a)
    world.add_fluid(Shape.box(a, (1, .3, 1)), "water", temperature=np.float32(20), fractions={"sugar": 0.1})
    world.add_solid(Shape.sphere(a, np.float32(1)) | Shape.unite(), "m", surface={"flux": 1}, growth=np.int64(1), carve=on)
    world.add_probe(a.reshape(1, 3), ["temperature"])
    world.hold(tool, on)
    world.enable("thermal", on)
    world.run(np.float32(0.1), fps=np.int64(3), record=False)
    world.remove(world.probes["gauge"])
    forces: dict[str, meltsim.Forces] = world.take_forces()
    values: dict[str, Any] = world.ledger().as_dict()
    low, high = Shape.box(a, a).bounds
    return world.take_forces()["tool"]["impulse"][1] + forces["tool"]["heat"] + low[0]

World(0.1, domain=(np.zeros(3), (1, 1, 1)), gravity=np.zeros(3), tension=np.False_, threads=np.int64(1))
"""
WRONG = ['world.step("a")', "world.set_gravity(3)", 'world.hold("a", "yes")', 'world.take_forces()["a"]["impuls"]', 'world.remove(world.emitters["a"])']


def mypy(tmp_path, *arguments):
    pytest.importorskip("mypy")
    environment = {**os.environ, "MYPYPATH": str(Path(meltsim.__file__).parent.parent)}
    return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path.parent / "mypy"), *arguments], env=environment, cwd=tmp_path,
                          capture_output=True, text=True)


@pytest.mark.skipif(not Path(meltsim.__file__).with_name("_core.pyi").exists(), reason="no type stubs were built")
def test_type_checkers_take_ordinary_calls(tmp_path):
    (tmp_path / "typed.py").write_text(TYPED + "\ndef wrong(world: World) -> None:\n" + "".join(f"    {line}\n" for line in WRONG))
    said = mypy(tmp_path, "-p", "meltsim", "-p", "typed")
    first = TYPED.count("\n") + 3
    faults = [line for line in said.stdout.splitlines() if ": error:" in line]
    assert [f.split(":")[1] for f in faults] == [str(first + k) for k in range(len(WRONG))], said.stdout + said.stderr


def test_liquid_comes_to_rest_before_the_first_step():
    with pytest.raises((meltsim.Error, TypeError), match="settle"):  # of scenes; here it is a call, when all is there
        meltsim.World(spacing=0.1, settle=1.0)
    world = bath()
    was = world.particles()
    rest = world.settle()
    assert rest.substeps > 0 and rest.seconds > 0 and 0 < rest.farthest < 0.05
    assert world.time == 0
    assert np.array_equal(world.particles().velocity, was.velocity)
    assert world.settle(seconds=0.01).seconds == pytest.approx(0.01)
    with pytest.raises(meltsim.Error, match="settle: seconds"):
        world.settle(-1)
    world.step(0.01)
    with pytest.raises(meltsim.Error, match="before the first"):
        world.settle()


def test_numbers_do_not_follow_the_locale_of_the_host(tmp_path):
    """A host that writes 0,5: scenes, the page and errors keep their points."""
    made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", str(tmp_path / "de_DE.UTF-8")], capture_output=True) if shutil.which("localedef") else None
    if not (tmp_path / "de_DE.UTF-8").exists():
        pytest.skip("no locale with a comma can be made here: " + ("no localedef" if made is None else made.stderr.decode()[-200:]))
    program = """
import json, locale, re, sys
locale.setlocale(locale.LC_ALL, sys.argv[1])
assert locale.localeconv()["decimal_point"] == sys.argv[2]
import meltsim
world = meltsim.World.load("ice_block", backend="cpu", threads=1)
world.run(0.1)
world.show("page.html")
try:
    world.add_fluid(meltsim.Shape.sphere((0.25, 0.5, 0.5), -0.05), "water")
except meltsim.Error as error:
    print(error)
try:
    world.add_material("thin", viscosity=-0.05)
except meltsim.Error as error:
    print(error)
print(open("page.html").read().count("null"), world.state_hash())
"""
    said = []
    for name, point in (("C", "."), ("de_DE.UTF-8", ",")):
        run = subprocess.run([sys.executable, "-c", program, name, point], capture_output=True, text=True, cwd=tmp_path, env={**os.environ, "LOCPATH": str(tmp_path)})
        assert run.returncode == 0, run.stderr
        said.append((run.stdout, (tmp_path / "page.html").read_bytes()))
    assert "-0.05" in said[0][0]
    assert said[1] == said[0]
