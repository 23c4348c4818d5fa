"""Callers of a real server, with or without a token, and their stubs."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import grpc

from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon.v1.leaderboard_pb2_grpc import LeaderboardStub
from arramon_client.transport.access import Access
from arramon_client.transport.channel import open_channel
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import Role
from arramon_server.runs.storage.database import Database


@contextmanager
def accounts(data: Path) -> Iterator[Accounts]:
    """The accounts in a data folder's journal, as the host's command line has them."""
    database = Database(f"sqlite:///{data / 'journal.db'}")
    try:
        yield Accounts(database)
    finally:
        database.close()


def token_of(data: Path, participant: str, role: Role = Role.PARTICIPANT, **fields: float) -> str:
    """A new token."""
    with accounts(data) as kept:
        return kept.create_token(participant, role, days=fields.get("days"))


def id_of(token: str) -> str:
    """Its public part."""
    return token.split("_")[1]


class Person:
    """Somebody who calls a server, with a token or without."""

    def __init__(self, address: str, token: str = "", access: Access | None = None) -> None:
        self.channel: grpc.Channel = open_channel(address, access or Access(token=token), ())
        self.stub, self.board = EvaluationStub(self.channel), LeaderboardStub(self.channel)

    def __enter__(self) -> "Person":
        return self

    def __exit__(self, *_: object) -> None:
        self.channel.close()
