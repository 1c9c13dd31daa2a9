"""Training of ``warehouse train clone`` from a planner of fleets, and its comparison at the end."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from agents.errors import AgentError
from agents.lab.commands.pogema.maps import maze_map, random_map
from agents.lab.commands.train import (
    CHECKPOINT_SUFFIX,
    check_agent_file,
    installed_versions,
    needed_libraries,
)
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.training.checkpoint import load_checkpoint, save_checkpoint
from agents.lab.training.exams import EXAMS, FINAL_SEEDS
from agents.lab.trials.interval import Interval, mean_interval
from agents.lab.trials.random_layouts import MAX_POOL, TRAINING_LAYOUTS
from agents.lab.trials.wording import mean
from agents.lab.trials.workers import deferred_interrupts
from agents.learning.clone_planner import ClonePlanner
from agents.learning.traffic_network import TrafficNetwork
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.planner import Planner
from agents.registry import make_planner
from warehouse_core import DEFAULT_LAYOUT, Layout
from warehouse_core.files.atomic import check_target

if TYPE_CHECKING:
    from agents.learning.fleet_clone_training import FleetCloneLearner

STEPS = 160
"""Steps of an episode of the training."""

FINAL_STEPS, FINAL_EPISODES = 256, 20
"""Steps and number of the episodes of the comparison at the end."""

PLAIN = "pibt"
"""Planner that is compared with the clone and its teacher."""


CROWD = 3
"""Open cells for each robot, at least."""

Floor = tuple[Layout, int]
"""A layout, and the number of robots on it."""


class FleetFloors(NamedTuple):
    """Floors of a fleet: one layout, or random ones by the generators of POGEMA's benchmark.

    Random floors are random maps and mazes by turns, with 17 to 21 rows and columns.

    Attributes:
        robots: most robots on a floor, as far as there is room.
        layout: the layout; ``None`` stands for random ones.
        layouts: number of random layouts of the training.
        seed: seed of these layouts, of which two share none.
    """

    robots: int
    layout: Layout | None
    layouts: int
    seed: int

    def pool(self) -> list[Floor]:
        """Return the floors of the training."""
        first = TRAINING_LAYOUTS + self.seed * MAX_POOL
        return [
            self.floor(first + number)
            for number in range(self.layouts if self.layout is None else 1)
        ]

    def floor(self, seed: int) -> Floor:
        """Return the floor of a seed; the training has those from ``TRAINING_LAYOUTS`` on."""
        layout = self.layout
        if layout is None:
            layout = random_map(seed) if seed % 2 else maze_map(seed)
        return layout, max(min(self.robots, len(layout.open_cells) // CROWD), 1)


def train_fleet(
    teacher: str, floors: FleetFloors, steps: int, seed: int, save: Path, *, resume: bool
) -> None:
    """Train a network by imitation of a planner, write it, and compare both with PIBT.

    An interrupt ends the training, and what has been learned by then is written.
    """
    from agents.lab.console.progress import progress_bar  # imports rich

    check_agent_file(save)
    checkpoint = save.with_suffix(CHECKPOINT_SUFFIX)
    for path in (save, checkpoint):
        check_target(path)
    learner = make_fleet_learner(teacher, floors, steps, seed)
    options = {
        "training": f"clone of {teacher}",
        "steps": steps,
        "seed": seed,
        **floors._asdict(),
        "layout": floors.layout and floors.layout.rows,
        **installed_versions(),
    }
    if resume and checkpoint.exists():
        load_checkpoint(checkpoint, options, learner)
        say(f"resumed after {learner.done:,} of {steps:,} steps")
    elif resume:
        say(f"{checkpoint} does not exist; the training begins", error=True)
    begin, exams = time.perf_counter(), learner.done * EXAMS // steps

    def keep() -> None:
        learner.network().save(save)
        save_checkpoint(checkpoint, options, learner, None)

    with deferred_interrupts() as check, progress_bar(steps, f"clone of {teacher}") as show:

        def watch(done: int, throughput: float) -> None:
            nonlocal exams
            show(min(done, steps), f"{throughput:.2f} goals a step")
            if done * EXAMS // steps > exams:
                exams = done * EXAMS // steps
                keep()
            check()

        try:
            network = learner.learn(watch)
        except KeyboardInterrupt:
            keep()
            say(f"saved {save}; the same command with --resume goes on from here")
            raise
    say(f"{learner.done:,} steps of robots in {time.perf_counter() - begin:.1f} s, seed {seed}")
    say(f"saved {save}")
    print_table(comparison(teacher, network, floors))


def make_fleet_learner(
    teacher: str, floors: FleetFloors, steps: int, seed: int
) -> FleetCloneLearner:
    """Return a learner from a planner; an ``AgentError`` says how to install what is missing."""
    planner_of(teacher, DEFAULT_LAYOUT, 1, seed)  # a wrong name is an error before the training
    with needed_libraries("imitation"):
        from agents.learning.fleet_clone_training import FleetCloneLearner
    return FleetCloneLearner(
        floors.pool(),
        lambda episode, layout, count: planner_of(teacher, layout, count, episode),
        lanes=teacher.partition(":")[0].endswith("-lanes"),
        episode_steps=STEPS,
        steps=steps,
        seed=seed,
    )


def planner_of(name: str, layout: Layout, robots: int, seed: int) -> Planner:
    """Return a planner by name, or raise an ``AgentError``."""
    made = make_planner(name, seed, layout, robots)
    if not isinstance(made, Planner):
        raise AgentError(f"planner {name!r} has no next_cells, so that nothing can be learned")
    return made


def comparison(teacher: str, network: TrafficNetwork, floors: FleetFloors) -> TextTable:
    """Return a table of the goals a step that a clone, its teacher and PIBT reach."""
    makers: dict[str, Callable[[Layout, int, int], Planner]] = {
        f"clone of {teacher}": lambda layout, count, seed: ClonePlanner.on(network, layout, seed),
        teacher: lambda layout, count, seed: planner_of(teacher, layout, count, seed),
        PLAIN: lambda layout, count, seed: planner_of(PLAIN, layout, count, seed),
    }
    rows = list[tuple[str, ...]]()
    for name, make in makers.items():
        runs = []
        for seed in FINAL_SEEDS[:FINAL_EPISODES]:
            layout, count = floors.floor(seed)
            planner = make(layout, count, seed)
            runs.append(run_lifelong(Graph(layout), planner, count, FINAL_STEPS, seed))
        reached = np.array([run.throughput for run in runs])
        seconds = np.mean([run.seconds.mean() for run in runs])
        interval = mean_interval(reached) or Interval(float(reached.mean()))
        rows.append((name, mean(interval, ""), f"{1000 * seconds:.1f}"))
    return TextTable(
        ("", "goals a step", "ms a step"),
        rows,
        f"{FINAL_EPISODES} episodes of {FINAL_STEPS} steps, the same for each",
    )
