"""Training by PPO as its users meet it where PyTorch is missing; see also test_learning.py."""

import sys
from pathlib import Path

import pytest
from helpers.command_line import command, in_a_process, refusal

from agents.commands.train import LIBRARIES

HEAVY = (*LIBRARIES, "gymnasium", "pymunk")


@pytest.fixture(autouse=True)
def in_an_empty_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


def without(monkeypatch: pytest.MonkeyPatch, library: str) -> None:
    """Let a library be missing, whether it is installed or not."""
    for name in ("agents.learning.ppo_training", "agents.learning.vec_env"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, library, None)


def test_what_is_missing_is_one_line_with_the_command_that_installs_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "torch")
    assert refusal(capsys, "train", "ppo") == (
        "training by PPO needs torch, which is not installed: pip install 'warehouse-lab[rl]'"
    )
    assert not list(Path().iterdir())


def test_a_fault_in_our_own_imports_is_not_hidden(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "agents.learning.ppo_training")
    with pytest.raises(ModuleNotFoundError, match=r"agents\.learning\.ppo_training"):
        refusal(capsys, "train", "ppo")


def test_options_are_checked_before_anything_is_imported(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "torch")
    message = "m.zip: cannot save as .zip; allowed: .npz"
    assert refusal(capsys, "train", "ppo", "--output", "m.zip") == message
    missing = refusal(capsys, "train", "ppo", "--layout", "missing.txt")
    assert missing == "missing.txt: No such file or directory"


def test_help_tells_of_the_risk_and_of_every_training(capsys: pytest.CaptureFixture[str]) -> None:
    words = " ".join(command(capsys, "train", "ppo", "--help").out.split())
    assert "load only files of that kind that you trust" in words
    result = command(capsys, "train")
    assert all(word in result.out + result.err for word in ("ppo", "q", "Train an agent"))


@pytest.mark.parametrize("words", [["--help"], ["run", "--seed", "1", "--no-show"]])
def test_other_commands_load_none_of_the_heavy_libraries(words: list[str], tmp_path: Path) -> None:
    program = f"""
import sys
from agents.cli import main
try:
    main()
finally:
    print([name for name in {HEAVY} if name in sys.modules], file=sys.stderr)
"""
    result = in_a_process("-c", program, *words, folder=tmp_path)
    assert (result.code, result.err) == (0, "[]\n")
