import random
from collections.abc import Sequence
from typing import Any

import pytest

from agents.warehouse_agent_greedy import GreedyAgent, distance, distance_after, open_moves
from warehouse_core import Cell, Observation, WarehouseEnv, record_episode

OPEN = ["...", ".R.", "..."]


def seen(
    here: Cell = (5, 5),
    *,
    pickup: Cell | None = (9, 9),
    dropoff: Cell | None = (0, 0),
    loaded: bool = False,
    view: Sequence[str] = OPEN,
) -> Observation:
    return {
        "local_grid": list(view),
        "robot_pos": here,
        "has_item": loaded,
        "battery": 100,
        "steps": 0,
        "pickup_pos": pickup,
        "dropoff_pos": dropoff,
    }


def chosen(agent: GreedyAgent, *observations: Observation) -> list[tuple[str, str]]:
    """Return action and reason for each observation."""
    return [(agent.act(observation), agent.reason) for observation in observations]


# One step.


def test_distances_are_manhattan_distances() -> None:
    assert distance((1, 2), (4, 0)) == distance((4, 0), (1, 2)) == 5
    assert [distance_after(move, (2, 2), (0, 4)) for move in "NESW"] == [3, 3, 5, 5]


@pytest.mark.parametrize(
    ("view", "moves"),
    [
        (OPEN, "NESW"),
        (["###", "#R#", "###"], ""),
        ([".#.", "#r.", "..."], "ES"),
        (["#P#", "DR#", "#D#"], "NSW"),
        (["..#..", ".....", "..R#.", "..#..", "....."], "NW"),
        (["R"], "NESW"),
    ],
)
def test_open_moves_are_moves_that_no_wall_in_view_blocks(view: list[str], moves: str) -> None:
    assert open_moves(view) == list(moves)


@pytest.mark.parametrize(
    ("goal", "action"),
    [((2, 5), "N"), ((8, 5), "S"), ((5, 9), "E"), ((5, 0), "W"), ((2, 9), "N"), ((9, 9), "E")],
)
def test_a_move_that_reduces_the_distance_is_taken(goal: Cell, action: str) -> None:
    assert chosen(GreedyAgent(seed=0), seen(pickup=goal)) == [(action, "greedy")]
    assert chosen(GreedyAgent(seed=0), seen(dropoff=goal, loaded=True)) == [(action, "greedy")]


def test_a_move_into_a_wall_is_not_taken() -> None:
    walled = seen(pickup=(2, 9), view=[".#.", ".R.", "..."])
    assert chosen(GreedyAgent(seed=0), walled) == [("E", "greedy")]


def test_at_the_goal_it_picks_and_drops() -> None:
    assert chosen(GreedyAgent(seed=0), seen(pickup=(5, 5))) == [("PICK", "greedy")]
    loaded = seen(dropoff=(5, 5), loaded=True)
    assert chosen(GreedyAgent(seed=0), loaded) == [("DROP", "greedy")]


@pytest.mark.parametrize("loaded", [False, True])
def test_without_a_goal_it_waits(loaded: bool) -> None:
    nowhere = seen(pickup=None, dropoff=None, loaded=loaded)
    assert chosen(GreedyAgent(seed=0), *[nowhere] * 5) == [("WAIT", "no goal")] * 5


@pytest.mark.parametrize(("pickup", "reason"), [((2, 5), "stuck"), ((9, 9), "escape")])
def test_when_it_is_stuck_or_escapes_it_takes_any_open_move(pickup: Cell, reason: str) -> None:
    view = seen(pickup=pickup, view=[".#.", ".R.", "..."])
    steps = 1 if reason == "stuck" else 2  # an escape begins on a remembered cell
    answers = {chosen(GreedyAgent(seed=seed), *[view] * steps)[-1] for seed in range(60)}
    assert answers == {("E", reason), ("S", reason), ("W", reason)}


def test_walled_in_it_waits() -> None:
    walled_in = seen(view=["###", "#R#", "###"])
    assert chosen(GreedyAgent(seed=0), walled_in) == [("WAIT", "stuck")]


# Loops.


@pytest.mark.parametrize("escape_steps", [0, 1, 3, 5])
def test_on_a_remembered_cell_it_escapes_for_escape_steps(escape_steps: int) -> None:
    cells = [(5, 5), (5, 6), (5, 5), *((5, col) for col in range(20, 30))]
    agent = GreedyAgent(seed=0, escape_steps=escape_steps)
    reasons = [reason for _, reason in chosen(agent, *map(seen, cells))]
    expected = ["greedy"] * 2 + ["escape"] * escape_steps + ["greedy"] * (11 - escape_steps)
    assert reasons == expected


