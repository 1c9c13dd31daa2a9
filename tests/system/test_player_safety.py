"""The page that plays tracks shows text from users, runs none of it, and loads nothing."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.pages import HOSTILE, loaders
from helpers.player_pages import Files, Shown, shown

from warehouse_core.viz.player import player_page
from warehouse_core.viz.tracks import Frame, Pose, Track
from warehouse_core.viz.tracks.track import DrawnHit

pytestmark = pytest.mark.browser

Open = Callable[..., Shown]

AT_ONCE = 13
"""Number of tracks in a page."""

ROWS = ("...P", "...D")

TEXTS = (
    *HOSTILE, "{data} {script} {title} {policy}", "\\1 \\g<0>", "\u202eabc\u2066", "quoted \"'`",
    "a" * 300, "--> </template><dialog open>", "%00%0d", "__proto__", "constructor",
)  # fmt: skip


def track_saying(text: str) -> Track:
    """Return a track that has a text in every possible place."""
    frames = [Frame(ROWS, (Pose((0.5 + step, 0.5), 0.0, False),), float(step), text)
              for step in range(3)]  # fmt: skip
    frames[1].hits = (DrawnHit((1.5, 1.0), text),)
    metrics = {"battery": [3.0, 2.0, 1.0], "rewards": [0.0, -1.0, -1.0]}
    return Track(frames, metrics, title=text, ending=text)


def test_text_from_users_is_shown_and_not_run(browser, tmp_path, server) -> None:
    address, requested = server
    hostile = [*TEXTS, f"</script>{loaders(address)}", " ".join(TEXTS)[:900]]
    path = tmp_path / "hostile.html"
    tags = "main :is(script, iframe, link, object, video, img, base, svg, form form)"
    with shown(browser) as page:
        for first in range(0, len(hostile), AT_ONCE):
            texts = hostile[first : first + AT_ONCE]
            tracks = [track_saying(text) for text in texts]
            path.write_text(player_page(tracks, title=" ".join(texts)), encoding="utf-8")
            page.open(path)
            page.press("ArrowRight", "End")
            for name in ("title", "caption", "ending"):
                words = page.part(name).evaluate_all("all => all.map(part => part.textContent)")
                said = [re.sub("^[A-Z]: ", "", each) for each in words]
                assert said == texts
            assert page.page.locator(tags).count() == 0
            assert page.read("document.scripts.length") == 2
            assert page.page.title() != "owned"
    assert requested == []


def test_the_policy_blocks_markup_that_got_into_the_page(browser, tmp_path, server) -> None:
    address, requested = server
    html = player_page([track_saying("text")])
    main = '<main id="player"'
    broken = html.replace(main, f"{loaders(address)}{main}")
    assert broken != html
    path = tmp_path / "broken.html"
    path.write_text(broken, encoding="utf-8")
    with shown(browser) as page:
        page.open(path)
        assert page.page.title() == "text"
        assert len(page.read("violations")) >= 6
        assert requested == []
        # A blocked request is an error and a request here, but none at the server.
        page.page.goto("about:blank")
        page.errors.clear()
        page.requests.clear()


def test_ten_megabytes_of_text_open_and_are_cut(opened: Open, files: Files) -> None:
    text = " ".join(f"</script>{number:x}" for number in range(700_000))
    assert len(text) > 10_000_000
    page = opened(files("long", lambda: [track_saying(text)]))
    page.press("End")
    for name in ("title", "caption", "ending"):
        words = page.part(name).text_content()
        assert words == f"{text[: len(words) - 1]}\u2026"
        assert 200 <= len(words) <= 2_000


def test_a_page_loads_nothing_but_itself(opened: Open, files: Files) -> None:
    page = opened(files("alone", lambda: [track_saying("text")]))
    page.press("n", "Space", "?", "Escape", "+", "0", "f")
    urls = [url for url in page.requests if not url.startswith("data:")]
    assert urls == [page.page.url.partition("#")[0]]


def test_a_browser_that_is_too_old_shows_one_sentence(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text(player_page([track_saying("text")]), encoding="utf-8")
    sentence = "This replay needs JavaScript and a browser from 2023 or later."
    for script, options in (
        ("delete globalThis.DecompressionStream", {}),
        ("", {"java_script_enabled": False}),
    ):
        context = browser.new_context(**options)
        page = context.new_page()
        page.add_init_script(script)
        errors: list[str] = []
        page.on("pageerror", lambda error, errors=errors: errors.append(str(error)))
        page.goto(path.as_uri())
        page.wait_for_timeout(200)
        assert page.locator("body").inner_text().strip() == sentence
        assert len(errors) <= 1
        context.close()
