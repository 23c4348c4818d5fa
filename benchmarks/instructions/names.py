"""Names of things in parsed and in written meanings, in canonical form for comparison."""

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
"""Synonyms of a colour or look. Wooden street furniture has the catalogue's colour gold."""

OWN_WORDS = {
    "phone_booth": {"blue"}, "hydrant": {"red"}, "stop_sign": {"red"}, "bags": {"black"}, "tree": {"green"},
    "bench": {"brown", "gold"}, "mailbox": {"blue"},
}  # fmt: skip
"""Attributes common to all things of a kind: "the blue phone booth" means the same as "the phone booth"."""

SHOPS = frozenset(("hotel", "cafe", "bank", "bakery", "pharmacy", "cinema"))
"""Kinds of shops: a shop, its sign and its building count as one place."""

ORDINALS = frozenset(("first", "second", "third", "last", "nearest", "next", "another"))

_WITHOUT_MEANING = frozenset(("the", "two", "several", "both", "three", "right", "left", "building", "far"))


@dataclass(frozen=True, slots=True)
class ComparedName:
    """The name of a thing in a text, in canonical form.

    Attributes:
        kind: as in `arramon_lang.meaning.Thing`.
        says: colours and looks.
        which: "second", ...; "" if not said.
    """

    kind: str
    says: frozenset[str] = frozenset()
    which: str = ""

    def fits(self, other: "ComparedName") -> bool:
        """Return whether both can name the same thing, with the same distinguishing attributes.

        The kinds must be equal, and the attributes of one must include those of the other ("the white and black mug",
        "the banner with the red triangle"). Names differ if only one of them gives a colour or look.
        """
        if self.kind != other.kind or (self.which in COUNTED and other.which in COUNTED and self.which != other.which):
            return False
        return self.says == other.says or bool(
            self.says & other.says and (self.says <= other.says or other.says <= self.says)
        )


COUNTED = frozenset(("first", "second", "third"))
"""Ordinals that count, and so are not interchangeable."""


THREE_STREETS = 3
"""Number of streets at a T-junction."""


def parsed_name(thing: Thing) -> ComparedName:
    """Return the canonical name of a thing in a parsed meaning; an intersection of three streets is a T-junction."""
    kind = "t_junction" if thing.kind == "intersection" and thing.arms == THREE_STREETS else thing.kind
    return _name(kind, {word for word in (thing.colour, thing.look) if word}, thing.which)


def written_name(words: str) -> ComparedName:
    """Return the name of a thing in a meaning that an annotator wrote down, in canonical form."""
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
