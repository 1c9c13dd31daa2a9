from pathlib import Path

import numpy as np
import pytest

from agents.errors import AgentError
from agents.learning.q_learning import QTable
from agents.learning.q_table import load_agent, load_table, save_table
from warehouse_core import Layout, RecordError
from warehouse_core.task.encoding import NOWHERE

ROOM = Layout(["P#D", "..."])
TABLE = QTable(
    {
        ((1, 2), (3, 4), False): [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, -6.5],
        ((1, 2), (3, 4), True): [0.1] * 7,
        ((70_000, 0), NOWHERE, True): [0.0] * 7,
    }
)


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "table.npz"
    save_table(TABLE, ROOM, path)
    return path


def refusal(path: Path) -> str:
    with pytest.raises(RecordError) as refused:
        load_table(path)
    message = str(refused.value)
    assert message.startswith(f"{path}: ")
    return message.removeprefix(f"{path}: ")


def test_a_table_is_read_back_from_its_file(saved: Path) -> None:
    again, walls = load_table(saved)
    assert again == TABLE
    assert walls.tolist() == [[False, True, False], [False, False, False]]
    assert isinstance(again, QTable)
    assert all(isinstance(loaded, bool) for _, _, loaded in again)
    save_table(QTable(), ROOM, saved)
    assert load_table(saved)[0] == {}


def test_a_table_is_for_the_walls_on_which_it_was_learned(saved: Path) -> None:
    assert load_agent(saved, layout=Layout([".#.", "P.D"])).table == TABLE
    message = "learned on a layout of 2 x 3 cells; this one has 1 x 3 cells and other walls"
    with pytest.raises(AgentError, match=message):
        load_agent(saved, layout=Layout(["P.D"]))
    with pytest.raises(AgentError, match="has 7 x 12 cells and other walls"):
        load_agent(saved)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"states": np.zeros((3, 4), np.int32)}, "states (3, 4) and values (3, 7); they must be"),
        ({"states": np.zeros((2, 5), np.int32)}, "states (2, 5) and values (3, 7); they must be"),
        ({"values": np.zeros((3, 6))}, "states (3, 5) and values (3, 6); they must be (N, 5)"),
        ({"values": np.full((3, 7), -np.inf)}, "it has values that are not finite"),
        ({"values": np.zeros((3, 7), np.float32)}, "array values is float32"),
        ({"more": np.zeros(3)}, "4 arrays; there must be 3"),
    ],
)
def test_a_file_of_something_else_is_an_error(saved, changed, says) -> None:
    with np.load(saved) as file:
        arrays = dict(file)
    np.savez_compressed(saved, **(arrays | changed))
    assert refusal(saved).startswith(says)
