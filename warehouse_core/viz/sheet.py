"""How a picture is laid out: one track with its charts beside it, or several side by side.

All lengths are in inches, from the top left corner of the figure; sizes of words are in points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from warehouse_core.viz.charts import BatteryBar, Chart, DistanceChart, MotionChart, kinds_of_charts
from warehouse_core.viz.figure import DPI
from warehouse_core.viz.tracks.track import Track
from warehouse_core.viz.words import (
    Words,
    caption_in_lines,
    counter_of,
    ending_of,
    fitted_caption,
    tally_of,
    title_of,
)

MAX_CELL, SHARP = 1.05, 8
"""Largest side of a cell; pixels of the smallest cells that have a whole number of them."""

BAR = 0.2
"""Height of a battery."""

GRID, FLEET_GRID = (6.4, 4.6), (9.0, 4.2)
"""Most width and height of the map of a single track; with its charts a fleet's is as wide as
``WIDTH``, and its window as high as a screen of 768 pixels allows."""

EDGE, HEAD, BAR_GAP, MIN_LEFT = 0.3, 1.0, 0.12, 4.8
"""Room around a single track, above its map and above its battery; least width of its words."""

CHARTS_LEFT, CHARTS_WIDTH, CHARTS_GAP, CHARTS_FOOT, LEGEND_WIDTH = 0.75, 3.3, 0.55, 0.5, 1.95
"""Room left of charts beside a map, their width, room between and below them; then the legend."""

MIN_CHARTS, MIN_TALL_CHARTS = 3.2, 4.2
"""Least heights of all charts beside a map; the second if one is of a motion or of orders."""

MOTION_PARTS = 100
"""Parts in which a single track's chart of a motion grows; or each step, if there are more."""

WIDTH, MARGIN, COLUMN_HEAD, GUTTER = 13.66, 0.4, 1.45, 0.5
"""Width of a figure of several tracks, room at its sides, above its maps and between columns."""

LEAD_WIDTH = 8.0
"""Width of the left column if it leads."""

MAX_MAP, MAX_LEAD_MAP, MAX_SMALL_MAP = 3.3, 4.8, 2.3
"""Most heights of maps of one scale, of the map that leads, and of the map beside it."""

GAP, VERDICT, FOOT, FLEET_FOOT = 0.1, 0.45, 0.6, 0.8
"""Room between a map and its battery; heights of the verdict below, and of legends."""

BELOW = GAP + BAR + VERDICT

CHART, CHART_HEAD, CHART_FOOT, CHART_LEFT, CHART_RIGHT = 1.05, 0.3, 0.38, 0.4, 0.5
"""Height of a chart in a column, and the room around it."""

MAX_COLUMNS, ROW, CLOCK = 4, 3, 0.4
"""Most tracks in one row; tracks in a row if there are more of them; room for the clock on top."""

LEGEND_COLUMNS = 7

BOLD = {"fontweight": "bold"}

Box = tuple[float, float, float, float]
"""Left, top, width and height."""

SheetLine = tuple[float, float, Callable[[Track, int], Words], Mapping[str, Any]]
"""Left and top of words, what says them in a frame of a track, and their style."""


class Slot(NamedTuple):
    """Place of a chart or of a battery, which may have a label of its axis of time."""

    kind: type[Chart | BatteryBar]
    box: Box
    has_label: bool = False


class TrackPlace(NamedTuple):
    """Place of a track: the side of a cell, the box of the map, and everything around the map."""

    cell: float
    map: Box
    slots: list[Slot]
    lines: list[SheetLine]


class Sheet(NamedTuple):
    """Layout of a picture, with a place for each track.

    Attributes:
        size: width and height of the figure.
        legend_columns: columns of the legend along the bottom; 0 is a legend along the right side.
        motion_parts: parts in which charts of motions grow; ``None`` is one for each frame.
    """

    size: tuple[float, float]
    places: list[TrackPlace]
    legend_columns: int
    motion_parts: int | None


