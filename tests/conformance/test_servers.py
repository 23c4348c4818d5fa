"""Conformance of the project's servers: embedded, hosted with TLS and token, and two hosts behind a proxy."""

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from arramon_client import cli
from arramon_client.conformance.checks import CHECKS
from arramon_client.local.embedded import embedded_server
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import Role
from arramon_server.runs.storage.database import Database
from tests import tiny
from tests.api.people import token_of
from tests.certificates import Authority
from tests.proxy import Proxies
from tests.serving import Server


def skipped(folder: Path, *options: str) -> set[str]:
    """Run all checks, of which none may fail; returns the names of those skipped."""
    path = folder / "results.json"
    status = cli.main(["conformance", "--json", str(path), *options])
    results = json.loads(path.read_text())["checks"]
    assert [(each["name"], each["reason"]) for each in results if each["outcome"] == "failed"] == []
    assert status == 0
    assert len(results) == len(CHECKS)
    return {each["name"] for each in results if each["outcome"] == "skipped"}


def write(data: Path) -> None:
    tiny.write(data)
    tiny.write(data, "secret", 3, hidden=True)


def test_embedded_server_conforms(tmp_path: Path) -> None:
    write(tmp_path)
    with embedded_server(tmp_path, options=("--no-fsync", "--step-seconds", "0", "--steps", "8")) as server:
        found = skipped(tmp_path, "--server", server.address)
    assert found == {
        "information.open",
        "runs.account",
        "notes.private",
        "refusals.anonymous",
    }  # All the anonymous are let in here.


def test_hosted_server_with_tls_and_token_conforms(tmp_path: Path) -> None:
    write(tmp_path)
    authority = Authority()
    certificate, key = authority.sign(tmp_path)
    (tmp_path / "ca.pem").write_bytes(authority.pem)
    (tmp_path / "token").write_text(token_of(tmp_path, "ann"))
    tls = ("--tls-certificate", str(certificate), "--tls-key", str(key))
    limits = ("--steps", "8", "--runs-at-once", "2", "--runs-per-day", str(sum(check.runs for check in CHECKS)))
    server = Server(tmp_path, "127.0.0.1:0", *tls, *limits, "--no-anonymous", "--no-fsync", "--workers", "2")
    try:
        way_in = ("--token-file", str(tmp_path / "token"), "--tls-ca", str(tmp_path / "ca.pem"))
        assert skipped(tmp_path, "--server", server.address, *way_in) == {"images.shared"}
    finally:
        assert server.stop() == 0


@pytest.fixture
def hosts(postgres_url: str, tmp_path: Path) -> Iterator[list[Server]]:
    hosts: list[Server] = []
    try:
        for number, listen in enumerate(("127.0.0.2:0", "127.0.0.3:0")):
            data = tmp_path / f"host-{number}"
            write(data)
            shared = ["--journal", postgres_url, "--signing-key", str(tmp_path / "key.pem"), "--steps", "8"]
            hosts.append(Server(data, listen, *shared, "--trust-proxy", log=tmp_path / f"log-{number}"))
        yield hosts
    finally:
        assert {host.stop() for host in hosts} <= {0}


@pytest.mark.slow
def test_two_hosts_behind_a_proxy_conform(
    hosts: list[Server], proxies: Proxies, postgres_url: str, tmp_path: Path
) -> None:
    proxy = proxies.start([host.address for host in hosts])
    with closing(Database(postgres_url)) as database:
        (tmp_path / "token").write_text(Accounts(database).create_token("ann", Role.PARTICIPANT))
    way_in = ("--token-file", str(tmp_path / "token"), "--tls-ca", str(proxy.authority))
    assert skipped(tmp_path, "--server", proxy.address, *way_in) == {"images.shared"}
