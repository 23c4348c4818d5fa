"""Exported CSV and JSON files, read back with the usual parsers."""

import csv
import io
import json
from dataclasses import replace
from typing import Any

import pytest

from arramon_server.board.board import StandingsListing
from arramon_server.board.exports import CSV_COLUMNS, as_csv, as_json
from arramon_server.board.reference import read_references
from arramon_server.board.standings import BOTH
from arramon_server.runs.play.clocks import ClockSettings
from tests.board.leaderboard_backend import LeaderboardBackend


def read(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text, newline="")))


def test_csv_columns_are_stable() -> None:
    assert CSV_COLUMNS[:13] == (
        "kind", "rank", "tied", "participant", "agent", "split", "language", "sensors", "coverage", "marks",
        "nDTW", "nDTW low", "nDTW high",
    )  # fmt: skip
    assert CSV_COLUMNS[31:34] == ("nDTW turn 1", "CTC-0 turn 1", "CTC-3 turn 1")
    assert CSV_COLUMNS[45:49] == ("published_at", "run_id", "signature", "note")
    assert CSV_COLUMNS[49:52] == ("last rank", "runs begun", "runs published")
    assert CSV_COLUMNS[64:] == ("reproduced by", "reproduces", "void episodes")
    assert CSV_COLUMNS[58:64] == (
        "seeds", "seed deviation", "seconds a step", "declared parameters", "declared tokens", "declared price",
    )  # fmt: skip
    assert CSV_COLUMNS[52:58] == ("gap", "gap low", "gap high", "higher language", "lower language", "same outcome")


def test_csv_preserves_scores_and_texts(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("r1", [0.1, 0.2, 0.3, 1 / 3, 0.7, 0.0], agent="walker, mine"), 'says "hello"')
    backend.publish(backend.run("r2", [1.0], sensors=("oracle",)))
    whole, part = read(as_csv(backend.board.listing("tiny", "en")))
    score = backend.board.entry("r1").rows["total"]["PTC@CTC-3"]
    assert (float(whole["PTC@CTC-3"]), float(whole["PTC@CTC-3 low"]), float(whole["PTC@CTC-3 high"])) == (
        score.mean, score.low, score.high,
    )  # fmt: skip
    assert float(whole["PTC@CTC-3 turn 2"]) == score.mean
    assert (whole["kind"], whole["rank"], whole["tied"], whole["agent"]) == ("run", "1", "no", "walker, mine")
    assert (whole["note"], whole["run_id"], whole["coverage"], whole["marks"]) == ('says "hello"', "r1", "1.0", "")
    assert (part["rank"], part["marks"], part["sensors"]) == ("", "partial privileged", "oracle")


def test_other_clocks_are_marked_in_csv_and_json(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("r1", clocks=ClockSettings(30.0, 3600.0)))
    listing = backend.board.listing("tiny", "en")
    (cells,) = read(as_csv(listing))
    (line,) = json.loads(as_json(listing))["standings"]
    assert (cells["rank"], cells["marks"]) == ("", "other-clocks")
    assert (line["rank"], line["marks"], line["entries"][0]["marks"]) == (None, ["other-clocks"], ["other-clocks"])


def test_csv_of_both_languages_names_both_runs(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("e", 0.5))
    backend.publish(backend.run("h", 1.0, language="hi"))
    (line,) = read(as_csv(backend.board.listing("tiny", BOTH)))
    assert (line["language"], line["run_id"], line["nDTW"]) == ("both", "e h", "0.75")


@pytest.mark.parametrize("name", ["=1+1", "+1", "-1", "@SUM(A1)", " =1", "=cmd|' /C calc'!A0"])
def test_csv_escapes_names_that_look_like_formulas(backend: LeaderboardBackend, name: str) -> None:
    backend.publish(backend.run("r1", agent=name, participant=name), name)
    (line,) = read(as_csv(backend.board.listing("tiny", "en")))
    assert (line["agent"], line["participant"]) == (f"'{name}", f"'{name}")
    assert line["note"] == f"'{name.strip()}"


@pytest.mark.parametrize(
    "note",
    [
        "＝1+1", "＋1", "－1", "＠SUM(A1)", "﹦1", "﹢1", "﹣1", "﹫A1", "⁼1", "₊1", "−1",
        "\u3000＝1", "\u200b=1", "\ufeff=1", "\u2060＝1", "\N{NO-BREAK SPACE}=1", "\t1", "\r1", "\n1", "\v=1",
    ],
)  # fmt: skip
def test_csv_escapes_formulas_with_unicode_or_hidden_prefixes(note: str) -> None:
    (reference, *_) = read_references()
    (line,) = read(as_csv(StandingsListing("val_seen", "en", "nDTW", (), (replace(reference, name=note),))))
    assert line["agent"] == f"'{note}"


@pytest.mark.parametrize("note", ["a=1", "1-2", "मेरा = -1", "'=1", "½", "", "…=1"])
def test_csv_leaves_other_texts_unchanged(note: str) -> None:
    (reference, *_) = read_references()
    (line,) = read(as_csv(StandingsListing("val_seen", "en", "nDTW", (), (replace(reference, name=note),))))
    assert line["agent"] == note


def test_csv_lists_the_papers_results() -> None:
    references = tuple(line for line in read_references() if line.split == "val_seen")
    lines = read(as_csv(StandingsListing("val_seen", "en", "nDTW", (), references)))
    assert [(line["kind"], line["agent"]) for line in lines][:2] == [
        ("paper", "Vision-and-Language"), ("paper", "Vision-Only"),
    ]  # fmt: skip
    assert (lines[0]["nDTW"], lines[0]["nDTW low"], lines[0]["nDTW turn 1"]) == ("0.135", "", "0.222")
    assert lines[4]["PTC@CTC-3"] == ""  # the shortest path, which the paper gives no placement for
    assert lines[0]["note"] == "Tables 2 and 5."


def test_json_holds_standings_scores_and_entries(backend: LeaderboardBackend) -> None:
    backend.publish(backend.run("e", [0.1, 0.2, 0.3, 1 / 3, 0.7, 0.0]), "नोट")
    backend.publish(backend.run("h", 1.0, language="hi"))
    text = as_json(backend.board.listing("tiny", BOTH, "nDTW"))
    document: dict[str, Any] = json.loads(text)
    assert (document["format"], document["version"]) == ("arramon-standings", 1)
    assert (document["split"], document["language"], document["sort"]) == ("tiny", "both", "nDTW")
    assert document["references"] == []
    (line,) = document["standings"]
    assert (line["rank"], line["tied"], line["coverage"], line["marks"]) == (1, False, 1.0, [])
    english, hindi = line["entries"]
    score = line["rows"]["turn 2"]["rPOD"]
    assert score["mean"] == pytest.approx((backend.board.entry("e").rows["turn 2"]["rPOD"].mean + 1) / 2)
    assert 0.3 < score["low"] < score["mean"] < score["high"] < 0.9
    assert (english["run_id"], english["note"], hindi["causes"]) == ("e", "नोट", {"AGENT_FINISHED": 4})
    assert "नोट" in text


def test_json_lists_the_papers_results() -> None:
    references = tuple(line for line in read_references() if line.short == "H/E")
    document = json.loads(as_json(StandingsListing("test_unseen", "en", "nDTW", (), references)))
    assert document["references"][0]["rows"]["total"]["nDTW"] == 0.806
    assert document["references"][0]["note"] == "On 50 episodes, drawn at random."
