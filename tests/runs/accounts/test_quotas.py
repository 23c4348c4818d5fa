"""Quotas across processes, each with its own connection, with either kind of database."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from datetime import UTC, datetime
from uuid import uuid4

import pytest

from arramon_server.errors import OverQuota
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import ANONYMOUS, Caller, Role
from arramon_server.runs.accounts.quotas import Quota, Quotas
from arramon_server.runs.accounts.usage import Usage
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING, Run

LIMIT, TRIES, PROCESSES = 3, 12, 4


def run_of(caller: Caller) -> Run:
    return Run(
        run_id=uuid4().hex,
        participant=caller.account or "anonymous",
        agent="a",
        split="s",
        language="en",
        sensors=(),
        steps_per_phase=8,
        data_hash="d",
        server_version="v",
        state=RUNNING,
        created_at=datetime.now(UTC),
        account=caller.account,
    )


@pytest.mark.parametrize("account", ["ann", None])
def test_run_and_stream_limits_hold_across_processes(database_url: str, account: str | None) -> None:
    caller = ANONYMOUS if account is None else Caller(Role.PARTICIPANT, account)
    default = Quota(runs_in_all=LIMIT, streams_at_once=LIMIT)
    with ExitStack() as stack:
        databases = [stack.enter_context(closing(Database(database_url))) for _ in range(PROCESSES)]
        journals = [Journal(database) for database in databases]
        quotas = [Quotas(database, lambda *_: default) for database in databases]
        Accounts(databases[0]).create_token("ann", Role.PARTICIPANT)
        for number, journal in enumerate(journals):
            journal.beat(f"worker {number}", "")
        pool = stack.enter_context(ThreadPoolExecutor(TRIES))

        def create(number: int) -> Run | None:
            process, run = number % PROCESSES, run_of(caller)
            admit = quotas[process].admit_run
            try:
                journals[process].create(run, ["0"], lambda connection: admit(connection, caller, "s"))
            except OverQuota:
                return None
            return run

        made = [run for run in pool.map(create, range(TRIES)) if run is not None]
        assert len(made) == LIMIT

        def join(number: int) -> str | None:
            process = number % PROCESSES
            try:
                return quotas[process].open_stream(caller, made[0], f"player {number}", f"worker {process}")
            except OverQuota:
                return None

        streams = [stream for stream in pool.map(join, range(TRIES)) if stream is not None]
        assert len(streams) == LIMIT
        assert quotas[0].limits_and_usage(caller, "s") == (default, Usage(LIMIT, LIMIT, LIMIT, LIMIT))
        quotas[1].close_stream(streams[0])
        assert quotas[2].limits_and_usage(caller, "s")[1].streams == LIMIT - 1
        assert join(TRIES) is not None
        for journal in journals:
            journal.retire("worker 0")  # whatever it held is free
        assert quotas[0].limits_and_usage(caller, "s")[1].streams < LIMIT
