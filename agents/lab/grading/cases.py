"""Cases of a rubric: episodes that an agent runs, or calls of a function."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import isclose
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from agents.lab.grading.child import as_tuples
from agents.lab.grading.sandbox import FAILS, AgentFailureError, Runner
from agents.lab.grading.slipping import SlippingGrid
from agents.lab.parameters import default_value
from agents.lab.place import RANDOM, Stations, default_stations, what_to_draw
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import (
    DEFAULT_LAYOUT,
    Cell,
    EpisodeRecorder,
    Layout,
    Observation,
    WarehouseEnv,
    random_layout,
)
from warehouse_core.records.episode import DELIVERED, Episode
from warehouse_core.records.failure_modes import diagnose, fewest_steps
from warehouse_core.wording import counted
from warehouse_core.world.actions import DROP, INVALID, PICK, action_index
from warehouse_core.world.named_layouts import DEFAULT, find_layout

EPISODE, CALL = "episode", "call"
"""Units of a case: it has episodes or calls."""

MAX_SHOWN = 300
"""Limit on the characters of a value in a report."""

TOLERANCE = 1e-6
"""Absolute and relative error that is allowed in a number."""


class Run(NamedTuple):
    """The outcome of one episode or of one call.

    Attributes:
        seed: seed of the episode, or number of the call.
        needed: fewest steps of a delivery; ``None`` if no path exists, and for a call.
        delivered: true if the episode ended with the delivery, or the call with the right answer.
        useless: number of actions that had no effect, except for waits.
        unknown: number of unknown actions.
        mode: the failure mode, or ``"delivered"``; ``"right"`` or ``"wrong"`` for a call.
        sentence: evidence for the mode, in words.
        failure: failure of the agent, or ``None``.
        where: step or call of the failure, in words; "" if the agent was not loaded.
        slowest: seconds of the slowest answer.
        agent: name of the class or function; "" if it was not loaded.
        episode: record of the episode; ``None`` if it has no steps or was not run, and for a call.
    """

    case: Case
    seed: int
    needed: int | None = None
    delivered: bool = False
    steps: int = 0
    useless: int = 0
    unknown: int = 0
    mode: str = ""
    sentence: str = ""
    failure: AgentFailureError | None = None
    where: str = ""
    slowest: float = 0.0
    agent: str = ""
    reward: float = 0.0
    episode: Episode | None = None

    @property
    def outcome(self) -> str:
        """Kind of the agent's failure if it failed, otherwise the mode."""
        return self.failure.kind if self.failure else self.mode

    @property
    def charged_steps(self) -> int:
        """Steps of a delivery; a failed episode counts as the step limit."""
        return self.steps if self.delivered else max(self.steps, self.case.full_length)

    @property
    def description(self) -> str:
        """Course of the episode in words; for a hidden case, only what students may know."""
        is_visible = self.case.visible
        if self.failure is not None:
            kind, text, public = self.failure.kind, self.failure.text, self.failure.public
            if is_visible:
                return f"{kind}{self.where}: {text}"
            return ": ".join(filter(None, (kind, public)))
        # In other episodes the mode already mentions useless actions.
        has_useless = self.delivered or self.needed is None
        counts = {"useless action": self.useless * has_useless, "unknown action": self.unknown}
        also = "".join(f"; {counted(count, noun)}" for noun, count in counts.items() if count)
        is_plain = self.delivered or self.case.unit == CALL
        mode = [] if is_plain and is_visible else [self.mode]
        return ": ".join([*mode, self.sentence] if is_visible else mode) + also


