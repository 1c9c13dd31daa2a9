import math

import numpy as np
import pytest

from agents.evaluation.samples import Scores, Task, evaluate
from agents.run_episode import run_episode
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Layout, Observation

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
SCORES = Scores(np.array([True, False, True, True]), np.array([10, 200, 20, 60]))


class Noter:
    """Waits, and notes what it was asked and whether it was reset first."""

    def __init__(self, notes: list[object]) -> None:
        self.notes = notes

    def reset(self) -> None:
        self.notes.append("reset")

    def act(self, observation: Observation) -> str:
        self.notes.append(observation["steps"])
        return "WAIT"


@pytest.mark.parametrize("task", [Task(), Task(battery=20), Task(max_steps=15), Task(ROOM, 100, 5)])
def test_the_episodes_are_those_that_run_shows(task: Task) -> None:
    seeds = range(100, 130)
    scores = evaluate(GreedyAgent, task, seeds)
    shown = [
        run_episode(
            "greedy", layout=task.layout, seed=seed, battery=task.battery, max_steps=task.max_steps
        )
        for seed in seeds
    ]
    assert scores.delivered.tolist() == [episode.terminated for episode in shown]
    assert scores.steps.tolist() == [episode.steps for episode in shown]
    assert 0 < scores.success < 1


def test_an_agent_is_made_for_each_seed_and_reset_before_it_acts() -> None:
    notes: list[object] = []

    def make(seed: int) -> Noter:
        notes.append(f"seed {seed}")
        return Noter(notes)

    scores = evaluate(make, Task(max_steps=2), [7, 5])
    assert notes == ["seed 7", "reset", 0, 1, "seed 5", "reset", 0, 1]
    assert scores.delivered.tolist() == [False, False]
    assert scores.steps.tolist() == [2, 2]


def test_success_is_the_share_of_deliveries() -> None:
    assert SCORES.success == 0.75


def test_steps_to_deliver_leave_failures_out() -> None:
    assert SCORES.steps_to_deliver() == 30
    assert SCORES.steps_to_deliver(np.array([True, True, True, False])) == 15
    assert math.isnan(SCORES.steps_to_deliver(np.array([False, True, False, False])))
    assert math.isnan(Scores(np.zeros(2, np.bool_), np.ones(2, np.int64)).steps_to_deliver())
