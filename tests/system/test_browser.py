"""The page of a report in a real browser: it shows its pictures, and loads and runs nothing."""

import contextlib
import re
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.pages import a_page, a_page_of, loaders
from helpers.player_pages import wait_until
from helpers.results_files import fill, outcomes
from numpy.typing import NDArray
from PIL import Image

from agents.lab.experiments.store import Store
from agents.lab.reports.page import make_page, write_page

pytestmark = pytest.mark.browser

Open = Callable[..., Any]


MAGENTA = (255, 0, 255)
"""Colour of the SVG in ``pages.py``."""


@pytest.fixture
def tab(browser: Any) -> Iterator[Open]:
    """Return a function that opens a page in a tab of its own, with a given width."""
    with ExitStack() as stack:

        def open_page(file: Path, scheme: str = "light", width: int = 1200) -> Any:
            size = {"width": width, "height": 900}
            context = browser.new_context(viewport=size, color_scheme=scheme)
            page = stack.enter_context(contextlib.closing(context)).new_page()
            page.goto(file.as_uri())
            return page

        yield open_page


def pixels_of(page: Any) -> NDArray[np.uint8]:
    with Image.open(BytesIO(page.screenshot(full_page=True))) as image:
        return np.asarray(image.convert("RGB"))


def is_magenta(pixels: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Return which pixels have this colour, within 3 of 255."""
    return np.abs(pixels.astype(int) - MAGENTA).max(axis=-1) <= 3


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "report.html"


def test_figures_are_shown_on_a_light_card_on_paper_of_the_scheme(file, report_page, tab) -> None:
    write_page(file, a_page())
    for width, scheme, low, high in ((1200, "light", 240, 255), (500, "dark", 0, 50)):
        pixels = pixels_of(tab(file, scheme, width))
        assert is_magenta(pixels).sum() > 0.95 * 300 * 100
        assert low <= pixels[5, 5].min() <= pixels[5, 5].max() <= high
        image = tab(report_page, scheme, width).locator("figure img").first
        with Image.open(BytesIO(image.screenshot())) as card:
            assert np.mean(np.asarray(card.convert("RGB")).min(axis=-1) > 200) > 0.7


def test_replays_play_inside_the_page(file: Path, tab: Open) -> None:
    [section] = [each for each in a_page().sections if each.title == "Examples"]
    write_page(file, a_page(Examples=[*section.parts] * 2))
    errors = list[str]()
    for scheme, paper in (("light", 255), ("dark", 23)):
        page = tab(file, scheme)
        page.on("console", lambda message: errors.append(message.text))
        _, *players = page.frames
        assert len(players) == 2
        for player in players:
            wait_until(player, "globalThis.player !== undefined")
            player.locator("[data-do=last]").click()
            assert player.evaluate("player.step") == 1
            color = player.evaluate("getComputedStyle(document.body).backgroundColor")
            assert color.startswith(f"rgb({paper}, ")
    assert errors == []


@pytest.fixture(scope="module")
def report_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a page of real results, with figures of each kind."""
    folder = tmp_path_factory.mktemp("report_page")
    hall = folder / "hall.txt"
    hall.write_text("########\n#P....D#\n########\n")
    cases = [
        ({"layout": layout, "battery": battery}, outcomes("d" * battery + "w" * (9 - battery)))
        for layout in ("default", str(hall))
        for battery in (2, 4, 8)
    ]
    page = folder / "report.html"
    with Store(fill(folder / "results.sqlite", cases), read_only=True) as store:
        write_page(page, make_page(store))
    return page


def test_the_verdicts_are_seen_at_once_and_the_evidence_after_a_click(report_page, tab) -> None:
    answers = tab(report_page).locator(".answer").all()
    assert len(answers) == 2
    for answer in answers:
        folded = answer.inner_text()
        question, verdict, *others = folded.split("\n\n")
        assert (question[-1], verdict[-1], others) == ("?", ".", ["Evidence"])
        weight = answer.locator("strong").first.evaluate(
            "each => getComputedStyle(each).fontWeight"
        )
        assert int(weight) >= 600
        answer.locator("summary").first.click()
        opened = answer.inner_text()
        assert opened.startswith(folded)
        assert "uccess " in opened.removeprefix(folded)


def printed(page: Any) -> list[bytes]:
    """Return the contents of the sheets of a printed page, as streams of PDF operators."""
    streams = []
    for found in re.finditer(rb"stream\r?\n(.*?)endstream", page.pdf(), re.DOTALL):
        with contextlib.suppress(zlib.error):
            streams.append(zlib.decompress(found[1]))
    return [stream for stream in streams if re.search(rb" (cm|rg)\b", stream)]


def test_a_printed_page_is_light_and_its_details_are_open(report_page: Path, tab: Open) -> None:
    light, dark = printed(tab(report_page, "light")), printed(tab(report_page, "dark"))
    assert light == dark
    text = report_page.read_text(encoding="utf-8")
    opened = report_page.with_name("open.html")
    opened.write_text(text.replace("<details>", "<details open>"), encoding="utf-8")
    glyphs = [
        len(b"".join(re.findall(rb"<([0-9A-F]+)> Tj", b"".join(sheets))))
        for sheets in (dark, printed(tab(opened)))
    ]
    assert glyphs[0] == glyphs[1] > 4 * 1000


def test_an_svg_with_a_script_is_shown_and_the_script_is_not_run(file, tab, server) -> None:
    address, requested = server
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="300" height="100">'
        '<rect width="300" height="100" fill="#ff00ff"/>'
        f"<script>fetch('{address}/script'); top.document.title = 'owned'</script>"
        f'<image href="{address}/image" width="9" height="9"/></svg>'
    )
    write_page(file, a_page_of("A name", svg.encode()))
    page = tab(file)
    assert is_magenta(pixels_of(page)).sum() > 0.95 * 300 * 100
    assert (page.title(), requested) == ("A name", [])


def test_the_policy_of_the_page_blocks_html_that_was_not_escaped(file, tab, server) -> None:
    address, requested = server
    write_page(file, a_page())
    text = file.read_text(encoding="utf-8")
    broken = text.replace("<main>", f"<main>{loaders(address)}")
    assert broken != text
    file.write_text(broken, encoding="utf-8")
    assert (tab(file).title(), requested) == ("A title", [])
    # Without the policy, the same page runs and loads it.
    file.write_text(broken.replace("Content-Security-Policy", "x-nothing"), encoding="utf-8")
    assert tab(file).title() == "owned"
    assert {"/img", "/script", "/style"} <= {*requested}
