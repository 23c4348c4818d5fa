"""Coverage of intervals, false claims and power of paired tests: `python -m benchmarks.leaderboard.interval_coverage`.

Scores are drawn from known distributions, so that the truth is known: PTC-like (two trials of an episode that depend on
each other), rPOD-like (mostly 0, sometimes 1 or a part), and nDTW-like (continuous). Prints three tables:

- intervals: how often a nominal 95% interval holds the mean of the sections played, and the mean of all sections that
  could have been played; beside it the percentile bootstrap of whole sections, which earlier releases had;
- pairs: how often a difference between two runs is claimed, by its true size, with the interval's coverage;
- boards: 40 runs of known truth, how often any false claim is made on a board, and the share of true differences that
  is found; beside it the share that normal distributions with the true means and variances predict.

`--only` selects tables, `--repeats` sets the number of simulated data sets of each line (default 4000; the standard
error of a coverage is then 0.3%), and `--json` also writes all numbers.
"""

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr, ndtri

from arramon_server.scoring.intervals import episode_moments, mean_bounds, section_bounds
from arramon_server.scoring.paired import difference_bounds, holm, permutation_tests
from benchmarks.common import add_json, parser_of, positive_int, write_json

Floats = npt.NDArray[np.float64]
Draw = Callable[[np.random.Generator, Floats], Floats]

SPLITS = {"val_seen": 1065, "val_unseen": 1155, "test_unseen": 1205, "train": 4267}
"""Episodes of the paper's splits."""

SECTIONS, MEANS = (1, 2, 5, 7, 30), (0.01, 0.1, 0.5, 0.99)

SECTION_VARIANCE = 0.003
"""Variance between sections' means, as a share of the largest: a deviation of 0.027 at a mean of 0.5."""

LEVEL = 0.05

REFERENCE_EPISODES = 100_000
"""Episodes from which the true means and variances of differences are taken."""

BATCH = 100


def main() -> None:
    """Run the simulations and print their tables."""
    parser = parser_of(__doc__)
    tables = {"intervals": _intervals, "pairs": _pairs, "boards": _boards}
    parser.add_argument("--only", choices=tables, action="append", help="a table (default: all)")
    parser.add_argument("--repeats", type=positive_int, default=4000, help="data sets of a line (default: %(default)s)")
    add_json(parser)
    arguments = parser.parse_args()
    results = {}
    for name in arguments.only or tables:
        results[name] = list(_printed(tables[name](arguments.repeats)))
        print()
    write_json(arguments.json, results)


def draw_ptc(draw: np.random.Generator, means: Floats) -> Floats:
    """Draw scores like PTC: the mean of two trials; in 3 of 10 episodes the second equals the first."""
    first = draw.random(means.shape) < means
    second = np.where(draw.random(means.shape) < 0.3, first, draw.random(means.shape) < means)
    return (first.astype(np.float64) + second) / 2.0


def draw_rpod(draw: np.random.Generator, means: Floats) -> Floats:
    """Draw scores like rPOD: 1, 1/2, 1/5 or 1/10 in some episodes, otherwise 0; turned round for means above 0.6."""
    values, shares = np.array([1.0, 0.5, 0.2, 0.1]), np.array([0.6, 0.2, 0.1, 0.1])
    if means.mean() > 0.6:
        return 1.0 - draw_rpod(draw, 1.0 - means)
    scored = draw.random(means.shape) < np.minimum(means / (values @ shares), 1.0)
    scores: Floats = scored * draw.choice(values, p=shares, size=means.shape)
    return scores


def draw_ndtw(draw: np.random.Generator, means: Floats) -> Floats:
    """Draw scores like nDTW: of a beta distribution with a fifth of the largest variance."""
    return draw.beta(np.maximum(4.0 * means, 1e-9), np.maximum(4.0 * (1.0 - means), 1e-9))


KINDS: dict[str, Draw] = {"PTC": draw_ptc, "rPOD": draw_rpod, "nDTW": draw_ndtw}


