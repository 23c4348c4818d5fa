"""Display of a run's progress: a progress bar on a terminal, otherwise a line every few seconds."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.progress import Progress as Bar

from arramon_client.output import episodes_text
from arramon_client.play import Progress

LINE_EVERY = 10.0
"""Minimum number of seconds between two lines, without a terminal."""

Show = Callable[[Progress], None]


class PaceEstimator:
    """Estimator of steps per second and remaining time, measured from its creation."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._started = clock()
        self._ended_before: int | None = None

    def describe(self, state: Progress) -> str:
        """Describe the pace, for example "152 steps/s, 3 min 20 s left"."""
        if self._ended_before is None:
            self._ended_before = state.ended
        seconds = max(self._clock() - self._started, 1e-9)
        text = f"{state.steps / seconds:.0f} steps/s"
        ended = state.ended - self._ended_before
        if ended > 0 and state.ended < state.episodes:
            text += f", {_duration((state.episodes - state.ended) * seconds / ended)} left"
        return text


@contextmanager
def progress_display(console: Console, *, quiet: bool = False) -> Iterator[Show]:
    """Yield a callback that displays progress until the end of the context."""
    if quiet:
        yield lambda _: None
    elif console.is_terminal:
        with _bar(console) as show:
            yield show
    else:
        yield progress_lines(console)


@contextmanager
def _bar(console: Console) -> Iterator[Show]:
    pace = PaceEstimator()
    columns = (TextColumn("episodes"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[pace]}"))
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task("play", total=None, pace="")

        def show(state: Progress) -> None:
            bar.update(task, total=state.episodes, completed=state.ended, pace=pace.describe(state))

        yield show


def progress_lines(console: Console, clock: Callable[[], float] = time.monotonic) -> Show:
    """Return a callback that prints a progress line at most every ten seconds."""
    pace, last = PaceEstimator(clock), clock()

    def show(state: Progress) -> None:
        nonlocal last
        text = pace.describe(state)
        if clock() - last >= LINE_EVERY:
            last = clock()
            console.print(f"{state.ended} of {episodes_text(state.episodes)}, {text}", highlight=False)

    return show


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"
