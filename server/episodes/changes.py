"""What changed between two states of a split's data: the world, the ground truth, or the texts of its episodes."""

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, replace

from arramon_server.episodes.episode import Episode, Turn
from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict

MOST_NAMED = 5
"""Episodes that an error names."""


@dataclass(frozen=True, slots=True)
class EpisodeChanges:
    """Ids of the episodes that changed; each is in one set or several.

    Attributes:
        world: what an agent is shown, or what stops it, is another: the section, the start, the furniture, the objects
            in the street or the room.
        truth: the ground truth is another: path, actions, which object is the target, or its cell.
        texts: an instruction is another.
    """

    world: frozenset[str]
    truth: frozenset[str]
    texts: frozenset[str]

    @property
    def all(self) -> frozenset[str]:
        """All episodes that changed."""
        return self.world | self.truth | self.texts


def changes_between(before: Split, after: Split) -> EpisodeChanges:
    """Return what changed in a split's episodes.

    Raises:
        Conflict: if both do not have the same episodes, in the same languages, and the same rules about what is public:
            then scores on one are no scores on the other.
    """
    if before.episodes.keys() != after.episodes.keys():
        gone = named(before.episodes.keys() - after.episodes.keys())
        new = named(after.episodes.keys() - before.episodes.keys())
        raise Conflict(
            f"split {after.name!r} does not have the episodes that it had: {gone} left out, {new} added; expected the "
            "same episodes (one that cannot be corrected is voided: `arramon-server void`)"
        )
    if (before.hidden, before.training) != (after.hidden, after.training):
        raise Conflict(f"split {after.name!r} was hidden or for training before and is not now, or the other way round")
    pairs = [(before.episodes[name], episode) for name, episode in after.episodes.items()]
    if spoken := [one.episode_id for one, other in pairs if one.instructions.keys() != other.instructions.keys()]:
        raise Conflict(f"other languages than before in {named(spoken)} of split {after.name!r}; expected the same")
    redrawn = {name for name, section in before.sections.items() if after.sections.get(name) != section}
    return EpisodeChanges(
        frozenset(two.episode_id for one, two in pairs if one.section in redrawn or _world(one) != _world(two)),
        frozenset(two.episode_id for one, two in pairs if _truth(one) != _truth(two)),
        frozenset(two.episode_id for one, two in pairs if one.instructions != two.instructions),
    )


def named(episode_ids: Collection[str]) -> str:
    """Return a number of episodes with the names of the first of them."""
    ordered = sorted(episode_ids)
    if not ordered:
        return "no episode"
    more = ", ..." if len(ordered) > MOST_NAMED else ""
    listed = ", ".join(map(repr, ordered[:MOST_NAMED])) + more
    return f"{len(ordered)} episode{'s' if len(ordered) > 1 else ''} ({listed})"


def _world(episode: Episode) -> object:
    """Return what the rules and the camera depend on, whatever the target is among the objects of the street."""
    streets = [Counter(turn.street) for turn in episode.turns]
    return episode.section, episode.start, episode.furniture, episode.decoys, streets


def _truth(episode: Episode) -> tuple[Turn, ...]:
    return tuple(replace(turn, street=turn.street[:1]) for turn in episode.turns)
