"""Rescoring from a receipt file and the run's actions, without a journal, on any machine that has the split."""

import json
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Any

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
from pydantic import TypeAdapter

from arramon.strict_json import read_json
from arramon.v1.chain import episode_ending, steps_to
from arramon_server.episodes.split_files import read_json_object
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadFile, quoted
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.results.receipts import FORMAT, LIMITS, MASKED_VERSION, VERSION, VOIDED, receipt_content
from arramon_server.runs.results.reports import make_report, split_as_played
from arramon_server.runs.results.rescoring import (
    RescoringResult,
    differences_of_receipt,
    limit_differences,
    replay_ending,
)
from arramon_server.runs.storage.causes import AGENT_FINISHED, FORFEITED, SERVER_FAULT, STEP_LIMIT, TIME_LIMIT
from arramon_server.runs.storage.play_digest import play_digest
from arramon_server.runs.storage.records import CodeReference, EpisodeEnding, Run, RunProgress

FILE_FORMAT, FILE_VERSION = "arramon-receipt-file", 1
"""Header of a receipt file, which `arramon-client verify` reads, too."""

_DIGITS = frozenset("0123")

VERSIONS = (VERSION, MASKED_VERSION)
"""Versions of payloads that can be rescored."""

CAUSES = (AGENT_FINISHED, STEP_LIMIT, TIME_LIMIT, FORFEITED, SERVER_FAULT)
"""Causes that an episode of a receipt may commit to."""

_PLAYED = TypeAdapter(tuple[Run, RunProgress, list[EpisodeEnding]])
"""Checks the types of a receipt's values, as anyone can sign a file with their own key."""

Actions = Mapping[str, Sequence[int]]
"""Actions of a run, by episode id."""


def rescore_file(path: Path, actions_path: Path, splits: Mapping[str, Split]) -> RescoringResult:
    """Replay a run from its receipt and its actions, and compare the results with the receipt.

    Args:
        path: file of the receipt.
        actions_path: file with the run's actions: a download from the leaderboard, or a client's results file.
        splits: splits on this machine, by name.

    Raises:
        BadFile: if a file is malformed or altered, or the actions are those of another run or lack an episode.
        Conflict: if the split is missing or has other data than the run was played on.
    """
    content, key = _read_receipt(path)
    try:
        run = _run_of(content)
        voided = frozenset(map(str, content.get(VOIDED, ())))
        actions = _read_actions(actions_path, run.run_id)
        recorded = _endings_of(content, run, actions)
        progress = _progress_of(content, recorded)
        run, progress, recorded = _checked(run, progress, recorded)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BadFile(path, f"is signed by {key}, but its content does not have the fields of a receipt") from error
    split = split_as_played(run, splits)
    missing = [one.episode_id for one in recorded if (one.steps or not one.cause) and one.episode_id not in actions]
    if missing:
        raise BadFile(actions_path, f"lacks the actions of {len(missing)} episodes, the first one is {missing[0]!r}")
    steps = {one.episode_id: one.steps for one in recorded}

    def actions_of(_run_id: str, episode_id: str) -> Sequence[int]:
        """Return the recorded actions of an episode: a client may have sent more after its end."""
        return actions.get(episode_id, ())[: steps[episode_id]]

    played, found = list[EpisodeEnding](), list[str]()
    found += [f"episode {one.episode_id}: its head was not that of these actions" for one in recorded if not one.cause]
    with closing(Worlds({split.name: split})) as worlds:
        for ending in () if found else recorded:
            if ending.episode_id in voided:  # no score depends on it
                played.append(ending)
                continue
            try:
                played.append(replay_ending(run, split, ending, worlds, actions_of))
            except (KeyError, ValueError) as error:
                found.append(f"episode {ending.episode_id}: cannot be replayed: {error}")
    if not found:
        try:
            masked = content["version"] == MASKED_VERSION
            play = play_digest(run, played, actions_of)
            report = make_report(run, progress, played, split, play, voided, exact=not masked)
            made = receipt_content(actions_of, report, played, hidden=split.hidden, masked=masked)
            found = [*limit_differences(differences_of_receipt(content, made))]
        except ValueError as error:  # such as a number that is no limit, or no episodes at all
            raise BadFile(path, f"has a value that no receipt can have: {error}") from error
    return RescoringResult(run.run_id, len(recorded), sum(steps.values()), True, tuple(found), key)


