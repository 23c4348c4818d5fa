"""The nouns of the leaderboard: a published run, its standing beside others, a line of the paper, and the columns."""

import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from server.runs.records import Progress, Run
from server.scoring.aggregate import Interval

Rows = Mapping[str, Mapping[str, Interval]]
"""Row name of `server.scoring.aggregate.ROWS` -> metric of `server.scoring.episode.METRICS` -> value."""

COLUMNS = {
    "nDTW": "nDTW",
    "CTC-0": "CTC k=0",
    "CTC-3": "CTC k=3",
    "CTC-5": "CTC k=5",
    "CTC-7": "CTC k=7",
    "rPOD@CTC-3": "rPOD",
    "PTC@CTC-3": "PTC",
}
"""Metric -> heading, in the order of the paper's tables, whose placement scores count where CTC-3 is 1."""

TOTAL = "total"
"""The row by which standings are sorted and ranked: the mean of both turns."""

HEADLINE = "PTC@CTC-3"
"""The metric that ranks unless another is asked for: whether, in the end, the right object lies in the right place."""

BOTH = "both"
"""In place of a language: all languages of the split together."""

PRIVILEGED = frozenset({"pose", "oracle"})
"""Sensors that tell what no camera shows."""


class Mark(StrEnum):
    """What a reader must know of an entry beside its scores."""

    PARTIAL = "partial"
    """It played fewer episodes than the split has in its language."""
    PRIVILEGED = "privileged"
    """It was given a sensor of PRIVILEGED."""
    OTHER_DATA = "other-data"
    """The split's data is not what it was when the run was played, or is gone."""
    OTHER_LIMITS = "other-limits"
    """It was played under another step limit than this server's."""
    OTHER_CLOCKS = "other-clocks"
    """It was played under other clocks than this server's, or one of the two has none."""
    SERVER_FAULT = "server-fault"
    """Some of its episodes ended by the server's fault and count as not played: its scores are rather too low."""


UNRANKED = frozenset(Mark) - {Mark.SERVER_FAULT}
"""Marks with which an entry is listed, but not ranked: it cannot be compared with the others."""


@dataclass(frozen=True, slots=True)
class Seal:
    """By which the receipt of a run can be told.

    Attributes:
        digest: SHA-256 of the receipt's payload, 32 bytes.
        public_key: the host's Ed25519 key that signed it, 32 bytes.
    """

    digest: bytes
    public_key: bytes


@dataclass(frozen=True, slots=True)
class Entry:
    """A run that its owner, or the host, has published. Nothing in it is of a single episode.

    Attributes:
        run: as the journal has it; show `participant` and `agent` of the entry instead of the run's.
        progress: its episodes, steps, causes and forms of images, as they were when it ended.
        rows: its scores, with 95% intervals.
        signature: what they were reached under, in one line.
        published_at: in UTC.
        note: the publisher's own words, at most 500 characters; may be empty.
        coverage: share of the split's episodes in its language that the run has, in (0, 1]; None where the split's data
            is not what it was.
        marks: in the order of `Mark`.
        seal: of its receipt; None where there is none, and in lists, which do not look for it.
    """

    run: Run
    progress: Progress
    rows: Rows
    signature: str
    published_at: datetime
    note: str
    coverage: float | None
    marks: tuple[Mark, ...]
    seal: Seal | None = None

    @property
    def participant(self) -> str:
        """Who played, fit to be shown."""
        return shown(self.run.participant)

    @property
    def agent(self) -> str:
        """The agent's name, fit to be shown."""
        return shown(self.run.agent)

    @property
    def sensors(self) -> tuple[str, ...]:
        """What the agent was given."""
        return self.run.sensors

    @property
    def causes(self) -> Mapping[str, int]:
        """How many episodes ended by each cause."""
        return self.progress.causes

    @property
    def is_ranked(self) -> bool:
        """Whether it can be compared with others."""
        return not UNRANKED.intersection(self.marks)

    @property
    def system(self) -> tuple[str | None, str, str]:
        """Whose runs in several languages belong together: the account, the participant's and the agent's name."""
        return self.run.account, self.run.participant, self.run.agent


@dataclass(frozen=True, slots=True)
class Standing:
    """A line of the leaderboard: one entry, or those of one system in all languages together.

    Attributes:
        entries: one; of several languages one each, in the order of their codes.
        rows: the entry's; of several languages the mean of theirs, see `Board.both`.
        rank: from 1; tied standings share theirs. 0 where it is not ranked.
        tied: whether another standing has the same rank.
    """

    entries: tuple[Entry, ...]
    rows: Rows
    rank: int = 0
    tied: bool = False

    @property
    def participant(self) -> str:
        """Who played, fit to be shown."""
        return self.entries[0].participant

    @property
    def agent(self) -> str:
        """The agent's name, fit to be shown."""
        return self.entries[0].agent

    @property
    def languages(self) -> tuple[str, ...]:
        """By their codes, in order."""
        return tuple(entry.run.language for entry in self.entries)

    @property
    def sensors(self) -> tuple[str, ...]:
        """What the agent was given in any of its runs."""
        return tuple(dict.fromkeys(sensor for entry in self.entries for sensor in entry.sensors))

    @property
    def coverage(self) -> float | None:
        """The least of its entries'; None where one has none."""
        known = [entry.coverage for entry in self.entries if entry.coverage is not None]
        return min(known) if len(known) == len(self.entries) else None

    @property
    def marks(self) -> tuple[Mark, ...]:
        """Of any of its entries, in the order of `Mark`."""
        return tuple(mark for mark in Mark if any(mark in entry.marks for entry in self.entries))

    @property
    def causes(self) -> dict[str, int]:
        """How many episodes ended by each cause, over all its entries."""
        counts: dict[str, int] = {}
        for entry in self.entries:
            for cause, number in entry.causes.items():
                counts[cause] = counts.get(cause, 0) + number
        return counts

    @property
    def is_ranked(self) -> bool:
        """Whether all its entries can be compared with others."""
        return all(entry.is_ranked for entry in self.entries)


@dataclass(frozen=True, slots=True)
class Reference:
    """A line of the paper's tables. It was measured in the original simulator, on the original's episodes: other data.

    Attributes:
        name: such as "Vision-and-Language".
        short: as the paper's tables have it, such as "V/L".
        split: such as "val_seen".
        language: of the instructions.
        rows: row name -> metric -> value in [0, 1]; what the paper does not give is left out. Always has "total".
        source: where it stands, such as "Table 2".
        note: what else is to be known, or empty.
    """

    name: str
    short: str
    split: str
    language: str
    rows: Mapping[str, Mapping[str, float]]
    source: str
    note: str = ""


def shown(text: str) -> str:
    """A name as it can be shown anywhere: what would move the cursor or turn the writing round is replaced."""
    return "".join("\ufffd" if is_control(letter) else letter for letter in text)


def is_control(letter: str) -> bool:
    """Whether a character controls its surroundings instead of being seen; joiners, which Hindi needs, do not."""
    return unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp") or letter in _DIRECTIONS


_DIRECTIONS = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
