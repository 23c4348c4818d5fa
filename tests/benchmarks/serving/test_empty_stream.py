"""Speed of an empty gRPC stream."""

from tests.benchmarks.command import numbers, printed


def test_messages_are_answered() -> None:
    lines = printed("benchmarks.serving.empty_stream", "--seconds", 0.2, "--together", 4)
    messages, steps, server, client = numbers(lines[1:], "")
    assert abs(steps - 4 * messages) <= 4  # They are rounded.
    assert messages > 0
    assert min(server, client) >= 0
