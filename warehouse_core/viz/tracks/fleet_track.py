"""What a replay of a fleet draws, read from a ``FleetEpisode``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.vector import NOTHING
from warehouse_core.records.episode import FleetEpisode
from warehouse_core.records.plans import NO_PLANS, StepPlans, check_plans
from warehouse_core.render.palette import ORDER_COLORS
from warehouse_core.viz.tracks.motion_frames import FRAME_SECONDS, check_frame_seconds, frames_along
from warehouse_core.viz.tracks.track import (
    FleetFrame,
    Frame,
    Hit,
    Pose,
    Shift,
    Track,
    Waiting,
    middle,
)
from warehouse_core.wording import counted, printable
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.tiles import manhattan_distance

LATE = len(ORDER_COLORS) - 1
"""The age of an order that is late."""

NOTHING_CARRIED = -1


def track_of_fleet_episode(
    episode: FleetEpisode,
    frame_seconds: float | None = FRAME_SECONDS,
    plans: Sequence[StepPlans] = (),
) -> Track:
    """Return the track of a fleet's record.

    Args:
        episode: the record.
        frame_seconds: as for ``track_of_episode``.
        plans: to be drawn, those before the first step first; there may be fewer than steps.

    Raises:
        ValueError: ``frame_seconds`` is not a positive finite number, or ``plans`` are not those of
            the episode.
        RecordError: continuous motions take more than ``MAX_FRAMES`` frames.
    """
    seconds = float(episode.seconds.max(axis=1).sum())
    is_continuous = bool(episode.motions) and frame_seconds is not None
    check_frame_seconds(frame_seconds, seconds if is_continuous else 0.0)
    check_plans(plans, episode)
    frames = list(_frames(episode, frame_seconds if is_continuous else None, plans))
    robots, backend = counted(episode.robots, "robot"), episode.backend
    title = f"{episode.agent or 'Fleet'}, {robots} on the {backend} backend, seed {episode.seed}"
    track = Track(frames, {}, is_continuous, episode.settings.battery.capacity, printable(title))
    track.view_radius = episode.settings.view_radius
    track.slippery, track.motor_strength = episode.slippery, episode.motor_strength
    if episode.robots == 1:
        track.metrics = _metrics(episode)
    else:
        track.shift = _shift(episode)
    track.ending = _ending(episode)
    return track


def _frames(
    episode: FleetEpisode, frame_seconds: float | None, plans: Sequence[StepPlans]
) -> Iterator[Frame]:
    """Yield the frames, one a step or one every ``frame_seconds``."""
    orders, bodies = _Orders(episode), np.hstack([episode.cells, episode.people])
    loaded = np.hstack([episode.loaded, np.zeros_like(episode.people, np.bool_)]).tolist()
    rows, width, size = episode.layout.rows, episode.layout.width, episode.cell_size
    headings = _headings(episode)

    @cache
    def pose_of(cell: int, heading: float | None, is_loaded: bool) -> Pose:
        return Pose(middle(divmod(cell, width)), heading, is_loaded)

    last = Frame(rows, (), 0.0)
    for step in range(episode.steps + 1):
        now = plans[step] if step < len(plans) else NO_PLANS
        fleet, caption = orders.at(step)._replace(plans=now), orders.caption(step)
        motions = episode.motions[step - 1] if step and frame_seconds else ()
        if motions and frame_seconds:
            before = last.fleet
            along = frames_along(last, motions, loaded[step], size, frame_seconds, caption)
            for last in along:
                last.hits = tuple(Hit(hit.at, "", hit.robot) for hit in last.hits)
                last.fleet = fleet if last.progress == step else before
                yield last
        else:
            keys = zip(bodies[step].tolist(), headings[step], loaded[step], strict=True)
            poses = tuple([pose_of(*key) for key in keys])
            hits = _hits(episode, step - 1) if step else ()
            clock = last.clock + float(episode.seconds[step - 1].max()) if step else 0.0
            last = Frame(rows, poses, float(step), caption, hits, clock, fleet=fleet)
            yield last


def _headings(episode: FleetEpisode) -> list[list[float | None]]:
    """Return for each frame the direction in which each body moved last, as an angle."""
    bodies = episode.settings.bodies
    headings: list[list[float | None]] = [[None] * bodies]
    width = episode.layout.width
    angle_of = {1: 0.0, width: math.pi / 2, -1: math.pi, -width: -math.pi / 2}
    moved = np.diff(np.hstack([episode.cells, episode.people]), axis=0)
    for row in moved.tolist():
        headings.append(
            [angle_of.get(by, before) for by, before in zip(row, headings[-1], strict=True)]
        )
    return headings


def _hits(episode: FleetEpisode, step: int) -> tuple[Hit, ...]:
    """Return where robots were blocked in a step: half way to the cell that they did not reach."""
    found = []
    for robot in np.flatnonzero(episode.stopped_by[step] != NOTHING).tolist():
        row, col = divmod(int(episode.cells[step, robot]), episode.layout.width)
        action = int(episode.actions[step, robot])
        down, right = DISPLACEMENTS[action] if action < WAIT else (0, 0)
        found.append(Hit((col + 0.5 + right / 2, row + 0.5 + down / 2), "", robot))
    return tuple(found)


class _Orders:
    """The orders of an episode, as they are after any number of steps."""

    def __init__(self, episode: FleetEpisode) -> None:
        self._episode, never = episode, episode.steps + 1
        orders = episode.orders
        self._released, self._due, self._taken, self._delivered = np.array(
            [
                (
                    order.released,
                    order.due,
                    never if order.taken is None else order.taken,
                    never if order.delivered is None else order.delivered,
                )
                for order in orders
            ],
            np.int64,
        ).reshape(-1, 4).T  # fmt: skip
        self._robot = np.array([-1 if o.taken_by is None else o.taken_by for o in orders], np.intp)
        self._pickups = sorted({order.pickup for order in orders})
        number = {cell: index for index, cell in enumerate(self._pickups)}
        self._pickup = np.array([number[order.pickup] for order in orders], np.intp)
        self._full = episode.settings.battery.capacity

    def at(self, step: int) -> FleetFrame:
        """Return what a frame shows of orders, and of batteries."""
        age = self._ages(step)
        waits = (self._released <= step) & (step < self._taken)
        counts = np.bincount(self._pickup[waits], minlength=len(self._pickups)).tolist()
        oldest = np.zeros(len(self._pickups), np.intp)
        np.maximum.at(oldest, self._pickup[waits], age[waits])
        items = np.where(self._episode.loaded[step], 0, NOTHING_CARRIED)
        carried = (self._taken <= step) & (step < self._delivered)
        items[self._robot[carried]] = age[carried]
        return FleetFrame(
            tuple(
                Waiting(middle(cell), count, int(oldest[place]))
                for place, (cell, count) in enumerate(zip(self._pickups, counts, strict=True))
                if count
            ),
            tuple(None if item == NOTHING_CARRIED else item for item in items.tolist()),
            tuple(np.clip(self._episode.battery[step] / self._full, 0, 1).tolist()),
        )

    def caption(self, step: int) -> str:
        """Return how many orders have been delivered, are carried and wait, in words."""
        if not len(self._released):
            return ""
        delivered = self._delivered <= step
        late = int((delivered & (self._delivered > self._due)).sum())
        carried = int(((self._taken <= step) & ~delivered).sum())
        waiting = int(((self._released <= step) & (step < self._taken)).sum())
        late_ones = f" ({late:,} late)" if late else ""
        return f"{delivered.sum():,} delivered{late_ones}, {carried:,} carried, {waiting:,} waiting"

    def _ages(self, step: int) -> NDArray[np.intp]:
        """Return the age of each order: the third of its time that it is in, or ``LATE``."""
        time = np.maximum(self._due - self._released, 1)
        third = np.clip(LATE * (step - self._released) // time, 0, LATE - 1)
        ages: NDArray[np.intp] = np.where(step > self._due, LATE, third)
        return ages


def _shift(episode: FleetEpisode) -> Shift:
    """Return what the charts show."""
    steps, full = episode.steps, episode.settings.battery.capacity
    released = [order.released for order in episode.orders]
    late = [
        (order.delivered, order.delivered - order.due)
        for order in episode.orders
        if order.delivered is not None
    ]
    if episode.settings.orders is None:
        gone = episode.loaded[:-1] & ~episode.loaded[1:]
        delivered = np.concatenate([[0], gone.sum(axis=1)])
    else:
        delivered = np.bincount([step for step, _ in late], minlength=steps + 1)
    shares = np.clip(episode.battery / full, 0, 1)
    return Shift(
        np.bincount(np.array(released, np.intp), minlength=steps + 1).cumsum().tolist(),
        delivered.cumsum().tolist(),
        sorted(late),
        shares.mean(axis=1).tolist(),
        shares.min(axis=1).tolist(),
        [0.0, *episode.joules.sum(axis=1).cumsum().tolist()],
        episode.orders,
        episode.assignments,
    )


def _metrics(episode: FleetEpisode) -> dict[str, list[float]]:
    """Return the chapter's lists for a lone robot."""
    cells = [divmod(cell, episode.layout.width) for cell in episode.cells[:, 0].tolist()]
    metrics: dict[str, list[float]] = {
        "rewards": [0.0, *episode.rewards[:, 0].tolist()],
        "battery": episode.battery[:, 0].tolist(),
    }
    if episode.settings.orders is None:
        for name, stations in (
            ("dist_pickup", episode.layout.pickups),
            ("dist_dropoff", episode.layout.dropoffs),
        ):
            metrics[name] = [
                float(manhattan_distance(cell, stations[0])) if stations else math.nan
                for cell in cells
            ]
    return metrics


def _ending(episode: FleetEpisode) -> str:
    if episode.terminated.all():
        return "all delivered"
    if (episode.battery[-1] <= 0).all():
        return "batteries empty"
    return "time is up" if episode.truncated.any() else ""
