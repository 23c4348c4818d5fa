"""Standings from published runs: scores, marks, coverage, several languages."""

from pathlib import Path
from typing import Any

import pytest

from arramon_server.board.board import Board
from arramon_server.board.standings import BOTH, Mark
from arramon_server.errors import BadInput, NotFound
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.play.clocks import Clocks
from tests import tiny
from tests.board.made import CLOCKS, STEPS, House


def test_board_without_runs_has_empty_standings(house: House) -> None:
    assert house.board.languages() == {"secret": ("en", "hi"), "tiny": ("en", "hi")}
    assert house.board.standings("tiny", "en") == []
    assert house.board.both("tiny") == []


def test_standing_holds_the_runs_scores_signature_and_note(house: House) -> None:
    house.publish(house.run("r1", [1.0, 1.0, 0.0, 0.0, 0.0, 0.0], agent="walker"), "code: example.org")
    (line,) = house.board.standings("tiny", "en")
    (entry,) = line.entries
    assert (line.rank, line.tied, line.agent, line.participant) == (1, False, "walker", "lab")
    assert line.rows["total"]["PTC@CTC-3"].mean == pytest.approx(2 / 6)
    assert line.rows["total"]["PTC@CTC-3"].low < 2 / 6 < line.rows["total"]["PTC@CTC-3"].high
    assert set(line.rows) == {"turn 1", "turn 2", "total"}
    assert (entry.progress.episodes, entry.causes, entry.note) == (6, {"AGENT_FINISHED": 6}, "code: example.org")
    assert entry.signature.startswith("split:tiny|lang:en|episodes:6|steps:150|")
    assert (line.coverage, line.marks) == (1.0, ())


def test_scores_are_the_same_when_they_are_read_from_the_database(house: House) -> None:
    run = house.run("r1", [0.1, 0.2, 0.3, 1 / 3, 0.7, 0.0])
    house.publish(run)
    first = house.entries.scores(run)
    again = Board(type(house.entries)(house.database), house.splits, steps_per_phase=STEPS, clocks=CLOCKS)
    assert again.entry(run).rows == first.rows
    assert again.entry(run).progress == first.progress


def test_standings_hold_only_the_requested_split_and_language(house: House) -> None:
    house.publish(house.run("en", agent="e"))
    house.publish(house.run("hi", agent="h", language="hi"))
    house.publish(house.run("hidden", agent="s", split="secret"))
    house.run("unpublished", agent="u")
    assert [line.agent for line in house.board.standings("tiny", "en")] == ["e"]
    assert [line.agent for line in house.board.standings("tiny", "hi")] == ["h"]
    assert [line.agent for line in house.board.standings("secret", "en")] == ["s"]


@pytest.mark.parametrize(
    ("fields", "marks", "coverage", "rank"),
    [
        ({}, (), 1.0, 1),
        ({"scores": [1.0, 1.0, 1.0]}, (Mark.PARTIAL,), 0.5, 0),
        ({"sensors": ("rgb", "segmentation")}, (), 1.0, 1),
        ({"sensors": ("rgb", "pose")}, (Mark.PRIVILEGED,), 1.0, 0),
        ({"sensors": ("oracle",)}, (Mark.PRIVILEGED,), 1.0, 0),
        ({"steps": STEPS + 1}, (Mark.OTHER_LIMITS,), 1.0, 0),
        ({"clocks": Clocks(30.0, 3600.0)}, (Mark.OTHER_CLOCKS,), 1.0, 0),
        ({"clocks": Clocks(60.0, 7200.0)}, (Mark.OTHER_CLOCKS,), 1.0, 0),
        ({"clocks": Clocks()}, (Mark.OTHER_CLOCKS,), 1.0, 0),
        ({"cause": "SERVER_FAULT"}, (Mark.SERVER_FAULT,), 1.0, 1),
        ({"scores": [1.0], "sensors": ("oracle",)}, (Mark.PARTIAL, Mark.PRIVILEGED), 1 / 6, 0),
    ],
)
def test_run_properties_determine_marks_coverage_and_rank(
    house: House, fields: dict[str, Any], marks: tuple[Mark, ...], coverage: float, rank: int
) -> None:
    house.publish(house.run("r1", **fields))
    (line,) = house.board.standings("tiny", "en")
    assert (line.marks, line.coverage, line.rank) == (marks, coverage, rank)


def test_runs_with_other_clocks_than_the_server_are_unranked(house: House) -> None:
    house.publish(house.run("timed", agent="timed"))
    house.publish(house.run("untimed", 0.5, agent="untimed", clocks=Clocks()))
    now = Board(house.entries, house.splits, steps_per_phase=STEPS, clocks=Clocks())
    assert [(line.agent, line.rank, line.marks) for line in house.board.standings("tiny", "en")] == [
        ("timed", 1, ()),
        ("untimed", 0, (Mark.OTHER_CLOCKS,)),
    ]
    assert [(line.agent, line.rank, line.marks) for line in now.standings("tiny", "en")] == [
        ("untimed", 1, ()),
        ("timed", 0, (Mark.OTHER_CLOCKS,)),
    ]


