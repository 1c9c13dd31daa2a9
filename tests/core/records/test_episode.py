"""Records of a lone robot and of fleets: what they hold, how they load, and how they replay."""

import copy
import dataclasses
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.fleets import LINE as LANE
from helpers.fleets import SHELVES, Choosers, Couriers, fleet_episode

from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import (
    Episode,
    EpisodeRecorder,
    FleetEnv,
    Layout,
    Order,
    OrderQueue,
    OrderStream,
    RecordError,
    Settings,
    WarehouseEnv,
    record_episode,
    replay_episode,
)
from warehouse_core.fleet import Battery, People
from warehouse_core.motion.grid import GridMotion
from warehouse_core.records import FleetRecorder
from warehouse_core.world.actions import INVALID, WAIT

pytestmark = pytest.mark.filterwarnings("ignore:.*can keep")

LINE = Layout(["P..D"])


class Script:
    """Carries out a list of actions."""

    def __init__(self, *actions: Any) -> None:
        self.actions = actions

    def reset(self) -> None:
        self.left = list(self.actions)

    def act(self, observation: object) -> Any:
        return self.left.pop(0)


def on_line(*actions: Any, **limits: int) -> Episode:
    env = WarehouseEnv(LINE, start_pos=(0, 0), **limits)
    return record_episode(env, Script(*actions), seed=5, randomize=False)


HUGE = 10**5000


class Talkers(Couriers):
    """Couriers who say why, sometimes all together."""

    def act(self, env: FleetEnv) -> list[str]:
        actions = super().act(env)
        self.reason = "all wait" if set(actions) == {"WAIT"} else [f"to {a}" for a in actions]
        return actions


DELIVERY = ("PICK", "E", "e", 1, np.int64(1), "DROP")


# Recording.


def test_a_record_holds_every_frame_and_every_step() -> None:
    episode = on_line(*DELIVERY)
    assert (episode.layout, episode.seed, episode.agent) == (LINE, 5, "Script")
    assert episode.settings == Settings("grid", 1.0, (0, 0), 200, 200, 2)
    assert episode.cells == [(0, 0), (0, 0), (0, 1), (0, 2), (0, 3), (0, 3), (0, 3)]
    assert episode.loaded == [False, True, True, True, True, True, False]
    assert episode.battery == [200, 199, 198, 197, 196, 195, 194]
    assert episode.rewards == pytest.approx([0, 4.9, -0.1, -0.1, -0.1, -1.1, 9.9])
    assert episode.actions == ["PICK", "E", "e", 1, 1, "DROP"]
    assert [type(action) for action in episode.actions] == [str, str, str, int, int, str]
    assert episode.reasons == [""] * 6
    assert [motion.cell for motion in episode.motions] == episode.cells[1:]
    assert [motion.blocked for motion in episode.motions] == [False] * 4 + [True, False]
    assert (episode.terminated, episode.truncated, episode.steps) == (True, False, 6)
    assert episode.total_reward == pytest.approx(13.4)


def test_an_agents_reason_is_kept_with_its_action(episode: Episode) -> None:
    assert len(episode.reasons) == episode.steps
    assert set(episode.reasons) == {"", "because", "müde"}


def test_a_step_that_raises_is_not_recorded() -> None:
    recorder = EpisodeRecorder(WarehouseEnv(), agent="me")
    with pytest.raises(TypeError):
        recorder.step(1.5)
    assert recorder.episode.steps == 0
    assert len(recorder.episode.cells) == 1


@pytest.mark.parametrize(
    ("actions", "limits", "outcome"),
    [
        (DELIVERY, {}, "delivered"),
        (DELIVERY, {"battery": 6}, "delivered"),
        (DELIVERY, {"max_steps": 6}, "delivered"),
        (DELIVERY, {"battery": 5}, "battery depleted"),
        (DELIVERY, {"battery": 5, "max_steps": 5}, "battery depleted"),
        (DELIVERY, {"max_steps": 5}, "out of time"),
    ],
)
def test_the_outcome_of_an_episode(actions, limits, outcome) -> None:
    assert on_line(*actions, **limits).outcome == outcome


