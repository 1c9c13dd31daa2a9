"""Helpers for tests of reports: a page with every part, and hostile names."""

from typing import Any

from agents.lab.console.table import TextTable
from agents.lab.experiments.case import make_case
from agents.lab.parameters import shown
from agents.lab.reports.answers import Answer
from agents.lab.reports.examples import Example
from agents.lab.reports.figures import Picture
from agents.lab.reports.page import Page, Section
from helpers.pictures import named
from warehouse_core.viz.tracks import track_of_record

HOSTILE = (
    "<script>alert(1)</script>",
    "</title></style><script>document.title = 'owned'</script>",
    '"><img src=x onerror=alert(1)>',
    "' autofocus onfocus=alert(1) x='",
    "--><script>alert(1)</script><!--",
    "$\\frac{",
    "{{7*7}} {% raw %} {# gone #}",
    "javascript:alert(1)",
    "data:text/html,<script>alert(1)</script>",
    "]]><svg onload=alert(1)>",
    "</svg><script>alert(1)</script>",
    "<![CDATA[<script>alert(1)</script>]]>",
    "<!--#exec cmd='id'--!><iframe srcdoc='<script>alert(1)</script>'>",
    "<?xml-stylesheet href='javascript:alert(1)'?><!DOCTYPE x [<!ENTITY e SYSTEM 'file:///etc'>]>",
    "&lt;script&gt;&#60;script&#x3e;&e;&\x00amp;",
    "<a href=' java\nscript:alert(1)'>x</a><base href='javascript:/'>",
    "<math><mi xlink:href='javascript:alert(1)'><form action=javascript:alert(1)><button>",
    "\x00<scr\x00ipt>alert(1)</script\x0b>",
    "a\x1b]0;owned\x07\x1b[2J\x9b31mb\r\x08\x7f",
    "\u202e\u2066<script>\u2069\u200f\u061c",
    "\ud800<\udfff\ufffe\uffff\ufdd0",
    "--\x2d-->\u2028\u2029\x85<script>--",
    "$x$ $\\includegraphics{a}$ %s {0} \\N{DIGIT ONE}",
)
"""Markup, scripts, event handlers, URLs, ends of comments and CDATA, entities, templates, control
characters, bidi marks, NUL, lone surrogates and noncharacters."""


def loaders(address: str) -> str:
    """Return HTML that loads something by every means that needs no click."""
    return (
        f'<img src="{address}/img"><script src="{address}/script"></script>'
        f'<link rel="stylesheet" href="{address}/style"><iframe src="{address}/frame"></iframe>'
        f'<object data="{address}/object"></object><video src="{address}/video" autoplay></video>'
        f'<div style="background: url({address}/background)">x</div>'
        f"<script>document.title = 'owned'; fetch('{address}/fetch')</script>"
        f"<img src=x onerror=\"document.title = 'owned'\">"
    )


SVG = (
    b'<svg xmlns="http://www.w3.org/2000/svg" width="300" height="100">'
    b'<rect width="300" height="100" fill="#ff00ff"/></svg>'
)


def found(mode: str = "oscillation", **changes: Any) -> Example:
    """Return an example of a failure mode."""
    return Example(
        **{  # type: ignore[arg-type]
            "mode": mode,
            "case": make_case({"escape": False, "battery": 60}),
            "seed": 1234,
            "steps": 57,
            "episodes": 4321,
            **changes,
        }
    )


def a_page(**changes: Any) -> Page:
    """Return a page in which every part has content, with changed parts by title."""
    rows = [("greedy", "12.5"), ("mine", shown(None)), ("other", "7")]
    example = found(sentence="swung to and fro", track=track_of_record(named("A robot")))
    parts: dict[str, Any] = {
        "Answers": [Answer("Is it so?", "It is.", ("Mostly.",)), Answer("And that?", "No.", ())],
        "Figures": [Picture("success", "A caption", SVG)],
        "Examples": [example],
        "Settings": [TextTable((), [("escape", "on, off"), ("memory", "5")])],
        "Cases": [TextTable(("agent", "steps"), rows, caption="A note")],
    }
    sections = [Section(title, each, "A note") for title, each in (parts | changes).items()]
    return Page("A title", ["A summary"], sections, "The methods")


def a_page_of(name: str, svg: bytes = SVG) -> Page:
    """Return a page in which every text is ``name``."""
    case = {**make_case({}), "agent": name, "layout": name, name: name}
    parts = [
        Answer(name, name, (name, name)),
        Picture(name, name, svg),
        TextTable((), [(name, name)]),
        TextTable((name, name), [(name, name)], caption=name),
        found(name, case=case, sentence=name, track=track_of_record(named(name))),
        found(name, case=case, sentence=name),
    ]
    return Page(name, [name], [Section(name, parts, name)], name)
