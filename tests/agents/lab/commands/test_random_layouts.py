"""``--layout random`` for ``warehouse train ppo`` and ``warehouse compare agents``."""

from typing import Any

from helpers.command_line import Refused, Warehouse
from helpers.networks import random_network
from PIL import Image

from agents.lab.commands import train
from agents.lab.trials.random_layouts import RandomLayouts
from agents.lab.trials.task import Task

RANDOM = ("--layout", "random")
COMPARE = ("compare", "agents", "-n", 2, "--backend", "grid", "--max-steps", 40, *RANDOM)
PPO = ("train", "ppo", *RANDOM)


def test_agents_are_compared_in_each_size_in_one_figure(warehouse: Warehouse) -> None:
    random_network(1).save("ppo.npz")
    words = "--size 5x6 --size 6x9 --density 0.2 --agent ppo:ppo.npz:revisit=4 --seed 3"
    result = warehouse(*COMPARE, *words.split(), "--save", "f.png")
    assert (result.code, result.err) == (0, "")
    out = " ".join(result.out.split())
    for size in ("5 x 6", "6 x 9"):
        assert f"random layouts of {size} with density 0.2, 2 episodes each, backend grid" in out
    assert out.count("ppo:ppo.npz:revisit=4") == 4
    with Image.open("f.png") as picture:
        assert picture.width > 900


def test_the_options_determine_the_pool_for_training(refused: Refused, monkeypatch) -> None:
    tasks: list[Task] = []

    def make_learner(task: Task, steps: int, seed: int) -> Any:
        tasks.append(task)
        raise OSError("enough")

    monkeypatch.setattr(train, "make_learner", make_learner)
    words = ("--size", "6x9", "--density", "0.1:0.3", "--layouts", 5, "--seed", 4)
    assert refused(*PPO, *words) == refused(*PPO) == "enough"
    assert [task.layout for task in tasks] == [
        RandomLayouts(6, 9, 0.1, 0.3, 5, pool_seed=4),
        RandomLayouts(),
    ]
