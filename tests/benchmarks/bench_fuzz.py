"""A million mutated inputs in all formats."""

import os
from collections.abc import Callable

import pytest
from helpers.fuzz import fuzz
from helpers.hostile import bounded_memory

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
