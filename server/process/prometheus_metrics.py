"""Metrics for Prometheus. Labels have few values: never a run, a participant or an address.

Processes on one machine share a folder, named by `PROMETHEUS_MULTIPROC_DIR` before this module is imported; each of
them then reports the sum over all processes.
"""

import os
import resource
import sys
from collections.abc import Callable, Iterable, Mapping

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.exposition import CONTENT_TYPE_LATEST
from prometheus_client.metrics_core import GaugeMetricFamily, Metric
from prometheus_client.multiprocess import MultiProcessCollector
from prometheus_client.registry import Collector

from arramon_server import __version__
from arramon_server.runs.storage.meter import Meter, Stage

FOLDER = "PROMETHEUS_MULTIPROC_DIR"

CONTENT_TYPE = CONTENT_TYPE_LATEST

_SECONDS = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0)


class PrometheusMetrics(Meter):
    """All metrics of one process.

    Args:
        camera: name of the camera.
        runs: returns the number of runs by state; called whenever the metrics are read.
    """

    def __init__(self, camera: str, runs: Callable[[], Mapping[str, int]]) -> None:
        disable_created_metrics()  # type: ignore[no-untyped-call]
        own = CollectorRegistry()
        self._registry = CollectorRegistry()
        if os.environ.get(FOLDER):
            MultiProcessCollector(self._registry)  # type: ignore[no-untyped-call]
        else:
            ProcessCollector(registry=own)
            self._registry = own
        self._registry.register(_JournalCollector(runs))

        def counter(name: str, meaning: str, *labels: str) -> Counter:
            return Counter(f"arramon_{name}", meaning, labels, registry=own)

        def gauge(name: str, meaning: str) -> Gauge:
            return Gauge(f"arramon_{name}", meaning, registry=own, multiprocess_mode="livesum")

        self._runs_created = counter("runs_created", "Runs created")
        self._runs_ended = counter("runs_ended", "Runs ended, by state", "state")
        self._episodes_ended = counter("episodes_ended", "Episodes ended, by cause", "cause")
        self._reoffered = counter("episodes_reoffered", "Episodes offered again after a process died")
        self._steps = counter("steps", "Steps committed")
        self._frames = counter("frames", "Frames drawn, by camera", "camera").labels(camera)
        self._faults = counter("faults", "Faults of the server, by kind", "kind")
        self._rpcs = counter("rpcs", "Calls ended, by method and status", "method", "status")
        seconds = Histogram(
            "arramon_stage_seconds", "Time by stage of a step", ("stage",), buckets=_SECONDS, registry=own
        )
        self._stages = {stage: seconds.labels(stage.value) for stage in Stage}
        self._streams = gauge("streams_open", "Streams open")
        self._episodes = gauge("episodes_open", "Episodes open")
        self._queue = gauge("messages_waiting", "Messages of streams that wait to be handled")
        self._memory = gauge("memory_bytes", "Peak memory of each process, summed over processes")
        self._ready = gauge("processes_ready", "Processes that are ready for calls")

    def run_created(self) -> None:
        """Count a created run."""
        self._runs_created.inc()

    def run_ended(self, state: str) -> None:
        """Count an ended run by its state."""
        self._runs_ended.labels(state).inc()

    def episode_ended(self, cause: str) -> None:
        """Count an ended episode by its cause."""
        self._episodes_ended.labels(cause).inc()

    def count_reoffers(self, episodes: int) -> None:
        """Count episodes that were offered again after their process had died."""
        self._reoffered.inc(episodes)

    def count_steps(self, steps: int) -> None:
        """Count committed steps."""
        self._steps.inc(steps)

    def record_duration(self, stage: Stage, seconds: float) -> None:
        """Record the duration of a stage."""
        self._stages[stage].observe(seconds)
        if stage is Stage.DRAW:
            self._frames.inc()

    def count_fault(self, kind: str) -> None:
        """Count a server fault by its kind."""
        self._faults.labels(kind).inc()

    def record_load(self, streams: int, episodes: int, waiting: int) -> None:
        """Record the numbers of open streams, open episodes and waiting messages."""
        self._streams.set(streams)
        self._episodes.set(episodes)
        self._queue.set(waiting)
        self._memory.set(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024))

    def count_call(self, method: str, status: str) -> None:
        """Count an ended call."""
        self._rpcs.labels(method, status).inc()

    def note_ready(self, ready: bool) -> None:
        """Record whether this process is ready for calls."""
        self._ready.set(ready)

    def text(self) -> bytes:
        """Return all metrics in Prometheus's format. This queries the database, so do not call it on the event loop."""
        return generate_latest(self._registry)


class _JournalCollector(Collector):
    """Collector of metrics that are computed on demand: the runs in the journal, and the version."""

    def __init__(self, runs: Callable[[], Mapping[str, int]]) -> None:
        self._runs = runs

    def collect(self) -> Iterable[Metric]:
        """Return the metrics."""
        runs = GaugeMetricFamily("arramon_runs", "Runs in the journal, by state", labels=["state"])
        for state, number in self._runs().items():
            runs.add_metric([state], number)
        info = GaugeMetricFamily("arramon_info", "The server's version", labels=["version"])
        info.add_metric([__version__], 1)
        return [runs, info]
