"""Batches: the order of each epoch, and padding."""

from collections import Counter

from arramon_agents.training.batches import EpochBatches, epoch_batches, padded
from tests.agents.training_fixtures import demonstrations


def test_an_epoch_has_each_demonstration_of_a_phase_once() -> None:
    shown = demonstrations(10)
    batches = epoch_batches(shown, "assembly", 4, "1/0")
    assert sorted(map(len, batches)) == [2, 4, 4]
    assert {shown[row].phase for batch in batches for row in batch} == {"assembly"}
    assert max(Counter(row for batch in batches for row in batch).values()) == 1


def test_epochs_differ_and_follow_from_the_seed_alone() -> None:
    shown = demonstrations(12)
    epochs, again = EpochBatches(shown, "navigation", 2, 7), EpochBatches(shown, "navigation", 2, 7)
    assert epochs.count == 6
    steps = [epochs.batch(step) for step in range(18)]
    first, second, third = (steps[at : at + 6] for at in (0, 6, 12))
    assert first != second != third
    assert {row for batch in first for row in batch} == {row for batch in third for row in batch}
    assert again.batch(13) == third[1]  # In any order, as after resuming.
    assert again.batch(2) == first[2]
    assert EpochBatches(shown, "navigation", 2, 8).batch(0) != first[0]


def test_texts_are_padded_at_their_end() -> None:
    assert padded([[5, 6], [], [7, 8, 9]]).tolist() == [[5, 6, 0], [0, 0, 0], [7, 8, 9]]
    assert padded([]).shape == (0, 0)
