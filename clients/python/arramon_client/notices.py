"""Notices of a server's host as lines of text: who hosts it, when leaderboards close, and corrections."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from arramon.v1 import evaluation_pb2
from arramon.v1 import leaderboard_pb2 as pb
from arramon_client.output import episodes_text

MAX_NAMED = 5
"""Maximum number of a correction's episodes that are named."""

_CORRECTION_TEXTS = {
    "void": "void: {episodes}",
    "restore": "counted again: {episodes}",
    "rescore": "data corrected in {episodes}, from {before} to {after}, and all runs scored again",
}


def host_lines(info: evaluation_pb2.ServerInfo) -> Iterator[str]:
    """Yield the host's name, contact and rules, those that are given."""
    host = info.host
    said = {"host": host.name, "contact": host.contact, "rules": host.rules}
    yield from (f"{name}: {text}" for name, text in said.items() if text)


def closing_line(closes_at: str, *, frozen: bool) -> str:
    """Return a line with the time at which a leaderboard closes or closed; empty if it stays open."""
    if not closes_at:
        return ""
    if frozen:
        return f"frozen: scores and ranks are shown when it closes, at {closes_at}"
    return f"closes at {closes_at}: from then on no runs are created or published"


def correction_lines(corrections: Iterable[pb.Correction]) -> Iterator[str]:
    """Yield a line for each of a host's corrections: when, what and why."""
    for one in corrections:
        kind = pb.CorrectionKind.Name(one.kind).removeprefix("CORRECTION_KIND_").lower()
        yield _correction(kind, one.made_at, one.reason, one.episodes, one.data_before, one.data_after)


def signed_corrections(receipt: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line for each correction applied to a receipt's scores, and one for the receipt that it supersedes."""
    for one in receipt.get("corrections", ()):
        data = [str(one.get(name, "")) for name in ("data_before", "data_after")]
        yield _correction(one["kind"], one["made_at"], one["reason"], one["episodes"], *data)
    revision = receipt.get("revision")
    if revision:
        yield f"supersedes the receipt with the digest {revision.get('supersedes')} since {revision.get('made_at')}"


def superseded_line(payload_digest: bytes, entry: pb.Entry) -> str:
    """Return a line that a published run's receipt is superseded, and why; empty if it is the current receipt.

    Args:
        payload_digest: SHA-256 of the receipt's payload.
        entry: the run on the leaderboard.
    """
    if payload_digest == entry.receipt_digest:
        return ""
    for one in entry.superseded:
        if one.digest == payload_digest:
            why = "; ".join(correction_lines(entry.corrections))
            return f"SUPERSEDED at {one.superseded_at}: the host has signed another receipt for this run ({why})"
    return "the host shows another receipt for this run, and does not list this one among those that it superseded"


def digest_of(payload: str) -> bytes:
    """Return the SHA-256 of a receipt's payload, 32 bytes."""
    return hashlib.sha256(payload.encode()).digest()


def _correction(
    kind: str, made_at: str, reason: str, episodes: Sequence[str], before: str = "", after: str = ""
) -> str:
    named = ", ".join(map(str, episodes[:MAX_NAMED])) + (", ..." if len(episodes) > MAX_NAMED else "")
    said = _CORRECTION_TEXTS.get(kind, "{episodes}").format(
        episodes=f"{episodes_text(len(episodes))} ({named})", before=before[:12], after=after[:12]
    )
    return f"corrected at {made_at}: {said}: {reason}"
