"""Model card of a trained model of the paper: training data, command and validation scores."""

from collections.abc import Mapping
from typing import Any

from arramon_agents.pretrained.encoders import INSTALL, PACKAGE
from arramon_agents.reading.tokenizers import PRETRAINED
from arramon_agents.training.card import model_card, training_command, training_text_limit
from arramon_agents.training.recipe import as_json
from arramon_agents.vl.policy import VlPolicy
from arramon_agents.vl.recipe import RECIPES, Recipe

WHAT = {
    (True, True): "It reads the instruction and sees the present image.",
    (True, False): "It sees the present image and does not read.",
    (False, True): "It reads the instruction and sees nothing.",
}
"""Description of the inputs, by (sees, reads)."""

MEMORY_LIMITS = {
    True: "- It sees one image at a time and remembers only its own actions, not the places where it has been.",
    False: "- It sees nothing and remembers only its own actions: it cannot know where it is.",
}
"""First limit, by whether the agent sees."""

LIMITS = """\
- The model of a phase knows nothing of the other; a wrong turn 1 leaves turn 2 where the training never was.
- It is a baseline, and far from human level. Compare with `docs/results/agents.md`."""


def card(policy: VlPolicy, recipe: Recipe) -> str:
    """Return the model card of a policy that was trained by a recipe, in Markdown."""
    about: Mapping[str, Any] = policy.about
    size = sum(parameter.numel() for parameter in policy.model.parameters())
    encoder = "none" if policy.encoder is None else f"`{policy.encoder.name}` ({policy.encoder.fingerprint})"
    digest = about.get("data_hash", "unknown")[:12]
    default = RECIPES.get(recipe.agent, Recipe(recipe.agent, sees=recipe.sees, reads=recipe.reads))
    rows = {
        "agent": f"`agents.{recipe.agent}`. {WHAT[recipe.sees, recipe.reads]}",
        "model": f"the paper's (`agents/vl/model.py`), {size:,} parameters, reader `{recipe.reader}`",
        "tokenizer": f"`{policy.tokenizer.name}`, {policy.tokenizer.size} pieces, for {' and '.join(recipe.languages)}",
        "text encoder": _text_encoder(recipe),
        "visual encoder": encoder,
        "training data": f"{about.get('data', 'unknown')}; SHA-256 of `{recipe.split}` {digest}",
        "command": f"`{training_command(recipe.agent, as_json(recipe), as_json(default))}`",
        "seed": recipe.seed,
        "updates": about.get("updates", "unknown"),
        "CPU time": f"{about.get('cpu_seconds', 0) / 60:.0f} minutes, without drawing the demonstrations",
        "validation": _validation(about.get("validation", {}), recipe),
    }
    if recipe.init:
        rows["begins with"] = f"`{recipe.init}`"
    return model_card(
        recipe.agent, rows, f"{training_text_limit(recipe.split, recipe.init)}\n{MEMORY_LIMITS[recipe.sees]}\n{LIMITS}"
    )


def _text_encoder(recipe: Recipe) -> str:
    if not recipe.reader.startswith(PRETRAINED):
        return "its own, learned with the rest of the model"
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
