"""A fleet in a picture: numbered robots with their items and batteries, people, and orders."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.text import Text

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
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.robot_view import ABOVE_TILES
from warehouse_core.viz.track import FleetFrame, Frame, Pose, Waiting
from warehouse_core.world.tiles import PERSON, ROBOT_EMPTY, ROBOT_LOADED

RADIUS, MIN_POINTS = 0.41, 2.5
"""Of a robot, in cells, and its minimum in points."""

MIN_NUMBER_POINTS, DIGIT = 5.0, 0.7
"""Minimum size of the numbers; the width of a digit as a share of the size."""

FEW = 12
"""Up to so many robots always show their batteries; more do only when they are low."""

LOW_BATTERY = 0.25

LATE = len(ORDER_COLORS) - 1

_SQUARE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2
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
        self._radius = max(RADIUS, MIN_POINTS / cell_points)
        thin = min(1.2, max(0.3, cell_points / 24))
        edge: dict[str, Any] = {"edgecolors": [INK], "linewidths": thin, "zorder": ABOVE_TILES}
        side = 2 * self._radius
        self._people = PolyCollection([], facecolors=[COLORS[PERSON]], **edge)
        self._noses = LineCollection(
            [], colors=[INK], linewidths=max(0.8, cell_points / 12), zorder=ABOVE_TILES
        )
        self._discs = EllipseCollection(
            [side], [side], [0], units="xy", offsets=[], offset_transform=axes.transData, **edge
        )
        self._grounds = PolyCollection([], facecolors=[PAPER], **edge)
        self._levels = PolyCollection([], linewidths=0, zorder=ABOVE_TILES)
        self._items = PolyCollection([], **edge)
        for collection in (self._people, self._noses, self._discs):
            self._add(collection)
        size = min(0.5, 1.26 * self._radius / (DIGIT * len(str(robots - 1)))) * cell_points
        self._numbers = [
            axes.text(
                0, 0, str(robot), fontsize=size, fontweight="bold", ha="center",
                va="center_baseline", zorder=ABOVE_TILES, clip_on=True,
            )
            for robot in range(robots if size >= MIN_NUMBER_POINTS else 0)
        ]  # fmt: skip
        for number in self._numbers:
            figure.add_mover(number)
        for collection in (self._grounds, self._levels, self._items):
            self._add(collection)
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
        self._noses.set_segments([self._nose(pose) for pose in robots if pose.heading is not None])
        for number, pose, color in zip(self._numbers, robots, colors, strict=False):
            number.set(position=pose.at, color=INK if color == COLORS[ROBOT_LOADED] else PAPER)
        self._show_batteries(places, fleet)
        items = [
            (place, age) for place, age in zip(places, fleet.items, strict=True) if age is not None
        ]
        corner = 0.8 * self._radius
        self._items.set_verts(
            [place + (corner, -corner) + 0.8 * self._radius * _SQUARE for place, _ in items]
        )
        self._items.set_facecolor([ORDER_COLORS[age] for _, age in items])
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
            is_late = orders.age == LATE
            text.set(
                visible=True,
                position=(x + 0.32, y + 0.36),
                text=f"{orders.count}{'!' * is_late}",
                color=PAPER if is_late else INK,
            )
            text.get_bbox_patch().set_facecolor(ORDER_COLORS[orders.age])  # type: ignore[union-attr]

    def _box_for_a_number(self) -> Text:
        size = max(MIN_NUMBER_POINTS + 1, 0.36 * self._cell_points)
        text = self._axes.text(
            0, 0, "", fontsize=size, fontweight="bold", ha="center", va="center_baseline",
            bbox={"boxstyle": "square,pad=0.12", "edgecolor": INK, "linewidth": 0.8},
            zorder=ABOVE_TILES + 1,
        )  # fmt: skip
        self._figure.add_mover(text)
        return text

    def _nose(self, pose: Pose) -> list[tuple[float, float]]:
        (x, y), heading = pose.at, pose.heading or 0.0
        ends = (self._radius, 1.22 * self._radius)
        return [(x + r * math.cos(heading), y + r * math.sin(heading)) for r in ends]

    def _add(self, collection: Any) -> None:
        self._axes.add_collection(collection, autolim=False)
        self._figure.add_mover(collection)


def _color_of(pose: Pose, share: float) -> Color:
    if share <= 0:
        return STRANDED
    return COLORS[ROBOT_LOADED if pose.loaded else ROBOT_EMPTY]


def _box(corner: tuple[float, float], length: float, height: float) -> Any:
    return np.array(corner) + np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * (length, height)
