"""A validator of plans of several robots; it shares no code with the planners.

Cells are numbers, ``row * width + col``, as in the plans; inside they are pairs.
"""

from collections.abc import Iterable, Sequence

from warehouse_core.motion.base import Motion

Places = Sequence[int]


def plan_conflict(
    rows: Sequence[str], starts: Places, goals: Places, plan: Sequence[Places]
) -> str | None:
    """Return the first fault of a plan, or ``None``.

    Args:
        rows: rows of the layout.
        starts: cells where the robots begin.
        goals: cells where the robots end.
        plan: the cell of each robot before each joint step and after the last.
    """
    plan = [[int(cell) for cell in places] for places in plan]
    if not plan or plan[0] != [int(cell) for cell in starts]:
        return f"it does not begin at the starts {list(starts)}"
    for step in range(len(plan) - 1):
        found = step_conflict(rows, plan[step], plan[step + 1])
        if found is not None:
            return f"step {step}: {found}"
    for robot, (cell, goal) in enumerate(zip(plan[-1], goals, strict=True)):
        if cell != goal:
            return f"robot {robot} ends in {cell}, not in its goal {goal}"
    return None


def step_conflict(
    rows: Sequence[str],
    before: Places,
    after: Places,
    stays: Iterable[bool] = (),
    closed: Iterable[int] = (),
) -> str | None:
    """Return the first fault of a joint step, or ``None``.

    Args:
        rows: rows of the layout.
        before: cells of the robots before the step.
        after: cells of the robots after the step.
        stays: true for each robot that must not move; empty if all may move.
        closed: cells that no robot can enter; a robot that is in one may stay.
    """
    if len(before) != len(after):
        return f"{len(after)} cells for {len(before)} robots"
    width, closed = len(rows[0]), {int(cell) for cell in closed}
    here = [divmod(int(cell), width) for cell in before]
    there = [divmod(int(cell), width) for cell in after]
    for robot, ((row, col), (to_row, to_col)) in enumerate(zip(here, there, strict=True)):
        moves = abs(row - to_row) + abs(col - to_col)
        if moves > 1:
            return f"robot {robot} moves {moves} cells, from {row, col} to {to_row, to_col}"
        if not 0 <= to_row < len(rows) or rows[to_row][to_col] == "#":
            return f"robot {robot} is in a wall, {to_row, to_col}"
        if moves and to_row * width + to_col in closed:
            return f"robot {robot} enters the closed cell {to_row, to_col}"
    for robot, still in enumerate(stays):
        if still and here[robot] != there[robot]:
            return f"robot {robot} does not stay in {here[robot]}"
    return _meeting(here, there)


def _meeting(here: list[tuple[int, int]], there: list[tuple[int, int]]) -> str | None:
    for one in range(len(here)):
        for other in range(one):
            if there[one] == there[other]:
                return f"robots {other} and {one} are both in {there[one]}"
            if there[one] == here[other] and there[other] == here[one]:
                return f"robots {other} and {one} change places, {here[other]} and {here[one]}"
    return None


def check_traffic(motion: Motion, layout, plan: Sequence[Places]) -> None:
    """Carry out a plan with a motion.

    Raises:
        AssertionError: a robot is blocked, or is not in the cell of the plan after a step.
    """
    pairs = [[divmod(int(cell), layout.width) for cell in places] for places in plan]
    motion.reset(layout, pairs[0], 0)
    for step, places in enumerate(pairs[1:]):
        moves = [
            (to_row - row, to_col - col)
            for (row, col), (to_row, to_col) in zip(pairs[step], places, strict=True)
        ]
        outcomes = motion.advance(moves, [False] * len(moves))
        blocked = [robot for robot, outcome in enumerate(outcomes) if outcome.blocked]
        assert not blocked, f"step {step}: blocked {blocked}"
        assert [outcome.cell for outcome in outcomes] == places, f"step {step}"
