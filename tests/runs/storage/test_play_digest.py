"""The digest of a play: the same for the same play, and another one for any other."""

from dataclasses import replace

import pytest

from arramon_server.runs.storage.play_digest import play_digest
from arramon_server.runs.storage.records import RUNNING, EpisodeEnding, Run
from tests.played import BEGUN

RUN = Run("r", "lab", "walker", "tiny", "en", ("rgb",), 8, "0", "0.1.0", RUNNING, BEGUN)
ACTIONS = {"0": [0, 1, 2], "1": []}
ENDINGS = [EpisodeEnding("r", name, "AGENT_FINISHED", 3, []) for name in ACTIONS]


def digest(run: Run = RUN, endings: list[EpisodeEnding] = ENDINGS, **actions: list[int]) -> str:
    taken = ACTIONS | {name.removeprefix("of_"): found for name, found in actions.items()}
    return play_digest(run, endings, lambda _, episode_id: taken[episode_id])


def test_the_digest_of_a_fixed_play_never_changes() -> None:
    """Figures that are signed in receipts depend on it."""
    assert digest() == "51792175424db34ea39f05999c2fc47accfccdd688f5a8182ccbb79bf3ce0f6d"


def test_who_plays_when_and_in_which_order_does_not_matter() -> None:
    other = replace(RUN, run_id="s", participant="other", agent="runner", language="hi", server_version="9")
    assert digest(other) == digest(endings=ENDINGS[::-1]) == digest()


def test_scores_do_not_enter() -> None:
    scored = [replace(ending, scores=[{"PTC": 1.0}] * 2) for ending in ENDINGS]
    assert digest(endings=scored) == digest()


@pytest.mark.parametrize(
    "other",
    [
        digest(of_0=[0, 1, 3]),
        digest(of_0=[0, 1]),
        digest(of_0=[], of_1=[0, 1, 2]),
        digest(replace(RUN, steps_per_phase=9)),
        digest(endings=[ENDINGS[0], replace(ENDINGS[1], cause="TIME_LIMIT")]),
    ],
)
def test_whatever_scores_follow_from_enters(other: str) -> None:
    assert other != digest()