def sheet_of(tracks: Sequence[Track], steps: int, *, legend: bool) -> Sheet:
    """Return the layout of a picture; a single track will have ``steps`` steps, perhaps a legend.

    If only the left one of two tracks has anything to chart, it leads: its map is larger, and its
    charts are on the right. More than ``MAX_COLUMNS`` tracks are in rows, without charts.
    """
    if len(tracks) == 1:
        return _single(tracks[0], steps, legend=legend)
    first, *others = tracks
    leads = len(others) == 1 and first.metrics and not others[0].metrics
    if len(tracks) > MAX_COLUMNS:
        places, bottom = _rows(tracks)
    else:
        kinds = _kinds_in_columns(tracks)
        in_columns = partial(_columns, tracks, len(tracks), kinds, MAX_MAP)
        places, bottom = _leading(first, others[0]) if leads else in_columns()
    ends = [top + height for place in places for _, (_, top, _, height), _ in place.slots]
    bottom = max([bottom, *(end + CHART_FOOT for end in ends)])
    foot = FLEET_FOOT if any(track.is_fleet for track in tracks) else FOOT
    return Sheet((WIDTH, bottom + foot), places, LEGEND_COLUMNS, None)


def _single(track: Track, steps: int, *, legend: bool) -> Sheet:
    """Return a map with its battery below, and its charts and its legend beside it."""
    kinds = kinds_of_charts([track])
    cell = _cell(track, *(FLEET_GRID if track.is_fleet else GRID))
    map_width, map_height = (cell * cells for cells in track.shown_size)
    has_tall_charts = track.is_continuous or track.counts_orders
    least = MIN_TALL_CHARTS if has_tall_charts else MIN_CHARTS if kinds else 0.0
    left_width, height = max(map_width, MIN_LEFT), max(map_height, least)
    map_box = (
        EDGE + (left_width - map_width) / 2, HEAD + (height - map_height) / 2, map_width, map_height
    )  # fmt: skip
    chart = (height - CHARTS_GAP * (len(kinds) - 1)) / max(len(kinds), 1)
    charts_left = EDGE + left_width + CHARTS_LEFT
    slots = [
        Slot(
            kind,
            (charts_left, HEAD + number * (chart + CHARTS_GAP), CHARTS_WIDTH, chart),
            has_label=kind is kinds[-1],
        )
        for number, kind in enumerate(kinds)
    ]
    has_battery = "battery" in track.metrics
    if has_battery:
        slots.append(Slot(BatteryBar, (EDGE, HEAD + height + BAR_GAP, left_width, BAR)))
    # Without a battery there are only the words below charts.
    foot = EDGE if has_battery or not legend else CHARTS_FOOT
    # The legend of a fleet with charts is below, where there is room.
    is_below = legend and track.is_fleet and bool(kinds)
    beside = EDGE + left_width + (CHARTS_LEFT + CHARTS_WIDTH if kinds else 0.0)
    width = beside + EDGE + (LEGEND_WIDTH if legend and not is_below else 0.0)
    lines: list[SheetLine] = [
        (EDGE, 0.2, partial(title_of, 9), {}),
        (width - EDGE, 0.2, partial(counter_of, steps), {"ha": "right"}),
        (EDGE, 0.56, partial(fitted_caption, width - 2 * EDGE), BOLD),
        (width / 2, 0.2, ending_of, BOLD | {"ha": "center"}),
    ]
    foot += FLEET_FOOT if is_below else 0.0
    size = (width, HEAD + height + (BAR + BAR_GAP if has_battery else 0.0) + foot)
    columns = LEGEND_COLUMNS if is_below else 0
    return Sheet(size, [TrackPlace(cell, map_box, slots, lines)], columns, MOTION_PARTS)


def _rows(tracks: Sequence[Track]) -> tuple[list[TrackPlace], float]:
    """Return rows of columns without charts, and where the last row ends."""
    places: list[TrackPlace] = []
    bottom = CLOCK
    for first in range(0, len(tracks), ROW):
        row, end = _columns(tracks[first : first + ROW], ROW, [], MAX_SMALL_MAP)
        places += [_lowered(place, bottom - CLOCK) for place in row]
        bottom += end - CLOCK
    return places, bottom


