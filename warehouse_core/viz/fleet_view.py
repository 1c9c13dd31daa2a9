"""A fleet in a picture: numbered robots with their items and batteries, people, and orders."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import (
    EllipseCollection,
    PathCollection,
    PolyCollection,
)
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D, AffineDeltaTransform

from warehouse_core.render.palette import (
    BATTERY,
    COLORS,
    INK,
    ORDER_COLORS,
    PAPER,
    STRANDED,
    WARNING,
    Color,
)
from warehouse_core.viz.axes.plans import PlanView
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.robot_view import ABOVE_TILES, SQUARE, nose_of
from warehouse_core.viz.tracks.track import FleetFrame, Frame, Pose, Waiting
from warehouse_core.world.tiles import PERSON, ROBOT_EMPTY, ROBOT_LOADED

RADIUS, MAX_RADIUS, GOOD_POINTS, MIN_POINTS = 0.36, 0.45, 9.0, 2.5
"""Of a robot, in cells; larger up to ``MAX_RADIUS`` if it had fewer than ``GOOD_POINTS``."""

MIN_NUMBER_POINTS, MIN_BOX_POINTS, DIGIT = 5.0, 7.0, 0.7
"""Minimum sizes of the numbers of robots and of orders; width of a digit as a share of its size."""

BOX: dict[str, Any] = {"boxstyle": "square,pad=0.12", "linewidth": 0.8}
"""Around the number of orders at a pickup."""

FEW = 12
"""Up to so many robots always show their batteries; more do only when they are low."""

LOW_BATTERY = 0.25

LATE = len(ORDER_COLORS) - 1

TIP = 1.38
"""Of the nose of a robot, which stays in its cell; see ``robot_view``."""

_DIAMOND = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)])


class FleetView:
    """Draws the robots of a fleet, its people and orders into axes whose unit is a cell.

    Args:
        figure: to add the movers to.
        axes: to draw into.
        cell_points: side of a cell in points, 1/72 inch.
        robots: their number; the other poses of a frame are those of people.
    """

    def __init__(self, figure: SceneFigure, axes: Axes, cell_points: float, robots: int) -> None:
        self._figure, self._axes, self._robots = figure, axes, robots
        self._cell_points = cell_points
        self._radius = max(
            RADIUS, min(MAX_RADIUS, GOOD_POINTS / cell_points), MIN_POINTS / cell_points
        )
        thin = min(1.2, max(0.3, cell_points / 24))
        edge: dict[str, Any] = {"edgecolors": [INK], "linewidths": thin, "zorder": ABOVE_TILES}
        side = 2 * self._radius
        self._people = PolyCollection([], facecolors=[COLORS[PERSON]], **edge)
        self._noses = PolyCollection([], facecolors=[INK], linewidths=0, zorder=ABOVE_TILES)
        self._discs = EllipseCollection(
            [side], [side], [0], units="xy", offsets=[], offset_transform=axes.transData, **edge
        )
        self._grounds = PolyCollection([], facecolors=[PAPER], **edge)
        self._levels = PolyCollection([], linewidths=0, zorder=ABOVE_TILES)
        self._items = PolyCollection([], **edge)
        self._plans = PlanView(axes, cell_points, ABOVE_TILES)
        for mover in (self._plans.ways, self._plans.wishes):
            figure.add_mover(mover)
        for collection in (self._people, self._noses, self._discs):
            self._add(collection)
        size = min(0.5, 1.5 * self._radius / (DIGIT * len(str(robots - 1))))
        paths = _paths_of_numbers(robots, size) if size * cell_points >= MIN_NUMBER_POINTS else []
        # One collection is drawn faster than as many texts.
        by: Any = axes.transData  # affine, which its type does not say
        self._numbers = PathCollection(
            paths, offsets=[], offset_transform=by, transform=AffineDeltaTransform(by),
            linewidths=0, zorder=ABOVE_TILES,
        )  # fmt: skip
        self._add(self._numbers)
        for collection in (self._grounds, self._levels, self._items):
            self._add(collection)
        figure.add_mover(self._plans.pushes)
        self._waiting: list[Text] = []

    def show(self, frame: Frame) -> None:
        """Draw the fleet of a frame."""
        fleet = frame.fleet
        assert fleet is not None, "only frames of fleets are shown"
        poses = [pose for pose in frame.robots if pose is not None]
        robots, people = poses[: self._robots], poses[self._robots :]
        places = np.array([pose.at for pose in robots])
        self._people.set_verts(
            [np.array(person.at) + 0.95 * self._radius * _DIAMOND for person in people]
        )
        colors = [_color_of(pose, share) for pose, share in zip(robots, fleet.battery, strict=True)]
        self._discs.set_offsets(places)
        self._discs.set_facecolor(colors)
        self._plans.show(fleet.plans, places, colors)
        noses = [nose_of(pose, self._radius, TIP) for pose in robots if pose.heading is not None]
        self._noses.set_verts(noses)
        self._numbers.set_offsets(places)
        self._numbers.set_facecolor(
            [INK if color == COLORS[ROBOT_LOADED] else PAPER for color in colors]
        )
        self._show_batteries(places, fleet)
        items = [
            (place, age) for place, age in zip(places, fleet.items, strict=True) if age is not None
        ]
        corner = 0.78 * self._radius
        self._items.set_verts(
            [place + (corner, -corner) + 0.4 * self._radius * SQUARE for place, _ in items]
        )
        self._items.set_facecolor([ORDER_COLORS[age] for _, age in items])
        self._items.set_edgecolor([_ink_on(age) for _, age in items])
        self._show_waiting(fleet.waiting)

    def _show_batteries(self, places: Any, fleet: FleetFrame) -> None:
        """Draw a bar below each robot, of many only below those whose battery is low."""
        shown = [
            ((x - self._radius, y + 0.75 * self._radius), share)
            for (x, y), share in zip(places.tolist(), fleet.battery, strict=True)
            if self._robots <= FEW or share < LOW_BATTERY
        ]
        length, height = 2 * self._radius, 0.32 * self._radius
        self._grounds.set_verts([_box(corner, length, height) for corner, _ in shown])
        self._levels.set_verts([_box(corner, share * length, height) for corner, share in shown])
        self._levels.set_facecolor(
            [WARNING if share < LOW_BATTERY else BATTERY for _, share in shown]
        )

    def _show_waiting(self, waiting: tuple[Waiting, ...]) -> None:
        """Write the number of orders at each pickup into a box of the colour of their age."""
        while len(self._waiting) < len(waiting):
            self._waiting.append(self._box_for_a_number())
        for text in self._waiting[len(waiting) :]:
            text.set_visible(False)
        for text, orders in zip(self._waiting, waiting, strict=False):
            x, y = orders.at
            text.set(
                visible=True,
                position=(x + 0.4, y + 0.5),
                text=f"{orders.number}{'!' * (orders.age == LATE)}",
                color=_ink_on(orders.age),
            )
            box = {"facecolor": ORDER_COLORS[orders.age], "edgecolor": text.get_color()}
            text.set_bbox(BOX | box)

    def _box_for_a_number(self) -> Text:
        size = max(MIN_BOX_POINTS, 0.36 * self._cell_points)
        text = self._axes.text(
            0, 0, "", fontsize=size, fontweight="bold", ha="center", va="center_baseline",
            zorder=ABOVE_TILES + 1,
        )  # fmt: skip
        self._figure.add_mover(text)
        return text

    def _add(self, collection: Any) -> None:
        self._axes.add_collection(collection, autolim=False)
        self._figure.add_mover(collection)


def _paths_of_numbers(robots: int, size: float) -> list[Path]:
    """Return the outlines of the numbers from 0, of a size in cells, around 0, 0."""
    bold = FontProperties(weight="bold")
    paths = []
    for robot in range(robots):
        path = TextPath((0, 0), str(robot), size=1, prop=bold)
        (left, bottom), (right, top) = path.get_extents().get_points()
        to_middle = Affine2D().translate(-(left + right) / 2, -(bottom + top) / 2)
        paths.append(path.transformed(to_middle.scale(size, -size)))
    return paths


def _color_of(pose: Pose, share: float) -> Color:
    if share <= 0:
        return STRANDED
    return COLORS[ROBOT_LOADED if pose.loaded else ROBOT_EMPTY]


def _ink_on(age: int) -> Color:
    """Return the colour of what is written on an order, and of the line around it."""
    return PAPER if age == LATE else INK


def _box(corner: tuple[float, float], length: float, height: float) -> Any:
    return np.array(corner) + np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * (length, height)
