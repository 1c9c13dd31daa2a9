"""Names cannot do harm in any page or picture; ``bench_injection.py`` tries each of them alone."""

from pathlib import Path

import pytest
from helpers.documents import executable_nodes, write_documents
from helpers.pages import HOSTILE


@pytest.mark.filterwarnings("ignore:Glyph")  # matplotlib says when a font lacks a character
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


@pytest.mark.parametrize(
    "text",
    [
        "<script>1</script>", "<img src=x onerror=alert(1)>", "<a href=' java\nscript:1'>",
        "<iframe>", "<p/onclick=1>", "<img src='http://example.com'>",
    ],
)  # fmt: skip
def test_what_would_run_is_found(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.html").write_text(text)
    assert executable_nodes(tmp_path / "a.html")


def test_what_would_run_in_an_svg_is_found(tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'
        '<script/><a xlink:href="javascript:1"/><g onload="1"/><use xlink:href="#a"/></svg>'
    )
    assert executable_nodes(tmp_path / "a.svg") == ["script", "a href", "g onload"]
