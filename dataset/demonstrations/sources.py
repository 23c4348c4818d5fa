"""Selection of the episodes to export, with their actions from the ground truth or a recorded run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from arramon_client.world import STEPS_PER_PHASE
from arramon_dataset.demonstrations.request import ExportRequest
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, Conflict
from arramon_server.runs.results.reports import split_as_played
from arramon_server.runs.storage.causes import AGENT_FINISHED
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING, EpisodeEnding, Run


@dataclass(frozen=True, slots=True)
class EpisodeActions:
    """The exported actions of one episode.

    Attributes:
        episode_id: the episode.
        languages: of the exported instructions.
        actions: in order, at least one.
        cause: why the episode ended; AGENT_FINISHED for the ground truth.
    """

    episode_id: str
    languages: tuple[str, ...]
    actions: tuple[int, ...]
    cause: str = AGENT_FINISHED


@dataclass(frozen=True, slots=True)
class EpisodeSelection:
    """The episodes to export, and those left out.

    Attributes:
        chosen: episodes with their actions, in the split's playing order.
        left_out: reason for each episode that cannot be exported, by id.
        steps_per_phase: the step limit of a phase.
    """

    chosen: tuple[EpisodeActions, ...]
    left_out: Mapping[str, str]
    steps_per_phase: int


def ground_truth(split: Split, request: ExportRequest) -> EpisodeSelection:
    """Select ground-truth episodes of a split. Those with a phase longer than a run's step limit are left out."""
    chosen, left_out = [], {}
    for episode in _first(split.in_playing_order(*request.languages), request):
        phases = [phase for turn in episode.turns for phase in (turn.actions, turn.room_actions)]
        if max(map(len, phases)) > STEPS_PER_PHASE:
            left_out[episode.episode_id] = f"its ground truth has a phase of more than {STEPS_PER_PHASE} steps"
            continue
        actions = tuple(int(action) for phase in phases for action in phase)
        chosen.append(EpisodeActions(episode.episode_id, _languages(episode, request), actions))
    return EpisodeSelection(tuple(chosen), left_out, STEPS_PER_PHASE)


def recorded_run(journal: Journal, run: Run, split: Split, request: ExportRequest) -> EpisodeSelection:
    """Select the episodes of a finished run, with the agent's actions.

    Raises:
        Conflict: if the run is still being played, or the split's data has changed since then.
        BadInput: if the run was played in another language.
    """
    split_as_played(run, {split.name: split})
    if run.state == RUNNING:
        raise Conflict(f"run {run.run_id!r} is still being played; export it when it is over")
    if request.languages != (run.language,):
        raise BadInput(
            f"run {run.run_id!r} was played in {run.language!r}, not in {', '.join(request.languages)}: "
            f"expected that language, or none"
        )
    endings = {ending.episode_id: ending for ending in journal.endings(run.run_id)}
    chosen, left_out = [], {}
    for episode in _first([one for one in split.in_playing_order(run.language) if one.episode_id in endings], request):
        ending = endings[episode.episode_id]
        actions = _recorded(journal, ending)
        if actions:
            chosen.append(EpisodeActions(episode.episode_id, (run.language,), tuple(actions), ending.cause))
        else:
            left_out[episode.episode_id] = f"nothing was played: it ended by {ending.cause}"
    return EpisodeSelection(tuple(chosen), left_out, run.steps_per_phase)


def _recorded(journal: Journal, ending: EpisodeEnding) -> Sequence[int]:
    return journal.actions(ending.run_id, ending.episode_id)[: ending.steps] if ending.has_played else ()


def _first(episodes: Sequence[Episode], request: ExportRequest) -> Sequence[Episode]:
    return episodes if request.episodes is None else episodes[: request.episodes]


def _languages(episode: Episode, request: ExportRequest) -> tuple[str, ...]:
    return tuple(language for language in request.languages if language in episode.instructions)
