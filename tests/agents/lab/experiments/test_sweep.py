"""The command ``warehouse sweep``, which keeps finished episodes and resumes."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import nullcontext, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from helpers.command_line import Refused, Warehouse
from helpers.results_files import outcomes
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

from agents.lab.experiments import sweep as sweep_command
from agents.lab.experiments.case import make_case
from agents.lab.experiments.store import Store
from agents.lab.parameters import PARAMETERS
from agents.lab.runs.programs import program_for
from warehouse_core.batch.fleet_settings import MAX_BODIES
from warehouse_core.world.generators import MAX_DENSITY


@pytest.fixture
def path(tmp_path: Path) -> Iterator[Path]:
    yield tmp_path / "r.sqlite"
    # After the file has been closed, no other files are left.
    assert {each.name for each in tmp_path.iterdir()} <= {"r.sqlite", "expected.sqlite"}


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the episodes of commands in this process, with the function that workers use."""
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
    """``bench_sweep.py`` kills sweeps of lone robots and of fleets 100 times each."""
    episodes = 150
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
    left = f"{path} now has {len(table(path)):,} of 400,000 episodes"
    assert f"\n{left}; run the same command again to resume\n" in out


DEADLY = """
        if self.seed == 13:
            os.kill(os.getpid(), 9)  # as a system that runs out of memory does
        if self.seed == 15:
            raise KeyError"""


def test_agents_that_fail_or_end_their_process_are_named_and_the_others_continue(
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
        f"warehouse: 2 episodes failed (in 1 of 2 combinations); {path} now has 38 of 40 episodes; "
        "run the same command again to run the missing ones"
    )
    assert "done; see" not in result.out
    check_is_usable(path)
    assert len(table(path)) == 38


def test_the_help_names_every_parameter(warehouse: Warehouse) -> None:
    lines = [line.split() for line in warehouse("sweep", "--help").out.splitlines()]
    shown = {words[0]: " ".join(words[1:]) for words in lines if len(words) > 1}
    assert PARAMETERS.keys() <= shown.keys()
    assert shown["density"] == f"0..{MAX_DENSITY:g}, for layout random"
    assert (shown["people"], shown["battery"]) == (f"0..{MAX_BODIES}, for fleets", "1..1000000000")
    assert shown["robot.NAME"] == "and disturbances.NAME, for physics"
