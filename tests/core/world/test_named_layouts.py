import re
from pathlib import Path

import pytest

from agents import GreedyAgent
from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError, WarehouseEnv, record_episode
from warehouse_core.records.failure_modes import OSCILLATION, diagnose, fewest_steps
from warehouse_core.world.map_files import save_map
from warehouse_core.world.named_layouts import DEFAULT, NAMES, as_layout, find_layout, named_layout

HALL = Layout(["#####", "#P.D#", "#...#", "#####"])


@pytest.mark.parametrize("name", NAMES)
def test_an_item_can_be_delivered_from_everywhere_in_each_but_the_closed_one(name: str) -> None:
    layout = named_layout(name)
    env = WarehouseEnv(layout, None)
    starts = {env.reset("start", seed=seed)["robot_pos"] for seed in range(30)}
    needed = fewest_steps(layout, *((cell, False) for cell in starts))
    assert {steps is None for steps in needed} == {name == "closed"}


@pytest.mark.parametrize(("name", "loops"), [("corridor", 0), ("hall", 0), ("trap", 20)])
def test_the_trap_catches_an_agent_that_does_not_escape(name: str, loops: int) -> None:
    agent = GreedyAgent(1, escape_steps=0)
    episodes = [
        record_episode(WarehouseEnv(named_layout(name), None), agent, seed=seed, randomize="start")
        for seed in range(20)
    ]
    assert [diagnose(each).mode for each in episodes].count(OSCILLATION) == loops


def test_a_file_comes_before_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("trap").mkdir()
    assert find_layout("trap") is named_layout("trap")
    Path("trap").rmdir()
    Path("trap").write_text("P.D\n")
    assert find_layout("trap").rows == ("P.D",)


def test_an_unknown_name_is_an_error_that_lists_the_names(tmp_path: Path) -> None:
    with pytest.raises(LayoutError, match="is called 'trapp'; allowed: default, corridor"):
        find_layout("trapp")
    for name in ("a\0", "a\0.txt"):
        with pytest.raises(LayoutError, match=r"is called 'a.*: a name has no null character"):
            find_layout(name)
    with pytest.raises(FileNotFoundError):
        find_layout("missing.txt")
    with pytest.raises(FileNotFoundError):
        find_layout(tmp_path / "trap")


def test_a_layout_is_given_in_any_of_its_forms(tmp_path, monkeypatch) -> None:
    assert as_layout("trap") is named_layout("trap")
    assert as_layout(None) is as_layout(DEFAULT_LAYOUT) is as_layout(DEFAULT) is DEFAULT_LAYOUT
    assert as_layout(str(HALL)) == as_layout(HALL.rows) == HALL
    monkeypatch.chdir(tmp_path)
    HALL.save("hall.txt")
    assert as_layout("hall.txt") == as_layout(Path("hall.txt")) == HALL
    save_map(HALL, "hall.map")
    assert as_layout("hall.map") == HALL.with_stations(None, None)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            "hal.txt",
            "hal.txt: No such file or directory; nor is it the text of a layout: "
            "row 0, column 0: 'h' is not a tile; allowed: ",
        ),
        (Path("hal.txt"), "hal.txt: No such file or directory"),
        (Path(), ".: it is a folder, not a file"),
        ("#x", "no layout is called '#x'; allowed: default, "),
        ("bad.txt", "bad.txt: row 1, column 2: 'x' is not a tile"),
        (Path("bad.map"), "bad.map: line 1, column 1: "),
        ("P.\n#x", "row 1, column 1: 'x' is not a tile"),
        ("", "the layout is empty"),
    ],
    ids=repr,
)
def test_an_error_in_a_layout_starts_with_the_name_of_its_file(
    given: str | Path, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("bad.txt", "bad.map"):
        Path(name).write_text("P..\n..x\n")
    with pytest.raises(LayoutError, match=f"^{re.escape(message)}"):
        as_layout(given)
