"""Training data of `vl_grounded`: consistent exchange of things, attributes, rooms, vocabulary."""

from pathlib import Path
from random import Random

import numpy as np
import pytest
import torch

import arramon_lang as lang
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.perception.eyes.vocabulary import COLOURS
from arramon_agents.reading.reader.network import ReaderNetwork
from arramon_agents.reading.reader.network import ReaderSizes as ReaderSizes
from arramon_agents.reading.reader.vocabulary import Vocabulary
from arramon_agents.training.demonstrations import DemonstrationSource
from arramon_agents.training.name_permutation import NamePermutation, instruction_versions
from arramon_agents.vl_grounded.attributes import KINDS, LOOKS
from arramon_agents.vl_grounded.initial_vocabulary import initialise_from_reader, tokenizer_with_reader
from arramon_agents.vl_grounded.instruction_encoder import InstructionEncoder
from arramon_agents.vl_grounded.room_views import collect_views
from arramon_agents.vl_grounded.task import attributes_ahead
from arramon_lang.cell_grading import RoomObject
from arramon_lang.meaning import Navigation, Thing, Walk

MEANT = Navigation(
    (
        Walk("past", (Thing("bench"),), "left"),
        Walk("to", (Thing("banner", "red", "star"),)),
        Walk("past", (Thing("cone", "blue"),)),
        Walk("past", (Thing("building", "", "brick"),)),
    ),
    Thing("mug", "red", "dotted"),
)


def shown(**channels: int) -> np.ndarray:
    features = np.zeros(len(CHANNEL_NAMES), np.uint8)
    for name, value in channels.items():
        features[CHANNEL_NAMES.index(name.replace("__", ":").replace("_colour", " colour"))] = value
    return features


def channel(features: np.ndarray, group: str) -> str:
    """Return the name that is shown in a group."""
    (found,) = [
        name.split(":")[1]
        for name, value in zip(CHANNEL_NAMES, features, strict=True)
        if name.startswith(f"{group}:") and value
    ]
    return found


@pytest.mark.parametrize("seed", range(4))
def test_things_are_exchanged_alike_in_images_and_words(seed: int) -> None:
    permutation = NamePermutation.draw(Random(seed))
    said = permutation.permute_meaning(MEANT)
    assert isinstance(said, Navigation)
    seen = shown(kind__mug=9, colour__red=9, pattern__dotted=9, furniture__bench=9, banner_colour__red=9, shape__star=9,
                 facade__brick=9)[permutation.channels]  # fmt: skip
    assert channel(seen, "kind") == said.target.kind
    assert channel(seen, "colour") == said.target.colour
    assert channel(seen, "pattern") == said.target.look
    bench, banner, cone, building = (step.things[0] for step in said.steps if isinstance(step, Walk))
    assert channel(seen, "furniture") == bench.kind
    assert (channel(seen, "banner colour"), channel(seen, "shape")) == (banner.colour, banner.look)
    assert cone == Thing("cone", "blue")  # Kinds that have colours stay what they are.
    assert channel(seen, "facade") == building.look
    (standing,) = permutation.permute_objects([RoomObject("mug", "red", "dotted", 1, 2)])
    assert standing == RoomObject(said.target.kind, said.target.colour, said.target.look, 1, 2)


def test_versions_say_what_is_meant() -> None:
    text = lang.load("en").write(MEANT, Random(1))
    first, *others = instruction_versions({"en": text}, "navigation", ("en", "hi"), 3, "seed")
    assert (first.texts, first.permutation) == ({"en": text}, None)
    assert len(others) == 3
    for version in others:
        assert version.permutation is not None
        for language, written in version.texts.items():
            assert lang.load(language).read(written, "navigation") == version.permutation.permute_meaning(MEANT)
    assert instruction_versions({"en": text}, "navigation", ("en", "hi"), 3, "seed")[3].texts == others[2].texts


def test_what_was_picked_up_is_named_as_it_was_seen() -> None:
    frame = np.zeros((7, 7, len(CHANNEL_NAMES)), np.uint8)
    assert attributes_ahead(frame) == (-1, -1, -1)
    near = {"nearness of collectible": 100}
    frame[4, 3] = shown(kind__mug=250, kind__bowl=3, colour__blue=250, pattern__striped=250, **near)
    frame[4, 0] = shown(kind__tv=250, colour__red=250, pattern__dotted=250) + 2 * shown(**near)  # Nearer, but aside.
    assert attributes_ahead(frame) == (KINDS.index("mug"), COLOURS.index("blue"), LOOKS.index(("pattern", "striped")))


def test_words_begin_as_the_reader_knows_them() -> None:
    torch.manual_seed(1)
    vocabulary = Vocabulary(["left", "mug", "बाएँ"])
    network = ReaderNetwork(ReaderSizes(len(vocabulary))).eval()
    words = tokenizer_with_reader(["go left go"], vocabulary)
    assert set(words.vocabulary) == {"go", "left", "mug", "बाएँ"}
    reading = InstructionEncoder(words.size).eval()
    initialise_from_reader(reading, words, network, vocabulary)
    for text, known in (("left mug", ["left", "mug"]), ("बाएँ mug left xyz", ["बाएँ", "mug", "left", ""])):
        own = reading(torch.tensor([words.encode(text)]))
        torch.testing.assert_close(own, network._encode(torch.tensor([[vocabulary.code(word) for word in known]])))
    small = ReaderNetwork(ReaderSizes(len(vocabulary), embedding=8))
    with pytest.raises(ValueError, match="a reader's words have 8 numbers, not 64"):
        initialise_from_reader(reading, words, small, vocabulary)


def test_rooms_are_seen_once_and_kept(data: Path, tmp_path: Path) -> None:
    source = DemonstrationSource(data, "train", ("en", "hi"), "eyes", 3)
    first = [view for part in collect_views(source, tmp_path) for view in part]
    assert [view.turn for view in first] == [1, 2] * 3
    for view in first:
        assert view.target == (2, 2)
        assert set(view.texts) == ({"en"} if int(view.episode_id) % 3 == 0 else {"en", "hi"})
        seen = {thing.cell: (thing.kind, thing.colour, thing.look) for thing in view.things}
        assert seen[0, 0] == ("bowl", "white", "dotted")
        assert seen.get((2, 2)) == (("mug", "red", "striped") if view.turn == 2 else None)
    (written,) = tmp_path.rglob("*.json")
    before = written.stat().st_mtime_ns
    assert [view for part in collect_views(source, tmp_path) for view in part] == first
    assert written.stat().st_mtime_ns == before
