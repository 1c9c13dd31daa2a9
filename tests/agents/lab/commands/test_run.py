import os
import re
from pathlib import Path

import pytest
import typer
from helpers.command_line import ROOT, Warehouse, in_a_process, write_mine

from agents.lab.commands.run import report_episode, run, run_episode
from agents.lab.place import Stations
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import (
    BackendError,
    Episode,
    Layout,
    WarehouseEnv,
    record_episode,
    replay_episode,
)

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
app = typer.Typer(add_completion=False)
app.command()(run)


def test_an_episode_runs_from_a_random_start_to_its_end() -> None:
    episode = run_episode(seed=1)
    assert episode.terminated or episode.truncated
    assert (episode.agent, episode.seed, episode.settings.backend) == ("GreedyAgent", 1, "grid")
    assert replay_episode(episode) == episode
    others = [run_episode(seed=seed, battery=3) for seed in range(20)]
    assert len({(str(each.layout), each.cells[0]) for each in others}) == 20
    assert {(each.steps, each.outcome) for each in others} == {(3, "battery depleted")}


MOTION = """
from warehouse_core import GridMotion
class Mine:
    cell_size = 0.5
    def __init__(self, speed=1.0, steps=9**9):
        self.steps, grid = steps, GridMotion(0.5)
        self.reset, self.close, self.move = grid.reset, grid.close, grid.advance
    def reset(self): ...
    close = reset
    def advance(self, displacements, loaded):
        self.steps -= 1
        if not self.steps:
            raise ValueError("stuck")
        return self.move(displacements, loaded)
class Still:
    reset = advance = lambda self, *_: None
class Mute(Still):
    close = lambda self: None
"""


@pytest.mark.parametrize("line", ["run", "fleet --robots 2"])
def test_a_backend_of_a_user_is_given_by_its_file(warehouse, refused, tmp_path, line) -> None:
    os.chdir(tmp_path)
    Path("my_motion.py").write_text(MOTION)
    option = "--backend"
    words = (*line.split(), "--seed", 1, "--max-steps", 4, option)
    code, out, err = warehouse(*words, "my_motion.py:Mine:speed=2", "--save", "a.html")
    assert (code, err) == (0, "")
    assert "Mine" in out
    warehouse(*words, "my_motion.py:Mine", "--save", "a.npz")
    record = Episode.load("a.npz")
    assert record.backend == "Mine"
    with pytest.raises(BackendError, match="no backend is called 'Mine'"):
        replay_episode(record)
    said = refused(*words, "my_motion.py:Mine:steps=2", "--no-show")
    assert said == "seed 1, step 2, backend Mine: ValueError: stuck (my_motion.py, line 13)"
    assert "takes no argument 'mass'" in refused(*words, "my_motion.py:Mine:mass=2")
    assert "has no close; needed: reset and advance and close" in refused(
        *words, "my_motion.py:Still"
    )
    assert "has no cell_size" in refused(*words, "my_motion.py:Mute")
    assert "has 2 classes with" in refused(*words, "my_motion.py")
    assert "has no class 'Yours'" in refused(*words, "my_motion.py:Yours")


def test_the_report_names_the_failure_mode_if_it_is_not_the_outcome(capsys) -> None:
    env = WarehouseEnv(["P.#.D", "....."], (1, 0), max_steps=40)
    report_episode(
        record_episode(env, GreedyAgent(seed=1, escape_steps=0), seed=1, randomize=False)
    )
    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == "outcome         out of time"
    assert lines[2] == (
        "diagnosis       oscillation: kept moving between (0, 0), (0, 1) and (1, 1) for the last "
        "38 steps"
    )


def test_the_command_passes_every_option_on(warehouse: Warehouse, capsys, tmp_path) -> None:
    room = tmp_path / "room.txt"
    ROOM.save(room)
    episode = run_episode(
        "greedy:memory=3,escape_steps=0", "physics", ROOM, 6, 30, 12, 1, (2, 3), False
    )
    report_episode(episode, Stations.KEPT)
    expected = capsys.readouterr().out
    words = ["--backend", "physics", "--layout", room, "--start", "2,3", "--seed", 6]
    words += ["--battery", 30, "--max-steps", 12, "--view-radius", 1, "--no-show"]
    words += ["--agent", "greedy:memory=3,escape_steps=0"]
    assert warehouse(*words, app=app) == (0, expected, "")


def test_the_file_is_the_command(tmp_path: Path) -> None:
    file = ROOT / "agents" / "run_episode.py"
    write_mine("act", "raise KeyError('x')", "'N'", step=1)
    words = ("--agent", "mine.py:Mine", "--seed", 5, "--no-show")
    result = in_a_process(file, *words, folder=tmp_path)
    assert result.code == 1
    assert result.out.startswith("Mine on the grid backend, seed 5, random stations\n")
    assert re.fullmatch(r"warehouse: seed 5, step 1, .* KeyError: 'x' .*\n", result.err)


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        ("ValueError(3)", 1, "seed 4, step 4, agent mine.py:Mine: ValueError: 3 (mine.py, line 9)"),
        ("KeyboardInterrupt", 130, "interrupted in step 4, agent mine.py:Mine (mine.py, line 9)"),
    ],
)
def test_the_episode_until_an_agent_fails_is_reported_and_saved(
    warehouse: Warehouse, error: str, code: int, line: str
) -> None:
    write_mine("act", f"raise {error}", "'N'")
    words = ("run", "--agent", "mine.py:Mine", "--seed", 4, "--save", "e.npz")
    result = warehouse(*words)
    assert (result.code, result.err) == (code, f"warehouse: {line}\n")
    assert "outcome         unfinished\n" in result.out
    assert Episode.load("e.npz").actions == ["N"] * 3


