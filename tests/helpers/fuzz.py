"""Changed inputs of every file format, and how reading them ends."""

import io
import random
import re
import sqlite3
from collections.abc import Callable
from contextlib import closing, suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

from agents.lab.datasets.table import columns_of, lines_of
from agents.lab.experiments.case import is_fleet, make_case, run_task
from agents.lab.experiments.plan import parse_flags, read_plan_file, spread
from agents.lab.experiments.store import Store
from agents.lab.grading.archives import members_of, unpack
from agents.lab.grading.grades import load_days, load_grades, save_grades
from agents.lab.grading.rubric import MINI_LAB, load_rubric
from agents.lab.reports.answers import answers
from agents.lab.reports.examples import find_examples
from agents.lab.reports.results import FLEETS, LONE, Experiment
from agents.learning.policy_network import PolicyNetwork
from agents.learning.q_learning import QTable
from agents.learning.q_table import load_agent, save_table
from agents.registry import make_agent
from agents.warehouse_agent_greedy import GreedyAgent
from helpers.fleets import fleet_episode
from helpers.results_files import fleet_row, row
from helpers.submissions import RUBRIC
from warehouse_core import DEFAULT_LAYOUT, Episode, Layout, WarehouseEnv, record_episode
from warehouse_core.errors import WarehouseError
from warehouse_core.fleet import FleetEnv
from warehouse_core.orders import load_orders
from warehouse_core.orders.files import COLUMNS as ORDER_COLUMNS
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.wording import printable
from warehouse_core.world.map_files import load_map, save_map
from warehouse_core.world.named_layouts import as_layout
from warehouse_core.world.scenarios import check_scenarios, load_scenarios

MAX_INPUT = 2 * 2**20
"""Largest size of a changed input in bytes; ``.npz`` files are compressed."""

NUMBER = re.compile(rb"\d+")

DOCUMENTED = (WarehouseError, OSError)

TOKENS = (
    b"\n", b"\r\n", b"\t", b" ", b"\x00", b"\x1b[2J", b"\xef\xbb\xbf", b"\xff", b"\xed\xa0\x80",
    b"#", b".", b"@", b"P", b"D", b"=", b",", b":", b"(", b"[", b"{", b"]", b"}", b"'", b'"', b"-",
    b"\\", b"a.", b"[[", b"'''", "\u0663".encode(), "\u202e".encode(), b"null", b"true", b"NaN",
    b"C", b"[],", b"{},", b'"a":[],', b"1e9,", b"a,", b"\n[a.b]\n", b"\na = 1\n", b"[[a]]\n", b"0.",
)  # fmt: skip

REPEATS = (1,) * 90 + (2, 30, 1000) * 30 + (200_000,)
"""Numbers of copies that a change inserts. Large numbers are rare, because reading takes longer."""

NUMBERS = (
    b"0", b"-1", b"1", b"-0", b"1.5", b"1e308", b"1e400", b"-1e308", b"1e-320", b"nan", b"inf",
    b"2147483648", b"9223372036854775808", b"16000000", b"100001", b"9" * 20, b"9" * 900,
    b"9" * 5000, b"0x10", b"1_0", b"", b"Infinity", "\u0663".encode(),
)  # fmt: skip

VALUES: tuple[Any, ...] = (
    0, 1, -1, 2, 2**31 - 1, -(2**31), 2**63 - 1, -(2**63), 1e308, -1e308, 1e-320, np.nan, np.inf,
)  # fmt: skip

DTYPES = ("<i4", "<i8", ">i4", "<f4", "<f8", "|b1", "|u1", "<U3", "|S9", "<c16", "<M8[s]", "|V4")


Change = Callable[[bytes, tuple[bytes, ...], random.Random], bytes]
"""Function that changes an input. It also gets all good inputs and the random numbers."""


class Format(NamedTuple):
    """A format: good inputs, a function that reads and uses one, and changes of inputs."""

    good: tuple[bytes, ...]
    read: Callable[[Path], object]
    changes: tuple[Change, ...]


class Report(NamedTuple):
    """How many inputs were accepted or refused, and the most processor seconds for one input."""

    inputs: int
    accepted: int
    refused: int
    worst_seconds: float


