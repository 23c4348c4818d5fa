"""An attacker who uses all public numbers of a hidden split together, on runs of its own choice."""

import math
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from scipy.special import stdtrit

from arramon_server.board.board import Board
from arramon_server.board.comparisons import ComparisonCache
from arramon_server.board.episode_table import EpisodeTable
from arramon_server.board.standings import COLUMNS, Mark
from arramon_server.errors import Conflict
from arramon_server.runs.results.reports import report_of
from arramon_server.scoring import masking
from arramon_server.scoring.aggregate import Interval
from arramon_server.scoring.disclosure import GROUP_BITS, TEST_NOISE, rounding_step
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.scoring.intervals import Floats
from arramon_server.scoring.masking import Noise, masked_rows
from tests import tiny
from tests.board.leaderboard_backend import CLOCKS, STEPS, LeaderboardBackend, standing
from tests.scoring.figure_bits import figure_bits

EPISODES = 48
TURNS = ("turn 1", "turn 2")
DAY = 3
"""Runs a day that a participant has on a hidden split by default."""

FIGURES = 2 * len(METRICS)
"""Figures of the rows of one run: 15 metrics of two turns."""

TEST_BITS = len(COLUMNS) * math.log2(1 + 0.25 / TEST_NOISE**2) / 2
"""The same of the noisy sums that are compared with those of other runs."""

REST_BITS = GROUP_BITS + TEST_BITS


class Target(LeaderboardBackend):
    """A leaderboard with a larger hidden split, "guarded"."""

    def __init__(self, folder: Path, episodes: int = EPISODES) -> None:
        super().__init__(folder)
        self.splits["guarded"] = tiny.write(folder, "guarded", episodes, hidden=True)
        self.board = Board(self.entries, self.splits, steps_per_phase=STEPS, clocks=CLOCKS)

    def plays(self, run_id: str, scores: Floats, detour: int = 0) -> str:
        """Play a run of an agent of its own with these scores, equal in all metrics of both turns."""
        return self.run(run_id, scores.tolist(), split="guarded", agent=run_id, detour=detour)

    def figures(self, run_id: str) -> Floats:
        """Return what a participant's report shows of the turns of its own run."""
        rows = report_of(self.journal.run(run_id), self.journal, self.splits).table.rows
        return np.array([rows[row][metric].mean for row in TURNS for metric in METRICS])


@pytest.fixture
def target(tmp_path: Path) -> Iterator[Target]:
    made = Target(tmp_path)
    with closing(made.database):
        yield made


@pytest.fixture
def unordered(monkeypatch: pytest.MonkeyPatch) -> None:
    """All figures as they are before the metrics are put in order: more than anybody sees, and easier to use."""
    monkeypatch.setattr(masking, "_consistent", lambda values: values)


def likelihood(shown: float, exact: Floats, step: float) -> Floats:
    """The probability that exact means are shown so."""
    parts = round(1.0 / step)
    places = np.round(exact * parts, 9)
    up = np.array([masking.upward_chance(float(place), parts) for place in places])
    seen = round(shown * parts)
    chances: Floats = np.where(np.floor(places) == seen, 1.0 - up, np.where(np.floor(places) == seen - 1, up, 0.0))
    return chances


def sum_of_squares(value: Interval, episodes: int) -> float:
    """Return the sum of squared scores, from the interval of a mean as open splits have it."""
    quantile, freedom = float(stdtrit(episodes - 1, 0.975)), episodes - 1
    ends = value.low + value.high
    if abs(1 - ends) < 1e-9:
        return episodes * value.mean  # rounded ends that tell nothing of it
    weight = (ends - 2 * value.mean) / (1 - ends)
    share = (weight / quantile**2 * episodes * (freedom + 1) - 1) / freedom
    return share * value.mean * (1 - value.mean) * freedom + episodes * value.mean**2


def sum_of_squared_differences(value: Interval, episodes: int) -> float:
    """Return the sum of squared differences, from the interval of a difference as open splits have it."""
    quantile, freedom = float(stdtrit(episodes - 1, 0.975)), episodes - 1
    share = ((value.high - value.low) / 2 / quantile) ** 2 * episodes
    return (share * (freedom + 1) - 1) + episodes * value.mean**2


def test_nobody_solves_for_the_score_of_another_participant(target: Target) -> None:
    """One episode played well, all others stopped at once: its own scores are known, the victim's follow."""
    truth = np.random.default_rng(0).random(EPISODES)
    target.publish(target.plays("victim", truth))
    found = []
    for at in range(12):
        mine = np.zeros(EPISODES)
        mine[at] = 1.0
        target.publish(target.plays(f"probe {at}", mine))
        ((_, compared),) = (
            line
            for line in target.board.compare_with_all(f"probe {at}", sort="nDTW").lines
            if line[0].agent == "victim"
        )
        difference = compared.difference
        squares = sum_of_squares(target.board.entry("victim").rows["total"]["nDTW"], EPISODES)
        other = sum_of_squared_differences(Interval(difference.mean, difference.low, difference.high), EPISODES)
        found.append(min(max((squares + 1.0 - other) / 2.0, 0.0), 1.0))
    error = np.sqrt(np.mean((np.array(found) - truth[:12]) ** 2))
    assert error > 0.8 * truth.std(), (found, truth[:12])


