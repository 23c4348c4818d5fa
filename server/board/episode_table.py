"""Scores of every episode of a published run, for paired comparisons. They never leave the server."""

import io
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_server.board.standings import HEADLINE
from arramon_server.runs.storage.records import EpisodeEnding
from arramon_server.scoring.aggregate import with_total
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.scoring.intervals import Floats
from arramon_server.scoring.language_gap import LanguageGap, language_gap
from arramon_server.scoring.masking import digest_without


@dataclass(frozen=True, eq=False, slots=True)
class EpisodeTable:
    """Scores of a run by episode.

    Attributes:
        ids: ids of the episodes, sorted.
        scores: scores of both turns, (episodes, 2, METRICS).
        play_digest: digest of the run's actions and causes, see `play_digest`; empty if unknown. If void episodes were
            removed, their ids are appended, see `digest_without`.
    """

    ids: tuple[str, ...]
    scores: Floats
    play_digest: str = ""

    @classmethod
    def from_endings(cls, endings: Iterable[EpisodeEnding], play_digest: str) -> "EpisodeTable":
        """Return the table of a run from the endings of its episodes and the digest of its play."""
        ordered = sorted(endings, key=lambda ending: ending.episode_id)
        scores = np.array([[[turn[name] for name in METRICS] for turn in ending.scores] for ending in ordered])
        return cls(tuple(ending.episode_id for ending in ordered), scores, play_digest)

    def without(self, episode_ids: Set[str]) -> "EpisodeTable":
        """Return the table without some episodes."""
        if episode_ids.isdisjoint(self.ids):
            return self
        kept = [place for place, name in enumerate(self.ids) if name not in episode_ids]
        name = digest_without(self.play_digest, episode_ids & frozenset(self.ids))
        return EpisodeTable(tuple(self.ids[place] for place in kept), self.scores[kept], name)

    def packed(self) -> bytes:
        """Return the table as a compressed NumPy archive."""
        file = io.BytesIO()
        ids, metrics, play_digest = (np.array(one) for one in (self.ids, METRICS, self.play_digest))
        np.savez_compressed(file, ids=ids, metrics=metrics, scores=self.scores, play=play_digest)
        return file.getvalue()

    @classmethod
    def unpacked(cls, content: bytes) -> "EpisodeTable | None":
        """Return the table stored in an archive; None if a release with other metrics wrote it."""
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            if tuple(archive["metrics"].tolist()) != METRICS:
                return None
            play_digest = str(archive["play"]) if "play" in archive else ""  # earlier releases did not need it
            return cls(tuple(archive["ids"].tolist()), archive["scores"], play_digest)


def mean_table(tables: Sequence[EpisodeTable]) -> EpisodeTable:
    """Return the mean scores of several runs of the same episodes, such as one agent's runs with different seeds.

    Raises:
        ValueError: if the runs did not play the same episodes.
    """
    if any(table.ids != tables[0].ids for table in tables):
        raise ValueError("the runs did not play the same episodes")
    return EpisodeTable(tables[0].ids, np.mean([table.scores for table in tables], axis=0))


@dataclass(frozen=True, eq=False, slots=True)
class JoinedScores:
    """Scores of a system by episode, combined over the languages of each episode.

    Attributes:
        ids: ids of the episodes, sorted.
        values: contribution of each episode, (episodes, ROWS, METRICS); its mean is the mean over the languages' means.
        strata: number of each episode's stratum: its section and its set of languages.
        are_sections: whether every episode exists in every language, so that strata are sections.
    """

    ids: tuple[str, ...]
    values: Floats
    strata: npt.NDArray[np.intp]
    are_sections: bool


def join_languages(tables: Sequence[EpisodeTable], section_of: Mapping[str, str]) -> JoinedScores:
    """Combine the scores of one run per language.

    Args:
        tables: scores in each language.
        section_of: section of every episode, by id.

    Raises:
        KeyError: if the section of an episode is unknown.
    """
    first = tables[0].ids
    if all(table.ids == first for table in tables):
        values = with_total(np.mean([table.scores for table in tables], axis=0))
        return JoinedScores(
            first, values, np.unique([section_of[name] for name in first], return_inverse=True)[1], True
        )
    ids = tuple(sorted(set().union(*(table.ids for table in tables))))
    place = {name: number for number, name in enumerate(ids)}
    turns = np.zeros((len(ids), *tables[0].scores.shape[1:]))
    held = np.zeros((len(ids), len(tables)), dtype=bool)
    for language, table in enumerate(tables):
        at = [place[name] for name in table.ids]
        turns[at] += table.scores * (len(ids) / (len(tables) * len(table.ids)))
        held[at, language] = True
    names = [f"{section_of[name]} {held[number].tolist()}" for number, name in enumerate(ids)]
    return JoinedScores(ids, with_total(turns), np.unique(names, return_inverse=True)[1], False)


def language_gap_of(
    tables: Sequence[EpisodeTable], languages: Sequence[str], section_of: Mapping[str, str], metric: str
) -> LanguageGap | None:
    """Return the gap between a system's languages in a metric; None if the languages share no episode.

    Args:
        tables: scores in each language.
        languages: codes of the languages, at least two.
        section_of: section of every episode, by id.
        metric: metric whose total is compared, one of METRICS.
    """
    ids = sorted(set(tables[0].ids).intersection(*(table.ids for table in tables)))
    if not ids:
        return None
    rows = [np.searchsorted(table.ids, ids) for table in tables]
    common = np.stack([table.scores[row] for table, row in zip(tables, rows, strict=True)])
    strata = np.unique([section_of[name] for name in ids], return_inverse=True)[1]
    scores = common[:, :, :, METRICS.index(metric)].mean(axis=2)
    return language_gap(languages, scores, common[:, :, :, METRICS.index(HEADLINE)], strata)
