"""In-process players for tests."""

from pathlib import Path
from typing import Any

from arramon_client.environments.backend import PlayerSettings
from arramon_dataset.environments import LocalBackend
from arramon_dataset.environments.player import LocalPlayer


def player(data: Path, split: str = "tiny", **more: Any) -> LocalPlayer:
    settings = {"language": "en", "split": split, "sensors": (), "image_size": 32, **more}
    return LocalBackend(data).player(PlayerSettings(**settings))
