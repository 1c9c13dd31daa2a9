"""Gradescope: results in its format, and an autograder that runs this program there.

The archive of an autograder contains a copy of this program and the versions of the libraries that
it needs, so that agents are graded in the same way on both systems.

Source: gradescope-autograders.readthedocs.io, "Technical Details", "Output format" and "Submission
Metadata".
"""

from __future__ import annotations

import json
import math
import os
import re
import sys
from collections.abc import Iterator
from datetime import datetime, timedelta
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from agents.errors import GradeError
from agents.lab.grading.grading import Grade, GradeReport, grade
from agents.lab.grading.rubric import MAX_DAYS, Rubric, load_rubric
from agents.lab.grading.sandbox import NOBODY, check_trust
from agents.lab.grading.submissions import submission_of
from agents.lab.runs.programs import OWN, ROOT
from warehouse_core.errors import WarehouseError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.reading import read_file

SETUP = """#!/usr/bin/env bash
set -e
apt-get update
apt-get install -y python3 python3-venv
python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
    echo "This image has no Python 3.11; choose a newer one." >&2
    exit 1
}
python3 -m venv /autograder/venv
/autograder/venv/bin/pip install -r /autograder/source/requirements.txt
"""

RUN = """#!/usr/bin/env bash
# Grades submission/ and writes results/results.json. A failure is written first, so that there are
# results whatever happens.
root="${AUTOGRADER_ROOT:-/autograder}"
mkdir -p "$root/results"
cat > "$root/results/results.json" <<'END'
FAILED
END
chmod 600 "$root/source/rubric.toml"  # if the kernel does not hide it from agents
cd "$root" || exit 0
export PYTHONPATH="$root/source/packages"
"${AUTOGRADER_PYTHON:-$root/venv/bin/python}" -m agents.lab.grading.gradescope "$root"
exit 0
"""

ENDED = "The grader was stopped before it was done, because of a limit on its time or memory."

METADATA, MAX_METADATA = "submission_metadata.json", 50_000_000
"""Gradescope's file about a submission, and a limit on its bytes; it has all earlier results."""


def results_of(report: GradeReport) -> dict[str, Any]:
    """Return the results of a report in Gradescope's format, for JSON.

    They do not contain the time of execution, so that the same agent gets the same results.
    """
    points = f"{report.agent}: {report.points:g} of {report.max_points:g} points"
    return {
        **failed_results("\n".join([report.title, points, *report.remarks])),
        "score": report.points,
        "test_output_format": "text",
        "test_name_format": "text",
        "extra_data": {
            name: getattr(report, name) for name in ("agent", "rubric", "code", "episodes")
        },
        "tests": [_test(number, grade) for number, grade in enumerate(report.grades, 1)],
    }


def failed_results(reason: str) -> dict[str, Any]:
    """Return the results of a submission that cannot be graded: no points, and the reason."""
    return {
        "score": 0, "output": reason, "output_format": "text", "visibility": "visible",
        "stdout_visibility": "hidden", "tests": [],
    }  # fmt: skip


def _test(number: int, grade: Grade) -> dict[str, Any]:
    criterion = grade.criterion
    return {
        "name": criterion.name, "number": str(number), "score": grade.points,
        "max_score": criterion.points, "status": "passed" if grade.is_full else "failed",
        "output": "\n".join(f"{name}: {text}" for name, text in grade.lines),
        "visibility": criterion.visibility,
    }  # fmt: skip


def write_autograder(target: Path, rubric: Rubric) -> None:
    """Write the archive of an autograder for Gradescope; after an error there is no file.

    Raises:
        GradeError: a layout is not in the folder of the rubric, or this package is not installed.
    """
    with atomic_path(target) as part, ZipFile(part, "w", ZIP_DEFLATED) as archive:
        for name, data in _files(rubric):
            member = ZipInfo(name)  # dated 1980, so that the same files give the same archive
            is_script = name in ("setup.sh", "run_autograder")
            member.external_attr = (0o100755 if is_script else 0o100644) << 16
            member.compress_type = ZIP_DEFLATED
            archive.writestr(member, data)


