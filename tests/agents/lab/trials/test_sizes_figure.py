from helpers.results_files import BAD, GOOD, scores_of

from agents.lab.trials.sizes_figure import PANELS, sizes_figure

GROUPS = {
    "small": {"one": scores_of([GOOD] * 30), "a" * 60: scores_of([GOOD] * 20 + [BAD] * 10)},
    "large": {"one": scores_of([BAD] * 30), "a" * 60: scores_of([GOOD] * 30)},
}


def test_each_task_has_its_message_its_title_and_its_panels() -> None:
    figure = sizes_figure(GROUPS, "What is measured.")
    figure.pixels()
    assert [axes.get_title(loc="left") for axes in figure.axes] == 2 * [p.title for p in PANELS]
    texts = [text.get_text() for text in figure.texts]
    assert texts[0].startswith("All 30 delivered by one, at 20 steps a delivery;")
    assert texts[1::2] == ["small", "large"]
    assert texts[4] == "What is measured."
    failures = [[text.get_text() for text in axes.texts] for axes in figure.axes[::3]]
    assert failures == [["failed", "0", "10"], ["failed", "30", "0"]]


def test_nothing_overlaps_or_leaves_the_figure() -> None:
    figure = sizes_figure(GROUPS, "What is measured.")
    figure.pixels()
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    panels = [axes.get_tightbbox(renderer) for axes in figure.axes]
    boxes = [*panels, *(text.get_window_extent() for text in figure.texts)]
    for number, box in enumerate(boxes):
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.x1
        assert box.y0 >= 0
        assert box.y1 <= figure.bbox.y1
        assert not [other for other in boxes[:number] if box.overlaps(other)], number
