"""Template variables of the standings page."""

import re
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from arramon_server.board.board import Board
from arramon_server.board.epoch_board import EpochBoard
from arramon_server.board.standings import BOTH, Entry, Mark, Standing
from arramon_server.episodes.splits import Split
from arramon_server.errors import NotFound
from arramon_server.runs.storage.epoch_store import EpochState
from arramon_server.runs.storage.records import CANCELLED
from arramon_server.visible_text import shown
from arramon_server.web.corrections_part import closing_sentence, correction_sentence
from arramon_server.web.cost_part import COSTS, cost_part
from arramon_server.web.curves import FRAME
from arramon_server.web.epochs_page import state_of
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.standings_query import COVERAGES, GAP, METRICS, SENSORS, TURNS, StandingsQuery, first_order

PAGE_SIZE = 100
"""Standings on one page."""

REFERENCE_LANGUAGE = "en"
"""Language of the instructions with which the paper's scores were measured."""

COMMANDS = """\
arramon-client --agent agents.random_walk --split {split} --lang {language} {server}
arramon-client publish RUN {server}
"""


class StandingsPage:
    """Builds the variables of the page.

    Args:
        board: the leaderboard.
        splits: the splits served, by name.
        epochs: the epochs of hidden splits.
    """

    def __init__(self, board: Board, splits: Mapping[str, Split], epochs: EpochBoard) -> None:
        self._epochs = epochs
        self._board = board
        self._splits = splits
        self._episodes = {name: split.languages for name, split in splits.items()}

    def defaults(self, language: str) -> StandingsQuery:
        """Return the default list for readers of a language: a split with published runs, preferably a hidden one.

        Among hidden splits, the latest open epoch is preferred, and closed epochs come last.
        """
        languages = self._board.languages()
        epochs = {epoch.statement.split: epoch for epoch in self._epochs.all()}

        def order(name: str) -> tuple[bool, bool, int, str]:
            epoch = epochs.get(name)
            if epoch is None:
                return not self._is_hidden(name), False, 0, name
            return False, epoch.record.state is not EpochState.OPEN, -epoch.number, name

        ordered = sorted(languages, key=order)
        choices = [
            StandingsQuery(name, language if language in languages[name] else next(iter(languages[name]), language))
            for name in ordered
            if languages[name]
        ]
        listed = (choice for choice in choices if self._board.has_entries(choice.split, choice.language))
        return next(listed, choices[0] if choices else StandingsQuery("", language))

    def context(self, t: PageTexts, choice: StandingsQuery, defaults: StandingsQuery, server: str) -> dict[str, Any]:
        """Return the variables of the template.

        Args:
            t: texts of the page's language.
            choice: the list that the reader requested.
            defaults: the default list for the reader.
            server: options with which the reader's client reaches the server.

        Raises:
            NotFound: if the table has no page of that number.
        """
        listing = self._board.listing(choice.split, choice.language, choice.metric)
        ranked = list(listing.standings)
        fitting = choice.sorted([one for one in ranked if choice.fits(one)])
        first = (choice.page - 1) * PAGE_SIZE
        here = fitting[first : first + PAGE_SIZE]
        if choice.page > 1 and first >= len(fitting):
            raise NotFound(f"there is no page {choice.page}")
        row = TURNS[choice.turns]
        references = self._board.reference(choice.split, REFERENCE_LANGUAGE)
        language = choice.language if choice.language != BOTH else REFERENCE_LANGUAGE
        return {
            "choice": choice,
            "defaults": defaults,
            "row": row,
            "standings": here,
            "cost": None if listing.frozen else cost_part(t, here, row, choice.metric, choice.cost),
            "frame": FRAME,
            "entry_name": lambda one, entry: _entry_name(t, one, entry),
            "pages": -(-len(fitting) // PAGE_SIZE),
            "references": [line for line in references if row in line.rows and not listing.frozen],
            "shown": len(fitting),
            "all": len(ranked),
            "about": self._about(t, choice),
            "epoch": self._epoch(t, choice.split),
            "closes": closing_sentence(t, self._board.closing, choice.split),
            "frozen": listing.frozen,
            "corrections": [correction_sentence(t, correction) for correction in listing.corrections],
            "commands": COMMANDS.format(split=choice.split, language=language, server=server),
            "elsewhere": [] if ranked else self._elsewhere(t, choice),
            "everything": choice.link(sensors="all", coverage="all"),
            "files": choice.link(turns="total", sensors="all", coverage="all", order=first_order(choice.sort)),
            "all_marks": [*(mark.value for mark in Mark), "cancelled", "reference"],
            "coverage": lambda one: _coverage(t, one),
            "published": _published,
            "tables": lambda line: ", ".join(re.findall(r"\d+", line.source)),
            "cancelled": lambda one: any(entry.run.state == CANCELLED for entry in one.entries),
            "metrics": METRICS,
            "columns": columns(t),
            "combined": choice.language == BOTH,
            "by_gap": choice.sort == GAP,
            **self._choices(t),
        }

    def _elsewhere(self, t: PageTexts, choice: StandingsQuery) -> list[tuple[str, str, str]]:
        """Return link, name and number of published runs of the split's other languages that have any."""
        found = []
        for language in self._board.languages()[choice.split]:
            if language != choice.language and self._board.has_entries(choice.split, language):
                standings = self._board.listing(choice.split, language, choice.metric).standings
                runs = sum(len(one.entries) for one in standings)
                link = choice.link(language=language, sensors="all", coverage="all")
                found.append((link, t.named("languages", language), t.whole(runs)))
        return found

    def _choices(self, t: PageTexts) -> dict[str, list[tuple[str, str]]]:
        languages = self._board.languages()
        known_languages = sorted({language for codes in languages.values() for language in codes})
        return {
            "splits": [(name, name) for name in languages],
            "instruction_languages": [(code, t.named("languages", code)) for code in (*known_languages, BOTH)],
            "turns": [(name, t(f"turns.{name}")) for name in TURNS],
            "sensors_choices": [(name, t(f"choices.{name}")) for name in SENSORS],
            "costs": [(name, t(f"cost.{name}")) for name in COSTS],
            "coverages": [(name, t(f"choices.{name}")) for name in COVERAGES],
        }

    def _about(self, t: PageTexts, choice: StandingsQuery) -> str:
        split = self._splits.get(choice.split)
        if split is None:
            return t("standings.gone")
        kind = t("standings.hidden_split") if split.hidden else t("standings.open_split")
        numbers = self._episodes[choice.split]
        episodes = numbers.get(choice.language, min(numbers.values(), default=0))
        return t("standings.about_split", kind=kind, episodes=t.whole(episodes))

    def _epoch(self, t: PageTexts, split: str) -> str:
        """Return a sentence about a split's epoch; empty if the split is not an epoch."""
        epoch = self._epochs.find(split)
        if epoch is None:
            return ""
        return t("epochs.about", number=t.whole(epoch.number), base=epoch.statement.base, state=state_of(t, epoch))

    def _is_hidden(self, name: str) -> bool:
        return name in self._splits and self._splits[name].hidden


def columns(t: PageTexts) -> list[tuple[str, str, str]]:
    """Return the score columns as (name in addresses, heading, meaning)."""
    names = [(name, metric.partition("@")[0]) for name, metric in METRICS.items()]
    return [(name, heading, t(f"metrics.{heading}")) for name, heading in names]


def _coverage(t: PageTexts, standing: Standing) -> str:
    if standing.coverage is None:
        return "–"
    return t("standings.coverage_full") if standing.coverage == 1.0 else t.percent(standing.coverage)


def _entry_name(t: PageTexts, standing: Standing, entry: Entry) -> str:
    """Return what distinguishes a run from the others of its standing: the language, the seed, or both."""
    names = [t.named("languages", entry.run.language)] if len(standing.languages) > 1 else []
    if standing.seeds > 1 or len(standing.entries) > len(standing.languages):
        names.append(t("standings.seed", seed=shown(entry.seed)) if entry.seed else t("standings.own_seed"))
    return " ".join(names)


def _published(standing: Standing) -> datetime:
    return max(entry.published_at for entry in standing.entries)
