"""Tests of the README and the handbook: every block runs, and the statements are true."""

import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jupytext
import matplotlib.pyplot as plt
import pytest
from helpers.command_line import ROOT, without_display
from helpers.handbook import (
    CELL,
    COMMAND,
    HANDBOOK,
    INSTALL,
    PAGES,
    RAY,
    TEST,
    TORCH,
    blocks_of,
    run_command,
    run_page,
)
from helpers.lab_notebook import NOTEBOOK, PAGE, lab_notebook

from agents.lab.commands import train
from agents.lab.commands.fleet import fleet
from agents.lab.experiments.sweep import PRESETS
from agents.lab.grading.cases import GradedCase, is_right
from agents.lab.grading.child import as_value
from agents.lab.grading.rubric import SOLUTIONS, find_rubric, load_rubric
from agents.lab.training import exams
from warehouse_core import FleetEnv
from warehouse_core.viz.replay import Replay

README = ROOT / "README.md"
TEXTS = {page: page.read_text(encoding="utf-8") for page in (README, *PAGES)}
ANSWERS = re.compile(
    r"^<!-- (\w+) -->\n\*\*(.*?)\*\*\n\n(.*?)\n\n!", flags=re.DOTALL | re.MULTILINE
)
FRAMES_APART, MAX_STEPS = 10, 60
"""Frames between two of a saved replay, and the longest shift of a command, in pages."""

MAX_PICTURE_BYTES = 250_000
GLOSSARY, PROMISES = HANDBOOK / "glossary.md", HANDBOOK / "promises.md"
EXAMPLE = re.compile(r"(\w+\(.*\)) {2,}([^\s:].*?)(?:: .*)?$")
"""A call and its result in the text of an exercise, optionally followed by a remark."""

HEADINGS = re.compile(r"^#+ (.*)$", flags=re.MULTILINE)
WITHOUT_TERMS = {"README", "index", "coming_from", "glossary", "promises"}
"""Pages without links to terms, because they lead to other pages or explain names of programs."""

each_page = pytest.mark.parametrize("page", TEXTS, ids=[page.stem for page in TEXTS])


@pytest.fixture(autouse=True)
def in_a_folder_without_a_display(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, small_pictures: None
) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))  # because a page sets it
    without_display(monkeypatch)
    yield
    plt.close("all")


def some_frames(replay: Replay) -> Iterator[int]:
    """Return every ``FRAMES_APART``-th frame and the last one."""
    return iter([*range(0, len(replay._scene) - 1, FRAMES_APART), len(replay._scene) - 1])


def slug(heading: str) -> str:
    """Return the anchor of a heading, as on GitHub."""
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


