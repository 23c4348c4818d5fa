"""Scores of what a person has just played: an episode with its maps on open splits, and the totals of a run."""

import asyncio
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TypeAlias

from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict, NotFound, Unavailable, quoted
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.run_service import RunService
from arramon_server.runs.storage.causes import FORFEITED
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import Run
from arramon_server.scoring.aggregate import ROWS
from arramon_server.web.episode_replays import EpisodeReplays
from arramon_server.web.episodes_page import NOTHING, failure_of, map_labels, pile_name
from arramon_server.web.named_things import object_name
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.play.turn_verdicts import turn_verdict
from arramon_server.web.rendering import Renderer
from arramon_server.web.standings_page import columns
from arramon_server.web.standings_query import METRICS

MAX_WAITING = 32
"""Maximum number of requests that wait for the thread; further ones are refused."""


Shown: TypeAlias = tuple[str, list[bool]]
"""HTML, and for each turn of the episode, or of all episodes that are shown, whether it is right."""


class PlayedScores:
    """Renders parts of the play page, in a thread of their own.

    Args:
        runs: reports of ended runs.
        journal: endings and actions of episodes.
        splits: the splits served, by name.
        renderer: renders the templates.
    """

    def __init__(self, runs: RunService, journal: Journal, splits: Mapping[str, Split], renderer: Renderer) -> None:
        self._runs = runs
        self._journal = journal
        self._splits = splits
        self._renderer = renderer
        self._replays = EpisodeReplays(splits, journal)
        self._thread = ThreadPoolExecutor(1, "played")
        self._waiting = 0

    def close(self) -> None:
        """End the thread."""
        self._thread.shutdown(wait=True, cancel_futures=True)
        self._replays.close()

    async def html(self, caller: Caller, run: Run, episode_id: str, t: PageTexts) -> Shown:
        """Return the scores of an episode that has ended, or of the ended run if `episode_id` is empty, as HTML.

        Also return for each turn whether it is right; for a run, those of all episodes that its report shows.

        Raises:
            NotFound: if the run has no such episode that has ended.
            Conflict: if its split is hidden or frozen, or the run has not ended.
            Unavailable: if too many requests wait.
        """
        if self._waiting >= MAX_WAITING:
            raise Unavailable("too many scores are being drawn; try again in a moment")
        self._waiting += 1
        try:
            work = self._totals if not episode_id else self._episode
            return await asyncio.get_running_loop().run_in_executor(self._thread, work, caller, run, episode_id, t)
        finally:
            self._waiting -= 1

    def _episode(self, caller: Caller, run: Run, episode_id: str, t: PageTexts) -> Shown:  # noqa: ARG002, as `_totals`
        split = self._splits.get(run.split)
        if split is None or split.hidden or split.data_hash != run.data_hash:
            raise Conflict(f"the split {run.split!r} shows no scores of single episodes")
        self._runs.closing.check_shown(run.split)
        ending = next((one for one in self._journal.endings(run.run_id) if one.episode_id == episode_id), None)
        if ending is None:
            raise NotFound(f"run {run.run_id!r} has no ended episode {quoted(episode_id)}")
        played = self._replays.draw(run, ending)
        objects = [
            (turn.target.type, room.carried) for turn, room in zip(played.episode.turns, played.room_maps, strict=True)
        ]
        gave_up = [ending.cause == FORFEITED and not room.forced for room in played.room_maps]
        verdicts = [
            turn_verdict(scores, target, carried, forced=track.forced, gave_up=gave)
            for scores, (target, carried), track, gave in zip(
                ending.scores, objects, played.tracks, gave_up, strict=True
            )
        ]
        placed = [verdict.is_right for verdict in verdicts]
        context = {
            "played": played,
            "verdicts": [(verdict, *objects[number]) for number, verdict in enumerate(verdicts)],
            "right": sum(placed),
            "metrics": METRICS,
            "columns": columns(t),
            "failures": [failure_of(turn) for turn in ending.scores],
            "spoken": run.language,
            "path_text": partial(t.in_groups, ("play_path", "path")),
            "labels": [map_labels(t, run.language, played, turn) for turn in range(2)],
            "object_name": lambda type_: object_name(t, type_),
            "pile_name": lambda pile: pile_name(t, pile),
        }
        return self._renderer.page("play_episode.html", t, "", context).decode(), placed

    def _totals(self, caller: Caller, run: Run, episode_id: str, t: PageTexts) -> Shown:  # noqa: ARG002, as `_episode`
        report = self._runs.report(caller, run.run_id)
        rows = [(t(f"turns.{name.removeprefix('turn ')}"), report.table.rows[name]) for name in ROWS]
        objects = [(t("play_path.turn", turn=turn), report.table.rows[f"turn {turn}"]) for turn in (1, 2)]
        context = {
            "report": report,
            "rows": rows,
            "plain_rows": objects,
            "metrics": METRICS,
            "columns": columns(t),
            "episodes": [
                (ending.episode_id, sum(failure_of(turn) == NOTHING for turn in ending.scores))
                for ending in report.endings
            ],
            "is_watchable": run.account is None,  # People with a token would first have to sign in there.
        }
        return self._renderer.page("play_totals.html", t, "", context).decode(), [
            failure_of(turn) == NOTHING for ending in report.endings for turn in ending.scores
        ]
