"""Names cannot do harm in any page or picture."""

from pathlib import Path

import pytest
from helpers.documents import executable_nodes, write_documents
from helpers.pages import HOSTILE


@pytest.mark.filterwarnings("ignore:Glyph")  # matplotlib warns if a font lacks a character
@pytest.mark.usefixtures("small_pictures")
def test_hostile_names_add_nothing_that_runs(tmp_path: Path) -> None:
    found = []
    for folder, name in (("plain", "A name"), ("hostile", " ".join([*HOSTILE, "\x1b"]))):
        (tmp_path / folder).mkdir()
        write_documents(tmp_path / folder, name)
        paths = sorted((tmp_path / folder).glob("*.[hs][tv]*"))
        found.append({path.name: executable_nodes(path) for path in paths})
    assert found[0] == found[1]
    assert {"page.html", "report.html", "success.svg", "modes.svg", "scores.svg"} <= found[0].keys()
    assert [name for name, nodes in found[0].items() if nodes] == ["page.html", "replay.html"]
