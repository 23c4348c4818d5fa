"""What tests of several folders need: a database server and a proxy of their own, and servers that start quickly."""

from tests.forked import Forked
from tests.serving import Server

pytest_plugins = ["tests.postgres", "tests.proxy"]

Server.fork = Forked
