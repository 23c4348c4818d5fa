"""Demands of episodes from the meaning of their instructions, the same in every language."""

from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

import arramon_lang as lang
from arramon_dataset.demands import add_demands, demands_of, episode_demands
from arramon_dataset.paraphrases.collection import install as add_paraphrased
from arramon_lang.meaning import Assembly, Navigation, Rotate, Thing, Walk, Where
from arramon_server.episodes.demands import TurnDemands
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.splits import read_split, split_folder, write_split
from arramon_server.errors import BadInput
from tests import tiny

HYDRANT, BENCH = Thing("hydrant", identity="hydrant/1"), Thing("bench", identity="bench/1")
HOUSE, CROSSING = Thing("building", colour="green", identity="building/1"), Thing("intersection", identity="place/1")
MUG = Thing("mug", "red", "striped", where=(Where("behind", (BENCH,)),), identity="target")

WAYS = (
    Navigation((Rotate("left"), Walk("to", (HYDRANT,)), Rotate("right", "at", HOUSE), Walk("ahead")), MUG),
    Navigation((Walk("past", (BENCH,)), Rotate("left", "at", CROSSING)), MUG),
)
TV, BOOK = Thing("tv", "green", "dotted", identity="tv"), Thing("book", "blue", "striped", identity="book")
PLACES = (
    Assembly((), Thing("mug", identity="target"), (Where("behind", (TV,)),)),
    Assembly(("right",), Thing("mug", identity="target"), (Where("between", (TV, BOOK)),)),
)

EXPECTED = (
    TurnDemands(("turn", "to", "turn_at", "ahead"), ("object", "building", "object"), ("behind",), ("behind",)),
    TurnDemands(("past", "turn_at"), ("object", "place"), ("behind",), ("between",)),
)
"""The bench of the second turn is named twice, and counts once."""


def episode(seed: int) -> Episode:
    """An episode whose instructions say this in every language."""
    texts = {
        code: tuple(
            Instructions(*(lang.load(code).write(meaning, Random(seed)) for meaning in pair))
            for pair in zip(WAYS, PLACES, strict=True)
        )
        for code in lang.required()
    }
    instructions = {code: (turns[0], turns[1]) for code, turns in texts.items()}
    return replace(tiny.episode(str(seed)), instructions=instructions)


@pytest.mark.parametrize("code", ["en", "hi"])
@pytest.mark.parametrize("seed", range(4))
def test_demands_are_those_of_the_meaning_in_every_language(code: str, seed: int) -> None:
    assert episode_demands(episode(seed), code) == EXPECTED


def test_demands_are_written_beside_a_generated_split(tmp_path: Path) -> None:
    episodes = [episode(seed) for seed in range(2)]
    split = write_split(
        tmp_path, "made", hidden=True, source="generated, scale 1, seed 1", episodes=episodes, sections=[tiny.SECTION]
    )
    assert split.demands == {}
    found = add_demands(tmp_path, split)
    assert found.demands == {"0": EXPECTED, "1": EXPECTED} == demands_of(split)
    assert found.data_hash == split.data_hash == read_split(split_folder(tmp_path, "made")).data_hash


def test_texts_that_no_grammar_wrote_are_refused(tmp_path: Path) -> None:
    paraphrased = add_paraphrased(tmp_path)
    with pytest.raises(BadInput, match="only where they were generated"):
        add_demands(tmp_path, paraphrased)
    with pytest.raises(BadInput, match=r"split 'tiny' is tests; .* only where they were generated"):
        add_demands(tmp_path, tiny.write(tmp_path))
