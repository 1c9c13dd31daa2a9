"""The page of a report: the order of its parts, and the escaping of user input."""

from html.parser import HTMLParser
from pathlib import Path

import pytest
from helpers.pages import HOSTILE, a_page, a_page_of
from helpers.player import said_by

from agents.lab.reports.page import write_page
from warehouse_core.viz.player.page import digest, script
from warehouse_core.wording import printable

VOID = {"meta", "link", "img", "input", "source"}
ALLOWED = {
    "html", "head", "meta", "link", "title", "style", "body", "header", "nav", "main", "section",
    "article", "h1", "h2", "h3", "p", "a", "div", "span", "figure", "figcaption",
    "img", "table", "thead", "tbody", "tr", "th", "td", "code", "details",
    "summary", "strong", "iframe",
}  # fmt: skip


class Seen(HTMLParser):
    """The elements, attributes and texts of a page."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.texts: list[tuple[str, str]] = []
        self.comments: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert len(dict(attrs)) == len(attrs), f"{tag} has an attribute twice"
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in VOID:
            self.open.append(tag)
            self.texts.append((tag, ""))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            tag, text = self.texts[-1]
            if tag == self.open[-1]:
                self.texts[-1] = (tag, text + data)
            else:
                self.texts.append((self.open[-1], data))

    def handle_comment(self, data: str) -> None:
        self.comments.append(data)

    def said(self, tag: str) -> list[str]:
        return [text.strip() for each, text in self.texts if each == tag and text.strip()]

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attributes for each, attributes in self.elements if each == tag]


def read(path: Path) -> Seen:
    return Seen(path.read_text(encoding="utf-8"))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "report.html"


def test_a_replay_is_a_player_whose_script_alone_is_allowed(path: Path) -> None:
    write_page(path, a_page())
    [frame] = read(path).all("iframe")
    assert frame["sandbox"] == "allow-scripts"
    assert frame["title"] == "Replay of an episode that ended as oscillation: swung to and fro"
    [track] = said_by(frame["srcdoc"])["tracks"]
    assert track["title"] == "A robot on the grid backend, seed 4"
    own, allowed = rules_of(Seen(frame["srcdoc"])), rules_of(read(path))
    assert allowed["script-src"] == own["script-src"] == digest(script())
    source = frame["srcdoc"].partition('<script type="module">')[2].partition("</script>")[0]
    assert source == script(), "as it was hashed"


def rules_of(seen: Seen) -> dict[str, str]:
    """Return the Content-Security-Policy of a page."""
    [policy] = [each["content"] for each in seen.all("meta") if "http-equiv" in each]
    return dict(rule.split(maxsplit=1) for rule in policy.split("; "))


@pytest.mark.parametrize("name", HOSTILE)
def test_names_are_escaped_and_load_nothing(path: Path, name: str) -> None:
    write_page(path, a_page_of(name))
    seen = read(path)
    assert seen.open == []
    assert seen.comments == []
    assert {tag for tag, _ in seen.elements} <= ALLOWED
    for tag, attributes in seen.elements:
        assert not [each for each in attributes if each.startswith("on")], tag
    name = printable(name).strip()
    assert seen.said("title") == seen.said("h1") == [name]
    assert seen.said("th").count(name) == 3
    assert seen.said("td").count(name) == 3
    assert name in [each["alt"].strip() for each in seen.all("img")]
    assert f"{name}={name}" in seen.said("code")
    for tag, attributes in seen.elements:
        assert attributes.get("src", "data:").startswith("data:"), tag
        assert attributes.get("href", "#").startswith(("#", "data:,")), tag
    [style] = seen.said("style")
    assert "url(" not in style
    assert "@import" not in style
    rules = rules_of(seen)
    assert rules["default-src"] == "'none'"
    assert rules["img-src"] == "data:"
    assert rules["script-src"] == digest(script())
