"""Kernels give the same results compiled with Numba and in plain Python, bit for bit."""

import os
import subprocess
import sys

import pytest
from helpers.command_line import ROOT

pytestmark = pytest.mark.compiled


def digests(fast: str) -> list[str]:
    """Return the printed plans of another process, after the form of its kernels."""
    done = subprocess.run(
        [sys.executable, "-m", "helpers.kernel_digests"],
        cwd=ROOT / "tests",
        env={**os.environ, "WAREHOUSE_FAST": fast, "PYTHONPATH": os.pathsep.join([str(ROOT), "."])},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.splitlines()


def test_both_forms_give_the_same_plans() -> None:
    plain, compiled = digests("0"), digests("1")
    assert (plain[0], compiled[0]) == ("plain", "compiled")
    assert len(plain) > 30
    assert plain[1:] == compiled[1:]
