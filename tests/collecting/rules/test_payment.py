"""Payments, by the paper's rates."""

from arramon_collecting.rules.payment import cost_of, payments_for_text
from arramon_collecting.settings import Settings

PAPER = Settings()


def test_a_text_earns_its_pay_and_the_milestones_reached() -> None:
    found = [[(one.kind, one.amount_minor) for one in payments_for_text("t", count, PAPER)] for count in (1, 5, 20, 50)]
    write, five, twenty, fifty = ("write", 100), ("milestone-5", 10), ("milestone-20", 90), ("milestone-50", 400)
    assert found == [[write], [write, five], [write, five, twenty], [write, five, twenty, fifty]]


def test_what_a_collection_costs() -> None:
    """1,000 texts that are kept, of 1,111 written by workers of 50 each: 90% are kept in the paper (7,692 of 8,546)."""
    # 1,111 * (1.00 + 3 * 0.20) + 22 workers with all milestones (5.00) + 11 texts of one more (0.10) + 1,000 * 0.10
    assert cost_of(1000, 1111, 50, PAPER) == 177_760 + 22 * 500 + 10 + 10_000
