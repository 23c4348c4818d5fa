"""Makes the film of an episode from the journal and the data folder, for the host."""

from dataclasses import dataclass
from pathlib import Path

from arramon_server.episodes.splits import read_splits
from arramon_server.errors import BadInput, Conflict, NotFound, StorageError, quoted
from arramon_server.playback.pictures import as_jpeg, draw
from arramon_server.runs.results.reports import split_as_played
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.sim.raster.camera import compile_kernels
from arramon_server.web.film.page import film_page
from arramon_server.web.film.pictures import pictures
from arramon_server.web.film.video import check_mp4, write_mp4, write_webp
from arramon_server.web.page_texts import all_texts
from arramon_server.web.watch.playbacks import Playbacks
from arramon_server.web.watch.watch_part import WatchPart
from arramon_server.web.watch.watched_runs import WatchedEpisode, WatchedRun


@dataclass(frozen=True, slots=True)
class FilmSettings:
    """How a film is made.

    Attributes:
        path: the file, whose suffix chooses its format: .webp, .mp4 or .html.
        language: language of the labels.
        steps: first and last step; None for all.
        fps: steps a second.
        size: side of a frame, in pixels.
        quality: 1 to 100.
    """

    path: Path
    language: str
    steps: tuple[int, int] | None
    fps: float
    size: int
    quality: int


@dataclass(frozen=True, slots=True)
class MadeFilm:
    """A film that was made.

    Attributes:
        path: the file.
        pictures: number of its pictures.
        split: name of the run's split.
        hidden: whether that is hidden.
    """

    path: Path
    pictures: int
    split: str
    hidden: bool


class FilmMaker:
    """Makes films.

    Args:
        database: database of the journal.
        data: the data folder.
        camera: camera of the server's runs.
    """

    def __init__(self, database: Database, data: Path, camera: str) -> None:
        self._journal = Journal(database)
        self._splits = read_splits(data)
        self._playbacks = Playbacks(self._journal, self._splits, camera)
        self._part = WatchPart(self._playbacks, self._journal)

    def make(self, run_id: str, episode_id: str, settings: FilmSettings) -> MadeFilm:
        """Make a film.

        Raises:
            NotFound: if there is no such run or episode.
            Conflict: if nothing of it is played, or the data of its split has changed.
            BadInput: if a setting is wrong, or PyAV is needed and not installed.
            StorageError: if the file cannot be written.
        """
        if settings.language not in all_texts():
            raise BadInput(f"--lang is {settings.language!r}, expected one of {', '.join(all_texts())}")
        if settings.path.suffix.lower() == ".mp4":
            check_mp4()
        watched = self._episode(run_id, episode_id)
        opened = self._playbacks.of(watched, drawn=True)
        last = opened.playback.steps
        if last == 0:
            raise Conflict(f"episode {quoted(episode_id)} of run {run_id!r} has no steps yet")
        first, until = settings.steps or (0, last)
        if until > last:
            raise BadInput(f"--steps ends with {until}, expected at most {last}, the last step of the episode")
        compile_kernels()
        try:
            self._write(watched, settings, range(first, until + 1))
        except OSError as error:
            raise StorageError(f"cannot write {settings.path}: {error.strerror or error}") from error
        return MadeFilm(settings.path, until + 1 - first, watched.run.split, watched.watched.split.hidden)

    def _episode(self, run_id: str, episode_id: str) -> WatchedEpisode:
        run = self._journal.run(run_id)
        split = split_as_played(run, self._splits)
        state = self._journal.episode_state(run_id, episode_id) if episode_id in split.episodes else None
        if state is None:
            raise NotFound(f"run {run_id!r} has no episode {quoted(episode_id)}")
        return WatchedEpisode(WatchedRun(run, split, None, is_own=True), split.episodes[episode_id], state[1])

    def _write(self, watched: WatchedEpisode, settings: FilmSettings, steps: range) -> None:
        t = all_texts()[settings.language]
        context = self._part.context(t, watched, {"step": str(steps[0])})
        opened = self._playbacks.of(watched)
        kind = settings.path.suffix.lower()
        if kind == ".html":
            data = self._part.data(t, watched, 0)
            moments = [opened.playback.moment(step) for step in range(data["last"] + 1)]
            frames = [as_jpeg(draw(opened.world, one.state, settings.size), settings.quality) for one in moments]
            devanagari = "hi" in (t.language, watched.run.language)
            page = film_page(t, context, {**data, "live": False, "next": ""}, frames, devanagari=devanagari)
            settings.path.write_bytes(page)
            return
        shown = pictures(t, context, self._part.views(t, watched), opened, steps, settings.size)
        write = write_mp4 if kind == ".mp4" else write_webp
        write(settings.path, shown, settings.fps, settings.quality)
