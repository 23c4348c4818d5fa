"""Data types of the leaderboard: entries, standings, marks, columns, and results of the paper."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from typing import NamedTuple

from arramon_server.board.cost import NO_COST, Cost, mean_cost
from arramon_server.runs.accounts.attempts import NO_ATTEMPTS, Attempts
from arramon_server.runs.results.receipts import SupersededReceipt
from arramon_server.runs.storage.corrections import Correction
from arramon_server.runs.storage.records import Run, RunProgress
from arramon_server.scoring.aggregate import Interval
from arramon_server.scoring.language_gap import LanguageGap
from arramon_server.scoring.seed_spread import SeedSpread
from arramon_server.visible_text import shown

Rows = Mapping[str, Mapping[str, Interval]]
"""Row name of `arramon_server.scoring.aggregate.ROWS` -> metric of `scoring.episode_scores.METRICS` -> value."""

COLUMNS = {
    "nDTW": "nDTW",
    "CTC-0": "CTC k=0",
    "CTC-3": "CTC k=3",
    "CTC-5": "CTC k=5",
    "CTC-7": "CTC k=7",
    "rPOD@CTC-3": "rPOD",
    "PTC@CTC-3": "PTC",
}
"""Metric -> heading, in the order of the paper's tables. Placement scores are gated by CTC-3, as in the paper."""

TOTAL = "total"
"""Row by which standings are sorted and ranked: the mean of both turns."""

HEADLINE = "PTC@CTC-3"
"""Default metric for ranking: whether the right object ends in the right place."""

BOTH = "both"
"""Used in place of a language code for all languages of a split combined."""

SEED = "seed"
"""Agent argument for the random seed: runs of one agent that differ only in it form one standing."""

PRIVILEGED = frozenset({"pose", "oracle"})
"""Sensors that give information which no camera shows."""


class Mark(StrEnum):
    """Caveat that is shown beside an entry's scores."""

    PARTIAL = "partial"
    """It played fewer episodes than the split has in its language."""
    PRIVILEGED = "privileged"
    """It used a sensor of PRIVILEGED."""
    OTHER_DATA = "other-data"
    """The data of the split has changed since the run was played, or the split is gone."""
    OTHER_LIMITS = "other-limits"
    """Its step limit differs from that of ranked runs, see `Board`."""
    OTHER_CLOCKS = "other-clocks"
    """Its clocks differ from those of ranked runs, see `Board`. Having no clocks counts as different."""
    REPRODUCTION = "reproduction"
    """It reproduces another account's run, and is compared only with that run."""
    FORFEITED = "forfeited"
    """On a hidden split, more than half of its episodes were forfeited: scores would reveal single episodes'."""
    SERVER_FAULT = "server-fault"
    """Some of its episodes ended by SERVER_FAULT and count as not played, so its scores may be too low."""


UNRANKED_MARKS = frozenset(Mark) - {Mark.SERVER_FAULT}
"""Marks of entries that are listed but not ranked, because they cannot be compared with the others."""


OUTCOME_MARKS = frozenset({Mark.FORFEITED, Mark.SERVER_FAULT})
"""Marks that reveal how episodes ended; they are left out while a leaderboard is frozen."""


class ScoresVersion(NamedTuple):
    """Version of a run's scores, which changes with corrections of its split; equal versions have equal scores.

    Attributes:
        run_id: id of the run.
        corrections: number of corrections of the split.
        rescored: number of times that the run was rescored.
    """

    run_id: str
    corrections: int = 0
    rescored: int = 0


@dataclass(frozen=True, slots=True)
class ReceiptFingerprint:
    """Fingerprint of a run's receipt.

    Attributes:
        digest: SHA-256 of the receipt's payload, 32 bytes.
        public_key: Ed25519 key of the host that signed it, 32 bytes.
        superseded: earlier receipts of the run, in order.
    """

    digest: bytes
    public_key: bytes
    superseded: tuple[SupersededReceipt, ...] = ()


