"""A run that is played step by step, for example in a notebook or by a program that brings its own loop."""

import builtins
from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Unpack

from arramon_client.agent import Episode, Observation
from arramon_client.runs import opening
from arramon_client.runs.info import RunInfo
from arramon_client.runs.live_episode import LiveEpisode
from arramon_client.runs.opening import OpenedRun
from arramon_client.runs.options import CreateOptions, PlayOptions, ServerOptions
from arramon_client.runs.results import info_now, report_data, scores_of
from arramon_client.runs.waiting import wait_for

if TYPE_CHECKING:
    from arramon_client.agent import Note
    from arramon_client.receipts import Receipt

PARALLEL = 1
"""Default number of open episodes: a loop that plays them one after the other acts on one at a time."""


class Run:
    """A run, created by `Run.create` or `Run.resume`; a context manager that closes it.

    A run is one evaluation of an agent on a split, in one language. The server offers its episodes one by one:

        with Run.create(language="en", agent="my-model", split="val_seen") as run:
            for episode in run.episodes():
                while not episode.ended:
                    seen = episode.look()
                    episode.act(seen.step, choose_action(seen))
            print(run.report()["table"])

    A thread owns the stream, and reconnects when it breaks; an embedded server that has died is restarted. All methods
    may be called from any thread, so that several episodes can be played at once, each at its own pace. After an error
    that reconnecting cannot help, every call raises it; the run can be resumed.
    """

    def __init__(self, opened: OpenedRun) -> None:
        self._opened = opened

    @classmethod
    def create(cls, *, language: str, agent: str, **options: Unpack[CreateOptions]) -> "Run":
        """Create a run, and open its first episodes.

        Args:
            language: language of the instructions: "en", "hi", ...
            agent: name of the agent, shown on the leaderboard.
            options: see `CreateOptions`, `PlayOptions` and `ServerOptions`; without `server` an embedded server is
                started.

        Raises:
            UsageError: if an option is wrong, or the server does not have what it names.
            ArramonClientError: if the server cannot be reached or started, or refuses.
        """
        return cls(opening.create(language, agent, options, PARALLEL))

    @classmethod
    def resume(cls, run_id: str, *, history: bool = False, **options: Unpack[PlayOptions]) -> "Run":
        """Resume a run that another program, or an earlier one, has left open.

        Args:
            run_id: id of the run.
            history: whether `look` shows the recorded steps of open episodes again, with `Observation.taken`; acting on
                them with that action only moves on. They are in memory until then. Otherwise an episode continues with
                its present observation.
            options: see `PlayOptions` and `ServerOptions`.

        Raises:
            ArramonClientError: as for `create`; also if there is no such run.
        """
        return cls(opening.resume(run_id, options, PARALLEL, history=history))

    @staticmethod
    def list(**options: Unpack[ServerOptions]) -> builtins.list[RunInfo]:
        """Return the runs that the caller may see on a server, latest first.

        Args:
            options: see `ServerOptions`.

        Raises:
            ArramonClientError: if the server cannot be reached or started, or refuses.
        """
        return opening.list_runs(options)

    @property
    def run_id(self) -> str:
        """Id of the run."""
        return self._opened.run_id

    @property
    def info(self) -> RunInfo:
        """Description of the run, as of the latest message of the server; `ended` is always up to date."""
        return info_now(self._opened.live)

    def episodes(self) -> "Iterator[RunEpisode]":
        """Yield the run's episodes as the server offers them, until the run is over.

        At most `parallel` episodes are open at once: the server offers another one when one has ended. An episode of a
        resumed run that was played before comes first.

        Raises:
            ArramonClientError: if the connection is lost for too long, or the run is closed.
        """
        while (episode := wait_for(self._opened.next_episode())) is not None:
            yield RunEpisode(self._opened, episode)

    def wait(self) -> RunInfo:
        """Wait until the run is over, and return its description."""
        wait_for(self._opened.live.end_of_run())
        return self.info

    def report(self) -> dict[str, Any]:
        """Return the scores as plain data, the content of the results file (docs/reference/report.md).

        Raises:
            UsageError: if the run is not over.
        """
        return report_data(self._opened.report())

    def receipt(self) -> "Receipt":
        """Return the run's signed receipt, after verifying its signature and the server's key.

        Raises:
            UsageError: if the run is not over.
            ReceiptError: if it was altered, or signed with another key than the server's.
        """
        return self._opened.receipt()

    def cancel(self) -> None:
        """Cancel the run: its unfinished episodes are given up, and stay in the denominator of the scores."""
        self._opened.cancel()
        self.wait()

    def close(self) -> None:
        """Close the connection, and stop an embedded server. The run stays open, and can be resumed."""
        self._opened.close()

    def __enter__(self) -> "Run":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class RunEpisode:
    """An episode of a run.

    Its steps are numbered: `act` names the step that it answers, so that a repeated call never takes a step twice.
    """

    def __init__(self, opened: OpenedRun, live: LiveEpisode) -> None:
        self._opened, self._live = opened, live

    def __repr__(self) -> str:
        return f"<RunEpisode {self.episode_id}: {self.cause or 'open'}>"

    @property
    def episode_id(self) -> str:
        """Id of the episode, unique within the split."""
        return self._live.episode_id

    @property
    def episode(self) -> Episode:
        """What an agent gets when an episode begins: language, split, labels of segmentations."""
        return self._live.episode

    @property
    def ended(self) -> bool:
        """Whether the episode has ended."""
        return bool(self._live.cause)

    @property
    def cause(self) -> str:
        """Why the episode ended, such as "AGENT_FINISHED" or "TIME_LIMIT"; empty while it is open.

        "UNKNOWN" if it ended while the stream was broken, or with the run; the report then states the cause.
        """
        return self._live.cause

    @property
    def actions(self) -> tuple[int, ...]:
        """Actions recorded so far, from the first step on; the last one may not have been applied."""
        return self._live.recorded

    @property
    def stop_reason(self) -> str:
        """Why the latest plan stopped before its last action; empty if it did not, see `act`."""
        return self._live.stop_reason

    def look(self) -> Observation:
        """Return the observation that awaits an action, waiting for it if necessary.

        It stays the same until it is acted on, and nothing is sent. Of an ended episode it is the last one.

        Raises:
            EpisodeLostError: if another client has taken over the episode.
            UsageError: if the episode ended before its first observation.
            ArramonClientError: if the connection is lost for too long, or the run is closed.
        """
        return wait_for(self._live.look())

    def act(self, step: int, actions: int | Sequence[int], note: "Note | None" = None) -> Observation | None:
        """Take a step, or several one after the other (a plan), and return the next observation.

        A plan stops after an action whose effect was not expected, and `stop_reason` states why:

        - "phase over": the phase or the turn has changed;
        - "blocked": FORWARD did not move the agent: its pose is the same or, without the sensor "pose", every image is
          identical. Without any of these sensors this is not detected;
        - "no pick-up": INTERACT picked up nothing;
        - "episode over": the episode has ended.

        An act for a step that was answered before takes no step. If it names the actions that are recorded from that
        step on, it returns the present observation, so that a call can be repeated when its result was lost.

        Args:
            step: step of the observation that the act answers, `Observation.step`.
            actions: an action, 0 to 3, or a sequence of 1 to 1000 of them.
            note: a note to store beside the first step: text or a mapping of at most 2,048 bytes, see `Answer`.

        Returns:
            The observation that awaits an action; None if the episode has ended.

        Raises:
            StepSpentError: if the step was answered before with another action; it names the present step.
            StepAheadError: if the step is ahead of the present one.
            UsageError: if an action or the note is not valid; no step is taken.
            EpisodeLostError, ArramonClientError: as for `look`.
        """
        return wait_for(self._live.act(step, actions, note))

    def give_up(self, reason: str = "") -> None:
        """Give up the episode, which is then scored as far as it was played.

        Args:
            reason: for the host's log; at most 500 characters are kept.
        """
        wait_for(self._live.give_up(reason))

    def scores(self) -> dict[str, dict[str, float]] | None:
        """Return the episode's scores by row ("turn 1", "turn 2", and their mean "total") and metric.

        Returns:
            The scores; None on a hidden split, which does not disclose those of single episodes.

        Raises:
            UsageError: if the run is not over.
        """
        return scores_of(self._opened.report(), self.episode_id)
