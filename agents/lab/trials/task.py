"""Tasks for agents, whose episodes are the same for every agent.

Each episode has a seed, so that ``warehouse run --seed`` can show it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import closing, nullcontext
from pathlib import Path
from typing import Any, NamedTuple

from agents.lab.console.values import load_layout, parse_cell
from agents.lab.console.watch import slow_steps_reported
from agents.lab.place import Stations, check_stations, default_stations, what_to_draw
from agents.lab.runs.run import Watch, run
from agents.lab.trials.random_layouts import RandomLayouts, VariedLayouts
from agents.lab.trials.rows import fleet_row, lone_row
from agents.lab.trials.scores import FleetScores, Scores
from agents.learning.learner import MakeAgent
from agents.registry import make_agent, make_backend, on_backend
from warehouse_core import (
    DEFAULT_LAYOUT,
    Agent,
    BackendError,
    BatchEnv,
    Cell,
    Episode,
    FleetEnv,
    Layout,
    WarehouseEnv,
)
from warehouse_core.batch.array_env import SAME_STEP
from warehouse_core.extras import not_installed
from warehouse_core.fleet import FleetBatch
from warehouse_core.fleet.env import Actions
from warehouse_core.records import FleetAgent
from warehouse_core.records.episode import DRIVE, is_drive
from warehouse_core.task.starts import STATIONS
from warehouse_core.world.layout import check_open

__all__ = ["Task"]

MakeWatch = Callable[[object, str], Watch]
"""Function that returns a ``Watch`` of an episode, given the agent and its name."""

MakeNamed = Callable[[str, int, Layout], Agent]
"""Function that returns the agent with a name, given the seed and the layout of its episode."""


class Task(NamedTuple):
    """A task for a lone robot.

    Random layouts differ for each seed. The stations of a layout are used unless ``randomize``
    replaces them with random stations.

    Attributes:
        layout: Layout, or random layouts.
        battery: Number of steps that a full battery lasts.
        max_steps: Maximum number of steps in an episode.
        backend: Name of the backend.
        start_pos: Start cell, see ``WarehouseEnv``.
        randomize: Option of ``WarehouseEnv.reset``.
        view_radius: Number of cells that the robot sees in each direction.

    Example:
        >>> from agents import GreedyAgent
        >>> from agents.lab.trials.task import Task
        >>> scores = Task(battery=100).evaluate(GreedyAgent, range(20))
        >>> int(scores.delivered.sum()), len(scores.rows)
        (11, 20)
    """

    layout: Layout | RandomLayouts = DEFAULT_LAYOUT
    battery: int = 200
    max_steps: int = 200
    backend: str = "grid"
    start_pos: Cell | None = None
    randomize: bool | str = True
    view_radius: int = 2

    @property
    def stations(self) -> Stations:
        """Source of pickup and dropoff."""
        return Stations.DRAWN if self.randomize in (True, STATIONS) else Stations.KEPT

    @property
    def seed_stride(self) -> int:
        """Distance between the seeds of an evaluation: 1, or 4 if layouts are varied and large."""
        return 4 if isinstance(self.layout, VariedLayouts) else 1

    def layout_for(self, seed: int) -> Layout:
        """Return the layout of the episode with a seed."""
        return self.layout if isinstance(self.layout, Layout) else self.layout.layout(seed)

    def make_env(self, seed: int = 0) -> Any:
        """Return the environment for the episode with a seed.

        It is a ``DriveEnv`` if the backend means continuous control, and otherwise a
        ``WarehouseEnv``. Under continuous control, ``max_steps`` and ``battery`` count moves over
        one cell, and ``randomize`` is used instead of the argument of ``reset``.

        Raises:
            BackendError: a setting is wrong, or a library is not installed.
        """
        layout, limits = self.layout_for(seed), (self.max_steps, self.battery)
        if not is_drive(self.backend):
            backend = make_backend(self.backend)
            return WarehouseEnv(layout, self.start_pos, *limits, self.view_radius, backend=backend)
        try:
            from warehouse_physics.drive import DriveEnv

            return DriveEnv.from_name(
                self.backend, layout, start_pos=self.start_pos, randomize=self.randomize,
                moves=self.max_steps, units=self.battery,
            )  # fmt: skip
        except ImportError as error:
            raise BackendError(not_installed("backend 'drive' needs", error, "physics")) from error
        except ValueError as error:
            raise BackendError(f"backend {self.backend!r}: {error}") from error

    def make_batch(self, rows: int) -> BatchEnv:
        """Return a batch of environments for training on the grid.

        Stations and starts are random.
        """
        return BatchEnv(
            rows,
            self.layout if isinstance(self.layout, Layout) else None,
            pool=None if isinstance(self.layout, Layout) else self.layout.pool(),
            max_steps=self.max_steps,
            battery=self.battery,
            autoreset_mode=SAME_STEP,
        )

    def run(self, name: str, seed: int, make: MakeNamed = make_agent) -> Episode:
        """Run the episode of a seed with the agent of a name, and print its slow steps.

        Args:
            name: name of the agent, see ``agents.registry.make_agent``.
            seed: seed of the episode and of the agent.
            make: function that returns the agent, given its name, the seed and the layout.

        Raises:
            EpisodeError: the agent or the backend failed.
            EpisodeInterrupted: Ctrl-C was pressed.
        """

        def act(backend: str) -> Episode:
            if backend == DRIVE and is_drive(name):  # a trained policy has an environment
                trained: Any = make_agent(name)
                backend = trained.backend
            with closing(self._replace(backend=backend).make_env(seed)) as env:
                agent = make(name, seed, self.layout_for(seed))
                watch = slow_steps_reported(agent, name)
                return run(env, agent, seed, watch, name=name, randomize=self.randomize)

        return on_backend(self.backend, act)

    def evaluate(
        self,
        make_agent: MakeAgent,
        seeds: Iterable[int],
        name: str = "",
        make_watch: MakeWatch = lambda agent, name: nullcontext,
    ) -> Scores:
        """Run one episode for each seed, each with a new agent, and return the scores.

        Args:
            make_agent: function that returns the agent for a seed.
            seeds: seeds of the episodes.
            name: name of the agent.
            make_watch: function that returns a ``Watch`` for an agent and its name.

        Raises:
            EpisodeError: see ``run``.
        """
        rows, expanded = [], []  # a search counts the nodes that it has expanded
        for seed in seeds:
            agent = make_agent(seed)
            with closing(self.make_env(seed)) as env:
                watch = make_watch(agent, name)
                episode = run(env, agent, seed, watch, name=name, randomize=self.randomize)
            rows.append(lone_row(episode))
            expanded.append(getattr(agent, "expanded", 0))
        return Scores(rows, expanded)


def load_task(
    path: Path | None, stations: Stations | None = None, start: str | None = None, **others: Any
) -> Task:
    """Return the task in the layout of a file, or by default in the layout of the chapter.

    Args:
        path: name or file of a layout.
        stations: source of the stations; ``None`` keeps the stations of a file that has any,
            and draws others at random.
        start: cell as ``ROW,COL``; ``None`` is a random cell.
        others: other fields of the task.

    Raises:
        LayoutError: no episode can take place in the layout.
    """
    layout, cell = load_layout(path), parse_cell(start, "--start")
    if cell is not None:
        check_open(layout, cell, "--start")
    chosen = stations or default_stations(layout, is_default=layout is DEFAULT_LAYOUT)
    check_stations(layout, chosen, path, "--stations drawn")
    return Task(layout, start_pos=cell, randomize=what_to_draw(chosen, cell), **others)


class FleetTask(NamedTuple):
    """A task for a fleet, with arguments of ``FleetEnv`` and ``FleetBatch``."""

    layout: Layout = DEFAULT_LAYOUT
    robots: int = 4
    orders: float = 0.2
    battery: int = 200
    max_steps: int = 200

    @property
    def seed_stride(self) -> int:
        """Distance between the seeds of an evaluation; few episodes have enough deliveries."""
        return 10

    def make_env(self) -> FleetEnv:
        """Return an environment for the fleet."""
        return FleetEnv(**self._asdict())

    def make_batch(self, rows: int) -> FleetBatch:
        """Return a batch for training with at most ``rows`` robots, but at least one fleet."""
        fleets = max(rows // self.robots, 1)
        return FleetBatch(fleets, **self._asdict(), autoreset_mode=SAME_STEP)

    def evaluate(self, make_agent: MakeAgent, seeds: Iterable[int]) -> FleetScores:
        """Run one episode for each seed, with a separate agent and seed for each robot."""
        return self.evaluate_fleet(lambda seed: _Each(make_agent, seed, self.robots), seeds)

    def evaluate_fleet(
        self, make_agent: Callable[[int], FleetAgent], seeds: Iterable[int]
    ) -> FleetScores:
        """Run one episode for each seed, with one agent that controls all robots."""
        with closing(self.make_env()) as env:
            rows = [fleet_row(run(env, make_agent(seed), seed)) for seed in seeds]
        return FleetScores(rows, self.robots)


class _Each:
    """A fleet agent that combines a separate agent for each robot."""

    def __init__(self, make_agent: MakeAgent, seed: int, robots: int) -> None:
        self._agents = [make_agent(seed * robots + robot) for robot in range(robots)]

    def reset(self) -> None:
        for agent in self._agents:
            agent.reset()

    def act(self, env: FleetEnv) -> Actions:
        pairs = zip(self._agents, env.observations(), strict=True)
        return [agent.act(observation) for agent, observation in pairs]
