"""The client's token: where it is read, and that it never leaves this machine readable."""

from pathlib import Path

import pytest

from arramon_client import UsageError, arguments, cli
from arramon_client.access import Access, access_of

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
def test_when_a_connection_is_encrypted(access: Access, address: str, encrypts: bool) -> None:
    assert access.encrypts(address) is encrypts


def test_a_token_is_not_sent_readable_to_another_machine() -> None:
    for address in ("arramon.example.org:443", "10.0.0.1:50551", "localhost.example.org:1", "0.0.0.0:50551"):
        with pytest.raises(UsageError, match=f"a token is not sent to {address} without encryption"):
            Access("t", tls=False).encrypts(address)


def test_the_command_refuses_to_send_it(capsys: pytest.CaptureFixture[str]) -> None:
    status = cli.main(["account", "--server", "192.0.2.1:443", "--token", "arramon_x", "--no-tls"])
    assert status == 2
    assert "a token is not sent to 192.0.2.1:443 without encryption" in capsys.readouterr().err


def test_a_token_does_not_show_in_what_is_printed() -> None:
    assert "sesame" not in repr(Access("sesame"))


def test_where_a_token_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


@pytest.mark.parametrize("content", [b"", b"\n", b"two words", b"two\nlines", "é".encode(), b"\xff", b"a\x00b"])
def test_what_cannot_be_a_token(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "token"
    file.write_bytes(content)
    options = arguments.parse([*PLAY, "--server", "x:1", "--token-file", str(file)])
    with pytest.raises(UsageError, match=f"what is in {file} is no token"):
        access_of(options)


def test_files_that_are_not_there(tmp_path: Path) -> None:
    for option in ("--token-file", "--tls-ca"):
        options = arguments.parse([*PLAY, "--server", "x:1", option, str(tmp_path / "gone")])
        with pytest.raises(UsageError, match="gone cannot be read: No such file or directory"):
            access_of(options)


@pytest.mark.parametrize("more", [["--token", "t"], ["--token-file", "f"], ["--tls"], ["--no-tls"], ["--tls-ca", "f"]])
def test_the_embedded_server_needs_none(more: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        arguments.parse([*PLAY, *more])
    assert "is for a server of others: name it with --server" in capsys.readouterr().err


def test_the_way_to_go_on_shows_no_token() -> None:
    for given in (["--token", "sesame"], ["--token=sesame"]):
        shown = arguments.resume_command([*PLAY, *given, "--server", "x:1"], "r1")
        assert shown == "arramon-client --agent agents.stop --lang en --server x:1 --resume r1"
