"""What verifications play, from the storage: texts, and known episodes with the split's own texts."""

from collections.abc import Mapping

from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import Text
from arramon_collecting.storage.work.records import VERIFY, Task
from arramon_collecting.verifying.text_splits import PlayableText
from arramon_server.episodes.episode import Instructions
from arramon_server.episodes.splits import Split
from arramon_server.errors import NotFound


class StoredTexts:
    """Finds texts in the storage (`text_splits.TextSource`). Thread-safe.

    Args:
        store: storage of the collections.
        own: splits of the data folder, by name.
    """

    def __init__(self, store: Store, own: Mapping[str, Split]) -> None:
        self._store = store
        self._own = own

    def playable_text(self, collection: str, key: str) -> PlayableText | None:
        """Return what is followed in a verification, or the present version of a text; None if there is none."""
        try:
            found = self._store.collections.get(collection)
        except NotFound:
            return None
        task, text = self._task(key), None
        if task is not None and (task.stage != VERIFY or task.collection != collection):
            return None
        if task is not None and task.is_gold:
            return self._gold(found, task)
        text = self._text(key if task is None else task.text_id or "")
        if text is None or text.collection != collection or not text.instructions:
            return None
        (first, second) = (Instructions(*pair) for pair in text.instructions)
        return PlayableText(collection, key, found.split, text.episode_id, text.language, (first, second))

    def _gold(self, collection: Collection, task: Task) -> PlayableText | None:
        split, language = self._own.get(collection.split), collection.language
        episode = split.episodes.get(task.episode_id) if split is not None else None
        texts = episode.instructions.get(language) if episode is not None else None
        if texts is None:
            return None
        return PlayableText(collection.name, task.task_id, collection.split, task.episode_id, language, texts)

    def _task(self, task_id: str) -> Task | None:
        try:
            return self._store.tasks.get(task_id)
        except NotFound:
            return None

    def _text(self, text_id: str) -> Text | None:
        try:
            return self._store.texts.get(text_id)
        except NotFound:
            return None
