"""Imitation of a planner of fleets by one network for all robots; needs PyTorch.

In the first episodes the planner moves the robots, later the network, so that it learns where its
own mistakes lead (DAgger); the planner says what would have been right there.

Source: Ross, Gordon and Bagnell, *A Reduction of Imitation Learning and Structured Prediction to
No-Regret Online Learning*, 2011. Jiang, Wang, Veerapaneni, Duhan, Sartoretti and Li, *Deploying Ten
Thousand Robots: Scalable Imitation Learning for Lifelong Multi-Agent Path Finding*, 2025, on PIBT
in which a network that imitates windowed planning ranks the moves.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch

from agents.learning.clone_planner import ClonePlanner
from agents.learning.lessons import Lessons
from agents.learning.ranking_layers import copied_layers, improve, new_layers
from agents.learning.traffic_network import TrafficNetwork
from agents.learning.traffic_view import IS_OPEN, SIZE
from agents.mapf.kernels.floor import ACTIONS
from agents.mapf.lifelong import run_lifelong
from agents.mapf.planner import Planner, Situation
from warehouse_core import Layout
from warehouse_core.world.tables import Integers

TAUGHT = 0.2
"""Share of the episodes, the first ones, in which the teacher moves the robots."""

LEARNED_FROM = 0.125
"""Share of the robots that are learned from in a step; views of one step have much in common."""

MOST = 80_000
"""Views that are kept to learn from."""

UPDATES, VIEWS = 100, 1024
"""Updates after an episode, and views that each learns from."""

LEARNING_RATE = 2e-3
"""Learning rate of the first episode; it decreases linearly."""

WIDTH = 64
"""Outputs of the hidden layers."""

RECENT = 10
"""Episodes over which the goals a step are averaged."""

MakeTeacher = Callable[[int, Layout, int], Planner]
"""Makes the teacher of an episode, given a seed, the layout and the number of robots."""

Watch = Callable[[int, float], None]
"""Watches a training, given the steps of robots so far and the goals a step of late."""


class FleetCloneLearner:
    """Learns from what a planner would do in the lifelong episodes of fleets.

    Each episode is on one of some floors, with half of the most robots there, or up to all.

    Args:
        floors: layouts, each with the most robots on it.
        make_teacher: makes the teacher.
        lanes: true if shortest ways are by the costs of lanes.
        episode_steps: steps of an episode.
        steps: steps of all robots in the whole training, rounded up to whole episodes.
        seed: seed that repeats a training on the same machine with the same versions.

    Attributes:
        done: steps of all robots so far.

    Example:
        >>> from agents.learning.fleet_clone_training import FleetCloneLearner  # doctest: +SKIP
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.windows import WindowedPlanner
        >>> from warehouse_core import random_layout
        >>> floors = [(random_layout(12, 12, 0.2, seed), 12) for seed in range(4)]
        >>> learner = FleetCloneLearner(  # doctest: +SKIP
        ...     floors, lambda seed, layout, robots: WindowedPlanner(Graph(layout), seed=seed),
        ...     lanes=False, episode_steps=50, steps=10_000, seed=1)
    """

    def __init__(
        self,
        floors: Sequence[tuple[Layout, int]],
        make_teacher: MakeTeacher,
        *,
        lanes: bool,
        episode_steps: int,
        steps: int,
        seed: int,
    ) -> None:
        torch.set_num_threads(1)  # the network is small, and sums are repeatable
        torch.manual_seed(seed)
        self._floors, self._make_teacher, self._lanes = floors, make_teacher, lanes
        self._episode_steps, self._steps = episode_steps, steps
        self.done = 0
        self._layers = new_layers(SIZE, WIDTH)
        self._optimiser = torch.optim.Adam(self._layers.parameters(), LEARNING_RATE)
        self._stream = np.random.default_rng(seed)
        self._lessons = Lessons(MOST, (ACTIONS, SIZE), ACTIONS)
        self._recent = deque[float](maxlen=RECENT)

    def learn(self, watch: Watch) -> TrafficNetwork:
        """Train to the end, and return the network."""
        while self.done < self._steps:
            self._watched(watch)
            self._act()
            self._update()
        self._watched(watch)
        return self.network()

    def state(self) -> Any:
        """Return all that further training depends on, to be pickled before it goes on."""
        learned = self._layers.state_dict(), self._optimiser.state_dict()
        return learned, self.done, self._stream, self._lessons, self._recent

    def restore(self, state: Any) -> None:
        """Go on from a state that a learner with the same arguments had."""
        learned, self.done, self._stream, self._lessons, self._recent = state
        self._layers.load_state_dict(learned[0])
        self._optimiser.load_state_dict(learned[1])

    def network(self) -> TrafficNetwork:
        """Return a copy of the network."""
        return TrafficNetwork(self._lanes, copied_layers(self._layers))

    def _watched(self, watch: Watch) -> None:
        watch(self.done, float(np.mean(self._recent)) if self._recent else math.nan)

    def _act(self) -> None:
        """Run an episode, and keep what robots saw and what would have been right."""
        seed, stream = int(self._stream.integers(2**31)), self._stream
        layout, most = self._floors[int(stream.integers(len(self._floors)))]
        robots = int(stream.integers(-(-most // 2), most + 1))
        pupil = ClonePlanner.on(self.network(), layout, seed)
        moves = self.done < TAUGHT * self._steps
        taught = Taught(
            self._make_teacher(seed, layout, robots), pupil, self._lessons, stream, moves
        )
        run = run_lifelong(pupil.graph, taught, robots, self._episode_steps, seed)
        self._recent.append(run.throughput)
        self.done += robots * self._episode_steps

    def _update(self) -> None:
        rate = LEARNING_RATE * max(1 - self.done / self._steps, 0)
        self._optimiser.param_groups[0]["lr"] = rate
        for _ in range(UPDATES):
            views, right = self._lessons.draw(self._stream, VIEWS)
            shut = torch.from_numpy(views[:, :, IS_OPEN] == 0)
            scores = self._layers(torch.from_numpy(views))[..., 0].masked_fill(shut, -math.inf)
            improve(self._optimiser, scores, torch.from_numpy(~right))


class Taught:
    """A planner that keeps lessons: what a network's planner sees, and what its teacher does.

    Args:
        teacher: planner that does what is right.
        pupil: planner of the network.
        lessons: lessons, to which new ones are added.
        stream: random numbers that draw the robots that are learned from.
        follows: true if the robots move as the teacher says, false if they move by the pupil.
    """

    def __init__(
        self, teacher: Planner, pupil: ClonePlanner, lessons: Lessons,
        stream: np.random.Generator, follows: bool,
    ) -> None:  # fmt: skip
        self._teacher, self._pupil, self._lessons = teacher, pupil, lessons
        self._stream, self._follows = stream, follows

    def reset(self) -> None:
        """Reset both planners."""
        self._teacher.reset()
        self._pupil.reset()

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cells after the next step, and keep what can be learned from it."""
        taught, chosen = (each.next_cells(situation) for each in (self._teacher, self._pupil))
        right = self._pupil.graph.neighbours[situation.cells] == taught[:, None]
        drawn = self._stream.random(len(taught)) < LEARNED_FROM
        self._lessons.add(self._pupil.views[drawn], right[drawn])
        return taught if self._follows else chosen
