"""A split whose section has recovered furniture, and an episode with furniture of its own."""

from dataclasses import replace
from pathlib import Path

from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.provenance import Provenance, RecoveredLook
from arramon_server.episodes.splits import Split, write_split
from arramon_server.sim.own_furniture import MovedProp, OwnFurniture
from arramon_server.sim.section import Prop
from tests import tiny

PROPS = (
    Prop("barrier", 1.5, 1.0, 90.0, "red"),
    Prop("traffic_light", -15.0, -12.0, 0.0),
    Prop("tree", 12.0, -10.0, 0.0),
)
SECTION = replace(tiny.SECTION, props=PROPS)
OWN = OwnFurniture(
    added=(Prop("cone", 0.0, 5.0, 0.0, "orange"), Prop("bin", -9.0, -9.0, 0.0)), moved=(MovedProp(1, -8.0, 3.0, 0.0),)
)
PROVENANCE = Provenance(
    "1", (RecoveredLook(0, 31.4), RecoveredLook(1, 8.6)), (RecoveredLook(0, 12.0),), {"0": ("text", "drawn")}
)


def episode(*navigation: str) -> Episode:
    """The first of the tiny episodes, with its own furniture and these navigation instructions."""
    made = replace(tiny.episode("0", ("en",)), furniture=OWN)
    texts = [Instructions(text, "Put it two steps ahead.") for text in navigation]
    return replace(made, instructions={"en": (texts[0], texts[1])}) if texts else made


def write(data: Path, *navigation: str) -> Split:
    episodes = [episode(*navigation), tiny.episode("1")]
    return write_split(
        data, "own", hidden=False, source="tests", episodes=episodes, sections=[SECTION], provenance=[PROVENANCE]
    )