@dataclass(frozen=True, slots=True)
class GradedCase:
    """Episodes that differ only in their seeds, as defined by a table of a rubric.

    Attributes:
        layout: name of a layout, path of a file, or ``RANDOM``.
        size: height and width of random layouts.
        density: share of walls in random layouts.
        stations: source of pickup and dropoff; ``None`` is the default of ``warehouse run``.
        start: start cell, or ``None`` for a random one.
        visible: true if the report may show seeds and what happened.
        slip: probability that a move goes to a side, see ``SlippingGrid``.
    """

    name: str
    layout: str = DEFAULT
    size: tuple[int, int] = (7, 12)
    density: float = default_value("density")
    first_seed: int = 1
    episodes: int = 10
    stations: Stations | None = None
    start: Cell | None = None
    battery: int = default_value("battery")
    max_steps: int = default_value("max_steps")
    view_radius: int = default_value("view_radius")
    visible: bool = True
    slip: float = 0.0

    unit: ClassVar[str] = EPISODE

    @property
    def files(self) -> list[Path]:
        """File of the layout, or an empty list."""
        path = Path(self.layout)
        return [path] if path.is_absolute() else []

    @property
    def seeds(self) -> range:
        """Seeds of the episodes."""
        return range(self.first_seed, self.first_seed + self.episodes)

    @property
    def full_length(self) -> int:
        """Step limit of an episode in which the robot does not charge its battery."""
        return min(self.max_steps, self.battery)

    def layout_of(self, seed: int) -> Layout:
        """Return the layout of an episode, before stations are drawn at random."""
        if self.layout == RANDOM:
            return random_layout(*self.size, self.density, seed)
        return DEFAULT_LAYOUT if self.layout == DEFAULT else find_layout(self.layout)

    def stations_of(self, layout: Layout) -> Stations:
        """Return the source of pickup and dropoff in a layout of the case."""
        return self.stations or default_stations(layout, is_default=layout is DEFAULT_LAYOUT)

    def begin(
        self, seed: int, layout: Layout | None = None, stations: Stations | None = None
    ) -> tuple[WarehouseEnv, Observation]:
        """Return the environment of an episode, in a given layout if any, and its observation."""
        layout = layout or self.layout_of(seed)
        limits = self.max_steps, self.battery, self.view_radius
        backend = SlippingGrid(self.slip) if self.slip else "grid"
        env = WarehouseEnv(layout, self.start, *limits, backend=backend)
        drawn = what_to_draw(stations or self.stations_of(layout), self.start)
        return env, env.reset(drawn, seed)

    def run(self, runner: Runner, seed: int) -> Run:
        """Run one episode.

        The agent receives the seed of the episode, as in ``warehouse run``. If the seed is hidden,
        the agent receives the number of the episode instead, because it could derive the layout
        from the seed.
        """
        failure, (env, observation) = None, self.begin(seed)
        recorder, needed = EpisodeRecorder(env, seed=seed), _needed_steps(env)
        try:
            with runner.episode() as agent:
                agent.start(seed if self.visible else seed - self.first_seed)
                while not recorder.ended:
                    observation = recorder.step(agent.act(observation))
        except AgentFailureError as error:
            failure = error
        episode = recorder.episode
        diagnosis, counts = diagnose(episode), count_useless(episode)
        return Run(
            self, seed, needed, episode.outcome == DELIVERED, episode.steps,
            sum(counts.values()), counts[INVALID], diagnosis.mode, diagnosis.sentence, failure,
            where=f" at step {episode.steps + 1}" if agent.name else "",
            slowest=agent.slowest, agent=agent.name, reward=episode.total_reward,
            episode=episode if episode.steps else None,
        )  # fmt: skip

    def needed_steps(self, seed: int) -> int | None:
        """Return the fewest steps of a delivery in an episode; ``None`` if no path exists."""
        return _needed_steps(self.begin(seed)[0])

    @lru_cache(maxsize=100_000)  # noqa: B019 (cases live as long as their rubric)
    def greedy_steps(self, seed: int) -> int:
        """Return the steps of the greedy agent in an episode; it may use all steps of the limit."""
        recorder = EpisodeRecorder(self.begin(seed)[0], seed=seed)
        recorder.run(GreedyAgent(seed))
        return recorder.episode.steps

    def command(self, agent: str, seed: int) -> str:
        """Return the command that runs an episode again."""
        words, before = ["warehouse", "run", "--agent", agent, "--seed", str(seed)], ""
        if self.layout == RANDOM:
            file = f"{self.name}-{seed}.txt"
            height, width = self.size
            made = f"random:height={height},width={width},density={self.density:g},seed={seed}"
            before = f"warehouse layout {made} --save {shlex.quote(file)} && "
            words += ["--layout", file]
        elif self.layout != DEFAULT:
            path, here = Path(self.layout), Path.cwd()
            is_below = path.is_relative_to(here)
            words += ["--layout", str(path.relative_to(here)) if is_below else self.layout]
        words += ["--stations", str(self.stations)] if self.stations else []
        words += ["--start", "{},{}".format(*self.start)] if self.start else []
        for name in ("battery", "max_steps", "view_radius"):
            if getattr(self, name) != default_value(name):
                words += [f"--{name.replace('_', '-')}", str(getattr(self, name))]
        if self.slip:
            kind = f"{SlippingGrid.__module__}:{SlippingGrid.__name__}"
            words += ["--backend", f"{kind}:chance={self.slip:g}"]
        return before + shlex.join(words)


class Call(NamedTuple):
    """The arguments of a call and the right answer, as JSON values."""

    arguments: Sequence[Any]
    answer: Any


