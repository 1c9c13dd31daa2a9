"""What notebooks show for the last value of a cell: players of records, pictures of the others.

Players and Pillow are imported when something is shown.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from warehouse_core.fleet.env import FleetEnv
from warehouse_core.records.episode import Episode
from warehouse_core.render.atlas import CODES, NO_ROBOT, Pixels, color_bytes
from warehouse_core.render.painter import TilePainter, tile_pixels_for
from warehouse_core.render.palette import PAPER
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.world.display import display
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import EMPTY, PERSON, ROBOT_EMPTY, Cell

MAX_BYTES = 3_000_000
"""Size of the largest player that a notebook shows; its file keeps what it shows."""


@display.register
def record_player(record: Episode) -> str:
    """Return the player of a record as HTML, or how to save it if it is large."""
    from warehouse_core.viz.player import player_frame

    frame = player_frame([track_of_record(record)])
    if len(frame) <= MAX_BYTES:
        return frame
    return (
        f"<p>This replay has {len(frame) / 1e6:.1f} MB, more than a notebook should keep. "
        "<code>replay_animation(episode).save('replay.html')</code> writes it as a page.</p>"
    )


@display.register
def env_picture(env: WarehouseEnv) -> bytes:
    """Return a picture of a warehouse as it is now, as PNG."""
    return layout_picture(env.layout, [(env.state.robot_pos, env.state.has_item)])


@display.register
def fleet_picture(env: FleetEnv) -> bytes:
    """Return a picture of a fleet as it is now, as PNG.

    Before the first reset robots are where they will start, or below the floor if that is to be
    drawn, as people are.
    """
    if env._started:
        return layout_picture(env.layout, zip(env.cells, env.loaded, strict=True), env.people)
    settings, layout = env.settings, env.layout
    usual = (layout.usual_start(),) if settings.robots == 1 else ()
    starts = usual if settings.starts is None else settings.starts
    waiting = [ROBOT_EMPTY] * (settings.robots - len(starts)) + [PERSON] * settings.people.count
    painter = painter_of(layout)
    floor = painter.fleet_picture(layout, [(cell, False) for cell in starts])
    return png_of(np.concatenate([floor, *_waiting(painter, waiting, layout.width)]))


@display.register
def layout_picture(
    layout: Layout, robots: Iterable[tuple[Cell, bool]] = (), people: Iterable[Cell] = ()
) -> bytes:
    """Return a picture of a layout, with robots and people in it, as PNG."""
    return png_of(painter_of(layout).fleet_picture(layout, robots, people))


def _waiting(painter: TilePainter, signs: Sequence[str], width: int) -> Iterator[Pixels]:
    """Yield what is below a floor of a width in cells: robots and people without a place."""
    if not signs:
        return
    codes = np.full((-(-len(signs) // width), width), CODES[EMPTY, NO_ROBOT])
    codes.flat[: len(signs)] = [CODES[EMPTY, sign] for sign in signs]
    rows = painter.paint(codes)
    yield np.full((painter.tile_pixels // 2, *rows.shape[1:]), color_bytes(PAPER))
    yield rows


def painter_of(layout: Layout) -> TilePainter:
    """Return a painter of tiles whose size suits a layout."""
    return TilePainter(tile_pixels_for(layout.height, layout.width))


def png_of(picture: Pixels) -> bytes:
    """Return a picture as the bytes of a PNG file."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(picture).save(file, "PNG")
    return file.getvalue()
