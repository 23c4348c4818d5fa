"""People as a group: mean over people, intervals by people and by episodes, and how often each knew a section."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from arramon_server.board.board import Board
from arramon_server.board.standings import COLUMNS, Entry, Mark, PaperResult
from arramon_server.episodes.splits import Split
from arramon_server.runs.accounts.accounts import ANONYMOUS_NAME
from arramon_server.runs.run_service import HUMAN
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import EpisodeEnding
from arramon_server.scoring.intervals import Bounds, Floats, episode_moments, mean_bounds, section_bounds

UNLIKE = frozenset({Mark.OTHER_DATA, Mark.OTHER_LIMITS, Mark.OTHER_CLOCKS, Mark.REPRODUCTION})
"""Marks of runs that cannot be averaged with the others."""

PAPER = "Human-"
"""Beginning of the names of the paper's people."""

Person = str
"""Account or name of a person; the run's id for one without either, of whom other runs are not known."""


@dataclass(frozen=True, slots=True)
class WalkedBefore:
    """Episodes of people who had walked the section equally often before.

    Attributes:
        times: number of the person's earlier episodes in the section.
        episodes: number of such episodes.
        means: mean of each metric of COLUMNS.
    """

    times: int
    episodes: int
    means: Floats


@dataclass(frozen=True, eq=False)
class PeopleGroup:
    """People who played a split in one language with the same aids.

    Attributes:
        arguments: the aids.
        people: number of people.
        episodes: number of their episodes, void ones left out.
        mean: mean over people of each person's mean, by metric of COLUMNS.
        by_people: intervals for the mean over other people; None with one person.
        by_episodes: mean over all episodes, with intervals for other episodes in these sections.
        walked_before: episodes by how often the person had walked the section before.
        entries: their published runs.
    """

    arguments: tuple[tuple[str, str], ...]
    people: int
    episodes: int
    mean: Floats
    by_people: Bounds | None
    by_episodes: Bounds
    walked_before: tuple[WalkedBefore, ...]
    entries: tuple[Entry, ...]


class PeopleBoard:
    """Groups of people on the open splits. Thread-safe.

    Args:
        board: the leaderboard, with the published runs.
        journal: scores of single episodes.
        splits: splits served, by name.
    """

    def __init__(self, board: Board, journal: Journal, splits: Mapping[str, Split]) -> None:
        self._board = board
        self._journal = journal
        self._splits = splits

    def groups(self, split: str, language: str) -> list[PeopleGroup]:
        """Return the groups of a split in a language, one for each set of aids; none on hidden and frozen splits.

        Raises:
            NotFound: if there is no such split or language.
        """
        listing = self._board.listing(split, language)
        served = self._splits.get(split)
        if served is None or served.hidden or listing.frozen:
            return []
        by_arguments: dict[tuple[tuple[str, str], ...], list[Entry]] = {}
        for standing in listing.standings:
            for entry in standing.entries:
                if entry.run.agent == HUMAN and not UNLIKE.intersection(entry.marks):
                    by_arguments.setdefault(entry.run.agent_arguments, []).append(entry)
        return [self._group(served, arguments, entries) for arguments, entries in sorted(by_arguments.items())]

    def references(self, split: str, language: str) -> list[PaperResult]:
        """Return the paper's results of people on a split, which are measured on other data."""
        return [one for one in self._board.listing(split, language).references if one.name.startswith(PAPER)]

    def _group(self, split: Split, arguments: tuple[tuple[str, str], ...], entries: Sequence[Entry]) -> PeopleGroup:
        voided = self._journal.voided(split.name)
        people: list[Person] = []
        endings: list[EpisodeEnding] = []
        walked: list[int] = []
        known = Counter[tuple[Person, str]]()
        for entry in sorted(entries, key=lambda entry: entry.run.created_at):
            for ending in self._journal.endings(entry.run.run_id):
                person, section = _person(entry), split.episodes[ending.episode_id].section
                times = known[person, section]
                known[person, section] += ending.steps > 0
                if ending.episode_id not in voided:
                    people.append(person)
                    endings.append(ending)
                    walked.append(times)
        values = np.array([[np.mean([turn[name] for turn in one.scores]) for name in COLUMNS] for one in endings])
        names, numbers = np.unique(people, return_inverse=True)
        _, sections = np.unique([split.episodes[one.episode_id].section for one in endings], return_inverse=True)
        times_walked = np.array(walked)
        means = np.stack([values[numbers == number].mean(axis=0) for number in range(len(names))])
        return PeopleGroup(
            arguments,
            len(names),
            len(endings),
            means.mean(axis=0),
            section_bounds(values, numbers),
            mean_bounds(episode_moments(values, sections)),
            tuple(
                WalkedBefore(int(times), int((times_walked == times).sum()), values[times_walked == times].mean(axis=0))
                for times in np.unique(times_walked)
            ),
            tuple(entries),
        )


def _person(entry: Entry) -> Person:
    run = entry.run
    return run.account or (run.participant if run.participant != ANONYMOUS_NAME else run.run_id)
