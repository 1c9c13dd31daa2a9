"""A case: a value for every parameter that applies, as a dict that can be written as JSON.

A case with ``robots`` is one of a fleet, with orders; any other is the chapter's task.

It contains the tiles of its layout and a digest of its agent's code: changed code is another case,
and workers do not need the layout's file.
"""

from __future__ import annotations

import json
import math
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

from agents.fleet.planned import DEFAULT_ASSIGNMENT
from agents.lab.experiments.tables import MAX_LENGTH
from agents.lab.parameters import (
    FLEET,
    NO_PLANNER,
    PARAMETERS,
    PHYSICAL,
    PLANNER,
    Number,
    Value,
    checked,
    find,
    shown,
    text,
)
from agents.lab.place import RANDOM, Stations, check_stations, usual_stations, what_to_draw
from agents.lab.runs.programs import fingerprint
from agents.lab.trials.rows import AnyRow, FleetRow, Row
from agents.registry import agent_file, agent_module, make_agent, make_fleet_agent, make_team
from warehouse_core import (
    Agent,
    Cell,
    FleetEnv,
    Layout,
    LayoutError,
    OrderStream,
    WarehouseEnv,
    random_layout,
)
from warehouse_core.files.json_text import parse_object
from warehouse_core.motion.backends import Backend
from warehouse_core.records.recorder import FleetAgent
from warehouse_core.world.named_layouts import DEFAULT, DEPOT, find_layout

Case = Mapping[str, Any]

TILES, FINGERPRINT = "tiles", "fingerprint"
"""Keys beside the parameters: the rows of the layout, and the digest of the agent's code."""

FLEET_DEFAULTS: dict[str, Value] = {"layout": DEPOT, "battery": 400, "max_steps": 1000}
"""Defaults of a fleet for parameters that lone robots have too."""

IMPLIED = {"stations": str(Stations.DRAWN)}
"""Values that a case as text leaves out; the files that exist do so."""

MAX_KEYS = 100
"""Limit on the keys of a case as text."""

PHYSICAL_NAME = re.compile(rf"({'|'.join(PHYSICAL)})\.[a-z_]{{1,50}}")

_layout = lru_cache(2)(Layout)
"""Few, because one may be large."""


def make_case(values: Mapping[str, Value]) -> dict[str, Any]:
    """Return the case of some checked values; the other parameters have their defaults.

    Raises ``ValueError`` for a layout, an agent or a robot that cannot be used, and ``OSError``.
    """
    case: dict[str, Any] = {}
    if any(find(name).of_fleets for name in values):
        case[FLEET] = values.get(FLEET, find(FLEET).default)
    layout_name = values.get("layout", default_of("layout", case))
    if layout_name != RANDOM:
        case[TILES] = list(find_layout(str(layout_name)).rows)
    for name in [*PARAMETERS, *sorted(values.keys() - PARAMETERS.keys())]:
        parameter = find(name)
        if parameter.applies(case):
            case[name] = values.get(name, default_of(name, case))
    if TILES in case and not is_fleet(case):  # a random layout has its stations
        kept_or_drawn = Stations(case["stations"])
        check_stations(layout_of(case), kept_or_drawn, layout_name, "stations=drawn")
    layout = layout_for(case, seed=0)
    make_env(case, layout).close()
    make_agent_for(case, 0, layout)
    digest = agent_fingerprint(case)
    if digest is not None:
        case[FINGERPRINT] = digest
    return case


def is_fleet(case: Case) -> bool:
    """Return whether a case is one of a fleet."""
    return FLEET in case


def row_type(case: Case) -> type[AnyRow]:
    """Return the kind of the rows of a case."""
    return FleetRow if is_fleet(case) else Row


def default_of(name: str, case: Case) -> Value | None:
    """Return the default of a parameter, given the values of the parameters before it."""
    if is_fleet(case) and name in FLEET_DEFAULTS:
        return FLEET_DEFAULTS[name]
    if name == "chargers" and TILES in case:
        return len(layout_of(case).chargers)
    if name == "stations" and TILES in case:
        return str(usual_stations(layout_of(case), is_default=case["layout"] == DEFAULT))
    return find(name).default


def key_of(case: Case) -> str:
    """Return the case as text, the same for equal cases."""
    told = {name: value for name, value in case.items() if IMPLIED.get(name) != value}
    return json.dumps(told, sort_keys=True, separators=(",", ":"))


