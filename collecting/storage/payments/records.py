"""Entries of the ledger as dataclasses, and their kinds."""

from dataclasses import dataclass
from datetime import datetime

PAID_WRITE, PAID_VERIFY, PAID_KEPT = "write", "verify", "kept"
"""Kinds of ledger entries; those of milestones are `milestone-5` and so on."""


@dataclass(frozen=True, slots=True)
class LedgerEntry:
    """An amount owed to a worker for a subject: a task, a text or a milestone."""

    entry_id: str
    collection: str
    worker_id: str
    kind: str
    subject: str
    amount_minor: int
    currency: str
    created_at: datetime
