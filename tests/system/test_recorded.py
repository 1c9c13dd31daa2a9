"""Pictures, pages, exports and outputs are as recorded, so that no change to them goes unnoticed.

Nearly all numbers in their code are sizes, places and colours, which no other test checks. After a
change that is meant to alter them, ``python tests/system/test_recorded.py [CASE ...]`` records the
cases again. Each case has a file of compressed text in ``tests/data/recorded``. To see changes of
these files with ``git diff``, run ``git config diff.gzip.textconv "gzip -dc"``.
"""

import gzip
import json
import math
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import chdir, redirect_stdout
from dataclasses import replace
from functools import partial
from hashlib import sha256
from inspect import isclass, signature
from io import StringIO
from itertools import islice, product
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FunctionType
from typing import Any

import gymnasium
import matplotlib
import numpy as np
import pytest

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[1])]

from helpers.command_line import LEAVES, ROOT
from helpers.drawn import drawn
from helpers.fleets import fleet_episode
from helpers.kernel_digests import HOUR, lifelong, once
from helpers.mapf_problems import random_problems
from helpers.pictures import ROOM, short_episode
from helpers.player import said_by
from helpers.results_files import BAD, GOOD, Cases, fill, fleet_row, outcomes, scores_of
from helpers.rigid_bodies import EAST, NORTH, WEST, together
from matplotlib.figure import Figure
from numpy.typing import NDArray

import warehouse_core
import warehouse_physics
from agents.errors import PlanError
from agents.lab.commands import cli
from agents.lab.console.main import main
from agents.lab.datasets.recording import entries
from agents.lab.reports import figures as report_figures
from agents.lab.training.curve import learning_curve
from agents.lab.training.exams import ExamPoint
from agents.lab.trials.figure import curves_figure, scores_figure
from agents.lab.trials.interval import Interval
from agents.lab.trials.rows import row_of
from agents.mapf.cbs import ConflictTree
from agents.mapf.eecbs import ExplicitTree
from agents.mapf.lacam import LaCAM
from agents.registry import make_fleet_agent
from agents.run_episode import run_episode
from warehouse_core import (
    Episode,
    EpisodeRecorder,
    FleetEnv,
    Layout,
    OrderStream,
    WarehouseEnv,
    gymnasium_env,
    pettingzoo_env,
    record_fleet_episode,
    shelf_layout,
)
from warehouse_core.records.plans import StepPlans
from warehouse_core.render.palette import LOOK
from warehouse_core.viz.axes.heat_map import congestion_picture, heat_map
from warehouse_core.viz.figure import SceneFigure, make_figure
from warehouse_core.viz.player import player_page
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.svg import animated_svg
from warehouse_core.viz.tracks import Frame, Pose, Track, track_of_record
from warehouse_core.viz.tracks.track import DrawnHit, FleetFrame, Marks, Push, Waiting
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, RobotSpec, Stop

RECORDS = Path(__file__).parents[1] / "data/recorded"

HEAVY = RobotSpec(
    mass=120, radius=0.45, cell_size=1.4, top_speed=1.6, acceleration=2.5, motor_force=400
)

NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
LONG = re.compile(r"\d+\.\d{6,}(?:e-?\d+)?")
NAMELESS = re.compile(r" at 0x\w+")
VERSIONS = re.compile("<th scope=.row.>(Python|warehouse-lab|numpy|scipy|matplotlib)<")
"""Lines with versions."""

SCRIPTS = re.compile(
    r"<script.*?</script>|&lt;script.*?&lt;/script&gt;|(?<=sha256-)[\w+/=]+", re.DOTALL
)
"""Scripts of pages and of their frames, and the digests of these."""

DRAWN = ("text ", "path ", "figure ")
"""Words that begin a line of what Matplotlib draws."""

PIXELS, OTHER_PIXELS = 0.11, 24.0
"""Largest distances in pixels from the recorded places, with the same version of Matplotlib and
with others, whose letters differ."""

Lines = Iterator[str]


def version() -> Lines:
    yield f"Matplotlib {matplotlib.__version__}"


