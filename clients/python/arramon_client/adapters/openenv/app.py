"""The web application that serves the environment, configured by environment variables."""

import os

from arramon_client.adapters.extras import extra
from arramon_client.adapters.host import Host
from arramon_client.adapters.openenv.environment import ArramonEnvironment
from arramon_client.adapters.openenv.messages import ArramonAction, ArramonObservation

with extra("openenv"):
    from fastapi import FastAPI
    from openenv.core.env_server.http_server import create_app

SESSIONS = 8
"""Default of the largest number of sessions at once."""


def make_app() -> FastAPI:
    """Return the application.

    It reads `ARRAMON_SERVER` (HOST:PORT; without it an embedded server plays the data folder `ARRAMON_DATA`),
    `ARRAMON_TOKEN`, `ARRAMON_LANGUAGE` ("en"), `ARRAMON_SPLIT` (the server's only one), `ARRAMON_AGENT` ("openenv"),
    `ARRAMON_SESSIONS` (8) and `ARRAMON_IMAGE_SIZE` (the server's).
    """
    given = os.environ.get
    host = Host(
        language=given("ARRAMON_LANGUAGE", "en"),
        split=given("ARRAMON_SPLIT"),
        agent=given("ARRAMON_AGENT", "openenv"),
        server=given("ARRAMON_SERVER"),
        sensors=("rgb",),
        image_size=int(given("ARRAMON_IMAGE_SIZE", "0")) or None,
    )
    return create_app(
        lambda: ArramonEnvironment(host),
        ArramonAction,
        ArramonObservation,
        env_name="arramon",
        max_concurrent_envs=int(given("ARRAMON_SESSIONS", str(SESSIONS))),
    )
