"""Train a network by PPO until it beats the greedy agent; needs the extra ``rl``.

``warehouse train ppo``, ``python agents/train_ppo.py`` and ``python -m agents.train_ppo`` are the
same command. PyTorch is imported when the training begins, not before.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from agents.agent_error import AgentError
from agents.console import BatteryOption, LayoutOption, MaxStepsOption, load_layout, main
from agents.evaluation import Task
from agents.training import (
    MODEL_SUFFIX,
    OutputOption,
    StepsOption,
    Training,
    TrainingSeedOption,
)

if TYPE_CHECKING:
    from agents.ppo_training import PPOLearner

LIBRARIES = ("torch", "stable_baselines3", "sb3_contrib")


def train_ppo(
    steps: StepsOption = 2_000_000,
    seed: TrainingSeedOption = 1,
    layout: LayoutOption = None,
    battery: BatteryOption = 200,
    max_steps: MaxStepsOption = 200,
    output: OutputOption = Path("ppo.npz"),
) -> None:
    """Train a network by PPO and compare it with the greedy agent.

    Writes the agent (.npz), which "warehouse run --agent ppo:FILE" takes, a
    picture of how it learnt (.png), and the model of Stable-Baselines3 (.zip)
    for those who want to train on. The .zip holds pickled Python: load only
    files of that kind that you trust.
    """
    task = Task(load_layout(layout), battery, max_steps)
    training = Training("PPO", task, steps, seed, output)
    learner = make_learner(task, steps, seed)
    writers = {MODEL_SUFFIX: learner.save_network, ".zip": learner.save_model}
    training.run(lambda: learner.learn(training.watch), writers)


def make_learner(task: Task, steps: int, seed: int) -> PPOLearner:
    """Return what learns a task.

    Raises:
        AgentError: a library is missing; it says which command installs it.
    """
    try:
        from agents.ppo_training import PPOLearner
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in LIBRARIES:
            raise
        raise AgentError(
            f"training by PPO needs {error.name}, which is not installed: "
            "pip install 'warehouse-lab[rl]'"
        ) from error
    return PPOLearner(task, steps, seed)


if __name__ == "__main__":
    app = typer.Typer(add_completion=False)
    app.command()(train_ppo)
    main(app)
