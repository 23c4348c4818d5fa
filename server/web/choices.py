"""What a reader chose to see of the standings, as it stands in the page's address."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from urllib.parse import urlencode

from server.board.standings import BOTH, COLUMNS, HEADLINE, PRIVILEGED, TOTAL, Mark, Standing
from server.errors import NotFound

TURNS = {"total": TOTAL, "1": "turn 1", "2": "turn 2"}
"""Whose scores are shown -> row of a score table."""

EVERY = "all"

SENSORS = (EVERY, "plain", "segmentation", "privileged")
"""No more than images and depth; a segmentation, but nothing that no camera shows; and what no camera shows."""

COVERAGES = (EVERY, "whole", "partial")

METRICS = {metric.partition("@")[0].lower(): metric for metric in COLUMNS}
"""A metric's name in addresses -> the metric."""

WORDS = ("agent", "published")
"""What else can be sorted by. Ranks are then by the headline metric."""

ASCENDING, DESCENDING = "asc", "desc"

_CHOICES: Mapping[str, tuple[str, ...]] = {
    "turns": tuple(TURNS),
    "sensors": SENSORS,
    "coverage": COVERAGES,
    "sort": (*METRICS, *WORDS),
    "order": (ASCENDING, DESCENDING),
}


@dataclass(frozen=True, slots=True)
class Choice:
    """What is shown, and in which order.

    Attributes:
        split: by name.
        language: of the instructions, or BOTH.
        turns: one of TURNS.
        sensors: one of SENSORS.
        coverage: one of COVERAGES.
        sort: one of METRICS or WORDS.
        order: ascending or descending.
        page: from 1.
    """

    split: str
    language: str
    turns: str = "total"
    sensors: str = EVERY
    coverage: str = EVERY
    sort: str = HEADLINE.partition("@")[0].lower()
    order: str = DESCENDING
    page: int = 1

    @property
    def metric(self) -> str:
        """By which the standings are ranked."""
        return METRICS.get(self.sort, HEADLINE)

    def link(self, **changes: object) -> str:
        """The address of another choice; what is as usual is left out."""
        changed = {"page": 1, **changes}
        other = replace(self, **changed)  # type: ignore[arg-type]
        usual = Choice(other.split, other.language)
        named = {field.name: getattr(other, field.name) for field in fields(other)}
        shown = {k: v for k, v in named.items() if k in ("split", "language") or v != getattr(usual, k)}
        return "?" + urlencode(shown)

    def sorting(self, column: str) -> str:
        """The address of the same, sorted by a column; by one that is sorted by already, the other way round."""
        usual = ASCENDING if column == "agent" else DESCENDING
        turned = ASCENDING if self.order == DESCENDING else DESCENDING
        return self.link(sort=column, order=turned if column == self.sort else usual)

    def fits(self, standing: Standing) -> bool:
        """Whether a standing is among what was chosen."""
        kinds = {
            EVERY: True,
            "plain": set(standing.sensors) <= {"rgb", "depth"},
            "segmentation": "segmentation" in standing.sensors and not PRIVILEGED.intersection(standing.sensors),
            "privileged": bool(PRIVILEGED.intersection(standing.sensors)),
        }
        partial = Mark.PARTIAL in standing.marks
        return kinds[self.sensors] and self.coverage in (EVERY, "partial" if partial else "whole")

    def sorted(self, standings: list[Standing]) -> list[Standing]:
        """Standings, as the board ranked them, in the chosen order; those without a rank come last by any metric."""
        down = self.order == DESCENDING
        if self.sort == "published":
            return sorted(standings, key=lambda one: max(e.published_at for e in one.entries), reverse=down)
        if self.sort == "agent":
            return sorted(standings, key=lambda one: (one.agent.casefold(), one.participant.casefold()), reverse=down)
        ordered = standings if down else standings[::-1]
        if TURNS[self.turns] != TOTAL:
            row = TURNS[self.turns]
            ordered = sorted(ordered, key=lambda one: one.rows[row][self.metric].mean, reverse=down)
        return sorted(ordered, key=lambda one: not one.is_ranked)


def read_choice(query: Mapping[str, str], languages: Mapping[str, tuple[str, ...]], usual: Choice) -> Choice:
    """The choice that an address makes.

    Args:
        query: its query.
        languages: of each split that there is.
        usual: where the address leaves something open.

    Raises:
        NotFound: for what cannot be chosen.
    """
    chosen = {name: query[name] for name in ("split", "language", *_CHOICES) if name in query}
    split = chosen.get("split", usual.split)
    if split not in languages:
        raise NotFound(f"there is no split {split!r}")
    spoken = {language for codes in languages.values() for language in codes}
    if languages[split] and chosen.setdefault("language", usual.language) in spoken - set(languages[split]):
        chosen["language"] = languages[split][0]  # a reader who changes the split alone comes to what it has
    choices = {**_CHOICES, "language": (*spoken, BOTH)}
    for name, value in chosen.items():
        if name != "split" and value not in choices[name]:
            raise NotFound(f"there is no {name} {value!r}")
    page = query.get("page", "1")
    if not (page.isascii() and page.isdecimal() and int(page[:6]) > 0):
        raise NotFound(f"there is no page {page!r}")
    return replace(usual, **chosen, page=int(page[:6]))
