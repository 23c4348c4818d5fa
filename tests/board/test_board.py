"""Standings from published runs: scores, marks, coverage, several languages."""

from pathlib import Path
from typing import Any

import pytest

from arramon_server.board.board import Board
from arramon_server.board.standings import BOTH, Mark
from arramon_server.errors import BadInput, NotFound
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.play.clocks import ClockSettings
from tests import tiny
from tests.board.leaderboard_backend import CLOCKS, STEPS, LeaderboardBackend


def test_board_without_runs_has_empty_standings(backend: LeaderboardBackend) -> None:
    assert backend.board.languages() == {"secret": ("en", "hi"), "tiny": ("en", "hi")}
    assert backend.board.standings("tiny", "en") == []
    assert backend.board.combined_standings("tiny") == []


def test_standing_holds_the_runs_scores_signature_and_note(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("r1", [1.0, 1.0, 0.0, 0.0, 0.0, 0.0], agent="walker"), "code: example.org")
    (line,) = backend.board.standings("tiny", "en")
    (entry,) = line.entries
    assert (line.rank, line.tied, line.agent, line.participant) == (1, False, "walker", "lab")
    assert line.rows["total"]["PTC@CTC-3"].mean == pytest.approx(2 / 6)
    assert line.rows["total"]["PTC@CTC-3"].low < 2 / 6 < line.rows["total"]["PTC@CTC-3"].high
    assert set(line.rows) == {"turn 1", "turn 2", "total"}
    assert (entry.progress.episodes, entry.causes, entry.note) == (6, {"AGENT_FINISHED": 6}, "code: example.org")
    assert entry.signature.startswith("split:tiny|lang:en|episodes:6|steps:150|")
    assert (line.coverage, line.marks) == (1.0, ())


def test_scores_are_the_same_when_they_are_read_from_the_database(backend: LeaderboardBackend) -> None:
    run = backend.run("r1", [0.1, 0.2, 0.3, 1 / 3, 0.7, 0.0])
    backend.publish(run)
    first = backend.entries.scores(run)
    again = Board(type(backend.entries)(backend.database), backend.splits, steps_per_phase=STEPS, clocks=CLOCKS)
    assert again.entry(run).rows == first.rows
    assert again.entry(run).progress == first.progress


def test_standings_hold_only_the_requested_split_and_language(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("en", agent="e"))
    backend.publish(backend.run("hi", agent="h", language="hi"))
    backend.publish(backend.run("hidden", agent="s", split="secret"))
    backend.run("unpublished", agent="u")
    assert [line.agent for line in backend.board.standings("tiny", "en")] == ["e"]
    assert [line.agent for line in backend.board.standings("tiny", "hi")] == ["h"]
    assert [line.agent for line in backend.board.standings("secret", "en")] == ["s"]


@pytest.mark.parametrize(
    ("fields", "marks", "coverage", "rank"),
    [
        ({}, (), 1.0, 1),
        ({"scores": [1.0, 1.0, 1.0]}, (Mark.PARTIAL,), 0.5, 0),
        ({"sensors": ("rgb", "segmentation")}, (), 1.0, 1),
        ({"sensors": ("rgb", "pose")}, (Mark.PRIVILEGED,), 1.0, 0),
        ({"sensors": ("oracle",)}, (Mark.PRIVILEGED,), 1.0, 0),
        ({"steps": STEPS + 1}, (Mark.OTHER_LIMITS,), 1.0, 0),
        ({"clocks": ClockSettings(30.0, 3600.0)}, (Mark.OTHER_CLOCKS,), 1.0, 0),
        ({"clocks": ClockSettings(60.0, 7200.0)}, (Mark.OTHER_CLOCKS,), 1.0, 0),
        ({"clocks": ClockSettings()}, (Mark.OTHER_CLOCKS,), 1.0, 0),
        ({"cause": "SERVER_FAULT"}, (Mark.SERVER_FAULT,), 1.0, 1),
        ({"scores": [1.0], "sensors": ("oracle",)}, (Mark.PARTIAL, Mark.PRIVILEGED), 1 / 6, 0),
    ],
)
def test_run_properties_determine_marks_coverage_and_rank(
    backend: LeaderboardBackend, fields: dict[str, Any], marks: tuple[Mark, ...], coverage: float, rank: int
) -> None:
    backend.publish(backend.run("r1", **fields))
    (line,) = backend.board.standings("tiny", "en")
    assert (line.marks, line.coverage, line.rank) == (marks, coverage, rank)


