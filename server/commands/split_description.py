"""One-line description of a split, which several commands print."""

from arramon_server.episodes.provenance import origins_of
from arramon_server.episodes.splits import Split


def describe_split(split: Split) -> str:
    """Return a one-line description of a split, with the origins of its furniture where they are known."""
    languages = ", ".join(f"{count} in {code}" for code, count in split.languages.items())
    kind = "hidden" if split.hidden else "for training alone" if split.training else "open"
    made = f"; {origins_of(split.provenance.values(), split.sections)}" if split.provenance else ""
    sections = f"{len(split.sections)} sections"
    return f"split {split.name} ({kind}): {languages}; {sections}{made}; data {split.data_hash[:12]}"
