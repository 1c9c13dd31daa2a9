"""Changed inputs of every format raise documented errors only; see also ``bench_fuzz.py``."""

from pathlib import Path

import pytest
from helpers.fuzz import formats, fuzz


@pytest.mark.parametrize("name", formats())
def test_changed_inputs_are_read_or_refused(name: str) -> None:
    report = fuzz(name, 30 if name == "results" else 80, seed=2)
    assert report.accepted > 0
    assert report.refused > report.accepted


@pytest.mark.parametrize("name", sorted(formats().keys() - {"archive", "grades", "results"}))
def test_a_missing_file_is_an_os_error(name: str, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="missing"):
        formats()[name].read(tmp_path / "missing")
