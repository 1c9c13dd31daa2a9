"""Every kind of page and picture is legible on a desktop, a phone and paper, and meets WCAG."""

from base64 import b64encode
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import in_a_process
from helpers.handbook import SITE
from helpers.looks import SCREENS, SHEET, Reader, reading
from helpers.results_files import BAD, GOOD, scores_of

from agents.lab.training.curve import learning_curve
from agents.lab.training.exams import ExamPoint
from warehouse_core.viz.figure import make_figure, save_svg

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def reader(browser: Any) -> Iterator[Reader]:
    """Yield a reader that looks at pages."""
    with reading(browser) as one:
        yield one


PAGES = {
    "physics": "run --seed 12 --backend physics",
    "fleet of 50": "fleet --seed 3 --max-steps 40 -r 50 --planner pibt",
    "gap": "compare backends -r 4 --count 4 -n 1 -j 1",
    "plan": "plan -r 8 --layout depot --planner lacam",
    "compare backends": "compare backends --seed 12 --max-steps 40",
    "explore": "run --agent exploring --seed 3 --max-steps 60",
    "search": "compare search",
    "race": "race",
    "demo bump": "demo bump",
    "demo pibt": "demo pibt",
}
"""Commands that save a page, by the content of the page."""

PICTURES = {
    "run": "run --seed 12",
    "fleet": "fleet --seed 3 --max-steps 20",
    "compare backends": "compare backends --seed 12 --max-steps 20",
    "explore": "run --agent exploring --seed 3 --max-steps 30",
    "search": "compare search",
    "race": "race",
    "demo lanes": "demo lanes",
    "compare agents": "compare agents -n 3",
    "compare planners": "compare planners -n 1 -r 32,64 --planner pibt "
    "--planner pibt:guidance=lanes --lifelong 60 -j 1",
}
"""Commands that save a picture as SVG."""


def save(folder: Path, *words: object) -> None:
    """Run a command that saves a file in its own process, because it may start others."""
    done = in_a_process("-m", "agents", *words, folder=folder)
    assert done.code == 0, done.err


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_legible(reader: Reader, tmp_path: Path, name: str) -> None:
    save(tmp_path, *PAGES[name].split(), "--save", "page.html")
    assert reader.faults_of_page(tmp_path / "page.html") == {}


def test_a_report_is_legible(reader: Reader, tmp_path: Path) -> None:
    sets = ["agent=greedy,astar", "battery=20:120:20", "backend=grid,physics"]
    words = [word for each in sets for word in ("--set", each)]
    save(tmp_path, "sweep", *words, "-n", 6, "-j", 1, "--save", "results.sqlite")
    save(tmp_path, "report", "results.sqlite", "--save", "page.html")
    assert reader.faults_of_page(tmp_path / "page.html", [*SCREENS, SHEET]) == {}


def test_pages_of_grades_are_legible(reader: Reader, tmp_path: Path) -> None:
    """The pages are the one of a student, with the worst episode, and the one of the class."""
    (tmp_path / "all").mkdir()
    long_name = "Surname Given Names_12345_assignsubmission_file_"
    for name, body in {"walks": "return 'N'", "fails": "1 / 0", long_name: "pass"}.items():
        methods = "def reset(self): pass", f"def act(self, seen): {body}"
        text = "\n    ".join(["class Agent:", *methods])
        (tmp_path / "all" / f"{name}.py").write_text(text)
    save(tmp_path, "grade", "all", "--trust", "--pages", "pages", "-j", 1)
    for name in ("index", "walks.py"):
        page = tmp_path / "pages" / f"{name}.html"
        assert reader.faults_of_page(page, [*SCREENS, SHEET]) == {}


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_legible(reader: Reader, tmp_path: Path, name: str) -> None:
    save(tmp_path, *PICTURES[name].split(), "--save", "picture.svg")
    assert reader.faults_of_picture(tmp_path / "picture.svg") == {}


def test_a_learning_curve_is_legible(reader: Reader, tmp_path: Path) -> None:
    points = [ExamPoint(60_000 * n, scores_of([GOOD] * n + [BAD] * (5 - n))) for n in range(1, 6)]
    figure = learning_curve("PPO", "PPO learns to deliver", points, scores_of([GOOD, BAD]))
    save_svg(figure, tmp_path / "picture.svg")
    assert reader.faults_of_picture(tmp_path / "picture.svg") == {}


