"""Entry point of LeRobot's EnvHub, for a repository on the Hugging Face Hub; see docs/how-to/hugging-face.md."""

from arramon_client.adapters.lerobot import make_env

__all__ = ["make_env"]
