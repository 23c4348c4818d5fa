"""The page of epochs, what other pages say of them, reproductions, and downloads."""

import gzip
import json
from pathlib import Path

import pytest

from arramon_server.runs.accounts.callers import HOST
from arramon_server.web.page_texts import all_texts
from tests.board.leaderboard_backend import secret_of
from tests.web.leaderboard_site import HIDDEN_RUN, OLDER_RUN, OPEN_RUN, REPRODUCED_RUN, LeaderboardSite
from tests.web.reading import Page

TEXTS = all_texts()["en"]


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("en", ("Epoch 1: revealed", "Epoch 2: open", "not revealed", "Standings of test_unseen_e2")),
        ("hi", ("दौर 1: प्रकट", "दौर 2: खुला", "प्रकट नहीं", "test_unseen_e2 की सूची")),
    ],
)
def test_epochs_are_listed_with_commitments_and_revealed_secrets(
    shown: LeaderboardSite, language: str, words: tuple[str, ...]
) -> None:
    text = shown.site.get(f"/{language}/epochs").text
    assert [word for word in words if word not in text] == []
    for number in (1, 2):
        assert shown.epochs.of(f"test_unseen_e{number}").commitment.hex() in text
    assert f"--scale 0.5 --secret {secret_of(1)}" in text
    assert secret_of(2) not in text


def test_the_page_shows_how_agents_stand_on_two_epochs(shown: LeaderboardSite) -> None:
    text = shown.site.get("/en/epochs").text
    assert "PTC in both turns on test_unseen_e2 against test_unseen_e1" in text
    (pair,) = shown.epoch_board.changes_between_epochs("en")
    assert TEXTS.difference(pair.agents[0].difference.mean) in text
    assert "the same" in text
    assert "nDTW in both turns on" in shown.site.get("/en/epochs?language=en&sort=ndtw").text
    assert "No agent has a ranked run" in shown.site.get("/en/epochs?language=hi").text
    assert len(gzip.compress(text.encode())) < 5_000


@pytest.mark.parametrize("query", ["language=xx", "sort=best", "language=both"])
def test_unknown_choices_have_no_page(shown: LeaderboardSite, query: str) -> None:
    assert shown.site.get(f"/en/epochs?{query}").status == 404


def test_without_epochs_there_is_no_page_but_an_empty_list(web: LeaderboardSite) -> None:
    assert web.site.get("/en/epochs").status == 404
    assert json.loads(web.site.get("/epochs.json").text)["epochs"] == []


def test_the_list_can_be_downloaded_without_secrets_that_are_not_revealed(shown: LeaderboardSite) -> None:
    got = shown.site.get("/epochs.json")
    content = json.loads(got.text)
    assert (content["format"], content["version"]) == ("arramon-epochs", 1)
    assert [(epoch["split"], epoch["state"], epoch["secret"]) for epoch in content["epochs"]] == [
        ("test_unseen_e2", "open", None),
        ("test_unseen_e1", "revealed", secret_of(1)),
    ]


def test_standings_of_an_epoch_say_so(shown: LeaderboardSite) -> None:
    text = shown.site.get("/en/?split=test_unseen_e1&language=en").text
    assert "Epoch 1 of test_unseen: revealed." in text
    assert '<a href="/en/epochs">' in text
    assert "Epoch" not in shown.site.get("/en/?split=hidden&language=en").text


def test_actions_are_downloaded_where_no_split_is_hidden(shown: LeaderboardSite) -> None:
    for run_id in (OPEN_RUN, OLDER_RUN):
        content = json.loads(shown.site.get(f"/runs/{run_id}/actions.json").text)
        assert (content["format"], content["run"]) == ("arramon-actions", {"run_id": run_id})
        assert f"/runs/{run_id}/actions.json" in shown.site.get(f"/en/runs/{run_id}").text
    (actions,) = set(json.loads(shown.site.get(f"/runs/{OPEN_RUN}/actions.json").text)["actions"].values())
    assert actions == "0030322200303"
    for run_id in (HIDDEN_RUN, REPRODUCED_RUN, "9" * 32):
        assert shown.site.get(f"/runs/{run_id}/actions.json").status == 404
    assert "actions.json" not in shown.site.get(f"/en/runs/{HIDDEN_RUN}").text


def test_a_downloaded_receipt_is_rescored_with_downloaded_actions(shown: LeaderboardSite, tmp_path: Path) -> None:
    from arramon_server.runs.results.receipt_file import rescore_file

    paths = []
    for name in ("receipt", "actions"):
        paths.append(tmp_path / f"{name}.json")
        paths[-1].write_bytes(shown.site.get(f"/runs/{OPEN_RUN}/{name}.json").body)
    assert rescore_file(paths[0], paths[1], shown.splits).differences == ()


def test_reproductions_are_shown_with_their_differences(shown: LeaderboardSite) -> None:
    assert "reproduced by 2" in shown.site.get("/en/?split=test_unseen_e2&language=en").text
    text = shown.site.get(f"/en/runs/{REPRODUCED_RUN}").text
    page = Page(text)
    assert (2, "Reproduced by 2") in page.headings
    for one in shown.board.reproductions(REPRODUCED_RUN):
        assert TEXTS.difference(one.differences["PTC@CTC-3"].mean) in text
    assert "https://example.org/walker; commit cccc" in text
    assert 'href="https://example.org' not in text
    of_bob = shown.site.get(f"/en/runs/{'2' * 32}").text
    assert f"/en/runs/{REPRODUCED_RUN}#reproduced" in of_bob
    assert "reproduction" in of_bob


def test_withdrawn_reproductions_and_originals_are_not_linked(web: LeaderboardSite) -> None:
    web.season()
    web.publisher.withdraw(HOST, "2" * 32)
    assert "Reproduced by 1" in web.site.get(f"/en/runs/{REPRODUCED_RUN}").text
    web.publisher.withdraw(HOST, REPRODUCED_RUN)
    text = web.site.get(f"/en/runs/{'3' * 32}").text
    assert "repeats a run that is no longer published" in text
    assert REPRODUCED_RUN not in text


def test_the_first_page_shows_the_latest_open_epoch_with_runs(web: LeaderboardSite) -> None:
    web.season()
    assert "test_unseen_e2" in Page(web.site.get("/en/").text).headings[0][1]
    web.epochs.close("test_unseen_e2")
    assert "test_unseen_e2" in Page(web.site.get("/en/").text).headings[0][1]
    web.published(7, 0.5, "walker", split="hidden")
    assert "hidden" in Page(web.site.get("/en/").text).headings[0][1]
