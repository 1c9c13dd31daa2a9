"""The pages of the handbook as notebooks that run in a browser, by JupyterLite.

``sphinx-build -t live`` adds one for each page with cells to the site, and a link to it to the
page; the extra ``lite`` has what that needs. All is served with the site, nothing from elsewhere.
"""

from __future__ import annotations

import ast
import base64
import json
import mimetypes
import re
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jupytext
from nbformat import v4

from agents.lab.playground.packages import KERNEL, write_packages
from agents.lab.playground.runtime import SERVER

HANDBOOK = Path(__file__).parent

FOLDER = "live"
"""Folder of the notebooks in the site."""

RUNTIME = "static/pyodide"
"""Folder of Pyodide in ``FOLDER``."""

KERNEL_FILE = "kernel.js"
"""File in ``RUNTIME`` that the kernel runs: Pyodide, and ``live_kernel.js``."""

UNNEEDED = ("jedi", "ssl")
"""Packages that the kernel would load, and pages do not need; they make a page load longer."""

EXTENSION = "@jupyterlite/pyodide-kernel-extension"

SERVICE_WORKER = "@jupyterlite/application-extension:service-worker-manager"
"""Part of JupyterLite that keeps the files of cells in the browser. Python does not find modules
that a cell writes there, and each look at a file takes long; without it files are in memory.
"""

SPEC = {"name": "python", "display_name": "Python (Pyodide)", "language": "python"}
"""Kernel of JupyterLite."""

ADDRESS = f"{FOLDER}/notebooks/index.html?path={{page}}.ipynb"

LINK = (
    '<p class="live"><a href="{address}">Open live</a>: the cells of this page run in the browser, '
    "with nothing installed.</p>"
)

NOTICE = """\
*This page runs in your browser. Click on a cell and press Shift and Enter; the first one takes
longer, because Python is loaded. Commands of a terminal need an installation.*"""

COMMANDS = "commands are processes, which a browser does not have"
GRADES = "the episodes of a grade are processes, which a browser does not have"
DATA = "Minari needs h5py, which is not served with this page"
BODIES = "bodies need Pymunk, which is not made for browsers"

NOT_THERE = {
    "!warehouse": COMMANDS,
    "my_distance.py": f"a command writes this file, and {COMMANDS}",
    "find_submission": GRADES,
    "report.grades": GRADES,
    "minari": DATA,
    "MINARI": DATA,
    "recover_environment(": DATA,
    "in data]": DATA,
    "EvenInfos": DATA,
    "physics": BODIES,
    "Rigid": BODIES,
    "RobotSpec": BODIES,
}
"""Why a cell does not run in a browser, by a part of it."""

LOADING = {
    "replay_animation(": "import matplotlib",
    "import gymnasium": "import warehouse_core.gymnasium_env",
    "most_deliveries(": "import scipy",
}
"""Import that loads a package, by a part of the cells that need the package without importing it;
a cell with this import stands before the first of them.
"""

CELL = "```{code-cell}"
TITLE = re.compile(r"^# (.*)$", flags=re.MULTILINE)
TEST = re.compile(r"<!-- test\n.*?^-->\n*", flags=re.DOTALL | re.MULTILINE)
SITE_ONLY = re.compile(r"^(`{3,})\{(?:only|toctree)\}.*?^\1$\n*", flags=re.DOTALL | re.MULTILINE)
INCLUDED = re.compile(
    r"^```{literalinclude} (\S+)\n(?::language: .*\n)?:pyobject: (\w+)$", flags=re.M
)
PICTURE = re.compile(r"(!\[[^]]*\])\((\S+)\)")
PAGE_LINK = re.compile(r"(?<!!)\[([^]]*)\]\((\w+)\.md[^)]*\)")


def setup(app: Any) -> None:
    """Call the functions below where Sphinx writes pages."""
    app.add_config_value("pyodide", SERVER, "html")
    app.connect("html-page-context", add_link)
    app.connect("build-finished", add_notebooks)


def pages() -> list[Path]:
    """Return the pages that have cells."""
    every = sorted(HANDBOOK.glob("*.md"))
    return [page for page in every if CELL in page.read_text(encoding="utf-8")]


def add_link(_app: Any, page: str, _template: str, context: dict[str, Any], _tree: Any) -> None:
    """Add a link to the notebook of a page below its title."""
    if page in {each.stem for each in pages()}:
        link = LINK.format(address=context["pathto"](ADDRESS.format(page=page), 1))
        context["body"] = context["body"].replace("</h1>", f"</h1>\n{link}", 1)


def add_notebooks(app: Any, error: Exception | None) -> None:
    """Add the notebooks to a site that is built."""
    if error is None and app.builder.format == "html":
        write_notebooks(Path(app.outdir) / FOLDER, app.config.pyodide)


