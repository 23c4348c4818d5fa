"""The server's address and the token in the commands on an empty leaderboard."""

import re
from contextlib import closing
from pathlib import Path

import pytest

from arramon_server.configuration.config import Config
from arramon_server.web.pages import Pages
from arramon_server.web.server_options import ServerOptions, reached_address
from arramon_server.web.watch.viewers import Viewers
from tests.web.leaderboard_site import LeaderboardSite
from tests.web.serving import Site

LOCAL, OTHER = "127.0.0.1:60000", "203.0.113.5:60000"
PROXIED = {"X-Forwarded-For": "192.0.2.1"}


@pytest.mark.parametrize(("listen", "reached"), [
    (OTHER, OTHER),
    (LOCAL, LOCAL),
    ("arramon.example.org:443", "arramon.example.org:443"),
    ("[2001:db8::1]:7", "[2001:db8::1]:7"),
    ("0.0.0.0:60000", "host.example:60000"),
    ("[::]:60000", "host.example:60000"),
    ("unix:/run/arramon", "host.example:50551"),
])  # fmt: skip
def test_the_address_is_the_one_listened_on_if_clients_reach_it(listen: str, reached: str) -> None:
    assert reached_address(listen) == reached


@pytest.mark.parametrize(("given", "headers", "options"), [
    ({"listen": LOCAL}, {}, f"--server {LOCAL}"),
    ({"listen": LOCAL}, PROXIED, "--server host.example:50551 --token-file token"),
    ({"listen": LOCAL, "anonymous": False}, {}, f"--server {LOCAL} --token-file token"),
    ({"listen": LOCAL, "anonymous": False, "trust_proxy": True}, {},
     "--server host.example:50551 --tls --token-file token"),
    ({"listen": OTHER}, {}, f"--server {OTHER} --token-file token"),
    ({"listen": OTHER, "anonymous": True}, PROXIED, f"--server {OTHER}"),
    ({"listen": OTHER, "anonymous": True, "tls_certificate": Path("a"), "tls_key": Path("b")}, {},
     f"--server {OTHER} --tls"),
])  # fmt: skip
def test_the_commands_are_for_the_server_and_the_reader(
    web: LeaderboardSite, given: dict[str, object], headers: dict[str, str], options: str
) -> None:
    config = Config(**given)  # type: ignore[arg-type]
    viewers = Viewers.of(config)
    server = ServerOptions.of(config, config.listen, viewers)
    pages = Pages(web.board, web.journal, web.receipts, web.splits, web.epoch_board, viewers=viewers, server=server)
    with closing(Site(pages)) as site:
        shown = re.findall(r"arramon-client (.*)", site.get("/en/?split=tiny&language=hi", headers).text)
    assert shown[0] == f"--agent agents.random_walk --split tiny --lang hi {options}"
    assert shown[1].startswith(f"publish RUN {options}")
