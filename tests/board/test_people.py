"""People as a group: mean over people, intervals, sections walked before, and what is left out."""

from pathlib import Path

import numpy as np
import pytest

from arramon_server.board.people import PeopleBoard
from arramon_server.runs.accounts.callers import HOST
from tests.board.leaderboard_backend import LeaderboardBackend

AIDS = (("compass", "off"), ("frame_strip", "off"), ("landing_diagram", "on"))
PLAIN = (("compass", "off"), ("frame_strip", "off"), ("landing_diagram", "off"))


@pytest.fixture
def backend(tmp_path: Path) -> LeaderboardBackend:
    return LeaderboardBackend(tmp_path)


def people_of(backend: LeaderboardBackend) -> PeopleBoard:
    return PeopleBoard(backend.board, backend.journal, backend.splits)


def test_every_person_counts_once_whatever_they_played(backend: LeaderboardBackend) -> None:
    scores = {"ann": [1.0, 1.0, 1.0, 1.0], "bob": [0.0, 0.5]}
    for number, (who, values) in enumerate(scores.items()):
        backend.publish(backend.run(f"{number:032x}", values, agent="human", participant=who, arguments=PLAIN))
    (group,) = people_of(backend).groups("tiny", "en")
    assert (group.people, group.episodes, group.arguments) == (2, 6, PLAIN)
    assert group.mean == pytest.approx(np.full(7, 0.625))  # of 1 and 0.25
    assert group.by_people is not None
    assert (group.by_people.low < group.mean).all()
    assert (group.mean < group.by_people.high).all()
    assert group.by_episodes.mean == pytest.approx(np.full(7, 4.5 / 6))
    walked = [(part.times, part.episodes, float(part.means[0])) for part in group.walked_before]
    assert walked == [(0, 2, 0.5), (1, 2, 0.75), (2, 1, 1.0), (3, 1, 1.0)]


def test_one_person_has_no_interval_over_people(backend: LeaderboardBackend) -> None:
    for number in range(2):
        backend.publish(backend.run(f"{number:032x}", [1.0], agent="human", participant="ann", arguments=PLAIN))
    (group,) = people_of(backend).groups("tiny", "en")
    assert (group.people, group.episodes, group.by_people) == (1, 2, None)
    assert [part.times for part in group.walked_before] == [0, 1]


def test_people_without_a_name_are_not_known_to_be_one(backend: LeaderboardBackend) -> None:
    for number in range(2):
        backend.publish(backend.run(f"{number:032x}", [1.0], agent="human", participant="anonymous", arguments=PLAIN))
    (group,) = people_of(backend).groups("tiny", "en")
    assert group.people == 2


def test_aids_make_groups_of_their_own(backend: LeaderboardBackend) -> None:
    for number, aids in enumerate((AIDS, PLAIN)):
        backend.publish(backend.run(f"{number:032x}", [1.0], agent="human", arguments=aids))
    assert [group.arguments for group in people_of(backend).groups("tiny", "en")] == [PLAIN, AIDS]


def test_what_is_no_part_of_a_group(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("1" * 32, agent="walker"))
    backend.run("2" * 32, agent="human")  # not published
    backend.publish(backend.run("3" * 32, agent="human", steps=20))  # other limits
    backend.publish(backend.run("4" * 32, agent="human", split="secret"))
    backend.publish(backend.run("5" * 32, agent="human"))
    backend.publisher.withdraw(HOST, "5" * 32)
    people = people_of(backend)
    assert people.groups("tiny", "en") == []
    assert people.groups("secret", "en") == []
