"""Hostile values of arguments, and the public callables that must refuse them with clear errors.

The callables come from ``__all__`` of the packages, so new ones are included. A required argument
needs a value in ``VALID``. Callables that need no test are in ``EXEMPT``.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import random
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import is_dataclass
from functools import partial
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from agents import GreedyAgent
from agents.drive import Follower
from agents.fleet import PlannedFleet, Team
from agents.learning import DriveNetwork, DrivePolicy
from agents.mapf.circulation import Circulation
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from agents.mapf.windows import WindowedPlanner
from agents.registry import AGENTS
from agents.search import RouteProblem
from helpers.networks import random_moves, random_network
from warehouse_core import (
    DEFAULT_LAYOUT,
    FleetEnv,
    GridMotion,
    Layout,
    Motion,
    Order,
    OrderQueue,
    OrderStream,
    WarehouseEnv,
    WarehouseError,
    record_episode,
)
from warehouse_core.batch.array_env import ArrayEnv
from warehouse_core.fleet import Battery, People
from warehouse_core.motion import BaseBatchMotion, BaseMotion
from warehouse_core.pettingzoo_env import parallel_env
from warehouse_core.viz.tracks import track_of_record
from warehouse_core.wording import brief
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, RobotSpec, Stop
from warehouse_physics.drive import DriveEnv

PACKAGES = ("warehouse_core", "warehouse_physics", "agents")

MAX_MESSAGE = 1000
"""Largest number of characters of a message."""

MAX_MEMORY = 500_000_000
"""Bytes that a call may add to the process."""


class Raises:
    """An object whose conversions all fail with an undocumented error."""

    def fail(self, *_: object) -> Any:
        raise RuntimeError("conversion of a hostile object")

    __index__ = __int__ = __float__ = __len__ = __iter__ = __eq__ = __bool__ = fail
    __array__ = __getitem__ = __repr__ = __str__ = __hash__ = fail  # type: ignore[assignment]


class Lies:
    """An integer that is different each time it is read."""

    number = 0

    def __index__(self) -> int:
        self.number += 1
        return self.number

    def __float__(self) -> float:
        return float(self.__index__())


class Bulky:
    """An object with a very long repr."""

    def __repr__(self) -> str:
        return "x" * 600_000


HOSTILE: dict[str, Callable[[], Any]] = {
    "0": lambda: 0,
    "-7": lambda: -7,
    "10**9": lambda: 10**9,
    "2**63": lambda: 2**63,
    "5,000 digits": lambda: 10**5000,
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "0.5": lambda: 0.5,
    "1e-320": lambda: 1e-320,
    "1e308": lambda: 1e308,
    "1j": lambda: 1j,
    "True": lambda: True,
    "None": lambda: None,
    "int64": lambda: np.int64(-(2**62)),
    "float32": lambda: np.float32("nan"),
    "array": lambda: np.arange(6.0).reshape(2, 3),
    "array of objects": lambda: np.array([None, "x"], object),
    "bytes": lambda: b"\xff\x00",
    "empty text": lambda: "",
    "text": lambda: "x",
    "lone surrogate": lambda: "\ud800\x00\x1b[2J",
    "600 kB of text": lambda: "x" * 600_000,
    "nested list": lambda: [[[[1]]], "x"],
    "long list": lambda: [0] * 100_000,
    "dict": lambda: {"x": 1, 2: None},
    "generator": lambda: (number for number in range(3)),
    "function": lambda: len,
    "object": object,
    "raises": Raises,
    "lies": Lies,
    "bulky": Bulky,
}
"""Functions that create a value for each call, by the name of the value."""

RECORD = record_episode(WarehouseEnv(max_steps=2), GreedyAgent(0), seed=0)

LAYERS = [(np.zeros((b, a)), np.zeros(b)) for a, b in ((29, 8), (8, 8), (8, 2))]
"""Layers of a network that controls a body."""

VALID: dict[str, Any] = {
    "action": 4,
    "actions": [4, 4],
    "agent": GreedyAgent(0),
    "agents": [GreedyAgent(0)] * 2,
    "aisle": 1,
    "at": 1.0,
    "battery": 200,
    "columns": 2,
    "count": 2,
    "FleetRecorder.env": FleetEnv(),
    "achieved_goal": (0.1, 0.1, 0.0),
    "density": 0.2,
    "depth": 1,
    "desired_goal": (0.5, 0.6, 1.0),
    "backend": "grid",
    "env": WarehouseEnv(),
    "Follower.env": DriveEnv(),
    "DriveEnv.step.action": [0.0, 0.0],
    "DriveVectorEnv.step.actions": [[0.0, 0.0]],
    "DriveEnv.from_name.name": "drive",
    "DriveEnv.start_recording.agent": "x",
    "DriveEnv.start_recording.randomize": True,
    "DriveNetwork.backend": "drive",
    "layers": LAYERS,
    "DrivePolicy.network": DriveNetwork("drive", LAYERS),
    "episode": RECORD,
    "extent": (7, 12, 2, 200, 200),
    "cell": (1, 1),
    "cells": [(1, 1)],
    "fleet": 0,
    "graph": Graph(DEFAULT_LAYOUT),
    "fleets": 2,
    "frames": RECORD,
    "goal": (1, 2),
    "height": 7,
    "layout": DEFAULT_LAYOUT,
    "length": 2,
    "max_steps": 200,
    "name": "dict",
    "network": random_network(0),
    "CloneAgent.network": random_moves(0),
    "num_envs": 2,
    "order": None,
    "planner": PIBT(Graph(DEFAULT_LAYOUT)),
    "robot": 0,
    "rays": 4,
    "output_dir": "svg",
    "path": "x.map",
    "problem": RouteProblem(DEFAULT_LAYOUT, (1, 1), (1, 2)),
    "save_page.path": "x.html",
    "tracks": [track_of_record(RECORD)],
    "heuristic": lambda state: 0.0,
    "evaluate": lambda state, cost: cost,
    "weight": 1.0,
    "record": RECORD,
    "row": 0,
    "seed": 0,
    "rows": 2,
    "seconds": 1.0,
    "size": 3,
    "start": (1, 1),
    "table": {},
    "tile_pixels": 8,
    "width": 12,
}

EXEMPT = (
    "warehouse_core.task",  # pure functions of the rules, called in every step
    "warehouse_core.files",  # arrays that this project's own files consist of
    "warehouse_core.viz.axes",  # parts of this project's own drawings
    "warehouse_core.viz.export",
    "warehouse_core.render.PictureWindow",  # it needs a display
    "warehouse_core.Episode",  # made by recorders, and read from files
    "warehouse_core.world.load_",  # of files
    "agents.learning.load_",
    "agents.learning.save_table",  # what it saves has just been learned
    "warehouse_core.orders.save_orders",
    "warehouse_core.conformance",  # its checks call what they are given
    "warehouse_physics.batch",  # made by RigidBodyMotion.batch
)
"""Beginnings of the names of callables that are not tested."""

EXTRA: dict[str, dict[str, Any]] = {"FleetEnv": {"orders": [Order(0, 9, (1, 3), (5, 6))]}}
"""Further arguments for the objects whose methods are tested."""

DRAWN = ("replay_animation", "save_frames_to_svg")
"""Slow functions, which get only some of the values."""

FEW = ("-7", "5,000 digits", "1e-320", "raises", "bulky", "array")

SEAMS = {
    "act",
    "advance",
    "batch",
    "extend",
    "face",
    "fleet_batch",
    *(f"{motion.__name__}.reset" for motion in (GridMotion, RigidBodyMotion, DrivingMotion)),
}
"""Methods that this project's own code calls in every step, with arguments that it has checked."""

