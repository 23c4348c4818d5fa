"""Train agents: `arramon-train --agent vl --lang en,hi`, or `--all` for every trained agent."""

import argparse
import shutil
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from arramon_agents.perception.encoder import FOLDER
from arramon_agents.requirements import REQUIRED_AT_PLAY, require
from arramon_agents.training.option_help import option_help
from arramon_agents.training.workspace import CHECKPOINT_STEPS, Workspace
from arramon_client.errors import ArramonClientError, UsageError
from arramon_client.stopping import describe, status_of, stopped_by_signals

PACKAGES = ("reading.reader", "vl", "vl_grounded", "vl_map", "reading", "perception.eyes")
"""Packages with a training; each has a module `recipe` (`RECIPES`, `smoke`) and a module `train` (`train`)."""

NOT_IN_ALL = ("reader_tuning", "sentencepiece", "eyes")
"""Trainings that `--all` skips: the agents are trained with the shipped results of these."""

LANGUAGES = {"languages": "--lang", "aligned": "--align-lang"}
"""Options with comma-separated languages, by recipe field."""

FIELDS_WITHOUT_OPTION = ("agent", "sees", "reads")
"""Recipe fields without an option."""

NEEDED = (*REQUIRED_AT_PLAY, "sentencepiece", "tensorboardX", "gymnasium")


@dataclass(frozen=True)
class Training:
    """Training of one agent.

    Attributes:
        package: package with the modules `recipe` and `train`.
        recipe: recipe of the agent, a dataclass of settings.
    """

    package: str
    recipe: Any

    def module(self, name: str) -> Any:
        """Import a module of the package; modules `recipe` do not import torch."""
        return import_module(f"arramon_agents.{self.package}.{name}")


def trainings() -> dict[str, Training]:
    """Return all trainings by the name of the agent, in the order of `--all`."""
    modules = {package: import_module(f"arramon_agents.{package}.recipe") for package in PACKAGES}
    return {name: Training(at, recipe) for at, module in modules.items() for name, recipe in module.RECIPES.items()}


def main(arguments: list[str] | None = None) -> int:
    """Run the command.

    Returns:
        Exit status: 0 success, 1 error, 2 usage; 128 plus the signal's number after Ctrl-C (130), SIGTERM (143) or
        SIGHUP (129).
    """
    with stopped_by_signals():
        return _run(arguments)


def _run(arguments: list[str] | None) -> int:
    known = trainings()
    parser = _parser(known)
    given = parser.parse_args(arguments)
    if not given.agent and not given.all:
        parser.error("name an agent with --agent, or take all with --all")
    names = [name for name in known if name not in NOT_IN_ALL] if given.all else given.agent.split(",")
    unknown = [name for name in names if name not in known]
    if unknown:
        parser.error(f"there is no recipe {unknown[0]!r}; there are {', '.join(known)}")
    try:
        require(NEEDED, "training", extra="training")
        workspace = _workspace(given)
        recipes = {name: _recipe(name, known[name], given, _options(known)) for name in names}
        for name, recipe in recipes.items():
            weights = known[name].module("train").train(recipe, workspace, _report)
            _report(f"{name}: in {weights or workspace.output}")
            if given.ship and weights:
                _ship(name, known[name].package, weights)
    except (ArramonClientError, ValueError) as error:
        _report(f"error: {error}")
        return 1
    except KeyboardInterrupt as stop:
        _report(f"{describe(stop)}: the same command resumes the training")
        return status_of(stop)
    return 0


def _recipe(name: str, training: Training, given: argparse.Namespace, options: Iterable[str]) -> Any:
    """Return an agent's recipe with the given options.

    Args:
        name: name of the agent.
        training: training with the default recipe.
        given: values of the options.
        options: fields of all recipes.

    Raises:
        ValueError: if the recipe does not have a given option, unless all agents are trained.
    """
    recipe = training.module("recipe").smoke(training.recipe) if given.smoke else training.recipe
    chosen = {option: value for option in options if (value := getattr(given, option)) is not None}
    if given.visual:
        if given.encoder:
            raise ValueError("--visual and --encoder both name what sees: give one of them")
        chosen["encoder"] = f"{FOLDER}{given.visual}"
    own = {each.name for each in fields(recipe)}
    other = sorted(set(chosen) - own)
    if other and not given.all:
        raise ValueError(
            f"{name} has no option {'--visual' if given.visual and other[0] == 'encoder' else _flag(other[0])}"
        )
    return replace(recipe, **{option: value for option, value in chosen.items() if option in own})


