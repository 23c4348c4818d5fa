"""Assembly rooms as the visual encoder sees them, with the target cell: training data, rendered once and cached."""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from arramon_agents.mapping.probabilistic_room_memory import ProbabilisticRoomMemory
from arramon_agents.mapping.room_path import RoomPose
from arramon_agents.perception.eyes.encoder import Eyes
from arramon_agents.perception.eyes.encoder import load as load_eyes
from arramon_agents.perception.eyes.predicted_segmentation import LABELS
from arramon_agents.training.demonstrations import DemonstrationSource, backend_of, episodes_of, settings_of
from arramon_agents.vl_grounded.look_around import LookAround
from arramon_client.agent import Action, Observation
from arramon_client.environments.backend import Player
from arramon_client.world import ASSEMBLY, COLUMNS, ROWS, TURN_DEGREES
from arramon_lang.cell_grading import START, Cell, RoomObject

VERSION = 1

PART = 64
"""Number of episodes in one cache file."""


@dataclass(frozen=True)
class RoomView:
    """One assembly phase: the objects seen in a look around from the start tile, and the target cell.

    Attributes:
        episode_id, turn: episode and turn of the phase.
        texts: instruction by language.
        things: objects as named by the visual encoder.
        target: (column, row) of the target cell.
    """

    episode_id: str
    turn: int
    texts: dict[str, str]
    things: tuple[RoomObject, ...]
    target: Cell


def collect_views(source: DemonstrationSource, cache: Path) -> Iterator[list[RoomView]]:
    """Yield the views of a source's rooms, PART episodes at a time, rendering those that are not cached.

    Args:
        source: the episodes; its visual encoder is "eyes".
        cache: cache folder.

    Raises:
        UsageError: if the data folder does not have the split or a language.
    """
    eyes = load_eyes()
    ids, data_hash = episodes_of(source)
    key = f"{data_hash}/{'+'.join(source.languages)}/{eyes.fingerprint}/{VERSION}"
    key += f"/{source.every}" if source.every > 1 else ""  # Files are named by the first of some episodes.
    folder = cache / f"views-{source.split}-{hashlib.sha256(key.encode()).hexdigest()[:12]}"
    folder.mkdir(parents=True, exist_ok=True)
    players: dict[str, Player] = {}
    for first in range(0, len(ids), PART):
        some = ids[first : first + PART]
        path = folder / f"{some[0]}-{len(some)}.json"
        if not path.exists():
            if not players:
                players = {
                    language: backend_of(source).player(
                        settings_of(source, language, 0 if number else eyes.image_size, (ASSEMBLY,))
                    )
                    for number, language in enumerate(source.languages)
                }
            views = [view for episode_id in some for view in _draw(players, eyes, episode_id)]
            _write(path, views)
        yield _read(path)


def _draw(players: dict[str, Player], eyes: Eyes, episode_id: str) -> list[RoomView]:
    """Return the views of an episode's rooms, with texts in all languages that have the same target cells."""
    first, *others = players
    views = _seen(players[first], eyes, episode_id, first)
    for language in others:
        known = players[language].split.episode_ids
        if known is not None and episode_id not in known:
            continue
        same = _seen(players[language], None, episode_id, language)
        if [view.target for view in same] == [view.target for view in views]:
            for view, other in zip(views, same, strict=True):
                view.texts.update(other.texts)
    return views


def _seen(player: Player, eyes: Eyes | None, episode_id: str, language: str) -> list[RoomView]:
    """Return the views of an episode's rooms in one language; without a visual encoder, texts and targets only."""
    views: list[RoomView] = []
    observation: Observation | None = player.begin(episode_id, 0)
    while observation is not None:
        seen = ProbabilisticRoomMemory(LABELS)
        turn, text, look = observation.turn, observation.instruction, LookAround(seen)
        while eyes is not None and observation is not None:
            if look.is_new():
                assert observation.rgb is not None
                assert observation.depth is not None
                things = eyes.things(observation.rgb[None], observation.depth[None])[0]
                seen.add_things(things, START, look.heading)
            action = look.turn()
            if action is None:
                break
            observation = player.step(action).observation
        observation, target = _place(player, observation, look.heading)
        views.append(RoomView(episode_id, turn, {language: text}, look.things(), target))
    return views


def _place(player: Player, observation: Observation | None, heading: int) -> tuple[Observation | None, Cell]:
    """Let the expert place the object; return the next observation, and the cell."""
    (column, row), number = START, observation.turn if observation is not None else 0
    while observation is not None and observation.turn == number:
        action = player.expert_action()
        observation = player.step(action).observation
        if action == Action.INTERACT:
            break
        if action == Action.FORWARD:
            column, row = _ahead(column, row, heading)
        else:
            heading += TURN_DEGREES if action == Action.RIGHT else -TURN_DEGREES
    column, row = _ahead(column, row, heading)
    assert 0 <= column < COLUMNS
    assert 0 <= row < ROWS
    return observation, (column, row)


def _ahead(column: int, row: int, heading: int) -> Cell:
    return RoomPose(column, row, heading // 90 % 4).ahead


def _write(path: Path, views: list[RoomView]) -> None:
    """Write views to a file, atomically."""
    part = path.with_suffix(".part")
    part.write_text(json.dumps([asdict(view) for view in views], ensure_ascii=False), encoding="utf-8")
    part.replace(path)


def _read(path: Path) -> list[RoomView]:
    found = json.loads(path.read_text(encoding="utf-8"))
    return [
        RoomView(
            each["episode_id"],
            each["turn"],
            each["texts"],
            tuple(RoomObject(**thing) for thing in each["things"]),
            (each["target"][0], each["target"][1]),
        )
        for each in found
    ]
