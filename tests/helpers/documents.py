"""Every kind of page and picture with a name in it, and the parts that a browser would run."""

import dataclasses
from collections.abc import Iterator
from html.parser import HTMLParser
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from agents.lab.experiments.case import make_case
from agents.lab.experiments.store import Store
from agents.lab.reports.page import make_page, write_page
from agents.lab.trials.figure import scores_figure
from helpers.pages import a_page_of
from helpers.pictures import named, replay_of
from helpers.results_files import GOOD, outcomes, scores_of
from warehouse_core.viz.figure import save_svg

SCRIPT_TAGS = {"script", "iframe", "object", "embed", "base", "form", "foreignobject", "math"}
LINKS = {"href", "src", "action", "formaction", "data", "srcdoc", "xlink:href"}


def write_documents(folder: Path, name: str) -> None:
    """Write every kind of page and SVG, with ``name`` wherever a user may give one."""
    write_page(folder / "page.html", a_page_of(name))
    with Store(folder / "results.sqlite") as store:
        for agent, layout in product((name, f"{name}2"), repeat=2):
            case = {**make_case({"agent": "astar"}), "agent": agent, "layout": layout}
            store.add(store.case_ids([case])[0], outcomes("dow"))
        page = make_page(store)
    write_page(folder / "report.html", page._replace(title=name))
    for picture in next(each.parts for each in page.sections if each.title == "Figures"):
        (folder / f"{picture.name}.svg").write_bytes(picture.svg)
    episode = named(name)
    episode = dataclasses.replace(
        episode, settings=dataclasses.replace(episode.settings, backend=name), truncated=True
    )
    for suffix in ("html", "svg"):
        replay_of(episode, beside=episode).save(folder / f"replay.{suffix}")
    scores = scores_of([GOOD] * 2)
    save_svg(scores_figure({"Agents": {name: scores, f"{name}2": scores}}), folder / "scores.svg")


class _Found(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.nodes: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.nodes += executable(tag, dict(attrs))

    handle_startendtag = handle_starttag


def executable(tag: str, attributes: dict[str, Any]) -> Iterator[str]:
    """Yield the parts of an element that a browser would run or load."""
    if tag.lower() in SCRIPT_TAGS:
        yield tag
    for key, value in attributes.items():
        target = "".join(str(value).split()).lower()
        is_link = key.lower() in LINKS and not target.startswith(("#", "data:image/", "data:,"))
        if key.lower().startswith("on") or is_link:
            yield f"{tag} {key}"
        if key.lower() == "srcdoc":
            yield from _Found(str(value)).nodes


def executable_nodes(path: Path) -> list[str]:
    """Return the parts of a page or an SVG that a browser would run or load.

    Raises:
        ElementTree.ParseError: the SVG is not well-formed.
    """
    if path.suffix == ".html":
        return _Found(path.read_text(encoding="utf-8")).nodes
    return [
        node
        for element in ElementTree.parse(path).iter()
        for node in executable(
            element.tag.rpartition("}")[2],
            {key.rpartition("}")[2]: value for key, value in element.attrib.items()},
        )
    ]
