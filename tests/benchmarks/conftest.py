"""Fixtures of the benchmarks: timing of two calls, and tables of the results.

``pytest tests/benchmarks/bench_fleet.py --measured`` replaces the table of the subject "fleet" in
``.github/MEASURED.md`` and keeps the tables of other subjects. With ``-k``, it replaces only the
rows that are measured.
"""

import re
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median

import pytest
from helpers.command_line import ROOT
from helpers.timing import seconds

ROUNDS = 7

TABLES = ROOT / ".github" / "MEASURED.md"
HEAD = """# Measured

Each table is written by the command above it.
"""
SECTION = re.compile(r"^## (\w+)\n.*?(?=^## |\Z)", flags=re.DOTALL | re.MULTILINE)
ROW = re.compile(r"^\| (?!measurement|---)(.*?) \| (.*) \|$", flags=re.MULTILINE)

FIGURES: dict[str, dict[str, str]] = {}
"""Results of this run by subject and name; the subject is in the name of the benchmark's file."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--measured", action="store_true", help=f"write tables into {TABLES.name}")


def pytest_sessionfinish(session: pytest.Session) -> None:
    if session.config.getoption("--measured"):
        for subject, figures in FIGURES.items():
            write_table(TABLES, subject, figures, is_whole=not session.config.option.keyword)


def write_table(
    path: Path, subject: str, figures: Mapping[str, str], *, is_whole: bool = True
) -> None:
    """Write the table of a subject, or only these rows of it; subjects are sorted."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    sections = {found[1]: found[0].rstrip() for found in SECTION.finditer(text)}
    known = {} if is_whole else dict(ROW.findall(sections.get(subject, "")))
    figures = known | dict(figures)
    rows = "\n".join(f"| {name} | {figure} |" for name, figure in figures.items())
    command = f"`pytest tests/benchmarks/bench_{subject}.py --measured`"
    head = "| measurement | result |\n| --- | --- |"
    sections[subject] = f"## {subject}\n\n{command}\n\n{head}\n{rows}"
    written = "\n\n".join(section for _, section in sorted(sections.items()))
    path.write_text(f"{HEAD}\n{written}\n", encoding="utf-8")


@pytest.fixture
def measured(request: pytest.FixtureRequest, capsys) -> Callable[[str, object], None]:
    """Return a function that prints a result, and keeps it for the table of its subject."""
    subject = request.path.stem.removeprefix("bench_")

    def report(name: str, result: object) -> None:
        with capsys.disabled():
            print(f"\n{name}: {result}")
        FIGURES.setdefault(subject, {})[name] = str(result)

    return report


@pytest.fixture
def processor_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let planners measure CPU time, so that other programs do not use up their time."""
    for name, module in list(sys.modules.items()):
        if name.startswith("agents.mapf.") and hasattr(module, "perf_counter"):
            monkeypatch.setattr(module, "perf_counter", time.process_time)
    monkeypatch.setattr(time, "perf_counter", time.process_time)


@pytest.fixture
def times_faster(benchmark, capsys):
    """Return a function that measures how many times faster ``ours`` is than ``baseline``.

    Both run once without being measured, and then alternately; the result is the median of the
    ratios. It is printed, and stored with the results of pytest-benchmark for ``ours``.
    """

    def measure(
        ours: Callable[[], object], baseline: Callable[[], object], rounds: int = ROUNDS
    ) -> float:
        ours(), baseline()
        pairs = [(seconds(ours), seconds(baseline)) for _ in range(rounds)]
        ratio = median(theirs / mine for mine, theirs in pairs)
        benchmark.extra_info["times faster than the baseline"] = round(ratio, 2)
        with capsys.disabled():
            mine, theirs = (median(column) for column in zip(*pairs, strict=True))
            print(f"\n{benchmark.name}: {mine:.3g} s to {theirs:.3g} s, ratio {ratio:.2f}")
        benchmark.pedantic(ours, rounds=1)
        return ratio

    return measure
