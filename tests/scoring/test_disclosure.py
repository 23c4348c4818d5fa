"""Published sums of hidden scores tell nothing of single episodes, alone or together."""

import numpy as np
import numpy.typing as npt
import pytest

from server.scoring.disclosure import LEAST, STEPS, PublishedSums, step_of

Mask = npt.NDArray[np.bool_]


def first(episodes: int, number: int, *, turns: tuple[int, ...] = (0, 1)) -> Mask:
    """The first `number` of the episodes, in these turns."""
    group = np.zeros((episodes, 2), dtype=bool)
    group[:number, turns] = True
    return group


def told(groups: list[Mask]) -> float:
    """The largest leverage of an episode, from a pseudo-inverse of all sums: computed in another way."""
    episodes = groups[0].shape[0]
    turns = [first(episodes, episodes, turns=(turn,)) for turn in (0, 1)]
    sums = np.array([group.astype(float).ravel() for group in (*turns, *groups)])
    projection = np.linalg.pinv(sums) @ sums
    blocks = [projection[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] for n in range(episodes)]
    return max(float(np.linalg.eigvalsh(block)[-1]) for block in blocks)


def test_small_group_is_refused() -> None:
    published = PublishedSums(1000)
    assert not published.admit(first(1000, LEAST - 1))
    assert not published.admit(first(1000, LEAST - 1, turns=(0,)))
    assert published.admit(first(1000, 3 * LEAST))


def test_group_whose_complement_is_small_is_refused() -> None:
    """All but five episodes: the total less that sum is a sum over five."""
    published = PublishedSums(1000)
    assert not published.admit(first(1000, 995))
    assert not published.admit(first(1000, 995, turns=(1,)))  # the second turn's total is published, too
    assert published.admit(first(1000, 900))


def test_group_that_differs_by_few_from_another_is_refused() -> None:
    """Nested groups, and groups that overlap in all but a few."""
    published = PublishedSums(1000)
    assert published.admit(first(1000, 300))
    assert not published.admit(first(1000, 305))
    assert not published.admit(first(1000, 295))
    shifted = first(1000, 304) & ~first(1000, 4)
    assert not published.admit(shifted)
    assert published.admit(first(1000, 400))


def test_group_that_differs_by_few_from_a_union_is_refused() -> None:
    published = PublishedSums(1000)
    assert published.admit(first(1000, 100))
    assert published.admit(first(1000, 300) & ~first(1000, 200))
    union = first(1000, 100) | (first(1000, 300) & ~first(1000, 200))
    assert not published.admit(union | (first(1000, 503) & ~first(1000, 500)))
    assert published.admit(union | (first(1000, 700) & ~first(1000, 500)))


def test_group_that_follows_from_others_is_admitted() -> None:
    published = PublishedSums(200)
    assert published.admit(first(200, 100))
    before = published.leverages()
    assert published.admit(~first(200, 100))
    assert np.array_equal(published.leverages(), before)


@pytest.mark.parametrize("seed", range(5))
def test_no_combination_of_random_groups_is_about_few_episodes(seed: int) -> None:
    """As another computation finds it, and by trying to estimate single episodes' scores from the sums."""
    draw, episodes = np.random.default_rng(seed), 300
    published, admitted = PublishedSums(episodes), list[Mask]()
    for _ in range(60):
        group = draw.random((episodes, 2)) < draw.choice((0.02, 0.1, 0.3, 0.97))
        if published.admit(group):
            admitted.append(group)
    assert 3 < len(admitted) < 60
    assert told(admitted) == pytest.approx(published.leverages().max())
    assert told(admitted) <= 1.0 / LEAST + 1e-9
    # Nothing that follows from the sums is about fewer than LEAST episodes, as far as random combinations show it.
    turns = [first(episodes, episodes, turns=(turn,)) for turn in (0, 1)]
    sums = np.array([group.astype(float).ravel() for group in (*turns, *admitted)])
    for _ in range(300):
        zero = draw.choice(2 * episodes, len(sums) - 1, replace=False)  # a combination that is 0 in these turns
        weights = np.linalg.svd(sums[:, zero].T)[2][-1]
        about = np.abs(weights @ sums).reshape(episodes, 2).max(axis=1) > 1e-9
        assert about.sum() >= LEAST


@pytest.mark.parametrize(("turns", "step"), [(5000, 0.01), (400, 0.01), (399, 0.02), (80, 0.05), (40, 0.1), (20, 0.2)])
def test_means_are_rounded_to_twice_what_an_episode_can_move(turns: int, step: float) -> None:
    assert step_of(turns) == step
    assert step >= min(2 * 2 / turns, STEPS[-1])
