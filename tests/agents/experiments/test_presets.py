"""The chapter's questions: each preset is a plan that can be run, and asks something."""

from pathlib import Path

import pytest
from helpers.command_line import command, refusal

from agents.experiments.parameters import PARAMETERS
from agents.experiments.plan import MAX_CASES, MAX_EPISODES, make_plan
from agents.experiments.presets import PRESETS
from agents.experiments.store import Store

over_presets = pytest.mark.parametrize("name", PRESETS)


@over_presets
def test_a_preset_is_a_plan_within_the_limits(name: str) -> None:
    preset = PRESETS[name]
    assert preset.choices.keys() <= PARAMETERS.keys()
    plan = make_plan(preset.choices, preset.episodes, 0)
    assert 1 < len(plan.cases) <= MAX_CASES
    assert plan.total <= MAX_EPISODES


@over_presets
def test_a_preset_varies_something_that_is_a_question(name: str) -> None:
    preset = PRESETS[name]
    plan = make_plan(preset.choices, preset.episodes, 0)
    values = {name: {case[name] for case in plan.cases if name in case} for name in preset.choices}
    varied = [name for name in values if len(values[name]) > 1]
    assert varied
    assert all(PARAMETERS[each].question.endswith("?") for each in varied)


@over_presets
def test_a_preset_gives_rows(capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str) -> None:
    path = tmp_path / "r.sqlite"
    words = ["--preset", name, "-n", 2, "--workers", 2, "-o", path]
    assert command(capsys, "sweep", *words).code == 0
    plan = make_plan(PRESETS[name].choices, 2, 0)
    with Store(path, read_only=True) as store:
        assert [store.count(case, plan.seeds) for case in plan.cases] == [2] * len(plan.cases)
        assert len(store.cases()) == len(plan.cases)


def test_its_own_number_of_episodes_counts_unless_another_is_given(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PRESETS, "escape", PRESETS["escape"]._replace(episodes=3))
    words = ["--preset", "escape", "--set", "memory=5", "--workers", 1]
    printed = command(capsys, "sweep", *words, "-o", tmp_path / "r.sqlite").out
    assert printed.startswith("2 combinations, 3 episodes each, 0 done\n")
    printed = command(capsys, "sweep", *words, "-n", 1, "-o", tmp_path / "r.sqlite").out
    assert printed.startswith("2 combinations, 1 episode each, 2 done\n")


def test_an_unknown_preset_is_refused_by_name(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "r.sqlite"
    line = refusal(capsys, "sweep", "--preset", "batery", "-o", path)
    assert line == f"no preset is called 'batery'; allowed: {', '.join(PRESETS)}"
    assert not path.exists()


def test_a_preset_and_a_file_are_one_plan_too_many(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    plan, path = tmp_path / "plan.toml", tmp_path / "r.sqlite"
    plan.write_text("")
    line = refusal(capsys, "sweep", plan, "--preset", "battery", "-o", path)
    assert str(plan) in line
    assert "battery" in line
    assert not path.exists()
