"""The picture of a conflict tree."""

import pytest
from matplotlib.patches import Rectangle

from agents.mapf.cbs import Conflict, ConflictTree
from agents.mapf.graph import Graph
from agents.mapf.problem import Problem
from agents.mapf.rules import Constraint
from agents.mapf.tree_picture import CARD, SOLUTION, tree_picture, words_of
from warehouse_core import Layout

GAP = Layout(["..#..", ".....", "..#.."])


def grown(starts: list[int], goals: list[int], layout: Layout = GAP) -> ConflictTree:
    tree = ConflictTree(Problem(Graph(layout), starts, goals))
    tree.solve(10)
    return tree


def test_the_tree_has_a_card_for_each_node_and_marks_the_solution() -> None:
    tree = grown([7, 11, 1], [11, 4, 5])
    assert tree.solution is not None
    assert not tree.solution.conflicts
    axes = tree_picture(tree).axes[1]
    cards = [
        patch
        for patch in axes.patches
        if isinstance(patch, Rectangle) and not patch.get_fill() and patch.get_width() == CARD[0]
    ]
    assert len(cards) == len(tree.nodes) > 5
    marked = [
        number
        for number, card in enumerate(cards)
        if card.get_edgecolor()[:3] == pytest.approx(SOLUTION)
    ]
    assert marked == [tree.nodes.index(tree.solution)]
    assert len(axes.lines) == len(tree.nodes) - 1


def test_the_floor_has_walls_starts_and_goals_with_the_numbers_of_their_robots() -> None:
    floor = tree_picture(grown([5, 9], [9, 0])).axes[0]
    walls = [patch.get_bbox().bounds for patch in floor.patches]  # type: ignore[attr-defined]
    assert walls == [(2, 0, 1, 1), (2, 2, 1, 1)]
    marks = [
        (str(line.get_marker()), *(int(place) for place in line.get_xydata()[0]))
        for line in floor.lines
    ]
    assert marks == [("o", 0, 1), ("s", 4, 1), ("o", 4, 1), ("s", 0, 0)]
    for line, text in zip(floor.lines, floor.texts, strict=True):
        assert list(text.get_position()) == line.get_xydata()[0].tolist()
    assert [text.get_text() for text in floor.texts] == ["0", "0", "1", "1"]
    cell = 72 * floor.get_position().width * floor.get_figure().get_figwidth() / 5  # type: ignore
    for line, text in zip(floor.lines, floor.texts, strict=True):
        assert 0.3 * cell < line.get_markersize() < 0.6 * cell
        assert 0.5 < text.get_fontsize() / line.get_markersize() < 0.8
    assert (floor.get_xlim(), floor.get_ylim()) == ((0, 5), (3, 0))


def test_nothing_in_the_picture_of_a_tree_overlaps_or_leaves_it() -> None:
    figure = tree_picture(grown([7, 11, 1], [11, 4, 5]))
    figure.pixels()
    boxes = [axes.get_window_extent() for axes in figure.axes]
    boxes += [text.get_window_extent() for text in figure.texts]
    for number, box in enumerate(boxes):
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1
        assert not any(box.overlaps(other) for other in boxes[:number])
    title = figure.texts[0].get_text()
    assert title == "Conflict-based search, 3 robots: cost 12 after 8 nodes"


def test_constraints_and_conflicts_are_told_in_words() -> None:
    tree = ConflictTree(Problem(Graph(GAP), [0], [1]))
    for rule, words in {
        Constraint(3, 2, 6): "3 not in (1, 1) at 2",
        Constraint(3, 2, 6, holds=True): "3 in (1, 1) at 2",
        Constraint(3, 2, 7, 6): "3 not (1, 1)→(1, 2) at 2",
        Constraint(3, 4, None): "3 arrives after step 4",
    }.items():
        assert words_of(tree, [rule]) == words
    both = [Constraint(3, 4, None, holds=True), Constraint(0, 5, None)]
    assert words_of(tree, both) == "3 by step 4, 0 after step 5"
    for conflict, words in {
        Conflict((0, 2), 1, 0): "0 and 2 in (0, 0) at 1",
        Conflict((0, 2), 1, 1, 0): "0, 2 swap (0, 0), (0, 1) at 1",
        Conflict((0, 1), 4, None): "0 and 1: shortest ways meet",
    }.items():
        assert words_of(tree, conflict) == words


def test_a_tree_of_one_node_is_drawn_and_one_without_or_with_many_is_not() -> None:
    tree = grown([0], [1])
    assert "★ optimal plan" in [text.get_text() for text in tree_picture(tree).axes[1].texts]
    with pytest.raises(ValueError, match=r"the conflict tree has 0 nodes; a picture has 1\.\.31"):
        tree_picture(ConflictTree(tree.problem))
    with pytest.raises(ValueError, match="the conflict tree has 39 nodes"):
        tree_picture(grown([8, 13, 6, 14], [5, 14, 8, 7]))
