import json
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Warehouse

from agents.lab.grading.cases import GradedCase
from agents.lab.grading.grading import grade
from agents.lab.grading.rubric import MINI_LAB, SOLUTIONS, load_rubric, own_rubrics
from agents.lab.grading.submissions import find_submission
from agents.lab.playground.page import exercise_settings
from agents.lab.playground.session import Session
from agents.registry import make_agent
from warehouse_core import DEFAULT_LAYOUT, Episode

STARTER = MINI_LAB.with_suffix(".py").read_text(encoding="utf-8")
AGENT = """class Agent:
    def reset(self):
        pass
    def act(self, observation):
        {}
"""


class Page:
    """A page: requests to a session, and the answers."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "agent.py"
        self._session = Session(self.file)

    def ask(self, **question: Any) -> dict[str, Any]:
        answer: dict[str, Any] = json.loads(
            self._session.answer(json.dumps(question), lambda done, total: None)
        )
        return answer

    def begin(self, do: str, code: str = STARTER, **more: Any) -> dict[str, Any]:
        start = {
            "exercise": "mini_lab", "code": code, "rows": DEFAULT_LAYOUT.rows, "seed": 1,
            "stations": "drawn",
        }  # fmt: skip
        return self.ask(do=do, start=start | more)


@pytest.fixture
def page(tmp_path: Path) -> Page:
    return Page(tmp_path)


def test_an_episode_is_that_of_warehouse_run(page: Page, tmp_path, warehouse: Warehouse) -> None:
    steps = [page.begin("step", seed=7)["steps"], page.ask(do="step", start=None)["steps"]]
    answer = page.ask(do="run", start=None)
    saved = tmp_path / "episode.npz"
    warehouse("run", "--agent", tmp_path / "agent.py", "--seed", 7, "-o", saved)
    expected = Episode.load(saved)
    assert steps == [1, 2]
    assert (answer["steps"], answer["ended"]) == (expected.steps, True)
    assert answer["summary"].endswith(f"; reward {expected.total_reward:.1f}")
    assert "<!DOCTYPE html>" in answer["page"]


@pytest.mark.parametrize("name", ["exercise-14", "exercise-21"])
def test_an_episode_of_an_exercise_is_as_the_exercise_has_it(name: str, page: Page) -> None:
    settings = exercise_settings(load_rubric(own_rubrics()[name]))
    stations = "drawn" if settings["drawn"] else "kept"
    code = (SOLUTIONS / f"{name}.py").read_text(encoding="utf-8")
    place = {"exercise": name, "rows": settings["rows"], "stations": stations}
    summaries = [page.begin("run", code, seed=seed, **place)["summary"] for seed in range(1, 6)]
    case = load_rubric(own_rubrics()[name]).first_case
    assert case is not None
    for seed, each in enumerate(summaries, 1):
        env, observation = case.begin(seed)
        agent, is_over = make_agent(str(page.file), seed, env.layout), False
        agent.reset()
        while not is_over:
            observation, _, terminated, truncated, _ = env.step(agent.act(observation))
            is_over = terminated or truncated
        assert f" in {env.state.steps} steps" in each


@pytest.mark.parametrize(
    ("code", "error", "line"),
    [
        ("\nx = ", "invalid syntax", 2),
        ("\n\n1 / 0", "division by zero", 3),
        ("pass", "agent.py has 0 classes with reset and act", None),
        (AGENT.format("return observation['nothing']"), "KeyError: 'nothing'", 5),
        (AGENT.format("return 1.5"), "action 1.5 is float", None),
        (AGENT.format("raise SystemExit(3)"), "SystemExit: 3", 5),
    ],
)
def test_an_error_has_the_line_of_the_agent(code, error, line, page) -> None:
    answer = page.begin("run", code)
    assert error in answer["error"]
    assert answer["line"] == line


def test_a_layout_that_is_none_is_named(page: Page) -> None:
    assert "row 1 has 1 columns" in page.begin("run", rows=["##", "#"])["error"]
    assert "page" not in page.ask(do="step", start=None)


def test_what_an_agent_prints_is_shown(page: Page) -> None:
    page.begin("step", AGENT.format("print(observation['steps']); return 'WAIT'"))
    assert page.ask(do="step", start=None)["printed"] == "1\n"


def test_a_grade_is_that_of_warehouse_grade(page: Page, tmp_path, monkeypatch) -> None:
    few = property(lambda case: range(case.first_seed, case.first_seed + 2))
    monkeypatch.setattr(GradedCase, "seeds", few)  # for speed
    code = STARTER.replace('self.random.choice("NESW")', '"WAIT"')
    answer = page.ask(do="grade", code=code, exercise="mini_lab")
    report = grade(find_submission(str(tmp_path / "agent.py")), load_rubric(MINI_LAB))
    assert answer["summary"].startswith(f"{report.points:g} of 100 points")
    assert [(row["name"], row["points"], row["seen"]) for row in answer["grades"]] == [
        (row.criterion.name, row.points, row.seen) for row in report.grades
    ]


def test_an_exercise_denies_what_its_rubric_denies_and_the_program_goes_on(page: Page) -> None:
    code = "import agents.search\ndistance = nearer_moves = print\n"
    answer = page.ask(do="grade", code=code, exercise="exercise-02")
    assert "the rubric denies the import of agents.search" in answer["summary"]
    assert page.ask(do="grade", code=STARTER, exercise="mini_lab")["points"] > 0


def test_a_grade_of_what_cannot_be_loaded_says_why(page: Page) -> None:
    answer = page.ask(do="grade", code="1 / 0", exercise="mini_lab")
    assert answer["points"] == 0
    assert "division by zero (agent.py, line 1)" in answer["summary"]
