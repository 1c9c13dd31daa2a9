import os
import sys
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import in_a_process
from helpers.networks import random_network

import agents
from agents.errors import AgentError
from agents.learning.policy_network import PolicyNetwork
from agents.learning.ppo_agent import PPOAgent
from agents.learning.q_learning import QTable
from agents.learning.q_table import save_table
from agents.registry import TRAINED, agent_module, is_own_code, make_agent
from agents.registry import agent_file as find_agent_file
from agents.search.agents import ExploringAgent, SearchAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import DEFAULT_LAYOUT, Layout, WarehouseEnv, record_episode

METHODS = """
    def reset(self):
        pass

    def act(self, observation):
        return "WAIT"
"""
WITH_SEED = f"class Mine:\n    def __init__(self, seed=None):\n        self.seed = seed\n{METHODS}"
WITHOUT_SEED = f"class Mine:\n{METHODS}"


@pytest.fixture
def agent_file(tmp_path: Path) -> Path:
    """Return the path of a test's agent, in a folder that is not in ``sys.path``."""
    return tmp_path / "my_agent.py"


def refusal(name: str) -> str:
    with pytest.raises(AgentError) as refused:
        make_agent(name, 1)
    return str(refused.value)


def test_a_built_in_agent_is_made_by_its_name_and_its_arguments() -> None:
    agent = make_agent("greedy:memory=20,escape_steps=0", 7)
    assert isinstance(agent, GreedyAgent)
    assert (agent.memory, agent.escape_steps, agent.seed) == (20, 0, 7)
    assert make_agent("greedy").seed is None  # type: ignore[attr-defined]
    assert isinstance(make_agent("exploring"), ExploringAgent)


def test_an_agent_gets_the_layout_the_seed_and_the_arguments_that_it_takes(agent_file) -> None:
    hall = Layout(["######", "#P..D#", "######"])
    searching = make_agent("astar", 7, hall)
    assert isinstance(searching, SearchAgent)
    assert searching.layout is hall
    assert searching.algorithm == "astar"

    def mine(text: str, options: str = "") -> Any:
        agent_file.write_text(text)
        return make_agent(f"{agent_file}:Mine{options}", 7, hall)

    assert mine(WITH_SEED.replace("seed=None", "layout, seed=None")).seed == 7
    fast = WITH_SEED.replace("seed=None", "speed, names=''").replace("seed", "speed")
    assert mine(fast, ":speed=2.5").speed == 2.5
    episode = record_episode(WarehouseEnv(max_steps=3), mine(WITHOUT_SEED), seed=1)
    assert episode.actions == ["WAIT"] * 3


@pytest.mark.parametrize("name", ["agent.py", "helper.py"])
def test_a_file_that_is_written_again_within_a_second_is_read_again(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (tmp_path / "agent.py").write_text("from helper import Mine\n")
    for seed in (1, 2):
        (tmp_path / name).write_text(WITH_SEED + f"\nMine.number = {seed}\n")
        os.utime(tmp_path / name, (1, 1))
        agent: Any = make_agent(f"{tmp_path / 'agent.py'}:Mine", 7)
        assert agent.number == seed
    assert not sys.dont_write_bytecode
    assert not (tmp_path / "__pycache__").exists()


def test_an_agent_may_come_from_a_module(agent_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(agent_file.parent)
    (agent_file.parent / "my_robots").mkdir()
    (agent_file.parent / "my_robots" / "slow.py").write_text(WITH_SEED)
    agent = make_agent("my_robots.slow:Mine", 3)
    assert agent.seed == 3  # type: ignore[attr-defined]
    assert make_agent("agents.warehouse_agent_greedy:GreedyAgent", 3)


@pytest.mark.parametrize("name", ["random", "q"])
def test_a_file_may_be_called_like_a_module_or_a_trained_agent(tmp_path: Path, name: str) -> None:
    known = sys.modules.get(name)
    (tmp_path / f"{name}.py").write_text(WITH_SEED)
    assert make_agent(f"{tmp_path / name}.py:Mine", 5).seed == 5  # type: ignore[attr-defined]
    assert sys.modules.get(name) is known


def test_an_agent_may_be_a_dataclass(agent_file: Path) -> None:
    # ``dataclass`` looks its module up in ``sys.modules``.
    agent_file.write_text(
        "from __future__ import annotations\n"
        "from dataclasses import dataclass\n"
        "from typing import ClassVar\n\n"
        "@dataclass\n"
        "class Mine:\n"
        "    seed: int | None = None\n"
        "    words: ClassVar[list[str]] = []\n"
        f"{METHODS}"
    )
    assert make_agent(f"{agent_file}:Mine", 5).seed == 5  # type: ignore[attr-defined]


KINDS = "bfs, ucs, greedy-best-first, astar, weighted-astar"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "clever",
            f"no agent is called 'clever'; allowed: random, reflex, model, goal, utility, "
            f"greedy, exploring, {KINDS}, clone:FILE, drive:FILE, ppo:FILE, q:FILE, or your own as "
            "file.py, file.py:Class or module:Class",
        ),
        ("", "no agent is called ''*"),
        *((word, f"no agent is called '{word}'*") for word in TRAINED),
        *((f"{word}:", f"agent '{word}:' names no file; allowed: {word}:FILE") for word in TRAINED),
        (
            "no_such_module_anywhere:Mine",
            "cannot import agent module 'no_such_module_anywhere': "
            "No module named 'no_such_module_anywhere'",
        ),
        (":Mine", "'' is neither a .py file nor the name of a module"),
        (".relative:Mine", "'.relative' is neither a .py file nor the name of a module"),
        ("two words:Mine", "'two words' is neither a .py file nor the name of a module"),
        (
            "greedy:memori=3",
            "agent 'greedy' takes no argument 'memori'; allowed: memory=VALUE, escape_steps=VALUE",
        ),
        ("greedy:seed=3", "agent 'greedy' takes no argument 'seed'; *"),
        ("astar:algorithm='bfs'", "agent 'astar' takes no argument 'algorithm'; *"),
        ("reflex:memory=3", "agent 'reflex' takes no argument 'memory'; allowed: chance=VALUE"),
        ("greedy:memory=-1", "agent 'greedy:memory=-1': memory is -1; it must be at least 0"),
        ("greedy:memory=x", "agent 'greedy:memory=x': memory is 'x'; it must be an integer"),
        ("astar:cost=money", "agent 'astar:cost=money': cost is 'money'; allowed: *"),
    ],
)
def test_a_name_that_stands_for_no_agent_is_an_error_that_says_why(name: str, message: str) -> None:
    assert fnmatchcase(refusal(name), message)


