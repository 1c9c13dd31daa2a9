"""The command ``warehouse explore``."""

from pathlib import Path

import pytest
from helpers.command_line import Warehouse
from PIL import Image

from warehouse_core import Episode


def values(out: str) -> dict[str, str]:
    """Return the values that the command prints, by their names."""
    return {line[:16].strip(): line[16:] for line in out.splitlines()}


@pytest.mark.parametrize(("radius", "seen", "plans"), [(0, 14, 3), (1, 38, 2), (20, 84, 2)])
def test_it_prints_the_outcome_and_how_much_was_seen(
    warehouse: Warehouse, radius: int, seen: int, plans: int
) -> None:
    words = ("explore", "--seed", 12, "--view-radius", radius, "--save", "way.npz")
    code, out, _ = warehouse(*words)
    said, episode = values(out), Episode.load("way.npz")
    assert code == 0
    assert out.startswith("ExploringAgent on the grid backend, seed 12, stations drawn\n")
    assert (said["outcome"], said["cells seen"]) == ("delivered", f"{seen} of 84")
    assert said["plans made"] == str(plans)
    assert said["fewest steps"] == f"15; it took {episode.steps / 15:.2f} times as many"
    assert (episode.agent, episode.settings.view_radius) == ("ExploringAgent", radius)


def test_an_episode_without_a_delivery_is_drawn_and_not_compared(warehouse: Warehouse) -> None:
    words = ("--seed", 5, "--max-steps", 2, "--backend", "physics", "--save", "a.png")
    said = values(warehouse("explore", *words).out)
    assert said["outcome"] == "out of time"
    assert said["fewest steps"].isdigit()
    with Image.open("a.png") as picture:
        assert picture.width > 100


def test_an_unreachable_delivery_has_no_fewest_steps(warehouse: Warehouse, tmp_path: Path) -> None:
    (tmp_path / "closed.txt").write_text("#####\n#.#.#\n#####\n", encoding="utf-8")
    words = ("--layout", "closed.txt", "--seed", 1, "--max-steps", 3, "--no-show")
    said = warehouse("explore", *words)
    assert said.code == 0
    assert "fewest steps    none: no way leads to the delivery" in said.out
