"""The web server of the OpenEnv environment; `arramon_client.adapters.openenv.app` says by what it is configured."""

import argparse

import uvicorn

from arramon_client.adapters.openenv.app import make_app

app = make_app()


def main() -> None:
    """Serve the environment."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on")
    parser.add_argument("--port", type=int, default=8000, help="port to listen on")
    given = parser.parse_args()
    uvicorn.run(app, host=given.host, port=given.port)


if __name__ == "__main__":
    main()
