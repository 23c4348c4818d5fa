"""CPU time of a server with metrics and of one without."""

from pathlib import Path

from arramon_server.process.prometheus_metrics import PrometheusMetrics
from arramon_server.runs.storage.meter import Meter
from tests.benchmarks.command import numbers, printed


def test_ratios(many: Path) -> None:
    arguments = "--data", many, "--seconds", 0.2, "--rounds", 1, "--parallel", 2
    lines = printed("benchmarks.serving.metering", *arguments)
    for what in ("server CPU per step", "steps per second"):
        median, only_round = numbers(lines, f"   2 episodes, {what}")
        assert median == only_round > 0


def test_metrics_count_what_is_replaced() -> None:
    """Otherwise both servers would measure alike."""
    hooks = [name for name in vars(Meter) if not name.startswith("_")]
    assert hooks
    assert all(getattr(PrometheusMetrics, name) is not getattr(Meter, name) for name in hooks)
