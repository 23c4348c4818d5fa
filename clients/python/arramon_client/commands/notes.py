"""The command `arramon-client notes`: print what a run's agent noted beside its steps."""

import argparse
import sys
from collections.abc import Iterator, Sequence

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.commands.base import run
from arramon_client.commands.server_options import add_server, server_of
from arramon_client.errors import NotArramonError
from arramon_client.output import print_json
from arramon_client.transport.connection import Server, call
from arramon_client.transport.pages import read_pages

MAX_PAGES = 100_000
"""Maximum number of pages that are read; a run's notes fill far fewer."""


def main(argv: Sequence[str]) -> int:
    """Run `arramon-client notes` and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="arramon-client notes",
        allow_abbrev=False,
        description="Print the notes that an agent left beside its steps, by episode and step.",
    )
    parser.add_argument("run", metavar="RUN", help="id of a run of your own, or of a published one on an open split")
    parser.add_argument("episode", metavar="EPISODE", nargs="?", default="", help="only the notes of this episode")
    parser.add_argument("--json", action="store_true", help="print JSON instead of text")
    add_server(parser)
    return run(parser, argv, _main)


def notes_of(server: Server, run_id: str, episode_id: str = "") -> Iterator[pb.Note]:
    """Yield the notes of a run, page by page, by episode and step.

    Args:
        server: the connected server.
        run_id: id of the run.
        episode_id: only the notes of this episode; empty for all.

    Raises:
        ArramonClientError: if there is no such run or episode, or the caller may not read its notes.
    """

    def read(token: str) -> tuple[Sequence[pb.Note], str]:
        request = pb.ListNotesRequest(run_id=run_id, episode_id=episode_id, page_token=token)
        try:
            page = call(server.stub.ListNotes, request, server.address)
        except NotArramonError as error:
            raise NotArramonError(f"the server at {server.address} is of an earlier release, without notes") from error
        return page.notes, page.next_page_token

    return read_pages(read, "notes", MAX_PAGES)


def _main(options: argparse.Namespace) -> None:
    with server_of(options) as server:
        notes = notes_of(server, options.run, options.episode)
        if options.json:
            print_json([{"episode_id": note.episode_id, "step": note.step, "note": note.text} for note in notes])
            return
        episode_id = None
        for note in notes:
            if note.episode_id != episode_id:
                episode_id = note.episode_id
                sys.stdout.write(f"episode {episode_id}\n")
            sys.stdout.write(_lines(note))
    if episode_id is None:
        sys.stdout.write("no notes\n")


def _lines(note: pb.Note) -> str:
    """Return the lines that show a note; further lines of its text are indented as the first."""
    start = f"  step {note.step}: "
    indent = "\n" + " " * len(start)
    return start + indent.join(note.text.splitlines()) + "\n"
