"""Differences between two versions of a split's data: in the world, the ground truth, or the texts of its episodes."""

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, replace

from arramon_server.episodes.episode import Episode, Turn
from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict

MOST_NAMED = 5
"""Maximum number of episodes that an error names."""


@dataclass(frozen=True, slots=True)
class EpisodeChanges:
    """Ids of the changed episodes, each in one or several sets.

    Attributes:
        world: changes of images or collisions: the section, the start, the furniture, the objects in the street or the
            room.
        truth: changes of the ground truth: path, actions, choice of the target, or its cell.
        texts: changes of an instruction.
    """

    world: frozenset[str]
    truth: frozenset[str]
    texts: frozenset[str]

    @property
    def all(self) -> frozenset[str]:
        """All changed episodes."""
        return self.world | self.truth | self.texts


def changes_between(before: Split, after: Split) -> EpisodeChanges:
    """Return the changes in a split's episodes.

    Raises:
        Conflict: if the episodes, their languages or the rules about public data differ, so that scores on one version
            are not valid for the other.
    """
    if before.episodes.keys() != after.episodes.keys():
        gone = describe_episodes(before.episodes.keys() - after.episodes.keys())
        new = describe_episodes(after.episodes.keys() - before.episodes.keys())
        raise Conflict(
            f"split {after.name!r} does not have the episodes that it had: {gone} left out, {new} added; expected the "
            "same episodes (one that cannot be corrected is voided: `arramon-server void`)"
        )
    if (before.hidden, before.training) != (after.hidden, after.training):
        raise Conflict(f"split {after.name!r} was hidden or for training before and is not now, or the other way round")
    pairs = [(before.episodes[name], episode) for name, episode in after.episodes.items()]
    others = [one.episode_id for one, other in pairs if one.instructions.keys() != other.instructions.keys()]
    if others:
        raise Conflict(
            f"other languages than before in {describe_episodes(others)} of split {after.name!r}; expected the same"
        )
    redrawn = {name for name, section in before.sections.items() if after.sections.get(name) != section}
    return EpisodeChanges(
        frozenset(two.episode_id for one, two in pairs if one.section in redrawn or _world(one) != _world(two)),
        frozenset(two.episode_id for one, two in pairs if _truth(one) != _truth(two)),
        frozenset(two.episode_id for one, two in pairs if one.instructions != two.instructions),
    )


def describe_episodes(episode_ids: Collection[str]) -> str:
    """Return the number of some episodes and the first ids, as text."""
    ordered = sorted(episode_ids)
    if not ordered:
        return "no episode"
    more = ", ..." if len(ordered) > MOST_NAMED else ""
    listed = ", ".join(map(repr, ordered[:MOST_NAMED])) + more
    return f"{len(ordered)} episode{'s' if len(ordered) > 1 else ''} ({listed})"


def _world(episode: Episode) -> object:
    """Return the data that rules and camera depend on; the choice of the target does not matter."""
    streets = [Counter(turn.street) for turn in episode.turns]
    return episode.section, episode.start, episode.furniture, episode.decoys, streets


def _truth(episode: Episode) -> tuple[Turn, ...]:
    return tuple(replace(turn, street=turn.street[:1]) for turn in episode.turns)
