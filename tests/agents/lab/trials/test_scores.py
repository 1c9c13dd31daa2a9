"""Agents are compared by the outcomes of the same episodes."""

import math

import pytest
from matplotlib.text import Text

from agents.lab.trials.figure import message, scores_figure
from agents.lab.trials.scores import MEASURES, Run, Scores, Task, evaluate
from agents.run_episode import run_episode
from agents.search.agents import SearchAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Layout, Observation
from warehouse_core.records.failure_modes import diagnose

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
GOOD, BAD = Run(True, 20, 10.0, 40.0, 900.0, 5), Run(False, 200, 10.0, 400.0, 9000.0, 95)


class Waiter:
    """Waits, and records the calls of its methods."""

    def __init__(self, notes: list[object]) -> None:
        self.notes = notes

    def reset(self) -> None:
        self.notes.append("reset")

    def act(self, observation: Observation) -> str:
        self.notes.append(observation["steps"])
        return "WAIT"


@pytest.mark.parametrize(
    "task",
    [
        Task(battery=20),
        Task(ROOM, 100, 5),
        Task(backend="physics"),
        Task(ROOM, 50, 50, "grid", None, "start"),
        Task(ROOM, 50, 50, "grid", (2, 1), False),
    ],
)
def test_the_episodes_are_those_of_run_episode(task: Task) -> None:
    seeds = range(100, 115) if task.backend == "grid" else range(100, 102)
    scores = evaluate(GreedyAgent, task, seeds)
    for seed, run in zip(seeds, scores.runs, strict=True):
        episode = run_episode(
            "greedy", task.backend, task.layout, seed, task.battery, task.max_steps,
            start_pos=task.start_pos, randomize=task.randomize,
        )  # fmt: skip
        assert run == Run(
            episode.terminated, episode.steps, float(diagnose(episode).needed or 0),
            episode.seconds, episode.joules, 0,
        )  # fmt: skip
    assert scores.lengths.tolist() == [run.steps for run in scores.runs]
    assert scores.delivered.tolist() == [run.delivered for run in scores.runs]
    assert scores.delivered.any()


def test_the_environment_of_a_task_has_its_settings() -> None:
    env = Task(ROOM, 100, 5, "physics").make_env()
    assert (env.layout, env.max_battery, env.max_steps) == (ROOM, 100, 5)
    env.close()


def test_an_agent_is_made_for_each_seed_and_reset_before_it_acts() -> None:
    notes: list[object] = []

    def make(seed: int) -> Waiter:
        notes.append(f"seed {seed}")
        return Waiter(notes)

    scores = evaluate(make, Task(max_steps=2), [7, 5])
    assert notes == ["seed 7", "reset", 0, 1, "seed 5", "reset", 0, 1]
    assert scores.delivered.tolist() == [False, False]
    assert scores.lengths.tolist() == [2, 2]


def test_the_nodes_that_an_agent_expanded_are_counted() -> None:
    layout = Task().layout
    [astar] = evaluate(lambda _: SearchAgent(layout), Task(), [3]).runs
    [ucs] = evaluate(lambda _: SearchAgent(layout, "ucs"), Task(), [3]).runs
    assert astar.steps == ucs.steps == astar.needed
    assert 0 < astar.expanded < ucs.expanded


def test_needed_is_nan_if_there_is_no_path() -> None:
    layout = Layout(["########", "#..##..#", "#..##..#", "########"])
    runs = evaluate(GreedyAgent, Task(layout, 9, 9), range(20)).runs
    cut_off = [run for run in runs if math.isnan(run.needed)]
    assert cut_off
    assert not any(run.delivered for run in cut_off)


def test_failures_count_in_all_measures_but_the_ratio_to_the_fewest_steps() -> None:
    scores = Scores([GOOD] * 30 + [BAD] * 10)
    found = {each.column.split("\n")[0]: each.of(scores) for each in MEASURES}
    assert {name: interval and interval.estimate for name, interval in found.items()} == {
        "success": 0.75, "steps a delivery": pytest.approx((30 * 20 + 10 * 200) / 30),
        "of the fewest": 2, "expanded": pytest.approx(27.5),
        "seconds a delivery": pytest.approx((30 * 40 + 10 * 400) / 30),
        "joules a delivery": pytest.approx((30 * 900 + 10 * 9000) / 30),
    }  # fmt: skip
    assert Scores([BAD]).steps is None