def _workspace(given: argparse.Namespace) -> Workspace:
    """Return the workspace with the given folders, processes and device.

    Raises:
        UsageError: if torch cannot use the device.
    """
    import torch

    device = given.device
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError) as error:  # An AssertionError if torch was built without CUDA.
        reason = str(error).partition("\n")[0]
        raise UsageError(
            f"--device {device} cannot be used: {reason}; expected auto, cpu, or cuda with a GPU"
        ) from error
    return Workspace(given.data, given.cache, given.output, given.processes, given.checkpoint_steps, device)


def _ship(name: str, package: str, weights: Path) -> None:
    """Copy weights, and the model card if there is one, to the folder of the agent or of its package."""
    from arramon_agents.weights import CARD, SHIPPED, SUFFIX, WEIGHTS

    own = SHIPPED / name
    folder = own if own.is_dir() else SHIPPED.joinpath(*package.split("."))
    has_own_name = weights.suffix != SUFFIX or (folder / weights.name).exists()  # The visual encoder has two files.
    shutil.copyfile(weights, folder / (weights.name if has_own_name else WEIGHTS))
    if weights.with_suffix(".md").exists():
        shutil.copyfile(weights.with_suffix(".md"), folder / CARD)


def _parser(known: Mapping[str, Training]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="arramon-train", description="Train agents, and what they see and read with.")
    parser.add_argument("--agent", help=f"what to train, separated by commas: {', '.join(known)}")
    parser.add_argument("--all", action="store_true", help=f"train all of them but {', '.join(NOT_IN_ALL)}")
    parser.add_argument(
        "--ship",
        action="store_true",
        help="replace the installed weights and model cards by the new ones: in a clone, files under `agents`",
    )
    parser.add_argument("--smoke", action="store_true", help="take seconds: a few episodes, a few updates")
    parser.add_argument("--data", type=Path, default=Path("arramon-data"), help="data folder (default: %(default)s)")
    parser.add_argument(
        "--cache",
        type=Path,
        default=Path("arramon-cache"),
        help="folder of rendered demonstrations, shared by all trainings (default: %(default)s)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("arramon-weights"),
        help="folder of weights, model cards, checkpoints and logs (default: %(default)s)",
    )
    parser.add_argument(
        "--processes",
        type=int,
        default=1,
        help="processes that render demonstrations and simulate walks (default: %(default)s)",
    )
    parser.add_argument(
        "--device",
        default="auto",
        help="device of the updates: cpu, cuda, or auto, a GPU if there is one (default: auto)",
    )
    parser.add_argument(
        "--checkpoint-steps",
        type=int,
        default=CHECKPOINT_STEPS,
        help="updates between two checkpoints (default: %(default)s)",
    )
    parser.add_argument("--visual", type=Path, help="folder of a vision model of transformers, instead of --encoder")
    for name, (kind, agents) in _options(known).items():
        shown = option_help(name, {agent: known[agent].recipe for agent in agents})
        parser.add_argument(LANGUAGES.get(name, _flag(name)), dest=name, type=kind, help=shown)
    return parser


def _options(known: Mapping[str, Training]) -> dict[str, tuple[Any, list[str]]]:
    """Return the options of all recipes by field: the parser of their values, and the agents that have them."""
    options: dict[str, tuple[Any, list[str]]] = {}
    for name, training in known.items():
        for each in fields(training.recipe):
            if each.name not in FIELDS_WITHOUT_OPTION:
                kind = _languages if each.name in LANGUAGES else type(getattr(training.recipe, each.name))
                options.setdefault(each.name, (kind, []))[1].append(name)
    return options


def _languages(value: str) -> tuple[str, ...]:
    return tuple(value.split(","))


def _flag(name: str) -> str:
    return LANGUAGES.get(name, f"--{name.replace('_', '-')}")


def _report(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
