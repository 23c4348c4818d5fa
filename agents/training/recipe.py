"""Functions for training recipes, which are dataclasses of settings."""

from dataclasses import asdict
from typing import Any

PRECISIONS = ("float32", "bfloat16")
"""Names of the precisions of matrix products."""


def as_json(recipe: Any) -> dict[str, Any]:
    """Return the settings of a recipe as JSON values, with lists for tuples."""
    return {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(recipe).items()}


def update_settings(recipe: Any) -> dict[str, Any]:
    """Return the settings of a recipe that affect updates: all but those of validation, and of joining policies."""
    return {name: value for name, value in as_json(recipe).items() if not name.startswith(("validate", "join"))}
