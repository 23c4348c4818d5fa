"""A small test section: four blocks around a crossing of streets 6 units wide, and instruction writers."""

from server.dataset.generation import Draft, Site, Writer
from server.dataset.randomness import seeded
from server.episodes.episode import Instructions
from server.sim.section import Building, Prop, Section

BLOCKS = tuple(
    Building(x, z, 5.0, 5.0, 0.0, 3.0, facade)
    for (x, z), facade in zip(((-8, -8), (-8, 8), (8, -8), (8, 8)), ("brick", "glass", "white", "red"), strict=True)
)
CROSSING = Section("9", 0.0, (-13.0, -13.0, 13.0, 13.0), BLOCKS, (Prop("bench", 2.7, 6.0, 270.0),))


def plainly(draft: Draft, site: Site, names: tuple[object, ...]) -> dict[str, tuple[Instructions, Instructions]]:
    """Says what the targets are, and a number that the names draw."""
    texts = [
        Instructions(f"get the {turn.target.type}", f"put it in {turn.target_cell}: {seeded(*names).random()}")
        for turn in draft.turns
    ]
    return {"en": (texts[0], texts[1])}


def fussily(draft: Draft, site: Site, names: tuple[object, ...]) -> dict[str, tuple[Instructions, Instructions]] | None:
    """Takes only what has a ball for its first target."""
    return plainly(draft, site, names) if draft.turns[0].target.type.kind in ("ball", "mug", "tv") else None


def never(draft: Draft, site: Site, names: tuple[object, ...]) -> None:
    """Finds nothing good."""


def make_plain() -> Writer:
    return plainly


def make_fussy() -> Writer:
    return fussily


def make_never() -> Writer:
    return never
