"""Recovery of landmarks on which many texts agree."""

from dataclasses import replace

import numpy as np

from arramon_dataset.release.landmarks.mentions import Event
from arramon_dataset.release.landmarks.mixture import MentionsOfKind, peaks_of
from arramon_dataset.release.landmarks.recovery import CERTAIN, TurnText, recover
from tests.dataset.release.landmarks.walks import path_along

PLACE = (6.0, 11.7)
"""Of a mailbox beside a street that everybody walks."""


def texts(number: int, event: Event) -> TurnText:
    """Return what one of many people says who pass the place: they come from different sides and go on differently."""
    start = ((0, 10), (-number % 5, 10))[number % 2]
    path = path_along(start, (12, 10), (12, 10 + 6 + number % 4))
    return TurnText(str(number), 1, "en", path, (event, Event(direction="left")))


MAILBOX = Event(kind="mailbox", colour="blue", manner="past", side="left")


def test_a_landmark_is_where_most_people_put_it() -> None:
    (found,) = recover([texts(number, MAILBOX) for number in range(24)])
    assert (found.kind, found.colour) == ("mailbox", "blue")
    assert found.votes >= CERTAIN
    assert np.hypot(found.x - PLACE[0], found.z - PLACE[1]) < 4.0
    assert found.languages == (("en", found.votes),) or abs(found.languages[0][1] - found.votes) < 0.1


def test_two_people_are_not_enough() -> None:
    assert recover([texts(number, MAILBOX) for number in range(2)]) == []


def test_things_drawn_for_each_episode_are_no_landmarks() -> None:
    assert recover([texts(number, replace(MAILBOX, kind="cone")) for number in range(24)]) == []


def test_the_order_of_the_episodes_does_not_matter() -> None:
    people = [texts(number, MAILBOX) for number in range(16)]
    assert recover(people) == recover(people[::-1])


def test_the_mixture_gathers_where_mentions_overlap() -> None:
    cells = np.array([(x, 0.0) for x in range(20)], dtype=np.float64)
    likely = np.zeros((12, 20))
    for row in range(12):  # Wide votes of several cells each, which share one cell.
        likely[row, 5 - row % 4 : 9 - row % 4] = 1.0
    colours = ["red"] * 7 + ["blue"] * 2 + [""] * 3
    (peak,) = peaks_of(MentionsOfKind(cells, likely, np.ones(12), colours, [""] * 12), 5.0)
    assert abs(peak.x - 5.0) < 1.0
    assert peak.votes > 8.0
    assert peak.colours[0][0] == "red"


def test_mentions_in_passing_count_once_for_one_thing() -> None:
    cells = np.array([(0.0, 0.0), (9.0, 0.0)])
    likely = np.array([[1.0, 0.0]] * 8)
    whole, shared = (
        peaks_of(MentionsOfKind(cells, likely, weights, [""] * 8, [""] * 8), 0.5)[0].votes
        for weights in (np.ones(8), np.full(8, 0.5))
    )
    assert shared < 0.6 * whole
