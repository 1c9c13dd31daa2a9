"""The track of a record of one robot or of a fleet, for its replay."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import instance_of, real_number, sequence_of
from warehouse_core.errors import RecordError
from warehouse_core.motion.base import NOTHING, Contact, Outcome
from warehouse_core.motion.grid import ANGLES
from warehouse_core.records.episode import UNFINISHED, Episode
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.records.held_up import held_up
from warehouse_core.records.plans import NO_PLANS, StepPlans, check_plans
from warehouse_core.render.palette import LATE, LOOK
from warehouse_core.viz.tracks.track import (
    DrawnHit,
    FleetFrame,
    Frame,
    Line,
    Pose,
    Push,
    Readings,
    Track,
    Waiting,
    middle,
)
from warehouse_core.wording import counted, printable
from warehouse_core.world.actions import ACTIONS, DISPLACEMENTS, INVALID, WAIT, action_index
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tiles import MOVE_DELTAS

FRAME_SECONDS = 0.2
"""Simulated seconds from one frame of a continuous motion to the next."""

FLASH_SECONDS = 0.6
"""Simulated seconds for which a hit is shown."""

MAX_FRAMES = 100_000
"""Limit on the number of frames of continuous motions, which follows from their duration."""

MAX_POSES = 2_000_000
"""Limit on the number of poses of robots and people in all frames of continuous motions."""

MAX_PUSHED = int(LOOK["battery"]["few"])
"""Most bodies whose velocities, forces and skid marks are shown."""

SKIDDING, SLOW = 0.99, 0.02
"""Least share of the largest force on slippery floor with which a robot skids, and the speed in m/s
that it must exceed in order to skid."""

ACTION_WORDS = {
    "N": "North", "S": "South", "E": "East", "W": "West",
    "PICK": "Pick up", "DROP": "Drop", "WAIT": "Wait",
}  # fmt: skip
"""Words for actions in captions."""

REASON_WORDS = {
    "greedy": "getting closer",
    "stuck": "stuck, trying a random move",
    "escape": "escaping a loop",
    "no goal": "no goal to go to",
    "key": "key pressed",
}
"""Words in captions for the short reasons of the chapter's greedy agent and of a human player."""

NOTHING_CARRIED = -1


def track_of_record(
    record: Episode,
    frame_seconds: float = FRAME_SECONDS,
    plans: Sequence[StepPlans] = (),
) -> Track:
    """Return the track of a record.

    Args:
        record: record of one robot or of a fleet.
        frame_seconds: simulated time between two frames of continuous motions. Other motions have
            one frame per step.
        plans: plans of a fleet before each step, beginning with the first; there may be fewer plans
            than steps.

    Raises:
        ValueError: ``frame_seconds`` is not a positive finite number, or a plan does not fit the
            record.
        TypeError: an argument has the wrong type.
        RecordError: continuous motions need more than ``MAX_FRAMES`` frames or ``MAX_POSES`` poses.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.viz.tracks import track_of_record
        >>> episode = record_episode(WarehouseEnv(backend="physics"), GreedyAgent(seed=12), seed=12)
        >>> track_of_record(episode).is_continuous
        True
    """
    instance_of("record", record, Episode)
    plans = sequence_of("plans", plans, StepPlans)
    frame_seconds = real_number("frame_seconds", frame_seconds, above=True)
    if record.is_fleet:
        check_plans(plans, record)
        is_continuous = bool(record.motions)
    else:
        is_continuous = any(len(motion.path) > 2 for motion in record.motions)
    is_measured = is_continuous or bool(record.drive)
    if is_continuous:
        _check_frames(record, frame_seconds)
    apart = frame_seconds if is_continuous else None
    frames = [*(_fleet_frames(record, apart, plans) if record.is_fleet else _frames(record, apart))]
    settings = record.settings
    track = Track(
        frames, record.metrics, is_continuous, is_measured, readings_of(record),
        title=title_of(record), slippery=record.slippery,
        view_radius=settings.view_radius, motor_strength=record.motor_strength, drive=record.drive,
    )  # fmt: skip
    if record.is_fleet:
        track.full_battery, track.ending = settings.battery.capacity, _ending(record)
    else:
        track.full_battery = settings.battery
        if record.outcome != UNFINISHED:
            diagnosis = diagnose(record)
            track.ending, frames[-1].caption = diagnosis.mode, printable(diagnosis.sentence)
    if record.robots > 1:
        track.metrics, track.lateness = _fleet_metrics(record), _lateness(record)
        if not is_measured:
            del track.metrics["joules"]
        steps, robots = np.nonzero(held_up(record))
        cells = map(record.layout.cell, record.cells[steps, robots].tolist())
        track.held_up = [*zip((steps + 1).tolist(), cells, strict=True)]
    return track


