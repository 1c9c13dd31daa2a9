import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.fleets import LINE, SHELVES, Choosers, Couriers, fleet_episode

from warehouse_core import (
    FleetEnv,
    FleetEpisode,
    Order,
    OrderQueue,
    OrderStream,
    RecordError,
    replay_fleet_episode,
)
from warehouse_core.fleet import Battery, People
from warehouse_core.records import FleetRecorder
from warehouse_core.world.actions import INVALID

KINDS: dict[str, dict[str, Any]] = {
    "orders": {},
    "assigned by the agent": {"agent": Choosers(), "dispatch": False},
    "assigned by the agent and the fleet": {"agent": Choosers(), "orders": 0.6},
    "a list": {"orders": [Order(0, 40, (1, 1), (1, 5)), Order(3, 4, (1, 5), (1, 1), 2)]},
    "streams": {"orders": [OrderStream(0.1), OrderStream(0.5, pickup_weights=[1, 0], start=9)]},
    "a queue": {"orders": OrderQueue(3, (9, 30), pickup_weights=[1, 2])},
    "no orders": {"orders": None, "people": 0, "layout": LINE, "robots": 2, "battery": 20},
    "joules": {"battery": Battery(3000, "joules"), "people": People(1, "aisles", 0.5)},
    "bodies": {"backend": "physics", "max_steps": 12},
    "one robot": {"robots": 1, "people": 0, "orders": None},
}

pytestmark = pytest.mark.filterwarnings("ignore:.*chargers supply")


@pytest.fixture(scope="module")
def episode() -> FleetEpisode:
    return fleet_episode()


@pytest.mark.parametrize("options", KINDS.values(), ids=KINDS.keys())
def test_a_record_loads_and_replays_bit_for_bit(options: dict[str, Any], tmp_path: Path) -> None:
    episode = fleet_episode(**options)
    assert episode.steps > 5
    episode.save(tmp_path / "fleet.npz")
    loaded = FleetEpisode.load(tmp_path / "fleet.npz")
    assert loaded == episode
    assert replay_fleet_episode(loaded) == episode
    again = replay_fleet_episode(loaded)
    again.battery[-1, 0] += 1
    assert again != episode


def test_agents_assign_differently_in_the_tests_of_replays() -> None:
    for options in (KINDS["assigned by the agent"], KINDS["assigned by the agent and the fleet"]):
        episode = fleet_episode(**options)
        assert episode.measures.delivered
        assert None in [order for _, _, order in episode.assignments]
        unassigned = dataclasses.replace(episode, assignments=[])
        assert replay_fleet_episode(unassigned).orders != episode.orders


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
    assert (episode.orders, episode.measures) == (env.orders, env.measures)
    assert (episode.truncated.tolist(), episode.terminated.tolist()) == ([True] * 3, [False] * 3)
    assert episode.motions == []


def test_a_move_that_was_blocked_is_recorded_with_what_blocked_it() -> None:
    env = FleetEnv(LINE, 2, orders=None, starts=[(0, 0), (0, 1)], people=0, max_steps=9)
    recorder = FleetRecorder(env, seed=1)
    recorder.step(["E", "W"])
    recorder.step(["N", "E"])
    assert recorder.episode.stopped_by.tolist() == [[1, 0], [-2, -1]]


def test_bodies_have_paths_in_metres() -> None:
    episode = fleet_episode(backend="physics", max_steps=5)
    assert [len(motions) for motions in episode.motions] == [6] * 5
    assert any(len(motion.path) > 2 for motion in episode.motions[0])
    ends = [[row * SHELVES.width + col for row, col in (m.cell for m in each)]
            for each in episode.motions]  # fmt: skip
    assert ends == np.hstack([episode.cells, episode.people])[1:].tolist()
    assert dataclasses.replace(episode, motions=[]) != episode


def test_a_seed_is_drawn_and_kept() -> None:
    one, other = (fleet_episode(seed=None) for _ in range(2))  # type: ignore[arg-type]
    assert one.seed != other.seed
    assert replay_fleet_episode(one) == one


def test_another_backend_can_replay_a_record() -> None:
    episode = fleet_episode(max_steps=8)
    other = replay_fleet_episode(episode, "physics")
    assert other.backend == "physics"
    assert np.array_equal(other.cells, episode.cells)
    assert not np.array_equal(other.joules, episode.joules)


def test_a_record_says_in_one_line_what_it_holds(episode: FleetEpisode) -> None:
    delivered = sum(order.delivered is not None for order in episode.orders)
    assert repr(episode) == (
        f"<Episode 4 robots, {delivered} of {len(episode.orders)} orders delivered, "
        f"80 steps, reward {episode.total_reward:.2f}, seed 5, agent 'Couriers'>"
    )
    assert delivered == episode.measures.delivered > 1
    alone = fleet_episode(**KINDS["one robot"])
    assert repr(alone).startswith("<Episode 1 robot, 0 of 1 item delivered, ")
    assert alone.total_reward == round(sum(alone.rewards[:, 0].tolist()), 9)
    assert episode != "a record"


def test_values_that_would_load_as_others_are_not_saved(
    episode: FleetEpisode, tmp_path: Path
) -> None:
    for changes in (
        {"rewards": episode.rewards + np.inf},
        {"cells": episode.cells[:-1]},
        {"seed": -1},
        {"agent": None},
        {"orders": [Order("now", 3, (1, 1), (1, 2))]},  # type: ignore[arg-type]
    ):
        with pytest.raises(RecordError, match=r"fleet\.npz: "):
            dataclasses.replace(episode, **changes).save(tmp_path / "fleet.npz")
    assert not [*tmp_path.iterdir()]


class Talkers(Couriers):
    """Couriers who say why, sometimes all together."""

    def act(self, env: FleetEnv) -> list[str]:
        actions = super().act(env)
        self.reason = "all wait" if set(actions) == {"WAIT"} else [f"to {a}" for a in actions]
        return actions


def test_reasons_and_words_are_kept_saved_and_replayed(tmp_path: Path) -> None:
    episode = fleet_episode(agent=Talkers(), orders=[Order(3, 40, (1, 1), (1, 5))], max_steps=20)
    assert len(episode.reasons) == len(episode.words) == episode.steps
    for words, reasons, actions in zip(
        episode.words, episode.reasons, episode.actions, strict=True
    ):
        if set(words) == {"WAIT"}:
            assert reasons == ("all wait",) * 4
        else:
            assert reasons == tuple(f"to {word}" for word in words)
        assert [word == "FLY" for word in words] == (actions == INVALID).tolist()
    assert "FLY" in episode.unknown_actions.values()
    episode.save(tmp_path / "fleet.npz")
    loaded = FleetEpisode.load(tmp_path / "fleet.npz")
    assert loaded == episode == replay_fleet_episode(loaded)
