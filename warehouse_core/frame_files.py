"""The frames of a track as numbered SVG files, with the legend in a file of its own."""

from __future__ import annotations

import math
from pathlib import Path

from warehouse_core.atomic_file import atomic_path
from warehouse_core.display import make_figure
from warehouse_core.export import progress_bar, save_svg
from warehouse_core.scene import Scene, draw_legend
from warehouse_core.track import Track

LEGEND_INCHES = (6.0, 0.6)


def save_frames(track: Track, folder: Path, dpi: float) -> None:
    """Write ``frame_0000.svg`` and so on and ``legend.svg`` into ``folder``.

    Raises:
        ValueError: ``dpi`` is not a positive finite number.
        OSError: the folder cannot be made or written to.
    """
    if not (math.isfinite(dpi) and dpi > 0):
        raise ValueError(f"dpi is {dpi!r}; it must be positive and finite")
    folder.mkdir(parents=True, exist_ok=True)
    track.metrics, track.clock = {}, []
    scene = Scene(track, make_figure, legend=False)
    with progress_bar(len(track), "Drawing") as report:
        for frame in range(len(track)):
            scene.show(frame)
            with atomic_path(folder / f"frame_{frame:04d}.svg") as part:
                save_svg(scene.root, part, dpi)
            report(frame, None)
    legend = make_figure(LEGEND_INCHES)
    draw_legend(legend)
    with atomic_path(folder / "legend.svg") as part:
        save_svg(legend, part, dpi)
