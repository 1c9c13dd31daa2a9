"""The page in a real browser: it shows its pictures, loads nothing and runs nothing."""

import contextlib
import json
import re
import subprocess
import zlib
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.pages import HOSTILE, a_page, a_page_of, loaders
from helpers.player_pages import chromium_program, wait_until
from helpers.results_files import fill, outcomes
from numpy.typing import NDArray
from PIL import Image

from agents.lab.experiments.store import Store
from agents.lab.reports.page import make_page, write_page

pytestmark = pytest.mark.browser

WIDE, NARROW = (1200, 2400), (500, 2400)
"""500 is the smallest width of a window of headless Chromium."""

PHONE = 420

LIGHT, DARK = (f"--blink-settings=preferredColorScheme={scheme}" for scheme in (1, 0))

MAGENTA = (255, 0, 255)
"""Of the SVG in ``pages.py``."""

POLICY = re.compile('<meta http-equiv="Content-Security-Policy"[^>]*>')

QUIET = (
    "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-extensions",
)  # fmt: skip


def chromium(folder: Path, *words: str) -> str:
    """Run a browser with a profile of its own and return what it prints."""
    done = subprocess.run(
        [chromium_program(), *QUIET, f"--user-data-dir={folder / 'profile'}", *words],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def screenshot(page: Path, size: tuple[int, int], *words: str) -> NDArray[np.uint8]:
    picture = page.with_suffix(".png")
    width, height = size
    options = (f"--window-size={width},{height}", f"--screenshot={picture}", *words)
    chromium(page.parent, *options, page.as_uri())
    with Image.open(picture) as image:
        return np.asarray(image.convert("RGB"))


def area(pixels: NDArray[np.uint8], color: tuple[int, int, int]) -> int:
    """Return how many pixels have a colour, within 3 of 255."""
    difference = np.abs(pixels.astype(int) - color).max(axis=-1)
    return int((difference <= 3).sum())


@pytest.fixture
def page(tmp_path: Path) -> Path:
    return tmp_path / "report.html"


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["wide", "narrow"])
def test_figures_are_shown(page: Path, size: tuple[int, int]) -> None:
    write_page(page, a_page())
    assert area(screenshot(page, size), MAGENTA) > 0.95 * 300 * 100


@pytest.mark.parametrize(("scheme", "paper"), [("light", 255), ("dark", 23)])
def test_replays_play_inside_the_page(page: Path, browser: Any, scheme: str, paper: int) -> None:
    write_page(page, a_page(examples=a_page().examples * 2))
    errors = list[str]()
    with browser.new_context(color_scheme=scheme) as context:
        tab = context.new_page()
        tab.on("console", lambda message: errors.append(message.text))
        tab.goto(page.as_uri())
        _, *players = tab.frames
        for player in players:
            wait_until(player, "globalThis.player !== undefined")
            player.locator("[data-do=last]").click()
            assert player.evaluate("player.step") == 1
            color = player.evaluate("getComputedStyle(document.body).backgroundColor")
            assert color.startswith(f"rgb({paper}, ")
        assert len(players) == 2
        assert errors == []


