"""The command ``warehouse train``: agents that learn by reward or by imitation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray

from agents.errors import AgentError
from agents.lab.commands import random_layouts
from agents.lab.console import options
from agents.lab.console.group import CommandOfKinds
from agents.lab.console.options import given, option, refuse
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.console.values import load_layout
from agents.lab.parameters import Whole
from agents.lab.parameters import size as check_size
from agents.lab.training.checkpoint import load_checkpoint, save_checkpoint
from agents.lab.training.driving import known, train_drive
from agents.lab.training.exams import EXAM_SEEDS, FINAL_SEEDS, Examiner, save_points
from agents.lab.trials.interval import mean, share
from agents.lab.trials.random_layouts import RandomLayouts, VariedLayouts
from agents.lab.trials.scores import FleetScores, Scores
from agents.lab.trials.task import FleetTask, Task
from agents.lab.trials.workers import CheckInterrupt, deferred_interrupts
from agents.learning.learner import Learner, MakeAgent
from agents.learning.q_table import save_table
from agents.learning.q_training import QLearner
from agents.registry import make_agent, make_team
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Layout
from warehouse_core.extras import not_installed
from warehouse_core.files.atomic import check_suffix, check_target
from warehouse_core.wording import brief

if TYPE_CHECKING:
    from agents.learning.clone_training import CloneLearner
    from agents.learning.ppo_training import PPOLearner

LIBRARIES = ("torch", "stable_baselines3", "sb3_contrib")
"""Libraries that the training of networks needs."""

MODEL_SUFFIX, CURVE_SUFFIX, POINTS_SUFFIX = ".npz", ".png", ".csv"
CHECKPOINT_SUFFIX = ".checkpoint"

VERSIONS = ("numpy", "stable_baselines3", "sb3_contrib", "torch", "warehouse-lab")
"""Distributions whose versions affect the result of a training."""

Writer = Callable[[Path], None]

KNOWS_THE_MAP = "astar"
"""Teacher that need not search in each step, and accepts the first move of any shortest path."""

VARIED = VariedLayouts()


class Kind(NamedTuple):
    """A kind of training, with its defaults and its options.

    Attributes:
        name: name in messages and pictures.
        steps: default number of training steps, a minimum.
        limit: default of the maximum steps of an episode, and of the steps that a battery lasts.
        options: names of its options, except for the file that is saved.
    """

    name: str
    steps: int
    limit: int
    options: str


OF_AGENTS = "steps seed layout battery max_steps resume"
"""Options of the kinds that train agents for the actions of the grid."""

KINDS = {
    "q": Kind("Q-learning", 600_000, 200, OF_AGENTS),
    "ppo": Kind("PPO", 2_000_000, 200, f"{OF_AGENTS} robots order_rate size density layouts"),
    "clone": Kind("clone", 1_000_000, 800, f"{OF_AGENTS} teacher size layouts"),
    "drive": Kind("continuous control", 7_000_000, 200, "steps seed layout"),
}


class TrainCommand(CommandOfKinds):
    """The command ``warehouse train``, whose help lists the options of a kind."""

    argument = "kind"
    names: ClassVar = {name: each.options.split() for name, each in KINDS.items()}


def defaults_of(field: str) -> str:
    """Return the defaults of all kinds for a field of ``Kind``, in words."""
    names: dict[int, list[str]] = {}
    for name, kind in KINDS.items():
        names.setdefault(getattr(kind, field), []).append(name)
    return ", ".join(f"{value:,} for {' and '.join(kinds)}" for value, kinds in names.items())


def train(
    context: typer.Context,
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND",
            help="Kind of training. q: a table by Q-learning; ppo: a network by PPO; clone: a "
            "network by imitation (DAgger), whose input includes a map of the visited cells; "
            "drive: a network that controls a body, by PPO.",
        ),
    ],
    steps: Annotated[
        int | None,
        option(
            "--steps N",
            f"Minimum number of training steps. Default: {defaults_of('steps')}.",
            Whole(1),
        ),
    ] = None,
    seed: Annotated[int, option("--seed N", options.SEED, Whole(0, 2**32 - 1))] = 1,
    layout: random_layouts.LayoutOrRandom = None,
    battery: Annotated[
        int | None, options.parameter_option("battery", more=f"Default: {defaults_of('limit')}.")
    ] = None,
    max_steps: Annotated[
        int | None, options.parameter_option("max_steps", more=f"Default: {defaults_of('limit')}.")
    ] = None,
    robots: Annotated[
        int,
        option(
            "--robots -r N",
            f"{options.ROBOTS} Several robots have orders. Only for ppo.",
            Whole(1, 1000),
        ),
    ] = 1,
    order_rate: options.OrderRate = 0.2,
    teacher: Annotated[
        str, option("--from NAME", "Name of the agent that teaches the clone.")
    ] = KNOWS_THE_MAP,
    size: Annotated[
        str | None,
        option(
            "--size HxW",
            f"{random_layouts.SIZE} For clone: the largest size. Default: "
            f"{VARIED.height}x{VARIED.width}.",
            check_size,
        ),
    ] = None,
    density: random_layouts.Density = None,
    layouts: random_layouts.Pool = None,
    save: Annotated[
        Path | None,
        option("--save -o FILE", f"{options.SAVE} The agent is saved as .npz. Default: KIND.npz."),
    ] = None,
    resume: Annotated[
        bool,
        option(
            "--resume",
            "Continue an interrupted training from its checkpoint. Repeat the other options.",
        ),
    ] = False,
) -> None:
    """Train an agent by reward or by imitation.

    The command writes the agent (.npz) for "warehouse run --agent KIND:FILE",
    its learning curve (.png), and the points of the curve (.csv). ppo also
    writes a model for Stable-Baselines3 (.zip). Each exam writes a .checkpoint
    for --resume. The .zip and the .checkpoint contain pickled Python: load
    only files that you trust.

    With --layout random, each episode is in one of many random layouts, and
    exams are in other layouts. "warehouse train KIND -h" lists the options of
    a kind. drive writes only its network, for "warehouse run --backend drive
    --agent drive:FILE", and prints an exam.

    Example: warehouse train ppo --steps 2000000 -o ppo.npz
    """
    if kind not in KINDS:
        raise typer.BadParameter(f"KIND is {brief(kind)}; allowed: {', '.join(KINDS)}")
    chosen = KINDS[kind]
    refuse(context, given(context) - {*chosen.options.split(), "kind", "save"}, f"train {kind}")
    steps, limit = steps or chosen.steps, max_steps or chosen.limit
    battery = battery or chosen.limit
    target = save or Path(f"{kind}.npz")
    is_random = random_layouts.are_wanted(layout, size=size, density=density, layouts=layouts)
    known_map = kind in ("q", "drive")
    if is_random and (known_map or robots > 1):
        raise typer.BadParameter(
            "--layout random cannot be combined with "
            + (f"'train {kind}'" if known_map else "--robots: random layouts have one robot")
        )
    task: Task | FleetTask
    if robots > 1:
        task = FleetTask(load_layout(layout), robots, order_rate, battery, limit)
    elif is_random:
        default = VARIED if kind == "clone" else random_layouts.DEFAULTS
        drawn = random_layouts.parse(size, density, layouts, seed, default)
        task = Task(drawn, battery, limit)
    else:
        task = Task(load_layout(layout), battery, limit)
    check_suffix(target, (MODEL_SUFFIX,))
    if kind == "drive":
        with needed_libraries("training of continuous control"):
            print_table(train_drive(load_layout(layout), steps, seed, target))
        return
    if isinstance(task, Task) and isinstance(task.layout, RandomLayouts):
        task = task._replace(layout=task.layout.without([*EXAM_SEEDS, *FINAL_SEEDS]))
    name = chosen.name if kind != "clone" else f"clone of {teacher}"
    training = Training(name, task, steps, seed, target)
    learner, writers = learner_of(kind, task, steps, seed, teacher)
    training.run(learner, writers, resume=resume)
    if kind == "ppo" and is_random:
        say(
            f"ppo:{target}:revisit=4 avoids visited cells and therefore leaves loops; to compare "
            f"it: warehouse compare agents --layout random --agent ppo:{target}:revisit=4"
        )


def learner_of(
    kind: str, task: Any, steps: int, seed: int, teacher: str
) -> tuple[Learner, dict[str, Writer]]:
    """Return the learner of a kind, and the functions that write its files by suffix."""
    if kind == "ppo":
        ppo = make_learner(task, steps, seed)
        return ppo, {MODEL_SUFFIX: ppo.save_network, ".zip": ppo.save_model}
    if kind == "clone":
        clone = make_clone_learner(teacher, task, steps, seed)
        return clone, {MODEL_SUFFIX: clone.save_network}
    q = QLearner(task.make_env(), steps, seed)
    return q, {MODEL_SUFFIX: partial(save_table, q.table, task.layout)}


def make_learner(task: Task | FleetTask, steps: int, seed: int) -> PPOLearner:
    """Return a PPO learner for a task; if a library is missing, ``AgentError`` has the command."""
    with needed_libraries("training with PPO"):
        from agents.learning.ppo_training import ENVS, FOR_RANDOM_LAYOUTS, PPOLearner
    differs = FOR_RANDOM_LAYOUTS if isinstance(task.layout, RandomLayouts) else {}
    return PPOLearner(task.make_batch(ENVS), steps, seed, **differs)


@contextmanager
def needed_libraries(what: str) -> Iterator[None]:
    """Raise ``AgentError`` with the command to install a library if its import fails."""
    try:
        yield
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in LIBRARIES:
            raise
        raise AgentError(not_installed(f"{what} needs", error, "rl")) from error


def make_clone_learner(teacher: str, task: Task, steps: int, seed: int) -> CloneLearner:
    """Return a learner that imitates a teacher; see ``make_learner``."""
    from agents.learning.teachers import AgentTeacher, ShortestPaths

    make = partial(make_agent, teacher, seed)
    make(task.layout_for(0))  # a wrong name raises here, before the training
    with needed_libraries("training by imitation"):
        from agents.learning.clone_training import ENVS, CloneLearner
    batch = task.make_batch(ENVS)
    knows = teacher == KNOWS_THE_MAP
    return CloneLearner(
        batch, ShortestPaths(batch) if knows else AgentTeacher(batch, make), steps, seed
    )


@dataclass
class Progress:
    """State of a training: its exams, its steps and the seconds that it took so far."""

    examiner: Examiner
    steps: int = 0
    seconds: float = 0.0


@dataclass(frozen=True)
class Training:
    """A training with its progress bar, its files and the table of its result.

    The files are named after the agent's file, ``output``, with different suffixes.
    """

    name: str
    task: Task | FleetTask
    steps: int
    seed: int
    output: Path

    def run(self, learner: Learner, writers: Mapping[str, Writer], *, resume: bool) -> None:
        """Train an agent, write its files by suffix, and compare it with the greedy agent.

        An interrupt ends the training. If there has been an exam by then, the files are written
        nevertheless.

        Raises:
            OSError: a file cannot be written. This is checked before the training.
        """
        for suffix in (*writers, CURVE_SUFFIX, POINTS_SUFFIX, CHECKPOINT_SUFFIX):
            check_target(self.output.with_suffix(suffix))
        final = FINAL_SEEDS[:: self.task.seed_stride]
        greedy = greedy_scores(self.task, final)
        progress = Progress(Examiner(self.task, self.steps))
        if resume:
            progress = self._restored(learner) or progress
        with deferred_interrupts() as check:
            try:
                make_agent = self._train(learner, progress, check)
            except KeyboardInterrupt:
                if progress.examiner.points:
                    self._checkpoint(learner, progress)
                    self._save(progress, greedy, writers)
                    say("to continue, run the same command with --resume")
                raise
            self._save(progress, greedy, writers)
        scores = self.task.evaluate(make_agent, final)
        table = comparison_table({self.name: scores, "greedy": greedy})
        if isinstance(self.task.layout, RandomLayouts):
            table = table._replace(
                title=self.task.layout.name,
                caption=f"the same {len(final):,} layouts for both, none of them from the training",
            )
        print_table(table)

    @property
    def options(self) -> dict[str, Any]:
        """Everything that determines the result of a training, bit by bit."""
        layout, settings = self.task.layout, self.task._asdict()
        settings.pop("view_radius", None)  # always the default, which older checkpoints do not name
        return {
            "training": self.name,
            "steps": self.steps,
            "seed": self.seed,
            **settings,
            "layout": layout.rows if isinstance(layout, Layout) else repr(layout),
            **installed_versions(),
        }

    def _restored(self, learner: Learner) -> Progress | None:
        path = self.output.with_suffix(CHECKPOINT_SUFFIX)
        if not path.exists():
            say(f"{path} does not exist; the training starts from the beginning", error=True)
            return None
        progress: Progress = load_checkpoint(path, self.options, learner)
        say(f"resumed after {progress.steps:,} of {self.steps:,} steps")
        return progress

    def _checkpoint(self, learner: Learner, progress: Progress) -> None:
        path = self.output.with_suffix(CHECKPOINT_SUFFIX)
        save_checkpoint(path, self.options, learner, progress)

    def _train(self, learner: Learner, progress: Progress, check: CheckInterrupt) -> MakeAgent:
        """Train until the end, or until ``check`` raises; write a checkpoint at each exam."""
        from agents.lab.console.progress import progress_bar

        examiner, started = progress.examiner, time.perf_counter() - progress.seconds
        with progress_bar(self.steps, self.name) as show_progress:

            def watch(steps: int, delivers: float, make_agent: MakeAgent) -> None:
                is_examined = examiner.watch(steps, make_agent)
                progress.steps, progress.seconds = steps, time.perf_counter() - started
                show_progress(steps, f"delivers {known(delivers)}, exam {examiner.summary}")
                if is_examined:
                    save_points(self.output.with_suffix(POINTS_SUFFIX), examiner.points)
                    self._checkpoint(learner, progress)
                check()

            return learner.learn(watch)

    def _save(
        self, progress: Progress, greedy: Scores | FleetScores, writers: Mapping[str, Writer]
    ) -> None:
        points = progress.examiner.points
        of = "" if progress.steps >= self.steps else f" of {self.steps:,}"
        say(f"{progress.steps:,}{of} steps in {progress.seconds:.1f} s, seed {self.seed}")

        def draw(path: Path) -> None:
            from agents.lab.training.curve import save_learning_curve

            is_random = isinstance(self.task.layout, RandomLayouts)
            unseen = " in unseen layouts" if is_random else ""
            title = f"Learning to deliver{unseen}: {self.name}, seed {self.seed}"
            save_learning_curve(path, self.name, title, points, greedy)

        curves: dict[str, Writer] = {
            CURVE_SUFFIX: draw,
            POINTS_SUFFIX: partial(save_points, points=points),
        }
        for suffix, write in {**writers, **curves}.items():
            target = self.output.with_suffix(suffix)
            write(target)
            say(f"saved {target}")


def installed_versions() -> dict[str, str]:
    """Return the versions that affect the result of a training, by distribution."""
    from importlib.metadata import PackageNotFoundError, version  # takes long to import

    found = {}
    for name in VERSIONS:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def greedy_scores(task: Task | FleetTask, seeds: Iterable[int]) -> Scores | FleetScores:
    """Return the scores of the greedy agent, whose robots give way to one another in a fleet."""
    if isinstance(task, FleetTask):
        make = partial(make_team, "greedy", task.robots, layout=task.layout)
        return task.evaluate_fleet(make, seeds)
    return task.evaluate(GreedyAgent, seeds)


def comparison_table(scores: Mapping[str, Scores | FleetScores]) -> TextTable:
    """Return the table of the scores of agents on the same starts."""
    fleets = [one for one in scores.values() if isinstance(one, FleetScores)]
    if fleets:
        return TextTable(
            ("", *scores),
            [
                ("deliveries per hour", *(mean(one.per_hour, "") for one in fleets)),
                ("steps blocked by others", *(share(one.blocked) for one in fleets)),
            ],
            f"The same {len(fleets[0].rows):,} episodes of {fleets[0].robots} robots for all",
        )
    each = [one for one in scores.values() if isinstance(one, Scores)]
    by_all = np.all([one.delivered for one in each], axis=0)
    return TextTable(
        ("", *scores),
        [
            ("delivered", *(f"{one.delivered.mean():.1%}" for one in each)),
            ("steps to deliver", *(_mean_length(one, one.delivered) for one in each)),
            ("  if all deliver", *(_mean_length(one, by_all) for one in each)),
        ],
        f"The same {len(each[0].rows):,} random starts for all",
    )


def _mean_length(scores: Scores, among: NDArray[np.bool_]) -> str:
    return f"{scores.lengths[among].mean():.2f}" if among.any() else "none"
