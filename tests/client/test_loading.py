"""Loading agents: what can be named, and what an author is told when it cannot be loaded."""

import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from arramon_client import AgentLoadError, load_agent, loading

GOOD = """
class Agent:
    def begin(self, episode): pass
    def act(self, observations): return [0] * len(observations)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working directory of its own; what is imported from it is forgotten."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path])
    known = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - known:
        del sys.modules[name]


@pytest.mark.parametrize(("source", "spec"), [
    (GOOD, "mine_a"),
    (GOOD, "mine_a:Agent"),
    (GOOD.replace("class Agent", "class Other") + "def make_agent(): return Other()", "mine_a"),
    (GOOD.replace("class Agent", "class Other") + "def build(): return Other()", "mine_a:build"),
    (GOOD + "ready = Agent()", "mine_a:ready"),
    (GOOD + "class Box:\n    Inner = Agent", "mine_a:Box.Inner"),
    ("from arramon_client import Agent\n" + GOOD.replace("Agent", "Other") + "make_agent = Other", "mine_a"),
])  # fmt: skip
def test_what_can_be_named(folder: Path, source: str, spec: str) -> None:
    (folder / "mine_a.py").write_text(source)
    assert load_agent(spec).act([]) == []


def test_a_module_in_a_package_of_the_working_directory(folder: Path) -> None:
    (folder / "team").mkdir()
    (folder / "team" / "vl.py").write_text(GOOD)
    assert type(load_agent("team.vl")).__name__ == "Agent"


def test_an_installed_name(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "mine_b.py").write_text(GOOD)
    entry = EntryPoint(name="fancy", value="mine_b:Agent", group=loading.ENTRY_POINTS)
    monkeypatch.setattr(loading, "entry_points", lambda group: [entry] if group == "arramon.agents" else [])
    assert type(load_agent("fancy")).__name__ == "Agent"
    with pytest.raises(AgentLoadError, match=r"Did you mean fancy\?"):
        load_agent("fanci")


@pytest.mark.parametrize(("source", "spec", "said", "details"), [
    (GOOD, "mine_d", "no agent 'mine_d': there is no module mine_d installed", ""),
    (GOOD, "agents.stopp", "no module agents.stopp in the package agents. Did you mean agents.stop?", ""),
    (GOOD, "mine_c.py", "Give it as a module, such as --agent mine_c", ""),
    (GOOD, "./team/vl.py", "such as --agent team.vl", ""),
    (GOOD, "mine_c:", "neither a module, a module:Class nor an installed name", ""),
    (GOOD, "", "neither a module, a module:Class nor an installed name", ""),
    (GOOD, "mine_c:Agnet", "mine_c has no Agnet. Did you mean Agent?", ""),
    ("import no_such_dependency", "mine_c", "it needs no_such_dependency, which is not installed", "import no_"),
    ("x = 1\nx.y", "mine_c", "its module mine_c cannot be imported", "AttributeError: 'int' object has no attribute"),
    ("def (", "mine_c", "cannot be imported", "SyntaxError"),
    ("raise SystemExit(3)", "mine_c", "cannot be imported", "SystemExit: 3"),
    ("x = 1", "mine_c", "has neither a class Agent nor a function make_agent()", ""),
    ("from arramon_client import Agent", "mine_c", "has neither a class Agent", ""),
    ("class Mine: pass", "mine_c", "Name one of its classes: mine_c:Mine.", ""),
    ("x = 1", "mine_c:x", "1 is neither an agent nor something to call for one", ""),
    ("class Agent:\n    def __init__(self): open('weights.pt')", "mine_c", "Agent() raised FileNotFoundError",
     "open('weights.pt')"),
    ("class Agent:\n    def __init__(self, path): pass", "mine_c", "it is called without arguments", "'path'"),
    ("class Agent:\n    def act(self, o): pass", "mine_c", "Agent has no method begin(episode)", ""),
    ("class Agent: pass", "mine_c", "no method begin(episode) and no method act(observations)", ""),
])  # fmt: skip
def test_what_an_author_is_told(folder: Path, source: str, spec: str, said: str, details: str) -> None:
    (folder / "mine_c.py").write_text(source)
    with pytest.raises(AgentLoadError) as caught:
        load_agent(spec)
    assert said in str(caught.value)
    assert details in caught.value.details
    assert "arramon_client" not in caught.value.details
    assert "importlib" not in caught.value.details
    assert bool(caught.value.details) == bool(details)
