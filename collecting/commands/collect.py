"""The command `collect`: creates, describes, pauses and exports collections of instructions."""

import argparse
from importlib import import_module
from pathlib import Path

from arramon_collecting.settings import STAGES
from arramon_collecting.storage.people.records import HOST, WORKER
from arramon_collecting.storage.records import CLOSED, PAUSED, RUNNING
from arramon_server.commands import Commands

PAPER_SHARE, PAPER_TEXTS = 7692 / 8546, round(8546 / 96)
"""Share of the paper's texts that were kept, and texts of each of its writers ("Data Analysis", "Qualifications")."""


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command with its actions."""
    collect = commands.add_parser("collect", help="collect instructions from people, or let them review generated ones")
    actions = collect.add_subparsers(title="actions", required=True, metavar="ACTION")
    _add_create(actions, common)
    _add_invite(actions, common)
    _add_status(actions, common)
    for name, state, meaning in (
        ("pause", PAUSED, "give out no more tasks; open ones can be submitted"),
        ("resume", RUNNING, "give out tasks again"),
        ("close", CLOSED, "give out no more tasks, as the collection is complete"),
    ):
        action = _named(actions, common, name, meaning)
        action.set_defaults(command=_run, action="hosting.set_state", state=state)
    delete = _named(actions, common, "delete", "delete a collection in which nobody has signed in yet")
    delete.set_defaults(command=_run, action="hosting.delete")
    _add_results(actions, common)
    _add_forget(actions, common)
    _add_tools(actions, common)


def _named(actions: Commands, common: argparse.ArgumentParser, action: str, meaning: str) -> argparse.ArgumentParser:
    parser = actions.add_parser(action, parents=[common], help=meaning)
    parser.add_argument("name", metavar="NAME", help="name of the collection")
    return parser


def _add_create(actions: Commands, common: argparse.ArgumentParser) -> None:
    create = actions.add_parser("create", parents=[common], help="create a collection")
    create.add_argument("name", metavar="NAME", nargs="?", help="its name (default with --review: review-SPLIT-LANG)")
    source = create.add_mutually_exclusive_group(required=True)
    source.add_argument("--split", help="split whose episodes are written for")
    source.add_argument("--review", metavar="SPLIT", help="split whose texts are reviewed instead")
    create.add_argument("--lang", required=True, help="code of the language")
    create.add_argument(
        "--settings",
        dest="settings_file",
        type=Path,
        metavar="FILE",
        help="TOML file with the collection's settings (default: table [collections.NAME] of the settings file)",
    )
    create.add_argument(
        "--episodes", type=int, metavar="N", help="number of episodes, in playing order (default: as set, or all)"
    )
    create.set_defaults(command=_run, action="creation.create")


def _add_invite(actions: Commands, common: argparse.ArgumentParser) -> None:
    invite = _named(actions, common, "invite", "print new personal links, only this once")
    invite.add_argument("--count", type=int, default=1, metavar="N", help="number of links (default: %(default)s)")
    invite.add_argument(
        "--role", default=WORKER, choices=(WORKER, HOST), help="hosts review texts and see workers (default: worker)"
    )
    invite.add_argument("--stage", nargs="+", default=STAGES, choices=STAGES, help="what they do (default: both)")
    invite.add_argument("--note", default="", metavar="TEXT", help="note for the host, such as a name")
    invite.add_argument("--email", default="", metavar="ADDRESS", help="mail address, to tell them about their texts")
    invite.add_argument(
        "--site", metavar="URL", help="address of the pages, such as https://example.org (default: setting `web`)"
    )
    invite.add_argument("--page-lang", default="en", metavar="L", help="language of the pages (default: %(default)s)")
    invite.set_defaults(command=_run, action="hosting.invite")


def _add_status(actions: Commands, common: argparse.ArgumentParser) -> None:
    status = actions.add_parser("status", parents=[common], help="show how collections stand")
    status.add_argument("name", metavar="NAME", nargs="?", help="name of the collection (default: all)")
    status.add_argument("--workers", action="store_true", help="list the workers, with their pseudonyms and notes")
    status.add_argument("--json", action="store_true", help="print JSON")
    status.set_defaults(command=_run, action="reports.status")


def _add_results(actions: Commands, common: argparse.ArgumentParser) -> None:
    export = actions.add_parser(
        "export", parents=[common], help="write the kept texts as a split, and in the official release's form"
    )
    export.add_argument(
        "names", metavar="NAME", nargs="+", help="name of the collection; several of one split, each in its language"
    )
    export.add_argument(
        "--split", metavar="S", help="name of the new split (default: the collection's name; needed for several)"
    )
    export.set_defaults(command=_run, action="results.export")

    ledger = _named(actions, common, "ledger", "print what is owed to whom as CSV")
    ledger.set_defaults(command=_run, action="results.ledger")

    reconcile = _named(
        actions,
        common,
        "reconcile",
        "print the visits from a crowd platform as CSV, to compare with the platform's own",
    )
    reconcile.add_argument(
        "--returned",
        nargs="+",
        default=(),
        metavar="ID",
        help="ids of workers who returned their submission on the platform: their tasks go back to the pool",
    )
    reconcile.set_defaults(command=_run, action="results.reconcile")


def _add_forget(actions: Commands, common: argparse.ArgumentParser) -> None:
    forget = _named(actions, common, "forget", "delete a worker's data; the texts stay or not, as the worker chose")
    forget.add_argument("worker", metavar="WORKER", help="the worker's pseudonym, or the beginning of it")
    texts = forget.add_mutually_exclusive_group()
    texts.add_argument("--keep-texts", action="store_true", default=None, help="keep the texts, as the worker asks now")
    texts.add_argument("--delete-texts", action="store_false", dest="keep_texts", help="delete the texts, too")
    forget.set_defaults(command=_run, action="hosting.forget")


def _add_tools(actions: Commands, common: argparse.ArgumentParser) -> None:
    texts = actions.add_parser(
        "texts", parents=[common], help="list what the pages lack in a language; status 1 if any"
    )
    texts.add_argument("language", metavar="L", help="code of the language")
    texts.set_defaults(command=_run, action="reports.list_missing_texts")

    cost = actions.add_parser("cost", parents=[common], help="compute what a collection costs")
    cost.add_argument("texts", type=int, metavar="N", help="number of episodes whose texts are kept")
    cost.add_argument(
        "--kept", type=float, default=PAPER_SHARE, metavar="SHARE", help="share kept (default: the paper's)"
    )
    cost.add_argument(
        "--each", type=int, default=PAPER_TEXTS, metavar="N", help="texts of each writer (default: the paper's)"
    )
    cost.add_argument("--settings", dest="settings_file", type=Path, metavar="FILE", help="TOML file with the rates")
    cost.set_defaults(command=_run, action="reports.cost")


def _run(arguments: argparse.Namespace) -> int | None:
    """Run an action. Its module is imported only now, as other commands build this parser, too."""
    module, function = arguments.action.split(".")
    status: int | None = getattr(import_module(f"arramon_collecting.commands.{module}"), function)(arguments)
    return status