def of_tracks(*tracks: Track) -> Lines:
    """Yield the drawings of tracks at their start, middle and end."""
    scene = Scene(tracks, make_figure)
    for moment in (0, len(scene) // 2, len(scene) - 1):
        scene.show(moment)
        yield from drawn(scene.root)
    yield from animated_svg(tracks).replace("><", ">\n<").splitlines()
    yield from of_page(player_page(tracks))


def of_page(page: str) -> Lines:
    """Yield the data of the replay in a page, if any, and the elements of the page."""
    said = said_by(page) if 'id="data"' in page else {}
    for name, value in said.items():
        for each in value if isinstance(value, list) else [value]:
            yield f"{name} {json.dumps(each)}"
    yield from SCRIPTS.sub("", page).splitlines()


def of_command(words: str) -> Lines:
    """Yield the output of a command, its figures and the files that it writes."""
    printed, figures, before = StringIO(), [], set(Path().iterdir())

    def keep(figure: Figure, target: Any, *_: object, **__: object) -> None:
        figures.extend(drawn(figure))
        if isinstance(target, Path):
            target.touch()

    with pytest.MonkeyPatch.context() as patch, redirect_stdout(printed):
        patch.setenv("COLUMNS", "80")
        patch.setattr(Figure, "savefig", keep)
        patch.setattr(SceneFigure, "savefig", keep)
        with pytest.raises(SystemExit):
            main(cli.app, words.split())
    yield from printed.getvalue().splitlines()
    yield from figures
    for file in sorted(set(Path().iterdir()) - before):
        if file.suffix in (".csv", ".json", ".svg"):
            yield from file.read_text().replace("><", ">\n<").splitlines()
        if file.suffix == ".html":
            yield from of_page(file.read_text())


def of_record(episode: Episode) -> Lines:
    """Yield the arrays of an episode, thinned out, and its messages for other programs."""
    episode.save("x.npz")
    with np.load("x.npz") as arrays:
        for name, values in arrays.items():
            few = values[:: 1 + len(values) // 40] if values.ndim else values
            text = bytes(values).decode() if values.dtype == np.uint8 else str(few.tolist())
            yield f"{name} {values.dtype} {values.shape} {text}"
    for time, topic, message in entries(episode):
        yield f"{time} {topic} {json.dumps(message)}"


def options() -> Lines:
    """Yield the options of all commands with their defaults and limits."""
    for name, command in LEAVES.items():
        for each in command.params:
            reader = vars(each.type_descriptor.parameter_info).get("parser")
            check = getattr(reader, "check", None)
            limits = vars(check) if hasattr(check, "__dict__") else check
            kept = (each.default, each.min, each.max, each.multiple, each.required)
            yield f"{name} {each.opts} {each.secondary_opts} {kept} {NAMELESS.sub('', str(limits))}"


def rows() -> Lines:
    """Yield the rows that a sweep stores for episodes, most of which fail."""
    for agent in ("random", "reflex", "greedy:escape_steps=0"):
        for seed in range(4):
            yield str(row_of(run_episode(agent, "grid", seed=seed)))


def interface() -> Lines:
    """Yield the defaults and the metadata of public functions and classes."""
    packages = warehouse_core, warehouse_physics, gymnasium_env, pettingzoo_env
    for each in (getattr(package, name) for package in packages for name in package.__all__):
        if isinstance(each, FunctionType) or (isclass(each) and "__init__" in vars(each)):
            parameters = signature(each).parameters.values()
            defaults = {one.name: one.default for one in parameters if one.default is not one.empty}
            yield f"{each.__name__} {defaults} {getattr(each, 'metadata', None)}"


def lone() -> Lines:
    yield from of_tracks(track_of_record(short_episode()))


def seen() -> Lines:
    episode = run_episode("greedy", "grid", seed=12)
    yield from of_tracks(
        replace(track_of_record(episode), view_radius=2, slippery=((1, 2), (3, 4)))
    )


def bodies() -> Lines:
    env = WarehouseEnv(ROOM, (1, 2), battery=50, backend=RigidBodyMotion(HEAVY))
    recorder = EpisodeRecorder(env, seed=1, agent="by hand")
    for action in ("N", "W", "PICK", "E", "E"):
        recorder.step(action)
    yield from of_tracks(track_of_record(recorder.episode))
    yield from of_record(recorder.episode)


def fleet() -> Lines:
    episode = fleet_episode(max_steps=36, orders=OrderStream(0.5, due=(8, 20)), people=1)
    yield from of_tracks(track_of_record(episode))
    yield from of_record(episode)


def driven() -> Lines:
    """Yield a fleet of heavy robots that drive through large cells."""
    layout = shelf_layout(2, 2, aisle=2, pickups=2, dropoffs=2)
    env = FleetEnv(layout, 3, orders=0.3, max_steps=6, backend=DrivingMotion(HEAVY))
    episode = record_fleet_episode(env, make_fleet_agent("pibt", "nearest", 1, layout, 3), seed=2)
    yield from of_tracks(track_of_record(episode))
    yield from of_record(episode)


def slipping() -> Lines:
    """Yield records of robots with slippery floors, weak motors and a stop."""
    layout = shelf_layout(2, 2, aisle=2, pickups=2, dropoffs=2)
    icy = frozenset((row, col) for row in range(layout.height) for col in range(0, layout.width, 2))
    shocks = Disturbances(0.2, icy, 0.012, 0.8, 0.5)
    driving = DrivingMotion(HEAVY, replace(shocks, stops=(Stop(1, 3.0, 4.0),)), period=0.3)
    for motion in (driving, RigidBodyMotion(HEAVY, shocks)):
        env = FleetEnv(layout, 4, orders=0.3, max_steps=8, people=1, backend=motion)
        agent = make_fleet_agent("windowed", "urgent", 1, layout, 4)
        yield from islice(of_record(record_fleet_episode(env, agent, seed=2)), 40)
    rows = ["######", "......", "##.###"]  # four robots block each other here
    cells, moves = [(2, 2), (1, 3), (1, 5), (1, 2)], [NORTH, EAST, WEST, EAST]
    spec = RobotSpec(payload_mass=90, motor_force=108)
    for found in together(Layout(rows), cells, moves, spec, [False, True, True, True]):
        yield f"{found.cell} {found.seconds} {found.joules} {found.contacts}"


def planners() -> Lines:
    """Yield digests of runs and plans, and the trees of searches that are optimal or bounded."""
    for name, cells in (*islice(lifelong(), 20), *islice(once(), 4)):
        numbers = np.ascontiguousarray(cells, np.int64)
        yield f"{name} {cells.shape} {sha256(numbers.tobytes()).hexdigest()[:16]}"
    for problem in random_problems(12, seed=3, max_size=6, max_robots=6):
        star = LaCAM(problem, 1)
        for rounds in (20, 100, 400):
            star.search(np.inf, rounds)
            plan = star.plan()
            yield f"lacam-star {star.is_done} {plan.costs.sum() if plan else None}"
        for tree in (ConflictTree(problem), ExplicitTree(problem, 1.3)):
            try:
                plan = tree.solve(HOUR)
            except PlanError as error:
                yield str(error)
            else:
                yield f"{tree.nodes} nodes {plan.costs} {plan.cells.tolist()}"


def signs() -> Lines:
    """Yield a large fleet with all signs, on a small and on a large floor."""
    for rows in (("P.....D#",) + ("........",) * 4, ("P.....D#" + "." * 52,) + ("." * 60,) * 40):
        yield from of_tracks(track_with_all_signs(rows))


def track_with_all_signs(rows: tuple[str, ...]) -> Track:
    poses = tuple(Pose((n % 8 + 0.5, n // 8 + 0.5), n / 2, n % 3 == 0) for n in range(14))
    people = Pose((6.5, 4.5), None, False), Pose((7.5, 4.5), 1.0, False)
    plans = StepPlans({0: [(1, 1), (1, 2)]}, {1: [(1, 2), (2, 2), (2, 3)]}, {2: 3})
    frames = []
    for step in range(4):
        items = tuple(n % 4 if pose.loaded else None for n, pose in enumerate(poses))
        battery = tuple(min(n * step / 10, 1.0) for n in range(14))
        waiting = tuple(Waiting((n + 0.5, 3.5), n + step, n) for n in range(4))
        fleet = FleetFrame(waiting, items, battery, plans)
        route = tuple((n + 0.5, 1.5) for n in range(step))
        hits = (DrawnHit((4.0, 2.5), "12 N·s"),) if step % 2 else ()
        frames.append(
            Frame(rows, poses + people, float(step), f"at {step}", hits, fleet=fleet, route=route)
        )
    names = "released", "delivered", "battery_mean", "battery_lowest", "joules"
    return Track(
        frames, {name: [0.1, 0.4, 0.5, 0.9] for name in names}, title="All", ending="the end",
        lateness=[(1, 1), (2, -4), (3, 0), (3, 9)],
        held_up=[(1, (0, 2)), (2, (3, 7))], slippery=((2, 5),),
    )  # fmt: skip


def details() -> Lines:
    """Yield small tracks with what no episode has, such as skid marks, ghosts and marks."""
    floor = ("P....D", ".##...", "..C...", "......")
    pushes = (
        None, Push((1.0, 0.0), (60.0, 0.0)), Push((0.5, 0.0), (-60.0, 0.0), skids=True),
        Push((0.0, 0.0), (0.0, 0.0)), Push((90.0, 0.0), (0.0, 2.0)), Push((0.0, 2.0), (9.0, 9.0)),
    )  # fmt: skip
    bodies = [Pose((n + 0.5, 3.5), n / 2, n > 2, push) for n, push in enumerate(pushes)]
    frames = [Frame(floor, (pose,), float(n), clock=float(n)) for n, pose in enumerate(bodies)]
    for drive in ("differential", "tracked"):
        body = Track(frames, {}, is_continuous=True, drive=drive, slippery=((3, 1), (3, 2)))
        body.ghost = [(step + 0.5, 0.5) for step in range(len(frames))]
        yield from of_tracks(body)
    hops = [*(Pose((n % 2 + 0.5, 0.5), None, n > 3) for n in range(9)), None]
    hits = [DrawnHit(at, said) for at, said in (((0.0, 2.0), "wall"), ((6.0, 0.0), "12 N·s"))]
    frames = [
        Frame(floor, (pose,), float(n), hits=(hits[n % 2], DrawnHit((3.0, 3.0), "")))
        for n, pose in enumerate(hops)
    ]
    levels = [40.0, 39.0, 20.0, 8.0, 7.9, 7.0, 1.0, 0.0, math.nan, 45.0]
    yield from of_tracks(Track(frames, {"battery": levels}, full_battery=40.0, motor_strength=0.5))
    cells, colors = [(0, 0), (0, 1), (0, 0), (3, 3)], [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)]
    names, ends = ["expanded", "frontier"], ((0, 0), (2, 5))
    marks = Marks([0, 1, 2, 3], cells, [0, 0, 1, 1], colors, names, ends)
    frames = [Frame(floor, (), float(n), clock=float(n)) for n in range(3)]
    frames[2].route = (0.5, 0.5), (5.5, 2.5)
    yield from of_tracks(Track(frames, {}, marks=marks, title="Search"))
    few = LOOK["battery"]["few"]
    plans = StepPlans({0: [(0, 0), (0, 1)]}, {0: [(0, 1), (1, 1), (1, 1)]}, {1: 0})
    for robots, width in ((few, 8), (few + 1, 8), (few + 1, 24), (few + 1, 61)):
        poses = tuple(Pose((n % width + 0.5, n // width + 0.5), 0.0, False) for n in range(robots))
        battery = tuple((0.0, 0.24, 0.25, 0.9)[n % 4] for n in range(robots))
        fleet = FleetFrame((), (None,) * robots, battery, plans)
        yield from of_tracks(Track([Frame(("." * width,) * 4, poses, 0.0, fleet=fleet)], {}))


def pair() -> Lines:
    yield from of_tracks(
        track_of_record(short_episode()), track_of_record(run_episode("greedy", "grid", seed=12))
    )


def maps() -> Lines:
    episodes = {
        name: fleet_episode(seed=seed, max_steps=30) for seed, name in enumerate(("one", "other"))
    }
    yield from drawn(congestion_picture(episodes, "Where", make_figure))
    counts = np.arange(20).reshape(4, 5)
    panels = {"first": counts, "second": counts[::-1]}
    yield from drawn(heat_map(ROOM.rows, panels, with_stations=True))


def charts() -> Lines:
    """Yield the figures that compare agents, and the figures of training and of planners."""
    slow = GOOD._replace(steps=30)
    one, other = scores_of([GOOD, slow] * 15), scores_of([GOOD] * 20 + [BAD] * 10)
    yield from drawn(scores_figure({"small": {"one": one}, "large": {"one": other}}))
    points = [ExamPoint(60_000 * (n + 1), each) for n, each in enumerate((other, one))]
    yield from drawn(learning_curve("PPO", "A title", points, one))
    curve = {4: Interval(1.0, 0.8, 1.2), 8: Interval(2.5, 2.0, 3.0)}
    yield from drawn(curves_figure({"pibt": curve, "most": curve}, "A title", "rate", "most"))


def reports() -> Lines:
    """Yield the figures and pages of reports, and their tables for other programs."""
    good, bad = outcomes("dddddddddw"), outcomes("ddoo", 10, 30)
    equal = outcomes("wddddddddd")
    odd = [GOOD._replace(seed=90), BAD._replace(seed=91)]
    shifts = [fleet_row(0), fleet_row(1, per_hour=90.0)]
    cases: list[Cases] = [
        [
            ({"escape": escape, "view_radius": radius}, good + bad[radius + escape :])
            for escape in (True, False)
            for radius in (1, 2)
        ],
        [({"backend": "grid"}, good + odd), ({"backend": "physics"}, equal + odd)],
        [({"robots": robots}, [*shifts, fleet_row(2, joules=robots)]) for robots in (2, 4)],
    ]
    for number, each in enumerate(cases):
        figures: list[str] = []

        def keep(figure: Figure, figures: list[str] = figures) -> bytes:
            figures.extend(drawn(figure))
            return b"<svg/>"

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(report_figures, "svg_of", keep)
            fill(Path(f"{number}.sqlite"), each)
            yield from of_command(f"report {number}.sqlite --no-replays -o {number}.html")
        yield from figures
        yield from of_command(f"export {number}.sqlite {number}.csv")


def episodes() -> Lines:
    """Yield whole episodes of the agents, on the grid and with bodies."""
    agents = "greedy", "model", "utility", "exploring", "astar", "random"
    for name, backend, seed in product(agents, ("grid", "physics"), (3, 12)):
        episode = run_episode(name, backend, seed=seed, max_steps=60)
        sums = episode.total_reward, episode.seconds, episode.joules
        yield f"{name} {backend} {seed} {episode.outcome} {' '.join(episode.actions)} {sums}"


def shifts() -> Lines:
    """Yield shifts of fleets with compass moves and with headings, for each planner."""
    layout = shelf_layout(2, 3, aisle=2, pickups=3, dropoffs=2, chargers=2)
    turning = "auto", "windowed", "windowed:guidance=learned", "circulation"
    compass = *turning, "pibt", "pibt:guidance=lanes"
    for moves, name in (*product(["compass"], compass), *product(["turn"], turning)):
        agent = make_fleet_agent(name, "urgent", 1, layout, 8)
        env = FleetEnv(
            layout, 8, orders=OrderStream(0.5, due=(20, 60)), max_steps=60, battery=50,
            people=1, moves=moves, dispatch=False, seed=5,
        )  # fmt: skip
        episode = record_fleet_episode(env, agent, seed=5)
        digest = sha256(repr(episode.actions).encode()).hexdigest()[:16]
        yield f"{moves} {name} {episode.outcome} {episode.total_reward} {digest}"


def pixels() -> Lines:
    """Yield the mean colours of small blocks in pictures that are made of pixels."""
    scenes = {
        "lone": env_pixels("Warehouse-v0", view_radius=2),
        "bodies": env_pixels("Warehouse-v0", backend="physics"),
        "large": env_pixels("Warehouse-v0", layout=shelf_layout(4, 6, aisle=2)),
        "fleet": fleet_pixels(),
        "headings": fleet_pixels(moves="turn"),
        "crowd": fleet_pixels(robots=12, people=4),
    }
    for name, picture in scenes.items():
        height, width = (side - side % 4 for side in picture.shape[:2])
        blocks = picture[:height, :width].reshape(height // 4, 4, width // 4, 4, 3)
        yield f"{name} {picture.shape} {picture.dtype}"
        for row in blocks.mean(axis=(1, 3)).round().astype(int)[:: 1 + height // 200]:
            yield f"figure {row.ravel().tolist()}"


def env_pixels(name: str, **settings: Any) -> NDArray[np.uint8]:
    env = gymnasium.make(
        f"warehouse_core.gymnasium_env:{name}", render_mode="rgb_array", **settings
    )
    env.reset(seed=3)
    for action in (0, 1, 1, 2):
        env.step(action)
    picture: Any = env.render()
    env.close()
    return np.asarray(picture)


def fleet_pixels(robots: int = 4, **settings: Any) -> NDArray[np.uint8]:
    layout = shelf_layout(2, 2, aisle=2, pickups=2, dropoffs=2, chargers=2)
    env = pettingzoo_env.parallel_env(
        layout=layout, robots=robots, orders=0.5, render_mode="rgb_array", **settings
    )
    env.reset(seed=3)
    for action in (0, 1, 2):
        env.step(dict.fromkeys(env.agents, action))
    return np.asarray(env.render())


def grades() -> Lines:
    """Yield the printed grades and the feedback pages of good and of bad agents."""
    Path("wrong.py").write_text(WRONG)
    yield from of_command("grade greedy --save good.html")
    yield from of_command("grade wrong.py --trust --save wrong.html")
    solution = ROOT / "agents/handbook/exercises/solutions/exercise-01.py"
    yield from of_command(f"grade {solution} --rubric exercise-01 --trust --save one.html")


WRONG = """
class Wrong:
    def reset(self):
        self.steps = 0

    def act(self, observation):
        self.steps += 1
        return "N" if self.steps < 30 else 1 / 0
"""
"""An agent that drives north and then fails."""


def sweeps() -> Lines:
    """Yield the output of a sweep and its table for other programs, without their version."""
    Path("plan.toml").write_text(PLAN)
    yield from of_command("sweep plan.toml -o a.sqlite -j 1")
    fleets = "--set robots=2,3 --set layout=depot --set max_steps=30"
    yield from of_command(f"sweep {fleets} -n 2 -o b.sqlite -j 1")
    for name in "ab":
        for line in of_command(f"export {name}.sqlite {name}.csv"):
            yield PROGRAM.sub("", line)


PLAN = """
episodes = 4
seed = 3

[settings]
agent = ["greedy", "reflex"]
battery = [20, 60]
"""

PROGRAM = re.compile(r',"?warehouse-lab.*')
"""Last column of a table of episodes, which contains versions."""


KINDS = (
    version, options, interface, rows, planners, lone, seen, bodies, fleet, driven,
    slipping, signs, details, pair, maps, charts, reports, episodes, shifts, pixels, grades, sweeps,
)  # fmt: skip

COMMANDS = (
    "compare search --save x.svg",
    "run --agent exploring --seed 3 --max-steps 6 --save x.svg",
    "demo bump --save x.svg",
    "demo slip --save x.svg",
    "demo wheels --save x.svg",
    "race --worlds grid,physics,icy --max-steps 24 --save x.html",
    "compare backends --seed 12 --save x.html",
    "race --agent random --agent greedy --seed 3 --max-steps 5 --save x.html",
    "run --seed 4 --no-show",
    "fleet --seed 4 --no-show --max-steps 30 --robots 4 --save x.csv",
    "compare agents --seed 1 -n 2 --max-steps 40 --save x.svg",
    "layout",
    "layout shelves:",
    "layout random:seed=1",
    "layout warehouse:3-4-5-2-1",
)

CASES: dict[str, Callable[[], Lines]] = {
    **{each.__name__: each for each in KINDS},
    **{words: partial(of_command, words) for words in COMMANDS},
}


def lines_of(case: str) -> list[str]:
    with TemporaryDirectory() as folder, chdir(folder):
        lines = [line.replace(folder, "").replace(str(ROOT), "") for line in CASES[case]()]
    return [
        LONG.sub(lambda number: f"{float(number[0]):.6g}", line)
        for line in lines
        if not VERSIONS.search(line)
    ]


def file_of(case: str) -> Path:
    return RECORDS / f"{re.sub('[^a-z0-9]+', '-', case.lower())}.txt.gz"


def recorded(case: str) -> list[str]:
    return gzip.decompress(file_of(case).read_bytes()).decode().splitlines()


@pytest.mark.parametrize("case", [case for case in CASES if case != "version"])
def test_it_is_as_recorded(case: str) -> None:
    found, expected = lines_of(case), recorded(case)
    if found == expected:
        return
    words, expected_words = (NUMBER.sub("0", "\n".join(lines)) for lines in (found, expected))
    assert words.splitlines() == expected_words.splitlines()
    pixels = PIXELS if recorded("version") == [*version()] else OTHER_PIXELS
    for line, other in zip(found, expected, strict=True):
        numbers, others = ([*map(float, NUMBER.findall(each))] for each in (line, other))
        error = pixels if line.startswith(DRAWN) else 1e-5
        assert numbers == pytest.approx(others, 1e-5, error), f"{line}\nrecorded: {other}"


def test_each_record_has_its_case() -> None:
    assert {*RECORDS.iterdir()} == {*map(file_of, CASES)}


if __name__ == "__main__":
    for case in sys.argv[1:] or CASES:
        text = "".join(f"{line}\n" for line in lines_of(case))
        file_of(case).write_bytes(gzip.compress(text.encode(), mtime=0))
