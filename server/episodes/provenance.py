"""Provenance of a section's scenery and of its episodes' own furniture: recovered from texts, or drawn at random.

A split has one file for each section whose furniture was recovered: `provenance/ID.json` beside its sections.
Rules and cameras do not depend on it.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from arramon_server.episodes.episode import Episode
from arramon_server.sim.section import Section

AGREEMENT, COLOUR, TEXT, DRAWN = "agreement", "colour", "text", "drawn"
"""Origins: several texts agree; they agree on the position, and the episode's own text selects one of their colours;
the episode's own text alone; drawn at random."""

OWN_ORIGINS = (COLOUR, TEXT, DRAWN)


@dataclass(frozen=True, slots=True)
class PropOrigin:
    """The origin of one prop.

    Attributes:
        name: AGREEMENT, COLOUR, TEXT or DRAWN.
        votes: number of votes for AGREEMENT; otherwise 0.
    """

    name: str
    votes: float = 0.0


@dataclass(frozen=True, slots=True)
class RecoveredLook:
    """A prop or building of a section whose look several texts agree on.

    Attributes:
        index: index in `Section.props` or `Section.buildings`.
        votes: number of these texts, weighted by how near each text puts it.
        language_votes: the same by language code; may be empty.
    """

    index: int
    votes: float
    language_votes: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.votes <= 0.0:
            raise ValueError(f"has {self.votes:g} votes; expected more than 0")


@dataclass(frozen=True, slots=True)
class Provenance:
    """The origin of a section's scenery, and of the furniture of the episodes in it.

    Attributes:
        section: id of the section.
        props: the section's recovered props; all others were drawn at random.
        buildings: the buildings with a recovered facade; those of all others were drawn at random.
        own: for each episode with own furniture the origin of each of `OwnFurniture.added`: COLOUR, TEXT or
            DRAWN.
    """

    section: str
    props: tuple[RecoveredLook, ...] = ()
    buildings: tuple[RecoveredLook, ...] = ()
    own: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("props", "buildings"):
            indices = [each.index for each in getattr(self, name)]
            if len(set(indices)) < len(indices):
                raise ValueError(f"{name} names the same index twice")
        for episode_id, origins in self.own.items():
            for origin in origins:
                if origin not in OWN_ORIGINS:
                    raise ValueError(f"own.{episode_id} is {origin!r}, expected one of {', '.join(OWN_ORIGINS)}")

    def prop_votes(self) -> dict[int, float]:
        """Return the votes of the section's recovered props, by index."""
        return {each.index: each.votes for each in self.props}

    def building_votes(self) -> dict[int, float]:
        """Return the votes of the buildings whose facade was recovered, by index."""
        return {each.index: each.votes for each in self.buildings}

    def origins(self, section: Section, episode: Episode | None = None) -> tuple[PropOrigin, ...]:
        """Return the origin of each prop of the section, or of `own_furniture.furnished` for an episode, in order."""
        votes = self.prop_votes()
        gone = () if episode is None else episode.furniture.left_out
        kept = [index for index in range(len(section.props)) if index not in gone]
        added = () if episode is None else self.own.get(episode.episode_id, (DRAWN,) * len(episode.furniture.added))
        return (
            *(PropOrigin(AGREEMENT, votes[index]) if index in votes else PropOrigin(DRAWN) for index in kept),
            *map(PropOrigin, added),
        )

    def check(self, section: Section, episodes: Mapping[str, Episode]) -> None:
        """Check it against the section and the episodes of its split.

        Raises:
            ValueError: naming what does not fit.
        """
        for name, count in (("props", len(section.props)), ("buildings", len(section.buildings))):
            for each in getattr(self, name):
                if not 0 <= each.index < count:
                    raise ValueError(f"{name} names {each.index}; section {section.id!r} has {count} {name}")
        for episode_id, origins in self.own.items():
            episode = episodes.get(episode_id)
            if episode is None or episode.section != section.id:
                raise ValueError(f"own.{episode_id}: there is no such episode in section {section.id!r}")
            if len(origins) != len(episode.furniture.added):
                added = len(episode.furniture.added)
                raise ValueError(f"own.{episode_id} has {len(origins)} origins; the episode adds {added} props")


@dataclass(frozen=True, slots=True)
class OriginCounts:
    """Number of props and facades by origin.

    Attributes:
        agreed_props, agreed_facades: the sections' props and facades recovered by agreement.
        drawn_props: the sections' props drawn at random.
        own_coloured, own_text, own_drawn: the episodes' own props by origin COLOUR, TEXT and DRAWN.
    """

    agreed_props: int
    agreed_facades: int
    drawn_props: int
    own_coloured: int
    own_text: int
    own_drawn: int

    def __str__(self) -> str:
        """Return a summary in one line of the counts above 0; empty if all are 0."""
        agreed = [_counted(self.agreed_props, "landmark"), _counted(self.agreed_facades, "facade")]
        drawn = f"{self.drawn_props + self.own_drawn} drawn"
        parts = [
            (self.agreed_props + self.agreed_facades, f"{' and '.join(filter(None, agreed))} recovered by agreement"),
            (self.own_text, f"{self.own_text} put where an episode's own text says"),
            (
                self.own_coloured,
                f"{_counted(self.own_coloured, 'landmark')} in the colour that an episode's own text says",
            ),
            (
                self.drawn_props + self.own_drawn,
                f"{drawn} ({self.own_drawn} for single episodes)" if self.own_drawn else drawn,
            ),
        ]
        return ", ".join(text for count, text in parts if count)


def _counted(count: int, noun: str) -> str:
    """Return a count and its noun; empty for 0."""
    return f"{count} {noun}{'s' if count != 1 else ''}" if count else ""


def origins_of(provenance: Iterable[Provenance], sections: Mapping[str, Section]) -> OriginCounts:
    """Count props and facades by origin, in the sections that have a provenance."""
    listed = list(provenance)
    own = Counter(origin for each in listed for origins in each.own.values() for origin in origins)
    agreed = sum(len(each.props) for each in listed)
    return OriginCounts(
        agreed_props=agreed,
        agreed_facades=sum(len(each.buildings) for each in listed),
        drawn_props=sum(len(sections[each.section].props) for each in listed) - agreed,
        own_coloured=own[COLOUR],
        own_text=own[TEXT],
        own_drawn=own[DRAWN],
    )
