"""A million changed inputs of all formats that are read; each format in a process of its own."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.fuzz import MAX_BYTES, MAX_SECONDS, Report

INPUTS = {
    "layout": 114_000, "map": 120_000, "LoRR map": 80_000, "LoRR problem": 30_000, "scen": 120_000,
    "tasks": 100_000, "agents": 80_000, "orders": 90_000, "plan": 60_000, "flags": 50_000,
    "names": 40_000, "given layout": 40_000, "grades": 25_000, "rubric": 10_000,
    "episode": 12_000, "fleet": 10_000, "q-table": 8_000, "ppo": 8_000, "results": 3_000,
}  # fmt: skip
"""Together 10^6; ``FUZZ_SHARE=0.1`` runs a tenth of each, and ``FUZZ_SEED`` other ones."""

SHARE, SEED = float(os.environ.get("FUZZ_SHARE", "1")), os.environ.get("FUZZ_SEED", "1")
TESTS = Path(__file__).parents[1]


@pytest.mark.parametrize("name", INPUTS)
def test_only_documented_errors(name: str, measured: Callable[[str, object], None]) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "helpers.fuzz", name, str(round(INPUTS[name] * SHARE)), SEED],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), str(TESTS.parent)])},
        stdout=subprocess.PIPE,
        check=True,
        text=True,
    )
    report = Report(*json.loads(done.stdout))
    measured(
        f"changed inputs of the format {name}",
        f"{report.inputs:,}: {report.accepted:,} accepted, {report.refused:,} refused with "
        f"documented errors; one at most {report.worst_seconds:.3f} s and "
        f"{report.worst_bytes / 2**20:.0f} MB",
    )
    assert report.worst_seconds <= MAX_SECONDS
    assert report.worst_bytes <= MAX_BYTES
