"""TLS: encrypted calls, untrusting clients, renewed certificates, and invalid files."""

import json
import socket
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import RefusedError, ServerUnreachableError, cli, connect
from arramon_client.transport.access import Access
from arramon_client.transport.connection import call
from arramon_server.configuration.config import Config
from arramon_server.errors import BadInput, Unavailable
from arramon_server.process.health import check
from arramon_server.process.tls import grpc_credentials
from tests import tiny
from tests.api.people import token_of
from tests.certificates import Authority
from tests.serving import Server


def start(folder: Path, *more: str) -> tuple[Server, Authority, str]:
    """A server with TLS, who signed its certificate, and ann's token."""
    tiny.write(folder)
    authority = Authority()
    certificate, key = authority.sign(folder)
    token = token_of(folder, "ann")
    return (
        Server(folder, "127.0.0.1:0", "--tls-certificate", str(certificate), "--tls-key", str(key), *more),
        authority,
        token,
    )


def test_account_and_run_work_over_tls(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    server, authority, token = start(tmp_path, "--runs-per-day", "3", "--no-anonymous")
    (tmp_path / "ca.pem").write_bytes(authority.pem)
    (tmp_path / "token").write_text(token + "\n")
    trusting = ["--server", server.address, "--tls-ca", str(tmp_path / "ca.pem")]
    try:
        assert cli.main(["account", *trusting, "--token-file", str(tmp_path / "token")]) == 0
        said = capsys.readouterr().out
        assert said.startswith("ann (participant)\n")
        assert "0 of 3" in said
        assert "0 of unlimited" in said
        assert cli.main(["account", *trusting]) == 1
        assert "refused authentication: authentication required: no token was sent" in capsys.readouterr().err
        monkeypatch.setenv("ARRAMON_TOKEN", token)
        assert cli.main(["account", *trusting]) == 0
        # The whole of it: a run is created, played on a stream and reported.
        played = ["--agent", "agents.stop", "--lang", "en", "--episodes", "1", "--quiet", "--output", str(tmp_path)]
        assert cli.main([*played, *trusting]) == 0
    finally:
        assert server.stop() == 0


def test_a_client_without_tls_leaves_no_line_of_grpc_in_the_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("GRPC_VERBOSITY", raising=False)
    tiny.write(tmp_path)
    certificate, key = Authority().sign(tmp_path)
    options = ("--tls-certificate", str(certificate), "--tls-key", str(key), "--log-format", "json")
    log = tmp_path / "log"
    server = Server(tmp_path, "127.0.0.1:0", *options, log=log, anew=True)
    host, port = server.address.split(":")
    try:
        with socket.create_connection((host, int(port)), timeout=120) as connection:
            connection.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n")
            assert connection.recv(1) == b""  # The handshake has failed, and the server has closed the connection.
    finally:
        assert server.stop() == 0
    for line in log.read_text().splitlines():
        assert json.loads(line)["message"]


def test_untrusting_and_unencrypted_clients_get_advice(tmp_path: Path) -> None:
    server, authority, token = start(tmp_path)
    try:
        for access, advice in (
            (
                Access(token, tls=True),
                "its certificate is not trusted; if its host gave you a certificate, use --tls-ca",
            ),
            (Access(token, authority=Authority().pem), "its certificate is not trusted"),
            (Access(token, authority=authority.pem, name="elsewhere.example"), "its certificate is for another name"),
            (Access(token), "if it uses TLS, add --tls"),
        ):
            with pytest.raises(ServerUnreachableError, match=advice), connect(server.address, access):
                pass
        with connect(server.address, Access(authority=authority.pem)) as reached:  # anonymous, at the loopback
            assert call(reached.stub.GetAccount, pb.GetAccountRequest(), "here").role == pb.ROLE_ANONYMOUS
        with pytest.raises(RefusedError, match="refused authentication: authentication failed: unknown token"):
            connect(server.address, Access(token[:-1] + "_", authority=authority.pem)).__enter__()
    finally:
        assert server.stop() == 0


def test_tls_client_reports_a_server_without_tls(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path)
    try:
        with (
            pytest.raises(ServerUnreachableError, match="it does not use TLS"),
            connect(server.address, Access(tls=True)),
        ):
            pass
    finally:
        assert server.stop() == 0


def test_health_probe_trusts_only_the_servers_certificate(tmp_path: Path) -> None:
    server, _, _ = start(tmp_path)
    (tmp_path / "other").mkdir()
    other, _ = Authority().sign(tmp_path / "other")
    try:
        check(server.address, tmp_path / "certificate.pem")
        for wrong in (other, None):
            with pytest.raises(Unavailable, match=f"no answer from {server.address}: UNAVAILABLE"):
                check(server.address, wrong)
    finally:
        assert server.stop() == 0


def test_renewed_certificate_is_used_for_new_connections(tmp_path: Path) -> None:
    server, old, token = start(tmp_path)
    try:
        with connect(server.address, Access(token, authority=old.pem)) as before:
            new = Authority()
            new.sign(tmp_path)
            with connect(server.address, Access(token, authority=new.pem)) as after:
                assert call(after.stub.GetAccount, pb.GetAccountRequest(), "here").participant == "ann"
            assert call(before.stub.GetAccount, pb.GetAccountRequest(), "here").participant == "ann"
            (tmp_path / "key.pem").write_text("half a")  # while it is written, the last good one stays
            with connect(server.address, Access(token, authority=new.pem)) as after:
                assert call(after.stub.GetAccount, pb.GetAccountRequest(), "here").participant == "ann"
    finally:
        assert server.stop() == 0


def test_invalid_certificate_and_key_files_are_refused(tmp_path: Path) -> None:
    for name in ("one", "two", "locked"):
        (tmp_path / name).mkdir()
    one = Authority().sign(tmp_path / "one")
    two = Authority().sign(tmp_path / "two")
    locked = Authority().sign(tmp_path / "locked", password=b"sesame")
    text = tmp_path / "text.pem"
    text.write_text("certainly not")
    for certificate, key, said in (
        (one[0], tmp_path / "gone.pem", f"{tmp_path / 'gone.pem'}: cannot be read: No such file or directory"),
        (tmp_path, one[1], f"{tmp_path}: cannot be read: Is a directory"),
        (one[0], two[1], f"{two[1]}: is not the key of the certificate {one[0]}"),
        (text, one[1], f"{text} and {one[1]} are not a certificate and its key in PEM format without a password"),
        (locked[0], locked[1], f"{locked[0]} and {locked[1]} are not a certificate and its key in PEM format without"),
    ):
        with pytest.raises(BadInput) as caught:
            grpc_credentials(Config(data=tmp_path, tls_certificate=certificate, tls_key=key))
        assert str(caught.value).startswith(said)
    assert isinstance(
        grpc_credentials(Config(data=tmp_path, tls_certificate=one[0], tls_key=one[1])), grpc.ServerCredentials
    )
    assert grpc_credentials(Config(data=tmp_path)) is None
