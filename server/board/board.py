"""The leaderboard: standings of the published runs, by split and language."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Generic, TypeVar

import numpy as np

from arramon_server.board.comparisons import ComparisonCache, ComparisonFamily, PairComparison, ScoreVersions
from arramon_server.board.entries import Entries, PublishedRun, StoredScores
from arramon_server.board.episode_table import EpisodeTable, join_languages, language_gap_of, mean_table
from arramon_server.board.ranking import ranked
from arramon_server.board.reference import read_references
from arramon_server.board.reproductions import Reproduction, masked_score_differences, score_differences
from arramon_server.board.standing_groups import by_language, group_by_seed, group_by_system, versions_of_entries
from arramon_server.board.standings import (
    BOTH,
    COLUMNS,
    HEADLINE,
    OUTCOME_MARKS,
    PRIVILEGED,
    TOTAL,
    Entry,
    Mark,
    PaperResult,
    Rows,
    ScoresVersion,
    Standing,
)
from arramon_server.closing_times import NEVER_CLOSES, ClosingTimes
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, Conflict, NotFound, quoted
from arramon_server.runs.accounts.attempts import Attempts, ParticipantKey, participant_key
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.results.reports import coarse_progress
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.corrections import Correction, voided_by
from arramon_server.runs.storage.records import Run, RunProgress
from arramon_server.scoring.aggregate import MIN_SECTION, Interval, table_rows
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.scoring.language_gap import LanguageGap
from arramon_server.scoring.masking import (
    Noise,
    masked_rows,
    masked_share,
    mean_of_rows,
    shown_deviation,
    shown_difference,
)
from arramon_server.scoring.seed_spread import SeedSpread, masked_spread, seed_spread
from arramon_server.scoring.signature import without_episodes
from arramon_server.visible_text import shown


@dataclass(frozen=True, eq=False)
class StandingsListing:
    """Standings of a split in one language, or in all languages combined. Cached until a run or an entry changes.

    Attributes:
        split: name of the split.
        language: code of the language, or BOTH.
        sort: metric by which the standings are sorted and ranked.
        standings: standings in order of rank.
        references: results of the paper for comparison, measured on other data.
        family: paired tests of all ranked standings; the episode scores in it never leave the server.
        corrections: the host's corrections of the split, in order.
        frozen: whether scores and ranks are withheld, see `Board.listing`.
    """

    split: str
    language: str
    sort: str
    standings: tuple[Standing, ...]
    references: tuple[PaperResult, ...]
    family: ComparisonFamily | None = None
    corrections: tuple[Correction, ...] = ()
    frozen: bool = False


@dataclass(frozen=True, slots=True)
class RunComparisons:
    """Paired comparisons of one ranked standing with all other ranked standings of its listing.

    Attributes:
        listing: the listing.
        standing: the standing that the others are compared with.
        lines: the other standings in order of rank, each with the comparison of `standing` with it.
    """

    listing: StandingsListing
    standing: Standing
    lines: tuple[tuple[Standing, PairComparison], ...]


class Board:
    """The standings of all splits. Thread-safe; listings are cached until an entry changes or a run begins.

    Args:
        entries: published runs.
        splits: served splits, by name.
        steps_per_phase, clocks: limits of new runs on this server; entries with other limits are marked.
        closing: when the leaderboards of splits close, and whether they are frozen until then.
        local: whether only this machine can reach the server. Its runs may have been played with different limits, so
            on each split the limits that most runs share replace the server's.
    """

    def __init__(
        self,
        entries: Entries,
        splits: Mapping[str, Split],
        *,
        steps_per_phase: int,
        clocks: ClockSettings,
        local: bool = False,
        closing: ClosingTimes = NEVER_CLOSES,
    ) -> None:
        self._entries = entries
        self._splits = splits
        self._episodes = {name: split.languages for name, split in splits.items()}
        self._limits, self._local = (steps_per_phase, clocks), local
        self.closing = closing
        self._common_limits = _StampedCache[str, tuple[int, ClockSettings]](entries.stamp, self._find_limits)
        self._attempts = _StampedCache[str, Mapping[tuple[ParticipantKey, str], Attempts]](
            entries.stamp, entries.attempts
        )
        self._reproducers = _StampedCache[str, Mapping[str, frozenset[str]]](entries.stamp, entries.reproducers)
        self._references = read_references()
        self._corrections = _StampedCache[str, tuple[Correction, ...]](entries.stamp, self._find_corrections)
        self._comparisons = ComparisonCache(self._table, self._noise)
        self._masked = lru_cache(_CACHE_SIZE)(self._mask)
        self._joined_rows = lru_cache(_CACHE_SIZE)(self._join_rows)
        self._gaps = lru_cache(_CACHE_SIZE)(self._find_gap)
        self._differences = lru_cache(_CACHE_SIZE)(self._find_differences)
        self._spreads = lru_cache(_CACHE_SIZE)(self._find_spread)
        self._listings = _StampedCache[tuple[str, str, str], StandingsListing](
            self._stamp, lambda wanted: self._build_listing(*wanted)
        )

    def _stamp(self) -> object:
        return self._entries.stamp(), tuple(map(self.closing.is_frozen, self.closing.closes.splits))

    def languages(self) -> dict[str, tuple[str, ...]]:
        """Return the languages of each split with a leaderboard, by name: served splits, and splits with older entries.

        Splits for training alone have no leaderboard.
        """
        ranked = {name: languages for name, languages in self._episodes.items() if not self._splits[name].training}
        found = {name: set(languages) for name, languages in ranked.items()}
        for split, language in self._entries.languages():
            found.setdefault(split, set()).add(language)
        return {name: tuple(sorted(found[name])) for name in sorted(found)}

    def listing(self, split: str, language: str, sort: str = HEADLINE) -> StandingsListing:
        """Return the standings of a split in one language, or in all combined (BOTH), and the paper's results.

        Ranked runs of one agent that differ only in the argument SEED form one standing, with the mean over seeds. If
        several have the same seed, the one published last is part of it, and the others are standings of their own.

        BOTH lists systems (same account, participant and agent) that have entries in all languages of the split. Of a
        system's standings in one language, a ranked one is preferred, then the one published last. Scores are means
        over the languages; intervals treat an episode's languages as one observation. If the data has changed, the
        sections are unknown, and the ends of an interval are the means of the languages' ends.

        While the leaderboard is frozen, the standings have no rows and no ranks, and are ordered by publication.

        Args:
            split: name of the split.
            language: code of the language, or BOTH.
            sort: metric to sort and rank by, one of COLUMNS, see `ranking.ranked`.

        Raises:
            NotFound: if there is no such split or language.
            BadInput: if there is no such metric.
        """
        return self._listings[split, language, sort]

    def standings(self, split: str, language: str, sort: str = HEADLINE) -> list[Standing]:
        """Return the standings of `listing` without the references."""
        return list(self.listing(split, language, sort).standings)

    def combined_standings(self, split: str, sort: str = HEADLINE) -> list[Standing]:
        """Return the standings of systems over all languages of a split, see `listing`."""
        return self.standings(split, BOTH, sort)

    def entry(self, run_id: str) -> Entry:
        """Return the entry of a published run, with the fingerprint of its receipt.

        Raises:
            NotFound: if the run is not on the leaderboard.
        """
        published = self._entries.find(run_id)
        if published is None or not published.is_listed:
            raise NotFound(f"there is no run {quoted(run_id)} on the leaderboard")
        corrections: tuple[Correction, ...] = ()
        if self._corrections[published.run.split]:
            corrections = tuple(self._entries.corrections_of(published.run))
        return replace(
            self._entry(published),
            receipt_fingerprint=self._entries.receipt_fingerprint(run_id),
            corrections=corrections,
        )

    def runs_on(self, split: str) -> list[Run]:
        """Return the listed runs of a split, the latest published first; none while its leaderboard is frozen."""
        if self.closing.is_frozen(split):
            return []
        listed = sorted(self._entries.listed(split), key=lambda published: published.published_at, reverse=True)
        return [published.run for published in listed]

    def corrections(self, split: str) -> tuple[Correction, ...]:
        """Return the host's corrections of a split, in order."""
        return self._corrections[split]

    def reproductions(self, run_id: str) -> list[Reproduction]:
        """Return the listed reproductions of a published run, oldest first; none while the leaderboard is frozen."""
        found = self._entries.reproductions(run_id)
        published = self._entries.find(run_id) if found else None
        if published is None or self.closing.is_frozen(published.run.split):
            return []
        original, split = self._entry(published), published.run.split
        return [
            Reproduction(
                again := self._entry(one),
                masked_score_differences(original, again)
                if self._is_masked(one.run)
                else self._differences(split, original.version, again.version),
            )
            for one in found
        ]

    def compare_with_all(self, run_id: str, language: str = "", sort: str = HEADLINE) -> RunComparisons:
        """Compare the standing of a published run with all other ranked standings of a listing.

        Args:
            run_id: id of the run.
            language: the run's language, or BOTH; empty for the run's language.
            sort: metric to compare, one of COLUMNS.

        Raises:
            NotFound: if the run is not on the leaderboard, or not in that listing.
            Conflict: if the run is not ranked, so it did not play the same episodes under the same conditions; or if
                the leaderboard is frozen.
            BadInput: if there is no such metric.
        """
        run = self.entry(run_id).run
        self.closing.check_shown(run.split)
        listing = self.listing(run.split, language or run.language, sort)
        for standing in listing.standings:
            if any(entry.run.run_id == run_id for entry in standing.entries):
                break
        else:
            raise NotFound(f"there is no run {quoted(run_id)} in the standings of {run.split!r} in {language!r}")
        if not standing.is_ranked or listing.family is None:
            raise Conflict(
                f"run {run_id!r} is not ranked ({', '.join(standing.marks)}), so it is compared with no other run"
            )
        others = [other for other in listing.standings if other.is_ranked and other is not standing]
        family = listing.family
        return RunComparisons(listing, standing, tuple((other, family.compare(standing, other)) for other in others))

    def has_entries(self, split: str, language: str) -> bool:
        """Return whether any run is listed on a split in a language."""
        return (split, language) in self._entries.languages()

    def reference(self, split: str, language: str = "en") -> tuple[PaperResult, ...]:
        """Return the paper's results for a split and a language; the paper has results for English only."""
        return tuple(line for line in self._references if (line.split, line.language) == (split, language))

    def _build_listing(self, split: str, language: str, sort: str) -> StandingsListing:
        known = self.languages()
        if split not in known:
            raise NotFound(f"there is no split {quoted(split)}; the leaderboard has {', '.join(known) or 'none'}")
        if language not in (*known[split], BOTH):
            has = ", ".join((*known[split], BOTH))
            raise NotFound(f"split {split!r} has no language {quoted(language)}; it has {has}")
        if sort not in COLUMNS:
            raise BadInput(f"cannot sort by {quoted(sort)}; expected one of {', '.join(COLUMNS)}")
        entries = [
            self._entry(published) for published in self._entries.listed(split, None if language == BOTH else language)
        ]
        lines = list(group_by_seed(entries))
        if language == BOTH:
            lines = list(group_by_system(lines, known[split]))
        if self.closing.is_frozen(split):
            ordered = sorted(lines, key=lambda line: (max(one.published_at for one in line), line[0].run.run_id))
            unknown = tuple(Standing(line, {}) for line in ordered)
            references = self.reference(split, language)
            return StandingsListing(
                split, language, sort, unknown, references, None, self.corrections(split), frozen=True
            )
        standings = [
            Standing(line, self._rows_of(line), self._gap_of(line, sort), self._spread_of(line, sort)) for line in lines
        ]
        comparable = [standing for standing in standings if standing.is_ranked]
        family = self._comparisons.family(comparable, sort, self._sections(split))
        order = tuple(ranked(standings, sort, family))
        return StandingsListing(
            split, language, sort, order, self.reference(split, language), family, self.corrections(split)
        )

    def _limits_on(self, split: str) -> tuple[int, ClockSettings]:
        """Return the step limit and the clocks under which runs of a split are ranked."""
        return self._common_limits[split] if self._local else self._limits

    def _find_limits(self, split: str) -> tuple[int, ClockSettings]:
        """Return the step limit and clocks that most listed runs of a split share; in a tie the latest run's."""
        listed = sorted(self._entries.listed(split), key=lambda published: published.published_at, reverse=True)
        counts = Counter((one.run.steps_per_phase, ClockSettings.of(one.run)) for one in listed)
        return counts.most_common(1)[0][0] if counts else self._limits

    def _rows_of(self, entries: tuple[Entry, ...]) -> Rows:
        """Return the mean scores of several runs."""
        if len(entries) == 1:
            return entries[0].rows
        if any(self._is_masked(entry.run) for entry in entries):
            return mean_of_rows([entry.rows for entry in entries], _min_counted(entries))
        if any(Mark.OTHER_DATA in entry.marks for entry in entries):
            return _mean_rows(entries)
        return self._joined_rows(entries[0].run.split, versions_of_entries(entries))

    def _gap_of(self, entries: tuple[Entry, ...], metric: str) -> LanguageGap | None:
        """Return the gap between a system's languages."""
        languages = tuple(dict.fromkeys(entry.run.language for entry in entries))
        if len(languages) < 2 or any(Mark.OTHER_DATA in entry.marks for entry in entries):
            return None
        found = self._gaps(entries[0].run.split, versions_of_entries(entries), languages, metric)
        if found is None or not self._is_masked(entries[0].run):
            return found
        return self._masked_gap(entries, found, metric)

    def _masked_gap(self, entries: tuple[Entry, ...], exact: LanguageGap, metric: str) -> LanguageGap:
        """Return the gap between a system's languages on a hidden split, from the shown means."""
        lines = {same[0].run.language: same for same in map(tuple, by_language(entries))}
        means = {code: self._rows_of(same)[TOTAL][metric].mean for code, same in lines.items()}
        lower, *_, higher = sorted(means, key=lambda code: (means[code], [*means][::-1].index(code)))
        noise = math.sqrt(2.0) * shown_deviation(exact.episodes)
        gap = shown_difference(means[higher], means[lower], exact.episodes, noise)
        names = [
            "same outcome",
            *(self._entries.counted_episode_scores(entry.run.run_id).play_digest for entry in entries),
        ]
        noise_of_split = self._noise(entries[0].run.split)
        assert noise_of_split is not None  # the data has not changed, see `_gap_of`
        same = masked_share(exact.same, exact.episodes, noise_of_split, names)
        return LanguageGap(higher, lower, gap.mean, gap.low, gap.high, same, exact.episodes)

    def _spread_of(self, entries: tuple[Entry, ...], metric: str) -> SeedSpread | None:
        """Return the spread between seeds; None if the languages have different seeds."""
        versions_by_seed = [{entry.seed: entry.version for entry in same} for same in by_language(entries)]
        if len(versions_by_seed[0]) < 2 or any(set(one) != set(versions_by_seed[0]) for one in versions_by_seed):
            return None
        if self._is_masked(entries[0].run):
            if _min_counted(entries) < MIN_SECTION:
                return None
            seeds = [
                [{entry.seed: entry for entry in same}[seed] for same in by_language(entries)]
                for seed in versions_by_seed[0]
            ]
            return masked_spread([sum(one.rows[TOTAL][metric].mean for one in same) / len(same) for same in seeds])
        return self._spreads(
            entries[0].run.split,
            tuple(tuple(one[seed] for one in versions_by_seed) for seed in versions_by_seed[0]),
            metric,
        )

    def _find_spread(self, split: str, versions: ScoreVersions, metric: str) -> SeedSpread | None:
        sections, column = self._sections(split), METRICS.index(metric)
        runs = [join_languages([self._table(version) for version in same], sections).values for same in versions]
        scores = np.stack([values[:, -1, column] for values in runs])
        return None if scores.shape[1] < 2 else seed_spread(scores)

    def _find_gap(
        self, split: str, versions: ScoreVersions, languages: tuple[str, ...], metric: str
    ) -> LanguageGap | None:
        tables = self._tables(versions)
        found = language_gap_of(tables, languages, self._sections(split), metric)
        few = found is not None and found.episodes < MIN_SECTION
        return None if few and self._splits[split].hidden else found  # a few episodes would reveal single scores

    def _find_differences(self, split: str, original: ScoresVersion, version: ScoresVersion) -> dict[str, Interval]:
        return score_differences(self._table(original), self._table(version), self._sections(split))

    def _find_corrections(self, split: str) -> tuple[Correction, ...]:
        return tuple(self._entries.corrections.on(split))

    def _table(self, version: ScoresVersion) -> EpisodeTable:
        return self._entries.counted_episode_scores(version.run_id)

    def _tables(self, versions: ScoreVersions) -> list[EpisodeTable]:
        """Return the scores in each language, as means over the seeds."""
        return [mean_table([self._table(version) for version in same]) for same in versions]

    def _join_rows(self, split: str, versions: ScoreVersions) -> Rows:
        joined = join_languages(self._tables(versions), self._sections(split))
        return table_rows(joined.values, joined.strata, are_sections=joined.are_sections)

    def _sections(self, split: str) -> dict[str, str]:
        """Return the section of every episode of a split; empty if it is not served, as then no run on it is ranked."""
        found = self._splits.get(split)
        return {name: episode.section for name, episode in found.episodes.items()} if found else {}

    def _noise(self, split: str) -> Noise | None:
        """Return the noise of a hidden split; None if it is open or not served."""
        found = self._splits.get(split)
        return Noise(found.truth_hash) if found is not None and found.hidden else None

    def _is_masked(self, run: Run) -> bool:
        """Return whether a run's scores are shown rounded, because it was played on a hidden split."""
        split = self._splits.get(run.split)
        if split is not None and split.data_hash == run.data_hash:
            return split.hidden
        return self._entries.was_hidden(run.run_id)

    def _mask(self, split: str, version: ScoresVersion, voided: frozenset[str]) -> Rows:
        """Return the masked rows of a run on a hidden split; the stored ones may be an earlier release's exact ones."""
        noise = self._noise(split)
        assert noise is not None
        table = self._entries.all_episode_scores(version.run_id).without(voided)
        return masked_rows(table.scores, noise, table.play_digest)

    def _shown_scores(
        self, run: Run, version: ScoresVersion, scores: StoredScores, voided: frozenset[str], *, current: bool
    ) -> StoredScores:
        """Return the scores of a run as everybody but its participant sees them.

        Args:
            run: the run.
            version: version of its scores.
            scores: its stored scores, over all its episodes.
            voided: its void episodes, which are left out of the shown scores.
            current: whether the data of its split is unchanged since the run.
        """
        rows, signature = scores.rows, scores.signature
        if voided:
            signature = without_episodes(signature, voided)
        if self._is_masked(run):
            progress = coarse_progress(scores.progress)
            if current:
                rows = self._masked(run.split, version, voided)
            else:
                rows = self._entries.masked_rows_without_truth(run.run_id, version.rescored)
            return StoredScores(progress, rows, signature)
        if voided:
            rows = self._joined_rows(run.split, ((version,),))
        return StoredScores(scores.progress, rows, signature)

    def _entry(self, published: PublishedRun) -> Entry:
        run, scores = published.run, self._entries.scores(published.run.run_id, published.rescored)
        split = self._splits.get(run.split)
        current = split is not None and split.data_hash == run.data_hash
        corrections = self._corrections[run.split]
        version = ScoresVersion(run.run_id, len(corrections), published.rescored)
        voided, left_out = self._entries.void_and_left_out(
            run.run_id, voided_by(corrections) if current else frozenset()
        )
        scores = self._shown_scores(run, version, scores, left_out, current=current)
        forfeited = scores.progress.causes.get(causes.FORFEITED, 0)
        all_ = self._episodes[run.split].get(run.language, 0) if current else 0
        coverage = scores.progress.episodes / all_ if all_ else None
        steps_per_phase, clocks = self._limits_on(run.split)
        found = {
            Mark.PARTIAL: coverage is not None and coverage < 1.0,
            Mark.PRIVILEGED: bool(PRIVILEGED.intersection(run.sensors)),
            Mark.OTHER_DATA: not current,
            Mark.OTHER_LIMITS: run.steps_per_phase != steps_per_phase,
            Mark.OTHER_CLOCKS: ClockSettings.of(run) != clocks,
            Mark.REPRODUCTION: published.reproduces is not None,
            Mark.FORFEITED: 2 * forfeited > scores.progress.episodes and self._is_masked(run),
            Mark.SERVER_FAULT: scores.progress.causes.get(causes.SERVER_FAULT, 0) > 0,
        }
        frozen = self.closing.is_frozen(run.split)
        marks = tuple(mark for mark in Mark if found[mark] and not (frozen and mark in OUTCOME_MARKS))
        if frozen:
            episodes = scores.progress.episodes
            progress = RunProgress(episodes, episodes, 0, {}, scores.progress.images, published=True)
            scores = StoredScores(progress, {}, scores.signature)
        return Entry(
            run,
            scores.progress,
            scores.rows,
            scores.signature,
            published.published_at,
            shown(published.note),
            coverage,
            marks,
            attempts=self._attempts[run.split].get((participant_key(run), run.language), Attempts()),
            cost=published.cost,
            reproduces=published.reproduces,
            reproducers=self._reproducers[run.split].get(run.run_id, frozenset()),
            split_corrections=len(corrections),
            rescored=published.rescored,
            voided=len(voided),
            frozen=frozen,
        )


