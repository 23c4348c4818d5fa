"""What is paid for: tasks, milestones and kept texts, by the paper's "Worker Bonus Criteria and Rates"."""

from collections.abc import Iterator
from dataclasses import dataclass

from arramon_collecting.settings import Settings

MILESTONE = "milestone-"
"""Beginning of the kinds of entries for milestones."""


@dataclass(frozen=True, slots=True)
class Payment:
    """A payment: its kind and subject, which together are paid once, and its amount."""

    kind: str
    subject: str
    amount_minor: int


def payments_for_text(text_id: str, accepted: int, settings: Settings) -> Iterator[Payment]:
    """Yield what an accepted text earns.

    Args:
        text_id: the text.
        accepted: number of the author's accepted texts, this one included.
        settings: of the collection.
    """
    yield Payment("write", text_id, settings.pay_write)
    for count, amount in settings.milestones.items():
        if accepted >= count:
            yield Payment(f"{MILESTONE}{count}", str(count), amount)


def payment_for_verification(task_id: str, settings: Settings) -> Payment:
    """Return what a verification earns."""
    return Payment("verify", task_id, settings.pay_verify)


def payment_for_kept_text(text_id: str, settings: Settings) -> Payment:
    """Return what the author of a kept text earns."""
    return Payment("kept", text_id, settings.pay_kept)


def cost_of(texts: int, written: int, texts_per_worker: int, settings: Settings) -> int:
    """Return what a collection costs at these rates, in the currency's smallest unit.

    Args:
        texts: number of texts kept.
        written: number of texts written and accepted, each verified by all verifiers.
        texts_per_worker: number of accepted texts of each worker.
        settings: of the collection.
    """
    workers, rest = divmod(written, texts_per_worker)
    bonus = sum(amount for count, amount in settings.milestones.items() if texts_per_worker >= count)
    bonus_rest = sum(amount for count, amount in settings.milestones.items() if rest >= count)
    per_text = settings.pay_write + settings.verifiers * settings.pay_verify
    return written * per_text + workers * bonus + bonus_rest + texts * settings.pay_kept
