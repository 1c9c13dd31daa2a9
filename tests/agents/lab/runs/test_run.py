"""Runs of a lone robot or a fleet: their records, and the place where an agent fails."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from agents.errors import EpisodeError, EpisodeInterrupted
from agents.fleet import PlannedFleet, Team
from agents.lab.runs.run import MAX_SEED, draw_seed, run
from agents.mapf.planner import Situation
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import FleetEnv, Layout, WarehouseEnv

ROOM = Layout(["########", "#P....P#", "#......#", "#D....D#", "########"])


class Third:
    """An agent that moves north and calls a function for its third action."""

    def __init__(self, third: Callable[[], Any]) -> None:
        self.third = third

    def reset(self) -> None:
        self.count = 0

    def act(self, observation: Any) -> Any:
        self.count += 1
        return self.third() if self.count == 3 else "N"


class Directs(Third):
    def act(self, env: Any) -> Any:
        return [super().act(None)] * env.settings.robots


class Plans(Third):
    def next_cells(self, situation: Situation) -> Any:
        super().act(None)
        return situation.cells


class NeverStarts(Third):
    def reset(self) -> None:
        self.missing.count = 0  # type: ignore[attr-defined]


def fail() -> None:
    raise ValueError("too far")


def leave() -> None:
    raise SystemExit(3)


def stop() -> None:
    raise KeyboardInterrupt


def fleet(**settings: Any) -> FleetEnv:
    return FleetEnv(ROOM, 2, orders=0.2, max_steps=60, **settings)


def begin(kind: str, third: Callable[[], Any]) -> tuple[Any, Any]:
    """Return an environment and an agent that calls a function for its third action."""
    if kind == "lone":
        return WarehouseEnv(), Third(third)
    if kind == "fleet":
        return fleet(), Directs(third)
    return fleet(dispatch=False), PlannedFleet(Plans(third))


def line_in(function: Callable[[], None]) -> str:
    return f"(test_run.py, line {function.__code__.co_firstlineno + 1})"


KINDS = ("lone", "fleet", "planned")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("third", "error"), [(fail, "ValueError: too far"), (leave, "SystemExit: 3")]
)
def test_a_failure_names_seed_step_agent_and_line_and_keeps_the_record(kind, third, error) -> None:
    with pytest.raises(EpisodeError) as failed:
        run(*begin(kind, third), 4, name="mine")
    assert str(failed.value) == f"seed 4, step 3, agent mine: {error} {line_in(third)}"
    assert (failed.value.episode.steps, failed.value.episode.seed) == (2, 4)


@pytest.mark.parametrize("kind", KINDS)
def test_an_interrupt_names_the_step_and_keeps_the_record(kind: str) -> None:
    with pytest.raises(EpisodeInterrupted) as stopped:
        run(*begin(kind, stop), 4, name="mine")
    assert str(stopped.value) == f"in step 3, agent mine {line_in(stop)}"
    assert stopped.value.episode.steps == 2


@pytest.mark.parametrize(
    ("agent", "place", "reason"),
    [
        (Third(lambda: None), "step 3", "TypeError: action None is NoneType; allowed: one of N, E"),
        (
            NeverStarts(fail),
            "reset",
            "AttributeError: 'NeverStarts' object has no attribute 'missing'",
        ),
    ],
)
def test_a_wrong_action_and_a_failure_in_reset_are_named(agent, place, reason) -> None:
    with pytest.raises(EpisodeError) as failed:
        run(WarehouseEnv(), agent, 4)
    assert str(failed.value).startswith(f"seed 4, {place}, agent {type(agent).__name__}: {reason}")


def test_the_robot_whose_agent_fails_is_named() -> None:
    with pytest.raises(EpisodeError) as failed:
        run(fleet(), Team([GreedyAgent(1), Third(fail)]), 9, name="mine")
    found = re.fullmatch(r"seed 9, step (\d+), robot 1, agent mine: (.*)", str(failed.value))
    assert found is not None
    assert found[2].startswith("ValueError: too far")
    assert failed.value.episode.steps == int(found[1]) - 1


def test_a_random_seed_is_short_and_independent_of_the_random_module() -> None:
    import random

    random.seed(1)
    first = [draw_seed() for _ in range(20)]
    random.seed(1)
    assert first != [draw_seed() for _ in range(20)]
    assert all(0 <= seed <= MAX_SEED for seed in first)
