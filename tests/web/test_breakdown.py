"""The part of a run's page with its scores by what turns ask for, on open and hidden splits."""

import re
from collections.abc import Iterator
from contextlib import closing

import pytest

from arramon_server.runs.results.breakdown import Breakdowns
from arramon_server.scoring.disclosure import MIN_EPISODES
from tests import demanding
from tests.web.made import HIDDEN_RUN, WebHouse
from tests.web.reading import Page

OPEN, SECRET = "1" * 32, "2" * 32


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebHouse]:
    folder = tmp_path_factory.mktemp("house")
    house = WebHouse(folder)
    with closing(house.database):
        house.restart(
            asked=demanding.written(folder, "asked", 40), guarded=demanding.written(folder, "guarded", 90, hidden=True)
        )
        house.publish(house.run(OPEN, [0.0, 1.0] * 20, split="asked"))
        house.publish(house.run(SECRET, [0.0, 1.0, 1.0] * 30, split="guarded"))
        house.play(HIDDEN_RUN, "hidden")
        yield house
        house.site.close()


@pytest.mark.parametrize("language", ["en", "hi"])
def test_open_run_has_all_groups_with_words_for_each(asked: WebHouse, language: str) -> None:
    text = asked.site.get(f"/{language}/runs/{OPEN}").text
    part = text[text.index('id="report"') : text.index('id="causes"')]
    run = asked.journal.run(OPEN)
    groups = Breakdowns(asked.splits, asked.journal.play).of(run, asked.journal.endings(OPEN)).lines
    assert part.count('class="forest"') == len(groups) > 30
    assert not re.search(r"(step|turn|landmark|relation)\.[a-z_]+", part)  # every name has words
    assert len(Page(text).all("caption")) == len(Page(text).all("table"))


@pytest.mark.parametrize("language", ["en", "hi"])
def test_hidden_run_has_few_groups_and_rounded_scores(asked: WebHouse, language: str) -> None:
    text = asked.site.get(f"/{language}/runs/{SECRET}").text
    part = text[text.index('id="report"') : text.index('id="causes"')]
    found = Breakdowns(asked.splits, asked.journal.play).of(asked.journal.run(SECRET), asked.journal.endings(SECRET))
    assert part.count('class="forest"') == len(found.lines)
    assert 2 < len(found.lines) < 20
    assert found.withheld > 10
    assert str(found.withheld) in part
    assert str(MIN_EPISODES) in part
    numbers = {float(number) for number in re.findall(r"[01]\.\d{3}", part)}
    assert numbers
    assert all(number * 100 == pytest.approx(round(number * 100)) for number in numbers)


def test_tiny_hidden_split_shows_no_group(asked: WebHouse) -> None:
    text = asked.site.get(f"/en/runs/{HIDDEN_RUN}").text
    assert "has too few episodes for groups" in text
    assert 'class="forest"' not in text


def test_run_on_data_that_has_changed_has_no_report(asked: WebHouse, tmp_path_factory: pytest.TempPathFactory) -> None:
    other = demanding.written(tmp_path_factory.mktemp("other"), "asked", 12)
    before = asked.splits["asked"]
    asked.restart(asked=other)
    text = asked.site.get(f"/en/runs/{OPEN}").text
    asked.restart(asked=before)
    assert 'class="forest"' not in text
    assert "data has changed" in text
