"""Episodes of a lone robot whose cells a body drives in one go."""

import math
import random
from dataclasses import replace
from itertools import pairwise

import pytest

from agents import GreedyAgent
from warehouse_core import (
    Episode,
    FleetEnv,
    GridMotion,
    Layout,
    WarehouseEnv,
    random_layout,
    record_episode,
    replay_episode,
)
from warehouse_core.errors import BackendError
from warehouse_core.motion.base import BaseMotion, centre_of
from warehouse_core.records import drive_summary
from warehouse_core.world.actions import DROP, PICK, WAIT, action_index
from warehouse_core.world.named_layouts import NAMES, named_layout
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop
from warehouse_physics.driving import driven_episode

SPECS = {
    "disc": RobotSpec(),
    "wheels": RobotSpec(drive="differential"),
    "turning": RobotSpec(turn_seconds=1.5),
    "quick": RobotSpec(top_speed=2.0, payload_mass=60.0),
}
over_specs = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS.keys())


def on_the_grid(seed: int, layout: Layout | None = None) -> Episode:
    env = WarehouseEnv(layout, max_steps=120)
    return record_episode(env, GreedyAgent(seed=seed), seed=seed)


def bound(episode: Episode, spec: RobotSpec) -> float:
    """Return the seconds of a robot that drives each straight in one go and stops at its end.

    At corners and where the path turns back, it turns on the spot if its drive has to.
    """
    seconds, heading, straight = 0.0, 0.0, 0
    for step, (action, loaded) in enumerate(zip(episode.actions, episode.loaded, strict=False)):
        before, after = episode.cells[step : step + 2]
        move = after[0] - before[0], after[1] - before[1]
        is_handling = action_index(action) in (WAIT, PICK, DROP)
        turn = 0.0 if move == (0, 0) else math.remainder(math.atan2(*move) - heading, math.tau)
        if straight and (turn or is_handling):
            seconds += seconds_over(straight, spec, loaded)
            straight = 0
        if turn and spec.turns_on_the_spot:
            quarters = round(abs(turn) / (math.pi / 2))
            seconds += spec.turn_substeps(quarters, loaded) * spec.time_step
        heading += turn
        straight += move != (0, 0)
        seconds += spec.dwell * is_handling
    return seconds + seconds_over(straight, spec, episode.loaded[-1])


def seconds_over(cells: int, spec: RobotSpec, loaded: bool) -> float:
    """Return the seconds from rest to rest over a straight of some cells."""
    if not cells:
        return 0.0
    length, rate = cells * spec.cell_size, spec.attainable_acceleration(loaded)
    speed = min(spec.top_speed, math.sqrt(rate * length))
    return length / speed + speed / rate


def check(episode: Episode, driven: Episode, spec: RobotSpec) -> None:
    """Check that a record has the same cells in the same order, without a hit, and in good time."""
    assert replace(driven, settings=episode.settings, motions=episode.motions) == episode
    assert [motion.cell for motion in driven.motions] == episode.cells[1:]
    assert not any(motion.contacts for motion in driven.motions)
    for cell, motion in zip(episode.cells[1:], driven.motions, strict=True):
        off = math.dist(motion.path[-1, 1:3], centre_of(cell, spec.cell_size))
        assert off < spec.cell_size / 4
        assert motion.path[-1, 0] == motion.seconds > 0
        assert motion.readings[-1, 4] == motion.joules >= 0
    for before, after in pairwise(driven.motions):
        assert before.path[-1, 1:] == pytest.approx(after.path[0, 1:], abs=1e-4)
        assert before.readings[-1, :2] == pytest.approx(after.readings[0, :2], abs=2e-3)
    idle = sum(
        here == there and action_index(action) not in (WAIT, PICK, DROP)
        for action, (here, there) in zip(episode.actions, pairwise(episode.cells), strict=True)
    )
    assert driven.seconds <= 1.05 * bound(episode, spec) + (idle + 1) * spec.time_step


@over_specs
def test_a_body_drives_the_cells_of_an_episode_in_good_time(spec: RobotSpec) -> None:
    episode = on_the_grid(12)
    check(episode, DrivingMotion(spec).drive_episode(episode), spec)


@pytest.mark.slow
def test_bodies_drive_the_cells_of_a_thousand_random_episodes() -> None:
    for seed in range(1000):
        stream = random.Random(seed)
        layout = random_layout(stream.randint(5, 12), stream.randint(5, 14), 0.2, seed=seed)
        if seed % 10 == 0:
            layout = named_layout(stream.choice(NAMES))
        spec = stream.choice([*SPECS.values()])
        episode = on_the_grid(seed, layout)
        check(episode, DrivingMotion(spec).drive_episode(episode), spec)