def _read_receipt(path: Path) -> tuple[dict[str, Any], str]:
    """Check the signature of a receipt, and return its content and the public key in hexadecimal."""
    file = read_json_object(path)
    if (file.get("format"), file.get("version")) != (FILE_FORMAT, FILE_VERSION):
        raise BadFile(path, f"is not a receipt: expected the format {FILE_FORMAT!r}, version {FILE_VERSION}")
    try:
        payload, key = file["payload"].encode(), bytes.fromhex(file["public_key"])
        Ed25519PublicKey.from_public_bytes(key).verify(bytes.fromhex(file["signature"]), payload)
        content = read_json(payload)
        json.dumps(content, ensure_ascii=False).encode()  # half a character is no text
    except (KeyError, TypeError, AttributeError, ValueError, InvalidSignature) as error:
        raise BadFile(path, "was altered: its signature does not match its content and key") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT or content.get("version") not in VERSIONS:
        raise BadFile(path, f"contains no {FORMAT!r} of version {' or '.join(map(str, VERSIONS))}")
    return content, key.hex()


def _run_of(content: Mapping[str, Any]) -> Run:
    """Return the run of a receipt."""
    run = content["run"]
    return Run(
        **{name: run[name] for name in ("run_id", "participant", "agent", "split", "language", "state")},
        **{name: content["limits"][name] for name in LIMITS},
        sensors=tuple(run["sensors"]),
        data_hash=content["data_hash"],
        server_version=content["server_version"],
        created_at=datetime.fromisoformat(run["created_at"]),
        ended_at=datetime.fromisoformat(run["ended_at"]) if run["ended_at"] else None,
        agent_arguments=tuple(sorted(run.get("agent_arguments", {}).items())),
        code=CodeReference(**run.get("code", {})),
    )


def _endings_of(content: Mapping[str, Any], run: Run, actions: Actions) -> list[EpisodeEnding]:
    """Return the endings of a receipt's episodes, without scores.

    A receipt of MASKED_VERSION contains neither steps nor causes: both are derived from the actions. Where these are
    missing, or differ from those of the receipt, the cause is empty.
    """
    if content["version"] != MASKED_VERSION:
        return [
            EpisodeEnding(run.run_id, one["episode_id"], one["cause"], int(one["steps"]), [])
            for one in content["episodes"]
        ]
    endings = []
    for one in content["episodes"]:
        taken, head = actions.get(one["episode_id"], ()), bytes.fromhex(one["head"])
        steps = steps_to(head, run.run_id, one["episode_id"], run.data_hash, taken)
        cause = "" if steps is None else _cause_of(one, run, taken[:steps])
        endings.append(EpisodeEnding(run.run_id, one["episode_id"], cause, steps or 0, []))
    return endings


def _cause_of(episode: Mapping[str, Any], run: Run, actions: Sequence[int]) -> str:
    """Return the cause that an episode of a receipt commits to; empty if no cause matches, given these actions."""
    committed = bytes.fromhex(episode["ending"])
    found = (
        cause for cause in CAUSES if episode_ending(run.run_id, episode["episode_id"], cause, actions) == committed
    )
    return next(found, "")


def _progress_of(content: Mapping[str, Any], endings: Sequence[EpisodeEnding]) -> RunProgress:
    return RunProgress(
        episodes=len(endings),
        ended=len(endings),
        steps=sum(ending.steps for ending in endings),
        causes={cause: [one.cause for one in endings].count(cause) for cause in {one.cause for one in endings}},
        images=tuple(content["run"]["images"]),
        reoffers=content["reoffers"],
    )


def _checked(
    run: Run, progress: RunProgress, endings: Sequence[EpisodeEnding]
) -> tuple[Run, RunProgress, list[EpisodeEnding]]:
    """Return the arguments if all fields have the right types.

    Raises:
        ValueError: if one does not.
    """
    fields = asdict(run), asdict(progress), [asdict(ending) for ending in endings]
    return _PLAYED.validate_python(fields)


def _read_actions(path: Path, run_id: str) -> Actions:
    content = read_json_object(path)
    run, actions = content.get("run"), content.get("actions")
    if not isinstance(run, dict) or not isinstance(actions, dict):
        raise BadFile(path, "has no actions: expected a download from the leaderboard, or a client's results file")
    if run.get("run_id") != run_id:
        found = quoted(str(run.get("run_id")))
        raise BadFile(path, f"has the actions of run {found}, but the receipt is for run {run_id!r}")
    for name, digits in actions.items():
        if not isinstance(digits, str) or not _DIGITS.issuperset(digits):
            raise BadFile(path, "is no text of the digits 0 to 3", field=f"actions.{name}")
    return {name: tuple(map(int, digits)) for name, digits in actions.items()}
