"""The command ``warehouse train clone``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from agents.lab.commands import random_layouts
from agents.lab.commands.train import (
    MODEL_SUFFIX,
    AgentFile,
    Resume,
    Steps,
    Training,
    TrainingSeed,
    check_agent_file,
    needed_libraries,
)
from agents.lab.console import options
from agents.lab.console.options import option
from agents.lab.console.values import load_layout
from agents.lab.parameters import size as check_size
from agents.lab.training.exams import EXAM_SEEDS, FINAL_SEEDS
from agents.lab.trials.random_layouts import RandomLayouts, VariedLayouts
from agents.lab.trials.task import Task
from agents.registry import make_agent
from warehouse_core import Layout

if TYPE_CHECKING:
    from agents.learning.clone_training import CloneLearner

KNOWS_THE_MAP = "astar"
"""Teacher that needs no search in each step, and accepts each first move of a shortest way."""

MOST_STEPS = 800
"""Steps of an episode of a lone robot, and of its battery."""

DEFAULTS = VariedLayouts()
SIZE = f"{DEFAULTS.height}x{DEFAULTS.width}"


def train_clone(
    teacher: Annotated[str, option("--from NAME", f"Teacher. {options.AGENT}")] = KNOWS_THE_MAP,
    steps: Steps = 1_000_000,
    seed: TrainingSeed = 1,
    layout: random_layouts.LayoutOrRandom = None,
    battery: options.BatteryOption = MOST_STEPS,
    max_steps: options.MaxSteps = MOST_STEPS,
    size: Annotated[
        str | None,
        option(
            "--size HxW",
            f"Rows and columns of random layouts. Here the largest. Default: {SIZE}.",
            check_size,
        ),
    ] = None,
    layouts: random_layouts.Pool = None,
    save: AgentFile = Path("clone.npz"),
    resume: Resume = False,
) -> None:
    """Train a network by imitation.

    The network moves the robot, and learns what its teacher would have done
    there (DAgger). It sees a map of where it has been. The default teacher knows
    the whole map, which the network does not: so it learns where to look first,
    and to search where it has been least.

    Writes the agent (.npz), which "warehouse run --agent clone:FILE" takes, and
    what "warehouse train ppo" writes too, but for the .zip. By default the
    training takes about two minutes.

    With --layout random each episode is in one of many floors of any size up to
    --size, two in five of them mazes. Exams and the comparison at the end are on
    other floors than the training.

    Example: warehouse train clone --from astar --layout random -o clone.npz
    """
    place: Layout | RandomLayouts
    if random_layouts.are_wanted(layout, size=size, layouts=layouts):
        height, width = map(int, (size or SIZE).split("x"))
        varied = VariedLayouts(height, width, count=layouts or DEFAULTS.count, pool_seed=seed)
        place = varied.without([*EXAM_SEEDS, *FINAL_SEEDS])
    else:
        place = load_layout(layout)
    task = Task(place, battery, max_steps)
    check_agent_file(save)
    learner = make_clone_learner(teacher, task, steps, seed)
    training = Training(f"clone of {teacher}", task, steps, seed, save)
    training.run(learner, {MODEL_SUFFIX: learner.save_network}, resume=resume)


def make_clone_learner(teacher: str, task: Task, steps: int, seed: int) -> CloneLearner:
    """Return a learner from a teacher; an ``AgentError`` says how to install what is missing."""
    from agents.learning.teachers import AgentTeacher, ShortestWays

    make = partial(make_agent, teacher, seed)
    make(task.layout_for(0))  # a wrong name is an error before the training
    with needed_libraries("imitation"):
        from agents.learning.clone_training import ENVS, CloneLearner
    batch = task.make_batch(ENVS)
    knows = teacher == KNOWS_THE_MAP
    return CloneLearner(
        batch, ShortestWays(batch) if knows else AgentTeacher(batch, make), steps, seed
    )
