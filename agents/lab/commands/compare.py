"""The command ``warehouse compare``, which compares agents, backends, planners or searches."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, ClassVar, NamedTuple

import typer

from agents.lab.commands import random_layouts
from agents.lab.commands.compare_agents import AGENTS, compare_agents
from agents.lab.commands.compare_backends import compare_backends
from agents.lab.commands.compare_fleets import DISTURBANCES, compare_fleets
from agents.lab.commands.compare_search import HEURISTICS, compare_search
from agents.lab.commands.planners.compare_planners import compare_planners
from agents.lab.console import options
from agents.lab.console.group import CommandOfKinds
from agents.lab.console.options import MANY, PICTURES, option, writable
from agents.lab.parameters import MAX_SEED, MAX_VALUE, Number, Whole
from warehouse_core.files.atomic import check_suffix
from warehouse_core.orders.order import MAX_ORDERS
from warehouse_core.wording import brief
from warehouse_core.world.named_layouts import DEPOT

FLEETS = "backends --robots"


class Comparison(NamedTuple):
    """A comparison: its function, its options and the files that it saves.

    Attributes:
        run: function that is called with the options from the command line, by name.
        options: names of its options.
        suffixes: allowed suffixes of files; if empty, the suffixes of replays are allowed.
        once: name of an option that only other comparisons may repeat, or "".
    """

    run: Callable[..., None]
    options: str
    suffixes: tuple[str, ...] = ()
    once: str = ""


COMPARISONS = {
    "agents": Comparison(
        compare_agents,
        "agent backend layout stations start episodes seed battery max_steps size density",
        PICTURES,
        once="backend",
    ),
    "backends": Comparison(
        compare_backends,
        "agent backend slippery layout stations start seed battery max_steps show",
        once="agent",
    ),
    FLEETS: Comparison(
        compare_fleets,
        "robots planner order_rate count layout disturbed episodes seed jobs",
        (".html", ".csv"),
        once="planner",
    ),
    "planners": Comparison(
        compare_planners,
        "files planner robots layout lifelong plan_seconds episodes jobs",
        (".csv", *PICTURES),
    ),
    "search": Comparison(compare_search, "layout start goal seed weights heuristic show"),
}
"""Comparisons by name."""


class CompareCommand(CommandOfKinds):
    """The command ``compare``, whose help shows the options of each comparison."""

    argument = "what"
    names: ClassVar = {
        **{kind: each.options.split() for kind, each in COMPARISONS.items()},
        "backends": f"{COMPARISONS['backends'].options} {COMPARISONS[FLEETS].options}".split(),
    }


def only(help_text: str, name: str) -> str:
    """Return the description of an option, followed by the comparisons that have it."""
    takers = [kind for kind, each in COMPARISONS.items() if name in each.options.split()]
    return f"{help_text} For {', '.join(takers)}."


def compare(
    context: typer.Context,
    what: Annotated[
        str,
        typer.Argument(metavar="WHAT", help="agents, backends, planners or search."),
    ],
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FILE",
            help="For planners: MovingAI scenario files (.scen), or folders of such files.",
            show_default=False,
        ),
    ] = None,
    *,
    agent: Annotated[
        list[str],
        option(
            "--agent NAME",
            f"{options.AGENT} May be repeated for agents. Default: {', '.join(AGENTS)}; for "
            "backends: greedy.",
            **MANY,
        ),
    ],
    backend: Annotated[
        list[str],
        option(
            "--backend NAME",
            f"{options.BACKEND.format(options.DRIVES)} May be repeated for backends. Default: "
            "grid; for backends: grid, physics and driving.",
            **MANY,
        ),
    ],
    slippery: options.SlipperyOption,
    planner: Annotated[
        list[str],
        option(
            "--planner NAME",
            f"{options.PLANNER} May be repeated for planners. Default: several planners; for "
            f"{FLEETS}: pibt:guidance=lanes.",
            **MANY,
        ),
    ],
    save: Annotated[
        list[Path],
        option(
            "--save -o FILE",
            f"{options.SAVE} For agents and planners: a figure (.svg, .png); for planners also "
            "the trials (.csv). For backends and search: a replay (.gif, .mp4, .html, .svg, .png). "
            f"For {FLEETS}: a page (.html) or the measures of each run (.csv). May be repeated.",
            callback=writable(".csv", replays=True),
            **MANY,
        ),
    ],
    robots: Annotated[
        str | None,
        option(
            "--robots -r N,N",
            f"{options.ROBOTS} For backends: the size of a fleet whose plan they carry out. For "
            "planners: several numbers, separated by commas.",
        ),
    ] = None,
    layout: Annotated[
        Path | None,
        option(
            "--layout FILE",
            f"{options.LAYOUT} For agents: also random, which uses another random layout in each "
            f"episode. Default: default; for {FLEETS}: {DEPOT}; for planners: kiva, which has 33 x "
            "46 cells.",
        ),
    ] = None,
    stations: options.StationsOption = None,
    start: options.Start = None,
    goal: Annotated[str | None, option("--goal ROW,COL", only("Goal cell.", "goal"))] = None,
    episodes: Annotated[
        int | None,
        option(
            "--episodes -n N",
            f"{options.EPISODES} Default: 100 for agents, 5 for planners and 4 for {FLEETS}.",
            Whole(1, options.MAX_EPISODES),
        ),
    ] = None,
    seed: Annotated[
        int | None,
        option(
            "--seed N",
            f"{options.SEED} Default: 0; for backends a random seed. With a seed, search has a "
            "random start and goal.",
            Whole(0, MAX_SEED),
        ),
    ] = None,
    battery: Annotated[
        int | None, options.parameter_option("battery", more="Default: 200.")
    ] = None,
    max_steps: Annotated[
        int | None, options.parameter_option("max_steps", more="Default: 200.")
    ] = None,
    size: random_layouts.Sizes = None,
    density: random_layouts.Density = None,
    weights: Annotated[
        str | None,
        option(
            "--weights W,W",
            only(
                "Up to six weights of the heuristic, each from 0 to inf. Default: 0,1,5,inf.",
                "weights",
            ),
        ),
    ] = None,
    heuristic: Annotated[
        str | None,
        option("--heuristic NAME", only(f"Heuristic: {', '.join(HEURISTICS)}.", "heuristic")),
    ] = None,
    lifelong: Annotated[
        int | None,
        option(
            "--lifelong N",
            only(
                "Number of steps of a lifelong run, in which a robot that reaches its goal gets "
                "another.",
                "lifelong",
            ),
            Whole(1),
        ),
    ] = None,
    plan_seconds: Annotated[
        float | None,
        option("--plan-seconds S", options.PLAN_SECONDS, Number(0.001, MAX_VALUE)),
    ] = None,
    order_rate: Annotated[
        float | None, options.parameter_option("order_rate", "X", f"Default: 0.4. For {FLEETS}.")
    ] = None,
    count: Annotated[
        int | None,
        option("--count N", only("Number of orders in an episode.", "count"), Whole(1, MAX_ORDERS)),
    ] = None,
    disturbed: Annotated[
        str | None,
        option(
            "--disturbed NOISE:SECONDS",
            only(
                "Disturbances of the bodies. NOISE is the standard deviation of the speed error, "
                "as a share of the commanded speed, up to 0.5. SECONDS is how long one robot "
                f"stops; inf means forever. Default: {DISTURBANCES}.",
                "disturbed",
            ),
        ),
    ] = None,
    jobs: options.Jobs = None,
    show: options.Show = None,
) -> None:
    """Compare agents, backends or planners.

    agents: print deliveries, steps, expanded nodes, time and energy over the
    same seeds, in one layout or, with --layout random, in unseen layouts.
    Several sizes share a figure.

    backends: run an episode on several backends and show them side by side.
    With --robots, run a fleet on the grid, on bodies that stop in every cell,
    on bodies that drive through, and on disturbed bodies.

    planners: print the goals that robots reach per step, for several numbers
    of robots.

    search: search one layout with several weights of the heuristic.

    Example: warehouse compare agents --agent greedy --agent my_agent.py -n 50
    """
    kind = FLEETS if what == "backends" and robots is not None else what
    if kind not in COMPARISONS:
        raise typer.BadParameter(
            f"WHAT is {brief(what)}; allowed: agents, backends, planners, search"
        )
    comparison = COMPARISONS[kind]
    given = options.given(context) - {"what"}
    names = comparison.options.split()
    if files and "files" not in names:
        raise typer.BadParameter(f"{str(files[0])!r} is one argument too many for 'compare {kind}'")
    options.refuse(context, given - {*names, "save"}, f"compare {kind}")
    for path in save:
        if comparison.suffixes or path.suffix.lower() == ".csv":
            check_suffix(path, comparison.suffixes or replay_suffixes())
    values = {name: context.params[name] for name in names if name in given}
    if once := values.get(comparison.once):
        if len(once) > 1:
            raise typer.BadParameter(
                f"--{comparison.once} is given {len(once)} times; here it may be given once"
            )
        values[comparison.once] = once[0]
    comparison.run(save=save, **values)


def replay_suffixes() -> tuple[str, ...]:
    """Return the allowed suffixes of replays."""
    from warehouse_core.viz.export import FORMATS  # here, because other comparisons do not need it

    return (*FORMATS,)
