import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from helpers.fleets import LINE, SHELVES, Couriers, fleet_episode

from warehouse_core import FleetEnv, FleetEpisode, Layout, Order, RecordError
from warehouse_core.records import FleetRecorder
from warehouse_core.viz.tracks import record_track, track_of_record
from warehouse_core.viz.tracks.track import Waiting

LATE = 3


@pytest.fixture(scope="module")
def episode() -> FleetEpisode:
    return fleet_episode()


@pytest.fixture(scope="module")
def bodies() -> FleetEpisode:
    return fleet_episode(backend="physics", max_steps=20)


def driven(actions: list[list[str]], **options: Any) -> FleetEpisode:
    """Return the record of a fleet, by default on ``LINE``, that carries out some actions."""
    layout = options.pop("layout", LINE)
    env = FleetEnv(layout, len(actions[0]), **{"max_steps": 30, "battery": 30, **options})
    recorder = FleetRecorder(env, seed=1, agent="hand")
    for each in actions:
        recorder.step(each)
    return recorder.episode


def age_at(step: int, order: Order) -> int:
    """Return the third of its time that an order is in, counted up from its release."""
    if step > order.due:
        return LATE
    shares = (step - order.released) / max(order.due - order.released, 1)
    return sum(shares >= third for third in (1 / 3, 2 / 3))


def test_orders_wait_at_their_pickups_and_age(episode: FleetEpisode) -> None:
    ages = set()
    for step, frame in enumerate(track_of_record(episode).frames):
        waiting: dict[tuple[int, int], list[int]] = {}
        items: dict[int | None, int] = {}
        for order in episode.orders:
            end = math.inf if order.delivered is None else order.delivered
            taken = math.inf if order.taken is None else order.taken
            if order.released <= step < taken:
                waiting.setdefault(order.pickup, []).append(age_at(step, order))
            elif taken <= step < end:
                items[order.taken_by] = age_at(step, order)
        assert frame.fleet
        assert frame.fleet.waiting == tuple(
            Waiting((col + 0.5, row + 0.5), len(found), max(found))
            for (row, col), found in sorted(waiting.items())
        )
        assert frame.fleet.items == tuple(items.get(robot) for robot in range(4))
        ages |= {age for found in waiting.values() for age in found} | {*items.values()}
        delivered = sum(order.delivered is not None and order.delivered <= step
                        for order in episode.orders)  # fmt: skip
        waits = sum(map(len, waiting.values()))
        assert frame.caption.startswith(f"{delivered} delivered")
        assert frame.caption.endswith(f", {len(items)} carried, {waits} waiting")
    assert ages >= {0, 1, 2}


def test_the_energy_is_the_sum_over_all_robots(bodies) -> None:
    track = track_of_record(bodies)
    used = np.concatenate([[0.0], bodies.joules.sum(axis=1).cumsum()])
    assert (bodies.joules[0] > 0).sum() > 1, "the first robot is not alone"
    for frame in track.frames:
        assert frame.energy == used[math.floor(frame.progress)]


@pytest.mark.parametrize("body", [0, -1], ids=["a robot", "a person"])
def test_a_motion_of_a_fleet_longer_than_its_step_says_raises(bodies, tmp_path, body) -> None:
    motions = [list(each) for each in bodies.motions]
    motions[0][body] = motions[0][body]._replace(seconds=1e9)
    path = tmp_path / "slow.npz"
    dataclasses.replace(bodies, motions=[*map(tuple, motions)]).save(path)
    with pytest.raises(RecordError, match=r"take 1e\+09 s; .* more than MAX_FRAMES = 100000"):
        track_of_record(FleetEpisode.load(path))


def test_motions_of_too_many_bodies_for_their_frames_raise(bodies, monkeypatch) -> None:
    drawn = sum(len(frame.robots) for frame in track_of_record(bodies).frames)
    monkeypatch.setattr(record_track, "MAX_POSES", 2 * drawn)
    track_of_record(bodies)
    monkeypatch.setattr(record_track, "MAX_POSES", drawn // 2)
    with pytest.raises(RecordError, match=f"more than MAX_POSES = {drawn // 2} allows for"):
        track_of_record(bodies)


def test_without_orders_the_items_delivered_are_counted() -> None:
    actions = [["PICK", "E"], ["E", "WAIT"], ["E", "N"], ["DROP", "W"]]
    episode = driven(actions, orders=None, starts=[(0, 0), (1, 0)], layout=Layout(["P.D", "..."]))
    track = track_of_record(episode)
    assert track.metrics["delivered"] == [0, 0, 0, 0, 1]
    assert (track.metrics["released"], track.lateness) == ([0] * 5, [])
    assert [frame.caption for frame in track.frames] == [""] * 5
    items = [frame.fleet and frame.fleet.items[0] for frame in track.frames]
    assert items == [None, 0, 0, 0, None]


def test_a_fleet_of_one_has_the_charts_of_the_chapter() -> None:
    alone = fleet_episode(robots=1, people=0, orders=None, layout=SHELVES, max_steps=30)
    track = track_of_record(alone)
    assert not track.counts_orders
    assert track.metrics == alone.metrics
    with_orders = fleet_episode(robots=1, people=0)
    assert track_of_record(with_orders).metrics.keys() == {"rewards", "battery"}
    bare = fleet_episode(robots=1, people=0, orders=None, layout=SHELVES.with_tiles([], [], []))
    assert all(math.isnan(each) for each in track_of_record(bare).metrics["dist_pickup"])


def test_the_ending_says_how_it_ended(episode: FleetEpisode) -> None:
    assert track_of_record(episode).ending == "time is up"
    empty = dataclasses.replace(episode, battery=episode.battery * 0)
    assert track_of_record(empty).ending == "batteries empty"
    going_on = dataclasses.replace(episode, truncated=~episode.truncated)
    assert track_of_record(going_on).ending == ""
    assert track_of_record(episode).title == ("Couriers, 4 robots on the grid backend, seed 5")
    assert Couriers.__name__ == episode.agent
