"""What an experiment may be told: settings, flags, plans, their files, and the cases they make."""

import time
from pathlib import Path
from typing import Any

import pytest
from command_line import refusal

from agents.experiments.case import key_of, make_case
from agents.experiments.flags import parse_flags
from agents.experiments.plan import MAX_CASES, MAX_SEED, Plan, make_plan
from agents.experiments.plan_file import MAX_BYTES, PlanFile, read_plan_file
from agents.experiments.setting import SETTINGS, SettingError
from warehouse_core import DEFAULT_LAYOUT

WAITER = """
class Waiter:
    def reset(self):
        pass

    def act(self, observation):
        return "WAIT"
"""

BIG = "1" + 400 * "0"


def to(text: str) -> str:
    return f"[settings]\n{text}"


HOSTILE = {
    "an unknown key": ("episode = 3", "episode"),
    "an unknown setting": (to("batery = 3"), "batery"),
    "an unknown group": ("[robots]\nmass = 3", "robots"),
    "an unknown number": ("[robot]\nmas = 3", "mas"),
    "no number": ("[robot]\nmass = 'heavy'", "robot.mass"),
    "nothing physical": ("[robot]\nmass = -1\n[settings]\nbackend = 'physics'", "mass"),
    "a number instead of a table": ("settings = 3", "settings"),
    "a nested table": ("[settings.battery]\nx = 3", "battery"),
    "a table too deep": ("[settings.robot]\nmass = [3]", "robot"),
    "one too many in a range": (to("battery = {from = 1, to = 2, step = 1, by = 1}"), "battery"),
    "nothing": (to("battery = []"), "battery"),
    "a list in a list": (to("battery = [[3]]"), "battery"),
    "text": (to("battery = '3'"), "battery"),
    "a fraction": (to("battery = 1.5"), "battery"),
    "a flag as a number": (to("battery = true"), "battery"),
    "a number as a flag": (to("escape = 1"), "escape"),
    "a date": (to("agent = 2020-01-01"), "agent"),
    "no text": (to("layout = ' '"), "layout"),
    "nan": (to("density = nan"), "density"),
    "inf": (to("density = inf"), "density"),
    "huge": (to(f"density = {BIG}"), "density"),
    "too long a number": (to("battery = " + 5000 * "9"), "digits"),
    "too far a view": (to("view_radius = 1000000000"), "view_radius"),
    "too big": (to("layout = 'random'\nsize = '9999x9999'"), "9999"),
    "not a size": (to("size = '7x12x3'"), "size"),
    "no backend": (to("backend = 'hover'"), "backend"),
    "no agent": (to("agent = 'nobody'"), "nobody"),
    "a file that cannot be": (to('layout = "a\\u0000b"'), "null"),
    "a range to inf": (to("density = {from = 0, to = inf, step = 0.1}"), "density"),
    "a range by nan": (to("density = {from = 0, to = 0.3, step = nan}"), "density"),
    "a range by nothing": (to("battery = {from = 1, to = 9, step = 0}"), "battery"),
    "a range by next to nothing": (to("density = {from = 0, to = 0.3, step = 1e-320}"), "density"),
    "a range down": (to("battery = {from = 9, to = 1, step = 1}"), "battery"),
    "a huge range": (to(f"battery = {{from = 1, to = {BIG}, step = 1}}"), "battery"),
    "a long range": (to("battery = {from = 1, to = 1000000000, step = 1}"), "battery"),
    "flags as a range": (to("escape = {from = false, to = true, step = true}"), "escape"),
    "billions of combinations": (
        to("battery = {from = 1, to = 999, step = 1}\n")
        + "".join(
            f"{name} = {{from = 1, to = 1000, step = 1}}\n"
            for name in ("max_steps", "memory", "view_radius")
        ),
        "max_steps",
    ),
    "a setting twice": ("[settings]\n'robot.mass' = 3\n[robot]\nmass = 4", "robot.mass"),
    "episodes as text": ("episodes = '3'", "episodes"),
    "no episodes": ("episodes = 0", "episodes"),
    "a flag of episodes": ("episodes = true", "episodes"),
    "too many episodes": ("episodes = 100000001", "episodes"),
    "a negative seed": ("seed = -1", "seed"),
    "a huge seed": (f"seed = {10**25}", "seed"),
    "brackets": (to("battery = " + 5000 * "[" + 5000 * "]"), "recursion"),
    "not TOML": ("battery: 3", "line 1"),
}