@pytest.mark.parametrize("name", SITE)
def test_the_handbook_is_legible(reader: Reader, site: Path, name: str) -> None:
    assert reader.faults_of_page(site / f"{name}.html") == {}


SMALL_SCREEN = SCREENS[2]


def on_canvas(calls: str) -> str:
    return (
        '<canvas width="300" height="100"></canvas><script>'
        'const context = document.querySelector("canvas").getContext("2d");'
        'const write = (words, x, y, color = "black", font = "14px sans-serif") => {'
        "Object.assign(context, {fillStyle: color, font}); context.fillText(words, x, y); };"
        f"{calls}</script>"
    )


def in_svg(texts: str) -> str:
    return (
        f'<svg width="300" height="100"><rect width="300" height="100" fill="#eee"/>{texts}</svg>'
    )


def by_matplotlib(*texts: tuple[str, float, str, float]) -> str:
    """Return an image of words, each with its place, colour and size in points."""
    figure = make_figure((3, 1))
    figure.patch.set_facecolor("#eee")
    for words, x, color, size in texts:
        figure.text(x, 0.5, words, color=color, fontsize=size)
    file = BytesIO()
    save_svg(figure, file)
    data = b64encode(file.getvalue()).decode()
    return f'<img alt="words" src="data:image/svg+xml;base64,{data}">'


RIGHT = (
    '<p>Words.</p><p style="color: #767676">Quiet.</p><p style="font: 24px serif; '
    'color: #949494">Large.</p><details><summary>More</summary><p>Hidden.</p></details>'
    '<div role="region" aria-label="Long" tabindex="0" style="overflow-x: auto">'
    '<p style="width: 600px">Long.</p></div>',
    on_canvas("write('one', 10, 20); context.clearRect(0, 0, 300, 100); write('other', 10, 20)"),
    in_svg('<text x="10" y="20">one</text><text x="10" y="50">other</text>'),
    by_matplotlib(("one", 0.1, "black", 9), ("other", 0.5, "#666", 9)),
)

WRONG = {
    "small text": '<p style="font-size: 10px">one</p>',
    "pale text": '<p style="color: #777; background: #fefefe">one</p>',
    "pale canvas": on_canvas(
        "context.fillStyle = '#555'; context.fillRect(0, 0, 200, 50); write('one', 10, 20)"
    ),
    "cut text": '<p style="width: 3em; overflow: hidden; white-space: nowrap">one and other</p>',
    "cut canvas": on_canvas("write('one and other', 280, 20)"),
    "overlap text": '<p>one</p><p style="margin: -2em 0 0 1em">other</p>',
    "overlap canvas": on_canvas("write('one', 10, 20); write('other', 20, 25)"),
    "overlap matplotlib": by_matplotlib(("one", 0.1, "black", 9), ("other", 0.15, "black", 9)),
    "sideways page": '<p style="width: 1400px">one</p>',
    "sideways box": '<div style="overflow-x: auto"><p style="width: 600px">one</p></div>',
    "console error": "<p>one</p><script>console.error('one')</script>",
    "wcag picture": '<p>one</p><img src="data:image/gif;base64,R0lGODlhAQABAAAAACw=">',
}


def page_of(folder: Path, body: str) -> Path:
    """Return the file of a page with some elements."""
    path = folder / "page.html"
    head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width">'
    path.write_text(
        f'<!DOCTYPE html><html lang="en"><head>{head}<link rel="icon" href="data:,">'
        f"<title>Page</title></head><body><main>{body}</main></body></html>"
    )
    return path


def test_pages_without_faults_have_none(reader: Reader, tmp_path: Path) -> None:
    for body in RIGHT:
        assert reader.faults_of_page(page_of(tmp_path, body), [SMALL_SCREEN]) == {}


@pytest.mark.parametrize(("name", "body"), WRONG.items(), ids=WRONG)
def test_each_fault_is_found(reader: Reader, tmp_path: Path, name: str, body: str) -> None:
    faults = reader.faults_of_page(page_of(tmp_path, body), [SMALL_SCREEN])
    assert name.split()[0] in {fault.partition(":")[0] for fault in faults}, faults
