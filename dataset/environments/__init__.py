"""Play in this process: an episode's session, scene and camera without gRPC, journal or clocks, for learning."""

import os

from arramon_client.errors import UsageError

if os.name != "posix":  # before what needs it is imported: file locks
    raise UsageError(
        "environments in this process need Linux or macOS: on Windows use WSL 2, or name a host with server='HOST:PORT'"
    )

from arramon_dataset.environments.local import LocalBackend

__all__ = ["LocalBackend"]
