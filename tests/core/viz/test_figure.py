import io
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from helpers.pictures import pixels, replay_of, short_episode
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.path import Path

from warehouse_core.viz.figure import SceneFigure, make_figure
from warehouse_core.viz.line_of_text import font_of
from warehouse_core.viz.replay import Replay
from warehouse_core.viz.shapes import BAR, CIRCLE, DOTS, Shape, Shapes, lines, stamped

LAST = 6


def film() -> Replay:
    """Return a replay without charts, which is quick to draw."""
    return replay_of(short_episode().frames)


@cache
def drawn_in_new_figure(
    frame: int, change: Callable[[Replay], object] = lambda _: None
) -> np.ndarray:
    """Return the pixels of a frame in a figure that has drawn nothing before."""
    replay = film()
    replay.go_to(frame)
    change(replay)
    replay.figure.stale = True
    return pixels(replay)


@pytest.fixture
def replay() -> Replay:
    return film()


@pytest.fixture
def background_drawings(monkeypatch: pytest.MonkeyPatch) -> list[SceneFigure]:
    """Return a list that grows with each drawing of the background."""
    drawings: list[SceneFigure] = []
    draw_still = SceneFigure._draw_still

    def counted(self: SceneFigure, *arguments: object, **options: bool) -> None:
        drawings.append(self)
        draw_still(self, *arguments, **options)

    monkeypatch.setattr(SceneFigure, "_draw_still", counted)
    return drawings


def test_a_frame_over_the_cached_background_equals_a_new_drawing(replay: Replay) -> None:
    pixels(replay)
    for frame in (1, 6, 2):
        replay.go_to(frame)
        assert np.array_equal(pixels(replay), drawn_in_new_figure(frame)), f"frame {frame}"


def test_frames_do_not_draw_the_background_again(replay, background_drawings) -> None:
    pixels(replay)
    before = len(background_drawings)
    for frame in (1, 4):
        replay.go_to(frame)
        pixels(replay)
    assert len(background_drawings) == before


def zoom(replay: Replay) -> None:
    replay.figure.axes[0].set_xlim(1, 4)


def resize(replay: Replay) -> None:
    replay.figure.set_size_inches(7.31, 3.3)


def refine(replay: Replay) -> None:
    replay.figure.set_dpi(70)


@pytest.mark.parametrize("change", [zoom, resize, refine])
def test_a_change_of_the_background_is_drawn(replay, change) -> None:
    replay.go_to(2)
    before = pixels(replay)
    change(replay)
    after = pixels(replay)
    assert before.shape != after.shape or not np.array_equal(before, after)
    assert np.array_equal(after, drawn_in_new_figure(2, change))
    replay.go_to(4)
    assert np.array_equal(pixels(replay), drawn_in_new_figure(4, change))


def test_a_vector_drawing_includes_the_moving_parts() -> None:
    figure = film().figure
    small, whole = io.BytesIO(), io.BytesIO()
    movers = figure._movers
    figure.savefig(whole, format="svg")
    for mover in movers:
        mover.set_visible(False)
    figure.savefig(small, format="svg")
    assert len(small.getvalue()) < len(whole.getvalue())
    assert not any(mover.get_visible() for mover in movers), "what is hidden stays hidden"
    assert all(mover.get_animated() for mover in movers)


def test_a_listener_that_moves_something_does_not_change_the_present_drawing() -> None:
    # A replay is such a listener: its first drawing starts it and shows its current frame.
    replay = film()
    replay.show_still()
    assert np.array_equal(pixels(replay), drawn_in_new_figure(LAST))


def test_a_figure_without_pixels_raises() -> None:
    figure = SceneFigure(figsize=(2, 1))
    FigureCanvasSVG(figure)
    with pytest.raises(TypeError, match="FigureCanvasSVG has no pixels"):
        figure.pixels()


