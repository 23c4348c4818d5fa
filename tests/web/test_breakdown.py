"""The part of a run's page with its scores by what turns ask for, on open and hidden splits."""

import re
from collections.abc import Iterator
from contextlib import closing

import pytest

from arramon_server.runs.results.breakdown import Breakdowns
from arramon_server.scoring.disclosure import MIN_EPISODES
from tests import demanding
from tests.web.leaderboard_site import HIDDEN_RUN, LeaderboardSite
from tests.web.reading import Page

OPEN, SECRET = "1" * 32, "2" * 32


@pytest.fixture(scope="module")
def demanding_site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LeaderboardSite]:
    folder = tmp_path_factory.mktemp("backend")
    backend = LeaderboardSite(folder)
    with closing(backend.database):
        backend.restart(
            asked=demanding.written(folder, "asked", 40), guarded=demanding.written(folder, "guarded", 90, hidden=True)
        )
        backend.publish(backend.run(OPEN, [0.0, 1.0] * 20, split="asked"))
        backend.publish(backend.run(SECRET, [0.0, 1.0, 1.0] * 30, split="guarded"))
        backend.play(HIDDEN_RUN, "hidden")
        yield backend
        backend.site.close()


@pytest.mark.parametrize("language", ["en", "hi"])
def test_open_run_has_all_groups_with_words_for_each(demanding_site: LeaderboardSite, language: str) -> None:
    text = demanding_site.site.get(f"/{language}/runs/{OPEN}").text
    part = text[text.index('id="report"') : text.index('id="causes"')]
    run = demanding_site.journal.run(OPEN)
    groups = (
        Breakdowns(demanding_site.splits, demanding_site.journal.play_digest)
        .of(run, demanding_site.journal.endings(OPEN))
        .lines
    )
    assert part.count('class="forest"') == len(groups) > 30
    assert not re.search(r"(step|turn|landmark|relation)\.[a-z_]+", part)  # every name has words
    assert len(Page(text).all("caption")) == len(Page(text).all("table"))


@pytest.mark.parametrize("language", ["en", "hi"])
def test_hidden_run_has_few_groups_and_rounded_scores(demanding_site: LeaderboardSite, language: str) -> None:
    text = demanding_site.site.get(f"/{language}/runs/{SECRET}").text
    part = text[text.index('id="report"') : text.index('id="causes"')]
    found = Breakdowns(demanding_site.splits, demanding_site.journal.play_digest).of(
        demanding_site.journal.run(SECRET), demanding_site.journal.endings(SECRET)
    )
    assert part.count('class="forest"') == len(found.lines)
    assert 2 < len(found.lines) < 20
    assert found.withheld > 10
    assert str(found.withheld) in part
    assert str(MIN_EPISODES) in part
    numbers = {float(number) for number in re.findall(r"[01]\.\d{3}", part)}
    assert numbers
    assert all(number * 100 == pytest.approx(round(number * 100)) for number in numbers)


def test_tiny_hidden_split_shows_no_group(demanding_site: LeaderboardSite) -> None:
    text = demanding_site.site.get(f"/en/runs/{HIDDEN_RUN}").text
    assert "has too few episodes for groups" in text
    assert 'class="forest"' not in text


def test_run_on_data_that_has_changed_has_no_report(
    demanding_site: LeaderboardSite, tmp_path_factory: pytest.TempPathFactory
) -> None:
    other = demanding.written(tmp_path_factory.mktemp("other"), "asked", 12)
    before = demanding_site.splits["asked"]
    demanding_site.restart(asked=other)
    text = demanding_site.site.get(f"/en/runs/{OPEN}").text
    demanding_site.restart(asked=before)
    assert 'class="forest"' not in text
    assert "data has changed" in text
