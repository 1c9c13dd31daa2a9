"""The map of an agent that weighs risks: known cells and expected lengths of paths."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product

from agents.search.algorithms import Solution, astar_search
from agents.search.belief import Belief, BeliefProblem, cells_in_view
from agents.search.heuristics import manhattan
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import CHARGER, DROPOFF, MOVE_DELTAS, PICKUP, Cell, moved

Plan = tuple[Cell, ...]
"""The stations and chargers at which a robot stops, in the order of its visits."""

CROWD = 3.0
"""Expected number of steps, beyond one, to enter a cell with a robot or a person in it."""

OCCUPIED = "OoH"
"""Characters of other robots and of people in an observation."""


class RiskMap(Belief):
    """A map of the cells seen so far, with stations, chargers and expected steps.

    Entering a cell takes one step. The map expects ``doubt`` more steps if the cell has not been
    seen, and ``CROWD`` more if a robot or a person is in it. It ignores a station after an action
    there had no effect.
    """

    def __init__(self, doubt: float) -> None:
        super().__init__()
        self._doubt = doubt
        self._tiles: dict[Cell, str] = {}
        self._useless: set[Cell] = set()
        self._occupied: set[Cell] = set()
        self._tried: tuple[Cell, bool, Cell] | None = None
        self._paths: dict[tuple[Cell, Cell], Solution[Cell, str]] = {}

    def look(self, observation: Observation) -> None:
        """Add the cells in view to the map, and learn from the result of the last action."""
        super().look(observation)
        here, view = observation["robot_pos"], cells_in_view(observation)
        if self._tried is not None and self._tried[:2] == (here, observation["has_item"]):
            target = self._tried[2]
            self._useless.add(here) if target == here else self.bump(target)
        self._occupied = {cell for cell, tile in view.items() if tile in OCCUPIED}
        self._tiles |= {
            cell: tile for cell, tile in view.items() if tile in (PICKUP, DROPOFF, CHARGER)
        }
        for tile, cell in (
            (PICKUP, observation["pickup_pos"]),
            (DROPOFF, observation["dropoff_pos"]),
        ):
            if cell is not None:
                self._tiles[cell] = tile
        self._tried = None
        self._paths.clear()

    def plans(self, has_item: bool) -> Iterator[Plan]:
        """Yield all plans for a delivery, those without a charger first."""
        stops = (DROPOFF,) if has_item else (PICKUP, DROPOFF)
        direct = list(product(*map(self._places, stops)))
        yield from direct
        for plan, at, charger in product(direct, range(len(stops)), self._places(CHARGER)):
            yield *plan[:at], charger, *plan[at:]

    def is_charger(self, cell: Cell) -> bool:
        """Return whether a cell is known to have a charger."""
        return self._tiles.get(cell) == CHARGER

    def steps(self, start: Cell, stop: Cell) -> float:
        """Return the expected steps of the best path between two cells; infinite without a path."""
        path = self._path(start, stop)
        return path.cost if path.found else math.inf

    def action_towards(self, stop: Cell, observation: Observation) -> str:
        """Return the first move of the path to a stop, or the action to take there."""
        here, has_item = observation["robot_pos"], observation["has_item"]
        if here == stop and self.is_charger(here):
            return "WAIT"
        if here == stop:
            self._tried = here, has_item, here
            return "DROP" if has_item else "PICK"
        move = self._path(here, stop).actions[0]
        self._tried = here, has_item, moved(here, MOVE_DELTAS[move])
        return move

    def expected_steps(self, cell: Cell) -> float:
        """Return the expected number of steps to enter a cell, at least 1."""
        return 1.0 + self._doubt * (cell not in self.known) + CROWD * (cell in self._occupied)

    def _places(self, tile: str) -> list[Cell]:
        tiles = self._tiles.items()
        return [cell for cell, known in tiles if known == tile and cell not in self._useless]

    def _path(self, start: Cell, stop: Cell) -> Solution[Cell, str]:
        if (start, stop) not in self._paths:
            problem = _RiskyPath(self, start, stop)
            self._paths[start, stop] = astar_search(problem, manhattan(problem))
        return self._paths[start, stop]


class _RiskyPath(BeliefProblem):
    def __init__(self, risks: RiskMap, start: Cell, goal: Cell) -> None:
        super().__init__(risks, start, goal)
        self._expected_steps = risks.expected_steps

    def expand(self, state: Cell) -> Sequence[tuple[str, Cell, float]]:
        return [(move, to, self._expected_steps(to)) for move, to, _ in super().expand(state)]
