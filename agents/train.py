"""Train agents: `python -m agents.train --agent vl --lang en,hi`, or `--all` for everything that comes along."""

import argparse
import shutil
import sys
from dataclasses import fields, replace
from pathlib import Path

from agents.learning.extra import PLAYING, require
from agents.learning.recipe import RECIPES, Place, Recipe, smoke
from agents.learning.vision import FOLDER
from arramon_client.errors import ArramonClientError

MAP = "vl_map"
"""The agent whose policy is trained in simulated walks, with a recipe of its own kind."""

AGENTS = (*RECIPES, MAP)

MAP_OPTIONS = ("walks", "rounds", "round_walks", "first", "again")
"""Options of that agent alone."""

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
            if name == MAP:
                _train_map(given)
            else:
                _train(_recipe(RECIPES[name], given), _place(given), ship=given.ship)
    except (ArramonClientError, ValueError) as error:
        _tell(f"error: {error}")
        return 1
    return 0


def _train(recipe: Recipe, place: Place, *, ship: bool) -> None:
    import torch

    from agents.learning.checkpoint import WEIGHTS
    from agents.learning.imitation import Imitation, demonstrations_of, train_data_hash

    torch.set_num_threads(1)  # Two processes of one thread do more than one of two.
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
        for path in (training.weights, training.weights.with_suffix(".md")):
            shutil.copyfile(path, WEIGHTS / path.name)


def _train_map(given: argparse.Namespace) -> None:
    from agents.learning.checkpoint import WEIGHTS
    from agents.learning.map_training import MapRecipe
    from agents.learning.map_training import smoke as smoke_map
    from agents.learning.train_map import Validation, train_map

    own = [each.name for each in fields(MapRecipe)]
    given_all = {each.name: getattr(given, each.name, None) for each in (*fields(Recipe), *fields(MapRecipe))}
    chosen = {
        name: value for name, value in given_all.items() if value is not None and name not in ("agent", "languages")
    }
    validation = Validation(
        **{
            name: chosen.pop(option)
            for name, option in (("split", "validate"), ("episodes", "validate_episodes"))
            if option in chosen
        }
    )
    other = [name for name in chosen if name not in own]
    if other and not given.all:
        raise ValueError(f"{MAP} has no option {_flag(other[0])}")
    recipe = MapRecipe()
    if given.smoke:
        recipe, validation = smoke_map(recipe), replace(validation, episodes=1)
    if given.lang:
        recipe = replace(recipe, languages=tuple(given.lang.split(",")))
    recipe = replace(recipe, **{name: value for name, value in chosen.items() if name in own})
    weights = train_map(recipe, validation, given.data, given.output, _tell)
    _tell(f"{MAP}: in {weights}")
    if given.ship:
        for path in (weights, weights.with_suffix(".md")):
            shutil.copyfile(path, WEIGHTS / path.name)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m agents.train", description="Train agents by imitation.")
    parser.add_argument("--agent", help=f"agents to train, separated by commas: {', '.join(AGENTS)}")
    parser.add_argument("--all", action="store_true", help="train all of them")
    parser.add_argument("--ship", action="store_true", help="copy weights and card to those that come along")
    parser.add_argument("--smoke", action="store_true", help="take seconds: a few episodes, a few updates")
    parser.add_argument("--data", type=Path, default=Path("arramon-data"), help="data folder (default: %(default)s)")
    parser.add_argument("--cache", type=Path, default=Path("arramon-cache"), help="drawn demonstrations (%(default)s)")
    parser.add_argument("--output", type=Path, default=Path("arramon-weights"), help="weights, log (%(default)s)")
    parser.add_argument("--processes", type=int, default=1, help="that draw demonstrations (default: %(default)s)")
    parser.add_argument("--device", default="auto", help="cpu, cuda, or auto: a GPU where there is one (default)")
    parser.add_argument("--checkpoint-steps", type=int, default=100, help="updates between checkpoints (%(default)s)")
    for name in MAP_OPTIONS:
        parser.add_argument(
            _flag(name), type=float if name in ("first", "round_walks") else int, help=f"of {MAP} alone"
        )
    parser.add_argument("--lang", help="languages, separated by commas (default: en,hi)")
    parser.add_argument("--align-lang", help="languages of the texts that --align pulls together (default: en,hi)")
    parser.add_argument("--visual", type=Path, help="folder of a vision model of transformers, instead of --encoder")
    for each in fields(Recipe):
        if each.name not in ("agent", "languages", "aligned", "sees", "reads"):
            kind = type(each.default)
            parser.add_argument(_flag(each.name), type=kind, help="default: as the agent's recipe says")
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
