"""The commands ``warehouse train q`` and ``warehouse train ppo``."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING

from agents.console.options import (
    BatteryOption,
    LayoutOption,
    MaxStepsOption,
    ModelOption,
    TrainingSeedOption,
    TrainingStepsOption,
    load_layout,
)
from agents.errors import AgentError
from agents.evaluation.samples import RECENT, MakeAgent, Task
from agents.learning.q_learning import QAgent, QTable, learn
from agents.learning.q_table import save_table
from agents.run_episode import make_env

if TYPE_CHECKING:
    from agents.learning.ppo_training import PPOLearner
    from agents.learning.training import Training


LIBRARIES = ("torch", "stable_baselines3", "sb3_contrib")


def train_ppo(
    steps: TrainingStepsOption = 2_000_000,
    seed: TrainingSeedOption = 1,
    layout: LayoutOption = None,
    battery: BatteryOption = 200,
    max_steps: MaxStepsOption = 200,
    output: ModelOption = Path("ppo.npz"),
) -> None:
    """Train a network by PPO and compare it with the greedy agent.

    Writes the agent (.npz), which "warehouse run --agent ppo:FILE" takes, a
    picture of how it learnt (.png), and the model of Stable-Baselines3 (.zip)
    for those who want to train on. The .zip holds pickled Python: load only
    files of that kind that you trust.
    """
    from agents.learning.training import MODEL_SUFFIX, Training

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
        from agents.learning.ppo_training import PPOLearner
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in LIBRARIES:
            raise
        raise AgentError(
            f"training by PPO needs {error.name}, which is not installed: "
            "pip install 'warehouse-lab[rl]'"
        ) from error
    return PPOLearner(task, steps, seed)


def train_q(
    steps: TrainingStepsOption = 600_000,
    seed: TrainingSeedOption = 1,
    layout: LayoutOption = None,
    battery: BatteryOption = 200,
    max_steps: MaxStepsOption = 200,
    output: ModelOption = Path("q.npz"),
) -> None:
    """Train a table by Q-learning and compare it with the greedy agent.

    Writes the table (.npz), which "warehouse run --agent q:FILE" takes, and a
    picture of how it learnt (.png).
    """
    from agents.learning.training import MODEL_SUFFIX, Training

    task = Task(load_layout(layout), battery, max_steps)
    training = Training("Q-learning", task, steps, seed, output)
    table = QTable()

    def train() -> MakeAgent:
        return fill(table, task, steps, seed, training)

    training.run(train, {MODEL_SUFFIX: lambda path: save_table(table, path)})


def fill(table: QTable, task: Task, steps: int, seed: int, training: Training) -> MakeAgent:
    """Let a table learn under the eyes of ``training``, and return what makes its agent."""
    env = make_env(task.layout, "grid", task.battery, task.max_steps)
    recent = deque[bool](maxlen=RECENT)

    def make_agent(seed: int) -> QAgent:
        return QAgent(table, seed)

    for taken, delivered in learn(table, env, steps, seed):
        recent.append(delivered)
        training.watch(taken, sum(recent) / len(recent), make_agent)
    return make_agent
