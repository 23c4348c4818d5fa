"""What the programs share: their arguments, and what the scripted model answers."""

import json
import re
import sys
from pathlib import Path
from typing import Any

ADDRESS, LANGUAGE, EPISODE, DIGITS, OUTPUT = sys.argv[1:6]

PLAN = 3
"""Number of actions in one act."""

NAMES = ("forward", "left", "right", "interact")


def plan(step: int) -> list[str]:
    """Return the next actions, by name."""
    return [NAMES[int(digit)] for digit in DIGITS[step : step + PLAN]]


def step_of(text: str) -> int:
    """Return the present step from what the model is told."""
    found = re.search(r"^Step (\d+):", text, re.MULTILINE)
    assert found is not None, text
    return int(found[1])


def write(result: Any) -> None:
    """Write the program's result."""
    Path(OUTPUT).write_text(json.dumps(result))
