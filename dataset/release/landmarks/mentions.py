"""Turns and mentions of landmarks in navigation instructions, and which kinds are recovered."""

from collections.abc import Sequence
from dataclasses import dataclass

import arramon_lang as lang
from arramon_client.world import BANNER_COLOURS
from arramon_lang.reading.outline import OutlineEntry
from arramon_server.sim.labels import IMPORTED_BANNER_COLOURS

METAL, METAL_BENCH = ("bench", "silver"), "metal_bench"
"""Kind and colour of metal benches, and the kind as which they are recovered."""

SCENERY = (
    "barrier", "banner", "barrel", "tyre_stack", "traffic_light", "mailbox", "bags", "stop_sign", "speed_sign",
    METAL_BENCH,
)  # fmt: skip
"""Kinds of street furniture that keep their places in all episodes of a section. People who name one beside targets
less than 2 units apart in different episodes agree 3 to 15 times as often as chance."""

DRAWN = ("cone", "phone_booth", "bench", "dumpster", "lamp_post", "hydrant", "bin")
"""Kinds of street furniture that stand elsewhere in each episode: people agree 0.7 to 1.2 times as often as chance."""

FACADES = "building"
"""The kind of buildings, whose looks agree 2 to 3 times as often as chance."""

FURNITURE = tuple(kind for kind in (*SCENERY, *DRAWN) if kind != METAL_BENCH)
"""Kinds of street furniture that people name."""

_SIGN = "shop_sign"
"""Kind that people confuse with banners: with a background colour it is a banner."""


@dataclass(frozen=True, slots=True)
class Event:
    """A turn, or a mention of a landmark.

    Attributes:
        direction: of a turn, one of `arramon_lang.meaning.TURNS`; "" for a mention.
        kind: of FURNITURE, or "building"; "" for a turn and for what has no place of its own ("the corner").
        colour: as stated; "" if not stated.
        look: a banner's shape, a building's facade; "" if not stated.
        manner: of `arramon_lang.reading.outline.MANNERS`; "" for a turn.
        relation: of the object to pick up to the landmark, of `arramon_lang.meaning.RELATIONS`; "" otherwise.
        side: "left" or "right" if the landmark's side is stated.
        tied: whether it is at the same place as the event before.
        weight: share of its landmark's one vote: a landmark named twice in a text still votes once.
        identity: the same for all mentions of one thing in a text; "" if unknown.
    """

    direction: str = ""
    kind: str = ""
    colour: str = ""
    look: str = ""
    manner: str = ""
    relation: str = ""
    side: str = ""
    tied: bool = False
    weight: float = 1.0
    identity: str = ""

    @property
    def recovered_kind(self) -> str:
        """The kind as which the landmark is recovered: its own, or "metal_bench" for a metal bench."""
        return METAL_BENCH if (self.kind, self.colour) == METAL else self.kind


def events_of(text: str, language: str) -> tuple[Event, ...]:
    """Return the turns and mentions of an instruction, in order; none if nothing of it can be read."""
    said = lang.load(language).outline(text)
    identities = [each.thing.identity for each in said if each.thing is not None]
    return tuple(_event(each, identities) for each in said)


def _event(said: OutlineEntry, identities: Sequence[str]) -> Event:
    thing = said.thing
    if thing is None:
        return Event(direction=said.direction, tied=said.tied)
    kind = (
        "banner" if thing.kind == _SIGN and thing.colour in (*BANNER_COLOURS, *IMPORTED_BANNER_COLOURS) else thing.kind
    )
    kind = FACADES if kind == "building_corner" else kind
    weight = 1.0 / max(1, identities.count(thing.identity)) if thing.identity else 1.0
    return Event(
        kind=kind if kind in FURNITURE or kind == FACADES else "",
        colour=thing.colour,
        look=thing.look,
        manner=said.manner,
        relation=said.relation,
        side=said.side,
        tied=said.tied,
        weight=weight,
        identity=thing.identity,
    )
