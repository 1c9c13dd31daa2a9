"""The README: every code block runs, and its statements hold."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command_line import without_display

from agents import cli
from agents.commands import bench, train
from agents.console.main import main
from agents.experiments.sweep import PRESETS
from agents.learning import training
from warehouse_core.viz.replay import Replay

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+) ?([\w.]*)\n(.*?)^```$", flags=re.DOTALL | re.MULTILINE)
BLOCKS = [(kind, "" if kind == "sh" else file, text) for kind, file, text in BLOCK.findall(README)]
SECTIONS = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", README, flags=re.DOTALL | re.MULTILINE))
ANSWERS = re.compile(
    r"^<!-- (\w+) -->\n\*\*(.*?)\*\*\n\n(.*?)\n\n!", flags=re.DOTALL | re.MULTILINE
)
TORCH = ("sh", "rl")
INSTALL = "python3 -m venv .venv && .venv/bin/pip install -e "
WRITTEN = {
    "What to try first": {"replay.html", "replay.gif", "episode.npz", "hall.txt"},
    "Write an agent": {"replay-Wanderer-grid-3.gif"},
    "Write a layout": {"replay-GreedyAgent-grid-5.gif"},
    "Change one word: physics": {"both.html"},
    "Several robots": {"replay-greedy-grid-12.html", "replay-greedy-grid-12-2.html"},
    "Planning for several robots": {"replay-pibt-lanes-grid-12.html", "planners.png"},
    "From plans to bodies": {"replay-windowed-lanes-driving-12.html", "gap.html"},
    "Gymnasium, one or thousands": set(),
    "Learn": {"table.npz", "table.png"},
    "Search": {"explore.html", "search.html", "agents.png", "benchmark.txt"},
    "Experiments": {"escape.html", "mine.csv", "mine.html", "figures"},
}
"""The sections that have commands, and files that these write."""

FRAMES_APART = 10


def run_command(line: str) -> None:
    words = shlex.split(line)
    assert words[0] == "warehouse", f"the README has a command of another program: {line}"
    with pytest.raises(SystemExit) as ended:
        main(cli.app, words[1:])
    assert not ended.value.code, f"{line} failed"


@pytest.fixture(autouse=True)
def in_a_folder_without_a_display(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, small_pictures: None
) -> None:
    monkeypatch.chdir(tmp_path)
    without_display(monkeypatch)


def some_frames(replay: Replay) -> Iterator[int]:
    """Return every ``FRAMES_APART``-th frame, and the last."""
    return iter([*range(0, len(replay._scene) - 1, FRAMES_APART), len(replay._scene) - 1])


@pytest.fixture
def less_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Save some frames of each replay, train for fewer steps and measure fewer steps."""
    monkeypatch.setattr(Replay, "new_saved_frame_seq", some_frames)
    steps, *others = train.train_q.__defaults__ or ()
    monkeypatch.setattr(train.train_q, "__defaults__", (steps // 20, *others))
    monkeypatch.setattr(training, "EXAM_SEEDS", training.EXAM_SEEDS[:5])
    monkeypatch.setattr(train, "FINAL_SEEDS", train.FINAL_SEEDS[:20])
    for name in ("STEPS", "FRAMES", "BATCH_STEPS", "MAX_STEPS"):
        monkeypatch.setattr(bench, name, 5)


def write_files() -> None:
    """Write each block that has a file's name."""
    for _, file, text in BLOCKS:
        if file:
            Path(file).write_text(text, encoding="utf-8")


def commands(section: str, torch: bool = False) -> list[str]:
    """Return the commands of a section, except the two that install."""
    blocks = [text for *kind, text in BLOCK.findall(section) if (tuple(kind) == TORCH) == torch]
    lines = [line for text in blocks for line in text.splitlines()]
    return [line for line in lines if line.startswith("warehouse ")]


def test_every_block_is_of_a_kind_that_is_run() -> None:
    kinds = {language for language, *_ in BLOCKS}
    assert kinds == {"sh", "python", "text", "toml"}
    lines = [line for language, _, text in BLOCKS if language == "sh" for line in text.splitlines()]
    assert all(line.startswith(("warehouse ", INSTALL)) for line in lines)


def test_the_python_of_the_readme_runs() -> None:
    write_files()
    names: dict[str, object] = {}
    for language, file, text in BLOCKS:
        if language == "python":
            exec(compile(text, file or "README.md", "exec"), names)
    assert Path("frames", "legend.svg").exists()


def test_the_agent_of_the_readme_acts_in_the_loop_of_the_readme() -> None:
    [own] = [text for _, file, text in BLOCKS if file == "my_agent.py"]
    [loop] = [text for kind, _, text in BLOCKS if kind == "python" and "while not done" in text]
    names: dict[str, object] = {}
    exec(own, names)
    exec(loop.replace("GreedyAgent(seed=12)", "Wanderer(seed=12)"), names)
    assert names["done"] is True


@pytest.mark.parametrize("title", WRITTEN)
def test_the_commands_of_the_readme_run(title: str, less_work: None) -> None:
    write_files()
    for line in commands(SECTIONS[title]):
        run_command(line)
    assert {path.name for path in Path().iterdir()} >= WRITTEN[title]


def test_every_section_with_commands_is_run() -> None:
    assert [title for title, text in SECTIONS.items() if commands(text)] == list(WRITTEN)


@pytest.mark.learning
def test_the_commands_that_need_pytorch_run() -> None:
    for line in commands(README, torch=True):
        run_command(line)
    assert Path("model.png").exists()


@pytest.mark.slow
def test_the_presets_give_the_answers_in_the_readme(
    capsys: pytest.CaptureFixture[str],
) -> None:
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


def test_the_two_install_commands_are_the_ones_that_ci_runs() -> None:
    installing = [line for line in README.splitlines() if line.startswith(INSTALL)]
    ci = (ROOT / ".ci" / "test").read_text(encoding="utf-8")
    searched = re.findall(r"run_readme_line '([^']*)'", ci)
    assert [sum(words in line for line in README.splitlines()) for words in searched] == [1, 1]
    assert all(words in line for words, line in zip(searched, installing, strict=True))
    assert len(installing) == 2


def test_the_animation_on_the_first_screen_exists_and_moves() -> None:
    from PIL import Image

    pictures = re.findall(r"!\[.*?\]\((.*?)\)", README)
    assert all((ROOT / picture).is_file() for picture in pictures)
    picture = re.search(r"!\[.*?\]\((.*?)\)", README)
    assert picture is not None
    with Image.open(ROOT / picture.group(1)) as image:
        assert image.n_frames > 10


def test_every_file_that_the_readme_names_exists() -> None:
    paths = re.findall(r"`((?:warehouse_\w+|agents|\.github)/[\w/.]*)`", README)
    assert len(paths) > 20
    assert [path for path in paths if not (ROOT / path).exists()] == []
