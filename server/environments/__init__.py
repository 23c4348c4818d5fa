"""Play in this process: an episode's session, scene and camera without gRPC, journal or clocks, for learning."""

from server.environments.local import LocalBackend

__all__ = ["LocalBackend"]
