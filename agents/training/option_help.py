"""Help texts of training options, from the docstrings of the recipes."""

import inspect
from collections.abc import Iterable, Mapping
from typing import Any

SECTION = "Attributes:"


def attribute_texts(kind: type) -> dict[str, str]:
    """Return the descriptions of a class's attributes from the section "Attributes" of its docstring.

    Attributes described together ("batch, room_batch: ...") get the same text.
    """
    _, _, section = inspect.cleandoc(kind.__doc__ or "").partition(f"\n{SECTION}\n")
    texts: dict[str, str] = {}
    names: list[str] = []
    for line in section.splitlines():
        if not line.strip():
            break
        if line.startswith(" " * 8):
            texts |= {name: f"{texts[name]} {line.strip()}" for name in names}
        else:
            head, _, text = line.partition(":")
            names = [name.strip() for name in head.split(",")]
            texts |= dict.fromkeys(names, text.strip())
    return texts


def option_help(option: str, recipes: Mapping[str, Any]) -> str:
    """Return the help text of an option: what it means, and its default for each agent.

    Agents whose recipes describe the option in the same words share a sentence.

    Args:
        option: field of the recipes.
        recipes: recipes that have the field, by the name of the agent.
    """
    agents_by_text: dict[str, list[str]] = {}
    for agent, recipe in recipes.items():
        text = attribute_texts(type(recipe))[option].removesuffix(".")
        agents_by_text.setdefault(text, []).append(agent)
    sentences = []
    for text, agents in agents_by_text.items():
        defaults = _defaults((agent, getattr(recipes[agent], option)) for agent in agents)
        sentences.append(f"{text} (default: {defaults})")
    return "; ".join(sentences).replace("%", "%%")


def _defaults(values: Iterable[tuple[str, Any]]) -> str:
    """Format default values, each with the agents that have it."""
    agents_by_value: dict[str, list[str]] = {}
    for agent, value in values:
        agents_by_value.setdefault(_shown(value), []).append(agent)
    return "; ".join(f"{value} for {', '.join(agents)}" for value, agents in agents_by_value.items())


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return ",".join(value)
    return "none" if value == "" else str(value)
