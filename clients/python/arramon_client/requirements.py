"""The check that the contract's package, whose wheel is separate, is installed beside the client."""

import importlib.util
import sys
from pathlib import Path

MESSAGE = (
    "arramon-client needs arramon-proto, the contract's package, beside it: "
    "pip install arramon_proto-*.whl arramon_client-*.whl"
)

COMMANDS = ("arramon-client", "-m")
"""Names of the running program while the client's own command is loaded; the second is that of `python -m`."""


def check() -> None:
    """Raise ModuleNotFoundError if the package is missing; where the client's command runs, print that and exit."""
    if importlib.util.find_spec("arramon") is not None:
        return
    if Path(sys.argv[0]).name in COMMANDS:
        sys.exit(f"error: {MESSAGE}")
    raise ModuleNotFoundError(MESSAGE, name="arramon")


check()
