"""Recovery of a section's landmarks: alternates alignment and mixture, then keeps the confirmed peaks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from arramon_dataset.release.landmarks.alignment import EventAlignment, align
from arramon_dataset.release.landmarks.kernels import kernel_frames, likelihood
from arramon_dataset.release.landmarks.mentions import METAL, METAL_BENCH, SCENERY, Event, events_of
from arramon_dataset.release.landmarks.mixture import MentionsOfKind, Peak, peaks_of
from arramon_dataset.release.landmarks.turn_paths import Numbers, TurnPath, paths_of_turns
from arramon_server.episodes.episode import Episode

ROUNDS = 2
"""Number of alignments with the map of the alignment before. With more, peaks fragment."""

CERTAIN = 10.0
"""Minimum votes of a landmark that is kept in any case: on val-seen, held-out halves confirm 80 to 87% of such peaks
within 2.5 units (by chance 2%)."""

ENOUGH = 2.5
"""Minimum votes of a landmark that is kept if both halves of the episodes mention it: peaks of 4 to 10 votes are
confirmed at 36 to 71% (by chance 2 to 20%). Those of 2.5 to 4 are kept because held-out texts are then true more
often: in sections 1, 2 and 5 of val-seen in 68% of turns instead of 64%. A limit of 2.0 gains nothing more."""

HALF = 0.5
"""Minimum votes with which a half of the episodes mentions a landmark."""

AGREED = 2.0
"""Maximum distance of a half's peak from the landmark, in units."""

SIGNIFICANT = 0.02
"""Minimum probability of a mention's place that votes."""

CELL = 1.0
"""Side of the mixture's cells, in units."""

REACH = {"banner": 6.0}
"""Maximum distance of things from paths, by kind, in units."""

GROUND = 3.0
"""The same of all other kinds."""

ABSENT = 0.15
"""Likelihood of a mention without a known landmark, relative to the best place."""

MIN_NAME_SHARE = 0.1
"""Minimum share of a landmark's colour mentions for a colour to be one of its names."""

DOUBT = 3.0
"""Number of votes of a landmark with half the full strength in an alignment."""


@dataclass(frozen=True, eq=False)
class TurnText:
    """One turn's text as events, with the path that it describes.

    Attributes:
        episode: its id.
        turn: 1 or 2.
        language: of the text.
        path: of the turn.
        events: of the text.
    """

    episode: str
    turn: int
    language: str
    path: TurnPath
    events: tuple[Event, ...]


@dataclass(frozen=True, slots=True)
class RecoveredLandmark:
    """A recovered landmark.

    Attributes:
        kind: of `mentions.SCENERY`.
        x, z: in units.
        colour: the most frequent one in texts; "" if none states one.
        look: likewise.
        names: all colours that texts state with a share of at least MIN_NAME_SHARE.
        votes: expected number of mentions of it.
        halves: votes of each half of the episodes for the same place.
        languages: votes of each language's texts, by code.
    """

    kind: str
    x: float
    z: float
    colour: str
    look: str
    votes: float
    names: tuple[str, ...] = ()
    halves: tuple[float, float] = (0.0, 0.0)
    languages: tuple[tuple[str, float], ...] = ()


@dataclass
class LandmarkMap:
    """Known landmarks of a section: for each kind n places, strengths in [0, 1], and colours."""

    places: dict[str, Numbers] = field(default_factory=dict)
    strengths: dict[str, Numbers] = field(default_factory=dict)
    colours: dict[str, list[str]] = field(default_factory=dict)

    @classmethod
    def of(cls, landmarks: Mapping[str, Sequence[tuple[float, float, float, str]]]) -> "LandmarkMap":
        """Return the map of landmarks by kind, each with x, z, strength and colour ("" for any)."""
        known = cls()
        for kind, listed in landmarks.items():
            if listed:
                known.places[kind] = np.array([(x, z) for x, z, _, _ in listed])
                known.strengths[kind] = np.array([strength for _, _, strength, _ in listed])
                known.colours[kind] = [colour for _, _, _, colour in listed]
        return known

    def fit(self, event: Event, path: TurnPath) -> Numbers:
        """Return the likelihood (n,) of a mention at each place of a path."""
        if event.kind not in self.places:
            return np.ones(len(path.places))
        origins, directions = kernel_frames(event, path)
        values = likelihood(event, origins, directions, self.places[event.kind])
        strengths = self.strengths[event.kind]
        if event.colour:
            same = [colour in ("", event.colour) for colour in self.colours[event.kind]]
            strengths = strengths * np.where(same, 1.0, 0.2)
        found: Numbers = ABSENT + (1.0 - ABSENT) * np.minimum(values @ strengths, 1.0)
        return found


def turn_texts(episode: Episode) -> list[TurnText]:
    """Return the texts of an episode as events, in all its languages, turn by turn."""
    paths = paths_of_turns(episode)
    return [
        TurnText(episode.episode_id, number + 1, language, path, events_of(texts[number].navigation, language))
        for number, path in enumerate(paths)
        for language, texts in sorted(episode.instructions.items())
    ]


