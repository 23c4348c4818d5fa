"""Names of things in readings and in written meanings, brought to one form so that they can be compared."""

from dataclasses import dataclass

from arramon_lang.meaning import Thing

SAME_KIND = {
    "crossing": "intersection", "crossroads": "intersection", "junction": "intersection", "building_corner": "corner",
    "t-junction": "t_junction", "sidewalk": "street", "road": "street", "wall_corner": "corner", "roadblock": "barrier",
    "wall": "building", "tires": "tyre_stack", "tyres": "tyre_stack", "benches": "bench",
}  # fmt: skip

SAME_WORD = {
    "golden": "gold", "wooden": "gold", "gray": "grey", "metal": "grey", "silver": "grey", "spotted": "dotted",
    "dot": "circle",
}  # fmt: skip
"""Words for one colour or look. A wooden thing of the street is of the catalogue's colour gold."""

OWN_WORDS = {
    "phone_booth": {"blue"}, "hydrant": {"red"}, "stop_sign": {"red"}, "bags": {"black"}, "tree": {"green"},
    "bench": {"brown", "gold"}, "mailbox": {"blue"},
}  # fmt: skip
"""What all things of a kind look like: "the blue phone booth" says no more than "the phone booth"."""

SHOPS = frozenset(("hotel", "cafe", "bank", "bakery", "pharmacy", "cinema"))
"""A shop, its sign and its building are one place."""

ORDINALS = frozenset(("first", "second", "third", "last", "nearest", "next", "another"))

_WITHOUT_MEANING = frozenset(("the", "two", "several", "both", "three", "right", "left", "building", "far"))


@dataclass(frozen=True, slots=True)
class ComparedName:
    """What a text calls a thing.

    Attributes:
        kind: as in `arramon_lang.meaning.Thing`.
        says: colours and looks.
        which: "second", ...; "" if not said.
    """

    kind: str
    says: frozenset[str] = frozenset()
    which: str = ""

    def fits(self, other: "ComparedName") -> bool:
        """Return whether both can name one thing, and say of it what tells it apart.

        The kind is the same; what the one says the other says too, or at least a part of it if it says more ("the white
        and black mug", "the banner with the red triangle"). A colour or look that only one of them says at all, or that
        differs, is another name.
        """
        if self.kind != other.kind or (self.which in COUNTED and other.which in COUNTED and self.which != other.which):
            return False
        return self.says == other.says or bool(
            self.says & other.says and (self.says <= other.says or other.says <= self.says)
        )


COUNTED = frozenset(("first", "second", "third"))
"""Ordinals that count, and so cannot be exchanged for one another."""


def name_read(thing: Thing) -> ComparedName:
    """Return the name of a thing in a reading."""
    return _name(thing.kind, {word for word in (thing.colour, thing.look) if word}, thing.which)


def name_said(words: str) -> ComparedName:
    """Return the name of a thing in the plain words of a written meaning."""
    *before, kind = words.lower().replace("-", " ").replace("zebra crossing", "zebra_crossing").split()
    singular = kind[:-1] if kind.endswith("s") and kind not in ("hourglass", "bags", "tires", "tyres") else kind
    which = next((word for word in before if word in ORDINALS), "")
    says = {word for word in before if word not in ORDINALS | _WITHOUT_MEANING}
    if singular == "corner" and "building" in before:
        singular = "building_corner"
    return _name(singular if kind not in SAME_KIND or singular == "building_corner" else kind, says, which)


def _name(kind: str, says: set[str], which: str) -> ComparedName:
    if kind == "building_corner" and says:  # A building's own corner is named for the building.
        kind = "building"
    kind = SAME_KIND.get(kind, kind)
    says = {SAME_WORD.get(word, word) for word in says}
    if kind == "barrier" and "orange" in says:  # The catalogue's white barriers are orange and white.
        says = (says - {"orange"}) | {"white"}
    if kind == "shop_sign" and says & SHOPS:
        kind = "building"
    return ComparedName(kind, frozenset(says - OWN_WORDS.get(kind, set())), which)
