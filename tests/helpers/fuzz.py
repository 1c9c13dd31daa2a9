"""Inputs of every format that is read, made from good ones by small changes, and how they end.

As a program, ``python -m helpers.fuzz FORMAT INPUTS SEED`` prints a ``Report`` as JSON. It allows
itself 256 MB of memory.
"""

import io
import json
import random
import re
import resource
import sys
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any, NamedTuple

import numpy as np

from agents.lab.experiments.choices import parse_flags, read_plan_file
from agents.lab.experiments.plan import spread
from agents.learning.policy_network import PolicyNetwork
from agents.learning.q_learning import QTable
from agents.learning.q_table import load_agent, save_table
from agents.registry import make_agent
from agents.warehouse_agent_greedy import GreedyAgent
from helpers.fleets import fleet_episode
from warehouse_core import DEFAULT_LAYOUT, Episode, Layout, WarehouseEnv, record_episode
from warehouse_core.errors import WarehouseError
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.world.map_files import load_map, save_map
from warehouse_core.world.named_layouts import as_layout
from warehouse_core.world.robot_runners import load_agents, load_tasks
from warehouse_core.world.scenarios import check_scenarios, load_scenarios

MAX_BYTES, MAX_SECONDS = 256 * 2**20, 2.0

DOCUMENTED = (WarehouseError, OSError)

TOKENS = (
    b"\n", b"\r\n", b"\t", b" ", b"\x00", b"\x1b[2J", b"\xef\xbb\xbf", b"\xff", b"\xed\xa0\x80",
    b"#", b".", b"@", b"P", b"D", b"=", b",", b":", b"(", b"[", b"{", b"]", b"}", b"'", b'"', b"-",
    b"\\", b"a.", b"[[", b"'''", "\u0663".encode(), "\u202e".encode(), b"null", b"true", b"NaN",
    b"C",
)  # fmt: skip

NUMBERS = (
    b"0", b"-1", b"1", b"-0", b"1.5", b"1e308", b"1e400", b"-1e308", b"1e-320", b"nan", b"inf",
    b"2147483648", b"9223372036854775808", b"16000000", b"100001", b"9" * 20, b"9" * 900,
    b"9" * 5000, b"0x10", b"1_0", b"", b"Infinity", "\u0663".encode(),
)  # fmt: skip

VALUES: tuple[Any, ...] = (
    0, 1, -1, 2, 2**31 - 1, -(2**31), 2**63 - 1, -(2**63), 1e308, -1e308, 1e-320, np.nan, np.inf,
)  # fmt: skip

DTYPES = ("<i4", "<i8", ">i4", "<f4", "<f8", "|b1", "|u1", "<U3", "|S9", "<c16", "<M8[s]", "|V4")


class Format(NamedTuple):
    """A format: good inputs, and what reads one and all that follows."""

    good: tuple[bytes, ...]
    read: Callable[[Path], object]
    is_npz: bool = False


class Report(NamedTuple):
    """How the inputs of a format ended; seconds are of the processor, bytes of the process."""

    inputs: int
    accepted: int
    refused: int
    worst_seconds: float
    worst_bytes: int = 0


def fuzz(name: str, inputs: int, seed: int) -> Report:
    """Read changed inputs of a format, which raise documented errors only, and soon."""
    form, stream, accepted, worst = formats()[name], random.Random(seed), 0, 0.0
    with TemporaryDirectory() as folder:
        path = Path(folder, "input")
        for number in range(inputs):
            good = stream.choice(form.good)
            change = change_arrays if form.is_npz and stream.random() < 0.8 else change_bytes
            data = change(good, form.good, stream) if number else good
            path.write_bytes(data)
            start = process_time()
            try:
                form.read(path)
                accepted += 1
            except DOCUMENTED:
                assert number, f"{name}: a good input is refused"
            except Exception as error:
                raise AssertionError(f"{name}, input {number}: {error!r}"[:500]) from error
            seconds = process_time() - start
            worst = max(worst, seconds)
            assert seconds <= MAX_SECONDS, f"{name}, input {number}: {seconds} s: {data[:2000]!r}"
    return Report(inputs, accepted, inputs - accepted, worst)


