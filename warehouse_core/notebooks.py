"""What notebooks show for the last value of a cell: players of records, pictures of the others.

The classes stand below what draws them, so their methods are added here. Players and Pillow are
imported when something is shown.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from typing import Any

from warehouse_core.fleet.env import FleetEnv
from warehouse_core.records.episode import Episode
from warehouse_core.viz.tracks.record_track import Record, track_of_record
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

MAX_BYTES = 3_000_000
"""Of a player in a notebook, which keeps it in its file."""


def record_player(record: Record) -> str:
    """Return the player of a record as HTML, or how to save it if it is large."""
    from warehouse_core.viz.player import player_frame

    frame = player_frame([track_of_record(record)])
    if len(frame) <= MAX_BYTES:
        return frame
    return (
        f"<p>This replay has {len(frame) / 1e6:.1f} MB, more than a notebook should keep. "
        "<code>replay_animation(episode).save('replay.html')</code> writes it as a page.</p>"
    )


def layout_picture(layout: Layout) -> bytes:
    """Return a picture of a layout as PNG."""
    return _picture(layout)


def env_picture(env: WarehouseEnv) -> bytes:
    """Return a picture of a warehouse as it is now, as PNG."""
    return _picture(env.layout, [(env.state.robot_pos, env.state.has_item)])


def fleet_picture(env: FleetEnv) -> bytes:
    """Return a picture of a fleet as it is now, as PNG; before its reset, of the layout."""
    if not env._started:
        return _picture(env.layout)
    return _picture(env.layout, zip(env.cells, env.loaded, strict=True), env.people)


def _picture(
    layout: Layout, robots: Iterable[tuple[Cell, bool]] = (), people: Iterable[Cell] = ()
) -> bytes:
    from PIL import Image

    from warehouse_core.render.painter import TilePainter, tile_pixels_for

    painter = TilePainter(tile_pixels_for(layout.height, layout.width))
    file = io.BytesIO()
    Image.fromarray(painter.fleet_picture(layout, robots, people)).save(file, "PNG")
    return file.getvalue()


SHOWN: dict[tuple[type, str], Callable[[Any], str | bytes]] = {
    (Episode, "_repr_html_"): record_player,
    (Layout, "_repr_png_"): layout_picture,
    (WarehouseEnv, "_repr_png_"): env_picture,
    (FleetEnv, "_repr_png_"): fleet_picture,
}
"""The methods that notebooks call, by class and name."""

for (_kind, _name), _show in SHOWN.items():
    setattr(_kind, _name, _show)
