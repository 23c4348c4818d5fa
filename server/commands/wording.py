"""Descriptions that commands print."""

from server.episodes.splits import Split


def describe(split: Split) -> str:
    """Return a one-line description of a split."""
    languages = ", ".join(f"{count} in {code}" for code, count in split.languages.items())
    kind = "hidden" if split.hidden else "for training alone" if split.training else "open"
    return f"split {split.name} ({kind}): {languages}; {len(split.sections)} sections; data {split.data_hash[:12]}"