def test_runs_with_other_clocks_than_the_server_are_unranked(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("timed", agent="timed"))
    backend.publish(backend.run("untimed", 0.5, agent="untimed", clocks=ClockSettings()))
    now = Board(backend.entries, backend.splits, steps_per_phase=STEPS, clocks=ClockSettings())
    assert [(line.agent, line.rank, line.marks) for line in backend.board.standings("tiny", "en")] == [
        ("timed", 1, ()),
        ("untimed", 0, (Mark.OTHER_CLOCKS,)),
    ]
    assert [(line.agent, line.rank, line.marks) for line in now.standings("tiny", "en")] == [
        ("untimed", 1, ()),
        ("timed", 0, (Mark.OTHER_CLOCKS,)),
    ]


def test_a_local_board_ranks_by_the_settings_that_most_of_its_runs_share(backend: LeaderboardBackend) -> None:
    local = Board(backend.entries, backend.splits, steps_per_phase=STEPS, clocks=CLOCKS, local=True)
    fast = ClockSettings(30.0, 600.0)

    def ranks() -> list[tuple[str, int, tuple[Mark, ...]]]:
        return [(line.agent, line.rank, line.marks) for line in local.standings("tiny", "en")]

    backend.publish(backend.run("untimed", agent="untimed", clocks=ClockSettings()))
    assert ranks() == [("untimed", 1, ())]
    backend.publish(backend.run("fast", 0.5, agent="fast", clocks=fast))
    assert ranks() == [("fast", 1, ()), ("untimed", 0, (Mark.OTHER_CLOCKS,))]  # as many of both: the latest
    backend.publish(backend.run("short", 0.1, agent="short", clocks=ClockSettings(), steps=10))
    backend.publish(backend.run("hindi", agent="hindi", clocks=ClockSettings(), language="hi"))
    assert ranks() == [
        ("untimed", 1, ()),
        ("fast", 0, (Mark.OTHER_CLOCKS,)),
        ("short", 0, (Mark.OTHER_LIMITS,)),
    ]
    assert local.entry("fast").marks == (Mark.OTHER_CLOCKS,)
    backend.publisher.withdraw(HOST, "hindi")
    backend.publisher.withdraw(HOST, "untimed")
    assert ranks() == [("short", 1, ()), ("fast", 0, (Mark.OTHER_LIMITS, Mark.OTHER_CLOCKS))]


def test_runs_on_changed_or_missing_data_are_listed_with_a_mark(backend: LeaderboardBackend, tmp_path: Path) -> None:
    backend.publish(backend.run("r1", [0.5] * 6))
    changed = Board(
        backend.entries, {"tiny": tiny.write(tmp_path / "other", "tiny", 4)}, steps_per_phase=STEPS, clocks=CLOCKS
    )
    gone = Board(backend.entries, {}, steps_per_phase=STEPS, clocks=CLOCKS)
    for board in (changed, gone):
        (line,) = board.standings("tiny", "en")
        assert (line.marks, line.coverage, line.rank) == ((Mark.OTHER_DATA,), None, 0)
        assert line.rows == backend.entries.scores("r1").rows
    assert gone.languages() == {"tiny": ("en",)}


@pytest.mark.parametrize(
    ("split", "language", "sort", "error", "message"),
    [
        ("moon", "en", "nDTW", NotFound, "there is no split 'moon'; the leaderboard has secret, tiny"),
        ("moon", BOTH, "nDTW", NotFound, "there is no split 'moon'; the leaderboard has secret, tiny"),
        ("tiny", "fr", "nDTW", NotFound, "split 'tiny' has no language 'fr'; it has en, hi, both"),
        (
            "tiny", "en", "PTC", BadInput,
            "cannot sort by 'PTC'; expected one of nDTW, CTC-0, CTC-3, CTC-5, CTC-7, rPOD@CTC-3, PTC@CTC-3",
        ),
    ],
)  # fmt: skip
def test_invalid_listings_are_refused(
    backend: LeaderboardBackend, split: str, language: str, sort: str, error: type[Exception], message: str
) -> None:
    with pytest.raises(error) as caught:
        backend.board.standings(split, language, sort)
    assert str(caught.value) == message


