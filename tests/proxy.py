"""A real nginx for tests, configured by `deploy/nginx.conf` with other addresses and files."""

import re
import shutil
import socket
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from tests import ROOT
from tests.certificates import Authority
from tests.ports import free_port
from tests.programs import program, start, stop

CONFIGURATION = ROOT / "deploy" / "nginx.conf"

_MAIN = """
daemon off;
{user}
pid {folder}/pid;
error_log {folder}/errors;
worker_processes 1;
events {{ worker_connections 512; }}
http {{
    access_log {folder}/requests;
    client_body_temp_path {folder}/body;
    proxy_temp_path {folder}/proxied;
    fastcgi_temp_path {folder}/fastcgi;
    uwsgi_temp_path {folder}/uwsgi;
    scgi_temp_path {folder}/scgi;
    # Whatever the file below does not set for itself is far too short and too small for a stream.
    client_max_body_size 1k;
    client_body_timeout 1s;
    client_header_timeout 1s;
    send_timeout 1s;
    keepalive_timeout 1s;
    keepalive_requests 3;
    grpc_read_timeout 1s;
    grpc_send_timeout 1s;
    include {folder}/arramon.conf;
}}
"""


class Proxy:
    """nginx before some servers. It can be killed and started again on the same port.

    Attributes:
        address: where agents connect, by TLS.
        authority: PEM file with the certificate to trust.
    """

    def __init__(self, binary: Path, folder: Path, servers: Sequence[str], pages: str = "127.0.0.1:50580") -> None:
        self._binary, self._folder = binary, folder
        self.address = f"localhost:{free_port()}"
        self.authority = folder / "ca.pem"
        authority = Authority()
        self.authority.write_bytes(authority.pem)
        certificate, key = authority.sign(folder)
        text = CONFIGURATION.read_text()
        for pattern, replacement in (
            (r"listen 443 ", f"listen {self.address.replace('localhost', '127.0.0.1')} "),
            (r"\S+/certificate\.pem", str(certificate)),
            (r"\S+/key\.pem", str(key)),
            (r"server 127\.0\.0\.1:50580 ", f"server {pages} "),
            (r"server (127\.0\.0\.1:50551)( .*;)\n", "".join(rf"server {server}\2\n" for server in servers)),
        ):
            text, number = re.subn(pattern, replacement, text)
            assert number, f"{pattern} is not in {CONFIGURATION.name}"
        (folder / "arramon.conf").write_text(text)
        user = "user root;" if folder.owner() == "root" else ""
        (folder / "nginx.conf").write_text(_MAIN.format(folder=folder, user=user))
        self.start()

    def start(self) -> None:
        command = [str(self._binary), "-p", str(self._folder), "-c", str(self._folder / "nginx.conf")]
        self._process = start([*command, "-e", str(self._folder / "errors")], self._folder / "log")
        host, _, port = self.address.rpartition(":")
        while True:
            try:
                socket.create_connection((host, int(port)), 60).close()
            except OSError:
                assert self._process.poll() is None, self.said()
                time.sleep(0.05)
            else:
                return

    def stop(self) -> None:
        """Ends it at once, and every stream with it."""
        stop(self._process)

    def said(self) -> str:
        return "\n".join(path.read_text() for name in ("log", "errors") if (path := self._folder / name).exists())

    def requests(self) -> str:
        return (self._folder / "requests").read_text()


@pytest.fixture
def proxies() -> Iterator["Proxies"]:
    """Makes proxies, and stops them in the end."""
    made = Proxies()
    yield made
    made.stop()


class Proxies:
    """Those of one test."""

    def __init__(self) -> None:
        self._made: list[Proxy] = []
        self._folders: list[Path] = []

    def start(self, servers: Sequence[str], pages: str = "127.0.0.1:50580") -> Proxy:
        """A proxy before servers at these addresses, and before the pages at another one."""
        binary = program("nginx", "nginx", "/usr/sbin")
        self._folders.append(Path(tempfile.mkdtemp(prefix="arramon-nginx-")))
        self._made.append(Proxy(binary, self._folders[-1], servers, pages))
        return self._made[-1]

    def stop(self) -> None:
        for proxy in self._made:
            proxy.stop()
        for folder in self._folders:
            shutil.rmtree(folder, ignore_errors=True)
