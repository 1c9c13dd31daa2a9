"""The formats of replays, and what writing them needs."""

from warehouse_core.viz.export.formats import FORMATS, ffmpeg, progress_bar

__all__ = ["FORMATS", "ffmpeg", "progress_bar"]