@pytest.mark.parametrize(("text", "named"), HOSTILE.values(), ids=HOSTILE)
def test_a_hostile_plan_is_refused_at_once_with_one_line_and_nothing_is_made(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, named: str
) -> None:
    plan, output = tmp_path / "plan.toml", tmp_path / "r.sqlite"
    plan.write_text(text)
    start = time.perf_counter()
    line = refusal(capsys, "sweep", plan, "-o", output, *(() if "episodes" in text else ("-n", 1)))
    assert time.perf_counter() - start < 1
    assert named in line
    assert list(tmp_path.iterdir()) == [plan]


FLAGS = {
    "battery": "battery",
    "battery=": "battery",
    "battery=1:2": "battery",
    "battery=1:2:3:4": "battery",
    "battery=9:1:1": "battery",
    "battery=1:9:0": "battery",
    "battery=nan": "battery",
    "battery=1,,2": "battery",
    "battery=1e3": "battery",
    "battery=" + 5000 * "9": "battery",
    "density=nan:inf:1": "density",
    "density=0:0.3:1e-320": "density",
    "battery=1:1000000000:1": "battery",
    "escape=1": "escape",
    "agent=on": "agent",
    "=3": "allowed",
    "batery=3": "batery",
    "robot.mas=3": "mas",
}


@pytest.mark.parametrize("flag", FLAGS)
def test_a_hostile_flag_is_refused_at_once_and_nothing_is_made(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, flag: str
) -> None:
    start = time.perf_counter()
    line = refusal(capsys, "sweep", "--set", flag, "-o", tmp_path / "r.sqlite")
    assert time.perf_counter() - start < 1
    assert FLAGS[flag] in line
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("seed", [-1, 10**25])
def test_a_seed_that_cannot_be_kept_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, seed: int
) -> None:
    output = tmp_path / "r.sqlite"
    assert "seed" in refusal(capsys, "sweep", "-n", 1, "--seed", seed, "-o", output)
    assert not output.exists()


@pytest.mark.parametrize(
    ("content", "named"),
    [(b"\xff\xfe", "utf-8"), (b"#" * (MAX_BYTES + 1), "longer"), (None, "directory")],
    ids=["not UTF-8", "too long", "a directory"],
)
def test_what_is_no_text_is_refused_by_name(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, content: bytes | None, named: str
) -> None:
    plan = tmp_path / "plan.toml"
    plan.mkdir() if content is None else plan.write_bytes(content)
    line = refusal(capsys, "sweep", plan, "-o", tmp_path / "r.sqlite")
    assert str(plan) in line
    assert named in line
    assert list(tmp_path.iterdir()) == [plan]


def test_a_flag_given_twice_is_refused() -> None:
    with pytest.raises(SettingError, match=r"^battery is given twice"):
        parse_flags(["battery=1", "battery=2"])


def test_flags_are_lists_ranges_words_and_names_with_colons() -> None:
    flags = ["escape=on,FALSE", "battery=20:60:20", "agent=ppo:a.npz, greedy", "density=0.1"]
    assert parse_flags(flags) == {
        "escape": [True, False],
        "battery": {"from": 20, "to": 60, "step": 20},
        "agent": ["ppo:a.npz", "greedy"],
        "density": [0.1],
    }


def test_a_plan_file_says_what_its_documentation_says(tmp_path: Path) -> None:
    from agents.experiments import plan_file

    text = (plan_file.__doc__ or "").split("::\n")[1].replace("\n    ", "\n")
    path = tmp_path / "plan.toml"
    path.write_text(text)
    given = read_plan_file(path)
    assert (given.episodes, given.seed) == (200, 0)
    assert given.choices["robot.mass"] == [50, 70]
    # With the grid the robot counts for nothing: 2 * 10, and with physics 2 * 10 * 2 * 2.
    assert len(make_plan(given.choices, 200, 0).cases) == 20 + 80


