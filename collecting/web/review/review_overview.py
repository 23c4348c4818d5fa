"""Template variables of the host's overview: figures of a collection, and the list of its texts."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from arramon_collecting.episodes import episodes_to_write, golds
from arramon_collecting.review.figures import Overview, decided_episodes, gold_tasks, overview_of, walks_by_text
from arramon_collecting.rules.agreement import flag_alpha
from arramon_collecting.rules.flags import FLAGS
from arramon_collecting.storage.records import REVIEW_KIND, Collection
from arramon_collecting.storage.texts.records import (
    DISCARDED,
    IN_REVIEW,
    KEPT,
    REJECTED,
    SENT_BACK,
    VERIFYING,
    WITHDRAWN,
    Text,
)
from arramon_collecting.storage.work.records import OPEN, SUBMITTED
from arramon_collecting.web.review.host_view import CollectionRows, percent, score
from arramon_server.episodes.splits import Split
from arramon_server.web.page_texts import PageTexts

STATES = (IN_REVIEW, VERIFYING, KEPT, DISCARDED, SENT_BACK, REJECTED, WITHDRAWN)
"""States of texts, in the order in which hosts choose them."""

LISTED = 200
"""Maximum number of texts on the page."""

EXCERPT = 80
"""Characters of a text in the list."""


@dataclass(frozen=True, slots=True)
class TextRow:
    """A text in the list, with the beginning of its first instruction, and the numbers of its walks and flags."""

    text: Text
    excerpt: str
    walks: int
    flags: int


def overview_context(
    t: PageTexts, collection: Collection, rows: CollectionRows, split: Split | None, state: str, now: datetime
) -> dict[str, Any]:
    """Return the template variables.

    Args:
        t: texts of the page's language.
        collection: the collection.
        rows: its rows.
        split: its split; None if it is not served.
        state: state of the texts to list; others than STATES are those in review.
        now: the time.
    """
    overview = overview_of(rows.tasks, rows.texts, rows.verifications, rows.ledger, collection.settings)
    chosen = state if state in STATES else IN_REVIEW
    listed = [text for text in rows.texts if text.state == chosen]
    ended = [task.ended_at for task in rows.tasks if task.state == SUBMITTED and task.ended_at is not None]
    alpha, has_alpha = _alpha(rows)
    is_review = collection.kind == REVIEW_KIND
    all_episodes = len(rows.texts) if is_review or split is None else len(episodes_to_write(split, collection))
    return {
        "overview": overview,
        "done": len(decided_episodes(rows.texts, collection.kind)),
        "all_episodes": max(all_episodes, 1),
        "open_tasks": sum(task.state == OPEN for task in rows.tasks),
        "today": sum(now - at < timedelta(days=1) for at in ended),
        "week": sum(now - at < timedelta(days=7) for at in ended),
        "shares": [] if is_review else _shares(t, collection, overview, alpha),
        "has_alpha": has_alpha or is_review,
        "is_review": is_review,
        "golds": len(golds(split, collection)) if split is not None and not is_review else None,
        "states": STATES,
        "chosen": chosen,
        "rows": _text_rows(listed[:LISTED], rows),
        "more": max(0, len(listed) - LISTED),
    }


def _shares(t: PageTexts, collection: Collection, overview: Overview, alpha: float | None) -> list[tuple[str, str]]:
    return [
        ("success", percent(t, overview.success)),
        ("gold_success", percent(t, overview.gold_success)),
        ("kept_ndtw", score(t, overview.kept_ndtw)),
        ("agreement_path", score(t, overview.agreement.path)),
        ("agreement_cell", percent(t, overview.agreement.cell)),
        ("alpha", score(t, alpha)),
        ("paid", collection.settings.money(sum(overview.paid.values()))),
    ]


def _alpha(rows: CollectionRows) -> tuple[float | None, bool]:
    """Return Krippendorff's alpha over the flags, and whether the package that computes it is installed."""
    try:
        return flag_alpha(walks_by_text(rows.verifications, gold_tasks(rows.tasks)), FLAGS), True
    except ModuleNotFoundError:
        return None, False


def _text_rows(texts: Sequence[Text], rows: CollectionRows) -> list[TextRow]:
    walks, flags = Counter[str](), Counter[str]()
    for one in rows.verifications:
        if one.text_id is not None:
            walks[one.text_id] += one.counts
            flags[one.text_id] += len(one.flags)
    return [TextRow(text, excerpt(text), walks[text.text_id], flags[text.text_id]) for text in texts]


def excerpt(text: Text) -> str:
    """Return the beginning of a text's first instruction; of a deleted text, that of its id."""
    said = text.instructions[0][0] if text.instructions else text.text_id[:8]
    return said if len(said) <= EXCERPT else f"{said[:EXCERPT]}…"
