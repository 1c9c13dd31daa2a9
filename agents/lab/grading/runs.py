"""The episodes of an agent that is graded: each in a process of its own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import closing
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from agents.lab.grading.calls import CallCase, is_right
from agents.lab.grading.cases import GradedCase, needed_steps
from agents.lab.grading.same_process import SameProcess
from agents.lab.grading.sandbox import FAILS, AgentFailureError, AgentLimits, Sandbox
from agents.lab.grading.submissions import Submission
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import EpisodeRecorder
from warehouse_core.records.episode import DELIVERED, Action, Episode
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.wording import counted
from warehouse_core.world.actions import DROP, INVALID, PICK, action_index

Runner = Sandbox | SameProcess
"""Runs the agents of a submission, each in an episode of its own."""

MakeRunner = Callable[[Submission, AgentLimits, str | None, Iterable[Path]], Runner]
"""Returns what runs a submission: its limits, its user, and files kept from it; see ``Sandbox``."""


class Run(NamedTuple):
    """The outcome of one episode.

    Attributes:
        needed: the fewest steps of a delivery, ``None`` without a way.
        useless: actions that had no effect, waits not counted.
        unknown: unknown actions.
        mode: the failure mode, or ``"delivered"``; the sentence is the evidence for it. A call is
            ``"right"`` or ``"wrong"``, and the sentence tells it.
        step: step at which the agent failed; 0 is before the first.
        slowest: seconds of the slowest answer.
        agent: the name of its class or function, if it was loaded.
        actions: its actions; none if the episode was not run, and of a call.
        reward: sum of the rewards.
        is_right: the answer of a call was the right one.
    """

    case: GradedCase | CallCase
    seed: int
    needed: int | None
    delivered: bool = False
    steps: int = 0
    useless: int = 0
    unknown: int = 0
    mode: str = ""
    sentence: str = ""
    failure: AgentFailureError | None = None
    step: int = 0
    slowest: float = 0.0
    agent: str = ""
    actions: tuple[Action, ...] = ()
    reward: float = 0.0
    is_right: bool = False

    @property
    def outcome(self) -> str:
        """The failure of the agent, or the failure mode of the episode."""
        return self.failure.kind if self.failure else self.mode

    @property
    def charged_steps(self) -> int:
        """The steps of a delivery, or else all that the episode may have."""
        if self.delivered or isinstance(self.case, CallCase):
            return self.steps
        return max(self.steps, full_length(self.case))

    @property
    def told(self) -> str:
        """The course of the episode in words, as far as the case may be told."""
        if self.failure is None:
            is_told = self.delivered or self.needed is None  # the mode tells it in other episodes
            counts = {"useless action": self.useless * is_told,
                      "unknown action": self.unknown}  # fmt: skip
            also = (f"; {counted(count, noun)}" for noun, count in counts.items() if count)
            is_plain = self.delivered or isinstance(self.case, CallCase)
            told = [] if is_plain and self.case.visible else [self.mode]
            told += [self.sentence] if self.case.visible else []
            return f"{': '.join(told)}{''.join(also)}"
        if not self.case.visible:
            return ": ".join(filter(None, (self.failure.kind, self.failure.public)))
        where = f" at step {self.step}" if self.step else ""
        if self.agent and isinstance(self.case, CallCase):
            where = f" in {self.sentence}"
        return f"{self.failure.kind}{where}: {self.failure.text}"


def run_cases(
    submission: Submission,
    cases: Iterable[GradedCase | CallCase],
    limits: AgentLimits,
    user: str | None,
    secrets: Iterable[Path],
    advance: Callable[[], None],
    make_runner: MakeRunner,
) -> list[Run]:
    """Run all episodes of cases, with each of their seeds; ``advance`` is called after each."""
    runs, hopeless = list[Run](), 0
    with make_runner(submission, limits, user, secrets) as sandbox:
        for case in cases:
            if runs and runs[-1].agent:  # it was loaded, so another case may be another matter
                hopeless = 0
            for seed in case.seeds:
                if hopeless < limits.give_up_after:
                    run = run_of(sandbox, submission, case, seed)
                else:
                    run = _unrun(runs[-1], case, seed)
                is_hopeless = run.failure is not None and run.failure.kind != FAILS
                hopeless = hopeless + 1 if is_hopeless else 0
                runs.append(run)
                advance()
    return runs


def _unrun(last: Run, case: GradedCase | CallCase, seed: int) -> Run:
    """Return the outcome of an episode that is not run, because it would end like the last one."""
    if isinstance(case, CallCase):
        return last._replace(case=case, seed=seed, needed=None, actions=())
    env, _ = case.begin(seed)
    with closing(env):
        return last._replace(case=case, seed=seed, needed=needed_steps(env), actions=())


def run_of(sandbox: Runner, submission: Submission, case: GradedCase | CallCase, seed: int) -> Run:
    """Run one episode, or one call."""
    if isinstance(case, CallCase):
        return run_call(sandbox, submission, case, seed)
    return run_case(sandbox, submission, case, seed)


def run_call(sandbox: Runner, submission: Submission, case: CallCase, number: int) -> Run:
    """Run one call, in a process of its own as an episode."""
    run, call = Run(case, number, None), case.calls[number]
    try:
        with sandbox.episode() as agent:
            try:
                agent.start(submission, number, case.function)
                answer = agent.call(call.arguments)
            finally:
                run = run._replace(agent=agent.name, slowest=agent.slowest)
    except AgentFailureError as failure:
        return run._replace(failure=failure, sentence=case.shown(number))
    if is_right(answer, call.answer):
        return run._replace(is_right=True, mode="right")
    return run._replace(mode="wrong", sentence=case.told(number, answer))


def run_case(sandbox: Runner, submission: Submission, case: GradedCase, seed: int) -> Run:
    """Run one episode."""
    env, observation = case.begin(seed)
    with closing(env):
        recorder = EpisodeRecorder(env, seed=seed)
        run = Run(case, seed, needed_steps(env))
        try:
            with sandbox.episode() as agent:
                try:
                    agent.start(submission, case.agent_seed(seed))
                    while not recorder.ended:
                        observation = recorder.step(agent.act(observation))
                finally:
                    run = run._replace(agent=agent.name, slowest=agent.slowest)
        except AgentFailureError as failure:
            step = recorder.episode.steps + 1 if run.agent else 0
            run = run._replace(failure=failure, step=step)
    episode = recorder.episode
    diagnosis, counts = diagnose(episode), _count_useless(episode)
    return run._replace(
        delivered=episode.outcome == DELIVERED,
        steps=episode.steps,
        useless=sum(counts.values()),
        unknown=counts[INVALID],
        mode=diagnosis.mode,
        sentence=diagnosis.sentence,
        actions=tuple(episode.actions),
        reward=episode.total_reward,
    )


def episode_of(run: Run) -> Episode:
    """Return the record of an episode, made by its actions without its agent."""
    assert isinstance(run.case, GradedCase), "a call has no episode"
    env, _ = run.case.begin(run.seed)
    with closing(env):
        recorder = EpisodeRecorder(env, seed=run.seed)
        for action in run.actions:
            recorder.step(action)
    return recorder.episode


def _count_useless(episode: Episode) -> Counter[int]:
    """Return by their index how many actions had no effect, waits not counted."""
    found: Counter[int] = Counter()
    loaded = zip(episode.loaded, episode.loaded[1:], strict=False)
    delivered = len(episode.actions) - 1 if episode.terminated else None
    for step, (before, after) in enumerate(loaded):
        index = action_index(episode.actions[step])
        is_idle = index in (PICK, DROP) and before == after and step != delivered
        found[index] += is_idle or episode.motions[step].blocked or index == INVALID
    return found


@lru_cache(maxsize=100_000)
def greedy_steps(case: GradedCase, seed: int) -> int:
    """Return the steps of the greedy agent in an episode; it takes all that it may have."""
    env, _ = case.begin(seed)
    with closing(env):
        recorder = EpisodeRecorder(env, seed=seed)
        recorder.run(GreedyAgent(seed))
    return recorder.episode.steps


def full_length(case: GradedCase) -> int:
    """Return the steps of an episode without a delivery, unless it charges its battery."""
    return min(case.max_steps, case.battery)
