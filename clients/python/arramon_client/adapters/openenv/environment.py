"""The environment: an episode of a run for each `reset`, taken up again after a lost connection."""

from importlib.metadata import version
from typing import Any

from arramon_client.adapters.extras import extra
from arramon_client.adapters.host import Host
from arramon_client.adapters.model_view import actions_of, picture_url
from arramon_client.adapters.openenv.messages import ArramonAction, ArramonObservation, ArramonState
from arramon_client.adapters.results import episode_result, headline, run_result, unfinished_result
from arramon_client.agent import Observation
from arramon_client.errors import UsageError
from arramon_client.runs.run import Run, RunEpisode

with extra("openenv"):
    from openenv.core.env_server.interfaces import Environment
    from openenv.core.env_server.types import EnvironmentMetadata


class ArramonEnvironment(Environment[ArramonAction, ArramonObservation, ArramonState]):
    """An environment that plays on a server; each session has one of its own.

    Closing a session leaves its run open, so that another session can go on with `reset(resume=run_id)`.

    Args:
        host: the server, with the language and split that `reset` plays by default.
    """

    SUPPORTS_CONCURRENT_SESSIONS = True

    def __init__(self, host: Host) -> None:
        super().__init__()
        self._host = host
        self._chosen: Host | None = None  # Set if `reset` has chosen a language or split of its own.
        self._run: Run | None = None
        self._episode: RunEpisode | None = None
        self._result: dict[str, Any] | None = None
        self._number = 0

    def reset(
        self,
        seed: int | None = None,
        episode_id: str | None = None,
        lang: str | None = None,
        split: str | None = None,
        resume: str | None = None,
        **_: Any,
    ) -> ArramonObservation:
        """Begin an episode; one that has not ended is given up.

        Args:
            seed: draws the episode; without seed and `episode_id` they come in the split's order.
            episode_id: id of the episode.
            lang: language of the instructions; None for the default.
            split: name of the split; None for the default. A hidden one is played whole, in one run, in its order.
            resume: id of a run whose episode goes on where it is, instead of a new one.

        Raises:
            UsageError: if there is no such episode, language or split.
            ArramonClientError: if the server refuses, or does not answer.
        """
        if resume is not None:
            return self._resume(resume)
        if (lang or self._host.language, split or self._host.split) != (self._host.language, self._host.split):
            self.close()
            self._host = self._chosen = self._host.with_choice(lang or self._host.language, split or self._host.split)
        host = self._host
        if host.is_hidden and (seed is not None or episode_id is not None):
            raise UsageError(
                f"the hidden split {host.split!r} is played in its own order: expected no seed or episode_id"
            )
        if self._episode is not None and not self._episode.ended:
            self._episode.give_up("the environment was reset before the episode's end")
        if not host.is_hidden or self._run is None or self._run.info.is_over:
            self._leave_run()
            chosen = None if host.is_hidden else episode_id or self._choose(seed)
            self._run = Run.create(
                language=host.language, agent=host.agent, **host.run_options(chosen) | {"parallel": 1}
            )
        self._episode, self._result = next(self._run.episodes()), None
        return self._observation(self._episode.look())

    def step(
        self,
        action: ArramonAction,
        timeout_s: float | None = None,  # noqa: ARG002 - OpenEnv's interface
        **_: Any,
    ) -> ArramonObservation:
        """Take the action's steps; a repeated call takes none, and returns what follows.

        Raises:
            UsageError: if no episode has begun, or an action is unknown.
            StepSpentError, StepAheadError: if the step is not the present one.
            ArramonClientError: if the server refuses, or does not answer.
        """
        if self._episode is None:
            if self._result is not None:
                return self._end()
            raise UsageError("no episode has begun: call reset first")
        return self._observation(self._episode.act(action.step, actions_of(action.actions)))

    @property
    def state(self) -> ArramonState:
        """The state, without the ground truth."""
        episode, result = self._episode, self._result
        known: dict[str, Any] = {"language": self._host.language, "split": self._host.split}
        if self._run is not None:
            info = self._run.info
            known = {"language": info.language, "split": info.split, "run_id": info.run_id}
        if episode is not None:
            known |= {"episode_id": episode.episode_id, "step_count": len(episode.actions), "done": episode.ended}
        elif result is not None:
            known |= {"episode_id": result["episode_id"], "done": True}
        return ArramonState(**known)

    def get_metadata(self) -> EnvironmentMetadata:
        """Return name and description."""
        return EnvironmentMetadata(
            name="arramon",
            description="Follow instructions through streets, and place what was collected in a room",
            version=version("arramon-client"),
        )

    def close(self) -> None:
        """Close the session's connections; the run stays open."""
        self._leave_run()
        if self._chosen is not None:
            self._chosen.close()

    def _choose(self, seed: int | None) -> str:
        ids = list(self._host.episodes())
        if seed is None:
            seed, self._number = self._number, self._number + 1
        return ids[seed % len(ids)]

    def _resume(self, run_id: str) -> ArramonObservation:
        self._leave_run()
        self._run = run = Run.resume(run_id, history=True, **self._host.server_options())
        episode = next(run.episodes(), None)
        if episode is None:  # The run has ended.
            self._result = run_result(run.report(), run.receipt())
            return self._end()
        while (seen := episode.look()).taken is not None:  # So that a repeated act is recognized.
            episode.act(seen.step, seen.taken)
        self._episode = episode
        return self._observation(seen)

    def _observation(self, seen: Observation | None) -> ArramonObservation:
        assert self._run is not None
        assert self._episode is not None
        run, episode = self._run, self._episode
        if seen is not None:
            return ArramonObservation(
                run_id=run.run_id,
                step=seen.step,
                turn=seen.turn,
                phase=seen.phase,
                steps_left=seen.steps_left,
                instruction=seen.instruction,
                stop_reason=episode.stop_reason,
                image=picture_url(seen),
            )
        if self._result is None:
            if run.info.ended < run.info.episodes:
                self._result = unfinished_result(run.info, episode.episode_id, episode.cause)
            else:
                run.wait()
                self._result = episode_result(
                    episode.episode_id, episode.cause, episode.scores(), run.report(), run.receipt()
                )
        return self._end()

    def _end(self) -> ArramonObservation:
        """Return the last observation; its reward is the mean of nDTW, CTC-3 and PTC@CTC-3, if they are disclosed."""
        assert self._result is not None
        scores = self._result["scores"]
        reward = None if scores is None else sum(headline(scores).values()) / len(headline(scores))
        return ArramonObservation(done=True, reward=reward, run_id=self._result["run_id"], result=self._result)

    def _leave_run(self) -> None:
        run, self._run, self._episode, self._result = self._run, None, None, None
        if run is not None:
            run.close()
