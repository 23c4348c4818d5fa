"""Loading of agents: names, constructor arguments, and error messages."""

import pickle
import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from arramon_client import AgentLoadError, load_agent
from arramon_client.plugin import loader
from arramon_client.plugin.agent_files import agent_label

GOOD = """
class Agent:
    def begin(self, episode): pass
    def act(self, observations): return [0] * len(observations)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A separate working directory; modules imported from it are unloaded afterwards."""
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
    (GOOD + "    end = None", "mine_a"),
    (GOOD + "    def end(self, of, *more, cause=''): pass", "mine_a"),
    (GOOD + "    end = print", "mine_a"),
])  # fmt: skip
def test_agents_load_by_module_class_factory_or_instance(folder: Path, source: str, spec: str) -> None:
    (folder / "mine_a.py").write_text(source)
    assert load_agent(spec).act([]) == []


MINE = GOOD.replace("class Agent", "class Mine")
BEAM = MINE + "    def __init__(self, beam=1): self.beam = beam\n"


@pytest.mark.parametrize(("source", "chosen"), [
    ("from arramon_agents.stop import Agent\n" + MINE, "Mine"),
    ("from arramon_client import Agent\n" + MINE.replace("Mine", "Mine(Agent)"), "Mine"),
    ("class Settings: pass\nclass Agent: pass\n" + MINE, "Mine"),
    (GOOD.replace("Agent", "Base") + "class Mine(Base): pass", "Mine"),
    (GOOD.replace("Agent", "_Hidden") + MINE, "Mine"),
    ("import abc\n" + GOOD.replace("Agent", "Base(abc.ABC)") + "    @abc.abstractmethod\n    def m(self): ...\n" + MINE,
     "Mine"),
    (GOOD + MINE, "Agent"),
    ("from arramon_agents.stop import Agent as Stop\n" + MINE, "Mine"),
    (f"import functools\n{BEAM}class Other(Mine): pass\nAgent = functools.partial(Mine, beam=4)", "Mine"),
    (f"{BEAM}class Other(Mine): pass\nclass Lazy:\n    __module__ = 'elsewhere'\n"
     "    def __call__(self): return Mine()\nAgent = Lazy()", "Mine"),
])  # fmt: skip
@pytest.mark.parametrize("spec", ["mine_f", "mine_f.py", "./mine_f.py", "FOLDER/mine_f.py"])
def test_the_modules_own_agent_is_chosen(folder: Path, source: str, chosen: str, spec: str) -> None:
    """Not one that it imports, and no class that is no agent."""
    (folder / "mine_f.py").write_text(source)
    assert type(load_agent(spec.replace("FOLDER", str(folder)))).__name__ == chosen


def test_an_imported_agent_is_played_where_it_is_named(folder: Path) -> None:
    (folder / "mine_g.py").write_text("from arramon_agents.stop import Agent\n" + MINE)
    for spec in ("mine_g:Agent", "mine_g.py:Agent"):
        assert type(load_agent(spec)).__module__ == "arramon_agents.stop"


@pytest.mark.parametrize(("name", "spec"), [
    ("mine_h.py", "mine_h.py:Mine"), ("team/mine_h.py", "team/mine_h.py:Mine"),
    ("team/my-agent.py", "./team/my-agent.py"), ("team/random.py", "team/random.py"),
    ("हिन्दी/a b.py", "हिन्दी/a b.py:Mine"),
])  # fmt: skip
def test_files_are_agents(folder: Path, name: str, spec: str) -> None:
    """Also where the name is no module's, or that of another one, and with what lies beside them."""
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).with_name("mine_beside.py").write_text("ACTION = 3")
    (folder / name).write_text(
        "import mine_beside, random\nassert random.random\n" + MINE.replace("[0]", "[mine_beside.ACTION]")
    )
    assert load_agent(spec).act([None]) == [3]  # type: ignore[list-item]


def test_a_file_is_known_by_its_module(folder: Path) -> None:
    """So that what it holds can be pickled, and is named without the folder."""
    (folder / "mine_i.py").write_text(MINE)
    agent = load_agent(str(folder / "mine_i.py"))
    assert pickle.loads(pickle.dumps(agent)).__class__ is type(agent)
    assert load_agent("mine_i").__class__ is type(agent)
    assert [agent_label(spec) for spec in ("/home/me/mine_i.py", "a/mine_i.py:Mine", "a.py:Agent", "m:Agent", "m")] == [
        "mine_i", "mine_i:Mine", "a", "m", "m",
    ]  # fmt: skip