@dataclass(frozen=True, slots=True)
class CallCase:
    """Calls of a function of a submission, as defined by a table of a rubric.

    A call has no steps, no files and no command that repeats it.

    Attributes:
        function: name of the function, or of a dictionary in which the arguments are looked up.
        visible: true if the report may show the calls and the agent's answers.
    """

    name: str
    function: str
    calls: tuple[Call, ...]
    visible: bool = True

    unit: ClassVar[str] = CALL
    full_length: ClassVar[int] = 0
    files: ClassVar[Sequence[Path]] = ()

    @property
    def seeds(self) -> range:
        """Numbers of the calls."""
        return range(self.episodes)

    @property
    def episodes(self) -> int:
        """Number of calls."""
        return len(self.calls)

    def needed_steps(self, number: int) -> None:
        """Return ``None``, as for an episode in which delivery is impossible."""

    def command(self, agent: str, number: int) -> str:
        """Return "", because no command repeats a call."""
        return ""

    def run(self, runner: Runner, number: int) -> Run:
        """Run one call in a process of its own, like an episode."""
        call, failure, answer = self.calls[number], None, None
        try:
            with runner.episode() as agent:
                agent.start(number, self.function)
                answer = agent.call(call.arguments)
        except AgentFailureError as error:
            failure = error
        shown = f"{self.function}({', '.join(_shown(as_tuples(each)) for each in call.arguments)})"
        right = failure is None and is_right(answer, call.answer)
        # The right answer is never shown, as a script could copy it into the next submission.
        sentence = "" if right else f"{shown} is {_shown(answer)}, which is not the right answer"
        return Run(
            self, number, None, right, mode="right" if right else "wrong", sentence=sentence,
            failure=failure, where=f" in {shown}" if agent.name else "",
            slowest=agent.slowest, agent=agent.name,
        )  # fmt: skip


Case = GradedCase | CallCase
"""A case of a rubric: episodes, or calls of a function."""


def run_cases(
    runner: Runner, cases: Iterable[Case], give_up_after: int, advance: Callable[[], None]
) -> list[Run]:
    """Run the episodes and calls of all cases, and return a run for each seed of each case.

    After ``give_up_after`` successive episodes that are too slow, end the process or cannot be
    loaded, the rest of a case is not run and counts the same. ``advance`` is called after each.
    """
    runs, hopeless = list[Run](), 0
    for case in cases:
        if runs and runs[-1].agent:  # the agent was loaded, so it may succeed in another case
            hopeless = 0
        for seed in case.seeds:
            if hopeless < give_up_after:
                run = case.run(runner, seed)
            else:
                needed = case.needed_steps(seed)
                run = runs[-1]._replace(case=case, seed=seed, needed=needed, episode=None)
            is_hopeless = run.failure is not None and run.failure.kind != FAILS
            hopeless = hopeless + 1 if is_hopeless else 0
            runs.append(run)
            advance()
    return runs


def count_useless(episode: Episode) -> Counter[int]:
    """Return for each action index how many actions had no effect, except for waits."""
    found: Counter[int] = Counter()
    loaded = zip(episode.loaded, episode.loaded[1:], strict=False)
    delivered = len(episode.actions) - 1 if episode.terminated else None
    for step, (before, after) in enumerate(loaded):
        index = action_index(episode.actions[step])
        is_idle = index in (PICK, DROP) and before == after and step != delivered
        found[index] += is_idle or episode.motions[step].blocked or index == INVALID
    return found


def is_right(answer: object, wanted: object) -> bool:
    """Return whether an answer is the right one; numbers may differ by ``TOLERANCE``."""
    if isinstance(answer, bool) or isinstance(wanted, bool):
        return answer is wanted
    if isinstance(answer, int | float) and isinstance(wanted, int | float):
        try:
            return isclose(answer, wanted, rel_tol=TOLERANCE, abs_tol=TOLERANCE)
        except OverflowError:  # an int that is too large for a float
            return answer == wanted
    if isinstance(answer, list) and isinstance(wanted, list):
        return len(answer) == len(wanted) and all(map(is_right, answer, wanted))
    if isinstance(answer, dict) and isinstance(wanted, dict):
        same = answer.keys() == wanted.keys()
        return same and all(is_right(answer[key], wanted[key]) for key in answer)
    return answer == wanted


def _needed_steps(env: WarehouseEnv) -> int | None:
    return fewest_steps(env.layout, (env.state.robot_pos, False))[0]


def _shown(value: object) -> str:
    """Return a value as Python code, truncated if it is long."""
    text = repr(value)
    return text if len(text) <= MAX_SHOWN else f"{text[:MAX_SHOWN]}..."
