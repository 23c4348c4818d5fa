"""What can be played: texts, verifications of them and of known episodes; nothing else."""

from arramon_collecting.storage.store import Store
from arramon_collecting.verifying.text_source import StoredTexts
from arramon_server.episodes.splits import Split
from tests import tiny
from tests.collecting.collecting import TEXTS, Field

EPISODES = {name: tiny.episode(name) for name in ("e0", "e1")}
OWN = {"sample": Split("sample", False, "tests", EPISODES, {"1": tiny.SECTION}, "0" * 64)}


def said(found: object) -> list[str]:
    assert found is not None
    return [text for turn in found.instructions for text in (turn.navigation, turn.assembly)]  # type: ignore[attr-defined]


def test_texts_and_their_verifications_are_found(field: Field) -> None:
    source = StoredTexts(field.store, OWN)
    text = field.write(field.worker()).text
    assert text is not None
    task = field.store.tasks.claim_verify(field.collection, field.worker(), ())
    assert task is not None
    for key in (text.text_id, task.task_id):
        found = source.playable_text("col", key)
        assert found is not None
        assert (found.key, found.split, found.episode_id, found.language) == (key, "sample", "e0", "en")
        assert said(found) == [one for pair in TEXTS for one in pair]


def test_a_known_episode_has_its_own_texts(field: Field) -> None:
    store = Store(field.database, field.clock, lambda: 0.0)
    settings = field.collection.settings.model_copy(update={"gold_share": 0.5})
    collection = store.collections.create("golds", "write", "hi", "sample", settings)
    field.collection = collection
    field.write(field.worker())
    task = store.tasks.claim_verify(collection, field.worker(), ["e1"])
    assert task is not None
    assert task.is_gold
    hindi = EPISODES["e1"].instructions["hi"]
    assert said(StoredTexts(store, OWN).playable_text("golds", task.task_id)) == [
        text for turn in hindi for text in (turn.navigation, turn.assembly)
    ]
    assert StoredTexts(store, {}).playable_text("golds", task.task_id) is None  # the split is not served


def test_nothing_else_is_found(field: Field) -> None:
    source = StoredTexts(field.store, OWN)
    author = field.worker()
    text = field.write(author).text
    assert text is not None
    writing = field.claim(author)
    for collection, key in (
        ("col", "0" * 32), ("others", text.text_id), ("col", writing.task_id), ("col", author.worker_id),
    ):  # fmt: skip
        assert source.playable_text(collection, key) is None
    other = field.store.collections.create("others", "write", "en", "sample", field.collection.settings)
    assert source.playable_text(other.name, text.text_id) is None
    field.store.removal.forget(field.collection, author.worker_id, keep_texts=False)
    assert source.playable_text("col", text.text_id) is None  # its text is gone