def test_agents_load_from_packages_in_the_working_directory(folder: Path) -> None:
    (folder / "team").mkdir()
    (folder / "team" / "vl.py").write_text(GOOD)
    assert type(load_agent("team.vl")).__name__ == "Agent"


def test_an_agent_hidden_by_an_installed_package_is_found_by_its_file(
    folder: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As Python prefers a package to a folder that has no `__init__.py`."""
    installed = tmp_path_factory.mktemp("installed")
    for path in (folder / "team_b" / "mine_j.py", installed / "team_b" / "__init__.py"):
        path.parent.mkdir()
        path.write_text(GOOD)
    monkeypatch.setattr(sys, "path", [*sys.path, str(installed)])
    said = rf"The file team_b/mine_j.py is hidden by the package in {installed}/team_b: name it as ./team_b/mine_j.py\."
    with pytest.raises(AgentLoadError, match=said):
        load_agent("team_b.mine_j")
    assert load_agent("./team_b/mine_j.py").act([]) == []


def test_agents_load_by_entry_point(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "mine_b.py").write_text(GOOD)
    entry = EntryPoint(name="fancy", value="mine_b:Agent", group=loader.ENTRY_POINTS)
    monkeypatch.setattr(loader, "entry_points", lambda group: [entry] if group == "arramon.agents" else [])
    assert type(load_agent("fancy")).__name__ == "Agent"
    with pytest.raises(AgentLoadError, match=r"Did you mean fancy\?"):
        load_agent("fanci")


@pytest.mark.parametrize(("source", "spec", "said", "details"), [
    (GOOD, "mine_d", "no agent 'mine_d': there is no module mine_d installed", ""),
    (GOOD, "agents.stopp", "no module agents.stopp in the package agents. Did you mean agents.stop?", ""),
    (GOOD, "mine_d.py", "there is no file FOLDER/mine_d.py. Did you mean mine_c.py?", ""),
    (GOOD, "./team/vl.py", "there is no file FOLDER/team/vl.py.", ""),
    (GOOD, "./team/vl", "A file's name ends in .py; name a package as a module, e.g. --agent team.vl", ""),
    (GOOD, "mine_c:", "neither a module, a file, a module:Class nor an entry point", ""),
    (GOOD, "mine_c.py:", "neither a module, a file, a module:Class nor an entry point", ""),
    (GOOD, "", "neither a module, a file, a module:Class nor an entry point", ""),
    (GOOD, "mine_c.py:Agnet", "mine_c has no Agnet. Did you mean Agent?", ""),
    ("import no_such_dependency", "mine_c.py", "imports no_such_dependency, which is neither installed nor in FOLDER",
     "import no_"),
    ("def (", "./mine_c.py", "the file FOLDER/mine_c.py cannot be imported", "SyntaxError"),
    (GOOD.replace("Agent", "One") + GOOD.replace("Agent", "Two"), "mine_c",
     "has several agents: name one, as in --agent mine_c:One (:One, :Two)", ""),
    ("from arramon_agents.stop import Agent", "mine_c",
     "Its Agent is imported from arramon_agents.stop: to play with it, write", ""),
    (GOOD, "mine_c:Agnet", "mine_c has no Agnet. Did you mean Agent?", ""),
    ("import no_such_dependency", "mine_c", "it imports no_such_dependency, which is not installed", "import no_"),
    ("x = 1\nx.y", "mine_c", "its module mine_c cannot be imported", "AttributeError: 'int' object has no attribute"),
    ("def (", "mine_c", "cannot be imported", "SyntaxError"),
    ("raise SystemExit(3)", "mine_c", "cannot be imported", "SystemExit: 3"),
    ("x = 1", "mine_c", "has neither a class Agent nor a function make_agent()", ""),
    ("from arramon_client import Agent", "mine_c", "has neither a class Agent", ""),
    ("class Mine: pass", "mine_c", "another class with begin and act; without these methods: Mine.", ""),
    ("x = 1", "mine_c:x", "1 is neither an agent nor a class or function that returns one", ""),
    ("class Agent:\n    def __init__(self): open('weights.pt')", "mine_c", "Agent() raised FileNotFoundError",
     "open('weights.pt')"),
    ("class Agent:\n    def __init__(self, path): pass", "mine_c",
     "Agent() requires the argument 'path': add --agent-arg path=VALUE", ""),
    ("def make_agent(path, /): pass", "mine_c", "make_agent() requires 'path', which cannot be given by name", ""),
    ("class Agent:\n    def act(self, o): pass", "mine_c", "Agent has no method begin(episode)", ""),
    ("class Agent: pass", "mine_c", "no method begin(episode) and no method act(observations)", ""),
    (GOOD + "    def end(self): pass", "mine_c",
     "Agent has end(); expected a method that can be called as end(episode_id), or none", ""),
    (GOOD + "    def end(self, one, cause): pass", "mine_c", "Agent has end(one, cause); expected a method", ""),
    (GOOD + "    def end(self, *, episode_id): pass", "mine_c", "Agent has end(*, episode_id); expected a method", ""),
    (GOOD + "    async def end(self, episode_id): pass", "mine_c", "Agent.end is a coroutine function (async def)", ""),
    (GOOD + "    end = 3", "mine_c", "Agent.end is int 3; expected a method end(episode_id), or none", ""),
])  # fmt: skip
def test_loading_errors_show_only_the_agents_own_frames(
    folder: Path, source: str, spec: str, said: str, details: str
) -> None:
    (folder / "mine_c.py").write_text(source)
    with pytest.raises(AgentLoadError) as caught:
        load_agent(spec)
    assert said.replace("FOLDER", str(folder)) in str(caught.value)
    assert details in caught.value.details
    assert "arramon_client" not in caught.value.details
    assert "importlib" not in caught.value.details
    assert bool(caught.value.details) == bool(details)


TAKES = """
class Agent:
    def __init__(self, checkpoint, beam=1, **more):
        self.given = (checkpoint, beam, more)
    def begin(self, episode): pass
    def act(self, observations): return []
class Strict(Agent):
    def __init__(self, checkpoint, *, beam=1):
        super().__init__(checkpoint, beam)
        if beam > 9: raise ValueError("too wide")
def make(checkpoint="none", beam=2): return Strict(checkpoint, beam=beam)
ready = make()
"""


@pytest.mark.parametrize(("spec", "arguments", "given"), [
    ("mine_e", {"checkpoint": "w.pt", "beam": 4}, ("w.pt", 4, {})),
    ("mine_e", {"checkpoint": "w.pt", "other": [1]}, ("w.pt", 1, {"other": [1]})),
    ("mine_e:Strict", {"beam": 4, "checkpoint": None}, (None, 4, {})),
    ("mine_e:make", {"beam": 4}, ("none", 4, {})),
    ("mine_e:make", {}, ("none", 2, {})),
    ("mine_e:ready", {}, ("none", 2, {})),
])  # fmt: skip
def test_arguments_reach_the_constructor(
    folder: Path, spec: str, arguments: dict[str, object], given: tuple[object, ...]
) -> None:
    (folder / "mine_e.py").write_text(TAKES)
    assert load_agent(spec, arguments).given == given  # type: ignore[attr-defined]


@pytest.mark.parametrize(("spec", "arguments", "said"), [
    ("mine_e", {}, "Agent() requires the argument 'checkpoint': add --agent-arg checkpoint=VALUE"),
    ("mine_e:Strict", {"checkpoint": "w", "baem": 4},
     "Strict() has no argument 'baem'; its arguments: checkpoint, beam. Did you mean beam?"),
    ("mine_e:Strict", {"checkpoint": "w", "beam": 10},
     "Strict(checkpoint='w', beam=10) raised ValueError: too wide"),
    ("mine_e:ready", {"beam": 4}, "it is an instance, and accepts no --agent-arg"),
])  # fmt: skip
def test_arguments_that_do_not_match_the_signature_are_refused(
    folder: Path, spec: str, arguments: dict[str, object], said: str
) -> None:
    (folder / "mine_e.py").write_text(TAKES)
    with pytest.raises(AgentLoadError) as caught:
        load_agent(spec, arguments)
    assert said in str(caught.value)
