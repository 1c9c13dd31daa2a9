"""A case: a value for every parameter that applies, as a dict that can be written as JSON.

It contains the tiles of its layout and a digest of its agent's code: changed code is another case,
and workers do not need the layout's file.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from agents.console.place import Stations, check_stations, usual_stations
from agents.experiments.parameters import (
    DEFAULT,
    PARAMETERS,
    PHYSICAL,
    RANDOM,
    Value,
    checked,
    find,
    number,
    shown,
    text,
)
from agents.programs import fingerprint
from agents.registry import agent_file, agent_module, make_agent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Agent, Layout, WarehouseEnv, random_layout
from warehouse_core.motion.backends import Backend
from warehouse_core.world.named_layouts import find_layout

Case = Mapping[str, Any]

TILES, FINGERPRINT = "tiles", "fingerprint"
"""Keys beside the parameters: the rows of the layout, and the digest of the agent's code."""

IMPLIED = {"stations": str(Stations.DRAWN)}
"""Left out of a case as text, as in the files of version 0.1.0, which are read and resumed."""

MAX_BRACKETS, MAX_KEYS = 1000, 100
"""Limits on the text of a case; a name may have brackets."""

PHYSICAL_NAME = re.compile(rf"({'|'.join(PHYSICAL)})\.[a-z_]{{1,50}}")

_layout = lru_cache(2)(Layout)
"""Few, because one may be large."""


def make_case(values: Mapping[str, Value]) -> dict[str, Any]:
    """Return the case of some checked values; the other parameters have their defaults.

    Raises:
        ValueError: a layout, an agent or a robot that cannot be used.
        OSError: a file that cannot be read.
    """
    layout_name = values.get("layout", DEFAULT)
    case: dict[str, Any] = {}
    if layout_name != RANDOM:
        case[TILES] = list(find_layout(str(layout_name)).rows)
    for name in [*PARAMETERS, *sorted(values.keys() - PARAMETERS.keys())]:
        parameter = find(name)
        if parameter.applies(case):
            case[name] = values.get(name, default_of(name, case))
    if TILES in case:  # a random layout has its stations
        kept_or_drawn = Stations(case["stations"])
        check_stations(layout_of(case), kept_or_drawn, layout_name, "stations=drawn")
    env = make_env(case, seed=0)
    env.close()
    make_agent_for(case, 0, env.layout)
    digest = agent_fingerprint(case)
    if digest is not None:
        case[FINGERPRINT] = digest
    return case


def default_of(name: str, case: Case) -> Value | None:
    """Return the default of a parameter, given the values of the parameters before it."""
    if name == "stations" and TILES in case:
        return str(usual_stations(layout_of(case), is_default=case["layout"] == DEFAULT))
    return find(name).default


def key_of(case: Case) -> str:
    """Return the case as text, the same for equal cases."""
    told = {name: value for name, value in case.items() if IMPLIED.get(name) != value}
    return json.dumps(told, sort_keys=True, separators=(",", ":"))


def read_case(written: str) -> Case:
    """Return the case that ``key_of`` has written as text, checked as the values of a plan are.

    Its backend need not be installed here, and its agent is not looked for.

    Raises:
        ValueError: it is not such a text, a key is missing or unknown, or a value is not allowed.
    """
    if sum(map(written.count, "[{")) > MAX_BRACKETS:
        raise ValueError(f"there are more than MAX_BRACKETS = {MAX_BRACKETS} brackets")
    case = json.loads(written)
    if not isinstance(case, dict) or len(case) > MAX_KEYS:
        raise ValueError(f"it must be a JSON object of at most MAX_KEYS = {MAX_KEYS} keys")
    case = IMPLIED | case
    for name, value in case.items():
        checked(name, value, number() if PHYSICAL_NAME.fullmatch(name) else CHECKS.get(name))
    needed = [name for name, each in PARAMETERS.items() if each.applies(case)]
    needed += [] if case.get("layout") == RANDOM else [TILES]
    if missing := [name for name in needed if name not in case]:
        raise ValueError(f"it has no {missing[0]}")
    return case


def _tiles(value: Any) -> str:
    try:
        return str(_layout(tuple(value)))
    except TypeError as error:
        raise ValueError("a list of rows") from error


def _digest(value: Any) -> str:
    if not isinstance(value, str) or not re.fullmatch("[0-9a-f]{64}", value):
        raise ValueError("64 hexadecimal digits")
    return value


CHECKS: dict[str, Callable[[Any], Value]] = {
    TILES: _tiles, FINGERPRINT: _digest, "backend": text,
}  # fmt: skip
"""Of what is in a case and is no parameter, or need not be installed where a case is read."""


def flags_of(case: Case) -> list[str]:
    """Return what is not the default in a case, as command-line flags."""
    return [
        f"{name}={shown(value)}"
        for name, value in case.items()
        if name not in (TILES, FINGERPRINT)
        and (name not in PARAMETERS or value != default_of(name, case))
    ]


def in_words(case: Case) -> str:
    """Return what is not the default in a case, as part of a sentence."""
    return ", ".join(flags_of(case)) or "the defaults"


def agent_fingerprint(case: Case) -> str | None:
    """Return the digest of the present code of a case's agent, see ``fingerprint``."""
    return fingerprint(agent_file(case["agent"]), agent_module(case["agent"]))


def layout_of(case: Case) -> Layout:
    """Return the layout of a case that has tiles."""
    return _layout(tuple(case[TILES]))


def cells_of(case: Case) -> int:
    """Return how many cells the layouts of a case have."""
    if TILES in case:
        return len(case[TILES]) * len(case[TILES][0])
    return math.prod(_size(case))


def make_env(case: Case, seed: int) -> WarehouseEnv:
    """Return a new environment for one episode of a case."""
    if TILES in case:
        layout = layout_of(case)
    else:
        layout = random_layout(*_size(case), case["density"], seed)
    return WarehouseEnv(
        layout,
        None,
        case["max_steps"],
        case["battery"],
        case["view_radius"],
        backend=_backend(case),
    )


def make_agent_for(case: Case, seed: int, layout: Layout) -> Agent:
    """Return the agent of a case, with the seed and the layout if it takes them."""
    if case["agent"] == "greedy":
        if case["escape"]:
            return GreedyAgent(seed, case["memory"])
        return GreedyAgent(seed, escape_steps=0)
    return make_agent(case["agent"], seed, layout)


def _size(case: Case) -> tuple[int, int]:
    height, width = map(int, case["size"].split("x"))
    return height, width


def _backend(case: Case) -> Backend:
    groups = {
        group: {
            name.removeprefix(f"{group}."): value
            for name, value in case.items()
            if name.startswith(f"{group}.")
        }
        for group in PHYSICAL
    }
    if not any(groups.values()):
        backend: str = case["backend"]
        return backend
    from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec

    return RigidBodyMotion(RobotSpec(**groups["robot"]), Disturbances(**groups["disturbances"]))
