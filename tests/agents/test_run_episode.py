import re
from pathlib import Path

import pytest
import typer
from helpers.command_line import ROOT, command, in_a_process, without_display

from agents import run_episode as module
from agents.errors import AgentError
from agents.run_episode import HIGHEST_SEED, draw_seed, make_env, report_episode, run, run_episode
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


@pytest.fixture(autouse=True)
def no_display(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    without_display(monkeypatch)
    monkeypatch.chdir(tmp_path)


# One whole episode.


def test_an_episode_runs_from_a_random_start_to_its_end() -> None:
    episode = run_episode(seed=1)
    assert isinstance(episode, Episode)
    assert episode.terminated or episode.truncated
    assert (episode.agent, episode.seed, episode.settings.backend) == ("GreedyAgent", 1, "grid")
    starts = {run_episode(seed=seed, battery=1).cells[0] for seed in range(20)}
    assert len(starts) > 5


def test_the_same_seed_gives_the_same_episode() -> None:
    assert run_episode(seed=3, layout=ROOM) == run_episode(seed=3, layout=ROOM)
    assert run_episode(seed=3) == run_episode(seed=3)


def test_other_seeds_give_other_episodes() -> None:
    episodes = [run_episode(seed=seed) for seed in range(6)]
    assert len({(str(episode.layout), tuple(episode.cells)) for episode in episodes}) == 6


def test_a_seed_that_was_drawn_is_kept_and_repeats_the_episode() -> None:
    episode = run_episode()
    assert episode.seed is not None
    assert run_episode(seed=episode.seed) == episode
    assert {run_episode(battery=1).seed for _ in range(5)} != {episode.seed}


def test_a_drawn_seed_is_short_whatever_the_readers_random_seed() -> None:
    import random

    random.seed(1)
    first = [draw_seed() for _ in range(20)]
    random.seed(1)
    assert first != [draw_seed() for _ in range(20)]
    assert all(0 <= seed <= HIGHEST_SEED for seed in first)


def test_battery_and_steps_are_the_ones_asked_for() -> None:
    assert len(run_episode(seed=1, battery=3).actions) == 3
    assert run_episode(seed=1, battery=3).outcome == "battery depleted"
    assert len(run_episode(seed=1, max_steps=2).actions) == 2
    assert run_episode(seed=1, max_steps=2).outcome == "out of time"


def test_a_record_of_a_run_runs_again() -> None:
    episode = run_episode(seed=9)
    assert replay_episode(episode) == episode


def test_a_wall_at_the_usual_start_is_no_obstacle() -> None:
    layout = Layout(["###", "##.", "P.D"])
    assert make_env(layout, "grid", 10, 10).start_pos == (1, 2)
    assert make_env(ROOM, "grid", 10, 10).start_pos == (1, 1)
    assert run_episode(layout=layout, seed=1).settings.start_pos == (1, 2)


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        ({"agent": "clever"}, AgentError),
        ({"backend": "sleigh"}, BackendError),
        ({"battery": 0}, ValueError),
        ({"max_steps": 0}, ValueError),
        ({"layout": Layout(["###"])}, ValueError),
    ],
)
def test_what_is_not_allowed_is_refused(options: dict[str, object], kind: type[Exception]) -> None:
    with pytest.raises(kind):
        run_episode(seed=1, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("agent", ["greedy", "clever"])
def test_the_environment_is_closed_whatever_happens(
    monkeypatch: pytest.MonkeyPatch, agent: str
) -> None:
    closed = []
    close = WarehouseEnv.close

    def counted(self: WarehouseEnv) -> None:
        closed.append(self)
        close(self)

    monkeypatch.setattr(WarehouseEnv, "close", counted)
    try:
        run_episode(agent, seed=1)
    except AgentError:
        assert agent == "clever"
    assert len(closed) == 1


# What it says.


def test_the_report_names_reward_battery_and_length(capsys: pytest.CaptureFixture[str]) -> None:
    episode = run_episode(seed=5)
    report_episode(episode)
    assert capsys.readouterr().out.splitlines() == [
        "GreedyAgent on the grid backend, seed 5",
        f"outcome         {episode.outcome}",
        f"diagnosis       delivered in {episode.steps} steps; the shortest way takes 14",
        f"total reward    {sum(episode.rewards):.2f}",
        f"final battery   {200 - episode.steps} of 200",
        f"episode length  {episode.steps} of at most 200 steps",
    ]


def test_the_report_names_the_failure_mode_where_the_outcome_does_not(
    capsys: pytest.CaptureFixture[str],
) -> None:
    env = WarehouseEnv(["P.#.D", "....."], (1, 0), max_steps=40)
    report_episode(
        record_episode(env, GreedyAgent(seed=1, escape_steps=0), seed=1, randomize=False)
    )
    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == "outcome         out of time"
    assert lines[2] == (
        "diagnosis       oscillation: swung between (0, 0), (0, 1) and (1, 1) for the last 38 steps"
    )


# The command.


def test_the_command_prints_the_report_of_the_episode(capsys: pytest.CaptureFixture[str]) -> None:
    report_episode(run_episode(seed=5))
    expected = capsys.readouterr().out
    assert command(capsys, "--seed", 5, "--no-show", app=app) == (0, expected, "")


def test_the_command_takes_all_that_the_function_takes(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    ROOM.save(tmp_path / "room.txt")
    report_episode(run_episode("greedy", "grid", ROOM, 6, 30, 12))
    expected = capsys.readouterr().out
    words = ["--agent", "greedy", "--backend", "grid", "--layout", "room.txt", "--seed", 6]
    words += ["--battery", 30, "--max-steps", 12, "--no-show"]
    assert command(capsys, *words, app=app).out == expected


def test_a_drawn_seed_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    out = command(capsys, "--no-show", app=app).out
    found = re.search(r"seed (\d+)$", out, re.MULTILINE)
    assert found is not None
    assert command(capsys, "--no-show", "--seed", found.group(1), app=app).out == out


def test_targets_are_checked_before_the_episode_is_run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "run_episode", lambda *_: pytest.fail("it ran"))
    assert command(capsys, "--save", "film.xyz", app=app).code == 1
    assert command(capsys, "--save", "missing/film.gif", app=app).code == 1


@pytest.mark.parametrize(
    "words", [["-m", "agents.run_episode"], [ROOT / "agents" / "run_episode.py"]]
)
def test_the_file_and_the_module_are_the_command(tmp_path: Path, words: list[object]) -> None:
    result = in_a_process(*words, "--seed", 5, "--battery", 6, folder=tmp_path)
    assert result.code == 0
    assert result.err == ""
    assert result.out.splitlines()[-2:] == [
        "there is no display to open a window on, so the replay goes to a file",
        "saved replay-5.gif",
    ]
    assert result.out.startswith("GreedyAgent on the grid backend, seed 5\n")
    assert [path.name for path in tmp_path.iterdir()] == ["replay-5.gif"]


def test_the_files_errors_are_one_line(tmp_path: Path) -> None:
    file = ROOT / "agents" / "run_episode.py"
    result = in_a_process(file, "--agent", "clever", folder=tmp_path)
    assert result.code == 1
    assert result.err.startswith("warehouse: no agent is called 'clever'")
    assert result.err.count("\n") == 1
