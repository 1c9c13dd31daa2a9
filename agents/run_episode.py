"""Run one episode from a random start, print its outcome and replay it.

``warehouse run``, ``python agents/run_episode.py`` and ``python -m agents.run_episode`` are the
same command.
"""

from __future__ import annotations

from agents.lab.commands.run import run, run_episode
from agents.lab.console.main import application, help_of, main

__all__ = ["run_episode"]

if __name__ == "__main__":
    app = application()
    app.command(help=help_of(run))(run)
    main(app)
