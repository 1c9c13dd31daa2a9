"""Episodes of a lone robot as arrays, which equal ``Warehouse-v0`` step by step."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from helpers.command_line import write_mine

from agents.errors import EpisodeError
from agents.lab.datasets import source as sources
from agents.lab.datasets.source import MOTION, OF_STEPS, Source
from agents.lab.trials.task import Task
from agents.registry import make_agent
from warehouse_core import Layout
from warehouse_core.world.actions import ACTIONS, action_index
from warehouse_core.world.named_layouts import named_layout

SEEDS = range(100, 125)

DRAWING = """
import random
class Mine:
    def reset(self):
        pass
    def act(self, seen):
        return random.choice("NESW")
"""


@pytest.fixture(autouse=True)
def few_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Record few episodes side by side, so that there are several batches of seeds."""
    monkeypatch.setattr(sources, "ROWS", 7)


@pytest.mark.parametrize("agent", ["greedy", "astar", "random", "mine.py"])
def test_each_episode_equals_the_episode_in_gymnasium_with_the_same_seed(agent: str) -> None:
    Path("mine.py").write_text(DRAWING)
    source = Source(agent, Task(max_steps=60, battery=50))
    episodes = [*source.episodes(SEEDS)]
    assert [each.seed for each in episodes] == [*SEEDS]
    env = environment(source)
    for seed, arrays in episodes:
        observation, info = env.reset(seed=seed)
        acting = make_agent(agent, seed)
        acting.reset()
        steps, actions = [(observation, 0.0, False, False, info)], []
        while not any(steps[-1][2:4]):
            actions.append(action_index(acting.act(env.unwrapped.warehouse.observe())))
            steps.append(env.step(actions[-1]))
        assert_same(arrays["actions"], np.array(actions))
        columns = [np.array(each) for each in [*zip(*steps, strict=True)][:4]]
        assert_same(arrays["observations"], columns[0])
        for name, column in zip(OF_STEPS[1:], columns[1:], strict=True):
            assert_same(arrays[name], column[1:])


def environment(source: Source) -> Any:
    """Return the Gymnasium environment that the spec of a source describes."""
    assert source.spec is not None
    env: Any = gymnasium.make(source.spec)
    assert env.observation_space == source.observation_space
    assert env.action_space == source.action_space
    return env


@pytest.mark.parametrize(("backend", "tolerance"), [("grid", 0), ("physics", 1e-9)])
def test_observations_and_infos_equal_gymnasium_with_the_same_seed_and_actions(
    backend: str, tolerance: float
) -> None:
    task = Task(named_layout("trap"), 40, 30, backend, (2, 3), "stations")
    source = Source("greedy", task)
    env = environment(source)
    for seed, arrays in source.episodes(range(10)):
        steps = [env.reset(seed=seed)]
        steps += [env.step(action)[::4] for action in arrays["actions"]]
        assert all(observation in env.observation_space for observation, _ in steps)
        assert_same(arrays["observations"], np.array([observation for observation, _ in steps]))
        masks = np.array([info["action_mask"] for _, info in steps])
        assert_same(arrays["infos/action_mask"], masks)
        moved = [[getattr(info.get("motion"), name, 0) for name in MOTION] for _, info in steps]
        assert arrays["infos/motion"] == pytest.approx(np.array(moved), rel=tolerance, abs=0)
    env.close()


def assert_same(one: Any, other: Any) -> None:
    """Compare two arrays bit by bit."""
    assert (one.dtype, one.shape) == (other.dtype, other.shape)
    assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize(
    ("line", "returned", "reason"),
    [
        ("raise KeyError('way')", "'N'", "KeyError: 'way' (mine.py, line 9)"),
        ("return 'FLY'", "'N'", f"AgentError: the action is 'FLY'; allowed in a dataset: "
                                f"{', '.join(ACTIONS)}"),
        ("return None", "'N'", "TypeError: action None is NoneType"),
    ],
)  # fmt: skip
def test_an_agent_that_fails_is_named_with_its_seed_and_its_step(line, returned, reason) -> None:
    write_mine("act", line, returned)
    source = Source("mine.py", Task(Layout(["....."])))
    with pytest.raises(EpisodeError) as caught:
        next(source.episodes(range(5, 8)))
    assert str(caught.value).startswith(f"seed 5, step 4, agent mine.py: {reason}")