@pytest.fixture
def less_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Save only some frames of each replay, train, drive and grade less, and use one process."""

    def short(*arguments: Any, max_steps: int, **settings: Any) -> FleetEnv:
        return FleetEnv(*arguments, max_steps=min(max_steps, MAX_STEPS), **settings)

    def few(case: GradedCase) -> range:
        return range(case.first_seed, case.first_seed + min(case.episodes, 2))

    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr(fleet, "FleetEnv", short)
    monkeypatch.setattr(GradedCase, "seeds", property(few))
    monkeypatch.setattr(Replay, "new_saved_frame_seq", some_frames)
    kind = train.KINDS["q"]
    monkeypatch.setitem(train.KINDS, "q", kind._replace(steps=kind.steps // 20))
    monkeypatch.setattr(exams, "EXAM_SEEDS", exams.EXAM_SEEDS[:5])
    monkeypatch.setattr(train, "FINAL_SEEDS", train.FINAL_SEEDS[:20])


@each_page
def test_every_block_of_a_page_runs(page: Path, less_work: None) -> None:
    run_page(page)
    if page.stem == "grading":  # this page continues with the files of its first run
        run_page(page)


@pytest.mark.learning
def test_the_commands_that_need_pytorch_run() -> None:
    run_page(HANDBOOK / "learning.md", TORCH)
    assert Path("model.png").exists()


@pytest.mark.learning
@pytest.mark.filterwarnings("ignore")  # warnings of libraries, in the names of others
def test_the_programs_for_other_libraries_run_and_learn() -> None:
    import torch

    torch.set_num_threads(1)  # more are slower for networks of this size
    names: dict[str, Any] = run_page(HANDBOOK / "libraries.md", TORCH)
    rewards = names["rewards_of_updates"]
    assert sum(rewards[-10:]) > sum(rewards[:10]) + 3
    goals, delivered = names["goals"], 0
    for seed in range(20):
        observation, _ = goals.reset(seed=seed)
        ended = False
        while not ended:
            action, _ = names["hindsight"].predict(observation, deterministic=True)
            observation, _, terminated, truncated, _ = goals.step(int(action))
            ended = terminated or truncated
        delivered += terminated
    assert delivered >= 18
    assert names["rollout"]["next", "reward"].shape == (100, 1)
    assert all(each.grad is not None for each in names["actor"].parameters())


@pytest.mark.neighbours
@pytest.mark.filterwarnings("ignore")  # warnings of libraries, in the names of others
def test_the_programs_for_tianshou_and_rllib_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    names: dict[str, Any] = run_page(HANDBOOK / "libraries.md", RAY)
    assert (names["tianshou_result"].train_step, names["tianshou_result"].update_step) == (400, 10)
    assert names["rllib_result"]["env_runners"]["num_env_steps_sampled"] == 400


@each_page
def test_every_block_is_of_a_kind_that_is_run(page: Path) -> None:
    fences = re.findall(r"^```+([^`\s]+)", TEXTS[page], flags=re.MULTILINE)
    names = "code-cell", "eval-rst", "glossary", "literalinclude", "only", "toctree"
    assert {*fences} <= {"sh", "python", "text", *(f"{{{name}}}" for name in names)}
    run = [block for block in blocks_of(page) if block.language in ("sh", CELL)]
    assert len(run) == sum(kind in ("sh", "python", "{code-cell}") for kind in fences)
    for block in run:
        if block.language == "sh":
            assert all(line.startswith((COMMAND, INSTALL)) for line in block.text.splitlines())


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_a_page_with_cells_is_a_notebook(page: Path) -> None:
    cells = [each.source for each in jupytext.read(page).cells if each.cell_type == "code"]
    assert not [cell for cell in cells if "assert " in cell], "readers of a notebook see it"
    assert TEXTS[page].count("<!-- test\n") == sum(b.language == TEST for b in blocks_of(page))
    run = [each for each in blocks_of(page) if each.language == CELL and not each.needs]
    assert cells == [block.text.rstrip("\n") for block in run]


def test_the_notebook_of_the_mini_lab_has_its_cells_and_installs_what_is_missing() -> None:
    assert NOTEBOOK.read_text(encoding="utf-8") == lab_notebook(), "see tests/helpers/lab_notebook"
    install, *cells = (cell for cell in jupytext.read(NOTEBOOK).cells if cell.cell_type == "code")
    assert [cell.source for cell in cells] == [
        block.text.rstrip("\n") for block in blocks_of(PAGE) if block.language == CELL
    ]
    code = install.source.replace("%pip install --quiet", "installed.append")
    code = code.replace('"$SOURCE"', "(SOURCE)")
    for is_missing, source, asked in ((False, "", []), (True, "x.whl", ["x.whl"])):
        names: dict[str, Any] = {"installed": []}
        module = "no_such_module" if is_missing else "warehouse_core"
        exec(code.replace("warehouse_core", module).replace('""', repr(source)), names)
        assert names["installed"] == asked
    with pytest.raises(ValueError, match="write the address"):
        exec(code.replace("warehouse_core", "no_such_module"), {})


@each_page
def test_all_that_a_page_names_exists(page: Path) -> None:
    links = re.findall(r"\]\((?!https?:)([^)#\s]+)[^)]*\)", TEXTS[page])
    named = re.findall(r"`((?:warehouse_\w+|agents|\.github)/[\w/.]*)`", TEXTS[page])
    assert [each for each in links if not (page.parent / each).exists()] == []
    assert [each for each in named if not (ROOT / each).exists()] == []


def test_the_places_and_tests_of_the_chapters_promises_exist() -> None:
    row = re.compile(r"^\| (\d+) \| (.*) \| (.*) \| (?:([^`]*), )?`(.*)` \|$", flags=re.MULTILINE)
    rows = row.findall(TEXTS[PROMISES])
    assert [int(number) for number, *_ in rows] == [*range(1, len(rows) + 1)]
    assert len(rows) >= 76
    for _, _, where, words, file in rows:
        assert "`" in where or "](" in where, where
        name = f"def test_{words.replace(' ', '_')}"
        assert (f"{name}(" if words else name) in (ROOT / file).read_text(encoding="utf-8")
        for page, anchor in re.findall(r"\]\((\w+\.md)#([^)]+)\)", where):
            assert anchor in map(slug, HEADINGS.findall(TEXTS[HANDBOOK / page])), where


def test_the_examples_of_exercises_are_what_their_solutions_answer() -> None:
    heading = re.compile(r"^### Exercise (\d+): (.*)$", flags=re.MULTILINE)
    parts, checked = heading.split(TEXTS[HANDBOOK / "exercises.md"]), 0
    assert parts[1::3] == [f"{number}" for number in range(1, 29)]
    for number, title, text in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        name = f"exercise-{int(number):02}"
        rubric = load_rubric(find_rubric(Path(name)))
        assert rubric.title.lower() == f"exercise {number}: {title}".lower()
        assert text.count(f"```{{literalinclude}} exercises/solutions/{name}.py\n") == 1
        known = runpy.run_path(str(SOLUTIONS / f"{name}.py"))
        for block in re.findall(r"^```text\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE):
            lines = block.splitlines()
            known["grid"] = tuple(line.split()[0] for line in lines if line.startswith("#"))
            for line in lines:
                if line.startswith("looks = "):
                    exec(line, known)
                if (found := EXAMPLE.search(line)) and "..." not in line:
                    answer, wanted = eval(found[1], known), eval(found[2])
                    assert is_right(as_value(answer), as_value(wanted)), line
                    checked += 1
    assert checked >= 20


def test_the_glossary_has_the_terms_that_pages_link_to() -> None:
    glossaries = re.findall(r"^```{glossary}\n(.*?)^```", TEXTS[GLOSSARY], flags=re.DOTALL | re.M)
    entries = [entry.split("\n    ") for part in glossaries for entry in part.strip().split("\n\n")]
    terms = [term for term, *_ in entries]
    assert len(terms) >= 60
    assert len({*terms}) == len(terms)
    assert all(words and words[-1].endswith(".") for _, *words in entries)
    ids = {f"term-{term.replace(' ', '-')}" for term in terms}
    for page, text in TEXTS.items():
        linked = re.findall(r"\(glossary\.md#([^)]+)\)", text)
        assert {*linked} <= ids, page
        assert linked or page.stem in WITHOUT_TERMS, page


def test_every_page_can_be_reached_from_the_first() -> None:
    for page in PAGES:
        assert page.name == "index.md" or f"\n{page.stem}\n" in TEXTS[HANDBOOK / "index.md"]
        is_listed = f"(agents/handbook/{page.name})" in TEXTS[README]
        assert is_listed == (page.stem != "index")


def test_the_first_page_begins_with_an_episode_an_install_line_and_six_lines_of_code() -> None:
    picture, install, code = [*blocks_of(HANDBOOK / "index.md")][:3]
    assert "\n:tags: [remove-input]\n" in TEXTS[HANDBOOK / "index.md"].partition(picture.text)[0]
    assert picture.text.splitlines()[-1].startswith("record_episode(")
    assert install.text.startswith(INSTALL)
    assert (code.language, len([line for line in code.text.splitlines() if line])) == (CELL, 6)


@pytest.mark.slow
def test_the_presets_give_the_answers_in_the_handbook(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = ANSWERS.findall(TEXTS[HANDBOOK / "experiments.md"])
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
    lines = TEXTS[README].splitlines()
    installing = [line for line in lines if line.startswith(INSTALL)]
    ci = (ROOT / ".ci" / "test").read_text(encoding="utf-8")
    searched = re.findall(r"run_readme_line '([^']*)'", ci)
    assert [sum(words in line for line in lines) for words in searched] == [1, 1]
    assert all(words in line for words, line in zip(searched, installing, strict=True))
    assert len(installing) == 2


def test_the_animation_on_the_first_screen_moves() -> None:
    picture = re.search(r"!\[.*?\]\((.*?)\)", TEXTS[README])
    assert picture is not None
    drawing = (ROOT / picture.group(1)).read_text(encoding="utf-8")
    assert drawing.count("<animate") > 10
    assert len(drawing.encode()) <= MAX_PICTURE_BYTES
