"""Heartbeats of a process: late ones are warned of."""

from contextlib import closing
from pathlib import Path
from types import SimpleNamespace

import pytest

from arramon_server.runs.play import upkeep
from arramon_server.runs.storage.records import LEASE
from tests.runs.engines import Backend


@pytest.mark.parametrize(("seconds", "expected"), [(LEASE - 1.0, 0), (LEASE + 3.0, 1)])
def test_a_heartbeat_that_others_missed_causes_one_warning(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    seconds: float,
    expected: int,
) -> None:
    now = 1000.0
    monkeypatch.setattr(upkeep, "time", SimpleNamespace(monotonic=lambda: now))
    backend = Backend(tmp_path)
    with closing(backend.database):
        kept = upkeep.Upkeep(backend.journal, backend.activity, [], worker="w", address="")
        kept.start()
        for passed in (1.0, seconds, 1.0):
            now += passed
            kept.sweep([])
    late = f"no heartbeat for {seconds:.0f} seconds: other processes may have taken over episodes"
    assert [record.getMessage() for record in caplog.records] == [late] * expected
