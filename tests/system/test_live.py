"""The pages of the handbook as notebooks for a browser, and their packages, without Pyodide."""

import json
from pathlib import Path
from typing import Any

import jupytext
import pytest
from helpers.handbook import HANDBOOK

from agents.handbook import live
from agents.lab.playground import packages
from agents.lab.playground.runtime import digest_of


def sources(page: Path, kind: str) -> list[str]:
    return [cell.source for cell in live.notebook_of(page).cells if cell.cell_type == kind]


@pytest.mark.parametrize("page", live.pages(), ids=lambda page: page.stem)
def test_a_notebook_has_the_cells_of_its_page_or_says_why_not(page: Path) -> None:
    read = [cell for cell in jupytext.read(page).cells if cell.cell_type == "code"]
    runs = [cell.source for cell in read if live.reason_of(cell) is None]
    added = live.LOADING.values()
    assert [each for each in sources(page, "code") if each not in added] == runs
    text = "\n".join(sources(page, "markdown"))
    for cell in read:
        if reason := live.reason_of(cell):
            assert f"{cell.source}\n```\n\n*Not here: {reason}.*" in text
    for only_of_the_site in (".md)", ".md#", "```{", "<!-- test", "../.github"):
        assert only_of_the_site not in text


def test_a_notebook_has_what_its_page_includes() -> None:
    text = "\n".join(sources(HANDBOOK / "agents.md", "markdown"))
    assert "```python\nclass ReflexAgent" in text
    cells = live.notebook_of(HANDBOOK / "planning.md").cells
    [pictures] = [cell.attachments for cell in cells if cell.get("attachments")]
    assert list(pictures["lanes.png"]) == ["image/png"]
    code = sources(HANDBOOK / "planning.md", "code")
    after = code[code.index("import scipy") + 1]
    assert "most_deliveries(" in after


def test_the_lock_names_what_is_served_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source, folder = tmp_path / "source", tmp_path / "served"
    source.mkdir()
    needs: dict[str, list[str]] = {name: [] for name in ("numpy", "pillow", "pandas", "six")}
    ours = packages.INSTALLED.keys()
    needs |= {name: [] for name in {*packages.KERNEL, *packages.IMPORTED, "pytz"} - ours}
    needs["matplotlib"] = ["numpy", "Six", "pytz"]
    known: dict[str, Any] = {}
    for name, depends in needs.items():
        (source / f"{name}.whl").write_text(name)
        digest = digest_of(name.encode())
        known[name] = {"file_name": f"{name}.whl", "sha256": digest, "depends": depends}
    lock = json.dumps({"packages": known})
    (source / packages.LOCK).write_text(lock)
    monkeypatch.setattr(packages, "FILES", {packages.LOCK: digest_of(lock.encode())})
    monkeypatch.setattr(packages, "SCRIPT", {})
    packages.write_packages(folder, str(source))
    written = json.loads((folder / packages.LOCK).read_text())["packages"]
    assert written.keys() == {*needs, *packages.INSTALLED} - {"pandas"}
    files = {each["file_name"] for each in written.values()}
    assert {file.name for file in folder.iterdir()} == {*files, packages.LOCK}
    for each in written.values():
        assert digest_of((folder / each["file_name"]).read_bytes()) == each["sha256"]
        assert {need.lower() for need in each["depends"]} <= written.keys() - packages.APART
