"""A replay that shows the belief of an exploring agent next to the world.

``T`` is the number of steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate, product
from typing import NamedTuple

from agents.search.agents import ExploringAgent
from warehouse_core import Episode, Layout
from warehouse_core.render.atlas import UNSEEN
from warehouse_core.task.state import Observation
from warehouse_core.viz.tracks.record_track import step_captions, track_of_record
from warehouse_core.viz.tracks.track import TileRows, Track, middle
from warehouse_core.world.tiles import CHARGER, DROPOFF, PICKUP, Cell


class Insight(NamedTuple):
    """The knowledge that an agent gained before an action, and its plan at this action.

    Attributes:
        seen: tile, ``"#"`` or ``"."``, of each cell that the agent saw for the first time.
        route: cells of the plan, beginning with the cell of the robot.
    """

    seen: dict[Cell, str]
    route: tuple[Cell, ...]


def noted(agent: ExploringAgent, layout: Layout) -> list[Insight]:
    """Return a list to which each future action of an agent adds an ``Insight``."""
    cells = {*product(range(layout.height), range(layout.width))}
    history: list[Insight] = []
    act = agent.act

    def acting(observation: Observation) -> str:
        action = act(observation)
        seen = {cell: tile for cell, tile in agent.belief.news.items() if cell in cells}
        history.append(Insight(seen, agent.route))
        return action

    agent.act = acting  # type: ignore[method-assign]
    return history


def believed_tiles(layout: Layout, history: Sequence[Insight]) -> list[TileRows]:
    """Return ``[T]`` the layout that the agent believed in when it chose each action.

    Unseen cells are ``UNSEEN``, except for the two stations whose cells the observations contain.
    If an action added no new cells, its rows are the same object as the previous rows.
    """
    grid = [[UNSEEN] * layout.width for _ in range(layout.height)]
    sensed = dict.fromkeys(layout.pickups[:1], PICKUP)
    sensed |= dict.fromkeys(layout.dropoffs[:1], DROPOFF)
    for (row, col), tile in sensed.items():
        grid[row][col] = tile
    known = dict.fromkeys(layout.chargers, CHARGER) | sensed
    rows: TileRows = tuple(map("".join, grid))
    believed = []
    for insight in history:
        for (row, col), tile in insight.seen.items():
            grid[row][col] = known.get((row, col), tile)
        if insight.seen:
            rows = tuple(map("".join, grid))
        believed.append(rows)
    return believed


def belief_tracks(episode: Episode, history: Sequence[Insight]) -> tuple[Track, Track]:
    """Return the tracks of the agent's belief and of the world, with frames at the same times.

    The charts, captions and ending are in the track of the belief, because the agent acts on it.

    Raises:
        ValueError: ``history`` is not as long as ``episode``.
    """
    if not history or len(history) != episode.steps:
        raise ValueError(f"history has {len(history)} insights for {episode.steps} steps")
    belief = track_of_record(episode)
    world = replace(
        belief,
        frames=[replace(frame, caption="", energy=0.0) for frame in belief.frames],
        metrics={},
        is_continuous=False,
        title="The world",
        ending="",
    )
    tiles = believed_tiles(episode.layout, history)
    counts = list(accumulate(len(insight.seen) for insight in history))
    words, last = step_captions(episode), belief.frames[-1]
    for index, frame in enumerate(belief.frames):
        # No action follows the last frame, so it shows the choice of the last action.
        choice = min(belief.step_at(index), len(history) - 1)
        frame.tiles = tiles[choice]
        [pose] = frame.robots
        ahead = history[choice].route[1:]
        if pose is not None and ahead:  # the robot covers the first cell of the plan
            frame.route = (pose.at, *map(middle, ahead))
        if frame is not last:  # the last frame keeps the diagnosis as its caption
            frame.caption = f"{words[choice]} ({counts[choice]} cells seen)"
    belief.captions_next = True
    belief.title = f"Belief of {belief.title}"
    return belief, world
