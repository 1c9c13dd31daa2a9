import re
from pathlib import Path

import pytest
import typer
from helpers.command_line import ROOT, command, in_a_process

from agents.errors import AgentError
from agents.lab.commands import run as module
from agents.lab.commands.run import report_episode, run, run_episode
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import BackendError, Layout, WarehouseEnv, record_episode, replay_episode

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
FAILS = """
class Fails:
    def reset(self):
        pass

    def act(self, observation):
        return observation["x"]
"""
app = typer.Typer(add_completion=False)
app.command()(run)


def test_an_episode_runs_from_a_random_start_to_its_end() -> None:
    episode = run_episode(seed=1)
    assert episode.terminated or episode.truncated
    assert (episode.agent, episode.seed, episode.settings.backend) == ("GreedyAgent", 1, "grid")
    assert replay_episode(episode) == episode
    starts = {run_episode(seed=seed, battery=1).cells[0] for seed in range(20)}
    assert len(starts) > 5


def test_the_same_seed_repeats_the_episode_and_others_differ() -> None:
    assert run_episode(seed=3, layout=ROOM) == run_episode(seed=3, layout=ROOM)
    episodes = [run_episode(seed=seed) for seed in range(6)]
    assert len({(str(episode.layout), tuple(episode.cells)) for episode in episodes}) == 6


def test_a_random_seed_is_kept_and_repeats_the_episode() -> None:
    episode = run_episode()
    assert episode.seed is not None
    assert run_episode(seed=episode.seed) == episode
    assert {run_episode(battery=1).seed for _ in range(5)} != {episode.seed}
    assert run_episode(seed=0, battery=1).seed == 0


def test_battery_and_steps_limit_the_episode() -> None:
    emptied, timed_out = run_episode(seed=1, battery=3), run_episode(seed=1, max_steps=2)
    assert (emptied.steps, emptied.outcome) == (3, "battery depleted")
    assert (timed_out.steps, timed_out.outcome) == (2, "out of time")


def test_the_usual_start_may_be_a_wall() -> None:
    layout = Layout(["###", "##.", "P.D"])
    for each, start in ((layout, (1, 2)), (ROOM, (1, 1))):
        episode = run_episode("greedy", "grid", each, 1, 10, 10)
        assert episode.settings.start_pos == start
    assert run_episode(layout=layout, seed=1).settings.start_pos == (1, 2)


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        ({"agent": "clever"}, AgentError),
        ({"backend": "sleigh"}, BackendError),
        ({"battery": 0}, ValueError),
        ({"max_steps": 0}, ValueError),
    ],
)
def test_wrong_arguments_are_errors(options: dict[str, object], kind: type[Exception]) -> None:
    with pytest.raises(kind):
        run_episode(seed=1, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("agent", ["greedy", "clever"])
def test_the_environment_is_always_closed(monkeypatch: pytest.MonkeyPatch, agent: str) -> None:
    closed: list[WarehouseEnv] = []
    monkeypatch.setattr(WarehouseEnv, "close", lambda env: closed.append(env))
    try:
        run_episode(agent, seed=1)
    except AgentError:
        assert agent == "clever"
    assert len(closed) == 1


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


def test_the_report_names_the_failure_mode_if_it_is_not_the_outcome(
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


def test_the_command_passes_every_option_on(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    room = tmp_path / "room.txt"
    ROOM.save(room)
    episode = run_episode(
        "greedy:memory=3,escape_steps=0", "physics", ROOM, 6, 30, 12, 1, (2, 3), False
    )
    report_episode(episode, "kept")
    expected = capsys.readouterr().out
    words = ["--backend", "physics", "--layout", room, "--start", "2,3", "--seed", 6]
    words += ["--battery", 30, "--max-steps", 12, "--view-radius", 1, "--memory", 3, "--no-escape"]
    words += ["--no-show"]
    assert command(capsys, *words, app=app) == (0, expected, "")


def test_a_random_seed_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    out = command(capsys, "--no-show", app=app).out
    found = re.search(r"seed (\d+),", out)
    assert found is not None
    assert command(capsys, "--no-show", "--seed", found.group(1), app=app).out == out


def test_files_are_checked_before_the_episode_runs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "run_episode", lambda *_: pytest.fail("it ran"))
    assert command(capsys, "--save", "film.xyz", app=app).code == 1


def test_the_file_is_the_command(tmp_path: Path) -> None:
    file = ROOT / "agents" / "run_episode.py"
    (tmp_path / "mine.py").write_text(FAILS)
    words = ("--agent", "mine.py:Fails", "--seed", 5, "--no-show")
    result = in_a_process(file, *words, folder=tmp_path)
    assert result.code == 1
    assert result.out.startswith("Fails on the grid backend, seed 5, stations drawn\n")
    assert re.fullmatch(r"warehouse: seed 5, step 1, .* KeyError: 'x' .*\n", result.err)
