"""Template variables of a run's page. Pages of runs on hidden splits show totals only."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from arramon_server.board.board import Board
from arramon_server.board.cost import Cost
from arramon_server.board.epoch_board import EpochBoard
from arramon_server.board.standings import Entry, Mark
from arramon_server.episodes.splits import Split
from arramon_server.errors import NotFound
from arramon_server.runs.results.breakdown import Breakdowns
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.corrections import voided_by
from arramon_server.runs.storage.records import CANCELLED, Run, RunProgress
from arramon_server.scoring.episode_scores import GATES, PLACEMENT
from arramon_server.visible_text import shown
from arramon_server.web import curves
from arramon_server.web.breakdown_part import BreakdownPart, breakdown_part
from arramon_server.web.corrections_part import closing_sentence, correction_sentence
from arramon_server.web.episode_replays import EpisodeReplays
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.standings_page import columns
from arramon_server.web.standings_query import METRICS, TURNS, StandingsQuery

_ROW_ORDER = ("1", "2", "total")
"""Rows of a score table, as in `arramon_server.scoring.aggregate.ROWS`."""

_MAX_CURVE_ROWS = 24
"""Maximum number of rows in the table of a curve's values."""


_COLOURS = {
    causes.AGENT_FINISHED: 1,
    causes.STEP_LIMIT: 2,
    causes.TIME_LIMIT: 3,
    causes.FORFEITED: 4,
    causes.SERVER_FAULT: 5,
}
"""Cause -> number of its colour in the style sheet."""