def _intervals(repeats: int) -> Iterator[dict[str, object]]:
    for name, episodes in SPLITS.items():
        count = repeats if episodes < 2000 else max(repeats // 2, min(repeats, BATCH))
        for kind, draw_scores in KINDS.items():
            for mean in MEANS:
                for sections in SECTIONS:
                    yield {
                        "split": name, "score": kind, "mean": mean, "sections": sections,
                        **_coverage(draw_scores, mean, sections, episodes, count),
                    }  # fmt: skip


def _coverage(draw_scores: Draw, mean: float, sections: int, episodes: int, repeats: int) -> dict[str, object]:
    draw = np.random.default_rng([sections, episodes, round(1000 * mean)])
    of = np.arange(episodes) % sections
    here = other = old = 0
    batch = min(BATCH, repeats)
    strength = 1.0 / SECTION_VARIANCE - 1.0
    for _ in range(repeats // batch):
        truths = draw.beta(mean * strength, (1.0 - mean) * strength, size=(batch, sections))
        if sections == 1:
            truths[:] = mean
        values = draw_scores(draw, truths[:, of])
        truth = truths[:, of].mean(axis=1)
        found = mean_bounds(episode_moments(values.T, of))
        here += int(((found.low <= truth) & (truth <= found.high)).sum())
        others = section_bounds(values.T, of)
        if others is not None:
            other += int(((others.low <= mean) & (mean <= others.high)).sum())
            low, high = _bootstrapped(draw, values, of, sections)
            old += int(((low <= mean) & (mean <= high)).sum())
    number = repeats // batch * batch
    several = {"other sections": other / number, "bootstrap of sections": old / number} if sections > 1 else {}
    return {"these sections": here / number, **several}


def _bootstrapped(
    draw: np.random.Generator, values: Floats, of: npt.NDArray[np.intp], sections: int
) -> tuple[Floats, Floats]:
    """Return the ends of percentile bootstrap intervals for each row of values, from 400 resamples of sections."""
    sizes = np.bincount(of)
    sums = np.stack([values[:, of == section].sum(axis=1) for section in range(sections)], axis=1)
    counts = draw.multinomial(sections, np.full(sections, 1.0 / sections), size=400)
    means = (sums @ counts.T) / (counts @ sizes)
    low, high = np.quantile(means, (0.025, 0.975), axis=1)
    return low, high


def _pairs(repeats: int) -> Iterator[dict[str, object]]:
    episodes = SPLITS["test_unseen"]
    for kind in KINDS:
        for base in (0.01, 0.1, 0.5):
            for gain in (0.0, 0.01, 0.02, 0.04):
                draw = np.random.default_rng([round(1000 * base), round(1000 * gain)])
                claims = held = apart = 0
                for _ in range(max(repeats // 4, 1)):
                    runs = _runs(draw, kind, np.array([base + gain, base]), episodes)
                    claims += permutation_tests(runs, flips=2000)[0, 1] < LEVEL
                    strata = np.zeros(episodes, np.intp)
                    _, low, high = difference_bounds(runs[0] - runs[1], strata)
                    held += low <= gain <= high
                    one, two = (mean_bounds(episode_moments(run, strata)) for run in runs)
                    apart += bool(one.low > two.high or two.low > one.high)
                number = max(repeats // 4, 1)
                yield {
                    "score": kind, "mean": base, "difference": gain, "claimed": claims / number,
                    "interval covers": held / number, "intervals apart": apart / number,
                }  # fmt: skip


def _boards(repeats: int) -> Iterator[dict[str, object]]:
    """Boards of 40 runs: all equal, in groups of four equal ones, and all different."""
    episodes, number = SPLITS["test_unseen"], max(repeats // 20, 1)
    upper = np.triu_indices(40, 1)
    truths = {
        "all equal": np.full(40, 0.3),
        "ten groups of four": np.repeat(np.linspace(0.1, 0.55, 10), 4),
        "all different": np.linspace(0.1, 0.5, 40),
    }
    for kind in KINDS:
        for name, truth in truths.items():
            draw = np.random.default_rng(len(name))
            gaps = (truth[:, None] - truth)[upper]
            differ = np.abs(gaps) > 1e-9
            predicted = _predicted(kind, truth, episodes) if differ.any() else None
            wrong = true = found = 0
            for _ in range(number):
                runs = _runs(draw, kind, truth, episodes)
                claimed = holm(permutation_tests(runs)[upper]) < LEVEL
                seen = np.sign((runs.mean(axis=1)[:, None] - runs.mean(axis=1))[upper])
                false = claimed & (seen != np.sign(np.round(gaps, 9)))
                wrong += bool(false.any())
                true += int(differ.sum())
                found += int((claimed & ~false).sum())
            yield {
                "score": kind, "truth": name, "boards with a false claim": wrong / number,
                "differences found": found / true if true else None, "predicted": predicted,
            }  # fmt: skip


def _predicted(kind: str, truth: Floats, episodes: int) -> float:
    """Return the share of true differences that Holm's procedure finds if means are normally distributed.

    It tests each hypothesis that is left at the level over their number, which depends on how many it has rejected: the
    share is where both agree.
    """
    upper = np.triu_indices(len(truth), 1)
    runs = _runs(np.random.default_rng(0), kind, truth, REFERENCE_EPISODES)
    means, moments = runs.mean(axis=1), np.cov(runs)
    alone = np.diag(moments)
    errors = np.sqrt((alone[:, None] + alone - 2.0 * moments)[upper] / episodes)
    differ = np.abs((truth[:, None] - truth)[upper]) > 1e-9
    sizes = (np.abs((means[:, None] - means)[upper]) / errors)[differ]
    number, found = len(upper[0]), 0.0
    for _ in range(200):
        bound = ndtri(1.0 - LEVEL / (number - found) / 2.0)
        found = float(ndtr(sizes - bound).sum())
    return found / len(sizes)


def _runs(draw: np.random.Generator, kind: str, means: Floats, episodes: int) -> Floats:
    """Return scores of runs, (runs, episodes), that agree on what is hard: an episode's odds are multiplied for all."""
    odds = means[:, None] / (1.0 - means[:, None]) * np.exp(draw.normal(0.0, 1.0, episodes))
    chances = odds / (1.0 + odds)
    chances *= means[:, None] / chances.mean(axis=1, keepdims=True)
    return KINDS[kind](draw, np.clip(chances, 0.0, 1.0))


def _printed(lines: Iterator[dict[str, object]]) -> Iterator[dict[str, object]]:
    """Print the lines of a table as they come."""
    for number, line in enumerate(lines):
        if number == 0:
            print("  ".join(f"{name:>14}" for name in line))
        cells = (f"{value:.3f}" if isinstance(value, float) else str(value) for value in line.values())
        print("  ".join(f"{cell:>{max(len(name), 14)}}" for cell, name in zip(cells, line, strict=False)), flush=True)
        yield line


if __name__ == "__main__":
    main()
