"""One example of each failure mode in the results, and of a delivery, run again to be watched."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from agents.errors import AgentError, EpisodeError, reason_of
from agents.experiments.case import Case
from agents.experiments.episodes import check_fingerprint, run_one
from agents.experiments.store import Store
from agents.registry import agent_file, is_own_code
from warehouse_core import BackendError, Episode, LayoutError
from warehouse_core.records.failure_modes import MODES, Diagnosis, diagnose
from warehouse_core.viz.replay import replay_of_track
from warehouse_core.viz.track import INTERVAL_MS, track_of_episode

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
"""Both inner searches go along the table as it is kept, and end with the first row they find."""

MOST_STEPS = 200
"""That are shown; of a longer episode the last ones."""

PLAY_MS = 12_000
"""A replay takes no longer, however many steps it has."""


SAYING_ENOUGH = (AgentError, BackendError, EpisodeError, LayoutError, OSError)
"""Errors of this project, or with the name of a file."""


@dataclass(frozen=True, slots=True)
class Found:
    """An episode in the results that stands for its failure mode.

    Attributes:
        mode: what became of it.
        case_id: of its case in the results.
        case: its settings.
        seed: of the episode.
        steps: its length.
        episodes: how many of that mode there are in all.
    """

    mode: str
    case_id: int
    case: Case
    seed: int
    steps: int
    episodes: int


@dataclass(frozen=True, slots=True)
class Example:
    """An episode to be watched.

    Attributes:
        found: which one.
        sentence: the evidence for its failure mode, or why there is no picture.
        gif: the replay; empty if there is none.
    """

    found: Found
    sentence: str
    gif: bytes


def find_examples(store: Store) -> list[Found]:
    """Return for each mode that occurs its shortest episode, in the order of ``MODES``.

    Of equally short ones it is that of the first case, then that of the smallest seed.
    """
    cases = store.cases()
    found = {
        mode: Found(mode, case_id, cases[case_id], seed, steps, episodes)
        for mode, case_id, steps, episodes, seed in store.query(SHORTEST)
    }
    return [found[mode] for mode in MODES if mode in found]


def replay(found: Found, *, run_own_code: bool) -> Example:
    """Run an episode again and return its replay, or the reason why there is none.

    What agents and libraries do may have changed since the results were written. An agent is
    anybody's code, so that whatever it raises becomes a sentence.

    Args:
        found: which episode.
        run_own_code: run agents that are a class of somebody's own. The results name them, and
            may come from a stranger.
    """
    if is_own_code(found.case["agent"]) and not run_own_code:
        return Example(found, "Its agent is no part of this program; --replays runs it.", b"")
    try:
        check_fingerprint(found.case)
        episode = run_one(found.case, found.seed)
    except (Exception, SystemExit) as error:
        return Example(found, f"It cannot be run again: {_why(error, found.case)}.", b"")
    diagnosis = diagnose(episode)
    if (diagnosis.mode, episode.steps) != (found.mode, found.steps):
        return Example(found, _changed(found, diagnosis, episode.steps), b"")
    left_out = max(episode.steps - MOST_STEPS, 0)
    only = f"; the replay shows the last {MOST_STEPS} of {episode.steps} steps" if left_out else ""
    return Example(found, f"{diagnosis.sentence}{only}", _gif(episode, left_out))


def _changed(found: Found, diagnosis: Diagnosis, steps: int) -> str:
    return (
        f"It comes out differently now: {diagnosis.mode} after {steps} steps, not {found.mode} "
        f"after {found.steps}. The agent or a library has changed since the results were written."
    )


def _gif(episode: Episode, left_out: int) -> bytes:
    """Return the replay of an episode without its first steps, as a GIF of one frame a step."""
    track = track_of_episode(episode, frame_seconds=None)
    interval = min(INTERVAL_MS, PLAY_MS / (len(track) - left_out))
    film = replay_of_track(track, interval_ms=interval, window=False, first_frame=left_out)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "replay.gif"
        film.save(path)
        return path.read_bytes()


def _why(error: BaseException, case: Case) -> str:
    """Return what an error says on one line, with its name and place if it is not of ours."""
    is_ours = isinstance(error, SAYING_ENOUGH)
    words = str(error) if is_ours else reason_of(error, agent_file(case["agent"]))
    return " ".join(words.split()).rstrip(".")
