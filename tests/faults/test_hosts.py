"""Two hosts behind an nginx with one PostgreSQL: a run survives the loss of a host or the proxy."""

import signal
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.transport.access import Access
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import Role
from arramon_server.runs.storage.database import Database
from tests import tiny
from tests.api.people import Person
from tests.api.player import Player, create
from tests.faults.clients import EPISODES, UndisturbedRun, check_same, client, finish, played_on, results, run_id
from tests.proxy import Proxies, Proxy
from tests.serving import METADATA, Server

pytestmark = pytest.mark.slow


@pytest.fixture
def hosts(postgres_url: str, tmp_path: Path) -> Iterator[list[Server]]:
    hosts: list[Server] = []
    try:
        for number, listen in enumerate(("127.0.0.2:0", "127.0.0.3:0")):
            data = tmp_path / f"host-{number}"
            tiny.write(data, count=EPISODES)
            shared = ["--journal", postgres_url, "--signing-key", str(tmp_path / "key.pem")]
            hosts.append(Server(data, listen, *shared, "--trust-proxy", log=tmp_path / f"log-{number}"))
        yield hosts
    finally:
        assert {host.stop() for host in hosts} <= {0}


@pytest.fixture
def proxy(hosts: list[Server], proxies: Proxies) -> Proxy:
    return proxies.start([host.address for host in hosts])


@pytest.fixture
def token(hosts: list[Server], postgres_url: str) -> str:
    with closing(Database(postgres_url)) as database:
        return Accounts(database).create_token("ann", Role.PARTICIPANT)


@pytest.fixture
def way_in(proxy: Proxy, token: str, tmp_path: Path) -> list[str]:
    """What a client needs beside the address."""
    path = tmp_path / "token"
    path.write_text(token)
    return ["--token-file", str(path), "--tls-ca", str(proxy.authority)]


def test_run_survives_killed_hosts_and_a_restarted_proxy(
    hosts: list[Server],
    proxy: Proxy,
    way_in: list[str],
    postgres_url: str,
    tmp_path: Path,
    undisturbed_run: UndisturbedRun,
) -> None:
    process = client(proxy.address, tmp_path / "disturbed", *way_in)
    try:
        run = run_id(process)
        recorded = played_on(postgres_url, run, 0)
        proxy.stop()
        proxy.start()
        recorded = played_on(postgres_url, run, recorded)
        for host in hosts:
            host.kill()
            recorded = played_on(postgres_url, run, recorded)
            # A host takes its time to start; the run is to be alive when the other one goes.
            process.send_signal(signal.SIGSTOP)
            host.start()
            process.send_signal(signal.SIGCONT)
        said = finish(process)
    finally:
        process.kill()
        process.communicate()
    assert "retrying" in said  # Once for several losses if the client was still connecting again.
    check_same(postgres_url, undisturbed_run, results(tmp_path / "disturbed"))


def test_streams_behind_a_proxy_share_a_run_without_server_addresses(
    hosts: list[Server], proxy: Proxy, token: str
) -> None:
    access = Access(token=token, authority=proxy.authority.read_bytes())
    with Person(proxy.address, access=access) as ann:
        info = ann.stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)
        assert list(info.addresses) == []
        run = create(ann.stub)
        with Player(ann.stub, run.run_id, 2, player="a") as a, Player(ann.stub, run.run_id, 2, player="b") as b:
            seen = [player.observation().episode_id for player in (a, a, b, b)]
            assert len(set(seen)) == 4


def test_proxy_keeps_silent_and_long_streams_open(hosts: list[Server], proxy: Proxy, token: str) -> None:
    access = Access(token=token, authority=proxy.authority.read_bytes())
    with Person(proxy.address, access=access) as ann:
        run = create(ann.stub)
        with Player(ann.stub, run.run_id, player="p") as player:
            episode_id = player.observation().episode_id
            time.sleep(3.0)  # a second is what nginx waits for, here, in all that our file does not say
            player.act(episode_id, 0, tiny.L)
            assert player.observation().step == 1
            for _ in range(100):
                player.send([pb.Act(episode_id="none", forfeit=pb.Forfeit(reason="x" * 10_000))])
                assert player.problem().code == pb.Problem.CODE_NOT_YOUR_EPISODE
            player.act(episode_id, 1, tiny.L)
            assert player.observation().step == 2
