"""The command that measures steps per second: how it counts and what it prints."""

import sys

import pytest
from helpers.command_line import command, refusal

from agents.lab.commands import bench
from warehouse_core.extras import install_command


class Clock:
    """A clock that advances only when a ``Work`` runs."""

    def __init__(self) -> None:
        self.now = 0.0

    def work(self, steps: int, seconds: float) -> bench.Work:
        def work() -> int:
            self.now += seconds
            return steps

        return work


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(bench, "perf_counter", lambda: clock.now)
    return clock


def test_rates_are_steps_over_seconds_and_their_ratio(clock: Clock) -> None:
    pair = bench.Pair("ours", lambda: clock.work(30, 0.01), "theirs", lambda: clock.work(10, 0.02))
    rates = bench.measure(pair, seconds=0.5)
    assert rates.ours == pytest.approx(3000)
    assert rates.beside == pytest.approx(500)
    assert rates.ratio == pytest.approx(6)


def test_a_measurement_takes_about_the_given_time(clock: Clock) -> None:
    work = clock.work(1, 0.001)
    bench.measure(bench.Pair("ours", lambda: work, "theirs", lambda: work), seconds=1.0)
    # Two works, and a round to warm up.
    assert clock.now == pytest.approx(2 * (1 + 1 / bench.ROUNDS), rel=0.05)


def test_a_work_longer_than_its_time_runs_once(clock: Clock) -> None:
    slow = clock.work(5, 10.0)
    rates = bench.measure(bench.Pair("ours", lambda: slow, "theirs", lambda: slow), seconds=0.01)
    assert rates.ours == pytest.approx(0.5)


@pytest.mark.parametrize("pair", bench.PAIRS, ids=lambda each: each.form)
def test_every_form_can_be_stepped(pair: bench.Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("MAX_STEPS", "BATCH_STEPS"):
        monkeypatch.setattr(bench, name, 3)
    work = pair.make()
    assert work() == work() > 0


@pytest.mark.parametrize("make", [bench._lake, bench._carts])
def test_every_known_environment_can_be_stepped_over_the_end_of_its_episodes(
    make: object,
) -> None:
    assert callable(make)
    work = make()
    assert work() == work() > 0


def test_the_table_has_a_line_for_every_form(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bench, "measure", lambda pair, seconds: bench.Rates(1234.6, 100.0, 12.346))
    monkeypatch.setenv("COLUMNS", "80")
    result = command(capsys, "bench")
    assert result.code == 0
    cells = [line.split("│") for line in result.out.splitlines() if line.startswith("│")]
    assert [cell[1].strip() for cell in cells] == [pair.form for pair in bench.PAIRS]
    assert [cell[3].strip() for cell in cells] == [pair.beside for pair in bench.PAIRS]
    for cell in cells:
        assert [cell[place].strip() for place in (2, 4, 5)] == ["1,235", "100", "12.35"]


def test_a_missing_package_is_named_in_its_row_and_the_rest_is_measured(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "minigrid", None)
    monkeypatch.setattr(bench, "PAIRS", [bench.PAIRS[4], bench.PAIRS[0]])
    monkeypatch.setenv("COLUMNS", "200")
    result = command(capsys, "bench", "--seconds", "0.01")
    assert result.code == 0
    lines = [line for line in result.out.splitlines() if line.startswith("│")]
    assert "pictures" in lines[0]
    assert "not measured: minigrid" in lines[0]
    assert install_command("bench") in lines[0]
    assert "not measured" not in lines[1]


@pytest.mark.parametrize("seconds", ["0", "nan"])
def test_an_impossible_time_is_wrong_usage(
    seconds: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "--seconds" in refusal(capsys, "bench", "--seconds", seconds, code=2)