def _lowered(place: TrackPlace, by: float) -> TrackPlace:
    """Return the place of a track further down."""

    def lower(box: Box) -> Box:
        return box[0], box[1] + by, *box[2:]

    slots = [slot._replace(box=lower(slot.box)) for slot in place.slots]
    lines = [(left, top + by, say, style) for left, top, say, style in place.lines]
    return TrackPlace(place.cell, lower(place.map), slots, lines)


def _columns(
    tracks: Sequence[Track], count: int, kinds: Sequence[type[Chart]], most: float
) -> tuple[list[TrackPlace], float]:
    """Return columns of one width with maps of one scale and charts below, and where maps end.

    The columns are so wide that ``count`` of them fill a row; maps have at most a height ``most``.
    """
    width = (WIDTH - (count - 1) * GUTTER) / count - 2 * MARGIN / count
    cell = min(_cell(track, width, most) for track in tracks)
    below = COLUMN_HEAD + cell * max(track.shown_size[1] for track in tracks)
    places = []
    for number, track in enumerate(tracks):
        left = MARGIN + number * (width + GUTTER)
        charts = [
            _chart(kind, left + index % 2 * width / 2, below + BELOW, index // 2, width / 2)
            for index, kind in enumerate(kinds)
            if kind.can_draw(track)
        ]
        places.append(_column(track, cell, left, width, charts, below))
    return places, below + BELOW


def _leading(first: Track, other: Track) -> tuple[list[TrackPlace], float]:
    """Return a wide column and a narrow one that has the charts, and where the wide one ends."""
    edge = MARGIN + LEAD_WIDTH + GUTTER
    width = WIDTH - MARGIN - edge
    cell, small = _cell(first, LEAD_WIDTH, MAX_LEAD_MAP), _cell(other, width, MAX_SMALL_MAP)
    below = COLUMN_HEAD + cell * first.shown_size[1]
    right_below = COLUMN_HEAD + small * other.shown_size[1]
    charts = [
        _chart(kind, edge, right_below, row, width)
        for row, kind in enumerate(_kinds_in_columns([first]))
    ]
    places = [
        _column(first, cell, MARGIN, LEAD_WIDTH, charts, below),
        _column(other, small, edge, width, [], None),
    ]
    return places, max(below + BELOW, right_below)


def _column(
    track: Track, cell: float, left: float, width: float, charts: list[Slot], below: float | None
) -> TrackPlace:
    """Return the place of a track in a column; battery and verdict are ``below`` its map."""
    columns, rows = track.shown_size
    map_box = (left, COLUMN_HEAD, cell * columns, cell * rows)
    lines: list[SheetLine] = [
        (left, 0.62, partial(title_of, 11), {}),
        (left, 0.77, partial(caption_in_lines, width), BOLD | {"va": "top"}),
    ]
    if below is not None:
        lines.append((left, below + BELOW - VERDICT / 2, partial(tally_of, width), BOLD))
        if "battery" in track.metrics:
            bar = Slot(BatteryBar, (left, below + GAP, map_box[2], BAR))
            charts = [bar, *charts]
    return TrackPlace(cell, map_box, charts, lines)


def _kinds_in_columns(tracks: Sequence[Track]) -> list[type[Chart]]:
    """Return the kinds of charts; where there is room for few, motions replace distances."""
    kinds = kinds_of_charts(tracks)
    return [kind for kind in kinds if kind is not DistanceChart or MotionChart not in kinds]


def _chart(kind: type[Chart], left: float, top: float, row: int, width: float) -> Slot:
    """Return the place of a chart in a row of charts."""
    top += CHART_HEAD + row * (CHART_HEAD + CHART + CHART_FOOT)
    box = (left + CHART_LEFT, top, width - CHART_LEFT - CHART_RIGHT, CHART)
    return Slot(kind, box, has_label=True)


def _cell(track: Track, width: float, height: float) -> float:
    """Return the side of a cell with which a map fits into a width and a height.

    It is a whole number of pixels where cells are not tiny, which keeps tiles sharp.
    """
    columns, rows = track.shown_size
    cell = min(width / columns, height / rows, MAX_CELL)
    return math.floor(cell * DPI) / DPI if cell * DPI > SHARP else cell
