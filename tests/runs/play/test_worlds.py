"""Worlds: created once per section, also for sections in several splits."""

from contextlib import closing
from dataclasses import replace

import numpy as np

from server.episodes.splits import Split
from server.runs.play.worlds import Worlds
from server.sim.rules import begin
from tests import tiny

OTHER = replace(tiny.SECTION, heading=45.0)


def split(name: str, section: str, world: str = "1") -> Split:
    episodes = {"0": replace(tiny.episode("0"), section=section)}
    sections = {section: replace(tiny.SECTION if world == "1" else OTHER, id=section)}
    return Split(name, False, "tests", episodes, sections, name)


def test_splits_with_the_same_section_share_it() -> None:
    one, two = split("one", "1"), split("two", "1")
    with closing(Worlds({"one": one, "two": two})) as worlds:
        assert worlds.ground("one", "1") is worlds.ground("two", "1")
        assert worlds.scene("one", "1") is worlds.scene("two", "1")


def test_different_sections_of_one_name_stay_separate() -> None:
    one, two = split("one", "1"), split("two", "1", "2")
    with closing(Worlds({"one": one, "two": two})) as worlds:
        assert worlds.scene("one", "1") is not worlds.scene("two", "1")
        first, second = (
            worlds.render(each.name, each.episodes["0"], begin(each.episodes["0"].layout), 32).rgb
            for each in (one, two)
        )
    assert not np.array_equal(first, second)
