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

from agents.errors import AgentError, reason_of
from agents.experiments.parameters import (
    DEFAULT,
    PHYSICAL,
    RANDOM,
    SETTINGS,
    Value,
    find,
    is_greedy,
    shown,
)
from agents.registry import agent_file, make_agent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import DEFAULT_LAYOUT, Agent, Layout, WarehouseEnv, random_layout
from warehouse_core.motion.backends import Backend
from warehouse_core.world.map_files import load_layout

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
        layout = DEFAULT_LAYOUT if is_default else load_layout(case["layout"])
        case[TILES] = list(layout.rows)
    env = make_env(case, seed=0)
    env.close()
    _try_agent(case, env.layout)
    fingerprint = agent_fingerprint(case)
    if fingerprint is not None:
        case[FINGERPRINT] = fingerprint
    return case


def key_of(case: Case) -> str:
    """Return the case as text, the same for equal cases."""
    return json.dumps(case, sort_keys=True, separators=(",", ":"))


def flags_of(case: Case) -> list[str]:
    """Return what is not the default in a case, as it is written on the command line."""
    return [
        f"{name}={shown(value)}"
        for name, value in case.items()
        if name not in (TILES, FINGERPRINT)
        and (name not in SETTINGS or value != SETTINGS[name].default)
    ]


def agent_fingerprint(case: Case) -> str | None:
    """Return the digest of the file of a case's agent as it is now, if it has one.

    Raises:
        OSError: it cannot be read.
    """
    file = agent_file(case["agent"])
    return None if file is None else hashlib.sha256(file.read_bytes()).hexdigest()


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


def make_agent_for(case: Case, seed: int, layout: Layout) -> Agent:
    """Return the agent of a case, with the seed and the layout if it takes them."""
    if is_greedy(case):
        if case["escape"]:
            return GreedyAgent(seed, case["memory"])
        return GreedyAgent(seed, escape_steps=0)
    return make_agent(case["agent"], seed, layout)


def _try_agent(case: Case, layout: Layout) -> None:
    """Make an agent, and see to it that whatever its file raises becomes one line."""
    try:
        make_agent_for(case, 0, layout)
    except (AgentError, OSError):
        raise
    except (Exception, SystemExit) as error:
        reason = reason_of(error, agent_file(case["agent"]))
        raise AgentError(f"agent {case['agent']!r} cannot be made: {reason}") from error


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
