"""Recovered landmarks in the colour that an episode's own text states."""

import pytest

from arramon_dataset.release.landmarks.agreement import WITHIN, nearest_match
from arramon_dataset.release.landmarks.mentions import Event
from arramon_dataset.release.landmarks.recovery import RecoveredLandmark, TurnText, recover
from arramon_dataset.release.landmarks.text_colours import recolour_landmarks
from arramon_server.sim.section import Prop
from tests.dataset.release.landmarks.walks import path_along

PATH = path_along((0, 0), (0, 12))
LANDMARK = RecoveredLandmark("barrel", 1.7, 6.0, "gold", "", 12.0, ("gold", "orange"))
STANDING = Prop("barrel", 1.7, 6.0, 90.0, "gold")


def texts(**said: str) -> list[TurnText]:
    event = Event(**{"kind": "barrel", "manner": "past", "side": "right", **said})  # type: ignore[arg-type]
    return [TurnText("1", 1, "en", PATH, (event,))]


def test_a_landmark_has_the_colour_that_the_text_says_if_others_say_it_too() -> None:
    assert recolour_landmarks(texts(colour="orange"), [STANDING], [LANDMARK], 0.8) == {
        0: Prop("barrel", 1.7, 6.0, 90.0, "orange")
    }


@pytest.mark.parametrize(
    "said",
    [
        {"colour": "gold"},
        {"colour": ""},
        {"colour": "red"},
        {"colour": "orange", "side": "left"},
        {"colour": "orange", "kind": "barrier"},
    ],
    ids=["as most say", "no colour", "nobody else says it", "on the other side", "another kind"],
)
def test_otherwise_it_stays_as_it_is(said: dict[str, str]) -> None:
    assert recolour_landmarks(texts(**said), [STANDING], [LANDMARK], 0.8) == {}


def test_a_banner_has_the_shape_that_the_text_says_with_its_colour() -> None:
    landmark = RecoveredLandmark("banner", 1.7, 6.0, "red", "star", 12.0, ("red", "green"))
    hanging = Prop("banner", 1.7, 6.0, 90.0, "red", "star", "white")
    (changed,) = recolour_landmarks(
        texts(kind="banner", colour="green", look="triangle"), [hanging], [landmark], 0.8
    ).values()
    assert (changed.colour, changed.shape) == ("green", "triangle")
    assert changed.shape_colour not in ("", "green")


def test_the_names_of_a_landmark_are_what_more_than_one_in_ten_say() -> None:
    colours = ["gold"] * 16 + ["orange"] * 7 + ["red"]
    people = [
        TurnText(str(number), 1, "en", path_along((0, 0), (12, 0), (12, 8)),
             (Event(kind="barrel", colour=colour, manner="past", side="left"), Event(direction="left")))
        for number, colour in enumerate(colours)
    ]  # fmt: skip
    (found,) = recover(people)
    assert found.colour == "gold"
    assert set(found.names) == {"gold", "orange"}


@pytest.mark.parametrize(
    ("kind", "thing", "said", "fits"),
    [
        ("bin", "", "green", True),
        ("bin", "", "red", False),
        ("bin", "black", "green", False),
        ("bin", "black", "black", True),
        ("phone_booth", "", "blue", True),
        ("cone", "orange", "blue", False),
    ],
)
def test_what_comes_in_one_colour_is_of_that_colour(kind: str, thing: str, said: str, fits: bool) -> None:
    event = Event(kind=kind, colour=said, manner="past")
    _, apart = nearest_match(event, 6, PATH, [(kind, 1.7, 6.0, thing, "")])
    assert (apart <= WITHIN) is fits