def test_a_local_board_ranks_by_the_settings_that_most_of_its_runs_share(house: House) -> None:
    local = Board(house.entries, house.splits, steps_per_phase=STEPS, clocks=CLOCKS, local=True)
    fast = Clocks(30.0, 600.0)

    def ranks() -> list[tuple[str, int, tuple[Mark, ...]]]:
        return [(line.agent, line.rank, line.marks) for line in local.standings("tiny", "en")]

    house.publish(house.run("untimed", agent="untimed", clocks=Clocks()))
    assert ranks() == [("untimed", 1, ())]
    house.publish(house.run("fast", 0.5, agent="fast", clocks=fast))
    assert ranks() == [("fast", 1, ()), ("untimed", 0, (Mark.OTHER_CLOCKS,))]  # as many of both: the latest
    house.publish(house.run("short", 0.1, agent="short", clocks=Clocks(), steps=10))
    house.publish(house.run("hindi", agent="hindi", clocks=Clocks(), language="hi"))
    assert ranks() == [
        ("untimed", 1, ()),
        ("fast", 0, (Mark.OTHER_CLOCKS,)),
        ("short", 0, (Mark.OTHER_LIMITS,)),
    ]
    assert local.entry("fast").marks == (Mark.OTHER_CLOCKS,)
    house.publisher.withdraw(HOST, "hindi")
    house.publisher.withdraw(HOST, "untimed")
    assert ranks() == [("short", 1, ()), ("fast", 0, (Mark.OTHER_LIMITS, Mark.OTHER_CLOCKS))]


def test_runs_on_changed_or_missing_data_are_listed_with_a_mark(house: House, tmp_path: Path) -> None:
    house.publish(house.run("r1", [0.5] * 6))
    changed = Board(
        house.entries, {"tiny": tiny.write(tmp_path / "other", "tiny", 4)}, steps_per_phase=STEPS, clocks=CLOCKS
    )
    gone = Board(house.entries, {}, steps_per_phase=STEPS, clocks=CLOCKS)
    for board in (changed, gone):
        (line,) = board.standings("tiny", "en")
        assert (line.marks, line.coverage, line.rank) == ((Mark.OTHER_DATA,), None, 0)
        assert line.rows == house.entries.scores("r1").rows
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
    house: House, split: str, language: str, sort: str, error: type[Exception], message: str
) -> None:
    with pytest.raises(error) as caught:
        house.board.standings(split, language, sort)
    assert str(caught.value) == message


def test_combined_standing_is_the_mean_over_languages(house: House) -> None:
    house.publish(house.run("en", [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]))
    house.publish(house.run("hi", 1.0, language="hi"))
    (line,) = house.board.both("tiny")
    assert (line.languages, line.agent, line.rank) == (("en", "hi"), "walker", 1)
    total = line.rows["total"]["nDTW"]
    assert (total.mean, total.low, total.high) == pytest.approx((0.75, 0.408, 0.929), abs=0.001)
    assert line.causes == {"AGENT_FINISHED": 10}
    assert house.board.standings("tiny", BOTH) == [line]


def test_only_systems_with_every_language_are_listed(house: House) -> None:
    house.participant("ann", "bob")
    house.publish(house.run("1", agent="lone"))
    house.publish(house.run("2", agent="shared", account="ann", participant="ann"))
    house.publish(house.run("3", agent="shared", account="bob", participant="bob", language="hi"))
    house.publish(house.run("4", agent="whole", account="ann", participant="ann"))
    house.publish(house.run("5", agent="whole", account="ann", participant="ann", language="hi"))
    assert [(line.participant, line.agent) for line in house.board.both("tiny")] == [("ann", "whole")]


def test_combined_standing_uses_the_latest_ranked_run(house: House) -> None:
    house.publish(house.run("hi", 0.5, language="hi"))
    house.publish(house.run("best", 0.9))
    house.publish(house.run("latest", 0.1))
    house.publish(house.run("told", 1.0, sensors=("oracle",)))
    (line,) = house.board.both("tiny")
    assert [entry.run.run_id for entry in line.entries] == ["latest", "hi"]


def test_combined_standing_has_the_marks_of_every_run(house: House) -> None:
    house.publish(house.run("en", 1.0))
    house.publish(house.run("hi", [1.0], language="hi", sensors=("oracle",)))
    (line,) = house.board.both("tiny")
    assert (line.marks, line.rank) == ((Mark.PARTIAL, Mark.PRIVILEGED), 0)
    assert (line.coverage, line.sensors) == (0.25, ("rgb", "depth", "oracle"))


def test_an_entry_of_a_published_run_names_its_receipt(house: House) -> None:
    house.publish(house.run("r1"))
    seal = house.board.entry("r1").seal
    assert seal is not None
    assert (len(seal.digest), len(seal.public_key)) == (32, 32)
    (line,) = house.board.standings("tiny", "en")
    assert line.entries[0].seal is None


def test_entries_of_unpublished_runs_are_not_found(house: House) -> None:
    house.run("r1")
    house.publish(house.run("r2"))
    house.publisher.withdraw(HOST, "r2")
    for run_id in ("r1", "r2", "r3"):
        with pytest.raises(NotFound, match=f"there is no run '{run_id}' on the leaderboard"):
            house.board.entry(run_id)


def test_control_characters_in_names_are_replaced(house: House) -> None:
    house.publish(house.run("r1", agent="a\x1b[2J\u202eb", participant="क्‍ष\r"))
    (line,) = house.board.standings("tiny", "en")
    assert (line.agent, line.participant) == ("a\ufffd[2J\ufffdb", "क्‍ष\ufffd")


@pytest.mark.parametrize(
    ("split", "language", "lines"), [("val_seen", "en", 6), ("val_seen", "hi", 0), ("tiny", "en", 0)]
)
def test_paper_results_are_listed_for_the_papers_splits_in_english(
    house: House, split: str, language: str, lines: int
) -> None:
    assert len(house.board.reference(split, language)) == lines
