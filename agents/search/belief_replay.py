"""A replay of an exploring agent's belief, beside the world. ``T`` is the number of steps."""

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
    """Cells that an agent had not seen before it chose an action, and the cells of its plan.

    Tiles are ``"#"`` or ``"."``; the plan begins with the cell of the robot.
    """

    seen: dict[Cell, str]
    route: tuple[Cell, ...]


def noted(agent: ExploringAgent, layout: Layout) -> list[Insight]:
    """Return a list to which each further action of an agent on a layout adds an insight."""
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
    """Return ``[T]`` the layout as the agent believed it to be when it chose each action.

    Cells not seen are ``UNSEEN``, except the two stations that observations name. If nothing new
    was seen, the rows are the same object as before.
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
    """Return the tracks of the agent's belief and of the world, with the same frames in time.

    The charts, captions and ending belong to the belief, because the agent acts on it.

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
        # The last frame shows the result of the last action, and no further one.
        choice = min(belief.step_at(index), len(history) - 1)
        frame.tiles = tiles[choice]
        [pose] = frame.robots
        ahead = history[choice].route[1:]
        if pose is not None and ahead:  # the robot covers the beginning
            frame.route = (pose.at, *map(middle, ahead))
        if frame is not last:  # which keeps the diagnosis
            frame.caption = f"now {words[choice]}, {counts[choice]} cells seen"
    belief.tells_next = True
    belief.title = f"Belief of {belief.title}"
    return belief, world
