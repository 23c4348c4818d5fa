"""The list of a run's episodes with its filters, the page of one, its maps and what is named on them."""

import re
from dataclasses import replace

import pytest

from arramon_client.world import FACADES, FURNITURE, Action
from arramon_lang.grammar import forms_of
from arramon_lang.language import load
from arramon_server.board.corrector import Corrector
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage.causes import AGENT_FINISHED, FORFEITED
from arramon_server.runs.storage.records import COMPLETE, CommitBatch, EpisodeEnding
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.sim.bullet import Obstacles
from arramon_server.sim.city import city_scene
from arramon_server.sim.room import RoomPosition
from arramon_server.sim.rules import Limits
from arramon_server.sim.section import Building, Prop
from arramon_server.web.episodes_page import FAILURES, NAVIGATION, NOTHING, OBJECT, PLACEMENT, EpisodeFilter, failure_of
from arramon_server.web.named_things import named_things
from arramon_server.web.page_texts import all_texts
from arramon_server.web.room_map import AssemblyReplay
from tests import tiny
from tests.web.leaderboard_site import HIDDEN_RUN, OPEN_RUN, LeaderboardSite
from tests.web.reading import Page

EN, HI = all_texts()["en"], all_texts()["hi"]


def scores(**values: float) -> dict[str, float]:
    return {**dict.fromkeys(METRICS, 0.0), **{name.replace("_", "-"): value for name, value in values.items()}}


TURNS = {
    NAVIGATION: scores(CTC_0=1.0, PTC=1.0),
    OBJECT: scores(CTC_3=1.0, PTC=1.0),
    PLACEMENT: scores(CTC_3=1.0, CTC_0=1.0),
    NOTHING: scores(CTC_3=1.0, CTC_0=1.0, PTC=1.0),
}


@pytest.mark.parametrize("failed", TURNS)
def test_a_turn_fails_at_the_first_thing_that_went_wrong(failed: str) -> None:
    assert failure_of(TURNS[failed]) == failed


def ending(one: str, two: str, cause: str = AGENT_FINISHED) -> EpisodeEnding:
    return EpisodeEnding("r", "0", cause, 7, [TURNS[one], TURNS[two]])


@pytest.mark.parametrize(("chosen", "first", "second", "fits"), [
    (EpisodeFilter(), NAVIGATION, NOTHING, True),
    (EpisodeFilter(OBJECT), NOTHING, OBJECT, True),
    (EpisodeFilter(OBJECT, "1"), NOTHING, OBJECT, False),
    (EpisodeFilter(OBJECT, "2"), NOTHING, OBJECT, True),
    (EpisodeFilter(NOTHING), NOTHING, OBJECT, False),
    (EpisodeFilter(NOTHING), NOTHING, NOTHING, True),
    (EpisodeFilter(NOTHING, "1"), NOTHING, OBJECT, True),
    (EpisodeFilter(cause=FORFEITED), NOTHING, NOTHING, False),
    (EpisodeFilter(cause=AGENT_FINISHED), NOTHING, NOTHING, True),
])  # fmt: skip
def test_filters(chosen: EpisodeFilter, first: str, second: str, fits: bool) -> None:
    assert chosen.fits(ending(first, second)) is fits


def mixed(web: LeaderboardSite, count: int = 12) -> str:
    """Publish a run on a split of its own whose even episodes fail at placing in turn 2."""
    web.restart(many=tiny.write(web.folder, "many", count))
    run_id = "9" * 32
    web.run(run_id, split="many", over=False)
    order = [one.episode_id for one in web.splits["many"].in_playing_order("en")]
    found = [
        replace(ending(NOTHING, NOTHING if int(name) % 2 else PLACEMENT), run_id=run_id, episode_id=name)
        for name in order
    ]
    web.journal.commit(CommitBatch(endings=found))
    web.journal.set_state(run_id, COMPLETE)
    return web.publish(run_id)


def listed(text: str) -> list[str]:
    return re.findall(r'<th scope="row" class="pin name"><a href="[^"]*">([^<]*)', text)


