"""The command ``warehouse sweep``: finished episodes are kept however it ends, and it resumes."""

import io
import os
import re
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.results_files import fleet_row, outcomes
from helpers.sweeps import (
    AGENT,
    Here,
    Sweep,
    check_is_usable,
    kill_sweeps,
    table,
    uninterrupted,
    words,
)
from helpers.terminal import Terminal

from agents.lab.experiments import sweep as sweep_command
from agents.lab.experiments.case import make_case
from agents.lab.experiments.plan import SweepPlan
from agents.lab.experiments.store import Store
from agents.lab.experiments.sweep import sweep_bar
from agents.lab.parameters import PARAMETERS
from agents.lab.runs.programs import program_for
from agents.lab.trials.rows import AnyRow, FleetRow, Row
from warehouse_core.batch.fleet_settings import MAX_BODIES
from warehouse_core.world.generators import MAX_DENSITY


@pytest.fixture
def path(tmp_path: Path) -> Iterator[Path]:
    yield tmp_path / "r.sqlite"
    # After the file has been closed, no other files are left.
    assert {each.name for each in tmp_path.iterdir()} <= {"r.sqlite", "expected.sqlite"}


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the episodes of commands in this process; workers run them by the same function."""
    monkeypatch.setattr(sweep_command, "Processes", lambda count: nullcontext(Here()))


@pytest.fixture(autouse=True)
def no_sweep_is_left() -> Iterator[None]:
    """Kill the sweeps of a test that has failed."""
    yield
    while Sweep.started:
        process = Sweep.started.pop().process
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def test_a_sweep_counts_stored_episodes_and_adds_missing_ones(
    warehouse: Warehouse, path: Path, tmp_path: Path, here: None
) -> None:
    assert warehouse(*words(path, 3)) == (
        0,
        f"4 combinations, 3 episodes each, 0 done\n"
        f"12 episodes done; see the results with: warehouse report {path}\n",
        "",
    )
    before = path.read_bytes()
    assert "12 done\n" in warehouse(*words(path, 3)).out
    assert path.read_bytes() == before
    assert "5 episodes each, 12 done\n20 episodes" in warehouse(*words(path, 5)).out
    assert table(path) == uninterrupted(tmp_path / "expected.sqlite", 5)


def test_all_combinations_are_in_the_file_in_order_before_the_first_episode(
    warehouse: Warehouse, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []

    def interrupted(plan: SweepPlan, store: Store, *_: object) -> None:
        found.append((plan.cases, [*store.cases().values()]))
        raise KeyboardInterrupt

    monkeypatch.setattr(sweep_command, "run_missing", interrupted)
    assert warehouse(*words(path, 3)).code == 130
    [(planned, stored)] = found
    assert stored == [*planned]


def test_a_sweep_adds_nothing_to_what_another_program_has_begun(
    refused: Refused, path: Path, here: None
) -> None:
    with Store(path) as store:
        store.add(store.case_id(make_case({})), [outcomes("d")[0]], "an older one")
    more = ("sweep", "-n", 3, "-o", path, "--jobs", 1)
    assert refused(*more) == (
        f"{path}: the episodes with the defaults were run by an older one, and new ones would be "
        f"run by {program_for('grid')}; write to another file"
    )
    assert len(table(path)) == 1


def test_flags_and_options_override_the_plan_file(
    warehouse: Warehouse, tmp_path: Path, here: None
) -> None:
    plan, path = tmp_path / "plan.toml", tmp_path / "r.sqlite"
    plan.write_text("episodes = 50\nseed = 7\n[settings]\nbattery = [20, 30]\nmemory = [1, 2]\n")
    warehouse("sweep", plan, "-n", 2, "--set", "battery=40", "-o", path, "--jobs", 1)
    with Store(path, read_only=True) as store:
        cases = [(case["battery"], case["memory"]) for case in store.cases().values()]
        assert sorted(cases) == [(40, 1), (40, 2)]
        assert {seed for (seed,) in store.query("SELECT seed FROM episodes")} == {7, 8}


def test_a_killed_sweep_loses_and_repeats_no_rows(path: Path, tmp_path: Path) -> None:
    """``bench_sweep.py`` kills one 100 times, and one of fleets."""
    episodes = 400
    assert kill_sweeps(path, episodes, 1) == 1
    before = table(path)
    assert before
    sweep = Sweep(path, episodes)
    code, out, err = sweep.end()
    assert (code, err) == (0, "")
    assert f" {len(before):,} done\n" in out
    assert table(path) == uninterrupted(tmp_path / "expected.sqlite", episodes)


def test_an_interrupted_sweep_prints_one_line_and_can_be_resumed(path: Path) -> None:
    sweep = Sweep(path, 100_000)
    sweep.wait_for_rows()
    for _ in range(20):
        with suppress(ProcessLookupError):
            os.killpg(sweep.process.pid, signal.SIGINT)  # as a terminal does
        time.sleep(0.005)
    code, out, err = sweep.end()
    assert (code, err) == (130, "warehouse: interrupted\n")
    check_is_usable(path)
    left = f"{len(table(path)):,} of 400,000 episodes in {path}"
    assert f"\n{left}; run the same command again to resume\n" in out


DEADLY = """
        if self.seed == 13:
            os.kill(os.getpid(), 9)  # as a system that runs out of memory does
        if self.seed == 15:
            raise KeyError"""


def test_agents_that_fail_or_end_their_process_are_named_and_the_others_go_on(
    warehouse: Warehouse, path: Path
) -> None:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "deadly.py"
        file.write_text("import os\n" + AGENT.format(name="Deadly", begin="pass", act=DEADLY))
        choice = ["--set", f"agent={file}:Deadly,greedy", "--set", "max_steps=5", "-o", path]
        result = warehouse("sweep", *choice, "-n", 20, "--jobs", 2)
    assert result.code == 1
    flags = f"with agent={file}:Deadly, max_steps=5"
    *failures, last = result.err.splitlines()
    assert sorted(failures) == [
        f"warehouse: seed 13 {flags}: its process was ended by signal 9 (Killed), "
        "perhaps because memory ran out; it was tried twice",
        f"warehouse: seed 15, step 1, {flags}: KeyError (deadly.py, line 16)",
    ]
    assert last == (
        "warehouse: 2 episodes failed, in 1 of 2 combinations; 38 of 40 episodes in "
        f"{path}; run the same command again to run the others"
    )
    assert "done; see" not in result.out
    check_is_usable(path)
    assert len(table(path)) == 38


def test_there_are_no_more_workers_than_episodes(
    warehouse: Warehouse, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def counted(count: int) -> AbstractContextManager[Here]:
        asked.append(count)
        return nullcontext(Here())

    monkeypatch.setattr(sweep_command, "Processes", counted)
    for episodes, workers in ((1, 64), (4, 2)):
        words = ["-n", episodes, "--jobs", workers, "-o", path]
        assert warehouse("sweep", *words).code == 0
    assert asked == [1, 2]


def test_the_help_names_every_parameter(warehouse: Warehouse) -> None:
    lines = [line.split() for line in warehouse("sweep", "--help").out.splitlines()]
    shown = {words[0]: " ".join(words[1:]) for words in lines if len(words) > 1}
    assert PARAMETERS.keys() <= shown.keys()
    assert shown["density"] == f"0..{MAX_DENSITY:g}, of layout random"
    assert (shown["people"], shown["battery"]) == (f"0..{MAX_BODIES}, of fleets", "1..1000000000")
    assert shown["robot.NAME"] == "and disturbances.NAME, of physics"


def test_a_sweep_of_fleets_is_resumed(warehouse: Warehouse, tmp_path: Path, here: None) -> None:
    path = tmp_path / "r.sqlite"
    words = ["sweep", "--set", "robots=1,2", "--set", "max_steps=30", "--set", "order_rate=0.5",
             "--jobs", 1, "-o", path]  # fmt: skip
    warehouse(*words, "-n", 2)
    with Store(path, read_only=True) as store:
        before = [[*store.rows(number, FleetRow)] for number in store.cases()]
    printed = warehouse(*words, "-n", 3).out
    assert printed.startswith("2 combinations, 3 episodes each, 4 done\n")
    with Store(path, read_only=True) as store:
        after = [[*store.rows(number, FleetRow)] for number in store.cases()]
    assert [rows[:2] for rows in after] == before


# The progress bar.


def rows_of(*modes: str) -> list[Row]:
    return [Row(seed, mode, 1, 1, 0, 0, 0, 0, 0, 0) for seed, mode in enumerate(modes)]


def shown(monkeypatch: pytest.MonkeyPatch, screen: io.StringIO, *news: Sequence[AnyRow]) -> str:
    """Return what a bar for 8 episodes writes."""
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("TERM", "xterm")
    with sweep_bar(8, lambda: None) as report:
        for each in news:
            time.sleep(0.02)  # without it the rate would be too large for the line
            report(each, [])
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())


def last_line(text: str) -> str:
    return re.split(r"[\r\n]+", text.strip())[-1]


def test_a_terminal_shows_the_count_the_rate_the_time_left_and_the_share_delivered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    some = rows_of("delivered", "stalled", "delivered")
    line = last_line(shown(monkeypatch, Terminal(), some, [], rows_of("wandering")))
    assert re.search(r"[━╸╺ ]+ 4/8 [\d,]+/s \d:\d\d:\d\d 50% delivered", line), line


@pytest.mark.parametrize(
    ("news", "ending"),
    [
        (
            [rows_of("delivered"), rows_of("stalled"), rows_of("stalled", "stalled")],
            " 4/8 .* 25% delivered",
        ),
        ([[fleet_row(0), fleet_row(1, delivered=1)]], " 2/8 .* 30% delivered"),
    ],
    ids=["episodes of lone robots", "orders of fleets"],
)
def test_the_share_is_of_all_so_far(
    monkeypatch: pytest.MonkeyPatch, news: list[list[AnyRow]], ending: str
) -> None:
    assert re.search(f"{ending} *$", last_line(shown(monkeypatch, Terminal(), *news)))


def test_the_share_is_left_out_until_it_is_known_and_all_without_a_terminal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert shown(monkeypatch, io.StringIO(), rows_of("delivered")) == ""
    text = shown(monkeypatch, Terminal(), [])
    assert "0/8" in text
    assert "delivered" not in text
    assert "None" not in text


def test_a_failure_that_comes_again_is_told_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with sweep_bar(8, lambda: None) as report:
        for failures in (["a is broken", "a is broken"], ["a is broken", "b is broken"]):
            report([], failures)
    lines = sorted(capsys.readouterr().err.splitlines())
    assert lines == ["warehouse: a is broken", "warehouse: b is broken"]
