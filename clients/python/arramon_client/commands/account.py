"""The command `arramon-client account`: show the caller's account on a server, with its limits and usage."""

import argparse
from collections.abc import Sequence

from google.protobuf.json_format import MessageToDict
from rich.table import Table

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.commands.base import run
from arramon_client.output import console, print_json
from arramon_client.transport.access import access_of, add_access
from arramon_client.transport.connection import call, connect

LIMITS = (
    ("runs in 24 hours", "runs_today", "runs_per_day"),
    ("runs in total", "runs", "runs_in_all"),
    ("running", "running", "runs_at_once"),
    ("streams", "streams", "streams_at_once"),
)
"""Limits of an account: column title, field of `Quota` with the usage, and field with the limit."""


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="arramon-client account", allow_abbrev=False, description="Show your account on a server."
    )
    parser.add_argument("--server", required=True, metavar="ADDR", help="host:port or unix:/path")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    add_access(parser)
    return run(parser, argv, _show)


def _show(options: argparse.Namespace) -> None:
    with connect(options.server, access_of(options)) as server:
        account = call(server.stub.GetAccount, pb.GetAccountRequest(), server.address)
    role = pb.Role.Name(account.role).removeprefix("ROLE_").lower()
    if options.json:
        quotas = [
            MessageToDict(each, preserving_proto_field_name=True, always_print_fields_with_no_presence=True)
            for each in account.quotas
        ]
        print_json({"participant": account.participant, "role": role, "quotas": quotas})
        return
    shown = console(80)
    shown.print(f"{account.participant or 'no participant name'} ({role})")
    if account.quotas:
        shown.print(_table(account.quotas))


def _table(quotas: Sequence[pb.Quota]) -> Table:
    table = Table("split", *(title for title, _, _ in LIMITS))
    for quota in quotas:
        table.add_row(quota.split, *(f"{getattr(quota, used)} of {_limit(quota, limit)}" for _, used, limit in LIMITS))
    return table


def _limit(quota: pb.Quota, name: str) -> str:
    return str(getattr(quota, name) or "unlimited")
