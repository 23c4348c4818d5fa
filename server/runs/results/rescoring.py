"""Rescoring: replay an ended run from the journal, and list differences from the recorded results."""

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import rfc8785
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict
from arramon_server.runs.accounts.administration import earlier_names
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.results.receipts import (
    MASKED_VERSION,
    UNDERIVED,
    VOIDED,
    SignedReceipt,
    receipt_content,
    stored_receipt,
)
from arramon_server.runs.results.reports import make_report, split_as_played
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.corrections import Corrections
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.play_digest import play_digest
from arramon_server.runs.storage.records import RUNNING, EpisodeEnding, Run
from arramon_server.sim.rules import Limits

TOLERANCE = 1e-9
"""Maximum difference of scores that count as equal: exponentials differ in the last digits between machines."""

MAX_DIFFERENCES = 10
"""Maximum number of differences that are listed for a run's episodes, and also for its receipt."""

OUTDATED = (
    "the receipt is outdated: the host has corrected the split since it was signed; a new one supersedes it when it is "
    "asked for, or when the command that corrected the split is repeated"
)
"""Difference of a receipt that a correction has not superseded yet."""


@dataclass(frozen=True, slots=True)
class RescoringResult:
    """Result of rescoring a run.

    Attributes:
        run_id: id of the run.
        episodes, steps: numbers of ended episodes and of their recorded steps.
        has_receipt: whether there was a receipt to compare with.
        differences: descriptions of the differences; empty if there are none.
        public_key: key that signed the receipt of a file, in hexadecimal; empty for runs of a journal.
    """

    run_id: str
    episodes: int
    steps: int
    has_receipt: bool
    differences: tuple[str, ...]
    public_key: str = ""


class Rescorer:
    """Replays and rescores runs without writing anything. Close it after use.

    Args:
        database: database of the journal.
        splits: splits of the runs, by name.
    """

    def __init__(self, database: Database, splits: Mapping[str, Split]) -> None:
        self._database = database
        self._journal = Journal(database)
        self._splits = splits
        self._worlds = Worlds(splits)

    def close(self) -> None:
        """Close the worlds."""
        self._worlds.close()

    def rescore(self, run_id: str) -> RescoringResult:
        """Replay a run, and compare the results with the recorded ones.

        Raises:
            NotFound: if there is no run with that id.
            Conflict: if the run is still being played, or the data of its split has changed or is missing.
            StorageError: if the journal cannot be read.
        """
        run = self._journal.run(run_id)
        if run.state == RUNNING:
            raise Conflict(f"run {run_id!r} is still being played")
        split = split_as_played(run, self._splits)
        endings, voided = self._journal.endings(run_id), self._journal.voided(run.split)
        receipt = stored_receipt(self._database, run_id)
        played: list[EpisodeEnding] = []
        found = [*self._in_episodes(run, split, endings, voided, played)]
        of_receipt: list[str] = []
        if receipt is not None and len(played) == len(endings):
            of_receipt = [*self._in_receipt(run, split, played, voided, receipt)]
        steps = sum(ending.steps for ending in endings)
        return RescoringResult(
            run_id,
            len(endings),
            steps,
            receipt is not None,
            (*limit_differences(found), *limit_differences(of_receipt)),
        )

    def _in_episodes(
        self, run: Run, split: Split, endings: Sequence[EpisodeEnding], voided: Set[str], played: list[EpisodeEnding]
    ) -> Iterator[str]:
        """Replay all episodes up to the first that fails; append their endings to `played`, and yield the differences.

        Void episodes are skipped: no score depends on them, and their data may have been corrected since.
        """
        unended = self._journal.count_unended(run.run_id)
        if unended:
            yield f"{unended} of {unended + len(endings)} episodes have not ended"
        for ending in endings:
            if ending.episode_id in voided:
                played.append(ending)
                continue
            try:
                again = replay_ending(run, split, ending, self._worlds, self._journal.actions)
            except (KeyError, ValueError) as error:
                yield f"episode {ending.episode_id}: cannot be replayed: {error}"
                return
            yield from _compare(f"episode {ending.episode_id}", _as_data(ending), _as_data(again))
            played.append(again)

    def _in_receipt(
        self, run: Run, split: Split, played: Sequence[EpisodeEnding], voided: Set[str], receipt: SignedReceipt
    ) -> Iterator[str]:
        try:
            Ed25519PublicKey.from_public_bytes(receipt.public_key).verify(receipt.signature, receipt.payload)
        except (InvalidSignature, ValueError):
            yield "receipt: its signature is wrong"
        written = json.loads(receipt.payload)
        corrections = Corrections(self._database).of_run(run.run_id, run.split, (one.episode_id for one in played))
        if written["data_hash"] in {one.data_before for one in corrections} - {run.data_hash}:
            yield OUTDATED
            return
        # Compared as it was signed: of a run whose episodes are all void now, it stays in force.
        signed, void = frozenset(written.get(VOIDED, ())), voided & {one.episode_id for one in played}
        if signed != void and len(void) < len(played):
            yield OUTDATED
        if (name := written["run"]["participant"]) in earlier_names(self._database, run.account):
            run = replace(run, participant=name)  # it was signed before the account was renamed
        masked = written.get("version") == MASKED_VERSION
        play = play_digest(run, played, self._journal.actions)
        progress = self._journal.progress(run.run_id)
        report = make_report(run, progress, played, split, play, signed, exact=not masked)
        made = receipt_content(self._journal.actions, report, played, hidden=split.hidden, masked=masked)
        yield from differences_of_receipt(written, made)


