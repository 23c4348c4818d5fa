"""Fingerprints of model files, used as keys of cached features and states."""

import hashlib
from collections.abc import Sequence
from pathlib import Path


def fingerprint_of(paths: Sequence[Path]) -> str:
    """Return a short hash of the names and contents of files."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.name.encode())
        with path.open("rb") as file:
            digest.update(hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()[:12]
