"""Whether agents may be graded here: what this system keeps from them, and what must be trusted."""

from __future__ import annotations

import os
import sys

from agents.errors import GradeError
from agents.lab.grading import walls
from agents.lab.grading.walls import FILES, PROCESSES

DEEDS = {
    FILES: "read files that are neither theirs nor Python's, or write any",
    PROCESSES: "reach other processes or the network",
}
"""The deeds of agents that each wall prevents, in words."""


def check_trust(user: str | None, is_trusted: bool, are_many: bool) -> str:
    """Return what agents cannot do here, and what they can, in words.

    Args:
        user: user that runs the agents, or ``None`` for the one that grades.
        is_trusted: promise that the agents do no harm.
        are_many: true for a folder of agents, false for one agent.

    Raises:
        GradeError: root would run agents that are not trusted, or nothing keeps the agents of a
            class from the files of others.
    """
    kept = walls.held()
    prevented = [deed for wall, deed in DEEDS.items() if wall in kept]
    possible = [deed for wall, deed in DEEDS.items() if wall not in kept]
    if not is_trusted and user is None:
        if sys.platform != "win32" and os.getuid() == 0:
            raise GradeError(
                "root does not run agents with its own rights: choose a user without any, such as "
                "--user nobody, or --trust the agents"
            )
        if are_many and possible:
            raise GradeError(
                f"on this system agents can {', and '.join(possible)}: grade them as root with a "
                "--user without rights, such as nobody, or --trust them"
            )
    told = f"agents cannot {', nor '.join(prevented)}" if prevented else ""
    also = f"agents can {', and '.join(possible)}" if possible else ""
    return "; ".join(filter(None, (told, also)))


def most_jobs(user: str | None, jobs: int) -> int:
    """Return how many agents may run at once: of one user only one, if it could reach others."""
    return 1 if user is not None and PROCESSES not in walls.held() else jobs