def replay_ending(
    run: Run, split: Split, ending: EpisodeEnding, worlds: Worlds, actions_of: Callable[[str, str], Sequence[int]]
) -> EpisodeEnding:
    """Replay the recorded actions of an episode, and return its ending.

    Args:
        run: run of the episode.
        split: split of the run.
        ending: recorded ending; its cause says what ended an episode that its actions do not end.
        worlds: worlds of the split.
        actions_of: returns the actions of a run's episode, given the ids of both.
    """
    episode = split.episodes[ending.episode_id]
    session = EpisodeSession(episode, worlds.world(split.name, episode), Limits(run.steps_per_phase))
    actions = actions_of(run.run_id, ending.episode_id) if ending.has_played else []
    for _ in session.replay(actions):
        pass
    cause = ending.cause
    if session.state.finished:
        cause = session.cause
    elif cause == causes.TIME_LIMIT:
        session.end_at_time_limit()
    elif cause in (causes.STEP_LIMIT, causes.AGENT_FINISHED):
        cause = "NOT_FINISHED"
    scores = [dict(turn) for turn in session.scores().turns]
    return replace(ending, cause=cause, steps=len(actions), scores=scores)


def check_same_states(
    run: Run,
    before: Split,
    after: Split,
    ending: EpisodeEnding,
    worlds: Worlds,
    actions_of: Callable[[str, str], Sequence[int]],
) -> None:
    """Check that an episode's recorded actions give the same states with two versions of its split's data.

    They do if the world is the same, except where objects are equally near: a pick-up then takes the target first.

    Args:
        run: run of the episode.
        before, after: the split, with the same world in this episode.
        ending: recorded ending.
        worlds: worlds of the split.
        actions_of: returns the actions of a run's episode, given the ids of both.

    Raises:
        ValueError: if they do not.
    """
    name = ending.episode_id
    collisions = worlds.world(after.name, after.episodes[name])
    actions = actions_of(run.run_id, name) if ending.has_played else ()
    ways = [EpisodeSession(split.episodes[name], collisions, Limits(run.steps_per_phase)) for split in (before, after)]
    states = [[*(state for state, _ in session.replay(actions)), session.state] for session in ways]
    if states[0] != states[1]:
        raise ValueError(f"episode {name}: the agent would have picked up another object")


def differences_of_receipt(written: dict[str, Any], replayed: Mapping[str, Any]) -> Iterator[str]:
    """Yield descriptions of the differences between a receipt's content and the content made from a replay.

    Args:
        written: content of the receipt.
        replayed: content as `receipt_content` returns it.
    """
    written = {name: value for name, value in written.items() if name not in UNDERIVED}
    again = json.loads(rfc8785.dumps(dict(replayed)))
    if written.get("intervals") != again["intervals"]:
        # Another release computed them by another method: the means must agree, the ends need not.
        written, again = _without_intervals(written), _without_intervals(again)
    yield from _compare("receipt", written, again)


def limit_differences(found: Iterable[str]) -> Iterator[str]:
    """Yield the first `MAX_DIFFERENCES` differences, and a last line if there are more."""
    left = iter(found)
    yield from islice(left, MAX_DIFFERENCES)
    if next(left, None) is not None:
        yield "... and more"


def _without_intervals(content: dict[str, Any]) -> dict[str, Any]:
    """Return a receipt's content without the intervals and their method."""
    kept = {name: value for name, value in content.items() if name != "intervals"}
    return {**kept, "scores": _without_ends(content.get("scores"))}


def _without_ends(value: Any) -> Any:
    """Return nested scores without the ends of intervals; other values, as in a forged receipt, are kept."""
    if not isinstance(value, dict):
        return value
    return {name: _without_ends(inner) for name, inner in value.items() if name not in ("low", "high")}


def _as_data(ending: EpisodeEnding) -> dict[str, Any]:
    turns = {f"turn {number}": turn for number, turn in enumerate(ending.scores, start=1)}
    return {"cause": ending.cause, "steps": ending.steps, **turns}


def _compare(place: str, written: Any, played: Any) -> Iterator[str]:
    """Yield descriptions of the differences between two pieces of plain data."""
    if isinstance(written, dict) and isinstance(played, dict):
        for key in dict.fromkeys((*written, *played)):
            yield from _compare(f"{place}: {key}", written.get(key), played.get(key))
    elif isinstance(written, list) and isinstance(played, list) and len(written) == len(played):
        for number, (one, other) in enumerate(zip(written, played, strict=True), start=1):
            yield from _compare(f"{place} {number}", one, other)
    elif isinstance(written, int | float) and isinstance(played, int | float):
        if not math.isclose(written, played, rel_tol=0.0, abs_tol=TOLERANCE):
            yield f"{place} was {written}, and is {played}"
    elif written != played:
        yield f"{place} was {written}, and is {played}"
