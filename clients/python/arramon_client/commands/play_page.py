"""The command `arramon-client play`: play an episode oneself, in the browser, on an embedded server."""

import argparse
import sys
import threading
import webbrowser
from collections.abc import Sequence
from pathlib import Path

from arramon_client.commands.base import run
from arramon_client.errors import EmbeddedServerError, UsageError
from arramon_client.local.embedded_play import embedded_for_play

LANGUAGES = ("en", "hi")
"""Languages of the page."""

PORT = 50552
"""Default port of the page. It stays the same, as browsers keep the run in play under the page's address."""

AIDS = ("frame-strip", "compass", "look-around", "zoom", "pictured-names", "ahead", "scene-words")
"""Aids for people besides the landing diagram."""

LOOK_SECONDS = 1.0
"""Interval at which the server is restarted if it has died."""


def main(argv: Sequence[str]) -> int:
    """Run `arramon-client play` and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="arramon-client play",
        allow_abbrev=False,
        description="Play episodes yourself in the browser, on a server that runs on this machine until Ctrl-C.",
    )
    parser.add_argument("--lang", default="en", choices=LANGUAGES, help="language of the page (default: %(default)s)")
    parser.add_argument(
        "--data", type=Path, metavar="DIR", help="data folder (default: $ARRAMON_DATA, or ./arramon-data)"
    )
    parser.add_argument(
        "--port", type=int, default=PORT, metavar="N", help="port of the page on this machine (default: %(default)s)"
    )
    parser.add_argument("--landing-diagram", action="store_true", help="show where the object would be placed")
    parser.add_argument(
        "--aid",
        action="append",
        default=[],
        choices=AIDS,
        help="give an aid for people, as the server's setting play_... does; repeat for more",
    )
    parser.add_argument("--no-browser", action="store_true", help="print the address, and open no browser")
    return run(parser, argv, _main)


def _main(options: argparse.Namespace) -> None:
    if not 1 <= options.port <= 65535:
        raise UsageError(f"--port is {options.port}, expected 1 to 65535")
    more = ["--web", f"127.0.0.1:{options.port}", "--play-page"]
    more += ["--play-landing-diagram"] if options.landing_diagram else []
    more += [f"--play-{aid}" for aid in options.aid]
    with embedded_for_play(options.data, _say, more=more) as server:
        if not server.pages:
            raise EmbeddedServerError("the embedded server serves no pages; install a release that has the play page")
        address = f"{server.pages}/{options.lang}/play"
        _say(f"play at {address}\nCtrl-C ends the server; a run in play can be continued later")
        if not options.no_browser and not webbrowser.open(address):
            _say("no browser could be opened: open the address yourself")
        while not threading.Event().wait(LOOK_SECONDS):
            server.revive()


def _say(text: str) -> None:
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()