OPEN_TO_ALL = {
    "evaluate",
    "expand",
    "frames",
    "heuristic",
    "metrics",
    "on_reset",
    "output_dir",
    "path",
    "problem",
    "tracks",
    "with_events",
    "reopen",
}
"""Parameters for paths and for users' own objects, for which Python itself raises the errors."""

OTHER_NAMES = {
    "orders": ("rate",),
    "starts": ("start of robot",),
    "capacity": ("battery",),
    "count": ("people",),
    "actions": ("action",),
    "grid": ("layout", "rows", "tile"),
    "layout": ("rows", "tile"),
    "rows": ("layout", "tile"),
    "aisle": ("cells",),
    "height": ("size", "rows"),
    "width": ("size", "cells"),
    "beside": ("record",),
    "agents": ("needs one",),
    **dict.fromkeys(("floor_drag", "mass", "payload_mass"), ("motor_force",)),
    **dict.fromkeys(("cell_size", "turn_seconds"), ("time_step",)),
    "name": ("observation", "backend"),
    "max_cycles": ("max_steps",),
}
"""Other names of some arguments in messages, after the object that they become."""

PARTS = (OrderStream, People, Stop, Team)
"""Parts that are valid by themselves but may not fit a fleet, such as more people than cells."""


class Target(NamedTuple):
    """A public callable, and a function that uses its result or its object."""

    name: str
    call: Callable[..., Any]
    use: Callable[[Any], object]

    @property
    def parameters(self) -> dict[str, inspect.Parameter]:
        """Parameters that can be given by name."""
        kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
        given = inspect.signature(self.call).parameters
        return {name: each for name, each in given.items() if each.kind in kinds}

    @property
    def valid(self) -> dict[str, Any]:
        """Valid values of the parameters that have no default."""
        needed = (each.name for each in self.parameters.values() if each.default is each.empty)
        return {name: VALID.get(f"{self.name}.{name}", VALID.get(name)) for name in needed}


