"""Imitation learning (DAgger): a network with a memory learns from a teacher; needs PyTorch.

The network moves the robots, so that the training contains the consequences of its own mistakes.
The teacher labels each state with the right moves.

A network that cannot know what its teacher knows would go round in circles, because it always takes
the likeliest move. Therefore only moves to the neighbours that the robot has visited least are
right. If the teacher's move is one of them, only that move is right. As a result, the network
learns to explore, and learns from the teacher where to begin.

Source: Ross, Gordon and Bagnell, *A Reduction of Imitation Learning and Structured Prediction to
No-Regret Online Learning*, 2011. Koenig and Szymanski, *Value-Update Rules for Real-Time Search*,
1999, on visiting the least visited cell.
"""

from __future__ import annotations

import math
from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import torch

from agents.learning.clone_agent import CloneAgent
from agents.learning.learner import RECENT_EPISODES, MakeAgent, WatchTraining
from agents.learning.map_memory import MOVES, WALLS, MapMemory, SingleFloats, turns, view_size
from agents.learning.policy_network import MoveNetwork, layer_of
from agents.learning.teachers import Teacher
from warehouse_core.batch import BatchEnv
from warehouse_core.world.actions import action_index
from warehouse_core.world.tables import Flags

ENVS = 256
"""Number of warehouses in a batch."""

ROUND = 32
"""Steps of each warehouse between two updates of the network."""

KEPT = 10
"""Number of the latest rounds whose views are used for training."""

UPDATES, VIEWS = 16, 1024
"""Number of updates in a round, and number of views in each of them."""

LEARNING_RATE = 2e-3
"""Learning rate of the first round; it decreases linearly."""

BEST = 0.7
"""Share of warehouses that take the best move; the others take random moves by their scores."""

RADIUS, WIDTH = 3, 64
"""Radius of the map in a view, in cells, and width of the hidden layers."""

PICK, DROP = action_index("PICK"), action_index("DROP")


class Lessons:
    """A buffer of the latest views and their right moves.

    Args:
        most: capacity in views.
        size: length of a view.
    """

    def __init__(self, most: int, size: int) -> None:
        self._views = np.zeros((most, size), np.float16)
        self._right = np.zeros((most, len(MOVES)), np.bool_)
        self._added = 0

    def add(self, views: SingleFloats, right: Flags) -> None:
        """Add the views for which some move is right, in place of the oldest views."""
        useful = right.any(axis=1)
        places = (self._added + np.arange(useful.sum())) % len(self._views)
        self._views[places], self._right[places] = views[useful], right[useful]
        self._added += len(places)

    def draw(self, stream: np.random.Generator, count: int) -> tuple[SingleFloats, Flags]:
        """Return random views, ``[count, ...]``, and their right moves."""
        chosen = stream.integers(min(self._added, len(self._views)), size=count)
        return self._views[chosen].astype(np.float32), self._right[chosen]