@dataclass(frozen=True, slots=True)
class Entry:
    """A published run with its scores, without scores of single episodes.

    Attributes:
        run: the run in the journal; display the entry's `participant` and `agent` instead of the run's.
        progress: counts of episodes, steps and causes, and encodings of images, at the end of the run.
        rows: scores with 95% intervals.
        signature: settings under which the scores were reached, in one line.
        published_at: time of the publication, in UTC.
        note: note of the publisher, at most 500 characters; may be empty.
        coverage: fraction of the split's episodes in the language that the run has, in (0, 1]; None if the data of the
            split has changed.
        marks: caveats, in the order of `Mark`.
        receipt_fingerprint: fingerprint of the receipt; None without a receipt, and in listings.
        attempts: numbers of runs that its participant began and published on the split in the language, with any agent.
        cost: declared cost.
        reproduces: id of the run that it reproduces; None if none.
        reproducers: accounts with a listed reproduction of it; only their number is shown.
        split_corrections: number of corrections of its split.
        rescored: number of times that it was rescored.
        voided: number of its episodes that the host has voided; no score includes them.
        corrections: corrections of the split that change its scores, in order; empty in listings.
        frozen: whether the leaderboard of its split is frozen: then `rows` is empty, and `progress` has only the number
            of episodes.
    """

    run: Run
    progress: RunProgress
    rows: Rows
    signature: str
    published_at: datetime
    note: str
    coverage: float | None
    marks: tuple[Mark, ...]
    receipt_fingerprint: ReceiptFingerprint | None = None
    attempts: Attempts = NO_ATTEMPTS
    cost: Cost = NO_COST
    reproduces: str | None = None
    reproducers: frozenset[str] = frozenset()
    split_corrections: int = 0
    rescored: int = 0
    voided: int = 0
    corrections: tuple[Correction, ...] = ()
    frozen: bool = False

    @property
    def version(self) -> ScoresVersion:
        """Version of its scores."""
        return ScoresVersion(self.run.run_id, self.split_corrections, self.rescored)

    @property
    def counted(self) -> int:
        """Number of episodes in its scores, see `Entries.void_and_left_out`: those not void, or all if all are void."""
        return self.progress.episodes - self.voided or self.progress.episodes

    @property
    def participant(self) -> str:
        """Displayed name of the participant."""
        return shown(self.run.participant)

    @property
    def seed(self) -> str | None:
        """Value of the agent argument SEED; None if the run has none."""
        return dict(self.run.agent_arguments).get(SEED)

    @property
    def key_without_seed(self) -> tuple[object, ...]:
        """Key that is equal for runs of one agent that differ only in their seed."""
        arguments = tuple(pair for pair in self.run.agent_arguments if pair[0] != SEED)
        return (*self.system, self.run.language, self.run.sensors, arguments)

    @property
    def agent(self) -> str:
        """Displayed name of the agent."""
        return shown(self.run.agent)

    @property
    def sensors(self) -> tuple[str, ...]:
        """Sensors that the agent received."""
        return self.run.sensors

    @property
    def causes(self) -> Mapping[str, int]:
        """Number of episodes that ended by each cause."""
        return self.progress.causes

    @property
    def is_ranked(self) -> bool:
        """Whether the entry can be compared with others, and so has a rank."""
        return not UNRANKED_MARKS.intersection(self.marks)

    @property
    def system(self) -> tuple[str | None, str, str]:
        """Account, participant and agent; entries of one system in several languages form one standing."""
        return self.run.account, self.run.participant, self.run.agent