def _files(rubric: Rubric) -> Iterator[tuple[str, bytes]]:
    failed = json.dumps(failed_results(ENDED))
    yield "setup.sh", SETUP.encode()
    yield "run_autograder", RUN.replace("FAILED", failed).encode()
    yield "requirements.txt", "\n".join([*_requirements(), ""]).encode()
    folder = rubric.file.resolve().parent
    for file in dict.fromkeys(map(Path.resolve, rubric.files)):
        if not file.is_relative_to(folder):
            raise GradeError(
                f"{file}: a layout of an autograder must be in the folder of the rubric, {folder}"
            )
        is_rubric = file == rubric.file.resolve()
        yield "rubric.toml" if is_rubric else str(file.relative_to(folder)), file.read_bytes()
    for package in OWN:
        for file in sorted((ROOT / package).rglob("*")):
            if file.is_file() and not {"__pycache__", "handbook"} & {*file.parts}:
                yield f"packages/{file.relative_to(ROOT).as_posix()}", file.read_bytes()


def _requirements() -> list[str]:
    """Return the libraries that this program needs, with their installed versions."""
    try:
        needed = [each for each in requires("warehouse-lab") or () if "extra ==" not in each]
    except PackageNotFoundError:
        raise GradeError("an autograder needs warehouse-lab to be installed with pip") from None
    names = [re.split(r"[^\w-]", each, maxsplit=1)[0] for each in needed]
    return [f"{name}=={version(name)}" for name in names]


def run(root: Path) -> dict[str, Any]:
    """Grade the submission in Gradescope's folder, and return the results.

    Raises:
        WarehouseError: the submission cannot be graded; the message says why.
        OSError: the rubric cannot be read.
    """
    rubric = load_rubric(root / "source" / "rubric.toml")
    folder = (root / "submission").resolve()  # on Gradescope it may be a link
    submission = submission_of([(folder, folder.name)], None)
    if Path(submission.shown).is_absolute():
        submission = submission._replace(shown=str(Path(submission.shown).relative_to(folder)))
    user = NOBODY if os.getuid() == 0 else None
    check_trust(user, is_trusted=False, are_many=False)
    days, note = days_late(root, rubric.late.grace_minutes)
    results = results_of(grade(submission._replace(late=days), rubric, user))
    return results | {"output": "\n".join(filter(None, (results["output"], note)))}


def days_late(root: Path, grace_minutes: float) -> tuple[int, str]:
    """Return the number of days by which a submission is late, and a remark.

    A day that has begun counts, after a grace period. A student's own due date has precedence, and
    the latest one counts for a group. If there are no readable metadata, the submission counts as
    on time, and the remark says why; otherwise it is "".
    """
    try:
        metadata: Any = json.loads(read_file(root / METADATA, MAX_METADATA))
        users = [each["assignment"] for each in metadata.get("users") or () if "assignment" in each]
        own = [each["due_date"] for each in users if each and each.get("due_date")]
        due = own or [metadata["assignment"]["due_date"]]
        if due == [None]:
            return 0, ""
        delay = _time(metadata["created_at"]) - max(map(_time, due))
    except (LookupError, TypeError, AttributeError):
        reason = "it has no time of the submission or no due date"
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or str(error)
    else:
        days = math.ceil((delay - timedelta(minutes=grace_minutes)) / timedelta(days=1))
        return min(max(days, 0), MAX_DAYS), ""
    return 0, f"counted as on time, because {METADATA} is not as expected: {reason}"


def _time(text: str) -> datetime:
    time = datetime.fromisoformat(text)
    if time.tzinfo is None:
        raise ValueError(f"the time {text[:40]!r} has no time zone")
    return time


def main() -> None:
    """Grade the submission in the folder named on the command line, and write the results."""
    root = Path(sys.argv[1]).resolve()
    try:
        results = run(root)
    except (WarehouseError, OSError) as error:
        results = failed_results(f"This submission cannot be graded: {error}")
    except Exception as error:  # whatever happens, there are results
        results = failed_results(f"The grader failed: {type(error).__name__}: {error}")
    with atomic_path(root / "results" / "results.json") as part:
        part.write_text(json.dumps(results, indent=2), encoding="utf-8")


if __name__ == "__main__":
    main()
