"""Hidden splits on the leaderboard: what follows from shown means, and what earlier releases stored."""

import json
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
import rfc8785
import sqlalchemy as sa

from arramon_server.board.board import Board
from arramon_server.board.corrector import Corrector
from arramon_server.board.entries import Entries
from arramon_server.board.standings import Mark
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.results.breakdown import Breakdowns
from arramon_server.runs.results.receipts import MASKED_VERSION, VERSION, Receipts, receipt_content
from arramon_server.runs.results.reports import make_report, report_of, score_array
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.records import CodeReference
from arramon_server.scoring.disclosure import rounding_step
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.scoring.masking import (
    Noise,
    digest_without,
    masked_rows,
    mean_interval,
    shown_deviation,
    shown_difference,
)
from tests import tiny
from tests.board.leaderboard_backend import CLOCKS, STEPS, LeaderboardBackend

EPISODES, METRIC = 60, "PTC@CTC-3"


@pytest.fixture
def hidden(backend: LeaderboardBackend, tmp_path: Path) -> LeaderboardBackend:
    """A backend with a hidden split of 60 episodes, 40 of them in Hindi too."""
    backend.splits["guarded"] = tiny.write(tmp_path, "guarded", EPISODES, hidden=True)
    backend.board = Board(backend.entries, backend.splits, steps_per_phase=STEPS, clocks=CLOCKS)
    return backend


def publish(backend: LeaderboardBackend, run_id: str, score: float, **changes: object) -> str:
    return backend.publish(backend.run(run_id, score, split="guarded", **changes))  # type: ignore[arg-type]


def total(backend: LeaderboardBackend, run_id: str) -> float:
    return backend.board.entry(run_id).rows["total"][METRIC].mean


def test_the_same_play_shows_the_same_scores_ranks_and_receipts(hidden: LeaderboardBackend) -> None:
    """Whoever plays it and when; and what is shown is less than a step from the exact scores."""
    scores = [((7 * number) % 10) / 10 for number in range(EPISODES)]
    for run_id in "ab":
        hidden.publish(hidden.run(run_id, scores, split="guarded", agent=run_id, participant=run_id))
    publish(hidden, "other", 0.9, agent="other")
    split, runs = hidden.splits["guarded"], [hidden.journal.run(run_id) for run_id in "ab"]
    reports = [report_of(run, hidden.journal, hidden.splits) for run in runs]
    assert reports[0].table == reports[1].table
    assert reports[0].table.rows == hidden.board.entry("a").rows == hidden.board.entry("b").rows
    payloads = [json.loads(row.payload) for row in hidden.database.read(sa.select(tables.receipts.c.payload))]
    assert payloads[0]["scores"] == payloads[1]["scores"] != payloads[2]["scores"]
    found = Breakdowns(hidden.splits, hidden.journal.play_digest)
    one, other = (found.of(run, hidden.journal.endings(run.run_id)) for run in runs)
    assert one == other
    lines = {line.agent: line for line in hidden.board.standings("guarded", "en")}
    assert (lines["a"].rank, lines["a"].last_rank) == (lines["b"].rank, lines["b"].last_rank)
    ((_, compared),) = (line for line in hidden.board.compare_with_all("a").lines if line[0].agent == "b")
    assert (compared.difference.mean, compared.difference.p, compared.shown) == (0.0, 1.0, 0)
    endings = hidden.journal.endings("a")
    exact = make_report(runs[0], hidden.journal.progress("a"), endings, split, "", exact=True).table.rows
    for row, metrics in reports[0].table.rows.items():
        for metric, value in metrics.items():
            assert abs(value.mean - exact[row][metric].mean) < rounding_step(EPISODES)


def test_another_play_with_the_same_scores_shows_others(hidden: LeaderboardBackend) -> None:
    plays = [hidden.run(str(detour), 0.45, split="guarded", detour=detour) for detour in range(6)]
    tables = [report_of(hidden.journal.run(run_id), hidden.journal, hidden.splits).table for run_id in plays]
    assert len({tuple(value.mean for value in table.rows["turn 1"].values()) for table in tables}) > 3


def test_an_agent_that_scores_nothing_shows_nothing(hidden: LeaderboardBackend) -> None:
    publish(hidden, "stop", 0.0)
    rows = hidden.board.entry("stop").rows
    assert {value.mean for values in rows.values() for value in values.values()} == {0.0}
    assert {value.low for values in rows.values() for value in values.values()} == {0.0}


def test_an_entry_of_an_earlier_release_gets_its_play_from_the_journal(hidden: LeaderboardBackend) -> None:
    publish(hidden, "a", 0.45)
    shown, kept = hidden.board.entry("a").rows, hidden.entries.counted_episode_scores("a")
    old = replace(kept, play_digest="")
    with hidden.database.write() as connection:
        connection.execute(tables.entries.update().values(episodes=old.packed()))
    again = Entries(hidden.database)
    assert (
        again.counted_episode_scores("a").play_digest
        == kept.play_digest
        == hidden.journal.play_digest(hidden.journal.run("a"))
    )
    assert Board(again, hidden.splits, steps_per_phase=STEPS, clocks=CLOCKS).entry("a").rows == shown


