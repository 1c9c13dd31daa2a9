"""The picture of a conflict tree."""

from itertools import pairwise

import pytest
from matplotlib.patches import Rectangle

from agents.mapf.cbs import Conflict, ConflictTree, Constraint
from agents.mapf.graph import Graph
from agents.mapf.problem import Problem
from agents.mapf.tree_picture import CARD, SOLUTION, places_of, tree_picture, words_of
from warehouse_core import Layout

GAP = Layout(["..#..", ".....", "..#.."])


def grown(starts: list[int], goals: list[int], layout: Layout = GAP) -> ConflictTree:
    tree = ConflictTree(Problem(Graph(layout), starts, goals))
    tree.solve(10)
    return tree


def test_the_tree_has_a_card_for_each_node_and_marks_the_solution() -> None:
    tree = grown([5, 9], [9, 5])
    assert tree.solution is not None
    assert not tree.solution.conflicts
    axes = tree_picture(tree).axes[1]
    cards = [
        patch
        for patch in axes.patches
        if isinstance(patch, Rectangle) and not patch.get_fill() and patch.get_width() == CARD[0]
    ]
    said = [text.get_text() for text in axes.texts]
    costs = [f"cost {node.cost}" for node in tree.nodes]
    assert len(cards) == len(tree.nodes) > 5
    assert [words for words in said if words.startswith("cost")] == costs
    marked = [
        number
        for number, card in enumerate(cards)
        if card.get_edgecolor()[:3] == pytest.approx(SOLUTION)
    ]
    assert marked == [tree.nodes.index(tree.solution)]
    assert said.count("★ optimal plan") == 1
    assert said[said.index("★ optimal plan") - 1] == f"cost {tree.solution.cost}"
    assert len(axes.lines) == len(tree.nodes) - 1
    for node in tree.nodes[1:]:
        assert words_of(tree, node.constraint) in said
    opened = [words_of(tree, node.split) for node in tree.nodes if node.split]
    assert [words for words in said if words in opened] == opened


def test_lines_lead_from_parents_to_children_and_no_cards_overlap() -> None:
    tree = grown([5, 9], [9, 5])
    places = places_of(tree.nodes)
    for node, (column, level) in places.items():
        children = [places[each] for each in tree.nodes if each.parent is node]
        assert {below for _, below in children} <= {level + 1}
        if children:
            assert column == sum(each for each, _ in children) / len(children)
    by_level: dict[int, list[float]] = {}
    for column, level in places.values():
        by_level.setdefault(level, []).append(column)
    assert all(b - a >= 1 for row in by_level.values() for a, b in pairwise(sorted(row)))


def test_constraints_and_conflicts_are_told_in_words() -> None:
    tree = ConflictTree(Problem(Graph(GAP), [0], [1]))
    assert words_of(tree, Constraint(3, 2, 6)) == "3 not in (1, 1) at 2"
    assert words_of(tree, Constraint(3, 2, 7, 6)) == "3 not (1, 1)→(1, 2) at 2"
    assert words_of(tree, Constraint(3, 4, None)) == "3 arrives after step 4"
    meet = Conflict(Constraint(0, 1, 0), Constraint(2, 1, 0))
    assert words_of(tree, meet) == "0 and 2 in (0, 0) at 1"
    swap = Conflict(Constraint(0, 1, 1, 0), Constraint(2, 1, 0, 1))
    assert words_of(tree, swap) == "0, 2 swap (0, 0), (0, 1) at 1"
    late = Conflict(Constraint(0, 4, None), Constraint(1, 4, None))
    assert words_of(tree, late) == "0 and 1: all shortest ways meet"


def test_a_tree_of_one_node_is_drawn_and_one_without_or_with_many_is_not() -> None:
    tree = grown([0], [1])
    assert "★ optimal plan" in [text.get_text() for text in tree_picture(tree).axes[1].texts]
    with pytest.raises(ValueError, match=r"the conflict tree has 0 nodes; a picture has 1\.\.31"):
        tree_picture(ConflictTree(tree.problem))
    with pytest.raises(ValueError, match="the conflict tree has 33 nodes"):
        tree_picture(grown([5, 1, 13], [9, 13, 1]))
