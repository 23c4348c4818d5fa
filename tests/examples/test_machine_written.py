"""The split of texts by language models: it plays, says what it is, and keeps what its README counts."""

import json

from arramon_server.episodes.splits import read_split
from tests import ROOT

FOLDER = ROOT / "examples" / "machine_written"


def test_the_split_is_read_and_says_what_it_is() -> None:
    split = read_split(FOLDER)
    assert "not people's texts" in split.source
    assert split.languages == {"en": 7, "hi": 8}
    collection = json.loads((FOLDER / "collection.json").read_text())
    assert collection["data_hash"] == split.data_hash


def test_every_kept_text_led_its_follower() -> None:
    collections = json.loads((FOLDER / "collection.json").read_text())["collections"]
    texts = [text for collection in collections for text in collection["texts"]]
    assert len(texts) == 15
    for text in texts:
        (verification,) = text["verifications"]
        assert min(verification["ndtw"]) > 0.2
        assert verification["ptc"] == [1.0, 1.0]
        assert verification["worker"] != text["author"]
