"""The file formats of replays, and the tools that write them.

Example:
    >>> from warehouse_core.viz.export import FORMATS
    >>> FORMATS
    ('.gif', '.mp4', '.html', '.svg', '.png')
"""

from warehouse_core.viz.export.formats import FORMATS, ffmpeg, has_live_terminal, progress_bar

__all__ = ["FORMATS", "ffmpeg", "has_live_terminal", "progress_bar"]
