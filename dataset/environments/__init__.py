"""In-process play for training: an episode's session, scene and camera, without gRPC, journal or clocks."""

import os

from arramon_client.errors import UsageError

if os.name != "posix":  # checked before modules that need POSIX file locks are imported
    raise UsageError(
        "environments in this process need Linux or macOS: on Windows use WSL 2, or name a host with server='HOST:PORT'"
    )

from arramon_dataset.environments.local import LocalBackend

__all__ = ["LocalBackend"]
