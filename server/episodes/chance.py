"""Where this package's random choices come from: the name of what is drawn, and nothing else."""

import hashlib
from random import Random


def seeded(*names: object) -> Random:
    """A generator that depends on `names` alone: the same on every machine, in every process."""
    digest = hashlib.sha256("/".join(str(name) for name in names).encode()).digest()
    return Random(int.from_bytes(digest, "big"))  # noqa: S311 - nothing here is a secret
