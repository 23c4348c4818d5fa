"""Train agents: `arramon-train --agent vl --lang en,hi`, or `--all` for every trained agent."""

import argparse
import shutil
import sys
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from arramon_agents.perception.encoder import FOLDER
from arramon_agents.requirements import PLAYING, require
from arramon_agents.vl.recipe import RECIPES, Place, Recipe, smoke
from arramon_client.errors import ArramonClientError

MAP = "vl_map"
"""The agent whose policy is trained in simulated walks, with a recipe of its own kind."""

GROUNDED = "vl_grounded"
"""The agent whose two networks are trained together, with a recipe of its own kind."""

READER = "reader"
"""The learned reader, which agents share: it comes first, as others are trained on what it reads."""

AGENTS = (READER, *RECIPES, GROUNDED, MAP)

OWN_OPTIONS = {
    MAP: ("walks", "rounds", "round_walks", "first", "again"),
    GROUNDED: ("inflection", "versions", "room_versions"),
}
"""Options of one agent alone."""

NEEDED = (*PLAYING, "sentencepiece", "tensorboardX", "gymnasium")


def main(arguments: list[str] | None = None) -> int:
    """Run the command, and return its exit status."""
    parser = _parser()
    given = parser.parse_args(arguments)
    if not given.agent and not given.all:
        parser.error("name an agent with --agent, or take all with --all")
    names = list(AGENTS) if given.all else given.agent.split(",")
    unknown = [name for name in names if name not in AGENTS]
    if unknown:
        parser.error(f"there is no recipe {unknown[0]!r}; there are {', '.join(AGENTS)}")
    try:
        require(NEEDED, "training")
        for name in names:
            if name == READER:
                _train_reader(given)
            elif name == MAP:
                _train_map(given)
            elif name == GROUNDED:
                _train_grounded(given)
            else:
                _train(_recipe(RECIPES[name], given), _place(given), ship=given.ship)
    except (ArramonClientError, ValueError) as error:
        _tell(f"error: {error}")
        return 1
    return 0


def _train(recipe: Recipe, place: Place, *, ship: bool) -> None:
    import torch

    from arramon_agents.process_settings import prepare_process
    from arramon_agents.training.sources import demonstrations_of, train_data_hash
    from arramon_agents.vl.train import Imitation

    prepare_process()
    if place.device == "auto":
        place = replace(place, device="cuda" if torch.cuda.is_available() else "cpu")
    demonstrations = demonstrations_of(recipe, place, _tell)
    training = Imitation(recipe, place, demonstrations, _tell)
    training.policy.about["data_hash"] = train_data_hash(recipe, place)
    size = sum(parameter.numel() for parameter in training.policy.model.parameters())
    _tell(f"{recipe.agent}: {len(demonstrations)} demonstrations, {size:,} parameters, on {place.device}")
    training.run()
    _tell(f"{recipe.agent}: best {training.best}, in {training.weights}")
    if ship:
        _ship(training.weights)


def _train_reader(given: argparse.Namespace) -> None:
    from arramon_agents.reading.reader.reader import WEIGHTS
    from arramon_agents.reading.reader.train import main as train_reader

    few = ("--texts", "60", "--rounds", "1") if given.smoke else ()
    train_reader(["--data", str(given.data), "--out", str(given.output), *few])
    if given.ship:
        shutil.copyfile(given.output / "reader.safetensors", WEIGHTS)


def _train_map(given: argparse.Namespace) -> None:
    from arramon_agents.vl_map.dagger import MapRecipe
    from arramon_agents.vl_map.dagger import smoke as smoke_map
    from arramon_agents.vl_map.train import Validation, train_map

    recipe, validation = MapRecipe(), Validation()
    if given.smoke:
        recipe, validation = smoke_map(recipe), replace(validation, episodes=1)
    chosen = _chosen(given)
    for field, option in (("split", "validate"), ("episodes", "validate_episodes")):
        if option in chosen:
            validation = replace(validation, **{field: chosen.pop(option)})
    recipe = replace(recipe, **_own(MAP, recipe, chosen, given))
    weights = train_map(recipe, validation, given.data, given.output, _tell)
    _tell(f"{MAP}: in {weights}")
    if given.ship:
        _ship(weights)


