"""The figures that compare agents: marks, intervals, failures, and the message above them."""

import pytest
from helpers.results_files import BAD, GOOD, scores_of

from agents.lab.trials.figure import message, scores_figure
from agents.lab.trials.rows import Row

SLOW = GOOD._replace(steps=30)


def test_an_agent_without_deliveries_has_a_text_instead_of_a_mark() -> None:
    figure = scores_figure({"": {"one": scores_of([BAD] * 3)}})
    figure.pixels()
    assert [len(axes.patches) for axes in figure.axes] == [2, 0, 0, 1, 0, 0]
    words = [[text.get_text() for text in axes.texts] for axes in figure.axes[1:]]
    assert words == [["no delivery"], ["no delivery"], [], ["no delivery"], ["no delivery"]]


@pytest.mark.parametrize(
    ("scores", "said"),
    [
        ({"a": [BAD] * 2}, "No agent delivered in 2 episodes"),
        ({"a": [GOOD]}, "All 1 delivered by a, at 20 steps per delivery"),
        (
            {"a": [BAD] * 3, "b": [SLOW, SLOW, SLOW], "c": [GOOD, GOOD, BAD], "d": [GOOD] * 3},
            "All 3 delivered by b and d, at 20 to 30 steps per delivery",
        ),
        (
            {"a": [BAD] * 2, "b": [GOOD, BAD]},
            "Most, 1 of 2, delivered by b, at 220 steps per delivery",
        ),
        (
            dict.fromkeys("abcde", [GOOD] * 2),
            "All 2 delivered by 5 agents, at 20 steps per delivery",
        ),
    ],
)
def test_the_message_is_computed_from_the_scores(scores: dict[str, list[Row]], said: str) -> None:
    assert message({name: scores_of(runs) for name, runs in scores.items()}) == said
