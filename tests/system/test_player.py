"""The page that plays tracks, in a real browser: every control, with keys and with the mouse."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.fleets import fleet_episode
from helpers.player_pages import Files, Shown, wait_until

from agents.run_episode import run_episode
from warehouse_core.viz.player import player_frame
from warehouse_core.viz.tracks import Track, track_of_record

pytestmark = pytest.mark.browser

Open = Callable[..., Shown]


@pytest.fixture(scope="module")
def track() -> Track:
    """Return an episode on the grid with a pick and a drop."""
    return track_of_record(run_episode("greedy", "grid", seed=12))


@pytest.fixture(scope="module")
def fleet() -> Track:
    return track_of_record(fleet_episode())


@pytest.fixture
def page(opened: Open, files: Files, track: Track) -> Shown:
    return opened(files("grid", lambda: [track]))


@pytest.fixture
def crowd(opened: Open, files: Files, fleet: Track) -> Shown:
    return opened(files("fleet", lambda: [fleet]))


def steps(page: Shown) -> int:
    """Return the step that the page shows, which is the same in text and slider."""
    step: int = page.read("player.step")
    assert page.part("place").inner_text().startswith(f"step {step} of ")
    assert page.part("slider").input_value() == str(step)
    return step


def test_keys_and_buttons_go_to_steps(page: Shown, track: Track) -> None:
    last = track.steps
    keys = [
        ("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("Home", 0), ("ArrowLeft", 0),
        ("End", last), ("ArrowRight", last), ("ArrowLeft", last - 1),
    ]  # fmt: skip
    for key, step in keys:
        page.press(key)
        assert (key, steps(page)) == (key, step)
    names = {"Go to the start": 0, "One step forward": 1, "One step back": 0, "Go to the end": last}
    for name, step in names.items():
        page.page.get_by_role("button", name=name, exact=True).click()
        assert (name, steps(page)) == (name, step)


def test_space_plays_and_pauses_at_the_speed_that_is_shown(opened, files, track) -> None:
    page = opened(files("grid", lambda: [track]), is_held=True)
    for speed, seconds in (("1", 2), ("4", 1), ("0.25", 2)):
        page.press("Home")
        page.part("speed").select_option(speed)
        page.page.get_by_role("button", name="One step back").click()
        page.press("Space")
        assert page.page.get_by_role("button", name="Pause", exact=True).count() == 1
        page.page.clock.run_for(1000 * seconds)
        page.press("Space")
        assert page.read("player.time") == pytest.approx(float(speed) * seconds, rel=0.05)
        at = page.pictures()
        page.page.clock.run_for(500)
        assert page.pictures() == at, "it is paused"


def test_a_page_plays_once_by_itself_and_rests_on_the_end_and_then_starts_again(
    opened: Open, files: Files, track: Track
) -> None:
    page = opened(files("playing", lambda: [track], opens_at=None), is_held=True)
    wait_until(page.page, "player.isPlaying")
    page.page.clock.run_for(100)
    page.page.clock.fast_forward(60_000)
    assert page.read("player.time / player.speed") < 1.2, "a hidden page goes on where it was"
    page.read("player.speed = 16")
    page.page.clock.run_for(2000 * track.steps / 16)
    assert page.read("[player.step, player.isPlaying]") == [track.steps, False]
    assert page.part("ending").inner_text().lower() == track.ending
    page.part("play").click()
    assert page.read("[player.step, player.isPlaying]") == [0, True]
    page.page.clock.run_for(500)
    page.part("play").click()
    assert page.part("play").get_attribute("aria-label") == "Play"
    assert 0 < page.read("player.time") < track.steps


@pytest.mark.parametrize("stop", ["q", "Space", "canvas.floor"])
def test_any_key_or_click_stops_a_page_that_plays_by_itself(opened, files, track, stop) -> None:
    page = opened(files("playing", lambda: [track], opens_at=None), is_held=True)
    wait_until(page.page, "player.isPlaying")
    page.page.clock.run_for(600)
    if "." in stop:
        page.page.locator(stop).click(position={"x": 3, "y": 3})
    else:
        page.press(stop)
    at = page.read("player.time")
    assert at > 1
    page.page.clock.run_for(600)
    assert page.read("[player.time, player.isPlaying]") == [at, False]


@pytest.mark.parametrize(
    ("opens_at", "motion", "time"),
    [(None, "reduce", 0), (1e9, "no-preference", "player.end"), (7.5, "no-preference", 7.5)],
)
def test_a_page_that_is_to_open_at_a_moment_rests_there(
    opened: Open, files: Files, track: Track, opens_at: float | None, motion: str, time: object
) -> None:
    path = files(f"{opens_at}", lambda: [track], opens_at=opens_at)
    page = opened(path, reduced_motion=motion)
    page.page.wait_for_timeout(150)
    assert page.read(f"player.time === {time} && !player.isPlaying")


def test_players_in_frames_play_by_themselves_while_they_are_in_sight(
    opened: Open, track: Track, tmp_path: Path
) -> None:
    slow = player_frame([track], speed=0.25)  # It plays for longer than the test waits.
    frames = "<p style='height: 500px'></p>".join([slow] * 3)
    outer = tmp_path / "frames.html"
    outer.write_text(f"<!DOCTYPE html><script>globalThis.player = 0</script>Players{frames}")
    page = opened(outer)
    _, *players = page.page.frames
    for seen in (0, 2, 1, 0):
        page.page.locator("iframe").nth(seen).scroll_into_view_if_needed()
        for number, player in enumerate(players):
            is_seen = str(number == seen).lower()
            wait_until(player, f"globalThis.player?.isPlaying === {is_seen}")
        wait_until(players[seen], "player.time > 0")
    assert all(player.evaluate("player.isOpening && player.time > 0") for player in players)


def test_the_energy_of_a_fleet_is_that_of_its_chart_while_it_plays(opened, files) -> None:
    episode = fleet_episode(backend="physics", max_steps=20)
    page = opened(files("fleet of bodies", lambda: [track_of_record(episode)]))
    used = episode.joules.sum(axis=1).cumsum()
    for step in (3, 12):
        page.read(f"player.seek(player.longest.timeOf({step}) + 0.5)")
        facts, chart = page.part("facts").inner_text(), page.read("player.charts.at(-1).text")
        assert facts == f"{page.read('player.time'):.1f} s, {used[step - 1]:,.0f} J"
        assert chart == f"Energy used (kJ): energy {used[step - 1] / 1000:.2f}".rstrip("0")


def test_a_chart_is_clicked_and_dragged(page: Shown, track: Track) -> None:
    chart = page.page.locator(".chart > svg").first
    box = chart.bounding_box()
    for share in (0.3, 0.8):
        chart.click(position={"x": share * box["width"], "y": 30})
        expected = page.read(f"player.charts[0].timeAt({share} * {box['width']})")
        assert page.read("player.time") == pytest.approx(expected, abs=0.01)
        assert 0 < expected < track.steps
    chart.hover(position={"x": 0.5 * box["width"], "y": 30})
    before = page.read("player.time")
    assert before == pytest.approx(expected, abs=0.01), "moving without a button does nothing"
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + box["width"] + 50, box["y"] + 30)
    page.page.mouse.up()
    assert steps(page) == track.steps


def events(track: Track, robot: int) -> list[int]:
    """Return the frames in which a robot picks, drops or is blocked."""
    found = []
    for index, (before, frame) in enumerate(zip(track.frames, track.frames[1:], strict=False), 1):
        was, now = before.robots[robot], frame.robots[robot]
        assert was
        assert now
        if was.loaded != now.loaded or any(hit.robot == robot for hit in frame.hits):
            found.append(index)
    return found


def test_n_goes_from_event_to_event_and_says_which(page: Shown, track: Track) -> None:
    for step, words in zip(events(track, 0), ("item picked up", "item delivered"), strict=True):
        page.press("n")
        assert (steps(page), page.part("event").inner_text()) == (step, words)
    page.page.get_by_role("button", name="Next event").click()
    assert steps(page) == track.steps
    assert "no more events" in page.part("event").inner_text()


def test_keys_with_ctrl_are_the_browsers(page: Shown) -> None:
    page.press("Control+ArrowRight")
    assert page.read("player.step") == 0


def test_help_is_a_dialog_whose_keys_are_its_own(page: Shown) -> None:
    dialog = page.part("helping")
    page.press("?", "ArrowRight", "n")
    assert dialog.is_visible()
    assert steps(page) == 0
    page.press("Escape", "ArrowRight")
    assert not dialog.is_visible()
    assert steps(page) == 1
    page.page.get_by_role("button", name="Help").click()
    page.page.get_by_role("button", name="Close").click()
    assert not dialog.is_visible()


def test_a_floor_is_zoomed_moved_and_fitted_by_keys_buttons_and_pointer(page: Shown) -> None:
    def view(name: str) -> Any:
        return page.read(f"player.views[0].{name}")

    whole, mouse = page.pictures(), page.page.mouse
    page.press("+", "+")
    assert view("zoom") == pytest.approx(2.25)
    assert page.pictures() != whole
    box = page.page.locator("canvas.floor").bounding_box()
    center = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before, scale = view("middle"), view("scale")
    mouse.move(*center)
    mouse.down()
    mouse.move(center[0] + 40, center[1] + 30)
    mouse.up()
    expected = [before[0] - 40 / scale, before[1] - 30 / scale]
    assert view("middle") == pytest.approx(expected, abs=0.02)
    before = view("middle")
    page.press("Shift+ArrowRight", "Shift+ArrowDown")
    assert [now > then for now, then in zip(view("middle"), before, strict=True)] == [True, True]
    page.press("Shift+ArrowLeft", "Shift+ArrowUp")
    assert view("middle") == pytest.approx(before)
    assert steps(page) == 0, "arrows alone go to another step"
    page.press("0")
    assert page.pictures() == whole
    for name in ("Zoom in", "Zoom in", "Zoom out"):
        page.page.get_by_role("button", name=name).click()
    assert view("zoom") == pytest.approx(1.5)
    page.page.get_by_role("button", name="Fit the floor").click()
    assert page.pictures() == whole
    mouse.move(*center)
    mouse.wheel(0, -100)
    assert view("zoom") == 1
    page.page.keyboard.down("Control")
    mouse.wheel(0, -100)
    wait_until(page.page, "player.views[0].zoom > 1.1")
    page.page.keyboard.up("Control")


def click_robot(page: Shown, robot: int) -> None:
    """Click the middle of a robot of the first track."""
    x, y = page.read(
        f"""(() => {{
          const [panel] = player.panels;
          const pose = panel.track.pose({robot}, panel.track.at(player.time));
          return [panel.view.x(pose.x) / devicePixelRatio, panel.view.y(pose.y) / devicePixelRatio];
        }})()"""
    )
    page.page.locator("canvas.floor").first.click(position={"x": x, "y": y})


def test_a_robot_is_chosen_by_a_click_and_by_its_number(crowd: Shown, fleet: Track) -> None:
    number = crowd.part("number")
    assert number.input_value() == ""
    for robot in range(4):
        click_robot(crowd, robot)
        assert crowd.read("player.chosen") == robot
        assert number.input_value() == str(robot)
    crowd.page.locator("canvas.floor").click(position={"x": 2, "y": 2})
    assert crowd.read("player.chosen") is None, "beside all robots"
    click_robot(crowd, 3)
    crowd.seek(10)
    pose = fleet.frames[10].robots[3]
    assert pose
    column, row = (int(part) for part in pose.at)
    assert crowd.part("robot").inner_text().count(f"row {row}, column {column}") == 1
    number.fill("1")
    assert crowd.read("player.chosen") == 1
    number.fill("99")
    assert crowd.read("player.chosen") is None
    number.fill("")
    assert crowd.read("player.chosen") is None
    assert not crowd.part("robot").is_visible()


def test_typing_a_number_does_not_play_or_step(crowd: Shown) -> None:
    crowd.part("number").click()
    crowd.press("2", "Home", "n", "Space")
    assert crowd.read("[player.chosen, player.step, player.isPlaying]") == [2, 0, False]


def test_what_was_played_and_what_was_scrubbed_are_the_same_pictures(
    opened: Open, files: Files, track: Track, fleet: Track
) -> None:
    def tracks() -> list[Track]:
        return [track, track_of_record(run_episode("greedy", "physics", seed=12))]

    for path, prepare in (
        (files("pair", tracks), ""),
        (files("fleet", lambda: [fleet]), "player.choose(1)"),
    ):
        played = opened(path, is_held=True)
        played.read(prepare or "null")
        played.press("Space")
        played.page.clock.run_for(1456)
        played.press("Space")
        time = played.read("player.time")
        assert time > 5
        scrubbed = opened(path)
        scrubbed.read(prepare or "null")
        for step in (20, 3, 11, 0, 7):
            scrubbed.seek(step)
        scrubbed.read(f"player.seek({time!r})")
        assert scrubbed.pictures() == played.pictures()
        played.press("ArrowRight")
        step = played.read("player.step")
        scrubbed.seek(step)
        assert scrubbed.pictures() == played.pictures()


def test_reduced_motion_shows_whole_steps_only(opened: Open, files: Files, track: Track) -> None:
    page = opened(files("grid", lambda: [track]), reduced_motion="reduce", is_held=True)
    page.press("Space")
    floor = "player.panels[0].canvas.toDataURL()"
    page.page.clock.run_for(640)
    assert 0.1 < page.read("player.time") % 1 < 0.9, "it is playing, within a step"
    between = page.read(floor)
    page.press("Space")
    page.seek(page.read("player.step"))
    assert page.read(floor) == between


def test_everything_has_a_name_and_is_reached_by_tab(crowd: Shown, page: Shown) -> None:
    for each in (crowd, page):
        tree = each.page.locator("main").aria_snapshot()
        nameless = r'- (button|checkbox|combobox|img|slider|spinbutton)\b(?! ")'
        assert [line for line in tree.splitlines() if re.match(nameless, line.strip())] == []
        expected = each.read(
            """[...document.querySelectorAll("button, input, select, summary")]
              .filter(element => element.checkVisibility()).length"""
        )
        reached = each.read("document.body.focus(); globalThis.reached = new Set(); 0")
        for _ in range(expected + 3):
            each.press("Tab")
            each.read("void reached.add(document.activeElement)")
        reached = each.read("[...reached].filter(element => element !== document.body).length")
        assert reached == expected


def test_a_screen_reader_is_told_what_is_shown(page: Shown, track: Track) -> None:
    page.press("ArrowRight")
    status = page.part("status").inner_text()
    assert "step 1 of" in status
    assert track.frames[1].caption in status
    assert page.page.locator("canvas.floor").get_attribute("aria-label") == status
    assert page.part("slider").get_attribute("aria-valuetext").startswith("step 1 of")
