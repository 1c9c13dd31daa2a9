"""The conflict tree of conflict-based search as a picture, for small problems."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from agents.mapf.cbs import Conflict, ConflictNode, ConflictTree
from agents.mapf.rules import Constraint
from warehouse_core.render.palette import COLORS, FAINT, INK, PAPER, SHELF
from warehouse_core.viz.axes import box_in, draw_grid
from warehouse_core.viz.figure import SceneFigure, make_figure
from warehouse_core.wording import counted
from warehouse_core.world.tiles import DROPOFF, ROBOT_EMPTY, WALL, Cell

__all__ = ["tree_picture"]

MAX_NODES = 31

CARD, GAP = (2.65, 1.3), (0.2, 0.5)
"""Width and height of a node and between nodes, in inches."""

HEAD = 0.36
"""Height of the strip with the constraints, in inches."""

TITLE, MARGIN, FLOOR_CELL, MAX_FLOOR, MIN_FLOOR = 0.85, 0.35, 0.75, 4.5, 2.9
SMALL, LARGE, TITLE_SIZE = 13, 20, 21
"""Sizes of words, in points."""

HOW_TO_READ = """Discs are starts, squares are goals.

Black: what is true of a robot
in this node and below.
Under the cost: the conflict that
the two children decide by what
one robot does, or does not do.
Not opened: no plan below it is
cheaper. Cells are (row, column)."""

SOLUTION = COLORS[DROPOFF]

MakeFigure = Callable[[tuple[float, float]], SceneFigure]


def tree_picture(tree: ConflictTree, make: MakeFigure = make_figure) -> SceneFigure:
    """Return a picture of a conflict tree that has grown, beside its problem.

    A node shows the constraints that its parent does not have, the cost of its ways, and the
    conflict that its children decide; one without children shows if it is the optimal plan. The
    figure is made by ``make``, from its width and height in inches.

    Raises:
        ValueError: the tree has no node, or more than ``MAX_NODES``.

    Example:
        >>> from agents.mapf.cbs import ConflictTree
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.problem import Problem
        >>> from agents.mapf.tree_picture import tree_picture
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> tree = ConflictTree(problem)
        >>> plan = tree.solve(seconds=10)
        >>> tree_picture(tree).savefig("tree.svg")
    """
    if not 0 < len(tree.nodes) <= MAX_NODES:
        raise ValueError(
            f"the conflict tree has {len(tree.nodes)} nodes; a picture has 1..{MAX_NODES}"
        )
    places = places_of(tree.nodes)
    layout = tree.problem.graph.layout
    cell = min(FLOOR_CELL, MAX_FLOOR / max(layout.width, layout.height))
    floor = (cell * layout.width, cell * layout.height)
    across, down = CARD[0] + GAP[0], CARD[1] + GAP[1]
    wide = (max(x for x, _ in places.values()) + 1) * across - GAP[0]
    high = (max(y for _, y in places.values()) + 1) * down - GAP[1]
    left = MARGIN + 0.2 + max(floor[0], MIN_FLOOR) + 2 * MARGIN
    size = left + wide + MARGIN, TITLE + max(high, floor[1] + 2.2) + MARGIN
    figure = make(size)
    figure.set_facecolor(PAPER)
    cost = f"cost {tree.solution.cost}" if tree.solution else "no plan yet"
    robots, nodes = counted(tree.problem.robots, "robot"), counted(len(tree.nodes), "node")
    figure.text(
        MARGIN / size[0], 1 - TITLE / 2 / size[1],
        f"Conflict-based search, {robots}: {cost} after {nodes}", fontsize=TITLE_SIZE,
        fontweight="bold", color=INK, va="center",
    )  # fmt: skip
    _draw_floor(figure.add_axes(box_in(size, MARGIN + 0.2, TITLE + 0.2, *floor)), tree, 72 * cell)
    figure.text(
        MARGIN / size[0], 1 - (TITLE + floor[1] + 0.45) / size[1], HOW_TO_READ, fontsize=SMALL,
        color=INK, va="top",
    )  # fmt: skip
    axes = figure.add_axes(box_in(size, left, TITLE, wide, high))
    axes.set(xlim=(0, wide), ylim=(high, 0))
    axes.axis("off")
    corners = {node: (x * across, y * down) for node, (x, y) in places.items()}
    for node, corner in corners.items():
        if node.parent is not None:
            x, y = corners[node.parent]
            ends = (x + CARD[0] / 2, corner[0] + CARD[0] / 2), (y + CARD[1], corner[1])
            axes.plot(*ends, color=INK, linewidth=1.6, zorder=0)
    for node, corner in corners.items():
        _draw_card(axes, tree, node, corner)
    return figure


def places_of(nodes: list[ConflictNode]) -> dict[ConflictNode, tuple[float, int]]:
    """Return the column and the level of each node: leaves side by side, parents above them."""
    children: dict[ConflictNode | None, list[ConflictNode]] = {}
    for node in nodes:
        children.setdefault(node.parent, []).append(node)
    placed: dict[ConflictNode, tuple[float, int]] = {}
    leaves = iter(range(len(nodes)))

    def place(node: ConflictNode, level: int) -> float:
        below = [place(child, level + 1) for child in children.get(node, [])]
        column = sum(below) / len(below) if below else float(next(leaves))
        placed[node] = column, level
        return column

    place(nodes[0], 0)
    return {node: placed[node] for node in nodes}


def words_of(tree: ConflictTree, what: Sequence[Constraint] | Conflict) -> str:
    """Return constraints or a conflict in words; robots and steps are numbers, cells places."""

    def place(cell: int | None) -> Cell:
        return tree.problem.graph.layout.cell(cell or 0)

    if isinstance(what, Conflict):
        (one, other), time, cell, before = what
        if cell is None:
            return f"{one} and {other}: shortest ways meet"
        if before is None:
            return f"{one} and {other} in {place(cell)} at {time}"
        return f"{one}, {other} swap {place(before)}, {place(cell)} at {time}"
    words = []
    for robot, time, cell, before, holds in what:
        if cell is None:
            arrives = " arrives" if len(what) == 1 else ""  # two of them must fit the strip
            words.append(f"{robot}{arrives} {'by' if holds else 'after'} step {time}")
        else:
            move = f"in {place(cell)}" if before is None else f"{place(before)}→{place(cell)}"
            words.append(f"{robot} {'' if holds else 'not '}{move} at {time}")
    return ", ".join(words)


def _draw_card(
    axes: Axes, tree: ConflictTree, node: ConflictNode, corner: tuple[float, float]
) -> None:
    (x, y), (wide, high), is_solution = corner, CARD, node is tree.solution
    ground = PAPER if node.split or is_solution else FAINT
    axes.add_patch(Rectangle(corner, wide, high, color=ground))
    common: dict[str, Any] = {"ha": "center", "va": "center", "parse_math": False}
    middle = x + wide / 2
    if node.constraints:
        axes.add_patch(Rectangle(corner, wide, HEAD, color=INK))
        words = words_of(tree, node.constraints)
        axes.text(middle, y + HEAD / 2, words, fontsize=SMALL, color=PAPER, **common)
    color, width = (SOLUTION, 7.0) if is_solution else (INK, 1.4)
    axes.add_patch(
        Rectangle(corner, wide, high, fill=False, edgecolor=color, linewidth=width, clip_on=False)
    )
    cost = f"cost {node.cost}"
    axes.text(middle, y + HEAD + 0.3, cost, fontsize=LARGE, fontweight="bold", color=INK, **common)
    last = (
        "★ optimal plan" if is_solution
        else words_of(tree, node.split) if node.split else "not opened"
    )  # fmt: skip
    weight = "bold" if is_solution else "normal"
    axes.text(middle, y + high - 0.25, last, fontsize=SMALL, fontweight=weight, color=INK, **common)


def _draw_floor(axes: Axes, tree: ConflictTree, cell_points: float) -> None:
    """Draw starts as discs, goals as rings, and the ways of the solution."""
    layout = tree.problem.graph.layout
    draw_grid(axes, (layout.height, layout.width), 1, 0.6, label_size=11)
    axes.xaxis.tick_top()
    for row, line in enumerate(layout.rows):
        for col, tile in enumerate(line):
            if tile == WALL:
                axes.add_patch(Rectangle((col, row), 1, 1, color=SHELF))
    for robot, ends in enumerate(zip(tree.problem.starts, tree.problem.goals, strict=True)):
        for cell, shape, share, at in zip(ends, "os", (0.56, 0.36), (0.64, 0.22), strict=True):
            row, col = layout.cell(cell)
            (x, y), size = (col + at, row + at), share * cell_points
            color, ink = (COLORS[ROBOT_EMPTY], PAPER) if shape == "o" else (COLORS[DROPOFF], INK)
            axes.plot(x, y, shape, markersize=size, color=color, markeredgecolor=INK, zorder=3)
            axes.text(
                x, y, str(robot), fontsize=0.62 * size, fontweight="bold", color=ink, ha="center",
                va="center_baseline", zorder=4,
            )  # fmt: skip
