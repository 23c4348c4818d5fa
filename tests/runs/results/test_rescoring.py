"""Rescoring of runs finds all changes to the journal and to receipts."""

import json
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
import rfc8785
import sqlalchemy as sa

from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict, NotFound
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.rescoring import Rescorer, RescoringResult
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from tests import tiny
from tests.played import STEPS, play

ALL = (0, 0, 3, 0)
FORCED = (0,) * (4 * STEPS)


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    with closing(Database(database_url)) as database:
        yield database


@pytest.fixture
def split(tmp_path: Path) -> Split:
    return tiny.write(tmp_path, count=6)


@pytest.fixture
def key(tmp_path: Path) -> SigningKey:
    return SigningKey(tmp_path / "key.pem")


@pytest.fixture
def played(database: Database, split: Split, key: SigningKey) -> None:
    """Create a run with every cause, and its receipt."""
    actions = {"0": tiny.ACTIONS, "1": FORCED, "2": (0, 0, 3), "3": (), "4": (0, 0), "5": ()}
    cut = {"2": "TIME_LIMIT", "3": "TIME_LIMIT", "4": "FORFEITED", "5": "SERVER_FAULT"}
    play(database, split, actions=actions, ended=cut)
    Receipts(database, {"tiny": split}, key).of(HOST, "r")


def rescore(database: Database, split: Split) -> RescoringResult:
    with closing(Rescorer(database, {"tiny": split})) as rescorer:
        return rescorer.rescore("r")


def change(database: Database, statement: sa.Update | sa.Delete) -> None:
    with database.write() as connection:
        assert connection.execute(statement).rowcount == 1


@pytest.mark.usefixtures("played")
def test_unchanged_run_is_rescored_identically(database: Database, split: Split) -> None:
    causes = database.read(sa.select(tables.episodes.c.cause).order_by(tables.episodes.c.ordinal))
    assert [row.cause for row in causes] == [
        "AGENT_FINISHED", "STEP_LIMIT", "TIME_LIMIT", "TIME_LIMIT", "FORFEITED", "SERVER_FAULT",
    ]  # fmt: skip
    assert rescore(database, split) == RescoringResult("r", 6, 13 + 4 * STEPS + 3 + 2, True, ())


def test_run_without_a_receipt_is_rescored(database: Database, split: Split) -> None:
    play(database, split)
    assert rescore(database, split) == RescoringResult("r", 6, 6 * 13, False, ())


@pytest.mark.usefixtures("played")
def test_rescoring_works_on_a_read_only_database(database: Database, split: Split, database_url: str) -> None:
    with closing(Database(database_url, read_only=True)) as reading:
        assert rescore(reading, split) == rescore(database, split)


def of(table: sa.Table, episode_id: str) -> sa.ColumnElement[bool]:
    return sa.and_(table.c.run_id == "r", table.c.episode_id == episode_id)


@pytest.mark.usefixtures("played")
def test_changed_action_is_found_in_scores_and_hash_chain(database: Database, split: Split) -> None:
    change(database, tables.steps.update().where(of(tables.steps, "0"), tables.steps.c.step == 1).values(action=1))
    found = rescore(database, split).differences
    assert any(each.startswith("episode 0: turn 1: nDTW was 1.0, and is 0.") for each in found)
    assert found[10] == "... and more"
    assert found[11].startswith("receipt: digest was ")


@pytest.mark.usefixtures("played")
def test_changed_action_without_effect_is_found_in_the_hash_chain(database: Database, split: Split) -> None:
    change(database, tables.steps.update().where(of(tables.steps, "4"), tables.steps.c.step == 1).values(action=1))
    found = rescore(database, split).differences
    assert [each.split(" was ")[0] for each in found] == ["receipt: digest", "receipt: episodes 5: head"]