def test_a_dark_scheme_has_a_dark_background_around_figures(page: Path) -> None:
    write_page(page, a_page())
    light = screenshot(page, WIDE, LIGHT)
    dark = screenshot(page, WIDE, DARK)
    assert light[5, 5].min() > 240
    assert dark[5, 5].max() < 50
    rows, cols = np.nonzero((np.abs(dark.astype(int) - MAGENTA) <= 3).all(axis=-1))
    assert dark[rows[0], cols[0] - 5].max() < 50


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a page of real results, whose figures are of each kind."""
    folder = tmp_path_factory.mktemp("drawn")
    hall = folder / "hall.txt"
    hall.write_text("########\n#P....D#\n########\n")
    cases = [
        ({"layout": layout, "battery": battery}, outcomes("d" * battery + "w" * (9 - battery)))
        for layout in ("default", str(hall))
        for battery in (2, 4, 8)
    ]
    page = folder / "report.html"
    with Store(fill(folder / "results.sqlite", cases), read_only=True) as store:
        write_page(page, make_page(store, ()))
    return page


def test_figures_are_dark_in_a_dark_scheme_and_light_in_a_light_one(drawn: Path) -> None:
    light, dark = (screenshot(drawn, (1200, 3600), scheme) for scheme in (LIGHT, DARK))
    assert light.shape == dark.shape
    for pixels, bright in ((light, True), (dark, False)):
        brightest = pixels.min(axis=-1)
        assert (np.mean(brightest > 200) > 0.7) == bright
        assert (np.mean(brightest > 200) < 0.05) != bright
    # Text, axes, bars and heat differ from the paper in both.
    assert np.mean(np.abs(dark.astype(int) - dark[5, 5]).max(axis=-1) > 60) > 0.03


def inspected(page: Path, expression: str, *words: str) -> str:
    """Return the value of an expression in a copy of a page in a frame as wide as a phone.

    The policy of the page forbids other scripts, so it is removed from the copy.
    """
    text = page.read_text(encoding="utf-8")
    assert POLICY.search(text)
    copy, frame = page.with_name("copy.html"), page.with_name("frame.html")
    script = (
        "<script>addEventListener('load', () => "
        f"parent.postMessage(String({expression}), '*'))</script>"
    )
    copy.write_text(POLICY.sub("", text).replace("</body>", f"{script}</body>"), encoding="utf-8")
    frame.write_text(
        "<!DOCTYPE html><title></title>"
        "<script>addEventListener('message', event => document.title = event.data)</script>"
        f"<iframe src='copy.html' width={PHONE} height=900 style='border: 0'></iframe>",
        encoding="utf-8",
    )
    dom = chromium(page.parent, "--virtual-time-budget=9000", *words, "--dump-dom", frame.as_uri())
    return unescape(dom.partition("<title>")[2].partition("</title>")[0])


def test_a_page_of_long_names_does_not_scroll_sideways_on_a_phone(page: Path) -> None:
    write_page(page, a_page_of("a_very_long_name_" * 20))
    images = "[...document.images].map(image => image.naturalWidth)"
    sizes = inspected(page, f"[document.documentElement.scrollWidth, innerWidth, ...{images}]")
    whole, window, *widths = map(int, sizes.split(","))
    assert whole <= window == PHONE
    assert widths == [300], "it has been loaded"


def test_nothing_but_what_scrolls_in_its_box_is_wider_than_a_phone(drawn: Path) -> None:
    found = json.loads(
        inspected(
            drawn,
            "(document.querySelectorAll('details').forEach(each => each.open = true),"
            "JSON.stringify({"
            "screen: innerWidth, whole: document.documentElement.scrollWidth,"
            "wide: [...document.body.querySelectorAll('*')].filter(each => "
            "!each.parentElement.closest('.scroll') && (each.getBoundingClientRect().right > "
            "innerWidth || (each.scrollWidth > each.clientWidth && each.clientWidth && "
            "!each.matches('.scroll')))).map(each => each.outerHTML.slice(0, 80)),"
            "scrolls: [...document.querySelectorAll('.scroll')].map(each => "
            "getComputedStyle(each).overflowX),"
            "shrunk: [...document.images].filter(each => "
            "each.getBoundingClientRect().width < each.naturalWidth - 1).length,"
            "images: document.images.length}))",
        )
    )
    assert found["screen"] == found["whole"] == PHONE
    assert found["wide"] == []
    assert set(found["scrolls"]) == {"auto"}
    assert found["images"] == 5
    assert found["shrunk"] == 0, "their text would be less than 12 pixels high"


def test_the_verdicts_are_seen_at_once_and_the_evidence_after_a_click(drawn: Path) -> None:
    found = json.loads(
        inspected(
            drawn,
            "JSON.stringify([...document.querySelectorAll('.answer')].map(each => [each.innerText,"
            "getComputedStyle(each.querySelector('strong')).fontWeight >= 600,"
            "(each.querySelector('details').open = true, each.innerText)]))",
        )
    )
    assert len(found) == 2
    for folded, is_bold, opened in found:
        question, verdict, *others = folded.split("\n\n")
        assert question.endswith("?")
        assert verdict.endswith(".")
        assert others == ["Evidence"]
        assert is_bold
        assert opened.startswith(folded)
        assert "uccess " in opened.removeprefix(folded)


def printed(page: Path, scheme: str) -> list[bytes]:
    """Return what is drawn on the sheets of a printed page, as streams of PDF operators."""
    file = page.with_suffix(".pdf")
    chromium(page.parent, f"--print-to-pdf={file}", "--no-pdf-header-footer", scheme, page.as_uri())
    streams = []
    for found in re.finditer(rb"stream\r?\n(.*?)endstream", file.read_bytes(), re.DOTALL):
        with contextlib.suppress(zlib.error):
            streams.append(zlib.decompress(found[1]))
    return [stream for stream in streams if re.search(rb" (cm|rg)\b", stream)]


def test_a_printed_page_is_light_and_its_details_are_open(drawn: Path) -> None:
    light, dark = printed(drawn, LIGHT), printed(drawn, DARK)
    assert light == dark
    text = drawn.read_text(encoding="utf-8")
    opened = drawn.with_name("open.html")
    opened.write_text(text.replace("<details>", "<details open>"), encoding="utf-8")
    glyphs = [b"".join(re.findall(rb"<([0-9A-F]+)> Tj", b"".join(sheet)))
              for sheet in (dark, printed(opened, LIGHT))]  # fmt: skip
    assert len(glyphs[0]) > 4 * 1000
    assert len(glyphs[0]) == len(glyphs[1])


def test_names_run_no_script_and_load_nothing(page: Path, server: tuple[str, list[str]]) -> None:
    address, requested = server
    name = " ".join([*HOSTILE, loaders(address)])
    write_page(page, a_page_of(name))
    dom = chromium(page.parent, "--dump-dom", page.as_uri())
    assert requested == []
    assert "<title>owned</title>" not in dom
    outside = re.sub('srcdoc="[^"]*"', "", dom)
    assert outside.count("<script") == 0
    assert outside.count("<img") == outside.count("<iframe") == 1


def test_an_svg_with_a_script_is_shown_and_the_script_is_not_run(
    page: Path, server: tuple[str, list[str]]
) -> None:
    address, requested = server
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="300" height="100">'
        '<rect width="300" height="100" fill="#ff00ff"/>'
        f"<script>fetch('{address}/script'); top.document.title = 'owned'</script>"
        f'<image href="{address}/image" width="9" height="9"/></svg>'
    )
    write_page(page, a_page_of("A name", svg.encode()))
    pixels = screenshot(page, WIDE)
    assert area(pixels, MAGENTA) > 0.95 * 300 * 100
    dom = chromium(page.parent, "--dump-dom", page.as_uri())
    assert "<title>A name</title>" in dom
    assert requested == []


def test_the_policy_of_the_page_blocks_html_that_was_not_escaped(
    page: Path, server: tuple[str, list[str]]
) -> None:
    address, requested = server
    write_page(page, a_page())
    text = page.read_text(encoding="utf-8")
    broken = text.replace("<main>", f"<main>{loaders(address)}")
    assert broken != text
    page.write_text(broken, encoding="utf-8")
    dom = chromium(page.parent, "--dump-dom", page.as_uri())
    assert "<title>A title</title>" in dom
    assert requested == []
    # Without the policy the same page does run and load it.
    page.write_text(broken.replace("Content-Security-Policy", "x-nothing"), encoding="utf-8")
    dom = chromium(page.parent, "--dump-dom", page.as_uri())
    assert "<title>owned</title>" in dom
    assert {"/img", "/script", "/style"} <= set(requested)
