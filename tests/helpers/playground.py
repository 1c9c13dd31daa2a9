"""The page of the playground in a headless Chromium."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from agents.lab.playground.page import RUNTIME, write_playground
from helpers.command_line import ROOT

FILES = ROOT / ".venv" / "pyodide"
"""Folder of Pyodide's files, which ``.ci/pyodide`` fetches."""

MAX_DOWNLOAD = 25_000_000
"""Largest number of bytes that the page may load."""

SECONDS = 120

PLAIN = os.environ | {"WAREHOUSE_FAST": "0"}
"""Environment variables with which planners are not compiled, as in a browser."""


def write_page(folder: Path) -> Path:
    """Write the playground into a folder, and return it."""
    assert FILES.is_dir(), f"{FILES} is missing; .ci/pyodide fetches it"
    write_playground(folder, str(FILES))
    return folder


def run_by_cpython(script: Path) -> str:
    """Return the output of a script in its folder, with planners that are not compiled."""
    words = [sys.executable, script]
    return subprocess.run(
        words, capture_output=True, text=True, env=PLAIN, check=True, cwd=script.parent
    ).stdout


def run_in_node(page: Path, script: Path) -> str:
    """Return the output of a script that Pyodide runs in node, with the wheel of a page."""
    [wheel] = page.glob("*.whl")
    words = ["node", ROOT / "tests/helpers/pyodide.mjs", page / RUNTIME, script, wheel]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


class Playground:
    """The page in a browser, with its errors and its requests."""

    def __init__(self, page: Any, address: str) -> None:
        self.page, self.errors, self.requests = page, list[str](), list[str]()
        self.size = 0
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", lambda message: self.errors.append(message.text))
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("response", self._count)
        page.goto(address)
        self.until(lambda: page.is_enabled("[data-do=run]"))

    def _count(self, response: Any) -> None:
        self.size += int(response.headers.get("content-length", 0))

    def until(self, is_so: Callable[[], Any]) -> None:
        """Wait until a condition is true; the policy of the page forbids its evaluation there."""
        end = monotonic() + SECONDS
        while not is_so():
            assert monotonic() < end, (self.text("state"), self.text("error"), self.errors)
            sleep(0.05)

    def text(self, part: str) -> str:
        found: str = self.page.locator(f"[data-part={part}]").inner_text()
        return found

    def press(self, name: str) -> None:
        """Press a button, and wait until its action has ended."""
        self.page.click(f"[data-do={name}]")
        self.until(lambda: self.page.is_enabled("[data-do=run]"))

    def wait_for_player(self) -> None:
        """Wait until the player shows its floor."""
        self.page.frame_locator("[data-part=player]").locator("canvas").first.wait_for()

    def type(self, code: str) -> None:
        self.page.fill("[data-part=code]", code)
