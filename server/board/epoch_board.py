"""Epochs of hidden splits, as published: statements, comparisons of agents between two epochs, and actions."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from arramon_server.board.board import Board
from arramon_server.board.entries import Entries
from arramon_server.board.standings import BOTH, COLUMNS, HEADLINE, SEED, TOTAL, Entry, Standing
from arramon_server.episodes.epoch_statement import (
    LIST_FORMAT,
    LIST_VERSION,
    EpochStatement,
    parse_epoch_name,
    read_statement,
)
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, Conflict, NotFound, quoted
from arramon_server.runs.storage.epoch_store import EpochRecord, EpochState, EpochStore
from arramon_server.runs.storage.journal import Journal
from arramon_server.scoring.aggregate import Interval
from arramon_server.scoring.score_changes import EpochScores, score_changes

_TIMES = ("opened_at", "closed_at", "revealed_at")


@dataclass(frozen=True, slots=True)
class Epoch:
    """An epoch of a hidden split.

    Attributes:
        record: state and times of the epoch, and its secret once revealed.
        statement: the statement to which the host committed.
    """

    record: EpochRecord
    statement: EpochStatement

    @property
    def number(self) -> int:
        """Number of the epoch among the epochs of its base split, from 1."""
        found = parse_epoch_name(self.statement.split)
        assert found is not None  # `read_statement` has checked it
        return found[1]

    @property
    def times(self) -> dict[str, str]:
        """Times of opening, closing and revealing by name, in ISO 8601 and UTC; steps not taken yet are missing."""
        times = {name: getattr(self.record, name) for name in _TIMES}
        return {name: time.isoformat(timespec="seconds") for name, time in times.items() if time is not None}

    @property
    def command(self) -> str:
        """Command that regenerates the split; empty until the secret is revealed."""
        return f"{self.statement.command} {self.record.secret}" if self.record.secret else ""


@dataclass(frozen=True, slots=True)
class AgentChange:
    """Change of an agent's score from an older epoch to a newer one.

    Attributes:
        older, newer: the agent's ranked standing on each epoch (one run, or several seeds); the one published last if
            there are several.
        older_mean, newer_mean: means of both turns.
        difference: the newer minus the older mean, with its 95% interval.
        against_others: `difference` minus the mean difference of all other agents; None if there are none.
        same_code: whether the runs on both epochs name the same code.
    """

    older: Standing
    newer: Standing
    older_mean: float
    newer_mean: float
    difference: Interval
    against_others: Interval | None
    same_code: bool


@dataclass(frozen=True, slots=True)
class EpochChanges:
    """Changes of all agents that have ranked runs on both of two epochs.

    Attributes:
        older, newer: names of the epochs' splits.
        agents: changes, the largest drop first.
        mean: mean change over the agents; None if there are none.
    """

    older: str
    newer: str
    agents: tuple[AgentChange, ...]
    mean: Interval | None


class EpochBoard:
    """Epochs of hidden splits and the published runs on them. Thread-safe.

    Args:
        board: the leaderboard.
        entries: published runs.
        epochs: storage of the epochs.
        journal: source of the actions.
        splits: served splits, by name.
    """

    def __init__(
        self, board: Board, entries: Entries, epochs: EpochStore, journal: Journal, splits: Mapping[str, Split]
    ) -> None:
        self._board = board
        self._entries = entries
        self._epochs = epochs
        self._journal = journal
        self._splits = splits

    def all(self) -> list[Epoch]:
        """Return all epochs, grouped by base split, the latest first."""
        found = [epoch_with_statement(record) for record in self._epochs.all()]
        return sorted(found, key=lambda epoch: (epoch.statement.base, -epoch.number))

    def find(self, split: str) -> Epoch | None:
        """Return the epoch with this split name; None if the split is not an epoch."""
        record = self._epochs.find(split)
        return epoch_with_statement(record) if record is not None else None

    def changes_between_epochs(self, language: str, metric: str = HEADLINE) -> Iterator[EpochChanges]:
        """Yield the changes between successive epochs, the latest first, if any agent played both.

        Args:
            language: code of the instructions' language.
            metric: one of COLUMNS.
        """
        known = self._board.languages()
        for newer, older in pairwise(self.all()):
            names = older.statement.split, newer.statement.split
            if older.statement.base != newer.statement.base or any(language not in known.get(one, ()) for one in names):
                continue
            if (found := self._compare(*names, language, metric)).agents:
                yield found

    def compare(self, older: str, newer: str, language: str, metric: str = HEADLINE) -> EpochChanges:
        """Compare the scores of all agents that have ranked runs on two epochs of a split.

        Two runs are of the same agent if account, participant, name, sensors and all arguments but the seed are equal,
        and if they do not name different code.

        Raises:
            NotFound: if there is no such epoch or language.
            Conflict: if the leaderboard of an epoch is frozen.
            BadInput: if the splits are not two epochs of one base split, the older first, or the metric is unknown.
        """
        for name in (older, newer):
            if self._epochs.find(name) is None:
                existing = ", ".join(epoch.statement.split for epoch in self.all()) or "none"
                raise NotFound(f"there is no epoch {quoted(name)}; there are {existing}")
        one, other = parse_epoch_name(older), parse_epoch_name(newer)
        if one is None or other is None or one[0] != other[0] or one[1] >= other[1]:
            raise BadInput(f"expected two epochs of one split, the older one first, got {older!r} and {newer!r}")
        if language == BOTH:
            raise BadInput("epochs are compared in one language, expected its code")
        for name in (older, newer):
            self._board.closing.check_shown(name)
        if metric not in COLUMNS:
            raise BadInput(f"cannot compare {quoted(metric)}; expected one of {', '.join(COLUMNS)}")
        return self._compare(older, newer, language, metric)

    def actions(self, run_id: str) -> dict[str, bytes]:
        """Return the actions of a published run by episode, one byte per action.

        Raises:
            NotFound: if the run is not on the leaderboard.
            Conflict: if its split is hidden and not a revealed epoch; or if its leaderboard is frozen.
        """
        run = self._board.entry(run_id).run
        self._board.closing.check_shown(run.split)
        if not self.shows_actions(run.split):
            raise Conflict(
                f"the split {run.split!r} is hidden: its runs' actions are public only once the secret of its epoch is "
                "revealed"
            )
        endings = self._journal.endings(run_id)
        return {one.episode_id: bytes(self._journal.actions(run_id, one.episode_id)) for one in endings}

    def shows_actions(self, split: str) -> bool:
        """Return whether the actions of published runs on a split are public."""
        if self._board.closing.is_frozen(split):
            return False
        found = self._splits.get(split)
        if found is not None and not found.hidden:
            return True
        record = self._epochs.find(split)
        return record is not None and record.state is EpochState.REVEALED

    def _compare(self, older: str, newer: str, language: str, metric: str) -> EpochChanges:
        before, after = (self._agents(split, language) for split in (older, newer))
        keys = [key for key in before if key in after and _may_be_same(before[key], after[key])]
        if not keys:
            return EpochChanges(older, newer, (), None)
        found = score_changes(
            _scored([before[key] for key in keys], metric),
            _scored([after[key] for key in keys], metric),
        )
        lines = [
            AgentChange(
                before[key],
                after[key],
                before[key].rows[TOTAL][metric].mean,
                after[key].rows[TOTAL][metric].mean,
                found.of_each[at],
                None if found.against_others is None else found.against_others[at],
                all(_codes(before[key], after[key])),
            )
            for at, key in enumerate(keys)
        ]
        lines.sort(key=lambda line: (line.difference.mean, line.newer.entries[0].run.run_id))
        return EpochChanges(older, newer, tuple(lines), found.mean)

    def _agents(self, split: str, language: str) -> dict[object, Standing]:
        """Return each agent's ranked standing, the one published last; none while the leaderboard is frozen."""
        if self._board.closing.is_frozen(split):
            return {}
        ranked = [line for line in self._board.standings(split, language) if line.is_ranked]
        ordered = sorted(ranked, key=lambda line: max((one.published_at, one.run.run_id) for one in line.entries))
        return {_agent_of(line.entries[0]): line for line in ordered}


