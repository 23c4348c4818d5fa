"""Jumps of the wall clock under a running server."""

from pathlib import Path

import pytest

from tests import tiny
from tests.faults.clients import (
    EPISODES,
    UndisturbedRun,
    check_same,
    client,
    finish,
    journal_url,
    played_on,
    results,
    run_id,
)
from tests.programs import program
from tests.relay import Relay
from tests.serving import Server

JUMPS = ("-1d", "+2h", "-3650d", "+400d", "+0")


class Clock:
    """The time of day that a process is told. What asks how much time has passed is told the truth."""

    def __init__(self, folder: Path) -> None:
        program("faketime", "faketime")
        (library,) = Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1")
        self._file = folder / "clock"
        self.jump("+0")
        self.environment = {
            "LD_PRELOAD": str(library),
            "FAKETIME_TIMESTAMP_FILE": str(self._file),
            "FAKETIME_NO_CACHE": "1",
            "FAKETIME_DONT_FAKE_MONOTONIC": "1",
        }

    def jump(self, offset: str) -> None:
        self._file.write_text(offset)


@pytest.mark.slow
def test_run_survives_wall_clock_jumps(tmp_path: Path, undisturbed_run: UndisturbedRun) -> None:
    clock = Clock(tmp_path)
    tiny.write(tmp_path / "data", count=EPISODES)
    server = Server(tmp_path / "data", log=tmp_path / "log", environment=clock.environment)
    process = client(server.address, tmp_path / "again")
    run, recorded = run_id(process), 0
    for offset in JUMPS:
        recorded = played_on(journal_url(server.data), run, recorded)
        clock.jump(offset)
    finish(process)
    check_same(journal_url(server.data), undisturbed_run, results(tmp_path / "again"))
    assert server.stop() == 0


@pytest.mark.slow
def test_run_moves_between_processes_with_different_clocks(tmp_path: Path, undisturbed_run: UndisturbedRun) -> None:
    """Whether an episode is still held by another process must not hang on whose clock is right."""
    clock = Clock(tmp_path)
    tiny.write(tmp_path / "data", count=EPISODES)
    right = Server(tmp_path / "data", log=tmp_path / "right")
    wrong = Server(tmp_path / "data", log=tmp_path / "wrong", environment=clock.environment)
    with Relay(right.address) as relay:
        process = client(relay.address, tmp_path / "again")
        run, recorded = run_id(process), 0
        for number, offset in enumerate(JUMPS):
            recorded = played_on(journal_url(right.data), run, recorded)
            clock.jump(offset)
            relay.target = (wrong, right)[number % 2].address
            relay.reset()
        finish(process)
    check_same(journal_url(right.data), undisturbed_run, results(tmp_path / "again"))
    assert (right.stop(), wrong.stop()) == (0, 0)
