import numpy as np
import pytest
from helpers.results_files import BAD, row, scores_of

from agents.lab.training.curve import learning_curve
from agents.lab.training.exams import ExamPoint
from agents.lab.trials.scores import Scores


def scores(success: float, count: int = 200) -> Scores:
    good = round(success * count)
    return scores_of([row(0, steps=14)] * good + [BAD] * (count - good))


POINTS = [ExamPoint(60_000 * (n + 1), scores(s)) for n, s in enumerate((0, 0.1, 0.5, 0.98, 1))]


def test_the_picture_has_its_final_values_its_lines_and_the_band_of_their_intervals() -> None:
    figure = learning_curve("PPO", "A title", POINTS, scores(0.87, 1000))
    assert figure.get_suptitle() == "A title"
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "delivered: 100.0%, greedy 87.0%", "mean steps: 14.0, greedy 38.2",
    ]  # fmt: skip
    [legend] = figure.legends
    assert [each.get_text() for each in legend.get_texts()] == ["PPO, with 95% intervals", "greedy"]
    success, length = (np.asarray(axes.lines[0].get_xydata()) for axes in figure.axes)
    assert success[:, 0].tolist() == [60_000, 120_000, 180_000, 240_000, 300_000]
    assert success[:, 1].tolist() == [0, 0.1, 0.5, 0.98, 1]
    expected = [200, 0.1 * 14 + 0.9 * 200, 107, 0.98 * 14 + 0.02 * 200, 14]
    assert length[:, 1] == pytest.approx(expected), "failures included"
    (band,) = figure.axes[0].collections
    (outline,) = band.get_paths()
    corners = {(round(x), round(y, 4)) for x, y in np.asarray(outline.vertices).tolist()}
    for point in POINTS:
        for end in point.scores.success[1:]:
            assert (point.steps, round(end, 4)) in corners
