"""Pages of the Python interface, for mkdocstrings: which names are public, and where they are defined."""

import inspect
from collections.abc import Iterator, Mapping, Sequence
from types import ModuleType

import arramon_client
import arramon_client.environments
from arramon_client import errors
from website.page import Page

SECTION = "Python"

AGENT = ("Agent", "AsyncAgent", "Observation", "Episode", "Answer", "Action")
"""Names of the contract between client and agent, in the order of the page."""

RUNS = (
    "Run", "RunEpisode", "AsyncRun", "AsyncRunEpisode", "RunInfo", "play", "play_async", "Settings", "Outcome",
    "Progress", "AgentFailure", "load_agent", "connect", "Server", "Access", "EmbeddedServer", "embedded_server",
)  # fmt: skip
"""Names for programs that play runs."""

WORLD = "arramon_client.world"

SCORING = ("metrics", "aggregate", "intervals", "paired", "seed_spread", "disclosure")
"""Modules of `arramon_server.scoring`, in the order of the page."""


def pages() -> Sequence[Page]:
    """Return the pages of the Python interface."""
    return (
        _page("agent", "Agent contract", "What an agent receives, and what it must provide.", objects(AGENT)),
        _page("runs", "Runs and episodes", "For programs that bring their own loop, or run the client.", objects(RUNS)),
        _page("environments", "Environments", "For learners: Gymnasium and PettingZoo.", environments()),
        _page(
            "scoring", "Scoring", "From a trajectory to scores, their means and their intervals. Pure functions.",
            {f"arramon_server.scoring.{name}": f"arramon_server.scoring.{name}" for name in SCORING},
        ),
        _page("errors", "Errors", "All errors of the client derive from `ArramonClientError`.", error_classes()),
        _page("world", "World", "Constants of the world, of observations and of actions.", {"world": WORLD}),
    )  # fmt: skip


def objects(names: Sequence[str]) -> Mapping[str, str]:
    """Return the full name of the definition of each public name of `arramon_client`."""
    return {name: _full_name(arramon_client, name) for name in names}


def environments() -> Mapping[str, str]:
    """Return the full name of each public class and function of `arramon_client.environments`."""
    names = arramon_client.environments.__all__
    found = {name: _full_name(arramon_client.environments, name) for name in names}
    order = sorted(found, key=lambda name: (name != "ArraMonEnv", name))
    return {name: found[name] for name in order}


def error_classes() -> Mapping[str, str]:
    """Return the full names of the client's errors, in order of definition."""
    found = {
        name: f"{errors.__name__}.{name}"
        for name, each in vars(errors).items()
        if inspect.isclass(each) and issubclass(each, Exception) and each.__module__ == errors.__name__
    }
    return {**found, **objects([name for name in arramon_client.__all__ if name == "StopRun" and name not in found])}


def public_names() -> Iterator[str]:
    """Yield every public name of `arramon_client` and its environments, by the full name of its definition."""
    for module in (arramon_client, arramon_client.environments):
        yield from (_full_name(module, name) for name in module.__all__)


def _full_name(module: ModuleType, name: str) -> str:
    found = getattr(module, name)
    return (
        f"{getattr(found, '__module__', None) or module.__name__}.{name}"
        if callable(found)
        else _constant(module, name)
    )


def _constant(module: ModuleType, name: str) -> str:
    """Return the full name of a constant, which is of the module that it was imported from."""
    tree = inspect.getsource(module)
    for line in tree.split("\n"):
        words = line.split()
        if words[:1] == ["from"] and name in line.partition(" import ")[2].replace(",", " ").split():
            return f"{words[1]}.{name}"
    return f"{module.__name__}.{name}"


def _page(name: str, title: str, about: str, found: Mapping[str, str]) -> Page:
    blocks = "\n".join(f"::: {full}\n" for full in found.values())
    return Page(f"reference/api/{name}.md", SECTION, title, f"# {title}\n\n{about}\n\n{blocks}")
