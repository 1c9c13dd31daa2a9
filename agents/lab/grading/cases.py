"""The episodes of a rubric: where they take place, and how they are run again."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from agents.lab.grading.slipping import SlippingGrid
from agents.lab.parameters import usual
from agents.lab.place import RANDOM, Stations, usual_stations, what_to_draw
from warehouse_core import DEFAULT_LAYOUT, Cell, Layout, Observation, WarehouseEnv, random_layout
from warehouse_core.records.failure_modes import fewest_steps
from warehouse_core.world.named_layouts import DEFAULT, find_layout


@dataclass(frozen=True, slots=True)
class GradedCase:
    """Episodes that differ by their seed alone, as a table of the rubric asks for them.

    Attributes:
        layout: a name, the path of a file, or ``RANDOM``; its size and density are of that alone.
        stations: source of pickup and dropoff; ``None`` leaves it to the rule of ``warehouse run``.
        start: start cell, or ``None`` to draw it.
        visible: the report may tell the seeds and what happened.
        slip: chance with which a move goes to a side, see ``SlippingGrid``.
    """

    name: str
    layout: str = DEFAULT
    size: tuple[int, int] = (7, 12)
    density: float = usual("density")
    first_seed: int = 1
    episodes: int = 10
    stations: Stations | None = None
    start: Cell | None = None
    battery: int = usual("battery")
    max_steps: int = usual("max_steps")
    view_radius: int = usual("view_radius")
    visible: bool = True
    slip: float = 0.0

    @property
    def files(self) -> list[Path]:
        """The file of the layout, if it has one."""
        path = Path(self.layout)
        return [path] if path.is_absolute() else []

    @property
    def seeds(self) -> range:
        """The seeds of the episodes."""
        return range(self.first_seed, self.first_seed + self.episodes)

    def agent_seed(self, seed: int) -> int:
        """Return the seed that the agent of an episode is given.

        It is the seed of the episode, as for ``warehouse run``; if that is hidden it is the number
        of the episode, because an agent could draw the same layout from the seed.
        """
        return seed if self.visible else seed - self.first_seed

    def layout_of(self, seed: int) -> Layout:
        """Return the layout of an episode, before stations are drawn."""
        if self.layout == RANDOM:
            return random_layout(*self.size, self.density, seed)
        return DEFAULT_LAYOUT if self.layout == DEFAULT else find_layout(self.layout)

    def stations_of(self, layout: Layout) -> Stations:
        """Return where pickup and dropoff come from, in a layout of the case."""
        return self.stations or usual_stations(layout, is_default=layout is DEFAULT_LAYOUT)

    def begin(self, seed: int) -> tuple[WarehouseEnv, Observation]:
        """Return the environment of an episode, and the first observation."""
        layout = self.layout_of(seed)
        return self.begin_in(layout, self.stations_of(layout), seed)

    def begin_in(
        self, layout: Layout, stations: Stations, seed: int
    ) -> tuple[WarehouseEnv, Observation]:
        """Return the environment of an episode in another layout, and the first observation."""
        limits = self.max_steps, self.battery, self.view_radius
        backend = SlippingGrid(self.slip) if self.slip else "grid"
        env = WarehouseEnv(layout, self.start, *limits, backend=backend)
        return env, env.reset(what_to_draw(stations, self.start), seed)

    def command(self, agent: str, seed: int) -> str:
        """Return the command that shows an episode."""
        words, before = ["warehouse", "run", "--agent", agent, "--seed", str(seed)], ""
        if self.layout == RANDOM:
            file = f"{self.name}-{seed}.txt"
            height, width = self.size
            before = (
                f"warehouse layout generate --height {height} --width {width} "
                f"--density {self.density:g} --seed {seed} --save {shlex.quote(file)} && "
            )
            words += ["--layout", file]
        elif self.layout != DEFAULT:
            words += ["--layout", _short(self.layout)]
        words += ["--stations", str(self.stations)] if self.stations else []
        words += ["--start", "{},{}".format(*self.start)] if self.start else []
        for name in ("battery", "max_steps", "view_radius"):
            if getattr(self, name) != usual(name):
                words += [f"--{name.replace('_', '-')}", str(getattr(self, name))]
        if self.slip:
            kind = f"{SlippingGrid.__module__}:{SlippingGrid.__name__}"
            words += ["--backend", f"{kind}:chance={self.slip:g}"]
        return before + shlex.join(words)


def needed_steps(env: WarehouseEnv) -> int | None:
    """Return the fewest steps of a delivery after ``reset``, ``None`` without a way."""
    return fewest_steps(env.layout, (env.state.robot_pos, False))[0]


def _short(path: str) -> str:
    """Return a path as a user would type it."""
    file = Path(path)
    return str(file.relative_to(Path.cwd())) if file.is_relative_to(Path.cwd()) else path
