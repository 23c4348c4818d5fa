"""What tests of several folders need: a database server and a proxy of their own."""

pytest_plugins = ["tests.postgres", "tests.proxy"]
