"""The command ``warehouse explore``."""

from pathlib import Path

import pytest
from helpers.command_line import command
from PIL import Image

from warehouse_core import Episode


def values(out: str) -> dict[str, str]:
    """Return the values that the command prints, by their names."""
    return {line[:16].strip(): line[16:] for line in out.splitlines()}


def test_it_prints_the_outcome_and_how_much_was_seen(capsys: pytest.CaptureFixture[str]) -> None:
    result = command(capsys, "explore", "--seed", 12, "--view-radius", 1, "--save", "way.npz")
    said, episode = values(result.out), Episode.load("way.npz")
    assert result.code == 0
    assert result.out.startswith("ExploringAgent on the grid backend, seed 12, stations drawn\n")
    assert said["outcome"] == "delivered"
    assert said["cells seen"] == "38 of 84"
    assert said["plans made"] == "2"
    assert said["fewest steps"] == "15; it took 1.00 times as many"
    assert (episode.agent, episode.settings.view_radius) == ("ExploringAgent", 1)


def test_a_larger_view_radius_sees_more_cells(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("explore", "--seed", 12, "--save", "way.npz", "--view-radius")
    near, far = (
        int(values(command(capsys, *words, radius).out)["cells seen"].split()[0])
        for radius in (0, 20)
    )
    assert near < 40
    assert far == 84


def test_it_saves_the_replay_in_each_given_format(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    saves = ("--save", "a.png", "--save", "b.svg", "--backend", "physics", "--max-steps", 4)
    assert command(capsys, "explore", "--seed", 1, *saves).code == 0
    assert {path.name for path in tmp_path.iterdir()} == {"a.png", "b.svg"}


def test_without_a_display_the_replay_goes_to_a_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    said = command(capsys, "explore", "--seed", 5, "--max-steps", 2)
    assert "saved explore-grid-5.gif" in said.out
    assert values(said.out)["outcome"] == "out of time"
    assert values(said.out)["fewest steps"].isdigit()
    with Image.open(tmp_path / "explore-grid-5.gif") as film:
        assert film.n_frames == 3  # type: ignore[attr-defined]


def test_an_unreachable_delivery_has_no_fewest_steps(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "closed.txt").write_text("#####\n#.#.#\n#####\n", encoding="utf-8")
    words = ("--layout", "closed.txt", "--seed", 1, "--max-steps", 3, "--no-show")
    said = command(capsys, "explore", *words)
    assert said.code == 0
    assert "fewest steps    none: no way leads to the delivery" in said.out