def _check_frames(record: Episode, frame_seconds: float) -> None:
    """Check that the motions of all bodies are not too long to be drawn.

    A step takes as long as the longest of its motions, as in ``frames_along``.
    """
    steps = record.motions if record.is_fleet else zip(record.motions, strict=True)
    bodies = record.settings.bodies if record.is_fleet else 1
    seconds = math.fsum(max(motion.seconds for motion in motions) for motions in steps)
    most = min(MAX_FRAMES, MAX_POSES // bodies)
    if seconds > most * frame_seconds:
        limit = f"MAX_FRAMES = {MAX_FRAMES}"
        if most < MAX_FRAMES:
            limit = f"MAX_POSES = {MAX_POSES} allows for {bodies:,} bodies"
        raise RecordError(
            f"the motions take {seconds:g} s; with a frame every {frame_seconds:g} s "
            f"this is more than {limit}"
        )


def title_of(record: Episode) -> str:
    """Return the title of a record: its agent, backend and seed, and the size of a fleet."""
    agent = record.agent or ("Fleet" if record.is_fleet else "Warehouse")
    robots = f", {counted(record.robots, 'robot')}" if record.is_fleet else ""
    seed = "" if record.seed is None else f", seed {record.seed}"
    return printable(f"{agent}{robots} on the {record.backend} backend{seed}")


def step_captions(record: Episode) -> list[str]:
    """Return for each step of a single robot the action and its reason, in words."""
    words = _command_words if record.is_driven else _action_words
    return [
        ": ".join(filter(None, (words(action), REASON_WORDS.get(reason, printable(reason)))))
        for action, reason in zip(record.actions, record.reasons, strict=True)
    ]


def _action_words(action: str | int) -> str:
    """Return an action in words, and an action that does not exist as the agent gave it."""
    index = action_index(action)
    return printable(str(action)) if index == INVALID else ACTION_WORDS[ACTIONS[index]]


def _command_words(action: str | int) -> str:
    """Return the two numbers of continuous control with two decimals; the file has all digits."""
    with suppress(ValueError):
        numbers = (round(float(number), 2) + 0.0 for number in str(action).split())  # no -0.00
        return f"Command {', '.join(f'{number:.2f}' for number in numbers)}"
    return printable(str(action))


def readings_of(record: Episode) -> Readings | None:
    """Return what the body of a single robot measured, or ``None`` without readings."""
    motions = [] if record.is_fleet else record.motions
    known = [motion.readings for motion in motions if motion.readings is not None]
    if not known or len(known) < len(motions):
        return None
    rows, lengths = np.vstack(known), [len(readings) for readings in known]
    path = np.vstack([motion.path for motion in motions])
    before = [
        [0.0, *accumulate(values)][:-1]
        for values in zip(*((m.seconds, m.joules) for m in motions), strict=True)
    ]
    seconds, joules = (np.repeat(each, lengths) for each in before)
    headings = np.column_stack([np.cos(path[:, 3]), np.sin(path[:, 3])])
    return Readings(
        (path[:, 0] + seconds).tolist(),
        np.hypot(*rows[:, :2].T).tolist(),
        (rows[:, 2:4] * headings).sum(axis=1).tolist(),
        (rows[:, 4] + joules).tolist(),
    )


class Floor(NamedTuple):
    """The floor under bodies: where it is slippery, and the force from which on they skid there.

    Attributes:
        cell_size: side of a cell in metres.
        is_slippery: ``[H, W]`` bool.
        limits: largest force in N of an empty and of a loaded robot on slippery floor. The grip
            limits the force, so a robot skids where it reaches this force.
    """

    cell_size: float
    is_slippery: NDArray[np.bool_]
    limits: tuple[float, float] = (math.inf, math.inf)

    def forces(self, motion: Outcome) -> NDArray[np.float64]:
        """Return the force in N at each row of a path where the floor is slippery, and else 0."""
        if motion.readings is None or not self.is_slippery.any():
            return np.zeros(len(motion.path))
        last = np.subtract(self.is_slippery.shape, 1)  # a file may have any path
        cells = np.clip(motion.path[:, 2:0:-1] // self.cell_size, 0, last).astype(np.intp)
        forces = np.hypot(*motion.readings[:, 2:4].T)
        on_slippery: NDArray[np.float64] = forces * self.is_slippery[tuple(cells.T)]
        return on_slippery


def floor_of(record: Episode) -> Floor:
    """Return the floor of a record."""
    is_slippery = np.zeros((record.layout.height, record.layout.width), bool)
    for cell in record.slippery:
        is_slippery[cell] = True
    floor, limits = Floor(record.cell_size, is_slippery), [0.0, 0.0]
    if is_slippery.any():
        motions = record.motions if record.is_fleet else [*zip(record.motions)]
        loads = np.reshape(record.loaded, (record.steps + 1, -1))[1:]
        for step, loaded in zip(motions, loads, strict=True):
            for motion, load in zip(step, loaded, strict=False):
                limits[int(load)] = max(limits[int(load)], floor.forces(motion).max())
    return floor._replace(limits=(limits[0] or math.inf, limits[1] or math.inf))


def _frames(record: Episode, frame_seconds: float | None) -> Iterator[Frame]:
    """Yield the frames of a single robot, one per step or one every ``frame_seconds``."""
    rows, floor = record.layout.rows, floor_of(record)
    heading = None if frame_seconds is None else float(record.motions[0].path[0, 3])
    last = Frame(rows, (Pose(middle(record.cells[0]), heading, record.loaded[0]),), 0.0)
    yield last
    for step, (motion, caption) in enumerate(
        zip(record.motions, step_captions(record), strict=True), start=1
    ):
        loaded, seen = record.loaded[step], lines_of(motion, record.cell_size)
        if frame_seconds is not None:
            along = frames_along(last, [motion], [loaded], floor, frame_seconds, caption)
            for last in along:
                last.lines = seen
                yield last
            continue
        pose = Pose(middle(record.cells[step]), float(motion.path[-1, 3]), loaded)
        hits = tuple(hit_of(contact, record.cell_size) for contact in motion.contacts)
        energy = last.energy + motion.joules if record.drive else 0.0
        last = Frame(rows, (pose,), float(step), caption, hits, last.clock + motion.seconds, energy)
        last.lines = seen
        yield last


def _fleet_frames(
    episode: Episode, frame_seconds: float | None, plans: Sequence[StepPlans]
) -> Iterator[Frame]:
    """Yield the frames of a fleet, one per step or one every ``frame_seconds``."""
    orders, bodies = _Orders(episode), np.hstack([episode.cells, episode.people])
    no_items = [False] * episode.people.shape[1]
    layout, rows, floor = episode.layout, episode.layout.rows, floor_of(episode)
    used = [0.0] * (episode.steps + 1) if frame_seconds is None else _joules_used(episode)

    @cache
    def pose_of(cell: int, heading: float | None, is_loaded: bool) -> Pose:
        return Pose(middle(layout.cell(cell)), heading, is_loaded)

    last = Frame(rows, (), 0.0)
    for step, headings in enumerate(_headings(episode)):
        loaded = [*episode.loaded[step].tolist(), *no_items]
        now = plans[step] if step < len(plans) else NO_PLANS
        fleet, caption = orders.at(step)._replace(plans=now), orders.caption(step)
        if step and frame_seconds is not None:
            motions, before = episode.motions[step - 1], last.fleet
            along = frames_along(last, motions, loaded, floor, frame_seconds, caption)
            for last in along:
                last.hits = tuple(replace(hit, label="") for hit in last.hits)
                is_complete = last.progress == step
                last.fleet = fleet if is_complete else before
                last.energy = used[step if is_complete else step - 1]
                yield last
        else:
            if episode.motions:
                headings = [float(motion.path[0, 3]) for motion in episode.motions[0]]
            keys = zip(bodies[step].tolist(), headings, loaded, strict=True)
            poses = tuple([pose_of(*key) for key in keys])
            hits = _hits(episode, step - 1) if step else ()
            clock = last.clock + float(episode.seconds[step - 1].max()) if step else 0.0
            last = Frame(rows, poses, float(step), caption, hits, clock, used[step], fleet=fleet)
            yield last


_ANGLES = np.array([ANGLES[MOVE_DELTAS[heading]] for heading in HEADINGS])
"""Angle of each heading."""


def _headings(episode: Episode) -> Iterator[list[float | None]]:
    """Yield for each frame the angle of each body, from its heading or its last move."""
    headings: list[float | None] = [None] * episode.settings.bodies
    of_frames = np.reshape(episode.headings, (episode.steps + 1, -1)).astype(np.intp)
    known = _ANGLES.take(of_frames).tolist()  # without headings it has no columns
    yield [*known[0], *headings[len(known[0]) :]]
    width = episode.layout.width
    angle_of = {1: 0.0, width: math.pi / 2, -1: math.pi, -width: -math.pi / 2}
    moved = np.diff(np.hstack([episode.cells, episode.people]), axis=0)
    for row, of_robots in zip(moved, known[1:], strict=True):
        pairs = zip(row.tolist(), headings, strict=True)
        headings = [angle_of.get(by, before) for by, before in pairs]
        yield [*of_robots, *headings[len(of_robots) :]]


def _hits(episode: Episode, step: int) -> tuple[DrawnHit, ...]:
    """Return the hits of a step, each halfway between a blocked robot and its target cell."""
    hits, actions = [], episode.counted_actions(step)
    for robot in np.flatnonzero(episode.stopped_by[step] != NOTHING).tolist():
        row, col = episode.layout.cell(episode.cells[step, robot])
        action = int(actions[robot])
        down, right = DISPLACEMENTS[action] if action < WAIT else (0, 0)
        hits.append(DrawnHit((col + 0.5 + right / 2, row + 0.5 + down / 2), "", robot))
    return tuple(hits)


class _Orders:
    """The orders of an episode, and their state after any number of steps."""

    def __init__(self, episode: Episode) -> None:
        self._episode, never = episode, episode.steps + 1
        orders = episode.orders

        def column(name: str) -> NDArray[np.intp]:
            values = (getattr(order, name) for order in orders)
            return np.array([never if value is None else value for value in values], np.intp)

        self._released, self._due, self._taken, self._delivered, self._robot = map(
            column, ("released", "due", "taken", "delivered", "taken_by")
        )
        self._pickups = sorted({order.pickup for order in orders})
        number = {cell: index for index, cell in enumerate(self._pickups)}
        self._pickup = np.array([number[order.pickup] for order in orders], np.intp)
        self._full = episode.settings.battery.capacity

    def at(self, step: int) -> FleetFrame:
        """Return the orders and batteries in the frame after ``step`` steps."""
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
        """Return in words how many orders have been delivered, are carried, and are waiting."""
        if not len(self._released):
            return ""
        delivered = self._delivered <= step
        late = int((delivered & (self._delivered > self._due)).sum())
        carried = int(((self._taken <= step) & ~delivered).sum())
        waiting = int(((self._released <= step) & (step < self._taken)).sum())
        late_ones = f" ({late:,} late)" if late else ""
        return f"{delivered.sum():,} delivered{late_ones}, {carried:,} carried, {waiting:,} waiting"

    def _ages(self, step: int) -> NDArray[np.intp]:
        """Return the age of each order: the present third of its time until due, or ``LATE``."""
        time = np.maximum(self._due - self._released, 1)
        third = np.clip(LATE * (step - self._released) // time, 0, LATE - 1)
        ages: NDArray[np.intp] = np.where(step > self._due, LATE, third)
        return ages


def _fleet_metrics(episode: Episode) -> dict[str, Sequence[float]]:
    """Return the metrics of a fleet after each step; see ``Track``."""
    steps = episode.steps
    if episode.settings.orders is None:
        gone = episode.loaded[:-1] & ~episode.loaded[1:]
        delivered = np.concatenate([[0], gone.sum(axis=1)])
    else:
        delivered = np.bincount([step for step, _ in _lateness(episode)], minlength=steps + 1)
    released = np.array([order.released for order in episode.orders], np.intp)
    shares = np.clip(episode.battery / episode.settings.battery.capacity, 0, 1)
    return {
        "released": np.bincount(released, minlength=steps + 1).cumsum().tolist(),
        "delivered": delivered.cumsum().tolist(),
        "battery_mean": shares.mean(axis=1).tolist(),
        "battery_lowest": shares.min(axis=1).tolist(),
        "joules": _joules_used(episode),
    }


def _joules_used(episode: Episode) -> list[float]:
    """Return the joules that all robots of a fleet have used after each step."""
    return [0.0, *episode.joules.sum(axis=1).cumsum().tolist()]


def _lateness(episode: Episode) -> list[tuple[int, int]]:
    """Return the step and the lateness in steps of each delivery, in order of the steps."""
    return sorted(
        (order.delivered, order.delivered - order.due)
        for order in episode.orders
        if order.delivered is not None
    )


def _ending(episode: Episode) -> str:
    if episode.terminated.all():
        return "all delivered"
    if (episode.battery[-1] <= 0).all():
        return "batteries empty"
    return "time is up" if episode.truncated.any() else ""


def frames_along(
    start: Frame,
    motions: Sequence[Outcome],
    loaded: Sequence[bool],
    floor: Floor,
    frame_seconds: float,
    caption: str,
) -> Iterator[Frame]:
    """Yield the frames of one step along the paths of all bodies, ending where the paths end.

    A step that takes no time has one frame.

    Args:
        start: frame before the step.
        motions: motion of each body.
        loaded: true for each body that holds an item after the step.
        floor: floor under the bodies.
        frame_seconds: simulated time between two frames.
        caption: caption of the frames.
    """
    seconds = max(motion.seconds for motion in motions)
    count = max(1, round(seconds / frame_seconds))
    times = [seconds * frame / count for frame in range(count + 1)]
    paths = [
        [np.interp(times, motion.path[:, 0], motion.path[:, axis]).tolist() for axis in (1, 2, 3)]
        for motion in motions
    ]
    is_small, size = len(motions) <= MAX_PUSHED, floor.cell_size
    pushes = [
        _pushes(motion, floor, times, load) if is_small else [None] * len(times)
        for motion, load in zip(motions, loaded, strict=True)
    ]
    energy = _energy(motions[0], times)
    hits: list[list[DrawnHit]] = [[] for _ in times]
    for robot, motion in enumerate(motions):
        for contact in motion.contacts:
            hit = hit_of(contact, size, impulse_words(contact.impulse), robot)
            end = bisect_right(times, contact.seconds + FLASH_SECONDS)
            for number in range(bisect_left(times, contact.seconds), end):
                hits[number].append(hit)
    for k in range(1, count + 1):
        is_last = k == count
        poses = [
            Pose(
                (x[k] / size, y[k] / size),
                angle[k],
                after if is_last else before is not None and before.loaded,
                push[k],
            )
            for (x, y, angle), push, before, after in zip(
                paths, pushes, start.robots, loaded, strict=True
            )
        ]
        yield Frame(
            start.tiles,
            tuple(poses),
            start.progress + k / count,
            caption,
            tuple(
                {hit.at: hit for hit in hits[k]}.values()
            ),  # both robots of a collision report it
            start.clock + (seconds if is_last else times[k]),
            start.energy + energy[k],
        )


def _pushes(
    motion: Outcome, floor: Floor, times: Sequence[float], load: bool
) -> Sequence[Push | None]:
    """Return the push of a body at some times of a motion.

    It skids if it skidded at any time since the time before.
    """
    readings = motion.readings
    if readings is None:
        return [None] * len(times)
    known = motion.path[:, 0]
    rows = np.searchsorted(known, times).clip(max=len(known) - 1)
    vx, vy = (np.interp(times, known, readings[:, axis]).tolist() for axis in (0, 1))
    is_skidding = (floor.forces(motion) >= SKIDDING * floor.limits[load]) & (
        np.hypot(*readings[:, :2].T) > SLOW
    )
    skidded = is_skidding.cumsum()[rows]
    return [
        Push(velocity, (fx, fy), skids)
        for velocity, (fx, fy), skids in zip(
            zip(vx, vy, strict=True),
            readings[rows, 2:4].tolist(),
            (np.diff(skidded, prepend=0) > 0).tolist(),
            strict=True,
        )
    ]


def _energy(motion: Outcome, times: Sequence[float]) -> list[float]:
    """Return the energy used at some times of a motion; if it is unknown, only at the end."""
    if motion.readings is None:
        return [0.0] * (len(times) - 1) + [motion.joules]
    used: list[float] = np.interp(times, motion.path[:, 0], motion.readings[:, 4]).tolist()
    return used


def lines_of(motion: Outcome, cell_size: float) -> tuple[Line, ...]:
    """Return the lines around a robot at the end of a motion, in cells."""
    if motion.lines is None:
        return ()
    return tuple(
        (bool(is_ray), (x / cell_size, y / cell_size), (to_x / cell_size, to_y / cell_size))
        for is_ray, x, y, to_x, to_y in motion.lines.tolist()
    )


def impulse_words(impulse: float) -> str:
    """Return an impulse in N·s as text, with a decimal if it is below 10."""
    return f"{impulse:.{0 if impulse >= 9.95 else 1}f} N·s"


def hit_of(contact: Contact, cell_size: float, label: str = "", robot: int = 0) -> DrawnHit:
    """Return the hit to draw for a contact, whose point is in metres.

    The area of a labelled burst is proportional to the impulse, within limits.
    """
    x, y = contact.point
    usual, least, most = LOOK["burst"].values()
    size = min(max(math.sqrt(max(contact.impulse, 0.0) / usual), least), most) if label else 1.0
    return DrawnHit((x / cell_size, y / cell_size), label, robot, size)