def test_combined_standing_is_the_mean_over_languages(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("en", [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]))
    backend.publish(backend.run("hi", 1.0, language="hi"))
    (line,) = backend.board.combined_standings("tiny")
    assert (line.languages, line.agent, line.rank) == (("en", "hi"), "walker", 1)
    total = line.rows["total"]["nDTW"]
    assert (total.mean, total.low, total.high) == pytest.approx((0.75, 0.408, 0.929), abs=0.001)
    assert line.causes == {"AGENT_FINISHED": 10}
    assert backend.board.standings("tiny", BOTH) == [line]


def test_only_systems_with_every_language_are_listed(backend: LeaderboardBackend) -> None:
    backend.participant("ann", "bob")
    backend.publish(backend.run("1", agent="lone"))
    backend.publish(backend.run("2", agent="shared", account="ann", participant="ann"))
    backend.publish(backend.run("3", agent="shared", account="bob", participant="bob", language="hi"))
    backend.publish(backend.run("4", agent="whole", account="ann", participant="ann"))
    backend.publish(backend.run("5", agent="whole", account="ann", participant="ann", language="hi"))
    assert [(line.participant, line.agent) for line in backend.board.combined_standings("tiny")] == [("ann", "whole")]


def test_combined_standing_uses_the_latest_ranked_run(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("hi", 0.5, language="hi"))
    backend.publish(backend.run("best", 0.9))
    backend.publish(backend.run("latest", 0.1))
    backend.publish(backend.run("told", 1.0, sensors=("oracle",)))
    (line,) = backend.board.combined_standings("tiny")
    assert [entry.run.run_id for entry in line.entries] == ["latest", "hi"]


def test_combined_standing_has_the_marks_of_every_run(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("en", 1.0))
    backend.publish(backend.run("hi", [1.0], language="hi", sensors=("oracle",)))
    (line,) = backend.board.combined_standings("tiny")
    assert (line.marks, line.rank) == ((Mark.PARTIAL, Mark.PRIVILEGED), 0)
    assert (line.coverage, line.sensors) == (0.25, ("rgb", "depth", "oracle"))


def test_an_entry_of_a_published_run_names_its_receipt(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("r1"))
    fingerprint = backend.board.entry("r1").receipt_fingerprint
    assert fingerprint is not None
    assert (len(fingerprint.digest), len(fingerprint.public_key)) == (32, 32)
    (line,) = backend.board.standings("tiny", "en")
    assert line.entries[0].receipt_fingerprint is None


def test_entries_of_unpublished_runs_are_not_found(backend: LeaderboardBackend) -> None:
    backend.run("r1")
    backend.publish(backend.run("r2"))
    backend.publisher.withdraw(HOST, "r2")
    for run_id in ("r1", "r2", "r3"):
        with pytest.raises(NotFound, match=f"there is no run '{run_id}' on the leaderboard"):
            backend.board.entry(run_id)


def test_control_characters_in_names_are_replaced(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("r1", agent="a\x1b[2J\u202eb", participant="क्‍ष\r"))
    (line,) = backend.board.standings("tiny", "en")
    assert (line.agent, line.participant) == ("a\ufffd[2J\ufffdb", "क्‍ष\ufffd")


@pytest.mark.parametrize(
    ("split", "language", "lines"), [("val_seen", "en", 6), ("val_seen", "hi", 0), ("tiny", "en", 0)]
)
def test_paper_results_are_listed_for_the_papers_splits_in_english(
    backend: LeaderboardBackend, split: str, language: str, lines: int
) -> None:
    assert len(backend.board.reference(split, language)) == lines