def recover(texts: Sequence[TurnText]) -> list[RecoveredLandmark]:
    """Return the landmarks of a section on which its texts agree; the same texts give the same result."""
    texts = [each for each in texts if each.events]
    known = LandmarkMap()
    by_kind: dict[str, tuple[MentionsOfKind, Numbers]] = {}
    for _ in range(ROUNDS + 1):
        aligned = [align(each.events, each.path, known.fit) for each in texts]
        by_kind = {kind: _mentions_of_kind(kind, texts, aligned) for kind in SCENERY}
        known = LandmarkMap.of(
            {
                _kind(recovered_kind): _strengths(peaks_of(mentions, 1.0))
                for recovered_kind, (mentions, _) in by_kind.items()
            }
        )
    return [landmark for kind, (mentions, halves) in by_kind.items() for landmark in _confirmed(kind, mentions, halves)]


def _strengths(peaks: Sequence[Peak]) -> list[tuple[float, float, float, str]]:
    return [
        (peak.x, peak.z, peak.votes / (peak.votes + DOUBT), peak.colours[0][0] if peak.colours else "")
        for peak in peaks
    ]


def _mentions_of_kind(
    kind: str, texts: Sequence[TurnText], aligned: Sequence[EventAlignment]
) -> tuple[MentionsOfKind, Numbers]:
    """Return the mentions of a kind, and for each the half of the episodes (0 or 1) that it belongs to."""
    cells = _cells(np.concatenate([each.path.places for each in texts]), REACH.get(kind, GROUND))
    rows, weights, colours, looks, languages, halves = [], [], [], [], [], []
    order = {episode: number for number, episode in enumerate(sorted({each.episode for each in texts}))}
    for each, found in zip(texts, aligned, strict=True):
        for event, posterior in zip(each.events, found.posterior, strict=True):
            if event.recovered_kind != kind:
                continue
            rows.append(mention_likelihood(event, each.path, posterior, cells))
            weights.append(event.weight)
            colours.append(event.colour)
            looks.append(event.look)
            languages.append(each.language)
            halves.append(order[each.episode] % 2)
    likely = np.array(rows).reshape(-1, len(cells))
    return MentionsOfKind(cells, likely, np.array(weights), colours, looks, languages), np.array(halves)


def mention_likelihood(event: Event, path: TurnPath, posterior: Numbers, cells: Numbers) -> Numbers:
    """Return the likelihood (g,) of a mentioned thing in each of the cells (g, 2)."""
    chosen = np.flatnonzero(posterior >= SIGNIFICANT)
    origins, directions = kernel_frames(event, path)
    voted: Numbers = posterior[chosen] @ likelihood(event, origins[chosen], directions[chosen], cells)
    return voted


def _cells(walked: Numbers, reach: float) -> Numbers:
    """Return the cells within reach of a path, (g, 2) of (x, z)."""
    low, high = np.floor(walked.min(axis=0) - reach), np.ceil(walked.max(axis=0) + reach)
    x, z = np.meshgrid(np.arange(low[0], high[0], CELL), np.arange(low[1], high[1], CELL), indexing="ij")
    cells = np.stack([x.ravel(), z.ravel()], axis=1)
    near: Numbers = cells[cKDTree(np.unique(walked.round(1), axis=0)).query(cells)[0] <= reach]
    return near


def _confirmed(kind: str, mentions: MentionsOfKind, halves: Numbers) -> list[RecoveredLandmark]:
    """Return the peaks with CERTAIN votes, or that both halves of the episodes confirm."""
    by_half = [peaks_of(mentions.subset(np.flatnonzero(halves == half)), HALF) for half in (0, 1)]
    found = []
    for peak in peaks_of(mentions, ENOUGH):
        votes = [
            max((p.votes for p in listed if np.hypot(p.x - peak.x, p.z - peak.z) <= AGREED), default=0.0)
            for listed in by_half
        ]
        if peak.votes >= CERTAIN or min(votes) >= HALF:
            colour = peak.colours[0][0] if peak.colours else ""
            look = peak.looks[0][0] if peak.looks else ""
            place = (round(peak.x, 2), round(peak.z, 2))
            by_half_votes = (round(votes[0], 1), round(votes[1], 1))
            said = sum(votes for _, votes in peak.colours)
            names = tuple(name for name, votes in peak.colours if votes >= max(1.0, MIN_NAME_SHARE * said))
            found.append(
                RecoveredLandmark(
                    _kind(kind), *place, colour, look, round(peak.votes, 1), names, by_half_votes, peak.languages
                )
            )
    return found


def _kind(recovered_kind: str) -> str:
    """Return the kind of street furniture that a recovered kind belongs to."""
    return METAL[0] if recovered_kind == METAL_BENCH else recovered_kind
