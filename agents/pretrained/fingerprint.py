"""Fingerprints of models' files: features and states in a cache are stored under them."""

import hashlib
from collections.abc import Sequence
from pathlib import Path


def fingerprint_of(paths: Sequence[Path]) -> str:
    """Return a short hash of some files' names and contents."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.name.encode())
        with path.open("rb") as file:
            digest.update(hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()[:12]