class RunPage:
    """Builds the variables of the page.

    Args:
        board: the leaderboard, with the published runs.
        splits: the splits served, by name.
        replays: draws episodes.
        epochs: the epochs of hidden splits.
    """

    def __init__(self, board: Board, splits: Mapping[str, Split], replays: EpisodeReplays, epochs: EpochBoard) -> None:
        self._board = board
        self._epochs = epochs
        self._splits = splits
        self._replays = replays
        self._breakdowns = Breakdowns(splits, replays.play_digest_of)

    def context(self, t: PageTexts, run_id: str) -> dict[str, Any]:
        """Return the variables of a run's template.

        Raises:
            NotFound: if the run is not published.
        """
        entry = self._board.entry(run_id)
        run = entry.run
        split = self._splits.get(run.split)
        is_open = self._replays.split(entry) is not None
        return {
            "entry": entry,
            "hidden": split is not None and split.hidden,
            "marks": [*entry.marks, *(["cancelled"] if run.state == CANCELLED else [])],
            "rows": [(t(f"turns.{name}"), TURNS[name]) for name in _ROW_ORDER],
            "gated": [(_gate(t, metric), metric) for metric in _placements()],
            "causes": _causes(entry),
            "ctc": curves.ctc_chart(entry.rows) if entry.rows else None,
            "open": self._open(entry) if is_open else None,
            "frame": curves.FRAME,
            "report": self._report(t, entry),
            "facts": self._facts(t, entry),
            "back": f"/{t.language}/{StandingsQuery(run.split, run.language).link()}",
            "verify": _verify(entry),
            "has_actions": self._epochs.shows_actions(run.split),
            "episodes": self._replays.examples(entry),
            "reproductions": self._board.reproductions(run_id),
            "original": self._original(entry),
            "closes": closing_sentence(t, self._board.closing, run.split),
            "corrections": [correction_sentence(t, correction) for correction in entry.corrections],
            "metrics": METRICS,
            "columns": columns(t),
        }

    def _original(self, entry: Entry) -> Entry | None:
        """Return the run that a reproduction repeats; None if there is none, or it is not published any more."""
        try:
            return self._board.entry(entry.reproduces) if entry.reproduces else None
        except NotFound:
            return None

    def _report(self, t: PageTexts, entry: Entry) -> BreakdownPart | None:
        """Return the breakdown; None if the data has changed, so that the groups are unknown, or while it is frozen."""
        if Mark.OTHER_DATA in entry.marks or entry.frozen:
            return None
        voided = voided_by(self._board.corrections(entry.run.split))
        endings = self._replays.endings(entry)
        if voided.issuperset(ending.episode_id for ending in endings):
            return None
        return breakdown_part(t, self._breakdowns.of(entry.run, endings, voided))

    def _open(self, entry: Entry) -> dict[str, Any]:
        shares = curves.unfinished_shares([ending.steps for ending in self._replays.endings(entry)])
        every = -(-len(shares) // _MAX_CURVE_ROWS)
        return {"chart": curves.unfinished_chart(shares), "shares": [*shares[:-1:every], shares[-1]]}

    def _facts(self, t: PageTexts, entry: Entry) -> list[tuple[str, str]]:
        run, progress, attempts = entry.run, entry.progress, entry.attempts
        episodes = t.whole(progress.episodes)
        if entry.coverage is not None:
            episodes = t("run.episodes_of", number=episodes, all=t.whole(round(progress.episodes / entry.coverage)))
        sensors = ", ".join(t.named("sensors", name) for name in run.sensors) or t("sensors.none")
        facts = {
            "split": run.split,
            "language": t.named("languages", run.language),
            "episodes": episodes,
            "sensors": sensors,
            "images": ", ".join(progress.images) or "–",
            "arguments": ", ".join(shown(f"{name}={value}") for name, value in run.agent_arguments) or "–",
            "code": _code(t, run),
            "steps": t.whole(run.steps_per_phase),
            "clocks": _clocks(t, run),
            "steps_played": t.whole(progress.steps),
            "thinking": _thinking(t, progress),
            "cost": _cost(t, entry.cost) or "–",
            "attempts": t("run.attempts_of", published=t.whole(attempts.published), begun=t.whole(attempts.begun)),
            "state": t.named("states", run.state),
            "started": t.moment(run.created_at),
            "ended": t.moment(run.ended_at) if run.ended_at else "–",
            "published": t.moment(entry.published_at),
            "version": run.server_version,
            "data": run.data_hash,
            "identity": run.run_id,
        }
        left_out = ("steps_played", "thinking") if entry.frozen else ()
        return [(t(f"run.{name}"), value) for name, value in facts.items() if name not in left_out]


def _causes(entry: Entry) -> list[tuple[str, int, int, float, float]]:
    """Return `curves.bar_segments` of the causes, with colours; causes that this release knows come first."""
    counts = {name: entry.causes.get(name, 0) for name in (*_COLOURS, *sorted(entry.causes))}
    found = curves.bar_segments({name: number for name, number in counts.items() if number})
    return [(name, _COLOURS.get(name, len(_COLOURS)), number, begin, width) for name, number, begin, width in found]


def _code(t: PageTexts, run: Run) -> str:
    keys = {"url": "run.code_url", "commit": "run.code_commit", "image": "run.code_image"}
    return "; ".join(t(keys[name], value=value) for name, value in run.code.named().items()) or "–"


def _verify(entry: Entry) -> str:
    key = entry.receipt_fingerprint.public_key.hex() if entry.receipt_fingerprint is not None else ""
    return f"arramon-client verify {entry.run.run_id}.receipt.json --key {key}"


def _clocks(t: PageTexts, run: Run) -> str:
    clocks = {"step": run.step_seconds, "bank": run.bank_seconds}
    if not any(clocks.values()):
        return t("run.no_clocks")
    return t("run.clock_values", **{name: t("format.seconds", number=t.decimal(v)) for name, v in clocks.items()})


def _thinking(t: PageTexts, progress: RunProgress) -> str:
    if progress.seconds_a_step is None:
        return "–"
    seconds = t("format.seconds", number=t.amount(progress.seconds_a_step))
    return t("run.thinking_of", seconds=seconds, steps=t.whole(progress.timed_steps))


def _cost(t: PageTexts, cost: Cost) -> str:
    declared = {name: value for name, value in asdict(cost).items() if value is not None}
    return ", ".join(f"{t(f'cost.{name}')}: {t.amount(value)}" for name, value in declared.items())


def _placements() -> list[str]:
    """Return the placement metrics, ungated and with each gate."""
    return [*PLACEMENT, *(f"{name}@{gate}" for gate in GATES for name in PLACEMENT)]


def _gate(t: PageTexts, metric: str) -> str:
    name, _, gate = metric.partition("@")
    return f"{name}, " + (gate or t("run.not_gated"))
