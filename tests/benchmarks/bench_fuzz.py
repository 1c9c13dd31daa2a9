"""A million mutated inputs in all formats, and hostile names in all pages."""

import os
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.documents import executable_nodes, write_documents
from helpers.fuzz import fuzz
from helpers.hostile import bounded_memory
from helpers.pages import HOSTILE

INPUTS = {
    "layout": 160_000, "map": 160_000, "scen": 160_000, "orders": 120_000, "plan": 80_000,
    "flags": 70_000, "names": 60_000, "given layout": 60_000, "grades": 35_000, "late": 24_000,
    "rubric": 15_000, "archive": 10_000, "episode": 14_000, "fleet": 12_000, "q-table": 8_000,
    "ppo": 8_000, "results": 4_000,
}  # fmt: skip
"""Number of inputs in each format.

``FUZZ_SHARE=0.1`` runs a tenth of them, and ``FUZZ_SEED`` selects other inputs.
"""

SHARE, SEED = float(os.environ.get("FUZZ_SHARE", "1")), int(os.environ.get("FUZZ_SEED", "1"))
MAX_SECONDS = 2.0


@pytest.mark.parametrize("name", INPUTS)
def test_only_documented_errors(name: str, measured: Callable[[str, object], None]) -> None:
    with bounded_memory():
        report = fuzz(name, round(INPUTS[name] * SHARE), SEED)
    measured(
        f"mutated inputs in the format {name}",
        f"{report.inputs:,} inputs: {report.accepted:,} accepted, {report.refused:,} refused with "
        f"documented errors; at most {report.worst_seconds:.3f} s per input",
    )
    assert report.worst_seconds <= MAX_SECONDS


@pytest.mark.filterwarnings("ignore:Glyph")  # matplotlib warns if a font lacks a character
def test_no_name_is_run_and_every_svg_is_well_formed(
    tmp_path: Path, measured: Callable[[str, object], None]
) -> None:
    """The names contain markup, scripts and control characters."""
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