# Frames and measures.


def test_the_repr_is_one_line() -> None:
    delivered = "<Episode delivered, 6 steps, reward 13.40, seed 5, agent 'Script'>"
    assert repr(on_line(*DELIVERY)) == delivered
    assert repr(on_line("E", max_steps=1)).startswith("<Episode out of time, 1 step, reward -0.10,")
    empty = Episode(LINE, WarehouseEnv(LINE, None).settings, None, "")
    assert repr(empty) == "<Episode unfinished, 0 steps, reward 0.00, seed None, agent ''>"
    fleet = fleet_episode(agent=Talkers(), max_steps=9, orders=[Order(3, 40, (1, 1), (1, 5))])
    reward = round(math.fsum(fleet.rewards.flat), 2)
    assert repr(fleet) == (
        "<Episode 4 robots, 0 of 1 order delivered, 9 steps, "
        f"reward {reward:.2f}, seed 5, agent 'Talkers'>"
    )
    alone = fleet_episode(robots=1, people=0, orders=None)
    assert repr(alone).startswith("<Episode 1 robot, 0 of 1 item delivered, ")


@pytest.mark.parametrize("actions", [DELIVERY, ("N", "E", "fly")])
def test_frames_equal_render_grid(actions: tuple[Any]) -> None:
    env = WarehouseEnv(LINE, start_pos=(0, 0))
    recorder, frames = EpisodeRecorder(env), [env.render_grid()]
    for action in actions:
        recorder.step(action)
        frames.append(env.render_grid())
    assert recorder.episode.frames == frames
    recorder.episode.frames[0][0][0] = "?"
    assert recorder.episode.frames == frames


def test_frames_of_a_fleet_show_all_robots_and_people() -> None:
    episode = fleet_episode()
    assert episode.loaded.any()
    for step, frame in enumerate(episode.frames):
        cells = np.ndindex(SHELVES.height, SHELVES.width)
        shown = {(row, col): frame[row][col] for row, col in cells if frame[row][col] in "RrH"}
        width = SHELVES.width
        robots = zip(episode.cells[step].tolist(), episode.loaded[step].tolist(), strict=True)
        expected = {divmod(cell, width): "r" if loaded else "R" for cell, loaded in robots}
        expected |= {divmod(cell, width): "H" for cell in episode.people[step].tolist()}
        assert shown == expected


def test_metrics_are_the_four_lists_of_the_chapter() -> None:
    metrics = on_line(*DELIVERY).metrics
    assert metrics.keys() == {"rewards", "battery", "dist_pickup", "dist_dropoff"}
    assert metrics["rewards"] == pytest.approx([0, 4.9, -0.1, -0.1, -0.1, -1.1, 9.9])
    assert metrics["battery"] == [200, 199, 198, 197, 196, 195, 194]
    assert metrics["dist_pickup"] == [0, 0, 1, 2, 3, 3, 3]
    assert metrics["dist_dropoff"] == [3, 3, 2, 1, 0, 0, 0]


# Files.


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        pytest.param("actions", HUGE, "actions cannot be written as JSON: Exceeds", id="huge"),
        ("cells", (2**31, 0), "cells cannot be stored as int32 with 2 dimensions"),
        ("cells", [0, 0], "cells would change its values or types when loaded"),
        ("loaded", 2, "loaded cannot be stored as bool with 1 dimensions"),
        ("battery", 2**63, "battery cannot be stored as int64"),
        ("rewards", 10**400, "rewards cannot be stored as float64"),
        ("rewards", "1", "rewards cannot be stored as float64"),
        ("rewards", math.nan, "rewards has a number outside -1e+12..1e+12"),
        ("seed", 1.5, "seed is 1.5; it must be int"),
        ("seed", object(), "seed cannot be written as JSON"),
        ("reasons", 5, "reasons must be a list of words"),
    ],
)
def test_a_value_that_would_change_is_named(tmp_path, name: str, value: Any, message: str) -> None:
    original = on_line("PICK", "E", "W", "W", max_steps=4)
    values = getattr(original, name)
    changed = [value, *values[1:]] if isinstance(values, list) else value
    with pytest.raises(RecordError, match=re.escape(message)):
        dataclasses.replace(original, **{name: changed}).save(tmp_path / "any.npz")