def test_what_is_said_of_a_pair_follows_from_shown_means(target: Target) -> None:
    """Two victims with the same shown means but other scores: the same interval, whatever the attacker plays."""
    target.publish(target.plays("victim", np.random.default_rng(0).random(EPISODES)))
    target.publish(target.plays("probe", np.ones(EPISODES)))
    for metric in COLUMNS:
        ((other, compared),) = target.board.compare_with_all("victim", sort=metric).lines
        rows = [target.board.entry(name).rows["total"][metric].mean for name in ("victim", "probe")]
        assert other.agent == "probe"
        assert compared.difference.mean == pytest.approx(rows[0] - rows[1], abs=1e-4)
        assert {compared.difference.p, compared.corrected} <= {0.001, 0.01, 0.05, 1.0}


def test_runs_that_mostly_forfeited_are_compared_with_nobody(target: Target) -> None:
    target.publish(target.plays("victim", np.ones(EPISODES)))
    order = [episode.episode_id for episode in target.splits["guarded"].in_playing_order("en")]
    target.run("probe", [1.0] * EPISODES, split="guarded", agent="probe", causes=["FORFEITED"] * (len(order) // 2 + 1))
    target.run("half", [1.0] * EPISODES, split="guarded", agent="half", causes=["FORFEITED"] * (len(order) // 2))
    for name in ("probe", "half"):
        target.publish(name)
    lines = {line.agent: line for line in target.board.standings("guarded", "en")}
    assert (lines["probe"].rank, lines["probe"].marks) == (0, (Mark.FORFEITED,))
    assert lines["half"].marks == ()
    with pytest.raises(Conflict, match=r"is not ranked \(forfeited\), so it is compared with no other"):
        target.board.compare_with_all("probe")
    assert [other.agent for other, _ in target.board.compare_with_all("victim").lines] == ["half"]
    target.publish(target.run("open", 1.0, agent="open", causes=["FORFEITED"] * 5))
    assert target.board.entry("open").marks == ()


@pytest.mark.parametrize(("days", "least"), [(1, 0.46), (3, 0.41), (20, 0.15)])
@pytest.mark.usefixtures("unordered")
def test_least_squares_over_chosen_runs_leave_single_scores_open(target: Target, days: int, least: float) -> None:
    """Each run plays a random half of the episodes, and stops in the others; its figures are all of that one sum.

    In truth the metrics differ, and tell less. Guessing the mean has an error of 0.5.
    """
    draw = np.random.default_rng(days)
    truth = (draw.random(EPISODES) < 0.5).astype(float)
    played = draw.random((days * DAY, EPISODES)) < 0.5
    shown = [target.figures(target.plays(f"run {at}", truth * chosen)) for at, chosen in enumerate(played)]
    sums = np.array(shown).mean(axis=1) * EPISODES
    noise = (rounding_step(EPISODES) * EPISODES) ** 2 / 6 / FIGURES  # variance of a mean of roundings, on average
    design = played.astype(float)
    covariance = np.linalg.inv(design.T @ design / noise + np.eye(EPISODES) / 0.25)
    estimate = 0.5 + covariance @ design.T @ (sums - design.sum(axis=1) / 2) / noise
    error = np.sqrt(np.mean((np.clip(estimate, 0, 1) - truth) ** 2))
    assert error > least


@pytest.mark.usefixtures("unordered")
def test_a_total_leaves_nearly_all_assignments_of_targets_open(tmp_path: Path) -> None:
    """24 episodes with two candidates each, of known scores: 16.8 million assignments before one total is known."""
    number, draw = 24, np.random.default_rng(1)
    candidates = draw.random((number, 2))
    truth = candidates[np.arange(number), draw.integers(0, 2, number)]
    target = Target(tmp_path, number)
    with closing(target.database):
        shown = target.figures(target.plays("probe", truth))
    sums = np.zeros(1)
    for pair in candidates:
        sums = np.add.outer(sums, pair).ravel()
    # Exact totals would leave a handful: those that add up to what is shown.
    assert not 0 < np.count_nonzero(np.abs(sums - shown[0] * number) < 1e-9) < 10_000
    grid = np.linspace(sums.min(), sums.max(), 4000)
    known = np.zeros(len(grid))
    for value in shown:
        known += np.log(np.maximum(likelihood(value, grid / number, rounding_step(number)), 1e-300))
    weights = np.exp(np.interp(sums, grid, known - known.max()))
    weights /= weights.sum()
    left = float(-(weights * np.log2(np.maximum(weights, 1e-300))).sum())
    assert left > number - 2.0


@pytest.mark.parametrize(
    ("others", "runs", "metrics", "least", "most"),
    [
        (24, 1, 1, 0.0, 0.05),
        (24, 1, len(METRICS), 0.1, 0.4),
        (24, DAY, len(METRICS), 0.3, 0.8),
        (0, DAY, len(METRICS), -0.01, 0.01),
        (1, DAY, len(METRICS), -0.01, 0.01),
        (2, 1, 1, 0.05, 2 * figure_bits(EPISODES)),
        (2, 1, len(METRICS), 0.6, 0.95),
    ],
)
@pytest.mark.usefixtures("unordered")
def test_what_one_episode_tells_to_who_knows_all_others(
    others: int, runs: int, metrics: int, least: float, most: float
) -> None:
    """All metrics of both turns are 0 or 1, so all figures agree. SECURITY.md states it.

    With 24 others solved the sum lies in the middle between two grid points. With none or one all figures are 0, solved
    or not. With two known successes a figure tells most: the first that is not 0 shows that the episode was solved.
    """
    draw, step = np.random.default_rng(2), rounding_step(EPISODES)
    information, days = [], 600
    for day in range(days):
        solved = draw.integers(0, 2)
        scores = np.zeros((EPISODES, 2, len(METRICS)))
        scores[:others] = 1.0
        scores[others] = solved
        known = np.zeros(2)
        for run in range(runs):
            rows = masked_rows(scores, Noise(b"secret"), f"{day} {run}")
            means = (others + np.arange(2.0)) / EPISODES
            for row in TURNS:
                for metric in METRICS[:metrics]:
                    known += np.log(np.maximum(likelihood(rows[row][metric].mean, means, step), 1e-300))
        posterior = np.exp(known - np.logaddexp(*known))
        information.append(1.0 + float(np.log2(posterior[solved])))  # log score: its mean is the information
    told, error = np.mean(information), np.std(information) / days**0.5
    assert told < runs * 2 * metrics * figure_bits(EPISODES) + 3 * error
    assert least < told < most + 3 * error


def test_plays_that_score_alike_do_not_show_it(target: Target) -> None:
    """Whoever knows the scores of one play would otherwise find those of another, which differs in one episode.

    Equal figures for equal scores would tell that one bit.
    """
    truth = (np.arange(EPISODES) % 2).astype(float)
    shown = [tuple(target.figures(target.plays(f"run {detour}", truth, detour))) for detour in range(8)]
    assert len(set(shown)) > 4


def test_paired_tests_are_no_ruler() -> None:
    """Probes that solve some known episodes and one more, against a run that solves none: what the outcome tells of it.

    Without noise, the sixth success makes p fall below 0.05: one bit for each run and column.
    """
    most, draws, classes = 0.0, 300, (0.001, 0.01, 0.05, 1.0)
    section_of = {str(number): "1" for number in range(EPISODES)}
    ids = tuple(sorted(section_of))
    tables: dict[str, EpisodeTable] = {}
    family = ComparisonCache(lambda version: tables[version.run_id], lambda split: Noise(b"secret"))
    for known in (5, 12, 20, 28):
        counts = np.zeros((2, len(classes)))
        for solved in (0, 1):
            scores = np.zeros((EPISODES, 2, len(METRICS)))
            scores[: known + solved] = 1.0
            for number in range(draws):
                names = [f"{kind} {known} {number}" for kind in ("probe", "none")]
                tables |= {
                    names[0]: EpisodeTable(ids, scores, names[0]),
                    names[1]: EpisodeTable(ids, 0 * scores, names[1]),
                }
                pair = [standing(name, {}) for name in names]
                compared = family.family(pair, "PTC@CTC-3", section_of).compare(*pair)
                counts[solved, classes.index(compared.difference.p)] += 1
        joint = counts / counts.sum()
        expected = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0, keepdims=True)
        told = float((joint[joint > 0] * np.log2(joint[joint > 0] / expected[joint > 0])).sum())
        most = max(most, told)
    chance = (len(classes) - 1) / (2 * draws * 2 * math.log(2))  # what as many draws show of nothing, on average
    assert most < math.log2(1 + 0.25 / TEST_NOISE**2) / 2 + 4 * chance


def test_the_bits_are_those_that_security_md_states() -> None:
    lines = Path("SECURITY.md").read_text().splitlines()
    for column, episodes in ((3, 1205), (4, 60)):
        figure = figure_bits(episodes)
        run = FIGURES * figure + REST_BITS
        for name, bits, digits in (
            ("figure", figure, 3), ("rows", FIGURES * figure, 2), ("groups", GROUP_BITS, 2), ("tests", TEST_BITS, 2),
            ("run", run, 2), ("day", DAY * run, 2),
        ):  # fmt: skip
            (line,) = (line for line in lines if line.startswith(f"| {name} "))
            said = float(line.split("|")[column].strip())
            assert bits <= said < bits + 2.1 * 10**-digits, (name, bits)
