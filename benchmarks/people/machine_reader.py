"""Play as a person does, through the play page's WebSocket, by numbered keys, frames and texts alone.

    python -m benchmarks.people.machine_reader serve --site URL --folder DIR --name NAME [--episodes 5]
    python -m benchmarks.people.machine_reader press DIR FFLR     # F forward, L left, R right, P pick up or place
    python -m benchmarks.people.machine_reader look DIR
    python -m benchmarks.people.machine_reader scores ADDRESS     # of finished runs, for hosts

`serve` keeps the run open, and writes each frame into DIR/frames. `press` sends the keys one after the other, each once
the frame of the last one has come, and stops at what a person would look at first: blocked, picked up, placed, nothing
within reach, the end of an episode. It prints what the page shows a person, but no scores and no map, which would show
a reader the streets; DIR/sheets has a picture with all frames of each press.
"""

import argparse
from pathlib import Path

from benchmarks.people.reader_folder import LETTERS, MAX_KEYS, ReaderError, ask


def letters(text: str) -> str:
    """Parse the letters of keys, for argparse.

    Raises:
        argparse.ArgumentTypeError: if they are too many, none, or no keys.
    """
    found = text.upper()
    if not 1 <= len(found) <= MAX_KEYS or set(found) - set(LETTERS):
        raise argparse.ArgumentTypeError(f"{text!r} is not 1 to {MAX_KEYS} of the letters {', '.join(LETTERS)}")
    return found


def main() -> None:
    """Run a command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    served = commands.add_parser("serve", help="play a run in the background, or go on with the folder's run")
    served.add_argument("--site", required=True, metavar="URL", help="address of the server's pages")
    served.add_argument("--folder", type=Path, required=True, metavar="DIR", help="folder for frames and state")
    served.add_argument("--name", required=True, help="the reader's name")
    served.add_argument("--split", default="val_unseen", metavar="S", help="episodes (default: %(default)s)")
    served.add_argument("--language", default="en", metavar="CODE", help="of instructions (default: %(default)s)")
    served.add_argument("--episodes", type=int, default=1, metavar="N", help="number (default: %(default)s)")
    served.add_argument("--size", type=int, default=448, metavar="N", help="image size (default: %(default)s)")
    served.add_argument(
        "--earlier", type=Path, nargs="*", default=[], metavar="DIR", help="folders of earlier runs of this reader"
    )
    pressed = commands.add_parser("press", help=f"press 1 to {MAX_KEYS} keys")
    pressed.add_argument("folder", type=Path, metavar="DIR", help="the reader's folder")
    pressed.add_argument("letters", type=letters, metavar="KEYS", help="F forward, L left, R right, P pick up or place")
    looked = commands.add_parser("look", help="print the present state")
    looked.add_argument("folder", type=Path, metavar="DIR", help="the reader's folder")
    scored = commands.add_parser("scores", help="print the scores of finished runs, beside the paper's people")
    scored.add_argument("address", help="the server's gRPC address")
    options = parser.parse_args()
    try:
        match options.command:
            case "serve":
                from benchmarks.people.reader_service import serve

                print(serve(options))
            case "press":
                print(ask(options.folder, options.letters), end="")
            case "look":
                print(ask(options.folder, ""), end="")
            case "scores":
                from benchmarks.people.reader_scores import score_table

                print(score_table(options.address))
    except ReaderError as error:
        parser.exit(1, f"{error}\n")


if __name__ == "__main__":
    main()