def change_bytes(data: bytes, others: tuple[bytes, ...], stream: random.Random) -> bytes:
    """Flip, insert, delete, repeat and splice bytes, and replace numbers."""
    for _ in range(stream.choice((1, 1, 2, 3, 5))):
        place = stream.randrange(len(data) + 1)
        end = min(len(data), place + stream.choice((1, 1, 2, 8, 64)))
        many = stream.choice((1, 1, 1, 2, 30, 1000))
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
        elif numbers := list(re.finditer(rb"\d+", data)):
            found = stream.choice(numbers)
            data = data[: found.start()] + stream.choice(NUMBERS) + data[found.end() :]
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


@cache
def formats() -> dict[str, Format]:
    """Return every format that is read."""
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
    return {
        "layout": Format((tiles, b"\xef\xbb\xbf  #P\r\n  CD\r\n"), _read_layout),
        "map": Format((octile, b"type octile\nwidth 2\nheight 1\nmap\nGT\n"), load_map),
        "LoRR map": Format((b"type octile\nheight 2\nwidth 3\nmap\n.ES\n@.T\n",),
                           partial(load_map, robot_runners=True)),
        "scen": Format((scenario,),
                       lambda path: check_scenarios(DEFAULT_LAYOUT, load_scenarios(path))),
        "tasks": Format((b"# t\n3\n13,15\n25\n13,14,25\n",),
                        lambda path: load_tasks(path, DEFAULT_LAYOUT)),
        "agents": Format((b"2\n13\n# r\n14\n",), lambda path: load_agents(path, DEFAULT_LAYOUT)),
        "episode": Format((grid, physics), _read_episode, is_npz=True),
        "fleet": Format((fleet, bodies), _read_episode, is_npz=True),
        "q-table": Format((q_table,), load_agent, is_npz=True),
        "ppo": Format((small, large), PolicyNetwork.load, is_npz=True),
        "plan": Format((plan, b"[settings]\nlayout = ['a b.txt', \"\"\"c\n\"\"\"]\n"), _read_plan),
        "flags": Format(
            (b"battery=20:200:20", b"escape=on,off", b"agent=greedy, ppo:a.npz", b"size=7x12",
             b"density=0.1,0.25", b"robot.mass=50,60", b"stations=kept"), _read_flags,
        ),
        "names": Format(
            (b"greedy:memory=20,escape_steps=0", b"random", b"ppo:a.npz", b"astar:weight=2.5",
             b"mine.py:Class:a='b',c=(1, [2, {3: None}])", b"no.module:Class"),
            lambda path: make_agent(_text(path), seed=1),
        ),
        "given layout": Format((tiles, b"trap", b"a/b.map", b"P.D"),
                               lambda path: as_layout(_text(path))),
    }  # fmt: skip


def _network(stream: np.random.Generator, radius: int) -> PolicyNetwork:
    from agents.learning.policy_network import input_size
    from helpers.networks import layers_of

    return PolicyNetwork(radius, layers_of(input_size(radius), 8, 6, 7, stream=stream))


def _read_layout(path: Path) -> None:
    layout = Layout.load(path)
    assert Layout.from_text(str(layout)) == layout


def _read_episode(path: Path) -> None:
    """Read an episode, write it again, and do what its replay needs."""
    episode = Episode.load(path)
    episode.save(path)
    assert Episode.load(path) == episode
    assert repr(episode)
    diagnose(episode)
    track_of_record(episode)


def _read_plan(path: Path) -> None:
    for name, choice in read_plan_file(path).choices.items():
        spread(name, choice)


def _read_flags(path: Path) -> None:
    for name, choice in parse_flags([_text(path)]).items():
        spread(name, choice)


def _text(path: Path) -> str:
    """Return text as the command line gives it, lone surrogates included."""
    return path.read_bytes().decode("utf-8", "surrogateescape")


def main(name: str, inputs: str, seed: str) -> None:
    """Print the report on a format."""
    formats()
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + MAX_BYTES,) * 2)
    report = fuzz(name, int(inputs), int(seed))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(json.dumps(report._replace(worst_bytes=peak)))


if __name__ == "__main__":
    main(*sys.argv[1:])
