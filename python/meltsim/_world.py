# SPDX-License-Identifier: Apache-2.0
"""World: the compiled one, with scenes, runs and pages on top."""
from __future__ import annotations

import difflib
import html
import json
import math
import os
import reprlib
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, SupportsFloat

from . import _core
from ._error import Error


if TYPE_CHECKING:
    from typing_extensions import Self


class Page:
    """A replay in a notebook."""

    def __init__(self, text: str, height: int):
        self.text = text
        self.height = height

    def __repr__(self) -> str:
        return f"<meltsim.Page: {len(self.text) / 1e6:.2g} MB, {self.height} pixels high; shown at the end of a notebook's cell>"

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{html.escape(self.text)}" width="100%" height="{self.height}" '
                'style="border:0" sandbox="allow-scripts"></iframe>')


def _plain(value: Any) -> Any:
    """What json cannot write: arrays and numbers of NumPy, paths, mappings that are no dict."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{value!r} ({type(value).__name__}) has no place in a scene")


def _faults(value: Any, path: str, above: tuple[int, ...]) -> Iterator[str]:
    """What json refuses in a value, with its path."""
    if isinstance(value, float):
        if not math.isfinite(value):
            yield f'{path}: {value} is not finite; leave it out, or write "never" for a melting point'
        return
    if value is None or isinstance(value, (bool, int, str)):
        return
    if id(value) in above:
        yield f"{path}: contains itself"
        return
    if len(above) > 100:
        yield f"{path[:40]}...: is nested more than 100 deep"
        return
    above += (id(value),)
    if isinstance(value, Mapping):
        for key, item in value.items():
            if key is None or isinstance(key, (str, int, float)):
                yield from _faults(item, f"{path}.{key}" if above[1:] else f"{path}: {key}", above)
            else:
                yield f"{path}: a key: expected a string, got {key!r} ({type(key).__name__})"
    elif isinstance(value, (list, tuple)):
        for k, item in enumerate(value):
            yield from _faults(item, f"{path}[{k}]", above)
    else:
        try:
            value = _plain(value)
        except TypeError as error:
            yield f"{path}: {error}"
        else:
            yield from _faults(value, path, above)


def _json(value: Any, name: str) -> str:
    """A scene, or a part of it, as text."""
    try:
        return json.dumps(value, default=_plain, allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        fault = next(_faults(value, name, ()), f"{name}: {error}")
        if isinstance(error, TypeError):
            raise TypeError(fault) from None
        raise Error(fault, "invalid_argument") from None


def _is_boolean(value: Any) -> bool:
    """Whether it is a bool, of NumPy, too."""
    of_numpy = type(value).__module__ == "numpy" and getattr(value, "ndim", 1) == 0
    return isinstance(value, bool) or of_numpy and value.dtype.kind == "b"


def _number(name: str, value: Any) -> float:
    if isinstance(value, (str, bytes)) or _is_boolean(value) or not hasattr(value, "__float__") and not hasattr(value, "__index__"):
        raise TypeError(f"{name}: expected a number, got {value!r} ({type(value).__name__})")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise TypeError(f"{name}: expected a number, got {value!r} ({type(value).__name__})") from error


def _boolean(name: str, value: Any) -> bool:
    if not _is_boolean(value):
        raise TypeError(f"{name}: expected True or False, got {value!r} ({type(value).__name__})")
    return bool(value)


_SETTINGS: tuple[str, ...] = getattr(_core, "_world_settings")  # no stub has it

#: What changes an argument of World(...) afterwards; the others stay.
_SETTERS = {"domain": "set_wall_heat(...) for the heat of its faces", "gravity": "set_gravity(...)", "heat_time_scale": "set_heat_time_scale(...)",
            "heat_free_surface": "set_free_surface_heat(...)", "heat_interval": 'set_interval("thermal", ...)'}


def _assigned_in_vain(name: str) -> str:
    """Why World has nothing of this name that could be assigned."""
    if name in _SETTINGS:
        if name in _SETTERS:
            return f"{name}: cannot be assigned; call {_SETTERS[name]}"
        return f"{name}: cannot be assigned; it is an argument of World(...), or of World.load(..., set=...), and stays"
    if callable(getattr(World, name, None)):
        return f"{name}: is a method; call {name}(...)"
    if hasattr(World, name):
        return f"{name}: can be read only"
    known = [*World._assignable, *_SETTINGS, *(k for k in dir(World) if not k.startswith("_"))]
    near = difflib.get_close_matches(name, known, 1)
    meant = "" if not near else f'; did you mean "{near[0]}"?' if near[0] in World._assignable else f"; {_assigned_in_vain(near[0])}"
    return f'World has no attribute "{name}"{meant}'


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


class World(_core.World):
    """One simulation. It is used by one thread at a time; Worlds are independent of each other.

    Of a World itself only ``end``, ``fps`` and ``warnings`` can be assigned: any other name would be kept without an effect, such as ``gravity`` beside
    ``set_gravity()``. A class of your own that is derived from World has attributes of its own, but for arguments of World that it does not define: these
    would look like settings.
    """

    _assignable = ("end", "fps", "warnings")
    end: float | None = None
    """When run() without seconds ends [s]: of a scene; None: nobody said."""
    fps: float = 25.0

    @property
    def warnings(self) -> list[str]:
        """What looks like a slip in its scene."""
        texts: list[str] = self.__dict__.setdefault("_warnings", [])
        return texts

    @warnings.setter
    def warnings(self, texts: list[str]) -> None:
        self._warnings = texts

    if not TYPE_CHECKING:  # a type checker would take any name then

        def __setattr__(self, name: str, value: Any) -> None:
            if not name.startswith("_") and name not in World._assignable and not self._own(name):
                raise AttributeError(_assigned_in_vain(name))
            super().__setattr__(name, value)

    def _own(self, name: str) -> bool:
        """Whether a class derived from World may have an attribute of this name."""
        if type(self) is World:
            return False
        derived = type(self).__mro__[:type(self).__mro__.index(World)]
        return name not in _SETTINGS or any(name in vars(c) or name in vars(c).get("__annotations__", ()) for c in derived)

    @classmethod
    def load(cls, scene: str | os.PathLike[str] | Mapping[str, Any], *, set: Mapping[str, Any] | None = None, scale: float = 1.0,
             backend: str = "automatic", precision: str = "single", threads: int = 0) -> World:
        """Makes the World of a scene: a YAML or JSON file, the name of a built-in scene, or a dict with the same keys.

        Parameters
        ----------
        scene : the scene; docs/runner.md has its keys, ``meltsim.scenes()`` the built-in names
        set : changes by path: ``{"bodies[0].temperature": -5}``
        scale : linear resolution; 0.5 makes an eighth of the particles
        backend, precision, threads : as of World
        """
        if set is not None and not isinstance(set, Mapping):
            raise TypeError(f'set: expected a dict such as {{"particles.spacing": 0.1}}, got {set!r}')
        changes = [f"{path}={_json(value, f'set[{path!r}]')}" for path, value in (set or {}).items()]
        if isinstance(scene, Mapping):
            source, is_text = _json(scene, "scene"), True
        elif isinstance(scene, (str, os.PathLike)):
            source, is_text = os.fspath(scene), False
            if source == "-":
                raise TypeError("scene: standard input is for the program meltsim; pass a file, a name or a dict")
        else:
            hint = "; World.load_saved() takes what save() gave" if isinstance(scene, (bytes, bytearray, memoryview)) else ""
            raise TypeError("scene: expected a file, the name of a built-in scene or a dict, "
                            f"got {reprlib.repr(scene)} ({type(scene).__name__}){hint}")
        loaded = _core.Scene(source, is_text, changes, _number("scale", scale))
        world = cls(loaded, backend, precision, threads)
        world.end, world.fps, world.warnings = loaded.end, loaded.fps, loaded.warnings
        return world

    def run(self, seconds: SupportsFloat | None = None, *, fps: SupportsFloat | None = None,
            each: Callable[[World], Any] | None = None, record: bool = True) -> _core.StepResult:
        """Steps for so many seconds (default: to the end of the scene; nothing where that is reached) and records a frame for show() `fps` times a second.

        ``each(world)`` is called after every frame; it ends the run by returning False. Returns the report on the last frame. Raises Error with code "halted" if the
        simulation diverges. Frames stay until clear_frames(); record=False keeps none.
        """
        length = self._left() if seconds is None else _number("seconds", seconds)
        rate = _number("fps", self.fps if fps is None else fps)
        kept = _boolean("record", record)
        if not (math.isfinite(length) and length >= 0):
            raise Error(f"seconds: expected a time from 0, got {length:g}", "invalid_argument")
        if not (math.isfinite(rate) and rate > 0):
            raise Error(f"fps: expected a number above 0, got {rate:g}", "invalid_argument")
        if each is not None and not callable(each):
            raise TypeError(f"each: expected a function of the World, got {each!r} ({type(each).__name__})")
        self.prepare()
        start = self.time
        if self.steps == 0 and kept:
            self.record()
        result = self.synchronize()
        frames = max(1, math.ceil(length * rate - 1e-9)) if length > 0 else 0
        for k in range(1, frames + 1):
            result = self._run_to(start + min(k / rate, length))
            if kept:
                self.record()
            if each is not None and each(self) is False:
                break
        return result

    def _left(self) -> float:
        """Seconds to the end of the scene."""
        now = self.time
        if self.end is None:
            raise Error("seconds: this World has no end, since it was not loaded from a scene; pass the seconds to run", "invalid_argument")
        left = self.end - now
        return left if left >= 1e-9 * self.end else 0.0  # there, to the rounding of a sum of sub-steps, or past it

    def _run_to(self, target: float) -> _core.StepResult:
        # No step may take more than max_substeps.
        parts = max(1, math.ceil((target - self.time) / (self.stable_dt() * self.max_substeps * 0.9)))
        for part in range(parts):
            self.step((target - self.time) / (parts - part))
        result = self.synchronize()
        if result.halted:
            raise Error(result.halt_reason, "halted")
        return result

    def show(self, path: str | os.PathLike[str] | None = None, *, title: str = "", height: int = 640) -> Page | Path:
        """The recorded frames as a page that plays in a browser: within a notebook, elsewhere as a file (default
        ``meltsim.html``), whose path it returns. Without frames it records the present state first."""
        if self.frames == 0:
            self.record()
        page: str = getattr(self, "_page")(title)  # no stub has it
        if path is None and _in_notebook():
            return Page(page, height)
        file = Path("meltsim.html" if path is None else path)
        file.write_text(page, encoding="utf-8")
        return file

    def __enter__(self) -> Self:
        self.time  # refused where it is closed
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Closes the World. Where an error leaves the block, whose frames may hold arrays of it, it then stays as long as these."""
        try:
            self.close()
        except Error:
            if error is None:
                raise

    def __repr__(self) -> str:
        if self.closed:
            return "<meltsim.World: closed>"
        return f"<meltsim.World: {self.backend}, t = {self.time:g} s, spacing {self.spacing:g} m, {len(self.bodies)} bodies>"
