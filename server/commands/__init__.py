"""The commands of `arramon-server`, one module per family. The function `add` of each adds the commands' parsers."""

import argparse
from typing import TypeAlias

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"

ENTRY_POINTS = "arramon.commands"
"""Entry-point group in which installed packages register commands, and actions of the command `epoch`."""