class CloneLearner:
    """Training of a network to imitate a teacher in the episodes of a batch.

    Args:
        batch: environments with ``autoreset_mode="SameStep"``, by default ``ENVS`` rows.
        teacher: teacher for the rows of this batch.
        steps: steps of the whole training, rounded up to whole rounds of all rows.
        seed: seed with which a training can be repeated on the same machine with the same versions.

    Example:
        >>> from agents.learning.clone_training import CloneLearner  # doctest: +SKIP
        >>> from agents.learning.teachers import ShortestPaths
        >>> from warehouse_core import BatchEnv
        >>> batch = BatchEnv(64, autoreset_mode="SameStep")
        >>> learner = CloneLearner(batch, ShortestPaths(batch), 100_000, seed=1)  # doctest: +SKIP
    """

    def __init__(self, batch: BatchEnv, teacher: Teacher, steps: int, seed: int) -> None:
        torch.set_num_threads(1)  # the network is small, and sums are repeatable
        torch.manual_seed(seed)
        self._batch, self._teacher = batch, teacher
        self._round, self._rounds = 0, math.ceil(steps / (batch.num_envs * ROUND))
        self._layers = torch.nn.Sequential(
            torch.nn.Linear(view_size(RADIUS), WIDTH), torch.nn.ReLU(),
            torch.nn.Linear(WIDTH, WIDTH), torch.nn.ReLU(), torch.nn.Linear(WIDTH, 1),
        )  # fmt: skip
        self._optimiser = torch.optim.Adam(self._layers.parameters(), LEARNING_RATE)
        self._stream = np.random.default_rng(seed)
        self._memory = MapMemory(batch.num_envs, batch.view_radius, RADIUS)
        self._is_random = np.arange(batch.num_envs) >= BEST * batch.num_envs
        self._lessons = Lessons(KEPT * ROUND * batch.num_envs, view_size(RADIUS))
        self._recent = deque[bool](maxlen=RECENT_EPISODES)
        self._arrays, _ = batch.reset(seed=seed)
        teacher.begin(np.arange(batch.num_envs), self._arrays)
        self._views = self._memory.look(self._arrays)

    def learn(self, watch: WatchTraining) -> MakeAgent:
        """Train to the end, and return a function that makes the agent."""
        size = self._batch.num_envs * ROUND
        while self._round < self._rounds:
            self._watched(watch, size)
            self._act()
            self._update()
            self._round += 1
        self._watched(watch, size)
        return self.agents()

    def state(self) -> Any:
        """Return everything except the teacher's distances, which follow from the layouts."""
        learned = self._layers.state_dict(), self._optimiser.state_dict()
        episodes = self._batch, self._teacher, self._memory, self._arrays, self._views
        return learned, episodes, self._round, self._stream, self._lessons, self._recent

    def restore(self, state: Any) -> None:
        """Continue from the state of a learner with the same arguments."""
        learned, episodes, self._round, self._stream, self._lessons, self._recent = state
        self._layers.load_state_dict(learned[0])
        self._optimiser.load_state_dict(learned[1])
        self._batch, self._teacher, self._memory, self._arrays, self._views = episodes

    def agents(self) -> MakeAgent:
        """Return a function that makes the current agent; further training does not change it."""
        network = self.network()
        return lambda seed: CloneAgent(network)

    def network(self) -> MoveNetwork:
        """Return a copy of the network."""
        layers = [layer_of(part) for part in self._layers if isinstance(part, torch.nn.Linear)]
        return MoveNetwork(self._batch.view_radius, RADIUS, layers)

    def save_network(self, path: Path) -> None:
        """Write the file that ``CloneAgent.load`` reads."""
        self.network().save(path)

    def _watched(self, watch: WatchTraining, size: int) -> None:
        delivers = float(np.mean(self._recent)) if self._recent else math.nan
        watch(self._round * size, delivers, self.agents())

    def _act(self) -> None:
        """Let the network move the robots, and record its views with the right moves."""
        network = self.network()
        for _ in range(ROUND):
            right = self._right()
            self._lessons.add(self._views, right)
            scores = network.scores(self._views)
            scores[self._is_random] += self._stream.gumbel(size=scores[self._is_random].shape)
            masks = self._batch.action_masks()
            actions = np.where(self._memory.is_open, scores, -np.inf).argmax(axis=1)
            actions[masks[:, PICK] > 0], actions[masks[:, DROP] > 0] = PICK, DROP
            self._arrays, _, terminated, truncated, _ = self._batch.step(actions)
            ended = terminated | truncated
            if ended.any():
                self._recent.extend(terminated[ended].tolist())
                self._teacher.begin(np.flatnonzero(ended), self._arrays)
                self._memory.forget(ended)
            self._views = self._memory.look(self._arrays)

    def _right(self) -> Flags:
        """Return the right moves, ``[B, 4]``; none for a robot whose teacher does not move it."""
        taught, memory = self._teacher.moves(self._arrays), self._memory
        visits = np.where(memory.is_open, memory.beside, np.iinfo(np.int32).max)
        least = visits == visits.min(axis=1, keepdims=True)
        both = taught & least
        right: Flags = np.where(both.any(axis=1, keepdims=True), both, least)
        return right & taught.any(axis=1, keepdims=True)

    def _update(self) -> None:
        rate = LEARNING_RATE * (1 - self._round / self._rounds)
        self._optimiser.param_groups[0]["lr"] = rate
        for _ in range(UPDATES):
            views, right = self._lessons.draw(self._stream, VIEWS)
            by_move = torch.from_numpy(views[:, turns(RADIUS)[self._stream.integers(2)]])
            walls = torch.from_numpy(views[:, WALLS] > 0)
            scores = self._layers(by_move)[..., 0].masked_fill(walls, -math.inf)
            # Increase the probability that a move sampled by the scores is any of the right ones.
            wrong = torch.from_numpy(~right)
            gain = scores.masked_fill(wrong, -math.inf).logsumexp(1) - scores.logsumexp(1)
            self._optimiser.zero_grad()
            (-gain.mean()).backward()
            self._optimiser.step()
