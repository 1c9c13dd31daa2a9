"""Choices in plan files and flags: valid ones, and errors for all others."""

from pathlib import Path

import pytest
from helpers.command_line import Refused

from agents.lab.experiments.case import key_of, make_case
from agents.lab.experiments.choices import MAX_BYTES, PlanFile, parse_flags, read_plan_file
from agents.lab.experiments.plan import make_plan

BIG = "1" + 400 * "0"


def to(text: str) -> str:
    return f"[settings]\n{text}"


INVALID: dict[str, tuple[str | bytes | None, str]] = {
    "an unknown key": ("episode = 3", "episode"),
    "an unknown setting": (to("batery = 3"), "batery"),
    "an unknown group": ("[robots]\nmass = 3", "robots"),
    "a negative mass": ("[robot]\nmass = -1\n[settings]\nbackend = 'physics'", "mass"),
    "a number instead of a table": ("settings = 3", "settings"),
    "a nested table": ("[settings.battery]\nx = 3", "battery"),
    "an unknown key in a range": (to("battery = {from = 1, to = 2, step = 1, by = 1}"), "battery"),
    "an empty list": (to("battery = []"), "battery"),
    "a list in a list": (to("battery = [[3]]"), "battery"),
    "a date": (to("agent = 2020-01-01"), "agent"),
    "nan": (to("density = nan"), "density"),
    "a number with many digits": (to("battery = " + 1000 * "9"), "battery"),
    "a long line": (to("battery = " + 5000 * "9"), "line 2 is longer than MAX_LINE = 2000 bytes"),
    "a deep key": (to(10 * "a." + "b = 3"), "line 2 has a key of more than MAX_DEPTH = 10 parts"),
    "a deep table": (f"[{10 * 'a.'}b]", "line 1 has a key of more than MAX_DEPTH = 10 parts"),
    "a deep key in quotes": (to(10 * "'a b' . " + "b = 3"), "MAX_DEPTH"),
    "a key that is not too deep": (to(9 * "a." + "b = 3"), "no setting is called 'a'"),
    "a size that is too big": (to("layout = 'random'\nsize = '9999x9999'"), "9999"),
    "an unknown agent": (to("agent = 'nobody'"), "nobody"),
    "a null character in a file name": (to('layout = "a\\u0000b"'), "no layout is called"),
    "a range to inf": (to("density = {from = 0, to = inf, step = 0.1}"), "density"),
    "a step of nan": (to("density = {from = 0, to = 0.3, step = nan}"), "density"),
    "a tiny step": (to("density = {from = 0, to = 0.3, step = 1e-320}"), "density"),
    "a descending range": (to("battery = {from = 9, to = 1, step = 1}"), "battery"),
    "a long range": (to("battery = {from = 1, to = 1000000000, step = 1}"), "battery"),
    "a range of booleans": (to("escape = {from = false, to = true, step = true}"), "escape"),
    "billions of combinations": (
        to("battery = {from = 1, to = 999, step = 1}\n")
        + "".join(
            f"{name} = {{from = 1, to = 1000, step = 1}}\n"
            for name in ("max_steps", "memory", "view_radius")
        ),
        "max_steps",
    ),
    "a range from a text": (to("battery = {from = 'a', to = 3, step = 1}"), "battery.from is 'a'"),
    "a setting twice": ("[settings]\n'robot.mass' = 3\n[robot]\nmass = 4", "robot.mass"),
    "episodes as text": ("episodes = '3'", "episodes"),
    "no episodes": ("episodes = 0", "episodes"),
    "too many episodes": ("episodes = 100000001", "episodes"),
    "a negative seed": ("seed = -1", "seed"),
    "a huge seed": (f"seed = {10**25}", "seed"),
    "deep nesting": (to("battery = " + 1900 * "[\n" + 1900 * "]\n"), "open brackets"),
    "not TOML": ("battery: 3", "line 1"),
    "not UTF-8": (b"\xff\xfe", "plan.toml: 'utf-8' codec can't decode"),
    "too long": (b"#" * (MAX_BYTES + 1), "plan.toml: it is longer"),
    "a directory": (None, "plan.toml"),
}


@pytest.mark.parametrize(("text", "named"), INVALID.values(), ids=INVALID)
def test_an_invalid_plan_is_a_one_line_error_and_no_file_is_written(
    refused: Refused, text: str | bytes | None, named: str
) -> None:
    plan = Path("plan.toml")
    if text is None:
        plan.mkdir()
    else:
        plan.write_bytes(text.encode() if isinstance(text, str) else text)
    few = () if isinstance(text, str) and "episodes" in text else ("-n", 1)
    line = refused("sweep", plan, *few)
    assert named in line
    assert list(Path().iterdir()) == [plan]


def test_the_example_in_the_documentation_of_plan_files_is_valid() -> None:
    from agents.lab.experiments import choices as plan_file

    text = (plan_file.__doc__ or "").split("::\n")[1].replace("\n    ", "\n")
    path = Path("plan.toml")
    path.write_text(text)
    given = read_plan_file(path)
    assert (given.episodes, given.seed) == (200, 0)
    assert given.choices["robot.mass"] == [50, 70]
    # On the grid the robot has no effect: 2 * 10 cases, and with physics 2 * 10 * 2 * 2.
    assert len(make_plan(given.choices, 200, 0).cases) == 20 + 80


@pytest.mark.parametrize(
    ("content", "episodes"), [(b"", None), (b"\xef\xbb\xbfepisodes = 3\r\n", 3)]
)
def test_an_empty_file_is_a_plan_of_defaults_and_a_byte_order_mark_is_ignored(
    content: bytes, episodes: int | None
) -> None:
    path = Path("plan.toml")
    path.write_bytes(content)
    assert read_plan_file(path) == PlanFile({}, episodes, None)
    assert [key_of(case) for case in make_plan({}, 1, 0).cases] == [key_of(make_case({}))]


def test_flags_may_be_lists_ranges_words_and_names_with_colons() -> None:
    flags = ["escape=on,FALSE", "battery=20:60:20", "agent=ppo:a.npz, greedy", "density=0.1"]
    assert parse_flags(flags) == {
        "escape": [True, False],
        "battery": {"from": 20, "to": 60, "step": 20},
        "agent": ["ppo:a.npz", "greedy"],
        "density": [0.1],
    }
