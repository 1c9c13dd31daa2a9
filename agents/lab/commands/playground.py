"""The command ``warehouse playground``: a page for writing, running and grading agents."""

from __future__ import annotations

import shlex
from itertools import count
from pathlib import Path
from typing import Annotated

from agents.lab.console.options import SAVE, option
from agents.lab.console.terminal import say
from agents.lab.playground.page import write_playground
from agents.lab.playground.runtime import FILES, SERVER, VERSION


def playground(
    save: Annotated[
        Path,
        option("--save -o FOLDER", f"{SAVE} Here: a folder, created if it is missing."),
    ] = Path("playground"),
    pyodide: Annotated[
        str,
        option(
            "--pyodide PLACE",
            f"Folder or address of Pyodide {VERSION}, which runs Python in browsers.",
        ),
    ] = SERVER,
) -> None:
    """Write a web page that runs agents.

    On this page, students write agents, run them, step through episodes and
    grade them. They install nothing, because Python runs in the browser. The
    folder needs a web server, but no network. To try it:
    python -m http.server -d playground

    Example: warehouse playground -o page/
    """
    from agents.lab.console.progress import progress_bar  # Rich takes long to import

    done = count(1)
    with progress_bar(len(FILES), "files") as show:
        write_playground(save, pyodide, lambda: show(next(done)))
    say(f"saved {save}; to open it: python -m http.server -d {shlex.quote(str(save))}")
