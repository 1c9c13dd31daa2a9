import pytest

from agents import cli
from agents.commands.compare_backends import ROWS, comparison_table, first_difference
from agents.console.main import main
from agents.run_episode import run_episode
from warehouse_core import Episode, replay_episode


def changed(episode: Episode, step: int, action: str) -> Episode:
    """The same episode run again with another action at one step, counted from 1."""
    again = replay_episode(episode)
    again.actions[step - 1] = action
    return replay_episode(again)


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(cli.app, arguments)
    return ended.value.code or 0


def test_nominal_physics_does_what_the_grid_does():
    grid, physics = (run_episode(backend=backend, seed=12) for backend in ("grid", "physics"))
    assert first_difference(grid, physics) is None
    assert physics.settings.backend == "physics"
    assert sum(motion.seconds for motion in physics.motions) > grid.steps


def test_the_first_step_that_differs_is_named():
    episode = run_episode(seed=12)
    assert first_difference(episode, episode) is None
    assert first_difference(episode, changed(episode, 4, "WAIT")) == 4


def test_a_shorter_episode_differs_where_it_ends():
    episode = run_episode(seed=12)
    shorter = run_episode(seed=12, max_steps=10)
    assert first_difference(episode, shorter) == first_difference(shorter, episode) == 11


def test_the_table_has_both_backends_and_every_row():
    episode = run_episode(seed=12)
    table = comparison_table(episode, episode)
    assert [column.header for column in table.columns] == ["", "grid", "grid"]
    assert table.row_count == len(ROWS) + 1
    assert list(table.columns[1].cells)[:3] == ["delivered", "23", "12.70"]


def test_compare_prints_the_table_and_saves_both_replays(tmp_path, capsys):
    target = tmp_path / "both.png"
    code = run("compare", "--seed", "12", "--max-steps", "5", "--save", str(target))
    said = capsys.readouterr().out
    assert code == 0
    assert target.stat().st_size > 10_000
    assert all(word in said for word in ("grid", "physics", "joules", "out of time"))


@pytest.mark.parametrize(
    ("arguments", "word"),
    [(["--right", "balloon"], "balloon"), (["--save", "both.npz"], ".npz")],
)
def test_what_cannot_be_compared_is_one_line(arguments, word, capsys):
    assert run("compare", "--seed", "1", *arguments) == 1
    error = capsys.readouterr().err
    assert word in error
    assert error.count("\n") == 1