def test_all_episodes_are_listed_by_number_and_filtered(web: LeaderboardSite) -> None:
    run_id = mixed(web)
    base = f"/en/runs/{run_id}/episodes"
    assert f'href="{base}"' in web.site.get(f"/en/runs/{run_id}").text
    text = web.site.get(base).text
    assert Page(text).all("select")
    assert listed(text) == [str(number) for number in range(12)]
    assert listed(web.site.get(f"{base}?failed=placement").text) == ["0", "2", "4", "6", "8", "10"]
    assert listed(web.site.get(f"{base}?failed=placement&turn=1").text) == []
    assert listed(web.site.get(f"{base}?failed=nothing&turn=1").text) == [str(number) for number in range(12)]
    assert listed(web.site.get(f"{base}?failed=nothing").text) == ["1", "3", "5", "7", "9", "11"]
    for wrong in ("failed=luck", "turn=3", "cause=LUCK", "page=2", "page=0", "page=x"):
        assert web.site.get(f"{base}?{wrong}").status == 404


def test_long_lists_have_pages(web: LeaderboardSite) -> None:
    run_id = mixed(web, 205)
    base = f"/en/runs/{run_id}/episodes?failed=placement"
    first, second = (listed(web.site.get(f"{base}&page={page}").text) for page in (1, 2))
    assert (len(first), second) == (100, ["200", "202", "204"])
    assert "failed=placement&amp;page=2" in web.site.get(base).text


def test_an_episode_leads_to_the_next_and_the_previous_of_its_list(web: LeaderboardSite) -> None:
    run_id = mixed(web)
    base = f"/en/runs/{run_id}/episodes"

    def around(path: str) -> list[str]:
        text = web.site.get(path).text
        return sorted(set(re.findall(r'href="([^"]*)" rel="(?:prev|next)"', text)))

    assert around(f"{base}/9") == [f"{base}/10", f"{base}/8"]
    assert around(f"{base}/0") == [f"{base}/1"]
    assert around(f"{base}/8?failed=placement&turn=2") == [
        f"{base}/10?failed=placement&amp;turn=2", f"{base}/6?failed=placement&amp;turn=2",
    ]  # fmt: skip
    assert around(f"{base}/10?failed=placement") == [f"{base}/8?failed=placement"]
    assert around(f"{base}/9?failed=placement") == [f"{base}/10", f"{base}/8"]  # not in that list
    assert web.site.get(f"{base}/9?failed=luck").status == 404


def test_a_number_in_the_form_leads_to_its_episode(web: LeaderboardSite) -> None:
    run_id = mixed(web)
    got = web.site.get(f"/en/runs/{run_id}/episodes?episode=3")
    assert (got.status, got.headers["location"]) == (303, f"/en/runs/{run_id}/episodes/3")


def test_episodes_of_hidden_splits_are_not_listed(shown: LeaderboardSite) -> None:
    assert shown.site.get(f"/en/runs/{HIDDEN_RUN}/episodes").status == 404
    assert shown.site.get(f"/en/runs/{HIDDEN_RUN}/episodes?failed=placement").status == 404


def test_void_episodes_are_marked(web: LeaderboardSite) -> None:
    run_id = mixed(web)
    Corrector(web.database, web.splits, SigningKey(web.folder / "key.pem")).void("many", ["3"], "a <b>wall</b>")
    text = web.site.get(f"/en/runs/{run_id}/episodes").text
    assert text.count('<span class="mark">void</span>') == 1
    assert '<span class="mark">void</span>' in web.site.get(f"/en/runs/{run_id}/episodes/3").text
    for page in (f"/en/runs/{run_id}", "/en/?split=many&language=en"):
        shown = web.site.get(page).text
        assert "episodes voided: 1 (3). Reason: a &lt;b&gt;wall&lt;/b&gt;" in shown
    assert "Receipt 1, superseded on" not in web.site.get(f"/en/runs/{run_id}").text
    Corrector(web.database, web.splits, SigningKey(web.folder / "key.pem")).renew_receipts("many")
    assert "Receipt 1, superseded on" in web.site.get(f"/en/runs/{run_id}").text
    old = web.site.get(f"/runs/{run_id}/receipt.json?number=1")
    now = web.site.get(f"/runs/{run_id}/receipt.json")
    assert ("voided" in old.text, "voided" in now.text) == (False, True)
    assert web.site.get(f"/runs/{run_id}/receipt.json?number=2").status == 404
    assert web.site.get(f"/runs/{run_id}/receipt.json?number=x").status == 404


