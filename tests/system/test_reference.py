"""The reference: each public object is on one page and has an example that runs."""

import doctest
import re
from collections import Counter

import matplotlib.pyplot as plt
import pytest
from helpers.command_line import without_display
from helpers.handbook import HANDBOOK
from helpers.reference import REFERENCE, examples, objects_on, public_objects, sources

EXAMPLES = examples()

NOT_RUN = {
    "agents.learning.clone_training:CloneLearner",
    "agents.learning.drive_training:DriveLearner",
    "agents.learning.ppo_training:PPOLearner",
    "warehouse_core.render.window:PictureWindow",
}
"""Classes whose examples are not run: three need PyTorch, the last one needs a display."""


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs_by_itself(name: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    without_display(monkeypatch)
    report: list[str] = []
    failed, _ = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(
        EXAMPLES[name], out=report.append
    )
    plt.close("all")
    assert not failed, "".join(report)


def test_few_examples_are_not_run() -> None:
    skipped = {
        name
        for name, test in EXAMPLES.items()
        if any(doctest.SKIP in each.options for each in test.examples)
    }
    assert skipped == NOT_RUN


def test_every_class_and_function_has_an_example() -> None:
    described = {each.key: each for each in public_objects() if each.is_described}
    assert [each for each in described.values() if ">>> " not in each.docstring] == []


def test_every_constant_and_alias_is_named_in_an_example() -> None:
    words = {
        word
        for test in EXAMPLES.values()
        for each in test.examples
        for word in re.findall(r"\w+", each.source)
    }
    others = {each.key: each for each in public_objects() if not each.is_described}
    assert [each for each in others.values() if each.name not in words] == []


def test_what_is_returned_begins_with_no_colon_which_would_end_a_type() -> None:
    for path in sources().values():
        for first in re.findall(r"(?:Returns|Yields):\n +(.*)", path.read_text(encoding="utf-8")):
            assert ":" not in re.sub("``.*?``", "", first), f"{path}: {first}"


def test_every_public_object_is_on_one_page_of_the_reference() -> None:
    pages = sorted(REFERENCE.glob("*.md"))
    shown = Counter(each.key for page in pages for each in objects_on(page))
    public = {each.key: each for each in public_objects()}
    assert {each: shown[each.key] for each in public.values() if shown[each.key] != 1} == {}
    assert shown.keys() <= public.keys()


def test_every_page_is_in_the_table_of_contents() -> None:
    listed = (REFERENCE / "index.md").read_text(encoding="utf-8").splitlines()
    pages = {path.stem for path in REFERENCE.glob("*.md")} - {"index"}
    assert [page for page in pages if page not in listed] == []
    assert "\nreference/index\n" in (HANDBOOK / "index.md").read_text(encoding="utf-8")


def test_a_page_names_all_that_its_package_exports() -> None:
    for page in REFERENCE.glob("*.md"):
        names = {each.name for each in objects_on(page)}
        named = {*re.findall(r"`(\w+)`", page.read_text(encoding="utf-8"))}
        for each in public_objects():
            assert each.module != page.stem or each.name in names | named, each
