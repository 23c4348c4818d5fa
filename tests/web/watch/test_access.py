"""Who may watch which runs, and how much of the ground truth a page shows."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from arramon_server.runs.run_service import HUMAN
from arramon_server.runs.storage.causes import AGENT_FINISHED
from arramon_server.runs.storage.records import CommitBatch, EpisodeEnding
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.web.pages import Pages
from arramon_server.web.watch.viewers import NOBODY, Viewers
from tests import tiny
from tests.web.leaderboard_site import HIDDEN_RUN, OPEN_RUN, UNPUBLISHED_RUN, WITHDRAWN_RUN, LeaderboardSite
from tests.web.serving import Got, Site

OWN = Viewers(None, own_machine=True)
"""The default of a server that only its own machine can reach."""

PUBLIC = Viewers(True)
"""A server on which anybody may play without a token."""

LIVE_RUN = "7" * 32

EPISODE = "quokka-1"

SCORES = [dict.fromkeys(METRICS, 1.0)] * 2


def addresses(run_id: str, episode: str = EPISODE) -> list[str]:
    """Everything of an episode that is watched."""
    here = f"runs/{run_id}/episodes/{episode}"
    return [
        f"/en/{here}",
        f"/hi/{here}?step=0",
        f"/en/{here}/moments.json",
        f"/{here}/frames/0.jpg",
        f"/{here}/frames/0.jpg?kind=depth&size=112",
        f"/{here}/frames/0.jpg?kind=segmentation&size=224",
    ]


@contextmanager
def served(backend: LeaderboardSite, viewers: Viewers) -> Iterator[Site]:
    """The backend's pages for other viewers."""
    site = Site(
        Pages(backend.board, backend.journal, backend.receipts, backend.splits, backend.epoch_board, viewers=viewers)
    )
    try:
        yield site
    finally:
        site.close()


def begin(
    backend: LeaderboardSite, run_id: str = LIVE_RUN, *, split: str = "open", steps: int = 3, agent: str = "walker"
) -> None:
    """Begin a run, of which one episode has some steps."""
    backend.run(run_id, split=split, over=False, agent=agent)
    pending = [claim for claim in backend.journal.pending(run_id) if claim.episode_id == EPISODE]
    backend.journal.claim(run_id, pending, "player", "worker")
    advance(backend, run_id, 0, steps)


def advance(backend: LeaderboardSite, run_id: str, first: int, last: int, note: str = "") -> None:
    """Play steps of the ground truth."""
    batch = CommitBatch()
    (claim,) = backend.journal.open_claims(run_id)
    for step in range(first, last):
        batch.add_step(run_id, EPISODE, claim.fence, step, tiny.ACTIONS[step])
    if note:
        batch.add_note(run_id, EPISODE, first, note)
    if last == len(tiny.ACTIONS):
        batch.endings.append(EpisodeEnding(run_id, EPISODE, AGENT_FINISHED, last, SCORES, "", claim.fence))
    backend.journal.commit(batch)


def statuses(site: Site, run_id: str, headers: dict[str, str] | None = None) -> set[int]:
    return {site.get(address, headers).status for address in addresses(run_id)}


@pytest.mark.parametrize("viewers", [NOBODY, OWN, PUBLIC])
def test_published_runs_of_open_splits_are_for_everybody(shown: LeaderboardSite, viewers: Viewers) -> None:
    with served(shown, viewers) as site:
        assert statuses(site, OPEN_RUN) == {200}


@pytest.mark.parametrize("viewers", [NOBODY, OWN, PUBLIC])
def test_hidden_splits_are_for_nobody(web: LeaderboardSite, viewers: Viewers) -> None:
    web.play(HIDDEN_RUN, "hidden")
    begin(web, split="hidden")
    with served(web, viewers) as site:
        for run_id in (HIDDEN_RUN, LIVE_RUN):
            assert statuses(site, run_id) == {404}
            assert site.get(f"/en/runs/{run_id}/failures").status == 404
        assert LIVE_RUN not in site.get("/en/watch").text


def test_unpublished_runs_are_for_those_who_see_them(web: LeaderboardSite) -> None:
    begin(web)
    for viewers, status in ((NOBODY, 404), (OWN, 200), (PUBLIC, 200)):
        with served(web, viewers) as site:
            assert statuses(site, LIVE_RUN) == {status}
            assert site.get(f"/en/runs/{LIVE_RUN}/failures").status == 404
            assert (LIVE_RUN in site.get("/en/watch").text) is (viewers is OWN)


def test_runs_of_accounts_are_for_nobody_before_they_are_published(web: LeaderboardSite) -> None:
    web.participant("ann")
    web.run(LIVE_RUN, split="open", participant="ann", account="ann")
    for viewers in (NOBODY, OWN, PUBLIC):
        with served(web, viewers) as site:
            assert statuses(site, LIVE_RUN) == {404}


@pytest.mark.parametrize(
    "headers",
    [{"X-Forwarded-For": "192.0.2.1"}, {"Via": "1.1 proxy"}, {"Forwarded": "for=x"}, {"Host": "evil.example"}],
)
def test_only_the_machine_itself_sees_its_unpublished_runs(web: LeaderboardSite, headers: dict[str, str]) -> None:
    begin(web)
    with served(web, OWN) as site:
        assert statuses(site, LIVE_RUN) == {200}
        assert statuses(site, LIVE_RUN, headers) == {404}
        assert "only on the machine of the server" in site.get("/en/watch", headers).text


def truth_of(got: Got) -> bool:
    """Whether a page shows the reference path, or a file the distance to the target."""
    if got.headers["content-type"].startswith("application/json"):
        return any(one["distance"] or one["ndtw"] for one in json.loads(got.text)["moments"])
    return 'class="truth"' in got.text or 'class="wanted"' in got.text or "Distance to the target" in got.text