def test_driving_through_saves_time_and_stops_against_moves_from_cell_to_cell() -> None:
    """A stop at each corner would take 38.8 s; a disc takes corners without stopping."""
    episode = replay_episode(on_the_grid(12), backend="physics")
    moved, driven = map(drive_summary, (episode, replay_episode(episode, backend="driving")))
    assert bound(episode, RobotSpec()) == pytest.approx(38.8, abs=0.1)
    assert (moved.seconds, moved.stops) == (pytest.approx(49.75), 21)
    assert driven.seconds < 38.8 < moved.seconds
    assert driven.stops < 10
    assert driven.joules < moved.joules


def test_steps_that_do_not_move_the_robot_take_one_substep_each() -> None:
    """The reflex agent bumps into walls, also at the end and before it picks."""
    env = WarehouseEnv(Layout(["......", ".P..D."]), (0, 0), max_steps=40)
    walk = Walk("N", "E", "N", "E", "N", "?", "WAIT", "N", "W", "N", "N")
    episode = record_episode(env, walk, randomize=False)
    driven = DrivingMotion().drive_episode(episode)
    check(episode, driven, RobotSpec())
    seconds = [round(motion.seconds * 60) for motion in driven.motions]
    assert [seconds[step] for step in (0, 2, 4, 5, 7, 9, 10)] == [1] * 7
    assert seconds[6] == 60
    still = record_episode(WarehouseEnv(Layout([".."]), (0, 0), max_steps=2), Walk("N", "W"))
    assert [motion.cell for motion in DrivingMotion().drive_episode(still).motions] == [(0, 0)] * 2


class Walk:
    """An agent that carries out some actions, after which the episode is at its limit."""

    def __init__(self, *actions: str) -> None:
        self._actions = actions

    def reset(self) -> None:
        self._left = iter(self._actions)

    def act(self, observation: object) -> str:
        return next(self._left, "N")


def test_a_driven_record_is_stored_and_replays_bit_for_bit(tmp_path) -> None:
    driven = replay_episode(on_the_grid(12), backend="driving:drive=differential")
    assert driven.backend == "driving:drive=differential"
    driven.save(tmp_path / "driven.npz")
    loaded = Episode.load(tmp_path / "driven.npz")
    assert loaded == driven
    assert replay_episode(loaded) == driven


def test_a_body_that_slid_on_or_never_arrives_is_refused() -> None:
    fleet = record_episode(FleetEnv(robots=1, max_steps=2), WaitingFleet())
    with pytest.raises(BackendError, match="the episode has a fleet; it must have a lone robot"):
        DrivingMotion().drive_episode(fleet)
    with pytest.raises(BackendError, match="RestingMotion cannot drive the cells of a record"):
        replay_episode(on_the_grid(12), backend=RestingMotion())
    stuck = DrivingMotion(disturbances=Disturbances(stops=[Stop(0, 0.0, math.inf)]))
    short = record_episode(
        WarehouseEnv(Layout([".."]), (0, 0), max_steps=1), Walk("E"), randomize=False
    )
    with pytest.raises(
        BackendError, match=r"not arrived in \(0, 1\) after 100 s; it is at x = 0\.5"
    ):
        stuck.drive_episode(short)


def test_a_body_that_stops_for_longer_than_it_may_stand_is_driven_on(monkeypatch) -> None:
    monkeypatch.setattr(driven_episode, "PATIENCE", 10.0)
    motion = DrivingMotion(disturbances=Disturbances(stops=[Stop(0, 1.0, 23.0)]))
    walk = record_episode(
        WarehouseEnv(Layout(["....."]), (0, 0), max_steps=4), Walk(*"EEEE"), randomize=False
    )
    driven = motion.drive_episode(walk)
    assert driven.cells == walk.cells
    assert driven.seconds > 23


def test_a_body_that_slid_over_a_cell_is_refused() -> None:
    layout = Layout(["....."])
    icy = WarehouseEnv(layout, (0, 0), backend="physics:grip=0.01,slippery=0-1+0-2", max_steps=1)
    slid = record_episode(icy, Walk("E"), randomize=False)
    assert slid.cells == [(0, 0), (0, 2)]
    with pytest.raises(BackendError, match=r"slid over a cell: robot 0 .* \(0, 0\) to \(0, 2\)"):
        replay_episode(slid, backend="driving")


class WaitingFleet:
    def reset(self) -> None:
        pass

    def act(self, env: FleetEnv) -> list[str]:
        return ["WAIT"]


class RestingMotion(GridMotion, BaseMotion):
    """A motion that claims to drive through, but cannot drive a record."""

    drives_through = True
