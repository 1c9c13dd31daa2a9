"""The canvas of the page that plays tracks, compared with the tracks."""

import dataclasses
from collections.abc import Callable, Iterator

import pytest
from helpers.player_pages import Files, Shown
from matplotlib.colors import to_hex

from agents.run_episode import run_episode
from warehouse_core.render.palette import COLORS, HIT, ORDER_COLORS, PALETTE, STRANDED
from warehouse_core.viz.tracks import Frame, Pose, Track, track_of_record
from warehouse_core.viz.tracks.track import DrawnHit, FleetFrame, Marks, Push, Waiting
from warehouse_core.world.tiles import CHARGER, DROPOFF, PICKUP, ROBOT_EMPTY, ROBOT_LOADED, WALL

pytestmark = pytest.mark.browser

Open = Callable[..., Shown]

EMPTY_COLOR, LOADED_COLOR = to_hex(COLORS[ROBOT_EMPTY]), to_hex(COLORS[ROBOT_LOADED])
STAR = to_hex(HIT)
COLORS_OF_MAP = """
() => {
  const map = document.querySelector('[data-part="map"]');
  const [width, height] = [map.width, map.height];
  const copy = Object.assign(document.createElement("canvas"), {width, height});
  const context = copy.getContext("2d", {willReadFrequently: true});
  context.drawImage(map, 0, 0);
  const { data } = context.getImageData(0, 0, width, height);
  const hex = (byte) => byte.toString(16).padStart(2, "0");
  const color = (i) => "#" + [...data.slice(4 * i, 4 * i + 3)].map(hex).join("");
  return Array.from({length: width * height}, (_, i) => color(i));
}
"""
"""Function that returns the colour of each cell of the map of a fleet."""


def cell(row: float, col: float) -> tuple[float, float, float, float]:
    """Return the box of a cell."""
    return col, row, 1, 1


@pytest.fixture(scope="module")
def track() -> Track:
    return track_of_record(run_episode("greedy", "grid", seed=12))


@pytest.mark.parametrize(("density", "scheme"), [(1, "light"), (2, "dark")])
def test_tiles_and_the_robot_are_where_the_track_has_them(
    opened: Open, files: Files, track: Track, density: int, scheme: str
) -> None:
    path = files("seen", lambda: [dataclasses.replace(track, view_radius=None)])
    page = opened(path, device_scale_factor=density, color_scheme=scheme)
    width = page.read("player.panels[0].canvas.width / player.panels[0].canvas.clientWidth")
    assert width == pytest.approx(density, rel=0.01)
    rows = track.frames[0].tiles
    inner = [(row, col) for row in range(1, len(rows) - 1) for col in range(1, len(rows[0]) - 1)]
    for tile, color in (
        (WALL, "shelf"), *((tile, to_hex(COLORS[tile])) for tile in (PICKUP, DROPOFF, CHARGER)),
    ):  # fmt: skip
        shares = page.shares(color, [cell(*place) for place in inner])
        found = [place for place, share in zip(inner, shares, strict=True) if share > 0.3]
        assert found == [(row, col) for row, col in inner if rows[row][col] == tile]
    for step in (0, 5, 9, 12, track.steps):
        page.seek(step)
        pose = track.frames[step].robots[0]
        assert pose is not None
        mine, other = EMPTY_COLOR, LOADED_COLOR
        if pose.loaded:
            mine, other = other, mine
        x, y = pose.at
        assert page.share(mine, (x - 0.3, y - 0.3, 0.6, 0.6)) > 0.15
        assert page.share(other, (x - 0.3, y - 0.3, 0.6, 0.6)) < 0.02
        box = page.share("item", (x - 0.3, y - 0.3, 0.6, 0.6))
        assert box > 0.05 if pose.loaded or step == track.steps else box == 0


def test_the_item_waits_at_the_pickup_is_carried_and_stays_at_the_dropoff(
    opened: Open, files: Files, track: Track
) -> None:
    page = opened(files("grid", lambda: [track]))
    [picked] = [i for i, f in enumerate(track.frames) if "Pick up" in f.caption]
    rows = track.frames[0].tiles
    [pickup] = [(r, line.index("P")) for r, line in enumerate(rows) if "P" in line]
    [dropoff] = [(r, line.index("D")) for r, line in enumerate(rows) if "D" in line]
    shares = []
    for step in (0, picked - 1, picked + 3, track.steps):
        page.seek(step)
        shares.append([page.share("item", cell(*place)) > 0.03 for place in (pickup, dropoff)])
    assert shares == [[True, False], [True, False], [False, False], [False, True]]
    page.seek(1.5)
    (x, y), (other_x, other_y) = (track.frames[i].robots[0].at for i in (1, 2))  # type: ignore[union-attr]
    assert page.share(EMPTY_COLOR, (x - 0.25, y - 0.25, 0.5, 0.5)) > 0.4
    assert page.share(EMPTY_COLOR, (other_x - 0.25, other_y - 0.25, 0.5, 0.5)) < 0.1, "it jumps"