def fuzz(name: str, inputs: int, seed: int) -> Report:
    """Read changed inputs of a format, and check that they raise documented errors only."""
    form, stream, accepted = formats()[name], random.Random(seed), 0
    worst_seconds = 0.0
    with TemporaryDirectory() as folder:
        path = Path(folder, "input")
        for number in range(inputs):
            data = stream.choice(form.good) if number else form.good[0]
            if number:
                data = stream.choice(form.changes)(data, form.good, stream)
            for each in Path(folder).iterdir():
                each.unlink()
            path.write_bytes(data)
            start = process_time()
            try:
                form.read(path)
                accepted += 1
            except DOCUMENTED:
                assert number, f"{name}: a good input is refused"
            except Exception as error:
                raise AssertionError(f"{name}, seed {seed}, input {number}: {error!r}") from error
            worst_seconds = max(worst_seconds, process_time() - start)
    return Report(inputs, accepted, inputs - accepted, worst_seconds)


def change_bytes(data: bytes, others: tuple[bytes, ...], stream: random.Random) -> bytes:
    """Flip, insert, delete, repeat and splice bytes, and replace numbers."""
    for _ in range(stream.choice((1, 1, 2, 3, 5))):
        place = stream.randrange(len(data) + 1)
        end = min(len(data), place + stream.choice((1, 1, 2, 8, 64)))
        many = stream.choice(REPEATS)
        kind = stream.randrange(6)
        if kind == 0 and place < len(data):
            data = data[:place] + bytes([stream.randrange(256)]) + data[place + 1 :]
        elif kind == 1:
            data = data[:place] + stream.choice(TOKENS) * many + data[place:]
        elif kind == 2:
            data = data[:place] + data[end:]
        elif kind == 3:
            data = data[:place] + data[place:end] * many + data[end:]
        elif kind == 4:
            other = stream.choice(others)
            data = data[:place] + other[stream.randrange(len(other) + 1) :]
        elif found := NUMBER.search(data, place) or NUMBER.search(data):
            data = data[: found.start()] + stream.choice(NUMBERS) + data[found.end() :]
        data = data[:MAX_INPUT]
    return data


def change_arrays(data: bytes, others: tuple[bytes, ...], stream: random.Random) -> bytes:
    """Change values, shapes and types of the arrays of a ``.npz`` file, and their names."""
    with np.load(io.BytesIO(data)) as file:
        arrays = dict(file)
    for _ in range(stream.choice((1, 1, 2, 3))):
        name = stream.choice(list(arrays))
        array, kind = arrays[name], stream.randrange(8)
        if name == "header" and kind < 6:
            text = change_bytes(array.tobytes(), (array.tobytes(),), stream)
            arrays[name] = np.frombuffer(text, np.uint8)
        elif kind < 3 and array.size:
            arrays[name] = array.copy()
            with np.errstate(all="ignore"):
                value = np.array(stream.choice(VALUES)).astype(array.dtype)
            arrays[name].flat[stream.randrange(array.size)] = value
        elif kind == 3:
            arrays[name] = array[: stream.randrange(len(array) + 1)]
        elif kind == 4:
            arrays[name] = np.repeat(array, stream.choice((2, 3, 1000)), 0)[:200_000]
        elif kind == 5:
            arrays[name] = np.zeros(array.shape, stream.choice(DTYPES))
        elif kind == 6:
            arrays[name] = array.reshape((*array.shape, 1) if stream.random() < 0.5 else -1)
        else:
            arrays[stream.choice([*arrays, "../x", "header.npy", ""])] = arrays.pop(name)
    changed = io.BytesIO()
    (np.savez if stream.random() < 0.5 else np.savez_compressed)(changed, **arrays)
    return changed.getvalue()


def change_database(data: bytes, _: tuple[bytes, ...], stream: random.Random) -> bytes:
    """Change values of the rows of a database, their cases and their texts."""
    with closing(sqlite3.connect(":memory:")) as database:
        database.deserialize(data)
        tables = ("cases", "episodes")
        for _ in range(stream.choice((1, 1, 2, 3))):
            table = stream.choice(tables)
            columns = [name for _, name, *_ in database.execute(f"PRAGMA table_info({table})")]
            column, value = stream.choice(columns), stream.choice((*VALUES, None, "x", b"x"))
            if column == "settings":
                [text] = stream.choice(database.execute("SELECT settings FROM cases").fetchall())
                value = change_bytes(text.encode(), (text.encode(),), stream).decode(
                    errors="replace"
                )
            with suppress(sqlite3.Error, OverflowError):  # the value violates a constraint
                database.execute(
                    f"UPDATE {table} SET {column} = ? WHERE {columns[0]} = ?",
                    (value, stream.randint(1, 4)),
                )
        database.commit()
        changed = database.serialize()
        return changed[:18] + b"\2\2" + changed[20:]


