"""What agents have to do: tasks whose episodes are the same for every agent.

Each episode has a seed, so ``warehouse run --seed`` shows any of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing, nullcontext
from typing import NamedTuple, Protocol, runtime_checkable

from agents.lab.runs.run import Watch, run
from agents.lab.trials.random_layouts import RandomLayouts, VariedLayouts
from agents.lab.trials.rows import fleet_row, lone_row
from agents.lab.trials.scores import FleetScores, Scores
from agents.learning.learner import MakeAgent
from agents.registry import make_backend
from warehouse_core import DEFAULT_LAYOUT, Agent, BatchEnv, Cell, FleetEnv, Layout, WarehouseEnv
from warehouse_core.batch.array_env import SAME_STEP
from warehouse_core.fleet import FleetBatch
from warehouse_core.fleet.env import Actions
from warehouse_core.records import FleetAgent

__all__ = ["FleetTask", "Task"]

MakeWatch = Callable[[object, str], Watch]
"""Makes what watches an agent, given its name, through an episode."""


@runtime_checkable
class Searching(Protocol):
    """An agent that counts the nodes it has expanded since its last reset."""

    expanded: int


class Task(NamedTuple):
    """What a lone robot has to do, by arguments of ``WarehouseEnv`` and of its ``reset``.

    The layout has walls, and the stations if they are not drawn; random ones differ for each seed.

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

    @property
    def seed_stride(self) -> int:
        """1: each seed of an evaluation is used; 4 on varied layouts, with their long ways."""
        return 4 if isinstance(self.layout, VariedLayouts) else 1

    def layout_for(self, seed: int) -> Layout:
        """Return the layout of the episode with a seed."""
        return self.layout if isinstance(self.layout, Layout) else self.layout.layout(seed)

    def make_env(self, seed: int = 0) -> WarehouseEnv:
        """Return an environment for the episode with a seed."""
        layout = self.layout_for(seed)
        return WarehouseEnv(
            layout,
            self.start_pos,
            self.max_steps,
            self.battery,
            backend=make_backend(self.backend),
        )

    def make_batch(self, rows: int) -> BatchEnv:
        """Return a batch for training, on the grid backend, with random stations and starts."""
        return BatchEnv(
            rows,
            self.layout if isinstance(self.layout, Layout) else None,
            pool=None if isinstance(self.layout, Layout) else self.layout.pool(),
            max_steps=self.max_steps,
            battery=self.battery,
            autoreset_mode=SAME_STEP,
        )

    def evaluate(
        self,
        make_agent: MakeAgent,
        seeds: Iterable[int],
        name: str = "",
        make_watch: MakeWatch = lambda agent, name: nullcontext,
    ) -> Scores:
        """Run one whole episode for each seed, with an agent of its own; for errors see ``run``."""
        rows, expanded = [], []
        for seed in seeds:
            agent = make_agent(seed)
            watch = make_watch(agent, name)
            with closing(self.make_env(seed)) as env:
                episode = run(env, agent, seed, watch, name=name, randomize=self.randomize)
            rows.append(lone_row(episode))
            expanded.append(agent.expanded if isinstance(agent, Searching) else 0)
        return Scores(rows, expanded)


class FleetTask(NamedTuple):
    """What the robots of a fleet have to do: arguments of ``FleetEnv`` and ``FleetBatch``.

    Example:
        >>> from agents.lab.trials.task import FleetTask
        >>> from agents.registry import make_team
        >>> task = FleetTask(robots=2, max_steps=50)
        >>> scores = task.evaluate_fleet(lambda seed: make_team("greedy", 2, seed), range(3))
        >>> len(scores.rows)
        3
    """

    layout: Layout = DEFAULT_LAYOUT
    robots: int = 4
    orders: float = 0.2
    battery: int = 200
    max_steps: int = 200

    @property
    def seed_stride(self) -> int:
        """10: an episode has many deliveries, so that every tenth seed is enough."""
        return 10

    def make_env(self) -> FleetEnv:
        """Return a fleet for the task."""
        return FleetEnv(**self._asdict())

    def make_batch(self, rows: int) -> FleetBatch:
        """Return a batch for training, of at most so many robots and at least one fleet."""
        fleets = max(rows // self.robots, 1)
        return FleetBatch(fleets, **self._asdict(), autoreset_mode=SAME_STEP)

    def evaluate(self, make_agent: MakeAgent, seeds: Iterable[int]) -> FleetScores:
        """Run one whole episode for each seed, with an agent for each robot, which does as it says.

        Each robot of each episode has its own seed.
        """

        def make_all(seed: int) -> FleetAgent:
            first = seed * self.robots
            return _Each([make_agent(first + robot) for robot in range(self.robots)])

        return self.evaluate_fleet(make_all, seeds)

    def evaluate_fleet(
        self, make_agent: Callable[[int], FleetAgent], seeds: Iterable[int]
    ) -> FleetScores:
        """Run one whole episode for each seed, with an agent that directs all robots."""
        with closing(self.make_env()) as env:
            rows = [fleet_row(run(env, make_agent(seed), seed)) for seed in seeds]
        return FleetScores(rows, self.robots)


class _Each:
    """Robots each of which does what its agent says."""

    def __init__(self, agents: Sequence[Agent]) -> None:
        self._agents = agents

    def reset(self) -> None:
        for agent in self._agents:
            agent.reset()

    def act(self, env: FleetEnv) -> Actions:
        pairs = zip(self._agents, env.observations(), strict=True)
        return [agent.act(observation) for agent, observation in pairs]
