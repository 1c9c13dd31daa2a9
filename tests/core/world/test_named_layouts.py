from pathlib import Path

import pytest

from agents import GreedyAgent
from warehouse_core import DEFAULT_LAYOUT, LayoutError, WarehouseEnv, record_episode
from warehouse_core.records.failure_modes import OSCILLATION, diagnose, fewest_steps
from warehouse_core.world.named_layouts import DEFAULT, NAMES, find_layout, named_layout


@pytest.mark.parametrize("name", NAMES)
def test_an_item_can_be_delivered_from_everywhere_in_each(name: str) -> None:
    layout = named_layout(name)
    env = WarehouseEnv(layout, None)
    starts = {env.reset("start", seed=seed)["robot_pos"] for seed in range(30)}
    assert None not in fewest_steps(layout, *((cell, False) for cell in starts))


def test_the_default_is_the_chapters() -> None:
    assert named_layout(DEFAULT) is DEFAULT_LAYOUT


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
    assert find_layout("trap") is named_layout("trap")
    Path("trap").write_text("P.D\n")
    assert find_layout("trap").rows == ("P.D",)


def test_an_unknown_name_is_an_error_that_lists_the_names(tmp_path: Path) -> None:
    with pytest.raises(LayoutError, match="is called 'trapp'; allowed: default, corridor"):
        find_layout("trapp")
    with pytest.raises(FileNotFoundError):
        find_layout("missing.txt")
    with pytest.raises(FileNotFoundError):
        find_layout(tmp_path / "trap")