def write_notebooks(folder: Path, pyodide: str) -> None:
    """Write JupyterLite with the notebooks of all pages, and Pyodide, into a folder.

    Args:
        folder: folder of the notebooks; what was in it is replaced.
        pyodide: place of Pyodide's files, as for ``write_packages``.

    Raises:
        PyodideError: as ``write_packages``.
        CalledProcessError: JupyterLite cannot be built.
        OSError: the folder cannot be written.
    """
    with TemporaryDirectory() as place:
        contents = Path(place, "contents")
        contents.mkdir()
        for page in pages():
            text = json.dumps(notebook_of(page), indent=1)
            (contents / f"{page.stem}.ipynb").write_text(text, encoding="utf-8")
        for name, settings in _settings(folder, contents).items():
            Path(place, name).write_text(json.dumps(settings), encoding="utf-8")
        words = [sys.executable, "-m", "jupyterlite_core", "build"]
        subprocess.run(words, cwd=place, check=True, capture_output=True)
    runtime = folder / RUNTIME
    write_packages(runtime, pyodide)
    parts = [runtime / "pyodide.js", HANDBOOK / "live_kernel.js"]
    text = "\n".join(part.read_text(encoding="utf-8") for part in parts)
    (runtime / KERNEL_FILE).write_text(text, encoding="utf-8")


def _settings(folder: Path, contents: Path) -> dict[str, Any]:
    """Return the settings of JupyterLite by the names of their files."""
    extension = Path(sysconfig.get_path("data"), "share", "jupyter", "labextensions", EXTENSION)
    kernel = {
        "pyodideUrl": f"./{RUNTIME}/{KERNEL_FILE}",
        "disablePyPIFallback": True,
        # The kernel installs what is not named here.
        "loadPyodideOptions": {"packages": [*KERNEL, *UNNEEDED], "unneeded": UNNEEDED},
    }
    return {
        "jupyter_lite_config.json": {
            "LiteBuildConfig": {
                "apps": ["notebooks"],
                "contents": [str(contents)],
                "output_dir": str(folder.resolve()),
                # Others in the environment may be for another JupyterLab.
                "ignore_sys_prefix": ["federated_extensions"],
                "federated_extensions": [str(extension)],
                "no_sourcemaps": True,
            }
        },
        # All cells are in the page, so that players go on when they are scrolled out of sight.
        "overrides.json": {"@jupyterlab/notebook-extension:tracker": {"windowingMode": "none"}},
        "jupyter-lite.json": {
            "jupyter-lite-schema-version": 0,
            "jupyter-config-data": {
                "disabledExtensions": [SERVICE_WORKER],
                "litePluginSettings": {f"{EXTENSION}:kernel": kernel},
            },
        },
    }


def notebook_of(page: Path) -> Any:
    """Return a page as a notebook. Cells that a browser cannot run are text, with the reason."""
    cells = [v4.new_markdown_cell(NOTICE)]
    waiting = dict(LOADING)
    for cell in jupytext.read(page).cells:
        if reason := reason_of(cell):
            text = f"```python\n{cell.source}\n```\n\n*Not here: {reason}.*"
            cells.append(v4.new_markdown_cell(text))
        elif cell.cell_type == "code":
            needed = [part for part in waiting if part in cell.source]
            cells += [v4.new_code_cell(waiting.pop(part)) for part in needed]
            cells.append(v4.new_code_cell(cell.source))
        else:
            cells += _texts(cell.source, page.parent)
    return v4.new_notebook(cells=cells, metadata={"kernelspec": SPEC})


def reason_of(cell: Any) -> str | None:
    """Return why a browser cannot run a cell of code; of others and if it can, ``None``."""
    reasons = (why for part, why in NOT_THERE.items() if part in cell.source)
    return next(reasons, None) if cell.cell_type == "code" else None


def _texts(source: str, folder: Path) -> Iterator[Any]:
    """Yield a cell of Markdown, unless all of it is for the site only.

    Links to other pages become words: a notebook does not know where it is in the site.
    """
    text = SITE_ONLY.sub("", TEST.sub("", source))
    text = INCLUDED.sub(lambda found: f"```python\n{_part(folder / found[1], found[2])}", text)
    text = PAGE_LINK.sub(lambda found: found[1] or _title(folder / f"{found[2]}.md"), text).strip()
    files = [folder / name for _, name in PICTURE.findall(text)]
    text = PICTURE.sub(lambda found: f"{found[1]}(attachment:{Path(found[2]).name})", text)
    if text:
        yield v4.new_markdown_cell(text, attachments=dict(map(_attached, files)))


def _part(file: Path, name: str) -> str:
    """Return the source of a function or a class in a file."""
    source = file.read_text(encoding="utf-8")
    [node] = [each for each in ast.parse(source).body if getattr(each, "name", "") == name]
    return str(ast.get_source_segment(source, node))


def _title(page: Path) -> str:
    [title, *_] = TITLE.findall(page.read_text(encoding="utf-8"))
    return str(title)


def _attached(file: Path) -> tuple[str, dict[str, str]]:
    """Return a picture as an attachment of a cell: its name, and its bytes by its type."""
    kind, _ = mimetypes.guess_type(file)
    return file.name, {str(kind): base64.b64encode(file.read_bytes()).decode()}
