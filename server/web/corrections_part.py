"""Sentences on the pages about a split's corrections and about when its leaderboard closes."""

from arramon_server.closing_times import ClosingTimes
from arramon_server.runs.storage.corrections import Correction
from arramon_server.web.page_texts import PageTexts

_NAMED = 5
"""Maximum number of a correction's episodes that are named."""


def correction_sentence(t: PageTexts, correction: Correction) -> str:
    """Return a sentence that says what a correction changed, when and why."""
    episodes = ", ".join(correction.episodes[:_NAMED]) + (", …" if len(correction.episodes) > _NAMED else "")
    what = t(
        f"corrections.{correction.kind.value}",
        number=t.whole(len(correction.episodes)),
        episodes=episodes,
        before=(correction.data_before or "")[:12],
        after=(correction.data_after or "")[:12],
    )
    return t("corrections.one", date=t.date(correction.made_at), what=what, reason=correction.reason)


def closing_sentence(t: PageTexts, closing: ClosingTimes, split: str) -> str:
    """Return a sentence that says when a split's leaderboard closes or closed; empty if it stays open."""
    time = closing.of(split)
    if time is None:
        return ""
    if closing.is_closed(split):
        return t("closing.closed", time=t.moment(time))
    return t("closing.frozen" if closing.is_frozen(split) else "closing.open", time=t.moment(time))
