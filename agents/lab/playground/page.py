"""The folder of the playground, with all files that a web server must serve."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

from agents.lab.grading.rubric import Rubric, load_rubric, own_rubrics
from agents.lab.place import Stations
from agents.lab.playground.runtime import SERVER, copy_runtime
from agents.lab.playground.wheel import write_wheel
from warehouse_core.files.atomic import atomic_path
from warehouse_core.render.palette import style_rules
from warehouse_core.viz.player import page as player
from warehouse_core.world.named_layouts import NAMES, find_layout

FOLDER = files("agents.lab.playground")

SCRIPTS = ("editor.js", "main.js", "painter.js", "python.js", "share.js", "worker.js")

RUNTIME = "pyodide"
"""Folder of Pyodide's files, next to the page."""

LARGEST = 40, 60
"""Limits on the rows and columns of layouts on the page, where larger ones cannot be painted."""


def write_playground(
    folder: Path, source: str = SERVER, advance: Callable[[], None] = lambda: None
) -> None:
    """Write the page to a folder, which is created if it is missing.

    Args:
        folder: folder of the page. Files of an earlier page are replaced; others are kept.
        source: folder or address of Pyodide's files, see ``copy_runtime``.
        advance: function that is called after each of Pyodide's files.

    Raises:
        PyodideError: see ``copy_runtime``.
        OSError: the folder cannot be written.
    """
    copy_runtime(source, folder / RUNTIME, advance)
    for name in SCRIPTS:
        _write(folder / name, _text(name))
    _write(folder / "floor.js", player.floor_module())
    _write(folder / "page.css", style_rules() + _text("page.css"))
    # The text of a script must not contain the end of its element.
    settings = json.dumps(_settings(write_wheel(folder))).replace("<", "\\u003c")
    page = _text("page.html").replace("{policy}", _policy()).replace("{settings}", settings)
    _write(folder / "index.html", page)


def _text(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")


def _write(target: Path, text: str) -> None:
    with atomic_path(target) as part:
        part.write_text(text, encoding="utf-8")


def _settings(wheel: str) -> dict[str, object]:
    layouts = {name: list(find_layout(name).rows) for name in NAMES}
    height, width = LARGEST
    return {
        "wheel": wheel,
        "exercises": {
            name: exercise_settings(load_rubric(file)) for name, file in own_rubrics().items()
        },
        "layouts": {
            name: rows
            for name, rows in layouts.items()
            if len(rows) <= height and len(rows[0]) <= width
        },
    }


def exercise_settings(rubric: Rubric) -> dict[str, object]:
    """Return the data of an exercise for the page; without episodes there is no layout."""
    shown: dict[str, object] = {
        "title": rubric.title,
        "starter": rubric.starter.read_text(encoding="utf-8"),
    }
    if case := rubric.first_case:
        layout = case.layout_of(case.first_seed)
        shown["rows"] = layout.rows
        shown["drawn"] = case.stations_of(layout) is Stations.DRAWN
    return shown


def _policy() -> str:
    """Return the Content-Security-Policy of the page, which allows the player in its frame."""
    return (
        "default-src 'none'; connect-src 'self'; worker-src 'self'; img-src data:; "
        f"script-src 'self' 'wasm-unsafe-eval' {player.digest(player.script())}; "
        f"style-src 'self' {player.digest(player.style())}; base-uri 'none'; form-action 'none'"
    )
