"""A network with memory that was cloned from A*, on many kinds of layouts that it has never seen.

``SEEDS=0 pytest tests/benchmarks/bench_clone.py`` trains with one seed. The settings were chosen
with seeds from 100 on. Training takes as many steps as ``warehouse train clone --layout random``.
Each agent acts alone, computes with NumPy, and has no penalty for repeated visits.
"""

import os
import random
import time
from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import NamedTuple

import pytest

from agents import CloneAgent, ExploringAgent, GreedyAgent, ModelBasedAgent, PPOAgent
from agents.lab.commands.train import KINDS, make_clone_learner, make_learner
from agents.lab.trials.random_layouts import RandomLayouts, VariedLayouts
from agents.lab.trials.task import Task
from agents.learning.learner import MakeAgent
from warehouse_core import Layout, random_layout
from warehouse_core.world.generators import maze_layout
from warehouse_core.world.tiles import EMPTY, WALL, Cell


def rooms(height: int, width: int, seed: int) -> Layout:
    """Return a hall that is halved again and again, with one door between two halves."""
    stream, tiles = random.Random(f"rooms {seed}"), _hall(height, width)

    def halve(rows: range, columns: range) -> None:
        most = max(len(rows), len(columns))
        if most < 6 or (most < 9 and stream.random() < 0.3):
            return
        is_high = len(rows) >= len(columns)
        length, across = (rows, columns) if is_high else (columns, rows)

        def cell(along: int, side: int) -> Cell:
            return (along, side) if is_high else (side, along)

        places = list(length[2:-2])
        stream.shuffle(places)
        for at in places:
            ends = [cell(at, across[0] - 1), cell(at, across[-1] + 1)]
            if all(tiles[row][col] == WALL for row, col in ends):  # no wall ends at a door
                door = stream.choice(across)
                for side in across:
                    row, col = cell(at, side)
                    tiles[row][col] = EMPTY if side == door else WALL
                for half in (range(length[0], at), range(at + 1, length[-1] + 1)):
                    halve(*((half, across) if is_high else (across, half)))
                return

    halve(range(1, height - 1), range(1, width - 1))
    return _layout(tiles)


def _hall(height: int, width: int) -> list[list[str]]:
    border, row = [WALL] * width, [WALL, *[EMPTY] * (width - 2), WALL]
    return [border, *(row.copy() for _ in range(height - 2)), border.copy()]


def _layout(tiles: list[list[str]]) -> Layout:
    return Layout(["".join(row) for row in tiles])


SEEDS = [int(seed) for seed in os.environ.get("SEEDS", "0 1 2").split()]
FIRST, PPO_STEPS = 900_000, 2_500_000
EPISODES = 150
TRAINING_MINUTES = 30.0


class Floors(NamedTuple):
    """A kind of layout, the maximum number of steps, and the share that a clone must deliver."""

    make: Callable[[int], Layout]
    max_steps: int
    least: float


FLOORS = {
    "random layouts, 7 x 12": Floors(RandomLayouts().layout, 200, 0.99),
    "random layouts, 12 x 20": Floors(RandomLayouts(12, 20).layout, 200, 0.99),
    "rooms, 7 x 12": Floors(partial(rooms, 7, 12), 200, 0.99),
    "rooms, 12 x 20": Floors(partial(rooms, 12, 20), 200, 0.9),
    "density 0.1, 25 x 25": Floors(partial(random_layout, 25, 25, 0.1), 200, 0.95),
    "density 0.4, 25 x 25": Floors(partial(random_layout, 25, 25, 0.4), 400, 0.95),
    "perfect mazes, 25 x 25": Floors(partial(maze_layout, 25, 25), 800, 0.6),
}

OTHERS: dict[str, MakeAgent] = {
    "greedy": GreedyAgent,
    "model": lambda seed: ModelBasedAgent(),
    "exploring": lambda seed: ExploringAgent(),
}


def delivered(make_agent: MakeAgent, floors: Floors) -> float:
    """Return the share of episodes in which an agent delivers."""
    done = [
        Task(floors.make(seed).with_tiles((), (), ()), floors.max_steps, floors.max_steps)
        .evaluate(make_agent, [seed])
        .delivered[0]
        for seed in range(FIRST, FIRST + EPISODES)
    ]
    return sum(done) / len(done)


@cache
def clone_of_astar(seed: int) -> tuple[MakeAgent, float]:
    """Return a clone, and the CPU time of its training in minutes."""
    task = Task(VariedLayouts(pool_seed=seed), 800, 800)
    begin = time.process_time()
    learner = make_clone_learner("astar", task, KINDS["clone"].steps, seed)
    learner.learn(lambda *_: None)
    return learner.agents(), (time.process_time() - begin) / 60


def agents() -> Iterator[tuple[str, MakeAgent]]:
    yield from OTHERS.items()
    learner = make_learner(Task(RandomLayouts(pool_seed=SEEDS[0])), PPO_STEPS, SEEDS[0])
    learner.learn(lambda *_: None)
    network = learner.network()
    yield "PPO without memory", lambda seed: PPOAgent(network)
    yield "PPO without memory, revisit=4", lambda seed: PPOAgent(network, revisit=4.0)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_clone_delivers_on_unseen_layouts(seed: int, measured) -> None:
    make_agent, minutes = clone_of_astar(seed)
    assert isinstance(make_agent(0), CloneAgent)
    shares = {name: delivered(make_agent, floors) for name, floors in FLOORS.items()}
    words = "; ".join(f"{name}: {share:.1%}" for name, share in shares.items())
    measured(
        f"deliveries of a clone of A* with memory, seed {seed}, {EPISODES} unseen layouts of each "
        "kind",
        f"{words}; trained in {minutes:.1f} min of CPU time",
    )
    assert minutes < TRAINING_MINUTES
    for name, floors in FLOORS.items():
        assert shares[name] >= floors.least, name


def test_other_agents_on_the_same_layouts(measured) -> None:
    for agent, make_agent in agents():
        shares = {name: delivered(make_agent, floors) for name, floors in FLOORS.items()}
        words = "; ".join(f"{name}: {share:.1%}" for name, share in shares.items())
        measured(f"deliveries of {agent}, {EPISODES} layouts of each kind", words)