def change_places(data: bytes, _: tuple[bytes, ...], stream: random.Random) -> bytes:
    """Overwrite bytes, half of them in the first page, and sometimes cut off the end."""
    content = bytearray(data)
    for _ in range(stream.randint(1, 12)):
        end = len(content) if stream.random() < 0.5 else min(4096, len(content))
        content[stream.randrange(end)] = stream.choice((0, 1, 34, 127, 128, 255, *range(256)))
    if stream.random() < 0.05:
        del content[stream.randrange(len(content)) :]
    return bytes(content)


TEXT, NPZ = (change_bytes,), (change_bytes, *[change_arrays] * 4)


@cache
def formats() -> dict[str, Format]:
    """Return every format, by name."""
    with TemporaryDirectory() as folder:
        saved = [Path(folder, f"{number}.npz") for number in range(6)]
        for path, backend in zip(saved, ("grid", "physics"), strict=False):
            env = WarehouseEnv(
                DEFAULT_LAYOUT.with_chargers([(1, 1), (5, 10)]), max_steps=12, backend=backend
            )
            record_episode(env, GreedyAgent(0), seed=3).save(path)
        table = QTable({((1, 1), (1, 3), False): [0.5] * 7, ((2, 1), (5, 6), True): [1.0] * 7})
        save_table(table, DEFAULT_LAYOUT, saved[2])
        stream = np.random.default_rng(0)
        for path, radius in zip(saved[3:5], (0, 1), strict=True):
            _network(stream, radius).save(path)
        save_map(DEFAULT_LAYOUT, saved[5])
        grid, physics, q_table, small, large, octile = (path.read_bytes() for path in saved)
        for path, backend in zip(saved, ("grid", "physics"), strict=False):
            fleet_episode(backend=backend, max_steps=12).save(path)
        fleet, bodies = (path.read_bytes() for path in saved[:2])
    plan = (
        b'episodes = 200\nseed = 0\n[settings]\nescape = [true, false]\nagent = "greedy"\n'
        b"battery = { from = 20, to = 200, step = 20 }\n[robot]\nmass = [50, 70.5]\n"
    )
    tiles = str(DEFAULT_LAYOUT).encode()
    scenario = b"version 1\n0\tmaps/hall.map\t12\t7\t1\t1\t3\t1\t2.0\n5 m.map 12 7 3 3 4 3 1e0\n"
    flags = (b"battery=20:200:20", b"escape=on,off", b"agent=greedy, ppo:a.npz", b"size=7x12",
             b"density=0.1,0.25", b"robot.mass=50,60", b"stations=kept")  # fmt: skip
    names = (b"greedy:memory=20,escape_steps=0", b"random", b"ppo:a.npz", b"astar:weight=2.5",
             b"mine.py:Class:a='b',c=(1, [2, {3: None}])", b"no.module:Class")  # fmt: skip
    head = ",".join(ORDER_COLUMNS).encode()
    orders = (head + b"\n0,20,1,3,5,6,\n 0, 9,1,3,5,6,1\n4,40,1,3,5,6,0\n", head + b"\r\n\r\n")
    grades = b"submission,points,of,moves,failure,code,rubric\n"
    grades += b'ann,27.5,30,10,,c0,r0\n"b, ob",0,30,0,"it said ""no""\n twice",c1,r0\n'
    return {
        "layout": Format((tiles, b"\xef\xbb\xbf  #P\r\n  CD\r\n"), _read_layout, TEXT),
        "map": Format((octile, b"type octile\nwidth 2\nheight 1\nmap\nGT\n"), load_map, TEXT),
        "scen": Format((scenario,),
                       lambda path: check_scenarios(DEFAULT_LAYOUT, load_scenarios(path)), TEXT),
        "orders": Format(orders, _read_orders, TEXT),
        "episode": Format((grid, physics), _read_episode, NPZ),
        "fleet": Format((fleet, bodies), _read_episode, NPZ),
        "q-table": Format((q_table,), load_agent, NPZ),
        "ppo": Format((small, large), PolicyNetwork.load, NPZ),
        "plan": Format((plan, b"[settings]\nlayout = ['a b.txt', \"\"\"c\n\"\"\"]\n"), _read_plan,
                       TEXT),
        "flags": Format(flags, _read_flags, TEXT),
        "names": Format(names, lambda path: make_agent(_text(path), seed=1), TEXT),
        "given layout": Format((tiles, b"trap", b"a/b.map", b"P.D"),
                               lambda path: as_layout(_text(path)), TEXT),
        "rubric": Format((MINI_LAB.read_bytes(), RUBRIC.encode()), load_rubric, TEXT),
        "grades": Format((grades,), _read_grades, TEXT),
        "late": Format((b"submission,days\nann.py,2\n\"b, ob\",0\n",), load_days, TEXT),
        "archive": Format((_archive(),), _read_archive, (change_places,)),
        "results": Format((_results(),), _read_results, (change_places, change_database)),
    }  # fmt: skip


