"""Grouping of published runs into standings: an agent's runs with several seeds, and in several languages."""

from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from itertools import groupby

from arramon_server.board.comparisons import ScoreVersions
from arramon_server.board.standings import Entry


def group_by_seed(entries: Sequence[Entry]) -> Iterator[tuple[Entry, ...]]:
    """Yield groups of ranked runs of one agent that differ only in their seed, and every other run alone.

    Several runs of one agent without a seed are not known to be independent draws, so each is yielded alone.
    """
    runs_by_seed: dict[object, dict[str | None, Entry]] = {}
    for entry in sorted(filter(lambda entry: entry.is_ranked, entries), key=_preference):
        runs_by_seed.setdefault((entry.key_without_seed, entry.run.code), {})[entry.seed] = entry
    groups = {
        entry.run.run_id: tuple(sorted(seeds.values(), key=lambda one: (len(one.seed or ""), one.seed or "")))
        for seeds in runs_by_seed.values()
        if len(seeds) > 1
        for entry in seeds.values()
    }
    for entry in entries:
        found = groups.get(entry.run.run_id, (entry,))
        if found[0] is entry:
            yield found


def group_by_system(groups: Iterable[tuple[Entry, ...]], languages: Sequence[str]) -> Iterator[tuple[Entry, ...]]:
    """Yield one group of runs per language for each system that has groups in all languages.

    If a system has several groups in a language, a ranked one is preferred, then the one published last.
    """
    systems: dict[object, dict[str, tuple[Entry, ...]]] = {}
    for line in groups:
        of_system, language = systems.setdefault(line[0].system, {}), line[0].run.language
        other = of_system.get(language)
        if other is None or max(map(_preference, line)) > max(map(_preference, other)):
            of_system[language] = line
    for found in systems.values():
        if len(found) == len(languages):
            yield tuple(entry for language in languages for entry in found[language])


def _preference(entry: Entry) -> tuple[bool, datetime, str]:
    return entry.is_ranked, entry.published_at, entry.run.run_id


def by_language(entries: Sequence[Entry]) -> list[list[Entry]]:
    """Split a group of runs by language, keeping its order."""
    return [list(same) for _, same in groupby(entries, lambda entry: entry.run.language)]


def versions_of_entries(entries: Sequence[Entry]) -> ScoreVersions:
    """Return the score versions of a group's runs, by language."""
    return tuple(tuple(entry.version for entry in same) for same in by_language(entries))
