"""Kernels give the same plans bit for bit, compiled by Numba or not."""

import os
import subprocess
import sys

import pytest
from helpers.command_line import ROOT


@pytest.mark.fast
def test_compiled_kernels_do_what_plain_python_does() -> None:
    def digest(fast: str) -> list[str]:
        environment = os.environ | {"WAREHOUSE_FAST": fast, "PYTHONPATH": str(ROOT / "tests")}
        command = [sys.executable, "-m", "helpers.kernel_digest"]
        found = subprocess.run(
            command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True
        )
        return found.stdout.split()

    (plain, of_plain), (compiled, of_compiled) = digest("0"), digest("1")
    assert (plain, compiled) == ("plain", "compiled")
    assert of_plain == of_compiled
