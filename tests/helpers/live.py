"""The handbook's site with live pages: built, and read in a headless Chromium."""

import gzip
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep
from typing import Any
from urllib.parse import urlsplit

from agents.handbook import live
from helpers.handbook import HANDBOOK
from helpers.playground import FILES

SECONDS = 240
"""Longest time that something takes on a busy machine."""

COMPRESSED = (".css", ".html", ".ipynb", ".js", ".json", ".wasm")
"""Ends of the names of files that servers compress."""


def write_site(folder: Path) -> Path:
    """Build the site with live pages, of which no cell is run before, and return its folder."""
    assert FILES.is_dir(), f"{FILES} is missing; .ci/pyodide fetches it"
    options = ["-D", "nb_execution_mode=off", "-D", f"pyodide={FILES}"]
    words = ["-Q", "-t", "live", *options, HANDBOOK, folder]
    subprocess.run([sys.executable, "-m", "sphinx", *words], check=True)
    return folder


def cells_of(page: str) -> list[str]:
    """Return the cells of a live page that a browser runs."""
    cells = live.notebook_of(HANDBOOK / f"{page}.md").cells
    return [cell.source for cell in cells if cell.cell_type == "code"]


class LivePage:
    """A notebook in a browser, and what it has loaded."""

    def __init__(self, page: Any, address: str, name: str) -> None:
        self.page, self.errors, self.requests = page, list[str](), list[str]()
        self.sizes: dict[str, int] = {}
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        # Workers ask too, and are of the context.
        page.context.on("request", lambda request: self.requests.append(request.url))
        page.context.on("response", self._count)
        page.goto(f"{address}{live.ADDRESS.format(page=name)}")
        # Before the kernel is there nothing is run.
        page.locator(".jp-KernelName >> text=Pyodide").wait_for(state="attached")

    def _count(self, response: Any) -> None:
        self.sizes[response.url] = int(response.headers.get("content-length", 0))

    @property
    def size(self) -> int:
        """Bytes loaded, or in the cache."""
        return sum(self.sizes.values())

    def compressed(self, site: Path) -> int:
        """Return the bytes loaded if the server compresses, unlike that of the tests."""
        files = {site / urlsplit(url).path[1:]: size for url, size in self.sizes.items()}
        return sum(
            len(gzip.compress(file.read_bytes())) if file.suffix in COMPRESSED else size
            for file, size in files.items()
        )

    def run(self) -> None:
        """Begin to run all cells."""
        self.page.click(".lm-MenuBar-itemLabel >> text=Run")
        self.page.click(".lm-Menu-itemLabel >> text='Run All Cells'")

    def wait_for_player(self) -> None:
        """Wait until a player shows its floor."""
        frame = self.page.frame_locator(".jp-OutputArea-output iframe").first
        frame.locator("main canvas").first.wait_for(timeout=SECONDS * 1000)

    def wait_for_end(self) -> None:
        """Wait until no cell waits to be run."""
        waiting = self.page.locator(".jp-InputPrompt >> text='[*]:'")
        self._until(lambda: not waiting.count())

    def _until(self, is_so: Callable[[], bool]) -> None:
        end = monotonic() + SECONDS
        while not is_so():
            assert monotonic() < end, (self.outputs, self.errors)
            sleep(0.1)

    @property
    def outputs(self) -> list[str]:
        """The texts below cells."""
        found: list[str] = self.page.locator(".jp-OutputArea-output").all_inner_texts()
        return found

    @property
    def red(self) -> list[str]:
        """The texts below cells that are errors or warnings."""
        kinds = ("stderr", "error")
        marks = ", ".join(f"[data-mime-type='application/vnd.jupyter.{kind}']" for kind in kinds)
        found: list[str] = self.page.locator(marks).all_inner_texts()
        return found
