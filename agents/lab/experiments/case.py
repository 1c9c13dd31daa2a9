"""A case: one combination of settings, as a dict that can be written as JSON.

A case has a value for every parameter that applies to it. A case with ``robots`` describes a fleet
with orders; any other case describes the chapter's task with a lone robot. Each episode of a case
has a seed and produces one row.

A case also contains the tiles of its layout, so that workers do not need the layout's file, and a
digest of its agent's code, so that changed code makes a different case.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from functools import lru_cache
from time import perf_counter
from typing import Any, NamedTuple

from agents.errors import AgentError, EpisodeError, reason_of
from agents.fleet.planned import DEFAULT_ASSIGNMENT, wants_dispatch
from agents.lab.console.terminal import print_error
from agents.lab.console.watch import slow_reported
from agents.lab.parameters import (
    FLEET,
    NO_PLANNER,
    PARAMETERS,
    PHYSICAL,
    PLANNER,
    Value,
    checked,
    find,
    pair_of,
    shown,
    text,
)
from agents.lab.place import RANDOM, Stations, check_stations, default_stations, what_to_draw
from agents.lab.runs.programs import fingerprint, program_for
from agents.lab.runs.run import run
from agents.lab.trials.rows import AnyRow, FleetRow, Row, row_of
from agents.registry import agent_file, agent_module, make_agent, make_fleet_agent, make_team
from warehouse_core import (
    Agent,
    Cell,
    Episode,
    FleetEnv,
    Layout,
    LayoutError,
    OrderStream,
    WarehouseEnv,
    random_layout,
)
from warehouse_core.errors import WarehouseError
from warehouse_core.files.json_text import parse_object
from warehouse_core.motion.backends import Backend
from warehouse_core.records.recorder import FleetAgent
from warehouse_core.world.named_layouts import DEFAULT, DEPOT, find_layout

Case = Mapping[str, Any]

TILES, FINGERPRINT = "tiles", "fingerprint"
"""Keys that are not parameters: the rows of the layout, and the digest of the agent's code."""

FLEET_DEFAULTS: dict[str, Value] = {"layout": DEPOT, "battery": 400, "max_steps": 1000}
"""Defaults for fleets of parameters that have another default for lone robots."""

SLOW_SECONDS = 10.0
"""Seconds after which a running episode is reported as slow."""

_layout = lru_cache(2)(Layout)
"""``Layout`` with a cache, which is small because a layout may be large."""


