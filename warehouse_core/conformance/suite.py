"""The conformance suite: checks that a motion backend follows the rules of ``motion/base.py``.

It needs no test runner. Three lines test a backend::

    from warehouse_core.conformance import run_conformance

    report = run_conformance(MyMotion)
    report.raise_for_failures()

The checks are plain functions in ``checks.py`` and, for batches, ``batch_checks.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from warehouse_core.conformance.batch_checks import BATCH_CHECKS
from warehouse_core.conformance.checks import CHECKS as SINGLE_CHECKS
from warehouse_core.conformance.checks import Check
from warehouse_core.conformance.trials import ConformanceError, MakeMotion

CHECKS: tuple[Check, ...] = SINGLE_CHECKS + BATCH_CHECKS
"""All checks in the order in which they run."""

PASSED, FAILED = "passed", "failed"
EXPECTED_FAILURE, UNEXPECTED_PASS = "expected failure", "unexpected pass"


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The result of one check.

    Attributes:
        name: name of the check, as in ``expected_failures``.
        rule: rule that it checks, a sentence.
        status: ``"passed"``, ``"failed"``, ``"expected failure"`` or ``"unexpected pass"``.
        detail: reason for the failure, or for expecting a failure; "" if the check passed.
    """

    name: str
    rule: str
    status: str
    detail: str = ""

    def __str__(self) -> str:
        return f"{self.status}: {self.name}: {self.detail or self.rule}"


@dataclass(frozen=True, slots=True)
class Report:
    """The results of all checks in the order of ``CHECKS``; ``str`` returns a line for each.

    Example:
        >>> from warehouse_core import GridMotion
        >>> from warehouse_core.conformance import run_conformance
        >>> report = run_conformance(GridMotion)
        >>> report.raise_for_failures()
        >>> report.results[0].name, report.results[0].status
        ('check_reset_puts_robots_at_rest', 'passed')
    """

    results: tuple[CheckResult, ...]

    @property
    def failures(self) -> tuple[CheckResult, ...]:
        """The results of checks that failed, or that passed although they were expected to fail."""
        return tuple(r for r in self.results if r.status in (FAILED, UNEXPECTED_PASS))

    def raise_for_failures(self) -> None:
        """Raise an error if there are failures.

        Raises:
            ConformanceError: there are failures; the message lists all of them.
        """
        if self.failures:
            raise ConformanceError("\n".join(map(str, self.failures)))

    def __str__(self) -> str:
        return "\n".join(map(str, self.results))


def run_conformance(
    make_motion: MakeMotion, expected_failures: Mapping[str, str] | None = None
) -> Report:
    """Run all checks, and return their results.

    A check fails if the motion raises an unexpected exception.

    Args:
        make_motion: function or class that returns a new motion at each call.
        expected_failures: names of checks that the motion is known to fail, with the reasons. A
            check that passes unexpectedly is a failure.

    Raises:
        ValueError: ``expected_failures`` has an unknown name or an empty reason.

    Example:
        >>> from warehouse_core import GridMotion
        >>> from warehouse_core.conformance import run_conformance
        >>> run_conformance(GridMotion).raise_for_failures()
    """
    expected = dict(expected_failures or {})
    unknown = expected.keys() - {check.__name__ for check in CHECKS}
    if unknown:
        raise ValueError(f"no check is called {', '.join(sorted(unknown))}")
    for name, reason in expected.items():
        if not reason.strip():
            raise ValueError(f"the expected failure of {name} needs a reason")
    return Report(tuple(_run(check, make_motion, expected.get(check.__name__)) for check in CHECKS))


def _run(check: Check, make_motion: MakeMotion, reason: str | None) -> CheckResult:
    name, rule = check.__name__, (check.__doc__ or "").strip()
    try:
        check(make_motion)
    except Exception as error:
        detail = str(error) if isinstance(error, ConformanceError) else f"it raised {error!r}"
        if reason is None:
            return CheckResult(name, rule, FAILED, detail)
        return CheckResult(name, rule, EXPECTED_FAILURE, f"{reason} ({detail})")
    if reason is None:
        return CheckResult(name, rule, PASSED)
    return CheckResult(name, rule, UNEXPECTED_PASS, f"it was expected to fail: {reason}")
