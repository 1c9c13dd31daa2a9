"""Settings on a command line: lists, ranges, words, and what is none of them."""

from pathlib import Path

import pytest
from helpers.command_line import refusal

from agents.errors import ParameterError
from agents.experiments.choices import parse_flags

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
def test_a_hostile_flag_is_refused_before_anything_is_made(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, flag: str
) -> None:
    line = refusal(capsys, "sweep", "--set", flag, "-o", tmp_path / "r.sqlite")
    assert FLAGS[flag] in line
    assert not list(tmp_path.iterdir())


def test_a_flag_given_twice_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"^battery is given twice"):
        parse_flags(["battery=1", "battery=2"])


def test_flags_are_lists_ranges_words_and_names_with_colons() -> None:
    flags = ["escape=on,FALSE", "battery=20:60:20", "agent=ppo:a.npz, greedy", "density=0.1"]
    assert parse_flags(flags) == {
        "escape": [True, False],
        "battery": {"from": 20, "to": 60, "step": 20},
        "agent": ["ppo:a.npz", "greedy"],
        "density": [0.1],
    }