def test_ground_truth_is_not_shown_to_those_who_may_still_play(web: LeaderboardSite) -> None:
    begin(web, steps=2)
    with served(web, PUBLIC) as site:
        pages = [address for address in addresses(LIVE_RUN) if "/frames/" not in address]
        assert [truth_of(site.get(page)) for page in pages] == [False] * 3
        assert "purple" not in site.get(pages[2]).text  # the object to take
        advance(web, LIVE_RUN, 2, len(tiny.ACTIONS))
        assert [truth_of(site.get(page)) for page in pages] == [True] * 3
    begin(web, "8" * 32)
    with served(web, OWN) as site:
        assert truth_of(site.get(f"/en/runs/{'8' * 32}/episodes/{EPISODE}"))


WITHHELD = {"en": "The reference is shown when the episode is over", "hi": "सही रास्ता एपिसोड ख़त्म होने पर"}


def places_of(got: Got) -> set[tuple[object, object]]:
    """Place and heading of all moments in a file."""
    return {(str(one["place"]), one["heading"]) for one in json.loads(got.text)["moments"]}


@pytest.mark.parametrize("viewers", [OWN, PUBLIC])
@pytest.mark.parametrize("steps", [2, 6], ids=["street", "room"])
def test_what_a_person_plays_is_withheld_from_everybody_until_it_ends(
    web: LeaderboardSite, viewers: Viewers, steps: int
) -> None:
    begin(web, steps=steps, agent=HUMAN)
    pages = {language: f"/{language}/runs/{LIVE_RUN}/episodes/{EPISODE}" for language in WITHHELD}
    with served(web, viewers) as site:
        for language, sentence in WITHHELD.items():
            page, data = site.get(pages[language]), site.get(f"{pages[language]}/moments.json")
            assert sentence in page.text
            for hidden in (
                "data-map=",
                'class="truth"',
                'class="wanted"',
                'class="distracter"',
                'class="thing',
                "trail",
            ):
                assert hidden not in page.text
            assert not truth_of(page)
            assert not truth_of(data)
            assert places_of(data) == {("None", None)}
        advance(web, LIVE_RUN, steps, len(tiny.ACTIONS))
        for language, sentence in WITHHELD.items():
            page, data = site.get(pages[language]), site.get(f"{pages[language]}/moments.json")
            assert sentence not in page.text
            assert truth_of(page)
            assert truth_of(data)
            assert ("None", None) not in places_of(data)


@pytest.mark.parametrize(
    ("before", "shown"), [(0, "placed exactly"), (1, "placed elsewhere, tiles and levels off: 1")], ids=["right", "off"]
)
def test_placements_say_how_far_they_are_off(web: LeaderboardSite, before: int, shown: str) -> None:
    begin(web, steps=0)
    (claim,) = web.journal.open_claims(LIVE_RUN)
    actions = (*tiny.ACTIONS[:3], *tiny.ACTIONS[3 + before :])
    batch = CommitBatch()
    for step, action in enumerate(actions):
        batch.add_step(LIVE_RUN, EPISODE, claim.fence, step, action)
    batch.endings.append(EpisodeEnding(LIVE_RUN, EPISODE, AGENT_FINISHED, len(actions), SCORES, "", claim.fence))
    web.journal.commit(batch)
    with served(web, OWN) as site:
        found = json.loads(site.get(f"/en/runs/{LIVE_RUN}/episodes/{EPISODE}/moments.json").text)["moments"]
    distances = [one["distance"] for one in found if one["distance"].startswith("placed")]
    assert distances == [shown] * 3  # turn 1, turn 2, which places on top of it, and the end


def test_agents_at_play_are_shown_on_ones_own_machine(web: LeaderboardSite) -> None:
    begin(web)
    with served(web, OWN) as site:
        page = site.get(f"/en/runs/{LIVE_RUN}/episodes/{EPISODE}")
        assert "anyone who may play here without one can open this page" in page.text
        assert WITHHELD["en"] not in page.text
        assert "data-map=" in page.text
        assert truth_of(page)
        assert truth_of(site.get(f"/en/runs/{LIVE_RUN}/episodes/{EPISODE}/moments.json"))


def test_other_episodes_and_unplayed_steps_are_not_found(shown: LeaderboardSite) -> None:
    for wrong in (
        f"/en/runs/{OPEN_RUN}/episodes/none",
        f"/en/runs/{OPEN_RUN}/episodes/{EPISODE}?step=14",
        f"/en/runs/{OPEN_RUN}/episodes/{EPISODE}?step=-1",
        f"/en/runs/{OPEN_RUN}/episodes/{EPISODE}?step=%00",
        f"/en/runs/{OPEN_RUN}/episodes/{EPISODE}/moments.json?from=15",
        f"/en/runs/{OPEN_RUN}/episodes/{EPISODE}/moments.json?from=x",
        f"/runs/{OPEN_RUN}/episodes/{EPISODE}/frames/14.jpg",
        f"/runs/{OPEN_RUN}/episodes/{EPISODE}/frames/99999999.jpg",
        f"/runs/{OPEN_RUN}/episodes/{EPISODE}/frames/0.png",
        f"/runs/{OPEN_RUN}/episodes/{EPISODE}/frames/0.jpg?size=4096",
        f"/runs/{OPEN_RUN}/episodes/{EPISODE}/frames/0.jpg?kind=pose",
        *addresses(WITHDRAWN_RUN),
        *addresses(UNPUBLISHED_RUN),
        *addresses("0" * 32),
    ):
        assert shown.site.get(wrong).status == 404, wrong