def targets() -> Iterator[Target]:
    """Yield the callables in ``__all__`` of the packages that check their own arguments."""
    seen: set[int] = set()
    for root in PACKAGES:
        package = importlib.import_module(root)
        modules = pkgutil.walk_packages(package.__path__, f"{root}.")
        for name in (root, *(module.name for module in modules if module.ispkg)):
            module = importlib.import_module(name)
            for word in getattr(module, "__all__", ()):
                each = getattr(module, word)
                if id(each) not in seen and not f"{name}.{word}".startswith(EXEMPT):
                    seen.add(id(each))
                    yield from _targets_of(word, each)


def named_targets() -> Iterator[Target]:
    """Yield the agents and planners that have a name in the registry."""
    for each in (*AGENTS.values(), PIBT, WindowedPlanner, Circulation):
        if inspect.isclass(each):
            yield Target(each.__name__, each, use)


def _targets_of(name: str, each: Any) -> Iterator[Target]:
    """Yield a function, or a class that checks its arguments and the methods of the class."""
    if inspect.isfunction(each):
        yield Target(name, each, use)
    if not inspect.isclass(each) or not _checks(each):
        return
    made = Target(name, each, use)
    yield made
    methods = inspect.getmembers(each, inspect.isfunction) if hasattr(each, "reset") else ()
    for word, method in methods:
        is_ours = method.__module__.startswith(PACKAGES)
        is_default = method.__qualname__.partition(".")[0] == BaseMotion.__name__
        if (
            is_ours
            and not is_default
            and not word.startswith("_")
            and not {word, f"{name}.{word}"} & SEAMS
        ):
            it = each(**made.valid | EXTRA.get(name, {}))
            use(it)
            yield Target(f"{name}.{word}", getattr(it, word), partial(_again, it))


def _checks(each: type) -> bool:
    """Return whether a class checks arguments: errors, interfaces and plain records do not."""
    is_interface = getattr(each, "_is_protocol", False) or each in (BaseMotion, BaseBatchMotion)
    if issubclass(each, (BaseException, tuple, dict)) or is_interface:
        return False
    if is_dataclass(each) and not hasattr(each, "__post_init__"):
        return not each.__dataclass_params__.init
    return each.__init__ is not object.__init__


def _again(it: Any, _: object) -> None:
    use(it)