def test_an_empty_file_is_a_plan_of_defaults(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text("")
    assert read_plan_file(path) == PlanFile({}, None, None)
    assert [key_of(case) for case in make_plan({}, 1, 0).cases] == [key_of(make_case({}))]


def values_of(name: str, plan: Plan) -> list[Any]:
    return [case[name] for case in plan.cases]


def test_a_range_has_both_its_ends_whatever_is_rounded() -> None:
    plan = make_plan({"density": {"from": 0, "to": 0.3, "step": 0.1}, "layout": "random"}, 1, 0)
    assert values_of("density", plan) == pytest.approx([0, 0.1, 0.2, 0.3])
    plan = make_plan({"battery": {"from": 20, "to": 59, "step": 20}}, 1, 0)
    assert values_of("battery", plan) == [20, 40]


def test_as_many_cases_as_are_allowed_and_not_one_more() -> None:
    limits = {"from": 1, "to": MAX_CASES, "step": 1}
    assert make_plan({"battery": limits}, 1, 0).total == MAX_CASES
    with pytest.raises(SettingError, match="battery"):
        make_plan({"battery": limits | {"to": MAX_CASES + 1}}, 1, 0)


def test_the_seeds_of_a_plan_go_up_from_the_first() -> None:
    assert list(make_plan({}, 3, MAX_SEED).seeds) == [MAX_SEED, MAX_SEED + 1, MAX_SEED + 2]


# Cases


def test_a_default_that_is_written_out_makes_no_other_case() -> None:
    given = {name: setting.default for name, setting in SETTINGS.items()}
    assert key_of(make_case(given)) == key_of(make_case({}))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "choices",
    [
        {"density": [0.1, 0.2]},
        {"size": ["7x12", "8x8"]},
        {"robot.mass": [50, 70]},
        {"disturbances.motor_strength": [0.5, 1]},
        {"battery": [20, 20]},
    ],
)
def test_what_means_nothing_makes_no_further_case(choices: dict[str, Any]) -> None:
    plan = make_plan(choices, 1, 0)
    assert len(plan.cases) == 1
    assert not set(choices) - {"battery"} & set(plan.cases[0])


@pytest.mark.parametrize(
    "choices",
    [
        {"density": [0.1, 0.3], "layout": "random"},
        {"size": ["7x12", "8x8"], "layout": "random"},
        {"robot.mass": [50, 70], "backend": "physics"},
        {"escape": [True, False]},
        {"memory": [0, 10]},
        {"view_radius": [1, 2]},
        {"max_steps": [1, 2]},
        {"backend": ["grid", "physics"]},
    ],
)
def test_what_means_something_makes_further_cases(choices: dict[str, Any]) -> None:
    assert len(make_plan(choices, 1, 0).cases) == 2


def test_an_agent_of_ones_own_has_neither_memory_nor_escape(tmp_path: Path) -> None:
    file = tmp_path / "waiter.py"
    file.write_text(WAITER)
    choices = {"agent": f"{file}:Waiter", "escape": [True, False], "memory": [1, 2]}
    [case] = make_plan(choices, 1, 0).cases
    assert not {"escape", "memory"} & case.keys()


def test_a_changed_agent_file_is_another_case(tmp_path: Path) -> None:
    file = tmp_path / "waiter.py"
    keys = []
    for text in (WAITER, WAITER, WAITER + "# changed\n"):
        file.write_text(text)
        keys.append(key_of(make_case({"agent": f"{file}:Waiter"})))
    assert keys[0] == keys[1] != keys[2]


def test_a_changed_layout_file_is_another_case(tmp_path: Path) -> None:
    file = tmp_path / "layout.txt"
    rows = [list(row) for row in DEFAULT_LAYOUT.rows]
    keys = []
    for tile in (".", ".", "#"):
        rows[1][1] = tile
        file.write_text("\n".join(map("".join, rows)) + "\n")
        keys.append(key_of(make_case({"layout": str(file)})))
    assert keys[0] == keys[1] != keys[2]
