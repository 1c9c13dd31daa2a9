"""Every code block of the README is run, in order, in an empty folder."""

import re
import shlex
from pathlib import Path

import pytest

from agents import cli
from agents.console.main import main
from agents.experiments.presets import PRESETS
from warehouse_core import Layout

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+) ?([\w.]*)\n(.*?)^```$", README, flags=re.DOTALL | re.MULTILINE)
ANSWERS = re.compile(
    r"^<!-- (\w+) -->\n\*\*(.*?)\*\*\n\n(.*?)\n\n!", flags=re.DOTALL | re.MULTILINE
)
NEEDS_TORCH = ("sh", "rl")
INSTALL = "python3 -m venv .venv && .venv/bin/pip install -e "


def run_command(line: str) -> None:
    words = shlex.split(line)
    assert words[0] == "warehouse", f"the README has a command of another program: {line}"
    with pytest.raises(SystemExit) as ended:
        main(cli.app, words[1:])
    assert not ended.value.code, f"{line} failed"


def test_every_block_of_the_readme_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("MPLBACKEND", "agg")
    names: dict[str, object] = {}
    for language, file, text in BLOCKS:
        if (language, file) == NEEDS_TORCH:
            continue
        if file:
            Path(file).write_text(text, encoding="utf-8")
        if language == "python":
            exec(compile(text, file or "README.md", "exec"), names)
        elif language == "sh":
            for line in text.splitlines():
                if not line.startswith(INSTALL):
                    run_command(line)
        elif language == "text":
            Layout.load(file)
        else:
            assert language == "toml"
    written = {path.name for path in tmp_path.iterdir()}
    assert {"replay.html", "replay.gif", "episode.npz", "hall.txt", "replay-12.gif"} <= written
    assert {"escape.html", "mine.csv", "mine.html", "figures"} <= written
    assert (tmp_path / "frames" / "legend.svg").exists()


@pytest.mark.learning
def test_the_commands_that_need_pytorch_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("MPLBACKEND", "agg")
    lines = [
        line for *kind, text in BLOCKS if tuple(kind) == NEEDS_TORCH for line in text.split("\n")
    ]
    for line in filter(None, lines):
        run_command(line)
    assert (tmp_path / "model.png").exists()


@pytest.mark.slow
def test_the_answers_of_the_presets_are_those_that_they_give(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = ANSWERS.findall(README)
    assert [preset for preset, *_ in blocks] == list(PRESETS)
    for preset, question, answer in blocks:
        run_command(f"warehouse sweep --preset {preset} -o {preset}.sqlite")
        capsys.readouterr()
        run_command(f"warehouse report {preset}.sqlite --no-replays")
        lines = capsys.readouterr().out.splitlines()
        assert question in lines
        given = lines[lines.index(question) + 1 :]
        rest = " ".join(answer.split())
        while rest:
            [sentence] = [line for line in given if line and rest.startswith(line)]
            rest = rest.removeprefix(sentence).lstrip()


def test_the_two_install_commands_are_the_ones_that_ci_runs():
    commands = [line for line in README.splitlines() if line.startswith(INSTALL)]
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    searched = re.findall(r"readme_line '([^']*)'", ci)
    assert [sum(words in line for line in README.splitlines()) for words in searched] == [1, 1]
    assert all(words in line for words, line in zip(searched, commands, strict=True))
    assert len(commands) == 2


def test_the_animation_on_the_first_screen_exists_and_moves():
    from PIL import Image

    pictures = re.findall(r"!\[.*?\]\((.*?)\)", README)
    assert all((ROOT / picture).is_file() for picture in pictures)
    picture = re.search(r"!\[.*?\]\((.*?)\)", README)
    assert picture is not None
    with Image.open(ROOT / picture.group(1)) as image:
        assert image.n_frames > 10


def test_the_readme_names_no_file_that_is_not_there():
    table = README.split("## Where things are")[1].split("\n\n")[1]
    for row in table.splitlines()[2:]:
        folder = None
        for name in re.findall(r"`([\w/]+\.py)`", row):
            folder = Path(name).parent if "/" in name else folder
            assert folder is not None
            assert (ROOT / folder / Path(name).name).is_file(), name
