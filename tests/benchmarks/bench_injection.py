"""Names with markup, scripts and control characters, in every page and picture that is written."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.documents import executable_nodes, write_documents
from helpers.pages import HOSTILE


@pytest.mark.filterwarnings("ignore:Glyph")  # matplotlib says when a font lacks a character
def test_no_name_is_run_and_every_svg_is_well_formed(
    tmp_path: Path, measured: Callable[[str, object], None]
) -> None:
    plain = tmp_path / "plain"
    plain.mkdir()
    write_documents(plain, "A plain name")
    expected = {path.name: executable_nodes(path) for path in plain.glob("*.[hs][tv]*")}
    names = [*HOSTILE, " ".join(HOSTILE)]
    kinds: Counter[str] = Counter()
    more = 0
    for number, name in enumerate(names):
        folder = tmp_path / str(number)
        folder.mkdir()
        write_documents(folder, name)
        for file, nodes in expected.items():
            found = executable_nodes(folder / file)
            more += sum((Counter(found) - Counter(nodes)).values())
            kinds[Path(file).suffix] += 1
    measured(
        f"{len(names)} names with markup, scripts and control characters",
        f"{kinds['.html']} pages, {kinds['.svg']} SVGs, all well-formed; {more} executable nodes",
    )
    assert more == 0