CASES = [make_case({"battery": battery}) for battery in (20, 60)]
CASES.append(make_case({"robots": 2, "max_steps": 30, "order_rate": 0.5}))
CASES.append(make_case({"layout": "random", "backend": "physics", "robot.mass": 70.0}))


def _results() -> bytes:
    """Return a file of results, of lone robots and of fleets."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "r.sqlite")
        with Store(path) as store:
            for case in CASES:
                store.add(store.case_ids([case])[0], run_task(case, range(3)).rows, "a program")
        return path.read_bytes()


def _network(stream: np.random.Generator, radius: int) -> PolicyNetwork:
    from agents.learning.policy_network import input_size
    from helpers.networks import layers_of

    return PolicyNetwork(radius, layers_of(input_size(radius), 8, 6, 7, stream=stream))


def _read_layout(path: Path) -> None:
    layout = Layout.load(path)
    assert Layout.from_text(str(layout)) == layout


def _read_episode(path: Path) -> None:
    """Read an episode, write it again, and prepare its replay."""
    episode = Episode.load(path)
    episode.save(path)
    assert Episode.load(path) == episode
    assert repr(episode)
    diagnose(episode)
    track_of_record(episode)


def _read_orders(path: Path) -> None:
    if orders := load_orders(path):
        with closing(FleetEnv(DEFAULT_LAYOUT, 2, orders=orders, max_steps=20)) as env:
            env.reset(seed=1)


def _archive() -> bytes:
    """Return an archive with files in folders, one of them compressed."""
    file = io.BytesIO()
    with ZipFile(file, "w") as archive:
        archive.writestr("src/agent.py", "class Agent:\n" * 20, ZIP_DEFLATED)
        archive.writestr("src/notes.txt", "notes")
        archive.mkdir("empty")
    return file.getvalue()


def _read_archive(path: Path) -> None:
    with TemporaryDirectory() as folder:
        unpack(path, Path(folder))
        found = {file for file in Path(folder).rglob("*") if file.is_file()}
        assert found == {Path(folder, name) for name in members_of(path)}


def _read_grades(path: Path) -> None:
    rows = load_grades(path)
    columns = dict.fromkeys(column for row in rows.values() for column in row)
    save_grades(path, list(columns), rows)
    on_one_line = {
        name: {column: _on_one_line(value) for column, value in row.items()}
        for name, row in rows.items()
    }
    assert load_grades(path) == on_one_line


def _on_one_line(value: Any) -> Any:
    """Return a value as a table keeps it: without line breaks and outer blanks."""
    return printable(value).strip() if isinstance(value, str) else value


def _read_results(path: Path) -> None:
    """Read results for a report and an export, and resume them like a sweep."""
    with Store(path, read_only=True) as store:
        for kind in (LONE, FLEETS):
            experiment = Experiment(store, kind)
            if experiment.cases:
                answers(experiment)
                if kind is LONE:
                    find_examples(experiment)
        for _ in lines_of(store, columns_of(store)):
            pass
    with Store(path) as store:
        for number, case in zip(store.case_ids(CASES), CASES, strict=True):
            store.seeds_done(number, range(100))
            store.add(number, [fleet_row(99) if is_fleet(case) else row(99)], "a program")


def _read_plan(path: Path) -> None:
    for name, choice in read_plan_file(path).choices.items():
        spread(name, choice)


def _read_flags(path: Path) -> None:
    for name, choice in parse_flags([_text(path)]).items():
        spread(name, choice)


def _text(path: Path) -> str:
    """Return text as the command line gives it, lone surrogates included."""
    return path.read_bytes().decode("utf-8", "surrogateescape")
