"""Memory and latency of several open streams."""

from pathlib import Path

from tests.benchmarks.command import numbers, printed


def test_more_streams_than_episodes_are_left_out(many: Path) -> None:
    lines = printed("benchmarks.serving.streams", "--data", many, "--streams", 2, 33, "--seconds", 0.2)
    assert lines[0] == "33 streams need as many episodes; split tiny has 32"
    assert lines[1].split() == [
        "streams",
        "idle",
        "MB",
        "MB",
        "a",
        "stream",
        "playing",
        "MB",
        "steps/s",
        "p50",
        "ms",
        "p99",
        "ms",
    ]
    streams, idle, _, playing, rate, p50, p99 = numbers(lines[2:], "")
    assert streams == 2
    assert min(idle, playing) > 50
    assert rate > 0
    assert 0 < p50 <= p99