def test_seeds_follow_from_shown_means(hidden: LeaderboardBackend) -> None:
    for run_id, score in (("a", 0.4), ("b", 0.6)):
        publish(hidden, run_id, score, arguments=(("seed", run_id),))
    (line,) = hidden.board.standings("guarded", "en")
    means = [total(hidden, run_id) for run_id in "ab"]
    assert line.rows["total"][METRIC].mean == pytest.approx(sum(means) / 2, abs=1e-4)
    assert line.spread is not None
    assert line.spread.deviation == pytest.approx(abs(means[0] - means[1]) / 2**0.5, abs=1e-4)
    assert (line.spread.episodes_deviation, line.spread.rest_deviation) == (None, None)


def test_gap_between_languages_follows_from_shown_means(hidden: LeaderboardBackend) -> None:
    publish(hidden, "a", 0.3)
    publish(hidden, "b", 0.7, language="hi")
    (line,) = hidden.board.combined_standings("guarded")
    means = {"en": total(hidden, "a"), "hi": total(hidden, "b")}
    assert line.rows["total"][METRIC].mean == pytest.approx(sum(means.values()) / 2, abs=1e-4)
    assert line.gap is not None
    higher = max(means, key=lambda code: means[code])
    assert (line.gap.higher, line.gap.episodes) == (higher, 40)
    assert line.gap.mean == pytest.approx(abs(means["en"] - means["hi"]), abs=1e-4)
    assert line.gap.low <= line.gap.mean <= line.gap.high
    parts = round(1 / rounding_step(40))
    assert line.gap.same * parts == pytest.approx(round(line.gap.same * parts))


def test_order_and_ranks_do_not_depend_on_exact_means(hidden: LeaderboardBackend) -> None:
    """Runs of which none is shown to be better are in the order of their shown means, ties by publication."""
    for number in range(12):
        publish(hidden, f"{number:02}", 0.5 + number / 1000, agent=str(number))
    lines = hidden.board.standings("guarded", "en")
    assert {line.rank for line in lines} == {1}
    means = [line.rows["total"][METRIC].mean for line in lines]
    assert means == sorted(means, reverse=True)
    assert [line.agent for line in lines] != [str(number) for number in range(11, -1, -1)]


def test_what_an_earlier_release_stored_exactly_is_shown_masked(hidden: LeaderboardBackend, tmp_path: Path) -> None:
    """Its entry and its receipt have exact scores; the receipt stays as it is, and is not taken for a masked one."""
    publish(hidden, "old", 0.3456)
    shown = hidden.board.entry("old").rows
    split, run = hidden.splits["guarded"], hidden.journal.run("old")
    endings = hidden.journal.endings("old")
    report = make_report(run, hidden.journal.progress("old"), endings, split, "", exact=True)
    assert report.table.rows["total"]["nDTW"].mean == pytest.approx(0.3456)
    content = receipt_content(hidden.journal.actions, report, endings, hidden=True, masked=False)
    assert content["version"] == VERSION
    rows = {
        row: {metric: [one.mean, one.low, one.high] for metric, one in values.items()}
        for row, values in report.table.rows.items()
    }
    with hidden.database.write() as connection:
        of_run = tables.entries.c.run_id == "old"
        kept = connection.execute(sa.select(tables.entries.c.scores).where(of_run)).scalar_one()
        connection.execute(tables.entries.update().where(of_run).values(scores={**kept, "rows": rows}))
        payload = rfc8785.dumps({**content, "attempts": {"number": 1, "begun": 1}})
        connection.execute(tables.receipts.update().values(payload=payload))
    again = Board(Entries(hidden.database), hidden.splits, steps_per_phase=STEPS, clocks=CLOCKS)
    assert again.entry("old").rows == shown
    # The same where the split's data has changed, so that its noise cannot be derived: rounded at least. So it is when
    # a receipt of this release has superseded the old one: the entry has the exact scores all the same.
    key = SigningKey(tmp_path / "key.pem")
    corrector = Corrector(hidden.database, hidden.splits, key)
    corrector.void("guarded", ["0"], "a wall in the way")
    assert corrector.renew_receipts("guarded") == 1
    superseding = Receipts(hidden.database, hidden.splits, key).of(HOST, "old")
    assert json.loads(superseding.payload)["version"] == MASKED_VERSION
    other = {**hidden.splits, "guarded": tiny.write(tmp_path / "other", "guarded", EPISODES - 1, hidden=True)}
    entry = Board(Entries(hidden.database), other, steps_per_phase=STEPS, clocks=CLOCKS).entry("old")
    assert Mark.OTHER_DATA in entry.marks
    assert {entry.rows[row][metric].mean for row in entry.rows for metric in METRICS} == {0.3}


