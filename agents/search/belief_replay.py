"""A replay of the world beside what an exploring agent believes of it, move by move.

``F`` is the number of drawn frames, ``T`` of steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from agents.search.agents import ExploringAgent
from warehouse_core import Episode, Layout, WarehouseEnv, record_episode
from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.window import has_display
from warehouse_core.task.state import Observation
from warehouse_core.viz.replay import Replay
from warehouse_core.viz.robot_view import ROBOT_RADIUS
from warehouse_core.viz.track import (
    FRAME_SECONDS,
    Point,
    Rows,
    Track,
    step_captions,
    track_of_episode,
)
from warehouse_core.warehouse_viz import INTERVAL_MS
from warehouse_core.world.tiles import DROPOFF, PICKUP, Cell

GAP = ROBOT_RADIUS + 0.05
"""In cells, from the middle of the robot to the first dot of its plan."""


@dataclass(frozen=True, slots=True)
class Insight:
    """What had changed when an agent chose an action.

    Attributes:
        seen: the cells that it now knows, or knows otherwise, ``"#"`` or ``"."``.
        route: the cells of its plan, from the one where it was.
    """

    seen: dict[Cell, str]
    route: tuple[Cell, ...]


class WatchedAgent:
    """An exploring agent, and what it learns from action to action.

    Args:
        agent: that chooses the actions.

    Attributes:
        history: ``[T]`` of its insights since the last reset.
    """

    def __init__(self, agent: ExploringAgent) -> None:
        self._agent = agent
        self.history: list[Insight] = []
        self._known: dict[Cell, str] = {}

    @property
    def reason(self) -> str:
        """Why it chose its last action."""
        return self._agent.reason

    def reset(self) -> None:
        """Forget everything."""
        self._agent.reset()
        self.history = []
        self._known = {}

    def act(self, observation: Observation) -> str:
        """Return the agent's action, and keep what it has learnt."""
        action = self._agent.act(observation)
        seen = dict(self._agent.belief.known.items() - self._known.items())
        self._known |= seen
        self.history.append(Insight(seen, self._agent.route))
        return action


def record_beliefs(
    env: WarehouseEnv, agent: ExploringAgent, *, seed: int | None = None, randomize: bool = True
) -> tuple[Episode, list[Insight]]:
    """Do what ``record_episode`` does, and return its record and what the agent learnt.

    Args:
        env: any environment, with any backend.
        agent: that is watched.
        seed: given to ``env.reset``.
        randomize: given to ``env.reset``.

    Returns:
        The record, the same as without a watcher, and ``[T]`` insights.
    """
    watched = WatchedAgent(agent)
    episode = record_episode(env, watched, seed=seed, randomize=randomize)
    return replace(episode, agent=type(agent).__name__), watched.history


def believed_tiles(layout: Layout, history: Sequence[Insight]) -> list[Rows]:
    """Return ``[T]`` the layout as it was believed to be when each action was chosen.

    What has not been seen is ``UNSEEN``, but for the two stations that the robot senses from
    afar. Where nothing new was seen, the rows are the same object again.
    """
    grid = [[UNSEEN] * layout.width for _ in range(layout.height)]
    sensed = dict.fromkeys(layout.pickups[:1], PICKUP)
    sensed |= dict.fromkeys(layout.dropoffs[:1], DROPOFF)
    for (row, col), tile in sensed.items():
        grid[row][col] = tile
    rows: Rows = tuple(map("".join, grid))
    found = []
    for insight in history:
        # A robot at the rim sees walls beyond it.
        fresh = {cell: insight.seen[cell] for cell in insight.seen if _is_inside(layout, cell)}
        for (row, col), tile in fresh.items():
            grid[row][col] = sensed.get((row, col), tile)
        if fresh:
            rows = tuple(map("".join, grid))
        found.append(rows)
    return found


def belief_tracks(
    episode: Episode, history: Sequence[Insight], frame_seconds: float = FRAME_SECONDS
) -> tuple[Track, Track]:
    """Return the tracks of the world and of what the agent believes, frame by frame the same.

    The charts, and the words about each move, are with the belief: it is what a move is made on.

    Args:
        episode: of an agent that was watched.
        history: ``[T]`` of its insights.
        frame_seconds: simulated time between two frames of a continuous motion.

    Raises:
        ValueError: ``history`` is not that of ``episode``.
    """
    if not history or len(history) != episode.steps:
        raise ValueError(f"history has {len(history)} insights for {episode.steps} steps")
    belief = track_of_episode(episode, frame_seconds)
    world = replace(belief, metrics={}, captions=[""] * len(belief), clock=[], speed=[], energy=[])
    tiles, counts = believed_tiles(episode.layout, history), seen_counts(episode.layout, history)
    # The last frame shows where the last action has led to, and no further one.
    choices = [min(belief.step_at(frame), len(history) - 1) for frame in range(len(belief))]
    belief.tiles = [tiles[choice] for choice in choices]
    belief.routes = [
        _way_ahead(pose.at, history[choice].route) if pose else ()
        for pose, choice in zip(belief.poses, choices, strict=True)
    ]
    words = step_captions(episode)
    # The last frame keeps what became of it all.
    belief.captions[:-1] = [
        f"now {words[choice]}, {counts[choice]} cells seen" for choice in choices[:-1]
    ]
    belief.title, belief.ending = "What it believes", ""
    return world, belief


def belief_replay(
    episode: Episode,
    history: Sequence[Insight],
    interval_ms: float = INTERVAL_MS,
    speed: float = 1.0,
    *,
    window: bool | None = None,
    frame_seconds: float = FRAME_SECONDS,
) -> Replay:
    """Return the replay of the world beside what the agent believes of it.

    Args:
        episode: of an agent that was watched.
        history: ``[T]`` of its insights.
        interval_ms: from one frame to the next at speed 1, in milliseconds.
        speed: factor on the playing speed.
        window: whether ``show`` is to open a window; ``None`` means wherever there is a display.
        frame_seconds: simulated time between two frames of a continuous motion.

    Raises:
        ValueError: ``history`` is not that of ``episode``, or a bad interval or speed.
    """
    world, belief = belief_tracks(episode, history, frame_seconds)
    return Replay(
        world,
        interval_ms,
        speed,
        window=has_display() if window is None else window,
        beside=belief,
    )


def seen_counts(layout: Layout, history: Sequence[Insight]) -> list[int]:
    """Return ``[T]`` how many cells of a layout had been seen when each action was chosen."""
    seen: set[Cell] = set()
    counts = []
    for insight in history:
        seen.update(cell for cell in insight.seen if _is_inside(layout, cell))
        counts.append(len(seen))
    return counts


def _is_inside(layout: Layout, cell: Cell) -> bool:
    return cell[0] in range(layout.height) and cell[1] in range(layout.width)


def _way_ahead(at: Point, route: Sequence[Cell]) -> tuple[Point, ...]:
    """Return the middles of the cells ahead, after the rim of the robot."""
    ahead = [(col + 0.5, row + 0.5) for row, col in route[1:]]
    if ahead and math.dist(at, ahead[0]) < GAP:
        del ahead[0]
    if not ahead:
        return ()
    share = GAP / math.dist(at, ahead[0])
    rim = (at[0] + share * (ahead[0][0] - at[0]), at[1] + share * (ahead[0][1] - at[1]))
    return rim, *ahead
