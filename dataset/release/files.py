"""Reader of the official release's files: a JSON list with one object per episode, in English or Hindi.

The release lacks distracters, decoys and the city, which `importer` adds: the episodes returned here have streets with
targets alone, and empty rooms.
"""

import math
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter
from typing_extensions import TypedDict

import arramon_lang as lang
from arramon_client.world import CELL_SIZE, TURN, Action
from arramon_server.episodes.episode import Episode, Instructions, Turn
from arramon_server.episodes.split_files import parse_json, read_bytes
from arramon_server.errors import BadFile
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point, Pose, wrap
from arramon_server.sim.room import START, RoomCell, RoomPosition
from arramon_server.sim.rules import Collectible, moved

SECTION_STARTS = (0, 15000, 25000, 35000, 45000, 55000, 65000)
"""First `mapId` of each of the seven sections."""

REPLAY_TOLERANCE = 0.01
"""Maximum distance between a replay of the actions and the file's path, in units. Official files: 0.0003."""

_Vector = tuple[float, float, float]


class _Instructions(TypedDict):
    navi_inst_gt: tuple[str, str]
    assem_inst_gt: tuple[str, str]


_Path = Annotated[list[_Vector], Field(min_length=1)]


class _Paths(TypedDict):
    navi_path_gt: tuple[_Path, _Path]
    assem_path_gt: tuple[_Path, _Path]


_ActionList = Annotated[list[Action], Field(min_length=1)]


class _ActionIDs(TypedDict):
    navi_actionIDs_gt: tuple[_ActionList, _ActionList]
    assem_actionIDs_gt: tuple[_ActionList, _ActionList]


class _ObjectPositions(TypedDict):
    navi_obj_pos_gt: tuple[_Vector, _Vector]
    assem_obj_pos_gt: tuple[RoomPosition, RoomPosition]


class _Record(TypedDict):
    """One object of the list; other keys (`code`, `filename`, `gt_actions`) are bookkeeping and ignored."""

    mapId: int
    instructions: _Instructions
    gt_paths: _Paths
    gt_actionIDs: _ActionIDs
    gt_objects: tuple[str, str]
    gt_objects_pos: _ObjectPositions


_RECORDS = TypeAdapter(list[_Record])


def read_release(path: Path, language: str | None = None) -> tuple[str, list[Episode]]:
    """Read and validate the episodes of a release file, without adding objects.

    Args:
        path: JSON file.
        language: code of the language; None to detect it from the texts.

    Returns:
        The language's code and the episodes, in the file's order.

    Raises:
        BadFile: if anything is missing or malformed, or the actions do not follow the paths; names the place in the
            file.
    """
    records = parse_json(_RECORDS, read_bytes(path), path)
    if not records:
        raise BadFile(path, "contains no episodes")
    language = language or _identify(records, path)
    episodes: dict[int, Episode] = {}
    for index, record in enumerate(records):
        if record["mapId"] in episodes:
            raise BadFile(path, f"mapId {record['mapId']} occurs twice", field=f"[{index}].mapId")
        try:
            episodes[record["mapId"]] = _episode(record, language)
        except ValueError as error:
            raise BadFile(path, str(error), field=f"[{index}] (mapId {record['mapId']})") from error
    return language, list(episodes.values())


def section_of(map_id: int) -> str:
    """Return the city section of a `mapId`, "1" to "7"."""
    return str(sum(map_id >= start for start in SECTION_STARTS))


def _identify(records: list[_Record], path: Path) -> str:
    text = " ".join(record["instructions"]["navi_inst_gt"][0] for record in records[:20])
    try:
        return lang.identify(text)
    except ValueError as error:
        raise BadFile(path, f"the instructions' language cannot be detected; set it with --lang ({error})") from error


def _episode(record: _Record, language: str) -> Episode:
    if record["mapId"] < 0:
        raise ValueError("mapId is negative")
    turns = (_turn(record, 0), _turn(record, 1))
    texts = record["instructions"]
    start = Pose(*turns[0].path[0], _start_heading(turns))
    _check_replay(start, turns)
    return Episode(
        episode_id=str(record["mapId"]),
        section=section_of(record["mapId"]),
        start=start,
        turns=turns,
        decoys=(),
        instructions={
            language: (
                Instructions(texts["navi_inst_gt"][0], texts["assem_inst_gt"][0]),
                Instructions(texts["navi_inst_gt"][1], texts["assem_inst_gt"][1]),
            )
        },
    )


def _turn(record: _Record, turn: int) -> Turn:
    path = tuple((x, z) for x, _, z in record["gt_paths"]["navi_path_gt"][turn])
    target = Collectible(
        ObjectType.parse(record["gt_objects"][turn]), Point(*record["gt_objects_pos"]["navi_obj_pos_gt"][turn])
    )
    return Turn(
        path=path,
        actions=tuple(record["gt_actionIDs"]["navi_actionIDs_gt"][turn]),
        room_path=tuple(_squares(record["gt_paths"]["assem_path_gt"][turn])),
        room_actions=tuple(record["gt_actionIDs"]["assem_actionIDs_gt"][turn]),
        street=(target,),
        target_cell=record["gt_objects_pos"]["assem_obj_pos_gt"][turn],
    )


def _squares(path: list[_Vector]) -> list[RoomCell]:
    """Return the room's cells on an assembly path, which always begins at the start tile."""
    x0, _, z0 = path[0]
    return [
        RoomCell(START.column + round((x - x0) / CELL_SIZE), START.row + round((z - z0) / CELL_SIZE))
        for x, _, z in path
    ]


def _start_heading(turns: tuple[Turn, Turn]) -> float:
    """Return the start heading, which the release omits: the one with which the actions follow the path."""
    turned = sin = cos = 0.0
    for turn in turns:
        if math.hypot(sin, cos) > 0.0:
            break  # Turn 1 determines it; turn 2 is needed only if the agent did not move in turn 1.
        steps = iter(zip(turn.path, turn.path[1:], strict=False))
        for action in turn.actions:
            if action is Action.LEFT:
                turned -= TURN
            elif action is Action.RIGHT:
                turned += TURN
            elif action is Action.FORWARD:
                (x0, z0), (x1, z1) = next(steps, ((0.0, 0.0), (0.0, 0.0)))
                angle = math.atan2(x1 - x0, z1 - z0) - math.radians(turned)
                sin, cos = sin + math.sin(angle), cos + math.cos(angle)
    if math.hypot(sin, cos) < 0.5:
        raise ValueError("the start heading cannot be recovered: no turn has a step forward that fits the path")
    return round(wrap(math.degrees(math.atan2(sin, cos))), 4)


def _check_replay(start: Pose, turns: tuple[Turn, Turn]) -> None:
    """Raise ValueError unless the actions follow the paths, from one turn into the next."""
    pose = start
    for number, turn in enumerate(turns):
        visited = [(pose.x, pose.z)]
        for action in turn.actions:
            pose = moved(pose, action)
            if action is Action.FORWARD:
                visited.append((pose.x, pose.z))
        if len(visited) != len(turn.path):
            raise ValueError(
                f"gt_paths.navi_path_gt[{number}] has {len(turn.path)} points, "
                f"but gt_actionIDs.navi_actionIDs_gt[{number}] visits {len(visited)}"
            )
        error = max(math.dist(there, given) for there, given in zip(visited, turn.path, strict=True))
        if error > REPLAY_TOLERANCE:
            raise ValueError(f"the actions deviate from gt_paths.navi_path_gt[{number}] by {error:.3f} units")