def test_void_episode_leaves_no_trace_in_fresh_figures(hidden: LeaderboardBackend, tmp_path: Path) -> None:
    """Rows, groups, tests and receipts are those of the other episodes, with thresholds of their own, at every door."""
    scores = [((7 * number) % 10) / 10 for number in range(EPISODES)]
    order = [episode.episode_id for episode in hidden.splits["guarded"].in_playing_order("en")]
    for run_id, change in (("a", 0.0), ("b", 0.3)):
        hidden.publish(hidden.run(run_id, [scores[0] + change, *scores[1:]], split="guarded", agent=run_id))
    board, split = hidden.board, hidden.splits["guarded"]
    run, endings = hidden.journal.run("a"), hidden.journal.endings("a")
    before = board.entry("a").rows
    corrector = Corrector(hidden.database, hidden.splits, SigningKey(tmp_path / "key.pem"))
    corrector.void("guarded", order[:1], "a wall in the way")
    after = board.entry("a").rows  # the board of a server that runs
    kept = [ending for ending in endings if ending.episode_id != order[0]]
    play, noise = hidden.journal.play_digest(run), Noise(split.truth_hash)
    assert after == masked_rows(score_array(kept), noise, digest_without(play, order[:1]))
    assert after != masked_rows(score_array(kept), noise, play)
    assert after == report_of(run, hidden.journal, hidden.splits).table.rows
    receipts = Receipts(hidden.database, hidden.splits, SigningKey(tmp_path / "key.pem"))
    content = json.loads(receipts.of(HOST, "a").payload)
    assert (content["version"], content["voided"]) == (MASKED_VERSION, order[:1])
    assert all(set(one) == {"episode_id", "head", "ending"} for one in content["episodes"])
    assert content["scores"]["total"]["nDTW"]["mean"] == after["total"]["nDTW"].mean
    (turn,) = (
        line for line in Breakdowns(hidden.splits, hidden.journal.play_digest).of(run, endings, {order[0]}).lines
        if (line.group.aspect, line.group.name) == ("turn", "first")
    )  # fmt: skip
    assert turn.found.scores["nDTW"] == after["turn 1"]["nDTW"]
    assert board.listing("guarded", "en").family is not None
    corrector.void("guarded", order[:1], "it was right", restore=True)
    assert board.entry("a").rows == before


def test_intervals_of_several_runs_are_those_of_the_episodes_that_are_not_void(
    hidden: LeaderboardBackend, tmp_path: Path
) -> None:
    """With 60 episodes the step is 0.1, with 59 it is 0.2: so much further may the exact means lie apart."""
    hidden.participant("ann", "bob")
    code = CodeReference("https://example.org/walker")
    for run_id, score, account in (("a", 0.4, "ann"), ("b", 0.6, "ann"), ("c", 0.6, "bob")):
        arguments = (("seed", "b" if run_id == "b" else "a"),)
        hidden.run(run_id, score, split="guarded", account=account, participant=account, arguments=arguments, code=code)
        hidden.publisher.publish(HOST, run_id, "", reproduces="a" if run_id == "c" else None)
    first = hidden.splits["guarded"].in_playing_order("en")[0].episode_id
    Corrector(hidden.database, hidden.splits, SigningKey(tmp_path / "key.pem")).void("guarded", [first], "a wall")
    left, step = EPISODES - 1, rounding_step(EPISODES - 1)
    (line,) = (one for one in hidden.board.standings("guarded", "en") if one.seeds == 2)
    assert [entry.counted for entry in line.entries] == [left, left]
    found = line.rows["total"][METRIC]
    assert found == mean_interval(found.mean, left, step / 2.0, step)
    (again,) = hidden.board.reproductions("a")
    assert again.differences[METRIC] == shown_difference(
        total(hidden, "c"), total(hidden, "a"), left, 2.0**0.5 * shown_deviation(left)
    )


def test_run_whose_hidden_split_is_gone_shows_what_it_showed(hidden: LeaderboardBackend) -> None:
    publish(hidden, "a", 0.3456)
    shown = hidden.board.entry("a").rows
    rest = {name: split for name, split in hidden.splits.items() if name != "guarded"}
    entry = Board(Entries(hidden.database), rest, steps_per_phase=STEPS, clocks=CLOCKS).entry("a")
    assert entry.rows == shown
    assert entry.progress.steps == 420


def test_receipts_of_hidden_splits_name_their_version(hidden: LeaderboardBackend) -> None:
    publish(hidden, "a", 0.5)
    with closing(hidden.database):
        (row,) = hidden.database.read(sa.select(tables.receipts.c.payload))
        assert json.loads(row.payload)["version"] == MASKED_VERSION
