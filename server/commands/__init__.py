"""The commands of `arramon-server`, one module for each family, whose function `add` adds the commands' parsers."""

import argparse
from typing import TypeAlias

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