def make_case(values: Mapping[str, Value]) -> dict[str, Any]:
    """Return the case that has the given checked values, and defaults for all other parameters.

    Raises:
        ValueError: the layout, the agent or the robot cannot be used.
        OSError: a file cannot be read.
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
    if TILES in case and not is_fleet(case):  # random layouts always have stations
        stations = Stations(case["stations"])
        check_stations(layout_of(case), stations, layout_name, "stations=drawn")
    layout = layout_for(case, seed=0)
    make_env(case, layout).close()
    make_agent_for(case, 0, layout)
    digest = agent_fingerprint(case)
    if digest is not None:
        case[FINGERPRINT] = digest
    return case


def is_fleet(case: Case) -> bool:
    """Return whether a case describes a fleet."""
    return FLEET in case


def row_type(case: Case) -> type[AnyRow]:
    """Return the type of the rows that the episodes of a case produce."""
    return FleetRow if is_fleet(case) else Row


def default_of(name: str, case: Case) -> Value | None:
    """Return the default of a parameter, given the values of the parameters before it."""
    if is_fleet(case) and name in FLEET_DEFAULTS:
        return FLEET_DEFAULTS[name]
    if name == "chargers" and TILES in case:
        return len(layout_of(case).chargers)
    if name == "stations" and TILES in case:
        return str(default_stations(layout_of(case), is_default=case["layout"] == DEFAULT))
    return find(name).default


def key_of(case: Case) -> str:
    """Return the case as text; equal cases have equal texts."""
    return json.dumps(case, sort_keys=True, separators=(",", ":"))


def read_case(written: str) -> Case:
    """Return the case that ``key_of`` has written as text; its agent need not exist here.

    Raises:
        ValueError: the text is not a valid case.
        TypeError: its layout is not a list of rows.
    """
    case = parse_object(str(written).encode())
    for name, value in case.items():
        checked(name, value, CHECKS.get(name))
    needed = [name for name, each in PARAMETERS.items() if each.applies(case)]
    needed += [] if case.get("layout") == RANDOM else [TILES]
    if missing := [name for name in needed if name not in case]:
        raise ValueError(f"it has no {missing[0]}")
    return case


CHECKS: dict[str, Callable[[Any], Value]] = {
    TILES: lambda rows: str(_layout(tuple(rows))), FINGERPRINT: text, "backend": text,
}  # fmt: skip
"""Checks of keys that are not parameters, and of the backend, which need not be installed."""


def flags_of(case: Case) -> list[str]:
    """Return the values of a case that are not defaults, as ``NAME=VALUE``."""
    return [
        f"{name}={shown(value)}"
        for name, value in case.items()
        if name not in (TILES, FINGERPRINT)
        and (name not in PARAMETERS or value != default_of(name, case))
    ]


def in_words(case: Case) -> str:
    """Return the values of a case that are not defaults, as part of a sentence."""
    return ", ".join(flags_of(case)) or "the defaults"


def agent_fingerprint(case: Case) -> str | None:
    """Return the digest of the current code of a case's agent; see ``fingerprint``."""
    name = director_of(case)
    return fingerprint(agent_file(name), agent_module(name))


def director_of(case: Case) -> str:
    """Return the name of the planner that chooses the actions, or else of the agent."""
    planner: str = case.get(PLANNER, NO_PLANNER)
    return case["agent"] if planner == NO_PLANNER else planner


def layout_of(case: Case) -> Layout:
    """Return the layout of a case that has tiles."""
    return _layout(tuple(case[TILES]))


def layout_for(case: Case, seed: int) -> Layout:
    """Return the layout of the episode with a seed.

    The layout of a fleet is given the number of chargers that the case asks for.

    Raises:
        LayoutError: the layout has fewer chargers.
    """
    if TILES in case:
        layout = layout_of(case)
    else:
        layout = random_layout(*pair_of(case["size"]), case["density"], seed)
    if not is_fleet(case):
        return layout
    return layout.with_chargers(_some(layout.chargers, case["chargers"]))


def make_env(case: Case, layout: Layout, *, dispatch: bool = True) -> WarehouseEnv | FleetEnv:
    """Return a new environment for one episode; ``dispatch`` is an argument of ``FleetEnv``."""
    shared: dict[str, Any] = {name: case[name] for name in ("max_steps", "battery", "view_radius")}
    shared["backend"] = _backend(case)
    if not is_fleet(case):
        return WarehouseEnv(layout, start_pos=None, **shared)
    with warnings.catch_warnings():
        # An experiment may study chargers that supply too little.
        warnings.simplefilter("ignore")
        return FleetEnv(
            layout,
            case[FLEET],
            orders=OrderStream(case["order_rate"], pair_of(case["due"])),
            people=case["people"],
            dispatch=dispatch,
            **shared,
        )


def make_agent_for(case: Case, seed: int, layout: Layout) -> Agent | FleetAgent:
    """Return the planner, the team of agents or the single agent that controls the robots."""
    if not is_fleet(case):
        return make_agent(_agent_name(case), seed, layout)
    if case[PLANNER] == NO_PLANNER:
        return make_team(_agent_name(case), case[FLEET], seed, layout)
    # A planner that assigns orders itself accepts no assignment, not even the default.
    chosen = None if case["assignment"] == DEFAULT_ASSIGNMENT else case["assignment"]
    return make_fleet_agent(case[PLANNER], chosen, seed, layout, case[FLEET])


