"""Tests of the kinds of agents: what each of them can do that the previous kind cannot."""

import ast
import inspect
from collections import Counter

import pytest

from agents import (
    GoalBasedAgent,
    ModelBasedAgent,
    QAgent,
    ReflexAgent,
    SearchAgent,
    UtilityBasedAgent,
)
from agents.registry import make_agent
from warehouse_core import Episode, Layout, WarehouseEnv, record_episode
from warehouse_core.records.failure_modes import OSCILLATION, diagnose
from warehouse_core.task.state import Observation
from warehouse_core.world.named_layouts import named_layout

BY_NAME = {
    "reflex": ReflexAgent,
    "model": ModelBasedAgent,
    "goal": GoalBasedAgent,
    "utility": UtilityBasedAgent,
}
TRAP = ["#######", "#..#..#", "#..#.P#", "#..#..#", "#.....#", "#D....#", "#######"]
MOST_LINES = 40

each_kind = pytest.mark.parametrize("name", BY_NAME)


def from_start(env: WarehouseEnv, name: str) -> Episode:
    return record_episode(env, make_agent(name, 1), randomize=False)


@pytest.mark.parametrize("kind", [*BY_NAME.values(), QAgent], ids=lambda kind: kind.__name__)
def test_a_student_reads_a_kind_on_one_page(kind: type) -> None:
    tree = ast.parse(inspect.getsource(kind))
    for node in ast.walk(tree):
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node):
            node.body = node.body[1:]
    assert len(ast.unparse(tree).splitlines()) <= MOST_LINES


@each_kind
def test_a_kind_has_a_name_delivers_on_open_floor_and_repeats_itself(name: str) -> None:
    agent = make_agent(name, 1)
    assert type(agent) is BY_NAME[name]
    open_floor = WarehouseEnv(["..P...D"], (0, 0))
    first, again = (record_episode(open_floor, agent, randomize=False) for _ in range(2))
    assert first.actions == ["E", "E", "PICK", "E", "E", "E", "E", "DROP"]
    assert first == again
    assert all(first.reasons)


@each_kind
@pytest.mark.parametrize("grid", [[".."], ["#.#"]])
def test_a_kind_waits_without_a_goal(name: str, grid: list[str]) -> None:
    env = WarehouseEnv(grid, None, max_steps=3)
    assert from_start(env, name).actions == ["WAIT"] * 3


def test_the_reflex_agent_oscillates_in_front_of_an_obstacle_and_others_do_not() -> None:
    for name in BY_NAME:
        episode = from_start(WarehouseEnv(TRAP, (2, 2)), name)
        assert (diagnose(episode).mode == OSCILLATION) == (name == "reflex")
        assert episode.terminated == (name != "reflex")


def test_a_reflex_agent_leaves_a_loop_by_chance_and_only_its_seed_decides_how() -> None:
    env = WarehouseEnv(TRAP, (2, 2))
    episodes = {
        seed: record_episode(env, ReflexAgent(seed, 0.5), randomize=False) for seed in range(4)
    }
    assert any(each.terminated for each in episodes.values())
    assert len({tuple(each.actions) for each in episodes.values()}) > 1
    assert record_episode(env, ReflexAgent(2, 0.5), randomize=False) == episodes[2]


def test_the_model_based_agent_runs_into_no_unseen_wall_twice() -> None:
    for seed in range(20):
        env = WarehouseEnv(view_radius=0)
        episode = record_episode(env, ModelBasedAgent(), seed=seed)
        moves = zip(episode.cells, episode.actions, episode.motions, strict=False)
        hits = Counter((cell, action) for cell, action, motion in moves if motion.blocked)
        assert set(hits.values()) <= {1}
        assert episode.terminated


def test_the_goal_based_agent_takes_a_shortest_path_if_it_sees_everything() -> None:
    for seed in range(20):
        env = WarehouseEnv(view_radius=12)
        steps = record_episode(env, GoalBasedAgent(), seed=seed).steps
        assert steps == record_episode(env, SearchAgent(env.layout), seed=seed).steps


def test_the_goal_based_agent_waits_if_it_knows_that_no_path_exists() -> None:
    episode = from_start(WarehouseEnv(named_layout("closed"), (2, 1), max_steps=60), "goal")
    assert set(episode.actions[-20:]) == {"WAIT"}


# Plans that the utility-based agent compares.

STATIONS = ["P........", ".......PD", "D........"]


def test_the_utility_based_agent_prefers_the_nearest_stations_that_it_has_seen() -> None:
    def steps(name: str) -> int:
        return from_start(WarehouseEnv(STATIONS, (1, 6)), name).steps

    assert steps("utility") == 4 < steps("goal")


def test_a_station_where_an_action_has_no_effect_is_tried_once() -> None:
    agent = UtilityBasedAgent()
    assert agent.act(observed(["...", ".RP", "..."], (1, 6))) == "E"
    on_it = observed(["...", ".RD", "..."], (1, 7))
    assert agent.act(on_it) == "PICK"
    assert agent.act(on_it) == "W"


def observed(window: list[str], here: tuple[int, int]) -> Observation:
    return {
        "local_grid": window,
        "robot_pos": here,
        "has_item": False,
        "battery": 100,
        "steps": 0,
        "pickup_pos": (1, 0),
        "dropoff_pos": (1, 8),
    }


LONG = ["PC.......D"]


def test_the_utility_based_agent_charges_as_long_as_it_has_to() -> None:
    env = WarehouseEnv(LONG, (0, 6), battery=13, view_radius=5)
    assert from_start(env, "goal").outcome == "battery depleted"
    episode = from_start(env, "utility")
    assert episode.terminated
    assert Counter(episode.actions) == {"W": 6, "PICK": 1, "E": 9, "WAIT": 1, "DROP": 1}


def test_the_utility_based_agent_gives_up_if_the_battery_or_the_worth_is_too_small() -> None:
    tight, short = (WarehouseEnv(["P........D"], (0, 5), battery=units) for units in (16, 15))
    assert from_start(tight, "utility:doubt=0").terminated
    assert set(from_start(short, "utility:doubt=0").actions) == {"WAIT"}
    assert set(from_start(tight, "utility:doubt=0,worth=16").actions) == {"WAIT"}
    assert from_start(tight, "utility:doubt=0,worth=17").terminated


def test_the_utility_based_agent_avoids_unseen_cells_if_it_knows_another_path() -> None:
    floor = Layout(["P.D", "...", "..."])
    agent = UtilityBasedAgent(doubt=5.0)
    agent.act(WarehouseEnv(floor, (2, 0), view_radius=1).observe())
    assert agent._map.steps((2, 0), (2, 2)) == 2 + 5
    assert agent._map.steps((2, 0), (1, 1)) == 2


def test_the_utility_based_agent_goes_round_a_person() -> None:
    window = ["....#", "....#", "..RH#", "....#", "#####"]
    seen = observed(window, (2, 2)) | {"pickup_pos": (1, 3), "dropoff_pos": (0, 0)}
    assert UtilityBasedAgent().act(seen) == "N"  # type: ignore[arg-type]
