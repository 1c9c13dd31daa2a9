"""The formats of replays, and what writing them needs."""

from warehouse_core.viz.export.formats import FORMATS, ffmpeg, has_live_terminal, progress_bar

__all__ = ["FORMATS", "ffmpeg", "has_live_terminal", "progress_bar"]