def read_case(written: str) -> Case:
    """Return the case that ``key_of`` has written as text, or raise ``ValueError``.

    Its values are checked as those in a plan, but its backend need not be installed here, and its
    agent is not looked for.
    """
    case = parse_object(written.encode(), MAX_LENGTH)
    if len(case) > MAX_KEYS:
        raise ValueError(f"it has {len(case):,} keys; MAX_KEYS = {MAX_KEYS} are allowed")
    if not is_fleet(case):
        case = IMPLIED | case
    for name, value in case.items():
        checked(name, value, Number() if PHYSICAL_NAME.fullmatch(name) else CHECKS.get(name))
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
"""Checks of the keys of a case that are not parameters, or need not be installed to be read."""


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
    name = director_of(case)
    return fingerprint(agent_file(name), agent_module(name))


def director_of(case: Case) -> str:
    """Return the name of what chooses the actions: the planner, or else the agent."""
    planner: str = case.get(PLANNER, NO_PLANNER)
    return case["agent"] if planner == NO_PLANNER else planner


def layout_of(case: Case) -> Layout:
    """Return the layout of a case that has tiles."""
    return _layout(tuple(case[TILES]))


def cells_of(case: Case) -> int:
    """Return how many cells the layouts of a case have."""
    if TILES in case:
        return len(case[TILES]) * len(case[TILES][0])
    return math.prod(_pair(case["size"], "x"))


def layout_for(case: Case, seed: int) -> Layout:
    """Return the layout of one episode; a fleet's has as many chargers as the case, or fails."""
    if TILES in case:
        layout = layout_of(case)
    else:
        layout = random_layout(*_pair(case["size"], "x"), case["density"], seed)
    if not is_fleet(case):
        return layout
    return layout.with_chargers(_some(layout.chargers, case["chargers"]))


def make_env(case: Case, layout: Layout, *, dispatch: bool = True) -> WarehouseEnv | FleetEnv:
    """Return a new environment for one episode; for ``dispatch`` see ``FleetEnv``."""
    shared: dict[str, Any] = {name: case[name] for name in ("max_steps", "battery", "view_radius")}
    shared["backend"] = _backend(case)
    if not is_fleet(case):
        return WarehouseEnv(layout, start_pos=None, **shared)
    with warnings.catch_warnings():
        # An experiment may be about chargers that supply too little.
        warnings.simplefilter("ignore")
        return FleetEnv(
            layout,
            case[FLEET],
            orders=OrderStream(case["order_rate"], _pair(case["due"], ":")),
            people=case["people"],
            dispatch=dispatch,
            **shared,
        )


def randomize_for(case: Case) -> bool | str:
    """Return what the reset of a lone robot draws; a fleet draws its starts by itself."""
    return is_fleet(case) or what_to_draw(Stations(case["stations"]))


def make_agent_for(case: Case, seed: int, layout: Layout) -> Agent | FleetAgent:
    """Return what directs the robots of a case: a planner, a team of agents, or one agent."""
    if not is_fleet(case):
        return make_agent(_agent_name(case), seed, layout)
    if case[PLANNER] == NO_PLANNER:
        return make_team(_agent_name(case), case[FLEET], seed, layout)
    # A planner that assigns orders itself takes no assignment, not even the default.
    chosen = None if case["assignment"] == DEFAULT_ASSIGNMENT else case["assignment"]
    return make_fleet_agent(case[PLANNER], chosen, seed, layout, case[FLEET])


def _agent_name(case: Case) -> str:
    """Return the name of the agent of a case, with its arguments."""
    name: str = case["agent"]
    if name == "greedy":
        name += f":memory={case['memory']}" if case["escape"] else ":escape_steps=0"
    return name


def _some(chargers: Sequence[Cell], count: int) -> list[Cell]:
    """Return so many of the chargers of a layout, from all parts of it."""
    if count > len(chargers):
        raise LayoutError(f"chargers is {count}; the layout has {len(chargers)}")
    return [chargers[number * len(chargers) // count] for number in range(count)]


def _pair(words: str, separator: str) -> tuple[int, int]:
    first, second = map(int, words.split(separator))
    return first, second


def _backend(case: Case) -> Backend:
    groups: dict[str, dict[str, Any]] = {group: {} for group in PHYSICAL}
    for name, value in case.items():
        group, dot, field = name.partition(".")
        if dot:
            groups[group][field] = value
    if not any(groups.values()):
        return str(case["backend"])
    from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec

    return RigidBodyMotion(RobotSpec(**groups["robot"]), Disturbances(**groups["disturbances"]))