K = TypeVar("K")
V = TypeVar("V")


class _StampedCache(Generic[K, V]):
    """Cache of lazily computed values, cleared when a stamp changes.

    Args:
        stamp: returns the current version of the data that the values depend on.
        make: computes the value of a key.
    """

    def __init__(self, stamp: Callable[[], object], make: Callable[[K], V]) -> None:
        self._stamp, self._make = stamp, make
        self._kept: tuple[object, dict[K, V]] = (None, {})

    def __getitem__(self, key: K) -> V:
        """Return the value of a key."""
        stamp = self._stamp()
        if self._kept[0] != stamp:
            self._kept = (stamp, {})
        kept = self._kept[1]
        if key not in kept:
            kept[key] = self._make(key)
        return kept[key]


_CACHE_SIZE = 2048
"""Maximum number of systems whose combined scores are cached, about 10 KB each."""


def _min_counted(entries: Sequence[Entry]) -> int:
    """Return the number of episodes in each run's scores; the minimum if the runs differ."""
    return min(entry.counted for entry in entries)


def _mean_rows(entries: Sequence[Entry]) -> Rows:
    tables = [entry.rows for entry in entries]

    def mean(row: str, metric: str) -> Interval:
        found = [table[row][metric] for table in tables]
        return Interval(*(sum(getattr(one, end) for one in found) / len(found) for end in ("mean", "low", "high")))

    return {row: {metric: mean(row, metric) for metric in tables[0][row]} for row in tables[0]}
