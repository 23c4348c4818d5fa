"""Reproductions of runs by other participants: conditions, counts, differences, exports and receipts."""

import json
from typing import Any

import numpy as np
import pytest
import scipy  # which loads scipy.stats when a test asks for it

from arramon_server.board.exports import as_csv, as_json
from arramon_server.board.standings import BOTH, Mark
from arramon_server.errors import BadInput, Conflict, NotFound
from arramon_server.runs.accounts.callers import HOST, Caller, Role
from arramon_server.runs.code_reference import normalize_code
from arramon_server.runs.results.receipts import stored_receipt
from arramon_server.runs.storage.records import CANCELLED, CodeReference
from tests.board.leaderboard_backend import LeaderboardBackend
from tests.board.test_exports import read

URL, COMMIT, IMAGE = "https://example.org/walker", "c" * 40, "sha256:" + "d" * 64
CODE = CodeReference(URL, COMMIT, IMAGE)
SCORES = (1.0, 0.0, 1.0, 0.5, 1.0, 0.0)


@pytest.fixture
def backend(backend: LeaderboardBackend) -> LeaderboardBackend:
    """A backend with a published run of ann."""
    backend.participant("ann", "bob", "cid")
    backend.publish(run(backend, "anns", "ann", SCORES))
    return backend


def run(backend: LeaderboardBackend, run_id: str, account: str | None, scores: Any = 1.0, **more: Any) -> str:
    return backend.run(run_id, scores, participant=account or "lab", account=account, **{"code": CODE, **more})


def reproduce(backend: LeaderboardBackend, run_id: str, of: str = "anns", caller: Caller = HOST) -> str:
    backend.publisher.publish(caller, run_id, "", reproduces=of)
    return run_id


def test_others_reproduce_a_run_and_are_counted_by_account(backend: LeaderboardBackend) -> None:
    reproduce(backend, run(backend, "bobs", "bob"), caller=Caller(Role.PARTICIPANT, "bob"))
    reproduce(backend, run(backend, "bobs2", "bob"))
    assert len(backend.board.entry("anns").reproducers) == 1
    reproduce(backend, run(backend, "cids", "cid", code=CodeReference(URL + "-mirror", COMMIT)))
    assert [line.reproduced_by for line in backend.board.standings("tiny", "en")] == [2, 0, 0, 0]
    assert [one.entry.run.run_id for one in backend.board.reproductions("anns")] == ["bobs", "bobs2", "cids"]
    backend.publisher.withdraw(HOST, "cids")
    assert backend.board.standings("tiny", "en")[0].reproduced_by == 1
    assert [one.entry.run.run_id for one in backend.board.reproductions("anns")] == ["bobs", "bobs2"]


def test_a_reproduction_is_listed_without_a_rank(backend: LeaderboardBackend) -> None:
    reproduce(backend, run(backend, "bobs", "bob"))
    lines = [(line.participant, line.rank, line.marks) for line in backend.board.standings("tiny", "en")]
    assert lines == [("ann", 1, ()), ("bob", 0, (Mark.REPRODUCTION,))]
    assert backend.board.entry("bobs").reproduces == "anns"


def test_republishing_keeps_or_changes_what_is_reproduced(backend: LeaderboardBackend) -> None:
    reproduce(backend, run(backend, "bobs", "bob"))
    backend.publish("bobs", "a note")
    assert (backend.board.entry("bobs").reproduces, backend.board.entry("bobs").note) == ("anns", "a note")
    backend.publisher.publish(HOST, "bobs", "", reproduces="")
    assert backend.board.entry("bobs").reproduces is None
    assert len(backend.board.entry("anns").reproducers) == 0


def test_differences_are_paired_by_episode(backend: LeaderboardBackend) -> None:
    theirs = (1.0, 0.5, 0.5, 0.5, 1.0, 1.0)
    reproduce(backend, run(backend, "bobs", "bob", theirs))
    (one,) = backend.board.reproductions("anns")
    change = np.array(theirs) - np.array(SCORES)
    found = one.differences["PTC@CTC-3"]
    assert found.mean == pytest.approx(change.mean())
    plain = scipy.stats.ttest_rel(theirs, SCORES).confidence_interval()
    # Wider than Student's interval by the one further episode that shows the largest variance.
    assert found.low <= plain.low
    assert found.high >= plain.high
    share = (change.var(ddof=1) * 5 + 1) / 6
    half = scipy.stats.t.ppf(0.975, 5) * (share / 6) ** 0.5
    assert (found.low, found.high) == pytest.approx((max(change.mean() - half, -1), min(change.mean() + half, 1)))


@pytest.mark.parametrize(
    ("account", "changed", "problem"),
    [
        ("ann", {}, "of the same account: a reproduction is published by another participant"),
        (None, {}, "run 'mine' was played without an account"),
        ("bob", {"agent": "runner"}, "of the agent 'runner', but run 'anns' of 'walker'"),
        ("bob", {"code": CodeReference()}, "names no code, but run 'anns' url https://example.org/walker, commit ccc"),
        ("bob", {"code": CodeReference(URL, "e" * 40)}, "expected the same commit or image"),
        ("bob", {"code": CodeReference(URL)}, "expected the same commit or image"),
        ("bob", {"scores": [1.0] * 5}, "episodes is 5, expected 6"),
        ("bob", {"language": "hi"}, "lang is hi, expected en; episodes is 4, expected 6"),
        ("bob", {"split": "secret"}, "split is secret, expected tiny"),
        ("bob", {"sensors": ("rgb",)}, r"sensors is rgb, expected depth\+rgb"),
        ("bob", {"steps": 99}, "steps is 99, expected 150"),
        ("bob", {"state": CANCELLED}, "was cancelled; a reproduction is played to its end"),
    ],
)
def test_what_is_no_reproduction_is_refused(
    backend: LeaderboardBackend, account: str | None, changed: dict[str, Any], problem: str
) -> None:
    run(backend, "mine", account, **changed)
    with pytest.raises(Conflict, match=problem):
        reproduce(backend, "mine")
    assert backend.entries.find("mine") is None


