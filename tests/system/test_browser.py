"""The page in a real browser: it shows its pictures, loads nothing and runs nothing."""

import http.server
import shutil
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from helpers.pages import HOSTILE, a_page, a_page_of
from numpy.typing import NDArray
from PIL import Image

from agents.reports.page import write_page

pytestmark = pytest.mark.browser

WIDE, NARROW = (1200, 2400), (500, 2400)
"""500 is the smallest width of a window of headless Chromium."""

MAGENTA, CYAN = (255, 0, 255), (0, 255, 255)
"""Of the pictures in ``pages.py``, the SVG and the GIF."""

QUIET = (
    "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-extensions",
)  # fmt: skip


def chromium(folder: Path, *words: str) -> str:
    """Run a browser with a profile of its own and return what it prints."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    assert program is not None, "these tests need chromium: apt-get install chromium"
    done = subprocess.run(
        [program, *QUIET, f"--user-data-dir={folder / 'profile'}", *words],
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


@pytest.fixture
def server() -> Iterator[tuple[str, list[str]]]:
    """Yield the address of a server, and a list of the paths requested from it."""
    requested: list[str] = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            requested.append(self.path)
            self.send_response(404)
            self.end_headers()

        def log_message(self, format: str, *_: object) -> None:  # noqa: A002
            pass

    listener = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=listener.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{listener.server_port}", requested
    finally:
        listener.shutdown()
        thread.join()
        listener.server_close()


def loaders(address: str) -> str:
    """Return HTML that loads something in each way that needs no click."""
    return (
        f'<img src="{address}/img"><script src="{address}/script"></script>'
        f'<link rel="stylesheet" href="{address}/style"><iframe src="{address}/frame"></iframe>'
        f'<object data="{address}/object"></object><video src="{address}/video" autoplay></video>'
        f'<div style="background: url({address}/background)">x</div>'
        f"<script>document.title = 'owned'; fetch('{address}/fetch')</script>"
        f"<img src=x onerror=\"document.title = 'owned'\">"
    )


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["wide", "narrow"])
def test_both_kinds_of_pictures_are_shown(page: Path, size: tuple[int, int]) -> None:
    write_page(page, a_page())
    pixels = screenshot(page, size)
    for color in (MAGENTA, CYAN):
        # Each is 300 x 100 dots or more.
        assert area(pixels, color) > 0.95 * 300 * 100


def test_a_narrow_page_does_not_scroll_sideways(page: Path) -> None:
    name = "a_very_long_name_" * 20
    write_page(page, a_page_of(name))
    text = page.read_text(encoding="utf-8")
    # The policy forbids every script, so it is removed from this copy, which a script measures.
    assert "default-src 'none'" in text
    probe = page.with_name("probe.html")
    measure = (
        "<script>addEventListener('load', () => {const images = [...document.images];"
        "document.title = [document.documentElement.scrollWidth, innerWidth, images.length,"
        "...images.map(image => image.naturalWidth)].join(' ')})</script>"
    )
    probe.write_text(
        text.replace("default-src 'none'; ", "").replace("</body>", f"{measure}</body>"),
        encoding="utf-8",
    )
    dom = chromium(page.parent, "--window-size=500,900", "--dump-dom", probe.as_uri())
    title = dom.partition("<title>")[2].partition("</title>")[0]
    whole, window, images, *widths = map(int, title.split())
    assert whole <= window == 500
    assert images == len(widths) == 2
    assert widths == [300, 300], "each picture has been loaded"


def test_a_dark_scheme_has_a_dark_background_and_pictures_keep_a_white_one(page: Path) -> None:
    write_page(page, a_page())
    light = screenshot(page, WIDE, "--blink-settings=preferredColorScheme=1")
    dark = screenshot(page, WIDE, "--blink-settings=preferredColorScheme=0")
    assert light[5, 5].min() > 240
    assert dark[5, 5].max() < 50
    rows, cols = np.nonzero((dark == MAGENTA).all(axis=-1))
    beside = dark[rows[0], cols[0] - 5]
    assert beside.min() > 240
    assert area(dark, CYAN) > 0.95 * 300 * 100


def test_names_run_no_script_and_load_nothing(page: Path, server: tuple[str, list[str]]) -> None:
    address, requested = server
    name = " ".join([*HOSTILE, loaders(address)])
    write_page(page, a_page_of(name))
    dom = chromium(page.parent, "--dump-dom", page.as_uri())
    assert requested == []
    assert "<title>owned</title>" not in dom
    assert dom.count("<script") == 0
    assert dom.count("<img") == 2


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
