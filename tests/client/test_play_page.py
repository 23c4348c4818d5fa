"""The command `arramon-client play`: the play page on an embedded server."""

import signal
import socket
import urllib.request
from pathlib import Path

import pytest

from arramon_client.cli import main
from tests import tiny
from tests.forked import ForkedClient
from tests.ports import free_port


def test_the_page_is_served_until_ctrl_c(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    port = free_port()
    arguments = ["play", "--lang", "hi", "--data", str(tmp_path), "--port", str(port), "--no-browser"]
    process = ForkedClient([*arguments, "--landing-diagram", "--aid", "pictured-names", "--aid", "look-around"])
    line = next(line for line in process.stdout if line.startswith("play at "))
    address = line.split()[-1]
    assert address == f"http://127.0.0.1:{port}/hi/play"
    with urllib.request.urlopen(address, timeout=120) as response:
        assert "एक एपिसोड खेलें" in response.read().decode()
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=120)
    assert process.returncode == 130
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(address, timeout=120)


def test_a_port_that_is_in_use_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tiny.write(tmp_path)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["play", "--data", str(tmp_path), "--port", str(port), "--no-browser"]) == 1
    assert f"cannot listen on '127.0.0.1:{port}'" in capsys.readouterr().err


@pytest.mark.parametrize(("option", "said"), [("0", "--port is 0, expected 1 to 65535"), ("70000", "70000")])
def test_impossible_ports(option: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["play", "--port", option]) == 2
    assert said in capsys.readouterr().err
