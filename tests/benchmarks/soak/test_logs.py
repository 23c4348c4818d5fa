"""What the soak test makes of logs."""

from pathlib import Path

import pytest

from benchmarks.soak.logs import unexplained, warnings

LOG = """\
{"level": "info", "message": "call ended"}
{"level": "error", "message": "/arramon.v1.Evaluation/Play failed: the journal cannot be used: connection lost"}
{"level": "warning", "message": "another process of this server has taken over episode '7'"}
{"level": "error", "message": "worker 1 died with status -11, 1 times in a row; restarting it"}
Fatal Python error: Segmentation fault
"""

AWAY = "error: /arramon.v1.Evaluation/Play failed: the journal cannot be used: connection lost"
TAKEN = "warning: another process of this server has taken over episode '7'"
DIED = "error: worker 1 died with status -11, 1 times in a row; restarting it"
FATAL = "no JSON: Fatal Python error: Segmentation fault"


@pytest.mark.parametrize(
    ("faults", "expected"),
    [
        ([], [AWAY, TAKEN, DIED, FATAL]),
        (["server killed", "client killed"], [AWAY, TAKEN, DIED, FATAL]),
        (["database ended"], [TAKEN, DIED, FATAL]),
        (["server paused"], [DIED, FATAL]),
    ],
)
def test_only_injected_faults_explain_warnings(faults: list[str], expected: list[str], tmp_path: Path) -> None:
    (tmp_path / "log-0").write_text(LOG)
    assert unexplained(warnings(tmp_path), faults) == expected
