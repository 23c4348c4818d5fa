"""A small test section: four blocks around a crossing of streets 6 units wide, and instruction writers."""

from arramon_dataset.generation import Draft, DraftWriter, GenerationSite
from arramon_dataset.randomness import seeded
from arramon_server.episodes.episode import Instructions, Turn
from arramon_server.sim.geometry import Pose
from arramon_server.sim.section import Building, Prop, Section

BLOCKS = tuple(
    Building(x, z, 5.0, 5.0, 0.0, 3.0, facade)
    for (x, z), facade in zip(((-8, -8), (-8, 8), (8, -8), (8, 8)), ("brick", "glass", "white", "red"), strict=True)
)
CROSSING = Section("9", 0.0, (-13.0, -13.0, 13.0, 13.0), BLOCKS, (Prop("bench", 2.7, 6.0, 270.0),))


class PlainWriter:
    """Names the targets, and a number drawn from the seed."""

    def can_describe(
        self, start: Pose, turn: Turn, number: int, site: GenerationSite, names: tuple[object, ...]
    ) -> bool:
        return True

    def __call__(
        self, draft: Draft, site: GenerationSite, names: tuple[object, ...]
    ) -> dict[str, tuple[Instructions, Instructions]] | None:
        texts = [
            Instructions(f"get the {turn.target.type}", f"put it in {turn.target_cell}: {seeded(*names).random()}")
            for turn in draft.turns
        ]
        return {"en": (texts[0], texts[1])}


class PickyWriter(PlainWriter):
    """Accepts only drafts whose first target is a ball, a mug or a TV."""

    def can_describe(
        self, start: Pose, turn: Turn, number: int, site: GenerationSite, names: tuple[object, ...]
    ) -> bool:
        return number == 2 or turn.target.type.kind in ("ball", "mug", "tv")


class FailingWriter(PlainWriter):
    """Accepts no draft."""

    def __call__(self, draft: Draft, site: GenerationSite, names: tuple[object, ...]) -> None:
        return None


def make_plain_writer() -> DraftWriter:
    return PlainWriter()


def make_picky_writer() -> DraftWriter:
    return PickyWriter()


def make_failing_writer() -> DraftWriter:
    return FailingWriter()