@pytest.mark.parametrize("language", ["en", "hi"])
def test_the_room_is_drawn_with_what_lies_in_it(shown: LeaderboardSite, language: str) -> None:
    text = shown.site.get(f"/{language}/runs/{OPEN_RUN}/episodes/quokka-1").text
    assert text.count('<svg class="room"') == 2
    piles = re.findall(r"<title>([^<]*)</title><rect", text)
    bowl = {"en": "dotted white bowl", "hi": "बिंदीदार सफ़ेद कटोरा"}[language]
    glass = {"en": "dotted purple hourglass", "hi": "बिंदीदार बैंगनी रेतघड़ी"}[language]
    assert piles == [bowl, bowl, glass]


def test_rooms_as_they_were_played() -> None:
    with Obstacles(city_scene(tiny.SECTION)) as ground:
        session = EpisodeSession(tiny.episode("0"), ground, Limits(150))
        watch = AssemblyReplay(session)
        watch.replay((*tiny.ACTIONS[:3], Action.RIGHT, Action.LEFT, *tiny.ACTIONS[3:10], Action.INTERACT))
        first, second = watch.maps()
    assert (first.played, first.placed, first.placed_level, first.forced) == ("25,35 25,25", (25.0, 15.0), 1, False)
    assert first.target == (25.0, 15.0)
    assert (str(first.carried), str(second.carried)) == ("striped red mug", "dotted blue tv")
    assert [(pile.x, pile.y) for pile in second.piles] == [(5.0, 35.0), (25.0, 15.0)]
    assert (second.played, second.placed, second.target_level) == ("", None, 2)


def test_a_room_that_was_not_reached_shows_what_would_have_been_there() -> None:
    with Obstacles(city_scene(tiny.SECTION)) as ground:
        session = EpisodeSession(tiny.episode("0"), ground, Limits(150))
        first, second = AssemblyReplay(session).maps()
    assert [len(room.piles) for room in (first, second)] == [1, 1]
    assert (first.played, first.placed, first.carried) == ("", None, None)
    assert RoomPosition(2, 1, 2).level == first.target_level


SECTION = replace(
    tiny.SECTION,
    buildings=(Building(0.0, 12.0, 5.0, 1.0, 0.0, 3.0, "brick"), Building(15.0, 15.0, 1.0, 1.0, 0.0, 3.0, "glass")),
    props=(
        Prop("bench", 2.0, 0.0, 0.0), Prop("bench", 3.0, 0.0, 0.0), Prop("bench", 4.0, 0.0, 0.0),
        Prop("bench", 5.0, 0.0, 0.0),
        Prop("car", 0.0, 3.0, 0.0, "red"), Prop("car", 1.0, 3.0, 0.0, "blue"), Prop("cone", 0.0, 1.0, 0.0),
        Prop("tree", 19.0, 19.0, 0.0),
    ),
)  # fmt: skip
PATH = ((0.0, 0.0), (0.0, 5.0))


@pytest.mark.parametrize(("text", "names"), [
    ("Go past the bench.", ["bench"] * 3),
    ("Go past the Benches to the tree.", ["bench"] * 3),  # the tree is far away
    ("Stop at the red car.", ["red parked car"]),
    ("Stop at the car.", ["parked car"] * 2),
    ("Face the brick building, not the glass building.", ["brick building"]),
    ("The treehouse and the benchmark.", []),
])  # fmt: skip
def test_things_near_the_way_that_a_text_names(text: str, names: list[str]) -> None:
    assert [one.name for one in named_things(EN, EN, SECTION, text, PATH)] == names


def test_things_are_named_in_the_language_of_the_page() -> None:
    found = named_things(EN, HI, SECTION, "लाल गाड़ी के पास बेंच तक चलें।", PATH)
    assert {one.name for one in found} == {"bench", "red parked car"}
    assert [one.name for one in named_things(HI, EN, SECTION, "the cone", PATH)] == [HI("things.cone").split("|")[0]]


@pytest.mark.parametrize("code", ["en", "hi"])
def test_maps_know_all_words_of_written_instructions(code: str) -> None:
    nouns, texts = load(code).grammar.nouns, all_texts()[code]
    for kind in FURNITURE:
        written = {form.replace("~", "") for form in forms_of(nouns[kind])}
        assert written <= set(texts(f"things.{kind}").split("|")), kind
    assert {f"things.building_{facade}" for facade in FACADES} <= texts.words.keys()


def test_every_failure_has_a_word() -> None:
    assert all(f"episodes.{name}" in EN.words for name in FAILURES)
