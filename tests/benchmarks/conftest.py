"""What the benchmarks share: timing of two calls, and the table of what has been measured.

``pytest tests/benchmarks/bench_*.py --measured`` writes the figures into ``.github/MEASURED.md``;
those of benchmarks that were not run stay.
"""

import sys
import time
from collections.abc import Callable
from statistics import median

import pytest
from helpers.command_line import ROOT
from helpers.timing import seconds

ROUNDS = 7

TABLE = ROOT / ".github" / "MEASURED.md"
HEAD = """# Measured

Written by `pytest tests/benchmarks/bench_*.py --measured`; each line names its file.

| what | figure | by |
| --- | --- | --- |
"""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--measured", action="store_true", help=f"write the figures into {TABLE.name}")


def write_measured(what: str, figure: str, by: str) -> None:
    """Write a line of the table, in place of an earlier one of the same name."""
    lines = TABLE.read_text().splitlines()[HEAD.count("\n") :] if TABLE.exists() else []
    table = {line.split(" | ")[0]: line for line in lines}
    table[f"| {what}"] = f"| {what} | {figure} | `{by}` |"
    TABLE.write_text(HEAD + "".join(f"{line}\n" for line in table.values()))


@pytest.fixture
def measured(request: pytest.FixtureRequest, capsys) -> Callable[[str, object], None]:
    """Return a function that prints a figure, and writes it into the table if that is asked for."""

    def say(what: str, figure: object) -> None:
        with capsys.disabled():
            print(f"\n{what}: {figure}")
        if request.config.getoption("--measured"):
            write_measured(what, str(figure), request.path.name)

    return say


@pytest.fixture
def processor_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let planners look at the processor's time, so that other programs take none of theirs."""
    for name, module in list(sys.modules.items()):
        if name.startswith("agents.mapf.") and hasattr(module, "perf_counter"):
            monkeypatch.setattr(module, "perf_counter", time.process_time)
    monkeypatch.setattr(time, "perf_counter", time.process_time)


@pytest.fixture
def times_faster(benchmark, capsys):
    """Return a function that measures how many times faster ``ours`` is than ``baseline``.

    Both run once unmeasured and then in turn; the median of the ratios counts. The ratio is
    printed, and stored with the figures of pytest-benchmark for ``ours``.
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
