"""A short run of the soak test."""

import importlib
import json
import signal
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from tests.postgres import binaries


@pytest.fixture
def soak() -> Iterator[ModuleType]:
    """The script as a module: in this process its servers and clients are forked, which spares many slow starts."""
    before = signal.getsignal(signal.SIGTERM)
    yield importlib.import_module("benchmarks.soak.run")
    signal.signal(signal.SIGTERM, before)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("database", "workers", "more"),
    [("sqlite", "2", ()), ("postgresql", "1", ("--hosted", "--rude", "12", "--spread", "0.1"))],
)
def test_short_soak_with_two_kills_has_no_mismatches(
    soak: ModuleType,
    database: str,
    workers: str,
    more: tuple[str, ...],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ARRAMON_STEPS", "60")  # Shorter runs are hit by as many faults.
    if database == "postgresql":
        binaries()
    options = ["--kills", "2", "--clients", "2", "--minutes", "2", "--patience", "300", *more]
    status = soak.main([*options, "--database", database, "--workers", workers, "--json", str(tmp_path / "figures")])
    assert status == 0, capsys.readouterr().out
    figures = json.loads((tmp_path / "figures").read_text())
    assert figures["faults"]["server killed"] == 2
    assert figures["runs"] >= 2
    assert figures["mismatches"] == 0
    assert figures["streams ended rudely"] == (12 if more else 0)
