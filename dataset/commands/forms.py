"""The command `forms`, which writes a split's texts anew in the forms that people type, as splits of their own."""

import argparse

from arramon_server.commands import Commands
from arramon_server.commands.split_description import describe_split
from arramon_server.episodes.splits import read_split, split_folder
from arramon_server.errors import NotFound, quoted


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    forms = commands.add_parser(
        "forms",
        parents=[common],
        help="write splits with the same episodes and texts as people type them: terse, romanised, mixed",
    )
    forms.add_argument("splits", nargs="+", metavar="SPLIT", help="name of an open split with generated texts")
    forms.add_argument("--forms", metavar="F,F", default="", help="forms, such as romanised,terse (default: all)")
    forms.add_argument(
        "--lang", metavar="CODES", default="", help="languages, such as en,hi (default: all that have the form)"
    )
    forms.add_argument("--seed", type=int, default=1, help="the same seed gives the same texts (default: 1)")
    forms.set_defaults(command=_forms)


def _forms(arguments: argparse.Namespace) -> None:
    from arramon_dataset.forms.forms import FORMS
    from arramon_dataset.forms.splits import write_form

    names = _listed(arguments.forms) or tuple(FORMS)
    languages = _listed(arguments.lang)
    for name in arguments.splits:
        folder = split_folder(arguments.data, name)
        if not folder.is_dir():
            raise NotFound(f"there is no split {quoted(name)} in {arguments.data}")
        split = read_split(folder)
        for form in names:
            having = [code for code in languages if arguments.forms or code in FORMS[form]]
            if having or not languages:
                print(describe_split(write_form(arguments.data, split, form, having, seed=arguments.seed)))


def _listed(text: str) -> tuple[str, ...]:
    return tuple(filter(None, (part.strip() for part in text.split(","))))