def test_several_episodes_have_a_line_each_and_a_summary(warehouse: Warehouse) -> None:
    code, out, err = warehouse("run", "-n", 3, "--seed", 4, "--max-steps", 50, "--save", "e.npz")
    episodes = [run_episode(seed=seed, max_steps=50) for seed in (4, 5, 6)]
    assert (code, err) == (0, "")
    *lines, summary = out.splitlines()[:4]
    for episode, line in zip(episodes, lines, strict=True):
        assert line.startswith(f"seed {episode.seed}: ")
        assert line.endswith(f"; total reward {episode.total_reward:.2f}")
    delivered = sum(episode.outcome == "delivered" for episode in episodes)
    steps = sum(episode.steps for episode in episodes) / 3
    assert summary.startswith(f"{delivered} of 3 episodes delivered, mean total reward ")
    assert summary.endswith(f", mean length {steps:.1f} steps")
    assert Episode.load("e.npz") == episodes[0]
    assert "outcome" not in warehouse("run", "-n", 2, "--seed", 4, "--max-steps", 5).out


def test_slippery_cells_are_a_part_of_the_backend_that_a_record_names(warehouse, refused) -> None:
    words = ("run", "--seed", 12, "--slippery", "1,2", "--slippery", "2, 2", "--save", "icy.npz")
    assert warehouse(*words, "--backend", "physics:grip=0.04").code == 0
    episode = Episode.load("icy.npz")
    assert episode.backend == "physics:grip=0.04,slippery=1-2+2-2"
    assert episode.slippery == ((1, 2), (2, 2))
    assert replay_episode(episode) == episode
    assert warehouse(*words, "--backend", "physics").code == 0
    assert Episode.load("icy.npz").backend == "physics:slippery=1-2+2-2"
    assert refused(*words, code=2) == (
        "--slippery needs a backend with bodies; allowed: physics; given: grid"
    )
    for backend in ("mine.py:Mine", "sleigh"):
        assert f"given: {backend}" in refused(*words, "--backend", backend, code=2)
    bodies = ("run", "--backend", "physics", "--slippery")
    assert refused(*bodies, "0,0") == "--slippery row 0, column 0 is wall; it must be an open cell"
    assert "row 99, column 1 is off the grid" in refused(*bodies, "99,1")
    message = refused(*bodies, "1", code=2)
    assert message == "--slippery is '1'; it must be ROW,COL, as in 1,2"


@pytest.mark.parametrize(("radius", "seen", "plans"), [(0, 14, 3), (1, 38, 2)])
def test_the_exploring_agent_prints_how_much_it_has_seen_and_shows_its_belief(
    warehouse: Warehouse, radius: int, seen: int, plans: int
) -> None:
    words = ("--seed", 12, "--view-radius", radius, "--save", "way.npz", "--save", "way.html")
    code, out, _ = warehouse("run", "--agent", "exploring", *words)
    assert code == 0
    assert f"cells seen      {seen} of 84, plans made: {plans}\n" in out
    assert Episode.load("way.npz").agent == "ExploringAgent"
    assert "Belief of ExploringAgent" in Path("way.html").read_text()


@pytest.mark.parametrize(
    ("error", "is_shown"), [("ValueError(3)", True), ("KeyboardInterrupt", False)]
)
def test_no_window_opens_after_an_interrupt(warehouse, monkeypatch, error, is_shown) -> None:
    shown = list[object]()
    monkeypatch.setattr(
        "agents.lab.commands.run.replay_or_save", lambda *given, **_: shown.append(given[2])
    )
    write_mine("act", f"raise {error}", "'N'")
    warehouse("run", "--agent", "mine.py:Mine", "--seed", 4, "--show")
    assert shown == [is_shown]


def test_a_body_drives_the_path_of_an_agent_in_one_go(warehouse: Warehouse, tmp_path: Path) -> None:
    saved = tmp_path / "driven.npz"
    out = warehouse("run", "--backend", "driving", "--seed", 12, "--save", saved).out
    values = dict(re.split(r"  +", line, maxsplit=1) for line in out.splitlines()[1:-1])
    assert values["seconds"] == "32.7"
    assert (values["stops"], values["hits"], values["highest speed (m/s)"]) == ("6", "0", "1.00")
    assert warehouse("replay", saved, "--no-show").out.splitlines()[1:] == out.splitlines()[1:-1]
    again = warehouse("replay", saved, "--backend", "physics", "--no-show").out
    assert "49.8" in again
    on_the_grid = warehouse("replay", saved, "--backend", "grid", "--no-show").out
    assert "seconds" not in on_the_grid


def test_a_random_seed_is_kept_and_repeats_the_episode() -> None:
    episode = run_episode()
    assert episode.seed is not None
    assert run_episode(seed=episode.seed) == episode
    assert {run_episode(battery=1).seed for _ in range(5)} != {episode.seed}
    assert run_episode(seed=0, battery=1).seed == 0
