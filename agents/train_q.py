"""Train a table by Q-learning and compare it with the greedy agent.

``warehouse train q``, ``python agents/train_q.py`` and ``python -m agents.train_q`` are the same
command. How the table learns is in ``q_learning.py``.
"""

from __future__ import annotations

from collections import deque
from pathlib import Path

import typer

from agents.console import BatteryOption, LayoutOption, MaxStepsOption, load_layout, main
from agents.evaluation import RECENT, MakeAgent, Task
from agents.q_learning import QAgent, QTable, learn
from agents.q_table_file import save_table
from agents.run_episode import make_env
from agents.training import (
    MODEL_SUFFIX,
    OutputOption,
    StepsOption,
    Training,
    TrainingSeedOption,
)


def train_q(
    steps: StepsOption = 600_000,
    seed: TrainingSeedOption = 1,
    layout: LayoutOption = None,
    battery: BatteryOption = 200,
    max_steps: MaxStepsOption = 200,
    output: OutputOption = Path("q.npz"),
) -> None:
    """Train a table by Q-learning and compare it with the greedy agent.

    Writes the table (.npz), which "warehouse run --agent q:FILE" takes, and a
    picture of how it learnt (.png).
    """
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


if __name__ == "__main__":
    app = typer.Typer(add_completion=False)
    app.command()(train_q)
    main(app)
