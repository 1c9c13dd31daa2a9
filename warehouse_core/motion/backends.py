"""Installed motion backends by name.

A backend is a class in the entry-point group ``warehouse_core.backends`` of any installed
distribution. ``grid`` and ``physics`` are registered in the same way as third-party backends.

Options may follow a name, as in ``physics:top_speed=2,turn_seconds=1.5``, if the class of the
backend has a class method ``from_numbers(numbers)``. It takes a dict of the options, and returns a
motion or raises ``ValueError``. The values are numbers, except for the options that the class lists
in ``WORDS``, whose values are words, as in ``physics:drive=differential``.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING

from warehouse_core.errors import BackendError
from warehouse_core.extras import pip_install, requirements_of
from warehouse_core.motion.base import BaseBatchMotion, Motion, with_defaults
from warehouse_core.motion.separate import SeparateMotions
from warehouse_core.wording import brief
from warehouse_core.world.layout import Layout

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "warehouse_core.backends"

Backend = str | Motion | type[Motion]


def make_motion(backend: Backend) -> Motion:
    """Return a motion for a backend given by name, as a class or as an instance.

    Raises:
        BackendError: no backend of this name is installed, its requirements are missing or broken,
            or the backend does not accept the options after its name.
        TypeError: ``backend`` is neither a name, nor a class or instance of a motion.

    Example:
        >>> from warehouse_core.motion import make_motion
        >>> make_motion("physics:top_speed=2").spec.top_speed
        2.0
    """
    if isinstance(backend, str):
        return _make_named(backend)
    if isinstance(backend, type) and hasattr(backend, "advance"):
        return backend()
    if isinstance(backend, Motion):
        return backend
    raise TypeError(
        f"backend {brief(backend, 100)} is {type(backend).__name__}; allowed: a name "
        f"({', '.join(backend_names())}), or a class or instance with reset, advance and close"
    )


def make_batch_motion(backend: Backend, layouts: Sequence[Layout]) -> BaseBatchMotion:
    """Return a motion of a backend for one robot in each of these layouts.

    Raises:
        BackendError: ``make_motion`` fails, or the backend has no ``batch``.
        ValueError: the settings of the motion do not allow a batch.
    """
    motion, batch = make_motion(backend), None
    if not is_outdated(motion, "batch"):
        batch = with_defaults(motion).batch(layouts)
    if batch is None:
        raise BackendError(
            f"backend {brief(backend, 100)} cannot move a batch; it would need a method "
            "batch(layouts) for its own advance()"
        )
    complete: BaseBatchMotion = with_defaults(batch, BaseBatchMotion)
    return complete


def make_fleet_motion(backend: Backend, layouts: Sequence[Layout], robots: int) -> BaseBatchMotion:
    """Return a motion of a backend for ``robots`` robots, at least 1, in each of these layouts.

    If the backend has no array version, each layout gets a motion of its own.

    Raises:
        BackendError: ``make_motion`` fails, or several motions are needed and ``backend`` is only a
            single instance.
    """
    motion, batch = make_motion(backend), None
    with suppress(ValueError):
        if not is_outdated(motion, "fleet_batch"):
            batch = with_defaults(motion).fleet_batch(layouts, robots)
    if batch is not None:
        complete: BaseBatchMotion = with_defaults(batch, BaseBatchMotion)
        return complete
    if len(layouts) > 1 and not isinstance(backend, (str, type)):
        raise BackendError(
            f"backend {brief(backend, 100)} is a single motion, for one layout; "
            f"{len(layouts)} layouts need the name or the class of a backend"
        )
    return SeparateMotions([make_motion(backend) for _ in layouts], layouts, robots)


def is_outdated(motion: Motion, method: str) -> bool:
    """Return whether a class overrides ``advance`` without its method that makes batches.

    The inherited batches would move robots like the parent class does.
    """
    kinds = type(motion).__mro__
    nearest = {name: kind for kind in reversed(kinds) for name in vars(kind)}
    return kinds.index(nearest["advance"]) < kinds.index(nearest.get(method, kinds[0]))


def _make_named(backend: str) -> Motion:
    """Return a motion for a backend given by name, which options may follow."""
    name, colon, numbers = backend.partition(":")
    kind = load_backend(name)
    if not colon:
        return kind()
    from_numbers = getattr(kind, "from_numbers", None)
    if from_numbers is None:
        raise BackendError(
            f"backend {brief(name, 100)} takes no numbers; {brief(numbers)} was given"
        )
    try:
        motion: Motion = from_numbers(read_numbers(numbers, getattr(kind, "WORDS", ())))
    except ValueError as error:
        raise BackendError(f"backend {brief(backend, 100)}: {error}") from error
    return motion


def read_numbers(text: str, words: Collection[str]) -> dict[str, float | str]:
    """Return options by name: numbers, and words for the options that take words.

    Raises:
        ValueError: a part of the text is not of the form ``name=value``.
    """
    numbers: dict[str, float | str] = {}
    for part in text.split(","):
        name, _, value = part.partition("=")
        try:
            numbers[name] = value if name in words else float(value)
        except ValueError:
            forms = " or ".join(["name=1.5", *(f"{word}=word" for word in words)])
            raise ValueError(f"{brief(part)} is not of the form {forms}") from None
    return numbers


def backend_names() -> list[str]:
    """Return the names of all installed backends in alphabetical order.

    Example:
        >>> from warehouse_core.motion import backend_names
        >>> backend_names()
        ['driving', 'grid', 'physics']
    """
    return sorted(_entry_points())


@cache
def load_backend(name: str) -> type[Motion]:
    """Import a backend, and return its class.

    Raises:
        BackendError: no backend of this name is installed, or its requirements are missing or
            broken. The message lists the installed backends, or gives the command that installs the
            requirements.

    Example:
        >>> from warehouse_core.motion import load_backend
        >>> load_backend("grid")
        <class 'warehouse_core.motion.grid.GridMotion'>
    """
    entry_point = _entry_points().get(name)
    if entry_point is None:
        installed = ", ".join(backend_names()) or "none"
        raise BackendError(f"no backend is called {brief(name, 100)}; installed: {installed}")
    try:
        backend: type[Motion] = entry_point.load()
    except Exception as error:
        raise BackendError(f"backend {name!r} {_complaint(error, entry_point)}") from error
    return backend


@cache
def _entry_points() -> dict[str, EntryPoint]:
    from importlib.metadata import entry_points

    return {entry_point.name: entry_point for entry_point in entry_points(group=GROUP)}


def _complaint(error: Exception, entry_point: EntryPoint) -> str:
    """Return a line with the cause of an import error and a command that may fix it."""
    command = pip_install(_requirements(entry_point))
    if isinstance(error, ModuleNotFoundError):
        return f"needs {error.name or error}, which is not installed: {command}"
    reason = " ".join(str(error).split()) or type(error).__name__
    return f"cannot be loaded: {reason}; to repair it: {command}"


def _requirements(entry_point: EntryPoint) -> list[str]:
    """Return the requirements of a backend: the requirements of an extra, or the distribution.

    The extra has the name of the backend, or of another backend in the same module, whose
    requirements are the same.
    """
    distribution = entry_point.dist
    if distribution is None:
        return [entry_point.module.partition(".")[0]]
    siblings = [name for name, each in _entry_points().items() if each.module == entry_point.module]
    for name in (entry_point.name, *siblings):
        if needed := requirements_of(name, distribution.requires or []):
            return needed
    return [distribution.metadata["Name"]]
