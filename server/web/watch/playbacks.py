"""Playbacks of watched episodes, replayed from the journal and cached; those still played grow with every look."""

from collections import OrderedDict

from arramon_server.playback.moments import Playback
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.journal import Journal
from arramon_server.sim.rules import Limits
from arramon_server.playback.collision_checks import CollisionChecks
from arramon_server.web.watch.watched_runs import WatchedEpisode

_CACHE_SIZE = 48
"""Number of cached playbacks, about 0.2 MB each."""


class Playbacks:
    """Playbacks of watched episodes. Only one thread may use it at a time.

    Args:
        journal: source of the actions.
        checks: collision checks.
    """

    def __init__(self, journal: Journal, checks: CollisionChecks) -> None:
        self._journal = journal
        self._checks = checks
        self._kept = OrderedDict[tuple[str, str, str], tuple[Playback, bool]]()

    def of(self, watched: WatchedEpisode) -> Playback:
        """Return the playback of an episode, with all steps that are recorded by now."""
        run, episode = watched.run, watched.episode
        key = (run.run_id, episode.episode_id, run.data_hash)
        playback, is_complete = self._kept.pop(key, (None, False))
        if playback is None:
            section = watched.watched.split.sections[episode.section]
            check = self._checks.of(section, episode.furniture)
            playback = Playback(episode, check, Limits(run.steps_per_phase))
        if not is_complete:
            ending = watched.ending
            if ending is None or ending.has_played:
                playback.extend(self._journal.actions(run.run_id, episode.episode_id, playback.steps))
            if ending is not None and ending.cause == causes.TIME_LIMIT and not playback.is_finished:
                playback.end_at_time_limit()
        self._kept[key] = (playback, not watched.is_live)
        while len(self._kept) > _CACHE_SIZE:
            self._kept.popitem(last=False)
        return playback
