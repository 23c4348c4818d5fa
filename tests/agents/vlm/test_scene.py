"""What stands where, in words."""

from typing import Any

import numpy as np
import pytest

from arramon_agents.vlm.prompt_texts import PromptFolder, Prompts
from arramon_agents.vlm.scene import MOST_THINGS, describe, find_things, name_of
from arramon_client.agent import Label
from arramon_server.sim.labels import LABELS
from tests.agents.vlm import helpers

SIZE = 100

ENGLISH = PromptFolder(None, pytest.fail).of("en")

KINDS = (
    Label("nothing"),
    Label("road"),
    Label("mug", "red", "striped"),
    Label("bench"),
    Label("building", "", "brick"),
)


FREE = (
    "Free in front: 4.3 units at 20 degrees to the left, 20.0 units straight ahead, "
    "21.3 units at 20 degrees to the right."
)


def images() -> tuple[np.ndarray, np.ndarray]:
    """A road, with two mugs beside each other at different depths, and a bench to the left."""
    segmentation, depth = np.ones((SIZE, SIZE), np.uint16), np.full((SIZE, SIZE), 20.0, np.float32)
    for rows, columns, kind, metres in (
        (slice(60, 70), slice(45, 50), 2, 2.0),
        (slice(60, 70), slice(50, 58), 2, 6.0),
        (slice(50, 70), slice(0, 20), 3, 4.0),
    ):
        segmentation[rows, columns], depth[rows, columns] = kind, metres
    segmentation[0, 0] = 4  # too small to be named
    return segmentation, depth


def test_things_are_told_apart_by_depth_and_sorted_by_distance() -> None:
    things = find_things(*images(), KINDS)
    assert [(each.label.kind, each.distance) for each in things] == [("mug", 2.0), ("bench", 4.0), ("mug", 6.0)]
    assert [round(each.bearing) for each in things] == [-1, -25, 3]


def test_without_depth_there_are_no_distances() -> None:
    segmentation, _ = images()
    things = find_things(segmentation, None, KINDS)
    assert [(each.label.kind, each.distance) for each in things] == [("mug", None), ("bench", None)]


@pytest.mark.parametrize(
    ("given", "lines"),
    [
        (("depth", "segmentation"), [
            FREE,
            "What stands where, nearest first:",
            "- the striped red mug, 2.0 units away, straight ahead",
            "- the bench, 4.0 units away, 25 degrees to the left",
            "- the striped red mug, 6.0 units away, straight ahead",
        ]),
        (("segmentation",), [
            "What stands where, nearest first:",
            "- the striped red mug, straight ahead",
            "- the bench, 25 degrees to the left",
        ]),
        (("depth",), [
            FREE,
        ]),
        ((), ["Nothing is known of what is in view."]),
    ],
)  # fmt: skip
def test_words_by_what_the_split_offers(given: tuple[str, ...], lines: list[str]) -> None:
    segmentation, depth = images()
    all_images: dict[str, Any] = {"segmentation": segmentation, "depth": depth}
    observation = helpers.seen(0, **{name: all_images[name] for name in given})
    assert describe(observation, KINDS, ENGLISH).splitlines() == lines


def test_an_empty_view() -> None:
    nothing = helpers.seen(0, segmentation=np.zeros((SIZE, SIZE), np.uint16), depth=np.zeros((SIZE, SIZE), np.float32))
    free, things = describe(nothing, KINDS, ENGLISH).splitlines()
    assert free.count("more than 60 units") == 3
    assert things == "No thing is in view."


def test_the_nearest_things_are_named() -> None:
    segmentation = np.zeros((SIZE, SIZE), np.uint16)
    segmentation[::5, :] = 3
    assert len(find_things(segmentation, None, KINDS)) == MOST_THINGS


@pytest.mark.parametrize("language", ["en", "hi"])
def test_everything_that_can_be_seen_has_a_name(language: str) -> None:
    prompts: Prompts = PromptFolder(None, pytest.fail).of(language)
    unnamed = ("nothing", "road", "pavement", "roof", "floor", "ceiling")
    labels = [Label(each.kind, each.colour, each.look) for each in LABELS if each.kind not in unnamed]
    names = {name_of(label, prompts) for label in labels}
    assert len(names) > 0.9 * len(labels)
    assert all(name and "  " not in name for name in names)
    if language == "hi":
        assert not [name for name in names if any("a" <= letter.lower() <= "z" for letter in name)]
