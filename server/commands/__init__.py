"""The commands of `arramon-server`, a module each family; each has `add`, which puts its parsers among the commands."""

import argparse
from typing import TypeAlias

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
