"""What tests of several folders need: a database server and a proxy of their own, and servers that start quickly."""

import pytest

from tests.forked import Forked
from tests.serving import Server

pytest_plugins = ["tests.postgres", "tests.proxy"]

Server.fork = Forked


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests come first: at the end, one of several processes is not to be left with one of these."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)