@dataclass(frozen=True, slots=True)
class Standing:
    """A line of the leaderboard: an agent's runs with one or several seeds, in one language or in all of them.

    Attributes:
        entries: its runs, ordered by language code and seed.
        rows: scores of the run, or means over seeds and languages, see `Board.listing`.
        gap: gap between the languages in the ranking metric; None with one language, or if the data has changed.
        spread: spread between seeds in the ranking metric; None with one seed, or if the languages' seeds differ.
        rank: rank from 1, one more than the number of significantly better standings; 0 if not ranked.
        last_rank: worst rank that is consistent with the significant differences; 0 if not ranked.
        tied: whether another standing has the same rank.
    """

    entries: tuple[Entry, ...]
    rows: Rows
    gap: LanguageGap | None = None
    spread: SeedSpread | None = None
    rank: int = 0
    last_rank: int = 0
    tied: bool = False

    @property
    def participant(self) -> str:
        """Displayed name of the participant."""
        return self.entries[0].participant

    @property
    def agent(self) -> str:
        """Displayed name of the agent."""
        return self.entries[0].agent

    @property
    def languages(self) -> tuple[str, ...]:
        """Codes of the languages, in order."""
        return tuple(dict.fromkeys(entry.run.language for entry in self.entries))

    @property
    def by_language(self) -> tuple[tuple[Entry, ...], ...]:
        """Entries, grouped by language."""
        return tuple(tuple(one for one in self.entries if one.run.language == code) for code in self.languages)

    @property
    def seeds(self) -> int:
        """Number of runs with different seeds in each language; the minimum if the languages differ."""
        return min(len(entries) for entries in self.by_language)

    @property
    def seconds_a_step(self) -> float | None:
        """Mean response time of the agent over the steps of all runs; None if none was measured."""
        steps = sum(entry.progress.timed_steps for entry in self.entries)
        return sum(entry.progress.thinking_seconds for entry in self.entries) / steps if steps else None

    @property
    def cost(self) -> Cost:
        """Declared cost of a run: the mean over the runs that declare one."""
        return mean_cost([entry.cost for entry in self.entries])

    @property
    def sensors(self) -> tuple[str, ...]:
        """Sensors that the agent received in any of the runs."""
        return tuple(dict.fromkeys(sensor for entry in self.entries for sensor in entry.sensors))

    @property
    def coverage(self) -> float | None:
        """Lowest coverage of the entries; None if any entry has none."""
        known = [entry.coverage for entry in self.entries if entry.coverage is not None]
        return min(known) if len(known) == len(self.entries) else None

    @property
    def marks(self) -> tuple[Mark, ...]:
        """Marks that any of the entries has, in the order of `Mark`."""
        return tuple(mark for mark in Mark if any(mark in entry.marks for entry in self.entries))

    @property
    def attempts(self) -> Attempts:
        """Numbers of runs that the participant began and published on the split in these languages."""
        return sum((entries[0].attempts for entries in self.by_language), NO_ATTEMPTS)

    @property
    def reproduced_by(self) -> int:
        """Number of other accounts that reproduced a run in every one of the languages, with any seed."""
        by_language = (frozenset[str]().union(*(one.reproducers for one in entries)) for entries in self.by_language)
        return len(frozenset.intersection(*by_language))

    @property
    def causes(self) -> dict[str, int]:
        """Number of episodes that ended by each cause, over all entries."""
        counts: dict[str, int] = {}
        for entry in self.entries:
            for cause, number in entry.causes.items():
                counts[cause] = counts.get(cause, 0) + number
        return counts

    @property
    def is_ranked(self) -> bool:
        """Whether all entries can be compared with others."""
        return all(entry.is_ranked for entry in self.entries)


@dataclass(frozen=True, slots=True)
class PaperResult:
    """A line of the paper's tables, measured in the original simulator on the original episodes.

    Attributes:
        name: name of the model, such as "Vision-and-Language".
        short: abbreviation in the paper's tables, such as "V/L".
        split: name of the split, such as "val_seen".
        language: language of the instructions.
        rows: row name -> metric -> value in [0, 1], without values that the paper does not report. Always has "total".
        source: place in the paper, such as "Table 2".
        note: remark; may be empty.
    """

    name: str
    short: str
    split: str
    language: str
    rows: Mapping[str, Mapping[str, float]]
    source: str
    note: str = ""
