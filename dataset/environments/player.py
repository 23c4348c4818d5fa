"""In-process play of episodes by the same rules as every run: session, scene and camera behind one interface.

The counterpart of `Delivery` and `PlayHandler` for a direct caller, without journal, clocks and messages.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from arramon.v1.chain import episode_head
from arramon_client.agent import Label, Observation
from arramon_client.environments.backend import EpisodeEnd, Images, PlayerSettings, Scores, SplitInfo, Step
from arramon_client.errors import UsageError
from arramon_client.world import IMAGE_SENSORS, NAVIGATION, Action
from arramon_dataset.environments.playable_split import PlayableSplit
from arramon_dataset.environments.rewards import NoReward, Reward, make_reward
from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.scoring.episode_scores import EpisodeScores
from arramon_server.sim.cameras import Frame
from arramon_server.sim.labels import LABELS
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.rules import Limits, Phase, PhaseEnded, State
from arramon_server.sim.section_world import EpisodeWorld
from arramon_server.sim.view import visible_pose

if TYPE_CHECKING:
    from arramon_dataset.environments.experts import Expert

UNLIMITED = Limits(steps_per_phase=1_000_000)
"""Step limit of phases that the ground truth plays."""

FindEpisode = Callable[[str | None, int], Episode]
"""Returns the episode with an id, or a generated one for a seed. Raises UsageError if there is none."""

LABEL_TABLE = tuple(Label(label.kind, label.colour, label.look) for label in LABELS)


class _OpenEpisode(NamedTuple):
    """An episode in play, and its world."""

    session: EpisodeSession
    world: EpisodeWorld


class LocalPlayer:
    """Plays one episode at a time in this process (`arramon_client.environments.backend.Player`).

    Args:
        playable: the split and its worlds.
        info: the split as environments see it.
        settings: of the environment.
        find: returns episodes.
    """

    def __init__(self, playable: PlayableSplit, info: SplitInfo, settings: PlayerSettings, find: FindEpisode) -> None:
        self._worlds, self._name = playable.worlds, playable.split.name
        self._sections = playable.split.sections
        self._info, self._settings, self._find = info, settings, find
        self._limits = Limits(info.steps_per_phase)
        self._images = tuple(name for name in IMAGE_SENSORS if name in settings.sensors)
        self._draws_streets = bool(self._images) and NAVIGATION in settings.phases
        self._open: _OpenEpisode | None = None
        self._seen: State  # The latest state that accepts an action.
        self._canvas = new_canvas(settings.image_size)
        """Buffers for images that the camera always renders but the settings leave out, and for raw labels."""
        self._reward: Reward = NoReward()
        self._expert: Expert | None = None

    @property
    def split(self) -> SplitInfo:
        """The split, as environments see it."""
        return self._info

    @property
    def labels(self) -> tuple[Label, ...]:
        """Meaning of each value of a segmentation; empty without that sensor."""
        return LABEL_TABLE if "segmentation" in self._settings.sensors else ()

    @property
    def episode_id(self) -> str:
        """Id of the current episode."""
        return self._played.episode.episode_id

    @property
    def place(self) -> str:
        """Id of the section where the agent is, or "" for the room."""
        return "" if self._seen.phase is Phase.ASSEMBLY else self._played.episode.section

    @property
    def session(self) -> EpisodeSession:
        """The session of the current episode: state, trajectory and scores.

        Raises:
            UsageError: if no episode has begun, or the split is hidden.
        """
        if self._info.hidden:
            raise UsageError(f"the split {self._info.name!r} is hidden: the state of its episodes is not available")
        return self._played

    def begin(
        self, episode_id: str | None, seed: int, into: Images | None = None, *, with_images: bool = True
    ) -> Observation:
        """Begin an episode. The ground truth plays the phases before the agent's first one.

        Args:
            episode_id: id of the episode; None to generate one.
            seed: of the generated episode.
            into: arrays to write the images to.
            with_images: whether to render the images now; otherwise `draw` renders them later.

        Raises:
            UsageError: if there is no such episode.
        """
        episode = self._find(episode_id, seed)
        if self._settings.language not in episode.instructions:
            raise UsageError(f"the episode {episode_id!r} has no instructions in {self._settings.language!r}")
        for _ in self._worlds.load(self._name, episode, drawn=self._draws_streets):
            pass
        world = self._worlds.world(self._name, episode)
        session = EpisodeSession(episode, world, self._limits)
        self._open = _OpenEpisode(session, world)
        self._reward = make_reward(self._settings.reward, episode)
        self._expert = None
        if self._settings.expert is not None:
            # Imported only here: it takes a tenth of a second, and few learners use an expert.
            from arramon_dataset.environments.experts import make_expert

            self._expert = make_expert(self._settings.expert, episode, world.scene, world)
        self._skip(session, (self._settings.turn, self._settings.start))
        self._seen = session.state
        return self.latest(into) if with_images else self.latest_without_images()

    def step(self, action: int) -> Step:
        """Apply an action from 0 to 3, and return its result, with an observation.

        Raises:
            ValueError: if the episode is finished, or the action is out of range.
        """
        step = self.advance(action)
        if step.ending is not None:
            return step
        return Step(self.latest(), step.steps_left, step.reward, step.phases_ended)

    def advance(self, action: int) -> Step:
        """Apply an action from 0 to 3, and return its result, without an observation.

        Raises:
            ValueError: if the episode is finished, or the action is out of range.
        """
        session, before = self._played, self._played.state
        ended = session.apply(Action(action))
        reward = self._reward.after_action(before, session, ended)
        over: tuple[tuple[int, str], ...] = ()
        if ended:
            over = tuple((end.turn, end.phase.value) for end in ended)
            self._skip(session)
        if session.state.finished:
            scores = None if self._info.hidden else scores_by_turn(session.scores())
            return Step(None, 0, reward, over, EpisodeEnd(session.cause, scores))
        self._seen = session.state
        return Step(None, session.steps_left(self._seen), reward, over)

    def latest(self, into: Images | None = None) -> Observation:
        """Return the latest observation again, also after the end of the episode.

        Args:
            into: arrays to write the images to.

        Raises:
            UsageError: if no episode has begun.
        """
        images = self._drawn(self._opened.world, into or {}) if self._images else {}
        return self._observation(self._played, self._seen, images)

    def latest_without_images(self) -> Observation:
        """Return the latest observation without its images.

        Raises:
            UsageError: if no episode has begun.
        """
        return self._observation(self._played, self._seen, {})

    def draw(self, into: Images) -> None:
        """Write the images of the latest observation to arrays.

        Raises:
            UsageError: if no episode has begun.
        """
        world = self._opened.world
        if into:
            self._drawn(world, into)

    def expert_action(self) -> int:
        """Return the expert's action in the current state.

        Raises:
            UsageError: if the settings name no expert.
        """
        if self._expert is None:
            raise UsageError("there is no expert: the settings name none")
        return int(self._expert.action(self._played))

    def map(self, size: int) -> npt.NDArray[np.uint8] | None:
        """Return a top-down map of the current phase, (size, size, 3) uint8; without targets on a hidden split."""
        # Imported only here, as few learners draw maps.
        from arramon_dataset.environments.maps import phase_map

        session = self._played
        section = furnished(self._sections[session.episode.section], session.episode.furniture)
        return phase_map(session, section, size, shows_targets=not self._info.hidden)

    def chain_head(self, run_id: str) -> bytes:
        """Return the head of the hash chain over the current episode's actions, 32 bytes."""
        session = self._played
        return episode_head(run_id, session.episode.episode_id, self._info.data_hash, session.actions)

    def close(self) -> None:
        """Discard the episode. The worlds stay cached."""
        self._open = None

    @property
    def _played(self) -> EpisodeSession:
        return self._opened.session

    @property
    def _opened(self) -> _OpenEpisode:
        if self._open is None:
            raise UsageError("no episode has begun")
        return self._open

    def _skip(self, session: EpisodeSession, until: tuple[int, str] = (1, NAVIGATION)) -> None:
        """Play the ground truth up to a phase, then to the agent's next phase or the end of the episode."""
        while not session.state.finished:
            state = session.state
            here = state.turn, state.phase.value
            if _order(*here) >= _order(*until) and state.phase.value in self._settings.phases:
                return
            turn = session.episode.turns[state.turn - 1]
            session.limits = UNLIMITED
            ended: list[PhaseEnded] = []
            for action in turn.actions if state.phase is Phase.NAVIGATION else turn.room_actions:
                ended = session.apply(action)
            session.limits = self._limits
            if not ended:
                raise UsageError(
                    f"the ground truth of episode {session.episode.episode_id!r} does not end the {state.phase.value} "
                    f"phase of turn {state.turn} from where the agent is; play that phase too"
                )

    def _drawn(self, world: EpisodeWorld, into: Images) -> Images:
        """Return the images of the latest state, in new arrays or in those of `into`."""
        canvas = self._canvas
        images = {name: into[name] if name in into else np.empty_like(canvas[name]) for name in self._images}
        # The camera always renders colours and depth; its labels are the section's own.
        labels = canvas["segmentation"] if "segmentation" in images else None
        frame = world.render(
            self._seen,
            self._settings.image_size,
            segmentation=labels is not None,
            into=Frame(images.get("rgb", canvas["rgb"]), images.get("depth", canvas["depth"]), labels),
        )
        if frame.segmentation is not None:
            images["segmentation"][...] = frame.segmentation
        return images

    def _observation(self, session: EpisodeSession, state: State, images: Images) -> Observation:
        """Return the observation of a state with its images."""
        sensors, language = self._settings.sensors, self._settings.language
        pose = visible_pose(state) if "pose" in sensors else None
        return Observation(
            episode_id=session.episode.episode_id,
            turn=state.turn,
            phase=state.phase.value,
            step=state.step,
            instruction=session.episode.instruction(language, state.turn, state.phase.value),
            phase_step=state.phase_step,
            steps_left=session.steps_left(state),
            rgb=images.get("rgb"),
            depth=images.get("depth"),
            pose=None if pose is None else (pose.x, pose.z, pose.heading),
            segmentation=images.get("segmentation"),
        )


def scores_by_turn(scores: EpisodeScores) -> Scores:
    """Return the scores of an episode by turn, and the means of both turns as "total"."""
    first, second = (dict(turn) for turn in scores.turns)
    return {"turn 1": first, "turn 2": second, "total": {name: (first[name] + second[name]) / 2 for name in first}}


def _order(turn: int, phase: str) -> tuple[int, bool]:
    return turn, phase != NAVIGATION


def new_canvas(size: int) -> dict[str, npt.NDArray[Any]]:
    """Return empty image buffers: (size, size, 3) uint8 RGB, (size, size) float32 depth and uint16 segmentation."""
    return {
        "rgb": np.empty((size, size, 3), np.uint8),
        "depth": np.empty((size, size), np.float32),
        "segmentation": np.empty((size, size), np.uint16),
    }
