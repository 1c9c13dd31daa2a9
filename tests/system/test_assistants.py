"""What assistants, containers and newcomers read first names only what exists."""

import json
import re
import tomllib
from pathlib import Path

from typer.main import get_command

import agents
import warehouse_core
from agents.lab.commands.cli import app

ROOT = Path(__file__).parents[2]
INSTRUCTIONS = (ROOT / ".github/copilot-instructions.md").read_text(encoding="utf-8")


def test_the_list_of_pages_names_every_page_of_the_handbook() -> None:
    text = (ROOT / "agents/handbook/llms.txt").read_text(encoding="utf-8")
    listed = set(re.findall(r"\(([a-z_/]+)\.html\)", text))
    pages = {page.stem for page in (ROOT / "agents/handbook").glob("*.md")}
    assert listed == pages - {"index", "coming_from", "promises"} | {"reference/index"}
    conf = (ROOT / "agents/handbook/conf.py").read_text(encoding="utf-8")
    assert 'html_extra_path = ["llms.txt", ' in conf


def test_the_instructions_name_what_exists() -> None:
    for package in (agents, warehouse_core):
        for name in re.findall(rf"`{package.__name__}\.(\w+)", INSTRUCTIONS):
            assert hasattr(package, name)
    files = re.findall(r"`([\w./]+\.md)`", INSTRUCTIONS)
    assert len(files) == 3
    assert all((ROOT / file).is_file() for file in files)
    commands = get_command(app).commands  # type: ignore[attr-defined]
    assert {"run", "race", "compare", "sweep", "grade"} <= commands.keys()
    assert "copilot-instructions.md" in (ROOT / ".github/AGENTS.md").read_text(encoding="utf-8")


def test_the_container_installs_what_the_readme_does() -> None:
    container = json.loads((ROOT / ".devcontainer/devcontainer.json").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert container["postCreateCommand"].endswith("install -e '.[test,student]'")
    test, student = (project["optional-dependencies"][name] for name in ("test", "student"))
    assert "physics" in test[0]
    assert any("[physics]" in each for each in student)
