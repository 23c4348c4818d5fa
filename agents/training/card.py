"""Model cards of files of weights, in Markdown: properties, training command, limits."""

from collections.abc import Mapping
from typing import Any

TRAIN = "train"
"""Split of generated training episodes."""

GENERATED = (
    "- It is trained by imitation on generated episodes alone. On people's instructions such agents reach less "
    "(`docs/results/agents.md`)."
)
FINE_TUNED = (
    "- It is trained by imitation, at last on the texts of `{split}` alone: what it could before may have suffered."
)


def training_text_limit(split: str, init: str) -> str:
    """Return the line about the training texts for a model card's section on limits."""
    return GENERATED if not init and split == TRAIN else FINE_TUNED.format(split=split)


def model_card(name: str, rows: Mapping[str, object], limits: str) -> str:
    """Return a model card in Markdown: title, table of properties, limits."""
    table = "\n".join(f"| {row} | {value} |" for row, value in rows.items())
    return f"# {name}\n\n| | |\n| --- | --- |\n{table}\n\n## Limits\n\n{limits}\n"


def training_command(agent: str, recipe: Mapping[str, Any], default: Mapping[str, Any]) -> str:
    """Return the command that trains an agent by a recipe, with the options that differ from the default."""
    options = [
        f"--align-lang {','.join(value)}" if name == "aligned" else f"--{name.replace('_', '-')} {value}"
        for name, value in recipe.items()
        if name not in ("agent", "languages") and value != default[name]
    ]
    return " ".join(["arramon-train --agent", agent, "--lang", ",".join(recipe["languages"]), *sorted(options)])
