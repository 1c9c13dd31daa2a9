"""Pages that play tracks, opened in headless Chromium by Playwright."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from warehouse_core.viz.player import player_page
from warehouse_core.viz.tracks import Track

Box = tuple[float, float, float, float]
"""Column, row, number of columns and number of rows, in cells."""

MAX_WAIT = 30.0
"""Seconds to wait for a condition."""

LISTENING = """
globalThis.isPainted = false;
new PerformanceObserver(() => (isPainted = true)).observe({type: "paint", buffered: true});
globalThis.violations = [];
addEventListener("securitypolicyviolation", (event) => violations.push(event.blockedURI));
"""
"""Script that runs before the page's own script."""

COUNT = """
([panel, color, boxes]) => {
  const {view, canvas} = player.panels[panel];
  const {width, height} = canvas;
  const copy = Object.assign(document.createElement("canvas"), {width: width + 1, height});
  const context = copy.getContext("2d", {willReadFrequently: true});
  context.drawImage(canvas, 0, 0);
  context.fillStyle = color.startsWith("#") ? color : player.theme[color];
  context.fillRect(width, 0, 1, 1);
  const wanted = context.getImageData(width, 0, 1, 1).data;
  return boxes.map((box) => {
    const {data} = context.getImageData(...view.box(...box));
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      if ([0, 1, 2].every((part) => Math.abs(data[i + part] - wanted[part]) <= 2)) count++;
    }
    return count / (data.length / 4);
  });
}
"""
"""Function that returns the share of each box that has a colour."""

PICTURES = """
() => [...document.querySelectorAll("main canvas, .chart > svg")].map(
  (part) => part.toDataURL?.() ?? part.outerHTML
).join(" ")
"""


def chromium_program() -> str:
    """Return the path of a browser."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    assert program is not None, "these tests need chromium: apt-get install chromium"
    return program


@contextmanager
def headless_chromium() -> Iterator[Any]:
    """Yield a browser that draws without a GPU, driven by Playwright."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium_program(), args=["--no-sandbox", "--disable-gpu"]
        )
        yield browser
        browser.close()


def wait_until(frame: Any, condition: str) -> None:
    """Wait until a condition is true in a page or a frame.

    The policy of the page forbids ``wait_for_function`` of Playwright.
    """
    end = monotonic() + MAX_WAIT
    while not frame.evaluate(condition):
        assert monotonic() < end, condition
        sleep(0.02)


class Shown:
    """A page in a browser, and the errors that occurred in it."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.errors: list[str] = []
        self.requests: list[str] = []
        page.on("pageerror", lambda error: self.errors.append(f"uncaught: {error}"))
        page.on("console", lambda message: self.errors.append(f"console: {message.text}"))
        page.on("request", lambda request: self.requests.append(request.url))
        page.add_init_script(LISTENING)

    def open(self, file: Path) -> "Shown":
        """Load a file, and wait until the page shows it.

        Chromium drops keys until it first paints a page, which may be late on a busy machine.
        """
        self.page.goto(file.as_uri())
        wait_until(self.page, "globalThis.player !== undefined && isPainted")
        return self

    def read(self, expression: str) -> Any:
        """Return the value of an expression of JavaScript."""
        return self.page.evaluate(expression)

    def part(self, name: str) -> Any:
        """Return the locator of a part of the page."""
        return self.page.locator(f'[data-part="{name}"]')

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def seek(self, step: float) -> None:
        """Go to a step, or to a time within one."""
        self.read(f"player.seek({step})" if step % 1 else f"player.goTo({step})")

    def shares(self, color: str, boxes: Sequence[Box]) -> list[float]:
        """Return which part of each of some boxes of the first floor has a colour."""
        shares: list[float] = self.page.evaluate(COUNT, [0, color, boxes])
        return shares

    def share(self, color: str, box: Box) -> float:
        """Return the share of a box that has a colour."""
        return self.shares(color, [box])[0]

    def pictures(self) -> str:
        """Return all canvases and charts as text."""
        text: str = self.read(PICTURES)
        return text

    def check(self) -> None:
        """Raise unless nothing went wrong and nothing was loaded."""
        assert self.errors == [], self.errors
        assert self.read("violations") == []
        others = [url for url in self.requests if not url.startswith(("about:", "data:", "file:"))]
        assert others == [], others


@contextmanager
def shown(browser: Any, *, is_held: bool = False, **options: Any) -> Iterator[Shown]:
    """Yield an empty page with options of a browser context; check it at the end."""
    context = browser.new_context(**{"viewport": {"width": 1200, "height": 800}, **options})
    try:
        page = Shown(context.new_page())
        if is_held:  # only ``run_for`` advances the time
            page.page.clock.install(time=0)
            page.page.clock.pause_at(1000)
        yield page
        page.check()
    finally:
        context.close()


class Files:
    """Writes pages into a folder, each once; they open at the start and do not play."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __call__(self, name: str, tracks: Callable[[], list[Track]], **options: Any) -> Path:
        path = self._folder / f"{name}.html"
        if not path.exists():
            page = player_page(tracks(), **{"opens_at": 0.0, **options})
            path.write_text(page, encoding="utf-8")
        return path
