"""Plans from files, flags and presets, which are checked and have every combination once."""

from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Refused
from helpers.sweeps import Here, run_missing

from agents.errors import ParameterError
from agents.lab.experiments import plan as plan_file
from agents.lab.experiments.plan import (
    MAX_BYTES,
    MAX_SEED,
    SweepPlan,
    make_plan,
    parse_flags,
    read_plan_file,
)
from agents.lab.experiments.store import Store
from agents.lab.experiments.sweep import PRESETS, SweepRun
from agents.lab.parameters import PARAMETERS


def to(text: str) -> str:
    return f"[settings]\n{text}"


INVALID: dict[str, tuple[str | bytes, str]] = {
    "an unknown key": ("episode = 3", "episode"),
    "an unknown setting": (to("batery = 3"), "batery"),
    "a negative mass": ("[robot]\nmass = -1\n[settings]\nbackend = 'physics'", "mass"),
    "a number instead of a table": ("settings = 3", "settings"),
    "an unknown key in a range": (to("battery = {from = 1, to = 2, step = 1, by = 1}"), "battery"),
    "an empty list": (to("battery = []"), "battery"),
    "a size that is too big": (to("layout = 'random'\nsize = '9999x9999'"), "9999"),
    "a descending range": (to("battery = {from = 9, to = 1, step = 1}"), "battery"),
    "a long range": (to("battery = {from = 1, to = 1000000000, step = 1}"), "battery"),
    "billions of combinations": (
        to("battery = {from = 1, to = 999, step = 1}\n")
        + "".join(
            f"{name} = {{from = 1, to = 1000, step = 1}}\n"
            for name in ("max_steps", "memory", "view_radius")
        ),
        "combinations",
    ),
    "a negative seed": ("seed = -1", "seed"),
    "not TOML": ("battery: 3", "line 1"),
    "not UTF-8": (b"\xff\xfe", "plan.toml: 'utf-8' codec can't decode"),
    "too long": (b"#" * (MAX_BYTES + 1), "plan.toml: it is longer"),
}


@pytest.mark.parametrize(("text", "named"), INVALID.values(), ids=INVALID)
def test_an_invalid_plan_is_a_one_line_error_and_no_file_is_written(
    refused: Refused, text: str | bytes, named: str
) -> None:
    plan = Path("plan.toml")
    plan.write_bytes(text.encode() if isinstance(text, str) else text)
    few = () if isinstance(text, str) and "episodes" in text else ("-n", 1)
    line = refused("sweep", plan, *few)
    assert named in line
    assert list(Path().iterdir()) == [plan]


def test_the_example_in_the_documentation_of_plan_files_is_valid() -> None:
    text = (plan_file.__doc__ or "").split("::\n")[1].replace("\n    ", "\n")
    path = Path("plan.toml")
    path.write_text(text)
    given = read_plan_file(path)
    assert (given.episodes, given.seed) == (200, 0)
    assert given.choices["robot.mass"] == [50, 70]
    # On the grid the robot has no effect: 2 * 10 cases, and with physics 2 * 10 * 2 * 2.
    assert len(make_plan(given.choices, 200, 0).cases) == 20 + 80


def test_flags_may_be_lists_ranges_words_and_names_with_colons() -> None:
    flags = ["escape=on,FALSE", "battery=20:60:20", "agent=ppo:a.npz, greedy", "density=0.1"]
    assert parse_flags(flags) == {
        "escape": [True, False],
        "battery": {"from": 20, "to": 60, "step": 20},
        "agent": ["ppo:a.npz", "greedy"],
        "density": [0.1],
    }


def values_of(name: str, plan: SweepPlan) -> list[Any]:
    return [case[name] for case in plan.cases]


def test_a_range_includes_its_end_in_spite_of_rounding() -> None:
    plan = make_plan({"density": {"from": 0, "to": 0.3, "step": 0.1}, "layout": "random"}, 1, 0)
    assert values_of("density", plan) == pytest.approx([0, 0.1, 0.2, 0.3])
    plan = make_plan({"battery": {"from": 20, "to": 59, "step": 20}}, 1, 0)
    assert values_of("battery", plan) == [20, 40]


def test_the_seeds_of_a_plan_are_consecutive() -> None:
    assert list(make_plan({}, 3, MAX_SEED).seeds) == [MAX_SEED, MAX_SEED + 1, MAX_SEED + 2]
    for seed in (-1, MAX_SEED + 1):
        with pytest.raises(ParameterError, match=rf"^seed is {seed}; .* 0\.\.{MAX_SEED}$"):
            make_plan({}, 1, seed)


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
        run_missing(plan, store, Here())
        assert SweepRun(plan, store).done == plan.total
