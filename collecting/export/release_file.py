"""Episodes in the official release's form: a JSON list with one object for each, which `import-release` reads."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from arramon_client.world import CELL_SIZE, EYE_HEIGHT, Action
from arramon_dataset.release.files import read_release
from arramon_server.episodes.episode import Episode, Turn
from arramon_server.errors import BadInput
from arramon_server.sim.room import START

_LETTERS = {Action.FORWARD: "f", Action.LEFT: "l", Action.RIGHT: "r", Action.INTERACT: "P"}
"""The release's letters of actions; each list ends with the number of the turn, from 0."""


def write_release(path: Path, episodes: Sequence[Episode], language: str, collection: str) -> None:
    """Write a file in the release's form, and read it back.

    The form has neither distracters nor decoys nor the city, which an import adds.

    Args:
        path: path of the file; an existing one is replaced.
        episodes: with texts in the language; their ids are numbers.
        language: code of the language.
        collection: name of the collection.

    Raises:
        BadInput: if an id is no number, which the form needs.
        BadFile: if what was written cannot be read back.
        OSError: if the file cannot be written.
    """
    records = [_record(episode, language, collection) for episode in episodes]
    new = path.with_name(f".{path.name}.new")
    new.write_text(json.dumps(records, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    _, read = read_release(new, language)
    assert [one.instructions[language] for one in read] == [one.instructions[language] for one in episodes]
    new.replace(path)


def is_numbered(episodes: Sequence[Episode]) -> bool:
    """Return whether all ids are numbers, which the release's form needs."""
    return all(one.episode_id.isascii() and one.episode_id.isdecimal() for one in episodes)


def _record(episode: Episode, language: str, collection: str) -> dict[str, Any]:
    if not is_numbered([episode]):
        raise BadInput(f"the episode's id is {episode.episode_id!r}, expected a number, as the release has")
    turns, texts = episode.turns, episode.instructions[language]
    return {
        "code": collection,
        "mapId": int(episode.episode_id),
        "filename": f"{collection}_{episode.episode_id}.json",
        "instructions": {
            "navi_inst_gt": [turn.navigation for turn in texts],
            "assem_inst_gt": [turn.assembly for turn in texts],
        },
        "gt_paths": {
            "navi_path_gt": [[[x, EYE_HEIGHT, z] for x, z in turn.path] for turn in turns],
            "assem_path_gt": [_room_path(turn) for turn in turns],
        },
        "gt_actions": {
            "navi_action_gt": [_letters(turn.actions, number) for number, turn in enumerate(turns)],
            "assem_action_gt": [_letters(turn.room_actions, number) for number, turn in enumerate(turns)],
        },
        "gt_actionIDs": {
            "navi_actionIDs_gt": [list(map(int, turn.actions)) for turn in turns],
            "assem_actionIDs_gt": [list(map(int, turn.room_actions)) for turn in turns],
        },
        "gt_objects": [str(turn.target.type).title() for turn in turns],
        "gt_objects_pos": {
            "navi_obj_pos_gt": [list(_point(turn)) for turn in turns],
            "assem_obj_pos_gt": [_cell(turn) for turn in turns],
        },
    }


def _room_path(turn: Turn) -> list[list[float]]:
    """Return the places (x, y, z) in the room, from the start tile, in units."""
    return [
        [CELL_SIZE * (cell.column - START.column), EYE_HEIGHT, CELL_SIZE * (cell.row - START.row)]
        for cell in turn.room_path
    ]


def _letters(actions: Sequence[Action], turn: int) -> list[str]:
    return [*(_LETTERS[action] for action in actions), str(turn)]


def _point(turn: Turn) -> tuple[float, float, float]:
    place = turn.target.position
    return place.x, place.y, place.z


def _cell(turn: Turn) -> list[int]:
    cell = turn.target_cell
    return [cell.column, cell.level, cell.row]
