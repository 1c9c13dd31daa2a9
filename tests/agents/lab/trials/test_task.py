"""Tasks, whose episodes are the same for every agent, and the seeds of agents."""

import math

import pytest
from helpers.results_files import fleet_row

from agents.lab.trials.rows import row_of
from agents.lab.trials.scores import FleetScores
from agents.lab.trials.task import FleetTask, Task
from agents.run_episode import run_episode
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Layout, Observation

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])


class Waiter:
    """An agent that waits and records the calls of its methods."""

    def __init__(self, notes: list[object]) -> None:
        self.notes = notes

    def reset(self) -> None:
        self.notes.append("reset")

    def act(self, observation: Observation) -> str:
        self.notes.append(observation["steps"])
        return "WAIT"


@pytest.mark.parametrize(
    "task",
    [
        Task(battery=20),
        Task(ROOM, 100, 5),
        Task(backend="physics"),
        Task(ROOM, 50, 50, "grid", None, "start"),
        Task(ROOM, 50, 50, "grid", (2, 1), False),
    ],
)
def test_the_episodes_equal_the_episodes_of_run_episode(task: Task) -> None:
    seeds = range(100, 115) if task.backend == "grid" else range(100, 102)
    scores = task.evaluate(GreedyAgent, seeds)
    episodes = [
        run_episode(
            "greedy", task.backend, task.layout, seed, task.battery, task.max_steps,
            start_pos=task.start_pos, randomize=task.randomize,
        )
        for seed in seeds
    ]  # fmt: skip
    assert scores.rows == [row_of(episode) for episode in episodes]
    assert scores.nodes == [0] * len(seeds)
    assert scores.lengths.tolist() == [episode.steps for episode in episodes]
    assert scores.delivered.tolist() == [episode.terminated for episode in episodes]
    assert scores.delivered.any()


def test_an_agent_is_made_for_each_seed_and_reset_before_it_acts() -> None:
    notes: list[object] = []

    def make(seed: int) -> Waiter:
        notes.append(f"seed {seed}")
        return Waiter(notes)

    scores = Task(max_steps=2).evaluate(make, [7, 5])
    assert notes == ["seed 7", "reset", 0, 1, "seed 5", "reset", 0, 1]
    assert scores.delivered.tolist() == [False, False]
    assert scores.lengths.tolist() == [2, 2]


def test_each_robot_of_each_episode_has_an_agent_with_a_seed_of_its_own() -> None:
    seeds: list[int] = []

    def make(seed: int) -> GreedyAgent:
        seeds.append(seed)
        return GreedyAgent(seed)

    task = FleetTask(robots=3, max_steps=2)
    scores = task.evaluate(make, [0, 1, 5])
    assert seeds == [*range(6), 15, 16, 17]
    assert [row.seed for row in scores.rows] == [0, 1, 5]


def test_the_scores_of_a_fleet_are_means_of_its_episodes() -> None:
    rows = [
        fleet_row(0, per_hour=100.0, blocked_by_robot=10, steps=100),
        fleet_row(1, per_hour=200.0, blocked_by_robot=80, steps=200),
    ]
    scores = FleetScores(rows, robots=2)
    assert (scores.per_hour.estimate, scores.blocked.estimate) == (150, (0.05 + 0.2) / 2)
    assert scores.summary == "150 per hour"
    assert math.isnan(FleetScores([fleet_row(0, per_hour=None)], 2).per_hour.estimate)
