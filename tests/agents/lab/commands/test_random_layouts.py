"""``--layout random`` of ``warehouse train ppo`` and ``warehouse compare-agents``."""

from typing import Any

import pytest
from helpers.command_line import command, refusal
from helpers.networks import random_network
from PIL import Image

from agents.lab.commands import compare_agents, train
from agents.lab.trials.random_layouts import TRAINING_LAYOUTS, RandomLayouts
from agents.lab.trials.task import Task

RANDOM = ("--layout", "random")
COMPARE = ("compare-agents", "-n", 2, "--backend", "grid", "--max-steps", 40, *RANDOM)
PPO = ("train", "ppo", *RANDOM)


@pytest.fixture(autouse=True)
def network() -> None:
    random_network(1).save("ppo.npz")


@pytest.fixture
def trained(monkeypatch: pytest.MonkeyPatch) -> list[Task]:
    """Return a list that collects the tasks to be learned, which are not."""
    tasks: list[Task] = []

    def make_learner(task: Task, steps: int, seed: int) -> Any:
        tasks.append(task)
        raise OSError("enough")

    monkeypatch.setattr(train, "make_learner", make_learner)
    return tasks


def test_agents_are_compared_in_each_size_in_one_figure(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = "--size 5x6 --size 6x9 --density 0.2 --agent ppo:ppo.npz:revisit=4 --seed 3"
    result = command(capsys, *COMPARE, *words.split(), "--save", "f.png")
    assert (result.code, result.err) == (0, "")
    out = " ".join(result.out.split())
    for size in ("5 x 6", "6 x 9"):
        assert f"random layouts of {size} with density 0.2, 2 episodes each, backend grid" in out
    assert out.count("ppo:ppo.npz:revisit=4") == 4
    with Image.open("f.png") as picture:
        assert picture.height > 1000


def test_each_seed_is_in_its_own_layout_which_agents_are_given(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    given = []
    make_agent = compare_agents.make_agent

    def note(name: str, seed: int, layout: Any) -> Any:
        given.append((seed, layout))
        return make_agent(name, seed, layout)

    monkeypatch.setattr(compare_agents, "make_agent", note)
    assert command(capsys, *COMPARE, "--seed", 7).code == 0
    assert set(given) == {(seed, RandomLayouts().layout(seed)) for seed in (7, 8)}


def test_the_pool_of_a_training_follows_from_the_options(
    capsys: pytest.CaptureFixture[str], trained: list[Task]
) -> None:
    words = ("--size", "6x9", "--density", "0.1:0.3", "--layouts", 5, "--seed", 4)
    assert refusal(capsys, *PPO, *words) == "enough"
    assert refusal(capsys, *PPO) == "enough"
    assert [task.layout for task in trained] == [
        RandomLayouts(6, 9, 0.1, 0.3, 5, pool_seed=4),
        RandomLayouts(),
    ]


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--size", "7"], 2, "--size is '7'; it must be HxW as in 7x12"),
        (["--size", "3x9"], 1, "the size is 3 x 9; it must be at least 4 x 4"),
        (["--density", "0.1:x"], 2, "--density is '0.1:x'; it must be LOW:HIGH as in 0.1:0.4"),
        (["--density", "0.1:0.2:0.3"], 2, "it must be LOW:HIGH"),
        (["--density", "0.2:0.5"], 1, "density is 0.5; it must be 0..0.4"),
        (["--density", "0.4:0.1"], 1, "density is from 0.4 to 0.1"),
    ],
)
def test_wrong_random_layouts_are_one_line_in_both_commands(
    capsys: pytest.CaptureFixture[str],
    trained: list[Task],
    words: list[str],
    code: int,
    message: str,
) -> None:
    for start in (PPO, COMPARE):
        assert message in refusal(capsys, *start, *words, code=code)
    assert not trained


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--robots", 2], 2, "--layout random is for one robot, not for --robots"),
        (["--size", "4x4"], 1, "is one of the 1024 of the training; use a larger size"),
    ],
)
def test_a_training_in_random_layouts_that_is_not_possible_is_one_line(
    capsys: pytest.CaptureFixture[str],
    trained: list[Task],
    words: list[Any],
    code: int,
    message: str,
) -> None:
    assert message in refusal(capsys, *PPO, *words, code=code)
    assert not trained


def test_options_of_random_layouts_need_them(capsys: pytest.CaptureFixture[str]) -> None:
    for option, value in (("--size", "7x12"), ("--density", "0.2"), ("--layouts", 3)):
        message = f"Invalid value: {option} is of random layouts; add --layout random"
        assert refusal(capsys, "train", "ppo", option, value, code=2) == message
        if option != "--layouts":
            assert refusal(capsys, "compare-agents", option, value, code=2) == message


def test_a_comparison_in_random_layouts_that_is_not_possible_is_one_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    message = "Invalid value: --start is '1,1'; in random layouts it is always drawn"
    assert refusal(capsys, *COMPARE, "--start", "1,1", code=2) == message
    line = refusal(capsys, *COMPARE, "--seed", TRAINING_LAYOUTS - 1)
    assert line.startswith(f"the seed of a random layout is {TRAINING_LAYOUTS}; allowed: 0..")