def use(it: Any) -> None:
    """Start the result of a call and take a step, because an accepted value must not fail later."""
    if isinstance(it, WarehouseEnv):
        it.reset(seed=1)
        it.step("N")
    elif isinstance(it, FleetEnv):
        it.reset(seed=1)
        it.step([4] * it.settings.robots)
    elif isinstance(it, ArrayEnv):
        it.reset(seed=1)
        it.step([4] * it.num_envs)
    elif isinstance(it, gymnasium.vector.VectorEnv):
        it.reset(seed=1)
        it.step(np.zeros(it.action_space.shape, it.action_space.dtype))
    elif isinstance(it, gymnasium.Env):
        it.reset(seed=1)
        it.step(np.zeros(2) if isinstance(it.action_space, gymnasium.spaces.Box) else 4)
        if it.render_mode:
            it.render()
    elif isinstance(it, parallel_env):
        it.reset(seed=1)
        it.step(dict.fromkeys(it.agents, 4))
        it.state()
    elif isinstance(it, Motion):
        it.reset(DEFAULT_LAYOUT, [(1, 1)], 1)
        it.advance([(0, 1)], [False])
    elif isinstance(it, RobotSpec):
        use(RigidBodyMotion(it))
    elif isinstance(it, Stop):
        use(Disturbances(stops=(it,)))
    elif isinstance(it, Disturbances):
        use(DrivingMotion(None, it) if it.stops else RigidBodyMotion(None, it))
    elif isinstance(it, Battery):
        use(FleetEnv(battery=it))
    elif isinstance(it, People):
        use(FleetEnv(people=it))
    elif isinstance(it, (OrderStream, OrderQueue)):
        use(FleetEnv(orders=it))
    elif isinstance(it, Layout):
        use(WarehouseEnv(it, None))
    elif isinstance(it, (Team, PlannedFleet)):
        fleet = FleetEnv()
        fleet.reset(seed=0)
        it.reset()
        it.act(fleet)
    elif isinstance(it, Follower):
        it.env.reset(seed=0)
        it.reset()
        it.act(None)
    elif isinstance(it, DrivePolicy):
        it.act(np.zeros(29))
    elif hasattr(it, "act"):
        it.reset()
        it.act(WarehouseEnv().reset())


class Answer(NamedTuple):
    """The reaction of a callable to a hostile value.

    Attributes:
        kind: class of the error, or "accepted".
        fault: description of the fault; empty if there is none.
    """

    kind: str
    fault: str = ""


Answers = dict[str, dict[str, Answer]]
"""Answer to each hostile value by its name, for each argument."""


def answers(target: Target) -> Answers:
    """Return the answers of a callable to hostile values for each of its arguments."""
    words = FEW if target.name in DRAWN else HOSTILE
    return {
        f"{target.name}({name}": {
            word: _answer(target, {name: HOSTILE[word]()}, (name, *OTHER_NAMES.get(name, ())))
            for word in words
        }
        for name in sorted(target.parameters.keys() - OPEN_TO_ALL)
    }


def faults(answers: Answers) -> list[str]:
    """Return a line for each answer that has a fault."""
    return [
        f"{call}={word}): {answer.fault}"
        for call, found in answers.items()
        for word, answer in found.items()
        if answer.fault
    ]


def _answer(target: Target, hostile: dict[str, Any], names: Iterable[str]) -> Answer:
    random.seed(0)
    try:
        with bounded_memory():
            result = target.call(**target.valid | hostile)
            del hostile
    except (TypeError, ValueError, WarehouseError, gymnasium.error.Error) as error:
        return Answer(type(error).__name__, _complaint(error, names))
    except Exception as error:
        return Answer("undocumented", f"it raised {brief(error)}")
    try:
        with bounded_memory():
            target.use(result)
    except Exception as error:
        if isinstance(result, PARTS) and isinstance(error, ValueError):
            return Answer(type(error).__name__, _complaint(error, names))
        return Answer("late", f"it was accepted, and then raised {brief(error)}")
    return Answer("accepted")


def _complaint(error: Exception, names: Iterable[str]) -> str:
    """Return the fault of an error of a documented class, or an empty text."""
    message = str(error)
    if len(message) > MAX_MESSAGE:
        return f"{len(message)} characters: {message:.100}"
    if not any(name in message for name in names):
        return f"the message does not name it: {message:.200}"
    return ""


@contextmanager
def bounded_memory() -> Iterator[None]:
    """Raise ``MemoryError`` in a block that takes more than ``MAX_MEMORY``, on Linux."""
    if sys.platform != "linux":
        yield
        return
    import resource

    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (used + MAX_MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
