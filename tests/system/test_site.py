"""The handbook as a site: built without a warning, all links lead somewhere, read in a browser."""

from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
from helpers.handbook import SITE
from helpers.player_pages import shown, wait_until

pytestmark = pytest.mark.browser

PHONE = {"width": 390, "height": 800}

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
  const wide = document.documentElement.scrollWidth - innerWidth;
  if (wide > 0) faults.push(`${wide} pixels too wide`);
  return faults;
}
"""


class Anchors(HTMLParser):
    """The ``id``s of a page, and what it refers to: links, scripts, styles and pictures."""

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


@pytest.mark.parametrize("name", [*SITE, "genindex", "py-modindex"])
@pytest.mark.parametrize("options", [{}, {"viewport": PHONE, "color_scheme": "dark"}])
def test_a_page_is_read_in_a_browser(
    browser: Any, site: Path, name: str, options: dict[str, Any]
) -> None:
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
        player.get_by_label("To the start").click()
        player.get_by_text("step 0 of").first.wait_for()
        player.get_by_label("One step on").click()
        player.get_by_text("step 1 of").first.wait_for()


def test_the_first_page_plays_by_itself(browser: Any, site: Path) -> None:
    with shown(browser, viewport={"width": 1366, "height": 768}) as reading:
        reading.page.goto((site / "index.html").as_uri())
        [_, player] = reading.page.frames
        wait_until(player, "globalThis.player?.isPlaying && player.time > 0")
