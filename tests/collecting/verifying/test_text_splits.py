"""One text as a split: stable, hidden, unlisted, and playable beside equal sections."""

from contextlib import closing
from dataclasses import replace

import pytest

from arramon_collecting.verifying.text_splits import PlayableText, TextSplits, split_name, text_split
from arramon_server.episodes.episode import Instructions
from arramon_server.episodes.split_lookup import SplitLookup
from arramon_server.episodes.splits import Split
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.footprints import Footprints
from tests import tiny

TEXT_ID, OTHER_ID = "a" * 32, "b" * 32
TEXTS = (Instructions("Walk to the mug.", "Put it down."), Instructions("Then to the TV.", "Put it there."))
TEXT = PlayableText("people", TEXT_ID, "tiny", "1", "te", TEXTS)


def tiny_split(name: str = "tiny") -> Split:
    episodes = {str(number): tiny.episode(str(number)) for number in range(3)}
    return Split(name, False, "tests", episodes, {"1": tiny.SECTION}, "0" * 64)


class Texts:
    """A source of texts in memory."""

    def __init__(self, *texts: PlayableText) -> None:
        self.texts = {(text.collection, text.key): text for text in texts}

    def playable_text(self, collection: str, key: str) -> PlayableText | None:
        return self.texts.get((collection, key))


def test_a_text_is_a_split_of_one_hidden_episode_that_is_not_ranked() -> None:
    split = text_split(tiny_split(), TEXT)
    assert (split.name, split.hidden, split.training) == (f"collecting/people/{TEXT_ID}", True, True)
    (episode,) = split.episodes.values()
    assert (episode.episode_id, dict(episode.instructions)) == (TEXT_ID, {"te": TEXTS})
    assert episode.turns == tiny.episode("1").turns


@pytest.mark.parametrize(
    ("changed", "same"),
    [
        (TEXT, True),
        (replace(TEXT, collection="others"), True),  # what is played is the same
        (replace(TEXT, instructions=(TEXTS[0], TEXTS[0])), False),
        (replace(TEXT, key=OTHER_ID), False),
        (replace(TEXT, language="hi"), False),
    ],
)
def test_its_hash_is_that_of_what_is_played(changed: PlayableText, same: bool) -> None:
    hashes = {text_split(tiny_split(), TEXT).data_hash, text_split(tiny_split(), changed).data_hash}
    assert len(hashes) == (1 if same else 2)


def test_texts_are_found_by_name_and_never_listed() -> None:
    own = {"tiny": tiny_split()}
    source = Texts(TEXT, replace(TEXT, key=OTHER_ID, split="gone"))
    lookup = SplitLookup(own)
    lookup.add(TextSplits(own, source))
    name = split_name("people", TEXT_ID)
    assert lookup[name] is lookup[name]
    assert (list(lookup), len(lookup), list(TextSplits(own, source))) == (["tiny"], 1, [])
    for unknown in (
        split_name("people", "c" * 32), split_name("others", TEXT_ID), split_name("people", OTHER_ID),
        f"{name}/more", name.upper(), f"collecting/people/../{TEXT_ID}", "collecting", "",
    ):  # fmt: skip
        assert unknown not in lookup
    before = lookup[name]
    source.texts["people", TEXT_ID] = replace(TEXT, instructions=(TEXTS[1], TEXTS[1]))  # sent back, and mended
    assert lookup[name].data_hash != before.data_hash


def test_its_world_is_that_of_the_host_s_section() -> None:
    own = {"tiny": tiny_split()}
    lookup = SplitLookup(own)
    lookup.add(TextSplits(own, Texts(TEXT)))
    with closing(Worlds(lookup, physics=Footprints)) as worlds:
        split = lookup[split_name("people", TEXT_ID)]
        world = worlds.world(split.name, split.episodes[TEXT_ID])
        assert world.scene is worlds.world("tiny", own["tiny"].episodes["1"]).scene
