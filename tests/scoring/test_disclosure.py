"""Published sums of hidden scores tell nothing of single episodes, alone or together."""

import numpy as np
import numpy.typing as npt
import pytest

from arramon_server.scoring.breakdown import SHOWN
from arramon_server.scoring.disclosure import (
    FLAT,
    GROUP_BITS,
    GROUP_NOISE,
    MIN_EPISODES,
    MIN_EPISODES_PER_STEP,
    PublishedSums,
    disclosed_bits,
    rounding_step,
)
from arramon_server.scoring.masking import randomised_rounding, upward_chance
from tests.scoring.figure_bits import figure_bits

Mask = npt.NDArray[np.bool_]


def first(episodes: int, number: int, *, turns: tuple[int, ...] = (0, 1)) -> Mask:
    """The first `number` of the episodes, in these turns."""
    group = np.zeros((episodes, 2), dtype=bool)
    group[:number, turns] = True
    return group


def max_leverage(groups: list[Mask]) -> float:
    """The largest leverage of an episode, from a pseudo-inverse of all sums: computed in another way."""
    episodes = groups[0].shape[0]
    turns = [first(episodes, episodes, turns=(turn,)) for turn in (0, 1)]
    sums = np.array([group.astype(float).ravel() for group in (*turns, *groups)])
    projection = np.linalg.pinv(sums) @ sums
    blocks = [projection[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] for n in range(episodes)]
    return max(float(np.linalg.eigvalsh(block)[-1]) for block in blocks)


def test_small_group_is_refused() -> None:
    published = PublishedSums(1000)
    assert not published.admit(first(1000, MIN_EPISODES - 1))
    assert not published.admit(first(1000, MIN_EPISODES - 1, turns=(0,)))
    assert published.admit(first(1000, 3 * MIN_EPISODES))


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
    assert max_leverage(admitted) == pytest.approx(published.leverages().max())
    assert max_leverage(admitted) <= 1.0 / MIN_EPISODES + 1e-9
    # No combination of the sums is about fewer than MIN_EPISODES episodes, as far as random combinations show it.
    turns = [first(episodes, episodes, turns=(turn,)) for turn in (0, 1)]
    sums = np.array([group.astype(float).ravel() for group in (*turns, *admitted)])
    for _ in range(300):
        zero = draw.choice(2 * episodes, len(sums) - 1, replace=False)  # a combination that is 0 in these turns
        weights = np.linalg.svd(sums[:, zero].T)[2][-1]
        about = np.abs(weights @ sums).reshape(episodes, 2).max(axis=1) > 1e-9
        assert about.sum() >= MIN_EPISODES


@pytest.mark.parametrize(
    ("episodes", "step"),
    [
        (5000, 0.01),
        (600, 0.01),
        (599, 0.02),
        (120, 0.05),
        (60, 0.1),
        (30, 0.2),
        (24, 0.5),
        (12, 0.5),
        (6, 1.0),
        (3, 1.0),
    ],
)
def test_a_step_is_about_some_episodes(episodes: int, step: float) -> None:
    assert rounding_step(episodes) == step
    assert step * episodes >= min(MIN_EPISODES_PER_STEP, episodes)


def capacity(channel: npt.NDArray[np.float64]) -> float:
    """The most bits that a channel tells, (inputs, outputs): the upper bound of Blahut and Arimoto's algorithm."""
    inputs = np.full(len(channel), 1.0 / len(channel))
    for _ in range(1000):
        outputs = inputs @ channel
        ratio = np.divide(channel, outputs, out=np.ones_like(channel), where=channel > 0.0)
        gains = (channel * np.log2(ratio)).sum(axis=1)
        inputs = inputs * 2.0**gains
        inputs /= inputs.sum()
    return float(gains.max())


@pytest.mark.parametrize("episodes", [6, 48, 60, 300, 1205])
def test_a_figure_tells_at_most_the_bits_of_a_z_channel(episodes: int) -> None:
    """Wherever the other episodes' sum lies, also where the episode can cross a grid point."""
    parts, moved, most = round(1.0 / rounding_step(episodes)), 1.0 / (episodes * rounding_step(episodes)), 0.0
    for place in (*np.linspace(0.0, min(parts, 3) - moved, 121), FLAT):
        # Between these the probabilities are linear in the score.
        bends = (edge + part for edge in range(parts + 1) for part in (-FLAT, 0.0, FLAT))
        scores = {0.0, 1.0} | {(bend - place) / moved for bend in bends if 0.0 < bend - place < moved}
        channel = np.zeros((len(scores), parts + 2))
        for row, score in zip(channel, sorted(scores), strict=True):
            total = min(place + moved * score, float(parts))
            row[int(total) + 1] = upward_chance(total, parts)
            row[int(total)] = 1.0 - row[int(total) + 1]
        most = max(most, capacity(channel))
    assert most == pytest.approx(figure_bits(episodes), abs=1e-6)
    assert figure_bits(episodes) <= figure_bits(6) < 0.21


@pytest.mark.parametrize("episodes", [6, 24, 48, 60, 300, 600, 1205])
def test_a_single_success_is_not_shown(episodes: int) -> None:
    """Nor a single failure: who stops at once in all episodes but one learns nothing of that one."""
    step = rounding_step(episodes)
    for threshold in (1e-9, 0.5, 1.0 - 1e-9):
        assert randomised_rounding(1 / episodes, step, threshold) == 0.0
        assert randomised_rounding(1 - 1 / episodes, step, threshold) == 1.0


def test_a_single_episode_is_told_entirely() -> None:
    assert figure_bits(1) == 1.0


def test_groups_of_one_run_tell_few_bits_of_an_episode() -> None:
    """However many groups there are, and where none of them is small."""
    draw, episodes = np.random.default_rng(0), 2000
    published, told_of = PublishedSums(episodes), np.zeros(episodes)
    admitted = 0
    for _ in range(400):
        group = draw.random((episodes, 2)) < 0.5
        if published.admit(group):
            admitted += 1
            told_of += disclosed_bits(group)
    assert 5 < admitted < 60
    assert told_of.max() <= GROUP_BITS


def test_bits_of_a_group_are_those_of_a_gaussian_channel() -> None:
    """One turn in [0, 1] has a variance of 1/4 at most, two together of 1; an episode outside tells nothing."""
    group = np.array([[True, False], [True, True], [False, False]])
    once, twice = (np.log2(1 + variance / GROUP_NOISE**2) / 2 for variance in (0.25, 1.0))
    assert disclosed_bits(group) == pytest.approx([len(SHOWN) * once, len(SHOWN) * twice, 0.0])


def test_rows_of_the_score_table_cost_nothing_again() -> None:
    published = PublishedSums(100)
    for turns in ((0,), (1,), (0, 1)):
        assert all(published.admit(first(100, 100, turns=turns)) for _ in range(100))
