"""Probes, metrics and pages over HTTP: their addresses, and what readiness checks."""

import asyncio
import http.client
import socket
import ssl
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest

from arramon_server.configuration.config import Config
from arramon_server.errors import StorageError, Unavailable
from arramon_server.process.health import check
from arramon_server.process.readiness import NO_DATABASE, STUCK_SECONDS, Readiness
from tests import tiny
from tests.certificates import Authority
from tests.postgres import Cluster
from tests.serving import Server


def places(server: Server) -> dict[str, str]:
    """What is served where over HTTP, as the server says at its start."""
    reported = (line.partition(" at ") for line in server.said if " at http" in line)
    return {name: address for name, _, address in reported}


def get(address: str, path: str) -> tuple[int, str, str]:
    host = address.rpartition("/")[2]
    connection = http.client.HTTPConnection(host, timeout=120)
    try:
        connection.request("GET", path)
        response = connection.getresponse()
        return response.status, response.headers["Content-Type"], response.read().decode()
    finally:
        connection.close()


@pytest.mark.parametrize(
    ("flags", "served", "loaded"),
    [
        ((), set(), set()),
        (("--workers", "2"), set(), set()),
        (("--web", "127.0.0.1:0"), {"pages", "metrics"}, {"aiohttp", "jinja2"}),
    ],
)
def test_page_libraries_are_imported_only_where_pages_are_served(
    tmp_path: Path, flags: tuple[str, ...], served: set[str], loaded: set[str]
) -> None:
    tiny.write(tmp_path)
    log = tmp_path / "imports"
    server = Server(tmp_path, "127.0.0.1:0", *flags, log=log, environment={"PYTHONPROFILEIMPORTTIME": "1"})
    assert set(places(server)) == served
    assert server.stop() == 0
    imported = {line.rpartition("|")[2].strip() for line in log.read_text().splitlines()}
    assert imported & {"aiohttp", "jinja2", "grpc"} == {"grpc", *loaded}


def test_probes_metrics_and_pages_share_one_address(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--web", "127.0.0.1:0")
    try:
        found = places(server)
        assert found["pages"] == found["metrics"]
        assert get(found["pages"], "/healthz")[::2] == (200, "alive\n")
        assert get(found["pages"], "/readyz")[::2] == (200, "ready\n")
        status, kind, text = get(found["pages"], "/metrics")
        assert (status, kind.split(";")[0]) == (200, "text/plain")
        assert "arramon_processes_ready 1.0" in text.splitlines()
        assert get(found["pages"], "/en/")[0] == 200
        assert get(found["pages"], "/nothing")[0] == 404
    finally:
        assert server.stop() == 0


def test_metrics_can_have_their_own_address(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--web", "127.0.0.1:0", "--metrics", "[::1]:0")
    try:
        found = places(server)
        assert get(found["metrics"], "/metrics")[0] == 200
        assert get(found["metrics"], "/readyz")[0] == 200
        assert get(found["metrics"], "/en/")[0] == 404
        assert get(found["pages"], "/metrics")[0] == 404
    finally:
        assert server.stop() == 0


@pytest.mark.parametrize(
    ("web", "metrics", "expected"),
    [
        ("", "", ""),
        ("127.0.0.1:80", "", "127.0.0.1:80"),
        ("10.0.0.1:80", "", ""),
        ("0.0.0.0:80", "", ""),
        ("0.0.0.0:80", "0.0.0.0:80", "0.0.0.0:80"),
        ("", "10.0.0.1:90", "10.0.0.1:90"),
    ],
)
def test_metrics_are_public_only_if_configured(web: str, metrics: str, expected: str) -> None:
    assert Config(web=web, metrics=metrics).metrics_address == expected


def test_web_address_in_use_is_reported(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        address = f"127.0.0.1:{other.getsockname()[1]}"
        with pytest.raises(AssertionError, match=f"cannot listen on '{address}'"):
            Server(tmp_path, "127.0.0.1:0", "--web", address)


def test_pages_use_the_servers_certificate(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    authority = Authority()
    certificate, key = authority.sign(tmp_path)
    options = ("--tls-certificate", str(certificate), "--tls-key", str(key))
    server = Server(tmp_path, "127.0.0.1:0", "--web", "127.0.0.1:0", *options)
    try:
        address = places(server)["pages"]
        assert address.startswith("https://")
        assert get_over_tls(address, authority) == "ready\n"
        later = Authority()
        later.sign(tmp_path)  # the same files, renewed
        assert get_over_tls(address, later) == "ready\n"
        with pytest.raises(urllib.error.URLError, match="CERTIFICATE_VERIFY_FAILED"):
            get_over_tls(address, authority)
    finally:
        assert server.stop() == 0


def get_over_tls(address: str, authority: Authority) -> str:
    context = ssl.create_default_context(cadata=authority.pem.decode())
    with urllib.request.urlopen(address + "/readyz", timeout=120, context=context) as response:
        said: str = response.read().decode()
    return said


@pytest.mark.slow
def test_health_follows_a_database_outage_and_recovery(postgres_url: str, cluster: Cluster, tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--web", "127.0.0.1:0", "--journal", postgres_url)

    def wait_for(status: int) -> None:
        until = time.monotonic() + 240
        while get(places(server)["pages"], "/readyz")[0] != status:
            assert time.monotonic() < until, f"readiness is not {status} after a minute"
            time.sleep(0.2)

    try:
        wait_for(200)
        cluster.stop()
        try:
            wait_for(503)
            with pytest.raises(Unavailable, match="reports NOT_SERVING"):
                check(server.address)
            assert get(places(server)["pages"], "/healthz")[0] == 200
            assert get(places(server)["metrics"], "/metrics")[0] == 200
        finally:
            cluster.start()
        wait_for(200)
        check(server.address)
    finally:
        assert server.stop() == 0


class Fake:
    """A database and an engine that do as they are told."""

    def __init__(self) -> None:
        self.ask: Callable[[], object] = lambda: None
        self.turned = time.monotonic()
        self.reported: list[bool] = []
        self.readiness = Readiness(lambda: self.ask(), lambda: self.turned, self.report)

    async def report(self, ready: bool) -> None:
        self.reported.append(ready)

    def look(self) -> str:
        asyncio.run(self.readiness.check())
        return self.readiness.problem


def gone() -> None:
    raise StorageError("the journal cannot be used: no answer from db.inside.example at port 5432")


def test_readiness_follows_the_database() -> None:
    fake = Fake()
    assert fake.readiness.problem == "the server is starting"
    assert fake.look() == ""
    fake.ask = gone
    assert fake.look() == fake.look() == NO_DATABASE  # strangers may reach the probe: no host, no path
    fake.ask = lambda: None
    assert fake.look() == ""
    assert fake.reported == [True, False, True]


def test_readiness_follows_the_engine() -> None:
    fake = Fake()
    fake.turned -= STUCK_SECONDS + 5
    assert fake.look() == f"the engine has been stuck for {STUCK_SECONDS + 5:.0f} seconds"
    fake.turned = time.monotonic()
    assert fake.look() == ""


def test_draining_server_does_not_become_ready_again() -> None:
    fake = Fake()
    assert fake.look() == ""
    asyncio.run(fake.readiness.drain())
    assert fake.look() == "the server is draining"
    assert fake.reported == [True, False]
