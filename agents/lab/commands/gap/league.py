"""A problem of the League in ``warehouse gap``: what its score is worth on bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import typer

from agents.errors import PlanError
from agents.lab.commands.gap.game import Game, GameScore, game_of, play_in
from agents.lab.commands.gap.summary import shares_in_words
from agents.lab.commands.gap.worlds import DRIVING, PLAN, WORLDS, Shocks
from agents.lab.commands.planners.league import headed_planner, play_checked, usual_name
from agents.lab.console.csv_file import write_csv
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import print_error, say, warnings_printed
from agents.lab.trials.workers import run_trials
from agents.mapf.league.checker import check_result
from agents.mapf.league.result import Result, read_result
from warehouse_core import DEFAULT_LAYOUT
from warehouse_core.motion.backends import load_backend
from warehouse_core.wording import counted
from warehouse_core.world.robot_runners import League, load_league

VALUES = ".csv"

STEPS = 100
"""Steps that are played if nothing says how many."""

THEIRS = "theirs"

GameScores = Mapping[str, GameScore]
"""Score of each world by its name."""


def gap_of_league(
    file: Path,
    planner: str | None,
    beside: Path | None,
    max_steps: int | None,
    step_seconds: float,
    shocks: Shocks,
    seed: int,
    jobs: int | None,
    save: Sequence[Path],
) -> None:
    """Compare the plan of a problem of the League with what bodies do."""
    for path in save:
        if path.suffix != VALUES:
            raise typer.BadParameter(f"{path}: of a problem of the League values are saved as .csv")
    load_backend("driving")  # what it needs is missed here, and not after the game
    with warnings_printed():
        problem = load_league(file)
    check_league(file, problem, planner, seed)
    results = results_of(problem, planner, beside, max_steps, step_seconds, seed)
    scores = {}
    for name, result in results.items():
        game = game_of(problem.layout, result, max_steps or len(result.actual))
        scores[name] = drive(game, shocks, seed, jobs)
        title = (
            f"{counted(len(problem.starts), 'robot')} ({name}), "
            f"{counted(len(game.cells) - 1, 'step')}, {file.stem}, seed {seed}"
        )
        print_table(league_table(scores[name], game, title))
        say(worth(scores[name], game, shocks))
        if result.late:
            print_error(f"warning: {name}: {counted(result.late, 'step')} without a plan")
    for path in save:
        write_league_values(path, scores)
        say(f"saved {path}")


def check_league(file: Path, problem: League, planner: str | None, seed: int) -> None:
    """Raise before any run if a problem or a planner does not go with the comparison."""
    if problem.year == 2026:
        raise PlanError(
            f"{file}: a problem of 2026; allowed: 2023 and 2024, whose actions take a step"
        )
    if planner is not None:
        headed_planner(planner, seed, DEFAULT_LAYOUT, 1)


def results_of(
    problem: League,
    planner: str | None,
    beside: Path | None,
    max_steps: int | None,
    step_seconds: float,
    seed: int,
) -> dict[str, Result]:
    """Return the result of a planner by its name, and the one of a file.

    Raises:
        PlanError: the planner breaks a rule of the League, or the file does.
    """
    found = {}
    if beside is not None:
        found[THEIRS] = theirs = read_result(beside, problem.layout)
        verdict = check_result(problem, theirs)
        if verdict.finished is None:
            why = verdict.error or "it does not say who had which task"
            raise PlanError(f"{beside}: {why}")
        max_steps = max_steps or len(theirs.actual)
    name = planner or usual_name(problem, step_seconds)
    return {name: play_checked(problem, name, max_steps or STEPS, step_seconds, seed), **found}


def drive(game: Game, shocks: Shocks, seed: int, jobs: int | None) -> dict[str, GameScore]:
    """Return the score of each world by its name."""
    runs = run_trials(partial(play_in, game=game, shocks=shocks), WORLDS, [seed], jobs)
    return {world: score for world, [score] in runs.items()}


def league_table(scores: GameScores, game: Game, title: str) -> TextTable:
    """Return a table with a row for each world."""
    steps, robots = len(game.cells) - 1, game.cells.shape[1]
    rows = [
        (
            world,
            str(score.finished),
            written(100 * share_of(score, scores[PLAN]), 1),
            *(
                written(number / score.finished if score.finished else math.nan, digits)
                for number, digits in (
                    (robots * steps, 1), (score.joules / 1000, 2), (score.stops, 1),
                )
            ),
            str(score.hits),
        )
        for world, score in scores.items()
    ]  # fmt: skip
    header = (
        "world", "tasks", "% of the plan's", "s a task", "kJ a task", "stops a task", "hits",
    )  # fmt: skip
    caption = f"what all robots do in {steps} s; on the grid a step takes 1 s"
    return TextTable(header, rows, title, caption)


def written(number: float, digits: int) -> str:
    """Return a number with so many digits, or ``none`` in place of NaN."""
    return "none" if math.isnan(number) else f"{number:,.{digits}f}"


def share_of(score: GameScore, plan: GameScore) -> float:
    """Return the number of finished tasks relative to the plan."""
    return score.finished / plan.finished if plan.finished else math.nan


def worth(scores: GameScores, game: Game, shocks: Shocks) -> str:
    """Return in words what the score of a game is worth on bodies."""
    steps, robots = len(game.cells) - 1, game.cells.shape[1]
    driven, plan = scores[DRIVING], scores[PLAN]
    shares = {world: share_of(score, plan) for world, score in scores.items()}
    cost = ""
    if driven.finished:
        seconds, joules = robots * steps / driven.finished, driven.joules / driven.finished
        cost = f"; a task takes robots {seconds:.1f} s and {joules:,.0f} J"
    return (
        f"Of {counted(plan.finished, 'task')} bodies that drive through finish {driven.finished} "
        f"in the same {steps} s{cost}.\n{shares_in_words(shares, shocks)}."
    )


def write_league_values(path: Path, scores: Mapping[str, GameScores]) -> None:
    """Write a line for each plan and world."""
    lines = [
        [name, world, *score] for name, each in scores.items() for world, score in each.items()
    ]
    write_csv(path, ["by", "world", *GameScore._fields], lines)
