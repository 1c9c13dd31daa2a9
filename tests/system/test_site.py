"""The handbook as a site: it builds without warnings, its links work, and browsers show it."""

import re
import subprocess
import sys
from collections.abc import Iterator
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlencode, urlsplit

import pytest
from helpers.command_line import LEAVES
from helpers.handbook import HANDBOOK, SITE
from helpers.player_pages import shown, wait_until
from helpers.servers import served

from agents.lab.grading.rubric import SOLUTIONS

pytestmark = pytest.mark.browser

DESKTOP, PROJECTOR = {"width": 1366, "height": 768}, {"width": 1280, "height": 720}
PHONE = {"width": 360, "height": 800}

FAULTS = """
() => {
  const faults = [];
  for (const each of document.querySelectorAll("article img")) {
    if (each.loading !== "lazy" && !each.naturalWidth) faults.push(`empty picture ${each.src}`);
    const isDark = matchMedia("(prefers-color-scheme: dark)").matches && !each.src.endsWith(".svg");
    if (isDark && getComputedStyle(each).filter === "none") faults.push(`white ${each.src}`);
  }
  for (const each of document.querySelectorAll(".cell_output")) {
    if (/^warehouse: |not found|Traceback/m.test(each.innerText)) faults.push(each.innerText);
  }
  if (/Show code cell/.test(document.body.innerText)) faults.push("code is folded");
  for (const each of [document.documentElement, ...document.querySelectorAll(".content")]) {
    const wide = each.scrollWidth - each.clientWidth;
    if (wide > 0) faults.push(`${each.className} is ${wide} pixels too wide`);
  }
  // Tables and what programs print have columns, which may scroll on phones.
  const columns = innerWidth < 1000 ? ".cell_output, .highlight-text, .table-wrapper" : "nothing";
  for (const each of document.querySelectorAll("article :is(pre, .table-wrapper)")) {
    const wide = each.scrollWidth - each.clientWidth;
    const words = `${each.innerText.slice(0, 80)} is ${wide} pixels too wide`;
    if (wide > 0 && !each.closest(columns)) faults.push(words);
  }
  return faults;
}
"""


@pytest.fixture
def site_address(site: Path) -> Iterator[str]:
    """Serve the site, because its search loads files, and yield the address."""
    with served(site) as address:
        yield address


class Anchors(HTMLParser):
    """The ``id``s of a page, and the links, scripts, styles and pictures that it refers to."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value for name, value in attrs if value}
        self.ids |= {values[name] for name in ("id", "name") if name in values}
        self.links += [values["href"]] if tag == "a" and "href" in values else []
        self.loaded += [values["src"]] if "src" in values else []
        self.loaded += [values["href"]] if tag == "link" and "href" in values else []


def test_all_links_lead_somewhere_and_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    pages = {path: Anchors(path) for path in site.rglob("*.html")}
    assert pages.keys() >= {site / f"{name}.html" for name in SITE}
    for path, page in pages.items():
        assert [each for each in page.loaded if urlsplit(each).scheme not in ("", "data")] == []
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or not (parts.path or parts.fragment):
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            assert target.exists(), f"{path.name}: {link}"
            if parts.fragment and target in pages:
                assert unquote(parts.fragment) in pages[target].ids, f"{path.name}: {link}"


def test_the_page_of_the_command_line_has_the_help_of_every_command(site: Path) -> None:
    page = (site / "reference/command_line.html").read_text(encoding="utf-8")
    text = unescape(re.sub("<[^>]+>", "", page))
    for name, command in LEAVES.items():
        shown_help = text.partition(f"Usage: warehouse {name} ")[2].partition("Usage:")[0]
        options = [each for each in command.params if each.param_type_name == "option"]
        assert shown_help, name
        assert [each for each in options if each.opts[-1] not in shown_help] == [], name


def test_solutions_are_in_the_site_for_lecturers_alone(tmp_path: Path) -> None:
    """The cells are not run, because they do not depend on the tag."""
    pages = {}
    for tag in ("solutions", "students"):
        words = "-Q", "-t", tag, "-D", "nb_execution_mode=off", HANDBOOK, tmp_path / tag
        subprocess.run([sys.executable, "-m", "sphinx", *words], check=True)
        pages[tag] = (tmp_path / tag / "exercises.html").read_text(encoding="utf-8")
    for solution in SOLUTIONS.glob("*.py"):
        title = solution.read_text(encoding="utf-8").splitlines()[0].strip('"')
        assert [pages[tag].count(title) for tag in pages] == [1, 0]


@pytest.mark.parametrize("name", [*SITE, "genindex", "py-modindex"])
@pytest.mark.parametrize(
    "options",
    [{"viewport": DESKTOP}, {"viewport": PROJECTOR}, {"viewport": PHONE, "color_scheme": "dark"}],
)
def test_a_page_is_read_in_a_browser(browser, site, name, options) -> None:
    with shown(browser, **options) as reading:
        reading.page.goto((site / f"{name}.html").as_uri())
        reading.page.wait_for_load_state("networkidle")
        assert reading.read(FAULTS) == []
        assert reading.page.locator("h1").count() == 1


def test_the_first_episode_of_the_mini_lab_plays(browser: Any, site: Path) -> None:
    with shown(browser) as reading:
        reading.page.goto((site / "mini_lab.html").as_uri())
        player = reading.page.frame_locator("iframe").first
        player.locator("main canvas").first.wait_for()
        player.get_by_label("Go to the start").click()
        player.get_by_text("step 0 of").first.wait_for()
        player.get_by_label("One step forward").click()
        player.get_by_text("step 1 of").first.wait_for()


@pytest.mark.parametrize(
    ("words", "page"),
    [("flowtime", "glossary.html"), ("--plan-seconds", "reference/command_line.html")],
)
def test_the_search_finds_pages(browser: Any, site_address: str, words: str, page: str) -> None:
    reading = browser.new_page()
    try:
        reading.goto(f"{site_address}/search.html?{urlencode({'q': words})}")
        reading.locator(f"#search-results a[href^='{page}']").first.wait_for()
    finally:
        reading.close()


def test_the_first_page_plays_by_itself(browser: Any, site: Path) -> None:
    with shown(browser, viewport=DESKTOP) as reading:
        reading.page.goto((site / "index.html").as_uri())
        [_, player] = reading.page.frames
        wait_until(player, "globalThis.player?.time > 0")