def test_a_missing_file_is_named(agent_file: Path) -> None:
    assert refusal(f"{agent_file}:Mine") == f"agent file {agent_file}: there is no such file"
    agent_file.mkdir()
    assert refusal(f"{agent_file}:Mine") == f"agent file {agent_file}: it is a folder, not a file"


CLASS = "class Mine:\n    "


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        (WITHOUT_SEED, "Other", "{file} has no class 'Other'"),
        (WITHOUT_SEED, "", "{file} has no class ''"),
        ("number = 3\n", "number", "{file} has no class 'number'"),
        (f"{CLASS}def act(self, view): pass", "Mine", "'{file}:Mine' has no reset; needed: reset"),
        (f"{CLASS}pass", "Mine", "class '{file}:Mine' has no reset and no act; needed: reset and "),
        (f"{CLASS}reset = act = 3", "Mine", "class '{file}:Mine' has no reset and no act; needed"),
        (WITH_SEED.replace("seed=None", "speed"), "Mine", "cannot be made: TypeError: "),
        (WITH_SEED.replace("seed=None", "speed"), "Mine", "'speed'"),
        ("x = 1\nclass Mine(:\n    pass\n", "Mine", "{file}, line 2: invalid syntax"),
        ("\xff\xfe\x00", "Mine", "{file}"),
        ("import no_such_module_anywhere\n", "Mine", "cannot import agent file {file}: "),
        ("import no_such_module_anywhere\n", "Mine", "no_such_module_anywhere"),
        ("x = 1\n1 / 0\n", "Mine", "by zero (my_agent.py, line 2)"),
        ("x = 1\nraise SystemExit(2)\n", "Mine", "agent file {file}: SystemExit: 2 ("),
    ],
)
def test_a_file_without_such_an_agent_is_named(agent_file, text, name, message) -> None:
    agent_file.write_bytes(text.encode("latin-1"))
    assert message.format(file=agent_file) in refusal(f"{agent_file}:{name}")


def test_a_file_with_one_agent_needs_no_class(agent_file: Path) -> None:
    own = WITH_SEED.replace("class Mine", "class Base(dict): pass\n\nclass Mine")
    agent_file.write_text(f"from agents import GreedyAgent\n{own}")
    assert type(make_agent(str(agent_file), 3)).__name__ == "Mine"
    assert find_agent_file(f"{agent_file}:speed=2") == find_agent_file(str(agent_file))
    assert find_agent_file(str(agent_file)) == agent_file
    assert agent_module(str(agent_file)) is None
    agent_file.write_text(f"{own}\nclass Yours(Mine): pass\n")
    line = f"{agent_file} has 2 classes with reset and act (Mine, Yours); name one as file.py:Class"
    assert refusal(str(agent_file)) == line


