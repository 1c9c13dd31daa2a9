"""A check of pages and pictures in headless Chromium, as readers see them on each screen."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from helpers.player_pages import wait_until

LOOK = Path(__file__).with_name("look.js")

AXE = Path(sys.prefix, "node_modules", "axe-core", "axe.min.js")
"""Script that checks pages for WCAG; ``.ci/full`` has the version."""

RULES = """
async () => {
  const values = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"];
  const runOnly = {type: "tag", values};
  const options = {iframes: false, preload: false, resultTypes: ["violations"], runOnly};
  const {violations} = await axe.run(document, options);
  return violations.flatMap(({id, nodes}) => nodes.map(({target, failureSummary}) =>
    `wcag: ${id}: ${target.join(" ")}: ${failureSummary.split("\\n").slice(1, 3).join(" ")}`));
}
"""

PLACES = ("start", "end", "help")
"""Moments of a replay at which a page is looked at, and its list of keys."""

GO = """
(place) => {
  for (const each of document.querySelectorAll("details")) each.open = true;
  const dialog = document.querySelector("dialog");
  dialog?.close();
  if (place === "help") dialog?.showModal();
  else globalThis.player?.seek(place === "end" ? player.end : 0);
  return place === "start" || globalThis.player !== undefined;
}
"""
"""Function that goes to one of ``PLACES``, and returns whether the page looks different there."""

READY = "!document.getElementById('player') || globalThis.player !== undefined"

SETTLED = """
() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))
"""


HARNESS = "Canvas2D: Multiple readback operations"
"""Beginning of a warning about how ``look.js`` reads the colours behind text."""


class Screen(NamedTuple):
    """A size of a window, a colour scheme, and whether a page is printed on it."""

    width: int
    height: int
    scheme: str = "light"
    media: str = "screen"

    def __str__(self) -> str:
        return f"{self.width} px {self.scheme}{' printed' if self.media == 'print' else ''}"


DESKTOP, PHONE = (1366, 768), (360, 740)

SCREENS = [Screen(*size, scheme) for size in (DESKTOP, PHONE) for scheme in ("light", "dark")]

SHEET = Screen(718, 1000, media="print")
"""A4 without its margins."""


Faults = dict[str, list[str]]
"""Faults, and the places where each was seen."""


class Reader:
    """A tab of a browser that opens pages one after the other and looks for faults in each."""

    def __init__(self, page: Any) -> None:
        self._page = page
        self._faults: Faults = {}
        page.on("pageerror", lambda error: self._add([f"console: {error}"], "script"))
        page.on("console", lambda message: self._say(message.text))

    def faults_of_page(self, file: Path, screens: Sequence[Screen] = SCREENS) -> Faults:
        """Return the faults of a page on each screen and at each of ``PLACES``."""
        self._open(file, screens[0])
        for screen in screens:
            self._show(screen)
            for place in PLACES:
                self._look(str(screen), place, screen.width == DESKTOP[0])
                # The checker is slow, so it runs once for each size and each scheme.
                if screen in (SCREENS[0], SCREENS[-1], screens[0]) and place != "end":
                    self._check(str(screen), place)
        return self._faults

    def faults_of_picture(self, file: Path) -> Faults:
        """Return the faults of an SVG in its own size."""
        self._open(file, SCREENS[0])
        self._look("picture", "start", None)
        return self._faults

    def _open(self, file: Path, screen: Screen) -> None:
        self._page.goto("about:blank")
        self._faults = {}
        self._show(screen)
        self._page.goto(file.as_uri())
        for frame in self._page.frames:
            wait_until(frame, READY)

    def _show(self, screen: Screen) -> None:
        """Change the screen, and wait until the page is drawn."""
        self._page.set_viewport_size({"width": screen.width, "height": screen.height})
        self._page.emulate_media(color_scheme=screen.scheme, media=screen.media)
        self._page.evaluate(SETTLED)

    def _look(self, screen: str, place: str, wide: bool | None) -> None:
        for where, frame in self._frames(f"{screen}, {place}"):
            if frame.evaluate(GO, place):
                frame.evaluate(SETTLED)
                seen = frame.evaluate("(wide) => look(wide)", wide)
                self._add(seen["faults"], where)
                assert seen["texts"] > 0, f"{where}: there is no text"

    def _say(self, message: str) -> None:
        if not message.startswith(HARNESS):
            self._add([f"console: {message}"], "script")

    def _check(self, screen: str, place: str) -> None:
        for where, frame in self._frames(f"{screen}, {place}"):
            if frame.evaluate(GO, place):
                self._add(frame.evaluate(RULES), where)

    def _frames(self, where: str) -> Iterator[tuple[str, Any]]:
        """Yield each frame with its name; a browser does not draw those that are not in view."""
        for number, frame in enumerate(self._page.frames):
            if number:
                frame.frame_element().scroll_into_view_if_needed()
            yield f"{where}, frame {number}" if number else where, frame

    def _add(self, faults: Sequence[str], where: str) -> None:
        for fault in faults:
            self._faults.setdefault(fault, []).append(where)


@contextmanager
def reading(browser: Any) -> Iterator[Reader]:
    """Yield a reader that looks at pages."""
    assert AXE.exists(), f"these tests need axe-core in {AXE.parent}; see .github/CONTRIBUTING.md"
    context = browser.new_context(reduced_motion="reduce")
    try:
        for script in (LOOK, AXE):
            context.add_init_script(path=script)
        yield Reader(context.new_page())
    finally:
        context.close()