@pytest.mark.usefixtures("played")
def test_missing_step_is_found(database: Database, split: Split) -> None:
    change(database, tables.steps.delete().where(of(tables.steps, "0"), tables.steps.c.step == 12))
    found = rescore(database, split).differences
    assert found[:2] == (
        "episode 0: cause was AGENT_FINISHED, and is NOT_FINISHED",
        "episode 0: steps was 13, and is 12",
    )


@pytest.mark.usefixtures("played")
def test_additional_step_is_found(database: Database, split: Split) -> None:
    with database.write() as connection:
        row = {"run_id": "r", "episode_id": "0", "step": 13, "action": 0}
        connection.execute(tables.steps.insert(), [row])
    (found,) = rescore(database, split).differences
    assert found.startswith("episode 0: cannot be replayed: ")


@pytest.mark.usefixtures("played")
def test_raised_score_is_found(database: Database, split: Split) -> None:
    table = tables.episodes
    (row,) = database.read(sa.select(table.c.scores).where(of(table, "4")))
    raised = [{**row.scores[0], "PTC": 1.0}, row.scores[1]]
    change(database, table.update().where(of(table, "4")).values(scores=raised))
    assert rescore(database, split).differences == ("episode 4: turn 1: PTC was 1.0, and is 0.0",)


@pytest.mark.usefixtures("played")
@pytest.mark.parametrize(("episode", "values", "found"), [
    ("0", {"cause": "STEP_LIMIT"}, "episode 0: cause was STEP_LIMIT, and is AGENT_FINISHED"),
    ("4", {"cause": "AGENT_FINISHED"}, "episode 4: cause was AGENT_FINISHED, and is NOT_FINISHED"),
    ("1", {"steps": 7}, "episode 1: steps was 7, and is 32"),
    ("5", {"state": "OPEN"}, "1 of 6 episodes have not ended"),
])  # fmt: skip
def test_changed_ending_is_found(
    database: Database, split: Split, episode: str, values: dict[str, object], found: str
) -> None:
    change(database, tables.episodes.update().where(of(tables.episodes, episode)).values(values))
    assert rescore(database, split).differences[0] == found


@pytest.mark.usefixtures("played")
def test_forged_receipt_is_found(database: Database, split: Split) -> None:
    (row,) = database.read(sa.select(tables.receipts.c.payload))
    content = json.loads(row.payload)
    content["scores"]["total"]["PTC"]["mean"] = 1
    change(database, tables.receipts.update().values(payload=rfc8785.dumps(content)))
    signature, score = rescore(database, split).differences
    assert signature == "receipt: its signature is wrong"
    assert score.startswith("receipt: scores: total: PTC: mean was 1, and is 0.1")


@pytest.mark.usefixtures("played")
@pytest.mark.parametrize("method", [None, "an-older-one"])
def test_intervals_by_another_method_are_not_compared(database: Database, split: Split, method: str | None) -> None:
    (row,) = database.read(sa.select(tables.receipts.c.payload))
    content = json.loads(row.payload)
    content.pop("intervals")
    if method is not None:
        content["intervals"] = method
    content["scores"]["total"]["PTC"]["low"] = 0.123
    change(database, tables.receipts.update().values(payload=rfc8785.dumps(content)))
    assert rescore(database, split).differences == ("receipt: its signature is wrong",)


@pytest.mark.usefixtures("played")
def test_changed_data_is_an_error(database: Database, split: Split) -> None:
    with pytest.raises(Conflict, match=r"run 'r' began on split 'tiny' with the data .*, which now has the data ffff"):
        rescore(database, replace(split, data_hash="f" * 64))


def test_unfinished_and_unknown_runs_are_refused(database: Database, split: Split) -> None:
    with closing(Rescorer(database, {"tiny": split})) as rescorer:
        with pytest.raises(NotFound, match="there is no run 'r'"):
            rescorer.rescore("r")
        play(database, split, actions={"0": ALL}, over=False)
        with pytest.raises(Conflict, match="run 'r' is still being played"):
            rescorer.rescore("r")
