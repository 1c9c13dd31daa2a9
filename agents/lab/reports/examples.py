"""One example of each failure mode in the results, and of a delivery, run again as a replay."""

from __future__ import annotations

from dataclasses import dataclass

from agents.errors import AgentError, EpisodeError, reason_of
from agents.lab.experiments.case import Case, cause_of, cells_of, check_fingerprint, run_one
from agents.lab.experiments.store import Store
from agents.lab.reports.figures import MAX_CELLS
from agents.registry import agent_file, is_own_code
from warehouse_core import BackendError, LayoutError
from warehouse_core.records.failure_modes import MODES, diagnose
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Track

SHORTEST = """
WITH best AS (SELECT mode, count(*) AS episodes, min(steps) AS steps FROM episodes GROUP BY mode),
first AS (
    SELECT *, (
        SELECT case_id FROM episodes
        WHERE episodes.mode = best.mode AND episodes.steps = best.steps
        ORDER BY case_id LIMIT 1
    ) AS case_id FROM best
)
SELECT mode, case_id, steps, episodes, (
    SELECT seed FROM episodes
    WHERE episodes.case_id = first.case_id
        AND episodes.mode = first.mode AND episodes.steps = first.steps
    ORDER BY seed LIMIT 1
) FROM first
"""
"""Both inner queries follow the order of the table and end with the first row they find."""

MAX_STEPS, MAX_PHYSICS_STEPS = 10_000, 1_000
"""Steps of an episode that is run again, at most, on the grid and with physics."""

CLEAR_ERRORS = (AgentError, BackendError, EpisodeError, LayoutError, OSError)
"""Errors whose message is enough; of others the class and the place are shown too."""


@dataclass(frozen=True, slots=True)
class FoundEpisode:
    """An episode in the results, one of several ``episodes`` of its failure mode."""

    mode: str
    case: Case
    seed: int
    steps: int
    episodes: int


@dataclass(frozen=True, slots=True)
class Example:
    """A replay; the sentence is the evidence for its mode, or says why there is no track."""

    found: FoundEpisode
    sentence: str
    track: Track | None = None


def find_examples(store: Store) -> list[FoundEpisode]:
    """Return for each mode that occurs its shortest episode, in the order of ``MODES``.

    Ties go to the first case, then to the smallest seed.
    """
    store.check_rows()
    cases = store.cases()
    found = {
        mode: FoundEpisode(mode, cases[case_id], seed, steps, episodes)
        for mode, case_id, steps, episodes, seed in store.query(SHORTEST)
    }
    return [found[mode] for mode in MODES if mode in found]


def replay(found: FoundEpisode, *, run_own_code: bool) -> Example:
    """Run an episode again and return its replay, or the reason why there is none.

    Agents and libraries may have changed since the results were written. User agents may raise
    anything, which becomes the reason; they are run only if ``run_own_code``, because the results
    name them, and may come from a stranger.
    """
    if is_own_code(found.case["agent"]) and not run_own_code:
        return Example(found, "Its agent is not part of this program; --replays runs it.")
    if (why := _too_much(found)) is not None:
        return Example(found, f"It is not run again: {why}.")
    # It may go on for longer than the results say.
    case = {**found.case, "max_steps": min(found.case["max_steps"], found.steps + 1)}
    try:
        check_fingerprint(case)
        episode = run_one(case, found.seed)
    except (Exception, SystemExit) as error:
        cause = cause_of(error)
        is_clear = isinstance(cause, CLEAR_ERRORS)
        words = str(cause) if is_clear else reason_of(cause, agent_file(found.case["agent"]))
        why = " ".join(words.split()).rstrip(".")
        return Example(found, f"It cannot be run again: {why}.")
    diagnosis = diagnose(episode)
    if (diagnosis.mode, episode.steps) != (found.mode, found.steps):
        now = f"{diagnosis.mode} after {episode.steps} steps"
        if episode.steps > found.steps:
            now = f"it has not ended after {found.steps} steps"
        sentence = (
            f"Its outcome is different now: {now}, not "
            f"{found.mode} after {found.steps}. The agent or a library has changed since the "
            "results were written."
        )
        return Example(found, sentence)
    return Example(found, diagnosis.sentence, track_of_record(episode))


def _too_much(found: FoundEpisode) -> str | None:
    """Return why an episode is too much work to be run again, ``None`` if it is not.

    What limits it are numbers in the results, which may come from a stranger.
    """
    cells = cells_of(found.case)
    if cells > MAX_CELLS:
        return f"its map has {cells:,} cells, and at most {MAX_CELLS:,} are"
    limit = MAX_STEPS if found.case["backend"] == "grid" else MAX_PHYSICS_STEPS
    return (
        f"it has {found.steps:,} steps, and at most {limit:,} are" if found.steps > limit else None
    )
