"""Paired comparisons on the board: one family for each list, languages kept together, nothing of single episodes."""

import numpy as np
import pytest

from arramon_server.board.episode_table import EpisodeTable, join_languages, language_gap_of
from arramon_server.board.standings import BOTH, Mark, ScoresVersion
from arramon_server.errors import BadInput, Conflict, NotFound
from arramon_server.runs.storage import tables
from arramon_server.scoring.episode_scores import METRICS
from tests.board.leaderboard_backend import LeaderboardBackend


def table(**scores: float) -> EpisodeTable:
    """Return the table of episodes with one score everywhere in turn 1, and 0 in turn 2."""
    values = np.zeros((len(scores), 2, len(METRICS)))
    values[:, 0] = np.array(list(scores.values()))[:, None]
    return EpisodeTable(tuple(scores), values)


def test_a_run_against_the_others(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("good", [1.0] * 5 + [0.9], agent="good"))
    backend.publish(backend.run("bad", 0.0, agent="bad"))
    found = backend.board.compare_with_all("good")
    ((other, compared),) = found.lines
    assert (found.standing.agent, found.standing.rank, other.agent, other.rank) == ("good", 1, "bad", 2)
    assert compared.difference.mean == pytest.approx(5.9 / 6)
    assert (compared.difference.p, compared.corrected, compared.shown) == (2 / 64, 2 / 64, 1)
    ((_, mirrored),) = backend.board.compare_with_all("bad").lines
    assert mirrored.difference.mean == -compared.difference.mean
    assert (mirrored.difference.low, mirrored.difference.high) == (-compared.difference.high, -compared.difference.low)
    assert (mirrored.corrected, mirrored.shown) == (2 / 64, -1)


def test_more_runs_need_more_evidence(backend: LeaderboardBackend) -> None:
    for number, score in enumerate((1.0, 0.5, 0.0)):
        backend.publish(backend.run(str(number), score, agent=str(number)))
    for _, compared in backend.board.compare_with_all("0").lines:
        assert (compared.difference.p, compared.corrected, compared.shown) == (2 / 64, 6 / 64, 0)
    assert [(line.rank, line.last_rank, line.tied) for line in backend.board.standings("tiny", "en")] == [
        (1, 3, True)
    ] * 3


def test_the_metric_and_all_languages_together(backend: LeaderboardBackend) -> None:
    for agent, score in (("one", 1.0), ("other", 0.5)):
        backend.publish(backend.run(f"{agent}-en", score, agent=agent))
        backend.publish(backend.run(f"{agent}-hi", score, agent=agent, language="hi"))
    for sort in ("nDTW", "PTC@CTC-3"):
        found = backend.board.compare_with_all("other-hi", BOTH, sort)
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
    backend: LeaderboardBackend, run_id: str, language: str, sort: str, error: type[Exception], message: str
) -> None:
    backend.run("hidden")
    backend.publish(backend.run("plain"))
    backend.publish(backend.run("told", sensors=("oracle",)))
    with pytest.raises(error, match=message):
        backend.board.compare_with_all(run_id, language, sort)


def test_runs_that_are_not_ranked_are_in_no_family(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("plain"))
    backend.publish(backend.run("part", [1.0]))
    assert backend.board.compare_with_all("plain").lines == ()
    assert backend.board.standings("tiny", "en")[1].marks == (Mark.PARTIAL,)


def test_a_family_is_computed_once(backend: LeaderboardBackend, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []

    def episodes(version: ScoresVersion) -> EpisodeTable:
        read.append(version.run_id)
        return backend.entries.counted_episode_scores(version.run_id)

    monkeypatch.setattr(backend.board._comparisons, "_read", episodes)
    backend.publish(backend.run("one", agent="one"))
    backend.publish(backend.run("two", agent="two"))
    for _ in range(2):
        backend.board.standings("tiny", "en")
    backend.publish(backend.run("other", language="hi"))  # another list changes
    backend.board.standings("tiny", "en")
    assert sorted(read) == ["one", "two"]


def test_an_entry_without_episodes_gets_them_from_the_journal(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("old", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]))
    before = backend.entries.counted_episode_scores("old")
    for content in (None, b""):
        with backend.database.write() as connection:
            connection.execute(tables.entries.update().values(episodes=content))
        again = backend.entries.counted_episode_scores("old")
        assert (again.ids, again.scores.tolist()) == (before.ids, before.scores.tolist())


def test_a_packed_table_is_the_same(backend: LeaderboardBackend) -> None:
    made = table(a=0.1, दो=1 / 3)
    again = EpisodeTable.unpacked(made.packed())
    assert again is not None
    assert (again.ids, again.scores.tolist()) == (made.ids, made.scores.tolist())


def test_languages_are_joined_by_episode() -> None:
    joined = join_languages([table(a=1.0, b=0.0), table(a=0.5, b=0.5)], {"a": "1", "b": "2"})
    assert joined.ids == ("a", "b")
    assert joined.values[:, :, 0].tolist() == [[0.75, 0.0, 0.375], [0.25, 0.0, 0.125]]
    assert (joined.strata.tolist(), joined.are_sections) == ([0, 1], True)


def test_the_mean_of_uneven_languages_is_that_of_their_means() -> None:
    english, hindi = table(a=1.0, b=0.0, c=0.0), table(a=0.5)
    joined = join_languages([english, hindi], dict.fromkeys("abc", "1"))
    assert joined.values[:, 0, 0].mean() == pytest.approx((1 / 3 + 1 / 2) / 2)
    assert (joined.strata.tolist(), joined.are_sections) == ([1, 0, 0], False)


def test_the_gap_is_over_the_episodes_that_all_languages_have() -> None:
    english, hindi = table(a=1.0, b=0.0, c=0.25), table(a=0.5, c=0.25)
    gap = language_gap_of([english, hindi], ["en", "hi"], dict.fromkeys("abc", "1"), "nDTW")
    assert gap is not None
    assert (gap.higher, gap.lower, gap.mean, gap.same, gap.episodes) == ("en", "hi", 0.125, 0.5, 2)
    assert language_gap_of([table(a=1.0), table(b=1.0)], ["en", "hi"], {"a": "1", "b": "1"}, "nDTW") is None


def test_systems_in_all_languages_have_a_gap(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("e", 1.0))
    backend.publish(backend.run("h", 0.0, language="hi"))
    (line,) = backend.board.combined_standings("tiny")
    assert line.gap is not None
    assert (line.gap.higher, line.gap.mean, line.gap.same, line.gap.episodes) == ("en", 1.0, 0.0, 4)
    assert [one.gap for one in backend.board.standings("tiny", "en")] == [None]