def test_the_original_must_be_listed_named_and_no_reproduction(backend: LeaderboardBackend) -> None:
    for run_id in ("missing", "a\0b", "unpublished"):
        if run_id == "unpublished":
            run(backend, run_id, "cid")
        run(backend, f"for {run_id[:7]}".replace("\0", ""), "bob")
        with pytest.raises(NotFound, match="on the leaderboard that could be reproduced"):
            reproduce(backend, f"for {run_id[:7]}".replace("\0", ""), run_id)
    backend.publish(run(backend, "plain", "ann", code=CodeReference()))
    with pytest.raises(Conflict, match="names no code"):
        reproduce(backend, run(backend, "1", "bob"), "plain")
    backend.publish(run(backend, "nobodys", None))
    with pytest.raises(Conflict, match="run 'nobodys' was played without an account"):
        reproduce(backend, run(backend, "2", "bob"), "nobodys")
    reproduce(backend, "2")
    with pytest.raises(Conflict, match="run '2' reproduces run 'anns'; name that one instead"):
        reproduce(backend, run(backend, "3", "cid"), "2")
    backend.publish(run(backend, "cids", "cid"))
    with pytest.raises(Conflict, match="is itself reproduced by others"):
        reproduce(backend, "anns", "cids")


def test_a_withdrawn_original_leaves_its_reproductions_unranked(backend: LeaderboardBackend) -> None:
    reproduce(backend, run(backend, "bobs", "bob"))
    backend.publisher.withdraw(HOST, "anns")
    (line,) = backend.board.standings("tiny", "en")
    assert (line.participant, line.rank) == ("bob", 0)


def test_a_system_is_reproduced_by_those_who_did_so_in_every_language(backend: LeaderboardBackend) -> None:
    backend.publish(run(backend, "annhi", "ann", language="hi"))
    reproduce(backend, run(backend, "bobs", "bob"))
    reproduce(backend, run(backend, "cids", "cid"))
    reproduce(backend, run(backend, "bobhi", "bob", language="hi"), "annhi")
    both = {line.participant: line.reproduced_by for line in backend.board.standings("tiny", BOTH)}
    assert both == {"ann": 1, "bob": 0}


def test_exports_have_count_original_and_code(backend: LeaderboardBackend) -> None:
    reproduce(backend, run(backend, "bobs", "bob"))
    listing = backend.board.listing("tiny", "en")
    cells = [(line["reproduced by"], line["reproduces"], line["marks"]) for line in read(as_csv(listing))]
    assert cells == [("1", "", ""), ("0", "anns", "reproduction")]
    first, second = json.loads(as_json(listing))["standings"]
    assert (first["reproduced_by"], second["entries"][0]["reproduces"]) == (1, "anns")
    assert first["entries"][0]["code"] == {"url": URL, "commit": COMMIT, "image": IMAGE}


def test_the_receipt_signs_the_code(backend: LeaderboardBackend) -> None:
    backend.publish(run(backend, "plain", "bob", code=CodeReference()))
    found = {}
    for run_id in ("anns", "plain"):
        receipt = stored_receipt(backend.database, run_id)
        assert receipt is not None
        found[run_id] = json.loads(receipt.payload)["run"].get("code")
    assert found == {"anns": {"url": URL, "commit": COMMIT, "image": IMAGE}, "plain": None}


GOOD = [
    (URL, "", ""),
    (URL, "A" * 40, ""),
    (URL, "0" * 64, ""),
    ("", "", IMAGE),
    ("http://127.0.0.1:8080/x?y=1#z", "", f"ghcr.io:443/lab/walker@{IMAGE}"),
]


@pytest.mark.parametrize(("url", "commit", "image"), GOOD)
def test_code_is_named_by_address_commit_and_image(url: str, commit: str, image: str) -> None:
    assert normalize_code(url, commit, image) == CodeReference(url, commit.lower(), image)


@pytest.mark.parametrize(
    ("url", "commit", "image", "problem"),
    [
        ("example.org/walker", "", "", "expected an address such as"),
        ("ftp://example.org/walker", "", "", "expected an address such as"),
        ("javascript:alert(1)", "", "", "expected an address such as"),
        ("https://ann:pass@example.org/", "", "", "without a user's name or password"),
        ("https://ann@example.org/", "", "", "without a user's name or password"),
        ("https://example.org/a b", "", "", "expected an address such as"),
        ("https://example.org/\n", "", "", "expected an address such as"),
        ("https://exämple.org/", "", "", "expected an address such as"),
        ("https://example.org/" + "x" * 300, "", "", "has 320 characters; at most 300"),
        (URL, "c" * 39, "", "expected its full id of 40 or 64 hexadecimal digits"),
        (URL, "main", "", "'main', expected its full id"),
        ("", COMMIT, "", "has a commit but no address"),
        ("", "", "walker:latest", "expected a digest such as"),
        ("", "", "sha256:" + "d" * 63, "expected a digest such as"),
        ("", "", "a b@" + IMAGE, "expected a digest such as"),
        ("", "", "x" * 300 + "@" + IMAGE, "at most 300 characters"),
    ],
)
def test_malformed_code_is_refused(url: str, commit: str, image: str, problem: str) -> None:
    with pytest.raises(BadInput, match=problem):
        normalize_code(url, commit, image)
