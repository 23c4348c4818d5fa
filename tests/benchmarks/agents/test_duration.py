"""How long agents take, from clients that really play."""

from argparse import Namespace
from pathlib import Path

import pytest

from benchmarks.agents.duration import play
from tests import tiny


def test_clients_in_both_languages_are_timed(tmp_path: Path) -> None:
    tiny.write(tmp_path, "val_seen", 2)
    given = Namespace(data=tmp_path, split="val_seen", episodes=1, parallel=1)
    seconds, steps, start = play("stop", given)
    assert steps == 2 * 2 * (150 + 1)  # In two languages, two turns: a street to the step limit, and a room.
    assert 0.0 < seconds < start


def test_what_a_failed_client_says_is_told(tmp_path: Path) -> None:
    given = Namespace(data=tmp_path, split="val_seen", episodes=1, parallel=1)
    with pytest.raises(SystemExit, match="nowhere did not play to the end:\nerror: no agent"):
        play("nowhere", given)
