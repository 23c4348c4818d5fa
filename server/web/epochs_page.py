"""Template variables of the page about the epochs of hidden splits."""

from collections.abc import Mapping
from itertools import groupby
from typing import Any

from arramon_server.board.board import Board
from arramon_server.board.epoch_board import Epoch, EpochBoard
from arramon_server.board.standings import HEADLINE
from arramon_server.errors import NotFound
from arramon_server.runs.storage.epoch_store import EpochState
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.standings_query import METRICS, StandingsQuery


class EpochsPage:
    """Builds the variables of the page.

    Args:
        board: the leaderboard.
        epochs: the epochs of hidden splits.
    """

    def __init__(self, board: Board, epochs: EpochBoard) -> None:
        self._board = board
        self._epochs = epochs

    def context(self, t: PageTexts, query: Mapping[str, str]) -> dict[str, Any]:
        """Return the variables of the template.

        Args:
            t: texts of the page's language.
            query: query of the address: "language", of the instructions, and "sort", a metric of METRICS.

        Raises:
            NotFound: if there are no epochs, or the query has an unknown value.
        """
        epochs = self._epochs.all()
        known = self._board.languages()
        known_languages = sorted({code for epoch in epochs for code in known.get(epoch.statement.split, ())})
        language = query.get(
            "language", t.language if t.language in known_languages else next(iter(known_languages), t.language)
        )
        sort = query.get("sort", HEADLINE.partition("@")[0].lower())
        if not epochs or sort not in METRICS or (known_languages and language not in known_languages):
            raise NotFound("there is no such list of epochs")
        return {
            "epochs": [
                (base, [(epoch, self._facts(t, epoch)) for epoch in found])
                for base, found in groupby(epochs, key=lambda epoch: epoch.statement.base)
            ],
            "example": next((epoch for epoch in epochs if epoch.command), epochs[0]).statement.split,
            "state_of": lambda epoch: state_of(t, epoch),
            "standings": lambda split: (
                f"/{t.language}/{StandingsQuery(split, language).link()}" if language in known.get(split, ()) else ""
            ),
            "pairs": list(self._epochs.changes_between_epochs(language, METRICS[sort])),
            "language": language,
            "sort": sort,
            "heading": METRICS[sort].partition("@")[0],
            "languages_choices": [(code, t.named("languages", code)) for code in known_languages],
            "metric_choices": [(name, metric.partition("@")[0]) for name, metric in METRICS.items()],
        }

    def _facts(self, t: PageTexts, epoch: Epoch) -> list[tuple[str, str]]:
        record, statement = epoch.record, epoch.statement
        facts = {
            "opened": t.moment(record.opened_at),
            "closed": t.moment(record.closed_at) if record.closed_at else "–",
            "revealed": t.moment(record.revealed_at) if record.revealed_at else "–",
            "episodes": t.whole(statement.episodes),
            "sections": ", ".join(statement.sections),
            "generator": statement.generator,
            "data": statement.data_hash,
            "secret_hash": statement.secret_sha256,
            "commitment": record.commitment.hex(),
            "secret": record.secret or t("epochs.unrevealed"),
        }
        return [(t(f"epochs.{name}"), value) for name, value in facts.items()]


def state_of(t: PageTexts, epoch: Epoch) -> str:
    """Return an epoch's state as text."""
    words = {
        EpochState.OPEN: "epochs.is_open",
        EpochState.CLOSED: "epochs.is_closed",
        EpochState.REVEALED: "epochs.is_revealed",
    }
    return t(words[epoch.record.state])