def test_frames_with_charts_equal_new_drawings() -> None:
    replay, new = (replay_of(short_episode()) for _ in range(2))
    last = len(replay._scene) - 1
    for frame in (0, 1, last // 2, last, 3, 3):
        replay.go_to(frame)
        new.go_to(frame)
        new.figure.stale = True
        assert np.array_equal(pixels(replay), pixels(new)), f"frame {frame}"
        replay._scene.toggle_arrows()
        new._scene.toggle_arrows()


def random_shapes(random: np.random.Generator) -> list[Shape]:
    """Return shapes of one or two polygons in a room of 4 x 4 cells, some of which reach out."""
    shapes = []
    for _ in range(random.integers(1, 4)):
        places = random.integers(-1, 6, (random.integers(1, 3), 2))
        color, line = ((0.1, 0.2, shade) for shade in random.choice([0.3, 0.9], 2))
        kind = random.integers(0, 3)
        if kind == 0:
            shapes.append(Shape(stamped(BAR, places), color, alpha=0.5))
        elif kind == 1:
            shapes.append(Shape(stamped(CIRCLE * 0.7, places), color, line, 0.1))
        else:
            shapes.append(Shape(lines([places.tolist()]), None, line, 0.3, DOTS))
    return shapes


def varied(shape: Shape, random: np.random.Generator) -> Shape:
    """Return a shape with another colour, or with one corner elsewhere if it is opaque."""
    if shape.fill and random.random() < 0.5:
        return shape._replace(fill=(0.9, 0.8, 0.1))
    corners = np.array(shape.path.vertices)
    corners[random.integers(0, len(corners))] += 1.3 * (shape.alpha == 1)
    return shape._replace(path=Path(corners, shape.path.codes))


@pytest.mark.parametrize("seed", range(6))
def test_what_changes_in_axes_is_redrawn_completely(seed: int) -> None:
    random = np.random.default_rng(seed)
    figures, layers = [], []
    for _ in range(2):
        figures.append(make_figure((1, 1)))
        axes = figures[-1].add_axes((0.3, 0.1, 0.6, 0.6), xlim=(0, 4), ylim=(4, 0))
        layers.append([Shapes(), Shapes()])
        figures[-1].add_movers(axes, *layers[-1])
    for turn in range(8):
        for number in range(2):
            if random.random() < 0.6 or turn == 0:
                shapes = random_shapes(random) if random.random() < 0.5 else []
                old = [varied(s, random) if random.random() < 0.4 else s
                       for s in layers[0][number].shapes[: random.integers(2, 6)]]  # fmt: skip
                for movers in layers:
                    movers[number].show([*old, *shapes])
        figures[1].stale = True
        assert np.array_equal(*(figure.rgba() for figure in figures))


@pytest.mark.parametrize("pixels", [9.0, 12.5, 22.9])
def test_letters_are_composed_as_pillow_composes_them(pixels: float) -> None:
    font = font_of("bold", pixels)
    for text in ("step 10 of 200", "AVATAR To. 'Ty, f", "WA-ffi;jg|@"):
        mask, length = font.line(text)
        # Where letters touch, Pillow 10 takes the darker one instead of drawing one over the other.
        assert np.abs(mask.astype(int) - font._draw(text)).max() <= 2
        assert length == font._pillow.getlength(text)


@pytest.mark.parametrize("size", [9, 18])
@pytest.mark.parametrize("style", [{}, {"ha": "right"}, {"ha": "center", "fontweight": "bold"}])
def test_a_line_of_text_is_where_matplotlib_would_write_it(size: int, style: dict) -> None:
    figures = [SceneFigure(figsize=(4, 1)) for _ in range(2)]
    for figure in figures:
        FigureCanvasAgg(figure)
    style = {"va": "center", "fontsize": size, "color": "black", **style}
    figures[0].add_text(2, 0.5, text="step 9 of 12", **style)
    figures[1].add_mover(figures[1].text(0.5, 0.5, "step 9 of 12", **style))
    inked = [np.argwhere(figure.rgba()[..., 0] < 128) for figure in figures]
    for edge in (np.min, np.max):
        ours, theirs = (edge(each, axis=0) for each in inked)
        # Versions of matplotlib space small letters differently; this is half of a letter.
        assert abs(ours - theirs).max() <= 4
    assert len(inked[0]) == pytest.approx(len(inked[1]), rel=0.25)
