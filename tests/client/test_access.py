"""The client's token: its sources, and that it is never sent to another machine without encryption."""

import subprocess
import sys
from pathlib import Path

import pytest

from arramon_client import UsageError, arguments, cli
from arramon_client.transport.access import Access, access_of
from tests.forked import run

PLAY = ["--agent", "agents.stop", "--lang", "en"]


@pytest.mark.parametrize(
    ("access", "address", "encrypts"),
    [
        (Access(), "arramon.example.org:443", False),
        (Access(tls=True), "arramon.example.org:443", True),
        (Access(authority=b"pem"), "arramon.example.org:443", True),
        (Access("t"), "arramon.example.org:443", True),
        (Access("t", tls=True), "arramon.example.org:443", True),
        (Access("t"), "127.0.0.1:50551", False),
        (Access("t"), "[::1]:50551", False),
        (Access("t", tls=False), "localhost:50551", False),
        (Access("t", tls=True), "localhost:50551", True),
        (Access("t", tls=True), "unix:/run/arramon.sock", False),
        (Access("t"), "10.0.0.1:50551", True),
    ],
)
def test_encryption_depends_on_options_and_address(access: Access, address: str, encrypts: bool) -> None:
    assert access.encrypts(address) is encrypts


def test_a_token_is_not_sent_unencrypted_to_another_machine() -> None:
    for address in ("arramon.example.org:443", "10.0.0.1:50551", "localhost.example.org:1", "0.0.0.0:50551"):
        with pytest.raises(UsageError, match=f"a token is not sent to {address} without encryption"):
            Access("t", tls=False).encrypts(address)


def test_the_command_refuses_to_send_a_token_unencrypted(capsys: pytest.CaptureFixture[str]) -> None:
    status = cli.main(["account", "--server", "192.0.2.1:443", "--token", "arramon_x", "--no-tls"])
    assert status == 2
    assert "a token is not sent to 192.0.2.1:443 without encryption" in capsys.readouterr().err


def test_a_token_is_not_in_the_repr() -> None:
    assert "sesame" not in repr(Access("sesame"))


def test_token_comes_from_argument_file_or_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def token(*more: str) -> str:
        return access_of(arguments.parse([*PLAY, "--server", "x:1", *more])).token

    monkeypatch.delenv("ARRAMON_TOKEN", raising=False)
    file = tmp_path / "token"
    file.write_text("  of-file\n")
    assert token() == ""
    assert token("--token-file", str(file)) == "of-file"
    monkeypatch.setenv("ARRAMON_TOKEN", "of-environment")
    assert token() == "of-environment"
    assert token("--token-file", str(file)) == "of-file"
    assert token("--token", "of-argument") == "of-argument"


@pytest.mark.parametrize("content", [
    b"\xef\xbb\xbfof-file", b"\xef\xbb\xbfof-file\r\n", b"of-file\r\n\r\n", b"  of-file \t\n",
])  # fmt: skip
def test_a_token_file_may_come_from_any_editor(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "token"
    file.write_bytes(content)
    assert access_of(arguments.parse([*PLAY, "--server", "x:1", "--token-file", str(file)])).token == "of-file"


def test_a_token_file_in_another_encoding_is_named(tmp_path: Path) -> None:
    file = tmp_path / "token"
    file.write_bytes("of-file".encode("utf-16"))
    options = arguments.parse([*PLAY, "--server", "x:1", "--token-file", str(file)])
    with pytest.raises(UsageError, match=f"{file} is text in UTF-16, expected UTF-8: save it again as UTF-8"):
        access_of(options)


@pytest.mark.parametrize("content", [b"", b"\n", b"two words", b"two\nlines", "é".encode(), b"\xff", b"a\x00b"])
def test_malformed_token_files_are_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "token"
    file.write_bytes(content)
    options = arguments.parse([*PLAY, "--server", "x:1", "--token-file", str(file)])
    with pytest.raises(UsageError, match=f"{file} does not contain a token"):
        access_of(options)


def test_missing_token_and_certificate_files_are_reported(tmp_path: Path) -> None:
    for option in ("--token-file", "--tls-ca"):
        options = arguments.parse([*PLAY, "--server", "x:1", option, str(tmp_path / "gone")])
        with pytest.raises(UsageError, match="gone cannot be read: No such file or directory"):
            access_of(options)


BROKEN = b"-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n"


NO_CERTIFICATE = "error: --tls-ca {} contains no certificate: expected PEM, with a line -----BEGIN CERTIFICATE-----\n"


@pytest.mark.parametrize("content", [b"", b"hello", b"\xff\xfe\x00", BROKEN])
@pytest.mark.parametrize("command", [PLAY, ["account"]])
def test_ca_file_without_a_certificate_is_reported(tmp_path: Path, content: bytes, command: list[str]) -> None:
    (tmp_path / "ca.pem").write_bytes(content)
    done = run(*command, "--server", "127.0.0.1:1", "--tls-ca", tmp_path / "ca.pem", command=cli.main)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", NO_CERTIFICATE.format(tmp_path / "ca.pem"))


def test_ca_file_without_a_certificate_is_reported_by_the_program_without_output_of_grpc(tmp_path: Path) -> None:
    (tmp_path / "ca.pem").write_bytes(BROKEN)
    program = [sys.executable, "-m", "arramon_client", *PLAY, "--server", "127.0.0.1:1", "--tls-ca", "ca.pem"]
    done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", NO_CERTIFICATE.format("ca.pem"))


@pytest.mark.parametrize("more", [["--token", "t"], ["--token-file", "f"], ["--tls"], ["--no-tls"], ["--tls-ca", "f"]])
def test_access_options_require_a_server(more: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        arguments.parse([*PLAY, *more])
    assert "requires --server: the embedded server does not use it" in capsys.readouterr().err


def test_the_resume_command_has_no_token() -> None:
    for given in (["--token", "sesame"], ["--token=sesame"]):
        shown = arguments.resume_command([*PLAY, *given, "--server", "x:1"], "r1")
        assert shown == "arramon-client --agent agents.stop --lang en --server x:1 --resume r1"
