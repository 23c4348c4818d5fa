"""An episode's own furniture: the differences between its street furniture and that of its section."""

from dataclasses import dataclass, replace

from arramon_server.sim.assets.banners import COLOURS as BANNER_COLOURS
from arramon_server.sim.city import label_of_prop
from arramon_server.sim.labels import LABELS
from arramon_server.sim.section import Prop, Section

PAINTED = "zebra_crossing"
"""The kind of prop that is a road marking: it is the same in all episodes of a section."""

_LABELS = frozenset(LABELS)


@dataclass(frozen=True, slots=True)
class MovedProp:
    """A prop of the section at another position in one episode.

    Attributes:
        prop: its index in `Section.props`.
        x, z: its position in the episode, in units.
        heading: direction of its front in the episode, degrees clockwise from +z.
    """

    prop: int
    x: float
    z: float
    heading: float


@dataclass(frozen=True, slots=True)
class OwnFurniture:
    """The differences of one episode's furniture from its section's.

    Attributes:
        added: props of this episode alone.
        moved: props of the section at other positions, by index.
        left_out: indices in `Section.props` of removed props.
    """

    added: tuple[Prop, ...] = ()
    moved: tuple[MovedProp, ...] = ()
    left_out: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        for prop in self.added:
            problem = _problem_of(prop)
            if problem:
                raise ValueError(problem)
        changed = [*(each.prop for each in self.moved), *self.left_out]
        for index in changed:
            if changed.count(index) > 1:
                raise ValueError(f"the section's prop {index} is moved or left out twice; expected once")

    @property
    def is_empty(self) -> bool:
        """Whether the episode has the section's furniture unchanged."""
        return not (self.added or self.moved or self.left_out)

    def check(self, section: Section) -> None:
        """Check that the section has the props that are moved or left out.

        Raises:
            ValueError: naming the prop that does not exist.
        """
        for index in (*(each.prop for each in self.moved), *self.left_out):
            if not 0 <= index < len(section.props):
                raise ValueError(f"names prop {index} of section {section.id!r}, which has {len(section.props)}")
            if section.props[index].kind == PAINTED:
                raise ValueError(f"changes prop {index} of section {section.id!r}, a {PAINTED}: these stay")


NO_FURNITURE = OwnFurniture()
"""No differences: the episode has its section's furniture."""


def furnished(section: Section, furniture: OwnFurniture) -> Section:
    """Return a section with an episode's furniture: the section's props in their order, then those of the episode."""
    if furniture.is_empty:
        return section
    return replace(section, props=(*(prop for prop in _kept(section, furniture) if prop is not None), *furniture.added))


def _kept(section: Section, furniture: OwnFurniture) -> list[Prop | None]:
    """Return the section's props in an episode, by index; None for those left out."""
    kept: list[Prop | None] = list(section.props)
    for each in furniture.moved:
        kept[each.prop] = replace(section.props[each.prop], x=each.x, z=each.z, heading=each.heading)
    for index in furniture.left_out:
        kept[index] = None
    return kept


def _problem_of(prop: Prop) -> str:
    """Return what is wrong with a prop; empty if nothing is."""
    what = " ".join(filter(None, (prop.colour, prop.shape_colour, prop.shape, prop.kind)))
    if prop.kind == PAINTED:
        return f"a {PAINTED} cannot be an episode's own: it is part of the road"
    if label_of_prop(prop) not in _LABELS or (prop.kind == "banner" and prop.shape_colour not in BANNER_COLOURS):
        return f"there is no furniture such as a {what!r}"
    return ""
