"""Every public callable refuses hostile arguments with a clear error, or accepts them.

The error has a documented class, names the argument and is short. An accepted value also works in
the next reset and step. Neither needs much memory. ``tests/data/answers.txt`` records which values
are refused. After a change that is meant to alter it, run
``python tests/system/test_hostile_arguments.py`` to record it again.
"""

import sys
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[1])]

from helpers.hostile import Answers, answers, faults, named_targets, targets

RECORD = Path(__file__).parents[1] / "data/answers.txt"


def lines_of(found: Answers) -> list[str]:
    """Return a line for each argument and kind of answer, with its values.

    The most frequent kind comes first and has no values.
    """
    lines = []
    for call, given in sorted(found.items()):
        kinds: dict[str, list[str]] = {}
        for word, answer in given.items():
            if word != "bool_":  # an integer in old versions of NumPy
                kinds.setdefault(answer.kind, []).append(word)
        most, *others = sorted(kinds, key=lambda kind: (-len(kinds[kind]), kind))
        lines.append(f"{call}) {most}")
        lines += [f"{call}) {kind}: {', '.join(kinds[kind])}" for kind in others]
    return lines


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.filterwarnings("ignore")
def test_hostile_arguments_are_answered_in_words() -> None:
    called = [*targets(), *named_targets()]
    names = {target.name for target in called}
    assert names > {"WarehouseEnv", "FleetEnv.assign", "BatchEnv.row", "RobotSpec", "shelf_layout"}
    assert names > {"parallel_env.step", "WarehouseVectorEnv", "PIBT", "replay_episode"}
    found = {call: each for target in called for call, each in answers(target).items()}
    assert faults(found) == []
    assert lines_of(found) == RECORD.read_text().splitlines()


if __name__ == "__main__":
    with TemporaryDirectory() as here, chdir(here):
        both = [*targets(), *named_targets()]
        found = {call: each for target in both for call, each in answers(target).items()}
    RECORD.write_text("\n".join(lines_of(found)) + "\n")
