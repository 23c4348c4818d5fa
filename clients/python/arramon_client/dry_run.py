"""The dry run: two episodes of an open split, played with the settings of the real run."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from arramon.v1 import evaluation_pb2
from arramon_client.errors import ArramonClientError, UsageError
from arramon_client.transport.connection import Server, call

LONGEST_NAME = 200
"""Characters in an agent's name that servers accept."""

EPISODES = 2
"""Episodes of a dry run: enough to play in parallel, and few enough to take about a minute."""

FOLDER = "dry-run"
"""Name of the subfolder for a dry run's results."""

NAME_SUFFIX = " (dry run)"
"""Suffix of the agent's name in a dry run, which marks it in lists of runs on any server."""

STOP_TIMEOUT = 3.0
"""Seconds that an interrupted dry run may take to be cancelled; usually it takes some milliseconds."""


def dry_run_name(agent: str) -> str:
    """Return the agent's name with the suffix that marks a dry run."""
    return agent[: LONGEST_NAME - len(NAME_SUFFIX)] + NAME_SUFFIX


def choose_dry_run_split(
    info: evaluation_pb2.ServerInfo, real: evaluation_pb2.Split, language: str, sensors: Sequence[str]
) -> evaluation_pb2.Split:
    """Return the open split of a dry run: the real run's split if it is open, else the server's first suitable one.

    Args:
        info: the server's information.
        real: split of the run that the dry run tests.
        language: language of the instructions.
        sensors: sensors of the real run.

    Raises:
        UsageError: if the server has no open split with that language and these sensors.
    """
    for split in (real, *info.splits):
        if not split.hidden and language in split.episodes and set(sensors) <= set(split.sensors):
            return split
    needs = f", with the sensors {', '.join(sensors)}" if sensors else ""
    raise UsageError(
        f"the server has no open split in {language!r}{needs}, and {real.name!r} is hidden: a dry run needs an open "
        "split. Test the agent on this machine instead: --dry-run without --server and --split"
    )


@contextmanager
def cancelled_unless_played(server: Server, run_id: str) -> Iterator[None]:
    """Cancel a dry run that is interrupted, so that it does not stay open among the participant's runs."""
    played = False
    try:
        yield
        played = True
    finally:
        if not played:
            with suppress(ArramonClientError):  # The original error is shown; the server may be unreachable.
                request = evaluation_pb2.CancelRunRequest(run_id=run_id)
                call(server.stub.CancelRun, request, server.address, timeout=STOP_TIMEOUT)
