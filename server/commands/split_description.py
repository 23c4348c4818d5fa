"""One-line description of a split, which several commands print."""

from arramon_server.episodes.provenance import origins_of
from arramon_server.episodes.splits import Split


def describe_split(split: Split) -> str:
    """Return a one-line description of a split, with the origins of its furniture where they are known."""
    languages = ", ".join(f"{count} in {code}" for code, count in split.languages.items())
    kind = "hidden" if split.hidden else "for training alone" if split.training else "open"
    sections = f"{len(split.sections)} section{'s' if len(split.sections) != 1 else ''}"
    origins = str(origins_of(split.provenance.values(), split.sections))
    parts = [f"split {split.name} ({kind}): {languages}", sections, origins, f"data {split.data_hash[:12]}"]
    return "; ".join(part for part in parts if part)
