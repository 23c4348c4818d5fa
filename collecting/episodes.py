"""Which episodes of a split a collection uses: those that are written for, and known ones."""

from arramon_collecting.storage.records import Collection
from arramon_server.episodes.splits import Split


def episodes_to_write(split: Split, collection: Collection) -> list[str]:
    """Return the ids of the episodes that instructions are written for, in the split's shuffled order."""
    order = [episode.episode_id for episode in split.in_playing_order(*split.languages)]
    return order[: collection.settings.episodes or None]


def golds(split: Split, collection: Collection) -> list[str]:
    """Return the ids of the episodes whose instructions are known: those designated, or all with texts."""
    with_texts = [episode.episode_id for episode in split.in_playing_order(collection.language)]
    designated = set(collection.settings.gold_episodes)
    return [one for one in with_texts if not designated or one in designated]
