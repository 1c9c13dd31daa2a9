"""The floor of an animated drawing: tiles, what is not seen yet, and the marks of a search.

All lengths are in hundredths of a cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, product

from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import hex_color
from warehouse_core.viz.svg.change import Beat, Span, extend, shown, spans_of
from warehouse_core.viz.tracks.track import Frame, TileRows, Track
from warehouse_core.world.tiles import CHARGER, DROPOFF, PICKUP, WALL, Cell, runs_of

UNIT = 100
"""Parts of a cell."""

MAX_LINED_COLUMNS = 40
"""Columns of the widest floor that has lines between its cells."""

STATIONS = {PICKUP: "pickup", DROPOFF: "dropoff", CHARGER: "charger"}

MIN_LETTER = 16
"""Least pixels of a cell that shows letters and the boards of shelves."""


def box(left: float, top: float, wide: float, high: float, look: str) -> str:
    """Return a rectangle, in hundredths of a cell, in a colour of the palette."""
    place = f'x="{left:g}" y="{top:g}" width="{wide:g}" height="{high:g}"'
    return f'<rect {place} class="{look}"/>'


def floor_of(track: Track, frames: Sequence[Frame], beat: Beat, pixels: float) -> Iterator[str]:
    """Yield the floor in some frames of a track, whose cells have so many pixels a side."""
    rows, height, width = frames[0].tiles, len(frames[0].tiles), len(frames[0].tiles[0])
    yield box(0, 0, UNIT * width, UNIT * height, "floor")
    if width <= MAX_LINED_COLUMNS:
        lines = [f"M{UNIT * x} 0V{UNIT * height}" for x in range(1, width)]
        lines += [f"M0 {UNIT * y}H{UNIT * width}" for y in range(1, height)]
        yield f'<path d="{"".join(lines)}" class="of-line" stroke-width="2"/>'
    for row, col in track.slippery:
        if rows[row][col] != WALL:
            yield box(UNIT * col + 2, UNIT * row + 2, UNIT - 4, UNIT - 4, "ice")
            waves = "".join(
                f"M{UNIT * col + 12} {UNIT * row + y}q19-14 38 0t38 0" for y in (25, 50, 75)
            )
            yield f'<path d="{waves}" class="of-wave" stroke-width="5"/>'
    all_tiles = [frame.tiles for frame in frames]
    for tiles, spans in spans_of(_known(all_tiles)).items():
        yield shown("".join(_tiles(tiles, pixels)), spans, beat)
    for hidden, cells in _unseen(all_tiles).items():
        yield shown(_covered(cells, 0, 'class="unseen"'), hidden, beat)
    yield from _marks(track, frames, beat)
    if track.outer:
        edge, right, bottom = UNIT * track.outer, UNIT * width, UNIT * height
        yield box(0, 0, right, edge, "paper") + box(0, bottom - edge, right, edge, "paper")
        yield box(0, 0, edge, bottom, "paper") + box(right - edge, 0, edge, bottom, "paper")


def _tiles(rows: TileRows, pixels: float) -> Iterator[str]:
    """Yield walls, shelves and stations."""
    width = len(rows[0])
    for row, line in enumerate(rows):
        for left, right in runs_of(WALL, line):
            yield box(UNIT * left, UNIT * row, UNIT * (right - left), UNIT, "wall")
    boards: list[str] = []
    for row, line in enumerate(rows[1:-1], start=1):
        for left, right in runs_of(WALL, line):
            left, right = max(left, 1), min(right, width - 1)
            if left < right:
                yield box(UNIT * left, UNIT * row, UNIT * (right - left), UNIT, "shelf")
                places = product(range(left, right), (34, 66))
                boards += [f"M{UNIT * col + 12} {UNIT * row + y}h76" for col, y in places]
    if boards and pixels >= MIN_LETTER:
        yield f'<path d="{"".join(boards)}" class="of-board" stroke-width="8"/>'
    for row, line in enumerate(rows):
        for col, tile in enumerate(line):
            if tile in STATIONS:
                yield box(UNIT * col + 6, UNIT * row + 6, UNIT - 12, UNIT - 12, STATIONS[tile])
                if pixels >= MIN_LETTER:
                    place = f'x="{UNIT * col + 22}" y="{UNIT * row + 35}"'
                    yield f'<text {place} font-size="30" class="dark">{tile}</text>'


def _known(tiles: Sequence[TileRows]) -> list[TileRows]:
    """Return the tiles of frames, with later tiles in cells that are not seen yet."""
    known: list[TileRows] = []
    later = before = tiles[-1]
    for rows in reversed(tiles):
        if rows is not before:
            before = rows
            later = tuple(map(_filled, rows, later))
        known.append(later)
    return known[::-1]


def _filled(line: str, later: str) -> str:
    """Return a row of tiles, with tiles of a later row in cells that were not seen."""
    return "".join(map(lambda now, then: then if now == UNSEEN else now, line, later))


def _unseen(tiles: Sequence[TileRows]) -> dict[tuple[Span, ...], list[Cell]]:
    """Return the cells that are not seen in some frames, by the spans of these."""
    hidden: dict[Cell, list[Span]] = {}
    for rows, same in groupby(range(len(tiles)), key=tiles.__getitem__):
        first, *others = same
        for row, line in enumerate(rows):
            for col in (col for left, right in runs_of(UNSEEN, line) for col in range(left, right)):
                extend(hidden.setdefault((row, col), []), first, first + len(others) + 1)
    cells: dict[tuple[Span, ...], list[Cell]] = {}
    for cell, spans in hidden.items():
        cells.setdefault(tuple(spans), []).append(cell)
    return cells


def _covered(cells: Sequence[Cell], inset: int, look: str) -> str:
    """Return one shape of cells without their outermost parts."""
    side = UNIT - 2 * inset
    square = f"h{side}v{side}h-{side}z"
    boxes = (f"M{UNIT * col + inset} {UNIT * row + inset}{square}" for row, col in cells)
    return f'<path d="{"".join(boxes)}" {look}/>'


def _marks(track: Track, frames: Sequence[Frame], beat: Beat) -> Iterator[str]:
    """Yield the cells of a search in the colours that they have by and by, and its ends."""
    marks = track.marks
    if marks is None:
        return
    now: dict[Cell, tuple[int, int]] = {}
    boxes: dict[tuple[int, Span], list[Cell]] = {}
    following = 0

    def end(cell: Cell, frame: int) -> None:
        value, first = now.pop(cell)
        if first < frame:
            boxes.setdefault((value, (first, frame)), []).append(cell)

    for number, frame in enumerate(frames):
        while following < len(marks.times) and marks.times[following] <= frame.clock:
            cell = marks.cells[following]
            if cell in now:
                end(cell, number)
            now[cell] = marks.values[following], number
            following += 1
    for cell in [*now]:
        end(cell, beat.frames)
    for (value, span), cells in boxes.items():
        look = f'fill="{hex_color(marks.colors[value])}"'
        yield shown(_covered(cells, 3, look), [span], beat)


def ends_of(track: Track) -> Iterator[str]:
    """Yield start and goal of a search, as letters."""
    if track.marks is not None:
        for letter, (row, col) in zip("SG", track.marks.ends, strict=True):
            x, y = UNIT * col + UNIT // 2, UNIT * row + UNIT // 2
            yield f'<circle cx="{x}" cy="{y}" r="44" class="light of-rim"/>'
            yield f'<text x="{x}" y="{y + 20}" font-size="58" class="dark">{letter}</text>'
