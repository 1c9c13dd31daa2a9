"""Example episodes of a report: one for each outcome in the results, run again as a replay."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.lab.experiments.case import Case, check_fingerprint, failure_of, run_one
from agents.lab.reports.results import Experiment
from agents.registry import is_own_code
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Track

MAX_STEPS, MAX_PHYSICS_STEPS = 10_000, 1_000
"""Maximum length of an episode that is run again, on the grid and with physics."""


class Example(NamedTuple):
    """An episode in the results, which is one of ``episodes`` episodes with the same outcome.

    Attributes:
        sentence: Evidence for its outcome, or the reason why there is no track; "" before it has
            been run again.
        track: Track of the replay, if there is one.
    """

    mode: str
    case: Case
    seed: int
    steps: int
    episodes: int
    sentence: str = ""
    track: Track | None = None


def find_examples(experiment: Experiment) -> list[Example]:
    """Return the shortest episode with each outcome that occurs, in the order of ``MODES``.

    Among episodes of equal length, the first case and then the smallest seed is chosen.
    """
    everything = experiment.results(*experiment.cases)
    case_ids, seeds, steps = (everything.columns[name] for name in ("case", "seed", "steps"))
    found = []
    for mode, episodes in everything.modes.items():
        having = np.flatnonzero(everything.columns["mode"] == mode)
        first = having[steps[having].argmin()]
        case = experiment.cases[int(case_ids[first])]
        found.append(Example(mode, case, int(seeds[first]), int(steps[first]), episodes))
    return found


def replay(found: Example, *, run_own_code: bool) -> Example:
    """Run an episode again, and return it with its replay or the reason why there is none.

    Agents and libraries may have changed since the results were written. Whatever a user's agent
    raises becomes the reason. Users' agents run only with ``run_own_code``, because the results
    name them and may come from a stranger.
    """
    if is_own_code(found.case["agent"]) and not run_own_code:
        reason = "Its agent is not part of this program. Run its code with --replays."
        return found._replace(sentence=reason)
    limit = MAX_STEPS if found.case["backend"] == "grid" else MAX_PHYSICS_STEPS
    if found.steps > limit:
        reason = f"It is not run again: it has {found.steps:,} steps, and the limit is {limit:,}."
        return found._replace(sentence=reason)
    # It may now take longer than in the results.
    case = {**found.case, "max_steps": min(found.case["max_steps"], found.steps + 1)}
    try:
        check_fingerprint(case)
        episode = run_one(case, found.seed)
    except (Exception, SystemExit) as error:
        why = " ".join(failure_of(error, found.case).split()).rstrip(".")
        return found._replace(sentence=f"It cannot be run again: {why}.")
    diagnosis = diagnose(episode)
    if (diagnosis.mode, episode.steps) == (found.mode, found.steps):
        return found._replace(sentence=diagnosis.sentence, track=track_of_record(episode))
    reason = (
        f"Its outcome is different now: {diagnosis.mode} after {episode.steps} steps, not "
        f"{found.mode} after {found.steps} steps. The agent or a library has changed since the "
        "results were written."
    )
    return found._replace(sentence=reason)