def _scored(standings: Sequence[Standing], metric: str) -> EpochScores:
    means = [line.rows[TOTAL][metric].mean for line in standings]
    episodes = min(entry.counted for line in standings for entry in line.entries)
    return EpochScores(means, [len(line.entries) for line in standings], episodes)


def epoch_list_file(epochs: Sequence[Epoch]) -> dict[str, object]:
    """Return the content of the file that `arramon-server epoch verify` reads."""
    return {"format": LIST_FORMAT, "version": LIST_VERSION, "epochs": [epoch_as_data(epoch) for epoch in epochs]}


def epoch_as_data(epoch: Epoch) -> dict[str, object]:
    """Return an epoch as plain data."""
    record = epoch.record
    return {
        "split": record.split,
        "state": record.state.value,
        "statement": record.statement.decode(),
        "commitment": record.commitment.hex(),
        **{name: epoch.times.get(name) for name in _TIMES},
        "secret": record.secret,
        "command": epoch.command or None,
    }


def epoch_with_statement(record: EpochRecord) -> Epoch:
    """Parse the statement of an epoch's record.

    Raises:
        BadFile: if the statement in the database was altered.
    """
    return Epoch(record, read_statement(record.statement, f"statement of {record.split}"))


def _agent_of(entry: Entry) -> tuple[object, ...]:
    """Return a key that identifies an agent across epochs. It leaves out the code, which not every run names."""
    arguments = tuple(pair for pair in entry.run.agent_arguments if pair[0] != SEED)
    return (*entry.system, entry.sensors, arguments)


def _may_be_same(older: Standing, newer: Standing) -> bool:
    """Return whether the standings may be of the same agent: no two of their runs name different code."""
    return all(same is not False for same in _codes(older, newer))


def _codes(older: Standing, newer: Standing) -> list[bool | None]:
    """Return for each pair of runs whether they name the same code; None if either names none."""
    pairs = ((one.run.code, other.run.code) for one in older.entries for other in newer.entries)
    return [other.is_same_code(one) if one and other else None for one, other in pairs]
