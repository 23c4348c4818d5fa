"""Paired comparisons on the board: one family for each list, languages kept together, nothing of single episodes."""

import numpy as np
import pytest

from arramon_server.board.episode_table import EpisodeTable, gap_of, join
from arramon_server.board.standings import BOTH, Mark, ScoresVersion
from arramon_server.errors import BadInput, Conflict, NotFound
from arramon_server.runs.storage import tables
from arramon_server.scoring.episode import METRICS
from tests.board.made import House


def table(**scores: float) -> EpisodeTable:
    """Return the table of episodes with one score everywhere in turn 1, and 0 in turn 2."""
    values = np.zeros((len(scores), 2, len(METRICS)))
    values[:, 0] = np.array(list(scores.values()))[:, None]
    return EpisodeTable(tuple(scores), values)


def test_a_run_against_the_others(house: House) -> None:
    house.publish(house.run("good", [1.0] * 5 + [0.9], agent="good"))
    house.publish(house.run("bad", 0.0, agent="bad"))
    found = house.board.compare_with_all("good")
    ((other, compared),) = found.lines
    assert (found.standing.agent, found.standing.rank, other.agent, other.rank) == ("good", 1, "bad", 2)
    assert compared.difference.mean == pytest.approx(5.9 / 6)
    assert (compared.difference.p, compared.corrected, compared.shown) == (2 / 64, 2 / 64, 1)
    ((_, mirrored),) = house.board.compare_with_all("bad").lines
    assert mirrored.difference.mean == -compared.difference.mean
    assert (mirrored.difference.low, mirrored.difference.high) == (-compared.difference.high, -compared.difference.low)
    assert (mirrored.corrected, mirrored.shown) == (2 / 64, -1)


def test_more_runs_need_more_evidence(house: House) -> None:
    for number, score in enumerate((1.0, 0.5, 0.0)):
        house.publish(house.run(str(number), score, agent=str(number)))
    for _, compared in house.board.compare_with_all("0").lines:
        assert (compared.difference.p, compared.corrected, compared.shown) == (2 / 64, 6 / 64, 0)
    assert [(line.rank, line.last_rank, line.tied) for line in house.board.standings("tiny", "en")] == [
        (1, 3, True)
    ] * 3


def test_the_metric_and_all_languages_together(house: House) -> None:
    for agent, score in (("one", 1.0), ("other", 0.5)):
        house.publish(house.run(f"{agent}-en", score, agent=agent))
        house.publish(house.run(f"{agent}-hi", score, agent=agent, language="hi"))
    for sort in ("nDTW", "PTC@CTC-3"):
        found = house.board.compare_with_all("other-hi", BOTH, sort)
        assert [entry.run.run_id for entry in found.standing.entries] == ["other-en", "other-hi"]
        ((_, compared),) = found.lines
        assert compared.difference.mean == pytest.approx(-0.5)
        assert compared.difference.p == 2 / 64  # six episodes, in one language or in two


@pytest.mark.parametrize(
    ("run_id", "language", "sort", "error", "message"),
    [
        ("told", "", "nDTW", Conflict, r"run 'told' is not ranked \(privileged\)"),
        ("plain", "", "PTC", BadInput, "cannot sort by 'PTC'"),
        ("plain", BOTH, "nDTW", NotFound, "there is no run 'plain' in the standings of 'tiny' in 'both'"),
        ("plain", "hi", "nDTW", NotFound, "there is no run 'plain' in the standings of 'tiny' in 'hi'"),
        ("hidden", "", "nDTW", NotFound, "there is no run 'hidden' on the leaderboard"),
    ],
)
def test_what_is_not_compared(
    house: House, run_id: str, language: str, sort: str, error: type[Exception], message: str
) -> None:
    house.run("hidden")
    house.publish(house.run("plain"))
    house.publish(house.run("told", sensors=("oracle",)))
    with pytest.raises(error, match=message):
        house.board.compare_with_all(run_id, language, sort)


def test_runs_that_are_not_ranked_are_in_no_family(house: House) -> None:
    house.publish(house.run("plain"))
    house.publish(house.run("part", [1.0]))
    assert house.board.compare_with_all("plain").lines == ()
    assert house.board.standings("tiny", "en")[1].marks == (Mark.PARTIAL,)


def test_a_family_is_computed_once(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []

    def episodes(version: ScoresVersion) -> EpisodeTable:
        read.append(version.run_id)
        return house.entries.episodes(version.run_id)

    monkeypatch.setattr(house.board._comparisons, "_read", episodes)
    house.publish(house.run("one", agent="one"))
    house.publish(house.run("two", agent="two"))
    for _ in range(2):
        house.board.standings("tiny", "en")
    house.publish(house.run("other", language="hi"))  # another list changes
    house.board.standings("tiny", "en")
    assert sorted(read) == ["one", "two"]


def test_an_entry_without_episodes_gets_them_from_the_journal(house: House) -> None:
    house.publish(house.run("old", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]))
    before = house.entries.episodes("old")
    for content in (None, b""):
        with house.database.write() as connection:
            connection.execute(tables.entries.update().values(episodes=content))
        again = house.entries.episodes("old")
        assert (again.ids, again.scores.tolist()) == (before.ids, before.scores.tolist())


def test_a_packed_table_is_the_same(house: House) -> None:
    made = table(a=0.1, दो=1 / 3)
    again = EpisodeTable.unpacked(made.packed())
    assert again is not None
    assert (again.ids, again.scores.tolist()) == (made.ids, made.scores.tolist())


def test_languages_are_joined_by_episode() -> None:
    joined = join([table(a=1.0, b=0.0), table(a=0.5, b=0.5)], {"a": "1", "b": "2"})
    assert joined.ids == ("a", "b")
    assert joined.values[:, :, 0].tolist() == [[0.75, 0.0, 0.375], [0.25, 0.0, 0.125]]
    assert (joined.strata.tolist(), joined.are_sections) == ([0, 1], True)


def test_the_mean_of_uneven_languages_is_that_of_their_means() -> None:
    english, hindi = table(a=1.0, b=0.0, c=0.0), table(a=0.5)
    joined = join([english, hindi], dict.fromkeys("abc", "1"))
    assert joined.values[:, 0, 0].mean() == pytest.approx((1 / 3 + 1 / 2) / 2)
    assert (joined.strata.tolist(), joined.are_sections) == ([1, 0, 0], False)


def test_the_gap_is_over_the_episodes_that_all_languages_have() -> None:
    english, hindi = table(a=1.0, b=0.0, c=0.25), table(a=0.5, c=0.25)
    gap = gap_of([english, hindi], ["en", "hi"], dict.fromkeys("abc", "1"), "nDTW")
    assert gap is not None
    assert (gap.higher, gap.lower, gap.mean, gap.same, gap.episodes) == ("en", "hi", 0.125, 0.5, 2)
    assert gap_of([table(a=1.0), table(b=1.0)], ["en", "hi"], {"a": "1", "b": "1"}, "nDTW") is None


def test_systems_in_all_languages_have_a_gap(house: House) -> None:
    house.publish(house.run("e", 1.0))
    house.publish(house.run("h", 0.0, language="hi"))
    (line,) = house.board.both("tiny")
    assert line.gap is not None
    assert (line.gap.higher, line.gap.mean, line.gap.same, line.gap.episodes) == ("en", 1.0, 0.0, 4)
    assert [one.gap for one in house.board.standings("tiny", "en")] == [None]
