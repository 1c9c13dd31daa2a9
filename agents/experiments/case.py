"""A case: one value for every setting that counts, as a dict that can be written as JSON.

It carries the tiles of its layout and a fingerprint of its agent's file: a changed file is another
case, and no worker needs the layout's file.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from agents.agent_names import agent_file, make_agent
from agents.experiments.setting import (
    DEFAULT,
    PHYSICAL,
    RANDOM,
    SETTINGS,
    Value,
    find,
    is_greedy,
)
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import DEFAULT_LAYOUT, Agent, Layout, WarehouseEnv, random_layout
from warehouse_core.backends import Backend

Case = Mapping[str, Any]

TILES, FINGERPRINT = "tiles", "fingerprint"
"""Besides its settings a case has the rows of its layout, and the digest of its agent's file."""


def make_case(settings: Mapping[str, Value]) -> dict[str, Any]:
    """Return the case of some settings that have been checked; the others have their defaults.

    Raises:
        ValueError: a layout, an agent or a robot that cannot be used.
        OSError: a file that cannot be read.
    """
    case: dict[str, Any] = {}
    for name, setting in SETTINGS.items():
        if setting.counts(case):
            case[name] = settings.get(name, setting.default)
    for name in sorted(settings.keys() - SETTINGS.keys()):
        if find(name).counts(case):
            case[name] = settings[name]
    if case["layout"] != RANDOM:
        is_default = case["layout"] == DEFAULT
        layout = DEFAULT_LAYOUT if is_default else Layout.load(case["layout"])
        case[TILES] = list(layout.rows)
    make_env(case, seed=0).close()
    make_agent_for(case, seed=0)
    file = agent_file(case["agent"])
    if file is not None:
        case[FINGERPRINT] = hashlib.sha256(file.read_bytes()).hexdigest()
    return case


def key_of(case: Case) -> str:
    """Return the case as text, the same for equal cases."""
    return json.dumps(case, sort_keys=True, separators=(",", ":"))


def make_env(case: Case, seed: int) -> WarehouseEnv:
    """Return a fresh environment for one episode of a case."""
    if TILES in case:
        layout = _layout("\n".join(case[TILES]))
    else:
        height, width = map(int, case["size"].split("x"))
        layout = random_layout(height, width, case["density"], seed)
    return WarehouseEnv(
        layout,
        layout.usual_start(),
        case["max_steps"],
        case["battery"],
        case["view_radius"],
        backend=_backend(case),
    )


def make_agent_for(case: Case, seed: int) -> Agent:
    """Return the agent of a case, seeded if it takes a seed."""
    if is_greedy(case):
        if case["escape"]:
            return GreedyAgent(seed, case["memory"])
        return GreedyAgent(seed, case["memory"], escape_steps=0)
    return make_agent(case["agent"], seed)


@lru_cache
def _layout(text: str) -> Layout:
    return Layout(text.split("\n"))


def _backend(case: Case) -> Backend:
    groups = {group: _numbers(case, group) for group in PHYSICAL}
    if not any(groups.values()):
        backend: str = case["backend"]
        return backend
    from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec

    return RigidBodyMotion(RobotSpec(**groups["robot"]), Disturbances(**groups["disturbances"]))


def _numbers(case: Case, group: str) -> dict[str, Any]:
    """Return the settings of a group, ``robot.mass`` as ``mass``."""
    return {
        name.removeprefix(f"{group}."): value
        for name, value in case.items()
        if name.startswith(f"{group}.")
    }
