"""Two runs of one episode side by side, and the episodes in which two runs differ most."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, expect

from arramon_client.world import Action
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.storage.causes import AGENT_FINISHED
from arramon_server.runs.storage.records import COMPLETE, CommitBatch, EpisodeEnding
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.web.watch.differences_page import EpisodeDifference, episode_differences
from arramon_server.web.watch.viewers import NOBODY
from tests import tiny
from tests.web.leaderboard_site import HIDDEN_RUN, OPEN_RUN, UNPUBLISHED_RUN, WITHDRAWN_RUN, LeaderboardSite
from tests.web.test_browser import CONTRASTS
from tests.web.watch.test_access import EPISODE, LIVE_RUN, OWN, PUBLIC, advance, begin, served
from tests.web.watch.test_player import opened

F, L, R, P = Action.FORWARD, Action.LEFT, Action.RIGHT, Action.INTERACT

OTHER_RUN = "9" * 32
OTHER_ACTIONS = (L, R, F, F, P, F, P, R)
"""Looks around first, and has then the same way as the ground truth up to turn 2."""

HERE = f"/en/runs/{OPEN_RUN}/episodes/{EPISODE}"
PAIR = f"{HERE}?with={OTHER_RUN}"


def frame(run_id: str, step: int) -> str:
    return f"/runs/{run_id}/episodes/{EPISODE}/frames/{step}.jpg"


def ending(episode_id: str, *scores: float) -> EpisodeEnding:
    return EpisodeEnding("r", episode_id, AGENT_FINISHED, 1, [dict.fromkeys(METRICS, score) for score in scores])


def play(backend: LeaderboardSite, run_id: str = OTHER_RUN, actions: Sequence[Action] = OTHER_ACTIONS) -> None:
    """A published run with other actions in one episode, and scores of 0.25."""
    begin(backend, run_id, steps=0)
    batch, (claim,) = CommitBatch(), backend.journal.open_claims(run_id)
    for step, action in enumerate(actions):
        batch.add_step(run_id, EPISODE, claim.fence, step, action)
    scores = [dict.fromkeys(METRICS, 0.25)] * 2
    batch.endings.append(EpisodeEnding(run_id, EPISODE, AGENT_FINISHED, len(actions), scores, "", claim.fence))
    backend.journal.commit(batch)


@pytest.fixture
def paired(web: LeaderboardSite) -> LeaderboardSite:
    """With two published runs that played EPISODE differently."""
    web.play(OPEN_RUN, "open")
    play(web)
    web.journal.set_state(OTHER_RUN, COMPLETE)
    web.publish(OTHER_RUN)
    return web


def test_both_are_in_step_and_keys_lead_both(paired: LeaderboardSite, browser: Browser) -> None:
    with served(paired, NOBODY) as site, opened(browser, f"{site.address}{PAIR}&step=2") as page:
        first, second = (page.locator(f"[data-side='{n}']") for n in range(2))
        step = "[data-field=step]"
        expect(first.locator(step)).to_have_text("0")  # waits
        expect(second.locator(step)).to_have_text("2")
        expect(second.locator("[data-field=action]")).to_have_text("forward")
        page.keyboard.press("ArrowRight")
        expect(first.locator(step)).to_have_text("1")
        expect(second.locator(step)).to_have_text("3")
        page.wait_for_url("**&step=3")
        page.keyboard.press("n")
        for side, at in ((first, "2"), (second, "4")):
            expect(side.locator(step)).to_have_text(at)
            expect(side.locator("[data-field=answer]")).to_have_text("Picked up: dotted purple hourglass.")
        assert (
            first.locator("[data-field=frame]").get_attribute("src")
            == f"/runs/{OPEN_RUN}/episodes/{EPISODE}/frames/2.jpg"
        )
        assert page.locator("[data-map='1-navigation'] [data-trail]").evaluate_all(
            "ways => ways.map((way) => way.points.numberOfItems)"
        ) == [3, 5]
        page.keyboard.press("End")
        expect(page.locator("[data-field=phase]")).to_have_text("Turn 2, Assembly")
        expect(first.locator(step)).to_have_text(str(len(tiny.ACTIONS)))
        expect(second.locator(step)).to_have_text(str(len(OTHER_ACTIONS)))
        room = page.locator("[data-map='2-assembly']")
        expect(room.locator("[data-agent='0']")).to_be_visible()
        expect(room.locator("[data-agent='1']")).to_be_hidden()  # never came so far
        page.keyboard.press("Home")
        page.wait_for_url("**&step=0")
        assert page.locator("[data-field=link]").get_attribute("href") == f"{PAIR}&step=0"


def test_slider_events_pictures_and_playing(paired: LeaderboardSite, browser: Browser) -> None:
    with served(paired, NOBODY) as site, opened(browser, site.address + PAIR) as page:
        page.get_by_role("link", name="B 4: picked up").click()
        expect(page.locator("[data-side='1'] [data-field=step]")).to_have_text("4")
        page.select_option("[data-field=kind]", "depth")
        for side, address in enumerate((frame(OPEN_RUN, 2), frame(OTHER_RUN, 4))):
            shown = page.locator(f"[data-side='{side}'] [data-field=frame]")
            expect(shown).to_have_attribute("src", f"{address}?kind=depth")
        page.get_by_role("slider", name="Position of both runs").fill("1")
        expect(page.locator("[data-side='1'] [data-field=step]")).to_have_text("1")
        page.select_option("[data-field=speed]", "16")
        page.get_by_role("button", name="Play").click()
        expect(page.locator("[data-side='0'] [data-field=step]")).to_have_text(str(len(tiny.ACTIONS)))
        assert page.locator("[data-field=strip] .mark-picked_up").count() == 3


def test_without_scripts_links_lead_on(paired: LeaderboardSite, browser: Browser) -> None:
    with (
        served(paired, NOBODY) as site,
        opened(browser, f"{site.address}{PAIR}&step=4", java_script_enabled=False) as page,
    ):
        steps = page.locator("[data-field=step]")
        expect(steps).to_have_text(["2", "4"])
        page.get_by_role("link", name="Step on").click()
        expect(steps).to_have_text(["3", "5"])
        page.get_by_role("link", name="Swap A and B").click()
        expect(page.locator("h1")).to_have_text(f"Episode {EPISODE}: walker and truth")


def test_one_gets_there_from_an_episode_and_from_a_run(paired: LeaderboardSite, browser: Browser) -> None:
    with served(paired, NOBODY) as site, opened(browser, site.address + HERE) as page:
        page.get_by_role("button", name="Show both").click()
        expect(page).to_have_url(site.address + PAIR)
        page.wait_for_selector("#watch[data-ready]", state="attached")
        page.goto(f"{site.address}/en/runs/{OPEN_RUN}")
        page.get_by_role("link", name="The episodes in which it differs most from another run").click()
        page.get_by_label("Other run").select_option(OTHER_RUN)
        page.get_by_role("button", name="Show").click()
        expect(page.locator("tbody tr")).to_have_count(1)
        expect(page.locator("tbody td")).to_have_text(["−0.750", "1.000", "0.250"])
        page.get_by_role("link", name=EPISODE).click()
        page.wait_for_selector("#watch[data-ready]", state="attached")
        expect(page).to_have_url(site.address + PAIR)


def test_only_runs_that_the_viewer_may_see_are_offered_and_shown(paired: LeaderboardSite) -> None:
    paired.play("5" * 32, "open", "hi")
    play(paired, LIVE_RUN)
    paired.participant("ann")
    paired.run(UNPUBLISHED_RUN, split="open", participant="ann", account="ann")
    paired.publish(paired.run(WITHDRAWN_RUN, split="open"))
    paired.publisher.withdraw(HOST, WITHDRAWN_RUN)
    for viewers, offered in ((NOBODY, False), (PUBLIC, False), (OWN, True)):
        with served(paired, viewers) as site:
            for page in (site.get(HERE).text, site.get(f"/hi/runs/{OPEN_RUN}/differences").text):
                assert "5" * 32 in page
                assert OTHER_RUN in page
                assert (LIVE_RUN in page) is offered
                assert UNPUBLISHED_RUN not in page
            for run_id, status in ((LIVE_RUN, 404 if viewers is NOBODY else 200), (UNPUBLISHED_RUN, 404)):
                assert site.get(f"{HERE}?with={run_id}").status == status
                assert site.get(f"/en/runs/{run_id}/episodes/{EPISODE}?with={OPEN_RUN}").status == status
                assert site.get(f"/en/runs/{OPEN_RUN}/differences?with={run_id}").status == status


@pytest.mark.parametrize(
    "address",
    [
        f"{HERE}?with={OPEN_RUN}",
        f"{HERE}?with=",
        f"{HERE}?with={'0' * 32}",
        f"{HERE}?with={OTHER_RUN.upper()}x",
        f"{HERE}?with=%00%3Cscript%3E",
        f"{HERE}?with={HIDDEN_RUN}",
        f"{HERE}?with={'4' * 32}",
        f"{PAIR}&step=99",
        f"{PAIR}&step=-1",
        f"{PAIR}&step=x",
        f"/en/runs/{OPEN_RUN}/episodes/quokka-0?with={OTHER_RUN}",
        f"/en/runs/{OPEN_RUN}/episodes/none?with={OTHER_RUN}",
        f"/en/runs/{OPEN_RUN}/differences?with={HIDDEN_RUN}",
        f"/en/runs/{OPEN_RUN}/differences?with={'4' * 32}",
        f"/en/runs/{OPEN_RUN}/differences?with=1",
        f"/en/runs/{OPEN_RUN}/differences?with={OTHER_RUN}&sort=luck",
        f"/en/runs/{HIDDEN_RUN}/differences",
    ],
)
def test_forged_addresses_are_not_found(paired: LeaderboardSite, address: str) -> None:
    paired.play(HIDDEN_RUN, "hidden")
    paired.publish(paired.run("4" * 32))  # on another split
    with served(paired, PUBLIC) as site:
        assert site.get(address).status == 404


def test_nothing_is_compared_while_it_is_played(web: LeaderboardSite) -> None:
    web.play(OPEN_RUN, "open")
    begin(web, steps=2)
    with served(web, PUBLIC) as site:
        assert LIVE_RUN not in site.get(HERE).text
        assert site.get(f"{HERE}?with={LIVE_RUN}").status == 404
        advance(web, LIVE_RUN, 2, len(tiny.ACTIONS))
        assert site.get(f"{HERE}?with={LIVE_RUN}").status == 200


def test_names_of_strangers_are_text(paired: LeaderboardSite) -> None:
    name = "<img src=x onerror=alert(1)>"
    play_as = "6" * 32
    paired.run(play_as, split="open", agent=name, participant=name)
    paired.publish(play_as)
    with served(paired, NOBODY) as site:
        for path in (f"{HERE}?with={play_as}", HERE, f"/hi/runs/{play_as}/differences?with={OPEN_RUN}"):
            got = site.get(path)
            assert got.status == 200
            assert "<img src=x" not in got.text


@pytest.mark.parametrize(
    ("metric", "without", "expected"),
    [
        ("nDTW", (), [("b", 0.0, 1.0), ("a", 0.75, 0.25), ("c", 0.5, 0.5)]),
        ("nDTW", ("b",), [("a", 0.75, 0.25), ("c", 0.5, 0.5)]),
    ],
)
def test_the_largest_difference_comes_first(
    metric: str, without: tuple[str, ...], expected: list[tuple[str, float, float]]
) -> None:
    first = [ending("a", 1.0, 0.5), ending("c", 0.5, 0.5), ending("b", 0.0, 0.0), ending("alone", 1.0, 1.0)]
    second = [ending("b", 1.0, 1.0), ending("c", 0.5, 0.5), ending("a", 0.25, 0.25)]
    assert episode_differences(first, second, metric, without) == [EpisodeDifference(*row) for row in expected]


@pytest.mark.parametrize("width", [320, 768, 1440])
def test_nothing_scrolls_sideways(paired: LeaderboardSite, browser: Browser, width: int) -> None:
    with served(paired, NOBODY) as site:
        context = browser.new_context(viewport={"width": width, "height": 740})
        page = context.new_page()
        for path in (PAIR.replace("/en/", "/hi/"), f"/hi/runs/{OPEN_RUN}/differences?with={OTHER_RUN}", "/hi/watch"):
            page.goto(site.address + path)
            assert page.evaluate("document.documentElement.scrollWidth") == width
        context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_can_be_read_and_controls_have_names(paired: LeaderboardSite, browser: Browser, scheme: Any) -> None:
    own_pages = f"/hi/runs/{OPEN_RUN}/differences?with={OTHER_RUN}", f"/hi/runs/{OPEN_RUN}/failures", "/hi/watch"
    with served(paired, OWN) as site:
        for path in (HERE, PAIR, *own_pages):
            context = browser.new_context(color_scheme=scheme)
            page = context.new_page()
            page.goto(site.address + path)
            assert [text for ratio, text in page.evaluate(CONTRASTS) if ratio < 4.5] == []
            tree = page.locator("body").aria_snapshot()
            for role in ("link", "button", "combobox", "textbox", "slider", "img"):
                assert not [line for line in tree.splitlines() if line.strip() in (f"- {role}", f"- {role}:")], role
            assert page.locator("dl > :not(dt, dd, div)").count() == 0
            context.close()


WAYS = """() => ["0", "1"].map((n) => getComputedStyle(document.querySelector(`.trail.side-${n}`)).stroke)"""

COLOUR_BLINDNESS = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
}
"""How linear colours are seen (Machado, Oliveira and Fernandes 2009, severity 1)."""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_colour_blind_can_tell_the_ways_apart(paired: LeaderboardSite, browser: Browser, scheme: Any) -> None:
    with served(paired, NOBODY) as site:
        context = browser.new_context(color_scheme=scheme)
        page = context.new_page()
        page.goto(site.address + PAIR)
        colours = np.array([re.findall(r"\d+", colour)[:3] for colour in page.evaluate(WAYS)], dtype=float) / 255
        assert page.locator(".trail.side-1").first.evaluate("way => getComputedStyle(way).strokeDasharray") != "none"
        context.close()
    for matrix in ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], *COLOUR_BLINDNESS.values()):
        seen = np.clip(colours**2.2 @ np.array(matrix).T, 0.0, 1.0) ** (1 / 2.2)
        assert np.abs(seen[0] - seen[1]).max() > 0.3