def test_an_agent_that_makes_only_short_deliveries_does_not_score_better() -> None:
    choosy, thorough = Scores([GOOD] * 20 + [BAD] * 20), Scores([GOOD._replace(steps=30)] * 40)
    assert choosy.steps is not None
    assert thorough.steps is not None
    assert choosy.steps.low > thorough.steps.high


def test_the_figure_has_a_mark_for_each_agent_in_each_panel() -> None:
    scores = {"one": Scores([GOOD] * 30), "a" * 60: Scores([GOOD] * 3)}
    figure = scores_figure(scores, "A title", "What is measured.")
    assert [axes.get_title(loc="left") for axes in figure.axes] == [each.title for each in MEASURES]
    assert "What is measured." in [text.get_text() for text in figure.texts]
    values = [
        [bar.get_width() for bar in axes.patches]
        + [line.get_xdata()[0] for line in axes.lines if line.get_marker() == "o"]  # type: ignore[index]
        for axes in figure.axes
    ]
    assert values == [[1, 1], [20, 20], [2, 2], [5, 5], [40, 40], [900, 900]]
    intervals = [sum(line.get_marker() == "|" for line in axes.lines) for axes in figure.axes]
    assert intervals == [2, 1, 1, 1, 1, 1]
    drawn = figure.get_tightbbox(figure.canvas.get_renderer())  # type: ignore[attr-defined]
    width, height = figure.get_size_inches()
    assert drawn.x0 >= 0
    assert drawn.x1 <= width
    assert drawn.y1 <= height


def test_an_agent_without_deliveries_has_a_text_instead_of_a_mark() -> None:
    figure = scores_figure({"one": Scores([BAD] * 3)}, "")
    figure.pixels()
    assert [len(axes.patches) for axes in figure.axes] == [2, 0, 0, 1, 0, 0]
    words = [[text.get_text() for text in axes.texts] for axes in figure.axes[1:]]
    assert words == [["no delivery"], ["no delivery"], [], ["no delivery"], ["no delivery"]]


def test_failures_are_counted_and_fill_the_bars_of_deliveries() -> None:
    figure = scores_figure({"one": Scores([GOOD] * 30 + [BAD] * 10), "two": Scores([GOOD])}, "")
    first = figure.axes[0]
    assert [text.get_text() for text in first.texts] == ["failed", "10", "0"]
    bars = sorted((bar.get_x(), bar.get_width()) for bar in first.patches)  # type: ignore[attr-defined]
    assert bars == [(0, 0.75), (0, 1), (0.75, 0.25)]


SLOW = Run(True, 30, 10.0, 40.0, 900.0, 5)


@pytest.mark.parametrize(
    ("scores", "said"),
    [
        ({"a": [BAD] * 2}, "No agent delivered in 2 episodes"),
        ({"a": [GOOD]}, "All 1 delivered by a, at 20 steps a delivery"),
        (
            {"a": [BAD] * 3, "b": [SLOW, SLOW, SLOW], "c": [GOOD, GOOD, BAD], "d": [GOOD] * 3},
            "All 3 delivered by b and d, at 20 to 30 steps a delivery;\n"
            "c failed 1 time, at 120 steps",
        ),
        (
            {"a": [BAD] * 2, "b": [GOOD, BAD]},
            "Most delivered by b: 1 of 2, at 220 steps a delivery;\na failed 2 times",
        ),
        (
            dict.fromkeys("abcde", [GOOD] * 2),
            "All 2 delivered by 5 agents, at 20 steps a delivery",
        ),
    ],
)
def test_the_message_is_computed_from_the_scores(scores: dict[str, list[Run]], said: str) -> None:
    assert message({name: Scores(runs) for name, runs in scores.items()}) == said


def test_the_message_is_the_largest_text_however_long_it_is() -> None:
    scores = {f"{name}{'n' * 60}": Scores([GOOD]) for name in "abcd"}
    figure = scores_figure(scores, "200 episodes", "What is measured.")
    figure.pixels()
    [said] = [text for text in figure.texts if text.get_text().startswith("All 1 delivered")]
    assert said.get_fontsize() > max(
        text.get_fontsize() for text in figure.findobj(Text) if text is not said
    )
    box = said.get_window_extent()
    [below] = [text for text in figure.texts if text.get_text() == "200 episodes"]
    assert said.get_text().count("\n") >= 1
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1
    assert below.get_window_extent().y1 <= box.y0
    assert below.get_window_extent().y0 > figure.axes[0].title.get_window_extent().y1