def test_an_escape_stops_at_the_goal() -> None:
    answers = chosen(GreedyAgent(seed=0), seen(), seen(), seen((9, 9)))
    assert answers[1][1] == "escape"
    assert answers[2] == ("PICK", "greedy")
    again = chosen(GreedyAgent(seed=0), seen((9, 9)), seen((9, 9)))
    assert again == [("PICK", "greedy")] * 2


@pytest.mark.parametrize("memory", [0, 4])
def test_it_remembers_as_many_positions_as_memory(memory: int) -> None:
    for between in range(6):
        detour = [seen((20 + step, 5)) for step in range(between)]
        agent = GreedyAgent(seed=0, memory=memory)
        reason = chosen(agent, seen(), *detour, seen())[-1][1]
        assert (reason == "escape") == (between < memory)


def test_it_remembers_ten_positions_by_default() -> None:
    assert (GreedyAgent().memory, GreedyAgent().escape_steps) == (10, 3)


def test_with_a_new_goal_old_positions_do_not_count() -> None:
    answers = chosen(GreedyAgent(seed=0), seen(), seen(loaded=True), seen(loaded=True))
    assert [reason for _, reason in answers] == ["greedy", "greedy", "escape"]


def test_a_reset_forgets_positions_and_escapes() -> None:
    agent = GreedyAgent(seed=0)
    chosen(agent, seen(), seen())
    agent.reset()
    assert agent.reason == ""
    assert chosen(agent, seen(), seen((6, 6))) == [("E", "greedy"), ("E", "greedy")]


# Random numbers.


def test_a_reset_restarts_the_seeded_stream() -> None:
    agent, stuck = GreedyAgent(seed=3), seen(pickup=(2, 5), view=["###", ".R.", "#.#"])
    runs = []
    for _ in range(2):
        runs.append([agent.act(stuck) for _ in range(40)])
        agent.reset()
    assert runs[0] == runs[1]
    assert len(set(runs[0])) == 3
    assert runs[0] != [GreedyAgent(seed=4).act(stuck) for _ in range(40)]


def test_only_an_unseeded_agent_draws_from_the_global_stream() -> None:
    runs = []
    for seed in (3, None, None):
        random.seed(8)
        before = random.getstate()
        runs.append(chosen(GreedyAgent(seed=seed), *[seen()] * 20))
        assert (random.getstate() == before) == (seed is not None)
    assert runs[1] == runs[2]


@pytest.mark.parametrize("name", ["memory", "escape_steps"])
def test_a_negative_number_is_an_error(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is -1; it must be at least 0"):
        GreedyAgent(**{name: -1})


# Whole episodes.


class Watched(dict[str, Any]):
    """An observation that records the keys that are read."""

    read: set[str]

    def __getitem__(self, key: str) -> Any:
        self.read.add(key)
        return super().__getitem__(key)


def test_it_uses_nothing_but_the_observation() -> None:
    watched, plain = GreedyAgent(seed=1), GreedyAgent(seed=1)
    env = WarehouseEnv()
    observation = env.reset(randomize=True, seed=1)
    for _ in range(100):
        frozen = Watched(observation)
        frozen.read = set()
        action = watched.act(frozen)
        assert action == plain.act(observation)
        assert frozen.read <= {
            "robot_pos", "has_item", "pickup_pos", "dropoff_pos", "local_grid",
        }  # fmt: skip
        assert frozen == observation
        observation = env.step(action)[0]


@pytest.mark.parametrize(
    ("options", "least", "most"),
    [
        ({}, 0.80, 0.90),
        ({"escape_steps": 0}, 0.30, 0.48),
        ({"escape_steps": 1}, 0.70, 0.80),
        ({"memory": 3}, 0.0, 0.80),
    ],
)
def test_it_delivers_in_about_85_of_100_episodes_and_less_often_without_escapes_or_memory(
    options: dict[str, int], least: float, most: float
) -> None:
    """The standard error of the share of 200 episodes is 0.025."""
    env = WarehouseEnv()
    episodes = (
        record_episode(env, GreedyAgent(seed=seed, **options), seed=seed) for seed in range(200)
    )
    assert least < sum(episode.terminated for episode in episodes) / 200 < most


def test_another_loop_during_an_escape_does_not_lengthen_it() -> None:
    cells = [(5, 5), (5, 5), (5, 5), (5, 5), (5, 9)]
    reasons = [reason for _, reason in chosen(GreedyAgent(seed=0), *map(seen, cells))]
    assert reasons == ["greedy", "escape", "escape", "escape", "greedy"]


def test_it_never_drives_into_a_wall_in_view() -> None:
    for seed in range(20):
        episode = record_episode(WarehouseEnv(), GreedyAgent(seed=seed), seed=seed)
        assert not any(motion.blocked for motion in episode.motions)