def _agent_name(case: Case) -> str:
    """Return the name and arguments of the agent of a case."""
    name: str = case["agent"]
    if name == "greedy":
        name += f":memory={case['memory']}" if case["escape"] else ":escape_steps=0"
    return name


def _some(chargers: Sequence[Cell], count: int) -> list[Cell]:
    """Return ``count`` chargers, spread evenly over the chargers of a layout."""
    if count > len(chargers):
        raise LayoutError(f"chargers is {count}; the layout has {len(chargers)}")
    return [chargers[number * len(chargers) // count] for number in range(count)]


def _backend(case: Case) -> Backend:
    given: dict[str, dict[str, Any]] = {
        group: {
            name.removeprefix(f"{group}."): value
            for name, value in case.items()
            if name.startswith(f"{group}.")
        }
        for group in PHYSICAL
    }
    if not any(given.values()):
        return str(case["backend"])
    from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec

    return RigidBodyMotion(RobotSpec(**given["robot"]), Disturbances(**given["disturbances"]))


class Done(NamedTuple):
    """The outcome of a task, which ends at the first episode that fails.

    Attributes:
        seconds: time that the task took.
        rows: rows of the episodes before the failure, or of all episodes.
        program: program that ran them, see ``program_for``.
        failure: description of the failure. It is text, because an exception of a user's agent may
            not be picklable.
    """

    seconds: float
    rows: list[AnyRow]
    program: str
    failure: str | None = None


def run_task(case: Case, seeds: Sequence[int]) -> Done:
    """Run one episode for each seed until one fails, each in a new environment with a new agent.

    The rows depend only on the case and the seeds. Slow episodes are reported while they run.
    """
    start, rows, failure = perf_counter(), list[AnyRow](), None
    program = program_for(case["backend"])
    try:
        check_fingerprint(case)
    except EpisodeError as error:
        return Done(perf_counter() - start, rows, program, str(error))
    file, seed = agent_file(director_of(case)), seeds[0]

    def report_slow(seconds: float, line: str) -> None:
        print_error(f"{about(case, seed)} has run for {seconds:g} s{line}")

    try:
        with slow_reported(lambda: seed, SLOW_SECONDS, file, report_slow):
            for seed in seeds:
                rows.append(row_of(run_one(case, seed)))
    except BaseException as error:  # a user's agent may raise anything, even SystemExit
        failure = f"{about(case, seed)}: {failure_of(error, case).removeprefix(f'seed {seed}, ')}"
    return Done(perf_counter() - start, rows, program, failure)


def about(case: Case, seed: int) -> str:
    """Return an episode in words: its seed, and the values that are not defaults."""
    return f"seed {seed} with {in_words(case)}"


def failure_of(error: BaseException, case: Case) -> str:
    """Return why an episode failed: a message of this program, or an error of the agent."""
    if isinstance(error, WarehouseError):
        return str(error)
    return reason_of(error, agent_file(director_of(case)))


def run_one(case: Case, seed: int) -> Episode:
    """Run one episode of a case and return its record; errors are the errors of ``run``."""
    layout = layout_for(case, seed)
    agent: Any = make_agent_for(case, seed, layout)
    made: Any = make_env(case, layout, dispatch=is_fleet(case) and wants_dispatch(agent))
    with closing(made) as env:
        name = director_of(case)
        randomize = is_fleet(case) or what_to_draw(Stations(case["stations"]))
        episode: Episode = run(env, agent, seed, name=name, randomize=randomize)
        return episode


def check_fingerprint(case: Case) -> None:
    """Raise ``EpisodeError`` if the code of a case's agent has changed since the case was made."""
    name = director_of(case)
    try:
        is_same = agent_fingerprint(case) == case.get(FINGERPRINT)
    except (AgentError, OSError) as error:
        raise EpisodeError(f"the code of agent {name!r} cannot be read: {error}") from error
    if not is_same:
        raise EpisodeError(
            f"the code of agent {name!r}, or what it imports, has changed since the sweep began"
        )
