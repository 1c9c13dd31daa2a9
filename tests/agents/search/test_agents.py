"""Search agents deliver by a shortest path, or report that there is none."""

import random
from collections.abc import Iterable, Sequence
from typing import Any

import pytest

from agents.search.agents import ALGORITHMS, ExploringAgent, SearchAgent
from warehouse_core import (
    DEFAULT_LAYOUT,
    Episode,
    Layout,
    WarehouseEnv,
    random_layout,
    record_episode,
)
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import fewest_steps
from warehouse_core.world.named_layouts import named_layout

EXACT = ["bfs", "ucs", "astar"]
CUT_OFF = Layout(["#######", "#P.#.D#", "#######"])


def run(agent: Any, layout: Layout, seed: int = 0, **options: Any) -> Episode:
    env = WarehouseEnv(layout, layout.default_start(), **options)
    return record_episode(env, agent, seed=seed)


def fewest(episode: Episode) -> int:
    [steps] = fewest_steps(episode.layout, (episode.cells[0], False))
    assert steps is not None
    return steps


def layouts(count: int) -> Iterable[Layout]:
    stream = random.Random(1)
    for seed in range(count):
        yield random_layout(
            stream.randint(5, 12), stream.randint(5, 12), stream.uniform(0, 0.4), seed
        )


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_delivery_takes_the_fewest_steps_where_they_are_promised(algorithm: str) -> None:
    for seed, layout in enumerate(layouts(20)):
        episode = run(SearchAgent(layout, algorithm), layout, seed)
        assert episode.outcome == DELIVERED
        assert episode.steps == fewest(episode) or algorithm not in EXACT


def test_without_random_stations_those_of_the_layout_are_used() -> None:
    layout = Layout(["########", "#D....P#", "#.####.#", "#P....D#", "########"])
    env = WarehouseEnv(layout, (1, 5))
    episode = record_episode(env, SearchAgent(layout), randomize=False)
    # The nearest pickup and dropoff are not the first of the layout.
    assert list(episode.actions) == ["E", "PICK", "S", "S", "DROP"]


def test_a_plan_that_saves_energy_carries_the_item_a_shorter_distance() -> None:
    floor = "#P.........D...PD#"
    layout = Layout(["#" * len(floor), floor, "#" * len(floor)])
    episodes = {}
    for cost in ("steps", "joules"):
        env = WarehouseEnv(layout, (1, 3), backend="physics")
        episodes[cost] = record_episode(env, SearchAgent(layout, cost=cost), randomize=False)
    # Two cells to the first pickup and ten with the item, or twelve without it and one with it.
    assert episodes["steps"].actions[:3] == ["W", "W", "PICK"]
    assert episodes["joules"].actions[:3] == ["E", "E", "E"]
    assert episodes["joules"].steps > episodes["steps"].steps
    assert episodes["joules"].joules < episodes["steps"].joules


def test_an_agent_plans_once_and_follows_the_plan() -> None:
    agent = SearchAgent(DEFAULT_LAYOUT)
    episode = run(agent, DEFAULT_LAYOUT, 12)
    assert agent.plans == 1
    assert agent.expanded > 0
    assert list(dict.fromkeys(episode.reasons)) == ["has a plan", "follows its plan"]


UNREACHABLE = ["#######", "#..#.P#", "#D.#..#", "#######"]


@pytest.mark.parametrize("rows", [CUT_OFF.rows, UNREACHABLE])
@pytest.mark.parametrize("kind", ["search", "exploring"])
def test_without_a_path_an_agent_waits_and_gives_the_reason(kind: str, rows: Sequence[str]) -> None:
    agent: Any = SearchAgent(Layout(rows)) if kind == "search" else ExploringAgent()
    episode = record_episode(WarehouseEnv(rows, (1, 1), max_steps=8), agent, randomize=False)
    assert episode.actions[-1] == "WAIT"
    assert agent.plans <= 2
    assert episode.reasons[-1].startswith("no path to")
    if kind == "search" and rows == UNREACHABLE:
        assert set(episode.actions) == {"WAIT"}
        assert episode.reasons[-1] == "no path to the pickup and dropoff"


def test_an_agent_that_is_off_its_plan_makes_a_new_one() -> None:
    layout = Layout(["#######", "#P....#", "#.....#", "#....D#", "#######"])
    for agent in (SearchAgent(layout), ExploringAgent()):
        env = WarehouseEnv(layout, (3, 1), view_radius=1)
        observation = env.reset()
        agent.reset()
        for step in range(30):
            if step == 1:
                first = agent.expanded
                env.state.robot_pos = (2, 5)
                observation = env.observe()
            observation, _, delivered, _, _ = env.step(agent.act(observation))
            if delivered:
                break
        assert delivered
        assert agent.plans >= 2
        assert agent.expanded > first > 0
        agent.reset()
        assert agent.expanded == agent.plans == 0


def test_a_robot_without_a_view_tries_a_failed_move_again_and_gives_up_in_the_end() -> None:
    agent, env = ExploringAgent(), WarehouseEnv(["####", "#.P#", "#D.#", "####"], view_radius=0)
    observation = env.reset()
    actions = [agent.act(observation) for _ in range(200)]
    assert actions[:3] == ["E", "E", "E"]
    assert actions[-1] == "WAIT"
    assert agent.reason.startswith("no path to (1, 2)")


def test_the_exploring_agent_finds_a_path() -> None:
    for seed, layout in enumerate(layouts(20)):
        agent = ExploringAgent()
        episode = run(agent, layout, seed, max_steps=1000, battery=1000, view_radius=1 + seed % 3)
        assert episode.outcome == DELIVERED
        assert episode.steps >= fewest(episode)


def test_an_agent_that_does_not_replan_carries_out_its_first_plan_blindly() -> None:
    layout = named_layout("bay")
    blind, looking = SearchAgent(layout, replan=False), SearchAgent(layout)
    plan = [*run(looking, layout, 35).actions]
    assert [*run(blind, layout, 35).actions] == plan
    observation = WarehouseEnv(layout).reset()
    blind.reset()
    plan = [blind.act(observation) for _ in range(30)]
    end = plan.index("DROP") + 1
    assert plan[:3] == [*plan[:1] * 3], "although the robot does not move"
    assert plan[end:] == ["WAIT"] * (30 - end)
    assert (blind.plans, blind.reason) == (1, "its plan has ended")
    with pytest.raises(TypeError, match=r"^replan is 3; it must be True or False$"):
        SearchAgent(layout, replan=3)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"algorithm": "dijkstra"}, "algorithm is 'dijkstra'; allowed: bfs, ucs, "),
        ({"cost": "money"}, "cost is 'money'; allowed: steps, seconds, joules"),
        ({"weight": float("nan")}, "weight is nan; it must be 0..1000000 or infinity"),
    ],
)
def test_an_invalid_argument_is_an_error(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=r"allowed|must be") as caught:
        SearchAgent(DEFAULT_LAYOUT, **options)
    assert str(caught.value).startswith(words)
