"""A description of a figure of Matplotlib: a line for each path, text and image, in order."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.backend_bases import RendererBase
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

WHITE = "#ffffff"

MANY = 9
"""Number of corners from which a path is described by its box and its moments."""


class Lines(RendererBase):
    """Renderer that describes its calls, in pixels from the bottom left."""

    def __init__(self, figure: Figure) -> None:
        super().__init__()
        self.dpi, self.size = figure.dpi, figure.bbox.size
        self.lines = [f"figure {self.size[0]:.0f} {self.size[1]:.0f} {self.dpi:.0f}"]

    def get_canvas_width_height(self) -> tuple[float, float]:
        return self.size[0], self.size[1]

    def points_to_pixels(self, points: Any) -> Any:
        return points * self.dpi / 72

    def draw_path(self, gc: Any, path: Any, transform: Any, rgbFace: Any = None) -> None:  # noqa: N803
        corners = transform.transform(path.vertices)
        is_white = rgbFace is not None and to_hex(rgbFace) == WHITE
        if is_white and len(corners) == 5 and not gc.get_linewidth():
            return  # only some versions draw the backgrounds of axes in one place
        if len(corners) >= MANY:
            corners = np.vstack([corners.min(0), corners.max(0), corners.mean(0), corners.std(0)])
        face = "" if rgbFace is None else f" face {_color(rgbFace, gc.get_alpha(), gc)}"
        edge = ""
        if gc.get_linewidth():
            dashes = _numbers(gc.get_dashes()[1] or ())
            edge = f" edge {_color(gc.get_rgb(), None, gc)} {gc.get_linewidth():.2f} {dashes}"
        self.lines.append(
            f"path {len(path.vertices)}{face}{edge}{_clip(gc)} at {_numbers(corners.flat)}"
        )

    def draw_text(
        self, gc: Any, x: float, y: float, s: str, prop: Any, angle: float, *_: object, **__: object
    ) -> None:
        style = f"{prop.get_size_in_points():.1f} {prop.get_weight()} {prop.get_style()}"
        place = _numbers((x, self.size[1] - y, angle))
        self.lines.append(f"text {s!r} {style} {_color(gc.get_rgb(), None, gc)} at {place}")

    def draw_image(self, gc: Any, x: float, y: float, im: Any, transform: Any = None) -> None:
        means = im.reshape(-1, 4).mean(0), np.arange(im.size) @ im.ravel() / im.sum()
        self.lines.append(f"image {im.shape} {_numbers(np.hstack(means))}{_clip(gc)} at {x} {y}")


def drawn(figure: Figure) -> list[str]:
    """Return a line for each object in a figure."""
    renderer = Lines(figure)
    figure.draw(renderer)
    return renderer.lines


def _color(color: Any, alpha: float | None, gc: Any) -> str:
    if alpha is not None and gc.get_forced_alpha():
        color = (*color[:3], alpha)
    return to_hex(color, keep_alpha=True)


def _clip(gc: Any) -> str:
    box = gc.get_clip_rectangle()
    return f" clip {_numbers(box.bounds)}" if box else ""


def _numbers(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:.1f}" for number in numbers)
