"""Registry of visual encoders by name: `eyes`, `pooled`, or a vision model in a folder."""

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import cast

from arramon_agents.perception.encoder import FOLDER, VisualEncoder

ENCODERS = {"eyes": "arramon_agents.perception.eyes.encoder", "pooled": "arramon_agents.perception.pooled"}
"""Modules of the encoders, by name."""


def open_encoder(name: str) -> VisualEncoder:
    """Return the encoder of this name, or of a folder: `folder=PATH`.

    Raises:
        ValueError: if there is no such encoder, or the folder holds no vision model.
    """
    if name.startswith(FOLDER):
        from arramon_agents.perception.pretrained_vision import PretrainedVisualEncoder

        return PretrainedVisualEncoder(Path(name.removeprefix(FOLDER)))
    if name not in encoder_names():
        raise ValueError(f"there is no visual encoder {name!r}; there are {', '.join(encoder_names())}")
    load = cast(Callable[[], VisualEncoder], importlib.import_module(ENCODERS[name]).load)
    return load()


def encoder_names() -> list[str]:
    """Return the names of all encoders, sorted."""
    return sorted(ENCODERS)
