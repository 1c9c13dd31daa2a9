"""Output of notebook cells: a player for a record, and a picture for an environment or a layout.

The player and Pillow are imported only when something is shown.
"""

from __future__ import annotations

import io
from collections.abc import Iterable

from warehouse_core.fleet.env import FleetEnv
from warehouse_core.records.episode import Episode
from warehouse_core.render.atlas import Pixels
from warehouse_core.render.painter import TilePainter, tile_pixels_for
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.world.display import display
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

MAX_BYTES = 3_000_000
"""Size of the largest player that a notebook shows. A notebook file contains what it shows."""


@display.register
def record_player(record: Episode) -> str:
    """Return the player of a record as HTML, or instructions for saving it if it is large."""
    from warehouse_core.viz.player import player_frame

    frame = player_frame([track_of_record(record)])
    if len(frame) <= MAX_BYTES:
        return frame
    return (
        f"<p>This replay has {len(frame) / 1e6:.1f} MB, which is too much for a notebook. To save "
        "it as a page, call <code>replay_animation(episode).save('replay.html')</code>.</p>"
    )


@display.register
def env_picture(env: WarehouseEnv) -> bytes:
    """Return a PNG picture of the present state of a warehouse."""
    return layout_picture(env.layout, [(env.state.robot_pos, env.state.has_item)])


@display.register
def fleet_picture(env: FleetEnv) -> bytes:
    """Return a PNG picture of the present state of a fleet.

    Before the first reset, it shows only the robots whose start cells are known.
    """
    layout, starts = env.layout, env.settings.starts
    if env._started:
        return layout_picture(layout, zip(env.cells, env.loaded, strict=True), env.people)
    if starts is None:
        starts = (layout.default_start(),) if env.settings.robots == 1 else ()
    return layout_picture(layout, [(cell, False) for cell in starts])


@display.register
def layout_picture(
    layout: Layout, robots: Iterable[tuple[Cell, bool]] = (), people: Iterable[Cell] = ()
) -> bytes:
    """Return a PNG picture of a layout with robots and people."""
    painter = TilePainter(tile_pixels_for(layout.height, layout.width))
    return png_of(painter.fleet_picture(layout, robots, people))


def png_of(picture: Pixels) -> bytes:
    """Return a picture as the bytes of a PNG file."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(picture).save(file, "PNG")
    return file.getvalue()
