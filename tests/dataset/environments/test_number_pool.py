"""Reservation and reuse of numbers."""

from arramon_dataset.environments.number_pool import NumberPool


class Holder:
    pass


def test_numbers_are_apart_and_used_again() -> None:
    slots = NumberPool()
    holders = [Holder() for _ in range(3)]
    assert [slots.take(holder) for holder in holders] == [0, 1, 2]
    del holders[1]
    other = Holder()
    assert slots.take(other) == 1
    assert slots.take(holders[0]) == 3
