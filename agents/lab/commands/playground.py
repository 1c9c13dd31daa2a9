"""The command ``warehouse playground``: a page on which agents are written, run and graded."""

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
        option("--save -o FOLDER", f"{SAVE} Here: the folder of the page, made if it is missing."),
    ] = Path("playground"),
    pyodide: Annotated[
        str,
        option(
            "--pyodide PLACE",
            f"Folder or address of the files of Pyodide {VERSION}.",
        ),
    ] = SERVER,
) -> None:
    """Write a page that runs agents in browsers.

    On it agents are written, run, step by step if need be, and graded.
    Nothing has to be installed where it is read: Python runs in the browser.
    The folder needs a server, but no network. Try it with
    python -m http.server -d playground

    Example: warehouse playground -o page/
    """
    from agents.lab.console.progress import progress_bar  # Rich takes long to import

    done = count(1)
    with progress_bar(len(FILES), "files") as show:
        write_playground(save, pyodide, lambda: show(next(done)))
    say(f"saved {save}; to open it: python -m http.server -d {shlex.quote(str(save))}")
