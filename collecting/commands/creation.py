"""The action `collect create`: a new collection, its settings, and what would go wrong with it later."""

import argparse
import os
import sys
from pathlib import Path

from arramon_collecting.commands.base_split import read_base_split
from arramon_collecting.rules.currencies import CURRENCIES
from arramon_collecting.settings import CONSENT, Settings, settings_in_file, settings_in_table
from arramon_collecting.storage.records import REVIEW_KIND, WRITE_KIND
from arramon_collecting.storage.store import Store
from arramon_collecting.web.texts import languages_of, page_languages
from arramon_lang import UnknownLanguage, load
from arramon_server.commands.journal import open_journal
from arramon_server.configuration.config import Config
from arramon_server.configuration.sources import CONFIG, settings_file
from arramon_server.episodes.splits import Split, split_folder
from arramon_server.errors import BadInput, Conflict, NotFound

RATES = ("pay_write", "pay_verify", "pay_kept", "milestones")


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
    chosen, origin = _settings(arguments, name)
    if arguments.episodes is not None:
        chosen = chosen.model_copy(update={"episodes": arguments.episodes})
    _check_language(arguments.lang, split, is_review=is_review)
    texts = split.in_playing_order(arguments.lang) if is_review else []
    there = len(texts) if is_review else len(split.episodes)
    if arguments.episodes is not None and arguments.episodes < 1:
        raise BadInput(f"--episodes is {arguments.episodes}; expected at least 1, or none for all {there}")
    _check_settings(chosen, split, there)
    kind = REVIEW_KIND if is_review else WRITE_KIND
    texts = texts[: chosen.episodes or None]
    pairs = ((one.episode_id, one.instructions[arguments.lang]) for one in texts)
    imported = [(key, tuple((turn.navigation, turn.assembly) for turn in turns)) for key, turns in pairs]
    with open_journal(config) as database:
        collections = Store(database).collections
        if split_folder(config.data, name).exists() and name not in (one.name for one in collections.all()):
            raise Conflict(f"there is a split {name!r} already, and the export would be one; choose another name")
        collections.create(name, kind, arguments.lang, split.name, chosen, imported)
    print(f"collection {name}: {kind}, {arguments.lang}, {chosen.episodes or there} episodes of {split.name}")
    lines = [f"settings: {origin}", *([] if is_review else _terms(chosen, arguments.lang))]
    role = " --role host" if is_review else ""
    lines.append(f"invite people with: arramon-server collect invite {name}{role} --count 1")
    print(*lines, sep="\n", file=sys.stderr)


def _settings(arguments: argparse.Namespace, name: str) -> tuple[Settings, str]:
    """Return the settings of a new collection, and in words where they were found."""
    if arguments.settings_file is not None:
        return settings_in_file(arguments.settings_file), str(arguments.settings_file)
    file: Path | None = settings_file(vars(arguments), os.environ)
    if file is None:
        return Settings(), f"the defaults, as no settings file is named by --config or ${CONFIG}"
    found, tables = settings_in_table(file, name)
    if found is not None:
        return found, f"[collections.{name}] of {file}"
    others = ", ".join(f"[collections.{one}]" for one in tables)
    has = f"; it has {others}" if tables else ""
    return Settings(), f"the defaults, as {file} has no table [collections.{name}]{has}"


def _check_settings(settings: Settings, split: Split, there: int) -> None:
    """Check what a collection can no longer change: names that must exist, and the number of episodes.

    Raises:
        BadInput, NotFound: naming the setting.
    """
    if settings.currency not in CURRENCIES:
        raise BadInput(f"currency is {settings.currency!r}, expected a code of ISO 4217, such as USD, EUR or INR")
    if settings.episodes > there:
        raise BadInput(f"{settings.episodes} episodes are wanted, but {split.name} has {there}")
    pages = [one.language for one in page_languages()]
    for setting, codes in (("page_languages", settings.page_languages), ("consent_in", settings.consent_in)):
        for code in codes:
            if code not in pages:
                raise NotFound(f"{setting} has {code!r}; the pages are in {', '.join(pages)}")
    for episode in settings.gold_episodes:
        if episode not in split.episodes:
            raise NotFound(f"gold_episodes has {episode!r}, which {split.name} does not have")


def _terms(settings: Settings, language: str) -> list[str]:
    """Return what people will read and be paid, for the host to check now: it can no longer be changed."""
    pages = [one.language for one in languages_of(settings.page_languages)]
    shown = ", ".join(f"{code}: {_consent_kind(settings, code)}" for code in pages)
    money = settings.money
    lines = [
        f"consent text: {shown}",
        f"payment: {money(settings.pay_write)} for four texts, {money(settings.pay_verify)} for a verification, "
        f"{money(settings.pay_kept)} for kept texts",
    ]
    if settings.currency != Settings().currency and not settings.model_fields_set & set(RATES):
        lines.append(f"no amounts are set, so that the paper's dollars are paid as {settings.currency}")
    missing = [code for code in pages if code not in settings.consents]
    if missing:
        lines.append(
            f"there is no consent text in {', '.join(missing)}: these pages show the English one; the setting is "
            f"consent_in.{missing[0]}"
        )
    if language not in pages:
        lines.append(f"the pages have no words in {language!r}: people write {language!r} on pages in {pages[0]!r}")
    return lines


def _consent_kind(settings: Settings, code: str) -> str:
    if code not in settings.consents:
        return "missing"
    is_default = settings.consent == CONSENT and code not in settings.consent_in
    return "the default one, which you should replace" if is_default else "your own"


def _check_language(code: str, split: Split, *, is_review: bool) -> None:
    if is_review and code not in split.languages:
        known = ", ".join(split.languages)
        raise NotFound(f"split {split.name!r} has no texts in {code!r} to review; there are {known}")
    try:
        load(code)
    except UnknownLanguage as error:
        raise NotFound(f"{error}; docs/how-to/languages.md says which files a language needs") from error
