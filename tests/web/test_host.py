"""What the host says on the pages: its name, contact and rules, when leaderboards close, and that they are frozen."""

from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import pytest

from arramon_server.board.board import Board
from arramon_server.board.epoch_board import EpochBoard
from arramon_server.closing_times import ClosingTimes
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.signing import SigningKey
from arramon_server.split_times import SplitTimes
from arramon_server.web.host import UNNAMED, Host, link_of
from arramon_server.web.pages import Pages
from arramon_server.web.rendering import breakable
from tests.board.leaderboard_backend import CLOCKS, STEPS, LeaderboardBackend
from tests.web.reading import Page
from tests.web.serving import Site

CLOSES = datetime(2100, 6, 1, 12, tzinfo=UTC)
SAID = Host("Lab <b>1</b>", "mail@example.org", "https://example.org/rules")


class Season(LeaderboardBackend):
    """A backend whose split "tiny" closes, with a site."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.now = datetime(2100, 1, 1, tzinfo=UTC)
        self.publish(self.run("1" * 32, 1.0, agent="good"))
        self.publish(self.run("2" * 32, 0.5, agent="poor"))
        self.folder = folder

    def site(self, *, frozen: bool, host: Host = SAID) -> Site:
        closes = ClosingTimes(SplitTimes((("tiny", CLOSES),)), frozen, lambda: self.now)
        board = Board(self.entries, self.splits, steps_per_phase=STEPS, clocks=CLOCKS, closing=closes)
        epochs = EpochBoard(board, self.entries, self.epochs, self.journal, self.splits)
        receipts = Receipts(self.database, self.splits, SigningKey(self.folder / "key.pem"), closes)
        return Site(Pages(board, self.journal, receipts, self.splits, epochs, host))


@pytest.fixture
def season(tmp_path: Path) -> Iterator[Season]:
    made = Season(tmp_path)
    with closing(made.database):
        yield made


LIST = "/en/?split=tiny&language=en"


def test_every_page_names_the_host(season: Season) -> None:
    with closing(season.site(frozen=False)) as site:
        for path in ("/en/", "/hi/", f"/en/runs/{'1' * 32}", "/en/epochs", "/en/nothing"):
            foot = site.get(path).text.partition("<footer>")[2]
            assert "<bdi>Lab &lt;b&gt;1&lt;/b&gt;</bdi>" in foot
            assert 'href="mailto:mail@example.org"' in foot
            assert 'href="https://example.org/rules"' in foot
    with closing(season.site(frozen=False, host=UNNAMED)) as site:
        assert "Hosted by" not in site.get("/en/").text


@pytest.mark.parametrize(("text", "link"), [
    ("https://example.org/a", "https://example.org/a"),
    ("mail@example.org", "mailto:mail@example.org"),
    ("javascript:alert(1)", ""),
    ("javascript:a@example.org", ""),
    ("One run a day.", ""),
    ("see https://example.org", ""),
    ("@example.org", ""),
    ("a@b", ""),
])  # fmt: skip
def test_addresses_alone_are_links(text: str, link: str) -> None:
    assert link_of(text) == link


def test_pages_say_when_a_leaderboard_closes(season: Season) -> None:
    with closing(season.site(frozen=False)) as site:
        assert "This leaderboard closes on 1 June 2100, 12:00 UTC" in site.get(LIST).text
        assert "1.000" in site.get(LIST).text
        season.now = CLOSES
        assert "This leaderboard closed on 1 June 2100, 12:00 UTC" in site.get(LIST).text
        assert "closes on" not in site.get("/en/?split=secret&language=en").text


def test_a_frozen_leaderboard_shows_no_score_on_any_page(season: Season) -> None:
    run, paths = (
        "1" * 32,
        ("/en/?split=tiny&language=both", LIST, f"{LIST}&sort=ndtw&order=asc", f"{LIST}&turns=1&cost=price"),
    )
    with closing(season.site(frozen=True)) as site:
        for path in (*paths, f"/en/runs/{run}", f"/hi/runs/{run}"):
            text = site.get(path).text
            assert Page(text)
            assert not any(score in text for score in ("1.000", "0.500", "0.610", 'class="range"'))
        assert "This leaderboard is frozen: scores and ranks are shown when it closes" in site.get(LIST).text
        assert site.get(LIST).text.index("good") < site.get(LIST).text.index("poor")
        for path in (
            f"/en/runs/{run}/episodes",
            f"/en/runs/{run}/episodes/0",
            f"/runs/{run}/receipt.json",
            f"/runs/{run}/actions.json",
        ):
            assert site.get("/" + path.replace("RUN", run)).status == 404
        assert "has no rank" in site.get(f"/en/runs/{run}/against").text
        for form in ("csv", "json"):
            assert "0.5" not in site.get(f"/standings.{form}?split=tiny&language=en").text
        season.now = CLOSES
        assert site.get(f"/runs/{run}/receipt.json").status == 200
        assert "1.000" in site.get(LIST).text


@pytest.mark.parametrize(("name", "shown"), [
    ("agents.vl_grounded", "agents.<wbr>vl_<wbr>grounded"),
    ("two-fold words", "two-fold words"),
    ("a.<b>", "a.<wbr>&lt;b&gt;"),
    ("हिन्दी_एजेंट", "हिन्दी_<wbr>एजेंट"),
])  # fmt: skip
def test_names_break_after_words(name: str, shown: str) -> None:
    assert str(breakable(name)) == shown