def _train_grounded(given: argparse.Namespace) -> None:
    from arramon_agents.vl_grounded.train import GroundedRecipe, train_grounded
    from arramon_agents.vl_grounded.train import smoke as smoke_grounded

    recipe = smoke_grounded(GroundedRecipe()) if given.smoke else GroundedRecipe()
    recipe = replace(recipe, **_own(GROUNDED, recipe, _chosen(given), given))
    weights = train_grounded(recipe, _place(given), _tell)
    _tell(f"{GROUNDED}: in {weights}")
    if given.ship:
        _ship(weights)


def _chosen(given: argparse.Namespace) -> dict[str, Any]:
    """Return the values of a recipe that were named, by field, of agents with a recipe of their own kind."""
    names = {each.name for each in fields(Recipe)} | {name for own in OWN_OPTIONS.values() for name in own}
    names |= {"align_lang", "visual"}
    named = {name: getattr(given, name, None) for name in names - {"agent", "languages"}}
    return {name: value for name, value in named.items() if value is not None}


def _own(agent: str, recipe: Any, chosen: Mapping[str, Any], given: argparse.Namespace) -> dict[str, Any]:
    """Return what changes in a recipe of another kind.

    Raises:
        ValueError: if something was named that it does not have, unless all agents are trained.
    """
    own = {each.name for each in fields(recipe)}
    other = sorted(set(chosen) - own)
    if other and not given.all:
        raise ValueError(f"{agent} has no option {_flag(other[0])}")
    changes = {name: value for name, value in chosen.items() if name in own}
    return changes | ({"languages": tuple(given.lang.split(","))} if given.lang else {})


def _ship(weights: Path) -> None:
    """Copy weights and model card to the shipped ones."""
    from arramon_agents.weights import CARD, SHIPPED, WEIGHTS

    folder = SHIPPED / weights.stem
    shutil.copyfile(weights, folder / WEIGHTS)
    shutil.copyfile(weights.with_suffix(".md"), folder / CARD)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="arramon-train", description="Train agents by imitation.")
    parser.add_argument("--agent", help=f"agents to train, separated by commas: {', '.join(AGENTS)}")
    parser.add_argument("--all", action="store_true", help="train all of them")
    parser.add_argument("--ship", action="store_true", help="copy weights and model card to the shipped ones")
    parser.add_argument("--smoke", action="store_true", help="take seconds: a few episodes, a few updates")
    parser.add_argument("--data", type=Path, default=Path("arramon-data"), help="data folder (default: %(default)s)")
    parser.add_argument("--cache", type=Path, default=Path("arramon-cache"), help="drawn demonstrations (%(default)s)")
    parser.add_argument("--output", type=Path, default=Path("arramon-weights"), help="weights, log (%(default)s)")
    parser.add_argument("--processes", type=int, default=1, help="that draw demonstrations (default: %(default)s)")
    parser.add_argument("--device", default="auto", help="cpu, cuda, or auto: a GPU where there is one (default)")
    parser.add_argument("--checkpoint-steps", type=int, default=100, help="updates between checkpoints (%(default)s)")
    for agent, names in OWN_OPTIONS.items():
        for name in names:
            kind = float if name in ("first", "round_walks", "inflection") else int
            parser.add_argument(_flag(name), type=kind, help=f"of {agent} alone")
    parser.add_argument("--lang", help="languages, separated by commas (default: en,hi)")
    parser.add_argument("--align-lang", help="languages of the texts that --align pulls together (default: en,hi)")
    parser.add_argument("--visual", type=Path, help="folder of a vision model of transformers, instead of --encoder")
    for each in fields(Recipe):
        if each.name not in ("agent", "languages", "aligned", "sees", "reads"):
            parser.add_argument(_flag(each.name), type=type(each.default), help="default: as the agent's recipe says")
    return parser


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _recipe(recipe: Recipe, given: argparse.Namespace) -> Recipe:
    if given.smoke:
        recipe = smoke(recipe)
    if given.lang:
        recipe = replace(recipe, languages=tuple(given.lang.split(",")))
    if given.align_lang:
        recipe = replace(recipe, aligned=tuple(given.align_lang.split(",")))
    if given.visual and given.encoder:
        raise ValueError("--visual and --encoder both name what sees: give one of them")
    if given.visual:
        recipe = replace(recipe, encoder=f"{FOLDER}{given.visual}")
    changes = {each.name: getattr(given, each.name, None) for each in fields(Recipe)}
    return replace(recipe, **{name: value for name, value in changes.items() if value is not None and name != "agent"})


def _place(given: argparse.Namespace) -> Place:
    return Place(given.data, given.cache, given.output, given.processes, given.checkpoint_steps, given.device)


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