def test_a_record_without_a_step_loads_as_it_was_saved(tmp_path: Path) -> None:
    episode = EpisodeRecorder(WarehouseEnv()).episode
    episode.save(tmp_path / "empty.npz")
    assert Episode.load(tmp_path / "empty.npz") == episode


def test_values_of_a_fleet_that_would_load_as_others_are_not_saved(tmp_path: Path) -> None:
    episode = fleet_episode()
    for changes in (
        {"rewards": episode.rewards + np.inf},
        {"cells": episode.cells[:-1]},
        {"seed": -1},
        {"agent": None},
        {"orders": [Order("now", 3, (1, 1), (1, 2))]},  # type: ignore[arg-type]
        {"reasons": [("one",)]},
    ):
        with pytest.raises(RecordError, match=r"fleet\.npz: "):
            dataclasses.replace(episode, **changes).save(tmp_path / "fleet.npz")
    assert not [*tmp_path.iterdir()]


# Replays.


def on_charger(backend: str) -> Episode:
    env = WarehouseEnv(["PCD"], (0, 0), battery=14, backend=backend)
    script = ("PICK", "E", "E", "W", "WAIT", "WAIT", "WAIT", "E", "DROP")
    episode = record_episode(env, Script(*script), randomize=False)
    assert episode.battery == [14, 13, 12, 11, 10, 14, 14, 14, 13, 12]
    assert (episode.outcome, episode.layout.chargers) == ("delivered", ((0, 1),))
    return episode


def greedy(seed: int) -> Episode:
    env = WarehouseEnv(battery=60, view_radius=1)
    return record_episode(env, GreedyAgent(seed=seed), seed=seed)


ORDERS = [Order(0, 40, (1, 1), (1, 5)), Order(3, 4, (1, 5), (1, 1), 2)]
STREAMS = [OrderStream(0.1), OrderStream(0.5, pickup_weights=[1, 0], start=9)]
AISLES = People(1, "aisles", 0.5)
KINDS: dict[str, Callable[[], Episode]] = {
    "random starts": lambda: greedy(1),
    "a drop at the end": lambda: greedy(4),
    "limits": lambda: record_episode(WarehouseEnv(LINE, (0, 1), 7, 9, 1), Script(*"EWWEWWW")),
    "a charger": lambda: on_charger("grid"),
    "a charger and a body": lambda: on_charger("physics"),
    "orders": fleet_episode,
    "reasons": lambda: fleet_episode(agent=Talkers(), max_steps=20),
    "assigned by the agent": lambda: fleet_episode(agent=Choosers(), dispatch=False),
    "assigned by the agent and the fleet": lambda: fleet_episode(agent=Choosers(), orders=0.6),
    "a list": lambda: fleet_episode(orders=ORDERS),
    "streams": lambda: fleet_episode(orders=STREAMS),
    "a queue": lambda: fleet_episode(orders=OrderQueue(3, (9, 30), pickup_weights=[1, 2])),
    "no orders": lambda: fleet_episode(orders=None, people=0, layout=LANE, robots=2, battery=20),
    "joules": lambda: fleet_episode(battery=Battery(3000, "joules", knee=0.9), people=AISLES),
    "bodies": lambda: fleet_episode(backend="physics", max_steps=12),
    "one robot": lambda: fleet_episode(robots=1, people=0, orders=None),
}


@pytest.mark.parametrize("record", KINDS.values(), ids=KINDS.keys())
def test_a_record_loads_and_replays_bit_for_bit(record: Callable[[], Episode], tmp_path) -> None:
    episode = record()
    assert episode.steps > 5
    episode.save(tmp_path / "any.npz")
    loaded, before = Episode.load(tmp_path / "any.npz"), copy.deepcopy(episode)
    assert loaded == episode == replay_episode(loaded)
    assert episode == before
    again = replay_episode(loaded)
    if episode.is_fleet:
        again.battery[-1, 0] += 1
    else:
        again.battery[-1] += 1
    assert again != episode