def test_an_agent_imports_the_modules_beside_its_file(tmp_path: Path) -> None:
    for folder, word in (("one", "N"), ("two", "S")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "helper.py").write_text(f"WORD = {word!r}\n")
        file = tmp_path / folder / "mine.py"
        file.write_text("from helper import WORD\n" + WITHOUT_SEED.replace('"WAIT"', "WORD"))
    observation = WarehouseEnv().reset()
    for folder, word in (("one", "N"), ("two", "S")):
        assert make_agent(f"{tmp_path / folder / 'mine.py'}:Mine").act(observation) == word
    (tmp_path / "one" / "helper.py").write_text("WORD = 'WAIT'\n")
    assert make_agent(f"{tmp_path / 'one' / 'mine.py'}:Mine").act(observation) == "WAIT"


def test_a_file_with_the_name_of_this_package_is_named(agent_file: Path, monkeypatch) -> None:
    hidden = agent_file.with_name("agents.py")
    hidden.write_text("WORD = 'N'\n")
    agent_file.write_text("from agents import WORD\n")
    advice = (
        f"'agents' is the package of this program, so {hidden} cannot be imported: "
        "give it another name"
    )
    assert refusal(f"{agent_file}:Mine").endswith(advice)
    monkeypatch.chdir(agent_file.parent)
    assert refusal("agents.mine:Mine").endswith(advice)


@pytest.mark.parametrize(
    ("name", "own", "module"),
    [
        ("greedy", False, None),
        ("greedy:memory=3", False, None),
        ("q:table.npz", False, None),
        ("folder/mine.py:Mine", True, None),
        ("mine.py:Mine:speed=2", True, None),
        ("greedy:Mine", True, "greedy"),  # a class in a module of that name
        ("robots.slow:Mine:speed=2", True, "robots.slow"),
    ],
)
def test_a_name_says_whether_its_code_is_a_users_and_which_module_has_it(name, own, module) -> None:
    assert (is_own_code(name), agent_module(name)) == (own, module)


# Trained agents.


@pytest.fixture
def network_file(tmp_path: Path) -> Path:
    path = tmp_path / "model.npz"
    random_network(1).save(path)
    return path


@pytest.fixture
def table_file(tmp_path: Path) -> Path:
    path = tmp_path / "table.npz"
    table = QTable({((1, 1), (1, 3), False): [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]})
    save_table(table, DEFAULT_LAYOUT, path)
    return path


def test_arguments_follow_the_file_of_a_trained_agent(tmp_path: Path) -> None:
    folder = tmp_path / "rate=0.1"
    folder.mkdir()
    file = folder / "a:b.npz"
    random_network(1).save(file)
    name = f"ppo:{file}:revisit=4,sample=True"
    agent = make_agent(name, 7)
    assert isinstance(agent, PPOAgent)
    assert (agent.revisit, agent.samples) == (4, True)
    observation = WarehouseEnv().reset()
    expected = PPOAgent(PolicyNetwork.load(file), seed=7, sample=True).act(observation)
    assert agent.act(observation) == expected
    assert find_agent_file(name) == find_agent_file(f"ppo:{file}") == file
    assert not is_own_code(name)
    assert make_agent(f"ppo:{file}").revisit == 0  # type: ignore[attr-defined]


def test_wrong_arguments_of_a_trained_agent_are_errors(network_file, table_file) -> None:
    name = f"ppo:{network_file}"
    assert refusal(f"{name}:memory=3") == (
        f"agent {name!r} takes no argument 'memory'; allowed: sample=VALUE, revisit=VALUE"
    )
    assert refusal(f"q:{table_file}:revisit=3").endswith(
        "takes no argument 'revisit'; allowed: none"
    )
    for value in ("-1", "often", "True", "1e999"):
        line = refusal(f"{name}:revisit={value}")
        assert line.startswith(f"{network_file}: revisit is ")
        assert line.endswith(("it must be a number", "it must be at least 0 and finite"))
    assert refusal(f"{name}:sample=2") == f"{network_file}: sample is 2; it must be True or False"


@pytest.mark.parametrize("word", TRAINED)
def test_a_trained_agent_needs_a_file(word: str, tmp_path: Path) -> None:
    missing = tmp_path / "missing.npz"
    assert refusal(f"{word}:{missing}") == f"agent file {missing}: No such file or directory"
    os.mkfifo(tmp_path / "pipe")
    others = {"folder": tmp_path, "pipe": tmp_path / "pipe", "device": Path(os.devnull)}
    for kind, other in others.items():
        line = f"agent file {other}: it is a {kind}, not a file"
        assert refusal(f"{word}:{other}") == line


def test_the_package_exports_the_agents() -> None:
    assert agents.__all__ == sorted(agents.__all__)
    for name in agents.__all__:
        assert getattr(agents, name).__name__ == name
    with pytest.raises(AttributeError, match="module 'agents' has no attribute 'Nobody'"):
        _ = agents.Nobody


def test_importing_the_package_imports_no_agent(tmp_path: Path) -> None:
    program = "import sys, agents; print([name for name in sys.modules if 'agents.' in name])"
    assert in_a_process("-c", program, folder=tmp_path).out == "[]\n"
