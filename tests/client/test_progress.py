"""Display of a run's progress."""

import io

import pytest
from rich.console import Console

from arramon_client.play import Progress
from arramon_client.progress import PaceEstimator, progress_display, progress_lines


class Clock:
    """Clock that is advanced manually."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.mark.parametrize(("seconds", "state", "text"), [
    (10.0, Progress(100, 20, 500), "50 steps/s, 1 min 20 s left"),
    (10.0, Progress(10_000, 20, 500), "50 steps/s, 2 h 46 min left"),
    (10.0, Progress(100, 10, 500), "50 steps/s"),
    (10.0, Progress(100, 100, 500), "50 steps/s"),
    (8.0, Progress(12, 11, 4), "0 steps/s, 8 s left"),
])  # fmt: skip
def test_pace_is_measured_from_its_start(seconds: float, state: Progress, text: str) -> None:
    clock = Clock()
    pace = PaceEstimator(clock)
    pace.describe(Progress(state.episodes, 10, 0))
    clock.now += seconds
    assert pace.describe(state) == text


def test_without_a_terminal_a_line_is_printed_every_ten_seconds() -> None:
    clock, output = Clock(), io.StringIO()
    show = progress_lines(Console(file=output, width=100), clock)
    for step in range(51):
        clock.now = 100.0 + step / 2
        show(Progress(10, step // 10, step))
    assert output.getvalue().splitlines() == [
        "2 of 10 episodes, 2 steps/s, 40 s left",
        "4 of 10 episodes, 2 steps/s, 30 s left",
    ]


def test_a_terminal_shows_a_bar_and_quiet_shows_nothing() -> None:
    for quiet, seen in ((False, True), (True, False)):
        output = io.StringIO()
        with progress_display(Console(file=output, force_terminal=True, width=100), quiet=quiet) as show:
            show(Progress(10, 3, 7))
        assert ("3/10" in output.getvalue()) is seen