def test_a_replay_on_another_backend_keeps_the_rules_and_names_the_backend(episode) -> None:
    replayed = replay_episode(episode, backend=GridMotion(cell_size=0.5))
    assert replayed.rewards == episode.rewards
    assert replayed.cells == episode.cells
    assert replayed.settings.backend == "GridMotion"
    assert replayed.settings.cell_size == 0.5
    assert replayed.motions != episode.motions
    fleet = fleet_episode(max_steps=8)
    other = replay_episode(fleet, "physics")
    assert other.backend == "physics"
    assert np.array_equal(other.cells, fleet.cells)
    assert not np.array_equal(other.joules, fleet.joules)


def test_a_replay_resets_the_motion_to_the_start_and_seed_of_the_record(episode: Episode) -> None:
    resets = []

    class Recording(GridMotion):
        def reset(self, layout: Layout, cells: Any, seed: int | None) -> None:
            resets.append((layout, list(cells), seed))
            super().reset(layout, cells, seed)

    replay_episode(episode, backend=Recording())
    assert resets[-1] == (episode.layout, [episode.cells[0]], 3)


# Fleets.


def test_a_record_holds_what_the_fleet_did() -> None:
    env = FleetEnv(SHELVES, 3, orders=0.3, people=2, max_steps=9)
    recorder = FleetRecorder(env, seed=3, agent="hand")
    frames, rewards = [], []
    first = recorder.episode
    assert (first.steps, first.actions.shape, first.cells.shape) == (0, (0, 3), (1, 3))
    moves = [["N", 1, "fly"], np.array([9, 3, 0]), {0: "W", 1: "wait", 2: "pick"}]
    for actions in (*moves, *moves, *moves):
        assert not recorder.ended
        frames.append((env.cells, env.people, env.loaded, env.battery))
        recorder.step(actions)
        rewards.append(env.measures.joules)
    frames.append((env.cells, env.people, env.loaded, env.battery))
    assert recorder.ended
    episode = recorder.episode
    width = SHELVES.width
    assert (episode.seed, episode.agent, episode.backend) == (3, "hand", "grid")
    assert episode.actions[:3].tolist() == [[0, 1, INVALID], [INVALID, 3, 0], [3, 4, 5]]
    for frame, (cells, people, loaded, battery) in enumerate(frames):
        assert [divmod(cell, width) for cell in episode.cells[frame].tolist()] == cells
        assert [divmod(cell, width) for cell in episode.people[frame].tolist()] == people
        assert episode.loaded[frame].tolist() == loaded
        assert episode.battery[frame].tolist() == battery
    assert np.cumsum(episode.joules.sum(axis=1)).tolist() == pytest.approx(rewards)
    assert episode.orders == env.orders
    # From Python 3.13 on, dataclasses with NaN differ even if both have the same NaN.
    assert repr(episode.measures) == repr(env.measures)
    assert (episode.truncated.tolist(), episode.terminated.tolist()) == ([True] * 3, [False] * 3)
    assert episode.motions == []


def test_a_seed_is_drawn_and_kept() -> None:
    one, other = (fleet_episode(seed=None) for _ in range(2))  # type: ignore[arg-type]
    assert one.seed != other.seed
    assert replay_episode(one) == one


@pytest.mark.parametrize("reason", [None, 5, ["one"], "all"])
def test_any_reason_of_a_fleet_is_kept_as_text(reason: object) -> None:
    recorder = FleetRecorder(FleetEnv(LANE, 2, orders=None), seed=1)
    recorder.step([INVALID, "WAIT"], reason)
    assert recorder.episode.reasons == [(str(reason),) * 2]
    assert recorder.episode.actions.tolist() == [[INVALID, WAIT]]


def test_a_fleet_and_a_lone_robot_have_different_records() -> None:
    assert fleet_episode(robots=1, people=0) != on_line(*DELIVERY) != "a record"