def body_track(drive: str, **changes: object) -> Track:
    """Return a track of a body that drives east, brakes and skids, with a ray and an outline."""
    rows = ("########", *["#......#"] * 4, "########")
    poses = [
        Pose((1.5 + x, 2.5), 0.0, False, Push((speed, 0.0), (force, 0.0), skids=skids))
        for x, speed, force, skids in ((0, 0, 0, False), (1, 1, 60, False), (2, 0.5, -60, True))
    ]
    lines = ((True, (1.5, 4.5), (5.5, 4.5)), (False, (6.2, 1.5), (6.8, 1.5)))
    frames = [Frame(rows, (pose,), i / 2, clock=i, lines=lines) for i, pose in enumerate(poses)]
    return Track(frames, {}, True, drive=drive, slippery=((2, 3),), **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize("drive", ["differential", "omnidirectional", ""])
def test_a_body_has_a_chassis_a_drive_arrows_a_brake_light_and_skid_marks(
    opened: Open, files: Files, drive: str
) -> None:
    track = body_track(drive, ghost=[(5.5, 3.5)] * 3)
    page = opened(files(f"body {drive}", lambda: [track]))
    chassis, wheel = (1.3, -0.15, 0.4, 0.3), (1.4, -0.31, 0.2, 0.08)
    rear, ahead = (1.16, -0.15, 0.06, 0.3), (2.0, -0.05, 0.3, 0.1)

    def share(color: str, box: tuple[float, float, float, float], x: float) -> float:
        left, top, width, height = box
        return page.share(color, (left + x, 2.5 + top, width, height))

    page.read("player.seek(1)")
    assert share(EMPTY_COLOR, chassis, 1) > 0.7
    assert (share("rim", wheel, 1) > 0.9) == (drive == "differential")
    ring = share("rim", (1.5 + 0.33, -0.1, 0.04, 0.2), 1)
    assert (ring > 0.5) == (drive == "omnidirectional")
    assert share("brake", rear, 1) == 0
    assert share("velocity", ahead, 1) > 0.3
    page.read("player.seek(2)")
    assert share("brake", rear, 2) > 0.4
    assert share("force", (0.8, -0.05, 0.2, 0.1), 2) > 0.4
    assert page.share("ink", (5.1, 3.1, 0.8, 0.8)) > 0.02, "the ghost"
    # Skid marks are half as dark as ink.
    left = page.read("player.tracks[0].skid.join()")
    assert left == "0,0,1"
    ray, outline = (2.2, 4.45, 3, 0.1), (6.25, 1.45, 0.5, 0.1)
    assert page.share("ink", ray) > 0.02
    assert page.share("ink", outline) > 0.1
    page.press("v")
    assert share("force", (0.8, -0.05, 0.2, 0.1), 2) == 0
    assert page.share("ink", ray) == 0
    assert page.share("ink", outline) > 0.1
    page.press("v")
    assert share("force", (0.8, -0.05, 0.2, 0.1), 2) > 0.4


def simple(frames: list[Frame], **changes: object) -> Track:
    """Return a track of frames, without metrics."""
    return dataclasses.replace(Track(frames, {}), **changes)  # type: ignore[arg-type]


def test_a_hit_is_a_star_with_its_label_while_its_frame_is_shown(opened, files) -> None:
    rows = ("......", "......", "......", "......")
    pose = Pose((2.5, 2.5), 0.0, False)
    frames = [Frame(rows, (pose,), float(step)) for step in range(3)]
    frames[1].hits = (DrawnHit((4.0, 2.5), "12 N·s"),)
    page = opened(files("hit", lambda: [simple(frames)]))
    star, label = (3.75, 2.25, 0.5, 0.5), (3, 1, 2, 1)
    seen = []
    for step in (0, 1, 2):
        page.seek(step)
        seen.append((page.share(STAR, star) > 0.2, page.share(STAR, label) > 0.03))
    assert seen == [(False, False), (True, True), (False, False)]


def test_slippery_and_unseen_cells_and_the_view_are_drawn(opened: Open, files: Files) -> None:
    rows = ("......", "..?...", "......", "......")
    pose = Pose((0.5, 3.5), None, False)
    track = simple([Frame(rows, (pose,), 0.0)], slippery=((0, 4),), view_radius=1)
    page = opened(files("floors", lambda: [track]))
    assert page.share("floor", cell(0, 4)) == 0
    assert page.share("floor", cell(1, 2)) < 0.2
    assert page.share("floor", cell(0, 0)) < 0.1, "it is out of the view"
    assert page.share("floor", cell(2, 1)) > 0.8, "it is in the view"
    without = opened(files("no floors", lambda: [dataclasses.replace(track, view_radius=None)]))
    assert without.share("floor", cell(0, 0)) > 0.8


def fleet_frames() -> Iterator[Frame]:
    """Yield frames of two robots of a fleet and a person, the second robot loaded, then empty."""
    rows = ("........",) * 4
    for step in range(3):
        poses = (
            Pose((1.5 + step, 0.5), 0.0, False), Pose((4.5, 2.5), None, step < 2),
            Pose((7.5, 3.5), None, False),
        )  # fmt: skip
        items = (None, 3 if step < 2 else None)
        yield Frame(rows, poses, float(step), fleet=FleetFrame((), items, (1.0, 0.0)))


def test_robots_of_a_fleet_show_their_items_age_and_an_empty_battery(opened, files) -> None:
    page = opened(files("two", lambda: [simple(list(fleet_frames()))]))
    page.read("player.choose(1)")
    late = to_hex(ORDER_COLORS[3])
    for step, is_late in ((0, True), (2, False)):
        page.seek(step)
        assert (page.share(late, cell(2, 4)) > 0.03) == is_late
        assert page.part("load").inner_text() == ("loaded" if is_late else "empty")
    assert page.share(to_hex(STRANDED), cell(2, 4)) > 0.1, "it is stranded"
    assert page.share(EMPTY_COLOR, cell(0, 3)) > 0.1
    assert page.share(EMPTY_COLOR, cell(0, 1)) == 0
    assert page.share(to_hex(COLORS["H"]), cell(3, 7)) > 0.1


def test_the_map_next_to_a_fleet_has_the_cells_in_which_robots_were_held_up(opened, files) -> None:
    scheme = "dark"
    held_up = [(1, (0, 2)), (2, (0, 2)), (2, (3, 7))]
    path = files("map", lambda: [simple(list(fleet_frames()), held_up=held_up)])
    page = opened(path, color_scheme=scheme)
    *_, half, _, _, full = PALETTE["heat"][scheme]
    seen = []
    for step in (2, 0, 1):
        page.seek(step)
        colors = enumerate(page.read(COLORS_OF_MAP))
        hot = {divmod(n, 8): color for n, color in colors if color in PALETTE["heat"][scheme]}
        seen.append((hot, page.part("most").inner_text(), page.part("peak").inner_text()))
    assert seen == [
        ({(0, 2): full, (3, 7): half}, "2 times", "most often at row 0, column 2"),
        ({}, "0 times", "No robot was held up so far."),
        ({(0, 2): full}, "1 time", "most often at row 0, column 2"),
    ]
    assert page.part("map").get_attribute("aria-label") == (
        "Robots were held up most often at row 0, column 2: 1 time"
    )


def test_marks_have_the_colour_of_their_time(opened: Open, files: Files) -> None:
    rows = ("......",) * 3
    frames = [Frame(rows, (), float(step)) for step in range(4)]
    marks = Marks(
        [1, 2, 3], [(1, 1), (1, 2), (1, 1)], [0, 0, 1], [(0.0, 1.0, 1.0), (1.0, 0.0, 1.0)],
        ["expanded", "path"], ((0, 0), (2, 5)),
    )  # fmt: skip
    page = opened(files("marks", lambda: [simple(frames, marks=marks)]))
    seen = []
    for time in (3, 0, 1, 2, 1):
        page.read(f"player.seek({time})")
        seen.append(
            "".join(
                "c" if page.share("#00ffff", cell(1, col)) > 0.8
                else "m" if page.share("#ff00ff", cell(1, col)) > 0.8
                else "."
                for col in (1, 2)
            )
        )  # fmt: skip
    assert seen == ["mc", "..", "c.", "cc", "c."]


def test_a_floor_of_many_columns_has_stations_and_robots_of_a_least_size(opened, files) -> None:
    rows = ["." * 500 for _ in range(140)]
    rows[70] = "." * 250 + "D" + "." * 249
    pose = Pose((100.5, 20.5), None, False)
    page = opened(files("large", lambda: [simple([Frame(tuple(rows), (pose,), 0.0)])]))
    scale = page.read("player.views[0].scale")
    assert scale < 3
    robot = page.share(EMPTY_COLOR, (90.5, 10.5, 20, 20)) * (20 * scale) ** 2
    assert robot >= 4
    station = page.share(to_hex(COLORS[DROPOFF]), (240.5, 60.5, 20, 20)) * (20 * scale) ** 2
    assert station >= 16


WIDE_ROWS = ("#" * 60, *["#" + "." * 58 + "#"] * 13, "#" * 60)
RECORD_TEXTS = """
() => {
  const write = CanvasRenderingContext2D.prototype.fillText;
  globalThis.written = [];
  CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
    const size = this.font.split(" ").find((part) => part.endsWith("px"));
    written.push([text, Number.parseFloat(size)]);
    write.call(this, text, ...place);
  };
}
"""
"""Script that records each text that is written on a canvas, and its size."""


def wide_fleet() -> Track:
    """Return a track of 50 robots next to each other on a wide floor."""
    poses = tuple(Pose((1.5 + robot, 2.5), None, robot % 2 == 1) for robot in range(50))
    items = tuple(0 if pose.loaded else None for pose in poses)
    fleet = FleetFrame((), items, (1.0,) * 50)
    return simple([Frame(WIDE_ROWS, poses, float(step), fleet=fleet) for step in range(2)])


def texts(page: Shown) -> dict[str, float]:
    """Return the texts on the floors of a page after it is drawn, and their sizes."""
    return dict(page.read(f"({RECORD_TEXTS})() ?? player.draw() ?? written"))


def numbers(page: Shown) -> dict[str, float]:
    """Return the numbers among the texts."""
    return {text: size for text, size in texts(page).items() if text.isdecimal()}


def test_robots_of_a_fleet_have_numbers_where_they_fit(opened: Open, files: Files) -> None:
    path = files("fifty", lambda: [wide_fleet()])
    found = numbers(opened(path, viewport={"width": 1366, "height": 768}))
    assert {*found} == {str(robot) for robot in range(50)}
    assert min(found.values()) >= 11
    phone = opened(path, viewport={"width": 360, "height": 780})
    assert numbers(phone) == {}
    phone.page.locator("canvas.floor").click(position=place_of(phone, 20))
    assert numbers(phone) == {"20": 11}


def place_of(page: Shown, robot: int) -> dict[str, float]:
    """Return the middle of a robot, in pixels of its canvas."""
    place: dict[str, float] = page.read(
        f"""(() => {{
          const [{{ track, view }}] = player.panels;
          const pose = track.pose({robot}, track.at(player.time));
          return {{ x: view.x(pose.x), y: view.y(pose.y) }};
        }})()"""
    )
    return place


@pytest.mark.parametrize("width", [360, 1366])
def test_an_order_that_waits_leaves_the_letter_of_its_pickup(opened, files, width) -> None:
    rows = ("P" + "." * 14 + "D", *["." * 16] * 9)
    fleets = [FleetFrame(waiting, (None, None), (1.0, 1.0))
              for waiting in ((), (Waiting((0.5, 0.5), 1, 0),))]  # fmt: skip
    poses = tuple(Pose((col + 0.5, 4.5), None, False) for col in (3, 5))
    frames = [Frame(rows, poses, float(step), fleet=fleet) for step, fleet in enumerate(fleets)]
    path = files("waits", lambda: [simple(frames)])
    page = opened(path, viewport={"width": width, "height": 768})
    letter, item = (0.05, 0.05, 0.45, 0.45), (0.55, 0.55, 0.4, 0.4)
    shares = []
    for step in (0, 1):
        page.seek(step)
        shares.append([page.share("dark", box) for box in (letter, item)])
    (before, nothing), (after, box) = shares
    assert before == after > 0.02
    assert nothing == 0 < box


@pytest.mark.parametrize("count", [2, 4, 5])
def test_all_floors_are_above_the_bar_on_a_projector(opened, files, track, count) -> None:
    page = opened(
        files(f"row of {count}", lambda: [track] * count), viewport={"width": 1280, "height": 720}
    )
    bottoms = "Math.max(...[...document.querySelectorAll('.floor')].map(BOTTOM))"
    bottom = "(each) => each.getBoundingClientRect().bottom"
    lowest = page.read(bottoms.replace("BOTTOM", bottom))
    assert 360 < lowest <= page.read("document.querySelector('.bar').getBoundingClientRect().top")
