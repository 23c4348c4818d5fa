"""The command that opens one stream and ends it rudely."""

from tests.benchmarks.command import run

MODULE = "benchmarks.soak.rude_stream"


def test_a_stream_without_a_server_is_told() -> None:
    done = run(MODULE, "127.0.0.1:1", "0" * 32, "deadline")
    assert done.returncode == 1
    assert done.stderr.startswith(("UNAVAILABLE: ", "DEADLINE_EXCEEDED: "))


def test_bad_arguments_are_told() -> None:
    assert "invalid choice: 'politely'" in run(MODULE, "127.0.0.1:1", "0" * 32, "politely").stderr
    done = run(MODULE, "127.0.0.1:1", "0" * 32, "killed", "token")
    assert done.returncode == 2
    assert "expected the file of the authority, too" in done.stderr
