"""The commands `import-release`, `generate` and `demands`, which create and annotate splits."""

import argparse
import sys
from pathlib import Path

from arramon_dataset.release.importer import import_release
from arramon_server.commands import Commands
from arramon_server.commands.split_description import describe_split
from arramon_server.episodes.epoch_statement import SECRET_DIGITS, check_secret
from arramon_server.episodes.splits import read_split, split_folder
from arramon_server.errors import BadInput, NotFound, quoted


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add all three commands."""
    import_ = commands.add_parser("import-release", parents=[common], help="import files of the official release")
    import_.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="file of one language, such as val_seen.json"
    )
    import_.add_argument("--split", help="name of the split (default: the file's name without the language)")
    import_.add_argument("--lang", help="language of the instructions (default: from their script)")
    import_.add_argument("--hidden", action="store_true", help="keep targets, goals and paths on the server")
    import_.add_argument("--jobs", type=int, default=0, help="number of processes (default: one for each core)")
    import_.set_defaults(command=_import)

    generate = commands.add_parser("generate", parents=[common], help="generate the data set, or a part of it")
    generate.add_argument(
        "--split", nargs="+", metavar="S", help="splits, such as val_unseen or train_extra (default: the paper's four)"
    )
    generate.add_argument(
        "--sections",
        type=int,
        metavar="N",
        help="number of sections of train_extra, whose street plans are random",
    )
    generate.add_argument(
        "--rooms", type=int, metavar="N", help="generate the split rooms instead: N tasks in the room, without a city"
    )
    generate.add_argument(
        "--scale", type=float, default=1.0, help="share of each split's episodes (default: %(default)s)"
    )
    generate.add_argument(
        "--seed", type=int, default=1, help="seed of open splits; hidden ones use the host's secret (default: 1)"
    )
    generate.add_argument(
        "--secret",
        metavar="HEX|FILE",
        help="secret of a hidden split, or a file with it, instead of the host's own: for a revealed epoch",
    )
    generate.add_argument("--jobs", type=int, default=0, help="number of processes (default: one for each core)")
    generate.add_argument(
        "--no-trial",
        action="store_true",
        help="keep episodes without a trial by an agent: faster, and marked in the split's header",
    )
    generate.add_argument(
        "--languages",
        metavar="CODES",
        default="",
        help="languages to write, such as en,hi,te: those that every episode has, and further ones, which an episode "
        "lacks that they cannot express (default: those that every episode has)",
    )
    generate.set_defaults(command=_generate)

    demands = commands.add_parser(
        "demands",
        parents=[common],
        help="add the demands of instructions to splits of earlier releases, for reports; `generate` includes them",
    )
    demands.add_argument("splits", nargs="+", metavar="SPLIT", help="name of a generated split")
    demands.set_defaults(command=_demands)


def _demands(arguments: argparse.Namespace) -> None:
    from arramon_dataset.demands import add_demands

    for name in arguments.splits:
        folder = split_folder(arguments.data, name)
        if not folder.is_dir():
            raise NotFound(f"there is no split {quoted(name)} in {arguments.data}")
        print(describe_split(add_demands(arguments.data, read_split(folder))))


def _import(arguments: argparse.Namespace) -> None:
    for split in import_release(
        arguments.files,
        arguments.data,
        split=arguments.split,
        language=arguments.lang,
        hidden=arguments.hidden,
        jobs=arguments.jobs,
    ):
        print(describe_split(split))


def _generate(arguments: argparse.Namespace) -> None:
    from arramon_dataset.generation.command import generate_rooms
    from arramon_dataset.instruction_writer import generate_splits, throttled_progress

    def print_line(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    if arguments.rooms is not None:
        if arguments.split or arguments.sections is not None or arguments.secret is not None:
            raise BadInput("--rooms generates the split rooms only; leave out --split, --sections and --secret")
        if arguments.languages:
            raise BadInput("--rooms writes the languages that every episode has; leave out --languages")
        tasks = generate_rooms(
            arguments.data,
            arguments.rooms,
            seed=arguments.seed,
            jobs=arguments.jobs,
            on_progress=throttled_progress(print_line),
        )
        print(describe_split(tasks))
        return
    for split in generate_splits(
        arguments.data,
        arguments.split,
        scale=arguments.scale,
        seed=arguments.seed,
        jobs=arguments.jobs,
        write_line=print_line,
        trial=not arguments.no_trial,
        sections=arguments.sections,
        secret="" if arguments.secret is None else read_secret(arguments.secret),
        languages=[code.strip() for code in arguments.languages.split(",")] if arguments.languages else (),
    ):
        print(describe_split(split))


def read_secret(text: str) -> str:
    """Return a secret given as hexadecimal digits or as the path of a file.

    Raises:
        BadInput: if the argument is neither.
    """
    if len(text) == SECRET_DIGITS:
        return check_secret(text)
    try:
        return check_secret(Path(text).read_text())
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise BadInput(
            f"--secret is neither {SECRET_DIGITS} hexadecimal digits nor a readable file: {error}"
        ) from error
