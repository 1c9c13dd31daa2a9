"""The formats of replays, and what writing them needs."""

from warehouse_core.viz.export.formats import (
    FORMATS,
    ffmpeg,
    page,
    progress_bar,
    self_contained,
)

__all__ = ["FORMATS", "ffmpeg", "page", "progress_bar", "self_contained"]
