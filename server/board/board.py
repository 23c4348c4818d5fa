"""The leaderboard: how the published runs of a split stand."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from server.board.entries import Entries, Published
from server.board.ranking import ranked
from server.board.reference import read_references
from server.board.standings import BOTH, COLUMNS, HEADLINE, PRIVILEGED, Entry, Mark, Reference, Rows, Standing
from server.episodes.splits import Split
from server.errors import BadInput, NotFound
from server.runs import causes
from server.scoring.aggregate import Interval


@dataclass(frozen=True, slots=True)
class Listing:
    """A whole list of the leaderboard.

    Attributes:
        split: by name.
        language: by code, or BOTH.
        sort: the metric by which it is sorted and ranked.
        standings: in order.
        references: the paper's lines beside it, which are of other data.
    """

    split: str
    language: str
    sort: str
    standings: tuple[Standing, ...]
    references: tuple[Reference, ...]


class Board:
    """All standings. Safe to use from several threads; reads the database with every call, a run's scores once.

    Args:
        entries: what is published.
        splits: what is served, by name.
        steps_per_phase: this server's step limit; runs under another are marked.
    """

    def __init__(self, entries: Entries, splits: Mapping[str, Split], *, steps_per_phase: int) -> None:
        self._entries = entries
        self._splits = splits
        self._steps_per_phase = steps_per_phase
        self._references = read_references()

    def languages(self) -> dict[str, tuple[str, ...]]:
        """The splits that can be listed, by name, and the languages of each: those served, and those of old entries."""
        found = {name: set(split.languages) for name, split in self._splits.items()}
        for split, language in self._entries.languages():
            found.setdefault(split, set()).add(language)
        return {name: tuple(sorted(found[name])) for name in sorted(found)}

    def listing(self, split: str, language: str, sort: str = HEADLINE) -> Listing:
        """The standings of a split in a language, or BOTH, and the paper's lines beside them.

        Raises:
            NotFound, BadInput: as `standings`.
        """
        standings = self.standings(split, language, sort)
        return Listing(split, language, sort, tuple(standings), self.reference(split, language))

    def standings(self, split: str, language: str, sort: str = HEADLINE) -> list[Standing]:
        """The standings of a split in a language, or, for BOTH, of `both`.

        Args:
            split: by name.
            language: by code, or BOTH.
            sort: one of COLUMNS; the ranks are by it, see `ranking.ranked`.

        Raises:
            NotFound: for a split or language that there is not.
            BadInput: for a metric that there is not.
        """
        if language == BOTH:
            return self.both(split, sort)
        self._check(split, language, sort)
        entries = [self._entry(published) for published in self._entries.listed(split, language)]
        return ranked([Standing((entry,), entry.rows) for entry in entries], sort)

    def both(self, split: str, sort: str = HEADLINE) -> list[Standing]:
        """The standings of systems (same account, participant and agent) that are listed in all languages of a split.

        Of several entries of a system in one language, the one counts that would be ranked, and of those the one that
        was published last. A score is the mean over the languages; so are the ends of its interval, which is exact
        where a resample moves all languages alike, and otherwise too wide, never too narrow.

        Raises:
            NotFound, BadInput: as `standings`.
        """
        self._check(split, None, sort)
        languages = self.languages()[split]
        systems: dict[object, dict[str, Entry]] = {}
        for published in self._entries.listed(split):
            entry = self._entry(published)
            of_system = systems.setdefault(entry.system, {})
            other = of_system.get(entry.run.language)
            if other is None or _preference(entry) > _preference(other):
                of_system[entry.run.language] = entry
        whole = [tuple(found[name] for name in languages) for found in systems.values() if len(found) == len(languages)]
        return ranked([Standing(entries, _mean(entries)) for entries in whole], sort)

    def entry(self, run_id: str) -> Entry:
        """One published run, with the seal of its receipt.

        Raises:
            NotFound: if there is none of that id.
        """
        published = self._entries.find(run_id)
        if published is None or published.withdrawn_at is not None:
            raise NotFound(f"there is no run {run_id!r} on the leaderboard")
        return replace(self._entry(published), seal=self._entries.seal(run_id))

    def reference(self, split: str, language: str = "en") -> tuple[Reference, ...]:
        """The paper's lines for a split; it has them for English alone."""
        return tuple(line for line in self._references if (line.split, line.language) == (split, language))

    def _check(self, split: str, language: str | None, sort: str) -> None:
        known = self.languages()
        if split not in known:
            raise NotFound(f"there is no split {split!r}; the leaderboard has {', '.join(known) or 'none'}")
        if language is not None and language not in known[split]:
            raise NotFound(f"split {split!r} has no language {language!r}; it has {', '.join((*known[split], BOTH))}")
        if sort not in COLUMNS:
            raise BadInput(f"cannot sort by {sort!r}; expected one of {', '.join(COLUMNS)}")

    def _entry(self, published: Published) -> Entry:
        run, scores = published.run, self._entries.scores(published.run.run_id)
        split = self._splits.get(run.split)
        current = split is not None and split.data_hash == run.data_hash
        all_ = split.languages.get(run.language, 0) if split is not None and current else 0
        coverage = scores.progress.episodes / all_ if all_ else None
        found = {
            Mark.PARTIAL: coverage is not None and coverage < 1.0,
            Mark.PRIVILEGED: bool(PRIVILEGED.intersection(run.sensors)),
            Mark.OTHER_DATA: not current,
            Mark.OTHER_LIMITS: run.steps_per_phase != self._steps_per_phase,
            Mark.SERVER_FAULT: scores.progress.causes.get(causes.SERVER_FAULT, 0) > 0,
        }
        marks = tuple(mark for mark in Mark if found[mark])
        return Entry(
            run, scores.progress, scores.rows, scores.signature, published.published_at, published.note, coverage, marks
        )


def _preference(entry: Entry) -> tuple[object, ...]:
    return Standing((entry,), entry.rows).is_ranked, entry.published_at, entry.run.run_id


def _mean(entries: tuple[Entry, ...]) -> Rows:
    tables = [entry.rows for entry in entries]

    def mean(row: str, metric: str) -> Interval:
        found = [table[row][metric] for table in tables]
        return Interval(*(sum(getattr(one, end) for one in found) / len(found) for end in ("mean", "low", "high")))

    return {row: {metric: mean(row, metric) for metric in tables[0][row]} for row in tables[0]}
