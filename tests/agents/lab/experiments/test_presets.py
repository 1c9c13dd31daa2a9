"""Presets: each is a plan for a question of the chapter, and can be run."""

from contextlib import nullcontext
from pathlib import Path

import pytest
from helpers.command_line import Warehouse
from helpers.sweeps import Here, nothing

from agents.lab.experiments import sweep
from agents.lab.experiments.choices import read_plan_file
from agents.lab.experiments.plan import make_plan
from agents.lab.experiments.running import run_missing
from agents.lab.experiments.store import Store
from agents.lab.experiments.sweep import PRESETS
from agents.lab.parameters import PARAMETERS


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_varies_a_parameter_with_a_question_and_can_be_run(
    tmp_path: Path, name: str
) -> None:
    choices = read_plan_file(PRESETS[name]).choices
    plan = make_plan({**choices, "max_steps": 20}, 1, 0)
    values = {name: {case[name] for case in plan.cases if name in case} for name in choices}
    varied = [name for name in values if len(values[name]) > 1]
    assert varied
    assert all(PARAMETERS[each].question.endswith("?") for each in varied)
    with Store(tmp_path / "r.sqlite") as store:
        run_missing(plan, store, Here(), 1, nothing)
        assert [store.count(case, plan.seeds) for case in plan.cases] == [1] * len(plan.cases)


def test_the_preset_sets_the_number_of_episodes_unless_another_is_given(
    warehouse: Warehouse, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep, "process_pool", lambda count: nullcontext((Here(), count)))
    text = PRESETS["escape"].read_text().replace("episodes = 2000", "episodes = 3")
    plan = tmp_path / "plan.toml"
    plan.write_text(text)
    monkeypatch.setitem(PRESETS, "escape", plan)
    words = ["--preset", "escape", "--set", "memory=5", "--jobs", 1]
    printed = warehouse("sweep", *words, "-o", tmp_path / "r.sqlite").out
    assert printed.startswith("2 combinations, 3 episodes each, 0 done\n")
    printed = warehouse("sweep", *words, "-n", 1, "-o", tmp_path / "r.sqlite").out
    assert printed.startswith("2 combinations, 1 episode each, 2 done\n")
