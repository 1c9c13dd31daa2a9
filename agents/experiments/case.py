"""A case: a value for every parameter that applies, as a dict that can be written as JSON.

It contains the tiles of its layout and a digest of its agent's file: a changed file is another
case, and workers do not need the layout's file.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from agents.console.place import Stations, check_stations, usual_stations
from agents.experiments.parameters import DEFAULT, PARAMETERS, PHYSICAL, RANDOM, Value, find, shown
from agents.registry import agent_file, make_agent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Agent, Layout, WarehouseEnv, random_layout
from warehouse_core.motion.backends import Backend
from warehouse_core.world.named_layouts import find_layout

Case = Mapping[str, Any]

TILES, FINGERPRINT = "tiles", "fingerprint"
"""Keys beside the parameters: the rows of the layout, and the digest of the agent's file."""

IMPLIED = {"stations": str(Stations.DRAWN)}
"""Left out of a case as text, as in the files of version 0.1.0, which are read and resumed."""

_layout = lru_cache(Layout)


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
    fingerprint = agent_fingerprint(case)
    if fingerprint is not None:
        case[FINGERPRINT] = fingerprint
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


def flags_of(case: Case) -> list[str]:
    """Return what is not the default in a case, as command-line flags."""
    return [
        f"{name}={shown(value)}"
        for name, value in case.items()
        if name not in (TILES, FINGERPRINT)
        and (name not in PARAMETERS or value != default_of(name, case))
    ]


def agent_fingerprint(case: Case) -> str | None:
    """Return the digest of the present file of a case's agent; ``None`` if it has no file.

    Raises:
        OSError: it cannot be read.
    """
    file = agent_file(case["agent"])
    return None if file is None else hashlib.sha256(file.read_bytes()).hexdigest()


def layout_of(case: Case) -> Layout:
    """Return the layout of a case that has tiles."""
    return _layout(tuple(case[TILES]))


def make_env(case: Case, seed: int) -> WarehouseEnv:
    """Return a new environment for one episode of a case."""
    if TILES in case:
        layout = layout_of(case)
    else:
        height, width = map(int, case["size"].split("x"))
        layout = random_layout(height, width, case["density"], seed)
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
