"""Actions of `collect` that change a collection: create, invite, pause, forget."""

import argparse
import os
import sys

from arramon_collecting.commands.base_split import read_base_split
from arramon_collecting.settings import Settings, settings_in_file
from arramon_collecting.storage.people.records import HOST
from arramon_collecting.storage.records import REVIEW_KIND, WRITE_KIND
from arramon_collecting.storage.store import Store
from arramon_collecting.web.texts import languages_of, texts_of
from arramon_lang import UnknownLanguage, load
from arramon_server.commands.journal import open_journal
from arramon_server.configuration.config import Config
from arramon_server.configuration.sources import settings_file
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, NotFound

MAX_LINKS = 10_000
"""Maximum number of links printed at once."""


def create(arguments: argparse.Namespace) -> None:
    """Create a collection; one of the kind "review" with the texts of a split."""
    config: Config = arguments.settings
    is_review = arguments.review is not None
    split = read_base_split(config.data, arguments.review if is_review else arguments.split)
    name = arguments.name or (f"review-{split.name}-{arguments.lang}".replace(".", "-").lower() if is_review else None)
    if name is None:
        raise BadInput(
            "expected the collection's name: arramon-server collect create NAME --split SPLIT --lang LANGUAGE"
        )
    chosen = _settings(arguments, name)
    if arguments.episodes is not None:
        if arguments.episodes < 1:
            raise BadInput(f"--episodes is {arguments.episodes}; expected at least 1")
        chosen = chosen.model_copy(update={"episodes": arguments.episodes})
    _check_language(arguments.lang, split, is_review=is_review)
    texts = split.in_playing_order(arguments.lang)[: chosen.episodes or None] if is_review else []
    with open_journal(config) as database:
        kind = REVIEW_KIND if is_review else WRITE_KIND
        pairs = ((one.episode_id, one.instructions[arguments.lang]) for one in texts)
        imported = [(key, tuple((turn.navigation, turn.assembly) for turn in turns)) for key, turns in pairs]
        Store(database).collections.create(name, kind, arguments.lang, split.name, chosen, imported)
    number = len(texts) if is_review else min(chosen.episodes or len(split.episodes), len(split.episodes))
    print(f"collection {name}: {kind}, {arguments.lang}, {number} episodes of {split.name}")
    role = " --role host" if is_review else ""
    missing = [one.language for one in languages_of(chosen.page_languages) if one.language not in chosen.consents]
    if missing and not is_review:
        print(
            f"there is no consent text in {', '.join(missing)}: these pages show the English one; the setting is "
            f"consent_in.{missing[0]}",
            file=sys.stderr,
        )
    print(f"invite people with: arramon-server collect invite {name}{role} --count 1", file=sys.stderr)


def invite(arguments: argparse.Namespace) -> None:
    """Print personal links."""
    config: Config = arguments.settings
    if not 1 <= arguments.count <= MAX_LINKS:
        raise BadInput(f"--count is {arguments.count}; expected 1 to {MAX_LINKS}")
    if arguments.count > 1 and arguments.email:
        raise BadInput("a mail address belongs to one person; expected --count 1")
    site, language = _site(arguments, config), texts_of(arguments.page_lang).language
    with open_journal(config) as database:
        store = Store(database)
        collection = store.collections.get(arguments.name)
        for _ in range(arguments.count):
            stages = () if arguments.role == HOST else arguments.stage
            _, key = store.workers.invite(
                collection, role=arguments.role, stages=stages, note=arguments.note, email=arguments.email
            )
            print(f"{site}/{language}/collect/{collection.name}/join?key={key}")
    print("each link is for one person, and is shown only once", file=sys.stderr)


def set_state(arguments: argparse.Namespace) -> None:
    """Pause, resume or close a collection."""
    with open_journal(arguments.settings) as database:
        changed = Store(database).collections.set_state(arguments.name, arguments.state)
    print(f"collection {changed.name} is {changed.state}")


def forget(arguments: argparse.Namespace) -> None:
    """Delete the data of a worker."""
    with open_journal(arguments.settings) as database:
        store = Store(database)
        removed = store.removal.forget(
            store.collections.get(arguments.name), arguments.worker, keep_texts=arguments.keep_texts
        )
        if not database.is_file:
            database.vacuum()
    print(f"deleted: {removed.runs} runs, {removed.texts} texts; kept: {removed.kept_texts} texts")
    print(
        "backups and exports made before still have this person's data: delete them, or repeat this command after they "
        "are restored",
        file=sys.stderr,
    )


def _settings(arguments: argparse.Namespace, name: str) -> Settings:
    if arguments.settings_file is not None:
        return settings_in_file(arguments.settings_file)
    file = settings_file(vars(arguments), os.environ)
    return settings_in_file(file, name) if file is not None else Settings()


def _check_language(code: str, split: Split, *, is_review: bool) -> None:
    if is_review and code not in split.languages:
        known = ", ".join(split.languages)
        raise NotFound(f"split {split.name!r} has no texts in {code!r} to review; there are {known}")
    try:
        load(code)
    except UnknownLanguage as error:
        raise NotFound(f"{error}; docs/how-to/languages.md says which files a language needs") from error


def _site(arguments: argparse.Namespace, config: Config) -> str:
    if arguments.site is not None:
        if not arguments.site.startswith(("https://", "http://")):
            raise BadInput(f"--site is {arguments.site!r}, expected an address such as https://example.org")
        return str(arguments.site).rstrip("/")
    if not config.web:
        raise BadInput("expected the address of the pages: --site https://example.org, or the setting `web`")
    return config.http["pages"]
