"""Warnings and errors in the logs of the soak test's servers, and which of them the injected faults explain."""

import json
import re
from collections import Counter
from collections.abc import Collection
from pathlib import Path

OUTAGE = (
    r"^(/\S+ failed: )?the journal cannot be used: ",
    r"^cannot record the end of a stream yet: the journal cannot be used: ",
    r"^not ready: the database ",
    r"^error ignored terminating <psycopg\.",  # said by psycopg itself
)
"""What a server logs while its database is away or its disk is full."""

ALWAYS_EXPECTED = (r"^no heartbeat for \d+ seconds: ",)
"""What a busy machine explains by itself."""

EXPLAINED = {
    "server killed": (r"^worker \d+ died with status -9, ",),
    "server paused": (
        r"^another process of this server has taken over ",
        r"^not ready: the engine has been stuck for \d+ seconds",
        *OUTAGE,  # PostgreSQL ends the transaction of a process that stands still
    ),
    "database ended": OUTAGE,
    "disk full": OUTAGE,
}
"""Patterns of the messages that each fault explains; faults that are not listed explain none."""


def warnings(folder: Path) -> Counter[str]:
    """Count the warnings and errors in the JSON logs `log-*` by message, without ids and long numbers.

    A line that is no JSON counts too: a crash of the interpreter, for example, writes such lines.
    """
    found = Counter[str]()
    for log in sorted(folder.glob("log-*")):
        for line in log.read_text(errors="replace").splitlines():
            if not line.startswith("{"):
                found[f"no JSON: {line[:100]}"] += 1
                continue
            record = json.loads(line)
            if record["level"] not in ("info", "debug"):
                message = re.sub(r"[0-9a-f]{32}|\d{4,}|\s+", _shortened, record["message"])
                found[f"{record['level']}: {message[:160]}"] += 1
    return found


def _shortened(match: re.Match[str]) -> str:
    return " " if match[0].isspace() else "..."


def unexplained(found: Collection[str], faults: Collection[str]) -> list[str]:
    """Return the messages of `warnings` that none of these faults explains."""
    patterns = [*ALWAYS_EXPECTED, *(pattern for fault in faults for pattern in EXPLAINED.get(fault, ()))]
    return [text for text in found if not any(re.search(each, text.partition(": ")[2]) for each in patterns)]
